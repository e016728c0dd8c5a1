//! Warns before rendering where single floats are too coarse for a shot.
//!
//! None of this is an error: the pictures show as much as floats can keep. But surfaces may look jagged, and
//! samples may be reused in a neighbouring cell, which the audit counts as differing.

use crate::animation::Track;
use crate::scene::camera::{Aim, Projection};
use crate::scene::{Mesh, Scene};
use crate::settings::Settings;

/// Relative error of a coordinate that is rounded to a single float.
const ROUNDING: f64 = 6e-8;

/// Share of a model's size by which rounding may move its vertices without a warning: a pixel of a large
/// picture.
const COARSE: f64 = 3e-4;

/// Angle in radians that a cell must span, so that rounding moves directions by a hundredth of it at most.
const NARROWEST_CELL: f64 = 5e-6;

/// Warning about a model whose file puts it far from its own origin.
pub(crate) fn coarse(mesh: &Mesh) -> Option<String> {
    let (low, high) = mesh.bounds();
    let (largest, size) = (low.abs().max(high.abs()).max_element(), (high - low).max_element());
    let step = largest * 2.0 * ROUNDING;
    (step > size * COARSE).then(|| {
        format!(
            "coordinates of up to {largest:.3e} are kept in steps of {step:.1e}, and the model's size is {size:.3}: its \
             surfaces may look jagged; export it near its origin, and put it in its place with `translate`"
        )
    })
}

/// Warnings about the camera and the extent of `scene` if it is rendered with `settings`.
pub fn of_camera(scene: &Scene, settings: &Settings) -> Vec<String> {
    let camera = &scene.camera;
    let is_orthographic = camera.projection() == Projection::Orthographic;
    let heights = camera.lens.height.iter().flat_map(Track::frames);
    let frames: Vec<f64> =
        camera.eye.frames().into_iter().chain(camera.fov.frames()).chain(heights).collect();
    // at distance 1; of an orthographic camera, world units
    let cell = |frame: f64| {
        let cells = f64::from(settings.height) * f64::from(settings.samples);
        2.0 * f64::from(camera.half_height(frame)) / cells
    };
    let fine = frames.iter().filter(|_| is_orthographic).find(|frame| {
        let largest = camera.eye.at(**frame).abs().max_element();
        // visible things are about where the camera is
        largest * ROUNDING > cell(**frame)
    });
    let fine = fine.map(|frame| {
        format!(
            "at frame {frame} a sample of the orthographic camera is so small that rounding of positions moves it by more than \
             its size: take a greater `height`, a smaller --size or fewer --samples, or move the shot to the origin"
        )
    });
    let frames: Vec<f64> = frames.into_iter().filter(|_| !is_orthographic).collect();
    let narrow = frames.iter().find(|frame| cell(**frame) < NARROWEST_CELL);
    let near = frames.iter().find(|frame| {
        let (Aim::Target { target, .. }, eye) = (&camera.aim, camera.eye.at(**frame)) else { return false };
        let distance = (target.at(**frame) - eye).length();
        eye.abs().max_element() * ROUNDING > distance * cell(**frame)
    });
    let narrow = narrow.map(|frame| {
        format!(
            "the field of view at frame {frame} is so narrow that a sample spans less than {NARROWEST_CELL:e} of its \
             distance, where rounding moves it by more than a hundredth of that: take a smaller --size or fewer \
             --samples, or bring the eye nearer"
        )
    });
    let near = near.map(|frame| {
        format!(
            "at frame {frame} the eye is so near to its target that rounding of positions moves samples by more than \
             their size: scale the shot up, or move it to the origin"
        )
    });
    let wide = scene.space.least_length().map(|least| {
        format!(
            "the shot reaches so far that it is scaled down: what is smaller than {least:.1e} loses its shadows; bring \
             what is far away nearer"
        )
    });
    narrow.into_iter().chain(near).chain(fine).chain(wide).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;
    use crate::scene::Shot;

    fn shot(obj: &str, eye: &str, fov: &str) -> Shot {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("m.obj"), obj).unwrap();
        let text = format!(
            "[[camera.key]]\nframe = 1\neye = {eye}\ntarget = [5, 2, 5]\nfov = {fov}\n[[model]]\nobj = \"m.obj\"\n\
             [ambient]\ncolor = [1, 1, 1]\n"
        );
        let path = folder.path().join("s.toml");
        std::fs::write(&path, text).unwrap();
        crate::scene::load(&path, true).unwrap()
    }

    const USUAL: &str = "v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n";

    #[test]
    fn usual_shots_are_within_the_limits() {
        for (eye, fov) in [("[0, 0, 9]", "40"), ("[5, 2, 5.01]", "60"), ("[0, 0, 9]", "1")] {
            let shot = shot(USUAL, eye, fov);
            assert!(shot.warnings.is_empty());
            assert_eq!(of_camera(&shot.scene, &shot.settings), [""; 0], "{eye} {fov}");
        }
    }

    #[test]
    fn what_is_too_narrow_or_too_near_is_told() {
        let told = |eye, fov| {
            let shot = shot(USUAL, eye, fov);
            of_camera(&shot.scene, &shot.settings).join("\n")
        };
        assert!(told("[0, 0, 9]", "0.05").contains("narrow"));
        assert!(told("[5, 2, 5.00006]", "40").contains("so near"));
        let wide = shot(&USUAL.replace("v 9 0 0", "v 4.5e12 0 0"), "[0, 0, 9]", "40");
        assert!(of_camera(&wide.scene, &wide.settings).join("\n").contains("smaller than 5.0e-1"));
    }

    #[test]
    fn an_orthographic_camera_that_sees_too_little_is_told() {
        let mut shot = shot(USUAL, "[0, 0, 9]", "0.05");
        for (height, is_told) in [(10.0, false), (1e-4, true)] {
            shot.scene.camera.lens.height = Some(Track::constant(height));
            let told = of_camera(&shot.scene, &shot.settings);
            assert_eq!((told.len(), told.join("\n").contains("`height`")), (usize::from(is_told), is_told));
        }
    }

    #[test]
    fn a_model_far_from_its_origin_is_told() {
        let far = "v 2700000 0 0\nv 2700009 0 0\nv 2700000 9 0\nf 1 2 3\n";
        let warnings = shot(far, "[2700000, 0, 9]", "40").warnings;
        assert!(warnings.len() == 1 && warnings[0].0.to_string().contains("2.700e6"), "{warnings:?}");
    }
}

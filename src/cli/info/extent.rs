//! Size and motion of what a shot shows.

use std::path::Path;

use glam::{DVec3, Vec3};

use super::{line, list};
use crate::cli::bare_model::{is_gltf, is_model, is_usd};
use crate::pose::Pose;
use crate::scene::turntable::text::number;
use crate::scene::{Geometry, Model, Scene, Shot, Triangles};

/// Maximum number of names that a line lists.
const MOST_LISTED: usize = 12;

/// Adds lines on the size of all models, and on the axis that points up; `path`: of the shot or the bare model.
pub fn tell(text: &mut String, shot: &Shot, path: &Path) {
    let frame = shot.frames.first();
    if let Some((low, high)) = bounds(&shot.scene, frame) {
        let size = high - low;
        let at = if shot.scene.models.iter().all(|model| model.track.is_constant()) {
            String::new()
        } else {
            format!(", at frame {frame}")
        };
        line(text, "bounds", format!("{} to {}, size {}{at}", point(low), point(high), point(size)));
    }
    line(text, "up", up(&shot.notes, path));
}

/// Axis of the file that points up: what is guessed of a bare OBJ or PLY file, as `notes` say, and otherwise what the format says.
fn up(notes: &[String], path: &Path) -> String {
    let guess = notes.iter().find_map(|note| note.strip_prefix("up is "));
    match guess {
        Some(guess) => guess.to_string(),
        None if is_gltf(path) => String::from("y, as in all glTF files"),
        None if is_usd(path) => String::from("y, to which what the stage says (upAxis) is turned"),
        None if is_model(path) => String::from("as --up says"),
        None => String::from("y, as in all shots"),
    }
}

fn point(point: DVec3) -> String {
    let [x, y, z] = point.to_array().map(|value| number(value, value.abs().max(f64::MIN_POSITIVE)));
    format!("[{x}, {y}, {z}]")
}

/// The box around all models that are visible at `frame`, in the space of the files; without planes, which have no end.
fn bounds(scene: &Scene, frame: i32) -> Option<(DVec3, DVec3)> {
    let pose = Pose::new(scene, frame);
    let is_plane = |model: &Model| model.mesh.as_curved().is_some_and(|curved| curved.is_endless());
    let nothing = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let shown =
        scene.models.iter().zip(&pose.models).filter(|(model, _)| !is_floor(model) && !is_plane(model));
    let (low, high) = shown.filter(|(_, place)| place.is_visible).fold(nothing, |all, (model, place)| {
        let with = |(low, high): (Vec3, Vec3), point| {
            let at = place.point(point);
            (low.min(at), high.max(at))
        };
        match &model.mesh.geometry {
            Geometry::Triangles(Triangles { positions, corners, .. }) => {
                let used = corners.as_flattened().iter();
                used.map(|corner| Vec3::from(positions.as_slice()[*corner as usize])).fold(all, with)
            }
            Geometry::Curved(curved) => {
                let boxes = (0..curved.count()).map(|primitive| curved.bounds(primitive));
                boxes.flat_map(|around| around.corners()).fold(all, with)
            }
        }
    });
    (low.x <= high.x).then(|| (scene.space.point_of_files(low), scene.space.point_of_files(high)))
}

/// Returns true for the floor that a shot states, or that a bare model stands on.
fn is_floor(model: &Model) -> bool {
    let is_fan = |all: &Triangles| all.normals.is_empty() && all.corners.len() == 48;
    model.name == "floor" && model.mesh.as_triangles().is_some_and(is_fan)
}

/// Adds a line on what moves and deforms.
pub fn tell_motion(text: &mut String, scene: &Scene) {
    let of = |count: usize, all: usize, what: &str| (count > 0).then(|| format!("{count} of {all} {what}"));
    let models = &scene.models;
    let moving =
        models.iter().filter(|model| !model.track.is_constant() && model.track.shapes.is_none()).count();
    let deforming = models.iter().filter(|model| model.mesh.deforms()).count();
    let lights = scene.lights.iter().filter(|light| !light.is_constant()).count();
    let camera = (!scene.camera.is_constant()).then(|| String::from("the camera moves"));
    let parts = [
        camera,
        of(moving, models.len(), "models move"),
        of(deforming, models.len(), "models deform"),
        of(lights, scene.lights.len(), "lights change"),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    let none = || String::from("nothing moves");
    line(text, "motion", if parts.is_empty() { none() } else { list(parts.into_iter()) });
}

/// Names of the groups of a model of several, as the end of its line.
pub fn groups(model: &Model) -> Option<String> {
    let groups = &model.mesh.groups;
    let used = groups.used();
    (used.len() > 1).then(|| {
        let names = used.iter().take(MOST_LISTED).map(|number| groups.names()[*number].clone());
        let more = used.len().saturating_sub(MOST_LISTED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        format!("{} groups ({}{more})", used.len(), list(names))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nobody_has_said_what_is_up_but_who_did() {
        let note = String::from("up is z, by what the model stands on");
        assert_eq!(up(&[note], Path::new("a.obj")), "z, by what the model stands on");
        assert_eq!(up(&[], Path::new("a.obj")), "as --up says");
        for file in ["a.usda", "a.usdz", "a.glb", "a.toml"] {
            let told = up(&[], Path::new(file));
            assert!(told.starts_with("y, ") && !told.contains("--up"), "{file}: {told}");
        }
    }
}

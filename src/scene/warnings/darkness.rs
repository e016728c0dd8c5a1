//! Warns of shots that nothing lights: their pictures are black, which is hardly ever wanted.

use std::path::Path;

use glam::Vec3;

use crate::scene::{Background, Light, Scene, SceneError, Warning};

/// Warning about the shot at `path` if nothing in it gives light.
pub fn warning(path: &Path, scene: &Scene) -> Option<Warning> {
    is_dark(scene).then(|| {
        let black = match is_black(&scene.background) {
            true => "the picture is black",
            false => "surfaces are black; the [background] is seen, but lights them only as an [environment]",
        };
        let message = format!(
            "nothing gives light, so {black}: write a [[light]], an [environment] (a sky, for instance) or an [ambient] \
             color, or give a material `ke`"
        );
        Warning(SceneError::new(path, message))
    })
}

/// Returns true if no surface of the scene can be anything but black. A different warning covers ambient
/// light that no material reflects.
fn is_dark(scene: &Scene) -> bool {
    let shows_background = scene.materials.iter().any(|material| material.has_secondary_rays());
    !scene.lights.iter().any(shines)
        && scene.environment.as_ref().is_none_or(|environment| environment.is_black())
        && scene.ambient == Vec3::ZERO
        && scene.materials.iter().all(|material| material.emission == Vec3::ZERO)
        && (is_black(&scene.background) || !shows_background)
        && !shines_by_itself(scene)
}

/// Returns true if a medium emits light.
fn shines_by_itself(scene: &Scene) -> bool {
    let of_materials = scene.materials.iter().filter_map(|material| material.medium.as_ref());
    of_materials.chain(&scene.fog).any(|medium| medium.emit != Vec3::ZERO)
}

/// Returns true if a light has power and a colour at any key.
pub fn shines(light: &Light) -> bool {
    light.power.values().any(|power| power > 0.0) && light.color.values().any(|color| color != Vec3::ZERO)
}

pub fn is_black(background: &Background) -> bool {
    [background.zenith, background.horizon, background.ground].iter().all(|color| *color == Vec3::ZERO)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

    /// Warnings about a triangle with the material `a` of `mtl`, and `text` in the shot file.
    fn told(text: &str, mtl: &str, strict: bool) -> Vec<String> {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write("m.mtl", mtl);
        write("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n");
        let camera = "[[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n";
        write("s.toml", &format!("{text}\n{camera}[[model]]\nobj = \"m.obj\"\n"));
        let shot = crate::scene::load(&folder.path().join("s.toml"), strict).unwrap();
        shot.warnings.iter().map(ToString::to_string).collect()
    }

    const WALL: &str = "newmtl a\nKd 0.5 0.5 0.5\n";
    const LIGHT: &str = "[[light]]\ntype = \"directional\"\ndirection = [0, 0, -1]\n";

    #[test]
    fn a_shot_that_nothing_lights_is_told_once_whether_strict_or_not() {
        for strict in [false, true] {
            let told = told("", WALL, strict);
            assert_eq!(told.len(), 1, "{told:?}");
            for part in
                ["s.toml: nothing gives light", "picture is black", "[[light]]", "[environment]", "`ke`"]
            {
                assert!(told[0].contains(part), "{told:?}");
            }
        }
        for text in [
            &format!("{LIGHT}power = 0\n"),
            &format!("{LIGHT}color = [0, 0, 0]\n"),
            "[ambient]\ncolor = [0, 0, 0]\n",
            "[environment]\npower = 0\nsky = {}\n",
        ] {
            assert_eq!(told(text, WALL, true).len(), 1, "{text}");
        }
    }

    #[test]
    fn a_background_is_seen_and_lights_nothing() {
        let sky = "[background]\ncolor = [0.2, 0.5, 1]\n";
        assert!(told(sky, WALL, true)[0].contains("surfaces are black; the [background] is seen"));
        assert_eq!(told(sky, "newmtl a\nKs 1 1 1\nillum 3\n", true), [""; 0], "a mirror shows it");
        assert_eq!(told(&format!("{sky}[environment]\n"), WALL, true), [""; 0]);
    }

    #[test]
    fn whatever_gives_light_is_enough() {
        for text in [LIGHT, "[environment.sky]\n", "[ambient]\ncolor = [0, 0, 0.1]\n"] {
            assert_eq!(told(text, WALL, true), [""; 0], "{text}");
        }
        let later = format!("{LIGHT}power = 0\n[[light.key]]\nframe = 9\npower = 1\n");
        assert_eq!(told(&later, WALL, true), [""; 0], "it is switched on in the course of the shot");
        assert_eq!(told("", "newmtl a\nKe 0 1 0\n", true), [""; 0]);
        assert_eq!(told("[[material]]\nname = \"a\"\nke = [1, 1, 1]\n", WALL, true), [""; 0]);
    }
}

//! Warns of shots in which no light can come by way of glass. If glass casts shadows, only paths bring light
//! through it, and only from lights that they can hit.

use glam::Vec3;

use super::darkness::{is_black, shines};
use crate::scene::{Light, Scene};
use crate::settings::{Caustics, Settings};

/// Warning about `scene` if it is rendered with `settings`.
pub fn warning(scene: &Scene, settings: &Settings) -> Option<String> {
    let has_glass = scene.materials.iter().any(|material| material.lets_through());
    if settings.caustics == Caustics::None || !has_glass {
        return None;
    }
    let why = why_none(scene, settings)?;
    Some(format!(
        "`caustics` is \"paths\", and nothing will reach surfaces through glass, which casts shadows: {why}"
    ))
}

fn why_none(scene: &Scene, settings: &Settings) -> Option<&'static str> {
    match settings {
        Settings { paths: 0, .. } => Some("there are no paths; write `paths` in [indirect], or give --paths"),
        Settings { bounces: 0, .. } => Some(
            "paths meet no surface; `bounces` in [indirect] must be 1 at least, and 2 for a pane or a ball",
        ),
        Settings { depth: 0, .. } => Some("rays end at glass; `depth` in [render] must be 1 at least"),
        _ if !can_be_met(scene) => Some(
            "no path meets a light of the type point, directional or spot; give lights a size (rectangle, disk or sphere; \
             `angle` for a directional one), or use an [environment], or a material with `ke`",
        ),
        _ => None,
    }
}

/// Returns true if there is light that paths can hit by themselves.
fn can_be_met(scene: &Scene) -> bool {
    let is_met = |light: &Light| light.kind.is_area() && shines(light);
    let sky_shines = match &scene.environment {
        Some(environment) => !environment.is_black(),
        None => !is_black(&scene.background),
    };
    sky_shines
        || scene.lights.iter().any(is_met)
        || scene.materials.iter().any(|material| material.emission != Vec3::ZERO)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

    use super::*;

    /// Warning about a triangle of glass with these lights, or of no glass.
    fn told(lights: &str, is_glass: bool, settings: &Settings) -> Option<String> {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n");
        write("m.mtl", if is_glass { "newmtl a\nillum 4\nNi 1.5\n" } else { "newmtl a\nKd 1 1 1\n" });
        let camera = "[[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n";
        write("s.toml", &format!("{lights}\n{camera}[[model]]\nobj = \"m.obj\"\n"));
        warning(&crate::scene::load(&folder.path().join("s.toml"), true).unwrap().scene, settings)
    }

    const SUN: &str = "[[light]]\ntype = \"directional\"\ndirection = [0, 0, -1]\n";

    fn paths() -> Settings {
        Settings { caustics: Caustics::Paths, paths: 16, ..Settings::default() }
    }

    #[test]
    fn light_that_nothing_finds_is_told() {
        let soft = format!("{SUN}angle = 0.5\n");
        for (lights, settings, word) in [
            (soft.as_str(), Settings { paths: 0, ..paths() }, "--paths"),
            (&soft, Settings { bounces: 0, ..paths() }, "`bounces`"),
            (&soft, Settings { depth: 0, ..paths() }, "`depth`"),
            (SUN, paths(), "`angle`"),
            (&format!("{soft}power = 0\n{SUN}"), paths(), "`angle`"),
        ] {
            let told = told(lights, true, &settings).unwrap_or_default();
            assert!(told.contains(word) && told.contains("`caustics`"), "{lights}: {told}");
        }
    }

    #[test]
    fn what_paths_can_meet_needs_no_word() {
        for lights in [
            &format!("{SUN}angle = 0.5\n"),
            &format!("{SUN}[environment.sky]\n"),
            &format!("{SUN}[background]\ncolor = [0.1, 0.1, 0.1]\n"),
            &format!("{SUN}[[material]]\nname = \"a\"\nke = [1, 1, 1]\n"),
        ] {
            assert_eq!(told(lights, true, &paths()), None, "{lights}");
        }
        assert_eq!(told(SUN, false, &paths()), None, "there is no glass");
        assert_eq!(told(SUN, true, &Settings { caustics: Caustics::None, ..paths() }), None);
    }
}

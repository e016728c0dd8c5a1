//! Volumes in shot files: what they mean, and what is said about mistakes in them.

use std::fs;
use std::path::Path;

use afterimage::scene::{self, SceneError, Shot};
use glam::DVec3;

const REST: &str = "[camera]\n[[camera.key]]\nframe = 1\neye = [0, 0, 9]\ntarget = [0, 0, 0]\n[ambient]\ncolor = [1, 1, 1]\n";

/// A shot of a volume whose table says this, beside its files and a material of this text.
fn load(volume: &str, material: &str) -> Result<Shot, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    for name in ["plain.vdb", "turned.vdb", "mask.vdb"] {
        let seed = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds/vdb").join(name);
        fs::copy(seed, folder.path().join(name)).unwrap();
    }
    for number in [7, 8, 10] {
        fs::copy(folder.path().join("plain.vdb"), folder.path().join(format!("smoke.{number:04}.vdb")))
            .unwrap();
    }
    let whole = fs::read(folder.path().join("plain.vdb")).unwrap();
    fs::write(folder.path().join("cut.vdb"), &whole[..20_000]).unwrap();
    let material = format!("[[material]]\nname = \"cloud\"\n{material}");
    let text = format!("{REST}[[model]]\nvdb = {{ {volume} }}\n{material}\n");
    fs::write(folder.path().join("shot.toml"), text).unwrap();
    scene::load(&folder.path().join("shot.toml"), false)
}

const MATERIAL: &str = "surface = false\nvolume_scatter = [1, 1, 1]\n";

#[test]
fn a_volume_is_a_box_around_what_is_in_it() {
    let shot = load("file = \"plain.vdb\", material = \"cloud\"", MATERIAL).unwrap();
    let model = &shot.scene.models[0];
    let volume = model.mesh.details.volume.as_ref().expect("it has one");
    assert_eq!(
        (model.name.as_str(), volume.grids.len(), volume.grids[0].name.as_str()),
        ("plain", 1, "density")
    );
    assert_eq!(shot.warnings.len(), 0, "{:?}", shot.warnings);
    let shot = load("file = \"turned.vdb\", grids = [\"color\"], material = \"cloud\"", MATERIAL).unwrap();
    let volume = shot.scene.models[0].mesh.details.volume.as_ref().expect("it has one");
    assert_eq!(volume.grids[0].name, "color");
    assert_eq!(volume.grids[0].value(glam::IVec3::new(-5, -3, 0)).z, 0.0);
    let (low, high) =
        load("file = \"plain.vdb\", material = \"cloud\"", MATERIAL).unwrap().scene.models[0].mesh.bounds();
    assert!((high - low - DVec3::new(19.0, 10.0, 8.5)).abs().max_element() < 1e-4, "{low} {high}");
}

#[test]
fn numbered_files_are_there_in_their_frames() {
    for (first, frames) in [("", [7.0, 8.0, 10.0]), (", first = 1", [1.0, 2.0, 4.0])] {
        let shot =
            load(&format!("file = \"smoke.####.vdb\", material = \"cloud\"{first}"), MATERIAL).unwrap();
        let there = |frame: f64| -> Vec<&str> {
            let models = shot.scene.models.iter().filter(|model| model.track.visible.at(frame));
            models.map(|model| model.name.as_str()).collect()
        };
        for (frame, name) in frames.into_iter().zip(["smoke.0007", "smoke.0008", "smoke.0010"]) {
            assert_eq!(there(frame), [name]);
            assert_eq!(there(frame + 0.25), [name]);
        }
        assert!(there(frames[2] - 1.0).is_empty());
    }
}

#[test]
fn mistakes_are_told() {
    let told = |volume: &str, wanted: &str| {
        let said = load(volume, MATERIAL).expect_err(volume).to_string();
        assert!(said.contains(wanted), "{volume}: {said}");
    };
    let of = |file: &str| format!("file = \"{file}\", material = \"cloud\"");
    told(&of("none.vdb"), "none.vdb");
    told(&of("cut.vdb"), "cut off, or damaged");
    told(&of("mask.vdb"), "no grid of numbers: there are `mask` (Tree_bool_5_4_3)");
    told(&of("shot.toml"), "no OpenVDB file");
    told("file = \"plain.vdb\", material = \"fog\"", "no [[material]] `fog`");
    told("file = \"plain.vdb\"", "material");
    told(&format!("{}, first = 3", of("plain.vdb")), "`first`");
    told(&format!("{}, grids = [\"heat\"]", of("plain.vdb")), "no grid `heat`: there are `density`");
    told(&of("gone.####.vdb"), "no file");
    let warned = |material: &str| {
        let shot = load(&of("plain.vdb"), material).unwrap();
        shot.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    };
    assert!(warned("volume_scatter = [1, 1, 1]").contains("shown as a box"));
    assert!(warned("surface = false").contains("has no medium"));
}

//! Volumes of USD files: are the grids read that their fields name, and when they name them?

use super::*;

/// A volume whose fields are of this file, which a copy of a seed lies at.
fn volume(fields: &str) -> String {
    let seed = concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz/seeds/vdb");
    let fields = fields.replace("SEEDS", seed);
    format!(
        "def Volume \"Cloud\" {{\nrel field:density = </Cloud/Density>\n{fields}\n}}\ndef Sphere \"Ball\" {{}}\n"
    )
}

#[test]
fn a_volume_has_the_grids_of_its_fields() {
    let shot = shown(
        METRES,
        &volume(
            "def OpenVDBAsset \"Density\" {\nasset filePath = @SEEDS/plain.vdb@\ntoken fieldName = \"density\"\n}",
        ),
    );
    let model = model(&shot, "m/Cloud");
    let volume = model.mesh.details.volume.as_ref().expect("it has one");
    assert_eq!(volume.grids.iter().map(|grid| grid.name.as_str()).collect::<Vec<_>>(), ["density"]);
    let material = &shot.scene.materials[usize::from(model.mesh.material_of[0])];
    assert!(
        !material.has_surface && material.medium.is_some_and(|medium| medium.scatter.x == 1.0),
        "{material:?}"
    );
    assert_eq!(material.name, "Cloud");
}

#[test]
fn files_come_and_go_with_their_times() {
    let times = "def OpenVDBAsset \"Density\" {\nasset filePath.timeSamples = { 1: @SEEDS/plain.vdb@, 2: @SEEDS/turned.vdb@ }\n\
        token fieldName.timeSamples = { 1: \"density\", 2: \"temperature\" }\n}";
    let shot = shown(METRES, &volume(times));
    let there = |frame: f64| -> Vec<&str> {
        let models = shot.scene.models.iter().filter(|model| model.track.visible.at(frame));
        let volumes = models.filter_map(|model| model.mesh.details.volume.as_ref());
        volumes.map(|volume| volume.grids[0].name.as_str()).collect()
    };
    assert_eq!((there(1.0), there(2.0)), (vec!["density"], vec!["temperature"]));
}

#[test]
fn volumes_that_cannot_be_read_are_told() {
    for (fields, wanted) in [
        (
            "def OpenVDBAsset \"Density\" {\nasset filePath = @none.vdb@\ntoken fieldName = \"density\"\n}",
            "none.vdb",
        ),
        (
            "def OpenVDBAsset \"Density\" {\nasset filePath = @SEEDS/mask.vdb@\ntoken fieldName = \"mask\"\n}",
            "Tree_bool_5_4_3",
        ),
    ] {
        let shot = load(METRES, &volume(fields)).unwrap();
        assert_eq!(names(&shot), ["m/Ball"]);
        let said = shot.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
        assert!(said.contains(wanted), "{said}");
    }
}

//! What changes in a world while its frames are audited.

use std::sync::Arc;

use afterimage::scene::environment::Sky;
use afterimage::scene::{Environment, LightKind, Scene};
use afterimage::settings::{Filter, Settings};
use glam::DVec3;

use crate::toy;
use crate::toy::worlds::*;

/// Something that changes in a scene.
pub type Change = fn(Scene) -> Scene;

/// A camera, things, lights with and without a size, and a sky, each of which goes or stays.
pub const CHANGES: [&[Change]; 3] = [
    &[camera_goes, under_a_sky],
    &[with_metal_flyer, camera_goes, under_a_sky, with_area_lights],
    &[lamp_goes, with_metal_flyer],
];

/// Has each of these `changes` in a scene, and checks that the audit of four frames finds nothing, with one sample in a pixel and with four.
pub fn expect_nothing_found(scene: &Scene, changes: &[&[Change]], settings: &Settings) {
    for (number, changes) in changes.iter().enumerate() {
        let scene = changes.iter().fold(scene.clone(), |scene, change| change(scene));
        for (samples, filter) in [(1, Filter::Box), (2, Filter::Mitchell)] {
            let [width, height] = [80, 60].map(|size| size / samples);
            let settings = Settings { samples, width, height, filter, audit: true, ..settings.clone() };
            for finished in toy::render(&scene, &settings, 4) {
                let frame = finished.stats.frame;
                assert_eq!(toy::differing(&finished), 0, "change {number}, frame {frame}");
            }
        }
    }
}

/// A sky lights it, and is seen.
pub fn under_a_sky(mut scene: Scene) -> Scene {
    scene.environment = Some(Environment::from_sky(&Sky::default()));
    scene
}

pub fn lamp_goes(mut scene: Scene) -> Scene {
    let position = goes(DVec3::new(2.0, 4.0, 3.0), DVec3::new(1.0, 4.5, 3.0));
    scene.lights[1].kind = LightKind::Point { position };
    scene
}

pub fn camera_goes(scene: Scene) -> Scene {
    with_camera(scene, goes(EYE, EYE + DVec3::new(0.3, 0.1, -0.4)), rests(TARGET))
}

/// A flyer of rough metal.
pub fn with_metal_flyer(scene: Scene) -> Scene {
    let mut scene = with_flyer(scene);
    let flyer = scene.models.last_mut().expect("it was just added");
    flyer.mesh = Arc::new(toy::octahedron(1, true));
    scene
}

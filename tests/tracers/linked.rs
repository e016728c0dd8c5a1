//! Are shadow rays to lights in which some models alone cast shadows blocked by these, and by nothing else?

use std::sync::Arc;

use afterimage::animation::Track;
use afterimage::scene::{BlockerSets, LightKind, LightLinks, Linked, Model, ModelNames, Scene};
use afterimage::trace::{Occluders, Purpose, RayBatch};
use glam::{DVec3, Vec3};

use crate::kinds::{blocks, on_each, scene_of};
use crate::sorts::{at, clear, resting, row_of_things};
use crate::toy::{deforming, floor, light, still};

/// Number of sets: as many as there may be.
const SETS: usize = afterimage::scene::BlockerSet::MOST;

/// Things of every sort, a row for each light, in whose light all cast shadows but those of its own row.
fn things() -> (Scene, usize) {
    let mut models = vec![still("floor", floor(99.0, 0), Vec3::ZERO)];
    let shared = Arc::new(floor(1.0, 0));
    let (mut sorts, mut lights) = (0, Vec::new());
    for row in 0..SETS {
        let bent = |point: Vec3| point * 1.1;
        let mut row_of = row_of_things(row, &shared);
        row_of.push(still("still clear", clear(2), at(7, row).as_vec3()));
        let shapes: &[(f64, &dyn Fn(Vec3) -> Vec3)] = &[(1.0, &|point| point), (2.0, &bent)];
        row_of.push(deforming("bent", floor(1.0, 0), resting(at(8, row)), shapes));
        sorts = row_of.len();
        let name = format!("row {row}");
        let linked = Linked { groups: Arc::from([name.clone()]), ..Linked::default() };
        models.extend(row_of.into_iter().map(|model| Model { linked: linked.clone(), ..model }));
        let mut lamp = light("lamp", LightKind::Point { position: Track::constant(DVec3::Y * 9.0) }, 1.0);
        lamp.links = LightLinks {
            blockers: ModelNames { include: None, exclude: vec![name] },
            ..LightLinks::default()
        };
        lights.push(lamp);
    }
    let mut scene = scene_of(models);
    scene.lights = lights;
    (scene, sorts)
}

#[test]
fn segments_are_blocked_by_the_models_of_their_set() {
    let (scene, sorts) = things();
    let sets = BlockerSets::of(&scene);
    assert_eq!(sets.count(), SETS);
    on_each(&scene, |tracer, way| {
        for light in 0..SETS {
            let purpose = Purpose::shadow_of(sets.of_light(light));
            assert_ne!(purpose, Purpose::Shadow);
            for (row, column) in (0..SETS).flat_map(|row| (0..sorts).map(move |column| (row, column))) {
                let place = at(column, row).as_vec3() + Vec3::new(0.3, 2.0, 0.2);
                let mut ray = RayBatch::default();
                // to above the floor
                ray.push(place, Vec3::NEG_Y, 0.0, 2.5);
                let name = &scene.models[1 + row * sorts + column].name;
                let casts = !name.contains("clear");
                for (purpose, expected) in
                    [(purpose, casts && row != light), (Purpose::Shadow, casts), (Purpose::Sight, true)]
                {
                    let by = [Occluders::Still, Occluders::Movable];
                    let blocked = by.iter().any(|by| blocks(tracer, way, *by, purpose, &ray)[0]);
                    assert_eq!(blocked, expected, "{purpose:?}, {name} of row {row}");
                }
            }
        }
    });
}

//! Do rays meet what their kind sees, and nothing else?

use std::sync::Arc;

use afterimage::scene::{Model, RayKind, RayKinds, RayVisibility, Role, Scene};
use afterimage::trace::{HitBatch, Occluders, OfKind, Purpose, RayBatch, SceneSubset, Search};
use glam::Vec3;

use crate::kinds::{WAYS, blocks, down, kinds, on_each, scene_of};
use crate::sorts::{at, row_of_things};
use crate::toy::{floor, still};

/// Things of every sort over a floor: a row for each kind of ray from which they are hidden.
fn things() -> (Scene, usize) {
    let mut models = vec![still("floor", floor(99.0, 0), Vec3::ZERO)];
    let shared = Arc::new(floor(1.0, 0));
    let mut sorts = 0;
    for (row, kind) in RayKind::ALL.into_iter().enumerate() {
        let row_of = row_of_things(row, &shared);
        sorts = row_of.len();
        let hidden_from = RayKinds::NONE.with(kind);
        let ray_visibility = RayVisibility { hidden_from, role: Role::Itself };
        models.extend(row_of.into_iter().map(|model| Model { ray_visibility, ..model }));
    }
    (scene_of(models), sorts)
}

/// Rays straight down on everything, a row after the other.
fn over(sorts: usize) -> RayBatch {
    let mut rays = RayBatch::default();
    for row in 0..RayKind::ALL.len() {
        for column in 0..sorts {
            let place = at(column, row).as_vec3() + Vec3::new(0.3, 2.0, 0.2);
            rays.push(place, Vec3::NEG_Y, 0.0, f32::INFINITY);
        }
    }
    rays
}

#[test]
fn rays_meet_what_their_kind_sees_and_nothing_else() {
    let (scene, sorts) = things();
    let rays = over(sorts);
    on_each(&scene, |tracer, way| {
        let met = |kinds: OfKind| {
            let mut hits = HitBatch::default();
            let search = Search { kinds, among: SceneSubset::All, coherence: way };
            tracer.closest(&rays, search, &mut hits);
            (0..rays.len()).map(|ray| hits.get(ray).expect("the floor, at least")).collect::<Vec<_>>()
        };
        let of_each = RayKind::ALL.map(|kind| met(OfKind::All(kind)));
        for (kind, hits) in RayKind::ALL.into_iter().zip(&of_each) {
            for (number, hit) in hits.iter().enumerate() {
                let sees = RayKind::ALL[number / sorts] != kind;
                let expected = if sees { number as u32 + 1 } else { 0 };
                assert_eq!(hit.model, expected, "{kind:?}, {}", scene.models[number + 1].name);
            }
        }
        // rays of several kinds in one packet are answered as those of one
        let mixed: Vec<RayKind> = (0..rays.len()).map(|ray| RayKind::ALL[ray * 7 % 5]).collect();
        for (ray, (hit, kind)) in met(OfKind::Each(&mixed)).into_iter().zip(&mixed).enumerate() {
            assert_eq!(hit, of_each[*kind as usize][ray], "{kind:?}, ray {ray}");
        }
    });
}

#[test]
fn segments_are_blocked_by_what_their_kind_sees() {
    let (scene, sorts) = things();
    on_each(&scene, |tracer, way| {
        for (row, hidden_from) in RayKind::ALL.into_iter().enumerate() {
            for column in 0..sorts {
                let place = at(column, row).as_vec3();
                // to above the floor
                let ray = down(place.x + 0.3, place.z + 0.2, 1.5);
                for purpose in [Purpose::Sight, Purpose::Shadow] {
                    let is_clear = column == 6 && purpose == Purpose::Shadow;
                    let expected = hidden_from != purpose.kind() && !is_clear;
                    let by = [Occluders::Still, Occluders::Movable];
                    let blocked = by.iter().any(|by| blocks(tracer, way, *by, purpose, &ray)[0]);
                    let name = &scene.models[1 + row * sorts + column].name;
                    assert_eq!(blocked, expected, "{purpose:?}, {name}, hidden from {hidden_from:?}");
                }
            }
        }
    });
}

/// A model that no ray sees is as good as absent.
#[test]
fn what_is_hidden_from_all_is_met_by_none() {
    let hidden = |model: Model| Model {
        ray_visibility: RayVisibility { hidden_from: RayKinds::ALL, role: Role::Itself },
        ..model
    };
    let scene = scene_of(vec![hidden(still("roof", floor(1.0, 0), Vec3::Y))]);
    for kind in kinds() {
        let mut backend = kind.build(&scene);
        let tracer = backend.commit(&afterimage::pose::Pose::new(&scene, 1), &[false]).unwrap();
        for way in WAYS {
            for kind in RayKind::ALL {
                let mut hits = HitBatch::default();
                let search = Search { kinds: OfKind::All(kind), among: SceneSubset::All, coherence: way };
                tracer.closest(&down(0.1, 0.2, 9.0), search, &mut hits);
                assert_eq!(hits.get(0), None, "{kind:?}");
            }
        }
    }
}

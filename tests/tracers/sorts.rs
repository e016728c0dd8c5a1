//! Things of every sort that tracers keep apart, in rows.

use std::sync::Arc;

use afterimage::animation::{Track, TransformTrack};
use afterimage::scene::{Mesh, Model};
use glam::DVec3;

use crate::toy::{floor, keys, moving, moving_quadric, sphere, still, still_quadric};

/// Distance between neighbours.
const APART: f64 = 4.0;

/// Place of a thing.
pub fn at(column: usize, row: usize) -> DVec3 {
    DVec3::new(APART * column as f64, 1.0, -APART * row as f64)
}

/// A model's track that rests at `place`.
pub fn resting(place: DVec3) -> TransformTrack {
    TransformTrack { translate: Track::constant(place), ..TransformTrack::identity() }
}

/// A square of which the last so many triangles are clear.
pub fn clear(clear: usize) -> Mesh {
    Mesh { shadow_casting: 2 - clear, ..floor(1.0, 0) }
}

/// Things in a row: still, moving, two copies of the mesh `shared`, a still and a moving ball, and one that is clear.
pub fn row_of_things(row: usize, shared: &Arc<Mesh>) -> Vec<Model> {
    let track = |column: usize| TransformTrack {
        translate: keys(&[(1.0, at(column, row)), (2.0, at(column, row) + DVec3::Y)]),
        ..TransformTrack::identity()
    };
    let copy = |column| Model {
        mesh: Arc::clone(shared),
        ..moving("copy", floor(1.0, 0), resting(at(column, row)))
    };
    let ball = glam::DAffine3::from_translation(at(4, row));
    vec![
        still("still", floor(1.0, 0), at(0, row).as_vec3()),
        moving("moving", floor(1.0, 0), track(1)),
        copy(2),
        copy(3),
        still_quadric("ball", &sphere(), 0, true, ball),
        moving_quadric("moving ball", &sphere(), 0, track(5)),
        moving("clear", clear(2), track(6)),
    ]
}

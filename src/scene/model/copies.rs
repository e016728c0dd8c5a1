//! Chooses the still models that share one mesh instead of being put into world space, each with triangles of
//! its own.
//!
//! Rays are fastest among triangles in world space ([`bake`](super::bake)), but ten thousand copies of a tree
//! would fill any memory with them. So the copies that would add most stay in object space, and tracers place
//! one tree of their mesh many times.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::DAffine3;

use crate::scene::{Mesh, Model};

/// Number of triangles that still models may add to a shot by being copies of each other, all meshes
/// together: some 150 MiB.
pub const MOST_ADDED: u64 = 1 << 20;

/// Meshes whose still copies stay in object space, by their addresses.
pub struct SharedMeshes(HashSet<*const Mesh>);

/// The copies of a mesh.
struct Copies {
    mesh: *const Mesh,
    /// Number of triangles of the mesh.
    triangles: u64,
    count: u64,
}

impl Copies {
    /// Number of triangles beyond those of the first copy, if each has its own.
    fn added(&self) -> u64 {
        self.triangles * (self.count - 1)
    }
}

impl SharedMeshes {
    /// Finds the meshes that copies among `models` share, in the space in which the shot is rendered. The
    /// copies that add least are put into world space instead, as long as all of these together add no more
    /// triangles than `most_added`.
    pub fn among(models: &[Model], most_added: u64) -> Self {
        let mut all: Vec<Copies> = Vec::new();
        let mut known: HashMap<*const Mesh, usize> = HashMap::new();
        for model in models.iter().filter(|model| model.is_placed_at_rest()) {
            let mesh = Arc::as_ptr(&model.mesh);
            let number = *known.entry(mesh).or_insert(all.len());
            match all.get_mut(number) {
                Some(copies) => copies.count += 1,
                None => all.push(Copies { mesh, triangles: model.mesh.count() as u64, count: 1 }),
            }
        }
        all.retain(|copies| copies.count > 1);
        // those that add as much stay in the order of the shot
        all.sort_by_key(Copies::added);
        let mut sum = 0;
        let baked = |copies: &&Copies| {
            sum += copies.added();
            sum <= most_added
        };
        let first_shared = all.iter().take_while(baked).count();
        Self(all[first_shared..].iter().map(|copies| copies.mesh).collect())
    }

    /// Returns true if `model` is one of the copies.
    pub fn has(&self, model: &Model) -> bool {
        model.is_placed_at_rest() && self.0.contains(&Arc::as_ptr(&model.mesh))
    }
}

impl Model {
    /// Returns true if it stands still for the whole shot elsewhere than its mesh. Once a shot is loaded,
    /// that is a copy which shares its mesh with others: all other still models are in world space.
    pub fn is_placed_at_rest(&self) -> bool {
        self.track.is_constant() && self.track.map_at(0.0) != DAffine3::IDENTITY
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::animation::{Interpolation, Track, TransformTrack};
    use crate::changes::world::{Dice, bent, model};
    use crate::geometry::Quadric;
    use crate::geometry::quadric::QuadricShape;

    fn at(x: f64) -> TransformTrack {
        TransformTrack { translate: Track::constant(DVec3::X * x), ..TransformTrack::identity() }
    }

    /// Creates models of one mesh of `triangles` triangles, at these places.
    fn copies(triangles: usize, tracks: impl IntoIterator<Item = TransformTrack>) -> Vec<Model> {
        let first = model(bent(&mut Dice(1), triangles, 1.0), TransformTrack::identity());
        tracks.into_iter().map(|track| Model { track, ..first.clone() }).collect()
    }

    /// Tells which of the models share their mesh, if copies may add at most `most_added` triangles.
    fn shared(models: &[Model], most_added: u64) -> Vec<bool> {
        let shared = SharedMeshes::among(models, most_added);
        models.iter().map(|model| shared.has(model)).collect()
    }

    #[test]
    fn copies_beyond_the_limit_share_their_mesh() {
        let models = copies(10, (1..=5).map(|copy| at(copy.into())));
        assert_eq!(shared(&models, 40), [false; 5], "the first one adds nothing");
        assert_eq!(shared(&models, 39), [true; 5]);
        assert_eq!(shared(&models[..1], 0), [false], "it is alone");
    }

    #[test]
    fn all_meshes_have_one_limit_and_those_that_add_least_are_put_into_world_space() {
        let mut models = copies(30, [at(1.0), at(2.0)]);
        models.extend(copies(5, (1..=3).map(|copy| at(copy.into()))));
        models.extend(copies(30, [at(3.0), at(4.0)]));
        let expected =
            |first: bool, few: bool, last: bool| [[first; 2].to_vec(), vec![few; 3], vec![last; 2]];
        for (most_added, expected) in [
            (9, expected(true, true, true)),
            (39, expected(true, false, true)),
            // of two that add as much the first one of the shot
            (40, expected(false, false, true)),
            (70, expected(false, false, false)),
        ] {
            assert_eq!(shared(&models, most_added), expected.concat(), "{most_added}");
        }
    }

    #[test]
    fn only_what_would_be_put_elsewhere_counts() {
        let keys = vec![(1.0, DVec3::ZERO), (2.0, DVec3::X)];
        let moves = TransformTrack {
            translate: Track::through(keys, Interpolation::Linear).expect("good"),
            ..TransformTrack::identity()
        };
        let models = copies(10, [TransformTrack::identity(), at(1.0), moves.clone()]);
        assert_eq!(shared(&models, 0), [false; 3], "one alone is put elsewhere");
        let models = copies(10, [TransformTrack::identity(), at(1.0), moves, at(2.0)]);
        assert_eq!(shared(&models, 0), [false, true, false, true]);
        let quadric = Quadric::new(QuadricShape::Ellipsoid { radii: DVec3::ONE }, false);
        let ball = model(Mesh::of_curved(quadric, 0, true), at(1.0));
        assert_eq!(
            shared(&[ball.clone(), Model { track: at(2.0), ..ball }], 0),
            [true; 2],
            "curved ones as well"
        );
        let twins = [1, 2].map(|_| copies(10, [at(1.0)])).concat();
        assert_eq!(shared(&twins, 0), [false; 2], "two meshes");
    }
}

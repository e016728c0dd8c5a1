//! Models that deform: a tree is built of the first shape, and refitted to each other one.
//!
//! Refitting keeps the tree and makes its boxes anew, from the triangles upwards. So the scene of a shape follows from the first shape
//! and this one, whatever was rendered before. Where triangles that lay together in the first shape no longer do, boxes become large
//! ([`Groups`]): then a scene of this shape is built from nothing.
//!
//! Within an exposure in which the model deforms it goes straight from one shape to another: then its scene is built of both, for Embree
//! cannot refit such a tree.

use std::sync::Arc;

use embree::{BuildQuality, Device, FrozenScene, GeometryId, Scene as EmbreeScene, VertexBuffer};
use glam::Vec3;

use super::frozen::{Frozen, ROBUST, Source, Vertices, freeze, is_flat};
use crate::animation::{Chord, Shape};
use crate::geometry::Bounds;
use crate::pose::Pose;
use crate::scene::{Mesh, Shapes, Triangles};
use crate::trace::TraceError;

/// Growth of [`Groups`] above which a tree suits a shape so badly that another is built.
const MOST_GROWTH: f64 = 2.0;

/// Model whose scenes follow its shapes.
pub struct Deforming {
    model: usize,
    mesh: Arc<Mesh>,
    with_casters: bool,
    /// Instances among all movable models, and among those that cast shadows, if it has one there.
    instances: [Option<GeometryId>; 2],
    /// Shapes between which the instances go, or twice the one that they show; none after an error.
    shapes: Option<[Shape; 2]>,
    /// Scenes with the trees of the first shape, refitted to the last shape that these suit; none after an error.
    refitted: Option<Frozen>,
    groups: Groups,
    /// True if the mesh is flat in the first shape.
    is_flat: bool,
    /// What the instances show while their scenes are changed.
    nothing: Arc<FrozenScene>,
}

impl Deforming {
    /// Creates model number `model`, whose `mesh` has shapes, in the first of these.
    pub fn new(
        device: &Device,
        model: usize,
        mesh: &Arc<Mesh>,
        with_casters: bool,
    ) -> Result<Self, TraceError> {
        let triangles = mesh.triangles();
        let positions = vertices_in(triangles, &Shape::FIRST);
        Ok(Self {
            model,
            mesh: Arc::clone(mesh),
            with_casters,
            instances: [None; 2],
            shapes: None,
            refitted: None,
            groups: Groups::new(&triangles.corners, positions.as_slice()),
            is_flat: is_flat(&positions),
            nothing: EmbreeScene::new(device, BuildQuality::Low, ROBUST)?.freeze()?,
        })
    }

    /// Scenes of the first shape, for the instances that place the model.
    pub fn first(&mut self, device: &Device) -> Result<&Frozen, TraceError> {
        let positions = vertices_in(self.mesh.triangles(), &Shape::FIRST);
        let first = self.freeze(device, Vertices::Still(&positions), BuildQuality::Refit)?;
        self.shapes = Some(Chord::FIRST.ends);
        Ok(self.refitted.insert(first))
    }

    /// Sets the instances that place the model.
    pub fn placed(self, instances: [Option<GeometryId>; 2]) -> Self {
        Self { instances, ..self }
    }

    /// Takes the model to the shapes that it has in `pose`, if it is there. `movable`, `casters`: the scenes of its instances.
    pub fn deform(
        &mut self,
        device: &Device,
        movable: &mut EmbreeScene,
        casters: Option<&mut EmbreeScene>,
        pose: &Pose,
    ) -> Result<(), TraceError> {
        let place = &pose.models[self.model];
        let chord = &place.shape;
        if !place.is_visible || self.shapes == Some(chord.ends) {
            return Ok(());
        }
        self.shapes = None;
        let mut scenes = [Some(movable), casters];
        // a scene that an instance places cannot be changed
        show(self.instances, &mut scenes, [Some(&self.nothing); 2])?;
        let triangles = self.mesh.triangles();
        let positions = vertices_in(triangles, &chord.ends[0]);
        let anew;
        let shown = if !chord.is_still() {
            let later = vertices_in(triangles, &chord.ends[1]);
            let vertices = Vertices::Moving([positions, later], pose.sweeps.groups());
            anew = self.freeze(device, vertices, BuildQuality::Low)?;
            Some(&anew)
        } else if self.suits(&positions) {
            if self.refitted.is_none() {
                self.first(device)?;
            }
            let refitted = self.refitted.take().map(|frozen| frozen.refit(&positions)).transpose()?;
            self.refitted = refitted;
            self.refitted.as_ref()
        } else {
            anew = self.freeze(device, Vertices::Still(&positions), BuildQuality::Low)?;
            Some(&anew)
        };
        if let Some(Frozen { scene, casters, .. }) = shown {
            show(self.instances, &mut scenes, [Some(scene), casters.as_ref()])?;
        }
        self.shapes = Some(chord.ends);
        Ok(())
    }

    /// Returns true if the trees of the first shape suit the one with these positions.
    fn suits(&self, positions: &VertexBuffer) -> bool {
        // what becomes flat needs a scene as flat meshes have
        let becomes_flat = !self.is_flat && is_flat(positions);
        !becomes_flat && self.groups.growth(positions.as_slice()) <= MOST_GROWTH
    }

    fn freeze(
        &self,
        device: &Device,
        vertices: Vertices<'_>,
        quality: BuildQuality,
    ) -> Result<Frozen, TraceError> {
        let source = Source::Triangles(self.mesh.triangles(), vertices);
        freeze(device, &self.mesh, &source, quality, self.with_casters)
    }
}

/// Has instances among all movable models, and among those that cast shadows, place other scenes, where they are in `scenes`.
pub(super) fn show(
    instances: [Option<GeometryId>; 2],
    scenes: &mut [Option<&mut EmbreeScene>; 2],
    of: [Option<&Arc<FrozenScene>>; 2],
) -> Result<(), TraceError> {
    for ((id, scene), of) in instances.into_iter().zip(scenes).zip(of) {
        if let (Some(id), Some(scene), Some(of)) = (id, scene, of) {
            scene.set_instance_scene(id, of)?;
        }
    }
    Ok(())
}

fn vertices_in(triangles: &Triangles, shape: &Shape) -> Arc<VertexBuffer> {
    let of_shape = |shapes: &Arc<Shapes>| Arc::new(VertexBuffer::new(shapes.positions(shape)));
    triangles.shapes.as_ref().map_or_else(|| Arc::clone(&triangles.positions), of_shape)
}

/// Some of a mesh's triangles, by their corners, in the order of a curve through the first shape: those that follow each other lie
/// together there, as in the nodes of a tree.
struct Groups(Vec<[u32; 3]>);

impl Groups {
    /// Largest number of triangles that are looked at.
    const MOST: usize = 4096;
    /// Number of triangles of a group.
    const TOGETHER: usize = 8;

    fn new(triangles: &[[u32; 3]], positions: &[[f32; 3]]) -> Self {
        let every = triangles.len().div_ceil(Self::MOST).max(1);
        let some = triangles.iter().copied().step_by(every).collect();
        Self(along_curve(some, positions))
    }

    /// How many times as large as the boxes of groups that are made for these positions those of the first shape's groups are there.
    fn growth(&self, positions: &[[f32; 3]]) -> f64 {
        let area = |triangles: &[[u32; 3]]| -> f64 {
            let around = |group: &[[u32; 3]]| {
                let corners = group.iter().flatten().map(|corner| place(*corner, positions));
                let around = corners.fold(Bounds::EMPTY, Bounds::with);
                let [x, y, z] = (around.high - around.low).to_array().map(f64::from);
                x * y + y * z + z * x
            };
            triangles.chunks(Self::TOGETHER).map(around).sum()
        };
        let least = area(&along_curve(self.0.clone(), positions));
        // what has no area at all is as good as ever
        if least > 0.0 { area(&self.0) / least } else { 1.0 }
    }
}

fn place(corner: u32, positions: &[[f32; 3]]) -> Vec3 {
    Vec3::from_array(positions[corner as usize])
}

/// Sorts triangles along Morton's curve through their middles.
fn along_curve(mut triangles: Vec<[u32; 3]>, positions: &[[f32; 3]]) -> Vec<[u32; 3]> {
    /// Largest coordinate of a cell of the curve.
    const LAST: f32 = 1023.0;
    let middle =
        |triangle: &[u32; 3]| triangle.map(|corner| place(corner, positions) / 3.0).iter().sum::<Vec3>();
    let around = triangles.iter().map(middle).fold(Bounds::EMPTY, Bounds::with);
    let scale = LAST / (around.high - around.low).max_element().max(f32::MIN_POSITIVE);
    triangles.sort_by_cached_key(|triangle| {
        let cell = (middle(triangle) - around.low) * scale;
        let [x, y, z] = cell.to_array().map(|along| spread(along as u32));
        x << 2 | y << 1 | z
    });
    triangles
}

/// Spreads ten bits: two zeros come before each.
fn spread(bits: u32) -> u32 {
    let bits = (bits | bits << 16) & 0x0300_00ff;
    let bits = (bits | bits << 8) & 0x0300_f00f;
    let bits = (bits | bits << 4) & 0x030c_30c3;
    (bits | bits << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles of a square of 64 x 64 cells, and the places of its vertices.
    fn square() -> (Vec<[u32; 3]>, Vec<Vec3>) {
        let at = |x: u32, y: u32| y * 65 + x;
        let cells = (0..64).flat_map(|y| (0..64).map(move |x| (x, y)));
        let halves =
            |(x, y)| [[at(x, y), at(x + 1, y), at(x, y + 1)], [at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]];
        let places = (0..65 * 65).map(|at| Vec3::new((at % 65) as f32, (at / 65) as f32, 0.0));
        (cells.flat_map(halves).collect(), places.collect())
    }

    fn growth(to: impl Fn(Vec3) -> Vec3) -> f64 {
        let (triangles, places) = square();
        let floats = |places: &[Vec3]| places.iter().map(|at| at.to_array()).collect::<Vec<_>>();
        let groups = Groups::new(&triangles, &floats(&places));
        groups.growth(&floats(&places.into_iter().map(to).collect::<Vec<_>>()))
    }

    #[test]
    fn groups_that_bend_turn_and_stretch_do_not_grow() {
        assert_eq!(growth(|at| at), 1.0);
        assert_eq!(growth(|at| at * 100.0 + 5.0), 1.0);
        let turned = growth(|at| Vec3::new(at.x + at.y, at.y - at.x, 0.5 * at.x));
        let stretched = growth(|at| at * Vec3::new(5.0, 1.0, 1.0));
        let rolled = growth(|at| Vec3::new(at.x, (at.y * 0.1).sin() * 10.0, (at.y * 0.1).cos() * 10.0));
        for growth in [turned, stretched, rolled] {
            assert!((0.5..1.5).contains(&growth), "{growth}");
        }
    }

    #[test]
    fn groups_whose_triangles_part_grow() {
        // triangles in a row, and each where another was
        let count = 1000;
        let triangles: Vec<[u32; 3]> = (0..count).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect();
        let row = |step: u32| -> Vec<[f32; 3]> {
            let corners = |at: u32| {
                [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5]]
                    .map(|[x, y]| [(at * step % count) as f32 + x, y, 0.5 * x])
            };
            (0..count).flat_map(corners).collect()
        };
        let groups = Groups::new(&triangles, &row(1));
        assert_eq!(groups.growth(&row(1)), 1.0);
        assert!(groups.growth(&row(389)) > 10.0 * MOST_GROWTH);
    }

    #[test]
    fn a_mesh_that_shrinks_to_a_point_does_not_grow() {
        assert_eq!(growth(|_| Vec3::ONE), 1.0);
        assert_eq!(Groups::new(&[], &[]).growth(&[]), 1.0);
    }
}

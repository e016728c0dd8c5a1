//! All models at rest, in trees of boxes that are searched for what reaches into a volume.

use std::collections::HashMap;
use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

use super::volume::Volume;
use crate::animation::Transform;
use crate::geometry::tree::{Box3, Child, Tree, WIDTH};
use crate::scene::{Mesh, RayKind, Scene, Triangles};

/// Triangles of a leaf, at most.
const LEAF: u32 = 8;

/// Factor by which the box around some triangles may have more surface than their own boxes together.
const LOOSE: f32 = 0.7;

/// The models that never move in the shot. A mesh that stands at several places is held once.
pub struct Obstacles {
    meshes: Vec<MeshTree>,
    placed: Vec<Placed>,
    /// Tree of the models' boxes, world space. A leaf is an index into `placed`.
    models: Tree,
    /// True for each model of the scene whose surfaces may be proven to be clear.
    is_provable: Vec<bool>,
}

/// The primitives of a mesh, object space.
struct MeshTree {
    mesh: Arc<Mesh>,
    tree: Tree,
    /// Primitives that follow each other in the mesh: the first, and how many.
    leaves: Vec<(u32, u32)>,
}

/// A model at its place.
struct Placed {
    /// Index into [`Scene::models`].
    model: u32,
    /// Index into [`Obstacles::meshes`].
    mesh: usize,
    transform: Transform,
    /// True if the transform mirrors.
    is_mirrored: bool,
}

impl Placed {
    /// Corners of a triangle, world space, in an order by which its normal is on the outside, which a mirror would turn.
    fn corners(&self, triangles: &Triangles, triangle: u32) -> [Vec3; 3] {
        let [a, b, c] = triangles.positions_of(triangle).map(|corner| self.transform.point(corner));
        if self.is_mirrored { [a, c, b] } else { [a, b, c] }
    }
}

/// A triangle that may reach into a volume.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    /// Index into [`Scene::models`].
    pub model: u32,
    /// Index into [`Triangles::corners`].
    pub triangle: u32,
    /// Its corners, world space. Triangles of one model that share a vertex have the same corner there, to the bit.
    pub corners: [Vec3; 3],
}

/// Memory of a search.
#[derive(Debug, Default)]
pub(super) struct SearchStack(Vec<Child>, Vec<Child>);

/// End of a search that has found more than it may, what may not be there, or something of which it cannot be said where it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TooMuch;

impl Obstacles {
    /// Builds the trees of all models of `scene` that never move and that rays from the eye see.
    pub fn new(scene: &Scene) -> Self {
        let at_rest = |model: &u32| scene.models[*model as usize].track.is_constant();
        let models: Vec<u32> = (0..scene.models.len() as u32).filter(at_rest).collect();
        let mut known: HashMap<*const Mesh, usize> = HashMap::new();
        let (mut meshes, mut placed): (Vec<Arc<Mesh>>, Vec<Placed>) = Default::default();
        for model in models {
            let one = &scene.models[model as usize];
            let transform = one.track.at(0.0);
            if !transform.is_visible || !one.ray_visibility.is_seen_by(RayKind::Camera) {
                continue;
            }
            let mesh = *known.entry(Arc::as_ptr(&one.mesh)).or_insert_with(|| {
                meshes.push(Arc::clone(&one.mesh));
                meshes.len() - 1
            });
            let is_mirrored = transform.to_world.matrix3.determinant() < 0.0;
            placed.push(Placed { model, mesh, transform, is_mirrored });
        }
        let meshes: Vec<MeshTree> = meshes.into_par_iter().map(MeshTree::new).collect();
        let boxes: Vec<Box3> =
            placed.iter().map(|one| meshes[one.mesh].tree.bounds.placed(&one.transform)).collect();
        let models = Tree::quick(&boxes, 1, |ids| ids[0]);
        let mut is_provable = vec![false; scene.models.len()];
        for one in &placed {
            let mesh = &scene.models[one.model as usize].mesh;
            is_provable[one.model as usize] =
                mesh.cut.is_none() && mesh.as_triangles().is_some_and(|all| all.shapes.is_none());
        }
        Self { meshes, placed, models, is_provable }
    }

    /// Returns true if `model` is at rest, made of triangles, and has no parts cut out of it: then its surfaces may be proven to be clear.
    #[inline(always)]
    pub fn is_provable(&self, model: u32) -> bool {
        self.is_provable[model as usize]
    }

    /// Collects the triangles that may reach into `volume`, `most` at most, each of which `may` be there.
    pub(super) fn find(
        &self,
        volume: &Volume,
        (most, may): (usize, &impl Fn(&Piece) -> bool),
        SearchStack(open_models, open): &mut SearchStack,
        found: &mut Vec<Piece>,
    ) -> Result<(), TooMuch> {
        found.clear();
        if self.models.nodes.is_empty() {
            return Ok(());
        }
        let test = volume.box_test();
        open_models.clear();
        open_models.push(Child::ROOT);
        while let Some(child) = open_models.pop() {
            match child.open() {
                Ok(placed) => {
                    self.find_in(&self.placed[placed as usize], volume, (most, may), open, found)?
                }
                Err(node) => {
                    let node = &self.models.nodes[node];
                    push_met(test.met(&node.planes), &node.children, open_models);
                }
            }
        }
        Ok(())
    }

    fn find_in(
        &self,
        placed: &Placed,
        volume: &Volume,
        (most, may): (usize, &impl Fn(&Piece) -> bool),
        open: &mut Vec<Child>,
        found: &mut Vec<Piece>,
    ) -> Result<(), TooMuch> {
        let MeshTree { mesh, tree, leaves } = &self.meshes[placed.mesh];
        let triangles = mesh.as_triangles();
        let test = volume.in_object(&placed.transform).box_test();
        open.clear();
        open.push(Child::ROOT);
        while let Some(child) = open.pop() {
            match child.open() {
                Err(node) => {
                    let node = &tree.nodes[node];
                    push_met(test.met(&node.planes), &node.children, open);
                }
                Ok(leaf) => {
                    let (first, count) = leaves[leaf as usize];
                    // of curved geometry nothing is proven where it may be, and nothing hinders where it is not
                    let triangles = triangles.ok_or(TooMuch)?;
                    for triangle in first..first + count {
                        let corners = placed.corners(triangles, triangle);
                        if volume.misses(&corners) {
                            continue;
                        }
                        let piece = Piece { model: placed.model, triangle, corners };
                        if found.len() == most || !may(&piece) {
                            return Err(TooMuch);
                        }
                        found.push(piece);
                    }
                }
            }
        }
        Ok(())
    }
}

/// Adds the children whose bit in `met` is set.
#[inline(always)]
fn push_met(mut met: u32, children: &[Child; WIDTH], open: &mut Vec<Child>) {
    while met != 0 {
        open.push(children[met.trailing_zeros() as usize % WIDTH]);
        met &= met - 1;
    }
}

impl MeshTree {
    /// Primitives that follow each other in a file mostly lie side by side: runs of them are leaves. So the tree has fewer boxes, and takes
    /// less time to build.
    fn new(mesh: Arc<Mesh>) -> Self {
        let (mut boxes, mut leaves): (Vec<Box3>, Vec<(u32, u32)>) = Default::default();
        let mut run = (Box3::EMPTY, 0.0, (0, 0));
        for primitive in 0..mesh.count() as u32 {
            let own = mesh.geometry.bounds(primitive);
            let own = Box3 { low: own.low.to_array(), high: own.high.to_array() };
            let (around, sum, (first, count)) = run;
            let (joined, all) = (around.union(&own), sum + own.half_area());
            run = if count > 0 && (count == LEAF || joined.half_area() > all * LOOSE) {
                boxes.push(around);
                leaves.push((first, count));
                (own, own.half_area(), (primitive, 1))
            } else {
                (joined, all, (first, count + 1))
            };
        }
        boxes.push(run.0);
        leaves.push(run.2);
        let tree = Tree::quick(&boxes, 1, |ids| ids[0]);
        Self { mesh, tree, leaves }
    }
}

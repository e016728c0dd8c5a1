//! Skins and morph targets: the positions of vertices in each frame.

use glam::{Affine3A, DAffine3, DMat4, Vec3, Vec3A};
use rayon::prelude::*;

use super::animation::{Channel, Clip, Property};
use super::document::Document;
use super::geometry::{Geometry, Influences};
use super::nodes::Tree;
use crate::scene::import::deformed::Distinct;
use crate::scene::import::faces::are_within_reach;
use crate::scene::{SceneError, Shapes};

/// A skin with its bind pose.
struct Skin {
    joints: Vec<usize>,
    /// Maps from the mesh to each joint as it was bound.
    inverse_binds: Vec<DAffine3>,
}

/// Shapes of a mesh as node `number` shows it, with their times, of which each frame has so many (`a_frame`). Meshes with a skin come
/// to lie in the space of the scene.
///
/// # Errors Joints that are not there, or more shapes than there is memory for.
pub fn shapes(
    document: &Document,
    (tree, clip): (&Tree, &Clip),
    number: usize,
    geometry: &Geometry,
    a_frame: u32,
) -> Result<Distinct, SceneError> {
    let pose = Pose::new(document, number, geometry)?;
    let frames = match pose.is_animated(tree, clip) {
        true => clip.moments(a_frame),
        false => vec![1.0],
    };
    let check = Shapes::check_memory(frames.len(), geometry.positions.len());
    check.map_err(|error| document.fault(error.to_string()))?;
    let mut shapes = Distinct::default();
    for frame in frames {
        let positions = pose.positions(document, (tree, clip), geometry, frame);
        if !are_within_reach(&positions) {
            let message = format!(
                "node {number} deforms its mesh beyond all bounds at frame {frame}: export the file again"
            );
            return Err(document.fault(message));
        }
        shapes.add(frame, positions);
    }
    Ok(shapes)
}

/// A node's skin, and the weights of its morph targets at rest.
pub struct Pose {
    node: usize,
    skin: Option<Skin>,
    weights: Vec<f64>,
}

impl Pose {
    /// Reads it for the mesh of `geometry`.
    ///
    /// # Errors Joints that are not there.
    pub fn new(document: &Document, number: usize, geometry: &Geometry) -> Result<Self, SceneError> {
        let node = document.get(&document.json.nodes, number, "node")?;
        let skin = node.skin.map(|skin| read_skin(document, skin, geometry)).transpose()?;
        let of_mesh = match node.mesh {
            Some(mesh) => document.get(&document.json.meshes, mesh, "mesh")?.weights.clone(),
            None => Vec::new(),
        };
        Ok(Self { node: number, skin, weights: node.weights.clone().unwrap_or(of_mesh) })
    }

    /// Returns true if the shape of the mesh may change in the animation.
    pub fn is_animated(&self, tree: &Tree, clip: &Clip) -> bool {
        let is_morphing =
            |channel: &Channel| channel.node == self.node && channel.property == Property::Weights;
        let bends = |skin: &Skin| {
            let moved = moved(tree, clip);
            skin.joints.iter().any(|joint| moved[*joint])
        };
        self.skin.as_ref().is_some_and(bends) || clip.channels.iter().any(is_morphing)
    }

    /// Positions of the vertices at a frame: in the space of the scene if the node has a skin, otherwise in that of the mesh.
    pub fn positions(
        &self,
        document: &Document,
        (tree, clip): (&Tree, &Clip),
        geometry: &Geometry,
        frame: f64,
    ) -> Vec<[f32; 3]> {
        let animated = clip.weights(self.node, frame);
        let positions = morphed(geometry, animated.as_deref().unwrap_or(&self.weights));
        let Some(skin) = &self.skin else { return positions };
        let globals = tree.globals(&clip.locals(tree, frame));
        if geometry.influences.is_empty() {
            document.leave_out("a mesh with a skin names no joints: it stands where it was bound");
        }
        skinned(geometry, &positions, &skin.maps(&globals))
    }
}

/// Tells for each node whether it, or a node above it, moves in the animation.
pub fn moved(tree: &Tree, clip: &Clip) -> Vec<bool> {
    let mut moved = vec![false; tree.parents.len()];
    let places = clip.channels.iter().filter(|channel| channel.property != Property::Weights);
    places.for_each(|channel| moved[channel.node] = true);
    tree.inherited(moved)
}

fn morphed(geometry: &Geometry, weights: &[f64]) -> Vec<[f32; 3]> {
    let mut positions = geometry.positions.clone();
    for (target, weight) in geometry.targets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
        let weight = *weight as f32;
        positions.par_iter_mut().zip(target).for_each(|(position, by)| {
            *position = (Vec3::from(*position) + Vec3::from(*by) * weight).to_array();
        });
    }
    positions
}

fn skinned(geometry: &Geometry, positions: &[[f32; 3]], maps: &[Affine3A]) -> Vec<[f32; 3]> {
    let place = |(vertex, position): (usize, &[f32; 3])| {
        let position = Vec3A::from(*position);
        let (mut sum, mut all) = (Vec3A::ZERO, 0.0);
        for Influences { joints, weights } in &geometry.influences {
            for (joint, weight) in
                joints[vertex].iter().zip(weights[vertex]).filter(|(_, weight)| *weight > 0.0)
            {
                sum += maps[*joint as usize].transform_point3a(position) * weight;
                all += weight;
            }
        }
        if all > 0.0 { (sum / all).to_array() } else { position.to_array() }
    };
    positions.par_iter().enumerate().map(place).collect()
}

fn read_skin(document: &Document, number: usize, geometry: &Geometry) -> Result<Skin, SceneError> {
    let json = document.get(&document.json.skins, number, "skin")?;
    for joint in &json.joints {
        document.get(&document.json.nodes, *joint, "node")?;
    }
    let wrong = |what: &str| document.fault(format!("skin {number} {what}: export the file again"));
    let count = json.joints.len();
    for Influences { joints, weights } in &geometry.influences {
        let pairs = joints.iter().flatten().zip(weights.iter().flatten());
        if pairs.into_iter().any(|(joint, weight)| *weight > 0.0 && *joint as usize >= count) {
            return Err(wrong("has fewer joints than its mesh names"));
        }
    }
    let inverse_binds = match json.inverse_bind_matrices {
        None => vec![DAffine3::IDENTITY; count],
        Some(accessor) => {
            let matrices: Vec<[f32; 16]> = document.vectors(accessor)?;
            let map = |matrix: [f32; 16]| DAffine3::from_mat4(DMat4::from_cols_array(&matrix.map(f64::from)));
            matrices.into_iter().map(map).collect()
        }
    };
    if inverse_binds.len() < count {
        return Err(wrong("has fewer inverseBindMatrices than joints"));
    }
    Ok(Skin { joints: json.joints.clone(), inverse_binds })
}

impl Skin {
    /// Maps from the bound mesh to the scene, by joint.
    fn maps(&self, globals: &[DAffine3]) -> Vec<Affine3A> {
        let map = |(joint, inverse_bind): (&usize, &DAffine3)| {
            let map = globals[*joint] * *inverse_bind;
            Affine3A::from_cols_array(&map.to_cols_array().map(|number| number as f32))
        };
        self.joints.iter().zip(&self.inverse_binds).map(map).collect()
    }
}

//! The tree of nodes: who is below whom, and where each stands while nothing is animated.

use glam::{DAffine3, DMat4, DQuat, DVec3};

use super::document::{Document, LARGEST_COORDINATE};
use super::json::Node;
use crate::scene::SceneError;

/// Place of a node below its parent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Local {
    pub translation: DVec3,
    /// Unit length.
    pub rotation: DQuat,
    pub scale: DVec3,
}

impl Local {
    /// The map from the node to its parent.
    pub fn map(&self) -> DAffine3 {
        DAffine3::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

/// Nodes of a file.
pub struct Tree {
    /// Parent of each node.
    pub parents: Vec<Option<usize>>,
    /// All nodes, parents before their children.
    pub order: Vec<usize>,
    /// Nodes of the scene that is shown, in the order of the file: each followed by those below it.
    pub shown: Vec<usize>,
    /// Map of each node to its parent at rest.
    pub rest: Vec<DAffine3>,
    /// Parts of that map, for what animations replace.
    pub locals: Vec<Local>,
}

impl Tree {
    /// Reads the tree.
    ///
    /// # Errors Nodes that are not there, that stand below themselves or below two others, or places that make no sense.
    pub fn new(document: &Document) -> Result<Self, SceneError> {
        let nodes = &document.json.nodes;
        let mut parents = vec![None; nodes.len()];
        for (parent, node) in nodes.iter().enumerate() {
            for child in &node.children {
                document.get(nodes, *child, "node")?;
                if parents[*child].replace(parent).is_some() {
                    let message =
                        format!("node {child} stands below two nodes: the file is damaged; export it again");
                    return Err(document.fault(message));
                }
            }
        }
        let mut order: Vec<usize> = (0..nodes.len()).filter(|node| parents[*node].is_none()).collect();
        let mut at = 0;
        while let Some(node) = order.get(at) {
            let children = &nodes[*node].children;
            at += 1;
            order.extend(children);
        }
        if order.len() < nodes.len() {
            let mut is_known = vec![false; nodes.len()];
            order.iter().for_each(|node| is_known[*node] = true);
            let first = is_known.iter().position(|known| !known).unwrap_or_default();
            let message = format!("node {first} stands below itself: the file is damaged; export it again");
            return Err(document.fault(message));
        }
        let places: Vec<(DAffine3, Local)> =
            nodes.iter().enumerate().map(|(i, node)| place(document, i, node)).collect::<Result<_, _>>()?;
        let (rest, locals) = places.into_iter().unzip();
        Ok(Self { shown: shown(document, &parents)?, parents, order, rest, locals })
    }

    /// Computes the map of each node to the root of the scene, from those to their parents.
    pub fn globals(&self, locals: &[DAffine3]) -> Vec<DAffine3> {
        let mut globals = locals.to_vec();
        for node in &self.order {
            if let Some(parent) = self.parents[*node] {
                globals[*node] = globals[parent] * locals[*node];
            }
        }
        globals
    }

    /// Spreads flags of nodes to all nodes below them.
    pub fn inherited(&self, mut flags: Vec<bool>) -> Vec<bool> {
        for node in &self.order {
            if let Some(parent) = self.parents[*node] {
                flags[*node] |= flags[parent];
            }
        }
        flags
    }
}

/// Nodes of the scene that is shown: the file's own choice, or the first scene, or all nodes if there is none.
fn shown(document: &Document, parents: &[Option<usize>]) -> Result<Vec<usize>, SceneError> {
    let (nodes, scenes) = (&document.json.nodes, &document.json.scenes);
    let roots: Vec<usize> = match (document.json.scene, scenes.first()) {
        (Some(scene), _) => document.get(scenes, scene, "scene")?.nodes.clone(),
        (None, Some(first)) => first.nodes.clone(),
        (None, None) => (0..nodes.len()).filter(|node| parents[*node].is_none()).collect(),
    };
    let mut is_there = vec![false; nodes.len()];
    let (mut shown, mut waiting) = (Vec::new(), roots);
    waiting.reverse();
    while let Some(node) = waiting.pop() {
        let children = &document.get(nodes, node, "node")?.children;
        if !std::mem::replace(&mut is_there[node], true) {
            shown.push(node);
            waiting.extend(children.iter().rev());
        }
    }
    Ok(shown)
}

fn place(document: &Document, index: usize, node: &Node) -> Result<(DAffine3, Local), SceneError> {
    let wrong = || {
        let message =
            "has a place that is not finite, or no place (a matrix with perspective): export the file again";
        document.fault(format!("node {index} {message}"))
    };
    let reaches = |numbers: &[f64]| numbers.iter().all(|number| number.abs() <= LARGEST_COORDINATE);
    if let Some(matrix) = &node.matrix {
        let map = DMat4::from_cols_array(matrix);
        let bottom = map.row(3);
        if !reaches(matrix) || bottom.truncate() != DVec3::ZERO || bottom.w != 1.0 {
            return Err(wrong());
        }
        let map = DAffine3::from_mat4(map);
        let local = if map.matrix3.determinant() == 0.0 {
            Local { translation: map.translation, rotation: DQuat::IDENTITY, scale: DVec3::ZERO }
        } else {
            let (scale, rotation, translation) = map.to_scale_rotation_translation();
            Local { translation, rotation, scale }
        };
        return Ok((map, local));
    }
    let translation = node.translation.unwrap_or([0.0; 3]);
    let rotation = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let scale = node.scale.unwrap_or([1.0; 3]);
    if ![&translation[..], &rotation, &scale].into_iter().all(reaches) {
        return Err(wrong());
    }
    let local = Local {
        translation: translation.into(),
        rotation: unit(DQuat::from_array(rotation)),
        scale: scale.into(),
    };
    Ok((local.map(), local))
}

/// Scales a quaternion to unit length; one without a length turns nothing.
pub fn unit(rotation: DQuat) -> DQuat {
    let length = rotation.length();
    if length.is_normal() { rotation * length.recip() } else { DQuat::IDENTITY }
}

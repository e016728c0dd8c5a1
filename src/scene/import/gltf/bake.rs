//! Bakes the motion of nodes: where each stands in each frame of an animation, through all of its parents.

use std::collections::{BTreeMap, BTreeSet};

use glam::DAffine3;

use super::animation::{Clip, Curve, Property};
use super::document::Document;
use super::nodes::Tree;
use crate::memory::{self, Need, Part};
use crate::scene::SceneError;
use crate::scene::import::part_of_file::NodeTrack;

/// Time before a jump at which a node still stands where it was, frames.
const JUST_BEFORE: f64 = 1.0 / 1024.0;

/// Bakes the tracks of `wanted` nodes. Those without a volume in all frames have none.
///
/// # Errors More keys than there is memory for.
pub fn tracks(
    document: &Document,
    tree: &Tree,
    clip: &Clip,
    wanted: &BTreeSet<usize>,
) -> Result<BTreeMap<usize, NodeTrack>, SceneError> {
    let times = Times::new(tree, clip);
    let moving: Vec<usize> = wanted.iter().copied().filter(|node| times.moves[*node]).collect();
    check_memory(document, moving.len(), times.quarters.len() + times.beside_cuts.len())?;
    let mut keys = keys(tree, clip, &times, &moving);
    let rest = tree.globals(&tree.rest);
    let track = |node: &usize| {
        let keys = keys.remove(node).unwrap_or_else(|| vec![(1.0, rest[*node])]);
        let cuts: &[f64] = if times.jumps[*node] { &times.cuts } else { &[] };
        Some((*node, NodeTrack::through(keys, cuts)?))
    };
    Ok(wanted.iter().filter_map(track).collect())
}

/// Frames at which nodes have keys: at each whole frame, and those that turn also between them. Elements of matrices are interpolated
/// one by one, which takes turned things off their circles.
struct Times {
    /// By node: true if it, or a node above it, moves; turns; jumps.
    moves: Vec<bool>,
    turns: Vec<bool>,
    jumps: Vec<bool>,
    whole: BTreeSet<Moment>,
    quarters: BTreeSet<Moment>,
    /// Frames at which a node jumps, and these with those just before them.
    cuts: Vec<f64>,
    beside_cuts: BTreeSet<Moment>,
}

impl Times {
    fn new(tree: &Tree, clip: &Clip) -> Self {
        let animated = |is: &dyn Fn(Property, Curve) -> bool| {
            let mut flags = vec![false; tree.parents.len()];
            let of_nodes = clip.channels.iter().filter(|channel| is(channel.property, channel.curve));
            of_nodes.for_each(|channel| flags[channel.node] = true);
            tree.inherited(flags)
        };
        let whole: BTreeSet<Moment> = clip.moments(1).into_iter().map(Moment).collect();
        let quarters = whole.iter().flat_map(|at| [0.0, 0.25, 0.5, 0.75].map(|part| Moment(at.0 + part)));
        let cuts = jump_frames(clip);
        let around = |cut: &f64| [Moment(cut - JUST_BEFORE), Moment(*cut)];
        Self {
            moves: animated(&|property, _| property != Property::Weights),
            turns: animated(&|property, curve| property == Property::Rotation && curve != Curve::Step),
            jumps: animated(&|property, curve| property != Property::Weights && curve == Curve::Step),
            quarters: quarters.filter(|at| at.0 <= clip.end.ceil()).collect(),
            beside_cuts: cuts.iter().flat_map(around).collect(),
            whole,
            cuts,
        }
    }

    /// All frames at which one of `nodes` has a key.
    fn of(&self, nodes: &[usize]) -> BTreeSet<Moment> {
        let any = |flags: &[bool]| nodes.iter().any(|node| flags[*node]);
        let mut all = if any(&self.turns) { self.quarters.clone() } else { self.whole.clone() };
        if any(&self.jumps) {
            all.extend(&self.beside_cuts);
        }
        all
    }

    fn has_key(&self, node: usize, at: Moment) -> bool {
        self.whole.contains(&at)
            || self.turns[node] && self.quarters.contains(&at)
            || self.jumps[node] && self.beside_cuts.contains(&at)
    }
}

/// Maps of the `moving` nodes to the root of the scene, by frame.
fn keys(tree: &Tree, clip: &Clip, times: &Times, moving: &[usize]) -> BTreeMap<usize, Vec<(f64, DAffine3)>> {
    let mut keys: BTreeMap<usize, Vec<(f64, DAffine3)>> = BTreeMap::new();
    if moving.is_empty() {
        return keys;
    }
    for at in times.of(moving) {
        let globals = tree.globals(&clip.locals(tree, at.0));
        for node in moving.iter().filter(|node| times.has_key(**node, at)) {
            keys.entry(*node).or_default().push((at.0, globals[*node]));
        }
    }
    keys
}

/// Frame that can be ordered.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Moment(f64);

impl Eq for Moment {}

impl PartialOrd for Moment {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Moment {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// Frames at which a place jumps.
fn jump_frames(clip: &Clip) -> Vec<f64> {
    let steps = clip.channels.iter().filter(|channel| channel.curve == Curve::Step);
    let frames = steps.filter(|channel| channel.property != Property::Weights);
    let frames: BTreeSet<Moment> =
        frames.flat_map(|channel| channel.frames.iter().skip(1).map(|frame| Moment(*frame))).collect();
    frames.into_iter().map(|frame| frame.0).collect()
}

fn check_memory(document: &Document, nodes: usize, keys: usize) -> Result<(), SceneError> {
    let bytes =
        (nodes as u64).saturating_mul(keys as u64).saturating_mul(size_of::<(f64, DAffine3)>() as u64);
    let need = Need::new(Part::new(
        "the keys of the animation",
        bytes,
        "a shorter animation, fewer nodes that move",
    ));
    need.check(&memory::left()).map_err(|error| document.fault(error.to_string()))
}

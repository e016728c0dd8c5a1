//! Skeletons (UsdSkelSkeleton) and their animations: the pose of each joint, and the weights of blend shapes, by frame.

use std::collections::{BTreeSet, HashMap};

use glam::{DAffine3, DQuat, DVec3};
use openusd::sdf::Path;
use openusd::usd::{Prim, Stage};

use super::file::Clock;
use super::place::affine;
use super::value::{Answer, codes, numbers, targets, value, words};
use crate::memory::{self, Need, Part};

/// Largest number of frames of an animation.
const MOST_FRAMES: f64 = 1e6;

/// A skeleton.
pub struct Skeleton {
    pub joints: Vec<String>,
    /// Joint above each, if there is one.
    parents: Vec<Option<usize>>,
    /// All joints, parents first.
    order: Vec<usize>,
    /// Maps from the mesh to each joint as it was bound.
    inverse_binds: Vec<DAffine3>,
    /// Places of the joints below their parents if nothing moves them.
    rest: Vec<DAffine3>,
    animation: Option<Animation>,
}

/// An animation (UsdSkelAnimation).
struct Animation {
    prim: Prim,
    /// Number in the animation of each joint of the skeleton.
    joints: Vec<Option<usize>>,
    /// Names of the blend shapes whose weights it states.
    blend_shapes: Vec<String>,
    /// Frames at which it is posed, in order. Empty if it rests.
    frames: Vec<f64>,
}

/// Path of the first prim that this relationship names, of a prim or the nearest one above it that has it.
///
/// # Errors What the library says.
pub fn inherited(stage: &Stage, path: &Path, name: &str) -> Answer<Option<Path>> {
    let mut at = Some(path.clone());
    while let Some(path) = at.filter(|path| path.as_str() != "/") {
        if let Some(target) = targets(&stage.prim(path.clone()), name)?.into_iter().next() {
            return Ok(Some(target));
        }
        at = path.parent();
    }
    Ok(None)
}

impl Skeleton {
    /// Reads the skeleton at `path` with its animation.
    ///
    /// # Errors Lists that do not fit together, and what the library says.
    pub fn read(stage: &Stage, path: &Path, clock: &Clock) -> Answer<Self> {
        let prim = stage.prim(path.clone());
        let code = clock.code(clock.first());
        let joints = value(&prim, "joints", code)?.as_ref().and_then(words).unwrap_or_default();
        let binds = maps(&prim, "bindTransforms", code)?;
        if binds.len() < joints.len() {
            let (joints, binds) = (joints.len(), binds.len());
            return Err(format!(
                "the skeleton {path} has {joints} joints and {binds} bindTransforms: export the file again"
            ));
        }
        let (parents, order) = above_one_another(&joints);
        let mut rest = maps(&prim, "restTransforms", code)?;
        if rest.len() < joints.len() {
            // as they were bound: each below its parent
            let below = |(joint, parent): (usize, &Option<usize>)| {
                parent.map_or(binds[joint], |parent| binds[parent].inverse() * binds[joint])
            };
            rest = parents.iter().enumerate().map(below).collect();
        }
        let animation = match inherited(stage, path, "skel:animationSource")? {
            Some(source) => Animation::read(stage.prim(source), &joints, clock)?,
            None => None,
        };
        let inverse_binds = binds[..joints.len()].iter().map(inverse).collect();
        Ok(Self { joints, parents, order, inverse_binds, rest, animation })
    }

    /// Frames at which it is posed, in order: one alone if it rests.
    pub fn frames(&self, clock: &Clock) -> Vec<f64> {
        let moving = self.animation.as_ref().map(|animation| animation.frames.clone());
        moving.filter(|frames| !frames.is_empty()).unwrap_or_else(|| vec![clock.first()])
    }

    /// Maps of the joints, from where a mesh was bound to where it is, in the space of the skeleton.
    ///
    /// # Errors What the library says.
    pub fn pose(&self, code: f64) -> Answer<Vec<DAffine3>> {
        let locals = match &self.animation {
            Some(animation) => animation.locals(&self.rest, code)?,
            None => self.rest.clone(),
        };
        let mut globals = locals;
        for joint in &self.order {
            if let Some(parent) = self.parents[*joint] {
                globals[*joint] = globals[parent] * globals[*joint];
            }
        }
        Ok(globals.iter().zip(&self.inverse_binds).map(|(global, inverse)| *global * *inverse).collect())
    }

    /// Weights of these blend shapes; 0 for those that the animation does not name.
    ///
    /// # Errors What the library says.
    pub fn weights(&self, blend_shapes: &[String], code: f64) -> Answer<Vec<f64>> {
        let Some(animation) = &self.animation else { return Ok(vec![0.0; blend_shapes.len()]) };
        let stated = value(&animation.prim, "blendShapeWeights", code)?;
        let stated = stated.as_ref().and_then(numbers).unwrap_or_default();
        let weight = |name: &String| {
            let number = animation.blend_shapes.iter().position(|known| known == name);
            number.and_then(|number| stated.get(number)).copied().filter(|weight| weight.is_finite())
        };
        Ok(blend_shapes.iter().map(|name| weight(name).unwrap_or(0.0)).collect())
    }
}

impl Animation {
    fn read(prim: Prim, joints: &[String], clock: &Clock) -> Answer<Option<Self>> {
        let code = clock.code(clock.first());
        let list = |name: &str| -> Answer<Vec<String>> {
            Ok(value(&prim, name, code)?.as_ref().and_then(words).unwrap_or_default())
        };
        let (own, blend_shapes) = (list("joints")?, list("blendShapes")?);
        if own.is_empty() && blend_shapes.is_empty() {
            return Ok(None);
        }
        let numbers: HashMap<&String, usize> = own.iter().zip(0..).collect();
        let joints = joints.iter().map(|joint| numbers.get(joint).copied()).collect();
        let frames = frames(&prim, clock)?;
        Ok(Some(Self { prim, joints, blend_shapes, frames }))
    }

    /// Places of a skeleton's joints below their parents; those that the animation does not name are at rest.
    fn locals(&self, rest: &[DAffine3], code: f64) -> Answer<Vec<DAffine3>> {
        let list = |name: &str| -> Answer<Vec<f64>> {
            let read = value(&self.prim, name, code)?.as_ref().and_then(numbers).unwrap_or_default();
            Ok(if read.iter().all(|number| number.is_finite()) { read } else { Vec::new() })
        };
        let (translations, turns, scales) = (list("translations")?, list("rotations")?, list("scales")?);
        let local = |number: usize| {
            let three = |list: &[f64], default: DVec3| {
                list.get(3 * number..3 * number + 3).map_or(default, DVec3::from_slice)
            };
            let turn = turns.get(4 * number..4 * number + 4).map_or(DQuat::IDENTITY, DQuat::from_slice);
            let length = turn.length();
            let turn = if length.is_normal() { turn * length.recip() } else { DQuat::IDENTITY };
            let (scale, translation) = (three(&scales, DVec3::ONE), three(&translations, DVec3::ZERO));
            DAffine3::from_scale_rotation_translation(scale, turn, translation)
        };
        Ok(self.joints.iter().zip(rest).map(|(number, rest)| number.map_or(*rest, local)).collect())
    }
}

/// Frames at which an animation is posed: those of its values, and each whole one between them, since joints turn on arcs, and points
/// go straight from shape to shape.
fn frames(prim: &Prim, clock: &Clock) -> Answer<Vec<f64>> {
    let mut frames = Vec::new();
    for name in ["translations", "rotations", "scales", "blendShapeWeights"] {
        let own = codes(prim, name)?;
        if own.len() > 1 {
            frames.extend(own.iter().map(|code| clock.frame(*code)));
        }
    }
    frames.sort_by(f64::total_cmp);
    if let (Some(first), Some(last)) = (frames.first().copied(), frames.last().copied()) {
        if last - first > MOST_FRAMES {
            return Err(format!("{} moves over more frames than anybody needs", prim.path()));
        }
        let whole = (first.ceil() as i64..=last.floor() as i64).map(|frame| frame as f64);
        frames.extend(whole);
    }
    let distinct: BTreeSet<u64> = frames.iter().map(|frame| (frame + 0.0).to_bits()).collect();
    let mut frames: Vec<f64> = distinct.into_iter().map(f64::from_bits).collect();
    frames.sort_by(f64::total_cmp);
    Ok(frames)
}

/// Maps of an attribute. What is not finite is a map that does nothing.
fn maps(prim: &Prim, name: &str, code: f64) -> Answer<Vec<DAffine3>> {
    let numbers = value(prim, name, code)?.as_ref().and_then(numbers).unwrap_or_default();
    let map = |matrix: &[f64]| affine(matrix).filter(DAffine3::is_finite).unwrap_or(DAffine3::IDENTITY);
    Ok(numbers.chunks_exact(16).map(map).collect())
}

/// Inverse of a map; of a flat one, which has none, a map that does nothing.
fn inverse(map: &DAffine3) -> DAffine3 {
    let inverse = map.inverse();
    if inverse.is_finite() { inverse } else { DAffine3::IDENTITY }
}

/// The joint above each one, and all joints with those above first. Names are paths: the parent of `A/B/C` is `A/B`, or `A` if there is no
/// `A/B`.
fn above_one_another(joints: &[String]) -> (Vec<Option<usize>>, Vec<usize>) {
    let numbers: HashMap<&str, usize> = joints.iter().map(String::as_str).zip(0..).collect();
    let parent = |joint: &String| {
        let mut above = joint.as_str();
        while let Some((parent, _)) = above.rsplit_once('/') {
            if let Some(number) = numbers.get(parent) {
                return Some(*number);
            }
            above = parent;
        }
        None
    };
    let mut order: Vec<usize> = (0..joints.len()).collect();
    order.sort_by_key(|joint| joints[*joint].len());
    (joints.iter().map(parent).collect(), order)
}

/// Checks that there is memory for `frames` shapes of so many points.
///
/// # Errors If there is not.
pub fn check_memory(frames: usize, points: usize) -> Answer<()> {
    let bytes = (frames * size_of::<[f32; 3]>()) as u64 * points as u64;
    let need = Need::new(Part::new("the shapes of the model", bytes, "a shorter animation, a smaller model"));
    need.check(&memory::left()).map_err(|error| error.to_string())
}

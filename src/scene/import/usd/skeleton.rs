//! Skeletons (UsdSkelSkeleton) and their animations: the pose of each joint, and the weights of blend shapes, by frame.

use std::collections::HashMap;

use glam::DAffine3;
use openusd::sdf::Path;
use openusd::usd::{Prim, Stage};

use super::clock::Clock;
use super::place::{Places, affine};
use super::value::{Answer, codes_read, numbers, said, targets, value, words};
use crate::memory::{self, Need, Part};

/// Largest number of frames of an animation.
const MOST_FRAMES: f64 = 1e6;

/// A skeleton, in all its poses.
pub struct Skeleton {
    pub joints: Vec<String>,
    /// Names of the blend shapes whose weights its animation states.
    pub blend_shapes: Vec<String>,
    /// Its poses, by frame: one alone if it rests.
    pub keys: Vec<PoseKey>,
}

/// A skeleton at a frame.
pub struct PoseKey {
    pub frame: f64,
    /// Maps of the joints, from where a mesh was bound to where it is, in the space of the skeleton.
    pub joints: Vec<DAffine3>,
    /// Weights of the blend shapes; those that are not stated are missing.
    pub weights: Vec<f64>,
}

/// Joints at rest.
struct Rest {
    /// Joint above each, if there is one.
    parents: Vec<Option<usize>>,
    /// All joints, parents first.
    order: Vec<usize>,
    /// Maps from the mesh to each joint as it was bound.
    inverse_binds: Vec<DAffine3>,
    /// Places of the joints below their parents if nothing moves them.
    locals: Vec<DAffine3>,
}

/// An animation (UsdSkelAnimation).
struct Animation {
    prim: Prim,
    /// Number in the animation of each joint of the skeleton.
    joints: Vec<Option<usize>>,
    /// Names of the blend shapes whose weights it states.
    blend_shapes: Vec<String>,
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
    /// # Errors Lists that do not fit together, more poses than there is memory for, and what the library says.
    pub fn read(stage: &Stage, path: &Path, clock: &Clock) -> Answer<Self> {
        let prim = stage.prim(path.clone());
        let code = clock.code(clock.first());
        let joints = value(&prim, "joints", code)?.as_ref().and_then(words).unwrap_or_default();
        let binds = maps(&prim, "bindTransforms", code)?;
        if binds.len() < joints.len() {
            let (joints, binds) = (joints.len(), binds.len());
            return Err(format!("the skeleton {path} has {joints} joints and {binds} bindTransforms"));
        }
        let (parents, order) = above_one_another(&joints);
        let mut locals = maps(&prim, "restTransforms", code)?;
        if locals.len() < joints.len() {
            // as they were bound: each below its parent
            let below = |(joint, parent): (usize, &Option<usize>)| {
                parent.map_or(binds[joint], |parent| inverse(&binds[parent]) * binds[joint])
            };
            locals = parents.iter().enumerate().map(below).collect();
        }
        let inverse_binds = binds[..joints.len()].iter().map(inverse).collect();
        let rest = Rest { parents, order, inverse_binds, locals };
        let animation = match inherited(stage, path, "skel:animationSource")? {
            Some(source) => Animation::read(stage.prim(source), &joints, code)?,
            None => None,
        };
        let keys = keys(animation.as_ref(), &rest, clock)?;
        let blend_shapes = animation.map(|animation| animation.blend_shapes).unwrap_or_default();
        Ok(Self { joints, blend_shapes, keys })
    }
}

/// Poses of a skeleton at all its frames.
fn keys(animation: Option<&Animation>, rest: &Rest, clock: &Clock) -> Answer<Vec<PoseKey>> {
    let Some(animation) = animation else {
        let joints = rest.posed(rest.locals.clone());
        return Ok(vec![PoseKey { frame: clock.first(), joints, weights: Vec::new() }]);
    };
    let frames = animation.frames(clock)?;
    let bytes = size_of::<DAffine3>() as u64 * frames.len() as u64 * rest.order.len() as u64;
    said(
        Need::new(Part::new("the poses of a skeleton", bytes, "a shorter animation")).check(&memory::left()),
    )?;
    let key = |frame: f64| {
        let code = clock.code(frame);
        let joints = rest.posed(animation.locals(&rest.locals, code)?);
        Ok(PoseKey { frame, joints, weights: animation.numbers("blendShapeWeights", code)? })
    };
    frames.into_iter().map(key).collect()
}

impl Rest {
    /// Maps of the joints, from where a mesh was bound, by their places below their parents.
    fn posed(&self, mut places: Vec<DAffine3>) -> Vec<DAffine3> {
        for joint in &self.order {
            if let Some(parent) = self.parents[*joint] {
                places[*joint] = places[parent] * places[*joint];
            }
        }
        places.iter().zip(&self.inverse_binds).map(|(place, inverse)| *place * *inverse).collect()
    }
}

impl Animation {
    fn read(prim: Prim, joints: &[String], code: f64) -> Answer<Option<Self>> {
        let list = |name: &str| -> Answer<Vec<String>> {
            Ok(value(&prim, name, code)?.as_ref().and_then(words).unwrap_or_default())
        };
        let (own, blend_shapes) = (list("joints")?, list("blendShapes")?);
        if own.is_empty() && blend_shapes.is_empty() {
            return Ok(None);
        }
        let numbers: HashMap<&String, usize> = own.iter().zip(0..).collect();
        let joints = joints.iter().map(|joint| numbers.get(joint).copied()).collect();
        Ok(Some(Self { prim, joints, blend_shapes }))
    }

    /// Frames at which it is posed: those of its values, and each whole one between them, since joints turn on arcs, and points go straight
    /// from shape to shape.
    fn frames(&self, clock: &Clock) -> Answer<Vec<f64>> {
        let mut frames = Vec::new();
        for name in ["translations", "rotations", "scales", "blendShapeWeights"] {
            let own = codes_read(&self.prim, name, clock)?;
            if own.len() > 1 {
                frames.extend(own.iter().map(|code| clock.frame(*code)));
            }
        }
        let first = frames.iter().copied().fold(f64::INFINITY, f64::min);
        let last = frames.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if frames.is_empty() {
            return Ok(vec![clock.first()]);
        }
        if last - first > MOST_FRAMES {
            return Err(format!("{} moves over more frames than anybody needs", self.prim.path()));
        }
        frames.extend((first.ceil() as i64..=last.floor() as i64).map(|frame| frame as f64));
        frames.sort_by(f64::total_cmp);
        frames.dedup();
        Ok(frames)
    }

    /// Places of a skeleton's joints below their parents; those that the animation does not name are at rest.
    fn locals(&self, rest: &[DAffine3], code: f64) -> Answer<Vec<DAffine3>> {
        let places = Places {
            translations: self.numbers("translations", code)?,
            turns: self.numbers("rotations", code)?,
            scales: self.numbers("scales", code)?,
        };
        let local =
            |(number, rest): (&Option<usize>, &DAffine3)| number.map_or(*rest, |number| places.at(number));
        Ok(self.joints.iter().zip(rest).map(local).collect())
    }

    /// Numbers of an attribute; none if one is not finite.
    fn numbers(&self, name: &str, code: f64) -> Answer<Vec<f64>> {
        let read = value(&self.prim, name, code)?.as_ref().and_then(numbers).unwrap_or_default();
        Ok(if read.iter().all(|number| number.is_finite()) { read } else { Vec::new() })
    }
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

//! Animations: keyed places and weights of nodes, by frame.

use std::collections::HashSet;

use glam::{DAffine3, DQuat, DVec3};

use super::document::{Document, LARGEST_COORDINATE};
use super::json;
use super::nodes::{Local, Tree, unit};
use crate::scene::SceneError;
use crate::scene::keys::spelling;

/// Largest number of frames of an animation.
const MOST_FRAMES: f64 = 1e6;

/// Distance to a whole frame, in frames, below which a key counts as being on it: files keep seconds as single floats.
const ON_FRAME: f64 = 1e-3;

/// One animation of a file. Frame 1 is at its time 0.
#[derive(Default)]
pub struct Clip {
    pub channels: Vec<Channel>,
    /// Frame of the last key.
    pub end: f64,
}

/// Part of a node that is animated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Property {
    Translation,
    Rotation,
    Scale,
    Weights,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Curve {
    Step,
    Linear,
    Cubic,
}

/// Keys of a property of a node.
pub struct Channel {
    pub node: usize,
    pub property: Property,
    pub curve: Curve,
    /// Frames of the keys, rising; never empty.
    pub frames: Vec<f64>,
    /// Numbers of each value.
    width: usize,
    /// Values, key after key; of a cubic curve the tangent before the key, the value, and the tangent after it.
    values: Vec<f64>,
    /// Frames in a second.
    rate: f64,
}

impl Clip {
    /// Reads the animation called `name`. Without a name: the first one, and each other that moves nothing that those before it move;
    /// some programs write an animation for each object. None in a file without any.
    ///
    /// # Errors A name that the file does not have, or keys that make no sense.
    pub fn read(document: &Document, name: Option<&str>, rate: f64) -> Result<Self, SceneError> {
        let all = &document.json.animations;
        let read = |animation: &json::Animation| -> Result<Vec<Channel>, SceneError> {
            let channels =
                animation.channels.iter().map(|channel| Channel::read(document, animation, channel, rate));
            channels.filter_map(Result::transpose).collect()
        };
        let mut channels: Vec<Channel> = Vec::new();
        match name {
            Some(name) => {
                let called = |animation: &&json::Animation| animation.name.as_deref() == Some(name);
                channels = read(all.iter().find(called).ok_or_else(|| document.fault(unknown(all, name)))?)?;
            }
            None => {
                let (mut moved, mut others) = (HashSet::new(), Vec::new());
                for animation in all {
                    let more = read(animation)?;
                    let targets: Vec<(usize, Property)> =
                        more.iter().map(|channel| (channel.node, channel.property)).collect();
                    if targets.iter().any(|target| moved.contains(target)) {
                        others.push(format!("`{}`", animation.name.as_deref().unwrap_or_default()));
                        continue;
                    }
                    moved.extend(targets);
                    channels.extend(more);
                }
                note_others(document, others);
            }
        }
        let end = channels.iter().filter_map(|channel| channel.frames.last().copied()).fold(1.0, f64::max);
        Ok(Self { channels, end })
    }

    /// Times from the first to the last key: all whole frames, each divided into so many `parts`.
    pub fn moments(&self, parts: u32) -> Vec<f64> {
        let last = self.end.ceil() as u32;
        (parts..=last * parts).map(|part| f64::from(part) / f64::from(parts)).collect()
    }

    /// Maps of all nodes to their parents at a frame.
    pub fn locals(&self, tree: &Tree, frame: f64) -> Vec<DAffine3> {
        let mut changed: Vec<(usize, Local)> = Vec::new();
        let mut sorted: Vec<&Channel> =
            self.channels.iter().filter(|channel| channel.property != Property::Weights).collect();
        sorted.sort_by_key(|channel| channel.node);
        for channel in sorted {
            if changed.last().is_none_or(|(node, _)| *node != channel.node) {
                changed.push((channel.node, tree.locals[channel.node]));
            }
            let Some((_, local)) = changed.last_mut() else { continue };
            channel.apply(frame, local);
        }
        let mut locals = tree.rest.clone();
        changed.into_iter().for_each(|(node, local)| locals[node] = local.map());
        locals
    }

    /// Weights of a node's morph targets at a frame, if they are animated.
    pub fn weights(&self, node: usize, frame: f64) -> Option<Vec<f64>> {
        let of_node = |channel: &&Channel| channel.node == node && channel.property == Property::Weights;
        self.channels.iter().find(of_node).map(|channel| channel.at(frame))
    }
}

/// Records which animations are not shown.
fn note_others(document: &Document, others: Vec<String>) {
    if !others.is_empty() {
        let (count, names) = (others.len(), others.into_iter().take(20).collect::<Vec<_>>().join(", "));
        document.leave_out(format!(
            "{count} animations are not shown, which move what the first ones move: `animation` in [[model]] chooses one of them ({names})"
        ));
    }
}

fn unknown(all: &[json::Animation], name: &str) -> String {
    let known: Vec<&str> = all.iter().filter_map(|animation| animation.name.as_deref()).collect();
    let hint = spelling::hint(name, known.iter().copied());
    let list: Vec<String> = known.iter().take(20).map(|name| format!("`{name}`")).collect();
    let there = if list.is_empty() { String::from("it has none with a name") } else { list.join(", ") };
    format!("it has no animation `{name}`{hint} (there: {there})")
}

impl Channel {
    fn read(
        document: &Document,
        animation: &json::Animation,
        channel: &json::Channel,
        rate: f64,
    ) -> Result<Option<Self>, SceneError> {
        let Some(node) = channel.target.node else { return Ok(None) };
        let count = document.json.nodes.len();
        if node >= count {
            return Err(document.fault(format!(
                "an animation moves node {node}, and there are {count} nodes: export the file again (from Blender without GPU instances)"
            )));
        }
        let property = match channel.target.path.as_str() {
            "translation" => Property::Translation,
            "rotation" => Property::Rotation,
            "scale" => Property::Scale,
            "weights" => Property::Weights,
            _ => {
                document.leave_out("animations of other things than places and morph targets are not used");
                return Ok(None);
            }
        };
        let sampler = document.get(&animation.samplers, channel.sampler, "animation sampler")?;
        let bad =
            |what: &str| document.fault(format!("an animation of node {node} {what}: export the file again"));
        let curve = match sampler.interpolation.as_deref() {
            None | Some("LINEAR") => Curve::Linear,
            Some("STEP") => Curve::Step,
            Some("CUBICSPLINE") => Curve::Cubic,
            Some(_) => return Err(bad("has an unknown interpolation")),
        };
        let frames = frames(document.floats(sampler.input, 1)?, rate);
        let frames = frames
            .ok_or_else(|| bad("has times that do not rise from 0 on, or more than a million frames"))?;
        let own_width = match property {
            Property::Translation | Property::Scale => Some(3),
            Property::Rotation => Some(4),
            Property::Weights => None,
        };
        let values = document.floats(sampler.output, own_width.unwrap_or(1))?;
        let values: Vec<f64> = values.into_iter().map(f64::from).collect();
        let parts = frames.len() * if curve == Curve::Cubic { 3 } else { 1 };
        let width = own_width.unwrap_or(values.len() / parts);
        if width == 0 || values.len() != parts * width {
            return Err(bad("has not as many values as times"));
        }
        if !values.iter().all(|value| value.abs() <= LARGEST_COORDINATE) {
            return Err(bad("has values that are not finite"));
        }
        Ok(Some(Self { node, property, curve, frames, width, values, rate }))
    }

    /// Sets the property of a node at rest to that at a frame.
    fn apply(&self, frame: f64, local: &mut Local) {
        let value = self.at(frame);
        match self.property {
            Property::Translation => local.translation = DVec3::from_slice(&value),
            Property::Scale => local.scale = DVec3::from_slice(&value),
            Property::Rotation => local.rotation = unit(DQuat::from_slice(&value)),
            Property::Weights => {}
        }
    }

    /// Value at a frame.
    pub fn at(&self, frame: f64) -> Vec<f64> {
        let after = self.frames.partition_point(|key| *key <= frame);
        if after == 0 || after == self.frames.len() || self.curve == Curve::Step {
            return self.value(after.saturating_sub(1)).to_vec();
        }
        let (before, span) = (after - 1, self.frames[after] - self.frames[after - 1]);
        let share = (frame - self.frames[before]) / span;
        match (self.curve, self.property) {
            (Curve::Cubic, _) => self.cubic(before, share, span / self.rate),
            (_, Property::Rotation) => {
                let [from, to] = [before, after].map(|key| unit(DQuat::from_slice(self.value(key))));
                from.slerp(to, share).to_array().to_vec()
            }
            _ => {
                let pairs = self.value(before).iter().zip(self.value(after));
                pairs
                    .map(|(from, to)| if from == to { *from } else { from * (1.0 - share) + to * share })
                    .collect()
            }
        }
    }

    /// Value between two keys on a cubic Hermite curve; `seconds`: from key to key.
    fn cubic(&self, before: usize, t: f64, seconds: f64) -> Vec<f64> {
        let part = |key: usize, part: usize| &self.values[(3 * key + part) * self.width..][..self.width];
        let (t2, t3) = (t * t, t * t * t);
        let [from, leaving, arriving, to] =
            [part(before, 1), part(before, 2), part(before + 1, 0), part(before + 1, 1)];
        let blended = (0..self.width).map(|i| {
            (2.0 * t3 - 3.0 * t2 + 1.0) * from[i]
                + seconds * (t3 - 2.0 * t2 + t) * leaving[i]
                + (3.0 * t2 - 2.0 * t3) * to[i]
                + seconds * (t3 - t2) * arriving[i]
        });
        blended.collect()
    }

    fn value(&self, key: usize) -> &[f64] {
        let at = if self.curve == Curve::Cubic { 3 * key + 1 } else { key };
        &self.values[at * self.width..][..self.width]
    }
}

/// Frames of times in seconds. `None` if they do not rise, or are out of bounds.
fn frames(seconds: Vec<f32>, rate: f64) -> Option<Vec<f64>> {
    let exact: Vec<f64> = seconds.iter().map(|seconds| 1.0 + f64::from(*seconds) * rate).collect();
    let snapped = exact.iter().map(|frame| {
        let whole = frame.round();
        if (frame - whole).abs() < ON_FRAME { whole } else { *frame }
    });
    let snapped: Vec<f64> = snapped.collect();
    let rise = |frames: &[f64]| frames.windows(2).all(|pair| pair[0] < pair[1]);
    let frames = if rise(&snapped) { snapped } else { exact };
    let in_bounds = frames.iter().all(|frame| (1.0 - ON_FRAME..=MOST_FRAMES).contains(frame));
    (!frames.is_empty() && in_bounds && rise(&frames)).then_some(frames)
}

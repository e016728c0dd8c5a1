//! Parts of a scene's emitting triangles: neighbours that are chosen together, by how near they are.
//!
//! A lamp far away lights a surface less than one beside it, and among thousands of triangles none can be weighed
//! for each ray. So the triangles are divided where they lie apart, into parts, each a [source](Source) of its own. Like
//! the triangles' probabilities, parts are those of the shot.

use std::ops::Range;

use glam::{DVec3, Vec3};

use super::light_chances::{LightChances, Sent, Source};
use super::neighbours::{Item, divide};
use crate::cumulative::Steps;
use crate::geometry::Bounds;
use crate::scene::render_space::Extent;
use crate::scene::{Model, Scene};

/// Greatest number of parts: within one all triangles seem equally near.
const MOST_PARTS: usize = 1024;

/// Least length of a part that is divided, as a share of the scene's. A single small lamp is one part, and costs
/// nothing.
const LEAST_LENGTH: f64 = 1.0 / 32.0;

/// Triangle that emits light.
#[derive(Debug, Clone, Copy)]
pub struct EmitterTriangle {
    /// Number of its model.
    pub model: u32,
    /// Its number in the model's mesh.
    pub triangle: u32,
    /// Light that it sends, relative to others.
    pub weight: f64,
    /// Its middle, world space; of a model that moves, the middle of its way.
    pub place: DVec3,
    /// Distance from that place within which it is in some frame.
    pub reach: f64,
    /// Its normal, unit length, world space; zero if it turns.
    pub normal: Vec3,
}

/// Triangles by part.
#[derive(Debug, Clone, Default)]
pub struct EmitterParts {
    chances: LightChances,
    parts: Vec<Part>,
    /// Model and triangle, part by part.
    triangles: Vec<(u32, u32)>,
    /// Parts of each model's triangles; empty if there is one part alone.
    of_models: Vec<PartsOfModel>,
}

#[derive(Debug, Clone)]
struct Part {
    /// Index of its first triangle.
    first: usize,
    /// Probability of each of its triangles.
    choices: Steps,
    /// Share of the light of all.
    share: f32,
}

/// Parts of a model's triangles.
#[derive(Debug, Clone, Default)]
enum PartsOfModel {
    #[default]
    None,
    /// All are of one.
    One(usize),
    /// Part by triangle, in rising order of these.
    Each(Vec<(u32, usize)>),
}

impl EmitterParts {
    /// Divides `triangles` of `scene`, all of which emit. `bounds`: of its models, object space.
    pub fn new(scene: &Scene, bounds: &[Bounds], mut triangles: Vec<EmitterTriangle>) -> Self {
        if triangles.is_empty() {
            return Self::default();
        }
        let item = |each: &EmitterTriangle| Item { place: each.place, weight: each.weight };
        let ranges = divide(&mut triangles, item, LEAST_LENGTH * length_of(scene, bounds), MOST_PARTS);
        let weight = |triangles: &[EmitterTriangle]| triangles.iter().map(|each| each.weight).sum::<f64>();
        let total = weight(&triangles);
        let part = |range: &Range<usize>| {
            let weights: Vec<f64> = triangles[range.clone()].iter().map(|each| each.weight).collect();
            let (choices, sum) = Steps::new(&weights, 0.0);
            Part { first: range.start, choices, share: (sum / total) as f32 }
        };
        let parts: Vec<Part> = ranges.iter().map(part).collect();
        let source = |(range, part): (&Range<usize>, &Part)| {
            let extent = extent_of(&triangles[range.clone()]);
            let reach = triangles[range.clone()].iter().map(|each| each.reach).fold(0.0, f64::max);
            let reach = reach + 0.25 * extent.diagonal();
            let source = Source::around(extent.center().as_vec3(), reach as f32, part.share);
            match axis_of(&triangles[range.clone()]) {
                Some(axis) => source.flat(axis),
                None => source,
            }
        };
        let sources: Vec<Source> = ranges.iter().zip(&parts).map(source).collect();
        let of_models = if parts.len() < 2 {
            Vec::new()
        } else {
            parts_of_models(scene.models.len(), &triangles, &ranges)
        };
        let triangles = triangles.iter().map(|each| (each.model, each.triangle)).collect();
        Self { chances: LightChances::new(&sources), parts, triangles, of_models }
    }

    /// Returns true if there are none.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Chooses a triangle for a surface at `point` by a `random` number from 0 to below 1: its model and number,
    /// and how many times as likely it is as by its light alone. There is at least one. `sent`: what is known of
    /// the last surface that has chosen one of these.
    pub fn choose(&self, point: Vec3, random: f32, sent: &mut Sent) -> ((u32, u32), f32) {
        let chosen = self.chances.choose_again(point, random, sent);
        let part = &self.parts[chosen.source];
        let triangle = self.triangles[part.first + part.choices.find(chosen.rest).index];
        (triangle, if self.parts.len() < 2 { 1.0 } else { chosen.chance / part.share })
    }

    /// How many times as likely a surface at `point` chooses a triangle of a model as by its light alone.
    pub fn likelihood(&self, point: Vec3, model: u32, triangle: u32) -> f32 {
        let part = match self.of_models.get(model as usize) {
            None => return 1.0,
            Some(PartsOfModel::None) => return 0.0,
            Some(PartsOfModel::One(part)) => *part,
            Some(PartsOfModel::Each(parts)) => match parts.binary_search_by_key(&triangle, |each| each.0) {
                Ok(at) => parts[at].1,
                Err(_) => return 0.0,
            },
        };
        self.chances.of(point, part) / self.parts[part].share
    }
}

/// Normal that all of `triangles` have, to either side, if they have one.
fn axis_of(triangles: &[EmitterTriangle]) -> Option<Vec3> {
    let axis = triangles.first()?.normal;
    // of a slightly bent panel, too
    let has = |each: &EmitterTriangle| each.normal.dot(axis).abs() > 0.95;
    triangles.iter().all(has).then_some(axis)
}

/// Box around the places of `triangles`.
fn extent_of(triangles: &[EmitterTriangle]) -> Extent {
    triangles.iter().fold(Extent::NONE, |extent, each| extent.with(each.place))
}

/// Length of the scene where its models begin: the longest edge of a box around what is not endless. `bounds`: of
/// the models, object space.
fn length_of(scene: &Scene, bounds: &[Bounds]) -> f64 {
    let has_size = |(model, bounds): &(&Model, &Bounds)| !model.mesh.is_curved() && !bounds.is_empty();
    let all = scene.models.iter().zip(bounds).filter(has_size).fold(Extent::NONE, |all, (model, bounds)| {
        let first = model.track.key_frames().into_iter().fold(f64::INFINITY, f64::min);
        all.with_model_at((bounds.low.as_dvec3(), bounds.high.as_dvec3()), &model.track, first)
    });
    all.size().max_element()
}

fn parts_of_models(
    count: usize,
    triangles: &[EmitterTriangle],
    ranges: &[Range<usize>],
) -> Vec<PartsOfModel> {
    let mut each: Vec<Vec<(u32, usize)>> = vec![Vec::new(); count];
    for (part, range) in ranges.iter().enumerate() {
        for EmitterTriangle { model, triangle, .. } in &triangles[range.clone()] {
            each[*model as usize].push((*triangle, part));
        }
    }
    let of_model = |mut parts: Vec<(u32, usize)>| match parts.first() {
        None => PartsOfModel::None,
        Some((_, first)) if parts.iter().all(|(_, part)| part == first) => PartsOfModel::One(*first),
        Some(_) => {
            parts.sort_unstable();
            parts.shrink_to_fit();
            PartsOfModel::Each(parts)
        }
    };
    each.into_iter().map(of_model).collect()
}

//! Light on surfaces, seen by the eye or by a ray that has bounced: sums direct light, and dims ambient
//! light.

use glam::Vec3;
use wide::u32x8;

use crate::exposure::{MIDDLE_TICK, Tick};
use crate::frame::grid::bits::set_bits;
use crate::frame::shot::frame_view::{FrameView, Occlusion};
use crate::frame::shot::links::OF_EYE;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::media::Media;
use crate::pose::LightPose;
use crate::samples::EMPTY;
use crate::scene::look::Look;
use crate::shade::area::{Glow, glow};
use crate::shade::bsdf::phong::Gloss;
use crate::shade::light::{LightSample, StratifiedPattern, light_sample};

/// Area lights that a ray (unit length) passes through within `far`, each with its number and its direction from
/// `asked_from`, the point from which next-event estimation asked for light: their densities are those at that
/// point. Area lights are light alone: no ray ends at them.
pub fn lights_passed(
    lights: &[LightPose],
    asked_from: Vec3,
    (origin, direction): (Vec3, Vec3),
    far: f32,
) -> impl Iterator<Item = (usize, Glow, Vec3)> + '_ {
    let areas = lights.iter().enumerate().filter(|(_, light)| light.shape.is_area());
    areas.filter_map(move |(number, light)| {
        // if nothing is in the way, a light at infinity is seen, too
        let passed = glow(light, origin, direction).filter(|glow| glow.distance <= far)?;
        if asked_from == origin || passed.distance == f32::INFINITY {
            return Some((number, passed, direction));
        }
        let straight = (origin + direction * passed.distance - asked_from).normalize_or(direction);
        // from there the light's dark side may be seen, for which nobody asks
        let density = glow(light, asked_from, straight).map_or(0.0, |asked| asked.density);
        Some((number, Glow { density, ..passed }, straight))
    })
}

/// Mask of those of eight surfaces that show `light` by a highlight. Where rays go on, they meet an area
/// light itself.
#[inline(always)]
pub fn shows_highlight(frame: &FrameView, light: &LightPose, gloss: &Gloss) -> Mask {
    if frame.settings.depth > 0 && light.shape.is_area() { !gloss.goes_on } else { Mask::ALL }
}

/// Emission of eight surfaces, and the ambient light that they reflect, dimmed by their openness if the shot
/// says so.
#[inline]
pub fn emitted_and_ambient(
    frame: &FrameView,
    (looks, reflectance): (&[Look], Vec3x8),
    openness: impl FnOnce() -> F32x8,
) -> Vec3x8 {
    match frame.occlusion {
        Some(Occlusion { dims_ambient: true, .. }) => {
            frame.palette.emitted_and_occluded(looks, reflectance, openness())
        }
        _ => frame.palette.emitted_and_ambient(looks, reflectance),
    }
}

/// [`emitted_and_ambient`] of eight samples of `models` as the eye sees it: what some of them emit may be dark.
#[inline]
pub fn of_itself(
    frame: &FrameView,
    models: &[u32],
    (looks, reflectance): (&[Look], Vec3x8),
    openness: impl Fn() -> F32x8,
) -> Vec3x8 {
    let light = emitted_and_ambient(frame, (looks, reflectance), &openness);
    if !frame.has_linked_emission() {
        return light;
    }
    let shows = Mask::new(|lane| models[lane] >= EMPTY || frame.sees_emission(OF_EYE, models[lane]));
    let is_occluded = frame.occlusion.is_some_and(|occlusion| occlusion.dims_ambient);
    let openness = if is_occluded { openness() } else { F32x8::ONE };
    shows.select3(light, frame.palette.ambient_alone(looks, reflectance, openness))
}

/// Light of a point, by number, of a light that eight surfaces at `points` see at their `ticks`. `seeds`: as of [`Places`].
#[inline(always)]
pub fn sample_of_light(
    frame: &FrameView,
    (light, point): (usize, usize),
    ticks: impl FnOnce() -> [Tick; LANES],
    (points, seeds): (Vec3x8, u32x8),
) -> LightSample {
    let mut all: Option<LightSample> = None;
    frame.pose.each_of_light(light, ticks, |light, bits| {
        let of_pose = light_sample(light, point, &StratifiedPattern::of_seeds(light, seeds), points);
        all = Some(all.map_or(of_pose, |others| of_pose.where_set(Mask::from_bits(bits), &others)));
    });
    all.expect("eight surfaces see the light at some tick")
}

/// Places of eight surfaces.
#[derive(Debug, Clone, Copy)]
pub struct Places {
    /// World space.
    pub point: Vec3x8,
    /// Seeds for the choice of points on an area light: see [`StratifiedPattern`].
    pub seeds: u32x8,
    /// Ticks at which they are lit; any, where there are no media.
    ticks: [Tick; LANES],
}

impl Places {
    /// Surfaces at these points. `ticks`: at which they are lit.
    #[inline(always)]
    pub fn new(
        frame: &FrameView,
        (point, seeds): (Vec3x8, u32x8),
        ticks: impl FnOnce() -> [Tick; LANES],
    ) -> Self {
        Self { point, seeds, ticks: if frame.media.is_some() { ticks() } else { [MIDDLE_TICK; LANES] } }
    }
}

/// Adds to `sum` what `shade` makes of the light from those points of `light` that reach the surfaces. The
/// points are added in their order, so that the sum is always the same to the bit. `reached` gives the mask
/// of surfaces that a point, by number, reaches.
#[inline(always)]
pub fn add_light(
    frame: &FrameView,
    sum: Vec3x8,
    light: &LightPose,
    places: Places,
    reached: impl Fn(usize) -> Mask,
    shade: impl Fn(&LightSample) -> Vec3x8,
) -> Vec3x8 {
    let pattern = StratifiedPattern::of_seeds(light, places.seeds);
    (0..light.points).fold(sum, |sum, point| {
        let reached = reached(point);
        if !reached.any() {
            return sum;
        }
        let light_sample = light_sample(light, point, &pattern, places.point);
        let mut light = shade(&light_sample);
        if let Some(media) = frame.media {
            light = light * left_of(media, &places, &light_sample, reached);
        }
        sum + reached.select3(light, Vec3x8::ZERO)
    })
}

/// Share of a light that media leave on its way to those of eight places that it has `reached`.
fn left_of(media: &Media, places: &Places, light: &LightSample, reached: Mask) -> Vec3x8 {
    let mut left = Vec3x8::ZERO;
    for lane in set_bits(reached.bits() & light.irradiance.is_some().bits()) {
        let way = (places.point.lane(lane), light.to_light.lane(lane));
        left.set_lane(lane, media.left(way, light.far, places.ticks[lane]));
    }
    left
}

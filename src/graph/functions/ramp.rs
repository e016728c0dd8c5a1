//! Blender's Color Ramp node.
//!
//! Blender interpolates the stops. Cycles samples that at 257 places, and draws straight lines between the samples, or steps for a
//! constant interpolation. [`Ramp::value`] is what Cycles shows, and so a step is up to 1/256 away from its stop.
use super::color::{hsl_to_rgb, hsv_to_rgb, rgb_to_hsl, rgb_to_hsv};
use super::curve::SAMPLES;
use super::{finite, fraction, mix, named};
use crate::lanes::{F32x8, LANES, Vec3x8};
use glam::Vec3;

named! {
    /// How a colour ramp of mode RGB gets from a stop to the next one.
    Interpolation {
        /// It keeps the colour of the stop before.
        Constant = "constant",
        /// In a straight line.
        Linear = "linear",
        /// By `3 t^2 - 2 t^3`.
        Ease = "ease",
        /// By a cardinal spline through the stops.
        Cardinal = "cardinal",
        /// By a cubic B-spline, which does not reach the stops.
        BSpline = "b_spline",
    }
}

named! {
    /// Which way round the circle of hues a colour ramp of mode HSV or HSL gets from a stop to the next one.
    Hue {
        /// The shorter way.
        Near = "near",
        /// The longer way.
        Far = "far",
        /// Towards larger hues.
        Clockwise = "cw",
        /// Towards smaller hues.
        Counterclockwise = "ccw",
    }
}

/// What a colour ramp interpolates. Only RGB heeds the interpolation, apart from [`Interpolation::Constant`] (see [`Ramp::value`]):
/// hue, saturation, and value or lightness go straight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mode {
    /// Red, green, blue.
    Rgb,
    /// Hue, saturation, value.
    Hsv(Hue),
    /// Hue, saturation, lightness.
    Hsl(Hue),
}

impl Mode {
    /// The mode with Blender's identifiers in small letters, such as "hsv" and "near"; `None` for any other names.
    pub fn named(mode: &str, hue: &str) -> Option<Self> {
        let hue = Hue::named(hue)?;
        match mode {
            "rgb" => Some(Self::Rgb),
            "hsv" => Some(Self::Hsv(hue)),
            "hsl" => Some(Self::Hsl(hue)),
            _ => None,
        }
    }
}

/// A stop of a colour ramp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Where it is: 0 to 1.
    pub position: f32,
    /// Linear RGB, and alpha.
    pub color: [f32; 4],
}

/// A colour ramp.
#[derive(Clone, Debug, PartialEq)]
pub struct Ramp {
    stops: Vec<Stop>,
    interpolation: Interpolation,
    mode: Mode,
    samples: Vec<[f32; 4]>,
}

impl Ramp {
    /// The ramp of stops, in any order: it sorts them, and keeps the order of those at the same place. None make a ramp of 0.
    pub fn new(mut stops: Vec<Stop>, interpolation: Interpolation, mode: Mode) -> Self {
        stops.sort_by(|a, b| a.position.total_cmp(&b.position));
        let mut ramp = Self { stops, interpolation, mode, samples: Vec::new() };
        ramp.samples = (0..SAMPLES).map(|sample| ramp.exact(sample as f32 / (SAMPLES - 1) as f32)).collect();
        ramp
    }

    /// Linear RGB and alpha at places, as Cycles shows them. Places are clamped to 0 to 1. With [`Interpolation::Constant`] there
    /// are steps between the samples, whatever the mode.
    pub fn value(&self, at: F32x8) -> [F32x8; 4] {
        let place = at.finite_or_zero().clamp(0.0, 1.0) * (SAMPLES - 1) as f32;
        let [here, next] = [0, 1].map(|step| self.samples_at(place, step));
        match self.interpolation {
            Interpolation::Constant => here,
            // behind the last sample there is nothing of it left
            _ => std::array::from_fn(|channel| mix::float(fraction(place), here[channel], next[channel])),
        }
    }

    /// The samples so many steps after places, which are numbers of samples.
    #[inline(always)]
    fn samples_at(&self, place: F32x8, step: usize) -> [F32x8; 4] {
        let numbers = place.to_whole().to_array();
        match place.is_same() {
            true => self.sample(numbers[0], step).map(F32x8::splat),
            false => self.gathered(numbers, step),
        }
    }

    /// The samples of eight numbers. Not inlined, so that nothing of it is done where one does.
    #[inline(never)]
    fn gathered(&self, numbers: [i32; LANES], step: usize) -> [F32x8; 4] {
        let of_lanes = numbers.map(|number| self.sample(number, step));
        std::array::from_fn(|channel| F32x8::new(of_lanes.map(|sample| sample[channel])))
    }

    #[inline(always)]
    fn sample(&self, number: i32, step: usize) -> [f32; 4] {
        self.samples[(number as usize + step).min(SAMPLES - 1)]
    }

    /// Linear RGB and alpha at a place, as Blender's own `ColorRamp.evaluate` gives them. Places are clamped to 0 to 1.
    pub fn exact(&self, at: f32) -> [f32; 4] {
        let at = finite(at).clamp(0.0, 1.0);
        let (Some(first), Some(last)) = (self.stops.first(), self.stops.last()) else { return [0.0; 4] };
        let next = self.stops.partition_point(|stop| stop.position <= at);
        match (self.mode, self.interpolation) {
            (Mode::Rgb, Interpolation::Cardinal) if self.stops.len() > 1 => {
                return self.splined(at, next, cardinal);
            }
            (Mode::Rgb, Interpolation::BSpline) if self.stops.len() > 1 => {
                return self.splined(at, next, b_spline);
            }
            _ if at <= first.position => return first.color,
            _ => {}
        }
        let Some(end) = self.stops.get(next) else { return last.color };
        let start = &self.stops[next - 1];
        let t = (at - start.position) / (end.position - start.position);
        match self.mode {
            Mode::Rgb => match self.interpolation {
                Interpolation::Constant => start.color,
                Interpolation::Ease => straight(start.color, end.color, one(super::map_range::smoothstep, t)),
                _ => straight(start.color, end.color, t),
            },
            Mode::Hsv(way) => hued(start.color, end.color, t, way, rgb_to_hsv, hsv_to_rgb),
            Mode::Hsl(way) => hued(start.color, end.color, t, way, rgb_to_hsl, hsl_to_rgb),
        }
    }

    /// A spline of four stops; Blender clamps what it gives to 0 to 1. Beyond the first and last stop there are copies of them, at the
    /// ends of the ramp.
    fn splined(&self, at: f32, next: usize, weights: fn(f32) -> [f32; 4]) -> [f32; 4] {
        let last = self.stops.len() - 1;
        let start = if next == 0 { 0.0 } else { self.stops[next - 1].position };
        let end = self.stops.get(next).map_or(1.0, |stop| stop.position);
        let t = if end > start { ((at - start) / (end - start)).clamp(0.0, 1.0) } else { 0.0 };
        let weights = weights(t);
        let stop = |offset: usize| self.stops[(next + offset).saturating_sub(2).min(last)].color;
        let colors = [stop(0), stop(1), stop(2), stop(3)];
        channels(|channel| {
            finite(weights.iter().zip(colors).map(|(weight, color)| weight * color[channel]).sum::<f32>())
                .clamp(0.0, 1.0)
        })
    }
}

/// A colour from each of its four channels.
fn channels(channel: impl Fn(usize) -> f32) -> [f32; 4] {
    std::array::from_fn(channel)
}

fn straight(a: [f32; 4], b: [f32; 4], t: f32) -> [f32; 4] {
    channels(|channel| mixed(t, a[channel], b[channel]))
}

/// A mixture of two numbers.
fn mixed(t: f32, a: f32, b: f32) -> f32 {
    let [t, a, b] = [t, a, b].map(F32x8::splat);
    mix::float(t, a, b).lane(0)
}

/// A function of eight numbers, of one.
fn one(function: fn(F32x8) -> F32x8, of: f32) -> f32 {
    function(F32x8::splat(of)).lane(0)
}

/// Two colours, mixed in a space whose first channel is a hue.
fn hued(
    a: [f32; 4],
    b: [f32; 4],
    t: f32,
    way: Hue,
    into: fn(Vec3x8) -> Vec3x8,
    back: fn(Vec3x8) -> Vec3x8,
) -> [f32; 4] {
    let convert = |convert: fn(Vec3x8) -> Vec3x8, color: [f32; 3]| {
        convert(Vec3x8::splat(Vec3::from(color))).lane(0).to_array()
    };
    let [from, to] = [a, b].map(|[red, green, blue, _]| convert(into, [red, green, blue]));
    let [red, green, blue] =
        convert(back, [turned(from[0], to[0], t, way), mixed(t, from[1], to[1]), mixed(t, from[2], to[2])]);
    [red, green, blue, mixed(t, a[3], b[3])]
}

/// A hue between two hues, 0 to 1.
fn turned(from: f32, to: f32, t: f32, way: Hue) -> f32 {
    let ahead = to - from;
    let turn = match way {
        Hue::Near if ahead > 0.5 => ahead - 1.0,
        Hue::Near if ahead < -0.5 => ahead + 1.0,
        Hue::Near => ahead,
        Hue::Far if ahead > 0.0 && ahead < 0.5 => ahead - 1.0,
        Hue::Far if ahead <= 0.0 && ahead > -0.5 => ahead + 1.0,
        Hue::Far => ahead,
        Hue::Clockwise if ahead < 0.0 => ahead + 1.0,
        Hue::Clockwise => ahead,
        Hue::Counterclockwise if ahead > 0.0 => ahead - 1.0,
        Hue::Counterclockwise => ahead,
    };
    one(fraction, from + turn * t)
}

/// The weights of four stops at a place between the second and the third: a cardinal spline with Blender's tension.
fn cardinal(t: f32) -> [f32; 4] {
    const TENSION: f32 = 0.71;
    let (t2, t3) = (t * t, t * t * t);
    [
        TENSION * (2.0 * t2 - t3 - t),
        (2.0 - TENSION) * t3 + (TENSION - 3.0) * t2 + 1.0,
        (TENSION - 2.0) * t3 + (3.0 - 2.0 * TENSION) * t2 + TENSION * t,
        TENSION * (t3 - t2),
    ]
}

/// The weights of four stops at a place between the second and the third: a uniform cubic B-spline.
fn b_spline(t: f32) -> [f32; 4] {
    let (t2, t3, rest) = (t * t, t * t * t, 1.0 - t);
    [rest * rest * rest / 6.0, 0.5 * t3 - t2 + 2.0 / 3.0, 0.5 * (t + t2 - t3) + 1.0 / 6.0, t3 / 6.0]
}

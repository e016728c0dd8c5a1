//! Stereo: the places of two eyes beside the shot's camera, and the window through which each looks.
//!
//! Both cameras look along the shot's view axis. They stand `separation` apart, each half of it from the
//! shot's camera, and their pictures are shifted within the lens (off axis) so that both show the same
//! rectangle at the distance `convergence`: points there have the same place in both pictures, and in that of
//! the shot's camera, too. Cameras that are turned towards each other instead (toed in) would see that
//! rectangle as two different trapezoids, whose rows do not match.

use serde::{Deserialize, Serialize};

/// Two eyes, in the units of the shot's files.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Stereo {
    /// Distance from the left eye to the right one, above 0.
    pub separation: f64,
    /// Distance along the view axis at which both pictures agree, above 0. `None` for infinity, where windows
    /// are not shifted.
    pub convergence: Option<f64>,
}

/// Eye that sees a picture. The one eye of a shot that is not in stereo is the left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Eye {
    /// Left eye, which sees a frame first.
    Left,
    /// Right eye, whose pictures are made from the left eye's samples.
    Right,
}

impl Eye {
    /// Both eyes, in the order in which they see a frame.
    pub const BOTH: [Self; 2] = [Self::Left, Self::Right];
    /// Names of both, in that order: those of their views in files.
    pub const NAMES: [&'static str; 2] = ["left", "right"];

    /// Name of its view in files.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }
}

/// Place of an eye, or of a point of a lens, beside a camera, and its window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EyePlace {
    /// Offset to the right of the camera and up, world units.
    pub aside: [f64; 2],
    /// Offset of the centre of its picture from the view axis, to the right and up, at distance 1.
    pub window: [f64; 2],
    /// Width of the picture over its height, or 1 if that is less: shifts are shares of the longer side.
    pub longer: f64,
    /// Further shift of the lens, whatever the window: shares of the picture's longer side.
    pub shift: [f64; 2],
}

impl Stereo {
    /// Message for a camera that has no place for two eyes.
    pub const ORTHOGRAPHIC: &'static str = "an orthographic camera shows no depth: both eyes would see one picture, shifted; \
                                            take a perspective camera for stereo";
    /// Range of separations and convergences, in any unit: beyond it, single floats lose them.
    const LENGTHS: std::ops::RangeInclusive<f64> = 1e-18..=1e18;
    /// Largest ratio of separation to convergence: beyond it, no window is left before the eyes.
    const WIDEST: f64 = 10.0;

    /// Describes what is wrong with it, if anything, and what to do.
    pub fn fault(&self) -> Option<String> {
        let Self { separation, convergence } = *self;
        let (least, most) = Self::LENGTHS.into_inner();
        let lengths = [("separation", Some(separation)), ("convergence", convergence)];
        for (name, length) in lengths.into_iter().filter_map(|(name, length)| Some((name, length?))) {
            if !Self::LENGTHS.contains(&length) {
                return Some(format!(
                    "a {name} of {length} is no distance: give a length from {least:e} to {most:e}, in the units of the models, \
                     or leave stereo out for one eye"
                ));
            }
        }
        let convergence = convergence.filter(|convergence| separation > convergence * Self::WIDEST)?;
        Some(format!(
            "the eyes are {separation} apart and converge at a distance of {convergence}: take a separation of {} at most, or a \
             larger convergence",
            convergence * Self::WIDEST
        ))
    }

    /// Place of `eye`. `to_world` converts a length; `size`: columns and rows of the picture.
    pub fn place(&self, eye: Eye, to_world: impl Fn(f64) -> f64, size: [u32; 2]) -> EyePlace {
        let half = match eye {
            Eye::Left => -0.5 * self.separation,
            Eye::Right => 0.5 * self.separation,
        };
        let [width, height] = size.map(f64::from);
        EyePlace {
            aside: [to_world(half), 0.0],
            window: [self.convergence.map_or(0.0, |distance| -half / distance), 0.0],
            longer: (width / height).max(1.0),
            shift: [0.0; 2],
        }
    }
}

impl EyePlace {
    /// Place of a point of a lens, `self`, for a camera that stands in the place `of_eye` itself, in the same
    /// picture.
    pub fn in_eye(self, of_eye: Option<&Self>) -> Self {
        let Some(eye) = of_eye else { return self };
        let sum = |one: [f64; 2], other: [f64; 2]| [one[0] + other[0], one[1] + other[1]];
        Self {
            aside: sum(self.aside, eye.aside),
            window: sum(self.window, eye.window),
            longer: self.longer,
            shift: sum(self.shift, eye.shift),
        }
    }

    /// Shift that the eye adds to that of the lens, to the right and up, for a camera that sees as far as
    /// `half_height` above its axis at distance 1: shares of the picture's longer side.
    pub fn shift(&self, half_height: f64) -> [f64; 2] {
        let at_window = self.window.map(|window| window / (2.0 * half_height * self.longer));
        [at_window[0] + self.shift[0], at_window[1] + self.shift[1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_eyes_show_one_rectangle_where_they_converge() {
        let stereo = Stereo { separation: 0.5, convergence: Some(4.0) };
        for size in [[200, 100], [100, 200]] {
            let [left, right] = Eye::BOTH.map(|eye| stereo.place(eye, |length| length * 2.0, size));
            assert_eq!((left.aside, right.aside), ([-0.5, 0.0], [0.5, 0.0]), "world units");
            // 53 degrees from top to bottom: at distance 4 the picture is 4 high
            let half_height = 0.5;
            let longer = 4.0 * f64::max(f64::from(size[0]) / f64::from(size[1]), 1.0);
            for (eye, aside) in [(left, -0.25), (right, 0.25)] {
                let middle = aside + eye.shift(half_height)[0] * longer;
                assert!(middle.abs() < 1e-12, "{size:?}: {middle}");
            }
        }
        let faulty = |separation, convergence| Stereo { separation, convergence }.fault();
        assert_eq!(stereo.fault(), None);
        for (separation, convergence, word) in [
            (0.0, None, "separation of 0"),
            (-1.0, None, "separation of -1"),
            (f64::NAN, Some(1.0), "NaN"),
            (f64::INFINITY, None, "inf"),
            (1.0, Some(0.0), "convergence of 0"),
            (1.0, Some(-2.0), "convergence of -2"),
            (1.0, Some(0.01), "0.1 at most"),
        ] {
            let fault = faulty(separation, convergence).expect(word);
            assert!(fault.contains(word), "{fault}");
        }
        let parallel = Stereo { convergence: None, ..stereo };
        assert_eq!(parallel.place(Eye::Left, |length| length, [4, 3]).shift(1.0), [0.0; 2]);
    }
}

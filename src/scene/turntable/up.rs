//! Guesses the axis of a model's file that points up: the one along which the model stands best.

use std::fmt;

use glam::{DVec3, Vec3A};

use super::corners::Corners;

/// Axis of a file that points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Up {
    /// Y, as in most OBJ files.
    #[default]
    Y,
    /// Z, as some CAD and modelling programs write.
    Z,
}

/// Share of a model's height above its lowest point within which its points count as touching the ground.
const CONTACT: f32 = 0.015;
/// Stability beyond which more does not count: half the width of the model's support, in heights of its
/// centre.
const SAFE: f64 = 0.3;
/// Factor by which the model must stand better along Z than along Y for Z to be up; and the least standing
/// that counts at all.
const CLEARLY: f64 = 1.5;
const LEAST: f64 = 0.01;

impl fmt::Display for Up {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Y => "y",
            Self::Z => "z",
        })
    }
}

impl Up {
    /// Guesses the axis that points up.
    pub(super) fn guess(corners: &Corners<'_>) -> Self {
        let (low, high) = corners.bounds();
        let center = corners.center();
        let contacts = Contacts::new(corners, (low, high));
        let [y, z] = [1, 2].map(|axis| contacts.standing((low, high), center, axis));
        if z > LEAST && z > CLEARLY * y { Self::Z } else { Self::Y }
    }
}

/// Boxes around the lowest and the highest points along Y, and along Z.
#[derive(Debug, Clone, Copy)]
struct Contacts([[(Vec3A, Vec3A); 2]; 2]);

impl Contacts {
    fn new(corners: &Corners<'_>, (low, high): (DVec3, DVec3)) -> Self {
        let (low, high) = (low.as_vec3a(), high.as_vec3a());
        let rim = (high - low) * CONTACT;
        let nothing = Self([[(Vec3A::INFINITY, Vec3A::NEG_INFINITY); 2]; 2]);
        let with = |mut all: Self, point: Vec3A| {
            for (which, axis) in [1, 2].into_iter().enumerate() {
                let touches = [point[axis] <= low[axis] + rim[axis], point[axis] >= high[axis] - rim[axis]];
                for (bounds, touches) in all.0[which].iter_mut().zip(touches) {
                    if touches {
                        *bounds = (bounds.0.min(point), bounds.1.max(point));
                    }
                }
            }
            all
        };
        let joined = |a: Self, b: Self| {
            let join = |which: usize, side: usize| {
                let (a, b) = (a.0[which][side], b.0[which][side]);
                (a.0.min(b.0), a.1.max(b.1))
            };
            Self(std::array::from_fn(|which| std::array::from_fn(|side| join(which, side))))
        };
        corners.fold(nothing, with, joined)
    }

    /// Rates how well the model stands along `axis`: the share of its outline that touches the ground, how
    /// safely, and how much better than on its head. A thing that is the same upside down, such as a box or a
    /// sheet, stands along no axis better than along another.
    fn standing(&self, (low, high): (DVec3, DVec3), center: DVec3, axis: usize) -> f64 {
        let [foot, head] = self.0[axis - 1].map(|(low, high)| (low.as_dvec3(), high.as_dvec3()));
        let others = (0..3).filter(|other| *other != axis);
        let share = |of: (DVec3, DVec3)| -> f64 {
            let ratio = |other: usize| {
                let whole = high[other] - low[other];
                if whole > 0.0 { (of.1[other] - of.0[other]) / whole } else { 1.0 }
            };
            others.clone().map(ratio).product()
        };
        let reach = |other: usize| (center[other] - foot.0[other]).min(foot.1[other] - center[other]);
        let reach = others.clone().map(reach).fold(f64::INFINITY, f64::min);
        let height = (center[axis] - low[axis]).max(f64::MIN_POSITIVE);
        share(foot) * (reach / height).clamp(0.0, SAFE) * (1.0 - share(head))
    }
}

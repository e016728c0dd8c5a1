//! Parts of a lens through which exposures see, and the place of the eye at a point of one.

use std::f64::consts::TAU;

use super::{Strata, TICKS, Tick};
use crate::stereo::EyePlace;

/// Part of a lens: what a square of the unit square becomes on a disc of the same area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LensPart {
    /// Lower corner of the square.
    pub(super) corner: [f64; 2],
    /// Length of its edge.
    pub(super) edge: f64,
}

impl LensPart {
    /// Its middle, in a lens of radius 1: to the right, and up.
    pub fn middle(&self) -> [f64; 2] {
        self.at([0.5; 2])
    }

    /// Point for a tick: as [`middle`](Self::middle). With the ticks' times these are a net in which each box of the
    /// same volume, whatever its edges, has one (Sobol, 1967).
    pub fn at_tick(&self, tick: Tick) -> [f64; 2] {
        const BITS: usize = TICKS.ilog2() as usize;
        /// Sobol's directions in the second dimension: Pascal's triangle, modulo 2.
        const DIRECTIONS: [u8; BITS] = [0b1000, 0b1100, 0b1010, 0b1111];
        let of_bits = (0..BITS).filter(|bit| tick >> bit & 1 != 0);
        let [across, up] =
            of_bits.fold([0, 0], |[across, up], bit| [across ^ 0b1000 >> bit, up ^ DIRECTIONS[bit]]);
        self.at([across, up].map(|at: u8| (f64::from(at) + 0.5) / TICKS as f64))
    }

    /// Point at these shares of the square's edges: the concentric map of P. Shirley and K. Chiu, "A Low Distortion Map Between Disk
    /// and Square", 1997.
    fn at(&self, shares: [f64; 2]) -> [f64; 2] {
        let [x, y] = [0, 1].map(|axis| 2.0 * (self.corner[axis] + shares[axis] * self.edge) - 1.0);
        if x == 0.0 && y == 0.0 {
            return [0.0; 2];
        }
        let (radius, eighths) = if x.abs() > y.abs() { (x, y / x) } else { (y, 2.0 - x / y) };
        let (sin, cos) = (eighths * TAU / 8.0).sin_cos();
        [radius * cos, radius * sin]
    }
}

/// Equal parts of a lens, from the middle outwards.
pub fn lens_parts(Strata { across }: Strata) -> Vec<LensPart> {
    let off = |at: u32| (2 * at + 1).abs_diff(across);
    let mut all: Vec<[u32; 2]> = (0..across).flat_map(|y| (0..across).map(move |x| [x, y])).collect();
    all.sort_by_key(|[x, y]| (off(*x).max(off(*y)), off(*x).min(off(*y))));
    let edge = 1.0 / f64::from(across);
    all.into_iter().map(|at| LensPart { corner: at.map(|at| f64::from(at) * edge), edge }).collect()
}

/// Lens at one time, in world units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LensPose {
    /// Radius of the opening.
    pub radius: f64,
    /// Distance of the plane of focus along the view axis.
    pub focus: f64,
}

impl LensPose {
    /// Largest ratio of radius to focus distance: beyond it, no window is left before the lens.
    pub const WIDEST: f64 = 10.0;

    /// Message for a camera that has no place for a lens.
    pub const ORTHOGRAPHIC: &'static str = "goes with a perspective camera: lines of sight of an orthographic one do not meet in a lens; \
                                            leave `aperture` out";

    /// Place beside the camera of an eye at the point `at` of a lens of radius 1, with a window that is shifted by so many cells, in a
    /// picture of `width` x `height` pixels of `cells` x `cells` cells.
    pub fn place(
        lens: Option<Self>,
        (at, shift): ([f64; 2], [f64; 2]),
        ([width, height], cells): ([u32; 2], u32),
    ) -> EyePlace {
        let [width, height] = [width, height].map(f64::from);
        let Self { radius, focus } = lens.unwrap_or(Self { radius: 0.0, focus: 1.0 });
        let aside = at.map(|at| at * radius);
        // between keys a curve may fall below the values that keys may have
        let focus = focus.max(radius / Self::WIDEST).max(f64::MIN_POSITIVE);
        let pixels = width.max(height) * f64::from(cells);
        EyePlace {
            aside,
            window: aside.map(|aside| -aside / focus),
            longer: (width / height).max(1.0),
            shift: shift.map(|cells| cells / pixels),
        }
    }
}

//! Boxes that grow while they move: all segments between two boxes at once.

use glam::Vec3;

use super::Bounds;

/// Box that grows from one box to another as t goes from 0 to `end`: each side of the box is a linear
/// function of t.
#[derive(Debug, Clone, Copy)]
pub struct SweptBox {
    start: Bounds,
    /// Change of `low` and `high` for each unit of t.
    slope: Bounds,
    end: f32,
}

impl SweptBox {
    /// Swept box of all segments from points in `sources` to points in `targets`.
    pub fn between(sources: &Bounds, targets: &Bounds) -> Self {
        let slope = Bounds { low: targets.low - sources.low, high: targets.high - sources.high };
        Self { start: *sources, slope, end: 1.0 }
    }

    /// Swept box of all rays from points in `sources` along `direction`.
    pub fn along(sources: &Bounds, direction: Vec3) -> Self {
        Self { start: *sources, slope: Bounds { low: direction, high: direction }, end: f32::INFINITY }
    }

    /// Swept box of all rays from `source` along directions in `directions`.
    pub fn fan(source: Vec3, directions: &Bounds) -> Self {
        Self::fans(&Bounds::at(source), directions)
    }

    /// Swept box of all rays from points in `sources` along directions in `directions`.
    pub fn fans(sources: &Bounds, directions: &Bounds) -> Self {
        Self { start: *sources, slope: *directions, end: f32::INFINITY }
    }

    /// Returns true if the growing box meets `other` at some t: on each axis its low side must be below the
    /// other's high side, and its high side above the other's low side.
    pub fn meets(&self, other: &Bounds) -> bool {
        let mut span = (0.0_f32, self.end);
        for axis in 0..3 {
            let sides = [
                (self.start.low[axis] - other.high[axis], self.slope.low[axis]),
                (other.low[axis] - self.start.high[axis], -self.slope.high[axis]),
            ];
            // at + t * slope <= 0
            for (at, slope) in sides {
                if slope > 0.0 {
                    span.1 = span.1.min(-at / slope);
                } else if slope < 0.0 {
                    span.0 = span.0.max(-at / slope);
                } else if at > 0.0 {
                    return false;
                }
            }
        }
        span.0 <= span.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::bounds::tests::meets;

    #[test]
    fn a_sweep_meets_what_one_of_its_segments_meets() {
        // boxes, sources and targets on a coarse grid; segments between many points of each
        let mover = Bounds { low: Vec3::splat(2.0), high: Vec3::splat(3.0) };
        let steps = [0.0_f32, 0.35, 0.8, 1.0];
        let spots: Vec<(f32, f32)> = steps.iter().flat_map(|x| steps.iter().map(move |y| (*x, *y))).collect();
        let (mut met, mut missed) = (0, 0);
        for i in 0..1000 {
            let pick = |n: i32, of: i32| (i / n % of) as f32;
            let source = Vec3::new(pick(1, 10) - 2.0, pick(10, 10) - 2.5, pick(100, 10) - 1.5);
            let low = Vec3::new(pick(7, 9), pick(3, 8), pick(13, 7)) * 0.8;
            let targets = Bounds { low, high: low + Vec3::new(0.5, 0.2, 0.9) };
            let by_segment = spots.iter().any(|(x, y)| {
                steps.iter().any(|z| {
                    let target = low + Vec3::new(*x, *y, *z) * (targets.high - low);
                    meets(&mover, source, target - source, 1.0)
                })
            });
            let by_sweep = SweptBox::between(&Bounds::at(source), &targets).meets(&mover);
            assert!(by_sweep || !by_segment, "{source} {targets:?}");
            met += i32::from(by_segment);
            missed += i32::from(!by_sweep);
        }
        assert!(met > 50 && missed > 50, "{met} {missed}");
        let sun = Vec3::new(0.1, 1.0, 0.2);
        let under = Bounds { low: Vec3::new(2.0, 0.0, 2.0), high: Vec3::new(2.5, 0.1, 2.5) };
        assert!(SweptBox::along(&under, sun).meets(&mover));
        assert!(!SweptBox::along(&under, -sun).meets(&mover));
        // from a box, and along an axis where nothing moves
        let sources = Bounds { low: Vec3::new(0.0, 0.0, 2.0), high: Vec3::new(2.5, 0.0, 3.0) };
        let up = Bounds { low: Vec3::new(0.0, 0.9, -0.1), high: Vec3::new(0.0, 1.0, 0.1) };
        assert!(SweptBox::fans(&sources, &up).meets(&mover));
        let beside = Bounds { high: Vec3::new(1.9, 0.0, 3.0), ..sources };
        assert!(!SweptBox::fans(&beside, &up).meets(&mover));
        let above = Bounds { low: Vec3::new(-1.0, 5.0, 2.0), high: Vec3::new(1.5, 5.0, 3.0) };
        assert!(SweptBox::between(&sources, &above).meets(&mover), "from its right rim");
        assert!(!SweptBox::between(&beside, &above).meets(&mover));
        let north = Bounds { low: Vec3::new(0.9, 0.9, 0.9), high: Vec3::ONE };
        assert!(SweptBox::fan(Vec3::ZERO, &north).meets(&mover));
        assert!(!SweptBox::fan(Vec3::new(4.0, 0.0, 0.0), &north).meets(&mover));
    }
}

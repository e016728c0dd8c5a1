//! Traversal of a tree by beams of rays and by single rays: one test of eight boxes for all rays of a beam.
//!
//! A [`Beam`] is made of bounds that the rays of a packet have in common. They all go furthest along the same
//! axis, and in the same direction there, so distances are measured along that axis. The rays' places at
//! distance 0 and their slopes across are then intervals, and narrow ones if 0 is where the rays come closest
//! together (the eye, or a light). A box that the beam misses is missed by all of its rays, so that only
//! triangles are tested ray by ray. (Embree's coherent packets do likewise.)
//!
//! Boxes may be met for nothing, but never missed: origins are widened by the displacement that shearing the
//! rays for triangles may cause ([`SLACK`]), and distances by their rounding ([`ROUNDING`]).

use super::triangles::axes_for;
use crate::geometry::tree::{Box3, Child, Node, Planes, Tree, WIDTH};
use crate::lanes::F32x8;

/// Largest sideways displacement of a ray by rounding, when a triangle is sheared for it or a slope is
/// computed, as a share of the largest distance, along an axis, from the ray's origin to anything in the
/// tree. Seven roundings.
const SLACK: f32 = 4e-7;

/// Distance behind a probe's end at which a box may begin, as a share of the same distance: for rounding at
/// both ends, and some more, so that of two triangles in the same place neither hides the other's box.
const ROUNDING: f32 = 2e-6;

/// Least size of a direction's component: smaller ones are replaced by it. So its reciprocal is finite, and
/// no product with it is a NaN.
const LEAST_COMPONENT: f32 = 1e-18;

/// Largest ratio of the steepest to the least steep slope of a beam for its sides to be met like those of a
/// single ray. For other beams, above all for those whose rays go either way, only the slope is used.
const SLAB_RATIO: f32 = 4.0;

/// Reciprocal of a component of a direction.
#[inline(always)]
fn reciprocal(component: f32) -> f32 {
    if component.abs() < LEAST_COMPONENT {
        LEAST_COMPONENT.copysign(component).recip()
    } else {
        component.recip()
    }
}

/// Ray or beam that traverses a tree.
pub trait Probe {
    /// Tests eight boxes: a bit mask of those that it may meet, and the distances from which on it may.
    fn meet(&self, planes: &Planes) -> (u32, F32x8);
    /// Distance of its end, with room for rounding.
    fn end(&self) -> f32;
    /// Moves its end to `far`.
    fn end_at(&mut self, far: f32);
}

/// Indices of the planes of a box that are met first and last along `axis`.
#[inline(always)]
fn planes_of(axis: usize, backwards: bool) -> [usize; 2] {
    if backwards { [axis + 3, axis] } else { [axis, axis + 3] }
}

/// Largest distance, along any axis, from points between `low` and `high` to the ends of the tree.
#[inline(always)]
fn reach(low: [f32; 3], high: [f32; 3], bounds: &Box3) -> f32 {
    let mut reach = 0.0_f32;
    for axis in 0..3 {
        reach = reach.max(bounds.high[axis] - low[axis]).max(high[axis] - bounds.low[axis]);
    }
    reach
}

/// Planes across one axis, as a single ray or the steep rays of a beam meet them.
#[derive(Clone, Copy)]
struct Slab {
    /// Indices of the planes that are met first and last.
    planes: [usize; 2],
    /// Origins of the rays, for the first and for the last plane.
    from: [F32x8; 2],
    /// Distance for each unit across: least and greatest.
    rate: [F32x8; 2],
}

impl Slab {
    /// Creates the slab of rays that start between `low` and `high`, and whose rates all have the same sign.
    #[inline(always)]
    fn new(axis: usize, [low, high]: [f32; 2], rate: [f32; 2]) -> Self {
        let backwards = rate[0] < 0.0;
        let from = if backwards { [low, high] } else { [high, low] };
        Self {
            planes: planes_of(axis, backwards),
            from: [F32x8::splat(from[0]), F32x8::splat(from[1])],
            rate: [F32x8::splat(rate[0]), F32x8::splat(rate[1])],
        }
    }

    /// Distances to the planes across the axis, to be multiplied by the rates.
    #[inline(always)]
    fn ways(&self, planes: &Planes) -> [F32x8; 2] {
        let [first, last] = self.planes;
        [F32x8::new(planes[first]) - self.from[0], F32x8::new(planes[last]) - self.from[1]]
    }
}

/// A single ray; distances are its t.
pub struct Ray {
    slabs: [Slab; 3],
    near: F32x8,
    far: F32x8,
    end: f32,
}

impl Ray {
    /// Creates a ray for a tree within `bounds`.
    #[inline(always)]
    pub fn new(origin: [f32; 3], direction: [f32; 3], [near, far]: [f32; 2], bounds: &Box3) -> Self {
        let slack = reach(origin, origin, bounds) * SLACK;
        let mut slabs = [Slab::new(0, [0.0; 2], [1.0; 2]); 3];
        for axis in 0..3 {
            let ends = [origin[axis] - slack, origin[axis] + slack];
            slabs[axis] = Slab::new(axis, ends, [reciprocal(direction[axis]); 2]);
        }
        let mut ray = Self { slabs, near: F32x8::splat(near), far: F32x8::splat(far), end: far };
        ray.end_at(far);
        ray
    }
}

impl Probe for Ray {
    #[inline(always)]
    fn meet(&self, planes: &Planes) -> (u32, F32x8) {
        let (mut near, mut far) = (self.near, self.far);
        for slab in &self.slabs {
            let [first, last] = slab.ways(planes);
            near = (first * slab.rate[0]).max(near);
            far = (last * slab.rate[0]).min(far);
        }
        (u32::from(near.le(far * F32x8::splat(1.0 + ROUNDING)).bits()), near)
    }

    #[inline(always)]
    fn end(&self) -> f32 {
        self.end
    }

    #[inline(always)]
    fn end_at(&mut self, far: f32) {
        self.end = far * (1.0 + ROUNDING);
        self.far = F32x8::splat(far);
    }
}

/// Bounds that the rays of a beam have in common.
#[derive(Debug, Clone, Copy)]
pub struct Common {
    /// Axis along which they all go furthest.
    pub along: usize,
    /// True if they go against it.
    pub backwards: bool,
    /// Places at distance 0: least and greatest coordinates. Along `along` both are the same.
    pub place: [[f32; 3]; 2],
    /// Origins: least and greatest coordinates.
    pub origin: [[f32; 3]; 2],
    /// Slopes, along each axis for a unit along `along`: least and greatest.
    pub slope: [[f32; 3]; 2],
    /// Distance along `along` at which they begin.
    pub near: f32,
    /// Distance along `along` at which they end.
    pub far: f32,
}

/// Planes across an axis, as rays of little or changing slope meet them.
#[derive(Clone, Copy)]
struct Side {
    axis: usize,
    low: F32x8,
    high: F32x8,
    slope: [F32x8; 2],
}

/// Rays that are traced together; distances are measured along one axis.
pub struct Beam {
    along: Slab,
    /// Slabs across, where the beam has them; `sides` otherwise.
    slabs: [Slab; 2],
    sides: [Side; 2],
    is_slab: [bool; 2],
    near: F32x8,
    far: F32x8,
    /// Room for rounding.
    room: f32,
    end: f32,
}

impl Beam {
    /// Creates a beam for a tree within `bounds`.
    #[inline(always)]
    pub fn new(common: &Common, bounds: &Box3) -> Self {
        let [low, high] = common.place;
        let reach = reach(low, high, bounds).max(reach(common.origin[0], common.origin[1], bounds));
        // places are computed, and rounded as coordinates are, however near everything is to them
        let mut largest = 0.0_f32;
        for axis in 0..3 {
            largest = largest.max(low[axis].abs()).max(high[axis].abs());
        }
        let slack = (reach + largest) * SLACK;
        let ends = |axis: usize| [low[axis] - slack, high[axis] + slack];
        let rate = if common.backwards { -1.0 } else { 1.0 };
        let along = Slab::new(common.along, ends(common.along), [rate; 2]);
        let zero = F32x8::splat(0.0);
        let mut beam = Self {
            along,
            slabs: [along; 2],
            sides: [Side { axis: 0, low: zero, high: zero, slope: [zero; 2] }; 2],
            is_slab: [false; 2],
            near: F32x8::splat(common.near),
            far: F32x8::splat(common.far),
            room: reach * ROUNDING,
            end: common.far + reach * ROUNDING,
        };
        let [x, y, _] = axes_for(common.along);
        for (i, axis) in [x, y].into_iter().enumerate() {
            let (least, most) = (common.slope[0][axis], common.slope[1][axis]);
            let [low, high] = ends(axis);
            let (flat, steep) = (least.abs().min(most.abs()), least.abs().max(most.abs()));
            beam.is_slab[i] = least * most > 0.0 && steep <= SLAB_RATIO * flat;
            if beam.is_slab[i] {
                beam.slabs[i] = Slab::new(axis, [low, high], [most.recip(), least.recip()]);
            }
            let slope = [F32x8::splat(least), F32x8::splat(most)];
            beam.sides[i] = Side { axis, low: F32x8::splat(low), high: F32x8::splat(high), slope };
        }
        beam
    }
}

impl Probe for Beam {
    #[inline(always)]
    fn meet(&self, planes: &Planes) -> (u32, F32x8) {
        let [first, last] = self.along.ways(planes);
        let mut near = (first * self.along.rate[0]).max(self.near);
        let mut far = (last * self.along.rate[0]).min(self.far);
        let mut met = u32::MAX;
        for i in 0..2 {
            if self.is_slab[i] {
                let slab = &self.slabs[i];
                let [first, last] = slab.ways(planes);
                let [least, most] = slab.rate;
                near = (first * least).min(first * most).max(near);
                far = (last * least).max(last * most).min(far);
            } else {
                // between near and far the beam stays within the reach of its outermost slopes
                let side = &self.sides[i];
                let low = F32x8::new(planes[side.axis]) - side.high;
                let high = F32x8::new(planes[side.axis + 3]) - side.low;
                let [least, most] = side.slope;
                let (a, b) = (least * near, least * far);
                let (c, d) = (most * near, most * far);
                let lowest = a.min(b).min(c.min(d));
                let highest = a.max(b).max(c.max(d));
                let both = low.le(highest) & lowest.le(high);
                met &= u32::from(both.bits());
            }
        }
        let far = far + F32x8::splat(self.room);
        (met & u32::from(near.le(far).bits()), near)
    }

    #[inline(always)]
    fn end(&self) -> f32 {
        self.end
    }

    #[inline(always)]
    fn end_at(&mut self, far: f32) {
        self.end = far + self.room;
        self.far = F32x8::splat(far);
    }
}

/// Traverses `tree`, and calls `visitor` for each leaf that `probe` may meet. `NEAREST_FIRST` where the probe
/// is likely to end at the first leaves.
#[inline(always)]
pub fn walk<const NEAREST_FIRST: bool, P: Probe>(
    probe: &mut P,
    tree: &Tree,
    stack: &mut Vec<Open>,
    visitor: &mut impl Visitor<P>,
) {
    if tree.nodes.is_empty() {
        return;
    }
    // entries below belong to the tree that this one is an instance in
    let floor = stack.len();
    let mut now = Open { near: f32::NEG_INFINITY, child: Child::ROOT };
    loop {
        if now.near <= probe.end() {
            match now.child.open() {
                Ok(leaf) => visitor.visit(probe, leaf, stack),
                Err(node) => {
                    if let Some(next) = enter::<NEAREST_FIRST, P>(probe, &tree.nodes[node], stack) {
                        now = next;
                        continue;
                    }
                }
            }
        }
        if stack.len() == floor {
            return;
        }
        let Some(next) = stack.pop() else { return };
        now = next;
    }
}

/// Child to go on with; pushes the others that `probe` may meet on the stack.
#[inline(always)]
fn enter<const NEAREST_FIRST: bool, P: Probe>(probe: &P, node: &Node, stack: &mut Vec<Open>) -> Option<Open> {
    let (mut met, near) = probe.meet(&node.planes);
    if met == 0 {
        return None;
    }
    let near = near.values();
    let open = |met: u32| {
        let slot = met.trailing_zeros() as usize % WIDTH;
        Open { near: near[slot], child: node.children[slot] }
    };
    let mut next = open(met);
    met &= met - 1;
    let bottom = stack.len();
    while met != 0 {
        let mut other = open(met);
        met &= met - 1;
        if NEAREST_FIRST && other.near < next.near {
            std::mem::swap(&mut next, &mut other);
        }
        let mut at = stack.len();
        stack.push(other);
        while NEAREST_FIRST && at > bottom && stack[at - 1].near < other.near {
            stack[at] = stack[at - 1];
            at -= 1;
        }
        stack[at] = other;
    }
    Some(next)
}

/// Action at leaves.
pub trait Visitor<P: Probe> {
    /// Handles leaf number `leaf`; may end the probe earlier. Must be `#[inline(always)]`.
    fn visit(&mut self, probe: &mut P, leaf: u32, stack: &mut Vec<Open>);
}

/// Part of a tree that is still to be searched.
#[derive(Debug, Clone, Copy)]
pub struct Open {
    /// Distance at which the beam may reach it.
    near: f32,
    child: Child,
}

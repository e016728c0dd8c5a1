//! Invalidation of spare samples: they are neither verified nor lit in this frame. What is unknown about them
//! by the plan is noted, and tested when they serve.

use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::plan::{LightChange, ShadowCheck};
use crate::frame::shot::tile_bounds::TileBounds;
use crate::geometry::Bounds;
use crate::lanes::LANES;
use crate::samples::{BACKGROUND, MOST_SPARES, Sample, Spares, Tag};

/// Invalidates what the plan says must be tested about the spare samples of a tile.
///
/// A tag that only models that moved can make wrong stays where none of these is between sample and light:
/// that is tested for a tile as a whole, and then for eight samples. Otherwise a model that moves anywhere
/// would cost each spare sample its tags.
pub fn invalidate_spares(frame: &FrameView, spares: &mut Spares) {
    let plan = frame.plan;
    let flags = [false, true].map(|moved| plan.doubts(moved));
    spares.set_flags(|spare| flags[usize::from(frame.moved(spare.model))]);
    if plan.any_moved {
        spares.forget_answers(|spare| frame.moved(spare.model));
    }
    if spares.is_empty() || (0..frame.slots.len()).all(|light| plan.keeps_all_tags(light)) {
        return;
    }
    let places = Places::of(frame, &spares.samples);
    for (light, slot) in (0..).zip(frame.slots) {
        if plan.keeps_all_tags(light) {
            continue;
        }
        let may_be_met = places.may_be_in_shadow(frame, light);
        let holds = |number: usize, moved: bool, tag: Tag| match frame.shadow_check(light, moved, tag) {
            ShadowCheck::Keep => true,
            ShadowCheck::Moved => !may_be_met[number / LANES],
            ShadowCheck::StillThenMovable | ShadowCheck::MovableThenStill => false,
        };
        spares.update_tags(
            *slot,
            |number, spare, tag| {
                if holds(number, frame.moved(spare.model), tag) { tag } else { Tag::Unknown }
            },
            |number, spare, tags| {
                let moved = frame.moved(spare.model);
                tags.without(|tag| !holds(number, moved, tag))
            },
        );
    }
}

/// Number of groups of [`LANES`] spare samples.
const GROUPS: usize = MOST_SPARES.div_ceil(LANES);

/// Bounds of each group of spare samples, world space.
struct Places {
    groups: [Bounds; GROUPS],
    /// Longest way to where shadow rays start.
    lift: f32,
}

impl Places {
    fn of(frame: &FrameView, spares: &[Sample]) -> Self {
        let mut groups = [Bounds::EMPTY; GROUPS];
        for (bounds, spares) in groups.iter_mut().zip(spares.chunks(LANES)) {
            for spare in spares.iter().filter(|spare| spare.model != BACKGROUND) {
                let point = frame
                    .place(spare.model, spare.record.traced.tick())
                    .point(|| spare.record.triangle, spare.point);
                *bounds = bounds.with(point);
            }
        }
        let lift = spares.iter().fold(0.0_f32, |most, spare| most.max(frame.most_lift(&[spare.model])));
        Self { groups, lift }
    }

    /// Returns true for each group in which anything that moved may lie between one of the samples and light
    /// number `light`. A `false` is certain.
    fn may_be_in_shadow(&self, frame: &FrameView, light: usize) -> [bool; GROUPS] {
        let moved = frame.moved_bounds;
        if frame.plan.lights[light] == LightChange::Moved {
            return [true; GROUPS];
        }
        let may_be = |bounds: &Bounds| {
            TileBounds::surfaces(*bounds, self.lift).may_be_in_shadow(moved, frame.pose, light)
        };
        let all = self.groups.iter().fold(Bounds::EMPTY, |all, bounds| all.union(*bounds));
        if may_be(&all) { self.groups.each_ref().map(may_be) } else { [false; GROUPS] }
    }
}

//! What a frame asks of light [links](super::links).

use glam::Vec3;

use super::frame_view::FrameView;
use super::links::Class;
use super::plan::{LightChange, ShadowCheck};
use crate::pose::LightPose;
use crate::samples::{EMPTY, Tag};
use crate::scene::BlockerSet;
use crate::shade::area::{AreaRadiance, radiance};
use crate::shade::light_chances::Chosen;
use crate::trace::Purpose;

impl FrameView<'_> {
    /// Returns true if a light, by number, lights a model.
    #[inline]
    pub fn lights(&self, light: usize, model: u32) -> bool {
        self.links.lit.is_empty() && self.links.dark.is_empty() || self.links.lights(light, model)
    }

    /// Returns true if the light of another group alone is rendered, and this light, by number, is dark.
    #[inline]
    pub fn is_dark_group(&self, light: usize) -> bool {
        self.links.dark.get(light).is_some_and(|is_dark| *is_dark)
    }

    /// Bit mask of those of eight models that a light, by number, lights.
    #[inline]
    pub fn lit_bits(&self, light: usize, models: &[u32]) -> u8 {
        let is_linked = !self.links.dark.is_empty() || matches!(self.links.lit.get(light), Some(Some(_)));
        if !is_linked {
            return u8::MAX;
        }
        (0..).zip(models).fold(0, |bits, (lane, model)| {
            bits | u8::from(*model < EMPTY && self.links.lights(light, *model)) << lane
        })
    }

    /// Returns true if what any model emits is dark to some models.
    #[inline]
    pub fn has_linked_emission(&self) -> bool {
        !self.links.emission_of.is_empty() || !self.links.dark_emission.is_empty()
    }

    /// Returns true if surfaces of the model `receiver`, or the eye, see what the model `emitter` emits.
    #[inline]
    pub fn sees_emission(&self, receiver: u32, emitter: u32) -> bool {
        if self.links.dark_emission.get(emitter as usize).is_some_and(|is_dark| *is_dark) {
            return false;
        }
        let list = self.links.emission_of.get(emitter as usize).copied().flatten();
        list.is_none_or(|list| {
            self.links.lit_by_emission[list as usize].get(receiver as usize).copied().unwrap_or(true)
        })
    }

    /// Question of shadow rays to a light, by number.
    #[inline]
    pub fn shadows_of_light(&self, light: usize) -> Purpose {
        Purpose::shadow_of(self.links.blockers.of_light(light))
    }

    /// Radiance of a light, by number, if it is an area: `light` at one tick.
    #[inline]
    pub fn radiance_of(&self, number: usize, light: &LightPose) -> Option<AreaRadiance> {
        radiance(light).map(|radiance| AreaRadiance { is_met: !self.is_shadow_linked(number), ..radiance })
    }

    /// Question of shadow rays to what a model emits.
    #[inline]
    pub fn shadows_of_emission(&self, model: u32) -> Purpose {
        Purpose::shadow_of(self.links.blockers.of_emission(model))
    }

    /// Returns true if some models alone cast shadows in any light.
    #[inline]
    pub fn has_shadow_links(&self) -> bool {
        self.links.blockers.count() > 0
    }

    /// Returns true if some models alone cast shadows in a light, by number.
    #[inline]
    pub fn is_shadow_linked(&self, light: usize) -> bool {
        self.links.blockers.of_light(light) != BlockerSet::ALL
    }

    /// Returns true if some models alone cast shadows in the light that a model emits.
    #[inline]
    pub fn is_emission_shadow_linked(&self, model: u32) -> bool {
        self.links.blockers.of_emission(model) != BlockerSet::ALL
    }

    /// Returns true if any model that casts shadows in a light, by number, moved since the frame before.
    #[inline]
    pub fn moves_blockers(&self, light: usize) -> bool {
        self.moved_sets >> self.links.blockers.of_light(light).number() & 1 != 0
    }

    /// What a sample's shadow ray to a light is tested against: as the [plan](super::plan::Plan::shadow_check) says, and nothing where no
    /// model moved that casts shadows in that light.
    #[inline]
    pub fn shadow_check(&self, light: usize, moved: bool, tag: Tag) -> ShadowCheck {
        let is_as_before = !moved && self.plan.lights[light] != LightChange::Moved && tag != Tag::Unknown;
        if is_as_before && !self.moves_blockers(light) {
            return ShadowCheck::Keep;
        }
        self.plan.shadow_check(light, moved, tag)
    }

    /// Chooses one of the lights that light `model`, for a surface at `point` (world space) by a `random` number from 0 to below 1.
    /// `None` if none does.
    #[inline]
    pub fn choose_light(&self, model: u32, point: Vec3, random: f32) -> Option<Chosen> {
        let Some(class) = self.links.class_of.get(model as usize) else {
            return Some(self.light_chances.choose(point, random));
        };
        let Class { lights, chances } = &self.links.classes[*class as usize];
        let chosen = || chances.choose(point, random);
        let named = |chosen: Chosen| Chosen { source: lights[chosen.source] as usize, ..chosen };
        (!lights.is_empty()).then(chosen).map(named)
    }

    /// Chance with which [`choose_light`](Self::choose_light) chooses a light, by number, that lights `model`.
    #[inline]
    pub fn chance_of_light(&self, model: u32, point: Vec3, light: usize) -> f32 {
        let Some(class) = self.links.class_of.get(model as usize) else {
            return self.light_chances.of(point, light);
        };
        let Class { lights, chances } = &self.links.classes[*class as usize];
        lights.binary_search(&(light as u32)).map_or(0.0, |place| chances.of(point, place))
    }
}

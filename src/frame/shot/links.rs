//! Light links in a frame: which models a light lights, which models cast shadows in its light, and which lights a surface asks.
//!
//! A light that does not light a model is not there for its surfaces: they send no shadow rays to it, their paths do not ask it, and
//! what their rays meet of it is dark. Rays straight from the eye see all that emits.
//!
//! Where some models alone cast shadows in a light, rays that ask it know which; rays that meet it do not. So what surfaces ask for
//! such light brings all of it, and what their paths meet of it, after they asked, counts as nothing. Where nothing asks (off mirrors,
//! and behind glass), a ray shows it where it is the first that the ray meets.

use std::collections::HashMap;
use std::sync::Arc;

use glam::Vec3;

use super::frame_view::FrameView;
use super::plan::{LightChange, ShadowCheck};
use crate::pose::LightPose;
use crate::samples::{EMPTY, Tag};
use crate::scene::{BlockerSet, BlockerSets, LightGroups, LightLinks, ModelNames, Scene};
use crate::shade::area::{AreaRadiance, radiance};
use crate::shade::light_chances::{Chosen, LightChances, Source};
use crate::trace::Purpose;

/// Model of a ray that has come straight from the eye.
pub const OF_EYE: u32 = u32::MAX;

/// Links of all lights of a shot, by numbers. Empty where there are none.
#[derive(Debug, Clone, Default)]
pub struct Links {
    /// True for each model that a light lights; `None` if it lights all. Empty if all do.
    lit: Vec<Option<Vec<bool>>>,
    /// Lists of the models that some models light by what they emit.
    lit_by_emission: Vec<Vec<bool>>,
    /// Number of the list of each model; `None` if it lights all. Empty if all do.
    emission_of: Vec<Option<u32>>,
    blockers: BlockerSets,
    /// Chances of lights for models that the same lights light.
    classes: Vec<Class>,
    /// Number of the class of each model. Empty if all lights light all models.
    class_of: Vec<u32>,
    /// True for each light that is dark, as the light of another group alone is rendered; empty if none is.
    dark: Vec<bool>,
    /// The same of what each model emits.
    dark_emission: Vec<bool>,
    /// True if the world is dark for that reason.
    pub is_world_dark: bool,
}

/// Lights that light some models.
#[derive(Debug, Clone)]
struct Class {
    /// Numbers of the lights.
    lights: Vec<u32>,
    chances: LightChances,
}

impl Links {
    /// Links of `scene`, of which the light of the group `only` alone is rendered, if that is given.
    pub fn new(scene: &Scene, only: Option<&str>) -> Self {
        // who is dark is asked, chosen and met as if it were not: so groups add up to the picture
        let is_dark =
            |group: Option<&str>| only.is_some_and(|only| group.unwrap_or(LightGroups::OTHERS) != only);
        let any = |dark: Vec<bool>| if dark.contains(&true) { dark } else { Vec::new() };
        let dark = any(scene.lights.iter().map(|light| is_dark(light.group.as_deref())).collect());
        let dark_emission =
            any(scene.models.iter().map(|model| is_dark(model.linked.light_group.as_deref())).collect());
        let is_world_dark = is_dark(scene.world_group.as_deref());
        let members = |names: &ModelNames| -> Option<Vec<bool>> {
            let all = || scene.models.iter().map(|model| names.has(model)).collect::<Vec<bool>>();
            (!names.is_all()).then(all).filter(|members| members.contains(&false))
        };
        let mut lit: Vec<Option<Vec<bool>>> =
            scene.lights.iter().map(|light| members(&light.links.receivers)).collect();
        if lit.iter().all(Option::is_none) {
            lit.clear();
        }
        let mut lit_by_emission = Vec::new();
        // copies share their links
        let mut known: HashMap<*const LightLinks, Option<u32>> = HashMap::new();
        let mut number_of = |links: &Arc<LightLinks>| {
            *known.entry(Arc::as_ptr(links)).or_insert_with(|| {
                let members = members(&links.receivers)?;
                lit_by_emission.push(members);
                Some(lit_by_emission.len() as u32 - 1)
            })
        };
        let mut emission_of: Vec<Option<u32>> = scene
            .models
            .iter()
            .map(|model| model.linked.emission.as_ref().and_then(&mut number_of))
            .collect();
        if emission_of.iter().all(Option::is_none) {
            emission_of.clear();
        }
        let (classes, class_of) =
            if lit.is_empty() { (Vec::new(), Vec::new()) } else { classes(scene, &lit) };
        Self {
            lit,
            lit_by_emission,
            emission_of,
            blockers: BlockerSets::of(scene),
            classes,
            class_of,
            dark,
            dark_emission,
            is_world_dark,
        }
    }

    /// Bit mask of the sets of models that cast shadows in some lights in which any of those that `moved` is: bit 0 for all models.
    pub fn sets_of(&self, moved: &[bool]) -> u32 {
        let all = u32::from(moved.contains(&true));
        if all == 0 || self.blockers.count() == 0 {
            return all;
        }
        let moved = moved.iter().enumerate().filter(|(_, moved)| **moved);
        moved.fold(all, |bits, (model, _)| bits | u32::from(self.blockers.bits_of(model)) << 1)
    }

    fn lights(&self, light: usize, model: u32) -> bool {
        if self.dark.get(light).is_some_and(|is_dark| *is_dark) {
            return false;
        }
        let Some(Some(members)) = self.lit.get(light) else { return true };
        members.get(model as usize).copied().unwrap_or(true)
    }
}

/// Models by the lights that light them.
fn classes(scene: &Scene, lit: &[Option<Vec<bool>>]) -> (Vec<Class>, Vec<u32>) {
    let sources: Vec<Source> = scene.lights.iter().map(Source::of_light).collect();
    let mut known: HashMap<Vec<u32>, u32> = HashMap::new();
    let mut classes = Vec::new();
    let lights_of = |model: usize| -> Vec<u32> {
        let lights = (0..).zip(lit);
        let lights = lights.filter(|(_, lit)| lit.as_ref().is_none_or(|members| members[model]));
        lights.map(|(light, _)| light).collect()
    };
    let class_of = (0..scene.models.len()).map(|model| {
        *known.entry(lights_of(model)).or_insert_with_key(|lights| {
            let own: Vec<Source> = lights.iter().map(|light| sources[*light as usize]).collect();
            classes.push(Class { lights: lights.clone(), chances: LightChances::new(&own) });
            classes.len() as u32 - 1
        })
    });
    let class_of = class_of.collect();
    (classes, class_of)
}

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

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

use crate::scene::{BlockerSets, LightGroups, LightLinks, ModelNames, Scene};
use crate::shade::light_chances::{LightChances, Source};

/// Model of a ray that has come straight from the eye.
pub const OF_EYE: u32 = u32::MAX;

/// Links of all lights of a shot, by numbers. Empty where there are none.
#[derive(Debug, Clone, Default)]
pub struct Links {
    /// True for each model that a light lights; `None` if it lights all. Empty if all do.
    pub(super) lit: Vec<Option<Vec<bool>>>,
    /// Lists of the models that some models light by what they emit.
    pub(super) lit_by_emission: Vec<Vec<bool>>,
    /// Number of the list of each model; `None` if it lights all. Empty if all do.
    pub(super) emission_of: Vec<Option<u32>>,
    pub(super) blockers: BlockerSets,
    /// Chances of lights for models that the same lights light.
    pub(super) classes: Vec<Class>,
    /// Number of the class of each model. Empty if all lights light all models.
    pub(super) class_of: Vec<u32>,
    /// True for each light that is dark, as the light of another group alone is rendered; empty if none is.
    pub(super) dark: Vec<bool>,
    /// The same of what each model emits.
    pub(super) dark_emission: Vec<bool>,
    /// True if the world is dark for that reason.
    pub is_world_dark: bool,
}

/// Lights that light some models.
#[derive(Debug, Clone)]
pub(super) struct Class {
    /// Numbers of the lights.
    pub(super) lights: Vec<u32>,
    pub(super) chances: LightChances,
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

    pub(super) fn lights(&self, light: usize, model: u32) -> bool {
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

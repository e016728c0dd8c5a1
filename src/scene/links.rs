//! Light links: which models a light lights, and which models cast shadows in its light.
//!
//! Files say both by names: of models and of groups of models. What emits is linked as lights are.

use std::sync::Arc;

use super::{Model, Scene};

/// Models by their names and the names of their groups.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ModelNames {
    /// Names of the models that are meant; `None` for all.
    pub include: Option<Vec<String>>,
    /// Names of models that are not, though they are included.
    pub exclude: Vec<String>,
}

impl ModelNames {
    /// Returns true if all models are meant, whatever their names.
    pub fn is_all(&self) -> bool {
        self.include.is_none() && self.exclude.is_empty()
    }

    /// Returns true if a model is meant.
    pub fn has(&self, model: &Model) -> bool {
        let is_among = |names: &[String]| names.iter().any(|name| model.is_named(name));
        self.include.as_deref().is_none_or(is_among) && !is_among(&self.exclude)
    }

    /// All names that are written, in their order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.include.iter().flatten().chain(&self.exclude).map(String::as_str)
    }
}

/// Links of a light, or of the light that a model emits.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LightLinks {
    /// Models that it lights.
    pub receivers: ModelNames,
    /// Models that cast shadows in its light.
    pub blockers: ModelNames,
}

/// What links know of a model.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Linked {
    /// Names beside its own by which links mean it: those of its groups, and that of the table of which it is a part.
    pub groups: Arc<[String]>,
    /// Links of the light that it emits; `None` where it lights all, and all cast shadows in it.
    pub emission: Option<Arc<LightLinks>>,
    /// Name of the light group of what it emits.
    pub light_group: Option<Arc<str>>,
}

impl Model {
    /// Returns true if this is its name or that of one of its groups.
    pub fn is_named(&self, name: &str) -> bool {
        self.name == name || self.linked.groups.iter().any(|group| group == name)
    }
}

/// A set of models that cast shadows in the light of some lights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BlockerSet(u8);

impl BlockerSet {
    /// All models that cast shadows.
    pub const ALL: Self = Self(0);

    /// Maximum number of sets beside that of all: a bit of Embree's masks each.
    pub const MOST: usize = 16;

    /// The set of this number, from 1 on.
    #[cfg(test)]
    pub(crate) fn nth(number: usize) -> Self {
        Self(number as u8)
    }

    /// Number of the set; that of all is 0.
    pub const fn number(self) -> usize {
        self.0 as usize
    }
}

/// The sets of models that cast shadows in the light of each light: each set once.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BlockerSets {
    /// For each set beside that of all: true for each model, by number, that is in it.
    sets: Vec<Vec<bool>>,
    /// Set of each light; empty where all have that of all.
    of_lights: Vec<BlockerSet>,
    /// Set of the light that each model emits; empty where all have that of all.
    of_emission: Vec<BlockerSet>,
}

impl BlockerSets {
    /// Collects the sets of `scene`. Beyond the [maximum](BlockerSet::MOST), which a shot file may not exceed, all models are in
    /// all sets.
    pub fn of(scene: &Scene) -> Self {
        let mut sets: Vec<Vec<bool>> = Vec::new();
        let mut set_of = |links: Option<&LightLinks>| {
            let Some(links) = links.filter(|links| !links.blockers.is_all()) else { return BlockerSet::ALL };
            let members: Vec<bool> = scene.models.iter().map(|model| links.blockers.has(model)).collect();
            if members.iter().all(|is_member| *is_member) {
                return BlockerSet::ALL;
            }
            let number = sets.iter().position(|known| *known == members).unwrap_or_else(|| {
                sets.push(members);
                sets.len() - 1
            });
            if number < BlockerSet::MOST { BlockerSet(number as u8 + 1) } else { BlockerSet::ALL }
        };
        let of_lights: Vec<BlockerSet> =
            scene.lights.iter().map(|light| set_of(Some(&light.links))).collect();
        let of_emission: Vec<BlockerSet> =
            scene.models.iter().map(|model| set_of(model.linked.emission.as_deref())).collect();
        let any = |sets: Vec<BlockerSet>| {
            if sets.iter().all(|set| *set == BlockerSet::ALL) { Vec::new() } else { sets }
        };
        Self { of_lights: any(of_lights), of_emission: any(of_emission), sets }
    }

    /// Number of sets beside that of all.
    pub fn count(&self) -> usize {
        self.sets.len().min(BlockerSet::MOST)
    }

    /// All sets beside that of all.
    pub fn linked(&self) -> impl Iterator<Item = BlockerSet> + use<> {
        (1..=self.count() as u8).map(BlockerSet)
    }

    /// Set of a light.
    #[inline]
    pub fn of_light(&self, light: usize) -> BlockerSet {
        self.of_lights.get(light).copied().unwrap_or_default()
    }

    /// Set of the light that a model emits.
    #[inline]
    pub fn of_emission(&self, model: u32) -> BlockerSet {
        self.of_emission.get(model as usize).copied().unwrap_or_default()
    }

    /// Returns true if a model is in a set.
    pub fn has(&self, set: BlockerSet, model: usize) -> bool {
        set == BlockerSet::ALL || self.sets[set.number() - 1][model]
    }

    /// Bit mask of the sets that a model is in: bit 0 for the first one beside that of all.
    pub fn bits_of(&self, model: usize) -> u16 {
        self.linked().filter(|set| self.has(*set, model)).fold(0, |bits, set| bits | 1 << (set.number() - 1))
    }
}

//! Spare samples: those of a tile that serve none of its cells in this frame, and may serve one in the next.

use glam::Vec3;

use super::{AreaTag, CELLS, Flags, GatheredLight, Record, Tag, TagLayout, TagSlot, Tags, Tile};

/// One of them, but for its tags and what it has gathered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spare {
    /// See [`Tile::x`].
    pub point: Vec3,
    /// See [`Tile::model`].
    pub model: u32,
    /// What else is kept.
    pub record: Record,
}

/// The spare samples of a tile, in no order that means anything.
#[derive(Debug, Clone, Default)]
pub struct Spares {
    /// The samples.
    pub samples: Vec<Spare>,
    /// By light that has one tag a sample, the tag of each sample.
    pub(super) single: Vec<Vec<Tag>>,
    /// By light that is an area, the tags of each sample.
    pub(super) area: Vec<Vec<AreaTag>>,
    /// What each sample has gathered.
    pub(super) gathered: GatheredLight,
}

/// As many as a tile may have: a [slot](Tile::slots) has 11 bits.
pub const MOST_SPARES: usize = CELLS;

impl Spares {
    /// None, with room for tags as `layout` says.
    pub fn none(layout: &TagLayout) -> Self {
        let (single, area) = layout.columns();
        Self {
            samples: Vec::new(),
            single: vec![Vec::new(); single],
            area: vec![Vec::new(); area],
            gathered: GatheredLight::unknown(layout, 0),
        }
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// Forgets all of them and keeps their memory.
    pub fn clear(&mut self) {
        self.samples.clear();
        self.single.iter_mut().for_each(Vec::clear);
        self.area.iter_mut().for_each(Vec::clear);
        self.gathered.clear();
    }

    /// Gives back what memory they do not need, if it is much: a list grows by doubling, tiles go from place to place, and each
    /// would keep room for the most that it has ever held.
    pub fn trim(&mut self) {
        let most = self.len() + self.len() / 4 + 4;
        if self.samples.capacity() > most {
            self.samples.shrink_to_fit();
            self.single.iter_mut().for_each(Vec::shrink_to_fit);
            self.area.iter_mut().for_each(Vec::shrink_to_fit);
            self.gathered.trim();
        }
    }

    /// Adds the sample in `slot` of `from`.
    pub fn push(&mut self, from: &Tile, slot: usize) {
        self.samples.push(from.slot(slot));
        match slot.checked_sub(CELLS) {
            None => {
                from.tags.push_to(slot, &mut self.single, &mut self.area);
                self.gathered.push(&from.gathered, slot);
            }
            Some(number) => {
                let Self { single, area, gathered, .. } = &from.spares;
                self.gathered.push(gathered, number);
                self.single.iter_mut().zip(single).for_each(|(to, from)| to.push(from[number]));
                self.area.iter_mut().zip(area).for_each(|(to, from)| to.push(from[number]));
            }
        }
    }

    /// Adds a sample whose tags are not known, with what sample number `at` of `gathered` has gathered.
    pub fn push_untagged(&mut self, spare: Spare, gathered: &GatheredLight, at: usize) {
        self.samples.push(spare);
        self.gathered.push(gathered, at);
        self.single.iter_mut().for_each(|tags| tags.push(Tag::Unknown));
        self.area.iter_mut().for_each(|tags| tags.push(AreaTag::UNKNOWN));
    }

    /// Copies the tags of spare `number` to `cell`.
    pub fn copy_tags(&self, number: usize, tags: &mut Tags, cell: usize) {
        tags.set(
            cell,
            self.single.iter().map(|tags| tags[number]),
            self.area.iter().map(|tags| tags[number]),
        );
    }

    /// Calls `single` or `area` with the number of each spare, the spare, and its tags for the light of `slot`: what it returns
    /// is their new state.
    pub fn update_tags(
        &mut self,
        slot: TagSlot,
        mut single: impl FnMut(usize, &Spare, Tag) -> Tag,
        mut area: impl FnMut(usize, &Spare, AreaTag) -> AreaTag,
    ) {
        match slot {
            TagSlot::Single(column) => {
                for (number, (tag, spare)) in self.single[column].iter_mut().zip(&self.samples).enumerate() {
                    *tag = single(number, spare, *tag);
                }
            }
            TagSlot::Area(column) => {
                for (number, (tag, spare)) in self.area[column].iter_mut().zip(&self.samples).enumerate() {
                    *tag = area(number, spare, *tag);
                }
            }
        }
    }

    /// Sets these flags of all.
    pub fn set_flags(&mut self, flags: impl Fn(&Spare) -> Flags) {
        for spare in &mut self.samples {
            spare.record.flags = spare.record.flags.with(flags(spare));
        }
    }

    /// Forgets what those have found out that `is_doubtful` names: see [`GatheredLight::forget`].
    pub fn forget_answers(&mut self, is_doubtful: impl Fn(&Spare) -> bool) {
        let samples = &self.samples;
        self.gathered.forget(|number| is_doubtful(&samples[number]));
    }

    /// The same of the sample that was added last.
    pub fn forget_last_answers(&mut self) {
        if let Some(last) = self.len().checked_sub(1) {
            self.gathered.forget_one(last);
        }
    }

    /// Forgets what has been gathered.
    pub fn forget_gathered(&mut self) {
        self.gathered.forget_all();
    }

    /// Forgets all tags.
    pub fn forget_tags(&mut self) {
        self.single.iter_mut().flatten().for_each(|tag| *tag = Tag::Unknown);
        self.area.iter_mut().flatten().for_each(|tag| *tag = AreaTag::UNKNOWN);
    }

    /// Bytes on the heap.
    pub fn bytes(&self) -> usize {
        let single: usize = self.single.iter().map(Vec::capacity).sum();
        let area: usize = self.area.iter().map(Vec::capacity).sum();
        let tags = single * size_of::<Tag>() + area * size_of::<AreaTag>();
        self.samples.capacity() * size_of::<Spare>() + tags + self.gathered.bytes()
    }
}

//! Spare samples: samples of a tile that serve none of its cells in this frame, and may serve one in the
//! next.

use super::{AreaTag, CELLS, Flags, GatheredLight, Sample, Slot, Tag, TagLayout, TagSlot, Tags, Tile};

/// Spare samples of a tile, in no particular order.
#[derive(Debug, Clone, Default)]
pub struct Spares {
    /// The samples.
    pub samples: Vec<Sample>,
    /// Tags of each sample, by lights that have one tag a sample.
    pub(super) single: Vec<Vec<Tag>>,
    /// Tags of each sample, by area lights.
    pub(super) area: Vec<Vec<AreaTag>>,
    /// Gathered light and openness of each sample.
    pub(super) gathered: GatheredLight,
}

/// Largest number of spare samples of a tile: a [slot](Tile::slots) has 11 bits.
pub const MOST_SPARES: usize = CELLS;

impl Spares {
    /// Creates an empty list, with room for tags by `layout`.
    pub fn none(layout: &TagLayout) -> Self {
        let (single, area) = layout.columns();
        Self {
            samples: Vec::new(),
            single: vec![Vec::new(); single],
            area: vec![Vec::new(); area],
            gathered: GatheredLight::unknown(layout, 0),
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Returns true if there are none.
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// Removes all samples and keeps their memory.
    pub fn clear(&mut self) {
        self.samples.clear();
        self.single.iter_mut().for_each(Vec::clear);
        self.area.iter_mut().for_each(Vec::clear);
        self.gathered.clear();
    }

    /// Returns memory that is not needed, if it is much: a list grows by doubling, tiles go from place to
    /// place, and each would keep room for the most that it has ever held.
    pub fn trim(&mut self) {
        let most = self.len() + self.len() / 4 + 4;
        if self.samples.capacity() > most {
            self.samples.shrink_to_fit();
            self.single.iter_mut().for_each(Vec::shrink_to_fit);
            self.area.iter_mut().for_each(Vec::shrink_to_fit);
            self.gathered.trim();
        }
    }

    /// Appends the sample in `slot` of `from`.
    pub fn push(&mut self, from: &Tile, slot: usize) {
        self.samples.push(from.sample(slot));
        match Slot::new(slot) {
            Slot::Cell(cell) => {
                from.tags.push_to(cell, &mut self.single, &mut self.area);
                self.gathered.push(&from.gathered, cell);
            }
            Slot::Spare(number) => {
                let Self { single, area, gathered, .. } = &from.spares;
                self.gathered.push(gathered, number);
                self.single.iter_mut().zip(single).for_each(|(to, from)| to.push(from[number]));
                self.area.iter_mut().zip(area).for_each(|(to, from)| to.push(from[number]));
            }
        }
    }

    /// Appends a sample with unknown tags, and with the gathered light of sample number `at` of `gathered`.
    pub fn push_untagged(&mut self, spare: Sample, gathered: &GatheredLight, at: usize) {
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

    /// Calls `single` or `area` for each spare with its number, the spare, and its tags for the light of
    /// `slot`, and replaces these by what is returned.
    pub fn update_tags(
        &mut self,
        slot: TagSlot,
        mut single: impl FnMut(usize, &Sample, Tag) -> Tag,
        mut area: impl FnMut(usize, &Sample, AreaTag) -> AreaTag,
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

    /// Adds the flags that `flags` returns to each sample's.
    pub fn set_flags(&mut self, flags: impl Fn(&Sample) -> Flags) {
        for spare in &mut self.samples {
            spare.record.flags = spare.record.flags.with(flags(spare));
        }
    }

    /// Resets gathered light and openness of the samples that `is_doubtful` names: see
    /// [`GatheredLight::forget`].
    pub fn forget_answers(&mut self, is_doubtful: impl Fn(&Sample) -> bool) {
        let samples = &self.samples;
        self.gathered.forget(|number| is_doubtful(&samples[number]));
    }

    /// Resets gathered light and openness of the sample that was added last.
    pub fn forget_last_answers(&mut self) {
        if let Some(last) = self.len().checked_sub(1) {
            self.gathered.forget_one(last);
        }
    }

    /// Resets gathered light and openness of all samples.
    pub fn forget_gathered(&mut self) {
        self.gathered.forget_all();
    }

    /// Resets all tags.
    pub fn forget_tags(&mut self) {
        self.single.iter_mut().flatten().for_each(|tag| *tag = Tag::Unknown);
        self.area.iter_mut().flatten().for_each(|tag| *tag = AreaTag::UNKNOWN);
    }

    /// Memory held on the heap, in bytes.
    pub fn bytes(&self) -> usize {
        let single: usize = self.single.iter().map(Vec::capacity).sum();
        let area: usize = self.area.iter().map(Vec::capacity).sum();
        let tags = single * size_of::<Tag>() + area * size_of::<AreaTag>();
        self.samples.capacity() * size_of::<Sample>() + tags + self.gathered.bytes()
    }
}

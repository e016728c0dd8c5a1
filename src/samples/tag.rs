//! Shadow tags: the results of a sample's last shadow rays to each light.

use super::{CELLS, Column, EMPTY, GatheredLight, Move, PathList, Slot, Spares, VariedColumn};
use crate::changes::anything_changes;
use crate::lanes::{LANES, Mask};
use crate::scene::material::Varying;
use crate::scene::{Light, Material, Scene};
use crate::settings::{MOST_OCCLUSION_RAYS, Settings};

/// Number of points of an area light for which a sample keeps tags: the bits of a word.
pub const AREA_POINTS: usize = u16::BITS as usize;

/// Occluder between a sample and a light when it was last tested.
///
/// Tags save rays and never decide a picture: a frame with all tags dropped is the same to the bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Tag {
    /// Not tested yet.
    #[default]
    Unknown,
    /// None: the light reaches the sample.
    Lit,
    /// The surface itself: it faces away, or the light's cone does not contain it.
    BackFacing,
    /// A model that never moves.
    StaticOccluder,
    /// A model that moves in some frame of the shot.
    DynamicOccluder,
}

impl Tag {
    /// All tags, in the order of their numbers.
    pub const ALL: [Self; 5] =
        [Self::Unknown, Self::Lit, Self::BackFacing, Self::StaticOccluder, Self::DynamicOccluder];

    /// Returns true if the light reaches the sample.
    pub fn is_lit(self) -> bool {
        self == Tag::Lit
    }

    /// Returns true if light that was summed under this tag is wrong under `now`.
    pub fn changes_light_to(self, now: Tag) -> bool {
        self == Tag::Unknown || self.is_lit() != now.is_lit()
    }
}

/// Tags of one sample for the points of an area light, two bits each.
///
/// A point that the surface faces away from is stored as shadowed by a still model: the rules are the same
/// for both.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AreaTag {
    /// Bit by point: the light reaches the sample. With both bits set, the point has not been tested.
    lit: u16,
    /// Bit by point: in the shadow of a model that moves in some frame of the shot.
    by_dynamic: u16,
}

impl AreaTag {
    /// Tags of which none has been tested.
    pub const UNKNOWN: Self = Self { lit: u16::MAX, by_dynamic: u16::MAX };

    /// Converts the tags to bytes, to be saved.
    pub fn to_bytes(self) -> [u8; 4] {
        let [[a, b], [c, d]] = [self.lit, self.by_dynamic].map(u16::to_le_bytes);
        [a, b, c, d]
    }

    /// Inverse of [`to_bytes`](Self::to_bytes).
    pub fn from_bytes([a, b, c, d]: [u8; 4]) -> Self {
        Self { lit: u16::from_le_bytes([a, b]), by_dynamic: u16::from_le_bytes([c, d]) }
    }

    /// Tag of one point.
    #[inline]
    pub fn get(self, point: usize) -> Tag {
        match (self.lit >> point & 1, self.by_dynamic >> point & 1) {
            (1, 0) => Tag::Lit,
            (0, 0) => Tag::StaticOccluder,
            (0, _) => Tag::DynamicOccluder,
            _ => Tag::Unknown,
        }
    }

    /// Bit by point: the light is known to reach the sample.
    #[inline]
    pub fn lit(self) -> u16 {
        self.lit & !self.by_dynamic
    }

    /// Bit by point: the point has this tag. No point counts as back-facing.
    #[inline]
    pub fn points(self, tag: Tag) -> u16 {
        match tag {
            Tag::Unknown => self.lit & self.by_dynamic,
            Tag::Lit => self.lit & !self.by_dynamic,
            Tag::BackFacing => 0,
            Tag::StaticOccluder => !self.lit & !self.by_dynamic,
            Tag::DynamicOccluder => !self.lit & self.by_dynamic,
        }
    }

    /// Sets, for the points in `asked`, which are `lit` and which are in the shadow `by_dynamic`; leaves the
    /// others as they are.
    #[inline]
    pub fn learn(&mut self, asked: u16, lit: u16, by_dynamic: u16) {
        self.lit = self.lit & !asked | lit & asked;
        self.by_dynamic = self.by_dynamic & !asked | by_dynamic & asked;
    }

    /// Resets those tags that are in doubt to unknown.
    pub fn without(self, is_doubtful: impl Fn(Tag) -> bool) -> Self {
        let gone = Tag::ALL.into_iter().filter(|tag| is_doubtful(*tag));
        let gone = gone.fold(0, |all, tag| all | self.points(tag));
        Self { lit: self.lit | gone, by_dynamic: self.by_dynamic | gone }
    }

    /// Returns true if light that was summed under these tags is wrong under `now`.
    #[inline]
    pub fn changes_light_to(self, now: Self) -> bool {
        self.points(Tag::Unknown) != 0 || self.lit() != now.lit()
    }
}

impl Default for AreaTag {
    fn default() -> Self {
        Self::UNKNOWN
    }
}

/// Column of the tags for a light, among those of its kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TagSlot {
    /// One tag a sample.
    Single(usize),
    /// [`AREA_POINTS`] tags a sample.
    Area(usize),
}

/// Layout of the data that samples keep about light: the columns of tags for each light of a scene, and the
/// numbers of paths and rays by which they gather.
#[derive(Debug, Clone, Default)]
pub struct TagLayout {
    /// Column of each light.
    pub slots: Vec<TagSlot>,
    single: usize,
    area: usize,
    /// Number of paths by which a sample gathers light.
    pub paths: usize,
    /// Largest number of paths by which the layer of a sample reflects.
    pub reflections: usize,
    /// True if paths may expire: something in the shot moves or changes.
    pub expires: bool,
    /// Number of a sample's occlusion rays.
    pub occlusion_rays: usize,
    /// True if samples have seeds: for their paths and rays, for the points on area lights that they ask, and for the microfacets of
    /// rough glass.
    pub is_seeded: bool,
    /// Parameters of surfaces that vary from place to place.
    pub varying: Varying,
}

impl TagLayout {
    /// Creates a layout for lights to which samples send so many shadow rays each.
    pub fn new(points: impl Iterator<Item = usize>) -> Self {
        let mut layout = Self::default();
        for points in points {
            let (slot, count) = match points {
                1 => (TagSlot::Single(layout.single), &mut layout.single),
                _ => (TagSlot::Area(layout.area), &mut layout.area),
            };
            *count += 1;
            layout.slots.push(slot);
        }
        layout
    }

    /// Creates the layout for samples of `scene` with these settings.
    pub fn for_scene(scene: &Scene, settings: &Settings) -> Self {
        let points = scene.lights.iter().map(Light::points);
        let paths = if settings.bounces == 0 { 0 } else { settings.paths as usize };
        let has_areas = scene.lights.iter().any(|light| light.kind.is_area());
        let rays = settings.occlusion_rays.clamp(1, MOST_OCCLUSION_RAYS) as usize;
        let rays = if scene.asks_openness(settings.layers) { rays } else { 0 };
        let reflects = settings.depth > 0 && scene.materials.iter().any(Material::is_rough);
        let reflections = if reflects { settings.reflections as usize } else { 0 };
        let layout = Self::new(points).with_paths(paths).with_reflections(reflections).with_occlusion(rays);
        let has_rough_glass = settings.depth > 0 && scene.materials.iter().any(Material::is_rough_glass);
        let is_seeded = layout.is_seeded || has_areas || has_rough_glass || scene.has_media();
        let varying = scene.materials.iter().map(Material::varying).fold(Varying::default(), Varying::with);
        Self { is_seeded, expires: anything_changes(scene), varying, ..layout }
    }

    /// Sets the number of paths by which samples gather light.
    pub fn with_paths(self, paths: usize) -> Self {
        Self { paths, is_seeded: self.is_seeded || paths > 0, ..self }
    }

    /// Sets the largest number of paths by which samples reflect.
    pub fn with_reflections(self, reflections: usize) -> Self {
        Self { reflections, is_seeded: self.is_seeded || reflections > 0, ..self }
    }

    /// Sets the number of samples' occlusion rays.
    pub fn with_occlusion(self, occlusion_rays: usize) -> Self {
        Self { occlusion_rays, is_seeded: self.is_seeded || occlusion_rays > 0, ..self }
    }

    /// Number of columns of each kind: of lights with one shadow ray a sample, and with more.
    pub fn columns(&self) -> (usize, usize) {
        (self.single, self.area)
    }

    /// Size of a sample's tags and gathered data, in bytes. Where nothing expires, expiries take no memory.
    pub fn bytes(&self) -> usize {
        self.bytes_with(if self.expires { PathList::MOST_BYTES } else { PathList::LEAST_BYTES })
    }

    /// Largest size of a sample's tags and gathered data, in bytes.
    pub fn most_bytes(&self) -> usize {
        self.bytes_with(PathList::MOST_BYTES)
    }

    fn bytes_with(&self, bytes_of_path: usize) -> usize {
        let tags = self.single * size_of::<Tag>() + self.area * size_of::<AreaTag>();
        tags + VariedColumn::bytes_of(self.varying) + GatheredLight::bytes_of_sample(self, bytes_of_path)
    }
}

/// Tags of a tile's samples for all lights: a column for each light, one after the other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tags {
    pub(super) single: Vec<Column<Tag>>,
    pub(super) area: Vec<Column<AreaTag>>,
}

impl Tags {
    /// Creates tags of which none is known.
    pub fn unknown(layout: &TagLayout) -> Self {
        Self {
            single: vec![[Tag::Unknown; CELLS]; layout.single],
            area: vec![[AreaTag::UNKNOWN; CELLS]; layout.area],
        }
    }

    /// Tag of one cell for one point of a light; lights that have no area have point 0 alone.
    #[inline]
    pub fn get(&self, slot: TagSlot, point: usize, cell: usize) -> Tag {
        match slot {
            TagSlot::Single(column) => self.single[column][cell],
            TagSlot::Area(column) => self.area[column][cell].get(point),
        }
    }

    /// Tags of a tile for a light that has no area, one a cell; empty for an area light.
    #[inline]
    pub fn single(&self, slot: TagSlot) -> &[Tag] {
        match slot {
            TagSlot::Single(column) => &self.single[column],
            TagSlot::Area(_) => &[],
        }
    }

    /// Mutable access to the tags that `single` returns.
    #[inline]
    pub fn single_mut(&mut self, slot: TagSlot) -> &mut [Tag] {
        match slot {
            TagSlot::Single(column) => &mut self.single[column],
            TagSlot::Area(_) => &mut [],
        }
    }

    /// Mask of those of eight cells that the light reaches.
    #[inline(always)]
    pub fn lit(&self, slot: TagSlot, point: usize, first: usize) -> Mask {
        match slot {
            TagSlot::Single(column) => {
                let tags = &self.single[column][first..first + LANES];
                Mask::new(|lane| tags[lane].is_lit())
            }
            TagSlot::Area(column) => {
                let tags = &self.area[column][first..first + LANES];
                Mask::new(|lane| tags[lane].lit() >> point & 1 != 0)
            }
        }
    }

    /// Tags of a tile for an area light, one a cell; empty for other lights.
    #[inline]
    pub fn area(&self, slot: TagSlot) -> &[AreaTag] {
        match slot {
            TagSlot::Single(_) => &[],
            TagSlot::Area(column) => &self.area[column],
        }
    }

    /// Mutable access to the tags that `area` returns.
    #[inline]
    pub fn area_mut(&mut self, slot: TagSlot) -> &mut [AreaTag] {
        match slot {
            TagSlot::Single(_) => &mut [],
            TagSlot::Area(column) => &mut self.area[column],
        }
    }

    /// Returns true if the tags of any surface for a light may change even if nothing new comes between: they
    /// are unknown, or name a model that may have gone.
    pub fn any_doubtful(&self, slot: TagSlot, models: &Column<u32>) -> bool {
        // no early exit: so many are compared at once
        let is_surface = |model: &u32| *model < EMPTY;
        match slot {
            TagSlot::Single(_) => self.single(slot).iter().zip(models).fold(false, |any, (tag, model)| {
                any | ((*tag == Tag::Unknown) | (*tag == Tag::DynamicOccluder)) & is_surface(model)
            }),
            TagSlot::Area(_) => self
                .area(slot)
                .iter()
                .zip(models)
                .fold(false, |any, (tag, model)| any | (tag.by_dynamic != 0) & is_surface(model)),
        }
    }

    /// Appends the tags of `cell` to lists, one a column.
    pub fn push_to(&self, cell: usize, single: &mut [Vec<Tag>], area: &mut [Vec<AreaTag>]) {
        single.iter_mut().zip(&self.single).for_each(|(list, column)| list.push(column[cell]));
        area.iter_mut().zip(&self.area).for_each(|(list, column)| list.push(column[cell]));
    }

    /// Sets the tags of `cell`, one a column.
    pub fn set(
        &mut self,
        cell: usize,
        single: impl Iterator<Item = Tag>,
        area: impl Iterator<Item = AreaTag>,
    ) {
        self.single.iter_mut().zip(single).for_each(|(column, tag)| column[cell] = tag);
        self.area.iter_mut().zip(area).for_each(|(column, tag)| column[cell] = tag);
    }

    /// Copies the tags of cell `at` of `from` to `cell`.
    #[inline]
    pub fn take_over(&mut self, cell: usize, from: &Self, at: usize) {
        for (to, from) in self.single.iter_mut().zip(&from.single) {
            to[cell] = from[at];
        }
        for (to, from) in self.area.iter_mut().zip(&from.area) {
            to[cell] = from[at];
        }
    }

    /// Copies tags from tiles; `sources` has the cells' tags and the spare samples of each.
    pub fn copy_all(&mut self, sources: &[(&Self, &Spares)], moves: &[Move]) {
        for (column, to) in self.single.iter_mut().enumerate() {
            copy_all(to, sources, moves, |(tags, spares)| (&tags.single[column], &spares.single[column]));
        }
        for (column, to) in self.area.iter_mut().enumerate() {
            copy_all(to, sources, moves, |(tags, spares)| (&tags.area[column], &spares.area[column]));
        }
    }

    /// Resets the tags of some cells.
    pub fn forget(&mut self, cells: &[u32]) {
        for column in &mut self.single {
            cells.iter().for_each(|cell| column[*cell as usize] = Tag::Unknown);
        }
        for column in &mut self.area {
            cells.iter().for_each(|cell| column[*cell as usize] = AreaTag::UNKNOWN);
        }
    }

    /// Resets all tags.
    pub fn forget_all(&mut self) {
        self.single.iter_mut().for_each(|column| column.fill(Tag::Unknown));
        self.area.iter_mut().for_each(|column| column.fill(AreaTag::UNKNOWN));
    }
}

/// Copies one column of tags; `column` looks it up in a source.
fn copy_all<'t, T: Copy + 't, S: Copy>(
    to: &mut Column<T>,
    sources: &[S],
    moves: &[Move],
    column: impl Fn(S) -> (&'t Column<T>, &'t Vec<T>),
) {
    let columns: Vec<_> = sources.iter().map(|source| column(*source)).collect();
    for Move { to: cell, source, from } in moves {
        let (cells, spares) = columns[usize::from(*source)];
        to[usize::from(*cell) % CELLS] = match Slot::new(usize::from(*from)) {
            Slot::Cell(cell) => cells[cell],
            Slot::Spare(number) => spares[number],
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_area_tag_keeps_each_point_by_itself() {
        let mut tag = AreaTag::UNKNOWN;
        assert_eq!(tag.points(Tag::Unknown), u16::MAX);
        // every fourth point is lit, the next in a still shadow, the next in a moving one, the last not asked
        tag.learn(0x7777, 0x1111, 0x4444);
        let all = [Tag::Lit, Tag::StaticOccluder, Tag::DynamicOccluder, Tag::Unknown];
        for point in 0..AREA_POINTS {
            assert_eq!(tag.get(point), all[point % 4], "{point}");
            assert_eq!(tag.points(all[point % 4]) >> point & 1, 1, "{point}");
        }
        assert_eq!(tag.lit(), 0x1111);
        let before = tag;
        tag.learn(1, 0, 0);
        assert_eq!((tag.get(0), tag.get(4)), (Tag::StaticOccluder, Tag::Lit), "the others stay");
        assert!(before.changes_light_to(tag), "and the light with it");
    }

    #[test]
    fn lights_of_both_sorts_have_columns_of_their_own() {
        let layout = TagLayout::new([1, 16, 1, 4].into_iter());
        assert_eq!(layout.bytes(), 2 + 2 * 4);
        let mut tags = Tags::unknown(&layout);
        for (light, slot) in layout.slots.iter().enumerate() {
            let lit = u16::from(light != 2) << light;
            match slot {
                TagSlot::Single(_) => {
                    tags.single_mut(*slot)[9] = if lit != 0 { Tag::Lit } else { Tag::StaticOccluder }
                }
                TagSlot::Area(_) => tags.area_mut(*slot)[9].learn(1 << light, lit, 0),
            }
        }
        let lit: Vec<u8> =
            layout.slots.iter().enumerate().map(|(light, slot)| tags.lit(*slot, light, 8).bits()).collect();
        assert_eq!(lit, [2, 2, 0, 2]);
        tags.forget(&[9]);
        assert_eq!(tags, Tags::unknown(&layout));
    }
}

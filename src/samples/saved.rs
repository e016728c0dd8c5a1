//! Tiles as bytes, for files: all that later frames need of them.
//!
//! In levels that have not all of their cells wanted, a tile begins with a bit for each cell: 1 if it is
//! wanted.
//!
//! A tile is the number of its spare samples (two bytes), its cells in their order, and the spare samples. A
//! cell is a byte (its [`Status`], a bit if it has a sample, a bit if that is a copy) and its sample, if it
//! has one. Numbers are little-endian.
//!
//! | of a sample | bytes |
//! |---|---|
//! | place: three floats; model | 16 |
//! | triangle, normal, geometric normal | 12 |
//! | reflectance, direct diffuse: three half floats each | 12 |
//! | the rendered frame in which it was traced, material, flags, footprint | 8 |
//! | what varies of its surface: roughness, metalness, opacity; colour of highlights; emission | 1 each; 3; 4 |
//! | a tag for each light without a size; two words for each other light | 1; 4 |
//! | with paths: radiance and `Until` of each; of their mean | 6 each; 8 |
//! | if layers reflect: direction to the eye for which paths were drawn; radiance and `Until` of each | 4; 6 each |
//! | with ambient occlusion: how many rays get away, `Until` | 4 |
//! | if anything is random: the seed | 4 |
//!
//! Samples that are seen by way of mirrors follow tiles, [some](MIRRORED_AT_ONCE) at a time, each of them [`MIRRORED_BYTES`] long: point,
//! weights, light and width (nine floats); model, triangle, normal; `Until`, paths; octave, frames without use.

use glam::Vec3;
use half::f16;
use serde::{Deserialize, Serialize};

use super::{
    AreaTag, BACKGROUND, CELLS, EMPTY, Flags, Footprint, GatheredLight, HalfColor, KeptPath, MOST_SPARES,
    MirroredSample, Octahedral, Openness, PathColor, PathLight, PathList, Record, Sample, Status, Tag,
    TagLayout, Tile, Traced, VariedColumn,
};
use crate::changes::Until;
use crate::lanes::LANES;
use crate::samples::varied::{pack, unpack};
use crate::scene::Scene;
use crate::scene::material::Varying;
use crate::shade::sampling::SampleSeed;
use crate::stereo::Eye;

/// Set of a tile's cells, a bit each.
pub type CellMask = [u8; CELLS / 8];

/// Saved samples of one level of a frame.
#[derive(Debug, Clone)]
pub struct LevelSamples<S> {
    /// Samples of the level.
    pub store: S,
    /// Wanted cells of each tile; `None` in the coarsest level, in which all are.
    pub wanted: Option<Vec<CellMask>>,
}

/// Name of one of the pictures that a frame is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct PictureName {
    /// Eye that sees the picture.
    pub eye: Eye,
    /// Number of the exposure, counted from 0 in the order of time, in a frame with a shutter or a lens.
    pub exposure: usize,
}

/// Saved samples of one picture.
#[derive(Debug, Clone)]
pub struct PictureSamples<S> {
    /// Name of the picture.
    pub picture: PictureName,
    /// Levels, from the coarsest on.
    pub levels: Vec<LevelSamples<S>>,
}

/// Shape of a renderer's sample stores.
#[derive(Debug, Clone)]
pub struct StoreShape<'a> {
    /// Number of tiles of each level of a picture.
    pub tiles: Vec<usize>,
    /// Layout of the samples' data.
    pub layout: &'a TagLayout,
    /// Eyes that see the frame.
    pub eyes: &'a [Eye],
    /// Number of exposures of each eye.
    pub exposures: usize,
}

impl StoreShape<'_> {
    /// Returns true if `pictures`, in order, are those of a frame, of all eyes and exposures: none is there twice.
    pub fn fits(&self, pictures: &[PictureName]) -> bool {
        let is_there = |name: &PictureName| self.eyes.contains(&name.eye) && name.exposure < self.exposures;
        let rises = pictures.windows(2).all(|pair| pair[0] < pair[1]);
        rises && pictures.iter().all(is_there) && pictures.len() == self.eyes.len() * self.exposures
    }
}

/// Bit of a cell that has a sample.
const HAS_SAMPLE: u8 = 0x40;
/// Bit of a cell whose sample is a copy: see [`Tile::copies`].
const IS_COPY: u8 = 0x80;

/// Largest size of a tile, in bytes.
pub fn most_bytes(layout: &TagLayout) -> usize {
    let sample = size_of::<[f32; 3]>() + size_of::<u32>() + size_of::<Record>() + layout.most_bytes();
    size_of::<u16>() + CELLS * (1 + sample) + MOST_SPARES * sample
}

/// Appends `tile` to `bytes`.
pub fn encode(tile: &Tile, bytes: &mut Vec<u8>) {
    bytes.extend((tile.spares.len() as u16).to_le_bytes());
    let varying = tile.varied.varying();
    for cell in 0..CELLS {
        let has_sample = tile.model[cell] != EMPTY;
        let is_copy = tile.copies[cell / LANES] >> (cell % LANES) & 1 != 0;
        let which = if has_sample { HAS_SAMPLE } else { 0 } | if is_copy { IS_COPY } else { 0 };
        bytes.push(tile.status[cell] as u8 | which);
        if has_sample {
            encode_sample(&tile.sample(cell), varying, bytes);
            bytes.extend(tile.tags.single.iter().map(|column| column[cell] as u8));
            bytes.extend(tile.tags.area.iter().flat_map(|column| column[cell].to_bytes()));
            encode_gathered(&tile.gathered, cell, bytes);
        }
    }
    let spares = &tile.spares;
    for (number, spare) in spares.samples.iter().enumerate() {
        encode_sample(spare, varying, bytes);
        bytes.extend(spares.single.iter().map(|tags| tags[number] as u8));
        bytes.extend(spares.area.iter().flat_map(|tags| tags[number].to_bytes()));
        encode_gathered(&spares.gathered, number, bytes);
    }
}

fn encode_sample(sample: &Sample, varying: Varying, bytes: &mut Vec<u8>) {
    let Sample { point, model, record, varied } = sample;
    let Record {
        triangle,
        normal,
        geometric_normal,
        reflectance,
        direct_diffuse,
        traced,
        material,
        flags,
        footprint,
    } = record;
    bytes.extend(point.to_array().into_iter().flat_map(f32::to_le_bytes));
    for word in [*model, *triangle, normal.to_bits(), geometric_normal.to_bits()] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend(reflectance.iter().chain(direct_diffuse).flat_map(|half| half.to_le_bytes()));
    bytes.extend(traced.to_bits().to_le_bytes());
    bytes.extend(material.to_le_bytes());
    bytes.extend([flags.to_bits(), footprint.to_byte()]);
    let (packed, count) = pack(varying, *varied);
    bytes.extend(&packed[..count]);
}

fn encode_gathered(gathered: &GatheredLight, at: usize, bytes: &mut Vec<u8>) {
    if gathered.is_some() {
        encode_paths(&gathered.paths, at, bytes);
        let PathLight { radiance, until } = gathered.mean(at);
        bytes.extend(radiance.iter().flat_map(|half| half.to_le_bytes()));
        bytes.extend(until.to_bits().to_le_bytes());
    }
    if gathered.reflects() {
        bytes.extend(gathered.drawn_for(at).to_bits().to_le_bytes());
        encode_paths(&gathered.reflected, at, bytes);
    }
    if let Some(Openness { open, until }) = gathered.openness.get(at) {
        bytes.extend(open.to_le_bytes());
        bytes.extend(until.to_bits().to_le_bytes());
    }
    if gathered.is_seeded() {
        bytes.extend(gathered.seed(at).to_bits().to_le_bytes());
    }
}

fn encode_paths(list: &PathList, at: usize, bytes: &mut Vec<u8>) {
    const UNKNOWN: KeptPath = KeptPath { light: PathColor::UNKNOWN, until: Until::FOREVER };
    for path in 0..list.paths() {
        let KeptPath { light, until } = list.path(at, path).unwrap_or(UNKNOWN);
        bytes.extend(light.to_bits().to_le_bytes());
        bytes.extend(until.to_bits().to_le_bytes());
    }
}

/// Bounds of the numbers in samples.
#[derive(Debug)]
pub struct Named<'a> {
    /// Scene with the models, triangles and materials that they refer to.
    pub scene: &'a Scene,
    /// Number of frames rendered so far: no sample is younger.
    pub rendered: u32,
}

/// Decodes a tile from `bytes`. `None` if they are not those of a tile of such a scene with such a layout: no
/// sample that is returned refers to anything that does not exist.
pub fn decode(bytes: &[u8], layout: &TagLayout, named: &Named<'_>) -> Option<Box<Tile>> {
    let mut bytes = Bytes(bytes);
    let mut tile = Box::new(Tile::empty(layout));
    let spares = usize::from(bytes.half_word()?);
    if spares > MOST_SPARES {
        return None;
    }
    for cell in 0..CELLS {
        let [byte] = bytes.take()?;
        tile.status[cell] = *Status::ALL.get(usize::from(byte & !(HAS_SAMPLE | IS_COPY)))?;
        tile.set_copy(cell, byte & IS_COPY != 0);
        if byte & HAS_SAMPLE != 0 {
            tile.put(cell, decode_sample(&mut bytes, layout.varying, named)?);
            for column in &mut tile.tags.single {
                column[cell] = decode_tag(&mut bytes)?;
            }
            for column in &mut tile.tags.area {
                column[cell] = AreaTag::from_bytes(bytes.take()?);
            }
            decode_gathered(&mut bytes, &mut tile.gathered, cell)?;
        }
    }
    let mut one = GatheredLight::unknown(layout, 1);
    for _ in 0..spares {
        tile.spares.samples.push(decode_sample(&mut bytes, layout.varying, named)?);
        for tags in &mut tile.spares.single {
            tags.push(decode_tag(&mut bytes)?);
        }
        for tags in &mut tile.spares.area {
            tags.push(AreaTag::from_bytes(bytes.take()?));
        }
        decode_gathered(&mut bytes, &mut one, 0)?;
        tile.spares.gathered.push(&one, 0);
    }
    bytes.0.is_empty().then_some(tile)
}

fn decode_sample(bytes: &mut Bytes<'_>, varying: Varying, named: &Named<'_>) -> Option<Sample> {
    let point = Vec3::new(bytes.float()?, bytes.float()?, bytes.float()?);
    let model = bytes.word()?;
    let record = Record {
        triangle: bytes.word()?,
        normal: Octahedral::from_bits(bytes.word()?),
        geometric_normal: Octahedral::from_bits(bytes.word()?),
        reflectance: bytes.color()?,
        direct_diffuse: bytes.color()?,
        traced: Traced::from_bits(bytes.word()?)?,
        material: bytes.half_word()?,
        flags: Flags::from_bits(bytes.byte()?)?,
        footprint: Footprint::from_byte(bytes.byte()?),
    };
    let varied = unpack(varying, bytes.first(VariedColumn::bytes_of(varying))?)?;
    let is_there = match model {
        BACKGROUND => true,
        EMPTY => false,
        _ => {
            let model = named.scene.models.get(model as usize)?;
            (record.triangle as usize) < model.mesh.count()
        }
    };
    let materials = named.scene.materials.len().max(1);
    let is_good = is_there && point.is_finite() && record.traced.frame() <= named.rendered;
    (is_good && usize::from(record.material) < materials).then_some(Sample { point, model, record, varied })
}

/// Samples that are seen by way of mirrors in one block.
pub const MIRRORED_AT_ONCE: usize = 1 << 14;

/// Size of one of them, in bytes.
pub const MIRRORED_BYTES: usize = 9 * size_of::<f32>() + 3 * size_of::<u32>() + 2 * size_of::<u16>() + 2;

/// Encodes samples that are seen by way of mirrors.
pub fn encode_mirrored(samples: &[MirroredSample]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(samples.len() * MIRRORED_BYTES);
    for sample in samples {
        let MirroredSample {
            point,
            weights,
            model,
            triangle,
            geometric_normal,
            light,
            width,
            until,
            paths,
            octave,
            unused,
        } = sample;
        let floats = point.to_array().into_iter().chain(*weights).chain(light.to_array()).chain([*width]);
        bytes.extend(floats.flat_map(f32::to_le_bytes));
        bytes.extend([*model, *triangle, geometric_normal.to_bits()].into_iter().flat_map(u32::to_le_bytes));
        bytes.extend([until.to_bits(), *paths].into_iter().flat_map(u16::to_le_bytes));
        bytes.extend([*octave as u8, *unused]);
    }
    bytes
}

/// Decodes a block of samples that are seen by way of mirrors. `None` if they are not those of such a scene.
pub fn decode_mirrored(bytes: &[u8], named: &Named<'_>) -> Option<Vec<MirroredSample>> {
    let mut bytes = Bytes(bytes);
    let mut samples = Vec::with_capacity(bytes.0.len() / MIRRORED_BYTES);
    while !bytes.0.is_empty() {
        let mut floats = [0.0; 9];
        for float in &mut floats {
            *float = bytes.float().filter(|float| float.is_finite())?;
        }
        let [x, y, z, u, v, r, g, b, width] = floats;
        let (model, triangle) = (bytes.word()?, bytes.word()?);
        let mesh = &named.scene.models.get(model as usize)?.mesh;
        if mesh.is_curved() || triangle as usize >= mesh.count() {
            return None;
        }
        samples.push(MirroredSample {
            point: Vec3::new(x, y, z),
            weights: [u, v],
            model,
            triangle,
            geometric_normal: Octahedral::from_bits(bytes.word()?),
            light: Vec3::new(r, g, b),
            width,
            until: Until::from_bits(bytes.half_word()?),
            paths: bytes.half_word()?,
            octave: bytes.byte()? as i8,
            unused: bytes.byte()?,
        });
    }
    Some(samples)
}

fn decode_tag(bytes: &mut Bytes<'_>) -> Option<Tag> {
    let [tag] = bytes.take()?;
    Tag::ALL.get(usize::from(tag)).copied()
}

/// Decodes into sample number `at`.
fn decode_gathered(bytes: &mut Bytes<'_>, gathered: &mut GatheredLight, at: usize) -> Option<()> {
    if gathered.is_some() {
        bytes.paths(&mut gathered.paths, at)?;
        gathered.means[at] =
            PathLight { radiance: bytes.color()?, until: Until::from_bits(bytes.half_word()?) };
    }
    if gathered.reflects() {
        gathered.set_drawn_for(at, Octahedral::from_bits(bytes.word()?));
        bytes.paths(&mut gathered.reflected, at)?;
    }
    if let Some(openness) = gathered.openness.get_mut(at) {
        *openness = Openness { open: bytes.half_word()?, until: Until::from_bits(bytes.half_word()?) };
        if usize::from(openness.open) > gathered.rays {
            return None;
        }
    }
    if gathered.is_seeded() {
        gathered.seeds[at] = SampleSeed::from_bits(bytes.word()?);
    }
    Some(())
}

/// Rest of some bytes.
struct Bytes<'b>(&'b [u8]);

impl Bytes<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*first)
    }

    /// The next `count` bytes.
    fn first(&mut self, count: usize) -> Option<&[u8]> {
        let (first, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(first)
    }

    fn word(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    fn half_word(&mut self) -> Option<u16> {
        self.take().map(u16::from_le_bytes)
    }

    fn byte(&mut self) -> Option<u8> {
        self.take().map(u8::from_le_bytes)
    }

    fn float(&mut self) -> Option<f32> {
        self.take().map(f32::from_le_bytes)
    }

    /// Colour, if every channel is finite.
    fn color(&mut self) -> Option<HalfColor> {
        let mut half = || self.take().map(f16::from_le_bytes).filter(|half| half.is_finite());
        Some([half()?, half()?, half()?])
    }

    /// Decodes the paths of sample number `at`.
    fn paths(&mut self, list: &mut PathList, at: usize) -> Option<()> {
        for path in 0..list.paths() {
            let light = PathColor::from_bits(self.word()?);
            let until = Until::from_bits(self.half_word()?);
            list.set(at, path, KeptPath { light, until });
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::animation::TransformTrack;
    use crate::changes::world::{mesh_of_two, model, scene};
    use crate::exposure::{TICKS, Tick};

    fn layout() -> TagLayout {
        TagLayout::new([1, 16, 1].into_iter()).with_paths(2).with_reflections(3).with_occlusion(8)
    }

    /// Creates a scene of two models of two triangles.
    fn world() -> Scene {
        let model = || model(mesh_of_two(), TransformTrack::identity());
        scene(vec![model(), model()], vec![])
    }

    /// Creates a tile with something of everything.
    fn tile(layout: &TagLayout) -> Tile {
        let mut tile = Tile::empty(layout);
        for cell in (0..CELLS).filter(|cell| cell % 5 != 0) {
            [tile.x[cell], tile.y[cell], tile.z[cell]] = [cell as f32, -0.5, 1e9];
            tile.model[cell] = if cell % 3 == 0 { BACKGROUND } else { (cell % 2) as u32 };
            tile.record[cell] = Record {
                triangle: (cell % 2) as u32,
                normal: Octahedral::fold(Vec3::new(1.0, cell as f32, -2.0)),
                geometric_normal: Octahedral::fold(Vec3::X),
                reflectance: [f16::from_f32(0.5); 3],
                direct_diffuse: [f16::from_f32(cell as f32); 3],
                traced: Traced::new(cell as u32, (cell % TICKS) as Tick),
                material: 0,
                flags: Flags::STALE.when(cell % 7 == 0).with(Flags::FROM_BEHIND.when(cell % 11 == 0)),
                footprint: Footprint::from_byte(cell as u8),
            };
            tile.status[cell] = Status::ALL[cell % Status::ALL.len()];
            tile.set_copy(cell, cell % 13 == 0);
            tile.tags.single[1][cell] = Tag::ALL[cell % Tag::ALL.len()];
            tile.tags.area[0][cell].learn(cell as u16, 0x5555, 0x0f0f);
            tile.gathered.begin(cell, SampleSeed::new(cell as u32, 1, 2, 3));
            let until = Until::from_bits(cell as u16);
            let light = PathColor::new(Vec3::splat(cell as f32), false);
            tile.gathered.paths.set(cell, 1, KeptPath { light, until });
            tile.gathered.paths.set(cell, 0, KeptPath { light, until: Until::FOREVER });
            tile.gathered.update_mean(cell);
            tile.gathered.set_drawn_for(cell, Octahedral::fold(Vec3::new(cell as f32, 9.0, 1.0)));
            let light = PathColor::new(Vec3::splat(0.25), cell % 2 == 0);
            tile.gathered.reflected.set(cell, 2, KeptPath { light, until: Until::FOREVER });
            tile.gathered.set_openness(cell, Openness { open: 8, until: Until::FOREVER });
        }
        for cell in [3, 4, 6] {
            let from = tile.clone();
            tile.spares.push(&from, cell);
        }
        tile
    }

    fn encoded(tile: &Tile) -> Vec<u8> {
        let mut bytes = Vec::new();
        encode(tile, &mut bytes);
        bytes
    }

    #[test]
    fn a_tile_comes_back_as_it_was() {
        let (layout, scene) = (layout(), world());
        let named = Named { scene: &scene, rendered: 1024 };
        let tile = tile(&layout);
        let bytes = encoded(&tile);
        assert!(bytes.len() <= most_bytes(&layout));
        let back = decode(&bytes, &layout, &named).expect("it is whole");
        assert_eq!(encoded(&back), bytes);
        assert_eq!(
            (back.model, back.x, back.record, back.status),
            (tile.model, tile.x, tile.record, tile.status)
        );
        assert_eq!((back.copies, &back.tags, &back.gathered), (tile.copies, &tile.tags, &tile.gathered));
        assert_eq!(
            (&back.spares.samples, &back.spares.gathered),
            (&tile.spares.samples, &tile.spares.gathered)
        );
        // no layout but its own, and no byte more or less
        assert!(decode(&bytes, &layout.clone().with_paths(3), &named).is_none());
        assert!(decode(&bytes[..bytes.len() - 1], &layout, &named).is_none());
        assert!(decode(&[&bytes[..], &[0]].concat(), &layout, &named).is_none());
        let empty = encoded(&Tile::empty(&layout));
        assert_eq!(empty.len(), 2 + CELLS);
        assert!(decode(&empty, &layout, &named).is_some());
    }

    fn mirrored(model: u32, triangle: u32) -> MirroredSample {
        MirroredSample {
            point: Vec3::new(1.0, -2.5, 3e9),
            weights: [0.25, 0.5],
            model,
            triangle,
            geometric_normal: Octahedral::fold(Vec3::NEG_Y),
            light: Vec3::new(0.1, 70_000.0, 0.0),
            width: 0.03,
            until: Until::from_bits(77),
            paths: 12,
            octave: -9,
            unused: 2,
        }
    }

    #[test]
    fn what_mirrors_show_comes_back_as_it_was() {
        let scene = world();
        let named = Named { scene: &scene, rendered: 1 };
        let samples = [mirrored(1, 0), mirrored(0, 1)];
        let bytes = encode_mirrored(&samples);
        assert_eq!(bytes.len(), 2 * MIRRORED_BYTES);
        assert_eq!(decode_mirrored(&bytes, &named).as_deref(), Some(&samples[..]));
        assert!(decode_mirrored(&bytes[1..], &named).is_none());
        for other in [mirrored(2, 0), mirrored(0, 2), MirroredSample { width: f32::NAN, ..samples[0] }] {
            assert!(decode_mirrored(&encode_mirrored(&[other]), &named).is_none(), "{other:?}");
        }
        let mut word = 7_u32;
        for _ in 0..2000 {
            let mut bytes = bytes.clone();
            word = word.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let at = word as usize % bytes.len();
            bytes[at] = (word >> 24) as u8;
            decode_mirrored(&bytes, &named);
        }
    }

    #[test]
    fn what_is_not_there_cannot_be_named() {
        let (layout, scene) = (layout(), world());
        let spoilt = |spoil: &dyn Fn(&mut Tile)| {
            let mut tile = tile(&layout);
            spoil(&mut tile);
            decode(&encoded(&tile), &layout, &Named { scene: &scene, rendered: 1024 }).is_some()
        };
        assert!(spoilt(&|_| ()));
        assert!(!spoilt(&|tile| tile.model[7] = 2));
        assert!(!spoilt(&|tile| (tile.model[7], tile.record[7].triangle) = (1, 2)));
        assert!(!spoilt(&|tile| tile.record[7].material = 900));
        assert!(!spoilt(&|tile| tile.record[7].traced = Traced::new(1025, 0)));
        assert!(!spoilt(&|tile| tile.x[7] = f32::NAN));
        assert!(!spoilt(&|tile| tile.record[7].reflectance[1] = f16::INFINITY));
        assert!(!spoilt(&|tile| tile.spares.samples[0].model = EMPTY));
        let bytes = encoded(&tile(&layout));
        for (at, byte) in [(1, 0xff), (2, 0x3f)] {
            let mut bytes = bytes.clone();
            bytes[at] = byte;
            assert!(decode(&bytes, &layout, &Named { scene: &scene, rendered: 1024 }).is_none(), "{at}");
        }
    }

    #[test]
    fn whatever_the_bytes_are_there_is_no_panic() {
        let (layout, scene) = (layout(), world());
        let whole = encoded(&tile(&layout));
        let mut word = 7_u32;
        for _ in 0..2000 {
            let mut bytes = whole.clone();
            for _ in 0..3 {
                word = word.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let at = word as usize % bytes.len();
                bytes[at] = (word >> 24) as u8;
            }
            decode(&bytes, &layout, &Named { scene: &scene, rendered: 1024 });
        }
    }
}

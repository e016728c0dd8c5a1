//! Sample stores in files: with one a later run continues where this one ends, with the same results as in
//! one run.
//!
//! A file consists of [`MAGIC`], the version of the format, the header (JSON, with its length before it), and
//! a block for each tile of each level of each picture of the frame (of two eyes, and of exposures that keep
//! samples of their own), with its length before it, and then blocks of what mirrors show in them. After the header and after each block there is a checksum
//! of everything before it. Numbers are little-endian. No content is trusted: no list is longer than the shot
//! itself needs, and references to things that do not exist are refused.

use std::cell::Cell;
use std::fmt;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::fingerprint::Fingerprint;
use super::staged::{WriteError, write_whole};
use crate::digest::Digest;
use crate::input::{self, InputError, Kind};
use crate::samples::saved::{self, CellMask, LevelSamples, Named, PictureName, PictureSamples, StoreShape};
use crate::samples::{ClearRegions, MirroredSamples, RegionNumbers, SampleStore, TagLayout, Tile};
use crate::scene::Scene;

/// The first bytes of a store.
pub const MAGIC: &[u8; 16] = b"afterimage store";

/// Version of the format. It counts up whenever the data that a sample keeps changes, or its meaning.
pub const VERSION: u32 = 13;

/// Maximum length of a header, bytes.
const MOST_HEADER: u32 = 1 << 20;

/// Bytes of tiles that are encoded, or decoded, at once.
const AT_ONCE: usize = 32 << 20;

/// True if checksums are compared. `fuzz/` takes them as right, or it would never reach what they protect.
const HAS_CHECKSUMS: bool = !cfg!(fuzzing);

/// Limit of the number of rendered frames: no run has as many.
const MOST_RENDERED: u32 = 1 << 30;

/// Description of a store's content.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Header {
    /// Fingerprint of the shot, and of everything that decides samples.
    pub fingerprint: Fingerprint,
    /// Number of the frame.
    pub frame: i32,
    /// Sampling of its pictures in words: samples a pixel, eyes and exposures.
    pub sampling: String,
    /// Ancestry of the frame, in the words of the schedule.
    pub ancestry: String,
    /// Number of frames that had been rendered in its chain: samples count their age from it.
    pub rendered: u32,
}

/// Header as written.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct HeaderText {
    fingerprint: String,
    frame: i32,
    sampling: String,
    ancestry: String,
    rendered: u32,
    pictures: Vec<PictureName>,
    /// Number of tiles of each level of each of them.
    tiles: Vec<u32>,
    /// Regions of each level of each of them, in which proofs hold that samples keep.
    regions: Vec<SavedRegions>,
    /// Number of samples that are seen by way of mirrors in each level of each of them.
    mirrored: Vec<u64>,
}

/// See [`ClearRegions::to_numbers`].
type SavedRegions = Vec<(u8, RegionNumbers)>;

/// A store that cannot be used. The text says why and what to do.
#[derive(Debug)]
pub struct StoreError {
    /// The file.
    pub path: PathBuf,
    /// Kind of the error.
    pub kind: StoreErrorKind,
}

/// Kind of error of a store.
#[derive(Debug)]
pub enum StoreErrorKind {
    /// It cannot be read.
    Unreadable(io::Error),
    /// It is a different kind of file.
    NoStore,
    /// It has another version of the format.
    Version(u32),
    /// Some of its bytes are not as they were written.
    Damaged,
    /// It ends too early.
    Short,
    /// It has samples that do not fit the shot.
    Unfit,
}

impl fmt::Display for StoreError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const AGAIN: &str = "render its frame again with --save-store, or go on without --load-store";
        write!(f, "{}: ", self.path.display())?;
        match &self.kind {
            StoreErrorKind::Unreadable(error) => {
                write!(f, "cannot be read: {error}; give a file that --save-store wrote")
            }
            StoreErrorKind::NoStore => f.write_str("is no sample store; give a file that --save-store wrote"),
            StoreErrorKind::Version(version) => {
                write!(f, "is a sample store of format {version}, and this program reads {VERSION}; {AGAIN}")
            }
            StoreErrorKind::Damaged => write!(f, "this sample store is damaged; {AGAIN}"),
            StoreErrorKind::Short => write!(f, "this sample store is not whole; {AGAIN}"),
            StoreErrorKind::Unfit => write!(f, "this sample store does not fit the shot; {AGAIN}"),
        }
    }
}

impl std::error::Error for StoreError {}

impl From<io::Error> for StoreErrorKind {
    fn from(error: io::Error) -> Self {
        if error.kind() == ErrorKind::UnexpectedEof { Self::Short } else { Self::Unreadable(error) }
    }
}

/// Writes the samples of a frame, whose tiles keep the data that `layout` says, to `path`: a whole file, or
/// none. Returns the number of bytes.
pub fn write(
    path: &Path,
    header: &Header,
    pictures: &[PictureSamples<&SampleStore>],
    layout: &TagLayout,
) -> Result<u64, WriteError> {
    let length = Cell::new(0);
    write_whole(path, |file| {
        let written = write_to(BufWriter::new(file), header, pictures, layout);
        length.set(written.map_err(|error| WriteError::new(path, error))?);
        Ok::<(), WriteError>(())
    })?;
    Ok(length.get())
}

fn write_to(
    mut out: impl Write,
    header: &Header,
    pictures: &[PictureSamples<&SampleStore>],
    layout: &TagLayout,
) -> io::Result<u64> {
    let levels = pictures.first().map_or(&[][..], |picture| &picture.levels);
    let text = HeaderText {
        fingerprint: header.fingerprint.to_string(),
        frame: header.frame,
        sampling: header.sampling.clone(),
        ancestry: header.ancestry.clone(),
        rendered: header.rendered,
        pictures: pictures.iter().map(|picture| picture.picture).collect(),
        tiles: levels.iter().map(|level| level.store.tiles.len() as u32).collect(),
        regions: (pictures.iter().flat_map(|picture| &picture.levels))
            .map(|level| level.store.regions.to_numbers())
            .collect(),
        mirrored: (pictures.iter().flat_map(|picture| &picture.levels))
            .map(|level| level.store.mirrored.all().len() as u64)
            .collect(),
    };
    let text = serde_json::to_vec(&text)?;
    let mut before = Vec::from(MAGIC);
    before.extend(VERSION.to_le_bytes());
    before.extend((text.len() as u32).to_le_bytes());
    before.extend(text);
    let mut sum = Digest::new(&before);
    out.write_all(&before)?;
    out.write_all(&sum.to_bytes())?;
    let mut length = (before.len() + size_of::<u64>()) as u64;
    let levels = pictures.iter().flat_map(|picture| &picture.levels);
    let tiles: Vec<(&Tile, Option<&CellMask>)> = levels.flat_map(tiles_of_level).collect();
    for tiles in tiles.chunks(tiles_at_once(layout)) {
        let encode = |(tile, wanted): &(&Tile, Option<&CellMask>)| {
            let mut block: Vec<u8> = wanted.iter().copied().flatten().copied().collect();
            saved::encode(tile, &mut block);
            let digest = Digest::new(&block);
            (block, digest)
        };
        let blocks: Vec<(Vec<u8>, Digest)> = tiles.par_iter().map(encode).collect();
        for (block, digest) in blocks {
            length += write_block(&mut out, &block, digest, &mut sum)?;
        }
    }
    let levels = pictures.iter().flat_map(|picture| &picture.levels);
    for some in levels.flat_map(|level| level.store.mirrored.all().chunks(saved::MIRRORED_AT_ONCE)) {
        let block = saved::encode_mirrored(some);
        length += write_block(&mut out, &block, Digest::new(&block), &mut sum)?;
    }
    out.flush()?;
    Ok(length)
}

/// Writes a block with its length before it and the checksum of all behind it. Returns the number of bytes.
fn write_block(out: &mut impl Write, block: &[u8], digest: Digest, sum: &mut Digest) -> io::Result<u64> {
    *sum = Digest::of_all([*sum, digest]);
    out.write_all(&(block.len() as u32).to_le_bytes())?;
    out.write_all(block)?;
    out.write_all(&sum.to_bytes())?;
    Ok((size_of::<u32>() + block.len() + size_of::<u64>()) as u64)
}

/// Tiles of a level, each with the cells that were asked for.
fn tiles_of_level<'a>(
    level: &'a LevelSamples<&SampleStore>,
) -> impl Iterator<Item = (&'a Tile, Option<&'a CellMask>)> {
    let wanted = |number: usize| level.wanted.as_ref().and_then(|wanted| wanted.get(number));
    level.store.tiles.iter().enumerate().map(move |(number, tile)| (&**tile, wanted(number)))
}

fn tiles_at_once(layout: &TagLayout) -> usize {
    (AT_ONCE / saved::most_bytes(layout)).max(1)
}

/// A file whose header has been read.
#[derive(Debug)]
pub struct StoreFile {
    path: PathBuf,
    header: Header,
    pictures: Vec<PictureName>,
    /// Number of tiles of each level of each of them.
    tiles: Vec<u32>,
    /// Regions of the levels that have not been read yet.
    regions: std::vec::IntoIter<SavedRegions>,
    /// Number of samples that are seen by way of mirrors in each level of each of them.
    mirrored: Vec<u64>,
    rest: BufReader<File>,
    /// Checksum of everything read so far.
    sum: Digest,
}

/// All that stands before the samples.
struct Beginning {
    header: Header,
    pictures: Vec<PictureName>,
    tiles: Vec<u32>,
    regions: Vec<SavedRegions>,
    mirrored: Vec<u64>,
    sum: Digest,
}

impl StoreFile {
    /// Opens the store at `path`, and reads its header.
    pub fn open(path: &Path) -> Result<Self, StoreError> {
        let told = |kind| StoreError { path: path.to_owned(), kind };
        let input = input::open(path, Kind::Store).map_err(|error| {
            told(match error {
                InputError::System(error) => StoreErrorKind::Unreadable(error),
                InputError::NoFile(_) | InputError::TooLarge(..) => StoreErrorKind::NoStore,
            })
        })?;
        let mut rest = BufReader::new(input.file);
        let Beginning { header, pictures, tiles, regions, mirrored, sum } =
            read_header(&mut rest).map_err(told)?;
        let regions = regions.into_iter();
        Ok(Self { path: path.to_owned(), header, pictures, tiles, regions, mirrored, rest, sum })
    }

    /// Description of its content.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Checks that all bytes are as they were written. Decodes nothing.
    pub fn check(mut self) -> Result<(), StoreError> {
        let tiles = self.pictures.len() * self.tiles.iter().map(|tiles| *tiles as usize).sum::<usize>();
        let of_mirrors = self.mirrored.iter().map(|count| count.div_ceil(saved::MIRRORED_AT_ONCE as u64));
        let blocks = tiles as u64 + of_mirrors.fold(0, u64::saturating_add);
        let length = self.rest.get_ref().metadata().map_or(0, |found| found.len());
        let most = usize::try_from(length).unwrap_or(usize::MAX);
        let outcome = (0..blocks).try_for_each(|_| self.block(most).map(drop));
        let outcome = outcome.and_then(|()| match self.rest.read(&mut [0])? {
            0 => Ok(()),
            _ => Err(StoreErrorKind::Damaged),
        });
        outcome.map_err(|kind| StoreError { path: self.path, kind })
    }

    /// Reads the samples, whose `shape` must be one that frames of `scene` may have.
    pub fn read(
        mut self,
        shape: &StoreShape<'_>,
        scene: &Scene,
    ) -> Result<Vec<PictureSamples<SampleStore>>, StoreError> {
        self.read_pictures(shape, scene).map_err(|kind| StoreError { path: self.path, kind })
    }

    fn read_pictures(
        &mut self,
        shape: &StoreShape<'_>,
        scene: &Scene,
    ) -> Result<Vec<PictureSamples<SampleStore>>, StoreErrorKind> {
        let StoreShape { tiles, layout, .. } = shape;
        let has_tiles = self.tiles.iter().map(|tiles| *tiles as usize).eq(tiles.iter().copied());
        if !has_tiles || !shape.fits(&self.pictures) {
            return Err(StoreErrorKind::Unfit);
        }
        let names = std::mem::take(&mut self.pictures);
        let picture = |picture| {
            let levels = (0..).zip(tiles).map(|(level, tiles)| self.level(level > 0, *tiles, layout, scene));
            Ok(PictureSamples { picture, levels: levels.collect::<Result<_, StoreErrorKind>>()? })
        };
        let mut pictures = names.into_iter().map(picture).collect::<Result<Vec<_>, StoreErrorKind>>()?;
        let mirrored = std::mem::take(&mut self.mirrored);
        if mirrored.len() != pictures.len() * tiles.len() {
            return Err(StoreErrorKind::Unfit);
        }
        let levels = pictures.iter_mut().flat_map(|picture| &mut picture.levels);
        for (level, count) in levels.zip(mirrored) {
            level.store.mirrored = self.mirrored(count, scene)?;
        }
        match self.rest.read(&mut [0])? {
            0 => Ok(pictures),
            _ => Err(StoreErrorKind::Damaged),
        }
    }

    /// Reads the next level. If it `is_finer` than another, it states which of its cells were asked for.
    fn level(
        &mut self,
        is_finer: bool,
        tiles: usize,
        layout: &TagLayout,
        scene: &Scene,
    ) -> Result<LevelSamples<SampleStore>, StoreErrorKind> {
        let named = Named { scene, rendered: self.header.rendered };
        let most = saved::most_bytes(layout) + size_of::<CellMask>();
        let (mut store, mut wanted) = (SampleStore::default(), is_finer.then(Vec::new));
        let decode = |block: &Vec<u8>| {
            let (mask, tile) = match is_finer {
                true => block.split_first_chunk().map(|(mask, tile)| (Some(*mask), tile))?,
                false => (None, &block[..]),
            };
            Some((mask, saved::decode(tile, layout, &named)?))
        };
        while store.tiles.len() < tiles {
            let count = tiles_at_once(layout).min(tiles - store.tiles.len());
            let blocks: Result<Vec<Vec<u8>>, StoreErrorKind> = (0..count).map(|_| self.block(most)).collect();
            let read: Vec<Option<(Option<CellMask>, Box<Tile>)>> = blocks?.par_iter().map(decode).collect();
            for read in read {
                let (mask, tile) = read.ok_or(StoreErrorKind::Unfit)?;
                store.tiles.push(tile);
                wanted.iter_mut().for_each(|wanted| wanted.extend(mask));
            }
        }
        let regions = self.regions.next().ok_or(StoreErrorKind::Unfit)?;
        store.regions = ClearRegions::from_numbers(&regions).ok_or(StoreErrorKind::Unfit)?;
        Ok(LevelSamples { store, wanted })
    }

    /// Reads the next `count` samples that are seen by way of mirrors.
    fn mirrored(&mut self, count: u64, scene: &Scene) -> Result<MirroredSamples, StoreErrorKind> {
        let named = Named { scene, rendered: self.header.rendered };
        let mut samples = Vec::new();
        while (samples.len() as u64) < count {
            let block = self.block(saved::MIRRORED_AT_ONCE * saved::MIRRORED_BYTES)?;
            let some = saved::decode_mirrored(&block, &named).ok_or(StoreErrorKind::Unfit)?;
            if some.is_empty() || (samples.len() + some.len()) as u64 > count {
                return Err(StoreErrorKind::Unfit);
            }
            samples.extend(some);
        }
        Ok(MirroredSamples::new(samples))
    }

    /// Reads the next block, of `most` bytes at most.
    fn block(&mut self, most: usize) -> Result<Vec<u8>, StoreErrorKind> {
        let length = u32::from_le_bytes(take(&mut self.rest)?) as usize;
        if length > most {
            return Err(StoreErrorKind::Damaged);
        }
        let mut block = vec![0; length];
        self.rest.read_exact(&mut block)?;
        self.sum = Digest::of_all([self.sum, Digest::new(&block)]);
        if Digest::from_bytes(take(&mut self.rest)?) != self.sum && HAS_CHECKSUMS {
            return Err(StoreErrorKind::Damaged);
        }
        Ok(block)
    }
}

fn take<const N: usize>(file: &mut impl Read) -> Result<[u8; N], StoreErrorKind> {
    let mut bytes = [0; N];
    file.read_exact(&mut bytes)?;
    Ok(bytes)
}

/// Reads all that stands before the samples.
fn read_header(file: &mut impl Read) -> Result<Beginning, StoreErrorKind> {
    let magic: [u8; MAGIC.len()] = match take(file) {
        Err(StoreErrorKind::Short) => return Err(StoreErrorKind::NoStore),
        magic => magic?,
    };
    if magic != *MAGIC {
        return Err(StoreErrorKind::NoStore);
    }
    let [version, length] = [take(file)?, take(file)?];
    match u32::from_le_bytes(version) {
        VERSION => {}
        other => return Err(StoreErrorKind::Version(other)),
    }
    let count = u32::from_le_bytes(length);
    if count > MOST_HEADER {
        return Err(StoreErrorKind::Damaged);
    }
    let mut text = vec![0; count as usize];
    file.read_exact(&mut text)?;
    let sum = Digest::new(&[&magic[..], &version, &length, &text].concat());
    if Digest::from_bytes(take(file)?) != sum && HAS_CHECKSUMS {
        return Err(StoreErrorKind::Damaged);
    }
    let text: HeaderText = serde_json::from_slice(&text).map_err(|_| StoreErrorKind::Damaged)?;
    let fingerprint = text.fingerprint.parse().map_err(|()| StoreErrorKind::Damaged)?;
    if !(1..MOST_RENDERED).contains(&text.rendered) {
        return Err(StoreErrorKind::Damaged);
    }
    let HeaderText { frame, sampling, ancestry, rendered, pictures, tiles, regions, mirrored, .. } = text;
    let header = Header { fingerprint, frame, sampling, ancestry, rendered };
    Ok(Beginning { header, pictures, tiles, regions, mirrored, sum })
}

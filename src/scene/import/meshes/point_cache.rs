//! Reads point caches: the positions of a mesh's points at several times, in one file. MDD (LightWave) and
//! PC2 (Point Cache 2 of 3ds Max), as Blender writes both.

use std::path::Path;

use crate::digest::Digest;
use crate::input::{self, InputError, Kind};
use crate::memory::{self, Need, Part};
use crate::scene::SceneError;

/// First bytes of a PC2 file.
const PC2_MARK: &[u8] = b"POINTCACHE2\0";

/// Bytes of a PC2 header: the mark, the version, points, first frame, frames a sample, samples.
const PC2_HEADER: usize = 32;

/// Bytes of an MDD header: samples, points.
const MDD_HEADER: usize = 8;

/// Bytes of a position.
const POINT: usize = 12;

/// The content of a point cache.
pub struct PointCache {
    /// Frame of the first sample.
    pub first: f64,
    /// Frames from a sample to the next one.
    pub every: f64,
    /// Positions by sample; object space, perhaps not finite.
    pub samples: Vec<Vec<[f32; 3]>>,
    /// Digest of the file.
    pub digest: Digest,
}

/// Layout of a file.
struct Layout {
    samples: usize,
    points: usize,
    /// Offset of the positions in the file, bytes.
    begins: u64,
    first: f64,
    every: f64,
    number: fn([u8; 4]) -> f32,
}

/// Reads the point cache at `path`.
///
/// # Errors
/// Where it cannot be read, is none, or is not as long as it says.
pub fn read(path: &Path) -> Result<PointCache, SceneError> {
    let unreadable =
        |error: InputError| SceneError::new(path, format!("the point cache cannot be read: {error}"));
    let input = input::open(path, Kind::PointCache).map_err(unreadable)?;
    // the text of it, and what is read of it
    let need = Need::new(Part::new(
        "the point cache",
        input.length.saturating_mul(2),
        "fewer shapes, a smaller model",
    ));
    need.check(&memory::left()).map_err(|error| SceneError::new(path, error.to_string()))?;
    let bytes = input.read_all().map_err(unreadable)?;
    let layout = layout_of(&bytes).map_err(|message| SceneError::new(path, message))?;
    let Layout { samples, points, begins, first, every, number } = layout;
    let position = |point: &[u8]| -> [f32; 3] {
        let axis = |at: usize| number([point[at], point[at + 1], point[at + 2], point[at + 3]]);
        [axis(0), axis(4), axis(8)]
    };
    let positions = |sample: &[u8]| sample.chunks_exact(POINT).map(position).collect();
    let samples =
        bytes[begins as usize..].chunks_exact(points * POINT).take(samples).map(positions).collect();
    Ok(PointCache { first, every, samples, digest: Digest::new(&bytes) })
}

fn layout_of(bytes: &[u8]) -> Result<Layout, String> {
    let layout = if bytes.starts_with(PC2_MARK) { pc2(bytes) } else { mdd(bytes) };
    let none = "this is no point cache: it must be an MDD or a PC2 file; export it again";
    let layout = layout.ok_or(none)?;
    let Layout { samples, points, begins, .. } = layout;
    let wanted = u128::from(begins) + samples as u128 * points as u128 * POINT as u128;
    if bytes.len() as u128 != wanted {
        return Err(format!(
            "the point cache says that it has {samples} samples of {points} points, which take {wanted} bytes, and it has {}: it \
             is cut off, or of another kind; export it again",
            bytes.len()
        ));
    }
    if samples == 0 || points == 0 {
        return Err(String::from("the point cache is empty: export it again"));
    }
    Ok(layout)
}

/// Reads the layout of a PC2 file, which is little-endian.
fn pc2(bytes: &[u8]) -> Option<Layout> {
    let word = |number: usize| -> Option<[u8; 4]> {
        let at = PC2_MARK.len() + 4 * number;
        bytes.get(at..at + 4)?.try_into().ok()
    };
    let count = |number| usize::try_from(i32::from_le_bytes(word(number)?)).ok();
    let [first, every] = [word(2)?, word(3)?].map(|word| f64::from(f32::from_le_bytes(word)));
    let every = if every > 0.0 && every.is_finite() { every } else { 1.0 };
    let first = if first.is_finite() { first } else { 1.0 };
    let begins = PC2_HEADER as u64;
    Some(Layout { samples: count(4)?, points: count(1)?, begins, first, every, number: f32::from_le_bytes })
}

/// Reads the layout of an MDD file, which is big-endian. Its times are in seconds, without a frame rate.
fn mdd(bytes: &[u8]) -> Option<Layout> {
    let count = |at: usize| {
        let word = bytes.get(at..at + 4)?.try_into().ok()?;
        usize::try_from(i32::from_be_bytes(word)).ok()
    };
    let (samples, points) = (count(0)?, count(4)?);
    let begins = (MDD_HEADER + 4 * samples) as u64;
    Some(Layout { samples, points, begins, first: 1.0, every: 1.0, number: f32::from_be_bytes })
}

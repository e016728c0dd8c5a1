//! Packing of planes into the bytes of a chunk: line by line, and in it channel by channel.

use std::fmt;
use std::ops::Range;

use half::f16;
use half::slice::HalfFloatSliceExt;

use crate::{Channel, Data, SampleType};

/// The largest finite half.
const HALF_MAX: f32 = 65504.0;

/// The first value that must not be stored.
#[derive(Debug)]
pub(crate) struct NotFinite {
    pub channel: String,
    pub column: usize,
    pub line: usize,
    pub value: f32,
}

impl fmt::Display for NotFinite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { channel, column, line, value } = self;
        write!(f, "channel {channel:?} holds {value} at pixel ({column}, {line}), not a finite number")
    }
}

/// Puts the lines `lines` of all channels into `packed`, in the order and byte order of the file.
pub(crate) fn pack_lines(
    channels: &[Channel<'_>],
    width: usize,
    lines: Range<usize>,
    packed: &mut Vec<u8>,
) -> Result<(), NotFinite> {
    packed.clear();
    for line in lines {
        for channel in channels {
            let columns = line * width..(line + 1) * width;
            match channel.data {
                Data::Floats(values) => {
                    check_finite(channel.name, line, &values[columns.clone()], f32::is_finite, |value| {
                        value
                    })?;
                    pack_values(channel.stored, &values[columns], packed);
                }
                Data::Halves(values) => {
                    let values = &values[columns];
                    check_finite(channel.name, line, values, f16::is_finite, f16::to_f32)?;
                    match channel.stored {
                        SampleType::Half => extend(packed, values, f16::to_le_bytes),
                        other => pack_values(other, &values.to_f32_vec(), packed),
                    }
                }
            }
        }
    }
    Ok(())
}

fn check_finite<T: Copy>(
    channel: &str,
    line: usize,
    values: &[T],
    is_finite: impl Fn(T) -> bool,
    to_float: impl Fn(T) -> f32,
) -> Result<(), NotFinite> {
    // The branch-free sum vectorises; only a line that fails it is searched.
    let all_finite = values.iter().fold(true, |finite, value| finite & is_finite(*value));
    if all_finite {
        return Ok(());
    }
    let column = values.iter().position(|value| !is_finite(*value)).unwrap_or(0);
    Err(NotFinite { channel: channel.to_owned(), column, line, value: to_float(values[column]) })
}

fn pack_values(stored: SampleType, values: &[f32], packed: &mut Vec<u8>) {
    match stored {
        SampleType::Half => pack_halves(values, packed),
        SampleType::Float => extend(packed, values, |value| value.to_le_bytes()),
        // `as` saturates: negative values become 0.
        SampleType::Uint => extend(packed, values, |value| (value.round() as u32).to_le_bytes()),
    }
}

/// Adds the bytes of each value: a loop without checks, which compilers turn into vector instructions.
fn extend<T: Copy, const N: usize>(packed: &mut Vec<u8>, values: &[T], bytes: impl Fn(T) -> [u8; N]) {
    let start = packed.len();
    packed.resize(start + values.len() * N, 0);
    for (to, value) in packed[start..].chunks_exact_mut(N).zip(values) {
        to.copy_from_slice(&bytes(*value));
    }
}

fn pack_halves(values: &[f32], packed: &mut Vec<u8>) {
    const BLOCK: usize = 256; // stays in the first-level cache, and on the stack
    let mut clamped = [0.0_f32; BLOCK];
    let mut halves = [f16::ZERO; BLOCK];
    for block in values.chunks(BLOCK) {
        let count = block.len();
        for (to, from) in clamped.iter_mut().zip(block) {
            *to = from.clamp(-HALF_MAX, HALF_MAX);
        }
        halves[..count].convert_from_f32_slice(&clamped[..count]);
        extend(packed, &halves[..count], f16::to_le_bytes);
    }
}

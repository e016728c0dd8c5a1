//! Packed data of binary layers: LZ4 blocks, and whole numbers as differences from one to the next.

use crate::scene::import::bytes::{Bytes, Check};

/// Bytes that a byte of an LZ4 block can stand for, at most.
const MOST_RATIO: u64 = 255;

/// Shortest run that an LZ4 block copies.
const LEAST_RUN: usize = 4;

/// Takes a number of things, of which each takes a quarter of a byte or more of what is packed.
pub fn count(at: &mut Bytes<'_>) -> Check<u64> {
    let count = at.u64()?;
    if count > at.left().saturating_mul(4 * MOST_RATIO) {
        return Err(format!("states {count} things, and {} bytes are left of the file", at.left()));
    }
    Ok(count)
}

/// Bytes for which memory is taken for a number, at most.
const BYTES_A_NUMBER: u64 = 16;

/// Takes a packed block; its bytes and their number are checked, and nothing is unpacked.
pub fn block<'a>(at: &mut Bytes<'a>, size: u64, left: u64) -> Check<&'a [u8]> {
    let packed = at.u64()?;
    let block = at.list(packed, 1)?;
    if size > packed.saturating_mul(MOST_RATIO) {
        return Err(format!("states {size} bytes in a block of {packed}"));
    }
    if size > left {
        return Err(format!("takes {size} bytes of memory, and {left} are left"));
    }
    Ok(block)
}

/// Takes a packed block of `size` bytes or less, and unpacks it.
pub fn unpacked(at: &mut Bytes<'_>, size: u64, left: u64) -> Check<Vec<u8>> {
    match block(at, size, left)?.split_first() {
        Some((0, block)) => lz4(block, size as usize),
        Some(_) => Err(String::from("is packed in pieces, which is not read")),
        None => Err(String::from("has an empty block")),
    }
}

/// Bytes of packed numbers before they are unpacked, at least.
fn least_bytes(count: u64) -> u64 {
    if count == 0 { 0 } else { 4 + count.div_ceil(4) }
}

/// Takes `count` packed numbers of 4 bytes without unpacking them.
pub fn skip_integers(at: &mut Bytes<'_>, count: u64, left: u64) -> Check {
    if count > left / BYTES_A_NUMBER {
        return Err(format!("states {count} numbers, and {left} bytes of memory are left"));
    }
    block(at, least_bytes(count), left)?;
    Ok(())
}

/// Takes `count` packed numbers.
pub fn integers(at: &mut Bytes<'_>, count: u64, left: u64) -> Check<Vec<u32>> {
    if count > left / BYTES_A_NUMBER {
        return Err(format!("states {count} numbers, and {left} bytes of memory are left"));
    }
    let mut ahead = *at;
    let packed = block(&mut ahead, least_bytes(count), left)?.len() as u64;
    if count == 0 {
        *at = ahead;
        return Ok(Vec::new());
    }
    // each number has 4 bytes or less
    let most = (least_bytes(count) + 4 * count).min(packed.saturating_mul(MOST_RATIO));
    let bytes = unpacked(at, most, left)?;
    let short = || String::from("has fewer numbers than it states");
    let (head, rest) = bytes.split_at_checked(4).ok_or_else(short)?;
    let (codes, mut rest) = rest.split_at_checked(count.div_ceil(4) as usize).ok_or_else(short)?;
    let common = i32::from_le_bytes(head.try_into().unwrap_or_default());
    let mut take = |size: usize| {
        let (number, after) = rest.split_at_checked(size).ok_or_else(short)?;
        rest = after;
        Ok::<&[u8], String>(number)
    };
    let mut before = 0_i32;
    (0..count as usize)
        .map(|place| {
            let step = match codes[place / 4] >> (2 * (place % 4)) & 3 {
                0 => common,
                1 => i32::from(take(1)?[0] as i8),
                2 => i32::from(i16::from_le_bytes(take(2)?.try_into().unwrap_or_default())),
                _ => i32::from_le_bytes(take(4)?.try_into().unwrap_or_default()),
            };
            before = before.wrapping_add(step);
            Ok(before as u32)
        })
        .collect()
}

/// Unpacks an LZ4 block (github.com/lz4/lz4, "LZ4 Block Format Description") of `most` bytes or less.
fn lz4(mut block: &[u8], most: usize) -> Check<Vec<u8>> {
    let damaged = || String::from("has a damaged block");
    let mut out: Vec<u8> = Vec::with_capacity(most);
    while let Some((token, mut rest)) = block.split_first() {
        let literals = length(&mut rest, token >> 4).ok_or_else(damaged)?;
        let (literals, mut rest) = rest.split_at_checked(literals).ok_or_else(damaged)?;
        if out.len() + literals.len() > most {
            return Err(damaged());
        }
        out.extend_from_slice(literals);
        if rest.is_empty() {
            return Ok(out);
        }
        let (back, after) = rest.split_at_checked(2).ok_or_else(damaged)?;
        rest = after;
        let back = usize::from(u16::from_le_bytes([back[0], back[1]]));
        let run = LEAST_RUN + length(&mut rest, token & 15).ok_or_else(damaged)?;
        if back == 0 || back > out.len() || out.len() + run > most {
            return Err(damaged());
        }
        let from = out.len() - back;
        (from..from + run).for_each(|place| out.push(out[place]));
        block = rest;
    }
    Err(damaged())
}

/// A length, of which four bits are known.
fn length(rest: &mut &[u8], first: u8) -> Option<usize> {
    let mut length = usize::from(first);
    let mut more = if first == 15 { u8::MAX } else { 0 };
    while more == u8::MAX {
        let (next, after) = rest.split_first()?;
        (more, *rest) = (*next, after);
        length += usize::from(more);
    }
    Some(length)
}

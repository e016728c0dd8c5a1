//! Numbers that a file keeps packed: by Zip (deflate), by Blosc with LZ4, or as they are; as floats, or as halves of these.
//!
//! Sources of the format: `openvdb/io/Compression.cc` of OpenVDB, and `README_CHUNK_FORMAT.rst` of C-Blosc.

use std::io::Read;

use half::f16;

use crate::scene::import::bytes::Bytes;

/// How numbers are packed: bits of a grid's flags.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Packing(pub u32);

impl Packing {
    const ZIP: u32 = 1;
    const ACTIVE: u32 = 2;
    const BLOSC: u32 = 4;

    /// Returns true if inactive values are left out where a mask says what they are.
    pub fn leaves_out_inactive(self) -> bool {
        self.0 & Self::ACTIVE != 0
    }

    /// Returns true if it is known.
    pub fn is_known(self) -> bool {
        self.0 & !(Self::ZIP | Self::ACTIVE | Self::BLOSC) == 0
    }
}

/// Reads `count` floats, which the file has as halves if `are_halves`.
pub fn floats(
    bytes: &mut Bytes<'_>,
    count: usize,
    packing: Packing,
    are_halves: bool,
) -> Result<Vec<f32>, String> {
    if are_halves {
        if count == 0 {
            return Ok(Vec::new());
        }
        let all = unpacked(bytes, count * 2, packing)?;
        let half = |two: &[u8]| f16::from_le_bytes([two[0], two[1]]).to_f32();
        return Ok(all.chunks_exact(2).map(half).collect());
    }
    let all = unpacked(bytes, count * 4, packing)?;
    Ok(all.chunks_exact(4).map(|four| f32::from_le_bytes([four[0], four[1], four[2], four[3]])).collect())
}

/// The next bytes, `size` once they are unpacked.
fn unpacked(bytes: &mut Bytes<'_>, size: usize, packing: Packing) -> Result<Vec<u8>, String> {
    if packing.0 & (Packing::ZIP | Packing::BLOSC) == 0 {
        return bytes.take(size).map(<[u8]>::to_vec);
    }
    // a length below zero is that of what is not packed
    let length = bytes.i64()?;
    let count = usize::try_from(length.unsigned_abs()).map_err(|_| damaged("a length"))?;
    let content = bytes.take(count)?;
    let all = if length <= 0 {
        content.to_vec()
    } else if packing.0 & Packing::BLOSC != 0 {
        of_blosc(content, size)?
    } else {
        let mut all = Vec::with_capacity(size);
        let deflated = flate2::read::ZlibDecoder::new(content);
        deflated.take(size as u64 + 1).read_to_end(&mut all).map_err(|_| damaged("what is zipped"))?;
        all
    };
    if all.len() == size { Ok(all) } else { Err(damaged("a length")) }
}

fn damaged(what: &str) -> String {
    format!("{what} in it makes no sense: it is damaged")
}

/// Bytes of a chunk's header.
const HEADER: usize = 16;

/// Unpacks a chunk of Blosc's.
fn of_blosc(chunk: &[u8], size: usize) -> Result<Vec<u8>, String> {
    const SHUFFLED: u8 = 1;
    const COPIED: u8 = 2;
    const BITS_SHUFFLED: u8 = 4;
    const NOT_DIVIDED: u8 = 16;
    const LZ4: u8 = 1;
    /// Least elements of a block, and most bytes of an element, if a block is divided by the bytes of its elements.
    const DIVIDED: (usize, usize) = (128, 16);
    let mut header = Bytes::new(chunk);
    let [_, _, flags, width] = header.array()?;
    let [total, block, packed] = [header.u32()?, header.u32()?, header.u32()?].map(|size| size as usize);
    if total != size || packed != chunk.len() || block == 0 || width == 0 {
        return Err(damaged("a chunk of Blosc's"));
    }
    if flags & COPIED != 0 {
        return header.take(size).map(<[u8]>::to_vec);
    }
    if flags >> 5 != LZ4 || flags & BITS_SHUFFLED != 0 {
        return Err(String::from("it is packed by Blosc in another way than by LZ4: save it with Zip"));
    }
    let width = usize::from(width);
    let mut all = Vec::with_capacity(size);
    for first in (0..size).step_by(block) {
        let length = block.min(size - first);
        let is_divided = flags & NOT_DIVIDED == 0
            && length == block
            && width <= DIVIDED.1
            && block / width >= DIVIDED.0
            && block % width == 0;
        let parts = if is_divided { width } else { 1 };
        let mut content = Bytes::new(chunk);
        content.go_to(u64::from(header.u32()?))?;
        let mut unpacked = Vec::with_capacity(length);
        for _ in 0..parts {
            let count = content.count()?;
            let (part, content) = (length / parts, content.take(count)?);
            if count == part {
                unpacked.extend_from_slice(content);
                continue;
            }
            let start = unpacked.len();
            unpacked.resize(start + part, 0);
            let written = lz4_flex::block::decompress_into(content, &mut unpacked[start..]);
            if written.ok() != Some(part) {
                return Err(damaged("a chunk of Blosc's"));
            }
        }
        if flags & SHUFFLED != 0 && width > 1 {
            let count = length / width;
            let of = |number: usize| {
                let (element, byte) = (number / width, number % width);
                if element < count { unpacked[byte * count + element] } else { unpacked[number] }
            };
            all.extend((0..length).map(of));
        } else {
            all.append(&mut unpacked);
        }
    }
    debug_assert!(header_is_passed(&header, size.div_ceil(block)), "a start for each block");
    Ok(all)
}

/// Returns true if as much of a chunk was read in order as its header and the starts of its blocks take.
fn header_is_passed(header: &Bytes<'_>, blocks: usize) -> bool {
    header.place() == (HEADER + 4 * blocks) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chunk(flags: u8, width: u8, total: u32, block: u32, rest: &[u8]) -> Vec<u8> {
        let mut chunk = vec![2, 1, flags, width];
        for number in [total, block, (HEADER + rest.len()) as u32] {
            chunk.extend(number.to_le_bytes());
        }
        chunk.extend(rest);
        chunk
    }

    #[test]
    fn chunks_of_blosc_are_what_went_in() {
        let plain: Vec<u8> = (0..96_u32).flat_map(|number| (number / 3).to_le_bytes()).collect();
        assert_eq!(of_blosc(&chunk(2, 4, 384, 384, &plain), 384), Ok(plain.clone()));
        // the bytes of all elements, the first ones first
        let shuffled: Vec<u8> = (0..4).flat_map(|byte| plain.iter().skip(byte).step_by(4).copied()).collect();
        let packed = lz4_flex::block::compress(&shuffled);
        let mut rest = 20_u32.to_le_bytes().to_vec();
        rest.extend((packed.len() as u32).to_le_bytes());
        rest.extend(&packed);
        assert_eq!(of_blosc(&chunk(1 | 1 << 5, 4, 384, 384, &rest), 384), Ok(plain.clone()));
        for length in 0..rest.len() {
            let cut = chunk(1 | 1 << 5, 4, 384, 384, &rest[..length]);
            assert!(of_blosc(&cut, 384).is_err(), "{length}");
        }
        assert!(of_blosc(&chunk(1 | 2 << 5, 4, 384, 384, &rest), 384).is_err(), "Snappy");
        assert!(of_blosc(&chunk(1 | 1 << 5, 4, 384, 0, &rest), 384).is_err(), "blocks of nothing");
    }
}

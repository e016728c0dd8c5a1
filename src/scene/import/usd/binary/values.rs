//! Values of a binary layer: how much memory they take, and that they end.

use super::Layer;
use super::packed::skip_integers;
use crate::scene::import::bytes::{Bytes, Check};

/// Most values within each other: the library calls itself for each.
const MOST_DEPTH: usize = 64;

/// Fewest elements that are packed.
const LEAST_PACKED: u64 = 4;

/// Memory for a reference, a time with its value, or an entry of a dictionary, beside their texts.
const BYTES_AN_ENTRY: u64 = 128;

/// Memory for a text in a list, beside its letters.
const BYTES_A_TEXT: u64 = 32;

/// Looks at values, and at texts of lists, of any file: a fraction of a second. Larger files have more of them.
const LEAST_LOOKS: u64 = 1 << 28;
const LOOKS_A_BYTE: u64 = 16;

/// Flags of a value, and the bits of its place.
const ARRAY: u64 = 1 << 63;
const INLINED: u64 = 1 << 62;
const PACKED: u64 = 1 << 61;
const PLACE: u64 = (1 << 48) - 1;

/// Bytes of an element of types 1 to 30, in the order of the format (OpenUSD, crateDataTypes.h).
const SIZES: [u64; 30] =
    [1, 1, 4, 4, 8, 8, 2, 4, 8, 4, 4, 4, 32, 72, 128, 32, 16, 8, 16, 8, 4, 8, 24, 12, 6, 12, 32, 16, 8, 16];

// other types
const STRING: u64 = 10;
const TOKEN: u64 = 11;
const ASSET: u64 = 12;
const DICTIONARY: u64 = 31;
const TOKEN_EDIT: u64 = 32;
const STRING_EDIT: u64 = 33;
const PATH_EDIT: u64 = 34;
const REFERENCE_EDIT: u64 = 35;
const INT_EDIT: u64 = 36;
const INT64_EDIT: u64 = 37;
const UINT_EDIT: u64 = 38;
const UINT64_EDIT: u64 = 39;
const PATHS: u64 = 40;
const TOKENS: u64 = 41;
const VARIANTS: u64 = 45;
const SAMPLES: u64 = 46;
const DOUBLES: u64 = 48;
const OFFSETS: u64 = 49;
const STRINGS: u64 = 50;
const UNKNOWN_EDIT: u64 = 54;
const PAYLOAD_EDIT: u64 = 55;
const TIME: u64 = 56;
const PATTERN: u64 = 57;
const RELOCATES: u64 = 58;

/// A walk over values.
struct Values<'a> {
    layer: &'a Layer<'a>,
    /// Looks that are left: values that lead to one another in circles have no end.
    left: u64,
}

impl Layer<'_> {
    /// Checks the values of all fields.
    pub(super) fn check_values(&self, values: &[u64]) -> Check {
        let mut walk =
            Values { layer: self, left: LEAST_LOOKS.max(LOOKS_A_BYTE.saturating_mul(self.file.all())) };
        values.iter().try_for_each(|value| walk.value(*value, 0).map(|_| ()))
    }
}

impl Values<'_> {
    /// Checks a value. Returns the memory that it takes.
    fn value(&mut self, value: u64, depth: usize) -> Check<u64> {
        if depth > MOST_DEPTH {
            return Err(format!("its values are nested more than {MOST_DEPTH} deep"));
        }
        self.left = self.left.checked_sub(1).ok_or("its values lead in circles")?;
        let (kind, place) = (value >> 48 & 0xff, value & PLACE);
        if value & (ARRAY | INLINED) == INLINED {
            return Ok(0);
        }
        let mut at = match self.layer.file.from(place) {
            Some(at) => at,
            None => return Err(String::from("a value is beyond its end")),
        };
        let bytes = self.of_kind((kind, value), &mut at, depth).map_err(|why| match depth {
            0 => format!("a value: {why}"),
            _ => why,
        })?;
        self.left = self.left.saturating_sub(bytes / BYTES_A_TEXT);
        match bytes <= self.layer.left {
            true => Ok(bytes),
            false => Err(format!("takes {bytes} bytes of memory, and {} are left", self.layer.left)),
        }
    }

    fn of_kind(&mut self, (kind, value): (u64, u64), at: &mut Bytes<'_>, depth: usize) -> Check<u64> {
        let (is_array, place) = (value & ARRAY != 0, value & PLACE);
        let text = |at: &mut Bytes<'_>, of: &[u64]| {
            let count = at.u64()?;
            lengths(at, count, of)
        };
        let Layer { tokens, strings, paths, .. } = self.layer;
        match kind {
            STRING | ASSET | PATTERN if is_array && place == 0 => Ok(0),
            STRING | ASSET | PATTERN if is_array => text(at, strings),
            TOKEN if is_array => {
                let (count, _) = self.length(value, at)?;
                lengths(at, count, tokens)
            }
            STRINGS => text(at, strings),
            TOKENS => text(at, tokens),
            PATHS => text(at, paths),
            1..=30 if is_array => self.array(kind, SIZES[kind as usize - 1], value, at),
            TIME if is_array => self.array(kind, 8, value, at),
            DOUBLES => self.array(DOUBLES, 8, value, at),
            DICTIONARY => self.dictionary(at, depth),
            TOKEN_EDIT => edit(at, |at| text(at, tokens)),
            STRING_EDIT | UNKNOWN_EDIT => edit(at, |at| text(at, strings)),
            PATH_EDIT => edit(at, |at| text(at, paths)),
            INT_EDIT | UINT_EDIT => edit(at, |at| plain(at, 4)),
            INT64_EDIT | UINT64_EDIT => edit(at, |at| plain(at, 8)),
            REFERENCE_EDIT => edit(at, |at| self.arcs(at, true, depth)),
            PAYLOAD_EDIT => edit(at, |at| self.arcs(at, false, depth)),
            VARIANTS | RELOCATES => plain(at, 8).map(|bytes| bytes.saturating_mul(BYTES_AN_ENTRY)),
            OFFSETS => plain(at, 16),
            SAMPLES => self.samples(at, depth),
            _ => Ok(0),
        }
    }

    /// Number of elements of an array, and whether they are packed.
    fn length(&self, value: u64, at: &mut Bytes<'_>) -> Check<(u64, bool)> {
        if value & PLACE == 0 {
            return Ok((0, false));
        }
        if self.layer.version < (0, 5) {
            at.u32()?;
        }
        let count = if self.layer.version < (0, 7) { u64::from(at.u32()?) } else { at.u64()? };
        Ok((count, value & PACKED != 0 && count >= LEAST_PACKED))
    }

    fn array(&self, kind: u64, size: u64, value: u64, at: &mut Bytes<'_>) -> Check<u64> {
        let (count, is_packed) = self.length(value, at)?;
        let left = self.layer.left;
        match (is_packed, kind) {
            (true, 3..=6) if self.layer.version >= (0, 5) => skip_integers(at, count, left)?,
            (true, 7..=9 | TIME | DOUBLES) if self.layer.version >= (0, 6) => {
                if at.byte()? == b't' {
                    let table = u64::from(at.u32()?);
                    at.list(table, size)?;
                }
                skip_integers(at, count, left)?;
            }
            _ => {
                at.list(count, size)?;
            }
        }
        Ok(count.saturating_mul(size.max(4)))
    }

    fn dictionary(&mut self, at: &mut Bytes<'_>, depth: usize) -> Check<u64> {
        let count = at.u64()?;
        let mut bytes = 0_u64;
        for _ in 0..count {
            let key = at.u32()? as usize;
            bytes += self.layer.strings.get(key).ok_or("has a name that is not there")? + BYTES_AN_ENTRY;
            jump(at)?;
            let value = at.u64()?;
            bytes = bytes.saturating_add(self.value(value, depth + 1)?);
        }
        Ok(bytes)
    }

    /// References or payloads.
    fn arcs(&mut self, at: &mut Bytes<'_>, is_reference: bool, depth: usize) -> Check<u64> {
        let count = at.u64()?;
        let has_offset = is_reference || self.layer.version >= (0, 8);
        let size = 8 + if has_offset { 16 } else { 0 };
        if count > at.left() / size {
            return Err(format!("states {count} layers, and {} bytes are left of the file", at.left()));
        }
        let mut bytes = 0_u64;
        for _ in 0..count {
            let (layer, path) = (at.u32()? as usize, at.u32()? as usize);
            let layer = self.layer.strings.get(layer).ok_or("names a layer that is not there")?;
            let path = self.layer.paths.get(path).ok_or("names a path that is not there")?;
            bytes = bytes.saturating_add(layer + path + BYTES_AN_ENTRY);
            at.list(size - 8, 1)?;
            if is_reference {
                bytes = bytes.saturating_add(self.dictionary(at, depth + 1)?);
            }
        }
        Ok(bytes)
    }

    /// Values with times, all of which are read at once.
    fn samples(&mut self, at: &mut Bytes<'_>, depth: usize) -> Check<u64> {
        let mut ahead = *at;
        jump(&mut ahead)?;
        let times = ahead.u64()?;
        let mut bytes = self.value(times, depth + 1)?;
        jump(&mut ahead)?;
        let count = ahead.u64()?;
        let values = ahead.list(count, 8)?;
        for value in values.chunks_exact(8) {
            let value = u64::from_le_bytes(value.try_into().unwrap_or_default());
            let own = self.value(value, depth + 1)?;
            bytes = bytes.saturating_add(own).saturating_add(BYTES_AN_ENTRY);
        }
        Ok(bytes)
    }
}

/// Goes to where an offset leads, which counts from the place before it.
fn jump(at: &mut Bytes<'_>) -> Check {
    let place = at.place();
    let offset = at.u64()? as i64;
    let to = place.checked_add_signed(offset).and_then(|to| at.from(to));
    *at = to.ok_or("leads beyond the file's end")?;
    Ok(())
}

/// Takes indices of texts or paths. Returns the memory of all of them.
fn lengths(at: &mut Bytes<'_>, count: u64, of: &[u64]) -> Check<u64> {
    let indices = at.list(count, 4)?.chunks_exact(4);
    indices.into_iter().try_fold(0_u64, |sum, index| {
        let index = u32::from_le_bytes(index.try_into().unwrap_or_default());
        let length = of.get(index as usize).ok_or("names what is not there")?;
        Ok(sum.saturating_add(length + BYTES_A_TEXT))
    })
}

/// Takes a list of things of `size` bytes.
fn plain(at: &mut Bytes<'_>, size: u64) -> Check<u64> {
    let count = at.u64()?;
    Ok(at.list(count, size)?.len() as u64)
}

/// Takes the lists of an edit, those that its first byte says.
fn edit<'a>(at: &mut Bytes<'a>, mut read: impl FnMut(&mut Bytes<'a>) -> Check<u64>) -> Check<u64> {
    let flags = at.byte()?;
    let lists = (flags >> 1 & 0b11_1111).count_ones();
    (0..lists).try_fold(0_u64, |sum, _| Ok(sum.saturating_add(read(at)?)))
}

//! Checks binary layers (`.usdc`) before the library reads them.
//!
//! The library takes memory for as many things as a file states, follows its offsets wherever they lead, and calls itself for what is nested:
//! a damaged file would end the program, or never end. So each number is compared here with the bytes that are there, each offset is
//! followed once, and what all of it takes in memory is summed up. Values themselves are not read.

mod packed;
mod values;

use packed::{count, integers, unpacked};

use crate::scene::import::bytes::{Bytes, Check};

/// First bytes of a binary layer.
pub const MAGIC: &[u8] = b"PXR-USDC";

/// Most prims, variants and properties above one another: more than are walked over.
const MOST_LEVELS: u32 = 1024;

/// Largest number of sections, as in the library.
const MOST_SECTIONS: u64 = 64;

/// Bytes that a path takes beside its letters, about.
const BYTES_A_PATH: u64 = 64;

/// Version from which on sections are packed: older files are not read.
const OLDEST: (u8, u8) = (0, 4);

/// A layer whose structure is sound.
struct Layer<'a> {
    file: Bytes<'a>,
    version: (u8, u8),
    /// Lengths of the tokens, and of the tokens that strings are.
    tokens: Vec<u64>,
    strings: Vec<u64>,
    /// Lengths of the paths.
    paths: Vec<u64>,
    left: u64,
}

/// Checks a layer. `left`: bytes of memory for any of its values, and for all of its paths.
///
/// # Errors What is wrong, as a part of a sentence.
pub fn check(file: &[u8], left: u64) -> Check {
    let mut layer = Layer {
        file: Bytes::new(file),
        version: OLDEST,
        tokens: Vec::new(),
        strings: Vec::new(),
        paths: Vec::new(),
        left,
    };
    let sections = layer.sections()?;
    let mut section = |name: &str, read: &mut dyn FnMut(&mut Layer<'_>, Bytes<'_>) -> Check| -> Check {
        let Some((_, start)) = sections.iter().find(|(own, _)| own == name) else { return Ok(()) };
        let at = Bytes::new(file).from(*start);
        let at = at.ok_or_else(|| format!("its part {name} begins after its end"))?;
        read(&mut layer, at).map_err(|why| format!("its part {name}: {why}"))
    };
    let (mut values, mut fields, mut sets) = (Vec::new(), 0, 0);
    section("TOKENS", &mut |layer, at| layer.read_tokens(at))?;
    section("STRINGS", &mut |layer, at| layer.read_strings(at))?;
    section("FIELDS", &mut |layer, at| {
        values = layer.read_fields(at)?;
        Ok(())
    })?;
    fields += values.len() as u64;
    section("FIELDSETS", &mut |layer, mut at| {
        sets = count(&mut at)?;
        let list = integers(&mut at, sets, layer.left)?;
        match list.iter().all(|field| *field == u32::MAX || u64::from(*field) < fields) {
            true => Ok(()),
            false => Err(String::from("names fields that are not there")),
        }
    })?;
    section("PATHS", &mut |layer, at| layer.read_paths(at))?;
    section("SPECS", &mut |layer, mut at| {
        let count = count(&mut at)?;
        let is_there = |list: &[u32], count: u64| list.iter().all(|index| u64::from(*index) < count);
        let (paths, own) = (integers(&mut at, count, layer.left)?, integers(&mut at, count, layer.left)?);
        integers(&mut at, count, layer.left)?;
        match is_there(&paths, layer.paths.len() as u64) && is_there(&own, sets) {
            true => Ok(()),
            false => Err(String::from("names paths or fields that are not there")),
        }
    })?;
    layer.check_values(&values)
}

impl Layer<'_> {
    /// Names and places of the sections.
    fn sections(&mut self) -> Check<Vec<(String, u64)>> {
        let short = || String::from("its head is not complete");
        let mut head = self.file;
        let magic = head.take(8).map_err(|_| short())?;
        let version = head.take(8).map_err(|_| short())?;
        if magic != MAGIC {
            return Err(short());
        }
        self.version = (version[0], version[1]);
        if self.version < OLDEST {
            let (major, minor) = self.version;
            return Err(format!("it has the old version {major}.{minor}: save it with a newer program"));
        }
        let start = head.u64().map_err(|_| short())?;
        let mut table = self.file.from(start).ok_or("its table of parts is beyond its end")?;
        let count = table.u64()?;
        if count == 0 || count >= MOST_SECTIONS {
            return Err(String::from("its table of parts is damaged"));
        }
        (0..count)
            .map(|_| {
                let name = table.take(16)?;
                let end = name.iter().position(|byte| *byte == 0).unwrap_or(name.len());
                let name = String::from_utf8_lossy(&name[..end]).into_owned();
                let start = table.u64()?;
                table.u64()?;
                Ok((name, start))
            })
            .collect()
    }

    fn read_tokens(&mut self, mut at: Bytes<'_>) -> Check {
        let (count, size) = (at.u64()?, at.u64()?);
        let text = unpacked(&mut at, size, self.left)?;
        let Some((0, text)) = text.split_last() else {
            return if count == 0 && text.is_empty() { Ok(()) } else { Err(String::from("has no end")) };
        };
        self.tokens = text.split(|byte| *byte == 0).map(|token| token.len() as u64).collect();
        if self.tokens.len() as u64 != count {
            return Err(format!("states {count} names, and has {}", self.tokens.len()));
        }
        Ok(())
    }

    fn read_strings(&mut self, mut at: Bytes<'_>) -> Check {
        let count = count(&mut at)?;
        let indices = at.list(count, 4)?;
        let token = |index: &[u8]| {
            let index = u32::from_le_bytes(index.try_into().unwrap_or_default());
            self.tokens.get(index as usize).copied().ok_or("names what is not there")
        };
        self.strings = indices.chunks_exact(4).map(token).collect::<Result<_, _>>()?;
        Ok(())
    }

    /// Returns the fields' values.
    fn read_fields(&mut self, mut at: Bytes<'_>) -> Check<Vec<u64>> {
        let count = count(&mut at)?;
        let names = integers(&mut at, count, self.left)?;
        if names.iter().any(|name| *name as usize >= self.tokens.len()) {
            return Err(String::from("has names that are not there"));
        }
        let size = count.checked_mul(8).ok_or("states too many fields")?;
        let values = unpacked(&mut at, size, self.left)?;
        let values: Vec<u64> = values
            .chunks_exact(8)
            .map(|value| u64::from_le_bytes(value.try_into().unwrap_or_default()))
            .collect();
        if values.len() as u64 != count {
            return Err(format!("states {count} fields, and has {}", values.len()));
        }
        Ok(values)
    }

    /// Follows the tree of paths as the library does.
    fn read_paths(&mut self, mut at: Bytes<'_>) -> Check {
        let (all, count) = (at.u64()?, count(&mut at)?);
        if all > self.left / BYTES_A_PATH || all > count.saturating_add(1) {
            return Err(format!("states {all} paths, and has {count}"));
        }
        let indices = integers(&mut at, count, self.left)?;
        let names = integers(&mut at, count, self.left)?;
        let jumps = integers(&mut at, count, self.left)?;
        self.paths = vec![0; all as usize];
        let mut is_seen = vec![false; count as usize];
        // places in the lists, with the length and the level of what is above
        let mut waiting = vec![(0_usize, 0_u64, 0_u32)];
        let mut sum = 0_u64;
        while let Some((mut place, mut above, mut level)) = waiting.pop() {
            loop {
                if place >= is_seen.len() {
                    if count == 0 {
                        break;
                    }
                    return Err(String::from("leads beyond its end"));
                }
                if std::mem::replace(&mut is_seen[place], true) {
                    return Err(String::from("leads in circles"));
                }
                let name = (names[place] as i32).unsigned_abs() as usize;
                let own = match level {
                    0 => 1,
                    _ => *self.tokens.get(name).ok_or("has names that are not there")? + 1,
                };
                let length = above + own;
                let path =
                    self.paths.get_mut(indices[place] as usize).ok_or("names paths that are not there")?;
                *path = length;
                sum = sum.saturating_add(length + BYTES_A_PATH);
                let jump = jumps[place] as i32;
                let (has_child, has_sibling) = (jump > 0 || jump == -1, jump >= 0);
                if has_child && has_sibling {
                    waiting.push((place + jump as usize, above, level));
                }
                if has_child {
                    (above, level) = (length, level + 1);
                } else if !has_sibling {
                    break;
                }
                if level > MOST_LEVELS || sum > self.left {
                    return Err(format!(
                        "has paths of more than {MOST_LEVELS} names, or more than fit into memory"
                    ));
                }
                place += 1;
            }
        }
        Ok(())
    }
}

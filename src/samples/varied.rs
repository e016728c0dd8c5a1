//! Parameters of surfaces that vary from place to place, of the samples of a tile: those that vary in the shot, and no others.

use super::CELLS;
use crate::scene::look::Varied;
use crate::scene::material::Varying;
use crate::scene::shared_exponent::SharedExponent;

/// What varies of the samples in a tile's cells, packed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VariedColumn {
    varying: Varying,
    /// Bytes of each cell, one cell after the other; empty where nothing varies.
    bytes: Vec<u8>,
}

/// Most bytes of what varies of a sample.
const MOST_BYTES: usize = size_of::<Varied>();

impl VariedColumn {
    /// Creates the column of a tile whose surfaces have their materials' own parameters.
    pub fn new(varying: Varying) -> Self {
        let mut column = Self { varying, bytes: vec![0; CELLS * Self::bytes_of(varying)] };
        if varying.is_any() {
            (0..CELLS).for_each(|cell| column.put(cell, Varied::NONE));
        }
        column
    }

    /// Bytes of a sample.
    pub fn bytes_of(varying: Varying) -> usize {
        let Varying { roughness, metalness, opacity, highlight, emission } = varying;
        let numbers = usize::from(roughness) + usize::from(metalness) + usize::from(opacity);
        numbers + 3 * usize::from(highlight) + 4 * usize::from(emission)
    }

    /// Parameters that vary in the shot.
    pub fn varying(&self) -> Varying {
        self.varying
    }

    /// Returns true if nothing varies.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// Parameters of the sample in a cell.
    #[inline(always)]
    pub fn get(&self, cell: usize) -> Varied {
        if self.is_empty() { Varied::NONE } else { self.unpacked(cell) }
    }

    /// Sets the parameters of the sample in a cell.
    #[inline(always)]
    pub fn set(&mut self, cell: usize, varied: Varied) {
        if !self.is_empty() {
            self.put(cell, varied);
        }
    }

    /// Copies the parameters of a cell of another tile of the shot.
    #[inline(always)]
    pub fn copy(&mut self, cell: usize, from: &Self, old: usize) {
        if !self.is_empty() {
            let bytes = Self::bytes_of(self.varying);
            let (to, old) = (cell * bytes, old * bytes);
            self.bytes[to..to + bytes].copy_from_slice(&from.bytes[old..old + bytes]);
        }
    }

    /// Not inlined: nothing varies in most shots.
    #[inline(never)]
    fn unpacked(&self, cell: usize) -> Varied {
        let bytes = Self::bytes_of(self.varying);
        // there are as many bytes as are taken
        unpack(self.varying, &self.bytes[cell * bytes..(cell + 1) * bytes]).unwrap_or_default()
    }

    #[inline(never)]
    fn put(&mut self, cell: usize, varied: Varied) {
        let bytes = Self::bytes_of(self.varying);
        let (packed, _) = pack(self.varying, varied);
        self.bytes[cell * bytes..(cell + 1) * bytes].copy_from_slice(&packed[..bytes]);
    }
}

/// Bytes of what varies, and their number; the others are 0.
pub fn pack(varying: Varying, varied: Varied) -> ([u8; MOST_BYTES], usize) {
    let (mut bytes, mut count) = ([0; MOST_BYTES], 0);
    let Varied { roughness, metalness, opacity, highlight, emission } = varied;
    for (varies, packed) in [
        (varying.roughness, &[roughness][..]),
        (varying.metalness, &[metalness]),
        (varying.opacity, &[opacity]),
        (varying.highlight, &highlight),
        (varying.emission, &emission.to_bytes()),
    ] {
        if varies {
            bytes[count..count + packed.len()].copy_from_slice(packed);
            count += packed.len();
        }
    }
    (bytes, count)
}

/// Parameters of these bytes. `None` if there are too few.
pub fn unpack(varying: Varying, bytes: &[u8]) -> Option<Varied> {
    let mut rest = bytes;
    let mut varied = Varied::NONE;
    for (varies, byte) in [
        (varying.roughness, &mut varied.roughness),
        (varying.metalness, &mut varied.metalness),
        (varying.opacity, &mut varied.opacity),
    ] {
        if varies {
            let (first, others) = rest.split_first()?;
            (*byte, rest) = (*first, others);
        }
    }
    if varying.highlight {
        let (first, others) = rest.split_first_chunk()?;
        (varied.highlight, rest) = (*first, others);
    }
    if varying.emission {
        varied.emission = SharedExponent::from_bytes(*rest.first_chunk()?);
    }
    Some(varied)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    /// Whatever varies in a shot is kept, in each cell, and takes no more bytes than it has; the rest is the material's own.
    #[test]
    fn what_varies_is_kept_and_nothing_else() {
        let emission = SharedExponent::new(Vec3::new(0.5, 20.0, 3.0));
        let all = Varied { roughness: 1, metalness: 2, opacity: 3, highlight: [4, 5, 6], emission };
        for bits in 0..32 {
            let has = |bit: u32| bits >> bit & 1 != 0;
            let varying = Varying {
                roughness: has(0),
                metalness: has(1),
                opacity: has(2),
                highlight: has(3),
                emission: has(4),
            };
            let mut column = VariedColumn::new(varying);
            assert_eq!(column.bytes.len(), CELLS * VariedColumn::bytes_of(varying));
            column.set(7, all);
            let mut other = VariedColumn::new(varying);
            other.copy(9, &column, 7);
            let own = Varied::NONE;
            let expected = Varied {
                roughness: if has(0) { 1 } else { own.roughness },
                metalness: if has(1) { 2 } else { own.metalness },
                opacity: if has(2) { 3 } else { own.opacity },
                highlight: if has(3) { [4, 5, 6] } else { own.highlight },
                emission: if has(4) { emission } else { own.emission },
            };
            assert_eq!([column.get(7), other.get(9)], [expected; 2], "{varying:?}");
            assert_eq!([column.get(6), column.get(8), other.get(7)], [own; 3], "{varying:?}");
        }
        assert!(unpack(Varying { emission: true, ..Varying::default() }, &[1, 2, 3]).is_none());
    }
}

//! Unpacking of chunks of B44, B44A, DWAA and DWAB, in Rust.
//!
//! OpenEXR's C library cannot do it everywhere: 3.1.5, of Debian 12, has no DWA at all, and mixes up the lines of floats beside B44. The
//! crate `exr` reads both as OpenEXR's C++ library does, so that a file means the same with every version. Headers and
//! chunks are still the C library's to read.

use std::path::Path;

use exr::compression::Compression;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::{self, ChannelDescription, IntegerBounds, LineOrder, Text};
use exr::meta::header::Header;
use openexr_sys as sys;

use crate::c_text::text;
use crate::library::{Context, check};
use crate::{Error, SampleType};

/// Edge of a block of cosines, pixels.
const BLOCK: usize = 8;

/// Numbers at the beginning of a chunk of DWA that count something; the first is a version.
const DWA_COUNTS: usize = 10;

/// Unpacks the chunks of a part.
pub(crate) struct Unpacker {
    header: Header,
    stored: Vec<SampleType>,
    width: usize,
}

impl Unpacker {
    /// Creates one for a part of `size` pixels. `None` if its chunks are packed by another method.
    pub(crate) fn of(
        path: &Path,
        context: &Context<'_>,
        part: i32,
        size: [u32; 2],
    ) -> Result<Option<Self>, Error> {
        let mut compression = sys::EXR_COMPRESSION_NONE;
        let mut list: *const sys::exr_attr_chlist_t = std::ptr::null();
        // SAFETY: the context is open, and the places for the answers live through the calls.
        unsafe {
            let code = sys::exr_get_compression(context.raw(), part, &mut compression);
            check(path, "read its compression", code)?;
            check(path, "read its channels", sys::exr_get_channels(context.raw(), part, &mut list))?;
        }
        let compression = match compression {
            sys::EXR_COMPRESSION_B44 => Compression::B44,
            sys::EXR_COMPRESSION_B44A => Compression::B44A,
            sys::EXR_COMPRESSION_DWAA => Compression::DWAA(None),
            sys::EXR_COMPRESSION_DWAB => Compression::DWAB(None),
            _ => return Ok(None),
        };
        // SAFETY: null, or of the context, which is open; the library keeps as many entries as it says.
        let entries = unsafe {
            let list = list.as_ref().filter(|list| list.num_channels > 0 && !list.entries.is_null());
            list.map_or(&[][..], |list| std::slice::from_raw_parts(list.entries, list.num_channels as usize))
        };
        let stored = entries.iter().map(|entry| SampleType::of(entry.pixel_type)).collect();
        let channels = entries.iter().map(|entry| ChannelDescription {
            // SAFETY: names end with a zero and live as long as the list. One that Latin-1 does not have means nothing to DWA.
            name: Text::new_or_none(unsafe { text(entry.name.str_) }).unwrap_or(Text::new_or_panic("?")),
            sample_type: match SampleType::of(entry.pixel_type) {
                SampleType::Half => attribute::SampleType::F16,
                SampleType::Float => attribute::SampleType::F32,
                SampleType::Uint => attribute::SampleType::U32,
            },
            quantize_linearly: entry.p_linear != 0,
            sampling: Vec2(1, 1),
        });
        let [width, height] = size.map(|edge| edge as usize);
        let header = Header::new(Text::new_or_panic("part"), (width, height), channels.collect());
        let header = header.with_encoding(compression, BlockDescription::ScanLines, LineOrder::Increasing);
        Ok(Some(Self { header, stored, width }))
    }

    /// Unpacks a chunk of so many `lines` into the beginning of `buffers`, one a channel. The error says what is wrong.
    pub(crate) fn unpack(
        &self,
        packed: Vec<u8>,
        lines: usize,
        buffers: &mut [Vec<f32>],
    ) -> Result<(), String> {
        self.check_counts(&packed, lines)?;
        let place = IntegerBounds::from_dimensions((self.width, lines));
        let unpacked =
            self.header.compression.decompress_image_section_from_le(&self.header, packed, place, false);
        // as many bytes as the lines have: the crate asks
        let unpacked = unpacked.map_err(|error| error.to_string())?;
        let mut rest = unpacked.as_slice();
        for line in 0..lines {
            for (stored, buffer) in self.stored.iter().zip(&mut *buffers) {
                let (own, others) = rest.split_at(self.width * stored.bytes());
                rest = others;
                stored.widen(own, &mut buffer[line * self.width..][..self.width]);
            }
        }
        Ok(())
    }
}

impl Unpacker {
    /// Refuses a chunk of DWA whose counts of bytes and coefficients are beyond what its pixels can have: memory is taken for them.
    fn check_counts(&self, packed: &[u8], lines: usize) -> Result<(), String> {
        let is_dwa = matches!(self.header.compression, Compression::DWAA(_) | Compression::DWAB(_));
        let pixel: usize = self.stored.iter().map(|stored| stored.bytes()).sum();
        if !is_dwa || packed.len() == self.width * lines * pixel {
            return Ok(());
        }
        let blocks = self.width.next_multiple_of(BLOCK) * lines.next_multiple_of(BLOCK) * self.stored.len();
        // no sample has more than 4 bytes, and runs of bytes no more than one count a byte
        let most = 8 * blocks as u64 + 4096;
        let counts = packed.chunks_exact(8).take(DWA_COUNTS).skip(1);
        let counts = counts.filter_map(|bytes| bytes.try_into().ok()).map(u64::from_le_bytes);
        match counts.max() {
            Some(count) if count > most => {
                Err(format!("a chunk states a count of {count}, which its pixels cannot have: it is damaged"))
            }
            _ => Ok(()),
        }
    }
}

impl SampleType {
    /// The type that the C library calls by this number.
    pub(crate) fn of(number: sys::exr_pixel_type_t) -> Self {
        match number {
            sys::EXR_PIXEL_HALF => Self::Half,
            sys::EXR_PIXEL_FLOAT => Self::Float,
            _ => Self::Uint,
        }
    }

    /// Bytes of a sample.
    pub(crate) fn bytes(self) -> usize {
        if self == Self::Half { 2 } else { 4 }
    }

    /// Converts samples in the machine's order of bytes to floats.
    fn widen(self, bytes: &[u8], to: &mut [f32]) {
        let four = |bytes: &[u8]| [bytes[0], bytes[1], bytes[2], bytes[3]];
        for (value, bytes) in to.iter_mut().zip(bytes.chunks_exact(self.bytes())) {
            *value = match self {
                Self::Half => half::f16::from_ne_bytes([bytes[0], bytes[1]]).to_f32(),
                Self::Float => f32::from_ne_bytes(four(bytes)),
                Self::Uint => u32::from_ne_bytes(four(bytes)) as f32,
            };
        }
    }
}

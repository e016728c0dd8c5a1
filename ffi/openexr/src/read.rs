//! Reading of planes from a file: the parts of any scanline file.

use std::ffi::{CString, c_char};
use std::fs::File;
use std::ops::Range;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::sync::Arc;

use openexr_sys as sys;

use crate::c_text::text;
use crate::library::{Context, check, initializer};
use crate::lossy::Unpacker;
use crate::source::{open_regular, read_from};
use crate::{Attribute, Compression, Error, SampleType};

/// Maximum number of samples in one file, 64 GiB of planes: more are taken for a damaged header.
const MOST_SAMPLES: u64 = 1 << 34;
/// Minimum size of a chunk, bytes: its offset in the table, its line and its length.
const CHUNK_BYTES: u64 = 16;
/// Number of the part that every file has.
const FIRST: i32 = 0;
/// Maximum number of bytes of pixels for each byte of a file. (Deflate comes to 1032.)
const MOST_PACKED: u64 = 1 << 14;

/// Content of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadImage {
    /// Pixels across the data window.
    pub width: u32,
    /// Pixels down the data window.
    pub height: u32,
    /// Channels, sorted by name as in the file.
    pub channels: Vec<ReadChannel>,
    /// Attributes, in the file's order, without those that every file has and that the other fields hold.
    pub attributes: Vec<(String, Attribute)>,
    /// Compression; `None` for a method that this crate does not write.
    pub compression: Option<Compression>,
    /// Column and row of the data window's first pixel.
    pub origin: [i32; 2],
    /// The display window: its first column and row, its last column and row.
    pub display: [i32; 4],
    /// Name of the part; empty if it has none.
    pub part_name: String,
}

/// One plane of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadChannel {
    /// Full name, `layer.R`.
    pub name: String,
    /// Type in the file.
    pub stored: SampleType,
    /// Values: `width * height`, row-major, top row first; none if only the header was read.
    pub data: Vec<f32>,
}

impl ReadImage {
    /// Channel of that full name.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&ReadChannel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// Attribute of that name in the header.
    #[must_use]
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value)
    }
}

/// Reads the first part of a scanline file.
///
/// # Errors
/// A file that is missing, unreadable, damaged, cut short, tiled, deep, or has subsampled channels; and
/// what is no regular file, which is not read: a FIFO may have no writer.
pub fn read(path: &Path) -> Result<ReadImage, Error> {
    let (context, mut image) = begin(path, FIRST)?;
    let pixels = image.width as usize * image.height as usize;
    let mut planes: Vec<Vec<f32>> = vec![Vec::new(); image.channels.len()];
    for plane in &mut planes {
        let room = plane.try_reserve_exact(pixels);
        room.map_err(|_| refuse(path, "its planes do not fit into memory"))?;
    }
    let mut keep = |channel: usize, lines: &[f32]| planes[channel].extend_from_slice(lines);
    read_pixels(path, &context, FIRST, &image, &mut keep)?;
    for (channel, plane) in image.channels.iter_mut().zip(planes) {
        channel.data = plane;
    }
    Ok(image)
}

/// Reads the header alone: the planes are empty.
///
/// # Errors
/// As [`read`], as far as the header tells.
pub fn read_header(path: &Path) -> Result<ReadImage, Error> {
    begin(path, FIRST).map(|(_, image)| image)
}

/// [`read_header`] of the part of that number; the first is 0.
///
/// # Errors
/// As [`read_header`]; and where there is no such part.
pub fn read_header_of(path: &Path, part: usize) -> Result<ReadImage, Error> {
    begin(path, number(path, part)?).map(|(_, image)| image)
}

fn number(path: &Path, part: usize) -> Result<i32, Error> {
    i32::try_from(part).map_err(|_| refuse(path, "it has no such part"))
}

/// Reads all pixels but holds few: gives the lines of each chunk from top to bottom, channel by channel (by its number), to
/// `visit`. The planes of what is returned are empty.
///
/// # Errors
/// As [`read`].
pub fn scan(path: &Path, visit: impl FnMut(usize, &[f32])) -> Result<ReadImage, Error> {
    scan_part(path, 0, visit)
}

/// [`scan`] of the part of that number; the first is 0.
///
/// # Errors
/// As [`read`]; and where there is no such part.
pub fn scan_part(path: &Path, part: usize, mut visit: impl FnMut(usize, &[f32])) -> Result<ReadImage, Error> {
    let part = number(path, part)?;
    let (context, image) = begin(path, part)?;
    read_pixels(path, &context, part, &image, &mut visit)?;
    Ok(image)
}

/// Number of parts of a file, tiled and deep ones included.
///
/// # Errors
/// A file that is missing or unreadable, no EXR file, or no regular file.
pub fn part_count(path: &Path) -> Result<usize, Error> {
    let (context, _) = open_file(path)?;
    let mut count = 0;
    // SAFETY: the context is open, and the place for the answer lives through the call.
    check(path, "count its parts", unsafe { sys::exr_get_count(context.raw(), &mut count) })?;
    Ok(usize::try_from(count).unwrap_or(0))
}

/// Opens a part, and checks that it may be what its header says.
fn begin(path: &Path, part: i32) -> Result<(Context<'static>, ReadImage), Error> {
    let (context, length) = open_file(path)?;
    let image = describe(path, &context, part)?;
    let lines = context.lines_per_chunk(path, part)? as u64;
    check_length(length, &image, lines).map_err(|why| refuse(path, why))?;
    Ok((context, image))
}

/// Opens the file. Returns also its length in bytes.
fn open_file(path: &Path) -> Result<(Context<'static>, u64), Error> {
    let (file, length) = open_regular(path).map_err(|error| Error::reading(path, error))?;
    Ok((open(path, file)?, length))
}

/// Checks whether a file of `length` bytes can be whole if its header is right.
fn check_length(length: u64, image: &ReadImage, lines_per_chunk: u64) -> Result<(), String> {
    let (width, height) = (u64::from(image.width), u64::from(image.height));
    let pixel: u64 = image.channels.iter().map(|channel| channel.stored.bytes() as u64).sum();
    let unpacked = width.saturating_mul(height).saturating_mul(pixel);
    let least = (height.div_ceil(lines_per_chunk) * CHUNK_BYTES).max(unpacked / MOST_PACKED);
    if length < least {
        let (width, height) = (image.width, image.height);
        return Err(format!(
            "{width}x{height} pixels cannot be in a file of {length} bytes: it is cut short"
        ));
    }
    Ok(())
}

fn refuse(path: &Path, message: impl Into<String>) -> Error {
    Error::Library { path: path.to_owned(), doing: "read it", message: message.into() }
}

fn open(path: &Path, file: File) -> Result<Context<'static>, Error> {
    let name = CString::new(path.as_os_str().as_bytes())
        .map_err(|_| refuse(path, "the file's name holds a zero byte"))?;
    let mut initializer = initializer();
    // What is missing shall be an error, not a guess.
    initializer.flags = sys::EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION as i32;
    // in a place of its own, where it stays
    let file = Arc::new(file);
    read_from(&file, &mut initializer);
    let mut raw: sys::exr_context_t = std::ptr::null_mut();
    // SAFETY: name and initializer are copied during the call. The context has the file, which is the only thing that its
    // callbacks use.
    unsafe {
        check(path, "open it", sys::exr_start_read(&mut raw, name.as_ptr(), &initializer))?;
        Ok(Context::reading(raw, file))
    }
}

/// Reads size, channels with empty planes, and attributes.
fn describe(path: &Path, context: &Context<'_>, part: i32) -> Result<ReadImage, Error> {
    let raw = context.raw();
    let mut storage = sys::EXR_STORAGE_SCANLINE;
    let mut compression = sys::EXR_COMPRESSION_NONE;
    let (mut corners, mut display) = ([0_i32; 4], [0_i32; 4]);
    let mut list: *const sys::exr_attr_chlist_t = std::ptr::null();
    // SAFETY: the context is open; the places for the answers live through the calls, and a box of
    // integers is four `i32` without padding (minimum x and y, maximum x and y).
    unsafe {
        check(path, "read its type", sys::exr_get_storage(raw, part, &mut storage))?;
        let window = corners.as_mut_ptr().cast();
        check(path, "read its size", sys::exr_get_data_window(raw, part, window))?;
        let window = display.as_mut_ptr().cast();
        check(path, "read its display window", sys::exr_get_display_window(raw, part, window))?;
        check(path, "read its compression", sys::exr_get_compression(raw, part, &mut compression))?;
        check(path, "read its channels", sys::exr_get_channels(raw, part, &mut list))?;
    }
    let other = match storage {
        sys::EXR_STORAGE_SCANLINE => None,
        sys::EXR_STORAGE_TILED => Some("tiled"),
        _ => Some("deep"),
    };
    if let Some(kind) = other {
        return Err(refuse(
            path,
            format!("it is {kind}; only scanline files are read: write it again as one"),
        ));
    }
    let [left, top, right, bottom] = corners.map(i64::from);
    let size = |first: i64, last: i64| u32::try_from(last - first + 1).ok().filter(|&n| n > 0);
    let (Some(width), Some(height)) = (size(left, right), size(top, bottom)) else {
        return Err(refuse(path, "its data window is empty"));
    };
    // SAFETY: the list belongs to the context, which is open.
    let channels = unsafe { describe_channels(path, list)? };
    let samples = u64::from(width).saturating_mul(u64::from(height));
    // a line's length in bytes is a C integer
    let is_too_wide = width > i32::MAX as u32 / 4;
    if is_too_wide || samples.saturating_mul(channels.len() as u64) > MOST_SAMPLES {
        return Err(refuse(path, format!("{width}x{height} pixels are too many to be true")));
    }
    let compression = match compression {
        sys::EXR_COMPRESSION_NONE => Some(Compression::None),
        sys::EXR_COMPRESSION_ZIPS => Some(Compression::Zips),
        sys::EXR_COMPRESSION_ZIP => Some(Compression::Zip),
        sys::EXR_COMPRESSION_PIZ => Some(Compression::Piz),
        _ => None,
    };
    let attributes = crate::attributes::read_attributes(path, context, part)?;
    let origin = [corners[0], corners[1]];
    let part_name = part_name(context, part);
    Ok(ReadImage { width, height, channels, attributes, compression, origin, display, part_name })
}

/// Reads the name of a part. Empty if it has none: a file of one part needs no name.
fn part_name(context: &Context<'_>, part: i32) -> String {
    let mut name: *const c_char = std::ptr::null();
    // SAFETY: the context is open, and the place for the answer lives through the call; a name ends with a zero and
    // belongs to the context.
    unsafe {
        let code = sys::exr_get_name(context.raw(), part, &mut name);
        if code == sys::EXR_ERR_SUCCESS as sys::exr_result_t { text(name) } else { String::new() }
    }
}

unsafe fn describe_channels(
    path: &Path,
    list: *const sys::exr_attr_chlist_t,
) -> Result<Vec<ReadChannel>, Error> {
    // SAFETY: null or valid (the caller's promise).
    let entries = match unsafe { list.as_ref() } {
        Some(list) if list.num_channels > 0 && !list.entries.is_null() => {
            // SAFETY: the library keeps as many entries as it says.
            unsafe { std::slice::from_raw_parts(list.entries, list.num_channels as usize) }
        }
        _ => return Err(refuse(path, "it has no channel")),
    };
    let describe = |entry: &sys::exr_attr_chlist_entry_t| {
        // SAFETY: names end with a zero and live as long as the list.
        let name = unsafe { text(entry.name.str_) };
        if (entry.x_sampling, entry.y_sampling) != (1, 1) {
            return Err(refuse(path, format!("channel {name:?} is subsampled")));
        }
        Ok(ReadChannel { name, stored: SampleType::of(entry.pixel_type), data: Vec::new() })
    };
    entries.iter().map(describe).collect()
}

fn read_pixels(
    path: &Path,
    context: &Context<'_>,
    part: i32,
    image: &ReadImage,
    visit: &mut impl FnMut(usize, &[f32]),
) -> Result<(), Error> {
    let (width, height) = (image.width as usize, image.height as usize);
    let step = context.lines_per_chunk(path, part)?.min(height);
    let mut buffers: Vec<Vec<f32>> = vec![Vec::new(); image.channels.len()];
    for buffer in &mut buffers {
        let room = buffer.try_reserve_exact(width * step);
        room.map_err(|_| refuse(path, "its lines do not fit into memory"))?;
        buffer.resize(width * step, 0.0);
    }
    let mut pipeline = sys::decode_pipeline();
    let mut outcome = Ok(());
    let source = Chunks { path, context, part, width };
    let unpacker = Unpacker::of(path, context, part, [image.width, image.height])?;
    for first in (0..height).step_by(step) {
        let lines = step.min(height - first);
        let range = first..first + lines;
        outcome = match &unpacker {
            Some(unpacker) => source.read_packed(range, unpacker, &mut buffers),
            // SAFETY: the pipeline is empty the first time and of this context and part afterwards, and every
            // buffer has `width * step` values.
            None => unsafe { read_chunk(&source, range, &mut buffers, &mut pipeline) },
        };
        if outcome.is_err() {
            break;
        }
        for (number, buffer) in buffers.iter().enumerate() {
            visit(number, &buffer[..width * lines]);
        }
    }
    // SAFETY: the context is open, and the pipeline is empty or of this context.
    unsafe { sys::exr_decoding_destroy(context.raw(), &mut pipeline) };
    outcome
}

/// [`check`]s a step of reading these lines, counted from the top. The library's own words say which step of its work failed: what is
/// wrong, and what to do, stands before them.
fn check_lines(path: &Path, lines: &Range<usize>, code: sys::exr_result_t) -> Result<(), Error> {
    check(path, "read the pixels", code).map_err(|error| {
        let Error::Library { path, doing, message } = error else { return error };
        let why = match code as sys::exr_error_code_t {
            sys::EXR_ERR_OUT_OF_MEMORY => "there is too little memory",
            _ => "the file is damaged or cut short, make it again",
        };
        let which = match lines.len() {
            1 => format!("line {}", lines.end),
            _ => format!("lines {} to {}", lines.start + 1, lines.end),
        };
        let message = format!("{which}: {why} ({message})");
        Error::Library { path, doing, message }
    })
}

/// The part whose chunks are read.
struct Chunks<'a> {
    path: &'a Path,
    context: &'a Context<'a>,
    part: i32,
    /// Pixels across.
    width: usize,
}

/// The step that reads them, for errors.
const DOING: &str = "read the pixels";

impl Chunks<'_> {
    /// Finds the chunk of these lines, counted from the top.
    fn find(&self, lines: &Range<usize>) -> Result<sys::exr_chunk_info_t, Error> {
        let &Self { path, context, part, width } = self;
        let raw = context.raw();
        let mut corners = [0_i32; 4];
        // SAFETY: a chunk's description is plain numbers; for the window see `describe`.
        let (mut chunk, code) = unsafe {
            let chunk: sys::exr_chunk_info_t = std::mem::zeroed();
            (chunk, sys::exr_get_data_window(raw, part, corners.as_mut_ptr().cast()))
        };
        check(path, DOING, code)?;
        let line = corners[1] + lines.start as i32;
        // SAFETY: the context is open, and `chunk` lives through the call.
        let code = unsafe { sys::exr_read_scanline_chunk_info(raw, part, line, &mut chunk) };
        check_lines(path, lines, code)?;
        if usize::try_from(chunk.height) != Ok(lines.len()) || usize::try_from(chunk.width) != Ok(width) {
            return Err(refuse(path, "a chunk has other lines than its place says"));
        }
        Ok(chunk)
    }

    /// Reads the chunk of these lines, counted from the top, as it is packed, and unpacks it into the beginning of `buffers`.
    fn read_packed(
        &self,
        lines: Range<usize>,
        unpacker: &Unpacker,
        buffers: &mut [Vec<f32>],
    ) -> Result<(), Error> {
        let &Self { path, context, part, .. } = self;
        let chunk = self.find(&lines)?;
        // what would not become smaller is not packed
        if chunk.packed_size > chunk.unpacked_size {
            return Err(refuse(path, "a chunk is longer than its pixels"));
        }
        let mut packed = Vec::new();
        let room = usize::try_from(chunk.packed_size).ok().filter(|n| packed.try_reserve_exact(*n).is_ok());
        packed.resize(room.ok_or_else(|| refuse(path, "a chunk does not fit into memory"))?, 0_u8);
        // SAFETY: the context is open, and the buffer has room for the packed bytes of this chunk.
        let code = unsafe { sys::exr_read_chunk(context.raw(), part, &chunk, packed.as_mut_ptr().cast()) };
        check(path, DOING, code)?;
        unpacker.unpack(packed, lines.len(), buffers).map_err(|what| refuse(path, what))
    }
}

/// Reads the chunk of these lines, counted from the top, into the beginning of `buffers`.
///
/// # Safety
/// `pipeline` is empty, or of this context and part; each buffer has room for the lines.
unsafe fn read_chunk(
    source: &Chunks<'_>,
    lines: Range<usize>,
    buffers: &mut [Vec<f32>],
    pipeline: &mut sys::exr_decode_pipeline_t,
) -> Result<(), Error> {
    let &Chunks { path, context, part, width } = source;
    let raw = context.raw();
    let chunk = source.find(&lines)?;
    let is_first = pipeline.channels.is_null();
    // SAFETY: the pipeline is empty, or of this context and part (the caller's promise).
    let code = unsafe {
        if is_first {
            sys::exr_decoding_initialize(raw, part, &chunk, pipeline)
        } else {
            sys::exr_decoding_update(raw, part, &chunk, pipeline)
        }
    };
    check(path, DOING, code)?;
    // SAFETY: initialised; the library keeps as many descriptions as it says.
    let targets =
        unsafe { std::slice::from_raw_parts_mut(pipeline.channels, pipeline.channel_count as usize) };
    for (target, buffer) in targets.iter_mut().zip(buffers) {
        target.user_bytes_per_element = 4;
        target.user_data_type = sys::EXR_PIXEL_FLOAT as u16;
        target.user_pixel_stride = 4;
        target.user_line_stride = 4 * width as i32;
        target.__bindgen_anon_1.decode_to_ptr = buffer.as_mut_ptr().cast();
    }
    if is_first {
        // SAFETY: initialised with this context, and all channels are described.
        let code = unsafe { sys::exr_decoding_choose_default_routines(raw, part, pipeline) };
        check(path, DOING, code)?;
    }
    // SAFETY: every target has room for the chunk's lines: they are as many, and as wide, as was checked.
    let code = unsafe { sys::exr_decoding_run(raw, part, pipeline) };
    check_lines(path, &lines, code)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_must_be_long_enough_for_its_size() {
        let of = |width, height| {
            let channel = ReadChannel { name: "R".into(), stored: SampleType::Half, data: Vec::new() };
            ReadImage {
                width,
                height,
                channels: vec![channel; 37],
                attributes: vec![],
                compression: None,
                origin: [0; 2],
                display: [0; 4],
                part_name: String::new(),
            }
        };
        let fits = |length, width, height, lines| check_length(length, &of(width, height), lines).is_ok();
        assert!(fits(1000, 64, 36, 1) && fits(600, 64, 36, 1) && !fits(500, 64, 36, 1));
        assert!(fits(500, 64, 36, 16), "fewer chunks");
        assert!(!fits(1_000_000, 30_000, 30_000, 1), "no method packs that well");
        assert!(!fits(1_000_000, u32::MAX, u32::MAX, 1));
    }
}

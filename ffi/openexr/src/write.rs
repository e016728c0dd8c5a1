//! Writing of an image as the bytes of a file.

use std::borrow::Cow;
use std::ffi::{CString, c_void};
use std::fs::File;
use std::ops::Range;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use openexr_sys as sys;
use rayon::prelude::*;

use crate::check::sorted_channels;
use crate::compress::Deflater;
use crate::header::write_header;
use crate::library::{Context, check, initializer};
use crate::pack::pack_lines;
use crate::parts::{Part, by_layer};
use crate::piz::compress_piz;
use crate::sink::Sink;
use crate::{Channel, Compression, Error, Image};

/// zlib's fastest level; `examples/write_speed.rs` prints what the others cost and save. Level 2 makes
/// frames about a tenth smaller for a third more processor time, level 4 hardly less for twice the time.
pub(crate) const DEFLATE_LEVEL: u32 = 1;

/// Chunks that are compressed before they are written: enough work for many threads, and a bound on
/// the memory that a large frame needs besides its planes.
const CHUNKS_AT_ONCE: usize = 128;

/// Writes the image to `file`, which is empty and open for writing. Errors call it `path`.
///
/// Chunks are compressed on rayon's current pool. Bytes do not depend on the number of threads.
///
/// # Errors
/// Names, sizes and values that a file must not hold (a NaN or an infinity is reported with its
/// channel and pixel), and what the operating system or OpenEXR refuse. The file is then not whole.
pub fn write(file: &File, path: &Path, image: &Image<'_>) -> Result<(), Error> {
    write_at_level(file, path, image, DEFLATE_LEVEL)
}

/// [`write()`] with a part for each layer, of its name: first `rgba`, the channels without a layer, but for `Z`, which has a part
/// of its own. Channels keep their whole names. Parts have all attributes each.
///
/// # Errors
/// Those of [`write()`].
pub fn write_parts(file: &File, path: &Path, image: &Image<'_>) -> Result<(), Error> {
    let parts = by_layer(sorted_channels(path, image)?, &Cow::Borrowed(&image.attributes));
    write_to(file, path, image, &parts, DEFLATE_LEVEL)
}

/// [`write()`] with a deflate level of 1 to 9 for ZIP and ZIPS, to measure what it is worth.
///
/// # Errors
/// Those of [`write()`].
pub fn write_at_level(file: &File, path: &Path, image: &Image<'_>, level: u32) -> Result<(), Error> {
    let attributes = Cow::Borrowed(&image.attributes[..]);
    let part = Part { name: None, channels: sorted_channels(path, image)?, attributes };
    write_to(file, path, image, &[part], level.clamp(1, 9))
}

/// Writes `parts`, whose size, place and compression are those of `image`.
pub(crate) fn write_to(
    file: &File,
    path: &Path,
    image: &Image<'_>,
    parts: &[Part<'_>],
    level: u32,
) -> Result<(), Error> {
    let sink = Sink::new(file);
    write_all(path, image, parts, level, &sink).map_err(|error| {
        // If the operating system refused, then that is the reason, not what OpenEXR made of it.
        sink.take_failure().map_or(error, |reason| Error::writing(path, reason))
    })?;
    sink.take_failure().map_or(Ok(()), |reason| Err(Error::writing(path, reason)))
}

fn write_all(
    path: &Path,
    image: &Image<'_>,
    parts: &[Part<'_>],
    level: u32,
    sink: &Sink<'_>,
) -> Result<(), Error> {
    let context = open(path, sink)?;
    // SAFETY: `open` has just opened the context for writing.
    unsafe { write_header(path, context.raw(), image, parts)? };
    for (part, Part { channels, .. }) in (0..).zip(parts) {
        write_chunks(&context, &Encoder { path, context: &context, image, part, channels, level })?;
    }
    context.finish(path, "complete the file")
}

fn open<'a>(path: &Path, sink: &'a Sink<'_>) -> Result<Context<'a>, Error> {
    // The library wants a name for its texts only: it writes through `write_at`.
    let name = CString::new(path.as_os_str().as_bytes())
        .map_err(|_| Error::image(path, "the file's name holds a zero byte"))?;
    let mut initializer = initializer();
    initializer.user_data = std::ptr::from_ref(sink).cast_mut().cast();
    initializer.write_fn = Some(write_at);
    let mut raw: sys::exr_context_t = std::ptr::null_mut();
    // SAFETY: name and initializer are copied during the call. The sink, which the library will pass
    // to `write_at`, is borrowed for as long as the `Context` lives.
    unsafe {
        let directly = sys::EXR_WRITE_FILE_DIRECTLY;
        let code = sys::exr_start_write(&mut raw, name.as_ptr(), directly, &initializer);
        check(path, "begin the file", code)?;
        Ok(Context::owning(raw))
    }
}

/// Writes for the library. It runs in the library's frames, and cannot panic.
unsafe extern "C" fn write_at(
    _context: sys::exr_const_context_t,
    sink: *mut c_void,
    bytes: *const c_void,
    count: u64,
    offset: u64,
    _complain: sys::exr_stream_error_func_ptr_t,
) -> i64 {
    const FAILED: i64 = -1;
    let (Ok(length), Ok(written)) = (usize::try_from(count), i64::try_from(count)) else {
        return FAILED;
    };
    if bytes.is_null() || length == 0 {
        return if length == 0 { 0 } else { FAILED };
    }
    // SAFETY: `open` gave the library a `Sink` that outlives the context, and shared access is all
    // that is taken.
    let sink = unsafe { &*sink.cast::<Sink<'_>>() };
    // SAFETY: the library passes as many readable bytes as it says; not null, see above.
    let bytes = unsafe { std::slice::from_raw_parts(bytes.cast::<u8>(), length) };
    if sink.write_at(bytes, offset) { written } else { FAILED }
}

/// Compresses on all threads, writes in the order of the lines.
fn write_chunks(context: &Context<'_>, encoder: &Encoder<'_>) -> Result<(), Error> {
    let height = encoder.image.height as usize;
    let step = context.lines_per_chunk(encoder.path, encoder.part)?;
    let starts: Vec<usize> = (0..height).step_by(step).collect();
    // buffers are used again: new ones of this size are new pages from the system every time
    let scratches = Mutex::new(Vec::new());
    let lock = || scratches.lock().unwrap_or_else(PoisonError::into_inner);
    let mut chunks = vec![Vec::new(); starts.len().min(CHUNKS_AT_ONCE)];
    for some in starts.chunks(CHUNKS_AT_ONCE) {
        some.par_iter().zip(&mut chunks).try_for_each(|(&first, chunk)| {
            let unused = lock().pop();
            let mut scratch = unused.unwrap_or_else(|| Scratch::new(encoder.level));
            let done = encoder.chunk(&mut scratch, first..(first + step).min(height), chunk);
            lock().push(scratch);
            done
        })?;
        for (&first, chunk) in some.iter().zip(&chunks) {
            write_chunk(encoder, first, chunk)?;
        }
    }
    Ok(())
}

fn write_chunk(encoder: &Encoder<'_>, first: usize, chunk: &[u8]) -> Result<(), Error> {
    let &Encoder { path, context, part, .. } = encoder;
    let line = encoder.line(first);
    let (bytes, size) = (chunk.as_ptr().cast::<c_void>(), chunk.len() as u64);
    // SAFETY: the header is written, and the library is done with the bytes when it returns.
    let code = unsafe { sys::exr_write_scanline_chunk(context.raw(), part, line, bytes, size) };
    check(path, "write the pixels", code)
}

/// Shared data of all threads that make chunks.
struct Encoder<'a> {
    path: &'a Path,
    context: &'a Context<'a>,
    image: &'a Image<'a>,
    /// Number of the part; `channels` are its channels.
    part: i32,
    channels: &'a [Channel<'a>],
    level: u32,
}

/// Buffers that a thread uses for one chunk after the other.
struct Scratch {
    packed: Vec<u8>,
    deflater: Deflater,
}

impl Scratch {
    fn new(level: u32) -> Self {
        Self { packed: Vec::new(), deflater: Deflater::new(level) }
    }
}

impl Encoder<'_> {
    /// Number of a line in the file; `line` counts from the first one of the data window.
    fn line(&self, line: usize) -> i32 {
        line as i32 + self.image.placed.map_or(0, |placed| placed.first[1])
    }

    /// Makes `chunk` the bytes of these lines as stored in the file.
    fn chunk(&self, scratch: &mut Scratch, lines: Range<usize>, chunk: &mut Vec<u8>) -> Result<(), Error> {
        let first = lines.start;
        let packed = &mut scratch.packed;
        pack_lines(self.channels, self.image.width as usize, lines, packed)
            .map_err(|found| Error::image(self.path, found.to_string()))?;
        let is_smaller = match self.image.compression {
            Compression::None => false,
            Compression::Zips | Compression::Zip => scratch.deflater.deflate(packed, chunk),
            Compression::Piz => {
                match compress_piz(self.path, self.context, (self.part, self.line(first)), packed)? {
                    Some(compressed) => {
                        *chunk = compressed;
                        true
                    }
                    None => false,
                }
            }
        };
        if !is_smaller {
            chunk.clone_from(packed);
        }
        Ok(())
    }
}

//! PIZ chunks, by the library's own compressor.

use std::path::Path;

use openexr_sys as sys;

use crate::Error;
use crate::library::{Context, check};

/// Compresses the chunk of `part` that begins at line `first` of the picture; `None` if it would not be
/// smaller.
///
/// The library's compressor is called directly, because `exr_encoding_run` would pack the lines again,
/// under a lock that keeps all other threads waiting.
pub(crate) fn compress_piz(
    path: &Path,
    context: &Context<'_>,
    (part, first): (i32, i32),
    packed: &mut [u8],
) -> Result<Option<Vec<u8>>, Error> {
    let mut pipeline = sys::encode_pipeline();
    // SAFETY: the context is open for writing and its header is written; the pipeline is empty.
    let begun = unsafe { begin(path, context, (part, first), &mut pipeline, packed) };
    // SAFETY: begun, and `packed` is borrowed through the call.
    let outcome = begun.and_then(|()| unsafe { run(path, &mut pipeline, packed) });
    // The packed bytes are ours: the library must not free them.
    pipeline.packed_buffer = std::ptr::null_mut();
    pipeline.packed_alloc_size = 0;
    // SAFETY: the context is open, and the pipeline is empty or was begun with it.
    unsafe { sys::exr_encoding_destroy(context.raw(), &mut pipeline) };
    outcome
}

/// Describes the chunk to the pipeline and lets it choose its compressor.
unsafe fn begin(
    path: &Path,
    context: &Context<'_>,
    (part, first): (i32, i32),
    pipeline: &mut sys::exr_encode_pipeline_t,
    packed: &mut [u8],
) -> Result<(), Error> {
    // SAFETY: plain numbers, for which zero bytes are valid.
    let mut chunk: sys::exr_chunk_info_t = unsafe { std::mem::zeroed() };
    let raw = context.raw();
    // SAFETY: the context is open for writing (the caller's promise), `chunk` lives through the call.
    let code = unsafe { sys::exr_write_scanline_chunk_info(raw, part, first, &mut chunk) };
    check(path, "begin a PIZ chunk", code)?;
    // SAFETY: as above; the pipeline is empty (the caller's promise).
    let code = unsafe { sys::exr_encoding_initialize(raw, part, &chunk, pipeline) };
    check(path, "begin a PIZ chunk", code)?;
    // SAFETY: as above. The routine that packs is chosen too, but never called.
    let code = unsafe { sys::exr_encoding_choose_default_routines(raw, part, pipeline) };
    check(path, "begin a PIZ chunk", code)?;
    pipeline.packed_buffer = packed.as_mut_ptr().cast();
    pipeline.packed_bytes = packed.len() as u64;
    pipeline.packed_alloc_size = packed.len();
    Ok(())
}

unsafe fn run(
    path: &Path,
    pipeline: &mut sys::exr_encode_pipeline_t,
    packed: &[u8],
) -> Result<Option<Vec<u8>>, Error> {
    let Some(compress) = pipeline.compress_fn else {
        return Err(Error::image(path, "the installed OpenEXR cannot compress with PIZ"));
    };
    // SAFETY: the pipeline describes the chunk and points to its packed bytes (the caller's promise).
    check(path, "compress with PIZ", unsafe { compress(pipeline) })?;
    let size = pipeline.compressed_bytes;
    if pipeline.compressed_buffer.is_null() || size >= packed.len() {
        return Ok(None);
    }
    // SAFETY: not null, and the compressor has filled that many bytes.
    let bytes = unsafe { std::slice::from_raw_parts(pipeline.compressed_buffer.cast::<u8>(), size) };
    Ok(Some(bytes.to_vec()))
}

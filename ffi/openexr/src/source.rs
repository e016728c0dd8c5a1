//! The file that OpenEXR's library reads from: a regular one.
//!
//! The library would open whatever has a name, and wait for the writer of a FIFO.

use std::ffi::c_void;
use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind};
use std::os::unix::fs::{FileExt, OpenOptionsExt};
use std::path::Path;

use openexr_sys as sys;
use rustix::fs::OFlags;

/// Opens the file at `path`, to which links may lead, and tells its length in bytes. What is no regular file is not opened; one that
/// takes the place of a file in this moment is not waited for.
pub(crate) fn open_regular(path: &Path) -> io::Result<(File, u64)> {
    let refuse = || Err(io::Error::new(ErrorKind::InvalidInput, "it is not a regular file: give a file"));
    if !path.metadata()?.is_file() {
        return refuse();
    }
    let flags = OFlags::NONBLOCK | OFlags::NOCTTY;
    let file = OpenOptions::new().read(true).custom_flags(flags.bits() as i32).open(path)?;
    let found = file.metadata()?;
    if found.is_file() { Ok((file, found.len())) } else { refuse() }
}

/// Makes the library read from `file`, which must live as long as its context.
pub(crate) fn read_from(file: &File, initializer: &mut sys::exr_context_initializer_t) {
    initializer.user_data = std::ptr::from_ref(file).cast_mut().cast();
    initializer.read_fn = Some(read_at);
    initializer.size_fn = Some(size);
}

/// Reads for the library. It runs in the library's frames, and cannot panic. It returns fewer bytes only at
/// the file's end.
unsafe extern "C" fn read_at(
    _context: sys::exr_const_context_t,
    file: *mut c_void,
    buffer: *mut c_void,
    count: u64,
    offset: u64,
    _complain: sys::exr_stream_error_func_ptr_t,
) -> i64 {
    const FAILED: i64 = -1;
    let Ok(length) = usize::try_from(count) else { return FAILED };
    if buffer.is_null() || length == 0 {
        return if length == 0 { 0 } else { FAILED };
    }
    // SAFETY: `read_from` was given a file that lives as long as the context, and shared access is all that is taken.
    let file = unsafe { &*file.cast::<File>() };
    // SAFETY: the library has room for as many bytes as it says; not null, see above. They are written before they are
    // read, and bytes that nobody has set are zero first, so that no reference leads to any.
    let buffer = unsafe {
        std::ptr::write_bytes(buffer.cast::<u8>(), 0, length);
        std::slice::from_raw_parts_mut(buffer.cast::<u8>(), length)
    };
    let mut read = 0;
    while read < length {
        match file.read_at(&mut buffer[read..], offset.saturating_add(read as u64)) {
            Ok(0) => break,
            Ok(more) => read += more,
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(_) => return FAILED,
        }
    }
    read as i64
}

/// Returns the size of the file. It runs in the library's frames, too.
unsafe extern "C" fn size(_context: sys::exr_const_context_t, file: *mut c_void) -> i64 {
    // SAFETY: see `read_at`.
    let file = unsafe { &*file.cast::<File>() };
    file.metadata().ok().and_then(|found| i64::try_from(found.len()).ok()).unwrap_or(-1)
}

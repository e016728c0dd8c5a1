//! The library's error texts and its version.

use std::cell::RefCell;
use std::ffi::{CStr, c_char};
use std::fs::File;
use std::marker::PhantomData;
use std::path::Path;
use std::sync::Arc;

use openexr_sys as sys;

use crate::Error;

thread_local! {
    /// The last complaint on this thread: the library reports on the thread that made the mistake,
    /// sometimes while it holds a file's lock, so the callback may ask it for nothing.
    static COMPLAINT: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Version of OpenEXR that runs, such as `3.1.5`.
#[must_use]
pub fn version() -> String {
    let (mut major, mut minor, mut patch) = (0, 0, 0);
    // SAFETY: three places that live through the call; the text of the fourth is not asked for.
    unsafe {
        sys::exr_get_library_version(&mut major, &mut minor, &mut patch, std::ptr::null_mut());
    }
    format!("{major}.{minor}.{patch}")
}

/// Creates an initializer that sends errors to [`check`] instead of stderr.
pub(crate) fn initializer() -> sys::exr_context_initializer_t {
    let mut initializer = sys::context_initializer();
    initializer.error_handler_fn = Some(keep_complaint);
    initializer
}

/// Keeps a complaint of the library. It runs in the library's frames: it must not panic, hence the `try_`
/// forms.
unsafe extern "C" fn keep_complaint(
    _context: sys::exr_const_context_t,
    _code: sys::exr_result_t,
    message: *const c_char,
) {
    if message.is_null() {
        return;
    }
    // SAFETY: not null, and the library passes a string that ends with a zero and outlives the call.
    let text = unsafe { CStr::from_ptr(message) }.to_string_lossy().into_owned();
    // At the thread's end the cell may be gone, and then nobody asks for the text.
    let _ = COMPLAINT.try_with(|cell| {
        if let Ok(mut complaint) = cell.try_borrow_mut() {
            *complaint = Some(text);
        }
    });
}

/// Converts a result of the library into ours, with its own words.
pub(crate) fn check(path: &Path, doing: &'static str, code: sys::exr_result_t) -> Result<(), Error> {
    let complaint = COMPLAINT.with_borrow_mut(Option::take);
    if code == sys::EXR_ERR_SUCCESS as sys::exr_result_t {
        return Ok(());
    }
    let message = complaint.unwrap_or_else(|| {
        // SAFETY: takes any code and returns a text of static storage.
        let text = unsafe { CStr::from_ptr(sys::exr_get_default_error_message(code)) };
        text.to_string_lossy().into_owned()
    });
    Err(Error::Library { path: path.to_owned(), doing, message })
}

/// An open file of the library, closed when dropped; `'a` is what its callbacks point to.
pub(crate) struct Context<'a> {
    raw: sys::exr_context_t,
    callbacks: PhantomData<&'a ()>,
    /// File that it reads from, if it does: dropped after the context is closed.
    _file: Option<Arc<File>>,
}

// SAFETY: the library guards a context that is open for writing with a mutex of its own, and one that
// is open for reading does not change; threads may call it at the same time.
unsafe impl Sync for Context<'_> {}

impl Context<'_> {
    /// # Safety
    /// `raw` is open, nobody else closes it, and `'a` is no longer than what its callbacks use lives.
    pub(crate) unsafe fn owning(raw: sys::exr_context_t) -> Self {
        Self { raw, callbacks: PhantomData, _file: None }
    }

    /// # Safety
    /// `raw` is open, nobody else closes it, and its callbacks use nothing but `file`.
    pub(crate) unsafe fn reading(raw: sys::exr_context_t, file: Arc<File>) -> Self {
        Self { raw, callbacks: PhantomData, _file: Some(file) }
    }

    /// Handle for calls of the library; valid as long as `self`.
    pub(crate) fn raw(&self) -> sys::exr_context_t {
        self.raw
    }

    /// Number of scanlines that are compressed together, at least 1.
    pub(crate) fn lines_per_chunk(&self, path: &Path, part: i32) -> Result<usize, Error> {
        let mut lines = 0;
        // SAFETY: the context is open, and the place for the answer lives through the call.
        let code = unsafe { sys::exr_get_scanlines_per_chunk(self.raw, part, &mut lines) };
        check(path, "divide the lines", code)?;
        Ok(usize::try_from(lines).unwrap_or(1).max(1))
    }

    /// Writes remaining data, closes the file, and reports errors in doing so.
    pub(crate) fn finish(mut self, path: &Path, doing: &'static str) -> Result<(), Error> {
        // SAFETY: open until this call, which makes the pointer null, so that `drop` does nothing.
        check(path, doing, unsafe { sys::exr_finish(&mut self.raw) })
    }
}

impl Drop for Context<'_> {
    fn drop(&mut self) {
        if !self.raw.is_null() {
            // SAFETY: open, and never used again. Its outcome matters to `finish` only.
            unsafe { sys::exr_finish(&mut self.raw) };
        }
    }
}

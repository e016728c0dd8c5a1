//! Text of the C interface.

use std::ffi::{CStr, c_char};

/// A C string as text; bytes that are not UTF-8 become U+FFFD.
///
/// # Safety
/// `from` is null, or ends with a zero byte.
pub(crate) unsafe fn text(from: *const c_char) -> String {
    if from.is_null() {
        return String::new();
    }
    // SAFETY: not null; the caller's promise.
    unsafe { CStr::from_ptr(from) }.to_string_lossy().into_owned()
}

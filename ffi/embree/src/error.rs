//! Embree's errors as Rust errors, with Embree's own words.

use embree4_sys as sys;
use std::cell::RefCell;
use std::ffi::{CStr, c_char, c_void};
use std::fmt;

/// Kind of failure that Embree reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorCode {
    /// An unknown error.
    Unknown,
    /// An argument is out of range, or of another device.
    InvalidArgument,
    /// The object cannot do that, or not now.
    InvalidOperation,
    /// Memory is exhausted.
    OutOfMemory,
    /// The CPU lacks the instructions Embree was built for (at least SSE2).
    UnsupportedCpu,
    /// A callback cancelled the call.
    Cancelled,
    /// The library that was loaded is older than the headers this crate was built with, or lacks a feature.
    UnsuitableLibrary,
}

/// A call of Embree that failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    code: ErrorCode,
    message: String,
}

impl Error {
    pub(crate) fn new(code: ErrorCode, message: impl Into<String>) -> Self {
        Self { code, message: message.into() }
    }

    pub(crate) fn invalid_argument(message: impl Into<String>) -> Self {
        Self::new(ErrorCode::InvalidArgument, message)
    }

    /// Kind of the failure.
    pub fn code(&self) -> ErrorCode {
        self.code
    }

    /// Embree's message, or ours if the wrapper refused before Embree was asked.
    pub fn message(&self) -> &str {
        &self.message
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Embree: {}", self.message)
    }
}

impl std::error::Error for Error {}

thread_local! {
    /// The first message since the last [`take`]. Embree keeps its error codes per thread too.
    static MESSAGE: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Embree's error callback: keeps the message for [`take`].
///
/// # Safety
/// `text` is null or a C string. Embree calls this from the thread whose call failed.
pub(crate) unsafe extern "C" fn keep_message(_user: *mut c_void, _code: sys::RTCError, text: *const c_char) {
    if text.is_null() {
        return;
    }
    // SAFETY: not null, and by contract a C string that lives during this call.
    let text = unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned();
    // `try_` twice: a message may be lost, a panic must not cross C.
    let _ = MESSAGE.try_with(|kept| {
        if let Ok(mut kept) = kept.try_borrow_mut() {
            kept.get_or_insert(text);
        }
    });
}

/// The error of the calls that this thread made on `device` since the last `take`, if any.
///
/// # Safety
/// `device` is a live device, or null to ask why creating one failed.
pub(crate) unsafe fn take(device: sys::RTCDevice) -> Result<(), Error> {
    // SAFETY: by contract a live device or null, which both are allowed here.
    let code = unsafe { sys::rtcGetDeviceError(device) };
    let kept = MESSAGE.with(RefCell::take);
    if code == sys::RTC_ERROR_NONE {
        return Ok(());
    }
    // SAFETY: as above.
    let message = kept.or_else(|| unsafe { last_message(device) });
    Err(Error::new(translate(code), message.unwrap_or_else(|| format!("error code {code}"))))
}

#[cfg(has_last_error_message)]
unsafe fn last_message(device: sys::RTCDevice) -> Option<String> {
    // SAFETY: the caller passes a live device or null, which both are allowed here.
    let text = unsafe { sys::rtcGetDeviceLastErrorMessage(device) };
    if text.is_null() {
        return None;
    }
    // SAFETY: not null; Embree returns a C string that lives until the next error of this thread.
    let text = unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned();
    (!text.is_empty()).then_some(text)
}

#[cfg(not(has_last_error_message))]
unsafe fn last_message(_device: sys::RTCDevice) -> Option<String> {
    None
}

fn translate(code: sys::RTCError) -> ErrorCode {
    match code {
        sys::RTC_ERROR_INVALID_ARGUMENT => ErrorCode::InvalidArgument,
        sys::RTC_ERROR_INVALID_OPERATION => ErrorCode::InvalidOperation,
        sys::RTC_ERROR_OUT_OF_MEMORY => ErrorCode::OutOfMemory,
        sys::RTC_ERROR_UNSUPPORTED_CPU => ErrorCode::UnsupportedCpu,
        sys::RTC_ERROR_CANCELLED => ErrorCode::Cancelled,
        _ => ErrorCode::Unknown,
    }
}

//! Declarations by hand of the library's functions that are needed: see `oidn.h` of version 2.0.

use std::ffi::{c_char, c_int, c_void};
use std::path::Path;

use libloading::Library;

use crate::error::Error;

/// `OIDNDevice`.
pub(crate) type Device = *mut c_void;

/// `OIDNFilter`.
pub(crate) type Filter = *mut c_void;

/// `OIDN_DEVICE_TYPE_CPU`.
pub(crate) const DEVICE_TYPE_CPU: c_int = 1;

/// `OIDN_FORMAT_FLOAT3`.
pub(crate) const FORMAT_FLOAT3: c_int = 3;

macro_rules! functions {
    ($($field:ident: $name:literal, fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// The functions, and the library that holds them: they must not outlive it.
        pub(crate) struct Functions {
            $(pub(crate) $field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
            _library: Library,
        }

        impl Functions {
            /// Loads the library and finds all functions.
            pub(crate) fn load(path: &Path) -> Result<Self, Error> {
                let failed = |why: libloading::Error| Error::Load { path: path.to_owned(), why: words(&why) };
                // SAFETY: the initializers of Open Image Denoise and of TBB register classes, and ask nothing of the
                // program. Who names a path vouches for what is there.
                let library = unsafe { Library::new(path) }.map_err(failed)?;
                $(
                    // SAFETY: the type is that of the function of this name in oidn.h, in all of version 2. That it is of this version
                    // `Denoiser::load` asks before it calls more of them than it takes to ask.
                    let $field = *unsafe {
                        library.get::<unsafe extern "C" fn($($argument),*) $(-> $result)?>($name)
                    }
                    .map_err(failed)?;
                )*
                Ok(Self { $($field,)* _library: library })
            }
        }
    };
}

functions! {
    new_device: b"oidnNewDevice\0", fn(c_int) -> Device;
    set_device_int: b"oidnSetDeviceInt\0", fn(Device, *const c_char, c_int);
    set_device_bool: b"oidnSetDeviceBool\0", fn(Device, *const c_char, bool);
    get_device_int: b"oidnGetDeviceInt\0", fn(Device, *const c_char) -> c_int;
    commit_device: b"oidnCommitDevice\0", fn(Device);
    get_device_error: b"oidnGetDeviceError\0", fn(Device, *mut *const c_char) -> c_int;
    release_device: b"oidnReleaseDevice\0", fn(Device);
    new_filter: b"oidnNewFilter\0", fn(Device, *const c_char) -> Filter;
    set_image: b"oidnSetSharedFilterImage\0", fn(
        Filter, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize
    );
    set_filter_bool: b"oidnSetFilterBool\0", fn(Filter, *const c_char, bool);
    set_filter_int: b"oidnSetFilterInt\0", fn(Filter, *const c_char, c_int);
    commit_filter: b"oidnCommitFilter\0", fn(Filter);
    execute_filter: b"oidnExecuteFilter\0", fn(Filter);
    release_filter: b"oidnReleaseFilter\0", fn(Filter);
}

/// Message of the system's loader: it is in the error's source, if anywhere.
fn words(error: &libloading::Error) -> String {
    std::error::Error::source(error).map_or_else(|| error.to_string(), ToString::to_string)
}

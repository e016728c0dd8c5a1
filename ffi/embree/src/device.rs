//! The device: Embree's threads, its memory count and its errors.

use crate::error::{self, Error, ErrorCode};
use crate::packet::PacketWidth;
use embree4_sys as sys;
use std::ffi::{CString, c_void};
use std::ptr;
use std::sync::Arc;
use std::sync::atomic::{AtomicIsize, Ordering};

/// An Embree device. Clones share it; it ends with its last clone, scene or geometry.
#[derive(Clone, Debug)]
pub struct Device {
    inner: Arc<Inner>,
}

#[derive(Debug)]
struct Inner {
    raw: sys::RTCDevice,
    /// Bytes that Embree holds. Embree keeps the address of this counter, which stays because an `Arc` holds
    /// it.
    bytes: AtomicIsize,
}

// SAFETY: Embree's device functions may be called from any thread at any time, and the rest is atomic.
unsafe impl Send for Inner {}
// SAFETY: as above.
unsafe impl Sync for Inner {}

impl Device {
    /// Starts a device. `config` is Embree's list of settings, for instance `"threads=2"`; empty for the
    /// defaults (as many build threads as the machine has cores). Embree ignores names it does not know.
    ///
    /// # Errors
    /// Embree's message when a setting has a wrong value, [`ErrorCode::UnsuitableLibrary`] when the library
    /// found at run time is older than 4.3, or was built without what is needed here.
    pub fn new(config: &str) -> Result<Self, Error> {
        let text = CString::new(config)
            .map_err(|_| Error::invalid_argument("the device configuration contains a zero byte"))?;
        // SAFETY: a C string that lives during the call.
        let raw = unsafe { sys::rtcNewDevice(text.as_ptr()) };
        if raw.is_null() {
            // SAFETY: null asks why a device could not be made.
            unsafe { error::take(ptr::null_mut()) }?;
            return Err(Error::new(ErrorCode::Unknown, "no device, and no reason given"));
        }
        let inner = Arc::new(Inner { raw, bytes: AtomicIsize::new(0) });
        let counter = ptr::from_ref(&inner.bytes).cast_mut().cast::<c_void>();
        // SAFETY: the device is live; both functions match their C types and do not unwind; the counter lives
        // in the `Arc`, and `Inner::drop` releases the device before the counter goes.
        unsafe {
            sys::rtcSetDeviceErrorFunction(raw, Some(error::keep_message), ptr::null_mut());
            sys::rtcSetDeviceMemoryMonitorFunction(raw, Some(count_bytes), counter);
        }
        let device = Self { inner };
        device.take_error()?;
        device.check_library()?;
        Ok(device)
    }

    /// Version of the library that is loaded, for instance `"4.4.0"`. It may be newer than the headers.
    pub fn version(&self) -> String {
        format!(
            "{}.{}.{}",
            self.property(sys::RTC_DEVICE_PROPERTY_VERSION_MAJOR),
            self.property(sys::RTC_DEVICE_PROPERTY_VERSION_MINOR),
            self.property(sys::RTC_DEVICE_PROPERTY_VERSION_PATCH)
        )
    }

    /// Width of the widest packets that this processor traces as packets, within the instruction sets that
    /// the configuration allows (`"isa=avx2"`).
    pub fn native_width(&self) -> PacketWidth {
        let property = |width| match width {
            PacketWidth::Four => sys::RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED,
            PacketWidth::Eight => sys::RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED,
            PacketWidth::Sixteen => sys::RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED,
        };
        PacketWidth::widest(|width| self.property(property(width)) != 0)
    }

    /// Bytes that Embree has allocated for the scenes of this device, without the buffers that geometries
    /// share with it.
    pub fn memory_bytes(&self) -> usize {
        usize::try_from(self.inner.bytes.load(Ordering::Relaxed)).unwrap_or(0)
    }

    pub(crate) fn raw(&self) -> sys::RTCDevice {
        self.inner.raw
    }

    pub(crate) fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.inner, &other.inner)
    }

    /// Takes the error of this thread's calls since the last time it was asked for.
    pub(crate) fn take_error(&self) -> Result<(), Error> {
        // SAFETY: `self` keeps the device alive.
        unsafe { error::take(self.inner.raw) }
    }

    fn property(&self, which: sys::RTCDeviceProperty) -> isize {
        // SAFETY: `self` keeps the device alive, and asking for a property has no other condition.
        unsafe { sys::rtcGetDeviceProperty(self.inner.raw, which) as isize }
    }

    /// Checks the library, which is found anew in each run. The headers were checked when this was built.
    fn check_library(&self) -> Result<(), Error> {
        let unsuitable = |what: &str| {
            let version = self.version();
            let text = format!("the library that was loaded, version {version}, {what}");
            Err(Error::new(ErrorCode::UnsuitableLibrary, text))
        };
        if self.property(sys::RTC_DEVICE_PROPERTY_VERSION) < 40300 {
            return unsuitable("is older than 4.3: run `make setup` and build again");
        }
        for (property, option) in NEEDED {
            if self.property(property) == 0 {
                return unsuitable(&format!("was built without {option}"));
            }
        }
        if self.property(sys::RTC_DEVICE_PROPERTY_BACKFACE_CULLING_ENABLED) != 0 {
            return unsuitable("was built with EMBREE_BACKFACE_CULLING, and back faces count here");
        }
        Ok(())
    }
}

/// Properties of a library that are needed here, each with the build option that a person would look for.
const NEEDED: [(sys::RTCDeviceProperty, &str); 4] = [
    (sys::RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED, "EMBREE_RAY_MASK"),
    (sys::RTC_DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED, "EMBREE_FILTER_FUNCTION"),
    (sys::RTC_DEVICE_PROPERTY_TRIANGLE_GEOMETRY_SUPPORTED, "EMBREE_GEOMETRY_TRIANGLE"),
    // Whatever the CPU, packets of 4 are native if there are packets at all.
    (sys::RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED, "EMBREE_RAY_PACKETS"),
];

impl Drop for Inner {
    fn drop(&mut self) {
        // SAFETY: made by rtcNewDevice, released once; scenes and geometries, which hold an `Arc` of this,
        // are gone, so that no callback comes after.
        unsafe { sys::rtcReleaseDevice(self.raw) };
    }
}

/// Embree's memory monitor: adds up what is allocated and freed, and never cancels.
///
/// # Safety
/// `counter` is the live `AtomicIsize` of the device. Any thread may call this.
unsafe extern "C" fn count_bytes(counter: *mut c_void, bytes: isize, _post: bool) -> bool {
    // SAFETY: by contract live, and atomics are shared.
    let counter = unsafe { &*counter.cast::<AtomicIsize>() };
    counter.fetch_add(bytes, Ordering::Relaxed);
    true
}

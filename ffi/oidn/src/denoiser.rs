//! The library's device and its filter for ray tracing.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::fmt;
use std::path::Path;
use std::ptr;

use crate::error::{Error, Kind};
use crate::functions::{DEVICE_TYPE_CPU, Device, FORMAT_FLOAT3, Filter, Functions};

/// `OIDNQuality`: size and precision of the network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(missing_docs, reason = "the library's own names")]
pub enum Quality {
    #[default]
    High,
    Balanced,
    Fast,
}

impl Quality {
    fn number(self) -> c_int {
        match self {
            Self::Fast => 4,
            Self::Balanced => 5,
            Self::High => 6,
        }
    }
}

/// Guides of a denoiser: properties of the surfaces in a picture. One value for each pixel, filtered as the
/// picture is and free of noise.
#[derive(Debug, Clone, Copy)]
pub struct Guides<'a> {
    /// Albedo, 0 to 1.
    pub albedo: &'a [[f32; 3]],
    /// Normals, up to unit length, in any space.
    pub normal: &'a [[f32; 3]],
}

/// Kind of a guide.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Guide {
    /// [`Guides::albedo`].
    Albedo,
    /// [`Guides::normal`].
    Normal,
}

impl Guide {
    /// Name of its image.
    fn name(self) -> &'static CStr {
        match self {
            Self::Albedo => c"albedo",
            Self::Normal => c"normal",
        }
    }
}

/// Approximate limit of the library's working memory, in units of 2^20 bytes: larger pictures are cut into
/// pieces that overlap. The limit is fixed here, so that all machines cut at the same places.
pub const MOST_MEGABYTES: i32 = 2048;

/// Denoises pictures, on the processor.
pub struct Denoiser {
    functions: Functions,
    device: Device,
    filter: Filter,
    quality: Quality,
}

impl fmt::Debug for Denoiser {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Denoiser").field("version", &self.version()).finish_non_exhaustive()
    }
}

impl Denoiser {
    /// Loads the library at `path`; a name without a slash is looked for as programs' libraries are. It works on so many
    /// threads of its own.
    ///
    /// **Trust**: what is at `path` runs with all rights of this program, from the moment it is loaded, and nobody can see from outside
    /// whether its functions are those of Open Image Denoise, which their names and their version alone tell. Take the path from whoever
    /// may run programs here, and not from a document.
    ///
    /// # Errors
    /// The library cannot be loaded or is not of version 2, or it does not support this processor.
    pub fn load(path: &Path, threads: usize, quality: Quality) -> Result<Self, Error> {
        let functions = Functions::load(path)?;
        // SAFETY: the type of a device; what comes is null or a device that belongs to us.
        let device = unsafe { (functions.new_device)(DEVICE_TYPE_CPU) };
        // from here on `drop` releases what there is
        let mut denoiser = Self { functions, device, filter: ptr::null_mut(), quality };
        if device.is_null() {
            return Err(denoiser.error().unwrap_or_else(|| failed("it gives no device for this processor")));
        }
        // the types of all that follows are those of version 2
        let [major, minor, patch] = denoiser.version();
        if major != 2 {
            let why = format!("it is Open Image Denoise {major}.{minor}.{patch}, and version 2 is needed");
            return Err(Error::Load { path: path.to_owned(), why });
        }
        let functions = &denoiser.functions;
        let threads = c_int::try_from(threads).unwrap_or(c_int::MAX);
        // SAFETY: the device is there and not committed, and the names end with a zero.
        unsafe {
            (functions.set_device_int)(device, c"numThreads".as_ptr(), threads);
            // others work on this machine, too: threads stay where the system puts them
            (functions.set_device_bool)(device, c"setAffinity".as_ptr(), false);
            (functions.commit_device)(device);
        }
        denoiser.check()?;
        denoiser.filter = denoiser.new_filter()?;
        Ok(denoiser)
    }

    /// Version of the library: major, minor, patch.
    pub fn version(&self) -> [u32; 3] {
        if self.device.is_null() {
            return [0; 3];
        }
        let part = |name: &CStr| {
            // SAFETY: the device is there, and the name ends with a zero.
            let number = unsafe { (self.functions.get_device_int)(self.device, name.as_ptr()) };
            u32::try_from(number).unwrap_or(0)
        };
        [c"versionMajor", c"versionMinor", c"versionPatch"].map(part)
    }

    /// Denoises `color`, a linear picture of `size` (columns and rows) in rows, of any range. The result is
    /// the same to the bit for the same picture, library and processor.
    ///
    /// # Errors A list has not as many values as there are pixels, or the library fails: it may run out of
    /// memory.
    pub fn denoise(
        &mut self,
        size: [usize; 2],
        color: &[[f32; 3]],
        guides: Guides,
        output: &mut [[f32; 3]],
    ) -> Result<(), Error> {
        let inputs = [
            ("the picture", c"color", color),
            ("the albedo", c"albedo", guides.albedo),
            ("the normals", c"normal", guides.normal),
        ];
        self.apply(self.filter, size, &inputs, output, self.quality)
    }

    /// Denoises a guide by itself: one that is noisy, too, is better for [`denoise`](Self::denoise) then. As good as it gets is
    /// [`Quality::Balanced`] already. The result is the same to the bit as there.
    ///
    /// # Errors
    /// As there.
    pub fn denoise_guide(
        &mut self,
        size: [usize; 2],
        guide: Guide,
        noisy: &[[f32; 3]],
        output: &mut [[f32; 3]],
    ) -> Result<(), Error> {
        let quality = if self.quality == Quality::High { Quality::Balanced } else { self.quality };
        // a filter of its own: the other one keeps its images
        let filter = self.new_filter()?;
        let result = self.apply(filter, size, &[("the guide", guide.name(), noisy)], output, quality);
        // SAFETY: the filter belongs to us, and nobody has it any more.
        unsafe { (self.functions.release_filter)(filter) };
        result
    }

    /// Creates a filter for ray tracing, which belongs to the caller.
    fn new_filter(&self) -> Result<Filter, Error> {
        // SAFETY: the device is committed; what comes is null or a filter that belongs to us.
        let filter = unsafe { (self.functions.new_filter)(self.device, c"RT".as_ptr()) };
        self.check()?;
        if filter.is_null() { Err(failed("it has no filter for ray tracing")) } else { Ok(filter) }
    }

    /// Applies `filter`, one of this device's, to these images: what each is, its name and its pixels.
    fn apply(
        &self,
        filter: Filter,
        size: [usize; 2],
        inputs: &[(&'static str, &CStr, &[[f32; 3]])],
        output: &mut [[f32; 3]],
        quality: Quality,
    ) -> Result<(), Error> {
        let pixels = size[0].saturating_mul(size[1]);
        let lengths = inputs.iter().map(|(what, _, list)| (*what, list.len()));
        for (what, length) in lengths.chain([("the output", output.len())]) {
            if length != pixels {
                return Err(Error::Size { what, length, pixels });
            }
        }
        let functions = &self.functions;
        let set_image = |name: &CStr, data: *mut c_void| {
            // SAFETY: the filter is there; `data` has three floats for each pixel, in rows without gaps (strides of 0
            // say that). The filter keeps the address, and uses it in `execute_filter` alone: below, while the lists
            // are borrowed, after all of its images were set anew.
            unsafe {
                (functions.set_image)(filter, name.as_ptr(), data, FORMAT_FLOAT3, size[0], size[1], 0, 0, 0);
            }
        };
        // the library reads these, and writes the output alone
        for (_, name, list) in inputs {
            set_image(name, list.as_ptr().cast_mut().cast());
        }
        set_image(c"output", output.as_mut_ptr().cast());
        let is_picture = inputs.len() > 1;
        // SAFETY: the filter is there, the names end with a zero; for the images see above.
        unsafe {
            (functions.set_filter_bool)(filter, c"hdr".as_ptr(), is_picture);
            (functions.set_filter_bool)(filter, c"cleanAux".as_ptr(), is_picture);
            (functions.set_filter_int)(filter, c"quality".as_ptr(), quality.number());
            (functions.set_filter_int)(filter, c"maxMemoryMB".as_ptr(), MOST_MEGABYTES);
            (functions.commit_filter)(filter);
        }
        self.check()?;
        // SAFETY: the filter is committed, and returns when it is done.
        unsafe { (functions.execute_filter)(filter) };
        self.check()
    }

    fn check(&self) -> Result<(), Error> {
        self.error().map_or(Ok(()), Err)
    }

    /// Takes the first error since the last time, if there is any. Without a device, that of creating one.
    fn error(&self) -> Option<Error> {
        let mut message: *const c_char = ptr::null();
        // SAFETY: the device may be null; what comes is null or a text that stays until the next call from this thread.
        let (kind, why) = unsafe {
            let code = (self.functions.get_device_error)(self.device, &mut message);
            let text = if message.is_null() { c"" } else { CStr::from_ptr(message) };
            (Kind::of(code)?, text.to_string_lossy().into_owned())
        };
        Some(Error::Library { kind, why })
    }
}

fn failed(why: &str) -> Error {
    Error::Library { kind: Kind::Unknown, why: why.to_owned() }
}

impl Drop for Denoiser {
    fn drop(&mut self) {
        // SAFETY: both belong to us, and nobody has them any more.
        unsafe {
            if !self.filter.is_null() {
                (self.functions.release_filter)(self.filter);
            }
            if !self.device.is_null() {
                (self.functions.release_device)(self.device);
            }
        }
    }
}

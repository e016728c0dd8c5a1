//! Removes noise from finished frames, with Intel's Open Image Denoise. The result is stored beside the
//! picture, never in its place: a denoiser guesses, and the picture is exact.
//!
//! The library is loaded when the first [`Denoiser`] is made. Without it everything else works.

mod blend;

use std::path::{Path, PathBuf};
use std::{env, fmt};

use blend::Blend;

use crate::film::{Film, Plane, PlaneKind, Values};
use crate::frame;
use crate::layers::Layers;
use crate::memory::Part;
use crate::scene::Scene;
use crate::settings::{DenoiseQuality, Settings};

/// Planes of a denoised picture.
pub const PLANES: [&str; 3] = ["denoised.R", "denoised.G", "denoised.B"];

/// Plane of the noise as estimated from the picture's own samples.
const VARIANCE: &str = "denoise_variance.V";

/// File name of the library: version 2 in any of its revisions.
const LIBRARY: &str = "libOpenImageDenoise.so.2";

/// Path of the library that `make setup` installs. Programs that are made to be carried elsewhere know no
/// such place: their run path names the folder of the libraries that they carry, in which the loader looks
/// before it asks the system.
const PRIVATE: Option<&str> = option_env!("AFTERIMAGE_PRIVATE_OIDN");

/// Environment variable with the prefix of a library that is to be used, and no other.
const PREFIX_VARIABLE: &str = "OIDN_DIR";

/// Reason why a frame cannot be denoised.
#[derive(Debug)]
pub enum DenoiseError {
    /// There is no library, or none that can be used.
    Missing {
        /// Errors of all attempts.
        tried: Vec<oidn::Error>,
        /// True if a place was named, so that no other was tried.
        is_named: bool,
    },
    /// A plane that denoising needs is not in the film.
    NoPlane(&'static str),
    /// The library failed.
    Failed(oidn::Error),
}

impl fmt::Display for DenoiseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all =
            |tried: &[oidn::Error]| tried.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
        match self {
            Self::Missing { tried, is_named: true } => write!(
                f,
                "{PREFIX_VARIABLE} is set, but there is no Open Image Denoise 2 to use: {}. Set it to a folder that \
                 holds lib/{LIBRARY}, or unset it and run `make setup`",
                all(tried)
            ),
            Self::Missing { tried, .. } => write!(
                f,
                "denoising needs Intel's Open Image Denoise 2, which was not found: run `make setup`, or set \
                 {PREFIX_VARIABLE} to a folder that holds lib/{LIBRARY} (tried: {})",
                all(tried)
            ),
            Self::NoPlane(name) => write!(f, "denoising: the frame has no plane {name}"),
            Self::Failed(error) => {
                write!(f, "denoising: {error}. Frames without --denoise do not need it")
            }
        }
    }
}

impl std::error::Error for DenoiseError {}

/// Denoises frames, one after the other. Keeps its memory.
#[derive(Debug)]
pub struct Denoiser {
    library: oidn::Denoiser,
    color: Vec<[f32; 3]>,
    albedo: Vec<[f32; 3]>,
    normal: Vec<[f32; 3]>,
    output: Vec<[f32; 3]>,
    blend: Blend,
    filters_guides: bool,
}

impl Denoiser {
    /// Loads the library, which will work on so many threads of its own. It is the one that `OIDN_DIR` names;
    /// or else the one that the program carries, that of the system, or that of `make setup`.
    ///
    /// # Errors None of them can be used: what was tried, and what to do.
    pub fn new(threads: usize, quality: DenoiseQuality) -> Result<Self, DenoiseError> {
        let named = env::var_os(PREFIX_VARIABLE).filter(|prefix| !prefix.is_empty());
        let in_prefix = |prefix: &Path| prefix.join("lib").join(LIBRARY);
        let places: Vec<PathBuf> = match &named {
            Some(prefix) => vec![in_prefix(Path::new(prefix))],
            None => {
                let private = PRIVATE.map(|prefix| in_prefix(Path::new(prefix)));
                std::iter::once(PathBuf::from(LIBRARY)).chain(private).collect()
            }
        };
        let mut tried = Vec::new();
        for place in &places {
            match oidn::Denoiser::load(place, threads, of_library(quality)) {
                Ok(library) => {
                    let [color, albedo, normal, output] = Default::default();
                    let (blend, filters_guides) = (Blend::default(), false);
                    return Ok(Self { library, color, albedo, normal, output, blend, filters_guides });
                }
                Err(error) => tried.push(error),
            }
        }
        Err(DenoiseError::Missing { tried, is_named: named.is_some() })
    }

    /// Has the guides denoised first, each by itself, or not, which is the default. See [`has_rough_guides`].
    pub fn filtering_guides(self, filters_guides: bool) -> Self {
        Self { filters_guides, ..self }
    }

    /// Version of the library that is loaded.
    pub fn version(&self) -> String {
        let [major, minor, patch] = self.library.version();
        format!("{major}.{minor}.{patch}")
    }

    /// Denoises the picture of `film`, which must have the layers that denoising [needs](with_guides). The
    /// result is the library's, and the picture itself [where that is known better](Blend::keep_known).
    ///
    /// # Errors A plane is not there, or the library fails: it may run out of memory.
    pub fn denoise(&mut self, film: &Film) -> Result<[Plane; 3], DenoiseError> {
        let Self { library, color, albedo, normal, output, blend, filters_guides } = self;
        interleave(film, ["R", "G", "B"], color)?;
        interleave(film, ["denoise_albedo.R", "denoise_albedo.G", "denoise_albedo.B"], albedo)?;
        interleave(film, ["denoise_normal.X", "denoise_normal.Y", "denoise_normal.Z"], normal)?;
        output.clear();
        output.resize(color.len(), [0.0; 3]);
        let size = [film.width as usize, film.height as usize];
        if *filters_guides {
            for (guide, pixels) in [(oidn::Guide::Albedo, &mut *albedo), (oidn::Guide::Normal, &mut *normal)]
            {
                library.denoise_guide(size, guide, pixels, output).map_err(DenoiseError::Failed)?;
                std::mem::swap(pixels, output);
            }
        }
        library
            .denoise(size, color, oidn::Guides { albedo, normal }, output)
            .map_err(DenoiseError::Failed)?;
        for value in output.as_flattened_mut() {
            *value = value.max(0.0); // no NaN, either
        }
        let variance = film.plane(VARIANCE).ok_or(DenoiseError::NoPlane(VARIANCE))?;
        blend.keep_known(size, color, &variance.values, output);
        let mut channel = vec![0.0; output.len()];
        let planes = [0, 1, 2].map(|part| {
            for (value, color) in channel.iter_mut().zip(&*output) {
                *value = color[part];
            }
            Plane::new(PLANES[part], PlaneKind::Half, &channel)
        });
        Ok(planes)
    }
}

fn of_library(quality: DenoiseQuality) -> oidn::Quality {
    match quality {
        DenoiseQuality::High => oidn::Quality::High,
        DenoiseQuality::Balanced => oidn::Quality::Balanced,
        DenoiseQuality::Fast => oidn::Quality::Fast,
    }
}

/// Interleaves three planes as pixels.
fn interleave(film: &Film, names: [&'static str; 3], pixels: &mut Vec<[f32; 3]>) -> Result<(), DenoiseError> {
    let count = film.width as usize * film.height as usize;
    pixels.clear();
    pixels.resize(count, [0.0; 3]);
    for (part, name) in names.into_iter().enumerate() {
        let plane = film.plane(name).ok_or(DenoiseError::NoPlane(name))?;
        let mut put = |values: &mut dyn Iterator<Item = f32>| {
            pixels.iter_mut().zip(values).for_each(|(pixel, value)| pixel[part] = value);
        };
        match &plane.values {
            Values::Half(values) => put(&mut values.iter().map(|value| value.to_f32())),
            Values::Float(values) => put(&mut values.iter().copied()),
        }
    }
    Ok(())
}

/// Adds the layers that denoising needs to `settings`.
pub fn with_guides(settings: &Settings) -> Settings {
    Settings { layers: settings.layers.with(Layers::GUIDES).with(Layers::VARIANCE), ..settings.clone() }
}

/// Returns true if guides of the frames of `scene` gain from being denoised first: where one sample shows each pixel, edges are jagged, and
/// kept samples lie beside the middle of their pixels. With more samples it blurs more of textures than it takes away from noise
/// (docs/experiments.md).
pub fn has_rough_guides(scene: &Scene, settings: &Settings) -> bool {
    settings.samples_a_pixel() == 1
        && frame::exposures(scene, settings).is_none_or(|exposures| exposures.all.len() == 1)
}

/// Memory that denoising takes: our pixels, the library's working memory up to its limit, and the library
/// itself (measured with 2.5.1).
pub fn need(settings: &Settings) -> Part {
    const OURS: u64 = 4 * 12 + 2 * 8 + 2 * 3 * 2; // the last picture is being written meanwhile
    const WORKING: u64 = 720;
    const LIBRARY: u64 = 30 << 20;
    let pixels = settings.data_window().pixels();
    let working = (pixels * WORKING).min((oidn::MOST_MEGABYTES as u64) << 20);
    Part::new("denoising", pixels * OURS + working + LIBRARY, "a smaller --size, no --denoise")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_become_pixels() {
        let plane = |name, kind, first: f32| Plane::new(name, kind, &[first, first + 1.0]);
        let planes = vec![
            plane("R", PlaneKind::Half, 0.0),
            plane("G", PlaneKind::Float, 10.0),
            plane("B", PlaneKind::Half, 20.0),
        ];
        let film = Film { width: 2, height: 1, planes };
        let mut pixels = vec![[7.0; 3]; 9];
        interleave(&film, ["R", "G", "B"], &mut pixels).expect("all are there");
        assert_eq!(pixels, [[0.0, 10.0, 20.0], [1.0, 11.0, 21.0]]);
        let error = interleave(&film, ["R", "G", "denoise_albedo.R"], &mut pixels).expect_err("one is not");
        assert!(error.to_string().contains("no plane denoise_albedo.R"), "{error}");
    }
}

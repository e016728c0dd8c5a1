//! Options of both `render` and `compare`: as typed, and validated.

pub mod blur;
pub mod samples;
pub mod two_eyes;
pub mod values;

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::Args;
use rayon::ThreadPool;

use self::blur::BlurArgs;
use self::samples::SamplesArg;
use self::two_eyes::StereoArgs;
use self::values::{
    BackdropArg, Backend, BasePlaceArg, BuildArg, CausticsArg, ClampArg, CompressionArg, FilterArg, ReuseArg,
    ViewArg, clamp, crop, exposure, filter_radius, radius, settled_look, size, threads,
};
use crate::cli::bare_model::{BareModelArgs, is_model};
use crate::cli::failure::Failure;
use crate::cli::frames::target::Target;
use crate::cli::say::terminal::ProgressKind;
use crate::layers::Layers;
use crate::memory::{self, Need, Part};
use crate::pilot::{self, Choice};
use crate::scene::frames::Frames;
use crate::scene::{self, Shot, load_turntable, turntable};
use crate::settings::{
    Backdrop, BasePlace, Budget, Caustics, Compression, DenoiseQuality, FileFormat, Filter, Free, Look,
    MOST_OCCLUSION_RAYS, MOST_OVERSCAN, MOST_PATHS, MOST_REFLECTIONS, MOST_TREE_MEMORY, Mode, PixelRect,
    Reuse, Settings, Wanted,
};
use crate::trace::BackendKind;

/// Arguments as typed.
#[derive(Debug, Clone, Args)]
pub struct ShotArgs {
    /// A shot (TOML), or a model (OBJ, PLY, glTF, USD); without a camera of its own it is rendered on a turntable
    #[arg(value_name = "SHOT.toml|MODEL")]
    pub shot: PathBuf,

    /// Frames to render, for example 1-100, 1-100x2 (every second) or 1-10,150 [default: the shot's]
    #[arg(long, value_name = "RANGE", allow_hyphen_values = true, value_parser = Frames::parse)]
    pub frames: Option<Frames>,

    /// Size of the pictures in pixels, for example 1280x720 [default: the shot's]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<(u32, u32)>,

    /// Render only these pixels of the picture: width, height, and how far right and down they begin, for example
    /// 320x180+640+400. Files keep the picture's size as their display window
    #[arg(long, value_name = "WxH+X+Y", value_parser = crop)]
    pub crop: Option<PixelRect>,

    /// Render so many pixels more on each side of the picture. Files keep the picture's size as their display window
    /// [default: the shot's]
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(0..=i64::from(MOST_OVERSCAN)))]
    pub overscan: Option<u32>,

    /// N, for N x N samples a pixel; or two, like 1-4: the fewest, and the most in pixels that differ from their neighbours
    /// [default: the shot's]
    #[arg(long, value_name = "N|MIN-MAX", value_parser = samples::samples)]
    pub samples: Option<SamplesArg>,

    /// Noise that a frame may have, before any denoiser, relative to its mean: 0.03, or 3%. Samples, paths, reflections and shadow rays
    /// that are not given follow from it [default: the shot's]
    #[arg(long, value_name = "SHARE", value_parser = Wanted::parse)]
    pub error: Option<f32>,

    /// Contrast of colours from which on pixels with adaptive samples get more, above 0 and below 1 [default: the shot's,
    /// or 0.1]
    #[arg(long, value_name = "CONTRAST", value_parser = samples::threshold)]
    pub threshold: Option<f32>,

    /// Pixel filter [default: the shot's]
    #[arg(long, value_enum)]
    pub filter: Option<FilterArg>,

    /// Radius of the filter, in pixels, 0.5 to 4; not for box and area [default: the shot's, or by the filter]
    #[arg(long, value_name = "PIXELS", value_parser = filter_radius)]
    pub filter_radius: Option<f32>,

    /// Maximum number of mirror reflections and refractions along a camera path [default: the shot's]
    #[arg(long, value_name = "BOUNCES", value_parser = clap::value_parser!(u32).range(0..=64))]
    pub depth: Option<u32>,

    /// Rays by which each sample of a rough surface reflects the scene, at most; 0: it does not [default: the shot's]
    #[arg(long, value_name = "RAYS", value_parser = clap::value_parser!(u32).range(0..=i64::from(MOST_REFLECTIONS)))]
    pub reflections: Option<u32>,

    /// Light by way of clear glass [default: the shot's]
    #[arg(long, value_enum)]
    pub caustics: Option<CausticsArg>,

    /// Limit of the indirect radiance that a ray beyond the first surface, or a path, may bring (above 0):
    /// fewer sparks, and less light; `none`: no limit [default: the shot's]
    #[arg(long, value_name = "RADIANCE|none", value_parser = clamp)]
    pub clamp: Option<ClampArg>,

    /// Light group whose contribution alone is rendered: the sum over all groups is the picture [default: the shot's]
    #[arg(long, value_name = "GROUP")]
    pub only_lights: Option<String>,

    /// Memory for what mirrors and glass show while the camera rests, so that only what changes is traced again; 0: none [default:
    /// the shot's]
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u32).range(0..=i64::from(MOST_TREE_MEMORY)))]
    pub tree_memory: Option<u32>,

    /// Paths by which each sample gathers light from the sky and from other surfaces; 0: none [default: the shot's]
    #[arg(long, value_name = "PATHS", value_parser = clap::value_parser!(u32).range(0..=i64::from(MOST_PATHS)))]
    pub paths: Option<u32>,

    /// Budget for the paths of each frame, so that kept samples get more of them: `full` for as many as a
    /// frame that is traced in full, or a number of rays. A new sample gets its --paths-per-frame at once
    /// [default: the shot's]
    #[arg(long, value_name = "full|RAYS", value_parser = Budget::parse)]
    pub budget: Option<Budget>,

    /// With --budget: paths that a new sample gets at once [default: the shot's]
    #[arg(long, value_name = "PATHS", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_PATHS)))]
    pub paths_per_frame: Option<u32>,

    /// Maximum number of surfaces that such a path meets [default: the shot's]
    #[arg(long, value_name = "BOUNCES", value_parser = clap::value_parser!(u32).range(0..=64))]
    pub bounces: Option<u32>,

    /// Distance within which surfaces occlude, in the units of the models: for the layer `occlusion`, and for
    /// ambient light that is `occluded` [default: the shot's]
    #[arg(long, value_name = "LENGTH", value_parser = radius)]
    pub occlusion_radius: Option<f64>,

    /// Rays of ambient occlusion of each sample [default: the shot's]
    #[arg(long, value_name = "RAYS", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_OCCLUSION_RAYS)))]
    pub occlusion_rays: Option<u32>,

    /// Two eyes, or one.
    #[command(flatten)]
    pub stereo: StereoArgs,

    /// Motion blur and depth of field.
    #[command(flatten)]
    pub blur: BlurArgs,

    /// Which kept samples a cell shows [default: the shot's]
    #[arg(long, value_enum, value_name = "RULE")]
    pub reuse: Option<ReuseArg>,

    /// Trace every K-th frame in full, counted from the shot's first; 0: only the first. For chunks of a farm
    /// [default: the shot's]
    #[arg(long, value_name = "K")]
    pub base_every: Option<u32>,

    /// Which of each K frames is traced in full: the first, or the one in the middle. Those before it are made backwards in time
    /// [default: the shot's]
    #[arg(long, value_enum, value_name = "WHERE")]
    pub base_place: Option<BasePlaceArg>,

    /// Layers beside R G B A: their names are in the help.
    #[arg(long, value_name = "LAYERS", value_parser = Layers::parse, help = layers_help())]
    pub layers: Option<Layers>,

    /// Treatment of the background where the camera sees it [default: the shot's]
    #[arg(long, value_enum, value_name = "HOW")]
    pub background: Option<BackdropArg>,

    /// Write each layer as a part of its own into the EXR files [default: the shot's]
    #[arg(long)]
    pub multipart: bool,

    /// Lossless compression of the EXR files [default: the shot's]
    #[arg(long, value_enum, value_name = "METHOD")]
    pub compression: Option<CompressionArg>,

    /// Trace every sample of every frame again and count differences; any difference is a failure
    #[arg(long)]
    pub audit: bool,

    /// Also write an 8-bit sRGB PNG beside each EXR; `render` does so for a bare model in any case
    #[arg(long)]
    pub png: bool,

    /// Stops by which pictures for screens are brighter, as 1 or -2.5: those of --png, contact sheets, movies and reports. EXR
    /// files stay as they are [default: the shot's, or 0]
    #[arg(long, value_name = "STOPS", value_parser = exposure, allow_hyphen_values = true)]
    pub exposure: Option<f32>,

    /// View transform of the same pictures [default: the shot's, or standard]
    #[arg(long, value_enum)]
    pub view: Option<ViewArg>,

    /// A bare model's axis, camera and animation.
    #[command(flatten)]
    pub bare: BareModelArgs,

    /// Treat missing textures, materials and MTL files, and invalid MTL values, as errors
    #[arg(long)]
    pub strict: bool,

    /// Ray-tracing backend [default: embree; `compare`: all]
    #[arg(long, value_enum)]
    pub backend: Option<Backend>,

    /// Build quality of Embree's BVH
    #[arg(long, value_enum, default_value_t, value_name = "HOW")]
    pub build: BuildArg,

    /// Number of rendering threads [default: one per core]
    #[arg(long, value_name = "N", value_parser = threads)]
    pub threads: Option<NonZeroUsize>,

    /// Progress on stderr
    #[arg(long, value_enum, default_value_t, value_name = "KIND")]
    pub progress: ProgressKind,

    /// Print only errors and warnings
    #[arg(short, long)]
    pub quiet: bool,
}

/// A loaded shot with settled settings and frames: those of the command line, and the shot's for the rest.
#[derive(Debug, Clone)]
pub struct Job {
    /// Path of the shot as given on the command line.
    pub path: PathBuf,
    /// The shot. Its `settings`, `frames` and `output` are those of the file, without the command line's
    /// changes.
    pub shot: Shot,
    /// Settled settings.
    pub settings: Settings,
    /// Frames to render. The chains of a schedule need the runs.
    pub frames: Frames,
    /// Format of the frames' files.
    pub format: FileFormat,
    /// Exposure and view transform of pictures for screens.
    pub look: Look,
    /// Ray-tracing backend, if one was given.
    pub backend: Option<BackendKind>,
    /// The counts of `settings` that follow from an error, if one is wanted.
    pub choice: Option<Choice>,
    /// Quality of the denoised pictures; none if frames are not denoised.
    pub denoise: Option<DenoiseQuality>,
}

/// Help of `--layers`.
fn layers_help() -> String {
    format!(
        "Layers to render and write beside R G B A: a comma-separated list of {}; or of `all`, `usual` ({}) and `none` [default: the \
         shot's]",
        Layers::NAMES.join(", "),
        Layers::USUAL.names().collect::<Vec<_>>().join(", ")
    )
}

impl ShotArgs {
    /// Loads the shot. The command line beats the file. `mode`: see [`Settings::mode`].
    pub fn load(&self, mode: Option<Mode>) -> Result<Job, Failure> {
        let mut shot = open(&self.shot, self.strict, &self.bare.options(&self.shot, self.size)?)?;
        let mut settings = self.blur.settle(self.settled(&shot.settings)?, &mut shot.scene);
        let kind = self.backend.map(BackendKind::from);
        settings.mode = mode.unwrap_or(settings.mode);
        let choice = pilot::choose(kind.unwrap_or_default(), &shot, &settings).map_err(Failure::of)?;
        if let Some(choice) = &choice {
            choice.apply(&mut shot.scene, &mut settings);
            samples::check_samples(&settings, "--error")?;
        }
        two_eyes::check(&settings, &shot.scene, self.multipart || shot.format.multipart)?;
        let settings = Settings { build: self.build.for_shot(&shot, &settings), ..settings };
        let frames = self.frames.clone().unwrap_or_else(|| shot.frames.clone());
        Ok(Job {
            path: self.shot.clone(),
            denoise: shot.denoise.then_some(shot.denoise_quality),
            format: FileFormat {
                multipart: self.multipart || shot.format.multipart,
                compression: self.compression.map_or(shot.format.compression, Compression::from),
            },
            look: settled_look((self.exposure, self.view), shot.look),
            shot,
            settings,
            frames,
            backend: kind,
            choice,
        })
    }

    /// The error that is wanted. One that is typed counts for all that is not typed beside it, whatever the shot states.
    fn wanted(&self, of_shot: Option<Wanted>) -> Option<Wanted> {
        let error = self.error.map(|error| Wanted { error, free: Free::ALL });
        let Wanted { error, free } = error.or(of_shot)?;
        let free = Free {
            samples: free.samples && self.samples.is_none(),
            paths: free.paths && self.paths.is_none(),
            reflections: free.reflections && self.reflections.is_none(),
            shadow_rays: free.shadow_rays,
        };
        Some(Wanted { error, free })
    }

    /// Settings of the shot, changed by the command line. The build quality stays: it depends on the shot,
    /// too.
    fn settled(&self, settings: &Settings) -> Result<Settings, Failure> {
        let (width, height) = self.size.unwrap_or((settings.width, settings.height));
        let filter = self.filter.map(Filter::from);
        // the radius of the shot is that of the shot's filter
        let of_shot =
            settings.filter_radius.filter(|_| filter.is_none_or(|filter| filter == settings.filter));
        let filter = filter.unwrap_or(settings.filter);
        if filter.is_of_one_pixel() && self.filter_radius.is_some() {
            return Err(Failure::Usage(String::from(
                "--filter-radius means nothing for the filters box and area, which are a pixel: add --filter",
            )));
        }
        let (samples, refinement) = samples::settled(self.samples, self.threshold, settings, filter)?;
        let settled = Settings {
            width,
            height,
            overscan: self.overscan.unwrap_or(settings.overscan),
            crop: self.crop.or(settings.crop),
            samples,
            refinement,
            filter,
            filter_radius: self.filter_radius.or(of_shot),
            depth: self.depth.unwrap_or(settings.depth),
            reflections: self.reflections.unwrap_or(settings.reflections),
            paths: self.paths.unwrap_or(settings.paths),
            paths_per_frame: self.paths_per_frame.unwrap_or(settings.paths_per_frame),
            budget: self.budget.unwrap_or(settings.budget),
            bounces: self.bounces.unwrap_or(settings.bounces),
            volume_bounces: settings.volume_bounces,
            volume_samples: settings.volume_samples,
            caustics: self.caustics.map_or(settings.caustics, Caustics::from),
            clamp: self.clamp.map_or(settings.clamp, |limit| limit.0),
            only_lights: self.only_lights.clone().or_else(|| settings.only_lights.clone()),
            occlusion_rays: self.occlusion_rays.unwrap_or(settings.occlusion_rays),
            occlusion_radius: self.occlusion_radius.unwrap_or(settings.occlusion_radius),
            tree_memory: self.tree_memory.unwrap_or(settings.tree_memory),
            stereo: self.stereo.settle(settings.stereo)?,
            base_every: self.base_every.unwrap_or(settings.base_every),
            base_place: self.base_place.map_or(settings.base_place, BasePlace::from),
            layers: self.layers.unwrap_or(settings.layers),
            background: self.background.map_or(settings.background, Backdrop::from),
            audit: self.audit || settings.audit,
            reuse: self.reuse.map_or(settings.reuse, Reuse::from),
            wanted: self.wanted(settings.wanted),
            ..settings.clone()
        };
        samples::check_window(&settled)?;
        samples::check_samples(&settled, "--samples")?;
        Ok(settled)
    }
}

impl Job {
    /// Shadow rays that follow from an error, if they do: else the shot states them.
    pub fn shadow_rays(&self) -> Option<u32> {
        self.choice.as_ref().and_then(|choice| choice.counts.shadow_rays)
    }

    /// The files that `pattern` names, or the shot's `output`, or `out/NAME/NAME.####.exr`.
    pub fn target(&self, pattern: Option<&str>, png: bool) -> Result<Target, Failure> {
        let text = pattern.map(String::from).or_else(|| self.shot.output.clone());
        let text = text.unwrap_or_else(|| default_output(&self.path));
        Target::new(
            &text,
            &name_of(&self.path),
            self.frames.list(),
            png,
            self.shot.rate,
            (&self.settings, self.format, self.look),
        )
    }
}

/// Loads a shot, or a model as a turntable.
pub fn open(path: &Path, strict: bool, options: &turntable::Options) -> Result<Shot, Failure> {
    /// Minimum memory, bytes, for loading any shot.
    const LEAST_BYTES: u64 = 24 << 20;
    let least = Need::new(Part::new("loading a shot", LEAST_BYTES, "a higher limit"));
    least.check(&memory::left()).map_err(Failure::of)?;
    let load =
        |path| if is_model(path) { load_turntable(path, strict, options) } else { scene::load(path, strict) };
    load(path).map_err(Failure::of)
}

/// Runs `work` on so many threads: one per core if no number is given.
pub fn on_threads<T: Send>(
    threads: Option<NonZeroUsize>,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    pool(threads)?.install(work)
}

/// Creates a pool of so many threads: one per core if no number is given.
pub fn pool(threads: Option<NonZeroUsize>) -> Result<ThreadPool, Failure> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.map_or(0, NonZeroUsize::get))
        .thread_name(|index| format!("afterimage-{index}"))
        .build()
        .map_err(|error| Failure::Failed(format!("cannot start threads: {error}; try fewer --threads")))?;
    // the C library reserves addresses for each thread that begins to allocate: what is left is asked for after that
    pool.broadcast(|_| drop(std::hint::black_box(Box::new(0_u8))));
    Ok(pool)
}

/// Default names of a shot's frames, if neither the shot nor the command line names them.
pub fn default_output(shot: &Path) -> String {
    let name = name_of(shot);
    format!("out/{name}/{name}.####.exr")
}

/// Name of a shot within file names: that of its own file without the ending.
fn name_of(shot: &Path) -> String {
    let stem = shot.file_stem().map_or_else(|| "frame".into(), |stem| stem.to_string_lossy());
    // in a pattern, # and % stand for the number
    stem.replace(['#', '%'], "_")
}

#[cfg(test)]
mod tests;

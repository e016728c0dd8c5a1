//! Options of both `render` and `compare`: as typed, and validated.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::Args;
use rayon::ThreadPool;

use super::bare_model::{UpArg, is_model, turntable_options};
use super::blur_args::BlurArgs;
use super::failure::Failure;
use super::samples_args::{self, SamplesArg};
use super::target::Target;
use super::terminal::ProgressKind;
use super::two_eyes::{self, StereoArgs};
use super::values::{
    BackdropArg, Backend, BasePlaceArg, BuildArg, CausticsArg, ClampArg, CompressionArg, FilterArg, ReuseArg,
    ViewArg, clamp, crop, exposure, filter_radius, radius, settled_look, size, threads,
};
use crate::layers::Layers;
use crate::memory::{self, Need, Part};
use crate::scene::frames::Frames;
use crate::scene::turntable;
use crate::scene::{self, Shot, load_turntable};
use crate::settings::{
    Backdrop, BasePlace, Budget, Caustics, Compression, DenoiseQuality, FileFormat, Filter, Look,
    MOST_OCCLUSION_RAYS, MOST_OVERSCAN, MOST_PATHS, MOST_REFLECTIONS, MOST_TREE_MEMORY, PixelRect, Reuse,
    Settings,
};
use crate::trace::BackendKind;

/// As typed.
#[derive(Debug, Clone, Args)]
pub struct ShotArgs {
    /// A shot (TOML), or a model (OBJ), rendered on a turntable
    #[arg(value_name = "SHOT.toml|MODEL.obj")]
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
    #[arg(long, value_name = "N|MIN-MAX", value_parser = samples_args::samples)]
    pub samples: Option<SamplesArg>,

    /// Contrast of colours from which on pixels with adaptive samples get more, above 0 and below 1 [default: the shot's,
    /// or 0.1]
    #[arg(long, value_name = "CONTRAST", value_parser = samples_args::threshold)]
    pub threshold: Option<f32>,

    /// Pixel filter [default: the shot's]
    #[arg(long, value_enum)]
    pub filter: Option<FilterArg>,

    /// How far the filter reaches, in pixels, 0.5 to 4; not for the box [default: the shot's, or by the filter]
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

    /// What a ray beyond the first surface, or a path, may bring by indirect ways, at most (radiance, above 0): fewer sparks, and less
    /// light; `none`: whatever it finds [default: the shot's]
    #[arg(long, value_name = "RADIANCE|none", value_parser = clamp)]
    pub clamp: Option<ClampArg>,

    /// Memory for what mirrors and glass show while the camera rests, so that only what changes is traced again; 0: none [default:
    /// the shot's]
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u32).range(0..=i64::from(MOST_TREE_MEMORY)))]
    pub tree_memory: Option<u32>,

    /// Paths by which each sample gathers light from the sky and from other surfaces; 0: none [default: the shot's]
    #[arg(long, value_name = "PATHS", value_parser = clap::value_parser!(u32).range(0..=i64::from(MOST_PATHS)))]
    pub paths: Option<u32>,

    /// What each frame spends on paths, so that kept samples get more of them: `full` for as many as a frame that is traced
    /// in full, or a number of rays. A new sample gets its --paths-per-frame at once [default: the shot's]
    #[arg(long, value_name = "full|RAYS", value_parser = Budget::parse)]
    pub budget: Option<Budget>,

    /// With --budget: paths that a new sample gets at once [default: the shot's]
    #[arg(long, value_name = "PATHS", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_PATHS)))]
    pub paths_per_frame: Option<u32>,

    /// Maximum number of surfaces that such a path meets [default: the shot's]
    #[arg(long, value_name = "BOUNCES", value_parser = clap::value_parser!(u32).range(0..=64))]
    pub bounces: Option<u32>,

    /// How far away surfaces occlude, in the units of the models: for the layer `occlusion`, and for ambient light that is
    /// `occluded` [default: the shot's]
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

    /// Layers to render and write beside R G B A: a comma-separated list of diffuse, specular, reflection, refraction, albedo, Z,
    /// P, N, object, status, rays, direct, indirect, emission, background, denoise_albedo, denoise_normal, occlusion, motion,
    /// forward, backward, CryptoObject, CryptoMaterial, CryptoGroup, light, depth, material, uv, denoise_variance; or of `all`,
    /// `usual` (Z, object, status) and `none` [default: the shot's]
    #[arg(long, value_name = "LAYERS", value_parser = Layers::parse)]
    pub layers: Option<Layers>,

    /// What becomes of the background where the camera sees it [default: the shot's]
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

    /// Of a bare model: the axis of its file that points up [default: guessed from what the model stands on]
    #[arg(long, value_enum, value_name = "AXIS")]
    pub up: Option<UpArg>,

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

/// A shot that is loaded, with settings and frames that are settled.
#[derive(Debug, Clone)]
pub struct Job {
    /// As it was named.
    pub path: PathBuf,
    /// Its `settings`, `frames` and `output` are what the file says, not what holds.
    pub shot: Shot,
    /// What holds.
    pub settings: Settings,
    /// Asked for; the chains of a schedule need the runs.
    pub frames: Frames,
    /// How files are made.
    pub format: FileFormat,
    /// How pictures for screens show frames.
    pub look: Look,
    /// Ray-tracing backend, if one was given.
    pub backend: Option<BackendKind>,
    /// With what quality frames are denoised as well, if they are.
    pub denoise: Option<DenoiseQuality>,
}

impl ShotArgs {
    /// Loads the shot. The command line beats the file.
    pub fn load(&self) -> Result<Job, Failure> {
        let mut shot = open(&self.shot, self.strict, &turntable_options(&self.shot, self.up, self.size)?)?;
        let settings = self.blur.settle(self.settled(&shot.settings)?, &mut shot.scene);
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
            backend: self.backend.map(BackendKind::from),
        })
    }

    /// `settings` with what the command line says instead, but for how to build: that depends on the shot, too.
    fn settled(&self, settings: &Settings) -> Result<Settings, Failure> {
        let (width, height) = self.size.unwrap_or((settings.width, settings.height));
        let filter = self.filter.map(Filter::from);
        // the radius of the shot is that of the shot's filter
        let of_shot =
            settings.filter_radius.filter(|_| filter.is_none_or(|filter| filter == settings.filter));
        let filter = filter.unwrap_or(settings.filter);
        if filter == Filter::Box && self.filter_radius.is_some() {
            return Err(Failure::Usage(String::from(
                "--filter-radius means nothing for the box, which is a pixel: add --filter",
            )));
        }
        let (samples, refinement) = samples_args::settled(self.samples, self.threshold, settings, filter)?;
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
            caustics: self.caustics.map_or(settings.caustics, Caustics::from),
            clamp: self.clamp.map_or(settings.clamp, |limit| limit.0),
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
            ..settings.clone()
        };
        samples_args::check_window(&settled)?;
        samples_args::check_samples(&settled, "--samples")?;
        Ok(settled)
    }
}

impl Job {
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
    /// What any shot takes while it is loaded.
    const LEAST_BYTES: u64 = 24 << 20;
    let least = Need::of(Part::new("loading a shot", LEAST_BYTES, "a higher limit"));
    least.check(&memory::left()).map_err(Failure::of)?;
    let load =
        |path| if is_model(path) { load_turntable(path, strict, options) } else { scene::load(path, strict) };
    load(path).map_err(Failure::of)
}

/// Runs `work` on so many threads, all cores where none are given.
pub fn on_threads<T: Send>(
    threads: Option<NonZeroUsize>,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    pool(threads)?.install(work)
}

/// So many threads, all cores where none are given.
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

/// The names of a shot's frames where neither the shot nor the command line say them.
pub fn default_output(shot: &Path) -> String {
    let name = name_of(shot);
    format!("out/{name}/{name}.####.exr")
}

/// What a shot is called in file names: its own file's name without its ending.
fn name_of(shot: &Path) -> String {
    let stem = shot.file_stem().map_or_else(|| "frame".into(), |stem| stem.to_string_lossy());
    // in a pattern, # and % stand for the number
    stem.replace(['#', '%'], "_")
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use glam::DVec3;

    use super::*;
    use crate::animation::{Interpolation, Track, TransformTrack};
    use crate::scene::{Model, Scene};
    use crate::settings::Refinement;
    use crate::settings::{Build, Mode};

    #[derive(Parser)]
    struct Typed {
        #[command(flatten)]
        args: ShotArgs,
    }

    fn typed(line: &str) -> Result<ShotArgs, String> {
        let words = std::iter::once("test").chain(line.split_whitespace());
        Typed::try_parse_from(words).map(|typed| typed.args).map_err(|error| error.to_string())
    }

    fn of_file() -> Settings {
        Settings {
            width: 64,
            height: 32,
            overscan: 6,
            crop: None,
            samples: 3,
            refinement: None,
            filter: Filter::Mitchell,
            filter_radius: Some(1.75),
            depth: 5,
            reflections: 4,
            paths: 3,
            paths_per_frame: 2,
            budget: Budget::Rays(5),
            bounces: 1,
            caustics: Caustics::None,
            clamp: Some(9.0),
            occlusion_rays: 8,
            occlusion_radius: 3.0,
            tree_memory: 5,
            stereo: None,
            shutter: None,
            exposures: 9,
            mode: Mode::Auto,
            reuse: Reuse::Paper,
            base_every: 7,
            base_place: BasePlace::First,
            layers: Layers::ALL,
            background: Backdrop::Visible,
            audit: false,
            build: Build::Best,
        }
    }

    #[test]
    fn the_file_holds_where_the_command_line_is_silent() {
        let args = typed("a.toml").expect("fine");
        assert_eq!(args.settled(&of_file()), Ok(of_file()));
    }

    #[test]
    fn the_command_line_beats_the_file() {
        let line = "a.toml --size 8x4 --crop 9x3-2+1 --overscan 2 --samples 2 --filter tent --filter-radius 1.25 --depth 1 --reflections 9 --paths 16 --caustics paths --clamp 2.5 --paths-per-frame 4 --budget full --occlusion-rays 32 --occlusion-radius 0.25 --tree-memory 0 --reuse target --base-every 0 --base-place middle --layers Z --background transparent --audit";
        let settled = typed(line).expect("fine").settled(&of_file()).expect("fine");
        let expected = Settings {
            width: 8,
            height: 4,
            overscan: 2,
            crop: Some(PixelRect { x: -2, y: 1, width: 9, height: 3 }),
            samples: 2,
            refinement: None,
            filter: Filter::Tent,
            filter_radius: Some(1.25),
            depth: 1,
            reflections: 9,
            paths: 16,
            paths_per_frame: 4,
            budget: Budget::Full,
            bounces: 1,
            caustics: Caustics::Paths,
            clamp: Some(2.5),
            occlusion_rays: 32,
            occlusion_radius: 0.25,
            tree_memory: 0,
            stereo: None,
            shutter: None,
            exposures: 9,
            mode: Mode::Auto,
            reuse: Reuse::Target,
            base_every: 0,
            base_place: BasePlace::Middle,
            layers: Layers::Z,
            background: Backdrop::Transparent,
            audit: true,
            build: Build::Best,
        };
        assert_eq!(settled, expected);
    }

    #[test]
    fn what_makes_no_sense_is_refused_with_a_way_out() {
        for (options, word) in [
            ("--size 0x4", "1280x720"),
            ("--size 4", "1280x720"),
            ("--size 4x70000", "65535"),
            ("--crop 9x3", "320x180+640+400"),
            ("--crop 9x3+0,0", "320x180+640+400"),
            ("--overscan -1", "unexpected"),
            ("--overscan 99999", "0..=16384"),
            ("--samples 0", "1..=16"),
            ("--samples 1-17", "1..=16"),
            ("--samples -4", "unexpected"),
            ("--samples 1-", "1..=16"),
            ("--threshold 0", "above 0"),
            ("--threshold 1", "above 0"),
            ("--threshold nan", "above 0"),
            ("--depth 65", "0..=64"),
            ("--threads 0", "1 to 4096"),
            ("--frames 9-1", "backwards"),
            ("--frames 1-x", "frames"),
            ("--backend cuda", "embree"),
            ("--progress loud", "plain"),
            ("--layers far", "there are diffuse"),
            ("--occlusion-rays 0", "1..=256"),
            ("--occlusion-rays 257", "1..=256"),
            ("--occlusion-radius 0", "above 0"),
            ("--occlusion-radius=-1", "above 0"),
            ("--occlusion-radius nan", "above 0"),
            ("--occlusion-radius inf", "above 0"),
            ("--exposure bright", "-20 to 20 stops"),
            ("--exposure -21", "-20 to 20 stops"),
            ("--exposure nan", "-20 to 20 stops"),
            ("--view aces", "agx"),
        ] {
            let error = typed(&format!("a.toml {options}")).expect_err(options);
            assert!(error.contains(word), "{options}: {error}");
        }
    }

    #[test]
    fn adaptive_samples_are_settled_with_the_shot() {
        let of_shot = Refinement { most: 8, threshold: 0.3 };
        let adaptive = Settings { samples: 2, refinement: Some(of_shot), filter: Filter::Box, ..of_file() };
        let adaptive = Settings { filter_radius: None, ..adaptive };
        let settled = |line: &str| typed(&format!("a.toml {line}")).expect("fine").settled(&adaptive);
        let samples = |line: &str| settled(line).map(|settings| (settings.samples, settings.refinement));
        assert_eq!(samples(""), Ok((2, Some(of_shot))));
        assert_eq!(samples("--samples 1-4"), Ok((1, Some(Refinement { most: 4, ..of_shot }))));
        assert_eq!(samples("--threshold 0.5"), Ok((2, Some(Refinement { threshold: 0.5, ..of_shot }))));
        assert_eq!(samples("--samples 4"), Ok((4, None)));
        let wrong = [
            ("--samples 1-3", "doubled"),
            ("--filter tent", "filter `box`"),
            ("--samples 4 --threshold 0.1", "MIN-MAX"),
        ];
        for (line, word) in wrong {
            let error = settled(line).expect_err(line);
            assert!(matches!(&error, Failure::Usage(text) if text.contains(word)), "{line}: {error:?}");
        }
    }

    #[test]
    fn pixels_that_are_not_there_are_refused_with_the_size() {
        for (options, words) in [
            ("--crop 0x4+0+0", ["0x4+0+0", "64x32"]),
            ("--overscan 0 --crop 9x4-1+0", ["9x4-1+0", "picture is 64x32"]),
            ("--crop 9x4-7+0", ["64x32", "76x44-6-6"]),
            ("--size 20x10 --overscan 0 --crop 5x5+16+0", ["5x5+16+0", "20x10"]),
            ("--crop 4294967295x1+0+0", ["4294967295x1", "64x32"]),
            ("--size 65535x1 --overscan 1", ["65535", "--overscan"]),
        ] {
            let settled = typed(&format!("a.toml {options}")).expect(options).settled(&of_file());
            let error = settled.expect_err(options).to_string();
            assert!(words.iter().all(|word| error.contains(word)), "{options}: {error}");
        }
    }

    #[test]
    fn a_frame_that_no_memory_holds_is_refused() {
        let args = typed("a.toml --size 65535x65535 --samples 16").expect("each is fine by itself");
        assert!(args.settled(&of_file()).is_err_and(|error| error.to_string().contains("--size")));
    }

    #[test]
    fn frames_may_be_negative() {
        let frames = typed("a.toml --frames -2-1").expect("fine").frames.expect("given");
        assert_eq!(frames.list(), [-2, -1, 0, 1]);
    }

    #[test]
    fn how_to_build_follows_from_the_shot() {
        let mut one = open(Path::new("scenes/analytic/triangle.obj"), true, &turntable::Options::default())
            .expect("a scene of the repository");
        // without its floor, and with a ray to each light
        one.scene.models.truncate(1);
        one.scene.lights.iter_mut().for_each(|light| light.samples = 1);
        let of = |model: &Model| {
            let scene = Scene { models: vec![model.clone(); 10], ..one.scene.clone() };
            Shot { scene, ..one.clone() }
        };
        let model = &one.scene.models[0];
        let scale = Track::through(vec![(1.0, DVec3::ONE), (2.0, DVec3::ZERO)], Interpolation::Linear);
        let track = TransformTrack { scale: scale.expect("good keys"), ..TransformTrack::identity() };
        let (still, moving) = (of(model), of(&Model { track, ..model.clone() }));
        assert_eq!(
            [one.triangles(), still.triangles(), moving.triangles()],
            [1, 10, 1],
            "built once to move"
        );
        let tiny = Settings { width: 1, height: 1, samples: 1, ..one.settings.clone() };
        assert_eq!(one.rays(&tiny), Some(360), "120 frames; from the eye, and to two lights");

        let build = |options: &str, shot: &Shot| {
            let args = typed(&format!("a.obj --size 1x1 --samples 1 {options}")).expect("fine");
            args.build.for_shot(shot, &args.settled(&shot.settings).expect("fine"))
        };
        assert_eq!(build("", &one), Build::Best);
        assert_eq!(build("--build quick", &one), Build::Quick);
        assert_eq!(build("", &still), Build::Quick, "36 rays a triangle");
        assert_eq!(build("--build best", &still), Build::Best);
        assert_eq!(build("--frames 1-9999", &still), Build::Quick, "whatever frames are asked for");
        assert_eq!(build("", &Shot { says_frames: false, ..still }), Build::Best, "nobody knows how many");
        assert_eq!(build("", &moving), Build::Best);
    }

    #[test]
    fn backends_have_names() {
        assert_eq!(typed("a.toml").expect("fine").backend, None);
        let rust = typed("a.toml --backend rust").expect("known").backend;
        assert_eq!(rust.map(|kind| BackendKind::from(kind).name()), Some("rust"));
    }

    #[test]
    fn default_names_come_from_the_shot() {
        assert_eq!(default_output(Path::new("scenes/city.toml")), "out/city/city.####.exr");
        assert_eq!(default_output(Path::new("a#1.obj")), "out/a_1/a_1.####.exr");
    }
}

//! A shot, made from a shot file (`.toml`) and all files that it names.

mod camera;
mod clipping;
mod curves;
mod environment;
mod extents;
mod floor;
mod hair;
mod lens;
mod light;
mod links;
mod material;
mod medium;
mod mist;
mod model;
mod models;
mod orbit;
mod overrides;
mod places;
mod quadric;
mod readers;
mod settings;
mod shapes;
mod stage;
mod tracks;
mod vdb;

use std::path::PathBuf;

use glam::Vec3;
use readers::Readers;
pub(crate) use readers::{Beside, ReadBefore};

use crate::digest::Digest;
use crate::scene::dicing::{self, Views};
use crate::scene::frames::Run;
use crate::scene::import::{Import, Imported, Surfaces};
use crate::scene::keys::toml_text::{At, TomlText};
use crate::scene::keys::values::{look, optional_color};
use crate::scene::keys::{BackgroundTable, FileTables, FloorTable, ModelTable, ShotFile};
use crate::scene::model::copies::SharedMeshes;
use crate::scene::model::trim::trimmed;
use crate::scene::render_space::{Extent, RenderSpace};
use crate::scene::warnings::{darkness, media};
use crate::scene::{Background, Frames, Light, Material, Model, Scene, SceneError, Warning};
use crate::settings::{Backdrop, DEFAULT_PATHS, DenoiseQuality, FileFormat, Look, RayEstimate, Settings};

/// A shot: everything in a shot file, and in the files that it names.
#[derive(Debug, Clone)]
pub struct Shot {
    /// Title, for people; the file's stem if the file gives none.
    pub title: String,
    /// Scene to render.
    pub scene: Scene,
    /// Settings to render it with.
    pub settings: Settings,
    /// Frames to render; the first alone if the file does not say.
    pub frames: Frames,
    /// True if the file says which frames to render.
    pub says_frames: bool,
    /// True if the camera's keys say `orbit`, and not `eye`.
    pub says_orbit: bool,
    /// Frame rate in frames per second, as numerator and denominator; both above 0.
    pub rate: (i32, u32),
    /// Output path, with `#` for the digits of the frame's number; relative to the working folder.
    pub output: Option<String>,
    /// Format of the frames' files.
    pub format: FileFormat,
    /// Exposure and view transform of pictures for screens.
    pub look: Look,
    /// True if files hold a denoised picture as well.
    pub denoise: bool,
    /// Quality of the denoised picture.
    pub denoise_quality: DenoiseQuality,
    /// Warnings about the picture.
    pub warnings: Vec<Warning>,
    /// Decisions that were made for the user, in whole sentences.
    pub notes: Vec<String>,
    /// Paths of the shot file and of all files that were read for it.
    pub files: Vec<PathBuf>,
    /// Digests of the shot's content.
    pub content: Content,
}

/// Digests of a shot's content: equal for shots that show the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Content {
    /// Digest of the shot file's statements, in whatever layout, without its title and the tables of
    /// settings: `[render]`, `[indirect]`, `[occlusion]` and `[output]`.
    pub shot: Digest,
    /// Digest of the files that it names, and of those that these name.
    pub inputs: Digest,
}

impl Shot {
    /// Estimates the rays of all its frames with `settings` if each sample is traced once. (Reused samples need
    /// none.) `None` if the shot does not say which frames it has.
    pub fn rays(&self, settings: &Settings) -> Option<RayEstimate> {
        if !self.says_frames {
            return None;
        }
        let frames: u64 = self.frames.runs().iter().map(Run::count).sum();
        Some(self.rays_of_sample(settings).times(frames.saturating_mul(settings.samples_a_frame())))
    }

    /// Estimates the rays of a sample that is traced: one from the camera and those to each light; those along
    /// its first paths, and from the surfaces on these to lights. It counts too many, because many paths escape;
    /// mirrors, glass and openness come on top.
    pub fn rays_of_sample(&self, settings: &Settings) -> RayEstimate {
        let points = |light: &Light| light.points() as u64;
        let is_rough = settings.depth > 0 && self.scene.materials.iter().any(Material::is_rough);
        let reflected = if is_rough { settings.reflections } else { 0 };
        let paths = u64::from(settings.first_paths()) + u64::from(reflected);
        RayEstimate {
            coherent: 1 + self.scene.lights.iter().map(points).sum::<u64>(),
            scattered: paths * (2 * u64::from(settings.bounces) + 1),
        }
    }

    /// Number of triangles and other primitives that are built for it: those of a mesh that moves at several places count once.
    pub fn triangles(&self) -> u64 {
        self.scene.built().map(|mesh| mesh.count() as u64).sum()
    }
}

/// Reads the shot file `text`, with all files that it names. `most_added`: see [`SharedMeshes::among`].
///
/// # Errors With line and column: values that make no sense. In a `strict` load also anything that a stand-in
/// would replace.
pub fn from_text(text: TomlText<'_>, strict: bool, most_added: u64) -> Result<Shot, SceneError> {
    from_text_with(text, strict, Beside::default(), most_added)
}

/// Reads a shot like [`from_text`].
pub fn from_text_with(
    text: TomlText<'_>,
    strict: bool,
    beside: Beside,
    most_added: u64,
) -> Result<Shot, SceneError> {
    let mut file: ShotFile = text.read()?;
    let Beside { read, tables } = beside;
    let said = said(text, &tables)?;
    tables.add_to(&mut file);
    let ShotFile { render, indirect, occlusion, output, .. } = &file;
    let lights_state_rays = file.light.iter().any(|light| light.get_ref().samples.is_some());
    let tables = settings::Tables { render, indirect, occlusion, output, lights_state_rays };
    let mut settings = settings::settings(text, &tables, &Settings::default())?;
    let frames = settings::frames(text, render)?.unwrap_or(Frames::between(1, 1));
    let rate = settings::rate(text, render)?.unwrap_or((24, 1));
    let is_gathered =
        file.environment.is_some() || settings.wanted.is_some() && file.indirect.bounces.is_some();
    if is_gathered && file.indirect.paths.is_none() {
        // without any the environment would light nothing
        settings.paths = DEFAULT_PATHS;
    }
    let missing = |what| SceneError::new(text.path, what);
    let camera = file.camera.as_ref().ok_or_else(|| {
        missing("there is no [camera]: write one [[camera.key]] with frame, eye and target at least")
    })?;
    let says_orbit = camera.get_ref().key.iter().any(|key| key.get_ref().orbit.is_some());
    let overrides =
        file.material.iter().map(|table| material::replacement(text, table)).collect::<Result<_, _>>()?;
    let mut import = Import::new(strict, overrides);
    if let Some(bytes) = settings::texture_memory(text, render)? {
        import.pictures.set_memory(bytes);
    }
    let readers = Readers::new(import, file.mtl.kd_beside_map_kd);
    let mut readers = match read {
        Some(file) => readers.with(file),
        None => readers,
    };
    let marked = settings::marked_cuts(text, &file.render)?;
    let camera = camera::of_table(text, camera, &marked, (&mut readers, frames_a_second(rate)))?;
    settings.stereo = file.stereo.as_ref().map(|table| lens::stereo(text, table, &camera)).transpose()?;
    settings.shutter = file.shutter.as_ref().map(|table| lens::shutter(text, table)).transpose()?;
    readers.gltf.is_shutter_open = settings.shutter.is_some();
    let lights = file.light.iter().zip(1..).map(|(light, i)| light::of_table(text, light, i));
    let lights: Vec<Light> = lights.collect::<Result<_, _>>()?;
    light::check_groups(text, &file.light, &lights)?;
    let background = file.background.as_ref().map(|table| gradient(text, table)).transpose()?;
    let environment = file.environment.as_ref();
    let environment =
        environment.map(|table| environment::of_table(text, table, background.as_ref())).transpose()?;
    let is_seen = background.is_some() || environment.as_ref().is_some_and(|read| read.environment.visible);
    // a black picture that nobody asked for would show nothing
    let of_none = if is_seen { Backdrop::Visible } else { Backdrop::Transparent };
    settings.background = file.output.background.unwrap_or(of_none);
    let background = background.unwrap_or(Background::uniform(Vec3::ZERO));
    let only_lights = render.only_lights.clone();
    let world_group = file.environment.as_ref().and_then(|table| table.get_ref().light_group.as_ref());
    let world_group = world_group.map(|group| links::group_name(text, "light_group", group)).transpose()?;
    let mist = mist::of_table(text, file.mist.as_ref())?;
    let ambient = optional_color(text, "color", &file.ambient.color)?.unwrap_or(Vec3::ZERO);
    if file.model.is_empty() {
        return Err(missing(
            "there is nothing to see: write one [[model]] with the path of its obj, gltf or usd, at least",
        ));
    }
    // for each model its table: of a glTF or USD file there may be many models
    let (mut tables, mut models) = (Vec::new(), Vec::new());
    for table in &file.model {
        models.extend(models::of_table(text, table, &mut readers, frames_a_second(rate))?);
        tables.resize(models.len(), table);
    }
    links::check(text, (&file.light, &file.model), &models, file.floor.is_some())?;
    let dicing = settings::dicing(text, render)?;
    let times = match file.render.frames {
        Some(_) => frames.list().into_iter().map(f64::from).collect(),
        None => clipping::whole_frames(&camera, &models, frames.first()),
    };
    let views = Views::new(&camera, &times, [settings.width, settings.height]);
    let diced = dicing::diced(models, &mut readers.import, &views, &dicing)?;
    let models = diced.models;
    let bounds = extents::bounds_of_meshes(&models);
    let extent = extents::over_time(text, &tables, &models, &bounds)?;
    let at_first = extents::at_frame(&models, &bounds, frames.first());
    if file.occlusion.radius.is_none() {
        settings.occlusion_radius = settings::usual_occlusion_radius(&at_first);
    }
    let with_eye = extent.with_camera(&camera);
    let space = RenderSpace::fit_for(with_eye);
    let has_graphs = readers.import.surfaces.has_graphs();
    let models = models.into_iter().map(|model| {
        let map = model.track.map_at(frames.first().into());
        let to_world = has_graphs.then(|| map.as_affine3a()).filter(|map| map.is_finite());
        let model = Model { to_world, ..model };
        let model = quadric::spread(model, &with_eye, &space, frames.first());
        Model { track: space.track(model.track), ..model }
    });
    let models = trimmed(models.collect());
    let shared = SharedMeshes::among(&models, most_added);
    let models = tables.iter().zip(models).map(|(table, model)| settled(text, table, model, &shared));
    let mut models: Vec<Model> = models.collect::<Result<_, _>>()?;
    // they count for the size of the shot, so that nothing else changes when one is left out
    models.retain(|model| !model.track.visible.is_never());
    if let Some(table) = &file.floor {
        models.push(floor_model(text, table, &at_first, &mut readers.import.surfaces, &space)?);
    }
    let camera =
        clipping::without_idle(space.camera(camera), &models, &clipping::Picture::of(&settings, &space));
    let lights = lights.into_iter().map(|light| space.light(light)).collect();
    let mut import = readers.import;
    import.report_unused_overrides()?;
    if file.ambient.everywhere {
        import.surfaces.reflect_ambient_light_as_diffuse();
    } else if let Some(color) = file.ambient.color.filter(|_| ambient != Vec3::ZERO)
        && !import.surfaces.reflects_ambient_light()
    {
        let message = "the ambient light shows nowhere: Ka is 0 in all materials; `everywhere = true` in [ambient] makes it use their Kd";
        import.findings.note(text.fault(color.span(), message));
    }
    let Imported { materials, textures, mut findings, mut files, mut inputs } = import.finish();
    files.push(text.path.to_path_buf());
    let environment = environment.map(|read| {
        files.extend(read.file);
        inputs = Digest::of_all([inputs].into_iter().chain(read.digest));
        findings.warnings.extend(read.warning);
        read.environment
    });
    // samples of one level are none of another
    inputs = diced.digest.map_or(inputs, |levels| Digest::of_all([inputs, levels]));
    let stem = text.path.file_stem().unwrap_or_default().to_string_lossy();
    let fog = file.fog.as_ref().map(|table| medium::fog(text, table)).transpose()?;
    let mut scene = Scene {
        camera,
        models,
        materials,
        textures,
        lights,
        ambient,
        ambient_is_occluded: file.ambient.occluded,
        background,
        environment,
        world_group,
        mist,
        fog,
        space,
    };
    scene.hide_media();
    if let Some(only) = &only_lights {
        scene.check_light_group(only.get_ref()).map_err(|what| text.bad("only_lights", only, &what))?;
    }
    findings.warnings.extend(darkness::warning(text.path, &scene));
    findings.warnings.extend(media::warnings(text.path, &scene));
    Ok(Shot {
        title: file.title.unwrap_or_else(|| stem.into_owned()),
        scene,
        settings,
        frames,
        says_frames: file.render.frames.is_some(),
        says_orbit,
        rate,
        format: FileFormat {
            multipart: file.output.multipart.unwrap_or_default(),
            compression: file.output.compression.unwrap_or_default(),
        },
        look: look(text, &file.output, Look::default())?,
        denoise: file.output.denoise.unwrap_or_default(),
        denoise_quality: file.output.denoise_quality.unwrap_or_default(),
        output: settings::output(text, file.output.path)?,
        warnings: findings.warnings,
        notes: Vec::new(),
        files,
        content: Content { shot: said, inputs },
    })
}

/// Checks the tables of `text` as far as one can be checked without the others.
///
/// # Errors Those of [`from_text`].
pub fn check_tables(text: TomlText<'_>) -> Result<(), SceneError> {
    let file: ShotFile = text.read()?;
    file.material.iter().try_for_each(|table| material::replacement(text, table).map(drop))?;
    file.light.iter().zip(1..).try_for_each(|(light, i)| light::of_table(text, light, i).map(drop))
}

fn frames_a_second((frames, seconds): (i32, u32)) -> f64 {
    f64::from(frames) / f64::from(seconds)
}

/// Digest of the file's statements and of the tables `beside` it, without its title and settings.
fn said(text: TomlText<'_>, beside: &FileTables) -> Result<Digest, SceneError> {
    let mut tables: toml::Table = text.read()?;
    beside.add_to_statements(&mut tables);
    let cuts = tables.get("render").and_then(|render| render.get("cuts")).cloned();
    for settings in ["title", "render", "stereo", "shutter", "indirect", "occlusion", "output"] {
        tables.remove(settings);
    }
    // of the settings, these alone are a part of what happens
    tables.extend(cuts.map(|cuts| (String::from("cuts"), cuts)));
    // keys are in order
    Ok(Digest::new(tables.to_string().as_bytes()))
}

fn gradient(text: TomlText<'_>, table: &BackgroundTable) -> Result<Background, SceneError> {
    let zenith = optional_color(text, "zenith", &table.zenith)?;
    let horizon = optional_color(text, "horizon", &table.horizon)?;
    let ground = optional_color(text, "ground", &table.ground)?;
    if let Some(color) = &table.color {
        if [zenith, horizon, ground].iter().any(Option::is_some) {
            return Err(text.bad(
                "color",
                color,
                "and the gradient (zenith, horizon, ground) exclude each other",
            ));
        }
        return Ok(Background::uniform(text.color("color", color)?));
    }
    let horizon = horizon.or(zenith).unwrap_or(Vec3::ZERO);
    Ok(Background { zenith: zenith.unwrap_or(horizon), horizon, ground: ground.unwrap_or(horizon) })
}

/// Creates the floor in the space in which the shot is rendered; `extent`: of all models at the shot's first
/// frame.
fn floor_model(
    text: TomlText<'_>,
    table: &At<FloorTable>,
    extent: &Extent,
    surfaces: &mut Surfaces,
    space: &RenderSpace,
) -> Result<Model, SceneError> {
    let floor = floor::of_table(text, table.get_ref(), extent)?;
    let too = |what| text.fault(table.span(), what);
    let material = surfaces.add(floor.material()).ok_or_else(|| too("there are too many materials"))?;
    let model = floor.model(text.path, material);
    let model = Model { track: space.track(model.track), ..model };
    model.settled().ok_or_else(|| too("the floor is too far from the models, or too large"))
}

/// Settles a model that is in the render space already: bakes its mesh if it never moves, unless copies share
/// it.
fn settled(
    text: TomlText<'_>,
    table: &At<ModelTable>,
    model: Model,
    shared: &SharedMeshes,
) -> Result<Model, SceneError> {
    if shared.has(&model) {
        return Ok(model);
    }
    model.settled().ok_or_else(|| text.fault(model::place_of(table), "the model is too far from all others"))
}

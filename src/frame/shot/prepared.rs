//! A shot made ready: data that all of its frames read.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use glam::Vec3;
use rayon::prelude::*;

use super::exposed::lenders;
use super::frame_view::Occlusion;
use super::links::Links;
use super::proofs::FRAMES_AHEAD;
use crate::changes::{Direction, Motion};
use crate::clear::Obstacles;
use crate::cryptomatte::Mattes;
use crate::exposure::{Clock, Exposures};
use crate::frame::grid::Grid;
use crate::frame::planes::channels::{Channel, channels};
use crate::frame::planes::mixing::MixRule;
use crate::frame::watcher::{Stop, Watcher};
use crate::geometry::Bounds;
use crate::layers::Layers;
use crate::media::MediaOfShot;
use crate::pose::{CameraPose, Pose};
use crate::samples::TagLayout;
use crate::samples::saved::PictureName;
use crate::scene::{LightGroups, Material, Mesh, Model, Role, Scene};
use crate::settings::{Backdrop, Mode, Settings};
use crate::shade::bsdf::palette::Palette;
use crate::shade::deformed::Deformations;
use crate::shade::emitters::Emitters;
use crate::shade::light_chances::{LightChances, Source};
use crate::shade::sky::SkyLight;
use crate::shade::terminator::most_lift_at_rest;
use crate::stereo::EyePlace;

/// Data made of a scene and settings once, before the first frame.
pub struct Prepared<'s> {
    pub scene: &'s Scene,
    pub settings: Settings,
    pub sky: SkyLight,
    pub emitters: Emitters,
    /// Chances with which paths ask each of the shot's lights.
    pub light_chances: LightChances,
    /// Light links of the shot.
    pub links: Links,
    pub palette: Palette,
    /// Media of the scene.
    pub media: MediaOfShot,
    /// Layout of the store's tags.
    pub layout: TagLayout,
    pub occlusion: Option<Occlusion>,
    /// Mattes, if a layer shows any.
    pub mattes: Option<Mattes>,
    /// Attributes of layers for headers of files.
    pub about_layers: Arc<[(String, String)]>,
    /// Planes of the picture.
    pub channels: Vec<Channel>,
    /// The planes of exposures that are not the middle one.
    mixed_channels: Vec<Channel>,
    /// The grid of each level of samples, the coarsest first.
    pub grids: Vec<Arc<Grid>>,
    pub light_groups: LightGroups,
    /// Bounds of each model, object space.
    pub bounds: Vec<Bounds>,
    /// True for each model that is not made of triangles; empty if there is none.
    pub curved: Vec<bool>,
    /// See [`FrameView::lifts`](super::frame_view::FrameView::lifts).
    pub lifts: Vec<f32>,
    /// True if any model is hidden from some kinds of rays.
    pub hides_from_some: bool,
    /// What the eye sees of each model; empty if it sees all as themselves.
    pub roles: Vec<Role>,
    /// The models at rest, for proofs; built when they are needed first.
    pub obstacles: OnceLock<Obstacles>,
    /// Frames that regions of proofs look ahead.
    pub frames_ahead: i32,
    /// Shapes of the picture that was made last.
    shapes: Mutex<Deformations>,
    /// What random numbers follow from beside cells and cameras.
    pub salt: u32,
    /// True if rays follow mirrors or glass of the shot, or what media show is kept with theirs.
    pub has_trees: bool,
    /// The exposures of each frame: one where frames are sharp.
    pub exposures: Exposures,
    /// Motion of the whole shot, one for each clock of `exposures`. Empty ones until [`look_ahead`](Self::look_ahead) builds them, unless samples
    /// need them from the start.
    motions: Vec<Motion>,
    /// True once `motions` are built. They are built at once where samples keep paths or their openness from frame to frame.
    knows_motion: bool,
    /// Motions with time running backwards, once a frame was inferred so.
    motions_back: Option<Vec<Motion>>,
    /// Receiver of the frames' progress.
    pub watcher: Option<Watcher>,
    /// Request to stop.
    pub stop: Option<Stop>,
}

/// Motion of a shot, and the clocks of the exposures that see it.
pub struct KnownMotion {
    clocks: Vec<Clock>,
    motions: Vec<Motion>,
}

impl<'s> Prepared<'s> {
    /// Prepares frames of `scene`, each of which has these `exposures`, with `settings` that are [those of one
    /// picture](super::exposed::picture_settings).
    pub fn new(scene: &'s Scene, settings: &Settings, exposures: Exposures) -> Self {
        Self::with_motion(scene, settings, exposures, None)
    }

    /// [`new`](Self::new), for a scene whose motion is `known` already, if exposures have the same clocks.
    pub fn with_motion(
        scene: &'s Scene,
        settings: &Settings,
        exposures: Exposures,
        known: Option<KnownMotion>,
    ) -> Self {
        let known = known.filter(|known| known.clocks == exposures.clocks()).map(|known| known.motions);
        let layout = TagLayout::for_scene(scene, settings);
        let occlusion = occlusion(scene, settings, &layout);
        let has_answers = layout.paths > 0 || layout.reflections > 0 || occlusion.is_some();
        // frames that are all traced in full keep nothing: for how long an answer would hold is not asked
        let keeps_answers = has_answers && settings.mode != Mode::Full;
        let mattes = mattes(scene, settings);
        let mut about_layers =
            mattes.as_ref().map_or(Vec::new(), |mattes| mattes.attributes(settings.layers));
        about_layers.extend(settings.layers.has(Layers::MATERIAL).then(|| numbers_of_materials(scene)));
        let links = Links::new(scene, settings.only_lights.as_deref());
        let light_groups = LightGroups::new(&scene.lights);
        let media = MediaOfShot::of(scene);
        let bounds = bounds_of_models(scene);
        let channels: Vec<Channel> = channels(settings.layers, &light_groups).collect();
        let is_mixed = |channel: &&Channel| MixRule::new(channel) != MixRule::Middle;
        Self {
            scene,
            settings: settings.clone(),
            sky: SkyLight::new(scene).dark_if(links.is_world_dark),
            emitters: if layout.paths > 0 { Emitters::new(scene, &bounds) } else { Emitters::default() },
            light_chances: LightChances::new(&scene.lights.iter().map(Source::of_light).collect::<Vec<_>>()),
            palette: Palette::in_ambient(scene, if links.is_world_dark { Vec3::ZERO } else { scene.ambient }),
            links,
            has_trees: !media.are_none()
                || settings.depth > 0 && scene.materials.iter().any(Material::is_followed),
            media,
            knows_motion: keeps_answers || known.is_some(),
            motions: match known {
                Some(motions) => motions,
                None if keeps_answers => motions(scene, &exposures, Direction::Forward),
                None => vec![Motion::default(); exposures.clocks().len()],
            },
            mixed_channels: channels.iter().filter(is_mixed).cloned().collect(),
            grids: Grid::levels(settings, exposures.strata).map(Arc::new).collect(),
            exposures,
            motions_back: None,
            watcher: None,
            stop: None,
            layout,
            occlusion,
            mattes,
            about_layers: about_layers.into(),
            channels,
            light_groups,
            bounds,
            curved: of_models(scene, |model| model.mesh.is_curved()),
            lifts: lifts(scene),
            roles: of_models(scene, |model| model.ray_visibility.role),
            hides_from_some: scene.hides_from_some(),
            obstacles: OnceLock::new(),
            frames_ahead: FRAMES_AHEAD,
            salt: 0,
            shapes: Mutex::default(),
        }
    }

    /// What is known of the shot's motion.
    pub fn into_motion(self) -> Option<KnownMotion> {
        self.knows_motion
            .then(|| KnownMotion { clocks: self.exposures.clocks().to_vec(), motions: self.motions })
    }

    /// Number of exposures that [lend each other samples](lenders).
    pub fn lenders(&self) -> usize {
        lenders(&self.settings, &self.layout, self.exposures.all.len())
    }

    /// The planes of one of a frame's pictures: what cannot be mixed is in the middle one alone.
    pub fn channels_of(&self, picture: PictureName) -> &[Channel] {
        let is_middle = picture.exposure == self.exposures.middle();
        if is_middle { &self.channels } else { &self.mixed_channels }
    }

    /// The state of the shot in one of the pictures of `frame`; `place`: of its eye beside the camera, if there are two.
    pub fn pose(&self, frame: i32, picture: PictureName, place: Option<&EyePlace>) -> Pose {
        Pose::exposed(self.scene, frame, (&self.exposures, picture.exposure), place, self.size())
    }

    /// The camera of an exposure of `frame`, in its middle and at its ticks: see [`CameraPose::exposed`]. `place`: as of [`pose`](Self::pose).
    pub fn camera(
        &self,
        frame: i32,
        exposure: usize,
        place: Option<&EyePlace>,
    ) -> (CameraPose, Vec<CameraPose>) {
        CameraPose::exposed(&self.scene.camera, frame, (&self.exposures, exposure), place, self.size())
    }

    /// The camera in the middle of an exposure of `frame`; `place`: as of [`pose`](Self::pose).
    pub fn middle_camera(&self, frame: i32, exposure: usize, place: Option<&EyePlace>) -> CameraPose {
        let exposures = (&self.exposures, exposure);
        CameraPose::exposed_at(&self.scene.camera, (frame, None), exposures, place, self.size())
    }

    /// Pixels of the picture, and cells along the edge of each in the finest level.
    fn size(&self) -> ([u32; 2], u32) {
        let settings = &self.settings;
        ([settings.width, settings.height], settings.levels().last().unwrap_or(settings.samples))
    }

    /// The shapes of a picture. Those that it has in common with the one before are not made again.
    pub fn deformations(&self, pose: &Pose) -> Deformations {
        let mut shapes = self.shapes.lock().unwrap_or_else(PoisonError::into_inner);
        *shapes = Deformations::after(self.scene, &pose.models, true, &shapes);
        shapes.clone()
    }

    /// The models at rest, for proofs.
    pub fn obstacles(&self) -> &Obstacles {
        self.obstacles.get_or_init(|| Obstacles::new(self.scene))
    }

    /// Has [motions](Self::motion) know the shot, if ray trees are to be kept.
    pub fn look_ahead(&mut self) {
        if self.has_trees && !self.knows_motion {
            self.motions = motions(self.scene, &self.exposures, Direction::Forward);
            self.knows_motion = true;
        }
    }

    /// Builds [`motion_back`](Self::motion_back), if `motion` is built.
    pub fn look_back(&mut self) {
        if self.knows_motion {
            let motions = || motions(self.scene, &self.exposures, Direction::Backward);
            self.motions_back.get_or_insert_with(motions);
        }
    }

    /// Motion of the shot at the moments of an exposure.
    pub fn motion(&self, exposure: usize) -> &Motion {
        &self.motions[self.exposures.clock_of(exposure)]
    }

    /// Motion at the moments of an exposure with time running backwards, if it was [built](Self::look_back); else
    /// [`motion`](Self::motion).
    pub fn motion_back(&self, exposure: usize) -> &Motion {
        &self.motions_back.as_ref().unwrap_or(&self.motions)[self.exposures.clock_of(exposure)]
    }

    /// Returns true if the camera of an exposure, at `pose` in its frame, is in the same place in the frame before or the frame after.
    pub fn rests(&self, pose: &Pose, exposure: usize, place: Option<&EyePlace>) -> bool {
        Self::beside(pose).into_iter().any(|frame| self.is_there(frame, pose, exposure, place))
    }

    /// Returns true if the camera of an exposure, at `pose` in its frame, is in another place in the frame before or the frame after.
    pub fn moves(&self, pose: &Pose, exposure: usize, place: Option<&EyePlace>) -> bool {
        !Self::beside(pose).into_iter().all(|frame| self.is_there(frame, pose, exposure, place))
    }

    fn beside(pose: &Pose) -> [i32; 2] {
        [pose.frame.saturating_sub(1), pose.frame.saturating_add(1)]
    }

    fn is_there(&self, frame: i32, pose: &Pose, exposure: usize, place: Option<&EyePlace>) -> bool {
        let (camera, cameras) = self.camera(frame, exposure, place);
        camera == pose.camera && cameras == pose.cameras
    }
}

/// Motion of the shot at the moments of each clock of `exposures`. All of them together are as large as that of one may be.
fn motions(scene: &Scene, exposures: &Exposures, direction: Direction) -> Vec<Motion> {
    let clocks = exposures.clocks();
    clocks.par_iter().map(|clock| Motion::in_direction(scene, clock, direction, clocks.len())).collect()
}

/// A value for each model; an empty list if all have the default.
fn of_models<T: Default + PartialEq>(scene: &Scene, value: impl Fn(&Model) -> T) -> Vec<T> {
    let all: Vec<T> = scene.models.iter().map(value).collect();
    if all.iter().all(|value| *value == T::default()) { Vec::new() } else { all }
}

/// Upper bounds of the ways to the curved surfaces of all models. Each mesh is read once, however many models share it; where one
/// deforms, each of its shapes is asked, and here it only counts whether it is smooth.
fn lifts(scene: &Scene) -> Vec<f32> {
    let mut known: HashMap<*const Mesh, f32> = HashMap::new();
    let mut lift =
        |mesh: &Arc<Mesh>| *known.entry(Arc::as_ptr(mesh)).or_insert_with(|| most_lift_at_rest(mesh));
    let lifts: Vec<f32> = scene.models.iter().map(|model| lift(&model.mesh)).collect();
    let is_smooth = |model: &Model| model.mesh.as_triangles().is_some_and(|all| !all.normals.is_empty());
    let has_fibres = |model: &Model| model.mesh.as_curved().is_some_and(|curved| curved.most_radius() > 0.0);
    if scene.models.iter().any(|model| is_smooth(model) || has_fibres(model)) { lifts } else { Vec::new() }
}

/// Boxes around the meshes of all models. Each mesh is read once, however many models share it.
fn bounds_of_models(scene: &Scene) -> Vec<Bounds> {
    let mut known: HashMap<*const Mesh, Bounds> = HashMap::new();
    let mut bounds = |mesh: &Arc<Mesh>| *known.entry(Arc::as_ptr(mesh)).or_insert_with(|| Bounds::of(mesh));
    scene.models.iter().map(|model| bounds(&model.mesh)).collect()
}

/// Settings of ambient occlusion for samples of `scene`, if anything needs it.
fn occlusion(scene: &Scene, settings: &Settings, layout: &TagLayout) -> Option<Occlusion> {
    /// Longest ray: far beyond every shot in the space in which it is rendered, and far below overflow.
    const FARTHEST: f32 = 1e30;
    let radius = scene.space.length(settings.occlusion_radius).clamp(f32::MIN_POSITIVE, FARTHEST);
    let dims_ambient = scene.occludes_ambient();
    (layout.occlusion_rays > 0).then_some(Occlusion {
        rays: layout.occlusion_rays as u32,
        radius,
        dims_ambient,
    })
}

/// Names of the materials in the order of their numbers, for headers: JSON.
fn numbers_of_materials(scene: &Scene) -> (String, String) {
    let names = scene.materials.iter().map(|material| material.name.clone().into());
    (String::from("materials"), serde_json::Value::Array(names.collect()).to_string())
}

/// Mattes of `scene`, if a layer shows any.
fn mattes(scene: &Scene, settings: &Settings) -> Option<Mattes> {
    let shows_background = settings.background == Backdrop::Visible;
    settings.layers.has(Layers::CRYPTOMATTE).then(|| Mattes::new(scene, shows_background))
}

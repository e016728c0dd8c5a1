//! A bare OBJ becomes a shot: the camera goes once around it.

use std::f64::consts::TAU;
use std::path::Path;

use glam::{DVec3, Vec3};

use super::assemble::{Assembled, Assembly};
use super::camera::Aim;
use super::render_space::{Extent, RenderSpace};
use super::shot::{Content, Shot, usual_occlusion_radius};
use super::{Background, CameraTrack, Frames, Light, LightKind, Mesh, Model, Scene, SceneError, Warning};
use crate::animation::{Interpolation, Track, TransformTrack};
use crate::digest::Digest;
use crate::settings::{DenoiseQuality, FileFormat, Settings};

/// Frames of one turn.
const FRAMES: i32 = 120;
/// Vertical field of view, degrees.
const FOV: f64 = 40.0;
/// How far above the model the camera stands, degrees.
const ELEVATION: f64 = 18.0;
/// Distance beyond what the bounding sphere needs.
const MARGIN: f64 = 1.05;

/// The turntable of the OBJ file at `path`.
///
/// # Errors
/// Those of the OBJ and what belongs to it.
pub(crate) fn shot(path: &Path, strict: bool) -> Result<Shot, SceneError> {
    let mut assembly = Assembly::new(strict, Vec::new());
    let mesh = assembly.mesh(path)?;
    assembly.note_without_ambient(|nothing| {
        let remedy = "a shot file with `everywhere = true` in [ambient] makes it use their Kd";
        SceneError::new(path, format!("{nothing}; {remedy}"))
    });
    let Assembled { materials, textures, findings, files, inputs } = assembly.finish();
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let camera = around(&mesh);
    let track = TransformTrack::identity();
    let extent = Extent::NONE.with_model(mesh.bounds(), &track);
    let space = RenderSpace::fit_for(extent.with_camera(&camera));
    let camera = space.camera(camera);
    let model = Model { name: name.clone(), path: path.to_path_buf(), mesh, track: space.track(track) };
    let too_far = || SceneError::new(path, "the model reaches too far from the origin: move it there");
    let model = model.settled().ok_or_else(too_far)?;
    let scene = Scene {
        camera,
        models: vec![model],
        materials,
        textures,
        lights: vec![
            light("key", DVec3::new(-0.5, -1.0, -0.6), Vec3::new(1.0, 0.97, 0.92), 0.8),
            light("fill", DVec3::new(0.8, -0.35, 0.4), Vec3::new(0.85, 0.92, 1.0), 0.3),
        ],
        ambient: Vec3::splat(0.2),
        ambient_is_occluded: false,
        background: Background {
            zenith: Vec3::splat(0.12),
            horizon: Vec3::splat(0.35),
            ground: Vec3::splat(0.18),
        },
        environment: None,
        space,
    };
    Ok(Shot {
        title: name,
        scene,
        settings: Settings { occlusion_radius: usual_occlusion_radius(&extent), ..Settings::default() },
        frames: Frames::between(1, FRAMES),
        says_frames: true,
        rate: (24, 1),
        output: None,
        denoise: false,
        denoise_quality: DenoiseQuality::default(),
        format: FileFormat::default(),
        warnings: findings.warnings,
        files,
        // the version of the program says what a turntable is
        content: Content { shot: Digest::of(b"turntable"), inputs },
    })
}

fn light(name: &str, direction: DVec3, color: Vec3, power: f64) -> Light {
    Light {
        name: name.to_string(),
        kind: LightKind::Directional { direction: Track::constant(direction) },
        color: Track::constant(color),
        power: Track::constant(power),
        samples: Light::MOST_SAMPLES,
        group: None,
    }
}

/// A circle around the model, from which all of its bounding sphere is seen. A key a
/// frame: between fewer keys the distance would change.
fn around(mesh: &Mesh) -> CameraTrack {
    let fit = Fit::of(mesh);
    let eye = |frame: i32| {
        let turn = TAU * f64::from(frame - 1) / f64::from(FRAMES);
        (f64::from(frame), fit.eye(turn))
    };
    let eyes = (1..=FRAMES).map(eye).collect();
    CameraTrack {
        eye: Track::through(eyes, Interpolation::Linear).expect("one key a frame"),
        aim: Aim::Target { target: Track::constant(fit.center), roll: Track::constant(0.0) },
        fov: Track::constant(FOV),
        cuts: Vec::new(),
    }
}

/// Where a camera sees all of a model, in the space of its file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// Of the model's bounding box: what the camera looks at.
    pub center: DVec3,
    /// Of the sphere around that box.
    pub radius: f64,
    /// From the centre to the eye.
    pub distance: f64,
    /// Vertical field of view, degrees.
    pub fov: f64,
}

impl Fit {
    fn of(mesh: &Mesh) -> Self {
        let (low, high) = mesh.bounds();
        let (center, radius) = ((low + high) * 0.5, (high - low).length() * 0.5);
        Self { center, radius, distance: MARGIN * radius / (FOV * 0.5).to_radians().sin(), fov: FOV }
    }

    /// The eye, a little above the model, turned around it by so many radians; at 0 it is on the side of +Z.
    pub fn eye(&self, turn: f64) -> DVec3 {
        let (up, out) = ELEVATION.to_radians().sin_cos();
        let (sin, cos) = turn.sin_cos();
        self.center + self.distance * DVec3::new(sin * out, up, cos * out)
    }
}

/// What a shot of a model must know of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// Where the camera may be.
    pub fit: Fit,
    /// Whether some material reflects ambient light.
    pub has_ambient: bool,
    /// What the loader found odd.
    pub warnings: Vec<Warning>,
}

/// Looks at the model at `path`.
///
/// # Errors
/// Those of the OBJ and what belongs to it.
pub fn look(path: &Path) -> Result<Look, SceneError> {
    let mut assembly = Assembly::new(false, Vec::new());
    let mesh = assembly.mesh(path)?;
    let Assembled { materials, findings, .. } = assembly.finish();
    let has_ambient = materials.iter().any(|material| material.ambient != Vec3::ZERO);
    Ok(Look { fit: Fit::of(&mesh), has_ambient, warnings: findings.warnings })
}

//! The scene as plain data, and its loaders.
//!
//! Spaces: a mesh lives in its model's *object* space; a [`Model`]'s track takes it to *world* space. Units
//! are the OBJ's. Right-handed, Y up. Nothing here traces a ray or knows Embree.

pub(crate) mod cage;
pub mod camera;
pub mod cutout;
pub mod details;
pub(crate) mod dicing;
pub mod environment;
pub mod error;
pub mod frames;
pub mod geometry;
pub mod given;
pub(crate) mod import;
mod keys;
pub mod light;
pub mod links;
mod loader;
pub mod look;
pub mod material;
pub mod medium;
pub mod mesh;
pub mod mist;
mod model;
pub mod on_mesh;
mod paths;
pub mod ray_kinds;
pub mod render_space;
pub mod shapes;
pub mod shared_exponent;
pub(crate) mod shot;
pub mod surface;
pub mod texture;
pub mod turntable;
pub mod volume;
pub mod warnings;
pub mod written;

use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::Arc;

use glam::{Affine3A, Vec3};

pub use camera::CameraTrack;
pub use environment::{Environment, LightFrom, SkyDensity};
pub use error::{SceneError, Warning};
pub use frames::Frames;
pub use geometry::{Geometry, Triangles};
pub use import::{gltf, obj, ply, usd};
pub use keys::schema;
pub use light::{Light, LightGroups, LightKind, Panel, SpotFall};
pub use links::{BlockerSet, BlockerSets, LightLinks, Linked, ModelNames};
#[doc(hidden)]
pub use loader::load_sharing;
pub use loader::{load, load_turntable};
pub use material::Material;
pub use mesh::Mesh;
pub use mist::{Mist, MistFalloff};
pub use ray_kinds::{RayKind, RayKinds, RayVisibility, Role};
pub use render_space::RenderSpace;
pub use shapes::Shapes;
pub use shot::{Content, Shot};
use texture::Pager;
pub use texture::Texture;

use crate::animation::TransformTrack;
use crate::layers::Layers;

/// All that a shot shows. Ids are indices into these lists.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Camera and its motion.
    pub camera: CameraTrack,
    /// Models; each moves as a rigid whole.
    pub models: Vec<Model>,
    /// Materials of all models.
    pub materials: Vec<Material>,
    /// Textures of all materials, each file once.
    pub textures: Vec<Texture>,
    /// Lights in the order of the shot.
    pub lights: Vec<Light>,
    /// Ambient light, which reaches everything: multiplies a material's `ambient`.
    pub ambient: Vec3,
    /// True if ambient light is dimmed by ambient occlusion.
    pub ambient_is_occluded: bool,
    /// Radiance of rays that hit nothing.
    pub background: Background,
    /// Light from all around. If it is visible, the camera sees it instead of the background.
    pub environment: Option<Environment>,
    /// Name of the light group of the environment, the background and the ambient light.
    pub world_group: Option<String>,
    /// Distances of the layer of mist.
    pub mist: Mist,
    /// What fills everything, if anything does.
    pub fog: Option<medium::Medium>,
    /// Change of units and origin that the loader made to the files.
    pub space: RenderSpace,
}

/// A mesh at a place that may change with time.
#[derive(Debug, Clone)]
pub struct Model {
    /// Name in the shot, or the file's stem.
    pub name: String,
    /// File of the mesh, for messages.
    pub path: PathBuf,
    /// The mesh in object space. For most models that stand still this is world space; otherwise models of
    /// the same file share it.
    pub mesh: Arc<Mesh>,
    /// Transform from object to world space, per frame.
    pub track: TransformTrack,
    /// Map from object space, as its file has it, to the world of the shot's files at the first frame: what graphs see as the world. None
    /// where no graph asks.
    pub to_world: Option<Affine3A>,
    /// Number from 0 to 1 that graphs see of it, by which copies may differ.
    pub random: f32,
    /// Resolution of the reflection map in which its mirrors and glass look up their reflections, texels
    /// along an edge. None: they send rays.
    pub reflection_map: Option<u32>,
    /// What rays of each kind see of it.
    pub ray_visibility: RayVisibility,
    /// What links of lights know of it.
    pub linked: Linked,
}

impl Scene {
    /// Pager of the textures that are in pages, if there are some.
    pub fn pager(&self) -> Option<&Pager> {
        self.textures.iter().find_map(|texture| texture.image.pager()).map(Arc::as_ref)
    }

    /// Names of the light groups of lights, of what emits and of the world, and that of all that have none, each once.
    pub fn light_groups(&self) -> Vec<&str> {
        let of_lights = self.lights.iter().filter_map(|light| light.group.as_deref());
        let of_models = self.models.iter().filter_map(|model| model.linked.light_group.as_deref());
        let mut names: Vec<&str> = Vec::new();
        let all = of_lights.chain(of_models).chain(self.world_group.as_deref()).chain([LightGroups::OTHERS]);
        all.for_each(|name| {
            if !names.contains(&name) {
                names.push(name);
            }
        });
        names
    }

    /// Checks that there is a light group of this name.
    ///
    /// # Errors What there is instead.
    pub fn check_light_group(&self, name: &str) -> Result<(), String> {
        let known = self.light_groups();
        if known.contains(&name) {
            return Ok(());
        }
        Err(format!(
            "names no light group of the shot: there are `{}`; write one of these",
            known.join("`, `")
        ))
    }

    /// Returns true if any model is hidden from some kinds of rays.
    pub fn hides_from_some(&self) -> bool {
        self.models.iter().any(|model| model.ray_visibility.hidden_from != RayKinds::NONE)
    }

    /// Returns true if anything but clear air is anywhere.
    pub fn has_media(&self) -> bool {
        let of_materials = self.materials.iter().filter_map(|material| material.medium.as_ref());
        of_materials.chain(&self.fog).any(|medium| !medium.is_clear())
    }

    /// Has no ray meet those models that are media alone: all of their materials have no surface.
    pub fn hide_media(&mut self) {
        let Self { models, materials, .. } = self;
        if materials.iter().all(|material| material.has_surface) {
            return;
        }
        for model in models {
            let of = &model.mesh.material_of;
            if of.iter().all(|material| !materials[usize::from(*material)].has_surface) {
                model.ray_visibility = RayVisibility { hidden_from: RayKinds::ALL, ..model.ray_visibility };
            }
        }
    }

    /// Returns true if occlusion dims ambient light that any material reflects.
    pub fn occludes_ambient(&self) -> bool {
        self.ambient_is_occluded
            && self.ambient != Vec3::ZERO
            && self.materials.iter().any(|material| material.ambient != Vec3::ZERO)
    }

    /// Returns true if the openness of surfaces is needed: for one of these layers, or for the ambient light.
    pub fn asks_openness(&self, layers: Layers) -> bool {
        layers.has(Layers::OCCLUSION) || self.occludes_ambient()
    }

    /// Meshes that tracers build. A mesh that stands or moves at several places is built once, one that
    /// deforms for each model.
    pub fn built(&self) -> impl Iterator<Item = &Mesh> {
        let mut placed = HashSet::new();
        let is_own =
            |model: &Model| model.track.is_constant() && !model.is_placed_at_rest() || model.mesh.deforms();
        let models = self.models.iter();
        let built = models.filter(move |model| is_own(model) || placed.insert(Arc::as_ptr(&model.mesh)));
        built.map(|model| &*model.mesh)
    }
}

/// Radiance of the sky by direction; linear, scene-referred.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Background {
    /// Radiance straight up.
    pub zenith: Vec3,
    /// Radiance at the height of the eye, seen from above.
    pub horizon: Vec3,
    /// Radiance below the horizon.
    pub ground: Vec3,
}

impl Background {
    /// Creates a background of one colour all around.
    pub fn uniform(color: Vec3) -> Self {
        Self { zenith: color, horizon: color, ground: color }
    }

    /// Radiance from `direction` (world space, unit length).
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        if direction.y >= 0.0 {
            // a root keeps the bright band at the horizon narrow, as in a clear sky
            self.horizon.lerp(self.zenith, direction.y.min(1.0).sqrt())
        } else {
            // a short ramp instead of an edge: an edge would alias
            self.horizon.lerp(self.ground, (-direction.y * 20.0).min(1.0))
        }
    }
}

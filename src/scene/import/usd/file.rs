//! Content of a USD file as plain data, with Y up and in metres, by frame.

use std::collections::{BTreeSet, HashMap};
use std::path::PathBuf;
use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3, Vec2, Vec3};
use half::f16;

use super::choice::StageChoice;
use super::clock::Clock;
use super::render::RenderSettings;
use super::tiles::Tiles;
use crate::animation::{Track, Visibility};
use crate::digest::Digest;
use crate::scene::SceneError;
use crate::scene::cage::Cage;
use crate::scene::import::curves::CurveSet;
use crate::scene::import::mtlx::Document;
use crate::scene::texture::Mapping;

/// A USD file that was read, with all layers that it names.
#[derive(Debug)]
pub(crate) struct UsdFile {
    /// Path of the file.
    pub path: PathBuf,
    /// The file, and those of its other layers.
    pub files: Vec<PathBuf>,
    /// Digest of the layers' contents.
    pub digest: Digest,
    /// What of it was read.
    pub choice: StageChoice,
    /// All that it shows.
    pub content: Content,
}

/// Things that a file shows.
#[derive(Debug, Default)]
pub struct Content {
    pub clock: Clock,
    /// Distinct meshes.
    pub meshes: Vec<UsdMesh>,
    /// Distinct materials.
    pub surfaces: Vec<Surface>,
    pub shown: Vec<ShownMesh>,
    pub cameras: Vec<UsdCamera>,
    /// Lights that shine at some frame.
    pub lights: Vec<UsdLight>,
    /// True if there are lights, whether or not they shine.
    pub has_lights: bool,
    /// Path of the camera that is shown, if one is named: by a choice, or by the settings.
    pub camera: Option<String>,
    /// What the file says about its picture.
    pub render: Option<RenderSettings>,
    /// Variant sets that were met, and what they show, for people.
    pub variants: Vec<String>,
    /// What was decided of its payloads, if anything was.
    pub note: Option<String>,
    /// Defects for which something else is shown, in whole sentences.
    pub defects: BTreeSet<String>,
    /// Parts of the file that have no effect here, in whole sentences.
    pub unused: BTreeSet<String>,
}

/// Things about a file that its lights depend on.
#[derive(Debug, Clone, Copy)]
pub struct Units {
    /// Metres in a unit.
    pub metres: f64,
    /// True if Blender wrote it.
    pub is_of_blender: bool,
}

/// A mesh before its materials are looked up.
#[derive(Debug, Default, PartialEq)]
pub struct UsdMesh {
    /// Vertex positions, finite.
    pub positions: Vec<[f32; 3]>,
    /// Vertex normals, none at all or one a vertex: unit length, or zero.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, none at all or one a vertex; v = 0 at the bottom.
    pub uvs: Vec<Vec2>,
    /// Second set of texture coordinates, where a material takes two.
    pub second_uvs: Vec<Vec2>,
    /// Colours of the vertices, none at all or one a vertex; linear RGB.
    pub colors: Vec<[f16; 3]>,
    /// Vertices of the triangles. Each has an area, if the mesh does not deform.
    pub triangles: Vec<[u32; 3]>,
    /// Runs of consecutive triangles: their number, and that of their surface.
    pub uses: Vec<(usize, Option<usize>)>,
    /// Point of the file for each vertex.
    pub point_of: Vec<u32>,
    /// Frames, and all points at these, if the mesh deforms.
    pub shapes: Vec<(f64, Vec<[f32; 3]>)>,
    /// Cage that it stands for, if it is subdivided.
    pub cage: Option<Box<UsdCage>>,
    /// Curves in place of triangles, which may have shapes of their own, of the one surface that is used.
    pub curves: Option<CurveSet>,
    /// A volume in their place.
    pub volume: Option<UsdVolume>,
}

/// A cage before its materials are looked up.
#[derive(Debug, PartialEq)]
pub struct UsdCage {
    /// The cage, without materials.
    pub cage: Cage,
    /// Surface of each face.
    pub surface_of: Vec<Option<usize>>,
}

/// A mesh at its place.
#[derive(Debug, Clone)]
pub struct ShownMesh {
    /// Path of its prim, without the first slash.
    pub name: String,
    /// Index of the mesh.
    pub mesh: usize,
    /// Map from the mesh to the world. It may be flat at some frames.
    pub map: Track<DAffine3>,
    pub visible: Visibility,
}

/// A material (UsdPreviewSurface), or the colour of a mesh without one.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// Name of its prim.
    pub name: String,
    pub diffuse: Input,
    /// True if the colours of vertices tint it.
    pub is_tinted: bool,
    pub emissive: Input,
    pub roughness: Input,
    pub metallic: Input,
    pub opacity: Input,
    /// Opacity below which the surface is not there; 0: it is blended.
    pub opacity_threshold: f64,
    /// Index of refraction.
    pub ior: f64,
    /// Reflectance at normal incidence, in the specular workflow.
    pub specular: Option<DVec3>,
    /// Weight and roughness of the clear coat above it.
    pub coat: [f64; 2],
    /// Picture of its normals.
    pub normal: Option<Picture>,
    /// Lengths by which its vertices are moved along their normals, in the units of the file.
    pub displacement: Input,
    /// Network of MaterialX's nodes, which counts in place of all of that.
    pub network: Option<Arc<Network>>,
    /// True if the file has nothing beside the network.
    pub is_network_alone: bool,
}

/// A material of MaterialX.
#[derive(Debug, PartialEq)]
pub enum Network {
    /// Of prims: a document whose only material it is, and the pictures by the names that nodes have for them.
    Prims { document: Document, pictures: HashMap<String, Picture> },
    /// Of a file: the material with this name.
    File { path: PathBuf, name: String },
}

/// Value of a shader's input.
#[derive(Debug, Clone, PartialEq)]
pub enum Input {
    /// The same everywhere; numbers repeat in all three.
    Constant(DVec3),
    /// A picture.
    Picture(Picture),
}

/// A volume at one time.
#[derive(Debug, PartialEq)]
pub struct UsdVolume {
    /// Its file.
    pub path: PathBuf,
    /// Names of its grids in the file.
    pub grids: Vec<String>,
    /// Name of its material where it has none: that of the prim.
    pub name: String,
    /// Metres in a unit of the stage, for each of which it is as dense as it says.
    pub metres: f64,
}

/// A picture on a surface (UsdUVTexture).
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Path by which it is known, of a file or of a part of a package.
    pub path: PathBuf,
    /// Name as written.
    pub name: String,
    /// Bytes, if it is packed.
    pub packed: Option<Arc<Vec<u8>>>,
    /// Channel that counts, 0 to 3 for red to alpha; all of its colour without one.
    pub channel: Option<usize>,
    /// Factors on the four channels, and what is added to them then.
    pub scale: [f64; 4],
    pub bias: [f64; 4],
    /// True if its bytes are no colours, but numbers.
    pub is_raw: bool,
    /// From texture coordinates to places of the picture.
    pub mapping: Mapping,
    /// Its tiles, if it has some: the mapping is that of all of them.
    pub tiles: Option<Tiles>,
}

impl Picture {
    /// The whole picture, as it is.
    pub fn plain(path: PathBuf, name: String, packed: Option<Arc<Vec<u8>>>) -> Self {
        Self {
            path,
            name,
            packed,
            channel: None,
            scale: [1.0; 4],
            bias: [0.0; 4],
            is_raw: false,
            mapping: Mapping::default(),
            tiles: None,
        }
    }
}

/// A camera.
#[derive(Debug)]
pub struct UsdCamera {
    pub name: String,
    /// Path of its prim.
    pub path: String,
    pub is_orthographic: bool,
    /// Ratio of its width to its height.
    pub ratio: f64,
    /// Its keys, by frame; one if it rests.
    pub keys: Vec<LensKey>,
    /// Opening and closing of the shutter, frames.
    pub shutter: [f64; 2],
    /// Stops by which its exposure makes pictures brighter, at the first frame.
    pub stops: f64,
}

/// A camera at a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct LensKey {
    pub frame: f64,
    /// Map from the camera, which looks along -Z, to the world.
    pub map: DAffine3,
    /// Vertical field of view in degrees, or the height of what is seen in metres.
    pub fov_or_height: f64,
    /// Right and up, in the longer side of the picture.
    pub shift: DVec2,
    /// Radius of the lens and distance that is in focus, metres, if it is no pinhole.
    pub focus: Option<[f64; 2]>,
    /// Distances of the clipping planes, metres, if the file states any.
    pub planes: Option<[f64; 2]>,
}

/// A light.
#[derive(Debug)]
pub struct UsdLight {
    pub name: String,
    /// Path of its prim.
    pub path: String,
    /// Prims that it lights; `None` for all.
    pub light_link: Option<Link>,
    /// Prims that cast shadows in its light; `None` for all.
    pub shadow_link: Option<Link>,
    pub kind: UsdLightKind,
    /// Its keys, by frame; one if it rests.
    pub keys: Vec<LightKey>,
}

/// Prims of a collection.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Paths of prims.
    pub includes: Vec<String>,
    pub excludes: Vec<String>,
    /// True if all prims of the file are included.
    pub has_root: bool,
    /// True if prims below a path are not meant.
    pub is_exact: bool,
}

/// Kinds of lights; lengths in metres, angles in degrees.
#[derive(Debug, Clone, PartialEq)]
pub enum UsdLightKind {
    Rectangle {
        size: [f64; 2],
    },
    /// Its diameters.
    Disk {
        size: [f64; 2],
    },
    Sphere {
        radius: f64,
    },
    Point,
    /// `cone`: from its axis to its rim.
    Spot {
        cone: f64,
        soft: f64,
        /// 0 for a point.
        radius: f64,
    },
    Sun {
        angle: f64,
    },
    /// All around, with a picture or one colour.
    Dome {
        picture: Option<Picture>,
    },
}

/// A light at a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct LightKey {
    pub frame: f64,
    /// Map from the light, which shines along -Z, to the world.
    pub map: DAffine3,
    pub color: DVec3,
    /// Power as the renderer has it; of a dome its radiance.
    pub power: f64,
}

impl UsdFile {
    /// Creates an error about the file.
    pub fn fault(&self, message: impl Into<String>) -> SceneError {
        SceneError::new(&self.path, message)
    }
}

impl UsdMesh {
    /// Positions of the vertices at a frame.
    pub fn positions_at(&self, frame: f64) -> Vec<[f32; 3]> {
        let after = self.shapes.partition_point(|(key, _)| *key <= frame);
        match self.shapes.get(after.saturating_sub(1)) {
            Some((_, points)) => self.of_vertices(points),
            None => self.positions.clone(),
        }
    }

    /// Frames of its shapes, if it deforms.
    pub fn frames_of_shapes(&self) -> impl Iterator<Item = f64> + '_ {
        let of_curves = self.curves.iter().flat_map(|curves| curves.shapes.iter().map(|shape| shape.frame));
        self.shapes.iter().map(|(frame, _)| *frame).chain(of_curves)
    }

    /// Positions of the vertices where the points of the file are at these places.
    pub fn of_vertices(&self, points: &[[f32; 3]]) -> Vec<[f32; 3]> {
        self.point_of.iter().map(|point| points[*point as usize]).collect()
    }
}

impl Input {
    /// The same value everywhere.
    pub fn number(value: f64) -> Self {
        Self::Constant(DVec3::splat(value))
    }
}

//! `[[model]]` and its keys in a shot file, as they are written: see [`shot_file`](super).

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::value::SeqAccessDeserializer;
use serde::de::{self, Deserializer, SeqAccess, Visitor};

use super::curves::CurvesTable;
use super::links::NamesTable;
use super::places::PlacesTable;
use super::quadric::QuadricTable;
use super::shapes::ShapesTable;
use super::stage::StageTable;
use super::toml_text::{At, List, Three};
use super::vdb::VdbTable;
use crate::animation::Interpolation;
use crate::scene::RayKind;

/// Bounds of the resolution of a reflection map, texels along an edge.
pub(crate) const LEAST_MAP: u32 = 8;
pub(crate) const LARGEST_MAP: u32 = 1024;

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{"required": ["obj"]}, {"required": ["gltf"]}, {"required": ["usd"]}, {"required": ["ply"]}, {"required": ["quadric"]}, {"required": ["curves"]}, {"required": ["vdb"]}]))]
pub(crate) struct ModelTable {
    /// For people; the file's name, or the type of the quadric, without it
    pub name: Option<String>,
    /// OBJ file, relative to the shot file
    pub obj: Option<At<String>>,
    /// glTF file (.gltf or .glb), relative to the shot file, instead of an OBJ file: a model for each of its nodes with a mesh
    pub gltf: Option<At<String>>,
    /// USD file (.usda, .usdc or .usdz), relative to the shot file, instead of an OBJ file: a model for each of its meshes
    pub usd: Option<At<String>>,
    /// With `usd`: what of the file is read (all that it renders)
    pub stage: Option<At<StageTable>>,
    /// PLY file, relative to the shot file, instead of an OBJ file
    pub ply: Option<At<String>>,
    /// Name of the glTF file's animation (its first)
    pub animation: Option<At<String>>,
    /// With `obj`: name of an object (`o`) or group (`g`) of the file, which alone is the model
    pub group: Option<At<String>>,
    /// With `obj`: a model for each object (`o`) or each group (`g`) of the file
    pub split: Option<At<Division>>,
    /// Sphere, ellipsoid, cylinder, cone, paraboloid, hyperboloid or plane, instead of an OBJ file
    pub quadric: Option<At<QuadricTable>>,
    /// Curves with a thickness (hair, grass, wires), instead of an OBJ file
    pub curves: Option<At<CurvesTable>>,
    /// OpenVDB file, instead of an OBJ file: a medium that varies from place to place
    pub vdb: Option<At<VdbTable>>,
    /// Files of the shapes between which the model deforms; `obj` is its shape at rest
    pub shapes: Option<At<ShapesTable>>,
    /// With `obj`: its faces are a cage, which is subdivided by these rules until its edges are as long as `dicing` says. With `usd`: "none"
    /// shows cages as they are
    pub subdivision: Option<At<Subdivision>>,
    /// Applied last [0, 0, 0]
    pub translate: Option<Three>,
    /// Degrees about the fixed axes X, then Y, then Z; applied second [0, 0, 0]
    pub rotate: Option<Three>,
    /// One factor, or one for each axis; applied first, after the matrix (1)
    pub scale: Option<At<Scale>>,
    /// Rows of an affine map, for column vectors: 3 of 4 numbers, or 4 of which the last is [0, 0, 0, 1]; applied before all others
    #[schemars(length(min = 3, max = 4))]
    pub matrix: Option<Rows>,
    /// Mirrors and glass of the model look up what they show in a cube map of so many texels along each edge, instead of sending rays: an
    /// approximation (rays)
    #[schemars(range(min = LEAST_MAP, max = LARGEST_MAP))]
    pub reflection_map: Option<At<i64>>,
    /// Kinds of rays that do not meet the model ([]). A surface that is hidden from the camera still shines and casts shadows
    #[schemars(extend("uniqueItems" = true))]
    pub hidden_from: Option<At<Vec<At<RayKind>>>>,
    /// True: rays from the eye see a hole in the picture where the model is, without light or coverage; all other rays see the model (false)
    pub holdout: Option<bool>,
    /// True: rays from the eye see what is behind the picture where the model is, dimmed by the shadows on it (false)
    pub shadow_catcher: Option<At<bool>>,
    /// Names of groups that it is in, by which links of lights mean it ([])
    #[schemars(extend("uniqueItems" = true))]
    pub groups: Option<At<Vec<At<String>>>>,
    /// Light group of the light that it emits (others)
    pub light_group: Option<At<String>>,
    /// Models that the light that it emits lights (all)
    pub light_link: Option<At<NamesTable>>,
    /// Models that cast shadows in the light that it emits (all)
    pub shadow_link: Option<At<NamesTable>>,
    /// File of the places of many copies of the model, instead of `matrix` and keys
    pub places: Option<At<PlacesTable>>,
    /// Number from 0 to 1 that graphs of its materials see, by which models of one mesh may differ (0)
    #[schemars(range(min = 0, max = 1))]
    pub random: Option<At<f64>>,
    /// True if the model is there, before the first key that says it (true)
    pub visible: Option<bool>,
    /// Between keys
    #[serde(default)]
    pub interpolation: Interpolation,
    /// Keys of the model: its place at some frames
    #[serde(default)]
    pub key: Vec<At<ModelKey>>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ModelKey {
    /// Number of the frame; may be fractional
    pub frame: At<f64>,
    /// As of the model, at this frame
    pub translate: Option<Three>,
    /// As of the model, at this frame
    pub rotate: Option<Three>,
    /// As of the model, at this frame
    pub scale: Option<At<Scale>>,
    /// As of the model, at this frame
    #[schemars(length(min = 3, max = 4))]
    pub matrix: Option<Rows>,
    /// True if the model is there, from this frame on; a key that says nothing else says nothing of its place
    pub visible: Option<bool>,
}

/// Names in an OBJ file by which it is divided into models.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Division {
    /// A model for each object (`o`)
    Objects,
    /// A model for each group: the last `g` or `o` before a face
    Groups,
}

/// Rules by which a cage is subdivided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Subdivision {
    /// It is smooth, but at creases
    CatmullClark,
    /// The same of triangles alone
    Loop,
    /// Its faces are divided and stay where they are, for displacement
    Bilinear,
    /// It is not subdivided
    None,
}

/// One factor, or one an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale(pub [f64; 3]);

/// Rows of a matrix.
pub(crate) type Rows = At<Vec<List<f64, 4>>>;

impl<'de> Deserialize<'de> for Scale {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ScaleVisitor;
        impl<'de> Visitor<'de> for ScaleVisitor {
            type Value = Scale;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number or three")
            }
            fn visit_f64<E: de::Error>(self, factor: f64) -> Result<Scale, E> {
                Ok(Scale([factor; 3]))
            }
            fn visit_i64<E: de::Error>(self, factor: i64) -> Result<Scale, E> {
                Ok(Scale([factor as f64; 3]))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, factors: A) -> Result<Scale, A::Error> {
                List::deserialize(SeqAccessDeserializer::new(factors)).map(|List(factors)| Scale(factors))
            }
        }
        deserializer.deserialize_any(ScaleVisitor)
    }
}

impl JsonSchema for Scale {
    fn schema_name() -> Cow<'static, str> {
        "Scale".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let three = generator.subschema_for::<List<f64, 3>>();
        json_schema!({"anyOf": [{"type": "number"}, three]})
    }
}

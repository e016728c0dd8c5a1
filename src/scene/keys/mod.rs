//! The shot file as it is written: tables and keys, nothing checked but names and types. What stands above a key is what
//! editors show of it: see [`schema`].

pub mod camera;
mod camera_text;
pub mod curves;
mod file_tables;
pub mod hair;
mod light_text;
pub mod links;
pub mod material;
pub mod model;
pub mod places;
pub mod quadric;
pub mod samples;
pub mod shapes;
pub mod spelling;
pub mod stage;
mod table_text;
pub mod toml_text;
pub mod values;
pub mod vdb;

use std::borrow::Cow;
use std::fmt;

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{self, Deserializer, Visitor};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use self::camera::{CameraTable, ShutterTable, StereoTable};
pub(crate) use self::file_tables::FileTables;
use self::links::NamesTable;
use self::material::{MaterialTable, MtlTable};
pub(crate) use self::model::{LARGEST_MAP, LEAST_MAP, ModelKey, ModelTable, Rows, Scale};
use self::samples::SamplesValue;
pub(crate) use self::table_text::Digits;
use self::toml_text::{At, List, Three};
use crate::animation::Interpolation;
use crate::exposure::MOST_EXPOSURES;
use crate::layers::Layers;
use crate::scene::dicing::MOST_DICED;
use crate::scene::{MistFalloff, SpotFall};
use crate::settings::{
    Backdrop, BasePlace, Caustics, Compression, DenoiseQuality, Filter, LONGEST_SIDE, Look,
    MOST_OCCLUSION_RAYS, MOST_OVERSCAN, MOST_PATHS, MOST_REFLECTIONS, MOST_TREE_MEMORY, Mode, Reuse, View,
};

/// The JSON schema (draft 7) of shot files: names, types and ranges of all keys. Editors complete and check files by it.
pub fn schema() -> Value {
    let generator = SchemaSettings::draft07().into_generator();
    let mut schema = generator.into_root_schema_for::<ShotFile>().to_value();
    without_null(&mut schema);
    schema
}

/// Removes null from the schema: TOML has none, and a key that may be left out is simply not there.
fn without_null(schema: &mut Value) {
    match schema {
        Value::Object(object) => {
            if let Some(Value::Array(kinds)) = object.get_mut("type") {
                kinds.retain(|kind| kind != "null");
                if let [kind] = &kinds[..] {
                    let kind = kind.clone();
                    object.insert("type".into(), kind);
                }
            }
            if let Some(Value::Array(any)) = object.get_mut("anyOf") {
                any.retain(|one| *one != json!({"type": "null"}));
                // errors are then those of the one alternative that is left
                if any.len() == 1 {
                    let one = object.remove("anyOf").expect("it is there");
                    object.insert("allOf".into(), one);
                }
            }
            if object.get("default").is_some_and(Value::is_null) {
                object.remove("default");
            }
            object.values_mut().for_each(without_null);
        }
        Value::Array(list) => list.iter_mut().for_each(without_null),
        _ => {}
    }
}

/// A shot for Afterimage.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("required" = ["camera", "model"]))]
pub(crate) struct ShotFile {
    /// For people; the file's name without it
    pub title: Option<String>,
    /// Size, samples, frames, and how they are rendered
    #[serde(default)]
    pub render: RenderTable,
    /// Files to write, and their place
    #[serde(default)]
    pub output: OutputTable,
    /// Radiance of rays that hit nothing: a colour, or a gradient
    pub background: Option<BackgroundTable>,
    /// Light from all around: a map, a sky with its sun, or the background
    pub environment: Option<At<EnvironmentTable>>,
    /// What fills everything
    pub fog: Option<FogTable>,
    /// The camera and its keys
    pub camera: Option<At<CameraTable>>,
    /// Two eyes instead of one
    pub stereo: Option<At<StereoTable>>,
    /// Motion blur: when the shutter is open
    pub shutter: Option<At<ShutterTable>>,
    /// Each moves as a rigid whole
    #[serde(default)]
    #[schemars(length(min = 1))]
    pub model: Vec<At<ModelTable>>,
    /// A level floor under the models
    pub floor: Option<At<FloorTable>>,
    /// Distances of the layer `mist`
    pub mist: Option<At<MistTable>>,
    /// Light sources
    #[serde(default)]
    pub light: Vec<At<LightTable>>,
    /// Light that reaches everything
    #[serde(default)]
    pub ambient: AmbientTable,
    /// Light that reaches surfaces from the sky and from other surfaces
    #[serde(default)]
    pub indirect: IndirectTable,
    /// Ambient occlusion: openness of surfaces
    #[serde(default)]
    pub occlusion: OcclusionTable,
    /// Meaning of MTL statements
    #[serde(default)]
    pub mtl: MtlTable,
    /// Overrides of MTL materials
    #[serde(default)]
    pub material: Vec<MaterialTable>,
}

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RenderTable {
    /// Width and height in pixels [1280, 720]
    #[schemars(inner(range(min = 1, max = LONGEST_SIDE)))]
    pub size: Option<List<At<i64>, 2>>,
    /// Pixels around the picture, on each side, that are rendered as well (0)
    #[schemars(range(min = 0, max = MOST_OVERSCAN))]
    pub overscan: Option<At<i64>>,
    /// N, for N x N samples a pixel, or a table of the fewest and the most (2)
    pub samples: Option<At<SamplesValue>>,
    /// Noise that a frame may have, before any denoiser, relative to its mean, such as 0.03: counts that are not stated (`samples`,
    /// `paths`, `reflections`, `samples` of lights) follow from it
    #[schemars(range(min = 0.001, max = 0.9))]
    pub error: Option<At<f64>>,
    /// With a shutter or a lens: the most exposures among which the samples of a pixel are divided (4)
    #[schemars(range(min = 1, max = MOST_EXPOSURES))]
    pub exposures: Option<At<i64>>,
    /// "1-100", "1-100x2" (every second frame), "1-10,150" ("1")
    pub frames: Option<At<String>>,
    /// Frames per second, such as 24 or "24000/1001" (24)
    pub rate: Option<At<Rate>>,
    /// Pixel filter
    #[schemars(extend("default" = "box"))]
    pub filter: Option<Filter>,
    /// Radius of the filter, pixels (tent 1, gaussian and blackman-harris 1.5, mitchell 2, lanczos 3)
    #[schemars(range(min = 0.5, max = 4))]
    pub filter_radius: Option<At<f64>>,
    /// Places along each ray from the eye at which media scatter light (1)
    #[schemars(range(min = 1, max = 64))]
    pub volume_samples: Option<At<i64>>,
    /// Maximum number of mirror reflections and refractions along a camera path (4)
    #[schemars(range(min = 0, max = 64))]
    pub depth: Option<At<i64>>,
    /// Maximum number of rays by which each sample of a rough metal-rough surface reflects the scene (4)
    #[schemars(range(min = 0, max = MOST_REFLECTIONS))]
    pub reflections: Option<At<i64>>,
    /// Light by way of clear glass: "none" lets lights shine through as if it were not there, "paths" has paths find it
    #[schemars(extend("default" = "none"))]
    pub caustics: Option<Caustics>,
    /// Limit of the indirect radiance that a ray beyond the first surface, or a path, may bring: above 0 (no
    /// limit)
    #[schemars(range(min = 0))]
    pub clamp: Option<At<f64>>,
    /// Light group whose contribution alone is rendered (all)
    pub only_lights: Option<At<String>>,
    /// Memory for what mirrors and glass show while the camera rests, MiB; 0: none (256)
    #[schemars(range(min = 0, max = MOST_TREE_MEMORY))]
    pub tree_memory: Option<At<i64>>,
    /// Memory for textures, MiB: what is more is in a file, in pages (1024)
    #[schemars(range(min = 0, max = MOST_TREE_MEMORY))]
    pub texture_memory: Option<At<i64>>,
    /// Length in pixels of the edges of what is diced: subdivided or displaced (1). Longer ones stay where the surface is as flat
    #[schemars(range(min = 0.05, max = 1000))]
    pub dicing: Option<At<f64>>,
    /// Maximum number of triangles into which a mesh is diced (4000000)
    #[schemars(range(min = 1, max = MOST_DICED))]
    pub dicing_triangles: Option<At<i64>>,
    /// Distance between base frames, which are traced in full; 0: only the first (48)
    #[schemars(range(min = 0, max = 1_000_000))]
    pub base_every: Option<At<i64>>,
    /// Which of so many frames is the base frame: those before it are inferred backwards in time
    #[schemars(extend("default" = "first"))]
    pub base_place: Option<BasePlace>,
    /// Frames at which a new take begins: the first frame of each
    pub cuts: Option<Vec<At<i64>>>,
    /// When samples are reused
    #[schemars(extend("default" = "auto"))]
    pub mode: Option<Mode>,
    /// Which samples are kept
    #[schemars(extend("default" = "target"))]
    pub reuse: Option<Reuse>,
}

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct IndirectTable {
    /// Paths of each sample; 0: no indirect light (0; 16 with an environment)
    #[schemars(range(min = 0, max = MOST_PATHS))]
    pub paths: Option<At<i64>>,
    /// Maximum number of surfaces that a path meets (2)
    #[schemars(range(min = 0, max = 64))]
    pub bounces: Option<At<i64>>,
    /// Maximum number of times that a path is scattered in media, beside the first that the eye sees (4)
    #[schemars(range(min = 0, max = 64))]
    pub volume_bounces: Option<At<i64>>,
    /// Budget for the paths of each frame: "full", or a number of rays
    pub budget: Option<At<BudgetValue>>,
    /// With a budget: paths that a new sample gets at once (16)
    #[schemars(range(min = 1, max = MOST_PATHS))]
    pub paths_per_frame: Option<At<i64>>,
}

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct OcclusionTable {
    /// Distance within which surfaces occlude (a tenth of the diagonal of all models at the first frame)
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius: Option<At<f64>>,
    /// Rays of each sample (16)
    #[schemars(range(min = 1, max = MOST_OCCLUSION_RAYS))]
    pub rays: Option<At<i64>>,
}

/// `"full"`, or a number of rays.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged, expecting = "it must be `full`, or a number of rays a frame")]
pub(crate) enum BudgetValue {
    Rays(u64),
    Text(String),
}

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct OutputTable {
    /// File names such as "out/walk.####.exr", or a folder, relative to the current folder
    pub path: Option<At<String>>,
    /// Layers beside R G B A, or sets of them (Z, object, status)
    #[schemars(with = "Option<Vec<LayerName>>")]
    pub layers: Option<Vec<At<String>>>,
    /// Treatment of the background where the camera sees it (visible if there is one)
    pub background: Option<Backdrop>,
    /// Write each layer as a part of its own
    #[schemars(extend("default" = false))]
    pub multipart: Option<bool>,
    /// Lossless compression
    #[schemars(extend("default" = "zips"))]
    pub compression: Option<Compression>,
    /// Stops by which previews, contact sheets and movies are brighter; EXR files stay as they are (0)
    #[schemars(range(min = -Look::MOST_EXPOSURE, max = Look::MOST_EXPOSURE))]
    pub exposure: Option<At<f64>>,
    /// View transform of previews, contact sheets and movies; EXR files stay as they are
    #[schemars(extend("default" = "standard"))]
    pub view: Option<View>,
    /// Also write a denoised picture, as the layer `denoised`
    #[schemars(extend("default" = false))]
    pub denoise: Option<bool>,
    /// Quality of the denoised picture
    #[schemars(extend("default" = "high"))]
    pub denoise_quality: Option<DenoiseQuality>,
}

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BackgroundTable {
    /// Constant colour, linear RGB; instead of a gradient
    pub color: Option<Three>,
    /// Straight up
    pub zenith: Option<Three>,
    /// At eye level
    pub horizon: Option<Three>,
    /// Straight down
    pub ground: Option<Three>,
}

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct EnvironmentTable {
    /// Latitude-longitude map (.hdr, .exr, or a picture of sRGB values), relative to the shot file
    pub map: Option<At<String>>,
    /// A clear sky with its sun
    pub sky: Option<SkyTable>,
    /// Degrees about Y, counter-clockwise as seen from above (0)
    pub rotation: Option<At<f64>>,
    /// Factor on all of it (1)
    #[schemars(range(min = 0))]
    pub power: Option<At<f64>>,
    /// Light group of the environment, the background and the ambient light (others)
    pub light_group: Option<At<String>>,
    /// True if the camera sees it instead of the background (true)
    pub visible: Option<bool>,
    /// Rays that ask it for light where a path starts (1)
    #[schemars(range(min = 0, max = 64))]
    pub samples: Option<At<i64>>,
}

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FogTable {
    /// Share of light that it scatters for each unit of length of the shot (0)
    pub scatter: Option<Three>,
    /// Share of light that it absorbs, likewise (0)
    pub absorb: Option<Three>,
    /// Radiance that it emits, likewise (0)
    pub emit: Option<Three>,
    /// Factor on all three (1)
    #[schemars(range(min = 0))]
    pub density: Option<At<f64>>,
    /// Where it scatters light to: mean cosine of the angle by which that is turned, from -1 (back) to 1 (straight on) (0)
    #[schemars(range(min = -1, max = 1))]
    pub anisotropy: Option<At<f64>>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SkyTable {
    /// Elevation of the sun above the horizon, degrees (45)
    #[schemars(range(min = -6, max = 90))]
    pub elevation: Option<At<f64>>,
    /// Azimuth of the sun, degrees: 0 is -Z, 90 is +X (135)
    pub azimuth: Option<At<f64>>,
    /// Haze: 2 is very clear, 6 hazy (3)
    #[schemars(range(min = 2, max = 10))]
    pub turbidity: Option<At<f64>>,
    /// Albedo of the ground below the horizon [0.2, 0.2, 0.2]
    pub ground: Option<Three>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FloorTable {
    /// Its Y (0)
    pub height: Option<At<f64>>,
    /// Reflectance, linear RGB [0.3, 0.3, 0.3]
    pub color: Option<Three>,
    /// Radius around the middle of the models (40 times the diagonal of all models at the first frame)
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius: Option<At<f64>>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MistTable {
    /// Distance from the eye at which it begins (5)
    #[schemars(range(min = 0))]
    pub start: Option<At<f64>>,
    /// Way from there to where it hides all (25)
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub depth: Option<At<f64>>,
    /// How it grows on that way
    #[schemars(extend("default" = "quadratic"))]
    pub falloff: Option<MistFalloff>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LightTable {
    /// For people
    pub name: Option<String>,
    /// The kind of light
    #[serde(rename = "type")]
    pub kind: LightType,
    /// Directional: in which the light travels
    pub direction: Option<Three>,
    /// Point, spot: position. Rectangle, disk, sphere: centre
    pub position: Option<Three>,
    /// Spot, rectangle, disk: the point that the light faces
    pub target: Option<Three>,
    /// Spot: full cone angle, degrees (45)
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 180))]
    pub cone: Option<At<f64>>,
    /// Spot: falloff at the rim, as a fraction of the half angle (0)
    #[schemars(range(min = 0, max = 1))]
    pub soft: Option<At<f64>>,
    /// Spot: curve of that falloff, from the rim inwards, by cosines ("smooth")
    pub fall: Option<At<SpotFall>>,
    /// Rectangle, disk: direction in which its height points, as far as the target lets it [0, 1, 0]
    pub up: Option<Three>,
    /// Rectangle: width and height [1, 1]. Disk: those of an ellipse, instead of `radius`
    pub size: Option<At<List<f64, 2>>>,
    /// Rectangle, disk: full angle of the cone in which it shines, degrees: towards its rim it dims to nothing (180: to all of its
    /// side)
    #[schemars(range(min = 1, max = 180))]
    pub spread: Option<At<f64>>,
    /// Disk, sphere (0.5), spot (0: a point)
    pub radius: Option<At<f64>>,
    /// Sphere: whatever it lights sees a disc that faces it, also from within the radius, as of Blender's soft falloff (false)
    pub faces: Option<At<bool>>,
    /// Directional: diameter of the light, degrees (0)
    #[schemars(range(min = 0, max = 180))]
    pub angle: Option<At<f64>>,
    /// Rectangle, disk, sphere, and directional with an angle: shadow rays of each sample (16)
    #[schemars(extend("enum" = [1, 4, 16]))]
    pub samples: Option<At<u32>>,
    /// Name of the light group, whose layer shows what its lights add to the picture: letters, digits, `-`
    /// and `_`
    pub group: Option<At<String>>,
    /// Models that it lights (all)
    pub light_link: Option<At<NamesTable>>,
    /// Models that cast shadows in its light (all)
    pub shadow_link: Option<At<NamesTable>>,
    /// Linear RGB [1, 1, 1]
    pub color: Option<Three>,
    /// Directional: irradiance. Others: intensity (1)
    pub power: Option<At<f64>>,
    /// Between keys
    #[serde(default)]
    pub interpolation: Interpolation,
    /// Keys of the light: its values at some frames
    #[serde(default)]
    pub key: Vec<At<LightKey>>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum LightType {
    Directional,
    Point,
    Spot,
    Rectangle,
    Disk,
    Sphere,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LightKey {
    /// Number of the frame; may be fractional
    pub frame: At<f64>,
    /// As of the light, at this frame
    pub position: Option<Three>,
    /// As of the light, at this frame
    pub direction: Option<Three>,
    /// As of the light, at this frame
    pub target: Option<Three>,
    /// As of the light, at this frame
    pub up: Option<Three>,
    /// As of the light, at this frame
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 180))]
    pub cone: Option<At<f64>>,
    /// As of the light, at this frame
    #[schemars(range(min = 0, max = 1))]
    pub soft: Option<At<f64>>,
    /// As of the light, at this frame
    pub size: Option<At<List<f64, 2>>>,
    /// As of the light, at this frame
    #[schemars(range(min = 1, max = 180))]
    pub spread: Option<At<f64>>,
    /// As of the light, at this frame
    pub radius: Option<At<f64>>,
    /// As of the light, at this frame
    #[schemars(range(min = 0, max = 180))]
    pub angle: Option<At<f64>>,
    /// As of the light, at this frame
    pub color: Option<Three>,
    /// As of the light, at this frame
    pub power: Option<At<f64>>,
}

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct AmbientTable {
    /// Linear RGB; multiplied by the material's Ka
    pub color: Option<Three>,
    /// Multiply by Kd instead of Ka
    #[serde(default)]
    pub everywhere: bool,
    /// Multiply by how open the surface is: see `[occlusion]`
    #[serde(default)]
    pub occluded: bool,
}

/// Known to the schema alone: what is no layer is told by the loader.
struct LayerName;

impl JsonSchema for LayerName {
    fn schema_name() -> Cow<'static, str> {
        "Layer".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"enum": Layers::SETS.iter().chain(&Layers::NAMES).collect::<Vec<_>>()})
    }
}

/// Frames per second as a fraction of whole numbers, or the text that could not be read as one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Rate {
    Whole(i64),
    Text(String),
}

impl<'de> Deserialize<'de> for Rate {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct RateVisitor;
        impl Visitor<'_> for RateVisitor {
            type Value = Rate;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a whole number or a fraction in quotes, like \"24000/1001\"")
            }
            fn visit_i64<E: de::Error>(self, rate: i64) -> Result<Rate, E> {
                Ok(Rate::Whole(rate))
            }
            fn visit_str<E: de::Error>(self, rate: &str) -> Result<Rate, E> {
                Ok(Rate::Text(rate.to_string()))
            }
        }
        deserializer.deserialize_any(RateVisitor)
    }
}

impl JsonSchema for Rate {
    fn schema_name() -> Cow<'static, str> {
        "Rate".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"anyOf": [
            {"type": "integer", "minimum": 1},
            {"type": "string", "pattern": "^ *[0-9]+ *(/ *[0-9]+ *)?$"},
        ]})
    }
}

impl JsonSchema for BudgetValue {
    fn schema_name() -> Cow<'static, str> {
        "Budget".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"anyOf": [
            {"type": "integer", "minimum": 0},
            {"type": "string", "pattern": "^(full|[0-9]+)$"},
        ]})
    }
}

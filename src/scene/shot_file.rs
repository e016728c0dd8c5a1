//! The shot file as it is written: tables and keys, nothing checked but names and types.

use std::fmt;

use serde::Deserialize;
use serde::de::value::SeqAccessDeserializer;
use serde::de::{self, Deserializer, SeqAccess, Visitor};

use super::toml_text::{At, List};
use crate::animation::Interpolation;
use crate::settings::{DenoiseQuality, Filter, Mode, Reuse};

/// Linear RGB, or coordinates.
pub(crate) type Three = At<List<f64, 3>>;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ShotFile {
    pub title: Option<String>,
    #[serde(default)]
    pub render: RenderTable,
    #[serde(default)]
    pub output: OutputTable,
    pub background: Option<BackgroundTable>,
    pub environment: Option<At<EnvironmentTable>>,
    pub camera: Option<At<CameraTable>>,
    #[serde(default)]
    pub model: Vec<ModelTable>,
    #[serde(default)]
    pub light: Vec<At<LightTable>>,
    #[serde(default)]
    pub ambient: AmbientTable,
    #[serde(default)]
    pub indirect: IndirectTable,
    #[serde(default)]
    pub material: Vec<MaterialTable>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RenderTable {
    pub size: Option<List<At<i64>, 2>>,
    pub samples: Option<At<i64>>,
    pub frames: Option<At<String>>,
    pub rate: Option<At<Rate>>,
    #[serde(default)]
    pub filter: Filter,
    pub depth: Option<At<i64>>,
    pub reflections: Option<At<i64>>,
    pub base_every: Option<At<i64>>,
    #[serde(default)]
    pub mode: Mode,
    #[serde(default)]
    pub reuse: Reuse,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct IndirectTable {
    pub paths: Option<At<i64>>,
    pub bounces: Option<At<i64>>,
    pub budget: Option<At<BudgetValue>>,
    pub paths_per_frame: Option<At<i64>>,
}

/// `"full"`, or a number of rays.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged, expecting = "it must be `full`, or a number of rays a frame")]
pub(crate) enum BudgetValue {
    Rays(u64),
    Text(String),
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct OutputTable {
    pub path: Option<At<String>>,
    pub layers: Option<Vec<At<String>>>,
    #[serde(default)]
    pub denoise: bool,
    #[serde(default)]
    pub denoise_quality: DenoiseQuality,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BackgroundTable {
    pub color: Option<Three>,
    pub zenith: Option<Three>,
    pub horizon: Option<Three>,
    pub ground: Option<Three>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct EnvironmentTable {
    pub map: Option<At<String>>,
    pub sky: Option<SkyTable>,
    pub rotation: Option<At<f64>>,
    pub power: Option<At<f64>>,
    pub visible: Option<bool>,
    pub samples: Option<At<i64>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SkyTable {
    pub elevation: Option<At<f64>>,
    pub azimuth: Option<At<f64>>,
    pub turbidity: Option<At<f64>>,
    pub ground: Option<Three>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CameraTable {
    #[serde(default)]
    pub interpolation: Interpolation,
    #[serde(default)]
    pub key: Vec<At<CameraKey>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CameraKey {
    pub frame: At<f64>,
    pub eye: Three,
    pub target: Option<Three>,
    pub rotation: Option<Three>,
    pub roll: Option<At<f64>>,
    pub fov: Option<At<f64>>,
    #[serde(default)]
    pub cut: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ModelTable {
    pub name: Option<String>,
    pub obj: At<String>,
    pub translate: Option<Three>,
    pub rotate: Option<Three>,
    pub scale: Option<At<Scale>>,
    #[serde(default)]
    pub interpolation: Interpolation,
    #[serde(default)]
    pub key: Vec<At<ModelKey>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ModelKey {
    pub frame: At<f64>,
    pub translate: Option<Three>,
    pub rotate: Option<Three>,
    pub scale: Option<At<Scale>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LightTable {
    pub name: Option<String>,
    #[serde(rename = "type")]
    pub kind: LightType,
    pub direction: Option<Three>,
    pub position: Option<Three>,
    pub target: Option<Three>,
    pub cone: Option<At<f64>>,
    pub soft: Option<At<f64>>,
    pub size: Option<At<List<f64, 2>>>,
    pub radius: Option<At<f64>>,
    pub angle: Option<At<f64>>,
    pub samples: Option<At<u32>>,
    pub color: Option<Three>,
    pub power: Option<At<f64>>,
    #[serde(default)]
    pub interpolation: Interpolation,
    #[serde(default)]
    pub key: Vec<At<LightKey>>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum LightType {
    Directional,
    Point,
    Spot,
    Rectangle,
    Disk,
    Sphere,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LightKey {
    pub frame: At<f64>,
    pub position: Option<Three>,
    pub direction: Option<Three>,
    pub target: Option<Three>,
    pub color: Option<Three>,
    pub power: Option<At<f64>>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct AmbientTable {
    pub color: Option<Three>,
    #[serde(default)]
    pub everywhere: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MaterialTable {
    pub name: At<String>,
    pub kd: Option<Three>,
    pub ka: Option<Three>,
    pub ks: Option<Three>,
    pub ke: Option<Three>,
    pub ns: Option<At<f64>>,
    pub ni: Option<At<f64>>,
    pub d: Option<At<f64>>,
    pub illum: Option<At<i64>>,
    pub pr: Option<At<f64>>,
    pub pm: Option<At<f64>>,
    pub map_kd: Option<At<String>>,
}

/// One factor, or one an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale(pub [f64; 3]);

/// Frames per second as a fraction of whole numbers, or what could not be read as one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Rate {
    Whole(i64),
    Text(String),
}

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

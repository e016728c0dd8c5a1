//! The table of hair in a `[[material]]` of a shot file, as it is written: see [`shot_file`](super).

use schemars::JsonSchema;
use serde::Deserialize;

use super::toml_text::{At, Three};

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct HairTable {
    /// Roughness along the fibre (0.3)
    #[schemars(range(min = 0, max = 1))]
    pub roughness: Option<At<f64>>,
    /// Roughness around the fibre (0.3)
    #[schemars(range(min = 0, max = 1))]
    pub radial_roughness: Option<At<f64>>,
    /// How much smoother light is reflected off the surface of fibres: 0 as rough as all else, 1 as off a mirror (0)
    #[schemars(range(min = 0, max = 1))]
    pub coat: Option<At<f64>>,
    /// Index of refraction (1.55)
    #[schemars(range(min = 1.01, max = 4))]
    pub ni: Option<At<f64>>,
    /// Tilt of the scales, degrees (2)
    #[schemars(range(min = -45, max = 45))]
    pub offset: Option<At<f64>>,
    /// Amount of melanin, from 0 (white hair) to 1 (black), in place of `kd`
    #[schemars(range(min = 0, max = 1))]
    pub melanin: Option<At<f64>>,
    /// With `melanin`: share of the red kind (1)
    #[schemars(range(min = 0, max = 1))]
    pub melanin_redness: Option<At<f64>>,
    /// With `melanin`: colour of a dye (white)
    pub tint: Option<Three>,
    /// Absorption of red, green and blue light across the radius of a fibre, in place of `kd`
    pub absorption: Option<Three>,
}

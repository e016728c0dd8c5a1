//! Keys of `[mtl]` and `[[material]]`.

use glam::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

use super::hair::HairTable;
use super::toml_text::{At, Three};

/// Meaning of `Kd` beside a `map_Kd`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum KdBesideMap {
    /// As the exporter means it: ignored where the header says Blender, a factor elsewhere.
    #[default]
    Exporter,
    /// It multiplies the picture.
    Multiply,
    /// The picture shows alone.
    Ignore,
}

/// Meaning of alpha that a picture has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum AlphaMode {
    /// Places of which less than a half is there are not there at all.
    Cut,
    /// Each place is a veil as clear as it says.
    Blend,
}

/// Axis of a model's file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Axis {
    X,
    Y,
    Z,
}

impl Axis {
    /// The axis as a direction.
    pub fn vector(self) -> Vec3 {
        match self {
            Self::X => Vec3::X,
            Self::Y => Vec3::Y,
            Self::Z => Vec3::Z,
        }
    }
}

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MtlTable {
    /// Kd beside a map_Kd: as the exporter means it, or it multiplies the picture, or it is ignored (exporter)
    #[serde(default)]
    pub kd_beside_map_kd: KdBesideMap,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MaterialTable {
    /// The name after `newmtl`
    pub name: At<String>,
    /// MaterialX file (.mtlx), relative to the shot file, whose material of this name is taken; the other keys here replace values of it
    pub mtlx: Option<At<String>>,
    /// Diffuse colour, linear RGB
    pub kd: Option<Three>,
    /// Ambient colour
    pub ka: Option<Three>,
    /// Specular colour: highlights and mirrors
    pub ks: Option<Three>,
    /// Emission
    pub ke: Option<Three>,
    /// Highlight exponent
    #[schemars(range(min = 0))]
    pub ns: Option<At<f64>>,
    /// Index of refraction
    #[schemars(range(min = 0, max = 100))]
    pub ni: Option<At<f64>>,
    /// Opacity
    #[schemars(range(min = 0, max = 1))]
    pub d: Option<At<f64>>,
    /// Share of the light that goes through the surface, as through clear glass that `kd` tints (0)
    #[schemars(range(min = 0, max = 1))]
    pub transmission: Option<At<f64>>,
    /// Transmission filter: colour of the light that goes through glass (`illum` 4, 6, 7 or 9) or a veil (`d` below 1)
    pub tf: Option<Three>,
    /// Illumination model
    #[schemars(range(min = 0, max = 10))]
    pub illum: Option<At<i64>>,
    /// Roughness
    #[schemars(range(min = 0, max = 1))]
    pub pr: Option<At<f64>>,
    /// Metallic
    #[schemars(range(min = 0, max = 1))]
    pub pm: Option<At<f64>>,
    /// How white metal is at grazing angles: 0 as at right angles, 1 white, as metals are (1)
    #[schemars(range(min = 0, max = 1))]
    pub metal_edge: Option<At<f64>>,
    /// How much narrower the lobe of its layer is across the tangent than along it: brushed metal (0)
    #[schemars(range(min = 0, max = 1))]
    pub anisotropy: Option<At<f64>>,
    /// Turn of the tangent about the normal, counter-clockwise, in degrees (0)
    pub anisotropy_turn: Option<At<f64>>,
    /// Axis of the model's file around which the tangent leads, as the grooves of turned metal do; without one it is that of the first texture coordinate
    pub anisotropy_around: Option<Axis>,
    /// Roughness of what is matt: clay, dust, the moon (0)
    #[schemars(range(min = 0, max = 1))]
    pub diffuse_roughness: Option<At<f64>>,
    /// Share of the diffuse light that goes below the surface and comes out somewhere else (0)
    #[schemars(range(min = 0, max = 1))]
    pub subsurface: Option<At<f64>>,
    /// Mean free path below the surface: the way that red, green and blue light goes before it is scattered, in the units of the shot (1, 0.5, 0.25)
    pub subsurface_radius: Option<Three>,
    /// Index of refraction by which light that goes below the surface is bent (that of its layer; 1 without one)
    #[schemars(range(min = 1, max = 100))]
    pub subsurface_ni: Option<At<f64>>,
    /// Roughness of the interface that bends it (that of its layer)
    #[schemars(range(min = 0, max = 1))]
    pub subsurface_pr: Option<At<f64>>,
    /// Share of it that goes in by the cosine law, as into what is matt (0; 1 without an index of refraction)
    #[schemars(range(min = 0, max = 1))]
    pub subsurface_matt: Option<At<f64>>,
    /// Share of the diffuse light that leaves on the other side of the surface, as through a leaf or paper (0)
    #[schemars(range(min = 0, max = 1))]
    pub translucency: Option<At<f64>>,
    /// Share of light that what fills closed meshes of it scatters for each unit of length of the shot: fog, smoke, milk (0)
    pub volume_scatter: Option<Three>,
    /// Share of light that it absorbs, likewise: tinted water (0)
    pub volume_absorb: Option<Three>,
    /// Radiance that it emits, likewise: fire (0)
    pub volume_emit: Option<Three>,
    /// Factor on all three (1)
    #[schemars(range(min = 0))]
    pub volume_density: Option<At<f64>>,
    /// Where it scatters light to: mean cosine of the angle by which that is turned, from -1 (back) to 1 (straight on) (0)
    #[schemars(range(min = -1, max = 1))]
    pub volume_anisotropy: Option<At<f64>>,
    /// Cells along the longest edge of a mesh within which it is interpolated, where a graph gives it (128)
    #[schemars(range(min = 1, max = 512))]
    pub volume_cells: Option<At<i64>>,
    /// False if it has no surface, and is what fills its meshes alone (true)
    pub surface: Option<bool>,
    /// Length of the way through glass after which light has the colour `depth_color`, in the units of the shot; 0: it absorbs none (0)
    #[schemars(range(min = 0))]
    pub depth: Option<At<f64>>,
    /// Colour of light that has come as far as `depth` through glass (white)
    pub depth_color: Option<Three>,
    /// Share of the light that glass reflects where it reflects totally, back into itself (white, or `transmission`)
    pub ks_total: Option<Three>,
    /// True for glass that is a pane, both of its walls at once: light goes straight through (false)
    pub thin: Option<bool>,
    /// Share of the surface that a clear coat covers (0)
    #[schemars(range(min = 0, max = 1))]
    pub coat: Option<At<f64>>,
    /// Roughness of the coat (0)
    #[schemars(range(min = 0, max = 1))]
    pub coat_roughness: Option<At<f64>>,
    /// Index of refraction of the coat (1.5)
    #[schemars(range(min = 1, max = 100))]
    pub coat_ni: Option<At<f64>>,
    /// Colour of light that has passed the coat, in and out again (white)
    pub coat_color: Option<Three>,
    /// How far the coat darkens what is below by reflecting it back inside: 0 not at all, 1 as light does (0)
    #[schemars(range(min = 0, max = 1))]
    pub coat_darkening: Option<At<f64>>,
    /// Share of the surface that fuzz covers: fibres, dust, down (0)
    #[schemars(range(min = 0, max = 1))]
    pub fuzz: Option<At<f64>>,
    /// Colour of the fuzz (white)
    pub fuzz_color: Option<Three>,
    /// Roughness of the fuzz: how far from grazing angles it is seen (0.5)
    #[schemars(range(min = 0, max = 1))]
    pub fuzz_roughness: Option<At<f64>>,
    /// Fibres of hair in place of all that reflects
    pub hair: Option<At<HairTable>>,
    /// Texture file, relative to the shot file
    pub map_kd: Option<At<String>>,
    /// Opacity: a picture that cuts parts out, where its alpha, or its brightness if it has none, is below a half
    pub map_d: Option<At<String>>,
    /// What a picture's alpha means: it cuts parts out, or makes veils (OBJ: cut; glTF, USD: as the file says)
    pub alpha_mode: Option<AlphaMode>,
    /// Picture of Ks, by which it is multiplied
    pub map_ks: Option<At<String>>,
    /// Picture of Ns: its brightness is a factor
    pub map_ns: Option<At<String>>,
    /// Picture of Ke, by which it is multiplied
    pub map_ke: Option<At<String>>,
    /// Picture of Pr: its brightness is a factor
    pub map_pr: Option<At<String>>,
    /// Picture of Pm: its brightness is a factor
    pub map_pm: Option<At<String>>,
    /// Picture of the colour of the light that goes through glass, a factor of `tf` (and of `kd` beside `transmission`)
    pub map_tf: Option<At<String>>,
    /// Picture of the share of glass that is glass: its brightness is a factor; what is not is matt, in the colour of `kd`
    pub map_transmission: Option<At<String>>,
    /// Picture of normals: red to the right, green upwards, blue out of the surface
    pub norm: Option<At<String>>,
    /// Picture of heights, or of normals
    pub map_bump: Option<At<String>>,
    /// Picture of heights that move the vertices of the mesh along its normals, once a shot: see `subdivision` and `dicing`
    pub map_displacement: Option<At<String>>,
    /// With `map_displacement`: length for which white stands, in the units of the model's file (1)
    pub displacement: Option<At<f64>>,
    /// With `map_displacement`: brightness that moves nothing (0.5)
    pub displacement_middle: Option<At<f64>>,
}

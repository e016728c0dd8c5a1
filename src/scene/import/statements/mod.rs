//! What files and `[[material]]` tables state of a material, by MTL's names; and what these statements mean together.

pub mod anisotropy;
pub mod coat;
pub mod fuzz;
mod illumination;
pub mod interior;
pub mod maps;

use glam::{DVec3, Vec3};

use self::anisotropy::StatedAnisotropy;
use self::coat::StatedCoat;
use self::fuzz::StatedFuzz;
use self::interior::StatedInterior;
use self::maps::{MapStatements, MapUse};
use crate::scene::import::surfaces::varying::PARAMETERS;
use crate::scene::keys::material::AlphaMode;
use crate::scene::material::LARGEST_COLOR;

/// Statements of a file about one material. Absent values are not the defaults: those depend on other values.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Statements {
    pub name: String,
    /// Line of `newmtl`.
    pub line: usize,
    pub kd: Option<Vec3>,
    pub ka: Option<Vec3>,
    pub ks: Option<Vec3>,
    pub ke: Option<Vec3>,
    pub tf: Option<Vec3>,
    pub ns: Option<f32>,
    pub ni: Option<f32>,
    pub d: Option<f32>,
    pub tr: Option<f32>,
    pub illum: Option<u32>,
    pub pr: Option<f32>,
    pub pm: Option<f32>,
    /// How white metal is at grazing angles, 0 (as at right angles) to 1, and how rough what is matt is, 0 to 1; MTL has no such statements.
    pub metal_edge: Option<f32>,
    pub diffuse_roughness: Option<f32>,
    /// Direction along which it spreads light.
    pub anisotropy: StatedAnisotropy,
    /// Inside of the surface.
    pub interior: StatedInterior,
    /// Clear coat: Pc and Pcr; MTL has no statements about the rest.
    pub coat: StatedCoat,
    /// Fuzz; MTL has no statements about it.
    pub fuzz: StatedFuzz,
    /// Meaning of a picture's alpha, if a shot file states it.
    pub alpha_mode: Option<AlphaMode>,
    /// Pictures by their use.
    pub maps: MapStatements,
}

impl Statements {
    /// Returns true if `d` and `Tr` contradict each other: `d` is 1 - `Tr`.
    pub fn contradicts_itself(&self) -> bool {
        matches!((self.d, self.tr), (Some(d), Some(tr)) if (d + tr - 1.0).abs() > 0.01)
    }

    /// Takes every value that `other` states.
    pub fn replace_with(&mut self, other: &Self) {
        self.kd = other.kd.or(self.kd);
        self.ka = other.ka.or(self.ka);
        self.ks = other.ks.or(self.ks);
        self.ke = other.ke.or(self.ke);
        self.tf = other.tf.or(self.tf);
        self.ns = other.ns.or(self.ns);
        self.ni = other.ni.or(self.ni);
        self.d = other.d.or(self.d);
        self.tr = other.tr.or(self.tr);
        self.illum = other.illum.or(self.illum);
        self.pr = other.pr.or(self.pr);
        self.pm = other.pm.or(self.pm);
        self.metal_edge = other.metal_edge.or(self.metal_edge);
        self.diffuse_roughness = other.diffuse_roughness.or(self.diffuse_roughness);
        self.interior.replace_with(&other.interior);
        self.anisotropy.replace_with(&other.anisotropy);
        self.coat.replace_with(&other.coat);
        self.fuzz.replace_with(&other.fuzz);
        self.alpha_mode = other.alpha_mode.or(self.alpha_mode);
        // a number all over is what is meant, and no factor of a picture; the colour of one is
        for used in PARAMETERS.into_iter().filter(|used| other.states_number(*used)) {
            self.maps[used] = None;
        }
        self.maps.replace_with(&other.maps);
    }

    /// Returns true if it states the parameter as a number that pictures of this use give.
    pub fn states_number(&self, used: MapUse) -> bool {
        match used {
            MapUse::Specular => self.ks.is_some(),
            MapUse::Shininess => self.ns.is_some(),
            MapUse::Emission => self.ke.is_some(),
            MapUse::Roughness => self.pr.is_some(),
            MapUse::Metal => self.pm.is_some(),
            MapUse::Color | MapUse::Opacity | MapUse::Normal | MapUse::Bump => false,
        }
    }

    /// Has the surface let the share `through` of the light pass, tinted by its diffuse colour and `filter`: as glass, which is as rough as
    /// `Pr`.
    #[must_use]
    pub fn with_transmission(self, through: f64, filter: DVec3) -> Self {
        let base = self.kd.unwrap_or(Vec3::ONE).as_dvec3();
        let tint = (base * through * filter).min(DVec3::ONE);
        // the share that a surface does not let through is what it reflects by itself: see `settle`
        let rest = (1.0 - tint.max_element()).max(f64::MIN_POSITIVE);
        let kd = (base * (1.0 - through) / rest).as_vec3().clamp(Vec3::ZERO, Vec3::splat(LARGEST_COLOR));
        Self { kd: Some(kd), tf: Some(tint.as_vec3()), illum: Some(6), pm: None, ..self }
    }
}

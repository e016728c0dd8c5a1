//! What files and `[[material]]` tables state of a material, by MTL's names; and what these statements mean together.

mod illumination;
pub mod maps;

use glam::{DVec3, Vec3};

use self::maps::{MapStatements, MapUse, PARAMETERS};
use crate::scene::keys::material::AlphaMode;
use crate::scene::material::{Hair, LARGEST_COLOR};
use crate::scene::surface::{Parameter, Value};

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
    /// Parameters of OpenPBR that are stated by their own names, constants; of two the later one counts. MTL has two: Pc and Pcr.
    pub parameters: Vec<(Parameter, Value)>,
    /// See [`Beyond`](crate::scene::surface::Beyond); MTL has no statements about these.
    pub metal_edge: Option<f32>,
    pub total_reflection: Option<Vec3>,
    pub translucency: Option<f32>,
    pub entry_index: Option<f32>,
    pub entry_roughness: Option<f32>,
    pub entry_matt: Option<f32>,
    pub tangent_turn: Option<f32>,
    pub tangent_around: Option<Vec3>,
    pub hair: Option<Hair>,
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
        self.total_reflection = other.total_reflection.or(self.total_reflection);
        self.parameters.extend(&other.parameters);
        self.translucency = other.translucency.or(self.translucency);
        self.entry_index = other.entry_index.or(self.entry_index);
        self.entry_roughness = other.entry_roughness.or(self.entry_roughness);
        self.entry_matt = other.entry_matt.or(self.entry_matt);
        self.tangent_turn = other.tangent_turn.or(self.tangent_turn);
        self.tangent_around = other.tangent_around.or(self.tangent_around);
        self.hair = other.hair.or(self.hair);
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
            MapUse::Filter => self.tf.is_some(),
            MapUse::Color | MapUse::Opacity | MapUse::Normal | MapUse::Bump => false,
            MapUse::Transmission | MapUse::Displacement => false,
        }
    }

    /// The value of a parameter that is stated by its own name.
    pub fn stated(&self, parameter: Parameter) -> Option<Value> {
        self.parameters.iter().rfind(|(of, _)| *of == parameter).map(|(_, value)| *value)
    }

    /// States a parameter by its own name, if there is a value.
    pub fn state(&mut self, parameter: Parameter, value: Option<impl Into<Value>>) {
        self.parameters.extend(value.map(|value| (parameter, value.into())));
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
        // only what is glass reflects totally
        let total_reflection = self.total_reflection.or(Some(Vec3::splat(through as f32)));
        Self { kd: Some(kd), tf: Some(tint.as_vec3()), illum: Some(6), pm: None, total_reflection, ..self }
    }
}

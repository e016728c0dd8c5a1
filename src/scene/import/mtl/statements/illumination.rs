//! What the statements on a material mean together: its optics by `illum`, its layer by `Pr` and `Pm`.

use glam::Vec3;

use super::Statements;
use super::maps::MapUse;
use crate::scene::Material;
use crate::scene::surface::{Mirror, Parameter, Phong, Surface, Value};

/// Exponent of a highlight where a `map_Ns` is white and there is no `Ns`: the largest that most programs write.
const NARROWEST_OF_MAP: f32 = 1000.0;

/// Default of Pr for a material that has Pm alone, as in programs with a metal-rough material.
const DEFAULT_ROUGHNESS: f32 = 0.5;

/// Index of refraction of a surface that is no metal, if Ni does not say.
const DEFAULT_INDEX: f32 = 1.5;

/// Share of the light that glass lets through of which the filter says that it is none: it reflects all the same.
const OF_BLACK_GLASS: f32 = 1e-30;

impl Statements {
    /// The surface that the statements mean together. The pictures are left to the caller.
    pub fn surface(&self) -> Surface {
        let illum = self.illum.unwrap_or(2);
        let is_metal_rough = self.is_metal_rough(illum);
        let mut surface = Surface::matt(self.name.clone(), Vec3::ONE);
        if is_metal_rough {
            // of glass and mirrors metal-rough materials know coverage alone
            self.set_coverage(&mut surface);
            if self.has_layer() {
                self.set_layer(&mut surface);
            }
        } else {
            self.set_optics(illum, &mut surface);
            surface.beyond.phong = self.highlight(illum);
        }
        let kd = self.kd.unwrap_or_else(|| self.default_diffuse(&surface));
        // some files leave Kd black, because metals scatter no light, and give their colour as that of highlights
        let base = match self.ks {
            Some(ks) if metalness(&surface) > 0.0 && kd == Vec3::ZERO => ks,
            _ => kd,
        };
        set_base(&mut surface, base);
        surface.beyond.ambient = self.ka.or((base != kd).then_some(kd));
        surface.set_emission(self.emission());
        self.lay_parameters(&mut surface);
        surface
    }

    /// Replaces what they state of a surface that means something by itself, of a file of another kind.
    pub fn lay_over(&self, surface: &mut Surface) {
        if let Some(kd) = self.kd {
            set_base(surface, kd);
        }
        if let Some(ke) = self.ke {
            surface.set_emission(ke);
        }
        if self.d.is_some() || self.tr.is_some() {
            surface[Parameter::GeometryOpacity] = self.solid().into();
        }
        let is_glass = |surface: &Surface| surface[Parameter::TransmissionWeight] != Value::ZERO;
        match (self.illum, self.tf) {
            (Some(illum), tf) if is_model_of_glass(illum) => set_glass(surface, tf.unwrap_or(Vec3::ONE)),
            (Some(_), _) => surface[Parameter::TransmissionWeight] = Value::ZERO,
            (None, Some(tf)) if is_glass(surface) => set_glass(surface, tf),
            (None, _) => {}
        }
        surface.beyond.veil = self.tf.map_or(surface.beyond.veil, veil);
        let is_glass = is_glass(surface);
        if (self.pr.is_some() || self.pm.is_some()) && !is_glass && !has_layer(surface) {
            surface.set_layer(DEFAULT_INDEX, DEFAULT_ROUGHNESS, 0.0);
            surface.beyond.phong = None;
        }
        if let Some(pr) = self.pr {
            surface[Parameter::SpecularRoughness] = pr.into();
        }
        // glass stays glass
        if let Some(pm) = self.pm.filter(|_| !is_glass || self.solid() < 1.0) {
            surface[Parameter::BaseMetalness] = pm.into();
        }
        if let Some(ni) = self.ni {
            let of_layer = if ni > 1.0 { ni } else { DEFAULT_INDEX };
            surface[Parameter::SpecularIor] = if is_glass { ni } else { of_layer }.into();
            surface[Parameter::SpecularWeight] = Value::ONE;
        }
        if let Some(ks) = self.ks {
            let is_black_metal =
                surface.constant(Parameter::BaseColor) == Vec3::ZERO && metalness(surface) > 0.0;
            match &mut surface.beyond.phong {
                _ if is_glass => surface[Parameter::SpecularColor] = ks.into(),
                Some(phong) => phong.color = ks.into(),
                None if is_black_metal => set_base(surface, ks),
                None => {}
            }
        }
        if let (Some(ns), Some(phong)) = (self.ns, &mut surface.beyond.phong) {
            phong.exponent = ns.into();
        }
        let emission = [Parameter::EmissionColor, Parameter::EmissionLuminance].map(|of| surface[of]);
        if self.maps.has(MapUse::Emission) && emission.contains(&Value::ZERO) {
            surface.set_emission(Vec3::ONE);
        }
        surface.beyond.ambient = self.ka.or(surface.beyond.ambient);
        self.lay_parameters(surface);
    }

    /// Replaces the parameters of a surface that are stated by themselves.
    fn lay_parameters(&self, surface: &mut Surface) {
        let before = surface[Parameter::TransmissionDepth];
        let depth = self.stated(Parameter::TransmissionDepth).unwrap_or(before);
        if before != Value::ZERO && depth == Value::ZERO {
            surface[Parameter::TransmissionColor] = Value::ONE;
        }
        for (parameter, value) in &self.parameters {
            // without a depth there is no colour of one
            if *parameter != Parameter::TransmissionColor || depth != Value::ZERO {
                surface[*parameter] = *value;
            }
        }
        let beyond = &mut surface.beyond;
        beyond.metal_edge = self.metal_edge.or(beyond.metal_edge);
        beyond.translucency = self.translucency.or(beyond.translucency);
        beyond.entry_index = self.entry_index.or(beyond.entry_index);
        beyond.entry_roughness = self.entry_roughness.or(beyond.entry_roughness);
        beyond.entry_matt = self.entry_matt.or(beyond.entry_matt);
        beyond.tangent_turn = self.tangent_turn.unwrap_or(beyond.tangent_turn);
        beyond.tangent_around = self.tangent_around.or(beyond.tangent_around);
        beyond.hair = self.hair.or(beyond.hair);
    }

    /// Share of the surface that is there, by `d` or `Tr`.
    pub fn solid(&self) -> f32 {
        self.d.or(self.tr.map(|tr| 1.0 - tr)).unwrap_or(1.0).clamp(0.0, 1.0)
    }

    /// Returns true if it states roughness, metal or something above them. Glass stays glass: exporters state them for everything.
    fn is_metal_rough(&self, illum: u32) -> bool {
        let is_glass = is_model_of_glass(illum) && self.solid() == 1.0;
        let is_some = |parameter| self.stated(parameter).is_some_and(|value| value.factor.x > 0.0);
        let has_fuzz = is_some(Parameter::FuzzWeight);
        (self.has_layer() || has_fuzz || is_some(Parameter::BaseDiffuseRoughness)) && !is_glass
    }

    /// Returns true if it states anything of a layer that reflects. Fuzz alone lies on what is matt.
    fn has_layer(&self) -> bool {
        let states = |used| self.maps.has(used);
        let of_maps = states(MapUse::Roughness) || states(MapUse::Metal);
        let is_coated = self.stated(Parameter::CoatWeight).is_some_and(|weight| weight.factor.x > 0.0);
        self.pr.is_some() || self.pm.is_some() || of_maps || is_coated
    }

    fn set_layer(&self, surface: &mut Surface) {
        // without a factor a picture shows as it is
        let of_map = |used, without: f32| if self.maps.has(used) { 1.0 } else { without };
        let roughness = self.pr.unwrap_or_else(|| of_map(MapUse::Roughness, DEFAULT_ROUGHNESS));
        let metalness = self.pm.unwrap_or_else(|| of_map(MapUse::Metal, 0.0));
        // files write a Ni of 1, or 0, for "not known"
        let index = self.ni.filter(|ni| *ni > 1.0).unwrap_or(DEFAULT_INDEX);
        surface.set_layer(index, roughness, metalness);
    }

    /// Highlight, if there is any.
    fn highlight(&self, illum: u32) -> Option<Phong> {
        // without a factor a picture shows as it is
        let of_map = |used, with: f32, without: f32| if self.maps.has(used) { with } else { without };
        let color = self.ks.unwrap_or(Vec3::splat(of_map(MapUse::Specular, 1.0, 0.0)));
        let exponent = self.ns.unwrap_or(of_map(MapUse::Shininess, NARROWEST_OF_MAP, 1.0));
        (illum >= 2).then(|| Phong { color: color.into(), exponent: exponent.into() })
    }

    /// Emission: what a picture of it shows is multiplied by this. Files write a black `Ke` beside a `map_Ke`.
    fn emission(&self) -> Vec3 {
        let stated = self.ke.filter(|ke| *ke != Vec3::ZERO || !self.maps.has(MapUse::Emission));
        stated.unwrap_or(if self.maps.has(MapUse::Emission) { Vec3::ONE } else { Vec3::ZERO })
    }

    /// Sets how far the surface is there: cut-outs and veils.
    fn set_coverage(&self, surface: &mut Surface) {
        surface[Parameter::GeometryOpacity] = self.solid().into();
        surface.beyond.veil = veil(self.tf.unwrap_or(Vec3::ONE));
    }

    /// Sets what the surface does to rays.
    fn set_optics(&self, illum: u32, surface: &mut Surface) {
        if matches!(illum, 3 | 5 | 8) {
            let mirror = Mirror { tint: self.ks.unwrap_or(Vec3::ZERO), fresnel: illum == 5 };
            surface.beyond.mirror = Some(mirror);
            return;
        }
        if !is_model_of_glass(illum) {
            self.set_coverage(surface);
            return;
        }
        let filter = self.tf.unwrap_or(Vec3::ONE).min(Vec3::ONE);
        let solid = self.solid();
        if solid == 1.0 {
            // glass by its model alone: the filter says how much comes through
            set_glass(surface, filter);
            // clear, unless roughness is stated, or a picture of it
            let of_map = if self.maps.has(MapUse::Roughness) { 1.0 } else { 0.0 };
            surface[Parameter::SpecularRoughness] = self.pr.unwrap_or(of_map).into();
        } else {
            surface[Parameter::TransmissionWeight] = (1.0 - solid).into();
            surface.beyond.glass_tint = filter.into();
            surface[Parameter::SpecularRoughness] = Value::ZERO;
        }
        surface[Parameter::SpecularColor] = self.ks.unwrap_or(Vec3::ONE).into();
        // files leave Ni out, or 0, for "does not bend"
        surface[Parameter::SpecularIor] = self.ni.unwrap_or(1.0).into();
    }

    /// Default of Kd, if the file gives none.
    fn default_diffuse(&self, surface: &Surface) -> Vec3 {
        let is_glass = surface[Parameter::TransmissionWeight] != Value::ZERO;
        match self.ni {
            _ if self.maps.has(MapUse::Color) => Vec3::ONE, // the picture as it is
            _ if surface.beyond.mirror.is_some() => Vec3::ZERO,
            Some(index) if is_glass && index != 1.0 && index > 0.0 => Vec3::ZERO,
            _ => Material::fallback().diffuse,
        }
    }
}

/// Returns true for the models that are glass.
fn is_model_of_glass(illum: u32) -> bool {
    matches!(illum, 4 | 6 | 7 | 9)
}

/// Makes a surface glass, by the colour that comes through.
fn set_glass(surface: &mut Surface, filter: Vec3) {
    let most = filter.max_element();
    surface[Parameter::TransmissionWeight] = most.max(OF_BLACK_GLASS).into();
    surface.beyond.glass_tint = if most > 0.0 { (filter / most).into() } else { Value::ZERO };
    surface.beyond.is_glass_pictured = false;
    surface[Parameter::BaseMetalness] = Value::ZERO;
    if surface[Parameter::TransmissionDepth] == Value::ZERO {
        surface[Parameter::TransmissionColor] = Value::ONE;
    }
}

/// Colour of a veil by its filter: writers of `Tf 0 0 0` with `d` do not mean black.
fn veil(filter: Vec3) -> Vec3 {
    if filter == Vec3::ZERO { Vec3::ONE } else { filter.min(Vec3::ONE) }
}

/// The base colour, which is that of what is below as well.
fn set_base(surface: &mut Surface, color: Vec3) {
    surface[Parameter::BaseColor] = color.into();
    surface[Parameter::BaseWeight] = Value::ONE;
    surface[Parameter::SubsurfaceColor] = color.into();
}

fn metalness(surface: &Surface) -> f32 {
    surface[Parameter::BaseMetalness].factor.x
}

fn has_layer(surface: &Surface) -> bool {
    surface[Parameter::SpecularWeight] != Value::ZERO || metalness(surface) > 0.0
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;
    use crate::scene::import::mtl::parse;
    use crate::scene::material::{MetalRough, Optics};

    fn settled(statements: &str) -> Material {
        let file = parse(format!("newmtl m\n{statements}").as_bytes());
        assert_eq!(file.oddities, [], "{statements}");
        file.materials.into_iter().next().unwrap().surface().material()
    }

    fn glass(transmission: f32, index: f32, reflection: Vec3) -> Optics {
        Optics::clear(Vec3::splat(transmission), index, reflection)
    }

    #[test]
    fn illumination_models_say_what_the_surface_does() {
        let half = Vec3::splat(0.5);
        let glass_of = |is_rough| Optics::Glass {
            transmission: Vec3::ONE,
            index: 1.5,
            reflection: half,
            is_rough,
            is_thin: false,
        };
        for (statements, optics, specular) in [
            ("Ks .5 .5 .5\nillum 0", Optics::Opaque, Vec3::ZERO),
            ("Ks .5 .5 .5\nillum 1", Optics::Opaque, Vec3::ZERO),
            ("Ks .5 .5 .5\nillum 2", Optics::Opaque, half),
            ("Ks .5 .5 .5", Optics::Opaque, half),
            ("Ks .5 .5 .5\nillum 3", Optics::Mirror { tint: half, fresnel: false }, half),
            ("Ks .5 .5 .5\nillum 5", Optics::Mirror { tint: half, fresnel: true }, half),
            ("Ks .5\nNi 1.5\nd .25\nillum 4", glass(0.75, 1.5, half), half),
            ("Ks .5\nNi 1.5\nd .25\nillum 6", glass(0.75, 1.5, half), half),
            ("Ks .5\nNi 1.5\nd 1\nillum 7", glass(1.0, 1.5, half), half),
            ("Ks .5\nNi 0\nTr .75\nillum 9", glass(0.75, 1.0, half), half),
            ("d .25\nillum 1", glass(0.75, 1.0, Vec3::ZERO), Vec3::ZERO),
            ("Tr .75\nNi 1.5", glass(0.75, 1.0, Vec3::ZERO), Vec3::ZERO),
            ("d -halo .25\nTr .25", glass(0.75, 1.0, Vec3::ZERO), Vec3::ZERO),
            ("Ks .5\nNi 1.5\nd 1\nillum 7\nPr .5", glass_of(true), Vec3::ZERO),
            ("Ks .5\nNi 1.5\nd 1\nillum 7\nPr 0\nPm 0", glass_of(false), half),
            ("d 7", Optics::Opaque, Vec3::ZERO),
        ] {
            let material = settled(statements);
            assert_eq!((material.optics, material.specular), (optics, specular), "{statements}");
        }
    }

    #[test]
    fn roughness_or_metal_make_a_metal_rough_material() {
        let surface = |statements: &str| settled(statements).metal_rough;
        assert_eq!(surface("Kd 1 0 0\nKs 1 1 1\nNs 9"), None);
        let plain = MetalRough {
            base: Vec3::new(0.5, 0.25, 0.0),
            roughness: 0.3,
            metallic: 0.0,
            head_on: 0.04,
            solid: 1.0,
        };
        assert_eq!(surface("Kd .5 .25 0\nPr .3"), Some(plain));
        assert_eq!(surface("Kd .5 .25 0\nPm 0"), Some(MetalRough { roughness: 0.5, ..plain }));
        for unknown in ["Ni 1", "Ni 0"] {
            assert_eq!(surface(&format!("Kd .5 .25 0\nPr .3\n{unknown}")), Some(plain), "{unknown}");
        }
        let water = surface("Kd .5 .25 0\nPr .3\nNi 1.33").unwrap().head_on;
        assert!((water - 0.0201).abs() < 1e-4, "{water}");
        // metals reflect in their colour, and scatter nothing; models of illumination do not count
        let metal = settled("Kd .5 .25 0\nKs .5 .5 .5\nPr .3\nPm .75\nillum 3");
        assert_eq!(metal.metal_rough, Some(MetalRough { metallic: 0.75, ..plain }));
        assert_eq!((metal.diffuse, metal.specular), (Vec3::new(0.125, 0.0625, 0.0), Vec3::ZERO));
        assert_eq!((metal.ambient, metal.optics), (plain.base, Optics::Opaque));
        assert!(metal.has_secondary_rays() && metal.casts_shadow());
        let black = settled("Kd 0 0 0\nKs .7 .6 .5\nPr .3\nPm 1");
        assert_eq!(
            black.metal_rough.unwrap().base,
            Vec3::new(0.7, 0.6, 0.5),
            "its colour is that of highlights"
        );
        assert_eq!(
            (black.diffuse, settled("Kd 0\nKs 1\nPr .3").metal_rough.unwrap().base),
            (Vec3::ZERO, Vec3::ZERO)
        );
        // alpha is coverage
        let veil = settled("Kd .5 .25 0\nPr .3\nNi 1.5\nd .25\nillum 9");
        assert_eq!(veil.optics, glass(0.75, 1.0, Vec3::ZERO));
        assert_eq!((veil.diffuse, veil.metal_rough.unwrap().solid), (plain.base * 0.25, 0.25));
        // and glass is glass
        let pane = settled("Ks 1\nPr 0\nPm 0\nNi 1.5\nillum 7");
        assert_eq!((pane.optics, pane.metal_rough), (glass(1.0, 1.5, Vec3::ONE), None));
        let rough = settled("Ks 1\nPr .3\nPm 1\nNi 1.5\nillum 7");
        assert!(rough.is_rough_glass() && rough.is_rough(), "{rough:?}");
        let layer = MetalRough { base: Vec3::ZERO, ..plain };
        assert!((rough.metal_rough.unwrap().head_on - layer.head_on).abs() < 1e-6);
        assert_eq!(rough.metal_rough.map(|it| MetalRough { head_on: layer.head_on, ..it }), Some(layer));
    }

    #[test]
    fn filters_tint_what_comes_through() {
        let Optics::Glass { transmission, .. } = settled("Tf 1 .5 0\nd .5\nillum 7").optics else {
            unreachable!("glass by its model")
        };
        assert_eq!(transmission, Vec3::new(0.5, 0.25, 0.0));
    }

    #[test]
    fn colours_have_defaults_that_fit() {
        let plain = settled("");
        assert_eq!((plain.diffuse, plain.ambient), (Vec3::splat(0.6), Vec3::splat(0.6)));
        assert_eq!(settled("Kd 1 0 0").ambient, Vec3::X);
        assert_eq!(settled("Kd 1 0 0\nKa 0 1 0").ambient, Vec3::Y);
        assert_eq!(settled("map_Kd a.png").diffuse, Vec3::ONE);
        assert_eq!(settled("Ks 1 1 1\nillum 3").diffuse, Vec3::ZERO);
        assert_eq!(settled("Kd .5\nd .5").diffuse, Vec3::splat(0.25));
        assert_eq!(settled("Ke 3 2 1").emission, Vec3::new(3.0, 2.0, 1.0));
        assert_eq!(settled("Ns 1e9").shininess, 1e5);
    }

    /// What tables say over surfaces of files of other kinds means what it does over MTL's.
    #[test]
    fn values_replace_those_of_other_surfaces() {
        let plastic = || {
            let mut surface = Surface::matt("m", Vec3::splat(0.5));
            surface.set_layer(1.5, 0.25, 0.0);
            surface
        };
        let glass = || {
            let mut surface = plastic();
            surface[Parameter::TransmissionWeight] = Value::ONE;
            surface[Parameter::TransmissionColor] = Vec3::Y.into();
            surface
        };
        let over = |mut surface: Surface, statements: &str| {
            let file = parse(format!("newmtl m\n{statements}").as_bytes());
            file.materials[0].lay_over(&mut surface);
            surface.material()
        };
        let layer = |statements: &str| over(plastic(), statements).metal_rough.unwrap();
        assert_eq!((layer("Pr .5").roughness, layer("Pm 1").metallic), (0.5, 1.0));
        assert_eq!(layer("Kd 1 0 0").base, Vec3::X);
        assert!(
            (layer("Ni 2").head_on - 1.0 / 9.0).abs() < 1e-6 && (layer("Ni 1").head_on - 0.04).abs() < 1e-6
        );
        assert_eq!(over(plastic(), "Ke 1 2 3").emission, Vec3::new(1.0, 2.0, 3.0));
        assert_eq!(over(plastic(), "map_Ke a.png").emission, Vec3::ONE, "the picture as it is");
        // black metal has the colour of highlights, and black plastic stays black
        assert_eq!(layer("Kd 0\nKs .7\nPm 1").base, Vec3::splat(0.7));
        assert_eq!(layer("Kd 0\nKs .7").base, Vec3::ZERO);
        // coverage and its colour
        let half = |filter: Vec3| Optics::veil(filter * 0.5);
        assert_eq!(over(plastic(), "d .5\nTf 1 0 0\nillum 2").optics, half(Vec3::X));
        assert_eq!(over(plastic(), "d .5\nTf 0 0 0").optics, half(Vec3::ONE));
        // what is made glass is as rough as it was, and what is no glass any more has its layer again
        let Optics::Glass { transmission, is_rough: true, .. } = over(plastic(), "illum 7").optics else {
            panic!("it is rough glass")
        };
        assert_eq!(transmission, Vec3::ONE);
        assert!(over(glass(), "illum 2").metal_rough.is_some_and(|layer| layer.roughness == 0.25));
        // a filter replaces the colour of glass, and metal does not unmake it
        for (statements, expected) in [("Tf 1 0 0", Vec3::X), ("Pm 1", Vec3::Y), ("Ks .5", Vec3::Y)] {
            let Optics::Glass { transmission, .. } = over(glass(), statements).optics else {
                panic!("{statements}: it stays glass")
            };
            assert_eq!(transmission, expected, "{statements}");
        }
    }

    #[test]
    fn depth_takes_the_colour_of_glass() {
        let with = |values: &[(Parameter, Value)], deep: f32| {
            let mut surface = Surface::matt("m", Vec3::ONE);
            surface.set_layer(1.5, 0.0, 0.0);
            surface[Parameter::TransmissionWeight] = Value::ONE;
            surface[Parameter::TransmissionColor] = Vec3::Y.into();
            surface[Parameter::TransmissionDepth] = deep.into();
            let stated = Statements { parameters: values.to_vec(), ..Statements::default() };
            stated.lay_over(&mut surface);
            let Material { optics: Optics::Glass { transmission, .. }, absorption, .. } = surface.material()
            else {
                panic!("it is glass")
            };
            (transmission, absorption != Vec3::ZERO)
        };
        let (color, depth) =
            ((Parameter::TransmissionColor, Vec3::X.into()), (Parameter::TransmissionDepth, 2.0.into()));
        assert_eq!(with(&[], 0.0), (Vec3::Y, false));
        assert_eq!(with(&[color], 0.0), (Vec3::Y, false), "without a depth it is no colour of one");
        assert_eq!(with(&[color, depth], 0.0), (Vec3::ONE, true));
        assert_eq!(with(&[(Parameter::TransmissionDepth, Value::ZERO)], 1.0), (Vec3::ONE, false));
    }
}

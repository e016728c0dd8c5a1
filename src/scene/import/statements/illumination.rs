//! What the statements on a material mean together: its optics by `illum`, its layer by `Pr` and `Pm`.

use glam::Vec3;

use super::maps::MapUse;
use crate::scene::Material;
use crate::scene::import::statements::Statements;
use crate::scene::material::{LEAST_ALPHA, MetalRough, Optics, Scattering, head_on};
use crate::shade::optics::of_both_walls;

/// Maximum exponent of a highlight: beyond it a highlight is smaller than any pixel.
const HIGHEST_SHININESS: f32 = 1e5;

/// Exponent of a highlight where a `map_Ns` is white and there is no `Ns`: the largest that most programs write.
const NARROWEST_OF_MAP: f32 = 1000.0;

/// Default of Pr for a material that has Pm alone, as in programs with a metal-rough material.
const DEFAULT_ROUGHNESS: f32 = 0.5;

/// Reflectance of a surface that is no metal at normal incidence, if Ni does not say: that of an index of
/// 1.5.
const DEFAULT_HEAD_ON: f32 = 0.04;

impl Statements {
    /// Settles the meaning of the statements together. The pictures are left to the caller.
    pub fn settle(&self) -> Material {
        let illum = self.illum.unwrap_or(2);
        let solid = self.solid();
        let is_metal_rough = self.is_metal_rough(illum, solid);
        // of glass and mirrors metal-rough materials know coverage alone
        let illum = if is_metal_rough { 2 } else { illum };
        let (optics, share) = self.optics(illum, solid);
        let kd = self.kd.unwrap_or_else(|| self.default_diffuse(&optics));
        if is_metal_rough {
            return self.settle_metal_rough(kd, optics, share);
        }
        // without a factor a picture shows as it is
        let of_map = |used, with: f32, without: f32| if self.maps.has(used) { with } else { without };
        let ks = Vec3::splat(of_map(MapUse::Specular, 1.0, 0.0));
        let highlight = if illum < 2 { Vec3::ZERO } else { self.ks.unwrap_or(ks) };
        let shininess = of_map(MapUse::Shininess, NARROWEST_OF_MAP, 1.0);
        let metal_rough = self.layer_of_glass(optics);
        Material {
            name: self.name.clone(),
            diffuse: kd * share,
            ambient: self.ka.unwrap_or(kd) * share,
            specular: if metal_rough.is_some() { Vec3::ZERO } else { highlight },
            metal_rough,
            emission: self.emission(),
            shininess: self.ns.unwrap_or(shininess).clamp(1.0, HIGHEST_SHININESS),
            optics,
            scattering: self.scattering(optics),
            absorption: self.absorption(optics),
            ..Material::fallback()
        }
    }

    /// What goes below the surface of what is not clear.
    fn scattering(&self, optics: Optics) -> Option<Scattering> {
        self.interior.scattering().filter(|_| optics == Optics::Opaque)
    }

    /// What it absorbs on the way through it, if it is glass.
    fn absorption(&self, optics: Optics) -> Vec3 {
        if matches!(optics, Optics::Glass { .. }) { self.interior.absorption() } else { Vec3::ZERO }
    }

    /// Share of the surface that is there, by `d` or `Tr`.
    pub fn solid(&self) -> f32 {
        self.d.or(self.tr.map(|tr| 1.0 - tr)).unwrap_or(1.0).clamp(0.0, 1.0)
    }

    /// Returns true if it states roughness, metal or something above them. Glass stays glass: exporters state them for everything.
    fn is_metal_rough(&self, illum: u32, solid: f32) -> bool {
        let is_glass = matches!(illum, 4 | 6 | 7 | 9) && solid == 1.0;
        (self.has_layer() || self.fuzz.settle().is_some() || self.diffuse_roughness() > 0.0) && !is_glass
    }

    fn diffuse_roughness(&self) -> f32 {
        self.diffuse_roughness.unwrap_or(0.0).clamp(0.0, 1.0)
    }

    /// Returns true if it states anything of a layer that reflects. Fuzz alone lies on what is matt.
    fn has_layer(&self) -> bool {
        let states = |used| self.maps.has(used);
        let of_maps = states(MapUse::Roughness) || states(MapUse::Metal);
        let is_coated = self.coat.weight.is_some_and(|weight| weight > 0.0);
        self.pr.is_some() || self.pm.is_some() || of_maps || is_coated
    }

    /// Roughness of glass: that which is stated, or else of the picture alone; clear without either.
    fn roughness_of_glass(&self) -> f32 {
        self.pr.unwrap_or(if self.maps.has(MapUse::Roughness) { 1.0 } else { 0.0 })
    }

    /// Layer by which rough glass reflects.
    fn layer_of_glass(&self, optics: Optics) -> Option<MetalRough> {
        let Optics::Glass { index, reflection, is_rough: true, is_thin, .. } = optics else { return None };
        let of_wall = head_on(index.into()) as f32;
        Some(MetalRough {
            base: Vec3::ZERO,
            roughness: self.roughness_of_glass(),
            metallic: 0.0,
            head_on: if is_thin { of_both_walls(of_wall) } else { of_wall },
            // a pane that does not bend light reflects none
            solid: if index == 1.0 { 0.0 } else { reflection.max_element().min(1.0) },
        })
    }

    fn settle_metal_rough(&self, kd: Vec3, optics: Optics, solid: f32) -> Material {
        // without a factor a picture shows as it is
        let of_map = |used, without: f32| if self.maps.has(used) { 1.0 } else { without };
        let without = if self.has_layer() { DEFAULT_ROUGHNESS } else { 1.0 };
        let roughness = self.pr.unwrap_or_else(|| of_map(MapUse::Roughness, without));
        let metallic = self.pm.unwrap_or_else(|| of_map(MapUse::Metal, 0.0));
        // files write a Ni of 1, or 0, for "not known"
        let of_index =
            self.ni.filter(|ni| *ni > 1.0).map_or(DEFAULT_HEAD_ON, |index| head_on(index.into()) as f32);
        let head_on = if self.has_layer() { of_index } else { 0.0 };
        // some files leave Kd black, because metals scatter no light, and give their colour as that of highlights
        let base = match self.ks {
            Some(ks) if metallic > 0.0 && kd == Vec3::ZERO => ks,
            _ => kd,
        };
        Material {
            name: self.name.clone(),
            diffuse: kd * (1.0 - metallic) * solid,
            ambient: self.ka.unwrap_or(kd) * solid,
            specular: Vec3::ZERO,
            emission: self.emission(),
            shininess: 1.0,
            optics,
            metal_rough: Some(MetalRough { base, roughness, metallic, head_on, solid }),
            coat: self.coat.settle(),
            fuzz: self.fuzz.settle(),
            metal_edge: self.metal_edge.unwrap_or(1.0).clamp(0.0, 1.0),
            diffuse_roughness: self.diffuse_roughness(),
            anisotropy: self.anisotropy.settle(),
            scattering: self.scattering(optics),
            ..Material::fallback()
        }
    }

    /// Emission: what a picture of it shows is multiplied by this. Files write a black `Ke` beside a `map_Ke`.
    fn emission(&self) -> Vec3 {
        let stated = self.ke.filter(|ke| *ke != Vec3::ZERO || !self.maps.has(MapUse::Emission));
        stated.unwrap_or(if self.maps.has(MapUse::Emission) { Vec3::ONE } else { Vec3::ZERO })
    }

    /// Effect on the ray from the camera, and the share of the light that the surface itself reflects.
    fn optics(&self, illum: u32, solid: f32) -> (Optics, f32) {
        let tint = self.ks.unwrap_or(Vec3::ONE);
        let filter = self.tf.unwrap_or(Vec3::ONE).min(Vec3::ONE);
        // files leave Ni out, or 0, for "does not bend"
        let index = self.ni.filter(|ni| *ni > 0.0).unwrap_or(1.0);
        let is_thin = self.interior.is_thin();
        match illum {
            3 | 5 | 8 => (Optics::Mirror { tint: self.ks.unwrap_or(Vec3::ZERO), fresnel: illum == 5 }, 1.0),
            // glass by its model alone: the filter says how much comes through
            4 | 6 | 7 | 9 if solid == 1.0 => {
                // a lobe that is too narrow to be seen is none
                let is_rough = self.roughness_of_glass().powi(2) > LEAST_ALPHA;
                let glass =
                    Optics::Glass { transmission: filter, index, reflection: tint, is_rough, is_thin };
                (glass, 1.0 - filter.max_element())
            }
            4 | 6 | 7 | 9 => {
                let transmission = filter * (1.0 - solid);
                let glass = Optics::Glass { transmission, index, reflection: tint, is_rough: false, is_thin };
                (glass, solid)
            }
            _ if solid < 1.0 => {
                // cut-outs and veils: writers of `Tf 0 0 0` with `d` do not mean black
                let filter = if filter == Vec3::ZERO { Vec3::ONE } else { filter };
                (Optics::veil(filter * (1.0 - solid)), solid)
            }
            _ => (Optics::Opaque, 1.0),
        }
    }

    /// Default of Kd, if the file gives none.
    fn default_diffuse(&self, optics: &Optics) -> Vec3 {
        match optics {
            _ if self.maps.has(MapUse::Color) => Vec3::ONE, // the picture as it is
            Optics::Mirror { .. } => Vec3::ZERO,
            Optics::Glass { index, .. } if *index != 1.0 => Vec3::ZERO,
            _ => Material::fallback().diffuse,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;
    use crate::scene::import::mtl::parse;

    fn settled(statements: &str) -> Material {
        let file = parse(format!("newmtl m\n{statements}").as_bytes());
        assert_eq!(file.oddities, [], "{statements}");
        file.materials.into_iter().next().unwrap().settle()
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
        assert_eq!(settled("Ns 1e9").shininess, HIGHEST_SHININESS);
    }
}

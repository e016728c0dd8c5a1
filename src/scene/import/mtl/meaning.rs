//! Meaning of an MTL file's statements to the program that wrote them.
//!
//! MTL has no surfaces as programs know them today. Blender's exporter puts those of its Principled BSDF into statements that mean
//! something else to everybody else (`source/blender/io/wavefront_obj/exporter/obj_export_mtl.cc`): metal becomes `illum 3`, which is a
//! mirror, and its share `Ka`; roughness becomes `Ns`; `illum 9` with `d` is coverage, not glass; and `Kd` beside a `map_Kd` is the
//! colour that the picture replaces. They are put back here. 3ds Max has no header that stays: its `Tf` is known by what it says.

use glam::Vec3;

use super::exporter::Exporter;
use super::statements::Statements;
use super::statements::maps::MapUse;
use crate::scene::keys::material::KdBesideMap;
use crate::scene::material::{Optics, index_of};

/// `Ns` of a surface without roughness, as Blender writes it.
const SMOOTH_NS: f32 = 1000.0;

/// Difference between numbers that a file rounds to three digits.
const OF_ROUNDING: f32 = 1.5e-3;

/// Reflectance at normal incidence for a specular level of 1: Blender's levels, `Ks`, are from 0 to 1.
const HEAD_ON_OF_KS: f32 = 0.08;

impl Exporter {
    /// The statements that mean to this program what these `stated` ones mean to the exporter.
    pub fn meant(self, stated: Statements, kd_beside_map: KdBesideMap) -> Statements {
        let is_blenders = self == Self::Blender;
        let meant = if is_blenders { meant_by_blender(stated) } else { meant_by_max(stated) };
        let is_ignored = match kd_beside_map {
            KdBesideMap::Exporter => is_blenders,
            KdBesideMap::Multiply => false,
            KdBesideMap::Ignore => true,
        };
        // a number that is not stated is 1 beside a picture, which is then taken as it is
        let counts = |used| !is_ignored || !meant.maps.has(used);
        let kd = meant.kd.filter(|_| counts(MapUse::Color));
        let pr = meant.pr.filter(|_| counts(MapUse::Roughness));
        let pm = meant.pm.filter(|_| counts(MapUse::Metal));
        Statements { kd, pr, pm, ..meant }
    }

    /// Returns true if a material states a transmission filter, and is opaque nevertheless.
    pub fn filters_nothing(self, stated: &Statements) -> bool {
        let is_opaque = || {
            let meant = self.meant(stated.clone(), KdBesideMap::default());
            meant.surface().material().optics == Optics::Opaque
        };
        stated.tf.is_some_and(|filter| filter != Vec3::ZERO) && is_opaque()
    }
}

/// What 3ds Max means by `Tf`, if it seems to have written it: the opacity once more, which filters nothing.
fn meant_by_max(stated: Statements) -> Statements {
    let solid = stated.solid();
    let repeats = |filter: &Vec3| (*filter - solid).abs().max_element() < OF_ROUNDING;
    let tf = stated.tf.filter(|filter| solid == 1.0 || !repeats(filter));
    Statements { tf, ..stated }
}

fn meant_by_blender(mut stated: Statements) -> Statements {
    // its names for pictures of roughness and of normals
    for (written, meant) in [(MapUse::Shininess, MapUse::Roughness), (MapUse::Bump, MapUse::Normal)] {
        if let Some(map) = stated.maps[written].take() {
            stated.maps[meant].get_or_insert(map);
        }
    }
    stated.maps[MapUse::Specular] = None;
    let is_metal = matches!(stated.illum, Some(3 | 6));
    let metallic = stated.ka.map_or(1.0, |ka| ka.max_element().min(1.0));
    let level = stated.ks.map_or(0.5, |ks| ks.max_element());
    // `Tf` is the share of transmission; where it is 0, or not stated, light passes by `d` alone
    let transmits = stated.tf.is_some_and(|filter| filter != Vec3::ZERO);
    if transmits {
        // its colour is that of the surface
        let tf = stated.tf.map(|share| share * stated.kd.unwrap_or(Vec3::ONE));
        return Statements { illum: Some(7), ks: None, ka: None, tf, ..stated };
    }
    // no highlight: the surface is matt, unless it states what it is by itself
    if stated.illum.is_some_and(|illum| illum < 2) && stated.pr.is_none() && stated.pm.is_none() {
        return Statements { ka: None, ..stated };
    }
    let roughness = stated.ns.map_or(0.5, |ns| 1.0 - (ns / SMOOTH_NS).clamp(0.0, 1.0).sqrt());
    Statements {
        pr: stated.pr.or(Some(roughness)),
        pm: stated.pm.or(Some(if is_metal { metallic } else { 0.0 })),
        // an index of 1 means that none is stated; so little more reflects nothing that is seen
        ni: Some(index_of((HEAD_ON_OF_KS * level).clamp(1e-7, 0.999))),
        illum: Some(2),
        ka: None,
        ks: None,
        tf: None,
        ..stated
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::super::parse;
    use super::*;
    use crate::scene::Material;

    const BLENDER: &str = "# Blender 5.0.1 MTL File: 'shot.blend'\n# www.blender.org\n\n";

    fn settled(header: &str, statements: &str, rule: KdBesideMap) -> Material {
        let file = parse(format!("{header}newmtl m\n{statements}").as_bytes());
        file.exporter.meant(file.materials.into_iter().next().unwrap(), rule).surface().material()
    }

    #[test]
    fn an_opacity_that_is_stated_twice_filters_nothing() {
        for (statements, transmission) in [
            // as 3ds Max writes it
            ("Tr 0.610\nTf 0.390 0.390 0.390\nillum 7\nNi 1.5", 0.61),
            ("d 0.25\nTf 0.2496 0.25 0.25", 0.75),
            // a filter of its own
            ("d 0.25\nTf 0.5 0.5 0.5", 0.375),
            ("Tf 0.2 0.2 0.2\nillum 7", 0.2),
        ] {
            let optics = settled("", statements, KdBesideMap::Exporter).optics;
            let Optics::Glass { transmission: share, .. } = optics else {
                panic!("{statements}: {optics:?}")
            };
            assert!((share - transmission).abs().max_element() < 1e-6, "{statements}: {share}");
        }
    }

    #[test]
    fn blenders_surfaces_are_what_they_were() {
        let of = |statements: &str| settled(BLENDER, statements, KdBesideMap::Exporter);
        // gold of a roughness of 0.2
        let gold = of("Ns 640\nKa 1 1 1\nKd 1 .8 .3\nKs .5 .5 .5\nKe 0 0 0\nNi 1.45\nd 1\nillum 3");
        let layer = gold.metal_rough.unwrap();
        assert!((layer.roughness - 0.2).abs() < 1e-6 && layer.metallic == 1.0, "{layer:?}");
        assert_eq!((layer.base, gold.optics), (Vec3::new(1.0, 0.8, 0.3), Optics::Opaque));
        // half a metal, half there
        let half = of("Ns 250\nKa .5 .5 .5\nKd 1 1 1\nKs .5 .5 .5\nd .4\nillum 6");
        let layer = half.metal_rough.unwrap();
        assert_eq!((layer.roughness, layer.metallic, layer.solid), (0.5, 0.5, 0.4));
        // plastic reflects 4 % at normal incidence, a level of 1 twice as much
        for (level, head_on) in [(0.5, 0.04), (1.0, 0.08), (0.0, 0.0)] {
            let plastic = of(&format!(
                "Ns 250\nKa 1 1 1\nKd .5 .5 .5\nKs {level} {level} {level}\nNi 1.45\nd 1\nillum 2"
            ));
            let layer = plastic.metal_rough.unwrap();
            assert!((layer.head_on - head_on).abs() < 1e-5 && layer.metallic == 0.0, "{level}: {layer:?}");
            assert_eq!(plastic.ambient, plastic.diffuse, "`Ka` says nothing of ambient light");
        }
        // a veil, and no glass that bends
        let veil = of("Ns 250\nKa 1 1 1\nKd .5 .5 .5\nKs .5 .5 .5\nNi 1.45\nd .4\nillum 9");
        assert!(matches!(veil.optics, Optics::Glass { index: 1.0, .. }), "{:?}", veil.optics);
        assert!(of("Ns 0\nKd .5 .5 .5\nKs 0 0 0\nillum 1").metal_rough.is_none());
        // glass with the statements for PBR
        let glass = of("Ns 1000\nKd 1 .5 1\nKs .5 .5 .5\nNi 1.45\nd 1\nillum 2\nPr 0\nPm 0\nTf 1 1 1");
        let tinted = Optics::clear(Vec3::new(1.0, 0.5, 1.0), 1.45, Vec3::ONE);
        assert_eq!(glass.optics, tinted);
    }

    #[test]
    fn others_mean_what_the_format_says() {
        let max = "# 3ds Max Wavefront OBJ Exporter v0.97b\n";
        let statements = "Ns 10\nKd .5 .5 .5\nKs .5 .5 .5\nTf 1 1 1\nd 1\nillum 2";
        let plain = settled(max, statements, KdBesideMap::Exporter);
        assert_eq!((plain.optics, plain.metal_rough), (Optics::Opaque, None));
        assert_eq!(plain.specular, Vec3::splat(0.5));
    }

    #[test]
    fn kd_beside_a_picture_is_what_the_exporter_or_the_shot_says() {
        use KdBesideMap::{Exporter, Ignore, Multiply};
        for (header, map, rule, expected) in [
            ("", "map_Kd a.png", Exporter, 0.5),
            ("", "map_Kd a.png", Ignore, 1.0),
            (BLENDER, "map_Kd a.png", Exporter, 1.0),
            (BLENDER, "map_Kd a.png", Multiply, 0.5),
            (BLENDER, "", Ignore, 0.5),
        ] {
            let material = settled(header, &format!("Kd .5 .5 .5\nillum 1\n{map}"), rule);
            assert_eq!(material.diffuse, Vec3::splat(expected), "{map} {rule:?} {header}");
        }
    }
}

//! Do layers reflect what their formulas say, one by one and eight at a time, and do coats?

use super::*;
use crate::graph::{Graph, Input, Program};
use crate::lanes::Mask;
use crate::scene::look::Varied;
use crate::scene::material::Coat;
use crate::scene::material::{ByParameter, Computed, Computes};
use crate::shade::area::{AreaRadiance, Beam};
use crate::shade::light::LightSample;
use crate::shade::sampling::PathRandom;

pub(super) fn material(roughness: f32, metallic: f32, base: f32) -> Material {
    let base = Vec3::splat(base);
    let metal_rough = MetalRough { base, roughness, metallic, head_on: 0.04, solid: 1.0 };
    Material { diffuse: base * (1.0 - metallic), metal_rough: Some(metal_rough), ..Material::fallback() }
}

/// Direction at a cosine to the normal, which is Z, in the plane of X.
pub(super) fn at(cos: f32) -> Vec3 {
    at_turn(cos, 0.0)
}

/// Direction at a cosine to the normal, turned about it.
pub(super) fn at_turn(cos: f32, turn: f32) -> Vec3 {
    let across = (1.0 - cos * cos).max(0.0).sqrt();
    Vec3::new(across * turn.cos(), across * turn.sin(), cos)
}

pub(super) fn seen(material: &Material, cos: f32) -> SeenBsdf {
    let bsdfs = Bsdfs::new(std::slice::from_ref(material));
    bsdfs
        .seen(
            Look::plain(0),
            material.painted(),
            SurfaceAxes::of_normals([Vec3::Z; 2]),
            -at(cos),
            SeenBy::Eye,
        )
        .expect("it has a layer")
}

/// Light of a white surface in a white furnace: reflected light, by sampled directions, and scattered
/// light.
fn in_a_furnace(material: &Material, cos: f32) -> Vec3 {
    const COUNT: u32 = 4096;
    let seen = seen(material, cos);
    let random = |index| {
        let [along, above, ..] = PathRandom::new(99, index).four(0);
        [along, above]
    };
    let reflected: Vec3 =
        (0..COUNT).filter_map(|index| seen.reflect(random(index))).map(|ray| ray.weight).sum();
    reflected / COUNT as f32 + material.diffuse * seen.through
}

#[test]
fn a_furnace_is_never_exceeded_and_hardly_darkened() {
    for roughness in [0.0, 0.1, 0.3, 0.5, 0.7, 1.0] {
        for metallic in [0.0, 0.5, 1.0] {
            for cos in [1.0, 0.7, 0.3, 0.1, 0.03] {
                let shown = in_a_furnace(&material(roughness, metallic, 1.0), cos).x;
                let name = format!("roughness {roughness}, metal {metallic}, cosine {cos}");
                assert!(shown < 1.005, "{name}: {shown}");
                assert!(shown > 0.98, "{name}: {shown}");
            }
        }
    }
}

#[test]
fn the_albedo_is_what_rays_bring() {
    for (roughness, metallic, cos) in [(0.2, 0.0, 0.4), (0.5, 1.0, 0.9), (0.9, 1.0, 0.2), (0.05, 0.3, 0.1)] {
        let material = material(roughness, metallic, 0.7);
        let seen = seen(&material, cos);
        let reflected = in_a_furnace(&material, cos) - material.diffuse * seen.through;
        assert!((reflected - seen.albedo).abs().max_element() < 4e-3, "{reflected}, {}", seen.albedo);
    }
}

#[test]
fn head_on_rough_layers_add_what_they_reflect_and_dim_what_is_beneath() {
    // metal, plastic, half of both, and a mirror, whose rays bring what they show
    let materials = [(0.5, 1.0), (0.5, 0.0), (0.5, 0.5), (0.0, 1.0)]
        .map(|(roughness, metallic)| material(roughness, metallic, 0.7));
    let bsdfs = Bsdfs::new(&materials);
    for (number, wanted) in [(0, 0.7), (1, 0.04 + 0.7 * 0.96), (2, 0.02 + 0.35 + 0.35 * 0.96), (3, 0.0)] {
        let diffuse = materials[usize::from(number)].diffuse;
        let all =
            bsdfs.rough_over(&[Look::plain(number); LANES], Vec3x8::splat(diffuse), Vec3x8::splat(diffuse));
        assert!((all.lane(5) - wanted).abs().max_element() < 1e-5, "{number}: {}", all.lane(5));
    }
    let white =
        bsdfs.rough_over(&[Look::plain(1); LANES], Vec3x8::splat(Vec3::ONE), Vec3x8::splat(Vec3::ONE));
    assert!((white.lane(0) - 1.0).abs().max_element() < 1e-5, "white stays white");
    let none = Bsdfs::new(&[Material::fallback()]).rough_over(
        &[Look::plain(0); LANES],
        Vec3x8::ZERO,
        Vec3x8::splat(Vec3::X),
    );
    assert_eq!(none.lane(7), Vec3::X);
}

/// A metal whose edges are not white has its own colour from everywhere, and reflects what is said of it.
#[test]
fn metals_have_the_edges_that_are_stated() {
    for (edge, roughness) in [(0.0, 0.0), (0.0, 0.4), (0.5, 0.6), (1.0, 0.2)] {
        let metal = Material { metal_edge: edge, ..material(roughness, 1.0, 0.3) };
        let seen = seen(&metal, 0.1);
        let brought = in_a_furnace(&metal, 0.1);
        assert!((brought - seen.albedo).abs().max_element() < 4e-3, "{edge} {roughness}: {brought}");
        if roughness == 0.0 {
            assert!((seen.albedo - 0.3).abs().max_element() < 1e-3, "{}", seen.albedo);
        }
    }
}

/// Surfaces below coats: each pair of mirror and rough, metal and plastic below.
fn coated() -> impl Iterator<Item = Material> {
    let coats = [(0.0, 1.0), (0.3, 1.0), (0.5, 0.6)].map(|(roughness, weight)| Coat {
        weight,
        roughness,
        index: 1.5,
        tint: Vec3::new(0.9, 0.7, 0.4),
        darkening: 1.0,
    });
    let below = [(0.0, 1.0), (0.4, 1.0), (0.4, 0.0), (0.7, 0.5)];
    coats.into_iter().flat_map(move |coat| {
        below.map(|(roughness, metallic)| Material { coat: Some(coat), ..material(roughness, metallic, 0.7) })
    })
}

/// What sampled directions bring is what is said to be reflected, in all and by each part.
#[test]
fn coated_surfaces_reflect_what_rays_bring() {
    const COUNT: u32 = 16384;
    let random = |index| {
        let [along, above, ..] = PathRandom::new(7, index).four(0);
        [along, above]
    };
    for (number, material) in coated().enumerate() {
        for cos in [1.0, 0.6, 0.2] {
            let all = seen(&material, cos);
            for (name, part) in [("all", Some(all)), ("rough", all.rough()), ("smooth", all.smooth())] {
                let Some(part) = part else { continue };
                let brought: Vec3 =
                    (0..COUNT).filter_map(|index| part.reflect(random(index))).map(|ray| ray.weight).sum();
                let off = (brought / COUNT as f32 - part.albedo).abs().max_element();
                assert!(off < 8e-3, "{number}, {name}, {cos}: {} {}", brought / COUNT as f32, part.albedo);
            }
            let parts = [all.rough(), all.smooth()].into_iter().flatten().map(|part| part.albedo);
            let sum: Vec3 = parts.sum();
            assert!((sum - all.albedo).abs().max_element() < 1e-5, "{number}, {cos}: {sum} {}", all.albedo);
        }
    }
}

/// The density of directions is one in all, and weights are the reflectance over it.
#[test]
fn coated_surfaces_are_sampled_as_their_densities_say() {
    const COUNT: u32 = 16384;
    for (number, material) in coated().enumerate() {
        let Some(rough) = seen(&material, 0.5).rough() else { continue };
        let (mut sum, mut below) = (0.0, 0);
        for index in 0..COUNT {
            let [along, above, around, up] = PathRandom::new(3, index).four(0);
            match rough.reflect([along, above]) {
                None => below += 1,
                Some(ray) => {
                    let (reflected, density) = rough.towards(ray.direction);
                    assert_eq!(ray.density, Some(density));
                    let off = (ray.weight * density - reflected).abs().max_element();
                    assert!(off <= 1e-4 * reflected.max_element() + 1e-6, "{number}");
                    assert_eq!(rough.density(ray.direction), density);
                }
            }
            // evenly over the half sphere
            let (turn, across) = (around * std::f32::consts::TAU, (1.0 - up * up).sqrt());
            let even = Vec3::new(across * turn.cos(), across * turn.sin(), up);
            sum += f64::from(rough.density(even)) * std::f64::consts::TAU / f64::from(COUNT);
        }
        let in_all = sum + f64::from(below) / f64::from(COUNT);
        assert!((in_all - 1.0).abs() < 0.05, "{number}: {in_all}");
    }
}

/// A white surface stays white below a clear coat, however rough either is.
#[test]
fn a_coat_takes_no_light_in_a_furnace() {
    let clear = |roughness| Coat { weight: 1.0, roughness, index: 1.5, tint: Vec3::ONE, darkening: 1.0 };
    for roughness in [0.0, 0.4] {
        for metallic in [0.0, 1.0] {
            for cos in [1.0, 0.4, 0.1] {
                let coated = Material { coat: Some(clear(roughness)), ..material(0.5, metallic, 1.0) };
                let shown = in_a_furnace(&coated, cos).x;
                assert!((0.98..1.005).contains(&shown), "{roughness} {metallic} {cos}: {shown}");
            }
        }
    }
}

/// Eight coated surfaces are seen, and shine, as each does alone.
#[test]
fn eight_coated_surfaces_are_seen_as_each_is_alone() {
    let materials: Vec<Material> = coated().chain([material(0.3, 0.5, 0.6), Material::fallback()]).collect();
    let bsdfs = Bsdfs::new(&materials);
    let count = materials.len() as u16;
    for round in 0..count {
        let looks: [Look; LANES] = std::array::from_fn(|lane| Look::plain((round + lane as u16 * 3) % count));
        let reflectance = Vec3::new(0.2, 0.5, 0.6);
        let (incoming, light) = (-at(0.7), Vec3::new(-0.5, 0.2, 0.8).normalize());
        let lanes = Vec3x8::splat;
        let rays = LayerRays { count: [2; LANES], followed: u8::MAX, incoming: lanes(incoming) };
        let eight = bsdfs
            .seen_lanes(
                &looks,
                lanes(reflectance),
                SurfaceAxes::of_normals([lanes(Vec3::Z); 2]),
                lanes(incoming),
                Some(rays),
            )
            .expect("some have layers");
        let sample = LightSample {
            to_light: lanes(light),
            direction: lanes(light),
            far: 1.0,
            irradiance: lanes(Vec3::ONE),
            reaches: Mask::ALL,
        };
        let [point, area] =
            [None, Some(AreaRadiance { full: Vec3::splat(2.0), beam: Beam::Even, is_met: true })]
                .map(|radiance| eight.highlight(&sample, radiance));
        for (lane, look) in looks.iter().enumerate() {
            let one =
                bsdfs.seen(*look, reflectance, SurfaceAxes::of_normals([Vec3::Z; 2]), incoming, SeenBy::Eye);
            let Some(one) = one else {
                assert_eq!((eight.through.lane(lane), point.lane(lane)), (Vec3::ONE, Vec3::ZERO));
                continue;
            };
            assert!((eight.through.lane(lane) - one.through).abs().max_element() < 1e-5);
            let near = |found: Vec3, wanted: Vec3| {
                (found - wanted).abs().max_element() <= 2e-3 * wanted.max_element() + 1e-5
            };
            let wanted = one.highlight(light, Vec3::ONE, false).0;
            assert!(near(point.lane(lane), wanted), "{look:?}: {} {wanted}", point.lane(lane));
            // rays show what is a mirror, and of the rest their share
            let (towards, density) = one.rough().map_or((Vec3::ZERO, 0.0), |rough| rough.towards(light));
            let by_points = 2.0 * std::f32::consts::FRAC_1_PI;
            let wanted = towards * std::f32::consts::PI * by_points / (by_points + 2.0 * density);
            assert!(near(area.lane(lane), wanted), "{look:?}: {} {wanted}", area.lane(lane));
        }
    }
}

#[test]
fn a_texture_colours_metal() {
    let mut textured = material(0.4, 1.0, 0.5);
    (textured.diffuse_map, textured.ambient) = (Some(0), Vec3::ZERO);
    let texel = Vec3::new(1.0, 0.5, 0.0);
    let bsdfs = Bsdfs::new(std::slice::from_ref(&textured));
    let of_texture = bsdfs.seen(
        Look::plain(0),
        textured.painted() * texel,
        SurfaceAxes::of_normals([Vec3::Z; 2]),
        -at(0.8),
        SeenBy::Eye,
    );
    assert_eq!(of_texture.expect("it has one").fresnel.metal, (texel * 0.5).to_array());
    let dark = bsdfs
        .seen(Look::plain(0), Vec3::ZERO, SurfaceAxes::of_normals([Vec3::Z; 2]), -at(0.8), SeenBy::Eye)
        .expect("it has one");
    assert_eq!(dark.fresnel.metal, [0.0; 3]);
}

/// What varies is between tables: as near to the layer of that very roughness as these are to the truth.
#[test]
fn a_layer_that_varies_is_that_of_its_parameters() {
    let program = Program::new(&Graph::default(), Input::Constant(Vec3::ONE));
    let mut numbers = ByParameter::default();
    for of in [Computes::Roughness, Computes::Metalness, Computes::Opacity] {
        numbers[of] = Some(0);
    }
    let computed = Computed { program, numbers, opacity: None };
    let varied = Material { computed: Some(Arc::new(computed)), ..material(1.0, 1.0, 0.7) };
    let bsdfs = Bsdfs::new(std::slice::from_ref(&varied));
    for (roughness, metalness, opacity) in
        [(255, 255, 255), (200, 0, 102), (128, 51, 255), (64, 255, 51), (0, 0, 255)]
    {
        let share = |byte: u8| f32::from(byte) / 255.0;
        let mut plain = material(share(roughness), share(metalness), 0.7);
        plain.metal_rough.iter_mut().for_each(|layer| layer.solid = share(opacity));
        let plain_bsdfs = Bsdfs::new(std::slice::from_ref(&plain));
        let look = Look { material: 0, varied: Varied { roughness, metalness, opacity, ..Varied::NONE } };
        for (cos, seen_by) in [(0.9, SeenBy::Eye), (0.2, SeenBy::Eye), (0.5, SeenBy::Path)] {
            let kept = Vec3::splat(0.7);
            let [of_varied, of_plain] =
                [(&bsdfs, look), (&plain_bsdfs, Look::plain(0))].map(|(bsdfs, look)| {
                    bsdfs
                        .seen(look, kept, SurfaceAxes::of_normals([Vec3::Z; 2]), -at(cos), seen_by)
                        .expect("it has a layer")
                });
            let name = format!("{roughness} {metalness} {opacity} {cos} {seen_by:?}");
            assert!((of_varied.alpha - of_plain.alpha).abs() < 1e-6, "{name}");
            assert!((of_varied.albedo - of_plain.albedo).abs().max_element() < 4e-3, "{name}");
            assert!((of_varied.through - of_plain.through).abs().max_element() < 4e-3, "{name}");
        }
        let eight = bsdfs.seen_lanes(
            &[look; LANES],
            Vec3x8::splat(Vec3::splat(0.7)),
            SurfaceAxes::of_normals([Vec3x8::splat(Vec3::Z); 2]),
            Vec3x8::splat(-at(0.6)),
            None,
        );
        let one =
            bsdfs.seen(look, Vec3::splat(0.7), SurfaceAxes::of_normals([Vec3::Z; 2]), -at(0.6), SeenBy::Eye);
        let (eight, one) = (eight.expect("all have one"), one.expect("it has one"));
        assert!((eight.through.lane(3) - one.through).abs().max_element() < 1e-5);
    }
}

#[test]
fn paths_find_smooth_surfaces_rougher_and_no_darker() {
    for (roughness, alpha) in [(0.0, 0.1), (0.25, 0.125), (0.5, 0.3), (0.8, 0.64)] {
        let bsdfs = Bsdfs::new(&[material(roughness, 1.0, 1.0)]);
        let seen = bsdfs
            .seen(Look::plain(0), Vec3::ONE, SurfaceAxes::of_normals([Vec3::Z; 2]), -at(0.6), SeenBy::Path)
            .expect("it has one");
        assert!((seen.alpha - alpha).abs() < 1e-6 && (seen.albedo.x - 1.0).abs() < 1e-3, "{seen:?}");
    }
}

/// Checks that the triangle's own normal reflects light where an interpolated one would send it below the
/// triangle.
#[test]
fn nothing_is_mirrored_below_the_triangle() {
    let bsdfs = Bsdfs::new(&[material(0.0, 1.0, 1.0)]);
    let leaning = Vec3::new(0.9, 0.0, 0.1).normalize();
    for incoming in [-at(0.3), Vec3::new(0.95, 0.0, -0.3).normalize()] {
        let seen = bsdfs
            .seen(
                Look::plain(0),
                Vec3::ONE,
                SurfaceAxes::of_normals([leaning, Vec3::Z]),
                incoming,
                SeenBy::Eye,
            )
            .expect("it has one");
        let ray = seen.reflect([0.5; 2]).expect("a mirror always reflects");
        assert!(ray.direction.z > 0.0 && ray.density.is_none(), "{}", ray.direction);
    }
}

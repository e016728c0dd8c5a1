//! Properties of every environment: densities integrate to 1, and samples follow them.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use std::f64::consts::{PI, TAU};

use super::*;

/// Environments of every kind, with their names.
fn environments() -> Vec<(&'static str, Environment)> {
    let noise = |width: u32, height: u32| {
        let value = |at: u32| {
            let bits = at.wrapping_mul(0x9e37_79b9) >> 16;
            if bits % 5 == 0 { 0.0 } else { (f64::from(bits % 1000) / 500.0).powi(6) as f32 }
        };
        Environment::from_picture(width, height, (0..3 * width * height).map(value).collect()).unwrap()
    };
    let mut spot = vec![0.0; 3 * 64 * 32];
    spot[3 * (7 * 64 + 40)] = 5.0;
    let background =
        Background { zenith: Vec3::new(0.1, 0.2, 0.9), horizon: Vec3::ONE, ground: Vec3::splat(0.05) };
    let evening = Sky { elevation: 4.0, azimuth: 300.0, turbidity: 6.0, ..Sky::default() };
    let dusk = Sky { elevation: -4.0, ground: Vec3::ZERO, ..Sky::default() };
    vec![
        ("noise", noise(32, 16).rotated(77.0).times(3.0)),
        ("narrow", noise(1, 9)),
        ("flat", noise(5, 1)),
        ("spot", Environment::from_picture(64, 32, spot).unwrap().rotated(-100.0)),
        ("black", Environment::from_picture(8, 4, vec![0.0; 96]).unwrap()),
        ("background", Environment::from_background(&background)),
        ("noon", Environment::from_sky(&Sky::default()).rotated(20.0)),
        ("evening", Environment::from_sky(&evening).times(0.5)),
        ("dusk", Environment::from_sky(&dusk)),
    ]
}

/// Creates directions of a grid, even in solid angle, with the solid angle of each.
fn all_around(rows: u32) -> (impl Iterator<Item = Vec3>, f64) {
    let columns = 2 * rows;
    let direction = move |at: u32| {
        let (column, row) = (f64::from(at % columns) + 0.5, f64::from(at / columns) + 0.5);
        let y = 1.0 - 2.0 * row / f64::from(rows);
        let (sin, cos) = (TAU * column / f64::from(columns)).sin_cos();
        let radius = (1.0 - y * y).sqrt();
        glam::DVec3::new(radius * sin, y, radius * cos).as_vec3()
    };
    ((0..rows * columns).map(direction), 4.0 * PI / f64::from(rows * columns))
}

/// Creates two numbers from 0 to 1 in each of `n` x `n` strata.
fn strata(n: u32) -> impl Iterator<Item = [f32; 2]> {
    let jitter = |seed: u32| {
        let bits = (seed ^ (seed >> 16)).wrapping_mul(0x7feb_352d);
        let bits = (bits ^ (bits >> 15)).wrapping_mul(0x846c_a68b);
        ((bits ^ (bits >> 16)) >> 8) as f32 / (1 << 24) as f32
    };
    (0..n * n).map(move |at| {
        [(at % n) as f32 + jitter(2 * at), (at / n) as f32 + jitter(2 * at + 1)].map(|place| place / n as f32)
    })
}

fn mean(color: Vec3) -> f64 {
    f64::from(color.element_sum()) / 3.0
}

const DENSITIES: [SkyDensity; 2] = [SkyDensity::Whole, SkyDensity::Peaks];

/// All environments with both densities.
fn with_densities() -> impl Iterator<Item = (String, Environment, SkyDensity)> {
    let both = |(name, environment): (&'static str, Environment)| {
        DENSITIES.map(|density| (format!("{name}, {density:?}"), environment.clone(), density))
    };
    environments().into_iter().flat_map(both)
}

#[test]
fn densities_integrate_to_one() {
    for (name, environment, density) in with_densities() {
        let (light, grid_light) =
            (|at| environment.light(density, at).pdf, |at| environment.grid_light(density, at).pdf);
        let (directions, solid_angle) = all_around(1000);
        let of_grid: f64 = directions.map(|at| f64::from(grid_light(at))).sum::<f64>() * solid_angle;
        assert!((of_grid - 1.0).abs() < 0.01, "{name}: {of_grid}");
        // the sun's part by itself: its disk is finer than these directions
        if let Some(sun) = environment.sun() {
            let is_beside = |at: &Vec3| grid_light(*at) > 0.0 && sun.light(*at) == LightFrom::NONE;
            let beside = all_around(100).0.find(is_beside).unwrap();
            let pdf = f64::from(light(beside) / grid_light(beside));
            let of_sun = f64::from(light(sun.to_sun) - grid_light(sun.to_sun) * pdf as f32);
            let whole = of_sun * f64::from(sun.solid_angle()) + pdf * of_grid;
            assert!((whole - 1.0).abs() < 0.01, "{name}: {whole}");
        }
    }
}

#[test]
fn samples_estimate_the_integral_of_what_shines() {
    for (name, environment) in environments() {
        let (directions, solid_angle) = all_around(1000);
        // smooth weights, so that wrong directions show
        let weight = |at: Vec3| f64::from(1.5 + at.x + 0.3 * at.y * at.z);
        let mut expected: f64 = directions
            .map(|at| mean(environment.grid_light(SkyDensity::Whole, at).radiance) * weight(at))
            .sum::<f64>()
            * solid_angle;
        if let Some(sun) = environment.sun() {
            expected += mean(sun.radiance * sun.solid_angle()) * weight(sun.to_sun);
        }
        let n = 400;
        let estimate = strata(n).map(|random| {
            let direction = environment.sample(SkyDensity::Whole, random);
            let LightFrom { radiance, pdf } = environment.light(SkyDensity::Whole, direction);
            assert!((direction.length() - 1.0).abs() < 1e-5 && pdf.is_finite() && pdf > 0.0, "{name}: {pdf}");
            mean(radiance) * weight(direction) / f64::from(pdf)
        });
        let estimate = estimate.sum::<f64>() / f64::from(n * n);
        assert!((estimate - expected).abs() <= 0.01 * expected, "{name}: {estimate}, not {expected}");
    }
}

#[test]
fn samples_fall_where_the_density_says() {
    // 12 x 6 fields of the sphere, each of the same solid angle
    let field = |at: Vec3| {
        let around = (0.5 + f64::from(at.z.atan2(at.x)) / TAU) * 12.0;
        (around as usize).min(11) + 12 * ((f64::from(1.0 - at.y) * 3.0) as usize).min(5)
    };
    for (name, environment, density) in with_densities() {
        let mut expected = [0.0; 72];
        let (directions, solid_angle) = all_around(900);
        for at in directions {
            expected[field(at)] += f64::from(environment.grid_light(density, at).pdf) * solid_angle;
        }
        let mut found = [0.0; 72];
        let n = 400;
        strata(n).for_each(|random| {
            found[field(environment.sample_grid(density, random))] += 1.0 / f64::from(n * n)
        });
        for (number, (found, expected)) in found.iter().zip(expected).enumerate() {
            // what is expected is a sum, and coarse where texels end
            assert!(
                (found - expected).abs() < 4e-3 + 0.03 * expected,
                "{name}, field {number}: {found}, not {expected}"
            );
        }
    }
}

#[test]
fn what_shines_can_be_found() {
    for (name, environment) in environments() {
        let (directions, _) = all_around(300);
        let lost = directions.map(|at| environment.light(SkyDensity::Whole, at));
        let lost = lost.filter(|light| light.radiance.max_element() > 0.0 && light.pdf <= 0.0);
        assert_eq!(lost.count(), 0, "{name}");
    }
}

/// Rays that paths accompany ask for what is brighter than the mean; for an even light, which paths find better, there are none.
#[test]
fn peaks_are_what_is_brighter_than_the_mean() {
    let even = |sun: Option<Sun>| Environment::new(Grid::new(8, 4, vec![0.5; 96]).unwrap(), sun);
    assert!(!even(None).has_peaks());
    assert!(!Environment::from_background(&Background::uniform(Vec3::ONE)).has_peaks());
    let without: Vec<_> =
        environments().into_iter().filter(|(_, environment)| !environment.has_peaks()).collect();
    assert_eq!(without.iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["black"]);

    let sun = Sun::of_irradiance(Vec3::Y, 0.53, Vec3::ONE);
    let sunny = even(Some(sun));
    assert!(sunny.has_peaks());
    assert!(strata(9).all(|random| sunny.sample(SkyDensity::Peaks, random).distance(Vec3::Y) < 0.01));
    assert_eq!(sunny.light(SkyDensity::Peaks, Vec3::X).pdf, 0.0);

    // a dark half and a bright one, which a row of texels blends
    let texel = |at: usize| if at < 16 * 8 { [3.0; 3] } else { [1.0; 3] };
    let halves = Environment::from_picture(16, 16, (0..16 * 16).flat_map(texel).collect()).unwrap();
    assert!(strata(9).all(|random| halves.sample(SkyDensity::Peaks, random).y > -0.2));
    let [above, below] = [Vec3::Y, Vec3::NEG_Y].map(|at| halves.light(SkyDensity::Peaks, at).pdf);
    assert!((above * TAU as f32 - 1.0).abs() < 0.1 && below == 0.0, "{above} {below}");
}

#[test]
fn one_bright_texel_of_a_large_map_is_found_by_every_sample() {
    let [width, height] = [4096, 2048];
    let mut texels = vec![0.0; 3 * width * height];
    let [column, row] = [3000, 1999];
    texels[3 * (row * width + column) + 1] = 1000.0;
    let environment = Environment::from_picture(width as u32, height as u32, texels).unwrap();
    let theta = PI * (row as f64 + 0.5) / height as f64;
    let phi = TAU * ((column as f64 + 0.5) / width as f64 - 0.5);
    let middle = glam::DVec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos()).as_vec3();
    assert!((environment.radiance(middle).y - 1000.0).abs() < 5.0, "{}", environment.radiance(middle));
    for random in strata(32).chain([[0.0, 0.0], [1.0, 1.0], [0.999_999_94, 0.0], [f32::NAN, 2.0]]) {
        let direction = environment.sample(SkyDensity::Whole, random);
        // within the texel and its neighbours
        assert!(direction.distance(middle) < 2.5 * PI as f32 / height as f32, "{random:?}: {direction}");
    }
    // in single floats places of so large a map are known to some thousandths of a texel: at its rim rounding decides
    let light = |random| environment.light(SkyDensity::Whole, environment.sample(SkyDensity::Whole, random));
    let is_lost = |random: &[f32; 2]| light(*random).pdf <= 1e4;
    let lost = strata(32).filter(is_lost).count();
    assert!(lost <= 3, "{lost} of 1,024");
}

#[test]
fn dim_and_bright_beside_each_other_stay_finite() {
    let texels = [[f32::MAX; 3], [0.0; 3], [f32::MIN_POSITIVE; 3], [1e-45, 0.0, 0.0]];
    let texels = texels.as_flattened().to_vec();
    let environment = Environment::from_picture(4, 1, texels).unwrap().times(f32::MAX);
    for (random, density) in strata(16).flat_map(|random| DENSITIES.map(|density| (random, density))) {
        let LightFrom { radiance, pdf } = environment.light(density, environment.sample(density, random));
        assert!(radiance.is_finite() && pdf.is_finite() && pdf > 0.0, "{radiance} {pdf}");
    }
    for odd in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY] {
        // of no meaning, but no panic
        let _ = DENSITIES.map(|density| environment.light(density, odd));
    }
}

#[test]
fn a_black_one_is_sampled_evenly() {
    let black = Environment::from_picture(16, 8, vec![0.0; 384]).unwrap();
    assert!(black.is_black());
    let even = 1.0 / (4.0 * PI as f32);
    for random in strata(16) {
        let LightFrom { radiance, pdf } =
            black.light(SkyDensity::Whole, black.sample(SkyDensity::Whole, random));
        assert!((pdf / even - 1.0).abs() < 1e-4, "{pdf}");
        assert_eq!(radiance, Vec3::ZERO);
    }
    let dark = Environment::from_sky(&Sky::default()).times(0.0);
    assert!(
        dark.is_black()
            && dark.radiance(Vec3::Y) == Vec3::ZERO
            && dark.light(SkyDensity::Whole, Vec3::Y).pdf > 0.0
    );
    assert!(!Environment::from_sky(&Sky::default()).is_black());
}

#[test]
fn rotation_turns_as_models_do_and_power_multiplies() {
    // bright at -Z
    let mut texels = vec![0.0; 3 * 16 * 8];
    for texel in [3 * 16 + 7, 3 * 16 + 8, 4 * 16 + 7, 4 * 16 + 8] {
        texels[3 * texel] = 1.0;
    }
    let plain = Environment::from_picture(16, 8, texels).unwrap();
    assert_eq!(plain.radiance(Vec3::NEG_Z), Vec3::X);
    let turned = plain.clone().rotated(90.0).times(3.0);
    assert_eq!(turned.radiance(Vec3::NEG_Z), Vec3::ZERO);
    assert!(
        turned.radiance(Vec3::NEG_X).abs_diff_eq(3.0 * Vec3::X, 1e-4),
        "{}",
        turned.radiance(Vec3::NEG_X)
    );
    assert!(
        (turned.light(SkyDensity::Whole, Vec3::NEG_X).pdf - plain.light(SkyDensity::Whole, Vec3::NEG_Z).pdf)
            .abs()
            < 1e-4
    );
    assert!(Arc::ptr_eq(&plain.grid, &turned.grid), "one grid for all");
    let back = turned.rotated(-90.0 + 36_000.0).times(1.0 / 3.0);
    assert!(back.radiance(Vec3::NEG_Z).abs_diff_eq(Vec3::X, 1e-4));

    let sky = Sky { elevation: 30.0, azimuth: 0.0, ..Sky::default() };
    let turned = Environment::from_sky(&sky).rotated(90.0).times(2.0);
    let (plain, to_sun) = (Environment::from_sky(&sky), turned.sun().unwrap().to_sun);
    assert!(to_sun.x < -0.8 && to_sun.z.abs() < 1e-6, "{to_sun}");
    let [seen, expected] = [turned.radiance(to_sun), 2.0 * plain.radiance(plain.sun().unwrap().to_sun)];
    assert!((seen / expected - 1.0).abs().max_element() < 1e-3, "{seen} {expected}");
}

#[test]
fn a_gradient_shines_as_the_background_does() {
    let background =
        Background { zenith: Vec3::new(0.1, 0.2, 0.9), horizon: Vec3::ONE, ground: Vec3::splat(0.05) };
    let environment = Environment::from_background(&background);
    let (directions, _) = all_around(200);
    for at in directions {
        let (found, expected) = (environment.radiance(at), background.radiance(at));
        assert!(found.abs_diff_eq(expected, 0.03), "{at}: {found}, not {expected}");
    }
}

#[test]
fn pictures_that_are_none_are_told_with_the_pixel() {
    let error = |width, height, texels: &[f32]| {
        Environment::from_picture(width, height, texels.to_vec()).unwrap_err().to_string()
    };
    for (width, height, values) in [(0, 4, 0), (4, 0, 0), (2, 1, 5), (2, 1, 7), (u32::MAX, u32::MAX, 3)] {
        assert!(error(width, height, &vec![1.0; values]).contains("three for each"), "{width}x{height}");
    }
    for (value, words) in [
        (-1.0, "negative value -1 in channel B of pixel (1, 2)"),
        (f32::NAN, "the value NaN in channel B of pixel (1, 2)"),
        (f32::INFINITY, "the value inf in channel B of pixel (1, 2)"),
    ] {
        let mut texels = vec![1.0; 3 * 4 * 3];
        texels[3 * (2 * 4 + 1) + 2] = value;
        assert!(error(4, 3, &texels).contains(words), "{}", error(4, 3, &texels));
    }
}

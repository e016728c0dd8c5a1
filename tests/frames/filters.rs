//! Do all filters give pictures of the right brightness, and are frames of reused samples exact with each of them?

use std::path::Path;

use afterimage::frame::Finished;
use afterimage::layers::Layers;
use afterimage::scene;
use afterimage::settings::{Filter, Mode, Settings};
use glam::{DVec3, Vec3};

use crate::blur::with_lens;
use crate::toy;
use crate::toy::worlds::*;

#[test]
fn reuse_is_exact_with_every_filter() {
    let scene = with_camera(with_flyer(world()), goes(EYE, EYE + DVec3::X), rests(TARGET));
    for (filter, radius) in
        Filter::WIDE.into_iter().flat_map(|filter| [None, Some(3.5)].map(|radius| (filter, radius)))
    {
        for samples in [1, 3] {
            let small = Settings { width: 48, height: 36, ..toy::audited(samples) };
            let settings = Settings { filter, filter_radius: radius, ..small };
            for frame in toy::render(&scene, &settings, 3) {
                assert_eq!(toy::differing(&frame), 0, "{filter:?}, {samples}");
                let planes = &frame.film.planes;
                let is_finite =
                    planes.iter().all(|plane| plane.values.to_floats().iter().all(|value| value.is_finite()));
                assert!(is_finite, "{filter:?}, {radius:?}, {samples}");
            }
        }
    }
}

/// Their samples are in the centres of their cells; with a lens, in those of windows that are shifted.
#[test]
fn areas_show_frames_that_are_traced_in_full_as_the_box_does() {
    for (scene, samples) in [(world(), 1), (world(), 2), (with_lens(with_flyer(world()), 0.2), 2)] {
        let [own, spread] = [Filter::Box, Filter::Area].map(|filter| {
            let settings =
                Settings { filter, mode: Mode::Full, exposures: Some(4), ..toy::settings(samples) };
            toy::render(&scene, &settings, 1).remove(0).film.values("G").unwrap()
        });
        let off = own.iter().zip(&spread).map(|(own, spread)| (own - spread).abs()).fold(0.0, f32::max);
        assert!(off < 2e-3 && own.iter().any(|value| *value > 0.1), "{samples}: {off}");
    }
}

/// Before a camera at rest most tiles are left as they are: those that a wider filter reaches must not be.
#[test]
fn a_film_at_rest_is_what_it_would_be_if_it_were_made_anew() {
    let scene = with_flyer(matt_world());
    for (filter, radius) in [
        (Filter::Area, None),
        (Filter::Tent, Some(0.75)),
        (Filter::Lanczos, Some(3.0)),
        (Filter::Gaussian, Some(4.0)),
    ] {
        let settings = Settings { filter, filter_radius: radius, ..toy::audited(2) };
        let kept = toy::render(&scene, &settings, 5);
        for kept in kept {
            assert_eq!(toy::differing(&kept), 0, "{filter:?}");
        }
    }
}

/// Bright wires of little more than a pixel before a wall, which the camera passes: frames that reuse samples show as much of them as those
/// that are traced in full, whatever the filter; also where a silhouette lies at the border of two tiles.
#[test]
fn silhouettes_are_where_frames_in_full_have_them() {
    let size = [96.0, 72.0_f32];
    let pixel = 2.0 * 6.0 * 30.0_f32.to_radians().tan() / size[1];
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for number in -12..=12_i32 {
        let (x, lean, half) =
            (number as f32 * 0.71, [0.0, 0.4, -0.7][number.rem_euclid(3) as usize], 0.55 * pixel);
        let first = corners.len() as u32;
        corners.extend([[x - lean - half, -6.0, 0.0], [x - lean + half, -6.0, 0.0]]);
        corners.extend([[x + lean + half, 6.0, 0.0], [x + lean - half, 6.0, 0.0]]);
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    let wall = [[-30.0, -20.0, -2.0], [30.0, -20.0, -2.0], [30.0, 20.0, -2.0], [-30.0, 20.0, -2.0]];
    let models = vec![
        toy::still("wall", toy::mesh(&wall, &[[0, 1, 2], [0, 2, 3]], 0, true), Vec3::ZERO),
        toy::still("wires", toy::mesh(&corners, &triangles, 1, true), Vec3::ZERO),
    ];
    let bright = afterimage::scene::Material { emission: Vec3::ONE, ..toy::matt(0.0) };
    let along = |z: f64| toy::keys(&[(1.0, DVec3::new(0.0, 0.0, z)), (25.0, DVec3::new(1.1, 0.1, z))]);
    let camera = toy::camera(along(6.0), along(0.0));
    let scene = toy::scene(camera, models, vec![toy::matt(0.0), bright], vec![]);
    for filter in [Filter::Box, Filter::Area, Filter::Tent, Filter::Gaussian, Filter::Mitchell] {
        let of = |mode| {
            let settings = Settings { filter, mode, layers: Layers::NONE, ..toy::settings(2) };
            let light = |frame: &Finished| frame.film.values("R").unwrap().iter().sum::<f32>();
            toy::render(&scene, &settings, 16).iter().map(light).collect::<Vec<f32>>()
        };
        let (inferred, full) = (of(Mode::Reproject), of(Mode::Full));
        let ratios: Vec<f32> = inferred.iter().zip(full).map(|(inferred, full)| inferred / full).collect();
        println!("{filter:?}: {ratios:.4?}");
        assert!(ratios.iter().all(|ratio| (ratio - 1.0).abs() < 0.01), "{filter:?}: {ratios:.4?}");
    }
}

/// Filters differ at edges. What is flat, and the mean of a whole picture, they leave as it is.
#[test]
fn no_filter_makes_a_picture_brighter() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/analytic/analytic.toml");
    let shot = scene::load(&path, true).unwrap();
    let mean = |filter, samples| {
        let settings = Settings { filter, samples, mode: Mode::Full, ..toy::settings(1) };
        let film = toy::render(&shot.scene, &settings, 1).remove(0).film;
        let sum =
            |name: &str| film.values(name).unwrap().iter().sum::<f32>() / (film.width * film.height) as f32;
        Vec3::new(sum("R"), sum("G"), sum("B"))
    };
    for samples in [1, 2, 4] {
        let by_box = mean(Filter::Box, samples);
        for filter in Filter::WIDE {
            let off = (mean(filter, samples) / by_box - 1.0).abs().max_element();
            assert!(off < 0.02, "{filter:?}, {samples}: {off}");
        }
    }
}

/// A dark half plane before a bright one, seen through 4 x 4 samples a pixel: how many pixels of a row are between the two.
#[test]
fn wider_filters_are_softer_and_lobes_make_edges_sharp() {
    let wall = |left: f32, right: f32, material| {
        let corners = [[left, -9.0, 0.0], [right, -9.0, 0.0], [right, 9.0, 0.0], [left, 9.0, 0.0]];
        toy::mesh(&corners, &[[0, 1, 2], [0, 2, 3]], material, true)
    };
    let bright = afterimage::scene::Material { emission: Vec3::ONE, ..toy::matt(0.0) };
    let models = vec![
        toy::still("dark", wall(-20.0, 0.013, 0), Vec3::ZERO),
        toy::still("bright", wall(0.013, 20.0, 1), Vec3::ZERO),
    ];
    let camera = toy::camera(rests(DVec3::new(0.0, 0.0, 4.0)), rests(DVec3::ZERO));
    let scene = toy::scene(camera, models, vec![toy::matt(0.0), bright], vec![]);
    let row = |filter, radius| {
        let settings = Settings { filter, filter_radius: radius, ..toy::settings(4) };
        let red = toy::render(&scene, &settings, 1).remove(0).film.values("R").unwrap();
        red[36 * 96..37 * 96].to_vec()
    };
    let between = |row: &[f32]| row.iter().filter(|value| (0.02..0.98).contains(*value)).count();
    let [narrow, wide] = [0.75, 3.0].map(|radius| between(&row(Filter::Gaussian, Some(radius))));
    assert!(narrow <= 2 && wide >= 3, "{narrow}, {wide}");
    let over = |filter| row(filter, None).iter().any(|value| *value > 1.004);
    assert_eq!(Filter::WIDE.map(over), [false, false, false, true, false, true], "which of them overshoot");
}

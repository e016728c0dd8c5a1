//! Is a part of a picture the part of the picture, and is the picture the same with overscan around it? To the bit, in all
//! layers.

use afterimage::film::Film;
use afterimage::frame::Renderer;
use afterimage::scene::Scene;
use afterimage::settings::{Budget, Filter, Mode, PixelRect, Settings};
use afterimage::trace::BackendKind;
use glam::DVec3;

use crate::toy;
use crate::toy::worlds::*;

/// No whole number of tiles, whatever the samples.
const SIZE: [u32; 2] = [101, 67];

fn rect(x: i32, y: i32, width: u32, height: u32) -> PixelRect {
    PixelRect { x, y, width, height }
}

/// Shadows, mirrors, glass, gathered light, occlusion and motion, before a camera that moves.
fn scene() -> Scene {
    let scene = with_camera(world(), goes(EYE, EYE + DVec3::new(1.0, 0.2, -1.5)), rests(TARGET));
    with_area_lights(with_flyer(scene))
}

fn settings(samples: u32, filter: Filter) -> Settings {
    let [width, height] = SIZE;
    Settings { width, height, filter, mode: Mode::Full, paths: 2, occlusion_rays: 4, ..toy::audited(samples) }
}

fn film(settings: &Settings, kind: BackendKind) -> Film {
    let scene = scene();
    let mut renderer = Renderer::with(kind, &scene, settings).expect("the scene builds");
    let finished = renderer.render(3, false).expect("the frame renders");
    let audit = finished.stats.audit.expect("asked for");
    assert_eq!(audit.wrong(), 0, "{:?}: {audit:?}", settings.data_window());
    Film::clone(&finished.film)
}

/// Demands that two films, of these windows, show the same where both have pixels.
fn assert_same_pixels((film, of): (&Film, PixelRect), (other, of_other): (&Film, PixelRect), what: &str) {
    assert_eq!([film.width, film.height], [of.width, of.height]);
    let names = |film: &Film| film.planes.iter().map(|plane| plane.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(film), names(other));
    let mut shared = 0;
    for (plane, of_plane) in film.planes.iter().zip(&other.planes) {
        for y in of.y.max(of_other.y)..(of.y + of.height as i32).min(of_other.y + of_other.height as i32) {
            for x in of.x.max(of_other.x)..(of.x + of.width as i32).min(of_other.x + of_other.width as i32) {
                let at = |of: PixelRect| ((y - of.y) as u32 * of.width + (x - of.x) as u32) as usize;
                let values = [plane.values.get(at(of)), of_plane.values.get(at(of_other))];
                assert!(
                    values[0].to_bits() == values[1].to_bits(),
                    "{what}: {} {x} {y}: {values:?}",
                    plane.name
                );
                shared += 1;
            }
        }
    }
    assert!(shared > 0, "{what}");
}

#[test]
fn a_crop_is_the_part_of_the_picture() {
    let crops = [rect(0, 0, 1, 1), rect(33, 17, 31, 23), rect(60, 50, 41, 17), rect(0, 64, 101, 3)];
    for (samples, filter) in
        [(1, Filter::Box), (2, Filter::Box), (2, Filter::Mitchell), (3, Filter::Mitchell)]
    {
        for kind in [BackendKind::Embree, BackendKind::Rust] {
            let whole = settings(samples, filter);
            let picture = film(&whole, kind);
            for crop in crops {
                let part = Settings { crop: Some(crop), ..whole.clone() };
                let what = format!("{crop} {samples} {filter:?} {kind:?}");
                assert_same_pixels((&film(&part, kind), crop), (&picture, whole.data_window()), &what);
            }
        }
    }
}

#[test]
fn the_picture_is_the_same_with_overscan() {
    for (samples, filter) in [(1, Filter::Mitchell), (2, Filter::Box), (2, Filter::Mitchell)] {
        for kind in [BackendKind::Embree, BackendKind::Rust] {
            let whole = settings(samples, filter);
            let picture = film(&whole, kind);
            for overscan in [1, 20] {
                let around = Settings { overscan, ..whole.clone() };
                let more = film(&around, kind);
                let what = format!("{overscan} {samples} {filter:?} {kind:?}");
                assert_same_pixels((&more, around.data_window()), (&picture, whole.data_window()), &what);
                // and a crop of both
                let crop = rect(-1, 40, 40, 28);
                let part = Settings { crop: Some(crop), ..around.clone() };
                assert_same_pixels((&film(&part, kind), crop), (&more, around.data_window()), &what);
            }
        }
    }
}

#[test]
fn what_is_around_the_picture_is_what_a_larger_picture_shows() {
    // the same camera, twice as wide an angle: the picture is the middle of the larger one
    let larger_scene = |scale: f64| {
        let mut scene = matt_world();
        let half = (30.0_f64.to_radians()).tan() * scale;
        scene.camera.fov = toy::keys(&[(1.0, 2.0 * half.atan().to_degrees())]);
        scene
    };
    let film = |scale: f64, settings: &Settings| {
        let scene = larger_scene(scale);
        let mut renderer = Renderer::new(&scene, settings).expect("the scene builds");
        renderer.render(1, false).expect("the frame renders")
    };
    let small = Settings { overscan: 36, width: 96, height: 72, ..settings(1, Filter::Box) };
    let large = Settings { overscan: 0, width: 168, height: 144, ..small.clone() };
    let (small, large) = (film(1.0, &small), film(2.0, &large));
    let [ids, wanted] = [&small, &large].map(|finished| finished.film.values("object.V").expect("asked for"));
    assert_eq!(ids.len(), wanted.len());
    let off = ids.iter().zip(&wanted).filter(|(a, b)| a != b).count();
    assert!(off * 1000 < ids.len(), "{off} of {}: rounding at edges", ids.len());
    let around = (0..ids.len()).filter(|at| *at % 168 < 36 && ids[*at] != wanted[0]).count();
    assert!(around > 100, "there is something to see around the picture");
}

#[test]
fn a_crop_costs_as_much_as_the_tiles_that_it_touches() {
    let whole = settings(2, Filter::Box);
    let crop = rect(33, 17, 31, 23);
    let scene = scene();
    let primary = |settings: &Settings| {
        let mut renderer = Renderer::new(&scene, settings).expect("the scene builds");
        renderer.render(3, false).expect("the frame renders").stats.rays.primary
    };
    assert_eq!(primary(&whole), 101 * 67 * 4);
    // tiles have 16 x 16 pixels: columns 32 to 63, rows 16 to 47
    assert_eq!(primary(&Settings { crop: Some(crop), ..whole }), 32 * 32 * 4);
}

#[test]
fn a_share_of_a_budget_is_that_of_the_whole_picture() {
    let whole =
        Settings { paths: 16, paths_per_frame: 1, budget: Budget::Rays(200_000), ..settings(1, Filter::Box) };
    let crop = rect(33, 17, 31, 23);
    let part = Settings { crop: Some(crop), ..whole.clone() };
    let kind = BackendKind::Embree;
    assert_same_pixels((&film(&part, kind), crop), (&film(&whole, kind), whole.data_window()), "budget");
}

#[test]
fn chains_are_exact_with_any_window_and_any_number_of_threads() {
    let scene = scene();
    let crop = Some(rect(33, 17, 31, 23));
    for (overscan, crop, filter) in
        [(0, crop, Filter::Mitchell), (20, None, Filter::Box), (20, None, Filter::Mitchell)]
    {
        let settings = Settings { overscan, crop, mode: Mode::Reproject, ..settings(1, filter) };
        let films = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
            let frames = pool.install(|| toy::render(&scene, &settings, FRAMES));
            for frame in &frames {
                let audit = frame.stats.audit.expect("asked for");
                assert_eq!(audit.wrong(), 0, "{overscan} {crop:?}: frame {}: {audit:?}", frame.stats.frame);
                assert!(audit.on_edge * 100 < audit.checked, "{audit:?}");
            }
            let reused: u64 = frames.iter().map(|frame| frame.stats.samples.good).sum();
            assert!(reused > 0, "or nothing is tested");
            frames.into_iter().map(|frame| Film::clone(&frame.film)).collect::<Vec<_>>()
        });
        assert!(films[0] == films[1], "{overscan} {crop:?}");
    }
}

#[test]
fn a_camera_at_rest_keeps_what_stays_the_same_in_any_window() {
    let scene = with_flyer(world());
    for (overscan, crop, filter) in [
        (0, Some(rect(33, 17, 31, 23)), Filter::Mitchell),
        (20, None, Filter::Mitchell),
        (20, None, Filter::Box),
    ] {
        let settings = Settings { overscan, crop, mode: Mode::Reproject, ..settings(1, filter) };
        let mut renderer = Renderer::new(&scene, &settings).expect("the scene builds");
        for frame in 1..=FRAMES {
            let finished = renderer.render(frame, true).expect("the frame renders");
            let audit = finished.stats.audit.expect("asked for");
            assert_eq!(audit.wrong(), 0, "{overscan} {crop:?}: frame {frame}: {audit:?}");
        }
    }
}

//! Two eyes: is each exact, is it what a camera in its place sees, and what do files and reports say of them?

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use afterimage::animation::Track;
use afterimage::exposure::Shutter;
use afterimage::film::Film;
use afterimage::frame::{Finished, Renderer};
use afterimage::layers::Layers;
use afterimage::scene::Scene;
use afterimage::scene::camera::{EyeTrack, Lens};
use afterimage::settings::{Budget, Filter, Mode, PixelRect, Refinement, Reuse, Settings};
use afterimage::stats::FrameStats;
use afterimage::stereo::{Eye, Stereo};
use glam::DVec3;
use openexr::Attribute;

use crate::runs::{Place, Ran, analytic};
use crate::toy;
use crate::toy::worlds::*;

const STEREO: Stereo = Stereo { separation: 0.25, convergence: Some(6.0) };

fn settings(samples: u32) -> Settings {
    Settings { stereo: Some(STEREO), ..toy::settings(samples) }
}

fn both(renderer: &mut Renderer, frame: i32, reuse: bool) -> [Finished; 2] {
    Eye::BOTH.map(|eye| renderer.render_eye(eye, frame, reuse).unwrap())
}

/// Both eyes of frames `1..=FRAMES`, each inferred from the one before it, unless all are to be traced in full.
fn render(scene: &Scene, settings: &Settings) -> Vec<[Finished; 2]> {
    let mut renderer = Renderer::new(scene, settings).unwrap();
    assert_eq!(renderer.eyes(), Eye::BOTH);
    (1..=FRAMES).map(|frame| both(&mut renderer, frame, settings.mode != Mode::Full)).collect()
}

/// Demands an audit without a difference; gives the share of the right eye's samples that came from the left eye, in those
/// frames in which any did.
fn audited(scene: &Scene, settings: &Settings) -> f64 {
    let frames = render(scene, &Settings { audit: true, ..settings.clone() });
    let (mut reused, mut all) = (0, 0);
    for finished in frames.iter().flatten() {
        let (stats, audit) = (&finished.stats, finished.stats.audit.unwrap());
        let (frame, eye) = (stats.frame, stats.eye.unwrap());
        assert_eq!(audit.wrong(), 0, "frame {frame}, {eye:?}: {audit:?}");
        assert!(audit.on_edge * 200 < audit.checked, "frame {frame}, {eye:?}: {audit:?}");
        if stats.from_left {
            assert_eq!(eye, Eye::Right);
            (reused, all) = (reused + stats.samples.reused(), all + stats.samples.total());
        }
    }
    assert!(all > 0, "or nothing is compared");
    reused as f64 / all as f64
}

/// In base frames and inferred ones, before a camera that moves or rests, with adaptive samples, exposures and two eyes.
#[test]
fn a_watcher_is_told_of_each_tile_once_a_frame() {
    let refinement = Some(Refinement { most: 4, threshold: 0.1 });
    let shutter = Some(Shutter::new(-0.25, 0.25));
    for settings in [
        toy::settings(2),
        settings(1),
        Settings { filter: Filter::Mitchell, ..toy::settings(1) },
        Settings { refinement, ..toy::settings(1) },
        Settings { shutter, exposures: Some(3), refinement, ..settings(1) },
    ] {
        let mut scene = world();
        for rests in [false, true] {
            if rests {
                scene.camera.eye = EyeTrack::constant(scene.camera.eye.at(1.0));
            }
            let mut renderer = Renderer::new(&scene, &settings).unwrap();
            let told = Arc::new(AtomicUsize::new(0));
            let count = Arc::clone(&told);
            let watch = move |tiles| {
                count.fetch_add(tiles, Ordering::Relaxed);
            };
            renderer.watch(Some(Arc::new(watch)));
            for frame in 1..=3 {
                for eye in renderer.eyes() {
                    renderer.render_eye(*eye, frame, true).unwrap();
                }
                assert_eq!(told.swap(0, Ordering::Relaxed), renderer.tiles_a_frame(), "{frame} {settings:?}");
            }
        }
    }
}

fn planes(film: &Film) -> Vec<(String, Vec<u32>)> {
    let bits = |values: Vec<f32>| values.into_iter().map(f32::to_bits).collect();
    film.planes.iter().map(|plane| (plane.name.to_string(), bits(plane.values.to_floats()))).collect()
}

#[track_caller]
fn assert_same(one: &Finished, other: &Finished, what: &str) {
    for ((name, one), (_, other)) in planes(&one.film).into_iter().zip(planes(&other.film)) {
        let off = one.iter().zip(&other).filter(|(one, other)| one != other).count();
        assert_eq!((one.len(), off), (other.len(), 0), "{what}: {name}");
    }
}

#[test]
fn both_eyes_are_exact_whatever_moves() {
    let still = with_flyer(world());
    let moves = with_camera(still.clone(), goes(EYE, EYE + DVec3::new(0.4, -0.2, -0.5)), rests(TARGET));
    let turns = with_camera(still.clone(), rests(EYE), goes(TARGET, TARGET + DVec3::X));
    let scenes = [
        ("at rest", still.clone()),
        ("moves", moves.clone()),
        ("turns", turns),
        ("area lights", with_area_lights(moves)),
    ];
    for (number, (name, scene)) in scenes.into_iter().enumerate() {
        // each way before a camera that moves, and before one that rests or turns; random shots have the other pairs
        let ways = [
            settings(1),
            settings(2),
            Settings { mode: Mode::Auto, filter: Filter::Mitchell, ..settings(2) },
            Settings { reuse: Reuse::Paper, ..settings(2) },
            Settings { refinement: Some(Refinement { most: 4, threshold: 0.1 }), ..settings(1) },
            Settings {
                crop: Some(PixelRect { x: -3, y: 5, width: 60, height: 40 }),
                overscan: 4,
                ..settings(2)
            },
        ];
        for settings in ways.into_iter().skip(number.div_ceil(2) % 2).step_by(2) {
            let settings = Settings { width: 64, height: 48, ..settings };
            let share = audited(&scene, &settings);
            assert!(share > 0.75, "{name}, {:?}, {}: {share}", settings.mode, settings.samples);
        }
    }
}

#[test]
fn gathered_light_is_the_left_eyes() {
    let scene = with_camera(with_flyer(world()), goes(EYE, EYE - DVec3::Z), rests(TARGET));
    for budget in [Budget::None, Budget::Full] {
        let settings = Settings { paths: 8, paths_per_frame: 2, budget, ..settings(1) };
        assert!(audited(&scene, &settings) > 0.75);
        let frames = render(&scene, &settings);
        let gathering = |eye: usize| frames[0][eye].stats.rays.gathering;
        if budget == Budget::None {
            assert!(gathering(1) * 3 < gathering(0), "{} {}", gathering(1), gathering(0));
        }
    }
}

#[test]
fn frames_are_the_same_for_any_number_of_threads() {
    let scene = with_camera(with_flyer(world()), goes(EYE, EYE - DVec3::Z), rests(TARGET));
    let settings = Settings { paths: 2, filter: Filter::Gaussian, ..settings(2) };
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| render(&scene, &settings))
    };
    let one = on(1);
    for threads in [2, 5] {
        for (one, other) in one.iter().flatten().zip(on(threads).iter().flatten()) {
            assert_same(one, other, &format!("{threads} threads, frame {}", one.stats.frame));
            assert_eq!(one.stats.rays, other.stats.rays);
        }
    }
}

/// Looks along -Z, and goes by numbers that single floats hold.
fn straight() -> Scene {
    let at = [DVec3::new(0.5, 1.5, 7.0), DVec3::new(0.5, 1.5, 4.5)];
    let mut scene = with_flyer(world());
    scene.camera = toy::camera(goes(at[0], at[1]), goes(at[0] - DVec3::Z * 8.0, at[1] - DVec3::Z * 8.0));
    scene
}

/// `scene` with its camera so far to the right, and its lens shifted as that of `finished` is.
fn by_hand(mut scene: Scene, aside: f64, finished: &Finished) -> Scene {
    let at = [DVec3::new(0.5, 1.5, 7.0), DVec3::new(0.5, 1.5, 4.5)].map(|at| at + DVec3::X * aside);
    let lens = Lens {
        shift: finished.camera.shift.map(|shift| Track::constant(f64::from(shift))),
        ..Lens::default()
    };
    scene.camera = toy::camera(goes(at[0], at[1]), goes(at[0] - DVec3::Z * 8.0, at[1] - DVec3::Z * 8.0));
    scene.camera.lens = lens;
    scene
}

#[test]
fn each_eye_sees_what_a_camera_in_its_place_sees() {
    // in all layers: motion vectors, too, lead to what this eye saw and will see
    let scene = straight();
    let full = Settings { mode: Mode::Full, ..settings(2) };
    let inferred = render(&scene, &settings(2));
    let frame = both(&mut Renderer::new(&scene, &full).unwrap(), 3, false);
    for (eye, aside) in [(0, -0.125), (1, 0.125)] {
        let seen = &frame[eye];
        // 60 degrees from top to bottom, and 4 to 3
        let shift = -aside / 6.0 / (2.0 * 30_f64.to_radians().tan() * 96.0 / 72.0);
        assert!((f64::from(seen.camera.shift[0]) - shift).abs() < 1e-6, "{:?}", seen.camera);
        let mono = Settings { stereo: None, ..full.clone() };
        let by_hand = by_hand(scene.clone(), aside, seen);
        let alone = Renderer::new(&by_hand, &mono).unwrap().render(3, false).unwrap();
        assert_eq!((seen.camera, seen.stats.mode), (alone.camera, "full"));
        assert_same(seen, &alone, &format!("eye {eye}"));
        // what is inferred has its samples elsewhere in their cells
        let [one, other] = [&inferred[2][eye], &alone].map(|frame| frame.film.values("object.V").unwrap());
        let off = one.iter().zip(&other).filter(|(one, other)| one != other).count();
        assert!(off * 50 < one.len(), "eye {eye}: {off}");
        assert!(toy::mean_difference(&inferred[2][eye], &alone, "R") < 0.01);
    }
    let [left, right] = &frame;
    assert!(toy::mean_difference(left, right, "R") > 0.005, "or both see the same");
}

/// With a shutter and a lens that is focused on the camera's target.
fn blurred(mut scene: Scene, samples: u32) -> (Scene, Settings) {
    scene.camera.lens.aperture = Some(Track::constant(0.1));
    let shutter = Some(Shutter::new(-0.25, 0.25));
    (scene, Settings { shutter, exposures: Some(4), ..settings(samples) })
}

#[test]
fn blurred_eyes_are_exact_and_the_right_one_is_lent_what_the_left_one_sees() {
    let still = with_flyer(world());
    let moves = with_camera(still.clone(), goes(EYE, EYE + DVec3::new(0.4, -0.2, -0.5)), rests(TARGET));
    for (name, scene) in [("at rest", still), ("moves", moves)] {
        let (scene, settings) = blurred(scene, 2);
        let small = Settings { width: 64, height: 48, ..settings.clone() };
        for settings in [
            small.clone(),
            // in a smaller picture tracing would pay
            Settings { mode: Mode::Auto, filter: Filter::Mitchell, ..settings },
            Settings { refinement: Some(Refinement { most: 4, threshold: 0.1 }), ..small },
        ] {
            let settings = Settings { audit: true, ..settings };
            for finished in render(&scene, &settings).iter().flatten() {
                let FrameStats { frame, eye, from_left, samples, ref audit, .. } = finished.stats;
                let audit = audit.as_ref().unwrap();
                assert_eq!(
                    (audit.differing, audit.checked),
                    (0, samples.total()),
                    "{name}, {frame}, {eye:?}"
                );
                let is_lent = eye == Some(Eye::Right) && (frame == 1 || name == "moves");
                // tracing may pay in an exposure
                let may_be_traced = settings.mode == Mode::Auto && is_lent;
                assert!(from_left == is_lent || may_be_traced, "{name}, frame {frame}, {eye:?}");
                let share = samples.reused() as f64 / samples.total() as f64;
                assert!(frame == 1 || share > 0.7, "{name}, frame {frame}, {eye:?}: {share}");
            }
        }
    }
}

#[test]
fn a_blurred_eye_sees_what_a_blurred_camera_in_its_place_sees() {
    let (scene, settings) = blurred(straight(), 2);
    let settings = Settings { mode: Mode::Full, ..settings };
    let frame = both(&mut Renderer::new(&scene, &settings).unwrap(), 3, false);
    for (eye, aside) in [(0, -0.125), (1, 0.125)] {
        let seen = &frame[eye];
        let mut by_hand = by_hand(scene.clone(), aside, seen);
        by_hand.camera.lens.aperture = scene.camera.lens.aperture.clone();
        let mono = Settings { stereo: None, ..settings.clone() };
        let alone = Renderer::new(&by_hand, &mono).unwrap().render(3, false).unwrap();
        assert_eq!(seen.camera, alone.camera);
        // their windows are rounded in another order
        for plane in ["R", "A", "Z", "motion.X"] {
            let off = toy::mean_difference(seen, &alone, plane);
            assert!(off < 1e-3, "eye {eye}, {plane}: {off}");
        }
    }
    let [left, right] = &frame;
    assert!(toy::mean_difference(left, right, "R") > 0.005, "or both see the same");
}

#[test]
fn what_stands_where_they_converge_has_one_place_in_both_pictures() {
    let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let at = |z: f32| {
        let square = toy::mesh(&corners, &[[0, 1, 2], [0, 2, 3]], 0, true);
        let camera = toy::camera(rests(DVec3::ZERO), rests(DVec3::NEG_Z));
        let model = toy::still("square", square, glam::Vec3::NEG_Z * z);
        toy::scene(camera, vec![model], vec![toy::matt(0.5)], vec![toy::sun_overhead(1.0)])
    };
    let middles = |z: f32| {
        let frames = render(&at(z), &Settings { mode: Mode::Full, ..settings(1) });
        frames[0].each_ref().map(|seen| {
            let ids = seen.film.values("object.V").unwrap();
            let columns: Vec<usize> =
                ids.iter().enumerate().filter(|(_, id)| **id > 0.0).map(|(at, _)| at % 96).collect();
            columns.iter().sum::<usize>() as f64 / columns.len() as f64
        })
    };
    let [near, there, far] = [4.0, 6.0, 12.0].map(middles);
    assert_eq!(there[0], there[1]);
    assert!(near[0] > near[1] + 0.5, "before the screen the left eye sees things further right: {near:?}");
    assert!(far[0] < far[1] - 0.5, "{far:?}");
}

#[test]
fn eyes_at_rest_go_on_with_their_own() {
    let (scene, settings) = (world(), Settings { audit: true, ..settings(2) });
    let mut renderer = Renderer::new(&scene, &settings).unwrap();
    let mut first = None;
    for frame in 1..=FRAMES {
        // whoever keeps a film has the next frame made in a new one
        let [left, right] = both(&mut renderer, frame, true).map(|seen| {
            let planes = ["R", "Z", "object.V"].map(|plane| seen.film.values(plane).unwrap());
            (seen.stats, planes)
        });
        assert_eq!((left.0.from_left, right.0.from_left), (false, frame == 1));
        assert_eq!([&left, &right].map(|(stats, _)| stats.audit.unwrap().differing), [0, 0]);
        // what mirrors show is made once more in the second frame, to note where their rays go
        if frame > 2 {
            assert_eq!([&left, &right].map(|(stats, _)| stats.rays.total()), [0, 0], "nothing moves");
        }
        let pictures = [left.1, right.1];
        assert_eq!(first.get_or_insert_with(|| pictures.clone()), &pictures, "frame {frame}");
    }
    // where something moves, each eye asks of its own samples what that changed
    let frames = render(&with_flyer(world()), &settings);
    assert!(frames[1..].iter().all(|[_, right]| right.stats.samples.reused() > 0 && !right.stats.from_left));
}

#[test]
fn frames_do_not_depend_on_where_a_chunk_begins() {
    let moves = with_camera(with_flyer(world()), goes(EYE, EYE - DVec3::Z), rests(TARGET));
    for scene in [moves, with_flyer(world())] {
        for mode in [Mode::Auto, Mode::Reproject] {
            let settings = Settings { mode, layers: Layers::USUAL, ..settings(2) };
            let chunk = |first: i32| -> Vec<[Finished; 2]> {
                let mut renderer = Renderer::new(&scene, &settings).unwrap();
                (first..=FRAMES).map(|frame| both(&mut renderer, frame, frame != 4)).collect()
            };
            for (whole, part) in chunk(1)[3..].iter().flatten().zip(chunk(4).iter().flatten()) {
                assert_eq!((whole.stats.samples, whole.stats.rays), (part.stats.samples, part.stats.rays));
                assert_same(whole, part, &format!("{mode:?}, frame {}", whole.stats.frame));
            }
        }
    }
}

/// What the program says of a shot of this text after its camera.
fn rendered(place: &Place, text: &str, options: &str) -> Ran {
    let analytic = std::fs::read_to_string(analytic()).unwrap();
    let folder = analytic_folder().canonicalize().unwrap();
    let shot = analytic.replace("obj = \"", &format!("obj = \"{}/", folder.display()));
    std::fs::write(place.path("s.toml"), format!("{shot}\n{text}")).unwrap();
    Ran::new(place.command("s.toml", options).output().unwrap())
}

fn analytic_folder() -> std::path::PathBuf {
    analytic().parent().unwrap().to_path_buf()
}

fn header(path: &Path, part: usize) -> openexr::ReadImage {
    openexr::read_header_of(path, part).unwrap()
}

#[test]
fn one_part_has_both_views_by_the_convention() {
    let place = Place::new();
    place
        .render("--separation 0.2 --convergence 5 --frames 2 --layers usual,diffuse -o a.####.exr --png")
        .done();
    let path = place.path("a.0002.exr");
    assert_eq!(openexr::part_count(&path).unwrap(), 1);
    let head = header(&path, 0);
    let views = Attribute::Texts(vec!["left".into(), "right".into()]);
    assert_eq!(head.attribute("multiView"), Some(&views));
    let names: Vec<&str> = head.channels.iter().map(|channel| channel.name.as_str()).collect();
    for name in
        ["R", "A", "Z", "right.R", "right.Z", "diffuse.left.R", "diffuse.right.R", "status_age.right.V"]
    {
        assert!(names.contains(&name), "{name} is not in {names:?}");
    }
    assert!(!names.contains(&"diffuse.R") && !names.contains(&"left.R"), "{names:?}");
    let [left, right] = ["worldToCamera", "right.worldToCamera"].map(|name| match head.attribute(name) {
        Some(Attribute::M44f(matrix)) => matrix[12],
        other => panic!("{name}: {other:?}"),
    });
    assert!((left - right - 0.2).abs() < 1e-5, "a point lies further left for the right eye: {left} {right}");
    assert_eq!(place.names("."), ["a.0002.exr", "a.left.0002.png", "a.right.0002.png"]);
    let [left, right] = ["left", "right"].map(|eye| std::fs::read(place.path(&format!("a.{eye}.0002.png"))));
    assert_ne!(left.unwrap(), right.unwrap());
}

#[test]
fn parts_have_a_view_each_and_the_same_values() {
    let place = Place::new();
    let options = "--separation 0.2 --frames 2 --layers usual,diffuse";
    place.render(&format!("{options} -o one.exr")).done();
    place.render(&format!("{options} -o parts.exr --multipart")).done();
    let (one, parts) = (place.path("one.0002.exr"), place.path("parts.0002.exr"));
    let image = openexr::read(&one).unwrap();
    let mut names = Vec::new();
    for part in 0..openexr::part_count(&parts).unwrap() {
        let mut planes: Vec<Vec<f32>> = vec![Vec::new(); header(&parts, part).channels.len()];
        let head =
            openexr::scan_part(&parts, part, |channel, values| planes[channel].extend(values)).unwrap();
        let Some(Attribute::Text(view)) = head.attribute("view") else { panic!("part {part} has no view") };
        assert!(head.attribute("multiView").is_none(), "these conventions exclude each other");
        names.push((head.part_name.clone(), view.clone()));
        for (channel, values) in head.channels.iter().zip(planes) {
            let name = match channel.name.split_once('.') {
                None if view == "left" => channel.name.clone(),
                None => format!("{view}.{}", channel.name),
                Some((layer, letter)) => format!("{layer}.{view}.{letter}"),
            };
            assert_eq!(image.channel(&name).unwrap().data, values, "{name}");
        }
    }
    let first: Vec<(&str, &str)> = names.iter().map(|(name, view)| (&**name, &**view)).take(2).collect();
    assert_eq!(first, [("rgba.left", "left"), ("rgba.right", "right")]);
    assert!(names.contains(&("diffuse.right".to_owned(), "right".to_owned())), "{names:?}");
    let diff =
        std::process::Command::new(env!("CARGO_BIN_EXE_afterimage")).arg("diff").args([&one, &one]).output();
    assert_eq!(Ran::new(diff.unwrap()).code, 0);
}

#[test]
fn a_run_tells_of_each_eye() {
    let place = Place::new();
    let ran = place
        .render("--separation 0.2 --frames 1-3 --audit --stats s.json --contact-sheet -o a.####.exr")
        .done();
    assert!(ran.stdout.contains("right eye: "), "{}", ran.stdout);
    assert_eq!(ran.stdout.lines().filter(|line| line.contains(" right ") && line.contains("ok")).count(), 3);
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(place.path("s.json")).unwrap()).unwrap();
    assert_eq!(json["frames"].as_array().unwrap().len(), 6);
    assert_eq!((&json["frames"][1]["eye"], &json["frames"][1]["from_left"]), (&"right".into(), &true.into()));
    let eyes = &json["eyes"];
    assert!(eyes["from_left"]["percent"].as_f64().unwrap() > 80.0, "{eyes}");
    let total = |eye: &str| eyes[eye]["rays"]["primary"].as_u64().unwrap();
    assert_eq!(total("left") + total("right"), json["totals"]["rays"]["primary"].as_u64().unwrap());
    assert_eq!(json["settings"]["stereo"]["separation"], 0.2);
    let compare = std::process::Command::new(env!("CARGO_BIN_EXE_afterimage"))
        .current_dir(place.path("."))
        .arg("compare")
        .arg(analytic())
        .args(
            "--separation 0.2 --frames 1-2 --size 64x36 --reference 4 --json c.json --report c.html"
                .split(' '),
        )
        .output();
    let ran = Ran::new(compare.unwrap()).done();
    assert!(ran.stdout.contains("(right eye: 2)"), "{}", ran.stdout);
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(place.path("c.json")).unwrap()).unwrap();
    assert!(json["eyes"]["reprojected"]["from_left"]["percent"].as_f64().unwrap() > 80.0);
}

#[test]
fn resumed_runs_know_both_eyes() {
    let place = Place::new();
    let run =
        |options: &str| place.render(&format!("--frames 1-3 -o a.####.exr --resume {options}")).done().stderr;
    run("--separation 0.2 --png");
    assert!(run("--separation 0.2 --png").contains("3 frames are there"));
    std::fs::remove_file(place.path("a.right.0002.png")).unwrap();
    assert!(run("--separation 0.2 --png").contains("2 frames are there"));
    assert!(run("--separation 0.3 --png").contains("settings"));
    assert!(run("").contains("rendering again"), "one eye is another picture");
}

#[test]
fn the_shot_says_it_and_the_command_line_beats_it() {
    let place = Place::new();
    let separation = |options: &str| {
        rendered(
            &place,
            "[stereo]\nseparation = 0.1\nconvergence = 3.0",
            &format!("--frames 1 --stats s.json {options}"),
        )
        .done();
        let json: serde_json::Value =
            serde_json::from_slice(&std::fs::read(place.path("s.json")).unwrap()).unwrap();
        let stereo = &json["settings"]["stereo"];
        (stereo["separation"].as_f64(), stereo["convergence"].as_f64())
    };
    assert_eq!(separation(""), (Some(0.1), Some(3.0)));
    assert_eq!(separation("--stereo --convergence 4"), (Some(0.1), Some(4.0)));
    assert_eq!(separation("--separation 0.2"), (Some(0.2), Some(3.0)));
    assert_eq!(separation("--mono"), (None, None));
}

#[test]
fn what_makes_no_sense_is_refused_with_a_way_out() {
    let place = Place::new();
    for (text, words) in [
        ("separation = 0", ["s.toml:", "separation of 0"]),
        ("separation = -0.1", ["s.toml:", "separation of -0.1"]),
        ("separation = nan", ["s.toml:", "separation of NaN"]),
        ("separation = 1\nconvergence = 0", ["s.toml:", "convergence of 0"]),
        ("separation = 1\nconvergence = -4.0", ["s.toml:", "convergence of -4"]),
        ("separation = 1\nconvergence = inf", ["s.toml:", "convergence of inf"]),
        ("separation = 1\nconvergence = 0.01", ["s.toml:", "0.1 at most"]),
        ("convergence = 1", ["s.toml:", "needs `separation`"]),
    ] {
        rendered(&place, &format!("[stereo]\n{text}"), "--frames 1").failed(&words);
    }
    for (options, word) in [
        ("--stereo", "--separation"),
        ("--convergence 3", "--separation"),
        ("--separation 0", "above 0"),
        ("--separation nan", "above 0"),
        ("--separation 1 --convergence=-1", "above 0"),
        ("--separation 1 --convergence 0.01", "0.1 at most"),
        ("--separation 1 --mono", "cannot be used"),
    ] {
        let ran = place.render(options);
        assert!(ran.code == 2 && ran.stderr.contains(word), "{options}: {}", ran.stderr);
    }
    let text = std::fs::read_to_string(analytic()).unwrap();
    let text = text
        .replace("[camera]", "[camera]\nprojection = \"orthographic\"")
        .replace("fov = 40", "height = 4.0");
    let folder = analytic_folder().canonicalize().unwrap();
    let text = text.replace("obj = \"", &format!("obj = \"{}/", folder.display()));
    std::fs::write(place.path("o.toml"), &text).unwrap();
    let ran = Ran::new(place.command("o.toml", "--separation 1 --frames 1").output().unwrap());
    assert!(ran.code == 2 && ran.stderr.contains("perspective"), "{}", ran.stderr);
    std::fs::write(place.path("o.toml"), format!("{text}\n[stereo]\nseparation = 1")).unwrap();
    let ran = Ran::new(place.command("o.toml", "--frames 1").output().unwrap());
    ran.failed(&["o.toml:", "perspective"]);
}

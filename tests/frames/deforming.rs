//! Meshes that deform: do they look as they must, and is reuse exact on them?

use afterimage::animation::{ShapeTrack, Track, TransformTrack};
use afterimage::exposure::Shutter;
use afterimage::film::Film;
use afterimage::frame::{Finished, Renderer};
use afterimage::scene::{Mesh, Model, Scene};
use afterimage::settings::{Mode, Refinement, Settings};
use afterimage::stereo::{Eye, Stereo};
use afterimage::trace::BackendKind;
use glam::{DVec3, Vec2, Vec3};

use crate::toy;
use crate::toy::worlds::*;

/// Waves that run along a sheet, at a phase.
fn wave(phase: f32) -> impl Fn(Vec3) -> Vec3 {
    move |at| at + Vec3::Y * (0.35 * (2.2 * at.x + phase).sin() + 0.15 * (3.0 * at.z - phase).cos())
}

/// A sheet whose right half lies over the left one, by a share of half a turn about the z axis.
fn fold(share: f32) -> impl Fn(Vec3) -> Vec3 {
    move |at| {
        let (sin, cos) = (share * std::f32::consts::PI).sin_cos();
        if at.x <= 0.0 { at } else { Vec3::new(at.x * cos, at.x * sin + 0.08 * at.x, at.z) }
    }
}

/// The world with a sheet above its floor that waves through four shapes, and moves.
fn waving(mesh: Mesh) -> Scene {
    let track = TransformTrack {
        translate: goes(DVec3::new(-0.5, 2.2, 1.4), DVec3::new(0.2, 2.0, 1.6)),
        rotate: rests(DVec3::new(25.0, 10.0, 0.0)),
        ..TransformTrack::identity()
    };
    let waves = [0.0, 0.7, 1.5, 2.0].map(wave);
    let shapes: Vec<(f64, &dyn Fn(Vec3) -> Vec3)> =
        [1.0, 2.5, 4.0, 6.0].into_iter().zip(waves.iter().map(|wave| wave as _)).collect();
    let mut scene = world();
    scene.models.push(toy::deforming("sheet", mesh, track, &shapes));
    scene
}

/// The same with a sheet that stays where it is and folds over itself.
fn folding(mesh: Mesh) -> Scene {
    let track = TransformTrack { translate: rests(DVec3::new(-0.3, 1.9, 1.6)), ..TransformTrack::identity() };
    let folds = [0.0, 0.4, 0.8, 0.97].map(fold);
    let shapes: Vec<(f64, &dyn Fn(Vec3) -> Vec3)> =
        [1.0, 3.0, 5.0, 6.0].into_iter().zip(folds.iter().map(|fold| fold as _)).collect();
    let mut scene = world();
    scene.models.push(toy::deforming("sheet", mesh, track, &shapes));
    scene
}

/// Puts each vertex where another may have been.
fn mixed(at: Vec3) -> Vec3 {
    let within = |x: f32| x.rem_euclid(3.0) - 1.5;
    Vec3::new(within(13.7 * at.x), 0.3 * (5.0 * at.x * at.z).sin(), within(9.3 * (at.z + at.x)))
}

/// The world with a sheet that waves, is mixed up, waves again and lies flat; beside it much glass, so that what casts shadows is apart.
fn shuffled(mesh: Mesh) -> Scene {
    let track = TransformTrack { translate: rests(DVec3::new(-0.3, 2.2, 1.6)), ..TransformTrack::identity() };
    let [one, other] = [0.0, 0.7].map(wave);
    let flat: &dyn Fn(Vec3) -> Vec3 = &|at| at;
    let shapes = [(1.0, &one as _), (2.0, &mixed as _), (3.0, &other as _), (4.0, flat), (6.0, &mixed as _)];
    let mut scene = world();
    scene.models.push(toy::deforming("sheet", mesh, track, &shapes));
    let pane = Mesh { shadow_casting: 0, ..toy::sheet(1.0, 16, 2, false) };
    scene.models.push(toy::still("pane", pane, Vec3::new(2.5, 0.3, 2.0)));
    scene
}

fn audited(scene: &Scene, settings: &Settings) -> Vec<Finished> {
    audited_with(BackendKind::Embree, scene, settings)
}

fn audited_with(kind: BackendKind, scene: &Scene, settings: &Settings) -> Vec<Finished> {
    let settings = &Settings { audit: true, ..settings.clone() };
    let mut renderer = Renderer::with(kind, scene, settings).unwrap();
    let frames: Vec<Finished> = (1..=FRAMES).map(|frame| renderer.render(frame, true).unwrap()).collect();
    let cells = u64::from(settings.width * settings.height * settings.samples.pow(2));
    for finished in &frames {
        let audit = finished.stats.audit.unwrap();
        assert_eq!(audit.wrong(), 0, "frame {}: {audit:?}", finished.stats.frame);
        assert!(audit.on_edge * 100 < cells, "frame {}: {audit:?}", finished.stats.frame);
    }
    frames
}

/// With a camera that goes along.
fn passed_by(scene: Scene) -> Scene {
    with_camera(scene, goes(EYE, EYE + DVec3::new(0.6, 0.2, -0.8)), rests(TARGET))
}

#[test]
fn reuse_is_exact_on_sheets_that_wave_and_fold() {
    // each material with each two of: flat or smooth, waves or folds, a camera that rests or goes
    for material in 0..3 {
        for (is_smooth, waves) in [(false, false), (false, true), (true, false), (true, true)] {
            let mesh = toy::sheet(1.5, 12, material, is_smooth);
            let scene = if waves { waving(mesh) } else { folding(mesh) };
            let scene = if is_smooth == waves { passed_by(scene) } else { scene };
            audited(&scene, &Settings { width: 64, height: 48, ..toy::settings(2) });
        }
    }
}

#[test]
fn reuse_is_exact_for_both_tracers_and_for_light_from_all_around() {
    let mesh = toy::sheet(1.5, 10, 0, true);
    for scene in [waving(mesh.clone()), folding(mesh)] {
        let mut scene = with_area_lights(scene);
        scene.ambient_is_occluded = true;
        for scene in [scene.clone(), passed_by(scene)] {
            let settings = Settings { paths: 3, bounces: 2, occlusion_rays: 4, ..toy::settings(1) };
            for kind in [BackendKind::Embree, BackendKind::Rust] {
                audited_with(kind, &scene, &settings);
            }
        }
    }
}

#[test]
fn reuse_is_exact_in_exposures_levels_and_both_eyes() {
    let mesh = toy::sheet(1.5, 10, 1, true);
    for scene in [waving(mesh.clone()), passed_by(folding(mesh))] {
        let shutter = Some(Shutter::new(-0.25, 0.25));
        audited(&scene, &Settings { shutter, exposures: Some(4), ..toy::settings(2) });
        let refinement = Some(Refinement { most: 4, threshold: 0.1 });
        audited(&scene, &Settings { refinement, ..toy::settings(1) });
        let stereo = Some(Stereo { separation: 0.25, convergence: Some(6.0) });
        let settings = Settings { stereo, ..toy::audited(2) };
        let mut renderer = Renderer::new(&scene, &settings).unwrap();
        for (frame, eye) in (1..=FRAMES).flat_map(|frame| [Eye::Left, Eye::Right].map(|eye| (frame, eye))) {
            let audit = renderer.render_eye(eye, frame, true).unwrap().stats.audit.unwrap();
            assert_eq!(audit.wrong(), 0, "{eye:?}, frame {frame}: {audit:?}");
        }
    }
}

/// Nothing but a sheet that fills the picture while it waves and the camera goes by: its samples are reprojected with it.
#[test]
fn samples_go_along_with_what_deforms() {
    let waves = [0.0, 1.0].map(wave);
    let shapes: Vec<(f64, &dyn Fn(Vec3) -> Vec3)> =
        [1.0, 6.0].into_iter().zip(waves.iter().map(|wave| wave as _)).collect();
    let sheet = toy::deforming("sheet", toy::sheet(4.0, 40, 0, true), TransformTrack::identity(), &shapes);
    let camera = toy::camera(goes(DVec3::new(0.0, 3.0, 2.0), DVec3::new(0.3, 3.1, 1.8)), rests(DVec3::ZERO));
    let scene = toy::scene(camera, vec![sheet], vec![toy::matt(0.5)], vec![toy::sun_overhead(1.0)]);
    let cells = 96 * 72 * 4;
    for finished in &audited(&scene, &toy::settings(2))[1..] {
        let counts = finished.stats.samples;
        let kept = counts.good + counts.overlapped;
        assert_eq!(kept + counts.missed + counts.obscured, cells);
        assert!(kept * 100 > cells * 85, "{counts:?}");
    }
}

fn bits(film: &Film) -> Vec<u32> {
    film.planes.iter().flat_map(|plane| (0..96 * 72).map(|at| plane.values.get(at).to_bits())).collect()
}

#[test]
fn reuse_is_exact_on_a_sheet_that_is_mixed_up_and_lies_flat() {
    for is_smooth in [false, true] {
        let scene = passed_by(shuffled(toy::sheet(1.5, 12, 0, is_smooth)));
        let settings = Settings { width: 64, height: 48, ..toy::settings(2) };
        let both = [BackendKind::Embree, BackendKind::Rust].map(|kind| audited_with(kind, &scene, &settings));
        let [embree, rust] = both;
        for (one, other) in embree.iter().zip(&rust) {
            for plane in ["R", "Z"] {
                let apart = toy::mean_difference(one, other, plane);
                assert!(apart < 2e-3, "frame {}, {plane}: {apart}", one.stats.frame);
            }
        }
    }
}

/// What is traced follows from the first shape and the present one: what was rendered before, and by how many threads, changes no bit.
#[test]
fn frames_depend_neither_on_threads_nor_on_the_frames_before() {
    let settings = Settings { mode: Mode::Full, paths: 1, ..toy::settings(1) };
    let sheet = || toy::sheet(1.5, 30, 1, true);
    // one that waves, and one that is mixed up, waves again and is flat
    for (scene, last) in
        [(waving(sheet()), 4), (shuffled(sheet()), 2), (shuffled(sheet()), 3), (shuffled(sheet()), 4)]
    {
        for kind in [BackendKind::Embree, BackendKind::Rust] {
            let render = |threads: usize, before: &[i32]| {
                let pool =
                    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
                pool.install(|| {
                    let mut renderer = Renderer::with(kind, &scene, &settings).unwrap();
                    for frame in before {
                        renderer.render(*frame, false).unwrap();
                    }
                    bits(&renderer.render(last, false).unwrap().film)
                })
            };
            let alone = render(2, &[]);
            for (threads, before) in [(1, &[][..]), (2, &[1, 3]), (3, &[6, 5, 2]), (2, &[last])] {
                let is_same = alone == render(threads, before);
                assert!(is_same, "{kind:?}, {threads} threads, frame {last} after {before:?}");
            }
        }
    }
    let scene = waving(sheet());
    let chain = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        let films = pool.install(|| toy::render(&scene, &toy::settings(2), FRAMES));
        films.iter().map(|finished| bits(&finished.film)).collect::<Vec<_>>()
    };
    assert!(chain(1) == chain(4));
}

/// A model whose shapes are all that of its file looks as one without shapes.
#[test]
fn shapes_that_are_those_of_the_file_change_nothing() {
    let track = TransformTrack {
        translate: goes(DVec3::new(-0.5, 2.2, 1.4), DVec3::new(0.2, 2.0, 1.6)),
        ..TransformTrack::identity()
    };
    let rigid = {
        let mut scene = world();
        scene.models.push(toy::moving("solid", toy::octahedron(0, true), track.clone()));
        scene
    };
    let same: &dyn Fn(Vec3) -> Vec3 = &|at| at;
    let mut scene = world();
    scene.models.push(toy::deforming("solid", toy::octahedron(0, true), track, &[(1.0, same), (4.0, same)]));
    for (deforming, rigid) in
        audited(&scene, &toy::settings(2)).iter().zip(audited(&rigid, &toy::settings(2)))
    {
        for plane in ["R", "G", "B", "N.X", "P.Y"] {
            let apart = toy::mean_difference(deforming, &rigid, plane);
            assert!(apart < 1e-5, "frame {}, {plane}: {apart}", rigid.stats.frame);
        }
    }
}

/// Alone, seen straight from above: 36 pixels are as many units as the eye is high.
fn from_above(model: Model, height: f64) -> Scene {
    let mut camera = toy::camera(rests(DVec3::Y * height), rests(DVec3::NEG_Z * 1e-6));
    camera.fov = Track::constant(90.0);
    toy::scene(camera, vec![model], vec![toy::matt(0.5)], vec![toy::sun_overhead(2.0)])
}

fn vector(finished: &Finished, names: [&str; 2], [x, y]: [u32; 2]) -> Vec2 {
    Vec2::from(names.map(|name| toy::pixel(finished, name, x, y)))
}

/// A square that becomes twice as wide in four frames: a point of it is seen at x = x0 (1 + (frame - 1) / 4).
#[test]
fn motion_vectors_of_what_stretches_are_those_worked_out_by_hand() {
    let wide: &dyn Fn(Vec3) -> Vec3 = &|at| at * Vec3::new(2.0, 1.0, 1.0);
    let same: &dyn Fn(Vec3) -> Vec3 = &|at| at;
    let model =
        toy::deforming("floor", toy::floor(20.0, 0), TransformTrack::identity(), &[(1.0, same), (5.0, wide)]);
    let scene = from_above(model, 4.0);
    let stretch = |frame: f32| 1.0 + (frame - 1.0) / 4.0;
    let frames = audited(&scene, &toy::settings(1));
    for (at, frame) in
        [[20, 30], [48, 40], [80, 60]].into_iter().flat_map(|at| [2, 3, 4].map(|frame| (at, frame)))
    {
        let finished = &frames[frame as usize - 1];
        // samples are not in the middle of pixels: where they are, the layer of positions says
        let x = toy::pixel(finished, "P.X", at[0], at[1]);
        let frame = frame as f32;
        let along = |other: f32| Vec2::X * (x * (stretch(other) / stretch(frame) - 1.0) * 36.0 / 4.0);
        let (forward, backward) = (along(frame + 1.0), along(frame - 1.0));
        for (names, expected) in
            [(["forward.U", "forward.V"], forward), (["backward.U", "backward.V"], backward)]
        {
            let found = vector(finished, names, at);
            assert!(found.distance(expected) < 5e-3, "{at:?}, frame {frame}: {found}, not {expected}");
        }
        assert!(backward.length() > 0.1 || at[0] == 48);
    }
}

/// A square whose right edge rises: in each frame the plane y = s (x + 2) / 4, as bright as the cosine law says.
#[test]
fn what_tilts_is_seen_where_it_is_and_as_bright_as_it_must_be() {
    let up: &dyn Fn(Vec3) -> Vec3 = &|at| at.with_y((at.x + 2.0) / 4.0 * 3.0);
    let same: &dyn Fn(Vec3) -> Vec3 = &|at| at;
    for normals in [Vec::new(), vec![Vec3::Y; 4]] {
        let mesh = toy::floor(2.0, 0).with_triangles(|triangles| triangles.normals = normals);
        let model = toy::deforming("square", mesh, TransformTrack::identity(), &[(1.0, same), (5.0, up)]);
        let frames = audited(&from_above(model, 5.0), &toy::settings(1));
        for (number, finished) in (0_u8..5).zip(&frames) {
            let rise = 3.0 * f32::from(number) / 4.0;
            let slope = rise / 4.0;
            let normal = Vec3::new(-slope, 1.0, 0.0).normalize();
            for at in [[44, 36], [52, 40]] {
                let [x, y] = ["P.X", "P.Y"].map(|plane| toy::pixel(finished, plane, at[0], at[1]));
                assert!((y - slope * (x + 2.0)).abs() < 1e-3, "frame {}: {x} {y}", finished.stats.frame);
                let found =
                    Vec3::from(["N.X", "N.Y", "N.Z"].map(|plane| toy::pixel(finished, plane, at[0], at[1])));
                assert!(found.distance(normal) < 2e-3, "{found}, not {normal}");
                let (shown, expected) = (toy::color(finished, at[0], at[1]).x, 2.0 * 0.5 * normal.y);
                assert!((shown - expected).abs() < 2e-3, "{shown}, not {expected}");
            }
        }
    }
}

/// A strip of two squares that bends at the edge between them: smooth ones share a normal there, which is the mean of both.
#[test]
fn bent_meshes_are_smooth_where_their_file_is() {
    let roof: &dyn Fn(Vec3) -> Vec3 = &|at| at.with_y(-at.x.abs());
    let same: &dyn Fn(Vec3) -> Vec3 = &|at| at;
    for is_smooth in [false, true] {
        let mesh = toy::sheet(2.0, 2, 0, is_smooth);
        let model = toy::deforming("roof", mesh, TransformTrack::identity(), &[(1.0, same), (3.0, roof)]);
        let frames = audited(&from_above(model, 6.0), &toy::settings(1));
        let normal =
            |x: u32| Vec3::from(["N.X", "N.Y", "N.Z"].map(|plane| toy::pixel(&frames[4], plane, x, 30)));
        let flat = Vec3::new(0.5_f32.sqrt(), 0.5_f32.sqrt(), 0.0);
        // beside the ridge, and half way down
        let (ridge, half) = (normal(48), normal(53));
        if is_smooth {
            assert!(ridge.distance(Vec3::Y) < 0.15 && half.distance(flat) > 0.1, "{ridge} {half}");
        } else {
            assert!(ridge.distance(flat) < 2e-3 && half.distance(flat) < 2e-3, "{ridge} {half}");
        }
    }
}

/// A ridge that is flat at rest: both of its sides are as bright, and one surface. Its fold alone asks for more samples.
#[test]
fn folds_that_are_not_there_at_rest_are_refined() {
    let ridge: &dyn Fn(Vec3) -> Vec3 = &|at| at.with_y(-0.3 * at.x.abs());
    let same: &dyn Fn(Vec3) -> Vec3 = &|at| at;
    let mesh = toy::sheet(20.0, 2, 0, false);
    let model = toy::deforming("ridge", mesh, TransformTrack::identity(), &[(1.0, same), (3.0, ridge)]);
    let settings = Settings { refinement: Some(Refinement { most: 2, threshold: 0.1 }), ..toy::audited(1) };
    let scene = from_above(model, 4.0);
    let mut renderer = Renderer::new(&scene, &settings).unwrap();
    let frames = [1, 2, 3, 4].map(|frame| renderer.render(frame, true).unwrap().stats);
    assert!(frames.iter().all(|stats| stats.audit.unwrap().differing == 0));
    let samples = frames.each_ref().map(|stats| stats.samples.total());
    assert_eq!(samples[0], 96 * 72, "it is flat");
    // along the ridge at least a pixel of each row
    assert!(samples[3] >= 96 * 72 + 72 * 4 && samples[3] < 2 * 96 * 72, "{samples:?}");
}

/// What has no area in some frame is not seen there, and comes again.
#[test]
fn a_sheet_that_collapses_is_gone_and_comes_back() {
    let line: &dyn Fn(Vec3) -> Vec3 = &|at| Vec3::new(at.x, 0.0, 0.0);
    let same: &dyn Fn(Vec3) -> Vec3 = &|at| at;
    let track = TransformTrack { translate: rests(DVec3::new(-0.3, 1.9, 1.6)), ..TransformTrack::identity() };
    for is_smooth in [false, true] {
        let mesh = toy::sheet(1.5, 6, 0, is_smooth);
        let keys = [(1.0, same), (3.0, line), (4.0, line), (6.0, same)];
        let mut scene = world();
        scene.models.push(toy::deforming("sheet", mesh, track.clone(), &keys));
        for scene in [scene.clone(), passed_by(scene)] {
            let frames = audited(&scene, &Settings { paths: 1, ..toy::settings(2) });
            let planes = frames.iter().flat_map(|frame| &frame.film.planes);
            assert!(planes.flat_map(|plane| (0..96 * 72).map(|at| plane.values.get(at))).all(f32::is_finite));
        }
    }
}

/// What comes again is that of the first time, to the bit, in frames that are traced in full.
#[test]
fn shapes_that_repeat_give_the_same_picture() {
    let mut scene = waving(toy::sheet(1.5, 10, 0, true));
    let sheet = scene.models.last_mut().unwrap();
    let shapes = ShapeTrack::through(vec![(1.0, 0), (2.0, 1), (3.0, 2)], Some(1.0));
    sheet.track =
        TransformTrack { shapes, translate: rests(DVec3::new(-0.5, 2.2, 1.4)), ..TransformTrack::identity() };
    let settings = Settings { paths: 1, ..toy::settings(1) };
    audited(&scene, &settings);
    let mut full = Renderer::new(&scene, &Settings { mode: Mode::Full, ..settings }).unwrap();
    let film = |frame: i32, full: &mut Renderer| bits(&full.render(frame, false).unwrap().film);
    // the first time nothing leads to frame 1, which motion vectors tell
    let [fourth, fifth, seventh] = [4, 5, 7].map(|frame| film(frame, &mut full));
    assert!(fourth == seventh && fourth != fifth);
}

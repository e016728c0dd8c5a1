//! Is reuse exact? Every kind of change, audited in each frame: what differs must be nothing.

use afterimage::animation::{Track, TransformTrack};
use afterimage::film::{Film, Values};
use afterimage::frame::{Finished, Renderer};
use afterimage::layers::Layers;
use afterimage::scene::camera::Aim;
use afterimage::scene::{Light, LightKind, Panel, Scene, SpotFall};
use afterimage::settings::{Filter, Mode, Settings};
use glam::{DVec3, Vec3};

use crate::toy;
use crate::toy::worlds::*;

/// Renders all frames, demands an audit without a difference, and gives the share of samples that were
/// reused in the inferred ones.
fn audited(scene: &Scene) -> (Vec<Finished>, f64) {
    let frames = toy::render(scene, &toy::audited(2), FRAMES);
    let cells = 96 * 72 * 4;
    let mut reused = 0;
    for frame in &frames {
        let (audit, samples) = (frame.stats.audit.expect("asked for"), frame.stats.samples);
        assert_eq!(audit.checked, cells, "frame {}", frame.stats.frame);
        assert_eq!(audit.wrong(), 0, "frame {}: {audit:?}", frame.stats.frame);
        // the tolerance is for edges: it must not swallow surfaces
        assert!(audit.on_edge * 200 < cells, "frame {}: {audit:?}", frame.stats.frame);
        let sum = samples.base + samples.good + samples.overlapped + samples.missed + samples.obscured;
        assert_eq!(sum, cells);
        reused += samples.good + samples.overlapped;
    }
    let share = reused as f64 / (cells * (FRAMES as u64 - 1)) as f64;
    (frames, share)
}

#[test]
fn a_still_world_costs_no_rays_but_the_eyes() {
    let (frames, share) = audited(&world());
    assert_eq!(share, 1.0);
    let rays = frames[3].stats.rays;
    assert_eq!((rays.primary, rays.verification), (0, 0));
    assert!(rays.reflection > 0 && rays.refraction > 0, "these are made anew for every new film");
    let tracing = frames[3].stats.tracing;
    assert!(tracing.bounced > 0.0 && tracing.primary == 0.0, "timed as what they are: {tracing:?}");
    for plane in &frames[0].film.planes {
        if !plane.name.starts_with("status") && !plane.name.starts_with("rays") {
            assert_eq!(Some(plane), frames[5].film.plane(&plane.name), "{}", plane.name);
        }
    }
}

#[test]
fn a_turning_camera() {
    let scene = with_camera(world(), rests(EYE), goes(TARGET, TARGET + DVec3::new(0.8, 0.3, 0.0)));
    let (frames, share) = audited(&scene);
    assert!(share > 0.8, "{share}");
    assert!(frames[1..].iter().all(|frame| frame.stats.rays.verification == 0), "nothing can hide");
}

#[test]
fn a_zoom() {
    let mut scene = world();
    scene.camera.fov = toy::keys(&[(1.0, 60.0), (6.0, 50.0)]);
    let (frames, share) = audited(&scene);
    assert!(share > 0.7, "{share}");
    assert!(frames[1..].iter().all(|frame| frame.stats.rays.verification == 0), "nothing can hide");
}

#[test]
fn a_rolling_camera() {
    let mut scene = world();
    let roll = toy::keys(&[(1.0, 0.0), (6.0, 12.0)]);
    scene.camera.aim = Aim::Target { target: rests(TARGET), roll };
    assert!(audited(&scene).1 > 0.8);
}

#[test]
fn a_moving_camera() {
    let scene = with_camera(world(), goes(EYE, EYE + DVec3::new(1.0, 0.2, -1.5)), rests(TARGET));
    let (frames, share) = audited(&scene);
    assert!(share > 0.7, "{share}");
    assert!(frames[2].stats.samples.obscured > 0, "something gets hidden");
}

#[test]
fn a_camera_that_flies_through_the_floor_sees_its_other_side() {
    let scene = with_camera(world(), goes(EYE, DVec3::new(0.5, -3.0, 7.0)), rests(TARGET));
    audited(&scene);
}

#[test]
fn a_moving_model_before_a_still_camera() {
    let (frames, share) = audited(&with_flyer(world()));
    assert!(share > 0.8, "{share}");
    let full = frames[0].stats.rays;
    let inferred = frames[3].stats.rays;
    assert!(inferred.primary * 10 < full.primary, "{inferred:?}");
    assert!(frames[3].stats.samples.obscured > 0 && frames[3].stats.samples.missed > 0);
}

#[test]
fn a_moving_model_before_a_turning_camera() {
    let scene = with_camera(world(), rests(EYE), goes(TARGET, TARGET + DVec3::new(0.5, 0.0, 0.0)));
    assert!(audited(&with_flyer(scene)).1 > 0.7);
}

#[test]
fn a_model_that_rests_for_a_while_is_still_seen_by_a_moving_camera() {
    let place = DVec3::new(-0.4, 1.6, 1.5);
    let track = TransformTrack {
        translate: toy::keys(&[(1.0, place), (4.0, place), (6.0, place + DVec3::X)]),
        ..TransformTrack::identity()
    };
    let mut scene = with_camera(world(), goes(EYE, EYE + DVec3::new(1.0, 0.2, -1.5)), rests(TARGET));
    scene.models.push(toy::moving("rests at first", toy::octahedron(0, true), track));
    assert!(audited(&scene).1 > 0.6);
}

#[test]
fn everything_moves_at_once() {
    let mut scene =
        with_flyer(with_camera(world(), goes(EYE, EYE + DVec3::X), goes(TARGET, TARGET + DVec3::Y)));
    scene.lights[1].kind =
        LightKind::Point { position: goes(DVec3::new(2.0, 4.0, 3.0), DVec3::new(-2.0, 4.0, 3.0)) };
    scene.lights[0].color = toy::keys(&[(1.0, Vec3::ONE), (6.0, Vec3::X)]);
    assert!(audited(&scene).1 > 0.5);
}

#[test]
fn a_world_that_moves_as_a_whole_is_traced_where_that_is_left_to_the_program() {
    let mode_of = |models: bool| {
        let shift = if models { DVec3::X } else { DVec3::ZERO };
        let track = TransformTrack { translate: goes(DVec3::ZERO, shift), ..TransformTrack::identity() };
        let floor = match models {
            true => toy::moving("floor", toy::floor(30.0, 0), track),
            false => toy::still("floor", toy::floor(30.0, 0), Vec3::ZERO),
        };
        let camera = toy::camera(goes(EYE, EYE + DVec3::X), rests(TARGET));
        let scene = toy::scene(camera, vec![floor], vec![toy::matt(0.5)], vec![toy::sun_overhead(1.0)]);
        let settings = Settings { mode: Mode::Auto, ..toy::settings(2) };
        toy::render(&scene, &settings, 2)[1].stats.mode
    };
    assert_eq!((mode_of(false), mode_of(true)), ("reproject", "base"));
}

#[test]
fn a_moving_light_over_a_still_world() {
    let mut scene = world();
    scene.lights[1].kind =
        LightKind::Point { position: goes(DVec3::new(2.0, 4.0, 3.0), DVec3::new(-2.0, 4.0, 3.0)) };
    let (frames, share) = audited(&scene);
    assert_eq!(share, 1.0);
    assert_eq!(frames[2].stats.rays.primary, 0);
    assert!(frames[2].stats.rays.shadow > 0);
}

#[test]
fn a_recoloured_light_casts_no_rays_and_changes_the_picture() {
    let mut scene = world();
    scene.models.truncate(2);
    scene.lights[0].power = toy::keys(&[(1.0, 0.6), (6.0, 0.1)]);
    let (frames, _) = audited(&scene);
    assert_eq!(frames[3].stats.rays.total(), 0);
    let sunlit = toy::color(&frames[0], 48, 60);
    assert!(toy::color(&frames[5], 48, 60).x < sunlit.x);
}

#[test]
fn turning_spots() {
    for radius in [0.0, 0.4] {
        let mut scene = world();
        let kind = LightKind::Spot {
            position: rests(DVec3::new(0.0, 5.0, 2.0)),
            target: goes(DVec3::new(-2.0, 0.0, 0.0), DVec3::new(2.0, 0.0, 0.0)),
            cone: 40.0.into(),
            soft: 0.5.into(),
            fall: if radius > 0.0 { SpotFall::Square } else { SpotFall::Smooth },
            radius: radius.into(),
        };
        scene.lights.push(Light { ..toy::light("spot", kind, 20.0) });
        audited(&scene);
    }
}

#[test]
fn lights_that_grow_widen_and_sharpen() {
    let keyed = |from: f64, to: f64| toy::keys(&[(1.0, from), (f64::from(FRAMES), to)]);
    let (above, below) = (DVec3::new(0.0, 5.0, 2.0), DVec3::ZERO);
    let spot = LightKind::Spot {
        position: rests(above),
        target: rests(below),
        cone: keyed(20.0, 70.0),
        soft: keyed(1.0, 0.0),
        fall: SpotFall::Smooth,
        radius: keyed(0.05, 0.6),
    };
    let panel = Panel {
        size: toy::keys(&[(1.0, [0.2, 2.0]), (f64::from(FRAMES), [2.0, 0.5])]),
        spread: keyed(180.0, 40.0),
        ..Panel::at_rest(above, below, [1.0; 2])
    };
    let ball = LightKind::Sphere { position: rests(above), radius: keyed(0.1, 1.0), faces: false };
    let sun = LightKind::Sun { direction: rests(below - above), angle: keyed(1.0, 30.0) };
    for kind in [spot, LightKind::Rectangle(panel.clone()), LightKind::Disk(panel), ball, sun] {
        let mut scene = world();
        scene.lights = vec![toy::light("changes", kind, 20.0)];
        let (frames, _) = audited(&scene);
        assert!(frames[2].stats.rays.shadow > 0, "its shadows change");
    }
}

#[test]
fn a_panel_over_a_still_world_casts_no_ray_twice() {
    let mut scene = world();
    scene.models.truncate(2);
    scene.lights = vec![panel(rests(DVec3::new(1.0, 5.0, 2.0)))];
    let scene = with_camera(scene, goes(EYE, EYE + DVec3::X), rests(TARGET));
    let (_, share) = audited(&scene);
    assert!(share > 0.7, "{share}");
    // rays of occlusion count as shadow rays
    let frames = toy::render(&scene, &Settings { layers: Layers::USUAL, ..toy::settings(2) }, 4);
    let (base, inferred) = (&frames[0].stats, &frames[3].stats);
    assert!(base.rays.shadow > 10 * base.rays.primary, "{base:?}");
    let traced = inferred.samples.missed + inferred.samples.obscured;
    assert!(inferred.rays.shadow <= 16 * traced, "only new samples ask: {inferred:?}");
}

#[test]
fn panels_of_few_rays_over_a_flyer() {
    for samples in [1, 4] {
        let mut scene = with_flyer(world());
        let panel = panel(goes(DVec3::new(1.0, 5.0, 2.0), DVec3::new(1.5, 5.0, 2.0)));
        let still = Light { kind: self::panel(rests(DVec3::new(-1.0, 5.0, 2.0))).kind, ..panel.clone() };
        scene.lights = [panel, still].map(|light| Light { samples, ..light }).to_vec();
        let (frames, _) = audited(&scene);
        let (base, inferred) = (frames[0].stats.rays, frames[3].stats.rays);
        assert!(inferred.shadow < base.shadow, "the light at rest is remembered: {inferred:?}");
    }
}

#[test]
fn a_panel_over_a_flyer_is_asked_again_where_the_flyer_passes() {
    let mut scene = with_flyer(world());
    scene.models.retain(|model| ["floor", "matt", "flyer"].contains(&model.name.as_str()));
    scene.lights = vec![panel(rests(DVec3::new(1.0, 5.0, 2.0)))];
    let (frames, _) = audited(&scene);
    let (base, inferred) = (frames[0].stats.rays, frames[3].stats.rays);
    assert!(inferred.shadow > 0 && inferred.shadow * 3 < base.shadow, "{inferred:?}");
}

#[test]
fn a_moving_panel() {
    let mut scene = with_flyer(world());
    scene.lights.push(panel(goes(DVec3::new(1.0, 5.0, 2.0), DVec3::new(-1.0, 5.0, 2.0))));
    audited(&scene);
}

#[test]
fn tags_save_rays_and_change_no_pixel() {
    // under a camera that travels, that stands, and that stands before a world where nothing moves
    let travels = with_flyer(with_camera(world(), goes(EYE, EYE + DVec3::X), rests(TARGET)));
    for mut scene in [travels, with_flyer(world()), world()] {
        scene.lights.push(panel(rests(DVec3::new(1.0, 5.0, 2.0))));
        let settings = toy::settings(2);
        let run = |forget: bool| {
            let mut renderer = Renderer::new(&scene, &settings).expect("the scene builds");
            let frames = (1..=FRAMES).map(|frame| {
                if forget {
                    renderer.forget_tags();
                }
                renderer.render(frame, true).expect("renders")
            });
            frames.collect::<Vec<_>>()
        };
        for (kept, forgotten) in run(false).iter().zip(&run(true)) {
            for plane in kept.film.planes.iter().filter(|plane| !plane.name.starts_with("rays_")) {
                let other = forgotten.film.values(&plane.name).expect("the same planes");
                let differ = plane.values.to_floats().iter().zip(&other).filter(|(a, b)| a != b).count();
                assert_eq!(differ, 0, "frame {}: {}", kept.stats.frame, plane.name);
            }
            if kept.stats.frame > 1 {
                assert!(kept.stats.rays.shadow < forgotten.stats.rays.shadow);
            }
        }
    }
}

#[test]
fn spare_samples_learn_that_a_thing_came_between_them_and_the_light() {
    // while the camera goes away samples become spare, and serve again as it comes back
    let away = EYE + (EYE - TARGET) * 0.5;
    let goes_and_comes = toy::keys(&[(1.0, EYE), (3.0, away), (6.0, EYE)]);
    let mut scene = with_camera(matt_world(), goes_and_comes, rests(TARGET));
    scene.models.retain(|model| model.name != "flyer");
    // it comes while they are spare, and rests where it is when they serve
    let (below, above) = (DVec3::new(0.0, -50.0, 0.0), DVec3::new(1.0, 2.0, 1.5));
    let translate = toy::keys(&[(1.0, below), (2.0, below), (3.0, above), (6.0, above)]);
    let track = TransformTrack { translate, ..TransformTrack::identity() };
    scene.models.push(toy::moving("thing", toy::octahedron(0, true), track));
    let (_, share) = audited(&scene);
    assert!(share > 0.8, "{share}");
}

#[test]
fn layers_that_are_left_out_change_no_other() {
    let moving = with_flyer(with_camera(world(), goes(EYE, EYE + DVec3::X), rests(TARGET)));
    for (scene, filter) in [(moving, Filter::Box), (matt_world(), Filter::Box), (world(), Filter::Mitchell)] {
        let render = |layers: &str| {
            let layers = Layers::parse(layers).expect("known");
            toy::render(&scene, &Settings { filter, layers, ..toy::settings(2) }, 4)
        };
        // rays of occlusion count as shadow rays
        let without_occlusion: Vec<&str> =
            Layers::NAMES.into_iter().filter(|layer| *layer != "occlusion").collect();
        let (all, without_occlusion) = (render("all"), render(&without_occlusion.join(",")));
        for layers in [
            "none",
            "Z",
            "N,albedo",
            "P,object",
            "status",
            "rays,specular",
            "direct",
            "indirect,background",
            "denoise_normal",
            "denoise_variance",
            "occlusion",
            "motion",
            "forward,backward",
        ] {
            for (some, (all, without)) in render(layers).iter().zip(all.iter().zip(&without_occlusion)) {
                assert!(some.film.planes.len() < 12);
                for plane in &some.film.planes {
                    let all = if plane.name == "rays_shadow.V" { without } else { all };
                    assert_eq!(
                        all.film.values(&plane.name),
                        Some(plane.values.to_floats()),
                        "{}",
                        plane.name
                    );
                }
            }
        }
    }
}

#[test]
fn frames_are_the_same_for_any_number_of_threads() {
    let scene = with_flyer(with_camera(world(), goes(EYE, EYE + DVec3::X), rests(TARGET)));
    let with_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let settings = afterimage::settings::Settings {
            filter: afterimage::settings::Filter::Mitchell,
            ..toy::settings(3)
        };
        pool.install(|| toy::render(&scene, &settings, 4))
    };
    let alone = with_threads(1);
    for threads in [2, 5] {
        for (a, b) in alone.iter().zip(&with_threads(threads)) {
            assert!(a.film == b.film, "frame {}, {threads} threads", a.stats.frame);
            assert_eq!((a.stats.rays, a.stats.samples), (b.stats.rays, b.stats.samples));
        }
    }
}

#[test]
fn what_a_film_shows_already_is_what_would_be_rendered() {
    // some frames come again and again: all rests; and before the last one the camera turns
    const NUMBERS: [i32; 12] = [1, 2, 3, 3, 3, 4, 4, 5, 5, 6, 6, 6];
    let box_filter = toy::settings(2);
    let mitchell = Settings { filter: Filter::Mitchell, ..box_filter.clone() };
    let turn = toy::keys(&[(5.0, TARGET), (f64::from(FRAMES), TARGET + DVec3::X * 0.1)]);
    let matt = || (matt_world(), &box_filter);
    let glossy = || (with_flyer(world()), &box_filter);
    for (scene, settings) in [matt(), glossy(), (matt().0, &mitchell), (glossy().0, &mitchell)] {
        let scene = with_camera(scene, rests(EYE), turn.clone());
        let has_mirrors = scene.models.iter().any(|model| model.name == "mirror");
        let run = |may_reuse: bool| {
            // the other run is to have the same film
            let settings = Settings { audit: may_reuse, ..settings.clone() };
            let mut renderer = Renderer::new(&scene, &settings).expect("the scene builds");
            let mut held = Vec::new();
            let frames: [_; NUMBERS.len()] = std::array::from_fn(|at| {
                let finished = renderer.render(NUMBERS[at], true).expect("renders");
                let copy = Film::clone(&finished.film);
                // not every film is dropped in time
                if !may_reuse || at == 3 || at == 8 {
                    held.push(finished.film);
                }
                (copy, finished.stats)
            });
            frames.into_iter().enumerate()
        };
        let (mut beyond, mut beyond_fresh) = (0, 0);
        for ((at, (kept, stats)), (_, (fresh, fresh_stats))) in run(true).zip(run(false)) {
            assert_eq!(stats.audit.expect("asked for").wrong(), 0);
            beyond += stats.rays.reflection + stats.rays.refraction;
            beyond_fresh += fresh_stats.rays.reflection + fresh_stats.rays.refraction;
            // what a film shows in mirrors and glass casts no rays; with a wide filter what it shows beside the borders of tiles casts none
            let is_wide = settings.filter != Filter::Box;
            let may_differ =
                |name: &str| has_mirrors && name.starts_with("rays_") || is_wide && name == "rays_primary.V";
            for plane in kept.planes.iter().filter(|plane| !may_differ(&plane.name)) {
                let other = fresh.values(&plane.name).expect("the same planes");
                let differ = plane.values.to_floats().iter().zip(&other).filter(|(a, b)| a != b).count();
                assert_eq!(differ, 0, "frame {at}: {}", plane.name);
                let zero = other.iter().all(|value| *value == 0.0);
                assert!(zero || !plane.is_zero, "frame {at}: {} is not zero", plane.name);
            }
        }
        assert!(
            if has_mirrors { beyond * 10 < beyond_fresh * 9 } else { beyond == 0 },
            "{beyond} of {beyond_fresh}"
        );
    }
}

#[test]
fn a_mirror_shows_what_moves_behind_the_eye() {
    // the flyer is seen in the mirror alone, or its shadow on the screen is
    const LAST: i32 = LAST_BEFORE_MIRROR;
    let above = DVec3::new(0.0, 7.2, 5.0);
    let (hard, soft) = ((above, lamp(0.0, 9.0, 4.0)), (above, panel(rests(DVec3::new(0.0, 9.0, 4.0)))));
    for (flyer, light) in [seen_in_a_mirror(), hard, soft] {
        let scene = before_a_mirror(flyer, light);
        let layers = Layers::parse("reflection").expect("known");
        let settings = Settings { width: 192, height: 144, layers, ..toy::settings(1) };
        let run = |may_reuse: bool| {
            let mut renderer = Renderer::new(&scene, &settings).expect("the scene builds");
            let frames = (1..=LAST).map(|frame| {
                if !may_reuse {
                    renderer.forget_film();
                }
                let finished = renderer.render(frame, true).expect("renders");
                let shown = finished.film.values("reflection.R").expect("a plane");
                (shown, finished.stats.rays.reflection)
            });
            frames.collect::<Vec<_>>()
        };
        let (kept, fresh) = (run(true), run(false));
        for (frame, ((kept, _), (fresh, _))) in (1..).zip(kept.iter().zip(&fresh)) {
            assert!(kept == fresh, "frame {frame}, flyer at {flyer}");
        }
        let is_seen = kept[..LAST as usize - 1].windows(2).any(|frames| frames[0].0 != frames[1].0);
        assert!(is_seen, "the flyer or its shadow, {flyer}");
        let [cast, of] = [&kept, &fresh].map(|frames| frames.iter().map(|(_, rays)| rays).sum::<u64>());
        assert!(cast * 4 < of * 3, "{cast} of {of}, flyer at {flyer}");
    }
}

#[test]
fn what_is_at_rest_is_left_alone() {
    const MARK: f32 = 777.0;
    // the camera travels in the first two frames, and then holds; or it holds from the first one on
    let travels = toy::keys(&[(1.0, EYE), (2.0, EYE + DVec3::X * 0.2)]);
    let box_filter = [(travels.clone(), Filter::Box, 4), (rests(EYE), Filter::Box, 1)];
    let mitchell = [(travels, Filter::Mitchell, 4), (rests(EYE), Filter::Mitchell, 1)];
    for (eye, filter, marked) in box_filter.into_iter().chain(mitchell) {
        let scene = with_camera(matt_world(), eye, rests(TARGET));
        let settings = Settings { width: 192, height: 144, filter, ..toy::settings(2) };
        let mut renderer = Renderer::new(&scene, &settings).expect("the scene builds");
        let mut render = |frame: i32, mark: bool| {
            let film = renderer.render(frame, true).expect("renders").film;
            let is_marked = |value: &&f32| **value == MARK;
            let marked =
                ["R", "P.X"].map(|name| film.values(name).expect("a plane").iter().filter(is_marked).count());
            drop(film);
            renderer.spoil_film(|film| {
                for plane in
                    film.planes.iter_mut().filter(|plane| mark && matches!(&*plane.name, "R" | "P.X"))
                {
                    let count = plane.values.len();
                    plane.values = Values::of(plane.kind, &vec![MARK; count]);
                }
            });
            marked
        };
        (1..=marked).for_each(|frame| assert_eq!(render(frame, frame == marked), [0; 2]));
        let pixels = 192 * 144;
        for left in render(marked + 1, false) {
            assert!(left > pixels / 4 && left < pixels, "{filter:?}, frame {marked}: {left}");
        }
    }
}

#[test]
fn a_still_camera_gives_what_a_camera_that_hardly_turns_gives() {
    // the way for still cameras and the general way, over the same samples, in a world where all is matt
    let turning = |degrees: f64| {
        let mut scene = matt_world();
        scene.camera.aim = Aim::Target { target: rests(TARGET), roll: goes_by(degrees) };
        toy::render(&scene, &toy::settings(2), FRAMES)
    };
    for (still, turned) in turning(0.0).iter().zip(&turning(1e-4)) {
        let reused = |finished: &Finished| finished.stats.samples.good + finished.stats.samples.overlapped;
        let (a, b) = (reused(still), reused(turned));
        assert!(a.abs_diff(b) * 200 <= a.max(b), "frame {}: {a} and {b}", still.stats.frame);
        let differ = toy::mean_difference(still, turned, "R");
        assert!(differ < 2e-3, "frame {}: {differ}", still.stats.frame);
    }
}

fn goes_by(degrees: f64) -> Track<f64> {
    toy::keys(&[(1.0, 0.0), (f64::from(FRAMES), degrees)])
}

#[test]
fn the_automatic_mode_traces_where_nothing_is_seen_again() {
    let automatic =
        afterimage::settings::Settings { mode: afterimage::settings::Mode::Auto, ..toy::audited(2) };
    let modes = |target: Track<DVec3>| {
        let scene = with_camera(world(), rests(EYE), target);
        let frames = toy::render(&scene, &automatic, FRAMES);
        assert!(frames.iter().all(|frame| toy::differing(frame) == 0));
        frames.iter().map(|frame| frame.stats.mode).collect::<Vec<_>>()
    };
    let behind = 2.0 * EYE - TARGET;
    let keys: Vec<_> =
        (1..=FRAMES).map(|frame| (f64::from(frame), if frame % 2 == 0 { behind } else { TARGET })).collect();
    assert_eq!(modes(toy::keys(&keys)), vec!["base"; FRAMES as usize]);
    let slowly = modes(goes(TARGET, TARGET + DVec3::X));
    assert_eq!(slowly[1..], ["reproject"; FRAMES as usize - 1]);
}

#[test]
fn a_long_chain_does_not_wear_out() {
    const LAST: i32 = 60;
    let scene = with_camera(
        matt_world(),
        toy::keys(&[(1.0, EYE), (f64::from(LAST), EYE - DVec3::new(0.9, 0.2, 0.9))]),
        rests(TARGET),
    );
    let layers = Layers::NONE;
    let settings = Settings { width: 192, height: 144, mode: Mode::Auto, layers, ..toy::audited(2) };
    let frames = toy::render(&scene, &settings, LAST);
    assert!(frames.iter().all(|frame| toy::differing(frame) == 0));
    assert!(frames[1..].iter().all(|frame| frame.stats.mode == "reproject"), "no fresh start");
    let traced = |frames: &[Finished]| {
        let samples = frames.iter().map(|frame| frame.stats.samples);
        samples.map(|samples| samples.missed + samples.obscured).sum::<u64>() as f64 / frames.len() as f64
    };
    let all = frames[0].stats.samples.total() as f64;
    let (young, old) = (traced(&frames[2..12]) / all, traced(&frames[50..]) / all);
    assert!(old < 0.015 && old < 2.0 * young, "{young} {old}");
}

#[test]
fn the_automatic_mode_traces_where_all_that_was_seen_falls_into_few_cells() {
    let layers = Layers::USUAL;
    let automatic = Settings { width: 320, height: 240, mode: Mode::Auto, layers, ..toy::settings(2) };
    let mode_after = |fov: f64| {
        let mut scene = world();
        scene.camera.fov = toy::keys(&[(1.0, 20.0), (2.0, fov)]);
        toy::render(&scene, &automatic, 2)[1].stats.mode
    };
    assert_eq!((mode_after(21.0), mode_after(80.0)), ("reproject", "base"));
}

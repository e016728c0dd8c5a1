//! Before a camera at rest: is what mirrors and glass show kept while it holds, and is it what would be traced?

use afterimage::frame::{Finished, Renderer};
use afterimage::scene::material::{MetalRough, Optics};
use afterimage::scene::{Environment, Material, Scene, environment::Sky};
use afterimage::settings::{Filter, Refinement, Settings};
use afterimage::stats::FrameStats;
use glam::{DVec3, Vec3};

use crate::toy;
use crate::toy::worlds::*;

const FRAMES: i32 = 9;

/// A mirror, and a flyer that it shows in some of the frames.
fn mirror() -> Scene {
    let (middle, light) = seen_in_a_mirror();
    before_a_mirror(middle, light)
}

/// The same with a mirror behind the eye, so that there are mirrors in the mirror, and a soft light.
fn two_mirrors() -> Scene {
    let mut scene = before_a_mirror(DVec3::new(0.0, 1.5, 5.0), panel(rests(DVec3::new(0.0, 6.0, 5.0))));
    let corners = [[4.0, -1.0, 7.0], [-4.0, -1.0, 7.0], [-4.0, 5.0, 7.0], [4.0, 5.0, 7.0]];
    let mesh = toy::mesh(&corners, &[[0, 1, 2], [0, 2, 3]], 0, true);
    scene.models.push(toy::still("other", mesh, Vec3::ZERO));
    scene
}

/// A pane of glass, through which a flyer is seen and a rough floor that reflects it, under a sky.
fn glass_and_gloss() -> Scene {
    let mut scene = mirror();
    let glass = Material { optics: Optics::clear(Vec3::splat(0.9), 1.4, Vec3::ONE), ..Material::fallback() };
    let base = Vec3::splat(0.8);
    let rough = MetalRough { base, roughness: 0.3, metallic: 1.0, head_on: 0.04, solid: 1.0 };
    let rough = Material { metal_rough: Some(rough), diffuse: Vec3::ZERO, ..Material::fallback() };
    scene.materials.extend([glass, rough]);
    let corners = [[-3.0, -1.0, 2.0], [3.0, -1.0, 2.0], [3.0, 4.0, 2.0], [-3.0, 4.0, 2.0]];
    let pane = toy::mesh(&corners, &[[0, 1, 2], [0, 2, 3]], 2, true);
    scene.models.push(toy::still("pane", pane, Vec3::ZERO));
    scene.models.push(toy::still("floor", toy::floor(4.0, 3), Vec3::Y * -0.9));
    scene.environment = Some(Environment::from_sky(&Sky::default()));
    scene
}

fn run(scene: &Scene, settings: &Settings, threads: usize) -> Vec<(afterimage::film::Film, FrameStats)> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(|| {
        let mut renderer = Renderer::new(scene, settings).expect("the scene builds");
        let render = |frame| {
            let Finished { film, stats, .. } = renderer.render(frame, true).expect("renders");
            (afterimage::film::Film::clone(&film), stats)
        };
        (1..=FRAMES).map(render).collect()
    })
}

fn rays_beyond(frames: &[(afterimage::film::Film, FrameStats)]) -> u64 {
    // the second frame traces all of them
    frames[2..].iter().map(|(_, stats)| stats.rays.reflection + stats.rays.refraction).sum()
}

#[test]
fn pixels_are_the_same_whatever_is_kept_and_by_how_many_threads() {
    let small = Settings { width: 64, height: 48, ..toy::settings(2) };
    let refinement = Some(Refinement { most: 4, threshold: 0.1 });
    let cases = [
        (mirror(), small.clone()),
        (mirror(), Settings { filter: Filter::Mitchell, ..small.clone() }),
        (two_mirrors(), Settings { samples: 1, refinement, ..small.clone() }),
        (two_mirrors(), Settings { paths: 4, ..small.clone() }),
        (glass_and_gloss(), small),
    ];
    for (number, (scene, settings)) in cases.into_iter().enumerate() {
        let with = |tree_memory: u32, threads: usize| {
            run(&scene, &Settings { tree_memory, ..settings.clone() }, threads)
        };
        // the others have the same samples and the same film
        let kept = run(&scene, &Settings { tree_memory: 256, audit: true, ..settings.clone() }, 1);
        for (_, stats) in &kept {
            assert_eq!(stats.audit.expect("asked for").wrong(), 0, "case {number}, frame {}", stats.frame);
        }
        for (other, is_same) in [(with(256, 2), true), (with(256, 5), true), (with(0, 2), false)] {
            for ((a, stats), (b, other_stats)) in kept.iter().zip(&other) {
                for plane in a.planes.iter().filter(|plane| is_same || !plane.name.starts_with("rays_")) {
                    let other = b.values(&plane.name).expect("the same planes");
                    assert!(
                        plane.values.to_floats() == other,
                        "case {number}, frame {}: {}",
                        stats.frame,
                        plane.name
                    );
                }
                assert!(!is_same || stats.rays == other_stats.rays, "case {number}");
            }
        }
    }
}

#[test]
fn rays_are_cast_again_for_those_samples_alone_whose_view_changes() {
    for scene in [mirror(), two_mirrors(), glass_and_gloss()] {
        let settings = Settings { width: 192, height: 144, ..toy::settings(1) };
        let with = |tree_memory| rays_beyond(&run(&scene, &Settings { tree_memory, ..settings.clone() }, 2));
        let (kept, tiles) = (with(256), with(0));
        assert!(kept > 0 && kept * 2 < tiles, "{kept} of {tiles}");
    }
}

#[test]
fn a_budget_bounds_what_is_kept() {
    let scene = mirror();
    let settings = Settings { width: 320, height: 240, ..toy::settings(2) };
    let with = |tree_memory| {
        let settings = Settings { tree_memory, ..settings.clone() };
        let mut renderer = Renderer::new(&scene, &settings).expect("the scene builds");
        let render = |frame| renderer.render(frame, true).expect("renders").stats.rays.reflection;
        let rays: u64 = (1..=6).map(render).skip(2).sum();
        (rays, renderer.memory().store_bytes)
    };
    let [none, little, all] = [0, 8, 256].map(with);
    assert!(none.0 > little.0 && little.0 > all.0, "rays: {none:?} {little:?} {all:?}");
    assert!(little.1 > none.1 && little.1 <= none.1 + (8 << 20), "bytes: {none:?} {little:?}");
    // three quarters of the picture are a mirror
    assert!(all.1 > none.1 + 3 * 320 * 240 * 28, "bytes: {none:?} {all:?}");
}

#[test]
fn a_camera_that_moves_keeps_nothing() {
    let mut scene = mirror();
    scene.camera = toy::camera(goes(EYE, EYE + DVec3::X), rests(TARGET));
    let with = |tree_memory| {
        let mut renderer =
            Renderer::new(&scene, &Settings { tree_memory, ..toy::settings(1) }).expect("the scene builds");
        let rays: Vec<_> =
            (1..=4).map(|frame| renderer.render(frame, true).expect("renders").stats.rays).collect();
        (rays, renderer.memory().store_bytes)
    };
    assert_eq!(with(256), with(0));
}

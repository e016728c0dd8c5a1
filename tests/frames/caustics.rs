//! Is light right that comes by way of glass, where paths alone find it, and is what is kept of it what would be made anew?

use std::f64::consts::{PI, TAU};

use afterimage::frame::{Finished, Renderer};
use afterimage::layers::Layers;
use afterimage::scene::material::{MetalRough, Optics};
use afterimage::scene::{Background, Environment, LightKind, Material, Panel, Scene};
use afterimage::settings::{Caustics, Settings};
use afterimage::trace::BackendKind;
use glam::{DAffine3, DVec3, Vec3};

use crate::toy;
use crate::toy::worlds::*;

fn settings(caustics: Caustics, paths: u32, bounces: u32) -> Settings {
    Settings { caustics, paths, bounces, ..toy::settings(1) }
}

fn glass(index: f32) -> Material {
    let optics = Optics::clear(Vec3::ONE, index, Vec3::ONE);
    Material { optics, ..toy::matt(0.0) }
}

/// Frame 1 of `scene`.
fn first(scene: &Scene, settings: &Settings) -> Finished {
    toy::render(scene, settings, 1).remove(0)
}

const ALBEDO: f32 = 0.6;

/// Of the floor.
const HALF: f64 = 4.0;

const BALL: (DVec3, f64, f64) = (DVec3::new(0.0, 1.1, 0.0), 0.6, 1.5);

/// Height and half of the edges of the panel.
const PANEL: (f64, f64) = (3.0, 0.9);

/// Radiance of whatever shines.
const SHINES: f64 = 2.0;

/// What shines on the ball and the floor.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Shining {
    /// A light.
    Panel,
    /// A mesh of the same shape.
    Surface,
    Sky,
}

/// A glass ball above a floor, which a camera sees below the ball, and all of what is above it black but for what shines.
fn ball(shining: Shining) -> Scene {
    let mut camera = toy::camera(rests(DVec3::new(0.0, 0.45, 2.2)), rests(DVec3::ZERO));
    camera.fov = afterimage::animation::Track::constant(25.0);
    let (center, radius, index) = BALL;
    let at = DAffine3::from_scale_rotation_translation(DVec3::splat(radius), glam::DQuat::IDENTITY, center);
    let mut models = vec![
        toy::still("floor", toy::floor(HALF as f32, 0), Vec3::ZERO),
        toy::still_quadric("ball", &toy::sphere(), 1, false, at),
    ];
    let glowing = Material { emission: Vec3::splat(SHINES as f32), ..toy::matt(0.0) };
    let (height, half) = PANEL;
    let mut lights = vec![];
    match shining {
        Shining::Panel => {
            let panel = Panel::at_rest(DVec3::Y * height, DVec3::ZERO, [2.0 * half; 2]);
            let kind = LightKind::Rectangle(panel);
            lights.push(toy::light("panel", kind, SHINES * (2.0 * half).powi(2) / PI));
        }
        Shining::Surface => {
            let panel = toy::floor(half as f32, 2);
            models.push(toy::still("panel", panel, Vec3::Y * height as f32));
        }
        Shining::Sky => {}
    }
    let materials = vec![toy::matt(ALBEDO), glass(index as f32), glowing];
    let mut scene = toy::scene(camera, models, materials, lights);
    let sky = if shining == Shining::Sky { SHINES } else { 0.0 };
    scene.background = Background::uniform(Vec3::splat(sky as f32));
    if shining == Shining::Sky {
        scene.environment = Some(Environment::from_background(&scene.background));
    }
    scene
}

/// Numbers from 0 to below 1 (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", 2014).
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ mixed >> 31) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// What a path brings that leaves the floor at `point`: all by chance, in double floats, with geometry of its own. It asks
/// nothing for light.
fn brought(shining: Shining, point: DVec3, chance: &mut Chance) -> f64 {
    const SURFACES: u32 = 30;
    let (mut from, mut way, mut weight) = (point, up(chance), 1.0);
    for _ in 0..SURFACES {
        let (center, radius, index) = BALL;
        let (along, apart) = (way.dot(center - from), (from - center).length_squared() - radius * radius);
        let square = along * along - apart;
        let ends = [along - square.max(0.0).sqrt(), along + square.max(0.0).sqrt()];
        let of_ball = ends.into_iter().find(|far| square > 0.0 && *far > 1e-6);
        if let Some(far) = of_ball {
            from += way * far;
            way = through(way, (from - center) / radius, index, chance);
            continue;
        }
        if way.y < 0.0 {
            from += way * (-from.y / way.y);
            if from.x.abs().max(from.z.abs()) > HALF {
                return if shining == Shining::Sky { weight * SHINES } else { 0.0 };
            }
            (way, weight) = (up(chance), weight * f64::from(ALBEDO));
            continue;
        }
        let (height, half) = PANEL;
        let above = from + way * ((height - from.y) / way.y);
        let meets = shining == Shining::Sky || above.x.abs().max(above.z.abs()) < half;
        return if meets { weight * SHINES } else { 0.0 };
    }
    0.0
}

/// A direction by the cosine law about Y.
fn up(chance: &mut Chance) -> DVec3 {
    let (square, turn) = (chance.next(), TAU * chance.next());
    let across = square.sqrt();
    DVec3::new(across * turn.cos(), (1.0 - square).sqrt(), across * turn.sin())
}

/// Where light goes on that meets the glass along `way`: mirrored, or refracted, as likely as Fresnel's equations say.
fn through(way: DVec3, outwards: DVec3, index: f64, chance: &mut Chance) -> DVec3 {
    let leaves = way.dot(outwards) > 0.0;
    let (normal, eta) = if leaves { (-outwards, index) } else { (outwards, 1.0 / index) };
    let cos = -way.dot(normal);
    let mirrored = way + normal * (2.0 * cos);
    let square = 1.0 - eta * eta * (1.0 - cos * cos);
    if square <= 0.0 {
        return mirrored;
    }
    let cos_beyond = square.sqrt();
    let across = (eta * cos - cos_beyond) / (eta * cos + cos_beyond);
    let along = (cos - eta * cos_beyond) / (cos + eta * cos_beyond);
    if chance.next() < 0.5 * (across * across + along * along) {
        return mirrored;
    }
    (way * eta + normal * (eta * cos - cos_beyond)).normalize()
}

/// Points of the floor whose distance from below the ball is in a range, and what pixels show of them.
fn shown(finished: &Finished, [least, most]: [f32; 2]) -> Vec<(DVec3, f64)> {
    let [green, x, z, object] =
        ["G", "P.X", "P.Z", "object.V"].map(|plane| finished.film.values(plane).expect("it is there"));
    let is_there = |pixel: &usize| {
        object[*pixel] == 1.0 && (least..most).contains(&glam::Vec2::new(x[*pixel], z[*pixel]).length())
    };
    let at = |pixel: usize| (DVec3::new(x[pixel].into(), 0.0, z[pixel].into()), f64::from(green[pixel]));
    let shown: Vec<(DVec3, f64)> = (0..green.len()).filter(is_there).map(at).collect();
    assert!(shown.len() > 300, "{} pixels from {least} to {most}", shown.len());
    shown
}

/// The mean of what is shown.
fn mean(shown: &[(DVec3, f64)]) -> f64 {
    shown.iter().map(|(_, green)| green).sum::<f64>() / shown.len() as f64
}

/// What it should be.
fn mean_by_chance(shining: Shining, shown: &[(DVec3, f64)]) -> f64 {
    const PATHS: usize = 200;
    let mut chance = Chance(7);
    let sum: f64 = shown
        .iter()
        .flat_map(|(point, _)| [*point; PATHS])
        .map(|point| brought(shining, point, &mut chance))
        .sum();
    f64::from(ALBEDO) * sum / (shown.len() * PATHS) as f64
}

/// In the shadow of a glass ball and around it there is as much light as paths by chance alone bring: whatever shines is
/// counted once. As if glass were not there for shadows, too: there is no more than what comes straight or what comes bent.
#[test]
fn light_through_a_ball_is_what_paths_by_chance_bring() {
    for shining in [Shining::Panel, Shining::Surface, Shining::Sky] {
        let mut scene = ball(shining);
        let finished = first(&scene, &settings(Caustics::Paths, 256, 8));
        for range in [[0.0, 0.3], [0.3, 0.6], [0.6, 1.0]] {
            let shown = shown(&finished, range);
            let (seen, wanted) = (mean(&shown), mean_by_chance(shining, &shown));
            println!(
                "{shining:?} {range:?}: {seen:.4}, by chance {wanted:.4}: {:+.2} %",
                100.0 * (seen / wanted - 1.0)
            );
            assert!((seen / wanted - 1.0).abs() < 0.02, "{shining:?} {range:?}: {seen}, {wanted}");
        }
        let range = [0.3, 0.6];
        let as_if_not_there = shown(&first(&scene, &settings(Caustics::None, 64, 8)), range);
        let (seen, wanted) = (mean(&as_if_not_there), mean_by_chance(shining, &as_if_not_there));
        scene.models.remove(1);
        let straight = mean(&shown(&first(&scene, &settings(Caustics::None, 64, 8)), range));
        println!("{shining:?} without shadows: {:+.1} %", 100.0 * (seen / wanted - 1.0));
        println!("{shining:?} without a ball: {:+.1} %", 100.0 * (straight / wanted - 1.0));
        let (least, most) = (straight.min(wanted), straight.max(wanted));
        assert!((0.99 * least..1.01 * most).contains(&seen), "{shining:?}: {seen}, {straight}, {wanted}");
    }
}

/// The last surface of a path may be the far side of the ball: what is behind is found as a surface that scatters finds it.
#[test]
fn a_ball_takes_two_bounces() {
    for shining in [Shining::Panel, Shining::Surface, Shining::Sky] {
        let of = |bounces| {
            mean(&shown(&first(&ball(shining), &settings(Caustics::Paths, 32, bounces)), [0.0, 0.3]))
        };
        let [one, two, eight] = [1, 2, 8].map(of);
        assert!(one < 0.8 * eight && two > 0.95 * eight, "{shining:?}: {one}, {two}, {eight}");
    }
}

/// Two panes between the floor and whatever shines.
fn with_panes(mut scene: Scene, glass: Material) -> Scene {
    let mut mesh = toy::floor(200.0, 1);
    mesh.shadow_casting = if glass.casts_shadow() { mesh.count() } else { 0 };
    for height in [1.9, 2.0] {
        scene.models.push(toy::still("pane", mesh.clone(), Vec3::Y * height));
    }
    scene.materials[1] = glass;
    scene
}

/// A floor below whatever shines, and nothing else.
fn floor(shining: Shining, material: Material) -> Scene {
    let mut scene = ball(shining);
    scene.models.remove(1);
    scene.materials[0] = material;
    scene
}

/// The mean of the picture.
fn mean_of(scene: &Scene, settings: &Settings) -> f32 {
    let values = first(scene, settings).film.values("G").expect("it is there");
    values.iter().sum::<f32>() / values.len() as f32
}

fn metal(roughness: f32) -> Material {
    let metal_rough =
        MetalRough { base: Vec3::splat(0.8), roughness, metallic: 1.0, head_on: 0.04, solid: 1.0 };
    Material { diffuse: Vec3::ZERO, metal_rough: Some(metal_rough), ..Material::fallback() }
}

/// Panes that neither bend nor dim light change nothing, whatever is behind them: matt, with light that comes by one surface or by
/// several, or rough metal, whose highlights such a pane blocks if it casts a shadow. What is behind them counts once.
#[test]
fn panes_that_nobody_sees_change_nothing() {
    // the smooth one shows the lights in few pixels; below the awning each pixel shows what is far away
    for (name, material, bounces, bound) in [
        ("matt", toy::matt(0.6), 2, 0.005),
        ("below an awning", toy::matt(0.6), 6, 0.02),
        ("below a metal awning", toy::matt(0.6), 6, 0.02),
        ("rough", metal(0.5), 2, 0.005),
        ("smooth", metal(0.25), 2, 0.04),
    ] {
        for shining in [Shining::Panel, Shining::Surface, Shining::Sky] {
            let mut scene = floor(shining, material.clone());
            if name.ends_with("awning") {
                scene.materials.push(if name.contains("metal") { metal(0.5) } else { toy::matt(0.6) });
                scene.models.push(toy::still("awning", toy::floor(0.6, 3), Vec3::Y * 0.9));
            }
            let settings = |caustics| Settings {
                reflections: 64,
                samples: if name == "rough" { 2 } else { 1 },
                depth: 5,
                layers: Layers::NONE,
                ..settings(caustics, 32, bounces)
            };
            let free = mean_of(&scene, &settings(Caustics::None));
            let scene = with_panes(scene, glass(1.0));
            // where rays pass, both ways together find what they find without panes; but a scene as wide as the panes
            // are takes what glows for one part, and chooses other points on it
            let passing = if shining == Shining::Surface { 0.002 } else { 0.001 };
            for (caustics, bound) in [(Caustics::None, passing), (Caustics::Paths, bound)] {
                let behind = mean_of(&scene, &settings(caustics));
                let more = behind / free - 1.0;
                println!("{name}, {shining:?}, {caustics:?}: {behind}, {free}: {:+.2} %", 100.0 * more);
                assert!(more.abs() < bound, "{name}, {shining:?}, {caustics:?}: {behind}, {free}");
            }
        }
    }
}

/// Glass that does not bend light, but dims it.
fn dim(transmission: f32) -> Material {
    let optics = Optics::clear(Vec3::splat(transmission), 1.0, Vec3::ONE);
    Material { optics, ..toy::matt(0.0) }
}

/// Rays that ask for light pass panes that dim it as if they were not there, paths do not: there is between what the panes let
/// through and all of it, all where nothing but rays asks, and what they let through where nothing but paths does.
#[test]
fn behind_panes_that_dim_light_no_more_arrives_than_without() {
    const DIM: f32 = 0.6;
    let gradient = |scene: Scene| Scene { environment: None, ..scene };
    for (name, scene, bounds) in [
        ("panel", floor(Shining::Panel, toy::matt(0.6)), [0.995, 1.005]),
        ("surface", floor(Shining::Surface, toy::matt(0.6)), [DIM * DIM, 0.98]),
        ("sky", floor(Shining::Sky, toy::matt(0.6)), [DIM * DIM, 0.98]),
        ("gradient", gradient(floor(Shining::Sky, toy::matt(0.6))), [0.99 * DIM * DIM, 1.01 * DIM * DIM]),
    ] {
        let settings = |caustics| settings(caustics, 32, 2);
        let mean = |scene: &Scene, caustics| mean(&shown(&first(scene, &settings(caustics)), [0.0, 1.0]));
        let free = mean(&scene, Caustics::None);
        let scene = with_panes(scene, dim(DIM));
        let [share, dimmed] = [Caustics::None, Caustics::Paths].map(|way| (mean(&scene, way) / free) as f32);
        println!("{name}: {share}, {dimmed}");
        assert!((bounds[0]..bounds[1]).contains(&share), "{name}: {share}");
        assert!((dimmed / (DIM * DIM) - 1.0).abs() < 0.01, "{name}: {dimmed}");
    }
}

/// Panes too dark for rays that ask: what is behind them counts in full where other rays find it, and is dimmed.
#[test]
fn what_is_behind_dark_panes_is_dimmed_and_counts_in_full() {
    const DARK: f32 = 0.4;
    for (name, material) in [("matt", toy::matt(0.6)), ("rough", metal(0.5))] {
        for shining in [Shining::Panel, Shining::Surface, Shining::Sky] {
            let scene = floor(shining, material.clone());
            let settings = Settings { reflections: 64, ..settings(Caustics::None, 32, 3) };
            let mean = |scene: &Scene| mean(&shown(&first(scene, &settings), [0.0, 1.0]));
            let free = mean(&scene);
            let scene = with_panes(scene, dim(DARK));
            let share = mean(&scene) / free / f64::from(DARK * DARK);
            println!("{name}, {shining:?}: {share}");
            assert!((share - 1.0).abs() < 0.02, "{name}, {shining:?}: {share}");
        }
    }
}

/// Clear glass casts a shadow: a mesh and a quadric, still ones and those that move, with either tracer.
#[test]
fn glass_casts_shadows() {
    let moves = || goes(DVec3::new(0.0, 2.0, 0.0), DVec3::new(0.1, 2.0, 0.0));
    let track = || afterimage::animation::TransformTrack {
        translate: moves(),
        ..afterimage::animation::TransformTrack::identity()
    };
    let mesh = || toy::octahedron(1, false);
    let quadric = |material| afterimage::scene::Mesh::of_curved(toy::sphere(), material, false);
    for kind in [BackendKind::Embree, BackendKind::Rust] {
        for thing in [
            toy::still("mesh", mesh(), Vec3::Y * 2.0),
            toy::moving("mesh", mesh(), track()),
            toy::still_quadric("ball", &toy::sphere(), 1, false, DAffine3::from_translation(DVec3::Y * 2.0)),
            toy::moving("ball", quadric(1), track()),
        ] {
            let camera = toy::camera(rests(DVec3::new(0.0, 0.4, 2.0)), rests(DVec3::ZERO));
            let floor = toy::still("floor", toy::floor(9.0, 0), Vec3::ZERO);
            let materials = vec![toy::matt(0.5), glass(1.5)];
            let scene = toy::scene(camera, vec![floor, thing], materials, vec![toy::sun_overhead(1.0)]);
            let shown = |caustics| {
                let settings = Settings { audit: true, ..settings(caustics, 0, 0) };
                let mut renderer = Renderer::with(kind, &scene, &settings).expect("it builds");
                let finished = renderer.render(1, true).expect("it renders");
                assert_eq!(toy::differing(&finished), 0);
                toy::color(&finished, 48, 36).y
            };
            let [through, blocked] = [Caustics::None, Caustics::Paths].map(shown);
            assert!((through - 0.5).abs() < 1e-3 && blocked == 0.0, "{kind:?}: {through}, {blocked}");
        }
    }
}

/// A flyer of glass between lights and what they shine on.
fn with_glass_flyer(scene: Scene) -> Scene {
    let mut scene = with_flyer(scene);
    let flyer = scene.models.last_mut().expect("it is there");
    flyer.mesh = std::sync::Arc::new(toy::octahedron(2, false));
    scene
}

/// Where glass moves, shadows and what paths found through it do, too.
#[test]
fn what_is_kept_behind_glass_that_moves_is_what_would_be_made_anew() {
    let lamps = with_glass_flyer(world());
    let areas = with_glass_flyer(with_area_lights(world()));
    let mut sky = with_glass_flyer(world());
    sky.environment = Some(Environment::from_background(&sky.background));
    let mut glows = with_glass_flyer(world());
    glows.materials.push(Material { emission: Vec3::splat(8.0), ..toy::matt(0.0) });
    glows.models.push(toy::still("glows", toy::octahedron(3, true), Vec3::new(-1.0, 4.0, 1.0)));
    let by_camera = |scene: &Scene| {
        with_camera(scene.clone(), goes(EYE, EYE + DVec3::new(0.6, -0.2, 0.3)), rests(TARGET))
    };
    for (name, scene) in [("lamps", lamps), ("areas", areas), ("sky", sky), ("glows", glows)] {
        for scene in [by_camera(&scene), scene] {
            for caustics in [Caustics::None, Caustics::Paths] {
                let settings = Settings { audit: true, ..settings(caustics, 3, 3) };
                for (number, finished) in toy::render(&scene, &settings, FRAMES).iter().enumerate() {
                    assert_eq!(toy::differing(finished), 0, "{name}, {caustics:?}, frame {}", number + 1);
                    let reused = finished.stats.samples.reused();
                    assert!(number == 0 || reused > 0, "{name}, {caustics:?}: nothing is reused");
                }
            }
        }
    }
}

/// A ball of rough gold on a matt floor, under an even sky and two small lamps before which there is a ball of glass: a few rays off the
/// gold and a few paths off the floor meet a lamp by way of the glass.
fn glass_before_gold() -> Scene {
    let mut camera = toy::camera(rests(DVec3::new(0.0, 1.4, 4.0)), rests(DVec3::new(0.0, 0.6, 0.0)));
    camera.fov = afterimage::animation::Track::constant(30.0);
    let ball = |name, material, center| {
        let at = DAffine3::from_scale_rotation_translation(DVec3::splat(0.8), glam::DQuat::IDENTITY, center);
        toy::still_quadric(name, &toy::sphere(), material, material != 1, at)
    };
    let models = vec![
        toy::still("floor", toy::floor(HALF as f32, 0), Vec3::ZERO),
        ball("glass", 1, DVec3::new(0.0, 2.3, 0.9)),
        ball("gold", 2, DVec3::new(0.0, 0.8, -0.6)),
    ];
    let base = Vec3::new(1.0, 0.77, 0.34);
    let metal_rough = MetalRough { base, roughness: 0.4, metallic: 1.0, head_on: 0.04, solid: 1.0 };
    let gold = Material { diffuse: Vec3::ZERO, metal_rough: Some(metal_rough), ..toy::matt(0.0) };
    let lamps = [-1.0, 1.0].map(|x| {
        let kind =
            LightKind::Sphere { position: rests(DVec3::new(x, 3.5, 1.0)), radius: 0.1.into(), faces: false };
        toy::light("lamp", kind, 6.0)
    });
    let mut scene = toy::scene(camera, models, vec![toy::matt(0.5), glass(1.5), gold], lamps.to_vec());
    scene.background = Background::uniform(Vec3::splat(0.4));
    scene.environment = Some(Environment::from_background(&scene.background));
    scene
}

fn colors(finished: &Finished) -> Vec<f32> {
    ["R", "G", "B"].iter().flat_map(|plane| finished.film.values(plane).expect("it is there")).collect()
}

/// The figures in docs/quality.md: a limit takes sparks, and some of the light.
#[test]
fn a_limit_takes_sparks_and_a_little_light() {
    let scene = glass_before_gold();
    let rendered = |samples, (paths, reflections), clamp| {
        let settings = Settings {
            width: 48,
            height: 36,
            samples,
            reflections,
            clamp,
            ..settings(Caustics::Paths, paths, 4)
        };
        colors(&first(&scene, &settings))
    };
    let mean = |light: &[f32]| light.iter().sum::<f32>() / light.len() as f32;
    let truth = rendered(10, (32, 16), None);
    let error = |light: &[f32]| {
        let squares: f32 = light.iter().zip(&truth).map(|(a, b)| (a - b).powi(2)).sum();
        (squares / light.len() as f32).sqrt()
    };
    println!("reference: mean {:.4}", mean(&truth));
    let of = |clamp| {
        let light = rendered(4, (16, 4), clamp);
        let brightest = light.iter().fold(0.0_f32, |most, light| most.max(*light));
        println!(
            "{clamp:?}: mean {:+.2} %, RMSE {:.4}, brightest {brightest:.1}",
            100.0 * (mean(&light) / mean(&truth) - 1.0),
            error(&light)
        );
        (mean(&light), error(&light), light)
    };
    let (free, noisy, off) = of(None);
    let [_, some, _] = [10.0, 3.0, 1.0].map(|most| of(Some(most)));
    assert!(some.1 < 0.6 * noisy, "{} {noisy}", some.1);
    assert!(some.0 < free && some.0 > 0.9 * free, "{} {free}", some.0);
    // what nothing reaches is as if it were not there
    assert_eq!(rendered(4, (16, 4), Some(1e9)), off);
}

/// What shines on a surface directly is not limited, by whatever way it is found: nor is what is seen in mirrors.
#[test]
fn direct_light_is_not_limited() {
    let rough = MetalRough { base: Vec3::ONE, roughness: 0.4, metallic: 1.0, head_on: 0.04, solid: 1.0 };
    let metal = Material { diffuse: Vec3::ZERO, metal_rough: Some(rough), ..toy::matt(0.0) };
    let mirror = Material { optics: Optics::Mirror { tint: Vec3::ONE, fresnel: false }, ..toy::matt(0.0) };
    // a body that is convex meets nothing but light
    for material in [toy::matt(0.7), metal, mirror, glass(1.0)] {
        let glows = Material { emission: Vec3::splat(30.0), ..toy::matt(0.0) };
        let models = vec![
            toy::still("thing", toy::octahedron(0, true), Vec3::ZERO),
            toy::still("glows", toy::octahedron(1, true), Vec3::new(0.0, 4.0, 1.0)),
        ];
        let camera = toy::camera(rests(DVec3::new(0.5, 1.0, 3.0)), rests(DVec3::ZERO));
        let panel = LightKind::Sphere {
            position: rests(DVec3::new(3.0, 3.0, 3.0)),
            radius: 0.5.into(),
            faces: false,
        };
        let mut scene =
            toy::scene(camera, models, vec![material, glows], vec![toy::light("lamp", panel, 40.0)]);
        scene.environment = Some(Environment::from_sky(&afterimage::scene::environment::Sky::default()));
        let light = |clamp| {
            let settings =
                Settings { width: 32, height: 24, clamp, audit: true, ..settings(Caustics::None, 4, 1) };
            let finished = first(&scene, &settings);
            assert_eq!(toy::differing(&finished), 0);
            colors(&finished)
        };
        let (limited, free) = (light(Some(1e-3)), light(None));
        let apart = limited.iter().zip(&free).map(|(a, b)| (a - b).abs() / b.max(0.1)).fold(0.0, f32::max);
        assert!(apart < 0.01, "{:?}: {apart}", scene.materials[0].optics);
    }
}

/// What is limited is kept, and is what would be made anew, on any number of threads.
#[test]
fn limited_light_is_kept_exactly() {
    let mut scene = with_flyer(glass_before_gold());
    scene.models.last_mut().expect("it is there").mesh = std::sync::Arc::new(toy::octahedron(1, false));
    let by_camera = with_camera(
        scene.clone(),
        goes(DVec3::new(0.0, 1.2, 4.0), DVec3::new(0.4, 1.3, 3.8)),
        rests(DVec3::new(0.0, 0.5, 0.0)),
    );
    for scene in [scene, by_camera] {
        let rendered = |threads: usize, clamp| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
            let usual = settings(Caustics::Paths, 3, 3);
            let settings = Settings { width: 48, height: 36, clamp, audit: true, ..usual };
            let frames = pool.install(|| toy::render(&scene, &settings, FRAMES));
            for (number, finished) in frames.iter().enumerate() {
                assert_eq!(toy::differing(finished), 0, "frame {}", number + 1);
                assert!(number == 0 || finished.stats.samples.reused() > 0, "nothing is reused");
            }
            frames.iter().flat_map(colors).map(f32::to_bits).collect::<Vec<_>>()
        };
        let limited = rendered(1, Some(0.3));
        assert_eq!(limited, rendered(3, Some(0.3)));
        assert_ne!(limited, rendered(1, None), "there is something to limit");
    }
}

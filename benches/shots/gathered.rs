//! Light from all around: full frames, and inferred frames that keep what was gathered, by what moves. Sky and a soft
//! light, 16 paths a sample and two bounces; in the city the sky alone and 64 paths.

use std::error::Error;
use std::sync::Arc;
use std::time::Instant;

use afterimage::animation::{Interpolation, Track, TransformTrack};
use afterimage::frame::Renderer;
use afterimage::scene::environment::Sky;
use afterimage::scene::{self, Environment, Light, LightKind, Mesh, Model, Scene, Triangles};
use afterimage::settings::{Mode, Settings};
use glam::{DVec3, Vec2, Vec3};
use serde::Serialize;

use super::chains::load_still;
use super::flows::Flow;
use super::kinds::Lights;
use super::places::{Place, SceneName};
use super::rough;
use super::table::{Circumstances, write_json};
use super::{Arguments, folder};

/// Moving things of a shot.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Moves {
    /// The camera rests, or follows a flow; a ball flies, with so many hundredths of the distance from eye to target for
    /// its radius, or there is none.
    Camera(Option<Flow>, u32),
    /// The sun, over a camera at rest.
    Sun,
    /// The airship of the city's own shot, and the camera in a dolly.
    Airship,
}

impl Moves {
    const KITCHEN: [Self; 8] = [
        Self::Camera(None, 7),
        Self::Camera(None, 19),
        Self::Camera(Some(Flow::DollyIn), 0),
        Self::Camera(Some(Flow::DollyIn), 7),
        Self::Camera(Some(Flow::Turn), 0),
        Self::Camera(Some(Flow::Pan), 0),
        Self::Camera(Some(Flow::ZoomIn), 0),
        Self::Sun,
    ];
    const CITY: [Self; 2] = [Self::Airship, Self::Camera(Some(Flow::DollyIn), 7)];

    fn name(self) -> String {
        match self {
            Self::Sun => "sun".into(),
            Self::Airship => format!("{}, airship", Flow::DollyIn.name()),
            Self::Camera(flow, ball) => {
                let flow = flow.map_or("at rest".into(), Flow::name);
                if ball > 0 { format!("{flow}, ball {ball} %") } else { flow }
            }
        }
    }
}

/// A line of the table.
#[derive(Debug, Clone, Serialize)]
struct Row {
    scene: &'static str,
    moves: String,
    paths: u32,
    full_seconds: f64,
    inferred_seconds: f64,
    full_over_inferred: f64,
    /// Rays of paths of an inferred frame, as a percentage of those of a full one.
    gathering_percent: f64,
    bytes_per_sample: f64,
}

type Failable<T> = Result<T, Box<dyn Error>>;

/// Measures what `arguments` ask for; prints rows as they come.
pub fn run(arguments: &Arguments) -> Failable<()> {
    let circumstances = Circumstances::now(arguments);
    println!("{}\n", circumstances.text());
    let line = "| scene     | moves               | paths |   full s | inferred s | full/inferred | rays % | B/sample |";
    println!("{line}\n{}", line.chars().map(|c| if c == '|' { '|' } else { '-' }).collect::<String>());
    let mut rows = Vec::new();
    for name in [SceneName::Kitchen, SceneName::City] {
        if !arguments.scenes.is_empty() && !arguments.scenes.contains(&name) {
            continue;
        }
        let place = name.place(arguments.triangles(), &folder());
        let place = match place.and_then(|place| made_rough(place, arguments.rough)) {
            Ok(place) => place,
            Err(error) => {
                println!("skipped: {error}");
                continue;
            }
        };
        let is_kitchen = name == SceneName::Kitchen;
        let moves: &[Moves] = if is_kitchen { &Moves::KITCHEN } else { &Moves::CITY };
        let asked =
            |moves: &&Moves| arguments.moves.as_ref().is_none_or(|part| moves.name().contains(part.as_str()));
        for moves in moves.iter().filter(asked) {
            let row = measure(arguments, &place, *moves, if is_kitchen { 16 } else { 64 })?;
            println!("{}", row.text());
            rows.push(row);
        }
    }
    let path = folder().join("gathered.json");
    write_json(&path, &circumstances, &rows)?;
    println!("\nalso in {}", path.display());
    Ok(())
}

/// Gives all materials of a place but glass this roughness, if any is asked for.
pub fn made_rough(place: Place, roughness: Option<f32>) -> Failable<Place> {
    let Some(roughness) = roughness else { return Ok(place) };
    let folder = std::path::absolute(folder())?.join(format!("{}-rough-{roughness}", place.name));
    Ok(Place { obj: rough::copy(&place.obj, &folder, roughness)?, ..place })
}

/// Loads the scene of a place under a sky, with a soft light in the kitchen.
pub fn under_a_sky(place: &Place, arguments: &Arguments) -> Failable<(Scene, Settings)> {
    let (mut scene, settings) = load_still(place, arguments)?;
    let lights = std::mem::take(&mut scene.lights);
    scene.environment = Some(Environment::from_sky(&Sky::default()));
    scene.ambient = Vec3::ZERO;
    if place.name == "kitchen" {
        scene.lights = Lights::Soft.of(&lights).to_vec();
    }
    Ok((scene, settings))
}

/// Frames up to the last one are inferred, the first one and that after the last are traced in full.
fn measure(arguments: &Arguments, place: &Place, moves: Moves, paths: u32) -> Failable<Row> {
    let (mut scene, settings) = under_a_sky(place, arguments)?;
    let samples = arguments.samples.first().copied().unwrap_or(1);
    let settings = Settings { paths, bounces: 2, samples, ..settings };
    match moves {
        Moves::Camera(flow, ball) => {
            if let Some(flow) = flow {
                scene.camera = flow.camera(place, &scene.space);
            }
            if ball > 0 {
                add_ball(&mut scene, place, f64::from(ball) / 100.0);
            }
        }
        Moves::Airship => {
            add_airship(&mut scene, place)?;
            scene.camera = Flow::DollyIn.camera(place, &scene.space);
        }
        Moves::Sun => {
            let direction = |x: f64| DVec3::new(x, -1.0, -0.6);
            let direction = through(direction(0.2), direction(0.8));
            let (color, power) = (Track::constant(Vec3::ONE), Track::constant(1.0));
            let kind = LightKind::Directional { direction };
            scene.lights.push(Light {
                name: "sun".into(),
                kind,
                color,
                power,
                samples: 1,
                group: None,
                links: Default::default(),
            });
        }
    }
    let (mut full, mut inferred) = (Vec::new(), Vec::new());
    let mut rays = [0, 0];
    let mut renderer = Renderer::new(&scene, &Settings { mode: Mode::Reproject, ..settings.clone() })?;
    let mut bytes = 0.0;
    for frame in 1..=arguments.frames() as i32 {
        let start = Instant::now();
        let stats = renderer.render(frame, true)?.stats;
        bytes = renderer.memory().bytes_per_sample;
        let seconds = start.elapsed().as_secs_f64();
        // the first frame of rest writes everything once more
        match frame {
            1 => {
                full.push(seconds);
                rays[0] = stats.rays.gathering;
            }
            2 => {}
            _ => {
                inferred.push(seconds);
                rays[1] = stats.rays.gathering;
            }
        }
    }
    let start = Instant::now();
    renderer.render(arguments.frames() as i32 + 1, false)?;
    full.push(start.elapsed().as_secs_f64());
    let mean = |seconds: &[f64]| seconds.iter().sum::<f64>() / seconds.len().max(1) as f64;
    let (full_seconds, inferred_seconds) = (mean(&full), mean(&inferred));
    Ok(Row {
        scene: place.name,
        moves: moves.name(),
        paths,
        full_seconds,
        inferred_seconds,
        full_over_inferred: full_seconds / inferred_seconds,
        gathering_percent: 100.0 * rays[1] as f64 / rays[0].max(1) as f64,
        bytes_per_sample: bytes,
    })
}

/// Makes `scene` that of the city's own shot, without the sign, which turns there. Its airship flies on at
/// the same speed after its last key.
fn add_airship(scene: &mut Scene, place: &Place) -> Failable<()> {
    let own = scene::load(&place.obj.with_file_name("city.toml"), false)?.scene;
    let (models, materials, textures) = (own.models, own.materials, own.textures);
    (scene.models, scene.materials, scene.textures, scene.space) = (models, materials, textures, own.space);
    scene.models.retain(|model| model.name != "sign");
    let airship = scene.models.iter_mut().find(|model| model.name == "blimp").ok_or("no airship")?;
    let flight = |track: &Track<DVec3>| {
        let [start, end] = [1.0, 60.0].map(|frame| track.at(frame));
        through(start, start + (end - start) * (100.0 / 59.0))
    };
    let TransformTrack { translate, rotate, .. } = &mut airship.track;
    (*translate, *rotate) = (flight(translate), flight(rotate));
    Ok(())
}

/// Creates a track that is at one place in frame 1 and at another in frame 101.
fn through(from: DVec3, to: DVec3) -> Track<DVec3> {
    Track::through(vec![(1.0, from), (101.0, to)], Interpolation::Linear).expect("frames rise")
}

/// Adds a ball that crosses the view half way between eye and target, by the distance between them in 100
/// frames. `radius`: as a share of that distance.
fn add_ball(scene: &mut Scene, place: &Place, radius: f64) {
    let way = place.target - place.eye;
    let (middle, aside) = (place.eye + way * 0.5, way.cross(DVec3::Y).normalize() * way.length() * 0.5);
    let [from, to] = [middle - aside, middle + aside].map(|at| scene.space.point(at));
    let scale = DVec3::splat(radius * (to - from).length());
    let track = TransformTrack {
        translate: through(from, to),
        scale: Track::constant(scale),
        ..TransformTrack::identity()
    };
    scene.models.push(Model {
        name: "ball".into(),
        path: "ball".into(),
        mesh: Arc::new(ball()),
        track,
        to_world: None,
        random: 0.0,
        reflection_map: None,
        ray_visibility: Default::default(),
        linked: Default::default(),
    });
}

/// Creates a sphere of radius 1, of 32 x 16 quadrangles.
fn ball() -> Mesh {
    const AROUND: u32 = 32;
    const DOWN: u32 = 16;
    let corner = |i: u32| {
        let (turn, down) = ((i % AROUND) as f32 / AROUND as f32, (i / AROUND) as f32 / DOWN as f32);
        let ((sin, cos), (across, up)) =
            ((turn * std::f32::consts::TAU).sin_cos(), (down * std::f32::consts::PI).sin_cos());
        [across * cos, up, across * sin]
    };
    let corners: Vec<[f32; 3]> = (0..AROUND * (DOWN + 1)).map(corner).collect();
    let faces = (0..AROUND * DOWN).flat_map(|i| {
        let beside = i / AROUND * AROUND + (i + 1) % AROUND;
        [[i, beside, i + AROUND], [beside, beside + AROUND, i + AROUND]]
    });
    // at the poles one triangle of two has no area
    let triangles: Vec<[u32; 3]> =
        faces.filter(|[a, b, c]| corner(*a) != corner(*b) && corner(*b) != corner(*c)).collect();
    let uvs = vec![Vec2::ZERO; corners.len()];
    Mesh::plain(Triangles { uvs, ..Triangles::new(corners, triangles) }.into(), 0, true)
}

impl Row {
    fn text(&self) -> String {
        let Self { scene, moves, paths, full_seconds, inferred_seconds, full_over_inferred, .. } = self;
        format!(
            "| {scene:<9} | {moves:<19} | {paths:>5} | {full_seconds:8.3} | {inferred_seconds:10.4} | \
             {full_over_inferred:13.1} | {:6.2} | {:8.1} |",
            self.gathering_percent, self.bytes_per_sample
        )
    }
}

//! Generated scenes: discs and wires before a chequered plane. All light is ambient, so that the colour of a point does
//! not depend on the view.

use afterimage::animation::{Track, TransformTrack};
use afterimage::scene::texture::Mapping;
use afterimage::scene::{Material, Mesh, Model, Scene, Texture};
use glam::{DVec3, Vec2, Vec3};

use super::flows::{Flow, Stand, there_and_back};
use super::toy;

/// A scene with its camera moves.
pub struct Subject {
    pub name: &'static str,
    /// The scene. Its camera is replaced by that of a flow.
    pub scene: Scene,
    pub stand: Stand,
    pub flows: &'static [Flow],
    /// Unit of the coverage error of an object, if material 0 belongs to one: the error is reported as a
    /// percentage of it.
    pub object: Option<Unit>,
}

/// The unit of an object's coverage error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Pixels that it covers in part.
    Rim,
    /// Its area: for objects about as thin as a pixel.
    Area,
}

impl Subject {
    /// The scene with the camera of `flow`.
    pub fn scene(&self, flow: Flow) -> Scene {
        Scene { camera: flow.camera(&self.stand), ..self.scene.clone() }
    }
}

/// Camera that looks along -Z at a plane at distance 10; objects are at distance 6, from which `In` takes 2.
const STAND: Stand = Stand {
    eye: DVec3::new(0.0, 0.0, 10.0),
    target: DVec3::ZERO,
    fov: 40.0,
    stride: 0.02,
    aside: 0.03,
    turn: 0.25,
};
const OBJECTS: f32 = 4.0;
const CAMERA_FLOWS: &[Flow] = &[Flow::In, Flow::Out, Flow::Sideways, Flow::Turn];

/// Creates discs of a fifth of the picture's height.
pub fn discs() -> Subject {
    let model = toy::still("discs", disc_mesh(), Vec3::new(0.11, 0.07, OBJECTS));
    subject("discs", model, CAMERA_FLOWS, Unit::Rim)
}

/// Creates wires 1.2 pixels wide at the largest distance, in pictures `height` pixels high.
pub fn wires(height: u32) -> Subject {
    let distance = STAND.eye.z as f32 - OBJECTS;
    let pixel = 2.0 * distance * (STAND.fov as f32 * 0.5).to_radians().tan() / height as f32;
    let model = toy::still("wires", wire_mesh(1.2 * pixel), Vec3::new(0.0, 0.0, OBJECTS));
    subject("wires", model, CAMERA_FLOWS, Unit::Area)
}

/// Creates discs that move and rotate.
pub fn movers() -> Subject {
    let from = DVec3::new(0.11, 0.07, f64::from(OBJECTS));
    let track = TransformTrack {
        translate: there_and_back(from, from + DVec3::new(2.0, 0.7, 0.5)),
        rotate: there_and_back(DVec3::ZERO, DVec3::Z * 20.0),
        ..TransformTrack::identity()
    };
    subject("movers", toy::moving("discs", disc_mesh(), track), &[Flow::Rest, Flow::In], Unit::Rim)
}

fn subject(name: &'static str, model: Model, flows: &'static [Flow], unit: Unit) -> Subject {
    let flat = Vec3::new(0.9, 0.4, 0.1);
    let object = Material { name: name.into(), diffuse: flat, ambient: flat, ..Material::fallback() };
    let plane = Material { name: "plane".into(), diffuse_map: Some(0), ..toy::matt(1.0) };
    let unused = toy::camera(Track::constant(STAND.eye), Track::constant(STAND.target));
    let mut scene = toy::scene(unused, vec![plane_model(), model], vec![object, plane], vec![]);
    scene.textures = vec![chequers()];
    scene.ambient = Vec3::ONE;
    Subject { name, scene, stand: STAND, flows, object: Some(unit) }
}

/// 2 x 2 squares of 8 x 8 texels.
fn chequers() -> Texture {
    const SIDE: usize = 16;
    let texel = |at: usize| {
        let is_dark = (at % SIDE < SIDE / 2) == (at / SIDE < SIDE / 2);
        if is_dark { [60, 60, 60, 255] } else { [210, 220, 230, 255] }
    };
    let texels = (0..SIDE * SIDE).map(texel).collect();
    Texture::of_bytes("chequers".into(), [SIDE as u32; 2], texels, Mapping::default())
}

/// The plane z = 0, at an angle to the pixel rows, with squares of 0.4.
fn plane_model() -> Model {
    const HALF: f32 = 60.0;
    let turned = |x: f32, y: f32| Vec2::from_angle(0.2).rotate(Vec2::new(x, y) * HALF);
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let places = corners.map(|(x, y)| turned(x, y).extend(0.0).to_array());
    let mesh = toy::mesh(&places, &[[0, 1, 2], [0, 2, 3]], 1, true);
    let uvs = corners.map(|(x, y)| Vec2::new(x, y) * HALF / 0.8).to_vec();
    toy::still("plane", mesh.with_triangles(|triangles| triangles.uvs = uvs), Vec3::ZERO)
}

/// Discs of radius 0.4 in a grid that fills every picture; offsets keep them from all lying alike on the pixel grid.
fn disc_mesh() -> Mesh {
    const EDGES: u32 = 64;
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for (x, y) in (-8..=8).flat_map(|x| (-4..=4).map(move |y| (x as f32, y as f32))) {
        let centre = Vec2::new(x, y) * 1.3 + Vec2::from_angle(x * 2.4 + y * 5.1) * 0.12;
        let first = corners.len() as u32;
        corners.push(centre.extend(0.0).to_array());
        for edge in 0..EDGES {
            let rim = Vec2::from_angle(std::f32::consts::TAU * edge as f32 / EDGES as f32) * 0.4;
            corners.push((centre + rim).extend(0.0).to_array());
            triangles.push([first, first + 1 + edge, first + 1 + (edge + 1) % EDGES]);
        }
    }
    toy::mesh(&corners, &triangles, 0, true)
}

/// Flat wires, about upright and about level, at various angles.
fn wire_mesh(width: f32) -> Mesh {
    const LENGTH: f32 = 20.0;
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for (number, upright) in (-16..=16).flat_map(|number| [(number, true), (number, false)]) {
        let angle = (number * 7_i32).rem_euclid(33) as f32 / 33.0 * 0.6 - 0.3;
        // in two layers, so that crossing wires do not coincide
        let (middle, along, z) = match upright {
            true => (Vec2::X, Vec2::from_angle(angle).perp(), 0.02),
            false => (Vec2::Y, Vec2::from_angle(angle), 0.0),
        };
        let (middle, along, across) = (middle * number as f32 * 0.7, along * LENGTH / 2.0, along.perp());
        let first = corners.len() as u32;
        for (end, side) in [(-1.0, -0.5), (1.0, -0.5), (1.0, 0.5), (-1.0, 0.5)] {
            corners.push((middle + along * end + across * side * width).extend(z).to_array());
        }
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    toy::mesh(&corners, &triangles, 0, true)
}

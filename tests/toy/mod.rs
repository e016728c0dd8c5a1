//! Tiny scenes that are made in code, with answers that can be worked out by hand.
#![allow(dead_code, reason = "each test binary uses its share")]

pub mod worlds;

use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use afterimage::animation::{Interpolation, ShapeTrack, Track, TransformTrack};
use afterimage::frame::{Finished, Renderer};
use afterimage::geometry::quadric::QuadricShape;
use afterimage::geometry::{Curves, Quadric};
use afterimage::layers::Layers;
use afterimage::scene::camera::{Aim, Lens};
use afterimage::scene::cutout::{CutTriangles, Cutout, LEAST_OPACITY, Mask};
use afterimage::scene::texture::{Mapping, Wrap};
use afterimage::scene::{
    Background, CameraTrack, Geometry, Light, LightKind, Material, Mesh, Model, Panel, RenderSpace, Scene,
    Shapes, Texture, Triangles,
};
use afterimage::settings::{Filter, Mode, Settings};
use embree::VertexBuffer;
use glam::{DAffine3, DVec3, Vec2, Vec3};

/// A track through `keys`.
pub fn keys<T: afterimage::animation::Keyed>(keys: &[(f64, T)]) -> Track<T> {
    Track::through(keys.to_vec(), Interpolation::Linear).expect("keys are good")
}

/// A mesh of one material.
pub fn mesh(corners: &[[f32; 3]], triangles: &[[u32; 3]], material: u16, casts_shadow: bool) -> Mesh {
    let triangles = Triangles::new(corners.to_vec(), triangles.to_vec());
    let uvs = vec![Vec2::ZERO; corners.len()];
    Mesh::plain(Triangles { uvs, ..triangles }.into(), material, casts_shadow)
}

/// A square in the plane y = 0 that looks up, from -half to half.
pub fn floor(half: f32, material: u16) -> Mesh {
    let corners = [[-half, 0.0, half], [half, 0.0, half], [half, 0.0, -half], [-half, 0.0, -half]];
    mesh(&corners, &[[0, 1, 2], [0, 2, 3]], material, true)
}

/// A texture of two texels side by side that holds nothing but opacity.
pub fn opacity(left: u8, right: u8) -> Texture {
    let texels = Arc::from([[255, 255, 255, left], [255, 255, 255, right]]);
    let mapping = Mapping { wrap: [Wrap::Clamp; 2], ..Mapping::default() };
    Texture::of_bytes(PathBuf::new(), [2, 1], texels, mapping)
}

/// `mesh`, whose triangles `range` the alpha of `texture` cuts out.
pub fn cut_out(mesh: Mesh, range: Range<usize>, texture: &Texture) -> Mesh {
    let masks = vec![Mask::new(Cutout::by_picture(0, LEAST_OPACITY), Some(texture.clone()))];
    let cut = CutTriangles { first: range.start as u32, mask_of: vec![0; range.len()], masks };
    Mesh { cut: Some(Arc::new(cut)), ..mesh }
}

/// An octahedron of radius 1 about the origin.
pub fn octahedron(material: u16, casts_shadow: bool) -> Mesh {
    let corners: [[f32; 3]; 6] =
        [[1., 0., 0.], [-1., 0., 0.], [0., 1., 0.], [0., -1., 0.], [0., 0., 1.], [0., 0., -1.]];
    let faces = [[0, 2, 4], [4, 2, 1], [1, 2, 5], [5, 2, 0], [4, 3, 0], [1, 3, 4], [5, 3, 1], [0, 3, 5]];
    mesh(&corners, &faces, material, casts_shadow)
}

/// `mesh`, moved to `at`, in world space: as the loader leaves what never moves.
pub fn still(name: &str, mesh: Mesh, at: Vec3) -> Model {
    let mesh = mesh.with_triangles(|triangles| {
        let moved = triangles.positions.as_slice().iter().map(|p| (Vec3::from_array(*p) + at).to_array());
        triangles.positions = Arc::new(VertexBuffer::new(moved.collect()));
    });
    moving(name, mesh, TransformTrack::identity())
}

/// `mesh`, at the places that `track` says.
pub fn moving(name: &str, mesh: Mesh, track: TransformTrack) -> Model {
    Model {
        name: name.into(),
        path: name.into(),
        mesh: Arc::new(mesh),
        track,
        to_world: None,
        random: 0.0,
        reflection_map: None,
        ray_visibility: Default::default(),
        linked: Default::default(),
    }
}

/// A quadric that never moves, in world space: as the loader leaves it.
pub fn still_quadric(
    name: &str,
    quadric: &Quadric,
    material: u16,
    casts_shadow: bool,
    at: DAffine3,
) -> Model {
    let mesh = Mesh::of_curved(quadric.placed(at), material, casts_shadow);
    moving(name, mesh, TransformTrack::identity())
}

/// A quadric at the places that `track` says.
pub fn moving_quadric(name: &str, quadric: &Quadric, material: u16, track: TransformTrack) -> Model {
    moving(name, Mesh::of_curved(quadric.clone(), material, true), track)
}

/// Of radius 1, about the origin.
pub fn sphere() -> Quadric {
    Quadric::new(QuadricShape::Ellipsoid { radii: DVec3::ONE }, false)
}

/// One of each shape but the plane, some closed and some open, each about 2 high.
pub fn quadrics() -> Vec<Quadric> {
    vec![
        Quadric::new(QuadricShape::Ellipsoid { radii: DVec3::new(1.0, 1.2, 0.8) }, false),
        Quadric::new(QuadricShape::Cylinder { radius: 0.8, height: 1.6 }, false),
        Quadric::new(QuadricShape::Cylinder { radius: 0.8, height: 1.4 }, true),
        Quadric::new(QuadricShape::Cone { radius: 0.9, top: 0.0, height: 1.8 }, false),
        Quadric::new(QuadricShape::Cone { radius: 0.5, top: 0.9, height: 1.5 }, true),
        Quadric::new(QuadricShape::Paraboloid { radius: 0.9, height: 1.5 }, true),
        Quadric::new(QuadricShape::OneSheet { radius: 0.9, waist: 0.4, height: 1.6 }, false),
        Quadric::new(QuadricShape::TwoSheets { radius: 1.0, gap: 0.3, height: 1.8 }, false),
    ]
}

/// Seven bent hairs about 2 high that grow thinner, of eight pieces each, or as few thick cords.
pub fn tuft(is_thick: bool) -> Curves {
    let mut points = Vec::new();
    for hair in 0..7 {
        let turn = hair as f32 * 0.9;
        for at in 0..9 {
            let up = at as f32 / 8.0;
            let away = 0.2 + 0.7 * up * up;
            let radius = if is_thick { 0.16 - 0.05 * up } else { 0.03 * (1.0 - up) };
            points.push([away * turn.cos(), 2.0 * up, away * turn.sin(), radius]);
        }
    }
    Curves::new(&points, &[9; 7], &[]).expect("they have a length").0
}

/// Balls of a radius each, as points of USD are: each is the hull of its sphere and of a point within it.
pub fn balls() -> Curves {
    let ball = |number: u32| {
        let (turn, radius) = (number as f32 * 2.4, 0.05 + 0.03 * (number % 4) as f32);
        let [x, y, z] = [0.6 * turn.cos(), 0.2 + 0.04 * number as f32, 0.6 * turn.sin()];
        [[x, y, z, radius], [x, y + 0.5 * radius, z, 0.0]]
    };
    let points: Vec<[f32; 4]> = (0..24).flat_map(ball).collect();
    Curves::new(&points, &[2; 24], &[]).expect("they have a size").0
}

/// The points of seven bent hairs about 2 high, nine each: `place` puts each, which is so high, of the hair that turns to there.
pub fn tuft_points(place: impl Fn(f32, f32) -> [f32; 4]) -> Vec<[f32; 4]> {
    let all = (0..7).flat_map(|hair| (0..9).map(move |at| (hair as f32 * 0.9, at as f32 / 8.0)));
    all.map(|(turn, up)| place(turn, up)).collect()
}

/// Hairs that go straight from shape to shape: at each frame their points are these, nine a hair.
pub fn deforming_curves(
    name: &str,
    material: u16,
    track: TransformTrack,
    shapes: &[(f64, Vec<[f32; 4]>)],
) -> Model {
    let list: Vec<Vec<[f32; 4]>> = shapes.iter().map(|(_, points)| points.clone()).collect();
    let counts = vec![9; list[0].len() / 9];
    let curves = Curves::deforming(&list, &counts, &[]).expect("they have a length").0;
    let keys = shapes.iter().zip(0..).map(|((frame, _), number)| (*frame, number)).collect();
    let track = TransformTrack { shapes: ShapeTrack::through(keys, None), ..track };
    moving(name, Mesh::of_curved(curves, material, true), track)
}

/// Curves that never move, in world space: as the loader leaves them.
pub fn still_curves(name: &str, curves: &Curves, material: u16, at: DAffine3) -> Model {
    let mesh =
        Mesh::plain(Geometry::Curved(afterimage::geometry::Curved::mapped(curves, at)), material, true);
    moving(name, mesh, TransformTrack::identity())
}

/// From `eye` to `target`, 60 degrees from top to bottom.
pub fn camera(eye: Track<DVec3>, target: Track<DVec3>) -> CameraTrack {
    let roll = Track::constant(0.0);
    CameraTrack {
        eye: eye.into(),
        aim: Aim::Target { target, roll },
        fov: Track::constant(60.0),
        lens: Lens::default(),
        cuts: vec![],
    }
}

/// A light of constant colour.
pub fn light(name: &str, kind: LightKind, power: f64) -> Light {
    let (color, power) = (Track::constant(Vec3::ONE), Track::constant(power));
    Light {
        name: name.into(),
        kind,
        color,
        power,
        samples: Light::MOST_SAMPLES,
        group: None,
        links: Default::default(),
    }
}

/// Straight down on everything.
pub fn sun_overhead(power: f64) -> Light {
    light("sun", LightKind::Directional { direction: Track::constant(DVec3::NEG_Y) }, power)
}

/// A matt material of reflectance `diffuse`.
pub fn matt(diffuse: f32) -> Material {
    let diffuse = Vec3::splat(diffuse);
    Material { diffuse, ambient: diffuse, ..Material::fallback() }
}

/// Nothing but what is given: no ambient light, a background of (0.25, 0.5, 1).
pub fn scene(camera: CameraTrack, models: Vec<Model>, materials: Vec<Material>, lights: Vec<Light>) -> Scene {
    Scene {
        camera,
        models,
        materials,
        textures: vec![],
        lights,
        ambient: Vec3::ZERO,
        world_group: None,
        mist: Default::default(),
        ambient_is_occluded: false,
        fog: None,
        background: Background::uniform(Vec3::new(0.25, 0.5, 1.0)),
        environment: None,
        space: RenderSpace::OF_FILES,
    }
}

/// The same as [`settings`], with an audit of each frame: for those who look at what it finds. It costs more than the frame.
pub fn audited(samples: u32) -> Settings {
    Settings { audit: true, ..settings(samples) }
}

/// A small picture of `samples` x `samples` samples a pixel.
pub fn settings(samples: u32) -> Settings {
    Settings {
        width: 96,
        height: 72,
        samples,
        filter: Filter::Box,
        depth: 4,
        mode: Mode::Reproject,
        base_every: 0,
        layers: Layers::ALL,
        ..Settings::default()
    }
}

/// Frames `1..=last`, the first a base frame and the others inferred.
pub fn render(scene: &Scene, settings: &Settings, last: i32) -> Vec<Finished> {
    let mut renderer = Renderer::new(scene, settings).expect("the scene builds");
    (1..=last).map(|frame| renderer.render(frame, true).expect("the frame renders")).collect()
}

/// Number of findings of a frame's audit: samples that differ from what is traced anew, and cells that show what their targets do not see.
pub fn differing(finished: &Finished) -> u64 {
    finished.stats.audit.expect("asked for").wrong()
}

/// Number of samples that an inferred frame has traced anew.
pub fn traced(finished: &Finished) -> u64 {
    let samples = finished.stats.samples;
    samples.missed + samples.obscured
}

/// One pixel of a plane.
pub fn pixel(finished: &Finished, plane: &str, x: u32, y: u32) -> f32 {
    let film = &finished.film;
    film.plane(plane).expect("the plane is there").values.get((y * film.width + x) as usize)
}

/// The picture's colour at a pixel.
pub fn color(finished: &Finished, x: u32, y: u32) -> Vec3 {
    Vec3::new(pixel(finished, "R", x, y), pixel(finished, "G", x, y), pixel(finished, "B", x, y))
}

/// Mean of how much two frames differ in a plane, pixel by pixel.
pub fn mean_difference(a: &Finished, b: &Finished, plane: &str) -> f32 {
    let values = |finished: &'_ Finished| finished.film.values(plane).expect("the plane is there");
    let (a, b) = (values(a), values(b));
    a.iter().zip(&b).map(|(a, b)| (a - b).abs()).sum::<f32>() / a.len() as f32
}

/// `mesh`, which goes straight from shape to shape: at each frame of `shapes` its vertices are where a function puts them.
pub fn deforming(
    name: &str,
    mesh: Mesh,
    track: TransformTrack,
    shapes: &[(f64, &dyn Fn(Vec3) -> Vec3)],
) -> Model {
    let triangles = mesh.triangles();
    let place = |shape: &dyn Fn(Vec3) -> Vec3| {
        let moved = |at: &[f32; 3]| shape(Vec3::from_array(*at)).to_array();
        triangles.positions.as_slice().iter().map(moved).collect()
    };
    let list = shapes.iter().map(|(_, shape)| place(*shape)).collect();
    let places: Vec<u32> = (0..triangles.positions.as_slice().len() as u32).collect();
    let data = Arc::new(Shapes::new(list, &triangles.corners, &triangles.normals, &places));
    let keys = shapes.iter().zip(0..).map(|((frame, _), number)| (*frame, number)).collect();
    let track = TransformTrack { shapes: ShapeTrack::through(keys, None), ..track };
    moving(name, mesh.with_triangles(|triangles| triangles.shapes = Some(data)), track)
}

/// A sheet of `cells` x `cells` squares in the plane y = 0 that looks up, from -half to half; smooth, if that is asked for.
pub fn sheet(half: f32, cells: u32, material: u16, is_smooth: bool) -> Mesh {
    let row = cells + 1;
    let at = |i: u32| half * (2.0 * i as f32 / cells as f32 - 1.0);
    let corners: Vec<[f32; 3]> = (0..row * row).map(|i| [at(i % row), 0.0, -at(i / row)]).collect();
    let square = |i: u32| {
        let first = i / cells * row + i % cells;
        [[first, first + 1, first + row + 1], [first, first + row + 1, first + row]]
    };
    let triangles: Vec<[u32; 3]> = (0..cells * cells).flat_map(square).collect();
    let sheet = mesh(&corners, &triangles, material, true);
    let uvs = corners.iter().map(|[x, _, z]| Vec2::new(*x, -*z) / (2.0 * half) + 0.5).collect();
    let normals = if is_smooth { vec![Vec3::Y; corners.len()] } else { Vec::new() };
    sheet.with_triangles(|triangles| (triangles.normals, triangles.uvs) = (normals, uvs))
}

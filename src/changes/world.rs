//! Random shots and segments for tests, the same in each run.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3};

use crate::animation::{Interpolation, ShapeTrack, Track, TransformTrack, Visibility};
use crate::scene::camera::{Aim, Lens};
use crate::scene::{
    Background, CameraTrack, Light, LightKind, Mesh, Model, RenderSpace, Scene, Shapes, Triangles,
};

/// Numbers that look random (SplitMix64).
pub struct Dice(pub u64);

impl Dice {
    pub fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        (mixed ^ mixed >> 31) % end
    }

    /// Number in `low..high`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.below(1 << 40) as f64 / (1_u64 << 40) as f64
    }

    pub fn point(&mut self, reach: f64) -> DVec3 {
        DVec3::new(self.between(-reach, reach), self.between(-reach, reach), self.between(-reach, reach))
    }

    pub fn one_in(&mut self, count: u64) -> bool {
        self.below(count) == 0
    }
}

/// A track with keys from `first` to `last`: straight or smooth, with rests, cuts, and keys between frames.
pub fn track(
    dice: &mut Dice,
    [first, last]: [f64; 2],
    mut value: impl FnMut(&mut Dice) -> DVec3,
) -> Track<DVec3> {
    let count = 2 + dice.below(5);
    let mut keys: Vec<(f64, DVec3)> = Vec::new();
    for i in 0..count {
        let at = first + (last - first) * i as f64 / (count - 1) as f64;
        let at = if dice.one_in(4) { at + 0.25 } else { at.round() };
        let rests = !keys.is_empty() && dice.one_in(3);
        let value = if rests { keys[keys.len() - 1].1 } else { value(dice) };
        if keys.last().is_none_or(|(before, _)| *before < at) {
            keys.push((at, value));
        }
    }
    let interpolation = if dice.one_in(2) { Interpolation::Smooth } else { Interpolation::Linear };
    let cuts: Vec<f64> = keys.iter().map(|(at, _)| *at).filter(|_| dice.one_in(5)).collect();
    Track::through(keys, interpolation).expect("keys rise").cut_at(&cuts)
}

/// Creates a track that moves, turns or grows, or does some of these.
pub fn motion(dice: &mut Dice, frames: [f64; 2], reach: f64) -> TransformTrack {
    let still = dice.point(reach);
    TransformTrack {
        translate: if dice.one_in(4) {
            Track::constant(still)
        } else {
            track(dice, frames, |dice| dice.point(reach))
        },
        rotate: if dice.one_in(3) {
            Track::constant(still * 90.0)
        } else {
            track(dice, frames, |dice| dice.point(200.0))
        },
        scale: if dice.one_in(3) {
            track(dice, frames, |dice| DVec3::splat(dice.between(0.3, 2.0)))
        } else {
            Track::constant(DVec3::ONE)
        },
        matrix: dice.one_in(4).then(|| matrices(dice, frames)),
        visible: if dice.one_in(3) { visibility(dice, frames) } else { Visibility::ALWAYS },
        shapes: None,
    }
}

/// Creates a track from one map that shears to another.
fn matrices(dice: &mut Dice, frames: [f64; 2]) -> Track<DAffine3> {
    let map = |dice: &mut Dice| {
        let shear = dice.point(0.3);
        DAffine3::from_mat3_translation(
            DMat3::from_cols(DVec3::NEG_X, DVec3::new(shear.x, 1.0, shear.y), DVec3::new(shear.z, 0.0, 1.0)),
            dice.point(1.0),
        )
    };
    let keys = frames.map(|frame| (frame, map(dice)));
    Track::through(keys.to_vec(), Interpolation::Linear).expect("keys rise")
}

fn visibility(dice: &mut Dice, [first, last]: [f64; 2]) -> Visibility {
    let count = 1 + dice.below(4);
    let key = |i: u64| first + (last - first) * (i as f64 + 0.3) / count as f64;
    let is_there = dice.one_in(2);
    let keys = (0..count).map(|i| (key(i), (i % 2 == 0) != is_there)).collect();
    Visibility::through(is_there, keys).expect("keys rise")
}

/// Creates a mesh of `count` triangles of size `thick` along an L of size 3, which one box fits badly.
pub fn bent(dice: &mut Dice, count: usize, thick: f64) -> Mesh {
    let corners = (0..count).flat_map(|i| {
        let along = 6.0 * i as f64 / count as f64;
        let middle = DVec3::new((1.5 - along).max(-1.5), (along - 4.5).max(-1.5), 0.0);
        [(); 3].map(|()| middle + dice.point(0.5 * thick))
    });
    let corners = corners.map(|corner| corner.as_vec3().to_array()).collect();
    triangles(corners, (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

/// One triangle around the origin, at a right angle to the z axis.
pub fn pane() -> Mesh {
    triangles(vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])
}

/// Two triangles side by side.
pub fn mesh_of_two() -> Mesh {
    triangles(
        vec![[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]],
        vec![[0, 1, 3], [1, 2, 3]],
    )
}

/// A sphere about the origin, of `rings` rings of quadrilaterals.
pub fn ball(radius: f32, rings: u32) -> Mesh {
    use std::f32::consts::PI;
    let corner = |i: u32, j: u32| {
        let (down, around) = (PI * i as f32 / rings as f32, PI * j as f32 / rings as f32);
        let at = Vec3::new(down.sin() * around.cos(), down.cos(), down.sin() * around.sin());
        (at * radius).to_array()
    };
    let columns = 2 * rings;
    let corners = (0..=rings).flat_map(|i| (0..columns).map(move |j| corner(i, j))).collect();
    let quad = |i: u32, j: u32| {
        let at = |i: u32, j: u32| i * columns + j % columns;
        [[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)]]
    };
    triangles(corners, (0..rings).flat_map(|i| (0..columns).flat_map(move |j| quad(i, j))).collect())
}

/// A mesh of these triangles, of material 0.
pub fn triangles(corners: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh::plain(Triangles::new(corners, triangles).into(), 0, true)
}

pub fn model(mesh: Mesh, track: TransformTrack) -> Model {
    Model {
        name: "mover".into(),
        path: "mover".into(),
        mesh: Arc::new(mesh),
        track,
        to_world: None,
        random: 0.0,
        reflection_map: None,
        ray_visibility: Default::default(),
        linked: Default::default(),
    }
}

/// A model of `mesh` with a few shapes, in which it is elsewhere or bent, some of them twice in a row.
fn deforming(dice: &mut Dice, mesh: Mesh, track: TransformTrack, [first, last]: [f64; 2]) -> Model {
    let count = 1 + dice.below(4);
    let list = (0..count).map(|_| {
        let (aside, slope) = (dice.point(2.0), dice.point(0.7));
        let moved = |at: &[f32; 3]| {
            let at = Vec3::from_array(*at).as_dvec3();
            (at + aside + slope * at.x * at.y).as_vec3().to_array()
        };
        mesh.triangles().positions.as_slice().iter().map(moved).collect()
    });
    let list = list.collect();
    let places: Vec<u32> = (0..mesh.triangles().positions.as_slice().len() as u32).collect();
    let shapes = Arc::new(Shapes::new(list, &mesh.triangles().corners, &[], &places));
    let step = ((last - first) / 4.0).max(0.5);
    let number = |dice: &mut Dice| dice.below(count) as u32;
    let keys = (0..4).map(|key| (first + f64::from(key) * step, number(dice))).collect();
    let track = TransformTrack { shapes: ShapeTrack::through(keys, None), ..track };
    model(mesh.with_triangles(|triangles| triangles.shapes = Some(shapes)), track)
}

/// A lamp of constant colour.
pub fn lamp(position: Track<DVec3>, power: Track<f64>) -> Light {
    Light {
        name: "lamp".into(),
        kind: LightKind::Point { position },
        color: Track::constant(Vec3::ONE),
        power,
        samples: 1,
        group: None,
        links: Default::default(),
    }
}

pub fn scene(models: Vec<Model>, lights: Vec<Light>) -> Scene {
    // the camera moves, and does not count
    let eye =
        Track::through(vec![(-50.0, DVec3::ZERO), (400.0, DVec3::X)], Interpolation::Linear).expect("good");
    let aim = Aim::Target { target: Track::constant(DVec3::NEG_Z), roll: Track::constant(0.0) };
    Scene {
        camera: CameraTrack {
            eye: eye.into(),
            aim,
            fov: Track::constant(60.0),
            lens: Lens::default(),
            cuts: vec![],
        },
        models,
        materials: vec![],
        textures: vec![],
        lights,
        ambient: Vec3::ZERO,
        world_group: None,
        mist: Default::default(),
        ambient_is_occluded: false,
        fog: None,
        background: Background::uniform(Vec3::ONE),
        environment: None,
        space: RenderSpace::OF_FILES,
    }
}

/// Up to four models in a cube of size 8, most of which move, between frames -10 and about 40.
pub fn random_scene(dice: &mut Dice) -> Scene {
    let models = (0..1 + dice.below(4)).map(|_| {
        let first = dice.between(-10.0, 10.0).round();
        let frames = [first, first + dice.between(3.0, 40.0)];
        let count = 1 + dice.below(150) as usize;
        let mesh = bent(dice, count, 1.0);
        match dice.below(5) {
            0 => model(mesh, TransformTrack::identity()),
            1 => deforming(dice, mesh, TransformTrack::identity(), frames),
            2 => {
                let track = motion(dice, frames, 4.0);
                deforming(dice, mesh, track, frames)
            }
            _ => model(mesh, motion(dice, frames, 4.0)),
        }
    });
    scene(models.collect(), vec![])
}

/// Query to a [`Motion`](super::Motion).
#[derive(Debug, Clone, Copy)]
pub struct Segment {
    pub origin: Vec3,
    pub direction: Vec3,
    pub far: f32,
    pub after: i32,
}

/// Creates a segment across a cube of size 8, short, long or without an end; some along an axis.
pub fn random_segment(dice: &mut Dice) -> Segment {
    let mut direction = dice.point(4.0).as_vec3();
    if dice.one_in(4) {
        direction[dice.below(3) as usize] = 0.0;
    }
    let far = [0.5, 1.0, 3.0, f32::INFINITY][dice.below(4) as usize];
    let after = dice.between(-13.0, 45.0) as i32;
    Segment { origin: dice.point(4.0).as_vec3(), direction, far, after }
}

//! Worlds in which reuse is tested.

use afterimage::scene::material::{MetalRough, Optics};

use super::*;

pub const FRAMES: i32 = 6;

pub fn rests(at: DVec3) -> Track<DVec3> {
    Track::constant(at)
}

pub fn goes(from: DVec3, to: DVec3) -> Track<DVec3> {
    super::keys(&[(1.0, from), (f64::from(FRAMES), to)])
}

pub const EYE: DVec3 = DVec3::new(0.5, 3.0, 7.0);

pub const TARGET: DVec3 = DVec3::new(0.0, 0.5, 0.0);

/// A floor with three solids on it: one matt, one mirror, one of glass, under a lamp and a sun.
pub fn world() -> Scene {
    let mirror = Material {
        specular: Vec3::splat(0.5),
        shininess: 40.0,
        optics: Optics::Mirror { tint: Vec3::splat(0.7), fresnel: true },
        ..super::matt(0.2)
    };
    let optics = Optics::clear(Vec3::ONE, 1.5, Vec3::ONE);
    let glass = Material { optics, ..super::matt(0.0) };
    let models = vec![
        super::still("floor", super::floor(12.0, 0), Vec3::ZERO),
        super::still("matt", super::octahedron(0, true), Vec3::new(-2.0, 1.0, 0.0)),
        super::still("mirror", super::octahedron(1, true), Vec3::new(0.3, 1.1, -1.5)),
        super::still("glass", super::octahedron(2, false), Vec3::new(2.3, 1.0, 1.0)),
    ];
    let sun = LightKind::Directional { direction: rests(DVec3::new(-0.5, -1.0, -0.3)) };
    let lamp = LightKind::Point { position: rests(DVec3::new(2.0, 4.0, 3.0)) };
    let lights = vec![super::light("sun", sun, 0.6), super::light("lamp", lamp, 9.0)];
    let camera = super::camera(rests(EYE), rests(TARGET));
    let mut scene = super::scene(camera, models, vec![super::matt(0.6), mirror, glass], lights);
    scene.ambient = Vec3::splat(0.1);
    scene
}

/// Adds an octahedron that flies through the picture, turning.
pub fn with_flyer(mut scene: Scene) -> Scene {
    let track = TransformTrack {
        translate: goes(DVec3::new(-3.0, 2.0, 1.5), DVec3::new(2.0, 1.5, 1.0)),
        rotate: goes(DVec3::ZERO, DVec3::new(20.0, 90.0, 0.0)),
        scale: rests(DVec3::splat(0.6)),
        ..TransformTrack::identity()
    };
    scene.models.push(super::moving("flyer", super::octahedron(0, true), track));
    scene
}

pub fn with_camera(mut scene: Scene, eye: Track<DVec3>, target: Track<DVec3>) -> Scene {
    scene.camera = super::camera(eye, target);
    scene
}

/// A wall and a floor without mirror or glass, so that whole tiles stay the same, and a flyer in a corner.
/// A second flyer would be in the same place, and which of two surfaces in one place Embree meets is not defined.
pub fn matt_world() -> Scene {
    let mut scene = with_flyer(world());
    scene.models.retain(|model| model.name != "mirror" && model.name != "glass");
    scene
}

/// Frames of [`before_a_mirror`].
pub const LAST_BEFORE_MIRROR: i32 = 12;

/// A mirror before a camera that stands, and a screen behind it; between them a flyer passes `middle` on its way to the
/// right. In the last frame the light is stronger.
pub fn before_a_mirror(middle: DVec3, mut light: Light) -> Scene {
    let mirror =
        Material { optics: Optics::Mirror { tint: Vec3::splat(0.7), fresnel: false }, ..super::matt(0.1) };
    let wall = |[left, right]: [f32; 2], [low, high]: [f32; 2], z: f32, material| {
        let corners = [[left, low, z], [right, low, z], [right, high, z], [left, high, z]];
        super::mesh(&corners, &[[0, 1, 2], [0, 2, 3]], material, true)
    };
    let eye = DVec3::new(0.0, 1.5, 3.0);
    let last = f64::from(LAST_BEFORE_MIRROR);
    light.power = super::keys(&[(last - 1.0, 9.0), (last, 12.0)]);
    let way = [-9.0, 9.0].map(|x| middle + DVec3::X * x);
    let track = TransformTrack {
        translate: super::keys(&[(1.0, way[0]), (last, way[1])]),
        scale: rests(DVec3::splat(0.3)),
        ..TransformTrack::identity()
    };
    let models = vec![
        super::still("mirror", wall([-3.0, 3.0], [-1.0, 4.0], 0.0, 0), Vec3::ZERO),
        super::still("screen", wall([5.0, -5.0], [-1.0, 5.0], 8.0, 1), Vec3::ZERO),
        super::moving("flyer", super::octahedron(1, true), track),
    ];
    let camera = super::camera(rests(eye), rests(eye - DVec3::Z));
    super::scene(camera, models, vec![mirror, super::matt(0.6)], vec![light])
}

pub fn lamp(x: f64, y: f64, z: f64) -> Light {
    super::light("lamp", LightKind::Point { position: rests(DVec3::new(x, y, z)) }, 9.0)
}

/// A flyer that a camera sees [in a mirror](before_a_mirror) alone.
pub fn seen_in_a_mirror() -> (DVec3, Light) {
    (DVec3::new(0.0, 1.5, 4.0), lamp(0.0, 9.0, 7.5))
}

/// An ellipse that shines to less than all of its side, a sphere and a sun of four degrees, all of which move, instead of all other lights.
pub fn with_area_lights(mut scene: Scene) -> Scene {
    let disk = LightKind::Disk(Panel {
        position: goes(DVec3::new(-3.0, 4.0, 1.0), DVec3::new(-2.5, 4.2, 1.0)),
        spread: 120.0.into(),
        ..Panel::at_rest(DVec3::ZERO, DVec3::ZERO, [1.4, 0.9])
    });
    let sphere = LightKind::Sphere {
        position: goes(DVec3::new(2.0, 3.0, 2.0), DVec3::new(2.2, 2.6, 2.5)),
        radius: 0.4.into(),
        faces: false,
    };
    let direction = goes(DVec3::new(0.5, -1.0, -0.3), DVec3::new(0.6, -1.0, -0.2));
    let sun = LightKind::Sun { direction, angle: 4.0.into() };
    scene.lights = vec![
        super::light("disk", disk, 5.0),
        super::light("sphere", sphere, 6.0),
        super::light("sun", sun, 0.4),
    ];
    scene
}

/// A panel above the world.
pub fn panel(position: Track<DVec3>) -> Light {
    let kind =
        LightKind::Rectangle(Panel { position, ..Panel::at_rest(DVec3::ZERO, DVec3::ZERO, [2.0, 1.0]) });
    super::light("panel", kind, 20.0)
}

/// Adds a thing of rough metal to a world, and last of all one that glows.
pub fn add_metal_and_glow(scene: &mut Scene) {
    let metal =
        MetalRough { base: Vec3::splat(0.7), roughness: 0.4, metallic: 0.5, head_on: 0.04, solid: 1.0 };
    let number = scene.materials.len() as u16;
    scene.materials.push(Material { metal_rough: Some(metal), ..matt(0.35) });
    scene.materials.push(Material { emission: Vec3::new(4.0, 2.0, 1.0), ..matt(0.2) });
    let metal = still("metal", octahedron(number, true), Vec3::new(-0.5, 1.0, 2.0));
    scene.models.extend([metal, still("glow", floor(0.4, number + 1), Vec3::new(-3.0, 2.5, 2.0))]);
}

//! Surfaces of which pictures cut parts out: do pictures show what is behind, and is reuse exact?

use afterimage::animation::TransformTrack;
use afterimage::frame::Renderer;
use afterimage::scene::cutout::{Cutout, LEAST_OPACITY};
use afterimage::scene::texture::{Mapping, Wrap};
use afterimage::scene::{Material, Mesh, Scene};
use afterimage::settings::Settings;
use afterimage::trace::BackendKind;
use glam::{DVec3, Vec2, Vec3};

use crate::toy;
use crate::toy::worlds::*;

/// A sheet of 2 x 2 with a grid of holes.
fn holes(material: u16) -> Mesh {
    let sheet = toy::sheet(1.0, 2, material, false);
    let texels = (0..16_u8).map(|i| [255, 255, 255, if (i + i / 4) % 2 == 0 { 250 } else { 40 }]).collect();
    let mapping = Mapping::scaled(Vec2::splat(2.5), Vec2::ZERO, [Wrap::Repeat; 2]);
    let texture = afterimage::scene::Texture::of_bytes("holes".into(), [4, 4], texels, mapping);
    toy::cut_out(sheet, 0..8, &texture)
}

/// The world under a leaf that rests and one that flies; both glow if `glows`.
fn world_of_leaves(glows: bool) -> Scene {
    let mut scene = with_area_lights(world());
    let emission = if glows { Vec3::new(3.0, 2.0, 1.0) } else { Vec3::ZERO };
    // the tracers ask the meshes; materials say it for those who read scenes
    let cutout = Some(Cutout::by_picture(0, LEAST_OPACITY));
    scene.materials.push(Material { emission, cutout, ..toy::matt(0.6) });
    let material = (scene.materials.len() - 1) as u16;
    let flies = TransformTrack {
        translate: toy::keys(&[(1.0, DVec3::new(-0.8, 1.4, 0.9)), (9.0, DVec3::new(0.9, 1.1, 0.4))]),
        rotate: toy::keys(&[(1.0, DVec3::ZERO), (9.0, DVec3::new(60.0, 40.0, 0.0))]),
        ..TransformTrack::identity()
    };
    scene.models.push(toy::still("rests", holes(material), Vec3::new(0.4, 1.9, 0.0)));
    scene.models.push(toy::moving("flies", holes(material), flies));
    scene
}

#[test]
fn reuse_is_exact_where_holes_rest_and_fly() {
    let camera = |scene| with_camera(scene, goes(EYE, EYE + DVec3::new(0.6, 0.2, -0.8)), rests(TARGET));
    for (scene, backend, name) in [
        (camera(world_of_leaves(false)), BackendKind::Embree, "the camera goes"),
        (world_of_leaves(true), BackendKind::Embree, "they glow"),
        (camera(world_of_leaves(true)), BackendKind::Rust, "in Rust"),
    ] {
        let settings = Settings { paths: 2, reflections: 1, ..toy::audited(2) };
        let mut renderer = Renderer::with(backend, &scene, &settings).unwrap();
        for finished in (1..=5).map(|frame| renderer.render(frame, true).unwrap()) {
            let audit = finished.stats.audit.unwrap();
            assert_eq!(audit.wrong(), 0, "{name}, frame {}: {audit:?}", finished.stats.frame);
        }
    }
}

/// A wall whose right half is cut out, lit from behind: a floor in front of it is as bright on the right as without it.
#[test]
fn light_and_sight_pass_holes() {
    let wall = |half_cut: bool| {
        let corners = [[-2.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 3.0, 0.0], [-2.0, 3.0, 0.0]];
        let wall = toy::mesh(&corners, &[[0, 1, 2], [0, 2, 3]], 0, true);
        let uvs = corners.iter().map(|[x, y, _]| Vec2::new((x + 2.0) / 4.0, *y)).collect();
        let wall = wall.with_triangles(|triangles| triangles.uvs = uvs);
        if half_cut { toy::cut_out(wall, 0..2, &toy::opacity(255, 0)) } else { wall }
    };
    let rendered = |models: Vec<Mesh>| {
        let place = |mesh: Mesh| toy::still("model", mesh, Vec3::ZERO);
        let models = models.into_iter().map(place).collect();
        let sun = afterimage::scene::LightKind::Directional {
            direction: afterimage::animation::Track::constant(DVec3::new(0.0, -1.0, 0.6)),
        };
        let camera = toy::camera(rests(DVec3::new(0.0, 2.0, 6.0)), rests(DVec3::new(0.0, 0.8, 0.0)));
        let scene = toy::scene(camera, models, vec![toy::matt(0.5)], vec![toy::light("sun", sun, 1.0)]);
        toy::render(&scene, &toy::settings(1), 1).pop().unwrap()
    };
    let floor = || toy::floor(4.0, 0);
    let [open, shut, half] =
        [vec![floor()], vec![floor(), wall(false)], vec![floor(), wall(true)]].map(rendered);
    // of the sky through the hole, of the wall, and of the floor before either half
    for (x, y, as_open, name) in [
        (60, 20, true, "through the hole"),
        (36, 20, false, "the wall"),
        (60, 46, true, "before the hole"),
        (36, 46, false, "before the wall"),
    ] {
        let [open, shut, half] = [&open, &shut, &half].map(|finished| toy::color(finished, x, y));
        assert!(open != shut, "{name}: {open} in any case");
        assert_eq!(half, if as_open { open } else { shut }, "{name}");
    }
}

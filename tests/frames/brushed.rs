//! Do brushed surfaces spread light along their grooves, and is what stays of them what would be made anew?

use std::sync::Arc;

use afterimage::scene::details::{Details, ObjectSpace};
use afterimage::scene::material::Anisotropy;
use afterimage::scene::{Background, Environment, LightKind, Material, Mesh, Panel};
use afterimage::settings::Settings;
use glam::{DVec3, Vec2, Vec3};

use crate::changing::{CHANGES, expect_nothing_found};
use crate::metal_rough::metal_rough;
use crate::toy;
use crate::toy::worlds::*;

fn brushed(amount: f32, turn: f32, around: Option<Vec3>) -> Material {
    Material { anisotropy: Some(Anisotropy { amount, turn, around }), ..metal_rough(0.8, 0.4, 1.0) }
}

/// A floor whose first texture coordinate grows along X.
fn floor() -> Mesh {
    let mesh = toy::floor(9.0, 0);
    let uvs = mesh.triangles().positions.as_slice().iter().map(|[x, _, z]| Vec2::new(*x, -z)).collect();
    mesh.with_triangles(|triangles| triangles.uvs = uvs)
}

/// A lamp above a floor, seen from straight above. How far its highlight reaches along X and along Z.
fn reach(material: Material, mesh: Mesh) -> [f32; 2] {
    let camera = toy::camera(rests(DVec3::new(0.0, 4.0, 0.0)), rests(DVec3::new(0.0, 0.0, -1e-6)));
    let models = vec![toy::still("floor", mesh, Vec3::ZERO)];
    let mut scene = toy::scene(camera, models, vec![material], vec![lamp(0.0, 4.0, 0.0)]);
    scene.background = Background::uniform(Vec3::ZERO);
    let finished = toy::render(&scene, &toy::audited(1), 1).remove(0);
    assert_eq!(toy::differing(&finished), 0);
    let middle = toy::pixel(&finished, "specular.G", 48, 36);
    let width =
        |bright: &dyn Fn(u32) -> f32| (0..36).take_while(|step| bright(*step) > 0.3 * middle).count() as f32;
    [
        width(&|step| toy::pixel(&finished, "specular.G", 48 + step, 36)),
        width(&|step| toy::pixel(&finished, "specular.G", 48, 35 - step)),
    ]
}

#[test]
fn highlights_are_long_along_the_tangent() {
    let round = reach(Material { anisotropy: None, ..brushed(0.0, 0.0, None) }, floor());
    assert_eq!(round[0], round[1]);
    let [along, across] = reach(brushed(0.8, 0.0, None), floor());
    assert!(along > round[0] && across < 0.6 * along, "{along} {across} {round:?}");
    let turned = reach(brushed(0.8, std::f32::consts::FRAC_PI_2, None), floor());
    assert_eq!(turned, [across, along]);
    // without texture coordinates it is round
    assert_eq!(reach(brushed(0.8, 0.0, None), toy::floor(9.0, 0)), round);
}

/// Turned metal: seen from above, the highlight of a lamp lies across grooves that lead around the middle. Of a place on the X axis the tangent
/// is along Z.
#[test]
fn grooves_lead_around_an_axis() {
    let mesh = floor();
    let space = Some(ObjectSpace::around(mesh.triangles().positions.as_slice()));
    let mut details = Details::clone(&mesh.details);
    details.space = space;
    let details = Arc::new(details);
    let camera = toy::camera(rests(DVec3::new(2.0, 4.0, 0.0)), rests(DVec3::new(2.0, 0.0, -1e-6)));
    let models = vec![toy::still("disk", Mesh { details, ..mesh }, Vec3::ZERO)];
    let material = brushed(0.8, 0.0, Some(Vec3::Y));
    let mut scene = toy::scene(camera, models, vec![material], vec![lamp(2.0, 4.0, 0.0)]);
    scene.background = Background::uniform(Vec3::ZERO);
    let finished = toy::render(&scene, &toy::audited(1), 1).remove(0);
    assert_eq!(toy::differing(&finished), 0);
    let at = |x: u32, y: u32| toy::pixel(&finished, "specular.G", x, y);
    assert!(at(48, 24) > 2.0 * at(60, 36), "{} {}", at(48, 24), at(60, 36));
}

/// A panel is seen once, whether highlights, rays or both show it, and a white one is white in an even sky.
#[test]
fn light_is_neither_lost_nor_made() {
    let shown = |sky: f32, depth: u32| {
        let camera = toy::camera(rests(DVec3::new(0.0, 1.5, 4.0)), rests(DVec3::ZERO));
        let white = Material { anisotropy: brushed(0.7, 0.4, None).anisotropy, ..metal_rough(1.0, 0.5, 1.0) };
        let models = vec![toy::still("floor", floor(), Vec3::ZERO)];
        let mut scene = toy::scene(camera, models, vec![white], vec![]);
        scene.background = Background::uniform(Vec3::splat(sky));
        if sky > 0.0 {
            scene.environment = Some(Environment::from_background(&scene.background));
        } else {
            let panel = Panel::at_rest(DVec3::new(0.0, 2.0, -3.0), DVec3::ZERO, [2.0, 2.0]);
            scene.lights.push(toy::light("panel", LightKind::Rectangle(panel), 30.0));
        }
        let settings = Settings { depth, reflections: 32, paths: 4, ..toy::audited(2) };
        let finished = toy::render(&scene, &settings, 1).remove(0);
        assert_eq!(toy::differing(&finished), 0);
        let [object, green] =
            ["object.V", "G"].map(|plane| finished.film.values(plane).expect("it is there"));
        let of_floor: Vec<f32> =
            object.iter().zip(green).filter(|(object, _)| **object == 1.0).map(|(_, green)| green).collect();
        of_floor.iter().sum::<f32>() / of_floor.len() as f32
    };
    let white = shown(1.0, 1);
    // light that is reflected several times is that of a round lobe
    assert!((white - 1.0).abs() < 0.03, "{white}");
    let [alone, shared] = [0, 1].map(|depth| shown(0.0, depth));
    assert!((shared / alone - 1.0).abs() < 0.03, "{alone} {shared}");
}

/// Whatever moves: what stays is what would be made anew.
#[test]
fn an_audit_finds_nothing() {
    let mut scene = world();
    for material in [0, 1] {
        scene.materials[material] = brushed(0.7, 0.5, (material == 1).then_some(Vec3::Y));
    }
    for model in &mut scene.models {
        let mesh = Mesh::clone(&model.mesh);
        let positions = mesh.triangles().positions.as_slice();
        let uvs = positions.iter().map(|[x, y, z]| Vec2::new(x + 0.3 * y, z - y)).collect();
        let space = Some(ObjectSpace::around(positions));
        let mut details = Details::clone(&mesh.details);
        details.space = space;
        let details = Arc::new(details);
        model.mesh = Arc::new(Mesh { details, ..mesh }.with_triangles(|triangles| triangles.uvs = uvs));
    }
    let settings = Settings { paths: 2, reflections: 2, depth: 3, ..toy::settings(1) };
    expect_nothing_found(&scene, &CHANGES, &settings);
}

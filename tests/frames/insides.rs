//! Is light right that passes through surfaces: glass that absorbs it, panes, and what is translucent?

use afterimage::scene::material::{Entry, Optics, Scattering};
use afterimage::scene::{Background, Environment, Material, Mesh, Scene};
use afterimage::settings::Settings;
use glam::{DVec3, Vec3};

use crate::changing::{CHANGES, expect_nothing_found};
use crate::toy;
use crate::toy::worlds::*;

const ABSORPTION: Vec3 = Vec3::new(0.2, 0.7, 1.5);

/// Glass that absorbs light and bends it by this index.
fn absorbing(index: f32) -> Material {
    Material { optics: Optics::clear(Vec3::ONE, index, Vec3::ONE), absorption: ABSORPTION, ..toy::matt(0.0) }
}

fn pane(index: f32) -> Material {
    let optics = Optics::Glass {
        transmission: Vec3::ONE,
        index,
        reflection: Vec3::ONE,
        total: Vec3::ONE,
        is_rough: false,
        is_thin: true,
    };
    Material { optics, ..toy::matt(0.0) }
}

fn leaf(through: f32) -> Material {
    let scattering = Some(Scattering { below: Vec3::ZERO, radius: Vec3::ZERO, through, entry: Entry::MATT });
    Material { scattering, ..toy::matt(0.6) }
}

/// A box of this thickness across Z, 4 wide and high.
fn slab(thickness: f32, material: u16) -> Mesh {
    let corner = |number: u32| {
        let side = |bit: u32, half: f32| if number >> bit & 1 == 1 { half } else { -half };
        [side(0, 2.0), side(1, 2.0), side(2, 0.5 * thickness)]
    };
    let corners: Vec<[f32; 3]> = (0..8).map(corner).collect();
    let faces = [[4, 5, 7, 6], [1, 0, 2, 3], [5, 1, 3, 7], [0, 4, 6, 2], [6, 7, 3, 2], [0, 1, 5, 4]];
    let triangles: Vec<[u32; 3]> =
        faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    toy::mesh(&corners, &triangles, material, false)
}

/// One sheet, 4 wide and high, at Z = 0.
fn sheet(material: u16, casts_shadow: bool) -> Mesh {
    let corners = [[-2., -2., 0.], [2., -2., 0.], [2., 2., 0.], [-2., 2., 0.]];
    toy::mesh(&corners, &[[0, 1, 2], [0, 2, 3]], material, casts_shadow)
}

/// Something before an even sky of 1, seen straight on.
fn before_a_sky(mesh: Mesh, material: Material) -> Scene {
    let camera = toy::camera(rests(DVec3::new(0.0, 0.0, 6.0)), rests(DVec3::ZERO));
    let mut scene = toy::scene(camera, vec![toy::still("thing", mesh, Vec3::ZERO)], vec![material], vec![]);
    scene.background = Background::uniform(Vec3::ONE);
    scene.environment = Some(Environment::from_background(&scene.background));
    scene
}

fn middle(scene: &Scene, settings: &Settings) -> Vec3 {
    let finished = toy::render(scene, settings, 1).remove(0);
    assert_eq!(toy::differing(&finished), 0);
    let around = (0..16).map(|number| toy::color(&finished, 46 + number % 4, 34 + number / 4));
    around.sum::<Vec3>() / 16.0
}

/// Light fades with the length of its way in glass, and with nothing else.
#[test]
fn thick_glass_is_darker_than_thin_glass() {
    for thickness in [0.25, 1.0, 3.0] {
        let seen = middle(&before_a_sky(slab(thickness, 0), absorbing(1.0)), &toy::audited(1));
        let wanted = (-ABSORPTION * thickness).exp();
        assert!((seen - wanted).abs().max_element() < 4e-3, "{thickness}: {seen}, not {wanted}");
        // both walls reflect 4 % of a sky that is 1 all around; what is reflected inside goes its way more often
        let bent = middle(&before_a_sky(slab(thickness, 0), absorbing(1.5)), &toy::audited(1));
        let (once, passes) = (wanted, 0.96 * 0.96);
        let wanted = 0.04 + once * passes / (1.0 - 0.0016 * once * once) + 0.04 * once * once * passes;
        assert!((bent - wanted).abs().max_element() < 0.01, "{thickness}: {bent}, not {wanted}");
    }
}

/// A matt floor below glass that absorbs: paths that light it fade as rays of the eye do.
#[test]
fn paths_fade_in_glass() {
    let gathered = |absorption: Vec3| {
        let camera = toy::camera(rests(DVec3::new(0.0, 0.05, 1.0)), rests(DVec3::new(0.0, -0.1, 0.0)));
        let roof = toy::still("glass", slab(0.5, 1), Vec3::ZERO);
        let glass = Material { absorption, ..absorbing(1.0) };
        let floor = toy::still("wall", sheet(0, true), Vec3::new(0.0, 0.0, -0.2505));
        let mut scene = toy::scene(camera, vec![floor, roof], vec![toy::matt(0.5), glass], vec![]);
        scene.background = Background::uniform(Vec3::ONE);
        // what is asked for comes straight and undimmed through clear glass
        let mut sky = Environment::from_background(&scene.background);
        sky.samples = 0;
        scene.environment = Some(sky);
        middle(&scene, &Settings { paths: 256, bounces: 4, depth: 6, ..toy::audited(1) })
    };
    let (clear, dark) = (gathered(Vec3::ZERO), gathered(Vec3::splat(1.0)));
    // by the cosine law a way through a layer of half a unit is left with 2 E3(0.5) of its light, and the eye's own with e^-0.5
    let wanted = 2.0 * 0.221_604 * (-0.5_f32).exp();
    let share = dark.y / clear.y;
    assert!((share / wanted - 1.0).abs() < 0.12, "{share}, not {wanted}: {clear} {dark}");
}

/// A pane shows what is straight behind it, and reflects as both of its walls do.
#[test]
fn panes_are_as_clear_as_two_walls() {
    let mut scene = before_a_sky(sheet(0, false), pane(1.5));
    let seen = middle(&scene, &toy::audited(1));
    assert!((seen - 1.0).abs().max_element() < 2e-3, "in a furnace it is not seen: {seen}");
    // a wall behind it that shines, and nothing before it
    let glow = Material { emission: Vec3::ONE, ..toy::matt(0.0) };
    scene.models.push(toy::still("wall", sheet(1, true), Vec3::new(0.0, 0.0, -1.0)));
    scene.materials.push(glow);
    (scene.background, scene.environment) = (Background::uniform(Vec3::ZERO), None);
    let seen = middle(&scene, &toy::audited(1));
    assert!((seen - (1.0 - 0.08 / 1.04)).abs().max_element() < 2e-3, "{seen}");
}

/// A sheet that is lit from behind shows what comes through, one that is lit from before what does not; in an even sky it shows its colour.
#[test]
fn leaves_show_the_light_behind_them() {
    let lit = |through: f32, z: f64| {
        let mut scene = before_a_sky(sheet(0, true), leaf(through));
        (scene.background, scene.environment) = (Background::uniform(Vec3::ZERO), None);
        scene.lights.push(lamp(0.0, 0.0, z));
        middle(&scene, &Settings { paths: 64, bounces: 1, ..toy::audited(1) }).y
    };
    let matt = lit(0.0, 4.0);
    for (through, z, share) in [(0.25, 4.0, 0.75), (0.25, -4.0, 0.25), (1.0, -4.0, 1.0), (1.0, 4.0, 0.0)] {
        let found = lit(through, z) / matt;
        assert!((found - share).abs() < 0.04, "{through} {z}: {found}, not {share}");
    }
    for through in [0.3, 1.0] {
        let seen =
            middle(&before_a_sky(sheet(0, true), leaf(through)), &Settings { paths: 64, ..toy::audited(1) });
        assert!((seen - 0.6).abs().max_element() < 0.02, "{through}: {seen}");
    }
}

/// Seen in a mirror, too, a leaf shows the light behind it.
#[test]
fn mirrors_show_leaves_as_the_eye_sees_them() {
    let [mut straight, mut mirrored] = [false, true].map(|is_mirrored| {
        let mut scene = before_a_sky(sheet(0, true), leaf(0.5));
        (scene.background, scene.environment) = (Background::uniform(Vec3::ZERO), None);
        scene.lights.push(lamp(0.0, 0.0, -4.0));
        if is_mirrored {
            let optics = Optics::Mirror { tint: Vec3::ONE, fresnel: false };
            scene.materials.push(Material { optics, ..toy::matt(0.0) });
            scene.models.push(toy::still("mirror", sheet(1, true), Vec3::new(0.0, 0.0, 3.0)));
            scene.camera = toy::camera(rests(DVec3::new(0.0, 0.0, 2.0)), rests(DVec3::new(0.0, 0.0, 3.0)));
        }
        middle(&scene, &Settings { paths: 256, bounces: 1, ..toy::audited(1) }).y
    });
    (straight, mirrored) = (straight.max(1e-6), mirrored.max(1e-6));
    assert!((mirrored / straight - 1.0).abs() < 0.1, "{straight} {mirrored}");
}

/// Whatever moves: what stays is what would be made anew.
#[test]
fn an_audit_finds_nothing() {
    let settings = Settings { paths: 4, bounces: 3, depth: 4, ..toy::settings(1) };
    for glass in [absorbing(1.4), pane(1.5)] {
        let mut scene = world();
        scene.materials[0] = leaf(0.4);
        scene.materials[1] = glass;
        expect_nothing_found(&scene, &CHANGES, &settings);
    }
}

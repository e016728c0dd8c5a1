//! Quadrics in shot files: what they mean, and what is said about mistakes in them.

use afterimage::scene::material::Optics;
use glam::{DVec3, Vec3};

use crate::small_shot::*;

/// A shot with a quadric of this table beside the usual model.
fn with(quadric: &str) -> String {
    format!("{REST}[[model]]\nquadric = {{ {quadric} }}\n")
}

#[test]
fn every_type_is_read() {
    for (table, name, pieces, low, high) in [
        ("type = \"sphere\", radius = 3", "sphere", 1, [-3.0; 3], [3.0; 3]),
        ("type = \"ellipsoid\", radii = [1, 2, 3]", "ellipsoid", 1, [-1.0, -2.0, -3.0], [1.0, 2.0, 3.0]),
        ("type = \"cylinder\"", "cylinder", 3, [-1.0, 0.0, -1.0], [1.0, 2.0, 1.0]),
        ("type = \"cylinder\", open = true, height = 5", "cylinder", 1, [-1.0, 0.0, -1.0], [1.0, 5.0, 1.0]),
        ("type = \"cone\", radius = 2", "cone", 2, [-2.0, 0.0, -2.0], [2.0; 3]),
        ("type = \"cone\", top = 3", "cone", 3, [-3.0, 0.0, -3.0], [3.0, 2.0, 3.0]),
        ("type = \"paraboloid\"", "paraboloid", 2, [-1.0, 0.0, -1.0], [1.0, 2.0, 1.0]),
        ("type = \"hyperboloid\"", "hyperboloid", 3, [-1.0, 0.0, -1.0], [1.0, 2.0, 1.0]),
        ("type = \"hyperboloid\", gap = 0.5", "hyperboloid", 4, [-1.0, 0.0, -1.0], [1.0, 2.0, 1.0]),
    ] {
        let shot = load(&format!("{}[ambient]\ncolor = [1, 1, 1]\n", with(table)));
        let model = &shot.scene.models[1];
        let (found_low, found_high) = model.mesh.bounds();
        assert_eq!(model.name, name);
        assert_eq!(model.mesh.as_curved().unwrap().count(), pieces, "{table}");
        for (found, wanted) in [(found_low, low), (found_high, high)] {
            assert!((found - DVec3::from(wanted)).abs().max_element() < 1e-5, "{table}: {found}");
        }
        assert!(shot.warnings.is_empty());
    }
}

#[test]
fn materials_are_those_of_the_shot_file() {
    let shot = load(&format!(
        "{}name = \"ball\"\n[[material]]\nname = \"glass\"\nillum = 4\nni = 1.5\nd = 0.2\n\
         [[model]]\nquadric = {{ type = \"cone\" }}\n",
        with("type = \"sphere\", material = \"glass\"")
    ));
    let [_, ball, cone] = &shot.scene.models[..] else { panic!("three models") };
    let material =
        |model: &afterimage::scene::Model| &shot.scene.materials[usize::from(model.mesh.material_of[0])];
    assert_eq!((ball.name.as_str(), material(ball).name.as_str()), ("ball", "glass"));
    assert!(matches!(material(ball).optics, Optics::Glass { index: 1.5, .. }));
    assert_eq!(ball.mesh.shadow_casting, 0, "it is clear");
    assert_eq!((material(cone).diffuse, material(cone).optics), (Vec3::splat(0.6), Optics::Opaque));
    assert_eq!(cone.mesh.shadow_casting, 2);
}

#[test]
fn transforms_are_those_of_other_models() {
    let place = "translate = [10, 0, 0]\nrotate = [0, 0, 90]\nscale = [1, 2, -1]\n";
    let still = load(&format!("{}{place}", with("type = \"cylinder\""))).scene;
    let (low, high) = still.models[1].mesh.bounds();
    assert!((low - DVec3::new(6.0, -1.0, -1.0)).abs().max_element() < 1e-4, "{low}");
    assert!((high - DVec3::new(10.0, 1.0, 1.0)).abs().max_element() < 1e-4, "{high}");
    let moving = load(&format!(
        "{}{place}[[model.key]]\nframe = 1\n[[model.key]]\nframe = 9\nscale = [1, 1, -2]\n",
        with("type = \"cylinder\"")
    ));
    let model = &moving.scene.models[1];
    assert!(
        !model.track.is_constant() && (model.mesh.bounds().1 - DVec3::new(1.0, 2.0, 1.0)).length() < 1e-5
    );
}

/// Planes are drawn far beyond all else, and make no shot larger, wherever they are and whatever its units.
#[test]
fn planes_reach_far_and_have_no_size() {
    let usual = load(REST);
    for (scale, shot) in [
        (1.0, with("type = \"plane\"")),
        (1.0, format!("{}scale = 100\nrotate = [20, 0, 0]\n", with("type = \"plane\""))),
        (
            1e-9,
            with("type = \"plane\"")
                .replace("[0, 0, 5]", "[0, 0, 5e-9]")
                .replace("\"m.obj\"", "\"m.obj\"\nscale = 1e-9"),
        ),
        (
            1e9,
            with("type = \"plane\"")
                .replace("[0, 0, 5]", "[0, 0, 5e9]")
                .replace("\"m.obj\"", "\"m.obj\"\nscale = 1e9"),
        ),
    ] {
        let shot = load(&shot);
        let (low, high) = shot.scene.models[1].mesh.bounds();
        let reach = (high - low).max_element() / f64::from(shot.scene.space.length(1.0));
        assert!(reach.is_finite() && (1e6..1e8).contains(&(reach / scale)), "{scale}: {reach}");
        let radius = shot.settings.occlusion_radius / usual.settings.occlusion_radius / scale;
        assert!((radius - 1.0).abs() < 1e-6, "{radius}");
    }
    let alone =
        format!("{}[[model]]\nquadric = {{ type = \"plane\" }}\n", REST.split("[[model]]").next().unwrap());
    assert!(load(&alone).scene.models[0].mesh.bounds().1.is_finite());
}

#[test]
fn mistakes_name_their_place() {
    for (table, wanted) in [
        ("type = \"ball\"", "s.toml:8:20: `quadric`: unknown value `ball`"),
        ("radius = 1", "s.toml:8:11: the key `type` is missing"),
        ("type = \"sphere\", radius = 0", "s.toml:8:39: `radius` is 0: it must be a length from 1e-9 to 1e9"),
        ("type = \"sphere\", radius = -2", "s.toml:8:39: `radius` is -2: it must be a length"),
        ("type = \"sphere\", radius = nan", "s.toml:8:39: `radius` is NaN: it must be a length"),
        ("type = \"sphere\", radius = inf", "s.toml:8:39: `radius` is inf: it must be a length"),
        (
            "type = \"sphere\", height = 2",
            "s.toml:8:39: a sphere has no `height`: it takes radius and material",
        ),
        ("type = \"plane\", radius = 2", "s.toml:8:38: a plane has no `radius`: it takes `material` alone"),
        ("type = \"ellipsoid\"", "s.toml:8:11: an ellipsoid needs `radii = [x, y, z]`"),
        ("type = \"ellipsoid\", radii = [1, 0, 1]", "s.toml:8:41: `radii` must be three lengths"),
        ("type = \"cone\", top = -1", "s.toml:8:34: `top` is -1: it must be 0 (a tip)"),
        ("type = \"hyperboloid\", waist = 1", "s.toml:8:43: `waist` is 1: it must be more than"),
        ("type = \"hyperboloid\", gap = 2", "s.toml:8:41: `gap` is 2: it must be more than"),
        ("type = \"hyperboloid\", waist = 0.5, gap = 1", "s.toml:8:54: `gap` and `waist` exclude each other"),
        ("type = \"sphere\", material = \"glas\"", "s.toml:8:41: there is no [[material]] `glas`"),
        ("type = \"sphere\", material = \"\"", "s.toml:8:41: there is no [[material]] ``"),
    ] {
        let error = error(&with(table));
        assert!(error.starts_with(wanted), "{table}: {error}");
    }
    for (more, wanted) in [
        ("quadric = { type = \"sphere\" }\n", "s.toml:7:11: `obj` and `quadric` exclude each other"),
        (
            "[[model]]\nname = \"none\"\n",
            "s.toml:7:1: the key `obj` is missing: a model is an OBJ file, a glTF file (`gltf`), a USD file (`usd`), a PLY file (`ply`), a `quadric`, `curves`, or an OpenVDB file (`vdb`)",
        ),
        ("[[model]]\nscale = 0\nquadric = { type = \"cone\" }\n", "s.toml:8:9: `scale` must not be zero"),
    ] {
        let error = error(&format!("{REST}{more}"));
        assert!(error.starts_with(wanted), "{more}: {error}");
    }
}

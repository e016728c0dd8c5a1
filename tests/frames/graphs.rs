//! Do surfaces look as their graphs say, wherever they are, and is reuse exact there?

use std::fs;
use std::path::Path;

use afterimage::scene::{self, Scene};
use afterimage::settings::Settings;
use glam::Vec3;

use crate::toy;

/// A square in the plane y = 0 that looks up, from -2 to 2.
const FLOOR: &str = "v -2 0 2\nv 2 0 2\nv 2 0 -2\nv -2 0 -2\nusemtl m\nf 1 2 3 4\n";

/// Four of its shapes: a corner goes up and down.
const SHAPES: [f32; 4] = [0.0, 0.4, 0.8, 0.2];

/// Places in object space as colours: x to red, z to green; in the box around the mesh; and squares of two colours, which begin and end
/// at once: a place that is off by a rounding has another colour.
const GRAPHS: [&str; 3] = [
    "<position name=\"p\" type=\"vector3\"/><blender_math name=\"x\" type=\"float\"><input name=\"a\" type=\"float\" nodename=\"s\" output=\"outx\"/>\
     <input name=\"b\" type=\"float\" value=\"0.25\"/><input name=\"c\" type=\"float\" value=\"0.5\"/><input name=\"operation\" type=\"string\" value=\"multiply_add\"/></blender_math>\
     <blender_math name=\"z\" type=\"float\"><input name=\"a\" type=\"float\" nodename=\"s\" output=\"outz\"/>\
     <input name=\"b\" type=\"float\" value=\"0.25\"/><input name=\"c\" type=\"float\" value=\"0.5\"/><input name=\"operation\" type=\"string\" value=\"multiply_add\"/></blender_math>\
     <separate3 name=\"s\" type=\"multioutput\"><input name=\"in\" type=\"vector3\" nodename=\"p\"/></separate3>\
     <combine3 name=\"n\" type=\"color3\"><input name=\"in1\" type=\"float\" nodename=\"x\"/><input name=\"in2\" type=\"float\" nodename=\"z\"/></combine3>",
    "<blender_generated_coordinates name=\"p\" type=\"vector3\"/><separate3 name=\"s\" type=\"multioutput\"><input name=\"in\" type=\"vector3\" nodename=\"p\"/></separate3>\
     <combine3 name=\"n\" type=\"color3\"><input name=\"in1\" type=\"float\" nodename=\"s\" output=\"outx\"/><input name=\"in2\" type=\"float\" nodename=\"s\" output=\"outz\"/></combine3>",
    "<position name=\"p\" type=\"vector3\"/><blender_checker name=\"c\" type=\"multioutput\"><input name=\"vector\" type=\"vector3\" nodename=\"p\"/>\
     <input name=\"scale\" type=\"float\" value=\"7.3\"/></blender_checker>\
     <blender_mix_color name=\"n\" type=\"color3\"><input name=\"factor\" type=\"float\" nodename=\"c\" output=\"value\"/><input name=\"b\" type=\"color3\" value=\"0.9, 0.1, 0\"/></blender_mix_color>",
];

fn load(folder: &Path, graph: &str, shader: &str, rest: &str) -> Scene {
    let mtlx = format!(
        "<?xml version=\"1.0\"?>\n<materialx version=\"1.39\">\n<nodegraph name=\"G\">{graph}<output name=\"out\" type=\"color3\" nodename=\"n\"/></nodegraph>\n\
         <bump name=\"B\" type=\"vector3\"><input name=\"height\" type=\"float\" nodename=\"H\" output=\"value\"/><input name=\"scale\" type=\"float\" value=\"0.2\"/></bump>\n\
         <blender_noise name=\"H\" type=\"multioutput\"><input name=\"vector\" type=\"vector3\" nodename=\"P\"/></blender_noise><position name=\"P\" type=\"vector3\"/>\n\
         <open_pbr_surface name=\"S\" type=\"surfaceshader\">\n<input name=\"base_color\" type=\"color3\" nodegraph=\"G\" output=\"out\"/>\n{shader}\n</open_pbr_surface>\n\
         <surfacematerial name=\"m\" type=\"material\"><input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"S\"/></surfacematerial>\n</materialx>\n"
    );
    fs::write(folder.join("m.mtlx"), mtlx).unwrap();
    fs::write(folder.join("floor.obj"), FLOOR).unwrap();
    for (number, up) in SHAPES.iter().enumerate() {
        let shape = FLOOR.replacen("v -2 0 2", &format!("v -2 {up} 2"), 1);
        fs::write(folder.join(format!("floor.{:02}.obj", number + 1)), shape).unwrap();
    }
    let material = "[[material]]\nname = \"m\"\nmtlx = \"m.mtlx\"\n";
    fs::write(folder.join("s.toml"), format!("{rest}{material}")).unwrap();
    scene::load(&folder.join("s.toml"), false).unwrap().scene
}

/// Matt surfaces.
const MATT: &str = "<input name=\"specular_weight\" type=\"float\" value=\"0\"/>";

/// A camera above, at rest, and a sun that lights what looks up by 1.
const ABOVE: &str = "[[camera.key]]\nframe = 1\neye = [0, 6, 0.001]\ntarget = [0, 0, 0]\nfov = 60\n\
                     [[light]]\ntype = \"directional\"\ndirection = [0, -1, 0]\npower = 1\n";

/// Places go with their models: still ones are in world space, moved ones in their own, and look the same.
#[test]
fn colours_are_those_of_places_in_object_space() {
    let folder = tempfile::tempdir().unwrap();
    let placed = "[[model]]\nobj = \"floor.obj\"\nrotate = [0, 90, 0]\nscale = [0.5, 1, 0.75]\ntranslate = [0.5, 0, 0.25]\n";
    let moves = "[[model]]\nobj = \"floor.obj\"\n[[model.key]]\nframe = 1\nrotate = [0, 90, 0]\nscale = [0.5, 1, 0.75]\ntranslate = [0.5, 0, 0.25]\n\
                 [[model.key]]\nframe = 2\ntranslate = [9, 0, 0]\n";
    for (number, graph) in GRAPHS[..2].iter().enumerate() {
        for model in [placed, moves] {
            let scene = load(folder.path(), graph, MATT, &format!("{ABOVE}{model}"));
            let settings = Settings { width: 64, height: 64, ..toy::audited(1) };
            let finished = toy::render(&scene, &settings, 1).pop().unwrap();
            // 60 degrees from top to bottom, from a height of 6
            let per_pixel = 2.0 * 6.0 * 30_f32.to_radians().tan() / 64.0;
            for (x, y) in [(32, 32), (38, 30), (30, 37), (41, 33)] {
                let world = Vec3::new(x as f32 + 0.5 - 32.0, 0.0, y as f32 + 0.5 - 32.0) * per_pixel;
                let moved = world - Vec3::new(0.5, 0.0, 0.25);
                // a turn by 90 degrees about y takes x to -z and z to x
                let object = Vec3::new(-moved.z / 0.5, 0.0, moved.x / 0.75);
                let expected = (object / 4.0 + 0.5).clamp(Vec3::ZERO, Vec3::ONE);
                let found = toy::color(&finished, x, y);
                let expected = Vec3::new(expected.x, expected.z, 0.0);
                assert!(found.abs_diff_eq(expected, 0.02), "{number} {x} {y}: {found} {expected}");
            }
        }
    }
}

/// Quadrics have a space as meshes have: a sphere that was moved shows the places that it had.
#[test]
fn quadrics_have_a_space_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let sphere =
        "[[model]]\nquadric = { type = \"sphere\", radius = 1.0, material = \"m\" }\ntranslate = [1, 0, 0]\n";
    for (graph, expected) in GRAPHS[..2].iter().zip([0.625, 0.75]) {
        let scene = load(folder.path(), graph, MATT, &format!("{ABOVE}{sphere}"));
        let settings = Settings { width: 64, height: 64, ..toy::audited(1) };
        let finished = toy::render(&scene, &settings, 1).pop().unwrap();
        assert_eq!(toy::differing(&finished), 0);
        // above x = 1.5: half a radius from the middle, at a height of 0.87
        let column = 32 + (1.5 / (6.0 - 0.87) * 32.0 / 30_f32.to_radians().tan()) as u32;
        let found = toy::color(&finished, column, 32);
        let found = found.x / toy::color(&finished, column, 32).y * 0.5;
        assert!((found - expected).abs() < 0.03, "{found} {expected}");
    }
}

/// A camera that goes around, lights and paths.
const AROUND: &str = "[render]\nframes = \"1-4\"\n[indirect]\nbounces = 1\npaths = 2\n[camera]\ninterpolation = \"linear\"\n\
                      [[camera.key]]\nframe = 1\neye = [2, 3, 5]\ntarget = [0, 0, 0]\n[[camera.key]]\nframe = 4\neye = [2.3, 3, 4.9]\ntarget = [0, 0, 0]\n\
                      [[light]]\ntype = \"point\"\nposition = [2, 4, 3]\npower = 200\n";

/// Whether a place is computed where it was traced, or where a sample that was kept is looked up: the colour is the same to the bit.
#[test]
fn reuse_is_exact_where_colours_are_computed() {
    let folder = tempfile::tempdir().unwrap();
    let still = "[[model]]\nobj = \"floor.obj\"\nrotate = [20, 30, 10]\n";
    let turns = "[[model]]\nobj = \"floor.obj\"\n[[model.key]]\nframe = 1\n[[model.key]]\nframe = 4\nrotate = [10, 20, 0]\nscale = 1.1\n";
    let deforms = "[[model]]\nobj = \"floor.obj\"\n[model.shapes]\nobj = \"floor.##.obj\"\n";
    let metal = "<input name=\"base_metalness\" type=\"float\" value=\"0.5\"/>";
    // parameters and heights of the same squares
    let varies = "<input name=\"specular_roughness\" type=\"float\" nodegraph=\"G\" output=\"out\"/><input name=\"base_metalness\" type=\"float\" nodegraph=\"G\" output=\"out\"/>";
    let bump = "<input name=\"geometry_normal\" type=\"vector3\" nodename=\"B\"/>";
    let glass = "<input name=\"transmission_weight\" type=\"float\" nodegraph=\"G\" output=\"out\"/><input name=\"transmission_color\" type=\"color3\" nodegraph=\"G\" output=\"out\"/>";
    for shader in [MATT, metal, varies, bump, glass] {
        for model in [still, turns, deforms] {
            let scene = load(folder.path(), GRAPHS[2], shader, &format!("{AROUND}{model}"));
            let settings = Settings { paths: 2, bounces: 1, reflections: 2, ..toy::audited(2) };
            let finished = toy::render(&scene, &settings, 4);
            for (frame, finished) in (1..).zip(&finished) {
                assert_eq!(toy::differing(finished), 0, "frame {frame} of {model}");
            }
            let reused = finished[3].stats.samples.reused();
            assert!(reused > 2_000, "{reused} of {model}");
        }
    }
}

/// Stained glass: what is behind it has the colours of its graph, as far as another says that there is glass; the rest is matt.
#[test]
fn glass_is_where_its_graphs_say_and_as_they_say() {
    let folder = tempfile::tempdir().unwrap();
    let floor = "[background]\ncolor = [1, 1, 1]\n[[model]]\nobj = \"floor.obj\"\n";
    let by = |parameter: &str, of_type: &str| {
        format!("<input name=\"{parameter}\" type=\"{of_type}\" nodegraph=\"G\" output=\"out\"/>")
    };
    let clear = "<input name=\"specular_ior\" type=\"float\" value=\"1\"/><input name=\"specular_roughness\" type=\"float\" value=\"0\"/>";
    let whole = "<input name=\"transmission_weight\" type=\"float\" value=\"1\"/>";
    let (color, weight) = (by("transmission_color", "color3"), by("transmission_weight", "float"));
    // the sun is not there: what is matt is black
    let above = ABOVE.replace("power = 1", "power = 0");
    // what is not glass of it is black all the more
    let black = "<input name=\"base_weight\" type=\"float\" value=\"0\"/>";
    for (glass, sees) in [
        (format!("{whole}{color}"), (|at| at) as fn(Vec3) -> Vec3),
        (format!("{black}{weight}{color}"), |at| at * luma(at)),
        (weight.clone(), |at| Vec3::splat(luma(at))),
        (format!("{weight}{color}"), |at| at * luma(at)),
    ] {
        let scene = load(folder.path(), GRAPHS[0], &format!("{clear}{glass}"), &format!("{above}{floor}"));
        let settings = Settings { width: 64, height: 64, depth: 2, ..toy::audited(1) };
        let finished = toy::render(&scene, &settings, 1).pop().unwrap();
        assert_eq!(toy::differing(&finished), 0);
        let per_pixel = 2.0 * 6.0 * 30_f32.to_radians().tan() / 64.0;
        for (x, y) in [(32, 32), (38, 24), (22, 40)] {
            let world = Vec3::new(x as f32 + 0.5 - 32.0, 0.0, y as f32 + 0.5 - 32.0) * per_pixel;
            let at = world / 4.0 + 0.5;
            let (expected, found) = (sees(Vec3::new(at.x, at.z, 0.0)), toy::color(&finished, x, y));
            assert!(found.abs_diff_eq(expected, 0.02), "{glass} {x} {y}: {found} {expected}");
        }
    }
}

/// Luminance, as nodes convert colours to numbers.
fn luma(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

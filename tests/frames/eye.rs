//! Do surfaces look as the angle says at which they are seen, frame by frame, and is reuse exact there?

use std::fs;
use std::path::Path;

use afterimage::frame::Finished;
use afterimage::scene::{self, Scene};
use afterimage::settings::{Mode, Settings};

use crate::toy;

/// A square in the plane y = 0 that looks up, from -2 to 2.
const FLOOR: &str = "v -2 0 2\nv 2 0 2\nv 2 0 -2\nv -2 0 -2\nusemtl m\nf 1 2 3 4\n";

/// Two squares that lean on each other, with normals that are smooth across the edge.
const ROOF: &str = "v -2 0 1\nv 2 0 1\nv 2 1 0\nv -2 1 0\nv 2 0 -1\nv -2 0 -1\nvn 0 1 1\nvn 0 1 0\nvn 0 1 -1\n\
                    usemtl m\nf 1//1 2//1 3//2 4//2\nf 4//2 3//2 5//3 6//3\n";

/// The cosine of the angle, and a weight of Blender's, as a number and as a colour.
const GRAPH: &str = "<facingratio name=\"cos\" type=\"float\"/>\
    <blender_layer_weight name=\"weight\" type=\"multioutput\"><input name=\"blend\" type=\"float\" value=\"0.4\"/></blender_layer_weight>\
    <blender_mix_color name=\"color\" type=\"color3\"><input name=\"factor\" type=\"float\" nodename=\"weight\" output=\"facing\"/>\
    <input name=\"a\" type=\"color3\" value=\"0.8, 0.1, 0\"/><input name=\"b\" type=\"color3\" value=\"0, 0.3, 0.9\"/></blender_mix_color>\
    <output name=\"cos\" type=\"float\" nodename=\"cos\"/><output name=\"color\" type=\"color3\" nodename=\"color\"/>";

fn load(folder: &Path, shader: &str, rest: &str) -> Scene {
    let mtlx = format!(
        "<?xml version=\"1.0\"?>\n<materialx version=\"1.39\">\n<nodegraph name=\"G\">{GRAPH}</nodegraph>\n\
         <open_pbr_surface name=\"S\" type=\"surfaceshader\">\n{shader}\n</open_pbr_surface>\n\
         <surfacematerial name=\"m\" type=\"material\"><input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"S\"/></surfacematerial>\n</materialx>\n"
    );
    fs::write(folder.join("m.mtlx"), mtlx).unwrap();
    fs::write(folder.join("floor.obj"), FLOOR).unwrap();
    fs::write(folder.join("roof.obj"), ROOF).unwrap();
    for (number, up) in [1.0, 1.4, 1.8, 1.2].iter().enumerate() {
        let shape = ROOF.replacen("v 2 1 0", &format!("v 2 {up} 0"), 1);
        fs::write(folder.join(format!("roof.{:02}.obj", number + 1)), shape).unwrap();
    }
    let material = "[[material]]\nname = \"m\"\nmtlx = \"m.mtlx\"\n";
    fs::write(folder.join("s.toml"), format!("{rest}{material}")).unwrap();
    scene::load(&folder.join("s.toml"), true).unwrap().scene
}

/// A camera that goes down beside the middle of the floor.
const GOES_DOWN: &str = "[camera]\ninterpolation = \"linear\"\n\
    [[camera.key]]\nframe = 1\neye = [0, 3, 4]\ntarget = [0, 0, 0]\nfov = 40\n\
    [[camera.key]]\nframe = 4\neye = [0, 2.4, 4.2]\ntarget = [0, 0, 0]\nfov = 40\n";

/// Light by the cosine: pixel by pixel and frame by frame it is that of the way from the eye.
#[test]
fn what_glows_by_the_angle_does_so_in_each_frame() {
    let folder = tempfile::tempdir().unwrap();
    let glows = "<input name=\"base_weight\" type=\"float\" value=\"0\"/><input name=\"specular_weight\" type=\"float\" value=\"0\"/>\
                 <input name=\"emission_color\" type=\"color3\" nodegraph=\"G\" output=\"cos\"/><input name=\"emission_luminance\" type=\"float\" value=\"1\"/>";
    let scene = load(folder.path(), glows, &format!("{GOES_DOWN}[[model]]\nobj = \"floor.obj\"\n"));
    let settings = Settings { width: 64, height: 64, ..toy::audited(1) };
    let finished = toy::render(&scene, &settings, 4);
    for (frame, finished) in (0..).zip(&finished) {
        assert_eq!(toy::differing(finished), 0, "frame {frame}");
        let share = frame as f32 / 3.0;
        let eye = glam::Vec3::new(0.0, 3.0 - 0.6 * share, 4.0 + 0.2 * share);
        // the middle of the picture, and a place above it
        for up in [0.0_f32, 8.0] {
            let back = (-eye).normalize();
            let right = back.cross(glam::Vec3::Y).normalize();
            let slope = (up - 0.5) / 32.0 * 20_f32.to_radians().tan();
            let way = (back + right.cross(back) * slope + right * (0.5 / 32.0 * 20_f32.to_radians().tan()))
                .normalize();
            let found = toy::color(finished, 32, 32 - up as u32).x;
            assert!((found + way.y).abs() < 4e-3, "frame {frame}, {up} up: {found}, not {}", -way.y);
        }
    }
    assert!(finished[3].stats.samples.reused() > 3_000, "samples stay");
    assert_eq!(finished[3].stats.rays.shadow, 0);
}

fn same_as_in_full(scene: &Scene, settings: &Settings, name: &str) -> Vec<Finished> {
    let reused = toy::render(scene, settings, 4);
    for (frame, finished) in (1..).zip(&reused) {
        assert_eq!(toy::differing(finished), 0, "frame {frame} of {name}");
    }
    assert!(reused[3].stats.samples.reused() > 1_000, "{name}");
    reused
}

/// Colour, roughness, metal, light and holes by the angle, on what rests, turns and deforms, flat or smooth, seen by the eye and by paths.
#[test]
fn reuse_is_exact_where_the_angle_counts() {
    let folder = tempfile::tempdir().unwrap();
    let input = |name: &str, of_type: &str, output: &str| {
        format!("<input name=\"{name}\" type=\"{of_type}\" nodegraph=\"G\" output=\"{output}\"/>")
    };
    let color = input("base_color", "color3", "color");
    let shaders = [
        color.clone(),
        format!("{color}{}", input("base_metalness", "float", "cos")),
        format!("{color}{}", input("specular_roughness", "float", "cos")),
        format!("{color}{}", input("geometry_opacity", "float", "cos")),
        format!(
            "{color}{}<input name=\"emission_luminance\" type=\"float\" value=\"1\"/>",
            input("emission_color", "color3", "color")
        ),
    ];
    let models = [
        "[[model]]\nobj = \"roof.obj\"\nrotate = [20, 30, 10]\n",
        "[[model]]\nobj = \"roof.obj\"\n[[model.key]]\nframe = 1\n[[model.key]]\nframe = 4\nrotate = [10, 20, 0]\nscale = 1.1\n",
        "[[model]]\nobj = \"roof.obj\"\n[model.shapes]\nobj = \"roof.##.obj\"\n",
        "[[model]]\nquadric = { type = \"sphere\", radius = 1.0, material = \"m\" }\n",
    ];
    let light = "[indirect]\nbounces = 1\npaths = 2\n[[light]]\ntype = \"point\"\nposition = [2, 4, 3]\npower = 200\n\
                 [[model]]\nobj = \"floor.obj\"\ntranslate = [0, -1, 0]\n";
    for (number, shader) in shaders.iter().enumerate() {
        // each shader on two models, each model with two shaders at least
        for model in [models[number % 4], models[(number + 1) % 4]] {
            let scene = load(folder.path(), shader, &format!("{light}{GOES_DOWN}{model}"));
            let settings = Settings { paths: 1, bounces: 1, reflections: 2, ..toy::audited(1) };
            same_as_in_full(&scene, &settings, &format!("{number}, {model}"));
        }
    }
}

/// With the eye at rest nothing is looked up anew, and a frame that is inferred is the one in full, to the bit.
#[test]
fn inferred_frames_show_what_full_ones_show() {
    let folder = tempfile::tempdir().unwrap();
    let shader = "<input name=\"base_color\" type=\"color3\" nodegraph=\"G\" output=\"color\"/><input name=\"specular_weight\" type=\"float\" value=\"0\"/>";
    let sun = "[[light]]\ntype = \"directional\"\ndirection = [0, -1, -0.3]\npower = 1\n";
    let model = "[[model]]\nobj = \"roof.obj\"\n";
    let scene = load(folder.path(), shader, &format!("{sun}{GOES_DOWN}{model}"));
    let settings = Settings { width: 64, height: 64, ..toy::audited(4) };
    let reused = same_as_in_full(&scene, &settings, "roof");
    let in_full = toy::render(&scene, &Settings { mode: Mode::Full, ..settings }, 4);
    // samples lie anywhere in their cells: near enough in the middle of a face
    for (x, y) in [(32, 36), (28, 38), (40, 37)] {
        for (frame, (one, other)) in reused.iter().zip(&in_full).enumerate() {
            let [one, other] = [one, other].map(|finished| toy::color(finished, x, y));
            assert!(one.abs_diff_eq(other, 6e-3), "frame {frame}, {x} {y}: {one} {other}");
        }
    }
    // and it does change as the camera goes down
    let change = toy::color(&in_full[0], 32, 36) - toy::color(&in_full[3], 32, 36);
    assert!(change.abs().max_element() > 0.02, "{change}");
}

//! Are MaterialX files read as they are written, and told where they make no sense?

mod pictures;

use std::fs;
use std::path::Path;

use afterimage::scene::material::{Computes, Optics};
use afterimage::scene::on_mesh::OnMesh;
use afterimage::scene::{Material, SceneError, Shot};
use glam::Vec3;

use crate::small_shot::{folder, load_in};

const CAMERA: &str =
    "[[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n[background]\ncolor = [1, 1, 1]\n";

const SQUARE: &str =
    "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl Oak\nf 1/1 2/2 3/3 4/4\n";

/// A file whose material `Oak` has this shader, with other elements beside it.
fn file(shader: &str, others: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<materialx version=\"1.39\">\n{others}\n{shader}\n<surfacematerial name=\"Oak\" type=\"material\">\n\
         <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"S\"/>\n</surfacematerial>\n</materialx>\n"
    )
}

/// An `open_pbr_surface` of these inputs.
fn open_pbr(inputs: &str) -> String {
    format!("<open_pbr_surface name=\"S\" type=\"surfaceshader\">\n{inputs}\n</open_pbr_surface>")
}

fn read(mtlx: &str, keys: &str, is_strict: bool) -> Result<Shot, SceneError> {
    let folder = folder();
    fs::write(folder.path().join("square.obj"), SQUARE).unwrap();
    fs::write(folder.path().join("m.mtlx"), mtlx).unwrap();
    let text = format!(
        "{CAMERA}[[model]]\nobj = \"square.obj\"\n[[material]]\nname = \"Oak\"\nmtlx = \"m.mtlx\"\n{keys}\n"
    );
    load_in(folder.path(), &text, is_strict)
}

fn shot(mtlx: &str) -> Shot {
    read(mtlx, "", false).unwrap()
}

fn oak(shot: &Shot) -> &Material {
    shot.scene.materials.iter().find(|material| material.name == "Oak").unwrap()
}

fn warnings(shot: &Shot) -> Vec<String> {
    shot.warnings.iter().map(ToString::to_string).collect()
}

/// Reflectance of the square at weights of its second and third corner.
fn reflectance(shot: &Shot, weights: [f32; 2]) -> Vec3 {
    OnMesh::on(&shot.scene.models[0], 0, weights).reflectance(&shot.scene, oak(shot))
}

/// The base colour of a node `n` among these.
fn of_nodes(nodes: &str) -> Shot {
    let base = "<input name=\"base_color\" type=\"color3\" nodegraph=\"G\" output=\"out\"/>";
    let graph = format!(
        "<nodegraph name=\"G\">\n{nodes}\n<output name=\"out\" type=\"color3\" nodename=\"n\"/>\n</nodegraph>"
    );
    shot(&file(&open_pbr(base), &graph))
}

#[test]
fn parameters_are_those_of_the_shader() {
    let inputs = "<input name=\"base_color\" type=\"color3\" value=\"0.1, 0.2, 0.3\"/>\
                  <input name=\"base_metalness\" type=\"float\" value=\"0.5\"/>\
                  <input name=\"specular_roughness\" type=\"float\" value=\"0.25\"/>\
                  <input name=\"emission_color\" type=\"color3\" value=\"1, 0.5, 0\"/>\
                  <input name=\"emission_luminance\" type=\"float\" value=\"2\"/>";
    let shot = shot(&file(&open_pbr(inputs), ""));
    let (oak, base) = (oak(&shot), Vec3::new(0.1, 0.2, 0.3));
    let layer = oak.metal_rough.unwrap();
    assert_eq!((layer.roughness, layer.metallic, layer.base), (0.25, 0.5, base));
    assert!((layer.head_on - 0.04).abs() < 1e-5, "of an index of 1.5");
    assert_eq!((oak.diffuse, oak.emission), (base * 0.5, Vec3::new(2.0, 1.0, 0.0)));
    assert!(warnings(&shot).is_empty(), "{:?}", warnings(&shot));
}

#[test]
fn shaders_of_other_kinds_have_names_and_defaults_of_their_own() {
    let read = |category: &str, inputs: &str| {
        let shader = format!("<{category} name=\"S\" type=\"surfaceshader\">{inputs}</{category}>");
        oak(&shot(&file(&shader, ""))).clone()
    };
    let standard = read("standard_surface", "<input name=\"base\" type=\"float\" value=\"0.5\"/>");
    assert!((standard.diffuse - 0.4).abs().max_element() < 1e-6);
    assert_eq!(standard.metal_rough.unwrap().roughness, 0.2);
    let gltf = read("gltf_pbr", "<input name=\"metallic\" type=\"float\" value=\"0\"/>");
    assert_eq!((gltf.diffuse, gltf.metal_rough.unwrap().roughness), (Vec3::ONE, 1.0));
    let preview =
        read("UsdPreviewSurface", "<input name=\"emissiveColor\" type=\"color3\" value=\"1, 2, 3\"/>");
    assert_eq!(preview.emission, Vec3::new(1.0, 2.0, 3.0));
    let glass = read(
        "standard_surface",
        "<input name=\"transmission\" type=\"float\" value=\"1\"/><input name=\"base\" type=\"float\" value=\"0\"/>\
         <input name=\"specular_roughness\" type=\"float\" value=\"0\"/><input name=\"transmission_color\" type=\"color3\" value=\"1, 0.5, 0.25\"/>",
    );
    let Optics::Glass { transmission, index, .. } = glass.optics else { panic!("{:?}", glass.optics) };
    assert_eq!((transmission, index, glass.diffuse), (Vec3::new(1.0, 0.5, 0.25), 1.5, Vec3::ZERO));
    let matt = read("standard_surface", "<input name=\"specular\" type=\"float\" value=\"0\"/>");
    assert!(matt.metal_rough.is_none(), "what reflects nothing has no layer");
}

#[test]
fn a_graph_is_computed_at_each_place() {
    let shot = of_nodes(
        "<position name=\"p\" type=\"vector3\"/>\n<multiply name=\"n\" type=\"vector3\">\
         <input name=\"in1\" type=\"vector3\" nodename=\"p\"/><input name=\"in2\" type=\"float\" value=\"0.2\"/></multiply>",
    );
    // corners of the first triangle: (0, 0), (4, 0), (4, 4)
    assert!(reflectance(&shot, [0.5, 0.0]).abs_diff_eq(Vec3::new(0.4, 0.0, 0.0), 1e-6));
    assert!(reflectance(&shot, [0.25, 0.5]).abs_diff_eq(Vec3::new(0.6, 0.4, 0.0), 1e-6));
    assert_eq!(reflectance(&shot, [0.0, 1.0]).truncate().max_element(), 0.8, "it stays within 0 and 1");
}

/// What the standard library's arithmetic makes of constants, which are folded.
#[test]
fn nodes_of_the_standard_library_are_known() {
    let of = |category: &str, inputs: &[(&str, &str)]| {
        let inputs: String = inputs
            .iter()
            .map(|(name, value)| format!("<input name=\"{name}\" type=\"color3\" value=\"{value}\"/>"))
            .collect();
        let shot = of_nodes(&format!("<{category} name=\"n\" type=\"color3\">{inputs}</{category}>"));
        assert!(oak(&shot).computed.is_none(), "{category} is a constant");
        oak(&shot).metal_rough.unwrap().base.to_array()
    };
    for (category, inputs, expected) in [
        ("add", &[("in1", "0.1, 0.2, 0.3"), ("in2", "0.1, 0.1, 0.1")][..], [0.2, 0.3, 0.4]),
        ("subtract", &[("in1", "0.5, 0.5, 0.5"), ("in2", "0.1, 0.2, 0.3")], [0.4, 0.3, 0.2]),
        ("divide", &[("in1", "0.5, 0.5, 0.5"), ("in2", "2, 0, 1")], [0.25, 0.0, 0.5]),
        ("invert", &[("in", "0.25, 0.5, 1")], [0.75, 0.5, 0.0]),
        ("mix", &[("fg", "1, 1, 1"), ("bg", "0, 0, 0"), ("mix", "0.25")], [0.25; 3]),
        ("clamp", &[("in", "-1, 0.5, 2"), ("high", "0.75")], [0.0, 0.5, 0.75]),
        ("remap", &[("in", "3, 3, 3"), ("inlow", "2"), ("inhigh", "4")], [0.5; 3]),
        ("smoothstep", &[("in", "0.5, 0, 1")], [0.5, 0.0, 1.0]),
        ("power", &[("in1", "0.5, 0.5, 0.5"), ("in2", "2")], [0.25; 3]),
        ("extract", &[("in", "0.1, 0.2, 0.3"), ("index", "2")], [0.3; 3]),
        ("combine3", &[("in1", "0.1"), ("in2", "0.2"), ("in3", "0.3")], [0.1, 0.2, 0.3]),
        ("screen", &[("fg", "0.5, 0.5, 0.5"), ("bg", "0.5, 0.5, 0.5")], [0.75; 3]),
        ("difference", &[("fg", "0.5, 0.5, 0.5"), ("bg", "0.75, 0.5, 0.25")], [0.25, 0.0, 0.25]),
        ("ifgreater", &[("value1", "2"), ("value2", "1"), ("in1", "0.5"), ("in2", "1")], [0.5; 3]),
        ("luminance", &[("in", "0, 1, 0")], [0.674_081_8; 3]),
        ("luminance", &[("in", "0, 1, 0"), ("lumacoeffs", "0, 0.5, 0")], [0.5; 3]),
        ("hsvtorgb", &[("in", "0.333333333, 1, 1")], [0.0, 1.0, 0.0]),
        ("hsvtorgb", &[("in", "1.333333333, 1, 1")], [0.0, 1.0, 0.0]),
        ("multiply", &[("in2", "0.5")], [0.0; 3]),
        ("switch", &[("which", "1"), ("in1", "0.1"), ("in2", "0.2")], [0.2; 3]),
        (
            "range",
            &[("in", "0.25, 2, 0.5"), ("gamma", "2"), ("doclamp", "1")],
            [0.5, 1.0, std::f32::consts::FRAC_1_SQRT_2],
        ),
        ("hsvadjust", &[("in", "1, 0, 0"), ("amount", "0.333333333, 1, 0.5")], [0.0, 0.5, 0.0]),
        ("inside", &[("in", "0.4, 0.2, 0"), ("mask", "0.5")], [0.2, 0.1, 0.0]),
        ("outside", &[("in", "0.4, 0.2, 0"), ("mask", "0.75")], [0.1, 0.05, 0.0]),
        ("safepower", &[("in1", "0.5, -0.5, 1"), ("in2", "2")], [0.25, 0.0, 1.0]),
        ("distance", &[("in1", "0.5, 0, 0"), ("in2", "0.25, 0, 0")], [0.25; 3]),
        ("modulo", &[("in1", "0.75, 1.25, -0.25"), ("in2", "0.5")], [0.25; 3]),
    ] {
        let found = of(category, inputs);
        assert!(Vec3::from(found).abs_diff_eq(Vec3::from(expected), 1e-5), "{category}: {found:?}");
    }
}

#[test]
fn what_is_not_known_is_told_by_name_once_and_its_default_counts() {
    let shot = of_nodes(
        "<curious name=\"a\" type=\"color3\"/><curious name=\"b\" type=\"color3\"/>\n<mix name=\"n\" type=\"color3\">\
         <input name=\"fg\" type=\"color3\" nodename=\"a\"/><input name=\"bg\" type=\"color3\" nodename=\"b\"/>\
         <input name=\"mix\" type=\"float\" value=\"0.5\"/></mix>",
    );
    let told = warnings(&shot);
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(told[0].contains("m.mtlx:4: material `Oak`: nodes `curious` are not known"), "{told:?}");
    let shot = of_nodes("<curious name=\"n\" type=\"color3\"/>");
    assert_eq!(oak(&shot).metal_rough.unwrap().base, Vec3::splat(0.8), "that of the parameter");
    let layers = "<input name=\"subsurface_weight\" type=\"float\" value=\"0.5\"/>\
                  <input name=\"subsurface_scatter_anisotropy\" type=\"float\" value=\"0.5\"/>\
                  <input name=\"coat_color\" type=\"color3\" value=\"1, 0, 0\"/><input name=\"coat_roughness_anisotropy\" type=\"float\" value=\"1\"/>\
                  <input name=\"thin_film_ior\" type=\"float\" value=\"2\"/>";
    let told = warnings(&self::shot(&file(&open_pbr(layers), ""))).join("\n");
    assert!(told.contains("`subsurface_scatter_anisotropy`"), "{told}");
    assert!(!told.contains("coat"), "there is none: {told}");
    assert!(!told.contains("thin_film"), "there is none: {told}");
}

#[test]
fn vectors_of_two_have_no_third_channel() {
    let shot = of_nodes(
        "<subtract name=\"d\" type=\"vector2\"><input name=\"in1\" type=\"vector2\" value=\"0.8, 0.9\"/>\
         <input name=\"in2\" type=\"float\" value=\"0.5\"/></subtract>\n\
         <magnitude name=\"n\" type=\"float\"><input name=\"in\" type=\"vector2\" nodename=\"d\"/></magnitude>",
    );
    assert!(oak(&shot).metal_rough.unwrap().base.abs_diff_eq(Vec3::splat(0.5), 1e-6));
}

#[test]
fn colours_are_in_the_space_that_is_stated() {
    let of = |space: &str| {
        let base = format!(
            "<input name=\"base_color\" type=\"color3\" value=\"0.5, 0, 1\" colorspace=\"{space}\"/>"
        );
        shot(&file(&open_pbr(&base), ""))
    };
    let encoded = oak(&of("srgb_texture")).metal_rough.unwrap().base;
    assert!(encoded.abs_diff_eq(Vec3::new(0.214_041, 0.0, 1.0), 1e-5), "{encoded}");
    let odd = of("acescg");
    assert_eq!(oak(&odd).metal_rough.unwrap().base, Vec3::new(0.5, 0.0, 1.0));
    assert!(warnings(&odd)[0].contains("`acescg`"), "{:?}", warnings(&odd));
}

#[test]
fn inputs_that_nothing_reads_are_told() {
    let told = warnings(&of_nodes(
        "<add name=\"n\" type=\"color3\"><input name=\"in3\" type=\"color3\" value=\"0, 0, 0\"/></add>",
    ));
    assert!(told[0].contains("`in3` of nodes `add` is not used"), "{told:?}");
    let of = |category: &str, inputs: &str| {
        let shader = format!("<{category} name=\"S\" type=\"surfaceshader\">{inputs}</{category}>");
        warnings(&shot(&file(&shader, ""))).join("\n")
    };
    let film = |value: &str| format!("<input name=\"iridescence\" type=\"float\" value=\"{value}\"/>");
    assert!(of("gltf_pbr", &film("0.5")).contains("`iridescence`"));
    assert_eq!(of("gltf_pbr", &film("0")), "");
}

/// Layers and insides of surfaces by the names of OpenPBR: a velvet leaf, glass that absorbs, and a pane.
#[test]
fn fuzz_and_insides_are_read() {
    let number =
        |name: &str, value: &str| format!("<input name=\"{name}\" type=\"float\" value=\"{value}\"/>");
    let color =
        |name: &str, value: &str| format!("<input name=\"{name}\" type=\"color3\" value=\"{value}\"/>");
    let thin = "<input name=\"geometry_thin_walled\" type=\"boolean\" value=\"true\"/>";
    let of = |inputs: String| {
        let shot = shot(&file(
            &format!("<open_pbr_surface name=\"S\" type=\"surfaceshader\">{inputs}</open_pbr_surface>"),
            "",
        ));
        assert_eq!(warnings(&shot), Vec::<String>::new());
        oak(&shot).clone()
    };
    let leaf = of(number("fuzz_weight", "0.5")
        + &color("fuzz_color", "1, 0.5, 0")
        + &number("subsurface_weight", "0.5")
        + thin);
    let fuzz = leaf.fuzz.unwrap();
    assert_eq!((fuzz.weight, fuzz.color, fuzz.roughness), (0.5, Vec3::new(1.0, 0.5, 0.0), 0.5));
    let scattering = leaf.scattering.unwrap();
    assert_eq!((scattering.below, scattering.through), (Vec3::ZERO, 0.25), "a half of it goes through");
    let glass = number("transmission_weight", "1") + &color("transmission_color", "1, 0.25, 0.5");
    let deep = of(glass.clone() + &number("transmission_depth", "2"));
    let left = (-deep.absorption * 2.0).exp();
    assert!(left.abs_diff_eq(Vec3::new(1.0, 0.25, 0.5), 1e-6), "{left}");
    let Optics::Glass { transmission, is_thin, .. } = deep.optics else { panic!("{:?}", deep.optics) };
    assert_eq!((transmission, is_thin), (Vec3::ONE, false), "its surface has no colour");
    let pane = of(glass + thin);
    let Optics::Glass { transmission, is_thin, .. } = pane.optics else { panic!("{:?}", pane.optics) };
    assert_eq!((transmission, is_thin, pane.absorption), (Vec3::new(1.0, 0.25, 0.5), true, Vec3::ZERO));
}

#[test]
fn options_that_nothing_asks_for_are_told() {
    let of = |input: &str| {
        warnings(&of_nodes(&format!("<blender_math name=\"n\" type=\"float\">{input}</blender_math>")))
    };
    let told = of("<input name=\"operatoin\" type=\"string\" value=\"multiply\"/>");
    assert!(told[0].contains("`operatoin` of nodes `blender_math` is not used"), "{told:?}");
    let told = of("<input name=\"d\" type=\"float\" nodename=\"m\"/>");
    assert!(told.iter().any(|told| told.contains("`d` of nodes `blender_math` is not used")), "{told:?}");
    assert!(of("<input name=\"operation\" type=\"string\" value=\"multiply\"/>").is_empty());
}

#[test]
fn letters_put_channels_in_another_order() {
    let of = |letters: &str| {
        of_nodes(&format!(
            "<swizzle name=\"n\" type=\"color3\"><input name=\"in\" type=\"color4\" value=\"0.1, 0.2, 0.3, 0.4\"/>\
             <input name=\"channels\" type=\"string\" value=\"{letters}\"/></swizzle>"
        ))
    };
    for (letters, expected) in [("zx1", [0.3, 0.1, 1.0]), ("a", [0.4; 3]), ("gr0", [0.2, 0.1, 0.0])] {
        assert_eq!(oak(&of(letters)).metal_rough.unwrap().base.to_array(), expected, "{letters}");
    }
    let told = warnings(&of("xq"));
    assert!(told[0].contains("`channels` of nodes `swizzle` is `xq`"), "{told:?}");
}

/// OpenPBR's coats have an index of 1.6 and darken what is below, those of other shaders 1.5, and do not.
#[test]
fn coats_are_those_of_their_shaders() {
    let coat = |shader: &str, inputs: &str| {
        let shader = format!("<{shader} name=\"S\" type=\"surfaceshader\">{inputs}</{shader}>");
        let shot = shot(&file(&shader, ""));
        let oak = oak(&shot);
        assert!((oak.metal_rough.unwrap().head_on - 0.04).abs() < 1e-4);
        oak.coat.unwrap()
    };
    let number =
        |name: &str, value: f64| format!("<input name=\"{name}\" type=\"float\" value=\"{value}\"/>");
    let own = coat("open_pbr_surface", &number("coat_weight", 0.5));
    assert_eq!((own.weight, own.roughness, own.index, own.darkening), (0.5, 0.0, 1.6, 1.0));
    let standard = coat("standard_surface", &number("coat", 1.0));
    assert_eq!((standard.roughness, standard.index, standard.darkening), (0.1, 1.5, 0.0));
    let color = "<input name=\"coat_color\" type=\"color3\" value=\"1, 0.5, 0.25\"/>";
    let stated =
        coat("standard_surface", &format!("{}{}{color}", number("coat", 1.0), number("coat_IOR", 2.0)));
    assert_eq!((stated.index, stated.tint), (2.0, Vec3::new(1.0, 0.5, 0.25)));
}

#[test]
fn nodes_that_depend_on_themselves_are_told() {
    let circle = "<add name=\"n\" type=\"color3\"><input name=\"in1\" type=\"color3\" nodename=\"m\"/></add>\
                  <add name=\"m\" type=\"color3\"><input name=\"in1\" type=\"color3\" nodename=\"n\"/><input name=\"in2\" type=\"color3\" value=\"0.25, 0, 0\"/></add>";
    let shot = of_nodes(circle);
    assert!(warnings(&shot)[0].contains("depends on itself"), "{:?}", warnings(&shot));
    assert_eq!(oak(&shot).metal_rough.unwrap().base, Vec3::new(0.25, 0.0, 0.0), "there it is 0");
    let outputs = "<dot name=\"n\" type=\"color3\"><input name=\"in\" type=\"color3\" nodename=\"n\"/></dot>";
    assert!(warnings(&of_nodes(outputs))[0].contains("in a circle"));
}

#[test]
fn graphs_may_be_deep() {
    let mut nodes = String::from("<position name=\"n0\" type=\"vector3\"/>");
    for number in 1..=10_000 {
        let name = if number == 10_000 { String::from("n") } else { format!("n{number}") };
        nodes += &format!(
            "<add name=\"{name}\" type=\"vector3\"><input name=\"in1\" type=\"vector3\" nodename=\"n{}\"/>\
             <input name=\"in2\" type=\"float\" value=\"0.0001\"/></add>\n",
            number - 1
        );
    }
    let found = reflectance(&of_nodes(&nodes), [0.0, 0.0]);
    assert!((found - 1.0).abs().max_element() < 1e-3, "{found}");
}

#[test]
fn outputs_may_have_the_names_of_nodes() {
    let graph = "<nodegraph name=\"G\"><constant name=\"out\" type=\"color3\"><input name=\"value\" type=\"color3\" value=\"0, 0.5, 0\"/></constant>\n\
                 <output name=\"out\" type=\"color3\" nodename=\"out\"/></nodegraph>";
    let base = "<input name=\"base_color\" type=\"color3\" nodegraph=\"G\"/>";
    let shot = shot(&file(&open_pbr(base), graph));
    assert_eq!(oak(&shot).metal_rough.unwrap().base, Vec3::new(0.0, 0.5, 0.0));
    assert!(warnings(&shot).is_empty(), "{:?}", warnings(&shot));
}

#[test]
fn graphs_take_values_from_outside() {
    let graph = "<nodegraph name=\"G\">\n<input name=\"tint\" type=\"color3\" value=\"0.5, 0.25, 0\"/>\n\
                 <add name=\"n\" type=\"color3\"><input name=\"in1\" type=\"color3\" interfacename=\"tint\"/></add>\n\
                 <output name=\"out\" type=\"color3\" nodename=\"n\"/></nodegraph>";
    let base = "<input name=\"base_color\" type=\"color3\" nodegraph=\"G\"/>";
    let shot = shot(&file(&open_pbr(base), graph));
    assert_eq!(oak(&shot).metal_rough.unwrap().base, Vec3::new(0.5, 0.25, 0.0));
}

#[test]
fn parameters_and_normals_may_be_graphs() {
    let inputs = "<input name=\"specular_roughness\" type=\"float\" nodename=\"n\" output=\"value\"/>\
                  <input name=\"base_metalness\" type=\"float\" nodename=\"n\" output=\"value\"/>\
                  <input name=\"geometry_normal\" type=\"vector3\" nodename=\"b\"/>";
    let nodes = "<blender_noise name=\"n\" type=\"multioutput\"><input name=\"vector\" type=\"vector3\" nodename=\"p\"/></blender_noise>\
                 <position name=\"p\" type=\"vector3\"/>\
                 <bump name=\"b\" type=\"vector3\"><input name=\"height\" type=\"float\" nodename=\"n\" output=\"value\"/><input name=\"scale\" type=\"float\" value=\"0.5\"/></bump>";
    let shot = shot(&file(&open_pbr(inputs), nodes));
    let oak = oak(&shot);
    let computed = [Computes::Color, Computes::Roughness, Computes::Metalness].map(|of| oak.is_computed(of));
    assert_eq!(computed, [false, true, true]);
    let layer = oak.metal_rough.unwrap();
    assert_eq!((layer.roughness, layer.metallic), (1.0, 1.0), "factors of what varies");
    assert_eq!(oak.bump.as_ref().unwrap().distance, 0.5);
    assert!(warnings(&shot).is_empty(), "{:?}", warnings(&shot));
    let of = |weights: [f32; 2]| OnMesh::on(&shot.scene.models[0], 0, weights).appearance(&shot.scene, oak).1;
    assert_ne!(of([0.13, 0.21]), of([0.47, 0.32]));
    let stated = read(&file(&open_pbr(inputs), nodes), "pr = 0.5", true).unwrap();
    let computed = [Computes::Roughness, Computes::Metalness].map(|of| self::oak(&stated).is_computed(of));
    assert_eq!(computed, [false, true], "a number replaces a graph");
}

#[test]
fn keys_of_the_shot_file_replace_values() {
    let base = "<input name=\"base_color\" type=\"color3\" value=\"0.5, 0.5, 0.5\"/>";
    let shot = read(&file(&open_pbr(base), ""), "kd = [0, 1, 0]\npr = 0.75", true).unwrap();
    let layer = oak(&shot).metal_rough.unwrap();
    assert_eq!((layer.base, layer.roughness), (Vec3::Y, 0.75));
}

#[test]
fn mistakes_are_told_with_their_places() {
    let told = |mtlx: &str| read(mtlx, "", false).unwrap_err().to_string();
    for (mtlx, words) in [
        (String::from("<materialx>\n<a x=1/></materialx>"), "m.mtlx:2: it is no XML"),
        (String::from("<scene/>"), "it is no MaterialX: it begins with <scene>"),
        (
            file(&open_pbr(""), "").replace("\"Oak\"", "\"Oaks\""),
            "it has no surfacematerial `Oak`: did you mean `Oaks`?",
        ),
        (file("", ""), "m.mtlx:5: the material `Oak` has no `surfaceshader`"),
        (file("<hair_bsdf name=\"S\" type=\"BSDF\"/>", ""), "m.mtlx:4: the shader of `Oak` is `hair_bsdf`"),
        (
            file(&open_pbr("<input name=\"base_color\" type=\"color3\" value=\"red\"/>"), ""),
            "m.mtlx:4: `base_color` has `red`, which is no number",
        ),
        (
            file(
                &open_pbr("<input name=\"base_color\" type=\"color3\" nodename=\"n\"/>"),
                "<blender_math name=\"n\" type=\"float\"><input name=\"operation\" type=\"string\" value=\"plus\"/></blender_math>",
            ),
            "m.mtlx:3: `n`: `operation` is `plus`, which is not known",
        ),
    ] {
        let error = told(&mtlx);
        assert!(error.contains(words), "{error}");
    }
    let folder = folder();
    fs::write(folder.path().join("square.obj"), SQUARE).unwrap();
    let text =
        format!("{CAMERA}[[model]]\nobj = \"square.obj\"\n[[material]]\nname = \"Oak\"\nmtlx = \"m.mtlx\"\n");
    let error = load_in(folder.path(), &text, false).unwrap_err().to_string();
    assert!(error.contains("s.toml:11:8: the MaterialX file `m.mtlx` cannot be found"), "{error}");
}

#[test]
fn pictures_are_those_of_the_file() {
    let folder = folder();
    let root = folder.path();
    fs::create_dir(root.join("looks")).unwrap();
    fs::write(root.join("square.obj"), SQUARE).unwrap();
    write_tga(&root.join("looks/two.tga"));
    let nodes = "<image name=\"p\" type=\"color3\"><input name=\"file\" type=\"filename\" value=\"two.tga\" colorspace=\"lin_rec709\"/></image>\
                 <multiply name=\"n\" type=\"color3\"><input name=\"in1\" type=\"color3\" nodename=\"p\"/><input name=\"in2\" type=\"float\" value=\"0.5\"/></multiply>";
    let base = "<input name=\"base_color\" type=\"color3\" nodename=\"n\"/>";
    fs::write(root.join("looks/m.mtlx"), file(&open_pbr(base), nodes)).unwrap();
    let text = format!(
        "{CAMERA}[[model]]\nobj = \"square.obj\"\n[[material]]\nname = \"Oak\"\nmtlx = \"looks/m.mtlx\"\n"
    );
    let shot = load_in(root, &text, true).unwrap();
    let place = OnMesh::on(&shot.scene.models[0], 0, [0.25, 0.0]);
    let left = place.reflectance(&shot.scene, oak(&shot));
    assert!(left.abs_diff_eq(Vec3::new(0.5 * 100.0 / 255.0, 0.0, 0.0), 1e-3), "as numbers: {left}");
}

/// A picture of two texels: dark red and white.
fn write_tga(path: &Path) {
    let mut bytes = vec![0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 1, 0, 24, 0];
    bytes.extend([0, 0, 100, 255, 255, 255]);
    fs::write(path, bytes).unwrap();
}

//! The MaterialX files that shots name, as `NUMBER.mtlx`: for each material a graph of its own, made of the number.
//!
//! Some of what the graphs hold makes no sense: divisions by 0, powers of negative numbers, nodes that depend on themselves, and kinds
//! that nobody knows.

use std::fmt::Write;

use crate::dice::Dice;
use crate::files::{MATERIALS, OF_CLOUD, TEXTURES};

/// Number of nodes of a graph, at most.
const MOST_NODES: i64 = 12;

/// Kinds of nodes: the category, its type, the types and names of its inputs, and options as texts. Those with outputs of their own have
/// type `multioutput`, and the first output counts.
type Kind = (
    &'static str,
    &'static str,
    &'static [(&'static str, &'static str)],
    &'static [(&'static str, &'static [&'static str])],
);

const KINDS: [Kind; 22] = [
    ("blender_uv", "vector3", &[], &[("set", &["0", "1"])]),
    ("blender_object_coordinates", "vector3", &[], &[]),
    ("blender_generated_coordinates", "vector3", &[], &[]),
    ("blender_object_normal", "vector3", &[], &[]),
    ("blender_vertex_color", "color3", &[], &[]),
    (
        "blender_noise",
        "multioutput",
        &[
            ("vector", "vector3"),
            ("w", "float"),
            ("scale", "float"),
            ("detail", "float"),
            ("roughness", "float"),
            ("distortion", "float"),
        ],
        &[
            ("dimensions", &["1d", "2d", "3d", "4d"]),
            (
                "kind",
                &["fbm", "multifractal", "hybrid_multifractal", "ridged_multifractal", "hetero_terrain"],
            ),
            ("normalize", &["true", "false"]),
        ],
    ),
    (
        "blender_voronoi",
        "multioutput",
        &[
            ("vector", "vector3"),
            ("scale", "float"),
            ("randomness", "float"),
            ("exponent", "float"),
            ("smoothness", "float"),
        ],
        &[
            ("dimensions", &["1d", "2d", "3d", "4d"]),
            ("feature", &["f1", "f2", "smooth_f1", "distance_to_edge", "n_sphere_radius"]),
            ("distance", &["euclidean", "manhattan", "chebychev", "minkowski"]),
        ],
    ),
    (
        "blender_wave",
        "multioutput",
        &[("vector", "vector3"), ("scale", "float"), ("distortion", "float")],
        &[("shape", &["bands_x", "rings_spherical"])],
    ),
    (
        "blender_magic",
        "multioutput",
        &[("vector", "vector3"), ("scale", "float")],
        &[("depth", &["0", "2", "9"])],
    ),
    ("blender_checker", "multioutput", &[("vector", "vector3"), ("scale", "float")], &[]),
    (
        "blender_brick",
        "multioutput",
        &[("vector", "vector3"), ("scale", "float"), ("brick_width", "float")],
        &[],
    ),
    (
        "blender_gradient",
        "multioutput",
        &[("vector", "vector3")],
        &[("kind", &["radial", "easing", "spherical"])],
    ),
    (
        "blender_white_noise",
        "multioutput",
        &[("vector", "vector3"), ("w", "float")],
        &[("dimensions", &["3d", "4d"])],
    ),
    (
        "blender_gabor",
        "multioutput",
        &[("vector", "vector3"), ("scale", "float")],
        &[("kind", &["flat", "solid"])],
    ),
    (
        "blender_math",
        "float",
        &[("a", "float"), ("b", "float"), ("c", "float")],
        &[(
            "operation",
            &["add", "divide", "power", "logarithm", "modulo", "wrap", "sqrt", "tangent", "exponent"],
        )],
    ),
    (
        "blender_vector_math",
        "multioutput",
        &[("a", "vector3"), ("b", "vector3"), ("c", "vector3")],
        &[("operation", &["divide", "normalize", "modulo", "project"])],
    ),
    (
        "blender_mix_color",
        "color3",
        &[("factor", "float"), ("a", "color3"), ("b", "color3")],
        &[("blend", &["mix", "burn", "dodge", "divide", "color"])],
    ),
    (
        "blender_mapping",
        "vector3",
        &[("vector", "vector3"), ("scale", "vector3"), ("rotation", "vector3")],
        &[("kind", &["point", "texture", "normal"])],
    ),
    (
        "blender_color_ramp",
        "multioutput",
        &[("factor", "float")],
        &[
            ("stops", &["0.3, 1, 0, 0, 1, 0.6, 0, 1, 1, 1", "0.5, 1, 1, 1, 1"]),
            ("interpolation", &["constant", "linear", "b_spline"]),
        ],
    ),
    ("fractal3d", "float", &[("position", "vector3"), ("octaves", "integer")], &[]),
    ("divide", "color3", &[("in1", "color3"), ("in2", "color3")], &[]),
    ("nobody_knows_this", "color3", &[("in", "color3")], &[]),
];

/// Kinds of nodes that depend on the angle at which a place is seen.
const OF_EYE: [Kind; 3] = [
    ("blender_fresnel", "float", &[("ior", "float")], &[]),
    ("blender_layer_weight", "multioutput", &[("blend", "float")], &[]),
    ("facingratio", "float", &[], &[("faceforward", &["true", "false"]), ("invert", &["true", "false"])]),
];

/// Numbers of files from which on nodes may depend on the eye: below them files are what they were before there were such nodes.
pub const FIRST_OF_EYE: u64 = 10_000;

/// Number of files without glass.
pub const FILES: u64 = 15_000;

/// Numbers of files from which on materials may be glass, of which graphs say where it is and in which colours.
pub const FIRST_OF_GLASS: u64 = FILES;

/// The file with this number.
pub fn file(number: u64) -> String {
    let mut text = String::from("<?xml version=\"1.0\"?>\n<materialx version=\"1.39\">\n");
    let mut dice = Dice::new(number ^ 0x6D74_6C78);
    // half of the nodes that are not first
    let of_eye = if number < FIRST_OF_EYE { 0 } else { KINDS.len() / OF_EYE.len() };
    let kinds: Vec<Kind> =
        KINDS.into_iter().chain(OF_EYE.into_iter().cycle().take(OF_EYE.len() * of_eye)).collect();
    for name in MATERIALS {
        material(&mut dice, (name, &kinds), number >= FIRST_OF_GLASS, &mut text);
    }
    text.push_str("</materialx>\n");
    text
}

fn material(dice: &mut Dice, (name, kinds): (&str, &[Kind]), may_be_glass: bool, text: &mut String) {
    let _ = writeln!(text, "<nodegraph name=\"G{name}\">");
    let count = dice.whole(2, MOST_NODES) as usize;
    for node in 0..count {
        // the first ones have something to begin with
        let (category, of_type, inputs, options) = *dice.pick(if node < 2 { &kinds[..5] } else { kinds });
        let _ = writeln!(text, "<{category} name=\"n{node}\" type=\"{of_type}\">");
        for (input, of_input) in inputs {
            if dice.one_in(3) {
                let value = *dice.pick(&[0.0, 0.5, 1.0, 3.0, -2.0, 20.0, 1e9]);
                let _ = writeln!(text, "<input name=\"{input}\" type=\"{of_input}\" value=\"{value}\"/>");
            } else {
                // rarely one behind it, which may depend on it
                let from = if dice.one_in(30) { dice.below(count) } else { dice.below(node.max(1)) };
                let _ = writeln!(text, "<input name=\"{input}\" type=\"{of_input}\" nodename=\"n{from}\"/>");
            }
        }
        for (option, choices) in options {
            let choice = dice.pick(choices);
            let _ = writeln!(text, "<input name=\"{option}\" type=\"string\" value=\"{choice}\"/>");
        }
        let _ = writeln!(text, "</{category}>");
    }
    let last = count - 1;
    let color = if dice.one_in(4) {
        let texture = dice.pick(&TEXTURES);
        let at = if dice.one_in(2) {
            format!("<input name=\"texcoord\" type=\"vector2\" nodename=\"n{last}\"/>")
        } else {
            String::new()
        };
        let _ = writeln!(
            text,
            "<image name=\"p\" type=\"color3\"><input name=\"file\" type=\"filename\" value=\"{texture}\"/>{at}</image>"
        );
        let _ = writeln!(
            text,
            "<multiply name=\"c\" type=\"color3\"><input name=\"in1\" type=\"color3\" nodename=\"p\"/><input name=\"in2\" type=\"color3\" nodename=\"n{last}\"/></multiply>"
        );
        String::from("c")
    } else {
        format!("n{last}")
    };
    let numbers = [
        ("specular_roughness", dice.between(0.0, 1.0)),
        ("base_metalness", *dice.pick(&[0.0, 0.0, 1.0, 0.5])),
        ("coat_weight", *dice.pick(&[0.0, 0.0, 1.0])),
        ("specular_weight", *dice.pick(&[0.0, 1.0, 1.0])),
    ];
    // of the first two a graph may give either, heights the normal, and others light and veils
    let computed: Vec<bool> = (0..3).map(|_| dice.one_in(3)).collect();
    let (glows, is_veil) = (dice.one_in(5), dice.one_in(5));
    let outputs = [
        ("roughness", "float"),
        ("metalness", "float"),
        ("heights", "float"),
        ("glow", "color3"),
        ("opacity", "float"),
    ];
    let _ = writeln!(text, "<output name=\"out\" type=\"color3\" nodename=\"{color}\"/>");
    for (name, of_type) in outputs {
        let node = dice.below(count);
        let _ = writeln!(text, "<output name=\"{name}\" type=\"{of_type}\" nodename=\"n{node}\"/>");
    }
    let _ = writeln!(text, "</nodegraph>");
    if computed[2] {
        let distance = *dice.pick(&[0.02, 0.2, -0.1]);
        let _ = writeln!(
            text,
            "<bump name=\"B{name}\" type=\"vector3\"><input name=\"height\" type=\"float\" nodegraph=\"G{name}\" output=\"heights\"/>\
             <input name=\"scale\" type=\"float\" value=\"{distance}\"/></bump>"
        );
    }
    let _ = writeln!(text, "<open_pbr_surface name=\"S{name}\" type=\"surfaceshader\">");
    let _ =
        writeln!(text, "<input name=\"base_color\" type=\"color3\" nodegraph=\"G{name}\" output=\"out\"/>");
    for (number, (input, value)) in numbers.into_iter().enumerate() {
        let stated = match computed.get(number).filter(|_| number < 2) {
            Some(true) => format!("nodegraph=\"G{name}\" output=\"{}\"", outputs[number].0),
            _ => format!("value=\"{value}\""),
        };
        let _ = writeln!(text, "<input name=\"{input}\" type=\"float\" {stated}/>");
    }
    if glows {
        let _ = writeln!(
            text,
            "<input name=\"emission_color\" type=\"color3\" nodegraph=\"G{name}\" output=\"glow\"/>\
             <input name=\"emission_luminance\" type=\"float\" value=\"0.5\"/>"
        );
    }
    if is_veil {
        let _ = writeln!(
            text,
            "<input name=\"geometry_opacity\" type=\"float\" nodegraph=\"G{name}\" output=\"opacity\"/>"
        );
    }
    if may_be_glass && dice.one_in(2) {
        let graph = format!("nodegraph=\"G{name}\" output=");
        let weight =
            if dice.one_in(2) { format!("{graph}\"opacity\"") } else { String::from("value=\"0.8\"") };
        let _ = writeln!(text, "<input name=\"transmission_weight\" type=\"float\" {weight}/>");
        if dice.one_in(2) {
            let _ = writeln!(text, "<input name=\"transmission_color\" type=\"color3\" {graph}\"out\"/>");
        }
    }
    if computed[2] {
        let _ = writeln!(text, "<input name=\"geometry_normal\" type=\"vector3\" nodename=\"B{name}\"/>");
    }
    let _ = writeln!(text, "</open_pbr_surface>");
    let _ = writeln!(
        text,
        "<surfacematerial name=\"{name}\" type=\"material\"><input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"S{name}\"/></surfacematerial>"
    );
}

/// What fills meshes of all materials, from place to place: noise in object space, with a hole in it; clouds glow where they are hot.
pub fn smoke() -> String {
    let mut text = String::from("<?xml version=\"1.0\"?>\n<materialx version=\"1.39\">\n");
    text += "<nodegraph name=\"g\">\n<blender_object_coordinates name=\"p\" type=\"vector3\"/>\n\
        <blender_noise name=\"n\" type=\"multioutput\"><input name=\"vector\" type=\"vector3\" nodename=\"p\"/>\
        <input name=\"scale\" type=\"float\" value=\"3\"/></blender_noise>\n\
        <subtract name=\"s\" type=\"float\"><input name=\"in1\" type=\"float\" nodename=\"n\"/>\
        <input name=\"in2\" type=\"float\" value=\"0.4\"/></subtract>\n\
        <multiply name=\"d\" type=\"float\"><input name=\"in1\" type=\"float\" nodename=\"s\"/>\
        <input name=\"in2\" type=\"float\" value=\"6\"/></multiply>\n\
        <blender_volume_grid name=\"h\" type=\"multioutput\"><input name=\"grid\" type=\"string\" value=\"heat\"/></blender_volume_grid>\n\
        <output name=\"density\" type=\"vector3\" nodename=\"d\"/>\n<output name=\"heat\" type=\"color3\" nodename=\"h\"/>\n</nodegraph>\n\
        <anisotropic_vdf name=\"v\" type=\"VDF\"><input name=\"scattering\" type=\"vector3\" nodegraph=\"g\" output=\"density\"/>\
        <input name=\"absorption\" type=\"vector3\" value=\"0.3, 0.1, 0\"/></anisotropic_vdf>\n\
        <uniform_edf name=\"e\" type=\"EDF\"><input name=\"color\" type=\"color3\" nodegraph=\"g\" output=\"heat\"/></uniform_edf>\n\
        <volume name=\"w\" type=\"volumeshader\"><input name=\"vdf\" type=\"VDF\" nodename=\"v\"/>\
        <input name=\"edf\" type=\"EDF\" nodename=\"e\"/></volume>\n";
    for name in MATERIALS.into_iter().chain([OF_CLOUD]) {
        let _ = writeln!(
            text,
            "<volumematerial name=\"{name}\" type=\"material\"><input name=\"volumeshader\" type=\"volumeshader\" nodename=\"w\"/></volumematerial>"
        );
    }
    text + "</materialx>\n"
}

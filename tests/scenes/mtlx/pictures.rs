//! Do pictures of MaterialX files lie where their nodes put them, and do fourth channels and noise have their own numbers?

use afterimage::scene::texture::Wrap;

use super::*;

/// Loads a file beside a picture of two texels, dark red and white: `two.tga`.
fn with_picture(shader: &str, others: &str) -> Shot {
    let folder = folder();
    fs::write(folder.path().join("square.obj"), SQUARE).unwrap();
    write_tga(&folder.path().join("two.tga"));
    fs::write(folder.path().join("m.mtlx"), file(shader, others)).unwrap();
    let text =
        format!("{CAMERA}[[model]]\nobj = \"square.obj\"\n[[material]]\nname = \"Oak\"\nmtlx = \"m.mtlx\"\n");
    load_in(folder.path(), &text, false).unwrap()
}

/// The base colour of a node `n` of the picture, as numbers, among these.
fn shown(nodes: &str) -> Shot {
    with_picture(&open_pbr("<input name=\"base_color\" type=\"color3\" nodename=\"n\"/>"), nodes)
}

/// A node `n` that shows the picture, with these inputs.
fn node(category: &str, inputs: &str) -> String {
    format!(
        "<{category} name=\"n\" type=\"color3\"><input name=\"file\" type=\"filename\" value=\"two.tga\" colorspace=\"lin_rec709\"/>\
         <input name=\"filtertype\" type=\"string\" value=\"closest\"/>{inputs}</{category}>"
    )
}

/// Green at these texture coordinates: 0 of the dark texel, 1 of the white one.
fn green(shot: &Shot, u: f32, v: f32) -> f32 {
    // of the triangle (0, 0), (1, 0), (1, 1)
    reflectance(shot, [u - v, v]).y
}

#[test]
fn a_picture_of_numbers_that_is_missing_is_its_default() {
    let image = |of_type: &str| {
        format!(
            "<image name=\"r\" type=\"{of_type}\"><input name=\"file\" type=\"filename\" value=\"nowhere.png\"/>\
             <input name=\"default\" type=\"{of_type}\" value=\"0.25\"/></image>"
        )
    };
    let rough = "<input name=\"specular_roughness\" type=\"float\" nodename=\"r\"/>";
    let numbers = shot(&file(&open_pbr(rough), &image("float")));
    assert_eq!((oak(&numbers).metal_rough.unwrap().roughness, numbers.scene.textures.len()), (0.25, 1));
    assert!(oak(&numbers).computed.is_none());
    assert!(warnings(&numbers)[0].contains("nowhere.png"), "{:?}", warnings(&numbers));
    let base = "<input name=\"base_color\" type=\"color3\" nodename=\"r\"/>";
    let colors = shot(&file(&open_pbr(base), &image("color3")));
    assert!(oak(&colors).computed.is_some(), "a checker is seen");
}

#[test]
fn pictures_are_nearest_texels_where_that_is_stated() {
    let shot = shown(&node("image", ""));
    assert_eq!([0.3, 0.45, 0.55, 0.9].map(|u| green(&shot, u, 0.1)), [0.0, 0.0, 1.0, 1.0]);
}

#[test]
fn pictures_of_gltf_are_scaled_turned_and_moved() {
    let of = |inputs: &str| shown(&node("gltf_image", inputs));
    let moved = of("<input name=\"offset\" type=\"vector2\" value=\"0.5, 0\"/>");
    assert_eq!([0.3, 0.7].map(|u| green(&moved, u, 0.1)), [1.0, 0.0]);
    let scaled = of("<input name=\"scale\" type=\"vector2\" value=\"2, 1\"/>");
    assert_eq!([0.2, 0.3, 0.6, 0.8].map(|u| green(&scaled, u, 0.1)), [0.0, 1.0, 0.0, 1.0]);
    // KHR_texture_transform: a quarter about the upper left corner; u of the picture is v of the surface, downwards
    let turned = of("<input name=\"rotate\" type=\"float\" value=\"90\"/>");
    assert_eq!([0.1, 0.4, 0.6, 0.9].map(|v| green(&turned, 0.95, v)), [1.0, 1.0, 0.0, 0.0]);
    assert!(warnings(&turned).is_empty(), "{:?}", warnings(&turned));
}

#[test]
fn the_order_of_turning_and_moving_is_that_of_the_node() {
    let of = |order: &str| {
        let placed = format!(
            "<place2d name=\"p\" type=\"vector2\"><input name=\"scale\" type=\"vector2\" value=\"0.5, 1\"/>\
             <input name=\"offset\" type=\"vector2\" value=\"0.25, 0\"/><input name=\"operationorder\" type=\"integer\" value=\"{order}\"/></place2d>"
        );
        let at = "<input name=\"texcoord\" type=\"vector2\" nodename=\"p\"/>";
        let shot = shown(&format!("{placed}{}", node("image", at)));
        // u of the picture is 2 u - 0.25, or 2 (u - 0.25)
        [0.2, 0.3, 0.45].map(|u| green(&shot, u, 0.1))
    };
    assert_eq!(of("0"), [0.0, 0.0, 1.0]);
    assert_eq!(of("1"), [1.0, 0.0, 0.0]);
}

/// What constants place is a picture like others, filtered over the place; what is computed is looked up there.
#[test]
fn texture_coordinates_are_computed_where_they_must_be() {
    let placed = |scale: &str| {
        let at = "<input name=\"texcoord\" type=\"vector2\" nodename=\"p\"/>";
        shown(&format!(
            "<geomcolor name=\"white\" type=\"color3\"/><place2d name=\"p\" type=\"vector2\">\
             <input name=\"scale\" type=\"vector2\" {scale}/></place2d>{}",
            node("image", at)
        ))
    };
    let (constant, computed) = (placed("value=\"2, 2\""), placed("nodename=\"white\""));
    let is_filtered = |shot: &Shot| oak(shot).computed.as_ref().unwrap().program.is_filtered();
    assert!(is_filtered(&constant) && !is_filtered(&computed));
    assert_eq!(constant.scene.textures[0].mapping.at(glam::Vec2::ONE), glam::Vec2::splat(0.5));
}

#[test]
fn tiles_may_be_scaled_by_a_node() {
    let tiled = |tiling: &str| {
        shown(&format!(
            "<multiply name=\"two\" type=\"vector2\"><input name=\"in1\" type=\"vector2\" nodename=\"one\"/>\
             <input name=\"in2\" type=\"float\" value=\"2\"/></multiply><geomcolor name=\"one\" type=\"color3\"/>{}",
            node("tiledimage", tiling)
        ))
    };
    let offset = "<input name=\"uvoffset\" type=\"vector2\" value=\"0.5, 0\"/>";
    for tiling in ["value=\"2, 2\"", "nodename=\"two\""] {
        let shot = tiled(&format!("<input name=\"uvtiling\" type=\"vector2\" {tiling}/>{offset}"));
        // u of the picture is 2 u - 0.5
        assert_eq!([0.2, 0.3, 0.45, 0.55].map(|u| green(&shot, u, 0.1)), [1.0, 0.0, 0.0, 1.0], "{tiling}");
    }
}

#[test]
fn hexagons_show_the_picture() {
    let as_it_is = ["rotation", "scale", "offset"]
        .map(|name| format!("<input name=\"{name}\" type=\"float\" value=\"0\"/>"));
    let of = |inputs: &str| shown(&node("hextiledimage", inputs));
    let plain = of(&as_it_is.concat());
    for (u, expected) in [(0.3, 0.0), (0.45, 0.0), (0.55, 1.0), (0.9, 1.0)] {
        assert!((green(&plain, u, 0.1) - expected).abs() < 1e-5, "{u}");
    }
    assert!(warnings(&plain).is_empty(), "{:?}", warnings(&plain));
    let random = of("");
    let places = (1..10).flat_map(|u| (0..u).map(move |v| (u as f32 / 10.0, v as f32 / 10.0)));
    let differ = places.filter(|(u, v)| (green(&random, *u, *v) - green(&plain, *u, *v)).abs() > 0.1);
    assert!(differ.count() > 5, "tiles are turned and moved");
}

#[test]
fn edges_are_as_the_node_says_in_each_direction() {
    let of = |modes: [&str; 2]| {
        let [across, up] = modes;
        shown(&node(
            "image",
            &format!(
                "<input name=\"uaddressmode\" type=\"string\" value=\"{across}\"/><input name=\"vaddressmode\" type=\"string\" value=\"{up}\"/>"
            ),
        ))
    };
    let shot = of(["mirror", "clamp"]);
    assert_eq!(shot.scene.textures[0].mapping.wrap, [Wrap::Mirror, Wrap::Clamp]);
    assert!(warnings(&shot).is_empty(), "{:?}", warnings(&shot));
    let shot = of(["periodic", "constant"]);
    assert_eq!(shot.scene.textures[0].mapping.wrap, [Wrap::Repeat, Wrap::Clamp]);
    assert!(warnings(&shot)[0].contains("`vaddressmode` is `constant`"), "{:?}", warnings(&shot));
}

#[test]
fn names_of_files_may_come_from_outside_of_a_graph() {
    let graph = "<nodegraph name=\"G\"><input name=\"map\" type=\"filename\" value=\"two.tga\"/>\
                 <image name=\"n\" type=\"color3\"><input name=\"file\" type=\"filename\" interfacename=\"map\"/></image>\
                 <output name=\"out\" type=\"color3\" nodename=\"n\"/></nodegraph>";
    let shot = with_picture(&open_pbr("<input name=\"base_color\" type=\"color3\" nodegraph=\"G\"/>"), graph);
    assert!(shot.scene.textures[0].path.ends_with("two.tga"));
}

#[test]
fn fourth_channels_are_those_of_constants_and_of_what_is_combined() {
    let of = |node: &str, category: &str| {
        let taken = format!(
            "<{category} name=\"n\" type=\"float\"><input name=\"in\" type=\"color4\" nodename=\"a\"/>\
             <input name=\"index\" type=\"integer\" value=\"3\"/></{category}>"
        );
        of_nodes(&format!("{node}{taken}"))
    };
    let constant = "<constant name=\"a\" type=\"color4\"><input name=\"value\" type=\"color4\" value=\"0.1, 0.2, 0.3, 0.4\"/></constant>";
    let combined =
        "<combine4 name=\"a\" type=\"color4\"><input name=\"in4\" type=\"float\" value=\"0.4\"/></combine4>";
    let of_two = "<combine2 name=\"a\" type=\"color4\"><input name=\"in1\" type=\"color3\" value=\"0.1, 0.2, 0.3\"/>\
                  <input name=\"in2\" type=\"float\" value=\"0.4\"/></combine2>";
    for node in [constant, combined, of_two] {
        let shot = of(node, "extract");
        assert_eq!(oak(&shot).metal_rough.unwrap().base, Vec3::splat(0.4), "{node}");
        assert!(warnings(&shot).is_empty(), "{:?}", warnings(&shot));
    }
    let shot = of("<mix name=\"a\" type=\"color4\"/>", "extract");
    assert_eq!(oak(&shot).metal_rough.unwrap().base, Vec3::ONE);
    assert!(
        warnings(&shot)[0].contains("the fourth channel of nodes `mix` is taken as 1"),
        "{:?}",
        warnings(&shot)
    );
}

#[test]
fn noise_of_colours_has_three_numbers() {
    for category in ["noise2d", "noise3d", "fractal2d", "fractal3d", "worleynoise2d", "worleynoise3d"] {
        let of = |of_type: &str| {
            let at = if category.ends_with("2d") { "texcoord" } else { "position" };
            let shot = of_nodes(&format!(
                "<position name=\"q\" type=\"vector3\"/><add name=\"p\" type=\"vector3\"><input name=\"in1\" type=\"vector3\" nodename=\"q\"/>\
                 <input name=\"in2\" type=\"float\" value=\"0.3\"/></add>\
                 <{category} name=\"m\" type=\"{of_type}\"><input name=\"{at}\" type=\"vector3\" nodename=\"p\"/></{category}>\
                 <add name=\"k\" type=\"color3\"><input name=\"in1\" type=\"color3\" nodename=\"m\"/><input name=\"in2\" type=\"float\" value=\"1.5\"/></add>\
                 <multiply name=\"n\" type=\"color3\"><input name=\"in1\" type=\"color3\" nodename=\"k\"/><input name=\"in2\" type=\"float\" value=\"0.25\"/></multiply>"
            ));
            assert!(warnings(&shot).is_empty(), "{:?}", warnings(&shot));
            reflectance(&shot, [0.13, 0.21])
        };
        let (number, color) = (of("float"), of("color3"));
        assert!(number.x == number.y && number.y == number.z, "{category}: {number}");
        assert!(color.x != color.y && color.y != color.z, "{category}: {color}");
    }
}

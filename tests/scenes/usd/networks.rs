//! Are networks of MaterialX's nodes what they would be in a MaterialX file?

use super::*;
use afterimage::scene::Material;
use afterimage::scene::on_mesh::OnMesh;
use afterimage::scene::texture::UvSet;

/// A mesh that is bound to the material `Oak`, with two sets of texture coordinates.
fn mesh() -> String {
    let set = |name: &str, x: f32| {
        format!(
            "texCoord2f[] primvars:{name} = [({x}, 0), ({x}, 0), ({x}, 0)] ( interpolation = \"vertex\" )\n"
        )
    };
    format!(
        "def Mesh \"M\" {{ {TRIANGLE} {}{}rel material:binding = </Oak>\n}}\n",
        set("st", 0.25),
        set("other", 0.75)
    )
}

/// A material whose surface is the shader `S`, with these prims and properties.
fn oak(prims: &str) -> String {
    format!(
        "def Material \"Oak\" {{\n token outputs:mtlx:surface.connect = </Oak/S.outputs:out>\n{prims}\n}}\n{}",
        mesh()
    )
}

/// A shader with these inputs.
fn shader(name: &str, id: &str, inputs: &str) -> String {
    format!("def Shader \"{name}\" {{\n uniform token info:id = \"{id}\"\n{inputs}\n}}\n")
}

/// An `open_pbr_surface` with these inputs.
fn surface(inputs: &str) -> String {
    shader("S", "ND_open_pbr_surface_surfaceshader", &format!("{inputs}\n token outputs:out"))
}

fn material(shot: &Shot) -> &Material {
    &shot.scene.materials[usize::from(model(shot, "m/M").mesh.material_of[0])]
}

fn told(shot: &Shot) -> Vec<String> {
    shot.warnings.iter().map(ToString::to_string).collect()
}

fn reflectance(shot: &Shot, weights: [f32; 2]) -> Vec3 {
    OnMesh::on(model(shot, "m/M"), 0, weights).reflectance(&shot.scene, material(shot))
}

#[test]
fn values_come_through_graphs_and_interfaces() {
    let graph = "def NodeGraph \"G\" {\n color3f inputs:tint.connect = </Oak.inputs:tint>\n color3f outputs:color.connect = </Oak/G/N.outputs:out>\n";
    let add = "color3f inputs:in1.connect = </Oak/G.inputs:tint>\n color3f inputs:in2 = (0.25, 0, 0)\n color3f outputs:out";
    let prims = format!(
        "color3f inputs:tint = (0.25, 0.5, 0)\n float inputs:rough = 0.75\n{}{graph}{}}}\n",
        surface(
            "color3f inputs:base_color.connect = </Oak/G.outputs:color>\n float inputs:specular_roughness.connect = </Oak.inputs:rough>\n\
             float inputs:base_metalness = 0.5"
        ),
        shader("N", "ND_add_color3", add)
    );
    let shot = shown(METRES, &oak(&prims));
    let layer = material(&shot).metal_rough.unwrap();
    assert_eq!((layer.base, layer.roughness, layer.metallic), (Vec3::new(0.5, 0.5, 0.0), 0.75, 0.5));
    assert_eq!(material(&shot).name, "Oak");
}

#[test]
fn graphs_are_computed_at_each_place() {
    let prims = format!(
        "{}{}{}",
        surface("color3f inputs:base_color.connect = </Oak/C.outputs:out>"),
        shader(
            "C",
            "ND_convert_vector3_color3",
            "float3 inputs:in.connect = </Oak/P.outputs:out>\n color3f outputs:out"
        ),
        shader("P", "ND_position_vector3", "string inputs:space = \"object\"\n float3 outputs:out")
    );
    let shot = shown(METRES, &oak(&prims));
    assert!(reflectance(&shot, [0.5, 0.25]).abs_diff_eq(Vec3::new(0.5, 0.25, 0.0), 1e-6));
}

#[test]
fn a_network_counts_before_a_preview_surface_if_it_is_known() {
    let both = |id: &str| {
        let prims = format!(
            "token outputs:surface.connect = </Oak/V.outputs:surface>\n{}{}",
            shader("S", id, "color3f inputs:base_color = (1, 0, 0)\n token outputs:out"),
            shader(
                "V",
                "UsdPreviewSurface",
                "color3f inputs:diffuseColor = (0, 1, 0)\n token outputs:surface"
            )
        );
        let shot = load(METRES, &oak(&prims)).unwrap();
        (material(&shot).metal_rough.unwrap().base, told(&shot))
    };
    assert_eq!(both("ND_standard_surface_surfaceshader"), (Vec3::X, Vec::new()));
    let (base, told) = both("ND_lama_surface");
    assert_eq!(base, Vec3::Y);
    assert!(told[0].contains("surfaces `ND_lama_surface` are not used"), "{told:?}");
}

/// Each set of texture coordinates by its name; the colours of a picture are sRGB's, unless they are said to be others.
#[test]
fn pictures_are_those_that_assets_name() {
    let image = |name: &str, id: &str, inputs: &str, space: &str| {
        let file = format!("asset inputs:file = @./two.png@{space}\n{inputs}");
        shader(name, id, &file)
    };
    let prims = format!(
        "{}{}{}{}",
        surface(
            "color3f inputs:base_color.connect = </Oak/I.outputs:out>\n float inputs:specular_roughness.connect = </Oak/R.outputs:out>"
        ),
        image("I", "ND_image_color3", "color3f outputs:out", ""),
        image(
            "R",
            "ND_image_float",
            "float2 inputs:texcoord.connect = </Oak/U.outputs:out>\n float outputs:out",
            ""
        ),
        shader("U", "ND_geompropvalue_vector2", "string inputs:geomprop = \"other\"\n float2 outputs:out")
    );
    let write = |prims: &str| {
        let folder = folder(METRES, prims);
        let picture =
            image::RgbImage::from_fn(2, 1, |x, _| image::Rgb(if x == 0 { [188, 0, 0] } else { [51, 0, 0] }));
        picture.save(folder.path().join("two.png")).unwrap();
        scene::load(&folder.path().join("m.usda"), true).unwrap()
    };
    let shot = write(&oak(&prims));
    assert!((reflectance(&shot, [0.2, 0.2]).x - 0.5029).abs() < 1e-3, "{}", reflectance(&shot, [0.2, 0.2]));
    let sets: Vec<UvSet> = shot.scene.textures.iter().map(|texture| texture.mapping.uvs).collect();
    assert!(sets.contains(&UvSet::First) && sets.contains(&UvSet::Second), "{sets:?}");
    let raw = prims.replacen("@./two.png@", "@./two.png@ ( colorSpace = \"raw\" )", 1);
    let raw = write(&oak(&raw));
    assert!((reflectance(&raw, [0.2, 0.2]).x - 188.0 / 255.0).abs() < 1e-3);
}

#[test]
fn what_is_not_known_is_told_by_name() {
    let prims = format!(
        "{}{}",
        surface(
            "color3f inputs:base_color.connect = </Oak/N.outputs:out>\n float inputs:thin_film_weight = 0.5"
        ),
        shader("N", "ND_curious_color3", "color3f outputs:out")
    );
    let shot = load(METRES, &oak(&prims)).unwrap();
    assert_eq!(material(&shot).metal_rough.unwrap().base, Vec3::splat(0.8), "the default counts");
    let told = told(&shot).join("\n");
    assert!(told.contains("material `Oak`: nodes `curious` are not known"), "{told}");
    assert!(told.contains("`thin_film_weight`"), "{told}");
}

#[test]
fn circles_of_connections_end() {
    let prims = format!(
        "{}{}def NodeGraph \"G\" {{ color3f outputs:o.connect = </Oak/G.outputs:o>\n}}\n",
        surface(
            "color3f inputs:base_color.connect = </Oak/N.outputs:out>\n color3f inputs:specular_color.connect = </Oak/G.outputs:o>"
        ),
        shader(
            "N",
            "ND_add_color3",
            "color3f inputs:in1.connect = </Oak/N.outputs:out>\n color3f inputs:in2 = (0.5, 0, 0)\n color3f outputs:out"
        )
    );
    let shot = load(METRES, &oak(&prims)).unwrap();
    assert_eq!(material(&shot).metal_rough.unwrap().base, Vec3::new(0.5, 0.0, 0.0));
    assert!(told(&shot).join("\n").contains("depends on itself"), "{:?}", told(&shot));
}

#[test]
fn a_table_of_the_shot_file_replaces_values() {
    let folder = folder(
        METRES,
        &oak(&surface("color3f inputs:base_color = (1, 0, 0)\n float inputs:specular_roughness = 0.5")),
    );
    let path = folder.path().join("s.toml");
    fs::write(
        &path,
        format!("{CAMERA}[[model]]\nusd = \"m.usda\"\n[[material]]\nname = \"Oak\"\nkd = [0, 0, 1]\n"),
    )
    .unwrap();
    let shot = scene::load(&path, true).unwrap();
    let layer = material(&shot).metal_rough.unwrap();
    assert_eq!((layer.base, layer.roughness), (Vec3::Z, 0.5));
}

/// A MaterialX file with the material `Oak thing`, whose colour is `value`.
fn mtlx(value: &str) -> String {
    format!(
        "<materialx version=\"1.39\"><standard_surface name=\"S\" type=\"surfaceshader\"><input name=\"base\" type=\"float\" value=\"1\"/>\
         <input name=\"base_color\" type=\"color3\" {value}/></standard_surface>\
         <image name=\"I\" type=\"color3\"><input name=\"file\" type=\"filename\" value=\"red.png\"/></image>\
         <surfacematerial name=\"Oak thing\" type=\"material\"><input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"S\"/></surfacematerial></materialx>"
    )
}

/// Loads a mesh of the material of a file in the folder `looks`.
fn referred(file: &str, is_strict: bool) -> Result<Shot, SceneError> {
    let prims = format!(
        "def Scope \"Looks\" ( references = @./looks/oak.mtlx@</MaterialX/Materials> ) {{}}\n\
         def Mesh \"M\" {{ {TRIANGLE} rel material:binding = </Looks/Oak_thing>\n}}\n"
    );
    let folder = folder(METRES, &prims);
    fs::create_dir(folder.path().join("looks")).unwrap();
    fs::write(folder.path().join("looks/oak.mtlx"), file).unwrap();
    image::RgbImage::from_pixel(1, 1, image::Rgb([255, 0, 0]))
        .save(folder.path().join("looks/red.png"))
        .unwrap();
    scene::load(&folder.path().join("m.usda"), is_strict)
}

#[test]
fn references_to_materialx_files_bring_their_materials() {
    let shot = referred(&mtlx("value=\"0.25, 0.5, 0\""), true).unwrap();
    assert_eq!(material(&shot).metal_rough.unwrap().base, Vec3::new(0.25, 0.5, 0.0));
    assert_eq!(material(&shot).name, "Oak_thing", "that of its prim");
    // pictures are beside that file
    let shot = referred(&mtlx("nodename=\"I\""), true).unwrap();
    assert_eq!(reflectance(&shot, [0.2, 0.2]), Vec3::X);
}

#[test]
fn materialx_files_that_make_no_sense_are_told() {
    let shot = referred("<materialx", false).unwrap();
    let messages = told(&shot).join("\n");
    assert!(messages.contains("oak.mtlx") && messages.contains("it is no XML"), "{messages}");
    let shot = referred(&mtlx("value=\"red\""), false).unwrap();
    let messages = told(&shot).join("\n");
    assert!(messages.contains("`base_color` has `red`, which is no number"), "{messages}");
    assert!(messages.contains("it is grey"), "{messages}");
    assert!(referred(&mtlx("value=\"red\""), true).is_err());
}

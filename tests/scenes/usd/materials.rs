//! Are UsdPreviewSurface materials what the file says, and bound to the right faces?

use super::*;
use afterimage::scene::on_mesh::OnMesh;
use afterimage::scene::texture::{UvSet, Wrap};

/// A material with these inputs.
fn material(name: &str, inputs: &str) -> String {
    format!(
        "def Material \"{name}\" {{\n token outputs:surface.connect = </{name}/S.outputs:surface>\n\
         def Shader \"S\" {{\n uniform token info:id = \"UsdPreviewSurface\"\n token outputs:surface\n{inputs} }}\n"
    )
}

#[test]
fn texture_coordinates_whose_indices_have_no_value_are_those_without() {
    for indices in ["int[] primvars:st:indices", "int[] primvars:st:indices = []"] {
        let prims = format!(
            "def Mesh \"M\" {{ {TRIANGLE} texCoord2f[] primvars:st = [(0, 0), (1, 0), (0.5, 1)] ( interpolation = \"vertex\" )\n {indices}\n}}\n"
        );
        let folder = folder(METRES, &prims);
        let shot = scene::load(&folder.path().join("m.usda"), true).unwrap();
        let uvs = &shot.scene.models[0].mesh.triangles().uvs;
        assert_eq!(uvs.iter().map(|uv| uv.x).collect::<Vec<_>>(), [0.0, 1.0, 0.5], "{indices}");
    }
}

#[test]
fn values_and_bindings_are_those_of_the_file() {
    let prims = format!(
        "{}}}\n{}}}\n\
         def Xform \"G\" {{\n rel material:binding = </Red>\n\
         def Mesh \"Inherits\" {{ {TRIANGLE} }}\n\
         def Mesh \"Own\" {{ {TRIANGLE} rel material:binding = </Gold>\n}}\n\
         def Mesh \"Parts\" {{ int[] faceVertexCounts = [3, 3]\n int[] faceVertexIndices = [0, 1, 2, 2, 1, 0]\n\
         point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 3, 0)]\n uniform token subdivisionScheme = \"none\"\n\
         def GeomSubset \"S\" {{ int[] indices = [1]\n uniform token familyName = \"materialBind\"\n\
         rel material:binding = </Gold>\n}} }} }}\n\
         def Mesh \"Colour\" {{ {TRIANGLE} color3f[] primvars:displayColor = [(0, 0.5, 1)]\n}}\n",
        material(
            "Red",
            "color3f inputs:diffuseColor = (1, 0, 0)\n float inputs:roughness = 0.25\n float inputs:ior = 2\n"
        ),
        material(
            "Gold",
            "color3f inputs:diffuseColor = (1, 0.5, 0)\n float inputs:metallic = 1\n color3f inputs:emissiveColor = (0, 0, 3)\n"
        ),
    );
    let shot = shown(METRES, &prims);
    let of = |name: &str, triangle: usize| {
        &shot.scene.materials[usize::from(model(&shot, name).mesh.material_of[triangle])]
    };
    let red = of("m/G/Inherits", 0);
    let layer = red.metal_rough.unwrap();
    assert_eq!((red.name.as_str(), layer.base, layer.roughness, layer.metallic), ("Red", Vec3::X, 0.25, 0.0));
    assert!((layer.head_on - 1.0 / 9.0).abs() < 1e-6);
    let gold = of("m/G/Own", 0);
    assert_eq!((gold.metal_rough.unwrap().metallic, gold.emission), (1.0, Vec3::Z * 3.0));
    let mut names = [of("m/G/Parts", 0).name.as_str(), of("m/G/Parts", 1).name.as_str()];
    names.sort_unstable();
    assert_eq!(names, ["Gold", "Red"]);
    assert_eq!(of("m/Colour", 0).metal_rough.unwrap().base, Vec3::new(0.0, 0.5, 1.0));
}

#[test]
fn pictures_colour_and_cut_surfaces() {
    let texture = "def Shader \"T\" {\n uniform token info:id = \"UsdUVTexture\"\n asset inputs:file = @./leaf.png@\n\
        token inputs:wrapS = \"clamp\"\n token inputs:wrapT = \"mirror\"\n float4 inputs:scale = (0.5, 1, 1, 1)\n\
        float2 inputs:st.connect = </Leaf/U.outputs:result>\n float3 outputs:rgb\n float outputs:a\n float outputs:g\n}\n\
        def Shader \"U\" {\n uniform token info:id = \"UsdTransform2d\"\n float2 inputs:in.connect = </Leaf/R.outputs:result>\n\
        float2 inputs:scale = (2, 1)\n float inputs:rotation = 90\n float2 inputs:translation = (0.25, 0)\n float2 outputs:result\n}\n\
        def Shader \"R\" {\n uniform token info:id = \"UsdPrimvarReader_float2\"\n string inputs:varname = \"map1\"\n float2 outputs:result\n}\n}\n";
    let inputs = "color3f inputs:diffuseColor.connect = </Leaf/T.outputs:rgb>\n float inputs:opacity.connect = </Leaf/T.outputs:a>\n\
        float inputs:opacityThreshold = 0.25\n float inputs:roughness.connect = </Leaf/T.outputs:g>\n";
    let prims = format!(
        "{}{texture}def Mesh \"M\" {{ {TRIANGLE} rel material:binding = </Leaf>\n\
         texCoord2f[] primvars:map1 = [(0, 0), (1, 0)] ( interpolation = \"vertex\" )\n int[] primvars:map1:indices = [0, 1, 1]\n}}\n",
        material("Leaf", inputs)
    );
    let folder = folder(METRES, &prims);
    let picture =
        image::RgbaImage::from_fn(2, 1, |x, _| image::Rgba([255, 51, 255, if x == 0 { 0 } else { 255 }]));
    picture.save(folder.path().join("leaf.png")).unwrap();
    let shot = scene::load(&folder.path().join("m.usda"), true).unwrap();
    let mesh = &shot.scene.models[0].mesh;
    assert_eq!(mesh.triangles().uvs.iter().map(|uv| uv.x).collect::<Vec<_>>(), [0.0, 1.0, 1.0]);
    let leaf = &shot.scene.materials[usize::from(mesh.material_of[0])];
    let layer = leaf.metal_rough.unwrap();
    assert_eq!((layer.base, leaf.cutout.unwrap().least), (Vec3::new(0.5, 1.0, 1.0), 0.25));
    // green of the picture is roughness at each place
    let there = OnMesh::on(&shot.scene.models[0], 0, [0.5, 0.25]).appearance(&shot.scene, leaf).1;
    assert_eq!((layer.roughness, there.roughness), (1.0, 51));
    let texture = &shot.scene.textures[leaf.diffuse_map.unwrap() as usize];
    let turned = texture.mapping.at(Vec2::new(1.0, 0.0));
    assert!(turned.abs_diff_eq(Vec2::new(0.25, 2.0), 1e-6), "{turned}");
    assert_eq!(texture.mapping.wrap, [Wrap::Clamp, Wrap::Mirror]);
    assert!(!shot.warnings.iter().any(|warning| warning.to_string().contains("the mean counts")));
    assert!(mesh.cut.is_some());
}

/// A coat is above plastic and metal, and leaves both as they are.
#[test]
fn coats_are_above_what_is_below() {
    let coated = |inputs: &str| {
        let inputs =
            format!("{inputs} float inputs:roughness = 0.75\n float inputs:clearcoatRoughness = 0.25\n");
        let mesh = format!("def Mesh \"M\" {{ {TRIANGLE} rel material:binding = </Coated>\n}}\n");
        let shot = load(METRES, &format!("{}}}\n{mesh}", material("Coated", &inputs))).unwrap();
        let told: Vec<String> = shot.warnings.iter().map(ToString::to_string).collect();
        assert!(!told.iter().any(|text| text.contains("coat")), "{told:?}");
        let made = &shot.scene.materials[usize::from(model(&shot, "m/M").mesh.material_of[0])];
        let layer = made.metal_rough.unwrap();
        assert!(layer.roughness == 0.75 && (layer.head_on - 0.04).abs() < 1e-5, "{layer:?}");
        made.coat.map(|coat| (coat.weight, coat.roughness, coat.index))
    };
    assert_eq!(coated("float inputs:clearcoat = 1\n"), Some((1.0, 0.25, 1.5)));
    assert_eq!(
        coated("float inputs:clearcoat = 0.25\n float inputs:metallic = 1\n"),
        Some((0.25, 0.25, 1.5))
    );
    assert_eq!(coated(""), None);
}

/// Each material has its own sets of texture coordinates, on one mesh: one for its colour, and another one.
#[test]
fn materials_name_their_texture_coordinates() {
    let reader = |material: &str, number: usize, varname: &str, output: &str| {
        format!(
            "def Shader \"T{number}\" {{\n uniform token info:id = \"UsdUVTexture\"\n asset inputs:file = @./leaf.png@\n\
             float2 inputs:st.connect = </{material}/R{number}.outputs:result>\n float3 outputs:{output}\n}}\n\
             def Shader \"R{number}\" {{\n uniform token info:id = \"UsdPrimvarReader_float2\"\n\
             string inputs:varname = \"{varname}\"\n float2 outputs:result\n}}\n"
        )
    };
    let one = format!(
        "{}{}}}\n",
        material("One", "color3f inputs:diffuseColor.connect = </One/T0.outputs:rgb>\n"),
        reader("One", 0, "first", "rgb")
    );
    let inputs = "color3f inputs:diffuseColor.connect = </Two/T0.outputs:rgb>\n\
                  float3 inputs:normal.connect = </Two/T1.outputs:rgb>\n\
                  color3f inputs:emissiveColor.connect = </Two/T2.outputs:rgb>\n";
    let two = format!(
        "{}{}{}{}}}\n",
        material("Two", inputs),
        reader("Two", 0, "second", "rgb"),
        reader("Two", 1, "first", "rgb"),
        reader("Two", 2, "third", "rgb")
    );
    let set = |name: &str, x: f32| {
        format!(
            "texCoord2f[] primvars:{name} = [({x}, 0), ({x}, 1), ({x}, 2)] ( interpolation = \"vertex\" )\n"
        )
    };
    let prims = format!(
        "{one}{two}def Mesh \"M\" {{ int[] faceVertexCounts = [3, 3]\n int[] faceVertexIndices = [0, 1, 2, 2, 1, 0]\n\
         point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 3, 0)]\n uniform token subdivisionScheme = \"none\"\n{}{}{}\
         rel material:binding = </One>\n def GeomSubset \"S\" {{ int[] indices = [1]\n\
         uniform token familyName = \"materialBind\"\n rel material:binding = </Two>\n}} }}\n",
        set("first", 0.25),
        set("second", 0.5),
        set("third", 0.75)
    );
    let folder = folder(METRES, &prims);
    image::RgbaImage::from_pixel(2, 2, image::Rgba([128, 128, 255, 255]))
        .save(folder.path().join("leaf.png"))
        .unwrap();
    let shot = scene::load(&folder.path().join("m.usda"), false).unwrap();
    let mesh = &shot.scene.models[0].mesh;
    for (triangle, name, sets) in [(0, "One", [0.25, 0.0]), (1, "Two", [0.5, 0.25])] {
        let material = &shot.scene.materials[usize::from(mesh.material_of[triangle])];
        assert_eq!(material.name, name);
        for corner in mesh.triangles().corners[triangle].map(|corner| corner as usize) {
            let all = [UvSet::First, UvSet::Second].map(|set| mesh.uvs_of(set)[corner].x);
            assert_eq!(all, sets, "{name}");
        }
    }
    let two = &shot.scene.materials[usize::from(mesh.material_of[1])];
    let set_of = |map: u32| shot.scene.textures[map as usize].mapping.uvs;
    assert_eq!(set_of(two.diffuse_map.unwrap()), UvSet::First);
    assert_eq!(set_of(two.normal_map.unwrap().map), UvSet::Second);
    let message = "a material takes two sets of texture coordinates";
    assert!(shot.warnings.iter().any(|warning| warning.to_string().contains(message)), "{:?}", shot.warnings);
}

#[test]
fn colours_without_a_material_may_change_over_a_mesh() {
    let prims = format!(
        "def Mesh \"A\" {{ {TRIANGLE} color3f[] primvars:displayColor = [(1, 0, 0), (0, 0.5, 0), (0, 0, 1)] ( interpolation = \"vertex\" )\n}}\n\
         def Mesh \"B\" {{ {TRIANGLE} color3f[] primvars:displayColor = [(0.25, 0, 0)] }}\n"
    );
    let shot = shown(METRES, &prims);
    let colors = &model(&shot, "m/A").mesh.details.colors;
    assert_eq!(
        colors.iter().map(|color| color.map(f32::from)).collect::<Vec<_>>(),
        [[1.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 1.0]]
    );
    assert!(model(&shot, "m/B").mesh.details.colors.is_empty());
    let of = |name: &str| &shot.scene.materials[usize::from(model(&shot, name).mesh.material_of[0])];
    assert!(of("m/A").has_vertex_colors && !of("m/B").has_vertex_colors);
}

#[test]
fn a_surface_may_take_the_colour_of_what_it_is_bound_to() {
    let reader = "def Shader \"R\" {\n uniform token info:id = \"UsdPrimvarReader_float3\"\n string inputs:varname = \"displayColor\"\n\
        float3 inputs:fallback = (0, 0.25, 0)\n vector3f outputs:result\n}\n";
    let taken = material(
        "Taken",
        "color3f inputs:diffuseColor.connect = </Taken/R.outputs:result>\n float inputs:roughness = 0.25\n",
    );
    let bound = "rel material:binding = </Taken>";
    let color = |color: &str| format!("color3f[] primvars:displayColor = {color}");
    let each = "[(1, 0, 0), (0, 0.5, 0), (0, 0, 1)] ( interpolation = \"vertex\" )";
    let prims = format!(
        "def Mesh \"Even\" {{ {TRIANGLE} {bound}\n {}\n}}\ndef Mesh \"Same\" {{ {TRIANGLE} {bound}\n {}\n}}\n\
         def Mesh \"Each\" {{ {TRIANGLE} {bound}\n {}\n}}\ndef Mesh \"None\" {{ {TRIANGLE} {bound}\n}}\n\
         def Xform \"Above\" {{ {}\n def Mesh \"Inherits\" {{ {TRIANGLE} {bound}\n}} }}\n\
         def Mesh \"Part\" {{ {TRIANGLE} {}\n def GeomSubset \"S\" {{ int[] indices = [0]\n uniform token familyName = \"materialBind\"\n {bound}\n}} }}\n\
         {taken}{reader}}}\n",
        color("[(1, 0, 0)]"),
        color("[(1, 0, 0)]"),
        color(each),
        color("[(0, 0, 0.5)] ( interpolation = \"constant\" )"),
        color(each),
    );
    let shot = shown(METRES, &prims);
    assert!(shot.warnings.is_empty(), "{:?}", shot.warnings);
    let number = |name: &str| model(&shot, name).mesh.material_of[0];
    let of = |name: &str| &shot.scene.materials[usize::from(number(name))];
    let base = |name: &str| of(name).metal_rough.unwrap().base;
    assert_eq!([base("m/Even"), base("m/None")], [Vec3::X, Vec3::Y * 0.25]);
    assert_eq!((base("m/Above/Inherits"), number("m/Even")), (Vec3::Z * 0.5, number("m/Same")));
    for name in ["m/Each", "m/Part"] {
        assert!(of(name).has_vertex_colors && base(name) == Vec3::ONE, "{name}");
        assert_eq!(model(&shot, name).mesh.details.colors.len(), 3, "{name}");
    }
    assert!(["m/Even", "m/None", "m/Above/Inherits"].iter().all(|name| !of(name).has_vertex_colors));
    assert!(
        ["m/Even", "m/Each", "m/None"].iter().all(|name| of(name).metal_rough.unwrap().roughness == 0.25)
    );
}

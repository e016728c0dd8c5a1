//! Is a file read as Pixar's own library reads it?

use afterimage::pose::Pose;

use super::*;

/// A square of two units around the origin, up to its last brace.
const SQUARE: &str = "int[] faceVertexCounts = [4]\nint[] faceVertexIndices = [0, 1, 2, 3]\n\
    point3f[] points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]\nuniform token subdivisionScheme = \"none\"\n\
    texCoord2f[] primvars:st = [(0, 0), (2, 0), (2, 1), (0, 1)] (interpolation = \"vertex\")\n";

fn told(shot: &Shot) -> String {
    shot.warnings.iter().map(|warning| format!("{warning}\n")).collect()
}

fn material<'a>(shot: &'a Shot, name: &str) -> &'a afterimage::scene::Material {
    &shot.scene.materials[usize::from(model(shot, name).mesh.material_of[0])]
}

fn base(shot: &Shot, name: &str) -> Vec3 {
    material(shot, name).metal_rough.unwrap().base
}

/// A material called `M` with these lines in its surface, and a texture that reads `st`.
fn textured(inputs: &str, texture: &str) -> String {
    format!(
        "def Material \"M\"\n{{\n token outputs:surface.connect = </M/S.outputs:surface>\n\
         def Shader \"S\"\n{{\n uniform token info:id = \"UsdPreviewSurface\"\n {inputs}\n token outputs:surface\n}}\n\
         def Shader \"T\"\n{{\n uniform token info:id = \"UsdUVTexture\"\n {texture}\n float2 inputs:st.connect = </M/R.outputs:result>\n\
         float3 outputs:rgb\n}}\n\
         def Shader \"R\"\n{{\n uniform token info:id = \"UsdPrimvarReader_float2\"\n string inputs:varname = \"st\"\n\
         float2 outputs:result\n}}\n}}\n\
         def Mesh \"Q\"\n{{\n {SQUARE} rel material:binding = </M>\n}}\n"
    )
}

#[test]
fn text_layers_may_have_all_spellings_of_the_format() {
    let text = "#usda 1.0 // of a program\n/* by\n hand */\n( \"a note\"; customData = { uint[] a = [1]; bool b = yes }\n metersPerUnit = 1.\n)\n\
        def Acme.Cube2 \"Odd\" (doc = '''it's \"odd\"'''; kind = \"group\", active = 1)\n{\n\
        asset x.timeSamples = { .5: @a.png@, 1: \"b.png\", 2: None }\n asset y = \"a\"; uint64[] z = [18446744073709551615]\n\
        pathExpression p = \"//*\"\n acme w = 5 // of no type that is known\n double s.spline = { bezier, 1: 5; post held, 2: 6 }\n\
        config custom varying rel r = </Odd>\n reorder properties = [\"y\", \"x\"]\n string t = \"a\\\"b\\\\\"\n double größe = 1\n}\n\
        def Cube \"C\" {\n double size = .5 # half\n color3f[] primvars:displayColor = [(.5, 0., 1),]\n int n = 1e3\n float i = -inf\n}\n";
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.usda"), text).unwrap();
    let shot = scene::load(&folder.path().join("m.usda"), true).unwrap();
    let positions = &model(&shot, "m/C").mesh.triangles().positions;
    let extent = positions.as_slice().iter().map(|point| point[0]).fold(0.0, f32::max);
    assert_eq!((extent, base(&shot, "m/C")), (0.25, Vec3::new(0.5, 0.0, 1.0)));
    assert!(told(&shot).contains("splines are not used"), "{}", told(&shot));
}

#[test]
fn what_is_wrong_in_a_text_layer_has_its_line() {
    let folder = folder(
        METRES,
        &format!("def Mesh \"M\" {{ {TRIANGLE} }}\ndef \"A\" (references = @./bad.usda@</B>) {{}}\n"),
    );
    fs::write(folder.path().join("bad.usda"), "#usda 1.0\n\ndef \"B\"\n{\n double x = = 5\n}\n").unwrap();
    let shot = scene::load(&folder.path().join("m.usda"), false).unwrap();
    assert!(
        told(&shot).contains("bad.usda`, which /A names, cannot be read (line 5: `=` is there"),
        "{}",
        told(&shot)
    );
    let error = scene::load(&folder.path().join("bad.usda"), false).err().unwrap();
    assert_eq!(error.line, Some(5));
    assert!(error.message.contains("where a value is expected"), "{error}");
    // what only the library refuses
    fs::write(folder.path().join("bad.usda"), "#usda 1.0\ndef \"B\"\n{\n float2 x = (1, 2, 3)\n}\n").unwrap();
    let error = scene::load(&folder.path().join("bad.usda"), false).err().unwrap();
    assert_eq!(error.line, Some(4), "{error}");
}

#[test]
fn a_strong_binding_goes_before_those_below() {
    let paint = |name: &str, color: &str| {
        format!(
            "def Material \"{name}\" {{ token outputs:surface.connect = </{name}/S.outputs:surface>\n\
             def Shader \"S\" {{ uniform token info:id = \"UsdPreviewSurface\"\n color3f inputs:diffuseColor = {color}\n\
             token outputs:surface\n}} }}\n"
        )
    };
    let prims = paint("Blue", "(0, 0, 1)")
        + &paint("Red", "(1, 0, 0)")
        + &format!(
            "def Xform \"G\" {{ rel material:binding = </Blue> (bindMaterialAs = \"strongerThanDescendants\")\n\
             def Mesh \"M\" {{ {TRIANGLE} rel material:binding = </Red>\n}} }}\n"
        );
    let shot = shown(METRES, &prims);
    assert_eq!(base(&shot, "m/G/M"), Vec3::Z);
}

#[test]
fn instances_within_instances_are_shown() {
    let prims = "def Xform \"W\" { def Xform \"Lib\" { def Cube \"c\" { double size = 0.5\n} }\n\
        def Xform \"Group\" { def Xform \"in\" (instanceable = true\n references = </W/Lib>) { double3 xformOp:translate = (0, 1, 0)\n\
        uniform token[] xformOpOrder = [\"xformOp:translate\"]\n} }\n\
        def Xform \"out\" (instanceable = true\n references = </W/Group>) { double3 xformOp:translate = (1, 0, 0)\n\
        uniform token[] xformOpOrder = [\"xformOp:translate\"]\n} }\n";
    let shot = shown(METRES, prims);
    assert_eq!(names(&shot), ["m/W/Lib/c", "m/W/Group/in/c", "m/W/out/in/c"]);
    let nested = model(&shot, "m/W/out/in/c");
    let count = nested.mesh.triangles().positions.as_slice().len();
    let sum: DVec3 = (0..count).map(|number| corner(nested, 1.0, number)).sum();
    assert_near(sum / count as f64, DVec3::new(1.0, 1.0, 0.0));
}

#[test]
fn times_of_a_sublayer_are_converted_once() {
    let sub = format!(
        "#usda 1.0\n(\n timeCodesPerSecond = 48\n)\ndef Xform \"W\" {{\n def Xform \"A\" {{\n\
         double3 xformOp:translate.timeSamples = {{ 0: (-1, 0, 0), 24: (1, 0, 0) }}\n uniform token[] xformOpOrder = [\"xformOp:translate\"]\n\
         def Mesh \"M\" {{ {TRIANGLE} }} }}\n def \"B\" (references = </W/A>) {{}}\n}}\n"
    );
    let folder = folder("timeCodesPerSecond = 24\nmetersPerUnit = 1\nsubLayers = [@./sub.usda@]\n", "");
    fs::write(folder.path().join("sub.usda"), sub).unwrap();
    let shot = scene::load(&folder.path().join("m.usda"), true).unwrap();
    for name in ["m/W/A/M", "m/W/B/M"] {
        assert_near(corner(model(&shot, name), 6.0, 0), DVec3::ZERO);
        assert_near(corner(model(&shot, name), 12.0, 0), DVec3::X);
    }
}

#[test]
fn colours_are_inherited_and_instances_have_their_own() {
    let color = |color: &str| format!("color3f[] primvars:displayColor = {color}\n");
    let prims = format!(
        "class \"P\" {{ def Mesh \"M\" {{ {TRIANGLE} }} }}\n\
         def Xform \"G\" {{ {} float[] primvars:displayOpacity = [0.25]\n def Xform \"H\" {{ def Mesh \"M\" {{ {TRIANGLE} }} }}\n\
         def Mesh \"Own\" {{ {TRIANGLE} {} }}\n def Mesh \"None\" {{ {TRIANGLE} {} float[] primvars:displayOpacity = [1]\n}} }}\n\
         def \"A\" (instanceable = true\n references = </P>) {{ {} }}\n def \"B\" (instanceable = true\n references = </P>) {{ {} }}\n",
        color("[(0, 0, 1)]"),
        color("[(1, 0, 0)] (interpolation = \"constant\")"),
        color("None"),
        color("[(0, 1, 0)]"),
        color("[(1, 1, 0)]"),
    );
    let shot = shown(METRES, &prims);
    assert_eq!((base(&shot, "m/G/H/M"), base(&shot, "m/G/Own")), (Vec3::Z, Vec3::X));
    assert_eq!((base(&shot, "m/A/M"), base(&shot, "m/B/M")), (Vec3::Y, Vec3::new(1.0, 1.0, 0.0)));
    assert!(material(&shot, "m/G/None").metal_rough.is_none(), "a blocked value is none");
    let solid = |name: &str| material(&shot, name).metal_rough.unwrap().solid;
    assert_eq!((solid("m/G/H/M"), solid("m/A/M")), (0.25, 1.0));
    let moving = format!(
        "def Mesh \"M\" {{ {TRIANGLE} color3f[] primvars:displayColor.timeSamples = {{ 1: [(1, 0, 0)], 2: [(0, 0, 1)] }}\n}}\n"
    );
    let shot = load(METRES, &moving).unwrap();
    assert!(told(&shot).contains("do not change with time"), "{}", told(&shot));
}

#[test]
fn lights_go_on_and_off_with_their_visibility() {
    let light = |visibility: &str| {
        format!(
            "def Mesh \"M\" {{ {TRIANGLE} }}\ndef SphereLight \"L\" {{ float inputs:intensity = 10\n float inputs:radius = 0.2\n\
             token visibility{visibility}\n}}\n"
        )
    };
    let shot =
        shown(METRES, &light(".timeSamples = { 1: \"invisible\", 3: \"inherited\", 5: \"invisible\" }"));
    let strength = |frame| Pose::new(&shot.scene, frame).lights.first().map_or(0.0, |light| light.strength.x);
    assert_eq!([1, 2, 5, 6].map(strength), [0.0; 4]);
    assert!(strength(3) > 0.0 && strength(3) == strength(4));
    // one that never shines is one all the same
    let shot = load(METRES, &light(" = \"invisible\"")).unwrap();
    assert!(shot.scene.lights.is_empty() && shot.scene.environment.is_none());
    let said = shot.notes.join("\n") + &told(&shot);
    assert!(said.contains("none of the file's lights shines"), "{said}");
}

#[test]
fn render_settings_name_the_camera_and_the_size() {
    let camera = |name: &str, aperture: f64| {
        format!(
            "def Camera \"{name}\" {{ token projection = \"orthographic\"\n float horizontalAperture = {aperture}\n\
             float verticalAperture = 10\n double3 xformOp:translate = (0, 0, 9)\n uniform token[] xformOpOrder = [\"xformOp:translate\"]\n}}\n"
        )
    };
    let settings = |name: &str, size: &str| {
        format!(
            "def RenderSettings \"{name}\" {{ rel camera = </Second>\n uniform int2 resolution = {size}\n}}\n"
        )
    };
    let prims = format!(
        "def Mesh \"M\" {{ {TRIANGLE} }}\n{}{}def Scope \"Render\" {{ {}{} }}\n",
        camera("First", 10.0),
        camera("Second", 20.0),
        settings("Other", "(50, 50)"),
        settings("Named", "(400, 400)")
    );
    let shot = shown(&format!("{METRES}renderSettingsPrimPath = \"/Render/Named\"\n"), &prims);
    assert_eq!((shot.settings.width, shot.settings.height), (400, 400));
    // the second camera sees 2 x 1 units; for a square picture the aperture grows upwards
    assert!((Pose::new(&shot.scene, 1).camera.half_height - 1.0).abs() < 1e-6);
    let shot = shown(METRES, &prims);
    assert_eq!(
        (shot.settings.width, shot.settings.height),
        (50, 50),
        "the first settings, if none are named"
    );
}

#[test]
fn scale_and_bias_turn_and_flatten_normals() {
    let with = |scale: &str, bias: &str| {
        let texture = format!(
            "asset inputs:file = @./n.png@\n float4 inputs:scale = {scale}\n float4 inputs:bias = {bias}\n token inputs:sourceColorSpace = \"raw\""
        );
        let folder =
            folder(METRES, &textured("normal3f inputs:normal.connect = </M/T.outputs:rgb>", &texture));
        image::RgbaImage::from_pixel(2, 2, image::Rgba([128, 204, 230, 255]))
            .save(folder.path().join("n.png"))
            .unwrap();
        scene::load(&folder.path().join("m.usda"), true).unwrap()
    };
    let of = |shot: &Shot| {
        let map = material(shot, "m/Q").normal_map.unwrap();
        let texel = shot.scene.textures[map.map as usize].texels().bytes()[..3].to_vec();
        (texel, map.slope)
    };
    assert_eq!(of(&with("(2, 2, 2, 1)", "(-1, -1, -1, 0)")), (vec![128, 204, 230], 1.0));
    assert_eq!(of(&with("(1, 1, 2, 1)", "(-0.5, -0.5, -1, 0)")), (vec![128, 204, 230], 0.5));
    assert_eq!(of(&with("(2, -2, 2, 1)", "(-1, 1, -1, 0)")), (vec![128, 51, 230], 1.0));
}

#[test]
fn a_texture_that_is_missing_has_its_fallback() {
    let texture = "asset inputs:file = @./no.png@\n float4 inputs:fallback = (0.25, 0.5, 1, 1)";
    let prims = textured("color3f inputs:diffuseColor.connect = </M/T.outputs:rgb>", texture);
    let shot = load(METRES, &prims).unwrap();
    assert_eq!(base(&shot, "m/Q"), Vec3::new(0.25, 0.5, 1.0));
    assert!(
        told(&shot).contains("`./no.png` cannot be found: the value that the file states"),
        "{}",
        told(&shot)
    );
    assert!(scene::load(&folder(METRES, &prims).path().join("m.usda"), true).is_err());
}

#[test]
fn tiles_lie_beside_and_above_each_other() {
    let prims = textured(
        "color3f inputs:diffuseColor.connect = </M/T.outputs:rgb>",
        "asset inputs:file = @./ud.<UDIM>.png@",
    );
    let folder = folder(METRES, &prims);
    for (number, color) in [(1001, [255, 0, 0]), (1002, [0, 255, 0]), (1012, [0, 0, 255])] {
        let [r, g, b] = color;
        let tile = image::RgbaImage::from_pixel(4, 2, image::Rgba([r, g, b, 255]));
        tile.save(folder.path().join(format!("ud.{number}.png"))).unwrap();
    }
    let shot = scene::load(&folder.path().join("m.usda"), true).unwrap();
    let texture = &shot.scene.textures[material(&shot, "m/Q").diffuse_map.unwrap() as usize];
    assert_eq!(texture.size(), [8, 4]);
    let texel = |number: usize| texture.texels().bytes()[4 * number..4 * number + 3].to_vec();
    // rows from the top: nothing and 1012, then 1001 and 1002
    assert_eq!([0, 4, 16, 20].map(texel), [vec![0, 0, 0], vec![0, 0, 255], vec![255, 0, 0], vec![0, 255, 0]]);
    assert_eq!(texture.mapping.at(Vec2::new(1.5, 0.5)), Vec2::new(0.75, 0.25));
}

#[test]
fn a_dome_with_a_picture_that_is_no_map_is_even() {
    let prims = |file: &str| {
        format!(
            "def Mesh \"M\" {{ {TRIANGLE} }}\ndef DomeLight \"D\" {{ asset inputs:texture:file = @./{file}@\n float inputs:intensity = 2\n}}\n"
        )
    };
    let of_screens = folder(METRES, &prims("sky.png"));
    image::RgbaImage::from_pixel(2, 1, image::Rgba([255; 4]))
        .save(of_screens.path().join("sky.png"))
        .unwrap();
    let shot = scene::load(&of_screens.path().join("m.usda"), false).unwrap();
    assert!(told(&shot).is_empty() && shot.scene.environment.is_some(), "{}", told(&shot));
    let folder = folder(METRES, &prims("sky.mov"));
    std::fs::write(folder.path().join("sky.mov"), b"moov").unwrap();
    let shot = scene::load(&folder.path().join("m.usda"), false).unwrap();
    assert!(told(&shot).contains("sky.mov` of the light from all around is no map"), "{}", told(&shot));
    assert_eq!(shot.scene.background, afterimage::scene::Background::uniform(Vec3::splat(2.0)));
}

/// A package of these files, compressed or not as far as it says.
fn package(files: &[(&str, &[u8])], method: u8) -> Vec<u8> {
    let (mut all, mut list) = (Vec::new(), Vec::new());
    let long = |number: usize| (number as u32).to_le_bytes();
    for (name, bytes) in files {
        let middle = [
            &[0; 8][..],
            &long(bytes.len()),
            &long(bytes.len()),
            &(name.len() as u16).to_le_bytes(),
            &[0, 0],
        ]
        .concat();
        let head = [&[20, 0, 0, 0, method, 0][..], &middle].concat();
        list.extend([b"PK\x01\x02\x14\0", &head[..], &[0; 10], &long(all.len()), name.as_bytes()].concat());
        all.extend([b"PK\x03\x04", &head[..], name.as_bytes(), bytes].concat());
    }
    let count = (files.len() as u16).to_le_bytes();
    let end =
        [b"PK\x05\x06\0\0\0\0", &count[..], &count, &long(list.len()), &long(all.len()), &[0, 0]].concat();
    [all, list, end].concat()
}

#[test]
fn packages_hold_text_layers_and_pictures_of_all_kinds() {
    let text = format!(
        "#usda 1.0\n({METRES})\n{}",
        textured("color3f inputs:diffuseColor.connect = </M/T.outputs:rgb>", "asset inputs:file = @a.tga@")
    );
    let mut picture = std::io::Cursor::new(Vec::new());
    image::RgbaImage::from_pixel(2, 2, image::Rgba([10, 20, 30, 255]))
        .write_to(&mut picture, image::ImageFormat::Tga)
        .unwrap();
    let files = [("m.usda", text.as_bytes()), ("a.tga", &picture.into_inner()[..])];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.usdz");
    fs::write(&path, package(&files, 0)).unwrap();
    let shot = scene::load(&path, true).unwrap();
    let texture = &shot.scene.textures[material(&shot, "m/Q").diffuse_map.unwrap() as usize];
    assert_eq!(texture.texels().bytes()[..3], [10, 20, 30]);
    fs::write(&path, package(&files, 8)).unwrap();
    let error = scene::load(&path, false).err().unwrap();
    assert!(error.message.contains("compressed in the package: pack it without compression"), "{error}");
}

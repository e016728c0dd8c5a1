//! Is of a stage read what was chosen of it: purposes, variants, a mask, payloads, times; and is its picture what its settings say?

use std::collections::BTreeSet;

use afterimage::pose::Pose;
use afterimage::scene::load_turntable;
use afterimage::scene::turntable::Options;
use afterimage::scene::usd::{Purpose, StageChoice, VariantChoice};

use super::*;

fn with(folder: &TempDir, options: Options) -> Result<Shot, SceneError> {
    load_turntable(&folder.path().join("m.usda"), false, &options)
}

/// Shot of a bare file of which this is chosen.
fn chosen(folder: &TempDir, usd: StageChoice) -> Result<Shot, SceneError> {
    with(folder, Options { usd, ..Options::default() })
}

fn names_of(shot: &Shot) -> BTreeSet<String> {
    names(shot).into_iter().map(|name| String::from(name.trim_start_matches("m/"))).collect()
}

fn why(shot: Result<Shot, SceneError>) -> String {
    shot.err().map_or_else(|| String::from("it was read"), |error| error.to_string())
}

/// Shot of a shot file with this value of `stage`.
fn by_key(folder: &TempDir, stage: &str) -> Result<Shot, SceneError> {
    let path = folder.path().join("s.toml");
    fs::write(&path, format!("{CAMERA}[[model]]\nusd = \"m.usda\"\nname = \"m\"\nstage = {stage}\n"))
        .unwrap();
    scene::load(&path, false)
}

fn mesh(name: &str) -> String {
    format!("def Mesh \"{name}\" {{ {TRIANGLE} }}\n")
}

#[test]
fn purposes_are_shown_by_choice() {
    let of = |purpose: &str| {
        format!("def Xform \"{purpose}\" {{\n uniform token purpose = \"{purpose}\"\n {} }}\n", mesh("M"))
    };
    let prims = [of("default"), of("render"), of("proxy"), of("guide")].concat();
    let folder = folder(METRES, &prims);
    let shown = |purposes: &[Purpose]| {
        let purposes = Some(purposes.iter().copied().collect());
        names_of(&chosen(&folder, StageChoice { purposes, ..StageChoice::default() }).unwrap())
    };
    let all = |names: &[&str]| names.iter().map(|name| format!("{name}/M")).collect::<BTreeSet<_>>();
    assert_eq!(names_of(&chosen(&folder, StageChoice::default()).unwrap()), all(&["default", "render"]));
    assert_eq!(shown(&[Purpose::Proxy]), all(&["default", "proxy"]));
    assert_eq!(shown(&[Purpose::Render, Purpose::Guide]), all(&["default", "render", "guide"]));
    assert_eq!(names_of(&by_key(&folder, "{ purposes = [\"guide\"] }").unwrap()), all(&["default", "guide"]));
    assert!(why(by_key(&folder, "{ purposes = [\"final\"] }")).contains("final"));
}

/// A set with two variant sets, of which one variant brings a prim with a set of its own.
fn variants() -> TempDir {
    let inner = format!(
        "def \"lamp\" ( variants = {{ string bulb = \"off\" }} add variantSets = \"bulb\" ) {{\n\
         variantSet \"bulb\" = {{ \"off\" {{ }} \"on\" {{ {} }} }} }}\n",
        mesh("Glow")
    );
    let set = format!(
        "def Xform \"World\" {{ def Xform \"set\" ( variants = {{ string time = \"day\" }}\n\
         prepend variantSets = [\"time\", \"lod\"] ) {{\n\
         variantSet \"time\" = {{ \"day\" {{ {} }} \"night\" {{ {} {inner} }} }}\n\
         variantSet \"lod\" = {{ \"high\" {{ {} }} \"low\" {{ {} }} }} }} }}\n",
        mesh("Day"),
        mesh("Night"),
        mesh("High"),
        mesh("Low")
    );
    folder(METRES, &set)
}

#[test]
fn variants_are_selected_by_prim_set_and_name() {
    let folder = variants();
    let shown = |variants: &[&str]| {
        let variants = variants.iter().map(|name| VariantChoice::parse(name).unwrap()).collect();
        let shot = chosen(&folder, StageChoice { variants, ..StageChoice::default() })?;
        let last = |name: String| name.rsplit('/').next().unwrap().to_string();
        Ok(names_of(&shot).into_iter().map(last).collect::<BTreeSet<_>>().into_iter().collect::<Vec<_>>())
    };
    assert_eq!(shown(&[]).unwrap(), ["Day"]);
    assert_eq!(shown(&["/World/set:time=night"]).unwrap(), ["Night"]);
    assert_eq!(shown(&["/World/set:lod=low", "/World/set:time=day"]).unwrap(), ["Day", "Low"]);
    // the lamp comes with the night, in whatever order they are chosen; it has one set, which need not be named
    let lit = ["/World/set/lamp=on", "/World/set:time=night"];
    assert_eq!(shown(&lit).unwrap(), ["Glow", "Night"]);
    for (names, expected) in [
        (
            &["/World/set:time=dusk"][..],
            "the variant set /World/set:time has no variant `dusk`: it has day, night",
        ),
        (
            &["/World/set:hour=night"],
            "/World/set has no variant set `hour`: it has /World/set:time (day, night), /World/set:lod (high, low)",
        ),
        (&["/World/set=night"], "has several variant sets: write the set as well"),
        (&["/World/sett:time=night"], "the file has no prim /World/sett: below /World there are set"),
        (&["/World:time=night"], "/World has no variant sets"),
        (&["/World/set/lamp=on"], "the file has no prim /World/set/lamp"),
        (&["/World/set:time=day", "/World/set:time=night"], "exclude each other"),
    ] {
        let told = shown(names).map_err(|error: SceneError| error.to_string()).unwrap_err();
        assert!(told.contains(expected), "{expected}: {told}");
    }
    let by_key =
        by_key(&folder, "{ variants = [\"/World/set:time=night\", \"/World/set/lamp=on\"] }").unwrap();
    assert_eq!(by_key.scene.models.len(), 2);
}

#[test]
fn a_bare_file_tells_its_variants_and_keeps_those_that_were_chosen() {
    let folder = variants();
    let variants = vec![VariantChoice::parse("/World/set:time=night").unwrap()];
    let options = Options { usd: StageChoice { variants, ..StageChoice::default() }, ..Options::default() };
    let told = with(&folder, options.clone()).unwrap().notes.join("\n");
    assert!(told.contains("/World/set:time=night (of day, night)"), "{told}");
    // what `init` writes shows the same
    let path = folder.path().join("m.usda");
    let text = scene::usd::text(&path, "m.usda", &options).unwrap().text;
    assert!(text.contains("stage = { variants = [\"/World/set:time=night\"] }"), "{text}");
    fs::write(folder.path().join("w.toml"), text).unwrap();
    let shot = scene::load(&folder.path().join("w.toml"), false).unwrap();
    assert_eq!(names(&shot), ["m/World/set/Night"]);
}

#[test]
fn one_file_is_shown_twice_with_other_variants() {
    let folder = variants();
    let path = folder.path().join("s.toml");
    let model = |name: &str| {
        format!(
            "[[model]]\nusd = \"m.usda\"\nname = \"{name}\"\nstage = {{ variants = [\"/World/set:time={name}\"] }}\n"
        )
    };
    fs::write(&path, format!("{CAMERA}{}{}", model("day"), model("night"))).unwrap();
    let shot = scene::load(&path, true).unwrap();
    assert_eq!(names(&shot), ["day/World/set/Day", "night/World/set/Night"]);
}

/// A stage of two payloads, one of which is a damaged file, with a material and a camera outside of both.
fn payloads() -> TempDir {
    let prims = "def Xform \"World\" {\n\
        def Xform \"a\" ( payload = @./a.usda@</A> ) { rel material:binding = </Looks/Red> }\n\
        def Xform \"b\" ( payload = @./b.usda@</B> ) { }\n def Camera \"inner\" { double3 xformOp:translate = (0, 0, 9)\n\
        uniform token[] xformOpOrder = [\"xformOp:translate\"] } }\n\
        def \"Looks\" { def Material \"Red\" { token outputs:surface.connect = </Looks/Red/S.outputs:surface>\n\
        def Shader \"S\" { uniform token info:id = \"UsdPreviewSurface\"\n color3f inputs:diffuseColor = (1, 0, 0)\n\
        token outputs:surface } } }\n";
    let folder = folder(METRES, prims);
    fs::write(folder.path().join("a.usda"), format!("#usda 1.0\ndef Xform \"A\" {{ {} }}\n", mesh("M")))
        .unwrap();
    fs::write(folder.path().join("b.usda"), "#usda 1.0\ndef Xform \"B\" { what is this\n").unwrap();
    folder
}

#[test]
fn what_the_mask_leaves_out_is_not_read() {
    let folder = payloads();
    let of = |mask: &[&str]| {
        let mask = mask.iter().map(|path| String::from(*path)).collect();
        chosen(&folder, StageChoice { mask, ..StageChoice::default() })
    };
    let all = of(&[]).unwrap();
    assert!(all.warnings.iter().any(|warning| warning.to_string().contains("b.usda")));
    let masked = of(&["/World/a"]).unwrap();
    let told: Vec<String> = masked.warnings.iter().map(ToString::to_string).collect();
    assert!(told.is_empty(), "{told:?}");
    assert!(
        !masked.files.iter().any(|file| file.ends_with("b.usda")) && all.files.len() == masked.files.len()
    );
    assert_eq!(names(&masked), ["m/World/a/M"]);
    // materials are found wherever they are
    let material = &masked.scene.materials[usize::from(model(&masked, "m/World/a/M").mesh.material_of[0])];
    assert_eq!(material.name, "Red");
    // and so is a camera by its path, but by its name only in the mask
    let camera = |camera: &str| {
        let usd = StageChoice { mask: vec![String::from("/World/a")], ..StageChoice::default() };
        with(&folder, Options { camera: Some(camera.into()), usd, ..Options::default() })
    };
    assert_eq!(Pose::new(&camera("/World/inner").unwrap().scene, 1).camera.eye, Vec3::Z * 9.0);
    assert!(why(camera("inner")).contains("the camera `inner` is not in the file: there is no camera"));
    assert!(why(camera("/World/outer")).contains("the camera `/World/outer` is not in the file"));
    let nowhere = why(of(&["/World/c"]));
    assert!(
        nowhere.contains("the mask: the file has no prim /World/c: below /World there are a, b, inner"),
        "{nowhere}"
    );
    assert!(why(by_key(&folder, "{ mask = [] }")).contains("names no prim"));
    assert!(why(by_key(&folder, "{ mask = [\"World\"] }")).contains("`World` is no path of a prim"));
    assert_eq!(names(&by_key(&folder, "{ mask = [\"/World/a\"] }").unwrap()), ["m/World/a/M"]);
}

#[test]
fn payloads_are_left_out_by_choice() {
    let folder = payloads();
    let of = |paths: &[&str]| {
        let unloaded = paths.iter().map(|path| String::from(*path)).collect();
        chosen(&folder, StageChoice { unloaded, ..StageChoice::default() })
    };
    let shot = of(&["/World/b"]).unwrap();
    assert!(shot.warnings.is_empty() && names(&shot) == ["m/World/a/M"]);
    assert!(why(of(&["/"])).contains("it shows no meshes"));
    assert!(why(of(&["/World/q"])).contains("the unloaded payloads: the file has no prim /World/q"));
}

#[test]
fn times_are_read_of_the_chosen_frames_alone() {
    let times: Vec<String> = (1..=100).map(|code| format!("{code}: ({code}, 0, 0)")).collect();
    let points: Vec<String> =
        (1..=100).map(|code| format!("{code}: [(0, 0, 0), (1, 0, 0), (0, {code}, 0)]")).collect();
    let mesh = TRIANGLE.replace("point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\n", "");
    let prims = format!(
        "def Mesh \"M\" {{ {mesh} point3f[] points.timeSamples = {{ {} }}\n double3 xformOp:translate.timeSamples = {{ {} }}\n\
         uniform token[] xformOpOrder = [\"xformOp:translate\"] }}\ndef Camera \"C\" {{}}\n",
        points.join(", "),
        times.join(", ")
    );
    let folder = folder(&format!("{METRES}startTimeCode = 1\nendTimeCode = 100\n"), &prims);
    let of = |frames| chosen(&folder, StageChoice { frames, ..StageChoice::default() }).unwrap();
    let (all, some) = (of(None), of(Some([40, 42])));
    assert_eq!([&all, &some].map(|shot| shot.frames.to_string()), ["1-100", "40-42"]);
    let shapes = |shot: &Shot| shot.scene.models[0].mesh.shapes().unwrap().list().len();
    // with a frame on each side, for the shutter
    assert_eq!([&all, &some].map(shapes), [100, 5]);
    for frame in [39.5, 40.0, 41.75, 42.5] {
        let place = |shot: &Shot| {
            let model = &shot.scene.models[0];
            let track = model.track.shapes.as_ref().unwrap();
            let point = model.mesh.shapes().unwrap().positions(&track.at(frame))[2];
            model.track.map_at(frame).transform_point3(Vec3::from(point).as_dvec3())
        };
        assert_near(place(&some), place(&all));
    }
    assert_eq!(shapes(&by_key(&folder, "{ time_samples = \"7\" }").unwrap()), 3);
    assert!(why(by_key(&folder, "{ time_samples = \"x\" }")).contains("`time_samples`"));
}

fn with_settings(settings: &str) -> TempDir {
    let camera = |name: &str, z: f64| {
        format!(
            "def Camera \"{name}\" {{ double3 xformOp:translate = (0, 0, {z})\n float horizontalAperture = 2\n\
             float verticalAperture = 1\n float focalLength = 1\n float fStop = 2\n float focusDistance = 3\n\
             double shutter:open = -0.25\n double shutter:close = 0.25\n uniform token[] xformOpOrder = [\"xformOp:translate\"] }}\n"
        )
    };
    let proxy = format!("def Xform \"P\" {{ uniform token purpose = \"proxy\"\n {} }}\n", mesh("M"));
    folder(METRES, &format!("{}{proxy}{}{}{settings}", mesh("M"), camera("A", 5.0), camera("B", 7.0)))
}

#[test]
fn settings_products_and_variables_describe_the_picture() {
    let settings = "def Scope \"Render\" {\n def RenderSettings \"draft\" { uniform int2 resolution = (64, 32) }\n\
        def RenderSettings \"final\" {\n rel camera = </A>\n rel products = [</Render/beauty>, </Render/other>]\n\
        uniform int2 resolution = (100, 100)\n uniform token[] includedPurposes = [\"default\", \"proxy\"]\n\
        uniform float4 dataWindowNDC = (0, 0, 0.5, 0.5)\n uniform bool disableDepthOfField = 1\n custom int ri:samples = 4 }\n\
        def RenderProduct \"beauty\" {\n rel camera = </B>\n uniform token aspectRatioConformPolicy = \"adjustApertureHeight\"\n\
        uniform bool disableMotionBlur = 1\n\
        token productName = \"pictures/beauty.exr\"\n rel orderedVars = [</Render/color>, </Render/z>, </Render/lpe>] }\n\
        def RenderProduct \"other\" { }\n def RenderVar \"color\" { uniform string sourceName = \"Ci\" }\n\
        def RenderVar \"z\" { uniform string sourceName = \"z\" }\n\
        def RenderVar \"lpe\" { uniform string sourceName = \"C<RD>L\"\n uniform token sourceType = \"lpe\" }\n\
        def RenderPass \"pass\" { rel renderSource = </Render/final> } }\n";
    let folder = with_settings(settings);
    let of = |path: Option<&str>| {
        with(&folder, Options { render_settings: path.map(String::from), ..Options::default() })
    };
    let first = of(None).unwrap();
    assert_eq!((first.settings.width, first.settings.height), (64, 32));
    assert!(first.settings.shutter.is_some() && first.scene.camera.has_lens());
    for name in ["/Render/final", "/Render/pass"] {
        let shot = of(Some(name)).unwrap();
        assert_eq!((shot.settings.width, shot.settings.height), (100, 100));
        assert_eq!(Pose::new(&shot.scene, 1).camera.eye, Vec3::Z * 7.0);
        assert_eq!(names(&shot), ["m/M", "m/P/M"]);
        assert!(shot.settings.shutter.is_none() && !shot.scene.camera.has_lens());
        assert_eq!(shot.output.as_deref(), Some("pictures/beauty.####.exr"));
        assert_eq!(shot.settings.layers.names().collect::<Vec<_>>(), ["depth"]);
        let told: String = shot.warnings.iter().map(|warning| format!("{warning}\n")).collect();
        for expected in [
            "products of /Render/final behind the first one are not used: /Render/other",
            "/Render/lpe (C<RD>L)",
            "dataWindowNDC of /Render/final is not used: the whole picture is rendered; --crop 50x50+0+50 renders",
            "settings of other renderers in /Render/final are not used (ri)",
        ] {
            assert!(told.contains(expected), "{expected}: {told}");
        }
    }
    // what is typed goes before what is stated
    let usd = StageChoice { purposes: Some([Purpose::Render].into()), ..StageChoice::default() };
    let options = Options {
        usd,
        camera: Some("A".into()),
        render_settings: Some("/Render/final".into()),
        ..Options::default()
    };
    let shot = with(&folder, options).unwrap();
    assert_eq!((names(&shot), Pose::new(&shot.scene, 1).camera.eye.z), (vec!["m/M"], 5.0));
    for (path, expected) in [
        ("/Render/best", "the render settings: the file has no prim /Render/best: below /Render there are"),
        (
            "/M",
            "/M is neither a RenderSettings nor a RenderPass: below /Render there are /Render/draft, /Render/final",
        ),
    ] {
        let told = why(of(Some(path)));
        assert!(told.contains(expected), "{expected}: {told}");
    }
}

#[test]
fn settings_that_name_no_camera_are_told() {
    let of = |name: &str| {
        format!("def Scope \"Render\" {{ def RenderSettings \"S\" {{ rel camera = <{name}> }} }}\n")
    };
    let folder = with_settings(&of("/Nowhere"));
    let path = folder.path().join("m.usda");
    let shot = scene::load(&path, false).unwrap();
    assert_eq!(Pose::new(&shot.scene, 1).camera.eye.z, 5.0);
    let told: String = shot.warnings.iter().map(ToString::to_string).collect();
    let expected =
        "the camera /Nowhere, which the settings /Render/S name, is not in the file: the first one is shown";
    assert!(told.contains(expected), "{told}");
    assert!(scene::load(&path, true).is_err());
    let metadata = format!("{METRES}renderSettingsPrimPath = \"/Render/Best\"\n");
    let told: String =
        load(&metadata, &mesh("M")).unwrap().warnings.iter().map(ToString::to_string).collect();
    assert!(
        told.contains(
            "the render settings `/Render/Best`, which renderSettingsPrimPath names, are not in the file"
        ),
        "{told}"
    );
}

#[test]
fn payloads_that_the_camera_does_not_see_are_left_out_by_choice() {
    let payload = |name: &str, x: f64, hint: &str| {
        format!(
            "def Xform \"{name}\" ( payload = @./a.usda@</A> ) {{ {hint}\n double3 xformOp:translate = ({x}, 0, 0)\n\
             uniform token[] xformOpOrder = [\"xformOp:translate\"] }}\n"
        )
    };
    let hint = "float3[] extentsHint = [(0, 0, 0), (1, 1, 0)]";
    // the camera goes from x = 0 to x = 40: what is at 20 is seen on the way
    let camera = "def Camera \"C\" { double3 xformOp:translate.timeSamples = { 1: (0, 0, 9), 5: (40, 0, 9) }\n\
        uniform token[] xformOpOrder = [\"xformOp:translate\"] }\n";
    let prims = [
        camera.into(),
        payload("first", 0.0, hint),
        payload("middle", 20.0, hint),
        payload("beyond", 60.0, hint),
        payload("unknown", 60.0, ""),
    ]
    .concat();
    let folder = folder(METRES, &prims);
    fs::write(folder.path().join("a.usda"), format!("#usda 1.0\ndef Xform \"A\" {{ {} }}\n", mesh("M")))
        .unwrap();
    let options = Options { only_seen: true, ..Options::default() };
    let shot = with(&folder, options.clone()).unwrap();
    assert_eq!(names(&shot), ["m/first/M", "m/middle/M", "m/unknown/M"]);
    let told = shot.notes.join("\n");
    assert!(
        told.contains("of 4 payloads 3 are loaded, 1 of them because they state no extentsHint"),
        "{told}"
    );
    let text = scene::usd::text(&folder.path().join("m.usda"), "m.usda", &options).unwrap().text;
    assert!(text.contains("stage = { unloaded = [\"/beyond\"] }"), "{text}");
    let nobody = with(&folder, Options { camera: Some("D".into()), ..options });
    assert!(why(nobody).contains(
        "--only-seen needs a camera that is in no payload, and there is no such camera `D` (there are: /C)"
    ));
}

#[test]
fn inactive_copies_are_not_there() {
    let shown = |metadata: &str, weaker: &str, ids: &str| {
        let over = format!("over \"P\" ( {metadata} ) {{ }}\n");
        let folder = folder(&format!("{METRES}subLayers = [@./w.usda@]\n"), &over);
        let copies = format!(
            "def PointInstancer \"P\" ( {weaker} ) {{ rel prototypes = [</P/T>]\n int[] protoIndices = [0, 0, 0, 0]\n {ids}\n\
             point3f[] positions = [(1, 0, 0), (2, 0, 0), (3, 0, 0), (4, 0, 0)]\n over Xform \"T\" {{ {} }} }}\n",
            mesh("M")
        );
        fs::write(folder.path().join("w.usda"), format!("#usda 1.0\n{copies}")).unwrap();
        let shot = scene::load(&folder.path().join("m.usda"), false).unwrap();
        let number = |name: &&str| name["m/P/".len()..].split('/').next().unwrap().parse().unwrap();
        names(&shot).iter().map(number).collect::<Vec<u32>>()
    };
    assert_eq!(shown("", "inactiveIds = [1, 2]", ""), [0, 3]);
    assert_eq!(shown("", "inactiveIds = [7, 9]", "int64[] ids = [6, 7, 8, 9]"), [0, 2]);
    assert_eq!(shown("append inactiveIds = [0]", "inactiveIds = [1]", ""), [2, 3]);
    assert_eq!(shown("delete inactiveIds = [1]", "inactiveIds = [1, 2]", ""), [0, 1, 3]);
    assert_eq!(shown("inactiveIds = [3]", "inactiveIds = [1, 2]", ""), [0, 1, 2]);
}

#[test]
fn copies_come_and_go_with_invisible_ids() {
    let prims = format!(
        "def PointInstancer \"P\" {{ rel prototypes = [</P/T>]\n int[] protoIndices = [0, 0, 0]\n\
         int64[] invisibleIds.timeSamples = {{ 1: [0, 2], 3: [2], 5: [1, 2] }}\n\
         point3f[] positions = [(1, 0, 0), (2, 0, 0), (3, 0, 0)]\n over Xform \"T\" {{ {} }} }}\n",
        mesh("M")
    );
    let shot = shown(METRES, &prims);
    assert_eq!(names(&shot), ["m/P/0/T/M", "m/P/1/T/M"]);
    let seen = |name: &str| [1.0, 2.9, 3.0, 4.9, 5.0].map(|frame| model(&shot, name).track.visible.at(frame));
    assert_eq!(seen("m/P/0/T/M"), [false, false, true, true, true]);
    assert_eq!(seen("m/P/1/T/M"), [true, true, true, true, false]);
}

#[test]
fn bindings_count_by_the_purposes_of_the_settings() {
    let material = |name: &str| {
        format!(
            "def Material \"{name}\" {{ token outputs:surface.connect = </{name}/S.outputs:surface>\n\
             def Shader \"S\" {{ uniform token info:id = \"UsdPreviewSurface\"\n token outputs:surface }} }}\n"
        )
    };
    let bound = |of_parent: &str, of_mesh: &str, settings: &str| {
        let meshes = format!(
            "def Xform \"X\" {{ {of_parent}\n def Mesh \"M\" {{ {TRIANGLE} {of_mesh} }} }}\ndef Camera \"C\" {{}}\n\
             def Scope \"Render\" {{ def RenderSettings \"S\" {{ {settings} }} }}\n"
        );
        let prims = [material("Preview"), material("All"), material("Full"), meshes].concat();
        let shot = load(METRES, &prims).unwrap();
        let number = usize::from(model(&shot, "m/X/M").mesh.material_of[0]);
        shot.scene.materials[number].name.clone()
    };
    let (preview, all, full) = (
        "rel material:binding:preview = </Preview>\n",
        "rel material:binding = </All>\n",
        "rel material:binding:full = </Full>\n",
    );
    // a purpose goes before what is nearer
    assert_eq!(bound(preview, all, ""), "Preview");
    assert_eq!(bound(all, full, ""), "All");
    assert_eq!(bound("", full, ""), "Full");
    let first = |names: &str| format!("uniform token[] materialBindingPurposes = [{names}]");
    assert_eq!(bound(full, &format!("{preview}{all}"), &first("\"full\", \"\"")), "Full");
    assert_eq!(bound(preview, all, &first("\"allPurpose\"")), "All");
}

#[test]
fn exposures_of_cameras_are_those_of_pictures_for_screens() {
    let of = |exposure: &str| {
        let prims = format!("{}def Camera \"C\" {{ {exposure} }}\n", mesh("M"));
        load(METRES, &prims).unwrap()
    };
    assert_eq!(of("").look.exposure, 0.0);
    // twice the light in twice the time for a film that needs half of it, behind a lens that lets a quarter through
    let all = "float exposure = 1\n float exposure:iso = 200\n float exposure:time = 2\n float exposure:fStop = 2\n\
        float exposure:responsivity = 2\n";
    assert!((of(all).look.exposure - 2.0).abs() < 1e-6);
    let endless = of("float exposure:time = 0\n");
    let told: String = endless.warnings.iter().map(ToString::to_string).collect();
    assert!(
        endless.look.exposure == 0.0 && told.contains("the exposure of the camera /C is beyond all bounds"),
        "{told}"
    );
}

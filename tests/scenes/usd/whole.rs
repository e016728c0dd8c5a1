//! Is a bare USD file a shot, with its own camera and lights?

use std::f32::consts::PI;

use afterimage::pose::Pose;
use afterimage::scene::LightKind;

use super::*;

fn with_mesh(prims: &str) -> String {
    format!("def Mesh \"M\" {{ {TRIANGLE} }}\n{prims}")
}

#[test]
fn cameras_have_their_lens_shift_focus_and_shutter() {
    let camera = "def Camera \"C\" {\n double3 xformOp:translate.timeSamples = { 1: (0, 0, 8), 5: (0, 0, 4) }\n\
        uniform token[] xformOpOrder = [\"xformOp:translate\"]\n float focalLength.timeSamples = { 1: 0.5, 5: 1 }\n\
        float horizontalAperture = 2\n float verticalAperture = 1\n float horizontalApertureOffset = 0.5\n\
        float fStop = 2\n float focusDistance = 3\n double shutter:open = -0.25\n double shutter:close = 0.25\n}\n";
    let shot = shown(&format!("{METRES}startTimeCode = 1\nendTimeCode = 5\n"), &with_mesh(camera));
    let settings = &shot.settings;
    assert_eq!((settings.width, settings.height, shot.frames.to_string().as_str()), (1440, 720, "1-5"));
    let pose = Pose::new(&shot.scene, 1);
    assert!((pose.camera.half_height - 1.0).abs() < 1e-6, "{}", pose.camera.half_height);
    assert!((Pose::new(&shot.scene, 5).camera.half_height - 0.5).abs() < 1e-6);
    assert_eq!(Pose::new(&shot.scene, 3).camera.eye, Vec3::new(0.0, 0.0, 6.0));
    let folder = folder(METRES, &with_mesh(camera));
    let text =
        scene::usd::text(&folder.path().join("m.usda"), "m.usda", &scene::turntable::Options::default());
    let text = text.unwrap().text;
    for line in ["shift = [0.25, 0.0]", "aperture = 0.0125", "focus = 3.0", "open = -0.25\nclose = 0.25"] {
        assert!(text.contains(line), "{line}\n{text}");
    }
}

/// What a bare file is rendered by is what `init` writes of it.
#[test]
fn a_bare_file_is_the_shot_that_is_written_of_it() {
    let camera = |projection: &str| {
        format!(
            "def Camera \"C\" {{\n token projection = \"{projection}\"\n\
             double3 xformOp:translate.timeSamples = {{ 1: (0, 0, 8), 5: (0, 0, 4) }}\n float xformOp:rotateZ = 30\n\
             uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:rotateZ\"]\n\
             float focalLength = 10\n float horizontalAperture = 40\n float verticalAperture = 20\n\
             float fStop.timeSamples = {{ 1: 2, 5: 0 }}\n float focusDistance = 3\n\
             float2 clippingRange.timeSamples = {{ 1: (0.1, 8.25), 5: (0.1, 5) }}\n\
             double shutter:open = -0.25\n double shutter:close = 0.25\n}}\n"
        )
    };
    let dome = "def DomeLight \"D\" {\n float inputs:intensity = 2\n color3f inputs:color = (1, 0.5, 0)\n}\n\
        def DistantLight \"S\" {\n float inputs:intensity = 1\n}\n";
    for (projection, told) in [("perspective", "\nfov = 90.0\n"), ("orthographic", "\nheight = 2.0\n")] {
        let folder = folder(METRES, &with_mesh(&(camera(projection) + dome)));
        let path = folder.path().join("m.usda");
        let text = scene::usd::text(&path, "m.usda", &scene::turntable::Options::default()).unwrap().text;
        let told = [told, "\nfar = 5.0\n", "\n[background]\ncolor = [2.0, 1.0, 0.0]\n\n[environment]\n"];
        assert!(told.iter().all(|lines| text.contains(lines)), "{told:?}\n{text}");
        assert_eq!(text.contains("\naperture = 0\n"), projection == "perspective", "{text}");
        fs::write(folder.path().join("s.toml"), text).unwrap();
        let [bare, shot] = [path, folder.path().join("s.toml")].map(|path| scene::load(&path, true).unwrap());
        assert_eq!(bare.content.shot, shot.content.shot);
        assert_eq!(bare.scene.camera, shot.scene.camera);
        assert_eq!(bare.scene.background, shot.scene.background);
        assert_eq!((bare.settings, bare.frames), (shot.settings, shot.frames));
        assert!(bare.scene.environment.is_some() && shot.scene.environment.is_some());
    }
}

#[test]
fn clipping_ranges_count_where_they_cut_anything_off() {
    let clip = |range: &str, header: &str| {
        let camera = format!(
            "def Camera \"C\" {{\n double3 xformOp:translate = (0, 0, 8)\n uniform token[] xformOpOrder = [\"xformOp:translate\"]\n\
             float2 clippingRange{range}\n}}\n"
        );
        let shot = load(header, &with_mesh(&camera)).unwrap();
        [1, 5].map(|frame| {
            let clip = Pose::new(&shot.scene, frame).camera.clip;
            (clip.near, clip.far)
        })
    };
    let all = (0.0, f32::INFINITY);
    assert_eq!(clip(" = (0.1, 1000)", METRES), [all; 2]);
    assert_eq!(clip(" = (0.1, 7)", METRES), [(0.0, 7.0); 2]);
    assert_eq!(clip(".timeSamples = { 1: (0.1, 7), 5: (0.1, 5) }", METRES), [(0.0, 7.0), (0.0, 5.0)]);
    assert_eq!(clip(" = (7, 1)", METRES), [all; 2]);
}

#[test]
fn lights_are_as_bright_as_the_file_says() {
    let lights = "def RectLight \"R\" {\n float inputs:intensity = 8\n float inputs:exposure = 1\n float inputs:width = 2\n\
        float inputs:height = 3\n}\n\
        def RectLight \"N\" {\n float inputs:intensity = 8\n float inputs:width = 2\n bool inputs:normalize = 1\n}\n\
        def DiskLight \"D\" {\n float inputs:intensity = 3\n float inputs:radius = 2\n}\n\
        def SphereLight \"S\" {\n float inputs:intensity = 3\n float inputs:radius = 2\n}\n\
        def SphereLight \"Spot\" {\n float inputs:intensity = 4\n bool inputs:normalize = 1\n float inputs:radius = 0\n\
        float inputs:shaping:cone:angle = 30\n float inputs:shaping:cone:softness = 0.5\n}\n\
        def DistantLight \"Sun\" {\n float inputs:intensity = 2\n bool inputs:normalize = 1\n float inputs:angle = 2\n}\n\
        def CylinderLight \"Tube\" {\n}\n";
    let shot = load(METRES, &with_mesh(lights)).unwrap();
    let pose = Pose::new(&shot.scene, 1);
    let strength: Vec<f32> = pose.lights.iter().map(|light| light.strength.x).collect();
    // radiance times the area that is seen, over pi
    let expected = [16.0 * 6.0 / PI, 8.0 / PI, 12.0, 12.0, 1.0 / PI, 2.0 / PI];
    assert!(
        strength.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4 * b),
        "{strength:?} {expected:?}"
    );
    let kinds: Vec<&str> = shot.scene.lights.iter().map(|light| light.kind.name()).collect();
    assert_eq!(kinds, ["rectangle", "rectangle", "disk", "sphere", "spot", "directional, soft"]);
    let LightKind::Spot { cone, soft, .. } = &shot.scene.lights[4].kind else { panic!("the spot") };
    assert!((cone.at(1.0) - 60.0).abs() < 1e-4 && (soft.at(1.0) - 0.5).abs() < 1e-6);
    let told: Vec<String> = shot.warnings.iter().map(ToString::to_string).collect();
    assert!(told.len() == 1 && told[0].contains("CylinderLight"), "{told:?}");
}

#[test]
fn temperatures_tint_lights_that_say_so() {
    let light = |name: &str, lines: &str| {
        format!(
            "def SphereLight \"{name}\" {{\n float inputs:intensity = 3\n float inputs:radius = 2\n{lines} }}\n"
        )
    };
    let on = "bool inputs:enableColorTemperature = 1\n";
    let warm = "float inputs:colorTemperature = 3000\n";
    let lights = light("Warm", &format!("{on}{warm}")) + &light("Off", warm) + &light("White", on);
    let shot = shown(METRES, &with_mesh(&lights));
    let pose = Pose::new(&shot.scene, 1);
    let [warm, off, white] = [0, 1, 2].map(|number| pose.lights[number].strength);
    assert!(off == white && off.x == off.z && off.x > 0.0, "{off} {white}");
    assert!(warm.x > 1.5 * off.x && warm.z < 0.5 * off.z, "{warm}");
    let luminance = glam::Vec3::new(0.2126, 0.7152, 0.0722);
    assert!((warm.dot(luminance) / off.dot(luminance) - 1.0).abs() < 1e-3);
}

#[test]
fn the_middle_of_a_dome_is_at_its_positive_z() {
    let dome = "def DomeLight \"D\" {\n float inputs:intensity = 0.5\n asset inputs:texture:file = @./sky.hdr@\n\
        float xformOp:rotateY = 90\n uniform token[] xformOpOrder = [\"xformOp:rotateY\"]\n}\n";
    let folder = folder(METRES, &with_mesh(dome));
    fs::write(folder.path().join("sky.hdr"), "").unwrap();
    let text =
        scene::usd::text(&folder.path().join("m.usda"), "m.usda", &scene::turntable::Options::default());
    let text = text.unwrap().text;
    assert!(
        text.contains("rotation = 270") && text.contains("power = 0.5") && text.contains("sky.hdr"),
        "{text}"
    );
    let even = "def DomeLight \"D\" {\n float inputs:intensity = 2\n color3f inputs:color = (1, 0.5, 0)\n}\n";
    let shot = shown(METRES, &with_mesh(even));
    assert!(shot.scene.environment.is_some() && shot.scene.lights.is_empty());
}

#[test]
fn a_dome_without_its_picture_is_even_and_says_so() {
    let dome = |name: &str| {
        with_mesh(&format!(
            "def DomeLight \"D\" {{ asset inputs:texture:file = @{name}@ float inputs:intensity = 2 }}\n"
        ))
    };
    let shot = load(METRES, &dome("./no.exr")).unwrap();
    let told: Vec<String> = shot.warnings.iter().map(ToString::to_string).collect();
    assert!(
        told.iter().any(|told| told.contains("no.exr` of the light from all around cannot be found")),
        "{told:?}"
    );
    assert_eq!(shot.scene.background, afterimage::scene::Background::uniform(glam::Vec3::splat(2.0)));
    assert!(scene::load(&folder(METRES, &dome("./no.exr")).path().join("m.usda"), true).is_err());
    // as programs on Windows write names
    let folder = folder(METRES, &dome(".\\maps\\even.hdr"));
    fs::create_dir(folder.path().join("maps")).unwrap();
    fs::write(
        folder.path().join("maps/even.hdr"),
        b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x80\x80\x81",
    )
    .unwrap();
    let shot = scene::load(&folder.path().join("m.usda"), true).unwrap();
    assert!(shot.warnings.is_empty() && shot.scene.environment.is_some(), "{:?}", shot.warnings);
}

/// Names of the models of a shot that are meant.
fn meant(shot: &Shot, names: &scene::ModelNames) -> Vec<String> {
    shot.scene.models.iter().filter(|model| names.has(model)).map(|model| model.name.clone()).collect()
}

#[test]
fn collections_link_lights_to_models() {
    let mesh = |name: &str| format!("def Mesh \"{name}\" {{ {TRIANGLE} }}\n");
    let set = format!("def Xform \"Set\" {{\n{}{}}}\n", mesh("Wall"), mesh("Floor"));
    let light = |name: &str, collections: &str| {
        format!("def SphereLight \"{name}\" {{\n float inputs:intensity = 3\n{collections}}}\n")
    };
    let link = "collection:lightLink";
    let lights = [
        light("All", ""),
        light(
            "Of",
            &format!(
                "bool {link}:includeRoot = 0\n rel {link}:includes = [</Set>, </Hero>]\n rel {link}:excludes = </Set/Floor>\n"
            ),
        ),
        light("But", &format!("rel {link}:excludes = </Set>\n rel {link}:includes = </Set/Wall>\n")),
        light(
            "Exact",
            &format!(
                "bool {link}:includeRoot = 0\n uniform token {link}:expansionRule = \"explicitOnly\"\n rel {link}:includes = [</Set>, </Hero>]\n"
            ),
        ),
        light("Shadows", "rel collection:shadowLink:excludes = </Hero>\n"),
        light(
            "None",
            "bool collection:shadowLink:includeRoot = 0\n rel collection:shadowLink:includes = </Away>\n",
        ),
        light("Nothing", &format!("bool {link}:includeRoot = 0\n rel {link}:includes = </Away>\n")),
    ];
    let shot = shown(METRES, &(mesh("Hero") + &set + &lights.concat()));
    let names: Vec<&str> = shot.scene.lights.iter().map(|light| light.name.as_str()).collect();
    // what is linked to nothing that is shown is left out
    assert_eq!(names, ["All", "Of", "But", "Exact", "Shadows", "None"]);
    let [hero, wall, floor] = ["m/Hero", "m/Set/Wall", "m/Set/Floor"];
    let lit: Vec<Vec<String>> =
        shot.scene.lights.iter().map(|light| meant(&shot, &light.links.receivers)).collect();
    let all = vec![hero, wall, floor];
    assert_eq!(lit, [all.clone(), vec![hero, wall], vec![hero, wall], vec![hero], all.clone(), all.clone()]);
    let shadows: Vec<Vec<String>> =
        shot.scene.lights[3..].iter().map(|light| meant(&shot, &light.links.blockers)).collect();
    assert_eq!(shadows, [all, vec![wall, floor], vec![]]);
}

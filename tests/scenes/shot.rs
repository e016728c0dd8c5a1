//! Shot files: what they mean, and what is said about mistakes in them.

use std::sync::Arc;

use afterimage::animation::TransformTrack;
use afterimage::layers::Layers;
use afterimage::pose::Pose;
use afterimage::scene::camera::{Lens, Projection};
use afterimage::scene::material::Optics;
use afterimage::scene::{self, Background, LightKind};
use afterimage::settings::{
    Backdrop, BasePlace, Caustics, Compression, DenoiseQuality, FileFormat, Filter, Look, Mode, View,
};
use glam::{DVec3, Vec3};

use crate::small_shot::*;

#[test]
fn defaults_are_as_documented() {
    let shot = load(REST);
    let settings = &shot.settings;
    assert_eq!((settings.width, settings.height, settings.samples), (1280, 720, 2));
    assert_eq!((settings.overscan, settings.crop), (0, None));
    assert_eq!((settings.filter, settings.mode), (Filter::Box, Mode::Auto));
    assert_eq!((settings.depth, settings.base_every, settings.audit), (4, 48, false));
    assert_eq!((settings.paths, settings.bounces, settings.reflections), (0, 2, 4));
    assert_eq!(settings.tree_memory, 256);
    // the model is 1 x 1 x 0
    assert_eq!(settings.occlusion_rays, 16);
    assert!((settings.occlusion_radius - 0.1 * 2.0_f64.sqrt()).abs() < 1e-12);
    assert!(!shot.scene.ambient_is_occluded);
    assert_eq!((shot.title.as_str(), shot.rate, shot.frames.list()), ("s", (24, 1), vec![1]));
    assert_eq!((shot.output, shot.warnings.len()), (None, 1));
    assert!(shot.warnings[0].to_string().contains("nothing gives light"));
    assert_eq!(shot.scene.background, Background::uniform(Vec3::ZERO));
    assert_eq!(shot.scene.environment, None);
    assert_eq!(shot.scene.models[0].name, "m");
    assert_eq!(shot.scene.camera.fov.at(1.0), 40.0);
    let Lens { height, shift, aperture, focus } = &shot.scene.camera.lens;
    assert!(height.is_none() && aperture.is_none() && focus.is_none());
    assert!(shift.iter().all(|shift| shift.at(1.0) == 0.0));
    assert_eq!(shot.scene.camera.projection(), Projection::Perspective);
}

#[test]
fn every_key_is_read() {
    let shot = load(&format!(
        "title = \"T\"\n[render]\nsize = [64, 48]\noverscan = 5\nsamples = 3\nframes = \"1-4x2\"\nrate = \"24000/1001\"\n\
         filter = \"mitchell\"\ndepth = 0\nreflections = 7\ncaustics = \"paths\"\nclamp = 2.5\ntree_memory = 0\nbase_every = 0\nbase_place = \"middle\"\ncuts = [3]\n\
         mode = \"full\"\n[indirect]\npaths = 9\nbounces = 1\n\
         [occlusion]\nradius = 0.5\nrays = 32\n[output]\npath = \"o.#.exr\"\n\
         denoise = true\ndenoise_quality = \"fast\"\nlayers = [\"background\", \"direct\"]\nbackground = \"transparent\"\nmultipart = true\ncompression = \"piz\"\nexposure = -1.5\nview = \"filmic\"\n\
         [background]\nzenith = [0, 0, 1]\nhorizon = [1, 1, 1]\n[ambient]\ncolor = [0.5, 0.5, 0.5]\noccluded = true\n\
         [[light]]\ntype = \"spot\"\nposition = [0, 9, 0]\ntarget = [0, 0, 0]\ncone = 30\nsoft = 0.5\n\
         color = [1, 0, 0]\npower = 2\n[[light.key]]\nframe = 1\n[[light.key]]\nframe = 3\npower = 4\n\
         [[light]]\nname = \"sun\"\ntype = \"directional\"\ndirection = [0, -1, 0]\n{REST}"
    ));
    assert_eq!((shot.title.as_str(), shot.rate, shot.frames.list()), ("T", (24000, 1001), vec![1, 3]));
    assert_eq!((shot.settings.width, shot.settings.filter), (64, Filter::Mitchell));
    assert_eq!(shot.settings.overscan, 5);
    assert_eq!((shot.settings.base_place, &shot.scene.camera.cuts[..]), (BasePlace::Middle, &[3][..]));
    assert_eq!((shot.settings.depth, shot.settings.base_every, shot.settings.mode), (0, 0, Mode::Full));
    assert_eq!((shot.settings.paths, shot.settings.bounces, shot.settings.reflections), (9, 1, 7));
    assert_eq!((shot.settings.tree_memory, shot.settings.caustics), (0, Caustics::Paths));
    assert_eq!(shot.settings.clamp, Some(2.5));
    assert_eq!(shot.output.as_deref(), Some("o.#.exr"));
    assert_eq!((shot.denoise, shot.denoise_quality), (true, DenoiseQuality::Fast));
    assert_eq!(shot.settings.layers, Layers::DIRECT.with(Layers::BACKGROUND));
    assert_eq!(shot.settings.background, Backdrop::Transparent);
    assert_eq!(shot.format, FileFormat { multipart: true, compression: Compression::Piz });
    assert_eq!(shot.look, Look { exposure: -1.5, view: View::Filmic });
    assert_eq!(shot.scene.background.ground, Vec3::ONE);
    let [spot, sun] = shot.scene.lights.as_slice() else { unreachable!("two lights") };
    assert_eq!((spot.name.as_str(), sun.name.as_str()), ("light 1", "sun"));
    assert_eq!((spot.power.at(1.0), spot.power.at(2.0), spot.power.at(3.0)), (2.0, 3.0, 4.0));
    assert!(matches!(spot.kind, LightKind::Spot { cone: 30.0, soft: 0.5, .. }));
    assert_eq!(shot.scene.ambient, Vec3::splat(0.5));
    assert!(shot.scene.ambient_is_occluded);
    assert_eq!((shot.settings.occlusion_radius, shot.settings.occlusion_rays), (0.5, 32));
}

/// A tenth of the diagonal of all models, where they stand in the shot's first frame.
#[test]
fn the_usual_radius_of_occlusion_is_that_of_the_first_frame() {
    let moved = "[[model]]\nobj = \"m.obj\"\n[[model.key]]\nframe = 1\n[[model.key]]\nframe = 3\ntranslate = [1, 0, 0]\n";
    for (frames, width) in [("1-3", 1.0_f64), ("3,9", 2.0)] {
        let shot = load(&format!("[render]\nframes = \"{frames}\"\n{REST}{moved}"));
        let expected = 0.1 * width.hypot(1.0);
        assert!((shot.settings.occlusion_radius - expected).abs() < 1e-12, "{frames}");
    }
    let folder = folder();
    let turntable = scene::load(&folder.path().join("m.obj"), false).unwrap();
    assert!((turntable.settings.occlusion_radius - 0.1 * 2.0_f64.sqrt()).abs() < 1e-12);
}

#[test]
fn ambient_light_takes_ka_or_everywhere_kd() {
    let folder = folder();
    let kd = Vec3::new(0.5, 0.25, 0.125);
    let nowhere = "[ambient]\ncolor = [1, 1, 1]\n";
    let everywhere = "[ambient]\neverywhere = true\ncolor = [1, 1, 1]\n";
    for (ka, ambient, of_wood, warnings, is_dark) in [
        ("", nowhere, kd, 0, false),
        ("Ka 1 1 1\n", nowhere, Vec3::ONE, 0, false),
        ("Ka 1 1 1\n", everywhere, kd, 0, false),
        ("Ka 0 0 0\n", nowhere, Vec3::ZERO, 1, false),
        ("Ka 0 0 0\n", everywhere, kd, 0, false),
        ("Ka 0 0 0\n", "", Vec3::ZERO, 0, true),
        ("Ka 0 0 0\n", "[ambient]\ncolor = [0, 0, 0]\n", Vec3::ZERO, 0, true),
    ] {
        let mtl = format!("newmtl wood\nKd 0.5 0.25 0.125\n{ka}newmtl clear\nd 0.1\n{ka}");
        std::fs::write(folder.path().join("m.mtl"), mtl).unwrap();
        let shot = load_in(folder.path(), &format!("{ambient}{REST}"), true).unwrap();
        let wood = shot.scene.materials.iter().find(|material| material.name == "wood").unwrap();
        assert_eq!((wood.ambient, wood.diffuse), (of_wood, kd), "{ka}{ambient}");
        let told: Vec<String> = shot.warnings.iter().map(ToString::to_string).collect();
        let (dark, told): (Vec<String>, Vec<String>) =
            told.into_iter().partition(|told| told.contains("nothing gives light"));
        assert_eq!((dark.len(), told.len()), (usize::from(is_dark), warnings), "{told:?}");
        let words = ["s.toml:2:9: ", "Ka is 0", "`everywhere = true`"];
        assert!(told.iter().all(|told| words.iter().all(|word| told.contains(word))), "{told:?}");
    }
}

#[test]
fn still_models_are_baked_and_moving_ones_share_their_mesh() {
    let moving =
        "[[model]]\nobj = \"m.obj\"\n[[model.key]]\nframe = 1\n[[model.key]]\nframe = 2\nscale = 2\n";
    let still = "[[model]]\nname = \"still\"\nobj = \"M.OBJ\"\ntranslate = [0, 0, 3]\nrotate = [0, 0, 90]\n";
    let shot = load(&format!("{REST}{still}{moving}{moving}"));
    let models = &shot.scene.models;
    assert_eq!(models.len(), 4);
    assert!(Arc::ptr_eq(&models[2].mesh, &models[3].mesh) && Arc::ptr_eq(&models[0].mesh, &models[2].mesh));
    assert_eq!(models[1].track, TransformTrack::identity());
    let corner = Vec3::from(models[1].mesh.positions.as_slice()[1]);
    assert!(corner.abs_diff_eq(Vec3::new(0.0, 1.0, 3.0), 1e-6), "{corner}");
    assert_eq!(models[2].track.scale.at(1.5), DVec3::splat(1.5));
}

#[test]
fn clear_triangles_come_last() {
    let shot = load(REST);
    let mesh = &shot.scene.models[0].mesh;
    assert_eq!((mesh.shadow_casting, mesh.triangles.len()), (1, 2));
    let names = mesh.material_of.iter().map(|id| shot.scene.materials[*id as usize].name.as_str());
    assert_eq!(names.collect::<Vec<_>>(), ["wood", "clear"]);
}

#[test]
fn materials_are_overridden_field_by_field() {
    let shot = load(&format!(
        "{REST}[[material]]\nname = \"clear\"\nd = 1\nke = [1, 2, 3]\n[[material]]\nname = \"wood\"\n\
         kd = [1, 0, 0]\nks = [1, 1, 1]\nillum = 3\n"
    ));
    assert!(shot.scene.materials.iter().all(|material| material.metal_rough.is_none()));
    let named = |name: &str| shot.scene.materials.iter().find(|material| material.name == name).unwrap();
    assert_eq!((named("clear").optics, named("clear").emission), (Optics::Opaque, Vec3::new(1.0, 2.0, 3.0)));
    assert_eq!(named("wood").diffuse, Vec3::X);
    assert!(matches!(named("wood").optics, Optics::Mirror { fresnel: false, .. }));
    assert_eq!(shot.scene.models[0].mesh.shadow_casting, 2);
}

#[test]
fn materials_become_metal_rough() {
    let shot = load(&format!("{REST}[[material]]\nname = \"wood\"\nkd = [1, 0.5, 0]\npr = 0.25\npm = 1\n"));
    let wood = shot.scene.materials.iter().find(|material| material.name == "wood").unwrap();
    let metal_rough = wood.metal_rough.unwrap();
    assert_eq!((metal_rough.roughness, metal_rough.metallic), (0.25, 1.0));
    assert_eq!((metal_rough.base, wood.diffuse), (Vec3::new(1.0, 0.5, 0.0), Vec3::ZERO));
}

const LISTS: &str = "[render]
size = [64, 48]
[background]
zenith = [0, 0, 1]
horizon = [1, 1, 1]
ground = [1, 1, 1]
[environment.sky]
ground = [1, 1, 1]
[ambient]
color = [0, 0, 0]
[[camera.key]]
frame = 1
eye = [0, 0, 5]
shift = [0, 1]
target = [0, 0, 0]
[[model]]
obj = \"m.obj\"
scale = [1, 2, 3]
rotate = [0, 0, 0]
translate = [0, 0, 0]
[[model.key]]
frame = 1
translate = [0, 0, 0]
rotate = [0, 0, 0]
scale = [1, 2, 3]
[[light]]
type = \"rectangle\"
position = [0, 9, 0]
target = [0, 0, 0]
size = [1, 1]
color = [1, 1, 1]
[[light.key]]
frame = 1
position = [0, 9, 0]
target = [0, 0, 0]
color = [1, 1, 1]
[[light]]
type = \"directional\"
direction = [0, -1, 0]
[[light.key]]
frame = 1
direction = [0, -1, 0]
[[material]]
name = \"wood\"
kd = [1, 1, 1]
ka = [1, 1, 1]
ks = [1, 1, 1]
ke = [1, 1, 1]
";

#[test]
fn lists_have_as_many_numbers_as_they_must() {
    load(LISTS);
    let color = LISTS.replace("zenith = [0, 0, 1]\nhorizon = [1, 1, 1]\nground", "color");
    let rotation = LISTS.replace("target = [0, 0, 0]\n[[model]]", "rotation = [0, 0, 0]\n[[model]]");
    let mut tried = 0;
    for text in [LISTS, &color, &rotation] {
        load(text);
        let lines: Vec<&str> = text.lines().collect();
        for (at, line) in lines.iter().enumerate() {
            let Some((key, list)) = line.split_once(" = [") else { continue };
            let count = list.split(',').count();
            let longer = list.replace(']', ", 99]");
            let shorter = list.rsplit_once(',').map_or(String::from("]"), |(begin, _)| format!("{begin}]"));
            for (wrong, length) in [(longer.as_str(), count + 1), (&shorter, count - 1), ("]", 0)] {
                let wrong = format!("{key} = [{wrong}");
                let text = [&lines[..at], &[wrong.as_str()], &lines[at + 1..]].concat().join("\n");
                let place = format!("s.toml:{}:{}: `{key}`: ", at + 1, key.len() + 4);
                let expected = format!("{place}invalid length {length}, expected a list of {count} numbers");
                assert!(error(&text).starts_with(&expected), "{wrong}: {}", error(&text));
                tried += 1;
            }
        }
    }
    assert_eq!(tried, 3 * (28 + 26 + 28), "every list of the three shots");
}

#[test]
fn mistakes_are_told_with_place_and_remedy() {
    let camera = "[[camera.key]]\nframe = 1\neye = [0, 0, 5]\n";
    let orbit = "[[camera.key]]\nframe = 1\ntarget = [0, 0, 0]\n";
    let light = format!("{REST}[[light]]\n");
    let orthographic = format!("[camera]\nprojection = \"orthographic\"\n{camera}");
    // falls steeply, and then no more: a smooth curve goes below
    let heights = [(1, 100.0), (11, 0.1), (40, 0.1)].map(|(frame, height)| {
        let key = camera.replace("frame = 1", &format!("frame = {frame}"));
        format!("{key}target = [0, 0, 0]\nheight = {height}\n")
    });
    let overshooting =
        format!("[camera]\nprojection = \"orthographic\"\ninterpolation = \"smooth\"\n{}", heights.concat());
    for (text, expected) in [
        ("[render]\nsise = [1, 2]\n".into(), "s.toml:2:1: unknown key `sise`: did you mean `size`?"),
        (
            "[render]\nsize = [0, 2]\n".into(),
            "s.toml:2:9: `size` is 0: it must be a whole number from 1 to 65535",
        ),
        ("[render]\nsize = [8, \"a\"]\n".into(), "s.toml:2:12: `size`: invalid type: string"),
        ("[render]\nsamples = 17\n".into(), "s.toml:2:11: `samples` is 17"),
        ("[render]\noverscan = -1\n".into(), "s.toml:2:12: `overscan` is -1"),
        ("[render]\noverscan = 16385\n".into(), "s.toml:2:12: `overscan` is 16385"),
        ("[render]\noverscan = 2.5\n".into(), "s.toml:2:12: `overscan`: invalid type"),
        (
            "[render]\nsize = [65000, 1]\noverscan = 300\n".into(),
            "s.toml:3:12: `overscan` makes a picture of 65000x1 longer than 65535 pixels on a side",
        ),
        (
            "[indirect]\npaths = -1\n".into(),
            "s.toml:2:9: `paths` is -1: it must be a whole number from 0 to 1024",
        ),
        ("[indirect]\npaths = 1025\n".into(), "s.toml:2:9: `paths` is 1025"),
        (
            "[occlusion]\nradius = 0\n".into(),
            "s.toml:2:10: `radius` is 0: it must be a length above 0, in the units of the models",
        ),
        ("[occlusion]\nradius = -0.5\n".into(), "s.toml:2:10: `radius` is -0.5: it must be a length above 0"),
        ("[occlusion]\nradius = nan\n".into(), "s.toml:2:10: `radius` is NaN: it must be a length above 0"),
        ("[occlusion]\nradius = inf\n".into(), "s.toml:2:10: `radius` is inf: it must be a length above 0"),
        (
            "[occlusion]\nrays = 0\n".into(),
            "s.toml:2:8: `rays` is 0: it must be a whole number from 1 to 256",
        ),
        (
            "[occlusion]\nrays = 257\n".into(),
            "s.toml:2:8: `rays` is 257: it must be a whole number from 1 to 256",
        ),
        (
            "[render]\nreflections = 65\n".into(),
            "s.toml:2:15: `reflections` is 65: it must be a whole number from 0 to 64",
        ),
        ("[render]\nclamp = 0\n".into(), "s.toml:2:9: `clamp` is 0: it must be a radiance above 0"),
        ("[render]\nclamp = 1e-60\n".into(), "s.toml:2:9: `clamp` is 0."),
        ("[render]\nclamp = inf\n".into(), "s.toml:2:9: `clamp` is inf: it must be a radiance above 0"),
        (
            "[render]\ntree_memory = -1\n".into(),
            "s.toml:2:15: `tree_memory` is -1: it must be a whole number from 0 to 1048576",
        ),
        (
            format!("{REST}[[material]]\nname = \"wood\"\npr = 1.5\n"),
            "s.toml:9:6: `pr` is 1.5: it must be from 0 (smooth) to 1 (rough)",
        ),
        (
            format!("{REST}[[material]]\nname = \"wood\"\npm = nan\n"),
            "s.toml:9:6: `pm` is NaN: it must be from 0 (no metal) to 1 (metal)",
        ),
        ("[indirect]\nbounces = 65\n".into(), "s.toml:2:11: `bounces` is 65"),
        (
            "[indirect]\nbudget = \"half\"\n".into(),
            "s.toml:2:10: `budget` must be `full`, or a number of rays",
        ),
        (
            "[indirect]\nbudget = -1\n".into(),
            "s.toml:2:10: `budget`: it must be `full`, or a number of rays a frame",
        ),
        ("[indirect]\npaths_per_frame = 0\n".into(), "s.toml:2:19: `paths_per_frame`"),
        ("[indirect]\nbounce = 1\n".into(), "s.toml:2:1: unknown key `bounce`: did you mean `bounces`?"),
        ("[render]\nframes = \"9-1\"\n".into(), "s.toml:2:10: `frames`: `9-1` runs backwards"),
        ("[render]\nrate = \"24/0\"\n".into(), "s.toml:2:8: `rate` must be frames per second"),
        ("[render]\nrate = 23.976\n".into(), "s.toml:2:8: `rate`: invalid type: floating point"),
        (
            "[render]\nmode = \"ful\"\n".into(),
            "s.toml:2:8: `mode`: unknown value `ful`: did you mean `full`?",
        ),
        ("[render\n".into(), "s.toml:1:8: "),
        (String::new(), "s.toml: there is no [camera]"),
        ("[camera]\n".into(), "s.toml:1:1: the camera has no keys"),
        (
            "[[camera.key]]\nframe = 1\ntarget = [0, 0, 0]\n".into(),
            "s.toml:1:1: this camera key needs `eye`, or `orbit`",
        ),
        (format!("{orbit}orbit = [0, 91, 2]\n"), "s.toml:4:9: `orbit` is azimuth, elevation (-90 to 90)"),
        (format!("{orbit}orbit = [0, 0, 0]\n"), "s.toml:4:9: `orbit` is azimuth, elevation (-90 to 90)"),
        (
            format!("{orbit}orbit = [0, 0, 2]\neye = [0, 0, 5]\n"),
            "s.toml:5:7: `eye` and `orbit` exclude each other",
        ),
        (
            format!("{orbit}orbit = [0, 0, 2]\n{camera}target = [0, 0, 0]\n").replacen(
                "frame = 1",
                "frame = 2",
                1,
            ),
            "s.toml:6:9: the keys of a camera have either all `eye` or all `orbit`",
        ),
        (
            orbit.replace("target", "rotation") + "orbit = [0, 0, 2]\n",
            "s.toml:4:9: `orbit` goes around the key's `target`",
        ),
        (format!("{REST}[floor]\nheight = inf\n"), "s.toml:8:10: `height` is inf: it must be from -1e18"),
        (format!("{REST}[floor]\nradius = 0\n"), "s.toml:8:10: `radius` is 0: it must be a length above 0"),
        (format!("{REST}[floor]\ncolor = [0, 2, 0]\n"), "s.toml:8:9: `color` is a reflectance"),
        (camera.to_string(), "s.toml:2:9: this camera key needs `target`"),
        (format!("{camera}target = [0, 0, 5]\n"), "s.toml:3:7: `eye` and `target` are the same point"),
        (format!("{camera}target = [0, 0, nan]\n"), "s.toml:4:10: `target` must be three finite numbers"),
        (format!("{camera}target = [0, 0]\n"), "s.toml:4:10: `target`: invalid length 2"),
        (format!("{camera}rotation = [0, 0, 0]\nroll = 1\n"), "s.toml:5:8: `roll` goes with `target`"),
        ("[camera]\nprojection = \"fisheye\"\n".into(), "s.toml:2:14: `projection`: unknown value `fisheye`"),
        (
            format!("{camera}target = [0, 0, 0]\nheight = 2\n"),
            "s.toml:5:10: `height` goes with `projection = \"orthographic\"`",
        ),
        (
            format!("{orthographic}target = [0, 0, 0]\n"),
            "s.toml:4:9: this key of an orthographic camera needs `height`",
        ),
        (
            format!("{orthographic}target = [0, 0, 0]\nheight = 2\nfov = 9\n"),
            "s.toml:8:7: `fov` goes with a perspective camera",
        ),
        (
            format!("{orthographic}target = [0, 0, 0]\nheight = 0\n"),
            "s.toml:7:10: `height` is 0: it must be from 1e-18 to 1e18",
        ),
        (format!("{orthographic}target = [0, 0, 0]\nheight = nan\n"), "s.toml:7:10: `height` is NaN"),
        (format!("{orthographic}target = [0, 0, 0]\nheight = 1e19\n"), "s.toml:7:10: `height` is"),
        (
            format!("{camera}target = [0, 0, 0]\nshift = [0, nan]\n"),
            "s.toml:5:9: `shift` must be two numbers from -100 to 100",
        ),
        (
            format!("{camera}target = [0, 0, 0]\nshift = [101, 0]\n"),
            "s.toml:5:9: `shift` must be two numbers",
        ),
        (format!("{camera}target = [0, 0, 0]\nshift = 1\n"), "s.toml:5:9: `shift`: "),
        (overshooting, "s.toml:1:1: the smooth curve of `height` falls to 0 or below"),
        (
            format!("{camera}target = [0, 0, 0]\nfov = 180\n"),
            "s.toml:5:7: `fov` is 180: it must be from 1e-6 to below 180 degrees",
        ),
        (
            format!("{camera}target = [0, 0, 0]\n{camera}target = [0, 0, 0]\n"),
            "s.toml:6:9: `frame` is 1: there is another key at this frame already",
        ),
        (format!("{camera}target = [0, 0, 0]\n"), "s.toml: there is nothing to see"),
        (format!("{REST}scale = 0\n"), "s.toml:7:9: `scale` must not be zero"),
        (format!("{REST}scale = [1, 1]\n"), "s.toml:7:9: `scale`: invalid length 2"),
        (REST.replace("m.obj", "none.obj"), "s.toml:6:7: `obj`: there is no file `none.obj`"),
        (
            format!("{REST}[output]\nlayers = [\"Z\", \"far\"]\n"),
            "s.toml:8:16: `layers`: there is no layer `far`; there are diffuse",
        ),
        (
            format!("{REST}[output]\ncompression = \"dwaa\"\n"),
            "s.toml:8:15: `compression`: unknown value `dwaa`",
        ),
        (
            format!("{REST}[output]\nexposure = 21\n"),
            "s.toml:8:12: `exposure` is 21: it must be from -20 to 20 stops",
        ),
        (
            format!("{REST}[output]\ndenoise_quality = \"best\"\n"),
            "s.toml:8:19: `denoise_quality`: unknown value `best`",
        ),
        (format!("{light}type = \"point\"\n"), "s.toml:7:1: this light needs the key `position`"),
        (
            format!("{light}type = \"point\"\nposition = [0, 0, 0]\ncone = 3\n"),
            "s.toml:10:8: a point light has no `cone`",
        ),
        (
            format!("{light}type = \"rectangle\"\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nsize = [1, 0]\n"),
            "s.toml:11:8: `size` must be two lengths",
        ),
        (
            format!("{light}type = \"sphere\"\nposition = [0, 0, 0]\nradius = 0\n"),
            "s.toml:10:10: `radius` is 0: it must be a length from 1e-9 to 1e9",
        ),
        (
            format!("{light}type = \"disk\"\nposition = [0, 0, 0]\ntarget = [0, 0, 0]\n"),
            "s.toml:7:1: `position` and `target` of this light are the same point",
        ),
        (
            format!("{light}type = \"directional\"\ndirection = [0, 0, 1]\nangle = 180\n"),
            "s.toml:10:9: `angle` is 180: it must be from 0 to below 180 degrees",
        ),
        (
            format!("{light}type = \"point\"\nposition = [0, 0, 0]\nradius = 1\n"),
            "s.toml:10:10: a point light has no `radius`",
        ),
        (
            format!("{light}type = \"spot\"\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nsize = [1, 1]\n"),
            "s.toml:11:8: a spot light has no `size`",
        ),
        (
            format!("{light}type = \"directional\"\ndirection = [0, 0, 0.0]\n"),
            "s.toml:9:13: `direction` must not be zero",
        ),
        (format!("{light}type = \"lamp\"\n"), "s.toml:8:8: `type`: unknown value `lamp`"),
        (
            format!("{light}type = \"point\"\nposition = [0, 0, 0]\npower = -1\n"),
            "s.toml:10:9: `power` is -1: it must be finite, not negative, and 1e30 at most",
        ),
        (
            format!("{REST}[[material]]\nname = \"wod\"\n"),
            "s.toml:8:8: no model has a material `wod`: did you mean `wood`?",
        ),
        (format!("{REST}[[material]]\nname = \"wood\"\nkd = [-1, 0, 0]\n"), "s.toml:9:6: `kd` is a colour"),
        (
            format!("{REST}[[material]]\nname = \"wood\"\nkd = [1, 7e4, 0]\n"),
            "s.toml:9:6: `kd` is too large: 65504",
        ),
        (format!("[background]\ncolor = [0, 0, 0]\nground = [0, 0, 0]\n{REST}"), "s.toml:2:9: `color` and"),
        (format!("[output]\npath = \"\"\n{REST}"), "s.toml:2:8: `path` is empty"),
        (
            format!("[environment]\npower = 1\n{REST}"),
            "s.toml:1:1: the environment needs `map` or `sky`: without them it is the [background]",
        ),
        (
            format!("[environment]\nsamples = 65\nsky = {{}}\n{REST}"),
            "s.toml:2:11: `samples` is 65: it must be",
        ),
        (format!("[environment]\nmpa = \"a\"\n{REST}"), "s.toml:2:1: unknown key `mpa`: did you mean `map`?"),
        (
            format!("[environment]\nmap = \"a.hdr\"\n{REST}"),
            "s.toml:2:7: `map`: there is no file `a.hdr` in ",
        ),
        (
            format!("[environment]\nmap = \"a.hdr\"\nsky = {{}}\n{REST}"),
            "s.toml:2:7: `map` and `sky` exclude each other",
        ),
        (format!("[environment]\nmap = 3\n{REST}"), "s.toml:2:7: `map`: invalid type"),
        (format!("[environment]\nsky = 3\n{REST}"), "s.toml:2:7: `sky`: invalid type"),
        (format!("[environment]\nsky = {{}}\nvisible = 1\n{REST}"), "s.toml:3:11: `visible`: invalid type"),
        (
            format!("[environment]\nsky = {{}}\npower = -1\n{REST}"),
            "s.toml:3:9: `power` is -1: it must be finite and not negative",
        ),
        (format!("[environment]\nsky = {{}}\npower = 1e39\n{REST}"), "s.toml:3:9: `power` is 1"),
        (
            format!("[environment]\nsky = {{}}\nrotation = inf\n{REST}"),
            "s.toml:3:12: `rotation` is inf: it must be finite",
        ),
        (
            format!("[environment]\nsky = {{}}\nrotation = \"a\"\n{REST}"),
            "s.toml:3:12: `rotation`: invalid type",
        ),
        (
            format!("[environment.sky]\nelevation = 91\n{REST}"),
            "s.toml:2:13: `elevation` is 91: it must be from -6 to 90 degrees",
        ),
        (
            format!("[environment.sky]\nturbidity = 1.5\n{REST}"),
            "s.toml:2:13: `turbidity` is 1.5: it must be from 2 to 10",
        ),
        (format!("[environment.sky]\nazimuth = nan\n{REST}"), "s.toml:2:11: `azimuth` is NaN"),
        (format!("[environment.sky]\nground = [0, 2, 0]\n{REST}"), "s.toml:2:10: `ground` is an albedo"),
        (format!("[environment.sky]\nground = [0, -1, 0]\n{REST}"), "s.toml:2:10: `ground` is a colour"),
        (
            format!("[environment.sky]\nturbidty = 3\n{REST}"),
            "s.toml:2:1: unknown key `turbidty`: did you mean `turbidity`?",
        ),
    ] {
        let message = error(&text);
        assert!(message.starts_with(expected), "for\n{text}\nexpected {expected}\ngot      {message}");
    }
}

#[test]
fn missing_files_are_stand_ins_or_strict_errors() {
    let (folder, lit) = (folder(), format!("[ambient]\ncolor = [1, 1, 1]\n{REST}"));
    std::fs::write(
        folder.path().join("m.mtl"),
        "newmtl wood\nmap_Kd a.png\nnewmtl clear\nmap_Kd -s 2 a.png\n",
    )
    .unwrap();
    let shot = load_in(folder.path(), &lit, false).unwrap();
    assert_eq!(shot.warnings.len(), 1, "one a file: {:?}", shot.warnings);
    assert!(shot.warnings[0].to_string().contains("m.mtl:4: the texture `a.png` cannot be found"));
    let [first, second] = shot.scene.textures.as_slice() else { unreachable!("two ways to use the file") };
    assert!(Arc::ptr_eq(&first.texels, &second.texels));
    assert!(load_in(folder.path(), &lit, true).is_err());
    std::fs::write(folder.path().join("a.png"), "no picture").unwrap();
    let shot = load_in(folder.path(), &lit, false).unwrap();
    assert!(shot.warnings[0].to_string().contains("cannot be read"), "{:?}", shot.warnings);
    std::fs::write(folder.path().join("a.png"), "#?RADIANCE\n\n-Y 1 +X 1\n\0\0\0\0").unwrap();
    let shot = load_in(folder.path(), &lit, false).unwrap();
    assert!(shot.warnings[0].to_string().contains("is a Radiance picture"), "{:?}", shot.warnings);
    std::fs::remove_file(folder.path().join("m.mtl")).unwrap();
    let shot = load_in(folder.path(), &lit, false).unwrap();
    assert_eq!(shot.warnings.len(), 1, "{:?}", shot.warnings);
    assert!(shot.warnings[0].to_string().contains("m.obj:1: the material file `m.mtl` cannot be found"));
}

#[test]
fn pictures_are_read_and_sampled() {
    let folder = folder();
    let mut picture = image::RgbImage::new(2, 1);
    picture.put_pixel(0, 0, image::Rgb([255, 0, 0]));
    picture.put_pixel(1, 0, image::Rgb([0, 0, 255]));
    picture.save(folder.path().join("Red.png")).unwrap();
    std::fs::write(folder.path().join("m.mtl"), "newmtl wood\nmap_Kd maps\\red.PNG\nnewmtl clear\n").unwrap();
    let shot = load_in(folder.path(), REST, true).unwrap();
    assert_eq!(shot.scene.textures[0].sample(glam::Vec2::new(0.25, 0.5)), Vec3::X);
}

#[test]
fn a_floor_lies_under_the_models() {
    let floor = "[floor]\nheight = -0.5\ncolor = [0.1, 0.2, 0.3]\n";
    let shot = load(&format!("{REST}translate = [7, 0, 0]\n{floor}"));
    let model = shot.scene.models.last().unwrap();
    let (low, high) = model.mesh.bounds();
    let middle = (low + high) * 0.5;
    assert!(middle.abs_diff_eq(glam::DVec3::new(7.5, -0.5, 0.0), 1e-5), "{middle}");
    assert!(low.y == -0.5 && high.y == -0.5 && (high - low).x > 80.0 * 2.0_f64.sqrt() - 1e-3);
    let material = &shot.scene.materials[usize::from(model.mesh.material_of[0])];
    assert_eq!((material.diffuse, model.name.as_str()), (Vec3::new(0.1, 0.2, 0.3), "floor"));
    // seen from above
    let [a, b, c] = model.mesh.triangles[0].map(|i| Vec3::from(model.mesh.positions.as_slice()[i as usize]));
    assert!((b - a).cross(c - a).y > 0.0);
    // what depends on the size of the models does not depend on the floor's
    let without = load(&format!("{REST}translate = [7, 0, 0]\n"));
    assert_eq!(shot.settings.occlusion_radius, without.settings.occlusion_radius);
}

#[test]
fn bare_models_turn_in_front_of_the_camera() {
    let folder = folder();
    let shot = scene::load(&folder.path().join("m.obj"), true).unwrap();
    assert_eq!((shot.frames.list().len(), shot.settings.samples, shot.scene.lights.len()), (120, 2, 2));
    for frame in [1, 31, 120] {
        let camera = Pose::new(&shot.scene, frame).camera;
        let seen = camera.world_to_ndc(16.0 / 9.0);
        for corner in shot.scene.models[0].mesh.positions.as_slice() {
            let ndc = seen.project_point3(Vec3::from(*corner));
            assert!(ndc.x.abs() < 1.0 && ndc.y.abs() < 1.0, "{frame}: {ndc}");
        }
    }
}

#[test]
fn other_files_are_refused() {
    let folder = folder();
    let message = |name: &str| scene::load(&folder.path().join(name), false).unwrap_err().to_string();
    assert!(message("m.mtl").contains("not a file that can be rendered"));
    assert!(message("none.obj").contains("none.obj: the OBJ file cannot be read"));
    assert!(message("none.toml").contains("none.toml: the shot file cannot be read"));
}

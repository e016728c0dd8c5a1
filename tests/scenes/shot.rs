//! Shot files: what they mean.

use std::sync::Arc;

use afterimage::animation::TransformTrack;
use afterimage::layers::Layers;
use afterimage::pose::{AreaShape, LightPose, LightShape, Pose};
use afterimage::scene::camera::{Lens, Projection};
use afterimage::scene::cutout::Asks;
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
    let Lens { height, shift, aperture, focus, near, far } = &shot.scene.camera.lens;
    assert!([height, aperture, focus, near, far].into_iter().all(Option::is_none));
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
    let LightKind::Spot { cone, soft, .. } = &spot.kind else { unreachable!("a spot") };
    assert_eq!((cone.at(1.0), soft.at(1.0)), (30.0, 0.5));
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
        let expected = 0.1 * (width.powi(2) + 1.0).sqrt();
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
    let corner = Vec3::from(models[1].mesh.triangles().positions.as_slice()[1]);
    assert!(corner.abs_diff_eq(Vec3::new(0.0, 1.0, 3.0), 1e-6), "{corner}");
    assert_eq!(models[2].track.scale.at(1.5), DVec3::splat(1.5));
}

#[test]
fn clear_triangles_come_last() {
    let shot = load(REST);
    let mesh = &shot.scene.models[0].mesh;
    assert_eq!((mesh.shadow_casting, mesh.count()), (1, 2));
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
fn filters_tint_what_glass_lets_through() {
    let glass = |keys: &str| {
        let shot = load(&format!(
            "{REST}[[material]]\nname = \"wood\"\nillum = 7\nni = 1.5\nks = [1, 1, 1]\n{keys}"
        ));
        shot.scene.materials.iter().find(|material| material.name == "wood").unwrap().clone()
    };
    let tinted = glass("kd = [0, 0, 0]\ntf = [0.25, 1, 0.5]\n");
    let transmission = Vec3::new(0.25, 1.0, 0.5);
    assert_eq!(tinted.optics, Optics::clear(transmission, 1.5, Vec3::ONE));
    // what it does not let through it scatters
    let half = glass("kd = [1, 0, 0]\ntf = [0.25, 0.5, 0.5]\n");
    assert_eq!(half.diffuse, Vec3::new(0.5, 0.0, 0.0));
    // which says nothing of total reflection
    let total = |material: afterimage::scene::Material| match material.optics {
        Optics::Glass { total, .. } => total,
        other => panic!("{other:?}"),
    };
    assert_eq!(total(half), Vec3::ONE);
    assert_eq!(total(glass("tf = [0.5, 0.5, 0.5]\nks_total = [0.5, 0.25, 0]\n")), Vec3::new(0.5, 0.25, 0.0));
    let part = load(&format!("{REST}[[material]]\nname = \"wood\"\ntransmission = 0.25\nni = 1.5\n"));
    let part = part.scene.materials.into_iter().find(|material| material.name == "wood").unwrap();
    assert_eq!(total(part), Vec3::splat(0.25));
}

#[test]
fn rectangles_have_a_direction_of_their_height() {
    let light = "[[light]]\ntype = \"rectangle\"\nposition = [0, 0, 0]\ntarget = [0, 0, -1]\nsize = [2, 1]\n";
    let keys = "[[light.key]]\nframe = 1\nup = [0, 1, 0]\n[[light.key]]\nframe = 3\nup = [1, 0, 0]\n";
    let edge = |keys: &str, frame: f64| {
        let shot = load(&format!("{REST}{light}{keys}"));
        let shape = LightPose::new(&shot.scene.lights[0], frame).shape;
        let LightShape::Area(AreaShape::Rectangle { across, up, .. }) = shape else { panic!("{shape:?}") };
        assert!((across.length() - 2.0).abs() < 1e-6 && across.dot(up).abs() < 1e-6);
        up
    };
    assert!(edge("", 1.0).abs_diff_eq(Vec3::Y, 1e-6));
    assert!(edge("up = [1, 1, 5]\n", 1.0).abs_diff_eq(Vec3::new(0.5, 0.5, 0.0).normalize(), 1e-6));
    assert!(edge(keys, 3.0).abs_diff_eq(Vec3::X, 1e-6));
    assert!(edge(keys, 2.0).abs_diff_eq(Vec3::new(0.5, 0.5, 0.0).normalize(), 1e-6));
}

#[test]
fn materials_become_metal_rough() {
    let shot = load(&format!("{REST}[[material]]\nname = \"wood\"\nkd = [1, 0.5, 0]\npr = 0.25\npm = 1\n"));
    let wood = shot.scene.materials.iter().find(|material| material.name == "wood").unwrap();
    let metal_rough = wood.metal_rough.unwrap();
    assert_eq!((metal_rough.roughness, metal_rough.metallic), (0.25, 1.0));
    assert_eq!((metal_rough.base, wood.diffuse), (Vec3::new(1.0, 0.5, 0.0), Vec3::ZERO));
}

#[test]
fn pictures_are_read_and_sampled() {
    let mut picture = image::RgbImage::new(2, 1);
    picture.put_pixel(0, 0, image::Rgb([255, 0, 0]));
    picture.put_pixel(1, 0, image::Rgb([0, 0, 255]));
    for format in ["png", "tif", "webp", "bmp", "tga"] {
        let folder = folder();
        picture.save(folder.path().join(format!("Red.{format}"))).unwrap();
        let named = format!("newmtl wood\nmap_Kd maps\\red.{}\nnewmtl clear\n", format.to_uppercase());
        std::fs::write(folder.path().join("m.mtl"), named).unwrap();
        let shot = load_in(folder.path(), REST, true).unwrap();
        assert_eq!(shot.scene.textures[0].color(glam::Vec2::new(0.25, 0.5), 0), Vec3::X, "{format}");
    }
}

/// Of `map_d`, of the alpha of `map_Kd` and of a table of the shot file.
#[test]
fn opacity_cuts_surfaces_out() {
    let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n\
               usemtl wood\nf 1/1 2/2 3/3\nusemtl clear\nf 2/2 4/4 3/3\n";
    let cut_of = |mtl: &str, obj: &str, more: &str| {
        let folder = folder();
        let image = |texels: [[u8; 4]; 2]| image::RgbaImage::from_raw(2, 1, texels.concat()).unwrap();
        let save = |name: &str, texels| image(texels).save(folder.path().join(name)).unwrap();
        save("grey.png", [[255, 255, 255, 255], [100, 100, 100, 255]]);
        save("alpha.png", [[0, 0, 0, 255], [200, 0, 0, 100]]);
        save("nothing.png", [[255, 0, 0, 0], [0, 255, 0, 0]]);
        std::fs::write(folder.path().join("m.mtl"), mtl).unwrap();
        std::fs::write(folder.path().join("m.obj"), obj).unwrap();
        let shot = load_in(folder.path(), &format!("{REST}{more}"), true).unwrap();
        let mesh = &shot.scene.models[0].mesh;
        mesh.cut.as_ref().map(|cut| {
            let names = cut.range().map(|triangle| {
                let material = usize::from(mesh.material_of[triangle]);
                shot.scene.materials[material].name.clone()
            });
            let names: Vec<String> = names.collect();
            let places = [0.25, 0.75]
                .map(|u| cut.masks[0].is_there((0, glam::Vec2::new(u, 0.5)), Asks::Sight, || 1.0));
            (names, places)
        })
    };
    let cut = |names: &[&str]| Some((names.iter().map(|name| name.to_string()).collect(), [true, false]));
    let clear = "newmtl clear\n";
    for (wood, expected) in [
        ("map_d grey.png", cut(&["wood"])),
        ("map_d alpha.png", cut(&["wood"])),
        ("map_Kd alpha.png", cut(&["wood"])),
        // that of the statement counts
        ("map_Kd grey.png\nmap_d alpha.png", cut(&["wood"])),
        ("map_Kd grey.png", None),
        // an alpha that nobody looked at
        ("map_Kd nothing.png", None),
    ] {
        assert_eq!(cut_of(&format!("newmtl wood\n{wood}\n{clear}"), obj, ""), expected, "{wood}");
    }
    // whole ones first, clear ones last
    let mtl = "newmtl wood\nmap_d grey.png\nnewmtl clear\nd 0.2\nmap_d grey.png\n";
    assert_eq!(cut_of(mtl, obj, ""), cut(&["wood", "clear"]));
    let table = "[[material]]\nname = \"clear\"\nmap_d = \"grey.png\"\n";
    assert_eq!(cut_of(&format!("newmtl wood\n{clear}"), obj, table), cut(&["clear"]));
    let without = obj.replace("/1", "").replace("/2", "").replace("/3", "").replace("/4", "");
    assert_eq!(cut_of(mtl, &without, ""), None, "nothing says where the holes are");
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
    let [a, b, c] = model.mesh.triangles().positions_of(0);
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
        for corner in shot.scene.models[0].mesh.triangles().positions.as_slice() {
            let ndc = seen.project_point3(Vec3::from(*corner));
            assert!(ndc.x.abs() < 1.0 && ndc.y.abs() < 1.0, "{frame}: {ndc}");
        }
    }
}

//! Is every key of cameras read, and what does it do?

use std::fs;

use afterimage::exposure::Curve;
use afterimage::pose::Pose;
use afterimage::scene::camera::Projection;
use glam::Vec3;

use crate::small_shot::*;

#[test]
fn cameras_are_orthographic_and_lenses_are_shifted() {
    let key = |frame: i32, more: &str| {
        format!("[[camera.key]]\nframe = {frame}\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n{more}")
    };
    let orthographic = |keys: &str, more: &str| {
        load(&format!("[camera]\nprojection = \"orthographic\"\n{keys}[[model]]\nobj = \"m.obj\"\n{more}"))
    };
    let keys =
        [key(1, "height = 4\nshift = [0.5, -0.25]\n"), key(3, ""), key(5, "height = 2\nshift = [0, 0]\n")];
    let camera = orthographic(&keys.concat(), "").scene.camera;
    assert_eq!(camera.projection(), Projection::Orthographic);
    assert_eq!([1.0, 3.0, 4.0, 5.0].map(|frame| camera.half_height(frame)), [2.0, 2.0, 1.5, 1.0]);
    assert_eq!([1.0, 3.0, 4.0, 5.0].map(|frame| camera.lens.shift[1].at(frame)), [-0.25, -0.25, -0.125, 0.0]);
    assert_eq!(camera.lens.shift[0].at(2.0), 0.5);
    // what is tiny is rendered at another scale, and sees as much
    let key = key(1, "height = 1e-7\n").replace("[0, 0, 5]", "[0, 0, 5e-7]");
    let shot = orthographic(&key, "scale = 1e-7\n");
    let space = shot.scene.space;
    assert!(!space.is_of_files());
    let pose = Pose::new(&shot.scene, 1).camera;
    assert!((pose.half_height / space.length(0.5e-7) - 1.0).abs() < 1e-5);
    assert!((space.camera_of_files(&pose).half_height / 0.5e-7 - 1.0).abs() < 1e-5);
}

#[test]
fn cameras_cut_without_passing_between() {
    let shot = load(
        "[camera]\ninterpolation = \"smooth\"\n\
         [[camera.key]]\nframe = 1\neye = [0, 0, 5]\nrotation = [0, 0, 0]\nfov = 30\n\
         [[camera.key]]\nframe = 5\neye = [4, 0, 5]\nrotation = [0, 90, 0]\n\
         [[camera.key]]\nframe = 11\neye = [90, 0, 5]\nrotation = [0, 0, 0]\ncut = true\n\
         [[model]]\nobj = \"m.obj\"\n",
    );
    let camera = &shot.scene.camera;
    assert_eq!(camera.cuts, [11]);
    let eye = |frame| camera.eye.at(frame).x;
    assert_eq!((eye(3.0), eye(5.0), eye(10.0), eye(11.0)), (2.0, 4.0, 4.0, 90.0));
    assert_eq!(camera.fov.at(11.0), 30.0);
    assert!(Pose::new(&shot.scene, 7).camera.forward.abs_diff_eq(Vec3::NEG_X, 1e-6));
}

#[test]
fn orbits_go_around_their_target() {
    let key = |frame: i32, azimuth: i32, more: &str| {
        format!("[[camera.key]]\nframe = {frame}\norbit = [{azimuth}, 30, 2]\ntarget = [1, 2, 3]\n{more}")
    };
    let model = "[[model]]\nobj = \"m.obj\"\n";
    let shot = load(&(key(1, 0, "") + &key(13, 360, "") + &key(17, 90, "cut = true\n") + model));
    let camera = &shot.scene.camera;
    let place = |frame: f64| camera.eye.at(frame) - glam::DVec3::new(1.0, 2.0, 3.0);
    let (out, up) = (3.0_f64.sqrt(), 1.0);
    for (frame, x, z) in
        [(1.0, 0.0, out), (4.0, out, 0.0), (7.0, 0.0, -out), (10.0, -out, 0.0), (16.0, 0.0, out)]
    {
        assert!(place(frame).abs_diff_eq(glam::DVec3::new(x, up, z), 1e-9), "{frame}: {}", place(frame));
    }
    assert_eq!(place(13.0), place(1.0), "a whole turn ends where it began");
    let is_on_arc = |quarter: i32| (place(f64::from(quarter) / 4.0).length() - 2.0).abs() < 1e-9;
    assert!((4..=52).all(is_on_arc), "exposures between frames see it on the arc, too");
    assert!(camera.cuts == [17] && place(17.0).abs_diff_eq(glam::DVec3::new(out, up, 0.0), 1e-9));
}

#[test]
fn lenses_have_an_opening_and_a_focus() {
    let shot = |first: &str, second: &str| {
        load(&format!(
            "[[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n{first}\n\
             [[camera.key]]\nframe = 3\neye = [0, 0, 4]\ntarget = [0, 0, 0]\n{second}\n[[model]]\nobj = \"m.obj\"\n"
        ))
    };
    let at = |shot: &afterimage::scene::Shot, frame| {
        shot.scene.camera.lens_at(frame).map(|lens| (lens.radius, lens.focus))
    };
    let lens = shot("aperture = 0.25", "");
    assert!(lens.scene.camera.has_lens());
    assert_eq!(
        [1.0, 2.0, 3.0].map(|frame| at(&lens, frame)),
        [(0.25, 5.0), (0.25, 4.5), (0.25, 4.0)].map(Some)
    );
    let lens = shot("", "aperture = 0.5\nfocus = 2");
    assert_eq!(
        [1.0, 2.0, 3.0].map(|frame| at(&lens, frame)),
        [(0.0, 5.0), (0.25, 3.5), (0.5, 2.0)].map(Some)
    );
    assert!(!shot("aperture = 0", "").scene.camera.has_lens() && at(&shot("", ""), 1.0).is_none());
    // what is tiny is rendered at another scale, with its lens
    let tiny = load(
        "[[camera.key]]\nframe = 1\neye = [0, 0, 5e-7]\ntarget = [0, 0, 0]\naperture = 1e-8\n\
         [[model]]\nobj = \"m.obj\"\nscale = 1e-7\n",
    );
    let (radius, focus) = at(&tiny, 1.0).unwrap();
    assert!(!tiny.scene.space.is_of_files() && (focus / radius - 50.0).abs() < 1e-9);
    assert!((radius / f64::from(tiny.scene.space.length(1e-8)) - 1.0).abs() < 1e-5);
}

#[test]
fn clipping_planes_have_keys() {
    let shot = |[first, second, third]: [&str; 3]| {
        let key = |frame: u32, more: &str| {
            format!("[[camera.key]]\nframe = {frame}\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n{more}\n")
        };
        // planes that cut nothing off would be taken out
        let model = "[[model]]\nquadric = { type = \"sphere\", radius = 9 }\n";
        load(&format!("{}{}{}{model}", key(1, first), key(3, second), key(5, third)))
    };
    let at = |shot: &afterimage::scene::Shot| {
        let clip = |frame| afterimage::pose::Pose::new(&shot.scene, frame).camera.clip;
        [1, 2, 3, 4, 5].map(|frame| (clip(frame).near, clip(frame).far))
    };
    assert_eq!(at(&shot(["", "", ""])), [(0.0, f32::INFINITY); 5]);
    let keyed = shot(["near = 1", "near = 2\nfar = 8", "far = 4"]);
    assert_eq!(at(&keyed), [(1.0, 8.0), (1.5, 8.0), (2.0, 8.0), (2.0, 6.0), (2.0, 4.0)]);
    let crossed = error(
        "[camera]\ninterpolation = \"smooth\"\n[[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nnear = 1\nfar = 9\n\
         [[camera.key]]\nframe = 2\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nfar = 1.1\n\
         [[camera.key]]\nframe = 5\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nfar = 1.2\n[[model]]\nobj = \"m.obj\"\n",
    );
    assert!(crossed.contains("leave nothing between them at frame"), "{crossed}");
    // what is tiny is rendered at another scale, with its planes
    let tiny = load(
        "[[camera.key]]\nframe = 1\neye = [0, 0, 5e-7]\ntarget = [0, 0, 0]\nfar = 1e-6\n\
         [[model]]\nquadric = { type = \"sphere\", radius = 9 }\nscale = 1e-7\n",
    );
    assert!((at(&tiny)[0].1 / tiny.scene.space.length(1e-6) - 1.0).abs() < 1e-5);
}

/// Distances of the planes that are kept, of a camera at (0, 1, 8) that looks along -Z.
fn kept(camera: &str, more: &str) -> [Option<f64>; 2] {
    let folder = folder();
    // a room with an open top, and a triangle that stands in the middle
    let room = "v -9 0 -9\nv 9 0 -9\nv 9 0 9\nv -9 0 9\nv -9 5 -9\nv 9 5 -9\nv 9 5 9\nv -9 5 9\nf 4 3 2 1\nf 1 2 6 5\nf 3 4 8 7\n";
    fs::write(folder.path().join("room.obj"), room).unwrap();
    fs::write(folder.path().join("one.obj"), "v -1 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n").unwrap();
    let key = "[[camera.key]]\nframe = 1\neye = [0, 1, 8]\nrotation = [0, 0, 0]";
    let kind = if camera.contains("height") { "orthographic" } else { "perspective" };
    let text = format!("[camera]\nprojection = \"{kind}\"\n{key}\n{camera}\n{more}");
    let lens = load_in(folder.path(), &text, true).unwrap().scene.camera.lens;
    [lens.near, lens.far].map(|plane| plane.map(|plane| plane.at(1.0)))
}

#[test]
fn clipping_planes_stay_where_they_cut_anything_off() {
    let one = "[[model]]\nobj = \"one.obj\"\n";
    let room = "[[model]]\nobj = \"room.obj\"\n";
    let moving = format!(
        "{one}[[model.key]]\nframe = 1\ntranslate = [0, 0, 0]\n[[model.key]]\nframe = 9\ntranslate = [0, 0, 7.95]\n"
    );
    let ball = "[[model]]\nquadric = { type = \"sphere\" }\ntranslate = [0, 1, 8]\n";
    let plane = "[[model]]\nquadric = { type = \"plane\" }\n";
    let to = |z: f64| format!("\n[[camera.key]]\nframe = 40\neye = [0, 1, {z}]\nrotation = [0, 0, 0]\n");
    for (camera, models, wanted) in [
        ("near = 0.1\nfar = 100", one, [None, None]),
        ("near = 0.1\nfar = 7", one, [None, Some(7.0)]),
        ("near = 8.1\nfar = 100", one, [Some(8.1), None]),
        // the box around the room holds the eye, and no wall is near it
        ("near = 0.1\nfar = 100", room, [None, None]),
        ("near = 4\nfar = 16", room, [Some(4.0), Some(16.0)]),
        ("near = 0.1\nfar = 9", &moving, [Some(0.1), None]),
        ("near = 0.1", ball, [Some(0.1), None]),
        ("near = 0.1\nfar = 1000", plane, [None, Some(1000.0)]),
        (&format!("near = 0.1\nfar = 20{}", to(21.0)), one, [None, Some(20.0)]),
        (&format!("near = 0.3\nfar = 90{}", to(-1.0)), one, [Some(0.3), None]),
    ] {
        assert_eq!(kept(camera, models), wanted, "{camera}\n{models}");
    }
    let parallel = |planes: &str| kept(&format!("height = 4\n{planes}"), one);
    assert_eq!(parallel("near = 0.1\nfar = 100"), [None, None]);
    assert_eq!(parallel("near = 8.5\nfar = 100"), [Some(8.5), None]);
}

#[test]
fn lenses_and_shutters_that_make_no_sense_are_told_with_their_place() {
    let key = |more: &str| {
        let text = format!("[[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n{more}\n");
        error(&format!("{text}[[model]]\nobj = \"m.obj\"\n"))
    };
    for (more, words) in [
        ("aperture = -1", ["s.toml:5:", "from 0 to 1e18"]),
        ("aperture = nan", ["s.toml:5:", "from 0 to 1e18"]),
        ("aperture = 1\nfocus = 0", ["s.toml:6:", "from 1e-18"]),
        ("focus = 3", ["s.toml:5:", "goes with `aperture`"]),
        ("aperture = 51", ["s.toml:5:", "10 times the distance at most"]),
        ("aperture = 1\nfocus = 0.05", ["s.toml:5:", "10 times"]),
        ("near = -1", ["s.toml:5:", "a distance of up to 1e18"]),
        ("far = 0", ["s.toml:5:", "a distance of up to 1e18"]),
        ("far = nan", ["s.toml:5:", "a distance of up to 1e18"]),
        ("near = 2\nfar = 2", ["s.toml:2:", "must be below `far`"]),
    ] {
        let error = key(more);
        assert!(words.iter().all(|word| error.contains(word)), "{more}: {error}");
    }
    let text = "[[camera.key]]\nframe = 1\neye = [0, 0, 5]\nrotation = [0, 0, 0]\naperture = 1\n[[model]]\nobj = \"m.obj\"\n";
    assert!(error(text).contains("needs `focus`"), "{}", error(text));
    let text = text.replace("rotation", "height = 2\nrotation").replace("aperture", "focus = 1\naperture");
    let orthographic = error(&format!("[camera]\nprojection = \"orthographic\"\n{text}"));
    assert!(orthographic.contains("s.toml:9:") && orthographic.contains("perspective"), "{orthographic}");
    for (keys, word) in [
        ("open = 0.5\nclose = 0", "before it opens"),
        ("open = -0.6\nclose = 0.6", "360 degrees"),
        ("close = 2", "from -1 to 1"),
        ("open = nan", "from -1 to 1"),
    ] {
        let error = error(&format!("[shutter]\n{keys}\n{REST}"));
        assert!(error.starts_with("s.toml:1:") && error.contains(word), "{keys}: {error}");
    }
    for (curve, word) in [
        ("[]", "two points"),
        ("[[0.5, 1]]", "two points"),
        ("[[0, 0], [1, 0]]", "never opens"),
        ("[[0, 1], [1, -1]]", "[1, -1]"),
        ("[[0, 1], [1, nan]]", "NaN"),
        ("[[0, 1], [2, 1]]", "[2, 1]"),
        ("[[1, 1], [0, 0.5]]", "in the order of time"),
        ("[[0, 1, 2], [1, 1, 2]]", "a list of 2 numbers"),
        ("1", "sequence"),
    ] {
        let error = error(&format!("[shutter]\nopen = 0\ncurve = {curve}\n{REST}"));
        assert!(error.starts_with("s.toml:3:") && error.contains(word), "{curve}: {error}");
    }
    let curved = load(&format!("[shutter]\ncurve = [[0, 1], [1, 0]]\n{REST}")).settings.shutter.unwrap();
    assert_eq!(curved.curve, Curve::through(vec![[0.0, 1.0], [1.0, 0.0]]).unwrap());
    assert!(!curved.curve.is_constant() && (curved.open, curved.close) == (-0.25, 0.25));
    for exposures in ["0", "257", "1.5"] {
        let error = error(&format!("[render]\nexposures = {exposures}\n{REST}"));
        assert!(error.starts_with("s.toml:2:"), "{error}");
    }
    let shutter = load(&format!("[shutter]\nopen = 0\n{REST}")).settings.shutter.unwrap();
    assert_eq!((shutter.open, shutter.close), (0.0, 0.25));
}

//! Does a new take begin afresh, whether the shot says so or shows it?

use std::fs;

use afterimage::frame::Renderer;
use afterimage::settings::{Mode, Settings};
use glam::DVec3;
use openexr::ReadImage;
use serde_json::Value;

use crate::runs::{Place, Ran, assert_same, whole};
use crate::small_shot;
use crate::toy;
use crate::toy::worlds::*;

const CAMERA: &str = "[[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0.5, 0.5, 0]\n\
    [[camera.key]]\nframe = 8\neye = [1, 0, 4]\ntarget = [0.5, 0.5, 0]\n[[model]]\nobj = \"m.obj\"\n";

/// A folder with a shot of eight frames, in which `render` adds keys.
fn place(render: &str) -> Place {
    let place = Place::new();
    fs::write(place.path("m.obj"), small_shot::OBJ).unwrap();
    fs::write(place.path("m.mtl"), small_shot::MTL).unwrap();
    let shot =
        format!("[render]\nsize = [48, 32]\nframes = \"1-8\"\nmode = \"reproject\"\n{render}\n{CAMERA}");
    fs::write(place.path("s.toml"), shot).unwrap();
    place
}

fn render(place: &Place, options: &str) -> Ran {
    let options = format!("--layers motion,forward,backward,status --progress none {options}");
    Ran::new(place.command("s.toml", &options).output().unwrap()).done()
}

/// Of each frame of `a.json`: whether it is a base frame, and whether it is told to be a cut.
fn told(place: &Place) -> Vec<(bool, bool)> {
    let stats: Value = serde_json::from_slice(&fs::read(place.path("a.json")).unwrap()).unwrap();
    let frames = stats["frames"].as_array().unwrap().iter();
    frames.map(|frame| (frame["mode"] == "base", frame["cut"] == true)).collect()
}

fn moves(frame: &ReadImage, layer: &str) -> bool {
    let mut planes = frame.channels.iter().filter(|channel| channel.name.starts_with(layer)).peekable();
    assert!(planes.peek().is_some());
    planes.any(|plane| plane.data.iter().any(|value| *value != 0.0))
}

#[test]
fn a_marked_cut_is_a_base_frame_and_no_motion_leads_across_it() {
    for (keys, cuts) in [("", vec![]), ("cuts = [4]", vec![4]), ("cuts = [7, 4, 4]", vec![4, 7])] {
        let place = place(keys);
        render(&place, "-o a.####.exr --stats a.json");
        let expected = (1..=8).map(|frame| (frame == 1 || cuts.contains(&frame), cuts.contains(&frame)));
        assert_eq!(told(&place), expected.collect::<Vec<_>>(), "{keys}");
        for frame in 2..8 {
            let image = whole(&place.path(&format!("a.{frame:04}.exr")));
            assert_eq!(moves(&image, "backward"), !cuts.contains(&frame), "{keys}: to frame {frame}");
            assert_eq!(moves(&image, "forward"), !cuts.contains(&(frame + 1)), "{keys}: from frame {frame}");
        }
    }
}

#[test]
fn chunks_meet_at_cuts_as_anywhere() {
    let place = place("cuts = [4]");
    render(&place, "-o whole/a.####.exr");
    for chunk in ["1-3", "4-5", "6-8"] {
        let ran = render(&place, &format!("-o chunks/a.####.exr --frames {chunk}"));
        assert_eq!(ran.stderr.contains("run-up: 2 frames from 4 on"), chunk == "6-8", "{}", ran.stderr);
    }
    for frame in 1..=8 {
        let [one, other] =
            ["whole", "chunks"].map(|folder| place.path(&format!("{folder}/a.{frame:04}.exr")));
        assert_same(&one, &other);
    }
}

#[test]
fn a_mark_counts_as_a_part_of_the_shot_and_not_as_a_setting() {
    let of = |render: &str| small_shot::load(&format!("[render]\n{render}\n{}", small_shot::REST));
    let [plain, marked, larger] = ["", "cuts = [4]", "size = [9, 9]"].map(|render| of(render).content.shot);
    assert_eq!((plain == marked, plain == larger), (false, true));
    assert_eq!(of("cuts = [9, -4, 9]").scene.camera.cuts, [-4, 9]);
    for (cuts, words) in
        [("[1.5]", "s.toml:2:9"), ("[4, 99999999999]", "`cuts` is not a frame's number"), ("4", "s.toml:2:8")]
    {
        let error = small_shot::error(&format!("[render]\ncuts = {cuts}\n{}", small_shot::REST));
        assert!(error.contains(words), "{error}");
    }
}

/// As at a key with `cut = true`: the camera stays where it was before, and is elsewhere then.
#[test]
fn nothing_leads_over_to_a_camera_key_at_a_mark() {
    let keys = "[camera]\ninterpolation = \"smooth\"\n[[camera.key]]\nframe = 1\neye = [0, 0, 5]\nrotation = [0, 0, 0]\n\
         [[camera.key]]\nframe = 4\neye = [9, 0, 5]\nrotation = [0, 0, 0]\n[[model]]\nobj = \"m.obj\"\n";
    let of = |render: &str, keys: &str| small_shot::load(&format!("[render]\n{render}\n{keys}")).scene.camera;
    let by_key = of("", &keys.replace("frame = 4\n", "frame = 4\ncut = true\n"));
    assert_eq!(of("cuts = [4]", keys), by_key);
    assert_eq!(by_key.eye.at(3.0).x, 0.0);
    assert!(of("", keys).eye.at(3.0).x > 1.0);
}

/// In every mode: what shows something else is begun afresh, and is what a base frame is.
#[test]
fn a_cut_that_nobody_marks_is_found() {
    let behind = 2.0 * EYE - TARGET;
    // turned by so much of the way that hardly anything stays in sight, and by so little that most does
    let turned = toy::keys(&[(1.0, TARGET), (2.0, TARGET), (3.0, behind), (4.0, behind + DVec3::X * 0.2)]);
    let scene = with_camera(with_flyer(world()), rests(EYE), turned);
    for mode in [Mode::Reproject, Mode::Auto] {
        let settings = Settings { mode, width: 192, height: 144, ..toy::audited(2) };
        let frames = toy::render(&scene, &settings, 4);
        let told: Vec<_> = frames.iter().map(|frame| (frame.stats.mode, frame.stats.cut)).collect();
        assert_eq!(told[..3], [("base", false), ("reproject", false), ("base", true)], "{mode:?}");
        assert!(!told[3].1, "{mode:?}");
        assert!(frames.iter().all(|frame| frame.stats.audit.unwrap().differing == 0));
        let alone = Renderer::new(&scene, &settings).unwrap().render(3, false).unwrap();
        assert!(!alone.stats.cut, "nobody looked");
        for plane in frames[2].film.planes.iter().filter(|plane| !plane.name.starts_with("rays")) {
            let values = |finished: &afterimage::frame::Finished| finished.film.values(&plane.name).unwrap();
            assert_eq!(values(&frames[2]), values(&alone), "{mode:?}: {}", plane.name);
        }
    }
}

#[test]
fn a_camera_that_goes_fast_is_no_cut() {
    // a third of the picture is new in each frame
    let away = EYE + (TARGET - EYE).cross(DVec3::Y).normalize() * 9.0;
    let scene = with_camera(world(), rests(EYE), goes(TARGET, TARGET + away - EYE));
    for finished in &toy::render(&scene, &toy::settings(2), FRAMES)[1..] {
        assert_eq!((finished.stats.mode, finished.stats.cut), ("reproject", false));
        assert!(finished.stats.samples.missed > finished.stats.samples.total() / 20);
    }
}

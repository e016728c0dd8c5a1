//! Is every key of cameras read, and what does it do?
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

mod small_shot;

use afterimage::pose::Pose;
use afterimage::scene::camera::Projection;
use glam::Vec3;
use small_shot::*;

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
    let pose = Pose::of(&shot.scene, 1).camera;
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
    assert!(Pose::of(&shot.scene, 7).camera.forward.abs_diff_eq(Vec3::NEG_X, 1e-6));
}

/// Every key of docs/shot-files.md that takes a list of numbers, each on a line of its own with a good value.
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
    assert!((1..=13).all(|frame| (place(f64::from(frame)).length() - 2.0).abs() < 1e-9));
    assert!(camera.cuts == [17] && place(17.0).abs_diff_eq(glam::DVec3::new(out, up, 0.0), 1e-9));
}

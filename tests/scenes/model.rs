//! Models in shot files: where they are, when they are there, and what is said about mistakes in that.

use std::sync::Arc;

use afterimage::frame;
use afterimage::pose::Pose;
use afterimage::scene::{Model, Shot};
use afterimage::trace::BackendKind;
use glam::Vec3;

use crate::small_shot::*;

#[test]
fn scales_may_not_pass_through_zero() {
    let text = format!("{REST}[[model.key]]\nframe = 1\n[[model.key]]\nframe = 5\nscale = -1\n");
    assert!(error(&text).contains("passes through zero"), "{}", error(&text));
}

#[test]
fn models_appear_and_disappear_at_their_keys() {
    let visible = |text: &str| {
        let shot = load(&format!("{REST}{text}"));
        let track = &shot.scene.models[0].track;
        let [there, places] = [1, 4, 5, 6, 9, 20]
            .map(|frame| {
                let pose = Pose::new(&shot.scene, frame);
                (pose.models[0].is_visible, track.map_at(frame.into()).translation.x)
            })
            .into_iter()
            .fold([vec![], vec![]], |[mut there, mut places], (is_there, place)| {
                there.push(u8::from(is_there) as f64);
                places.push(place);
                [there, places]
            });
        (there, places, track.is_constant())
    };
    // a key without it says nothing of it, and one that says nothing else nothing of the place
    let keys = "[[model.key]]\nframe = 1\n[[model.key]]\nframe = 5\nvisible = false\n\
                [[model.key]]\nframe = 9\ntranslate = [8, 0, 0]\nvisible = true\n";
    assert_eq!(
        visible(keys),
        (vec![1.0, 1.0, 0.0, 0.0, 1.0, 1.0], vec![0.0, 3.0, 4.0, 5.0, 8.0, 8.0], false)
    );
    let (there, _, is_constant) = visible("visible = false\n[[model.key]]\nframe = 5.5\nvisible = true\n");
    assert_eq!((there, is_constant), (vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], false));
    let (there, _, is_constant) = visible("visible = true\n[[model.key]]\nframe = 5\nvisible = true\n");
    assert_eq!((there, is_constant), (vec![1.0; 6], true));
}

#[test]
fn what_is_never_visible_is_left_out_and_counts_for_the_size_of_the_shot() {
    let second = "[[model]]\nobj = \"m.obj\"\ntranslate = [9, 0, 0]\n";
    let shown = load(&format!("{REST}{second}"));
    for never in ["visible = false\n", "visible = false\n[[model.key]]\nframe = 4\nvisible = false\n"] {
        let shot = load(&format!("{REST}{second}{never}"));
        assert_eq!((shown.scene.models.len(), shot.scene.models.len()), (2, 1));
        assert_eq!(shot.settings.occlusion_radius, shown.settings.occlusion_radius);
    }
    assert!(
        load(&format!("{REST}visible = false\n")).scene.models.is_empty(),
        "an empty stage is a picture, too"
    );
}

#[test]
fn copies_at_rest_that_add_too_much_share_their_mesh_and_count_once() {
    let copy = |i: usize| format!("[[model]]\nobj = \"m.obj\"\ntranslate = [{i}, 1, 0]\n");
    let text = |copies: usize| format!("{REST}{}", (0..copies).map(copy).collect::<String>());
    let meshes = |shot: &Shot| shot.scene.built().count();
    // of two triangles, and one more mesh where its file puts it
    let [shared, baked] = [17, 18].map(|most_added| load_sharing(&text(10), most_added));
    assert_eq!((meshes(&shared), shared.triangles()), (2, 4));
    assert_eq!((meshes(&baked), baked.triangles()), (11, 22));
    let (first, copies) = shared.scene.models.split_first().unwrap();
    assert!(!first.is_placed_at_rest() && copies.iter().all(Model::is_placed_at_rest));
    assert!(copies.iter().all(|copy| Arc::ptr_eq(&copy.mesh, &first.mesh)));
    assert!(!load(&text(10)).scene.models.iter().any(Model::is_placed_at_rest), "they are small");
    let need = |copies: usize, most_added: u64| {
        let shot = load_sharing(&text(copies), most_added);
        frame::need(&shot, &shot.settings, BackendKind::Embree, 1, 1).bytes()
    };
    assert_eq!(need(10, 0), need(100, 0));
    assert!(need(100, u64::MAX) > need(100, 0));
}

#[test]
fn matrices_are_rows_for_column_vectors() {
    let at = |rows: &str, more: &str| {
        let shot = load(&format!(
            "{REST}matrix = {rows}\n{more}[[model.key]]\nframe = 1\n[[model.key]]\nframe = 2\nrotate = [0, 0, 1]\n"
        ));
        Pose::new(&shot.scene, 1).models[0].point(Vec3::new(1.0, 2.0, 3.0))
    };
    let rows = "[[1, 0.5, 0, 10], [0, -1, 0, 20], [0, 0, 2, 30]";
    assert_eq!(at(&format!("{rows}]"), ""), Vec3::new(12.0, 18.0, 36.0));
    assert_eq!(at(&format!("{rows}, [0, 0, 0, 1]]"), ""), Vec3::new(12.0, 18.0, 36.0));
    let after = "translate = [100, 0, 0]\nscale = 2\nrotate = [0, 0, 90]\n";
    let text = load(&format!("{REST}matrix = {rows}]\n{after}"));
    assert!(text.scene.models[0].track.is_constant(), "it is put there once");
    let shot = load(&format!(
        "{REST}matrix = {rows}]\n{after}[[model.key]]\nframe = 1\n[[model.key]]\nframe = 2\nscale = 3\n"
    ));
    // (12, 18, 36) twice as large, turned by 90 degrees about z, then moved
    let there = Pose::new(&shot.scene, 1).models[0].point(Vec3::new(1.0, 2.0, 3.0));
    assert!(there.abs_diff_eq(Vec3::new(100.0 - 36.0, 24.0, 72.0), 1e-4), "{there}");
}

#[test]
fn keyed_matrices_pass_element_by_element() {
    let shot = load(&format!(
        "{REST}[[model.key]]\nframe = 1\n[[model.key]]\nframe = 5\nmatrix = [[1, 2, 0, 4], [0, 3, 0, 0], [0, 0, 1, 8]]\n"
    ));
    let rows = shot.scene.models[0].track.map_at(2.0).to_cols_array();
    assert_eq!(rows, [1.0, 0.0, 0.0, 0.5, 1.5, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 2.0]);
}

#[test]
fn matrices_that_make_no_sense_are_refused_at_their_place() {
    const FLAT: &str = "s.toml:7:10: `matrix` makes the model flat";
    for (rows, expected) in [
        (
            "[[1, 0, 0, 0], [0, 1, 0, 0]]",
            "s.toml:7:10: `matrix` has 2 rows: it must have 3, or 4 of which the last is",
        ),
        (
            "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1]]",
            "s.toml:7:39: `matrix`: invalid length 3, expected a list of 4 numbers",
        ),
        ("[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, \"1\", 0]]", "s.toml:7:46: `matrix`: invalid type"),
        ("[[1, 2, 3, 0], [4, 5, 6, 0], [7, 8, 9, 0]]", FLAT),
        ("[[1, 0, 0, 5], [0, 0, 0, 5], [0, 0, 1, 5]]", FLAT),
        ("[[1, 0, 0, 0], [0, 1e-10, 0, 0], [0, 0, 1, 0]]", FLAT),
        (
            "[[1e10, 0, 0, 0], [0, 1e10, 0, 0], [0, 0, 1e10, 0]]",
            "s.toml:7:10: `matrix` must not make the model more than 1e9",
        ),
        (
            "[[nan, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]",
            "s.toml:7:10: `matrix` must have finite numbers alone",
        ),
        (
            "[[1, 0, 0, 0], [0, 1, 0, inf], [0, 0, 1, 0]]",
            "s.toml:7:10: `matrix` must have finite numbers alone",
        ),
        (
            "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [5, 6, 7, 1]]",
            "s.toml:7:10: `matrix` has its translation in the last row",
        ),
        (
            "[[1, 0, 0, 2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 1, 1]]",
            "s.toml:7:10: `matrix` must have [0, 0, 0, 1] as its last row",
        ),
        ("4", "s.toml:7:10: `matrix`: invalid type"),
    ] {
        for text in [
            format!("{REST}matrix = {rows}\n"),
            format!(
                "[[model]]\nobj = \"m.obj\"\n[[model.key]]\nframe = 1\n\n\nmatrix = {rows}\n[[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n"
            ),
        ] {
            let message = error(&text);
            assert!(message.starts_with(expected), "for\n{text}\nexpected {expected}\ngot      {message}");
        }
    }
}

#[test]
fn matrices_may_not_turn_inside_out_between_keys() {
    const ONE: &str = "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]";
    const MIRROR: &str = "[[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]";
    // half a turn about z: flat half way, and the right way round on either side
    const TURNED: &str = "[[-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 1, 0]]";
    for (to, last, frame) in [(MIRROR, 5, 3), (MIRROR, 4, 3), (TURNED, 5, 3)] {
        let keys = format!(
            "[[model.key]]\nframe = 1\nmatrix = {ONE}\n[[model.key]]\nframe = {last}\nmatrix = {to}\n"
        );
        let message = error(&format!("{REST}{keys}"));
        let expected =
            format!("s.toml:6:7: the `matrix` of this model makes it flat at frame {frame}, or between");
        assert!(message.starts_with(&expected), "{message}, not {expected}");
    }
    let smooth = "interpolation = \"smooth\"\n[[model.key]]\nframe = 1\n[[model.key]]\nframe = 5\nmatrix = [[1e-3, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]\n\
         [[model.key]]\nframe = 9\nmatrix = [[2e-3, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]\n";
    assert!(error(&format!("{REST}{smooth}")).contains("makes it flat at frame"), "the curve overshoots");
}

#[test]
fn visible_is_a_key_of_models_alone() {
    for (text, expected) in [
        (format!("{REST}visible = 1\n"), "s.toml:7:11: `visible`: invalid type"),
        (
            format!("{REST}[[model.key]]\nframe = 1\nvisible = \"no\"\n"),
            "s.toml:9:11: `visible`: invalid type",
        ),
        (
            format!("[[light]]\ntype = \"point\"\nvisible = false\n{REST}"),
            "s.toml:3:1: unknown key `visible`",
        ),
        (format!("[floor]\nvisible = false\n{REST}"), "s.toml:2:1: unknown key `visible`"),
        (format!("{REST}[[model.key]]\nvisible = false\n"), "s.toml:7:1: the key `frame` is missing"),
    ] {
        let message = error(&text);
        assert!(message.starts_with(expected), "for\n{text}\nexpected {expected}\ngot      {message}");
    }
}

#[test]
fn reflection_maps_have_a_size() {
    let size = |text: &str| load(&format!("{REST}{text}")).scene.models[0].reflection_map;
    assert_eq!((size(""), size("reflection_map = 64\n")), (None, Some(64)));
    const RANGE: &str = "s.toml:7:18: `reflection_map` is";
    for (text, expected) in [
        ("7", format!("{RANGE} 7: it must be a whole number from 8 to 1024")),
        ("-1", format!("{RANGE} -1: it must be")),
        ("true", String::from("s.toml:7:18: `reflection_map`: invalid type")),
    ] {
        let message = error(&format!("{REST}reflection_map = {text}\n"));
        assert!(message.starts_with(&expected), "{message}, not {expected}");
    }
    let plane = format!("{REST}[[model]]\nquadric = {{ type = \"plane\" }}\nreflection_map = 16\n");
    assert!(
        error(&plane).starts_with("s.toml:9:18: `reflection_map` means nothing for a plane"),
        "{}",
        error(&plane)
    );
}

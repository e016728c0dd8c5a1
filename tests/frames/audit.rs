//! Does the audit find what is wrong? One class of failure after the other.

use afterimage::film::Film;
use afterimage::frame::{Renderer, Spoil};
use afterimage::settings::{Filter, Settings};
use glam::DVec3;

use crate::toy;
use crate::toy::worlds::*;

#[test]
fn an_audit_finds_each_kind_of_spoilt_sample() {
    // Before a camera that stands no sample is looked at again. Tags are spoilt before one that turns: the light is summed
    // anew there, as they say, so that nothing but a ray can tell
    let kinds =
        [Spoil::Place, Spoil::Sight, Spoil::Normal, Spoil::Triangle, Spoil::Reflectance, Spoil::Light];
    for (spoil, turn) in kinds.map(|kind| (kind, 0.0)).into_iter().chain([(Spoil::Tags, 0.02)]) {
        let mut scene = world();
        scene.models.truncate(2);
        scene.lights.push(panel(rests(DVec3::new(1.0, 5.0, 2.0))));
        let scene = with_camera(scene, rests(EYE), goes(TARGET, TARGET + DVec3::X * turn));
        let audited = |spoils: bool| {
            let mut renderer = Renderer::new(&scene, &toy::audited(2)).expect("the scene builds");
            renderer.render(1, true).expect("renders");
            let spoilt = if spoils { renderer.spoil(spoil).expect("rays are cast") } else { 0 };
            let stats = renderer.render(2, true).expect("renders").stats;
            assert_eq!(stats.mode, "reproject");
            (spoilt, stats.audit.expect("asked for"))
        };
        let (_, sound) = audited(false);
        assert_eq!(sound.wrong(), 0, "{spoil:?}: {sound:?}");
        let (spoilt, found) = audited(true);
        // those on edges may be taken for their neighbours
        assert!(spoilt > 50 && found.differing * 10 > spoilt * 9, "{spoil:?}: {spoilt}, {found:?}");
        assert!(found.differing * 10 <= spoilt * 11, "and no others, {spoil:?}: {spoilt}, {found:?}");
    }
}

#[test]
fn an_audit_finds_a_pixel_that_should_not_stand() {
    let mut scene = world();
    scene.models.truncate(2);
    for filter in [Filter::Box, Filter::Mitchell] {
        let settings = Settings { width: 48, height: 36, filter, ..toy::audited(2) };
        let mut renderer = Renderer::new(&scene, &settings).expect("the scene builds");
        // every frame is the first one again, over the film before
        let mut render = |spoil: &mut dyn FnMut(&mut Film)| {
            renderer.spoil_film(spoil);
            let finished = renderer.render(1, true).expect("renders");
            (finished.film.planes.len(), toy::differing(&finished))
        };
        let mut planes = 0;
        for _ in 0..3 {
            let (count, differing) = render(&mut |_| {});
            assert_eq!(differing, 0, "{filter:?}");
            planes = count;
        }
        let pixel = 20 * 48 + 25;
        // what was there before the plane was spoilt that is put right while the next one is spoilt: it is not found again
        let mut before: Option<(usize, f32)> = None;
        for plane in 0..=planes {
            let mut name = String::from("all as they were");
            let (_, differing) = render(&mut |film| {
                if let Some((plane, value)) = before.take() {
                    let older = if &*film.planes[plane].name == "status_age.V" { 1.0 } else { 0.0 };
                    film.planes[plane].values.put(pixel, &[value + older]);
                }
                let Some(spoilt) = film.planes.get_mut(plane) else { return };
                name = spoilt.name.to_string();
                let value = spoilt.values.get(pixel);
                before = Some((plane, value));
                // numbers of mattes are too large for that
                let other = if value + 1.0 == value { 0.0 } else { value + 1.0 };
                spoilt.values.put(pixel, &[other]);
            });
            // rays that were spared are not counted: those planes may differ
            let expected = if plane == planes || name.starts_with("rays_") { 0 } else { 4 };
            assert_eq!(differing, expected, "{filter:?}, {name}");
        }
    }
}

#[test]
fn an_audit_finds_a_mirror_that_should_not_stand() {
    let (middle, light) = seen_in_a_mirror();
    let scene = before_a_mirror(middle, light);
    for filter in [Filter::Box, Filter::Mitchell] {
        let settings = Settings { filter, ..toy::audited(1) };
        let differing = |spoils: bool| {
            let mut renderer = Renderer::new(&scene, &settings).expect("the scene builds");
            let frames = (1..LAST_BEFORE_MIRROR).map(|frame| {
                // while the flyer passes
                if spoils && (6..8).contains(&frame) {
                    assert!(renderer.spoil(Spoil::Trees).expect("no rays are cast") > 0);
                }
                let finished = renderer.render(frame, true).expect("renders");
                toy::differing(&finished)
            });
            frames.sum::<u64>()
        };
        assert_eq!(differing(false), 0, "{filter:?}");
        assert!(differing(true) > 20, "{filter:?}");
    }
}

//! The picture quality of frames that reuse samples: a small version of `make quality`. docs/quality.md explains the
//! figures.
#![allow(dead_code, reason = "the bench uses all of what is shared with it")]

#[path = "../../benches/quality/coverage.rs"]
mod coverage;
#[path = "../../benches/quality/flows.rs"]
mod flows;
#[path = "../../benches/quality/measure.rs"]
mod measure;
#[path = "../../benches/quality/picture.rs"]
mod picture;
#[path = "../../benches/quality/reference.rs"]
mod reference;
#[path = "../../benches/quality/sequence.rs"]
mod sequence;
#[path = "../../benches/quality/subjects.rs"]
mod subjects;

use afterimage::frame::Renderer;
use afterimage::layers::Layers;
use afterimage::settings::{Filter, Settings};

use crate::toy;
use flows::Flow;
use measure::{Comparison, Options, Row};
use picture::Picture;
use reference::Reference;
use subjects::Subject;

// The bounds: what the renderer reaches, with some room. Lists have an entry for each of `SAMPLES`.

/// Samples along a pixel's edge.
const SAMPLES: [u32; 2] = [1, 2];

/// RMSE of an inferred frame, over that of a jittered one. More with 2x2: in so young a chain all samples have drifted by
/// the same amount (docs/quality.md).
const MOST_ERROR: [f64; 2] = [1.15, 1.35];

/// Samples that are traced for an inferred frame: a share.
const MOST_TRACED: f64 = 0.06;

/// Signed coverage error, less that of a frame that is traced in full, of either sign: in percent of the rim of discs or of
/// the area of wires.
const MOST_GROWTH: f64 = 0.6;

/// Area moved, in percent of the picture, less that of a frame that is traced in full.
const MOST_MOVED: f64 = 0.04;

/// Flicker, over that of jittered frames.
const MOST_FLICKER: [f64; 2] = [0.7, 1.4];

/// How much the error pops between base and inferred frames, over how much between frames that are traced anew.
const MOST_POP: [f64; 2] = [3.5, 3.5];

const SIZE: [u32; 2] = [128, 72];

fn options() -> Options {
    let filter = (Filter::Box, None);
    Options { size: SIZE, frames: vec![24], filter, reference: 16, sequence: 4, window: 8, seeds: 4 }
}

/// Compares frame 24 of a chain with the bounds.
fn hold(subject: &Subject, flow: Flow) {
    let options = options();
    let comparison = Comparison::new(subject, flow, &options).unwrap();
    for (number, samples) in SAMPLES.into_iter().enumerate() {
        let rows = comparison.rows(samples).unwrap();
        let [Row { inferred, centred, traced, coverage, moved, flicker, .. }] = &rows[..] else {
            panic!("one frame was asked for");
        };
        let what = format!("{}, {flow:?}, {samples}x{samples}", subject.name);
        println!(
            "{what}: {inferred:.2} {centred:.2}, {traced:.2}, {coverage:.2?}, {moved:.3?}, {flicker:.2?}"
        );
        assert!(*traced < MOST_TRACED, "{what}: {traced} traced");
        assert!(*inferred > 0.0 && *inferred < MOST_ERROR[number], "{what}: error {inferred}");
        let coverage = coverage.unwrap();
        let growth = coverage.inferred - coverage.centred;
        assert!(growth.abs() < MOST_GROWTH, "{what}: {coverage:?}");
        // or the picture is too small to say anything
        assert!(coverage.jittered < 3.0, "{what}: {coverage:?}");
        assert!(moved[0] - moved[1] < MOST_MOVED, "{what}: {moved:?} moved");
        assert!(flicker[1] > 0.0 && flicker[1] < MOST_FLICKER[number], "{what}: flicker {flicker:?}");
        let pops = comparison.pops(samples).unwrap();
        println!("{what}: {:.2} {:.2} {:.2?}", pops.from_base, pops.to_base, pops.over_centred);
        assert!(
            pops.over_centred.iter().all(|jump| *jump < MOST_POP[number]),
            "{what}: {:?}",
            pops.over_centred
        );
    }
}

/// In a young chain all samples lie beside the centres of their cells by much the same amount. By area they weigh as much as what they
/// stand for in the pixel, so that the amount does not matter.
#[test]
fn areas_take_what_young_chains_add_to_error_and_flicker() {
    let subject = subjects::discs();
    let row = |filter, samples| {
        let options = Options { filter: (filter, None), ..options() };
        Comparison::new(&subject, Flow::In, &options).unwrap().rows(samples).unwrap().remove(0)
    };
    for (samples, most_error, most_flicker) in [(1, 0.75, 0.35), (2, 0.65, 0.3), (4, 0.5, 0.2)] {
        let [own, spread] = [Filter::Box, Filter::Area].map(|filter| row(filter, samples));
        println!(
            "{samples}: {:.2} {:.2}, {:.2?} {:.2?}",
            own.inferred, spread.inferred, own.flicker, spread.flicker
        );
        assert!(
            spread.inferred < most_error * own.inferred,
            "{samples}: {}, {}",
            own.inferred,
            spread.inferred
        );
        assert!(
            spread.flicker[1] < most_flicker * own.flicker[1],
            "{samples}: {:?}, {:?}",
            own.flicker,
            spread.flicker
        );
        // the samples of centred frames are where the box has them
        assert!(
            (spread.centred - own.centred).abs() < 0.01 * own.centred,
            "{}, {}",
            own.centred,
            spread.centred
        );
    }
}

#[test]
fn discs_keep_their_size_when_the_camera_comes_near() {
    hold(&subjects::discs(), Flow::In);
}

#[test]
fn discs_keep_their_size_when_the_camera_goes_away() {
    hold(&subjects::discs(), Flow::Out);
}

#[test]
fn wires_keep_their_width_when_the_camera_comes_near() {
    hold(&subjects::wires(SIZE[1]), Flow::In);
}

#[test]
fn wires_keep_their_width_when_the_camera_goes_sideways() {
    hold(&subjects::wires(SIZE[1]), Flow::Sideways);
}

#[test]
fn what_moves_keeps_its_size_before_a_camera_at_rest() {
    hold(&subjects::movers(), Flow::Rest);
}

/// A reference and the renderer's own frame with as many samples have the same picture and the same areas.
#[test]
fn references_agree_with_the_renderer() {
    let scene = subjects::wires(SIZE[1]).scene(Flow::Turn);
    let settings = Settings { width: SIZE[0], height: SIZE[1], layers: Layers::NONE, ..toy::settings(16) };
    let [reference] = &Reference::of(&scene, &settings, &[7], 16).unwrap()[..] else {
        panic!("one frame was asked for")
    };
    let own = Renderer::new(&scene, &settings).unwrap().render(7, false).unwrap();
    let (picture, reference) = reference.whole();
    let error = picture.rmse(&Picture::of(&own.film));
    assert!(error < 1e-3, "{error}: more than rounding to halves");
    let areas = coverage::areas(&scene, &settings, &[7], false).unwrap();
    assert_eq!(areas[0].len(), 3, "two materials and the background");
    for (area, wanted) in areas[0].iter().zip(&reference) {
        assert!((area - wanted).abs() < 0.01, "{areas:?}, {reference:?}");
    }
    assert!(reference[0] > 500.0 && reference[1] > 500.0, "{reference:?}: both are seen");
    let moved = coverage::moved(&vec![reference[0] - 92.16, reference[1] + 92.16, 0.0], &reference);
    assert!((moved - 1.0).abs() < 1e-6, "{moved}: one of a hundred pixels");
}

/// Codes of many materials give the same counts in any base.
#[test]
fn every_material_is_counted() {
    let mut scene = subjects::discs().scene(Flow::In);
    let discs = scene.materials[0].clone();
    let many = 83;
    scene.materials.splice(0..1, vec![discs; many]);
    for (number, model) in scene.models.iter_mut().enumerate() {
        let mut mesh = afterimage::scene::Mesh::clone(&model.mesh);
        for (triangle, material) in mesh.material_of.iter_mut().enumerate() {
            *material = if number == 0 { many as u16 } else { (triangle / 8 % many) as u16 };
        }
        model.mesh = std::sync::Arc::new(mesh);
    }
    // always the same samples
    let counts = |samples: u32| {
        let settings = Settings { width: 512 / samples, height: 288 / samples, ..toy::settings(samples) };
        let areas = coverage::areas(&scene, &settings, &[1], false).unwrap().remove(0);
        areas.iter().map(|area| area * f64::from(samples).powi(2)).collect::<Vec<f64>>()
    };
    let all = counts(1);
    assert_eq!(all.iter().sum::<f64>(), 512.0 * 288.0);
    assert!(all.iter().filter(|count| **count > 100.0).count() > many / 2, "many wedges are seen: {all:?}");
    assert_eq!(all, counts(2));
    assert_eq!(all, counts(4));
}

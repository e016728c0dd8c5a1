//! Does a run that goes on from a saved store make the frames of one that was never interrupted? What of files that are no good?

use std::fs;
use std::path::Path;
use std::process::Command;

use afterimage::animation::Track;
use afterimage::changes::Direction;
use afterimage::digest::Digest;
use afterimage::exposure::Shutter;
use afterimage::frame::{Finished, Moment, Renderer, Snapshot, ValidDirection};
use afterimage::output::Fingerprint;
use afterimage::output::store_file::{self, Header, MAGIC, StoreErrorKind, StoreFile, VERSION};
use afterimage::samples::saved::{LevelSamples, PictureName, PictureSamples, StoreShape};
use afterimage::samples::{SampleStore, Traced};
use afterimage::scene::{Environment, Scene};
use afterimage::settings::{Budget, Filter, Mode, Refinement, Reuse, Settings};
use afterimage::stereo::{Eye, Stereo};
use glam::DVec3;

use crate::runs;
use crate::runs::{Place, Ran, assert_same};
use crate::toy;
use crate::toy::worlds::*;

const OPTIONS: &str = "--mode reproject --progress none";

/// Half of the time, about each frame's own.
const HALF: Option<Shutter> = Some(Shutter::new(-0.25, 0.25));

const STEREO: Option<Stereo> = Some(Stereo { separation: 0.25, convergence: Some(6.0) });

fn render(place: &Place, options: &str) -> Ran {
    place.render(&format!("{OPTIONS} {options}"))
}

#[track_caller]
fn assert_same_frames(place: &Place, folders: [&str; 2], frames: std::ops::RangeInclusive<i32>) {
    for frame in frames {
        let [one, other] = folders.map(|folder| place.path(&format!("{folder}/a.{frame:04}.exr")));
        assert_same(&one, &other);
    }
}

fn header(frame: i32, rendered: u32) -> Header {
    let digest = Digest::new(b"of a test");
    let fingerprint = Fingerprint { version: digest, shot: digest, inputs: digest, settings: digest };
    let [sampling, ancestry] = ["of a test", "base"].map(String::from);
    Header { fingerprint, frame, sampling, ancestry, rendered }
}

fn borrowed(pictures: &[PictureSamples<SampleStore>]) -> Vec<PictureSamples<&SampleStore>> {
    let mut all = Vec::new();
    for PictureSamples { picture, levels } in pictures {
        let levels = levels.iter();
        let levels = levels.map(|level| LevelSamples { store: &level.store, wanted: level.wanted.clone() });
        all.push(PictureSamples { picture: *picture, levels: levels.collect() });
    }
    all
}

/// A frame as all eyes see it.
fn seen(renderer: &mut Renderer<'_>, frame: i32) -> Vec<Finished> {
    let eyes = renderer.eyes().iter();
    eyes.map(|eye| renderer.render_eye(*eye, frame, true).unwrap()).collect()
}

/// A renderer of another process, which goes on from what `renderer` has.
fn through_a_file<'s>(
    renderer: &Renderer<'_>,
    scene: &'s Scene,
    settings: &Settings,
    path: &Path,
) -> Renderer<'s> {
    let (moment, pictures) = renderer.samples().unwrap();
    let header = header(moment.frame, moment.rendered);
    let bytes = store_file::write(path, &header, &pictures, renderer.shape().layout).unwrap();
    assert_eq!(bytes, fs::metadata(path).unwrap().len());
    let mut other = Renderer::new(scene, settings).unwrap();
    let file = StoreFile::open(path).unwrap();
    assert_eq!(*file.header(), header);
    let pictures = file.read(&other.shape(), scene).unwrap();
    other.restore(Snapshot { moment, pictures });
    other
}

#[track_caller]
fn assert_same_film(name: &str, one: &Finished, other: &Finished, counts_rays: bool) {
    assert_eq!(one.stats.samples, other.stats.samples, "{name}, frame {}", one.stats.frame);
    for plane in one.film.planes.iter().filter(|plane| counts_rays || !plane.name.starts_with("rays")) {
        let [one_values, other_values] =
            [one, other].map(|finished| finished.film.values(&plane.name).unwrap());
        let differ = one_values.iter().zip(&other_values).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
        assert_eq!(differ, 0, "{name}: {} of frame {}", plane.name, one.stats.frame);
    }
}

fn camera_goes(scene: Scene) -> Scene {
    with_camera(scene, goes(EYE, EYE + DVec3::new(0.5, 0.2, -0.5)), rests(TARGET))
}

/// It rests, moves, and rests again, between exposures.
fn camera_stops(scene: Scene) -> Scene {
    let away = EYE + DVec3::new(0.3, 0.0, -0.2);
    let eye = toy::keys(&[(1.0, EYE), (2.25, EYE), (3.5, away), (20.0, away)]);
    with_camera(scene, eye, rests(TARGET))
}

fn with_lens(mut scene: Scene) -> Scene {
    scene.camera.lens.aperture = Some(Track::constant(0.1));
    scene
}

fn camera_turns(scene: Scene) -> Scene {
    with_camera(scene, rests(EYE), goes(TARGET, TARGET + DVec3::X))
}

fn under_a_sky(mut scene: Scene) -> Scene {
    scene.environment = Some(Environment::from_background(&scene.background));
    scene
}

fn small(samples: u32) -> Settings {
    Settings { width: 64, height: 48, ..toy::audited(samples) }
}

/// From each frame of each of these to the next through a file.
#[test]
fn frames_after_a_store_are_those_of_one_run() {
    let plain = small(2);
    let paths = Settings { paths: 5, bounces: 2, ..small(1) };
    let budget = Settings { budget: Budget::Full, paths_per_frame: 2, ..paths.clone() };
    let wide = Settings { filter: Filter::Gaussian, mode: Mode::Auto, ..small(2) };
    let paper = Settings { reuse: Reuse::Paper, ..small(2) };
    let occluded = |mut scene: Scene| {
        scene.ambient_is_occluded = true;
        scene
    };
    let adaptive = Settings {
        refinement: Some(Refinement { most: 4, threshold: 0.1 }),
        paths: 2,
        bounces: 1,
        ..small(1)
    };
    let exposed = Settings { shutter: HALF, exposures: Some(4), ..small(2) };
    let of_all =
        Settings { paths: 3, bounces: 1, budget: Budget::Full, paths_per_frame: 1, ..exposed.clone() };
    let through_a_lens = Settings { refinement: adaptive.refinement, exposures: Some(2), ..small(1) };
    let of_two = Settings { stereo: STEREO, ..small(1) };
    let of_two_exposed = Settings { stereo: STEREO, ..exposed.clone() };
    let kinds: [(&str, Scene, &Settings); 22] = [
        ("exposures", camera_goes(with_flyer(world())), &exposed),
        ("exposures at rest", with_flyer(world()), &exposed),
        ("exposures of a camera that stops", camera_stops(with_flyer(world())), &exposed),
        ("exposures and gathered light", camera_goes(under_a_sky(with_flyer(world()))), &of_all),
        ("the same, stopping", camera_stops(under_a_sky(with_flyer(world()))), &of_all),
        ("a lens", with_lens(camera_goes(with_flyer(world()))), &through_a_lens),
        ("a lens at rest", with_lens(with_flyer(world())), &through_a_lens),
        ("two eyes", camera_goes(with_flyer(world())), &of_two),
        ("two eyes at rest", with_flyer(world()), &of_two),
        ("exposures of two eyes", camera_goes(with_flyer(world())), &of_two_exposed),
        ("exposures of two eyes that stop", camera_stops(with_flyer(world())), &of_two_exposed),
        ("adaptive samples", camera_goes(with_flyer(world())), &adaptive),
        ("adaptive samples at rest", with_flyer(world()), &adaptive),
        ("the camera moves", camera_goes(with_flyer(world())), &plain),
        ("the camera turns", camera_turns(with_flyer(world())), &plain),
        ("all rests but a flyer", with_flyer(world()), &plain),
        ("area lights move", camera_goes(with_area_lights(with_flyer(world()))), &paper),
        ("gathered light", camera_goes(under_a_sky(with_flyer(world()))), &paths),
        ("gathered light under a budget", camera_goes(with_flyer(world())), &budget),
        ("the same, at rest", with_flyer(under_a_sky(world())), &budget),
        ("openness and a wide filter", occluded(camera_goes(with_flyer(world()))), &wide),
        ("openness at rest", occluded(with_flyer(world())), &plain),
    ];
    let folder = tempfile::tempdir().unwrap();
    for (name, scene, settings) in kinds {
        // at rest, what a film shows already casts no rays: that is counted, and changes nothing else
        let moves = scene.camera.eye.at(5.0) != scene.camera.eye.at(6.0) || name.contains("turns");
        // what has the same samples and the same film needs no audit of its own
        let unaudited = Settings { audit: false, ..settings.clone() };
        let mut one = Renderer::new(&scene, &unaudited).unwrap();
        let mut other = Renderer::new(&scene, settings).unwrap();
        for frame in 1..=FRAMES {
            for (uninterrupted, finished) in seen(&mut one, frame).iter().zip(seen(&mut other, frame)) {
                assert_same_film(name, uninterrupted, &finished, moves);
                assert_eq!(finished.stats.audit.unwrap().wrong(), 0, "{name}");
                if moves {
                    assert_eq!(finished.stats.rays, uninterrupted.stats.rays, "{name}");
                }
            }
            other = through_a_file(&other, &scene, settings, &folder.path().join("a.store"));
        }
    }
}

#[test]
fn answers_that_hold_backwards_come_back_as_such() {
    let sharp = Settings { paths: 4, bounces: 1, ..small(1) };
    let blurred = Settings { shutter: HALF, exposures: Some(4), samples: 2, ..sharp.clone() };
    let of_two = Settings { stereo: STEREO, ..blurred.clone() };
    let folder = tempfile::tempdir().unwrap();
    for settings in [sharp, blurred, of_two] {
        for scene in [camera_goes(with_flyer(world())), camera_stops(with_flyer(world()))] {
            let moves = scene.camera.eye.at(5.0) != scene.camera.eye.at(6.0);
            let [mut one, mut other] = [(); 2].map(|()| Renderer::new(&scene, &settings).unwrap());
            for frame in (1..=FRAMES).rev() {
                for (uninterrupted, finished) in seen(&mut one, frame).iter().zip(seen(&mut other, frame)) {
                    assert_same_film("backwards", uninterrupted, &finished, moves);
                    assert_eq!(finished.stats.audit.unwrap().wrong(), 0, "frame {frame}");
                }
                let direction = if frame == FRAMES { Direction::Forward } else { Direction::Backward };
                assert_eq!(
                    one.samples().unwrap().0,
                    Moment {
                        frame,
                        rendered: (FRAMES - frame + 1) as u32,
                        valid: ValidDirection::To(direction)
                    }
                );
                other = through_a_file(&other, &scene, &settings, &folder.path().join("a.store"));
            }
        }
    }
}

#[test]
fn a_run_in_parts_makes_the_frames_of_the_whole() {
    for options in [
        "--layers all",
        "--layers all --paths 4 --budget full --paths-per-frame 2 --filter tent",
        "--layers all --shutter -0.25,0.25 --exposures 3 --paths 2",
        "--stereo --separation 0.1",
        "--stereo --separation 0.1 --shutter 0,0.5 --exposures 2 --samples 1-2",
    ] {
        let place = Place::new();
        render(&place, &format!("-o whole/a.####.exr {options} --stats whole.json")).done();
        let first =
            render(&place, &format!("-o parts/a.####.exr {options} --frames 1-3 --save-store a.store"))
                .done();
        let told = first.stdout.lines().find(|line| line.starts_with("store")).unwrap();
        assert!(told.contains("a.store") && told.contains("MiB") && told.contains("frame 3"), "{told}");
        // over the store that it goes on from
        let more = "--frames 4-6 --load-store a.store --save-store a.store";
        let second = render(&place, &format!("-o parts/a.####.exr {options} {more}")).done();
        assert!(!second.stderr.contains("run-up"), "{}", second.stderr);
        render(
            &place,
            &format!("-o parts/a.####.exr {options} --frames 7-8 --load-store a.store --stats a.json"),
        )
        .done();
        assert_same_frames(&place, ["whole", "parts"], 1..=8);
        let frames = |name: &str| {
            let stats: serde_json::Value =
                serde_json::from_slice(&fs::read(place.path(name)).unwrap()).unwrap();
            stats["frames"]
                .as_array()
                .unwrap()
                .iter()
                .map(|frame| frame["samples"].clone())
                .collect::<Vec<_>>()
        };
        // of the eyes of two frames
        let (whole, last) = (frames("whole.json"), frames("a.json"));
        assert_eq!(last.len(), if options.contains("stereo") { 4 } else { 2 });
        assert_eq!(whole[whole.len() - last.len()..], last);
        assert_eq!(place.names(""), ["a.json", "a.store", "parts", "whole", "whole.json"]);
    }
}

#[test]
fn a_store_of_a_middle_base_frame_serves_both_sides() {
    for more in
        ["", "--shutter -0.25,0.25 --exposures 3", "--stereo --separation 0.1 --shutter 0,0.5 --exposures 2"]
    {
        serves_both_sides(&format!("--base-every 5 --base-place middle --paths 2 --layers all {more}"));
    }
}

fn serves_both_sides(options: &str) {
    let place = Place::new();
    render(&place, &format!("-o whole/a.####.exr {options}")).done();
    render(&place, &format!("-o parts/a.####.exr {options} --frames 3 --save-store 3.store")).done();
    let loaded = |frames: &str, more: &str| {
        render(&place, &format!("-o parts/a.####.exr {options} --frames {frames} {more}")).done().stderr
    };
    assert_eq!(loaded("2,4", "--load-store 3.store --save-store 2.store"), "");
    assert_eq!(loaded("1", "--load-store 2.store"), "");
    assert!(loaded("5", "--load-store 2.store").contains("nothing is taken from it"));
    assert_same_frames(&place, ["whole", "parts"], 1..=5);
}

#[test]
fn a_store_that_no_frame_follows_from_is_told_and_left() {
    let place = Place::new();
    render(&place, "-o whole/a.####.exr --base-every 4").done();
    render(&place, "-o a/a.####.exr --base-every 4 --frames 1-3 --save-store a.store").done();
    let ran = render(&place, "-o a/a.####.exr --base-every 4 --frames 5-8 --load-store a.store").done();
    assert!(ran.stderr.contains("no frame of this run follows from its frame 3"), "{}", ran.stderr);
    assert_same_frames(&place, ["whole", "a"], 5..=8);
    // nor where what leads to it is wanted, unless it is there
    let of_all = "-o a/a.####.exr --base-every 4 --frames 1-4 --load-store a.store";
    assert!(render(&place, of_all).done().stderr.contains("nothing is taken from it"));
    fs::remove_file(place.path("a/a.0004.exr")).unwrap();
    let ran = place.render(&format!("{of_all} --resume --mode reproject --progress plain")).done();
    assert!(ran.stderr.contains("[1/1] frame 4"), "{}", ran.stderr);
    assert_same_frames(&place, ["whole", "a"], 1..=8);
}

/// A chunk that is there already must still leave what the next one goes on from.
#[test]
fn resuming_saves_a_store_that_is_not_there() {
    let place = Place::new();
    let options = "-o a/a.####.exr --frames 1-3 --resume --save-store a.store";
    render(&place, "-o a/a.####.exr --frames 1-3").done();
    let stamp = |name: &str| fs::metadata(place.path(name)).unwrap().modified().unwrap();
    let first = stamp("a/a.0001.exr");
    assert!(render(&place, options).done().stdout.contains("the samples of frame 3"));
    assert_eq!(stamp("a/a.0001.exr"), first, "it is kept");
    let saved = stamp("a.store");
    assert_eq!(render(&place, options).done().stdout, "", "all is there");
    assert_eq!(stamp("a.store"), saved);
    fs::write(place.path("a.store"), "something else").unwrap();
    render(&place, options).done();
    render(&place, "-o whole/a.####.exr --frames 1-5").done();
    render(&place, "-o a/a.####.exr --frames 4-5 --load-store a.store").done();
    assert_same_frames(&place, ["whole", "a"], 1..=5);
}

/// A folder with the store of frame 2.
fn with_store() -> Place {
    let place = Place::new();
    render(&place, "-o a/a.####.exr --frames 1-2 --save-store a.store").done();
    place
}

#[test]
fn a_store_of_something_else_is_refused() {
    let place = with_store();
    for (options, words) in [
        ("--samples 1", &["a.store", "other settings", "--save-store"][..]),
        ("--paths 2", &["other settings"]),
        ("--crop 16x16+0+0", &["other settings"]),
        ("--reuse paper", &["other settings"]),
        ("--layers occlusion", &["other settings"]),
        ("--backend rust", &["another version", "other settings"]),
        ("--base-place middle", &["other settings"]),
        ("--base-every 1", &["--base-every", "from 1 by 1"]),
    ] {
        render(&place, &format!("-o b.####.exr --frames 3 --load-store a.store {options}")).failed(words);
    }
    let in_auto = "--mode auto --progress none -o b.####.exr --frames 3 --load-store a.store";
    place.render(in_auto).failed(&["other settings"]);
    assert_eq!(place.names(""), ["a", "a.store"]);
    // what only makes pixels of samples is no matter
    render(
        &place,
        "-o a/a.####.exr --frames 3 --load-store a.store --filter tent --layers none --compression piz",
    )
    .done();
    let other = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/analytic/panel.toml");
    let options = "-o b/b.####.exr --frames 3 --size 64x36 --samples 2 --mode reproject --progress none --load-store a.store";
    Ran::new(place.command(other, options).output().unwrap()).failed(&["a.store", "another shot file"]);
    let ran = place.render("-o b/b.####.exr --mode full --load-store a.store");
    assert!(
        ran.code == 2 && ran.stderr.contains("--load-store") && ran.stderr.contains("full"),
        "{}",
        ran.stderr
    );
    for (options, words) in [
        ("-o b.####.exr --frames 1 --save-store b.0001.exr", "a frame of this run has that name"),
        ("--stats a.store --load-store a.store", "names the same file"),
        ("--save-store /dev/null", "give a file's name"),
    ] {
        let ran = render(&place, options);
        assert!(ran.code == 2 && ran.stderr.contains(words), "{options}: {}", ran.stderr);
    }
}

#[test]
fn what_is_no_store_is_refused() {
    let place = with_store();
    let whole = fs::read(place.path("a.store")).unwrap();
    let refused = |bytes: &[u8], words: &[&str]| {
        fs::write(place.path("bad.store"), bytes).unwrap();
        render(&place, "-o b.####.exr --frames 3 --load-store bad.store").failed(words);
    };
    refused(b"", &["bad.store", "no sample store", "--save-store"]);
    refused(b"afterimage", &["no sample store"]);
    refused(&fs::read(place.path("a/a.0001.exr")).unwrap(), &["no sample store"]);
    let mut later = whole.clone();
    later[MAGIC.len()] += 1;
    refused(&later, &[&format!("format {}", VERSION + 1), "render its frame again"]);
    render(&place, "-o b.####.exr --frames 3 --load-store gone.store")
        .failed(&["gone.store", "No such file"]);
    render(&place, "-o b.####.exr --frames 3 --load-store a").failed(&["no sample store"]);
    // nobody would ever write into it
    let fifo = place.path("fifo");
    assert!(Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    render(&place, "-o b.####.exr --frames 3 --load-store fifo").failed(&["no sample store"]);
}

/// Wherever a file ends, and whichever byte of it is another: an error, and nothing that is larger than the picture asks for.
#[test]
fn a_damaged_store_is_refused() {
    let place = with_store();
    let whole = fs::read(place.path("a.store")).unwrap();
    let bad = place.path("bad.store");
    let scene = runs::analytic();
    let shot = afterimage::scene::load(&scene, false).unwrap();
    let settings = Settings { width: 64, height: 36, samples: 2, ..shot.settings.clone() };
    let renderer = Renderer::new(&shot.scene, &settings).unwrap();
    let shape = renderer.shape();
    let (tiles, layout) = (&shape.tiles, shape.layout);
    let read = |bytes: &[u8]| {
        fs::write(&bad, bytes).unwrap();
        StoreFile::open(&bad).and_then(|file| file.read(&shape, &shot.scene)).map(drop)
    };
    read(&whole).unwrap();
    let kind = |bytes: &[u8]| read(bytes).expect_err("it is damaged").kind;
    for end in (0..MAGIC.len()).chain((MAGIC.len()..whole.len()).step_by(997)).chain([whole.len() - 1]) {
        let kind = kind(&whole[..end]);
        let expected = if end < MAGIC.len() {
            matches!(kind, StoreErrorKind::NoStore)
        } else {
            matches!(kind, StoreErrorKind::Short)
        };
        assert!(expected, "{end}: {kind:?}");
    }
    // all of the header, lengths of blocks, and samples
    for at in (0..800).chain((800..whole.len()).step_by(1009)) {
        for bit in [0x01, 0x80] {
            let mut bytes = whole.clone();
            bytes[at] ^= bit;
            read(&bytes).expect_err("a bit is another");
        }
    }
    assert!(matches!(kind(&[&whole[..], b"x"].concat()), StoreErrorKind::Damaged));
    for other in [vec![tiles[0] + 1], vec![tiles[0]; 2], vec![]] {
        let other = StoreShape { tiles: other, ..shape.clone() };
        assert!(StoreFile::open(&place.path("a.store")).unwrap().read(&other, &shot.scene).is_err());
    }
    // one that has right sums, and lies
    let (moment, pictures) = (Moment { frame: 2, rendered: 2, valid: ValidDirection::Both }, {
        let file = StoreFile::open(&place.path("a.store")).unwrap();
        file.read(&shape, &shot.scene).unwrap()
    });
    let lies: [&dyn Fn(&mut Snapshot); 5] = [
        &|snapshot| snapshot.pictures[0].levels[0].store.tiles[1].model[5] = 77,
        &|snapshot| {
            snapshot.pictures[0].levels[0].store.tiles[1]
                .record
                .iter_mut()
                .for_each(|record| record.triangle = 1 << 30)
        },
        &|snapshot| snapshot.pictures[0].levels[0].store.tiles[1].record[5].material = 999,
        &|snapshot| snapshot.pictures[0].levels[0].store.tiles[1].record[5].traced = Traced::new(3, 0),
        &|snapshot| snapshot.pictures[0].levels[0].store.tiles[1].y[5] = f32::NAN,
    ];
    for lie in lies {
        let mut snapshot = Snapshot::new(moment, &borrowed(&pictures));
        lie(&mut snapshot);
        store_file::write(&bad, &header(2, 2), &borrowed(&snapshot.pictures), layout).unwrap();
        let error = StoreFile::open(&bad).unwrap().read(&shape, &shot.scene).expect_err("it lies");
        assert!(matches!(error.kind, StoreErrorKind::Unfit), "{error}");
    }
    for rendered in [0, u32::MAX] {
        store_file::write(&bad, &header(2, rendered), &borrowed(&pictures), layout).unwrap();
        assert!(StoreFile::open(&bad).is_err());
    }
    // through the program, with nothing left behind
    fs::write(&bad, &whole[..whole.len() / 2]).unwrap();
    render(&place, "-o b.####.exr --frames 3 --load-store bad.store").failed(&["not whole", "--save-store"]);
}

/// Of pictures that the shot does not have, of one twice, or without one: nothing is taken.
#[test]
fn a_store_of_other_pictures_is_refused() {
    let scene = with_flyer(world());
    let settings = Settings { stereo: STEREO, shutter: HALF, exposures: Some(4), ..toy::settings(2) };
    let mut renderer = Renderer::new(&scene, &settings).unwrap();
    seen(&mut renderer, 1);
    let (_, pictures) = renderer.samples().unwrap();
    let shape = renderer.shape();
    let names: Vec<PictureName> = pictures.iter().map(|picture| picture.picture).collect();
    let name = |eye, exposure| PictureName { eye, exposure };
    let all: [PictureName; 8] =
        std::array::from_fn(|at| name(if at < 4 { Eye::Left } else { Eye::Right }, at % 4));
    assert_eq!(names, all);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.store");
    let kind = |names: [PictureName; 8], count: usize| {
        let renamed = pictures.iter().zip(names).take(count);
        let renamed: Vec<_> =
            renamed.map(|(of, picture)| PictureSamples { picture, levels: of.levels.clone() }).collect();
        store_file::write(&path, &header(1, 1), &renamed, shape.layout).unwrap();
        StoreFile::open(&path).unwrap().read(&shape, &scene).map(|read| read.len())
    };
    assert_eq!(kind(all, 8).unwrap(), 8);
    let mut bad = vec![(all, 7), (all, 4), (all, 0)];
    for (at, other) in [(7, name(Eye::Right, 4)), (1, all[0]), (2, all[3]), (3, all[4])] {
        let mut names = all;
        names[at] = other;
        bad.push((names, 8));
    }
    for (names, count) in bad {
        let error = kind(names, count).expect_err("they are not those of the shot");
        assert!(matches!(error.kind, StoreErrorKind::Unfit), "{error}");
    }
    // where one picture ends and the next one begins
    kind(all, 8).unwrap();
    let whole = fs::read(&path).unwrap();
    for end in (1..8).map(|eighth| whole.len() * eighth / 8) {
        fs::write(&path, &whole[..end]).unwrap();
        let error = StoreFile::open(&path).unwrap().read(&shape, &scene).expect_err("it ends early");
        assert!(matches!(error.kind, StoreErrorKind::Short), "{error}");
    }
}

#[test]
fn a_store_of_frames_that_are_exposed_otherwise_is_refused() {
    let place = Place::new();
    let blurred = "--shutter -0.25,0.25 --exposures 3";
    render(&place, &format!("-o a/a.####.exr --frames 1-2 {blurred} --save-store a.store")).done();
    let theirs = "2x2 samples a pixel, 4 exposures, a shutter from -0.25 to 0.25";
    for (options, ours) in [
        (
            "--shutter -0.25,0.25 --exposures 1",
            "this run has 2x2 samples a pixel, 1 exposure, a shutter from -0.25",
        ),
        ("--shutter 0,0.5 --exposures 3", "a shutter from 0 to 0.5"),
        ("--samples 3 --shutter -0.25,0.25 --exposures 3", "this run has 3x3 samples a pixel, 9 exposures"),
        ("--stereo --separation 0.1 --shutter -0.25,0.25 --exposures 3", "two eyes 0.1 apart"),
        ("--sharp", "this run has 2x2 samples a pixel)"),
    ] {
        render(&place, &format!("-o b.####.exr --frames 3 --load-store a.store {options}")).failed(&[
            "a.store",
            "other settings",
            theirs,
            ours,
            "--save-store",
        ]);
    }
    assert_eq!(place.names(""), ["a", "a.store"]);
    // another lens is another shot
    let text = fs::read_to_string(runs::analytic()).unwrap();
    let folder = runs::analytic().canonicalize().unwrap();
    let obj = format!("obj = \"{}/", folder.parent().unwrap().display());
    for (name, aperture) in [("wide", "0.2"), ("narrow", "0.1")] {
        let text =
            text.replace("obj = \"", &obj).replace("fov = 40", &format!("fov = 40\naperture = {aperture}"));
        fs::write(place.path(&format!("{name}.toml")), text).unwrap();
    }
    let run = |shot: &str, options: &str| {
        Ran::new(place.command(shot, &format!("{OPTIONS} --exposures 2 {options}")).output().unwrap())
    };
    run("wide.toml", "-o wide/a.####.exr --frames 1-4").done();
    run("wide.toml", "-o parts/a.####.exr --frames 1-2 --save-store a.store").done();
    run("wide.toml", "-o parts/a.####.exr --frames 3-4 --load-store a.store").done();
    assert_same_frames(&place, ["wide", "parts"], 1..=4);
    run("narrow.toml", "-o b.####.exr --frames 3 --load-store a.store").failed(&[
        "a.store",
        "another shot file",
        "--save-store",
    ]);
}

#[test]
fn a_store_appears_whole_or_not_at_all() {
    let place = Place::new();
    render(&place, "-o a/a.####.exr --frames 1-2 --save-store new/folder/a.store").done();
    assert_eq!(place.names("new/folder"), ["a.store"]);
    fs::write(place.path("taken"), "mine").unwrap();
    render(&place, "-o b/a.####.exr --frames 1 --save-store taken/a.store").failed(&["taken"]);
    assert_eq!(place.names(""), ["a", "new", "taken"]);
    // a run that fails saves nothing
    fs::create_dir_all(place.path("c/a.0002.exr")).unwrap();
    let ran = render(&place, "-o c/a.####.exr --frames 1-2 --save-store c.store");
    assert!(ran.code == 1 && !place.path("c.store").exists(), "{}", ran.stderr);
}

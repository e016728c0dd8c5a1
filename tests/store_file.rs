//! Does a run that goes on from a saved store make the frames of one that was never interrupted? What of files that are no good?
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

mod program;
mod toy;

use std::fs;
use std::path::Path;
use std::process::Command;

use afterimage::changes::Direction;
use afterimage::digest::Digest;
use afterimage::frame::{Finished, Holds, Moment, Renderer, Snapshot};
use afterimage::output::Fingerprint;
use afterimage::output::store_file::{self, Header, MAGIC, StoreErrorKind, StoreFile, VERSION};
use afterimage::samples::SampleStore;
use afterimage::samples::saved::LevelSamples;
use afterimage::scene::{Environment, Scene};
use afterimage::settings::{Budget, Filter, Mode, Refinement, Reuse, Settings};
use glam::DVec3;
use program::{Place, Ran, assert_same};
use toy::worlds::*;

const OPTIONS: &str = "--mode reproject --progress none";

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
    let digest = Digest::of(b"of a test");
    let fingerprint = Fingerprint { version: digest, shot: digest, inputs: digest, settings: digest };
    Header { fingerprint, frame, ancestry: String::from("base"), rendered }
}

fn borrowed(levels: &[LevelSamples<SampleStore>]) -> Vec<LevelSamples<&SampleStore>> {
    levels.iter().map(|level| LevelSamples { store: &level.store, wanted: level.wanted.clone() }).collect()
}

/// A renderer of another process, which goes on from what `renderer` has.
fn through_a_file<'s>(
    renderer: &Renderer<'_>,
    scene: &'s Scene,
    settings: &Settings,
    path: &Path,
) -> Renderer<'s> {
    let (moment, levels) = renderer.samples().unwrap();
    let bytes =
        store_file::write(path, &header(moment.frame, moment.rendered), &levels, renderer.shape().1).unwrap();
    assert_eq!(bytes, fs::metadata(path).unwrap().len());
    let mut other = Renderer::new(scene, settings).unwrap();
    let file = StoreFile::open(path).unwrap();
    assert_eq!(*file.header(), header(moment.frame, moment.rendered));
    let levels = file.read(&other.shape().0, other.shape().1, scene).unwrap();
    other.restore(Snapshot { moment, levels });
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

fn camera_turns(scene: Scene) -> Scene {
    with_camera(scene, rests(EYE), goes(TARGET, TARGET + DVec3::X))
}

fn under_a_sky(mut scene: Scene) -> Scene {
    scene.environment = Some(Environment::from_background(&scene.background));
    scene
}

/// From each frame of each of these to the next through a file.
#[test]
fn frames_after_a_store_are_those_of_one_run() {
    let plain = toy::settings(2);
    let paths = Settings { paths: 5, bounces: 2, ..toy::settings(1) };
    let budget = Settings { budget: Budget::Full, paths_per_frame: 2, ..paths.clone() };
    let wide = Settings { filter: Filter::Gaussian, mode: Mode::Auto, ..toy::settings(2) };
    let paper = Settings { reuse: Reuse::Paper, ..toy::settings(2) };
    let occluded = |mut scene: Scene| {
        scene.ambient_is_occluded = true;
        scene
    };
    let adaptive = Settings {
        refinement: Some(Refinement { most: 4, threshold: 0.1 }),
        paths: 2,
        bounces: 1,
        ..toy::settings(1)
    };
    let kinds: [(&str, Scene, &Settings); 11] = [
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
        let moves = scene.camera.eye.at(1.0) != scene.camera.eye.at(6.0) || name.contains("turns");
        let mut one = Renderer::new(&scene, settings).unwrap();
        let mut other = Renderer::new(&scene, settings).unwrap();
        for frame in 1..=FRAMES {
            let uninterrupted = one.render(frame, true).unwrap();
            let finished = other.render(frame, true).unwrap();
            assert_same_film(name, &uninterrupted, &finished, moves);
            assert_eq!(finished.stats.audit.unwrap().differing, 0, "{name}");
            if moves {
                assert_eq!(finished.stats.rays, uninterrupted.stats.rays, "{name}");
            }
            other = through_a_file(&other, &scene, settings, &folder.path().join("a.store"));
        }
    }
}

#[test]
fn answers_that_hold_backwards_come_back_as_such() {
    let scene = camera_goes(with_flyer(world()));
    let settings = Settings { paths: 4, bounces: 1, ..toy::settings(1) };
    let folder = tempfile::tempdir().unwrap();
    let [mut one, mut other] = [(); 2].map(|()| Renderer::new(&scene, &settings).unwrap());
    for frame in (1..=FRAMES).rev() {
        let [uninterrupted, finished] =
            [&mut one, &mut other].map(|renderer| renderer.render(frame, true).unwrap());
        assert_same_film("backwards", &uninterrupted, &finished, true);
        let direction = if frame == FRAMES { Direction::Forward } else { Direction::Backward };
        assert_eq!(
            one.samples().unwrap().0,
            Moment { frame, rendered: (FRAMES - frame + 1) as u32, holds: Holds::To(direction) }
        );
        other = through_a_file(&other, &scene, &settings, &folder.path().join("a.store"));
    }
}

#[test]
fn a_run_in_parts_makes_the_frames_of_the_whole() {
    for options in ["--layers all", "--layers all --paths 4 --budget full --paths-per-frame 2 --filter tent"]
    {
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
        assert_eq!(frames("whole.json")[6..], frames("a.json"));
        assert_eq!(place.names(""), ["a.json", "a.store", "parts", "whole", "whole.json"]);
    }
}

#[test]
fn a_store_of_a_middle_base_frame_serves_both_sides() {
    let place = Place::new();
    let options = "--base-every 5 --base-place middle --paths 2 --layers all";
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
    Ran::of(place.command(other, options).output().unwrap()).failed(&["a.store", "another shot file"]);
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
    let scene = program::analytic();
    let shot = afterimage::scene::load(&scene, false).unwrap();
    let settings = Settings { width: 64, height: 36, samples: 2, ..shot.settings.clone() };
    let renderer = Renderer::new(&shot.scene, &settings).unwrap();
    let (tiles, layout) = renderer.shape();
    let read = |bytes: &[u8]| {
        fs::write(&bad, bytes).unwrap();
        StoreFile::open(&bad).and_then(|file| file.read(&tiles, layout, &shot.scene)).map(drop)
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
        assert!(StoreFile::open(&place.path("a.store")).unwrap().read(&other, layout, &shot.scene).is_err());
    }
    // one that has right sums, and lies
    let (moment, levels) = (Moment { frame: 2, rendered: 2, holds: Holds::Both }, {
        let file = StoreFile::open(&place.path("a.store")).unwrap();
        file.read(&tiles, layout, &shot.scene).unwrap()
    });
    let lies: [&dyn Fn(&mut Snapshot); 5] = [
        &|snapshot| snapshot.levels[0].store.tiles[1].model[5] = 77,
        &|snapshot| {
            snapshot.levels[0].store.tiles[1].record.iter_mut().for_each(|record| record.triangle = 1 << 30)
        },
        &|snapshot| snapshot.levels[0].store.tiles[1].record[5].material = 999,
        &|snapshot| snapshot.levels[0].store.tiles[1].record[5].traced = 3,
        &|snapshot| snapshot.levels[0].store.tiles[1].y[5] = f32::NAN,
    ];
    for lie in lies {
        let mut snapshot = Snapshot::of(moment, &borrowed(&levels));
        lie(&mut snapshot);
        store_file::write(&bad, &header(2, 2), &borrowed(&snapshot.levels), layout).unwrap();
        let error = StoreFile::open(&bad).unwrap().read(&tiles, layout, &shot.scene).expect_err("it lies");
        assert!(matches!(error.kind, StoreErrorKind::Unfit), "{error}");
    }
    for rendered in [0, u32::MAX] {
        store_file::write(&bad, &header(2, rendered), &borrowed(&levels), layout).unwrap();
        assert!(StoreFile::open(&bad).is_err());
    }
    // through the program, with nothing left behind
    fs::write(&bad, &whole[..whole.len() / 2]).unwrap();
    render(&place, "-o b.####.exr --frames 3 --load-store bad.store").failed(&["not whole", "--save-store"]);
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

//! What a run leaves that did not get to its end: earlier frames whole, no half ones, and a way to go on.

use std::fs;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::time::Duration;

use rustix::mount::{UnmountFlags, unmount};

use crate::disk::Disk;
use crate::runs;
use crate::runs::{Place, Ran, assert_same, whole};

/// That all files under a frame's name are whole; says how many there are. Leftovers of a killed run are
/// hidden and end in `.part`.
#[track_caller]
fn whole_frames(place: &Place, folder: &str) -> usize {
    let names = place.names(folder);
    let (hidden, frames): (Vec<_>, Vec<_>) = names.iter().partition(|name| name.starts_with('.'));
    assert!(hidden.iter().all(|name| name.ends_with(".part")), "{hidden:?}");
    for name in &frames {
        let path = place.path(folder).join(name);
        if name.ends_with(".exr") {
            whole(&path);
        } else {
            image::open(&path).unwrap();
        }
    }
    frames.iter().filter(|name| name.ends_with(".exr")).count()
}

#[test]
fn a_file_where_the_folder_should_be_ends_the_run_before_it_begins() {
    let place = Place::new();
    fs::write(place.path("taken"), "mine").unwrap();
    let ran = place.render("-o taken/a.####.exr").failed(&["taken", "remove it", "another folder"]);
    assert_eq!(ran.stdout, "");
    assert_eq!(fs::read(place.path("taken")).unwrap(), b"mine");
    place.render("-o a.####.exr --stats taken/a.json").failed(&["taken"]);
    assert_eq!(place.names(""), ["taken"]);
}

#[test]
fn a_frame_that_cannot_be_written_is_named_and_those_before_stay() {
    let place = Place::new();
    // with one digit more, the temporary name is longer than file systems allow
    let longest = 255 - ".x.exr.TWELVELETTER.part".len();
    let name = "a".repeat(longest);
    let ran = place.render(&format!("-o {name}#.exr --frames 8-10 --stats a.json"));
    let ran = ran.failed(&[&format!("{name}10.exr"), "shorten the name"]);
    assert!(ran.stdout.contains("reused%"), "what was done is told: {}", ran.stdout);
    let stats: serde_json::Value = serde_json::from_slice(&fs::read(place.path("a.json")).unwrap()).unwrap();
    assert_eq!(stats["frames"].as_array().unwrap().len(), 2);
    fs::remove_file(place.path("a.json")).unwrap();
    assert_eq!(whole_frames(&place, ""), 2);
    assert_eq!(place.names("").len(), 2, "{:?}", place.names(""));
}

#[test]
fn a_full_disk_is_told_and_leaves_whole_frames_only() {
    let place = Place::new();
    place.render("-o whole/a.####.exr").done();
    let size = |frame| fs::metadata(place.path(&format!("whole/a.{frame:04}.exr"))).unwrap().len();
    let all: u64 = (1..=8).map(size).sum();
    let folder = place.path("disk");
    let Some(disk) = Disk::new(all / 2, &folder) else { return };
    let ran = place.render("-o disk/a.####.exr").failed(&["free space"]);
    let names = place.names("disk");
    let fitted = whole_frames(&place, "disk");
    assert!((2..=5).contains(&fitted) && names.len() == fitted, "{names:?}");
    let next = format!("a.{:04}.exr", fitted + 1);
    assert!(ran.stderr.contains(&next), "{next}: {}", ran.stderr);
    // nothing goes on while there is no room, and all goes on when there is
    place.render("-o disk/a.####.exr --resume").failed(&["disk", "free space"]);
    assert_eq!(place.names("disk"), names);
    names.iter().for_each(|name| fs::remove_file(folder.join(name)).unwrap());
    place.render("-o disk/a.####.exr --frames 6-8").done();
    assert_same(&folder.join("a.0007.exr"), &place.path("whole/a.0007.exr"));
    drop(disk);
}

/// Renders eight frames, and does that when the second one is told.
fn meanwhile(place: &Place, options: &str, act: impl FnOnce()) -> Ran {
    let options = format!("{options} --size 320x180 --progress plain");
    let mut command = place.command(runs::analytic(), &options);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    lines.by_ref().find(|line| line.contains("] frame 2: ")).unwrap();
    act();
    let stderr = lines.map(|line| line + "\n").collect();
    Ran { code: child.wait().unwrap().code().unwrap(), stdout: String::new(), stderr }
}

#[test]
fn frames_that_are_gone_at_the_end_are_told() {
    for (gone, options) in [("a.0001.exr", ""), ("a.0002.png", "--png")] {
        let place = Place::new();
        let options = format!("-o a.####.exr {options}");
        let ran = meanwhile(&place, &options, || fs::remove_file(place.path(gone)).unwrap());
        let frame = format!("frame {}", &gone[5..6]);
        ran.failed(&[&frame, "1 of 8", gone, "--resume"]);
        place.render(&format!("{options} --size 320x180 --resume")).done();
        assert_eq!(whole_frames(&place, ""), 8);
    }
}

#[test]
fn a_disk_that_is_gone_at_the_end_is_told() {
    let place = Place::new();
    let folder = place.path("disk");
    let Some(disk) = Disk::new(64 << 20, &folder) else { return };
    let ran = meanwhile(&place, "-o disk/a.####.exr", || unmount(&folder, UnmountFlags::DETACH).unwrap());
    drop(disk);
    // a file that was begun on the disk cannot get its name; otherwise the rest went into the folder below
    assert_eq!(ran.code, 1, "{}", ran.stderr);
    let found = whole_frames(&place, "disk");
    assert!(found < 8, "{found}");
    let told = ran.stderr.lines().last().unwrap();
    assert!(told.starts_with("error: ") && told.contains("disk/a.000"), "{told}");
}

#[test]
fn a_limit_on_files_is_told_and_leaves_nothing() {
    for (blocks, name, options) in [(8, "a.0001.exr", ""), (1, "a.0001.png", "--png"), (8, "s.json", "")] {
        let place = Place::new();
        let mut shell = Command::new("sh");
        let script = format!("ulimit -f {blocks} && exec \"$@\"");
        shell.args(["-c", &script, "sh", env!("CARGO_BIN_EXE_afterimage"), "render"]).arg(runs::analytic());
        let options = match name {
            // frames below the limit, and long statistics
            "s.json" => String::from("-o out/a.#.exr --size 2x1 --layers none --samples 1 --stats s.json"),
            _ => format!("-o out/a.####.exr --frames 1 --size 640x360 {options}"),
        };
        let shell = shell.current_dir(place.0.path()).args(options.split_whitespace());
        let ran = Ran::new(shell.output().unwrap()).failed(&[name, "ulimit -f"]);
        assert!(!ran.stderr.contains("free space"), "{}", ran.stderr);
        let left = place.names("out").len() + usize::from(place.path(name).exists());
        assert_eq!(left, if name == "s.json" { 8 } else { 0 });
        assert_eq!(place.names(""), ["out"], "no temporary file");
    }
}

/// Renders until `frame` is told, waits so long, and kills.
fn kill_after(place: &Place, options: &str, frame: usize, wait: Duration) {
    let mut command = place.command(runs::analytic(), &format!("{options} --progress plain"));
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let told = BufReader::new(child.stderr.take().unwrap());
    let done = format!("] frame {frame}: ");
    told.lines().map_while(Result::ok).find(|line| line.contains(&done));
    std::thread::sleep(wait);
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn a_killed_run_leaves_no_half_frame_and_goes_on_to_the_same_frames() {
    for every in [0, 3] {
        let place = Place::new();
        let options = format!("--mode reproject --base-every {every} --size 192x108 --png");
        place.render(&format!("-o all/a.####.exr {options}")).done();
        let options = format!("-o parts/a.####.exr {options} --resume");
        // at other moments of a frame each time; the longest wait is about a frame
        let mut frames = 0;
        for round in 0..5 {
            kill_after(&place, &options, frames + 1, Duration::from_millis(round * 7));
            let now = whole_frames(&place, "parts");
            assert!(now > frames || now == 8, "it goes on: {now} after {frames}");
            frames = now;
        }
        let last = place.render(&options).done();
        assert!(last.stderr.contains(&format!("resume: {frames} frames")), "{}", last.stderr);
        assert_eq!(whole_frames(&place, "parts"), 8);
        assert_eq!(place.names("parts").len(), 16, "nothing of the killed runs is left");
        for frame in 1..=8 {
            let path = |folder| place.path(&format!("{folder}/a.{frame:04}.exr"));
            assert_same(&path("all"), &path("parts"));
        }
    }
}

#[test]
fn frames_that_are_not_whole_are_made_again() {
    let place = Place::new();
    place.render("-o all/a.####.exr").done();
    place.render("-o some/a.####.exr").done();
    let path = |folder: &str, frame: i32| place.path(&format!("{folder}/a.{frame:04}.exr"));
    let bytes = fs::read(path("some", 2)).unwrap();
    fs::write(path("some", 2), &bytes[..bytes.len() - 100]).unwrap();
    fs::write(path("some", 3), "no picture").unwrap();
    fs::write(path("some", 4), "").unwrap();
    fs::remove_file(path("some", 6)).unwrap();
    let ran = place.render("-o some/a.####.exr --resume").done();
    assert!(ran.stderr.contains("resume: 4 frames"), "{}", ran.stderr);
    (1..=8).for_each(|frame| assert_same(&path("all", frame), &path("some", frame)));
    let before = fs::metadata(path("some", 2)).unwrap().modified().unwrap();
    place.render("-o some/a.####.exr --resume").done();
    assert_eq!(fs::metadata(path("some", 2)).unwrap().modified().unwrap(), before, "nothing was left to do");
}

/// That `--resume` with `options` keeps all frames but `again`, for which it says all of `words`.
#[track_caller]
fn assert_renders(place: &Place, options: &str, again: &[i32], words: &[&str]) {
    let changed =
        |frame: &i32| fs::metadata(place.path(&format!("a.{frame:04}.exr"))).unwrap().modified().unwrap();
    let before: Vec<_> = (1..=4).map(|frame| changed(&frame)).collect();
    let ran =
        Ran::new(place.command("s.toml", &format!("-o a.####.exr --resume {options}")).output().unwrap());
    let ran = ran.done();
    let frames: Vec<i32> = (1..=4).filter(|frame| changed(frame) != before[*frame as usize - 1]).collect();
    assert_eq!(frames, again, "{}", ran.stderr);
    let told: Vec<&str> = ran.stderr.lines().filter(|line| line.contains("rendering again")).collect();
    assert_eq!(told.len(), usize::from(!again.is_empty()), "{}", ran.stderr);
    words.iter().for_each(|word| assert!(told[0].contains(word), "`{word}` is not in: {}", told[0]));
    assert!(again.len() == 4 || ran.stderr.contains("there and whole"), "{}", ran.stderr);
}

const ALL: &[i32] = &[1, 2, 3, 4];

/// A shot of four frames with a model, its material and a texture.
fn small_shot(place: &Place) {
    let write = |name: &str, text: &str| fs::write(place.path(name), text).unwrap();
    write("s.toml", SHOT);
    write(
        "m.obj",
        "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n",
    );
    write("m.mtl", "newmtl a\nKd 1 1 1\nmap_Kd t.png\n");
    image::RgbImage::from_pixel(2, 2, image::Rgb([9, 99, 200])).save(place.path("t.png")).unwrap();
    Ran::new(place.command("s.toml", "-o a.####.exr --png").output().unwrap()).done();
}

const SHOT: &str = "title = \"one\"
[render]
size = [16, 9]
samples = 1
frames = \"1-4\"
mode = \"reproject\"
base_every = 0
[[camera.key]]
frame = 1
eye = [0, 0, 5]
target = [0, 0, 0]
[[camera.key]]
frame = 4
eye = [1, 0, 5]
target = [0, 0, 0]
[[model]]
obj = \"m.obj\"
[[light]]
type = \"directional\"
direction = [0, 0, -1]
";

#[test]
fn frames_of_another_shot_are_made_again_and_the_reason_is_told() {
    let place = Place::new();
    small_shot(&place);
    assert_renders(&place, "", &[], &[]);
    let write = |name: &str, text: &str| fs::write(place.path(name), text).unwrap();
    // neither layout nor settings that change no pixel make another frame
    write("s.toml", &format!("# by day\n{}", SHOT.replace("one", "two").replace("= 1\n", "   =   1\n")));
    assert_renders(&place, "--threads 1 --audit", &[], &[]);
    write("s.toml", &SHOT.replace("[0, 0, -1]", "[0, 1, -1]"));
    assert_renders(&place, "", ALL, &["frames 1-4", "another shot file)"]);
    for (name, text) in [
        (
            "m.obj",
            "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 2 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n",
        ),
        ("m.mtl", "newmtl a\nKd 1 1 0\nmap_Kd t.png\n"),
    ] {
        write(name, text);
        assert_renders(
            &place,
            "",
            ALL,
            &["frames 1-4", "(made with other models, materials, textures or maps)"],
        );
    }
    image::RgbImage::from_pixel(2, 2, image::Rgb([9, 99, 201])).save(place.path("t.png")).unwrap();
    assert_renders(&place, "", ALL, &["textures or maps)"]);
    let with_map = format!("{SHOT}[environment]\nmap = \"map.exr\"\n");
    write("s.toml", &with_map);
    fs::copy(place.path("a.0001.exr"), place.path("map.exr")).unwrap();
    assert_renders(&place, "", ALL, &["another shot file"]);
    fs::copy(place.path("a.0004.exr"), place.path("map.exr")).unwrap();
    assert_renders(&place, "", ALL, &["textures or maps)"]);
    assert_renders(&place, "--samples 2", ALL, &["(made with other settings)"]);
    assert_renders(&place, "--samples 2 --multipart", ALL, &["(made with other settings)"]);
    assert_renders(&place, "--samples 2 --background visible", ALL, &["(made with other settings)"]);
    assert_renders(&place, "--samples 2 --compression zip", ALL, &["(made with other settings)"]);
    assert_renders(&place, "--samples 2 --size 17x9", ALL, &["(made with other settings)"]);
    assert_renders(&place, "--samples 2 --size 17x9 --crop 9x5+8+1", ALL, &["(made with other settings)"]);
    assert_renders(&place, "--samples 2 --size 17x9 --overscan 1", ALL, &["(made with other settings)"]);
    // the same pixels, by another name
    assert_renders(&place, "--samples 2 --size 17x9 --overscan 2 --crop 19x11-1-1", &[], &[]);
    assert_renders(&place, "--samples 2 --size 17x9", ALL, &["(made with other settings)"]);
    // nobody asks for occlusion
    assert_renders(&place, "--samples 2 --size 17x9 --occlusion-rays 3 --occlusion-radius 9", &[], &[]);
    for more in ["", " --occlusion-rays 3", " --occlusion-radius 9"] {
        let options = format!("--samples 2 --size 17x9 --layers occlusion{more}");
        assert_renders(&place, &options, ALL, &["(made with other settings)"]);
    }
    assert_renders(
        &place,
        "--samples 2 --size 17x9 --backend rust",
        ALL,
        &["version of the program", "other settings"],
    );
    assert_renders(&place, "--samples 2 --size 17x9 --backend rust", &[], &[]);
}

#[test]
fn kept_frames_have_the_ancestry_that_the_run_would_give_them() {
    let place = Place::new();
    small_shot(&place);
    // frame 1 is a base frame in any case, and 2 is inferred from it
    assert_renders(&place, "--base-every 2", &[3, 4], &["frames 3-4", "other settings"]);
    // in steps of two all of them are base frames
    assert_renders(
        &place,
        "--base-every 2 --frames 1-4x2,2-4x2",
        &[2, 4],
        &["frames 2, 4", "other settings"],
    );
    assert_renders(&place, "--base-every 0 --frames 1-4x3,2-3", &[2, 3, 4], &["frames 2-4"]);
    assert_renders(&place, "--mode full", ALL, &["other settings"]);
    assert_renders(&place, "--mode full --base-every 3 --frames 2-4x2", &[], &[]);
}

#[test]
fn frames_that_do_not_say_what_they_are_made_from_are_made_again() {
    let place = Place::new();
    small_shot(&place);
    // a picture of another program: the same bytes without the attribute that names what it is made from
    let bytes = fs::read(place.path("a.0002.exr")).unwrap();
    let at = bytes.windows(11).position(|word| word == b"fingerprint").unwrap();
    let mut renamed = bytes.clone();
    renamed[at] = b'F';
    fs::write(place.path("a.0002.exr"), renamed).unwrap();
    assert_renders(&place, "", &[2], &["frame 2 (without a fingerprint"]);
    fs::remove_file(place.path("a.0003.png")).unwrap();
    fs::copy(place.path("t.png"), place.path("a.0004.png")).unwrap();
    assert_renders(&place, "", &[], &[]);
    assert_renders(&place, "--png", &[3, 4], &["frames 3-4 (without the preview that is asked for)"]);
    // the preview belongs to the frame: one of another run does not count
    assert_renders(&place, "--samples 2", ALL, &["other settings"]);
    assert_renders(&place, "--samples 2 --png", ALL, &["without the preview"]);
    assert_renders(&place, "--samples 2 --png", &[], &[]);
}

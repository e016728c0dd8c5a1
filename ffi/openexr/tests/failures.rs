//! Does every failure name the file and say what to do?

#![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

use std::fs::{self, File};
use std::path::Path;
use std::process::Command;

use openexr::{Attribute, Channel, Compression, Data, Error, Image, SampleType, read, write};
use rustix::mount::{MountFlags, UnmountFlags, mount, unmount};
use tempfile::tempdir;

const SIDE: u32 = 300;

fn attempt(path: &Path, names: &[&str], data: &[f32]) -> Result<(), Error> {
    let stored = SampleType::Half;
    let channels = names.iter().map(|name| Channel { name, stored, data: Data::Floats(data) }).collect();
    let (attributes, compression) = (Vec::new(), Compression::Zips);
    let image = Image { width: SIDE, height: SIDE, placed: None, channels, attributes, compression };
    write(&File::create(path).unwrap(), path, &image)
}

fn plane() -> Vec<f32> {
    (0..SIDE * SIDE).map(|index| (index % 97) as f32).collect()
}

#[test]
fn a_nan_on_the_last_line_is_named() {
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let folder = tempdir().unwrap();
        let path = folder.path().join("frame.exr");
        let mut data = plane();
        let last = data.len() - 1;
        data[last - 5] = value;
        let text = attempt(&path, &["N.X"], &data).unwrap_err().to_string();
        assert!(text.contains("frame.exr") && text.contains("\"N.X\""), "{text}");
        assert!(text.contains("(294, 299)"), "{text}");
    }
}

#[test]
fn bad_channels_are_refused() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("frame.exr");
    let data = plane();
    let long = "a.bcdefghijklmnopqrstuvwxyz01234"; // 32 bytes
    let cases: [(&[&str], &str); 6] = [
        (&[], "no channel"),
        (&[""], "empty"),
        (&[long], "31 bytes"),
        (&["a.b.c"], "one dot"),
        (&["R", "G", "R"], "twice"),
        (&["R\0"], "control"),
    ];
    for (names, expected) in cases {
        let text = attempt(&path, names, &data).unwrap_err().to_string();
        assert!(text.contains(expected) && text.contains("frame.exr"), "{names:?}: {text}");
    }
    attempt(&path, &[&long[..31]], &data).unwrap();
    let text = attempt(&path, &["R"], &data[1..]).unwrap_err().to_string();
    assert!(text.contains("89999") && text.contains("90000"), "{text}");
}

#[test]
fn bad_attributes_are_refused() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("frame.exr");
    let cases = [
        ("text", Attribute::Text("a\0b".into())),
        ("", Attribute::Int(1)),
        ("a_name_that_is_longer_than_31_bytes", Attribute::Int(1)),
        ("other", Attribute::Other("keycode".into())),
        ("channels", Attribute::Int(1)), // not of that type
    ];
    for (name, value) in cases {
        let channels = vec![Channel { name: "R", stored: SampleType::Half, data: Data::Floats(&[1.0]) }];
        let attributes = vec![(name.to_owned(), value)];
        let compression = Compression::Zips;
        let image = Image { width: 1, height: 1, placed: None, channels, attributes, compression };
        assert!(write(&File::create(&path).unwrap(), &path, &image).is_err(), "{name}");
    }
}

#[test]
fn a_full_disk_is_told() {
    let folder = tempdir().unwrap();
    if mount("tmpfs", folder.path(), "tmpfs", MountFlags::empty(), c"size=8k").is_err() {
        eprintln!("skipped: mounting a small file system needs root's rights");
        return;
    }
    let outcome = attempt(&folder.path().join("frame.exr"), &["R", "G"], &plane());
    unmount(folder.path(), UnmountFlags::empty()).unwrap();
    let text = outcome.unwrap_err().to_string();
    assert!(text.contains("frame.exr") && text.contains("free space"), "{text}");
}

#[test]
fn a_file_size_limit_is_told() {
    // Works without root: a process with a small limit runs this very test binary.
    const CHILD: &str = "OPENEXR_TEST_LIMITED_FOLDER";
    if let Some(folder) = std::env::var_os(CHILD) {
        let text = attempt(&Path::new(&folder).join("f.exr"), &["R", "G"], &plane());
        println!("{}", text.unwrap_err());
        return;
    }
    let folder = tempdir().unwrap();
    let this = std::env::current_exe().unwrap();
    let script = "trap '' XFSZ; ulimit -f 16; exec \"$0\" --nocapture --exact \
                  a_file_size_limit_is_told";
    let output = Command::new("sh").args(["-c", script]).arg(this).env(CHILD, folder.path()).output();
    let output = output.unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{output:?}");
    assert!(said.contains("f.exr") && said.contains("ulimit -f"), "{said}");
}

#[test]
fn what_is_no_regular_file_is_refused_and_never_waited_for() {
    let folder = tempdir().unwrap();
    let fifo = folder.path().join("fifo.exr");
    assert!(Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    let device = folder.path().join("device.exr");
    std::os::unix::fs::symlink("/dev/zero", &device).unwrap();
    for path in [&*fifo, &device, folder.path()] {
        let text = read(path).unwrap_err().to_string();
        assert!(text.contains("regular file") && text.contains(path.to_str().unwrap()), "{text}");
    }
}

#[test]
fn files_that_are_no_images_are_refused() {
    let folder = tempdir().unwrap();
    let good = folder.path().join("good.exr");
    attempt(&good, &["R"], &plane()).unwrap();
    let bytes = fs::read(&good).unwrap();
    let cases = [
        ("empty", Vec::new()),
        ("text", b"this is no image, but it is long enough to be looked at".to_vec()),
        ("header", bytes[..100].to_vec()),
        ("half", bytes[..bytes.len() / 2].to_vec()),
        ("short", bytes[..bytes.len() - 1].to_vec()),
    ];
    for (name, content) in cases {
        let path = folder.path().join(name);
        fs::write(&path, content).unwrap();
        let text = read(&path).unwrap_err().to_string();
        assert!(text.contains(name), "{text}");
    }
    let text = read(&folder.path().join("absent.exr")).unwrap_err().to_string();
    assert!(text.contains("check the name"), "{text}");
}

#[test]
fn pixels_that_are_damaged_are_told_by_file_and_line_and_what_to_do() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("frame.exr");
    attempt(&path, &["R"], &plane()).unwrap();
    let mut bytes = fs::read(&path).unwrap();
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    fs::write(&path, bytes).unwrap();
    let text = read(&path).unwrap_err().to_string();
    for words in ["frame.exr: ", "line 300: the file is damaged or cut short, make it again"] {
        assert!(text.contains(words), "{text}");
    }
}

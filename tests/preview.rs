//! Does the page of `preview` show the shot, follow its changes, and tell what is wrong until it is mended?
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

mod small_shot;

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

/// The program, ended with the test.
struct Preview {
    child: Child,
    address: String,
}

impl Drop for Preview {
    fn drop(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

impl Preview {
    fn of(shot: &Path) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage"));
        let command = command.arg("preview").arg(shot).args(["--size", "16x9", "--paths", "1"]);
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let (_, address) = line.split_once("http://").unwrap();
        let address = address.split_once('/').unwrap().0.to_owned();
        assert!(address.starts_with("127.0.0.1:"), "{line}");
        Self { child, address }
    }

    /// Status line and body.
    fn get(&self, path: &str) -> (String, Vec<u8>) {
        let mut stream = TcpStream::connect(&self.address).unwrap();
        write!(stream, "GET {path} HTTP/1.1\r\nHost: {}\r\n\r\n", self.address).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        let end = answer.windows(4).position(|bytes| bytes == b"\r\n\r\n").unwrap();
        let head = String::from_utf8(answer[..end].to_vec()).unwrap();
        (head.lines().next().unwrap().to_owned(), answer[end + 4..].to_vec())
    }

    /// The state, once it is as `wanted`.
    fn state(&self, wanted: impl Fn(&Value) -> bool) -> Value {
        let start = Instant::now();
        loop {
            let state = serde_json::from_slice(&self.get("/state").1).unwrap();
            if wanted(&state) {
                return state;
            }
            assert!(start.elapsed() < Duration::from_secs(60), "{state}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn picture(&self, state: &Value, frame: i32) -> image::RgbImage {
        let (status, png) = self.get(&format!("/frame/{}/{frame}", state["version"]));
        assert!(status.ends_with("200 OK"), "{status}");
        image::load_from_memory(&png).unwrap().into_rgb8()
    }
}

#[test]
fn the_page_follows_the_shot() {
    let folder = small_shot::folder();
    let shot = folder.path().join("s.toml");
    let text = |color: &str| {
        format!("[render]\nframes = \"1-3\"\n[background]\ncolor = [{color}]\n{}", small_shot::REST)
    };
    std::fs::write(&shot, text("1, 0, 0")).unwrap();
    let preview = Preview::of(&shot);
    let (status, page) = preview.get("/");
    assert!(status.ends_with("200 OK") && page.starts_with(b"<!doctype html>"), "{status}");
    let state = preview.state(|state| state["version"] != 0);
    assert_eq!((&state["runs"], &state["error"]), (&serde_json::json!([[1, 3, 1]]), &Value::Null));
    for frame in [1, 3, 2] {
        let picture = preview.picture(&state, frame);
        assert_eq!((picture.dimensions(), picture.get_pixel(0, 0).0), ((16, 9), [255, 0, 0]));
    }
    assert!(preview.get(&format!("/frame/{}/4", state["version"])).0.contains("404"));

    // broken, mended, and another picture
    std::fs::write(&shot, text("0, 1")).unwrap();
    let broken = preview.state(|state| !state["error"].is_null());
    let error = broken["error"].as_str().unwrap();
    assert!(error.contains("s.toml:4:9"), "{error}");
    assert!(preview.get(&format!("/frame/{}/1", broken["version"])).0.contains("404"));
    std::fs::write(&shot, text("0, 1, 0")).unwrap();
    let mended = preview.state(|state| state["error"].is_null());
    assert_eq!(preview.picture(&mended, 1).get_pixel(0, 0).0, [0, 255, 0]);
    assert!(preview.get(&format!("/frame/{}/1", state["version"])).0.contains("404"), "the old shot is gone");

    // what the shot names counts as well: a file that goes and comes back
    let model = folder.path().join("m.obj");
    std::fs::remove_file(&model).unwrap();
    let missing = preview.state(|state| !state["error"].is_null());
    assert!(missing["error"].as_str().unwrap().contains("m.obj"), "{missing}");
    std::fs::write(&model, small_shot::OBJ).unwrap();
    let back = preview.state(|state| state["error"].is_null());
    assert_eq!(preview.picture(&back, 1).dimensions(), (16, 9));
}

#[test]
fn a_fifo_or_a_device_in_the_shots_place_is_told_until_it_is_gone() {
    let folder = small_shot::folder();
    let [shot, kept] = ["s.toml", "kept.toml"].map(|name| folder.path().join(name));
    std::fs::write(&shot, small_shot::REST).unwrap();
    let preview = Preview::of(&shot);
    for what in ["FIFO", "device"] {
        preview.state(|state| state["version"] != 0 && state["error"].is_null());
        std::fs::rename(&shot, &kept).unwrap();
        match what {
            "FIFO" => rustix::fs::mknodat(
                rustix::fs::CWD,
                &shot,
                rustix::fs::FileType::Fifo,
                rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR,
                0,
            )
            .unwrap(),
            _ => std::os::unix::fs::symlink("/dev/zero", &shot).unwrap(),
        }
        let told = preview.state(|state| state["error"].as_str().is_some_and(|text| text.contains(what)));
        assert!(told["error"].as_str().unwrap().contains("s.toml"), "{told}");
        std::fs::rename(&kept, &shot).unwrap();
    }
    let back = preview.state(|state| state["error"].is_null());
    preview.picture(&back, 1);
}

#[test]
fn a_shot_that_is_yet_to_be_written_is_waited_for() {
    let folder = small_shot::folder();
    let preview = Preview::of(&folder.path().join("s.toml"));
    preview.state(|state| !state["error"].is_null());
    std::fs::write(folder.path().join("s.toml"), small_shot::REST).unwrap();
    let state = preview.state(|state| state["error"].is_null());
    preview.picture(&state, 1);
}

#[test]
fn a_port_that_is_taken_is_told() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage"));
    let output = command.args(["preview", "a.toml", "--port", &port]).output().unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(1) && text.contains(&port) && text.contains("--port"), "{text}");
}

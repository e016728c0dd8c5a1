//! Does the page of `preview` show the shot, follow its changes, and tell what is wrong until it is mended?

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::small_shot;

/// The program, ended with the test.
struct Preview {
    child: Child,
    /// Of the machine, with the port.
    host: String,
    /// What the address of the page has in it.
    token: String,
}

impl Drop for Preview {
    fn drop(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

impl Preview {
    fn new(shot: &Path) -> Self {
        Self::of_size(shot, "16x9")
    }

    fn of_size(shot: &Path, size: &str) -> Self {
        Self::with(shot, &["--size", size])
    }

    fn with(shot: &Path, options: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage"));
        let command = command.arg("preview").arg(shot).args(["--paths", "1"]).args(options);
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let (_, address) = line.split_once("http://").unwrap();
        let (host, behind) = address.split_once('/').unwrap();
        let (token, _) = behind.split_once('/').unwrap();
        assert!(host.starts_with("127.0.0.1:") && token.len() >= 32, "{line}");
        Self { child, host: host.to_owned(), token: token.to_owned() }
    }

    fn connect(&self) -> TcpStream {
        TcpStream::connect(&self.host).unwrap()
    }

    /// Head and body of what `request` gets, as it is sent.
    fn ask(&self, request: &str) -> (String, Vec<u8>) {
        let mut stream = self.connect();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        let end = answer.windows(4).position(|bytes| bytes == b"\r\n\r\n").unwrap();
        (String::from_utf8(answer[..end].to_vec()).unwrap(), answer[end + 4..].to_vec())
    }

    /// The status of what the page asks with these lines in the head.
    fn status_with(&self, headers: &str) -> String {
        let request = format!("GET /{}/state HTTP/1.1\r\n{headers}\r\n", self.token);
        self.ask(&request).0.lines().next().unwrap().to_owned()
    }

    /// Status line and body of what is at `path` in the page's folder.
    fn get(&self, path: &str) -> (String, Vec<u8>) {
        let Self { host, token, .. } = self;
        let (head, body) = self.ask(&format!("GET /{token}/{path} HTTP/1.1\r\nHost: {host}\r\n\r\n"));
        (head.lines().next().unwrap().to_owned(), body)
    }

    /// The state, once it is as `wanted`.
    fn state(&self, wanted: impl Fn(&Value) -> bool) -> Value {
        let start = Instant::now();
        loop {
            let state = serde_json::from_slice(&self.get("state").1).unwrap();
            if wanted(&state) {
                return state;
            }
            assert!(start.elapsed() < Duration::from_secs(60), "{state}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn picture(&self, state: &Value, frame: i32) -> image::RgbImage {
        self.picture_at(&format!("frame/{}/{frame}", state["version"]))
    }

    /// What `camera` sees at `frame`.
    fn view(&self, state: &Value, frame: i32, detail: &str, camera: &str) -> image::RgbImage {
        self.picture_at(&format!("view/{}/{frame}/1/{detail}/{camera}", state["version"]))
    }

    fn picture_at(&self, path: &str) -> image::RgbImage {
        let (status, png) = self.get(path);
        assert!(status.ends_with("200 OK"), "{path}: {status}");
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
    let preview = Preview::new(&shot);
    let (status, page) = preview.get("");
    assert!(status.ends_with("200 OK") && page.starts_with(b"<!doctype html>"), "{status}");
    let state = preview.state(|state| state["version"] != 0);
    assert_eq!((&state["runs"], &state["error"]), (&serde_json::json!([[1, 3, 1]]), &Value::Null));
    for frame in [1, 3, 2] {
        let picture = preview.picture(&state, frame);
        assert_eq!((picture.dimensions(), picture.get_pixel(0, 0).0), ((16, 9), [255, 0, 0]));
    }
    assert!(preview.get(&format!("frame/{}/4", state["version"])).0.contains("404"));

    // broken, mended, and another picture
    std::fs::write(&shot, text("0, 1")).unwrap();
    let broken = preview.state(|state| !state["error"].is_null());
    let error = broken["error"].as_str().unwrap();
    assert!(error.contains("s.toml:4:9"), "{error}");
    assert!(preview.get(&format!("frame/{}/1", broken["version"])).0.contains("404"));
    std::fs::write(&shot, text("0, 1, 0")).unwrap();
    let mended = preview.state(|state| state["error"].is_null());
    assert_eq!(preview.picture(&mended, 1).get_pixel(0, 0).0, [0, 255, 0]);
    assert!(preview.get(&format!("frame/{}/1", state["version"])).0.contains("404"), "the old shot is gone");

    // what the shot names counts as well: a file that goes and comes back
    let model = folder.path().join("m.obj");
    std::fs::remove_file(&model).unwrap();
    let missing = preview.state(|state| !state["error"].is_null());
    assert!(missing["error"].as_str().unwrap().contains("m.obj"), "{missing}");
    std::fs::write(&model, small_shot::OBJ).unwrap();
    let back = preview.state(|state| state["error"].is_null());
    assert_eq!(preview.picture(&back, 1).dimensions(), (16, 9));
}

/// Frames and what led cameras see are shown with the look of the command line, or else with the shot's.
#[test]
fn a_look_beats_that_of_the_shot() {
    let folder = small_shot::folder();
    let shot = folder.path().join("s.toml");
    let output = "[output]\nexposure = 3\nview = \"agx\"\n";
    std::fs::write(&shot, format!("{output}[background]\ncolor = [0.5, 0.25, 0]\n{}", small_shot::REST))
        .unwrap();
    let corner = |options: &[&str]| {
        let preview = Preview::with(&shot, &[&["--size", "16x9"], options].concat());
        let state = preview.state(|state| state["version"] != 0);
        let picture = preview.picture(&state, 1);
        let led = preview.view(&state, 1, "full", "0,0,-500,0,0,-900,0,40");
        assert_eq!(led.get_pixel(0, 0), picture.get_pixel(0, 0), "{options:?}");
        picture.get_pixel(0, 0).0
    };
    assert_eq!(corner(&["--exposure", "1", "--view", "standard"]), [255, 188, 0]);
    assert_eq!(corner(&["--exposure", "-1", "--view", "standard"]), [137, 99, 0]);
    let of_shot = corner(&[]);
    assert!(of_shot[2] > 0, "{of_shot:?}: AgX moves bright colours towards white");
    assert_ne!(corner(&["--exposure", "1"]), of_shot);
}

/// Frame 1 has the camera before two triangles in the light, and in frame 3 it is elsewhere.
fn lit(keys: &str) -> String {
    format!(
        "[render]\nframes = \"1-3\"\n[background]\ncolor = [0, 0, 1]\n[[light]]\ntype = \"directional\"\ndirection = [0, 0, -1]\n\
         {keys}[[model]]\nobj = \"m.obj\"\n"
    )
}

const KEYS: &str = "[[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nfov = 30\n\
                    [[camera.key]]\nframe = 3\neye = [2, 0, 5]\ntarget = [0, 0, 0]\n";

#[test]
fn a_camera_that_is_led_around_can_be_copied_into_the_shot() {
    let folder = small_shot::folder();
    let shot = folder.path().join("s.toml");
    std::fs::write(&shot, lit(KEYS)).unwrap();
    let preview = Preview::new(&shot);
    let state = preview.state(|state| state["version"] != 0);
    assert_eq!(state["size"], serde_json::json!([16, 9]));
    let version = &state["version"];

    // it begins where the shot's is, and shows the same there
    let camera: Value = serde_json::from_slice(&preview.get(&format!("camera/{version}/3")).1).unwrap();
    let expected = serde_json::json!({
        "eye": [2.0, 0.0, 5.0], "target": [0.0, 0.0, 0.0], "roll": 0.0, "lens": 30.0, "orthographic": false,
    });
    assert_eq!(camera, expected);
    assert_eq!(preview.view(&state, 3, "full", "2,0,5,0,0,0,0,30"), preview.picture(&state, 3));

    // elsewhere: coarse at first, in full when asked for
    let elsewhere = "1,1.5,3,0.5,0.5,0,10,25";
    let coarse = preview.view(&state, 2, "coarse", elsewhere);
    let full = preview.view(&state, 2, "full", elsewhere);
    assert!(
        coarse.width() < 16 && full.dimensions() == (16, 9),
        "{:?} {:?}",
        coarse.dimensions(),
        full.dimensions()
    );
    assert_ne!(full, preview.picture(&state, 2));
    assert!(full.pixels().any(|pixel| pixel.0 != [0, 0, 255]), "it sees something");

    // what is copied is a key that shows just that
    let (status, key) = preview.get(&format!("key/{version}/2/{elsewhere}"));
    let key = String::from_utf8(key).unwrap();
    assert!(
        status.ends_with("200 OK") && key.starts_with("[[camera.key]]\nframe = 2\neye = [1, 1.5, 3]\n"),
        "{key}"
    );
    std::fs::write(&shot, lit(&key)).unwrap();
    let changed = preview.state(|state| state["version"] != *version);
    assert_eq!(changed["error"], Value::Null);
    assert_eq!(preview.picture(&changed, 2), full);

    for (path, code) in [
        (format!("camera/{version}/3"), "404"),
        (format!("camera/{}/4", changed["version"]), "404"),
        (format!("key/{}/1/0,0,1,0,0,0,0", changed["version"]), "400"),
        (format!("key/{}/1/0,0,0,0,0,0,0,40", changed["version"]), "400"),
        (format!("view/{}/1/1/full/0,0,1,0,0,0,0,180", changed["version"]), "400"),
        (format!("view/{}/1/1/full/0,0,NaN,0,0,0,0,40", changed["version"]), "400"),
        (format!("view/{}/1/1/fine/0,0,1,0,0,0,0,40", changed["version"]), "400"),
        (format!("view/{}/1/x/full/0,0,1,0,0,0,0,40", changed["version"]), "400"),
        (format!("view/{version}/1/1/full/0,0,1,0,0,0,0,40"), "404"),
    ] {
        let (status, _) = preview.get(&path);
        assert!(status.contains(code), "{path}: {status}");
    }
}

#[test]
fn the_first_picture_of_a_large_view_is_a_small_one() {
    let folder = small_shot::folder();
    let shot = folder.path().join("s.toml");
    std::fs::write(&shot, lit(KEYS)).unwrap();
    let preview = Preview::of_size(&shot, "640x360");
    let state = preview.state(|state| state["version"] != 0);
    let coarse = preview.view(&state, 1, "coarse", "1,1.5,3,0.5,0.5,0,10,25");
    assert_eq!(coarse.dimensions(), (160, 90));
}

#[test]
fn a_fifo_or_a_device_in_the_shots_place_is_told_until_it_is_gone() {
    let folder = small_shot::folder();
    let [shot, kept] = ["s.toml", "kept.toml"].map(|name| folder.path().join(name));
    std::fs::write(&shot, small_shot::REST).unwrap();
    let preview = Preview::new(&shot);
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
    let preview = Preview::new(&folder.path().join("s.toml"));
    preview.state(|state| !state["error"].is_null());
    std::fs::write(folder.path().join("s.toml"), small_shot::REST).unwrap();
    let state = preview.state(|state| state["error"].is_null());
    preview.picture(&state, 1);
}

#[test]
fn the_page_has_all_that_it_names() {
    let folder = small_shot::folder();
    let preview = Preview::new(&folder.path().join("s.toml"));
    let page = String::from_utf8(preview.get("").1).unwrap();
    for (name, kind) in [
        ("page.css", "text/css"),
        ("page.js", "text/javascript"),
        ("camera.js", "text/javascript"),
        ("icon.svg", "image/svg+xml"),
    ] {
        assert!(page.contains(&format!("\"{name}\"")), "{page}");
        let request = format!("GET /{}/{name} HTTP/1.1\r\nHost: {}\r\n\r\n", preview.token, preview.host);
        let (head, body) = preview.ask(&request);
        assert!(head.starts_with("HTTP/1.1 200") && head.contains(kind) && !body.is_empty(), "{head}");
    }
    // the policy allows none of these
    assert!(!page.contains("<style") && !page.contains("style=") && !page.contains(" on"), "{page}");
}

#[test]
fn other_pages_and_other_users_see_nothing() {
    let folder = small_shot::folder();
    let preview = Preview::new(&folder.path().join("s.toml"));
    let Preview { host, token, .. } = &preview;
    let port = host.split_once(':').unwrap().1;
    let own = format!("Host: {host}\r\n");
    let same = format!("Host: localhost:{port}\r\nSec-Fetch-Site: same-origin\r\n");
    for headers in [&own, &same, &format!("{own}Sec-Fetch-Site: none\r\n")] {
        assert_eq!(preview.status_with(headers), "HTTP/1.1 200 OK", "{headers}");
    }
    for (headers, code) in [
        (String::new(), "400"),
        (format!("Host: evil.example:{port}\r\n{own}"), "400"),
        (format!("{own}{own}"), "400"),
        (format!("Host: evil.example:{port}\r\n"), "403"),
        (String::from("Host: 127.0.0.1:evil.com\r\n"), "403"),
        (String::from("Host: 127.0.0.1\r\n"), "403"),
        (format!("{own}Sec-Fetch-Site: cross-site\r\n"), "403"),
        (format!("{own}Sec-Fetch-Site: same-site\r\n"), "403"),
        (format!("{own}Sec-Fetch-Site: none\r\nsec-fetch-site: cross-site\r\n"), "403"),
    ] {
        let status = preview.status_with(&headers);
        assert!(status.contains(code), "{headers}: {status}");
    }

    let other = format!("{}{}", if token.starts_with('0') { '1' } else { '0' }, &token[1..]);
    for path in
        ["/", "/state", "/favicon.ico", "/frame/1/1", &format!("/{other}/state"), &format!("//{token}/state")]
    {
        let (head, body) = preview.ask(&format!("GET {path} HTTP/1.1\r\n{own}\r\n"));
        assert!(head.starts_with("HTTP/1.1 403"), "{path}: {head}");
        assert!(!String::from_utf8(body).unwrap().contains(token.as_str()), "{path}");
    }
    assert_ne!(Preview::new(&folder.path().join("s.toml")).token, *token, "it is another one in each run");

    // and no browser lets others embed what it shows
    let (head, _) = preview.ask(&format!("GET /{token}/ HTTP/1.1\r\n{own}\r\n"));
    for header in [
        "Cross-Origin-Resource-Policy: same-origin",
        "X-Content-Type-Options: nosniff",
        "default-src 'none'",
        "frame-ancestors 'none'",
        "Referrer-Policy: no-referrer",
        "Cache-Control: no-store",
    ] {
        assert!(head.contains(header), "{header}: {head}");
    }
    assert!(!head.contains("unsafe-inline"), "{head}");
}

#[test]
fn slow_requests_end_and_keep_nobody_out() {
    let folder = small_shot::folder();
    let preview = Preview::new(&folder.path().join("s.toml"));
    let start = Instant::now();
    let mut slow: Vec<TcpStream> = (0..100).map(|_| preview.connect()).collect();
    slow.iter_mut().for_each(|stream| stream.set_read_timeout(Some(Duration::from_millis(1))).unwrap());
    while !slow.is_empty() {
        // a byte now and then: a request that never ends
        slow.retain_mut(|stream| {
            let is_open = stream.write_all(b"G").is_ok();
            let kinds = [std::io::ErrorKind::WouldBlock, std::io::ErrorKind::TimedOut];
            is_open && stream.read(&mut [0; 1]).is_err_and(|error| kinds.contains(&error.kind()))
        });
        let asked = Instant::now();
        assert!(preview.get("state").0.ends_with("200 OK"));
        // far below the patience that each of the slow ones has
        assert!(asked.elapsed() < Duration::from_secs(3), "{:?}", asked.elapsed());
        assert!(start.elapsed() < Duration::from_secs(30), "{} are still open", slow.len());
        std::thread::sleep(Duration::from_millis(200));
    }
    assert!(start.elapsed() > Duration::from_secs(3), "they had some time");
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

//! Runs the binary, and reads what it leaves.
#![allow(dead_code, reason = "each test binary uses its share")]

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use openexr::ReadImage;
use rustix::fs::{CWD, FileType, Mode, mknodat};
use tempfile::TempDir;

/// How a run ended.
#[derive(Debug)]
pub struct Ran {
    /// 0: done, 1: failed, 2: usage.
    pub code: i32,
    /// Results.
    pub stdout: String,
    /// All else.
    pub stderr: String,
}

impl Ran {
    /// What `output` says; a run that a signal ended is not expected.
    pub fn new(output: Output) -> Self {
        Self {
            code: output.status.code().expect("it ended by itself"),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// That it did what was asked.
    #[track_caller]
    pub fn done(self) -> Self {
        assert_eq!(self.code, 0, "{}", self.stderr);
        self
    }

    /// That it failed, saying so in a line that holds all of `words`.
    #[track_caller]
    pub fn failed(self, words: &[&str]) -> Self {
        assert_eq!(self.code, 1, "{}", self.stderr);
        let line = self.stderr.lines().last().unwrap_or_default();
        assert!(line.starts_with("error: ") && !self.stderr.contains("panicked"), "{}", self.stderr);
        for word in words {
            assert!(line.contains(word), "`{word}` is not in: {line}");
        }
        self
    }
}

/// Runs `command`, which must end by itself before long.
pub fn ended(mut command: Command) -> Ran {
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > Duration::from_secs(60) {
            child.kill().unwrap();
            panic!("it does not end: {command:?}");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    Ran::new(child.wait_with_output().unwrap())
}

/// A FIFO that nobody writes into.
pub fn make_fifo(path: &Path) {
    mknodat(CWD, path, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
}

/// A folder in which the binary renders the analytic shot.
pub struct Place(pub TempDir);

impl Place {
    /// An empty one.
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// What lies, or shall lie, at `name` in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// `render` of `shot`, working in this folder.
    pub fn command(&self, shot: impl AsRef<OsStr>, options: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage"));
        command.current_dir(self.0.path()).arg("render").arg(shot).args(options.split_whitespace());
        command
    }

    /// Renders the analytic shot: 64x36, frames 1 to 8 where `options` do not say otherwise.
    pub fn render(&self, options: &str) -> Ran {
        Ran::new(self.command(analytic(), options).output().unwrap())
    }

    /// Names in `folder`, hidden ones too, in order.
    pub fn names(&self, folder: &str) -> Vec<String> {
        let entries = self.path(folder).read_dir().unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

/// The shot of most tests.
pub fn analytic() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/analytic/analytic.toml")
}

/// A frame that must be whole.
#[track_caller]
pub fn whole(path: &Path) -> ReadImage {
    openexr::read(path).unwrap_or_else(|error| panic!("{error}"))
}

/// That two frames have the same channels with the same bits.
#[track_caller]
pub fn assert_same(a: &Path, b: &Path) {
    let (left, right) = (whole(a), whole(b));
    let names = |image: &ReadImage| -> Vec<String> {
        image.channels.iter().map(|channel| channel.name.clone()).collect()
    };
    assert_eq!(names(&left), names(&right));
    for (one, other) in left.channels.iter().zip(&right.channels) {
        let pairs = one.data.iter().zip(&other.data);
        let off = pairs.filter(|(one, other)| one.to_bits() != other.to_bits()).count();
        assert_eq!(off, 0, "{} of {} and {}", one.name, a.display(), b.display());
    }
}

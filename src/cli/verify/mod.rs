//! `afterimage verify`: are all frames of a shot there, whole, and of one run?

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use rayon::prelude::*;

use crate::cli::args::on_threads;
use crate::cli::failure::Failure;
use crate::cli::frames::frame_list;
use crate::cli::frames::resume::Fingerprints;
use crate::cli::frames::target::FileState;
use crate::cli::render;
use crate::cli::say::terminal::Terminal;
use crate::output::exr::Head;
use crate::output::{Fingerprint, OutputPattern, exr};
use crate::scene::frames::Frames;
use crate::settings::Mode;

/// Arguments as typed.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  afterimage verify out/city
      are there gaps between the first frame and the last, is each frame whole, are all of one run?
  afterimage verify out/city --frames 1-240
  afterimage verify out/city --shot city.toml -- --samples 4
      are these the frames that `afterimage render city.toml --samples 4` would make now?

Exit code: 0 if all frames are there, whole, and of one run; 1 if not. Then the last line of the result is `--frames`, ready to paste.")]
pub struct VerifyArgs {
    /// Folder of the frames, or their names
    #[arg(value_name = "DIR|DIR/name.####.exr")]
    place: String,

    /// Frames that must be there [default: the shot's; without a shot, all from the first that is there to the last]
    #[arg(long, value_name = "RANGE", allow_hyphen_values = true, value_parser = Frames::parse)]
    frames: Option<Frames>,

    /// Shot from which the frames must be made, as it is now
    #[arg(long, value_name = "SHOT.toml|MODEL")]
    shot: Option<PathBuf>,

    /// Options with which `render` made them
    #[arg(last = true, requires = "shot", value_name = "RENDER OPTIONS")]
    options: Vec<String>,
}

/// State of all frames.
struct Verdict {
    pattern: String,
    frames: Vec<i32>,
    missing: Vec<i32>,
    damaged: Vec<i32>,
    /// Frames of another run, by what they differ in.
    others: BTreeMap<String, Vec<i32>>,
}

impl VerifyArgs {
    /// Prints what it finds. Fails if frames are to be made again.
    pub fn execute(&self, terminal: &mut Terminal) -> Result<(), Failure> {
        let verdict = on_threads(None, || match &self.shot {
            Some(shot) => self.by_shot(shot),
            None => self.by_frames(),
        })?;
        terminal.result(verdict.text().trim_end());
        verdict.outcome()
    }

    /// Compares with the frames that `render` would make.
    fn by_shot(&self, shot: &Path) -> Result<Verdict, Failure> {
        let mut words = self.options.clone();
        if let Some(word) = words.iter().find(|word| ["-o", "--output", "--frames"].contains(&word.as_str()))
        {
            return Err(Failure::Usage(format!("{word} stands before `--`, where `verify` has its own")));
        }
        let folder = if Path::new(&self.place).is_dir() { "/" } else { "" };
        words.extend([String::from("-o"), format!("{}{folder}", self.place)]);
        words.extend(self.frames.iter().flat_map(|frames| [String::from("--frames"), frames.to_string()]));
        let (job, target) = render::job_and_target(shot, &words)?;
        target.check()?;
        let full = job.settings.mode == Mode::Full;
        let fingerprints = Fingerprints::new(&job, &render::rule(&job, full))?;
        let states =
            target.frames().par_iter().map(|&frame| (frame, target.left(frame, &fingerprints.at(frame))));
        Ok(Verdict::new(target.text().to_owned(), states.collect()))
    }

    /// Compares the frames with one another.
    fn by_frames(&self) -> Result<Verdict, Failure> {
        let (pattern, found) = found(&self.place)?;
        let frames = match (&self.frames, found.first(), found.last()) {
            (Some(frames), ..) => frames.list(),
            (None, Some(first), Some(last)) => Frames::between(*first, *last).list(),
            _ => Vec::new(),
        };
        let files: Vec<(i32, Found)> =
            frames.par_iter().map(|&frame| (frame, Found::at(&pattern.at(frame), frame))).collect();
        let run = commonest(files.iter().filter_map(|(_, found)| found.run()));
        let states = files.into_iter().map(|(frame, found)| (frame, found.state(run)));
        Ok(Verdict::new(pattern.to_string(), states.collect()))
    }
}

/// File of a frame, as it is found.
enum Found {
    Nothing,
    Damaged,
    /// The frame of this number, which is another one.
    OtherFrame(i32),
    /// Fingerprint of its run, if it says.
    Whole(Option<Fingerprint>),
}

impl Found {
    fn at(path: &Path, frame: i32) -> Self {
        if path.symlink_metadata().is_err() {
            return Self::Nothing;
        }
        let head = Head::read(path).ok().filter(|_| exr::is_whole(path));
        match head.map(|head| (head.run, head.other_frame(frame))) {
            None => Self::Damaged,
            // other programs count as they like
            Some((Some(_), Some(other))) => Self::OtherFrame(other),
            Some((run, _)) => Self::Whole(run),
        }
    }

    fn run(&self) -> Option<Fingerprint> {
        if let Self::Whole(run) = self { *run } else { None }
    }

    /// State beside frames of `run`.
    fn state(self, run: Option<Fingerprint>) -> FileState {
        match (self, run) {
            (Self::Nothing, _) => FileState::Nothing,
            (Self::Damaged, _) => FileState::Damaged,
            (Self::OtherFrame(other), _) => FileState::OtherFrame(other),
            (Self::Whole(Some(own)), Some(run)) if own == run => FileState::Finished,
            (Self::Whole(Some(own)), Some(run)) => FileState::Other(run.changes(&own)),
            (Self::Whole(_), _) => FileState::Unknown,
        }
    }
}

/// The fingerprint that comes most often; of several the one that comes first.
fn commonest(all: impl Iterator<Item = Fingerprint>) -> Option<Fingerprint> {
    let mut counts: Vec<(Fingerprint, usize)> = Vec::new();
    for fingerprint in all {
        match counts.iter_mut().find(|(known, _)| *known == fingerprint) {
            Some((_, count)) => *count += 1,
            None => counts.push((fingerprint, 1)),
        }
    }
    counts.into_iter().rev().max_by_key(|(_, count)| *count).map(|(fingerprint, _)| fingerprint)
}

/// Names of the frames at `place`, and the numbers of those that are there, in rising order.
fn found(place: &str) -> Result<(OutputPattern, Vec<i32>), Failure> {
    let path = Path::new(place);
    if path.is_dir() {
        return sequence_in(path);
    }
    let pattern = OutputPattern::parse(place, "frame", "exr")
        .map_err(|error| Failure::Usage(format!("`{place}` cannot name frames: {error}")))?;
    let folder = if pattern.folder().as_os_str().is_empty() { Path::new(".") } else { pattern.folder() };
    let mut frames: Vec<i32> = names(folder)?.iter().filter_map(|name| pattern.frame_of(name)).collect();
    frames.sort_unstable();
    match frames.first() {
        Some(_) => Ok((pattern, frames)),
        None => Err(Failure::Failed(format!(
            "{place}: no frame is there; give the folder or the names that `render` printed"
        ))),
    }
}

/// The only sequence of EXR files in `folder`.
fn sequence_in(folder: &Path) -> Result<(OutputPattern, Vec<i32>), Failure> {
    let mut sequences: Vec<(OutputPattern, Vec<i32>)> = Vec::new();
    for name in names(folder)?.iter().filter(|name| !name.starts_with('.')) {
        let path = folder.join(name);
        if !path.extension().is_some_and(|kind| kind.eq_ignore_ascii_case("exr")) {
            continue;
        }
        let Some((pattern, frame)) = OutputPattern::of_file(&path) else { continue };
        // numbers with more digits than the names have belong to them, too
        let same = sequences.iter_mut().find(|(known, _)| {
            let fewer = known.with_digits_of(&pattern);
            fewer == pattern.with_digits_of(known) && fewer.at(frame) == path
        });
        match same {
            Some((known, frames)) => {
                *known = known.with_digits_of(&pattern);
                frames.push(frame);
            }
            None => sequences.push((pattern, vec![frame])),
        }
    }
    let place = folder.display();
    match sequences.len() {
        0 => Err(Failure::Failed(format!(
            "{place}: no frames are there; give the folder that `render` printed"
        ))),
        1 => {
            let (pattern, mut frames) = sequences.remove(0);
            frames.sort_unstable();
            Ok((pattern, frames))
        }
        _ => {
            let names: Vec<String> = sequences.iter().map(|(pattern, _)| pattern.to_string()).collect();
            Err(Failure::Usage(format!(
                "{place}: has frames of several names; give one of {}",
                names.join(", ")
            )))
        }
    }
}

/// Names of what is in `folder`, in order.
fn names(folder: &Path) -> Result<Vec<String>, Failure> {
    let refused =
        |error| Failure::Failed(format!("{}: cannot be read: {error}; check the folder", folder.display()));
    let entries = fs::read_dir(folder).map_err(refused)?;
    let mut names: Vec<String> =
        entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect();
    names.sort_unstable();
    Ok(names)
}

impl Verdict {
    fn new(pattern: String, states: Vec<(i32, FileState)>) -> Self {
        let frames = states.iter().map(|(frame, _)| *frame).collect();
        let mut verdict = Self { pattern, frames, missing: vec![], damaged: vec![], others: BTreeMap::new() };
        for (frame, state) in states {
            match state {
                FileState::Finished => {}
                FileState::Nothing => verdict.missing.push(frame),
                FileState::Damaged => verdict.damaged.push(frame),
                other => verdict.others.entry(other.to_string()).or_default().push(frame),
            }
        }
        verdict
    }

    /// Frames to make again, in rising order.
    fn again(&self) -> Vec<i32> {
        let others = self.others.values().flatten();
        let mut all: Vec<i32> = self.missing.iter().chain(&self.damaged).chain(others).copied().collect();
        all.sort_unstable();
        all
    }

    fn text(&self) -> String {
        let mut text = String::new();
        let mut line = |name: &str, value: String| text += &format!("{name:<9}{value}\n");
        line(
            "frames",
            format!("{} ({}) of {}", frame_list::runs(&self.frames), self.frames.len(), self.pattern),
        );
        if !self.missing.is_empty() {
            line("missing", frame_list::runs(&self.missing));
        }
        if !self.damaged.is_empty() {
            line("damaged", format!("{} (not whole)", frame_list::runs(&self.damaged)));
        }
        for (why, frames) in &self.others {
            line("other", format!("{} ({why})", frame_list::runs(frames)));
        }
        match self.again() {
            again if again.is_empty() => {
                line("complete", String::from("all are there, whole, and of one run"))
            }
            again => line("again", format!("--frames {}", frame_list::range(&again))),
        }
        text
    }

    fn outcome(&self) -> Result<(), Failure> {
        let again = self.again();
        if again.is_empty() {
            return Ok(());
        }
        Err(Failure::Failed(format!(
            "{} of {} frames are not there, or not whole, or not of the run: render them with --frames {}",
            again.len(),
            self.frames.len(),
            frame_list::range(&again)
        )))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

    use super::*;

    #[test]
    fn sequences_are_found_by_their_names() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str| fs::write(folder.path().join(name), "").unwrap();
        ["a.0009.exr", "a.0010.exr", "a.10000.exr", ".a.0011.exr.XXXXXXXXXXXX.part", "a.0012.png", "b.exr"]
            .into_iter()
            .for_each(write);
        let (pattern, frames) = sequence_in(folder.path()).unwrap();
        assert!(pattern.to_string().ends_with("/a.####.exr"), "{pattern}");
        assert_eq!(frames, [9, 10, 10000]);
        write("c.7.exr");
        let told = sequence_in(folder.path()).unwrap_err().to_string();
        assert!(told.contains("a.####.exr") && told.contains("c.#.exr"), "{told}");
    }

    #[test]
    fn the_run_of_most_frames_counts() {
        let of = |bytes: &[u8]| {
            let digest = crate::digest::Digest::new(bytes);
            Fingerprint { version: digest, shot: digest, inputs: digest, settings: digest }
        };
        let [a, b] = [of(b"a"), of(b"b")];
        assert_eq!(commonest([b, a, a].into_iter()), Some(a));
        assert_eq!(commonest([b, a].into_iter()), Some(b), "the first of as many");
        assert_eq!(commonest([].into_iter()), None);
    }
}

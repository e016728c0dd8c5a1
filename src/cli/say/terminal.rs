//! Output streams of a run: the table on stdout; progress and warnings on stderr. Names come from files of
//! other authors: no control sequence in them reaches the terminal (see [`visible`]).

use std::fmt;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use serde_json::{Value, json};

use crate::cli::failure::{Failure, one_line};
use crate::frame::Watcher;
use crate::stats::FrameStats;
use crate::visible::visible;

/// Kind of the progress on stderr while frames are rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum ProgressKind {
    /// A bar when stderr is a terminal, otherwise nothing
    #[default]
    Auto,
    /// One line a frame
    Plain,
    /// One JSON object a line: events start, frame, warning, note, error, end
    Json,
    /// Lines for engines of Open Job Description, on stdout: `openjd_progress`, `openjd_status`, `openjd_fail`
    Openjd,
    /// Nothing
    None,
}

enum Progress {
    Silent,
    Plain,
    Json,
    Openjd,
    Bar(ProgressBar),
}

/// The two streams. Results are silently dropped once nobody reads them any more: a closed pipe is no error,
/// because the frames are the real result. Whatever else keeps them from being printed fails the run at its end.
pub struct Terminal {
    progress: Progress,
    quiet: bool,
    stdout: Stdout,
    started: Instant,
    done: usize,
    of: usize,
}

/// State of stdout.
enum Stdout {
    Open,
    /// Nobody reads it any more.
    Closed,
    /// Something could not be printed, for this reason.
    Failed(io::Error),
}

impl Terminal {
    /// Creates the streams. `quiet` leaves errors and warnings.
    pub fn new(kind: ProgressKind, quiet: bool) -> Self {
        let progress = match kind {
            ProgressKind::Json => Progress::Json, // warnings and errors are events, even when quiet
            ProgressKind::Openjd => Progress::Openjd,
            _ if quiet => Progress::Silent,
            ProgressKind::Auto if io::stderr().is_terminal() => Progress::Bar(ProgressBar::hidden()),
            ProgressKind::Plain => Progress::Plain,
            ProgressKind::Auto | ProgressKind::None => Progress::Silent,
        };
        Self { progress, quiet, stdout: Stdout::Open, started: Instant::now(), done: 0, of: 0 }
    }

    /// Prints lines of the result.
    pub fn result(&mut self, text: &str) {
        if !self.quiet {
            self.print(format!("{}\n", visible(text)).as_bytes());
        }
    }

    /// Prints our own text unchanged, to be redirected into files.
    pub fn raw(&mut self, text: &[u8]) {
        self.print(text);
    }

    fn print(&mut self, text: &[u8]) {
        if !matches!(self.stdout, Stdout::Open) {
            return;
        }
        let write = || {
            let mut stdout = io::stdout().lock();
            stdout.write_all(text).and_then(|()| stdout.flush())
        };
        let outcome = match &self.progress {
            Progress::Bar(bar) => bar.suspend(write),
            _ => write(),
        };
        self.stdout = match outcome {
            Ok(()) => Stdout::Open,
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Stdout::Closed,
            Err(error) => Stdout::Failed(error),
        };
    }

    /// Fails if a part of the result could not be printed.
    pub fn printed(&self) -> Result<(), Failure> {
        match &self.stdout {
            Stdout::Open | Stdout::Closed => Ok(()),
            Stdout::Failed(error) => Err(unprinted(error)),
        }
    }

    /// Warns of a defect for which the picture shows a stand-in, or that the user may not expect.
    pub fn warn(&self, message: &str) {
        self.say("warning", message);
    }

    /// Prints useful information.
    pub fn note(&self, message: &str) {
        if !self.quiet {
            self.say("note", message);
        }
    }

    /// Prints the error that ended the run.
    pub fn error(&self, message: &str) {
        self.say("error", message);
    }

    fn say(&self, event: &str, message: &str) {
        let message = one_line(message);
        match &self.progress {
            Progress::Json => json_line(&json!({"event": event, "message": message})),
            Progress::Openjd if event == "error" => openjd_line("fail", &message),
            Progress::Bar(bar) => bar.suspend(|| err_line(&format!("{event}: {message}"))),
            _ => err_line(&format!("{event}: {message}")),
        }
    }

    /// Watcher of finished tiles for the progress display, if there is one.
    pub fn watcher(&self) -> Option<Watcher> {
        let Progress::Bar(bar) = &self.progress else { return None };
        let bar = bar.clone();
        // what it shows is drawn by a thread of its own, four times a second
        Some(Arc::new(move |tiles| bar.inc(tiles as u64)))
    }

    /// Returns true if a progress bar is shown while frames are rendered.
    pub fn has_bar(&self) -> bool {
        matches!(self.progress, Progress::Bar(_))
    }

    /// Begins the progress of so many renderings, each of so many tiles.
    pub fn begin(&mut self, renderings: usize, tiles: usize) {
        (self.started, self.done, self.of) = (Instant::now(), 0, renderings);
        match &self.progress {
            Progress::Bar(bar) => {
                bar.set_style(style(tiles as u64));
                bar.set_length((renderings * tiles) as u64);
                bar.set_prefix(format!("0/{renderings}"));
                bar.reset_eta();
                // not before there is something to show
                bar.set_draw_target(ProgressDrawTarget::stderr());
                bar.enable_steady_tick(Duration::from_millis(250));
            }
            Progress::Json if !self.quiet => {
                json_line(&json!({"event": "start", "renderings": renderings}));
            }
            _ => {}
        }
    }

    /// Reports a finished rendering, and its `file` if it was written.
    pub fn frame_done(&mut self, stats: &FrameStats, file: Option<&Path>) {
        self.done += 1;
        let left = self.seconds_left();
        match &self.progress {
            Progress::Bar(bar) => {
                bar.set_prefix(format!("{}/{}", self.done, self.of));
            }
            Progress::Plain => err_line(&format!(
                "[{}/{}] frame {}: {}, {:.3} s, about {} left",
                self.done,
                self.of,
                stats.frame,
                stats.kind(),
                stats.seconds.total,
                duration(left)
            )),
            Progress::Json if !self.quiet => json_line(&json!({
                "event": "frame", "frame": stats.frame, "mode": stats.mode,
                "done": self.done, "of": self.of,
                "seconds": stats.seconds.total, "seconds_left": left,
                "file": file.map(|path| path.display().to_string()),
            })),
            Progress::Openjd => {
                // of a part of a shared run there may be more than was foreseen
                let percent = 100.0 * self.done as f64 / self.of.max(self.done).max(1) as f64;
                openjd_line("progress", &format!("{percent:.1}"));
                openjd_line("status", &format!("frame {}, about {} left", stats.frame, duration(left)));
            }
            _ => {}
        }
    }

    /// Ends the progress.
    pub fn end(&mut self) {
        match &self.progress {
            Progress::Bar(bar) => bar.finish_and_clear(),
            Progress::Json if !self.quiet => json_line(&json!({
                "event": "end", "done": self.done, "of": self.of,
                "seconds": self.started.elapsed().as_secs_f64(),
            })),
            _ => {}
        }
    }

    /// Wall-clock seconds since the first frame began.
    pub fn elapsed(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Estimated remaining seconds, by the mean of the finished renderings.
    fn seconds_left(&self) -> f64 {
        let mean = self.elapsed() / self.done.max(1) as f64;
        mean * self.of.saturating_sub(self.done) as f64
    }
}

/// The failure of a result that is not on stdout, though somebody may read it.
pub fn unprinted(error: &io::Error) -> Failure {
    Failure::Failed(format!(
        "cannot print the result: {error}; see what stdout is redirected to, and whether there is room"
    ))
}

/// Formats a duration: `0.42 s`, `12 s`, `3 min 05 s`, `2 h 07 min`.
pub fn duration(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole {
        0..=8 => format!("{seconds:.2} s"),
        9..=119 => format!("{seconds:.1} s"),
        120..=7199 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole % 3600 / 60),
    }
}

/// Style of a bar over the tiles of all frames, so many in each: finished frames, and tiles of the one at
/// work.
fn style(tiles: u64) -> ProgressStyle {
    let template =
        "{bar:32.green/dim} {prefix} frames, {tiles} tiles  {elapsed_precise} gone, {eta_precise} to go";
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    let at_work = move |state: &ProgressState, text: &mut dyn fmt::Write| {
        // nobody may be there to read it
        let _ = write!(text, "{}/{tiles}", state.pos() % tiles.max(1));
    };
    style.with_key("tiles", at_work).progress_chars("━╸─")
}

/// Prints a line to stderr. Nobody may be there to read it.
fn err_line(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", visible(text));
}

/// Prints a JSON value to stderr. JSON has escapes of its own.
fn json_line(value: &Value) {
    let _ = writeln!(io::stderr().lock(), "{value}");
}

/// Prints a line for an engine of Open Job Description, which reads stdout.
fn openjd_line(key: &str, text: &str) {
    let mut stdout = io::stdout().lock();
    let _ = writeln!(stdout, "openjd_{key}: {}", visible(text)).and_then(|()| stdout.flush());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_have_the_unit_that_is_read_best() {
        let texts: Vec<_> = [0.4211, 9.7, 61.04, 185.0, 7620.0].map(duration).into();
        assert_eq!(texts, ["0.42 s", "9.7 s", "61.0 s", "3 min 05 s", "2 h 07 min"]);
    }

    #[test]
    fn a_bar_moves_within_a_frame() {
        let mut terminal = Terminal::new(ProgressKind::None, false);
        assert!(terminal.watcher().is_none(), "nobody looks");
        let bar = ProgressBar::hidden();
        terminal.progress = Progress::Bar(bar.clone());
        terminal.begin(3, 100);
        let watch = terminal.watcher().expect("there is a bar");
        watch(40);
        watch(50);
        assert_eq!((bar.position(), bar.length(), bar.prefix()), (90, Some(300), String::from("0/3")));
        watch(10);
        terminal.frame_done(&FrameStats::default(), None);
        assert_eq!((bar.position(), bar.prefix()), (100, String::from("1/3")));
        terminal.end();
    }
}

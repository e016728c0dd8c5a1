//! Frames as a movie, packed by FFmpeg, which is another program.

use std::fmt;
use std::fs::File;
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use super::picture::Picture;
use super::staged::{WriteError, write_whole};

/// Name of the program.
const FFMPEG: &str = "ffmpeg";

/// Format of a movie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Container {
    /// H.264, which plays everywhere.
    Mp4,
    /// GIF, which plays in web pages; 256 colours.
    Gif,
}

/// Reason why there is no movie.
#[derive(Debug)]
pub enum MovieError {
    /// FFmpeg cannot be started.
    NoFfmpeg(io::Error),
    /// FFmpeg cannot be told which file to write.
    NoProc,
    /// FFmpeg has failed; the last lines that it wrote.
    Ffmpeg(PathBuf, String),
    /// A frame has another size than the first one.
    Size,
    /// The file could not be written.
    Write(WriteError),
}

impl From<WriteError> for MovieError {
    fn from(error: WriteError) -> Self {
        Self::Write(error)
    }
}

impl fmt::Display for MovieError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoFfmpeg(error) => write!(
                f,
                "movies are packed by FFmpeg, and `{FFMPEG}` cannot be started ({error}): install it (apt-get install \
                 ffmpeg), or leave out --movie"
            ),
            Self::NoProc => write!(
                f,
                "movies need /proc, through which FFmpeg gets its file, and it is not mounted here: mount it (mount -t proc \
                 proc /proc), or leave out --movie"
            ),
            Self::Ffmpeg(path, why) => {
                write!(f, "{}: {FFMPEG} could not pack the movie: {why}", path.display())
            }
            Self::Size => f.write_str("a movie needs frames of one size"),
            Self::Write(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for MovieError {}

/// Folder in which a process finds the files that it has open.
const OPEN_FILES: &str = "/proc/self/fd";

/// Finds out whether FFmpeg is there, and what it needs.
///
/// # Errors
/// It is not, or does not work.
pub fn ensure_ffmpeg() -> Result<(), MovieError> {
    if !Path::new(OPEN_FILES).is_dir() {
        return Err(MovieError::NoProc);
    }
    let quiet = || Stdio::null();
    let ran = Command::new(FFMPEG).arg("-version").stdin(quiet()).stdout(quiet()).stderr(quiet()).status();
    match ran.map_err(MovieError::NoFfmpeg)? {
        status if status.success() => Ok(()),
        status => Err(MovieError::NoFfmpeg(io::Error::other(status.to_string()))),
    }
}

/// Writes `frames`, of which there is at least one, to `path`, whole or not at all; `rate`: frames a second, as a fraction.
///
/// # Errors
/// FFmpeg is not there, or fails; a frame cannot be had; the file cannot be written.
pub fn write_movie<E: From<MovieError> + From<WriteError>>(
    path: &Path,
    container: Container,
    rate: (i32, u32),
    frames: impl Fn() -> Box<dyn Iterator<Item = Result<Picture, E>>>,
) -> Result<(), E> {
    write_whole(path, |file| {
        let mut frames = frames();
        let Some(first) = frames.next().transpose()? else { return Ok(()) };
        let size = [first.width, first.height];
        let into = file.try_clone().map_err(|error| WriteError::new(path, error))?;
        // a file, and no pipe, which would have to be emptied meanwhile
        let log = tempfile::tempfile().and_then(|log| Ok((log.try_clone()?, log)));
        let (log, told) = log.map_err(|error| WriteError::new(&std::env::temp_dir(), error))?;
        let mut child = command(container, rate, size)
            .stdin(Stdio::piped())
            .stdout(into)
            .stderr(log)
            .spawn()
            .map_err(MovieError::NoFfmpeg)?;
        let fed = feed(&mut child, size, std::iter::once(Ok(first)).chain(frames));
        let told = conclude(child, told);
        // what the program says is why it no longer reads
        let fed = fed?;
        let told = told.map_err(|why| MovieError::Ffmpeg(path.to_owned(), why))?;
        fed.map_err(|error| MovieError::Ffmpeg(path.to_owned(), format!("{error}; {told}")))?;
        Ok(())
    })
}

/// Writes all frames to `child`. The inner result is that of its pipe.
fn feed<E: From<MovieError>>(
    child: &mut Child,
    size: [u32; 2],
    frames: impl Iterator<Item = Result<Picture, E>>,
) -> Result<io::Result<()>, E> {
    let mut pipe = child.stdin.take().expect("it was asked for");
    for frame in frames {
        let frame = frame?;
        if [frame.width, frame.height] != size {
            return Err(MovieError::Size.into());
        }
        if let Err(error) = pipe.write_all(&frame.rgb) {
            return Ok(Err(error));
        }
    }
    Ok(Ok(()))
}

/// Waits for the end of `child`, and returns the last lines that it has written to `log`.
fn conclude(mut child: Child, mut log: File) -> Result<String, String> {
    drop(child.stdin.take());
    let ended = child.wait();
    let mut text = Vec::new();
    // without the log only the exit status is reported
    let _ = log.rewind().and_then(|()| log.read_to_end(&mut text));
    let text = String::from_utf8_lossy(&text);
    let lines: Vec<&str> = text.lines().filter(|line| !line.trim().is_empty()).collect();
    let told = lines[lines.len().saturating_sub(3)..].join("; ");
    match ended {
        Ok(status) if status.success() => Ok(told),
        Ok(status) => Err(if told.is_empty() { status.to_string() } else { told }),
        Err(error) => Err(error.to_string()),
    }
}

/// Command that reads raw frames from its input, and writes to the file that is its output and allows
/// seeking.
fn command(container: Container, (above, below): (i32, u32), [width, height]: [u32; 2]) -> Command {
    let mut command = Command::new(FFMPEG);
    command.args(["-hide_banner", "-loglevel", "error", "-nostdin", "-y"]);
    command.args(["-f", "rawvideo", "-pixel_format", "rgb24", "-video_size", &format!("{width}x{height}")]);
    command.args(["-framerate", &format!("{above}/{below}"), "-i", "pipe:0"]);
    match container {
        // players want even sides, one brightness and two colours for four pixels, and to know which matrix made them
        Container::Mp4 => command.args([
            "-vf",
            "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p",
            "-c:v",
            "libx264",
            "-crf",
            "16",
            "-colorspace",
            "bt709",
            "-color_primaries",
            "bt709",
            "-color_trc",
            "iec61966-2-1",
            "-movflags",
            "+faststart",
            "-f",
            "mp4",
        ]),
        Container::Gif => command.args([
            "-vf",
            "split[a][b];[a]palettegen=stats_mode=full[p];[b][p]paletteuse=dither=sierra2_4a",
            "-f",
            "gif",
        ]),
    };
    command.arg(format!("{OPEN_FILES}/1"));
    command
}

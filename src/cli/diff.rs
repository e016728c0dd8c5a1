//! `afterimage diff`: measures the difference between the frames in two EXR files, or in two sequences of
//! them.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use super::args::on_threads;
use super::failure::Failure;
use super::frames::frame_list;
use super::say::terminal::{ProgressKind, Terminal};
use crate::memory::{self, Need, Part};
use crate::output::{self, OutputPattern, exr, false_color, png};
use crate::report::file_difference::{self, FileDifference, LayerDifference, Picture};
use crate::report::values::name_in_layer;
use crate::report::whole_file;

/// Examples, printed below the options in `--help`.
const EXAMPLES: &str = "\
Examples:
  afterimage diff old.exr new.exr                         each layer: largest difference, RMSE, pixels
  afterimage diff old.exr new.exr --tolerance 0.001 -q    the exit code alone
  afterimage diff old.exr new.exr -o difference.png       where the picture differs, in false colours
  afterimage diff 'old/walk.####.exr' 'new/walk.####.exr'

Exit code: 0 if the files are the same within the tolerance, 1 if they differ, 2 if something failed.";

/// Arguments as typed.
#[derive(Debug, Clone, Args)]
#[command(after_help = EXAMPLES)]
pub struct DiffArgs {
    /// A frame, or a sequence with #### or %04d for the frame number
    #[arg(value_name = "A.exr")]
    first: String,

    /// Frame, or sequence, to compare it with
    #[arg(value_name = "B.exr")]
    second: String,

    /// Write a picture of the absolute difference: EXR with all channels, or PNG with the largest difference of R, G and B
    /// in false colours
    #[arg(short, long, value_name = "FILE.exr|FILE.png")]
    output: Option<String>,

    /// Values that differ by this much or less count as the same
    #[arg(long, value_name = "X", default_value_t = 0.0, value_parser = tolerance)]
    tolerance: f64,

    /// Print only errors
    #[arg(short, long)]
    quiet: bool,
}

fn tolerance(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number >= 0.0);
    number.ok_or_else(|| String::from("a number from 0 on is wanted"))
}

/// Pairs of files to compare.
#[derive(Debug)]
struct Pairs {
    /// Number of the frame, if there are several, and the two files.
    files: Vec<(Option<i32>, [PathBuf; 2])>,
    /// Frames that only the first, or only the second, sequence has.
    alone: [Vec<i32>; 2],
}

impl DiffArgs {
    /// Output streams for these arguments.
    pub fn terminal(&self) -> Terminal {
        Terminal::new(ProgressKind::None, self.quiet)
    }

    /// Compares. Returns true if anything differs.
    pub fn execute(&self, terminal: &mut Terminal) -> Result<bool, Failure> {
        on_threads(None, || self.compare(terminal))
    }

    fn compare(&self, terminal: &mut Terminal) -> Result<bool, Failure> {
        let pairs = pairs([&self.first, &self.second])?;
        let output = self.output.as_deref().map(|text| Output::new(text, &pairs)).transpose()?;
        let mut report = Report::new([&self.first, &self.second], self.tolerance, pairs.alone);
        for (frame, files) in &pairs.files {
            let paths = files.each_ref().map(PathBuf::as_path);
            check_memory(paths[0])?;
            let (difference, picture) =
                file_difference::between(paths, self.tolerance, *frame).map_err(Failure::of)?;
            if let Some(output) = &output {
                output.write(*frame, &difference, picture, self.tolerance)?;
            }
            if let Some(line) = report.add(*frame, difference) {
                terminal.result(&line);
            }
        }
        terminal.result(report.text().trim_end());
        Ok(report.differs())
    }
}

/// Checks that memory suffices for the file at `path`.
fn check_memory(path: &Path) -> Result<(), Failure> {
    let head = whole_file::header(path).map_err(Failure::of)?;
    let part = Part::new("the channels of the first file", file_difference::bytes(&head), "smaller pictures");
    let error = |error| Failure::Failed(format!("{}: {error}", path.display()));
    Need::new(part).check(&memory::left()).map_err(error)
}

/// Finds the files that two names mean.
fn pairs(names: [&String; 2]) -> Result<Pairs, Failure> {
    let sequences = names.map(|name| sequence(name));
    match sequences {
        [None, None] => {
            let files = vec![(None, names.map(PathBuf::from))];
            files[0].1.iter().try_for_each(|file| check_file(file))?;
            Ok(Pairs { files, alone: Default::default() })
        }
        [Some(first), Some(second)] => {
            let patterns = [first?, second?];
            let [first, second] = [0, 1].map(|i| frames(&patterns[i], names[i]));
            let (first, second) = (first?, second?);
            let both = |frame: i32| (Some(frame), patterns.each_ref().map(|pattern| pattern.at(frame)));
            let alone = [&first - &second, &second - &first].map(|frames| frames.into_iter().collect());
            let files: Vec<_> = first.intersection(&second).map(|&frame| both(frame)).collect();
            files.iter().flat_map(|(_, files)| files).try_for_each(|file| check_file(file))?;
            Ok(Pairs { files, alone })
        }
        _ => Err(Failure::Usage(String::from(
            "one name has a place for the frame's number and the other one has none: give two files, or two sequences",
        ))),
    }
}

/// Reads `name` as the names of a sequence: it has a place for the number, and there is no such file. None
/// otherwise.
fn sequence(name: &str) -> Option<Result<OutputPattern, Failure>> {
    let path = Path::new(name);
    let has_place = path.file_name().is_some_and(|file| file.to_string_lossy().contains(['#', '%']));
    if !has_place || path.exists() {
        return None;
    }
    let pattern = OutputPattern::parse(name, "", "exr");
    Some(pattern.map_err(|error| Failure::Usage(format!("`{name}` cannot name frames: {error}"))))
}

fn frames(pattern: &OutputPattern, name: &str) -> Result<BTreeSet<i32>, Failure> {
    let folder = match pattern.folder() {
        folder if folder.as_os_str().is_empty() => Path::new("."),
        folder => folder,
    };
    let refuse = |why: &str| Failure::Failed(format!("{name}: {why}"));
    let entries =
        folder.read_dir().map_err(|error| refuse(&format!("its folder cannot be read: {error}")))?;
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let frames: BTreeSet<i32> = names.filter_map(|name| pattern.frame_of(&name)).collect();
    if frames.is_empty() { Err(refuse("there is no such frame")) } else { Ok(frames) }
}

/// Checks that a file has layers, with a better message for folders than the library's.
fn check_file(path: &Path) -> Result<(), Failure> {
    if path.is_dir() {
        let message = "is a folder: name the frames in it, such as FOLDER/name.####.exr";
        return Err(Failure::Failed(format!("{}: {message}", path.display())));
    }
    openexr::part_count(path).map(drop).map_err(Failure::of)
}

/// Destination of the pictures of differences.
struct Output {
    place: Place,
    is_png: bool,
}

enum Place {
    One(PathBuf),
    Many(OutputPattern),
}

impl Output {
    fn new(text: &str, pairs: &Pairs) -> Result<Self, Failure> {
        let is_many = pairs.files.iter().any(|(frame, _)| frame.is_some());
        let place = if is_many {
            let pattern = OutputPattern::parse(text, "difference", "exr");
            Place::Many(
                pattern
                    .map_err(|error| Failure::Usage(format!("`{text}` cannot name the pictures: {error}")))?,
            )
        } else {
            Place::One(PathBuf::from(text))
        };
        let any = match &place {
            Place::One(path) => path.clone(),
            Place::Many(pattern) => pattern.at(0),
        };
        let kind = any.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let is_png = match kind.as_str() {
            "exr" => false,
            "png" => true,
            _ => return Err(Failure::Usage(format!("`{text}` does not end in .exr or .png"))),
        };
        let output = Self { place, is_png };
        let inputs: Vec<PathBuf> = pairs
            .files
            .iter()
            .flat_map(|(_, files)| files)
            .filter_map(|file| file.canonicalize().ok())
            .collect();
        for (frame, _) in &pairs.files {
            let path = output.path(*frame);
            if path.canonicalize().is_ok_and(|path| inputs.contains(&path)) {
                let message = "is one of the files that are compared; choose another name with -o";
                return Err(Failure::Usage(format!("{} {message}", path.display())));
            }
        }
        output::ensure_writable(&any).map_err(Failure::of)?;
        Ok(output)
    }

    fn path(&self, frame: Option<i32>) -> PathBuf {
        match &self.place {
            Place::One(path) => path.clone(),
            Place::Many(pattern) => pattern.at(frame.unwrap_or(0)),
        }
    }

    fn write(
        &self,
        frame: Option<i32>,
        difference: &FileDifference,
        mut picture: Picture,
        tolerance: f64,
    ) -> Result<(), Failure> {
        let path = self.path(frame);
        let refuse = |why: &str| Failure::Failed(format!("{}: there is no picture: {why}", path.display()));
        if difference.windows.is_some() {
            return Err(refuse("the files have different sizes"));
        }
        if self.is_png {
            let colors = picture.colors().ok_or_else(|| {
                refuse("a PNG shows R, G and B, and not both files have them; write an EXR (-o FILE.exr)")
            })?;
            return png::write_rgb(&path, picture.size, &false_colors(colors, tolerance))
                .map_err(Failure::of);
        }
        if picture.planes.is_empty() {
            return Err(refuse("the files have no channel in common"));
        }
        for (_, values) in &mut picture.planes {
            values.iter_mut().for_each(|value| *value = value.min(f32::MAX));
        }
        let comments = "absolute difference of two files, written by afterimage diff";
        exr::write_floats(&path, picture.size, &picture.planes, comments).map_err(Failure::of)
    }
}

/// Draws the largest of three differences in false colours. Differences within the tolerance are black.
fn false_colors(planes: [&[f32]; 3], tolerance: f64) -> Vec<u8> {
    let [red, green, blue] = planes;
    let largest = red.iter().zip(green).zip(blue).map(|((r, g), b)| r.max(*g).max(*b));
    let shown = largest.map(|value| if f64::from(value) > tolerance { value } else { 0.0 });
    shown.flat_map(false_color::of_difference).collect()
}

/// Results of all comparisons, told at the end.
struct Report<'a> {
    names: [&'a str; 2],
    tolerance: f64,
    layers: Vec<LayerDifference>,
    alone: [BTreeSet<String>; 2],
    frames_alone: [Vec<i32>; 2],
    windows: Option<[[i64; 4]; 2]>,
    size: [u32; 2],
    compared: usize,
    off: Vec<i32>,
    pixels_off: u64,
    differs: bool,
    is_sequence: bool,
}

impl<'a> Report<'a> {
    fn new(names: [&'a String; 2], tolerance: f64, frames_alone: [Vec<i32>; 2]) -> Self {
        let differs = frames_alone.iter().any(|frames| !frames.is_empty());
        Self {
            names: names.map(String::as_str),
            tolerance,
            layers: Vec::new(),
            alone: Default::default(),
            frames_alone,
            windows: None,
            size: [0; 2],
            compared: 0,
            off: Vec::new(),
            pixels_off: 0,
            differs,
            is_sequence: differs,
        }
    }

    fn differs(&self) -> bool {
        self.differs
    }

    /// Adds a pair. Returns a line for frames of a sequence that differ.
    fn add(&mut self, frame: Option<i32>, difference: FileDifference) -> Option<String> {
        let line = frame.filter(|_| difference.differs()).map(|frame| frame_line(frame, &difference));
        self.compared += 1;
        self.is_sequence |= frame.is_some();
        self.size = difference.size;
        self.differs |= difference.differs();
        self.off.extend(frame.filter(|_| difference.differs()));
        self.pixels_off += difference.pixels_off;
        self.windows = self.windows.or(difference.windows);
        for (all, alone) in self.alone.iter_mut().zip(difference.alone) {
            all.extend(alone);
        }
        for layer in difference.layers {
            match self.layers.iter_mut().find(|known| known.layer == layer.layer) {
                Some(known) => known.merge(layer),
                None => self.layers.push(layer),
            }
        }
        line
    }

    fn text(&self) -> String {
        let mut text = String::new();
        if !self.layers.is_empty() {
            let _ = writeln!(text, "{}", row(["layer", "largest", "in", "pixel", "RMSE", "pixels", "%"]));
        }
        for layer in &self.layers {
            let _ = writeln!(text, "{}", layer_row(layer));
        }
        for (name, alone) in self.names.iter().zip(&self.alone).filter(|(_, alone)| !alone.is_empty()) {
            let channels: Vec<&str> = alone.iter().map(String::as_str).collect();
            let _ = writeln!(text, "only in {name}: {}", channels.join(" "));
        }
        for (name, frames) in self.names.iter().zip(&self.frames_alone).filter(|(_, f)| !f.is_empty()) {
            let _ = writeln!(text, "only in {name}: {}", frame_list::frames(frames));
        }
        if let Some([first, second]) = self.windows.filter(|_| !self.is_sequence) {
            let _ = writeln!(text, "sizes differ: {} and {}", window(first), window(second));
        }
        text + &self.verdict()
    }

    fn verdict(&self) -> String {
        let within = match self.tolerance {
            0.0 => String::new(),
            tolerance => format!(" within {tolerance}"),
        };
        let unlike: u64 = self.layers.iter().map(|layer| layer.unlike).sum();
        let unlike = match unlike {
            0 => String::new(),
            values => {
                format!("; {values} values are NaN or infinite in one of the files alone, and in no RMSE")
            }
        };
        match (self.is_sequence, self.differs) {
            (false, false) => format!("same{within}"),
            (true, false) => format!("same{within}: {} frames", self.compared),
            (false, true) if self.windows.is_some() => String::from("differ"),
            (false, true) => format!("differ: {} of {} pixels{unlike}", self.pixels_off, self.pixels()),
            (true, true) => format!("differ: {} of {} frames{unlike}", self.off.len(), self.compared),
        }
    }

    fn pixels(&self) -> u64 {
        self.size.map(u64::from).iter().product()
    }
}

fn frame_line(frame: i32, difference: &FileDifference) -> String {
    if let Some([first, second]) = difference.windows {
        return format!("frame {frame}: sizes differ: {} and {}", window(first), window(second));
    }
    let largest = difference.layers.iter().filter_map(|layer| layer.largest.as_ref());
    match largest.max_by(|a, b| a.value.total_cmp(&b.value)) {
        Some(largest) => {
            let [x, y] = largest.pixel;
            let (value, channel, off) =
                (number(largest.value.into()), &largest.channel, difference.pixels_off);
            format!(
                "frame {frame}: {off} pixels differ; the largest difference is {value} in {channel} at ({x}, {y})"
            )
        }
        None => format!("frame {frame}: the files have different channels"),
    }
}

/// Formats `[left, top, width, height]`.
fn window([left, top, width, height]: [i64; 4]) -> String {
    match [left, top] {
        [0, 0] => format!("{width}x{height}"),
        _ => format!("{width}x{height} at ({left}, {top})"),
    }
}

fn row([layer, largest, channel, pixel, rmse, pixels, percent]: [&str; 7]) -> String {
    let row =
        format!("  {layer:<16}{largest:>12} {channel:<13}{pixel:<20}{rmse:>12}{pixels:>12}{percent:>9}");
    row.trim_end().to_owned()
}

fn layer_row(layer: &LayerDifference) -> String {
    let names: Vec<&str> = layer.channels.iter().map(|channel| name_in_layer(channel)).collect();
    let title = if layer.layer.is_empty() { names.join(" ") } else { layer.layer.clone() };
    let percent = 100.0 * layer.pixels_off as f64 / layer.pixels.max(1) as f64;
    let (largest, channel, pixel) = match &layer.largest {
        None => (String::from("0"), String::from("-"), String::from("-")),
        Some(largest) => {
            let [x, y] = largest.pixel;
            let frame = largest.frame.map_or_else(String::new, |frame| format!(" of {frame}"));
            let channel = name_in_layer(&largest.channel).to_owned();
            (number(largest.value.into()), channel, format!("({x}, {y}){frame}"))
        }
    };
    let (rmse, pixels, percent) =
        (number(layer.rmse()), layer.pixels_off.to_string(), format!("{percent:.3}"));
    row([&title, &largest, &channel, &pixel, &rmse, &pixels, &percent])
}

/// Formats a number with four significant digits.
fn number(value: f64) -> String {
    match value.abs() {
        0.0 => String::from("0"),
        size if !(1e-4..1e6).contains(&size) => format!("{value:.3e}"),
        size => format!("{value:.*}", (3 - size.log10().floor() as i32).max(0) as usize),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        let texts = [0.0, 0.25, 1.0, 123.456, 65504.0, 1e-7, f64::INFINITY, 0.00123456].map(number);
        assert_eq!(texts, ["0", "0.2500", "1.000", "123.5", "65504", "1.000e-7", "inf", "0.001235"]);
    }

    #[test]
    fn what_is_within_the_tolerance_is_black() {
        let bytes = false_colors([&[0.0, 0.5], &[0.1, 0.0], &[0.0, 0.0]], 0.2);
        assert_eq!(bytes[..3], [0; 3]);
        assert_eq!(bytes[3..], false_color::of_difference(0.5));
    }
}

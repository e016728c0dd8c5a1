//! Differences of two pictures in EXR files, channel by channel, and their places.
//!
//! One file is held as a whole, the other one is read line by line. The values of the first one are then
//! replaced by the differences.

use std::path::Path;

use openexr::ReadImage;
use rayon::prelude::*;

use super::values::{layer_of, reading_order};
use super::whole_file;

/// Result of comparing two files.
#[derive(Debug, Clone, PartialEq)]
pub struct FileDifference {
    /// Size of the first one, pixels: columns and rows.
    pub size: [u32; 2],
    /// Windows of both, as first column and row, columns and rows, if they are not the same: no value was
    /// compared then.
    pub windows: Option<[[i64; 4]; 2]>,
    /// Layers of which both have channels.
    pub layers: Vec<LayerDifference>,
    /// Channels that only the first, and only the second, file has.
    pub alone: [Vec<String>; 2],
    /// Number of pixels in which some channel differs by more than the tolerance.
    pub pixels_off: u64,
}

/// Difference of a layer over all pixels of one pair of files, or of several.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerDifference {
    /// Name of the layer. That of the channel if the channel has no layer, and empty for `R G B A`.
    pub layer: String,
    /// Full names of the channels that both files have.
    pub channels: Vec<String>,
    /// Largest difference; `None` if all values are the same.
    pub largest: Option<Largest>,
    squares: f64,
    finite: u64,
    /// Number of values of which one is a NaN or infinite and the other one is not the same.
    pub unlike: u64,
    /// Number of pixels in which a channel differs by more than the tolerance.
    pub pixels_off: u64,
    /// Number of all pixels.
    pub pixels: u64,
}

/// The largest difference.
#[derive(Debug, Clone, PartialEq)]
pub struct Largest {
    /// Absolute difference; infinite if one of the values is a NaN or infinite.
    pub value: f32,
    /// Full name of the channel.
    pub channel: String,
    /// Column and row, counted from 0 at the upper left.
    pub pixel: [u32; 2],
    /// Number of the frame, if there are several.
    pub frame: Option<i32>,
}

/// Full name and values of a channel.
pub type NamedPlane = (String, Vec<f32>);

/// Absolute differences, pixel by pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Size: columns and rows.
    pub size: [u32; 2],
    /// Full names, and differences of all pixels; infinite if one of two values is a NaN or infinite.
    pub planes: Vec<NamedPlane>,
}

impl FileDifference {
    /// Returns true if anything differs.
    pub fn differs(&self) -> bool {
        self.windows.is_some() || self.pixels_off > 0 || self.alone.iter().any(|alone| !alone.is_empty())
    }
}

impl LayerDifference {
    /// Root mean square of the differences that are finite.
    pub fn rmse(&self) -> f64 {
        (self.squares / self.finite.max(1) as f64).sqrt()
    }

    /// Adds the same layer of other frames.
    pub fn merge(&mut self, other: Self) {
        let value = |largest: &Option<Largest>| largest.as_ref().map_or(-1.0, |largest| largest.value);
        if value(&other.largest) > value(&self.largest) {
            self.largest = other.largest;
        }
        let new: Vec<String> =
            other.channels.into_iter().filter(|channel| !self.channels.contains(channel)).collect();
        self.channels.extend(new);
        self.squares += other.squares;
        self.finite += other.finite;
        self.unlike += other.unlike;
        self.pixels_off += other.pixels_off;
        self.pixels += other.pixels;
    }
}

/// Compares two files. Values that differ by `tolerance` or less count as the same, and so do two NaNs. `frame` is what
/// is noted of the largest differences.
///
/// # Errors
/// A file that cannot be read: see [`whole_file::read`].
pub fn between(
    [a, b]: [&Path; 2],
    tolerance: f64,
    frame: Option<i32>,
) -> Result<(FileDifference, Picture), openexr::Error> {
    let (head, other_head) = (whole_file::header(a)?, whole_file::header(b)?);
    let size = [head.width, head.height];
    let windows = [window(&head), window(&other_head)];
    if windows[0] != windows[1] {
        let alone = alone(&head, &other_head);
        let (layers, pixels_off) = (Vec::new(), 0);
        let difference = FileDifference { size, windows: Some(windows), layers, alone, pixels_off };
        return Ok((difference, Picture { size, planes: Vec::new() }));
    }
    let mut first = whole_file::read(a)?;
    let second = subtract(&mut first, b)?;
    let alone = alone(&first, &second);
    first.channels.retain(|channel| second.channel(&channel.name).is_some());
    let planes: Vec<NamedPlane> =
        first.channels.into_iter().map(|channel| (channel.name, channel.data)).collect();
    let picture = Picture { size, planes };
    let (layers, pixels_off) = picture.measure(tolerance, frame);
    Ok((FileDifference { size, windows: None, layers, alone, pixels_off }, picture))
}

/// Bytes that [`between`] holds for a file of this header.
pub fn bytes(head: &ReadImage) -> u64 {
    u64::from(head.width) * u64::from(head.height) * 4 * head.channels.len() as u64
}

fn window(head: &ReadImage) -> [i64; 4] {
    let [left, top] = head.origin.map(i64::from);
    [left, top, i64::from(head.width), i64::from(head.height)]
}

fn alone(first: &ReadImage, second: &ReadImage) -> [Vec<String>; 2] {
    let without = |image: &ReadImage, other: &ReadImage| {
        let channels = image.channels.iter().filter(|channel| other.channel(&channel.name).is_none());
        channels.map(|channel| channel.name.clone()).collect()
    };
    [without(first, second), without(second, first)]
}

/// Replaces the values of `first` by their differences from the file at `path`. Returns that file's header.
fn subtract(first: &mut ReadImage, path: &Path) -> Result<ReadImage, openexr::Error> {
    let head = whole_file::header(path)?;
    let places: Vec<Option<usize>> = head
        .channels
        .iter()
        .map(|channel| first.channels.iter().position(|own| own.name == channel.name))
        .collect();
    let mut done = vec![0; places.len()];
    whole_file::scan(path, |channel, values| {
        // a file that was changed meanwhile may have other channels, or more lines
        let Some(Some(place)) = places.get(channel) else { return };
        let from = done[channel];
        done[channel] += values.len();
        if let Some(own) = first.channels[*place].data.get_mut(from..from + values.len()) {
            own.iter_mut().zip(values).for_each(|(own, other)| *own = apart(*own, *other));
        }
    })
}

/// Absolute difference; infinite if it is not a number.
fn apart(a: f32, b: f32) -> f32 {
    if a == b || (a.is_nan() && b.is_nan()) {
        return 0.0;
    }
    let apart = (a - b).abs();
    if apart.is_finite() { apart } else { f32::INFINITY }
}

impl Picture {
    /// Measures each layer, and counts the pixels in which some channel differs by more than `tolerance`.
    fn measure(&self, tolerance: f64, frame: Option<i32>) -> (Vec<LayerDifference>, u64) {
        let mut layers: Vec<(String, Vec<&NamedPlane>)> = Vec::new();
        for plane in &self.planes {
            let layer = title(&plane.0);
            match layers.iter_mut().find(|(known, _)| *known == layer) {
                Some((_, planes)) => planes.push(plane),
                None => layers.push((layer.to_owned(), vec![plane])),
            }
        }
        layers.sort_by(|a, b| a.0.cmp(&b.0));
        let measured =
            layers.into_par_iter().map(|(layer, planes)| self.layer(layer, planes, tolerance, frame));
        let layers = measured.collect();
        let all: Vec<&NamedPlane> = self.planes.iter().collect();
        (layers, pixels_off(&all, self.pixels(), tolerance))
    }

    fn pixels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    fn layer(
        &self,
        layer: String,
        mut planes: Vec<&NamedPlane>,
        tolerance: f64,
        frame: Option<i32>,
    ) -> LayerDifference {
        planes.sort_by_key(|(name, _)| reading_order(name));
        let mut found = LayerDifference {
            layer,
            channels: planes.iter().map(|(name, _)| name.clone()).collect(),
            largest: None,
            squares: 0.0,
            finite: 0,
            unlike: 0,
            pixels_off: pixels_off(&planes, self.pixels(), tolerance),
            pixels: self.pixels() as u64,
        };
        let mut largest = (0.0, 0, 0);
        for (number, (_, values)) in planes.iter().enumerate() {
            for (pixel, &value) in values.iter().enumerate() {
                if value > largest.0 {
                    largest = (value, number, pixel);
                }
                if value.is_finite() {
                    found.squares += f64::from(value).powi(2);
                    found.finite += 1;
                } else {
                    found.unlike += 1;
                }
            }
        }
        let (value, number, pixel) = largest;
        let width = self.size[0] as usize;
        found.largest = (value > 0.0).then(|| Largest {
            value,
            channel: planes[number].0.clone(),
            pixel: [(pixel % width) as u32, (pixel / width) as u32],
            frame,
        });
        found
    }

    /// The planes of the channels `R`, `G` and `B`, if all are there.
    pub fn colors(&self) -> Option<[&[f32]; 3]> {
        let plane =
            |name: &str| self.planes.iter().find(|(own, _)| own == name).map(|(_, values)| &values[..]);
        Some([plane("R")?, plane("G")?, plane("B")?])
    }
}

fn pixels_off(planes: &[&NamedPlane], pixels: usize, tolerance: f64) -> u64 {
    let is_off = |pixel: &usize| planes.iter().any(|(_, values)| f64::from(values[*pixel]) > tolerance);
    (0..pixels).filter(is_off).count() as u64
}

/// Name under which a channel counts: its layer, the empty name for the picture, or its own.
fn title(channel: &str) -> &str {
    match layer_of(channel) {
        "" if matches!(channel, "R" | "G" | "B" | "A") => "",
        "" => channel,
        layer => layer,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(planes: &[(&str, [f32; 4])]) -> Picture {
        let planes = planes.iter().map(|(name, values)| ((*name).to_owned(), values.to_vec())).collect();
        Picture { size: [2, 2], planes }
    }

    #[test]
    fn values_are_apart_by_their_difference() {
        let inf = f32::INFINITY;
        for ((a, b), expected) in [
            ((1.0, 3.0), 2.0),
            ((0.0, -0.0), 0.0),
            ((f32::NAN, f32::NAN), 0.0),
            ((inf, inf), 0.0),
            ((f32::NAN, 1.0), inf),
            ((1.0, -inf), inf),
            ((inf, -inf), inf),
        ] {
            assert_eq!((apart(a, b), apart(b, a)), (expected, expected), "{a} {b}");
        }
    }

    #[test]
    fn layers_tell_the_largest_the_mean_and_the_pixels() {
        let picture = picture(&[
            ("B", [0.0, 0.5, 0.0, 0.0]),
            ("R", [0.0, 0.5, 1.0, 0.0]),
            ("P.X", [0.0; 4]),
            ("Z", [f32::INFINITY, 2.0, 0.0, 0.0]),
        ]);
        let (layers, off) = picture.measure(0.0, Some(7));
        let names: Vec<&str> = layers.iter().map(|layer| layer.layer.as_str()).collect();
        assert_eq!((names, off), (vec!["", "P", "Z"], 3));
        let [colors, position, depth] = &layers[..] else { panic!("{layers:?}") };
        assert_eq!(colors.channels, ["R", "B"]);
        let largest = Largest { value: 1.0, channel: "R".into(), pixel: [0, 1], frame: Some(7) };
        assert_eq!((&colors.largest, colors.pixels_off), (&Some(largest), 2));
        assert!((colors.rmse() - (1.5_f64 / 8.0).sqrt()).abs() < 1e-12);
        assert_eq!((&position.largest, position.pixels_off, position.rmse()), (&None, 0, 0.0));
        assert_eq!((depth.unlike, depth.pixels_off, depth.pixels), (1, 2, 4));
        assert!(depth.largest.as_ref().is_some_and(|largest| largest.value == f32::INFINITY));
        assert!((depth.rmse() - (4.0_f64 / 3.0).sqrt()).abs() < 1e-12, "of those that are finite");
        assert_eq!(picture.measure(0.5, None).1, 3, "as far as the tolerance is the same");
        assert_eq!(picture.measure(1.0, None).1, 2);
    }

    #[test]
    fn frames_add_up() {
        let of =
            |value, frame| picture(&[("R", [value, 0.0, 0.0, 0.0])]).measure(0.0, Some(frame)).0.remove(0);
        let mut sum = of(1.0, 1);
        sum.merge(of(3.0, 2));
        sum.merge(of(0.0, 3));
        assert_eq!((sum.largest.as_ref().and_then(|largest| largest.frame), sum.pixels_off), (Some(2), 2));
        assert_eq!((sum.pixels, sum.rmse()), (12, (10.0_f64 / 12.0).sqrt()));
    }
}

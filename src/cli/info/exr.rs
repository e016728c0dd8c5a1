//! Description of an EXR file, ours or another program's, for `afterimage info`.

use std::borrow::Cow;
use std::fmt::Write;
use std::path::Path;

use glam::{Mat4, Vec3, Vec4};
use openexr::{Attribute, ReadImage};

use super::in_line;
use crate::cli::failure::Failure;
use crate::report::values::{Values, layer_of, name_in_layer, reading_order};

/// Describes the file at `path`: its parts, what its header says, and the values of each channel.
pub fn describe(path: &Path) -> Result<String, Failure> {
    let parts = openexr::part_count(path).map_err(Failure::of)?;
    let mut text = String::new();
    for number in 0..parts.max(1) {
        let mut values = Vec::new();
        let image = openexr::scan_part(path, number, |channel, lines| add(&mut values, channel, lines));
        match image {
            Ok(image) => {
                if parts > 1 {
                    let _ = writeln!(text, "part {} of {parts}: {}", number + 1, in_line(&image.part_name));
                }
                text += &part(&image, &values);
            }
            // other parts may be readable
            Err(error) if parts > 1 => {
                let _ = writeln!(text, "part {} of {parts}: {error}", number + 1);
            }
            Err(error) => return Err(Failure::of(error)),
        }
    }
    Ok(text)
}

fn add(all: &mut Vec<Values>, channel: usize, lines: &[f32]) {
    if all.len() <= channel {
        all.resize(channel + 1, Values::default());
    }
    all[channel].add(lines);
}

/// `values`: of each channel.
fn part(image: &ReadImage, values: &[Values]) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "  {name:<13}{value}");
    };
    line("size", size(image));
    let compression = image.compression.map_or_else(|| String::from("other"), |kind| format!("{kind:?}"));
    line("compression", compression.to_uppercase());
    if let Some(frame) = frame(image) {
        line("frame", frame);
    }
    if let Some(camera) = camera(image) {
        line("camera", camera);
    }
    for name in ["comments", "software"] {
        if let Some(Attribute::Text(text)) = image.attribute(name) {
            line(name, text.escape_debug().to_string());
        }
    }
    line("channels", image.channels.len().to_string());
    text += &channels(image, values);
    let _ = writeln!(text, "  {:<13}{}", "attributes", image.attributes.len());
    let longest = image.attributes.iter().map(|(name, _)| name.len() + 1).max().unwrap_or(0).max(24);
    for (name, value) in &image.attributes {
        let _ = writeln!(text, "    {:<longest$}{}", in_line(name), in_line(&attribute(value)));
    }
    text
}

fn size(image: &ReadImage) -> String {
    let (width, height) = (image.width, image.height);
    let [left, top] = image.origin;
    let [first, up, last, down] = image.display.map(i64::from);
    let pixels = format!("{width}x{height}");
    let (across, below) = (last - first + 1, down - up + 1);
    let is_shown_whole = (first, up, across, below) == (left.into(), top.into(), width.into(), height.into());
    if is_shown_whole && [left, top] == [0, 0] {
        return pixels;
    }
    format!("{pixels} at ({left}, {top}); the display window is {across}x{below} at ({first}, {up})")
}

fn frame(image: &ReadImage) -> Option<String> {
    let Some(Attribute::Int(number)) = image.attribute("imageCounter") else { return None };
    let mut text = number.to_string();
    if let Some(Attribute::Rational { numerator, denominator }) = image.attribute("framesPerSecond") {
        let rate =
            if *denominator == 1 { numerator.to_string() } else { format!("{numerator}/{denominator}") };
        let _ = write!(text, ", {rate} a second");
    }
    if let Some(Attribute::TimeCode { time_and_flags, .. }) = image.attribute("timeCode") {
        let _ = write!(text, ", time code {}", time_code(*time_and_flags));
    }
    Some(text)
}

/// Hours, minutes, seconds and frames, without flags.
fn time_code(time_and_flags: u32) -> String {
    let digits = |shift: u32, tens: u32| {
        let number = time_and_flags >> shift;
        ((number >> 4) & tens) * 10 + (number & 15)
    };
    format!("{:02}:{:02}:{:02}:{:02}", digits(24, 3), digits(16, 7), digits(8, 7), digits(0, 3))
}

/// Position and direction of the camera, and its vertical field of view (or, of an orthographic one, the
/// height of its view), if the header has both matrices.
fn camera(image: &ReadImage) -> Option<String> {
    let matrix = |name: &str| match image.attribute(name) {
        // rows of a matrix for row vectors are columns of one for column vectors
        Some(Attribute::M44f(numbers)) => Some(Mat4::from_cols_array(numbers)),
        _ => None,
    };
    let to_world = matrix("worldToCamera")?.inverse();
    let (eye, way) = (to_world.w_axis.truncate(), -to_world.z_axis.truncate());
    if !(eye.is_finite() && way.is_finite()) {
        return None;
    }
    let mut text = format!("at {}, looks along {}", point(eye), point(way));
    // the y axis of the picture, as a row of the projection: its length is the cotangent of half the angle
    if let Some(to_picture) = matrix("worldToNDC") {
        let projection = to_picture * to_world;
        let focal = (projection * Vec4::Y).y;
        let is_perspective = (projection * Vec4::Z).w != 0.0;
        if focal.is_finite() && focal > 0.0 && !is_perspective {
            let _ = write!(text, ", orthographic, sees a height of {:.4}", 2.0 / focal);
        } else if focal.is_finite() && focal > 0.0 {
            let _ = write!(text, ", vertical field of view {:.2}", 2.0 * (1.0 / focal).atan().to_degrees());
        }
    }
    Some(text)
}

fn point(point: Vec3) -> String {
    format!("({:.4}, {:.4}, {:.4})", point.x + 0.0, point.y + 0.0, point.z + 0.0)
}

/// One line a channel, layer by layer.
fn channels(image: &ReadImage, values: &[Values]) -> String {
    let width = |title: &str, part: fn(&str) -> &str| {
        let widths = image.channels.iter().map(|channel| part(&channel.name).chars().count());
        widths.fold(title.len(), usize::max) + 2
    };
    let (layers, names) = (width("layer", layer_of), width("channel", name_in_layer));
    let mut text = format!(
        "    {:<layers$}{:<names$}{:<6}{:>14}{:>14}{:>14}{:>9}{:>9}\n",
        "layer", "channel", "type", "least", "greatest", "mean", "NaN", "inf"
    );
    let mut channels: Vec<_> = image.channels.iter().zip(values).collect();
    channels.sort_by_key(|(channel, _)| (layer_of(&channel.name), reading_order(&channel.name)));
    let mut last = None;
    for (channel, values) in channels {
        let layer = layer_of(&channel.name);
        let shown = in_line(if last == Some(layer) { "" } else { layer });
        last = Some(layer);
        let stored = format!("{:?}", channel.stored).to_lowercase();
        let name = in_line(name_in_layer(&channel.name));
        let _ = write!(text, "    {shown:<layers$}{name:<names$}{stored:<6}");
        match values.mean() {
            Some(mean) => {
                for value in [values.least.into(), values.greatest.into(), mean] {
                    let _ = write!(text, "{:>14}", short(value));
                }
            }
            None => text += &format!("{:>14}{:>14}{:>14}", "-", "-", "-"),
        }
        let _ = writeln!(text, "{:>9}{:>9}", values.nan, values.infinite);
    }
    text
}

/// Six digits that count.
fn short(value: f64) -> String {
    match value.abs() {
        0.0 => String::from("0"),
        size if !(1e-4..1e7).contains(&size) => format!("{value:.5e}"),
        size => {
            let text = format!("{value:.*}", (5 - size.log10().floor() as i32).max(0) as usize);
            let is_fraction = text.contains('.');
            if is_fraction { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
        }
    }
}

/// Names of mattes may fill pages.
fn beginning(text: &str) -> Cow<'_, str> {
    const MOST: usize = 400;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{} ... ({} bytes)", &text[..end], text.len()).into(),
        None => text.into(),
    }
}

fn attribute(value: &Attribute) -> String {
    match value {
        Attribute::Text(text) => beginning(text).escape_debug().to_string(),
        Attribute::Texts(texts) => texts.join(", "),
        Attribute::Float(number) => number.to_string(),
        Attribute::Int(number) => number.to_string(),
        Attribute::Rational { numerator, denominator } => format!("{numerator}/{denominator}"),
        Attribute::M44f(numbers) => format!("{numbers:?}"),
        Attribute::V2f(numbers) => format!("{numbers:?}"),
        Attribute::V2i(numbers) => format!("{numbers:?}"),
        Attribute::V3f(numbers) => format!("{numbers:?}"),
        Attribute::Chromaticities(numbers) => format!("{numbers:?}"),
        Attribute::TimeCode { time_and_flags, .. } => time_code(*time_and_flags),
        Attribute::Other(kind) => format!("(of type {kind})"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::CameraPose;
    use crate::scene::camera::Projection;

    fn image() -> ReadImage {
        let channel = |name: &str| openexr::ReadChannel {
            name: name.into(),
            stored: openexr::SampleType::Half,
            data: Vec::new(),
        };
        ReadImage {
            width: 2,
            height: 1,
            channels: ["G", "R", "status_good.V"].map(channel).to_vec(),
            attributes: vec![
                ("framesPerSecond".into(), Attribute::Rational { numerator: 24000, denominator: 1001 }),
                ("imageCounter".into(), Attribute::Int(7)),
                ("timeCode".into(), Attribute::TimeCode { time_and_flags: 0x2359_5923, user_data: 0 }),
                ("comments".into(), Attribute::Text("a\nb".into())),
            ],
            compression: Some(openexr::Compression::Zips),
            origin: [0, 0],
            display: [0, 0, 1, 0],
            part_name: String::new(),
        }
    }

    #[test]
    fn a_frame_is_described_by_its_channels() {
        let mut values = Vec::new();
        for (channel, lines) in [(0, [0.5, 1.0]), (1, [f32::NAN, 2.0]), (2, [0.25, 0.75])] {
            add(&mut values, channel, &lines);
        }
        let text = part(&image(), &values);
        let words: Vec<Vec<&str>> = text.lines().map(|line| line.split_whitespace().collect()).collect();
        for line in [
            "size 2x1",
            "compression ZIPS",
            "frame 7, 24000/1001 a second, time code 23:59:59:23",
            "comments a\\nb",
            "channels 3",
            "R half 2 2 2 1 0",
            "G half 0.5 1 0.75 0 0",
            "status_good V half 0.25 0.75 0.5 0 0",
            "imageCounter 7",
        ] {
            assert!(words.contains(&line.split(' ').collect()), "{line} is not in\n{text}");
        }
    }

    #[test]
    fn cameras_and_windows_are_told() {
        let mut image = image();
        let pose = CameraPose {
            eye: Vec3::new(1.0, 2.0, 3.0),
            right: Vec3::X,
            up: Vec3::Y,
            forward: Vec3::NEG_Z,
            projection: Projection::Perspective,
            half_height: 1.0,
            shift: [0.0; 2],
            clip: crate::pose::Clip::NONE,
        };
        let (to_camera, to_picture) = (pose.world_to_camera(), pose.world_to_ndc(2.0));
        for (name, matrix) in [("worldToCamera", to_camera), ("worldToNDC", to_picture)] {
            image.attributes.push((name.into(), Attribute::M44f(matrix.to_cols_array())));
        }
        let told = camera(&image).expect("it has the matrices");
        let place = "at (1.0000, 2.0000, 3.0000), looks along (0.0000, 0.0000, -1.0000)";
        assert_eq!(told, format!("{place}, vertical field of view 90.00"));
        let pose = CameraPose { projection: Projection::Orthographic, half_height: 2.5, ..pose };
        image.attributes.pop();
        let to_picture = Attribute::M44f(pose.world_to_ndc(2.0).to_cols_array());
        image.attributes.push(("worldToNDC".into(), to_picture));
        let told = camera(&image).expect("it has the matrices");
        assert_eq!(told, format!("{place}, orthographic, sees a height of 5.0000"));
        image.origin = [-3, 4];
        assert_eq!(size(&image), "2x1 at (-3, 4); the display window is 2x1 at (0, 0)");
    }

    #[test]
    fn numbers_have_six_digits() {
        let texts = [0.0, 0.5, 123.456_789, 1e10, -1e-9, 999_999.0].map(short);
        assert_eq!(texts, ["0", "0.5", "123.457", "1.00000e10", "-1.00000e-9", "999999"]);
    }
}

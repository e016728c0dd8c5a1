//! Textures as their files say they are, and the stand-ins for those that cannot be shown.

use std::io::BufReader;
use std::path::Path;

use image::{ExtendedColorType, ImageDecoder, ImageFormat, ImageReader};

use crate::input::{self, Input, Kind};
use crate::scene::{Texture, Warning};

/// End of the message on a texture that a checker replaces.
const STANDS_IN: &str = "; a checker stands in for it";

/// Describes a texture: its size, format and bits, or that a stand-in is shown for it and why.
pub fn described(texture: &Texture, warnings: &[Warning]) -> String {
    let path = texture.path.display();
    let [width, height] = texture.size();
    let told = || warnings.iter().find_map(|warning| reason(&warning.0.message, &texture.path));
    match header(&texture.path) {
        Some((size, about)) if size == texture.size() => {
            format!("{path}: {}x{}, {about}", size[0], size[1])
        }
        // not a file of its own, and there
        None if texture.path.metadata().is_err() && told().is_none() => {
            format!("{path}: {width}x{height}, in the model's file")
        }
        _ => match told() {
            Some(why) => format!("{path}: a checker stands in for it, because it {why}"),
            None => format!("{path}: {width}x{height}"),
        },
    }
}

/// Reason why a stand-in is shown for the picture at `path`, if `message` tells one.
fn reason<'a>(message: &'a str, path: &Path) -> Option<&'a str> {
    let (name, why) = message.strip_prefix("the texture `")?.strip_suffix(STANDS_IN)?.split_once("` ")?;
    // as the file writes it, which may be with other slashes and folders
    let last = name.rsplit(['/', '\\']).next()?;
    let known = path.to_string_lossy();
    let is_it = known.ends_with(last) || known.rsplit_once('#').is_some_and(|(_, part)| name.contains(part));
    is_it.then_some(why)
}

/// Size of a picture and its format, by the beginning of its file.
fn header(path: &Path) -> Option<([u32; 2], String)> {
    let Input { file, .. } = input::open(path, Kind::Picture).ok()?;
    let mut reader = ImageReader::new(BufReader::new(file));
    if let Ok(format) = ImageFormat::from_path(path) {
        reader.set_format(format);
    }
    let reader = reader.with_guessed_format().ok()?;
    let format = reader.format()?;
    let decoder = reader.into_decoder().ok()?;
    let (width, height) = decoder.dimensions();
    let color = decoder.original_color_type();
    Some(([width, height], format!("{}, {}", name(format), bits(color))))
}

fn name(format: ImageFormat) -> String {
    format!("{format:?}").to_uppercase()
}

/// Channels and bits of a texel.
fn bits(color: ExtendedColorType) -> String {
    let channels = u16::from(color.channel_count());
    let bits = color.bits_per_pixel() / channels.max(1);
    let what = match channels {
        1 => "grey",
        2 => "grey and alpha",
        3 => "colour",
        _ => "colour and alpha",
    };
    format!("{bits} bits a channel, {what}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stand_in_is_told_by_its_own_warning() {
        let message = "the texture `maps\\wood.png` cannot be found; a checker stands in for it";
        assert_eq!(reason(message, Path::new("a/maps/wood.png")), Some("cannot be found"));
        assert_eq!(reason(message, Path::new("a/maps/stone.png")), None);
        let message = "the texture `bark (image 3)` cannot be read: short; a checker stands in for it";
        assert_eq!(reason(message, Path::new("a.glb#image 3")), Some("cannot be read: short"));
    }
}

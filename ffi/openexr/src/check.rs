//! Refuses images that would make a file that readers reject, before anything is created.

use std::path::Path;

use crate::{Channel, Error, Image, Placed};

/// Maximum length of names, bytes: longer ones need a file feature that many readers lack.
const LONGEST_NAME: usize = 31;

/// Checks the channels, and sorts them by name into the file's order.
pub(crate) fn sorted_channels<'a>(path: &Path, image: &Image<'a>) -> Result<Vec<Channel<'a>>, Error> {
    match image.channels.iter().find(|channel| channel.name.matches('.').count() > 1) {
        Some(Channel { name, .. }) => {
            let what = format!("channel {name:?}: a name may have one dot, between layer and channel");
            Err(Error::image(path, what))
        }
        None => sorted_with_views(path, image),
    }
}

/// Checks and sorts channels whose names may have the name of a view between layer and channel.
pub(crate) fn sorted_with_views<'a>(path: &Path, image: &Image<'a>) -> Result<Vec<Channel<'a>>, Error> {
    check_size(path, image)?;
    let mut channels = image.channels.clone();
    channels.sort_by(|a, b| a.name.as_bytes().cmp(b.name.as_bytes()));
    for channel in &channels {
        check_channel(path, image, channel)?;
    }
    match channels.windows(2).find(|pair| pair[0].name == pair[1].name) {
        Some(pair) => Err(Error::image(path, format!("channel {:?} is given twice", pair[0].name))),
        None => Ok(channels),
    }
}

fn check_size(path: &Path, image: &Image<'_>) -> Result<(), Error> {
    let (width, height) = (image.width, image.height);
    // OpenEXR keeps windows as i32, and counts the bytes of a line as i32.
    let bytes_per_line = u64::from(width) * 4 * image.channels.len() as u64;
    if width == 0 || height == 0 || i32::try_from(height).is_err() {
        return Err(Error::image(path, format!("{width}x{height} is no size for an image")));
    }
    if let Some(Placed { first, picture }) = image.placed {
        let fits = |first: i32, count: u32| i32::try_from(i64::from(first) + i64::from(count)).is_ok();
        let is_window = |[x, y]: [i32; 2], [width, height]: [u32; 2]| fits(x, width) && fits(y, height);
        if picture.contains(&0) || !is_window([0, 0], picture) || !is_window(first, [width, height]) {
            let [across, down] = picture;
            let message =
                format!("{width}x{height} pixels at {first:?} cannot lie in a picture of {across}x{down}");
            return Err(Error::image(path, message));
        }
    }
    if image.channels.is_empty() {
        return Err(Error::image(path, "it has no channel"));
    }
    if bytes_per_line * 32 > i32::MAX as u64 {
        return Err(Error::image(path, format!("lines of {bytes_per_line} bytes are too long")));
    }
    Ok(())
}

fn check_channel(path: &Path, image: &Image<'_>, channel: &Channel<'_>) -> Result<(), Error> {
    let name = channel.name;
    let refuse = |what: String| Err(Error::image(path, format!("channel {name:?}: {what}")));
    if let Some(what) = fault_of_name(name) {
        return refuse(what.to_owned());
    }
    let pixels = image.width as usize * image.height as usize;
    if channel.data.len() != pixels {
        return refuse(format!(
            "it has {} values, and {}x{} pixels need {pixels}",
            channel.data.len(),
            image.width,
            image.height
        ));
    }
    Ok(())
}

/// Fault in the name of a channel or an attribute.
pub(crate) fn fault_of_name(name: &str) -> Option<&'static str> {
    if name.is_empty() {
        Some("a name may not be empty")
    } else if name.len() > LONGEST_NAME {
        Some("a name may have 31 bytes at most")
    } else if name.bytes().any(|byte| byte < b' ') {
        Some("a name may not hold control characters")
    } else {
        None
    }
}

//! Reads the parts of an EXR file as one picture: the division of layers into parts says nothing about their
//! content.

use std::path::Path;

use openexr::{Error, ReadChannel, ReadImage};

/// Reads the header of the first part, with the channels of all parts.
///
/// # Errors As [`openexr::read_header`], of any part; and a part of another size or place than the first.
pub fn header(path: &Path) -> Result<ReadImage, Error> {
    let mut whole = openexr::read_header(path)?;
    for number in 1..openexr::part_count(path)? {
        add(path, number, openexr::read_header_of(path, number)?, &mut whole)?;
    }
    Ok(whole)
}

/// [`header`], and gives the lines of all channels (by their number in it) to `visit`, from top to bottom.
///
/// # Errors
/// The same; and as [`openexr::scan`].
pub fn scan(path: &Path, mut visit: impl FnMut(usize, &[f32])) -> Result<ReadImage, Error> {
    let mut whole = openexr::scan(path, &mut visit)?;
    for number in 1..openexr::part_count(path)? {
        let before = whole.channels.len();
        let part = openexr::scan_part(path, number, |channel, values| visit(before + channel, values))?;
        add(path, number, part, &mut whole)?;
    }
    Ok(whole)
}

/// [`header`] with the values of all channels.
///
/// # Errors
/// The same; and as [`openexr::read`].
pub fn read(path: &Path) -> Result<ReadImage, Error> {
    let mut planes: Vec<Vec<f32>> = Vec::new();
    let mut whole = scan(path, |channel, values| {
        planes.resize(planes.len().max(channel + 1), Vec::new());
        planes[channel].extend_from_slice(values);
    })?;
    for (channel, plane) in whole.channels.iter_mut().zip(planes) {
        channel.data = plane;
    }
    Ok(whole)
}

/// Adds the channels of part `number`. Programs that give the channels of all parts the same names tell them apart by the
/// parts' names.
fn add(path: &Path, number: usize, part: ReadImage, whole: &mut ReadImage) -> Result<(), Error> {
    let window = |image: &ReadImage| (image.origin, image.width, image.height);
    if window(&part) != window(whole) {
        let message = format!("part {} has another size or place than the first", number + 1);
        return Err(Error::Library {
            path: path.to_owned(),
            doing: "read its parts as one picture",
            message,
        });
    }
    for channel in part.channels {
        let name = match whole.channel(&channel.name) {
            Some(_) => format!("{}.{}", part.part_name, channel.name),
            None => channel.name,
        };
        whole.channels.push(ReadChannel { name, ..channel });
    }
    Ok(())
}

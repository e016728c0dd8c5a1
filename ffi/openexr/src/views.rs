//! Several views in one file, by the conventions of OpenEXR ("Storing Multi-View Images in OpenEXR Files"): the first view is
//! the default one, which readers show that know nothing of views.

use std::borrow::Cow;
use std::fs::File;
use std::path::Path;

use crate::check::{fault_of_name, sorted_channels, sorted_with_views};
use crate::parts::{Part, by_layer};
use crate::write::{DEFLATE_LEVEL, write_to};
use crate::{Attribute, Channel, Error, Image, View};

/// Writes `views` to `file`, which is empty and open for writing. Errors call it `path`.
///
/// In one part channels of the default view that have no layer keep their names; all others have the name of their view before
/// the last dot: `right.R`, `diffuse.left.R`. The header lists the views as `multiView`. It has the attributes of the default
/// view; where another view's differ they are named after it, as `right.worldToCamera`.
///
/// In `parts` each layer of each view has its own, named `layer.view` (the picture's: `rgba.left`), with the view's attributes
/// and its name as `view`. Channels keep their names then. The picture's parts come first, in the order of the views.
///
/// # Errors
/// Those of [`write()`](crate::write()); there is no view, a name that a view cannot have, or views that differ in size, place
/// or compression.
pub fn write_views(file: &File, path: &Path, views: &[View<'_>], parts: bool) -> Result<(), Error> {
    let Some(first) = views.first() else { return Err(Error::image(path, "it has no view")) };
    for view in views {
        check_view(path, view, &first.image)?;
        sorted_channels(path, &view.image)?;
    }
    if parts {
        let parts = parts_of(path, views)?;
        return write_to(file, path, &first.image, &parts, DEFLATE_LEVEL);
    }
    let names: Vec<Vec<String>> =
        (0..).zip(views).map(|(number, view)| names_in_file(number, view)).collect();
    let channels = views.iter().zip(&names).flat_map(|(view, names)| {
        view.image.channels.iter().zip(names).map(|(channel, name)| Channel { name, ..*channel })
    });
    let attributes = attributes_of(views);
    let all = Image { channels: channels.collect(), attributes: Vec::new(), ..first.image.clone() };
    let channels = sorted_with_views(path, &all)?;
    let part = Part { name: None, channels, attributes: Cow::Owned(attributes) };
    write_to(file, path, &all, &[part], DEFLATE_LEVEL)
}

fn check_view(path: &Path, view: &View<'_>, first: &Image<'_>) -> Result<(), Error> {
    let View { name, image } = view;
    let fault = match fault_of_name(name) {
        None if name.contains(['.', ' ']) => Some("a view's name has neither dots nor spaces"),
        fault => fault,
    };
    if let Some(fault) = fault {
        return Err(Error::image(path, format!("view {name:?}: {fault}")));
    }
    let form = |image: &Image<'_>| (image.width, image.height, image.placed, image.compression);
    if form(image) != form(first) {
        return Err(Error::image(path, format!("view {name:?} has another form than the first view")));
    }
    Ok(())
}

/// Names of the channels of view number `number`, the first of which is the default one.
fn names_in_file(number: usize, view: &View<'_>) -> Vec<String> {
    let name = |channel: &Channel<'_>| match channel.name.rsplit_once('.') {
        None if number == 0 => channel.name.to_owned(),
        None => format!("{}.{}", view.name, channel.name),
        Some((layer, letter)) => format!("{layer}.{}.{letter}", view.name),
    };
    view.image.channels.iter().map(name).collect()
}

/// Attributes of a file of one part.
fn attributes_of(views: &[View<'_>]) -> Vec<(String, Attribute)> {
    let Some((first, others)) = views.split_first() else { return Vec::new() };
    let mut attributes = first.image.attributes.clone();
    for view in others {
        let differing =
            view.image.attributes.iter().filter(|attribute| !first.image.attributes.contains(attribute));
        attributes.extend(differing.map(|(name, value)| (format!("{}.{name}", view.name), value.clone())));
    }
    let names = views.iter().map(|view| view.name.to_owned()).collect();
    attributes.push((String::from("multiView"), Attribute::Texts(names)));
    attributes
}

fn parts_of<'a>(path: &Path, views: &'a [View<'a>]) -> Result<Vec<Part<'a>>, Error> {
    let mut by_view = Vec::new();
    for view in views {
        let mut attributes = view.image.attributes.clone();
        attributes.push((String::from("view"), Attribute::Text(view.name.to_owned())));
        let mut parts = by_layer(sorted_channels(path, &view.image)?, &Cow::Owned(attributes));
        for part in &mut parts {
            part.name = part.name.take().map(|layer| Cow::Owned(format!("{layer}.{}", view.name)));
        }
        by_view.push(parts.into_iter());
    }
    let most = by_view.iter().map(ExactSizeIterator::len).max().unwrap_or(0);
    Ok((0..most).flat_map(|_| by_view.iter_mut().filter_map(Iterator::next).collect::<Vec<_>>()).collect())
}

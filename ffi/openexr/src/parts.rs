//! Division of channels into parts.

use std::borrow::Cow;

use crate::{Attribute, Channel};

/// Name of the part of channels that have no layer, as Nuke and others call it.
const PICTURE: &str = "rgba";

/// A part of a new file.
#[derive(Debug)]
pub(crate) struct Part<'a> {
    /// Name of the part. A file of one part needs none.
    pub name: Option<Cow<'a, str>>,
    /// Channels, sorted by name.
    pub channels: Vec<Channel<'a>>,
    /// Attributes of its header.
    pub attributes: Cow<'a, [(String, Attribute)]>,
}

/// Makes a part for each layer, the picture's first: most readers show the first. `channels` are sorted; each
/// part has all `attributes`.
pub(crate) fn by_layer<'a>(
    channels: Vec<Channel<'a>>,
    attributes: &Cow<'a, [(String, Attribute)]>,
) -> Vec<Part<'a>> {
    let mut parts: Vec<Part<'_>> = Vec::new();
    for channel in channels {
        let name = layer_of(channel.name);
        match parts.iter_mut().find(|part| part.name.as_deref() == Some(name)) {
            Some(part) => part.channels.push(channel),
            None => parts.push(Part {
                name: Some(Cow::Borrowed(name)),
                channels: vec![channel],
                attributes: attributes.clone(),
            }),
        }
    }
    parts.sort_by_key(|part| part.name.as_deref() != Some(PICTURE));
    parts
}

fn layer_of(channel: &str) -> &str {
    match channel.split_once('.') {
        Some((layer, _)) => layer,
        None if channel == "Z" => channel,
        None => PICTURE,
    }
}

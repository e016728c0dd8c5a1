//! Which channels make a part.

use crate::Channel;

/// The name of the part of channels that have no layer: what Nuke and others call it.
const PICTURE: &str = "rgba";

/// A part of a new file.
#[derive(Debug)]
pub(crate) struct Part<'a> {
    /// A file of one part needs none.
    pub name: Option<&'a str>,
    /// Sorted by name.
    pub channels: Vec<Channel<'a>>,
}

/// A part for each layer, the picture's first: most readers show the first. `channels` are sorted.
pub(crate) fn by_layer(channels: Vec<Channel<'_>>) -> Vec<Part<'_>> {
    let mut parts: Vec<Part<'_>> = Vec::new();
    for channel in channels {
        let name = layer_of(channel.name);
        match parts.iter_mut().find(|part| part.name == Some(name)) {
            Some(part) => part.channels.push(channel),
            None => parts.push(Part { name: Some(name), channels: vec![channel] }),
        }
    }
    parts.sort_by_key(|part| part.name != Some(PICTURE));
    parts
}

fn layer_of(channel: &str) -> &str {
    match channel.split_once('.') {
        Some((layer, _)) => layer,
        None if channel == "Z" => channel,
        None => PICTURE,
    }
}

//! Reads keys of a shot file into tracks, with the checks that all keys have in common. Each message points at the value's own place.

use crate::animation::track::Keyed;
use crate::animation::{Interpolation, Track};
use crate::scene::SceneError;
use crate::scene::keys::toml_text::{At, TomlText};

/// Maximum number of frames that are checked one by one for values that curves overshoot.
const MOST_FRAMES_LOOKED_AT: f64 = 100_000.0;

/// Sorts keys by frame. No two may share one.
pub fn in_order<'a, K>(
    text: TomlText<'_>,
    keys: &'a [At<K>],
    frame: impl Fn(&K) -> &At<f64>,
) -> Result<Vec<(f64, &'a At<K>)>, SceneError> {
    let fits = |frame: f64| frame.abs() <= f64::from(i32::MAX);
    let mut ordered = Vec::new();
    for key in keys {
        ordered.push((text.number("frame", frame(key.get_ref()), "a frame's number", fits)?, key));
    }
    ordered.sort_by(|a, b| a.0.total_cmp(&b.0));
    match ordered.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        Some(pair) => {
            let message = format!("is {}: there is another key at this frame already", pair[1].0);
            Err(text.bad("frame", frame(pair[1].1.get_ref()), &message))
        }
        None => Ok(ordered),
    }
}

/// Computes one value for each key.
pub fn each<K, T>(
    keys: &[(f64, &At<K>)],
    mut value: impl FnMut(&K) -> Result<T, SceneError>,
) -> Result<Vec<(f64, T)>, SceneError> {
    keys.iter().map(|(frame, key)| Ok((*frame, value(key.get_ref())?))).collect()
}

/// Returns the stated value, or `default`.
pub fn or<V, T>(
    stated: &Option<V>,
    key: &str,
    default: T,
    read: impl Fn(&str, &V) -> Result<T, SceneError>,
) -> Result<T, SceneError> {
    stated.as_ref().map_or(Ok(default), |value| read(key, value))
}

pub fn any_number(text: TomlText<'_>, key: &str, value: &At<f64>) -> Result<f64, SceneError> {
    text.number(key, value, "finite", |_| true)
}

pub fn through<T: Keyed>(keys: Vec<(f64, T)>, interpolation: Interpolation) -> Track<T> {
    Track::through(keys, interpolation).expect("keys are there, in order, no two at a frame")
}

/// Creates a track through one value a key, or, without keys, at rest.
pub fn through_or<K, T: Keyed>(
    rest: T,
    keys: &[(f64, &At<K>)],
    interpolation: Interpolation,
    value: impl Fn(&K) -> Result<T, SceneError>,
) -> Result<Track<T>, SceneError> {
    let values = each(keys, value)?;
    Ok(if values.is_empty() { Track::constant(rest) } else { through(values, interpolation) })
}

/// Whole frames from the first key to the last; of very long tracks the first ones.
pub fn frames_between<K>(keys: &[(f64, K)]) -> impl Iterator<Item = f64> {
    let (first, last) =
        (keys.first().map_or(0.0, |(frame, _)| *frame), keys.last().map_or(-1.0, |(frame, _)| *frame));
    whole_frames(first, last)
}

/// Whole frames about `first` to `last`; of very many the first ones.
pub fn whole_frames(first: f64, last: f64) -> impl Iterator<Item = f64> {
    let (first, last) = (first.floor(), last.ceil());
    let count = (last - first + 1.0).clamp(0.0, MOST_FRAMES_LOOKED_AT);
    (0..count as u32).map(move |i| first + f64::from(i))
}

//! Copies that a point instancer (UsdGeomPointInstancer) makes of its prototypes.

use std::collections::{BTreeSet, HashSet};

use glam::DAffine3;
use openusd::sdf::{Path, Value};
use openusd::usd::Prim;

use super::clock::Clock;
use super::place::Places;
use super::text::{ACTIVE_AGAIN, INACTIVE, INACTIVE_AS_WELL};
use super::value::{Answer, PrimError, Read, codes_read, numbers, said, targets, value, whole_numbers};
use crate::animation::{Interpolation, Track, Visibility};
use crate::memory::{self, Need, Part};

/// Parts of a frame after which copies that turn have keys.
const STEPS_A_FRAME: f64 = 4.0;

/// Attribute with the ids of copies that are not there.
const HIDDEN: &str = "invisibleIds";

/// A copy.
pub struct Copy {
    /// Number of the copy in the file.
    pub number: usize,
    /// Index of its prototype.
    pub prototype: usize,
    /// Map from the prototype to the instancer.
    pub map: Track<DAffine3>,
    pub visible: Visibility,
}

/// Copies of a point instancer.
pub struct Copies {
    /// Paths of the prototypes.
    pub prototypes: Vec<Path>,
    pub list: Vec<Copy>,
}

/// Reads the copies of an instancer.
///
/// # Errors Lists that do not fit together, or more copies than there is memory for.
pub fn copies(prim: &Prim, clock: &Clock, unused: &mut BTreeSet<String>) -> Read<Copies> {
    let prototypes = targets(prim, "prototypes")?;
    let mut frames = BTreeSet::new();
    for name in ["positions", "orientations", "orientationsf", "scales"] {
        frames.extend(codes_read(prim, name, clock)?.iter().map(|code| clock.frame(*code).to_bits()));
    }
    let mut frames: Vec<f64> = frames.into_iter().map(f64::from_bits).collect();
    frames.sort_by(f64::total_cmp);
    let moves = |name: &str| -> Answer<bool> { Ok(codes_read(prim, name, clock)?.len() > 1) };
    let turns = moves("orientations")? || moves("orientationsf")?;
    if let (true, Some(first), Some(last)) = (turns, frames.first().copied(), frames.last()) {
        let steps = ((last - first) * STEPS_A_FRAME).clamp(0.0, 4e6) as u32;
        frames.extend((0..steps).map(|step| first + f64::from(step) / STEPS_A_FRAME));
        frames.sort_by(f64::total_cmp);
        frames.dedup();
    }
    let first = frames.first().copied().unwrap_or_else(|| clock.first());
    let whole = |name: &str| -> Answer<Vec<i64>> {
        Ok(value(prim, name, clock.code(first))?.as_ref().and_then(whole_numbers).unwrap_or_default())
    };
    let of_copies = whole("protoIndices")?;
    let start = places(prim, clock.code(first))?;
    let path = prim.path();
    if start.len() != of_copies.len() {
        let (places, copies) = (start.len(), of_copies.len());
        return Err(format!("it has {copies} copies and {places} positions: export it again").into());
    }
    if let Some(bad) =
        of_copies.iter().find(|index| usize::try_from(**index).map_or(true, |i| i >= prototypes.len()))
    {
        let count = prototypes.len();
        return Err(format!("it copies prototype {bad}, and there are {count}: export it again").into());
    }
    let bytes = (start.len() as u64).saturating_mul(frames.len().max(1) as u64).saturating_mul(128);
    let need =
        Need::new(Part::new("the copies of a point instancer", bytes, "fewer copies, a shorter animation"));
    need.check(&memory::left()).map_err(|error| PrimError::Fatal(error.to_string()))?;
    let visible = visible(prim, clock, first, (whole("ids")?, start.len()))?;
    let mut keys: Vec<Vec<(f64, DAffine3)>> = start.iter().map(|map| vec![(first, *map)]).collect();
    for frame in frames.iter().skip(1) {
        let at = places(prim, clock.code(*frame))?;
        if at.len() != keys.len() {
            unused.insert(format!("copies of {path} appear with time: those of its first time are shown"));
            keys.iter_mut().for_each(|keys| keys.truncate(1));
            break;
        }
        keys.iter_mut().zip(at).for_each(|(keys, map)| keys.push((*frame, map)));
    }
    let copy = |(number, (keys, prototype)): (usize, (Vec<(f64, DAffine3)>, i64))| {
        let map = match keys.iter().all(|(_, map)| *map == keys[0].1) {
            true => Track::constant(keys[0].1),
            false => Track::through(keys, Interpolation::Linear)?,
        };
        let visible = visible[number].clone();
        (!visible.is_never()).then_some(Copy { number, prototype: prototype as usize, map, visible })
    };
    let list = keys.into_iter().zip(of_copies).enumerate().filter_map(copy).collect();
    Ok(Copies { prototypes, list })
}

/// Ids of copies that are inactive, over all layers of a prim: the metadata `inactiveIds`.
fn inactive(prim: &Prim) -> Answer<BTreeSet<i64>> {
    let stage = prim.stage();
    let mut fields = Vec::new();
    let graph = said(prim.prim_index().graph())?;
    for node in graph.all_nodes() {
        for (layer, _) in stage.node_layer_stack(node) {
            let Some(layer) = stage.layer_identifier(layer) else { continue };
            let Some(layer) = stage.layer(&layer) else { continue };
            for name in [INACTIVE, INACTIVE_AS_WELL, ACTIVE_AGAIN] {
                if let Ok(Some(value)) = layer.data().try_field(node.path(), name) {
                    fields.push((name, value.into_owned()));
                }
            }
        }
    }
    let mut ids = BTreeSet::new();
    // the stronger ones come first
    for (name, value) in fields.into_iter().rev() {
        if let Value::Int64ListOp(edit) = value {
            if edit.explicit {
                ids = edit.explicit_items.into_iter().collect();
                continue;
            }
            ids.retain(|id| !edit.deleted_items.contains(id));
            ids.extend([edit.added_items, edit.prepended_items, edit.appended_items].concat());
            continue;
        }
        let own = whole_numbers(&value).unwrap_or_default();
        match name {
            INACTIVE_AS_WELL => ids.extend(own),
            ACTIVE_AGAIN => ids.retain(|id| !own.contains(id)),
            _ => ids = own.into_iter().collect(),
        }
    }
    Ok(ids)
}

/// When the copies are there, of which so many have these ids; without ids each has its number.
fn visible(
    prim: &Prim,
    clock: &Clock,
    first: f64,
    (ids, count): (Vec<i64>, usize),
) -> Answer<Vec<Visibility>> {
    let inactive = inactive(prim)?;
    let times = codes_read(prim, HIDDEN, clock)?;
    let frames = match times.len() {
        0 | 1 => vec![first],
        _ => times.into_iter().map(|code| clock.frame(code)).collect(),
    };
    let mut hidden: Vec<(f64, HashSet<i64>)> = Vec::with_capacity(frames.len());
    for frame in frames {
        let own = value(prim, HIDDEN, clock.code(frame))?.as_ref().and_then(whole_numbers);
        hidden.push((frame, own.unwrap_or_default().into_iter().chain(inactive.iter().copied()).collect()));
    }
    let id = |number: usize| match ids.is_empty() {
        true => i64::try_from(number).ok(),
        false => ids.get(number).copied(),
    };
    let of_copy = |number: usize| {
        let is_there = |hidden: &HashSet<i64>| id(number).is_none_or(|id| !hidden.contains(&id));
        let mut keys: Vec<(f64, bool)> = Vec::new();
        for (frame, hidden) in &hidden {
            if keys.last().is_none_or(|(_, before)| *before != is_there(hidden)) {
                keys.push((*frame, is_there(hidden)));
            }
        }
        let first = keys[0].1;
        keys.remove(0);
        Visibility::through(first, keys).unwrap_or(Visibility::ALWAYS)
    };
    Ok((0..count).map(of_copy).collect())
}

/// Places of all copies at a time code.
fn places(prim: &Prim, code: f64) -> Answer<Vec<DAffine3>> {
    let list = |name: &str| -> Answer<Option<Vec<f64>>> {
        let read = value(prim, name, code)?.as_ref().and_then(numbers);
        Ok(read.filter(|numbers| numbers.iter().all(|number| number.is_finite())))
    };
    let translations = list("positions")?.unwrap_or_default();
    let scales = list("scales")?.unwrap_or_default();
    let turns = match list("orientationsf")?.filter(|turns| !turns.is_empty()) {
        Some(turns) => turns,
        None => list("orientations")?.unwrap_or_default(),
    };
    let count = translations.len() / 3;
    let places = Places { translations, turns, scales };
    Ok((0..count).map(|number| places.at(number)).collect())
}

//! Volumes (UsdVolVolume) whose fields are grids of OpenVDB files (OpenVDBAsset).

use std::collections::BTreeSet;
use std::path::PathBuf;

use openusd::sdf::Value;
use openusd::usd::{Prim, Stage};

use super::clock::Clock;
use super::file::{UsdMesh, UsdVolume};
use super::resolver;
use super::value::{Answer, codes_read, targets, value, word};
use crate::animation::Visibility;

/// Names of fields that are looked for, that of the density first.
const FIELDS: [&str; 8] = ["density", "temperature", "flame", "flames", "heat", "emission", "color", "Cd"];

/// Most times at which a volume is read: each is a model of its own.
const MOST_TIMES: usize = 2000;

/// A volume as it is at one time after the other, each with when it is there.
///
/// # Errors What the library says.
pub fn volumes(
    (prim, stage): (&Prim, &Stage),
    clock: &Clock,
    (surface, metres): (Option<usize>, f64),
    unused: &mut BTreeSet<String>,
) -> Answer<Vec<(UsdMesh, Visibility)>> {
    let mut fields = Vec::new();
    for name in FIELDS {
        fields
            .extend(targets(prim, &format!("field:{name}"))?.into_iter().next().map(|path| stage.prim(path)));
    }
    let Some(first) = fields.first() else {
        unused.insert(format!("the volume {} has no field of these: {}", prim.path(), FIELDS.join(", ")));
        return Ok(Vec::new());
    };
    let mut times = codes_read(first, "filePath", clock)?;
    times.truncate(MOST_TIMES);
    if times.is_empty() {
        times.push(clock.code(clock.first()));
    }
    let mut all = Vec::new();
    for (number, code) in times.iter().enumerate() {
        let Some(path) = file((first, stage), *code, unused)? else { continue };
        let mut grids = Vec::new();
        for field in &fields {
            if file((field, stage), *code, unused)?.as_ref() != Some(&path) {
                unused.insert(format!("fields of {} that lie in other files than its first", prim.path()));
                continue;
            }
            grids.extend(word(field, "fieldName", *code)?);
        }
        let name = prim.path().as_str().rsplit('/').next().unwrap_or_default().to_string();
        let volume = UsdVolume { path, grids, name, metres };
        let mut keys = vec![(clock.frame(*code), true)];
        keys.extend(times.get(number + 1).map(|next| (clock.frame(*next), false)));
        let there = match times.len() {
            1 => Visibility::ALWAYS,
            _ => Visibility::through(number == 0, keys).unwrap_or(Visibility::ALWAYS),
        };
        all.push((UsdMesh { uses: vec![(0, surface)], volume: Some(volume), ..UsdMesh::default() }, there));
    }
    Ok(all)
}

/// The file of a field at a time code.
fn file(
    (field, stage): (&Prim, &Stage),
    code: f64,
    unused: &mut BTreeSet<String>,
) -> Answer<Option<PathBuf>> {
    let asset = match value(field, "filePath", code)? {
        Some(Value::AssetPath(asset)) => Some(asset),
        // samples of one file, see `text`
        Some(Value::AssetPathVec(list)) => list.into_iter().next(),
        _ => None,
    };
    let Some(asset) = asset else { return Ok(None) };
    let resolved = match asset.resolved_path() {
        Some(path) => Some(PathBuf::from(path)).filter(|_| !path.ends_with(']')),
        None => resolver::beside_layers(stage, asset.asset_path(), |path| path.is_file()),
    };
    if resolved.is_none() {
        let name: String = asset.asset_path().chars().take(200).collect();
        unused.insert(format!(
            "the volume `{}` is not there, or lies in a package",
            crate::visible::visible(&name)
        ));
    }
    Ok(resolved)
}

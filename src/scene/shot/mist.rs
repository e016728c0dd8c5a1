//! The mist of a shot: its keys, read.

use crate::scene::keys::MistTable;
use crate::scene::keys::toml_text::{At, TomlText};
use crate::scene::{Mist, SceneError};

/// Reads the table, if there is one.
pub fn of_table(text: TomlText<'_>, table: Option<&At<MistTable>>) -> Result<Mist, SceneError> {
    let Some(MistTable { start, depth, falloff }) = table.map(At::get_ref) else {
        return Ok(Mist::default());
    };
    let usual = Mist::default();
    let start = start.as_ref();
    let start =
        start.map(|start| text.number("start", start, "from 0 to 1e9", |at| (0.0..=1e9).contains(&at)));
    let depth = depth.as_ref();
    let depth =
        depth.map(|depth| text.number("depth", depth, "from 1e-9 to 1e9", |way| (1e-9..=1e9).contains(&way)));
    Ok(Mist {
        start: start.transpose()?.unwrap_or(usual.start),
        depth: depth.transpose()?.unwrap_or(usual.depth),
        falloff: falloff.unwrap_or_default(),
    })
}

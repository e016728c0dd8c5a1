//! A shot, and how it is tried.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;
use std::{fs, io};

use afterimage::trace::BackendKind;
use toml::{Table, Value};

use crate::dice::Dice;
use crate::files;
use crate::generate::generate;

/// What is done otherwise in a second run, which has to give the same pictures to the bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Variation {
    /// One thread instead of three; nothing else. All others have one thread as well.
    Threads,
    /// All shadow tags are dropped before each frame.
    NoTags,
    /// Nothing is kept of ray trees.
    NoTrees,
    /// The samples of one frame go through a file, the renderer makes another frame, and then goes on from them.
    Store,
    /// Frames are rendered from a later one on, as a chunk of a farm.
    Chunk,
}

impl Variation {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Threads, Self::NoTags, Self::NoTrees, Self::Store, Self::Chunk];
}

/// Frames that proofs look ahead: as many as usual, or so few that proofs end within a shot.
pub const AHEAD: [i32; 4] = [16, 1, 2, 4];

/// Keys of a model that say what rays see of it, or what links know of it, and nothing of its place.
const OF_RAYS: [&str; 7] =
    ["hidden_from", "holdout", "shadow_catcher", "groups", "light_link", "shadow_link", "light_group"];

/// A model without some of its keys.
fn without(model: &Table, keys: &[&str]) -> Table {
    let kept = model.iter().filter(|(key, _)| !keys.contains(&key.as_str()));
    kept.map(|(key, value)| (key.clone(), value.clone())).collect()
}

/// A shot, and how it is tried.
#[derive(Debug, Clone)]
pub struct Trial {
    pub shot: Table,
    pub backend: BackendKind,
    pub variation: Variation,
    /// Frames that [proofs](afterimage::frame::Renderer::prove_ahead) look ahead.
    pub ahead: i32,
    /// Before which frame, counted from the first, the variation begins.
    pub turn: usize,
}

impl Trial {
    /// That of a seed.
    pub fn of_seed(seed: u64) -> Self {
        let mut dice = Dice::new(!seed);
        Self {
            shot: generate(seed),
            backend: if dice.one_in(4) { BackendKind::Rust } else { BackendKind::Embree },
            variation: *dice.pick(&Variation::ALL),
            turn: 1 + dice.below(4),
            ahead: *dice.pick(&AHEAD),
        }
    }

    /// That of a shot file.
    ///
    /// # Errors
    /// If it is no TOML.
    pub fn of_text(text: &str) -> Result<Self, toml::de::Error> {
        Ok(Self {
            shot: toml::from_str(text)?,
            backend: BackendKind::Embree,
            variation: Variation::Threads,
            turn: 1,
            ahead: AHEAD[0],
        })
    }

    /// The text of its shot file.
    pub fn text(&self) -> String {
        toml::to_string(&self.shot).unwrap_or_else(|error| format!("# {error}\n"))
    }

    /// Writes the shot file, `shot.toml`, and all that it names to a folder.
    pub fn write(&self, folder: &Path) -> io::Result<()> {
        let mut names = BTreeSet::from(["plain.mtl".to_string()]);
        find_names(&self.shot, &mut names);
        // graphs may name any of them
        if names.iter().any(|name| name.ends_with(".mtlx")) {
            names.extend(files::TEXTURES.map(String::from));
        }
        for name in names {
            for name in numbered(&name) {
                if let Some(content) = files::content(&name) {
                    fs::write(folder.join(name), content)?;
                }
            }
        }
        fs::write(folder.join("shot.toml"), self.text())
    }

    /// Whether two models that move are always in the same place. Which of them a ray meets is not defined: each run is right, and
    /// may differ from another.
    pub fn has_coinciding_movers(&self) -> bool {
        let models: Vec<Table> = self.models().map(|model| without(model, &OF_RAYS)).collect();
        let keys = ["key", "shapes", "visible", "gltf"];
        let moves = |model: &Table| keys.iter().any(|key| model.contains_key(*key));
        (1..models.len()).any(|number| moves(&models[number]) && models[..number].contains(&models[number]))
    }

    /// Whether two models may be in the same place in some frame. Which of their surfaces a ray meets is not defined: each is right.
    pub fn has_coinciding_models(&self) -> bool {
        // the same shape in the same place, whatever moves it away from there, and back
        let rest = |model: &Table| -> Table {
            let of_motion = ["key", "shapes", "visible", "interpolation", "reflection_map"];
            let mut rest = without(&without(model, &OF_RAYS), &of_motion);
            for key in ["obj", "gltf"] {
                let shape = rest.get(key).and_then(Value::as_str).and_then(|name| name.split('-').next());
                if let Some(shape) = shape.map(String::from) {
                    rest.insert(key.into(), shape.into());
                }
            }
            for key in ["quadric", "curves", "vdb"] {
                if let Some(Value::Table(shape)) = rest.get_mut(key) {
                    shape.remove("material");
                }
            }
            rest
        };
        let models: Vec<Table> = self.models().map(rest).collect();
        (1..models.len()).any(|number| models[..number].contains(&models[number]))
    }

    fn models(&self) -> impl Iterator<Item = &Table> {
        self.shot.get("model").and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_table)
    }

    /// How to see for oneself what the audit finds.
    pub fn command(&self) -> String {
        let mut text = String::from("afterimage render shot.toml --audit");
        if self.backend == BackendKind::Rust {
            let _ = write!(text, " --backend rust");
        }
        text
    }
}

/// Each string below `table` may name a file.
fn find_names(table: &Table, names: &mut BTreeSet<String>) {
    table.values().for_each(|value| find_names_in(value, names));
}

fn find_names_in(value: &Value, names: &mut BTreeSet<String>) {
    match value {
        Value::Table(table) => find_names(table, names),
        Value::Array(list) => list.iter().for_each(|value| find_names_in(value, names)),
        Value::String(text) => drop(names.insert(text.clone())),
        _ => {}
    }
}

/// The files of a sequence, or the one that is named.
fn numbered(name: &str) -> Vec<String> {
    match name.contains("##") {
        true => (1..=3).map(|number| name.replace("##", &format!("{number:02}"))).collect(),
        false => vec![name.to_string()],
    }
}

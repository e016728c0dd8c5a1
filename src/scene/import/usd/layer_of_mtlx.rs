//! MaterialX files that layers refer to: a layer stands for each, with a material for each of the file's.
//!
//! A material of such a layer names the file and its own name there; the file itself is read where the material is used
//! ([`MtlxFiles`](crate::scene::import::mtlx::MtlxFiles)).

use std::fmt::Write;
use std::path::{Path, PathBuf};

use openusd::usd::Prim;

use super::text::Fault;
use super::value::{Answer, word};
use crate::scene::import::mtlx::Document;

/// Ending of MaterialX files.
const ENDING: &str = ".mtlx";

/// What the paths of layers end with that stand for such a file: what the library reads as text.
const LAYER_ENDING: &str = ".mtlx.usda";

/// Attributes of materials that are those of a file: its path, and the name of the material in it.
const FILE: &str = "mtlx:file";
const NAME: &str = "mtlx:name";

/// Path of the layer that stands for the file at `resolved`, if it is one of MaterialX.
pub fn of_file(resolved: &str) -> Option<String> {
    resolved.ends_with(ENDING).then(|| format!("{resolved}{}", &LAYER_ENDING[ENDING.len()..]))
}

/// File for which the layer at `resolved` stands.
pub fn file_of(resolved: &str) -> Option<&str> {
    resolved
        .strip_suffix(&LAYER_ENDING[ENDING.len()..])
        .filter(|file| file.ends_with(ENDING) && !Path::new(resolved).is_file())
}

/// Text of the layer that stands for a file. Its materials are where Pixar's library has them.
///
/// # Errors A file that cannot be read, or is no MaterialX.
pub fn text(file: &str) -> Result<String, Fault> {
    if file.contains(['"', '\\']) || file.contains(char::is_control) {
        return Err(Fault {
            line: None,
            message: String::from("its path has quotes or backslashes: rename it"),
        });
    }
    let document = Document::read(Path::new(file))
        .map_err(|error| Fault { line: error.line, message: error.message })?;
    let mut text = String::from(
        "#usda 1.0\n(\n defaultPrim = \"MaterialX\"\n)\ndef \"MaterialX\" {\n def \"Materials\" {\n",
    );
    for name in document.materials().filter(|name| !name.contains(['"', '\\'])) {
        let prim = identifier(name);
        // a write to a string does not fail
        let _ = writeln!(
            text,
            "  def Material \"{prim}\" {{\n   custom string {FILE} = \"{file}\"\n   custom string {NAME} = \"{name}\"\n  }}"
        );
    }
    text.push_str(" }\n}\n");
    Ok(text)
}

/// A name of which a prim may have: other letters become `_`, as in Pixar's library.
fn identifier(name: &str) -> String {
    let is_first_odd = name.chars().next().is_none_or(|letter| letter.is_ascii_digit());
    let letter = |letter: char| if letter.is_ascii_alphanumeric() { letter } else { '_' };
    is_first_odd.then_some('_').into_iter().chain(name.chars().map(letter)).collect()
}

/// File of a material of such a layer, and its name there.
pub fn material(prim: &Prim, code: f64) -> Answer<Option<(PathBuf, String)>> {
    let (file, name) = (word(prim, FILE, code)?, word(prim, NAME, code)?);
    Ok(file.zip(name).map(|(file, name)| (PathBuf::from(file), name)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_identifiers() {
        assert_eq!(["Oak", "3D wood", "a:b", ""].map(identifier), ["Oak", "_3D_wood", "a_b", "_"]);
    }

    #[test]
    fn layers_stand_for_files_of_materialx_alone() {
        assert_eq!(of_file("a/b.mtlx").as_deref(), Some("a/b.mtlx.usda"));
        assert_eq!(of_file("a/b.usda"), None);
        assert_eq!(file_of("a/b.mtlx.usda"), Some("a/b.mtlx"));
        assert_eq!((file_of("a/b.usda"), file_of("")), (None, None));
    }
}

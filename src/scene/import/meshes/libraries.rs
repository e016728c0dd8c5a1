//! The MTL files of an OBJ file: those that it names, or the one beside it.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use super::read_model::is_ply;
use crate::scene::SceneError;
use crate::scene::error::Findings;
use crate::scene::import::Import;
use crate::scene::import::faces::TriangleSoup;
use crate::scene::import::mtl::statements::Statements;
use crate::scene::import::mtl::{self, Exporter, MtlFile};
use crate::scene::import::obj::lines::words;
use crate::scene::keys::material::KdBesideMap;
use crate::scene::paths::find_beside;

/// Maximum number of odd statements of a file that get a warning each.
const MOST_NAMED: usize = 10;

/// A material of an MTL file, with the file.
pub struct Defined {
    pub material: Statements,
    /// Program that wrote the file.
    pub exporter: Exporter,
    pub path: PathBuf,
}

impl Defined {
    /// What it states, as the program means it that wrote the file.
    pub fn meant(&self, kd_beside_map: KdBesideMap) -> Statements {
        self.exporter.meant(self.material.clone(), kd_beside_map)
    }
}

/// Reads the MTL files of `obj`. The flag says whether all were found.
pub fn libraries(
    import: &mut Import,
    obj: &TriangleSoup,
    path: &Path,
) -> Result<(Vec<Defined>, bool), SceneError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut defined = Vec::new();
    let mut complete = true;
    // some writers repeat the line before every object
    let (mut names, mut files) = (HashSet::new(), HashSet::new());
    for library in obj.libraries.iter().filter(|library| names.insert(library.name.as_str())) {
        let (mut found, missing) = library_files(folder, &library.name);
        // models are renamed together with their materials, and then name what was there before
        let own = (!missing.is_empty()).then(|| own_library(path)).flatten();
        let own = own.filter(|own| !files.contains(own) && !found.contains(own));
        complete &= missing.is_empty() || own.is_some();
        for name in missing {
            let place = |message| SceneError::new(path, message).at_line(library.line);
            let message = format!("the material file `{name}` cannot be found");
            match &own {
                Some(own) => {
                    let own = own.file_name().unwrap_or_default().to_string_lossy();
                    import.findings.note(place(format!("{message}: `{own}` is read in its place")));
                }
                None => {
                    let message = format!("{message}; faces that need it are drawn grey");
                    import.findings.stand_in(place(message))?;
                }
            }
        }
        found.extend(own);
        for file in found {
            if files.insert(file.clone()) {
                read_library(import, file, &mut defined)?;
            }
        }
    }
    let names_materials = obj.materials.iter().any(|material| !material.name.is_empty());
    if let (true, true, Some(own)) = (obj.libraries.is_empty(), names_materials, own_library(path)) {
        let name = own.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let message = format!("it names no material file (mtllib): `{name}`, which is beside it, is read");
        import.findings.note(SceneError::new(path, message));
        read_library(import, own, &mut defined)?;
    }
    Ok((defined, complete))
}

/// Reads an MTL file, and adds what it defines.
fn read_library(import: &mut Import, file: PathBuf, defined: &mut Vec<Defined>) -> Result<(), SceneError> {
    let MtlFile { materials, exporter, oddities, unused, digest } = mtl::read(&file)?;
    import.inputs.add([file.clone()], digest);
    report_oddities(&mut import.findings, oddities, &file)?;
    note_contradictions(&mut import.findings, &materials, &file);
    for (line, message) in unused {
        import.findings.note(SceneError::new(&file, message).at_line(line));
    }
    import.surfaces.known_names.extend(materials.iter().map(|material| material.name.clone()));
    defined.extend(materials.into_iter().map(|material| Defined { material, exporter, path: file.clone() }));
    Ok(())
}

fn report_oddities(
    findings: &mut Findings,
    oddities: Vec<(usize, String)>,
    file: &Path,
) -> Result<(), SceneError> {
    let more = oddities.len().saturating_sub(MOST_NAMED);
    for (line, message) in oddities.into_iter().take(MOST_NAMED) {
        findings.stand_in(SceneError::new(file, message).at_line(line))?;
    }
    if more > 0 {
        findings.note(SceneError::new(file, format!("{more} more statements make no sense")));
    }
    Ok(())
}

fn note_contradictions(findings: &mut Findings, materials: &[Statements], file: &Path) {
    if let Some(first) = materials.iter().find(|material| material.contradicts_itself()) {
        let message =
            format!("`d` and `Tr` of the material `{}` contradict each other: `d` counts", first.name);
        findings.note(SceneError::new(file, message).at_line(first.line));
    }
}

/// The MTL file beside an OBJ file that has its name, if there is one.
fn own_library(obj: &Path) -> Option<PathBuf> {
    if is_ply(obj) {
        return None;
    }
    let name = obj.with_extension("mtl");
    find_beside(obj.parent().unwrap_or(Path::new("")), &name.file_name()?.to_string_lossy())
}

/// The files that a `mtllib` line means: one name that may hold spaces, or several, or several that may
/// hold spaces. Then the names for which there is no file. A name may stand between quotes.
fn library_files(folder: &Path, text: &str) -> (Vec<PathBuf>, Vec<String>) {
    let quoted = text.strip_prefix('"').and_then(|text| text.strip_suffix('"'));
    if let Some(path) = quoted.and_then(|name| find_beside(folder, name)) {
        return (vec![path], Vec::new());
    }
    let words: Vec<String> =
        words(text.as_bytes()).map(|word| String::from_utf8_lossy(word).into_owned()).collect();
    let (mut found, mut missing) = (Vec::new(), Vec::new());
    if let Some(path) = find_beside(folder, text) {
        return (vec![path], missing);
    }
    let mut at = 0;
    while at < words.len() {
        // the longest name that there is a file for; limited, for lines of a thousand words
        let longest = words.len().min(at + 16);
        let file = (at + 1..=longest)
            .rev()
            .find_map(|end| Some((end, find_beside(folder, &words[at..end].join(" "))?)));
        at = match file {
            Some((end, path)) => {
                found.push(path);
                end
            }
            None => {
                missing.push(words[at].clone());
                at + 1
            }
        };
    }
    if found.is_empty() && !text.is_empty() {
        missing = vec![text.to_string()];
    }
    (found, missing)
}

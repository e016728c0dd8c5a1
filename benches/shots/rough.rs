//! A scene with other materials: all but glass become rough, as those of programs are that write `Pr`.

use std::error::Error;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};

/// The OBJ at `obj`, in `to`: a folder of links to what is beside it, but that its material libraries state `roughness` of all
/// materials that are no glass.
pub fn copy(obj: &Path, to: &Path, roughness: f32) -> Result<PathBuf, Box<dyn Error>> {
    let from = obj.parent().ok_or("an OBJ is in a folder")?;
    if to.exists() {
        fs::remove_dir_all(to)?;
    }
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let path = entry?.path();
        let name = path.file_name().ok_or("entries have names")?;
        match path.extension().is_some_and(|kind| kind == "mtl") {
            true => fs::write(to.join(name), roughened(&fs::read_to_string(&path)?, roughness))?,
            false => symlink(&path, to.join(name))?,
        }
    }
    Ok(to.join(obj.file_name().ok_or("an OBJ has a name")?))
}

/// The text of a material library, in which all materials but glass have this roughness.
fn roughened(text: &str, roughness: f32) -> String {
    const NEW: &str = "newmtl ";
    let mut materials = text.split_inclusive('\n').fold(vec![String::new()], |mut materials, line| {
        if line.starts_with(NEW) {
            materials.push(String::new());
        }
        if let Some(last) = materials.last_mut() {
            last.push_str(line);
        }
        materials
    });
    for material in materials.iter_mut().filter(|material| material.starts_with(NEW)) {
        let states = |key: &str, values: &[&str]| {
            let values_of = |line: &str| line.strip_prefix(key).map(|value| value.trim().to_owned());
            material.lines().filter_map(values_of).any(|value| values.contains(&value.as_str()))
        };
        if states("illum ", &["4", "6", "7", "9"]) {
            continue;
        }
        let kept: String = material.split_inclusive('\n').filter(|line| !line.starts_with("Pr ")).collect();
        *material = format!("{}\nPr {roughness}\n", kept.trim_end());
    }
    materials.concat()
}

//! Text of what a bare USD file's shot says beside its camera and lights: what of the file is read, and files of the picture.

use std::fmt::Write;

use toml::Value;

use super::choice::StageChoice;
use super::file::UsdFile;

/// The key `stage` of a model; empty where all of the file is read.
pub fn stage(choice: &StageChoice) -> String {
    let StageChoice { variants, purposes, mask, unloaded, frames } = choice;
    let mut table = toml::Table::new();
    let mut add = |key: &str, names: Vec<String>| {
        table.insert(key.into(), Value::Array(names.into_iter().map(Value::from).collect()));
    };
    if !variants.is_empty() {
        add("variants", variants.iter().map(ToString::to_string).collect());
    }
    if let Some(purposes) = purposes {
        add("purposes", purposes.iter().map(|purpose| String::from(purpose.name())).collect());
    }
    if !mask.is_empty() {
        add("mask", mask.clone());
    }
    if !unloaded.is_empty() {
        add("unloaded", unloaded.clone());
    }
    if let Some([first, last]) = frames {
        table.insert("time_samples".into(), Value::from(format!("{first}:{last}")));
    }
    match table.is_empty() {
        true => String::new(),
        false => format!("stage = {}\n", Value::Table(table)),
    }
}

/// The table `[output]`, where the file says something of its pictures; `stops`: by which its camera makes them brighter.
pub fn output(file: &UsdFile, stops: f64) -> String {
    let render = file.content.render.as_ref();
    let mut text = String::new();
    if let Some(name) = render.and_then(|render| render.output.as_ref()) {
        let _ = writeln!(text, "path = {}", Value::from(numbered(name)));
    }
    if let Some(layers) = render.and_then(|render| render.layers) {
        let names: Vec<Value> = layers.names().map(Value::from).collect();
        let _ = writeln!(text, "layers = {}", Value::Array(names));
    }
    if stops != 0.0 {
        let _ = writeln!(text, "exposure = {}", Value::from(stops));
    }
    match text.is_empty() {
        true => text,
        false => format!("\n[output]\n{text}"),
    }
}

/// Name of a product's file for a picture of each frame: as EXR, with a place for the frame's number.
fn numbered(name: &str) -> String {
    let name = name.replace("$F4", "####").replace("$F", "####").replace("<F4>", "####");
    let (folder, file) = name.rsplit_once('/').map_or(("", name.as_str()), |(folder, file)| (folder, file));
    let stem = match file.rsplit_once('.') {
        Some((stem, ending)) if !ending.contains(['#', '%']) => stem,
        _ => file,
    };
    let slash = if folder.is_empty() && !name.starts_with('/') { "" } else { "/" };
    let number = if stem.contains(['#', '%']) { "" } else { ".####" };
    format!("{folder}{slash}{stem}{number}.exr")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_products_get_a_number_and_are_exr_files() {
        for (name, expected) in [
            ("beauty.exr", "beauty.####.exr"),
            ("out/beauty", "out/beauty.####.exr"),
            ("/a/b.####.exr", "/a/b.####.exr"),
            ("b.$F4.exr", "b.####.exr"),
            ("/b.png", "/b.####.exr"),
            ("b.%04d.exr", "b.%04d.exr"),
            ("b.####", "b.####.exr"),
        ] {
            assert_eq!(numbered(name), expected);
        }
    }
}

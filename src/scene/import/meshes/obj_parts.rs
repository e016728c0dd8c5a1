//! Objects (`o`) and groups (`g`) of OBJ files as models of their own.
//!
//! The file is read once, into one mesh; each part takes its triangles and their vertices out of that. What all parts share
//! (materials, pictures, warnings) is then the file's, as if it were one model.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use super::objects::{PartOfObj, Segment, Taker};
use crate::scene::SceneError;
use crate::scene::import::Import;
use crate::scene::import::meshes::{MeshFile, MeshFiles, known_as};
use crate::scene::keys::model::Division;
use crate::scene::keys::spelling;

/// Maximum number of names that an error lists.
const MOST_LISTED: usize = 20;

impl MeshFiles {
    /// Takes the part called `name` out of the OBJ file at `path`: all faces whose last `o`, or whose last `o` or `g`, is `name`.
    /// The inner error, the end of a sentence about the name, says that there is no such part.
    ///
    /// # Errors Those of [`mesh`](Self::mesh).
    pub fn part(
        &mut self,
        import: &mut Import,
        path: &Path,
        name: &str,
    ) -> Result<Result<PartOfObj, String>, SceneError> {
        self.mesh(import, path)?;
        let key = (known_as(path), String::from(name));
        if let Some(mesh) = self.parts.by_name.get(&key) {
            return Ok(Ok(PartOfObj { name: key.1, mesh: mesh.clone() }));
        }
        let file = &self.files[&key.0];
        let (names, segments) = (file.mesh.groups.names(), segments(file));
        let is_called = |number: u32| names[number as usize] == name;
        let of_part: Vec<&Segment> =
            segments.iter().filter(|of| is_called(of.object) || is_called(of.group)).collect();
        if of_part.is_empty() {
            return Ok(Err(unknown(name, names, &segments)));
        }
        let mesh = Arc::new(Taker::new(&file.mesh).take(&of_part));
        self.parts.by_name.insert(key, mesh.clone());
        Ok(Ok(PartOfObj { name: String::from(name), mesh }))
    }

    /// Divides the OBJ file at `path` into parts, in the order in which it names them. The inner error, the end of a sentence,
    /// says that there is nothing to divide by.
    ///
    /// # Errors Those of [`mesh`](Self::mesh).
    pub fn divided(
        &mut self,
        import: &mut Import,
        path: &Path,
        by: Division,
    ) -> Result<Result<Arc<Vec<PartOfObj>>, String>, SceneError> {
        self.mesh(import, path)?;
        let key = (known_as(path), by);
        if let Some(parts) = self.parts.divided.get(&key) {
            return Ok(Ok(parts.clone()));
        }
        let file = &self.files[&key.0];
        let segments = segments(file);
        let number = |of: &Segment| match by {
            Division::Objects => of.object,
            Division::Groups => of.group,
        };
        let mut of_parts: BTreeMap<u32, Vec<&Segment>> = BTreeMap::new();
        segments.iter().for_each(|of| of_parts.entry(number(of)).or_default().push(of));
        if of_parts.keys().all(|number| *number == 0) {
            return Ok(Err(nothing_to_divide(by, &segments)));
        }
        let (mut taker, names) = (Taker::new(&file.mesh), file.mesh.groups.names());
        let parts = of_parts.iter().map(|(number, of_part)| PartOfObj {
            name: names[*number as usize].clone(),
            mesh: Arc::new(taker.take(of_part)),
        });
        let parts: Arc<Vec<PartOfObj>> = Arc::new(parts.collect());
        self.parts.divided.insert(key, parts.clone());
        Ok(Ok(parts))
    }
}

/// Runs of triangles of the same object and group, in order.
fn segments(MeshFile { mesh: whole, objects, .. }: &MeshFile) -> Vec<Segment> {
    let (objects, groups) = (objects.runs(), whole.groups.runs());
    let begins: BTreeSet<u32> = objects.iter().chain(groups).map(|(first, _)| *first).collect();
    let begins: Vec<usize> = begins.into_iter().map(|first| first as usize).collect();
    let ends = begins.iter().skip(1).copied().chain([whole.count()]);
    let at = |runs: &[(u32, u32)], first: usize| {
        let after = runs.partition_point(|(begin, _)| *begin as usize <= first);
        runs[after - 1].1
    };
    let segment = |(first, end): (&usize, usize)| Segment {
        triangles: *first..end,
        object: at(objects, *first),
        group: at(groups, *first),
    };
    begins.iter().zip(ends).map(segment).collect()
}

fn unknown(name: &str, names: &[String], segments: &[Segment]) -> String {
    let used: BTreeSet<u32> = segments.iter().flat_map(|of| [of.object, of.group]).collect();
    let used: Vec<&str> = used.iter().map(|number| names[*number as usize].as_str()).collect();
    if names.iter().any(|known| known == name) {
        return format!("`{name}`, which has no faces there: choose another one");
    }
    let hint = spelling::hint(name, used.iter().copied());
    let listed: Vec<String> = used.iter().take(MOST_LISTED).map(|name| format!("`{name}`")).collect();
    let more = used.len().saturating_sub(MOST_LISTED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!(
        "`{name}`, and there is no such object (`o`) or group (`g`){hint} (there: {}{more})",
        listed.join(", ")
    )
}

fn nothing_to_divide(by: Division, segments: &[Segment]) -> String {
    let groups: BTreeSet<u32> = segments.iter().map(|of| of.group).collect();
    match by {
        Division::Objects if groups.iter().any(|group| *group > 0) => format!(
            "is \"objects\", and the file has none (`o`): write \"groups\" for its {} groups (`g`)",
            groups.len()
        ),
        _ => String::from(
            "divides a file by its objects (`o`) or groups (`g`), and this one has none: take it out",
        ),
    }
}

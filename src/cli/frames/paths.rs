//! Refuses, before a run begins, files that it would write over one another or over its own inputs.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::target::Target;
use crate::cli::args::Job;
use crate::cli::failure::Failure;
use crate::output::folder_of;
use crate::report::file::{self, Destination};

/// An option that names a report, such as `--stats`, and the report's path.
pub type Report<'a> = (&'static str, &'a Path);

/// Checks that `reports`, the frames of `target`, and the inputs of `job` are different files.
pub fn check(job: &Job, target: Option<&Target>, reports: &[Report<'_>]) -> Result<(), Failure> {
    let inputs: Vec<PathBuf> = job.shot.files.iter().map(|file| place(file)).collect();
    let replaced = inputs.iter().find(|input| target.is_some_and(|target| is_frame(target, input)));
    if let Some(input) = replaced {
        return Err(Failure::Usage(format!(
            "{}: the shot reads this file, and a frame would replace it; choose other names with -o",
            input.display()
        )));
    }
    let mut files: Vec<(&str, PathBuf)> = Vec::new();
    for &(option, path) in reports {
        let Destination::File(file) = Destination::new(path).map_err(Failure::of)? else { continue };
        let file = place(&file);
        let refuse = |why: &str| {
            Err(Failure::Usage(format!("{option} {}: {why}; choose another name", path.display())))
        };
        if target.is_some_and(|target| is_frame(target, &link_place(path)) || is_frame(target, &file)) {
            return refuse("a frame of this run has that name");
        }
        if inputs.contains(&file) {
            return refuse("the shot reads that file, and it would be replaced");
        }
        if let Some((other, _)) = files.iter().find(|(_, other)| *other == file) {
            return refuse(&format!("{other} names the same file"));
        }
        files.push((option, file));
    }
    Ok(())
}

/// Tries the folders of reports that are to be written at the end, before the work.
pub fn prepare(reports: &[Report<'_>]) -> Result<(), Failure> {
    reports.iter().try_for_each(|(_, path)| file::prepare(path).map_err(Failure::of))
}

fn is_frame(target: &Target, place: &Path) -> bool {
    let name = place.file_name().and_then(OsStr::to_str);
    name.is_some_and(|name| target.has_name(name)) && place.parent() == Some(&self::place(target.folder()))
}

/// Resolves a path to one that is the same for each name of a file, existing or not: absolute, and without
/// links.
fn place(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| link_place(path))
}

/// Resolves the folder of a path alone: its last part may be a link.
fn link_place(path: &Path) -> PathBuf {
    let Some(_) = path.parent() else { return path.to_owned() };
    let mut place = place(folder_of(path));
    match path.file_name() {
        Some(name) => place.push(name),
        None => drop(place.pop()), // `..` in a folder that is yet to be made
    }
    place
}

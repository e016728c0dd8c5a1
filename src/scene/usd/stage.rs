//! Opens a USD file, and reads all of it in one go.

use std::any::Any;
use std::collections::BTreeSet;
use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::thread;

use openusd::ar::split_package_relative_path_outer;
use openusd::pcp;
use openusd::usd::Stage;

use super::file::{Content, UsdFile};
use super::resolver::Checked;
use super::value::{Answer, said};
use super::walk;
use crate::digest::Digest;
use crate::input::{self, InputError, Kind};
use crate::scene::SceneError;

/// Stack of the thread that reads, bytes: the library calls itself for each level of what is nested. Taken as it is used.
const STACK_BYTES: usize = 512 << 20;

/// Most defects of a file that are told one by one.
const MOST_DEFECTS: usize = 20;

/// Content of a file, and the layers of which it is composed.
struct ReadStage {
    content: Content,
    layers: Vec<PathBuf>,
}

impl UsdFile {
    /// Reads the file at `path`, with all that it names.
    ///
    /// # Errors A file that cannot be read, or that is damaged.
    pub fn open(path: &Path) -> Result<Self, SceneError> {
        let fault = |message: String| SceneError::new(path, message);
        let unreadable = |error: InputError| fault(format!("the file cannot be read: {error}"));
        input::open(path, Kind::Model).map_err(unreadable)?;
        let ReadStage { content, layers } = read_aside(path).map_err(fault)?;
        let mut files = vec![path.to_path_buf()];
        let known = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        files.extend(layers.into_iter().filter(|layer| *layer != known));
        let digests = files.iter().map(|file| {
            let bytes = input::open(file, Kind::Model).and_then(input::Input::read_all);
            Ok(Digest::new(&bytes.map_err(unreadable)?))
        });
        let digest = Digest::of_all(digests.collect::<Result<Vec<_>, SceneError>>()?);
        Ok(Self { path: path.to_path_buf(), files, digest, content })
    }
}

/// Reads on a thread of its own: with a large stack, and away from the library's panics, of which damaged files cause some.
fn read_aside(path: &Path) -> Answer<ReadStage> {
    let read = || panic::catch_unwind(AssertUnwindSafe(|| read(path)));
    let outcome = thread::scope(|scope| {
        let thread = thread::Builder::new().name(String::from("usd")).stack_size(STACK_BYTES);
        said(thread.spawn_scoped(scope, read)).map(|thread| thread.join())
    })?;
    match outcome {
        Ok(Ok(answer)) => answer,
        Ok(Err(panic)) | Err(panic) => Err(format!(
            "the file is damaged, or more than the library can read ({}): export it again",
            words(&*panic)
        )),
    }
}

/// Words of a panic.
fn words(panic: &dyn Any) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no reason given");
    text.chars().take(200).collect()
}

fn read(path: &Path) -> Answer<ReadStage> {
    let name = path.to_str().ok_or("its path is not UTF-8: rename it")?;
    // a name alone would be looked up in the library's search path
    let name =
        if path.is_absolute() || name.starts_with('.') { String::from(name) } else { format!("./{name}") };
    let opened = said(Stage::builder().resolver(Checked::default()).open(&name));
    let stage = opened.map_err(|why| format!("the USD file cannot be read: {why}"))?;
    let mut content = walk::content(&stage)?;
    for error in stage.composition_errors() {
        tell(&error, &mut content);
    }
    limit(&mut content.defects);
    let layers: BTreeSet<PathBuf> = stage.layer_identifiers().iter().map(|layer| file_of(layer)).collect();
    let layers = layers.into_iter().filter(|layer| layer.is_file()).collect();
    Ok(ReadStage { content, layers })
}

/// File of a layer, which may be in a package.
fn file_of(layer: &str) -> PathBuf {
    PathBuf::from(split_package_relative_path_outer(layer).map_or(layer.to_string(), |(package, _)| package))
}

/// Records what could not be composed.
fn tell(error: &pcp::Error, content: &mut Content) {
    let missing = "what it brings is missing";
    let message = match error {
        pcp::Error::UnresolvedLayer { asset_path, .. } | pcp::Error::MalformedLayer { asset_path, .. }
            if asset_path.ends_with(".mtlx") =>
        {
            content.unused.insert(String::from("MaterialX files are not used"));
            return;
        }
        pcp::Error::UnresolvedLayer { asset_path, site_path, .. } => {
            format!(
                "the layer `{asset_path}`, which {site_path} names, cannot be found: {missing}; copy it to where it is named"
            )
        }
        pcp::Error::MalformedLayer { asset_path, site_path, reason, .. } => {
            format!("the layer `{asset_path}`, which {site_path} names, cannot be read ({reason}): {missing}")
        }
        pcp::Error::UnresolvedSublayer { asset_path, introduced_by, .. } => {
            format!(
                "the layer `{asset_path}`, which `{introduced_by}` names, cannot be found: {missing}; copy it to where it is named"
            )
        }
        pcp::Error::UnresolvedPrimPath { prim_path, target_layer, site_path, .. } => {
            format!("{prim_path}, which {site_path} names, is not in the layer `{target_layer}`: {missing}")
        }
        pcp::Error::ArcCycle(chain) => {
            format!("{} refers to itself: that reference is left out", chain.composing)
        }
        other => other.to_string(),
    };
    content.defects.insert(message.chars().take(500).collect());
}

/// Keeps the first defects, and counts the rest.
fn limit(defects: &mut BTreeSet<String>) {
    let more = defects.len().saturating_sub(MOST_DEFECTS);
    if more > 0 {
        let kept: BTreeSet<String> = std::mem::take(defects).into_iter().take(MOST_DEFECTS).collect();
        *defects = kept;
        defects.insert(format!("{more} more references lead nowhere"));
    }
}

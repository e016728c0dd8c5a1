//! Opens a USD file, and reads all of it in one go.

use std::any::Any;
use std::collections::BTreeSet;
use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use openusd::ar::split_package_relative_path_outer;
use openusd::pcp;
use openusd::usd::Stage;

use super::choice::{StageChoice, ViewChoice};
use super::file::{Content, UsdFile};
use super::resolver::{self, Checked, Record, TooLarge, too_large};
use super::text::Fault;
use super::value::said;
use super::wanted::Wanted;
use super::{variants, walk};
use crate::digest::Digest;
use crate::input::{self, InputError, Kind};
use crate::memory;
use crate::scene::SceneError;

/// Stack of the thread that reads, bytes: the library calls itself for each level of what is nested. Taken as it is used.
const STACK_BYTES: usize = 512 << 20;

/// Most defects of a file that are told one by one.
const MOST_DEFECTS: usize = 20;

/// Time between two looks at the memory that is left, and that in which reading ends once there is too little.
const BETWEEN_LOOKS: Duration = Duration::from_millis(50);
const MOST_LOOKS_AFTER: u32 = 20;

/// Memory that is to be left while a file is read, bytes: less where there is little from the beginning.
const LEAST_LEFT: u64 = 256 << 20;

/// Content of a file, and the layers of which it is composed.
struct ReadStage {
    content: Content,
    choice: StageChoice,
    layers: Vec<PathBuf>,
}

impl UsdFile {
    /// Reads what is chosen of the file at `path`, with all that it names. `view`: of a file that is a shot; its settings count.
    ///
    /// # Errors A file that cannot be read, or that is damaged; a choice of what it does not have.
    pub fn open(path: &Path, choice: &StageChoice, view: Option<&ViewChoice>) -> Result<Self, SceneError> {
        let fault = |message: String| SceneError::new(path, message);
        let unreadable = |error: InputError| fault(format!("the file cannot be read: {error}"));
        input::open(path, Kind::Model).map_err(unreadable)?;
        let wanted = Wanted { choice: choice.clone(), view: view.cloned() };
        let ReadStage { content, choice, layers } =
            read_aside(path, wanted).map_err(|Fault { line, message }| {
                let fault = fault(message);
                if let Some(line) = line { fault.at_line(line) } else { fault }
            })?;
        let mut files = vec![path.to_path_buf()];
        let known = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        files.extend(layers.into_iter().filter(|layer| *layer != known));
        let digests = files.iter().map(|file| {
            let bytes = input::open(file, Kind::Model).and_then(input::Input::read_all);
            Ok(Digest::new(&bytes.map_err(unreadable)?))
        });
        let digest = Digest::of_all(digests.collect::<Result<Vec<_>, SceneError>>()?);
        Ok(Self { path: path.to_path_buf(), files, digest, choice, content })
    }
}

/// Reads on a thread of its own: with a large stack, away from the library's panics, of which damaged files cause some, and watched: few
/// bytes may compose more than fits into memory.
fn read_aside(path: &Path, wanted: Wanted) -> Result<ReadStage, Fault> {
    let whole = |message: String| Fault { line: None, message };
    let record = Arc::new(Record::default());
    let (sender, receiver) = mpsc::channel();
    let (own, path) = (record.clone(), path.to_path_buf());
    let read = move || {
        let outcome = panic::catch_unwind(AssertUnwindSafe(|| read(&path, wanted, &own)));
        // nobody waits any more where memory has run out
        let _ = sender.send(outcome);
    };
    let least = left().saturating_div(4).min(LEAST_LEFT);
    let thread = thread::Builder::new().name(String::from("usd")).stack_size(STACK_BYTES);
    said(thread.spawn(read)).map_err(whole)?;
    let mut looks_after = 0;
    let outcome = loop {
        match receiver.recv_timeout(BETWEEN_LOOKS) {
            Ok(outcome) => break outcome,
            Err(RecvTimeoutError::Disconnected) => {
                return Err(whole(String::from("the thread that reads it has ended: try again")));
            }
            Err(RecvTimeoutError::Timeout) if looks_after == MOST_LOOKS_AFTER => {
                return Err(whole(too_large()));
            }
            Err(RecvTimeoutError::Timeout) if looks_after > 0 || left() < least => {
                record.is_over.store(true, Ordering::Relaxed);
                looks_after += 1;
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
    };
    outcome.unwrap_or_else(|panic| match panic.is::<TooLarge>() {
        true => Err(whole(too_large())),
        false => Err(whole(format!(
            "the file is damaged, or more than the library can read ({}): export it again",
            words(&*panic)
        ))),
    })
}

/// Bytes of memory that are left.
fn left() -> u64 {
    memory::left().iter().map(|(_, bytes)| *bytes).min().unwrap_or(u64::MAX)
}

/// Words of a panic.
fn words(panic: &dyn Any) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no reason given");
    text.chars().take(200).collect()
}

fn read(path: &Path, mut wanted: Wanted, record: &Arc<Record>) -> Result<ReadStage, Fault> {
    let whole = |message: String| Fault { line: None, message };
    let name = path.to_str().ok_or_else(|| whole(String::from("its path is not UTF-8: rename it")))?;
    // a name alone would be looked up in the library's search path
    let name =
        if path.is_absolute() || name.starts_with('.') { String::from(name) } else { format!("./{name}") };
    let opened = said(Stage::builder().resolver(Checked::new(record.clone())).open(&name));
    let stage = opened.map_err(|why| {
        let found = record.fault("").or_else(|| resolver::unread(&name));
        let Fault { line, message } = found.unwrap_or_else(|| whole(why));
        Fault { line, message: format!("the USD file cannot be read: {message}") }
    })?;
    record.forget();
    walk::unload(&stage, &wanted.choice).map_err(whole)?;
    variants::select(&stage, &wanted.choice.variants).map_err(whole)?;
    let mut content = walk::content(&stage, record, &mut wanted).map_err(whole)?;
    for error in stage.composition_errors() {
        tell(&error, record, &mut content);
    }
    if record.has_splines() {
        content
            .unused
            .insert(String::from("splines are not used: what they move is as its other values say"));
    }
    limit(&mut content.defects);
    let layers: BTreeSet<PathBuf> = stage.layer_identifiers().iter().map(|layer| file_of(layer)).collect();
    let layers = layers.into_iter().filter(|layer| layer.is_file()).collect();
    Ok(ReadStage { content, choice: wanted.choice, layers })
}

/// File of a layer, which may be in a package.
fn file_of(layer: &str) -> PathBuf {
    PathBuf::from(split_package_relative_path_outer(layer).map_or(layer.to_string(), |(package, _)| package))
}

/// Records what could not be composed.
fn tell(error: &pcp::Error, record: &Record, content: &mut Content) {
    let missing = "what it brings is missing";
    let message = match error {
        pcp::Error::UnresolvedLayer { asset_path, site_path, .. } => {
            format!(
                "the layer `{asset_path}`, which {site_path} names, cannot be found: {missing}; copy it to where it is named"
            )
        }
        pcp::Error::MalformedLayer { asset_path, site_path, reason, introduced_by, .. } => {
            let beside = file_of(introduced_by).parent().map(|folder| folder.join(asset_path));
            let unread = || resolver::unread(beside?.to_str()?);
            let reason =
                record.fault(asset_path).or_else(unread).map_or(reason.clone(), |fault| fault.to_string());
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
        defects
            .insert(format!("what {more} more of its prims and layers name or hold is nowhere, or damaged"));
    }
}

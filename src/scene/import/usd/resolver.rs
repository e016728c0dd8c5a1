//! Opens the layers that a USD file names: regular files alone, so that nothing waits for ever, each checked before the library reads it,
//! and text in the spellings that it reads.

use std::collections::BTreeMap;
use std::io::{self, Cursor};
use std::panic;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use openusd::ar::{
    Asset, DefaultResolver, ResolvedPath, Resolver, is_package_relative_path,
    split_package_relative_path_outer,
};
use openusd::usd::Stage;
use openusd::usda::parser::Parser;

use super::text::Fault;
use super::{binary, layer_of_mtlx, package, text};
use crate::input::{self, Kind};
use crate::memory::{self, Need, Part};

/// Memory for each byte of a layer: the file, and what is made of it.
const BYTES_A_BYTE: u64 = 4;

/// Most references and the like that are followed for one prim, counted twice each: the time to compose them grows with the square of their
/// number.
const MOST_ARCS: u32 = 1 << 13;

/// What happens while a file is read, for the thread that reads and for the one that waits.
#[derive(Default)]
pub struct Record {
    /// True if reading is to end.
    pub is_over: AtomicBool,
    /// References that were followed for a prim.
    arcs: AtomicU32,
    /// What is wrong with layers.
    faults: Mutex<BTreeMap<PathBuf, Fault>>,
    has_splines: AtomicBool,
    /// Time codes in a second of the first layer, once it was opened; none: it is a binary one.
    rate: OnceLock<Option<f64>>,
    /// Bytes of all layers that were opened.
    bytes: AtomicU64,
    /// The layer that was opened last: the library opens most of them twice.
    last: Mutex<Option<(PathBuf, Arc<Vec<u8>>)>>,
}

/// The library's resolver, which checks files before it opens them.
#[derive(Default)]
pub struct Checked {
    library: DefaultResolver,
    record: Arc<Record>,
}

impl Record {
    /// Begins to count the references of another prim.
    ///
    /// # Errors If reading is to end.
    pub fn next_prim(&self) -> Result<(), String> {
        self.arcs.store(0, Ordering::Relaxed);
        match self.is_over.load(Ordering::Relaxed) {
            true => Err(too_large()),
            false => Ok(()),
        }
    }

    /// What is wrong with the layer whose path ends with these names, if it was found.
    pub fn fault(&self, end: &str) -> Option<Fault> {
        let end = end.trim_start_matches("./").trim_start_matches("../");
        let faults = self.faults.lock().unwrap_or_else(PoisonError::into_inner);
        let found =
            faults.iter().find(|(path, _)| path.to_string_lossy().trim_end_matches(']').ends_with(end));
        found.map(|(_, fault)| fault.clone())
    }

    /// True if a layer has splines, which are left out.
    pub fn has_splines(&self) -> bool {
        self.has_splines.load(Ordering::Relaxed)
    }

    /// Bytes of all layers so far.
    pub fn bytes(&self) -> u64 {
        self.bytes.load(Ordering::Relaxed)
    }

    /// Forgets the layer that was opened last.
    pub fn forget(&self) {
        *self.last.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }

    /// Counts a reference. Leaves the library if there are too many, or if reading is to end.
    fn count(&self) {
        let arcs = self.arcs.fetch_add(1, Ordering::Relaxed);
        if arcs > MOST_ARCS || self.is_over.load(Ordering::Relaxed) {
            panic::resume_unwind(Box::new(TooLarge));
        }
    }
}

/// Leaves the library: what a file composes is too large.
pub struct TooLarge;

/// Words for what composes too much.
pub fn too_large() -> String {
    format!(
        "what it refers to grows beyond the memory, or beyond {} references for one prim: references that refer twice each double it; refer \
         to each layer once, or make instances of it",
        MOST_ARCS / 2
    )
}

impl Checked {
    pub fn new(record: Arc<Record>) -> Self {
        Self { library: DefaultResolver::default(), record }
    }

    /// Bytes of a file or of a part of a package, as they are.
    pub fn bytes(resolved: &str) -> io::Result<Vec<u8>> {
        let outer =
            is_package_relative_path(resolved).then(|| split_package_relative_path_outer(resolved)).flatten();
        if let Some((package, inner)) = outer {
            return package::read(Path::new(&package), &inner);
        }
        let opened = input::open(Path::new(resolved), Kind::Model)?;
        let need = Need::new(Part::new("a USD layer", BYTES_A_BYTE * opened.length, "smaller layers"));
        need.check(&memory::left()).map_err(|error| io::Error::other(error.to_string()))?;
        Ok(opened.read_all()?)
    }

    /// Time codes in a second of the first layer, if it is a text layer.
    fn rate(&self, text: &str) -> Result<Option<f64>, Fault> {
        if let Some(rate) = self.record.rate.get() {
            return Ok(*rate);
        }
        let rate = text::rate(text)?;
        Ok(*self.record.rate.get_or_init(|| Some(rate)))
    }

    /// Bytes of a layer as the library reads them.
    fn layer(&self, resolved: &str) -> io::Result<Vec<u8>> {
        let file = layer_of_mtlx::file_of(resolved);
        let wrong = |fault: Fault| {
            let said = fault.to_string();
            let mut faults = self.record.faults.lock().unwrap_or_else(PoisonError::into_inner);
            faults.insert(PathBuf::from(file.unwrap_or(resolved)), fault);
            io::Error::new(io::ErrorKind::InvalidData, said)
        };
        if let Some(file) = file {
            return layer_of_mtlx::text(file).map(String::into_bytes).map_err(wrong);
        }
        let bytes = Self::bytes(resolved)?;
        if bytes.starts_with(binary::MAGIC) {
            // times of layers below a binary one stay as they are
            self.record.rate.get_or_init(|| None);
            let left = memory::left().iter().map(|(_, bytes)| *bytes).min().unwrap_or(u64::MAX);
            return match binary::check(&bytes, left) {
                Ok(()) => Ok(bytes),
                Err(why) => {
                    let message = format!("the file is damaged ({why}): export it again");
                    Err(wrong(Fault { line: None, message }))
                }
            };
        }
        if !bytes.starts_with(b"#usda") && !resolved.trim_end_matches(']').ends_with(".usda") {
            return Ok(bytes);
        }
        let text = String::from_utf8_lossy(&bytes);
        let rate = self.rate(&text).map_err(wrong)?;
        let rewritten = text::rewrite(&text, rate).map_err(wrong)?;
        self.record.has_splines.fetch_or(rewritten.has_splines, Ordering::Relaxed);
        Ok(rewritten.text.into_bytes())
    }
}

/// What the library does not read in a text layer, with the number of its line.
pub fn unread(resolved: &str) -> Option<Fault> {
    let bytes = Checked::bytes(resolved).ok().filter(|bytes| bytes.starts_with(b"#usda"))?;
    let text = match text::rewrite(&String::from_utf8_lossy(&bytes), None) {
        Ok(rewritten) => rewritten.text,
        Err(fault) => return Some(fault),
    };
    let mut parser = Parser::new(&text);
    let why = parser.parse().err()?;
    let place = parser.last_error_highlight();
    let line = place.as_ref().map(|place| place.line);
    let shown: String =
        place.map_or(String::new(), |place| place.line_text.trim().chars().take(60).collect());
    Some(Fault { line, message: format!("`{shown}` is not read ({})", why.root_cause()) })
}

impl Resolver for Checked {
    fn create_identifier(&self, asset_path: &str, anchor: Option<&ResolvedPath>) -> String {
        self.record.count();
        self.library.create_identifier(asset_path, anchor)
    }

    fn resolve(&self, asset_path: &str) -> Option<ResolvedPath> {
        let resolved = self.library.resolve(asset_path)?;
        Some(match layer_of_mtlx::of_file(&resolved.to_string_lossy()) {
            Some(layer) => ResolvedPath::new(layer),
            None => resolved,
        })
    }

    fn resolve_for_new_asset(&self, asset_path: &str) -> Option<ResolvedPath> {
        self.library.resolve_for_new_asset(asset_path)
    }

    fn open_asset(&self, resolved_path: &ResolvedPath) -> io::Result<Box<dyn Asset>> {
        let path = resolved_path.to_string_lossy();
        let known = PathBuf::from(path.as_ref());
        let mut last = self.record.last.lock().unwrap_or_else(PoisonError::into_inner);
        let bytes = match last.as_ref() {
            Some((own, bytes)) if *own == known => bytes.clone(),
            _ => {
                let bytes = Arc::new(self.layer(&path)?);
                self.record.bytes.fetch_add(bytes.len() as u64, Ordering::Relaxed);
                bytes
            }
        };
        *last = Some((known, bytes.clone()));
        Ok(Box::new(Cursor::new(bytes.to_vec())))
    }
}

/// The file of this name beside a layer of a stage, the root first: the library does not look for all that layers name.
pub fn beside_layers(stage: &Stage, name: &str, is_there: impl Fn(&PathBuf) -> bool) -> Option<PathBuf> {
    let root = stage.root_layer().identifier().to_string();
    let layers = std::iter::once(root).chain(stage.layer_identifiers());
    layers.filter_map(|layer| Some(PathBuf::from(layer).parent()?.join(name))).find(is_there)
}

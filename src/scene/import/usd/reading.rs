//! A file whose materials are being read.

use std::collections::{BTreeMap, BTreeSet};

use super::file::UsdFile;
use crate::scene::import::Import;

/// A file, what its materials add to, and what was left out of these.
pub struct Reading<'a> {
    pub file: &'a UsdFile,
    pub import: &'a mut Import,
    /// Parts of the file that have no effect, in whole sentences.
    pub unused: Vec<&'static str>,
    /// What was left out of networks of MaterialX, with the names of the materials.
    pub left_out: BTreeMap<String, BTreeSet<String>>,
}

impl<'a> Reading<'a> {
    pub fn new(file: &'a UsdFile, import: &'a mut Import) -> Self {
        Self { file, import, unused: Vec::new(), left_out: BTreeMap::new() }
    }
}

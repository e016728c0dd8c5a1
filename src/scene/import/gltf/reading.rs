//! A file whose materials are being read.

use super::document::Document;
use crate::scene::import::Import;

/// A file, and what its materials add to.
pub struct Reading<'a> {
    pub document: &'a Document,
    pub import: &'a mut Import,
}

//! Opens the layers that a USD file names, as all input is opened: regular files alone, so that nothing waits for ever.

use std::io;
use std::path::Path;

use openusd::ar::{
    Asset, DefaultResolver, ResolvedPath, Resolver, is_package_relative_path,
    split_package_relative_path_outer,
};

use crate::input::{self, Kind};
use crate::memory::{self, Need, Part};

/// Memory for each byte of a layer: the file, and what is made of it.
const BYTES_A_BYTE: u64 = 4;

/// The library's resolver, which checks files before it opens them.
#[derive(Default)]
pub struct Checked(DefaultResolver);

impl Resolver for Checked {
    fn create_identifier(&self, asset_path: &str, anchor: Option<&ResolvedPath>) -> String {
        self.0.create_identifier(asset_path, anchor)
    }

    fn resolve(&self, asset_path: &str) -> Option<ResolvedPath> {
        self.0.resolve(asset_path)
    }

    fn resolve_for_new_asset(&self, asset_path: &str) -> Option<ResolvedPath> {
        self.0.resolve_for_new_asset(asset_path)
    }

    fn open_asset(&self, resolved_path: &ResolvedPath) -> io::Result<Box<dyn Asset>> {
        let path = resolved_path.to_string_lossy();
        let outer =
            is_package_relative_path(&path).then(|| split_package_relative_path_outer(&path)).flatten();
        let file = outer.map_or(path.to_string(), |(package, _)| package);
        let opened = input::open(Path::new(&file), Kind::Model)?;
        let need = Need::new(Part::new("a USD layer", BYTES_A_BYTE * opened.length, "smaller layers"));
        need.check(&memory::left()).map_err(|error| io::Error::other(error.to_string()))?;
        self.0.open_asset(resolved_path)
    }
}

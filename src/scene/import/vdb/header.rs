//! What stands before the grids of a file, and before the values of a grid.
//!
//! Sources of the format: `openvdb/io/Archive.cc`, `GridDescriptor.cc` and `math/Maps.h` of OpenVDB.

use glam::{DAffine3, DVec3};

use super::packed::Packing;
use crate::scene::import::bytes::Bytes;

/// First bytes of a file.
const MARK: [u8; 8] = *b" BDV\0\0\0\0";

/// The least version whose grids say for themselves how they are packed: files since 2013 have it.
const LEAST_VERSION: u32 = 222;

/// Bytes of a file's own number.
const UUID: usize = 36;

/// Where a grid is in a file, and what it holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Described {
    /// Its name, of which there may be several.
    pub name: String,
    /// The same, but for a number of those that have one name.
    unique: String,
    /// Type of its tree.
    pub kind: String,
    pub are_halves: bool,
    /// The unique name of the grid whose tree it has; empty, if it has its own.
    parent: String,
    /// Where it begins.
    begins: u64,
}

/// What stands before a grid's values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Before {
    pub packing: Packing,
    /// From the lattice to object space.
    pub map: DAffine3,
}

/// Reads what a file says of its grids.
pub fn grids(bytes: &mut Bytes<'_>) -> Result<Vec<Described>, String> {
    if bytes.array().ok() != Some(MARK) {
        return Err(String::from("it is no OpenVDB file: check its name, or save it again"));
    }
    let version = bytes.u32()?;
    if version < LEAST_VERSION {
        return Err(format!(
            "it has version {version} of the format, and {LEAST_VERSION} is the least that is read: open it in a newer program and save it again"
        ));
    }
    // versions of the library
    bytes.take(8)?;
    if bytes.byte()? == 0 {
        return Err(String::from(
            "it was written as a stream, without a list of its grids: save it as a file",
        ));
    }
    bytes.take(UUID)?;
    skip_metadata(bytes)?;
    let count = bytes.count()?;
    (0..count).map(|_| described(bytes)).collect()
}

fn described(bytes: &mut Bytes<'_>) -> Result<Described, String> {
    let (unique, kind, parent) = (bytes.text()?, bytes.text()?, bytes.text()?);
    let begins = bytes.i64()?;
    let begins = u64::try_from(begins).map_err(|_| format!("the place {begins} of a grid is none"))?;
    // where its values begin, and where it ends: there the next one is described
    bytes.take(8)?;
    let ends = bytes.i64()?;
    bytes.go_to(u64::try_from(ends).map_err(|_| format!("the place {ends} of a grid is none"))?)?;
    let name = unique.split('\x1e').next().unwrap_or_default().to_string();
    let (kind, are_halves) = match kind.strip_suffix("_HalfFloat") {
        Some(kind) => (kind.to_string(), true),
        None => (kind, false),
    };
    Ok(Described { name, unique, kind, are_halves, parent, begins })
}

impl Described {
    /// Goes to the values of a grid.
    pub fn enter(&self, all: &[Self], bytes: &mut Bytes<'_>) -> Result<Before, String> {
        bytes.go_to(self.begins)?;
        let own = before(bytes)?;
        if self.parent.is_empty() {
            return Ok(own);
        }
        // the tree of another grid, in a place of its own
        let parent = all.iter().find(|other| other.unique == self.parent && other.parent.is_empty());
        let parent =
            parent.ok_or_else(|| format!("the grid `{}` whose tree it has is not there", self.parent))?;
        bytes.go_to(parent.begins)?;
        let of_parent = before(bytes)?;
        Ok(Before { packing: of_parent.packing, ..own })
    }
}

fn before(bytes: &mut Bytes<'_>) -> Result<Before, String> {
    let packing = Packing(bytes.u32()?);
    if !packing.is_known() {
        return Err(format!(
            "it is packed in a way that is not known ({:#x}): save it with Zip or Blosc",
            packing.0
        ));
    }
    skip_metadata(bytes)?;
    Ok(Before { packing, map: map(bytes)? })
}

/// Passes entries of a name, a type and bytes.
fn skip_metadata(bytes: &mut Bytes<'_>) -> Result<(), String> {
    for _ in 0..bytes.count()? {
        bytes.text()?;
        bytes.text()?;
        let size = bytes.count()?;
        bytes.take(size)?;
    }
    Ok(())
}

/// Reads the map of a lattice to object space.
fn map(bytes: &mut Bytes<'_>) -> Result<DAffine3, String> {
    /// Vectors that follow from the factors: of voxels, of the inverse, and of derivatives.
    const DERIVED: usize = 4;
    let kind = bytes.text()?;
    let three = |bytes: &mut Bytes<'_>| Ok::<_, String>(DVec3::new(bytes.f64()?, bytes.f64()?, bytes.f64()?));
    let map = match kind.as_str() {
        "ScaleMap" | "UniformScaleMap" => {
            let scale = three(bytes)?;
            bytes.take(24 * DERIVED)?;
            DAffine3::from_scale(scale)
        }
        "ScaleTranslateMap" | "UniformScaleTranslateMap" => {
            let (translation, scale) = (three(bytes)?, three(bytes)?);
            bytes.take(24 * DERIVED)?;
            DAffine3::from_translation(translation) * DAffine3::from_scale(scale)
        }
        "TranslationMap" => DAffine3::from_translation(three(bytes)?),
        "AffineMap" | "UnitaryMap" => {
            // rows, for vectors that are rows
            let mut columns = [DVec3::ZERO; 4];
            for column in &mut columns {
                *column = three(bytes)?;
                bytes.f64()?;
            }
            let [x, y, z, origin] = columns;
            DAffine3::from_cols(x, y, z, origin)
        }
        other => {
            return Err(format!("its grid has a `{other}`, which is not read: resample it to even voxels"));
        }
    };
    let volume = map.matrix3.determinant();
    if !map.is_finite() || volume == 0.0 || !map.inverse().is_finite() {
        return Err(String::from("the map of a grid leaves no space: save it again"));
    }
    Ok(map)
}

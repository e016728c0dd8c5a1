//! Opens glTF files: the JSON, and the bytes of its buffers.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use memchr::memchr_iter;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::json::{Asset, Extensions, Json, View};
use super::stated_gloss;
use super::uri::Uri;
use crate::digest::Digest;
use crate::input::{self, InputError, Kind};
use crate::memory::{self, Need, Part};
use crate::scene::SceneError;
use crate::scene::paths::find_beside;

/// Extensions that files may require.
const KNOWN: [&str; 19] = [
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp_json_ld",
];

/// Largest coordinate, about the same as in OBJ files: its square is still a finite single float.
pub const LARGEST_COORDINATE: f64 = 1e18;

/// Memory for an object in the JSON, bytes: a node, the largest, with its place and what is computed of it.
const OBJECT_BYTES: u64 = 1024;

/// First bytes of a text that some programs mark as UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// Header of a GLB file, and of each chunk in it, bytes.
const GLB_HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// A glTF file that was read, with its buffers.
pub struct Document {
    /// Path of the file.
    pub path: PathBuf,
    /// Its JSON.
    pub json: Json,
    /// Bytes of each buffer.
    buffers: Vec<Vec<u8>>,
    /// The file, and those of its buffers.
    pub files: Vec<PathBuf>,
    /// Digest of the files' contents.
    pub digest: Digest,
    /// Parts of the file that have no effect here, in whole sentences, each once.
    unused: Mutex<BTreeSet<String>>,
}

impl Document {
    /// Reads the file at `path`, text or binary.
    ///
    /// # Errors
    /// A file that cannot be read, is no glTF file, or needs what is not supported.
    pub fn open(path: &Path) -> Result<Self, SceneError> {
        let bytes = read(path, path)?;
        let mut digests = vec![Digest::new(&bytes)];
        let (text, blob) = split(bytes).map_err(|what| SceneError::new(path, what))?;
        check_memory(path, &text)?;
        let mut json: Json = serde_json::from_slice(&text).map_err(|error| {
            // files of another version are made otherwise: the version is what is wrong with them
            let other = serde_json::from_slice(&text).ok().and_then(|Versioned { asset }| {
                // version 1 may be a number
                let version = match asset.version {
                    serde_json::Value::String(text) => text,
                    other => other.to_string(),
                };
                check_version(path, &Asset { version, ..Asset::default() }).err()
            });
            let message = format!(
                "the JSON of this glTF file cannot be read ({error}): it is damaged; export it again"
            );
            other.unwrap_or_else(|| SceneError::new(path, message))
        })?;
        drop(text);
        check_version(path, &json.asset)?;
        check_extensions(path, &json)?;
        stated_gloss::state_base_colors(&mut json).map_err(|what| SceneError::new(path, what))?;
        let mut files = vec![path.to_path_buf()];
        let buffers = buffers(path, &json, blob, &mut files, &mut digests)?;
        let digest = Digest::of_all(digests);
        let unused = Mutex::default();
        let document = Self { path: path.to_path_buf(), json, buffers, files, digest, unused };
        document.note_unknown_extensions();
        Ok(document)
    }

    /// Creates an error about the file.
    pub fn fault(&self, message: impl Into<String>) -> SceneError {
        SceneError::new(&self.path, message)
    }

    /// Looks up an entry of a list of the file, which has `what` as entries.
    pub fn get<'a, T>(&self, list: &'a [T], index: usize, what: &str) -> Result<&'a T, SceneError> {
        list.get(index).ok_or_else(|| {
            let count = list.len();
            self.fault(format!(
                "it names {what} {index}, and there are {count} of them: export the file again"
            ))
        })
    }

    /// Bytes of a buffer view.
    pub fn view(&self, index: usize) -> Result<(&View, &[u8]), SceneError> {
        let view = self.get(&self.json.buffer_views, index, "bufferView")?;
        if view.extensions.contains_key("EXT_meshopt_compression") {
            return Err(self.fault(packed("EXT_meshopt_compression")));
        }
        let buffer = self.get(&self.buffers, view.buffer, "buffer")?;
        let end = view.byte_offset.checked_add(view.byte_length);
        let bytes = end.and_then(|end| buffer.get(view.byte_offset..end));
        let bytes = bytes.ok_or_else(|| {
            let (length, number) = (buffer.len(), view.buffer);
            self.fault(format!(
                "bufferView {index} ends behind buffer {number}, which has {length} bytes: the file is damaged; export it again"
            ))
        })?;
        Ok((view, bytes))
    }

    /// Records that a part of the file has no effect. Each sentence is told once.
    pub fn leave_out(&self, message: impl Into<String>) {
        self.unused.lock().unwrap_or_else(|broken| broken.into_inner()).insert(message.into());
    }

    /// Takes what was recorded.
    pub fn take_unused(&self) -> BTreeSet<String> {
        std::mem::take(&mut *self.unused.lock().unwrap_or_else(|broken| broken.into_inner()))
    }

    /// File that a URI of the file means, if there is one, and its name as written.
    pub fn beside(&self, name: &str) -> (PathBuf, Option<PathBuf>) {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        (folder.join(name), find_beside(folder, name))
    }

    fn note_unknown_extensions(&self) {
        for name in self.json.extensions_used.iter().filter(|name| !KNOWN.contains(&name.as_str())) {
            let name: String = name.chars().take(80).collect();
            self.leave_out(format!("the extension `{name}` is not used"));
        }
    }
}

/// Message about an extension that packs geometry.
pub fn packed(extension: &str) -> String {
    format!(
        "its geometry is packed with `{extension}`, which cannot be unpacked here: export without compression, or unpack it with \
         gltf-transform (`gltf-transform copy packed.glb plain.glb`)"
    )
}

/// Checks that there is memory for what is made of JSON.
fn check_memory(path: &Path, text: &[u8]) -> Result<(), SceneError> {
    let objects = memchr_iter(b'{', text).count() as u64;
    let need = Need::new(Part::new("the JSON of the glTF file", objects * OBJECT_BYTES, "a smaller file"));
    need.check(&memory::left()).map_err(|error| SceneError::new(path, error.to_string()))
}

fn read(path: &Path, asking: &Path) -> Result<Vec<u8>, SceneError> {
    let unreadable = |error: InputError| {
        let file = if path == asking { String::from("the file") } else { format!("`{}`", path.display()) };
        SceneError::new(asking, format!("{file} cannot be read: {error}"))
    };
    let input = input::open(path, Kind::Model).map_err(unreadable)?;
    // as read, and what is made of it
    let need = Need::new(Part::new("the glTF file", 2 * input.length, "a smaller file"));
    need.check(&memory::left()).map_err(|error| SceneError::new(asking, error.to_string()))?;
    input.read_all().map_err(unreadable)
}

/// Splits a file into its JSON and its binary chunk. The error says what is wrong.
fn split(bytes: Vec<u8>) -> Result<(Vec<u8>, Option<Vec<u8>>), String> {
    if !bytes.starts_with(b"glTF") {
        let text = bytes.strip_prefix(BYTE_ORDER_MARK).map(<[u8]>::to_vec);
        return Ok((text.unwrap_or(bytes), None));
    }
    let number = |at: usize| {
        let four: Option<[u8; 4]> = bytes.get(at..at + 4).and_then(|four| four.try_into().ok());
        four.map(u32::from_le_bytes)
    };
    let cut_off = || String::from("the GLB file is cut off: copy or export it again");
    match number(4) {
        Some(2) => {}
        Some(version) => return Err(format!("it is a GLB file of version {version}: export it as glTF 2.0")),
        None => return Err(cut_off()),
    }
    let (mut json, mut blob) = (None, None);
    let mut at = GLB_HEADER;
    // the length in the header counts for nothing: the chunks say where they end
    while at + CHUNK_HEADER <= bytes.len() && (json.is_none() || blob.is_none()) {
        let length = number(at).map(|length| length as usize).ok_or_else(cut_off)?;
        let begin = at + CHUNK_HEADER;
        let chunk = begin.checked_add(length).and_then(|end| bytes.get(begin..end)).ok_or_else(cut_off)?;
        match &bytes[at + 4..begin] {
            b"JSON" if json.is_none() => json = Some(chunk.to_vec()),
            b"BIN\0" if blob.is_none() => blob = Some(chunk.to_vec()),
            _ => {}
        }
        at = begin + length.next_multiple_of(4);
    }
    let json = json.ok_or("the GLB file has no JSON in it: export it again")?;
    Ok((json, blob))
}

/// What files of all versions state.
#[derive(Debug, Deserialize)]
struct Versioned {
    asset: VersionedAsset,
}

#[derive(Debug, Deserialize)]
struct VersionedAsset {
    version: serde_json::Value,
}

fn check_version(path: &Path, asset: &Asset) -> Result<(), SceneError> {
    let needed = asset.min_version.as_ref().unwrap_or(&asset.version);
    if needed.starts_with("2.") || needed == "2" {
        return Ok(());
    }
    let mut message = String::from("it is no glTF file of version 2");
    if !needed.is_empty() {
        let _ = write!(message, " but of version {}", needed.chars().take(20).collect::<String>());
    }
    Err(SceneError::new(path, message + ": export it as glTF 2.0"))
}

fn check_extensions(path: &Path, json: &Json) -> Result<(), SceneError> {
    let unknown = json.extensions_required.iter().find(|name| !KNOWN.contains(&name.as_str()));
    unknown.map_or(Ok(()), |name| {
        let message = match name.as_str() {
            "KHR_draco_mesh_compression" | "EXT_meshopt_compression" => packed(name),
            _ => {
                let name: String = name.chars().take(80).collect();
                format!("it requires the extension `{name}`, which is not supported: export it without")
            }
        };
        Err(SceneError::new(path, message))
    })
}

/// Reads all buffers; adds their files, and digests of these.
fn buffers(
    path: &Path,
    json: &Json,
    mut blob: Option<Vec<u8>>,
    files: &mut Vec<PathBuf>,
    digests: &mut Vec<Digest>,
) -> Result<Vec<Vec<u8>>, SceneError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut all = Vec::with_capacity(json.buffers.len());
    for (number, buffer) in json.buffers.iter().enumerate() {
        let fault = |what: String| SceneError::new(path, format!("buffer {number} {what}"));
        let bytes = match buffer.uri.as_deref().map(Uri::read).transpose().map_err(fault)? {
            Some(Uri::Data(bytes)) => bytes,
            Some(Uri::File(name)) => {
                let found = find_beside(folder, &name).ok_or_else(|| {
                    fault(format!(
                        "is the file `{name}`, which cannot be found: copy it beside the glTF file"
                    ))
                })?;
                let bytes = read(&found, path)?;
                digests.push(Digest::new(&bytes));
                files.push(found);
                bytes
            }
            None => blob.take().filter(|_| number == 0).ok_or_else(|| {
                fault(String::from(
                    "has no bytes: the file is damaged, or it must end in .glb; export it again",
                ))
            })?,
        };
        if bytes.len() < buffer.byte_length {
            let (length, wanted) = (bytes.len(), buffer.byte_length);
            return Err(fault(format!(
                "has {length} bytes, and should have {wanted}: copy or export it again"
            )));
        }
        all.push(bytes);
    }
    Ok(all)
}

/// Reads an extension, if it is there.
pub fn extension<T: DeserializeOwned>(
    document: &Document,
    all: &Extensions,
    name: &str,
) -> Result<Option<T>, SceneError> {
    let read = |value: &serde_json::Value| {
        let fault = |error| {
            document.fault(format!(
                "the extension `{name}` makes no sense ({error}): it is damaged; export the file again"
            ))
        };
        T::deserialize(value).map_err(fault)
    };
    all.get(name).map(read).transpose()
}

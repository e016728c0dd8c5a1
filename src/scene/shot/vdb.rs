//! Volumes of a shot file.

use std::path::PathBuf;
use std::sync::Arc;

use super::quadric::material_named;
use super::shapes::numbered_files;
use crate::animation::{TransformTrack, Visibility};
use crate::scene::import::meshes::shape_files::Numbered;
use crate::scene::import::{Import, vdb};
use crate::scene::keys::toml_text::{At, TomlText};
use crate::scene::keys::values::file_of;
use crate::scene::keys::vdb::VdbTable;
use crate::scene::{Mesh, Model, SceneError};

/// Makes the models of the files that `table` names: one, or one for each frame. `name`: of the model, if it has one.
///
/// # Errors With line and column: values that make no sense, or a material that is not there. With its file: a volume that cannot be read.
pub fn of_table(
    text: TomlText<'_>,
    (table, name): (&At<VdbTable>, Option<&str>),
    track: &TransformTrack,
    import: &mut Import,
) -> Result<Vec<Model>, SceneError> {
    let keys = table.get_ref();
    let material = material_named(text, table.span(), Some(&keys.material), import)?;
    let grids = keys.grids.as_ref().map(|grids| grids.get_ref().as_slice());
    let mut mesh = |path: &PathBuf| -> Result<Arc<Mesh>, SceneError> {
        let volume = vdb::read(import, path, grids)?;
        let mesh = vdb::mesh_of(import, volume, material);
        mesh.map(Arc::new).map_err(|what| SceneError::new(path, what))
    };
    let model = |(path, mesh): (PathBuf, Arc<Mesh>), visible: Visibility| {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Model {
            name: name.map_or(stem, String::from),
            path,
            mesh,
            track: TransformTrack { visible: track.visible.and(&visible), ..track.clone() },
            to_world: None,
            random: 0.0,
            reflection_map: None,
            ray_visibility: Default::default(),
            linked: Default::default(),
        }
    };
    if !keys.file.get_ref().contains('#') {
        if let Some(first) = &keys.first {
            return Err(text.bad("first", first, "goes with a number in `file`: take it out"));
        }
        let path = file_of(text, "file", &keys.file)?;
        let mesh = mesh(&path)?;
        return Ok(vec![model((path, mesh), Visibility::ALWAYS)]);
    }
    let is_frame = |first: f64| first.abs() <= f64::from(i32::MAX);
    let first = keys.first.as_ref().map(|first| text.number("first", first, "a frame's number", is_frame));
    let first = first.transpose()?;
    let files = numbered_files(text, ("file", "smoke.####.vdb"), &keys.file)?;
    let begins = files.first().map_or(0, |file| file.number);
    let of_file = |Numbered { number, path }: Numbered| {
        let frame = first.unwrap_or(begins as f64) + (number - begins) as f64;
        // while a shutter is open about a frame, its file counts
        let visible = Visibility::through(false, vec![(frame - 0.5, true), (frame + 0.5, false)]);
        let visible =
            visible.ok_or_else(|| text.fault(keys.file.span(), "the numbers of frames are too large"))?;
        let mesh = mesh(&path)?;
        Ok(model((path, mesh), visible))
    };
    files.into_iter().map(of_file).collect()
}

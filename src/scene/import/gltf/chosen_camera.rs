//! The camera of a shot file that is one of a glTF file.

use std::collections::BTreeSet;
use std::path::Path;

use super::animation::Clip;
use super::bake;
use super::cameras;
use super::nodes::Tree;
use super::parts::{GltfFiles, known_as};
use crate::digest::Digest;
use crate::scene::SceneError;
use crate::scene::import::Import;
use crate::scene::keys::camera::CameraTable;

/// Choice of a camera of a glTF file, and of its motion.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CameraChoice<'a> {
    /// Name of the camera; none: the first one.
    pub camera: Option<&'a str>,
    /// Name of the animation that moves it; none: as for models.
    pub animation: Option<&'a str>,
    /// Frames in a second.
    pub rate: f64,
}

impl GltfFiles {
    /// The table of a camera of the glTF file at `path`. The inner error, the end of a sentence about the choice, says that there is
    /// no such camera.
    ///
    /// # Errors A file that cannot be read or is damaged, an animation that is not there, or a lens that makes no sense.
    pub fn camera(
        &mut self,
        import: &mut Import,
        path: &Path,
        choice: CameraChoice<'_>,
    ) -> Result<Result<CameraTable, String>, SceneError> {
        let document = self.document(&mut import.inputs, path, &known_as(path))?;
        let tree = Tree::new(&document)?;
        let (node, camera) = match cameras::chosen(&document, &tree, choice.camera) {
            Ok(chosen) => chosen,
            Err(what) => return Ok(Err(what)),
        };
        let clip = Clip::read(&document, choice.animation, choice.rate)?;
        if !clip.channels.is_empty() {
            import.inputs.depend_on(Digest::new(&choice.rate.to_le_bytes()));
        }
        let camera = document.get(&document.json.cameras, camera, "camera")?;
        let tracks = bake::tracks(&document, &tree, &clip, &BTreeSet::from([node]))?;
        let track = tracks.get(&node).ok_or_else(|| {
            let name = cameras::name(&document, node);
            document.fault(format!(
                "its camera `{name}` is scaled to nothing, and looks nowhere: export it again"
            ))
        })?;
        let table = cameras::table(&document, camera, track)?;
        for message in document.take_unused() {
            import.findings.note(document.fault(message));
        }
        Ok(Ok(table))
    }
}

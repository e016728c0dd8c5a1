//! Surfaces of networks of MaterialX: those of prims go the way of MaterialX files.

use std::collections::HashMap;

use super::file::{self, Network, Picture};
use super::reading::Reading;
use crate::scene::SceneError;
use crate::scene::import::mtlx::{self, Document, PictureAsked};
use crate::scene::surface::Surface;

/// What is told of a network that makes no sense.
const NOT_USED: &str = "its network of MaterialX is not used";

impl Reading<'_> {
    /// The surface of a material's network. `None` if it has none, or one that makes no sense, which is told.
    ///
    /// # Errors Those of pictures; in a strict load also networks that make no sense.
    pub(super) fn network(&mut self, surface: &file::Surface) -> Result<Option<Surface>, SceneError> {
        let Some(network) = &surface.network else { return Ok(None) };
        let name = &surface.name;
        // what makes no sense is found before pictures are read, whose errors are none of the network's
        let mut no_pictures = |_: &PictureAsked| Ok(None);
        let makes_sense = match &**network {
            Network::Prims { document, .. } => {
                mtlx::surface(document, name, &mut no_pictures).map(|_| ()).map_err(|error| error.message)
            }
            Network::File { path, name } => {
                let document = self.import.mtlx_document(path);
                let made = document.and_then(|document| mtlx::surface(&document, name, &mut no_pictures));
                made.map(|_| ()).map_err(|error| error.to_string())
            }
        };
        if let Err(why) = makes_sense {
            let shown = if surface.is_network_alone { "it is grey" } else { "its UsdPreviewSurface counts" };
            let message = format!("material `{name}`: {NOT_USED} ({why}): {shown}");
            self.import.findings.stand_in(self.file.fault(message))?;
            return Ok(None);
        }
        match &**network {
            Network::File { path, name } => self.import.mtlx_surface(path, name).map(Some),
            Network::Prims { document, pictures } => self.of_prims(name, document, pictures).map(Some),
        }
    }

    /// The surface of a network of prims.
    fn of_prims(
        &mut self,
        name: &str,
        document: &Document,
        pictures: &HashMap<String, Picture>,
    ) -> Result<Surface, SceneError> {
        let (surface, told) = mtlx::surface(document, name, &mut |asked| {
            let Some(picture) = pictures.get(&asked.file) else { return Ok(None) };
            let of_tiles = picture.tiles.as_ref().map(|tiles| tiles.mapping(asked.mapping));
            let picture = Picture { mapping: of_tiles.unwrap_or(asked.mapping), ..picture.clone() };
            let index = self.place(&picture, asked.used)?;
            Ok(Some(index).filter(|index| asked.has_stand_in || !self.import.pictures.is_stand_in(*index)))
        })?;
        for (_, said) in told {
            self.left_out.entry(said).or_default().insert(name.to_string());
        }
        Ok(surface)
    }
}

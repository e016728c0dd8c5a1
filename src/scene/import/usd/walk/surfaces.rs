//! Surfaces of meshes: of materials that are bound, or of the colour that a prim states.

use openusd::sdf::Path;
use openusd::usd::Prim;

use super::{Walk, said_type};
use crate::scene::import::usd::file::Surface;
use crate::scene::import::usd::geometry::FaceSurfaces;
use crate::scene::import::usd::shader::{self, BoundSurface, ReadSurface};
use crate::scene::import::usd::value::{Answer, said, value, whole_numbers, word};

impl Walk<'_> {
    /// Surface of all faces of a mesh that no subset has.
    pub fn surface_of_mesh(&mut self, prim: &Prim) -> Answer<FaceSurfaces> {
        let mut surfaces = FaceSurfaces::default();
        let bound = self.surface(prim.path())?;
        if bound.is_none() {
            let color = self.shaders.display_color(prim)?;
            surfaces.is_tinted = color.as_ref().is_some_and(|color| color.is_tinted);
            let color = color.or_else(|| self.units.is_of_blender.then(shader::plain_of_blender));
            surfaces.of_mesh = color.map(|color| self.number_of_surface(color));
        }
        if let Some(bound) = bound {
            let (surface, is_tinted) = self.colored(prim, &bound)?;
            (surfaces.of_mesh, surfaces.is_tinted) = (Some(surface), is_tinted);
            surfaces.uvs.insert(surface, bound.uvs);
        }
        Ok(surfaces)
    }

    /// Subsets of a mesh's faces that have materials, and the time code at which they are read.
    pub fn subsets(&self, prim: &Prim) -> Answer<Vec<(Prim, f64)>> {
        let code = self.content.clock.code(self.content.clock.first());
        let mut subsets = Vec::new();
        for child in said(prim.children())? {
            let is_subset = said(child.type_name())?.is_some_and(|kind| kind.as_str() == "GeomSubset");
            if is_subset
                && matches!(word(&child, "familyName", code)?.as_deref(), Some("materialBind") | None)
            {
                subsets.push((child, code));
            }
        }
        Ok(subsets)
    }

    pub fn surfaces(&mut self, prim: &Prim) -> Answer<FaceSurfaces> {
        let mut surfaces = self.surface_of_mesh(prim)?;
        for (child, code) in self.subsets(prim)? {
            let Some(bound) = self.surface(child.path())? else { continue };
            let (surface, is_tinted) = self.colored(prim, &bound)?;
            surfaces.is_tinted |= is_tinted;
            let faces = value(&child, "indices", code)?.as_ref().and_then(whole_numbers).unwrap_or_default();
            let faces = faces.into_iter().filter_map(|face| u32::try_from(face).ok());
            surfaces.of_face.extend(faces.map(|face| (face, Some(surface))));
            surfaces.uvs.insert(surface, bound.uvs);
        }
        Ok(surfaces)
    }

    /// The surface that is bound at a path.
    pub fn surface(&mut self, path: &Path) -> Answer<Option<BoundSurface>> {
        let Some(material) = self.bindings.material(self.stage, path)? else { return Ok(None) };
        if let Some(known) = self.of_materials.get(material.as_str()) {
            return Ok(known.clone());
        }
        let read = match self.shaders.material(&material) {
            Ok(read) => read,
            Err(why) => {
                let message = format!(
                    "the material {material} cannot be read ({why}): what it is bound to is drawn in its displayColor, or grey"
                );
                self.content.defects.insert(message);
                self.of_materials.insert(material.to_string(), None);
                return Ok(None);
            }
        };
        let number = match read {
            Some(ReadSurface { surface, uvs, takes_display_color }) => {
                self.content.surfaces.push(surface);
                Some(BoundSurface { number: self.content.surfaces.len() - 1, uvs, takes_display_color })
            }
            None => {
                let message = if said_type(self.stage, &material)?.is_some() {
                    format!(
                        "the material {material} has neither a UsdPreviewSurface nor a surface of MaterialX that is known: what it is bound to is drawn in its displayColor, or grey"
                    )
                } else {
                    format!(
                        "the material {material} is nowhere: what it is bound to is drawn in its displayColor, or grey"
                    )
                };
                self.content.defects.insert(message);
                None
            }
        };
        self.of_materials.insert(material.to_string(), number.clone());
        Ok(number)
    }

    /// Number of a surface as it is on a prim, which has a colour of its own where the surface takes it; and whether colours of vertices tint it.
    pub fn colored(&mut self, prim: &Prim, bound: &BoundSurface) -> Answer<(usize, bool)> {
        let color = match bound.takes_display_color {
            true => self.shaders.display_color(prim)?,
            false => None,
        };
        let Some(Surface { diffuse, is_tinted, .. }) = color else { return Ok((bound.number, false)) };
        let surface = Surface { diffuse, is_tinted, ..self.content.surfaces[bound.number].clone() };
        Ok((self.number_of_surface(surface), is_tinted))
    }

    fn number_of_surface(&mut self, surface: Surface) -> usize {
        let surfaces = &mut self.content.surfaces;
        surfaces.iter().position(|known| *known == surface).unwrap_or_else(|| {
            surfaces.push(surface);
            surfaces.len() - 1
        })
    }
}

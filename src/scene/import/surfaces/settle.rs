//! Settles surfaces: what readers and tables say of one becomes the material that the renderer has, with its pictures.

use super::varying::Settled;
use crate::graph::nodes::picture::Shown;
use crate::scene::cutout::{ALL_BUT_OPAQUE, Cutout, LEAST_OPACITY};
use crate::scene::import::Import;
use crate::scene::material::{Computes, LEAST_ALPHA};
use crate::scene::surface::{Alpha, PlaceAlpha, Surface};

impl Import {
    /// Settles a surface whose pictures were placed.
    pub(in crate::scene) fn settle(&self, mut surface: Surface) -> Settled {
        self.fold(&mut surface);
        let (alpha, normals, entry_roughness) =
            (surface.alpha, surface.normals, surface.beyond.entry_roughness);
        let mut settled = surface.lowered();
        if let Some(glass) = &mut settled.material.uneven_glass {
            glass.mean = settled.graphs.mean(Computes::Metalness, &self.pictures.textures).clamp(0.0, 1.0);
        }
        if let (Some(scattering), None) = (&mut settled.material.scattering, entry_roughness) {
            // light goes in by one roughness
            let mean = settled.graphs.mean(Computes::Roughness, &self.pictures.textures).clamp(0.0, 1.0);
            scattering.entry.alpha = (scattering.entry.alpha * mean * mean).max(LEAST_ALPHA);
        }
        settled.material.normal_map = normals.and_then(|(map, slope)| self.pictures.normal_map(map, slope));
        settled.material.cutout = match alpha {
            Some(alpha) => self.cutout(alpha, &mut settled),
            None => cutout_of_graph(&settled),
        };
        settled
    }

    /// The parts of a material that are there by this alpha.
    fn cutout(
        &self,
        PlaceAlpha { map, by_vertices, meaning }: PlaceAlpha,
        Settled { material, graphs }: &mut Settled,
    ) -> Option<Cutout> {
        let least = match meaning {
            Alpha::Cut(least) if by_vertices => {
                return Some(Cutout { by_vertices, map, ..Cutout::below(least) });
            }
            Alpha::Blend if material.can_blend() => {
                let map = map.filter(|map| self.pictures.falls_below(*map, ALL_BUT_OPAQUE))?;
                graphs.show(Computes::Opacity, map, Shown::Alpha);
                return Some(Cutout::blended(map, material.opacity()));
            }
            Alpha::Blend => LEAST_OPACITY,
            Alpha::Cut(least) => least,
        };
        let map = map.filter(|map| self.pictures.falls_below(*map, least))?;
        Some(Cutout::by_picture(map, least))
    }
}

/// Parts of a material that are there by what a graph computes.
fn cutout_of_graph(Settled { material, graphs }: &Settled) -> Option<Cutout> {
    let is_veil = graphs.has(Computes::Opacity) && material.can_blend();
    is_veil.then(|| Cutout::by_graph(material.opacity()))
}

//! Enhancement: what depends on the eye is made anew for every sample, reused or not (the paper's
//! "Enhancement Phase"): highlights, reflections, refractions.

use glam::Vec3;

use super::bounce;
use super::placed::Placed;
use super::stage::{Stage, Workbench};
use crate::samples::{BACKGROUND, CELLS, Cold, EMPTY, Hot, Tag, Tile, from_half};
use crate::scene::Material;
use crate::shade::light::arrival;
use crate::shade::optics::branch;
use crate::shade::{Surface, phong};

/// What a cell shows, by layer of the picture. Linear RGB; their sum is the picture.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Radiance {
    /// Emission, ambient and diffuse light; the background.
    pub diffuse: Vec3,
    /// Highlights.
    pub specular: Vec3,
    /// In mirrors, and off glass.
    pub reflection: Vec3,
    /// Through glass.
    pub refraction: Vec3,
}

/// Writes what each cell of `tile` shows into the bench's `radiance`. The tags must be up to date.
pub fn enhance(stage: &Stage, tile: &Tile, bench: &mut Workbench) {
    bench.radiance.clear();
    bench.radiance.resize(CELLS, Radiance::default());
    let lights = stage.pose.lights.len();
    for (cell, (hot, cold)) in tile.hot.iter().zip(&tile.cold).enumerate() {
        bench.radiance[cell].diffuse = match hot.model {
            EMPTY => continue,
            BACKGROUND => stage.scene.background.radiance(hot.point.normalize()),
            _ => from_half(cold.lit),
        };
        if hot.model == BACKGROUND {
            continue;
        }
        let material = stage.material(hot, cold);
        if material.specular == Vec3::ZERO && !material.has_secondary_rays() {
            continue;
        }
        let placed = bench.placed.get(stage, tile, cell);
        let incoming = (placed.point - stage.view.camera.eye).normalize();
        bench.radiance[cell].specular =
            highlights(stage, material, &placed, incoming, &tile.tags[cell * lights..][..lights]);
        if material.has_secondary_rays() {
            let surface = surface_of(stage, hot, cold, &placed);
            let branches = branch(material.optics, &surface, incoming);
            bench.bounces.start(cell as u32, &surface, branches);
        }
    }
    bounce::follow(stage, bench);
}

/// The highlights of all lights that reach the sample.
fn highlights(stage: &Stage, material: &Material, placed: &Placed, incoming: Vec3, tags: &[Tag]) -> Vec3 {
    if material.specular == Vec3::ZERO {
        return Vec3::ZERO;
    }
    let mut sum = Vec3::ZERO;
    for (light, _) in stage.pose.lights.iter().zip(tags).filter(|(_, tag)| tag.is_lit()) {
        let arrival = arrival(light, placed.point);
        sum += phong::specular(material, placed.normal, -incoming, &arrival);
    }
    sum
}

fn surface_of(stage: &Stage, hot: &Hot, cold: &Cold, placed: &Placed) -> Surface {
    let mesh = &stage.scene.models[hot.model as usize].mesh;
    Surface {
        point: placed.point,
        normal: placed.normal,
        facet: placed.facet,
        albedo: from_half(cold.albedo),
        material: mesh.material_of[cold.triangle as usize],
        from_behind: cold.from_behind,
    }
}

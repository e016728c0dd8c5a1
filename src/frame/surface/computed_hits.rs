//! What graphs compute of the places that rays have met.
//!
//! Programs are evaluated at eight places at once, all of one material. Rays that go all around meet one material here and another one
//! there: their hits are sorted by material first.

use std::array;

use glam::Vec3;

use crate::frame::shot::frame_view::FrameView;
use crate::lanes::LANES;
use crate::scene::Material;
use crate::scene::look::Varied;
use crate::scene::on_mesh::{self, OnMesh};
use crate::trace::{Hit, HitBatch};

/// What graphs compute of a hit.
#[derive(Debug, Clone, Copy)]
pub struct ComputedHit {
    /// Factor of the reflectance, and the parameters of the material that vary.
    pub look: (Vec3, Varied),
    /// Heights: see [`on_mesh::heights`].
    pub heights: [f32; 3],
}

impl ComputedHit {
    /// Nothing is computed.
    const NONE: Self = Self { look: (Vec3::ONE, Varied::NONE), heights: [0.0; 3] };
}

/// What graphs compute of the hits of a batch. Kept as scratch memory.
#[derive(Debug, Default)]
pub struct ComputedHits {
    /// By the number of the hit, up to a multiple of eight. Empty where no graph computes anything in the shot.
    all: Vec<ComputedHit>,
    /// Materials, and the numbers of the hits that have them.
    order: Vec<(u16, u32)>,
}

impl ComputedHits {
    /// Computes them for the first `count` rays of a batch. `beam`: width of the beam (world space) of a ray with this number, at this ray
    /// parameter.
    pub fn compute(
        &mut self,
        frame: &FrameView,
        hits: &HitBatch,
        count: usize,
        beam: impl Fn(usize, f32) -> f32,
    ) {
        self.all.clear();
        if !frame.palette.computes {
            return;
        }
        self.all.resize(count.next_multiple_of(LANES), ComputedHit::NONE);
        self.sort(frame, hits, count);
        for group in self.order.chunk_by(|(one, _), (other, _)| one == other) {
            for some in group.chunks(LANES) {
                let place = |(_, number): (u16, u32)| place(frame, hits, number as usize, &beam);
                let places: [OnMesh; LANES] =
                    array::from_fn(|lane| place(*some.get(lane).unwrap_or(&some[0])));
                compute(frame, some, &places[..some.len()], &mut self.all);
            }
        }
    }

    /// Those of group number `number` of eight rays.
    #[inline(always)]
    pub fn eight(&self, number: usize) -> &[ComputedHit] {
        if self.all.is_empty() { &[] } else { &self.all[number * LANES..][..LANES] }
    }

    /// Sorts the numbers of the hits by their materials; those of which nothing is computed are left out.
    fn sort(&mut self, frame: &FrameView, hits: &HitBatch, count: usize) {
        self.order.clear();
        for number in 0..count {
            let Some(Hit { model, triangle, .. }) = hits.get(number) else { continue };
            let of_model = &frame.scene.models[model as usize].mesh.material_of;
            let material = of_model[triangle as usize];
            if frame.scene.materials[usize::from(material)].has_graphs() {
                self.order.push((material, number as u32));
            }
        }
        self.order.sort_unstable();
    }
}

/// Place of a hit, seen by a beam of this width.
fn place<'s>(
    frame: &FrameView<'s>,
    hits: &HitBatch,
    number: usize,
    beam: impl Fn(usize, f32) -> f32,
) -> OnMesh<'s> {
    let hit = hits.get(number).expect("only hits are sorted");
    let on = OnMesh::on(&frame.scene.models[hit.model as usize], hit.triangle, [hit.u, hit.v]);
    match frame.palette.has_textures {
        true => on.with_width(beam(number, hit.t) * frame.scale_to_object(hit.model)),
        false => on,
    }
}

/// Computes up to eight hits of one material, at these places.
fn compute(frame: &FrameView, some: &[(u16, u32)], places: &[OnMesh], all: &mut [ComputedHit]) {
    let Some((material, _)) = some.first() else { return };
    let Material { computed, bump, .. } = &frame.scene.materials[usize::from(*material)];
    // what depends on the angle is computed where that is known
    if let Some(computed) = computed.as_ref().filter(|computed| !computed.program.is_of_eye()) {
        let looks = on_mesh::appearances(places, frame.scene, computed);
        some.iter().zip(looks).for_each(|((_, number), look)| all[*number as usize].look = look);
    }
    if let Some(bump) = bump {
        let heights = on_mesh::heights(places, frame.scene, bump);
        some.iter().zip(heights).for_each(|((_, number), heights)| all[*number as usize].heights = heights);
    }
}

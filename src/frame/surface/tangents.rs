//! Tangents of surfaces whose lobes are not round. Others need none.

use glam::Vec3;

use crate::exposure::Tick;
use crate::frame::shot::frame_view::FrameView;
use crate::lanes::{LANES, Vec3x8};
use crate::samples::{EMPTY, Tile};
use crate::scene::on_mesh::OnMesh;
use crate::shade::surface::SurfacePoint;

/// Tangent at a place of a primitive of `model`, at a `tick`: world space, of any length; zero if its material asks for none.
#[inline]
pub fn tangent(frame: &FrameView, (model, primitive): (u32, u32), weights: [f32; 2], tick: Tick) -> Vec3 {
    if frame.palette.has_tangents() { of_place(frame, (model, primitive), weights, tick) } else { Vec3::ZERO }
}

/// Not inlined: hardly any shot has such surfaces.
#[inline(never)]
fn of_place(frame: &FrameView, (model, primitive): (u32, u32), weights: [f32; 2], tick: Tick) -> Vec3 {
    let place = OnMesh::on(&frame.scene.models[model as usize], primitive, weights);
    let material = &frame.scene.materials[usize::from(place.material())];
    if material.hair.is_some() {
        let along = place
            .mesh
            .as_curved()
            .map_or_else(|| place.tangent(), |curved| curved.tangent(primitive, weights));
        return frame.place(model, tick).direction(primitive, along);
    }
    let Some(anisotropy) = &material.anisotropy else { return Vec3::ZERO };
    let tangent = anisotropy.around.map_or_else(|| place.tangent(), |axis| place.tangent_around(axis));
    frame.place(model, tick).direction(primitive, tangent)
}

/// Tangent of the sample in `cell`, at its own tick.
#[inline]
pub fn tangent_of_sample(frame: &FrameView, tile: &Tile, cell: usize) -> Vec3 {
    if !frame.palette.has_tangents() {
        return Vec3::ZERO;
    }
    let (record, model) = (&tile.record[cell], tile.model[cell]);
    let mesh = &frame.scene.models[model as usize].mesh;
    let weights = SurfacePoint::weights(mesh, record.triangle, tile.point(cell));
    of_place(frame, (model, record.triangle), weights, record.traced.tick())
}

/// Tangents of eight samples from cell `first` on.
#[inline]
pub fn tangents_of_samples(frame: &FrameView, tile: &Tile, first: usize) -> Vec3x8 {
    let mut all = Vec3x8::ZERO;
    if frame.palette.has_tangents() {
        for lane in (0..LANES).filter(|lane| tile.model[first + lane] < EMPTY) {
            all.set_lane(lane, tangent_of_sample(frame, tile, first + lane));
        }
    }
    all
}

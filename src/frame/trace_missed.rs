//! Primary rays: through the centre of every cell that has no sample, or a hidden one.

use super::stage::{Stage, Workbench};
use super::view::cell_place;
use crate::samples::{BACKGROUND, Cold, Hot, Octahedral, Status, Tag, Tile, to_half};
use crate::shade::surface::{albedo, interpolate};
use crate::trace::{Coherence, Hit};

/// Traces the cells of tile number `number` that are `Missed`, `Obscured` or `Base`.
pub fn trace_missed(stage: &Stage, number: usize, tile: &mut Tile, bench: &mut Workbench) {
    let corner = stage.view.tile_corner(number);
    bench.begin_rays();
    for (cell, cold) in tile.cold.iter().enumerate() {
        if matches!(cold.status, Status::Missed | Status::Obscured | Status::Base) {
            let place = cell_place(cell).map(|along| along as f32 + 0.5);
            let direction = stage.view.direction(corner[0] as f32 + place[0], corner[1] as f32 + place[1]);
            bench.rays.push(stage.view.camera.eye, direction, 0.0, f32::INFINITY);
            bench.owners.push(cell as u32);
            bench.cell_rays[cell].primary += 1;
        }
    }
    if bench.rays.is_empty() {
        return;
    }
    bench.counts.primary += bench.rays.len() as u64;
    stage.tracer.closest(&bench.rays, Coherence::Coherent, &mut bench.hits);
    let lights = stage.pose.lights.len();
    for (ray, cell) in bench.owners.iter().map(|cell| *cell as usize).enumerate() {
        let place = cell_place(cell).map(|along| along as f32 + 0.5);
        let direction = stage.view.direction(corner[0] as f32 + place[0], corner[1] as f32 + place[1]);
        let status = tile.cold[cell].status;
        (tile.hot[cell], tile.cold[cell]) = match bench.hits.get(ray) {
            Some(hit) => sample_of(stage, hit, direction, status),
            None => (Hot { point: direction, model: BACKGROUND }, Cold { status, ..Cold::default() }),
        };
        tile.tags[cell * lights..][..lights].fill(Tag::Unknown);
    }
}

/// What the store keeps of a hit that is seen along `direction`: object space, on the side of the eye.
pub fn sample_of(stage: &Stage, hit: Hit, direction: glam::Vec3, status: Status) -> (Hot, Cold) {
    let mesh = &stage.scene.models[hit.model as usize].mesh;
    let corner = interpolate(mesh, hit.triangle, hit.u, hit.v);
    let material = &stage.scene.materials[usize::from(mesh.material_of[hit.triangle as usize])];
    let point = on_ray(stage, hit, corner.point, direction);
    let from_behind = stage.transform(hit.model).facet(corner.facet).dot(direction) > 0.0;
    let side = if from_behind { -1.0 } else { 1.0 };
    let cold = Cold {
        triangle: hit.triangle,
        normal: Octahedral::fold(corner.normal * side),
        facet: Octahedral::fold(corner.facet * side),
        albedo: to_half(albedo(stage.scene, material, corner.uv)),
        status,
        from_behind,
        ..Cold::default()
    };
    (Hot { point, model: hit.model }, cold)
}

/// The hit point in object space.
///
/// By the triangle's corners it lies in the triangle's plane as well as floats can say, and is taken. But
/// where the triangle is seen edge on, its weights are all but undetermined and may lead out of the cell:
/// there the point on the ray is the better one, and just as much in the plane.
fn on_ray(stage: &Stage, hit: Hit, by_corners: glam::Vec3, direction: glam::Vec3) -> glam::Vec3 {
    /// In cells.
    const FARTHEST: f32 = 0.125;
    let transform = stage.transform(hit.model);
    let eye = stage.view.camera.eye;
    let place = |way| stage.view.project(way).map(|seen| glam::Vec2::new(seen.x, seen.y));
    let apart = place(transform.point(by_corners) - eye).zip(place(direction)).map(|(a, b)| a.distance(b));
    if apart.is_some_and(|apart| apart < FARTHEST) {
        return by_corners;
    }
    let on_ray = eye + direction * hit.t;
    if transform.is_identity { on_ray } else { transform.to_object.transform_point3(on_ray) }
}

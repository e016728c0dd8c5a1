//! Primary rays: through the centre of every cell that has no sample, or a hidden one.

use glam::Vec3;

use super::stage::{Stage, Workbench};
use super::view::cell_place;
use crate::samples::{BACKGROUND, Cold, Hot, Octahedral, Status, Tag, Tile, to_half};
use crate::scene::Mesh;
use crate::shade::surface::{Corner, albedo, barycentric, interpolate};
use crate::trace::{Coherence, Hit};

/// Of the distance from the eye: how far beside its ray a hit point may lie. Less than the audit tolerates by
/// enough that what a later ray through the point meets is what this one met.
const OFF_RAY: f32 = 2.5e-6;

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
pub fn sample_of(stage: &Stage, hit: Hit, direction: Vec3, status: Status) -> (Hot, Cold) {
    let mesh = &stage.scene.models[hit.model as usize].mesh;
    let (point, corner) = point_of(stage, mesh, hit, direction);
    let material = &stage.scene.materials[usize::from(mesh.material_of[hit.triangle as usize])];
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

/// The point that was hit, object space, and what the mesh is there.
///
/// By the triangle's corners the point lies in the triangle's plane as well as floats can say, and is taken.
/// But where the triangle is a sliver or is seen edge on, its weights are all but undetermined in single
/// floats and may lead away from the ray, behind something else: there ray and triangle are met again in
/// double floats.
fn point_of(stage: &Stage, mesh: &Mesh, hit: Hit, direction: Vec3) -> (Vec3, Corner) {
    let (transform, eye) = (stage.transform(hit.model), stage.view.camera.eye);
    let corner = interpolate(mesh, hit.triangle, hit.u, hit.v);
    let offset = transform.point(corner.point) - eye;
    let off_ray = offset.cross(direction).length() / direction.length();
    if off_ray <= OFF_RAY * offset.length() {
        return (corner.point, corner);
    }
    let to_object = |way: Vec3| match transform.is_identity {
        true => way.as_dvec3(),
        false => transform.to_object.transform_vector3(way).as_dvec3(),
    };
    let origin = match transform.is_identity {
        true => eye.as_dvec3(),
        false => transform.to_object.transform_point3(eye).as_dvec3(),
    };
    let positions = mesh.positions.as_slice();
    let place = |i: u32| Vec3::from_array(positions[i as usize]).as_dvec3();
    let [a, b, c] = mesh.triangles[hit.triangle as usize].map(place);
    let (plane, along) = ((b - a).cross(c - a), to_object(direction));
    let t = (a - origin).dot(plane) / along.dot(plane);
    let met = origin + along * if t.is_finite() { t } else { f64::from(hit.t) };
    let Some(at) = barycentric([a, b, c], met, f64::INFINITY) else { return (corner.point, corner) };
    let point = a + (b - a) * at.x + (c - a) * at.y;
    (point.as_vec3(), interpolate(mesh, hit.triangle, at.x as f32, at.y as f32))
}

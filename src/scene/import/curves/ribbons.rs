//! Flat curves: strips of triangles, which lie across the normals of their points.

use glam::{Vec2, Vec3};

use super::set::{Chains, CurveSet, none_is_left};
use crate::animation::ShapeTrack;
use crate::scene::Mesh;
use crate::scene::details::vertex_color;
use crate::scene::import::Import;
use crate::scene::import::deformed::{self, Distinct};
use crate::scene::import::part_of_file::Surface;

/// Makes the mesh of flat curves of one material, the track of its shapes, and tells what was left out.
///
/// # Errors Those of [`CurveSet::chains`], and that there is no curve to be drawn.
pub fn mesh_of(
    import: &mut Import,
    set: &CurveSet,
    (tolerance, again): (Option<f64>, Option<f64>),
    material: u16,
) -> Result<(Mesh, Option<ShapeTrack>, Vec<String>), String> {
    let (chains, left_out) = set.chains(tolerance)?;
    let strips: Vec<Strips> = (0..chains.shapes.len()).map(|shape| Strips::of(&chains, shape)).collect();
    let mut shapes = Distinct::default();
    for (shape, strips) in set.shapes.iter().zip(&strips) {
        shapes.add(shape.frame, strips.positions.clone());
    }
    let first = &strips[0];
    let mut triangles = triangles_of(&chains.counts);
    let kept = (!shapes.list.is_empty()).then(|| deformed::most_open(&first.positions, &triangles, &shapes));
    let at_rest = kept.and_then(|kept| kept.among(&shapes)).unwrap_or(&first.positions);
    triangles.retain(|triangle| deformed::has_area(at_rest, *triangle));
    if triangles.is_empty() {
        return Err(none_is_left(&left_out));
    }
    if !set.colors.is_empty() {
        import.surfaces.color_vertices(material);
    }
    let colors = chains.colors.iter().filter(|_| !set.colors.is_empty());
    let all = 0..triangles.len();
    let surface = Surface {
        positions: first.positions.clone(),
        normals: first.normals.clone(),
        uvs: uvs_of(&chains),
        colors: colors.flat_map(|color| [vertex_color(*color); 2]).collect(),
        triangles,
        ..Surface::default()
    };
    let mesh = import.arranger().mesh_of_runs(surface, vec![(all, material)]);
    let Some(kept) = kept else { return Ok((mesh, None, left_out)) };
    let (keys, places) = (shapes.keys.clone(), deformed::places(at_rest, &shapes.list));
    let (mesh, track) = deformed::with_shapes(mesh, shapes, kept, &places);
    Ok((mesh, track.and_then(|_| ShapeTrack::through(keys, again)), left_out))
}

/// Vertices of all strips in one shape: two for each point of a chain, on its left and on its right.
struct Strips {
    positions: Vec<[f32; 3]>,
    normals: Vec<Vec3>,
}

impl Strips {
    fn of(chains: &Chains, shape: usize) -> Self {
        let (points, normals) = (&chains.shapes[shape], &chains.normals[shape]);
        let mut strips = Self { positions: Vec::new(), normals: Vec::new() };
        let mut begin = 0;
        for count in chains.counts.iter().map(|count| *count as usize) {
            let place = |at: usize| Vec3::from_slice(&points[begin + at]);
            // where it has no direction, or its normal goes along it, that of the point before
            let (mut along, mut aside) = (Vec3::Y, Vec3::ZERO);
            for at in 0..count {
                let way = place((at + 1).min(count - 1)) - place(at.saturating_sub(1));
                along = way.try_normalize().unwrap_or(along);
                let across = along.cross(Vec3::from(normals[begin + at]));
                let usual = if aside == Vec3::ZERO { along.any_orthonormal_vector() } else { aside };
                aside = across.try_normalize().unwrap_or(usual);
                let reach = aside * points[begin + at][3];
                strips.positions.extend([place(at) - reach, place(at) + reach].map(|at| at.to_array()));
                strips.normals.extend([aside.cross(along).normalize_or_zero(); 2]);
            }
            begin += count;
        }
        strips
    }
}

/// Triangles of strips along chains of so many points.
fn triangles_of(counts: &[u32]) -> Vec<[u32; 3]> {
    let mut begin = 0;
    let mut triangles = Vec::new();
    for count in counts {
        for left in (begin..begin + count.saturating_sub(1)).map(|point| 2 * point) {
            triangles.extend([[left, left + 1, left + 3], [left, left + 3, left + 2]]);
        }
        begin += count;
    }
    triangles
}

/// Texture coordinates: those of the curve; where it has none the share of its length, and 0 and 1 at its sides.
fn uvs_of(chains: &Chains) -> Vec<Vec2> {
    let mut uvs = Vec::new();
    let mut begin = 0;
    for (curve, count) in chains.counts.iter().map(|count| *count as usize).enumerate() {
        let place = |at: usize| Vec3::from_slice(&chains.shapes[0][begin + at]);
        let mut lengths = vec![0.0];
        for at in 1..count {
            lengths.push(lengths[at - 1] + place(at).distance(place(at - 1)));
        }
        let whole = lengths[count - 1].max(f32::MIN_POSITIVE);
        for length in lengths {
            let own = chains.uvs.get(curve).map(|uv| [*uv; 2]);
            uvs.extend(own.unwrap_or([0.0, 1.0].map(|side| Vec2::new(length / whole, side))));
        }
        begin += count;
    }
    uvs
}

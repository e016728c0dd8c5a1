//! Dices what is subdivided or displaced: meshes whose readers left a [`Cage`] become meshes of small triangles, once a shot, by the size at
//! which its cameras see them at their nearest. Nothing behind this knows: samples, motion and bounds are those of the triangles.
//!
//! A mesh has one level for all of its faces, so that no two of them meet with edges of different lengths and crack, and the same
//! triangles in all of its shapes.

mod build;
mod displace;
mod levels;
mod views;

use std::collections::HashMap;
use std::sync::Arc;

pub(in crate::scene) use levels::Dicing;
pub(in crate::scene) use views::Views;

use self::levels::{Bound, Levels, MOST_DEPTH};
use super::cage::Cage;
use super::import::Import;
use super::{Mesh, Model, SceneError};
use crate::digest::Digest;
use crate::subdivision::Scheme;

/// Length of edges in pixels, where a shot does not say.
pub(crate) const DEFAULT_EDGE: f64 = 1.0;

/// Maximum number of triangles that a mesh is diced into, where a shot does not say: some 500 MiB while they are made.
pub(crate) const DEFAULT_TRIANGLES: u64 = 4_000_000;

/// Maximum number of triangles that a shot may state for a mesh.
pub(crate) const MOST_DICED: u32 = 1 << 30;

/// Models whose meshes were diced.
pub(in crate::scene) struct Diced {
    pub models: Vec<Model>,
    /// Digest of how they were diced, if any was.
    pub digest: Option<Digest>,
}

/// Dices the meshes of `models` that have cages, and displaces those whose materials say so.
///
/// # Errors In a strict load: a mesh that is not as fine as it should be.
pub(in crate::scene) fn diced(
    models: Vec<Model>,
    import: &mut Import,
    views: &Views,
    dicing: &Dicing,
) -> Result<Diced, SceneError> {
    let mut of_meshes: Vec<(*const Mesh, Vec<&Model>)> = Vec::new();
    let mut known: HashMap<*const Mesh, usize> = HashMap::new();
    for model in &models {
        let mesh = Arc::as_ptr(&model.mesh);
        let is_displaced = displace::is_displaced(&model.mesh, import);
        if model.mesh.details.cage.is_none() && !is_displaced {
            continue;
        }
        let number = *known.entry(mesh).or_insert_with(|| {
            of_meshes.push((mesh, Vec::new()));
            of_meshes.len() - 1
        });
        of_meshes[number].1.push(model);
    }
    let mut made: HashMap<*const Mesh, Arc<Mesh>> = HashMap::new();
    let mut digests = Vec::new();
    for (mesh, shown) in &of_meshes {
        let (of_mesh, depth) = mesh_of(shown, import, views, dicing)?;
        digests.push(Digest::new(&(depth as u64).to_le_bytes()));
        made.insert(*mesh, Arc::new(of_mesh));
    }
    let digest = (!digests.is_empty()).then(|| Digest::of_all(digests));
    let with_mesh = |model: Model| match made.get(&Arc::as_ptr(&model.mesh)) {
        Some(mesh) => Model { mesh: mesh.clone(), ..model },
        None => model,
    };
    Ok(Diced { models: models.into_iter().map(with_mesh).collect(), digest })
}

/// Dices the mesh that these models share, and displaces it. Returns how often it was subdivided as well.
fn mesh_of(
    shown: &[&Model],
    import: &mut Import,
    views: &Views,
    dicing: &Dicing,
) -> Result<(Mesh, usize), SceneError> {
    let first = shown[0];
    let fault = |what: String| SceneError::new(&first.path, format!("model `{}`: {what}", first.name));
    let (mut mesh, mut depth) = (Mesh::clone(&first.mesh), 0);
    if let Some(cage) = first.mesh.details.cage.clone() {
        let mut cage = Arc::unwrap_or_clone(cage);
        mesh = mesh.without_cage();
        match diced_cage(&mut cage, shown, import, views, dicing) {
            Ok((diced, levels, findings)) => {
                (mesh, depth) = (diced, levels);
                for finding in findings {
                    import.findings.stand_in(fault(finding))?;
                }
            }
            Err(why) => import.findings.stand_in(fault(format!("it is shown as its cage: {why}")))?,
        }
    }
    let (mesh, why) = displace::displaced(mesh, first, import);
    why.map_or(Ok(()), |why| import.findings.stand_in(fault(why)))?;
    Ok((mesh, depth))
}

/// Dices a cage that these models share. Returns what is to be told as well, and how often it was subdivided.
///
/// # Errors Why it cannot be diced.
fn diced_cage(
    cage: &mut Cage,
    shown: &[&Model],
    import: &Import,
    views: &Views,
    dicing: &Dicing,
) -> Result<(Mesh, usize, Vec<String>), String> {
    let mut findings = Vec::new();
    match cage.remove_degenerate() {
        0 => {}
        count => findings.push(format!(
            "{count} faces of its cage have fewer than three corners, or two at one point: they are left out"
        )),
    }
    if cage.counts.is_empty() {
        return Err(String::from("its cage has no faces"));
    }
    let others = cage.counts.iter().filter(|count| **count != 3).count();
    if cage.scheme == Scheme::Loop && others > 0 {
        return Err(format!(
            "{others} of its faces are no triangles, and the scheme loop is of triangles alone: triangulate it, or use catmullClark"
        ));
    }
    let pixels = views.pixels_of_faces(cage, shown);
    let materials = &import.surfaces.materials;
    let by_length = |face: u32| {
        let material = cage.material_of.get(face as usize).map(|number| &materials[usize::from(*number)]);
        material.is_some_and(|material| material.displacement.is_some())
    };
    let Levels { hierarchy, bound } = levels::levels(cage, &pixels, by_length, dicing)?;
    let odd = hierarchy.first().odd_edges();
    if odd > 0 && cage.scheme != Scheme::Bilinear {
        findings.push(format!(
            "{odd} edges of its cage have more than two faces, or two that turn the other way round: they are sharp"
        ));
    }
    let edge = dicing.edge;
    findings.extend(bound.map(|bound| match bound {
        Bound::Triangles(count) => format!(
            "it is diced into {count} triangles, with edges longer than {edge} pixels: more would be more than `dicing_triangles` = {}",
            dicing.triangles
        ),
        Bound::Depth => {
            format!("it is subdivided {MOST_DEPTH} times, and has edges longer than {edge} pixels: make its cage finer")
        }
        Bound::Memory(what) => format!("it has edges longer than {edge} pixels: {what}"),
    }));
    let depth = hierarchy.depth();
    let space = shown[0].mesh.details.space;
    let mesh = build::mesh(cage, &hierarchy, import, space)?;
    Ok((mesh, depth, findings))
}

//! Media: what fills closed meshes, or everything, and what becomes of light on its way through them.
//!
//! A medium is asked by rays alone, and is no surface: where its material has none, no ray meets its mesh. Which media are around a place
//! follows from the boundaries that a line from there crosses, all of them, be they behind what the line ends at: closed meshes have an
//! inside wherever one begins. So nobody needs to know where the eye is.
//!
//! Media that overlap add up, as in Cycles.

mod baked;
pub mod boundary;
mod channels;
pub mod grid;
pub mod phase;
pub mod spans;

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use self::boundary::{Boundary, Fault};
use self::grid::{Cell, MOST_CHANNELS, MediumGrid};
use self::spans::{Run, Spans};
use crate::exposure::Tick;
use crate::pose::Pose;
use crate::scene::medium::Medium;
use crate::scene::{Mesh, Scene};
use crate::shade::deformed::Deformations;

/// Most media of a shot that are bounded: their crossings keep 16 bits of number.
const MOST: usize = 1 << 16;

/// A medium in a mesh of a model.
#[derive(Debug, Clone)]
struct Bounded {
    model: u32,
    material: u16,
    /// Render space, for an object that is as large as its file says.
    medium: Medium,
    /// Its triangles, in the mesh.
    triangles: Arc<Vec<u32>>,
    /// In the shape at rest, object space.
    boundary: Arc<Boundary>,
    /// How it varies in there.
    grid: Option<Arc<MediumGrid>>,
}

/// The media of a shot, render space.
#[derive(Debug, Default)]
pub struct MediaOfShot {
    everywhere: Option<Medium>,
    bounded: Vec<Bounded>,
}

/// A part of a mesh with a medium, but no inside.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unbounded {
    /// Name of the model.
    pub model: String,
    /// Name of the material.
    pub material: String,
    /// What is wrong.
    pub fault: &'static str,
}

impl MediaOfShot {
    /// Finds the media of `scene`, and evaluates what graphs give of them.
    pub fn of(scene: &Scene) -> Self {
        let (mut media, _) = Self::found(scene);
        let mut known: HashMap<(*const Mesh, u16), Option<Arc<MediumGrid>>> = HashMap::new();
        for bounded in &mut media.bounded {
            let model = &scene.models[bounded.model as usize];
            let material = &scene.materials[usize::from(bounded.material)];
            let grid = || baked::grid(scene, model, material, &bounded.boundary.bounds()).map(Arc::new);
            bounded.grid = match &material.medium_graph {
                // it may depend on where the model is
                Some(_) => grid(),
                None => {
                    known.entry((Arc::as_ptr(&model.mesh), bounded.material)).or_insert_with(grid).clone()
                }
            };
        }
        // where a volume or a graph gives nothing, there is nothing
        media.bounded.retain(|bounded| {
            let (model, material) = (bounded.model as usize, usize::from(bounded.material));
            let varies = scene.models[model].mesh.details.volume.is_some()
                || scene.materials[material].medium_graph.is_some();
            bounded.grid.is_some() || !varies
        });
        media
    }

    /// Meshes of `scene` that hold no medium, though their materials have one.
    pub fn unbounded(scene: &Scene) -> Vec<Unbounded> {
        Self::found(scene).1
    }

    fn found(scene: &Scene) -> (Self, Vec<Unbounded>) {
        let scale = scene.space.scale() as f32;
        let fills = |medium: &Option<Medium>| medium.filter(|medium| !medium.is_clear());
        let everywhere = fills(&scene.fog).map(|medium| medium.scaled(scale));
        let (mut bounded, mut unbounded) = (Vec::new(), Vec::new());
        if scene.materials.iter().all(|material| fills(&material.medium).is_none()) {
            return (Self { everywhere, bounded }, unbounded);
        }
        type Found = Result<(Arc<Vec<u32>>, Arc<Boundary>), Fault>;
        let mut known: HashMap<(*const Mesh, u16), Found> = HashMap::new();
        for (model, of) in (0..).zip(&scene.models) {
            let mesh = &of.mesh;
            let mut materials = mesh.material_of.clone();
            materials.sort_unstable();
            materials.dedup();
            for number in materials {
                let material = &scene.materials[usize::from(number)];
                let Some(medium) = fills(&material.medium) else { continue };
                let found = known.entry((Arc::as_ptr(mesh), number)).or_insert_with(|| {
                    let triangles = triangles_of(mesh, number);
                    let boundary = Boundary::new(at_rest(mesh, &triangles))?;
                    Ok((Arc::new(triangles), Arc::new(boundary)))
                });
                match found {
                    Ok((triangles, boundary)) if bounded.len() < MOST => {
                        let (triangles, boundary) = (Arc::clone(triangles), Arc::clone(boundary));
                        let medium = medium.scaled(scale);
                        bounded.push(Bounded {
                            model,
                            material: number,
                            medium,
                            triangles,
                            boundary,
                            grid: None,
                        });
                    }
                    Ok(_) => unbounded.push(told(&of.name, &material.name, "there are more than 65536")),
                    Err(Fault::Open) => unbounded.push(told(&of.name, &material.name, "it is not closed")),
                    Err(Fault::Flat) => unbounded.push(told(&of.name, &material.name, "it is flat")),
                }
            }
        }
        (Self { everywhere, bounded }, unbounded)
    }

    /// Returns true if there is none.
    pub fn are_none(&self) -> bool {
        self.everywhere.is_none() && self.bounded.is_empty()
    }

    /// Returns true if a model has one.
    pub fn fills(&self, model: usize) -> bool {
        self.bounded.iter().any(|bounded| bounded.model as usize == model)
    }

    /// The media where `pose` has their models, which have these shapes.
    pub fn placed<'a>(
        &'a self,
        scene: &Scene,
        pose: &'a Pose,
        deformations: &Deformations,
    ) -> Option<Media<'a>> {
        if self.are_none() {
            return None;
        }
        let shape = |bounded: &Bounded| {
            // within an exposure the shape is that of its middle
            let transform = &pose.models[bounded.model as usize];
            let deformed = deformations.of_model(scene, bounded.model, transform)?;
            let corners = bounded.triangles.iter().map(|triangle| deformed.corners(*triangle)).collect();
            Some(Arc::new(bounded.boundary.in_shape(corners)))
        };
        let there = self.bounded.iter().filter(|bounded| pose.models[bounded.model as usize].is_visible);
        let bounded = there.map(|bounded| Placed {
            model: bounded.model as usize,
            medium: bounded.medium,
            boundary: shape(bounded).unwrap_or_else(|| Arc::clone(&bounded.boundary)),
            grid: bounded.grid.clone(),
        });
        Some(Media { everywhere: self.everywhere.as_ref(), bounded: bounded.collect(), pose })
    }
}

fn told(model: &str, material: &str, fault: &'static str) -> Unbounded {
    Unbounded { model: model.to_string(), material: material.to_string(), fault }
}

/// Numbers of the triangles of a mesh that are of a material.
fn triangles_of(mesh: &Mesh, material: u16) -> Vec<u32> {
    if mesh.as_triangles().is_none() {
        return Vec::new();
    }
    (0..).zip(&mesh.material_of).filter(|(_, of)| **of == material).map(|(number, _)| number).collect()
}

/// Corners of these triangles of a mesh, object space.
fn at_rest(mesh: &Mesh, triangles: &[u32]) -> Vec<[DVec3; 3]> {
    let Some(all) = mesh.as_triangles() else { return Vec::new() };
    triangles.iter().map(|number| all.positions_of(*number).map(|corner| corner.as_dvec3())).collect()
}

/// A medium in its place.
#[derive(Debug)]
struct Placed {
    model: usize,
    medium: Medium,
    boundary: Arc<Boundary>,
    grid: Option<Arc<MediumGrid>>,
}

/// The media of a shot in one picture.
#[derive(Debug)]
pub struct Media<'a> {
    everywhere: Option<&'a Medium>,
    bounded: Vec<Placed>,
    pose: &'a Pose,
}

impl Media<'_> {
    /// Share of light that comes straight along the segment `origin + t * along`, t in `0..=far` (world space), at a `tick`.
    pub fn left(&self, (origin, along): (Vec3, Vec3), far: f32, tick: Tick) -> Vec3 {
        let length = f64::from(along.length());
        let mut depth = self
            .everywhere
            .map_or(Vec3::ZERO, |medium| depth(medium.extinction(), (f64::from(far) * length) as f32));
        for placed in &self.bounded {
            let line = self.pose.transform(placed.model, tick).line_to_object((origin, along));
            if let Some(grid) = &placed.grid {
                let (medium, mut crossings) = (&placed.medium, Vec::new());
                placed.boundary.crossings(line, |t, side| crossings.push((t, side)));
                inside(&mut crossings, far.into(), |from, to, count| {
                    let mut integrals = [0.0; MOST_CHANNELS];
                    grid.integrate(line, [from, to], &mut integrals);
                    let cell = grid.cell(&integrals);
                    let extinction = medium.scatter * cell.scatter + medium.absorb * cell.absorb;
                    depth += extinction * (count * length) as f32;
                });
                continue;
            }
            // the length inside is the sum of where it comes out, less that of where it goes in, all cut off at the end
            let mut inside = 0.0;
            placed.boundary.crossings(line, |t, side| inside += side * t.min(far.into()));
            if inside > 0.0 {
                depth += placed.medium.extinction() * (inside * length) as f32;
            }
        }
        (-depth).exp()
    }

    /// Finds what of a ray lies in media: `direction` has unit length.
    pub fn find(&self, (origin, direction): (Vec3, Vec3), far: f32, tick: Tick, spans: &mut Spans) {
        spans.begin();
        let mut crossings = std::mem::take(&mut spans.crossings);
        for placed in &self.bounded {
            let line = self.pose.transform(placed.model, tick).line_to_object((origin, direction));
            crossings.clear();
            placed.boundary.crossings(line, |t, side| crossings.push((t, side)));
            let medium = &placed.medium;
            inside(&mut crossings, far.into(), |from, to, count| match &placed.grid {
                None => spans.run(run([from, to], medium, &Cell::FULL, count)),
                Some(grid) => grid.walk(line, [from, to], |from, to, cell| {
                    spans.run(run([from, to], medium, cell, count));
                }),
            });
        }
        spans.crossings = crossings;
        spans.finish(self.everywhere, far);
    }
}

/// Calls `each` for the parts of a line up to `far` that are inside of a boundary, in their order: with the parameters at which a part begins
/// and ends, and how often it is inside.
fn inside(crossings: &mut [(f64, f64)], far: f64, mut each: impl FnMut(f64, f64, f64)) {
    crossings.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    // as often as it comes out it has been inside from the start
    let mut count: f64 = crossings.iter().map(|(_, side)| side).sum();
    let mut from = 0.0;
    for (at, side) in crossings.iter() {
        let to = at.min(far);
        if count > 0.0 && from < to {
            each(from, to, count);
        }
        from = to;
        count -= side;
    }
}

/// A part of a ray in a cell of a medium, as often as it is inside.
fn run([from, to]: [f64; 2], medium: &Medium, cell: &Cell, count: f64) -> Run {
    let count = count as f32;
    let medium = Medium {
        scatter: medium.scatter * cell.scatter * count,
        absorb: medium.absorb * cell.absorb * count,
        emit: medium.emit * cell.emit * count,
        anisotropy: medium.anisotropy,
    };
    Run { from: from as f32, to: to as f32, medium }
}

/// Optical depth of a way of this length.
fn depth(extinction: Vec3, length: f32) -> Vec3 {
    let of = |extinction: f32| if extinction > 0.0 { extinction * length } else { 0.0 };
    Vec3::from_array(extinction.to_array().map(of))
}

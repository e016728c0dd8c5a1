//! Which model and triangle a primitive is: Embree's ids, and the program's own lists.
//!
//! A model has up to four geometries: the triangles that cast shadows and then those that do not, whole
//! ones and those that are [cut out](crate::scene::cutout) apart (in the order of
//! [`Triangles::corners`](crate::scene::Triangles::corners)), so that `triangle = first + primID`. In the scene of what stands still a geometry's
//! id leads to its [`GeometryPart`]. With instances, the instance's id leads to the model and the geometry's to its part, whichever scene they
//! are in: instances of copies that stand still have ids after all those of models that move.

use embree::{GeometryId, Hit, INVALID, PrimId};

use super::frozen::MOST_PARTS;
use crate::lanes::are_same;
use crate::trace::NO_HIT;

/// Place of a geometry's triangles in the program's own lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct GeometryPart {
    model: u32,
    /// Index of the geometry's first triangle in the mesh.
    first: u32,
}

/// Places of an instance's triangles in the program's own lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct InstanceParts {
    model: u32,
    /// Index of the first triangle in the mesh, by geometry.
    firsts: [u32; MOST_PARTS],
}

/// Parts of all geometries and instances, by their ids.
#[derive(Debug, Default)]
pub struct PartsById {
    /// Of geometries in world space.
    still: Vec<GeometryPart>,
    /// Of instances, in both scenes.
    instances: Vec<InstanceParts>,
}

impl PartsById {
    /// Adds the next geometry in world space: triangles of `model`, the first of which has this number.
    pub fn add(&mut self, GeometryId(id): GeometryId, model: u32, first: u32) {
        debug_assert_eq!(id as usize, self.still.len());
        self.still.push(GeometryPart { model, first });
    }

    /// Id of the next instance: above those of all instances so far, whichever scene they are in.
    pub fn next_instance(&self) -> GeometryId {
        GeometryId(self.instances.len() as u32)
    }

    /// Adds an instance of `model`, with its first triangles by geometry.
    pub fn add_instance(&mut self, GeometryId(id): GeometryId, model: u32, firsts: [u32; MOST_PARTS]) {
        debug_assert!(id as usize >= self.instances.len());
        // ids of triangles in world space are not those of instances
        let nobody = InstanceParts { model: NO_HIT, firsts: [0; MOST_PARTS] };
        self.instances.resize(id as usize, nobody);
        self.instances.push(InstanceParts { model, firsts });
    }

    /// Model and triangle of a primitive.
    #[inline(always)]
    pub fn name(&self, met: PrimId) -> (u32, u32) {
        let part = self.part(met.inst_id, met.geom_id);
        (part.model, part.first + met.prim_id)
    }

    /// Looks up the models and triangles that N rays met.
    #[inline(always)]
    pub fn name_all<const N: usize>(&self, hit: &Hit<N>, (models, triangles): (&mut [u32], &mut [u32])) {
        let (geometry, instance) = (hit.geom_id[0], hit.inst_id[0]);
        if geometry != INVALID && are_same(&hit.geom_id) && are_same(&hit.inst_id) {
            let part = self.part(instance, geometry);
            models.fill(part.model);
            triangles.iter_mut().zip(&hit.prim_id).for_each(|(triangle, id)| *triangle = part.first + id);
            return;
        }
        for lane in 0..N {
            if hit.geom_id[lane] == INVALID {
                models[lane] = NO_HIT;
                continue;
            }
            let part = self.part(hit.inst_id[lane], hit.geom_id[lane]);
            models[lane] = part.model;
            triangles[lane] = part.first + hit.prim_id[lane];
        }
    }

    #[inline(always)]
    fn part(&self, instance: u32, geometry: u32) -> GeometryPart {
        match instance {
            INVALID => self.still[geometry as usize],
            instance => {
                let InstanceParts { model, firsts } = &self.instances[instance as usize];
                GeometryPart { model: *model, first: firsts[geometry as usize] }
            }
        }
    }
}

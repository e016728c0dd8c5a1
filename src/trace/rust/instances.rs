//! Placed models, in a tree above those of their meshes.

use glam::Affine3A;

use super::beam::{Beam, Open, Probe, Visitor, walk};
use super::rays::{Pace, Rays, first_of, open_lanes};
use super::search::{Exempt, block, closest_of, next_beam};
use super::triangles::{Shown, Triangles};
use crate::animation::Transform;
use crate::geometry::tree::{Box3, Tree};
use crate::trace::{Coherence, HitPacket, LANES};

/// A placed model: for the whole shot, or in one frame.
pub struct Instance {
    /// Index of the mesh.
    mesh: usize,
    model: u32,
    /// True if it moved since the frame before.
    moved: bool,
    to_object: Affine3A,
    /// Position of a model that deforms between its shapes.
    share: f32,
}

impl Instance {
    #[inline(always)]
    fn shown<'a>(&self, meshes: &'a [Triangles]) -> Shown<'a> {
        Shown { triangles: &meshes[self.mesh], model: self.model, share: self.share }
    }
}

/// Placed models.
pub struct Instances {
    all: Vec<Instance>,
    /// Tree above them; its leaves are their numbers.
    above: Tree,
}

impl Instances {
    /// Places models, each with the index of its mesh in `meshes`. `place` gives the transform of a model;
    /// `moved` returns true if it was elsewhere in the frame before.
    pub fn new(
        models: impl Iterator<Item = (u32, usize)>,
        meshes: &[Triangles],
        place: impl Fn(u32) -> Transform,
        moved: impl Fn(u32) -> bool,
    ) -> Self {
        let (mut all, mut boxes): (Vec<Instance>, Vec<Box3>) = (Vec::new(), Vec::new());
        for (model, mesh) in models {
            let transform = place(model);
            boxes.push(meshes[mesh].tree.bounds.placed(&transform));
            let (to_object, share) = (transform.to_object, transform.shape.share);
            all.push(Instance { mesh, model, moved: moved(model), to_object, share });
        }
        Self { all, above: Tree::new(&boxes, 1, |ids| ids[0]) }
    }

    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }
}

/// Instances with the meshes that they place.
#[derive(Clone, Copy)]
pub struct Placed<'a> {
    pub meshes: &'a [Triangles],
    pub instances: &'a Instances,
}

impl Placed<'_> {
    /// Shortens the rays `used` to their first hits.
    #[inline(always)]
    pub fn closest(
        &self,
        rays: &Rays,
        used: u16,
        coherence: Coherence,
        best: &mut HitPacket,
        stack: &mut Vec<Open>,
    ) {
        let mut rest = used;
        while rest != 0 {
            let used = next_beam(rays, rest, coherence);
            rest &= !used;
            let (among, above) = (*self, &self.instances.above);
            if coherence == Coherence::Incoherent {
                let (mut ray, ..) = rays.one(first_of(used), best.t[first_of(used)], &above.bounds);
                let pace = Pace::OF_T;
                let mut visitor = ClosestInstance { among, rays, used, pace, coherence, best };
                walk::<true, _>(&mut ray, above, stack, &mut visitor);
                continue;
            }
            let (common, pace) = rays.common(used, &best.t);
            let mut beam = Beam::new(&common, &above.bounds);
            let mut visitor = ClosestInstance { among, rays, used, pace, coherence, best };
            walk::<true, _>(&mut beam, above, stack, &mut visitor);
        }
    }

    /// Ends those of the rays `used` that are blocked.
    #[inline(always)]
    #[expect(
        clippy::too_many_arguments,
        reason = "each is a thing by itself, and what they make is only called"
    )]
    pub fn block(
        &self,
        moved_alone: bool,
        rays: &Rays,
        used: u16,
        coherence: Coherence,
        exempt: Exempt<'_>,
        far: &mut [f32; LANES],
        stack: &mut Vec<Open>,
    ) {
        let mut rest = used;
        while rest != 0 {
            let used = next_beam(rays, rest, coherence);
            rest &= !used;
            let (among, above, end) = (*self, &self.instances.above, far[first_of(used)]);
            if coherence == Coherence::Incoherent {
                let (mut ray, ..) = rays.one(first_of(used), end, &above.bounds);
                let pace = Pace::OF_T;
                let mut visitor =
                    BlockByInstances { among, moved_alone, rays, used, pace, coherence, exempt, far };
                walk::<false, _>(&mut ray, above, stack, &mut visitor);
                continue;
            }
            let (common, pace) = rays.common(used, far);
            let mut beam = Beam::new(&common, &above.bounds);
            let mut visitor =
                BlockByInstances { among, moved_alone, rays, used, pace, coherence, exempt, far };
            walk::<false, _>(&mut beam, above, stack, &mut visitor);
        }
    }
}

struct ClosestInstance<'a> {
    among: Placed<'a>,
    rays: &'a Rays,
    used: u16,
    pace: Pace,
    coherence: Coherence,
    best: &'a mut HitPacket,
}

impl<P: Probe> Visitor<P> for ClosestInstance<'_> {
    #[inline(always)]
    fn visit(&mut self, probe: &mut P, leaf: u32, stack: &mut Vec<Open>) {
        let Self { used, coherence, .. } = *self;
        let instance = &self.among.instances.all[leaf as usize];
        let inside = self.rays.transformed(&instance.to_object, used);
        closest_of(instance.shown(self.among.meshes), &inside, used, coherence, self.best, stack);
        probe.end_at(self.pace.greatest(&self.best.t, used));
    }
}

struct BlockByInstances<'a> {
    among: Placed<'a>,
    moved_alone: bool,
    rays: &'a Rays,
    used: u16,
    pace: Pace,
    coherence: Coherence,
    exempt: Exempt<'a>,
    far: &'a mut [f32; LANES],
}

impl<P: Probe> Visitor<P> for BlockByInstances<'_> {
    #[inline(always)]
    fn visit(&mut self, probe: &mut P, leaf: u32, stack: &mut Vec<Open>) {
        let Self { used, coherence, exempt, .. } = *self;
        let instance = &self.among.instances.all[leaf as usize];
        if self.moved_alone && !instance.moved {
            return;
        }
        let inside = self.rays.transformed(&instance.to_object, used);
        let open = used & open_lanes(self.far);
        block(instance.shown(self.among.meshes), &inside, open, coherence, exempt, self.far, stack);
        probe.end_at(self.pace.greatest(self.far, used));
    }
}

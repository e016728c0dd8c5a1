//! Curved geometry that deforms: a scene is built of each shape, or of both between which it goes while an exposure lasts, from nothing: nothing of it
//! depends on what was rendered before.

use std::sync::Arc;

use embree::{BuildQuality, Device, FrozenScene, GeometryId, Scene as EmbreeScene};

use super::curved::MovingCurved;
use super::deforming::show;
use super::frozen::{Frozen, ROBUST, Source, freeze};
use crate::animation::{Chord, Shape};
use crate::geometry::Curved;
use crate::pose::Pose;
use crate::scene::Mesh;
use crate::trace::TraceError;

/// Model whose scenes follow its shapes.
pub struct DeformingCurves {
    model: usize,
    mesh: Arc<Mesh>,
    with_casters: bool,
    /// Instances among all movable models, and among those that cast shadows, if it has one there.
    instances: [Option<GeometryId>; 2],
    /// Shapes between which the instances go, or twice the one that they show; none after an error.
    shapes: Option<[Shape; 2]>,
    /// What the instances show while their scenes are changed.
    nothing: Arc<FrozenScene>,
}

/// Scenes of the first shape of a geometry, for the instances that place its model.
pub fn first(
    device: &Device,
    (mesh, rest): (&Mesh, &dyn Curved),
    with_casters: bool,
) -> Result<Frozen, TraceError> {
    let now = rest.between(&Chord::FIRST.ends, &[0.0]).pop();
    let now = now.ok_or_else(|| TraceError(String::from("what has no shapes does not deform")))?;
    freeze(device, mesh, &Source::Curved(&now), BuildQuality::Low, with_casters)
}

impl DeformingCurves {
    /// Creates a model, by its number, whose mesh has shapes, and which these instances place in the [first] of them.
    pub fn new(
        device: &Device,
        (model, mesh): (usize, &Arc<Mesh>),
        (with_casters, instances): (bool, [Option<GeometryId>; 2]),
    ) -> Result<Self, TraceError> {
        let nothing = EmbreeScene::new(device, BuildQuality::Low, ROBUST)?.freeze()?;
        Ok(Self {
            model,
            mesh: Arc::clone(mesh),
            with_casters,
            instances,
            shapes: Some(Chord::FIRST.ends),
            nothing,
        })
    }

    /// Takes the model to the shapes that it has in `pose`, if it is there. `movable`, `casters`: the scenes of its instances.
    pub fn deform(
        &mut self,
        device: &Device,
        movable: &mut EmbreeScene,
        casters: Option<&mut EmbreeScene>,
        pose: &Pose,
    ) -> Result<(), TraceError> {
        let place = &pose.models[self.model];
        let ends = place.shape.ends;
        let Some(rest) = self.mesh.as_curved() else { return Ok(()) };
        if !place.is_visible || self.shapes == Some(ends) {
            return Ok(());
        }
        self.shapes = None;
        let mut scenes = [Some(movable), casters];
        // the scene of the shape before goes before the next one is built
        show(self.instances, &mut scenes, [Some(&self.nothing); 2])?;
        let build =
            |source: &Source<'_>| freeze(device, &self.mesh, source, BuildQuality::Low, self.with_casters);
        let built: Option<Frozen> = if place.shape.is_still() {
            let now = rest.between(&ends, &[0.0]).pop();
            now.map(|now| build(&Source::Curved(&now))).transpose()?
        } else {
            let moving = MovingCurved::new(rest.as_ref(), &ends, pose.sweeps.groups());
            moving.map(|moving| build(&Source::Moving(&moving))).transpose()?
        };
        if let Some(Frozen { scene, casters, .. }) = &built {
            show(self.instances, &mut scenes, [Some(scene), casters.as_ref()])?;
        }
        self.shapes = Some(ends);
        Ok(())
    }
}

//! Sources of light, as surfaces weigh them: how strong each is, where, and where to it shines.

use glam::{DVec3, Vec3};

use crate::pose::{AreaShape, LightPose, LightShape, LightSource};
use crate::scene::Light;
use crate::scene::render_space::Extent;

/// Source of light, world space.
#[derive(Debug, Clone, Copy)]
pub struct Source {
    /// Irradiance of sources at infinity; intensity of others. Any unit that all have.
    pub(super) strength: f32,
    /// None for one at infinity.
    pub(super) place: Option<Vec3>,
    /// Distance from its place within which it is nowhere in particular: its size, or its way.
    pub(super) reach: f32,
    pub(super) aim: Aim,
}

/// Directions in which a source shines.
#[derive(Debug, Clone, Copy)]
pub(super) enum Aim {
    All,
    /// To one side of a panel, and less aside, by the cosine to its axis.
    Panel(Vec3),
    /// To both sides of what is flat, in the same way.
    Flat(Vec3),
    /// Within a cone about an axis, up to an angle of this cosine.
    Cone(Vec3, f32),
}

impl Source {
    /// Creates a source of this strength that shines to all sides, within `reach` of `place`.
    pub fn around(place: Vec3, reach: f32, strength: f32) -> Self {
        Self { strength, place: Some(place), reach, aim: Aim::All }
    }

    /// Has the source shine as what is flat does, with this axis (unit length).
    #[must_use]
    pub fn flat(self, axis: Vec3) -> Self {
        Self { aim: Aim::Flat(axis), ..self }
    }

    /// Looks at all frames of `light`.
    pub fn of_light(light: &Light) -> Self {
        let poses: Vec<LightPose> =
            light.frames().into_iter().map(|frame| LightPose::new(light, frame)).collect();
        let strength = poses.iter().map(|pose| pose.strength.max_element()).fold(0.0, f32::max);
        let places = poses.iter().filter_map(|pose| match pose.shape.source() {
            LightSource::Place(place) => Some(place),
            LightSource::Direction(_) => None,
        });
        let (low, high) = places.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), place| {
            (low.min(place), high.max(place))
        });
        let is_near = low.cmple(high).all();
        let size = poses.first().map_or(0.0, |pose| pose.shape.reach());
        let aim = match poses.first().map(|pose| pose.shape) {
            Some(shape) if poses.iter().any(|pose| pose.shape != shape) => Aim::All,
            Some(LightShape::Area(AreaShape::Rectangle { axis, .. } | AreaShape::Disk { axis, .. })) => {
                Aim::Panel(axis)
            }
            Some(
                LightShape::Spot { cone, .. } | LightShape::Area(AreaShape::Sphere { cone: Some(cone), .. }),
            ) => Aim::Cone(cone.axis, cone.cos_outer),
            _ => Aim::All,
        };
        Self {
            strength,
            place: is_near.then_some(0.5 * (low + high)),
            reach: if is_near { 0.5 * (high - low).length() + 0.5 * size } else { 0.0 },
            aim,
        }
    }

    /// Stands for several sources near each other, as one of what all send, somewhere among them; those at infinity, all of them or none,
    /// for one there.
    pub fn of_group(sources: &[Self]) -> Self {
        let strength = sources.iter().map(|source| source.strength).sum();
        let extent = sources.iter().filter_map(Self::place).fold(Extent::NONE, Extent::with);
        if sources.iter().all(|source| source.place.is_none()) {
            return Self { strength, place: None, reach: 0.0, aim: Aim::All };
        }
        let reach = sources.iter().map(|source| source.reach).fold(0.0, f32::max);
        let reach = reach + (0.25 * extent.diagonal()) as f32;
        let aim = axis_of(sources).map_or(Aim::All, Aim::Flat);
        Self { strength, place: Some(extent.center().as_vec3()), reach, aim }
    }

    /// What it sends, in any unit that all sources have.
    pub fn strength(&self) -> f32 {
        self.strength
    }

    /// Its place; none of one at infinity.
    pub fn place(&self) -> Option<DVec3> {
        self.place.map(|place| place.as_dvec3())
    }
}

/// Axis about which all sources shine as panels do, to either side, if they have one. (To one side alone, those of a group would shine on
/// nothing that is beyond its middle.)
fn axis_of(sources: &[Source]) -> Option<Vec3> {
    let axis = |source: &Source| match source.aim {
        Aim::Panel(axis) | Aim::Flat(axis) => Some(axis),
        Aim::All | Aim::Cone(..) => None,
    };
    let first = axis(sources.first()?)?;
    // of a slightly bent panel, too
    let has = |source: &Source| axis(source).is_some_and(|axis| axis.dot(first).abs() > 0.95);
    sources.iter().all(has).then_some(first)
}

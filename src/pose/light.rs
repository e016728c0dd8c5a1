//! Lights at one frame: places, shapes and strength, in world space.

use glam::{DVec3, Vec3};

use super::{looking_at, upright};
use crate::exposure::{Clock, TICKS, Tick};
use crate::scene::{Light, LightKind, Panel};

/// Light at one frame, world space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightPose {
    /// Part of the light that visibility depends on.
    pub shape: LightShape,
    /// Irradiance of a directional light and a sun; intensity of the others (of a rectangle and a disc along
    /// its axis). Linear RGB.
    pub strength: Vec3,
    /// Number of shadow rays that each sample sends to it: one to each of the points that stand for it, a
    /// grid of as many rows as columns.
    pub points: usize,
}

/// Part of a light that visibility depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LightShape {
    /// Point that shines all around.
    Point {
        /// Position, world space.
        position: Vec3,
    },
    /// Light from infinitely far away.
    Directional {
        /// Direction from the scene to the light, unit length.
        to_light: Vec3,
    },
    /// Point that shines within a cone.
    Spot {
        /// Position, world space.
        position: Vec3,
        /// The cone.
        cone: Cone,
    },
    /// Light with an area.
    Area(AreaShape),
}

/// Directions within which a light shines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Direction in which the light travels, unit length.
    pub axis: Vec3,
    /// Cosine of the half angle at which the light ends.
    pub cos_outer: f32,
    /// Cosine of the half angle up to which it is full.
    pub cos_inner: f32,
    /// Numbers a and b of the curve between them, from 0 to 1: t²(a - bt).
    pub curve: [f32; 2],
}

/// How the radiance of a panel falls with the angle to its axis: by its tangent, to nothing at half of the spread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Direction in which the light travels, unit length.
    pub axis: Vec3,
    /// 1 over the tangent of half of the spread.
    pub fall: f32,
}

/// Shape of a light with an area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AreaShape {
    /// Rectangle that shines to the side that its axis points to.
    Rectangle {
        /// Centre, world space.
        center: Vec3,
        /// Whole edge, horizontal where it can be.
        across: Vec3,
        /// Whole edge, at a right angle to the other.
        up: Vec3,
        /// Axis, unit length, at right angles to both.
        axis: Vec3,
        /// How it dims aside of its axis, if it does.
        spread: Option<Spread>,
    },
    /// Disc, or ellipse, that shines to the side that its axis points to.
    Disk {
        /// Centre, world space.
        center: Vec3,
        /// Vector from the centre to the rim.
        across: Vec3,
        /// Vector from the centre to the rim, at a right angle to the other.
        up: Vec3,
        /// Axis, unit length, at right angles to both.
        axis: Vec3,
        /// How it dims aside of its axis, if it does.
        spread: Option<Spread>,
    },
    /// Sphere that shines outwards.
    Sphere {
        /// Centre, world space.
        center: Vec3,
        /// Radius, world units.
        radius: f32,
        /// Directions to which alone it shines, if it is a spot.
        cone: Option<Cone>,
        /// True: it is a disc that faces whatever it lights.
        faces: bool,
    },
    /// Light from infinitely far away, from a cone of directions.
    Sun {
        /// Direction from the scene to the middle of the light, unit length.
        to_light: Vec3,
        /// Axis across the light, unit length.
        across: Vec3,
        /// Other axis across the light, unit length; the three are at right angles.
        up: Vec3,
        /// Versine of the cone's half angle: 1 less its cosine.
        versine: f32,
    },
}

/// Origin of light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LightSource {
    /// A place, world space; the middle of it, where it has an area.
    Place(Vec3),
    /// Infinitely far away: the direction from the scene to the middle of it, unit length.
    Direction(Vec3),
}

impl LightShape {
    /// Returns true if the light has an area.
    pub fn is_area(&self) -> bool {
        matches!(self, Self::Area(_))
    }

    /// Origin of the light.
    #[inline(always)]
    pub fn source(&self) -> LightSource {
        match *self {
            Self::Point { position } | Self::Spot { position, .. } => LightSource::Place(position),
            Self::Directional { to_light } => LightSource::Direction(to_light),
            Self::Area(area) => area.source(),
        }
    }

    /// Upper bound of the distance of its points from its centre, world units, or for a sun from the middle
    /// of its directions; 0 for lights that have no area.
    pub fn reach(&self) -> f32 {
        match self {
            Self::Area(area) => area.reach(),
            Self::Point { .. } | Self::Directional { .. } | Self::Spot { .. } => 0.0,
        }
    }

    /// Half the size of the box around its points, or directions, with the [source](Self::source) in the middle.
    pub fn half_extent(&self) -> Vec3 {
        match self {
            Self::Area(area) => area.half_extent(),
            Self::Point { .. } | Self::Directional { .. } | Self::Spot { .. } => Vec3::ZERO,
        }
    }
}

impl AreaShape {
    #[inline(always)]
    fn source(&self) -> LightSource {
        match *self {
            Self::Rectangle { center, .. } | Self::Disk { center, .. } | Self::Sphere { center, .. } => {
                LightSource::Place(center)
            }
            Self::Sun { to_light, .. } => LightSource::Direction(to_light),
        }
    }

    fn reach(&self) -> f32 {
        match self {
            Self::Rectangle { across, up, .. } => 0.5 * (across.length() + up.length()),
            Self::Disk { across, up, .. } => across.length().max(up.length()),
            Self::Sphere { radius, .. } => *radius,
            Self::Sun { versine, .. } => (2.0 * versine).sqrt(),
        }
    }

    fn half_extent(&self) -> Vec3 {
        match self {
            Self::Rectangle { across, up, .. } => 0.5 * (across.abs() + up.abs()),
            Self::Disk { across, up, .. } => across.abs() + up.abs(),
            Self::Sphere { .. } | Self::Sun { .. } => Vec3::splat(self.reach()),
        }
    }
}

impl LightPose {
    /// Returns true if it sends no light, for want of power or colour: no ray to it is worth casting.
    pub fn is_dark(&self) -> bool {
        self.strength == Vec3::ZERO
    }

    /// Lights at the ticks of a `moment` of `clock`, one list for each tick; none if all are as in its middle.
    pub fn at_ticks(lights: &[Light], clock: &Clock, moment: i64, middle: &[Self]) -> Vec<Vec<Self>> {
        if clock.is_instant() || lights.iter().all(Light::is_constant) {
            return Vec::new();
        }
        let at = |tick| {
            let time = clock.time_of_tick(moment, tick);
            lights.iter().map(|light| Self::new(light, time)).collect()
        };
        let ticks: Vec<Vec<Self>> = (0..TICKS as Tick).map(at).collect();
        if ticks.iter().all(|lights| lights == middle) { Vec::new() } else { ticks }
    }

    /// Light at `frame`.
    pub fn new(light: &Light, frame: f64) -> Self {
        let strength = light.color.at(frame) * light.power.at(frame) as f32;
        let shape = match &light.kind {
            LightKind::Point { position } => LightShape::Point { position: position.at(frame).as_vec3() },
            LightKind::Directional { direction } => LightShape::Directional {
                to_light: -direction.at(frame).try_normalize().unwrap_or(DVec3::NEG_Y).as_vec3(),
            },
            LightKind::Spot { position, target, cone, soft, fall, radius } => {
                let (position, target) = (position.at(frame), target.at(frame));
                let half = (cone.at(frame) * 0.5).to_radians();
                let cone = Cone {
                    axis: (target - position).try_normalize().unwrap_or(DVec3::NEG_Y).as_vec3(),
                    cos_outer: half.cos() as f32,
                    cos_inner: (half * (1.0 - soft.at(frame))).cos() as f32,
                    curve: fall.curve(),
                };
                let (position, radius) = (position.as_vec3(), radius.at(frame) as f32);
                match radius > 0.0 {
                    true => LightShape::Area(AreaShape::Sphere {
                        center: position,
                        radius,
                        cone: Some(cone),
                        faces: false,
                    }),
                    false => LightShape::Spot { position, cone },
                }
            }
            LightKind::Rectangle(panel) => {
                let (center, [across, up, axis], spread) = placed(panel, panel.size.at(frame), frame);
                LightShape::Area(AreaShape::Rectangle { center, across, up, axis, spread })
            }
            LightKind::Disk(panel) => {
                let radii = panel.size.at(frame).map(|diameter| 0.5 * diameter);
                let (center, [across, up, axis], spread) = placed(panel, radii, frame);
                LightShape::Area(AreaShape::Disk { center, across, up, axis, spread })
            }
            LightKind::Sphere { position, radius, faces } => LightShape::Area(AreaShape::Sphere {
                center: position.at(frame).as_vec3(),
                radius: radius.at(frame) as f32,
                cone: None,
                faces: *faces,
            }),
            LightKind::Sun { direction, angle } => {
                let axes = looking_at(-direction.at(frame), 0.0);
                let half_sine = (angle.at(frame) * 0.25).to_radians().sin();
                LightShape::Area(AreaShape::Sun {
                    to_light: -axes.z_axis.as_vec3(),
                    across: axes.x_axis.as_vec3(),
                    up: axes.y_axis.as_vec3(),
                    versine: (2.0 * half_sine * half_sine) as f32,
                })
            }
        };
        Self { shape, strength, points: light.points() }
    }
}

/// Centre of a panel, its axes (those across it have these lengths, that along which it shines has 1), and its spread.
fn placed(panel: &Panel, [width, height]: [f64; 2], frame: f64) -> (Vec3, [Vec3; 3], Option<Spread>) {
    let center = panel.position.at(frame);
    let axes = upright(panel.target.at(frame) - center, panel.up.at(frame));
    let axis = -axes.z_axis.as_vec3();
    let spread = panel.spread.at(frame);
    let spread = (spread < Panel::ALL_OF_ITS_SIDE)
        .then(|| Spread { axis, fall: (0.5 * spread).to_radians().tan().recip() as f32 });
    let edges = [(axes.x_axis * width).as_vec3(), (axes.y_axis * height).as_vec3(), axis];
    (center.as_vec3(), edges, spread)
}

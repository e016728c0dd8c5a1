//! Lights: keyed place, direction, colour and power.

use glam::{DVec3, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::links::LightLinks;
use crate::animation::{Keyed, Keys, Track};

/// One light of a shot.
#[derive(Debug, Clone, PartialEq)]
pub struct Light {
    /// Name in the shot.
    pub name: String,
    /// Shape, with its keyed values.
    pub kind: LightKind,
    /// Colour, linear RGB, unitless.
    pub color: Track<Vec3>,
    /// Irradiance for a directional light and a sun; intensity, which falls with the square of the distance,
    /// for the others; a rectangle's and a disc's falls with the cosine to its axis, too.
    pub power: Track<f64>,
    /// Shadow rays that each sample sends to it, in a grid as wide as high: 1, 4 or [`MOST_SAMPLES`](Self::MOST_SAMPLES). Of use
    /// for areas alone.
    pub samples: u32,
    /// Name of the light group, whose layer shows the contribution of its lights.
    pub group: Option<String>,
    /// Models that it lights, and that cast shadows in its light.
    pub links: LightLinks,
}

/// Curve by which a spot fades from where it is full to its rim, by the cosine of the angle to its axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum SpotFall {
    /// Smoothstep, as in Blender and USD.
    #[default]
    Smooth,
    /// The square, as glTF's KHR_lights_punctual recommends.
    Square,
}

impl SpotFall {
    /// Numbers a and b of the curve t²(a - bt), from 0 at the rim to 1.
    pub fn curve(self) -> [f32; 2] {
        match self {
            Self::Smooth => [3.0, 2.0],
            Self::Square => [1.0, 0.0],
        }
    }
}

/// Lights by group: in the order in which the shot names them first, and at last those of no group.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LightGroups {
    /// Names of the groups' layers, without their common prefix.
    pub names: Vec<String>,
    /// Index of each light's group.
    pub of: Vec<usize>,
}

impl LightGroups {
    /// Maximum number of groups, that of the other lights included: each takes three planes.
    pub const MOST: usize = 8;

    /// Name of the group of lights that have none.
    pub const OTHERS: &str = "others";

    /// Collects the groups of `lights`.
    pub fn new(lights: &[Light]) -> Self {
        let name = |light: &Light| light.group.clone().unwrap_or_else(|| Self::OTHERS.into());
        let (grouped, others): (Vec<_>, Vec<_>) = lights.iter().partition(|light| light.group.is_some());
        let mut names: Vec<String> = Vec::new();
        for name in grouped.into_iter().chain(others).map(name) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let number = |light| names.iter().position(|known| *known == name(light)).unwrap_or_default();
        Self { of: lights.iter().map(number).collect(), names }
    }
}

impl Light {
    /// Maximum number of shadow rays that a sample sends to a light, and the default.
    pub const MOST_SAMPLES: u32 = 16;

    /// Number of shadow rays that each sample sends to the light.
    pub fn points(&self) -> usize {
        if self.kind.is_area() { self.samples as usize } else { 1 }
    }

    /// Frames of all of its keys, in rising order; at least one.
    pub fn frames(&self) -> Vec<f64> {
        let mut frames: Vec<f64> = self.color.frames().chain(self.power.frames()).collect();
        frames.extend(self.kind.tracks().into_iter().flat_map(Track::frames));
        frames.extend(self.kind.lengths().into_iter().flat_map(Track::frames));
        frames.extend(self.kind.size().into_iter().flat_map(Track::frames));
        frames.sort_by(f64::total_cmp);
        frames.dedup();
        frames
    }

    /// Timing of everything that may change.
    pub fn keys(&self) -> Vec<&dyn Keys> {
        let mut keys: Vec<&dyn Keys> = vec![&self.color, &self.power];
        keys.extend(self.kind.tracks().into_iter().map(|track| track as &dyn Keys));
        keys.extend(self.kind.lengths().into_iter().map(|track| track as &dyn Keys));
        keys.extend(self.kind.size().map(|track| track as &dyn Keys));
        keys
    }

    /// Returns true if nothing of it ever changes.
    pub fn is_constant(&self) -> bool {
        self.keys().into_iter().all(|keys| keys.span().0 >= keys.span().1)
    }
}

/// The shape of a light.
#[derive(Debug, Clone, PartialEq)]
pub enum LightKind {
    /// A point that shines to all sides.
    Point {
        /// World space.
        position: Track<DVec3>,
    },
    /// Parallel light from infinitely far away.
    Directional {
        /// Direction in which the light travels; world space, any length but zero.
        direction: Track<DVec3>,
    },
    /// A point, or a sphere, that shines within a cone.
    Spot {
        /// World space.
        position: Track<DVec3>,
        /// World space.
        target: Track<DVec3>,
        /// Degrees of the whole cone, 0..180.
        cone: Track<f64>,
        /// The share of the cone's half angle, from its rim inwards, over which the light fades; 0..=1.
        soft: Track<f64>,
        /// Curve by which it fades there.
        fall: SpotFall,
        /// World units; always 0 for a point, and never for a sphere.
        radius: Track<f64>,
    },
    /// A rectangle that shines to one side. Like all areas it casts soft shadows and is seen in mirrors, but
    /// not by the camera.
    Rectangle(Panel),
    /// A disc, or an ellipse, that shines to one side.
    Disk(Panel),
    /// A sphere that shines outwards.
    Sphere {
        /// Its centre; world space.
        position: Track<DVec3>,
        /// World units.
        radius: Track<f64>,
        /// True: whatever it lights sees a disc of that radius that faces it, from within as well.
        faces: bool,
    },
    /// Light from infinitely far away, from all directions within a cone.
    Sun {
        /// Direction in which the light travels in the middle of the cone; world space, any length but zero.
        direction: Track<DVec3>,
        /// Degrees of the whole cone, 0..180.
        angle: Track<f64>,
    },
}

/// A flat light that shines to one side.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Its centre; world space.
    pub position: Track<DVec3>,
    /// The point that it faces; world space.
    pub target: Track<DVec3>,
    /// Direction in which its height points, as far as the target lets it; world space, any length but zero.
    pub up: Track<DVec3>,
    /// Width and height, world units.
    pub size: Track<[f64; 2]>,
    /// Degrees of the whole cone in which it shines, above 0; at [`ALL_OF_ITS_SIDE`](Self::ALL_OF_ITS_SIDE) nothing dims it.
    pub spread: Track<f64>,
}

impl Panel {
    /// Spread of a panel that shines to all of its side.
    pub const ALL_OF_ITS_SIDE: f64 = 180.0;

    /// A panel at rest that shines to all of its side, its height upwards.
    pub fn at_rest(position: DVec3, target: DVec3, size: [f64; 2]) -> Self {
        let [position, target, up] = [position, target, DVec3::Y].map(Track::constant);
        Self { position, target, up, size: size.into(), spread: Self::ALL_OF_ITS_SIDE.into() }
    }

    fn converted(self, point: impl Fn(DVec3) -> DVec3, scale: f64) -> Self {
        Self {
            position: self.position.map(&point),
            target: self.target.map(&point),
            size: self.size.map(|size| size.scaled(scale)),
            ..self
        }
    }
}

impl LightKind {
    /// Name for people.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Point { .. } => "point",
            Self::Directional { .. } => "directional",
            Self::Spot { .. } => "spot",
            Self::Rectangle(_) => "rectangle",
            Self::Disk(_) => "disk",
            Self::Sphere { .. } => "sphere",
            Self::Sun { .. } => "directional, soft",
        }
    }

    /// Returns true if the light is more than a point, so that shadows are soft.
    pub fn is_area(&self) -> bool {
        match self {
            Self::Rectangle(_) | Self::Disk(_) | Self::Sphere { .. } | Self::Sun { .. } => true,
            Self::Spot { radius, .. } => radius.values().any(|radius| radius > 0.0),
            Self::Point { .. } | Self::Directional { .. } => false,
        }
    }

    /// Tracks of the places and directions of the light.
    pub fn tracks(&self) -> Vec<&Track<DVec3>> {
        match self {
            Self::Point { position } | Self::Sphere { position, .. } => vec![position],
            Self::Directional { direction } | Self::Sun { direction, .. } => vec![direction],
            Self::Spot { position, target, .. } => vec![position, target],
            Self::Rectangle(Panel { position, target, up, .. })
            | Self::Disk(Panel { position, target, up, .. }) => {
                vec![position, target, up]
            }
        }
    }

    /// Tracks of the lengths and angles of the light.
    fn lengths(&self) -> Vec<&Track<f64>> {
        match self {
            Self::Point { .. } | Self::Directional { .. } => vec![],
            Self::Spot { cone, soft, radius, .. } => vec![cone, soft, radius],
            Self::Rectangle(panel) | Self::Disk(panel) => vec![&panel.spread],
            Self::Sphere { radius, .. } => vec![radius],
            Self::Sun { angle, .. } => vec![angle],
        }
    }

    /// Track of the width and height of a panel.
    fn size(&self) -> Option<&Track<[f64; 2]>> {
        match self {
            Self::Rectangle(panel) | Self::Disk(panel) => Some(&panel.size),
            _ => None,
        }
    }

    /// Converts the light to another space, in which a point is `point` of itself and lengths are `scale` times as long. Returns also the
    /// factor on its power there: what falls with the square of the distance is stronger at larger ones.
    pub(crate) fn converted(self, point: impl Fn(DVec3) -> DVec3, scale: f64) -> (Self, f64) {
        let place = |track: Track<DVec3>| track.map(&point);
        let kind = match self {
            Self::Point { position } => Self::Point { position: place(position) },
            Self::Spot { position, target, cone, soft, fall, radius } => Self::Spot {
                position: place(position),
                target: place(target),
                cone,
                soft,
                fall,
                radius: radius.map(|radius| radius * scale),
            },
            Self::Rectangle(panel) => Self::Rectangle(panel.converted(point, scale)),
            Self::Disk(panel) => Self::Disk(panel.converted(point, scale)),
            Self::Sphere { position, radius, faces } => {
                Self::Sphere { position: place(position), radius: radius.map(|radius| radius * scale), faces }
            }
            directional @ (Self::Directional { .. } | Self::Sun { .. }) => return (directional, 1.0),
        };
        (kind, scale * scale)
    }
}

//! Lights of files, as the tables that a shot file has for them.

use glam::{DAffine3, DVec3};

use crate::scene::keys::toml_text::{At, List, Three};
use crate::scene::keys::{LightKey, LightTable, LightType};

/// Largest cone of a spot, degrees.
pub const WIDEST: f64 = 179.9;

/// Place of a light that shines along -Z of its node.
#[derive(Default)]
struct Place {
    direction: Option<Three>,
    position: Option<Three>,
    target: Option<Three>,
    up: Option<Three>,
}

impl Place {
    fn of(kind: LightType, map: &DAffine3) -> Self {
        let (at, along) = (map.translation, (-map.matrix3.z_axis).normalize_or(DVec3::NEG_Y));
        let (position, target) = (Some(three(at)), Some(three(at + along)));
        match kind {
            LightType::Directional => Self { direction: Some(three(along)), ..Self::default() },
            LightType::Point | LightType::Sphere => Self { position, ..Self::default() },
            LightType::Spot => Self { position, target, ..Self::default() },
            LightType::Rectangle | LightType::Disk => {
                let up = map.matrix3.y_axis.normalize_or(DVec3::Y);
                Self { position, target, up: Some(three(up)), direction: None }
            }
        }
    }
}

/// A vector, or a colour.
pub fn three(vector: DVec3) -> Three {
    At::of(List(vector.to_array()))
}

/// A light of this kind at rest: all that is not its place is left to the default.
pub fn at_rest(name: &str, kind: LightType, map: &DAffine3) -> LightTable {
    table(name, kind, Place::of(kind, map), Vec::new())
}

/// A light of this kind that keys place.
pub fn keyed(name: &str, kind: LightType, keys: impl Iterator<Item = LightKey>) -> LightTable {
    table(name, kind, Place::default(), keys.map(At::of).collect())
}

/// Place of a light of this kind at a frame.
pub fn key(frame: f64, kind: LightType, map: &DAffine3) -> LightKey {
    let Place { direction, position, target, up } = Place::of(kind, map);
    LightKey {
        frame: At::of(frame),
        position,
        direction,
        target,
        up,
        cone: None,
        soft: None,
        size: None,
        spread: None,
        radius: None,
        angle: None,
        color: None,
        power: None,
    }
}

fn table(name: &str, kind: LightType, place: Place, key: Vec<At<LightKey>>) -> LightTable {
    let Place { direction, position, target, up } = place;
    LightTable {
        name: Some(String::from(name)),
        kind,
        direction,
        position,
        target,
        up,
        cone: None,
        soft: None,
        fall: None,
        size: None,
        spread: None,
        radius: None,
        faces: None,
        angle: None,
        samples: None,
        group: None,
        light_link: None,
        shadow_link: None,
        color: None,
        power: None,
        interpolation: Default::default(),
        key,
    }
}

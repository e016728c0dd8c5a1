//! The lights of a shot: their keys, read into tracks. Each message points at the value's own place.

use glam::{DVec3, Vec3};

use super::links;
use super::tracks::{frames_between, in_order, or, through_or};
use crate::animation::Track;
use crate::scene::keys::toml_text::{At, List, Three, TomlText};
use crate::scene::keys::{LightKey, LightTable, LightType};
use crate::scene::{Light, LightGroups, LightKind, Panel, SceneError, SpotFall};

/// Minimum angle of a directional light, degrees: smaller ones count as points, or their directions would
/// differ by less than rounding.
const LEAST_ANGLE: f64 = 1e-3;

/// Minimum length of a light's edge or radius.
const LEAST_LENGTH: f64 = 1e-9;

/// Numbers that a key of a light may have.
#[derive(Clone, Copy)]
struct Range {
    key: &'static str,
    /// The range, for messages.
    wanted: &'static str,
    fits: fn(f64) -> bool,
}

impl Range {
    /// Message about a curve that leaves the range between keys that are within.
    fn overshoots(&self, frame: f64) -> String {
        format!(
            "the smooth curve of `{}` leaves what is allowed ({}) at frame {frame}: add a key there",
            self.key, self.wanted
        )
    }
}

const ANGLE: Range = Range {
    key: "angle",
    wanted: "from 0 to below 180 degrees",
    fits: |angle| (0.0..180.0).contains(&angle),
};
const CONE: Range =
    Range { key: "cone", wanted: "between 0 and 180 degrees", fits: |cone| cone > 0.0 && cone < 180.0 };
const SOFT: Range = Range { key: "soft", wanted: "from 0 to 1", fits: |soft| (0.0..=1.0).contains(&soft) };
const SPREAD: Range =
    Range { key: "spread", wanted: "from 1 to 180 degrees", fits: |spread| (1.0..=180.0).contains(&spread) };
const RADIUS: Range = Range {
    key: "radius",
    wanted: "a length from 1e-9 to 1e9",
    fits: |radius| (LEAST_LENGTH..=1e9).contains(&radius),
};
const RADIUS_OR_POINT: Range = Range {
    key: "radius",
    wanted: "0, or a length from 1e-9 to 1e9",
    fits: |radius| radius == 0.0 || (RADIUS.fits)(radius),
};

/// Maximum power of a light: in any colour it is finite in single floats, and so is the radiance of a small
/// light.
const MOST_POWER: f64 = 1e30;

/// Requirement for a power, for messages.
const POWER: &str = "finite, not negative, and 1e30 at most";

/// Reads a light; `number` counts from 1, for those without a name.
pub fn of_table(text: TomlText<'_>, table: &At<LightTable>, number: usize) -> Result<Light, SceneError> {
    let (light, span) = (table.get_ref(), table.span());
    refuse_foreign_keys(text, light)?;
    let keys = in_order(text, &light.key, |key| &key.frame)?;
    let how = light.interpolation;
    let vector = |key: &str, value: &Three| text.vector(key, value);
    let color = or(&light.color, "color", Vec3::ONE, |key, value| text.color(key, value))?;
    let watts = |key: &str, value: &At<f64>| {
        text.number(key, value, POWER, |power| (0.0..=MOST_POWER).contains(&power))
    };
    let power = or(&light.power, "power", 1.0, watts)?;
    let place = |key: &str, constant: &Option<Three>, keyed: fn(&LightKey) -> &Option<Three>| {
        let all_keyed = !keys.is_empty() && keys.iter().all(|(_, entry)| keyed(entry.get_ref()).is_some());
        if constant.is_none() && !all_keyed {
            return Err(text.fault(span.clone(), format!("this light needs the key `{key}`")));
        }
        let rest = or(constant, key, DVec3::ZERO, vector)?;
        through_or(rest, &keys, how, |entry| or(keyed(entry), key, rest, vector))
    };
    let keyed_number = |range: &Range,
                        constant: &Option<At<f64>>,
                        default: f64,
                        keyed: fn(&LightKey) -> &Option<At<f64>>| {
        let read = |key: &str, value: &At<f64>| text.number(key, value, range.wanted, range.fits);
        let rest = or(constant, range.key, default, read)?;
        let track = through_or(rest, &keys, how, |entry| or(keyed(entry), range.key, rest, read))?;
        match frames_between(&keys).find(|frame| !(range.fits)(track.at(*frame))) {
            Some(frame) => Err(text.fault(span.clone(), range.overshoots(frame))),
            None => Ok(track),
        }
    };
    let kind = match light.kind {
        LightType::Directional => {
            let keyed = light.key.iter().filter_map(|key| key.get_ref().direction.as_ref());
            refuse_zeros(text, "direction", light.direction.iter().chain(keyed))?;
            let direction = place("direction", &light.direction, |key| &key.direction)?;
            let angle = keyed_number(&ANGLE, &light.angle, 0.0, |key| &key.angle)?;
            // narrower angles cannot be told from a point
            let has_size = angle.values().any(|angle| angle > LEAST_ANGLE);
            match has_size {
                true => LightKind::Sun { direction, angle: angle.map(|angle| angle.max(LEAST_ANGLE)) },
                false => LightKind::Directional { direction },
            }
        }
        LightType::Point => {
            LightKind::Point { position: place("position", &light.position, |key| &key.position)? }
        }
        LightType::Spot => {
            let radius = keyed_number(&RADIUS_OR_POINT, &light.radius, 0.0, |key| &key.radius)?;
            let is_point = radius.values().all(|radius| radius == 0.0);
            LightKind::Spot {
                position: place("position", &light.position, |key| &key.position)?,
                target: place("target", &light.target, |key| &key.target)?,
                cone: keyed_number(&CONE, &light.cone, 45.0, |key| &key.cone)?,
                soft: keyed_number(&SOFT, &light.soft, 0.0, |key| &key.soft)?,
                fall: light.fall.as_ref().map_or(SpotFall::default(), |fall| *fall.get_ref()),
                radius: if is_point { radius } else { radius.map(|radius| radius.max(LEAST_LENGTH)) },
            }
        }
        LightType::Rectangle | LightType::Disk => {
            let panel = Panel {
                position: place("position", &light.position, |key| &key.position)?,
                target: place("target", &light.target, |key| &key.target)?,
                up: {
                    let keyed = light.key.iter().filter_map(|key| key.get_ref().up.as_ref());
                    refuse_zeros(text, "up", light.up.iter().chain(keyed))?;
                    let rest = or(&light.up, "up", DVec3::Y, vector)?;
                    through_or(rest, &keys, how, |key| or(&key.up, "up", rest, vector))?
                },
                size: size(text, light, &keys)?,
                spread: keyed_number(&SPREAD, &light.spread, Panel::ALL_OF_ITS_SIDE, |key| &key.spread)?,
            };
            if light.kind == LightType::Disk { LightKind::Disk(panel) } else { LightKind::Rectangle(panel) }
        }
        LightType::Sphere => LightKind::Sphere {
            position: place("position", &light.position, |key| &key.position)?,
            radius: keyed_number(&RADIUS, &light.radius, 0.5, |key| &key.radius)?,
            faces: light.faces.as_ref().is_some_and(|faces| *faces.get_ref()),
        },
    };
    if let LightKind::Spot { position, target, .. }
    | LightKind::Rectangle(Panel { position, target, .. })
    | LightKind::Disk(Panel { position, target, .. }) = &kind
    {
        let mut frames = keys.iter().map(|(frame, _)| *frame).chain([0.0]);
        if frames.any(|frame| position.at(frame) == target.at(frame)) {
            return Err(
                text.fault(span, "`position` and `target` of this light are the same point: move one")
            );
        }
    }
    let samples = or(&light.samples, "samples", Light::MOST_SAMPLES, |key, value| {
        let samples = *value.get_ref();
        let fits = [1, 4, Light::MOST_SAMPLES].contains(&samples);
        fits.then_some(samples).ok_or_else(|| text.bad(key, value, "must be 1, 4 or 16"))
    })?;
    Ok(Light {
        name: light.name.clone().unwrap_or_else(|| format!("light {number}")),
        kind,
        color: through_or(color, &keys, how, |key| or(&key.color, "color", color, |k, v| text.color(k, v)))?,
        power: through_or(power, &keys, how, |key| or(&key.power, "power", power, watts))?,
        samples,
        group: light.group.as_ref().map(|group| links::group_name(text, "group", group)).transpose()?,
        links: links::of_table(text, &light.light_link, &light.shadow_link)?,
    })
}

/// Checks that there are not too many groups, and that each light of a group has a name of its own in it.
pub fn check_groups(
    text: TomlText<'_>,
    tables: &[At<LightTable>],
    lights: &[Light],
) -> Result<(), SceneError> {
    let groups = LightGroups::new(lights);
    for (number, (table, light)) in tables.iter().zip(lights).enumerate() {
        let Some(group) = &light.group else { continue };
        if groups.of[number] >= LightGroups::MOST - 1 {
            let message = format!("more than {} groups of lights: use fewer", LightGroups::MOST - 1);
            return Err(text.fault(table.span(), message));
        }
        let is_same = |other: &&Light| other.group == light.group && other.name == light.name;
        if lights[..number].iter().any(|other| is_same(&other)) {
            let message = format!("two lights `{}` in the group `{group}`: rename one", light.name);
            return Err(text.fault(table.span(), message));
        }
    }
    Ok(())
}

/// Reads the width and height of a panel, at rest or at each key.
fn size(
    text: TomlText<'_>,
    light: &LightTable,
    keys: &[(f64, &At<LightKey>)],
) -> Result<Track<[f64; 2]>, SceneError> {
    let either = |size: &Option<At<List<f64, 2>>>, radius: &Option<At<f64>>| match (size, radius) {
        (Some(size), Some(_)) => {
            Err(text.bad("size", size, "and `radius` exclude each other: keep one of them"))
        }
        (Some(size), None) => edges(text, "size", size).map(Some),
        (None, Some(radius)) => {
            let radius = text.number(RADIUS.key, radius, RADIUS.wanted, RADIUS.fits)?;
            Ok(Some([2.0 * radius; 2]))
        }
        (None, None) => Ok(None),
    };
    let rest = either(&light.size, &light.radius)?.unwrap_or([1.0; 2]);
    let track = through_or(rest, keys, light.interpolation, |key| {
        Ok(either(&key.size, &key.radius)?.unwrap_or(rest))
    })?;
    match frames_between(keys).find(|frame| !track.at(*frame).iter().all(|edge| (RADIUS.fits)(*edge))) {
        Some(frame) => Err(text.fault(keys[0].1.span(), Range { key: "size", ..RADIUS }.overshoots(frame))),
        None => Ok(track),
    }
}

/// Reads the edges of a panel.
fn edges(text: TomlText<'_>, key: &str, value: &At<List<f64, 2>>) -> Result<[f64; 2], SceneError> {
    let List(edges) = *value.get_ref();
    let fits = edges.iter().all(|edge| (RADIUS.fits)(*edge));
    fits.then_some(edges).ok_or_else(|| text.bad(key, value, "must be two lengths from 1e-9 to 1e9"))
}

/// Refuses keys that the light's type does not use: they are probably a mistake about the type.
fn refuse_foreign_keys(text: TomlText<'_>, light: &LightTable) -> Result<(), SceneError> {
    let (kind, allowed): (_, &[&str]) = match light.kind {
        LightType::Directional => ("directional", &["direction", "angle", "samples"]),
        LightType::Point => ("point", &["position"]),
        LightType::Spot => ("spot", &["position", "target", "cone", "soft", "fall", "radius", "samples"]),
        LightType::Rectangle => ("rectangle", &["position", "target", "up", "size", "spread", "samples"]),
        LightType::Disk => ("disk", &["position", "target", "up", "radius", "size", "spread", "samples"]),
        LightType::Sphere => ("sphere", &["position", "radius", "faces", "samples"]),
    };
    let span = |value: &Option<Three>| value.as_ref().map(At::span);
    let number = |value: &Option<At<f64>>| value.as_ref().map(At::span);
    let mut stated = vec![
        ("direction", span(&light.direction)),
        ("position", span(&light.position)),
        ("target", span(&light.target)),
        ("up", span(&light.up)),
        ("cone", number(&light.cone)),
        ("soft", number(&light.soft)),
        ("fall", light.fall.as_ref().map(At::span)),
        ("size", light.size.as_ref().map(At::span)),
        ("radius", number(&light.radius)),
        ("faces", light.faces.as_ref().map(At::span)),
        ("spread", number(&light.spread)),
        ("angle", number(&light.angle)),
        ("samples", light.samples.as_ref().map(At::span)),
    ];
    for key in light.key.iter().map(At::get_ref) {
        let places = [
            ("direction", &key.direction),
            ("position", &key.position),
            ("target", &key.target),
            ("up", &key.up),
        ];
        stated.extend(places.map(|(name, value)| (name, span(value))));
        let numbers = [
            ("cone", &key.cone),
            ("soft", &key.soft),
            ("radius", &key.radius),
            ("spread", &key.spread),
            ("angle", &key.angle),
        ];
        stated.extend(numbers.map(|(name, value)| (name, number(value))));
        stated.push(("size", key.size.as_ref().map(At::span)));
    }
    let foreign = |(name, span): (&'static str, Option<_>)| span.map(|span| (name, span));
    match stated.into_iter().filter_map(foreign).find(|(name, _)| !allowed.contains(name)) {
        None => Ok(()),
        Some((name, span)) => {
            let message = format!(
                "a {kind} light has no `{name}`: it takes {} beside color and power",
                allowed.join(", ")
            );
            Err(text.fault(span, message))
        }
    }
}

/// Refuses zero among the vectors of a key, which say a direction.
fn refuse_zeros<'a>(
    text: TomlText<'_>,
    key: &str,
    mut vectors: impl Iterator<Item = &'a Three>,
) -> Result<(), SceneError> {
    match vectors.find(|vector| vector.get_ref().0 == [0.0; 3]) {
        Some(zero) => Err(text.bad(key, zero, "must not be zero: it says in which direction")),
        None => Ok(()),
    }
}

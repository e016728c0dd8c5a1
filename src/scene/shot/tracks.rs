//! Reads the keys of cameras and lights in a shot file into tracks, with the checks that all keys have in
//! common. Each message points at the value's own place.

use glam::{DVec3, Vec3};

use super::{lens, orbit};
use crate::animation::track::Keyed;
use crate::animation::{Interpolation, Track};
use crate::scene::camera::{Aim, Lens, Projection};
use crate::scene::keys::camera::{CameraKey, CameraTable};
use crate::scene::keys::toml_text::{At, List, Three, TomlText};
use crate::scene::keys::{LightKey, LightTable, LightType};
use crate::scene::{CameraTrack, Light, LightGroups, LightKind, Panel, SceneError, SpotFall};

/// Default vertical field of view if no key states one, degrees.
const DEFAULT_FOV: f64 = 40.0;
/// Bounds of the height of an orthographic camera's view, in the units of the files.
const LEAST_HEIGHT: f64 = 1e-18;
const GREATEST_HEIGHT: f64 = 1e18;
/// Maximum shift of a lens, in either direction, as a share of the picture's longer side.
const FARTHEST_SHIFT: f64 = 100.0;
/// Maximum number of frames that are checked one by one for values that curves overshoot.
const MOST_FRAMES_LOOKED_AT: f64 = 100_000.0;

/// Reads the camera of a shot; `marked`: frames at which the shot says that it cuts.
pub(crate) fn camera(
    text: TomlText<'_>,
    table: &At<CameraTable>,
    marked: &[i32],
) -> Result<CameraTrack, SceneError> {
    let keys = in_order(text, &table.get_ref().key, |key| &key.frame)?;
    let Some((_, first)) = keys.first() else {
        let message = "the camera has no keys: write one [[camera.key]] with frame, eye and target at least";
        return Err(text.fault(table.span(), message));
    };
    let by_target = first.get_ref().target.is_some();
    let interpolation = table.get_ref().interpolation.unwrap_or_default();
    let cuts = cuts(text, &keys, marked)?;
    let fov = fields_of_view(text, &keys)?;
    let is_orthographic = table.get_ref().projection == Some(Projection::Orthographic);
    let height = if is_orthographic { Some(heights(text, &keys)?) } else { None };
    let shift = shifts(text, &keys)?;
    refuse_other_lens(text, &keys, is_orthographic)?;
    let opening = lens::opening(text, &keys, is_orthographic)?;
    let [near, far] = lens::clip(text, &keys)?;
    let cut_frames: Vec<f64> = cuts.iter().map(|frame| f64::from(*frame)).collect();
    let aim = each(&keys, |key| aim_of(text, key, by_target))?;
    let roll = each(&keys, |key| key.roll.as_ref().map_or(Ok(0.0), |roll| any_number(text, "roll", roll)))?;
    if let Some(roll) = keys.iter().find_map(|(_, key)| key.get_ref().roll.as_ref()).filter(|_| !by_target) {
        return Err(text.bad(
            "roll",
            roll,
            "goes with `target`: with `rotation`, give it as the third number",
        ));
    }
    let aim = through(aim, interpolation).cut_at(&cut_frames);
    let eye = if keys.iter().any(|(_, key)| key.get_ref().orbit.is_some()) {
        let around = through(each(&keys, |key| orbit::of_key(text, key))?, interpolation).cut_at(&cut_frames);
        orbit::eye(text, &keys, (around, aim.clone()))?
    } else {
        let target = by_target.then_some(&aim);
        through(eyes(text, &keys, target)?, interpolation).cut_at(&cut_frames).into()
    };
    let track = CameraTrack {
        eye,
        aim: if by_target {
            Aim::Target { target: aim, roll: through(roll, interpolation).cut_at(&cut_frames) }
        } else {
            Aim::Rotation(aim)
        },
        fov: through(fov, interpolation).cut_at(&cut_frames),
        lens: Lens {
            height: height.map(|height| through(height, interpolation).cut_at(&cut_frames)),
            shift: shift.map(|shift| through(shift, interpolation).cut_at(&cut_frames)),
            aperture: opening.aperture.map(|keys| through(keys, interpolation).cut_at(&cut_frames)),
            focus: opening.focus.map(|keys| through(keys, interpolation).cut_at(&cut_frames)),
            near: near.map(|keys| through(keys, interpolation).cut_at(&cut_frames)),
            far: far.map(|keys| through(keys, interpolation).cut_at(&cut_frames)),
        },
        cuts,
    };
    let wide = |frame| !(track.fov.at(frame) > 0.0 && track.fov.at(frame) < 180.0);
    if let Some(frame) = frames_between(&keys).find(|frame| wide(*frame)) {
        let message = format!("the smooth curve of `fov` leaves 0..180 at frame {frame}: add a key there");
        return Err(text.fault(table.span(), message));
    }
    if let Some(frame) = frames_between(&keys).find(|frame| track.lens.sees_nothing(*frame)) {
        let message = format!(
            "the smooth curves of `near` and `far` leave nothing between them at frame {frame}: add a key there"
        );
        return Err(text.fault(table.span(), message));
    }
    let flat = |frame| track.lens.height.as_ref().is_some_and(|height| height.at(frame) < LEAST_HEIGHT);
    if let Some(frame) = frames_between(&keys).find(|frame| flat(*frame)) {
        let message =
            format!("the smooth curve of `height` falls to 0 or below at frame {frame}: add a key there");
        return Err(text.fault(table.span(), message));
    }
    Ok(track)
}

/// Reads the positions that keys give the eye, which looks at `target` if there is one.
fn eyes(
    text: TomlText<'_>,
    keys: &[(f64, &At<CameraKey>)],
    target: Option<&Track<DVec3>>,
) -> Result<Vec<(f64, DVec3)>, SceneError> {
    let place = |(frame, key): &(f64, &At<CameraKey>)| {
        let missing =
            || text.fault(key.span(), "this camera key needs `eye`, or `orbit`: where the camera is");
        let stated = key.get_ref().eye.as_ref().ok_or_else(missing)?;
        let eye = text.vector("eye", stated)?;
        if target.is_some_and(|target| target.at(*frame) == eye) {
            return Err(text.bad("eye", stated, "and `target` are the same point: move one of them"));
        }
        Ok((*frame, eye))
    };
    keys.iter().map(place).collect()
}

/// Frames at which the shot cuts, in order: those that keys begin, and those that are `marked`.
fn cuts(text: TomlText<'_>, keys: &[(f64, &At<CameraKey>)], marked: &[i32]) -> Result<Vec<i32>, SceneError> {
    let mut cuts = marked.to_vec();
    for (frame, key) in keys.iter().filter(|(_, key)| key.get_ref().cut) {
        if frame.fract() != 0.0 {
            let message = format!("is {frame}: a cut falls on a whole frame");
            return Err(text.bad("frame", &key.get_ref().frame, &message));
        }
        cuts.push(*frame as i32);
    }
    cuts.sort_unstable();
    cuts.dedup();
    Ok(cuts)
}

/// Minimum field of view, degrees: below it, single floats cannot tell the directions of neighbouring samples
/// apart.
const LEAST_FOV: f64 = 1e-6;

/// Requirement for a field of view, for messages.
const FOV: &str = "from 1e-6 to below 180 degrees";

fn fields_of_view(text: TomlText<'_>, keys: &[(f64, &At<CameraKey>)]) -> Result<Vec<(f64, f64)>, SceneError> {
    let mut last = DEFAULT_FOV;
    each(keys, |key| {
        if let Some(fov) = &key.fov {
            last = text.number("fov", fov, FOV, |fov| (LEAST_FOV..180.0).contains(&fov))?;
        }
        Ok(last)
    })
}

/// Reads the height of an orthographic camera's view at each key.
fn heights(text: TomlText<'_>, keys: &[(f64, &At<CameraKey>)]) -> Result<Vec<(f64, f64)>, SceneError> {
    let mut last = None;
    each(keys, |key| {
        if let Some(height) = &key.height {
            let wanted = "from 1e-18 to 1e18, in the units of the models";
            last = Some(text.number("height", height, wanted, |height| {
                (LEAST_HEIGHT..=GREATEST_HEIGHT).contains(&height)
            })?);
        }
        last.ok_or_else(|| {
            let message = "this key of an orthographic camera needs `height`: how much of the world is seen from the top of \
                           the picture to its bottom";
            text.fault(key.frame.span(), message)
        })
    })
}

/// Reads the lens shift to the right and upwards, at each key.
fn shifts(text: TomlText<'_>, keys: &[(f64, &At<CameraKey>)]) -> Result<[Vec<(f64, f64)>; 2], SceneError> {
    let mut last = [0.0; 2];
    let both = each(keys, |key| {
        if let Some(shift) = &key.shift {
            last = shift.get_ref().0;
            if !last.iter().all(|shift| shift.abs() <= FARTHEST_SHIFT) {
                let message = "must be two numbers from -100 to 100: shares of the picture's longer side";
                return Err(text.bad("shift", shift, message));
            }
        }
        Ok(last)
    })?;
    Ok([0, 1].map(|axis| both.iter().map(|(frame, shift)| (*frame, shift[axis])).collect()))
}

/// Refuses keys that describe the other projection.
fn refuse_other_lens(
    text: TomlText<'_>,
    keys: &[(f64, &At<CameraKey>)],
    is_orthographic: bool,
) -> Result<(), SceneError> {
    for (_, key) in keys {
        let key = key.get_ref();
        if let Some(fov) = key.fov.as_ref().filter(|_| is_orthographic) {
            return Err(text.bad(
                "fov",
                fov,
                "goes with a perspective camera: an orthographic one has `height`",
            ));
        }
        if let Some(height) = key.height.as_ref().filter(|_| !is_orthographic) {
            let message =
                "goes with `projection = \"orthographic\"` in [camera]: a perspective camera has `fov`";
            return Err(text.bad("height", height, message));
        }
    }
    Ok(())
}

fn aim_of(text: TomlText<'_>, key: &CameraKey, by_target: bool) -> Result<DVec3, SceneError> {
    match (&key.target, &key.rotation) {
        (Some(target), None) if by_target => text.vector("target", target),
        (None, Some(rotation)) if !by_target => text.vector("rotation", rotation),
        (None, None) => {
            let message = "this camera key needs `target` (a point) or `rotation` (pitch, yaw, roll)";
            Err(text.fault(key.frame.span(), message))
        }
        (Some(_), Some(rotation)) => {
            Err(text.bad("rotation", rotation, "and `target` exclude each other: keep one of them"))
        }
        (Some(other), None) | (None, Some(other)) => {
            let message = "the keys of a camera have either all `target` or all `rotation`";
            Err(text.fault(other.span(), message))
        }
    }
}

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
pub(crate) fn light(text: TomlText<'_>, table: &At<LightTable>, number: usize) -> Result<Light, SceneError> {
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
        group: light.group.as_ref().map(|group| group_name(text, group)).transpose()?,
    })
}

/// Reads the name of a group, which becomes a part of channel names.
fn group_name(text: TomlText<'_>, group: &At<String>) -> Result<String, SceneError> {
    /// Maximum length: names of channels end at 31 letters, for old readers, `light_` and `.R` included.
    const LONGEST: usize = 23;
    let name = group.get_ref();
    if name == LightGroups::OTHERS {
        return Err(text.bad(
            "group",
            group,
            "is the name of the group of all lights that state none: choose another",
        ));
    }
    let is_plain = name.chars().all(|letter| letter.is_ascii_alphanumeric() || matches!(letter, '-' | '_'));
    let fits = (1..=LONGEST).contains(&name.len()) && is_plain;
    fits.then(|| name.clone())
        .ok_or_else(|| text.bad("group", group, "must be 1 to 23 letters, digits, `-` and `_`"))
}

/// Checks that there are not too many groups, and that each light of a group has a name of its own in it.
pub(crate) fn check_groups(
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
        LightType::Sphere => ("sphere", &["position", "radius", "samples"]),
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

/// Sorts keys by frame. No two may share one.
pub fn in_order<'a, K>(
    text: TomlText<'_>,
    keys: &'a [At<K>],
    frame: impl Fn(&K) -> &At<f64>,
) -> Result<Vec<(f64, &'a At<K>)>, SceneError> {
    let fits = |frame: f64| frame.abs() <= f64::from(i32::MAX);
    let mut ordered = Vec::new();
    for key in keys {
        ordered.push((text.number("frame", frame(key.get_ref()), "a frame's number", fits)?, key));
    }
    ordered.sort_by(|a, b| a.0.total_cmp(&b.0));
    match ordered.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        Some(pair) => {
            let message = format!("is {}: there is another key at this frame already", pair[1].0);
            Err(text.bad("frame", frame(pair[1].1.get_ref()), &message))
        }
        None => Ok(ordered),
    }
}

/// Computes one value for each key.
fn each<K, T>(
    keys: &[(f64, &At<K>)],
    mut value: impl FnMut(&K) -> Result<T, SceneError>,
) -> Result<Vec<(f64, T)>, SceneError> {
    keys.iter().map(|(frame, key)| Ok((*frame, value(key.get_ref())?))).collect()
}

/// Returns the stated value, or `default`.
pub fn or<V, T>(
    stated: &Option<V>,
    key: &str,
    default: T,
    read: impl Fn(&str, &V) -> Result<T, SceneError>,
) -> Result<T, SceneError> {
    stated.as_ref().map_or(Ok(default), |value| read(key, value))
}

fn any_number(text: TomlText<'_>, key: &str, value: &At<f64>) -> Result<f64, SceneError> {
    text.number(key, value, "finite", |_| true)
}

fn through<T: Keyed>(keys: Vec<(f64, T)>, interpolation: Interpolation) -> Track<T> {
    Track::through(keys, interpolation).expect("keys are there, in order, no two at a frame")
}

/// Creates a track through one value a key, or, without keys, at rest.
pub fn through_or<K, T: Keyed>(
    rest: T,
    keys: &[(f64, &At<K>)],
    interpolation: Interpolation,
    value: impl Fn(&K) -> Result<T, SceneError>,
) -> Result<Track<T>, SceneError> {
    let values = each(keys, value)?;
    Ok(if values.is_empty() { Track::constant(rest) } else { through(values, interpolation) })
}

/// Whole frames from the first key to the last; of very long tracks the first ones.
pub fn frames_between<K>(keys: &[(f64, K)]) -> impl Iterator<Item = f64> {
    let (first, last) =
        (keys.first().map_or(0.0, |(frame, _)| *frame), keys.last().map_or(-1.0, |(frame, _)| *frame));
    whole_frames(first, last)
}

/// Whole frames about `first` to `last`; of very many the first ones.
pub fn whole_frames(first: f64, last: f64) -> impl Iterator<Item = f64> {
    let (first, last) = (first.floor(), last.ceil());
    let count = (last - first + 1.0).clamp(0.0, MOST_FRAMES_LOOKED_AT);
    (0..count as u32).map(move |i| first + f64::from(i))
}

//! Cameras (UsdGeomCamera), and their tables in a shot file.

use std::collections::BTreeSet;

use glam::{DAffine3, DVec2};
use openusd::usd::Prim;

use super::clock::Clock;
use super::file::{LensKey, UsdCamera};
use super::render::{Conform, RenderSettings};
use super::value::{Answer, codes, codes_read, number, numbers, value, word};
use crate::animation::Track;
use crate::scene::camera::{FARTHEST_PLANE, Projection};
use crate::scene::import::cameras::{self, settings, size_of_ratio};
use crate::scene::keys::camera::{CameraKey, ShutterTable};
use crate::scene::keys::toml_text::{At, List};
use crate::scene::keys::{FileTables, Rate};
use crate::settings::Look;

/// Lengths of cameras are in tenths of a unit.
const TENTH: f64 = 0.1;

/// Values of a lens, and what they are if the file does not say.
const LENS: [(&str, f64); 7] = [
    ("focalLength", 50.0),
    ("horizontalAperture", 20.955),
    ("verticalAperture", 15.2908),
    ("horizontalApertureOffset", 0.0),
    ("verticalApertureOffset", 0.0),
    ("fStop", 0.0),
    ("focusDistance", 0.0),
];

/// Attributes of the exposure, and what they are if the file does not say: in stops, as ISO 100 films, in seconds, and for a lens with
/// an f-number of 1.
const EXPOSURE: [(&str, f64); 5] = [
    ("exposure", 0.0),
    ("exposure:iso", 100.0),
    ("exposure:time", 1.0),
    ("exposure:fStop", 1.0),
    ("exposure:responsivity", 1.0),
];

/// Attribute of the distances of clipping planes.
const PLANES: &str = "clippingRange";

/// Reads a camera at the place `map`; `unit`: metres in a unit. What has no effect is told in `unused`.
///
/// # Errors What the library says, and a lens that makes no sense.
pub fn read(
    prim: &Prim,
    map: &Track<DAffine3>,
    (clock, unit): (&Clock, f64),
    unused: &mut BTreeSet<String>,
) -> Answer<UsdCamera> {
    let start = clock.code(clock.first());
    let is_orthographic = word(prim, "projection", start)?.as_deref() == Some("orthographic");
    let mut frames: BTreeSet<u64> = BTreeSet::new();
    let mut zooms = Vec::new();
    for (name, _) in LENS {
        let times = codes_read(prim, name, clock)?;
        if times.len() > 1 {
            zooms.extend(times.iter().map(|code| clock.frame(*code)));
        }
    }
    // an angle of view does not follow a focal length evenly
    zooms.sort_by(f64::total_cmp);
    if let (Some(first), Some(last)) = (zooms.first().copied(), zooms.last().copied()) {
        let whole = (first.ceil() as i64..=last.floor() as i64).take(1 << 20);
        zooms.extend(whole.map(|frame| frame as f64));
    }
    let times = codes_read(prim, PLANES, clock)?;
    if times.len() > 1 {
        frames.extend(times.iter().map(|code| clock.frame(*code).to_bits()));
    }
    if !map.is_constant() {
        frames.extend(map.frames().map(f64::to_bits));
    }
    frames.extend(zooms.into_iter().map(f64::to_bits));
    let mut frames: Vec<f64> = frames.into_iter().map(f64::from_bits).collect();
    frames.sort_by(f64::total_cmp);
    if frames.is_empty() {
        frames.push(clock.first());
    }
    let mut keys = Vec::with_capacity(frames.len());
    let mut ratio = 1.0;
    for frame in frames {
        let (key, own_ratio) = key(prim, map.at(frame), frame, (clock, unit, is_orthographic))?;
        if keys.is_empty() {
            ratio = own_ratio;
        }
        let planes = planes(prim, clock.code(frame))?.map(|planes| planes.map(|depth| depth * unit));
        let is_range = |[near, far]: &[f64; 2]| *near >= 0.0 && near < far && *far <= FARTHEST_PLANE;
        if planes.as_ref().is_some_and(|planes| !is_range(planes)) {
            unused.insert(String::from(
                "a clippingRange of a camera leaves nothing between its ends, and is not used",
            ));
        }
        keys.push(LensKey { planes: planes.filter(is_range), ..key });
    }
    let shutter = |name: &str| -> Answer<f64> { Ok(clock.frame(number(prim, name, start)?.unwrap_or(0.0))) };
    let name = prim.path().name().unwrap_or_default().to_string();
    Ok(UsdCamera {
        name,
        path: prim.path().to_string(),
        is_orthographic,
        ratio,
        keys,
        shutter: [shutter("shutter:open")?, shutter("shutter:close")?],
        stops: stops(prim, start, unused)?,
    })
}

/// Stops by which the exposure of a camera makes pictures brighter (UsdGeomCamera, ComputeLinearExposureScale).
fn stops(prim: &Prim, code: f64, unused: &mut BTreeSet<String>) -> Answer<f64> {
    let mut values = [0.0; 5];
    for (value, (name, default)) in values.iter_mut().zip(EXPOSURE) {
        *value = number(prim, name, code)?.unwrap_or(default);
        if codes(prim, name)?.len() > 1 {
            unused.insert(String::from(
                "exposures of cameras do not change with time: that of the first frame is used",
            ));
        }
    }
    let [exposure, iso, time, f_number, responsivity] = values;
    let stops = exposure + (time * iso * responsivity / (100.0 * f_number * f_number)).log2();
    if stops.abs() <= f64::from(Look::MOST_EXPOSURE) {
        return Ok(stops);
    }
    unused
        .insert(format!("the exposure of the camera {} is beyond all bounds, and is not used", prim.path()));
    Ok(0.0)
}

/// Reads a camera at a frame. Returns also the ratio of its width to its height.
fn key(
    prim: &Prim,
    map: DAffine3,
    frame: f64,
    (clock, unit, is_orthographic): (&Clock, f64, bool),
) -> Answer<(LensKey, f64)> {
    let mut lens = [0.0; 7];
    for (value, (name, default)) in lens.iter_mut().zip(LENS) {
        *value = number(prim, name, clock.code(frame))?.unwrap_or(default);
    }
    let [focal, across, up, right, above, f_number, distance] = lens;
    let (fov, height) = (2.0 * (up / (2.0 * focal)).atan().to_degrees(), up * TENTH * unit);
    let makes_sense = match is_orthographic {
        true => (1e-9..1e9).contains(&height),
        false => (0.001..179.9).contains(&fov),
    };
    if !(makes_sense && across > 0.0) {
        return Err(format!(
            "the camera {} has no field of view that makes sense: export it again",
            prim.path()
        ));
    }
    let has_lens = !is_orthographic && f_number > 0.0 && distance > 0.0;
    let focus = has_lens.then(|| [focal * TENTH * unit / (2.0 * f_number), distance * unit]);
    let key = LensKey {
        frame,
        map,
        fov_or_height: if is_orthographic { height } else { fov },
        shift: DVec2::new(right, above) / across.max(up),
        focus,
        planes: None,
    };
    Ok((key, across / up))
}

/// Distances of the clipping planes, in the units of the file.
fn planes(prim: &Prim, code: f64) -> Answer<Option<[f64; 2]>> {
    let stated = value(prim, PLANES, code)?.as_ref().and_then(numbers);
    Ok(stated.and_then(|range| range.try_into().ok()))
}

/// The tables of a camera and its settings; `size`: of a picture whose ratio makes no sense; `render`: what the file says of its picture.
pub fn tables(
    camera: &UsdCamera,
    size: [u32; 2],
    render: Option<&RenderSettings>,
    (frames, rate): (String, Rate),
) -> FileTables {
    let stated = render.and_then(|render| render.size);
    let conform = render.map_or(Conform::default(), |render| render.conform);
    let is_frozen = render.is_some_and(|render| render.is_frozen);
    let is_sharp = render.is_some_and(|render| render.is_sharp);
    let size = stated.or_else(|| size_of_ratio(camera.ratio)).unwrap_or(size);
    let ratio = stated.map_or(camera.ratio, |[width, height]| f64::from(width) / f64::from(height));
    let [open, close] = camera.shutter;
    let is_shutter = open < close && open >= -1.0 && close <= 1.0 && close - open <= 1.0;
    let shutter = (is_shutter && !is_frozen).then(|| ShutterTable {
        open: Some(At::of(open)),
        close: Some(At::of(close)),
        curve: None,
    });
    let mut before: Option<LensKey> = None;
    let keys = camera.keys.iter().map(|key| {
        let key = conformed(key, camera, ratio, conform);
        let key = LensKey { focus: key.focus.filter(|_| !is_sharp), ..key };
        let own = changed(&key, before.as_ref(), camera.is_orthographic);
        before = Some(key);
        own
    });
    let projection = camera.is_orthographic.then_some(Projection::Orthographic);
    FileTables {
        render: Some(settings(size, frames, rate)),
        shutter,
        camera: Some(cameras::table(projection, keys, &[])),
        ..FileTables::default()
    }
}

/// A key for a picture of another shape than the camera's, whose aperture changes as in Pixar's library (UsdRender,
/// `aspectRatioConformPolicy`).
fn conformed(key: &LensKey, camera: &UsdCamera, ratio: f64, conform: Conform) -> LensKey {
    let grown = conform.height(camera.ratio, ratio);
    let fov_or_height = match camera.is_orthographic {
        true => key.fov_or_height * grown,
        false => 2.0 * ((key.fov_or_height.to_radians() / 2.0).tan() * grown).atan().to_degrees(),
    };
    // shifts are in the longer side, here of a camera of height 1
    let longer = |height: f64, ratio: f64| (height * ratio).max(height);
    let shift = key.shift * longer(1.0, camera.ratio) / longer(grown, ratio);
    match ratio == camera.ratio {
        true => key.clone(),
        false => LensKey { fov_or_height, shift, ..key.clone() },
    }
}

/// The key in the table, with what has changed of the lens since the one before.
fn changed(key: &LensKey, before: Option<&LensKey>, is_orthographic: bool) -> CameraKey {
    let is_other_view = before.is_none_or(|before| before.fov_or_height != key.fov_or_height);
    let view = is_other_view.then(|| At::of(key.fov_or_height));
    let (fov, height) = if is_orthographic { (None, view) } else { (view, None) };
    let is_shifted = before.map_or(DVec2::ZERO, |before| before.shift) != key.shift;
    let (aperture, focus) = match key.focus {
        Some([aperture, focus]) if before.is_none_or(|before| before.focus != key.focus) => {
            (Some(aperture.min(10.0 * focus)), Some(focus))
        }
        // it is a pinhole from here on
        None if before.is_some_and(|before| before.focus.is_some()) => (Some(0.0), None),
        _ => (None, None),
    };
    let planes = key.planes.filter(|_| before.is_none_or(|before| before.planes != key.planes));
    let [near, far] = planes.map_or([None, None], |planes| planes.map(|depth| Some(At::of(depth))));
    CameraKey {
        fov,
        height,
        shift: is_shifted.then(|| At::of(List(key.shift.to_array()))),
        aperture: aperture.map(At::of),
        focus: focus.map(At::of),
        near,
        far,
        ..cameras::key(key.frame, key.map)
    }
}

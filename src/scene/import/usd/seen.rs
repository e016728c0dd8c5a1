//! Payloads that a camera does not see, by the bounds that are stated beside them (`extentsHint` of UsdGeomModelAPI), without reading them.

use std::rc::Rc;

use glam::{DAffine3, DVec3};
use openusd::sdf::Path;
use openusd::usd::{LoadPolicy, Prim, Stage};

use super::cameras;
use super::choice::StageChoice;
use super::clock::Clock;
use super::file::UsdCamera;
use super::place;
use super::render::RenderSettings;
use super::resolver::Record;
use super::value::{Answer, numbers, said, value};
use super::variants::listed;
use crate::animation::Track;

/// Times a frame at which the camera looks.
const LOOKS_A_FRAME: f64 = 2.0;

/// Most times at which it looks.
const MOST_LOOKS: f64 = 1e5;

/// Widening of what the camera sees, so that between two looks nothing comes in from beyond its edges.
const WIDENED: f64 = 1.1;

/// Payloads that are left out, and what to tell of that.
pub struct Unseen {
    /// Paths of the prims that have them.
    pub paths: Vec<String>,
    pub note: String,
}

/// A prim with a payload that is not loaded.
struct Waiting {
    path: String,
    /// Corners of its bounds, in its own space; none: nothing is known of them.
    corners: Option<[DVec3; 8]>,
    map: Track<DAffine3>,
}

/// What a stage shows without its payloads.
#[derive(Default)]
struct Bare {
    waiting: Vec<Waiting>,
    cameras: Vec<(UsdCamera, Track<DAffine3>)>,
}

/// Finds payloads that the camera sees at no frame: that of a name or path, of the settings, or the first one. Afterwards all payloads are loaded.
///
/// # Errors What the library says, and no camera outside of payloads.
pub fn unseen(
    stage: &Stage,
    (clock, record): (&Clock, &Record),
    (choice, camera): (&StageChoice, Option<&str>),
    render: Option<&RenderSettings>,
) -> Answer<Unseen> {
    stage.unload(Path::abs_root());
    let bare = bare(stage, clock, record, &choice.mask);
    stage.load(Path::abs_root(), LoadPolicy::WithDescendants);
    let bare = bare?;
    let named = camera.or(render.and_then(|render| render.camera.as_deref()));
    let is_named = |camera: &UsdCamera| {
        named.is_none_or(|name| camera.path == name || camera.path.ends_with(&format!("/{name}")))
    };
    let Some((camera, at)) = bare.cameras.iter().find(|(camera, _)| is_named(camera)) else {
        let known: Vec<String> = bare.cameras.iter().map(|(camera, _)| camera.path.clone()).collect();
        let name = named.map_or(String::new(), |name| format!(" `{name}`"));
        let there = if known.is_empty() { String::from("none") } else { listed(&known) };
        return Err(format!(
            "--only-seen needs a camera that is in no payload, and there is no such camera{name} (there are: {there}): leave it out, or name \
             another --camera"
        ));
    };
    let view = View::new(camera, render);
    let looks = looks(clock, at);
    let mut unseen = Vec::new();
    let mut unknown = 0;
    let count = bare.waiting.len();
    for Waiting { path, corners, map } in bare.waiting {
        let Some(corners) = corners else {
            unknown += 1;
            continue;
        };
        let sees = |frame: &f64| view.sees(&corners, at.at(*frame).inverse() * map.at(*frame));
        if !looks.iter().any(sees) {
            unseen.push(path);
        }
    }
    let without = match unknown {
        0 => String::new(),
        unknown => format!(", {unknown} of them because they state no extentsHint"),
    };
    let note = format!(
        "of {count} payloads {} are loaded{without}; the others, which the camera does not see, cast no shadows, give no light and are in no \
         mirror",
        count - unseen.len()
    );
    Ok(Unseen { paths: unseen, note })
}

/// Walks over what is there without payloads.
fn bare(stage: &Stage, clock: &Clock, record: &Record, mask: &[String]) -> Answer<Bare> {
    let mask = mask.iter().map(|path| said(Path::new(path))).collect::<Answer<Vec<_>>>()?;
    let is_in =
        |path: &Path| mask.is_empty() || mask.iter().any(|of| path.has_prefix(of) || of.has_prefix(path));
    let (mut found, root) = (Bare::default(), Rc::new(Track::constant(DAffine3::IDENTITY)));
    let roots = said(stage.prim(Path::abs_root()).children())?;
    let mut todo: Vec<(Prim, Rc<Track<DAffine3>>)> =
        roots.into_iter().rev().map(|prim| (prim, root.clone())).collect();
    while let Some((prim, above)) = todo.pop() {
        if !is_in(prim.path()) {
            continue;
        }
        record.next_prim()?;
        if !said(prim.is_active())? || said(prim.is_abstract())? {
            continue;
        }
        let own = match place::place(&prim, clock)? {
            Some(place) if place.is_reset => Rc::new(place.map),
            Some(place) => Rc::new(above.after(&place.map)),
            None => above,
        };
        if !said(prim.is_loaded())? {
            let corners = corners(&prim, clock)?;
            found.waiting.push(Waiting { path: prim.path().to_string(), corners, map: Track::clone(&own) });
            continue;
        }
        if said(prim.type_name())?.is_some_and(|kind| kind.as_str() == "Camera") {
            // in the file's own units and axes, as all places here
            let camera = cameras::read(&prim, &own, (clock, 1.0), &mut Default::default())?;
            found.cameras.push((camera, Track::clone(&own)));
        }
        todo.extend(said(prim.children())?.into_iter().rev().map(|child| (child, own.clone())));
    }
    Ok(found)
}

/// Corners of the bounds that a prim states for what it shows, whatever the purpose.
fn corners(prim: &Prim, clock: &Clock) -> Answer<Option<[DVec3; 8]>> {
    let hint = value(prim, "extentsHint", clock.code(clock.first()))?.as_ref().and_then(numbers);
    let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for pair in hint.unwrap_or_default().chunks_exact(6) {
        let (from, to) = (DVec3::from_slice(pair), DVec3::from_slice(&pair[3..]));
        // of a purpose that has nothing to show they are the wrong way round
        if from.is_finite() && to.is_finite() && from.cmple(to).all() {
            (least, most) = (least.min(from), most.max(to));
        }
    }
    let corner = |number: usize| {
        let side = |axis: usize| if number >> axis & 1 == 0 { least[axis] } else { most[axis] };
        DVec3::new(side(0), side(1), side(2))
    };
    Ok(least.cmple(most).all().then(|| std::array::from_fn(corner)))
}

/// Frames at which the camera looks: those of the file, or those between its own keys.
fn looks(clock: &Clock, camera: &Track<DAffine3>) -> Vec<f64> {
    let of_camera = || {
        let frames: Vec<f64> = if camera.is_constant() { Vec::new() } else { camera.frames().collect() };
        Some([*frames.first()?, *frames.last()?])
    };
    let [first, last] = clock.range.or_else(of_camera).unwrap_or([clock.first(); 2]);
    let steps = ((last - first) * LOOKS_A_FRAME).ceil().clamp(0.0, MOST_LOOKS);
    (0..=steps as u32).map(|step| first + (last - first) * f64::from(step) / steps.max(1.0)).collect()
}

/// What a camera sees at any frame.
struct View {
    /// Half of the width and the height, with the shift: at the distance 1, or of an orthographic camera.
    half: [f64; 2],
    is_orthographic: bool,
}

impl View {
    fn new(camera: &UsdCamera, render: Option<&RenderSettings>) -> Self {
        let ratio = render
            .and_then(|render| render.size)
            .map_or(camera.ratio, |[width, height]| f64::from(width) / f64::from(height));
        let grown = render.map_or(1.0, |render| render.conform.height(camera.ratio, ratio)).max(1.0);
        let ratio = ratio.max(camera.ratio);
        let mut half = [0.0_f64; 2];
        for key in &camera.keys {
            let height = grown
                * match camera.is_orthographic {
                    true => key.fov_or_height / 2.0,
                    false => (key.fov_or_height.to_radians() / 2.0).tan(),
                };
            let longer = 2.0 * height * ratio.max(1.0);
            let own = [height * ratio + key.shift.x.abs() * longer, height + key.shift.y.abs() * longer];
            half = [half[0].max(own[0]), half[1].max(own[1])];
        }
        Self { half: half.map(|edge| edge * WIDENED), is_orthographic: camera.is_orthographic }
    }

    /// Returns false if the box of these corners is certainly out of sight; `to_camera`: map from them to the camera, which looks along -Z.
    fn sees(&self, corners: &[DVec3; 8], to_camera: DAffine3) -> bool {
        let corners = corners.map(|corner| to_camera.transform_point3(corner));
        if corners.iter().any(|corner| !corner.is_finite()) {
            return true;
        }
        let [across, up] = self.half;
        let at = |corner: &DVec3, half: f64| if self.is_orthographic { half } else { -corner.z * half };
        let is_beyond = |test: &dyn Fn(&DVec3) -> bool| corners.iter().all(test);
        !(is_beyond(&|corner| corner.z > 0.0)
            || is_beyond(&|corner| corner.x > at(corner, across))
            || is_beyond(&|corner| corner.x < -at(corner, across))
            || is_beyond(&|corner| corner.y > at(corner, up))
            || is_beyond(&|corner| corner.y < -at(corner, up)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_out_of_sight_are_not_seen() {
        let view = View { half: [1.0, 0.5], is_orthographic: false };
        let near = |x: f64, y: f64, z: f64| {
            let corner = |number: usize| {
                let side = |axis: usize| (number >> axis & 1) as f64 - 0.5;
                DVec3::new(x + side(0), y + side(1), z + side(2))
            };
            view.sees(&std::array::from_fn(corner), DAffine3::IDENTITY)
        };
        assert!(near(0.0, 0.0, -3.0) && near(3.8, 0.0, -3.0) && near(0.0, -2.2, -3.0) && near(0.0, 0.0, 0.0));
        assert!(!near(0.0, 0.0, 2.0) && !near(4.2, 0.0, -3.0) && !near(-4.2, 0.0, -3.0));
        assert!(!near(0.0, 2.4, -3.0) && !near(0.0, -2.4, -3.0));
    }
}

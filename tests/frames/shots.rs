//! Is reuse exact on shots as people make them, and are all planes of their frames what the contract says?

use std::collections::BTreeSet;
use std::path::Path;

use afterimage::film::{Film, PlaneKind};
use afterimage::frame::{Finished, Renderer};
use afterimage::layers::Layers;
use afterimage::scene::{self, Shot};
use afterimage::settings::Mode;
use afterimage::stats::FrameStats;

use crate::collection;

/// Names that other programs rely on.
const CHANNELS: &str = "R G B A Z P.X P.Y P.Z N.X N.Y N.Z albedo.R albedo.G albedo.B \
    diffuse.R diffuse.G diffuse.B specular.R specular.G specular.B \
    reflection.R reflection.G reflection.B refraction.R refraction.G refraction.B object.V \
    status_base.V status_good.V status_overlapped.V status_missed.V status_obscured.V status_age.V \
    rays_primary.V rays_verification.V rays_shadow.V rays_secondary.V";

/// Beyond this, 16-bit floats are infinite.
const MOST_HALF: f32 = 65504.0;

/// Of a frame's samples, how many may hold only within the audit's tolerance for edges. Small pictures of
/// large scenes are edges for a good part; a tolerance that swallows surfaces shows far beyond this.
const MOST_ON_EDGE: f64 = 0.01;

fn own(path: &str) -> Shot {
    scene::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(path), true).unwrap()
}

/// Renders `frames`, the first a base frame, with an audit of each; returns the share of samples that were
/// reused in the others.
fn audited(shot: &Shot, size: (u32, u32), frames: &[i32]) -> f64 {
    let mut settings = shot.settings.clone();
    (settings.width, settings.height, settings.samples, settings.audit) = (size.0, size.1, 2, true);
    // whether it pays is not the question here
    settings.mode = Mode::Reproject;
    let layers = "diffuse,specular,reflection,refraction,albedo,Z,P,N,object,status,rays";
    settings.layers = Layers::parse(layers).unwrap();
    let mut renderer = Renderer::new(&shot.scene, &settings).unwrap();
    let mut reused = 0;
    for (index, frame) in frames.iter().enumerate() {
        let finished = renderer.render(*frame, index > 0).unwrap();
        check(&finished, &format!("{}, frame {frame}", shot.title));
        reused += finished.stats.samples.reused();
    }
    let cells = u64::from(size.0 * size.1 * 4);
    reused as f64 / (cells * (frames.len() as u64 - 1)) as f64
}

fn check(finished: &Finished, what: &str) {
    let Finished { film, stats, .. } = finished;
    let audit = stats.audit.expect("asked for");
    assert_eq!(audit.checked, stats.samples.total(), "{what}");
    assert_eq!(audit.wrong(), 0, "{what}: {audit:?}");
    assert!(audit.on_edge as f64 <= MOST_ON_EDGE * audit.checked as f64, "{what}: {audit:?}");
    check_planes(film, what);
    check_status(film, stats, what);
    check_rays(film, stats, what);
}

fn check_planes(film: &Film, what: &str) {
    let names: BTreeSet<&str> = film.planes.iter().map(|plane| &*plane.name).collect();
    assert_eq!(names, CHANNELS.split_whitespace().collect(), "{what}");
    assert_eq!(names.len(), film.planes.len(), "{what}: each once");
    for plane in &film.planes {
        let values = plane.values.to_floats();
        assert_eq!(values.len(), (film.width * film.height) as usize, "{what}: {}", plane.name);
        let most = if plane.kind == PlaneKind::Half { MOST_HALF } else { f32::MAX };
        let bad = values.iter().find(|value| !value.is_finite() || value.abs() > most);
        assert_eq!(bad, None, "{what}: {}", plane.name);
    }
    for name in
        ["A", "status_base.V", "status_good.V", "status_overlapped.V", "status_missed.V", "status_obscured.V"]
    {
        let values = film.values(name).unwrap();
        let outside = values.iter().find(|value| !(0.0..=1.0).contains(*value));
        assert_eq!(outside, None, "{what}: {name}");
    }
}

/// Per pixel the fractions are whole; over the frame they are the statistics.
fn check_status(film: &Film, stats: &FrameStats, what: &str) {
    let values = |name: &str| film.values(&format!("status_{name}.V")).unwrap();
    let planes = ["base", "good", "overlapped", "missed", "obscured"].map(values);
    for pixel in 0..planes[0].len() {
        let sum: f32 = planes.iter().map(|plane| plane[pixel]).sum();
        assert_eq!(sum, 1.0, "{what}: pixel {pixel}");
    }
    let counts = &stats.samples;
    let of_pixel = counts.total() as f64 / planes[0].len() as f64;
    let counted = planes.map(|plane| plane.iter().map(|share| f64::from(*share) * of_pixel).sum::<f64>());
    let expected = [counts.base, counts.good, counts.overlapped, counts.missed, counts.obscured];
    assert_eq!(counted, expected.map(|count| count as f64), "{what}");
}

/// The planes of rays hold every ray that the statistics count.
fn check_rays(film: &Film, stats: &FrameStats, what: &str) {
    let sum = |name: &str| film.values(name).unwrap().iter().map(|rays| f64::from(*rays)).sum::<f64>();
    let rays = &stats.rays;
    for (name, expected) in [
        ("rays_primary.V", rays.primary),
        ("rays_verification.V", rays.verification),
        ("rays_shadow.V", rays.shadow),
        ("rays_secondary.V", rays.reflection + rays.refraction + rays.gathering),
    ] {
        assert_eq!(sum(name), expected as f64, "{what}: {name}");
    }
}

#[test]
fn the_analytic_shot() {
    let share = audited(&own("analytic/analytic.toml"), (96, 54), &[1, 2, 3, 4, 5, 6, 7, 8]);
    assert!(share > 0.7, "{share}");
}

#[test]
fn lights_that_move_and_change() {
    let share = audited(&own("analytic/lights.toml"), (96, 54), &[1, 2, 3, 4, 5, 6, 7, 8]);
    assert_eq!(share, 1.0, "nothing moves but lights");
}

#[test]
fn a_still_life_of_quadrics() {
    let share = audited(&own("quadrics/quadrics.toml"), (96, 54), &[10, 11, 12, 30, 31, 32]);
    assert!(share > 0.5, "{share}");
}

#[test]
fn surfaces_of_graphs_alone() {
    let shot = own("patterns/patterns.toml");
    assert!(shot.warnings.is_empty(), "its graphs are used as they are: {:?}", shot.warnings);
    let share = audited(&shot, (96, 54), &[10, 11, 12, 13]);
    assert!(share > 0.5, "{share}");
}

#[test]
fn the_court() {
    let share = audited(&own("court/court.toml"), (96, 54), &[1, 2, 3, 24, 25, 48]);
    assert!(share > 0.7, "{share}");
}

#[test]
fn a_hall_of_mirrors() {
    let mut shot = own("hall/hall.toml");
    shot.settings.paths = 2;
    let share = audited(&shot, (96, 54), &[1, 2, 3, 24, 25, 48]);
    assert!(share > 0.7, "{share}");
}

#[test]
fn a_flag_in_the_wind() {
    // the camera rests, then goes around
    let share = audited(&own("cloth/cloth.toml"), (96, 54), &[14, 15, 16, 17, 30, 31, 32]);
    assert!(share > 0.6, "{share}");
}

#[test]
fn a_lens_and_a_shutter() {
    let mut shot = own("blur/blur.toml");
    shot.settings.exposures = Some(4);
    // the camera rests, starts to move, and moves
    let share = audited(&shot, (96, 54), &[10, 11, 12, 13, 14]);
    assert!(share > 0.6, "{share}");
}

#[test]
fn soft_shadows_of_panels_that_rest_and_move() {
    let share = audited(&own("analytic/panel.toml"), (96, 54), &[1, 2, 3, 4, 5, 6, 7, 8]);
    assert!(share > 0.7, "{share}");
}

#[test]
fn the_city() {
    let shot = own("city/city.toml");
    let share = audited(&shot, (96, 54), &[1, 2, 3, 4]);
    assert!(share > 0.5, "{share}");
    // over a key of the camera, at full speed, and frames further apart
    audited(&shot, (96, 54), &[28, 29, 30, 31, 40, 60]);
}

#[test]
fn the_city_under_a_sky() {
    let mut shot = own("city/sky.toml");
    shot.settings.paths = 4;
    let share = audited(&shot, (64, 36), &[1, 2, 3, 30]);
    assert!(share > 0.5, "{share}");
}

#[test]
fn the_turning_mirror() {
    let share = audited(&own("spin/spin.toml"), (96, 54), &[1, 2, 3, 4, 24, 48]);
    assert!(share > 0.8, "{share}");
}

/// A shot whose models lie elsewhere, named by absolute paths.
fn foreign(text: &str) -> Shot {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("foreign.toml");
    std::fs::write(&path, text).unwrap();
    scene::load(&path, false).unwrap()
}

#[test]
#[cfg_attr(not(scene_collection), ignore = "needs the scene collection: set AFTERIMAGE_SCENES")]
fn four_statues() {
    let folder = collection::folder("statues");
    let statue = |name: &str, x: f32| {
        format!("[[model]]\nobj = '{}'\ntranslate = [{x}, 0, 0]\n", folder.join(name).display())
    };
    // one of them turns
    let turning = "[[model.key]]\nframe = 1\n[[model.key]]\nframe = 9\nrotate = [0, 40, 0]\n";
    let text = [
        "[camera]\ninterpolation = \"smooth\"\n\
         [[camera.key]]\nframe = 1\neye = [-1.5, 1.5, 4]\ntarget = [0, 0.9, 0]\nfov = 40\n\
         [[camera.key]]\nframe = 9\neye = [1.0, 1.7, 3.5]\ntarget = [0.2, 0.8, 0]\n\
         [[light]]\ntype = \"directional\"\ndirection = [-1, -1, -0.5]\npower = 2\n\
         [[light]]\ntype = \"point\"\nposition = [1, 3, 3]\npower = 5\n",
        &statue("DancingGirl.obj", -1.4),
        &statue("Maria.obj", -0.45),
        &statue("Ugolino.obj", 0.5),
        &format!("[[model]]\nobj = '{}'\n", folder.join("BustManWreath.obj").display()),
        turning,
    ];
    let share = audited(&foreign(&text.concat()), (64, 36), &[1, 2, 3, 4]);
    assert!(share > 0.3, "{share}");
}

/// A million triangles: loaded once, small pictures.
#[test]
#[cfg_attr(not(scene_collection), ignore = "needs the scene collection: set AFTERIMAGE_SCENES")]
fn the_kitchen() {
    let folder = collection::folder("kitchen");
    // the camera of its maker, walking
    let text = format!(
        "[[camera.key]]\nframe = 1\neye = [1.211, 1.80475, 3.85239]\ntarget = [0.3348, 1.7214, 2.0565]\nfov = 36\n\
         [[camera.key]]\nframe = 25\neye = [0.6, 1.75, 3.0]\ntarget = [0.1, 1.6, 1.2]\n\
         [[light]]\ntype = \"point\"\nposition = [0.5, 2.4, 1.5]\npower = 4\n\
         [[light]]\ntype = \"spot\"\nposition = [2, 2.6, 3.5]\ntarget = [0, 0.5, 0]\ncone = 80\nsoft = 0.3\npower = 6\n\
         [ambient]\ncolor = [0.2, 0.2, 0.2]\n[background]\ncolor = [0.6, 0.8, 1]\n\
         [[model]]\nobj = '{}'\n",
        folder.join("kitchen.obj").display()
    );
    let share = audited(&foreign(&text), (64, 36), &[1, 2, 3, 4]);
    assert!(share > 0.3, "{share}");
}

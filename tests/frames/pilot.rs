//! Do frames have the error from which their counts follow?

use std::path::Path;

use afterimage::frame::Renderer;
use afterimage::layers::Layers;
use afterimage::pilot::{self, Choice};
use afterimage::scene::{self, Shot};
use afterimage::settings::{Free, Mode, Settings, Wanted};
use afterimage::trace::BackendKind;

/// Pixels that differ most, which are in no measure.
const SPARKS: f64 = 0.002;

fn shot(path: &str, error: f32, settings: &Settings) -> Shot {
    let mut shot = scene::load(Path::new(path), false).expect("it is shipped");
    let wanted = Some(Wanted { error, free: Free::ALL });
    let (width, height) = (128, 72);
    let of_shot = shot.settings.clone();
    shot.settings = Settings { width, height, wanted, layers: Layers::NONE, mode: settings.mode, ..of_shot };
    shot
}

fn chosen(shot: &Shot) -> Choice {
    let choice =
        pilot::choose(BackendKind::Embree, shot, &shot.settings).expect("small pictures are rendered");
    choice.expect("an error is wanted")
}

/// The colours of the last of these frames.
fn colors(shot: &Shot, settings: &Settings, frames: std::ops::RangeInclusive<i32>) -> Vec<f64> {
    let mut renderer = Renderer::new(&shot.scene, settings).expect("it builds");
    let mut film = None;
    for frame in frames.clone() {
        film = Some(renderer.render(frame, frame > *frames.start()).expect("it renders").film);
    }
    let film = film.expect("there is a frame");
    let values = |name| film.values(name).expect("it is there");
    let [r, g, b] = ["R", "G", "B"].map(values);
    r.into_iter().zip(g).zip(b).flat_map(|((r, g), b)| [r, g, b].map(f64::from)).collect()
}

/// Root of the mean square of what pixels differ by, over the mean.
fn error(shown: &[f64], truth: &[f64]) -> f64 {
    let square = |(a, b): (&[f64], &[f64])| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / 3.0;
    let mut squares: Vec<f64> = shown.chunks(3).zip(truth.chunks(3)).map(square).collect();
    squares.sort_by(f64::total_cmp);
    squares.truncate((squares.len() as f64 * (1.0 - SPARKS)) as usize);
    let mean = truth.iter().sum::<f64>() / truth.len() as f64;
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt() / mean
}

#[test]
fn frames_have_the_error_that_is_wanted() {
    for (path, wanted, mode) in [
        ("scenes/city/city.toml", 0.06, Mode::Reproject),
        ("scenes/city/sky.toml", 0.12, Mode::Full),
        ("scenes/city/sky.toml", 0.12, Mode::Reproject),
        ("scenes/blur/blur.toml", 0.05, Mode::Reproject),
    ] {
        let mut shot = shot(path, wanted, &Settings { mode, ..Settings::default() });
        let choice = chosen(&shot);
        let mut settings = shot.settings.clone();
        let truth = Settings { mode: Mode::Full, samples: 7, paths: settings.paths, ..settings.clone() };
        choice.apply(&mut shot.scene, &mut settings);
        let truth = Settings { paths: 6.min(truth.paths), ..truth };
        let last = 6;
        let measured = error(&colors(&shot, &settings, 1..=last), &colors(&shot, &truth, last..=last));
        println!("{path}, {mode:?}: {choice}: {measured:.4}");
        assert!(choice.is_reached(), "{path}: {choice}");
        // the truth has some error, too
        let within = 0.35 * choice.expected..1.6 * choice.expected;
        assert!(within.contains(&measured), "{path}, {mode:?}: {choice}: {measured}");
    }
}

#[test]
fn less_error_takes_more_rays_and_what_is_stated_stays() {
    let at = |error, free| {
        let mut shot = shot("scenes/city/sky.toml", error, &Settings::default());
        shot.settings.wanted = Some(Wanted { error, free });
        chosen(&shot)
    };
    let rays = [0.3, 0.1, 0.05].map(|error| at(error, Free::ALL).rays);
    assert!(rays.is_sorted() && rays[2] > 2 * rays[0], "{rays:?}");
    let stated = at(0.05, Free { samples: false, ..Free::ALL });
    let of_shot = shot("scenes/city/sky.toml", 0.05, &Settings::default()).settings.samples;
    assert_eq!(stated.counts.samples, of_shot, "{stated}");
}

#[test]
fn threads_and_frames_that_are_rendered_change_nothing() {
    let shot = shot("scenes/city/sky.toml", 0.1, &Settings::default());
    let by = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        pool.install(|| chosen(&shot))
    };
    assert_eq!(by(1), by(3));
}

//! The contestants, side by side in one run.

use std::error::Error;
use std::ops::Range;
use std::time::Instant;

use afterimage::frame::Renderer;
use afterimage::scene::Scene;
use afterimage::settings::Settings;
use serde::Serialize;

use super::bare::Bare;

/// Ways to make a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contestant {
    /// Bare Embree: the limit.
    Raw,
    /// Every frame traced from nothing.
    Full,
    /// Every frame inferred from the one before.
    Reprojected,
    /// Every frame traced from nothing by the pure-Rust tracer.
    Rust,
}

impl Contestant {
    /// Contestants in the order of the columns.
    pub const ALL: [Self; 4] = [Self::Raw, Self::Full, Self::Reprojected, Self::Rust];

    /// Title of its columns, and its key in the JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Raw => "raw",
            Self::Full => "full",
            Self::Reprojected => "reproj",
            Self::Rust => "rust",
        }
    }
}

/// Cost of a frame, or the mean over frames.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Cost {
    /// Wall-clock seconds.
    pub seconds: f64,
    /// Number of all rays that were cast.
    pub rays: f64,
    /// Share of the samples that came from the frame before.
    pub kept: f64,
}

/// Renderers of one scene with one set of lights and samples.
pub struct Arena<'s> {
    pub scene: &'s Scene,
    pub settings: &'s Settings,
    pub bare: &'s mut Bare,
    /// Renderer with Embree.
    pub renderer: Renderer<'s>,
    /// Renderer with the pure-Rust tracer.
    pub rust: Renderer<'s>,
}

/// Measurements of one shot.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Costs by contestant, in the order of [`Contestant::ALL`].
    pub costs: Vec<Cost>,
    /// Bytes of the sample store, for each sample.
    pub bytes_per_sample: f64,
}

type Failable<T> = Result<T, Box<dyn Error>>;

impl Arena<'_> {
    /// Measures the frames after the first of `frames`, which is the base frame and is not counted. Each
    /// contestant makes all of them once a round, the rounds in alternating order; of each frame the fastest
    /// round counts, and of the frames the mean.
    pub fn measure(&mut self, frames: Range<i32>, rounds: u32) -> Failable<Outcome> {
        let mut best: Vec<Vec<Cost>> = vec![Vec::new(); Contestant::ALL.len()];
        for round in 0..rounds {
            for turn in 0..Contestant::ALL.len() {
                let number = if round % 2 == 0 { turn } else { Contestant::ALL.len() - 1 - turn };
                let costs = self.run(Contestant::ALL[number], frames.clone())?;
                keep_faster(&mut best[number], costs);
            }
        }
        let costs = best.iter().map(|frames| mean(frames)).collect();
        // inferring takes more tiles than tracing, and they stay
        self.run(Contestant::Reprojected, frames.start..frames.start + 2)?;
        Ok(Outcome { costs, bytes_per_sample: self.renderer.memory().bytes_per_sample })
    }

    fn run(&mut self, contestant: Contestant, frames: Range<i32>) -> Failable<Vec<Cost>> {
        match contestant {
            Contestant::Raw => frames.skip(1).map(|frame| self.trace(frame)).collect(),
            Contestant::Full => render_all(&mut self.renderer, frames, false),
            Contestant::Reprojected => render_all(&mut self.renderer, frames, true),
            Contestant::Rust => render_all(&mut self.rust, frames, false),
        }
    }

    fn trace(&mut self, frame: i32) -> Failable<Cost> {
        let cost = self.bare.trace(self.scene, self.settings, frame)?;
        Ok(Cost { seconds: cost.seconds, rays: cost.rays as f64, kept: 0.0 })
    }
}

/// Renders the first of `frames` in full, and the others in full or inferred, which are counted.
fn render_all(renderer: &mut Renderer, mut frames: Range<i32>, reuse: bool) -> Failable<Vec<Cost>> {
    if let Some(first) = frames.next() {
        render(renderer, first, false)?;
    }
    frames.map(|frame| render(renderer, frame, reuse)).collect()
}

/// Measures like [`Arena::measure`], with the renderer alone.
pub fn full_and_reprojected(renderer: &mut Renderer, frames: Range<i32>, rounds: u32) -> Failable<[Cost; 2]> {
    let mut best = [Vec::new(), Vec::new()];
    for round in 0..rounds {
        for turn in [0, 1] {
            let number = (turn + round as usize) % 2;
            keep_faster(&mut best[number], render_all(renderer, frames.clone(), number == 1)?);
        }
    }
    Ok(best.map(|frames| mean(&frames)))
}

/// Renders a frame.
fn render(renderer: &mut Renderer, frame: i32, reuse: bool) -> Failable<Cost> {
    let start = Instant::now();
    let finished = renderer.render(frame, reuse)?;
    let seconds = start.elapsed().as_secs_f64();
    let (samples, rays) = (finished.stats.samples, finished.stats.rays.total() as f64);
    Ok(Cost { seconds, rays, kept: samples.reused() as f64 / samples.total() as f64 })
}

/// Keeps the faster of two measurements of each frame.
fn keep_faster(best: &mut Vec<Cost>, costs: Vec<Cost>) {
    if best.is_empty() {
        *best = costs;
        return;
    }
    for (best, cost) in best.iter_mut().zip(costs) {
        if cost.seconds < best.seconds {
            *best = cost;
        }
    }
}

fn mean(frames: &[Cost]) -> Cost {
    let of = |part: fn(&Cost) -> f64| frames.iter().map(part).sum::<f64>() / frames.len() as f64;
    Cost { seconds: of(|cost| cost.seconds), rays: of(|cost| cost.rays), kept: of(|cost| cost.kept) }
}

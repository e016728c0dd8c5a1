//! The fastest full frame of a shot, with the speeds of its rays.

use std::error::Error;

use afterimage::frame::Renderer;
use afterimage::stats::{FrameStats, RayCounts};
use serde::Serialize;

use super::Arguments;

/// Speeds of the rays of a frame.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Speeds {
    /// Seconds of the frame.
    pub full_seconds: f64,
    /// Millions of rays a second, of one thread while it is in the tracer: from the eye, ...
    pub primary_speed: f64,
    /// ... to lights, ...
    pub shadow_speed: f64,
    /// ... and all others: of mirrors, glass and paths.
    pub bounced_speed: f64,
}

/// Renders frames from `first` on in full; returns the counts and speeds of the fastest.
pub fn fastest(
    renderer: &mut Renderer,
    first: i32,
    arguments: &Arguments,
) -> Result<(RayCounts, Speeds), Box<dyn Error>> {
    let mut fastest: Option<FrameStats> = None;
    for frame in (0..arguments.rounds()).flat_map(|_| first..first + arguments.frames() as i32) {
        let finished = renderer.render(frame, false)?;
        if fastest.as_ref().is_none_or(|best| finished.stats.seconds.rendering() < best.seconds.rendering()) {
            fastest = Some(finished.stats.clone());
        }
    }
    let FrameStats { rays, tracing, seconds, .. } = fastest.ok_or("no frame was rendered")?;
    let speed = |rays: u64, seconds: f64| if rays == 0 { 0.0 } else { rays as f64 / seconds / 1e6 };
    let speeds = Speeds {
        full_seconds: seconds.rendering(),
        primary_speed: speed(rays.primary, tracing.primary),
        shadow_speed: speed(rays.shadow, tracing.shadow),
        bounced_speed: speed(rays.reflection + rays.refraction + rays.gathering, tracing.bounced),
    };
    Ok((rays, speeds))
}

//! Renders the frames of a shot one after the other, each from the samples of the one before, and tells what that saves:
//! `cargo run --release --example animation -- scenes/court/court.toml 12`.

use std::error::Error;
use std::path::PathBuf;

use afterimage::frame::Renderer;
use afterimage::scene;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let path = arguments.next().map_or_else(|| "scenes/court/court.toml".into(), PathBuf::from);
    let count: usize = match arguments.next() {
        Some(count) => count.to_string_lossy().parse()?,
        None => 12,
    };
    let shot = scene::load(&path, false)?;
    let mut renderer = Renderer::new(&shot.scene, &shot.settings)?;
    for (number, frame) in shot.frames.list().into_iter().take(count).enumerate() {
        // the first frame has nothing to reuse, and what follows a cut has nothing in common with what was before
        let is_base = number == 0 || shot.scene.camera.cuts.contains(&frame);
        let finished = renderer.render(frame, !is_base)?;
        let stats = &finished.stats;
        println!(
            "frame {frame}: {} of {} samples reused, {} rays, {:.2} s",
            stats.samples.reused(),
            stats.samples.total(),
            stats.rays.total(),
            stats.seconds.total
        );
        // `finished.film` is the picture. Dropped before the next frame, its memory is used again.
    }
    Ok(())
}

//! Renders one frame of a shot, or of a model on a turntable, into a buffer of red, green and blue floats:
//! `cargo run --release --example still -- scenes/court/court.toml`.

use std::error::Error;
use std::path::PathBuf;

use afterimage::frame::Renderer;
use afterimage::layers::Layers;
use afterimage::scene;
use afterimage::settings::Settings;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).map_or_else(|| "scenes/court/court.toml".into(), PathBuf::from);
    let shot = scene::load(&path, false)?;
    for warning in &shot.warnings {
        eprintln!("warning: {warning}");
    }

    // everything that is not named here is as the shot has it
    let settings =
        Settings { width: 320, height: 180, samples: 2, layers: Layers::NONE, ..shot.settings.clone() };
    let mut renderer = Renderer::new(&shot.scene, &settings)?;
    let finished = renderer.render(shot.frames.first(), false)?;

    // a film has a plane for each channel, row by row from the top; a plane that is zero throughout keeps no values
    let pixels = (settings.width * settings.height) as usize;
    let plane = |name| finished.film.values(name).unwrap_or_else(|| vec![0.0; pixels]);
    let planes = ["R", "G", "B"].map(plane);
    let buffer: Vec<[f32; 3]> =
        (0..pixels).map(|pixel| planes.each_ref().map(|plane| plane[pixel])).collect();

    let mean = buffer.iter().flatten().sum::<f32>() / (3 * pixels) as f32;
    let (rays, seconds) = (finished.stats.rays.total(), finished.stats.seconds.total);
    println!("{} pixels of mean radiance {mean:.3}, of {rays} rays in {seconds:.2} s", buffer.len());
    Ok(())
}

//! Prints the places of the vertices of a shot's first model, one a line: what is subdivided lies on its limit surface.
//!
//! `cargo run --example diced -- SHOT`

use std::path::Path;

use afterimage::scene;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("give a shot file")?;
    let shot = scene::load(Path::new(&path), true)?;
    let triangles = shot.scene.models[0].mesh.as_triangles().ok_or("the first model has no triangles")?;
    for place in triangles.positions.as_slice() {
        let [x, y, z] = shot.scene.space.point_of_files(glam::Vec3::from_array(*place)).to_array();
        println!("{x} {y} {z}");
    }
    Ok(())
}

//! Writes a big OBJ file to measure with: a rippled sphere with normals and texture coordinates.
//!
//! `cargo run --release --example big_obj -- FILE.obj [MILLIONS OF TRIANGLES]` (10 are 1.1 GB).

#[path = "../benches/shots/sphere.rs"]
mod sphere;

use std::io;
use std::path::Path;

fn main() -> io::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let Some(path) = arguments.next() else {
        return Err(io::Error::other("usage: big_obj FILE.obj [MILLIONS OF TRIANGLES]"));
    };
    let millions = arguments.next().and_then(|count| count.parse::<f64>().ok()).unwrap_or(10.0);
    sphere::write(Path::new(&path), (millions * 1e6) as u64)
}

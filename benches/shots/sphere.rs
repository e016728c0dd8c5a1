//! A rippled sphere of any number of triangles, with normals and texture coordinates, as OBJ.

use std::f64::consts::{PI, TAU};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Writes a sphere of radius 1 around the origin with `triangles` triangles or a few more.
pub fn write(path: &Path, triangles: u64) -> io::Result<()> {
    // twice as many cells around as from pole to pole, and two triangles in each
    let rows = ((triangles as f64 / 4.0).sqrt().ceil() as u32).max(2);
    let mut file = BufWriter::new(File::create(path)?);
    writeln!(file, "# a rippled sphere, {} triangles", 4 * rows * rows)?;
    vertices(&mut file, rows)?;
    faces(&mut file, rows)?;
    file.flush()
}

/// All corners of a grid; those of the first meridian twice, as their texture coordinates differ.
fn vertices(file: &mut impl Write, rows: u32) -> io::Result<()> {
    for row in 0..=rows {
        // holes at the poles: triangles there would have no area
        let v = 0.01 + 0.98 * f64::from(row) / f64::from(rows);
        for column in 0..=2 * rows {
            let u = f64::from(column) / f64::from(2 * rows);
            let (sin, cos) = (v * PI).sin_cos();
            let (east, north) = (u * TAU).sin_cos();
            let out = [sin * north, cos, sin * east];
            let radius = 1.0 + 0.05 * (u * TAU * 12.0).sin() * (v * PI * 9.0).sin();
            let [x, y, z] = out.map(|x| x * radius);
            writeln!(file, "v {x:.6} {y:.6} {z:.6}\nvt {u:.6} {:.6}", 1.0 - v)?;
            writeln!(file, "vn {:.4} {:.4} {:.4}", out[0], out[1], out[2])?;
        }
    }
    Ok(())
}

fn faces(file: &mut impl Write, rows: u32) -> io::Result<()> {
    let width = 2 * rows + 1;
    for row in 0..rows {
        for column in 0..2 * rows {
            let a = row * width + column + 1;
            let (b, c, d) = (a + 1, a + width, a + width + 1);
            writeln!(file, "f {a}/{a}/{a} {b}/{b}/{b} {d}/{d}/{d}\nf {a}/{a}/{a} {d}/{d}/{d} {c}/{c}/{c}")?;
        }
    }
    Ok(())
}

//! How fast OBJ files are read, beside tobj: best times, their ratio, and whether both read the same.
//!
//! `cargo run --release --example obj_speed -- FILE.obj [RUNS]`

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use afterimage::scene::obj::{self, TriangleSoup};

/// As a renderer would ask for it.
const OPTIONS: tobj::LoadOptions = tobj::GPU_LOAD_OPTIONS;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("usage: obj_speed FILE.obj [RUNS]")?;
    let runs = arguments.next().map_or(Ok(3), |runs| runs.parse::<u32>())?.max(1);
    let path = Path::new(&path);
    let megabytes = std::fs::metadata(path)?.len() as f64 / 1e6;
    println!("{}: {megabytes:.1} MB, {} threads", path.display(), rayon::current_num_threads());
    let (mut ours, mut theirs) = (f64::INFINITY, f64::INFINITY);
    for run in 1..=runs {
        let start = Instant::now();
        let read = obj::read(path).map_err(|error| error.to_string())?;
        ours = ours.min(start.elapsed().as_secs_f64());
        let start = Instant::now();
        let (models, _) = tobj::load_obj(path, &OPTIONS)?;
        theirs = theirs.min(start.elapsed().as_secs_f64());
        if run == runs {
            println!("{}", compared(&read, &models));
        }
    }
    for (name, seconds) in [("afterimage", ours), ("tobj", theirs)] {
        println!("{name:<11}{seconds:>8.3} s {:>8.0} MB/s", megabytes / seconds);
    }
    println!("ratio      {:>8.1}", theirs / ours);
    Ok(())
}

/// Says whether all triangles have the same corners, to the bit. Only files of triangles can be compared:
/// tobj cuts up other faces in its own way.
fn compared(ours: &TriangleSoup, theirs: &[tobj::Model]) -> String {
    let triangles: usize = theirs.iter().map(|model| model.mesh.indices.len() / 3).sum();
    if triangles != ours.triangles.len() {
        let (ours, vertices) = (ours.triangles.len(), ours.positions.len());
        return format!("{ours} triangles, {vertices} vertices; tobj has {triangles} triangles");
    }
    let corners = theirs.iter().flat_map(|model| {
        let mesh = &model.mesh;
        mesh.indices.iter().map(move |index| {
            let index = *index as usize;
            let uv = mesh.texcoords.get(2 * index..2 * index + 2);
            (&mesh.positions[3 * index..3 * index + 3], uv)
        })
    });
    let differing = ours.triangles.as_flattened().iter().zip(corners).filter(|(index, (position, uv))| {
        let index = **index as usize;
        let is_same = ours.positions[index] == *position;
        !is_same || uv.is_some_and(|uv| ours.uvs[index].to_array() != uv)
    });
    let (differing, vertices) = (differing.count(), ours.positions.len());
    format!("{triangles} triangles, {vertices} vertices, as tobj has them but for {differing} corners")
}

//! Memory and time that a shot takes: the first is computed, the second measured on a few samples and said as an estimate.

use std::collections::BTreeMap;
use std::time::Instant;

use super::line;
use crate::cli::coarse;
use crate::cli::say::terminal::duration;
use crate::frame::{self, Renderer};
use crate::layers::Layers;
use crate::memory::{self, Bytes};
use crate::scene::cutout::Mask;
use crate::scene::{Geometry, Mesh, Shot, Triangles};
use crate::settings::Settings;
use crate::trace::BackendKind;

/// Maximum number of rays that are cast for the estimate, for each thread: a second, or less.
const MOST_RAYS: u64 = 1 << 22;

/// Divisors of the picture's sides for the estimate: the smallest that is cheap enough is taken.
const DIVISORS: [u32; 6] = [1, 2, 4, 8, 16, 32];

/// Adds lines on the memory and the time of a frame of `shot`.
pub fn tell(text: &mut String, shot: &Shot) {
    let threads = rayon::current_num_threads();
    let frames = shot.frames.runs().iter().map(|run| run.count()).sum::<u64>().min(2) as usize;
    let need = frame::need(shot, &shot.settings, BackendKind::Embree, frames, threads);
    let scene = memory_of(shot);
    line(text, "memory", format!("{} for rendering, {} for the scene", Bytes(need.bytes()), Bytes(scene)));
    match seconds(shot, threads) {
        Some((build, a_frame)) => {
            let base = duration(a_frame);
            let build = duration(build);
            line(
                text,
                "time",
                format!(
                    "some {base} a frame that is traced in full, and {build} before the first, on {threads} threads: an \
                     estimate from a small picture; `afterimage compare` measures"
                ),
            );
        }
        None => line(text, "time", String::from("not estimated: a small picture could not be rendered")),
    }
}

/// Bytes of the meshes, of what is cut out of them, and of textures.
pub fn memory_of(shot: &Shot) -> u64 {
    let of_mesh = |mesh: &Mesh| {
        let of_geometry = match &mesh.geometry {
            Geometry::Triangles(triangles) => of_triangles(triangles),
            Geometry::Curved(curved) => curved.bytes(),
        };
        of_geometry
            + bytes(&mesh.details.second_uvs)
            + bytes(&mesh.details.colors)
            + bytes(&mesh.details.alphas)
            + bytes(&mesh.details.tangents)
            + bytes(&mesh.material_of)
    };
    let cut = || shot.scene.built().filter_map(|mesh| mesh.cut.as_deref());
    let of_cut: u64 = cut().map(|cut| bytes(&cut.mask_of)).sum();
    // masks of one picture share its squares
    let tables: BTreeMap<usize, u64> =
        cut().flat_map(|cut| cut.masks.iter().filter_map(Mask::table)).collect();
    let mut files: Vec<_> =
        shot.scene.textures.iter().map(|of| (&of.path, of.texels().bytes().len() as u64)).collect();
    files.sort_unstable();
    files.dedup();
    let of_files = files.iter().map(|(_, bytes)| bytes).sum::<u64>();
    shot.scene.built().map(of_mesh).sum::<u64>() + of_cut + tables.values().sum::<u64>() + of_files
}

/// Bytes of triangles and their vertices, in all shapes.
fn of_triangles(Triangles { positions, corners, normals, uvs, shapes }: &Triangles) -> u64 {
    let of_positions = 12 * positions.as_slice().len() as u64;
    let shapes = shapes.as_ref().map_or(0, |shapes| shapes.list().len() as u64);
    of_positions * (1 + shapes) + bytes(corners) + bytes(normals) + bytes(uvs)
}

fn bytes<T>(list: &[T]) -> u64 {
    size_of_val(list) as u64
}

/// Seconds to prepare the scene, and for the first frame traced in full. `None` where a small picture cannot be rendered.
fn seconds(shot: &Shot, threads: usize) -> Option<(f64, f64)> {
    let small = small(shot, threads);
    let need = frame::need(shot, &small, BackendKind::Embree, 1, threads);
    need.check(&memory::left()).ok()?;
    let mut renderer = Renderer::new(&shot.scene, &small).ok()?;
    let start = Instant::now();
    renderer.render(shot.frames.first(), false).ok()?;
    let share = samples(&shot.settings) as f64 / samples(&small) as f64;
    Some((renderer.build_seconds(), start.elapsed().as_secs_f64() * share))
}

/// Samples of a frame: of all eyes.
fn samples(settings: &Settings) -> u64 {
    let eyes = if settings.stereo.is_some() { 2 } else { 1 };
    let fewest = u64::from(settings.samples).pow(2);
    settings.data_window().pixels() * fewest * eyes
}

/// Settings of a small picture whose samples are as those of the shot.
fn small(shot: &Shot, threads: usize) -> Settings {
    let of_shot = &shot.settings;
    let settings = |divisor: &u32| Settings {
        paths: of_shot.paths,
        paths_per_frame: of_shot.paths_per_frame,
        reflections: of_shot.reflections,
        occlusion_rays: of_shot.occlusion_rays,
        layers: Layers::NONE,
        ..coarse::smaller(of_shot, *divisor)
    };
    let is_quick = |small: &Settings| coarse::rays(shot, small) <= MOST_RAYS * threads as u64;
    let all = || DIVISORS.iter().map(settings);
    all().find(is_quick).unwrap_or_else(|| settings(&DIVISORS[DIVISORS.len() - 1]))
}

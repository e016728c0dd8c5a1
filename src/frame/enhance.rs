//! Enhancement: what depends on the eye is made anew for every sample, reused or not (the paper's
//! "Enhancement Phase"): highlights, reflections, refractions. Tiles that the film shows already need none.

use super::bits::{set_bits, surface_bits};
use super::bounce;
use super::placed::Placed;
use super::stage::{Stage, Workbench};
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::samples::{BACKGROUND, CELLS, Column, EMPTY, Tile, full_color};
use crate::shade::light::{Aim, arrival, way};
use crate::shade::optics::branch;
use crate::shade::phong::Gloss;
use crate::shade::{Surface, phong};

/// Light beyond this is cut, so that no sum of samples is infinite. Half floats end at 65504.
const MOST_LIGHT: f32 = 1e30;

/// Three columns of a colour. Linear RGB.
pub type Light = [Column<f32>; 3];

/// What the cells of a tile show, by layer of the picture; their sum is the picture.
#[derive(Debug)]
pub struct Radiance {
    /// Emission, ambient and diffuse light; the background.
    pub diffuse: Light,
    /// Highlights. Means nothing where `has_specular` is not set.
    pub specular: Light,
    /// In mirrors, and off glass. Means nothing where `has_secondary` is not set.
    pub reflection: Light,
    /// Through glass. Means nothing where `has_secondary` is not set.
    pub refraction: Light,
    /// Whether any cell has a highlight.
    pub has_specular: bool,
    /// Whether any ray goes on from the tile.
    pub has_secondary: bool,
}

impl Default for Radiance {
    fn default() -> Self {
        let dark = [[0.0; CELLS]; 3];
        Self {
            diffuse: dark,
            specular: dark,
            reflection: dark,
            refraction: dark,
            has_specular: false,
            has_secondary: false,
        }
    }
}

impl Radiance {
    fn begin_tile(&mut self) {
        (self.has_specular, self.has_secondary) = (false, false);
    }

    /// Makes the layer of highlights ready to be written.
    fn open_specular(&mut self) {
        if !self.has_specular {
            self.has_specular = true;
            self.specular = [[0.0; CELLS]; 3];
        }
    }

    /// Makes the layers that rays beyond the first surface write ready.
    fn open_secondary(&mut self) {
        if !self.has_secondary {
            self.has_secondary = true;
            (self.reflection, self.refraction) = ([[0.0; CELLS]; 3], [[0.0; CELLS]; 3]);
        }
    }

    /// Light is neither negative nor infinite.
    fn cut_secondary(&mut self) {
        for value in self.reflection.iter_mut().chain(&mut self.refraction).flatten() {
            *value = value.clamp(0.0, MOST_LIGHT);
        }
    }
}

fn cut(light: Vec3x8) -> Vec3x8 {
    let cut = |light: F32x8| light.max(F32x8::ZERO).min(F32x8::splat(MOST_LIGHT));
    Vec3x8 { x: cut(light.x), y: cut(light.y), z: cut(light.z) }
}

/// Writes what each cell of `tile` shows into the bench's `radiance`. The tags must be up to date.
pub fn enhance(stage: &Stage, tile: &Tile, bench: &mut Workbench) {
    bench.radiance.begin_tile();
    for first in (0..CELLS).step_by(LANES) {
        let models = &tile.model[first..first + LANES];
        let surfaces = surface_bits(models);
        let lit = Mask::less(models, EMPTY).select3(tile.kept_light(first), Vec3x8::ZERO);
        let [r, g, b] = &mut bench.radiance.diffuse;
        cut(lit).store([r, g, b], first);
        if surfaces != u8::MAX {
            show_background(stage, tile, first, &mut bench.radiance.diffuse);
        }
        if surfaces != 0 {
            let gloss = stage.palette.gloss(&tile.materials(first));
            let goes_on = if stage.depth > 0 { gloss.goes_on.bits() & surfaces } else { 0 };
            if gloss.is_any || goes_on != 0 {
                enhance_lanes(stage, tile, first, &gloss, goes_on, bench);
            }
        }
    }
    bounce::follow(stage, bench);
    if bench.radiance.has_secondary {
        bench.radiance.cut_secondary();
    }
}

fn show_background(stage: &Stage, tile: &Tile, first: usize, [r, g, b]: &mut Light) {
    for cell in (first..first + LANES).filter(|cell| tile.model[*cell] == BACKGROUND) {
        [r[cell], g[cell], b[cell]] =
            stage.scene.background.radiance(tile.point(cell).normalize()).to_array();
    }
}

/// Highlights of eight samples, and the rays that go on from those whose bit is set in `goes_on`.
fn enhance_lanes(
    stage: &Stage,
    tile: &Tile,
    first: usize,
    gloss: &Gloss,
    goes_on: u8,
    bench: &mut Workbench,
) {
    let placed = bench.placed.get(stage, tile, first);
    let incoming = (placed.point - Vec3x8::splat(stage.view.camera.eye)).normalize();
    if gloss.is_any {
        let light = highlights(stage, tile, first, gloss, &placed, incoming);
        bench.radiance.open_specular();
        let [r, g, b] = &mut bench.radiance.specular;
        cut(light).store([r, g, b], first);
    }
    for lane in set_bits(goes_on) {
        bench.radiance.open_secondary();
        let cell = first + lane;
        let surface = Surface {
            point: placed.point.lane(lane),
            normal: placed.normal.lane(lane),
            facet: placed.facet.lane(lane),
            reflectance: full_color(tile.record[cell].reflectance),
            material: tile.record[cell].material,
            from_behind: tile.record[cell].is_from_behind(),
        };
        let optics = stage.scene.materials[usize::from(surface.material)].optics;
        bench.bounces.start(cell as u32, &surface, branch(optics, &surface, incoming.lane(lane)));
    }
}

/// The highlights of all lights that reach the samples.
fn highlights(
    stage: &Stage,
    tile: &Tile,
    first: usize,
    gloss: &Gloss,
    placed: &Placed,
    incoming: Vec3x8,
) -> Vec3x8 {
    let models = &tile.model[first..first + LANES];
    let is_surface = Mask::less(models, EMPTY);
    let mut sum = Vec3x8::ZERO;
    for (light, slot) in stage.pose.lights.iter().zip(stage.slots) {
        let to_centre = way(light, placed.point).0;
        if !phong::may_shine(gloss, placed.normal, -incoming, to_centre, light.shape.reach()) {
            continue;
        }
        let aim = Aim::at(light, tile.points(first));
        for point in 0..light.shape.points() {
            let lit = tile.tags.lit(*slot, point, first) & is_surface;
            if lit.any() {
                let arrival = arrival(light, point, &aim, placed.point);
                let highlight = phong::specular(gloss, placed.normal, -incoming, &arrival);
                sum = sum + lit.select3(highlight, Vec3x8::ZERO);
            }
        }
    }
    sum
}

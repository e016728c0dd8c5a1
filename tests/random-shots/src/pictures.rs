//! Compares a frame that was inferred with the same frame traced in full: what its cells show, the light on it, and whole pixels.
//!
//! Nothing here asks as the audit does, by rays: two frames are laid over each other.
//!
//! - **Area.** A frame traced in full shows in each cell what the cell's target sees. So must an inferred one: the same model, the same
//!   material. What may differ are cells whose target rounding decides; the audit has counted them, and no cell more may differ. Then
//!   the area of no surface, as a share of the cells, differs by more than theirs.
//! - **Light.** Each cell's light is that of a point of the same surface, somewhere about the target: two samplings of one function.
//!   [`Surface::is_fair`] derives how far their sums may be apart.
//! - **Pixels.** Where all samples that a pixel is made of are those of the frame traced in full, the pixel is the same to the bit; with a filter that is wider than a pixel, but for
//!   rounding.

use std::collections::BTreeMap;

use afterimage::exposure::Strata;
use afterimage::frame::grid::{Grid, place};
use afterimage::frame::picture_settings;
use afterimage::lanes::LANES;
use afterimage::samples::saved::PictureSamples;
use afterimage::samples::{CELLS, EMPTY, SampleStore, Tile};
use afterimage::scene::Shot;
use afterimage::settings::{Budget, Reuse};
use afterimage::stereo::Eye;

use crate::check::{Failure, Frame, Kind, Plane};

/// Of a colour's largest part: how far kept light may be from that of a frame traced in full. Both are rounded to half floats.
const COLOR_TOLERANCE: f32 = 2e-3;

/// Light below this is black.
const DARKEST: f32 = 1e-3;

/// Returns true for planes that tell how a picture was made instead of what it shows: rays that were cast, where samples come from, and
/// since when they are there. All other planes of the same samples are the same to the bit.
pub fn tells_how(plane: &str) -> bool {
    plane.starts_with("rays") || plane.starts_with("status")
}

/// A frame as it was made.
#[derive(Debug, Clone, Copy)]
pub struct Made<'m> {
    pub samples: &'m [PictureSamples<&'m SampleStore>],
    /// What each eye sees.
    pub frames: &'m [Frame],
}

/// How much was compared.
#[derive(Debug, Clone, Copy, Default)]
pub struct Compared {
    /// Samples that both frames have.
    pub samples: u64,
    /// Cells that show something in both.
    pub cells: u64,
    /// Cells that show another surface.
    pub elsewhere: u64,
    /// Surfaces whose light was compared.
    pub surfaces: u64,
    /// Pixels whose samples are the same.
    pub pixels: u64,
}

/// What of a frame can be compared.
#[derive(Debug, Clone, Copy)]
pub struct Asked {
    /// Single floats are fine enough for the shot.
    pub is_fine: bool,
    /// No two models are ever in the same place.
    pub is_defined: bool,
}

/// Compares an inferred frame with the same one in full.
pub fn compare(shot: &Shot, asked: Asked, inferred: Made, full: Made) -> Result<Compared, Failure> {
    let settings = &shot.settings;
    let mut compared = Compared::default();
    // with a budget samples have as many paths as they have had time for
    let is_lit_alike = settings.budget == Budget::None;
    let (of_picture, strata) = picture_settings(&shot.scene, settings);
    let grids: Vec<Grid> = Grid::levels(&of_picture, strata).collect();
    for frame in inferred.frames {
        // where surfaces of two models are in one place, their samples count among those on an edge
        let may_be_elsewhere = frame.audit.map_or(0, |audit| audit.coverage_on_edge + audit.on_edge);
        let (mut differing, mut elsewhere) = (0, 0);
        let is_of_eye = |picture: &&PictureSamples<&SampleStore>| picture.picture.eye as usize == frame.eye;
        for picture in inferred.samples.iter().filter(is_of_eye) {
            let Some(same) = full.samples.iter().find(|other| other.picture == picture.picture) else {
                continue;
            };
            for (grid, (level, other)) in grids.iter().zip(picture.levels.iter().zip(&same.levels)) {
                let level = Level { grid, stores: [level.store, other.store] };
                if is_lit_alike {
                    let (samples, apart) = level.same_samples();
                    (compared.samples, differing) = (compared.samples + samples, differing + apart);
                }
                if settings.reuse == Reuse::Target && asked.is_fine {
                    let (surfaces, others) = level.surfaces();
                    compared.cells += surfaces.values().map(|surface| surface.cells).sum::<u64>() + others;
                    elsewhere += others;
                    if is_lit_alike {
                        compared.surfaces += surfaces.len() as u64;
                        check_light(frame, &surfaces)?;
                    }
                }
            }
        }
        if differing > 0 {
            let detail = format!("frame {}: {differing} of {} samples", frame.number, compared.samples);
            return Err(Failure::new(Kind::Full, detail));
        }
        compared.elsewhere += elsewhere;
        if elsewhere > may_be_elsewhere && asked.is_defined {
            let detail = format!(
                "frame {}: {elsewhere} of {} cells show another surface than in full; rounding decides \
                 {may_be_elsewhere}",
                frame.number, compared.cells
            );
            return Err(Failure::new(Kind::Area, detail));
        }
        if is_lit_alike && asked.is_fine && asked.is_defined {
            compared.pixels += compare_pixels(shot, &grids, frame, inferred, full)?;
        }
    }
    Ok(compared)
}

fn check_light(frame: &Frame, surfaces: &BTreeMap<[u32; 2], Surface>) -> Result<(), Failure> {
    for ([model, material], surface) in surfaces {
        if !surface.is_fair() {
            let Surface { cells, sum, squares, brink, least, most, .. } = surface;
            let detail = format!(
                "frame {}: model {model}, material {material}: light over that in full {sum:+} on {cells} cells, where \
                 {} is allowed (sum of squares {squares}, {brink} cells at an edge, light from {least} to {most})",
                frame.number,
                surface.allowed()
            );
            return Err(Failure::new(Kind::Light, detail));
        }
    }
    Ok(())
}

/// What two frames show of a surface, in the cells in which both show it.
#[derive(Debug, Clone, Copy)]
struct Surface {
    cells: u64,
    /// Sum of the differences in light, inferred less full.
    sum: f64,
    /// Sum of their squares.
    squares: f64,
    /// Cells with another surface beside them, or none.
    brink: u64,
    /// Least light of either frame.
    least: f64,
    /// The greatest.
    most: f64,
}

impl Surface {
    const NONE: Self =
        Self { cells: 0, sum: 0.0, squares: 0.0, brink: 0, least: f64::INFINITY, most: f64::NEG_INFINITY };

    /// How often the light of one surface in one frame may be told to be unfair by chance. A shot has some tens of them: so it is
    /// a shot in 1e6, and a thousand shots in 1e3.
    const FALSE_ALARM: f64 = 1e-8;

    /// How far a sample may lie from its target, in cells.
    const REACH: f64 = 0.75;

    /// Cells that one sample may serve in all.
    const SERVED: f64 = 2.0;

    fn add(&mut self, [inferred, full]: [f64; 2], is_at_brink: bool) {
        self.cells += 1;
        self.sum += inferred - full;
        self.squares += (inferred - full).powi(2);
        self.brink += u64::from(is_at_brink);
        self.least = self.least.min(inferred).min(full);
        self.most = self.most.max(inferred).max(full);
    }

    /// Returns true if the light of the inferred frame is that of a fair sampling of what the frame in full samples.
    ///
    /// Let f be the light on the surface, as a function of places in the picture, and c the targets of the n cells that show it. The sum
    /// of the differences is that of f(c + s(c)) - f(c), with |s| at most [`REACH`](Self::REACH). Of s there is a part that cells share,
    /// for the picture has moved as a whole, and a part that is each sample's own.
    ///
    /// *Shared.* If all samples lie off by the same s, f is summed over the same region, displaced: what counts is what comes in on
    /// one side and goes out on the other. These strips are as large as each other, each at most as many cells as `REACH` times those at
    /// the brink, and f differs between them by no more than its range. Where s grows across the picture, as in a zoom, cells are as much
    /// denser or less dense as s grows, at most from -`REACH` to `REACH` from one brink to the other: as much again.
    ///
    /// *Own.* A sample is as likely to lie to one side of its target as to the other, and random numbers are drawn for each: its
    /// difference is symmetric about 0, and independent of those of others, but that a sample may serve two cells. Then the sum of n of
    /// them exceeds t times the root of the sum of their squares with a probability of at most 2 exp(-t^2 / 2), whatever their
    /// sizes are (B. Efron, "Student's t-Test Under Symmetry Conditions", 1969); pairs that are served alike cost a factor of 2
    /// in the squares.
    fn allowed(&self) -> f64 {
        let shared = 2.0 * Self::REACH * self.brink as f64 * (self.most - self.least);
        let own = (2.0 * (2.0 / Self::FALSE_ALARM).ln() * Self::SERVED * self.squares).sqrt();
        shared + own
    }

    fn is_fair(&self) -> bool {
        self.cells == 0 || self.sum.abs() <= self.allowed()
    }
}

/// A level of samples of a picture, inferred and in full.
struct Level<'l> {
    grid: &'l Grid,
    stores: [&'l SampleStore; 2],
}

impl Level<'_> {
    fn tiles(&self) -> impl Iterator<Item = [&Tile; 2]> {
        self.stores[0].tiles.iter().zip(&self.stores[1].tiles).map(|(tile, other)| [&**tile, &**other])
    }

    /// How many samples both frames have, and how many of them keep other light.
    fn same_samples(&self) -> (u64, u64) {
        let (mut same, mut apart) = (0, 0);
        for tiles in self.tiles() {
            for cell in (0..CELLS).filter(|cell| is_same_sample(tiles, *cell)) {
                same += 1;
                apart += u64::from(!keeps_same_light(tiles, cell));
            }
        }
        (same, apart)
    }

    /// What both frames show of each surface, by model and material; and in how many cells they show different ones.
    fn surfaces(&self) -> (BTreeMap<[u32; 2], Surface>, u64) {
        let mut surfaces: BTreeMap<[u32; 2], Surface> = BTreeMap::new();
        let mut elsewhere = 0;
        let show_both = |[tile, other]: [&Tile; 2], cell: usize| {
            let seen = surface_of(other, cell);
            seen.filter(|seen| surface_of(tile, cell) == Some(*seen))
        };
        for (number, tiles) in self.tiles().enumerate() {
            for cell in 0..CELLS {
                let [Some(inferred), Some(full)] = tiles.map(|tile| surface_of(tile, cell)) else { continue };
                if inferred != full {
                    elsewhere += 1;
                    continue;
                }
                let [x, y] = place(cell).map(|at| at as usize);
                let beside = [[1, 0], [0, 1], [2, 1], [1, 2], [0, 0], [2, 0], [0, 2], [2, 2]];
                let is_brink = |[dx, dy]: [usize; 2]| {
                    let there = self.grid.cell_around(number, [x + dx, y + dy]);
                    let there = there.and_then(|(tile, cell)| {
                        show_both([0, 1].map(|frame: usize| &*self.stores[frame].tiles[tile]), cell)
                    });
                    there != Some(full)
                };
                let light = tiles.map(|tile| {
                    let kept = tile.record[cell].direct_diffuse.map(|part| f64::from(part.to_f32()));
                    if full[0] < EMPTY { kept.into_iter().sum() } else { 0.0 }
                });
                surfaces.entry(full).or_insert(Surface::NONE).add(light, beside.into_iter().any(is_brink));
            }
        }
        (surfaces, elsewhere)
    }
}

/// Model and material that a cell shows.
fn surface_of(tile: &Tile, cell: usize) -> Option<[u32; 2]> {
    let (model, material) = (tile.model[cell], tile.record[cell].material);
    if model == EMPTY {
        return None;
    }
    if model > EMPTY {
        return Some([model, 0]);
    }
    Some([model, u32::from(material)])
}

/// Share of a value by which pixels of filters wider than a pixel may differ: in a tile of which some sample lies beside its target weights
/// are computed in another way, which is rounded otherwise, and so are half floats. Of two mattes with equal shares rounding decides which is the
/// first, and whether one without a share is named: then shares are compared alone.
const WIDE_ROUNDING: f32 = 2e-3;

/// Least value to which [`WIDE_ROUNDING`] is relative: what the share of a sample at the end of a filter's reach may be instead of none. In pictures of a
/// few pixels places are rounded by a ten-thousandth of a cell or two.
const LEAST_SHARE: f32 = 0.1;

/// Compares the pixels of which both frames have all samples: how many.
fn compare_pixels(
    shot: &Shot,
    grids: &[Grid],
    frame: &Frame,
    inferred: Made,
    full: Made,
) -> Result<u64, Failure> {
    let Some(in_full) = full.frames.iter().find(|other| other.eye == frame.eye) else { return Ok(0) };
    let [width, height] = grids[0].film.map(|count| count as usize);
    // beside its own samples a pixel shows those that its filter reaches; and which level it shows follows from the pixels beside it
    let is_divided = picture_settings(&shot.scene, &shot.settings).1 != Strata::ONE;
    let reach = shot.settings.filter_reach() as usize + usize::from(is_divided) + grids.len() - 1;
    let mut is_same = vec![true; width * height];
    let pictures = || inferred.samples.iter().filter(|one| one.picture.eye as usize == frame.eye);
    for picture in pictures() {
        let same = full.samples.iter().find(|other| other.picture == picture.picture);
        let levels = same.map_or(&[][..], |same| &same.levels);
        if levels.len() != grids.len() {
            return Ok(0);
        }
        for (grid, (level, other)) in grids.iter().zip(picture.levels.iter().zip(levels)) {
            // mirrors may show other places of the same surfaces
            let is_followed = |material: u16| shot.scene.materials[usize::from(material)].is_followed();
            let shows_kept = frame.audit.is_some_and(|audit| audit.mirrored > 0);
            let is_out = |tile: &Tile, cell: usize| {
                shows_kept && tile.model[cell] < EMPTY && is_followed(tile.record[cell].material)
            };
            rule_out(grid, [level.store, other.store], reach, is_out, &mut is_same);
        }
    }
    let pixels: Vec<usize> = (0..is_same.len()).filter(|pixel| is_same[*pixel]).collect();
    let rounding = if shot.settings.filter_reach() > 0 { WIDE_ROUNDING } else { 0.0 };
    let differs = |pixel: &&usize| first_difference(frame, in_full, **pixel, rounding).is_some();
    let differing = pixels.iter().filter(differs).count() as u64;
    // a shadow that grazes an edge shows in all pixels that its sample reaches
    let may_differ = frame.audit.map_or(0, |audit| audit.on_edge) * (2 * reach as u64 + 1).pow(2);
    if differing > may_differ {
        let first = pixels.iter().find_map(|pixel| first_difference(frame, in_full, *pixel, rounding));
        let detail = format!(
            "frame {}, eye {:?}: {differing} of {} pixels whose samples are those of the frame in full: {}",
            frame.number,
            Eye::BOTH.get(frame.eye),
            pixels.len(),
            first.unwrap_or_default()
        );
        return Err(Failure::new(Kind::Pixels, detail));
    }
    Ok(pixels.len() as u64)
}

/// Unmarks each pixel within `reach` pixels of a cell in which the two stores do not have the same, or that `is_out`.
fn rule_out(
    grid: &Grid,
    stores: [&SampleStore; 2],
    reach: usize,
    is_out: impl Fn(&Tile, usize) -> bool,
    is_same: &mut [bool],
) {
    let [width, height] = grid.film.map(|count| count as i32);
    let reach = reach as i32;
    for number in 0..grid.tiles() {
        let tiles = [0, 1].map(|store: usize| &*stores[store].tiles[number]);
        let corner = grid.corner_in_film(number);
        for cell in (0..CELLS).filter(|cell| !is_same_sample(tiles, *cell) || is_out(tiles[0], *cell)) {
            let is_empty = |tile: &Tile| tile.model[cell] == EMPTY;
            if tiles.into_iter().all(is_empty) {
                continue;
            }
            let at = place(cell).map(|at| (at / grid.samples) as i32);
            let [x, y] = [0, 1].map(|axis| corner[axis] + at[axis]);
            for y in (y - reach).max(0)..(y + reach + 1).min(height) {
                for x in (x - reach).max(0)..(x + reach + 1).min(width) {
                    is_same[(y * width + x) as usize] = false;
                }
            }
        }
    }
}

/// The first plane in which a pixel differs by more than `rounding`, a share of its value.
fn first_difference(frame: &Frame, full: &Frame, pixel: usize, rounding: f32) -> Option<String> {
    let planes = frame.planes.iter().zip(&full.planes);
    let is_rounding = |a: u32, b: u32| {
        let [a, b] = [a, b].map(f32::from_bits);
        (a - b).abs() <= rounding * a.abs().max(b.abs()).max(LEAST_SHARE)
    };
    let differs = |((name, a), (_, b)): &(&Plane, &Plane)| {
        let is_free = tells_how(name) || rounding > 0.0 && is_matte_id(name);
        !is_free && a[pixel] != b[pixel] && !is_rounding(a[pixel], b[pixel])
    };
    let ((name, a), (_, b)) = planes.into_iter().find(differs)?;
    Some(format!("{name}, pixel {pixel}: {} and {}", f32::from_bits(a[pixel]), f32::from_bits(b[pixel])))
}

/// Returns true for the planes of a Cryptomatte that name mattes: their bits are no number, and the planes that follow have the shares.
fn is_matte_id(plane: &str) -> bool {
    plane.starts_with("Crypto") && (plane.ends_with(".R") || plane.ends_with(".B"))
}

/// Whether both tiles have one and the same sample in `cell`.
fn is_same_sample([tile, other]: [&Tile; 2], cell: usize) -> bool {
    let place = |tile: &Tile| [tile.x[cell], tile.y[cell], tile.z[cell]].map(f32::to_bits);
    let what =
        |tile: &Tile| (tile.model[cell], tile.record[cell].triangle, tile.record[cell].is_from_behind());
    tile.model[cell] != EMPTY
        && (tile.model[cell] > EMPTY && other.model[cell] == tile.model[cell] || what(tile) == what(other))
        && place(tile) == place(other)
        && seed(tile, cell) == seed(other, cell)
}

/// Of its random numbers.
fn seed(tile: &Tile, cell: usize) -> u32 {
    tile.gathered.seeds(cell / LANES * LANES).to_array()[cell % LANES]
}

fn keeps_same_light(tiles: [&Tile; 2], cell: usize) -> bool {
    if tiles[0].model[cell] > EMPTY {
        return true;
    }
    let [a, b] = tiles.map(|tile| tile.record[cell].direct_diffuse.map(|part| part.to_f32()));
    let largest = b.into_iter().fold(DARKEST, f32::max);
    a.into_iter().zip(b).all(|(a, b)| (a - b).abs() <= COLOR_TOLERANCE * largest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dice::Dice;

    /// What a surface says of `cells` cells, of which as many as go around a square are at its brink.
    fn surface(cells: usize, mut light: impl FnMut(usize) -> [f64; 2]) -> Surface {
        let brink = 4 * (cells as f64).sqrt() as usize;
        let mut surface = Surface::NONE;
        (0..cells).for_each(|cell| surface.add(light(cell), cell < brink));
        surface
    }

    #[test]
    fn two_fair_samplings_are_fair() {
        let mut dice = Dice::new(1);
        for _ in 0..1000 {
            let noise = surface(400, |_| [0, 1].map(|_| dice.between(0.0, 1.0)));
            assert!(noise.is_fair(), "{noise:?}");
            // a ramp that was displaced: 20 cells wide, from 0 to 1
            let off = dice.between(-0.75, 0.75);
            let ramp = surface(400, |cell| [off, 0.0].map(|off| ((cell % 20) as f64 + 0.5 + off) / 20.0));
            assert!(ramp.is_fair(), "{ramp:?}");
        }
    }

    #[test]
    fn light_that_is_lost_is_told() {
        let mut dice = Dice::new(1);
        let dim = surface(4000, |_| {
            let light = 0.5 + dice.between(-0.05, 0.05);
            [0.7 * light, light]
        });
        assert!(!dim.is_fair(), "{dim:?}");
        let mut is_lost = Dice::new(2);
        let thinned = surface(4000, |_| if is_lost.one_in(4) { [0.0, 1.0] } else { [1.0, 1.0] });
        assert!(!thinned.is_fair(), "{thinned:?}");
    }
}

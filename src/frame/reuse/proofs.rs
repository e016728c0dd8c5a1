//! Which samples of a tile need not be asked about, because it is [proven](crate::clear) that they are seen, and that so is their surface
//! at every target that they serve.
//!
//! A proof holds for all eyes in a region: the places of the camera in this frame and in some that follow. The sample keeps the
//! region's number, and goes with it from cell to cell; so does the news that there is no proof for a region. Proofs are looked for block by
//! block, for large blocks first.

use crate::clear::{EyeBox, Lanes, Obstacles, Patch, Prover, Shows};
use crate::frame::grid::bits::{set_bits, status_bits};
use crate::frame::grid::cells::{BLOCK, CellSet};
use crate::frame::reuse::candidates::REACH;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::plan::CameraChange;
use crate::frame::shot::proofs::Proofs;
use crate::geometry::Bounds;
use crate::lanes::{LANES, Vec3x8};
use crate::pose::Clip;
use crate::samples::{
    Apart, BACKGROUND, CELLS, ClearRegion, ClearRegions, EMPTY, Flags, SampleStore, Status, Tile,
};
use crate::settings::Reuse;

/// Factor by which cells may become larger than they are now until a proof ends, by a zoom.
const ROOM_TO_ZOOM: f32 = 1.01;

/// Factor by which the camera may go faster until a proof ends.
const ROOM_TO_MOVE: f32 = 1.25;

/// Share of it by which the distance may change in which lines of sight cross until a proof ends.
const ROOM_TO_FOCUS: f32 = 0.01;

/// Room around a sample in which its surface is asked: that in which it serves, and some for rounding. Cells.
const ROOM: f32 = REACH + 0.05;

/// Cells along the edge of the largest block that is tried, in blocks of 4 x 4.
const LARGEST: usize = 4;

/// Samples of a block of 4 x 4 that make it worth trying.
const LEAST: u32 = 4;

/// Memory of a worker for proofs.
#[derive(Debug, Default)]
pub struct ProofScratch {
    prover: Prover,
    /// Eight samples each, in the order in which blocks are halved.
    lanes: Vec<Lanes>,
    /// What they show, if it is one thing.
    shows: Vec<Option<Shows>>,
}

/// Returns true if proofs spare rays in a frame that reuses samples: its camera is not where it was, and its lines of sight meet in the
/// eye.
pub fn are_of_use(frame: &FrameView) -> bool {
    let (is_projected, camera) = (frame.plan.camera != CameraChange::None, &frame.view.camera);
    // what they prove to be seen may be beyond a clipping plane
    let is_whole = camera.clip == Clip::NONE;
    is_projected && is_whole && frame.settings.reuse == Reuse::Target && !camera.is_orthographic()
}

/// Chooses the region for this frame, among those that samples of `before` keep; `regions` become those of this frame's store.
pub fn choose<'a>(
    frame: &FrameView,
    obstacles: &'a Obstacles,
    before: &SampleStore,
    regions: &mut ClearRegions,
) -> Proofs<'a> {
    let (view, path) = (frame.view, frame.eye_path);
    let eyes = view.cameras().fold(Bounds::EMPTY, |all, camera| all.with(camera.eye));
    // a target looks from another place, and another way, than the eye that sees the sample which serves it
    let ((apart, slant), spread) = (view.apart(), view.spread().by_distance);
    let here = ClearRegion { eyes, spread, slant, apart };
    *regions = before.regions.that_hold(&here);
    let holding = regions.numbers();
    // the places of the path are those of the middles of exposures
    let way = apart.way;
    let around = |eyes: Bounds| Bounds { low: eyes.low - way, high: eyes.high + way }.union(here.eyes);
    let soon = ClearRegion { eyes: around(path.soon), ..here };
    let number = regions.that_holds(&soon).or_else(|| {
        let zoom = path.zoom.max(1.0) * ROOM_TO_ZOOM;
        let way = way * ROOM_TO_MOVE;
        let refocus = way * apart.focus.abs() * ROOM_TO_FOCUS;
        let apart = Apart { turn: apart.turn * ROOM_TO_MOVE + refocus, way, ..apart };
        let ahead =
            ClearRegion { eyes: around(path.ahead), spread: spread * zoom, slant: slant * zoom, apart };
        regions.add(ahead, &before.regions)
    });
    let now = number.and_then(|number| Some((number, *regions.get(number)?)));
    Proofs { obstacles, holding, now }
}

/// The region for which the samples of a block of 4 x 4 cells are not tried, where there was no proof for another: each block has its turn
/// once in a few regions. `first`: one of its cells.
fn given_up(proofs: &Proofs, first: usize) -> Option<u8> {
    const TURNS: usize = 4;
    let (number, _) = proofs.now?;
    ((first / BLOCK + usize::from(number)) % TURNS != 0).then_some(number)
}

/// Finds the cells of a tile whose servers are proven to be seen at their targets; samples forget proofs that do not hold any more. `asks`: true
/// if proofs are of use here.
pub fn find(
    frame: &FrameView,
    proofs: &Proofs,
    asks: bool,
    tile: &mut Tile,
    scratch: &mut ProofScratch,
) -> CellSet {
    let (mut proven, mut untried) = (CellSet::default(), CellSet::default());
    for first in (0..CELLS).step_by(LANES) {
        let reused = status_bits(&tile.status[first..first + LANES], Status::is_reused);
        let (mut proven_bits, mut untried_bits) = (0, 0);
        let gives_up = given_up(proofs, first);
        for (lane, record) in tile.record[first..first + LANES].iter_mut().enumerate() {
            match settle(&mut record.flags, proofs.holding, gives_up) {
                None => untried_bits |= 1 << lane,
                Some(true) => proven_bits |= 1 << lane,
                Some(false) => (),
            }
        }
        proven.insert_eight(first, proven_bits & reused);
        untried.insert_eight(first, untried_bits & reused);
    }
    for spare in &mut tile.spares.samples {
        settle(&mut spare.record.flags, proofs.holding, None);
    }
    if !asks {
        return CellSet::default();
    }
    if let (Some((number, region)), false) = (proofs.now, untried.is_empty()) {
        let eyes = EyeBox::new(&region.eyes);
        scratch.take(frame, proofs.obstacles, &eyes, tile, &untried);
        let mut search = Search { frame, proofs, eyes, region, number, tile, proven: &mut proven };
        let steps = LARGEST * LARGEST * GROUPS;
        (0..scratch.lanes.len()).step_by(steps).for_each(|first| search.try_block(scratch, first, steps));
    }
    for cell in proven.numbers() {
        tile.record[cell].flags = tile.record[cell].flags.without(Flags::UNSEEN);
    }
    proven
}

/// Has a sample forget a proof that does not hold any more; if there was none, it `gives_up` for another region as well. Returns whether it
/// is proven or known not to be, if that is known.
#[inline(always)]
fn settle(flags: &mut Flags, holding: u16, gives_up: Option<u8>) -> Option<bool> {
    let (region, is_proven) = flags.proof()?;
    if holding >> region & 1 == 0 {
        *flags = flags.with_proof(gives_up.filter(|_| !is_proven).map(|region| (region, false)));
        return flags.proof().map(|_| false);
    }
    Some(is_proven)
}

/// Groups of eight samples in a block of 4 x 4.
const GROUPS: usize = 2;

/// Index of the first cell of group number `group`, counted in the order in which blocks are halved (Morton's).
fn cell_of_group(group: usize) -> usize {
    let block = group / GROUPS;
    let (mut x, mut y) = (0, 0);
    for bit in 0..3 {
        x |= (block >> (2 * bit) & 1) << bit;
        y |= (block >> (2 * bit + 1) & 1) << bit;
    }
    (y * 8 + x) * GROUPS * LANES + group % GROUPS * LANES
}

impl ProofScratch {
    /// Takes the samples of the cells that are `untried`.
    fn take(
        &mut self,
        frame: &FrameView,
        obstacles: &Obstacles,
        eyes: &EyeBox,
        tile: &Tile,
        untried: &CellSet,
    ) {
        self.lanes.resize(CELLS / LANES, Lanes::NONE);
        self.shows.resize(CELLS / LANES, None);
        let middle = Vec3x8::splat(eyes.middle);
        for (group, (lanes, of_lanes)) in self.lanes.iter_mut().zip(&mut self.shows).enumerate() {
            let first = cell_of_group(group);
            lanes.used = untried.eight(first);
            if lanes.used == 0 {
                continue;
            }
            *of_lanes = one_surface(frame, obstacles, tile, first, lanes.used);
            lanes.triangles = tile.triangles(first);
            let offsets = frame.offsets_from(middle, (tile, first), || tile.ticks(first));
            if *of_lanes == Some(Shows::Background) {
                lanes.offsets = offsets.normalize();
                continue;
            }
            lanes.offsets = offsets;
            let normals = frame.geometric_normals((tile, first), || tile.ticks(first));
            lanes.normals = normals.normalize();
        }
    }
}

/// The one surface that those of eight samples show whose bit is set in `used`. `None` if there are several, or none for which there are
/// proofs.
fn one_surface(
    frame: &FrameView,
    obstacles: &Obstacles,
    tile: &Tile,
    first: usize,
    used: u8,
) -> Option<Shows> {
    let shows = |lane: usize| {
        let (model, record) = (tile.model[first + lane], &tile.record[first + lane]);
        if model == BACKGROUND {
            return Some(Shows::Background);
        }
        let is_provable = model != EMPTY && obstacles.is_provable(model);
        is_provable.then(|| Shows::Surface {
            model,
            material: frame.scene.models[model as usize].mesh.material_of[record.triangle as usize],
            is_from_behind: record.is_from_behind(),
        })
    };
    let mut lanes = set_bits(used);
    let of_first = shows(lanes.next()?)?;
    lanes.all(|lane| shows(lane) == Some(of_first)).then_some(of_first)
}

/// The search for proofs in a tile.
struct Search<'a> {
    frame: &'a FrameView<'a>,
    proofs: &'a Proofs<'a>,
    eyes: EyeBox,
    region: ClearRegion,
    /// Number of the region.
    number: u8,
    tile: &'a mut Tile,
    proven: &'a mut CellSet,
}

impl Search<'_> {
    /// Tries to prove `count` groups from number `first` on, or parts of them.
    fn try_block(&mut self, scratch: &mut ProofScratch, first: usize, count: usize) {
        let range = first..first + count;
        let used: u32 = scratch.lanes[range.clone()].iter().map(|lanes| lanes.used.count_ones()).sum();
        if used == 0 || count == GROUPS && used < LEAST {
            return;
        }
        let is_dense = used as usize * 4 >= count * LANES;
        if count == GROUPS && self.was_tried_in_vain(cell_of_group(first)) {
            self.note(scratch, range, false);
        } else if is_dense && self.is_clear(scratch, range.clone()) {
            self.note(scratch, range, true);
        } else if count > GROUPS {
            let quarter = count / 4;
            (0..4).for_each(|part| self.try_block(scratch, first + part * quarter, quarter));
        } else {
            range.for_each(|group| self.try_group(scratch, group));
        }
    }

    /// Tries to prove the samples of a group, or of either half of it.
    fn try_group(&mut self, scratch: &mut ProofScratch, group: usize) {
        let used = scratch.lanes[group].used;
        if used == 0 {
            return;
        }
        if self.is_clear(scratch, group..group + 1) {
            return self.note(scratch, group..group + 1, true);
        }
        // the left and the right one: two by two cells each
        for half in [0x33, 0xcc].map(|half| used & half).into_iter().filter(|half| *half != 0) {
            scratch.lanes[group].used = half;
            let is_clear = half != used && self.is_clear(scratch, group..group + 1);
            self.note(scratch, group..group + 1, is_clear);
        }
        scratch.lanes[group].used = used;
    }

    /// Returns true if most of what a block of 4 x 4 cells shows is known to have no proof: new samples there have none either.
    fn was_tried_in_vain(&self, first: usize) -> bool {
        let first = first / BLOCK * BLOCK;
        let is_unproven = |cell: &usize| {
            let is_known = self.tile.record[*cell].flags.proof();
            // cells without a sample have what was there before
            self.tile.model[*cell] != EMPTY && is_known.is_some_and(|(_, is_proven)| !is_proven)
        };
        (first..first + BLOCK).filter(is_unproven).count() * 2 >= BLOCK
    }

    fn is_clear(&self, scratch: &mut ProofScratch, range: std::ops::Range<usize>) -> bool {
        let ProofScratch { prover, lanes, shows } = scratch;
        let lanes = &lanes[range.clone()];
        let mut of_used = shows[range].iter().zip(lanes).filter(|(_, lanes)| lanes.used != 0);
        let Some((Some(shows), _)) = of_used.next() else { return false };
        if of_used.any(|(other, _)| *other != Some(*shows)) {
            return false;
        }
        let camera = &self.frame.view.camera;
        let Some(reach) = self.reach(*shows, lanes) else { return false };
        let patch = Patch { shows: *shows, lanes, axes: [camera.right, camera.up], reach };
        prover.is_clear(self.frame.scene, self.proofs.obstacles, &self.eyes, &patch)
    }

    /// How far from samples their surface is asked, for each unit of distance; `None` where the eye goes by right before them.
    fn reach(&self, shows: Shows, lanes: &[Lanes]) -> Option<f32> {
        let ClearRegion { spread, slant, apart, .. } = self.region;
        let depths = match shows {
            Shows::Background => [f32::INFINITY; 2],
            Shows::Surface { .. } => {
                let used = lanes.iter().flat_map(|lanes| set_bits(lanes.used).map(move |lane| (lanes, lane)));
                let distances = used.map(|(lanes, lane)| lanes.offsets.lane(lane).length());
                let ends = distances.fold([f32::INFINITY, 0.0], |[least, most], distance| {
                    [least.min(distance), f32::max(most, distance)]
                });
                // from any eye
                let size = self.eyes.half.length();
                [(ends[0] - size) / slant, ends[1] + size]
            }
        };
        (depths[0] > apart.way).then(|| ROOM * spread + apart.between(depths))
    }

    /// Has samples keep whether they are proven.
    fn note(&mut self, scratch: &ProofScratch, range: std::ops::Range<usize>, is_proven: bool) {
        for group in range {
            for cell in set_bits(scratch.lanes[group].used).map(|lane| cell_of_group(group) + lane) {
                let flags = &mut self.tile.record[cell].flags;
                *flags = flags.with_proof(Some((self.number, is_proven)));
                if is_proven {
                    self.proven.insert(cell);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::grid::place;

    #[test]
    fn blocks_that_are_tried_together_lie_together() {
        let mut seen = [false; CELLS];
        for blocks in [1, 4, 16, 64] {
            for first in (0..CELLS / LANES).step_by(blocks * GROUPS) {
                let cells: Vec<[u32; 2]> = (first..first + blocks * GROUPS)
                    .flat_map(|group| (0..LANES).map(move |lane| place(cell_of_group(group) + lane)))
                    .collect();
                let extent = [0, 1].map(|axis| {
                    let all = cells.iter().map(|cell| cell[axis]);
                    all.clone().max().zip(all.min()).map_or(0, |(most, least)| most - least + 1)
                });
                assert_eq!((extent[0] * extent[1]) as usize, cells.len(), "{blocks} from {first}");
                if blocks == 1 {
                    cells.iter().for_each(|[x, y]| seen[(y * 32 + x) as usize] = true);
                }
            }
        }
        assert!(seen.iter().all(|seen| *seen));
    }
}

//! Enhancement: light that depends on the eye is computed anew for every sample, reused or not (the paper's
//! "Enhancement Phase"): highlights, reflections, refractions. Paths by which rough layers reflect are kept, and
//! weighted anew. Tiles that the film shows already need none.

use glam::Vec3;

use super::bounce::{self, Bounces};
use super::in_media::{self, InMedia};
use super::parts;
use super::ray_trees::TileTrees;
use super::roles;
use super::tree_times::TreeGrain;
use crate::frame::grid::bits::{set_bits, surface_bits};
use crate::frame::light::lighting::{Places, add_light, shows_highlight};
use crate::frame::light::reflected::{self, directions_to_eye};
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::footprints::cell_widths;
use crate::frame::surface::placed::{Placed, PlacedTile};
use crate::frame::surface::radiance::{Layer, Light, Radiance, cut};
use crate::frame::surface::tangents::{tangent_of_sample, tangents_of_samples};
use crate::frame::surface::trace_scratch::TraceScratch;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::layers::Layers;
use crate::samples::{BACKGROUND, CELLS, Column, EMPTY, Tile, full_color};
use crate::settings::Backdrop;
use crate::shade::Surface;
use crate::shade::bsdf::phong;
use crate::shade::bsdf::phong::Gloss;
use crate::shade::bsdf::{LayerRays, SeenBsdfs, SeenBy, SurfaceAxes};
use crate::shade::horizon::Horizon;
use crate::shade::light::{LightSample, to_light};
use crate::shade::optics::branch;
use crate::shade::sampling::PathSequence;

/// Writes the light of each cell of a tile, of which the number comes first, into `radiance`. The tags must be up to date. `kept` are the
/// tile's stored ray trees, which are updated; without them all trees are traced. Returns true if any tree
/// was traced.
pub fn enhance(
    frame: &FrameView,
    (number, tile): (usize, &Tile),
    radiance: &mut Radiance,
    bounces: &mut Bounces,
    mut kept: Option<&mut TileTrees>,
    placed: &mut PlacedTile,
    scratch: &mut TraceScratch,
) -> bool {
    let ticks = frame.ticks_of(tile);
    let frame = &FrameView { ticks: ticks.as_ref(), ..*frame };
    radiance.begin_tile();
    bounces.times.begin(frame, kept.as_ref().map_or(TreeGrain::Nothing, |kept| kept.asks(frame)));
    bounces.trees.begin();
    bounces.media.begin(frame);
    bounces.ways.clear();
    bounces.mirrors.begin(number);
    let mut any_traced = false;
    let shows_parts = frame.layers.has(Layers::PARTS);
    for first in (0..CELLS).step_by(LANES) {
        let models = &tile.model[first..first + LANES];
        let surfaces = surface_bits(models);
        let lit = Mask::less(models, EMPTY).select3(tile.kept_light(first), Vec3x8::ZERO);
        let [r, g, b] = &mut radiance.diffuse;
        cut(lit).store([r, g, b], first);
        let is_visible = frame.settings.background == Backdrop::Visible;
        let shows_background = is_visible || frame.layers.has(Layers::BACKGROUND);
        if surfaces != u8::MAX && shows_background {
            show_background(frame, tile, first, &mut radiance.diffuse);
        }
        if shows_parts {
            parts::split(frame, tile, first, placed, radiance);
        }
        // the layer of the background has it now
        if surfaces != u8::MAX && shows_background && !is_visible {
            hide_background(tile, first, &mut radiance.diffuse);
        }
        let media = frame.media.map(|media| (media, in_media::bits(models)));
        let in_media = media.map_or(0, |(_, in_media)| in_media);
        let mut traced = 0;
        if surfaces != 0 || in_media != 0 {
            let looks = tile.looks(first);
            let gloss = frame.palette.gloss(&looks);
            let has_bsdfs = frame.palette.bsdfs.any(&looks);
            let followed = if frame.settings.depth > 0 { gloss.is_followed.bits() & surfaces } else { 0 };
            // what is not shown of holes and catchers is not traced
            let followed = followed & !roles::bits(frame, models);
            let trees = followed | in_media;
            if trees != 0 {
                radiance.open_secondary();
                radiance.is_followed = true;
                traced = match &kept {
                    Some(kept) => bounces.trees.show(frame, kept, (first, trees), radiance),
                    None => trees,
                };
                any_traced |= traced != 0;
            }
            if let Some((media, in_media)) = media {
                let Bounces { media: shown, times, .. } = &mut *bounces;
                shown.look(frame, media, (number, tile), (first, traced & in_media), (times, radiance));
            }
            if gloss.is_any || has_bsdfs || followed != 0 {
                let placed = placed.get(frame, tile, first);
                let incoming = -directions_to_eye(frame, tile, first, &placed);
                let axes = SurfaceAxes {
                    normal: placed.normal,
                    geometric_normal: placed.geometric_normal,
                    tangent: tangents_of_samples(frame, tile, first),
                };
                let reflectance = tile.reflectances(first);
                let rays = (has_bsdfs && frame.settings.depth > 0)
                    .then(|| reflect(frame, tile, first, &placed, incoming, &mut bounces.reflected));
                let bsdfs = frame.palette.bsdfs.seen_lanes(&looks, reflectance, axes, incoming, rays);
                if let Some(bsdfs) = &bsdfs {
                    show_beneath(bsdfs, Mask::less(models, EMPTY), first, radiance);
                }
                if gloss.is_any || bsdfs.is_some() {
                    let shine = (&gloss, bsdfs.as_ref());
                    let [light, of_matt] = highlights(frame, tile, first, shine, &placed, incoming, |_| true);
                    if bsdfs.as_ref().is_some_and(SeenBsdfs::is_matt_rough) {
                        add_to(&mut radiance.diffuse, first, of_matt);
                        add_to(&mut radiance.parts.direct, first, of_matt);
                    }
                    if frame.layers.has(Layers::LIGHT) {
                        for (group, shown) in radiance.parts.groups.iter_mut().enumerate() {
                            let of_group = |light: usize| frame.light_groups.of[light] == group;
                            let [light, of_matt] =
                                highlights(frame, tile, first, shine, &placed, incoming, of_group);
                            add_to(shown, first, light + of_matt);
                        }
                    }
                    radiance.open_specular();
                    let [r, g, b] = &mut radiance.specular;
                    cut(light).store([r, g, b], first);
                }
                if followed != 0 {
                    let traced = traced & followed;
                    start_rays(frame, tile, first, traced, &placed, incoming, (bounces, radiance));
                }
            }
        }
    }
    bounce::follow(frame, bounces, radiance, scratch);
    if radiance.has_secondary {
        radiance.cut_secondary();
    }
    if let Some(kept) = &mut kept {
        bounces.trees.keep(frame, kept, &bounces.times, radiance);
    }
    show_reflected(&mut bounces.reflected, &bounces.media, radiance);
    if !frame.roles.is_empty() {
        roles::show(frame, tile, placed, radiance);
    }
    bounces.media.dim(radiance);
    any_traced
}

/// Sums the light that kept paths bring to the rough layers of the samples in eight cells of `tile`, as the eye
/// sees them along `incoming`, and appends it to `shown` with the cell. Returns the rays by which these layers
/// and smooth ones reflect.
fn reflect(
    frame: &FrameView,
    tile: &Tile,
    first: usize,
    placed: &Placed,
    incoming: Vec3x8,
    shown: &mut Vec<(u32, Vec3)>,
) -> LayerRays {
    let mut rays = LayerRays { count: [0; LANES], followed: 0, incoming };
    for lane in set_bits(surface_bits(&tile.model[first..first + LANES])) {
        let cell = first + lane;
        let record = &tile.record[cell];
        let axes = SurfaceAxes {
            normal: placed.normal.lane(lane),
            geometric_normal: placed.geometric_normal.lane(lane),
            tangent: tangent_of_sample(frame, tile, cell),
        };
        let (reflectance, incoming) = (full_color(record.reflectance), incoming.lane(lane));
        let seen = frame.palette.bsdfs.seen(tile.look(cell), reflectance, axes, incoming, SeenBy::Eye);
        let Some(seen) = seen else { continue };
        if bounce::followed(frame, &seen, Vec3::ONE).is_some() {
            rays.followed |= 1 << lane;
        }
        if let Some((start, layer)) = reflected::start_at(frame, tile, cell, placed) {
            rays.count[lane] = layer.paths;
            rays.incoming.set_lane(lane, -tile.gathered.drawn_for(cell).unfold());
            shown.push((cell as u32, reflected::shown(frame, tile, (&start, &layer), &seen)));
        }
    }
    rays
}

/// Adds the light that rough layers reflect to that of mirrors, and removes it from the list.
fn show_reflected(reflected: &mut Vec<(u32, Vec3)>, media: &InMedia, radiance: &mut Radiance) {
    if reflected.is_empty() {
        return;
    }
    radiance.open_secondary();
    for (cell, light) in reflected.drain(..) {
        radiance.add_secondary(Layer::Reflection, cell as usize, light * media.left(cell as usize));
    }
    radiance.cut_secondary();
}

/// Dims the light of eight samples to the share that their layers let through, where there `is_surface`.
fn show_beneath(bsdfs: &SeenBsdfs, is_surface: Mask, first: usize, radiance: &mut Radiance) {
    let show = |[r, g, b]: &mut Light, dims: &dyn Fn(Vec3x8) -> Vec3x8| {
        let light = Vec3x8::load([&*r, &*g, &*b].map(|column| column.as_slice()), first);
        is_surface.select3(cut(dims(light)), light).store([r, g, b], first);
    };
    let Radiance { diffuse, parts, .. } = radiance;
    show(diffuse, &|light| bsdfs.show(light));
    // columns that no layer shows mean nothing
    show(&mut parts.emission, &|light| bsdfs.show(light));
    show(&mut parts.direct, &|light| light * bsdfs.through);
    show(&mut parts.indirect, &|light| light * bsdfs.through);
    parts.groups.iter_mut().for_each(|group| show(group, &|light| light * bsdfs.through));
}

fn hide_background(tile: &Tile, first: usize, [r, g, b]: &mut Light) {
    for cell in (first..first + LANES).filter(|cell| tile.model[*cell] == BACKGROUND) {
        [r[cell], g[cell], b[cell]] = [0.0; 3];
    }
}

fn show_background(frame: &FrameView, tile: &Tile, first: usize, [r, g, b]: &mut Light) {
    for cell in (first..first + LANES).filter(|cell| tile.model[*cell] == BACKGROUND) {
        [r[cell], g[cell], b[cell]] = frame.sky.seen(tile.point(cell).normalize()).to_array();
    }
}

/// Starts the rays that go on from those of eight samples whose bit is set in `followed`.
fn start_rays(
    frame: &FrameView,
    tile: &Tile,
    first: usize,
    followed: u8,
    placed: &Placed,
    incoming: Vec3x8,
    (bounces, radiance): (&mut Bounces, &mut Radiance),
) {
    let widths = if frame.palette.has_textures && followed != 0 {
        let [_, sights] = frame.sights(tile, first);
        cell_widths(frame.view, sights, placed.geometric_normal)
    } else {
        F32x8::ZERO
    };
    for lane in set_bits(followed) {
        let cell = first + lane;
        let surface = Surface {
            point: placed.point.lane(lane),
            normal: placed.normal.lane(lane),
            geometric_normal: placed.geometric_normal.lane(lane),
            tangent: tangent_of_sample(frame, tile, cell),
            // rays off mirrors and through glass ask for no light here
            horizon: Horizon::flat(placed.geometric_normal.lane(lane)),
            reflectance: full_color(tile.record[cell].reflectance),
            material: tile.record[cell].material,
            varied: tile.look(cell).varied,
            from_behind: tile.record[cell].is_from_behind(),
            width: widths.lane(lane),
        };
        let material = &frame.scene.materials[usize::from(surface.material)];
        let incoming = incoming.lane(lane);
        let guides = frame.layers.has(Layers::GUIDES) && !parts::shows_itself(frame, surface.look());
        let branches = branch(material, &surface, incoming, || {
            // the numbers belong to the sample; directions of its paths are of another set
            let random = PathSequence::of_reflections(tile.gathered.seed(cell), 1).path(0);
            let [around, along, ..] = random.four(1);
            [around, along]
        });
        let place = (cell as u32, tile.model[cell], tile.record[cell].triangle);
        if frame.maps.has(tile.model[cell]) {
            bounces.look_up(frame, (cell as u32, tile.model[cell]), branches, radiance);
        } else {
            bounces.start(frame, place, &surface, guides, branches);
        }
        let (look, axes) = (surface.look(), surface.axes());
        if let Some(seen) = frame.palette.bsdfs.seen(look, surface.reflectance, axes, incoming, SeenBy::Eye) {
            bounces.start_off_layer(frame, place, guides, &surface, &seen);
        }
    }
}

/// Adds light, which may be below 0, to that of eight samples, which stays at 0 or above.
fn add_to(shown: &mut Light, first: usize, light: Vec3x8) {
    let all = Vec3x8::load(shown.each_ref().map(Column::as_slice), first) + light;
    let [r, g, b] = shown;
    cut(all.max(Vec3x8::ZERO)).store([r, g, b], first);
}

/// Highlights on eight samples of the lights that reach them and are `among` these, by number; and what is [matt and
/// rough](SeenBsdfs::of_rough_matt) of them.
fn highlights(
    frame: &FrameView,
    tile: &Tile,
    first: usize,
    (gloss, bsdfs): (&Gloss, Option<&SeenBsdfs>),
    placed: &Placed,
    incoming: Vec3x8,
    among: impl Fn(usize) -> bool,
) -> [Vec3x8; 2] {
    let models = &tile.model[first..first + LANES];
    let is_surface = Mask::less(models, EMPTY);
    let [mut sum, mut of_matt] = [Vec3x8::ZERO; 2];
    let is_shown = |light: usize| !frame.pose.is_dark(light) && among(light);
    for (number, slot) in (0..).zip(frame.slots).filter(|(light, _)| is_shown(*light)) {
        frame.pose.each_of_light(
            number,
            || tile.ticks(first),
            |light, bits| {
                let to_centre = to_light(light, placed.point).0;
                let shines =
                    phong::may_shine(gloss, placed.normal, -incoming, to_centre, light.shape.reach());
                if !shines && bsdfs.is_none() {
                    return;
                }
                let at = (placed.point, tile.gathered.seeds(first));
                let places = Places::new(frame, at, || tile.ticks(first));
                let (shows, radiance) =
                    (shows_highlight(frame, light, gloss), frame.radiance_of(number, light));
                let sees = is_surface & Mask::from_bits(bits);
                let shown_by = if bsdfs.is_some() { sees } else { sees & shows };
                let reached = |point| tile.tags.lit(*slot, point, first) & shown_by;
                let shade = |light_sample: &LightSample| {
                    let highlight = || phong::specular(gloss, placed.normal, -incoming, light_sample);
                    match bsdfs {
                        None => highlight(),
                        Some(bsdfs) if !shines => bsdfs.highlight(light_sample, radiance),
                        Some(bsdfs) => {
                            shows.select3(highlight(), Vec3x8::ZERO) + bsdfs.highlight(light_sample, radiance)
                        }
                    }
                };
                sum = add_light(frame, sum, light, places, reached, shade);
                if let Some(bsdfs) = bsdfs.filter(|bsdfs| bsdfs.is_matt_rough()) {
                    of_matt =
                        add_light(frame, of_matt, light, places, reached, |light| bsdfs.of_rough_matt(light));
                }
            },
        );
    }
    [sum, of_matt]
}

//! Parts of the `diffuse` layer, and guides for denoisers: computed only for layers that were asked for.
//! Samples store nothing more for them.

use crate::frame::light::lighting::{Places, add_light, of_itself};
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::placed::PlacedTile;
use crate::frame::surface::radiance::{DARK, Light, Parts, Radiance, cut};
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::layers::Layers;
use crate::samples::{EMPTY, TagSlot, Tile};
use crate::scene::look::Look;
use crate::shade::Surface;
use crate::shade::bsdf::phong;

/// Layers that are made of single samples' light.
const LIGHT: Layers =
    Layers::DIRECT.with(Layers::INDIRECT).with(Layers::EMISSION).with(Layers::BACKGROUND).with(Layers::LIGHT);

/// Splits the light of the eight cells from `first` on into parts, and writes these into `radiance`, whose
/// `diffuse` must be complete. The tags must be up to date.
pub fn split(frame: &FrameView, tile: &Tile, first: usize, placed: &mut PlacedTile, radiance: &mut Radiance) {
    let (layers, Radiance { diffuse, parts, .. }) = (frame.layers, radiance);
    let is_surface = Mask::less(&tile.model[first..first + LANES], EMPTY);
    let write = |light: Vec3x8, [r, g, b]: &mut Light| {
        cut(is_surface.select3(light, Vec3x8::ZERO)).store([r, g, b], first);
    };
    if layers.has(LIGHT) {
        let (reflectance, looks) = (tile.reflectances(first), tile.looks(first));
        if layers.has(Layers::EMISSION) {
            let openness = || tile.gathered.opennesses(first);
            let models = &tile.model[first..first + LANES];
            write(of_itself(frame, models, (&looks, reflectance), openness), &mut parts.emission);
        }
        let albedo = frame.palette.albedo(&looks, reflectance);
        let of_lights = frame.albedo_of_lights(&looks, albedo);
        if layers.has(Layers::INDIRECT) {
            write(albedo * tile.gathered.means(first), &mut parts.indirect);
        }
        if layers.has(Layers::DIRECT) {
            let lit = |slot, point| tile.tags.lit(slot, point, first);
            write(direct(frame, tile, first, placed, of_lights, |_| true, lit), &mut parts.direct);
        }
        if layers.has(Layers::LIGHT) {
            let groups = frame.light_groups;
            parts.groups.resize(groups.names.len(), DARK);
            for (group, light) in parts.groups.iter_mut().enumerate() {
                let of_group = |light: usize| groups.of[light] == group;
                let lit = |slot, point| tile.tags.lit(slot, point, first);
                write(direct(frame, tile, first, placed, of_lights, of_group, lit), light);
            }
        }
        if layers.has(Layers::BACKGROUND) {
            // samples of the background show nothing else
            let [r, g, b] = diffuse;
            let shown = Vec3x8::load([r, g, b], first);
            let [r, g, b] = &mut parts.sky;
            is_surface.select3(Vec3x8::ZERO, shown).store([r, g, b], first);
        }
    }
    if layers.has(Layers::CATCHER) {
        parts.catcher.iter_mut().for_each(|column| column[first..first + LANES].fill(1.0));
    }
    if layers.has(Layers::GUIDES) {
        guide(frame, tile, first, placed, parts);
    }
}

/// Diffuse light on eight samples of the lights that are `among` these, by number, as far as their points have
/// `reached` the samples. It is summed anew, and not taken as a difference from the light that samples store: that is rounded as a whole,
/// and in a shadow the rounding of the other parts would show.
pub fn direct(
    frame: &FrameView,
    tile: &Tile,
    first: usize,
    placed: &mut PlacedTile,
    albedo: Vec3x8,
    among: impl Fn(usize) -> bool,
    reached: impl Fn(TagSlot, usize) -> Mask,
) -> Vec3x8 {
    if frame.pose.lights.is_empty() || !tile.model[first..first + LANES].iter().any(|model| *model < EMPTY) {
        return Vec3x8::ZERO;
    }
    let placed = placed.get(frame, tile, first);
    let mut sum = Vec3x8::ZERO;
    for (number, slot) in (0..).zip(frame.slots).filter(|(light, _)| among(*light)) {
        // a catcher asks what would be lit if nothing cast shadows
        let lit = frame.lit_bits(number, &tile.model[first..first + LANES]);
        frame.pose.each_of_light(
            number,
            || tile.ticks(first),
            |light, bits| {
                let at = (placed.point, tile.gathered.seeds(first));
                let places = Places::new(frame, at, || tile.ticks(first));
                let reached = |point| reached(*slot, point) & Mask::from_bits(bits & lit);
                sum = add_light(frame, sum, light, places, reached, |light_sample| {
                    phong::diffuse(albedo, placed.normal, placed.smooth, light_sample)
                });
            },
        );
    }
    sum
}

/// Computes albedo and normals of eight samples, for denoisers. Smooth mirrors and glass have none of their own:
/// rays that go on bring those of surfaces [seen by way of them](see).
fn guide(frame: &FrameView, tile: &Tile, first: usize, placed: &mut PlacedTile, parts: &mut Parts) {
    let models = &tile.model[first..first + LANES];
    let is_surface = Mask::less(models, EMPTY);
    let (mut albedo, mut normal) = (Vec3x8::ZERO, Vec3x8::ZERO);
    if is_surface.any() {
        let looks = tile.looks(first);
        albedo = own_albedo(frame, &looks, tile.reflectances(first));
        let shows_itself = Mask::new(|lane| shows_itself(frame, looks[lane])) & is_surface;
        normal = shows_itself.select3(placed.get(frame, tile, first).normal, Vec3x8::ZERO);
        albedo = is_surface.select3(most_is_one(albedo), Vec3x8::ZERO);
    }
    let [r, g, b] = &mut parts.guide_albedo;
    albedo.store([r, g, b], first);
    let [x, y, z] = &mut parts.guide_normal;
    normal.store([x, y, z], first);
}

/// Albedo of eight surfaces for denoisers: the diffuse one, and the reflectance of rough layers at normal incidence. No ray goes on
/// from these, and metal has no other albedo.
fn own_albedo(frame: &FrameView, looks: &[Look; LANES], reflectance: Vec3x8) -> Vec3x8 {
    let diffuse = frame.palette.albedo(looks, reflectance);
    frame.palette.bsdfs.rough_over(looks, reflectance, diffuse)
}

fn most_is_one(color: Vec3x8) -> Vec3x8 {
    let cut = |value: F32x8| value.min(F32x8::splat(1.0));
    Vec3x8 { x: cut(color.x), y: cut(color.y), z: cut(color.z) }
}

/// Returns true if denoisers see surfaces of this look themselves, and not those seen by way of them.
pub fn shows_itself(frame: &FrameView, look: Look) -> bool {
    frame.settings.depth == 0
        || frame.palette.is_diffuse(look.material)
        || frame.palette.bsdfs.is_rough(look)
        || !frame.palette.goes_on(look)
}

/// Adds to the guides of the sample in `cell` the albedo and the normal of `surface`, which is seen by way of
/// mirrors and glass that let `weight` of its light through. `with_normal`: none of the surfaces before
/// [shows itself](shows_itself).
pub fn see(
    frame: &FrameView,
    parts: &mut Parts,
    cell: usize,
    surface: &Surface,
    weight: glam::Vec3,
    with_normal: bool,
) {
    let looks = [surface.look(); LANES];
    let albedo = own_albedo(frame, &looks, Vec3x8::splat(surface.reflectance)).lane(0);
    for (column, share) in parts.guide_albedo.iter_mut().zip((albedo * weight).to_array()) {
        column[cell] = (column[cell] + share).clamp(0.0, 1.0);
    }
    if with_normal && shows_itself(frame, surface.look()) {
        let normal = surface.normal * weight.element_sum() / 3.0;
        for (column, share) in parts.guide_normal.iter_mut().zip(normal.to_array()) {
            column[cell] = (column[cell] + share).clamp(-1.0, 1.0);
        }
    }
}

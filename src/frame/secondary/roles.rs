//! Models that the eye does not see as themselves: holes in the picture, and catchers, of which it sees no more than the
//! shadows on them. Their samples are kept and lit as all others are; only what is shown of them differs.
//!
//! A catcher covers what is behind the picture by the share of light that is kept from it: one minus the light that
//! arrives over the light that would arrive if nothing were in the way, channels added up. Both are of the shot's lights,
//! of ambient light, and of the sky. Of the sky both are the means of the same kept paths, so that an open place covers
//! exactly nothing, however few paths there are.

use glam::Vec3;

use super::parts::direct;
use crate::frame::grid::bits::{bits_of_models, set_bits};
use crate::frame::light::indirect::start_at;
use crate::frame::light::light_paths::light_of_open_sky;
use crate::frame::light::path_ends::PathStart;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::placed::PlacedTile;
use crate::frame::surface::radiance::Radiance;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::layers::Layers;
use crate::samples::{CELLS, PathColor, Tile};
use crate::scene::Role;
use crate::settings::Backdrop;

/// Bit mask of those of eight samples of such models.
#[inline(always)]
pub fn bits(frame: &FrameView, models: &[u32]) -> u8 {
    if frame.roles.is_empty() {
        return 0;
    }
    bits_of_models(models, |model| frame.role(model) != Role::Itself)
}

/// Replaces what `radiance` has of the samples of such models.
pub fn show(frame: &FrameView, tile: &Tile, placed: &mut PlacedTile, radiance: &mut Radiance) {
    for first in (0..CELLS).step_by(LANES) {
        let models = &tile.model[first..first + LANES];
        let of_role = |role: Role| Mask::new(|lane| frame.role(models[lane]) == role).bits();
        let [holes, catchers] = [Role::Holdout, Role::ShadowCatcher].map(of_role);
        if holes | catchers == 0 {
            continue;
        }
        radiance.open_secondary();
        for lane in set_bits(holes | catchers) {
            radiance.hold_out(first + lane);
        }
        if catchers == 0 {
            continue;
        }
        let light = light(frame, tile, (first, catchers), placed);
        let [_, sights] = frame.sights(tile, first);
        for (cell, lane) in set_bits(catchers).map(|lane| (first + lane, lane)) {
            let light = light.map(|light| light.lane(lane));
            let clear = clear(light);
            if frame.layers.has(Layers::CATCHER) {
                let shares = clear_by_channel(light, clear).to_array();
                radiance
                    .parts
                    .catcher
                    .iter_mut()
                    .zip(shares)
                    .for_each(|(column, share)| column[cell] = share);
            }
            let background = frame.sky.seen(sights.lane(lane).normalize_or_zero()) * clear;
            if frame.layers.has(Layers::BACKGROUND) {
                radiance.add_sky(cell, background);
            }
            if frame.settings.background == Backdrop::Visible {
                radiance.show_behind(cell, background);
            } else {
                radiance.clear[cell] = clear;
            }
        }
    }
}

/// Share of light that is not kept from a place, from that which arrives and that which would: the mean of the shares of those
/// channels that have any, as in Cycles.
fn clear([arrives, would]: [Vec3; 2]) -> f32 {
    let shares = arrives.to_array().into_iter().zip(would.to_array()).filter(|(_, would)| *would > 0.0);
    let (sum, count) =
        shares.fold((0.0, 0.0), |(sum, count), (arrives, would)| (sum + arrives / would, count + 1.0));
    let share: f32 = sum / count;
    // a place that no light could reach is in no shadow
    if share.is_finite() { share.clamp(0.0, 1.0) } else { 1.0 }
}

/// Share of each channel's light that is not kept from a place; `all`: that of a channel in which no light could reach it.
fn clear_by_channel([arrives, would]: [Vec3; 2], all: f32) -> Vec3 {
    let share = |channel: usize| {
        let share = arrives[channel] / would[channel];
        if would[channel] > 0.0 && share.is_finite() { share.clamp(0.0, 1.0) } else { all }
    };
    Vec3::new(share(0), share(1), share(2))
}

/// Light that arrives at those of eight samples whose bit is set, and that which would if nothing were in the way.
fn light(
    frame: &FrameView,
    tile: &Tile,
    (first, wanted): (usize, u8),
    placed: &mut PlacedTile,
) -> [Vec3x8; 2] {
    let white = Vec3x8::splat(Vec3::ONE);
    let looks = tile.looks(first);
    let has_ambient = Mask::new(|lane| frame.palette.has_ambient(looks[lane].material));
    let ambient = has_ambient.select3(Vec3x8::splat(frame.scene.ambient), Vec3x8::ZERO);
    let is_occluded = frame.occlusion.is_some_and(|occlusion| occlusion.dims_ambient);
    let openness = if is_occluded { tile.gathered.opennesses(first) } else { F32x8::ONE };
    let lit = |slot, point| tile.tags.lit(slot, point, first);
    let all = |_, _| Mask::from_bits(u8::MAX);
    let mut arrives = ambient * openness + direct(frame, tile, first, placed, white, |_| true, lit);
    let mut would = ambient + direct(frame, tile, first, placed, white, |_| true, all);
    if frame.paths > 0 {
        let placed = placed.get(frame, tile, first);
        for lane in set_bits(wanted) {
            let cell = first + lane;
            if !frame.palette.is_diffuse(tile.record[cell].material) {
                continue;
            }
            let start = start_at(frame, tile, cell, &placed, frame.paths);
            let (mut sums, mut count) = ([Vec3::ZERO; 2], 0);
            for (path, index) in tile.gathered.paths.known(cell).zip(0..) {
                let open = light_of_open_sky(frame, &PathStart { index, ..start });
                sums[0] += path.light.color();
                // rounded as what is kept
                sums[1] += PathColor::new(open, false).color();
                count += 1;
            }
            let mean = |sum: Vec3| sum / count.max(1) as f32;
            arrives.set_lane(lane, arrives.lane(lane) + mean(sums[0]));
            would.set_lane(lane, would.lane(lane) + mean(sums[1]));
        }
    }
    [arrives, would]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_covers_by_the_light_that_is_kept_from_it() {
        let white = Vec3::ONE;
        for (arrives, would, expected) in [
            (white, white, 1.0),
            (white * 0.25, white, 0.25),
            (Vec3::new(0.0, 3.0, 0.0), Vec3::new(1.0, 3.0, 0.0), 0.5),
            (white * 2.0, white, 1.0),
            (Vec3::ZERO, Vec3::ZERO, 1.0),
            (Vec3::NAN, white, 1.0),
        ] {
            assert_eq!(clear([arrives, would]), expected, "{arrives} of {would}");
        }
    }
}

//! Mask bits of rays, instances and geometries: a ray meets what shares a bit with it at every level.
//!
//! Instances have a bit for each kind of rays that sees their model: one of two, by whether the model moved. Geometries
//! have a bit for each kind, too; shadow rays have two, since clear triangles may let them pass.
//!
//! Shadow rays to lights in whose light some models alone cast shadows have a bit for each such set of models, and that of geometries that
//! cast shadows. Instances have the bits of the sets that their model is in. Geometries that no instance places have them, too, and
//! therefore no bits for geometries that cast shadows: that for instances at rest stands for both.

use crate::scene::{BlockerSet, RayKind, RayKinds};

/// Instance or geometry that is not there: no ray meets it.
pub const HIDDEN: u32 = 0;

/// Number of kinds of rays.
const KINDS: u32 = RayKind::ALL.len() as u32;
/// First bit of instances whose model is where it was in the frame before, or always.
const RESTS: u32 = 0;
/// First bit of instances whose model moved since the frame before.
const MOVED: u32 = KINDS;
/// First bit of geometries.
const GEOMETRY: u32 = 2 * KINDS;
/// Geometry whose triangles cast shadows, seen by shadow rays.
const CASTS_SHADOW: u32 = 1 << (GEOMETRY + RayKind::Shadow as u32);
/// Geometry whose triangles cast no shadows, seen by shadow rays.
const CLEAR: u32 = CASTS_SHADOW << 1;
/// First bit of the sets of models that cast shadows in some lights.
const SETS: u32 = GEOMETRY + KINDS + 1;

const _: () = assert!(SETS as usize + BlockerSet::MOST <= u32::BITS as usize);

/// Rays that see a model.
#[derive(Debug, Clone, Copy)]
pub struct SeenBy {
    pub kinds: RayKinds,
    /// Bits of the sets of models that it is in: see [`BlockerSets::bits_of`](crate::scene::BlockerSets::bits_of).
    pub sets: u16,
}

impl SeenBy {
    /// Bits of those of its sets that matter: what shadow rays do not see is in none.
    fn sets(self) -> u32 {
        if self.kinds.has(RayKind::Shadow) { u32::from(self.sets) << SETS } else { 0 }
    }
}

/// Mask of an instance of a model that these rays see.
pub fn of_instance(seen_by: SeenBy, moved: bool) -> u32 {
    u32::from(seen_by.kinds.bits()) << if moved { MOVED } else { RESTS } | seen_by.sets()
}

/// Mask of a geometry that these rays see.
pub fn of_geometry(seen_by: RayKinds, casts_shadow: bool) -> u32 {
    let mask = u32::from(seen_by.bits()) << GEOMETRY;
    if casts_shadow || mask & CASTS_SHADOW == 0 { mask } else { mask & !CASTS_SHADOW | CLEAR }
}

/// Mask of a geometry that no instance places, of a scene in which some models alone cast shadows in some lights. `clear_passes`: see
/// [`of_ray`].
pub fn of_geometry_in_sets(seen_by: SeenBy, casts_shadow: bool, clear_passes: bool) -> u32 {
    let of_kinds = of_geometry(seen_by.kinds, casts_shadow) & !(CASTS_SHADOW | CLEAR);
    let blocks = seen_by.kinds.has(RayKind::Shadow) && (casts_shadow || !clear_passes);
    if blocks { of_kinds | 1 << (RESTS + RayKind::Shadow as u32) | seen_by.sets() } else { of_kinds }
}

/// Mask of a shadow ray that only the models of `set` block. Whether these moved makes no difference: one that did not blocks the ray as
/// it did before.
pub fn of_linked_ray(set: BlockerSet, clear_passes: bool) -> u32 {
    let clear = if clear_passes { 0 } else { CLEAR };
    1 << (SETS as usize + set.number() - 1) | CASTS_SHADOW | clear
}

/// Mask of a ray. `moved_alone`: among instances it meets none but those that moved. `clear_passes`: clear triangles
/// let it pass, if it is a shadow ray.
pub fn of_ray(kind: RayKind, moved_alone: bool, clear_passes: bool) -> u32 {
    let bit = 1 << kind as u32;
    let instances = bit << MOVED | if moved_alone { 0 } else { bit << RESTS };
    let clear = if kind == RayKind::Shadow && !clear_passes { CLEAR } else { 0 };
    instances | bit << GEOMETRY | clear
}

/// Returns true if clear triangles let a ray of this mask pass.
pub fn clear_passes(of_ray: u32) -> bool {
    of_ray & (CASTS_SHADOW | CLEAR) == CASTS_SHADOW
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen_by(kinds: RayKinds) -> SeenBy {
        SeenBy { kinds, sets: 0 }
    }

    #[test]
    fn a_ray_meets_what_its_kind_sees_and_nothing_else() {
        for hidden_from in RayKind::ALL {
            let seen_by = RayKinds::NONE.with(hidden_from).others();
            for kind in RayKind::ALL {
                let ray = of_ray(kind, false, true);
                let sees = kind != hidden_from;
                assert_eq!(ray & of_geometry(seen_by, true) != 0, sees, "{kind:?}, {hidden_from:?}");
                for moved in [false, true] {
                    assert_eq!(
                        ray & of_instance(SeenBy { kinds: seen_by, sets: 0 }, moved) != 0,
                        sees,
                        "{kind:?}, {hidden_from:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn clear_triangles_block_all_but_shadow_rays_that_they_let_pass() {
        let meets =
            |kind, clear_passes| of_ray(kind, false, clear_passes) & of_geometry(RayKinds::ALL, false) != 0;
        assert_eq!(RayKind::ALL.map(|kind| meets(kind, true)), [true, true, true, true, false]);
        assert_eq!(RayKind::ALL.map(|kind| meets(kind, false)), [true; 5]);
        let never = of_geometry(RayKinds::NONE.with(RayKind::Shadow).others(), false);
        assert_eq!(of_ray(RayKind::Shadow, false, false) & never, 0, "it is hidden from them");
    }

    #[test]
    fn rays_among_what_moved_pass_what_rests() {
        let ray = of_ray(RayKind::Camera, true, true);
        let meets = |moved| ray & of_instance(seen_by(RayKinds::ALL), moved) != 0;
        assert_eq!([false, true].map(meets), [false, true]);
    }

    #[test]
    fn linked_rays_are_blocked_by_their_sets_and_others_as_if_there_were_none() {
        let [first, second] = [0b1_u16, 0b10];
        let set = |number: usize| BlockerSet::nth(number);
        for kinds in [RayKinds::ALL, RayKinds::NONE.with(RayKind::Shadow).others()] {
            let is_seen = kinds.has(RayKind::Shadow);
            for (sets, [by_first, by_second]) in [
                (0, [false; 2]),
                (first, [true, false]),
                (second, [false, true]),
                (first | second, [true; 2]),
            ] {
                let seen = SeenBy { kinds, sets };
                for (casts, passes) in [(true, true), (true, false), (false, true), (false, false)] {
                    let ray = |number: usize| of_linked_ray(set(number), passes);
                    let blocks = is_seen && (casts || !passes);
                    let placed = of_geometry(RayKinds::ALL, casts);
                    let free = of_geometry_in_sets(seen, casts, passes);
                    for (number, is_in) in [(1, by_first), (2, by_second)] {
                        assert_eq!(ray(number) & free != 0, blocks && is_in, "{sets:b} {casts} {passes}");
                        for moved in [false, true] {
                            let instance = of_instance(seen, moved);
                            let meets = ray(number) & instance != 0 && ray(number) & placed != 0;
                            assert_eq!(meets, blocks && is_in, "{sets:b} {casts} {passes}");
                        }
                    }
                    for kind in RayKind::ALL {
                        let ray = of_ray(kind, false, passes);
                        let before = ray & of_geometry(kinds, casts) != 0;
                        assert_eq!(ray & free != 0, before, "{kind:?} {casts} {passes}");
                        let instance = of_instance(seen, true);
                        assert_eq!(ray & instance != 0, kinds.has(kind), "{kind:?}");
                    }
                }
            }
        }
    }
}

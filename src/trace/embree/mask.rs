//! Mask bits of rays, instances and geometries: a ray meets what shares a bit with it at every level.
//!
//! Instances have a bit for each kind of rays that sees their model: one of two, by whether the model moved. Geometries
//! have a bit for each kind, too; shadow rays have two, since clear triangles may let them pass.

use crate::scene::{RayKind, RayKinds};

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

/// Mask of an instance of a model that these rays see.
pub fn of_instance(seen_by: RayKinds, moved: bool) -> u32 {
    u32::from(seen_by.bits()) << if moved { MOVED } else { RESTS }
}

/// Mask of a geometry that these rays see.
pub fn of_geometry(seen_by: RayKinds, casts_shadow: bool) -> u32 {
    let mask = u32::from(seen_by.bits()) << GEOMETRY;
    if casts_shadow || mask & CASTS_SHADOW == 0 { mask } else { mask & !CASTS_SHADOW | CLEAR }
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

    #[test]
    fn a_ray_meets_what_its_kind_sees_and_nothing_else() {
        for hidden_from in RayKind::ALL {
            let seen_by = RayKinds::NONE.with(hidden_from).others();
            for kind in RayKind::ALL {
                let ray = of_ray(kind, false, true);
                let sees = kind != hidden_from;
                assert_eq!(ray & of_geometry(seen_by, true) != 0, sees, "{kind:?}, {hidden_from:?}");
                for moved in [false, true] {
                    assert_eq!(ray & of_instance(seen_by, moved) != 0, sees, "{kind:?}, {hidden_from:?}");
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
        let meets = |moved| ray & of_instance(RayKinds::ALL, moved) != 0;
        assert_eq!([false, true].map(meets), [false, true]);
    }
}

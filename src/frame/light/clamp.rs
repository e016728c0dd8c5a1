//! Limit to the indirect light of a single ray or path, if the shot has one: light that is found by chance
//! and is far brighter than its surroundings shows as a spark ("firefly"). The limit is the shot's `clamp`;
//! it removes light.

use glam::Vec3;

use super::path_ends::PathResult;

/// Scales `light` down, all three channels alike, if any of them is above `most`.
pub fn limited(light: Vec3, most: f32) -> Vec3 {
    let largest = light.max_element();
    // first to at most 1: infinite light must not become none
    if largest > most { light.min(Vec3::splat(f32::MAX)) / largest.min(f32::MAX) * most } else { light }
}

/// Limits the indirect light of each path: all but its `direct` light, which its radiance includes.
pub fn limit_paths(brought: &mut [PathResult], direct: &[Vec3], most: f32) {
    for (brought, direct) in brought.iter_mut().zip(direct) {
        let indirect = (brought.radiance - *direct).max(Vec3::ZERO);
        if indirect.max_element() > most {
            brought.radiance = *direct + limited(indirect, most);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::changes::Until;

    #[test]
    fn light_above_the_limit_keeps_its_colour() {
        assert_eq!(limited(Vec3::new(8.0, 4.0, 0.0), 2.0), Vec3::new(2.0, 1.0, 0.0));
        let below = Vec3::new(1.9, 0.3, 2.0);
        assert_eq!(limited(below, 2.0), below);
        assert_eq!(limited(Vec3::new(f32::INFINITY, 0.0, 1.0), 2.0).x, 2.0);
        assert_eq!(limited(Vec3::ZERO, 2.0), Vec3::ZERO);
    }

    #[test]
    fn direct_light_stays_however_bright() {
        let path = |radiance| PathResult {
            radiance: Vec3::splat(radiance),
            sees_light: false,
            until: Until::FOREVER,
        };
        let direct = [Vec3::splat(50.0), Vec3::splat(50.0), Vec3::ZERO];
        let mut brought = [path(51.5), path(90.0), path(3.0)];
        limit_paths(&mut brought, &direct, 2.0);
        assert_eq!(brought, [path(51.5), path(52.0), path(2.0)]);
    }
}

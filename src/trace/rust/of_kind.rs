//! Kinds of rays that see the same models share their trees.

use crate::scene::{RayKind, Scene};

/// Number of the trees, among those of a backend, that rays of each kind see.
pub type TreesOfKind = [usize; RayKind::ALL.len()];

/// Kinds of rays no two of which see the same models of `scene`, and for each kind of all the number of the one that sees
/// the same as it.
pub fn distinct(scene: &Scene) -> (Vec<RayKind>, TreesOfKind) {
    let mut kinds: Vec<RayKind> = Vec::new();
    let of_kind = RayKind::ALL.map(|kind| {
        let sees_alike = |other: &RayKind| {
            let mut all = scene.models.iter().map(|model| model.ray_visibility);
            all.all(|visibility| visibility.is_seen_by(kind) == visibility.is_seen_by(*other))
        };
        kinds.iter().position(sees_alike).unwrap_or_else(|| {
            kinds.push(kind);
            kinds.len() - 1
        })
    });
    (kinds, of_kind)
}

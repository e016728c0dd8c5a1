//! Pictures for people to look at.

use afterimage::film::{Film, Plane, PlaneKind};
use glam::Vec3;

use crate::picture::Picture;

/// Draws the reference, the picture, and grey plus four times their difference, side by side.
pub fn side_by_side(reference: &Picture, picture: &Picture) -> Film {
    const TIMES: f32 = 4.0;
    let width = reference.width;
    let difference: Vec<Vec3> =
        picture.less(reference).iter().map(|less| Vec3::splat(0.5) + *less * TIMES).collect();
    let panels = [&reference.colors, &picture.colors, &difference];
    let rows = (0..reference.colors.len()).step_by(width);
    let all: Vec<Vec3> =
        rows.flat_map(|row| panels.map(|panel| &panel[row..row + width])).flatten().copied().collect();
    let plane = |name, axis: usize| {
        Plane::new(name, PlaneKind::Float, &all.iter().map(|color| color[axis]).collect::<Vec<f32>>())
    };
    Film {
        width: 3 * width as u32,
        height: (reference.colors.len() / width) as u32,
        planes: vec![plane("R", 0), plane("G", 1), plane("B", 2)],
    }
}

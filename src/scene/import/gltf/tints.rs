//! Colours of vertices of materials that are unlit.
//!
//! A material emits one colour, times that of a picture. So triangles are put together whose vertices have the same colour in the mean,
//! and each of these has a material of its own: flat colours, as models have that are painted by vertices alone, are exact.

use std::collections::BTreeSet;
use std::ops::Range;

use glam::{DVec3, Vec3};

use super::geometry::Geometry;

/// Number of colours of a material, beyond which those that are alike are one.
const MOST_TINTS: usize = 1024;

impl Geometry {
    /// Orders the triangles in `range` by the colours of their vertices. Returns those of one colour, with the colour, linear RGB; and true
    /// if all vertices have the colour of their triangle.
    pub fn by_tint(&mut self, range: Range<usize>) -> (Vec<(Range<usize>, Vec3)>, bool) {
        let color = |corner: u32| DVec3::from(self.colors[corner as usize].map(f64::from));
        let mean = |triangle: &[u32; 3]| triangle.map(color).into_iter().sum::<DVec3>() / 3.0;
        let is_even =
            |triangle: &[u32; 3]| triangle.iter().all(|corner| color(*corner) == color(triangle[0]));
        let triangles = &self.triangles[range.clone()];
        let is_exact = triangles.iter().all(is_even);
        let means: Vec<DVec3> = triangles.iter().map(mean).collect();
        // finest steps by which there are few enough colours; square roots are about as far apart as colours look
        let steps = [255.0, 63.0, 31.0, 15.0, 7.0];
        let code = |mean: &DVec3, steps: f64| {
            (mean.max(DVec3::ZERO).powf(0.5) * steps).round().to_array().map(|step| step as u32)
        };
        let codes = steps.into_iter().map(|steps| means.iter().map(|mean| code(mean, steps)).collect());
        let is_fine = |codes: &Vec<[u32; 3]>| codes.iter().collect::<BTreeSet<_>>().len() <= MOST_TINTS;
        // with 8 steps for each channel there are 512 at most
        let codes: Vec<[u32; 3]> = codes.into_iter().find(is_fine).unwrap_or_default();
        let mut order: Vec<usize> = (0..codes.len()).collect();
        order.sort_by_key(|triangle| codes[*triangle]);
        let ordered: Vec<[u32; 3]> = order.iter().map(|triangle| triangles[*triangle]).collect();
        let mut runs = Vec::new();
        let mut begin = range.start;
        for alike in order.chunk_by(|a, b| codes[*a] == codes[*b]) {
            let tint = alike.iter().map(|triangle| means[*triangle]).sum::<DVec3>() / alike.len() as f64;
            runs.push((begin..begin + alike.len(), tint.as_vec3()));
            begin += alike.len();
        }
        self.triangles[range].copy_from_slice(&ordered);
        (runs, is_exact)
    }
}

#[cfg(test)]
mod tests {
    use half::f16;

    use super::*;

    fn geometry(colors: &[[f32; 3]], triangles: &[[u32; 3]]) -> Geometry {
        let colors = colors.iter().map(|color| color.map(f16::from_f32)).collect();
        Geometry { colors, triangles: triangles.to_vec(), ..Geometry::default() }
    }

    #[test]
    fn triangles_of_one_colour_come_together() {
        let [red, blue] = [[1.0, 0.0, 0.0], [0.0, 0.25, 0.5]];
        let colors = [red, red, red, blue, blue, blue];
        let mut paint = geometry(&colors, &[[9, 9, 9], [3, 4, 5], [0, 1, 2], [5, 4, 3], [0, 2, 1]]);
        let (runs, is_exact) = paint.by_tint(1..5);
        assert_eq!(runs, [(1..3, Vec3::from(blue)), (3..5, Vec3::from(red))]);
        assert_eq!(paint.triangles, [[9, 9, 9], [3, 4, 5], [5, 4, 3], [0, 1, 2], [0, 2, 1]]);
        assert!(is_exact);
        let (runs, is_exact) = geometry(&[red, red, blue], &[[0, 1, 2]]).by_tint(0..1);
        assert!(runs[0].1.abs_diff_eq(Vec3::new(2.0, 0.25, 0.5) / 3.0, 1e-6) && !is_exact);
    }

    #[test]
    fn of_many_colours_those_that_are_alike_are_one() {
        let color = |i: u32| [i % 20, i / 20 % 20, i / 400].map(|step| step as f32 / 20.0);
        let colors: Vec<[f32; 3]> = (0..8000).map(color).collect();
        let triangles: Vec<[u32; 3]> = (0..8000).map(|i| [i; 3]).collect();
        let (runs, _) = geometry(&colors, &triangles).by_tint(0..8000);
        assert!((200..=MOST_TINTS).contains(&runs.len()), "{}", runs.len());
        assert_eq!(runs.last().map(|(range, _)| range.end), Some(8000));
    }
}

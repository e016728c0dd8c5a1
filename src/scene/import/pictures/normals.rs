//! Normals of pictures of heights.

use crate::scene::texture::Texels;

/// Returns true if a picture seems to hold directions of normals: most of them point out of the surface, which is blue. Files
/// state such pictures as bump maps as well.
pub fn are_normals(texels: &Texels) -> bool {
    let value = |texel: usize, channel: usize| u64::from(texels.get(texel).bytes()[channel]);
    let sum = |channel: usize| (0..texels.count()).map(|texel| value(texel, channel)).sum::<u64>();
    let mean = |channel: usize| sum(channel) as f64 / texels.count().max(1) as f64;
    let [red, green, blue] = [0, 1, 2].map(mean);
    let is_upright = |mean: f64| (96.0..160.0).contains(&mean);
    is_upright(red) && is_upright(green) && blue > 170.0
}

/// Directions of the normals of a surface with these heights, as a normal map holds them, rows from the top; and the factor for
/// their slopes, by which the map uses all of its range. A step of the whole range from one texel to the next is a slope of one.
/// The picture repeats.
pub fn of_heights(texels: &Texels, width: u32) -> (Vec<[u8; 4]>, f32) {
    let width = width as usize;
    let height = texels.count() / width;
    let mean = |texel: usize| texels.get(texel).numbers().truncate().element_sum() / 3.0;
    let heights: Vec<f32> = (0..texels.count()).map(mean).collect();
    // slopes to the right and upwards, over two texels
    let slopes = |texel: usize| {
        let (x, y) = (texel % width, texel / width);
        let at = |x: usize, y: usize| heights[y % height * width + x % width];
        let right = at(x + 1, y) - at(x + width - 1, y);
        let up = at(x, y + height - 1) - at(x, y + 1);
        [right / 2.0, up / 2.0]
    };
    let all = || (0..texels.count()).map(slopes);
    let steepest = all().flatten().fold(0.0, |most: f32, slope| most.max(slope.abs()));
    if steepest == 0.0 {
        return (vec![[128, 128, 255, 255]; texels.count()], 0.0);
    }
    let byte = |slope: f32| (127.5 - 127.5 * slope / steepest).round() as u8;
    (all().map(|[right, up]| [byte(right), byte(up), 255, 255]).collect(), steepest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(texels: &[[u8; 4]]) -> Texels {
        Texels::Bytes(texels.into())
    }

    #[test]
    fn normals_lean_away_from_what_is_higher() {
        let grey = |height: u8| [height, height, height, 255];
        // rises to the right: 0, 51, 102, and back
        let (normals, slope) = of_heights(&bytes(&[grey(0), grey(51), grey(102), grey(51)]), 4);
        assert!((slope - 0.2).abs() < 1e-6, "{slope}");
        assert_eq!(
            normals,
            [[128, 128, 255, 255], [0, 128, 255, 255], [128, 128, 255, 255], [255, 128, 255, 255]]
        );
        // rises upwards
        let (normals, _) = of_heights(&bytes(&[grey(102), grey(51), grey(0), grey(51)]), 1);
        assert_eq!(normals[1], [128, 0, 255, 255]);
        assert_eq!(of_heights(&bytes(&[grey(9); 6]), 3).1, 0.0);
    }

    #[test]
    fn blue_pictures_are_normals() {
        assert!(are_normals(&bytes(&[[128, 127, 255, 255], [90, 160, 230, 255]])));
        assert!(!are_normals(&bytes(&[[128, 128, 128, 255], [200, 200, 200, 255]])));
        assert!(!are_normals(&bytes(&[[20, 40, 255, 255]])));
    }
}

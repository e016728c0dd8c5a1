//! Layout of tiles along one axis of the picture.
//!
//! Tiles are counted from the picture's edges, whatever part of it and of its surroundings is rendered, and
//! none lies on both sides of an edge. So a tile has the same cells, and its rays the same company, with a
//! crop or overscan as without: its samples are the same to the bit. That is why a crop renders whole tiles.

use std::ops::Range;

/// Tiles along one axis, in pixels counted from the picture's first; pixels of the overscan before it are
/// negative.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// First pixel of each tile, then the end of the last.
    starts: Vec<i32>,
    /// Pixels of the film. Tiles at its ends may reach beyond.
    film: Range<i32>,
    /// Pixels of the picture.
    picture: Range<i32>,
}

impl Axis {
    /// Lays out those tiles, of up to `tile` pixels, whose samples show in the pixels `film` when a sample
    /// reaches `reach` pixels far. The picture has `size` pixels, and `overscan` more before and after it.
    pub fn new(size: u32, overscan: u32, film: Range<i32>, tile: u32, reach: u32) -> Self {
        let [size, overscan, reach] = [size, overscan, reach].map(|count| count as i32);
        let step = tile as usize;
        let before = (0..overscan).step_by(step).map(|at| -(at + tile as i32).min(overscan));
        let mut starts: Vec<i32> = before.collect();
        starts.reverse();
        starts.extend((0..size).step_by(step));
        starts.extend((size..size + overscan).step_by(step));
        starts.push(size + overscan);
        let needed = film.start - reach..film.end + reach;
        let first = starts.iter().skip(1).take_while(|end| **end <= needed.start).count();
        let end = starts.iter().take_while(|start| **start < needed.end).count();
        // the end of the last one stays
        starts.truncate(end + 1);
        starts.drain(..first.min(end));
        Self { starts, film, picture: 0..size }
    }

    /// Number of tiles.
    pub fn count(&self) -> usize {
        self.starts.len() - 1
    }

    /// Pixels of tile number `tile`.
    #[inline]
    pub fn tile(&self, tile: usize) -> Range<i32> {
        self.starts[tile]..self.starts[tile + 1]
    }

    /// Pixels of all tiles.
    pub fn all(&self) -> Range<i32> {
        self.starts[0]..self.starts[self.count()]
    }

    /// Number of pixels of the film.
    pub fn film(&self) -> usize {
        self.film.len()
    }

    /// Converts a pixel to one counted from the film's first.
    #[inline]
    pub fn in_film(&self, pixel: i32) -> i32 {
        pixel - self.film.start
    }

    /// Pixels of tile number `tile` that are in the film, counted from the film's first. Empty for a tile
    /// that exists only for its neighbours' sake.
    #[inline]
    pub fn film_of(&self, tile: usize) -> Range<usize> {
        self.border(tile)..self.border(tile + 1)
    }

    #[inline]
    fn border(&self, tile: usize) -> usize {
        self.in_film(self.starts[tile].clamp(self.film.start, self.film.end)) as usize
    }

    /// Where in the film these tiles begin, counted from its first pixel; one more than the last tile's number is where
    /// that ends.
    pub fn borders(&self, tiles: impl IntoIterator<Item = usize>) -> Vec<usize> {
        tiles.into_iter().map(|tile| self.border(tile)).collect()
    }

    /// Divides pixels of the film, counted from its first, into pieces of up to `size`, none of which crosses
    /// an edge of the picture.
    pub fn pieces(&self, pixels: Range<usize>, size: usize) -> Vec<Range<usize>> {
        let edges = [self.picture.start, self.picture.end].map(|edge| self.in_film(edge).max(0) as usize);
        let mut pieces = Vec::new();
        let mut start = pixels.start;
        while start < pixels.end {
            let edge = edges.into_iter().find(|edge| *edge > start).unwrap_or(usize::MAX);
            let end = (start + size).min(pixels.end).min(edge);
            pieces.push(start..end);
            start = end;
        }
        pieces
    }

    /// Returns true if all these pixels of the film, counted from its first, belong to the picture.
    pub fn is_picture(&self, pixels: &Range<usize>) -> bool {
        let [start, end] = [pixels.start, pixels.end].map(|pixel| self.film.start + pixel as i32);
        self.picture.start <= start && end <= self.picture.end
    }

    /// Numbers of the tiles that have a pixel within `reach` of these pixels of the film, counted from its
    /// first. With `of_picture` only tiles of the picture, none of the overscan.
    pub fn tiles_within(&self, pixels: &Range<usize>, reach: u32, of_picture: bool) -> Range<usize> {
        let [start, end] = [pixels.start, pixels.end].map(|pixel| self.film.start + pixel as i32);
        self.tiles_between(start - reach as i32..end + reach as i32, of_picture)
    }

    /// Numbers of the tiles that have any of these pixels, which count from the picture's first. `of_picture`
    /// as above.
    pub fn tiles_between(&self, pixels: Range<i32>, of_picture: bool) -> Range<usize> {
        let bounds = if of_picture { &self.picture } else { &(i32::MIN..i32::MAX) };
        let (start, end) = (pixels.start.max(bounds.start), pixels.end.min(bounds.end));
        let first = self.starts[1..].partition_point(|tile_end| *tile_end <= start);
        let last = self.starts[..self.count()].partition_point(|tile_start| *tile_start < end);
        first..last.max(first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tiles(axis: &Axis) -> Vec<Range<i32>> {
        (0..axis.count()).map(|tile| axis.tile(tile)).collect()
    }

    #[test]
    fn a_whole_picture_has_tiles_from_its_first_pixel_on() {
        let axis = Axis::new(70, 0, 0..70, 32, 2);
        assert_eq!(tiles(&axis), [0..32, 32..64, 64..70]);
        assert_eq!(axis.borders([0, 2, 3]), [0, 64, 70]);
        assert_eq!(axis.film_of(2), 64..70);
    }

    #[test]
    fn no_tile_crosses_the_edge_of_the_picture() {
        let axis = Axis::new(70, 40, -40..110, 32, 2);
        assert_eq!(tiles(&axis), [-40..-32, -32..0, 0..32, 32..64, 64..70, 70..102, 102..110]);
        assert_eq!(axis.film_of(1), 8..40);
        assert_eq!(axis.pieces(30..120, 32), [30..40, 40..72, 72..104, 104..110, 110..120]);
        assert!(axis.is_picture(&(40..110)) && !axis.is_picture(&(39..110)) && !axis.is_picture(&(40..111)));
    }

    #[test]
    fn a_crop_has_the_whole_tiles_that_show_in_it() {
        let picture = Axis::new(200, 40, -40..240, 32, 0);
        for (film, reach) in [(33..64, 0), (33..64, 2), (0..1, 2), (63..65, 0), (199..200, 2), (-3..200, 2)] {
            let axis = Axis::new(200, 40, film.clone(), 32, reach);
            let wanted: Vec<Range<i32>> = tiles(&picture)
                .into_iter()
                .filter(|tile| tile.start < film.end + reach as i32 && tile.end > film.start - reach as i32)
                .collect();
            assert_eq!(tiles(&axis), wanted, "{film:?}");
            let shown: Vec<usize> = (0..axis.count()).flat_map(|tile| axis.film_of(tile)).collect();
            assert!(shown.into_iter().eq(0..film.len()), "{film:?}");
        }
    }

    #[test]
    fn tiles_are_found_by_their_pixels() {
        let axis = Axis::new(70, 40, -40..110, 32, 2);
        // the film's first pixel is the picture's -40th
        assert_eq!(axis.tiles_within(&(40..41), 2, false), 1..3);
        assert_eq!(
            axis.tiles_within(&(40..41), 2, true),
            2..3,
            "the picture's pixels take nothing from around it"
        );
        assert_eq!(axis.tiles_within(&(108..110), 2, false), 4..6);
        assert_eq!(axis.tiles_within(&(0..150), 2, false), 0..7);
        assert_eq!(axis.tiles_between(500..600, false), 7..7);
    }
}

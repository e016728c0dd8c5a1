//! The picture of a frame as the mean of its exposures, plane by plane, each by its own rule.

use rayon::prelude::*;

use super::mattes::{add_share, rank};
use super::variance::{MOST_LIGHT, UNKNOWN};
use crate::cryptomatte::{Id, Kind, RANKS};
use crate::film::{Film, Plane, Values};
use crate::frame::planes::channels::{Channel, PlaneSource, matte_planes};
use crate::frame::planes::mixing::MixRule;

/// Planes of the picture's colours.
const COLORS: [&str; 3] = ["R", "G", "B"];

/// Running sums over the exposures of a frame.
#[derive(Debug)]
pub struct Mean {
    width: u32,
    height: u32,
    /// State of each of the picture's planes.
    planes: Vec<Gathered>,
    /// Sums of the squares of the colours' components, if there is a plane of variance.
    squares: Option<Vec<f32>>,
    /// Rows of mattes, by kind; empty for kinds that no layer shows.
    mattes: [Vec<Row>; Kind::ALL.len()],
    /// Number of exposures that were added.
    count: u32,
}

/// State of a plane.
#[derive(Debug)]
enum Gathered {
    /// Zero throughout, or kept elsewhere (mattes).
    Nothing,
    /// Sums, or least values.
    Values(Vec<f32>),
    /// The plane of one exposure.
    Plane(Plane),
}

/// Shares of mattes in a row of pixels.
#[derive(Debug, Clone, Default, PartialEq)]
struct Row {
    /// Index of the first share of each pixel, and the end of the last pixel's.
    starts: Vec<u32>,
    /// Shares, summed over exposures.
    shares: Vec<(Id, f32)>,
}

impl Mean {
    /// Creates the empty mean of a picture with these planes and this size.
    pub fn new(channels: &[Channel], [width, height]: [u32; 2]) -> Self {
        Self {
            width,
            height,
            planes: channels.iter().map(|_| Gathered::Nothing).collect(),
            squares: (channels.iter().any(|channel| MixRule::new(channel) == MixRule::Variance))
                .then(|| vec![0.0; width as usize * height as usize]),
            mattes: Default::default(),
            count: 0,
        }
    }

    /// Adds the picture of an exposure. It must have all `channels` whose rule is not [`MixRule::Middle`].
    pub fn add(&mut self, film: &Film, channels: &[Channel]) {
        let first = self.count == 0;
        self.count += 1;
        self.planes.par_iter_mut().zip(channels).for_each(|(gathered, channel)| {
            let Some(plane) = film.plane(&channel.name) else { return };
            match MixRule::new(channel) {
                MixRule::Mean | MixRule::Sum | MixRule::Variance => gathered.add(plane),
                MixRule::Least => gathered.least(plane, first),
                MixRule::Middle => *gathered = Gathered::Plane(plane.clone()),
                MixRule::Matte => {}
            }
        });
        if let Some(squares) = &mut self.squares {
            for plane in COLORS.iter().filter_map(|name| film.plane(name)).filter(|plane| !plane.is_zero) {
                each(squares, &plane.values, |sum, value| *sum += value.min(MOST_LIGHT).powi(2));
            }
        }
        for kind in Kind::ALL {
            if let Some(planes) = planes_of(kind, film, channels) {
                self.add_mattes(kind, &planes);
            }
        }
    }

    fn add_mattes(&mut self, kind: Kind, planes: &[&Plane]) {
        let rows = &mut self.mattes[kind as usize];
        if planes.iter().all(|plane| plane.is_zero) && rows.is_empty() {
            return;
        }
        rows.resize_with(self.height as usize, Row::default);
        let width = self.width as usize;
        rows.par_iter_mut().enumerate().for_each(|(y, row)| {
            let mut shares = Vec::new();
            let mut sum = Row::default();
            for x in 0..width {
                shares.clear();
                shares.extend_from_slice(row.of(x));
                for rank in planes.chunks_exact(2) {
                    let [id, share] = [rank[0], rank[1]].map(|plane| plane.values.get(y * width + x));
                    if share > 0.0 {
                        add_share(&mut shares, Id(id.to_bits()), share);
                    }
                }
                sum.push(&shares);
            }
            *row = sum;
        });
    }

    /// Makes the picture.
    pub fn finish(self, channels: &[Channel]) -> Film {
        let pixels = self.width as usize * self.height as usize;
        let share = (self.count.max(1) as f32).recip();
        let mattes: Vec<Vec<Vec<f32>>> =
            self.mattes.iter().map(|rows| ranked(rows, self.width as usize, share)).collect();
        let spread = self.squares.map(|squares| spread(squares, &self.planes, channels, self.count));
        let planes = self.planes.into_par_iter().zip(channels).map(|(gathered, channel)| {
            let mut plane = Plane {
                name: channel.name.clone(),
                kind: channel.kind,
                values: channel.room(pixels),
                is_zero: false,
            };
            match (gathered, channel.source) {
                (Gathered::Plane(plane), _) => return plane,
                (Gathered::Values(mut sums), _) => {
                    match MixRule::new(channel) {
                        MixRule::Mean => sums.iter_mut().for_each(|sum| *sum *= share),
                        MixRule::Variance => {
                            sums.iter_mut().zip(spread.iter().flatten()).for_each(|(sum, spread)| {
                                // where the exposures' own samples do not tell, the exposures do
                                *sum = if *sum < UNKNOWN { *sum * share * share } else { *spread };
                            })
                        }
                        _ => {}
                    }
                    plane.values.put(0, &sums);
                }
                (Gathered::Nothing, PlaneSource::Matte(number)) => {
                    let values = mattes.iter().flatten().nth(number).filter(|values| !values.is_empty());
                    plane.is_zero = values.is_none();
                    values.into_iter().for_each(|values| plane.values.put(0, values));
                }
                (Gathered::Nothing, _) => plane.is_zero = true,
            }
            plane
        });
        Film { width: self.width, height: self.height, planes: planes.collect() }
    }
}

impl Gathered {
    fn add(&mut self, plane: &Plane) {
        if plane.is_zero {
            return;
        }
        let sums = self.values(plane.values.len(), 0.0);
        each(sums, &plane.values, |sum, value| *sum += value);
    }

    fn least(&mut self, plane: &Plane, first: bool) {
        let values = self.values(plane.values.len(), if first { f32::INFINITY } else { 0.0 });
        each(values, &plane.values, |least, value| *least = least.min(value));
    }

    /// The `count` values; created with `begin` in each if there are none yet.
    fn values(&mut self, count: usize, begin: f32) -> &mut [f32] {
        if !matches!(self, Self::Values(_)) {
            *self = Self::Values(vec![begin; count]);
        }
        match self {
            Self::Values(values) => values,
            Self::Nothing | Self::Plane(_) => &mut [],
        }
    }
}

/// For each pixel the variance of the mean of `count` exposures, averaged over the three components, as they differ from each other: what
/// moves or is out of focus counts as noise. `squares`: sums of the components' squares; `planes` have their sums.
fn spread(mut squares: Vec<f32>, planes: &[Gathered], channels: &[Channel], count: u32) -> Vec<f32> {
    if count <= 3 {
        squares.fill(UNKNOWN);
        return squares;
    }
    let n = count as f32;
    for (plane, _) in planes.iter().zip(channels).filter(|(_, channel)| COLORS.contains(&&*channel.name)) {
        if let Gathered::Values(sums) = plane {
            squares.iter_mut().zip(sums).for_each(|(square, sum)| *square -= sum * sum / n);
        }
    }
    // as of the samples of a pixel, few of them know little of their variance
    let scale = 1.0 / (3.0 * (n - 1.0)) / n * (n - 1.0) / (n - 3.0);
    squares.iter_mut().for_each(|square| *square = square.max(0.0) * scale);
    squares
}

/// Calls `with` for each value and the one of `all` that it is joined to.
fn each(all: &mut [f32], values: &Values, with: impl Fn(&mut f32, f32) + Sync) {
    use half::slice::HalfFloatSliceExt;
    /// Values that fit well into the nearest cache.
    const PIECE: usize = 1024;
    match values {
        Values::Float(values) => {
            all.par_chunks_mut(PIECE).zip(values.par_chunks(PIECE)).for_each(|(all, values)| {
                all.iter_mut().zip(values).for_each(|(one, value)| with(one, *value));
            })
        }
        Values::Half(values) => {
            all.par_chunks_mut(PIECE).zip(values.par_chunks(PIECE)).for_each(|(all, values)| {
                let mut floats = [0.0; PIECE];
                let floats = &mut floats[..values.len()];
                values.convert_to_f32_slice(floats);
                all.iter_mut().zip(floats).for_each(|(one, value)| with(one, *value));
            })
        }
    }
}

impl Row {
    /// Shares of pixel number `x`; empty if the row has no pixels yet.
    fn of(&self, x: usize) -> &[(Id, f32)] {
        match self.starts[..] {
            [] => &[],
            _ => &self.shares[self.starts[x] as usize..self.starts[x + 1] as usize],
        }
    }

    /// Appends the shares of the next pixel.
    fn push(&mut self, shares: &[(Id, f32)]) {
        if self.starts.is_empty() {
            self.starts.push(0);
        }
        self.shares.extend_from_slice(shares);
        self.starts.push(self.shares.len() as u32);
    }
}

/// Planes of a kind of mattes, id and share of each rank in turn, if `film` has them.
fn planes_of<'a>(kind: Kind, film: &'a Film, channels: &[Channel]) -> Option<Vec<&'a Plane>> {
    let plane = |number| {
        let channel = channels.iter().find(|channel| channel.source == PlaneSource::Matte(number));
        channel.and_then(|channel| film.plane(&channel.name))
    };
    matte_planes(kind).map(plane).collect()
}

/// Values of the planes of a kind of mattes, made of sums that are scaled by `share`; empty ones where there
/// are no mattes.
fn ranked(rows: &[Row], width: usize, share: f32) -> Vec<Vec<f32>> {
    let mut planes = vec![Vec::new(); 2 * RANKS];
    if rows.is_empty() {
        return planes;
    }
    let of_row = |row: &Row| -> Vec<_> {
        let of_pixel = |x| {
            let mut shares: Vec<(Id, f32)> = row.of(x).iter().map(|(id, sum)| (*id, sum * share)).collect();
            rank(&mut shares)
        };
        (0..width).map(of_pixel).collect()
    };
    let pixels: Vec<_> = rows.par_iter().flat_map_iter(of_row).collect();
    planes.par_chunks_mut(2).enumerate().for_each(|(number, planes)| {
        planes[0] = pixels.iter().map(|ranked| ranked[number].0.as_float()).collect();
        planes[1] = pixels.iter().map(|ranked| ranked[number].1).collect();
    });
    planes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::planes::channels::channels;
    use crate::layers::Layers;
    use crate::scene::LightGroups;

    fn all_channels() -> Vec<Channel> {
        channels(Layers::ALL, &LightGroups::default()).collect()
    }

    /// Creates a picture of one pixel in which planes have these values, and others are zero.
    fn film(values: &[(&str, f32)]) -> Film {
        let planes = all_channels().into_iter().map(|channel| {
            let value = values.iter().find(|(name, _)| *name == channel.name).map(|(_, value)| *value);
            let is_zero = value.is_none();
            Plane { is_zero, ..Plane::new(channel.name, channel.kind, &[value.unwrap_or(0.0)]) }
        });
        Film { width: 1, height: 1, planes: planes.collect() }
    }

    fn mean(films: &[Film]) -> impl Fn(&str) -> f32 + use<> {
        let channels = all_channels();
        let mut mean = Mean::new(&channels, [1, 1]);
        films.iter().for_each(|film| mean.add(film, &channels));
        let film = mean.finish(&channels);
        assert_eq!(film.planes.len(), channels.len());
        for plane in &film.planes {
            assert!(!plane.is_zero || plane.values.get(0) == 0.0, "{}", plane.name);
        }
        move |name| film.values(name).expect(name)[0]
    }

    #[test]
    fn each_plane_has_its_rule() {
        let first =
            film(&[("R", 1.0), ("Z", 5.0), ("rays_shadow.V", 3.0), ("status_good.V", 1.0), ("P.X", 9.0)]);
        let mut last = film(&[("R", 4.0), ("Z", 7.0), ("rays_shadow.V", 4.0), ("A", 0.5)]);
        last.planes.retain(|plane| !plane.name.starts_with("P."));
        for films in [[first.clone(), last.clone()], [last, first]] {
            let mean = mean(&films);
            let values = ["R", "A", "Z", "rays_shadow.V", "status_good.V", "P.X", "G"].map(mean);
            assert_eq!(values, [2.5, 0.25, 5.0, 7.0, 0.5, 9.0, 0.0]);
        }
    }

    #[test]
    fn variance_is_that_of_the_mean() {
        const NAME: &str = "denoise_variance.V";
        let known = [0.0; 4].map(|_| film(&[("R", 1.0), (NAME, 0.5)]));
        assert_eq!(mean(&known)(NAME), 0.125, "of samples that differ by nothing but chance");
        // of the components one differs, by 2 from exposure to exposure
        let unknown =
            [1.0, 3.0, 1.0, 3.0, 1.0, 3.0, 1.0, 3.0].map(|red| film(&[("R", red), (NAME, UNKNOWN)]));
        let expected = 8.0 / 7.0 / 3.0 / 8.0 * 7.0 / 5.0;
        assert!((mean(&unknown)(NAME) - expected).abs() < 1e-6);
        let few = [1.0, 3.0].map(|red| film(&[("R", red), (NAME, UNKNOWN)]));
        assert_eq!(mean(&few)(NAME), UNKNOWN);
    }

    #[test]
    fn mattes_are_added_by_name_and_sorted_again() {
        let [a, b] = ["a", "b"].map(Id::new);
        let first = film(&[
            ("CryptoObject00.R", a.as_float()),
            ("CryptoObject00.G", 0.75),
            ("CryptoObject00.B", b.as_float()),
            ("CryptoObject00.A", 0.25),
        ]);
        let second = film(&[("CryptoObject00.R", b.as_float()), ("CryptoObject00.G", 1.0)]);
        let mean = mean(&[first, film(&[]), second, film(&[])]);
        assert_eq!(mean("CryptoObject00.R"), b.as_float());
        let shares = ["CryptoObject00.G", "CryptoObject00.A", "CryptoObject01.G"].map(&mean);
        assert_eq!((shares, mean("CryptoObject00.B")), ([1.25 / 4.0, 0.75 / 4.0, 0.0], a.as_float()));
    }
}

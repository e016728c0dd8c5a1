//! Planes of one finished frame.

use std::borrow::Cow;

use half::f16;
use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;

use crate::aligned::Aligned;

/// Storage of a plane in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlaneKind {
    /// 16-bit float: colours, normals, fractions.
    Half,
    /// 32-bit float: distances, positions, motion, ids.
    Float,
}

/// Numbers of a plane, rounded to what its file will hold or finer.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Values {
    Half(Aligned<f16>),
    Float(Aligned<f32>),
}

/// Largest finite half.
const HALF_MAX: f32 = 65504.0;

impl Values {
    /// Creates `count` zeros, as halves.
    pub fn halves(count: usize) -> Self {
        Self::Half(Aligned::zeros(count))
    }

    /// Creates `count` zeros, as floats.
    pub fn floats(count: usize) -> Self {
        Self::Float(Aligned::zeros(count))
    }

    /// Converts `values` to the type of a plane of that kind.
    pub fn of(kind: PlaneKind, values: &[f32]) -> Self {
        let mut some = match kind {
            PlaneKind::Half => Self::halves(values.len()),
            PlaneKind::Float => Self::floats(values.len()),
        };
        some.put(0, values);
        some
    }

    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            Self::Half(values) => values.len(),
            Self::Float(values) => values.len(),
        }
    }

    /// Returns true if both have the same type and length.
    fn is_like(&self, other: &Self) -> bool {
        std::mem::discriminant(self) == std::mem::discriminant(other) && self.len() == other.len()
    }

    /// Returns true if there are no values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Value number `index`.
    #[inline]
    pub fn get(&self, index: usize) -> f32 {
        match self {
            Self::Half(values) => values[index].to_f32(),
            Self::Float(values) => values[index],
        }
    }

    /// Converts all values to floats.
    pub fn to_floats(&self) -> Vec<f32> {
        match self {
            Self::Half(values) => values.to_f32_vec(),
            Self::Float(values) => values.to_vec(),
        }
    }

    /// Writes `values` from number `first` on. Halves end at 65504; a NaN stays one.
    #[inline]
    pub fn put(&mut self, first: usize, values: &[f32]) {
        let places = first..first + values.len();
        match self {
            Self::Float(all) => all[places].copy_from_slice(values),
            Self::Half(all) => round_to_halves(values, &mut all[places]),
        }
    }
}

/// Rounds as many values to halves. Values beyond the greatest half are clamped to it; a NaN stays one.
#[inline(always)]
pub fn round_to_halves(values: &[f32], halves: &mut [f16]) {
    const AT_ONCE: usize = 8;
    let (mut all_to, all_from) = (halves.chunks_exact_mut(AT_ONCE), values.chunks_exact(AT_ONCE));
    let rest = all_from.remainder();
    for (to, from) in all_to.by_ref().zip(all_from) {
        let clamped: [f32; AT_ONCE] = std::array::from_fn(|i| from[i].clamp(-HALF_MAX, HALF_MAX));
        to.convert_from_f32_slice(&clamped);
    }
    for (to, from) in all_to.into_remainder().iter_mut().zip(rest) {
        *to = f16::from_f32(from.clamp(-HALF_MAX, HALF_MAX));
    }
}

/// One channel of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Name in the EXR file: `R`, `Z`, `P.X`, `status_good.V`.
    pub name: Cow<'static, str>,
    /// Storage in files.
    pub kind: PlaneKind,
    /// `width * height` finite values, row-major, top row first.
    pub values: Values,
    /// True if it is known to be zero throughout: a renderer need not clear it, nor a writer look at it.
    pub is_zero: bool,
}

impl Plane {
    /// Creates a plane with these values, rounded for its `kind`.
    pub fn new(name: impl Into<Cow<'static, str>>, kind: PlaneKind, values: &[f32]) -> Self {
        Self { name: name.into(), kind, values: Values::of(kind, values), is_zero: false }
    }

    /// Copies it into the memory of another plane of the same name, kind and length.
    fn copied_into(&self, other: Option<Self>) -> Self {
        let Some(mut other) = other else { return self.clone() };
        if !(self.is_zero && other.is_zero) {
            match (&mut other.values, &self.values) {
                (Values::Half(to), Values::Half(from)) => to.copy_from_slice(from),
                (Values::Float(to), Values::Float(from)) => to.copy_from_slice(from),
                _ => return self.clone(),
            }
        }
        Self { is_zero: self.is_zero, ..other }
    }
}

/// A finished frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Planes in any order; no two of the same name.
    pub planes: Vec<Plane>,
}

impl Film {
    /// Creates a film without pixels and planes.
    pub fn empty() -> Self {
        Self { width: 0, height: 0, planes: Vec::new() }
    }

    /// Copies `other`, except for planes that `keeps` refuses by name. Existing memory is used again.
    pub fn copy_from(&mut self, other: &Self, keeps: impl Fn(&str) -> bool) {
        let mut unused = std::mem::take(&mut self.planes);
        let kept = other.planes.iter().filter(|plane| keeps(&plane.name));
        let own = kept.map(|plane| {
            let own = unused.iter().position(|own| {
                own.name == plane.name && own.kind == plane.kind && own.values.is_like(&plane.values)
            });
            (own.map(|own| unused.swap_remove(own)), plane)
        });
        let planes: Vec<(Option<Plane>, &Plane)> = own.collect();
        self.planes = planes.into_par_iter().map(|(own, plane)| plane.copied_into(own)).collect();
        (self.width, self.height) = (other.width, other.height);
    }

    /// Plane of that name.
    #[must_use]
    pub fn plane(&self, name: &str) -> Option<&Plane> {
        self.planes.iter().find(|plane| plane.name == name)
    }

    /// Values of the plane of that name.
    #[must_use]
    pub fn values(&self, name: &str) -> Option<Vec<f32>> {
        self.plane(name).map(|plane| plane.values.to_floats())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_is_the_same_whatever_was_there_before() {
        let film = |value: f32, is_zero| {
            let plane = |name, kind| Plane { is_zero, ..Plane::new(name, kind, &[value; 4]) };
            let planes = vec![
                plane("R", PlaneKind::Half),
                plane("Z", PlaneKind::Float),
                plane("P.X", PlaneKind::Float),
            ];
            Film { width: 2, height: 2, planes }
        };
        let keeps = |name: &str| name != "P.X";
        let films = [film(1.0, false), film(0.0, true), film(0.0, true), film(0.0, false), film(3.0, false)];
        let small = Film { width: 1, height: 1, planes: vec![Plane::new("R", PlaneKind::Half, &[5.0])] };
        let mut copy = Film::empty();
        for film in films.iter().chain([&small, &films[0]]) {
            copy.copy_from(film, keeps);
            let planes = film.planes.iter().filter(|plane| keeps(&plane.name)).cloned().collect();
            assert_eq!(copy, Film { planes, ..*film });
        }
    }

    #[test]
    fn halves_are_rounded_and_end_where_they_end() {
        let values: Vec<f32> = (0..600).map(|i| i as f32 * 0.3 - 7.0).chain([1e9, -1e9, f32::NAN]).collect();
        let halves = Values::of(PlaneKind::Half, &values);
        assert_eq!(halves.len(), values.len());
        for (index, value) in values[..600].iter().enumerate() {
            assert_eq!(halves.get(index), f16::from_f32(*value).to_f32());
        }
        assert_eq!([halves.get(600), halves.get(601)], [HALF_MAX, -HALF_MAX]);
        assert!(halves.get(602).is_nan(), "for the writer to find");
        assert_eq!(Values::of(PlaneKind::Float, &values[..600]).to_floats(), values[..600]);
    }
}

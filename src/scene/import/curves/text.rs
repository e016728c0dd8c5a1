//! Reads curves as text (`.curves`): a line for each point, and a line `curve` before the points of each.
//!
//! ```text
//! # two hairs
//! basis catmull-rom
//! radius 0.002 0.0005
//! curve 0.25 0.5
//! 0 0 0
//! 0.1 1 0
//! 0.3 2 0 0.0007
//! curve
//! …
//! ```
//! `basis` stands once, before all curves. `radius` is that of the first and of the last point of the curves that follow, or of all their points; a
//! fourth number of a point is its own. What `curve` has beside it are the texture coordinates of all of the curve; three more numbers of a point,
//! after its radius, are its colour.

use std::path::Path;

use glam::Vec2;

use super::basis::Basis;
use super::set::CurveSet;
use crate::digest::Digest;
use crate::input::{self, Kind};
use crate::memory::{self, Need, Part};
use crate::scene::SceneError;

/// Memory for each byte of a file while it is read.
const READING_BYTES: u64 = 4;

/// Reads the curves at `path`. `basis`, `radii` (of first and last points): those where the file says nothing of them.
///
/// # Errors A file that cannot be read or is no such text, with the line.
pub(in crate::scene) fn read(
    path: &Path,
    basis: Option<Basis>,
    radii: Option<[f32; 2]>,
) -> Result<(CurveSet, Digest), SceneError> {
    let unreadable = |what: String| SceneError::new(path, format!("the curves cannot be read: {what}"));
    let input = input::open(path, Kind::Model).map_err(|error| unreadable(error.to_string()))?;
    let need = Need::new(Part::new("the curves", READING_BYTES * input.length, "fewer curves, fewer points"));
    need.check(&memory::left()).map_err(|error| SceneError::new(path, error.to_string()))?;
    let bytes = input.read_all().map_err(|error| unreadable(error.to_string()))?;
    let digest = Digest::new(&bytes);
    let set = parse(&bytes, basis, radii);
    set.map(|set| (set, digest)).map_err(|(line, what)| SceneError::new(path, what).at_line(line))
}

/// Reads the text of curves and makes chains of them. Errors tell what is wrong; for tests.
///
/// # Errors Those of reading and of making chains.
#[cfg(test)]
pub fn check(bytes: &[u8]) -> Result<usize, String> {
    let set = parse(bytes, None, Some([0.01; 2])).map_err(|(line, what)| format!("line {line}: {what}"))?;
    set.build(None).map(|built| built.curves.curves())
}

/// Reader of a text: what was said so far.
struct Parser {
    set: CurveSet,
    basis: Option<Basis>,
    radii: Option<[f32; 2]>,
    /// Points of the present curve that have no radius of their own.
    without_radius: Vec<usize>,
    /// Whether points have colours.
    colored: Option<bool>,
    mapped: Option<bool>,
}

type Fault = (usize, String);

fn parse(bytes: &[u8], basis: Option<Basis>, radii: Option<[f32; 2]>) -> Result<CurveSet, Fault> {
    let set = CurveSet { basis: basis.unwrap_or_default(), ..CurveSet::default() };
    let mut parser =
        Parser { set, basis: None, radii, without_radius: Vec::new(), colored: None, mapped: None };
    let mut last = 0;
    for (number, line) in (1..).zip(bytes.split(|byte| *byte == b'\n')) {
        let line = std::str::from_utf8(line)
            .map_err(|_| (number, String::from("this is no text: curves are written as plain text")))?;
        let line = line.split('#').next().unwrap_or_default();
        let mut words = line.split_ascii_whitespace();
        if let Some(first) = words.next() {
            parser.line(first, words).map_err(|what| (number, what))?;
        }
        last = number;
    }
    parser.end_curve().map_err(|what| (last, what))?;
    if parser.set.counts.is_empty() {
        return Err((last, String::from("there is no `curve`: each begins with a line that says so")));
    }
    Ok(parser.set)
}

impl Parser {
    fn line<'a>(&mut self, first: &'a str, rest: impl Iterator<Item = &'a str>) -> Result<(), String> {
        match first {
            "curve" => {
                self.end_curve()?;
                let uv = numbers::<2>(rest)?;
                let is_mapped = match uv.1 {
                    0 => false,
                    2 => true,
                    _ => return Err(String::from("`curve` has two texture coordinates beside it, or none")),
                };
                if *self.mapped.get_or_insert(is_mapped) != is_mapped {
                    return Err(String::from("either all curves have texture coordinates, or none"));
                }
                if is_mapped {
                    self.set.uvs.push(Vec2::from(uv.0));
                }
                self.set.counts.push(0);
                Ok(())
            }
            "basis" => {
                let names = [
                    ("linear", Basis::Linear),
                    ("bezier", Basis::Bezier),
                    ("bspline", Basis::Bspline),
                    ("catmull-rom", Basis::CatmullRom),
                ];
                let name = rest.fold(String::new(), |all, word| all + word);
                let known = names.into_iter().find(|(known, _)| *known == name);
                let (_, basis) = known.ok_or_else(|| {
                    format!(
                        "`basis` is `{}`: it is linear, bezier, bspline or catmull-rom",
                        crate::visible::visible(&name)
                    )
                })?;
                if self.basis.is_some() || !self.set.counts.is_empty() {
                    return Err(String::from("`basis` stands once, before all curves"));
                }
                self.basis = Some(basis);
                self.set.basis = basis;
                Ok(())
            }
            "radius" => {
                self.end_curve()?;
                let (numbers, count) = numbers::<2>(rest)?;
                self.radii = Some(match count {
                    1 => [numbers[0]; 2],
                    2 => numbers,
                    _ => {
                        return Err(String::from(
                            "`radius` has one number, or two: of the first and the last point",
                        ));
                    }
                });
                if numbers.iter().any(|radius| *radius < 0.0) {
                    return Err(String::from("a radius is below 0"));
                }
                Ok(())
            }
            number => self.point(std::iter::once(number).chain(rest)),
        }
    }

    fn point<'a>(&mut self, words: impl Iterator<Item = &'a str>) -> Result<(), String> {
        let (numbers, count) = numbers::<7>(words)?;
        let Some(points) = self.set.counts.last_mut() else {
            return Err(String::from("a point stands before the first `curve`"));
        };
        let [x, y, z, radius, red, green, blue] = numbers;
        if !matches!(count, 3 | 4 | 7) {
            return Err(format!(
                "a point has {count} numbers: it has a place (3), its radius (4), and perhaps its colour (7)"
            ));
        }
        if *self.colored.get_or_insert(count == 7) != (count == 7) {
            return Err(String::from("either all points have colours, or none"));
        }
        if radius < 0.0 || [red, green, blue].iter().any(|part| *part < 0.0) {
            return Err(String::from("a radius or a colour is below 0"));
        }
        *points += 1;
        if count == 3 {
            self.without_radius.push(self.set.points.len());
        }
        self.set.points.push([x, y, z]);
        self.set.radii.push(radius);
        if count == 7 {
            self.set.colors.push([red, green, blue]);
        }
        Ok(())
    }

    /// Gives the points of the curve that ends the radii that they do not state.
    fn end_curve(&mut self) -> Result<(), String> {
        if self.without_radius.is_empty() {
            return Ok(());
        }
        let Some([first, last]) = self.radii else {
            return Err(String::from(
                "points of the curve have no radius: state it behind the place, or `radius` before the curve",
            ));
        };
        let count = self.set.counts.last().copied().unwrap_or_default() as usize;
        let begin = self.set.points.len() - count;
        for at in self.without_radius.drain(..) {
            let share = if count > 1 { (at - begin) as f32 / (count - 1) as f32 } else { 0.0 };
            self.set.radii[at] = first + (last - first) * share;
        }
        Ok(())
    }
}

/// Up to `MOST` numbers, and how many there are.
fn numbers<'a, const MOST: usize>(
    words: impl Iterator<Item = &'a str>,
) -> Result<([f32; MOST], usize), String> {
    let (mut numbers, mut count) = ([0.0; MOST], 0);
    for word in words {
        let number: Option<f32> = word.parse().ok().filter(|number: &f32| number.is_finite());
        let number = number.ok_or_else(|| format!("`{}` is no number", crate::visible::visible(word)))?;
        *numbers.get_mut(count).ok_or_else(|| format!("there are more than {MOST} numbers"))? = number;
        count += 1;
    }
    Ok((numbers, count))
}

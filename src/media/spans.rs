//! The parts of a ray that lie in media, and what becomes of light along them: closed formulas, as media are even.

use std::ops::Range;

use glam::Vec3;

use super::phase;
use crate::scene::medium::Medium;

/// Length that stands for one without end where nothing is lost on it: what a clear medium emits on it is a number.
const LONGEST: f32 = 1e15;

/// A part of a ray along which the same media are around it.
#[derive(Debug, Clone)]
struct Span {
    from: f32,
    /// Infinite, if the medium fills everything and the ray meets nothing.
    to: f32,
    extinction: Vec3,
    scatter: Vec3,
    emit: Vec3,
    /// Share of light that comes as far as its beginning.
    before: Vec3,
    /// Integral over it of the share of light that comes to its beginning: its length, where nothing is lost. Zero in ink, of which no light comes.
    integral: Vec3,
    /// Media that scatter, in the list of members.
    members: Range<u32>,
}

/// The parts of a ray of unit direction that lie in media, in their order.
#[derive(Debug, Default)]
pub struct Spans {
    all: Vec<Span>,
    /// Scattering of each medium of a span, and its anisotropy.
    members: Vec<(Vec3, f32)>,
    /// Share of light that comes through all of them.
    left: Vec3,
    /// Light that they scatter in all, by channel, if as much came to each place as leaves it straight on.
    scattered: Vec3,
    runs: Vec<Run>,
    /// Crossings of a boundary, with 1 where the ray comes out: scratch.
    pub crossings: Vec<(f64, f64)>,
    /// Places where runs begin or end: scratch.
    ends: Vec<f32>,
    /// Numbers of the runs around the part at work: scratch.
    around: Vec<u32>,
}

/// A part of a ray that lies in one medium.
#[derive(Debug, Clone, Copy)]
pub struct Run {
    /// Where it begins.
    pub from: f32,
    /// Where it ends.
    pub to: f32,
    /// The medium there.
    pub medium: Medium,
}

/// A place on the ray at which light is scattered.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// Distance from the ray's origin.
    pub distance: f32,
    /// Scattering there, times the share of light that comes from there to the origin.
    pub weight: Vec3,
    /// Number of its span.
    span: usize,
}

/// Where media scatter light to in one place: as those that are there do, by their shares.
#[derive(Debug, Clone, Copy)]
pub struct Phase<'s> {
    members: &'s [(Vec3, f32)],
    scatter: Vec3,
}

impl Spans {
    /// Begins the spans of another ray.
    pub fn begin(&mut self) {
        self.all.clear();
        self.members.clear();
        self.runs.clear();
        (self.left, self.scattered) = (Vec3::ONE, Vec3::ZERO);
    }

    /// Adds a part of the ray that lies in a medium.
    pub fn run(&mut self, run: Run) {
        self.runs.push(run);
    }

    /// Makes the spans up to `far` of a ray of which all [runs](Self::run) are known, beside the medium that fills everything.
    pub fn finish(&mut self, everywhere: Option<&Medium>, far: f32) {
        let (mut runs, mut ends, mut around) = (
            std::mem::take(&mut self.runs),
            std::mem::take(&mut self.ends),
            std::mem::take(&mut self.around),
        );
        // those that begin in one place stay in the order in which they came: that of media
        runs.sort_by(|a, b| a.from.total_cmp(&b.from));
        ends.clear();
        ends.extend(runs.iter().flat_map(|run| [run.from, run.to]).filter(|end| *end < far));
        ends.sort_unstable_by(f32::total_cmp);
        ends.dedup();
        around.clear();
        let (mut from, mut next) = (0.0, 0);
        for to in ends.iter().copied().chain([far]) {
            around.retain(|run| runs[*run as usize].to > from);
            while next < runs.len() && runs[next].from <= from {
                around.extend((runs[next].to > from).then_some(next as u32));
                next += 1;
            }
            let here = around.iter().map(|run| runs[*run as usize].medium);
            self.add([from, to], here.chain(everywhere.copied()));
            from = to;
        }
        (self.runs, self.ends, self.around) = (runs, ends, around);
    }

    fn add(&mut self, [from, to]: [f32; 2], media: impl Iterator<Item = Medium>) {
        if from.is_nan() || to.is_nan() || from >= to {
            return;
        }
        let first = self.members.len();
        let [mut extinction, mut scatter, mut emit] = [Vec3::ZERO; 3];
        for medium in media {
            extinction += medium.extinction();
            emit += medium.emit;
            if medium.scatter != Vec3::ZERO {
                scatter += medium.scatter;
                self.members.push((medium.scatter, medium.anisotropy));
            }
        }
        if extinction == Vec3::ZERO && emit == Vec3::ZERO {
            return;
        }
        let members = first as u32..self.members.len() as u32;
        let is_ink = scatter == Vec3::ZERO && emit == Vec3::ZERO;
        let integral = if is_ink { Vec3::ZERO } else { integral(extinction, to - from) };
        let span = Span { from, to, extinction, scatter, emit, before: self.left, integral, members };
        self.scattered += span.before * span.scatter * span.integral;
        self.left *= span.left(to);
        self.all.push(span);
    }

    /// Returns true if nothing happens to light along the ray.
    pub fn are_none(&self) -> bool {
        self.all.is_empty()
    }

    /// Share of light that comes through all of them.
    pub fn left(&self) -> Vec3 {
        self.left
    }

    /// Share of light that comes as far as a distance from the origin.
    pub fn left_at(&self, distance: f32) -> Vec3 {
        let passed = self.all.iter().take_while(|span| span.from < distance);
        passed.last().map_or(Vec3::ONE, |span| span.before * span.left(distance.min(span.to)))
    }

    /// Light that comes to the origin of what they emit, and of what they scatter of light of this radiance from all around, which is the
    /// same everywhere.
    pub fn emitted(&self, ambient: Vec3) -> Vec3 {
        let light = |span: &Span| span.before * (span.emit + span.scatter * ambient) * span.integral;
        self.all.iter().map(light).sum()
    }

    /// Sum over all places of the share of light that they scatter and that comes to the origin.
    pub fn scattered(&self) -> Vec3 {
        self.scattered
    }

    /// Distances within which light is scattered.
    pub fn range(&self) -> Option<[f32; 2]> {
        let mut all = self.all.iter().filter(|span| span.scatter != Vec3::ZERO);
        let first = all.next()?;
        Some([first.from, all.next_back().unwrap_or(first).to])
    }

    /// Chooses a place by the light that is scattered there, for a path whose light has this `weight`, by two random numbers. `None` if
    /// none is scattered.
    pub fn choose(&self, weight: Vec3, [choice, along]: [f32; 2]) -> Option<f32> {
        let chances = self.chances(weight)?;
        let (channel, mut choice) = match choice {
            _ if choice < chances.x => (0, choice / chances.x),
            _ if choice < chances.x + chances.y => (1, (choice - chances.x) / chances.y),
            _ => (2, (choice - chances.x - chances.y) / chances.z),
        };
        let mut chosen = None;
        for span in &self.all {
            let share = (span.before * span.scatter * span.integral)[channel] / self.scattered[channel];
            if share > 0.0 {
                chosen = Some(span);
                if choice < share {
                    break;
                }
                choice -= share;
            }
        }
        chosen.map(|span| span.from + span.distance(channel, along))
    }

    /// Density, by length, with which a distance is [chosen](Self::choose).
    pub fn density(&self, weight: Vec3, distance: f32) -> f32 {
        match (self.chances(weight), self.at(distance)) {
            (Some(chances), Some(place)) => {
                // of channels in which nothing is scattered none is chosen
                let each = |channel: usize| match chances[channel] {
                    0.0 => 0.0,
                    chance => chance * place.weight[channel] / self.scattered[channel],
                };
                each(0) + each(1) + each(2)
            }
            _ => 0.0,
        }
    }

    /// Chances of the channels: by the light that is scattered.
    fn chances(&self, weight: Vec3) -> Option<Vec3> {
        let light = (weight * self.scattered).abs();
        let sum = light.element_sum();
        (sum > 0.0 && sum.is_finite()).then(|| light / sum)
    }

    /// The place at this distance, if light is scattered there.
    pub fn at(&self, distance: f32) -> Option<Place> {
        let span = self.all.iter().rposition(|span| span.from <= distance)?;
        let (of, number) = (&self.all[span], span);
        let is_there = distance <= of.to && of.scatter != Vec3::ZERO;
        is_there.then(|| Place { distance, weight: of.before * of.scatter * of.left(distance), span: number })
    }

    /// Where light is scattered to in a place.
    pub fn phase(&self, place: &Place) -> Phase<'_> {
        let span = &self.all[place.span];
        let members = &self.members[span.members.start as usize..span.members.end as usize];
        Phase { members, scatter: span.scatter }
    }
}

impl Span {
    /// Share of light that comes from its beginning to a distance in it.
    fn left(&self, distance: f32) -> Vec3 {
        let length = distance - self.from;
        let left = |extinction: f32| if extinction > 0.0 { (-extinction * length).exp() } else { 1.0 };
        Vec3::from_array(self.extinction.to_array().map(left))
    }

    /// Distance from its beginning that a random number chooses, by the share of light that is left there in a channel.
    fn distance(&self, channel: usize, random: f32) -> f32 {
        let (extinction, length) = (self.extinction[channel], self.to - self.from);
        let distance = if extinction > 0.0 {
            -(random * (-extinction * length).exp_m1()).ln_1p() / extinction
        } else {
            random * length.min(LONGEST)
        };
        distance.clamp(0.0, length)
    }
}

/// Integral, over a way of this length, of the share of light that comes to its beginning.
fn integral(extinction: Vec3, length: f32) -> Vec3 {
    let integral = |extinction: f32| {
        if extinction > 0.0 { -(-extinction * length).exp_m1() / extinction } else { length.min(LONGEST) }
    };
    Vec3::from_array(extinction.to_array().map(integral))
}

impl Phase<'_> {
    /// Density, in solid angle, of light that goes on at this cosine to where it came along; of each channel.
    pub fn light(&self, cos: f32) -> Vec3 {
        let sum: Vec3 = self
            .members
            .iter()
            .map(|(scatter, anisotropy)| *scatter * phase::density(*anisotropy, cos))
            .sum();
        let share = |sum: f32, all: f32| if all > 0.0 { sum / all } else { 0.0 };
        let ([x, y, z], [r, g, b]) = (sum.to_array(), self.scatter.to_array());
        Vec3::new(share(x, r), share(y, g), share(z, b))
    }

    /// Density with which a direction at this cosine is [drawn](Self::draw).
    pub fn density(&self, cos: f32) -> f32 {
        let all: f32 = self.members.iter().map(|(scatter, _)| scatter.element_sum()).sum();
        let each = |(scatter, anisotropy): &(Vec3, f32)| {
            scatter.element_sum() / all * phase::density(*anisotropy, cos)
        };
        self.members.iter().map(each).sum()
    }

    /// Direction in which light that comes along `incoming` goes on: by three random numbers.
    pub fn draw(&self, incoming: Vec3, [mut choice, along, around]: [f32; 3]) -> Vec3 {
        let all: f32 = self.members.iter().map(|(scatter, _)| scatter.element_sum()).sum();
        let mut drawn = 0.0;
        for (scatter, anisotropy) in self.members {
            drawn = *anisotropy;
            let share = scatter.element_sum() / all;
            if choice < share {
                break;
            }
            choice -= share;
        }
        phase::sample(drawn, incoming, [along, around])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shade::sampling::PathRandom;

    const FOG: Medium = Medium {
        scatter: Vec3::new(0.5, 0.2, 0.1),
        absorb: Vec3::new(0.1, 0.0, 0.3),
        emit: Vec3::new(1.0, 2.0, 3.0),
        anisotropy: 0.5,
    };
    const INK: Medium = Medium { absorb: Vec3::ONE, ..Medium::NONE };

    /// Of parts of a ray, each from where to where, in which medium, and how dense.
    fn spans(runs: &[(f32, f32, u16, f32)], everywhere: Option<&Medium>, far: f32) -> Spans {
        let mut spans = Spans::default();
        spans.begin();
        for (from, to, medium, density) in runs.iter().copied() {
            let medium = [FOG, INK][usize::from(medium)].scaled(density.recip());
            spans.run(Run { from, to, medium });
        }
        spans.finish(everywhere, far);
        spans
    }

    fn near(found: Vec3, wanted: Vec3) {
        assert!(found.abs_diff_eq(wanted, 2e-4 * wanted.abs().max_element().max(1e-3)), "{found} {wanted}");
    }

    /// What is left, emitted and scattered is what small steps add up to.
    #[test]
    fn formulas_are_what_small_steps_add_up_to() {
        type Case<'a> = (&'a [(f32, f32, u16, f32)], Option<&'a Medium>, f32);
        let cases: [Case<'_>; 6] = [
            (&[(1.0, 3.0, 0, 1.0)], None, 9.0),
            // in it from the start, and another one within
            (&[(0.0, 3.0, 0, 1.0), (1.0, 2.0, 1, 1.0)], None, 9.0),
            // it ends in one
            (&[(1.0, 5.0, 0, 1.0)], None, 2.5),
            // twice in one, and one that varies
            (&[(1.0, 4.0, 0, 1.0), (2.0, 3.0, 0, 1.0), (4.0, 4.5, 0, 0.3), (4.5, 6.0, 0, 2.0)], None, 9.0),
            (&[(1.0, 2.0, 1, 1.0)], Some(&FOG), 4.0),
            (&[], Some(&FOG), 40.0),
        ];
        for (runs, everywhere, far) in cases {
            let spans = spans(runs, everywhere, far);
            const STEPS: usize = 40_000;
            let step = f64::from(far) / STEPS as f64;
            let [mut left, mut emitted, mut scattered] =
                [glam::DVec3::ONE, glam::DVec3::ZERO, glam::DVec3::ZERO];
            for number in 0..STEPS {
                let at = ((number as f64 + 0.5) * step) as f32;
                let depth = |medium: u16| {
                    let there =
                        runs.iter().filter(|(from, to, of, _)| *of == medium && *from < at && at < *to);
                    there.map(|(.., density)| *density).sum::<f32>()
                };
                let mut here: Vec<(Medium, f32)> = vec![(FOG, depth(0)), (INK, depth(1))];
                here.extend(everywhere.map(|medium| (*medium, 1.0)));
                let sum = |of: fn(&Medium) -> Vec3| {
                    here.iter().map(|(medium, depth)| of(medium) * *depth).sum::<Vec3>().as_dvec3()
                };
                let middle = left * (-sum(Medium::extinction) * 0.5 * step).exp();
                emitted += middle * (sum(|medium| medium.emit) + sum(|medium| medium.scatter) * 0.5) * step;
                scattered += middle * sum(|medium| medium.scatter) * step;
                left *= (-sum(Medium::extinction) * step).exp();
            }
            near(spans.left(), left.as_vec3());
            near(spans.left_at(far), left.as_vec3());
            near(spans.emitted(Vec3::splat(0.5)), emitted.as_vec3());
            near(spans.scattered(), scattered.as_vec3());
        }
    }

    /// The mean of what is scattered over the density of its place is all that is scattered, without end as well.
    #[test]
    fn places_are_chosen_with_the_density_that_is_said() {
        for (runs, everywhere, far) in [
            (&[(1.0, 3.0, 0, 1.0), (4.0, 9.0, 0, 1.0)][..], None, 6.0),
            (&[], Some(&FOG), f32::INFINITY),
            (&[(2.0, 2.5, 1, 1.0)], Some(&FOG), 9.0),
        ] {
            let spans = spans(runs, everywhere, far);
            let weight = Vec3::new(1.0, 0.5, 2.0);
            let (count, mut sum, mut moment) = (1 << 14, Vec3::ZERO, 0.0_f64);
            for number in 0..count {
                let [choice, along, ..] = PathRandom::new(3, number).four(0);
                let distance = spans.choose(weight, [choice, along]).expect("it scatters");
                let place = spans.at(distance).expect("there");
                let density = spans.density(weight, distance);
                sum += place.weight / density / count as f32;
                moment += 1.0 / f64::from(density) / f64::from(count);
            }
            near(sum * 0.1, spans.scattered() * 0.1);
            if far == 6.0 {
                assert!((moment - 4.0).abs() < 0.02, "as long as where it scatters: {moment}");
            }
        }
    }

    #[test]
    fn nothing_is_nothing() {
        let none = spans(&[], None, f32::INFINITY);
        assert!(none.are_none() && none.left() == Vec3::ONE && none.range().is_none());
        assert_eq!((none.emitted(Vec3::ONE), none.choose(Vec3::ONE, [0.5; 2])), (Vec3::ZERO, None));
        let murk = Medium { absorb: Vec3::ONE, ..FOG };
        assert_eq!(
            spans(&[], Some(&murk), f32::INFINITY).left(),
            Vec3::ZERO,
            "nothing gets through what has no end"
        );
        let ink = spans(&[(1.0, 2.0, 1, 1.0)], None, 9.0);
        assert!(ink.choose(Vec3::ONE, [0.5; 2]).is_none() && ink.range().is_none(), "ink scatters nothing");
    }
}

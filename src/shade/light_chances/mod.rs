//! How likely a surface is to ask each of several light sources: the likelier, the more light it may send there.
//!
//! Chances are those of the shot, not of a frame: a source that moves counts by the middle of its way, and one
//! that changes by the most that it ever sends. So what a path has asked depends on no source but that one, and
//! its result holds whatever the others do. What is in the way is not known. A share of all questions is spread
//! evenly, which bounds the noise of sources that count for less than they send.

//!
//! Where there are many, neighbours are weighed as one first, and one by one only where they are chosen: a tree whose nodes have up to 32
//! children (in place of the two of Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", 2018: eight
//! are weighed at once, and a wide tree is right more often about which are near).

mod level;
mod source;

use glam::Vec3;

use self::level::Level;
pub use self::level::{Chosen, Sent};
pub use self::source::Source;
use super::neighbours::{Item, divide};

/// Chances of some sources.
#[derive(Debug, Clone, Default)]
pub struct LightChances {
    /// The sources, or what stands for each group of them.
    level: Level,
    /// Groups of neighbours; none where each source is weighed.
    groups: Vec<Group>,
    /// Of each source, the number of its group, and its own there; empty without groups.
    places: Vec<(u32, u32)>,
}

/// Sources that lie near each other.
#[derive(Debug, Clone)]
struct Group {
    chances: LightChances,
    /// Their numbers among all.
    sources: Vec<u32>,
}

impl LightChances {
    /// Chances of these sources.
    pub fn new(sources: &[Source]) -> Self {
        let groups = if sources.len() > Sent::MOST { groups_of(sources) } else { Vec::new() };
        // those in one place cannot be divided
        if groups.len() < 2 {
            return Self { level: Level::new(sources), groups: Vec::new(), places: Vec::new() };
        }
        let mut places = vec![(0, 0); sources.len()];
        let of_group = |numbers: &Vec<u32>| -> Vec<Source> {
            numbers.iter().map(|number| sources[*number as usize]).collect()
        };
        for (numbers, group) in groups.iter().zip(0..) {
            for (number, place) in numbers.iter().zip(0..) {
                places[*number as usize] = (group, place);
            }
        }
        let stands: Vec<Source> = groups.iter().map(|numbers| Source::of_group(&of_group(numbers))).collect();
        let group = |sources: Vec<u32>| Group { chances: Self::new(&of_group(&sources)), sources };
        Self { level: Level::new(&stands), groups: groups.into_iter().map(group).collect(), places }
    }

    /// Chooses a source for a surface at `point` (world space) by a `random` number from 0 to below 1. There is at
    /// least one.
    pub fn choose(&self, point: Vec3, random: f32) -> Chosen {
        self.within(point, self.level.choose(point, random))
    }

    /// [Chooses](Self::choose) a source; `sent` is what was known of the last surface, often the same.
    pub fn choose_again(&self, point: Vec3, random: f32, sent: &mut Sent) -> Chosen {
        self.within(point, self.level.choose_again(point, random, sent))
    }

    /// Probability with which a surface at `point` asks `source`, of all sources.
    pub fn of(&self, point: Vec3, source: usize) -> f32 {
        let Some((group, place)) = self.places.get(source) else { return self.level.of(point, source) };
        let within = &self.groups[*group as usize].chances;
        self.level.of(point, *group as usize) * within.of(point, *place as usize)
    }

    /// The source itself where a group was `chosen`.
    #[inline]
    fn within(&self, point: Vec3, chosen: Chosen) -> Chosen {
        let Some(group) = self.groups.get(chosen.source) else { return chosen };
        let Chosen { source, chance, rest } = group.chances.choose(point, chosen.rest);
        Chosen { source: group.sources[source] as usize, chance: chosen.chance * chance, rest }
    }
}

/// Numbers of the sources of each group: those at infinity are one.
fn groups_of(sources: &[Source]) -> Vec<Vec<u32>> {
    let mut near = Vec::new();
    let mut far = Vec::new();
    for (source, number) in sources.iter().zip(0_u32..) {
        match source.place() {
            Some(place) => near.push((number, Item { place, weight: f64::from(source.strength()) })),
            None => far.push(number),
        }
    }
    let most = Sent::MOST - usize::from(!far.is_empty());
    let ranges = divide(&mut near, |(_, item)| *item, 0.0, most);
    let numbers = ranges.into_iter().map(|range| near[range].iter().map(|(number, _)| *number).collect());
    numbers.chain([far]).filter(|numbers: &Vec<u32>| !numbers.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use glam::DVec3;

    use super::level::EVEN_SHARE;
    use super::*;
    use crate::animation::{Interpolation, Track};
    use crate::scene::{Light, LightKind, Panel, SpotFall};

    fn light(kind: LightKind, power: f64) -> Light {
        let (color, power) = (Track::constant(Vec3::ONE), Track::constant(power));
        Light { name: "light".into(), kind, color, power, samples: 1, group: None, links: Default::default() }
    }

    fn lamp(place: DVec3, power: f64) -> Light {
        light(LightKind::Point { position: Track::constant(place) }, power)
    }

    /// One of each kind, one that moves, a dark one, and a row of lamps.
    fn lights() -> Vec<Light> {
        let [here, below] = [DVec3::new(1.0, 2.0, 0.0), DVec3::new(1.0, 0.0, 0.0)];
        let constant = Track::constant;
        let way = Track::through(vec![(0.0, DVec3::ZERO), (9.0, DVec3::X * 4.0)], Interpolation::Linear);
        let panel = Panel::at_rest(here, below, [0.5, 0.25]);
        let mut lights = vec![
            light(LightKind::Directional { direction: constant(DVec3::NEG_Y) }, 0.5),
            light(LightKind::Sun { direction: constant(DVec3::NEG_X), angle: 2.0.into() }, 1.0),
            light(LightKind::Rectangle(panel.clone()), 3.0),
            light(LightKind::Disk(panel), 1.0),
            light(LightKind::Sphere { position: constant(-here), radius: 0.3.into(), faces: false }, 2.0),
            light(LightKind::Point { position: way.unwrap() }, 1.0),
            light(
                LightKind::Spot {
                    position: constant(here),
                    target: constant(below),
                    cone: 40.0.into(),
                    soft: 0.2.into(),
                    fall: SpotFall::Smooth,
                    radius: 0.0.into(),
                },
                5.0,
            ),
            lamp(DVec3::ZERO, 0.0),
        ];
        lights.extend((0..9).map(|i| lamp(DVec3::new(f64::from(i) * 3.0, 3.0, 0.0), 1.0)));
        lights
    }

    /// Adds lamps here and there, two in each place, and more than there are groups in one.
    fn with_many(mut lights: Vec<Light>) -> Vec<Light> {
        let place = |i: u32| [i * 7 % 19, i * 11 % 5, i * 5 % 13].map(|step| f64::from(step) * 1.3);
        lights.extend((0..1000).map(|i| lamp(DVec3::from(place(i / 2)), f64::from(i % 5))));
        lights.extend((0..40).map(|_| lamp(DVec3::splat(30.0), 1.0)));
        lights
    }

    fn chances_of(lights: &[Light]) -> LightChances {
        LightChances::new(&lights.iter().map(Source::of_light).collect::<Vec<_>>())
    }

    fn points() -> impl Iterator<Item = Vec3> {
        let at = |i: u32| [i % 7, i / 7 % 5, i / 35].map(|step| step as f32 * 1.7 - 2.0);
        // lights among them, and far away from all
        (0..105).map(move |i| Vec3::from(at(i))).chain([Vec3::new(1.0, 2.0, 0.0), Vec3::splat(1e19)])
    }

    #[test]
    fn chances_are_those_with_which_lights_are_chosen() {
        let lights = with_many(lights());
        for count in [1, 2, 7, 8, 18, 200, lights.len()] {
            let (chances, mut sent) = (chances_of(&lights[..count]), Sent::NOWHERE);
            for point in points() {
                let all: Vec<f32> = (0..count).map(|light| chances.of(point, light)).collect();
                let sum: f32 = all.iter().sum();
                assert!((sum - 1.0).abs() < 1e-5, "{count} {point}: {sum}");
                // of a tree each level gives a share evenly
                let is_flat = count <= Sent::MOST;
                let least = if is_flat { 0.999 * EVEN_SHARE / count as f32 } else { 1e-7 };
                assert!(all.iter().all(|chance| *chance >= least), "{all:?}");
                let (mut times, steps) = (vec![0.0; count], 1024);
                for step in 0..steps {
                    let random = step as f32 / steps as f32;
                    let Chosen { source, chance, rest } = chances.choose(point, random);
                    let again = chances.choose_again(point, random, &mut sent);
                    assert_eq!(again, Chosen { source, chance, rest });
                    assert_eq!(chance, all[source], "{count} {point}");
                    assert!((0.0..1.0).contains(&rest), "{rest}");
                    times[source] += 1.0 / steps as f32;
                }
                // each part of the numbers may be a step longer or shorter, and a tree has up to four of each source
                let most = if is_flat { 3.0 } else { 8.0 };
                let off = times.iter().zip(&all).map(|(times, chance)| (times - chance).abs());
                assert!(off.fold(0.0, f32::max) < most / steps as f32, "{count} {point}: {times:?}, {all:?}");
            }
        }
    }

    #[test]
    fn of_many_lamps_a_surface_asks_those_beside_it() {
        let lights = with_many(Vec::new());
        let chances = chances_of(&lights);
        let asked_at = |lamp: usize| {
            let LightKind::Point { position } = &lights[lamp].kind else { unreachable!("all are lamps") };
            let beside = position.at(0.0).as_vec3() + Vec3::Y * 0.2;
            // both of that place, one of which may be dark
            let pair = lamp / 2 * 2;
            chances.of(beside, pair) + chances.of(beside, pair + 1)
        };
        let shining = (0..500).step_by(37).map(|lamp| 2 * lamp).filter(|lamp| lamp % 5 + (lamp + 1) % 5 > 1);
        for lamp in shining {
            // evenly it would be a five-hundredth
            assert!(asked_at(lamp) > 0.05, "{lamp}: {}", asked_at(lamp));
        }
    }

    #[test]
    fn a_surface_asks_what_shines_on_it() {
        let lights = lights();
        let chances = chances_of(&lights);
        let of = |light: usize, x: f32, y: f32| chances.of(Vec3::new(x, y, 0.0), light);
        let least = EVEN_SHARE / lights.len() as f32;
        // below the third lamp of the row, and below the last
        assert!(of(10, 6.0, 2.0) > 10.0 * of(16, 6.0, 2.0) && of(16, 24.0, 2.0) > 10.0 * of(10, 24.0, 2.0));
        // panels shine downwards, the spot within its cone
        for (light, [x, y]) in [(2, [1.0, 3.0]), (3, [1.0, 3.0]), (6, [3.0, 1.0]), (7, [0.5, 0.0])] {
            assert_eq!(of(light, x, y), least, "{light}");
        }
        assert!([2, 3, 6].iter().all(|light| of(*light, 1.0, 1.0) > 2.0 * least));
    }
}

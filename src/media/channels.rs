//! Which values of media that vary depend on each other: smoke of one colour has one number for each place, its density, and a fire whose
//! light is of another colour has two. A grid keeps these, and what 1 of each is.

use glam::Vec3;

use super::grid::{Cell, MOST_CHANNELS};

/// Share by which a value may differ from what another one says it is: rounding of products.
const SAME: f32 = 1e-5;

/// Values that others follow from.
#[derive(Debug, Clone, PartialEq)]
pub struct Channels {
    /// Each with the number of a value, and what each value is in units of it, where it follows from it.
    leads: Vec<(usize, [f32; MOST_CHANNELS])>,
}

impl Channels {
    /// Each value by itself.
    pub fn all() -> Self {
        let by_itself = |number| {
            let mut factors = [0.0; MOST_CHANNELS];
            factors[number] = 1.0;
            (number, factors)
        };
        Self { leads: (0..MOST_CHANNELS).map(by_itself).collect() }
    }

    /// Those that samples need.
    pub fn of(samples: &[Cell]) -> Self {
        let samples: Vec<[f32; MOST_CHANNELS]> = samples.iter().map(numbers).collect();
        let mut leads: Vec<(usize, [f32; MOST_CHANNELS])> = Vec::new();
        for number in 0..MOST_CHANNELS {
            if samples.iter().all(|sample| sample[number] == 0.0) {
                continue;
            }
            let factor = |lead: usize| {
                let largest = samples.iter().max_by(|a, b| a[lead].total_cmp(&b[lead]))?;
                let factor = largest[number] / largest[lead];
                let follows = |sample: &[f32; MOST_CHANNELS]| is_same(sample[number], sample[lead] * factor);
                (factor > 0.0 && factor.is_finite() && samples.iter().all(follows)).then_some(factor)
            };
            let found = leads.iter().enumerate().find_map(|(at, (lead, _))| Some((at, factor(*lead)?)));
            match found {
                Some((at, factor)) => leads[at].1[number] = factor,
                None => {
                    let mut factors = [0.0; MOST_CHANNELS];
                    factors[number] = 1.0;
                    leads.push((number, factors));
                }
            }
        }
        Self { leads }
    }

    /// What 1 of each is.
    pub fn cells(&self) -> Vec<Cell> {
        let three = |of: &[f32]| Vec3::from_slice(of);
        let cell = |(_, of): &(usize, [f32; MOST_CHANNELS])| Cell {
            scatter: three(&of[0..3]),
            absorb: three(&of[3..6]),
            emit: three(&of[6..9]),
        };
        self.leads.iter().map(cell).collect()
    }

    /// The values of each at some places, one after the other. `None` if others do not follow from them.
    pub fn values(&self, places: &[Cell]) -> Option<Vec<f32>> {
        let mut values = vec![0.0; self.leads.len() * places.len()];
        for (at, place) in places.iter().enumerate() {
            let all = numbers(place);
            let mut told = [0.0; MOST_CHANNELS];
            for (channel, (lead, factors)) in self.leads.iter().enumerate() {
                values[channel * places.len() + at] = all[*lead];
                for (told, factor) in told.iter_mut().zip(factors) {
                    *told += factor * all[*lead];
                }
            }
            if all.into_iter().zip(told).any(|(value, told)| !is_same(value, told)) {
                return None;
            }
        }
        Some(values)
    }
}

fn is_same(value: f32, told: f32) -> bool {
    (value - told).abs() <= SAME * value.abs().max(told.abs())
}

/// All values of a place, without what is negative or no number.
fn numbers(cell: &Cell) -> [f32; MOST_CHANNELS] {
    let clean = |value: f32| if value > 0.0 && value.is_finite() { value } else { 0.0 };
    let mut all = [0.0; MOST_CHANNELS];
    let colors = [cell.scatter, cell.absorb, cell.emit].into_iter().flat_map(|color| color.to_array());
    all.iter_mut().zip(colors).for_each(|(number, value)| *number = clean(value));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn smoke(density: f32, heat: f32) -> Cell {
        Cell {
            scatter: Vec3::new(0.5, 0.25, 0.0) * density,
            absorb: Vec3::ONE * density,
            emit: Vec3::new(3.0, 1.0, 0.2) * heat,
        }
    }

    #[test]
    fn what_depends_on_one_number_is_one_channel() {
        let places = [smoke(0.0, 0.0), smoke(2.0, 0.0), smoke(0.1, 0.0)];
        let channels = Channels::of(&places);
        assert_eq!(channels.leads.len(), 1);
        assert_eq!(channels.values(&places), Some(vec![0.0, 1.0, 0.05]));
        assert!((channels.cells()[0].absorb - Vec3::splat(2.0)).length() < 1e-6);
        // heat is another
        let places = [smoke(0.3, 0.1), smoke(2.0, 5.0), smoke(0.1, 0.0)];
        assert_eq!(Channels::of(&places).leads.len(), 2);
    }

    #[test]
    fn what_the_samples_did_not_show_is_told() {
        let channels = Channels::of(&[smoke(1.0, 0.0)]);
        assert_eq!(channels.values(&[smoke(1.0, 0.0), smoke(0.0, 1.0)]), None);
        assert_eq!(Channels::of(&[]).values(&[smoke(1.0, 0.0)]), None);
        let odd = [smoke(-1.0, f32::NAN), smoke(1.0, 2.0)];
        let [all, cells] = [Channels::all().values(&odd).expect("all have their own"), vec![0.0; 18]];
        assert_eq!((all.len(), all[0], all[12]), (cells.len(), 0.0, 0.0));
    }
}

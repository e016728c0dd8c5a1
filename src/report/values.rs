//! Statistics of the values of a channel: in our files and those of other programs.

/// Least, greatest and mean of the finite values, and numbers of those that are not finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Values {
    /// Least finite value; infinity if there is none.
    pub least: f32,
    /// Greatest finite value; minus infinity if there is none.
    pub greatest: f32,
    sum: f64,
    /// Number of finite values.
    pub finite: u64,
    /// Number of NaNs.
    pub nan: u64,
    /// Number of infinite values, of either sign.
    pub infinite: u64,
}

impl Default for Values {
    /// Statistics of no values.
    fn default() -> Self {
        Self { least: f32::INFINITY, greatest: f32::NEG_INFINITY, sum: 0.0, finite: 0, nan: 0, infinite: 0 }
    }
}

impl Values {
    /// Adds `values`.
    pub fn add(&mut self, values: &[f32]) {
        for &value in values {
            if value.is_finite() {
                (self.least, self.greatest) = (self.least.min(value), self.greatest.max(value));
                self.sum += f64::from(value);
                self.finite += 1;
            } else if value.is_nan() {
                self.nan += 1;
            } else {
                self.infinite += 1;
            }
        }
    }

    /// Mean of the finite values; `None` if there is none.
    pub fn mean(&self) -> Option<f64> {
        (self.finite > 0).then(|| self.sum / self.finite as f64)
    }
}

/// Layer of a channel: the part of its name before the last dot; empty for channels of no layer.
pub fn layer_of(channel: &str) -> &str {
    channel.rsplit_once('.').map_or("", |(layer, _)| layer)
}

/// Name of a channel within its layer.
pub fn name_in_layer(channel: &str) -> &str {
    channel.rsplit_once('.').map_or(channel, |(_, name)| name)
}

/// Sorting key in the order in which people read channels: R G B A, X Y Z, others by name.
pub fn reading_order(channel: &str) -> (usize, &str) {
    let name = name_in_layer(channel);
    ("RGBAXYZUV".find(name).filter(|_| name.len() == 1).unwrap_or(usize::MAX), name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_is_counted_and_in_no_mean() {
        let mut values = Values::default();
        assert_eq!(values.mean(), None);
        values.add(&[1.0, f32::NAN, -3.0]);
        values.add(&[f32::INFINITY, f32::NEG_INFINITY, 5.0]);
        assert_eq!((values.least, values.greatest, values.mean()), (-3.0, 5.0, Some(1.0)));
        assert_eq!((values.finite, values.nan, values.infinite), (3, 1, 2));
    }

    #[test]
    fn channels_are_read_by_layer() {
        assert_eq!(["R", "a.b.R", "Z", "P.X"].map(layer_of), ["", "a.b", "", "P"]);
        let mut names = ["A", "B", "G", "R", "depth"];
        names.sort_by_key(|name| reading_order(name));
        assert_eq!(names, ["R", "G", "B", "A", "depth"]);
    }
}

//! What a ray goes through: the glass that it has entered, whose light fades on the way.

use glam::Vec3;

use super::bsdf::palette::Palette;

/// The solids that a ray is in: that which it has entered last, and the one around that. Farther ones are forgotten, so that light fades
/// no more where it has left two in others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Within {
    /// Material of the innermost.
    innermost: Option<u16>,
    /// Material of the one around it.
    around: Option<u16>,
}

impl Within {
    /// Outside of all solids.
    pub const NOTHING: Self = Self { innermost: None, around: None };

    /// Where a ray is that has passed through the surface of a solid of this `material`, inwards or, `from_behind`, outwards.
    #[must_use]
    pub fn beyond(self, material: u16, from_behind: bool) -> Self {
        match (from_behind, self.innermost == Some(material)) {
            (false, _) => Self { innermost: Some(material), around: self.innermost },
            (true, true) => Self { innermost: self.around, around: None },
            // two solids that overlap: it has left the outer one
            (true, false) => Self { around: self.around.filter(|around| *around != material), ..self },
        }
    }

    /// Share of the light that is left after this `length` of the way (world space): by Beer and Lambert's law. All of it where the way has
    /// no end: the solid is open, and how much of it light has passed is not known.
    pub fn left(self, palette: &Palette, length: f32) -> Vec3 {
        match self.innermost {
            Some(material) if length.is_finite() => (-palette.absorption(material) * length).exp(),
            _ => Vec3::ONE,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_leaves_what_it_has_entered() {
        let [glass, water] = [3, 7];
        let in_glass = Within::NOTHING.beyond(glass, false);
        assert_eq!(in_glass.beyond(glass, true), Within::NOTHING);
        let in_both = in_glass.beyond(water, false);
        assert_eq!(in_both.beyond(water, true), in_glass, "a thing in glass");
        assert_eq!(
            in_both.beyond(glass, true),
            Within::NOTHING.beyond(water, false),
            "water that reaches into glass"
        );
        assert_eq!(Within::NOTHING.beyond(glass, true), Within::NOTHING, "the eye was inside");
    }
}

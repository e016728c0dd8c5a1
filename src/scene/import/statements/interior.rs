//! What files state of the inside of a surface: of glass, and of what scatters light below itself or through.

use glam::Vec3;

use crate::scene::material::Scattering;

/// What a file says of the inside of a surface; MTL has no such statements.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct StatedInterior {
    /// Share of the diffuse light that goes below the surface, 0 to 1.
    pub subsurface: Option<f32>,
    /// Mean free path there, by channel.
    pub subsurface_radius: Option<Vec3>,
    /// Share of the diffuse light that leaves on the other side, 0 to 1.
    pub translucency: Option<f32>,
    /// Length after which light within glass has the colour `depth_color`; 0 for glass that absorbs none.
    pub depth: Option<f32>,
    /// That colour.
    pub depth_color: Option<Vec3>,
    /// True if glass is a pane: both of its walls at once.
    pub is_thin: Option<bool>,
}

/// Mean free path below a surface where none is stated: that of OpenPBR.
const SUBSURFACE_RADIUS: Vec3 = Vec3::new(1.0, 0.5, 0.25);

/// Least mean free path: light that goes less far below a surface comes out where it went in.
const LEAST_RADIUS: f32 = 1e-8;

/// Least share of light that is left after the stated length: the logarithm of none is infinite.
const LEAST_LEFT: f32 = 1e-6;

impl StatedInterior {
    /// Takes every value that `other` states.
    pub fn replace_with(&mut self, other: &Self) {
        self.subsurface = other.subsurface.or(self.subsurface);
        self.subsurface_radius = other.subsurface_radius.or(self.subsurface_radius);
        self.translucency = other.translucency.or(self.translucency);
        self.depth = other.depth.or(self.depth);
        self.depth_color = other.depth_color.or(self.depth_color);
        self.is_thin = other.is_thin.or(self.is_thin);
    }

    /// What becomes of diffuse light that does not leave where it came, if any does not.
    pub fn scattering(&self) -> Option<Scattering> {
        let radius = self.subsurface_radius.unwrap_or(SUBSURFACE_RADIUS);
        let through = self.translucency.unwrap_or(0.0).clamp(0.0, 1.0);
        let weight = self.subsurface.unwrap_or(0.0).clamp(0.0, 1.0 - through);
        let below = Vec3::select(radius.cmpgt(Vec3::splat(LEAST_RADIUS)), Vec3::splat(weight), Vec3::ZERO);
        (below != Vec3::ZERO || through > 0.0).then_some(Scattering { below, radius, through })
    }

    /// What glass absorbs for each unit of length: the exponents of Beer and Lambert's law.
    pub fn absorption(&self) -> Vec3 {
        let depth = self.depth.unwrap_or(0.0);
        if depth <= 0.0 || self.is_thin() {
            return Vec3::ZERO;
        }
        let left = self.depth_color.unwrap_or(Vec3::ONE).clamp(Vec3::splat(LEAST_LEFT), Vec3::ONE);
        -left.ln() / depth
    }

    /// Returns true if glass is a pane.
    pub fn is_thin(&self) -> bool {
        self.is_thin == Some(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glass_has_its_colour_at_its_depth() {
        let stated = StatedInterior {
            depth: Some(0.5),
            depth_color: Some(Vec3::new(1.0, 0.5, 0.0)),
            ..StatedInterior::default()
        };
        let left = (-stated.absorption() * 0.5).exp();
        assert!((left - Vec3::new(1.0, 0.5, 1e-6)).abs().max_element() < 1e-6, "{left}");
        assert_eq!(
            StatedInterior { is_thin: Some(true), ..stated }.absorption(),
            Vec3::ZERO,
            "a pane has no depth"
        );
        assert_eq!(StatedInterior::default().absorption(), Vec3::ZERO);
    }

    /// Icing whose red light goes nowhere below it is as red as matt icing.
    #[test]
    fn light_that_goes_nowhere_stays_at_the_surface() {
        let stated = |radius, translucency| StatedInterior {
            subsurface: Some(0.75),
            subsurface_radius: Some(radius),
            translucency,
            ..StatedInterior::default()
        };
        let icing = stated(Vec3::new(0.0, 0.1, 0.1), None).scattering().expect("some goes below");
        assert_eq!(
            (icing.below, icing.at_surface()),
            (Vec3::new(0.0, 0.75, 0.75), Vec3::new(1.0, 0.25, 0.25))
        );
        assert_eq!(stated(Vec3::ZERO, None).scattering(), None);
        let leaf = stated(Vec3::ONE, Some(0.5)).scattering().expect("some goes through");
        assert_eq!((leaf.below, leaf.at_surface()), (Vec3::splat(0.5), Vec3::ZERO), "there is no more light");
    }
}

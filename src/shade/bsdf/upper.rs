//! What is above the layer of a surface, as one ray sees it: a coat, and fuzz above that.

use glam::Vec3;

use super::coat::SeenCoat;
use super::fuzz::SeenFuzz;

/// What is above a layer. Of what is not there nothing reflects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Upper {
    /// The coat, as far as fuzz lets its light through.
    pub coat: SeenCoat,
    /// Fuzz above it.
    pub fuzz: SeenFuzz,
    /// Share of the light of what is below both that comes through.
    pub lets_through: Vec3,
    /// Chances of all lobes, that of the layer below among them.
    pub chances: Chances,
}

/// Lobe by which a direction is sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lobe {
    Layer,
    Coat,
    Fuzz,
}

/// Chances with which directions are sampled by lobes other than the layer's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chances {
    pub coat: f32,
    pub fuzz: f32,
}

/// Greatest random number below 1.
const MOST_RANDOM: f32 = 1.0 - f32::EPSILON / 2.0;

impl Chances {
    /// By the layer's lobe alone.
    pub const LAYER: Self = Self { coat: 0.0, fuzz: 0.0 };

    /// In proportion to these albedos.
    pub fn new(coat: f32, fuzz: Vec3, layer: Vec3) -> Self {
        let fuzz = fuzz.max_element();
        let sum = coat + fuzz + layer.max_element();
        if sum > 0.0 { Self { coat: coat / sum, fuzz: fuzz / sum } } else { Self::LAYER }
    }

    /// Chance of the layer's lobe.
    pub fn layer(&self) -> f32 {
        (1.0 - self.coat - self.fuzz).max(0.0)
    }

    /// The lobe that a `random` number from 0 to below 1 chooses, and the rest of the number, which is as even as it was.
    pub fn choose(&self, random: f32) -> (Lobe, f32) {
        let Self { coat, fuzz } = *self;
        let (lobe, from, chance) = if random < coat {
            (Lobe::Coat, 0.0, coat)
        } else if random < coat + fuzz {
            (Lobe::Fuzz, coat, fuzz)
        } else {
            (Lobe::Layer, coat + fuzz, self.layer())
        };
        (lobe, ((random - from) / chance).clamp(0.0, MOST_RANDOM))
    }
}

impl Upper {
    /// A coat, and fuzz above it, above a layer that would reflect the share `below` of light without them.
    pub fn new(coat: SeenCoat, fuzz: SeenFuzz, below: Vec3) -> Self {
        let lets_through = coat.lets_through * fuzz.lets_through;
        let coat = coat.dimmed(fuzz.lets_through);
        let chances = Chances::new(coat.albedo, fuzz.albedo, below * lets_through);
        Self { coat, fuzz, lets_through, chances }
    }

    /// Share of light from all around that both reflect.
    pub fn albedo(&self) -> Vec3 {
        self.fuzz.albedo + self.coat.albedo
    }

    /// What of it is a mirror.
    pub fn smooth(&self) -> Self {
        let coat = if self.coat.is_smooth() { self.coat } else { self.coat.dimmed(0.0) };
        Self { coat, fuzz: SeenFuzz::NONE, ..*self }
    }

    /// What of it is none.
    pub fn rough(&self) -> Self {
        let coat = if self.coat.is_smooth() { self.coat.dimmed(0.0) } else { self.coat };
        Self { coat, ..*self }
    }

    /// Chances of its lobes above a layer that reflects so much.
    pub fn chances_above(&self, layer: Vec3) -> Chances {
        Chances::new(self.coat.albedo, self.fuzz.albedo, layer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_choose_lobes_and_stay_even() {
        let chances = Chances::new(0.2, Vec3::new(0.1, 0.3, 0.0), Vec3::splat(0.5));
        assert!((chances.coat - 0.2).abs() < 1e-6 && (chances.fuzz - 0.3).abs() < 1e-6, "{chances:?}");
        for (random, lobe, rest) in
            [(0.1, Lobe::Coat, 0.5), (0.35, Lobe::Fuzz, 0.5), (0.75, Lobe::Layer, 0.5)]
        {
            let chosen = chances.choose(random);
            assert!(chosen.0 == lobe && (chosen.1 - rest).abs() < 1e-6, "{random}: {chosen:?}");
        }
        assert_eq!(Chances::new(0.0, Vec3::ZERO, Vec3::ZERO), Chances::LAYER);
    }
}

//! Light of the cells of a tile, by layer.

use glam::Vec3;

use crate::lanes::{F32x8, Vec3x8};
use crate::samples::{CELLS, Column};

/// Upper limit of light, so that no sum of samples is infinite. Half floats end at 65504.
const MOST_LIGHT: f32 = 1e30;

/// Colours of a tile's cells, in three columns. Linear RGB.
pub type Light = [Column<f32>; 3];

/// No light.
pub const DARK: Light = [[0.0; CELLS]; 3];

/// Layer of the picture that rays beyond the first surface add to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layer {
    /// Light of rays that were reflected by the sample.
    Reflection,
    /// Light of rays that went through it.
    Refraction,
}

/// Light of the cells of a tile, by layer of the picture; the sum of the layers is the picture.
#[derive(Debug)]
pub struct Radiance {
    /// Emission, ambient and diffuse light; the background.
    pub diffuse: Light,
    /// Highlights. Means nothing where `has_specular` is not set.
    pub specular: Light,
    /// Light in mirrors, and off glass. Means nothing where `has_secondary` is not set.
    pub reflection: Light,
    /// Light through glass. Means nothing where `has_secondary` is not set.
    pub refraction: Light,
    /// Share of what is behind the picture that shows: through veils, in holes and on catchers of shadows. Means nothing where `has_secondary` is not set.
    pub clear: Column<f32>,
    /// Parts of `diffuse`, and guides for denoisers. Columns that no layer shows mean nothing.
    pub parts: Parts,
    /// True if any cell has a highlight.
    pub has_specular: bool,
    /// True if any light comes from beyond the first surface.
    pub has_secondary: bool,
    /// True if rays follow mirrors or glass of the tile.
    pub is_followed: bool,
}

/// Parts of the light: see [`Radiance::parts`].
#[derive(Debug)]
pub struct Parts {
    /// Diffuse light of light sources.
    pub direct: Light,
    /// Diffuse light that came by light paths.
    pub indirect: Light,
    /// Emission and ambient light.
    pub emission: Light,
    /// The background as the eye sees it.
    pub sky: Light,
    /// By what the shadows on catchers dim what is behind the picture: 1 where no catcher is seen.
    pub catcher: Light,
    /// Guide for denoisers: the albedo of the first surface that is neither mirror nor glass, seen by way of
    /// those.
    pub guide_albedo: Light,
    /// Guide for denoisers: that surface's normal.
    pub guide_normal: Light,
    /// Diffuse light and highlights of each group of lights.
    pub groups: Vec<Light>,
}

impl Default for Parts {
    fn default() -> Self {
        Self {
            direct: DARK,
            indirect: DARK,
            emission: DARK,
            sky: DARK,
            catcher: DARK,
            guide_albedo: DARK,
            guide_normal: DARK,
            groups: Vec::new(),
        }
    }
}

impl Default for Radiance {
    fn default() -> Self {
        Self {
            diffuse: DARK,
            specular: DARK,
            reflection: DARK,
            refraction: DARK,
            clear: [0.0; CELLS],
            parts: Parts::default(),
            has_specular: false,
            has_secondary: false,
            is_followed: false,
        }
    }
}

impl Radiance {
    /// Resets the state for a new tile: no highlights and no light from beyond the first surface.
    pub fn begin_tile(&mut self) {
        (self.has_specular, self.has_secondary, self.is_followed) = (false, false, false);
    }

    /// Prepares the layer of highlights for writing.
    pub fn open_specular(&mut self) {
        if !self.has_specular {
            self.has_specular = true;
            self.specular = DARK;
        }
    }

    /// Prepares the layers of rays beyond the first surface for writing.
    pub fn open_secondary(&mut self) {
        if !self.has_secondary {
            self.has_secondary = true;
            (self.reflection, self.refraction, self.clear) = (DARK, DARK, [0.0; CELLS]);
        }
    }

    /// Adds `light` to a layer of a cell.
    #[inline]
    pub fn add_secondary(&mut self, layer: Layer, cell: usize, light: Vec3) {
        let layer = match layer {
            Layer::Reflection => &mut self.reflection,
            Layer::Refraction => &mut self.refraction,
        };
        for (column, light) in layer.iter_mut().zip(light.to_array()) {
            column[cell] += light;
        }
    }

    /// Adds light of the background, seen through veils or on catchers, to the layer that has it.
    pub fn add_sky(&mut self, cell: usize, light: Vec3) {
        for (column, light) in self.parts.sky.iter_mut().zip(light.to_array()) {
            column[cell] += light;
        }
    }

    /// Removes all that a cell shows: it is a hole in the picture. Its guides stay. The layers of rays beyond the first
    /// surface must be [open](Self::open_secondary).
    pub fn hold_out(&mut self, cell: usize) {
        let Self { diffuse, specular, reflection, refraction, clear, parts, .. } = self;
        clear[cell] = 1.0;
        let Parts { direct, indirect, emission, sky, groups, .. } = parts;
        let all = [diffuse, specular, reflection, refraction, direct, indirect, emission, sky];
        for column in all.into_iter().chain(groups).flatten() {
            column[cell] = 0.0;
        }
    }

    /// Shows the light of what is behind the picture in a cell, which covers all then.
    pub fn show_behind(&mut self, cell: usize, light: Vec3) {
        self.clear[cell] = 0.0;
        for (column, light) in self.diffuse.iter_mut().zip(light.to_array()) {
            column[cell] = light;
        }
    }

    /// Light of rays beyond the first surface in a cell: reflected and refracted.
    pub fn secondary(&self, cell: usize) -> [[f32; 3]; 2] {
        [&self.reflection, &self.refraction].map(|light| light.each_ref().map(|column| column[cell]))
    }

    /// Sets the reflected and refracted light of a cell.
    pub fn set_secondary(&mut self, cell: usize, light: [[f32; 3]; 2]) {
        for (columns, light) in [&mut self.reflection, &mut self.refraction].into_iter().zip(light) {
            columns.iter_mut().zip(light).for_each(|(column, light)| column[cell] = light);
        }
    }

    /// Guides of a cell for denoisers: albedo and normal.
    pub fn guides(&self, cell: usize) -> [[f32; 3]; 2] {
        let Parts { guide_albedo, guide_normal, .. } = &self.parts;
        [guide_albedo, guide_normal].map(|guide| guide.each_ref().map(|column| column[cell]))
    }

    /// Sets the guides of a cell: albedo and normal.
    pub fn set_guides(&mut self, cell: usize, guides: [[f32; 3]; 2]) {
        let Parts { guide_albedo, guide_normal, .. } = &mut self.parts;
        for (columns, guide) in [guide_albedo, guide_normal].into_iter().zip(guides) {
            columns.iter_mut().zip(guide).for_each(|(column, value)| column[cell] = value);
        }
    }

    /// Clamps the light of rays beyond the first surface: it is neither negative nor infinite; and shares of what is behind.
    pub fn cut_secondary(&mut self) {
        for value in self.reflection.iter_mut().chain(&mut self.refraction).flatten() {
            *value = value.clamp(0.0, MOST_LIGHT);
        }
        for share in &mut self.clear {
            *share = share.clamp(0.0, 1.0);
        }
    }
}

/// Clamps the light of eight samples in the same way.
pub fn cut(light: Vec3x8) -> Vec3x8 {
    let cut = |light: F32x8| light.max(F32x8::ZERO).min(F32x8::splat(MOST_LIGHT));
    Vec3x8 { x: cut(light.x), y: cut(light.y), z: cut(light.z) }
}

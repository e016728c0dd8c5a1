//! Settles materials: what MTL and shot files state of one becomes what surfaces are made of, with its pictures.

use std::path::Path;

use super::varying::{self, PARAMETERS, Settled};
use crate::scene::cutout::{ALL_BUT_OPAQUE, Cutout, LEAST_OPACITY};
use crate::scene::import::Import;
use crate::scene::import::pictures::PictureUse;
use crate::scene::import::statements::Statements;
use crate::scene::import::statements::maps::{Channel, MapUse};
use crate::scene::keys::material::AlphaMode;
use crate::scene::{Material, SceneError};

/// Meaning of alpha that a picture has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::scene) enum Alpha {
    /// Places where it is below that are not there.
    Cut(f32),
    /// Each place is a veil as clear as it says, where the material can be one. Else it cuts out.
    Blend,
}

impl Alpha {
    /// The meaning that a shot file states; without one it cuts out.
    pub fn of(stated: Option<AlphaMode>) -> Self {
        match stated {
            Some(AlphaMode::Blend) => Self::Blend,
            Some(AlphaMode::Cut) | None => Self::Cut(LEAST_OPACITY),
        }
    }
}

impl Import {
    /// Settles a material of what is stated of it in the file at `own`; a grey one where nothing is.
    ///
    /// # Errors A picture that is missing, in a strict load.
    pub fn settle(&mut self, mut stated: Statements, own: &Path) -> Result<Settled, SceneError> {
        let is_nameless = stated.name.is_empty();
        let overridden = self.override_values(&mut stated)?;
        let asking = |used| overridden.places[used].as_deref().unwrap_or(own);
        let mut material = stated.settle();
        if is_nameless {
            material.name = Material::fallback().name;
        }
        if let Some(map) = &stated.maps[MapUse::Color] {
            material.diffuse_map = Some(self.picture(map, asking(MapUse::Color), PictureUse::Color)?);
        }
        let graphs = overridden.apply(&mut material);
        let opacity = match &stated.maps[MapUse::Opacity] {
            Some(map) => Some(self.picture(map, asking(MapUse::Opacity), PictureUse::Opacity)?),
            None => material.diffuse_map,
        };
        let mut settled = self.settle_maps(&stated, asking, Settled { material, graphs })?;
        if let Some(map) = opacity {
            self.show_stated_alpha(&mut settled, map, stated.alpha_mode);
        }
        Ok(settled)
    }

    /// Has the alpha of texture number `map`, which an MTL or a shot file states, show on a material. Alpha that is below a half all over
    /// means nothing, unless the shot file says what it means.
    pub(in crate::scene) fn show_stated_alpha(
        &self,
        settled: &mut Settled,
        map: u32,
        mode: Option<AlphaMode>,
    ) {
        if mode.is_some() || self.pictures.cuts(map) {
            self.show_alpha(settled, map, Alpha::of(mode));
        }
    }

    /// Has the alpha of texture number `map` show on a material.
    pub(in crate::scene) fn show_alpha(&self, settled: &mut Settled, map: u32, alpha: Alpha) {
        let Settled { material, graphs } = settled;
        material.cutout = match alpha {
            Alpha::Blend if material.can_blend() => {
                let shows = self.pictures.falls_below(map, ALL_BUT_OPAQUE);
                shows.then(|| {
                    graphs.show(MapUse::Opacity, map, Channel::Alpha);
                    Cutout::blended(map, material.opacity())
                })
            }
            Alpha::Blend => self.cut_below(map, LEAST_OPACITY),
            Alpha::Cut(least) => self.cut_below(map, least),
        };
    }

    /// The cut-out of places where the alpha of a texture is below `least`, if there are any.
    fn cut_below(&self, map: u32, least: f32) -> Option<Cutout> {
        self.pictures.falls_below(map, least).then(|| Cutout::by_picture(map, least))
    }

    /// Gives a material the map of its normals, and finds those of its parameters. `asking`: the file that states the map of
    /// each use.
    pub(in crate::scene) fn settle_maps<'p>(
        &mut self,
        stated: &Statements,
        asking: impl Fn(MapUse) -> &'p Path,
        Settled { mut material, mut graphs }: Settled,
    ) -> Result<Settled, SceneError> {
        for (used, as_picture) in [(MapUse::Normal, PictureUse::Normals), (MapUse::Bump, PictureUse::Heights)]
        {
            if let Some(map) = stated.maps[used].as_ref().filter(|_| material.normal_map.is_none()) {
                let index = self.picture(map, asking(used), as_picture)?;
                material.normal_map = self.pictures.normal_map(index, map.slope);
            }
        }
        for used in PARAMETERS {
            let Some(map) = &stated.maps[used] else { continue };
            if !varying::is_of_use(&material, used) {
                let message = format!(
                    "the material `{}` has no such parameter: its {} is not used",
                    material.name,
                    used.keyword()
                );
                self.findings.note(SceneError::new(asking(used), message).at_line(map.line));
                continue;
            }
            let index = self.picture(map, asking(used), varying::picture_use(used))?;
            if !self.pictures.is_stand_in(index) {
                graphs.show(used, index, map.channel);
            }
        }
        Ok(Settled { material, graphs })
    }
}

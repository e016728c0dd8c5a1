//! `[[material]]` tables of shot files: what they put in place of the materials of models.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::graph::nodes::picture;
use crate::scene::cutout::LEAST_OPACITY;
use crate::scene::import::Import;
use crate::scene::import::mtl::statements::Statements;
use crate::scene::import::mtl::statements::maps::{ByUse, MapStatements, MapUse, PARAMETERS};
use crate::scene::import::mtlx::{self, Document};
use crate::scene::import::pictures::Named;
use crate::scene::keys::material::AlphaMode;
use crate::scene::keys::spelling;
use crate::scene::material::Along;
use crate::scene::paths::find_beside;
use crate::scene::surface::{Alpha, Displaced, Parameter, PlaceAlpha, Surface, Value};
use crate::scene::{Material, SceneError};

impl Import {
    /// Finds the material that the `[[material]]` tables define under `name`, without any model: its index, or the error in it. Without
    /// a name, that of the stand-in material. `None` if no table defines the name.
    pub fn material_of_table(&mut self, name: &str) -> Option<Result<u16, String>> {
        if !name.is_empty() && !self.surfaces.is_overridden(name) {
            return None;
        }
        if let Some(known) = self.surfaces.of_tables.get(name) {
            return Some(Ok(*known));
        }
        let shot = self.surfaces.overrides.iter().find(|entry| entry.values.name == name);
        let path = shot.map_or(PathBuf::new(), |entry| entry.path.clone());
        let stated = Statements { name: name.to_string(), ..Statements::default() };
        let surface = self.stated_surface(stated, &path);
        Some(surface.map_err(|why| why.to_string()).and_then(|surface| {
            let settled = self.settle(surface);
            let index = self.surfaces.add_settled(settled).ok_or("there are too many materials")?;
            self.surfaces.of_tables.insert(name.to_string(), index);
            Ok(index)
        }))
    }

    /// The surface of what the MTL file at `own` states, and of what tables of its name state in place of that: these are MTL's
    /// statements as well, and mean something together.
    ///
    /// # Errors
    /// Those of MaterialX files that they name; in a strict load also a picture that is missing.
    pub(in crate::scene) fn stated_surface(
        &mut self,
        mut stated: Statements,
        own: &Path,
    ) -> Result<Surface, SceneError> {
        if let Some(surface) = self.surface_of_table(&stated.name)? {
            return self.lay_tables_over(surface);
        }
        let (of_tables, places) = self.stated_by_tables(&stated.name);
        stated.replace_with(&of_tables);
        let asking = |used| places[used].as_deref().unwrap_or(own);
        let mut surface = stated.surface();
        self.show_maps(&mut surface, &stated.maps, asking)?;
        let opacity = match &stated.maps[MapUse::Opacity] {
            Some(map) => Some(self.picture(map, asking(MapUse::Opacity), MapUse::Opacity.of_picture())?),
            None => surface.base_picture,
        };
        surface.alpha = opacity.and_then(|map| self.stated_alpha(map, stated.alpha_mode));
        if surface.name.is_empty() {
            surface.name = Material::fallback().name;
        }
        Ok(surface)
    }

    /// Has the tables of its name replace values of a surface that a file of another kind has.
    ///
    /// # Errors
    /// In a strict load: a picture that is missing.
    pub(in crate::scene) fn lay_tables_over(&mut self, mut surface: Surface) -> Result<Surface, SceneError> {
        let (stated, places) = self.stated_by_tables(&surface.name);
        let asking = |used| places[used].as_deref().unwrap_or(Path::new(""));
        stated.lay_over(&mut surface);
        self.show_maps(&mut surface, &stated.maps, asking)?;
        let color = stated.maps.has(MapUse::Color);
        let is_even = surface.alpha.is_none() && surface[Parameter::GeometryOpacity].node.is_none();
        surface.alpha = match &stated.maps[MapUse::Opacity] {
            Some(map) => {
                let map = self.picture(map, asking(MapUse::Opacity), MapUse::Opacity.of_picture())?;
                surface[Parameter::GeometryOpacity].node = None;
                self.stated_alpha(map, stated.alpha_mode)
            }
            None if color && is_even => {
                surface.base_picture.and_then(|map| self.stated_alpha(map, stated.alpha_mode))
            }
            None => with_mode(&surface, stated.alpha_mode),
        };
        Ok(surface)
    }

    /// What all tables of this name state together, with the shot file of each picture.
    fn stated_by_tables(&mut self, name: &str) -> (Statements, ByUse<PathBuf>) {
        let mut all = Statements { name: name.to_string(), ..Statements::default() };
        let mut places = ByUse::default();
        for (values, shot) in self.surfaces.tables_of(name) {
            all.replace_with(&values);
            places.replace_with(&values.maps.map(|_| shot.clone()));
        }
        (all, places)
    }

    /// The surface that the last table of this name takes from a MaterialX file, if one does.
    ///
    /// # Errors
    /// Those of the file, and of its pictures.
    pub(in crate::scene) fn surface_of_table(&mut self, name: &str) -> Result<Option<Surface>, SceneError> {
        let path = self.surfaces.mtlx_of(name);
        path.map(|path| self.mtlx_surface(&path, name)).transpose()
    }

    /// Gives a surface the pictures that are stated of it, but for that of its opacity. `asking`: the file that states the one of each use.
    fn show_maps<'p>(
        &mut self,
        surface: &mut Surface,
        maps: &MapStatements,
        asking: impl Fn(MapUse) -> &'p Path,
    ) -> Result<(), SceneError> {
        if let Some(map) = &maps[MapUse::Color] {
            let index = self.picture(map, asking(MapUse::Color), MapUse::Color.of_picture())?;
            surface.base_picture = Some(index);
            let base = &mut surface[Parameter::BaseColor];
            *base = Value { node: None, ..*base };
            surface[Parameter::SubsurfaceColor] = surface[Parameter::BaseColor];
        }
        let bends = [MapUse::Normal, MapUse::Bump].map(|used| maps[used].as_ref().map(|map| (used, map)));
        if bends.iter().any(Option::is_some) {
            (surface.normals, surface.heights) = (None, None);
        }
        for (used, map) in bends.into_iter().flatten() {
            if surface.normals.is_none() {
                let index = self.picture(map, asking(used), used.of_picture())?;
                surface.normals = (!self.pictures.is_stand_in(index)).then_some((index, map.slope));
            }
        }
        if let Some(map) = &maps[MapUse::Displacement] {
            let used = MapUse::Displacement;
            let index = self.picture(map, asking(used), used.of_picture())?;
            let by = picture::add(&mut surface.graph, index, map.channel, None);
            let stated = Displaced { by, scale: map.slope, middle: map.middle, along: Along::Normal };
            surface.displaced = (!self.pictures.is_stand_in(index)).then_some(stated);
        }
        let material = surface.material();
        for used in PARAMETERS {
            let Some(map) = &maps[used] else { continue };
            if !used.is_of(&material) {
                let message = format!(
                    "the material `{}` has no such parameter: its {} is not used",
                    material.name,
                    used.keyword()
                );
                self.findings.note(SceneError::new(asking(used), message).at_line(map.line));
                continue;
            }
            let index = self.picture(map, asking(used), used.of_picture())?;
            used.hide(surface);
            if !self.pictures.is_stand_in(index) {
                used.show(surface, index, map.channel);
            }
        }
        Ok(())
    }

    /// Alpha of texture number `map`, which an MTL or a shot file states. Alpha that is below a half all over means nothing, unless the
    /// shot file says what it means.
    fn stated_alpha(&self, map: u32, mode: Option<AlphaMode>) -> Option<PlaceAlpha> {
        let alpha = PlaceAlpha { map: Some(map), by_vertices: false, meaning: meaning_of(mode) };
        (mode.is_some() || self.pictures.cuts(map)).then_some(alpha)
    }

    /// The material of this name of the MaterialX file at `path`.
    ///
    /// # Errors
    /// Those of the file, and of its pictures.
    pub(in crate::scene) fn mtlx_surface(&mut self, path: &Path, name: &str) -> Result<Surface, SceneError> {
        let document = self.mtlx_document(path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let Self { pictures, findings, .. } = self;
        let (surface, told) = mtlx::surface(&document, name, &mut |asked| {
            let is_plain =
                find_beside(folder, &asked.file).is_none() && find_beside(folder, &asked.plain).is_some();
            let file = if is_plain { &asked.plain } else { &asked.file };
            let named = Named { file, folder, asking: path, line: asked.line, space: None };
            let index = pictures.index_at(&named, asked.mapping, findings, asked.used)?;
            Ok(Some(index).filter(|index| asked.has_stand_in || !pictures.is_stand_in(*index)))
        })?;
        for (line, said) in told {
            self.findings.note(SceneError::new(path, format!("material `{name}`: {said}")).at_line(line));
        }
        Ok(surface)
    }

    /// The MaterialX file at `path`, read once.
    ///
    /// # Errors
    /// One that cannot be read, or is no MaterialX.
    pub(in crate::scene) fn mtlx_document(&mut self, path: &Path) -> Result<Arc<Document>, SceneError> {
        let (document, is_new) = self.surfaces.mtlx.at(path)?;
        if is_new {
            self.inputs.add([path.to_path_buf()], document.digest);
        }
        Ok(document)
    }

    /// Reports overrides that no model uses.
    ///
    /// # Errors Any such override, in a strict load.
    pub fn report_unused_overrides(&mut self) -> Result<(), SceneError> {
        let used: Vec<String> =
            self.surfaces.materials.iter().map(|material| material.name.clone()).collect();
        for entry in self.surfaces.overrides.iter().filter(|entry| !entry.used) {
            let name = &entry.values.name;
            let message = if self.surfaces.known_names.contains(name) {
                format!("the material `{name}` is defined, but no face uses it")
            } else {
                format!(
                    "no model has a material `{name}`{}",
                    spelling::hint(name, used.iter().map(String::as_str))
                )
            };
            let finding = SceneError::new(&entry.path, message).at(entry.line, entry.column);
            self.findings.stand_in(finding)?;
        }
        Ok(())
    }
}

/// The meaning of alpha that a shot file states; without one it cuts out.
fn meaning_of(mode: Option<AlphaMode>) -> Alpha {
    match mode {
        Some(AlphaMode::Blend) => Alpha::Blend,
        Some(AlphaMode::Cut) | None => Alpha::Cut(LEAST_OPACITY),
    }
}

/// The alpha of a surface with the meaning that a shot file states: that of the picture of its colour, if it has no other.
fn with_mode(surface: &Surface, mode: Option<AlphaMode>) -> Option<PlaceAlpha> {
    let of_base = || {
        let map = surface.base_picture?;
        Some(PlaceAlpha { map: Some(map), by_vertices: false, meaning: meaning_of(mode) })
    };
    let own = surface.alpha;
    match (mode, own.map(|alpha| alpha.meaning)) {
        (None, _) | (Some(AlphaMode::Cut), Some(Alpha::Cut(_))) => own,
        (mode, _) => own.or_else(of_base).map(|alpha| PlaceAlpha { meaning: meaning_of(mode), ..alpha }),
    }
}

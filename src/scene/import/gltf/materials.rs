//! Materials of glTF files, as the renderer has them.

use glam::{DMat2, DVec2, DVec3, Vec3};
use serde::Deserialize;

use super::document::{Document, extension};
use super::json::{Material as Json, TextureInfo, TextureTransform};
use super::reading::Reading;
use super::upper::note_coat_of_glass;
use crate::graph::nodes::picture::Shown;
use crate::scene::cutout::LEAST_OPACITY;
use crate::scene::import::mtl::statements::maps::MapUse;
use crate::scene::import::pictures::PictureUse;
use crate::scene::material::LARGEST_COLOR;
use crate::scene::surface::{Alpha, Parameter, PlaceAlpha, Surface, Value};
use crate::scene::texture::{Mapping, UvSet, Wrap};
use crate::scene::{Material, SceneError, Texture};

/// Index of refraction of a file that states none.
const DEFAULT_INDEX: f64 = 1.5;

/// Alpha below which a material with cut-outs is not there, if the file does not say.
const DEFAULT_CUTOFF: f64 = 0.5;

/// Code of the filter of pictures whose texels are to be seen as squares.
const NEAREST: u32 = 9728;

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Transmission {
    transmission_factor: f64,
    transmission_texture: Option<TextureInfo>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Volume {
    thickness_factor: f64,
    /// Share of the light that is left after the distance.
    attenuation_color: [f64; 3],
    /// Without one nothing is lost.
    attenuation_distance: Option<f64>,
}

impl Default for Volume {
    fn default() -> Self {
        Self { thickness_factor: 0.0, attenuation_color: [1.0; 3], attenuation_distance: None }
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct DiffuseTransmission {
    diffuse_transmission_factor: f64,
    diffuse_transmission_texture: Option<TextureInfo>,
    diffuse_transmission_color_factor: Option<[f64; 3]>,
    diffuse_transmission_color_texture: Option<TextureInfo>,
}

#[derive(Debug, Deserialize)]
struct Ior {
    ior: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct EmissiveStrength {
    emissive_strength: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Specular {
    specular_factor: f64,
    specular_color_factor: [f64; 3],
}

impl Default for Specular {
    fn default() -> Self {
        Self { specular_factor: 1.0, specular_color_factor: [1.0; 3] }
    }
}

/// Alpha that the vertices of triangles have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum VertexAlpha {
    /// One alpha for all of them.
    Even(f32),
    /// Alphas that change over them.
    Uneven,
}

impl VertexAlpha {
    /// Alpha of vertices that state none.
    pub const OPAQUE: Self = Self::Even(1.0);
}

/// What the vertices of triangles add to their material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OfVertices {
    pub alpha: VertexAlpha,
    /// Factor of the colour of a material that is unlit, linear RGB.
    pub tint: Vec3,
}

/// Returns true if alpha has a meaning for a material.
pub fn takes_alpha(document: &Document, material: Option<usize>) -> Result<bool, SceneError> {
    let Some(material) = material else { return Ok(false) };
    let json = document.get(&document.json.materials, material, "material")?;
    Ok(matches!(json.alpha_mode.as_deref(), Some("BLEND" | "MASK")))
}

/// Returns true if a material is nowhere there: its alpha is below what cuts it out, whatever a texture or vertices take off.
pub fn is_absent(document: &Document, material: Option<usize>) -> Result<bool, SceneError> {
    let Some(material) = material else { return Ok(false) };
    let json = document.get(&document.json.materials, material, "material")?;
    let [.., alpha] = json.pbr_metallic_roughness.base_color_factor;
    let is_masked = json.alpha_mode.as_deref() == Some("MASK");
    Ok(is_masked && alpha < json.alpha_cutoff.unwrap_or(DEFAULT_CUTOFF))
}

/// Numbers of the texture coordinates that a material's textures take.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct UvSets {
    /// Those of the base colour, or of the first other texture.
    pub first: u32,
    /// Those of the first texture that takes others.
    pub second: Option<u32>,
}

/// Texture coordinates of a material; none: of faces without one.
pub fn uv_sets(document: &Document, material: Option<usize>) -> Result<UvSets, SceneError> {
    let Some(material) = material else { return Ok(UvSets::default()) };
    uv_sets_of(document, document.get(&document.json.materials, material, "material")?)
}

fn uv_sets_of(document: &Document, material: &Json) -> Result<UvSets, SceneError> {
    let pbr = &material.pbr_metallic_roughness;
    let glow = if material.emissive_factor == [0.0; 3] { &None } else { &material.emissive_texture };
    let transmission: Transmission =
        extension(document, &material.extensions, "KHR_materials_transmission")?.unwrap_or_default();
    let all = [
        &pbr.base_color_texture,
        &pbr.metallic_roughness_texture,
        &material.normal_texture,
        glow,
        &transmission.transmission_texture,
    ];
    let sets = all.into_iter().flatten().map(|info| set_of_texture(document, info));
    let sets = sets.collect::<Result<Vec<u32>, SceneError>>()?;
    let first = sets.first().copied().unwrap_or(0);
    Ok(UvSets { first, second: sets.into_iter().find(|set| *set != first) })
}

/// Number of the texture coordinates that a texture takes.
fn set_of_texture(document: &Document, info: &TextureInfo) -> Result<u32, SceneError> {
    Ok(transform(document, info)?.tex_coord.unwrap_or(info.tex_coord))
}

fn transform(document: &Document, info: &TextureInfo) -> Result<TextureTransform, SceneError> {
    Ok(extension(document, &info.extensions, "KHR_texture_transform")?.unwrap_or_default())
}

impl Reading<'_> {
    /// Settles a material of a glTF file, on triangles of such vertices; none: that of faces without one. Returns its index.
    ///
    /// # Errors Values that make no sense; in a strict load also a picture that is missing.
    pub fn settle(&mut self, number: Option<usize>, vertices: OfVertices) -> Result<u16, SceneError> {
        let Some(number) = number else {
            return self.import.surfaces.add_of(&self.document.path, Material::fallback().into());
        };
        let json = self.document.get(&self.document.json.materials, number, "material")?;
        let json = &*self.as_metal_rough(json)?;
        let name = json.name.clone().unwrap_or_else(|| format!("material {number}"));
        self.import.surfaces.known_names.push(name.clone());
        let surface = match self.import.surface_of_table(&name)? {
            Some(surface) => surface,
            None => self.surface(name, json, vertices)?,
        };
        let surface = self.import.lay_tables_over(surface)?;
        let settled = self.import.settle(surface);
        self.import.surfaces.add_of(&self.document.path, settled)
    }

    /// The surface of a material.
    fn surface(
        &mut self,
        name: String,
        json: &Json,
        OfVertices { alpha, tint }: OfVertices,
    ) -> Result<Surface, SceneError> {
        note_unused(self.document, json);
        let pbr = &json.pbr_metallic_roughness;
        let numbers = [&pbr.base_color_factor[..], &json.emissive_factor].concat();
        if !numbers.iter().all(|number| *number >= 0.0 && number.is_finite()) {
            let message =
                format!("material `{name}` has a colour that is negative or not finite: export it again");
            return Err(self.document.fault(message));
        }
        let [red, green, blue, _] = pbr.base_color_factor;
        let factor = DVec3::new(red, green, blue);
        if shows_itself(json) {
            // what it shows, whatever light there is
            let mut surface = Surface::matt(name, Vec3::ZERO);
            surface.set_emission(color(factor) * tint);
            self.set_alpha(json, alpha, &mut surface);
            self.show_own(json, &mut surface)?;
            return Ok(surface);
        }
        let mut surface = Surface::matt(name, color(factor));
        surface.set_emission(color(emission(self.document, json)?));
        let [roughness, metallic] =
            [pbr.roughness_factor, pbr.metallic_factor].map(|factor| factor.clamp(0.0, 1.0));
        surface.set_layer(index(self.document, json)? as f32, roughness as f32, metallic as f32);
        let specular: Specular =
            extension(self.document, &json.extensions, "KHR_materials_specular")?.unwrap_or_default();
        surface[Parameter::SpecularWeight] = (specular.specular_factor as f32).into();
        surface[Parameter::SpecularColor] = color(specular.specular_color_factor.into()).into();
        // its colour tints what is no metal alone
        surface.beyond.metal_edge = Some(1.0);
        let through = self.through(json, metallic)?;
        if through > 0.0 {
            self.make_glass(json, through, &mut surface)?;
        } else {
            self.set_alpha(json, alpha, &mut surface);
            self.set_upper(json, &mut surface)?;
            surface.beyond.translucency = self.translucency(json)?;
        }
        self.show_own(json, &mut surface)?;
        surface.left_out().into_iter().for_each(|said| self.document.leave_out(said));
        Ok(surface)
    }

    /// Has the texture of its transmission give the share of a surface that is glass.
    fn show_transmission(&mut self, json: &Json, surface: &mut Surface) -> Result<(), SceneError> {
        let sets = uv_sets_of(self.document, json)?;
        let read: Transmission =
            extension(self.document, &json.extensions, "KHR_materials_transmission")?.unwrap_or_default();
        let Some(info) = read.transmission_texture else { return Ok(()) };
        if let Some(uvs) = uvs_of(self.document, &info, sets)? {
            let map = self.texture(&info, uvs, PictureUse::Parameter)?;
            if !self.import.pictures.is_stand_in(map) {
                surface.show(Parameter::TransmissionWeight, map, Shown::Channel(0));
            }
        }
        Ok(())
    }

    /// Share of the light that a material with this factor of metal lets through, where it is not metal; 0 if it is metal all over.
    fn through(&mut self, json: &Json, metallic: f64) -> Result<f64, SceneError> {
        let transmission: Transmission =
            extension(self.document, &json.extensions, "KHR_materials_transmission")?.unwrap_or_default();
        let transmits = transmission.transmission_factor.clamp(0.0, 1.0);
        if transmits == 0.0 {
            return Ok(0.0);
        }
        let texture = &json.pbr_metallic_roughness.metallic_roughness_texture;
        let means = texture.as_ref().map(|info| self.mean_numbers(info)).transpose()?;
        let through = transmits * (1.0 - metallic * means.map_or(1.0, |means| means.z));
        Ok(if through > 0.0 { transmits } else { 0.0 })
    }

    /// Makes a surface transmit the share `through`, tinted by its base colour and the texture of that. Without a thickness it is a pane; how
    /// thick it is, its mesh says.
    fn make_glass(&mut self, json: &Json, through: f64, surface: &mut Surface) -> Result<(), SceneError> {
        let volume: Volume =
            extension(self.document, &json.extensions, "KHR_materials_volume")?.unwrap_or_default();
        surface.beyond.glass_tint = surface[Parameter::BaseColor];
        surface.beyond.is_glass_pictured = true;
        surface[Parameter::TransmissionWeight] = (through as f32).into();
        let is_thin = volume.thickness_factor <= 0.0;
        surface[Parameter::GeometryThinWalled] = if is_thin { Value::ONE } else { Value::ZERO };
        let distance = volume.attenuation_distance.filter(|distance| *distance as f32 > 0.0);
        if let Some(distance) = distance {
            surface[Parameter::TransmissionDepth] = (distance as f32).into();
            surface[Parameter::TransmissionColor] = color(volume.attenuation_color.into()).into();
        }
        note_coat_of_glass(self.document, json)
    }

    /// Gives a surface its own pictures, where no table replaces them.
    fn show_own(&mut self, json: &Json, surface: &mut Surface) -> Result<(), SceneError> {
        let sets = uv_sets_of(self.document, json)?;
        let pbr = &json.pbr_metallic_roughness;
        let is_lit = !shows_itself(json);
        let has_alpha = surface.alpha.is_some();
        if let Some(info) = pbr.base_color_texture.as_ref().filter(|_| is_lit || has_alpha) {
            let map = self.texture(info, UvSet::First, PictureUse::Color)?;
            surface.base_picture = is_lit.then_some(map);
            surface.alpha = surface.alpha.map(|alpha| PlaceAlpha { map: Some(map), ..alpha });
        }
        let replaces = |reading: &Self, used, name: &str| reading.import.surfaces.replaces(name, used);
        if let Some(info) = &json.normal_texture
            && !replaces(self, MapUse::Normal, &surface.name)
            && !replaces(self, MapUse::Bump, &surface.name)
            && let Some(uvs) = uvs_of(self.document, info, sets)?
        {
            let map = self.texture(info, uvs, PictureUse::Normals)?;
            surface.normals = Some((map, info.scale.unwrap_or(1.0) as f32));
        }
        let of_layer = pbr.metallic_roughness_texture.as_ref().filter(|_| is_lit);
        let is_glass = surface[Parameter::TransmissionWeight] != Value::ZERO;
        let of_metal = match of_layer {
            // glass is the same all over where its texture knows no metal
            Some(info) if is_glass && self.mean_numbers(info)?.z == 0.0 => {
                surface[Parameter::BaseMetalness] = Value::ZERO;
                None
            }
            texture => texture,
        };
        if is_glass {
            self.show_transmission(json, surface)?;
        }
        let shown = if is_lit { &json.emissive_texture } else { &pbr.base_color_texture };
        let of_emission = shown.as_ref().filter(|_| surface[Parameter::EmissionColor] != Value::ZERO);
        for (used, info, parameter, shown) in [
            (MapUse::Metal, of_metal, Parameter::BaseMetalness, Shown::Channel(2)),
            (MapUse::Roughness, of_layer, Parameter::SpecularRoughness, Shown::Channel(1)),
            (MapUse::Emission, of_emission, Parameter::EmissionColor, Shown::Color),
        ] {
            let Some(info) = info.filter(|_| !replaces(self, used, &surface.name)) else { continue };
            if let Some(uvs) = uvs_of(self.document, info, sets)? {
                let map = self.texture(info, uvs, used.of_picture())?;
                if !self.import.pictures.is_stand_in(map) {
                    surface.show(parameter, map, shown);
                }
            }
        }
        Ok(())
    }

    /// Sets how far a surface is there at all, on triangles whose vertices have this alpha.
    fn set_alpha(&self, json: &Json, alpha: VertexAlpha, surface: &mut Surface) {
        let pbr = &json.pbr_metallic_roughness;
        let [.., of_factor] = pbr.base_color_factor;
        let by = |by_vertices, meaning| Some(PlaceAlpha { map: None, by_vertices, meaning });
        match json.alpha_mode.as_deref() {
            Some("BLEND") => {
                let of_vertices = if let VertexAlpha::Even(alpha) = alpha { alpha } else { 1.0 };
                let solid = of_factor.clamp(0.0, 1.0) as f32 * of_vertices;
                surface[Parameter::GeometryOpacity] = solid.into();
                // what is there in part emits in part
                surface.set_emission(surface[Parameter::EmissionColor].factor * solid);
                if alpha == VertexAlpha::Uneven {
                    let message = "blended alpha of vertices (COLOR_0) that changes over a surface cuts out what is less than half there: veils are as clear as their factor says";
                    self.document.leave_out(message);
                    surface.alpha = by(true, Alpha::Cut(LEAST_OPACITY));
                } else if pbr.base_color_texture.is_some() {
                    surface.alpha = by(false, Alpha::Blend);
                }
            }
            // the alpha of the texture and that of vertices count times the factor's
            Some("MASK") => {
                let factor = of_factor.max(f64::MIN_POSITIVE);
                let least = json.alpha_cutoff.unwrap_or(DEFAULT_CUTOFF) / factor;
                if least > 0.0 {
                    surface.alpha = by(alpha != VertexAlpha::OPAQUE, Alpha::Cut(least as f32));
                }
            }
            _ => {}
        }
    }

    /// Share of the diffuse light that leaves on the other side.
    fn translucency(&self, json: &Json) -> Result<Option<f32>, SceneError> {
        let read: Option<DiffuseTransmission> =
            extension(self.document, &json.extensions, "KHR_materials_diffuse_transmission")?;
        let Some(read) = read.filter(|read| read.diffuse_transmission_factor > 0.0) else { return Ok(None) };
        if read.diffuse_transmission_texture.is_some() {
            self.document.leave_out(
                "textures of diffuse transmission are not used: the factor counts all over a material",
            );
        }
        if read.diffuse_transmission_color_factor.is_some()
            || read.diffuse_transmission_color_texture.is_some()
        {
            self.document.leave_out(
                "colours of diffuse transmission are not used: what comes through has the base colour",
            );
        }
        Ok(Some(read.diffuse_transmission_factor.min(1.0) as f32))
    }

    /// Places a texture, which takes these texture coordinates of the mesh. Returns its index.
    fn texture(&mut self, info: &TextureInfo, uvs: UvSet, used: PictureUse) -> Result<u32, SceneError> {
        let texture = self.document.get(&self.document.json.textures, info.index, "texture")?;
        let (path, decoded) = self.picture_of(info, used)?;
        let TextureTransform { offset, rotation, scale, .. } = transform(self.document, info)?;
        let (wrap, is_nearest) = match texture.sampler {
            Some(sampler) => {
                let sampler = self.document.get(&self.document.json.samplers, sampler, "sampler")?;
                ([sampler.wrap_s, sampler.wrap_t].map(wrap_of), sampler.mag_filter == Some(NEAREST))
            }
            None => ([Wrap::Repeat; 2], false),
        };
        let mapping = Mapping { uvs, is_nearest, ..mapping(scale, rotation, offset, wrap) };
        if !mapping.linear.is_finite() || !mapping.offset.is_finite() {
            return Err(self
                .document
                .fault("the offset, scale or rotation of a texture is not finite: export the file again"));
        }
        let image = self.import.pictures.image_for(&path, &decoded, used, None)?;
        Ok(self.import.pictures.place(Texture { path, image, mapping }))
    }
}

/// Texture coordinates of a mesh that a texture takes. `None` if the mesh does not keep them, which is told.
fn uvs_of(document: &Document, info: &TextureInfo, sets: UvSets) -> Result<Option<UvSet>, SceneError> {
    let set = set_of_texture(document, info)?;
    if set == sets.first {
        return Ok(Some(UvSet::First));
    }
    if sets.second == Some(set) {
        return Ok(Some(UvSet::Second));
    }
    document.leave_out(
        "a material takes two sets of texture coordinates: textures with a third one are not used",
    );
    Ok(None)
}

/// Returns true if a material shows its base colour whatever light there is.
pub fn is_unlit(document: &Document, material: Option<usize>) -> bool {
    material.and_then(|number| document.json.materials.get(number)).is_some_and(shows_itself)
}

fn shows_itself(json: &Json) -> bool {
    json.extensions.contains_key("KHR_materials_unlit")
}

/// Emission that a material states: its factor, times its strength.
fn emission(document: &Document, json: &Json) -> Result<DVec3, SceneError> {
    let strength: Option<EmissiveStrength> =
        extension(document, &json.extensions, "KHR_materials_emissive_strength")?;
    let strength = strength.and_then(|read| read.emissive_strength).unwrap_or(1.0).max(0.0);
    Ok(DVec3::from(json.emissive_factor) * strength)
}

/// Mapping of KHR_texture_transform: scaled, then turned by `rotation` radians, as seen, then moved. Coordinates count from the top
/// of pictures there, and from the bottom here.
///
/// The formula of the extension's page turns the other way than its own example and the model that is made to test it.
fn mapping(scale: [f64; 2], rotation: f64, offset: [f64; 2], wrap: [Wrap; 2]) -> Mapping {
    let (sin, cos) = rotation.sin_cos();
    let ([across, down], [right, below]) = (scale, offset);
    let linear =
        DMat2::from_cols(DVec2::new(cos * across, sin * across), DVec2::new(-sin * down, cos * down));
    let offset = DVec2::new(right + sin * down, 1.0 - below - cos * down);
    Mapping { linear: linear.as_mat2(), offset: offset.as_vec2(), wrap, ..Mapping::default() }
}

/// Wrapping of a sampler's code.
fn wrap_of(code: Option<u32>) -> Wrap {
    match code {
        Some(33071) => Wrap::Clamp,
        Some(33648) => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}

/// Index of refraction.
fn index(document: &Document, json: &Json) -> Result<f64, SceneError> {
    let ior: Option<Ior> = extension(document, &json.extensions, "KHR_materials_ior")?;
    Ok(ior.and_then(|read| read.ior).filter(|index| *index >= 1.0).unwrap_or(DEFAULT_INDEX))
}

fn color(color: DVec3) -> Vec3 {
    color.as_vec3().clamp(Vec3::ZERO, Vec3::splat(LARGEST_COLOR))
}

fn note_unused(document: &Document, json: &Json) {
    if json.occlusion_texture.is_some() {
        document.leave_out("occlusion maps (occlusionTexture) are not used: occlusion is computed");
    }
}

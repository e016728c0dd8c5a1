//! Materials of glTF files, as the renderer has them.

use glam::{DMat2, DVec2, DVec3, Vec3};
use serde::Deserialize;

use super::document::{Document, extension};
use super::json::{Material as Json, TextureInfo, TextureTransform};
use super::reading::Reading;
use super::upper::note_coat_of_glass;
use crate::scene::cutout::{Cutout, LEAST_OPACITY};
use crate::scene::import::pictures::PictureUse;
use crate::scene::import::statements::Statements;
use crate::scene::import::statements::interior::StatedInterior;
use crate::scene::import::statements::maps::{Channel, MapUse};
use crate::scene::import::surfaces::dielectric::{index_of, stated_index};
use crate::scene::import::surfaces::settle::Alpha;
use crate::scene::import::surfaces::varying::{Settled, computed_by, picture_use};
use crate::scene::keys::material::AlphaMode;
use crate::scene::material::{LARGEST_COLOR, head_on};
use crate::scene::texture::{Mapping, UvSet, Wrap};
use crate::scene::{Material, SceneError, Texture};

/// Index of refraction of a file that states none.
const DEFAULT_INDEX: f64 = 1.5;

/// Alpha below which a material with cut-outs is not there, if the file does not say.
const DEFAULT_CUTOFF: f64 = 0.5;

/// Code of the filter of pictures whose texels are to be seen as squares.
const NEAREST: u32 = 9728;

/// Parameters that a texture of metal and roughness gives.
const METAL_ROUGH: [(MapUse, Channel); 2] = [METAL, ROUGHNESS];
const METAL: (MapUse, Channel) = (MapUse::Metal, Channel::Blue);
const ROUGHNESS: (MapUse, Channel) = (MapUse::Roughness, Channel::Green);

/// A material of a file: the values that MTL files state as well, and the rest.
#[derive(Debug, Default)]
struct Read {
    stated: Statements,
    /// Meaning of alpha, if it has one: of the texture, times that of vertices if these count.
    alpha: Option<Alpha>,
    /// True if the alpha of vertices counts there.
    by_vertices: bool,
    /// True if the texture of the base colour stays a texture.
    is_textured: bool,
    /// Parameters that its texture of metal and roughness gives.
    of_texture: &'static [(MapUse, Channel)],
}

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
    let all = [&pbr.base_color_texture, &pbr.metallic_roughness_texture, &material.normal_texture, glow];
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
        let Read { mut stated, alpha: of_file, by_vertices, is_textured, of_texture } =
            self.read_material(number, json, vertices)?;
        self.import.surfaces.known_names.push(stated.name.clone());
        let overridden = self.import.override_values(&mut stated)?;
        let shot = &overridden.places;
        let of_file = of_file.filter(|_| !overridden.is_whole);
        let mut material = stated.settle();
        let base = &json.pbr_metallic_roughness.base_color_texture;
        let base = base.as_ref().filter(|_| is_textured && !overridden.is_whole || of_file.is_some());
        let of_base = |info| self.texture(info, UvSet::First, PictureUse::Color);
        let own = base.map(of_base).transpose()?;
        material.diffuse_map = match (&shot[MapUse::Color], &stated.maps[MapUse::Color]) {
            (Some(shot), Some(map)) => Some(self.import.picture(map, shot, PictureUse::Color)?),
            _ => own.filter(|_| is_textured),
        };
        let graphs = overridden.apply(&mut material);
        // what the file states by itself is no statement of MTL
        let asking = |used| shot[used].as_deref().unwrap_or(&self.document.path);
        let mut settled = self.import.settle_maps(&stated, asking, Settled { material, graphs })?;
        let alpha = match (stated.alpha_mode, of_file) {
            (Some(AlphaMode::Cut), Some(Alpha::Cut(least))) => Some(Alpha::Cut(least)),
            (Some(_), _) => Some(Alpha::of(stated.alpha_mode)),
            (None, of_file) => of_file,
        };
        match (&shot[MapUse::Opacity], &stated.maps[MapUse::Opacity], own, alpha) {
            (Some(shot), Some(map), ..) => {
                let map = self.import.picture(map, shot, PictureUse::Opacity)?;
                self.import.show_stated_alpha(&mut settled, map, stated.alpha_mode);
            }
            (.., map, Some(Alpha::Cut(least))) if by_vertices => {
                settled.material.cutout = Some(Cutout { by_vertices, map, ..Cutout::below(least) });
            }
            (.., Some(map), Some(alpha)) => self.import.show_alpha(&mut settled, map, alpha),
            _ => {}
        }
        if !overridden.is_whole {
            self.add_own_maps(json, of_texture, &mut settled)?;
        }
        self.import.surfaces.add_of(&self.document.path, settled)
    }

    /// Adds the textures of normals and parameters that the shot file does not replace.
    fn add_own_maps(
        &mut self,
        json: &Json,
        of_texture: &[(MapUse, Channel)],
        settled: &mut Settled,
    ) -> Result<(), SceneError> {
        let sets = uv_sets_of(self.document, json)?;
        let Settled { material, graphs } = settled;
        if let Some(info) = json.normal_texture.as_ref().filter(|_| material.normal_map.is_none())
            && let Some(uvs) = uvs_of(self.document, info, sets)?
        {
            let index = self.texture(info, uvs, PictureUse::Normals)?;
            material.normal_map = self.import.pictures.normal_map(index, info.scale.unwrap_or(1.0) as f32);
        }
        let surface = json.pbr_metallic_roughness.metallic_roughness_texture.as_ref();
        let surface = surface.filter(|_| material.metal_rough.is_some());
        let shown = if shows_itself(json) {
            &json.pbr_metallic_roughness.base_color_texture
        } else {
            &json.emissive_texture
        };
        let emission = shown.as_ref().filter(|_| material.emission != Vec3::ZERO);
        let of_surface = of_texture.iter().map(|(used, channel)| (*used, surface, *channel));
        for (used, info, channel) in of_surface.chain([(MapUse::Emission, emission, Channel::Mean)]) {
            let is_shown = computed_by(used).is_some_and(|of| graphs.has(of));
            let is_replaced = is_shown || self.import.surfaces.is_number_stated(&material.name, used);
            let Some(info) = info.filter(|_| !is_replaced) else { continue };
            if let Some(uvs) = uvs_of(self.document, info, sets)? {
                let map = self.texture(info, uvs, picture_use(used))?;
                if !self.import.pictures.is_stand_in(map) {
                    graphs.show(used, map, channel);
                }
            }
        }
        Ok(())
    }

    fn read_material(
        &mut self,
        number: usize,
        json: &Json,
        OfVertices { alpha, tint }: OfVertices,
    ) -> Result<Read, SceneError> {
        note_unused(self.document, json);
        let name = json.name.clone().unwrap_or_else(|| format!("material {number}"));
        let bad = |what: &str| {
            let message =
                format!("material `{name}` has {what} that is negative or not finite: export it again");
            self.document.fault(message)
        };
        let pbr = &json.pbr_metallic_roughness;
        let numbers = [&pbr.base_color_factor[..], &json.emissive_factor].concat();
        if !numbers.iter().all(|number| *number >= 0.0 && number.is_finite()) {
            return Err(bad("a colour"));
        }
        let [red, green, blue, _] = pbr.base_color_factor;
        let factor = DVec3::new(red, green, blue);
        let [roughness, metallic] =
            [pbr.roughness_factor, pbr.metallic_factor].map(|factor| factor.clamp(0.0, 1.0));
        let emission = emission(self.document, json)?;
        let mut stated =
            Statements { name: name.clone(), ke: Some(color(emission)), ..Statements::default() };
        if shows_itself(json) {
            // what it shows, whatever light there is
            stated.ke = Some(color(factor) * tint);
            (stated.kd, stated.illum) = (Some(Vec3::ZERO), Some(0));
            let mut read = Read { stated, ..Read::default() };
            read_alpha(self.document, json, alpha, &mut read);
            return Ok(read);
        }
        stated.kd = Some(color(factor));
        (stated.pr, stated.pm) = (Some(roughness as f32), Some(metallic as f32));
        let index = index(self.document, json)?;
        stated.ni = Some(index as f32);
        let mut read = Read { stated, is_textured: true, of_texture: &METAL_ROUGH, ..Read::default() };
        let transmission: Transmission =
            extension(self.document, &json.extensions, "KHR_materials_transmission")?.unwrap_or_default();
        let transmits = transmission.transmission_factor.clamp(0.0, 1.0);
        if transmits == 0.0 {
            return self.read_opaque(json, alpha, read);
        }
        // glass lets as much through all over
        let surface = pbr.metallic_roughness_texture.as_ref().map(|info| self.mean_numbers(info));
        let through = transmits * (1.0 - metallic * surface.transpose()?.map_or(1.0, |means| means.z));
        if through == 0.0 {
            return self.read_opaque(json, alpha, read);
        }
        if transmission.transmission_texture.is_some() {
            self.document
                .leave_out("textures of transmission are not used: the factor counts all over a material");
        }
        let base = factor * self.mean_color(pbr.base_color_texture.as_ref())?;
        make_glass(self.document, json, &mut read.stated, (base, through, roughness))?;
        note_coat_of_glass(self.document, json)?;
        (read.is_textured, read.of_texture) = (through < 1.0, &[ROUGHNESS]);
        Ok(read)
    }

    /// Completes a material that transmits nothing: what is above it, what comes through it all the same, and how far it is there at all.
    fn read_opaque(&mut self, json: &Json, alpha: VertexAlpha, mut read: Read) -> Result<Read, SceneError> {
        read_alpha(self.document, json, alpha, &mut read);
        read.stated.coat = self.coat(json)?;
        read.stated.fuzz = self.fuzz(json)?;
        if let Some((anisotropy, roughness)) = self.anisotropy(json, read.stated.pr.unwrap_or(1.0).into())? {
            (read.stated.anisotropy, read.stated.pr) = (anisotropy, Some(roughness as f32));
        }
        read.stated.interior.translucency = self.translucency(json)?;
        Ok(read)
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

    fn mean_color(&mut self, info: Option<&TextureInfo>) -> Result<DVec3, SceneError> {
        info.map_or(Ok(DVec3::ONE), |info| self.mean(info))
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

/// Reads how far a material is there at all, on triangles whose vertices have this alpha.
fn read_alpha(document: &Document, json: &Json, alpha: VertexAlpha, read: &mut Read) {
    let pbr = &json.pbr_metallic_roughness;
    match json.alpha_mode.as_deref() {
        Some("BLEND") => {
            let of_vertices = if let VertexAlpha::Even(alpha) = alpha { alpha } else { 1.0 };
            let solid = pbr.base_color_factor[3].clamp(0.0, 1.0) as f32 * of_vertices;
            read.stated.d = Some(solid);
            // what is there in part emits in part
            read.stated.ke = read.stated.ke.map(|emission| emission * solid);
            if alpha == VertexAlpha::Uneven {
                let message = "blended alpha of vertices (COLOR_0) that changes over a surface cuts out what is less than half there: veils are as clear as their factor says";
                document.leave_out(message);
                (read.alpha, read.by_vertices) = (Some(Alpha::Cut(LEAST_OPACITY)), true);
            } else if pbr.base_color_texture.is_some() {
                read.alpha = Some(Alpha::Blend);
            }
        }
        // the alpha of the texture and that of vertices count times the factor's
        Some("MASK") => {
            let factor = pbr.base_color_factor[3].max(f64::MIN_POSITIVE);
            let least = json.alpha_cutoff.unwrap_or(DEFAULT_CUTOFF) / factor;
            read.alpha = (least > 0.0).then_some(Alpha::Cut(least as f32));
            read.by_vertices = least > 0.0 && alpha != VertexAlpha::OPAQUE;
        }
        _ => {}
    }
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

impl Volume {
    /// The inside of the glass. Without a thickness it is a pane; how thick it is, its mesh says.
    fn interior(&self) -> StatedInterior {
        StatedInterior {
            depth: self.attenuation_distance.map(|distance| distance as f32),
            depth_color: Some(color(self.attenuation_color.into())),
            is_thin: Some(self.thickness_factor <= 0.0),
            ..StatedInterior::default()
        }
    }
}

/// Makes a material transmit the share `through`, tinted by `base`.
fn make_glass(
    document: &Document,
    json: &Json,
    stated: &mut Statements,
    (base, through, roughness): (DVec3, f64, f64),
) -> Result<(), SceneError> {
    let volume: Volume = extension(document, &json.extensions, "KHR_materials_volume")?.unwrap_or_default();
    (stated.kd, stated.pr) = (Some(color(base)), Some(roughness as f32));
    *stated = std::mem::take(stated).with_transmission(through, DVec3::ONE);
    stated.interior = volume.interior();
    Ok(())
}

/// Index of refraction, with what KHR_materials_specular does to the reflectance.
fn index(document: &Document, json: &Json) -> Result<f64, SceneError> {
    let ior: Option<Ior> = extension(document, &json.extensions, "KHR_materials_ior")?;
    let index = ior.and_then(|read| read.ior).filter(|index| *index >= 1.0).unwrap_or(DEFAULT_INDEX);
    let specular: Option<Specular> = extension(document, &json.extensions, "KHR_materials_specular")?;
    let Some(Specular { specular_factor, specular_color_factor }) = specular else {
        return Ok(stated_index(index));
    };
    let mean = specular_color_factor.iter().sum::<f64>() / 3.0;
    Ok(index_of(head_on(index) * specular_factor * mean))
}

fn color(color: DVec3) -> Vec3 {
    color.as_vec3().clamp(Vec3::ZERO, Vec3::splat(LARGEST_COLOR))
}

fn note_unused(document: &Document, json: &Json) {
    if json.occlusion_texture.is_some() {
        document.leave_out("occlusion maps (occlusionTexture) are not used: occlusion is computed");
    }
}

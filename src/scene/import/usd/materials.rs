//! Materials of USD files, as the renderer has them.

use std::path::PathBuf;

use glam::{DVec3, Vec3};

use super::file::{self, Input, Picture};
use super::reading::Reading;
use super::tiles::Tiles;
use crate::graph::Graph;
use crate::graph::nodes::picture::{self, Shown};
use crate::memory::{self, Need, Part};
use crate::scene::import::mtl::statements::maps::MapUse;
use crate::scene::import::pictures::decoded::{ColorSpace, Decoded};
use crate::scene::import::pictures::{Content, PictureUse, Wanted};
use crate::scene::material::{Along, LARGEST_COLOR, index_of};
use crate::scene::surface::{Alpha, Displaced, Parameter, PlaceAlpha, Surface};
use crate::scene::{Material, SceneError, Texture, texture};

/// Reflectance at normal incidence above which a surface of the specular workflow is a metal: no plastic or gem reflects as much.
const LEAST_METAL: f64 = 0.25;

impl Reading<'_> {
    /// Settles a surface of a file; none: that of faces without one. Returns its index.
    ///
    /// # Errors In a strict load: a picture that is missing.
    pub(super) fn material(&mut self, surface: Option<usize>) -> Result<u16, SceneError> {
        let Some(surface) = surface.and_then(|number| self.file.content.surfaces.get(number)) else {
            return self.import.surfaces.add_of(&self.file.path, Material::fallback().into());
        };
        let name = &surface.name;
        self.import.surfaces.known_names.push(name.clone());
        let of_table = self.import.surface_of_table(name)?;
        let network = of_table.map_or_else(|| self.network(surface), |of_table| Ok(Some(of_table)))?;
        let mut own = match network {
            Some(network) => network,
            None => self.preview(surface)?,
        };
        own.name.clone_from(name);
        let laid = self.import.lay_tables_over(own)?;
        let settled = self.import.settle(laid);
        self.import.surfaces.add_of(&self.file.path, settled)
    }

    /// The surface of a UsdPreviewSurface.
    fn preview(&mut self, of: &file::Surface) -> Result<Surface, SceneError> {
        let mut surface = self.of_numbers(of)?;
        surface.is_tinted = of.is_tinted;
        if let Input::Picture(picture) = &of.diffuse {
            surface.base_picture = Some(self.texture(picture)?);
        }
        surface.alpha = self.alpha(of, surface.base_picture)?;
        let is_replaced = |reading: &Self, used| reading.import.surfaces.replaces(&of.name, used);
        let bends = !is_replaced(self, MapUse::Normal) && !is_replaced(self, MapUse::Bump);
        if let Some(picture) = of.normal.as_ref().filter(|_| bends) {
            let map = self.place(picture, PictureUse::Normals)?;
            surface.normals = match slope_of(picture) {
                Some(slope) => Some((map, slope)),
                None if self.import.pictures.is_stand_in(map) => None,
                None => Some((self.normals(picture)?, 1.0)),
            };
        }
        surface.displaced = self.displacement(&mut surface.graph, &of.displacement)?;
        for (used, input, is_there, parameter) in [
            (MapUse::Roughness, &of.roughness, true, Parameter::SpecularRoughness),
            (MapUse::Metal, &of.metallic, of.specular.is_none(), Parameter::BaseMetalness),
            (MapUse::Emission, &of.emissive, true, Parameter::EmissionColor),
        ] {
            let is_own = is_there && !is_replaced(self, used);
            let Some(picture) = picture_of_parameter(input, used).filter(|_| is_own) else { continue };
            let map = self.place(picture, used.of_picture())?;
            let shown = match (used, picture.channel.unwrap_or(0)) {
                (MapUse::Emission, _) => Shown::Color,
                (_, channel @ 0..3) => Shown::Channel(channel),
                _ => Shown::Alpha,
            };
            if !self.import.pictures.is_stand_in(map) {
                surface.show(parameter, map, shown);
            }
        }
        Ok(surface)
    }

    /// What moves the vertices of a UsdPreviewSurface.
    fn displacement(&mut self, graph: &mut Graph, of: &Input) -> Result<Option<Displaced>, SceneError> {
        let (by, scale, middle) = match of {
            Input::Constant(length) if length.x == 0.0 => return Ok(None),
            Input::Constant(length) => (crate::graph::Input::Constant(length.as_vec3()), 1.0, 0.0),
            Input::Picture(picture) => {
                let map = self.place(picture, PictureUse::Parameter)?;
                let channel = picture.channel.unwrap_or(0);
                let (scale, bias) = (picture.scale[channel], picture.bias[channel]);
                if self.import.pictures.is_stand_in(map) || scale == 0.0 {
                    return Ok(None);
                }
                let shown = if channel < 3 { Shown::Channel(channel) } else { Shown::Alpha };
                (picture::add(graph, map, shown, None), scale, -bias / scale)
            }
        };
        Ok(Some(Displaced { by, scale: scale as f32, middle: middle as f32, along: Along::Normal }))
    }

    /// The surface of a UsdPreviewSurface without its pictures.
    fn of_numbers(&mut self, of: &file::Surface) -> Result<Surface, SceneError> {
        let mut base = match &of.diffuse {
            Input::Constant(color) => *color,
            // the picture is multiplied by it
            Input::Picture(picture) => {
                if picture.bias[..3] != [0.0; 3] {
                    self.unused.push("what is added to textures (bias) is not used for colours");
                }
                DVec3::from_slice(&picture.scale)
            }
        };
        let emissive = self.factor(&of.emissive, MapUse::Emission)?;
        let roughness = self.factor(&of.roughness, MapUse::Roughness)?.x.clamp(0.0, 1.0);
        let mut metallic = self.factor(&of.metallic, MapUse::Metal)?.x.clamp(0.0, 1.0);
        let mut index = of.ior;
        if let Some(specular) = of.specular {
            metallic = 0.0;
            if specular.max_element() > LEAST_METAL {
                self.unused.push(
                    "surfaces that reflect colours (useSpecularWorkflow) are shown as metal of that colour",
                );
                (metallic, base) = (1.0, specular);
            } else {
                index = index_of(specular.element_sum() / 3.0);
            }
        }
        let opacity =
            match &of.opacity {
                Input::Constant(opacity) if of.opacity_threshold > 0.0 => {
                    if opacity.x < of.opacity_threshold { 0.0 } else { 1.0 }
                }
                Input::Constant(opacity) => opacity.x.clamp(0.0, 1.0),
                // the factor of a picture that is blended
                Input::Picture(picture) if of.opacity_threshold == 0.0 => {
                    let channel = picture.channel.unwrap_or(0);
                    (picture.scale[channel] + picture.bias[channel]).clamp(0.0, 1.0)
                }
                Input::Picture(_) => 1.0,
            };
        let mut surface = Surface::matt(of.name.clone(), color(base));
        surface.set_layer(index as f32, roughness as f32, metallic as f32);
        surface.set_emission(color(emissive));
        surface[Parameter::GeometryOpacity] = (opacity as f32).into();
        let [weight, roughness] = of.coat.map(|number| number as f32);
        surface[Parameter::CoatWeight] = weight.into();
        surface[Parameter::CoatRoughness] = roughness.into();
        Ok(surface)
    }

    /// Value of an input: of a picture the factor by which it is multiplied, or its mean if it is more than multiplied.
    fn factor(&mut self, input: &Input, used: MapUse) -> Result<DVec3, SceneError> {
        let picture = match input {
            Input::Constant(value) => return Ok(*value),
            Input::Picture(picture) => picture,
        };
        if picture_of_parameter(input, used).is_some() {
            return Ok(match picture.channel {
                Some(channel) => DVec3::splat(picture.scale[channel]),
                None => DVec3::from_slice(&picture.scale),
            });
        }
        self.unused.push(
            "of pictures of roughness, metal and emission to which numbers are added (bias), or of raw colours, the mean counts",
        );
        let decoded = self.decoded(picture, PictureUse::Parameter)?;
        let is_number = picture.is_raw || picture.channel.is_some();
        let means = decoded.means(|channel, byte| match is_number || channel == 3 {
            true => f64::from(byte) / 255.0,
            false => f64::from(texture::linear(byte)),
        });
        let value =
            |channel: usize| (means[channel] * picture.scale[channel] + picture.bias[channel]).max(0.0);
        Ok(match picture.channel {
            Some(channel) => DVec3::splat(value(channel)),
            None => DVec3::new(value(0), value(1), value(2)),
        })
    }

    /// Texture of a surface's opacity, and what its alpha means. `color`: the texture of its colour.
    fn alpha(
        &mut self,
        surface: &file::Surface,
        color: Option<u32>,
    ) -> Result<Option<PlaceAlpha>, SceneError> {
        let Input::Picture(picture) = &surface.opacity else { return Ok(None) };
        let channel = picture.channel.unwrap_or(0);
        let meaning = if surface.opacity_threshold > 0.0 {
            // the threshold counts for what the texture makes of its numbers
            let scale = picture.scale[channel].max(f64::MIN_POSITIVE);
            let least = ((surface.opacity_threshold - picture.bias[channel]) / scale) as f32;
            if least <= 0.0 {
                return Ok(None);
            }
            Alpha::Cut(least.min(1.0))
        } else {
            Alpha::Blend
        };
        let of_color = match &surface.diffuse {
            Input::Picture(own) if channel == 3 && own.path == picture.path => color,
            _ => None,
        };
        let map = match of_color {
            Some(map) => map,
            None => self.opacity_texture(picture, channel)?,
        };
        Ok(Some(PlaceAlpha { map: Some(map), by_vertices: false, meaning }))
    }

    /// Texture of the normals that a picture's scale and bias make of its numbers. Returns its index.
    fn normals(&mut self, picture: &Picture) -> Result<u32, SceneError> {
        let decoded = self.decoded(picture, PictureUse::Normals)?;
        let finest = decoded.image.finest();
        let byte = |texel: [u8; 4], channel: usize| {
            let number = f64::from(texel[channel]) / 255.0 * picture.scale[channel] + picture.bias[channel];
            (127.5 * (number.clamp(-1.0, 1.0) + 1.0)).round() as u8
        };
        let texels = (0..finest.texels.count()).map(|texel| finest.texels.get(texel).bytes());
        let texels = texels.map(|texel| [byte(texel, 0), byte(texel, 1), byte(texel, 2), texel[3]]).collect();
        let image = Decoded::of_bytes(decoded.size(), texels).as_numbers();
        let mut path = picture.path.clone().into_os_string();
        path.push(format!("#normals {:?} {:?}", picture.scale, picture.bias));
        Ok(self.import.pictures.place(Texture { path: PathBuf::from(path), image, mapping: picture.mapping }))
    }

    /// A picture of all tiles, beside and above each other, each as large as the largest one.
    fn all_tiles(
        &mut self,
        (picture, tiles): (&Picture, &Tiles),
        used: PictureUse,
    ) -> Result<Decoded, SceneError> {
        let mut read = Vec::with_capacity(tiles.files.len());
        for (place, path) in &tiles.files {
            let tile = Picture { path: path.clone(), tiles: None, ..picture.clone() };
            read.push((*place, self.decoded(&tile, used)?));
        }
        let edge = |axis: usize| read.iter().map(|(_, tile)| tile.size()[axis]).max().unwrap_or(1);
        let of_tile = [edge(0), edge(1)];
        let size = [0, 1].map(|axis| u64::from(of_tile[axis]) * u64::from(tiles.size[axis]));
        let fault =
            |why: String| self.file.fault(format!("the tiles of `{}` are too large: {why}", picture.name));
        let need =
            Need::new(Part::new("a texture of tiles", 8 * size[0] * size[1], "smaller tiles, fewer tiles"));
        need.check(&memory::left()).map_err(|error| fault(error.to_string()))?;
        let [Ok(width), Ok(height)] = size.map(u32::try_from) else {
            return Err(fault(String::from("use fewer or smaller ones")));
        };
        let mut texels = vec![[0, 0, 0, u8::MAX]; (size[0] * size[1]) as usize];
        for ([column, row], tile) in &read {
            let (finest, [across, down]) = (tile.image.finest(), tile.size());
            // rows of tiles are from the bottom, and those of pictures from the top
            let (left, top) = (column * of_tile[0], (tiles.size[1] - 1 - row) * of_tile[1]);
            for y in 0..of_tile[1] {
                let from = u64::from(y) * u64::from(down) / u64::from(of_tile[1]);
                let line = (u64::from(top + y) * u64::from(width) + u64::from(left)) as usize;
                for x in 0..of_tile[0] {
                    let texel =
                        from * u64::from(across) + u64::from(x) * u64::from(across) / u64::from(of_tile[0]);
                    texels[line + x as usize] = finest.texels.get(texel as usize).bytes();
                }
            }
        }
        Ok(Decoded::of_bytes([width, height], texels.into()))
    }

    /// Texture whose alpha is a channel of a picture. Returns its index.
    fn opacity_texture(&mut self, picture: &Picture, channel: usize) -> Result<u32, SceneError> {
        let decoded = self.decoded(picture, PictureUse::Parameter)?;
        let (finest, size) = (decoded.image.finest(), decoded.size());
        let texels = (0..finest.texels.count()).map(|texel| finest.texels.get(texel).bytes());
        let texels = texels.map(|texel| [texel[0], texel[1], texel[2], texel[channel]]).collect();
        let mut path = picture.path.clone().into_os_string();
        path.push(format!("#channel {channel}"));
        let texture = Texture::of_bytes(PathBuf::from(path), size, texels, picture.mapping);
        Ok(self.import.pictures.place(texture))
    }

    /// The texture of a colour. Returns its index.
    fn texture(&mut self, picture: &Picture) -> Result<u32, SceneError> {
        if picture.channel.is_some() {
            self.unused.push(
                "colours are those of a picture's red, green and blue, also where one channel is named",
            );
        }
        self.place(picture, PictureUse::Color)
    }

    /// Places a picture. Returns its index.
    pub(super) fn place(&mut self, picture: &Picture, used: PictureUse) -> Result<u32, SceneError> {
        let decoded = self.decoded(picture, used)?;
        let path = picture.path.clone();
        let space = picture.is_raw.then_some(ColorSpace::Linear);
        let image = self.import.pictures.image_for(&path, &decoded, used, space)?;
        Ok(self.import.pictures.place(Texture { path, image, mapping: picture.mapping }))
    }

    fn decoded(&mut self, picture: &Picture, used: PictureUse) -> Result<Decoded, SceneError> {
        if let Some(tiles) = &picture.tiles {
            if let Some(known) = self.import.pictures.known(&picture.path) {
                return Ok(known);
            }
            let all = self.all_tiles((picture, tiles), used)?;
            return Ok(self.import.pictures.keep(picture.path.clone(), all));
        }
        let content = match &picture.packed {
            Some(bytes) => Content::Bytes(bytes),
            None => Content::File(picture.path.is_file().then_some(picture.path.as_path())),
        };
        let wanted = Wanted {
            path: picture.path.clone(),
            content,
            name: &picture.name,
            asking: &self.file.path,
            line: None,
            used,
        };
        self.import.pictures.decoded(wanted, &mut self.import.findings)
    }
}

/// Picture that gives a parameter, if it is one and is multiplied by a number alone.
fn picture_of_parameter(input: &Input, used: MapUse) -> Option<&Picture> {
    let Input::Picture(picture) = input else { return None };
    let is_color = used == MapUse::Emission;
    let fits = picture.channel.is_none() == is_color && !(is_color && picture.is_raw);
    (fits && picture.bias == [0.0; 4]).then_some(picture)
}

/// Factor on the slopes of a normal map, if they are those of its picture. Its bytes are to be spread from -1 to 1, by a scale of 2 and a
/// bias of -1 (UsdPreviewSurface, "normal"); files that say nothing mean the same.
fn slope_of(picture: &Picture) -> Option<f32> {
    let ([across, up, out, _], bias) = (picture.scale, &picture.bias[..3]);
    let is_even = across == up && across > 0.0 && out > 0.0;
    let is_centred = bias.iter().all(|bias| *bias == 0.0)
        || bias.iter().zip(&picture.scale).all(|(bias, scale)| (2.0 * bias + scale).abs() < 1e-6);
    (is_even && is_centred).then(|| (across / out) as f32)
}

fn color(color: DVec3) -> Vec3 {
    color.as_vec3().clamp(Vec3::ZERO, Vec3::splat(LARGEST_COLOR))
}

//! Networks of shaders: UsdPreviewSurface, and the pictures that lead to it.

use std::collections::{BTreeSet, HashMap};
use std::path::PathBuf;
use std::sync::Arc;

use glam::{DAffine2, DVec2, DVec3};
use openusd::sdf::{Path, Value};
use openusd::usd::{Prim, Stage};

use super::file::{Input, Picture, Surface};
use super::resolver::{self, Checked};
use super::tiles::{self, Tiles};
use super::value::{Answer, codes, is_name, number, numbers, said, value, word};
use crate::scene::texture::{Mapping, UvSet, Wrap};

/// Most steps from an input to the shader that computes it: nothing honest is as deep, and what is connected to itself has no end.
const MOST_STEPS: usize = 32;

/// Reads materials of a stage, each picture once.
pub struct Shaders<'a> {
    stage: &'a Stage,
    /// Time code at which values are read.
    pub(super) code: f64,
    packed: HashMap<String, Arc<Vec<u8>>>,
    /// Values of primvars, by path and name, for what is below.
    of_parents: HashMap<(String, &'static str), Vec<f64>>,
    pub unused: BTreeSet<String>,
    /// Pictures that are nowhere, in whole sentences.
    pub missing: BTreeSet<String>,
}

/// Names of a material's sets of texture coordinates: that of its colour, or else of its first picture, and another one.
pub type UvNames = [Option<String>; 2];

/// Colour of a transparent mesh that states none.
const GREY: f64 = 0.6;

/// Name of texture coordinates that are not named.
const USUAL_UVS: &str = "st";

/// Colour of a UsdPreviewSurface that states none.
const USUAL_COLOR: DVec3 = DVec3::splat(0.18);

/// A material, and the names of its texture coordinates.
#[derive(Debug, Clone)]
pub struct ReadSurface {
    pub surface: Surface,
    pub uvs: UvNames,
    /// True if what it is bound to has its own displayColor, where it has one, in place of the surface's colour.
    pub takes_display_color: bool,
}

/// A surface that is bound to something.
#[derive(Debug, Clone)]
pub struct BoundSurface {
    /// Number among all surfaces.
    pub number: usize,
    /// Names of its texture coordinates.
    pub uvs: UvNames,
    /// See [`ReadSurface::takes_display_color`].
    pub takes_display_color: bool,
}

/// Path by which a picture is known, its name as written, and its bytes if it is packed.
pub type PictureFile = (PathBuf, String, Option<Arc<Vec<u8>>>);

/// Other end of a connection.
pub(super) struct Source {
    pub prim: Prim,
    /// Name of its output, or of an input of an interface.
    pub output: String,
}

impl Source {
    /// Returns true if a node computes it.
    pub fn is_output(&self) -> bool {
        self.output.starts_with("outputs:")
    }
}

impl<'a> Shaders<'a> {
    /// Prepares to read at a time code.
    pub fn new(stage: &'a Stage, code: f64) -> Self {
        Self {
            stage,
            code,
            packed: HashMap::new(),
            of_parents: HashMap::new(),
            unused: BTreeSet::new(),
            missing: BTreeSet::new(),
        }
    }

    /// Reads the material at `path`. `None` if it has no surface that is known here.
    ///
    /// # Errors What the library says.
    pub fn material(&mut self, path: &Path) -> Answer<Option<ReadSurface>> {
        let material = self.stage.prim(path.clone());
        let network = self.network(&material)?;
        let preview = self.preview(&material, path)?;
        let Some((network, uvs)) = network else { return Ok(preview) };
        let takes_display_color = false;
        let name = path.name().unwrap_or("material");
        let is_network_alone = preview.is_none();
        let below = preview.map_or_else(|| plain(name, DVec3::splat(GREY)), |preview| preview.surface);
        let surface = Surface { network: Some(Arc::new(network)), is_network_alone, ..below };
        Ok(Some(ReadSurface { surface, uvs, takes_display_color }))
    }

    /// Reads the UsdPreviewSurface of a material, if it has one.
    fn preview(&mut self, material: &Prim, path: &Path) -> Answer<Option<ReadSurface>> {
        let Some(source) = self.source(material, "outputs:surface")? else { return Ok(None) };
        if word(&source.prim, "info:id", self.code)?.as_deref() != Some("UsdPreviewSurface") {
            return Ok(None);
        }
        let prim = source.prim;
        let mut uvs = UvNames::default();
        let mut input = |shaders: &mut Self, name: &str, default: DVec3| {
            let (mut input, own) = shaders.input(&prim, name, default)?;
            if let Input::Picture(picture) = &mut input {
                // cut-outs take the first set, as colours do
                let may_differ = name != "inputs:opacity";
                picture.mapping.uvs = shaders.set_of(&mut uvs, own, may_differ);
            }
            Ok::<Input, String>(input)
        };
        let beside_display_color = self.beside_display_color(&prim)?;
        let takes_display_color = beside_display_color.is_some();
        let diffuse = match beside_display_color {
            Some(color) => Input::Constant(color),
            None => input(self, "inputs:diffuseColor", USUAL_COLOR)?,
        };
        let opacity = input(self, "inputs:opacity", DVec3::ONE)?;
        let normal = match input(self, "inputs:normal", DVec3::Z)? {
            Input::Picture(picture) => Some(picture),
            Input::Constant(_) => None,
        };
        let emissive = input(self, "inputs:emissiveColor", DVec3::ZERO)?;
        let roughness = input(self, "inputs:roughness", DVec3::splat(0.5))?;
        let metallic = input(self, "inputs:metallic", DVec3::ZERO)?;
        let workflow = number(&prim, "inputs:useSpecularWorkflow", self.code)?.unwrap_or(0.0);
        let specular = match workflow == 1.0 {
            true => Some(input(self, "inputs:specularColor", DVec3::ZERO)?),
            false => None,
        };
        let specular = match specular {
            Some(Input::Constant(color)) => Some(color),
            Some(Input::Picture(_)) => {
                self.leave_out("textures of specularColor are not used: surfaces reflect as plastic does");
                None
            }
            None => None,
        };
        let displacement = match self.source(material, "outputs:displacement")?.is_some() {
            true => input(self, "inputs:displacement", DVec3::ZERO)?,
            false => Input::number(0.0),
        };
        self.note_unused(&prim)?;
        let coat = self.coat(&prim)?;
        let name = path.name().unwrap_or("material").to_string();
        let ior = number(&prim, "inputs:ior", self.code)?.unwrap_or(1.5);
        let threshold = number(&prim, "inputs:opacityThreshold", self.code)?.unwrap_or(0.0);
        let opacity_threshold = threshold.clamp(0.0, 1.0);
        let surface = Surface {
            name,
            diffuse,
            is_tinted: false,
            emissive,
            roughness,
            metallic,
            opacity,
            opacity_threshold,
            ior,
            specular,
            coat,
            normal,
            displacement,
            network: None,
            is_network_alone: false,
        };
        Ok(Some(ReadSurface { surface, uvs, takes_display_color }))
    }

    /// Value of a surface's colour where the displayColor of what has the surface is read for it: that of what has none. `None` if something
    /// else gives the colour.
    fn beside_display_color(&mut self, surface: &Prim) -> Answer<Option<DVec3>> {
        let name = "inputs:diffuseColor";
        if !said(surface.attribute(name).has_authored_connections())? {
            return Ok(None);
        }
        let Some(Source { prim: reader, .. }) = self.source(surface, name)? else { return Ok(None) };
        let is_reader = matches!(
            word(&reader, "info:id", self.code)?.as_deref(),
            Some("UsdPrimvarReader_float3" | "UsdPrimvarReader_vector")
        );
        if !is_reader || self.word_behind(&reader, "inputs:varname")?.as_deref() != Some("displayColor") {
            return Ok(None);
        }
        let color = |prim: &Prim, name: &str| -> Answer<Option<DVec3>> {
            let numbers = value(prim, name, self.code)?.as_ref().and_then(numbers);
            let color = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok()).map(DVec3::from);
            Ok(color.filter(|color| color.is_finite()))
        };
        let stated = match color(&reader, "inputs:fallback")? {
            Some(fallback) => Some(fallback),
            None => color(surface, name)?,
        };
        Ok(Some(stated.unwrap_or(USUAL_COLOR)))
    }

    /// Finds the set of texture coordinates called `own`, among those of a material, or adds it.
    pub(super) fn set_of(&mut self, names: &mut UvNames, own: Option<String>, may_differ: bool) -> UvSet {
        let own = own.unwrap_or_else(|| String::from(USUAL_UVS));
        let [first, second] = names;
        if *first.get_or_insert_with(|| own.clone()) == own {
            return UvSet::First;
        }
        if may_differ && *second.get_or_insert_with(|| own.clone()) == own {
            return UvSet::Second;
        }
        self.leave_out(
            "a material takes two sets of texture coordinates, and one for colour and opacity: other textures have those of the colour",
        );
        UvSet::First
    }

    /// Weight and roughness of the clear coat of a surface.
    fn coat(&mut self, prim: &Prim) -> Answer<[f64; 2]> {
        for name in ["inputs:clearcoat", "inputs:clearcoatRoughness"] {
            if said(prim.attribute(name).has_authored_connections())? {
                self.leave_out("textures of clearcoats are not used: a coat is the same all over, and as its numbers say");
            }
        }
        let share = number(prim, "inputs:clearcoat", self.code)?.unwrap_or(0.0);
        let roughness = number(prim, "inputs:clearcoatRoughness", self.code)?.unwrap_or(0.01);
        Ok([share, roughness])
    }

    /// Records that something has no effect.
    pub fn leave_out(&mut self, message: impl Into<String>) {
        self.unused.insert(message.into());
    }

    fn note_unused(&mut self, prim: &Prim) -> Answer<()> {
        if said(prim.attribute("inputs:occlusion").has_authored_connections())? {
            self.leave_out("occlusion maps are not used: occlusion is computed");
        }
        for name in ["diffuseColor", "emissiveColor", "roughness", "metallic", "opacity"] {
            if codes(prim, &format!("inputs:{name}"))?.len() > 1 {
                self.leave_out("materials do not change with time: they are as at the first frame");
            }
        }
        Ok(())
    }

    /// Follows a connection to the shader at its end, through node graphs and interfaces of materials.
    pub(super) fn source(&self, prim: &Prim, name: &str) -> Answer<Option<Source>> {
        let (mut at, mut name) = (prim.clone(), name.to_string());
        for _ in 0..MOST_STEPS {
            if !is_name(&name) {
                return Ok(None);
            }
            let connections = said(at.attribute(name.as_str()).connections())?;
            let Some(target) = connections.into_iter().next() else {
                return Ok((name != "outputs:surface").then_some(Source { prim: at, output: name }));
            };
            at = self.stage.prim(target.prim_path());
            name = target.as_str().rsplit_once('.').map_or(String::new(), |(_, name)| name.to_string());
            if name.starts_with("outputs:") && word(&at, "info:id", self.code)?.is_some() {
                return Ok(Some(Source { prim: at, output: name }));
            }
        }
        Ok(None)
    }

    /// Value of an input, and the name of the texture coordinates that it takes.
    fn input(&mut self, prim: &Prim, name: &str, default: DVec3) -> Answer<(Input, Option<String>)> {
        let constant = |prim: &Prim, name: &str| -> Answer<Option<DVec3>> {
            let numbers = value(prim, name, self.code)?.as_ref().and_then(numbers).unwrap_or_default();
            let finite = numbers.iter().all(|number| number.is_finite());
            Ok(match numbers[..] {
                [one] if finite => Some(DVec3::splat(one)),
                [x, y, z, ..] if finite => Some(DVec3::new(x, y, z)),
                _ => None,
            })
        };
        if !said(prim.attribute(name).has_authored_connections())? {
            return Ok((Input::Constant(constant(prim, name)?.unwrap_or(default)), None));
        }
        let Some(source) = self.source(prim, name)? else { return Ok((Input::Constant(default), None)) };
        if !source.output.starts_with("outputs:") {
            // an interface that states the value
            return Ok((Input::Constant(constant(&source.prim, &source.output)?.unwrap_or(default)), None));
        }
        let stated = constant(prim, name)?.unwrap_or(default);
        match word(&source.prim, "info:id", self.code)?.as_deref() {
            Some("UsdUVTexture") => self.picture(&source, stated),
            Some(id) => {
                let id: String = id.chars().take(80).collect();
                self.leave_out(format!(
                    "shaders `{id}` are not used: inputs have the values that they state themselves"
                ));
                Ok((Input::Constant(stated), None))
            }
            None => Ok((Input::Constant(stated), None)),
        }
    }

    /// Reads a UsdUVTexture.
    fn picture(&mut self, source: &Source, default: DVec3) -> Answer<(Input, Option<String>)> {
        let Source { prim, output } = source;
        let channel = match output.as_str() {
            "outputs:r" => Some(0),
            "outputs:g" => Some(1),
            "outputs:b" => Some(2),
            "outputs:a" => Some(3),
            _ => None,
        };
        let code = self.code;
        let four = |name: &str| -> Answer<Option<[f64; 4]>> {
            let numbers = value(prim, name, code)?.as_ref().and_then(numbers);
            let four = numbers.and_then(|numbers| <[f64; 4]>::try_from(numbers).ok());
            Ok(four.filter(|four| four.iter().all(|number| number.is_finite())))
        };
        let fallback = four("inputs:fallback")?.map(|four| match channel {
            Some(channel) => DVec3::splat(four[channel]),
            None => DVec3::from_slice(&four),
        });
        let Some((path, name, packed)) = self.file(prim)? else {
            return Ok((Input::Constant(fallback.unwrap_or(default)), None));
        };
        let tiles = if packed.is_none() { Tiles::find(&path) } else { None };
        let is_there = tiles.is_some() || packed.as_ref().map_or(path.is_file(), |bytes| !bytes.is_empty());
        if let (false, Some(fallback)) = (is_there, fallback) {
            self.missing.insert(format!(
                "the texture `{name}` cannot be found: the value that the file states for it (fallback) is shown; copy it to where it is named"
            ));
            return Ok((Input::Constant(fallback), None));
        }
        let scale = four("inputs:scale")?.unwrap_or([1.0; 4]);
        let bias = four("inputs:bias")?.unwrap_or([0.0; 4]);
        let wraps = [word(prim, "inputs:wrapS", self.code)?, word(prim, "inputs:wrapT", self.code)?];
        if wraps.iter().flatten().any(|wrap| wrap == "black") {
            self.leave_out("textures whose wrapping is black are clamped");
        }
        let wrap = wraps.map(|wrap| match wrap.as_deref() {
            Some("clamp" | "black") => Wrap::Clamp,
            Some("mirror") => Wrap::Mirror,
            _ => Wrap::Repeat,
        });
        let is_raw = word(prim, "inputs:sourceColorSpace", self.code)?.as_deref() == Some("raw");
        let (uvs, place) = self.coordinates(prim)?;
        let (linear, offset) = (place.matrix2.as_mat2(), place.translation.as_vec2());
        let mapping = Mapping { linear, offset, wrap, ..Mapping::default() };
        let mapping = tiles.as_ref().map_or(mapping, |tiles| tiles.mapping(mapping));
        let picture = Picture { path, name, packed, channel, scale, bias, is_raw, mapping, tiles };
        Ok((Input::Picture(picture), uvs))
    }

    /// Texture coordinates of a UsdUVTexture: their name, and the map to places of the picture.
    fn coordinates(&mut self, texture: &Prim) -> Answer<(Option<String>, DAffine2)> {
        let mut map = DAffine2::IDENTITY;
        let mut at = self.source(texture, "inputs:st")?;
        for _ in 0..MOST_STEPS {
            let Some(Source { prim, .. }) = &at else { break };
            match word(prim, "info:id", self.code)?.as_deref() {
                Some("UsdTransform2d") => {
                    let two = |name: &str, default: DVec2| -> Answer<DVec2> {
                        let numbers = value(prim, name, self.code)?.as_ref().and_then(numbers);
                        let two =
                            numbers.and_then(|numbers| <[f64; 2]>::try_from(numbers).ok()).map(DVec2::from);
                        Ok(two.filter(|two| two.is_finite()).unwrap_or(default))
                    };
                    let (own_scale, own_offset) =
                        (two("inputs:scale", DVec2::ONE)?, two("inputs:translation", DVec2::ZERO)?);
                    let degrees = number(prim, "inputs:rotation", self.code)?.unwrap_or(0.0);
                    map *=
                        DAffine2::from_scale_angle_translation(DVec2::ONE, degrees.to_radians(), own_offset)
                            * DAffine2::from_scale(own_scale);
                    at = self.source(prim, "inputs:in")?;
                }
                _ => {
                    return Ok((self.word_behind(prim, "inputs:varname")?, map));
                }
            }
        }
        Ok((None, map))
    }

    /// Text of an input, or of the interface that it is connected to.
    pub(super) fn word_behind(&self, prim: &Prim, name: &str) -> Answer<Option<String>> {
        match self.source(prim, name)? {
            Some(source) => word(&source.prim, &source.output, self.code),
            None => word(prim, name, self.code),
        }
    }

    /// Path of the file that is read.
    pub(super) fn root(&self) -> String {
        self.stage.root_layer().identifier().to_string()
    }

    /// Picture of a texture, or of a light.
    pub fn file(&mut self, prim: &Prim) -> Answer<Option<PictureFile>> {
        let asset = match value(prim, "inputs:file", self.code)? {
            Some(value) => Some(value),
            None => value(prim, "inputs:texture:file", self.code)?,
        };
        self.file_of(asset)
    }

    /// Picture that a value names.
    pub(super) fn file_of(&mut self, asset: Option<Value>) -> Answer<Option<PictureFile>> {
        let asset = match asset {
            Some(Value::AssetPath(asset)) => Some(asset),
            // samples of one file, see `text`
            Some(Value::AssetPathVec(list)) => list.into_iter().next(),
            _ => None,
        };
        let Some(asset) = asset else { return Ok(None) };
        if asset.is_empty() {
            return Ok(None);
        }
        let name: String = asset.asset_path().chars().take(200).collect();
        let Some(resolved) = asset.resolved_path() else {
            return Ok(Some((self.beside_the_file(&name), name, None)));
        };
        let path = PathBuf::from(resolved);
        if !resolved.ends_with(']') {
            return Ok(Some((path, name, None)));
        }
        if let Some(known) = self.packed.get(resolved) {
            return Ok(Some((path, name, Some(known.clone()))));
        }
        // what cannot be read is empty, which decoding reports
        let bytes = Arc::new(Checked::bytes(resolved).unwrap_or_default());
        self.packed.insert(resolved.to_string(), bytes.clone());
        Ok(Some((path, name, Some(bytes))))
    }

    /// Path of a picture that the library does not find under its name: in tiles, or with backslashes, as programs on Windows write
    /// them.
    fn beside_the_file(&self, name: &str) -> PathBuf {
        let path = name.replace('\\', "/");
        let is_there = |path: &PathBuf| match tiles::are_named(name) {
            true => Tiles::find(path).is_some(),
            false => path.is_file(),
        };
        resolver::beside_layers(self.stage, &path, is_there).unwrap_or_else(|| PathBuf::from(name))
    }

    /// Values of a primvar of a prim, or those of the nearest prim above that has some for all that is below it, and whether they are
    /// its own.
    fn inherited(&mut self, prim: &Prim, name: &'static str) -> Answer<(Vec<f64>, bool)> {
        if let Some(own) = value(prim, name, self.code)? {
            return Ok((numbers(&own).unwrap_or_default(), true));
        }
        match prim.path().parent() {
            Some(parent) => Ok((self.above(&parent, name)?, false)),
            None => Ok((Vec::new(), false)),
        }
    }

    /// Values of a primvar at a path or above it that are constant: others are not inherited.
    fn above(&mut self, path: &Path, name: &'static str) -> Answer<Vec<f64>> {
        let (mut passed, mut at, mut found) = (Vec::new(), Some(path.clone()), Vec::new());
        while let Some(path) = at.filter(|path| path.as_str() != "/") {
            let key = (path.to_string(), name);
            if let Some(known) = self.of_parents.get(&key) {
                found.clone_from(known);
                break;
            }
            passed.push(key);
            let prim = self.stage.prim(path.clone());
            if let Some(own) = value(&prim, name, self.code)? {
                let spread = said(prim.attribute(name).get_metadata::<Value>("interpolation"))?;
                let is_constant = match spread {
                    Some(Value::Token(spread)) => spread.as_str() == "constant",
                    _ => true,
                };
                if is_constant {
                    found = numbers(&own).unwrap_or_default();
                    break;
                }
            }
            at = path.parent();
        }
        self.of_parents.extend(passed.into_iter().map(|key| (key, found.clone())));
        Ok(found)
    }

    /// Surface of a mesh without a material: its displayColor and displayOpacity, or grey.
    pub fn display_color(&mut self, prim: &Prim) -> Answer<Option<Surface>> {
        let (list, is_own) = self.inherited(prim, "primvars:displayColor")?;
        for name in ["primvars:displayColor", "primvars:displayOpacity"] {
            if codes(prim, name)?.len() > 1 {
                self.leave_out(
                    "colours of meshes (displayColor, displayOpacity) do not change with time: they are as at the first frame",
                );
            }
        }
        let (opacities, _) = self.inherited(prim, "primvars:displayOpacity")?;
        let opacity = opacities.first().copied().filter(|opacity| opacity.is_finite()).unwrap_or(1.0);
        if opacities.iter().any(|other| *other != opacity) {
            self.leave_out("displayOpacity does not change over a mesh: its first value is used");
        }
        let list = match list.len() < 3 {
            true if opacity < 1.0 => vec![GREY; 3],
            true => return Ok(None),
            false => list,
        };
        let colors: Vec<DVec3> = list.chunks_exact(3).map(DVec3::from_slice).collect();
        let is_tinted = is_own && colors.windows(2).any(|pair| pair[0] != pair[1]);
        let color = if is_tinted { DVec3::ONE } else { colors[0] };
        if !color.is_finite() {
            return Ok(None);
        }
        let surface = plain("displayColor", color);
        let opacity = Input::number(opacity.clamp(0.0, 1.0));
        Ok(Some(Surface { is_tinted, opacity, roughness: Input::number(0.5), ior: 1.5, ..surface }))
    }
}

/// Surface of a mesh without a material as Blender, which writes no colour for it, draws it.
pub fn plain_of_blender() -> Surface {
    plain("without a material", DVec3::splat(0.8))
}

/// A matt surface of one colour.
fn plain(name: &str, color: DVec3) -> Surface {
    Surface {
        name: String::from(name),
        diffuse: Input::Constant(color),
        is_tinted: false,
        emissive: Input::number(0.0),
        roughness: Input::number(1.0),
        metallic: Input::number(0.0),
        opacity: Input::number(1.0),
        opacity_threshold: 0.0,
        ior: 1.0,
        specular: None,
        coat: [0.0; 2],
        normal: None,
        displacement: Input::number(0.0),
        network: None,
        is_network_alone: false,
    }
}

//! Nodes that show pictures: where they are looked up, what is beyond their edges, and fourth channels.

use glam::{Affine2, Vec2, Vec3};

use super::document::{Element, Stated};
use super::picture_nodes::{HEXAGONS, IMAGES, PictureAsked};
use super::standard;
use super::standard::ALPHA;
use super::walk::{LONGEST_WAY, Target, Value, Walk, kind_of};
use crate::graph::nodes::{hextile, inputs, picture};
use crate::graph::{Input, Kind, Options, UvSet};
use crate::lanes::{F32x8, Vec3x8};
use crate::scene::SceneError;
use crate::scene::import::pictures::PictureUse;
use crate::scene::texture::{Mapping, Wrap};

/// Inputs of nodes that show a picture that are read, or that mean nothing here: pictures do not change.
const OF_PICTURES: [&str; 15] = [
    "in",
    "file",
    "default",
    "texcoord",
    "uaddressmode",
    "vaddressmode",
    "colorspace",
    "layer",
    "filtertype",
    "framerange",
    "frameoffset",
    "frameendaction",
    "normal",
    "tangent",
    "bitangent",
];

/// Those that scale and move pictures, and factors on what they show.
const OF_TILES: [&str; 2] = ["uvtiling", "uvoffset"];
const OF_GLTF: [&str; 5] = ["pivot", "scale", "rotate", "offset", "operationorder"];
const FACTORS: [&str; 3] = ["factor", "color", "geomcolor"];

/// Where a picture is looked up.
struct Coordinates {
    /// Set of texture coordinates.
    uvs: UvSet,
    /// Coordinates that are computed in place of these.
    computed: Option<Input>,
    /// Map from them to the picture.
    map: Affine2,
}

impl<'d> Walk<'d, '_> {
    /// Number of the picture of normals of a node, if it shows one as it is.
    pub fn normals(&mut self, node: &'d Element) -> Result<Option<u32>, SceneError> {
        if !IMAGES.contains(&node.category.as_str()) {
            return Ok(None);
        }
        for stated in &node.inputs {
            self.value(node, stated)?;
        }
        let shown = self.picture_of(node, PictureUse::Normals)?;
        Ok(shown.and_then(|(number, at)| at.is_none().then_some(number)))
    }

    /// A picture's colour, or its alpha; of glTF's pictures times their factors. The node's default without a picture.
    pub(super) fn picture(&mut self, node: &'d Element, output: usize) -> Result<Value, SceneError> {
        if output == ALPHA {
            return Ok((self.alpha_of_picture(node)?, Kind::Number));
        }
        let kind = kind_of(&node.of_type).unwrap_or(Kind::Color);
        let mut value = match self.picture_of(node, PictureUse::Parameter)? {
            Some((number, at)) => picture::add(&mut self.graph, number, picture::Shown::Color, at),
            None => self.input_of(node, "default", Vec3::ZERO)?,
        };
        for name in FACTORS.into_iter().filter(|name| is_read(node, name)) {
            let factor = self.input_of(node, name, Vec3::ONE)?;
            if factor != Input::Constant(Vec3::ONE) {
                value = self.graph.add(standard::function("multiply"), vec![value, factor]);
            }
        }
        if kind == Kind::Number {
            value = self.graph.add(standard::first_channel(), vec![value]);
        }
        Ok((value, kind))
    }

    /// A picture in hexagonal tiles.
    pub(super) fn hexagons(&mut self, node: &'d Element) -> Result<Value, SceneError> {
        let Some((number, at)) = self.picture_of(node, PictureUse::Parameter)? else {
            return Ok((self.input_of(node, "default", Vec3::ZERO)?, Kind::Color));
        };
        let at = at.unwrap_or_else(|| self.uv(UvSet::First));
        let tiling = self.input_of(node, "tiling", Vec3::ONE)?;
        let at = self.graph.add(standard::function("multiply"), vec![at, tiling]);
        let mut taken = hextile::INPUTS.map(|(_, default)| Input::Constant(default));
        for (input, (name, default)) in taken.iter_mut().zip(hextile::INPUTS) {
            *input = self.input_of(node, name, default)?;
        }
        Ok((hextile::add(&mut self.graph, number, at, taken), Kind::Color))
    }

    /// Number of the picture of a node, and where it is looked up; `None` if it has none.
    fn picture_of(
        &mut self,
        node: &'d Element,
        used: PictureUse,
    ) -> Result<Option<(u32, Option<Input>)>, SceneError> {
        let stated = self.document.written(node, "file");
        let named = stated.and_then(|stated| stated.value.as_deref().map(|file| (stated, file)));
        let Some((stated, file)) = named.filter(|(_, file)| !file.is_empty()) else { return Ok(None) };
        self.tell_unread(node, |name| is_read(node, name));
        let Coordinates { uvs, computed, map } = self.coordinates(node)?;
        let is_color = kind_of(&node.of_type) == Some(Kind::Color);
        let is_encoded = is_color && self.is_encoded(node.line, stated.space.as_deref(), true);
        let asked = PictureAsked {
            file: format!("{}{file}", stated.file_prefix),
            plain: String::from(file),
            line: node.line,
            mapping: Mapping {
                linear: map.matrix2,
                offset: map.translation,
                wrap: self.wraps(node),
                uvs,
                is_nearest: self.document.text(node, "filtertype") == Some("closest"),
            },
            used: if is_encoded && used == PictureUse::Parameter { PictureUse::Color } else { used },
            has_stand_in: is_color || used == PictureUse::Normals,
        };
        Ok((self.pictures)(&asked)?.map(|number| (number, computed)))
    }

    /// What is beyond the edges of a node's picture, across and up.
    fn wraps(&mut self, node: &Element) -> [Wrap; 2] {
        let document = self.document;
        ["uaddressmode", "vaddressmode"].map(|name| match document.text(node, name) {
            Some("clamp") => Wrap::Clamp,
            Some("mirror") => Wrap::Mirror,
            Some("constant") => {
                self.tell(
                    node.line,
                    format!("pictures go on beyond their edges where `{name}` is `constant`"),
                );
                Wrap::Clamp
            }
            _ => Wrap::Repeat,
        })
    }

    /// Where the picture of a node is looked up: its texture coordinates, scaled and moved as the node says.
    fn coordinates(&mut self, node: &'d Element) -> Result<Coordinates, SceneError> {
        let at = self.stated_coordinates(node)?;
        match node.category.as_str() {
            "tiledimage" => {
                let tiling = self.input_of(node, "uvtiling", Vec3::ONE)?;
                let offset = self.input_of(node, "uvoffset", Vec3::ZERO)?;
                if let (Input::Constant(tiling), Input::Constant(offset)) = (tiling, offset) {
                    let map =
                        Affine2::from_scale_angle_translation(tiling.truncate(), 0.0, -offset.truncate());
                    return Ok(Coordinates { map: map * at.map, ..at });
                }
                let at = self.computed(&at);
                let scaled = self.graph.add(standard::function("multiply"), vec![at, tiling]);
                Ok(Coordinates::at(self.graph.add(standard::function("subtract"), vec![scaled, offset])))
            }
            "gltf_image" | "gltf_colorimage" | "gltf_normalmap" => {
                let placing = self.placing_of_gltf(node)?;
                if let Some(map) = place2d(&placing) {
                    return Ok(Coordinates { map: map * at.map, ..at });
                }
                let taken = std::iter::once(self.computed(&at)).chain(placing).collect();
                Ok(Coordinates::at(self.graph.add(standard::function("place2d"), taken)))
            }
            HEXAGONS => Ok(Coordinates::at(self.computed(&at))),
            _ => Ok(at),
        }
    }

    /// Texture coordinates that a node states, as long as they are those of the surface, placed by constants; else they are computed.
    fn stated_coordinates(&mut self, node: &'d Element) -> Result<Coordinates, SceneError> {
        let (mut at, mut from) = (Coordinates::own(UvSet::First), node);
        for _ in 0..LONGEST_WAY {
            let Some(stated) = from.input("texcoord") else { return Ok(at) };
            match self.target(from, stated)? {
                Target::Nothing => return Ok(at),
                Target::Node(next, _) if matches!(next.category.as_str(), "texcoord" | "geompropvalue") => {
                    return Ok(Coordinates { uvs: self.set_of(next), ..at });
                }
                Target::Node(next, _) if next.category == "place2d" => {
                    let placing = self.placing(next, &PLACING)?;
                    let Some(map) = place2d(&placing) else { break };
                    (at.map, from) = (at.map * map, next);
                }
                Target::Node(..) | Target::Constant { .. } => break,
            }
        }
        let Some(stated) = from.input("texcoord") else { return Ok(at) };
        let computed = self.known(from, stated)?.map(|(value, _)| value);
        Ok(Coordinates { computed, ..at })
    }

    /// Set of texture coordinates that a `texcoord` gives.
    pub(super) fn set_of(&self, node: &Element) -> UvSet {
        if self.document.text(node, "index") == Some("1") { UvSet::Second } else { UvSet::First }
    }

    /// Coordinates that are computed, whatever they were.
    fn computed(&mut self, at: &Coordinates) -> Input {
        let own = at.computed.unwrap_or_else(|| self.uv(at.uvs));
        if at.map == Affine2::IDENTITY {
            return own;
        }
        let map = at.map;
        let mapped = move |a: &[Vec3x8], _| {
            let [right_x, right_y, up_x, up_y, x, y] = map.to_cols_array();
            Vec3x8 {
                x: a[0].x * right_x + a[0].y * up_x + x,
                y: a[0].x * right_y + a[0].y * up_y + y,
                z: F32x8::ZERO,
            }
        };
        self.graph.add(crate::graph::function(format!("map {map:?}"), mapped), vec![own])
    }

    /// A set of texture coordinates.
    pub(super) fn uv(&mut self, set: UvSet) -> Input {
        let mut options = Options::default();
        options.set("set", if set == UvSet::Second { "1" } else { "0" });
        self.graph.add_defined(&inputs::UV, &options, &[], 0).unwrap_or(Input::Constant(Vec3::ZERO))
    }

    /// What a `place2d` takes beside texture coordinates; `defaults` counts where nothing is stated.
    fn placing(&mut self, node: &'d Element, defaults: &[Vec3; 5]) -> Result<[Input; 5], SceneError> {
        let mut placing = defaults.map(Input::Constant);
        for ((input, name), default) in placing.iter_mut().zip(OF_GLTF).zip(defaults) {
            *input = self.input_of(node, name, *default)?;
        }
        Ok(placing)
    }

    /// What a `place2d` is to take that moves a picture as glTF does: v downwards, from the upper left corner.
    fn placing_of_gltf(&mut self, node: &'d Element) -> Result<[Input; 5], SceneError> {
        let [_, scale, rotate, offset, order] = PLACING;
        let [pivot, scale, rotate, offset, order] =
            self.placing(node, &[Vec3::Y, scale, rotate, offset, Vec3::ONE.max(order)])?;
        let constant = Input::Constant;
        let inverse = self.graph.add(standard::function("divide"), vec![constant(Vec3::ONE), scale]);
        let mut product =
            |value, factor| self.graph.add(standard::function("multiply"), vec![value, constant(factor)]);
        let (rotate, offset) = (product(rotate, Vec3::NEG_ONE), product(offset, Vec3::new(-1.0, 1.0, 0.0)));
        // the specification's own graph of a gltf_colorimage scales first, whatever is stated
        let order = if node.category == "gltf_colorimage" { constant(Vec3::ZERO) } else { order };
        Ok([pivot, inverse, rotate, offset, order])
    }

    /// Value of an input of a node whose inputs are known; `default` where nothing is stated.
    pub(super) fn input_of(
        &mut self,
        node: &Element,
        name: &str,
        default: Vec3,
    ) -> Result<Input, SceneError> {
        let value = node.input(name).map(|stated| self.known(node, stated)).transpose()?.flatten();
        Ok(value.map_or(Input::Constant(default), |(value, _)| value))
    }

    /// The fourth channel that a node takes out of what `stated` leads to, which is told where it is not known: it is 1 then.
    pub(super) fn fourth(&mut self, node: &'d Element, stated: &'d Stated) -> Result<Input, SceneError> {
        let (mut node, mut stated) = (node, stated);
        let constant = |number: f32| Input::Constant(Vec3::splat(number));
        for _ in 0..LONGEST_WAY {
            let from = match self.target(node, stated)? {
                Target::Nothing => break,
                Target::Constant { fourth, .. } => return Ok(constant(fourth.unwrap_or(1.0))),
                Target::Node(from, _) => from,
            };
            let next = match from.category.as_str() {
                category if IMAGES.contains(&category) => return self.alpha_of_picture(from),
                "combine4" => return self.input_of(from, "in4", Vec3::ZERO),
                "combine2" => return self.input_of(from, "in2", Vec3::ZERO),
                "constant" => from.input("value"),
                "convert" => from.input("in"),
                other => {
                    self.tell(from.line, format!("the fourth channel of nodes `{other}` is taken as 1"));
                    break;
                }
            };
            let Some(next) = next else { break };
            (node, stated) = (from, next);
        }
        Ok(constant(1.0))
    }

    /// Channels of a value in another order, as letters say: one for each of the channels that it becomes.
    pub(super) fn swizzled(&mut self, node: &'d Element) -> Result<Option<Value>, SceneError> {
        let Some(stated) = node.input("in") else { return Ok(None) };
        let Some((value, _)) = self.known(node, stated)? else { return Ok(None) };
        let letters = self.document.text(node, "channels").unwrap_or_default();
        let channels: Vec<usize> =
            letters.chars().filter_map(|letter| "xyzwrgba01".find(letter)).take(4).collect();
        if channels.is_empty() || channels.len() != letters.len() {
            self.tell(node.line, format!("`channels` of nodes `swizzle` is `{letters}`: the default counts"));
            return Ok(None);
        }
        let takes_fourth = channels.iter().any(|channel| matches!(channel, 3 | 7));
        let fourth = if takes_fourth { self.fourth(node, stated)? } else { Input::Constant(Vec3::ONE) };
        let of = move |a: &[Vec3x8], channel: usize| match channel {
            8 => F32x8::ZERO,
            9 => F32x8::ONE,
            0 | 4 => a[0].x,
            1 | 5 => a[0].y,
            2 | 6 => a[0].z,
            _ => a[1].x,
        };
        let name = format!("swizzle {letters}");
        let swizzle = crate::graph::function(name, move |a, _| match channels[..] {
            [one] => Vec3x8::all_of(of(a, one)),
            [x, y] => Vec3x8 { x: of(a, x), y: of(a, y), z: F32x8::ZERO },
            [x, y, z, ..] => Vec3x8 { x: of(a, x), y: of(a, y), z: of(a, z) },
            [] => Vec3x8::ZERO,
        });
        let kind = kind_of(&node.of_type).unwrap_or(Kind::Vector);
        Ok(Some((self.graph.add(swizzle, vec![value, fourth]), kind)))
    }

    /// Alpha of a node's picture, with those of its factors; of its default without a picture.
    fn alpha_of_picture(&mut self, node: &'d Element) -> Result<Input, SceneError> {
        let mut alpha = match (self.picture_of(node, PictureUse::Parameter)?, node.input("default")) {
            (Some((number, at)), _) => picture::add(&mut self.graph, number, picture::Shown::Alpha, at),
            (None, Some(default)) => self.fourth(node, default)?,
            (None, None) => Input::Constant(Vec3::ZERO),
        };
        for factor in FACTORS.into_iter().filter(|name| is_read(node, name)) {
            let Some(stated) = node.input(factor) else { continue };
            let factor = self.fourth(node, stated)?;
            alpha = self.graph.add(standard::function("multiply"), vec![alpha, factor]);
        }
        Ok(alpha)
    }
}

impl Coordinates {
    /// Texture coordinates of the surface.
    fn own(uvs: UvSet) -> Self {
        Self { uvs, computed: None, map: Affine2::IDENTITY }
    }

    /// Coordinates that are computed.
    fn at(computed: Input) -> Self {
        Self { computed: Some(computed), ..Self::own(UvSet::First) }
    }
}

/// What a `place2d` takes where nothing is stated: pivot, scale, degrees, offset, and 1 if it moves before it turns and scales.
const PLACING: [Vec3; 5] = [Vec3::ZERO, Vec3::ONE, Vec3::ZERO, Vec3::ZERO, Vec3::ZERO];

/// Map of texture coordinates that a `place2d` makes of these, if they are constants and make sense.
fn place2d(placing: &[Input; 5]) -> Option<Affine2> {
    let constants = placing.map(|input| match input {
        Input::Constant(value) => value,
        Input::Node(_) => Vec3::NAN,
    });
    let [pivot, scale, degrees, offset, order] = constants;
    let [pivot, scale, offset] = [pivot, scale, offset].map(|value| value.truncate());
    let turn = Affine2::from_angle(-degrees.x.to_radians());
    let scale = Affine2::from_scale(Vec2::ONE / scale);
    let moved = |by: Vec2| Affine2::from_translation(by);
    let map = match order.x == 1.0 {
        true => moved(pivot) * scale * turn * moved(-pivot - offset),
        false => moved(pivot - offset) * turn * scale * moved(-pivot),
    };
    (map.is_finite() && !order.x.is_nan()).then_some(map)
}

/// Returns true if a node that shows a picture reads an input of this name.
fn is_read(node: &Element, name: &str) -> bool {
    let of_kind = match node.category.as_str() {
        "tiledimage" => OF_TILES.contains(&name),
        "gltf_image" | "gltf_colorimage" => OF_GLTF.contains(&name) || FACTORS.contains(&name),
        "gltf_normalmap" => OF_GLTF.contains(&name),
        HEXAGONS => name == "tiling" || hextile::INPUTS.iter().any(|(input, _)| *input == name),
        _ => false,
    };
    of_kind || OF_PICTURES.contains(&name)
}

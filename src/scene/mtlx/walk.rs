//! From nodes of a file to those of a graph.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

use super::document::{Document, Element, Stated};
use super::standard;
use crate::graph::nodes::{self, inputs, picture};
use crate::graph::{Definition, Graph, Input, Kind, Options, numbers};
use crate::scene::SceneError;
use crate::scene::model::map_statement::MapStatement;
use crate::scene::model::pictures::PictureUse;
use crate::scene::texture::linear_share;

/// What is left out of a file: the line, and a sentence.
pub(in crate::scene) type Finding = (usize, String);

/// A picture that a node asks for.
#[derive(Debug)]
pub(in crate::scene) struct PictureAsked {
    /// File, and places of texture coordinates on it.
    pub map: MapStatement,
    /// What its values are.
    pub used: PictureUse,
}

/// A value, and its kind.
pub type Value = (Input, Kind);

/// References that lead from one to the next, at most: more are a circle.
const LONGEST_WAY: usize = 64;

/// Kinds of nodes that show a picture.
const IMAGES: [&str; 5] = ["image", "tiledimage", "gltf_image", "gltf_colorimage", "gltf_normalmap"];

/// Inputs of those nodes that are read, or that mean nothing here: pictures are interpolated between texels, and do not change.
const OF_PICTURES: [&str; 18] = [
    "in",
    "file",
    "default",
    "texcoord",
    "uvtiling",
    "uvoffset",
    "uaddressmode",
    "vaddressmode",
    "factor",
    "color",
    "colorspace",
    "layer",
    "filtertype",
    "framerange",
    "frameoffset",
    "frameendaction",
    "normal",
    "tangent",
];

/// Number of the output that is alpha.
const ALPHA: usize = 3;

/// Outputs of nodes that were walked to.
#[derive(Debug, Clone, Copy)]
enum State {
    /// What it depends on is being walked to.
    Begun,
    /// The value; `None` of a node that is not known: what takes it has its default.
    Known(Option<Value>),
}

/// A node and the number of one of its outputs, by their places in the file.
type Key = (*const Element, usize);

/// Walk through the nodes that a surface depends on.
pub struct Walk<'d, 'p> {
    pub document: &'d Document,
    pub graph: Graph,
    pub findings: Vec<Finding>,
    pictures: &'p mut dyn FnMut(&PictureAsked) -> Result<u32, SceneError>,
    states: HashMap<Key, State>,
}

/// What an input leads to.
enum Target<'d> {
    Constant(Value),
    Node(&'d Element, usize),
    /// Nothing is stated.
    Nothing,
}

impl<'d, 'p> Walk<'d, 'p> {
    pub fn new(
        document: &'d Document,
        pictures: &'p mut dyn FnMut(&PictureAsked) -> Result<u32, SceneError>,
    ) -> Self {
        Self { document, graph: Graph::default(), findings: Vec::new(), pictures, states: HashMap::new() }
    }

    /// Tells what is left out, once.
    pub fn tell(&mut self, line: usize, what: String) {
        if !self.findings.iter().any(|(_, told)| *told == what) {
            self.findings.push((line, what));
        }
    }

    /// The value of an input of `element`; `None` where nothing is stated.
    ///
    /// # Errors
    /// Numbers that are none; those of pictures.
    pub fn value(&mut self, element: &Element, stated: &Stated) -> Result<Option<Value>, SceneError> {
        match self.target(element, stated)? {
            Target::Nothing => Ok(None),
            Target::Constant(value) => Ok(Some(value)),
            Target::Node(node, output) => self.node(node, output),
        }
    }

    /// Number of the picture of normals of a node, if it shows one as it is.
    pub fn normals(&mut self, node: &'d Element) -> Result<Option<u32>, SceneError> {
        if !IMAGES.contains(&node.category.as_str()) {
            return Ok(None);
        }
        let shown = self.picture_of(node, PictureUse::Normals)?;
        Ok(shown.and_then(|(number, at)| at.is_none().then_some(number)))
    }

    /// The node that an input of `element` leads to, if it leads to one.
    pub fn node_behind(
        &mut self,
        element: &Element,
        stated: &Stated,
    ) -> Result<Option<&'d Element>, SceneError> {
        Ok(match self.target(element, stated)? {
            Target::Node(node, _) => Some(node),
            Target::Constant(_) | Target::Nothing => None,
        })
    }

    /// The value of an output of a node. What it depends on is walked to without recursion: graphs may be as deep as they like.
    fn node(&mut self, node: &'d Element, output: usize) -> Result<Option<Value>, SceneError> {
        let mut way = vec![(node, output)];
        while let Some((node, output)) = way.last().copied() {
            match self.states.get(&key(node, output)) {
                Some(State::Known(_)) => {
                    way.pop();
                    continue;
                }
                Some(State::Begun) => {
                    let value = self.made(node, output)?;
                    self.states.insert(key(node, output), State::Known(value));
                    way.pop();
                    continue;
                }
                None => {
                    self.states.insert(key(node, output), State::Begun);
                }
            }
            for stated in &node.inputs {
                let Target::Node(next, of_next) = self.target(node, stated)? else { continue };
                match self.states.get(&key(next, of_next)) {
                    Some(State::Begun) => {
                        let what = format!("`{}` depends on itself: there it is its default", next.name);
                        self.tell(next.line, what);
                    }
                    Some(State::Known(_)) => {}
                    None => way.push((next, of_next)),
                }
            }
        }
        match self.states.get(&key(node, output)) {
            Some(State::Known(value)) => Ok(*value),
            _ => Ok(None),
        }
    }

    /// What an input of `element` leads to: through outputs of graphs, and through what graphs take.
    fn target(&mut self, element: &Element, stated: &Stated) -> Result<Target<'d>, SceneError> {
        let document = self.document;
        let (mut graph, mut stated, mut line) = (element.graph.clone(), stated.clone(), element.line);
        for _ in 0..LONGEST_WAY {
            if let Some(name) = &stated.interface {
                let Some(of_graph) = document.element("", &graph).and_then(|graph| graph.input(name)) else {
                    return Ok(Target::Nothing);
                };
                (graph, stated) = (String::new(), of_graph.clone());
            } else if let Some(name) = &stated.graph {
                let Some(output) = document.output(name, stated.output.as_deref()) else {
                    self.tell(line, format!("the graph `{name}` has no such output: the default counts"));
                    return Ok(Target::Nothing);
                };
                (graph, stated, line) = (name.clone(), output.shown.clone(), output.line);
            } else if let Some(name) = &stated.node {
                let Some(node) = document.element(&graph, name) else {
                    self.tell(line, format!("there is no node `{name}`: the default counts"));
                    return Ok(Target::Nothing);
                };
                if node.category == "output" || node.category == "dot" {
                    let next = node.input("in").unwrap_or(&node.shown);
                    (stated, line) = (next.clone(), node.line);
                    continue;
                }
                let output = output_number(node, stated.output.as_deref());
                return Ok(Target::Node(node, output));
            } else if let Some(text) = &stated.value {
                let Some(kind) = kind_of(&stated.of_type) else { return Ok(Target::Nothing) };
                let is_encoded = kind == Kind::Color && self.is_encoded(line, stated.space.as_deref(), false);
                let decoded = |value: Vec3| {
                    if is_encoded { value.map(|share| linear_share(f64::from(share))) } else { value }
                };
                let value = constant(text, kind).map(decoded);
                let fault = |fault: String| {
                    SceneError::new(&document.path, format!("`{}` {fault}", stated.name)).at_line(line)
                };
                return Ok(Target::Constant((Input::Constant(value.map_err(fault)?), kind)));
            } else {
                return Ok(Target::Nothing);
            }
        }
        self.tell(line, format!("`{}` leads in a circle: the default counts", stated.name));
        Ok(Target::Nothing)
    }

    /// Value of an input that was walked to.
    fn known(&mut self, element: &Element, stated: &Stated) -> Result<Option<Value>, SceneError> {
        Ok(match self.target(element, stated)? {
            Target::Nothing => None,
            Target::Constant(value) => Some(value),
            Target::Node(node, output) => match self.states.get(&key(node, output)) {
                Some(State::Known(value)) => *value,
                // it depends on itself, which was told
                _ => None,
            },
        })
    }

    /// The value of an output of a node, whose inputs are known.
    fn made(&mut self, node: &'d Element, output: usize) -> Result<Option<Value>, SceneError> {
        match node.category.as_str() {
            category if IMAGES.contains(&category) => return self.picture(node, output).map(Some),
            "texcoord" => {
                let set = node.input("index").and_then(|index| index.value.clone()).unwrap_or_default();
                let mut options = Options::default();
                options.set("set", if set == "1" { "1" } else { "0" });
                return self.defined(node, &inputs::UV, &options, 0).map(Some);
            }
            "position" => return Ok(Some(self.of_space(node, [&inputs::POINT, &inputs::WORLD_POINT]))),
            "normal" => return Ok(Some(self.of_space(node, [&inputs::NORMAL, &inputs::WORLD_NORMAL]))),
            "geomcolor" => {
                let color = &inputs::VERTEX_COLOR;
                return Ok(Some((self.source(color), color.outputs[0].1)));
            }
            "extract" | "separate2" | "separate3" | "separate4" => {
                if let Some(alpha) = self.alpha(node, output)? {
                    return Ok(Some(alpha));
                }
            }
            _ => {}
        }
        if let Some(function) = standard::named(&node.category) {
            let kind = kind_of(&node.of_type).unwrap_or(Kind::Number);
            let mut taken = Vec::with_capacity(function.inputs.len());
            for input in function.inputs {
                let stated = node.input(input.name).cloned();
                let value = stated.map(|stated| self.known(node, &stated)).transpose()?.flatten();
                taken.push(match (value, input.default) {
                    (Some((value, _)), _) => value,
                    (None, standard::Default::Number(number)) => Input::Constant(Vec3::splat(number)),
                    (None, standard::Default::Color(color)) => Input::Constant(Vec3::from(color)),
                    (None, standard::Default::Uv) => self.source(&inputs::UV),
                    (None, standard::Default::Point) => self.source(&inputs::POINT),
                });
            }
            let is_read = |name: &str| function.inputs.iter().any(|input| input.name == name);
            self.tell_unread(node, is_read);
            if kind != Kind::Number && standard::NOISES.contains(&function.name) {
                let what = format!("nodes `{}` give all channels the same number", function.name);
                self.tell(node.line, what);
            }
            let function = function.of_output(output, node.of_type == "vector2");
            return Ok(Some((self.graph.add(function, taken), kind)));
        }
        match nodes::named(&node.category) {
            Some(definition) => {
                let options = options(definition, node);
                self.defined(node, definition, &options, output).map(Some)
            }
            None => {
                let what = format!("nodes `{}` are not known: the default counts", node.category);
                self.tell(node.line, what);
                Ok(None)
            }
        }
    }

    /// Returns true if colours of a space are encoded as sRGB's, which is so of what `otherwise` says where no space is stated.
    fn is_encoded(&mut self, line: usize, space: Option<&str>, otherwise: bool) -> bool {
        match space.map(str::trim) {
            None | Some("") => otherwise,
            Some(space) if space.starts_with("srgb") => true,
            Some("lin_rec709" | "lin_srgb" | "linear" | "raw" | "none") => false,
            Some(space) => {
                self.tell(line, format!("colours in `{space}` are taken as those of lin_rec709"));
                false
            }
        }
    }

    /// Tells inputs of a node that nothing reads.
    fn tell_unread(&mut self, node: &Element, is_read: impl Fn(&str) -> bool) {
        for stated in node.inputs.iter().filter(|stated| !is_read(&stated.name)) {
            let what = format!("`{}` of nodes `{}` is not used", stated.name, node.category);
            self.tell(node.line, what);
        }
    }

    /// What a surface gives, without options.
    fn source(&mut self, definition: &'static Definition) -> Input {
        let made = self.graph.add_defined(definition, &Options::default(), &[], 0);
        made.unwrap_or(Input::Constant(Vec3::ZERO))
    }

    /// What a surface gives in object space, or in the world if the node says so.
    fn of_space(&mut self, node: &Element, [in_object, in_world]: [&'static Definition; 2]) -> Value {
        let is_world = node.input("space").is_some_and(|space| space.value.as_deref() == Some("world"));
        let definition = if is_world { in_world } else { in_object };
        (self.source(definition), definition.outputs[0].1)
    }

    fn defined(
        &mut self,
        node: &Element,
        definition: &'static Definition,
        options: &Options,
        output: usize,
    ) -> Result<Value, SceneError> {
        let mut taken = Vec::with_capacity(definition.inputs.len());
        for socket in definition.inputs {
            let stated = node.input(socket.name).cloned();
            taken.push(stated.map(|stated| self.known(node, &stated)).transpose()?.flatten());
        }
        let made = self.graph.add_defined(definition, options, &taken, output);
        let value = made.map_err(|fault| self.document.fault(node, format!("`{}`: {fault}", node.name)))?;
        Ok((value, definition.outputs[output.min(definition.outputs.len() - 1)].1))
    }

    /// A picture's colour, or its alpha; of glTF's pictures times their factor.
    fn picture(&mut self, node: &Element, output: usize) -> Result<Value, SceneError> {
        let kind = if output == ALPHA { Kind::Number } else { kind_of(&node.of_type).unwrap_or(Kind::Color) };
        let Some((number, at)) = self.picture_of(node, PictureUse::Parameter)? else {
            let default = node.input("default").cloned();
            let value = default.map(|stated| self.known(node, &stated)).transpose()?.flatten();
            return Ok(value.unwrap_or((Input::Constant(Vec3::ZERO), kind)));
        };
        if output == ALPHA {
            return Ok((picture::add(&mut self.graph, number, picture::Shown::Alpha, at), kind));
        }
        let mut color = picture::add(&mut self.graph, number, picture::Shown::Color, at);
        for name in ["factor", "color"] {
            let factor = node.input(name).cloned();
            if let Some((factor, _)) = factor.map(|stated| self.known(node, &stated)).transpose()?.flatten() {
                color = self.graph.add(standard::product(), vec![color, factor]);
            }
        }
        if kind == Kind::Number {
            color = self.graph.add(standard::first_channel(), vec![color]);
        }
        Ok((color, kind))
    }

    /// Number of the picture of a node, and where it is looked up; `None` if it names none.
    fn picture_of(
        &mut self,
        node: &Element,
        used: PictureUse,
    ) -> Result<Option<(u32, Option<Input>)>, SceneError> {
        let Some((prefix, file, space)) = node.input("file").and_then(|stated| {
            let file = stated.value.clone().filter(|file| !file.is_empty())?;
            Some((stated.file_prefix.clone(), file, stated.space.clone()))
        }) else {
            return Ok(None);
        };
        let pair = |name: &str, default: f32| {
            let text = node.input(name).and_then(|stated| stated.value.as_deref());
            let all = text.and_then(|text| numbers(text).ok()).unwrap_or_default();
            [0, 1].map(|axis| all.get(axis).copied().unwrap_or(default))
        };
        self.tell_unread(node, |name| OF_PICTURES.contains(&name));
        let mode = node.input("uaddressmode").and_then(|stated| stated.value.as_deref());
        let map = MapStatement {
            scale: Vec2::from(pair("uvtiling", 1.0)),
            offset: -Vec2::from(pair("uvoffset", 0.0)),
            clamp: mode == Some("clamp"),
            ..MapStatement::plain(format!("{prefix}{file}"), node.line)
        };
        let is_color =
            kind_of(&node.of_type) == Some(Kind::Color) && self.is_encoded(node.line, space.as_deref(), true);
        let asked = PictureAsked {
            map,
            used: if is_color && used == PictureUse::Parameter { PictureUse::Color } else { used },
        };
        let stated = node.input("texcoord").cloned();
        let at = stated.map(|stated| self.known(node, &stated)).transpose()?.flatten();
        let own = self.source(&inputs::UV);
        let at = at.map(|(input, _)| input).filter(|input| *input != own);
        Ok(Some(((self.pictures)(&asked)?, at)))
    }

    /// The alpha of a picture, if that is what a node takes.
    fn alpha(&mut self, node: &'d Element, output: usize) -> Result<Option<Value>, SceneError> {
        let index = match node.category.as_str() {
            "extract" => node.input("index").and_then(|stated| stated.value.as_deref()?.parse().ok()),
            _ => Some(output),
        };
        let Some(stated) = node.input("in").cloned().filter(|_| index == Some(ALPHA)) else {
            return Ok(None);
        };
        let Target::Node(from, _) = self.target(node, &stated)? else { return Ok(None) };
        let shown = match from.category.as_str() {
            category if IMAGES.contains(&category) => self.picture_of(from, PictureUse::Parameter)?,
            _ => None,
        };
        let alpha = match shown {
            Some((number, at)) => picture::add(&mut self.graph, number, picture::Shown::Alpha, at),
            None => Input::Constant(Vec3::ONE),
        };
        Ok(Some((alpha, Kind::Number)))
    }
}

fn key(node: &Element, output: usize) -> Key {
    (std::ptr::from_ref(node), output)
}

/// What a node states that is no input of its definition.
fn options(definition: &Definition, node: &Element) -> Options {
    let mut options = Options::default();
    let is_socket = |name: &str| definition.inputs.iter().any(|socket| socket.name == name);
    for stated in node.inputs.iter().filter(|stated| !is_socket(&stated.name)) {
        if let Some(value) = &stated.value {
            options.set(&stated.name, value);
        }
    }
    options
}

/// Number of the output of a node with this name; the first one without a name.
fn output_number(node: &Element, name: Option<&str>) -> usize {
    let Some(name) = name else { return 0 };
    let defined = nodes::named(&node.category);
    let of_definition = defined.and_then(|of| of.outputs.iter().position(|(output, _)| *output == name));
    of_definition.or_else(|| standard::output_number(name)).unwrap_or(0)
}

/// Kind of the values of a type; `None` of what is no value.
pub fn kind_of(of_type: &str) -> Option<Kind> {
    match of_type {
        "float" | "integer" | "boolean" => Some(Kind::Number),
        "vector2" | "vector3" | "vector4" => Some(Kind::Vector),
        "color3" | "color4" | "multioutput" => Some(Kind::Color),
        _ => None,
    }
}

/// A constant as it is written: one number, or two to four.
fn constant(text: &str, kind: Kind) -> Result<Vec3, String> {
    if kind == Kind::Number && matches!(text, "true" | "false") {
        return Ok(Vec3::splat(if text == "true" { 1.0 } else { 0.0 }));
    }
    match numbers(text)?[..] {
        [one] => Ok(Vec3::splat(one)),
        [x, y] => Ok(Vec3::new(x, y, 0.0)),
        [x, y, z, ..] => Ok(Vec3::new(x, y, z)),
        [] => Err(String::from("is empty: state a number")),
    }
}

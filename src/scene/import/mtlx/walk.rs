//! From nodes of a file to those of a graph.

use std::collections::HashMap;

use glam::Vec3;

use super::document::{Document, Element, Stated};
use super::picture_nodes::{HEXAGONS, IMAGES, Pictures};
use super::standard::{self, ALPHA, Standard};
use crate::graph::nodes::{self, inputs};
use crate::graph::{Definition, Graph, Input, Kind, Options, UvSet, numbers};
use crate::scene::SceneError;
use crate::scene::texture::linear_share;

/// What is left out of a file: the line, and a sentence.
pub(in crate::scene) type Finding = (usize, String);

/// A value, and its kind.
pub type Value = (Input, Kind);

/// References that lead from one to the next, at most: more are a circle.
pub const LONGEST_WAY: usize = 64;

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
    pub pictures: Pictures<'p>,
    states: HashMap<Key, State>,
}

/// What an input leads to.
pub enum Target<'d> {
    Constant {
        value: Value,
        /// The fourth number, if there are four.
        fourth: Option<f32>,
    },
    Node(&'d Element, usize),
    /// Nothing is stated.
    Nothing,
}

impl<'d, 'p> Walk<'d, 'p> {
    pub fn new(document: &'d Document, pictures: Pictures<'p>) -> Self {
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
            Target::Constant { value, .. } => Ok(Some(value)),
            Target::Node(node, output) => self.node(node, output),
        }
    }

    /// The node that an input of `element` leads to, if it leads to one.
    pub fn node_behind(
        &mut self,
        element: &Element,
        stated: &Stated,
    ) -> Result<Option<&'d Element>, SceneError> {
        Ok(match self.target(element, stated)? {
            Target::Node(node, _) => Some(node),
            Target::Constant { .. } | Target::Nothing => None,
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
    pub fn target(&mut self, element: &Element, stated: &Stated) -> Result<Target<'d>, SceneError> {
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
                let fault = |fault: String| document.fault_at(line, format!("`{}` {fault}", stated.name));
                let (value, fourth) = constant(text, kind).map_err(fault)?;
                let decoded = |share| linear_share(f64::from(share));
                let value = if is_encoded { value.map(decoded) } else { value };
                return Ok(Target::Constant { value: (Input::Constant(value), kind), fourth });
            } else {
                return Ok(Target::Nothing);
            }
        }
        self.tell(line, format!("`{}` leads in a circle: the default counts", stated.name));
        Ok(Target::Nothing)
    }

    /// Value of an input that was walked to.
    pub fn known(&mut self, element: &Element, stated: &Stated) -> Result<Option<Value>, SceneError> {
        Ok(match self.target(element, stated)? {
            Target::Nothing => None,
            Target::Constant { value, .. } => Some(value),
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
            HEXAGONS => return self.hexagons(node).map(Some),
            "texcoord" => {
                let set = self.set_of(node);
                return Ok(Some((self.uv(set), Kind::Vector)));
            }
            // meshes have no other names than those of their first texture coordinates and of their colours
            "geompropvalue" if node.of_type == "vector2" => {
                return Ok(Some((self.uv(UvSet::First), Kind::Vector)));
            }
            "position" => return Ok(Some(self.of_space(node, [&inputs::POINT, &inputs::WORLD_POINT]))),
            "normal" => return Ok(Some(self.of_space(node, [&inputs::NORMAL, &inputs::WORLD_NORMAL]))),
            "geomcolor" => {
                let color = &inputs::VERTEX_COLOR;
                return Ok(Some((self.source(color), color.outputs[0].1)));
            }
            "extract" | "separate4" if self.channel(node, output) == Some(ALPHA) => {
                let Some(stated) = node.input("in") else { return Ok(None) };
                return Ok(Some((self.fourth(node, stated)?, Kind::Number)));
            }
            "swizzle" => return self.swizzled(node),
            // a colour, and the fourth channel, which is looked up where it is taken
            "combine2" if matches!(node.of_type.as_str(), "color4" | "vector4") => {
                let first = node.input("in1").map(|stated| self.known(node, stated)).transpose()?;
                return Ok(first.flatten());
            }
            _ => {}
        }
        if let Some(function) = standard::named(&node.category) {
            return self.of_standard(function, node, output).map(Some);
        }
        match nodes::named(&node.category) {
            Some(definition) => self.of_definition(definition, node, output).map(Some),
            None => {
                let what = format!("nodes `{}` are not known: the default counts", node.category);
                self.tell(node.line, what);
                Ok(None)
            }
        }
    }

    /// An output of a node of the standard library.
    fn of_standard(
        &mut self,
        function: &'static Standard,
        node: &Element,
        output: usize,
    ) -> Result<Value, SceneError> {
        let kind = kind_of(&node.of_type).unwrap_or(Kind::Number);
        let mut taken = Vec::with_capacity(function.inputs.len());
        for input in function.inputs {
            let value = node.input(input.name).map(|stated| self.known(node, stated)).transpose()?.flatten();
            taken.push(match (value, input.default) {
                (Some((value, _)), _) => value,
                (None, standard::Default::Number(number)) => Input::Constant(Vec3::splat(number)),
                (None, standard::Default::Color(color)) => Input::Constant(Vec3::from(color)),
                (None, standard::Default::Uv) => self.source(&inputs::UV),
                (None, standard::Default::Point) => self.source(&inputs::POINT),
            });
        }
        self.tell_unread(node, |name| function.inputs.iter().any(|input| input.name == name));
        let channels = match node.of_type.as_str() {
            "vector2" => 2,
            _ if kind == Kind::Number => 1,
            _ => 3,
        };
        let function = function.asked(standard::Asked { output, channels });
        Ok((self.graph.add(function, taken), kind))
    }

    /// An output of a node of Blender's.
    fn of_definition(
        &mut self,
        definition: &'static Definition,
        node: &Element,
        output: usize,
    ) -> Result<Value, SceneError> {
        let options = self.options(definition, node);
        let mut taken = Vec::with_capacity(definition.inputs.len());
        for socket in definition.inputs {
            taken.push(node.input(socket.name).map(|stated| self.known(node, stated)).transpose()?.flatten());
        }
        let made = self.graph.add_defined(definition, &options, &taken, output);
        let value = made.map_err(|fault| self.document.fault(node, format!("`{}`: {fault}", node.name)))?;
        let unasked: Vec<&str> = options.unasked().collect();
        let document = self.document;
        let is_option = |name: &str| document.text(node, name).is_some() && !unasked.contains(&name);
        self.tell_unread(node, |name| is_socket(definition, name) || is_option(name));
        Ok((value, definition.outputs[output.min(definition.outputs.len() - 1)].1))
    }

    /// Returns true if colours of a space are encoded as sRGB's, which is so of what `otherwise` says where no space is stated.
    pub fn is_encoded(&mut self, line: usize, space: Option<&str>, otherwise: bool) -> bool {
        match space.map(str::trim) {
            None | Some("" | "auto") => otherwise,
            Some(space) if space.starts_with("srgb") || space == "sRGB" => true,
            Some("lin_rec709" | "lin_rec709_scene" | "lin_srgb" | "linear") => false,
            Some("raw" | "Raw" | "none" | "data" | "identity" | "unknown") => false,
            Some(space) => {
                self.tell(line, format!("colours in `{space}` are taken as those of lin_rec709"));
                false
            }
        }
    }

    /// Tells inputs of a node that nothing reads.
    pub fn tell_unread(&mut self, node: &Element, is_read: impl Fn(&str) -> bool) {
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
        let is_world = self.document.text(node, "space") == Some("world");
        let definition = if is_world { in_world } else { in_object };
        (self.source(definition), definition.outputs[0].1)
    }

    /// What a node states that is no input of its definition.
    fn options(&self, definition: &Definition, node: &Element) -> Options {
        let mut options = Options::default();
        for stated in node.inputs.iter().filter(|stated| !is_socket(definition, &stated.name)) {
            if let Some(text) = self.document.text(node, &stated.name) {
                options.set(&stated.name, text);
            }
        }
        options
    }

    /// The channel that a node takes out of a value.
    fn channel(&self, node: &Element, output: usize) -> Option<usize> {
        match node.category.as_str() {
            "extract" => self.document.text(node, "index")?.trim().parse().ok(),
            _ => Some(output),
        }
    }
}

fn is_socket(definition: &Definition, name: &str) -> bool {
    definition.inputs.iter().any(|socket| socket.name == name)
}

fn key(node: &Element, output: usize) -> Key {
    (std::ptr::from_ref(node), output)
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

/// A constant as it is written, one number, or two to four, and the fourth.
fn constant(text: &str, kind: Kind) -> Result<(Vec3, Option<f32>), String> {
    if kind == Kind::Number && matches!(text, "true" | "false") {
        return Ok((Vec3::splat(if text == "true" { 1.0 } else { 0.0 }), None));
    }
    match numbers(text)?[..] {
        [one] => Ok((Vec3::splat(one), None)),
        [x, y] => Ok((Vec3::new(x, y, 0.0), None)),
        [x, y, z] => Ok((Vec3::new(x, y, z), None)),
        [x, y, z, w, ..] => Ok((Vec3::new(x, y, z), Some(w))),
        [] => Err(String::from("is empty: state a number")),
    }
}

//! Networks of MaterialX's nodes: what prims state of them as the elements of a MaterialX file, in which connections lead straight from
//! node to node. Node graphs and interfaces are passed through.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;

use openusd::sdf::Value;
use openusd::usd::Prim;

use super::file::{Network, Picture};
use super::layer_of_mtlx;
use super::shader::{Shaders, Source, UvNames};
use super::tiles::Tiles;
use super::value::{Answer, codes, numbers, said, value, word};
use crate::scene::import::mtlx::{Document, Element, IMAGES, NodeKind, Stated};
use crate::scene::texture::UvSet;

/// Outputs of a material that lead to a surface of MaterialX, the better one first.
const SURFACES: [&str; 2] = ["outputs:mtlx:surface", "outputs:surface"];

/// Most nodes of a material.
const MOST_NODES: usize = 100_000;

/// Longest name of a kind of node that is told.
const MOST_LETTERS: usize = 80;

/// Name of the node that gives the second set of texture coordinates.
const SECOND_SET: &str = "second set";

/// A network while it is read.
#[derive(Default)]
struct Reading {
    elements: Vec<Element>,
    pictures: HashMap<String, Picture>,
    uvs: UvNames,
    /// Nodes that are yet to be read.
    waiting: Vec<Prim>,
    /// Paths of all nodes that were found.
    found: HashSet<String>,
}

impl Shaders<'_> {
    /// The network of a material, with the names of its texture coordinates. `None` if it has none that is known here.
    ///
    /// # Errors What the library says.
    pub fn network(&mut self, material: &Prim) -> Answer<Option<(Network, UvNames)>> {
        if let Some((path, name)) = layer_of_mtlx::material(material, self.code)? {
            return Ok(Some((Network::File { path, name }, UvNames::default())));
        }
        let mut surface = None;
        for output in SURFACES {
            let source = self.source(material, output)?.filter(Source::is_output);
            let Some(Source { prim, .. }) = source.filter(|_| surface.is_none()) else { continue };
            let id = word(&prim, "info:id", self.code)?.unwrap_or_default();
            match NodeKind::of_definition(&id) {
                Some(kind) if kind.is_surface => surface = Some(prim),
                Some(_) => self.leave_out(format!("surfaces `{}` are not used", shown(&id))),
                None => {}
            }
        }
        let Some(surface) = surface else { return Ok(None) };
        let displacement = self.displacement(material)?;
        let name = material.path().name().unwrap_or("material").to_string();
        let shader = Stated {
            name: String::from("surfaceshader"),
            node: Some(surface.path().to_string()),
            ..Stated::default()
        };
        let material = Element {
            category: String::from("surfacematerial"),
            name,
            inputs: [shader].into_iter().chain(displacement.as_ref().map(displacement_shader)).collect(),
            ..Element::default()
        };
        let mut reading = Reading { elements: vec![material], ..Reading::default() };
        reading.lead_to(surface);
        displacement.into_iter().for_each(|prim| reading.lead_to(prim));
        while let Some(prim) = reading.waiting.pop() {
            let element = self.element(&prim, &mut reading)?;
            reading.elements.push(element);
            if reading.elements.len() > MOST_NODES {
                return Err(format!("a material has more than {MOST_NODES} nodes"));
            }
        }
        let Reading { elements, pictures, uvs, .. } = reading;
        let path = PathBuf::from(self.root());
        let document = Document::of_elements(&path, elements);
        Ok(Some((Network::Prims { document, pictures }, uvs)))
    }

    /// The node that displaces a material, if there is one.
    fn displacement(&mut self, material: &Prim) -> Answer<Option<Prim>> {
        let source = self.source(material, "outputs:mtlx:displacement")?.filter(Source::is_output);
        let Some(Source { prim, .. }) = source else { return Ok(None) };
        // an output that nothing is connected to is its own source
        let Some(id) = word(&prim, "info:id", self.code)? else { return Ok(None) };
        if id.starts_with("ND_displacement_") {
            return Ok(Some(prim));
        }
        self.leave_out(format!("displacement by nodes `{}` is not used", shown(&id)));
        Ok(None)
    }

    /// A node with all that is stated of its inputs.
    fn element(&mut self, prim: &Prim, reading: &mut Reading) -> Answer<Element> {
        let id = word(prim, "info:id", self.code)?.unwrap_or_default();
        let kind = NodeKind::of_definition(&id);
        // what has no value has a token in its place
        let of_output = type_of(prim, "outputs:out")?.filter(|of_type| of_type != "string");
        let of_name = kind.as_ref().and_then(|kind| kind.of_type.clone());
        let mut element = Element {
            category: kind.map_or_else(|| shown(&id), |kind| kind.category),
            name: prim.path().to_string(),
            of_type: of_output.or(of_name).unwrap_or_else(|| String::from("multioutput")),
            ..Element::default()
        };
        if self.names_coordinates(prim, &mut element, reading)? {
            return Ok(element);
        }
        for name in said(prim.property_names())? {
            let Some(bare) = name.as_str().strip_prefix("inputs:") else { continue };
            let stated = self.stated(prim, name.as_str(), reading)?;
            element.inputs.extend(stated.map(|stated| Stated { name: bare.to_string(), ..stated }));
        }
        let is_placed = element.input("texcoord").is_some();
        if IMAGES.contains(&element.category.as_str()) && !is_placed {
            let set = self.set_of(&mut reading.uvs, None, true);
            element.inputs.extend((set == UvSet::Second).then(|| reading.second_set()));
        }
        Ok(element)
    }

    /// Makes a `texcoord` of a node that gives texture coordinates by a name or a number. Returns false of other nodes.
    fn names_coordinates(
        &mut self,
        prim: &Prim,
        element: &mut Element,
        reading: &mut Reading,
    ) -> Answer<bool> {
        let name = match (element.category.as_str(), element.of_type.as_str()) {
            ("texcoord", _) => {
                let index = value(prim, "inputs:index", self.code)?.as_ref().and_then(numbers);
                match index.and_then(|index| index.first().copied()).unwrap_or(0.0) {
                    first if first < 1.0 => None,
                    index => Some(format!("st{index}")),
                }
            }
            ("geompropvalue", "vector2") => self.word_behind(prim, "inputs:geomprop")?,
            ("UsdPrimvarReader", "vector2") | ("UsdPrimvarReader_float2", _) => {
                self.word_behind(prim, "inputs:varname")?
            }
            _ => return Ok(false),
        };
        let set = self.set_of(&mut reading.uvs, name, true);
        (element.category, element.of_type) = (String::from("texcoord"), String::from("vector2"));
        element.inputs = vec![index(set)];
        Ok(true)
    }

    /// What is stated of an input: the node that it leads to, or a value; `None` of neither.
    fn stated(&mut self, prim: &Prim, name: &str, reading: &mut Reading) -> Answer<Option<Stated>> {
        let own = Source { prim: prim.clone(), output: name.to_string() };
        let source = self.source(prim, name)?.unwrap_or(own);
        if source.is_output() {
            if word(&source.prim, "info:id", self.code)?.is_none() {
                return Ok(None);
            }
            let output = source.output.trim_start_matches("outputs:").to_string();
            let node = source.prim.path().to_string();
            reading.lead_to(source.prim);
            return Ok(Some(Stated { node: Some(node), output: Some(output), ..Stated::default() }));
        }
        if codes(&source.prim, &source.output)?.len() > 1 {
            self.leave_out("materials do not change with time: they are as at the first frame");
        }
        let Some(value) = value(&source.prim, &source.output, self.code)? else { return Ok(None) };
        let Some(of_type) = type_of(prim, name)?.or(type_of(&source.prim, &source.output)?) else {
            return Ok(None);
        };
        let text = match &value {
            Value::AssetPath(_) | Value::AssetPathVec(_) => self.picture_of_node(&value, reading)?,
            value => text_of(value),
        };
        let mut space = space_of(prim, name)?;
        if space.is_none() {
            space = space_of(&source.prim, &source.output)?;
        }
        Ok(text.map(|text| Stated { of_type, value: Some(text), space, ..Stated::default() }))
    }

    /// Name by which a network knows a picture.
    fn picture_of_node(&mut self, asset: &Value, reading: &mut Reading) -> Answer<Option<String>> {
        let Some((path, name, packed)) = self.file_of(Some(asset.clone()))? else { return Ok(None) };
        let tiles = if packed.is_none() { Tiles::find(&path) } else { None };
        let key = path.to_string_lossy().into_owned();
        let picture = Picture { tiles, ..Picture::plain(path, name, packed) };
        reading.pictures.insert(key.clone(), picture);
        Ok(Some(key))
    }
}

impl Reading {
    /// Has a node read, unless it was found before.
    fn lead_to(&mut self, prim: Prim) {
        if self.found.insert(prim.path().to_string()) {
            self.waiting.push(prim);
        }
    }

    /// Texture coordinates of the second set, as an input states them.
    fn second_set(&mut self) -> Stated {
        if self.found.insert(String::from(SECOND_SET)) {
            self.elements.push(Element {
                category: String::from("texcoord"),
                name: String::from(SECOND_SET),
                of_type: String::from("vector2"),
                inputs: vec![index(UvSet::Second)],
                ..Element::default()
            });
        }
        Stated { name: String::from("texcoord"), node: Some(String::from(SECOND_SET)), ..Stated::default() }
    }
}

/// The input of a material that names what displaces it.
fn displacement_shader(prim: &Prim) -> Stated {
    let node = Some(prim.path().to_string());
    Stated { name: String::from("displacementshader"), node, ..Stated::default() }
}

/// The input of a `texcoord` that says which set it gives.
fn index(set: UvSet) -> Stated {
    let number = if set == UvSet::Second { "1" } else { "0" };
    let (name, of_type) = (String::from("index"), String::from("integer"));
    Stated { name, of_type, value: Some(number.to_string()), ..Stated::default() }
}

/// Name of a kind of node as it is told.
fn shown(id: &str) -> String {
    id.chars().take(MOST_LETTERS).collect()
}

/// MaterialX's name of the type of an attribute; `None` of what has no type, or one that no node has.
fn type_of(prim: &Prim, name: &str) -> Answer<Option<String>> {
    let Some(of_type) = said(prim.attribute(name).type_name())? else { return Ok(None) };
    Ok(Some(String::from(match of_type.as_str() {
        "half" | "float" | "double" => "float",
        "int" | "uint" | "int64" => "integer",
        "bool" => "boolean",
        "asset" => "filename",
        "string" | "token" => "string",
        name if name.starts_with("color3") => "color3",
        name if name.starts_with("color4") => "color4",
        name if name.contains('2') => "vector2",
        name if name.contains("[]") => "string",
        name if ["float3", "double3", "half3", "vector3", "normal3", "point3"]
            .iter()
            .any(|of| name.starts_with(of)) =>
        {
            "vector3"
        }
        "float4" | "double4" | "half4" => "vector4",
        _ => return Ok(None),
    })))
}

/// Space of colours of an attribute, if it is stated.
fn space_of(prim: &Prim, name: &str) -> Answer<Option<String>> {
    Ok(match said(prim.attribute(name).get_metadata::<Value>("colorSpace"))? {
        Some(Value::Token(space)) => Some(space.to_string()),
        Some(Value::String(space)) => Some(space),
        _ => None,
    })
}

/// A value as MaterialX files spell it; `None` of what they do not have, or is not finite.
fn text_of(value: &Value) -> Option<String> {
    match value {
        Value::Bool(flag) => return Some(flag.to_string()),
        Value::Token(word) => return Some(word.to_string()),
        Value::String(text) => return Some(text.clone()),
        _ => {}
    }
    let numbers = numbers(value).filter(|numbers| numbers.iter().all(|number| number.is_finite()))?;
    let words: Vec<String> = numbers.iter().map(f64::to_string).collect();
    Some(words.join(", "))
}

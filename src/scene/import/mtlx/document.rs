//! The elements of a file, by name.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use roxmltree::{Document as Xml, Node};

use crate::digest::Digest;
use crate::input::{self, InputError, Kind};
use crate::memory::{self, Need, Part};
use crate::scene::SceneError;
use crate::scene::keys::spelling;

/// Memory for each byte of a file while it is read, and of what is kept of it.
const READING_BYTES: u64 = 16;

/// A MaterialX file.
#[derive(Debug, PartialEq)]
pub struct Document {
    /// Path of the file.
    pub path: PathBuf,
    /// Digest of its bytes; of none, where it was made of something else.
    pub digest: Digest,
    /// Elements, each after what it is in.
    elements: Vec<Element>,
    /// Elements by the name of the graph that they are in (empty: none) and their own.
    by_name: HashMap<(String, String), usize>,
}

/// An element with a name: a node, a graph, or an output of a graph.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Element {
    /// Kind: the name of its tag.
    pub category: String,
    pub name: String,
    /// Name of the graph that it is in; empty if it is in none.
    pub graph: String,
    /// Type of its value.
    pub of_type: String,
    /// Line from 1; 0 of what has none.
    pub line: usize,
    pub inputs: Vec<Stated>,
    /// What an output of a graph shows; it has no inputs.
    pub shown: Stated,
}

/// What is stated of an input.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Stated {
    pub name: String,
    pub of_type: String,
    pub value: Option<String>,
    /// Node in the same graph.
    pub node: Option<String>,
    /// Graph.
    pub graph: Option<String>,
    /// Name of the output of the node or graph.
    pub output: Option<String>,
    /// Input of the graph that it is in.
    pub interface: Option<String>,
    /// Encoding of colours, if it is stated here or above.
    pub space: Option<String>,
    /// What names of files begin with.
    pub file_prefix: String,
}

/// Where the lines of a text begin. The parser counts them from the first one for each place, which takes minutes in large files.
struct LineStarts(Vec<usize>);

impl LineStarts {
    fn of(text: &str) -> Self {
        Self(std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect())
    }

    /// Number of the line of a byte, from 1.
    fn line_at(&self, byte: usize) -> usize {
        self.0.partition_point(|start| *start <= byte)
    }
}

impl Document {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// Where it cannot be read, is no XML or no MaterialX.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let unreadable =
            |error: InputError| SceneError::new(path, format!("the MaterialX file cannot be read: {error}"));
        let input = input::open(path, Kind::Materials).map_err(unreadable)?;
        let need =
            Need::new(Part::new("the MaterialX file", READING_BYTES * input.length, "fewer materials"));
        need.check(&memory::left()).map_err(|error| SceneError::new(path, error.to_string()))?;
        let bytes = input.read_all().map_err(unreadable)?;
        let text = std::str::from_utf8(&bytes)
            .map_err(|_| SceneError::new(path, "the MaterialX file is not UTF-8: save it as UTF-8"))?;
        Self::parse(path, text)
    }

    fn parse(path: &Path, text: &str) -> Result<Self, SceneError> {
        let xml = Xml::parse(text).map_err(|error| {
            let line = error.pos().row as usize;
            SceneError::new(path, format!("it is no XML: {error}; export it again")).at_line(line)
        })?;
        let root = xml.root_element();
        if root.tag_name().name() != "materialx" {
            let found = root.tag_name().name();
            return Err(SceneError::new(path, format!("it is no MaterialX: it begins with <{found}>")));
        }
        let mut document = Self {
            path: path.to_path_buf(),
            digest: Digest::new(text.as_bytes()),
            elements: Vec::new(),
            by_name: HashMap::new(),
        };
        let lines = LineStarts::of(text);
        for node in root.children().filter(Node::is_element) {
            document.add(&lines, node, "");
            if node.tag_name().name() == "nodegraph" {
                let graph = node.attribute("name").unwrap_or_default();
                node.children().filter(Node::is_element).for_each(|node| document.add(&lines, node, graph));
            }
        }
        Ok(document)
    }

    /// Creates a document of these elements, of a file that is not MaterialX's own.
    #[cfg(feature = "usd")]
    pub fn of_elements(path: &Path, elements: Vec<Element>) -> Self {
        let mut document = Self {
            path: path.to_path_buf(),
            digest: Digest::new(&[]),
            elements: Vec::with_capacity(elements.len()),
            by_name: HashMap::new(),
        };
        elements.into_iter().for_each(|element| document.push(element));
        document
    }

    fn add(&mut self, lines: &LineStarts, node: Node<'_, '_>, graph: &str) {
        let text = |key: &str| node.attribute(key).unwrap_or_default().to_string();
        let inputs = node.children().filter(|child| child.is_element() && child.tag_name().name() == "input");
        let element = Element {
            category: node.tag_name().name().to_string(),
            name: text("name"),
            graph: graph.to_string(),
            of_type: text("type"),
            line: lines.line_at(node.range().start),
            inputs: inputs.map(Stated::of).collect(),
            shown: Stated::of(node),
        };
        self.push(element);
    }

    fn push(&mut self, element: Element) {
        // files that give an output the name of a node are not rare, though names should differ
        let (key, number) = ((element.graph.clone(), element.name.clone()), self.elements.len());
        if element.category == "output" {
            self.by_name.entry(key).or_insert(number);
        } else {
            self.by_name.insert(key, number);
        }
        self.elements.push(element);
    }

    /// The element with a name in a graph; none: the empty name.
    pub fn element(&self, graph: &str, name: &str) -> Option<&Element> {
        self.by_name.get(&(graph.to_string(), name.to_string())).map(|number| &self.elements[*number])
    }

    /// Output of a graph: that of this name, or the first one.
    pub fn output(&self, graph: &str, name: Option<&str>) -> Option<&Element> {
        let is_wanted = |element: &&Element| {
            element.graph == graph
                && element.category == "output"
                && name.is_none_or(|name| element.name == name)
        };
        self.elements.iter().find(is_wanted)
    }

    /// The material of this name.
    ///
    /// # Errors
    /// That there is none, with a name like it.
    pub fn material(&self, name: &str) -> Result<&Element, SceneError> {
        let is_it = |element: &&Element| is_material(element) && element.name == name;
        self.elements.iter().find(is_it).ok_or_else(|| {
            let near = spelling::hint(name, self.materials());
            SceneError::new(&self.path, format!("it has no surfacematerial `{name}`{near}"))
        })
    }

    /// Names of its materials.
    pub fn materials(&self) -> impl Iterator<Item = &str> {
        let materials = self.elements.iter().filter(|element| is_material(element));
        materials.map(|element| element.name.as_str())
    }

    /// What is stated of an input that has a text, such as the name of a file: there, or where the graph that it is in takes it from.
    pub fn written<'a>(&'a self, element: &'a Element, name: &str) -> Option<&'a Stated> {
        let stated = element.input(name)?;
        let stated = match &stated.interface {
            Some(outside) => self.element("", &element.graph)?.input(outside)?,
            None => stated,
        };
        stated.value.is_some().then_some(stated)
    }

    /// Text of an input; none is stated of what a node gives.
    pub fn text<'a>(&'a self, element: &'a Element, name: &str) -> Option<&'a str> {
        self.written(element, name)?.value.as_deref()
    }

    /// An error about an element.
    pub fn fault(&self, element: &Element, what: impl Into<String>) -> SceneError {
        self.fault_at(element.line, what)
    }

    /// An error at a line, if it is one.
    pub fn fault_at(&self, line: usize, what: impl Into<String>) -> SceneError {
        let fault = SceneError::new(&self.path, what.into());
        if line > 0 { fault.at_line(line) } else { fault }
    }
}

/// Returns true if an element is a material, of a surface or of a volume.
fn is_material(element: &Element) -> bool {
    ["surfacematerial", "volumematerial"].contains(&element.category.as_str())
}

impl Element {
    /// What is stated of an input.
    pub fn input(&self, name: &str) -> Option<&Stated> {
        self.inputs.iter().find(|input| input.name == name)
    }
}

impl Stated {
    fn of(node: Node<'_, '_>) -> Self {
        let text = |key: &str| node.attribute(key).map(String::from);
        let above = |key: &str| node.ancestors().find_map(|node| node.attribute(key)).map(String::from);
        Self {
            name: text("name").unwrap_or_default(),
            of_type: text("type").unwrap_or_default(),
            value: text("value"),
            node: text("nodename"),
            graph: text("nodegraph"),
            output: text("output"),
            interface: text("interfacename"),
            space: above("colorspace"),
            file_prefix: above("fileprefix").unwrap_or_default(),
        }
    }
}

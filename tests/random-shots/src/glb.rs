//! The glTF files that shots name, as `SHAPE-MATERIAL.MOTION.glb`: a mesh below two nodes, and an animation of half a second.

use serde_json::{Value, json};

use crate::files::Mesh;

/// What the files do, with what each of them is for.
pub const MOTIONS: [&str; 6] = [
    "painted", // rests; the colours of its vertices have alpha, some of which cuts out
    "turns",   // its parent turns, by a constant angle each frame
    "steps",   // jumps from place to place
    "curves",  // goes and grows along cubic curves
    "bends",   // a morph target comes and goes
    "skin",    // two joints, the upper of which nods
];

/// Times of its keys, in seconds: frames 1, 4, 7 and 13 of 24 in a second.
const TIMES: [f64; 4] = [0.0, 0.125, 0.25, 0.5];

// what the numbers of the standard mean
const FLOATS: u32 = 5126;
const SHORTS: u32 = 5123;

/// A file while it is made.
struct File {
    json: Value,
    buffer: Vec<u8>,
}

impl File {
    /// Adds numbers, `width` of them to an element.
    fn floats(&mut self, kind: &str, width: usize, numbers: &[f64]) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| (*number as f32).to_le_bytes()).collect();
        let elements = numbers.chunks(width);
        let fold = |with: fn(f64, f64) -> f64| -> Vec<f64> {
            let first = numbers[..width].to_vec();
            elements
                .clone()
                .fold(first, |far, element| far.iter().zip(element).map(|(a, b)| with(*a, *b)).collect())
        };
        let ends = (fold(f64::min), fold(f64::max));
        self.accessor(kind, FLOATS, numbers.len() / width, &bytes, ends)
    }

    fn shorts(&mut self, kind: &str, width: usize, numbers: &[u16]) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        self.accessor(kind, SHORTS, numbers.len() / width, &bytes, (vec![], vec![]))
    }

    fn accessor(
        &mut self,
        kind: &str,
        numbers: u32,
        count: usize,
        bytes: &[u8],
        (least, most): (Vec<f64>, Vec<f64>),
    ) -> usize {
        let view = json!({"buffer": 0, "byteOffset": self.buffer.len(), "byteLength": bytes.len()});
        self.buffer.extend(bytes);
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        let view = self.add("bufferViews", view);
        let mut accessor =
            json!({"bufferView": view, "componentType": numbers, "count": count, "type": kind});
        if !least.is_empty() {
            // as exact as the numbers themselves
            let exact = |ends: Vec<f64>| ends.iter().map(|end| *end as f32).collect::<Vec<f32>>();
            accessor["min"] = json!(exact(least));
            accessor["max"] = json!(exact(most));
        }
        self.add("accessors", accessor)
    }

    /// Appends to a list, and returns the number there.
    fn add(&mut self, list: &str, value: Value) -> usize {
        let list = &mut self.json[list];
        if list.is_null() {
            *list = json!([]);
        }
        let items = list.as_array_mut().expect("it is a list");
        items.push(value);
        items.len() - 1
    }

    /// Adds a channel of the animation: keys at [`TIMES`].
    fn animate(&mut self, node: usize, path: &str, curve: &str, (kind, width): (&str, usize), keys: &[f64]) {
        let times = self.floats("SCALAR", 1, &TIMES);
        let values = self.floats(kind, width, keys);
        if self.json["animations"].is_null() {
            self.json["animations"] = json!([{"name": "all", "samplers": [], "channels": []}]);
        }
        let animation = &mut self.json["animations"][0];
        let samplers = animation["samplers"].as_array_mut().expect("it is a list");
        samplers.push(json!({"input": times, "output": values, "interpolation": curve}));
        let sampler = samplers.len() - 1;
        let channels = animation["channels"].as_array_mut().expect("it is a list");
        channels.push(json!({"sampler": sampler, "target": {"node": node, "path": path}}));
    }

    /// The bytes of a .glb.
    fn finish(mut self) -> Vec<u8> {
        self.json["buffers"] = json!([{"byteLength": self.buffer.len()}]);
        let mut text = self.json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut bytes = Vec::from(*b"glTF");
        let chunks = [(*b"JSON", &text), (*b"BIN\0", &self.buffer)];
        let length = 12 + chunks.iter().map(|(_, chunk)| 8 + chunk.len()).sum::<usize>();
        bytes.extend([2, length as u32].map(u32::to_le_bytes).as_flattened());
        for (kind, chunk) in chunks {
            bytes.extend((chunk.len() as u32).to_le_bytes());
            bytes.extend(kind);
            bytes.extend(chunk);
        }
        bytes
    }
}

/// Number of the node of the mesh; its parent is the one before.
const NODE: usize = 1;

/// The file of a mesh.
pub fn file(mesh: &Mesh, material: &str, motion: &str) -> Vec<u8> {
    let asset = json!({"version": "2.0"});
    let mut file =
        File { json: json!({"asset": asset, "scene": 0, "scenes": [{"nodes": [0]}]}), buffer: vec![] };
    let is_painted = motion == "painted";
    let mut stated = json!({"name": material, "doubleSided": true,
        "pbrMetallicRoughness": {"baseColorFactor": [0.7, 0.7, 0.7, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.6}});
    if is_painted {
        stated["alphaMode"] = json!("MASK");
    }
    file.add("materials", stated);
    let (corners, count) = (mesh.corners.as_flattened(), mesh.corners.len());
    let uvs: Vec<f64> = mesh.corners.iter().flat_map(|[x, y, z]| [x + 0.3 * z, y + 0.7 * z]).collect();
    let mut attributes =
        json!({"POSITION": file.floats("VEC3", 3, corners), "TEXCOORD_0": file.floats("VEC2", 2, &uvs)});
    if mesh.is_smooth {
        attributes["NORMAL"] = file.floats("VEC3", 3, mesh.normals().as_flattened()).into();
    }
    if is_painted {
        // by place: of two surfaces in one place, either may be met
        let first = |corner: &[f64; 3]| mesh.corners.iter().position(|other| other == corner).unwrap_or(0);
        let color = |corner| {
            let number = first(corner);
            [0.5, 1.0, 0.2 * (number % 5) as f64, [1.0, 0.9, 0.1][number % 3]]
        };
        let colors: Vec<f64> = mesh.corners.iter().flat_map(color).collect();
        attributes["COLOR_0"] = file.floats("VEC4", 4, &colors).into();
    }
    let is_skinned = motion == "skin";
    if is_skinned {
        let upper = |[_, y, _]: &[f64; 3]| (0.5 + y).clamp(0.0, 1.0);
        let weights: Vec<f64> =
            mesh.corners.iter().flat_map(|corner| [1.0 - upper(corner), upper(corner), 0.0, 0.0]).collect();
        attributes["JOINTS_0"] = file.shorts("VEC4", 4, &[0, 1, 0, 0].repeat(count)).into();
        attributes["WEIGHTS_0"] = file.floats("VEC4", 4, &weights).into();
    }
    let fan = |face: &Vec<usize>| {
        let face: Vec<u16> = face.iter().map(|corner| *corner as u16).collect();
        (2..face.len()).flat_map(move |third| [face[0], face[third - 1], face[third]])
    };
    let indices: Vec<u16> = mesh.faces.iter().flat_map(fan).collect();
    let indices = file.shorts("SCALAR", 1, &indices);
    let mut primitive = json!({"attributes": attributes, "indices": indices, "material": 0});
    if motion == "bends" {
        let bent: Vec<f64> =
            mesh.corners.iter().flat_map(|[x, y, z]| [0.2 * y, 0.5 * x * z, 0.1 * z]).collect();
        primitive["targets"] = json!([{"POSITION": file.floats("VEC3", 3, &bent)}]);
    }
    file.add("meshes", json!({"primitives": [primitive]}));
    file.add("nodes", json!({"name": "above", "children": [NODE], "scale": [1.0, 0.9, 1.0]}));
    file.add("nodes", json!({"name": "thing", "mesh": 0, "translation": [0.1, 0.0, 0.0]}));
    move_it(&mut file, motion);
    file.finish()
}

/// Adds the animation of its nodes.
fn move_it(file: &mut File, motion: &str) {
    let [vector, turn] = [("VEC3", 3), ("VEC4", 4)];
    let about = |axis: [f64; 3], degrees: f64| {
        let (sin, cos) = (degrees.to_radians() / 2.0).sin_cos();
        [axis[0] * sin, axis[1] * sin, axis[2] * sin, cos]
    };
    match motion {
        "turns" => {
            let keys = [0.0, 40.0, 80.0, 160.0].map(|degrees| about([0.6, 0.8, 0.0], degrees));
            file.animate(0, "rotation", "LINEAR", turn, keys.as_flattened());
        }
        "steps" => {
            let keys = [[0.1, 0.0, 0.0], [0.4, 0.2, 0.0], [0.4, 0.2, 0.3], [0.0, -0.2, 0.0]];
            file.animate(NODE, "translation", "STEP", vector, keys.as_flattened());
        }
        "curves" => {
            // each key between the tangents that lead to it and from it
            let keys = [[0.1, 0.0, 0.0], [0.5, 0.3, 0.1], [0.2, 0.5, -0.2], [0.1, 0.0, 0.0]];
            let keys = keys.map(|key| [[0.0, 1.0, 0.0], key, [1.0, 0.0, 0.5]]);
            file.animate(NODE, "translation", "CUBICSPLINE", vector, keys.as_flattened().as_flattened());
            let sizes = [1.0, 1.3, 0.7, 1.0].map(|size| [[0.2; 3], [size; 3], [0.2; 3]]);
            file.animate(NODE, "scale", "CUBICSPLINE", vector, sizes.as_flattened().as_flattened());
        }
        "bends" => file.animate(NODE, "weights", "LINEAR", ("SCALAR", 1), &[0.0, 1.0, 0.3, 0.3]),
        "skin" => {
            let lower = file.add("nodes", json!({"name": "lower", "children": [NODE + 2]}));
            let upper = file.add("nodes", json!({"name": "upper", "translation": [0.0, 0.2, 0.0]}));
            file.json["scenes"][0]["nodes"] = json!([0, lower]);
            let back = |y: f64| [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., y, 0., 1.];
            let binds = [back(0.0), back(-0.2)];
            let binds = file.floats("MAT4", 16, binds.as_flattened());
            file.add("skins", json!({"joints": [lower, upper], "inverseBindMatrices": binds}));
            file.json["nodes"][NODE]["skin"] = json!(0);
            let keys = [0.0, 30.0, -20.0, 10.0].map(|degrees| about([0.0, 0.0, 1.0], degrees));
            file.animate(upper, "rotation", "LINEAR", turn, keys.as_flattened());
        }
        _ => {}
    }
}

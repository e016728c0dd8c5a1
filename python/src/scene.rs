//! The class `Scene`: a shot that was loaded, or one that is stated bit by bit.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use afterimage::scene::given::{self, Given, GivenMesh, GivenModel};
use afterimage::scene::written::camera_keys;
use afterimage::scene::{Frames, Shot};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use toml::{Table, Value};

use crate::aside::aside;
use crate::errors::{error, guarded};
use crate::keys::{self, told};
use crate::models::model;
use crate::stated::{Stated, check};
use crate::{convert, curves, meshes, motion, worker};

/// A shot: models, lights, camera, and how they are rendered.
#[pyclass(frozen, module = "afterimage")]
pub struct Scene {
    content: Mutex<Content>,
}

enum Content {
    Loaded(Arc<Shot>),
    Stated(Box<Stated>),
}

/// A mesh of a scene, for copies of it.
#[pyclass(frozen, module = "afterimage")]
pub struct Mesh {
    /// Name of the mesh.
    #[pyo3(get)]
    name: String,
    index: usize,
}

/// A material of a scene.
#[pyclass(frozen, module = "afterimage")]
pub struct Material {
    /// Name of the material.
    #[pyo3(get)]
    name: String,
}

/// Loads a shot file (.toml), or a model (.obj, .ply, .gltf, .glb, .usda, .usdc, .usdz).
///
/// strict: missing textures and materials are errors, and not warnings.
#[pyfunction]
#[pyo3(signature = (path, *, strict = false))]
pub fn load(py: Python<'_>, path: PathBuf, strict: bool) -> PyResult<Scene> {
    let shot = aside(py, move || afterimage::scene::load(&path, strict).map_err(|cause| cause.to_string()))?;
    Ok(Scene { content: Mutex::new(Content::Loaded(Arc::new(shot))) })
}

/// Words of materials in Python, and the keys of shot files that they stand for.
const MATERIAL_WORDS: [(&str, &str); 13] = [
    ("base_color", "kd"),
    ("metallic", "pm"),
    ("roughness", "pr"),
    ("ior", "ni"),
    ("alpha", "d"),
    ("emission", "ke"),
    ("base_color_map", "map_kd"),
    ("alpha_map", "map_d"),
    ("metallic_map", "map_pm"),
    ("roughness_map", "map_pr"),
    ("emission_map", "map_ke"),
    ("normal_map", "norm"),
    ("bump_map", "map_bump"),
];

/// Keys of `[camera]` itself; all others are those of its keys.
const OF_CAMERA: [&str; 4] = ["projection", "interpolation", "from", "animation"];

/// Keys that a light may have at each of its keys.
const OF_LIGHT_KEY: [&str; 6] = ["position", "direction", "target", "up", "color", "power"];

/// Most materials of a mesh: as many as a scene has.
const MOST_MATERIALS: usize = 1 << 16;

impl Scene {
    fn lock(&self) -> MutexGuard<'_, Content> {
        self.content.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes a scene that is stated.
    fn change<T>(&self, change: impl FnOnce(&mut Stated) -> PyResult<T>) -> PyResult<T> {
        match &mut *self.lock() {
            Content::Loaded(_) => Err(error(
                "this scene was loaded from a file, and stays as it is: make one with afterimage.Scene() to add to it",
            )),
            Content::Stated(stated) => {
                let changed = change(stated)?;
                if let Some(shot) = stated.built.take() {
                    worker::let_go(&shot);
                }
                Ok(changed)
            }
        }
    }

    /// The shot: made of what is stated, unless nothing has changed since it was made.
    pub fn shot(&self, py: Python<'_>) -> PyResult<Arc<Shot>> {
        let (text, given, strict) = match &*self.lock() {
            Content::Loaded(shot) => return Ok(Arc::clone(shot)),
            Content::Stated(stated) => match &stated.built {
                Some(shot) => return Ok(Arc::clone(shot)),
                None => (stated.text(), stated.given.clone(), stated.strict),
            },
        };
        let from = text.clone();
        let models = given.models.len();
        let make = move || given::shot(&text, given, strict).map(Arc::new).map_err(|cause| told(&cause));
        let shot = aside(py, make)?;
        if let Content::Stated(stated) = &mut *self.lock() {
            // another thread may have changed it meanwhile
            let is_same = stated.given.models.len() == models && stated.text() == from;
            stated.built = is_same.then(|| Arc::clone(&shot));
        }
        Ok(shot)
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        let shot = match &*self.lock() {
            Content::Loaded(shot) => Some(Arc::clone(shot)),
            Content::Stated(stated) => stated.built.clone(),
        };
        if let Some(shot) = shot {
            worker::let_go(&shot);
        }
    }
}

impl Scene {
    /// Adds a mesh, and a model of it.
    fn add(&self, mesh: GivenMesh, model: GivenModel) -> PyResult<Mesh> {
        guarded(|| mesh.check())?;
        self.change(|stated| {
            let name = mesh.name.clone();
            for material in mesh.materials.iter().filter(|material| !material.is_empty()) {
                let kind = if mesh.curves.is_some() { "curves" } else { "mesh" };
                stated.has_material(material).map_err(|what| error(format!("{kind} `{name}`: {what}")))?;
            }
            let index = stated.given.meshes.len();
            stated.given.meshes.push(Arc::new(mesh));
            stated.given.models.push(GivenModel { mesh: index, ..model });
            Ok(Mesh { name, index })
        })
    }
}

#[pymethods]
impl Scene {
    /// A scene without anything in it.
    ///
    /// frames: as in render(). fps: frames in a second. strict: stand-ins are errors. settings: as in render().
    #[new]
    #[pyo3(signature = (frames = None, fps = None, *, strict = false, **settings))]
    fn new(
        frames: Option<Bound<'_, PyAny>>,
        fps: Option<Bound<'_, PyAny>>,
        strict: bool,
        settings: Option<Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let mut tables = match &settings {
            Some(settings) => keys::tables_of_settings(settings)?,
            None => Table::new(),
        };
        let frames = frames.map_or(Ok(Frames::between(1, 1)), |frames| convert::frames(&frames))?;
        let render = tables.entry("render").or_insert_with(|| Value::Table(Table::new()));
        if let Some(render) = render.as_table_mut() {
            render.insert(String::from("frames"), Value::String(frames.to_string()));
            if let Some(fps) = fps {
                render.insert(String::from("rate"), convert::rate(&fps)?);
            }
        }
        for (name, table) in &tables {
            check(name, table, false)?;
        }
        let stated = Stated {
            tables,
            materials: Vec::new(),
            lights: Vec::new(),
            given: Given::default(),
            strict,
            built: None,
        };
        Ok(Self { content: Mutex::new(Content::Stated(Box::new(stated))) })
    }

    /// Numbers of the frames that the shot names, in rising order.
    #[getter]
    fn frames(&self) -> Vec<i32> {
        match &*self.lock() {
            Content::Loaded(shot) => shot.frames.list(),
            Content::Stated(stated) => stated.frames().list(),
        }
    }

    /// Warnings: what the picture shows a stand-in for, and what is odd.
    #[getter]
    fn warnings(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        Ok(self.shot(py)?.warnings.iter().map(|warning| told(&warning.0)).collect())
    }

    /// Width and height of the pictures, pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        match &*self.lock() {
            Content::Loaded(shot) => (shot.settings.width, shot.settings.height),
            Content::Stated(stated) => stated.size(),
        }
    }

    /// Adds a mesh, and shows it at `transform`.
    ///
    /// vertices: (n, 3). faces: (m, 3) triangles, or a tuple of the corners' vertices (c,) and the number of corners of each face (m,).
    /// normals: (n, 3) or (c, 3); faces without are flat. uv: (n, 2) or (c, 2), v = 0 at the bottom of the picture. colors: (n, 3) or
    /// (c, 3), linear RGB.
    /// material: a material or its name; or materials: a list, with face_materials: (m,) indices into it.
    /// transform: (4, 4) for column vectors, or a dict from frames to these. vertices_by_frame: a dict from frames to (n, 3).
    /// visible: True or False, or a dict from frames to these. hidden_from, holdout, shadow_catcher, groups, light_link,
    /// shadow_link: as in [[model]].
    #[pyo3(signature = (name, vertices, faces, normals = None, uv = None, colors = None, material = None, face_materials = None,
                        materials = None, transform = None, vertices_by_frame = None, visible = None, hidden_from = None, holdout = false,
                        shadow_catcher = false, groups = None, light_link = None, shadow_link = None))]
    #[allow(clippy::too_many_arguments, reason = "they have names in Python")]
    fn add_mesh(
        &self,
        name: String,
        vertices: &Bound<'_, PyAny>,
        faces: &Bound<'_, PyAny>,
        normals: Option<&Bound<'_, PyAny>>,
        uv: Option<&Bound<'_, PyAny>>,
        colors: Option<&Bound<'_, PyAny>>,
        material: Option<&Bound<'_, PyAny>>,
        face_materials: Option<&Bound<'_, PyAny>>,
        materials: Option<&Bound<'_, PyAny>>,
        transform: Option<&Bound<'_, PyAny>>,
        vertices_by_frame: Option<&Bound<'_, PyDict>>,
        visible: Option<&Bound<'_, PyAny>>,
        hidden_from: Option<Vec<String>>,
        holdout: bool,
        shadow_catcher: bool,
        groups: Option<Vec<String>>,
        light_link: Option<&Bound<'_, PyDict>>,
        shadow_link: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Mesh> {
        let materials = match (material, materials) {
            (Some(_), Some(_)) => {
                return Err(error(format!("mesh `{name}`: give `material` or `materials`, and not both")));
            }
            (Some(material), None) => vec![name_of(material)?],
            (None, Some(materials)) => names_of(materials)?,
            (None, None) => Vec::new(),
        };
        let said = meshes::Said { vertices, faces, normals, uv, colors, face_materials, vertices_by_frame };
        let mesh = meshes::mesh(&name, materials, &said)?;
        let links = (groups, light_link, shadow_link);
        self.add(mesh, model(name, transform, visible, (hidden_from, holdout, shadow_catcher), links)?)
    }

    /// Adds curves with a thickness, hair say, and shows them at `transform`.
    ///
    /// points: (n, 3), curve after curve. counts: how many points each has, (m,), or one number for all. radius: (n,), or one number.
    /// basis: "linear", "bezier", "bspline" or "catmull-rom". uv: (m, 2). colors: (n, 3), linear RGB. normals: (n, 3), which makes them flat.
    /// points_by_frame: a dict from frames to (n, 3). material, transform, visible, hidden_from, holdout, shadow_catcher, groups,
    /// light_link, shadow_link: as in add_mesh().
    #[pyo3(signature = (name, points, counts, radius, basis = "linear", uv = None, colors = None, normals = None, material = None,
                        transform = None, points_by_frame = None, visible = None, hidden_from = None, holdout = false,
                        shadow_catcher = false, groups = None, light_link = None, shadow_link = None))]
    #[allow(clippy::too_many_arguments, reason = "they have names in Python")]
    fn add_curves(
        &self,
        name: String,
        points: &Bound<'_, PyAny>,
        counts: &Bound<'_, PyAny>,
        radius: &Bound<'_, PyAny>,
        basis: &str,
        uv: Option<&Bound<'_, PyAny>>,
        colors: Option<&Bound<'_, PyAny>>,
        normals: Option<&Bound<'_, PyAny>>,
        material: Option<&Bound<'_, PyAny>>,
        transform: Option<&Bound<'_, PyAny>>,
        points_by_frame: Option<&Bound<'_, PyDict>>,
        visible: Option<&Bound<'_, PyAny>>,
        hidden_from: Option<Vec<String>>,
        holdout: bool,
        shadow_catcher: bool,
        groups: Option<Vec<String>>,
        light_link: Option<&Bound<'_, PyDict>>,
        shadow_link: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Mesh> {
        let said = curves::Said { points, counts, radius, basis, uv, colors, normals, points_by_frame };
        let of_material = material.map_or(Ok(String::new()), name_of)?;
        let mesh = curves::mesh(&name, of_material, &said)?;
        let links = (groups, light_link, shadow_link);
        self.add(mesh, model(name, transform, visible, (hidden_from, holdout, shadow_catcher), links)?)
    }

    /// Shows a mesh at one more place. transform, visible, hidden_from, holdout, shadow_catcher, groups, light_link, shadow_link: as in
    /// add_mesh(). name: the mesh's without it.
    #[pyo3(signature = (mesh, transform = None, *, name = None, visible = None, hidden_from = None, holdout = false,
                        shadow_catcher = false, groups = None, light_link = None, shadow_link = None))]
    #[allow(clippy::too_many_arguments, reason = "they have names in Python")]
    fn add_instance(
        &self,
        mesh: &Bound<'_, Mesh>,
        transform: Option<&Bound<'_, PyAny>>,
        name: Option<String>,
        visible: Option<&Bound<'_, PyAny>>,
        hidden_from: Option<Vec<String>>,
        holdout: bool,
        shadow_catcher: bool,
        groups: Option<Vec<String>>,
        light_link: Option<&Bound<'_, PyDict>>,
        shadow_link: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Mesh> {
        let Mesh { name: of_mesh, index } = mesh.get();
        let name = name.unwrap_or_else(|| of_mesh.clone());
        let links = (groups, light_link, shadow_link);
        let model = model(name, transform, visible, (hidden_from, holdout, shadow_catcher), links)?;
        self.change(|stated| {
            if stated.given.meshes.get(*index).is_none_or(|known| known.name != *of_mesh) {
                return Err(error(format!("mesh `{of_mesh}` is of another scene: add it to this one")));
            }
            stated.given.models.push(GivenModel { mesh: *index, ..model });
            Ok(Mesh { name: of_mesh.clone(), index: *index })
        })
    }

    /// Adds a material: base_color, metallic, roughness, ior, transmission, emission, alpha; pictures: base_color_map, alpha_map,
    /// metallic_map, roughness_map, emission_map, normal_map, bump_map. emission_strength is a factor on emission. Keys of [[material]] in
    /// shot files do as well.
    #[pyo3(signature = (name, **values))]
    fn add_material(&self, name: String, values: Option<Bound<'_, PyDict>>) -> PyResult<Material> {
        if name.is_empty() {
            return Err(error("a material needs a name"));
        }
        let mut stated = values.map_or(Ok(Table::new()), |values| keys::table(&values))?;
        let strength = stated.remove("emission_strength");
        let mut table = Table::new();
        for (word, value) in stated {
            let key =
                MATERIAL_WORDS.iter().find(|(known, _)| *known == word).map_or(word.as_str(), |(_, key)| key);
            table.insert(String::from(key), value);
        }
        if let Some(strength) = strength {
            scale_emission(&mut table, &strength)?;
        }
        table.insert(String::from("name"), Value::String(name.clone()));
        let table = Value::Table(table);
        check("material", &table, true).map_err(|cause| in_words(&cause))?;
        self.change(|stated| {
            if stated.has_material(&name).is_ok() {
                return Err(error(format!("there is a material `{name}` already: choose another name")));
            }
            stated.materials.push(table);
            Ok(Material { name })
        })
    }

    /// Adds a light: "point", "sun" (or "directional"), "spot", "rectangle", "disk" or "sphere".
    ///
    /// Keys are those of [[light]] in shot files: position, direction, target, up, color, power, size, radius, spread, angle, cone, soft, samples,
    /// group, name. transform: (4, 4), in which the light is at the origin and shines along -Z, with Y up, or a dict from frames to these.
    /// keys: a dict from frames to dicts of position, direction, target, up, color, power.
    #[pyo3(signature = (kind, *, transform = None, keys = None, **values))]
    fn add_light(
        &self,
        kind: &str,
        transform: Option<&Bound<'_, PyAny>>,
        keys: Option<&Bound<'_, PyDict>>,
        values: Option<Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let kind = if kind == "sun" { "directional" } else { kind };
        let mut table = values.map_or(Ok(Table::new()), |values| keys::table(&values))?;
        let all = motion::key_tables(transform, keys, |places| motion::of_light(kind, places))?;
        match (&all[..], keys.is_some()) {
            ([(_, place)], false) => {
                table.extend(
                    place
                        .iter()
                        .filter(|(key, _)| *key != "frame")
                        .map(|(key, value)| (key.clone(), value.clone())),
                );
            }
            ([], _) => {}
            _ => {
                // what is the same at all frames stays in the light; what some keys state, all do
                let shared: Vec<(String, Value)> = table
                    .iter()
                    .filter(|(key, _)| OF_LIGHT_KEY.contains(&key.as_str()))
                    .map(|(key, value)| (key.clone(), value.clone()))
                    .collect();
                let key = |(_, mut key): (f64, Table)| {
                    for (name, value) in &shared {
                        key.entry(name.clone()).or_insert_with(|| value.clone());
                    }
                    Value::Table(key)
                };
                table.insert(String::from("key"), Value::Array(all.into_iter().map(key).collect()));
            }
        }
        table.insert(String::from("type"), Value::String(String::from(kind)));
        let table = Value::Table(table);
        check("light", &table, true)?;
        self.change(|stated| {
            stated.lights.push(table);
            Ok(())
        })
    }

    /// Sets the camera. Keys are those of [camera] and [[camera.key]] in shot files: eye, target or rotation, roll, fov, shift, aperture,
    /// focus, cut, projection, height.
    ///
    /// transform: (4, 4), in which the camera looks along -Z with Y up, or a dict from frames to these. keys: a dict from frames to dicts
    /// of such keys.
    #[pyo3(signature = (*, transform = None, keys = None, **values))]
    fn set_camera(
        &self,
        transform: Option<&Bound<'_, PyAny>>,
        keys: Option<&Bound<'_, PyDict>>,
        values: Option<Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let values = values.map_or(Ok(Table::new()), |values| keys::table(&values))?;
        let (mut camera, shared): (Table, Table) =
            values.into_iter().partition(|(key, _)| OF_CAMERA.contains(&key.as_str()));
        let mut all = motion::key_tables(transform, keys, camera_keys)?;
        if all.is_empty() && !camera.contains_key("from") {
            all.push((1.0, Table::from_iter([(String::from("frame"), Value::Float(1.0))])));
        }
        let key = |(_, own): (f64, Table)| {
            let mut key = shared.clone();
            key.extend(own);
            Value::Table(key)
        };
        if !all.is_empty() {
            camera.insert(String::from("key"), Value::Array(all.into_iter().map(key).collect()));
        }
        let camera = Value::Table(camera);
        check("camera", &camera, false)?;
        self.change(|stated| {
            stated.tables.insert(String::from("camera"), camera);
            Ok(())
        })
    }

    /// Sets a clear sky with its sun: elevation, azimuth, turbidity, ground; rotation, power, visible and samples as in [environment].
    #[pyo3(signature = (**values))]
    fn set_sky(&self, values: Option<Bound<'_, PyDict>>) -> PyResult<()> {
        const OF_SKY: [&str; 4] = ["elevation", "azimuth", "turbidity", "ground"];
        let values = values.map_or(Ok(Table::new()), |values| keys::table(&values))?;
        let (sky, mut environment): (Table, Table) =
            values.into_iter().partition(|(key, _)| OF_SKY.contains(&key.as_str()));
        environment.insert(String::from("sky"), Value::Table(sky));
        self.replace("environment", environment)
    }

    /// Sets light from all around: map (.hdr or .exr), rotation, power, visible, samples. Without a map it is that of the background.
    #[pyo3(signature = (**values))]
    fn set_environment(&self, values: Option<Bound<'_, PyDict>>) -> PyResult<()> {
        self.replace("environment", values.map_or(Ok(Table::new()), |values| keys::table(&values))?)
    }

    /// Sets what rays see that hit nothing: color, or zenith, horizon and ground.
    #[pyo3(signature = (**values))]
    fn set_background(&self, values: Option<Bound<'_, PyDict>>) -> PyResult<()> {
        self.replace("background", values.map_or(Ok(Table::new()), |values| keys::table(&values))?)
    }

    /// Sets keys of another table of a shot file: "floor", "fog", "ambient", "stereo", "shutter", "render", "indirect", "occlusion" or "output".
    #[pyo3(signature = (table, **values))]
    fn set(&self, table: &str, values: Option<Bound<'_, PyDict>>) -> PyResult<()> {
        const OTHERS: [&str; 5] = ["camera", "light", "material", "model", "mtl"];
        if OTHERS.contains(&table) {
            return Err(error(format!(
                "[{table}] has a function of its own: see the documentation of Scene"
            )));
        }
        let values = values.map_or(Ok(Table::new()), |values| keys::table(&values))?;
        check(table, &Value::Table(values.clone()), false)?;
        self.change(|stated| {
            stated.put(table, values);
            Ok(())
        })
    }
}

impl Scene {
    fn replace(&self, name: &str, table: Table) -> PyResult<()> {
        let table = Value::Table(table);
        check(name, &table, false)?;
        self.change(|stated| {
            stated.tables.insert(String::from(name), table);
            Ok(())
        })
    }
}

impl Stated {
    /// Fails if no material has this name.
    fn has_material(&self, name: &str) -> Result<(), String> {
        let is_it = |table: &Value| table.get("name").and_then(Value::as_str) == Some(name);
        if self.materials.iter().any(is_it) {
            return Ok(());
        }
        Err(format!("there is no material `{name}` in the scene: add it before the mesh"))
    }
}

/// Name of a material; an empty one for None.
fn name_of(material: &Bound<'_, PyAny>) -> PyResult<String> {
    if material.is_none() {
        return Ok(String::new());
    }
    if let Ok(material) = material.cast::<Material>() {
        return Ok(material.get().name.clone());
    }
    material.extract().map_err(|_| error("a material is what add_material() gives, its name, or None"))
}

/// Names of a list of materials.
fn names_of(materials: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    let list = materials.try_iter().ok().filter(|_| !materials.is_instance_of::<PyString>());
    let list =
        list.ok_or_else(|| error("`materials` must be a list of materials, of their names, or None"))?;
    let mut names = Vec::new();
    for material in list {
        if names.len() == MOST_MATERIALS {
            return Err(error(format!("`materials`: more than {MOST_MATERIALS} of them")));
        }
        names.push(name_of(&material?)?);
    }
    Ok(names)
}

/// Multiplies the emission of a material.
fn scale_emission(table: &mut Table, strength: &Value) -> PyResult<()> {
    let number = |value: &Value| value.as_float().or(value.as_integer().map(|whole| whole as f64));
    let strength = number(strength).ok_or_else(|| error("`emission_strength` must be a number"))?;
    let emission = table.get("ke").cloned().unwrap_or(Value::from(vec![1.0, 1.0, 1.0]));
    let parts = emission.as_array().ok_or_else(|| error("`emission` must be three numbers"))?;
    let scaled = parts.iter().map(|part| number(part).map(|part| Value::Float(part * strength)));
    let scaled: Option<Vec<Value>> = scaled.collect();
    let scaled = scaled.ok_or_else(|| error("`emission` must be three numbers"))?;
    table.insert(String::from("ke"), Value::Array(scaled));
    Ok(())
}

/// Has a message about a material speak of Python's words.
fn in_words(cause: &PyErr) -> PyErr {
    let message = Python::attach(|py| cause.value(py).to_string());
    let (before, list) = message.split_once(" (known here").map_or((message.as_str(), ""), |parts| parts);
    let named = MATERIAL_WORDS.iter().fold(String::from(before), |message, (word, key)| {
        message.replace(&format!("`{key}`"), &format!("`{word}`"))
    });
    if list.is_empty() {
        return error(named);
    }
    let words = MATERIAL_WORDS.iter().map(|(word, _)| *word).chain(["transmission", "emission_strength"]);
    let words: Vec<&str> = words.collect();
    error(format!("{named} (known here: {}, and keys of [[material]] in shot files)", words.join(", ")))
}

//! Which features take part in a shot, by names that a table can show.

use std::collections::BTreeSet;

use toml::{Table, Value};

use crate::files::{SMALL_SHAPES, SMOKE};
use crate::generate::mirrors;
use crate::generate::small::cell_width;
use crate::mtlx::FIRST_OF_EYE;
use crate::trial::Trial;

/// Movers that are a crowd.
const CROWD: usize = 6;

/// Most lights that paths weigh one by one.
const MANY_LIGHTS: usize = 32;

/// The features of a shot and of how it is tried.
pub fn features(trial: &Trial) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut add = |name: String| {
        found.insert(name);
    };
    add(format!("second run: {:?}", trial.variation));
    add(format!("backend {}", trial.backend.name()));
    let shot = &trial.shot;
    for (table, keys) in [
        ("render", &["mode", "filter", "reuse", "base_place", "caustics"][..]),
        ("output", &["background"][..]),
        ("camera", &["projection"][..]),
    ] {
        for key in keys {
            if let Some(text) = get(shot, &[table, key]).and_then(Value::as_str) {
                add(format!("{key} {text}"));
            }
        }
    }
    for key in ["base_every", "cuts", "tree_memory", "overscan", "depth", "reflections", "clamp", "error"] {
        if get(shot, &["render", key]).is_some() {
            add(key.to_string());
        }
    }
    if get(shot, &["render", "samples"]).is_some_and(Value::is_table) {
        add("adaptive samples".into());
    }
    let is_blurred = |camera: &Table| keys_of(camera).any(|key| key.contains_key("aperture"));
    if shot.get("camera").and_then(Value::as_table).is_some_and(is_blurred) {
        add("lens".into());
    }
    if list(shot, "light").count() > MANY_LIGHTS {
        add("many lights".into());
    }
    if list(shot, "material").any(is_smoke) {
        add("smoke".into());
    }
    if list(shot, "material").any(is_filled) {
        add("medium".into());
    }
    let is_of_volume = |model: &Table| model.contains_key("vdb");
    if shot.contains_key("fog") || list(shot, "material").any(fills) || list(shot, "model").any(is_of_volume)
    {
        add("any medium".into());
    }
    for table in ["shutter", "stereo", "background", "floor", "fog"] {
        if shot.contains_key(table) {
            add(table.to_string());
        }
    }
    if let Some(environment) = shot.get("environment").and_then(Value::as_table) {
        let kind = ["map", "sky"].into_iter().find(|key| environment.contains_key(*key));
        add(format!("environment: {}", kind.unwrap_or("background")));
    }
    let paths = get(shot, &["indirect", "paths"]).and_then(Value::as_integer);
    if paths.is_some_and(|paths| paths > 0) {
        add("paths".into());
    }
    if get(shot, &["indirect", "budget"]).is_some() {
        add("budget".into());
    }
    if get(shot, &["ambient", "occluded"]).is_some() {
        add("occlusion".into());
    }
    if let Some(camera) = shot.get("camera").and_then(Value::as_table) {
        add(format!("camera {}", motion(camera, &["eye", "target", "rotation", "fov", "height", "shift"])));
        for (key, name) in
            [("cut", "camera cut"), ("near", "near clipping plane"), ("far", "far clipping plane")]
        {
            if keys_of(camera).any(|table| table.contains_key(key)) {
                add(name.into());
            }
        }
    }
    let models: Vec<&Table> = list(shot, "model").collect();
    if models.iter().any(|model| model.contains_key("subdivision")) {
        add("subdivision".into());
    }
    if list(shot, "material").any(|material| material.contains_key("map_displacement")) {
        add("displacement".into());
    }
    let name = |model: &&Table| model.get("name").and_then(Value::as_str) == Some(mirrors::NAME);
    if models.iter().any(name) {
        add("flat mirrors".into());
    }
    let rests = |model: &Table| ["key", "shapes", "visible"].iter().all(|key| !model.contains_key(*key));
    let is_copied = |model: &&Table| {
        let is_same = |other: &&Table| rests(other) && other.get("obj") == model.get("obj");
        model.contains_key("obj") && rests(model) && models.iter().copied().filter(is_same).count() > 1
    };
    if models.iter().any(is_copied) {
        add("copies at rest".into());
    }
    if models.iter().filter(|model| shape_of(model) == "speck").count() >= CROWD {
        add("crowd of small movers".into());
    }
    let width = cell_width(shot).unwrap_or_default();
    let is_small = |model: &&Table| {
        let scale = model.get("scale").and_then(Value::as_float);
        model.contains_key("obj") && scale.is_some_and(|scale| scale < width)
    };
    if !models.is_empty() && models.iter().all(is_small) {
        add("all is smaller than a cell".into());
    }
    for model in models {
        of_model(model, shot, &mut add);
    }
    for light in list(shot, "light") {
        let kind = light.get("type").and_then(Value::as_str).unwrap_or("light");
        let kind = if light.contains_key("angle") { "sun" } else { kind };
        add(format!("light: {kind}"));
        add(format!("light {}", motion(light, &["position", "direction"])));
        if let Some(power) = ends(light, "power") {
            add(format!("light power {power}"));
        }
        if keys_of(light).any(|key| key.contains_key("color")) {
            add("light changes colour".into());
        }
        for link in ["light_link", "shadow_link"].into_iter().filter(|link| light.contains_key(*link)) {
            add(format!("light: {link}"));
        }
        let sizes = ["size", "radius", "spread", "angle", "cone", "soft"];
        if keys_of(light).any(|key| sizes.iter().any(|size| key.contains_key(*size))) {
            add("light changes its size".into());
        }
    }
    found
}

fn is_smoke(material: &Table) -> bool {
    material.get("mtlx").and_then(Value::as_str) == Some(SMOKE)
}

fn is_filled(material: &Table) -> bool {
    material.keys().any(|key| key.starts_with("volume_"))
}

/// Returns true if a material has a medium.
fn fills(material: &Table) -> bool {
    is_smoke(material) || is_filled(material)
}

/// Shape of the file of a model, without the sizes in its name.
fn shape_of(model: &Table) -> &str {
    let file = ["obj", "gltf"].into_iter().find_map(|key| model.get(key)).and_then(Value::as_str);
    let shape = file.and_then(|file| file.split('-').next()).unwrap_or_default();
    shape.trim_end_matches(|character: char| character.is_ascii_digit() || character == 'x')
}

fn of_model(model: &Table, shot: &Table, add: &mut impl FnMut(String)) {
    let quadric = model.get("quadric").and_then(Value::as_table);
    let file = ["obj", "gltf"].into_iter().find_map(|key| model.get(key)).and_then(Value::as_str);
    let mut parts = file.unwrap_or_default().split('.');
    let named = parts.next().and_then(|name| name.split_once('-'));
    let by_file = parts.next().filter(|_| model.contains_key("gltf"));
    if let Some(motion) = by_file {
        add(format!("model: glTF, {motion}"));
    }
    if let Some(file) = model.get("vdb").and_then(|volume| volume.get("file")?.as_str()) {
        add("model: vdb".into());
        add(format!("vdb {}", motion(model, &["translate", "rotate"])));
        if file.contains('#') {
            add("vdb of frames".into());
        }
        if file.contains('#') || model.contains_key("key") {
            add("a medium changes".into());
        }
        return;
    }
    let curves = model.get("curves").and_then(Value::as_table);
    if let Some(file) = curves.and_then(|curves| curves.get("file")).and_then(Value::as_str) {
        add(format!("curves: {}", file.trim_end_matches(".curves")));
        if model.contains_key("shapes") {
            add("curves deform".into());
        }
        let shapes = model.get("shapes").and_then(|shapes| shapes.get("curves")?.as_str());
        if shapes.is_some_and(|name| name.contains(".1")) {
            add("curves grow".into());
        }
    }
    let quadric = quadric.or(curves);
    let (shape, material) = match quadric {
        Some(quadric) => {
            let text = |key| quadric.get(key).and_then(Value::as_str).unwrap_or_default();
            (if curves.is_some() { "curves" } else { text("type") }, text("material"))
        }
        None => named.unwrap_or_default(),
    };
    let shape = if quadric.is_some() { shape } else { shape_of(model) };
    add(format!("model: {shape}"));
    let moves = motion(model, &["translate", "rotate", "scale", "matrix"]);
    add(format!("model {moves}"));
    let passes = model.contains_key("visible");
    if passes {
        add("model comes or goes".into());
    }
    if SMALL_SHAPES.contains(&shape) {
        let deforms = model.contains_key("shapes") || by_file.is_some();
        let way = if passes {
            "come or go"
        } else if deforms {
            "deform"
        } else {
            moves
        };
        add(format!("small things: {way}"));
    }
    for key in ["shapes", "matrix", "reflection_map"] {
        if model.contains_key(key) {
            add(format!("model: {key}"));
        }
    }
    for kind in model.get("hidden_from").and_then(Value::as_array).into_iter().flatten() {
        add(format!("model: hidden from {} rays", kind.as_str().unwrap_or_default()));
    }
    for role in ["holdout", "shadow_catcher"].into_iter().filter(|role| model.contains_key(*role)) {
        add(format!("model: {role}"));
    }
    for link in ["light_link", "shadow_link"].into_iter().filter(|link| model.contains_key(*link)) {
        add(format!("model: {link}"));
    }
    if material.contains('+') {
        add("small things: of two materials".into());
    }
    let material = material.split('+').next().unwrap_or_default();
    let of_name = |table: &&Table| table.get("name").and_then(Value::as_str) == Some(material);
    let kind = list(shot, "material").find(of_name).map_or("matt", kind_of_material);
    add(format!("material: {kind}"));
    let has = |keys: &[&str]| {
        let stated = list(shot, "material").find(of_name);
        stated.is_some_and(|material| keys.iter().any(|key| material.contains_key(*key)))
    };
    if kind == "hair" && curves.is_some() {
        add("fibres".into());
        if model.contains_key("shapes") {
            add("fibres deform".into());
        }
    }
    let filled = list(shot, "material").find(of_name).is_some_and(fills);
    if filled && (passes || moves != "rests" || model.contains_key("shapes") || by_file.is_some()) {
        add("a medium changes".into());
    }
    if has(&["map_d"]) {
        add(if has(&["alpha_mode"]) { "material: blended" } else { "material: cut out" }.into());
    }
    if has(&["norm", "map_bump"]) {
        add("material: bent normals".into());
    }
    if has(&["mtlx"]) {
        add("material: graph".into());
        let file = list(shot, "material").find(of_name).and_then(|material| material["mtlx"].as_str());
        let number = file.and_then(|name| name.strip_suffix(".mtlx")?.parse::<u64>().ok());
        if number.is_some_and(|number| number >= FIRST_OF_EYE) {
            add("material: graph of the eye".into());
        }
    }
    if has(&["coat"]) {
        add("material: clear coat".into());
    }
    for (key, name) in [
        ("fuzz", "fuzz"),
        ("diffuse_roughness", "rough and matt"),
        ("metal_edge", "metal with edges"),
        ("anisotropy", "brushed"),
        ("subsurface", "subsurface"),
        ("translucency", "translucent"),
        ("depth", "glass that absorbs"),
        ("thin", "a pane"),
        ("ks_total", "glass that reflects in colour"),
    ] {
        if has(&[key]) {
            add(format!("material: {name}"));
        }
    }
    if has(&["map_ke", "map_ks", "map_ns", "map_pr", "map_pm"]) {
        add("material: parameters of pictures".into());
    }
    if kind == "glows" && (passes || moves != "rests" || model.contains_key("shapes") || by_file.is_some()) {
        add("what glows changes".into());
    }
}

fn kind_of_material(material: &Table) -> &'static str {
    let has = |key: &str| material.contains_key(key);
    match material.get("illum").and_then(Value::as_integer) {
        _ if has("hair") => "hair",
        _ if has("ke") => "glows",
        _ if has("pr") => "metal-rough",
        Some(3 | 5) => "mirror",
        Some(4 | 6 | 7 | 9) => "glass",
        Some(2) => "highlight",
        _ if has("d") => "thin",
        _ if has("map_kd") => "textured",
        _ => "matt",
    }
}

/// How any of these values changes from key to key.
fn motion(table: &Table, values: &[&str]) -> &'static str {
    let changes = |value: &&str| {
        let mut said = keys_of(table).filter_map(|key| key.get(*value));
        said.next().is_some_and(|first| said.any(|other| other != first))
    };
    let changing: Vec<&str> = values.iter().copied().filter(|value| changes(value)).collect();
    match changing[..] {
        [] => "rests",
        ["target"] => "turns",
        ["fov" | "height"] => "zooms",
        ["shift"] => "shifts",
        ["rotate" | "rotation"] => "turns",
        ["scale"] => "grows",
        _ => "moves",
    }
}

/// Where a value begins and ends that is nothing at some key.
fn ends(table: &Table, value: &str) -> Option<&'static str> {
    let said: Vec<f64> = keys_of(table).filter_map(|key| key.get(value)?.as_float()).collect();
    let (first, last) = (*said.first()?, *said.last()?);
    Some(match (first == 0.0, last == 0.0) {
        (true, true) if said.iter().any(|power| *power > 0.0) => "from 0 to 0",
        (true, true) => "of 0",
        (true, false) => "from 0",
        (false, true) => "to 0",
        (false, false) if said.contains(&0.0) => "through 0",
        (false, false) => "changes",
    })
}

fn keys_of(table: &Table) -> impl Iterator<Item = &Table> {
    list(table, "key")
}

fn list<'t>(table: &'t Table, key: &str) -> impl Iterator<Item = &'t Table> {
    table.get(key).and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_table)
}

fn get<'t>(table: &'t Table, keys: &[&str]) -> Option<&'t Value> {
    let (first, rest) = keys.split_first()?;
    rest.iter().try_fold(table.get(*first)?, |value, key| value.get(key))
}

//! Makes models of the tables of a shot file: one of an OBJ file, a PLY file or a quadric, and of a glTF or USD file one for each node
//! with a mesh.

use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DAffine3;

use super::places::Place;
use super::readers::Readers;
use super::{curves, links, model, places, quadric, shapes, stage, vdb};
use crate::animation::{Track, TransformTrack};
use crate::scene::import::Inputs;
use crate::scene::import::given;
use crate::scene::import::meshes::read_model::is_ply;
use crate::scene::import::part_of_file::PartOfFile;
use crate::scene::keys::model::Subdivision;
use crate::scene::keys::places::PlacesTable;
use crate::scene::keys::toml_text::{At, TomlText};
use crate::scene::keys::values::file_of;
use crate::scene::keys::{LARGEST_MAP, LEAST_MAP, ModelTable};
use crate::scene::{Mesh, Model, RayKinds, RayVisibility, Role, SceneError};
use crate::subdivision::Scheme;

/// Makes the models of a table; `rate`: frames in a second.
///
/// # Errors With line and column: keys that make no sense together. Errors of the files that it names.
pub fn of_table(
    text: TomlText<'_>,
    table: &At<ModelTable>,
    readers: &mut Readers,
    rate: f64,
) -> Result<Vec<Model>, SceneError> {
    let ray_visibility = ray_visibility(text, table.get_ref())?;
    let models = placed(text, table, readers, rate)?;
    let seen = |model: Model| Model { ray_visibility: model.ray_visibility.and(ray_visibility), ..model };
    links::with_links(text, table.get_ref(), models.into_iter().map(seen).collect())
}

/// Reads what rays see of the models of a table.
fn ray_visibility(text: TomlText<'_>, keys: &ModelTable) -> Result<RayVisibility, SceneError> {
    let kinds = keys.hidden_from.as_ref().map_or(&[][..], |kinds| kinds.get_ref());
    let mut hidden_from = RayKinds::NONE;
    for kind in kinds {
        if hidden_from.has(*kind.get_ref()) {
            return Err(text.bad("hidden_from", kind, "names this kind of rays twice: take one out"));
        }
        hidden_from = hidden_from.with(*kind.get_ref());
    }
    let is_catcher = keys.shadow_catcher.as_ref().filter(|is_catcher| *is_catcher.get_ref());
    let role = match (keys.holdout.unwrap_or(false), is_catcher) {
        (true, Some(catcher)) => {
            let message = "and `holdout` exclude each other: a hole shows no shadows; take one out";
            return Err(text.bad("shadow_catcher", catcher, message));
        }
        (true, None) => Role::Holdout,
        (false, Some(_)) => Role::ShadowCatcher,
        (false, None) => Role::Itself,
    };
    Ok(RayVisibility { hidden_from, role })
}

/// Makes the models of a table, in their places.
fn placed(
    text: TomlText<'_>,
    table: &At<ModelTable>,
    readers: &mut Readers,
    rate: f64,
) -> Result<Vec<Model>, SceneError> {
    let track = model::track(text, table)?;
    let keys = table.get_ref();
    if let Some(given) = readers.given.take() {
        return Ok(given::models(&mut readers.import, &given)?
            .iter()
            .map(|part| of_part(part, part.name.clone(), text.path, &track))
            .collect());
    }
    refuse_keys_together(text, table, readers.meshes.path_read_before().is_some())?;
    refuse_beside_ply(text, keys)?;
    refuse_parts_of_others(text, keys)?;
    refuse_subdivision(text, keys)?;
    let places = keys.places.as_ref();
    let places =
        places.map(|places| places_of(text, keys, places, &mut readers.import.inputs)).transpose()?;
    let models = match (&keys.gltf, &keys.usd, &keys.obj) {
        (Some(gltf), ..) => {
            let path = file_of(text, "gltf", gltf)?;
            let animation = keys.animation.as_ref().map(|name| name.get_ref().as_str());
            let parts = readers.gltf.models(&mut readers.import, &path, animation, rate)?;
            of_parts(keys, &path, &parts, &track)
        }
        (None, Some(usd), _) => {
            let path = file_of(text, "usd", usd)?;
            let choice = stage::choice(text, keys.stage.as_ref().map(At::get_ref))?;
            let parts = readers.usd.models(&mut readers.import, &path, &choice)?;
            let models = of_parts(keys, &path, &parts, &track);
            if keys.subdivision.is_some() { without_cages(models) } else { models }
        }
        (None, None, Some(obj)) if keys.group.is_some() || keys.split.is_some() => {
            parts(text, (table, obj), readers, &track)?
        }
        _ => match &keys.vdb {
            Some(volume) => vdb::of_table(text, (volume, keys.name.as_deref()), &track, &mut readers.import)?,
            None => vec![one(text, table, readers, track)?],
        },
    };
    let sizes = i64::from(LEAST_MAP)..i64::from(LARGEST_MAP) + 1;
    let map = keys.reflection_map.as_ref();
    let reflection_map = map.map(|size| text.whole("reflection_map", size, sizes)).transpose()?;
    if let Some(size) = map.filter(|_| models.iter().any(quadric::is_endless)) {
        let message = "means nothing for a plane, which has no middle: take it out";
        return Err(text.bad("reflection_map", size, message));
    }
    let random = keys.random.as_ref();
    let random = random
        .map(|random| text.number("random", random, "from 0 to 1", |number| (0.0..=1.0).contains(&number)));
    let random = random.transpose()?.unwrap_or(0.0) as f32;
    let models: Vec<Model> =
        models.into_iter().map(|model| Model { reflection_map, random, ..model }).collect();
    match places {
        Some(_) if models.iter().any(quadric::is_endless) => {
            Err(text.fault(table.span(), "a plane has no end: it has no copies; take `places` out"))
        }
        Some(places) => Ok(places::copies(&models, &places)),
        None => Ok(models),
    }
}

/// Reads the places of a model's copies, which say all that keys could say.
fn places_of(
    text: TomlText<'_>,
    keys: &ModelTable,
    places: &At<PlacesTable>,
    inputs: &mut Inputs,
) -> Result<Vec<Place>, SceneError> {
    let other = keys.matrix.as_ref().map(|matrix| ("matrix", matrix.span()));
    if let Some((key, span)) = other.or_else(|| keys.key.first().map(|key| ("key", key.span()))) {
        let message =
            format!("`{key}` and `places` exclude each other: the file of `places` has all matrices");
        return Err(text.fault(span, message));
    }
    places::of_table(text, places.get_ref(), keys.interpolation, inputs)
}

/// Refuses what excludes each other. `is_read`: the model's file was read before, and need not be named.
fn refuse_keys_together(text: TomlText<'_>, table: &At<ModelTable>, is_read: bool) -> Result<(), SceneError> {
    let ModelTable { obj, gltf, usd, ply, quadric, curves, vdb, shapes, animation, .. } = table.get_ref();
    let refuse = |span: Range<usize>, message: &str| Err(text.fault(span, message));
    let files = [("obj", obj), ("gltf", gltf), ("usd", usd)];
    let files = files.iter().filter_map(|(key, file)| Some((*key, file.as_ref()?.span())));
    let quadrics = quadric.iter().map(|quadric| ("quadric", quadric.span()));
    let curved = curves.iter().map(|curves| ("curves", curves.span()));
    let volumes = vdb.iter().map(|volume| ("vdb", volume.span()));
    let kinds: Vec<(&str, Range<usize>)> = files.chain(quadrics).chain(curved).chain(volumes).collect();
    match &kinds[..] {
        [(first, _), .., (last, span)] if !(is_read && kinds.len() == 2 && *first == "obj") => {
            let message = format!("`{first}` and `{last}` exclude each other: write a [[model]] for each");
            return refuse(span.clone(), &message);
        }
        [] if !is_read && ply.is_none() => {
            let message = "the key `obj` is missing: a model is an OBJ file, a glTF file (`gltf`), a USD file (`usd`), a PLY file (`ply`), a `quadric`, `curves`, or an OpenVDB file (`vdb`)";
            return refuse(table.span(), message);
        }
        _ => {}
    }
    if let Some(stage) = table.get_ref().stage.as_ref().filter(|_| usd.is_none()) {
        return refuse(
            stage.span(),
            "`stage` goes with `usd`: it says what of a USD file is read; take it out",
        );
    }
    let other = if gltf.is_some() { "glTF" } else { "USD" };
    match (shapes, animation) {
        (Some(shapes), _) if quadric.is_some() => {
            refuse(shapes.span(), "`shapes` are those of an OBJ file, and a quadric has none: take them out")
        }
        (Some(shapes), _) if curves.is_some() && shapes.get_ref().curves.is_none() => refuse(
            shapes.span(),
            "`shapes` of curves are files of curves: write `shapes = { curves = \"hair.####.npy\" }`",
        ),
        (Some(shapes), _) if vdb.is_some() => {
            let message = "`shapes` are those of an OBJ file, and a volume has none: number its files";
            refuse(shapes.span(), message)
        }
        (Some(shapes), _) if gltf.is_some() || usd.is_some() => {
            let message =
                format!("`shapes` are those of an OBJ file; a {other} file has its own: take them out");
            refuse(shapes.span(), &message)
        }
        (_, Some(animation)) if gltf.is_none() => {
            refuse(animation.span(), "`animation` goes with `gltf`: only glTF files have any; take it out")
        }
        _ => Ok(()),
    }
}

/// Refuses `subdivision` beside what has no cage.
fn refuse_subdivision(text: TomlText<'_>, table: &ModelTable) -> Result<(), SceneError> {
    let ModelTable { usd, ply, gltf, quadric, curves, vdb, group, split, subdivision, .. } = table;
    let Some(subdivision) = subdivision else { return Ok(()) };
    let refuse = |what: &str| Err(text.bad("subdivision", subdivision, what));
    if ply.is_some() || gltf.is_some() || quadric.is_some() || curves.is_some() || vdb.is_some() {
        refuse("goes with `obj`: others have no cages; write the model as OBJ, or take it out")
    } else if group.is_some() || split.is_some() {
        refuse("goes with whole OBJ files: take `group` or `split` out")
    } else if usd.is_some() && *subdivision.get_ref() != Subdivision::None {
        refuse("may be \"none\" beside `usd`, which shows cages as they are: USD files state their own rules")
    } else {
        Ok(())
    }
}

/// Rules that a key means.
fn scheme(subdivision: Subdivision) -> Option<Scheme> {
    match subdivision {
        Subdivision::CatmullClark => Some(Scheme::CatmullClark),
        Subdivision::Loop => Some(Scheme::Loop),
        Subdivision::Bilinear => Some(Scheme::Bilinear),
        Subdivision::None => None,
    }
}

/// Models whose cages are shown as they are.
fn without_cages(models: Vec<Model>) -> Vec<Model> {
    let mut plain: HashMap<*const Mesh, Arc<Mesh>> = HashMap::new();
    let without = |model: Model| {
        let mesh = plain.entry(Arc::as_ptr(&model.mesh));
        let mesh = mesh.or_insert_with(|| Arc::new(Mesh::clone(&model.mesh).without_cage())).clone();
        Model { mesh, ..model }
    };
    models.into_iter().map(without).collect()
}

/// Refuses what excludes a PLY file.
fn refuse_beside_ply(text: TomlText<'_>, table: &ModelTable) -> Result<(), SceneError> {
    let ModelTable { obj, gltf, ply, quadric, curves, vdb, shapes, .. } = table;
    let Some(ply) = ply else { return Ok(()) };
    let others = [
        ("obj", obj.is_some()),
        ("gltf", gltf.is_some()),
        ("quadric", quadric.is_some()),
        ("curves", curves.is_some()),
        ("vdb", vdb.is_some()),
    ];
    if let Some((other, _)) = others.into_iter().find(|(_, is_there)| *is_there) {
        let message = format!("`ply` and `{other}` exclude each other: write a [[model]] for each");
        return Err(text.fault(ply.span(), message));
    }
    match shapes {
        Some(shapes) => {
            let message = "`shapes` are those of an OBJ file: take them out, or write the model as OBJ";
            Err(text.fault(shapes.span(), message))
        }
        None => Ok(()),
    }
}

/// Refuses a file of the other kind: the ending of its path says how it is read.
fn refuse_other_ending(
    text: TomlText<'_>,
    (obj, ply): (Option<&At<String>>, Option<&At<String>>),
    path: &Path,
) -> Result<(), SceneError> {
    match (obj, ply) {
        (_, Some(ply)) if !is_ply(path) => {
            Err(text.bad("ply", ply, &format!("is `{}`: PLY files end in .ply", ply.get_ref())))
        }
        (Some(obj), None) if is_ply(path) => {
            Err(text.bad("obj", obj, "is a PLY file, by its ending: write `ply` instead"))
        }
        _ => Ok(()),
    }
}

/// Refuses `group` and `split` beside what has no parts, or beside each other.
fn refuse_parts_of_others(text: TomlText<'_>, table: &ModelTable) -> Result<(), SceneError> {
    let ModelTable { obj, shapes, group, split, .. } = table;
    let place = group.as_ref().map(|group| ("group", group.span()));
    let place = place.or_else(|| split.as_ref().map(|split| ("split", split.span())));
    let Some((key, span)) = place else { return Ok(()) };
    let refuse = |what: &str| Err(text.fault(span, format!("`{key}` {what}")));
    if obj.is_none() {
        refuse(
            "goes with `obj`: only OBJ files have such parts, and each node of a glTF file is a model already; take it out",
        )
    } else if shapes.is_some() {
        refuse("and `shapes` exclude each other: shapes are those of a whole OBJ file")
    } else if group.is_some() && split.is_some() {
        refuse("and `split` exclude each other: one object or group is not divided again")
    } else {
        Ok(())
    }
}

/// Makes models of parts of an OBJ file, which `track` moves together.
fn parts(
    text: TomlText<'_>,
    (table, obj): (&At<ModelTable>, &At<String>),
    readers: &mut Readers,
    track: &TransformTrack,
) -> Result<Vec<Model>, SceneError> {
    let ModelTable { name, group, split, .. } = table.get_ref();
    let path = file_of(text, "obj", obj)?;
    refuse_other_ending(text, (Some(obj), None), &path)?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let model = |name: String, mesh: &Arc<Mesh>| Model {
        name,
        path: path.clone(),
        mesh: mesh.clone(),
        track: track.clone(),
        to_world: None,
        random: 0.0,
        reflection_map: None,
        ray_visibility: Default::default(),
        linked: Default::default(),
    };
    if let Some(group) = group {
        let part = readers.meshes.part(&mut readers.import, &path, group.get_ref())?;
        let part = part.map_err(|what| text.bad("group", group, &format!("is {what}")))?;
        let own_name = || format!("{stem}/{}", part.name);
        return Ok(vec![model(name.clone().unwrap_or_else(own_name), &part.mesh)]);
    }
    let by = split.as_ref().expect("the caller has one of the two");
    let parts = readers.meshes.divided(&mut readers.import, &path, *by.get_ref())?;
    let parts = parts.map_err(|what| text.bad("split", by, &what))?;
    let whole = name.as_deref().unwrap_or(&stem);
    Ok(parts.iter().map(|part| model(format!("{whole}/{}", part.name), &part.mesh)).collect())
}

/// Makes the model of an OBJ file, a PLY file, a quadric or curves.
fn one(
    text: TomlText<'_>,
    table: &At<ModelTable>,
    readers: &mut Readers,
    mut track: TransformTrack,
) -> Result<Model, SceneError> {
    let ModelTable { name, obj, ply, quadric, curves: of_curves, shapes, subdivision, .. } = table.get_ref();
    let (path, mesh, own_name): (PathBuf, Arc<Mesh>, String) =
        match (readers.meshes.path_read_before(), quadric) {
            (None, Some(quadric)) => {
                let mesh = quadric::of_table(text, quadric, &mut readers.import)?;
                (text.path.to_path_buf(), Arc::new(mesh), String::from(quadric.get_ref().kind.name()))
            }
            (None, None) if of_curves.is_some() => {
                let table = of_curves.as_ref().expect("it is some");
                let path = curves::path_of(text, table)?;
                let shapes = shapes.as_ref();
                let (mesh, shapes) = curves::of_table(text, (table, shapes), &path, &mut readers.import)?;
                track.shapes = shapes;
                let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
                (path, Arc::new(mesh), stem)
            }
            (before, _) => {
                let path = match (before, ply) {
                    (Some(path), _) => path,
                    (None, Some(ply)) => file_of(text, "ply", ply)?,
                    (None, None) => {
                        file_of(text, "obj", obj.as_ref().expect("all others are refused before"))?
                    }
                };
                refuse_other_ending(text, (obj.as_ref(), ply.as_ref()), &path)?;
                let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
                let mesh = match shapes {
                    None => readers.meshes.mesh(&mut readers.import, &path)?,
                    Some(shapes) => {
                        let (mesh, shapes) = shapes::of_table(text, shapes, &path, readers)?;
                        track.shapes = Some(shapes);
                        mesh
                    }
                };
                let scheme = subdivision.as_ref().and_then(|subdivision| scheme(*subdivision.get_ref()));
                let mesh = match scheme {
                    Some(scheme) => readers.meshes.caged(&mut readers.import, &path, mesh, scheme)?,
                    None => mesh,
                };
                (path, mesh, stem)
            }
        };
    Ok(Model {
        name: name.clone().unwrap_or(own_name),
        path,
        mesh,
        track,
        to_world: None,
        random: 0.0,
        reflection_map: None,
        ray_visibility: Default::default(),
        linked: Default::default(),
    })
}

/// Makes the models of a file that holds several, which `track` moves together.
fn of_parts(table: &ModelTable, path: &Path, parts: &[PartOfFile], track: &TransformTrack) -> Vec<Model> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let whole = table.name.as_deref().unwrap_or(&stem);
    parts.iter().map(|part| of_part(part, format!("{whole}/{}", part.name), path, track)).collect()
}

/// Makes the model of a part of a file, which `track` moves.
fn of_part(part: &PartOfFile, name: String, path: &Path, track: &TransformTrack) -> Model {
    Model {
        name,
        path: path.to_path_buf(),
        mesh: part.mesh.clone(),
        track: TransformTrack {
            matrix: together(track.matrix.as_ref(), &part.map),
            visible: track.visible.and(&part.visible),
            shapes: part.shapes.clone(),
            ..track.clone()
        },
        to_world: None,
        random: 0.0,
        reflection_map: None,
        ray_visibility: part.ray_visibility,
        linked: part.linked.clone(),
    }
}

/// The map of a part of a file, and after it that of the whole. `None` if they change nothing.
fn together(whole: Option<&Track<DAffine3>>, part: &Track<DAffine3>) -> Option<Track<DAffine3>> {
    let Some(whole) = whole else {
        let rests = part.is_constant() && part.values().all(|map| map == DAffine3::IDENTITY);
        return (!rests).then(|| part.clone());
    };
    Some(whole.after(part))
}

//! Walks over the prims of a stage, and collects what they show.

mod instances;
mod meshes;
mod surfaces;

use std::collections::HashMap;
use std::rc::Rc;

use glam::{DAffine3, DQuat};
use openusd::pcp::{ArcType, Node};
use openusd::sdf::{Path, Value};
use openusd::usd::{LoadPolicy, Prim, PrimPredicate, PrimStatus, Stage};

use super::binding::Bindings;
use super::choice::StageChoice;
use super::clock::Clock;
use super::file::{Content, ShownMesh, Units};
use super::render::{self, RenderSettings};
use super::resolver::Record;
use super::shader::{BoundSurface, Shaders};
use super::skeleton::Skeleton;
use super::value::{Answer, PrimError, Read, codes_read, said, word};
use super::wanted::Wanted;
use super::{cameras, curves, implicit, lights, place, points, seen, variants, volume};
use crate::animation::{Track, Visibility};
use crate::digest::Digest;

/// Most prims above one another: the time to compose them grows with the cube of their number.
const MOST_LEVELS: usize = 256;

/// Most places of layers (nodes) of which a file's prims are composed, some kilobytes each, and bytes of its layers for each one more: a few
/// bytes that refer twice each compose more than fits into any memory. Those of a prim that has more than usual count several times.
const MOST_NODES: u64 = 1_000_000;
const BYTES_A_NODE: u64 = 2;
const USUAL_NODES: u64 = 16;
const TIMES: u64 = 5;

/// Most models of a file.
const MOST_SHOWN: usize = 4_000_000;

/// Metres in a unit, if the file does not say.
const DEFAULT_UNIT: f64 = 0.01;

/// Things that hold below a prim.
#[derive(Clone)]
struct Context {
    /// Map to the world.
    map: Track<DAffine3>,
    visible: Visibility,
    /// True if purpose is one that is rendered.
    is_rendered: bool,
    /// True below a SkelRoot: nothing else follows skeletons.
    is_skinned: bool,
}

/// A walk, and what it has found.
struct Walk<'a> {
    stage: &'a Stage,
    content: Content,
    units: Units,
    /// Map from the file's units and axes to the world's.
    root: Track<DAffine3>,
    shaders: Shaders<'a>,
    bindings: Bindings,
    /// Meshes of prototypes' prims with their surfaces, which instances share that have the same.
    of_prototypes: HashMap<(String, Vec<Option<usize>>), Option<usize>>,
    /// Surfaces by path of their material, and names of their texture coordinates.
    of_materials: HashMap<String, Option<BoundSurface>>,
    /// Numbers of the meshes by their digest.
    known: HashMap<Digest, Vec<usize>>,
    /// Skeletons by path.
    skeletons: HashMap<String, Option<Rc<Skeleton>>>,
    /// Instancers that are being walked through.
    within: Vec<Path>,
    record: &'a Record,
    /// For prototypes: true if there are instances below.
    has_nested: HashMap<String, bool>,
    /// Places of layers of which the prims so far are composed, see [`MOST_NODES`].
    nodes: u64,
    /// Prim below which places are sought: the root, or what is above the prototype that is being walked through.
    base: Path,
    choice: StageChoice,
    /// True if the file is a shot, so that its settings count.
    is_shot: bool,
    /// Prims that alone are read, with all above and below them; none: all are.
    mask: Vec<Path>,
}

/// Most variant sets that are told.
const MOST_SETS: usize = 4;

/// Frames on either side of those that are read, in which a shutter may be open and vectors of motion end.
const AROUND: f64 = 1.0;

/// Collects all that is wanted of what a stage shows; `wanted` gets the purposes that its settings include, where none are chosen.
///
/// # Errors What the library says, and what is wanted and not there.
pub fn content(stage: &Stage, record: &Record, wanted: &mut Wanted) -> Answer<Content> {
    let clock = clock(stage, wanted.choice.frames)?;
    let render = match &wanted.view {
        Some(view) => render::find(stage, view.settings.as_deref())?
            .map(|prim| render::read(stage, &prim, clock.code(clock.first())))
            .transpose()?,
        None => None,
    };
    if let Some(render) = &render {
        wanted.choice.purposes = wanted.choice.purposes.take().or_else(|| render.purposes.clone());
    }
    let mut note = None;
    if let Some(view) = wanted.view.as_ref().filter(|view| view.only_seen) {
        let chosen = (&wanted.choice, view.camera.as_deref());
        let found = seen::unseen(stage, (&clock, record), chosen, render.as_ref())?;
        wanted.choice.unloaded.extend(found.paths);
        unload(stage, &wanted.choice)?;
        note = Some(found.note);
    }
    let mask = wanted.choice.mask.iter().map(|path| said(Path::new(path))).collect::<Answer<Vec<_>>>()?;
    mask.iter().try_for_each(|path| variants::check_prim(stage, path, "the mask"))?;
    let unit = metadata_number(stage, "metersPerUnit")?.filter(|unit| *unit > 0.0).unwrap_or(DEFAULT_UNIT);
    let is_z_up =
        matches!(said(stage.stage_metadata("upAxis"))?, Some(Value::Token(axis)) if axis.as_str() == "Z");
    let quarter = DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    let turn = if is_z_up { exact(DAffine3::from_quat(quarter)) } else { DAffine3::IDENTITY };
    let map = Track::constant(DAffine3::from_scale(glam::DVec3::splat(unit)) * turn);
    let mut walk = Walk {
        stage,
        content: Content { clock, ..Content::default() },
        units: Units { metres: unit, is_of_blender: is_of_blender(stage)? },
        root: map.clone(),
        shaders: Shaders::new(stage, clock.code(clock.first())),
        bindings: Bindings::in_order(render.as_ref().and_then(|render| render.bindings.as_deref())),
        of_prototypes: HashMap::new(),
        of_materials: HashMap::new(),
        known: HashMap::new(),
        skeletons: HashMap::new(),
        within: Vec::new(),
        record,
        has_nested: HashMap::new(),
        nodes: 0,
        base: Path::abs_root(),
        choice: wanted.choice.clone(),
        is_shot: wanted.view.is_some(),
        mask,
    };
    walk.content.render = render;
    walk.content.note = note;
    if wanted.view.as_ref().is_some_and(|view| view.settings.is_none()) {
        walk.content.defects.extend(render::missing(stage)?);
    }
    let context = Context { map, visible: Visibility::ALWAYS, is_rendered: true, is_skinned: false };
    let roots = said(stage.prim(Path::abs_root()).children())?;
    let shown = walk.below(roots, context, PrimPredicate::DEFAULT_PROXIES)?;
    walk.content.shown = shown;
    if let Some(view) = &wanted.view {
        walk.read_camera(view.camera.as_deref())?;
    }
    let mut content = walk.content;
    if let Some(render) = &mut content.render {
        content.unused.append(&mut render.unused);
    }
    content.unused.append(&mut walk.shaders.unused);
    content.defects.append(&mut walk.shaders.missing);
    if walk.bindings.has_collections {
        content.unused.insert(String::from("materials that collections bind are not used"));
    }
    Ok(content)
}

/// Leaves payloads out.
///
/// # Errors A prim that is not there.
pub fn unload(stage: &Stage, choice: &StageChoice) -> Answer<()> {
    let paths = choice.unloaded.iter().map(|path| said(Path::new(path))).collect::<Answer<Vec<_>>>()?;
    paths.iter().try_for_each(|path| variants::check_prim(stage, path, "the unloaded payloads"))?;
    stage.load_and_unload(std::iter::empty::<(Path, LoadPolicy)>(), paths);
    Ok(())
}

/// A quarter turn without the rounding of sines.
fn exact(map: DAffine3) -> DAffine3 {
    DAffine3::from_cols_array(&map.to_cols_array().map(|number| number.round()))
}

fn metadata_number(stage: &Stage, name: &str) -> Answer<Option<f64>> {
    Ok(match said(stage.stage_metadata(name))? {
        Some(Value::Double(number)) => Some(number),
        Some(Value::Float(number)) => Some(f64::from(number)),
        Some(Value::Int(number)) => Some(f64::from(number)),
        _ => None,
    }
    .filter(|number| number.is_finite()))
}

fn is_of_blender(stage: &Stage) -> Answer<bool> {
    let written = said(stage.stage_metadata("documentation"))?;
    Ok(matches!(written, Some(Value::String(text)) if text.starts_with("Blender")))
}

fn clock(stage: &Stage, read: Option<[i32; 2]>) -> Answer<Clock> {
    let is_rate = |rate: &f64| (1e-3..=1e6).contains(rate);
    let codes = metadata_number(stage, "timeCodesPerSecond")?.filter(is_rate);
    let frames = metadata_number(stage, "framesPerSecond")?.filter(is_rate);
    let rate = frames.or(codes).unwrap_or(24.0);
    let codes = codes.or(frames).unwrap_or(24.0) / rate;
    let (start, end) = (metadata_number(stage, "startTimeCode")?, metadata_number(stage, "endTimeCode")?);
    let range = match (start, end) {
        (Some(start), Some(end)) if start <= end && start.abs().max(end.abs()) < 1e6 * codes => {
            Some([start / codes, end / codes])
        }
        _ => None,
    };
    let read = read.map(|ends| ends.map(f64::from));
    let around = read.map(|[first, last]| [(first - AROUND) * codes, (last + AROUND) * codes]);
    Ok(Clock { rate, codes, range: read.or(range), read: around })
}

impl Walk<'_> {
    /// Collects meshes of these prims and all below them; cameras and lights outside of prototypes.
    fn below(
        &mut self,
        roots: Vec<Prim>,
        context: Context,
        predicate: PrimPredicate,
    ) -> Answer<Vec<ShownMesh>> {
        let mut shown = Vec::new();
        let context = Rc::new(context);
        let mut waiting: Vec<(Prim, Rc<Context>)> =
            roots.into_iter().rev().map(|prim| (prim, context.clone())).collect();
        while let Some((prim, above)) = waiting.pop() {
            // what is asked of a prim composes it, and reads the layers that it refers to
            if !self.is_masked_in(prim.path()) {
                continue;
            }
            self.count_prim(&prim)?;
            let status = said(self.stage.prim_status(prim.path().clone()))?;
            if !predicate.matches(status) {
                continue;
            }
            if status.contains(PrimStatus::INSTANCE) {
                self.open_nested(&prim)?;
            }
            if prim.path().as_str().bytes().filter(|byte| *byte == b'/').count() > MOST_LEVELS {
                return Err(format!("its prims are nested more than {MOST_LEVELS} deep: flatten it"));
            }
            let kind = said(prim.type_name())?.map_or(String::new(), |kind| kind.to_string());
            let own = self.context((&prim, &kind), &above).map_err(PrimError::Damaged);
            let Some(own) = self.or_left_out(&prim, own)?.map(Rc::new) else { continue };
            if self.look((&prim, &kind), &own, &mut shown)? {
                let children = said(prim.children())?;
                if children.is_empty() {
                    self.note_missing(&prim)?;
                }
                self.note_variants(&prim)?;
                waiting.extend(children.into_iter().rev().map(|child| (child, own.clone())));
            }
            if shown.len() > MOST_SHOWN {
                return Err(format!("it shows more than {MOST_SHOWN} models"));
            }
        }
        Ok(shown)
    }

    /// What was read of a prim. `None` if it is damaged: then it is left out, with all below it where that depends on it, and this is told.
    ///
    /// # Errors What nothing can be shown for.
    fn or_left_out<T>(&mut self, prim: &Prim, read: Read<T>) -> Answer<Option<T>> {
        match read {
            Ok(read) => Ok(Some(read)),
            Err(PrimError::Fatal(why)) => Err(why),
            Err(PrimError::Damaged(why)) => {
                self.content.defects.insert(format!("{} is left out: {why}", prim.path()));
                Ok(None)
            }
        }
    }

    /// True for prims in the mask, above it and below it. What prims within name lies anywhere.
    fn is_masked_in(&self, path: &Path) -> bool {
        self.mask.is_empty()
            || !self.within.is_empty()
            || self.mask.iter().any(|of| path.has_prefix(of) || of.has_prefix(path))
    }

    /// Records variant sets of a prim, and what they show.
    fn note_variants(&mut self, prim: &Prim) -> Answer<()> {
        let graph = said(prim.prim_index().graph())?;
        let is_own = |node: &Node| node.arc() == ArcType::Variant && node.path().as_str().ends_with('}');
        if self.content.variants.len() > MOST_SETS || !graph.all_nodes().any(is_own) {
            return Ok(());
        }
        let selected = variants::selected(self.stage, prim.path())?;
        for set in variants::sets(self.stage, prim.path())? {
            let Some((name, variant)) = selected.iter().find(|(name, _)| *name == set.name) else { continue };
            let all = variants::listed(&set.variants);
            self.content.variants.push(match self.content.variants.len() {
                MOST_SETS => String::from("more"),
                _ => format!("{}:{name}={variant} (of {all})", prim.path()),
            });
            if self.content.variants.len() > MOST_SETS {
                break;
            }
        }
        Ok(())
    }

    /// Reads the camera that is chosen or that the settings name, where it is not among those that were met.
    fn read_camera(&mut self, chosen: Option<&str>) -> Answer<()> {
        let of_settings = self.content.render.as_ref().and_then(|render| render.camera.clone());
        let is_chosen = chosen.is_some();
        let Some(name) = chosen.map(String::from).or(of_settings) else { return Ok(()) };
        let known = |walk: &Self| walk.content.cameras.iter().map(|camera| camera.path.clone()).collect();
        let known: Vec<String> = known(self);
        let there = match &known[..] {
            [] => String::from("there is no camera"),
            some => format!("there are {}", variants::listed(some)),
        };
        if !name.starts_with('/') {
            let end = format!("/{name}");
            let found: Vec<String> = known.into_iter().filter(|path| path.ends_with(&end)).collect();
            return match &found[..] {
                [] => Err(format!("the camera `{name}` is not in the file: {there}")),
                [path] => {
                    self.content.camera = Some(path.clone());
                    Ok(())
                }
                some => Err(format!(
                    "the file has several cameras `{name}`: write the path of one, of {}",
                    variants::listed(some)
                )),
            };
        }
        if !known.contains(&name) {
            // below what the mask leaves out
            let path = Path::new(&name).map_err(|error| format!("the camera `{name}`: {error}"))?;
            let prim = self.stage.prim(path.clone());
            let is_camera =
                said(prim.is_valid())? && said_type(self.stage, &path)?.as_deref() == Some("Camera");
            let map = if is_camera { self.map_of(&path)? } else { None };
            let Some(map) = map else {
                if is_chosen {
                    return Err(format!("the camera `{name}` is not in the file: {there}"));
                }
                let of = self.content.render.as_ref().map_or("", |render| render.path.as_str());
                let message = format!(
                    "the camera {name}, which the settings {of} name, is not in the file: the first one is shown; --camera names another                      one ({there})"
                );
                self.content.defects.insert(message);
                return Ok(());
            };
            let file = (&self.content.clock, self.units.metres);
            let camera = cameras::read(&prim, &map, file, &mut self.content.unused)?;
            self.content.cameras.push(camera);
        }
        self.content.camera = Some(name);
        Ok(())
    }

    /// Counts a prim that is looked at.
    fn count_prim(&mut self, prim: &Prim) -> Answer<()> {
        self.record.next_prim()?;
        let nodes = prim.prim_index().graph().map_or(1, |graph| graph.all_nodes().count() as u64);
        self.nodes += nodes + (TIMES - 1) * nodes.saturating_sub(USUAL_NODES);
        if self.nodes > MOST_NODES + self.record.bytes() / BYTES_A_NODE {
            return Err(String::from(
                "its references compose more prims than make sense for layers of this size: refer to each layer once, or copy by point \
                 instancers",
            ));
        }
        Ok(())
    }

    /// Records prims that references and payloads of a prim without children name, and that are nowhere: the library reports payloads
    /// alone.
    fn note_missing(&mut self, prim: &Prim) -> Answer<()> {
        let depth = prim.path().as_str().bytes().filter(|byte| *byte == b'/').count();
        let graph = said(prim.prim_index().graph())?;
        let is_reference = |node: &&Node| matches!(node.arc(), ArcType::Reference | ArcType::Payload);
        let is_own = |node: &&Node| usize::from(node.namespace_depth()) == depth;
        let is_nowhere = |node: &&Node| !node.has_specs() && node.children().is_empty();
        for node in graph.all_nodes().filter(is_reference).filter(is_own).filter(is_nowhere) {
            let message = format!(
                "{}, which {} names, is nowhere: what it brings is missing",
                node.path(),
                prim.path()
            );
            self.content.defects.insert(message);
        }
        Ok(())
    }

    fn context(&mut self, (prim, kind): (&Prim, &str), above: &Rc<Context>) -> Answer<Context> {
        let mut context = Context::clone(above);
        let clock = self.content.clock;
        context.map = self.placed(prim, &above.map)?;
        context.is_skinned |= kind == "SkelRoot";
        if let Some(first) = word(prim, "visibility", clock.code(clock.first()))? {
            let times = codes_read(prim, "visibility", &clock)?;
            let is_there = |code: f64| -> Answer<bool> {
                Ok(word(prim, "visibility", code)?.as_deref() != Some("invisible"))
            };
            let own = match times.is_empty() {
                true => Visibility::through(first != "invisible", Vec::new()),
                false => {
                    let keys = times.iter().map(|code| Ok((clock.frame(*code), is_there(*code)?)));
                    Visibility::through(is_there(times[0])?, keys.collect::<Answer<_>>()?)
                }
            };
            context.visible = context.visible.and(&own.unwrap_or(Visibility::ALWAYS));
        }
        if let Some(purpose) = word(prim, "purpose", clock.code(clock.first()))? {
            context.is_rendered = self.choice.shows(&purpose);
        }
        Ok(context)
    }

    /// Map of a prim that is below one with the map `above`.
    fn placed(&self, prim: &Prim, above: &Track<DAffine3>) -> Answer<Track<DAffine3>> {
        Ok(match place::place(prim, &self.content.clock)? {
            Some(place) if place.is_reset => self.root.after(&place.map),
            Some(place) => above.after(&place.map),
            None => above.clone(),
        })
    }

    /// Map of the prim at a path, which need not have been walked over. `None` if it is not below what is walked through.
    fn map_of(&self, path: &Path) -> Answer<Option<Track<DAffine3>>> {
        let (mut below, mut at) = (Vec::new(), path.clone());
        while at != self.base {
            below.push(self.stage.prim(at.clone()));
            let Some(parent) = at.parent() else { return Ok(None) };
            at = parent;
        }
        let mut map =
            if self.within.is_empty() { self.root.clone() } else { Track::constant(DAffine3::IDENTITY) };
        for prim in below.iter().rev() {
            map = self.placed(prim, &map)?;
        }
        Ok(Some(map))
    }

    /// Collects what a prim shows itself. Returns true if what is below it counts as well.
    fn look(
        &mut self,
        (prim, kind): (&Prim, &str),
        context: &Context,
        shown: &mut Vec<ShownMesh>,
    ) -> Answer<bool> {
        let is_seen = context.is_rendered && !context.visible.is_never();
        let name = prim.path().as_str().trim_start_matches('/');
        let visible = &context.visible;
        let of = |mesh, map| ShownMesh { name: name.to_string(), mesh, map, visible: visible.clone() };
        match kind {
            "Mesh" if is_seen => {
                let read = self.mesh(prim, context);
                let read = self.or_left_out(prim, read)?.flatten();
                shown.extend(read.map(|(mesh, map)| of(mesh, map)));
            }
            "BasisCurves" | "Points" if is_seen => {
                let at = if kind == "Points" { points::at } else { curves::at };
                let read = self
                    .surfaces(prim)
                    .and_then(|surfaces| curves::curves((prim, at), &surfaces, &mut self.content));
                let read = self.or_left_out(prim, read.map_err(PrimError::Damaged))?;
                for (curves, there) in read.into_iter().flatten() {
                    let number = self.number_of(curves);
                    let one = of(number, context.map.clone());
                    shown.push(ShownMesh { visible: one.visible.and(&there), ..one });
                }
            }
            "Volume" if is_seen => {
                let (clock, metres) = (self.content.clock, self.units.metres);
                let read = self.surfaces(prim).and_then(|surfaces| {
                    let of_stage = (surfaces.of_mesh, metres);
                    volume::volumes((prim, self.stage), &clock, of_stage, &mut self.content.unused)
                });
                let read = self.or_left_out(prim, read.map_err(PrimError::Damaged))?;
                for (volume, there) in read.into_iter().flatten() {
                    let one = of(self.number_of(volume), context.map.clone());
                    shown.push(ShownMesh { visible: one.visible.and(&there), ..one });
                }
            }
            kind if implicit::is_shape(kind) && is_seen => {
                let clock = self.content.clock;
                let read = self.surfaces(prim).and_then(|surfaces| {
                    implicit::mesh((prim, kind), &clock, surfaces.of_mesh, &mut self.content.unused)
                });
                let read = self.or_left_out(prim, read.map_err(PrimError::Damaged))?.flatten();
                shown.extend(read.map(|mesh| of(self.number_of(mesh), context.map.clone())));
            }
            "PointInstancer" => {
                if is_seen {
                    self.copies(prim, context, shown)?;
                }
                return Ok(false);
            }
            "Camera" if self.within.is_empty() => {
                let file = (&self.content.clock, self.units.metres);
                let camera = cameras::read(prim, &context.map, file, &mut self.content.unused);
                let camera = self.or_left_out(prim, camera.map_err(PrimError::Damaged))?;
                self.content.cameras.extend(camera);
            }
            kind if lights::is_light(kind) && self.within.is_empty() => {
                self.content.has_lights = true;
                let file = (&self.content.clock, self.units);
                if is_seen {
                    let place = (&context.map, visible);
                    let read = lights::read((prim, kind), place, file, &mut self.shaders);
                    let read = self.or_left_out(prim, read.map_err(PrimError::Damaged))?;
                    self.content.lights.extend(read.into_iter().flatten());
                }
            }
            "RenderSettings" if self.content.render.is_none() && self.is_shot => {
                self.content.render = Some(self.settings_met(prim)?);
            }
            // materials are read when they are bound
            "Material" | "Shader" | "NodeGraph" | "GeomSubset" => return Ok(false),
            kind => self.note_unused(kind, is_seen),
        }
        Ok(true)
    }

    /// Reads settings that lie elsewhere than where they belong: the first ones that are met.
    fn settings_met(&mut self, prim: &Prim) -> Answer<RenderSettings> {
        let mut settings =
            render::read(self.stage, prim, self.content.clock.code(self.content.clock.first()))?;
        if settings.purposes.take().is_some() || settings.bindings.take().is_some() {
            settings.unused.insert(format!(
                "includedPurposes and materialBindingPurposes of {} are not used: name it by renderSettingsPrimPath, or put it below /Render",
                prim.path()
            ));
        }
        Ok(settings)
    }

    fn note_unused(&mut self, kind: &str, is_seen: bool) {
        let what = match kind {
            "NurbsCurves" | "HermiteCurves" => "NURBS and Hermite curves are",
            "NurbsPatch" => "NURBS patches are",
            "CylinderLight" | "GeometryLight" | "PortalLight" | "PluginLight" => {
                let message = format!("lights of the type {kind} are not used");
                self.content.unused.insert(message);
                return;
            }
            _ => return,
        };
        if is_seen {
            self.content
                .unused
                .insert(format!("{what} not shown: only meshes, curves, spheres, cubes and the like are"));
        }
    }
}

/// Type of the prim at a path, if there is a prim.
fn said_type(stage: &Stage, path: &Path) -> Answer<Option<String>> {
    Ok(said(stage.prim(path.clone()).type_name())?.map(|kind| kind.to_string()))
}

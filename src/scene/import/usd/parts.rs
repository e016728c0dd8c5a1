//! The models of a USD file: one for each mesh that it shows.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;

use super::choice::StageChoice;
use super::file::{Content, ShownMesh, UsdFile, UsdMesh, UsdVolume};
use super::links;
use super::reading::Reading;
use crate::animation::ShapeTrack;
use crate::graph::Input;
use crate::scene::cage::Cage;
use crate::scene::import::Import;
use crate::scene::import::curves::{self, CurveSet};
use crate::scene::import::deformed;
use crate::scene::import::deformed::{Distinct, Kept};
use crate::scene::import::part_of_file::{NodeTrack, PartOfFile, Surface};
use crate::scene::import::vdb;
use crate::scene::surface::{self, Volume};
use crate::scene::{Linked, Mesh, SceneError};

/// Files that were read, and what was made of them.
#[derive(Default)]
pub(in crate::scene) struct UsdFiles {
    /// Files that were read, and not asked for yet.
    before: HashMap<Known, Arc<UsdFile>>,
    parts: HashMap<Known, Arc<Vec<PartOfFile>>>,
}

impl UsdFiles {
    /// Adds a file that was read in advance.
    pub fn with(mut self, file: Arc<UsdFile>) -> Self {
        self.before.insert(known_as(&file.path, &file.choice), file);
        self
    }
}

/// Names of materials that are told for one thing that is left out, at most.
const MOST_TOLD: usize = 3;

/// A mesh, and its shapes over time, if it deforms.
type BuiltMesh = (Arc<Mesh>, Option<ShapeTrack>);

/// A file, and what of it is read.
type Known = (PathBuf, StageChoice);

fn known_as(path: &Path, choice: &StageChoice) -> Known {
    (path.canonicalize().unwrap_or_else(|_| path.to_path_buf()), choice.clone())
}

impl UsdFiles {
    /// The models of what is chosen of the USD file at `path`.
    ///
    /// # Errors A file that cannot be read, is damaged, or shows nothing; a choice of what it does not have; in a strict load also a file
    /// that names what is missing.
    pub fn models(
        &mut self,
        import: &mut Import,
        path: &Path,
        choice: &StageChoice,
    ) -> Result<Arc<Vec<PartOfFile>>, SceneError> {
        let known = known_as(path, choice);
        if let Some(parts) = self.parts.get(&known) {
            return Ok(parts.clone());
        }
        let file = match self.before.remove(&known) {
            Some(file) => file,
            None => Arc::new(UsdFile::open(path, choice, None)?),
        };
        import.inputs.add(file.files.iter().cloned(), file.digest);
        let parts = Arc::new(Reading::new(&file, import).models()?);
        self.parts.insert(known, parts.clone());
        Ok(parts)
    }
}

impl Reading<'_> {
    /// The models of the file.
    fn models(mut self) -> Result<Vec<PartOfFile>, SceneError> {
        let built = self.meshes()?;
        let Self { file, import, unused, left_out } = self;
        let parts: Vec<PartOfFile> =
            file.content.shown.iter().filter_map(|shown| part(&file.content, shown, &built)).collect();
        for defect in &file.content.defects {
            import.findings.stand_in(file.fault(defect))?;
        }
        let unused: BTreeSet<&str> =
            unused.into_iter().chain(file.content.unused.iter().map(String::as_str)).collect();
        unused.into_iter().for_each(|message| import.findings.note(file.fault(message)));
        for (said, materials) in left_out {
            import.findings.note(file.fault(format!("{}: {said}", named(&materials))));
        }
        if parts.is_empty() {
            let why = file.content.defects.first().map_or(String::new(), |defect| format!(" ({defect})"));
            return Err(
                file.fault(format!("it shows no meshes with triangles, which alone can be rendered{why}"))
            );
        }
        Ok(parts)
    }

    /// Builds the meshes of the file.
    fn meshes(&mut self) -> Result<Vec<Option<BuiltMesh>>, SceneError> {
        let file = self.file;
        let mut materials: HashMap<Option<usize>, u16> = HashMap::new();
        let mut built = Vec::with_capacity(file.content.meshes.len());
        for mesh in &file.content.meshes {
            if let Some(curves) = &mesh.curves {
                let name = self.named(built.len()).to_string();
                built.push(self.curves((mesh, &name), curves, &mut materials)?);
                continue;
            }
            if let Some(volume) = &mesh.volume {
                built.push(self.volume(mesh, volume)?);
                continue;
            }
            let mut shapes = Distinct::default();
            mesh.shapes.iter().for_each(|(frame, points)| shapes.add(*frame, mesh.of_vertices(points)));
            let (mut triangles, mut uses) = (mesh.triangles.clone(), mesh.uses.clone());
            let kept = (!shapes.list.is_empty())
                .then(|| deformed::most_open(&mesh.positions, &mesh.triangles, &shapes));
            if let Some(kept) = kept {
                let positions = kept.among(&shapes).unwrap_or(&mesh.positions);
                deformed::remove_closed(positions, &mut triangles, &mut uses);
            }
            if triangles.is_empty() {
                built.push(None);
                continue;
            }
            let (mut runs, mut begin) = (Vec::with_capacity(uses.len()), 0);
            for (count, surface) in &uses {
                let index = match materials.get(surface) {
                    Some(index) => *index,
                    None => {
                        let index = self.material(*surface)?;
                        materials.insert(*surface, index);
                        index
                    }
                };
                runs.push((begin..begin + count, index));
                begin += count;
            }
            let UsdMesh { positions, normals, uvs, second_uvs, colors, point_of, .. } = mesh;
            let surface = Surface {
                positions: positions.clone(),
                normals: normals.clone(),
                uvs: uvs.clone(),
                second_uvs: second_uvs.clone(),
                colors: colors.clone(),
                triangles,
                ..Surface::default()
            };
            let own = self.import.arranger().mesh_of_runs(surface, runs);
            let cage = mesh.cage.as_ref().map(|cage| {
                let of_faces =
                    cage.surface_of.iter().map(|surface| materials.get(surface).copied().unwrap_or(0));
                let deformed = kept.map(|kept| CageShapes::of(&mesh.shapes, &shapes, kept));
                Arc::new(deformed.unwrap_or_default().put_into(&cage.cage, of_faces.collect()))
            });
            let (mesh, shapes) = match kept {
                Some(kept) => deformed::with_shapes(own, shapes, kept, point_of),
                None => (own, None),
            };
            built.push(Some((Arc::new(mesh.with_cage(cage)), shapes)));
        }
        Ok(built)
    }
}

/// Points of a cage that deforms.
#[derive(Default)]
struct CageShapes {
    /// In the shape in which samples are kept; none: those of the file.
    own: Option<Vec<[f32; 3]>>,
    /// In each of its shapes; none if it has one alone.
    all: Vec<Vec<[f32; 3]>>,
}

impl CageShapes {
    /// Takes the points by the numbers that the shapes of vertices have.
    fn of(points: &[(f64, Vec<[f32; 3]>)], shapes: &Distinct, kept: Kept) -> Self {
        let first = |number: u32| shapes.keys.iter().position(|(_, of)| *of == number);
        let points =
            |number: usize| first(number as u32).map(|key| points[key].1.clone()).unwrap_or_default();
        let own = match kept {
            Kept::AtRest => None,
            Kept::Shape(number) => Some(points(number)),
        };
        let count = shapes.list.len();
        Self { own, all: if count > 1 { (0..count).map(points).collect() } else { Vec::new() } }
    }

    fn put_into(self, cage: &Cage, material_of: Vec<u16>) -> Cage {
        let own = self.own.unwrap_or_else(|| cage.points.clone());
        Cage { points: own, shapes: self.all, material_of, ..cage.clone() }
    }
}

impl Reading<'_> {
    /// Builds a volume, if it can be read: it scatters as much light as it is dense, unless a table of its material says otherwise.
    fn volume(&mut self, mesh: &UsdMesh, volume: &UsdVolume) -> Result<Option<BuiltMesh>, SceneError> {
        let surface = mesh.uses.first().and_then(|(_, surface)| *surface);
        let bound = surface.and_then(|number| self.file.content.surfaces.get(number));
        let name = bound.map_or(&volume.name, |bound| &bound.name);
        self.import.surfaces.known_names.push(name.clone());
        let scatter = Input::Constant(Vec3::splat((1.0 / volume.metres) as f32));
        let none = Input::Constant(Vec3::ZERO);
        let mut own = surface::Surface::matt(name, Vec3::ZERO);
        (own.volume, own.has_surface) =
            (Some(Volume { scatter, absorb: none, emit: none, anisotropy: 0.0 }), false);
        let laid = self.import.lay_tables_over(own)?;
        let settled = self.import.settle(laid);
        let material = self.import.surfaces.add_of(&self.file.path, settled)?;
        let read = vdb::read(self.import, &volume.path, Some(&volume.grids)).and_then(|read| {
            let mesh = vdb::mesh_of(self.import, read, material);
            mesh.map_err(|what| SceneError::new(&volume.path, what))
        });
        match read {
            Ok(mesh) => Ok(Some((Arc::new(mesh), None))),
            Err(why) => {
                self.import.findings.stand_in(why)?;
                Ok(None)
            }
        }
    }

    /// Builds curves, if there are any to be drawn.
    fn curves(
        &mut self,
        (mesh, name): (&UsdMesh, &str),
        curves: &CurveSet,
        materials: &mut HashMap<Option<usize>, u16>,
    ) -> Result<Option<BuiltMesh>, SceneError> {
        let surface = mesh.uses.first().and_then(|(_, surface)| *surface);
        let material = match materials.get(&surface) {
            Some(index) => *index,
            None => {
                let index = self.material(surface)?;
                materials.insert(surface, index);
                index
            }
        };
        match curves::mesh_of(self.import, &self.file.path, curves, (None, None), material) {
            Ok((mesh, shapes)) => Ok(Some((Arc::new(mesh), shapes))),
            Err(why) => {
                self.import
                    .findings
                    .stand_in(self.file.fault(format!("/{name} is left out: {}", why.message)))?;
                Ok(None)
            }
        }
    }

    /// Name of a model that shows a mesh.
    fn named(&self, mesh: usize) -> &str {
        self.file.content.shown.iter().find(|shown| shown.mesh == mesh).map_or("", |shown| &shown.name)
    }
}

/// Names of materials, as they are told.
fn named(materials: &BTreeSet<String>) -> String {
    let first: Vec<String> = materials.iter().take(MOST_TOLD).map(|name| format!("`{name}`")).collect();
    match materials.len() {
        1 => format!("material {}", first[0]),
        count if count > MOST_TOLD => {
            format!("materials {} and {} more", first.join(", "), count - MOST_TOLD)
        }
        _ => format!("materials {}", first.join(", ")),
    }
}

/// Model of a shown mesh. `None` if it is scaled to nothing for ever, or has no triangles.
fn part(content: &Content, shown: &ShownMesh, built: &[Option<BuiltMesh>]) -> Option<PartOfFile> {
    let keys = match shown.map.is_constant() {
        true => vec![(1.0, shown.map.at(1.0))],
        false => shown.map.frames().zip(shown.map.values()).collect(),
    };
    let NodeTrack { map, visible } = NodeTrack::through(keys, &[])?;
    let (mesh, shapes) = built[shown.mesh].clone()?;
    let visible = visible.and(&shown.visible);
    Some(PartOfFile {
        name: shown.name.clone(),
        mesh,
        map,
        visible,
        shapes,
        ray_visibility: Default::default(),
        linked: Linked { groups: links::groups(content, &shown.name).into(), ..Linked::default() },
    })
}

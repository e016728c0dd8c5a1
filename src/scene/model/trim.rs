//! Trims triangles that are cut out to what is there of them.
//!
//! A leaf covers a half of its quad. A ray that passes beside it meets the quad all the same, asks the picture, and goes on. So quads are
//! trimmed before anything else is done with them: to the [outline](crate::scene::cutout::outline) of their part of the picture, a
//! polygon of at most eight edges. What rays meet stays the same, as nothing is there of what is left out.
//!
//! Triangles that share vertices are an *island*, which has one outline. Where its triangles meet, new vertices are on the
//! edge that they share: each is computed once, so that no gap opens.

mod pieces;

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;

use glam::{DVec2, Vec3};

use crate::scene::cutout::outline::{HalfPlane, Outline, Part};
use crate::scene::cutout::{CutTriangles, Mask};
use crate::scene::{Mesh, Model, Triangles};
use pieces::{Outlined, Pieces};

/// Number of triangles that trimming may add to a shot: some 150 MiB.
const MOST_ADDED: usize = 1 << 20;

/// Number of squares of pictures that are looked at for a mesh: some tenths of a second.
const MOST_SQUARES: u64 = 1 << 27;

/// Share of an island's way across that a half plane must cut off to be worth an edge.
const LEAST_CUT: f64 = 0.02;

/// Size of an island, in units of its largest coordinate, below which it is not trimmed: its vertices are rounded to 6e-8 of that, and
/// parts of it would not lie in one plane.
const LEAST_SIZE: f64 = 1e-4;

/// Trims the meshes of models, each mesh once.
pub fn trimmed(models: Vec<Model>) -> Vec<Model> {
    let mut room = MOST_ADDED;
    let mut known: HashMap<*const Mesh, Arc<Mesh>> = HashMap::new();
    let trimmed = |model: Model| {
        let mesh = match known.entry(Arc::as_ptr(&model.mesh)) {
            Entry::Occupied(entry) => Arc::clone(entry.get()),
            Entry::Vacant(entry) => {
                let mesh =
                    trimmed_mesh(&model.mesh, &mut room).map_or_else(|| Arc::clone(&model.mesh), Arc::new);
                Arc::clone(entry.insert(mesh))
            }
        };
        Model { mesh, ..model }
    };
    // all of the former meshes live until the last one is known: addresses are not used twice
    let former: Vec<Arc<Mesh>> = models.iter().map(|model| Arc::clone(&model.mesh)).collect();
    let models = models.into_iter().map(trimmed).collect();
    drop(former);
    models
}

/// Trims a mesh, adding no more triangles than there is `room`. `None` if it stays as it is.
fn trimmed_mesh(mesh: &Mesh, room: &mut usize) -> Option<Mesh> {
    let (all, cut) = (mesh.as_triangles().filter(|all| all.shapes.is_none())?, mesh.cut.as_deref()?);
    let islands = Islands::of(all, cut);
    if islands.0.is_empty() {
        return None;
    }
    let mut pieces = Pieces::new(mesh, all);
    let mut outlines = Outlines::default();
    for (number, triangles) in islands.0.iter().enumerate() {
        let Some(halves) = outlines.of(all, cut, triangles) else { continue };
        pieces.trim(triangles, number as u32, &halves, room);
    }
    pieces.finish(cut)
}

/// Triangles by island: those that are connected by vertices, and cut by one picture.
struct Islands(Vec<Vec<Outlined>>);

impl Islands {
    fn of(all: &Triangles, cut: &CutTriangles) -> Self {
        let masks = cut.range().zip(&cut.mask_of).map(|(number, mask)| (number, usize::from(*mask)));
        let mut groups = Connected::new(all.positions.as_slice().len());
        for (number, _) in masks.clone() {
            let [a, b, c] = all.corners[number];
            groups.connect(a, b);
            groups.connect(b, c);
        }
        let mut islands: Vec<Vec<Outlined>> = Vec::new();
        let mut known: HashMap<(u32, usize), usize> = HashMap::new();
        for (number, mask) in masks {
            let corners = all.corners[number];
            let texel = |corner: u32| cut.masks[mask].texel_of(*all.uvs.get(corner as usize)?);
            let [Some(a), Some(b), Some(c)] = corners.map(texel) else { continue };
            let island = *known.entry((groups.first_of(corners[0]), mask)).or_insert_with(|| {
                islands.push(Vec::new());
                islands.len() - 1
            });
            islands[island].push(Outlined { number, texels: [a, b, c] });
        }
        Self(islands)
    }
}

/// Vertices that are connected by edges: each one's way to the first of all that it is connected with.
struct Connected(Vec<u32>);

impl Connected {
    fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    fn first_of(&mut self, mut vertex: u32) -> u32 {
        while self.0[vertex as usize] != vertex {
            // ways become shorter as they are gone
            let next = self.0[self.0[vertex as usize] as usize];
            self.0[vertex as usize] = next;
            vertex = next;
        }
        vertex
    }

    fn connect(&mut self, a: u32, b: u32) {
        let [a, b] = [self.first_of(a), self.first_of(b)];
        self.0[a.max(b) as usize] = a.min(b);
    }
}

/// Outlines of parts of pictures, each found once: many leaves show the same part.
#[derive(Default)]
struct Outlines {
    known: HashMap<(usize, Part), Option<Outline>>,
    /// Number of squares that were looked at.
    squares: u64,
}

impl Outlines {
    /// Half planes that hold all that is there of an island; `None` if it is not to be trimmed.
    fn of(&mut self, all: &Triangles, cut: &CutTriangles, island: &[Outlined]) -> Option<Vec<HalfPlane>> {
        let corners = || island.iter().flat_map(|triangle| triangle.texels);
        if !corners().all(|texel| texel.abs().max_element() < 1e6) {
            return None;
        }
        let low = corners().fold(DVec2::INFINITY, DVec2::min);
        let high = corners().fold(DVec2::NEG_INFINITY, DVec2::max);
        let part = Part::between(low, high);
        let mask = usize::from(cut.mask_of[island[0].number - cut.range().start]);
        let is_smooth = island.iter().all(|triangle| has_normals(all, triangle.number));
        if !is_smooth || is_too_small(all, island) {
            return None;
        }
        let outline = match self.known.entry((mask, part)) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => {
                self.squares = self.squares.saturating_add(part.count());
                let asked: Option<&Mask> = (self.squares <= MOST_SQUARES).then_some(&cut.masks[mask]);
                entry.insert(asked.and_then(|mask| mask.outline(part)))
            }
        };
        match outline.as_ref()? {
            // all of it is beyond this
            Outline::Nothing => Some(vec![HalfPlane { normal: DVec2::ZERO, end: -1.0 }]),
            Outline::Within(halves) => {
                let cuts = |half: &HalfPlane| {
                    let beyond = || corners().map(|corner| half.beyond(corner));
                    let (low, high) = (beyond().fold(f64::INFINITY, f64::min), beyond().fold(0.0, f64::max));
                    high > LEAST_CUT * (high - low)
                };
                Some(halves.iter().copied().filter(cuts).collect())
            }
        }
    }
}

/// Returns false if a corner of a triangle has a normal of no use: then the face's own counts all over it, and parts of it must not
/// mix that with others.
fn has_normals(Triangles { corners, normals, .. }: &Triangles, triangle: usize) -> bool {
    normals.is_empty() || corners[triangle].iter().all(|corner| normals[*corner as usize] != Vec3::ZERO)
}

/// Returns true if an island is so small, where it is, that parts of it would not lie in one plane.
fn is_too_small(all: &Triangles, island: &[Outlined]) -> bool {
    let nothing = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (low, high) = island
        .iter()
        .flat_map(|triangle| all.positions_of(triangle.number as u32))
        .fold(nothing, |(low, high): (Vec3, Vec3), corner| (low.min(corner), high.max(corner)));
    let largest = low.abs().max(high.abs()).max_element();
    f64::from((high - low).max_element()) < LEAST_SIZE * f64::from(largest)
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use embree::VertexBuffer;
    use glam::{DMat2, DVec3, Vec2};
    use half::f16;

    use super::*;
    use crate::animation::TransformTrack;
    use crate::changes::world::model;
    use crate::scene::cutout::{Asks, Cutout, CutoutTest, LEAST_OPACITY};
    use crate::scene::details::{Details, Tangents};
    use crate::scene::mesh::Groups;
    use crate::scene::texture::Mapping;
    use crate::scene::{Geometry, Texture};

    /// Texels along an edge of the pictures.
    const TEXELS: u32 = 32;

    /// A leaf in the middle of its picture: a slanted ellipse.
    fn is_leaf(x: u32, y: u32) -> bool {
        let place = (DVec2::new(x.into(), y.into()) + 0.5) / f64::from(TEXELS) - 0.5;
        DVec2::new(place.x + place.y, (place.x - place.y) * 2.5).length() < 0.55
    }

    /// A quad of two triangles that a picture cuts, then a whole triangle beside it.
    fn mesh(is_there: impl Fn(u32, u32) -> bool) -> Mesh {
        let alpha = |i: u32| if is_there(i % TEXELS, i / TEXELS) { 255 } else { 0 };
        let texels: Arc<[[u8; 4]]> = (0..TEXELS * TEXELS).map(|i| [0, 0, 0, alpha(i)]).collect();
        let texture = Texture::of_bytes(PathBuf::new(), [TEXELS; 2], texels, Mapping::default());
        let mask = Mask::new(Cutout::by_picture(0, LEAST_OPACITY), Some(texture));
        let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0], [5.0, 0.0], [6.0, 0.0], [5.0, 1.0]];
        let position = |[x, y]: [f32; 2]| [x, y, 0.25 * x - 0.5 * y];
        let normals = corners.map(|[x, y]| Vec3::new(0.1 * x, 0.2 * y, 1.0).normalize());
        let mut groups = Groups::named(["quad", "gone", "other"].map(String::from).into_iter());
        [0, 2].into_iter().for_each(|group| groups.begin(group, group));
        let tangents = [[0, 1, 2], [0, 2, 3], [4, 5, 6]].map(|triangle: [usize; 3]| {
            let places = triangle.map(|corner| Vec3::from(position(corners[corner])));
            Tangents::new(
                places,
                triangle.map(|corner| normals[corner]),
                [Vec3::new(1.0, 0.3, 0.0); 3],
                false,
            )
        });
        Mesh {
            geometry: Geometry::Triangles(Triangles {
                normals: normals.to_vec(),
                uvs: corners.map(|[x, y]| Vec2::new(x / 2.0, y)).to_vec(),
                ..Triangles::new(corners.map(position).to_vec(), vec![[0, 1, 2], [0, 2, 3], [4, 5, 6]])
            }),
            shadow_casting: 2,
            material_of: vec![7, 7, 8],
            groups: Arc::new(groups),
            cut: Some(Arc::new(CutTriangles { first: 0, mask_of: vec![0, 0], masks: vec![mask] })),
            details: Arc::new(Details {
                colors: corners.map(|[x, y]| [x / 6.0, y, 0.5].map(f16::from_f32)).to_vec(),
                second_uvs: corners.map(|[x, y]| Vec2::new(y, x)).to_vec(),
                alphas: Vec::new(),
                tangents: tangents.to_vec(),
                space: None,
                volume: None,
                cage: None,
            }),
        }
    }

    fn trim(mesh: &Mesh) -> Option<Mesh> {
        trimmed_mesh(mesh, &mut 1000)
    }

    /// Triangle of `mesh` that has the place, with the weights of its second and third corner.
    fn met(mesh: &Mesh, place: DVec2) -> Option<(usize, DVec2)> {
        let corner = |corner: u32| {
            let [x, y, _] = mesh.triangles().positions.as_slice()[corner as usize];
            DVec2::new(x.into(), y.into())
        };
        let weights = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(corner);
            DMat2::from_cols(b - a, c - a).inverse() * (place - a)
        };
        mesh.triangles()
            .corners
            .iter()
            .map(weights)
            .enumerate()
            .find(|(_, w)| w.min_element() >= 0.0 && w.x + w.y <= 1.0)
    }

    /// What a surface has at a place: texture coordinates of both sets, normal, colour and tangent.
    fn surface(mesh: &Mesh, (triangle, w): (usize, DVec2)) -> Vec<f64> {
        let all = mesh.triangles();
        let corners = all.corners[triangle].map(|corner| corner as usize);
        let weights = [1.0 - w.x - w.y, w.x, w.y];
        let mixed = |of: &dyn Fn(usize) -> DVec3| -> DVec3 {
            corners.iter().zip(weights).map(|(corner, weight)| of(*corner) * weight).sum()
        };
        let normal = mixed(&|corner| all.normals[corner].as_dvec3()).normalize();
        let [a, b, c] = all.positions_of(triangle as u32);
        let axes =
            mesh.details.tangents[triangle].axes(w.as_vec2().to_array(), [b - a, c - a], normal.as_vec3());
        let all = [
            mixed(&|corner| all.uvs[corner].as_dvec2().extend(0.0)),
            mixed(&|corner| mesh.details.second_uvs[corner].as_dvec2().extend(0.0)),
            normal,
            mixed(&|corner| DVec3::from(mesh.details.colors[corner].map(f64::from))),
            axes.expect("a direction")[0].as_dvec3(),
        ];
        all.into_iter().flat_map(|value| value.to_array()).collect()
    }

    #[test]
    fn what_is_there_stays_as_it_is_and_the_rest_goes() {
        let whole = mesh(is_leaf);
        let trimmed = trim(&whole).expect("a leaf is smaller than its quad");
        let test = CutoutTest::new(&whole).expect("cut");
        let (mut there, mut gone) = (0, 0);
        for i in 0..200 * 100 {
            let place = (DVec2::new((i % 200).into(), (i / 200).into()) + 0.37) / 100.0;
            let before = met(&whole, place).expect("in the quad");
            let is_there = test.is_there(before.0 as u32, before.1.as_vec2().to_array(), Asks::Sight);
            match met(&trimmed, place) {
                Some(after) => {
                    let all = surface(&whole, before).into_iter().zip(surface(&trimmed, after));
                    // normals of new vertices have unit length: between them they differ a little; colours have 11 bits
                    all.for_each(|(a, b)| assert!((a - b).abs() < 2e-3, "{place}: {a} is {b}"));
                    there += u32::from(is_there);
                }
                None => {
                    assert!(!is_there, "{place} is gone");
                    gone += 1;
                }
            }
        }
        assert!(there > 2000 && gone > 8000, "{there} there, {gone} gone");
        assert!(met(&trimmed, DVec2::new(5.2, 0.2)).is_some(), "what is whole stays");
    }

    #[test]
    fn lists_by_triangle_follow() {
        let trimmed = trim(&mesh(is_leaf)).expect("smaller");
        let cut = trimmed.cut.as_deref().expect("cut");
        let (count, all) = (trimmed.count(), trimmed.triangles());
        assert_eq!(cut.range(), 0..count - 1);
        assert_eq!(trimmed.shadow_casting, count - 1);
        assert_eq!(trimmed.material_of, [vec![7; count - 1], vec![8]].concat());
        assert_eq!(trimmed.details.tangents.len(), count);
        assert_eq!(trimmed.groups.runs(), [(0, 0), (count as u32 - 1, 2)]);
        let vertices = all.positions.as_slice().len();
        assert!([all.normals.len(), all.uvs.len(), trimmed.details.colors.len()] == [vertices; 3]);
    }

    /// The parts of both triangles meet at the diagonal that they share: no edge inside the quad is open.
    #[test]
    fn no_gap_opens_where_triangles_meet() {
        let trimmed = trim(&mesh(is_leaf)).expect("smaller");
        let (triangles, cut) = (trimmed.triangles(), trimmed.cut.as_deref().expect("cut"));
        let edges = |triangle: &[u32; 3]| [0, 1, 2].map(|i| [triangle[i], triangle[(i + 1) % 3]]);
        let all: Vec<[u32; 2]> = triangles.corners[cut.range()].iter().flat_map(edges).collect();
        let is_on_diagonal = |vertex: &u32| {
            let [x, y, _] = triangles.positions.as_slice()[*vertex as usize];
            (x - 2.0 * y).abs() < 1e-5
        };
        let diagonal = all.iter().filter(|edge| edge.iter().all(is_on_diagonal));
        assert_eq!(diagonal.clone().count(), 2);
        diagonal.for_each(|[a, b]| assert!(all.contains(&[*b, *a]), "an open edge"));
        // a polygon: each edge inside it twice, and those around it once
        let open = all.iter().filter(|[a, b]| !all.contains(&[*b, *a])).count();
        assert_eq!(open + 2 * (cut.range().len() - 1), all.len());
    }

    #[test]
    fn quads_without_a_leaf_go_and_those_that_it_fills_stay() {
        let nothing = mesh(|_, _| false);
        let gone = trim(&nothing).expect("nothing of the quad is there");
        let (left, all) = (gone.triangles(), nothing.triangles());
        assert_eq!((left.corners.as_slice(), gone.shadow_casting), ([[0, 1, 2]].as_slice(), 0));
        // its vertices are gone as well
        assert_eq!(
            (left.positions.as_slice(), left.uvs.as_slice()),
            (&all.positions.as_slice()[4..], &all.uvs[4..])
        );
        assert!(gone.cut.is_none() && gone.groups.runs() == [(0, 2)]);
        assert!(trim(&mesh(|x, y| x + y > 0)).is_none(), "all but a corner is there");
        assert!(trimmed_mesh(&mesh(is_leaf), &mut 1).is_none(), "no room");
        let corners = Arc::new(vec![[0, 1, 2], [0, 2, 3]]);
        let all_gone = mesh(|_, _| false).with_triangles(|all| all.corners = corners);
        let all_gone = Mesh { material_of: vec![7, 7], groups: Default::default(), ..all_gone };
        assert!(trim(&all_gone).is_none(), "a mesh is never empty");
    }

    #[test]
    fn meshes_that_deform_or_have_no_normals_or_are_tiny_stay() {
        let leaf = mesh(is_leaf);
        let rough = leaf.clone().with_triangles(|all| all.normals[3] = Vec3::ZERO);
        assert!(trim(&rough).is_none(), "the face's own normal counts");
        let far = leaf.with_triangles(|all| {
            let moved = all.positions.as_slice().iter().map(|[x, y, z]| [x + 1e6, *y, *z]);
            all.positions = Arc::new(VertexBuffer::new(moved.collect()));
        });
        assert!(trim(&far).is_none(), "far away");
    }

    #[test]
    fn copies_are_trimmed_once() {
        let first = model(mesh(is_leaf), TransformTrack::identity());
        let models = trimmed(vec![first.clone(), first.clone()]);
        assert!(Arc::ptr_eq(&models[0].mesh, &models[1].mesh));
        assert!(models[0].mesh.count() > first.mesh.count());
    }
}

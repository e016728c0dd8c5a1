//! BVH crates on one OBJ with the same rays, each ray for itself: what the choice in `src/trace/rust.rs` rests on.
//!
//! `cargo run --release --manifest-path benches/bvh_crates/Cargo.toml -- SCENE.obj`
//!
//! The eye is in the middle of the scene's box and looks along -z; primary rays go row by row, and the others
//! from what those meet in all directions. Each crate does what it offers for the closest hit. Best of three
//! rounds, on all cores.

use std::time::{Duration, Instant};

use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::{BHShape, BoundingHierarchy};
use nalgebra::{Point3, Vector3};
use obvhs::BvhBuildParams;
use obvhs::ray::{Ray, RayHit};
use obvhs::triangle::Triangle;
use parry3d::query::RayCast;
use rayon::prelude::*;

const WIDTH: usize = 1280;
const HEIGHT: usize = 720;

type Rays = Vec<([f32; 3], [f32; 3])>;

fn main() {
    let path = std::env::args().nth(1).expect("which OBJ?");
    let triangles = load(&path);
    println!("{path}: {} triangles, {} threads", triangles.len(), rayon::current_num_threads());
    let of_obvhs: Vec<Triangle> = triangles
        .iter()
        .map(|[a, b, c]| Triangle { v0: (*a).into(), v1: (*b).into(), v2: (*c).into() })
        .collect();
    let mut rays: Vec<Rays> = vec![primary(&triangles)];

    for (name, how) in [
        ("fast", BvhBuildParams::fast_build as fn() -> BvhBuildParams),
        ("medium", BvhBuildParams::medium_build),
        ("slow", BvhBuildParams::slow_build),
        ("very slow", BvhBuildParams::very_slow_build),
    ] {
        let start = Instant::now();
        let binary = obvhs::bvh2::builder::build_bvh2_from_tris(&of_obvhs, how(), &mut Duration::default());
        let seconds = start.elapsed().as_secs_f64();
        // triangles in the order of the leaves, as its examples do it
        let ordered: Vec<Triangle> = binary.primitive_indices.iter().map(|i| of_obvhs[*i as usize]).collect();
        let closest = |origin: [f32; 3], way: [f32; 3]| {
            let mut hit = RayHit::none();
            let ray = Ray::new_inf(origin.into(), way.into());
            binary.ray_traverse(ray, &mut hit, |ray, id| ordered[id].intersect(ray));
            hit.t
        };
        if rays.len() == 1 {
            rays.push(scattered(&rays[0], closest));
        }
        measure(&format!("obvhs, binary, {name}"), seconds, &rays, closest);
        let start = Instant::now();
        let wide = obvhs::cwbvh::builder::build_cwbvh_from_tris(&of_obvhs, how(), &mut Duration::default());
        let seconds = start.elapsed().as_secs_f64();
        let ordered: Vec<Triangle> = wide.primitive_indices.iter().map(|i| of_obvhs[*i as usize]).collect();
        measure(&format!("obvhs, CWBVH, {name}"), seconds, &rays, |origin, way| {
            let mut hit = RayHit::none();
            let ray = Ray::new_inf(origin.into(), way.into());
            wide.ray_traverse(ray, &mut hit, |ray, id| ordered[id].intersect(ray));
            hit.t
        });
    }
    of_bvh(&triangles, &rays);
    of_parry(&triangles, &rays);
}

fn of_bvh(triangles: &[[[f32; 3]; 3]], rays: &[Rays]) {
    let mut shapes: Vec<Shape> =
        triangles.iter().map(|corners| Shape { corners: *corners, node: 0 }).collect();
    let start = Instant::now();
    let tree = bvh::bvh::Bvh::build_par(&mut shapes);
    let seconds = start.elapsed().as_secs_f64();
    measure("bvh", seconds, rays, |origin, way| {
        let [x, y, z] = way;
        let ray = bvh::ray::Ray::new(Point3::from(origin), Vector3::new(x, y, z));
        // it normalises directions, culls triangles from behind, and leaves it to its user where to end
        let mut best = f32::INFINITY;
        for shape in tree.nearest_traverse_iterator(&ray, &shapes) {
            let Aabb { min, max } = shape.aabb();
            let away = (min - ray.origin).sup(&(ray.origin - max)).sup(&Vector3::zeros());
            if away.norm() > best {
                break;
            }
            let [a, b, c] = shape.corners.map(Point3::from);
            let front = ray.intersects_triangle(&a, &b, &c).distance;
            best = best.min(front).min(ray.intersects_triangle(&a, &c, &b).distance);
        }
        best / Vector3::new(x, y, z).norm()
    });
}

struct Shape {
    corners: [[f32; 3]; 3],
    node: usize,
}

impl Bounded<f32, 3> for Shape {
    fn aabb(&self) -> Aabb<f32, 3> {
        let [a, b, c] = self.corners.map(Point3::from);
        Aabb::empty().grow(&a).grow(&b).grow(&c)
    }
}

impl BHShape<f32, 3> for Shape {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }
    fn bh_node_index(&self) -> usize {
        self.node
    }
}

fn of_parry(triangles: &[[[f32; 3]; 3]], rays: &[Rays]) {
    let points = triangles.iter().flatten().map(|point| (*point).into()).collect();
    let indices = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let start = Instant::now();
    let mesh = parry3d::shape::TriMesh::new(points, indices).expect("there are triangles");
    let seconds = start.elapsed().as_secs_f64();
    measure("parry3d", seconds, rays, |origin, way| {
        let ray = parry3d::query::Ray::new(origin.into(), way.into());
        mesh.cast_local_ray(&ray, f32::MAX, false).unwrap_or(f32::INFINITY)
    });
}

fn measure(name: &str, build: f64, rays: &[Rays], closest: impl Fn([f32; 3], [f32; 3]) -> f32 + Sync) {
    print!("{name:<26} built in {build:>6.2} s");
    for (kind, rays) in ["primary", "incoherent"].iter().zip(rays) {
        let (mut best, mut met) = (f64::INFINITY, 0);
        for _ in 0..3 {
            let start = Instant::now();
            met = rays
                .par_chunks(1024)
                .map(|some| some.iter().filter(|ray| closest(ray.0, ray.1).is_finite()).count())
                .sum();
            best = best.min(start.elapsed().as_secs_f64());
        }
        print!("   {kind} {:>6.2} M/s ({met} meet)", rays.len() as f64 / best / 1e6);
    }
    println!();
}

fn primary(triangles: &[[[f32; 3]; 3]]) -> Rays {
    let mut ends = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    for point in triangles.iter().flatten() {
        for axis in 0..3 {
            ends[0][axis] = ends[0][axis].min(point[axis]);
            ends[1][axis] = ends[1][axis].max(point[axis]);
        }
    }
    let eye: [f32; 3] = std::array::from_fn(|axis| (ends[0][axis] + ends[1][axis]) * 0.5);
    let way = |i: usize| {
        let (x, y) = ((i % WIDTH) as f32 + 0.5, (i / WIDTH) as f32 + 0.5);
        [(2.0 * x - WIDTH as f32) / HEIGHT as f32 * 0.4, (1.0 - 2.0 * y / HEIGHT as f32) * 0.4, -1.0]
    };
    (0..WIDTH * HEIGHT).map(|i| (eye, way(i))).collect()
}

fn scattered(primary: &Rays, closest: impl Fn([f32; 3], [f32; 3]) -> f32) -> Rays {
    let mut state = 1_u32;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state as f32 / u32::MAX as f32 * 2.0 - 1.0
    };
    let mut rays = Rays::new();
    for (origin, way) in primary {
        let t = closest(*origin, *way);
        if t.is_finite() {
            let start = std::array::from_fn(|axis| origin[axis] + way[axis] * t * 0.9999);
            rays.push((start, [random(), random(), random()]));
        }
    }
    rays
}

fn load(path: &str) -> Vec<[[f32; 3]; 3]> {
    let options = tobj::LoadOptions { triangulate: true, ..tobj::LoadOptions::default() };
    let (models, _) = tobj::load_obj(path, &options).expect("an OBJ that can be read");
    let mut triangles = Vec::new();
    for tobj::Model { mesh, .. } in models {
        let point = |i: u32| std::array::from_fn(|axis| mesh.positions[i as usize * 3 + axis] as f32);
        triangles.extend(
            mesh.indices.chunks_exact(3).map(|face| [point(face[0]), point(face[1]), point(face[2])]),
        );
    }
    triangles
}

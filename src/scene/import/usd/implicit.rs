//! Shapes that are stated by their measures (UsdGeomSphere and the like), cut into triangles.

use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DVec2, DVec3};
use openusd::usd::Prim;

use super::clock::Clock;
use super::file::UsdMesh;
use super::value::{Answer, codes, number, word};
use crate::scene::import::deformed::remove_closed;
use crate::scene::import::faces::are_within_reach;

/// Corners around a round shape, and from one pole of a sphere to the other.
const AROUND: u32 = 96;
const ACROSS: u32 = 48;

/// Points of a profile, which is turned about an axis: the distance from it and the height, and the same of their normals.
type Profile = Vec<(DVec2, DVec2)>;

/// Returns true for types of prims that are such shapes.
pub fn is_shape(kind: &str) -> bool {
    matches!(kind, "Cube" | "Sphere" | "Cylinder" | "Cylinder_1" | "Cone" | "Capsule" | "Capsule_1" | "Plane")
}

/// Triangles of a prim of this type. `None` if it is of no size.
///
/// # Errors What the library says.
pub fn mesh(
    (prim, kind): (&Prim, &str),
    clock: &Clock,
    surface: Option<usize>,
    unused: &mut BTreeSet<String>,
) -> Answer<Option<UsdMesh>> {
    let code = clock.code(clock.first());
    for name in ["radius", "height", "size", "width", "length", "radiusTop", "radiusBottom"] {
        if codes(prim, name)?.len() > 1 {
            let path = prim.path();
            unused.insert(format!("the {name} of {path} changes with time: that of its first time is shown"));
        }
    }
    let measure =
        |name: &str, default: f64| -> Answer<f64> { Ok(number(prim, name, code)?.unwrap_or(default).abs()) };
    let half = |name: &str, default: f64| -> Answer<f64> { Ok(measure(name, default)? / 2.0) };
    let axis = word(prim, "axis", code)?;
    let mut mesh = Builder::default();
    match kind {
        "Cube" => mesh.cube(half("size", 2.0)?),
        "Plane" => {
            let [width, length] = [half("width", 2.0)?, half("length", 2.0)?];
            // along Z and Y, or along X and Z, where the axis is not Z
            match axis.as_deref() {
                Some("X" | "Y") => mesh.plane(length, width),
                _ => mesh.plane(width, length),
            }
        }
        "Sphere" => mesh.turned(&sphere(measure("radius", 1.0)?)),
        "Cone" => mesh.turned(&cone([measure("radius", 1.0)?, 0.0], half("height", 2.0)?)),
        "Cylinder" => {
            let radius = measure("radius", 1.0)?;
            mesh.turned(&cone([radius; 2], half("height", 2.0)?));
        }
        "Cylinder_1" => {
            let radii = [measure("radiusBottom", 1.0)?, measure("radiusTop", 1.0)?];
            mesh.turned(&cone(radii, half("height", 2.0)?));
        }
        "Capsule" => {
            let radius = measure("radius", 0.5)?;
            mesh.turned(&capsule([radius; 2], half("height", 1.0)?));
        }
        _ => {
            let radii = [measure("radiusBottom", 0.5)?, measure("radiusTop", 0.5)?];
            mesh.turned(&capsule(radii, half("height", 1.0)?));
        }
    }
    let mut mesh = mesh.turned_to(axis.as_deref(), surface);
    remove_closed(&mesh.positions, &mut mesh.triangles, &mut mesh.uses);
    if !are_within_reach(&mesh.positions) {
        return Err(String::from("it is larger than 1e18: export it again"));
    }
    Ok((!mesh.triangles.is_empty()).then_some(mesh))
}

/// Profile of an arc about a point on the axis, from one angle above the equator to another.
fn arc(radius: f64, height: f64, [from, to]: [f64; 2]) -> Profile {
    let steps = (f64::from(ACROSS) * (to - from) / (2.0 * FRAC_PI_2)).round().max(1.0) as u32;
    let point = |step: u32| {
        let is_pole = |angle: f64| angle.abs() == FRAC_PI_2;
        let angle = from + (to - from) * f64::from(step) / f64::from(steps);
        let across = if is_pole(angle) { 0.0 } else { angle.cos() };
        let normal = DVec2::new(across, angle.sin());
        (normal * radius + DVec2::new(0.0, height), normal)
    };
    (0..=steps).map(point).collect()
}

fn sphere(radius: f64) -> Profile {
    arc(radius, 0.0, [-FRAC_PI_2, FRAC_PI_2])
}

/// Profile of a cone with these radii at its bottom and top, and with its caps.
fn cone([bottom, top]: [f64; 2], half: f64) -> Profile {
    let [bottom, top] = [DVec2::new(bottom, -half), DVec2::new(top, half)];
    let side = (bottom - top).perp().normalize_or(DVec2::X);
    let axis = |point: DVec2| DVec2::new(0.0, point.y);
    vec![
        (axis(bottom), DVec2::NEG_Y),
        (bottom, DVec2::NEG_Y),
        (bottom, side),
        (top, side),
        (top, DVec2::Y),
        (axis(top), DVec2::Y),
    ]
}

/// Profile of a cylinder with a half of a sphere at each of its ends.
fn capsule([bottom, top]: [f64; 2], half: f64) -> Profile {
    let mut profile = arc(bottom, -half, [-FRAC_PI_2, 0.0]);
    profile.extend(arc(top, half, [0.0, FRAC_PI_2]));
    profile
}

/// A mesh that grows, with its axis along Z.
#[derive(Default)]
struct Builder {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Builder {
    /// A flat face, counter-clockwise, with four vertices of its own.
    fn square(&mut self, corners: [DVec3; 4]) {
        let first = self.positions.len() as u32;
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        self.positions.extend(corners);
        self.normals.extend([normal; 4]);
        self.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }

    fn cube(&mut self, half: f64) {
        for side in [1.0, -1.0] {
            for axis in 0..3 {
                // the other two axes in an order that makes what is seen from outside counter-clockwise
                let corner = |a: f64, b: f64| {
                    let mut corner = DVec3::ZERO;
                    corner[axis] = side;
                    corner[(axis + 1) % 3] = a;
                    corner[(axis + 2) % 3] = b * side;
                    corner * half
                };
                self.square([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
            }
        }
    }

    fn plane(&mut self, across: f64, along: f64) {
        let corner = |a: f64, b: f64| DVec3::new(a * across, b * along, 0.0);
        self.square([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
    }

    /// What a profile from the bottom to the top makes as it turns about the axis.
    fn turned(&mut self, profile: &Profile) {
        for step in 0..AROUND {
            let (sin, cos) = (TAU * f64::from(step) / f64::from(AROUND)).sin_cos();
            let placed = |point: DVec2| DVec3::new(point.x * cos, point.x * sin, point.y);
            self.positions.extend(profile.iter().map(|(point, _)| placed(*point)));
            self.normals.extend(profile.iter().map(|(_, normal)| placed(*normal)));
        }
        let rows = profile.len() as u32;
        for step in 0..AROUND {
            let [here, next] = [step * rows, (step + 1) % AROUND * rows];
            for row in 0..rows - 1 {
                let [a, b, c, d] = [here + row, next + row, next + row + 1, here + row + 1];
                self.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }

    /// The mesh with its axis along that of this name.
    fn turned_to(self, axis: Option<&str>, surface: Option<usize>) -> UsdMesh {
        let turn = |v: DVec3| match axis {
            Some("X") => DVec3::new(v.z, v.x, v.y),
            Some("Y") => DVec3::new(v.y, v.z, v.x),
            _ => v,
        };
        UsdMesh {
            positions: self.positions.iter().map(|point| turn(*point).as_vec3().to_array()).collect(),
            normals: self.normals.iter().map(|normal| turn(*normal).as_vec3()).collect(),
            point_of: (0..self.positions.len() as u32).collect(),
            uses: vec![(self.triangles.len(), surface)],
            triangles: self.triangles,
            ..UsdMesh::default()
        }
    }
}

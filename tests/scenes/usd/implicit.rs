//! Do spheres, cubes and the like have their measures, and face outwards?

use super::{METRES, corner, load, model, shown};
use afterimage::scene::Model;
use glam::DVec3;

/// Corners of the triangles in the world.
fn triangles(model: &Model) -> Vec<[DVec3; 3]> {
    let at = |vertex: u32| corner(model, 1.0, vertex as usize);
    model.mesh.triangles().corners.iter().map(|triangle| triangle.map(at)).collect()
}

/// Volume of a closed mesh that faces outwards.
fn volume(model: &Model) -> f64 {
    triangles(model).iter().map(|[a, b, c]| a.dot(b.cross(*c)) / 6.0).sum()
}

/// Half of the extent along each axis.
fn half(model: &Model) -> DVec3 {
    triangles(model).as_flattened().iter().fold(DVec3::ZERO, |most, corner| most.max(corner.abs()))
}

#[test]
fn shapes_have_their_measures_and_face_outwards() {
    let shot = shown(
        METRES,
        "def Sphere \"Ball\" { double radius = 2 }\ndef Cube \"Box\" { double size = 3 }\n\
         def Cylinder \"Tube\" { token axis = \"X\" }\ndef Cone \"Cone\" { double height = 3 token axis = \"Y\" }\n\
         def Capsule \"Pill\" {}\ndef Cylinder_1 \"Cut\" { double radiusTop = 0.5 double height = 4 }\n",
    );
    let pi = std::f64::consts::PI;
    for (name, wanted, extent) in [
        ("Ball", 4.0 / 3.0 * pi * 8.0, DVec3::splat(2.0)),
        ("Box", 27.0, DVec3::splat(1.5)),
        ("Tube", 2.0 * pi, DVec3::ONE),
        ("Cone", pi, DVec3::new(1.0, 1.5, 1.0)),
        ("Pill", pi / 4.0 + pi / 6.0, DVec3::new(0.5, 0.5, 1.0)),
        ("Cut", 4.0 / 3.0 * pi * (1.0 + 0.5 + 0.25), DVec3::new(1.0, 1.0, 2.0)),
    ] {
        let model = model(&shot, &format!("m/{name}"));
        let (volume, half) = (volume(model), half(model));
        assert!((volume / wanted - 1.0).abs() < 3e-3, "{name}: {volume}, not {wanted}");
        assert!(half.abs_diff_eq(extent, 1e-3), "{name}: {half}");
        let outwards = |(vertex, normal): (usize, &glam::Vec3)| {
            let at = model.mesh.triangles().positions.as_slice()[vertex];
            glam::Vec3::from(at).dot(*normal) > 0.0 && (normal.length() - 1.0).abs() < 1e-6
        };
        assert!(model.mesh.triangles().normals.iter().enumerate().all(outwards), "{name}");
    }
}

#[test]
fn a_plane_lies_as_its_axis_says() {
    let plane = |axis: &str| {
        let prim =
            format!("def Plane \"P\" {{ double width = 4 double length = 6 token axis = \"{axis}\" }}\n");
        half(model(&shown(METRES, &prim), "m/P"))
    };
    assert_eq!(plane("Z"), DVec3::new(2.0, 3.0, 0.0));
    assert_eq!(plane("Y"), DVec3::new(2.0, 0.0, 3.0));
    assert_eq!(plane("X"), DVec3::new(0.0, 3.0, 2.0));
}

#[test]
fn shapes_of_no_size_are_not_there_and_too_large_ones_are_told() {
    let ball =
        |radius: &str| format!("def Sphere \"A\" {{}}\ndef Sphere \"B\" {{ double radius = {radius} }}\n");
    assert_eq!(super::names(&shown(METRES, &ball("0"))), ["m/A"]);
    let shot = load(METRES, &ball("1e20")).unwrap();
    assert!(shot.warnings[0].to_string().contains("/B is left out: it is larger than 1e18"));
    assert_eq!(super::names(&shot), ["m/A"]);
}

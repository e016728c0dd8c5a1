//! Subdivision surfaces of USD files: are they what Pixar's rules make of their cages?

use afterimage::scene::{Mesh, Shot};
use glam::Vec3;

use super::{METRES, load};

/// A cube from -1 to 1. Points: x, then y, then z.
const CUBE: &str = "point3f[] points = [(-1,-1,-1),(1,-1,-1),(-1,1,-1),(1,1,-1),(-1,-1,1),(1,-1,1),(-1,1,1),(1,1,1)]\n\
    int[] faceVertexCounts = [4,4,4,4,4,4]\n\
    int[] faceVertexIndices = [0,4,6,2, 1,3,7,5, 0,1,5,4, 2,6,7,3, 0,2,3,1, 4,5,7,6]\n";

fn cube(more: &str) -> Shot {
    load(METRES, &format!("def Mesh \"M\" {{ {CUBE} {more} }}")).unwrap()
}

fn mesh(shot: &Shot) -> &Mesh {
    &shot.scene.models[0].mesh
}

/// Positions about the middle of the mesh, as wide as the cage is if none of it moved: shots of bare files may put models elsewhere.
fn positions(mesh: &Mesh) -> Vec<Vec3> {
    mesh.triangles().positions.as_slice().iter().map(|place| Vec3::from(*place)).collect()
}

fn extent(mesh: &Mesh) -> Vec3 {
    let (low, high) = mesh.bounds();
    (high - low).as_vec3()
}

#[test]
fn what_says_nothing_is_catmull_clark() {
    let shot = cube("");
    assert!(shot.warnings.is_empty(), "{:?}", shot.warnings);
    // the middle of a face goes to 11/12 of its place: a third of what is around goes with it
    let wide = extent(mesh(&shot));
    assert!(wide.x < 1.9 && wide.x > 1.5 && (wide.x - wide.y).abs() < 1e-5, "{wide}");
    assert!(mesh(&shot).count() > 1000);
    let plain = cube("uniform token subdivisionScheme = \"none\"\n");
    assert_eq!((mesh(&plain).count(), extent(mesh(&plain))), (12, Vec3::splat(2.0)));
    let bilinear = cube("uniform token subdivisionScheme = \"bilinear\"\n");
    assert_eq!(extent(mesh(&bilinear)), Vec3::splat(2.0));
    let told = cube("uniform token subdivisionScheme = \"loop\"\n");
    assert!(
        told.warnings.iter().any(|warning| warning.to_string().contains("6 of its faces are no triangles"))
    );
    assert_eq!(mesh(&told).count(), 12, "its cage");
    let triangles = "def Mesh \"M\" {\npoint3f[] points = [(1,0,0),(0,1,0),(0,0,1),(-1,0,0),(0,-1,0),(0,0,-1)]\n\
        int[] faceVertexCounts = [3,3,3,3,3,3,3,3]\n\
        int[] faceVertexIndices = [0,1,2, 1,3,2, 3,4,2, 4,0,2, 1,0,5, 3,1,5, 4,3,5, 0,4,5]\n\
        uniform token subdivisionScheme = \"loop\"\n}";
    let round = load(METRES, triangles).unwrap();
    assert!(round.warnings.is_empty(), "{:?}", round.warnings);
    // corners of an octahedron go to 24/55 of their place
    assert!(
        (extent(mesh(&round)) - Vec3::splat(48.0 / 55.0)).abs().max_element() < 1e-5,
        "{}",
        extent(mesh(&round))
    );
}

#[test]
fn creases_corners_and_holes_are_those_of_the_file() {
    let sharp = cube(
        "int[] creaseIndices = [4,5,7,6,4]\nint[] creaseLengths = [5]\nfloat[] creaseSharpnesses = [10]\n\
         int[] cornerIndices = [4,5,6,7]\nfloat[] cornerSharpnesses = [10,10,10,10]\n",
    );
    let (low, high) = mesh(&sharp).bounds();
    let top: Vec<Vec3> =
        positions(mesh(&sharp)).into_iter().filter(|at| at.z as f64 >= high.z - 1e-6).collect();
    let wide = top.iter().map(|at| at.x).fold(f32::MIN, f32::max)
        - top.iter().map(|at| at.x).fold(f32::MAX, f32::min);
    assert!((wide - 2.0).abs() < 1e-5 && high.z - low.z < 1.97, "{wide} {low} {high}");
    let semi = cube(
        "int[] creaseIndices = [4,5,7,6,4]\nint[] creaseLengths = [5]\nfloat[] creaseSharpnesses = [0.5]\n",
    );
    let round = cube("");
    let tall = |shot: &Shot| extent(mesh(shot)).z;
    assert!(tall(&round) < tall(&semi) && tall(&semi) < tall(&sharp));
    let all = mesh(&round).count();
    let open = cube("int[] holeIndices = [5]\n");
    assert_eq!(mesh(&open).count() * 6, all * 5);
    let left = cube("uniform token orientation = \"leftHanded\"\n");
    let inwards = positions(mesh(&left)).iter().zip(&mesh(&left).triangles().normals).all(|(at, normal)| {
        let middle = mesh(&left).bounds();
        (*at - ((middle.0 + middle.1) * 0.5).as_vec3()).dot(*normal) < 0.0
    });
    assert!(inwards);
}

#[test]
fn tags_that_name_nothing_are_told() {
    for (tags, words) in [
        (
            "int[] creaseIndices = [0, 99]\nint[] creaseLengths = [2]\nfloat[] creaseSharpnesses = [3]\n",
            "creaseIndices",
        ),
        (
            "int[] creaseIndices = [0, 1]\nint[] creaseLengths = [7]\nfloat[] creaseSharpnesses = [3]\n",
            "creaseLengths",
        ),
        ("int[] cornerIndices = [-1]\nfloat[] cornerSharpnesses = [3]\n", "cornerIndices"),
    ] {
        let shot = cube(tags);
        let told: Vec<String> = shot.warnings.iter().map(ToString::to_string).collect();
        assert!(told.len() == 1 && told[0].contains(words), "{told:?}");
        assert_eq!(mesh(&shot).count(), mesh(&cube("")).count(), "all else of it is shown");
    }
}

#[test]
fn texture_coordinates_follow_their_rule() {
    // an island a face
    let island = |face: u32| {
        let (left, right) = (2 * face, 2 * face + 1);
        format!("({left},0),({right},0),({right},1),({left},1)")
    };
    let uvs: Vec<String> = (0..6).map(island).collect();
    let uvs = uvs.join(",");
    let with = |rule: &str| {
        cube(&format!(
            "texCoord2f[] primvars:st = [{uvs}] ( interpolation = \"faceVarying\" )\n\
             uniform token faceVaryingLinearInterpolation = \"{rule}\"\n"
        ))
    };
    // corners of islands stay where they are, unless all of it is smooth
    let reaches = |shot: &Shot| mesh(shot).triangles().uvs.iter().map(|uv| uv.x).fold(0.0, f32::max);
    for (rule, wide) in [("cornersPlus1", 11.0), ("boundaries", 11.0), ("all", 11.0)] {
        assert_eq!(reaches(&with(rule)), wide, "{rule}");
    }
    assert!((reaches(&with("none")) - (10.0 + 23.0 / 24.0)).abs() < 1e-5);
}

#[test]
fn subsets_have_their_materials_and_points_their_times() {
    let prims = format!(
        "def Material \"Red\" {{ token outputs:surface.connect = </Red/S.outputs:surface>\n def Shader \"S\" {{ uniform token info:id = \"UsdPreviewSurface\"\n\
         color3f inputs:diffuseColor = (1, 0, 0)\n token outputs:surface }} }}\n\
         def Mesh \"M\" {{ {CUBE} point3f[] points.timeSamples = {{ 1: [(-1,-1,-1),(1,-1,-1),(-1,1,-1),(1,1,-1),(-1,-1,1),(1,-1,1),(-1,1,1),(1,1,1)],\n\
         2: [(-1,-1,-1),(1,-1,-1),(-1,1,-1),(1,1,-1),(-1,-1,3),(1,-1,3),(-1,1,3),(1,1,3)] }}\n\
         def GeomSubset \"Top\" (prepend apiSchemas = [\"MaterialBindingAPI\"]) {{ uniform token elementType = \"face\"\n uniform token familyName = \"materialBind\"\n\
         int[] indices = [5]\n rel material:binding = </Red> }} }}\n"
    );
    let shot = load(METRES, &prims).unwrap();
    let mesh = mesh(&shot);
    let red =
        mesh.material_of.iter().filter(|number| shot.scene.materials[usize::from(**number)].name == "Red");
    assert_eq!(red.count() * 6, mesh.count());
    let shapes = mesh.shapes().unwrap().list();
    let tall = |shape: &[[f32; 3]]| {
        let heights = shape.iter().map(|at| at[2]);
        heights.clone().fold(f32::MIN, f32::max) - heights.fold(f32::MAX, f32::min)
    };
    assert!((tall(&shapes[1]) - 2.0 * tall(&shapes[0])).abs() < 1e-4);
}

#[test]
fn a_preview_surface_displaces_its_mesh() {
    let material = "def Material \"Up\" { token outputs:surface.connect = </Up/S.outputs:surface>\n token outputs:displacement.connect = </Up/S.outputs:displacement>\n\
        def Shader \"S\" { uniform token info:id = \"UsdPreviewSurface\"\n float inputs:displacement = 0.25\n token outputs:surface\n token outputs:displacement } }\n";
    let prims = format!(
        "{material} def Mesh \"M\" (prepend apiSchemas = [\"MaterialBindingAPI\"]) {{ {CUBE} uniform token subdivisionScheme = \"bilinear\"\n rel material:binding = </Up> }}"
    );
    let shot = load(METRES, &prims).unwrap();
    assert!((extent(mesh(&shot)) - Vec3::splat(2.5)).abs().max_element() < 1e-4, "{}", extent(mesh(&shot)));
}

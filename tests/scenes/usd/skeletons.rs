//! Do meshes follow their skeletons and blend shapes?

use std::f64::consts::FRAC_1_SQRT_2;

use afterimage::scene::{Model, Shot};
use glam::{DVec3, Vec3};

use super::{METRES, assert_near, folder, load, model, shown};
use afterimage::scene;

/// A strip along X of two squares: points 0 and 1 at x = 0, 2 and 3 at 1, 4 and 5 at 2.
const STRIP: &str = "int[] faceVertexCounts = [4, 4]\nint[] faceVertexIndices = [0, 2, 3, 1, 2, 4, 5, 3]\n\
    point3f[] points = [(0, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0), (2, 0, 0), (2, 1, 0)]\n\
    uniform token subdivisionScheme = \"none\"\n";

/// Two joints along X: the second at x = 1.
const SKELETON: &str = "def Skeleton \"S\" {\n uniform token[] joints = [\"A\", \"A/B\"]\n\
    uniform matrix4d[] bindTransforms = [((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1)), ((1,0,0,0),(0,1,0,0),(0,0,1,0),(1,0,0,1))]\n\
    uniform matrix4d[] restTransforms = [((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1)), ((1,0,0,0),(0,1,0,0),(0,0,1,0),(1,0,0,1))]\n";

/// The second joint turns by 90 degrees about Z from frame 1 to frame 5.
const BEND: &str = "def SkelAnimation \"Bend\" {\n uniform token[] joints = [\"A/B\"]\n float3[] translations = [(1, 0, 0)]\n\
    half3[] scales = [(1, 1, 1)]\n quatf[] rotations.timeSamples = { 1: [(1, 0, 0, 0)], 5: [(0.70710678, 0, 0, 0.70710678)] }\n}\n";

/// Binding of the strip: the last two points to the second joint, those in the middle to both.
const BOUND: &str = "rel skel:skeleton = </R/S>\n\
    int[] primvars:skel:jointIndices = [0,0, 0,0, 0,1, 0,1, 1,0, 1,0] ( elementSize = 2\n interpolation = \"vertex\" )\n\
    float[] primvars:skel:jointWeights = [1,0, 1,0, 0.5,0.5, 0.5,0.5, 1,0, 1,0] ( elementSize = 2\n interpolation = \"vertex\" )\n";

fn root(skeleton: &str, mesh: &str) -> String {
    format!(
        "def SkelRoot \"R\" {{\n {SKELETON} {skeleton} }}\n {BEND} def Mesh \"M\" {{\n {STRIP} {mesh} }} }}\n"
    )
}

/// Place of a vertex at a frame, in the world.
fn at(model: &Model, frame: f64, vertex: usize) -> DVec3 {
    let own = model.mesh.triangles().positions.as_slice()[vertex];
    let shape = model.mesh.shapes().zip(model.track.shapes.as_ref());
    let position = shape.map_or(own, |(shapes, track)| shapes.positions(&track.at(frame))[vertex]);
    model.track.map_at(frame).transform_point3(Vec3::from(position).as_dvec3())
}

/// Number of the vertex that is here at a frame.
fn vertex(shot: &Shot, frame: f64, place: DVec3) -> usize {
    let model = model(shot, "m/R/M");
    let count = model.mesh.triangles().positions.as_slice().len();
    let found = (0..count).find(|vertex| at(model, frame, *vertex).abs_diff_eq(place, 1e-5));
    found.unwrap_or_else(|| {
        panic!("{place}: {:?}", (0..count).map(|v| at(model, frame, v)).collect::<Vec<_>>())
    })
}

#[test]
fn meshes_follow_their_joints_on_arcs() {
    let place =
        "double3 xformOp:translate = (0, 0, 5)\n uniform token[] xformOpOrder = [\"xformOp:translate\"]\n";
    let animated = format!("{place} rel skel:animationSource = </R/Bend>\n");
    let bound = format!(
        "{BOUND} double3 xformOp:translate = (9, 9, 9)\n uniform token[] xformOpOrder = [\"xformOp:translate\"]\n"
    );
    let shot = shown(METRES, &root(&animated, &bound));
    let tip = vertex(&shot, 1.0, DVec3::new(2.0, 0.0, 5.0));
    let strip = model(&shot, "m/R/M");
    assert_near(at(strip, 5.0, tip), DVec3::new(1.0, 1.0, 5.0));
    assert_near(at(strip, 3.0, tip), DVec3::new(1.0 + FRAC_1_SQRT_2, FRAC_1_SQRT_2, 5.0));
    // the mean of where both joints take it
    let middle = vertex(&shot, 1.0, DVec3::new(1.0, 1.0, 5.0));
    assert_near(at(strip, 5.0, middle), DVec3::new(0.5, 0.5, 5.0));
    let still = vertex(&shot, 1.0, DVec3::new(0.0, 1.0, 5.0));
    assert_near(at(strip, 5.0, still), DVec3::new(0.0, 1.0, 5.0));
}

#[test]
fn a_mesh_may_order_joints_and_be_bound_elsewhere() {
    let bound = "uniform token[] skel:joints = [\"A/B\"]\n rel skel:skeleton = </R/S>\n\
        matrix4d primvars:skel:geomBindTransform = ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,3,1))\n\
        int[] primvars:skel:jointIndices = [0] ( interpolation = \"constant\" )\n\
        float[] primvars:skel:jointWeights = [1] ( interpolation = \"constant\" )\n";
    let shot = shown(METRES, &root("rel skel:animationSource = </R/Bend>\n", bound));
    let corner = vertex(&shot, 1.0, DVec3::new(0.0, 0.0, 3.0));
    assert_near(at(model(&shot, "m/R/M"), 5.0, corner), DVec3::new(1.0, -1.0, 3.0));
}

#[test]
fn without_an_animation_joints_are_at_rest() {
    let moved =
        SKELETON.replace("(1,0,0,1))]\n uniform matrix4d[] rest", "(1,0,0,1))]\n uniform matrix4d[] old");
    let lifted = "uniform matrix4d[] restTransforms = [((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,2,1)), ((1,0,0,0),(0,1,0,0),(0,0,1,0),(1,0,0,1))]\n";
    let prims =
        format!("def SkelRoot \"R\" {{\n {moved} {lifted} }}\n def Mesh \"M\" {{\n {STRIP} {BOUND} }} }}\n");
    let shot = shown(METRES, &prims);
    vertex(&shot, 1.0, DVec3::new(2.0, 1.0, 2.0));
    assert!(model(&shot, "m/R/M").mesh.shapes().is_none());
}

#[test]
fn blend_shapes_move_points_by_their_weights() {
    let animation = "def SkelAnimation \"Talk\" {\n uniform token[] blendShapes = [\"down\", \"up\"]\n\
        float[] blendShapeWeights.timeSamples = { 1: [0, 0], 3: [0, 2] }\n}\n";
    let bound = "rel skel:skeleton = </R/S>\n uniform token[] skel:blendShapes = [\"up\"]\n rel skel:blendShapeTargets = [</R/M/up>]\n\
        def BlendShape \"up\" { uniform vector3f[] offsets = [(0, 0, 1)]\n uniform int[] pointIndices = [4] }\n\
        double3 xformOp:translate = (7, 0, 0)\n uniform token[] xformOpOrder = [\"xformOp:translate\"]\n";
    let prims =
        root(&format!("rel skel:animationSource = </R/Talk>\n }}\n {animation} def Scope \"Z\" {{"), bound);
    let shot = shown(METRES, &prims);
    let tip = vertex(&shot, 1.0, DVec3::new(9.0, 0.0, 0.0));
    assert_near(at(model(&shot, "m/R/M"), 2.0, tip), DVec3::new(9.0, 0.0, 1.0));
    assert_near(at(model(&shot, "m/R/M"), 3.0, tip), DVec3::new(9.0, 0.0, 2.0));
}

#[test]
fn instances_have_animations_of_their_own() {
    let still = "def SkelAnimation \"Still\" {\n uniform token[] joints = [\"A\"]\n float3[] translations = [(0, 0, 4)]\n\
        half3[] scales = [(1, 1, 1)]\n quatf[] rotations = [(1, 0, 0, 0)]\n}\n";
    let prims = format!(
        "class SkelRoot \"R\" {{\n {SKELETON} }}\n def Mesh \"M\" {{\n {STRIP} {BOUND} }} }}\n {BEND} {still}\n\
         def \"One\" (instanceable = true\n references = </R>) {{ rel skel:animationSource = </Bend> }}\n\
         def \"Two\" (instanceable = true\n references = </R>) {{ rel skel:animationSource = </Still> }}\n"
    );
    let shot = shown(METRES, &prims);
    let reach = |name: &str| {
        let model = model(&shot, name);
        (0..6).map(|vertex| at(model, 5.0, vertex)).fold(DVec3::ZERO, DVec3::max)
    };
    assert_near(reach("m/One/M"), DVec3::new(1.0, 1.0, 0.0));
    assert_near(reach("m/Two/M"), DVec3::new(2.0, 1.0, 4.0));
}

/// Pixar's library turns what it has baked into Xforms, and leaves all else.
#[test]
fn nothing_follows_a_skeleton_but_below_a_root_of_skeletons() {
    let prims = root("rel skel:animationSource = </R/Bend>\n", BOUND).replace("def SkelRoot", "def Xform");
    let shot = shown(METRES, &prims);
    vertex(&shot, 5.0, DVec3::new(2.0, 0.0, 0.0));
}

#[test]
fn damaged_skins_say_what_is_wrong() {
    let told = |prims: &str| -> String {
        let shot = load(METRES, prims).unwrap();
        // it stands as it was bound
        vertex(&shot, 5.0, DVec3::new(2.0, 1.0, 0.0));
        shot.warnings.iter().map(ToString::to_string).collect()
    };
    let error = |mesh: &str| told(&root("", mesh));
    let far = error(&BOUND.replace("1,0, 1,0] ( elementSize", "7,0, 1,0] ( elementSize"));
    assert!(far.contains("/R/M stands as it was bound, for it names joint 7, which is not there"), "{far}");
    let short = error(&BOUND.replace("= [0,0, 0,0, ", "= [0,0, ").replace("= [1,0, 1,0, 0.5", "= [1,0, 0.5"));
    assert!(short.contains("joints for 5 points, and 6 points"), "{short}");
    let uneven = error(&BOUND.replace("= [1,0, 1,0, 0.5", "= [1, 1,0, 0.5"));
    assert!(uneven.contains("12 jointIndices and 11 jointWeights"), "{uneven}");
    let joints = SKELETON.replace("\"A/B\"]", "\"A/B\", \"A/C\"]");
    let prims = format!("def SkelRoot \"R\" {{\n {joints} }}\n def Mesh \"M\" {{\n {STRIP} {BOUND} }} }}\n");
    let joints = told(&prims);
    assert!(joints.contains("has 3 joints and 2 bindTransforms"), "{joints}");
}

#[test]
fn a_skeleton_that_is_nowhere_is_a_warning_and_strictly_an_error() {
    let prims = root("", &BOUND.replace("</R/S>", "</R/None>"));
    let shot = load(METRES, &prims).unwrap();
    let told: Vec<String> = shot.warnings.iter().map(ToString::to_string).collect();
    assert!(told.iter().any(|told| told.contains("the skeleton of /R/M is nowhere")), "{told:?}");
    vertex(&shot, 1.0, DVec3::new(2.0, 1.0, 0.0));
    assert!(scene::load(&folder(METRES, &prims).path().join("m.usda"), true).is_err());
}

//! Is every damaged USD file an error or a warning that says so, and none the end of the program?

use super::*;

fn told(prims: &str) -> String {
    match load(METRES, prims) {
        Ok(shot) => shot.warnings.iter().map(ToString::to_string).collect(),
        Err(error) => error.to_string(),
    }
}

#[test]
fn what_is_damaged_is_told() {
    let good = format!("def Mesh \"M\" {{ {TRIANGLE} }}\n");
    let with = |from: &str, to: &str| good.replace(from, to);
    for (prims, expected) in [
        (with("[0, 1, 2]", "[0, 1, 7]"), "/M is left out: it has a face at point 7, and 3 points"),
        (with("[0, 1, 2]", "[0, -1, 2]"), "/M is left out: it has a face at point -1"),
        (with("[3]", "[2000000000]"), "/M is left out: it has faces with more corners than the 3"),
        (with("(1, 0, 0)", "(nan, 0, 0)"), "/M is left out: a point of it is not finite"),
        (with("def Mesh", "def Xform"), "it shows no meshes with triangles"),
        (String::from("def \"A\" {"), "the USD file cannot be read"),
        (format!("{good}def \"A\" (references = @./m.usda@</A>) {{}}"), "/A refers to itself"),
        (format!("{good}def \"A\" (references = </A/B>) {{ def \"B\" {{}} }}"), "/A refers to itself"),
        (
            format!("{good}def \"A\" (references = @./no.usda@) {{}}"),
            "no.usda`, which /A names, cannot be found",
        ),
        (format!("{good}def \"A\" (references = @./m.usda@</No>) {{}}"), "/No, which /A names, is nowhere"),
        (format!("{good}def \"A\" (references = </No>) {{}}"), "/No, which /A names, is nowhere"),
        (with("uniform", "rel material:binding = </No>\nuniform"), "the material /No is nowhere"),
        (
            format!(
                "{good}def PointInstancer \"P\" {{ rel prototypes = [</P>]\n int[] protoIndices = [0]\n point3f[] positions = [(0, 0, 0)] }}"
            ),
            "/P copies itself",
        ),
        (
            format!(
                "{good}def PointInstancer \"P\" {{ rel prototypes = [</M>]\n int[] protoIndices = [4]\n point3f[] positions = [(0, 0, 0)] }}"
            ),
            "/P is left out: it copies prototype 4, and there are 1",
        ),
        (
            format!("{good}def Camera \"C\" {{ float focalLength = 0 }}"),
            "/C is left out: the camera /C has no field of view",
        ),
        ("def \"A\" {\n".repeat(300) + &"}\n".repeat(300), "nested more than 256 deep"),
    ] {
        let told = told(&prims);
        assert!(told.contains(expected), "{expected}: {told}");
    }
}

/// A quadrilateral, up to its last brace.
const QUAD: &str = "int[] faceVertexCounts = [4]\nint[] faceVertexIndices = [0, 1, 2, 3]\n\
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]\n";

#[test]
fn what_is_damaged_is_left_out_and_all_else_shown() {
    let mesh = |with: &str| format!("def Mesh \"M\" {{ {TRIANGLE} {with} }}");
    let cage = |with: &str| format!("def Mesh \"M\" {{ {QUAD} {with} }}");
    let bad = |from: &str, to: &str| mesh("").replace(from, to);
    let curves = |with: &str| {
        format!(
            "def BasisCurves \"M\" {{ point3f[] points = [(0, 0, 0), (0, 1, 0)]\n uniform token type = \"linear\"\n {with} }}"
        )
    };
    let widths = "float[] widths = [0.1] (interpolation = \"constant\")";
    let none: &[&str] = &["m/N"];
    let both: &[&str] = &["m/M", "m/N"];
    for (prim, expected, shown) in [
        (bad("[0, 1, 2]", "[0, 1, 7]"), "/M is left out: it has a face at point 7, and 3 points", none),
        (bad("[3]", "[-3]"), "/M is left out: it has a face with fewer than no corners", none),
        (bad("[3]", "[3, 3]"), "/M is left out: it has faces with more corners than the 3", none),
        (bad("[0, 1, 2]", "[0, 1, 2, 1]"), "/M names 4 points of corners, and its faces have 3", both),
        (bad("(1, 0, 0)", "(inf, 0, 0)"), "/M is left out: a point of it is not finite", none),
        (
            mesh("normal3f[] normals = [(0, 0, 1), (0, 0, 1)]"),
            "`normals` of /M has 2 values for 3 points",
            both,
        ),
        (
            mesh("texCoord2f[] primvars:st = [(0, 0), (1, 0)] ( interpolation = \"faceVarying\" )"),
            "`primvars:st` of /M has 2 values for 3 corners of faces",
            both,
        ),
        (
            mesh(
                "texCoord2f[] primvars:st = [(0, 0)] ( interpolation = \"vertex\" )\nint[] primvars:st:indices = [0, 0, 4]",
            ),
            "`primvars:st` of /M has the index 4, and 1 values",
            both,
        ),
        (
            mesh("color3f[] primvars:displayColor = [(0, 0, 0), (1, 1, 1)] ( interpolation = \"vertex\" )"),
            "`primvars:displayColor` of /M has 2 values for 3 points",
            both,
        ),
        (
            cage("int[] creaseIndices = [0, 9]\nint[] creaseLengths = [2]\nfloat[] creaseSharpnesses = [3]"),
            "`creaseIndices` of /M names a point that is not among its 4",
            both,
        ),
        (
            cage("int[] creaseIndices = [0, 1]\nint[] creaseLengths = [5]\nfloat[] creaseSharpnesses = [3]"),
            "`creaseLengths` of /M does not fit to its creaseIndices",
            both,
        ),
        (
            cage("int[] cornerIndices = [-1]\nfloat[] cornerSharpnesses = [3]"),
            "`cornerIndices` of /M names a point that is not among its 4",
            both,
        ),
        (curves(&format!("int[] curveVertexCounts = [9]\n{widths}")), "/M is left out: ", none),
        (
            curves(
                "int[] curveVertexCounts = [2]\nfloat[] widths = [1, 2, 3]\nint[] widths:indices = [7, 8]",
            ),
            "/M has no widths that fit",
            both,
        ),
        (
            String::from(
                "def PointInstancer \"M\" { rel prototypes = [</N>]\n int[] protoIndices = [0, 0]\n point3f[] positions = [(0, 0, 0)] }",
            ),
            "/M is left out: it has 2 copies and 1 positions",
            none,
        ),
        (
            String::from("def Sphere \"M\" { double radius = 1e30 }"),
            "/M is left out: it is larger than 1e18",
            none,
        ),
    ] {
        let prims = format!("{prim}\ndef Mesh \"N\" {{ {TRIANGLE} }}\n");
        let folder = folder(METRES, &prims);
        let path = folder.path().join("m.usda");
        let shot = scene::load(&path, false).unwrap();
        let told: Vec<String> = shot.warnings.iter().map(ToString::to_string).collect();
        let [one] = &told[..] else { panic!("{expected}: {told:?}") };
        assert!(one.contains(expected) && one.contains("m.usda"), "{expected}: {one}");
        assert_eq!(names(&shot), shown, "{expected}");
        let strict = scene::load(&path, true).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(strict.contains(expected), "strictly: {expected}: {strict}");
    }
}

/// A binary layer of a mesh, with arrays, a dictionary, times and references.
fn binary() -> Vec<u8> {
    let text = format!(
        "#usda 1.0\n({METRES})\ndef Xform \"X\" (customData = {{ int a = 1\n dictionary d = {{ string b = \"c\"\n }} }}) {{\n\
         double3 xformOp:translate.timeSamples = {{ 1: (0, 0, 0), 2: (0.5, 0, 0) }}\n uniform token[] xformOpOrder = [\"xformOp:translate\"]\n\
         int[] many = [{}]\n float[] more = [{}]\n def Mesh \"M\" {{ {TRIANGLE} }} }}\n\
         def \"R\" (references = </X>) {{}}\n",
        "1, 2, 3, 900, ".repeat(50),
        "0.5, 1, ".repeat(50)
    );
    let mut bytes = std::io::Cursor::new(Vec::new());
    let data = openusd::usda::parse(&text).unwrap();
    openusd::usdc::CrateWriter::write(&data, &mut bytes).unwrap();
    bytes.into_inner()
}

#[test]
fn no_number_of_a_binary_layer_ends_the_program() {
    let good = binary();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.usdc");
    let load = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        scene::load(&path, false)
    };
    assert_eq!(load(&good).unwrap().scene.models.len(), 3, "two meshes and a floor");
    let mut told = 0;
    for at in (0..good.len()).step_by(7) {
        for (bytes, with) in [(8, 0x7f), (4, 0xff), (1, 0x40)] {
            let mut bad = good.clone();
            let end = (at + bytes).min(bad.len());
            bad[at..end].fill(with);
            told += usize::from(load(&bad).is_err_and(|error| error.message.contains("damaged")));
        }
    }
    assert!(told > 100, "{told} of {}", good.len());
    for length in (0..good.len()).step_by(17) {
        assert!(load(&good[..length]).is_err());
    }
}

#[test]
fn references_that_double_each_other_have_an_end() {
    let folder = tempfile::tempdir().unwrap();
    let path = |number: usize| folder.path().join(format!("{number}.usda"));
    for number in 0..31 {
        let next = number + 1;
        let twice = format!("[@./{next}.usda@</A>, @./{next}.usda@</A> (offset = {next})]");
        fs::write(path(number), format!("#usda 1.0\n({METRES})\ndef \"A\" (references = {twice}) {{}}\n"))
            .unwrap();
    }
    fs::write(path(31), format!("#usda 1.0\n({METRES})\ndef \"A\" {{ def Mesh \"M\" {{ {TRIANGLE} }} }}\n"))
        .unwrap();
    let error = scene::load(&path(0), false).err().unwrap();
    assert!(error.message.contains("references that refer twice each double it"), "{error}");
    assert!(scene::load(&path(28), false).is_ok());
}

/// The library would look for the parents of such a name for ever (found by `scripts/fuzz`).
#[test]
fn operations_with_names_that_no_attribute_has_do_nothing() {
    for name in ["a}b", "] }\\ndef ", "xformOp:translate}", "/A.b", ""] {
        let order = format!("uniform token[] xformOpOrder = [\"{name}\"]");
        let prims = format!("def Xform \"A\" {{ {order}\n def Mesh \"M\" {{ {TRIANGLE} }} }}");
        assert!(load(METRES, &prims).is_ok(), "{name}");
    }
}

#[test]
fn what_is_missing_is_an_error_in_a_strict_load() {
    let prims = format!("def Mesh \"M\" {{ {TRIANGLE} }}\ndef \"A\" (references = @./no.usda@) {{}}");
    let folder = folder(METRES, &prims);
    assert!(scene::load(&folder.path().join("m.usda"), false).is_ok());
    let why = scene::load(&folder.path().join("m.usda"), true).err().unwrap().message;
    assert!(why.contains("no.usda"), "{why}");
}

#[test]
fn files_that_are_none_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in [
        ("a.usdc", &b"PXR-USDC\0\0\0\0"[..]),
        ("a.usdz", b"PK\x03\x04"),
        ("a.usd", b"hello"),
        ("a.usda", b""),
    ] {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        let why = scene::load(&path, false).err().unwrap().message;
        assert!(why.contains("the USD file cannot be read"), "{name}: {why}");
    }
}

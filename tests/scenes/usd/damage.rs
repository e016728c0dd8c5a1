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
        (with("[0, 1, 2]", "[0, 1, 7]"), "/M has a face at point 7, and 3 points"),
        (with("[0, 1, 2]", "[0, -1, 2]"), "/M has a face at point -1"),
        (with("[3]", "[2000000000]"), "/M has faces with more corners than the 3"),
        (with("(1, 0, 0)", "(nan, 0, 0)"), "a point of /M is not finite"),
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
            "/P copies prototype 4, and there are 1",
        ),
        (format!("{good}def Camera \"C\" {{ float focalLength = 0 }}"), "/C has no field of view"),
        ("def \"A\" {\n".repeat(300) + &"}\n".repeat(300), "nested more than 256 deep"),
    ] {
        let told = told(&prims);
        assert!(told.contains(expected), "{expected}: {told}");
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

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

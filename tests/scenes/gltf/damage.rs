//! Is every damaged glTF file an error that says so, and none the end of the program?

use super::*;

#[test]
fn what_is_damaged_is_an_error_that_says_so() {
    let good = || {
        let mut file = File::new();
        let positions = file.vectors(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let indices = file.indices(&[0, 1, 2]);
        let mesh =
            file.mesh(json!({"attributes": {"POSITION": positions}, "indices": indices, "material": 0}));
        file.add("materials", json!({}));
        let node = file.root(json!({"mesh": mesh}));
        let there = file.vectors(&[[0.0; 3], [1.0, 0.0, 0.0]]);
        file.animate(node, "translation", "LINEAR", &[0.0, 1.0], there);
        file
    };
    assert_eq!(load(&good(), "").scene.models.len(), 1);
    let mut others = Vec::new();
    for (pointer, value, expected) in [
        ("/nodes/0/children", json!([7]), "it names node 7, and there are 1 of them"),
        ("/nodes/0/children", json!([0]), "node 0 stands below itself"),
        ("/nodes/0/mesh", json!(3), "it names mesh 3"),
        ("/nodes/0/skin", json!(0), "it names skin 0, and there are 0"),
        (
            "/nodes/0/matrix",
            json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            "node 0 has a place that is not finite",
        ),
        ("/nodes/0/translation", json!([1e300, 0, 0]), "node 0 has a place that is not finite"),
        ("/nodes/0/scale", json!([0, 0, 0]), "it shows no triangles"),
        ("/scenes/0/nodes", json!([4]), "it names node 4"),
        ("/scenes/0/nodes", json!([]), "it shows no triangles"),
        ("/scene", json!(2), "it names scene 2"),
        ("/meshes/0/primitives/0/attributes", json!({}), "a mesh has no positions (POSITION)"),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(70), "it names accessor 70"),
        (
            "/meshes/0/primitives/0/attributes/NORMAL",
            json!(2),
            "mesh 0 has 3 positions and 2 entries of NORMAL",
        ),
        ("/meshes/0/primitives/0/indices", json!(3), "accessor 3 has indices that are no whole numbers"),
        ("/meshes/0/primitives/0/mode", json!(9), "mesh 0 has the mode 9"),
        ("/meshes/0/primitives/0/material", json!(9), "it names material 9"),
        ("/accessors/0/count", json!(4), "accessor 0 ends behind its bufferView"),
        ("/accessors/0/count", json!(1_u64 << 62), "accessor 0 has too many elements"),
        ("/accessors/0/byteOffset", json!(u64::MAX), "accessor 0 ends behind its bufferView"),
        ("/accessors/0/componentType", json!(7), "accessor 0 has the componentType 7"),
        ("/accessors/0/type", json!("VEC2"), "accessor 0 is of type VEC2, and 3 numbers are needed"),
        ("/accessors/0/bufferView", json!(40), "it names bufferView 40"),
        ("/accessors/0/count", json!(2), "mesh 0 has a triangle at vertex 2, and 2 vertices"),
        ("/bufferViews/0/byteLength", json!(u64::MAX), "bufferView 0 ends behind buffer 0"),
        ("/bufferViews/0/buffer", json!(1), "it names buffer 1"),
        ("/animations/0/channels/0/sampler", json!(1), "it names animation sampler 1"),
        ("/animations/0/channels/0/target/node", json!(5), "node 5, and there are 1"),
        ("/animations/0/samplers/0/input", json!(0), "accessor 0 is of type VEC3, and 1 numbers are needed"),
        ("/animations/0/samplers/0/output", json!(0), "has not as many values as times"),
        ("/animations/0/samplers/0/interpolation", json!("X"), "has an unknown interpolation"),
        ("/materials/0/emissiveFactor", json!([-1, 0, 0]), "has a colour that is negative"),
        (
            "/materials/0/pbrMetallicRoughness",
            json!({"baseColorTexture": {"index": 3}}),
            "it names texture 3",
        ),
        (
            "/materials/0/extensions",
            json!({"KHR_materials_ior": {"ior": "x"}}),
            "the extension `KHR_materials_ior` makes no sense",
        ),
        ("/asset/version", json!("1.0"), "it is no glTF file of version 2 but of version 1.0"),
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "its geometry is packed with `KHR_draco_mesh_compression`",
        ),
        ("/extensionsRequired", json!(["EXT_new"]), "it requires the extension `EXT_new`"),
        (
            "/buffers",
            json!([{"byteLength": 4, "uri": "../a.bin"}]),
            "buffer 0 `../a.bin` leads out of its folder",
        ),
        ("/buffers", json!([{"byteLength": 4, "uri": "/a.bin"}]), "leads out of its folder"),
        ("/buffers", json!([{"byteLength": 4, "uri": "http://a.b/c"}]), "is no file beside it"),
        (
            "/buffers",
            json!([{"byteLength": 4, "uri": "a.bin"}]),
            "buffer 0 is the file `a.bin`, which cannot be found",
        ),
        (
            "/buffers",
            json!([{"byteLength": 40, "uri": "data:;base64,AAAA"}]),
            "buffer 0 has 3 bytes, and should have 40",
        ),
        ("/buffers", json!([{"byteLength": 4, "uri": "data:;base64,A*"}]), "buffer 0 is not base64"),
        ("/buffers", json!([{"byteLength": 4}]), "buffer 0 has no bytes"),
        ("/nodes", json!(7), "the JSON of this glTF file cannot be read"),
    ] {
        let mut file = good();
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        match file.json.pointer_mut(parent).unwrap() {
            Value::Array(list) => list[key.parse::<usize>().unwrap()] = value,
            object => object[key] = value,
        }
        let error = error(&file);
        if !(error.starts_with("m.gltf: ") && error.contains(expected)) {
            others.push(format!("{pointer}: {error}"));
        }
    }
    assert!(others.is_empty(), "{others:#?}");
    // numbers that are none
    for (bytes, expected) in [
        (f32::NAN.to_le_bytes(), "a position of mesh 0 is not finite"),
        (1e30_f32.to_le_bytes(), "a position of mesh 0 is not finite"),
    ] {
        let mut file = good();
        file.bytes[..4].copy_from_slice(&bytes);
        assert!(error(&file).contains(expected));
    }
    for times in [[1.0, 1.0], [-1.0, 1.0], [0.0, f32::NAN], [0.0, 1e30]] {
        let mut file = good();
        let input = file.floats("SCALAR", 1, &times);
        file.json["animations"][0]["samplers"][0]["input"] = json!(input);
        assert!(error(&file).contains("has times that do not rise from 0 on"), "{times:?}");
    }
}

/// However a file is cut off or changed, it is read or refused, and nothing else.
#[test]
fn no_damage_stops_the_program() {
    let glb = bent().glb();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.glb");
    let mut refused = 0;
    let mut try_out = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        refused += usize::from(scene::load(&path, false).is_err());
    };
    (0..glb.len()).step_by(61).for_each(|end| try_out(&glb[..end]));
    for at in (0..glb.len()).step_by(17) {
        let mut changed = glb.clone();
        changed[at] ^= 0x11;
        try_out(&changed);
    }
    assert!(refused > 50, "{refused}");
}

/// Files of version 1 have tables where others have lists.
#[test]
fn files_of_another_version_are_known_by_it() {
    for (version, expected) in [
        (json!("1.1"), "it is no glTF file of version 2 but of version 1.1: export it as glTF 2.0"),
        (json!(1.5), "it is no glTF file of version 2 but of version 1.5: export it as glTF 2.0"),
        (json!("2.0"), "the JSON of this glTF file cannot be read (invalid type: map, expected a sequence"),
    ] {
        let mut file = File::new();
        file.json["asset"] = json!({"version": version});
        file.json["meshes"] = json!({"mesh": {"primitives": []}});
        let error = error(&file);
        assert!(error.contains(expected), "{error}");
    }
}

//! Are materials and pictures of glTF files what the standard says?

use super::*;
use afterimage::scene::on_mesh::OnMesh;
use afterimage::scene::texture::{Mapping, Wrap};

/// Settles a material.
fn material(json: Value) -> (Material, Vec<String>) {
    let mut file = File::new();
    let mesh = file.triangle();
    file.json["meshes"][mesh]["primitives"][0]["material"] = json!(0);
    file.add("materials", json);
    file.root(json!({"mesh": mesh}));
    let shot = load(&file, "");
    let told = shot.warnings.iter().map(|warning| warning.0.to_string()).collect();
    (shot.scene.materials[0].clone(), told)
}

#[test]
fn materials_are_metal_rough() {
    let pbr = json!({"baseColorFactor": [0.5, 0.25, 1, 0.3], "metallicFactor": 0.25, "roughnessFactor": 0.5});
    let (plain, told) = material(json!({"name": "paint", "pbrMetallicRoughness": pbr}));
    let layer = plain.metal_rough.unwrap();
    assert_eq!((layer.base, layer.roughness, layer.metallic), (Vec3::new(0.5, 0.25, 1.0), 0.5, 0.25));
    assert!((layer.head_on - 0.04).abs() < 1e-6 && layer.solid == 1.0 && plain.optics == Optics::Opaque);
    assert_eq!((plain.name.as_str(), plain.emission), ("paint", Vec3::ZERO));
    assert!(!told.iter().any(|text| text.contains("not used")), "{told:?}");
    let (veil, _) = material(json!({"pbrMetallicRoughness": pbr, "alphaMode": "BLEND"}));
    assert!((veil.metal_rough.unwrap().solid - 0.3).abs() < 1e-6 && veil.name == "material 0");
    assert!(matches!(veil.optics, Optics::Glass { index: 1.0, .. }));
    let dim = json!({"pbrMetallicRoughness": pbr, "alphaMode": "BLEND", "emissiveFactor": [1, 0, 0.5]});
    assert!(material(dim).0.emission.abs_diff_eq(Vec3::new(0.3, 0.0, 0.15), 1e-6), "what is there in part");
    let extensions =
        json!({"KHR_materials_emissive_strength": {"emissiveStrength": 4}, "KHR_materials_ior": {"ior": 2}});
    let (lamp, _) = material(json!({"emissiveFactor": [1, 0.5, 0], "extensions": extensions}));
    assert_eq!(lamp.emission, Vec3::new(4.0, 2.0, 0.0));
    assert!((lamp.metal_rough.unwrap().head_on - 1.0 / 9.0).abs() < 1e-6);
    let (unlit, _) =
        material(json!({"pbrMetallicRoughness": pbr, "extensions": {"KHR_materials_unlit": {}}}));
    assert_eq!(
        (unlit.emission, unlit.diffuse, unlit.metal_rough),
        (Vec3::new(0.5, 0.25, 1.0), Vec3::ZERO, None)
    );
}

#[test]
fn what_transmits_is_glass() {
    let glass = |extensions: Value| {
        let pbr = json!({"baseColorFactor": [1, 0.5, 1, 1], "metallicFactor": 0, "roughnessFactor": 0});
        material(json!({"pbrMetallicRoughness": pbr, "extensions": extensions})).0
    };
    let thin = glass(json!({"KHR_materials_transmission": {"transmissionFactor": 1}}));
    let transmission = Vec3::new(1.0, 0.5, 1.0);
    assert_eq!(
        thin.optics,
        Optics::Glass {
            transmission,
            index: 1.5,
            reflection: Vec3::ONE,
            total: Vec3::ONE,
            is_rough: false,
            is_thin: true
        }
    );
    assert_eq!((thin.diffuse, thin.metal_rough), (Vec3::ZERO, None));
    let solid = glass(
        json!({"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.25},
        "KHR_materials_volume": {"thicknessFactor": 1}}),
    );
    assert_eq!(solid.optics, Optics::clear(transmission, 1.25, Vec3::ONE));
    // a quarter of the green light is left after 0.5 m, an eighth after 0.75 m, however thick it is said to be
    let bottle = glass(json!({"KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_volume": {"thicknessFactor": 0.75, "attenuationDistance": 0.5, "attenuationColor": [1, 0.25, 1]}}));
    assert_eq!(bottle.optics, Optics::clear(transmission, 1.5, Vec3::ONE));
    let left = (-bottle.absorption * 0.75).exp();
    assert!(left.abs_diff_eq(Vec3::new(1.0, 0.125, 1.0), 1e-6), "{left}");
    let half = glass(json!({"KHR_materials_transmission": {"transmissionFactor": 0.5}}));
    assert!(half.diffuse.abs_diff_eq(Vec3::new(0.5, 0.25, 0.5), 1e-6), "{}", half.diffuse);
}

#[test]
fn sheen_is_fuzz_and_diffuse_transmission_is_translucency() {
    let (cloth, told) = material(json!({"extensions": {
        "KHR_materials_sheen": {"sheenColorFactor": [1, 0.5, 0], "sheenRoughnessFactor": 0.25},
        "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.75}}}));
    let fuzz = cloth.fuzz.unwrap();
    assert_eq!((fuzz.weight, fuzz.color, fuzz.roughness), (1.0, Vec3::new(1.0, 0.5, 0.0), 0.25));
    assert_eq!(cloth.scattering.map(|scattering| scattering.through), Some(0.75));
    assert!(!told.iter().any(|text| text.contains("sheen") || text.contains("transmission")), "{told:?}");
    let (plain, _) = material(json!({"extensions": {"KHR_materials_sheen": {"sheenRoughnessFactor": 0.25}}}));
    assert_eq!((plain.fuzz, plain.scattering), (None, None));
}

#[test]
fn coats_are_above_plastic_and_metal() {
    let coat = |factor: f64| json!({"clearcoatFactor": factor, "clearcoatRoughnessFactor": 0.25});
    for (factor, metallic) in [(1.0, 0.0), (0.25, 1.0), (0.0, 0.5)] {
        let pbr = json!({"metallicFactor": metallic, "roughnessFactor": 0.75});
        let extensions = json!({"KHR_materials_clearcoat": coat(factor)});
        let (material, told) = material(json!({"pbrMetallicRoughness": pbr, "extensions": extensions}));
        let layer = material.metal_rough.unwrap();
        assert!(layer.roughness == 0.75 && (layer.head_on - 0.04).abs() < 1e-5, "{layer:?}");
        let coat = material.coat.map(|coat| (coat.weight, coat.roughness, coat.index));
        assert_eq!(coat, (factor > 0.0).then_some((factor as f32, 0.25, 1.5)));
        assert!(!told.iter().any(|text| text.contains("coat")), "{told:?}");
    }
    let extensions = json!({"KHR_materials_clearcoat": coat(1.0), "KHR_materials_transmission": {"transmissionFactor": 1}});
    let (glass, told) =
        material(json!({"pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": extensions}));
    assert!(
        glass.is_rough_glass() && told.iter().any(|text| text.contains("clearcoats of glass")),
        "{told:?}"
    );
}

/// Factor and roughness of a coat are those of their textures on the whole, and leave the surface's own as they are.
#[test]
fn textures_of_coats_count_by_their_means() {
    let mut file = File::new();
    let positions = file.vectors(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let uvs = file.floats("VEC2", 2, &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let picture = |texels| json!({"uri": format!("data:image/png;base64,{}", base64(&png(texels)))});
    file.json["images"] = json!([
        picture([[255, 0, 0, 255], [153, 0, 0, 255]]),
        picture([[0, 102, 0, 255], [0, 204, 0, 255]]),
        picture([[0, 255, 51, 255], [0, 0, 51, 255]]),
    ]);
    file.json["textures"] = json!([{"source": 0}, {"source": 1}, {"source": 2}]);
    let coat = json!({"clearcoatFactor": 1, "clearcoatTexture": {"index": 0}, "clearcoatRoughnessFactor": 0.5,
        "clearcoatRoughnessTexture": {"index": 1}, "clearcoatNormalTexture": {"index": 1}});
    file.json["extensionsRequired"] = json!(["KHR_materials_clearcoat"]);
    file.add(
        "materials",
        json!({"pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": 2}},
        "extensions": {"KHR_materials_clearcoat": coat}}),
    );
    let attributes = json!({"POSITION": positions, "TEXCOORD_0": uvs});
    let mesh = file.mesh(json!({"attributes": attributes, "material": 0}));
    file.root(json!({"mesh": mesh}));
    let shot = load(&file, "");
    let material = &shot.scene.materials[0];
    let coat = material.coat.unwrap();
    assert!((coat.weight - 0.8).abs() < 1e-5 && (coat.roughness - 0.3).abs() < 1e-6, "{coat:?}");
    for (u, roughness) in [(0.25, 1.0), (0.75, 0.0)] {
        let varied = OnMesh::on(&shot.scene.models[0], 0, [u, 0.0]).appearance(&shot.scene, material).1;
        let layer = material.metal_rough.unwrap().at(varied);
        assert!((layer.head_on - 0.04).abs() < 1e-5, "{layer:?}");
        assert!(
            (layer.roughness - roughness).abs() < 1e-2 && (layer.metallic - 0.2).abs() < 1e-3,
            "{layer:?}"
        );
    }
    let told: Vec<String> = shot.warnings.iter().map(|warning| warning.0.to_string()).collect();
    for part in ["by their means", "clearcoatNormalTexture"] {
        assert!(told.iter().filter(|text| text.contains(part)).count() == 1, "{told:?}");
    }
    let read = |mut file: File, coat: Value| {
        file.json["materials"][0]["extensions"]["KHR_materials_clearcoat"] = coat;
        error(&file)
    };
    let odd = read(file, json!({"clearcoatFactor": "much"}));
    assert!(odd.contains("`KHR_materials_clearcoat` makes no sense"), "{odd}");
}

/// A picture of two texels, as PNG.
pub fn png(texels: [[u8; 4]; 2]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
    encoder.set_color(png::ColorType::Rgba);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(texels.as_flattened()).unwrap();
    writer.finish().unwrap();
    bytes
}

#[test]
fn pictures_may_be_in_the_file_or_beside_it() {
    let picture = png([[255, 0, 0, 255], [0, 102, 51, 255]]);
    let mut file = File::new();
    let positions = file.vectors(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let uvs = file.floats("VEC2", 2, &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let view = file.view(&picture);
    let uri = format!("data:image/png;base64,{}", base64(&picture));
    file.json["images"] =
        json!([{"bufferView": view, "mimeType": "image/png"}, {"uri": uri}, {"uri": "maps/my%20wood.png"}]);
    file.json["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}]);
    file.json["textures"] = json!([{"source": 0}, {"source": 1}, {"source": 2, "sampler": 0}]);
    let transform = json!({"KHR_texture_transform": {"offset": [0.25, 0.5], "scale": [2, 4]}});
    let of = |texture: usize| json!({"index": texture, "extensions": transform});
    for texture in 0..3 {
        let pbr = json!({"baseColorTexture": of(texture), "metallicRoughnessTexture": {"index": 1}});
        let json = json!({"name": format!("paint {texture}"), "pbrMetallicRoughness": pbr, "emissiveTexture": {"index": 0},
            "emissiveFactor": [1, 1, 1], "normalTexture": {"index": 0}});
        let material = file.add("materials", json);
        let attributes = json!({"POSITION": positions, "TEXCOORD_0": uvs});
        let mesh = file.mesh(json!({"attributes": attributes, "material": material}));
        file.root(json!({"mesh": mesh}));
    }
    let folder = folder(&file);
    fs::create_dir(folder.path().join("maps")).unwrap();
    fs::write(folder.path().join("maps/my wood.png"), &picture).unwrap();
    let text = format!("{CAMERA}[[model]]\ngltf = \"m.gltf\"\n[[material]]\nname = \"paint 1\"\npr = 0.75\n");
    let shot = load_in(folder.path(), &text, true).unwrap();
    let materials = &shot.scene.materials;
    let colors: Vec<_> =
        materials.iter().take(3).map(|material| material.diffuse_map.unwrap() as usize).collect();
    let wraps = [[Wrap::Repeat; 2], [Wrap::Repeat; 2], [Wrap::Clamp, Wrap::Mirror]];
    for (material, wrap) in materials.iter().zip(wraps) {
        let texture = &shot.scene.textures[material.diffuse_map.unwrap() as usize];
        assert_eq!((texture.size(), texture.texels().get(1).bytes()), ([2, 1], [0, 102, 51, 255]));
        let mapping = Mapping::scaled(Vec2::new(2.0, 4.0), Vec2::new(0.25, -3.5), wrap);
        let is_nearest = wrap[0] == Wrap::Clamp;
        assert_eq!(texture.mapping, Mapping { is_nearest, ..mapping });
    }
    // at the centres of both texels: green is roughness, blue is metal
    for (number, roughness) in [(0, [0.0, 0.4]), (1, [0.75, 0.75]), (2, [0.0, 0.4])] {
        let (material, model) = (&materials[number], &shot.scene.models[number]);
        for (u, metallic, rough, light) in
            [(0.25, 0.0, roughness[0], Vec3::X), (0.75, 0.2, roughness[1], Vec3::new(0.0, 0.132_87, 0.033_1))]
        {
            let varied = OnMesh::on(model, 0, [u, 0.0]).appearance(&shot.scene, material).1;
            let layer = material.metal_rough.unwrap().at(varied);
            let found = [layer.metallic, layer.roughness];
            assert!(Vec2::from(found).abs_diff_eq(Vec2::new(metallic, rough), 1e-6), "{number}: {found:?}");
            assert!(material.emission_at(varied).abs_diff_eq(light, 1e-3), "{number} {u}");
        }
    }
    let name =
        |index: usize| shot.scene.textures[index].path.file_name().unwrap().to_string_lossy().into_owned();
    assert_eq!(
        [name(colors[0]), name(colors[1]), name(colors[2])],
        ["m.gltf#image 0", "m.gltf#image 1", "my wood.png"]
    );
    assert_eq!(shot.files.len(), 3, "the shot, the file and one picture: {:?}", shot.files);
    let told: Vec<String> = shot.warnings.iter().map(|warning| warning.0.to_string()).collect();
    assert_eq!(told, [] as [String; 0]);
    fs::remove_file(folder.path().join("maps/my wood.png")).unwrap();
    let error = load_in(folder.path(), &text, true).unwrap_err();
    assert!(error.contains("the texture `maps/my wood.png` cannot be found"), "{error}");
}

/// A picture of roughness makes glass frosted in places.
#[test]
fn glass_is_as_rough_as_its_picture() {
    let mut file = File::new();
    let positions = file.vectors(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let uvs = file.floats("VEC2", 2, &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let view = file.view(&png([[0, 255, 0, 255], [0, 51, 0, 255]]));
    file.json["images"] = json!([{"bufferView": view, "mimeType": "image/png"}]);
    file.json["textures"] = json!([{"source": 0}]);
    let material = file.add(
        "materials",
        json!({"pbrMetallicRoughness": {"roughnessFactor": 0.5, "metallicRoughnessTexture": {"index": 0}},
            "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1},
                "KHR_materials_volume": {"thicknessFactor": 1}}}),
    );
    let attributes = json!({"POSITION": positions, "TEXCOORD_0": uvs});
    let mesh = file.mesh(json!({"attributes": attributes, "material": material}));
    file.root(json!({"mesh": mesh}));
    let shot = load(&file, "");
    let material = &shot.scene.materials[0];
    assert!(matches!(material.optics, Optics::Glass { index: 1.5, is_rough: true, .. }), "{material:?}");
    // the centres of both texels
    let roughness = [0.25, 0.75].map(|u| {
        let varied = OnMesh::on(&shot.scene.models[0], 0, [u, 0.0]).appearance(&shot.scene, material).1;
        material.metal_rough.unwrap().at(varied).roughness
    });
    assert!(roughness[0] == 0.5 && (roughness[1] - 0.1).abs() < 1e-6, "{roughness:?}");
}

/// The example of the extension's page: "only the lower left quadrant of the source image, rotated clockwise 90°".
#[test]
fn textures_are_turned() {
    let mut file = File::new();
    let positions = file.vectors(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let uvs = file.floats("VEC2", 2, &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let view = file.view(&png([[255; 4]; 2]));
    file.json["images"] = json!([{"bufferView": view, "mimeType": "image/png"}]);
    file.json["textures"] = json!([{"source": 0}]);
    let transform = json!({"offset": [0, 1], "rotation": std::f64::consts::FRAC_PI_2, "scale": [0.5, 0.5]});
    let texture = json!({"index": 0, "extensions": {"KHR_texture_transform": transform}});
    let material = file.add("materials", json!({"pbrMetallicRoughness": {"baseColorTexture": texture}}));
    let attributes = json!({"POSITION": positions, "TEXCOORD_0": uvs});
    let mesh = file.mesh(json!({"attributes": attributes, "material": material}));
    file.root(json!({"mesh": mesh}));
    let folder = folder(&file);
    let shot = load_in(folder.path(), &format!("{CAMERA}[[model]]\ngltf = \"m.gltf\"\n"), true).unwrap();
    // v upwards; what was above on the surface shows what is to the left in the picture
    for (uv, place) in [
        ([0.0, 1.0], [0.0, 0.0]),
        ([1.0, 1.0], [0.0, 0.5]),
        ([0.0, 0.0], [0.5, 0.0]),
        ([1.0, 0.0], [0.5, 0.5]),
    ] {
        let found = shot.scene.textures[0].mapping.at(Vec2::from(uv));
        assert!(found.abs_diff_eq(Vec2::from(place), 1e-6), "{uv:?}: {found}");
    }
}

/// What is unlit shows its texture as light of its own, as opaque as that says.
#[test]
fn unlit_surfaces_show_their_texture_and_its_alpha() {
    let mut file = File::new();
    let positions = file.vectors(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let uvs = file.floats("VEC2", 2, &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let uri = base64(&png([[255, 0, 0, 255], [0, 255, 0, 102]]));
    file.json["images"] = json!([{"uri": format!("data:image/png;base64,{uri}")}]);
    file.json["textures"] = json!([{"source": 0}]);
    let pbr = json!({"baseColorTexture": {"index": 0}, "baseColorFactor": [0.5, 1, 1, 1]});
    file.add(
        "materials",
        json!({"pbrMetallicRoughness": pbr, "alphaMode": "BLEND", "extensions": {"KHR_materials_unlit": {}}}),
    );
    let attributes = json!({"POSITION": positions, "TEXCOORD_0": uvs});
    let mesh = file.mesh(json!({"attributes": attributes, "material": 0}));
    file.root(json!({"mesh": mesh}));
    let scene = load(&file, "").scene;
    let material = &scene.materials[0];
    let shown = [0.25, 0.75].map(|u| {
        let varied = OnMesh::on(&scene.models[0], 0, [u, 0.0]).appearance(&scene, material).1;
        (material.emission_at(varied), varied.of_opacity())
    });
    let green = Vec3::new(0.0, 0.4, 0.0);
    assert_eq!((shown[0], material.diffuse), ((Vec3::new(0.5, 0.0, 0.0), 1.0), Vec3::ZERO));
    assert!(shown[1].0.abs_diff_eq(green, 1e-6) && (shown[1].1 - 0.4).abs() < 1e-6, "{shown:?}");
}

/// Triangles of one colour each, and one whose colour changes: that has the mean of its vertices.
#[test]
fn colours_of_vertices_tint_unlit_surfaces() {
    let mut file = File::new();
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let positions = file.vectors(&[corners, corners, corners, corners].concat());
    let [red, blue] = [[1.0, 0.0, 0.0], [0.0, 0.25, 0.5]];
    let colors = file.vectors(&[red, red, red, blue, blue, blue, red, red, red, red, red, blue]);
    let pbr = json!({"baseColorFactor": [0.5, 1, 1, 1]});
    file.add("materials", json!({"pbrMetallicRoughness": pbr, "extensions": {"KHR_materials_unlit": {}}}));
    let attributes = json!({"POSITION": positions, "COLOR_0": colors});
    let mesh = file.mesh(json!({"attributes": attributes, "material": 0}));
    file.root(json!({"mesh": mesh}));
    let shot = load(&file, "");
    let scene = &shot.scene;
    let mesh = &scene.models[0].mesh;
    let shown = |material: &u16| scene.materials[usize::from(*material)].emission;
    let emissions: Vec<Vec3> = mesh.material_of.iter().map(shown).collect();
    let mixed = Vec3::new(2.0 / 6.0, 0.25 / 3.0, 0.5 / 3.0);
    for (emission, expected) in
        emissions.iter().zip([Vec3::from(blue), mixed, Vec3::new(0.5, 0.0, 0.0), Vec3::new(0.5, 0.0, 0.0)])
    {
        assert!(emission.abs_diff_eq(expected, 1e-6), "{emissions:?}");
    }
    let message = "unlit materials have one colour a triangle";
    assert!(shot.warnings.iter().any(|warning| warning.to_string().contains(message)), "{:?}", shot.warnings);
}

#[test]
fn alpha_cuts_out_what_is_below_the_cutoff() {
    let cutout = |alpha: [u8; 2], json: Value| {
        let mut file = File::new();
        let positions = file.vectors(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let uvs = file.floats("VEC2", 2, &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
        let attributes = json!({"POSITION": positions, "TEXCOORD_0": uvs});
        let mesh = file.mesh(json!({"attributes": attributes, "material": 0}));
        let uri = base64(&png(alpha.map(|alpha| [255, 255, 255, alpha])));
        file.json["images"] = json!([{"uri": format!("data:image/png;base64,{uri}")}]);
        file.json["textures"] = json!([{"source": 0}]);
        file.add("materials", json);
        file.root(json!({"mesh": mesh}));
        let shot = load(&file, "");
        let cut = shot.scene.models[0].mesh.cut.is_some();
        let least = shot.scene.materials[0].cutout.map(|cutout| cutout.least);
        assert_eq!(cut, least.is_some());
        least
    };
    let with = |factor: f64, mode: &str, cutoff: Option<f64>| {
        let pbr = json!({"baseColorTexture": {"index": 0}, "baseColorFactor": [1, 1, 1, factor]});
        let mut json = json!({"pbrMetallicRoughness": pbr, "alphaMode": mode});
        if let Some(cutoff) = cutoff {
            json["alphaCutoff"] = json!(cutoff);
        }
        json
    };
    for (alpha, json, expected) in [
        ([255, 0], with(1.0, "MASK", None), Some(0.5)),
        ([255, 100], with(1.0, "MASK", Some(0.25)), None),
        // as large as a fourth of what the texture says
        ([255, 100], with(0.25, "MASK", Some(0.125)), Some(0.5)),
        ([255, 0], with(1.0, "MASK", Some(0.0)), None),
        ([255, 0], with(1.0, "OPAQUE", None), None),
        // it is seen wherever it shows at all
        ([255, 0], with(1.0, "BLEND", None), Some(0.5 / 255.0)),
        ([255, 253], with(1.0, "BLEND", None), None),
    ] {
        assert_eq!(cutout(alpha, json.clone()), expected, "{alpha:?} {json}");
    }
}

/// A whole file is not lost for a picture that is packed in another way.
#[test]
fn a_stand_in_shows_where_a_texture_is_packed_and_that_is_told_once() {
    let mut file = File::new();
    let mesh = file.triangle();
    file.json["meshes"][mesh]["primitives"][0]["material"] = json!(0);
    file.json["extensionsUsed"] = json!(["KHR_texture_basisu"]);
    file.json["extensionsRequired"] = json!(["KHR_texture_basisu"]);
    file.json["images"] = json!([{"uri": "a.ktx2"}]);
    file.json["textures"] = json!([{"extensions": {"KHR_texture_basisu": {"source": 0}}}]);
    let pbr = json!({"baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 0}});
    file.add("materials", json!({"pbrMetallicRoughness": pbr}));
    file.root(json!({"mesh": mesh}));
    let shot = load(&file, "[[light]]\ntype = \"directional\"\ndirection = [0, 0, -1]\n");
    let told: Vec<String> = shot.warnings.iter().map(|warning| warning.0.to_string()).collect();
    assert_eq!(told.len(), 1, "{told:?}");
    for part in ["texture 0", "KHR_texture_basisu", "PNG or JPEG", "a checker stands in for it"] {
        assert!(told[0].contains(part), "{told:?}");
    }
    assert!(shot.scene.materials.iter().any(|material| material.diffuse_map.is_some()), "the checker");
    let text = format!("{CAMERA}[[model]]\ngltf = \"m.gltf\"\n");
    let strict = load_in(folder(&file).path(), &text, true).map(|_| ()).unwrap_err();
    assert!(strict.contains("KHR_texture_basisu"), "{strict}");
}

#[test]
fn specular_and_glossiness_become_metal_and_roughness() {
    let gloss =
        |values: Value| material(json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": values}}));
    let (paint, told) =
        gloss(json!({"diffuseFactor": [1, 0, 0, 1], "specularFactor": [0, 0, 0], "glossinessFactor": 0.2}));
    assert!(paint.diffuse.x > 0.95 && paint.diffuse.y == 0.0 && paint.diffuse.z == 0.0, "{paint:?}");
    assert_eq!(paint.metal_rough, None, "it reflects nothing");
    let dull =
        json!({"diffuseFactor": [1, 0, 0, 1], "specularFactor": [0.04, 0.04, 0.04], "glossinessFactor": 0.2});
    let layer = gloss(dull).0.metal_rough.unwrap();
    assert!((layer.roughness - 0.8).abs() < 1e-6 && layer.metallic < 1e-6, "{layer:?}");
    assert!(!told.iter().any(|text| text.contains("KHR_")), "{told:?}");
    let gold =
        json!({"diffuseFactor": [0, 0, 0, 1], "specularFactor": [1, 0.77, 0.34], "glossinessFactor": 1});
    let layer = gloss(gold).0.metal_rough.unwrap();
    assert!(layer.base.abs_diff_eq(Vec3::new(1.0, 0.77, 0.34), 0.03) && layer.metallic > 0.98, "{layer:?}");
    let veil = json!({"diffuseFactor": [1, 1, 1, 0.25], "specularFactor": [0, 0, 0]});
    let (veil, _) =
        material(json!({"alphaMode": "BLEND", "extensions": {"KHR_materials_pbrSpecularGlossiness": veil}}));
    assert!((veil.opacity() - 0.25).abs() < 1e-6, "alpha is that of the diffuse colour");
}

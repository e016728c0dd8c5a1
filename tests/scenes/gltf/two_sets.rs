//! Do textures of a material take the texture coordinates that they name, where it has two sets of them?

use super::*;
use afterimage::frame::Finished;
use afterimage::scene::material::Computes;
use afterimage::trace::BackendKind;

/// Texture coordinates of a square's corners, from the one to the left below, counter-clockwise.
type Corners = [f32; 8];

/// All of a picture.
const UPRIGHT: Corners = [0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0];

/// All of a picture, turned by a quarter: what is to the left in it is below.
const TURNED: Corners = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0];

const WHITE: [u8; 4] = [255; 4];
const BLACK: [u8; 4] = [0, 0, 0, 255];
const RED: [u8; 4] = [255, 0, 0, 255];
const GREEN: [u8; 4] = [0, 255, 0, 255];

/// A square of side 2 around the origin with these sets of texture coordinates; its material has `pictures`.
fn square(sets: &[Corners], material: Value, pictures: &[[[u8; 4]; 2]]) -> File {
    let mut file = File::new();
    let uri = |texels: &[[u8; 4]; 2]| json!({"uri": format!("data:image/png;base64,{}", base64(&materials::png(*texels)))});
    file.json["images"] = pictures.iter().map(uri).collect();
    file.json["samplers"] = json!([{"wrapS": 33071, "wrapT": 33071}]);
    file.json["textures"] =
        (0..pictures.len()).map(|source| json!({"source": source, "sampler": 0})).collect();
    let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let positions = file.vectors(&corners);
    let normals = file.vectors(&[[0.0, 0.0, 1.0]; 4]);
    let mut attributes = json!({"POSITION": positions, "NORMAL": normals});
    for (number, set) in sets.iter().enumerate() {
        attributes[format!("TEXCOORD_{number}")] = json!(file.floats("VEC2", 2, set));
    }
    let indices = file.indices(&[0, 1, 2, 0, 2, 3]);
    file.add("materials", material);
    let mesh = file.mesh(json!({"attributes": attributes, "indices": indices, "material": 0}));
    file.root(json!({"mesh": mesh}));
    file
}

fn shot(file: &File) -> Shot {
    let text = "[render]\nsize = [48, 36]\nsamples = 2\n[[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n\
        [[camera.key]]\nframe = 5\neye = [0.4, 0.2, 4]\ntarget = [0, 0, 0]\n\
        [[light]]\ntype = \"directional\"\ndirection = [0, 0, -1]\n[[model]]\ngltf = \"m.gltf\"\n";
    load_in(folder(file).path(), text, false).unwrap()
}

/// Renders frames, and audits them.
fn frames(shot: &Shot, backend: BackendKind) -> Vec<Finished> {
    let settings = Settings { audit: true, mode: Mode::Reproject, ..shot.settings.clone() };
    let mut renderer = Renderer::with(backend, &shot.scene, &settings).unwrap();
    let render = |frame| {
        let finished = renderer.render(frame, true).unwrap();
        let audit = finished.stats.audit.unwrap();
        assert_eq!(audit.differing, 0, "{backend:?}, frame {frame}: {audit:?}");
        finished
    };
    (1..=4).map(render).collect()
}

/// The colour goes from left to right, and emission from below to above: each quarter shows one of each.
#[test]
fn each_texture_takes_the_set_that_it_names() {
    let material = json!({
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 2}},
        "emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 1, "texCoord": 1},
    });
    let file =
        square(&[UPRIGHT, TURNED], material, &[[BLACK, WHITE], [RED, GREEN], [GREEN, [0, 128, 0, 255]]]);
    let shot = shot(&file);
    let told: Vec<String> = shot.warnings.iter().map(|warning| warning.0.to_string()).collect();
    assert!(!told.iter().any(|text| text.contains("texture coordinates")), "{told:?}");
    let material = &shot.scene.materials[0];
    assert!(material.is_computed(Computes::Roughness) && material.is_computed(Computes::Emission));
    for backend in [BackendKind::Embree, BackendKind::Rust] {
        let finished = frames(&shot, backend);
        let planes = ["R", "G", "B"].map(|name| finished[0].film.values(name).unwrap());
        // nearer to the edges than the centres of texels are
        let at = |x: usize, y: usize| [0, 1, 2].map(|plane: usize| planes[plane][y * 48 + x]);
        for (x, is_white) in [(16, false), (31, true)] {
            for (y, glows) in [(25, 0), (10, 1)] {
                let color = at(x, y);
                let is_lit = color[2] > 0.2;
                assert!(is_lit == is_white, "{backend:?} {x} {y}: {color:?}");
                let [glow, other] = [color[glows] - color[2], color[1 - glows] - color[2]];
                assert!((glow - 1.0).abs() < 0.05 && other.abs() < 0.05, "{backend:?} {x} {y}: {color:?}");
            }
        }
    }
}

/// Emission and normals show the same, to the bit, whether their coordinates are the first set or the second one, beside one by which
/// a picture would be a hundred times as fine: the places over which they are filtered are those of their own set, too.
#[test]
fn the_second_set_is_as_good_as_the_first() {
    let of = |sets: &[Corners]| {
        let set = sets.len() - 1;
        let material = json!({
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0},
            "normalTexture": {"index": 2, "texCoord": set},
            "emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 1, "texCoord": set},
        });
        let pictures = [[WHITE; 2], [RED, GREEN], [[200, 90, 220, 255], [60, 150, 240, 255]]];
        let mut file = square(sets, material, &pictures);
        file.json["samplers"] = json!([{}]);
        shot(&file)
    };
    let scaled = |corners: Corners, by: f32| corners.map(|coordinate| coordinate * by - 1.0);
    let [one, two] = [of(&[scaled(TURNED, 3.0)]), of(&[scaled(UPRIGHT, 300.0), scaled(TURNED, 3.0)])];
    assert!(one.scene.models[0].mesh.details.second_uvs.is_empty(), "costs nothing");
    assert!(!two.scene.models[0].mesh.details.second_uvs.is_empty());
    for backend in [BackendKind::Embree, BackendKind::Rust] {
        for (one, two) in frames(&one, backend).iter().zip(&frames(&two, backend)) {
            assert!(one.film == two.film, "{backend:?}");
        }
    }
}

/// A normal map bends along its own texture coordinates, whatever those of the colour are.
#[test]
fn tangents_are_those_of_the_normal_map() {
    let tangents = |sets: &[Corners], set: u32| {
        let material = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
            "normalTexture": {"index": 1, "texCoord": set}});
        let file = square(sets, material, &[[BLACK, WHITE], [[200, 90, 220, 255], [60, 150, 240, 255]]]);
        shot(&file).scene.models[0].mesh.details.tangents.clone()
    };
    let turned = tangents(&[TURNED], 0);
    assert!(!turned.is_empty() && turned == tangents(&[UPRIGHT, TURNED], 1));
    assert_ne!(turned, tangents(&[UPRIGHT, TURNED], 0));
}

#[test]
fn a_third_set_is_told() {
    let material = json!({
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
        "normalTexture": {"index": 1, "texCoord": 1},
        "emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 1, "texCoord": 2},
    });
    let file = square(&[UPRIGHT, TURNED, TURNED], material, &[[BLACK, WHITE], [[128, 128, 255, 255]; 2]]);
    let shot = shot(&file);
    let told: Vec<String> = shot.warnings.iter().map(|warning| warning.0.to_string()).collect();
    assert!(told.iter().filter(|text| text.contains("a third one")).count() == 1, "{told:?}");
    let material = &shot.scene.materials[0];
    assert!(material.normal_map.is_some() && !material.is_computed(Computes::Emission));
}

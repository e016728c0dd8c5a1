//! Does the alpha of vertices (COLOR_0) count as the standard says?

use super::*;
use afterimage::animation::Track;
use afterimage::film::Film;
use afterimage::layers::Layers;
use afterimage::scene::LightKind;
use afterimage::scene::cutout::{Asks, CutoutTest};
use afterimage::trace::BackendKind;
use glam::DVec3;

/// Squares side by side, four vertices each from the one to the left below, counter-clockwise, of material 0.
struct Squares {
    file: File,
    count: u16,
}

impl Squares {
    /// Squares of a material; `picture` is its texture, if it names one.
    fn new(material: Value, picture: Option<[[u8; 4]; 2]>) -> Self {
        let mut file = File::new();
        file.add("materials", material);
        if let Some(texels) = picture {
            let uri = format!("data:image/png;base64,{}", base64(&materials::png(texels)));
            file.json["images"] = json!([{"uri": uri}]);
            file.json["textures"] = json!([{"source": 0}]);
        }
        Self { file, count: 0 }
    }

    /// Adds a square as a mesh of its own.
    fn with(mut self, alphas: [f32; 4]) -> Self {
        let left = f32::from(self.count) * 3.0;
        let corners = [[left, 0.0, 0.0], [left + 2.0, 0.0, 0.0], [left + 2.0, 2.0, 0.0], [left, 2.0, 0.0]];
        let positions = self.file.vectors(&corners);
        let uvs = self.file.floats("VEC2", 2, &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
        let colors = self.file.floats("VEC4", 4, alphas.map(|alpha| [1.0, 1.0, 1.0, alpha]).as_flattened());
        let indices = self.file.indices(&[0, 1, 2, 0, 2, 3]);
        let attributes = json!({"POSITION": positions, "TEXCOORD_0": uvs, "COLOR_0": colors});
        let mesh = self.file.mesh(json!({"attributes": attributes, "indices": indices, "material": 0}));
        self.file.root(json!({"mesh": mesh}));
        self.count += 1;
        self
    }

    fn load(&self) -> Shot {
        load(&self.file, "")
    }
}

/// Alphas that fall from 1 on the left to 0 on the right.
const FALLING: [f32; 4] = [1.0, 0.0, 0.0, 1.0];

fn masked(factor: f32, cutoff: f32) -> Value {
    let pbr = json!({"baseColorFactor": [1, 1, 1, factor], "metallicFactor": 0});
    json!({"pbrMetallicRoughness": pbr, "alphaMode": "MASK", "alphaCutoff": cutoff})
}

fn told(shot: &Shot) -> Vec<String> {
    shot.warnings
        .iter()
        .map(|warning| warning.0.to_string())
        .filter(|text| text.contains("COLOR_0"))
        .collect()
}

#[test]
fn the_product_of_all_alphas_is_compared_with_the_cutoff() {
    let mut textured = masked(0.8, 0.25);
    textured["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
    for (material, picture, of_picture, least) in [
        (masked(1.0, 0.5), None, 1.0, 0.5),
        (masked(0.5, 0.25), None, 1.0, 0.5),
        // the same alpha all over the picture: the centre of each texel says it
        (textured, Some([[255, 255, 255, 153]; 2]), 0.6, 0.25 / 0.8),
    ] {
        let shot = Squares::new(material.clone(), picture).with(FALLING).load();
        let mesh = &shot.scene.models[0].mesh;
        let test = CutoutTest::new(mesh).unwrap();
        let mut there = 0;
        for (triangle, i, j) in
            (0..2).flat_map(|t| (0..20_u8).flat_map(move |i| (0..20 - i).map(move |j| (t, i, j))))
        {
            let [u, v] = [i, j].map(|at| (f32::from(at) + 0.3) / 20.6);
            let corners = mesh.triangles().corners[triangle as usize].map(|corner| FALLING[corner as usize]);
            let alpha = corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v;
            let is_there = test.is_there(triangle, [u, v], Asks::Sight);
            assert_eq!(is_there, alpha * of_picture >= least, "{material}: {alpha}");
            there += u32::from(is_there);
        }
        assert!((100..320).contains(&there), "{there} of 420");
        assert_eq!(told(&shot), [] as [&str; 0]);
    }
}

#[test]
fn what_no_alpha_cuts_is_whole() {
    let opaque = json!({"pbrMetallicRoughness": {"metallicFactor": 0}});
    for (material, alphas) in [(opaque, FALLING), (masked(1.0, 0.5), [1.0; 4]), (masked(1.0, 0.0), FALLING)] {
        let shot = Squares::new(material.clone(), None).with(alphas).load();
        let mesh = &shot.scene.models[0].mesh;
        assert!(mesh.cut.is_none() && mesh.details.alphas.is_empty(), "{material}");
        assert_eq!(told(&shot), [] as [&str; 0]);
    }
}

/// A surface that is half there all over is a veil; one whose alpha changes is cut out, and that is told.
#[test]
fn even_alpha_is_a_factor_of_blended_materials() {
    let pbr = json!({"baseColorFactor": [1, 1, 1, 0.5], "metallicFactor": 0});
    let squares = Squares::new(json!({"pbrMetallicRoughness": pbr, "alphaMode": "BLEND"}), None);
    let shot = squares.with([0.5; 4]).with([0.25; 4]).with([1.0; 4]).with([0.5; 4]).with(FALLING).load();
    let solid = |model: &Model| {
        let material = &shot.scene.materials[usize::from(model.mesh.material_of[0])];
        (material.metal_rough.unwrap().solid, model.mesh.cut.is_some())
    };
    let models: Vec<_> =
        shot.scene.models.iter().filter(|model| model.name.contains("node")).map(solid).collect();
    assert_eq!(models, [(0.25, false), (0.125, false), (0.5, false), (0.25, false), (0.5, true)]);
    let told = told(&shot);
    assert!(told.len() == 1 && told[0].contains("less than half there"), "{told:?}");
}

fn blended(factor: f32) -> Value {
    let texture = json!({"index": 0});
    let pbr =
        json!({"baseColorFactor": [1, 0.5, 0.2, factor], "metallicFactor": 0, "baseColorTexture": texture});
    json!({"pbrMetallicRoughness": pbr, "alphaMode": "BLEND"})
}

/// A square of a blended material, before a wall that glows in a lamp's light.
fn before_a_wall(material: Value, texels: [[u8; 4]; 2]) -> Squares {
    let mut squares = Squares::new(material, Some(texels)).with([1.0; 4]);
    let wall = json!({"emissiveFactor": [0, 0.2, 0], "pbrMetallicRoughness": {"metallicFactor": 0}});
    let wall = squares.file.add("materials", wall);
    let corners = squares.file.vectors(&[[-9.0, -9.0, -2.0], [9.0, -9.0, -2.0], [0.0, 20.0, -2.0]]);
    let mesh = squares.file.mesh(json!({"attributes": {"POSITION": corners}, "material": wall}));
    squares.file.root(json!({"mesh": mesh}));
    squares
}

fn shot_of(squares: &Squares, paths: u32) -> Shot {
    let text = format!(
        "[render]\nsamples = 2\n[indirect]\npaths = {paths}\n[[camera.key]]\nframe = 1\neye = [1, 1, 9]\ntarget = [1, 1, 0]\n\
        [[camera.key]]\nframe = 5\neye = [1.4, 1.2, 8]\ntarget = [1, 1, 0]\n\
        [[light]]\ntype = \"point\"\nposition = [3, 4, 6]\npower = 60\n[[model]]\ngltf = \"m.gltf\"\n"
    );
    load_in(folder(&squares.file).path(), &text, false).unwrap()
}

/// Renders four frames, audited, and returns the first picture.
fn first_of_audited(shot: &Shot, backend: BackendKind) -> Arc<Film> {
    let settings =
        Settings { width: 64, height: 48, audit: true, mode: Mode::Reproject, ..shot.settings.clone() };
    let mut renderer = Renderer::with(backend, &shot.scene, &settings).unwrap();
    let mut films = (1..=4).map(|frame| {
        let finished = renderer.render(frame, true).unwrap();
        let audit = finished.stats.audit.unwrap();
        assert_eq!(audit.differing, 0, "{backend:?}, frame {frame}: {audit:?}");
        finished.film
    });
    let first = films.next().unwrap();
    films.for_each(drop);
    first
}

/// A picture that is as clear all over is as good as that factor where there are no shadows.
#[test]
fn blended_alpha_of_a_picture_is_that_of_a_veil() {
    for (byte, factor) in [(102, 0.4_f32), (153, 0.6)] {
        let rendered = |material, alpha: u8| {
            let mut shot = shot_of(&before_a_wall(material, [[255, 255, 255, alpha]; 2]), 0);
            shot.scene.lights.clear();
            let settings = Settings { width: 64, height: 48, reflections: 0, ..shot.settings.clone() };
            let mut renderer = Renderer::with(BackendKind::Embree, &shot.scene, &settings).unwrap();
            let film = renderer.render(1, true).unwrap().film;
            (["R", "G", "B"].map(|name| film.values(name).unwrap().to_vec()), shot)
        };
        let (of_picture, shot) = rendered(blended(1.0), byte);
        assert!(shot.scene.models.iter().any(|model| model.mesh.cut.is_some()), "it is a mask's");
        let (of_factor, shot) = rendered(blended(factor), 255);
        assert!(shot.scene.models.iter().all(|model| model.mesh.cut.is_none()), "nothing is cut out");
        assert!(of_picture == of_factor, "{factor}");
        let (solid, _) = rendered(blended(1.0), 255);
        assert!(of_picture != solid, "{factor}");
    }
}

/// The shadow of a square that is so opaque is so dark, in the mean.
#[test]
fn blended_surfaces_dim_the_light_by_their_alpha() {
    let light_behind = |alpha: u8| {
        let mut shot = shot_of(&before_a_wall(blended(1.0), [[255, 255, 255, alpha]; 2]), 0);
        // along the line of sight: the middle of the square hides its own shadow
        shot.scene.lights[0].kind = LightKind::Directional { direction: Track::constant(DVec3::NEG_Z) };
        let settings =
            Settings { width: 48, height: 48, depth: 1, layers: Layers::ALL, ..shot.settings.clone() };
        let mut renderer = Renderer::with(BackendKind::Embree, &shot.scene, &settings).unwrap();
        let film = renderer.render(1, true).unwrap().film;
        let seen = film.values("refraction.R").unwrap();
        let inner: Vec<f32> = (20..28).flat_map(|y| seen[y * 48 + 20..y * 48 + 28].to_vec()).collect();
        inner.iter().sum::<f32>() / inner.len() as f32 / (1.0 - f32::from(alpha) / 255.0)
    };
    let open = light_behind(3);
    for alpha in [51, 128, 204] {
        let expected = 1.0 - f32::from(alpha) / 255.0;
        let share = light_behind(alpha) / open * (1.0 - 3.0 / 255.0);
        // few parts of two texels are behind the middle, each of which stops light or does not
        assert!((share - expected).abs() < 0.1, "{alpha}: {share}, not {expected}");
    }
}

/// A picture that is opaque on its left, and fades to the right, for both tracers.
#[test]
fn reuse_is_exact_where_alpha_is_blended() {
    let shot = shot_of(&before_a_wall(blended(0.9), [[255, 255, 255, 255], [250, 250, 250, 0]]), 2);
    assert!(shot.scene.materials.iter().any(|material| material.is_blended()));
    for backend in [BackendKind::Embree, BackendKind::Rust] {
        let first = first_of_audited(&shot, backend);
        // the left of the square hides the wall but for its factor's tenth; the right shows it
        let blue = first.values("B").unwrap();
        let [left, right] = [27, 36].map(|x| blue[24 * 64 + x]);
        assert!(right > left + 0.1, "{left} {right}");
    }
}

/// Beside each other: a square that falls off to the right, and one that is there. Both tracers see the left half of the first, and
/// what is behind in its right half; reuse is exact.
#[test]
fn both_tracers_see_through_what_is_cut_out() {
    let mut squares = Squares::new(masked(1.0, 0.5), None).with(FALLING).with([1.0; 4]);
    let lamp =
        json!({"emissiveFactor": [0, 1, 0], "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]}});
    let lamp = squares.file.add("materials", lamp);
    let wall = squares.file.vectors(&[[-9.0, -9.0, -2.0], [9.0, -9.0, -2.0], [0.0, 20.0, -2.0]]);
    let mesh = squares.file.mesh(json!({"attributes": {"POSITION": wall}, "material": lamp}));
    squares.file.root(json!({"mesh": mesh}));
    let shot = shot_of(&squares, 2);
    for backend in [BackendKind::Embree, BackendKind::Rust] {
        let first = first_of_audited(&shot, backend);
        // to the left and to the right of the middle of the first square; beyond it the wall shows as well
        let [red, green] = ["R", "G"].map(|name| first.values(name).unwrap());
        let shows = |x: usize| (red[24 * 64 + x] > 0.1, green[24 * 64 + x] == 1.0);
        assert_eq!([28, 35, 42].map(shows), [(true, false), (false, true), (false, true)], "{backend:?}");
    }
}

/// Alpha of a material with the mode MASK counts without a texture and without vertices, too.
#[test]
fn what_the_factor_cuts_is_absent() {
    for (factor, cutoff, is_there) in
        [(0.3, 0.5, false), (0.3, 0.2, true), (0.5, 0.5, true), (1.0, 1.1, false)]
    {
        let mut file = File::new();
        file.add("materials", masked(factor, cutoff));
        let cut = file.triangle();
        file.json["meshes"][cut]["primitives"][0]["material"] = json!(0);
        let plain = file.triangle();
        file.root(json!({"mesh": plain}));
        file.root(json!({"mesh": cut}));
        let shot = load(&file, "");
        assert_eq!(shot.scene.models.len(), 1 + usize::from(is_there), "{factor} {cutoff}");
    }
}

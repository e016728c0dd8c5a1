//! Does any damage to a file make a reader panic, instead of telling an error? `MUTATIONS=100000` tries more of it, and
//! `scripts/fuzz` looks for it. `AFTERIMAGE_SEEDS` names a folder to which the whole files are written, for `fuzz/seeds`.

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use afterimage::scene;

use crate::gltf;
use crate::small_shot::{MTL, folder};

/// Number of damaged files of each kind, if nobody says otherwise.
const USUAL: u64 = 150;

const OBJ: &str = "mtllib m.mtl\no Cube\nv 0 0 0\nv 1 0 0 1\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0.5\nvn 0 0 1\nusemtl clear\nf 1/1/1 2/2/1 3/1/1\n\
                   g top side\nusemtl wood\nf -3 -1 -2\ns 1\nf 1//1 2//1 4//1 3//1\nf 1 2 4 3 1\nl 1 2\n";
const CURVES: &str = "# three\nbasis catmull-rom\nradius 0.1 0.02\ncurve 0.5 0.25\n0 0 0\n0 1 0.5\n0 2 0\ncurve 0 1\n1 0 0\n1 2 0 0.3\n\
    curve 1 1\n2 0 0 0.1\n2 0 0 0.1\n2 1 1e3 0.2\n";

const SHOT_OF_CURVES: &str = "[[camera.key]]\nframe = 1\neye = [0, 0, 9]\ntarget = [0, 0, 0]\n[[model]]\ncurves = { file = \"m.curves\" }\n";

const PLY: &str = "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 4\nproperty float x\nproperty double y\nproperty float z\nproperty float s\n\
                   property float t\nelement face 2\nproperty list uchar int vertex_indices\nproperty uchar flags\nend_header\n0 0 0 0 0\n1 0 0 1 0\n\
                   1 1 0 1 1\n0 1 0 0 1\n4 0 1 2 3 7\n3 0 1 2 7\n";
const SHOT: &str = "[render]\nsize = [64, 36]\nframes = \"1-4\"\nsamples = { min = 1, max = 2 }\n[camera]\ninterpolation = \"smooth\"\n\
                    [[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n[[camera.key]]\nframe = 4\norbit = [10, 20, 3]\n\
                    target = [0, 0, 0]\n[[model]]\nobj = \"m.obj\"\nsplit = \"groups\"\nmatrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]\n\
                    [[model.key]]\nframe = 1\n[[model.key]]\nframe = 2\nscale = 2\n[[light]]\ntype = \"spot\"\nposition = [0, 5, 0]\n\
                    target = [0, 0, 0]\n[[material]]\nname = \"wood\"\nkd = [1, 0, 0]\n";

/// A shot whose material is that of a MaterialX file.
const SHOT_OF_MTLX: &str = "[[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n[[model]]\nobj = \"m.obj\"\n\
                            [[material]]\nname = \"wood\"\nmtlx = \"m.mtlx\"\n";
const MTLX: &str = "<?xml version=\"1.0\"?>\n<materialx version=\"1.39\">\n<nodegraph name=\"G\">\n\
                    <blender_noise name=\"n\" type=\"multioutput\"><input name=\"scale\" type=\"float\" value=\"3\"/>\
                    <input name=\"vector\" type=\"vector3\" nodename=\"p\"/></blender_noise>\n<position name=\"p\" type=\"vector3\"/>\n\
                    <blender_color_ramp name=\"r\" type=\"multioutput\"><input name=\"factor\" type=\"float\" nodename=\"n\" output=\"value\"/>\
                    <input name=\"stops\" type=\"floatarray\" value=\"0, 0, 0, 0, 1, 0.5, 1, 0, 0, 1\"/></blender_color_ramp>\n\
                    <image name=\"i\" type=\"color3\"><input name=\"file\" type=\"filename\" value=\"a.png\"/></image>\n\
                    <mix name=\"m\" type=\"color3\"><input name=\"fg\" type=\"color3\" nodename=\"r\"/>\
                    <input name=\"bg\" type=\"color3\" nodename=\"i\"/><input name=\"mix\" type=\"float\" value=\"0.5\"/></mix>\n\
                    <output name=\"out\" type=\"color3\" nodename=\"m\"/>\n</nodegraph>\n<open_pbr_surface name=\"S\" type=\"surfaceshader\">\
                    <input name=\"base_color\" type=\"color3\" nodegraph=\"G\" output=\"out\"/></open_pbr_surface>\n\
                    <surfacematerial name=\"wood\" type=\"material\"><input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"S\"/>\
                    </surfacematerial>\n</materialx>\n";

/// What is put in place of a part of a file.
const WORDS: [&[u8]; 16] = [
    b"",
    b"0",
    b"-1",
    b"1e39",
    b"nan",
    b"99999999999",
    b"4294967295",
    b"\n",
    b"\"",
    b"[",
    b"{",
    b"\0",
    b"\xFF\xFE",
    b"/",
    b" ",
    b"\x80",
];

/// Numbers that look random, and are the same in each run (a linear congruence, D. Knuth's MMIX).
struct Dice(u64);

impl Dice {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % end.max(1)
    }
}

/// The file with up to four parts replaced, repeated or left out.
fn mutated(whole: &[u8], seed: u64) -> Vec<u8> {
    let mut dice = Dice(seed);
    let mut file = whole.to_vec();
    for _ in 0..=dice.below(4) {
        let begin = dice.below(file.len());
        let end = (begin + dice.below(9)).min(file.len());
        match dice.below(4) {
            0 => file.truncate(if dice.below(8) == 0 { begin } else { file.len() }),
            1 => {
                let part = file[begin..end].to_vec();
                file.splice(begin..begin, part);
            }
            _ => {
                let word = WORDS[dice.below(WORDS.len())];
                file.splice(begin..end, word.iter().copied());
            }
        }
    }
    file
}

/// Loads `asked` with damaged versions of the file `name`, whose content is `whole`.
fn try_all(name: &str, whole: &[u8], asked: &str) {
    let count = std::env::var("MUTATIONS").ok().and_then(|count| count.parse().ok()).unwrap_or(USUAL);
    if let Some(seeds) = std::env::var_os("AFTERIMAGE_SEEDS") {
        let name = format!("{}-{name}", whole.len());
        fs::write(Path::new(&seeds).join(name), whole).unwrap();
    }
    let folder = folder();
    fs::write(folder.path().join("m.obj"), OBJ).unwrap();
    fs::write(folder.path().join("m.toml"), SHOT_OF_MTLX).unwrap();
    fs::write(folder.path().join("c.toml"), SHOT_OF_CURVES).unwrap();
    let load = |path: &Path| drop(scene::load(path, false));
    for seed in 0..count {
        fs::write(folder.path().join(name), mutated(whole, seed)).unwrap();
        let asked = folder.path().join(asked);
        let outcome = catch_unwind(AssertUnwindSafe(|| load(&asked)));
        assert!(
            outcome.is_ok(),
            "{name} panics with seed {seed}: {:?}",
            String::from_utf8_lossy(&mutated(whole, seed))
        );
    }
}

#[test]
fn damaged_obj_files_are_told() {
    try_all("m.obj", OBJ.as_bytes(), "m.obj");
}

#[test]
fn damaged_mtl_files_are_told() {
    let mtl = format!("{MTL}map_Kd -s 2 2 -clamp on a b.png\nPr 0.5\nTr 0.2\nillum 9\nNs 1e3\n");
    try_all("m.mtl", mtl.as_bytes(), "m.obj");
}

#[test]
fn damaged_mtlx_files_are_told() {
    try_all("m.mtlx", MTLX.as_bytes(), "m.toml");
}

#[test]
fn damaged_ply_files_are_told() {
    try_all("m.ply", PLY.as_bytes(), "m.ply");
    let binary = PLY.split("0 0 0 0 0").next().unwrap().replace("ascii", "binary_little_endian");
    let values = [&[0; 4 * 24][..], &[3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 7].repeat(2)].concat();
    try_all("m.ply", &[binary.as_bytes(), &values].concat(), "m.ply");
}

#[test]
fn damaged_curves_are_told() {
    try_all("m.curves", CURVES.as_bytes(), "c.toml");
}

#[test]
fn damaged_shot_files_are_told() {
    try_all("s.toml", SHOT.as_bytes(), "s.toml");
}

#[test]
fn damaged_gltf_files_are_told() {
    let (text, binary) = gltf::whole_files();
    try_all("m.gltf", text.as_bytes(), "m.gltf");
    try_all("m.glb", &binary, "m.glb");
}

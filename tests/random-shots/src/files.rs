//! The files that shots name: small meshes, textures and maps, each made of its own name. A mesh is called
//! `SHAPE-MATERIAL.obj`, and one of its deformed shapes `SHAPE-MATERIAL.NUMBER.obj`; as [glTF](crate::glb) it is
//! `SHAPE-MATERIAL.MOTION.glb`. [Graphs](crate::mtlx) of materials are `NUMBER.mtlx`. Shapes of small things have their sizes in their names: `SHAPE<WIDTH>x<GAP>`, both in thousandths of how far
//! the things are strewn.

use std::fmt::Write;

use crate::dice::Dice;
use crate::{glb, mtlx, vdb};

/// Shapes that a mesh may have, with what each of them is for.
pub const SHAPES: [&str; 11] = [
    "cube",    // closed, flat faces on the planes of its box
    "quad",    // thin: a box without extent along z
    "floor",   // thin along y, large
    "sliver",  // a triangle a hundred times as long as wide
    "tetra",   // closed, no face along an axis
    "ball",    // closed, smooth normals
    "sheet",   // open, smooth normals, many triangles in one plane
    "room",    // open to +Z, seen from inside
    "double",  // two quads in the same place
    "leaning", // a quad that no axis is parallel to
    "crossed", // three quads that pass through each other
];

/// Shapes of many small things, with what each of them is for.
pub const SMALL_SHAPES: [&str; 8] = [
    "dots",    // squares in one plane, each as wide as high
    "streaks", // upright ones, ten times as high as wide
    "slats",   // upright bars close before a wall of the same mesh
    "grate",   // bars across each other, open between them
    "foliage", // triangles that look to all sides
    "layers",  // squares one behind the other, some in the same place
    "tiles",   // squares that share their edges, as wide as high
    "rods",    // square rods that stand out of a wall of the same mesh, towards +Z
];

/// Materials that meshes name: the last part of a mesh's name. Those of two, as in `m0+m3`, have them in turn.
pub const MATERIALS: [&str; 6] = ["m0", "m1", "m2", "m3", "m4", "m5"];

/// Curves that models may be: thick loops, fur of thin hairs, chains whose links meet at sharp corners, balls as USD's points are.
pub const CURVES: [&str; 4] = ["loops.curves", "fur.curves", "chains.curves", "beads.curves"];

/// Textures that materials may name.
pub const TEXTURES: [&str; 3] = ["checks.bmp", "black.bmp", "fine.bmp"];

/// Opacity that cuts holes out; numbers elsewhere.
pub const HOLES: &str = "holes.bmp";

/// Directions of normals, some of which lie in the surface or point into it.
pub const NORMALS: &str = "normals.bmp";

/// The environment map.
pub const MAP: &str = "around.hdr";

/// A cloud of lumps, and the graph of what is in it and in meshes.
pub const CLOUD: &str = "cloud.vdb";
/// Others, each there in a frame of its own.
pub const CLOUDS: &str = "cloud.##.vdb";
pub const SMOKE: &str = "smoke.mtlx";

/// Name of the material of clouds.
pub const OF_CLOUD: &str = "cloud";

/// What a file of this name holds; none for a name that no generated shot uses.
pub fn content(name: &str) -> Option<Vec<u8>> {
    match name {
        "plain.mtl" => Some(mtl().into_bytes()),
        "checks.bmp" => Some(bmp(4, |x, y| if (x + y) % 2 == 0 { [250, 240, 230] } else { [30, 60, 90] })),
        // finer than most cells are
        "fine.bmp" => {
            Some(bmp(256, |x, y| [(x * 37 + y * 11) as u8, (x ^ y) as u8, if x % 2 == 0 { 9 } else { 250 }]))
        }
        "black.bmp" => Some(bmp(4, |_, _| [0, 0, 0])),
        HOLES => Some(bmp(4, |x, y| [(40 + 70 * (x * 3 + y * 5) % 200) as u8; 3])),
        NORMALS => {
            Some(bmp(4, |x, y| [(64 * x) as u8, (200 - 40 * y) as u8, (255 - 50 * ((x + y) % 4)) as u8]))
        }
        MAP => Some(hdr()),
        "loops.curves" => Some(loops().into_bytes()),
        "fur.curves" => Some(fur().into_bytes()),
        "chains.curves" => Some(chains().into_bytes()),
        "beads.curves" => Some(beads().into_bytes()),
        _ if name.ends_with(".curves") => {
            let (stem, bend) = name.strip_suffix(".curves")?.split_once('.')?;
            let rest = content(&format!("{stem}.curves"))
                .filter(|_| CURVES.contains(&&*format!("{stem}.curves")))?;
            Some(bent_curves(std::str::from_utf8(&rest).ok()?, bend.parse().ok()?).into_bytes())
        }
        CLOUD => Some(vdb::cloud(0)),
        _ if name.ends_with(".vdb") => {
            let number = name.strip_prefix("cloud.")?.strip_suffix(".vdb")?.parse().ok()?;
            Some(vdb::cloud(number))
        }
        SMOKE => Some(mtlx::smoke().into_bytes()),
        _ if name.ends_with(".mtlx") => {
            Some(mtlx::file(name.strip_suffix(".mtlx")?.parse().ok()?).into_bytes())
        }
        _ if name.ends_with(".glb") => {
            let (named, motion) = name.strip_suffix(".glb")?.split_once('.')?;
            let (shape, material) = named.split_once('-')?;
            glb::MOTIONS.contains(&motion).then(|| Some(glb::file(&Mesh::of(shape)?, material, motion)))?
        }
        _ => {
            let mut parts = name.strip_suffix(".obj")?.split('.');
            let (shape, material) = parts.next()?.split_once('-')?;
            let bend = parts.next().map_or(Some(0), |number| number.parse().ok())?;
            Some(obj(&Mesh::of(shape)?, material, bend).into_bytes())
        }
    }
}

/// All materials, matt; shots say otherwise.
fn mtl() -> String {
    MATERIALS.iter().fold(String::new(), |mut text, name| {
        let _ = writeln!(text, "newmtl {name}\nKd .7 .7 .7\nKa .7 .7 .7\nillum 1");
        text
    })
}

/// Corners and faces, counted from 0.
#[derive(Debug, Default)]
pub struct Mesh {
    pub corners: Vec<[f64; 3]>,
    pub faces: Vec<Vec<usize>>,
    pub is_smooth: bool,
}

impl Mesh {
    fn of(shape: &str) -> Option<Self> {
        let mut mesh = Self::default();
        match shape {
            "cube" => mesh.add_box(0.5),
            "quad" => mesh.add_quad([[-1., -1., 0.], [1., -1., 0.], [1., 1., 0.], [-1., 1., 0.]]),
            "floor" => mesh.add_quad([[-3., 0., 3.], [3., 0., 3.], [3., 0., -3.], [-3., 0., -3.]]),
            "leaning" => {
                mesh.add_quad([[-1., -0.5, 0.3], [0.9, -0.7, -0.4], [1., 0.5, -0.3], [-0.9, 0.7, 0.4]])
            }
            "sliver" => mesh.add(&[[-1.5, 0., 0.], [1.5, 0.02, 0.], [1.5, 0., 0.03]]),
            "tetra" => {
                let [a, b, c, d] = [[0., 1., 0.], [-0.9, -0.5, 0.6], [0.8, -0.5, 0.7], [0.1, -0.6, -1.]];
                [[a, b, c], [a, c, d], [a, d, b], [b, d, c]].iter().for_each(|face| mesh.add(face));
            }
            "ball" => mesh.add_ball(8, 5),
            "sheet" => mesh.add_sheet(4),
            "room" => {
                let [x, y, z] = [2.5, 2., 2.5];
                mesh.add_quad([[-x, -y, z], [x, -y, z], [x, -y, -z], [-x, -y, -z]]);
                mesh.add_quad([[-x, y, -z], [x, y, -z], [x, y, z], [-x, y, z]]);
                mesh.add_quad([[-x, -y, -z], [x, -y, -z], [x, y, -z], [-x, y, -z]]);
                mesh.add_quad([[-x, -y, z], [-x, -y, -z], [-x, y, -z], [-x, y, z]]);
                mesh.add_quad([[x, -y, -z], [x, -y, z], [x, y, z], [x, y, -z]]);
            }
            "double" => {
                for _ in 0..2 {
                    mesh.add_quad([[-1., -1., 0.], [1., -1., 0.], [1., 1., 0.], [-1., 1., 0.]]);
                }
            }
            "crossed" => {
                mesh.add_quad([[-1., -1., 0.], [1., -1., 0.], [1., 1., 0.], [-1., 1., 0.]]);
                mesh.add_quad([[0., -1., -1.], [0., -1., 1.], [0., 1., 1.], [0., 1., -1.]]);
                mesh.add_quad([[-1., 0., 1.], [1., 0., 1.], [1., 0., -1.], [-1., 0., -1.]]);
            }
            "speck" => mesh.add_box(0.5),
            "brink" => mesh.add_quad([[-4., 0., 4.], [4., 0., 4.], [4., 0., -4.], [-4., 0., -4.]]),
            _ => {
                let digits = shape.find(|character: char| character.is_ascii_digit())?;
                let (shape, sizes) = shape.split_at(digits);
                let (width, gap) = sizes.split_once('x')?;
                let [width, gap] = [width, gap].map(|size| size.parse::<f64>().ok());
                mesh.add_small(shape, width? / 1000.0, gap? / 1000.0)?;
            }
        }
        Some(mesh)
    }

    /// Things as wide as `width`, from -1 to 1, `gap` before what is behind them.
    fn add_small(&mut self, shape: &str, width: f64, gap: f64) -> Option<()> {
        const MOST_BARS: usize = 40;
        const MOST_TILES: usize = 21;
        let mut dice = Dice::new(0x0005_0A11);
        // as many bars as there is room for with twice their width between them
        let bars = ((2.0 / (3.0 * width)) as usize).clamp(1, MOST_BARS);
        let bar = |number: usize| (2 * number + 1) as f64 / bars as f64 - 1.0;
        match shape {
            "dots" => (0..40).for_each(|_| {
                let at = [dice.between(-1.0, 1.0), dice.between(-1.0, 1.0), 0.0];
                self.add_upright(at, [width, width]);
            }),
            "streaks" => (0..24).for_each(|_| {
                let at = [0; 3].map(|_| dice.between(-1.0, 1.0));
                self.add_upright(at, [width, 10.0 * width]);
            }),
            "slats" => {
                self.add_upright([0.0; 3], [2.0, 2.0]);
                (0..bars).for_each(|number| self.add_upright([bar(number), 0.0, gap], [width, 2.0]));
            }
            "grate" => (0..bars).for_each(|number| {
                self.add_upright([bar(number), 0.0, 0.0], [width, 2.0]);
                self.add_upright([0.0, bar(number), gap], [2.0, width]);
            }),
            "tiles" => {
                // an odd number, so that tiles that share an edge have not the same material
                let count = ((2.0 / width) as usize).clamp(1, MOST_TILES) | 1;
                let at = |number: usize| (number as f64 - count as f64 / 2.0) * width;
                for (row, column) in (0..count).flat_map(|row| (0..count).map(move |column| (row, column))) {
                    let [[left, right], [low, high]] =
                        [column, row].map(|number| [at(number), at(number + 1)]);
                    self.add_quad([
                        [left, low, 0.0],
                        [right, low, 0.0],
                        [right, high, 0.0],
                        [left, high, 0.0],
                    ]);
                }
            }
            "foliage" => (0..60).for_each(|_| {
                let middle = [0; 3].map(|_| dice.between(-1.0, 1.0));
                let corners = [0; 3].map(|_| {
                    let aside = [0; 3].map(|_| dice.between(-1.0, 1.0));
                    [0, 1, 2].map(|axis| middle[axis] + width * aside[axis])
                });
                self.add(&corners);
            }),
            "layers" => {
                for (number, behind) in [0.0, 0.0, gap, gap, 2.0 * gap].into_iter().enumerate() {
                    self.add_upright([0.1 * number as f64, 0.05 * number as f64, -behind], [1.5, 1.5]);
                }
            }
            "rods" => {
                self.add_upright([0.0; 3], [2.0, 2.0]);
                (0..20).for_each(|_| {
                    let at = [dice.between(-1.0, 1.0), dice.between(-1.0, 1.0), 0.5 * gap];
                    let rod = Self::cuboid(at, [width, width, gap]);
                    let first = self.corners.len();
                    self.corners.extend(rod.corners);
                    let faces = rod.faces.into_iter();
                    self.faces.extend(faces.map(|face| face.iter().map(|corner| corner + first).collect()));
                });
            }
            _ => return None,
        }
        Some(())
    }

    /// A rectangle that looks to +Z, about `middle`.
    fn add_upright(&mut self, [x, y, z]: [f64; 3], [width, height]: [f64; 2]) {
        let [w, h] = [width / 2.0, height / 2.0];
        self.add_quad([[x - w, y - h, z], [x + w, y - h, z], [x + w, y + h, z], [x - w, y + h, z]]);
    }

    /// A box of that size, about `middle`.
    fn cuboid(middle: [f64; 3], size: [f64; 3]) -> Self {
        let mut mesh = Self::default();
        mesh.add_box(0.5);
        for corner in &mut mesh.corners {
            *corner = [0, 1, 2].map(|axis| middle[axis] + size[axis] * corner[axis]);
        }
        mesh
    }

    /// Normals of a smooth mesh, one for each corner; not all of them have unit length.
    pub fn normals(&self) -> Vec<[f64; 3]> {
        let is_flat = self.corners.iter().all(|[_, y, _]| *y == 0.0);
        self.corners.iter().map(|corner| if is_flat { [0., 1., 0.] } else { *corner }).collect()
    }

    fn add(&mut self, corners: &[[f64; 3]]) {
        let first = self.corners.len();
        self.corners.extend(corners);
        self.faces.push((first..self.corners.len()).collect());
    }

    fn add_quad(&mut self, corners: [[f64; 3]; 4]) {
        self.add(&corners);
    }

    fn add_box(&mut self, h: f64) {
        let corner = |i: usize| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { -h } else { h });
        for face in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            self.add_quad(face.map(corner));
        }
    }

    fn add_ball(&mut self, columns: usize, rows: usize) {
        use std::f64::consts::{PI, TAU};
        self.is_smooth = true;
        for row in 0..=rows {
            for column in 0..columns {
                let (turn, down) = (column as f64 / columns as f64 * TAU, row as f64 / rows as f64 * PI);
                let place = [down.sin() * turn.cos(), down.cos(), -down.sin() * turn.sin()];
                self.corners.push(place.map(|at| at * 0.7));
            }
        }
        let at = |row: usize, column: usize| row * columns + column % columns;
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            let [upper, lower] = [row, row + 1].map(|row| [at(row, column), at(row, column + 1)]);
            if row > 0 {
                self.faces.push(vec![upper[0], lower[0], upper[1]]);
            }
            if row + 1 < rows {
                self.faces.push(vec![upper[1], lower[0], lower[1]]);
            }
        }
    }

    fn add_sheet(&mut self, cells: usize) {
        self.is_smooth = true;
        let at = |i: usize| 2.4 * (i as f64 / cells as f64 - 0.5);
        for (i, j) in (0..=cells).flat_map(|i| (0..=cells).map(move |j| (i, j))) {
            self.corners.push([at(j), 0.0, -at(i)]);
        }
        for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
            let first = i * (cells + 1) + j;
            self.faces.push(vec![first, first + 1, first + cells + 2, first + cells + 1]);
        }
    }
}

/// `bend`: which of its shapes; 0 is that at rest.
fn obj(mesh: &Mesh, material: &str, bend: u32) -> String {
    let mut text = String::from("mtllib plain.mtl\n");
    let strength = f64::from(bend) * 0.25;
    for [x, y, z] in &mesh.corners {
        let bent = [x + strength * 0.3 * y, y + strength * x * z, z * (1.0 + 0.2 * strength)];
        let _ = writeln!(text, "v {} {} {}", bent[0], bent[1], bent[2]);
    }
    for [x, y, z] in &mesh.corners {
        let _ = writeln!(text, "vt {} {}", x + 0.3 * z, y + 0.7 * z);
    }
    if mesh.is_smooth {
        for [x, y, z] in mesh.normals() {
            let _ = writeln!(text, "vn {x} {y} {z}");
        }
    }
    let materials: Vec<&str> = material.split('+').collect();
    for (number, face) in mesh.faces.iter().enumerate() {
        if number < materials.len() || materials.len() > 1 {
            let _ = writeln!(text, "usemtl {}", materials[number % materials.len()]);
        }
        text.push('f');
        for corner in face.iter().map(|corner| corner + 1) {
            let _ = match mesh.is_smooth {
                true => write!(text, " {corner}/{corner}/{corner}"),
                false => write!(text, " {corner}/{corner}"),
            };
        }
        text.push('\n');
    }
    // what only cages have: sharp for ever, for a while, and a point
    if mesh.corners.len() >= 4 {
        text.push_str("t crease 3/2/0 0 1 2 10 1.4\nt corner 1/1/0 3 2.5\n");
    }
    text
}

/// 4 x 4 pixels, 24 bits each.
fn bmp(side: usize, color: impl Fn(usize, usize) -> [u8; 3]) -> Vec<u8> {
    const HEADER: u32 = 54;
    let mut bytes = Vec::from(*b"BM");
    let pixels = (side * side * 3) as u32;
    for word in [HEADER + pixels, 0, HEADER, 40, side as u32, side as u32] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend(1_u16.to_le_bytes());
    bytes.extend(24_u16.to_le_bytes());
    for word in [0, pixels, 0, 0, 0, 0] {
        bytes.extend(word.to_le_bytes());
    }
    for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
        let [red, green, blue] = color(x, y);
        bytes.extend([blue, green, red]);
    }
    bytes
}

/// 8 x 4 pixels: dim, with one bright spot.
/// Curves of B-splines that go around each other, thicker here and thinner there, with a colour each.
fn loops() -> String {
    let mut text = String::from("basis bspline\n");
    for turn in 0..3 {
        text.push_str("curve\n");
        for step in 0..9 {
            let (along, around) = (f64::from(step) / 8.0, f64::from(step) * 1.3 + f64::from(turn) * 2.1);
            let [x, y, z] = [0.6 * around.cos(), 2.0 * along - 1.0, 0.6 * around.sin()];
            let radius = 0.05 + 0.06 * f64::from((step + turn) % 3);
            let [red, green] = [f64::from(turn) / 2.0, along];
            _ = writeln!(text, "{x} {y} {z} {radius} {red} {green} 0.4");
        }
    }
    text
}

/// Hairs on a square, with texture coordinates, that bend away from its middle and end in tips.
fn fur() -> String {
    let mut text = String::from("basis catmull-rom\nradius 0.02 0\n");
    for hair in 0..144 {
        let [x, z] = [hair % 12, hair / 12].map(|at| (f64::from(at) + 0.3) / 6.0 - 1.0);
        _ = writeln!(text, "curve {} {}", 0.5 + 0.5 * x, 0.5 + 0.5 * z);
        for step in 0..4 {
            let up = f64::from(step) / 3.0;
            _ = writeln!(text, "{} {} {}", x * (1.0 + 0.5 * up * up), 0.6 * up, z * (1.0 + 0.3 * up * up));
        }
    }
    text
}

/// Straight pieces that fold back on themselves, and points with a sphere each that hold others.
fn chains() -> String {
    let mut text = String::from("radius 0.12\n");
    for chain in 0..3 {
        text.push_str("curve\n");
        let x = f64::from(chain) - 1.0;
        for step in 0..6 {
            let (side, up) = (f64::from(step % 2) - 0.5, 0.35 * f64::from(step) - 0.9);
            let radius = if step == 3 { 0.3 } else { 0.05 + 0.04 * f64::from(step) };
            _ = writeln!(text, "{} {up} {} {radius}", x + 0.6 * side, 0.4 * side);
        }
    }
    text
}

/// Balls, a curve each: its sphere holds all of it. Some overlap, and their colours differ.
fn beads() -> String {
    let mut text = String::new();
    for bead in 0..40 {
        let turn = f64::from(bead);
        let [x, y, z] = [(turn * 2.4).cos(), turn / 20.0 - 1.0, (turn * 2.4).sin()];
        let radius = 0.05 + 0.04 * f64::from(bead % 5);
        let [red, green] = [f64::from(bead % 3) / 2.0, turn / 40.0];
        _ = writeln!(
            text,
            "curve\n{x} {y} {z} {radius} {red} {green} 0.4\n{x} {} {z} 0 {red} {green} 0.4",
            y + 0.5 * radius
        );
    }
    text
}

/// The same curves with other points: they lean and shrink, and what has a radius of its own grows thin. In their second shape the upper ones lie in
/// one plane, where curves that stand upright have no length. Of those that grow, by numbers from 101 on, the first shape is a thirtieth as large.
fn bent_curves(text: &str, bend: u32) -> String {
    let (size, bend) = (if bend == 101 { 1.0 / 30.0 } else { 1.0 }, bend % 100);
    let strength = f64::from(bend) * 0.25;
    let mut bent = String::new();
    for line in text.lines() {
        let numbers: Option<Vec<f64>> = line.split(' ').map(|word| word.parse().ok()).collect();
        let Some([x, y, z, rest @ ..]) = numbers.as_deref() else {
            bent += line;
            bent.push('\n');
            continue;
        };
        let [x, y, z] = [x * size, y * size, z * size];
        let y = if bend == 2 { y.min(0.1) } else { y };
        _ = write!(
            bent,
            "{} {} {}",
            x + strength * 0.5 * y,
            y * (1.0 - 0.3 * strength),
            z + strength * x * y
        );
        for (at, number) in rest.iter().enumerate() {
            let thinner = if at == 0 { (1.0 - 0.6 * strength) * size } else { 1.0 };
            _ = write!(bent, " {}", number * thinner);
        }
        bent.push('\n');
    }
    bent
}

fn hdr() -> Vec<u8> {
    let mut bytes = Vec::from(*b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n");
    for pixel in 0..32_u8 {
        // mantissas and the exponent that they share, 128 above the true one
        bytes.extend(if pixel == 11 { [200, 190, 160, 132] } else { [60 + pixel, 90, 120, 126] });
    }
    bytes
}

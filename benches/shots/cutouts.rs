//! Cost of cut-outs: a cloud of leaves and a fence over a floor. The same leaves are quads without cut-outs, quads that are asked about
//! and are there all over, quads of which a picture leaves the leaf, and leaves that are modelled: the second shows what asking
//! costs, the last what rays cost that meet nothing but leaves.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use afterimage::frame::Renderer;
use afterimage::scene;
use afterimage::settings::Settings;
use afterimage::trace::BackendKind;
use glam::{Mat3, Vec2, Vec3};
use serde::Serialize;

use super::fastest::{Speeds, fastest};
use super::table::{Circumstances, write_json};
use super::{Arguments, folder};

/// Number of leaves.
const LEAVES: u32 = 400;

/// Number of bars of the fence.
const BARS: u32 = 8;

/// Texels along an edge of the pictures.
const TEXELS: u32 = 64;

/// Corners of a modelled leaf.
const CORNERS: u32 = 48;

/// What leaves are made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Leaves {
    Whole,
    Asked,
    Cut,
    Modelled,
}

impl Leaves {
    const ALL: [Self; 4] = [Self::Whole, Self::Asked, Self::Cut, Self::Modelled];

    fn name(self) -> &'static str {
        match self {
            Self::Whole => "whole quads",
            Self::Asked => "asked, all there",
            Self::Cut => "cut out",
            Self::Modelled => "modelled",
        }
    }
}

/// A line of the table.
#[derive(Debug, Clone, Serialize)]
struct Row {
    leaves: &'static str,
    tracer: &'static str,
    /// Of the fastest frame.
    #[serde(flatten)]
    speeds: Speeds,
}

type Failable<T> = Result<T, Box<dyn Error>>;

/// Measures; prints a table.
pub fn run(arguments: &Arguments) -> Failable<()> {
    let circumstances = Circumstances::now(arguments);
    println!("{}\n", circumstances.text());
    println!("| leaves           | tracer |  full s | primary M/s | shadow M/s | paths M/s |");
    println!("|------------------|--------|---------|-------------|------------|-----------|");
    let folder = folder();
    let shots = Leaves::ALL.map(|leaves| Ok((leaves, write(leaves, &folder)?)));
    let shots: Vec<_> = shots.into_iter().collect::<Failable<_>>()?;
    let mut rows = Vec::new();
    for kind in [BackendKind::Embree, BackendKind::Rust] {
        for (leaves, shot) in &shots {
            rows.push(measure(kind, *leaves, shot, arguments)?);
        }
    }
    let path = folder.join("cutouts.json");
    write_json(&path, &circumstances, &rows)?;
    println!("\nalso in {}", path.display());
    Ok(())
}

fn measure(kind: BackendKind, leaves: Leaves, shot: &Path, arguments: &Arguments) -> Failable<Row> {
    let shot = scene::load(shot, true)?;
    let [width, height] = arguments.size();
    let settings = Settings { width, height, samples: 2, layers: arguments.layers(), ..shot.settings };
    let mut renderer = Renderer::with(kind, &shot.scene, &settings)?;
    let (_, speeds) = fastest(&mut renderer, 1, arguments)?;
    let row = Row { leaves: leaves.name(), tracer: kind.name(), speeds };
    println!(
        "| {:<16} | {:<6} | {:7.3} | {:11.1} | {:10.1} | {:9.1} |",
        row.leaves,
        row.tracer,
        speeds.full_seconds,
        speeds.primary_speed,
        speeds.shadow_speed,
        speeds.bounced_speed,
    );
    Ok(row)
}

/// Half the width of a leaf at `along`, 0 at its stalk to 1 at its tip: an ellipse with teeth.
fn half_width(along: f32) -> f32 {
    let ellipse = (along * (1.0 - along)).max(0.0).sqrt();
    ellipse * (0.62 + 0.06 * (along * 60.0).sin())
}

/// Returns true if a leaf is there at `uv`, 0 to 1.
fn is_leaf(uv: Vec2) -> bool {
    (uv.x - 0.5).abs() < half_width((uv.y - 0.05) / 0.9)
}

/// Returns true if a bar of the fence is there at `uv`, 0 to 1.
fn is_bar(uv: Vec2) -> bool {
    (uv.x * BARS as f32).fract() < 0.4
}

/// Writes a picture whose alpha is that of `is_there`: an uncompressed TGA.
fn write_picture(path: &Path, is_there: impl Fn(Vec2) -> bool) -> Failable<()> {
    let size = (TEXELS as u16).to_le_bytes();
    // 32 bits a texel, rows from the bottom
    let mut bytes = vec![0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, size[0], size[1], size[0], size[1], 32, 8];
    for i in 0..TEXELS * TEXELS {
        let uv = Vec2::new((i % TEXELS) as f32 + 0.5, (i / TEXELS) as f32 + 0.5) / TEXELS as f32;
        bytes.extend([40, 120, 60, if is_there(uv) { 255 } else { 0 }]);
    }
    Ok(fs::write(path, bytes)?)
}

/// An OBJ in the making.
#[derive(Default)]
struct Obj {
    text: String,
    vertices: u32,
}

impl Obj {
    /// Adds a polygon that is a fan around its first corner; each corner with its place on a picture.
    fn fan(&mut self, material: &str, corners: &[(Vec3, Vec2)]) {
        let first = self.vertices + 1;
        for (Vec3 { x, y, z }, uv) in corners {
            let _ = writeln!(self.text, "v {x} {y} {z}\nvt {} {}", uv.x, uv.y);
        }
        let _ = writeln!(self.text, "usemtl {material}");
        self.vertices += corners.len() as u32;
        for next in first + 1..self.vertices {
            let _ = writeln!(self.text, "f {first}/{first} {next}/{next} {0}/{0}", next + 1);
        }
    }

    /// Adds what is there of a rectangle at `corner` with these edges.
    fn rectangle(&mut self, material: &str, [corner, right, up]: [Vec3; 3], [low, high]: [Vec2; 2]) {
        let corners = [low, Vec2::new(high.x, low.y), high, Vec2::new(low.x, high.y)];
        self.fan(material, &corners.map(|uv| (corner + right * uv.x + up * uv.y, uv)));
    }
}

/// Writes the shot with such `leaves`; returns its path.
fn write(leaves: Leaves, folder: &Path) -> Failable<std::path::PathBuf> {
    let name = format!("leaves-{}", leaves.name().replace([' ', ','], ""));
    let mut mtl = String::from("newmtl floor\nKd 0.5 0.5 0.5\n");
    let all = |uv: Vec2| uv != Vec2::splat(0.5 / TEXELS as f32);
    for (material, is_there) in [("leaf", is_leaf as fn(Vec2) -> bool), ("fence", is_bar)] {
        let picture = format!("{name}-{material}.tga");
        let _ = writeln!(mtl, "newmtl {material}\nKd 0.2 0.5 0.2");
        match leaves {
            Leaves::Whole | Leaves::Modelled => {}
            // all but one texel: a picture that is there all over would not be asked
            Leaves::Asked => write_picture(&folder.join(&picture), all)?,
            Leaves::Cut => write_picture(&folder.join(&picture), is_there)?,
        }
        if matches!(leaves, Leaves::Asked | Leaves::Cut) {
            let _ = writeln!(mtl, "map_d -imfchan m {picture}");
        }
    }
    fs::write(folder.join(format!("{name}.mtl")), mtl)?;

    let mut obj = Obj { text: format!("mtllib {name}.mtl\n"), ..Obj::default() };
    let whole = [Vec2::ZERO, Vec2::ONE];
    obj.rectangle("floor", [Vec3::new(-6.0, 0.0, 6.0), Vec3::X * 12.0, Vec3::NEG_Z * 12.0], whole);
    let mut state = 1_u32;
    let mut random = || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    for _ in 0..LEAVES {
        let place = Vec3::new(random() * 5.0 - 2.5, random() * 3.0 + 0.3, random() * 3.0 - 1.5);
        let turn = Mat3::from_rotation_y(random() * 6.3) * Mat3::from_rotation_x(random() * 3.0 - 1.5);
        let quad = [place, turn * Vec3::X * 0.5, turn * Vec3::Y * 0.5];
        match leaves {
            Leaves::Modelled => {
                let rim = |i: u32| {
                    let turned = i as f32 / CORNERS as f32 * 2.0;
                    let (along, side) = if turned < 1.0 { (turned, 1.0) } else { (2.0 - turned, -1.0) };
                    Vec2::new(0.5 + side * half_width(along), 0.05 + 0.9 * along)
                };
                let corners: Vec<_> = std::iter::once(Vec2::splat(0.5))
                    .chain((0..=CORNERS).map(|i| rim(i % CORNERS)))
                    .map(|uv| (quad[0] + quad[1] * uv.x + quad[2] * uv.y, uv))
                    .collect();
                obj.fan("leaf", &corners);
            }
            _ => obj.rectangle("leaf", quad, whole),
        }
    }
    let fence = [Vec3::new(-3.0, 0.0, 2.0), Vec3::X * 6.0, Vec3::Y * 1.2];
    match leaves {
        Leaves::Modelled => (0..BARS).for_each(|bar| {
            let [low, high] = [bar as f32, bar as f32 + 0.4].map(|x| x / BARS as f32);
            obj.rectangle("fence", fence, [Vec2::new(low, 0.0), Vec2::new(high, 1.0)]);
        }),
        _ => obj.rectangle("fence", fence, whole),
    }
    fs::write(folder.join(format!("{name}.obj")), obj.text)?;

    let shot = format!(
        "[indirect]\npaths = 4\n[[model]]\nobj = \"{name}.obj\"\n\
         [[camera.key]]\nframe = 1\neye = [0.5, 2.2, 6.0]\ntarget = [0.0, 1.6, 0.0]\nfov = 46\n\
         [environment.sky]\nelevation = 40\n\
         [[light]]\ntype = \"directional\"\ndirection = [-0.4, -1.0, -0.5]\npower = 1.5\n"
    );
    let path = folder.join(format!("{name}.toml"));
    fs::write(&path, shot)?;
    Ok(path.canonicalize()?)
}

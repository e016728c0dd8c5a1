//! Makes a shot of a seed: a small room of things, each of which rests, moves, jumps, comes or goes, under lights that do the
//! same, seen by a camera that does the same, with settings of every kind.
//!
//! A shot is a TOML table, as its file would be. So whatever shots can say may be in one, and a shot that fails can be cut down
//! key by key ([`shrink`](crate::shrink)) without knowing what its keys mean.

mod camera;
mod graphs;
mod hostile;
mod lights;
mod links;
mod materials;
mod media;
pub mod mirrors;
mod models;
pub mod rays;
mod settings;
pub mod small;
mod still_world;
mod subdivision;
mod tracks;

use toml::{Table, Value};

use crate::dice::Dice;

/// One shot in so many has values at their limits, or beyond.
const HOSTILE: usize = 16;

/// Copies have dice of their own: without them a shot is what it was before there were any.
const COPIES: u64 = 0x00C0_71E5;

/// So have the meshes that come from glTF files.
const GLTF: u64 = 0x0061_7F00;

/// And small things.
const SMALL: u64 = 0x0005_0A11;

/// And what rays of each kind see.
const RAYS: u64 = 0x0002_A5EE;

/// And the error that is wanted.
const ERROR: u64 = 0x000E_2202;

/// And whether nothing moves but the camera.
const STILL_WORLD: u64 = 0x5713_1103;

/// And graphs of materials.
const GRAPHS: u64 = 0x6EA0_4500;

/// And links of lights.
const LINKS: u64 = 0x0011_4B5E;
/// And what is subdivided or displaced.
const SUBDIVISION: u64 = 0x5B_D171_DE00;
/// And media.
const MEDIA: u64 = 0x6D15_7000;
/// And flat mirrors.
const MIRRORS: u64 = 0x313A_1200;

/// The shot of this seed.
pub fn generate(seed: u64) -> Table {
    let mut dice = Dice::new(seed);
    let dice = &mut dice;
    let span = settings::Span::roll(dice);
    let camera = camera::Choice::roll(dice);
    let mut shot = Table::new();
    settings::add(dice, &span, camera, &mut shot);
    camera::add(dice, &span, camera, &mut shot);
    models::add(dice, &span, &mut shot);
    materials::add(dice, &mut shot);
    lights::add(dice, &span, &mut shot);
    if dice.one_in(HOSTILE) {
        hostile::spoil(dice, &mut shot);
    }
    models::add_copies(&mut Dice::new(seed ^ COPIES), &mut shot);
    models::add_gltf(&mut Dice::new(seed ^ GLTF), &mut shot);
    // at the end, so that all else stays what a seed has always given
    settings::add_caustics(dice, &mut shot);
    settings::add_clamp(dice, &mut shot);
    small::add(&mut Dice::new(seed ^ SMALL), &span, &mut shot);
    rays::add(&mut Dice::new(seed ^ RAYS), &mut shot);
    settings::add_error(&mut Dice::new(seed ^ ERROR), &mut shot);
    still_world::add(&mut Dice::new(seed ^ STILL_WORLD), &mut shot);
    graphs::add(&mut Dice::new(seed ^ GRAPHS), &mut shot);
    links::add(&mut Dice::new(seed ^ LINKS), &mut shot);
    subdivision::add(&mut Dice::new(seed ^ SUBDIVISION), &mut shot);
    media::add(&mut Dice::new(seed ^ MEDIA), &span, &mut shot);
    mirrors::add(&mut Dice::new(seed ^ MIRRORS), &mut shot);
    shot
}

/// A list of numbers.
fn numbers(values: impl IntoIterator<Item = f64>) -> Value {
    Value::Array(values.into_iter().map(Value::Float).collect())
}

/// A table of the keys that are given.
fn table<const N: usize>(keys: [(&str, Value); N]) -> Table {
    keys.into_iter().map(|(key, value)| (key.to_string(), value)).collect()
}

/// Three numbers, each in `-reach..reach`.
fn place(dice: &mut Dice, reach: f64) -> [f64; 3] {
    [0; 3].map(|_| dice.between(-reach, reach))
}

/// Three numbers from 0 to 1, some of them at the ends.
fn color(dice: &mut Dice) -> [f64; 3] {
    match dice.below(8) {
        0 => [1.0; 3],
        1 => [0.0; 3],
        2 => [1.0, 0.0, 0.0],
        _ => [0; 3].map(|_| dice.between(0.0, 1.0)),
    }
}

//! What surfaces are made of.

use toml::{Table, Value};

use super::{color, numbers, table};
use crate::dice::Dice;
use crate::files::{HOLES, MATERIALS, NORMALS, TEXTURES};

pub fn add(dice: &mut Dice, shot: &mut Table) {
    let materials = MATERIALS.iter().map(|name| Value::Table(material(dice, name)));
    shot.insert("material".into(), Value::Array(materials.collect()));
}

fn material(dice: &mut Dice, name: &str) -> Table {
    let mut material = table([("name", name.into()), ("kd", numbers(color(dice)))]);
    let mut set = |key: &str, value: Value| drop(material.insert(key.into(), value));
    match dice.below(10) {
        // a highlight
        0 => {
            set("ks", numbers(color(dice)));
            set("ns", Value::Float(*dice.pick(&[0.0, 5.0, 40.0, 1000.0])));
            set("illum", Value::Integer(2));
            if dice.one_in(3) {
                set("map_ks", (*dice.pick(&TEXTURES)).into());
            }
            if dice.one_in(3) {
                set("map_ns", HOLES.into());
            }
        }
        // a mirror
        1 => {
            set("ks", numbers(color(dice)));
            set("illum", Value::Integer(*dice.pick(&[3, 5])));
        }
        // glass
        2 => {
            set("ks", numbers([1.0; 3]));
            set("ni", Value::Float(*dice.pick(&[1.0, 1.33, 1.5])));
            set("illum", Value::Integer(*dice.pick(&[4, 6, 7, 9])));
            // what states `d` and roughness is a veil
            if dice.one_in(2) {
                set("pr", Value::Float(*dice.pick(&[0.03, 0.2, 0.5, 1.0])));
                set("tf", numbers(color(dice)));
                if dice.one_in(3) {
                    set("map_pr", HOLES.into());
                }
            } else {
                set("d", dice.between(0.0, 0.6).into());
            }
            // stained glass, and panes in walls
            for map in ["map_tf", "map_transmission"] {
                if dice.one_in(4) {
                    set(map, (*dice.pick(&[HOLES, TEXTURES[0]])).into());
                }
            }
            match dice.below(4) {
                0 => set("thin", Value::Boolean(true)),
                1 => {
                    set("depth", Value::Float(*dice.pick(&[0.05, 0.5, 3.0])));
                    set("depth_color", numbers(color(dice)));
                }
                _ => {}
            }
        }
        // thin
        3 => set("d", dice.between(0.1, 0.95).into()),
        // metal-rough
        4 | 5 => {
            set("pr", Value::Float(*dice.pick(&[0.0, 0.03, 0.2, 0.5, 1.0])));
            set("pm", Value::Float(*dice.pick(&[0.0, 0.0, 0.5, 1.0])));
            if dice.one_in(4) {
                set("d", dice.between(0.2, 0.9).into());
            }
            if dice.one_in(4) {
                set("anisotropy", Value::Float(*dice.pick(&[0.4, 0.9])));
                set("anisotropy_turn", dice.between(0.0, 360.0).into());
                if dice.one_in(2) {
                    set("anisotropy_around", (*dice.pick(&["x", "y", "z"])).into());
                }
            }
            if dice.one_in(4) {
                set("metal_edge", Value::Float(*dice.pick(&[0.0, 0.5])));
            }
            for map in ["map_pr", "map_pm"] {
                if dice.one_in(3) {
                    set(map, (*dice.pick(&[HOLES, TEXTURES[0]])).into());
                }
            }
        }
        // it glows
        6 => {
            set("ke", numbers(color(dice).map(|part| (part * 400.0).round() / 100.0)));
            if dice.one_in(2) {
                set("kd", numbers([0.0; 3]));
            }
            if dice.one_in(3) {
                set("map_ke", TEXTURES[0].into());
            }
        }
        _ => {}
    }
    if dice.one_in(4) {
        material.insert("map_kd".into(), (*dice.pick(&TEXTURES)).into());
    }
    if dice.one_in(5) {
        material.insert("map_d".into(), HOLES.into());
        if dice.one_in(2) {
            material.insert("alpha_mode".into(), "blend".into());
        }
    }
    if dice.one_in(7) {
        material.insert("hair".into(), Value::Table(hair(dice)));
    }
    if dice.one_in(6) {
        material.insert("subsurface".into(), Value::Float(*dice.pick(&[0.3, 1.0])));
        let radius = *dice.pick(&[0.02, 0.2, 2.0]);
        material.insert("subsurface_radius".into(), numbers([radius, 0.5 * radius, 0.0]));
        if dice.one_in(2) {
            for (key, values) in [
                ("subsurface_ni", [1.0, 1.4, 3.0]),
                ("subsurface_pr", [0.0, 0.3, 1.0]),
                ("subsurface_matt", [0.0, 0.5, 1.0]),
            ] {
                material.insert(key.into(), Value::Float(*dice.pick(&values)));
            }
        }
    }
    if dice.one_in(8) {
        material.insert("translucency".into(), Value::Float(*dice.pick(&[0.4, 1.0])));
    }
    if dice.one_in(5) {
        let (key, picture) = *dice.pick(&[("norm", NORMALS), ("map_bump", HOLES)]);
        material.insert(key.into(), picture.into());
    }
    if dice.one_in(6) {
        material.insert("ka".into(), numbers(color(dice)));
    }
    if dice.one_in(7) {
        add_coat(dice, &mut material);
    }
    if dice.one_in(6) {
        material.insert("diffuse_roughness".into(), Value::Float(*dice.pick(&[0.3, 1.0])));
    }
    if dice.one_in(7) {
        add_fuzz(dice, &mut material);
    }
    material
}

/// Fuzz, which is seen on edge alone or all over.
fn add_fuzz(dice: &mut Dice, material: &mut Table) {
    material.insert("fuzz".into(), Value::Float(*dice.pick(&[0.5, 1.0])));
    material.insert("fuzz_roughness".into(), Value::Float(*dice.pick(&[0.1, 0.5, 1.0])));
    if dice.one_in(2) {
        material.insert("fuzz_color".into(), numbers(color(dice)));
    }
}

/// A clear coat, which is as smooth as a mirror or rougher than what is below.
fn add_coat(dice: &mut Dice, material: &mut Table) {
    material.insert("coat".into(), Value::Float(*dice.pick(&[0.4, 1.0])));
    material.insert("coat_roughness".into(), Value::Float(*dice.pick(&[0.0, 0.2, 0.7])));
    material.insert("coat_ni".into(), Value::Float(*dice.pick(&[1.5, 2.0])));
    if dice.one_in(2) {
        material.insert("coat_color".into(), numbers(color(dice)));
        material.insert("coat_darkening".into(), Value::Float(*dice.pick(&[0.5, 1.0])));
    }
}

fn hair(dice: &mut Dice) -> Table {
    let mut share = |values: &[f64]| Value::Float(*dice.pick(values));
    let mut hair = table([
        ("roughness", share(&[0.1, 0.3, 1.0])),
        ("radial_roughness", share(&[0.1, 0.3, 1.0])),
        ("coat", share(&[0.0, 0.8])),
        ("offset", share(&[0.0, 2.0, -10.0])),
    ]);
    if dice.one_in(2) {
        hair.insert("melanin".into(), Value::Float(*dice.pick(&[0.0, 0.4, 0.9])));
        hair.insert("melanin_redness".into(), dice.between(0.0, 1.0).into());
    }
    hair
}

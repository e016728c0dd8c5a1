//! Graphs of materials.

use toml::{Table, Value};

use crate::dice::Dice;
use crate::mtlx::{FILES, FIRST_OF_GLASS};

/// Perhaps materials of the shot take graphs of a file.
pub fn add(dice: &mut Dice, shot: &mut Table) {
    if !dice.one_in(3) {
        return;
    }
    let number = dice.below(FILES as usize) as u64;
    let mut of_graphs = Vec::new();
    let entries = shot.get_mut("material").and_then(Value::as_array_mut).into_iter().flatten();
    for material in entries.filter_map(Value::as_table_mut) {
        if dice.one_in(2) {
            // either would count in place of the graph
            material.remove("kd");
            material.remove("map_kd");
            // of the rest some is replaced by what the file says
            for key in ["pr", "pm", "ni", "illum", "ks"] {
                if dice.one_in(2) {
                    material.remove(key);
                }
            }
            of_graphs.push(material);
        }
    }
    let number = if dice.one_in(4) { FIRST_OF_GLASS + number } else { number };
    for material in of_graphs {
        if number >= FIRST_OF_GLASS {
            // the file says that it is glass, and how clear
            for key in ["tf", "d", "transmission", "illum"] {
                material.remove(key);
            }
        }
        material.insert("mtlx".into(), format!("{number}.mtlx").into());
    }
}

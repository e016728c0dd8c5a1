//! Graphs of materials.

use toml::{Table, Value};

use crate::dice::Dice;
use crate::mtlx::FILES;

/// Perhaps materials of the shot take graphs of a file.
pub fn add(dice: &mut Dice, shot: &mut Table) {
    if !dice.one_in(3) {
        return;
    }
    let file = format!("{}.mtlx", dice.below(FILES as usize));
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
            material.insert("mtlx".into(), file.clone().into());
        }
    }
}

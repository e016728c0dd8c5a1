//! Cages and displacement: meshes of the shot that are subdivided, deform or not, and heights that move what is diced.

use toml::{Table, Value};

use crate::dice::Dice;
use crate::files::TEXTURES;

/// Perhaps subdivides some meshes of the shot, and displaces some of its materials.
pub fn add(dice: &mut Dice, shot: &mut Table) {
    if !dice.one_in(4) {
        return;
    }
    let mut is_diced = false;
    let models = shot.get_mut("model").and_then(Value::as_array_mut).into_iter().flatten();
    for model in models.filter_map(Value::as_table_mut) {
        let is_whole = model.get("obj").is_some_and(Value::is_str)
            && ["group", "split"].iter().all(|key| !model.contains_key(*key));
        if is_whole && dice.one_in(2) {
            let rules = *dice.pick(&["catmull-clark", "catmull-clark", "bilinear", "loop"]);
            model.insert("subdivision".into(), rules.into());
            is_diced = true;
        }
    }
    let materials = shot.get_mut("material").and_then(Value::as_array_mut).into_iter().flatten();
    for material in materials.filter_map(Value::as_table_mut) {
        if dice.one_in(3) {
            material.insert("map_displacement".into(), (*dice.pick(&TEXTURES)).into());
            material.insert("displacement".into(), dice.between(-0.4, 0.4).into());
            is_diced = true;
        }
    }
    if is_diced && let Some(render) = shot.get_mut("render").and_then(Value::as_table_mut) {
        // pictures are small, and shots many
        render.insert("dicing".into(), dice.between(3.0, 12.0).into());
        render.insert("dicing_triangles".into(), Value::Integer(*dice.pick(&[100, 3000])));
    }
}

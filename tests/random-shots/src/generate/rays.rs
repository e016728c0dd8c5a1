//! What rays of each kind see: models that are hidden from some of them, holes in the picture, a background that is not shown,
//! clipping planes.

use toml::{Table, Value};

use crate::dice::Dice;

/// Kinds of rays from which models may be hidden.
pub const KINDS: [&str; 5] = ["camera", "diffuse", "glossy", "transmission", "shadow"];

/// Perhaps hides some models of the shot from some rays.
pub fn add(dice: &mut Dice, shot: &mut Table) {
    if !dice.one_in(3) {
        return;
    }
    if let Some(models) = shot.get_mut("model").and_then(Value::as_array_mut) {
        for model in models.iter_mut().filter_map(Value::as_table_mut) {
            if dice.one_in(3) {
                let kinds: Vec<Value> =
                    KINDS.iter().filter(|_| dice.one_in(3)).map(|kind| Value::from(*kind)).collect();
                model.insert("hidden_from".into(), Value::Array(kinds));
            }
            if dice.one_in(6) {
                let role = *dice.pick(&["holdout", "shadow_catcher"]);
                model.insert(role.into(), Value::Boolean(true));
            }
        }
    }
    if dice.one_in(3) {
        let keys = shot.get_mut("camera").and_then(|camera| camera.get_mut("key")?.as_array_mut());
        // through the middle of what there is
        for key in keys.into_iter().flatten().filter_map(Value::as_table_mut) {
            let planes = [("near", dice.between(0.0, 4.0)), ("far", dice.between(4.5, 9.0))];
            for (plane, depth) in planes.into_iter().filter(|_| dice.one_in(2)) {
                key.insert(plane.into(), depth.into());
            }
        }
    }
    if dice.one_in(2) {
        let output = shot.entry("output").or_insert_with(|| Value::Table(Table::new()));
        if let Some(output) = output.as_table_mut() {
            output.insert("background".into(), "transparent".into());
        }
    }
}

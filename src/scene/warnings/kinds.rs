//! Warnings of one kind, of which a scene may have hundreds: one of them is told, and how many more there are.

use std::collections::HashMap;

use crate::scene::Warning;

/// Largest number of warnings of a kind that are all told.
const FEW: usize = 3;

/// Text of the warnings, in their order; of a kind with many the first alone, with the number of the others.
pub fn told(warnings: &[Warning]) -> Vec<String> {
    let mut counts: HashMap<String, usize> = HashMap::new();
    for warning in warnings {
        *counts.entry(kind(&warning.0.message)).or_default() += 1;
    }
    let mut all = Vec::new();
    for warning in warnings {
        let text = warning.0.to_string();
        match counts.get_mut(&kind(&warning.0.message)) {
            Some(0) => {}
            Some(count) if *count > FEW => {
                all.push(format!("{text} (and {} more like it, which `afterimage info` lists)", *count - 1));
                *count = 0;
            }
            _ => all.push(text),
        }
    }
    all
}

/// The message without the names and numbers that tell warnings of a kind apart.
fn kind(message: &str) -> String {
    let mut is_name = false;
    let mut kind = String::with_capacity(message.len());
    for character in message.chars() {
        is_name ^= character == '`';
        if !is_name && !character.is_ascii_digit() {
            kind.push(character);
        }
    }
    kind
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::SceneError;

    #[test]
    fn many_warnings_of_a_kind_are_told_once_with_their_number() {
        let missing =
            |i: usize| Warning(SceneError::new("m.mtl", format!("the texture `{i}.png` is lost")).at_line(i));
        let other = Warning(SceneError::new("s.toml", "`d` of the material `a` counts"));
        let few: Vec<Warning> = (1..=3).map(missing).chain([other.clone()]).collect();
        assert_eq!(told(&few), few.iter().map(|warning| warning.0.to_string()).collect::<Vec<_>>());
        let mut many: Vec<Warning> = (1..=19).map(missing).collect();
        many.insert(4, other);
        assert_eq!(
            told(&many),
            [
                "m.mtl:1: the texture `1.png` is lost (and 18 more like it, which `afterimage info` lists)",
                "s.toml: `d` of the material `a` counts",
            ]
        );
    }
}

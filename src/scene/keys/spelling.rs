//! Finds the known name that a misspelt one was meant to be.

/// Finds the names nearest to `wrong`, nearest first, at most three; none if all are far.
pub(crate) fn nearest<'a>(wrong: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    // long names would make the distance's table large, and are no typing slips
    const LONGEST: usize = 100;
    if wrong.len() > LONGEST {
        return Vec::new();
    }
    let allowed = (wrong.chars().count() / 3).max(1) + 1;
    let mut near: Vec<_> = known
        .into_iter()
        .filter(|name| name.len() <= LONGEST)
        .map(|name| (distance(&wrong.to_lowercase(), &name.to_lowercase()), name))
        .filter(|(steps, _)| *steps <= allowed)
        .collect();
    near.sort();
    near.dedup();
    near.into_iter().take(3).map(|(_, name)| name).collect()
}

/// Formats a hint, as `: did you mean a or b?`, or nothing.
pub(crate) fn hint<'a>(wrong: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let near: Vec<_> = nearest(wrong, known).into_iter().map(|name| format!("`{name}`")).collect();
    if near.is_empty() { String::new() } else { format!(": did you mean {}?", near.join(" or ")) }
}

/// Computes the Levenshtein distance: the number of characters to insert, remove or replace.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_steps() {
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("same", "same"), 0);
    }

    #[test]
    fn finds_what_was_meant() {
        let known = ["size", "samples", "frames"];
        assert_eq!(nearest("sise", known), ["size"]);
        assert_eq!(nearest("frame", known), ["frames"]);
        assert!(nearest("zebra", known).is_empty());
        assert_eq!(hint("Sampels", known), ": did you mean `samples`?");
    }
}

//! Statements of MTL files that have no effect here, but a visible one in other programs.

/// Statements without effect: the keyword in small letters, its usual spelling, and the picture's deviation.
const UNUSED: [(&str, &str, &str); 6] = [
    ("map_tr", "map_Tr", OPAQUE),
    ("disp", "disp", "the surface stays where its corners are"),
    ("map_ka", "map_Ka", "ambient light takes `Ka`, and the colours of `map_Kd`"),
    ("refl", "refl", REFLECTED),
    ("map_refl", "map_refl", REFLECTED),
    ("decal", "decal", "nothing is laid over `map_Kd`"),
];
const OPAQUE: &str = "what it cuts out is shown whole; `d` is a number all over a material";
const REFLECTED: &str = "mirrors show the scene and its environment alone";

/// Finds `keyword` (in small letters) among the statements without effect. Returns the entry's keyword, and a
/// message on the consequence.
pub fn message(keyword: &str) -> Option<(&'static str, String)> {
    let (key, usual, instead) = UNUSED.iter().find(|(key, ..)| *key == keyword)?;
    Some((key, format!("`{usual}` is not used: {instead}")))
}

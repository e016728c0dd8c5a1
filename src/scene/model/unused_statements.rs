//! Statements of MTL files that have no effect here, but a visible one in other programs.

/// Statements without effect: the keyword in small letters, its usual spelling, and the picture's deviation.
const UNUSED: [(&str, &str, &str); 15] = [
    ("map_pr", "map_Pr", "roughness is the number of `Pr` all over a material"),
    ("map_pm", "map_Pm", "metal is the number of `Pm` all over a material"),
    ("map_tr", "map_Tr", OPAQUE),
    ("map_bump", "map_Bump", SMOOTH),
    ("bump", "bump", SMOOTH),
    ("norm", "norm", SMOOTH),
    ("map_kn", "map_Kn", SMOOTH),
    ("disp", "disp", "the surface stays where its corners are"),
    ("map_ns", "map_Ns", "highlights are as wide as `Ns` says all over a material"),
    ("map_ks", "map_Ks", "highlights and reflections have the colour of `Ks` all over a material"),
    ("map_ka", "map_Ka", "ambient light takes `Ka`, and the colours of `map_Kd`"),
    ("map_ke", "map_Ke", "a material emits the colour of `Ke` all over"),
    ("refl", "refl", REFLECTED),
    ("map_refl", "map_refl", REFLECTED),
    ("decal", "decal", "nothing is laid over `map_Kd`"),
];
const OPAQUE: &str = "what it cuts out is shown whole; `d` is a number all over a material";
const SMOOTH: &str = "surfaces are as smooth as their normals";
const REFLECTED: &str = "mirrors show the scene and its environment alone";

/// Finds `keyword` (in small letters) among the statements without effect. Returns the entry's keyword, and a
/// message on the consequence.
pub fn message(keyword: &str) -> Option<(&'static str, String)> {
    let (key, usual, instead) = UNUSED.iter().find(|(key, ..)| *key == keyword)?;
    Some((key, format!("`{usual}` is not used: {instead}")))
}

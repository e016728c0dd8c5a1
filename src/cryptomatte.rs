//! Mattes by name, as in Cryptomatte 1.2 (Friedman and Jones, "Fully automatic ID mattes with support for
//! motion blur and transparency", SIGGRAPH 2015 posters): a hash turns a name into a number, pixels hold
//! numbers with the share that each covers, and the header lists the number of each name.

use std::collections::BTreeMap;

use crate::layers::Layers;
use crate::scene::Scene;

/// Largest number of pairs of id and coverage in a pixel: six, as compositing programs expect unless told
/// otherwise.
pub const RANKS: usize = 6;

/// Kind of things that mattes tell apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The models of the shot.
    Object,
    /// Materials of MTL files.
    Material,
    /// Objects and groups within OBJ files.
    Group,
}

impl Kind {
    /// All kinds, by number.
    pub const ALL: [Self; 3] = [Self::Object, Self::Material, Self::Group];

    /// Layer that shows this kind.
    pub fn layer(self) -> Layers {
        [Layers::CRYPTO_OBJECT, Layers::CRYPTO_MATERIAL, Layers::CRYPTO_GROUP][self as usize]
    }

    /// Name of the layer, without the digits that number its parts in files.
    pub fn layer_name(self) -> &'static str {
        ["CryptoObject", "CryptoMaterial", "CryptoGroup"][self as usize]
    }
}

/// Number that stands for a matte: the bits of a float that is neither zero, denormal, infinite nor NaN.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Id(pub u32);

impl Id {
    /// Number for no matte.
    pub const NONE: Self = Self(0);

    /// Number of a name.
    pub fn new(name: &str) -> Self {
        let hash = murmur3(name.as_bytes());
        // a float of this exponent is not a number that programs keep unchanged when they read it
        let is_usable = !matches!(hash >> 23 & 0xFF, 0 | 0xFF);
        Self(if is_usable { hash } else { hash ^ 1 << 23 })
    }

    /// Value in pixels.
    pub fn as_float(self) -> f32 {
        f32::from_bits(self.0)
    }
}

/// MurmurHash3 by Austin Appleby (public domain), the variant of 32 bits, with seed 0.
fn murmur3(bytes: &[u8]) -> u32 {
    let mix = |word: u32| word.wrapping_mul(0xCC9E_2D51).rotate_left(15).wrapping_mul(0x1B87_3593);
    let words = bytes.chunks_exact(4);
    let rest = words.remainder();
    let word = |bytes: &[u8]| bytes.iter().rev().fold(0, |word, byte| word << 8 | u32::from(*byte));
    let hash = words.fold(0_u32, |hash, four| {
        (hash ^ mix(word(four))).rotate_left(13).wrapping_mul(5).wrapping_add(0xE654_6B64)
    });
    let mut hash = hash ^ mix(word(rest)) ^ bytes.len() as u32;
    for (shift, factor) in [(16, 0x85EB_CA6B), (13, 0xC2B2_AE35)] {
        hash = (hash ^ hash >> shift).wrapping_mul(factor);
    }
    hash ^ hash >> 16
}

/// Name of the background's matte, where the picture shows it.
const BACKGROUND: &str = "background";

/// Mattes of a scene.
#[derive(Debug, Clone)]
pub struct Mattes {
    /// Matte of each model.
    pub objects: Vec<Id>,
    /// Matte of each material.
    pub materials: Vec<Id>,
    /// Mattes of each group of each model's mesh.
    pub groups: Vec<Vec<Id>>,
    /// Matte of the background; [`Id::NONE`] where the picture does not show it.
    pub background: Id,
    /// Manifests, by kind.
    manifests: [String; 3],
}

impl Mattes {
    /// Names the mattes of `scene`. Materials that have a name in common are one matte, those of two files as
    /// well. Models of one name are numbered. Groups are told apart by their models, and a model without any
    /// is one.
    pub fn new(scene: &Scene, shows_background: bool) -> Self {
        let background = shows_background.then_some(BACKGROUND);
        let mut names: [BTreeMap<String, Id>; 3] = Default::default();
        let mut add = |kind: Kind, name: String| -> Id {
            let id = Id::new(&name);
            names[kind as usize].insert(name, id);
            id
        };
        let models = names_of_models(scene);
        let objects = models.iter().map(|name| add(Kind::Object, name.clone())).collect();
        let materials =
            scene.materials.iter().map(|material| add(Kind::Material, material.name.clone())).collect();
        let groups = scene.models.iter().zip(&models).map(|(model, name)| {
            let groups = &*model.mesh.groups;
            let used = groups.used();
            if used.iter().eq([&0]) {
                return vec![add(Kind::Group, name.clone())];
            }
            let mut ids = vec![Id::NONE; groups.names().len()];
            used.into_iter().for_each(|group| {
                ids[group] = add(Kind::Group, format!("{name}/{}", groups.names()[group]));
            });
            ids
        });
        let groups = groups.collect();
        background.iter().for_each(|name| {
            Kind::ALL.into_iter().for_each(|kind| _ = add(kind, String::from(*name)));
        });
        let manifests = names.map(|names| manifest(&names));
        Self { objects, materials, groups, background: background.map_or(Id::NONE, Id::new), manifests }
    }

    /// Header attributes for a file with these layers: names and texts.
    pub fn attributes(&self, layers: Layers) -> Vec<(String, String)> {
        let kinds = Kind::ALL.into_iter().filter(|kind| layers.has(kind.layer()));
        let of_kind = |kind: Kind| {
            let name = kind.layer_name();
            // readers tell the mattes of a file apart by the first seven digits
            let key = &hex(Id::new(name))[..7];
            let attributes = [
                ("name", name),
                ("hash", "MurmurHash3_32"),
                ("conversion", "uint32_to_float32"),
                ("manifest", &self.manifests[kind as usize]),
            ];
            attributes.map(|(last, text)| (format!("cryptomatte/{key}/{last}"), String::from(text)))
        };
        kinds.flat_map(of_kind).collect()
    }
}

/// Names of all models; where several share a name, the later ones get numbers from 2 on.
fn names_of_models(scene: &Scene) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for model in &scene.models {
        let numbered = (2..).map(|number| format!("{} {number}", model.name));
        let mut possible = std::iter::once(model.name.clone()).chain(numbered);
        names.extend(possible.find(|name| !names.contains(name)));
    }
    names
}

fn hex(id: Id) -> String {
    format!("{:08x}", id.0)
}

/// Manifest as JSON: each name with the digits of its number.
fn manifest(names: &BTreeMap<String, Id>) -> String {
    let names = names.iter().map(|(name, id)| (name.clone(), hex(*id).into()));
    serde_json::Value::Object(names.collect()).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_the_specification() {
        // from its example of a manifest
        assert_eq!((hex(Id::new("bunny")), hex(Id::new("default"))), ("13851a76".into(), "42c9679f".into()));
        // rests of one to three bytes, against the reference implementation
        let hashes = ["", "a", "ab", "abc", "abcd", "hello, world"].map(|text| murmur3(text.as_bytes()));
        assert_eq!(hashes, [0, 0x3C25_69B2, 0x9BBF_D75F, 0xB3DD_93FA, 0x43ED_676A, 0x149B_BB7F]);
    }

    #[test]
    fn every_number_is_a_float_that_stays_as_it_is() {
        for number in 0..20_000 {
            assert!(Id::new(&number.to_string()).as_float().is_normal(), "{number}");
        }
        assert_eq!(Id::new(""), Id(1 << 23));
    }

    #[test]
    fn manifests_are_json_whatever_names_hold() {
        let name = "a \"b\"\\ \u{e4}\n";
        let text = manifest(&BTreeMap::from([(String::from(name), Id::new(name))]));
        let back: BTreeMap<String, String> = serde_json::from_str(&text).expect("it is JSON");
        assert_eq!(back.get(name), Some(&hex(Id::new(name))));
        assert!(!text.contains('\n'));
    }
}

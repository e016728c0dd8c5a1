//! Makes the variants of materials whose parameters pictures give: see [`Variants`].

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Vec2, Vec3};
use half::f16;

use super::map_statement::{ByUse, Channel, MapUse};
use super::pictures::PictureUse;
use crate::scene::cutout::ALL_BUT_OPAQUE;
use crate::scene::material::LARGEST_COLOR;
use crate::scene::texture::{Placement, Texel, UvSet, linear_color, linear_share, srgb_share};
use crate::scene::variants::{TexelNumbers, Variants};
use crate::scene::{Material, Texture};
use crate::scrambled::scrambled;

/// Maximum number of variants of a material.
const MOST_VARIANTS: usize = 4096;

/// Numbers of levels between which values are rounded, finest first: of roughness, and of each other number. The first is taken
/// with which there are few enough variants. More than 64 widths of a lobe are not told apart, and each takes time to prepare.
/// Emission of pictures with more than 8 bits has more than 256 levels.
const LEVELS: [[u32; 2]; 7] = [[64, 1 << 16], [64, 1024], [64, 256], [64, 32], [32, 16], [16, 8], [8, 4]];

/// Picture that gives a parameter of a material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ParameterMap {
    /// Index of the texture.
    pub map: u32,
    /// Channel of the value, if it is one number.
    pub channel: Channel,
}

/// A material with the pictures of its parameters.
pub(in crate::scene) struct Settled {
    pub material: Material,
    pub maps: ByUse<ParameterMap>,
}

impl From<Material> for Settled {
    fn from(material: Material) -> Self {
        Self { material, maps: ByUse::default() }
    }
}

/// Numbers that make a variant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Numbers {
    /// Roughness, metal, exponent of the highlight, reflectance of highlights, and opacity: 255 leaves a parameter as it is.
    bytes: [u8; BYTES],
    /// Emission, sRGB-encoded: 65535 is the brightest.
    emission: [u16; 3],
}

const BYTES: usize = 7;
const ROUGHNESS: usize = 0;
const METAL: usize = 1;
const SHININESS: usize = 2;
const SPECULAR: usize = 3;
const OPACITY: usize = 6;

/// Numbers that leave all parameters as they are.
const WHITE: Numbers = Numbers { bytes: [u8::MAX; BYTES], emission: [u16::MAX; 3] };

/// Uses of pictures that give parameters of a material.
pub(crate) const PARAMETERS: [MapUse; 5] =
    [MapUse::Roughness, MapUse::Metal, MapUse::Shininess, MapUse::Emission, MapUse::Specular];

/// Uses of pictures that variants are made of. Opacity is one where it is blended, and not where it cuts out.
const VARYING: [MapUse; 6] = [
    MapUse::Roughness,
    MapUse::Metal,
    MapUse::Shininess,
    MapUse::Emission,
    MapUse::Specular,
    MapUse::Opacity,
];

/// Returns true if `material` has the parameter that pictures of this use give.
pub(crate) fn is_of_use(material: &Material, used: MapUse) -> bool {
    match used {
        MapUse::Roughness => material.metal_rough.is_some(),
        MapUse::Metal => material.metal_rough.is_some() && !material.is_rough_glass(),
        MapUse::Shininess | MapUse::Specular => material.specular != Vec3::ZERO,
        _ => true,
    }
}

/// Use of a picture that gives a parameter.
pub(crate) fn picture_use(used: MapUse) -> PictureUse {
    match used {
        MapUse::Specular => PictureUse::ColorParameter,
        MapUse::Emission => PictureUse::Light,
        _ => PictureUse::Parameter,
    }
}

/// Variants of a material.
pub(crate) struct Made {
    /// The materials, in the order of their numbers.
    pub materials: Vec<Material>,
    /// The material itself, with the means of the parameters over its pictures.
    pub mean: Material,
    /// See [`Variants`].
    pub numbers: TexelNumbers,
    pub added: Option<TexelNumbers>,
}

impl Made {
    /// The material with its variants, whose first one will have the index `first`.
    pub fn head(&self, first: u16) -> Material {
        let variants = Variants { first, numbers: self.numbers.clone(), added: self.added.clone() };
        Material { variants: Some(Arc::new(variants)), ..self.mean.clone() }
    }
}

/// Makes the variants of `material`, at most `most`; `maps` has at least one of the [`VARYING`] uses.
pub(crate) fn make(
    material: &Material,
    maps: &ByUse<ParameterMap>,
    textures: &[Texture],
    most: usize,
) -> Option<Made> {
    let sets = [UvSet::First, UvSet::Second];
    let mut groups = sets.into_iter().filter_map(|set| Group::new(maps, textures, set));
    let (own, other) = (groups.next()?, groups.next());
    let most = most.min(MOST_VARIANTS);
    let numbered = |levels: &[u32; 2]| {
        let own = numbered(&own.numbers, *levels, most)?;
        let Some(other) = &other else { return Some((own, None)) };
        let other = numbered(&other.numbers, *levels, most / own.kinds.len())?;
        Some((own, Some(other)))
    };
    let (of_own, of_other) = LEVELS.iter().find_map(numbered)?;
    // with pictures of the other set there is a variant for each pair
    let other_kinds = of_other.as_ref().map_or(vec![WHITE], |of_other| of_other.kinds.clone());
    let both = |other: &Numbers| of_own.kinds.iter().map(|own| product(own, other)).collect::<Vec<_>>();
    let kinds = other_kinds.iter().flat_map(both);
    let emitting = Material { emission: material.emission * brightest(maps, textures), ..material.clone() };
    let materials: Vec<Material> = kinds.map(|kind| variant(&emitting, maps, kind)).collect();
    let own_shares = of_own.shares();
    let other_shares = of_other.as_ref().map_or(vec![1.0], Numbered::shares);
    let shares: Vec<f64> =
        other_shares.iter().flat_map(|other| own_shares.iter().map(move |own| own * other)).collect();
    let mean = mean(material, &materials, &shares);
    let step = of_own.kinds.len() as u16;
    let added = other.zip(of_other).map(|(other, of_other)| {
        let of_texel = of_other.of_texel.iter().map(|number| number * step).collect();
        TexelNumbers { of_texel, placement: other.placement }
    });
    let numbers = TexelNumbers { of_texel: of_own.of_texel.into(), placement: own.placement };
    Some(Made { materials, mean, numbers, added })
}

/// Pictures of a material in one set of texture coordinates.
struct Group {
    /// Place of the texels of the finest of them.
    placement: Placement,
    /// Numbers of all of them together, by those texels.
    numbers: Vec<Numbers>,
}

impl Group {
    /// Collects the pictures in `set`. `None` if there are none.
    fn new(maps: &ByUse<ParameterMap>, textures: &[Texture], set: UvSet) -> Option<Self> {
        let texture = |map: ParameterMap| &textures[map.map as usize];
        let pictures = || {
            let stated = VARYING.into_iter().filter_map(|used| Some((used, maps[used]?)));
            stated.filter(|(_, map)| texture(*map).mapping.uvs == set)
        };
        let finest =
            pictures().map(|(_, map)| texture(map)).max_by_key(|texture| texture.texels().count())?;
        let placement = finest.placement();
        let brightest = brightest(maps, textures);
        let pictures: Vec<Picture> =
            pictures().map(|stated| Picture::new(stated, texture(stated.1), &placement, brightest)).collect();
        let numbers = (0..finest.texels().count()).map(|texel| numbers_of(&pictures, texel)).collect();
        Some(Self { placement, numbers })
    }
}

/// Brightest channel of the picture of emission, at least 1: the numbers of emission are shares of it.
fn brightest(maps: &ByUse<ParameterMap>, textures: &[Texture]) -> f32 {
    maps[MapUse::Emission].map_or(1.0, |ParameterMap { map, .. }| {
        let texels = textures[map as usize].texels();
        // bytes are not brighter
        if texels.are_bytes() {
            return 1.0;
        }
        texels.iter().map(|texel| texel.color().truncate().max_element()).fold(1.0, f32::max)
    })
}

/// Numbers of both, of which at most one says something of each parameter.
fn product(one: &Numbers, other: &Numbers) -> Numbers {
    Numbers {
        bytes: std::array::from_fn(|i| one.bytes[i].min(other.bytes[i])),
        emission: std::array::from_fn(|i| one.emission[i].min(other.emission[i])),
    }
}

/// A picture, looked up at the texels of another one.
struct Picture<'a> {
    used: MapUse,
    channel: Channel,
    texture: &'a Texture,
    /// Place of the texels for which it is asked.
    asked: Placement,
    /// True if its texels are those for which it is asked.
    is_same: bool,
    /// Number of emission for the bits of each half float, if texels are such.
    of_half: Vec<u16>,
}

impl<'a> Picture<'a> {
    /// `brightest`: channel that the numbers of light are shares of.
    fn new(
        (used, map): (MapUse, ParameterMap),
        texture: &'a Texture,
        asked: &Placement,
        brightest: f32,
    ) -> Self {
        let is_same = texture.placement() == *asked;
        let of_bits = |bits: u16| encoded(f16::from_bits(bits).to_f32() / brightest);
        let has_halves = picture_use(used) == PictureUse::Light && !texture.texels().are_bytes();
        let of_half = if has_halves { (0..=u16::MAX).map(of_bits).collect() } else { Vec::new() };
        Self { used, channel: map.channel, texture, asked: *asked, is_same, of_half }
    }

    /// Bytes of this picture at the centre of number `texel` of those asked for; colours sRGB-encoded.
    fn bytes(&self, texel: usize) -> [u8; 4] {
        let texel = self.texture.texels().get(self.own_texel(texel));
        if picture_use(self.used) == PictureUse::ColorParameter { texel.srgb() } else { texel.bytes() }
    }

    /// Numbers of emission there.
    fn emission(&self, texel: usize) -> [u16; 3] {
        match self.texture.texels().get(self.own_texel(texel)) {
            Texel::Bytes([r, g, b, _]) => [r, g, b].map(|byte| 257 * u16::from(byte)),
            Texel::Halves([r, g, b, _]) => [r, g, b].map(|value| self.of_half[usize::from(value.to_bits())]),
        }
    }

    /// Texel of this picture at the centre of number `texel` of those asked for.
    fn own_texel(&self, texel: usize) -> usize {
        if self.is_same {
            return texel;
        }
        let (x, y) = (texel as u32 % self.asked.width, texel as u32 / self.asked.width);
        let at = |i: u32, count: u32| (i as f32 + 0.5) / count as f32;
        let in_picture = Vec2::new(at(x, self.asked.width), 1.0 - at(y, self.asked.height));
        let uv = self.asked.mapping.uv_of(in_picture);
        self.texture.between(uv).chosen([0.5; 2])
    }
}

/// Number of a linear share of the brightest.
fn encoded(share: f32) -> u16 {
    // a cast of NaN is 0
    (srgb_share(f64::from(share.clamp(0.0, 1.0))) * f64::from(u16::MAX) + 0.5) as u16
}

fn numbers_of(pictures: &[Picture<'_>], texel: usize) -> Numbers {
    let mut numbers = WHITE;
    for picture in pictures {
        let value = || picture.channel.of(picture.bytes(texel));
        match picture.used {
            MapUse::Roughness => numbers.bytes[ROUGHNESS] = value(),
            MapUse::Metal => numbers.bytes[METAL] = value(),
            MapUse::Shininess => numbers.bytes[SHININESS] = value(),
            MapUse::Emission => numbers.emission = picture.emission(texel),
            MapUse::Specular => {
                numbers.bytes[SPECULAR..SPECULAR + 3].copy_from_slice(&picture.bytes(texel)[..3])
            }
            MapUse::Opacity => {
                let alpha = value();
                let is_opaque = f32::from(alpha) / 255.0 >= ALL_BUT_OPAQUE;
                numbers.bytes[OPACITY] = if is_opaque { u8::MAX } else { alpha };
            }
            MapUse::Color | MapUse::Normal | MapUse::Bump => {}
        }
    }
    numbers
}

/// Distinct values of texels.
struct Numbered {
    /// Number of the value by texel.
    of_texel: Vec<u16>,
    /// The values.
    kinds: Vec<Numbers>,
}

impl Numbered {
    /// Share of the texels that each value has.
    fn shares(&self) -> Vec<f64> {
        let mut counts = vec![0_u32; self.kinds.len()];
        self.of_texel.iter().for_each(|number| counts[usize::from(*number)] += 1);
        counts.into_iter().map(|count| f64::from(count) / self.of_texel.len() as f64).collect()
    }
}

/// Numbers the distinct values of all texels, rounded to so many levels. `None` if there are more than `most`.
fn numbered(numbers: &[Numbers], levels: [u32; 2], most: usize) -> Option<Numbered> {
    let mut known: HashMap<Numbers, u16> = HashMap::new();
    let (mut of_texel, mut kinds) = (Vec::with_capacity(numbers.len()), Vec::new());
    let mut last: Option<(Numbers, u16)> = None;
    for (texel, numbers) in numbers.iter().enumerate() {
        let kind = rounded(numbers, levels, texel as u32);
        let number = match last.filter(|(last, _)| *last == kind) {
            Some((_, number)) => number,
            None => *known.entry(kind).or_insert_with(|| {
                kinds.push(kind);
                (kinds.len() - 1) as u16
            }),
        };
        if kinds.len() > most {
            return None;
        }
        of_texel.push(number);
        last = Some((kind, number));
    }
    Some(Numbered { of_texel, kinds })
}

/// Rounds to one of the two nearest levels, by chance, so that the mean over many texels stays; the least and the greatest stay as
/// they are.
fn rounded(numbers: &Numbers, [of_roughness, of_others]: [u32; 2], texel: u32) -> Numbers {
    const DRAWS: u32 = 10;
    let drawn = |draw: usize| scrambled(texel * DRAWS + draw as u32) % 255;
    // emission draws in between
    let of_byte = |i: usize| {
        let steps = if i == ROUGHNESS { of_roughness } else { of_others } - 1;
        let level = (u32::from(numbers.bytes[i]) * steps + drawn(if i < SPECULAR { i } else { i + 3 })) / 255;
        ((level * 255 + steps / 2) / steps) as u8
    };
    let of_light = |i: usize| {
        let steps = u64::from(of_others - 1);
        let chance = 257 * u64::from(drawn(SPECULAR + i));
        let level = (u64::from(numbers.emission[i]) * steps + chance) / 65535;
        ((level * 65535 + steps / 2) / steps) as u16
    };
    Numbers { bytes: std::array::from_fn(of_byte), emission: std::array::from_fn(of_light) }
}

/// The material with the parameters that these numbers stand for.
fn variant(material: &Material, maps: &ByUse<ParameterMap>, numbers: Numbers) -> Material {
    let share = |number: usize| f32::from(numbers.bytes[number]) / 255.0;
    let mut variant = material.clone();
    if let Some(layer) = &mut variant.metal_rough {
        layer.roughness *= share(ROUGHNESS);
        let metallic = layer.metallic * share(METAL);
        if maps.has(MapUse::Metal) {
            variant = variant.with_metal(metallic);
        }
    }
    if maps.has(MapUse::Emission) {
        let share = numbers.emission.map(|number| linear_share(f64::from(number) / 65535.0));
        variant.emission = (variant.emission * Vec3::from(share)).min(Vec3::splat(LARGEST_COLOR));
    }
    if maps.has(MapUse::Specular) {
        let [.., r, g, b, _] = numbers.bytes;
        variant.specular *= linear_color([r, g, b, 0]);
    }
    variant.shininess = (variant.shininess * share(SHININESS)).max(1.0);
    if maps.has(MapUse::Opacity) { variant.blended(share(OPACITY)) } else { variant }
}

/// The mean of the variants of `material`, each of which covers so large a share of the surface; as opaque as it is by itself.
fn mean(material: &Material, variants: &[Material], shares: &[f64]) -> Material {
    let number = |of: &dyn Fn(&Material) -> f32| {
        let sum = variants.iter().zip(shares).map(|(variant, share)| share * f64::from(of(variant)));
        sum.sum::<f64>() as f32
    };
    let color = |of: fn(&Material) -> Vec3| Vec3::from([0, 1, 2].map(|axis| number(&|one| of(one)[axis])));
    let mut mean = Material {
        emission: color(|one| one.emission),
        specular: color(|one| one.specular),
        shininess: number(&|one| one.shininess),
        ..material.clone()
    };
    if let Some(layer) = &mut mean.metal_rough {
        layer.roughness = number(&|one| one.metal_rough.map_or(0.0, |layer| layer.roughness));
        let metallic = number(&|one| one.metal_rough.map_or(0.0, |layer| layer.metallic));
        if metallic != layer.metallic {
            mean = mean.with_metal(metallic);
        }
    }
    mean
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use std::path::PathBuf;

    use super::*;
    use crate::scene::material::MetalRough;
    use crate::scene::texture::{Image, Mapping, Texels, Values};

    fn texture(width: u32, texels: Vec<[u8; 4]>) -> Texture {
        let height = texels.len() as u32 / width;
        Texture::of_bytes(PathBuf::new(), [width, height], texels.into(), Mapping::default())
    }

    fn metal_rough() -> Material {
        let base = Vec3::splat(0.8);
        let layer = MetalRough { base, roughness: 1.0, metallic: 1.0, head_on: 0.04, solid: 1.0 };
        Material { diffuse: Vec3::ZERO, metal_rough: Some(layer), ..Material::fallback() }
    }

    fn maps(list: &[(MapUse, Channel)]) -> ByUse<ParameterMap> {
        let mut maps = ByUse::default();
        list.iter().zip(0..).for_each(|((used, channel), map)| {
            maps[*used] = Some(ParameterMap { map, channel: *channel });
        });
        maps
    }

    #[test]
    fn variants_are_what_texels_say() {
        let roughness = texture(2, vec![[0, 255, 0, 255], [0, 0, 0, 255]]);
        let metal = texture(1, vec![[255, 0, 0, 255]]);
        let maps = maps(&[(MapUse::Roughness, Channel::Green), (MapUse::Metal, Channel::Blue)]);
        let made = make(&metal_rough(), &maps, &[roughness, metal], 10).unwrap();
        let layers = made.materials.iter().map(|one| (one.metal_rough.unwrap(), one.diffuse));
        let layers: Vec<_> =
            layers.map(|(layer, diffuse)| (layer.roughness, layer.metallic, diffuse)).collect();
        assert_eq!(layers, [(1.0, 0.0, Vec3::splat(0.8)), (0.0, 0.0, Vec3::splat(0.8))]);
        assert_eq!((&made.numbers.of_texel[..], made.added.is_none()), (&[0, 1][..], true));
        assert_eq!(made.mean.metal_rough.unwrap().roughness, 0.5);
        assert_eq!(made.head(3).variants.unwrap().first, 3);
    }

    /// Roughness in one set and emission in the other: a variant for each pair of both.
    #[test]
    fn pictures_in_two_sets_make_a_variant_for_each_pair() {
        let roughness = texture(2, vec![[0, 255, 0, 255], [0, 0, 0, 255]]);
        let mut glow = texture(3, vec![[255, 0, 0, 255], [0, 255, 0, 255], [255, 0, 0, 255]]);
        glow.mapping.uvs = UvSet::Second;
        let maps = maps(&[(MapUse::Roughness, Channel::Green), (MapUse::Emission, Channel::Mean)]);
        let glowing = Material { emission: Vec3::splat(2.0), ..metal_rough() };
        let textures = [roughness, glow];
        let made = make(&glowing, &maps, &textures, 4).unwrap();
        let shown: Vec<(f32, Vec3)> =
            made.materials.iter().map(|one| (one.metal_rough.unwrap().roughness, one.emission)).collect();
        let [red, green] = [Vec3::X, Vec3::Y].map(|color| color * 2.0);
        assert_eq!(shown, [(1.0, red), (0.0, red), (1.0, green), (0.0, green)]);
        let added = made.added.clone().unwrap();
        assert_eq!((&made.numbers.of_texel[..], &added.of_texel[..]), (&[0, 1][..], &[0, 2, 0][..]));
        assert_eq!(made.mean.metal_rough.unwrap().roughness, 0.5);
        assert!((made.mean.emission - Vec3::new(4.0 / 3.0, 2.0 / 3.0, 0.0)).abs().max_element() < 1e-6);
        assert!(make(&glowing, &maps, &textures, 3).is_none(), "no room for four");
    }

    #[test]
    fn many_colours_become_few_with_the_same_mean() {
        let texel = |i: u32| [scrambled(i) as u8, scrambled(i + 1) as u8, scrambled(i + 2) as u8, 255];
        let texels: Vec<[u8; 4]> = (0..128 * 128).map(|i| texel(3 * i)).collect();
        let exact = texels.iter().map(|texel| linear_color(*texel)).sum::<Vec3>() / texels.len() as f32;
        let glowing = Material { emission: Vec3::splat(2.0), ..Material::fallback() };
        let maps = maps(&[(MapUse::Emission, Channel::Mean)]);
        let made = make(&glowing, &maps, &[texture(128, texels)], usize::MAX).unwrap();
        assert!(made.materials.len() <= MOST_VARIANTS, "{}", made.materials.len());
        let difference = (made.mean.emission / 2.0 - exact).abs().max_element();
        assert!(difference < 0.02, "{difference} of {exact}");
    }

    /// A dark picture of halves beside one bright texel: bytes would know two values of it.
    #[test]
    fn emission_of_deep_pictures_is_not_rounded_to_bytes() {
        let lights: Vec<f32> = (0..256).map(|i| if i == 0 { 100.0 } else { 0.01 * i as f32 }).collect();
        let texels = lights.iter().map(|light| [*light, *light, *light, 1.0].map(f16::from_f32));
        let image = Image::new(16, 16, Texels::Halves(texels.collect()), Values::Colors);
        let picture = Texture { path: PathBuf::new(), image: image.into(), mapping: Mapping::default() };
        let glowing = Material { emission: Vec3::ONE, ..Material::fallback() };
        let maps = maps(&[(MapUse::Emission, Channel::Mean)]);
        let made = make(&glowing, &maps, &[picture], usize::MAX).unwrap();
        for (light, number) in lights.iter().zip(&made.numbers.of_texel[..]) {
            let shown = made.materials[usize::from(*number)].emission.x;
            assert!((shown - light).abs() <= 0.01 * light, "{shown} and not {light}");
        }
    }

    #[test]
    fn there_are_no_more_than_are_allowed() {
        let texels = (0..=255).map(|i| [i, i, i, 255]).collect();
        let (maps, picture) = (maps(&[(MapUse::Roughness, Channel::Mean)]), texture(16, texels));
        let with = |most| make(&metal_rough(), &maps, std::slice::from_ref(&picture), most);
        assert_eq!(with(1000).unwrap().materials.len(), 64);
        assert!(with(20).unwrap().materials.len() <= 20);
        assert!(with(3).is_none());
    }
}

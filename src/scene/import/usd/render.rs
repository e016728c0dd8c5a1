//! Settings of a picture (UsdRender): RenderSettings, the first of their products, and its variables.

use std::collections::BTreeSet;

use openusd::sdf::{Path, Value};
use openusd::usd::{Prim, Stage};

use super::choice::{Purpose, prim_path};
use super::value::{self, Answer, flag, numbers, said, targets, value, word, words};
use super::variants::{check_prim, listed};
use crate::layers::Layers;

/// Prim below which pictures are described, by convention of Pixar's library.
const HOME: &str = "/Render";

/// Most prims that are looked through for settings.
const MOST_PRIMS: usize = 10_000;

/// Most pixels along an edge of a picture that a file asks for.
const MOST_PIXELS: f64 = 32_768.0;

/// Types of prims.
const SETTINGS: &str = "RenderSettings";
const PASS: &str = "RenderPass";

/// Names of AOVs, as renderers and RenderVars of others call them, and layers that hold the same.
const OF_AOVS: [(&[&str], &str); 14] = [
    (&["z", "depth", "linearDepth"], "depth"),
    (&["P", "Pworld", "hitP", "worldPosition", "position"], "P"),
    (&["N", "Nn", "normal", "worldNormal", "hitN"], "N"),
    (&["albedo", "diffuse_albedo"], "albedo"),
    (&["primId", "objectId", "id"], "object"),
    (&["motion", "motionvector", "motionVector", "dPdtime", "velocity"], "motion"),
    (&["st", "uv", "primvars:st"], "uv"),
    (&["emission", "emissive"], "emission"),
    (&["directDiffuse"], "direct"),
    (&["indirectDiffuse"], "indirect"),
    (&["diffuse"], "diffuse"),
    (&["specular"], "specular"),
    (&["crypto_object", "CryptoObject"], "CryptoObject"),
    (&["crypto_material", "CryptoMaterial"], "CryptoMaterial"),
];

/// Names of the picture itself.
const BEAUTY: [&str; 10] = ["color", "rgba", "rgb", "C", "Ci", "RGBA", "RGB", "beauty", "a", "alpha"];

/// Shape of what is seen, if the picture's is another one than the camera's (`aspectRatioConformPolicy`).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Conform {
    /// The aperture grows in one direction.
    #[default]
    Expand,
    /// It shrinks in one direction.
    Crop,
    /// Its width changes.
    Width,
    /// Its height changes.
    Height,
}

impl Conform {
    /// Height of what is seen, as a multiple of the camera's: for a camera and a picture of these ratios of width to height.
    pub fn height(self, camera: f64, picture: f64) -> f64 {
        let kept_width = camera / picture;
        match self {
            Self::Expand => kept_width.max(1.0),
            Self::Crop => kept_width.min(1.0),
            Self::Width => 1.0,
            Self::Height => kept_width,
        }
    }
}

/// Picture of a file.
#[derive(Debug, Default)]
pub struct RenderSettings {
    /// Path of its prim.
    pub path: String,
    /// Path of the camera.
    pub camera: Option<String>,
    /// Width and height, pixels.
    pub size: Option<[u32; 2]>,
    pub conform: Conform,
    /// True without motion blur; true without depth of field.
    pub is_frozen: bool,
    pub is_sharp: bool,
    /// Purposes beside `default`.
    pub purposes: Option<BTreeSet<Purpose>>,
    /// Purposes of bindings of materials, in their order; of all purposes: empty.
    pub bindings: Option<Vec<String>>,
    /// Name of the picture's file.
    pub output: Option<String>,
    /// Layers of the picture, if there are any variables.
    pub layers: Option<Layers>,
    /// Parts that have no effect, in whole sentences.
    pub unused: BTreeSet<String>,
}

/// Settings that somebody names, that the file names (`renderSettingsPrimPath`), or the first ones below `/Render`.
///
/// # Errors Settings that are named and are not there.
pub fn find(stage: &Stage, chosen: Option<&str>) -> Answer<Option<Prim>> {
    if let Some(name) = chosen {
        let path = Path::new(name).map_err(|error| format!("the render settings `{name}`: {error}"))?;
        let all = || all(stage).map(|all| all.iter().map(|prim| prim.path().to_string()).collect::<Vec<_>>());
        let there = match &all()?[..] {
            [] => format!("there are none below {HOME}"),
            some => format!("below {HOME} there are {}", listed(some)),
        };
        check_prim(stage, &path, "the render settings").map_err(|why| format!("{why}; {there}"))?;
        return match kind(&stage.prim(path.clone()))?.as_str() {
            SETTINGS | PASS => Ok(Some(stage.prim(path))),
            _ => Err(format!("{name} is neither a RenderSettings nor a RenderPass: {there}")),
        };
    }
    let named = named(stage)?.map(|name| of_file(stage, &name)).transpose()?.flatten();
    match named {
        Some(found) => Ok(Some(found)),
        None => Ok(all(stage)?.into_iter().next()),
    }
}

/// Words for settings that the file names and that are not there.
///
/// # Errors What the library says.
pub fn missing(stage: &Stage) -> Answer<Option<String>> {
    let Some(name) = named(stage)? else { return Ok(None) };
    let is_there = of_file(stage, &name)?.is_some();
    Ok((!is_there).then(|| {
        format!("the render settings `{name}`, which renderSettingsPrimPath names, are not in the file: the first ones count, if there are any; --render-settings names others")
    }))
}

/// Path of the settings that the file names.
fn named(stage: &Stage) -> Answer<Option<String>> {
    Ok(match said(stage.stage_metadata("renderSettingsPrimPath"))? {
        Some(Value::String(path)) => Some(path),
        Some(Value::Token(path)) => Some(path.to_string()),
        _ => None,
    }
    .filter(|path| !path.is_empty()))
}

/// Settings at a path that the file names, if they are there.
fn of_file(stage: &Stage, name: &str) -> Answer<Option<Prim>> {
    let Some(path) = prim_path(name).ok().and_then(|path| Path::new(&path).ok()) else { return Ok(None) };
    let prim = stage.prim(path);
    Ok((kind(&prim)? == SETTINGS).then_some(prim))
}

/// All settings below `/Render`.
fn all(stage: &Stage) -> Answer<Vec<Prim>> {
    let home = Path::new(HOME).map_err(|error| error.to_string())?;
    let (mut waiting, mut found, mut seen) = (vec![stage.prim(home)], Vec::new(), 0);
    while let Some(prim) = waiting.pop() {
        seen += 1;
        if seen > MOST_PRIMS || !said(prim.is_valid())? || !said(prim.is_active())? {
            continue;
        }
        waiting.extend(said(prim.children())?.into_iter().rev());
        if kind(&prim)? == SETTINGS {
            found.push(prim);
        }
    }
    Ok(found)
}

fn kind(prim: &Prim) -> Answer<String> {
    Ok(said(prim.type_name())?.map_or(String::new(), |kind| kind.to_string()))
}

/// Reads settings, or those of a pass, as they are at a time code.
///
/// # Errors What the library says, and a pass without settings.
pub fn read(stage: &Stage, prim: &Prim, code: f64) -> Answer<RenderSettings> {
    let mut unused = BTreeSet::new();
    let prim = &of_pass(stage, prim, &mut unused)?;
    let path = prim.path().to_string();
    let mut products = Vec::new();
    for target in targets(prim, "products")? {
        let product = stage.prim(target.clone());
        if kind(&product)? == "RenderProduct" {
            products.push(product);
        } else {
            unused.insert(format!("the product {target}, which {path} names, is not there, and is not used"));
        }
    }
    if products.len() > 1 {
        let names: Vec<String> = products[1..].iter().map(|product| product.path().to_string()).collect();
        unused.insert(format!(
            "products of {path} behind the first one are not used: {}; --render-settings takes settings of another one",
            listed(&names)
        ));
    }
    let product = products.first();
    let read = Base { prim, product, code };
    let camera = match product.map(|product| targets(product, "camera")).transpose()?.unwrap_or_default() {
        own if own.is_empty() => targets(prim, "camera")?,
        own => own,
    };
    let mut settings = RenderSettings {
        path,
        camera: camera.into_iter().next().map(|path| path.to_string()),
        size: read.size()?,
        conform: read.conform(&mut unused)?,
        is_frozen: read.flag("disableMotionBlur")? || read.flag("instantaneousShutter")?,
        is_sharp: read.flag("disableDepthOfField")?,
        purposes: purposes(prim, code, &mut unused)?,
        bindings: value(prim, "materialBindingPurposes", code)?.as_ref().and_then(words),
        ..RenderSettings::default()
    };
    read.tell(&mut unused, settings.size)?;
    if let Some(product) = product {
        let kind = word(product, "productType", code)?.unwrap_or_else(|| String::from("raster"));
        if kind != "raster" {
            unused.insert(format!(
                "the type `{kind}` of {} is not used: pictures are EXR files",
                product.path()
            ));
        }
        settings.output = word(product, "productName", code)?.filter(|name| !name.trim().is_empty());
        settings.layers = layers(stage, product, code, &mut unused)?;
    }
    settings.unused = unused;
    Ok(settings)
}

/// Settings of a pass (its `renderSource`); other prims are settings themselves.
fn of_pass(stage: &Stage, prim: &Prim, unused: &mut BTreeSet<String>) -> Answer<Prim> {
    if kind(prim)? != PASS {
        return Ok(prim.clone());
    }
    let path = prim.path();
    let source = targets(prim, "renderSource")?.into_iter().next();
    let found = source.map(|source| stage.prim(source));
    let found = match found {
        Some(found) if kind(&found)? == SETTINGS => found,
        _ => {
            return Err(format!(
                "the RenderPass {path} names no RenderSettings (renderSource): name settings by --render-settings"
            ));
        }
    };
    let names = said(prim.property_names())?;
    let collections = ["renderVisibility", "cameraVisibility", "prune", "matte"];
    let is_of = |name: &str| collections.iter().any(|own| name.starts_with(&format!("collection:{own}:")));
    if names.iter().any(|name| is_of(name.as_str())) {
        unused.insert(format!("collections of the RenderPass {path} are not used: all of the file is shown"));
    }
    Ok(found)
}

/// Settings, and the product that overrides some of them.
struct Base<'a> {
    prim: &'a Prim,
    product: Option<&'a Prim>,
    code: f64,
}

impl Base<'_> {
    /// Value of the product, or else of the settings.
    fn value(&self, name: &str) -> Answer<Option<Value>> {
        if let Some(product) = self.product
            && let Some(own) = value(product, name, self.code)?
        {
            return Ok(Some(own));
        }
        value(self.prim, name, self.code)
    }

    fn flag(&self, name: &str) -> Answer<bool> {
        let own = self.product.map(|product| flag(product, name, self.code)).transpose()?.flatten();
        Ok(own.or(flag(self.prim, name, self.code)?).unwrap_or(false))
    }

    fn size(&self) -> Answer<Option<[u32; 2]>> {
        let size = self.value("resolution")?.as_ref().and_then(numbers);
        let size = size.and_then(|size| <[f64; 2]>::try_from(size).ok());
        let is_size = |size: &[f64; 2]| size.iter().all(|edge| (1.0..=MOST_PIXELS).contains(edge));
        Ok(size.filter(is_size).map(|size| size.map(|edge| edge as u32)))
    }

    fn conform(&self, unused: &mut BTreeSet<String>) -> Answer<Conform> {
        let policy = match self.value("aspectRatioConformPolicy")? {
            Some(Value::Token(policy)) => policy.to_string(),
            Some(Value::String(policy)) => policy,
            _ => return Ok(Conform::Expand),
        };
        Ok(match policy.as_str() {
            "expandAperture" => Conform::Expand,
            "cropAperture" => Conform::Crop,
            "adjustApertureWidth" => Conform::Width,
            "adjustApertureHeight" => Conform::Height,
            other => {
                unused.insert(format!(
                    "aspectRatioConformPolicy `{other}` is not used: apertures of cameras grow to the picture's shape"
                ));
                Conform::Expand
            }
        })
    }

    /// Tells what has no effect.
    fn tell(&self, unused: &mut BTreeSet<String>, size: Option<[u32; 2]>) -> Answer<()> {
        let path = self.prim.path();
        if let Some(ratio) = self.value("pixelAspectRatio")?.as_ref().and_then(numbers)
            && ratio.first().is_some_and(|ratio| (ratio - 1.0).abs() > 1e-6)
        {
            unused.insert(format!("pixelAspectRatio of {path} is not used: pixels are squares"));
        }
        let window = self.value("dataWindowNDC")?.as_ref().and_then(numbers);
        if let Some(window) = window.filter(|window| window.len() == 4 && window[..] != [0.0, 0.0, 1.0, 1.0])
        {
            let typed = size.and_then(|size| crop(&window, size));
            let typed = typed.map_or(String::new(), |typed| format!("; {typed}"));
            unused
                .insert(format!("dataWindowNDC of {path} is not used: the whole picture is rendered{typed}"));
        }
        if let Some(space) = word(self.prim, "renderingColorSpace", self.code)?
            && !matches!(space.as_str(), "" | "lin_rec709_scene" | "lin_rec709" | "lin_srgb")
        {
            unused.insert(format!(
                "renderingColorSpace `{space}` of {path} is not used: light is linear Rec. 709"
            ));
        }
        let names = said(self.prim.property_names())?;
        let mut foreign: BTreeSet<String> = BTreeSet::new();
        for name in &names {
            if let Some((own, _)) = name.as_str().split_once(':').filter(|(own, _)| *own != "collection") {
                foreign.insert(String::from(own));
            }
        }
        if !foreign.is_empty() {
            let foreign: Vec<String> = foreign.into_iter().collect();
            unused
                .insert(format!("settings of other renderers in {path} are not used ({})", listed(&foreign)));
        }
        Ok(())
    }
}

/// Option that renders a window of a picture: pixels whose centres are in it. `None` where it goes beyond the picture.
fn crop(window: &[f64], [width, height]: [u32; 2]) -> Option<String> {
    // of no negative zero, which is written with its sign
    let edge = |place: f64, size: u32| (place * f64::from(size) - 0.5).ceil() + 0.0;
    let (left, right) = (edge(window[0], width), edge(window[2], width));
    // there Y goes up
    let (top, bottom) = (edge(1.0 - window[3], height), edge(1.0 - window[1], height));
    let is_within = left >= 0.0
        && top >= 0.0
        && right <= f64::from(width)
        && bottom <= f64::from(height)
        && left < right
        && top < bottom;
    is_within.then(|| format!("--crop {}x{}+{left}+{top} renders that window", right - left, bottom - top))
}

fn purposes(prim: &Prim, code: f64, unused: &mut BTreeSet<String>) -> Answer<Option<BTreeSet<Purpose>>> {
    let Some(names) = value(prim, "includedPurposes", code)?.as_ref().and_then(words) else {
        return Ok(None);
    };
    let mut purposes = BTreeSet::new();
    for name in names.iter().filter(|name| *name != "default") {
        match Purpose::named(name) {
            Some(purpose) => {
                purposes.insert(purpose);
            }
            None => {
                unused.insert(format!("the purpose `{name}` of {} is not used", prim.path()));
            }
        }
    }
    Ok(Some(purposes))
}

/// Layers for the variables of a product. `None` if it has none.
fn layers(stage: &Stage, product: &Prim, code: f64, unused: &mut BTreeSet<String>) -> Answer<Option<Layers>> {
    let vars = targets(product, "orderedVars")?;
    if vars.is_empty() {
        return Ok(None);
    }
    let (mut layers, mut others) = (Layers::NONE, Vec::new());
    for path in vars {
        let var = stage.prim(path.clone());
        if kind(&var)? != "RenderVar" {
            others.push(format!("{path}, which is not there"));
            continue;
        }
        let name = path.name().unwrap_or_default().to_string();
        let source =
            value::word(&var, "sourceName", code)?.filter(|source| !source.is_empty()).unwrap_or(name);
        let is_lpe = value::word(&var, "sourceType", code)?.as_deref() == Some("lpe");
        match layer(&source).filter(|_| !is_lpe) {
            Some(layer) => layers = layers.with(layer),
            None if is_lpe && is_beauty_lpe(&source) => {}
            None if !is_lpe && BEAUTY.contains(&source.as_str()) => {}
            None => others.push(format!("{path} ({source})")),
        }
    }
    if !others.is_empty() {
        unused.insert(format!(
            "variables of {} are not used, for which there is no layer: {}",
            product.path(),
            listed(&others)
        ));
    }
    Ok(Some(layers))
}

/// Layer that holds what a variable does.
fn layer(source: &str) -> Option<Layers> {
    let own = OF_AOVS.iter().find(|(names, _)| names.contains(&source)).map(|(_, layer)| *layer);
    Layers::named(own.unwrap_or(source))
}

/// True for the light path expression of all light.
fn is_beauty_lpe(expression: &str) -> bool {
    let plain: String = expression.chars().filter(|letter| !letter.is_whitespace()).collect();
    matches!(
        plain.trim_start_matches("color:").trim_start_matches("lpe:"),
        "C.*" | "C.*[<L.>O]" | "C.*<L.>" | "C.*L"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn apertures_conform_to_pictures() {
        // a camera twice as wide as high, and pictures of 1 and of 4
        for (conform, expected) in [
            (Conform::Expand, [2.0, 1.0]),
            (Conform::Crop, [1.0, 0.5]),
            (Conform::Width, [1.0, 1.0]),
            (Conform::Height, [2.0, 0.5]),
        ] {
            assert_eq!([1.0, 4.0].map(|picture| conform.height(2.0, picture)), expected, "{conform:?}");
        }
    }

    #[test]
    fn windows_are_crops() {
        let of = |window: [f64; 4]| crop(&window, [100, 50]);
        assert_eq!(of([0.5, 0.0, 1.0, 0.5]).as_deref(), Some("--crop 50x25+50+25 renders that window"));
        // one column of pixels has its centre in it, then none
        assert_eq!(of([0.104, 0.8, 0.106, 0.9]).as_deref(), Some("--crop 1x5+10+5 renders that window"));
        assert_eq!(of([0.101, 0.8, 0.104, 0.9]), None);
        assert_eq!(of([-0.1, 0.0, 1.0, 1.0]), None);
    }

    #[test]
    fn variables_are_layers_by_any_of_their_names() {
        for (source, name) in [("z", "depth"), ("Nn", "N"), ("Z", "Z"), ("CryptoObject", "CryptoObject")] {
            assert_eq!(layer(source), Layers::named(name), "{source}");
            assert!(layer(source).is_some());
        }
        assert_eq!(layer("ri:attribute"), None);
        assert!(OF_AOVS.iter().all(|(_, name)| Layers::named(name).is_some()));
        assert!(is_beauty_lpe("C.*[<L.>O]") && !is_beauty_lpe("C<RD>.*[<L.>O]"));
    }
}

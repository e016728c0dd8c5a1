//! From a [`Surface`] to the [`Material`] that the renderer has, and the graphs of what varies of it.

use std::sync::Arc;

use glam::Vec3;

use super::varying::{Graphs, Settled};
use crate::graph::{Function, Input, Places, Program};
use crate::lanes::Vec3x8;
use crate::media::phase::MOST_ANISOTROPY;
use crate::scene::Material;
use crate::scene::material::{
    Anisotropy, Bump, ByParameter, Coat, Computes, Displacement, Entry, Fuzz, LARGEST_COLOR, LEAST_ALPHA,
    MetalRough, Optics, Scattering, UnevenGlass, head_on, index_of,
};
use crate::scene::medium::Medium;
use crate::scene::surface::{ALL, Beyond, Displaced, Parameter, Surface, Value, Volume};
use crate::shade::optics::of_both_walls;

/// What is told of glass with two graphs of colours.
const GLASS_OF_GRAPHS: &str =
    "of two graphs of colours of glass that of what goes through counts: what is not glass is matt in it";

/// What is told of glass whose metalness is computed.
const GLASS_OF_METAL: &str = "what of glass is metal is shown matt";

/// What is told of glass with a coat.
const COAT_OF_GLASS: &str = "coats and fuzz of glass are not used: glass reflects by its index alone";

/// What is told of heights that depend on the angle at which they are seen.
const HEIGHTS_OF_EYE: &str =
    "heights that depend on the angle at which they are seen are what they are head-on";

/// Maximum exponent of a highlight: beyond it a highlight is smaller than any pixel.
const HIGHEST_SHININESS: f32 = 1e5;

/// Greatest index of refraction: beyond it nothing would come out.
const GREATEST_INDEX: f32 = 100.0;

/// Least index of refraction of a coat: one that has a colour need not bend light.
const LEAST_OF_COAT: f32 = 1.0001;

/// Least mean free path: light that goes less far below a surface comes out where it went in.
const LEAST_RADIUS: f32 = 1e-8;

/// Least share of light that is left after the depth at which glass has its colour: the logarithm of none is infinite.
const LEAST_LEFT: f32 = 1e-6;

impl Surface {
    /// Lowers the surface. Its pictures of alpha and of normals are left to the caller, who knows what they show.
    pub(in crate::scene) fn lowered(mut self) -> Settled {
        let through = through(&self);
        let base = base(&mut self);
        let glass = (through > 0.0).then(|| glass(&mut self, base));
        let emission = product(&mut self, [Parameter::EmissionColor, Parameter::EmissionLuminance]);
        let inputs = self.inputs(glass.as_ref(), base, emission);
        let (medium, medium_graph) = self.medium();
        let material = Material {
            medium,
            medium_graph,
            has_surface: self.has_surface,
            name: std::mem::take(&mut self.name),
            emission: emission.factor.clamp(Vec3::ZERO, Vec3::splat(LARGEST_COLOR)),
            diffuse_map: self.base_picture,
            has_vertex_colors: self.is_tinted,
            bump: bump(&self),
            displacement: displacement(&self),
            ..self.reflecting(through, base, glass.map(|glass| glass.uneven))
        };
        Settled { material, graphs: Graphs::new(self.graph, inputs) }
    }

    /// What fills its meshes: where graphs give it, factors of that, and the program of what they give.
    fn medium(&self) -> (Option<Medium>, Option<Arc<Program>>) {
        let Some(Volume { scatter, absorb, emit, anisotropy }) = self.volume else { return (None, None) };
        let anisotropy = anisotropy.clamp(-MOST_ANISOTROPY, MOST_ANISOTROPY);
        match [scatter, absorb, emit] {
            [Input::Constant(scatter), Input::Constant(absorb), Input::Constant(emit)] => {
                (Some(Medium { scatter, absorb, emit, anisotropy }.cleaned()), None)
            }
            all => {
                let factors = Medium { scatter: Vec3::ONE, absorb: Vec3::ONE, emit: Vec3::ONE, anisotropy };
                (Some(factors), Some(Arc::new(Program::of_all(&self.graph, &all))))
            }
        }
    }

    /// The material alone, without what varies of it.
    pub(in crate::scene) fn material(&self) -> Material {
        self.clone().lowered().material
    }

    /// Sentences about what it states that the renderer does not have.
    pub(in crate::scene) fn left_out(&self) -> Vec<String> {
        let folded = self.parameters_to_fold();
        let names = || folded.iter().map(|parameter| ALL[*parameter as usize].name).collect::<Vec<_>>();
        let said = || format!("a graph gives {}: its mean counts in its place", names().join(", "));
        let mut left_out: Vec<String> = (!folded.is_empty()).then(said).into_iter().collect();
        let varies = |parameter| self[parameter].node.is_some();
        let is_glass = through(self) > 0.0;
        for (is_so, said) in [
            (is_glass && varies_in_metal(self), GLASS_OF_METAL),
            (is_glass && (coat(self).is_some() || fuzz(self).is_some()), COAT_OF_GLASS),
            (
                is_glass && varies(Parameter::TransmissionColor) && varies(Parameter::BaseColor),
                GLASS_OF_GRAPHS,
            ),
            (bump(self).is_some_and(|bump| bump.height.is_of_eye()), HEIGHTS_OF_EYE),
        ] {
            left_out.extend(is_so.then(|| String::from(said)));
        }
        left_out
    }

    /// What gives its values from place to place.
    fn inputs(&self, glass: Option<&Glass>, base: Value, emission: Value) -> ByParameter<Input> {
        let phong = self.beyond.phong.filter(|_| !has_layer(self));
        let mut inputs = ByParameter::default();
        inputs[Computes::Emission] = emission.given();
        inputs[Computes::Opacity] = self[Parameter::GeometryOpacity].given();
        inputs[Computes::Highlight] = phong.and_then(|phong| phong.color.given());
        let of_highlight = phong.and_then(|phong| phong.exponent.given());
        inputs[Computes::Roughness] = of_highlight.or(self[Parameter::SpecularRoughness].given());
        [inputs[Computes::Color], inputs[Computes::Metalness]] = match glass {
            Some(glass) => [glass.color, glass.share],
            None => [base.given(), self[Parameter::BaseMetalness].given()],
        };
        inputs
    }

    /// What it does with light, apart from emission. `through`: share that it lets through as glass.
    fn reflecting(&self, through: f32, base: Value, uneven_glass: Option<UnevenGlass>) -> Material {
        let beyond = &self.beyond;
        let is_glass = through > 0.0;
        let base = base.factor.clamp(Vec3::ZERO, Vec3::splat(LARGEST_COLOR));
        let optics = self.optics(through);
        let has_layer = has_layer(self) && !is_glass && beyond.mirror.is_none();
        let fuzz = fuzz(self).filter(|_| !is_glass);
        let diffuse_roughness = share(self, Parameter::BaseDiffuseRoughness);
        let solid = if beyond.mirror.is_some() { 1.0 } else { solid(self) * (1.0 - through) };
        // what is matt of uneven glass is as much as its factor says
        let lit = if is_glass && self.has_share_of_glass() { 1.0 } else { solid };
        let plain = Material {
            diffuse: base * solid,
            ambient: beyond.ambient.unwrap_or(base) * lit,
            optics,
            scattering: self.scattering().filter(|_| optics == Optics::Opaque),
            uneven_glass: uneven_glass.filter(|glass| glass.is_tinted || self.has_share_of_glass()),
            absorption: if is_glass { self.absorption() } else { Vec3::ZERO },
            ..Material::fallback()
        };
        if let Some(hair) = beyond.hair {
            // it counts as metal, so that nothing of it is matt: its colour is kept with samples as that of metal is
            let layer = MetalRough { base, roughness: 1.0, metallic: 1.0, head_on: 0.0, solid: 1.0 };
            return Material {
                diffuse: Vec3::ZERO,
                metal_rough: Some(layer),
                hair: Some(hair),
                optics: Optics::Opaque,
                scattering: None,
                absorption: Vec3::ZERO,
                uneven_glass: None,
                ..plain
            };
        }
        if !has_layer && (is_glass || fuzz.is_none() && diffuse_roughness == 0.0) {
            let layer = self.layer_of_glass(optics);
            let phong = beyond.phong.filter(|_| layer.is_none());
            let exponent = phong.map_or(1.0, |phong| phong.exponent.factor.x);
            return Material {
                metal_rough: layer,
                specular: phong.map_or(Vec3::ZERO, |phong| phong.color.factor),
                shininess: exponent.clamp(1.0, HIGHEST_SHININESS),
                ..plain
            };
        }
        let metallic = if has_layer { metalness(self) } else { 0.0 };
        let layer = MetalRough {
            base,
            roughness: if has_layer { factor(self, Parameter::SpecularRoughness) } else { 1.0 },
            metallic,
            head_on: reflectance(self) as f32,
            solid,
        };
        Material {
            diffuse: base * (1.0 - metallic) * solid,
            metal_rough: Some(layer),
            coat: coat(self),
            fuzz,
            metal_edge: beyond.metal_edge.unwrap_or_else(|| metal_edge(self)).clamp(0.0, 1.0),
            diffuse_roughness,
            anisotropy: self.anisotropy(),
            ..plain
        }
    }

    /// Returns true if a graph says how much of it is glass.
    fn has_share_of_glass(&self) -> bool {
        self[Parameter::TransmissionWeight].node.is_some() || varies_in_metal(self)
    }

    /// Its effect on rays.
    fn optics(&self, through: f32) -> Optics {
        let Beyond { mirror, veil, glass_tint, total_reflection, .. } = self.beyond;
        if let Some(mirror) = mirror {
            return Optics::Mirror { tint: mirror.tint, fresnel: mirror.fresnel };
        }
        if through > 0.0 {
            // a colour that light takes on its way is none of the surface
            let is_of_depth = self.number(Parameter::TransmissionDepth) > 0.0;
            let own = if is_of_depth { Vec3::ONE } else { self[Parameter::TransmissionColor].factor };
            // files write 0 for "does not bend"
            let index = Some(self.number(Parameter::SpecularIor)).filter(|index| *index > 0.0);
            return Optics::Glass {
                transmission: (own * glass_tint.factor * through).clamp(Vec3::ZERO, Vec3::ONE),
                index: index.unwrap_or(1.0).min(GREATEST_INDEX),
                reflection: self.constant(Parameter::SpecularColor).max(Vec3::ZERO),
                total: total_reflection.unwrap_or(Vec3::splat(through)).clamp(Vec3::ZERO, Vec3::ONE),
                // a lobe that is too narrow to be seen is none
                is_rough: factor(self, Parameter::SpecularRoughness).powi(2) > LEAST_ALPHA,
                is_thin: is_thin(self),
            };
        }
        match solid(self) {
            1.0 => Optics::Opaque,
            solid => Optics::veil(veil * (1.0 - solid)),
        }
    }

    /// Layer by which rough glass reflects.
    fn layer_of_glass(&self, optics: Optics) -> Option<MetalRough> {
        let Optics::Glass { index, reflection, is_rough: true, is_thin, .. } = optics else { return None };
        let of_wall = head_on(index.into()) as f32;
        Some(MetalRough {
            base: Vec3::ZERO,
            roughness: factor(self, Parameter::SpecularRoughness),
            metallic: 0.0,
            head_on: if is_thin { of_both_walls(of_wall) } else { of_wall },
            // a pane that does not bend light reflects none
            solid: if index == 1.0 { 0.0 } else { reflection.max_element().min(1.0) },
        })
    }

    /// What becomes of diffuse light that does not leave where it came, if any does not. What scatters light below itself lets a half of
    /// it through where it is thin.
    fn scattering(&self) -> Option<Scattering> {
        let radius =
            self.constant(Parameter::SubsurfaceRadiusScale) * self.number(Parameter::SubsurfaceRadius);
        let below = share(self, Parameter::SubsurfaceWeight);
        let (below, of_thin) = if is_thin(self) { (0.0, 0.5 * below) } else { (below, 0.0) };
        let through = self.beyond.translucency.unwrap_or(of_thin).clamp(0.0, 1.0);
        let weight = below.min(1.0 - through);
        let goes = radius.cmpgt(Vec3::splat(LEAST_RADIUS));
        let below = Vec3::select(goes, Vec3::splat(weight), Vec3::ZERO);
        let radius = radius.max(Vec3::ZERO);
        let entry = self.entry();
        (below != Vec3::ZERO || through > 0.0).then_some(Scattering { below, radius, through, entry })
    }

    /// Directions in which light goes below it: what has a layer bends light on its way in.
    fn entry(&self) -> Entry {
        let Beyond { entry_index, entry_roughness, entry_matt, .. } = self.beyond;
        let of_layer = index_of(reflectance(self)) as f32;
        let index = entry_index.unwrap_or(of_layer).clamp(1.0, GREATEST_INDEX);
        let own = if of_layer > 1.0 { factor(self, Parameter::SpecularRoughness) } else { 1.0 };
        let roughness = entry_roughness.unwrap_or(own);
        let matt = entry_matt.unwrap_or(if index > 1.0 { 0.0 } else { 1.0 });
        Entry { matt, index, alpha: (roughness * roughness).max(LEAST_ALPHA) }
    }

    /// What glass absorbs for each unit of length: the exponents of Beer and Lambert's law. A pane has no depth.
    fn absorption(&self) -> Vec3 {
        let depth = self.number(Parameter::TransmissionDepth);
        if depth <= 0.0 || is_thin(self) {
            return Vec3::ZERO;
        }
        let left = self.constant(Parameter::TransmissionColor);
        -left.clamp(Vec3::splat(LEAST_LEFT), Vec3::ONE).ln() / depth
    }

    fn anisotropy(&self) -> Option<Anisotropy> {
        let amount = share(self, Parameter::SpecularRoughnessAnisotropy);
        let Beyond { tangent_turn, tangent_around, .. } = self.beyond;
        let anisotropy = Anisotropy { amount, turn: tangent_turn.to_radians(), around: tangent_around };
        (amount > 0.0).then_some(anisotropy)
    }
}

/// What of glass graphs give.
struct Glass {
    /// Share that is glass, of its greatest one.
    share: Option<Input>,
    /// Colour of what goes through, or else of what is matt of it.
    color: Option<Input>,
    uneven: UnevenGlass,
}

/// What of glass varies from place to place.
fn glass(surface: &mut Surface, base: Value) -> Glass {
    let is_of_depth = surface.number(Parameter::TransmissionDepth) > 0.0;
    let of_color = surface[Parameter::TransmissionColor].given().filter(|_| !is_of_depth);
    let color = surface.beyond.glass_tint.given().or(of_color);
    let weight = surface[Parameter::TransmissionWeight].given();
    let metal = surface[Parameter::BaseMetalness];
    let share = match varies_in_metal(surface) {
        false => weight,
        true => {
            let inputs = vec![weight.unwrap_or(Input::Constant(Vec3::ONE)), whole(surface, metal)];
            Some(surface.graph.add(Arc::new(Without), inputs))
        }
    };
    let is_pictured = surface.beyond.is_glass_pictured && surface.base_picture.is_some();
    let through = through(surface);
    let uneven = UnevenGlass {
        base: base.factor.clamp(Vec3::ZERO, Vec3::splat(LARGEST_COLOR)),
        share: through,
        mean: 1.0,
        is_tinted: color.is_some() || is_pictured,
    };
    // nothing of it is matt, if it is clear all over
    let is_clear = through == 1.0 && share.is_none();
    Glass { share, color: color.or(base.given().filter(|_| !is_clear)), uneven }
}

/// Returns true if a graph says where it is metal.
fn varies_in_metal(surface: &Surface) -> bool {
    let metal = surface[Parameter::BaseMetalness];
    metal.node.is_some() && metal.factor != Vec3::ZERO
}

/// Share of the light that it lets through as glass.
fn through(surface: &Surface) -> f32 {
    if solid(surface) < 1.0 || surface.beyond.mirror.is_some() {
        return 0.0;
    }
    let metallic = if varies_in_metal(surface) { 0.0 } else { metalness(surface) };
    factor(surface, Parameter::TransmissionWeight) * (1.0 - metallic)
}

/// Share of it that is there: a factor, where a graph gives it.
fn solid(surface: &Surface) -> f32 {
    factor(surface, Parameter::GeometryOpacity)
}

/// Share of metal: a factor, where a graph gives it.
fn metalness(surface: &Surface) -> f32 {
    factor(surface, Parameter::BaseMetalness)
}

/// Returns true if it reflects by a layer, or a coat.
fn has_layer(surface: &Surface) -> bool {
    reflectance(surface) > 0.0 || metalness(surface) > 0.0 || coat(surface).is_some()
}

/// Reflectance at normal incidence of what of it is no metal.
fn reflectance(surface: &Surface) -> f64 {
    let tint = surface.constant(Parameter::SpecularColor).max(Vec3::ZERO);
    // a white tint changes no digit
    let mean = if tint == Vec3::ONE { 1.0 } else { f64::from(tint.element_sum()) / 3.0 };
    let index = f64::from(surface.number(Parameter::SpecularIor)).max(1.0);
    let weight = f64::from(share(surface, Parameter::SpecularWeight));
    (head_on(index) * weight * mean).min(head_on(GREATEST_INDEX.into()))
}

/// How white metal is at grazing angles, where its specular colour tints what it reflects at 82 degrees (the specification's F82): so that it
/// is as bright there.
fn metal_edge(surface: &Surface) -> f32 {
    let mean =
        |parameter| f64::from(surface.constant(parameter).clamp(Vec3::ZERO, Vec3::ONE).element_sum()) / 3.0;
    let [head_on, tint] = [Parameter::BaseColor, Parameter::SpecularColor].map(mean);
    if tint == 1.0 || head_on > MOST_OF_METAL {
        return 1.0;
    }
    // Schlick's formula at a cosine of 1/7
    let white = (6.0_f64 / 7.0).powi(5);
    let tinted = tint * (head_on + (1.0 - head_on) * white);
    ((tinted - head_on) / ((1.0 - head_on) * white)).clamp(0.0, 1.0) as f32
}

/// Reflectance at right angles above which a metal is as white as it gets.
const MOST_OF_METAL: f64 = 0.999;

/// The clear coat, if there is one that does anything.
fn coat(surface: &Surface) -> Option<Coat> {
    let coat = Coat {
        weight: share(surface, Parameter::CoatWeight),
        roughness: share(surface, Parameter::CoatRoughness),
        index: surface.number(Parameter::CoatIor),
        tint: surface.constant(Parameter::CoatColor).clamp(Vec3::ZERO, Vec3::ONE),
        darkening: share(surface, Parameter::CoatDarkening),
    };
    let is_seen = coat.index > 1.0 || coat.tint != Vec3::ONE;
    (coat.weight > 0.0 && is_seen)
        .then_some(Coat { index: coat.index.clamp(LEAST_OF_COAT, GREATEST_INDEX), ..coat })
}

/// The fuzz, if there is any that reflects.
fn fuzz(surface: &Surface) -> Option<Fuzz> {
    let fuzz = Fuzz {
        weight: share(surface, Parameter::FuzzWeight),
        color: surface.constant(Parameter::FuzzColor).clamp(Vec3::ZERO, Vec3::ONE),
        roughness: share(surface, Parameter::FuzzRoughness),
    };
    (fuzz.weight > 0.0 && fuzz.color != Vec3::ZERO).then_some(fuzz)
}

fn is_thin(surface: &Surface) -> bool {
    surface.number(Parameter::GeometryThinWalled) > 0.5
}

/// A number from 0 to 1; its default if a graph gives it.
fn share(surface: &Surface, parameter: Parameter) -> f32 {
    surface.number(parameter).clamp(0.0, 1.0)
}

/// A number from 0 to 1, of which a graph may give a share.
fn factor(surface: &Surface, parameter: Parameter) -> f32 {
    surface[parameter].factor.x.clamp(0.0, 1.0)
}

/// Heights that bend normals: even ones bend nothing.
fn bump(surface: &Surface) -> Option<Bump> {
    let heights = surface.heights?;
    let Input::Node(_) = heights.height else { return None };
    let height = Arc::new(Program::new(&surface.graph, heights.height));
    Some(Bump { height, distance: heights.distance, strength: heights.strength.clamp(0.0, 1.0) })
}

/// What moves vertices, unless it is none.
fn displacement(surface: &Surface) -> Option<Displacement> {
    let Displaced { by, scale, middle, along } = surface.displaced?;
    let is_none = scale == 0.0 || matches!(by, Input::Constant(value) if value == Vec3::splat(middle));
    let program = || Arc::new(Program::new(&surface.graph, by));
    (!is_none).then(|| Displacement { program: program(), scale, middle, along })
}

/// The base colour, with its weight.
fn base(surface: &mut Surface) -> Value {
    let base = product(surface, [Parameter::BaseColor, Parameter::BaseWeight]);
    let (below, color) = (share(surface, Parameter::SubsurfaceWeight), surface[Parameter::SubsurfaceColor]);
    if below == 0.0 || color == base {
        return base;
    }
    // what goes below the surface has a colour of its own, and the renderer one of both
    let inputs = [base, color].map(|value| whole(surface, value));
    Value::from(surface.graph.add(Arc::new(Mixed { share: below }), inputs.to_vec()))
}

/// Product of a colour and its weight.
fn product(surface: &mut Surface, [color, weight]: [Parameter; 2]) -> Value {
    match (surface[color], surface[weight]) {
        (color, Value::ONE) => color,
        (_, Value::ZERO) => Value::ZERO,
        (color, weight) => {
            let inputs = [color, weight].map(|value| whole(surface, value));
            Value::from(surface.graph.add(Arc::new(Product), inputs.to_vec()))
        }
    }
}

/// A value with its factor, as an input of other nodes.
fn whole(surface: &mut Surface, Value { factor, node }: Value) -> Input {
    match node {
        None => Input::Constant(factor),
        Some(node) if factor == Vec3::ONE => Input::Node(node),
        Some(node) => surface.graph.add(Arc::new(Product), vec![Input::Node(node), Input::Constant(factor)]),
    }
}

/// Two values, mixed.
#[derive(Debug)]
struct Mixed {
    /// Share of the second.
    share: f32,
}

impl Function for Mixed {
    fn values(&self, inputs: &[Vec3x8], _: Places) -> Vec3x8 {
        inputs[0] * (1.0 - self.share) + inputs[1] * self.share
    }
}

/// A share of a value that is left without another.
#[derive(Debug)]
struct Without;

impl Function for Without {
    fn values(&self, inputs: &[Vec3x8], _: Places) -> Vec3x8 {
        inputs[0] * (Vec3x8::splat(Vec3::ONE) - inputs[1])
    }
}

/// Product of two values.
#[derive(Debug)]
struct Product;

impl Function for Product {
    fn values(&self, inputs: &[Vec3x8], _: Places) -> Vec3x8 {
        inputs[0] * inputs[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::nodes::picture::Shown;

    fn coated(change: impl FnOnce(&mut Surface)) -> Option<Coat> {
        let mut surface = Surface::matt("m", Vec3::ONE);
        surface[Parameter::CoatWeight] = 0.5.into();
        change(&mut surface);
        surface.material().coat
    }

    #[test]
    fn a_coat_is_there_where_it_does_something() {
        let coat = coated(|_| {}).expect("it has a weight");
        assert_eq!((coat.weight, coat.index, coat.tint, coat.darkening), (0.5, 1.5, Vec3::ONE, 0.0));
        assert!(coated(|surface| surface[Parameter::CoatWeight] = Value::ZERO).is_none());
        assert!(coated(|surface| surface[Parameter::CoatIor] = Value::ONE).is_none(), "it is not seen");
        let tinted = coated(|surface| {
            surface[Parameter::CoatIor] = Value::ONE;
            surface[Parameter::CoatColor] = Vec3::X.into();
        });
        assert!(tinted.is_some());
    }

    #[test]
    fn fuzz_is_there_where_it_reflects() {
        let mut surface = Surface::matt("m", Vec3::ONE);
        assert_eq!(surface.material().fuzz, None);
        surface[Parameter::FuzzWeight] = 2.0.into();
        let expected = Fuzz { weight: 1.0, color: Vec3::ONE, roughness: 0.5 };
        assert_eq!(surface.material().fuzz, Some(expected));
        surface[Parameter::FuzzColor] = Value::ZERO;
        assert_eq!(surface.material().fuzz, None);
    }

    #[test]
    fn anisotropy_of_none_is_round() {
        let mut surface = Surface::matt("m", Vec3::ONE);
        surface.set_layer(1.5, 0.5, 1.0);
        assert_eq!(surface.material().anisotropy, None);
        surface[Parameter::SpecularRoughnessAnisotropy] = 0.5.into();
        surface.beyond.tangent_turn = 180.0;
        let found = surface.material().anisotropy.expect("there is some");
        assert!(found.amount == 0.5 && (found.turn - std::f32::consts::PI).abs() < 1e-6);
    }

    #[test]
    fn glass_has_its_colour_at_its_depth() {
        let mut surface = Surface::new("m", crate::graph::Graph::default());
        assert_eq!(surface.material().absorption, Vec3::ZERO);
        surface[Parameter::TransmissionWeight] = Value::ONE;
        surface[Parameter::TransmissionDepth] = 0.5.into();
        surface[Parameter::TransmissionColor] = Vec3::new(1.0, 0.5, 0.0).into();
        let left = (-surface.material().absorption * 0.5).exp();
        assert!((left - Vec3::new(1.0, 0.5, 1e-6)).abs().max_element() < 1e-6, "{left}");
        surface[Parameter::GeometryThinWalled] = Value::ONE;
        assert_eq!(surface.material().absorption, Vec3::ZERO, "a pane has no depth");
    }

    /// Icing whose red light goes nowhere below it is as red as matt icing.
    #[test]
    fn light_that_goes_nowhere_stays_at_the_surface() {
        let scattering = |radius: Vec3, translucency| {
            let mut surface = Surface::matt("m", Vec3::ONE);
            surface[Parameter::SubsurfaceWeight] = 0.75.into();
            surface[Parameter::SubsurfaceRadiusScale] = radius.into();
            surface.beyond.translucency = translucency;
            surface.material().scattering
        };
        let icing = scattering(Vec3::new(0.0, 0.1, 0.1), None).expect("some goes below");
        assert_eq!(
            (icing.below, icing.at_surface()),
            (Vec3::new(0.0, 0.75, 0.75), Vec3::new(1.0, 0.25, 0.25))
        );
        assert_eq!(scattering(Vec3::ZERO, None), None);
        let leaf = scattering(Vec3::ONE, Some(0.5)).expect("some goes through");
        assert_eq!((leaf.below, leaf.at_surface()), (Vec3::splat(0.5), Vec3::ZERO), "there is no more light");
    }

    /// A factor of a picture is one of the light, whether the colour has a weight or not.
    #[test]
    fn factors_stay_beside_their_pictures() {
        let mut surface = Surface::matt("m", Vec3::splat(0.5));
        surface.show(Parameter::BaseColor, 0, Shown::Color);
        surface[Parameter::SubsurfaceColor] = surface[Parameter::BaseColor];
        surface[Parameter::SubsurfaceWeight] = 0.5.into();
        let Settled { material, graphs } = surface.clone().lowered();
        assert!(material.diffuse == Vec3::splat(0.5) && graphs.has(Computes::Color));
        surface[Parameter::BaseWeight] = 0.5.into();
        let weighted = surface.lowered().material;
        assert_eq!(weighted.diffuse, Vec3::ONE, "its graph has all of it");
    }
}

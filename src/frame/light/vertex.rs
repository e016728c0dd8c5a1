//! A surface that a light path has met: where it asks for light, and how the path goes on.

use std::f32::consts::PI;

use glam::Vec3;

use super::light_choice::{Kinds, paths_go_on, sky_density};
use super::lobes::Lobes;
use super::next_event::AskingBsdf;
use super::path_ray::PathRay;
use super::pdfs::{LightsAsked, Pdfs};
use super::step::Step;
use crate::frame::grid::bits::set_bits;
use crate::frame::shot::frame_view::FrameView;
use crate::lanes::{F32x8, LANES, Vec3x8};
use crate::scene::RayKind;
use crate::scene::look::Look;
use crate::settings::Caustics;
use crate::shade::Surface;
use crate::shade::area::{AreaRadiance, density_of};
use crate::shade::bsdf::mis::mis_weight;
use crate::shade::bsdf::{SeenBsdf, SeenBy};
use crate::shade::sampling::{cosine_direction, orthonormal};
use crate::shade::surface::off_surface;
use crate::shade::terminator::Receivers;

/// A surface that a path has met.
#[derive(Debug, Clone, Copy)]
pub struct Vertex {
    pub ray: PathRay,
    pub surface: Surface,
    /// Model of the surface.
    pub model: u32,
    /// Light towards the path: its emission, and its reflection of the light that it has asked.
    pub light: Vec3,
    /// Weight of its emission, which next-event estimation finds, too.
    pub emission_weight: f32,
    /// Kinds of light sources that it asks.
    pub asks: Kinds,
    /// Number of the light that it asks, if it asks any.
    pub asked_light: u32,
    /// Probability with which it chose that one.
    pub chance: f32,
    /// Random numbers for that choice, and for the places that it asks.
    pub random: [f32; 4],
    /// Ways in which the path may go on.
    pub lobes: Lobes,
    /// Number of its layer, as the path sees it, among those of all vertices; [`NO_BSDF`] if it has none.
    pub bsdf: u32,
    /// True if the path came from below the surface: light of its own was seen where it went in.
    pub is_exit: bool,
}

/// Number of no layer.
pub const NO_BSDF: u32 = u32::MAX;

impl Vertex {
    /// Pdfs of the ways from this vertex to light.
    pub fn chances(&self, frame: &FrameView) -> Pdfs {
        let chance = |is_asked| if is_asked { 1.0 } else { 0.0 };
        let Kinds { lights, sky, emitters } = self.asks;
        Pdfs {
            asks_sky: chance(sky),
            sky: sky_density(frame, self.ray.step),
            asks_emitter: chance(emitters),
            lights: LightsAsked::One { chance: chance(lights) },
            goes_on: self.goes_on(frame, Lobes::DIFFUSE),
        }
    }

    /// Random numbers for a point on the light that it asks.
    pub fn on_light(&self) -> [f32; 2] {
        [self.random[1], self.random[2]]
    }

    /// Random numbers for a direction to the sky: others than for lights, so that both do not err alike.
    pub fn in_sky(&self) -> [f32; 2] {
        [self.random[3], self.random[0]]
    }

    /// Random numbers for a point on emitting surfaces.
    pub fn on_emitters(&self) -> [f32; 3] {
        [self.random[3], self.random[1], self.random[2]]
    }

    /// Returns true if one of its ways brings light even if the path ends here: off mirrors and through
    /// glass, where paths alone find that light; or else through clear glass, where rays have asked for a
    /// part of it.
    fn passes_light_on(&self, frame: &FrameView, lobe: usize) -> bool {
        let passes = || lobe == Lobes::THROUGH && frame.shines_through(self.surface.material);
        self.lobes.all[lobe].1.is_some() && (frame.settings.caustics == Caustics::Paths || passes())
    }

    /// Returns true if the path goes on by any of its ways.
    pub fn goes_on_at_all(&self, frame: &FrameView) -> bool {
        (0..self.lobes.all.len()).any(|lobe| self.is_followed(frame, lobe))
    }

    /// Returns true if the path goes on by this way, be it for no more than light for which the other ways
    /// have asked.
    fn is_followed(&self, frame: &FrameView, lobe: usize) -> bool {
        let through_veil = || {
            let is_through = lobe == Lobes::THROUGH && self.lobes.all[lobe].1.is_some();
            is_through && !self.next_step(frame, lobe).is_beyond()
        };
        self.leads_on(frame, lobe) || self.passes_light_on(frame, lobe) || through_veil()
    }

    /// Layer of the vertex as the path sees it, if it has one; `bsdfs` are those of all vertices.
    #[inline]
    pub fn seen_bsdf<'c>(&self, bsdfs: &'c [SeenBsdf]) -> Option<&'c SeenBsdf> {
        bsdfs.get(self.bsdf as usize)
    }

    /// Probability with which the path goes on by one of the ways.
    fn goes_on(&self, frame: &FrameView, lobe: usize) -> f32 {
        if self.leads_on(frame, lobe) { self.lobes.chance(lobe) } else { 0.0 }
    }

    /// Kind of ray as which the path goes on by a lobe, with a density or in one direction: as before off mirrors, narrow lobes and through
    /// glass.
    fn next_sees_as(&self, bsdf: Option<&SeenBsdf>, lobe: usize, has_density: bool) -> SeenBy {
        let is_narrow = match lobe {
            Lobes::DIFFUSE => false,
            Lobes::GLOSSY => !has_density || bsdf.is_some_and(SeenBsdf::is_narrow),
            _ => true,
        };
        if is_narrow { self.ray.seen_by } else { SeenBy::Path }
    }

    /// Kind of ray as which the path goes on by `way`, by what it comes from: as before through veils.
    fn next_kind(&self, frame: &FrameView, lobe: usize) -> RayKind {
        match lobe {
            Lobes::DIFFUSE => RayKind::Diffuse,
            Lobes::THROUGH if self.is_veil(frame) => self.ray.kind,
            Lobes::THROUGH => RayKind::Transmission,
            _ => RayKind::Glossy,
        }
    }

    /// Returns true if light goes straight through the surface.
    fn is_veil(&self, frame: &FrameView) -> bool {
        self.surface.optics(frame.scene).is_straight()
    }

    /// Highlight on its layer `bsdf` of a light that it has asked, which sends an irradiance from a
    /// direction. `radiance` is that of an area light, which the path itself may meet, too.
    pub fn highlight(
        &self,
        frame: &FrameView,
        bsdf: &SeenBsdf,
        (direction, irradiance): (Vec3, Vec3),
        radiance: Option<AreaRadiance>,
    ) -> Vec3 {
        let goes_on = self.goes_on(frame, Lobes::GLOSSY);
        // what is a mirror shows the light itself on the path
        let is_met = radiance.is_some() && goes_on > 0.0;
        let (highlight, density) = bsdf.highlight(direction, irradiance, is_met);
        let by_path = goes_on * density;
        let weight = match radiance {
            Some(radiance) if by_path > 0.0 && radiance.is_met => {
                mis_weight(density_of(radiance.along(direction), irradiance), by_path)
            }
            _ => 1.0,
        };
        highlight * weight
    }

    /// Layer of the vertex for next-event estimation, if it has one.
    pub fn asking_bsdf<'a>(&self, frame: &FrameView, bsdfs: &'a [SeenBsdf]) -> Option<AskingBsdf<'a>> {
        let seen = self.seen_bsdf(bsdfs).filter(|seen| frame.settings.depth > 0 && seen.is_rough())?;
        Some(AskingBsdf { seen, weight: self.ray.weight, goes_on: self.goes_on(frame, Lobes::GLOSSY) })
    }

    /// Pdfs of the ways from it to light in a direction in which its layer has reflected with this
    /// `density`. The ray takes that direction for its normal; the chances are scaled so that it is as likely
    /// as the layer chose it.
    fn chances_of_bsdf(&self, frame: &FrameView, density: f32) -> Pdfs {
        let goes_on = self.lobes.chance(Lobes::GLOSSY) * density * PI;
        Pdfs { goes_on, ..self.chances(frame) }
    }

    /// Place of the surface to which one of its ways leads.
    fn next_step(&self, frame: &FrameView, lobe: usize) -> Step {
        self.ray.step.next(lobe == Lobes::THROUGH && self.is_veil(frame))
    }

    /// Returns true if paths go on by this way. Where surfaces gather no light, none is scattered onwards.
    fn leads_on(&self, frame: &FrameView, lobe: usize) -> bool {
        paths_go_on(frame, self.ray.step) && (frame.paths > 0 || lobe != Lobes::DIFFUSE)
    }
}

/// Chooses one of the ways from a vertex, in proportion to the light that each carries, and makes the ray
/// that goes on. `bsdf` is the layer of the vertex, if it has one.
pub fn go_on(
    frame: &FrameView,
    (vertex, bsdf): (&Vertex, Option<&SeenBsdf>),
    [along, above, choice, _]: [f32; 4],
) -> Option<PathRay> {
    let Vertex { ray, surface, lobes, .. } = vertex;
    let chosen = lobes.choose(choice).filter(|lobe| vertex.is_followed(frame, *lobe))?;
    let (weight, direction) = lobes.all[chosen];
    let (mut asked_from, mut has_density) = (None, true);
    let (weight, direction, normal, chances) = match direction {
        Some(direction) if chosen == Lobes::THROUGH && frame.shines_through(surface.material) => {
            // rays of next-event estimation have passed here, too
            asked_from = Some(ray.asked_from);
            (weight, direction, ray.normal, ray.chances)
        }
        Some(direction) => (weight, direction, surface.normal, Pdfs::PATH_ALONE),
        None if chosen == Lobes::GLOSSY => {
            let reflected = bsdf?.reflect([along, above])?;
            if !surface.horizon.is_below(reflected.direction, surface.geometric_normal) {
                return None;
            }
            has_density = reflected.density.is_some();
            let chances = match reflected.density {
                Some(density) => vertex.chances_of_bsdf(frame, density),
                None => Pdfs::PATH_ALONE,
            };
            (reflected.weight, reflected.direction, reflected.direction, chances)
        }
        None => {
            let [tangent, bitangent] = orthonormal(surface.normal);
            let direction = cosine_direction([along, above], [tangent, bitangent, surface.normal]);
            if !surface.horizon.is_below(direction, surface.geometric_normal) {
                return None;
            }
            let weight = weight * surface.horizon.fading(surface.normal, direction);
            (weight, direction, surface.normal, vertex.chances(frame))
        }
    };
    let weight = ray.weight * weight / lobes.chance(chosen);
    let origin = match chosen {
        Lobes::DIFFUSE | Lobes::GLOSSY => {
            let origin = off_surface(surface.point, surface.geometric_normal);
            surface.horizon.origin(origin, direction, surface.geometric_normal)
        }
        _ => surface.leave(direction),
    };
    let receiver = if asked_from.is_some() { ray.receiver } else { vertex.model };
    let asked_from = asked_from.unwrap_or(origin);
    let (step, seen_by) = (vertex.next_step(frame, chosen), vertex.next_sees_as(bsdf, chosen, has_density));
    let kind = vertex.next_kind(frame, chosen);
    let within = match chosen {
        Lobes::THROUGH if frame.palette.absorbs => surface.within_behind(frame.scene, ray.within),
        _ => ray.within,
    };
    Some(PathRay {
        step,
        weight,
        origin,
        direction,
        asked_from,
        normal,
        chances,
        seen_by,
        kind,
        receiver,
        within,
        ..*ray
    })
}

/// Up to eight vertices side by side. Lanes without one repeat the first.
pub struct VertexLanes {
    pub point: Vec3x8,
    pub normal: Vec3x8,
    pub geometric_normal: Vec3x8,
    pub reflectance: Vec3x8,
    pub place: [F32x8; 2],
    /// Probabilities of the lights that they chose.
    pub chance: F32x8,
    pub looks: [Look; LANES],
    /// Bit mask of the lanes in use.
    pub used: u8,
    /// Bit mask of fibres: see [`Receivers::fibres`].
    pub fibres: u8,
}

impl VertexLanes {
    /// The surfaces as light sees them; `smooth` gives the normals of the curved surfaces of the lanes in use.
    pub fn receivers(&self, frame: &FrameView, smooth: impl Fn(usize) -> Vec3) -> Receivers {
        let Self { point, normal, geometric_normal, used, fibres, .. } = *self;
        let smooth = frame.palette.bends_normals.then(|| {
            let mut normals = normal;
            set_bits(used).for_each(|lane| normals.set_lane(lane, smooth(lane)));
            normals
        });
        Receivers { point, normal, smooth, geometric_normal, fibres }
    }

    pub fn of<'v>(count: usize, vertex: impl Fn(usize) -> &'v Vertex) -> Self {
        let mut eight = Self {
            point: Vec3x8::ZERO,
            normal: Vec3x8::ZERO,
            geometric_normal: Vec3x8::ZERO,
            reflectance: Vec3x8::ZERO,
            place: [F32x8::ZERO; 2],
            chance: F32x8::ONE,
            looks: [Look::plain(0); LANES],
            used: u8::MAX >> (LANES - count),
            fibres: 0,
        };
        for lane in 0..LANES {
            let vertex = vertex(if lane < count { lane } else { 0 });
            let (Vertex { surface, chance, .. }, place) = (vertex, vertex.on_light());
            eight.point.set_lane(lane, surface.point);
            eight.normal.set_lane(lane, surface.normal);
            eight.geometric_normal.set_lane(lane, surface.geometric_normal);
            eight.reflectance.set_lane(lane, surface.reflectance);
            eight.place[0].set_lane(lane, place[0]);
            eight.place[1].set_lane(lane, place[1]);
            eight.chance.set_lane(lane, *chance);
            eight.looks[lane] = surface.look();
            eight.fibres |= u8::from(surface.horizon.is_fibre) << lane;
        }
        eight
    }
}

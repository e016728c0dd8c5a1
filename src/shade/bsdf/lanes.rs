//! Layers of eight surfaces at a time, and how the eye sees them.

use std::f32::consts::PI;

use glam::Vec3;

use super::albedos::{LEAST_ALBEDO, LEAST_COSINE, Shares};
use super::fresnel::Fresnel;
use super::of_material::{Between, BsdfAt};
use super::rough_diffuse::{RoughLanes, SeenRough};
use super::seen::{SeenBsdf, SurfaceAxes};
use super::seen_by::SeenBy;
use super::seen_lanes::{HairLanes, LayerRays, More, SeenBsdfs};
use super::stretched::{StretchedLanes, Widths};
use super::upper::Upper;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8, are_same};
use crate::scene::look::Look;
use crate::scene::material::LEAST_ALPHA;

/// Layers of eight surfaces, side by side. A lane without one reflects nothing.
pub(super) struct BsdfLanes<'a> {
    alpha: F32x8,
    metallic: F32x8,
    metal: Vec3x8,
    metal_of_kept: Vec3x8,
    edge: F32x8,
    index: F32x8,
    solid: F32x8,
    emission: Vec3x8,
    albedos: [Option<Between<'a>>; LANES],
    has: Mask,
    /// Those that have more than a layer, if any has.
    more: Option<[Option<BsdfAt<'a>>; LANES]>,
}

impl<'a> BsdfLanes<'a> {
    const NONE: Self = Self {
        alpha: F32x8::ONE,
        metallic: F32x8::ZERO,
        metal: Vec3x8::ZERO,
        metal_of_kept: Vec3x8::ZERO,
        edge: F32x8::ONE,
        index: F32x8::ONE,
        solid: F32x8::ZERO,
        emission: Vec3x8::ZERO,
        albedos: [None; LANES],
        has: Mask::NONE,
        more: None,
    };

    /// Layers of eight surfaces; `bsdf` looks up that of each.
    #[inline]
    pub(super) fn new(bsdf: impl Fn(Look) -> Option<BsdfAt<'a>>, looks: &[Look; LANES]) -> Self {
        let mut lanes = Self::NONE;
        if are_same(looks) {
            if let Some(bsdf) = bsdf(looks[0]) {
                lanes.fill(&bsdf);
            }
            return lanes;
        }
        for (lane, look) in looks.iter().enumerate() {
            if let Some(bsdf) = bsdf(*look) {
                lanes.set(lane, &bsdf);
            }
        }
        lanes
    }

    /// Sets all lanes to the same layer.
    fn fill(&mut self, at: &BsdfAt<'a>) {
        let bsdf = at.bsdf;
        *self = Self {
            alpha: F32x8::splat(at.alpha),
            metallic: F32x8::splat(at.metallic),
            metal: Vec3x8::splat(bsdf.metal),
            metal_of_kept: Vec3x8::splat(bsdf.metal_of_kept),
            edge: F32x8::splat(bsdf.edge),
            index: F32x8::splat(bsdf.index),
            solid: F32x8::splat(at.solid),
            emission: Vec3x8::splat(at.emission),
            albedos: [Some(at.albedos); LANES],
            has: Mask::ALL,
            more: bsdf.has_more().then_some([Some(*at); LANES]),
        };
    }

    fn set(&mut self, lane: usize, at: &BsdfAt<'a>) {
        let bsdf = at.bsdf;
        self.alpha.set_lane(lane, at.alpha);
        self.metallic.set_lane(lane, at.metallic);
        self.metal.set_lane(lane, bsdf.metal);
        self.metal_of_kept.set_lane(lane, bsdf.metal_of_kept);
        self.edge.set_lane(lane, bsdf.edge);
        self.index.set_lane(lane, bsdf.index);
        self.solid.set_lane(lane, at.solid);
        self.emission.set_lane(lane, at.emission);
        self.albedos[lane] = Some(at.albedos);
        self.has.set(lane);
        if bsdf.has_more() {
            self.more.get_or_insert([None; LANES])[lane] = Some(*at);
        }
    }

    /// Layers as the eye sees them: [`BsdfAt::seen`] for eight surfaces.
    #[inline]
    pub(super) fn seen(&self, reflectance: Vec3x8, axes: SurfaceAxes<Vec3x8>, incoming: Vec3x8) -> SeenBsdfs {
        let SurfaceAxes { normal, geometric_normal, tangent } = axes;
        let Self { alpha, metallic, index, has, .. } = *self;
        let [normal, to_eye] = seen_from(normal, geometric_normal, incoming);
        let metal = (self.metal + self.metal_of_kept * reflectance).min(Vec3x8::splat(Vec3::ONE));
        let fresnel = Fresnel { metal: metal.into(), edge: self.edge, metallic, index };
        let cos = normal.dot(to_eye);
        let [gain, albedo, through] = self.reflected(&fresnel, cos);
        let mut seen = SeenBsdfs {
            normal,
            to_eye,
            alpha,
            fresnel,
            gain: has.select3(gain, Vec3x8::ZERO),
            through: has.select3(through, Vec3x8::splat(Vec3::ONE)),
            added: has.select3(self.emission * (F32x8::ONE - through.x), Vec3x8::ZERO),
            rays: F32x8::ZERO,
            drawn_for: [normal, to_eye],
            is_followed: Mask::NONE,
            more: None,
        };
        if self.more.is_some() {
            self.add_more(&mut seen, (cos, reflectance), tangent, [albedo, through]);
            if let Some(hair) = self.hair(reflectance, SurfaceAxes { tangent, ..axes }, incoming) {
                self.set_hair(&mut seen, hair);
            }
        }
        seen
    }

    /// Notes in what is `seen` of surfaces with these reflectances and directions the rays by which they reflect.
    pub(super) fn follow(
        &self,
        seen: &mut SeenBsdfs,
        reflectance: Vec3x8,
        axes: SurfaceAxes<Vec3x8>,
        rays: LayerRays,
    ) {
        let SurfaceAxes { normal, geometric_normal, tangent } = axes;
        seen.rays = F32x8::new(rays.count.map(|count| count as f32));
        seen.is_followed = Mask::from_bits(rays.followed);
        seen.drawn_for = seen_from(normal, geometric_normal, rays.incoming);
        if let Some(more) = &mut seen.more {
            if let Some(hair) = &mut more.hair {
                hair.drawn = self.hair(reflectance, axes, rays.incoming).unwrap_or(hair.drawn);
            }
            let [normal, to_eye] = seen.drawn_for;
            if let (Some([_, drawn]), Some(stretched)) =
                (&mut more.stretched, self.stretched(normal, tangent))
            {
                *drawn = stretched;
            }
            let cos = normal.dot(to_eye);
            let [_, albedo, through] = self.reflected(&seen.fresnel, cos);
            for lane in 0..LANES {
                let drawn = self.upper(lane, (cos, reflectance), [albedo, through]);
                let Some(drawn) = drawn else { continue };
                let is_rough = seen.alpha.lane(lane) > LEAST_ALPHA;
                let of_layer = if is_rough { albedo.lane(lane) * drawn.lets_through } else { Vec3::ZERO };
                more.set_drawn(lane, &drawn, drawn.rough().chances_above(of_layer));
            }
        }
    }

    /// Factor for the light that microfacets of the layers reflect once, share of the light from all around that they reflect, and share of
    /// scattered light that they let through.
    #[inline(always)]
    fn reflected(&self, fresnel: &Fresnel<F32x8>, cos: F32x8) -> [Vec3x8; 3] {
        let solid = self.solid;
        let shares = self.shares_at(cos);
        let [once, albedo] = [shares.once(fresnel), shares.in_all(fresnel)].map(Vec3x8::from);
        let gain = |albedo: F32x8, once: F32x8| {
            // a surface that reflects nothing needs no factor
            once.gt(F32x8::splat(LEAST_ALBEDO)).select(albedo / once, F32x8::ONE) * solid * F32x8::splat(PI)
        };
        let gain = Vec3x8 { x: gain(albedo.x, once.x), y: gain(albedo.y, once.y), z: gain(albedo.z, once.z) };
        let through = (F32x8::ONE - shares.clear).max(F32x8::ZERO).min(F32x8::ONE);
        [gain, albedo * solid, Vec3x8::all_of(through)]
    }

    /// What is above the layer in a lane, as it is seen at these cosines: `below` are the albedo and what is let through of layers with nothing
    /// above them. `None` if nothing is.
    fn upper(&self, lane: usize, (cos, reflectance): (F32x8, Vec3x8), below: [Vec3x8; 2]) -> Option<Upper> {
        let at = self.more.as_ref()?[lane].as_ref()?;
        let below = below.map(|all| all.lane(lane));
        Some(at.upper(cos.lane(lane), reflectance.lane(lane), below, SeenBy::Eye))
    }

    /// Puts what is above layers and below them there.
    #[inline(never)]
    fn add_more(&self, seen: &mut SeenBsdfs, at: (F32x8, Vec3x8), tangent: Vec3x8, below: [Vec3x8; 2]) {
        let stretched = self.stretched(seen.normal, tangent);
        let mut more = More { stretched: stretched.map(|lanes| [lanes; 2]), ..More::NONE };
        let [mut lets_through, mut shown] = [Vec3x8::splat(Vec3::ONE); 2];
        for lane in 0..LANES {
            let Some(upper) = self.upper(lane, at, below) else { continue };
            more.set(lane, &upper);
            lets_through.set_lane(lane, upper.lets_through);
            if let Some((rough, albedo)) = self.rough(lane, at) {
                let through = below[1].lane(lane) * upper.lets_through;
                more.rough.get_or_insert(RoughLanes::NONE).set(lane, &rough, albedo * through);
                shown.set_lane(lane, rough.shown);
            }
        }
        seen.gain = seen.gain * lets_through;
        seen.through = seen.through * lets_through * shown;
        let dimmed = Vec3x8::splat(Vec3::ONE) - seen.through;
        seen.added = self.has.select3(self.emission * dimmed, Vec3x8::ZERO);
        seen.more = Some(more);
    }

    /// Fibres of the surfaces that are hair, seen along `incoming`, if any is.
    fn hair(
        &self,
        reflectance: Vec3x8,
        axes: SurfaceAxes<Vec3x8>,
        incoming: Vec3x8,
    ) -> Option<[Option<SeenBsdf>; LANES]> {
        let all = self.more.as_ref()?;
        let is_hair = |at: &Option<BsdfAt<'_>>| at.is_some_and(|at| at.bsdf.hair.is_some());
        if !all.iter().any(is_hair) {
            return None;
        }
        Some(std::array::from_fn(|lane| {
            let at = all[lane].as_ref().filter(|at| at.bsdf.hair.is_some())?;
            let axes = SurfaceAxes {
                normal: axes.normal.lane(lane),
                geometric_normal: axes.geometric_normal.lane(lane),
                tangent: axes.tangent.lane(lane),
            };
            Some(at.seen(reflectance.lane(lane), axes, incoming.lane(lane), SeenBy::Eye))
        }))
    }

    /// Puts fibres in place of all else that their surfaces have.
    fn set_hair(&self, seen: &mut SeenBsdfs, hair: [Option<SeenBsdf>; LANES]) {
        for lane in (0..LANES).filter(|lane| hair[*lane].is_some()) {
            seen.gain.set_lane(lane, Vec3::ZERO);
            seen.through.set_lane(lane, Vec3::ONE);
            seen.added.set_lane(lane, Vec3::ZERO);
        }
        if let Some(more) = &mut seen.more {
            more.hair = Some(Box::new(HairLanes { seen: hair, drawn: hair }));
        }
    }

    /// Lobes of the layers on surfaces with these normals and tangents, if any is not round.
    fn stretched(&self, normal: Vec3x8, tangent: Vec3x8) -> Option<StretchedLanes> {
        let all = self.more.as_ref()?;
        let found: [Option<(Widths<f32>, [Vec3; 2])>; LANES] = std::array::from_fn(|lane| {
            all[lane].as_ref()?.stretched(self.alpha.lane(lane), normal.lane(lane), tangent.lane(lane))
        });
        if found.iter().all(Option::is_none) {
            return None;
        }
        let mut lanes = StretchedLanes::ROUND;
        for (lane, found) in found.into_iter().enumerate() {
            if let Some((widths, axes)) = found {
                lanes.set(lane, widths, axes);
            }
        }
        Some(lanes)
    }

    /// What is matt and rough in a lane, with its albedo.
    fn rough(&self, lane: usize, (cos, reflectance): (F32x8, Vec3x8)) -> Option<(SeenRough, Vec3)> {
        self.more.as_ref()?[lane].as_ref()?.rough(cos.lane(lane), reflectance.lane(lane))
    }

    /// [`Albedos::at`](super::albedos::Albedos::at) the cosines of eight surfaces.
    #[inline]
    fn shares_at(&self, cos: F32x8) -> Shares<F32x8> {
        let mut all = Shares::<F32x8>::none();
        for (lane, albedos) in self.albedos.iter().enumerate() {
            let Some(albedos) = albedos else { continue };
            let of_lane = albedos.at(cos.lane(lane));
            all.iter_mut().zip(of_lane).for_each(|(all, value)| all.set_lane(lane, value));
        }
        Shares::new(all)
    }
}

/// Normal of eight surfaces that are seen along `incoming`, and direction to the eye above it.
#[inline(always)]
fn seen_from(normal: Vec3x8, geometric_normal: Vec3x8, incoming: Vec3x8) -> [Vec3x8; 2] {
    let normal = facing_lanes(normal, geometric_normal, -incoming);
    let cos = -normal.dot(incoming);
    let to_eye = normal * (cos.max(F32x8::splat(LEAST_COSINE)) - cos) - incoming;
    [normal, to_eye.dot(to_eye).gt(F32x8::ZERO).select3(to_eye.normalize(), normal)]
}

/// [`facing`](super::seen::facing) for eight surfaces.
#[inline(always)]
fn facing_lanes(normal: Vec3x8, geometric_normal: Vec3x8, to_eye: Vec3x8) -> Vec3x8 {
    let cos = normal.dot(to_eye);
    let mirrored = normal * (cos + cos) - to_eye;
    let faces = cos.gt(F32x8::ZERO) & mirrored.dot(geometric_normal).gt(F32x8::ZERO);
    faces.select3(normal, geometric_normal)
}

#[cfg(test)]
mod tests {
    use super::super::tests::material;
    use super::super::{Bsdfs, SeenBy};
    use super::*;
    use crate::scene::Material;
    use crate::shade::area::{AreaRadiance, Beam};
    use crate::shade::light::LightSample;
    use crate::shade::sampling::PathRandom;

    #[test]
    fn one_surface_and_eight_are_the_same() {
        let materials = [material(0.4, 0.8, 0.6), Material::fallback()];
        let bsdfs = Bsdfs::new(&materials);
        let numbers = [0, 1, 0, 0, 1, 0, 0, 0];
        let [normal, incoming] = [Vec3::Y, Vec3::new(0.6, -0.8, 0.0)];
        let light = Vec3::new(0.36, 0.8, 0.48).normalize();
        let lanes = |v: Vec3| Vec3x8::splat(v);
        let eight = bsdfs.seen_lanes(
            &numbers.map(Look::plain),
            lanes(Vec3::ZERO),
            SurfaceAxes::of_normals([lanes(normal); 2]),
            lanes(incoming),
            None,
        );
        let eight = eight.expect("some have one");
        let sample = LightSample {
            to_light: lanes(light),
            direction: lanes(light),
            far: 1.0,
            irradiance: lanes(Vec3::ONE / PI),
            reaches: Mask::ALL,
        };
        let one = bsdfs
            .seen(Look::plain(0), Vec3::ZERO, SurfaceAxes::of_normals([normal; 2]), incoming, SeenBy::Eye)
            .expect("it has one");
        let highlight = eight.highlight(&sample, None);
        let (wanted, density) = one.highlight(light, Vec3::ONE / PI, false);
        assert!((highlight.lane(2) - wanted).abs().max_element() < 1e-4 * wanted.max_element(), "{wanted}");
        assert_eq!(highlight.lane(1), Vec3::ZERO);
        // rays see a part of a light with a size: of this radiance all points together are as dense as 2
        let followed = bsdfs.seen_lanes(
            &numbers.map(Look::plain),
            lanes(Vec3::ZERO),
            SurfaceAxes::of_normals([lanes(normal); 2]),
            lanes(incoming),
            Some(LayerRays { count: [3; LANES], followed: 0, incoming: lanes(incoming) }),
        );
        let weighed = followed
            .expect("some have one")
            .highlight(&sample, Some(AreaRadiance { full: Vec3::splat(2.0), beam: Beam::Even, is_met: true }))
            .lane(2);
        let share = 2.0 / (2.0 + 3.0 * density);
        assert!((weighed - wanted * share).abs().max_element() < 1e-4 * wanted.max_element(), "{weighed}");
        let shown = eight.show(lanes(Vec3::ONE));
        assert!((shown.lane(3) - one.through).abs().max_element() < 1e-6 && shown.lane(4) == Vec3::ONE);
        assert!(
            bsdfs
                .seen_lanes(
                    &[Look::plain(1); 8],
                    lanes(Vec3::ZERO),
                    SurfaceAxes::of_normals([lanes(normal); 2]),
                    lanes(incoming),
                    None
                )
                .is_none()
        );
    }

    /// Checks materials of every kind, seen from all sides, at grazing angles and from below too.
    #[test]
    fn eight_different_surfaces_are_seen_as_each_is_alone() {
        let materials = [(0.0, 1.0, 0.9), (0.3, 0.0, 0.5), (0.7, 0.6, 0.2), (1.0, 1.0, 0.0)]
            .map(|(roughness, metallic, base)| material(roughness, metallic, base));
        let bsdfs = Bsdfs::new(&[materials.as_slice(), &[Material::fallback()]].concat());
        for round in 0..200_u32 {
            let numbers: [u16; LANES] = std::array::from_fn(|lane| ((round + lane as u32 * 3) % 5) as u16);
            let any = |lane: usize, which: u32| {
                let [x, y, z, _] = PathRandom::new(round, lane as u32 * 4 + which).four(0);
                (Vec3::new(x, y, z) * 2.0 - 1.0).normalize_or(Vec3::X)
            };
            let [mut normal, mut geometric, mut incoming] = [Vec3x8::ZERO; 3];
            for lane in 0..LANES {
                geometric.set_lane(lane, any(lane, 0));
                normal.set_lane(lane, (any(lane, 0) + 0.3 * any(lane, 1)).normalize());
                incoming.set_lane(lane, any(lane, 2));
            }
            let reflectance = Vec3x8::splat(Vec3::new(0.2, 0.5, 0.9));
            let eight = bsdfs.seen_lanes(
                &numbers.map(Look::plain),
                reflectance,
                SurfaceAxes::of_normals([normal, geometric]),
                incoming,
                None,
            );
            let eight = eight.expect("some have one");
            for (lane, number) in numbers.iter().enumerate() {
                let normals = [normal.lane(lane), geometric.lane(lane)];
                let one = bsdfs.seen(
                    Look::plain(*number),
                    reflectance.lane(lane),
                    SurfaceAxes::of_normals(normals),
                    incoming.lane(lane),
                    SeenBy::Eye,
                );
                let (through, gain) = one.map_or((Vec3::ONE, Vec3::ZERO), |one| (one.through, one.gain * PI));
                let off = (eight.through.lane(lane) - through).abs().max_element();
                assert!(off < 1e-5, "round {round}, lane {lane}: {off}");
                let off = (eight.gain.lane(lane) - gain).abs().max_element();
                assert!(off < 1e-4 * gain.max_element().max(1.0), "round {round}, lane {lane}: {off}");
            }
        }
    }

    #[test]
    fn emission_is_not_dimmed() {
        let glowing = Material { emission: Vec3::new(3.0, 2.0, 1.0), ..material(0.4, 0.0, 0.5) };
        let bsdfs = Bsdfs::new(std::slice::from_ref(&glowing));
        let [up, down] = [Vec3::Z, Vec3::NEG_Z].map(Vec3x8::splat);
        let seen = bsdfs
            .seen_lanes(&[Look::plain(0); 8], Vec3x8::ZERO, SurfaceAxes::of_normals([up; 2]), down, None)
            .expect("all have one");
        assert_eq!(seen.show(Vec3x8::splat(glowing.emission)).lane(0), glowing.emission);
    }
}

//! Emitting surfaces for next-event estimation: random points on them.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};

use super::deformed::{Deformations, Deformed, smooth_point};
use super::emitter_parts::{EmitterParts, EmitterTriangle};
use super::light_chances::Sent;
use super::surface::{corners_of, facing};
use crate::animation::{Track, Transform};
use crate::exposure::Tick;
use crate::geometry::Bounds;
use crate::pose::Pose;
use crate::scene::cutout::{Asks, CutoutTest};
use crate::scene::material::Computes;
use crate::scene::on_mesh::OnMesh;
use crate::scene::render_space::Extent;
use crate::scene::{Material, Mesh, Model, RayKind, Scene, Triangles};

/// Triangles of a scene that emit light. Curved geometry is not among them: paths that meet it bring its
/// light. They are chosen by [parts](EmitterParts), by how near these are; within its part each triangle in
/// proportion to the light that it sends, and each point on it as often as any other.
///
/// Probabilities are those of the shot, not of a frame: a model that grows sends more light, and its
/// triangles are chosen no more often. So the result of a path stays valid until something on its way moves.
#[derive(Debug, Clone, Default)]
pub struct Emitters {
    parts: EmitterParts,
    /// Light that a unit of area of each material sends, relative to the others.
    brightness: Vec<f32>,
    /// Probability, for each model, that a unit of its area (object space) is chosen by its light alone, for
    /// each unit of brightness.
    chance: Vec<f32>,
    /// Test of each model for places that are cut out, if it emits and any are.
    cut: Vec<Option<Arc<CutoutTest>>>,
    /// True if surfaces emit of which no points are chosen.
    are_met_alone: bool,
    /// True if light of any material depends on the angle at which it is seen.
    is_of_eye: bool,
}

/// Point on an emitting surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EmitterPlace {
    /// Model of the surface.
    pub model: u32,
    /// Point, world space.
    pub point: Vec3,
    /// Normal of the triangle, unit length, world space. It emits to both sides.
    pub normal: Vec3,
    /// Radiance to all directions; linear RGB.
    pub radiance: Vec3,
    /// Density with which the point is chosen, for each unit of area; world space.
    pub density: f32,
}

/// An emitting model that is not there: it is chosen as often as if it were, and sends no light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NotThere {
    /// Number of the model.
    pub model: u32,
}

/// Returns true if points are chosen on the emitting surfaces of a model. The light of others is found by the rays
/// alone that meet them: of curved geometry, and of models that are hidden from rays by which surfaces would find what they
/// ask for. (A model that is hidden from glossy rays is asked, and layers reflect none of its light; but not where glass
/// may show it to a path that a layer has reflected.)
fn is_asked(scene: &Scene) -> impl Fn(&Model) -> bool + use<> {
    let has_glass = scene.materials.iter().any(Material::lets_through);
    move |model| {
        let hidden_from = model.ray_visibility.hidden_from;
        let is_hidden = [RayKind::Diffuse, RayKind::Transmission].iter().any(|kind| hidden_from.has(*kind))
            || has_glass && hidden_from.has(RayKind::Glossy);
        !model.mesh.is_curved() && !is_hidden
    }
}

impl Emitters {
    /// Collects the emitters of all models of `scene`, of which these are the bounds, object space.
    pub fn new(scene: &Scene, bounds: &[Bounds]) -> Self {
        let brightness = brightness_of(scene);
        if brightness.iter().all(|brightness| *brightness == 0.0) {
            return Self::default();
        }
        let is_asked = is_asked(scene);
        let mut triangles = Vec::new();
        // models may share a mesh: it is searched once
        let mut known: HashMap<*const Mesh, Vec<u32>> = HashMap::new();
        for (model, number) in scene.models.iter().zip(0..).filter(|(model, _)| is_asked(model)) {
            let glowing =
                known.entry(Arc::as_ptr(&model.mesh)).or_insert_with(|| glowing_of(&model.mesh, &brightness));
            let Some(all) = model.mesh.as_triangles().filter(|_| !glowing.is_empty()) else { continue };
            let (growth, stands) = (growth(model), Stand::of(model, &bounds[number as usize]));
            for triangle in glowing.iter().copied() {
                let material = model.mesh.material_of[triangle as usize];
                let brightness = f64::from(brightness[usize::from(material)]);
                let [a, b, c] = corners_of(all, triangle);
                let weight = brightness * growth * 0.5 * (b - a).cross(c - a).length();
                if weight > 0.0 && weight.is_finite() {
                    let (place, reach, normal) = stands.place([a, b, c]);
                    triangles.push(EmitterTriangle { model: number, triangle, weight, place, reach, normal });
                }
            }
        }
        let total: f64 = triangles.iter().map(|each| each.weight).sum();
        let emits = |model: &Model| {
            model.mesh.material_of.iter().any(|material| brightness[usize::from(*material)] > 0.0)
        };
        let are_met_alone = scene.models.iter().any(|model| !is_asked(model) && emits(model));
        let chance_of =
            |model: &Model| if is_asked(model) && total > 0.0 { growth(model) / total } else { 0.0 };
        let chance = scene.models.iter().map(|model| chance_of(model) as f32).collect();
        let mut tests: HashMap<*const Mesh, Option<Arc<CutoutTest>>> = HashMap::new();
        let test_of = |model: &Model| {
            let test = || CutoutTest::new(&model.mesh).filter(|_| emits(model)).map(Arc::new);
            tests.entry(Arc::as_ptr(&model.mesh)).or_insert_with(test).clone()
        };
        let cut = scene.models.iter().map(test_of).collect();
        let is_of_eye = scene.materials.iter().any(Material::is_of_eye);
        let parts = EmitterParts::new(scene, bounds, triangles);
        Self { parts, brightness, chance, cut, are_met_alone, is_of_eye }
    }

    /// Returns true if nothing emits.
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty() && !self.are_met_alone
    }

    /// Returns true if there are points to choose.
    pub fn are_asked(&self) -> bool {
        !self.parts.is_empty()
    }

    /// Returns true if surfaces of `material` emit.
    pub fn emits(&self, material: u16) -> bool {
        self.brightness.get(usize::from(material)).is_some_and(|brightness| *brightness > 0.0)
    }

    /// Chooses a point for a surface at `asked_from` (world space) by three numbers from 0 to below 1, if there
    /// are any. Returns [`NotThere`] with the model on which it would be, if that is not there. `sent`: what is
    /// known of the last surface for which one of these was chosen.
    pub fn choose(
        &self,
        scene: &Scene,
        (pose, tick): (&Pose, Tick),
        deformations: &Deformations,
        (asked_from, sent): (Vec3, &mut Sent),
        random: [f32; 3],
    ) -> Option<Result<EmitterPlace, NotThere>> {
        let [choice, along, above] = random;
        if self.parts.is_empty() {
            return None;
        }
        let ((model, triangle), likelihood) = self.parts.choose(asked_from, choice, sent);
        let triangles = scene.models[model as usize].mesh.as_triangles()?;
        let transform = pose.transform(model as usize, tick);
        if !transform.is_visible {
            return Some(Err(NotThere { model }));
        }
        let deformed = deformations.of_model(scene, model, transform);
        let corners =
            deformed.map_or_else(|| corners_of(triangles, triangle), |deformed| deformed.corners(triangle));
        let normal = transform.normal(normal_of(corners));
        let [a, b, c] = corners.map(|corner| transform.point(corner.as_vec3()));
        // even over the triangle: Turk, "Generating Random Points in Triangles", Graphics Gems, 1990
        let root = along.sqrt();
        let weights = [root * (1.0 - above), root * above];
        let point = a * (1.0 - root) + b * weights[0] + c * weights[1];
        let mut place = OnMesh::on(&scene.models[model as usize], triangle, weights);
        if self.is_of_eye && scene.materials[usize::from(place.material())].is_of_eye() {
            let along = point - asked_from;
            place = place.seen_at(facing_of(&place, (transform, deformed.as_ref()), normal, along));
        }
        // a place that is cut out is chosen as often as any other, and sends no light
        let is_there = self.cut[model as usize]
            .as_ref()
            .is_none_or(|test| test.is_there(triangle, weights, Asks::Sight));
        Some(Ok(EmitterPlace {
            model,
            point,
            normal,
            radiance: if is_there { place.emission(scene) } else { Vec3::ZERO },
            density: likelihood
                * self.density_by_light(scene, (pose, tick), deformations, (model, triangle), normal),
        }))
    }

    /// Density with which a surface at `asked_from` (world space) chooses a point on a triangle of a model, for
    /// each unit of area in world space. `normal`: of the triangle, unit length, world space, on either side.
    pub fn density(
        &self,
        scene: &Scene,
        (pose, tick): (&Pose, Tick),
        deformations: &Deformations,
        asked_from: Vec3,
        (model, triangle): (u32, u32),
        normal: Vec3,
    ) -> f32 {
        let by_light = self.density_by_light(scene, (pose, tick), deformations, (model, triangle), normal);
        if by_light == 0.0 { 0.0 } else { by_light * self.parts.likelihood(asked_from, model, triangle) }
    }

    /// Density with which a point would be chosen by the light of its triangle alone.
    fn density_by_light(
        &self,
        scene: &Scene,
        (pose, tick): (&Pose, Tick),
        deformations: &Deformations,
        (model, triangle): (u32, u32),
        normal: Vec3,
    ) -> f32 {
        let mesh = &scene.models[model as usize].mesh;
        let material = mesh.material_of[triangle as usize];
        let Some(brightness) =
            self.brightness.get(usize::from(material)).filter(|brightness| **brightness > 0.0)
        else {
            return 0.0;
        };
        let transform = pose.transform(model as usize, tick);
        let mut of_object = brightness * self.chance[model as usize];
        if let Some(deformed) = deformations.of_model(scene, model, transform) {
            of_object *= deformed.shrinks(triangle) as f32;
        }
        if transform.is_identity {
            return of_object;
        }
        // a linear map M takes an area with the unit normal n to one that is |det M| / |transpose(M) n| times
        // as large, where n is the normal of the result
        let map = transform.to_world.matrix3;
        of_object * Vec3::from(map.transpose() * glam::Vec3A::from(normal)).length() / map.determinant().abs()
    }
}

/// Cosine of the angle at which a place on an emitter is seen `along` a way, as paths that meet it see it: that of the curved surface for
/// which its triangle stands. `normal`: of the triangle, world space. Not inlined: hardly any emitter depends on the angle.
#[inline(never)]
fn facing_of(
    place: &OnMesh,
    (transform, deformed): (&Transform, Option<&Deformed>),
    normal: Vec3,
    along: Vec3,
) -> f32 {
    let smooth = smooth_point(place.mesh, place.primitive, place.position(), deformed);
    let smooth = smooth.and_then(|smooth| smooth.normal().try_normalize());
    facing([smooth.map_or(normal, |smooth| transform.normal(smooth)), normal], along)
}

/// Light that a unit of area of each material sends, relative to the others. Where graphs compute it, it is the mean over some places.
fn brightness_of(scene: &Scene) -> Vec<f32> {
    let mut brightness: Vec<f32> =
        scene.materials.iter().map(|material| luminance(material.emission)).collect();
    let is_computed = |material: &Material| {
        material.emission != Vec3::ZERO && (material.is_computed(Computes::Emission) || material.is_blended())
    };
    for (number, material) in scene.materials.iter().enumerate().filter(|(_, one)| is_computed(one)) {
        let mean = mean_brightness(scene, number as u16);
        // what is dark at these places may glow between them
        brightness[number] = mean.max(LEAST_BRIGHTNESS * luminance(material.emission));
    }
    brightness
}

/// Least brightness of a material that may glow, as a share of its emission.
const LEAST_BRIGHTNESS: f32 = 1e-4;

/// Places, at least, at which the mean of a material's light is asked; twice as many at most.
const PLACES: usize = 1024;

/// Mean luminance of the light that a material sends, over all surfaces that have it.
fn mean_brightness(scene: &Scene, material: u16) -> f32 {
    let triangles = |model: &Model| {
        let of = model.mesh.material_of.iter().enumerate().filter(|(_, of)| **of == material);
        of.map(|(triangle, _)| triangle as u32).collect::<Vec<_>>()
    };
    let mut known = HashSet::new();
    let models: Vec<(&Model, &Triangles, Vec<u32>)> = scene
        .models
        .iter()
        .filter_map(|model| Some((model, model.mesh.as_triangles()?)))
        .filter(|(model, _)| known.insert(Arc::as_ptr(&model.mesh)))
        .map(|(model, all)| (model, all, triangles(model)))
        .collect();
    let count: usize = models.iter().map(|(.., triangles)| triangles.len()).sum();
    let (step, places) = ((count / PLACES).max(1), (PLACES / count.max(1)).max(1));
    let all = models
        .iter()
        .flat_map(|(model, all, triangles)| triangles.iter().map(move |one| (*model, *all, *one)));
    let (mut sum, mut area) = (0.0, 0.0);
    for (number, (model, all, triangle)) in all.step_by(step).enumerate() {
        let [a, b, c] = corners_of(all, triangle);
        let of_triangle = (b - a).cross(c - a).length();
        let light = (0..places).map(|place| {
            let number = number * places + place;
            let on = OnMesh::on(model, triangle, place_in_triangle(number)).seen_at(cosine_of_place(number));
            f64::from(luminance(on.emission(scene)))
        });
        sum += of_triangle * light.sum::<f64>() / places as f64;
        area += of_triangle;
    }
    if area > 0.0 { (sum / area) as f32 } else { 0.0 }
}

/// Cosine of the angle at which place number `number` is seen: as often as light leaves a matt surface at that angle.
fn cosine_of_place(number: usize) -> f32 {
    let golden = 0.618_033_988_749_894_8;
    ((number as f64 * golden + 0.5).fract() as f32).sqrt()
}

/// Weights of the second and third corner of place number `number`: even over the triangle (the sequence R2 of M. Roberts, "The unreasonable
/// effectiveness of quasirandom sequences", 2018).
fn place_in_triangle(number: usize) -> [f32; 2] {
    let at = |step: f64| ((number as f64 * step + 0.5).fract()) as f32;
    let (root, above) = (at(0.754_877_666_246_692_8).sqrt(), at(0.569_840_290_998_053_3));
    [root * (1.0 - above), root * above]
}

/// Where a model is in the shot.
enum Stand {
    /// It stands still.
    Still(DAffine3),
    /// It is within a box, of which these are the middle and half of the diagonal.
    Within(DVec3, f64),
}

impl Stand {
    /// `bounds`: of the model, object space.
    fn of(model: &Model, bounds: &Bounds) -> Self {
        let frames = model.track.key_frames();
        let map = |frame: &f64| model.track.map_at(*frame);
        if model.track.shapes.is_none() && frames.windows(2).all(|two| map(&two[0]) == map(&two[1])) {
            return Self::Still(frames.first().map_or(DAffine3::IDENTITY, map));
        }
        let way = Extent::NONE.with_model((bounds.low.as_dvec3(), bounds.high.as_dvec3()), &model.track);
        Self::Within(way.center(), 0.5 * way.diagonal())
    }

    /// Middle of a triangle, the distance from it within which it stays, and its normal, if that stays.
    fn place(&self, corners: [DVec3; 3]) -> (DVec3, f64, Vec3) {
        match self {
            Self::Still(map) => {
                let [a, b, c] = corners.map(|corner| map.transform_point3(corner));
                ((a + b + c) / 3.0, 0.0, normal_of([a, b, c]))
            }
            Self::Within(middle, reach) => (*middle, *reach, Vec3::ZERO),
        }
    }
}

/// Triangles of `mesh` that emit, given the brightness of each material.
fn glowing_of(mesh: &Mesh, brightness: &[f32]) -> Vec<u32> {
    let materials = (0..).zip(&mesh.material_of);
    let glowing = materials.filter(|(_, material)| brightness[usize::from(**material)] > 0.0);
    glowing.map(|(triangle, _)| triangle).collect()
}

/// Normal of a triangle with these corners, unit length.
fn normal_of([a, b, c]: [DVec3; 3]) -> Vec3 {
    (b - a).cross(c - a).normalize_or(DVec3::Y).as_vec3()
}

/// Share of light to which the eye is sensitive: Rec. 709 luminance.
fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Largest factor, about, by which a model's area grows from its file to the world: that of an even scale.
fn growth(model: &Model) -> f64 {
    let of_volume = |volume: f64| volume.abs().powf(2.0 / 3.0);
    let of_scale = model.track.scale.values().map(|scale| of_volume(scale.x * scale.y * scale.z));
    let matrices = model.track.matrix.iter().flat_map(Track::values);
    let of_matrix = matrices.map(|matrix| of_volume(matrix.matrix3.determinant())).reduce(f64::max);
    of_scale.fold(0.0, f64::max) * of_matrix.unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use glam::DMat3;

    use super::*;
    use crate::animation::{ShapeTrack, Visibility};
    use crate::exposure::MIDDLE_TICK;
    use crate::scene::{self, Shapes};
    use crate::shade::sampling::PathRandom;

    /// Creates the city with every second material glowing.
    fn glowing_city() -> Scene {
        let mut scene = scene::load(Path::new("scenes/city/city.toml"), false).expect("it is shipped").scene;
        for (material, number) in scene.materials.iter_mut().zip(0..) {
            material.emission = Vec3::new(0.5, 1.0, 2.0) * (number % 2) as f32;
        }
        // moved, to differ from models that stand in the world as in their files
        for model in scene.models.iter_mut().filter(|model| !model.track.is_constant()) {
            model.track.scale = Track::constant(DVec3::new(1.0, 3.0, 0.5));
            let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.5, -2.0, 0.0), DVec3::Z);
            model.track.matrix = Some(Track::constant(DAffine3::from_mat3(shear)));
        }
        scene
    }

    /// Bends and stretches all that moves, unevenly.
    fn bent(mut scene: Scene) -> Scene {
        let moves = |model: &&mut Model| !model.track.is_constant() && !model.mesh.is_curved();
        for model in scene.models.iter_mut().filter(moves) {
            let bend = |at: &[f32; 3]| [at[0] * 2.0, at[1] + at[0] * at[2], at[2] * 0.75 + 0.3 * at[1]];
            let triangles = model.mesh.triangles();
            let rest = triangles.positions.as_slice().to_vec();
            let list = vec![rest.iter().map(bend).collect(), rest];
            let places: Vec<u32> = (0..triangles.positions.as_slice().len() as u32).collect();
            let shapes = Arc::new(Shapes::new(list, &triangles.corners, &[], &places));
            model.track.shapes = ShapeTrack::through(vec![(0.0, 0), (25.0, 1)], None);
            let deforming = Mesh::clone(&model.mesh).with_triangles(|all| all.shapes = Some(shapes));
            model.mesh = Arc::new(deforming);
        }
        scene
    }

    fn emitters_of(scene: &Scene) -> Emitters {
        let bounds: Vec<Bounds> = scene.models.iter().map(|model| Bounds::of(&model.mesh)).collect();
        Emitters::new(scene, &bounds)
    }

    fn deformations(scene: &Scene, pose: &Pose) -> Deformations {
        Deformations::new(scene, &pose.models, false)
    }

    fn world_area(
        scene: &Scene,
        (pose, shapes): (&Pose, &Deformations),
        model: usize,
        triangle: u32,
    ) -> (f32, Vec3) {
        let triangles = scene.models[model].mesh.triangles();
        let corners = shapes
            .of_model(scene, model as u32, &pose.models[model])
            .map_or_else(|| corners_of(triangles, triangle), |deformed| deformed.corners(triangle));
        let [a, b, c] = corners.map(|corner| pose.models[model].point(corner.as_vec3()).as_dvec3());
        let across = (b - a).cross(c - a);
        ((0.5 * across.length()) as f32, across.normalize_or(DVec3::Y).as_vec3())
    }

    /// Surfaces that ask: in the middle of the city, beside it, and far away.
    const ASKED_FROM: [Vec3; 3] = [Vec3::new(4.0, 20.0, 0.0), Vec3::new(-90.0, 5.0, 160.0), Vec3::splat(1e6)];

    #[test]
    fn the_density_of_all_places_is_one() {
        for (scene, asked_from) in [glowing_city(), bent(glowing_city())]
            .iter()
            .flat_map(|scene| ASKED_FROM.map(|from| (scene, from)))
        {
            let emitters = emitters_of(scene);
            assert!(scene.models.iter().any(|model| !model.track.is_constant()), "or too little is tested");
            for frame in [1, 20] {
                let pose = Pose::new(scene, frame);
                let shapes = deformations(scene, &pose);
                let mut sum = 0.0;
                for (number, model) in scene.models.iter().enumerate() {
                    for (triangle, material) in (0..).zip(&model.mesh.material_of) {
                        let (area, normal) = world_area(scene, (&pose, &shapes), number, triangle);
                        let primitive = (number as u32, triangle);
                        let density = emitters.density(
                            scene,
                            (&pose, MIDDLE_TICK),
                            &shapes,
                            asked_from,
                            primitive,
                            normal,
                        );
                        assert_eq!(density > 0.0, emitters.emits(*material));
                        sum += f64::from(area * density);
                    }
                }
                assert!((sum - 1.0).abs() < 1e-3, "frame {frame}: {sum}");
            }
        }
    }

    #[test]
    fn places_are_as_dense_as_they_say() {
        for (scene, asked_from) in [glowing_city(), bent(glowing_city())]
            .iter()
            .flat_map(|scene| ASKED_FROM.map(|from| (scene, from)))
        {
            let (emitters, pose) = (emitters_of(scene), Pose::new(scene, 20));
            let shapes = deformations(scene, &pose);
            let (mut counts, mut sent) = (vec![0; scene.models.len()], Sent::NOWHERE);
            const DRAWN: u32 = 4096;
            for index in 0..DRAWN {
                let [choice, along, above, _] = PathRandom::new(5, index).four(0);
                let place = emitters.choose(
                    scene,
                    (&pose, MIDDLE_TICK),
                    &shapes,
                    (asked_from, &mut sent),
                    [choice, along, above],
                );
                let place = place.expect("much glows").expect("all are there");
                counts[place.model as usize] += 1;
                assert!(place.radiance.y == 1.0 && place.normal.is_normalized());
            }
            for (number, model) in scene.models.iter().enumerate() {
                let glowing =
                    (0..).zip(&model.mesh.material_of).filter(|(_, material)| emitters.emits(**material));
                let share = glowing.map(|(triangle, _)| {
                    let (area, normal) = world_area(scene, (&pose, &shapes), number, triangle);
                    let primitive = (number as u32, triangle);
                    area * emitters.density(
                        scene,
                        (&pose, MIDDLE_TICK),
                        &shapes,
                        asked_from,
                        primitive,
                        normal,
                    )
                });
                let (expected, found) = (share.sum::<f32>(), counts[number] as f32 / DRAWN as f32);
                assert!((expected - found).abs() < 0.01, "{}: {expected}, {found}", model.name);
            }
        }
    }

    #[test]
    fn what_is_not_there_is_chosen_as_often_and_is_no_place() {
        let mut scene = glowing_city();
        let count = |scene: &Scene| {
            let (emitters, pose) = (emitters_of(scene), Pose::new(scene, 20));
            let choose = |index| {
                let [choice, along, above, _] = PathRandom::new(5, index).four(0);
                let asked_from = (ASKED_FROM[0], &mut Sent::default());
                let rests = Deformations::default();
                emitters
                    .choose(scene, (&pose, MIDDLE_TICK), &rests, asked_from, [choice, along, above])
                    .expect("much glows")
            };
            (0..1024).map(choose).map(|chosen| chosen.map(|place| place.model)).collect::<Vec<_>>()
        };
        let before = count(&scene);
        let away = before[0].expect("all are there");
        scene.models[away as usize].track.visible =
            Visibility::through(true, vec![(20.0, false)]).expect("good");
        let expected = |model: u32| if model == away { Err(NotThere { model }) } else { Ok(model) };
        assert_eq!(count(&scene), before.into_iter().flatten().map(expected).collect::<Vec<_>>());
    }

    #[test]
    fn a_scene_where_nothing_glows_has_none() {
        let scene = scene::load(Path::new("scenes/city/city.toml"), false).expect("it is shipped").scene;
        let dark = Scene {
            materials: scene
                .materials
                .into_iter()
                .map(|of| scene::Material { emission: Vec3::ZERO, ..of })
                .collect(),
            ..scene
        };
        let emitters = emitters_of(&dark);
        assert!(emitters.is_empty() && !emitters.emits(0));
        let (pose, rests) = (Pose::new(&dark, 1), Deformations::default());
        assert_eq!(
            emitters.choose(
                &dark,
                (&pose, MIDDLE_TICK),
                &rests,
                (Vec3::ZERO, &mut Sent::default()),
                [0.5; 3]
            ),
            None
        );
    }
}

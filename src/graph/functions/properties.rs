//! Properties of our arithmetic that do not need Blender: finite results above all.
use super::color::{self, Adjustment, Model};
use super::curve::{self, Table};
use super::map_range::{Clamp, Progress, Ranges};
use super::math::Math;
use super::mix::{self, Blend};
use super::ramp::{Hue, Interpolation, Mode, Ramp, Stop};
use super::vector::{Mapping, Rotate, Turn};
use super::vector_math::VectorMath;
use super::{fresnel, spectrum};
use crate::lanes::{F32x8, Vec3x8};
use glam::Vec3;

/// Numbers that arithmetic stumbles over: each sign, and the smallest and largest ones.
const NUMBERS: [f32; 17] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    -2.0,
    3.0,
    1e-5,
    88.8,
    f32::EPSILON,
    1e-42,
    -1e-42,
    f32::MIN_POSITIVE,
    1e20,
    -1e20,
    f32::MAX,
    f32::MIN,
];

/// Vectors of such numbers, in many orders.
fn vectors() -> Vec<Vec3> {
    let pick = |index: usize| NUMBERS[index % NUMBERS.len()];
    let mixed =
        (0..NUMBERS.len() * 2).map(|index| Vec3::new(pick(index), pick(index * 3 + 1), pick(index * 7 + 2)));
    mixed.chain(NUMBERS.map(Vec3::splat)).collect()
}

/// Returns true if a number has no lane that is infinite or NaN.
fn is_finite(number: F32x8) -> bool {
    number.values().iter().all(|number| number.is_finite())
}

/// The same of vectors.
fn are_finite(vector: Vec3x8) -> bool {
    [vector.x, vector.y, vector.z].into_iter().all(is_finite)
}

fn triples<T: Copy>(of: &[T]) -> impl Iterator<Item = (T, T, T)> {
    of.iter().flat_map(move |&a| of.iter().flat_map(move |&b| of.iter().map(move |&c| (a, b, c))))
}

#[test]
fn numbers_stay_finite() {
    for (a, b, c) in triples(&NUMBERS) {
        let [first, second, third] = [a, b, c].map(F32x8::splat);
        for operation in Math::ALL {
            assert!(is_finite(operation.apply(first, second, third)), "{operation:?} of {a} {b} {c}");
        }
        for clamp in Clamp::ALL {
            assert!(is_finite(clamp.apply(first, second, third)), "{clamp:?} of {a} {b} {c}");
        }
        assert!(is_finite(mix::float(first, second, third)), "a mixture of {a} {b} {c}");
        for inside in [false, true] {
            let weights = [fresnel::fresnel(a, b, inside), fresnel::layer_fresnel(a, b, inside)];
            assert!(weights.iter().all(|weight| weight.is_finite()), "the reflectance of {a} {b}");
        }
        assert!(fresnel::layer_facing(a, b).is_finite(), "a weight of {a} {b}");
    }
}

#[test]
fn vectors_stay_finite() {
    for (a, b, c) in triples(&vectors()) {
        let what = [a, b, c];
        let [a, b, c] = what.map(Vec3x8::splat);
        for operation in VectorMath::ALL {
            let (vector, value) = (operation.vector(a, b, c, c.x), operation.value(a, b));
            assert!(are_finite(vector) && is_finite(value), "{operation:?} of {what:?}");
        }
        for mapping in Mapping::ALL {
            assert!(are_finite(mapping.apply(a, b, c, b)), "{mapping:?} of {what:?}");
        }
        for rotate in Rotate::ALL {
            let turn = Turn { axis: c, angle: a.x, rotation: c, invert: false };
            assert!(are_finite(rotate.apply(a, b, &turn)), "{rotate:?} of {what:?}");
        }
        for progress in Progress::ALL {
            let mapped = Ranges { from: [a, b], to: [b, c], steps: c }.map(*progress, false, c);
            let number = Ranges { from: [a.x, b.x], to: [b.y, c.y], steps: c.x }.map(*progress, true, c.z);
            assert!(are_finite(mapped) && is_finite(number), "{progress:?} of {what:?}");
        }
    }
}

#[test]
fn colors_stay_finite() {
    for (a, b, c) in triples(&vectors()) {
        let what = [a, b, c];
        assert!(
            spectrum::wavelength(a.x).is_finite() && spectrum::blackbody(a.x).is_finite(),
            "light of {a}"
        );
        let [a, b, c] = what.map(Vec3x8::splat);
        for blend in Blend::ALL {
            assert!(are_finite(blend.apply(c.x, a, b)), "{blend:?} of {what:?}");
        }
        let change = Adjustment { hue: b.x, saturation: b.y, value: b.z, factor: c.x };
        let gray = color::brightness_contrast(a, b.x, c.x);
        let made = [change.apply(a), gray, color::gamma(a, b.x), color::invert(b.x, a)];
        assert!(made.into_iter().all(are_finite), "colours of {what:?}");
        assert!(is_finite(color::luma(a)), "colours of {what:?}");
        for model in Model::ALL {
            assert!(are_finite(model.separate(a)) && are_finite(model.combine(a)), "{model:?} of {what:?}");
        }
    }
}

#[test]
fn ramps_and_curves_stay_finite() {
    let stop = |position: f32, color: Vec3| Stop { position, color: color.extend(position).to_array() };
    let modes = Hue::ALL.iter().flat_map(|&hue| [Mode::Rgb, Mode::Hsv(hue), Mode::Hsl(hue)]);
    for (mode, color) in modes.flat_map(|mode| vectors().into_iter().map(move |color| (mode, color))) {
        for interpolation in Interpolation::ALL {
            let stops =
                vec![stop(color.y, color), stop(0.5, -color), stop(0.5, color), stop(color.z, Vec3::ONE)];
            let ramp = Ramp::new(stops, *interpolation, mode);
            let finite = |at: f32| ramp.value(F32x8::splat(at)).into_iter().all(is_finite);
            assert!(NUMBERS.into_iter().all(finite), "{interpolation:?} {mode:?} of {color}");
        }
    }
    for (from, to, at) in triples(&NUMBERS) {
        for values in [vec![], vec![from], vec![from, to], NUMBERS.to_vec()] {
            let table = Table { from, to, values, extrapolate: true };
            let mixed = curve::float(F32x8::splat(to), F32x8::splat(at), &table);
            assert!(table.value(at).is_finite() && is_finite(mixed), "{table:?} at {at}");
        }
    }
}

#[test]
fn colors_survive_the_way_there_and_back() {
    for model in Model::ALL {
        for color in [Vec3::new(0.1, 0.7, 0.3), Vec3::new(0.9, 0.2, 0.25), Vec3::splat(0.4), Vec3::ZERO] {
            let back = model.combine(model.separate(Vec3x8::splat(color))).lane(5);
            assert!((back - color).abs().max_element() < 1e-6, "{model:?} of {color}: {back}");
        }
    }
}

#[test]
fn names_lead_back() {
    assert!(Math::ALL.iter().all(|math| Math::named(math.name()) == Some(*math)));
    assert_eq!(Math::named("multiply_add"), Some(Math::MultiplyAdd));
    assert_eq!(Math::named("MULTIPLY_ADD"), None);
    assert_eq!(Mode::named("hsl", "ccw"), Some(Mode::Hsl(Hue::Counterclockwise)));
    assert_eq!(Mode::named("hsl", "up"), None);
}

#[test]
fn ramps_of_no_stop_and_of_one_have_values() {
    let ramp = |stops| Ramp::new(stops, Interpolation::BSpline, Mode::Rgb);
    let value = |ramp: Ramp| ramp.value(F32x8::splat(0.3)).map(|channel| channel.lane(1));
    assert_eq!(value(ramp(vec![])), [0.0; 4]);
    let color = [0.2, 2.0, 0.4, 0.5];
    assert_eq!(value(ramp(vec![Stop { position: 0.7, color }])), color);
}

#[test]
fn curves_end_as_told() {
    let table = |extrapolate| Table { from: -1.0, to: 1.0, values: vec![3.0, 1.0, 2.0], extrapolate };
    let at = |extrapolate| [-2.0, -1.0, -0.5, 0.0, 1.0, 3.0].map(|at| table(extrapolate).value(at));
    assert_eq!(at(false), [3.0, 3.0, 2.0, 1.0, 2.0, 2.0]);
    assert_eq!(at(true), [5.0, 3.0, 2.0, 1.0, 2.0, 4.0]);
}

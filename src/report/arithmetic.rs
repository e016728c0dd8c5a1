//! Arithmetic of this machine, as far as pixels depend on it: machines with the same name of it give the same pixels.
//!
//! Embree has code for each of several instruction sets, and they round differently: with AVX-512 a hit may be a unit in the last place
//! from that with AVX2. The functions of the system's mathematical library round differently from version to version, and some of
//! them from processor to processor.

use std::hint::black_box;
use std::sync::LazyLock;

use crate::digest::Digest;
use crate::trace::BackendKind;
use crate::trace::embree::{check_config, device_config, settings};

/// Settings of Embree's device that change no answer.
const WITHOUT_EFFECT: [&str; 7] =
    ["threads", "user_threads", "start_threads", "set_affinity", "hugepages", "verbose", "frequency_level"];

/// Number of arguments by which functions are told apart: versions that round differently differ in some of a hundred.
const ARGUMENTS: u32 = 512;

/// Name of the arithmetic by which a backend makes pixels.
pub fn name(kind: BackendKind) -> String {
    match kind {
        BackendKind::Embree => format!("{}, functions {}", embree(), functions()),
        BackendKind::Rust => format!("functions {}", functions()),
    }
}

/// Lanes of the packets that Embree prefers here.
static LANES: LazyLock<Result<usize, String>> = LazyLock::new(|| {
    let config = device_config().map_err(|error| error.0)?;
    let device = embree::Device::new(&config).map_err(|error| error.to_string())?;
    let lanes = device.native_width().lanes();
    // a device that is released right after it was made waits for ever where memory is limited (seen with Embree 4.4 and `ulimit -v`)
    std::mem::forget(device);
    Ok(lanes)
});

/// Name of the instruction set that Embree uses here, and the settings of its device that may change answers.
fn embree() -> String {
    let lanes = match &*LANES {
        Ok(lanes) => *lanes,
        Err(error) => return format!("does not start: {error}"),
    };
    // the device would not have started
    let config = check_config().unwrap_or_default();
    named(lanes, &config.to_lowercase(), &detected())
}

/// Names of the instruction sets that this processor has, of those that Embree knows.
fn detected() -> Vec<&'static str> {
    let mut sets = vec!["sse2"];
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("sse4.2") {
            sets.push("sse4.2");
        }
        if is_x86_feature_detected!("avx") {
            sets.push("avx");
        }
        // Embree takes them together
        if is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("f16c")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
        {
            sets.push("avx2");
        }
    }
    sets
}

/// Name of the set of a device with packets of so many `lanes`, on a processor that has `sets`, the best of them last, with a
/// configuration in lower case.
fn named(lanes: usize, config: &str, sets: &[&str]) -> String {
    let settings = || settings(config);
    let key = |setting: &str| setting.split('=').next().unwrap_or_default().to_owned();
    let is_set = |setting: &&str| matches!(key(setting).as_str(), "isa" | "max_isa");
    let asked = settings().rfind(is_set).and_then(|setting| setting.split('=').nth(1));
    let candidates = match lanes {
        16 => &["avx512"][..],
        8 => &["avx2", "avx"],
        _ => &["sse4.2", "sse2"],
    };
    let has = |name: &&&str| lanes == 16 || sets.contains(*name);
    let best = candidates.iter().find(has).copied().unwrap_or(candidates[0]);
    let chosen = candidates.iter().find(|name| asked == Some(**name)).copied().unwrap_or(best);
    let rest =
        settings().filter(|setting| !is_set(setting) && !WITHOUT_EFFECT.contains(&key(setting).as_str()));
    std::iter::once(chosen).chain(rest).collect::<Vec<_>>().join(" ")
}

/// Digest of what mathematical functions of the system give for some arguments.
fn functions() -> Digest {
    let of_one: [fn(f32) -> f32; 11] = [
        f32::sin,
        f32::cos,
        f32::tan,
        f32::asin,
        f32::acos,
        f32::atan,
        f32::exp,
        f32::exp2,
        f32::ln,
        f32::log2,
        f32::cbrt,
    ];
    let of_one_double: [fn(f64) -> f64; 8] =
        [f64::sin, f64::cos, f64::tan, f64::acos, f64::atan, f64::exp, f64::ln, f64::cbrt];
    let mut answers = Vec::new();
    for number in 1..=ARGUMENTS {
        // the compiler must not know them, or it calculates with a library of its own
        let x = black_box(number as f32 / (ARGUMENTS + 1) as f32);
        let y = black_box(1.0 + 3.0 * x);
        let [wide_x, wide_y] = [x, y].map(f64::from);
        answers.extend(of_one.iter().flat_map(|function| function(x).to_le_bytes()));
        answers.extend(of_one_double.iter().flat_map(|function| function(wide_x).to_le_bytes()));
        answers.extend([x.powf(y), x.atan2(y)].into_iter().flat_map(f32::to_le_bytes));
        answers.extend([wide_x.powf(wide_y), wide_x.atan2(wide_y)].into_iter().flat_map(f64::to_le_bytes));
    }
    Digest::new(&answers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_the_set_and_what_else_changes_answers() {
        let modern = ["sse2", "sse4.2", "avx", "avx2"];
        for (lanes, config, sets, expected) in [
            (16, "", &modern[..], "avx512"),
            (16, "threads=2,verbose=1", &modern, "avx512"),
            (8, "", &modern, "avx2"),
            (8, "isa=avx2", &modern, "avx2"),
            (8, "max_isa=avx2, threads=3", &modern, "avx2"),
            // one that it does not have is no more than it has
            (8, "max_isa=avx512", &modern, "avx2"),
            (8, "isa=avx", &modern, "avx"),
            (8, "", &modern[..3], "avx"),
            (4, "isa=sse2", &modern, "sse2"),
            (4, "isa=sse4.2", &modern, "sse4.2"),
            (4, "max_isa=avx2", &modern[..1], "sse2"),
            (16, "tri_accel=bvh4.triangle4v", &modern, "avx512 tri_accel=bvh4.triangle4v"),
        ] {
            assert_eq!(named(lanes, config, sets), expected, "{lanes} {config} {sets:?}");
        }
    }

    #[test]
    fn the_name_is_the_same_each_time() {
        for kind in [BackendKind::Embree, BackendKind::Rust] {
            assert_eq!(name(kind), name(kind));
        }
        assert!(name(BackendKind::Embree).starts_with(['a', 's']), "{}", name(BackendKind::Embree));
    }
}

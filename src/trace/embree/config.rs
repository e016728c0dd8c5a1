//! Settings of Embree's device.

use crate::trace::TraceError;

/// Environment variable with further settings of Embree's device, in Embree's syntax. `isa=avx2` makes any
/// processor one that has no packets of 16, for tests and measurements.
pub const CONFIG_VARIABLE: &str = "AFTERIMAGE_EMBREE_CONFIG";

/// Instruction sets that Embree knows. It takes any other word for the oldest of them.
const SETS: [&str; 12] =
    ["sse", "sse2", "sse3", "ssse3", "sse41", "sse4.1", "sse42", "sse4.2", "avx", "avxi", "avx2", "avx512"];

/// Settings that take an instruction set.
const OF_SETS: [&str; 3] = ["isa", "max_isa", "max_builder_isa"];

/// Other settings that Embree knows; it passes over those that it does not.
const NAMES: [&str; 21] = [
    "accel",
    "affinity",
    "benchmark",
    "builder",
    "cache_size",
    "enable_selockmemoryprivilege",
    "float_exceptions",
    "frequency_level",
    "hugepages",
    "max_spatial_split_replications",
    "max_triangles_per_leaf",
    "presplits",
    "quality",
    "scene_flags",
    "set_affinity",
    "start_threads",
    "tessellation_cache_size",
    "threads",
    "traverser",
    "user_threads",
    "verbose",
];

/// First words of names with several: `tri_accel`, `object_builder_mb`.
const FAMILIES: [&str; 12] = [
    "accel_",
    "alloc_",
    "builder_",
    "grid_",
    "hair_",
    "instancing_",
    "line_",
    "object_",
    "quad_",
    "subdiv_",
    "traverser_",
    "tri_",
];

/// Configuration of Embree's device: as many threads as rayon has, and the settings in [`CONFIG_VARIABLE`].
///
/// # Errors
/// As [`check_config`].
pub fn device_config() -> Result<String, TraceError> {
    let threads = format!("threads={}", rayon::current_num_threads());
    let more = check_config()?;
    Ok(if more.is_empty() { threads } else { format!("{threads},{more}") })
}

/// Settings in [`CONFIG_VARIABLE`].
///
/// # Errors
/// A setting that Embree would pass over without a word, or take for another one: frames of that run would be rounded otherwise
/// than whoever set it believes.
pub fn check_config() -> Result<String, TraceError> {
    let text = std::env::var_os(CONFIG_VARIABLE).unwrap_or_default().to_string_lossy().into_owned();
    let checked = settings(&text).try_for_each(check);
    checked.map(|()| text).map_err(|why| TraceError(format!("{CONFIG_VARIABLE}: {why}")))
}

/// Settings of a configuration: what stands between commas or spaces.
pub fn settings(config: &str) -> impl DoubleEndedIterator<Item = &str> {
    config.split([',', ' ']).map(str::trim).filter(|setting| !setting.is_empty())
}

fn check(setting: &str) -> Result<(), String> {
    let Some((name, value)) = setting.split_once('=').filter(|(_, value)| !value.is_empty()) else {
        return Err(format!(
            "`{setting}` is no setting: write NAME=VALUE without spaces, several with commas, such as isa=avx2,verbose=1"
        ));
    };
    if OF_SETS.contains(&name) {
        if SETS.contains(&value.to_lowercase().as_str()) {
            return Ok(());
        }
        return Err(format!(
            "`{setting}`: Embree has no code for instructions of this name: take one of {}",
            SETS.join(", ")
        ));
    }
    let is_known = |name: &str| {
        OF_SETS.contains(&name)
            || NAMES.contains(&name)
            || FAMILIES.iter().any(|family| name.starts_with(family))
    };
    if is_known(name) {
        return Ok(());
    }
    let small = name.to_lowercase();
    let remedy = if is_known(&small) { format!("write `{small}`") } else { String::from("see its name") };
    Err(format!("`{setting}`: Embree has no setting `{name}`, and would pass over it: {remedy}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_that_embree_would_pass_over_are_told() {
        let told = |config: &str| settings(config).try_for_each(check).err().unwrap_or_default();
        for config in [
            "",
            "isa=avx2",
            "isa=AVX2, max_isa=sse4.2",
            "threads=2,verbose=1 set_affinity=0",
            "tri_accel=bvh4.triangle4v,instancing_open_max=3,scene_flags=dynamic|robust",
        ] {
            assert_eq!(told(config), "", "{config}");
        }
        for (config, words) in [
            ("ISA=AVX2", "write `isa`"),
            ("threads=2,isa=avx3", "`isa=avx3`: Embree has no code for"),
            ("iza=avx2", "no setting `iza`"),
            ("isa = avx2", "`isa` is no setting"),
            ("isa=", "`isa=` is no setting"),
            ("avx2", "`avx2` is no setting"),
        ] {
            assert!(told(config).contains(words), "{config}: {}", told(config));
        }
    }
}

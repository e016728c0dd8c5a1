//! Our structs against those of the C compiler, read from the same headers.
#![allow(clippy::unwrap_used, reason = "tests")]

use embree4_sys::*;
use std::collections::BTreeMap;
use std::mem::offset_of;
use std::path::Path;
use std::process::Command;

/// Compiles `layout.c` as C or C++, runs it, and returns its lines.
fn ask_the_compiler(cpp: bool) -> BTreeMap<String, u64> {
    let folder = tempfile::tempdir().unwrap();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/layout.c");
    let program = folder.path().join("layout");
    // Outside of a build script `cc` has to be told what cargo would have.
    let host = env!("EMBREE4_TARGET");
    let compiler =
        cc::Build::new().cpp(cpp).target(host).host(host).opt_level(0).cargo_metadata(false).get_compiler();
    let status = Command::new(compiler.path())
        .args(["-x", if cpp { "c++" } else { "c" }, "-I", env!("EMBREE4_INCLUDE"), "-o"])
        .arg(&program)
        .arg(&source)
        .status()
        .unwrap();
    assert!(status.success(), "{} does not compile", source.display());
    let output = Command::new(&program).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let pair = |line: &str| line.split_once(' ').map(|(k, v)| (k.to_owned(), v.parse().unwrap()));
    text.lines().filter_map(pair).collect()
}

/// Writes the lines that `layout.c` prints, from the Rust side.
macro_rules! describe {
    ($($type:ident { $($field:ident),+ })+) => {{
        let mut lines = BTreeMap::new();
        $(
            lines.insert(stringify!($type).to_owned(), size_of::<$type>() as u64);
            $(lines.insert(
                concat!(stringify!($type), ".", stringify!($field)).to_owned(),
                offset_of!($type, $field) as u64,
            );)+
        )+
        lines
    }};
}

fn bindings() -> BTreeMap<String, u64> {
    let mut lines = describe! {
        RTCRay4 { org_x, org_y, org_z, tnear, dir_x, dir_y, dir_z, time, tfar, mask, id, flags }
        RTCHit4 { Ng_x, Ng_y, Ng_z, u, v, primID, geomID, instID, instPrimID }
        RTCRayHit4 { ray, hit }
        RTCRay8 { org_x, org_y, org_z, tnear, dir_x, dir_y, dir_z, time, tfar, mask, id, flags }
        RTCHit8 { Ng_x, Ng_y, Ng_z, u, v, primID, geomID, instID, instPrimID }
        RTCRayHit8 { ray, hit }
        RTCRay16 { org_x, org_y, org_z, tnear, dir_x, dir_y, dir_z, time, tfar, mask, id, flags }
        RTCHit16 { Ng_x, Ng_y, Ng_z, u, v, primID, geomID, instID, instPrimID }
        RTCRayHit16 { ray, hit }
        RTCIntersectArguments { flags, feature_mask, context, filter, intersect }
        RTCOccludedArguments { flags, feature_mask, context, filter, occluded }
        RTCRayQueryContext { instID, instPrimID }
        RTCFilterFunctionNArguments { valid, geometryUserPtr, context, ray, hit, N }
        RTCIntersectFunctionNArguments { valid, geometryUserPtr, primID, context, rayhit, N, geomID }
        RTCOccludedFunctionNArguments { valid, geometryUserPtr, primID, context, ray, N, geomID }
        RTCBoundsFunctionArguments { geometryUserPtr, primID, timeStep, bounds_o }
        RTCBounds { lower_x, lower_y, lower_z, upper_x, upper_y, upper_z }
    };
    let (intersect, occluded) = (init_intersect_arguments(), init_occluded_arguments());
    let context = init_ray_query_context();
    let set = intersect.filter.is_some() || intersect.intersect.is_some() || !intersect.context.is_null();
    let set_too = occluded.filter.is_some() || occluded.occluded.is_some() || !occluded.context.is_null();
    let numbers = [
        ("RTC_INVALID_GEOMETRY_ID", u64::from(RTC_INVALID_GEOMETRY_ID)),
        ("RTC_FEATURE_FLAG_ALL", u64::from(RTC_FEATURE_FLAG_ALL)),
        ("RTC_RAY_QUERY_FLAG_COHERENT", u64::from(RTC_RAY_QUERY_FLAG_COHERENT)),
        ("RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER", u64::from(RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER)),
        ("RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR", u64::from(RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR)),
        ("intersect.flags", u64::from(intersect.flags)),
        ("intersect.feature_mask", u64::from(intersect.feature_mask)),
        ("intersect.pointers", u64::from(set)),
        ("occluded.flags", u64::from(occluded.flags)),
        ("occluded.feature_mask", u64::from(occluded.feature_mask)),
        ("occluded.pointers", u64::from(set_too)),
        ("context.instID", u64::from(context.instID[0])),
        ("context.instPrimID", u64::from(context.instPrimID[0])),
    ];
    lines.extend(numbers.map(|(name, value)| (name.to_owned(), value)));
    lines
}

/// Value 2 of 3 in the rows that our callbacks read and write.
fn rows() -> BTreeMap<String, u64> {
    [
        ("RTCRayN_org_x", RTC_RAY_N_ORG_ROW),
        ("RTCRayN_org_y", RTC_RAY_N_ORG_ROW + 1),
        ("RTCRayN_org_z", RTC_RAY_N_ORG_ROW + 2),
        ("RTCRayN_tnear", RTC_RAY_N_TNEAR_ROW),
        ("RTCRayN_dir_x", RTC_RAY_N_DIR_ROW),
        ("RTCRayN_dir_y", RTC_RAY_N_DIR_ROW + 1),
        ("RTCRayN_dir_z", RTC_RAY_N_DIR_ROW + 2),
        ("RTCRayN_time", RTC_RAY_N_TIME_ROW),
        ("RTCRayN_tfar", RTC_RAY_N_TFAR_ROW),
        ("RTCRayN_mask", RTC_RAY_N_MASK_ROW),
        ("RTCRayN_id", RTC_RAY_N_ID_ROW),
        ("RTCHitN_Ng_x", RTC_HIT_N_NG_ROW),
        ("RTCHitN_Ng_y", RTC_HIT_N_NG_ROW + 1),
        ("RTCHitN_Ng_z", RTC_HIT_N_NG_ROW + 2),
        ("RTCHitN_u", RTC_HIT_N_U_ROW),
        ("RTCHitN_v", RTC_HIT_N_V_ROW),
        ("RTCHitN_primID", RTC_HIT_N_PRIM_ID_ROW),
        ("RTCHitN_geomID", RTC_HIT_N_GEOM_ID_ROW),
        ("RTCHitN_instID", RTC_HIT_N_INST_ID_ROW),
        ("RTCHitN_instPrimID", RTC_HIT_N_INST_PRIM_ID_ROW),
        // the value 0 of the first row of the hits behind the rays
        ("RTCRayHitN_HitN", RTC_RAY_N_ROWS),
    ]
    .map(|(name, row)| {
        let first = if name == "RTCRayHitN_HitN" { 0 } else { 2 };
        (name.to_owned(), (row * 3 + first) as u64)
    })
    .into()
}

#[test]
fn the_bindings_agree_with_c() {
    assert_eq!(bindings(), ask_the_compiler(false));
}

#[test]
fn the_bindings_agree_with_cpp_and_its_accessors() {
    let mut expected = bindings();
    expected.extend(rows());
    assert_eq!(expected, ask_the_compiler(true));
}

#[test]
fn alignment_is_that_of_packets() {
    assert_eq!([align_of::<RTCRay4>(), align_of::<RTCHit4>(), align_of::<RTCRayHit4>()], [16; 3]);
    assert_eq!([align_of::<RTCRay8>(), align_of::<RTCHit8>(), align_of::<RTCRayHit8>()], [32; 3]);
    assert_eq!([align_of::<RTCRay16>(), align_of::<RTCHit16>(), align_of::<RTCRayHit16>()], [64; 3]);
    assert_eq!(align_of::<RTCBounds>(), 16);
}

#[test]
fn the_library_loads_and_is_new_enough() {
    // SAFETY: null is the default configuration; the device is released once.
    let version = unsafe {
        let device = rtcNewDevice(std::ptr::null());
        assert!(!device.is_null());
        let version = rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION);
        rtcReleaseDevice(device);
        version
    };
    assert!(version >= 40300, "{version}");
}

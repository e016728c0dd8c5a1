//! Do the Rust structs lie in memory as the C compiler lays them out?

#![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

use openexr_sys::*;
use std::mem::offset_of;
use std::process::Command;

/// One row a struct or a field: the C expression and Rust's answer to it.
macro_rules! rows {
    ($($kind:ident { $($field:ident),* $(,)? })*) => {
        vec![$(
            (format!("sizeof({})", stringify!($kind)), size_of::<$kind>()),
            (format!("_Alignof({})", stringify!($kind)), align_of::<$kind>()),
            $((
                format!("offsetof({}, {})", stringify!($kind), stringify!($field)),
                offset_of!($kind, $field),
            ),)*
        )*]
    };
}

fn expected() -> Vec<(String, usize)> {
    rows! {
        exr_context_initializer_t {
            size, error_handler_fn, user_data, read_fn, size_fn, write_fn, destroy_fn,
            max_image_width, zip_level, dwa_quality, flags,
        }
        exr_coding_channel_info_t {
            channel_name, height, width, x_samples, p_linear, bytes_per_element, data_type,
            user_bytes_per_element, user_data_type, user_pixel_stride, user_line_stride,
        }
        exr_chunk_info_t { idx, start_y, height, width, type_, compression, packed_size, unpacked_size }
        exr_encode_pipeline_t {
            channels, channel_count, part_index, context, chunk, packed_buffer, packed_bytes,
            packed_alloc_size, compressed_buffer, compressed_bytes, compressed_alloc_size,
            convert_and_pack_fn, compress_fn, yield_until_ready_fn, write_fn, _quick_chan_store,
        }
        exr_decode_pipeline_t {
            channels, channel_count, part_index, context, chunk, decoding_user_data, read_fn,
            decompress_fn, unpack_and_convert_fn, _quick_chan_store,
        }
        exr_attr_chlist_t { num_channels, entries }
        exr_attr_chlist_entry_t { name, pixel_type, p_linear, x_sampling, y_sampling }
        exr_attr_box2i_t { min, max }
        exr_attribute_t { name, type_name, type_ }
    }
}

#[test]
fn rust_and_c_agree_on_sizes_and_offsets() {
    let rows = expected();
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("layout.c");
    let mut program = String::from("#include <openexr.h>\n#include <stddef.h>\n#include <stdio.h>\n");
    program += "int main(void) {\n";
    for (expression, _) in &rows {
        let expression = expression.replace("type_)", "type)"); // bindgen's name for C's `type`
        program += &format!("  printf(\"%zu\\n\", (size_t) {expression});\n");
    }
    program += "  return 0;\n}\n";
    std::fs::write(&source, program).unwrap();

    let binary = folder.path().join("layout");
    let host = format!("{}-unknown-{}-gnu", std::env::consts::ARCH, std::env::consts::OS);
    let compiler =
        cc::Build::new().host(&host).target(&host).opt_level(0).cargo_metadata(false).get_compiler();
    let mut compile: Command = compiler.to_command();
    for include in std::env::split_paths(env!("OPENEXR_INCLUDES")) {
        compile.arg("-I").arg(include);
    }
    let status = compile.arg(&source).arg("-o").arg(&binary).status().unwrap();
    assert!(status.success(), "the C compiler refused the layout program");

    let printed = String::from_utf8(Command::new(&binary).output().unwrap().stdout).unwrap();
    let answers: Vec<usize> = printed.lines().map(|line| line.parse().unwrap()).collect();
    assert_eq!(answers.len(), rows.len());
    for ((expression, in_rust), in_c) in rows.iter().zip(answers) {
        assert_eq!(*in_rust, in_c, "{expression}: Rust says {in_rust}, C says {in_c}");
    }
}

#[test]
fn the_initializer_asks_for_the_default_compression() {
    let initializer = context_initializer();
    assert_eq!(initializer.size, size_of::<exr_context_initializer_t>());
    assert_eq!(initializer.zip_level, -2, "0 would mean: do not compress");
    assert!(initializer.dwa_quality < 0.0);
}

#[test]
fn the_library_that_is_linked_is_the_one_of_the_headers() {
    let (mut major, mut minor, mut patch) = (0, 0, 0);
    // SAFETY: three valid places to write to; the fourth may be null.
    unsafe { exr_get_library_version(&mut major, &mut minor, &mut patch, std::ptr::null_mut()) };
    assert_eq!(major, 3);
    assert!(minor >= 1, "found {major}.{minor}.{patch}");
}

//! What was measured, as tables of plain text.

use crate::measure::{Jumps, Row};

/// The head of a subject's table of frames.
pub fn print_head(subject: &str, size: [u32; 2]) {
    println!("\n{subject}, {}x{}", size[0], size[1]);
    println!(
        "{:<9} {:>7} {:>5} {:>6}  {:>7} {:>6} {:>6}  {:>7} {:>7} {:>6}  {:>6} {:>6} {:>6}  {:>7}",
        "flow",
        "samples",
        "frame",
        "traced",
        "RMSE j",
        "inf/j",
        "cen/j",
        "cover",
        "centred",
        "j +-",
        "area",
        "centr.",
        "jitter",
        "flicker",
    );
}

/// A frame.
pub fn print_row(row: &Row) {
    let coverage = row.coverage.map_or_else(
        || format!("{:>7} {:>7} {:>6}", "-", "-", "-"),
        |coverage| {
            format!("{:>+7.2} {:>+7.2} {:>6.2}", coverage.inferred, coverage.centred, coverage.jittered)
        },
    );
    let [area, centred, jittered] = row.moved;
    println!(
        "{:<9} {:>7} {:>5} {:>6.1}  {:>7.5} {:>6.2} {:>6.2}  {coverage}  {area:>6.3} {centred:>6.3} {jittered:>6.3}  {:>7.2}",
        row.flow.name(),
        format!("{0}x{0}", row.samples),
        row.frame,
        100.0 * row.traced,
        row.jittered,
        row.inferred,
        row.centred,
        row.flicker,
    );
}

/// A subject's table of jumps at base frames.
pub fn print_jumps(all: &[Jumps]) {
    println!(
        "\n{:<9} {:>7}  {:>8} {:>8}  {:>8} {:>8}",
        "flow", "samples", "1 to 2", "/centred", "to base", "/centred"
    );
    for jumps in all {
        println!(
            "{:<9} {:>7}  {:>8.2} {:>8.2}  {:>8.2} {:>8.2}",
            jumps.flow.name(),
            format!("{0}x{0}", jumps.samples),
            jumps.first,
            jumps.over_centred[0],
            jumps.again,
            jumps.over_centred[1],
        );
    }
}

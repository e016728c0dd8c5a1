//! What was measured, as tables of plain text. docs/quality.md says what the columns are.

use crate::measure::{Jumps, Row};

/// Materials that are told by name.
const MOST_MATERIALS: usize = 12;

/// The head of a subject's table of frames.
pub fn print_head(subject: &str, [width, height]: [u32; 2]) {
    println!("\n{subject}, {width}x{height}");
    println!(
        "{:22} {:>7} |{:^22} |{:^22} |{:^22} |{:^14}",
        "", "traced", "RMSE", "covers too much, %", "area moved, %", "flicker"
    );
    println!(
        "{:<8} {:>7} {:>5} {:>7} | {:>7} {:>6} {:>6} | {:>7} {:>6} {:>6} | {:>7} {:>6} {:>6} | {:>6} {:>6}",
        "flow",
        "samples",
        "frame",
        "%",
        "jittrd",
        "inf/j",
        "cen/j",
        "inferrd",
        "centrd",
        "jittrd",
        "inferrd",
        "centrd",
        "jittrd",
        "/centr",
        "/jittr",
    );
}

/// A frame.
pub fn print_row(row: &Row) {
    let coverage = row.coverage.map_or_else(
        || format!("{:>7} {:>6} {:>6}", "-", "-", "-"),
        |coverage| {
            format!("{:>+7.2} {:>+6.2} {:>6.2}", coverage.inferred, coverage.centred, coverage.jittered)
        },
    );
    let ([moved, centred, jittered], [over_centred, over_jittered]) = (row.moved, row.flicker);
    println!(
        "{:<8} {:>7} {:>5} {:>7.1} | {:>7.5} {:>6.2} {:>6.2} | {coverage} | {moved:>7.3} {centred:>6.3} {jittered:>6.3} | {over_centred:>6.2} {over_jittered:>6.2}",
        row.flow.name(),
        pair(row.samples),
        row.frame,
        100.0 * row.traced,
        row.jittered,
        row.inferred,
        row.centred,
    );
}

/// The materials whose areas are furthest from the reference's in a frame, by `names`.
pub fn print_materials(row: &Row, names: &[String]) {
    let [inferred, centred, reference] = &row.areas;
    let gain = |areas: &[f64], number: usize| areas[number] - reference[number];
    let mut numbers: Vec<usize> = (0..names.len()).collect();
    numbers.sort_by(|a, b| gain(inferred, *b).abs().total_cmp(&gain(inferred, *a).abs()));
    println!("    {:<32} {:>10} {:>9} {:>9}", "material", "pixels", "inferrd %", "centrd %");
    for number in numbers.into_iter().take(MOST_MATERIALS).filter(|number| reference[*number] > 0.0) {
        let [inferred, centred] =
            [inferred, centred].map(|areas| 100.0 * gain(areas, number) / reference[number]);
        println!("    {:<32} {:>10.1} {inferred:>+9.2} {centred:>+9.2}", names[number], reference[number]);
    }
}

/// A subject's table of jumps at base frames.
pub fn print_jumps(all: &[Jumps]) {
    println!("\n{:16} |{:^17} |{:^17}", "error jumps", "base to inferred", "inferred to base");
    println!(
        "{:<8} {:>7} | {:>7} {:>8} | {:>7} {:>8}",
        "flow", "samples", "/next", "/centred", "/before", "/centred"
    );
    for jumps in all {
        println!(
            "{:<8} {:>7} | {:>7.2} {:>8.2} | {:>7.2} {:>8.2}",
            jumps.flow.name(),
            pair(jumps.samples),
            jumps.first,
            jumps.over_centred[0],
            jumps.again,
            jumps.over_centred[1],
        );
    }
}

fn pair(samples: u32) -> String {
    format!("{samples}x{samples}")
}

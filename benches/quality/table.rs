//! Tables of plain text. docs/quality.md explains their columns.

use crate::measure::{Pops, Row};

/// Materials listed for a frame.
const MOST_MATERIALS: usize = 12;

/// The head of a subject's table.
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

/// Prints one frame.
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

/// Prints the materials with the largest area errors.
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

/// Prints the largest figures of a subject over all flows and frames, by samples.
pub fn print_summary(rows: &[Row]) {
    println!(
        "\n{:<8} {:>8} {:>10} {:>14} {:>13}",
        "largest", "RMSE/j", "covers, %", "area moved/j", "flicker/j"
    );
    let mut counts: Vec<u32> = rows.iter().map(|row| row.samples).collect();
    counts.sort_unstable();
    counts.dedup();
    for samples in counts {
        let largest = |of: &dyn Fn(&Row) -> f64| {
            let values = rows.iter().filter(|row| row.samples == samples).map(of);
            values.max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(f64::NAN)
        };
        println!(
            "{:<8} {:>8.2} {:>+10.2} {:>14.2} {:>13.2}",
            pair(samples),
            largest(&|row| row.inferred),
            largest(&|row| row.coverage.map_or(f64::NAN, |coverage| coverage.inferred)),
            largest(&|row| row.moved[0] / row.moved[2]),
            largest(&|row| row.flicker[1]),
        );
    }
}

/// Prints a subject's pops.
pub fn print_pops(all: &[Pops]) {
    println!("\n{:16} |{:^17} |{:^17}", "pops", "base to inferred", "inferred to base");
    println!(
        "{:<8} {:>7} | {:>7} {:>8} | {:>7} {:>8}",
        "flow", "samples", "/next", "/centred", "/before", "/centred"
    );
    for pops in all {
        println!(
            "{:<8} {:>7} | {:>7.2} {:>8.2} | {:>7.2} {:>8.2}",
            pops.flow.name(),
            pair(pops.samples),
            pops.from_base,
            pops.over_centred[0],
            pops.to_base,
            pops.over_centred[1],
        );
    }
}

fn pair(samples: u32) -> String {
    format!("{samples}x{samples}")
}

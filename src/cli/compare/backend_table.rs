//! The table that `compare` prints of several tracers: a column for each tracer and mode.

use crate::cli::say::table;
use crate::report::backends::{AGREEMENT, BackendRun, RaySpeeds};
use crate::stats::Totals;

/// Width of a column, and of the titles beside.
const COLUMN: usize = 16;
const TITLE: usize = 24;

/// A row of the seconds.
type Seconds = fn(&Totals) -> f64;
/// A row of the speeds.
type Speed = fn(&RaySpeeds) -> Option<f64>;

/// The lines, below an empty one.
pub fn lines(runs: &[BackendRun]) -> Vec<String> {
    let full = |run: &BackendRun| run.totals.full.seconds.rendering();
    let mut lines = vec![String::new(), heading(runs)];
    let seconds: [(&str, Seconds); 6] = [
        ("seconds reproject", |totals| totals.seconds.reproject),
        ("seconds verify", |totals| totals.seconds.verify),
        ("seconds trace", |totals| totals.seconds.trace),
        ("seconds light", |totals| totals.seconds.light),
        ("seconds filter", |totals| totals.seconds.filter),
        ("seconds all", |totals| totals.seconds.rendering()),
    ];
    lines.extend(seconds.map(|(name, of)| row(name, runs, |_, totals, _| format!("{:.3} s", of(totals)))));
    lines.push(row("rays", runs, |_, totals, _| format!("{} M", table::millions(totals.rays.total()))));
    let speeds: [(&str, Speed); 4] = [
        ("Mray/s primary", |speeds| speeds.primary),
        ("Mray/s verification", |speeds| speeds.verification),
        ("Mray/s shadow", |speeds| speeds.shadow),
        ("Mray/s reflect, refract", |speeds| speeds.bounced),
    ];
    let number = |value: Option<f64>| value.map_or_else(|| String::from("-"), |value| format!("{value:.2}"));
    lines.extend(speeds.map(|(name, of)| row(name, runs, |_, _, speeds| number(of(speeds)))));
    let first = runs.first().map_or(0.0, full);
    lines.push(row("times as fast", runs, |_, totals, _| {
        let seconds = totals.seconds.rendering();
        if seconds > 0.0 { format!("{:.2}", first / seconds) } else { String::from("-") }
    }));
    lines.push(String::from(
        "Mray/s: million rays a second and thread, in the tracer alone; times as fast: as the first tracer in full",
    ));
    for run in runs {
        lines.push(format!(
            "{:<9}built in {:.2} s, {} of memory",
            run.backend,
            run.build_seconds,
            table::bytes(run.build_bytes)
        ));
        for (mode, agreement) in
            run.agreement.iter().flat_map(|both| ["reprojected", "full"].into_iter().zip(both))
        {
            lines.push(format!(
                "{:<9}{mode}: {} of {} pixels ({:.3} %) differ from the first tracer's by more than {AGREEMENT}",
                "",
                agreement.apart,
                agreement.pixels,
                agreement.percent_apart(),
            ));
        }
    }
    lines
}

fn heading(runs: &[BackendRun]) -> String {
    let mut line = " ".repeat(TITLE);
    for run in runs {
        for mode in ["", " full"] {
            line += &format!("{:>COLUMN$}", format!("{}{mode}", run.backend));
        }
    }
    line
}

/// A number for each tracer, reprojected and in full.
fn row(name: &str, runs: &[BackendRun], text: impl Fn(&BackendRun, &Totals, &RaySpeeds) -> String) -> String {
    let mut line = format!("{name:<TITLE$}");
    for run in runs {
        line += &format!("{:>COLUMN$}", text(run, &run.totals.reprojected, &run.speeds));
        line += &format!("{:>COLUMN$}", text(run, &run.totals.full, &run.full_speeds));
    }
    line
}

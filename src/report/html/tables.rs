//! Tables of the page: rays, seconds, errors, frames and tracers.

use super::grouped;
use crate::report::backends::AGREEMENT;
use crate::report::both_ways::THRESHOLD;
use crate::report::comparison::Comparison;
use crate::stats::{Saved, Seconds, Totals};

/// Reads a count from the totals of all frames.
type Count = fn(&Totals) -> u64;

/// Reads a phase from the seconds of frames.
type Phase = fn(&Seconds) -> f64;

/// Explanation of the column of savings.
const TIMES_AS_MUCH: &str = "Where reuse cost more than tracing in full, it is said how many times as much.";

/// Sums of rays, by kind.
pub fn rays_table(comparison: &Comparison) -> String {
    let kinds: [(&str, Count); 7] = [
        ("primary", |totals| totals.rays.primary),
        ("verification", |totals| totals.rays.verification),
        ("shadow", |totals| totals.rays.shadow),
        ("reflection", |totals| totals.rays.reflection),
        ("refraction", |totals| totals.rays.refraction),
        ("gathering", |totals| totals.rays.gathering),
        ("all", |totals| totals.rays.total()),
    ];
    let rows = kinds.map(|(name, count)| {
        let (ours, full) = (count(&comparison.totals.reprojected), count(&comparison.totals.full));
        two_sided(name, &grouped(ours), &grouped(full), (ours as f64, full as f64))
    });
    format!(
        "<h2>Rays by kind</h2><p class=\"note\">Sums over all frames, base frames too. A verification ray checks \
         that the eye still sees a sample that was carried over: full tracing has none. {TIMES_AS_MUCH}</p>{}",
        table("<th>rays</th><th>reprojected</th><th>full</th><th>saved</th>", &rows)
    )
}

/// Sums of seconds, by phase.
pub fn phases_table(comparison: &Comparison) -> String {
    let phases: [(&str, Phase); 6] = [
        ("reproject", |seconds| seconds.reproject),
        ("verify", |seconds| seconds.verify),
        ("trace", |seconds| seconds.trace),
        ("light", |seconds| seconds.light),
        ("filter", |seconds| seconds.filter),
        ("all", Seconds::rendering),
    ];
    let (ours, full) = (comparison.totals.reprojected.seconds, comparison.totals.full.seconds);
    let rows = phases.map(|(name, phase)| {
        let (ours, full) = (phase(&ours), phase(&full));
        two_sided(name, &format!("{ours:.3}"), &format!("{full:.3}"), (ours, full))
    });
    format!(
        "<h2>Seconds by phase</h2><p class=\"note\">Sums over all frames. “all” is the time of the frames with what \
         is in no phase; writing files ({:.2} s) and building the scene ({:.2} s) are not in it. {TIMES_AS_MUCH}</p>{}",
        ours.write + full.write,
        comparison.build_seconds,
        table("<th>seconds</th><th>reprojected</th><th>full</th><th>saved</th>", &rows)
    )
}

fn two_sided(name: &str, ours: &str, full: &str, values: (f64, f64)) -> String {
    let saved = or_dash(Saved::of(values.0, values.1));
    let class = if name == "all" { " class=\"sum\"" } else { "" };
    format!("<tr{class}><td>{name}</td><td>{ours}</td><td>{full}</td><td>{saved}</td></tr>")
}

/// Formats a saving; a dash if there is nothing to compare with.
fn or_dash(saved: Option<Saved>) -> String {
    saved.map_or_else(|| String::from("–"), |saved| saved.to_string())
}

/// Table of errors, if the pictures were compared with a reference.
pub fn errors_table(comparison: &Comparison) -> String {
    let Some(reference) = &comparison.reference else {
        return String::new();
    };
    let or_dash = |value: Option<f64>| value.map_or_else(|| String::from("–"), |value| format!("{value:.2}"));
    let rows = [("all frames", &reference.all), ("inferred frames", &reference.inferred)].map(|(name, totals)| {
        let (ours, full) = (totals.errors.reprojected, totals.errors.full);
        format!(
            "<tr><td>{name}: {}</td><td>{:.5}</td><td>{:.5}</td><td>{}</td><td>{}</td><td>{:.5}</td><td>{:.5}</td></tr>",
            totals.frames,
            ours.display,
            full.display,
            or_dash(totals.ratio),
            or_dash(totals.speed_up_at_equal_error),
            ours.linear,
            full.linear,
        )
    });
    format!(
        "<h2>Error</h2><p class=\"note\">Root mean square error of linear R, G and B, clamped to 0 to 1 as a display \
         shows them, against the same frames with {n}×{n} samples a pixel. Samples of inferred frames lie elsewhere in \
         their cells than those of full ones. “at equal error” is how many times as fast reprojection is where both \
         ways take the samples that the same error needs: time goes with error squared × seconds.</p>{}",
        table(
            "<th>error</th><th>reprojected</th><th>full</th><th>ratio</th><th>at equal error</th>\
             <th>not clamped</th><th>full</th>",
            &rows
        ),
        n = reference.samples,
    )
}

/// A row for each frame.
pub fn frames_table(comparison: &Comparison) -> String {
    let rows: Vec<String> = (comparison.frames.iter())
        .map(|frame| {
            let (ours, full) = (&frame.reprojected, &frame.full);
            let audit = ours.audit.map_or_else(|| String::from("–"), |audit| audit.wrong().to_string());
            let apart = match frame.error {
                Some(error) => [error.reprojected, error.full].map(|error| format!("{:.5}", error.display)),
                None => [
                    format!("{:.5}", frame.difference.mean),
                    format!("{:.2} %", frame.difference.percent_above),
                ],
            };
            format!(
                "<tr><td>{}</td><td>{}</td><td>{:.1} %</td><td>{:.3}</td><td>{:.3}</td><td>{:.2}</td>\
                 <td>{:.2}</td><td>{}</td><td>{}</td><td>{}</td><td>{audit}</td></tr>",
                frame.frame,
                ours.mode,
                100.0 * ours.samples.reused() as f64 / ours.samples.total().max(1) as f64,
                ours.seconds.rendering(),
                full.seconds.rendering(),
                ours.rays.total() as f64 / 1e6,
                full.rays.total() as f64 / 1e6,
                or_dash(Saved::of(ours.rays.total() as f64, full.rays.total() as f64)),
                apart[0],
                apart[1],
            )
        })
        .collect();
    let (what, titles) = match &comparison.reference {
        Some(_) => (String::from("The error is that of the table above."), "<th>error</th><th>full</th>"),
        None => (
            format!(
                "The difference of the two pictures is the mean over R, G, B (linear), and the percent of pixels of which \
                 any differs by more than {THRESHOLD}. It is noise, that of both ways together: their samples lie elsewhere \
                 in the pixels, and light comes along other paths."
            ),
            "<th>difference</th><th>pixels</th>",
        ),
    };
    format!(
        "<h2>Every frame</h2><p class=\"note\">Seconds without writing, rays in millions. {what} The audit tells whether any \
         sample is wrong.</p><details open><summary>{} frames</summary>{}</details>",
        comparison.frames.len(),
        table(
            &format!(
                "<th>frame</th><th>mode</th><th>reused</th><th>seconds</th><th>full</th><th>rays</th><th>full</th>\
                 <th>rays saved</th>{titles}<th>audit</th>"
            ),
            &rows
        )
    )
}

/// Table of the tracers' measurements; empty with only one.
pub fn backends_table(comparison: &Comparison) -> String {
    if comparison.backends.len() < 2 {
        return String::new();
    }
    let speed = |speed: Option<f64>| speed.map_or_else(|| String::from("–"), |speed| format!("{speed:.2}"));
    let first = comparison.backends[0].totals.full.seconds.rendering();
    let mut rows = Vec::new();
    for run in &comparison.backends {
        let apart = |mode: usize| {
            let agreement = run.agreement.map(|both| format!("{:.3} %", both[mode].percent_apart()));
            agreement.unwrap_or_else(|| String::from("–"))
        };
        let ways = [
            ("reprojected", &run.totals.reprojected, &run.speeds),
            ("full", &run.totals.full, &run.full_speeds),
        ];
        for (mode, (way, totals, speeds)) in ways.into_iter().enumerate() {
            let seconds = totals.seconds.rendering();
            rows.push(format!(
                "<tr><td>{} {way}</td><td>{:.2}</td><td>{:.0}</td><td>{seconds:.3}</td><td>{:.2}</td><td>{}</td><td>{}</td>\
                 <td>{}</td><td>{}</td><td>{}</td></tr>",
                run.backend,
                run.build_seconds,
                run.build_bytes as f64 / f64::from(1 << 20),
                if seconds > 0.0 { first / seconds } else { 1.0 },
                speed(speeds.primary),
                speed(speeds.verification),
                speed(speeds.shadow),
                speed(speeds.bounced),
                apart(mode),
            ));
        }
    }
    format!(
        "<h2>Tracers</h2><p class=\"note\">The same frames by each tracer; everything above is of the first. Seconds to \
         build the scene once and MiB that this took; seconds of all frames, and how many times as fast that is as \
         the first tracer in full. Million rays a second of one thread while it is in the tracer. Last the pixels \
         that differ from the first tracer's by more than {AGREEMENT}: at edges, where rounding decides.</p>{}",
        table(
            "<th>tracer</th><th>build</th><th>MiB</th><th>seconds</th><th>times as fast</th><th>primary</th>\
             <th>verification</th><th>shadow</th><th>reflection, refraction</th><th>pixels apart</th>",
            &rows
        )
    )
}

/// Formats a table. It scrolls in its own box if the page is too narrow for it; the first column stays.
fn table(titles: &str, rows: &[String]) -> String {
    format!("<div class=\"scroll\"><table><tr>{titles}</tr>{}</table></div>", rows.concat())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::both_ways::tests::frame;
    use crate::report::comparison::tests::comparison;

    #[test]
    fn what_took_much_longer_is_a_factor_and_no_percentage() {
        let mut slow = frame(2, 90);
        slow.reprojected.seconds.total = 2.1;
        (slow.reprojected.seconds.reproject, slow.full.seconds.reproject) = (0.05, 0.02);
        (slow.reprojected.seconds.filter, slow.full.seconds.filter) = (0.03, 0.02);
        let comparison = comparison(vec![slow]);
        let html = phases_table(&comparison);
        for row in [
            "<td>reproject</td><td>0.050</td><td>0.020</td><td>2.5×</td>",
            "<td>verify</td><td>0.000</td><td>0.000</td><td>–</td>",
            "<td>filter</td><td>0.030</td><td>0.020</td><td>-50.0 %</td>",
            "<td>all</td><td>2.000</td><td>0.400</td><td>5.0×</td>",
        ] {
            assert!(html.contains(row), "{row} is not in {html}");
        }
    }
}

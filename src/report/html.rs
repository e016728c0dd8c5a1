//! The comparison as one HTML page that needs nothing but itself.

use std::fmt::Write;

use super::backends::AGREEMENT;
use super::both_ways::THRESHOLD;
use super::chart::{self, Series};
use super::comparison::Comparison;
use super::picture::{STATUSES, hex};
use crate::stats::{FrameStats, Percent, SampleCounts, Seconds, Totals, saved_percent};
use crate::visible::visible;

/// Colours of the two ways in line charts.
const OURS: &str = "#2ea44f";
const FULL: &str = "#8b6fd6";

/// One row of the table of rays.
type Count = fn(&Totals) -> u64;
/// One row of the table of seconds.
type Phase = fn(&Seconds) -> f64;

/// One frame to look at; each a `data:` URI.
pub struct Pictures {
    /// The frame's number.
    pub frame: i32,
    /// Made by reprojection.
    pub reprojected: String,
    /// Where its samples came from, in the colours of the statuses.
    pub statuses: Option<String>,
    /// Traced in full.
    pub full: String,
}

/// The whole page.
pub fn page(comparison: &Comparison, pictures: &[Pictures]) -> String {
    let parts = [
        head(comparison),
        cards(comparison),
        sight(pictures),
        charts(comparison),
        rays_table(comparison),
        phases_table(comparison),
        errors_table(comparison),
        frames_table(comparison),
        backends_table(comparison),
        colophon(comparison),
    ];
    let title = escaped(&comparison.title);
    let style = include_str!("style.css");
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width\"><title>{title} · Afterimage</title>\
         <style>\n{style}</style></head>\n<body><main>\n{}\n</main></body></html>\n",
        parts.join("\n")
    )
}

fn head(comparison: &Comparison) -> String {
    let picture = &comparison.settings.picture;
    let frames = comparison.frames.len();
    format!(
        "<h1>{}</h1><p class=\"sub\">{} frames at {}×{}, {n}×{n} samples a pixel, {} threads. Each frame was made \
         twice in one run, in turns: from the samples of the frame before, and traced from nothing.</p>",
        escaped(&comparison.title),
        frames,
        picture.width,
        picture.height,
        comparison.settings.threads,
        n = picture.samples,
    )
}

fn cards(comparison: &Comparison) -> String {
    let saved = &comparison.saved;
    let inferred = &comparison.saved_inferred;
    let card = |class: &str, number: String, text: String| {
        format!("<div class=\"card{class}\"><b>{number}</b><span>{text}</span></div>")
    };
    let mut cards = vec![
        card(
            "",
            format!("{} %", Percent(saved.rays_percent)),
            format!("of all rays saved ({} % on inferred frames)", Percent(inferred.rays_percent)),
        ),
        card(
            "",
            format!("{} %", Percent(saved.time_percent)),
            format!("of the time saved ({} % on inferred frames)", Percent(inferred.time_percent)),
        ),
        card(
            "",
            format!("{:.2}×", saved.speed_up),
            format!("as fast ({:.2}× on inferred frames), without writing files", inferred.speed_up),
        ),
    ];
    if let Some(audit) = comparison.totals.reprojected.audit {
        let class = if audit.differing == 0 { "" } else { " bad" };
        cards.push(card(
            class,
            audit.differing.to_string(),
            format!("of {} samples differ when traced again (audit)", grouped(audit.checked)),
        ));
    }
    format!("<div class=\"cards\">{}</div>", cards.concat())
}

fn sight(pictures: &[Pictures]) -> String {
    if pictures.is_empty() {
        return String::new();
    }
    let mut html = String::from(
        "<h2>What it looks like</h2><p class=\"note\">Left the frame made by reprojection, in the middle where \
         its samples came from, right the same frame traced in full.</p>",
    );
    for picture in pictures {
        let frame = picture.frame;
        let figure = |uri: &str, text: &str| {
            format!(
                "<figure><img src=\"{uri}\" alt=\"\"><figcaption>Frame {frame}, {text}</figcaption></figure>"
            )
        };
        let statuses = picture.statuses.as_deref().map(|uri| figure(uri, "status of its samples"));
        let _ = write!(
            html,
            "<div class=\"three\">{}{}{}</div>",
            figure(&picture.reprojected, "reprojected"),
            statuses.unwrap_or_default(),
            figure(&picture.full, "traced in full")
        );
    }
    html.push_str("<dl>");
    for status in &STATUSES {
        let (color, name, meaning) = (hex(status.color), status.name, status.meaning);
        let _ = write!(html, "<dt><i style=\"background:{color}\"></i>{name}</dt><dd>{meaning}</dd>");
    }
    html.push_str("</dl>");
    html
}

fn charts(comparison: &Comparison) -> String {
    let numbers: Vec<i32> = comparison.frames.iter().map(|frame| frame.frame).collect();
    let counts: [fn(&SampleCounts) -> u64; 5] =
        [|s| s.base, |s| s.good, |s| s.overlapped, |s| s.missed, |s| s.obscured];
    let statuses: Vec<Series> = (STATUSES.iter().zip(counts))
        .map(|(status, count)| Series {
            name: status.name,
            color: hex(status.color),
            values: (comparison.frames.iter())
                .map(|frame| {
                    let samples = &frame.reprojected.samples;
                    100.0 * count(samples) as f64 / samples.total().max(1) as f64
                })
                .collect(),
        })
        .collect();
    let both = |value: fn(&FrameStats) -> f64| {
        let ours = comparison.frames.iter().map(|frame| value(&frame.reprojected)).collect();
        let full = comparison.frames.iter().map(|frame| value(&frame.full)).collect();
        [
            Series { name: "reprojected", color: OURS.into(), values: ours },
            Series { name: "traced in full", color: FULL.into(), values: full },
        ]
    };
    format!(
        "<h2>Where samples come from</h2><p class=\"note\">Percent of each frame's samples, by status.</p>\
         <div class=\"chart\">{}</div>\
         <h2>Seconds a frame</h2><p class=\"note\">Wall-clock time, without writing files.</p>\
         <div class=\"chart\">{}</div>\
         <h2>Rays a frame</h2><p class=\"note\">Millions, of every kind; what verification costs is among \
         them.</p><div class=\"chart\">{}</div>",
        chart::stacked_bars(&numbers, &statuses, " %"),
        chart::lines(&numbers, &both(|frame| frame.seconds.rendering()), " s"),
        chart::lines(&numbers, &both(|frame| frame.rays.total() as f64 / 1e6), " M"),
    )
}

fn rays_table(comparison: &Comparison) -> String {
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
         that the eye still sees a sample that was carried over: full tracing has none.</p>{}",
        table("<th>rays</th><th>reprojected</th><th>full</th><th>saved</th>", &rows)
    )
}

fn phases_table(comparison: &Comparison) -> String {
    let phases: [(&str, Phase); 6] = [
        ("reproject", |seconds| seconds.reproject),
        ("verify", |seconds| seconds.verify),
        ("trace", |seconds| seconds.trace),
        ("enhance", |seconds| seconds.enhance),
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
         is in no phase; writing files ({:.2} s) and building the scene ({:.2} s) are not in it.</p>{}",
        ours.write + full.write,
        comparison.build_seconds,
        table("<th>seconds</th><th>reprojected</th><th>full</th><th>saved</th>", &rows)
    )
}

fn two_sided(name: &str, ours: &str, full: &str, values: (f64, f64)) -> String {
    let saved = match values {
        (_, full) if full > 0.0 => format!("{} %", Percent(saved_percent(values.0, full))),
        _ => String::from("–"),
    };
    let class = if name == "all" { " class=\"sum\"" } else { "" };
    format!("<tr{class}><td>{name}</td><td>{ours}</td><td>{full}</td><td>{saved}</td></tr>")
}

/// Where the pictures were compared with a reference.
fn errors_table(comparison: &Comparison) -> String {
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

fn frames_table(comparison: &Comparison) -> String {
    let rows: Vec<String> = (comparison.frames.iter())
        .map(|frame| {
            let (ours, full) = (&frame.reprojected, &frame.full);
            let audit = ours.audit.map_or_else(|| String::from("–"), |audit| audit.differing.to_string());
            format!(
                "<tr><td>{}</td><td>{}</td><td>{:.1} %</td><td>{:.3}</td><td>{:.3}</td><td>{:.2}</td>\
                 <td>{:.2}</td><td>{} %</td><td>{:.5}</td><td>{:.2} %</td><td>{audit}</td></tr>",
                frame.frame,
                ours.mode,
                100.0 * ours.samples.reused() as f64 / ours.samples.total().max(1) as f64,
                ours.seconds.rendering(),
                full.seconds.rendering(),
                ours.rays.total() as f64 / 1e6,
                full.rays.total() as f64 / 1e6,
                Percent(saved_percent(ours.rays.total() as f64, full.rays.total() as f64)),
                frame.difference.mean,
                frame.difference.percent_above,
            )
        })
        .collect();
    format!(
        "<h2>Every frame</h2><p class=\"note\">Seconds without writing, rays in millions. The difference of the two \
         pictures is the mean over R, G, B (linear), and the percent of pixels of which any differs by more \
         than {THRESHOLD}. Edges differ, because a sample that was carried over lies elsewhere in its cell than a \
         new one; the audit tells whether any sample is wrong.</p><details open><summary>{} frames</summary>{}</details>",
        comparison.frames.len(),
        table(
            "<th>frame</th><th>mode</th><th>reused</th><th>seconds</th><th>full</th><th>rays</th><th>full</th>\
             <th>rays saved</th><th>difference</th><th>pixels</th><th>audit</th>",
            &rows
        )
    )
}

/// What the tracers were measured at; nothing where there is but one.
fn backends_table(comparison: &Comparison) -> String {
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

fn colophon(comparison: &Comparison) -> String {
    let versions = &comparison.versions;
    let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    format!(
        "<h2>How it was made</h2><dl><dt>command</dt><dd><code>{}</code></dd><dt>shot</dt><dd><code>{}</code></dd>\
         <dt>afterimage</dt><dd>{}</dd><dt>Embree</dt><dd>{}</dd><dt>OpenEXR</dt><dd>{}</dd>\
         <dt>machine</dt><dd>{}, {} threads</dd><dt>memory</dt><dd>{:.0} MiB at most with both renderers; sample \
         store {:.0} MiB, {:.1} bytes a sample</dd></dl>",
        escaped(&comparison.command),
        escaped(&comparison.shot),
        escaped(versions.afterimage),
        escaped(&versions.embree),
        escaped(&versions.openexr),
        escaped(&versions.cpu),
        comparison.settings.threads,
        mib(comparison.memory.peak_bytes),
        mib(comparison.memory.store_bytes),
        comparison.memory.bytes_per_sample,
    )
}

fn table(titles: &str, rows: &[String]) -> String {
    format!("<div class=\"scroll\"><table><tr>{titles}</tr>{}</table></div>", rows.concat())
}

/// `12 345 678`, with spaces that do not break.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i) % 3 == 0 {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

fn escaped(text: &str) -> String {
    visible(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::both_ways::tests::frame;
    use crate::report::comparison::tests::comparison;

    fn made() -> String {
        let pictures = Pictures {
            frame: 2,
            reprojected: "data:a".into(),
            statuses: Some("data:b".into()),
            full: "data:c".into(),
        };
        page(&comparison(vec![frame(1, 0), frame(2, 90)]), &[pictures])
    }

    #[test]
    fn the_page_needs_nothing_but_itself() {
        let page = made();
        for foreign in ["http:", "https:", "<script", "<link", "@import", "url("] {
            assert!(!page.contains(foreign), "{foreign}");
        }
        assert_eq!(page.matches("<img").count(), 3);
    }

    #[test]
    fn text_from_outside_is_escaped() {
        let page = made();
        assert!(page.contains("A city &amp; a blimp") && page.contains("city &lt;1&gt;.toml"));
        assert!(!page.contains("city <1>"));
    }

    #[test]
    fn every_element_that_opens_closes() {
        let page = made();
        for element in ["div", "table", "tr", "td", "svg", "figure", "dl", "g", "p", "details", "main"] {
            let opened =
                page.matches(&format!("<{element}>")).count() + page.matches(&format!("<{element} ")).count();
            assert_eq!(opened, page.matches(&format!("</{element}>")).count(), "{element}");
        }
    }

    #[test]
    fn numbers_are_grouped_by_thousands() {
        assert_eq!(grouped(0), "0");
        assert_eq!(grouped(1_234_567), "1\u{202f}234\u{202f}567");
    }

    #[test]
    fn a_comparison_without_frames_is_a_page_too() {
        assert!(page(&comparison(vec![]), &[]).contains("0 frames"));
    }
}

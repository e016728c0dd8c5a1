//! The comparison as one HTML page that needs nothing but itself.

mod pictures;
mod tables;

use super::chart::{self, Series};
use super::comparison::Comparison;
use super::picture::{STATUSES, hex};
use crate::stats::{FrameStats, SampleCounts, Saved};
use crate::visible::visible;

pub use pictures::{Maps, Pictures};

/// Colours of the two ways in line charts.
const OURS: &str = "#2ea44f";
const FULL: &str = "#8b6fd6";

/// The whole page.
pub fn page(comparison: &Comparison, pictures: &[Pictures]) -> String {
    let parts = [
        head(comparison),
        cards(comparison),
        pictures::section(comparison, pictures),
        charts(comparison),
        tables::rays_table(comparison),
        tables::phases_table(comparison),
        tables::errors_table(comparison),
        tables::frames_table(comparison),
        tables::backends_table(comparison),
        colophon(comparison),
    ];
    let title = escaped(&comparison.title);
    let style = include_str!("style.css");
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><title>{title} · Afterimage</title>\
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
        saved_card(
            card,
            "of all rays saved",
            "as many rays as full tracing",
            [saved.rays_percent, inferred.rays_percent],
        ),
        saved_card(
            card,
            "of the time saved",
            "the time of full tracing",
            [saved.time_percent, inferred.time_percent],
        ),
        card(
            "",
            format!("{:.2}×", saved.speed_up),
            format!("as fast ({:.2}× on inferred frames), without writing files", inferred.speed_up),
        ),
    ];
    if let Some(audit) = comparison.totals.reprojected.audit {
        let class = |count: u64| if count == 0 { "" } else { " bad" };
        cards.push(card(
            class(audit.differing),
            audit.differing.to_string(),
            format!("of {} samples differ when traced again (audit)", grouped(audit.checked)),
        ));
        // the paper's rule asks no target
        if audit.targets > 0 {
            cards.push(card(
                class(audit.coverage),
                audit.coverage.to_string(),
                String::from("cells show another surface than their targets see (audit)"),
            ));
        }
    }
    format!("<div class=\"cards\">{}</div>", cards.concat())
}

/// Card of the saving in all frames and in inferred ones. Its text is `saved_of`, or `times` if reuse took
/// more instead of less.
fn saved_card(
    card: impl Fn(&str, String, String) -> String,
    saved_of: &str,
    times: &str,
    percent: [f64; 2],
) -> String {
    let [all, inferred] = percent.map(Saved::of_percent);
    let text = if let Saved::Times(_) = all { times } else { saved_of };
    card("", all.to_string(), format!("{text} (inferred frames: {inferred})"))
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
            full: "data:b".into(),
            is_denoised: false,
            maps: Maps::Difference("data:c".into()),
            statuses: Some("data:d".into()),
        };
        page(&comparison(vec![frame(1, 0), frame(2, 90)]), &[pictures])
    }

    #[test]
    fn the_page_needs_nothing_but_itself() {
        let page = made();
        for foreign in ["http:", "https:", "<script", "<link", "@import", "url("] {
            assert!(!page.contains(foreign), "{foreign}");
        }
        assert_eq!(page.matches("<img").count(), 4);
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
        for element in [
            "div", "table", "tr", "td", "svg", "figure", "dl", "dd", "g", "p", "span", "h3", "details",
            "main",
        ] {
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
    fn the_page_has_no_percentage_below_minus_100_and_no_minus_zero() {
        let (mut even, mut slow) = (frame(2, 90), frame(3, 90));
        even.reprojected.rays = even.full.rays;
        even.reprojected.rays.shadow += 1;
        even.reprojected.rays.primary *= 10_000;
        even.full.rays.primary *= 10_000;
        slow.reprojected.rays.primary = 3_000_000;
        slow.reprojected.seconds.total = 9.0;
        for frames in [vec![even.clone()], vec![slow.clone()], vec![frame(1, 0), even, slow]] {
            let page = page(&comparison(frames), &[]);
            let percentages = page.match_indices(" %").map(|(end, _)| {
                let start = page[..end].rfind(|c: char| !"-.0123456789".contains(c)).map_or(0, |at| at + 1);
                &page[start..end]
            });
            for text in percentages.filter(|text| text.starts_with('-')) {
                let value: f64 = text.parse().expect("a number");
                assert!((-100.0..0.0).contains(&value), "{text} %");
            }
        }
    }

    #[test]
    fn a_slower_way_is_told_as_a_factor() {
        let mut slow = frame(2, 90);
        (slow.reprojected.seconds.total, slow.reprojected.rays.primary) = (1.3, 410);
        let page = page(&comparison(vec![slow]), &[]);
        assert!(page.contains("<b>3.0×</b><span>the time of full tracing (inferred frames: 3.0×)"), "{page}");
        assert!(page.contains("<b>2.5×</b><span>as many rays as full tracing"), "{page}");
        assert!(page.contains("<b>0.33×</b><span>as fast"), "{page}");
    }

    #[test]
    fn text_is_no_smaller_than_14_pixels() {
        let style = include_str!("style.css");
        let sizes = style.match_indices("px").filter_map(|(end, _)| {
            let start = style[..end].rfind(|c: char| !c.is_ascii_digit() && c != '.').map_or(0, |at| at + 1);
            let before = style[..start].trim_end();
            (before.ends_with("font-size:") || before.ends_with("font:")).then(|| &style[start..end])
        });
        let sizes: Vec<f64> = sizes.map(|text| text.parse().expect("a number")).collect();
        assert!(sizes.len() > 5 && sizes.iter().all(|size| *size >= 14.0), "{sizes:?}");
    }

    #[test]
    fn a_comparison_without_frames_is_a_page_too() {
        assert!(page(&comparison(vec![]), &[]).contains("0 frames"));
    }
}

//! The table that `compare` prints of frames that were made in both ways.

use super::{backend_table, reference};
use crate::cli::say::table;
use crate::cli::say::terminal::duration;
use crate::report::both_ways::{ComparedFrame, Difference, Saving};
use crate::report::comparison::Comparison;
use crate::stats::{Percent, Saved, saved_percent};

/// Titles of the columns: those of errors where there is a reference, and of differences where there is none. With two eyes each frame has two rows.
pub fn header(has_two_eyes: bool, has_errors: bool) -> String {
    let eye = if has_two_eyes { " eye  " } else { "" };
    let apart = if has_errors { reference::TITLES } else { " difference >0.02%" };
    format!("frame{eye} mode      seconds    full speed-up rays M  full saved% reused%{apart} audit")
}

/// Formats both ways of a frame.
pub fn row(frame: &ComparedFrame) -> String {
    let (ours, full) = (&frame.reprojected, &frame.full);
    let seconds = (ours.seconds.rendering(), full.seconds.rendering());
    let speed_up = if seconds.0 > 0.0 { seconds.1 / seconds.0 } else { 1.0 };
    format!(
        "{:>5}{} {:<9} {:>7.3} {:>7.3} {:>8.2} {:>6} {:>5} {:>6} {:>7.1}{} {}",
        frame.frame,
        table::eye(ours),
        ours.mode,
        seconds.0,
        seconds.1,
        speed_up,
        table::short_millions(ours.rays.total()),
        table::short_millions(full.rays.total()),
        Percent(saved_percent(ours.rays.total() as f64, full.rays.total() as f64)),
        table::reused_percent(ours),
        frame.error.map_or_else(|| apart(&frame.difference), |error| reference::columns(&error)),
        table::audit(ours.audit),
    )
}

/// Formats the difference between both pictures, for lack of a reference that would tell the error of each.
fn apart(difference: &Difference) -> String {
    format!(" {:>10.5} {:>6.2}", difference.mean, difference.percent_above)
}

/// Formats the totals of all frames.
pub fn summary(comparison: &Comparison) -> String {
    let (ours, full) = (&comparison.totals.reprojected, &comparison.totals.full);
    let mut lines =
        vec![String::new(), format!("{:<14}{:>13}{:>13}{:>9}", "", "reprojected", "full", "saved")];
    let rays = |name, ours: u64, full: u64| {
        let saved = percent_or_dash(ours as f64, full as f64);
        format!("{name:<14}{:>11} M{:>11} M{saved:>9}", table::millions(ours), table::millions(full))
    };
    lines.extend([
        rays("primary", ours.rays.primary, full.rays.primary),
        rays("verification", ours.rays.verification, full.rays.verification),
        rays("shadow", ours.rays.shadow, full.rays.shadow),
        rays("reflection", ours.rays.reflection, full.rays.reflection),
        rays("refraction", ours.rays.refraction, full.rays.refraction),
        rays("gathering", ours.rays.gathering, full.rays.gathering),
        rays("all rays", ours.rays.total(), full.rays.total()),
    ]);
    let seconds = |name, ours: f64, full: f64| {
        format!("{name:<14}{ours:>11.3} s{full:>11.3} s{:>9}", percent_or_dash(ours, full))
    };
    lines.extend([
        seconds("reproject", ours.seconds.reproject, full.seconds.reproject),
        seconds("verify", ours.seconds.verify, full.seconds.verify),
        seconds("trace", ours.seconds.trace, full.seconds.trace),
        seconds("light", ours.seconds.light, full.seconds.light),
        seconds("filter", ours.seconds.filter, full.seconds.filter),
        seconds("all seconds", ours.seconds.rendering(), full.seconds.rendering()),
        String::new(),
        saving("all frames", &comparison.saved),
        saving("inferred", &comparison.saved_inferred),
    ]);
    if let Some(eyes) = &comparison.eyes {
        lines.push(saving("right eye", &eyes.saved_right));
        lines.push(table::eyes_line(&eyes.reprojected));
    }
    lines.extend(reference::lines(comparison.reference.as_ref()));
    lines.extend(ours.audit.map(table::audit_line));
    lines.push(table::memory_line(&comparison.memory) + " (peak: all renderers)");
    lines.push(format!(
        "{:<9}in no sum above:{} writing {}, building the scene{} {}",
        "beside",
        table::denoising(ours.seconds.denoise),
        duration(ours.seconds.write),
        table::quickly(comparison.settings.picture.build),
        duration(comparison.build_seconds)
    ));
    lines.extend(backend_table::lines(&comparison.backends));
    lines.push(in_short(comparison));
    lines.join("\n")
}

/// Formats the time of a run from its start to its last file. Denoising and writing take the same time in
/// both ways; they were measured once.
fn in_short(comparison: &Comparison) -> String {
    let (ours, full) = (&comparison.totals.reprojected.seconds, &comparison.totals.full.seconds);
    let beside = ours.denoise + ours.write + comparison.build_seconds;
    let denoising = if ours.denoise > 0.0 { "denoising, " } else { "" };
    let writing = if ours.write > 0.0 { "writing files and " } else { "" };
    let [ours, full] = [ours, full].map(|seconds| seconds.rendering() + beside);
    // both eyes of a frame are one
    let frames = comparison.saved.frames / if comparison.eyes.is_some() { 2 } else { 1 };
    format!(
        "\nin short {frames} frames take {} with reuse and {} without, {denoising}{writing}building the scene included: {:.1} times as fast",
        duration(ours),
        duration(full),
        if ours > 0.0 { full / ours } else { 1.0 }
    )
}

fn saving(name: &str, saving: &Saving) -> String {
    format!(
        "saved    {}, {}, {:.2} times as fast ({name}: {})",
        saved(saving.rays_percent, "rays"),
        saved(saving.time_percent, "time"),
        saving.speed_up,
        saving.frames
    )
}

/// Formats a saving; empty if more was taken than a percentage can say.
fn saved(percent: f64, of: &str) -> String {
    match Saved::of_percent(percent) {
        Saved::Percent(percent) => format!("{percent} % of the {of}"),
        Saved::Times(times) => format!("none of the {of} ({times:.1} times as much)"),
    }
}

fn percent_or_dash(ours: f64, full: f64) -> String {
    // what full tracing hardly does cannot be saved
    match Saved::of(ours, full) {
        Some(Saved::Percent(percent)) => format!("{percent} %"),
        Some(Saved::Times(_)) | None => String::from("-"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::error::BothErrors;

    #[test]
    fn a_slower_way_saves_nothing() {
        let slow = Saving { frames: 3, rays_percent: -0.01, time_percent: -150.0, speed_up: 0.4 };
        let text = saving("inferred", &slow);
        let wanted = "saved    0.0 % of the rays, none of the time (2.5 times as much), 0.40 times as fast (inferred: 3)";
        assert_eq!(text, wanted);
        assert_eq!(
            [(3.0, 2.0), (5.0, 2.0), (1.0, 0.0)].map(|(ours, full)| percent_or_dash(ours, full)),
            ["-50.0 %", "-", "-"]
        );
    }

    #[test]
    fn in_short_both_ways_build_and_write() {
        let mut comparison = crate::report::comparison::tests::comparison(Vec::new());
        let totals = &mut comparison.totals;
        (totals.reprojected.seconds.total, totals.reprojected.seconds.write) = (11.0, 3.0);
        (totals.full.seconds.total, comparison.build_seconds) = (68.0, 2.0);
        comparison.saved.frames = 9;
        let text = in_short(&comparison);
        assert!(text.contains("9 frames take 13.0 s with reuse and 73.0 s without"), "{text}");
        assert!(text.ends_with("writing files and building the scene included: 5.6 times as fast"), "{text}");
        assert!(!text.contains("denoising"), "{text}");
        // with the denoiser's second both take one more
        let ours = &mut comparison.totals.reprojected.seconds;
        (ours.total, ours.denoise) = (12.0, 1.0);
        let text = in_short(&comparison);
        assert!(
            text.contains("14.0 s with reuse and 74.0 s without, denoising, writing files and"),
            "{text}"
        );
    }

    #[test]
    fn rows_stand_under_their_titles() {
        let frame = ComparedFrame {
            frame: 5,
            reprojected: Default::default(),
            full: Default::default(),
            difference: Difference::default(),
            error: None,
        };
        for (error, titles) in [
            (None, [("difference", "0.00000"), (">0.02%", "0.00")]),
            (Some(BothErrors::default()), [("error", "0.0000"), ("ratio", "-")]),
        ] {
            let frame = ComparedFrame { error, ..frame.clone() };
            let (head, row) = (header(false, error.is_some()), row(&frame));
            for (title, value) in titles {
                let end = head.find(title).expect(title) + title.len();
                assert!(row[..end].ends_with(value), "{head}\n{row}");
            }
            assert!(header(true, error.is_some()).len() <= table::COLUMNS);
            let end = head.len() - " audit".len();
            assert_eq!(row[end..], *" -", "{head}\n{row}");
        }
    }
}

//! The table on stdout: one line a frame, and the totals of the run.

use super::terminal::duration;
use crate::scene::texture::PageCounts;
use crate::settings::Build;
use crate::stats::{
    AuditCounts, Eyes, FrameStats, FromLeft, FullEstimate, Memory, Percent, RayCounts, Totals, saved_percent,
};

/// Columns of the terminals that rows fit into.
#[cfg(test)]
pub const COLUMNS: usize = 100;

/// Formats the title line of a render's table. Rays in millions. With two eyes each frame has two rows.
pub fn header(has_two_eyes: bool) -> String {
    let eye = if has_two_eyes { " eye  " } else { "" };
    format!(
        "frame{eye} mode      seconds write reused% prim. verify shadow refl. refr. gath. total saved% audit",
    )
}

/// Formats one frame. `full` estimates the rays for tracing every sample.
pub fn row(frame: &FrameStats, full: Option<FullEstimate>) -> String {
    let rays = &frame.rays;
    let saved = full.map(|full| saved_percent(rays.total() as f64, full.rays(frame)));
    format!(
        "{:>5}{} {:<9} {:>7.3} {:>5.2} {:>7.1} {:>5} {:>6} {:>6} {:>5} {:>5} {:>5} {:>5} {:>6} {}",
        frame.frame,
        eye(frame),
        frame.kind(),
        frame.seconds.rendering(),
        frame.seconds.write,
        reused_percent(frame),
        short_millions(rays.primary),
        short_millions(rays.verification),
        short_millions(rays.shadow),
        short_millions(rays.reflection),
        short_millions(rays.refraction),
        short_millions(rays.gathering),
        short_millions(rays.total()),
        saved.map_or_else(|| String::from("-"), |saved| Percent(saved).to_string()),
        audit(frame.audit),
    )
}

/// Formats a column for the eye, if there are two.
pub fn eye(frame: &FrameStats) -> String {
    frame.eye.map_or_else(String::new, |eye| format!(" {:<5}", eye.name()))
}

/// Formats the share of its samples that the right eye took from the left one.
pub fn eyes_line(eyes: &Eyes) -> String {
    let FromLeft { frames, percent, .. } = eyes.from_left;
    format!(
        "{:<9}right eye: {percent:.1} % of its samples from the left eye's (frames: {frames}); {} M rays, left {} M",
        "stereo",
        millions(eyes.right.rays.total()),
        millions(eyes.left.rays.total()),
    )
}

/// Percent of a frame's samples that were not traced.
pub fn reused_percent(frame: &FrameStats) -> f64 {
    percent(frame.samples.reused(), frame.samples.total())
}

/// Percentage; 0 if `whole` is 0.
pub fn percent(part: u64, whole: u64) -> f64 {
    if whole == 0 { 0.0 } else { 100.0 * part as f64 / whole as f64 }
}

/// Formats millions: `12.34` for 12 340 000.
pub fn millions(rays: u64) -> String {
    format!("{:.2}", rays as f64 / 1e6)
}

/// Formats millions in five characters, as long as there are fewer than 10^11: with as many decimals as there
/// is room for.
pub fn short_millions(rays: u64) -> String {
    let millions = rays as f64 / 1e6;
    let decimals = match millions {
        ..99.995 => 2,
        ..999.95 => 1,
        _ => 0,
    };
    format!("{millions:.decimals$}")
}

/// Formats the audit: `-`, `ok`, or the number of samples that differ.
pub fn audit(counts: Option<AuditCounts>) -> String {
    match counts {
        None => String::from("-"),
        Some(audit) if audit.wrong() == 0 => String::from("ok"),
        Some(AuditCounts { differing: 0, coverage, .. }) => format!("{coverage} elsewhere"),
        Some(AuditCounts { differing, .. }) => format!("{differing} differ"),
    }
}

/// Totals of a render.
pub struct Summary<'a> {
    /// Number of frames written.
    pub frames: usize,
    /// Costs of each eye, if there are two.
    pub eyes: Option<Eyes>,
    /// Sum of the frames written.
    pub totals: &'a Totals,
    /// Estimated rays for tracing every sample of these frames; 0: unknown.
    pub full_rays: f64,
    /// Frames that were rendered but not written, and their sum.
    pub run_up: Option<(usize, &'a Totals)>,
    /// Memory at the end.
    pub memory: Memory,
    /// Build quality of the acceleration structure.
    pub build: Build,
    /// Seconds that building it took.
    pub build_seconds: f64,
    /// Seconds of the whole run, from the first frame on.
    pub wall_seconds: f64,
}

/// Remark on a scene that was built quickly.
pub fn quickly(build: Build) -> &'static str {
    match build {
        Build::Best => "",
        Build::Quick => " (quickly)",
    }
}

/// Formats the time of denoising with a comma, if there was any.
pub fn denoising(seconds: f64) -> String {
    if seconds > 0.0 { format!(" denoising {},", duration(seconds)) } else { String::new() }
}

/// Formats the lines below the table.
pub fn summary(sum: &Summary<'_>) -> String {
    let totals = sum.totals;
    let mut lines = vec![
        format!(
            "{:<9}{} in {}: rendering {},{} writing {}; building the scene before{} {}",
            "frames",
            sum.frames,
            duration(sum.wall_seconds),
            duration(totals.seconds.rendering()),
            denoising(totals.seconds.denoise),
            duration(totals.seconds.write),
            quickly(sum.build),
            duration(sum.build_seconds),
        ),
        samples_line(totals),
        format!("{:<9}{}", "rays", rays_text(&totals.rays)),
    ];
    if totals.samples.reused() > 0 && sum.full_rays > 0.0 {
        lines.push(format!(
            "{:<9}about {} % of the rays, against tracing every sample: one primary ray each, shadow rays \
             a sample as in the last base frame, reflection and refraction as cast (`compare` measures it)",
            "saved",
            Percent(saved_percent(totals.rays.total() as f64, sum.full_rays)),
        ));
    }
    if let Some((frames, totals)) = sum.run_up {
        lines.push(format!(
            "{:<9}{frames} more frames in {}, {} M rays: rendered, not written, and in no sum above",
            "run-up",
            duration(totals.seconds.total),
            millions(totals.rays.total()),
        ));
    }
    lines.extend(sum.eyes.as_ref().map(eyes_line));
    lines.extend(totals.audit.map(audit_line));
    lines.push(memory_line(&sum.memory));
    lines.extend(sum.memory.texture_pages.as_ref().map(texture_line));
    lines.join("\n")
}

fn samples_line(totals: &Totals) -> String {
    let samples = &totals.samples;
    let share = |count| percent(count, samples.total());
    format!(
        "{:<9}{:.1} % reused ({:.1} good, {:.1} overlapped), traced: {:.1} % missed, {:.1} obscured, {:.1} base",
        "samples",
        share(samples.reused()),
        share(samples.good),
        share(samples.overlapped),
        share(samples.missed),
        share(samples.obscured),
        share(samples.base),
    )
}

/// Formats the rays of all kinds, and their sum.
pub fn rays_text(rays: &RayCounts) -> String {
    format!(
        "{} M: primary {}, verification {}, shadow {}, reflection {}, refraction {}, gathering {}",
        millions(rays.total()),
        millions(rays.primary),
        millions(rays.verification),
        millions(rays.shadow),
        millions(rays.reflection),
        millions(rays.refraction),
        millions(rays.gathering),
    )
}

/// Formats the result of the audit over all frames.
pub fn audit_line(audit: AuditCounts) -> String {
    let AuditCounts { checked, differing, on_edge, targets, coverage, coverage_on_edge, mirrored } = audit;
    let cells = match targets {
        0 => String::from("no target was asked what it sees: the paper's rule promises nothing of it"),
        _ => format!(
            "{coverage} cells show another surface than their targets see; {coverage_on_edge} within the tolerance"
        ),
    };
    let in_mirrors = match mirrored {
        0 => String::new(),
        _ => format!(", and {mirrored} surfaces that mirrors show"),
    };
    format!(
        "{:<9}{checked} samples traced again{in_mirrors}: {differing} differ; {on_edge} hold within the tolerance for edges\n\
         {:<9}{cells}",
        "audit", ""
    )
}

/// Formats peak memory and the size of the store.
pub fn memory_line(memory: &Memory) -> String {
    format!(
        "{:<9}{} at most; sample store {}, {:.1} bytes a sample",
        "memory",
        bytes(memory.peak_bytes),
        bytes(memory.store_bytes),
        memory.bytes_per_sample
    )
}

/// Formats the use of textures in pages.
pub fn texture_line(pages: &PageCounts) -> String {
    let PageCounts { bytes: all, held, asked, read } = *pages;
    format!(
        "{:<9}{} in pages of a file, {} of them held; {} M texels asked for, {:.3} % of them in pages that had to be read",
        "textures",
        bytes(all),
        bytes(held),
        millions(asked),
        100.0 * read as f64 / asked.max(1) as f64
    )
}

/// Formats bytes, as `812.0 MiB`.
pub fn bytes(count: u64) -> String {
    let mib = count as f64 / f64::from(1 << 20);
    if mib < 1024.0 { format!("{mib:.1} MiB") } else { format!("{:.2} GiB", mib / 1024.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::{SampleCounts, Seconds};

    fn frame() -> FrameStats {
        FrameStats {
            frame: 12,
            mode: "reproject",
            seconds: Seconds { total: 0.5, write: 0.1, ..Seconds::default() },
            samples: SampleCounts { good: 900, overlapped: 50, missed: 50, ..SampleCounts::default() },
            rays: RayCounts { primary: 50, verification: 950, shadow: 1_234_000, ..RayCounts::default() },
            audit: Some(AuditCounts { checked: 1000, on_edge: 1, ..Default::default() }),
            ..FrameStats::default()
        }
    }

    #[test]
    fn rows_stand_under_their_titles() {
        let (head, row) = (header(false), row(&frame(), None));
        let mut end_of_title = 0;
        for (title, value) in [
            ("frame", "12"),
            ("seconds", "0.400"),
            ("write", "0.10"),
            ("reused%", "95.0"),
            ("shadow", "1.23"),
            ("saved%", "-"),
        ] {
            end_of_title = end_of_title + head[end_of_title..].find(title).expect(title) + title.len();
            assert!(row[..end_of_title].ends_with(value), "{title} in\n{head}\n{row}");
        }
        assert!(row.ends_with(" ok"));
    }

    #[test]
    fn rows_of_long_runs_fit_a_terminal() {
        let many = 98_765_432_100;
        let rays = RayCounts {
            primary: many,
            verification: many,
            shadow: many,
            reflection: many,
            refraction: many,
            gathering: 1_000_000,
        };
        let seconds = Seconds { total: 999.0, write: 99.0, ..Seconds::default() };
        for eye in [None, Some(crate::stereo::Eye::Right)] {
            let row = row(&FrameStats { frame: 10_000, eye, seconds, rays, ..frame() }, None);
            assert!(header(eye.is_some()).len() <= COLUMNS && row.len() <= COLUMNS, "{row}");
        }
        let short = [0, 1_234_000, 99_996_000, 999_940_000, 999_960_000, many].map(short_millions);
        assert_eq!(short, ["0.00", "1.23", "100.0", "999.9", "1000", "98765"]);
    }

    #[test]
    fn two_eyes_have_a_column() {
        let both = [("left ", 0), ("right", 1)];
        for (name, number) in both {
            let seen =
                FrameStats { eye: Some(crate::stereo::Eye::BOTH[number]), from_left: number == 1, ..frame() };
            let (head, row) = (header(true), row(&seen, None));
            let at = head.find("eye").expect("a title");
            assert_eq!(row[at..at + 5], *name, "{head}\n{row}");
            assert_eq!(head.find("mode"), row.find("reproject"), "{head}\n{row}");
            let line = Eyes::new(&[seen]).map(|eyes| eyes_line(&eyes)).expect("two eyes");
            assert_eq!(line.contains("95.0 % of its samples"), number == 1, "{line}");
        }
    }

    #[test]
    fn the_summary_hides_no_ray() {
        let totals = Totals::new(&[frame()]);
        let sum = Summary {
            frames: 1,
            eyes: None,
            totals: &totals,
            full_rays: 2_470_000.0,
            run_up: Some((3, &totals)),
            memory: Memory {
                peak_bytes: 3 << 30,
                store_bytes: 1 << 20,
                bytes_per_sample: 58.0,
                texture_pages: None,
            },
            build: Build::Quick,
            build_seconds: 0.1,
            wall_seconds: 0.6,
        };
        let text = summary(&sum);
        for part in [
            "95.0 % reused",
            "rendering 0.40 s, writing 0.10 s",
            "before (quickly) 0.1",
            "1.24 M:",
            "about 50.0 %",
            "3 more frames",
        ] {
            assert!(text.contains(part), "{part} is not in\n{text}");
        }
        assert!(text.contains("3.00 GiB at most") && text.contains("0 differ"));
    }
}

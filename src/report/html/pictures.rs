//! What frames look like: both ways, how far they are apart, and where samples came from.

use std::fmt::Write;

use crate::film::Film;
use crate::output::false_color;
use crate::report::both_ways::{ComparedFrame, THRESHOLD};
use crate::report::comparison::Comparison;
use crate::report::picture::{self, STATUSES, hex};
use crate::stats::Percent;

/// Differences of which the page says the colour.
const DIFFERENCES: [f32; 5] = [0.0, 0.001, 0.01, 0.1, 1.0];

/// One frame to look at; each a `data:` URI.
#[derive(Debug, Clone, PartialEq)]
pub struct Pictures {
    /// The frame's number.
    pub frame: i32,
    /// Made by reprojection.
    pub reprojected: String,
    /// Traced in full.
    pub full: String,
    /// How far both are apart, in false colours.
    pub difference: String,
    /// Where the samples of the first came from, in the colours of the statuses.
    pub statuses: Option<String>,
}

impl Pictures {
    /// Of a frame that was made in both ways; `None` where there is nothing to see.
    pub fn of(frame: i32, reprojected: &Film, full: &Film) -> Option<Self> {
        Some(Self {
            frame,
            reprojected: picture::beauty(reprojected)?,
            full: picture::beauty(full)?,
            difference: picture::difference_map(reprojected, full)?,
            statuses: picture::status_map(reprojected),
        })
    }
}

/// The part of the page with all pictures.
pub fn section(comparison: &Comparison, pictures: &[Pictures]) -> String {
    if pictures.is_empty() {
        return String::new();
    }
    let compared = |pictures: &Pictures| comparison.frames.iter().find(|one| one.frame == pictures.frame);
    let is_inferred = |pictures: &Pictures| compared(pictures).is_some_and(ComparedFrame::is_inferred);
    let which = match pictures.iter().any(is_inferred) {
        true => "Frames made by reprojection, beside the same frames traced in full.",
        false => "No frame of this run reused samples.",
    };
    let side = picture::block_side(comparison.settings.picture.width);
    let blocks = match side {
        1 => String::new(),
        side => {
            format!(" Both maps show the worst pixel of each {side}×{side}, so that thin lines stay visible.")
        }
    };
    let mut html = format!(
        "<h2>What it looks like</h2><p class=\"note\">{which} The map of differences has the largest of R, G and B \
         (linear); the map of statuses tells where the samples came from.{blocks}</p>"
    );
    html.push_str(&legends());
    for pictures in pictures {
        html.push_str(&figures(pictures, compared(pictures)));
    }
    html
}

/// Below each picture, what was measured of it.
fn figures(pictures: &Pictures, compared: Option<&ComparedFrame>) -> String {
    let mut captions = [
        String::from("reprojected"),
        String::from("traced in full"),
        String::from("difference"),
        String::from("status of the samples"),
    ];
    if let Some(ComparedFrame { reprojected, full, difference, .. }) = compared {
        let samples = &reprojected.samples;
        let reused = 100.0 * samples.reused() as f64 / samples.total().max(1) as f64;
        let more = [
            format!(", {:.3} s", reprojected.seconds.rendering()),
            format!(", {:.3} s", full.seconds.rendering()),
            format!(
                ": mean {:.5}, {:.2} % of the pixels by more than {THRESHOLD}",
                difference.mean, difference.percent_above
            ),
            format!(": {} % reused", Percent(reused)),
        ];
        captions.iter_mut().zip(more).for_each(|(caption, more)| caption.push_str(&more));
    }
    let figure = |class: &str, uri: &str, text: &str| {
        format!("<figure><img{class} src=\"{uri}\" alt=\"\"><figcaption>{text}</figcaption></figure>")
    };
    let [reprojected, full, difference, statuses] = &captions;
    let map = " class=\"map\"";
    format!(
        "<h3>Frame {}</h3><div class=\"figures\">{}{}{}{}</div>",
        pictures.frame,
        figure("", &pictures.reprojected, reprojected),
        figure("", &pictures.full, full),
        figure(map, &pictures.difference, difference),
        pictures.statuses.as_deref().map(|uri| figure(map, uri, statuses)).unwrap_or_default(),
    )
}

fn legends() -> String {
    let mut html = String::from("<dl>");
    for status in &STATUSES {
        let (color, name, meaning) = (hex(status.color), status.name, status.meaning);
        let _ = write!(html, "<dt><i style=\"background:{color}\"></i>{name}</dt><dd>{meaning}</dd>");
    }
    html.push_str("<dt>difference</dt><dd class=\"legend\">");
    for difference in DIFFERENCES {
        let color = hex(false_color::of_difference(difference));
        let _ = write!(html, "<span><i style=\"background:{color}\"></i>{difference}</span>");
    }
    html.push_str("</dd></dl>");
    html
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::both_ways::tests::{film, frame};
    use crate::report::comparison::tests::comparison;

    #[test]
    fn a_frame_has_both_ways_and_how_far_they_are_apart() {
        let (ours, full) = (film([0.5; 4]), film([0.5, 0.5, 0.25, 0.5]));
        let pictures = Pictures::of(2, &ours, &full).expect("both have pictures");
        assert_eq!(pictures.statuses, None, "of a film without statuses");
        assert_ne!(pictures.reprojected, pictures.full);
        let html = section(&comparison(vec![frame(1, 0), frame(2, 90)]), std::slice::from_ref(&pictures));
        for part in [
            &*pictures.reprojected,
            &pictures.full,
            &pictures.difference,
            "Frame 2",
            "reprojected, 0.200 s",
            "traced in full, 0.400 s",
            "mean 0.00100, 0.50 % of the pixels by more than 0.02",
        ] {
            assert!(html.contains(part), "{part}");
        }
        assert_eq!(html.matches("<img").count(), 3);
    }

    #[test]
    fn it_says_where_no_frame_reused_anything_and_how_large_blocks_are() {
        let pictures = Pictures::of(1, &film([0.5; 4]), &film([0.5; 4])).expect("both have pictures");
        let mut comparison = comparison(vec![frame(1, 0)]);
        let html = section(&comparison, std::slice::from_ref(&pictures));
        assert!(html.contains("No frame of this run reused samples.") && !html.contains("worst pixel"));
        comparison.settings.picture.width = 1280;
        assert!(section(&comparison, &[pictures]).contains("the worst pixel of each 4×4"));
        assert_eq!(section(&comparison, &[]), "");
    }
}

//! Pictures of frames on the page: both ways, their difference, and the statuses of samples.

use std::fmt::Write;

use crate::film::{Film, Plane};
use crate::output::false_color;
use crate::report::both_ways::ComparedFrame;
use crate::report::comparison::Comparison;
use crate::report::error::BothErrors;
use crate::report::html::grouped;
use crate::report::picture::{self, STATUSES, hex};
use crate::settings::Look;
use crate::stats::Percent;

/// Differences whose colours the page explains.
const DIFFERENCES: [f32; 5] = [0.0, 0.001, 0.01, 0.1, 1.0];

/// Pictures of one frame; each a `data:` URI.
#[derive(Debug, Clone, PartialEq)]
pub struct Pictures {
    /// Number of the frame.
    pub frame: i32,
    /// Made by reprojection.
    pub reprojected: String,
    /// Traced in full.
    pub full: String,
    /// True if both are denoised. Maps show the pictures as traced.
    pub is_denoised: bool,
    /// Difference between them, or errors of both.
    pub maps: Maps,
    /// Statuses of the first one's samples, in their colours.
    pub statuses: Option<String>,
}

/// Distances in false colours, each a `data:` URI.
#[derive(Debug, Clone, PartialEq)]
pub enum Maps {
    /// Difference between both ways, without a reference.
    Difference(String),
    /// Errors against the reference: made by reprojection, traced in full.
    Errors([String; 2]),
}

impl Pictures {
    /// Makes the pictures of a frame that was made in both ways, perhaps `denoised`, and as a `reference`, if
    /// there is one. `None` if the films have no picture.
    pub fn of(
        frame: i32,
        [reprojected, full]: [&Film; 2],
        denoised: [Option<&[Plane; 3]>; 2],
        reference: Option<&Film>,
        look: Look,
    ) -> Option<Self> {
        let maps = match reference {
            None => Maps::Difference(picture::difference_map(reprojected, full)?),
            Some(reference) => Maps::Errors([
                picture::difference_map(reprojected, reference)?,
                picture::difference_map(full, reference)?,
            ]),
        };
        Some(Self {
            frame,
            reprojected: picture::beauty(reprojected, denoised[0], look)?,
            full: picture::beauty(full, denoised[1], look)?,
            is_denoised: denoised.iter().all(Option::is_some),
            maps,
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
        side => format!(" Maps show the worst pixel of each {side}×{side}, so that thin lines stay visible."),
    };
    let denoised = match pictures.iter().any(|pictures| pictures.is_denoised) {
        true => {
            " Both are shown without their noise, as Open Image Denoise takes it off; all else is of what was traced."
        }
        false => "",
    };
    let mut html = format!(
        "<h2>What it looks like</h2><p class=\"note\">{which}{denoised} {} The map of statuses tells where the samples \
         came from.{blocks}</p>",
        what_differs(comparison)
    );
    html.push_str(&legends());
    for pictures in pictures {
        html.push_str(&figures(pictures, compared(pictures)));
    }
    html
}

/// Explains the difference of both ways, and that neither is wrong, if that is known.
fn what_differs(comparison: &Comparison) -> String {
    let audit = match comparison.totals.reprojected.audit {
        None => String::from(
            "<code>--audit</code> would trace every sample again, and tell whether one is wrong.",
        ),
        Some(audit) if audit.wrong() == 0 => {
            let samples = grouped(audit.checked);
            // the paper's rule asks no target
            let cells = match audit.targets {
                0 => "",
                _ => ", and each cell shows the surface that its centre sees",
            };
            format!(
                "The audit has traced all {samples} samples of the reprojected frames again: <b>none is wrong</b>{cells}."
            )
        }
        Some(audit) => {
            let (wrong, samples) = (grouped(audit.wrong()), grouped(audit.checked));
            format!("The audit has traced {samples} samples again: <b>{wrong} of them are wrong</b>.")
        }
    };
    let samples = "Both are samplings of the same picture, equally valid, with samples at other places of the pixels \
                   and light along other paths.";
    let maps = match &comparison.reference {
        None => String::from(
            "So the map of differences shows noise, that of both ways together, and no error: a second picture traced in \
             full with other random numbers would differ from the first one in the same manner, and more samples a pixel \
             would make all of it smaller. How large the error of each way is by itself, <code>--reference</code> \
             measures.",
        ),
        Some(reference) => {
            let errors = reference.inferred.errors;
            format!(
                "So each has its own noise. The maps of errors show how far either is from the same frame with {n}×{n} \
                 samples a pixel: over all inferred frames {:.4} with reuse and {:.4} traced in full (root mean square).",
                errors.reprojected.display,
                errors.full.display,
                n = reference.samples
            )
        }
    };
    format!("{samples} {audit} {maps} Maps have the largest of R, G and B (linear).")
}

/// Captions with the measurements of each picture.
fn figures(pictures: &Pictures, compared: Option<&ComparedFrame>) -> String {
    let mut html = format!("<h3>Frame {}</h3><div class=\"figures\">", pictures.frame);
    let mut figure = |class: &str, uri: &str, text: String| {
        let figure =
            format!("<figure><img{class} src=\"{uri}\" alt=\"\"><figcaption>{text}</figcaption></figure>");
        html.push_str(&figure);
    };
    let map = " class=\"map\"";
    let measured = |text: fn(&ComparedFrame) -> String| compared.map_or_else(String::new, text);
    let ours = measured(|compared| format!(", {:.3} s", compared.reprojected.seconds.rendering()));
    let full = measured(|compared| format!(", {:.3} s", compared.full.seconds.rendering()));
    let denoised = if pictures.is_denoised { ", then denoised" } else { "" };
    figure("", &pictures.reprojected, format!("reprojected{ours}{denoised}"));
    figure("", &pictures.full, format!("traced in full{full}{denoised}"));
    match &pictures.maps {
        Maps::Difference(uri) => {
            let mean = measured(|compared| format!(": {:.4} on average", compared.difference.mean));
            figure(map, uri, format!("difference of the two, noise of both{mean}"));
        }
        Maps::Errors(uris) => {
            let errors = compared.and_then(|compared| compared.error);
            for ((uri, way), error) in uris.iter().zip(["reprojected", "traced in full"]).zip(of_each(errors))
            {
                figure(map, uri, format!("error, {way}{error}"));
            }
        }
    }
    if let Some(uri) = &pictures.statuses {
        let reused = measured(|compared| {
            let samples = &compared.reprojected.samples;
            let reused = 100.0 * samples.reused() as f64 / samples.total().max(1) as f64;
            format!(": {} % reused", Percent(reused))
        });
        figure(map, uri, format!("status of the samples{reused}"));
    }
    html.push_str("</div>");
    html
}

/// The errors of both ways for captions, as far as they are known.
fn of_each(errors: Option<BothErrors>) -> [String; 2] {
    let text = |error: f64| format!(": {error:.4} (root mean square)");
    errors.map_or_else(Default::default, |errors| {
        [errors.reprojected, errors.full].map(|error| text(error.display))
    })
}

fn legends() -> String {
    let mut html = String::from("<dl>");
    for status in &STATUSES {
        let (color, name, meaning) = (hex(status.color), status.name, status.meaning);
        let _ = write!(html, "<dt><i style=\"background:{color}\"></i>{name}</dt><dd>{meaning}</dd>");
    }
    html.push_str("<dt>maps of differences, errors</dt><dd class=\"legend\">");
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
    use crate::film::PlaneKind;
    use crate::report::both_ways::tests::{film, frame};
    use crate::report::comparison::tests::comparison;
    use crate::report::error::PictureError;
    use crate::report::reference::Reference;
    use crate::stats::AuditCounts;

    #[test]
    fn a_frame_has_both_ways_and_how_far_they_are_apart() {
        let (ours, full) = (film([0.5; 4]), film([0.5, 0.5, 0.25, 0.5]));
        let pictures =
            Pictures::of(2, [&ours, &full], [None; 2], None, Look::default()).expect("both have pictures");
        assert_eq!(pictures.statuses, None, "of a film without statuses");
        assert_ne!(pictures.reprojected, pictures.full);
        let comparison = comparison(vec![frame(1, 0), frame(2, 90)]);
        let html = section(&comparison, std::slice::from_ref(&pictures));
        let Maps::Difference(difference) = &pictures.maps else { unreachable!("there is no reference") };
        for part in [
            &*pictures.reprojected,
            &pictures.full,
            difference,
            "Frame 2",
            "reprojected, 0.200 s",
            "traced in full, 0.400 s",
            "difference of the two, noise of both: 0.0010 on average",
            "traced all 200 samples of the reprojected frames again: <b>none is wrong</b>",
            "shows noise, that of both ways together, and no error",
        ] {
            assert!(html.contains(part), "{part} is not in {html}");
        }
        assert_eq!(html.matches("<img").count(), 3);
        assert!(!html.contains("denoise"));
    }

    #[test]
    fn denoised_pictures_say_so_and_maps_are_of_what_was_traced() {
        let (ours, full) = (film([0.5; 4]), film([0.5, 0.5, 0.25, 0.5]));
        let plane = |name| Plane::new(name, PlaneKind::Half, &[0.25; 4]);
        let smooth = crate::denoise::PLANES.map(plane);
        let of = |denoised| Pictures::of(2, [&ours, &full], [denoised; 2], None, Look::default());
        let (noisy, clean) = (of(None).expect("a picture"), of(Some(&smooth)).expect("a picture"));
        assert_eq!(clean.reprojected, clean.full);
        assert_ne!(clean.reprojected, noisy.reprojected);
        assert_eq!(clean.maps, noisy.maps);
        let html = section(&comparison(vec![frame(2, 90)]), &[clean]);
        for part in [
            "reprojected, 0.200 s, then denoised",
            "traced in full, 0.400 s, then denoised",
            "without their noise",
        ] {
            assert!(html.contains(part), "{part} is not in {html}");
        }
    }

    #[test]
    fn with_a_reference_each_way_has_its_own_error() {
        let [ours, full, reference] = [0.5, 0.25, 0.75].map(|value| film([value; 4]));
        let pictures = Pictures::of(2, [&ours, &full], [None; 2], Some(&reference), Look::default())
            .expect("all have pictures");
        let of = |display| PictureError { display, linear: display };
        let mut inferred = frame(2, 90);
        inferred.error = Some(BothErrors { reprojected: of(0.25), full: of(0.5) });
        let mut comparison = comparison(vec![inferred.clone()]);
        comparison.reference = Some(Reference::of(8, &[inferred]));
        let html = section(&comparison, std::slice::from_ref(&pictures));
        let Maps::Errors([of_ours, of_full]) = &pictures.maps else { unreachable!("there is a reference") };
        assert_ne!(of_ours, of_full);
        for part in [
            of_ours,
            of_full,
            "error, reprojected: 0.2500 (root mean square)",
            "error, traced in full: 0.5000 (root mean square)",
            "with 8×8 samples a pixel: over all inferred frames 0.2500 with reuse and 0.5000 traced in full",
        ] {
            assert!(html.contains(part), "{part} is not in {html}");
        }
        assert!(!html.contains("difference of the two"));
    }

    #[test]
    fn what_the_audit_finds_is_not_called_noise() {
        let mut wrong = frame(2, 90);
        wrong.reprojected.audit = Some(AuditCounts { checked: 1000, differing: 7, ..Default::default() });
        assert!(what_differs(&comparison(vec![wrong.clone()])).contains("<b>7 of them are wrong</b>"));
        wrong.reprojected.audit = None;
        assert!(what_differs(&comparison(vec![wrong])).contains("<code>--audit</code> would"));
    }

    #[test]
    fn it_says_where_no_frame_reused_anything_and_how_large_blocks_are() {
        let pictures = Pictures::of(1, [&film([0.5; 4]); 2], [None; 2], None, Look::default());
        let pictures = pictures.expect("both have pictures");
        let mut comparison = comparison(vec![frame(1, 0)]);
        let html = section(&comparison, std::slice::from_ref(&pictures));
        assert!(html.contains("No frame of this run reused samples.") && !html.contains("worst pixel"));
        comparison.settings.picture.width = 1280;
        assert!(section(&comparison, &[pictures]).contains("the worst pixel of each 4×4"));
        assert_eq!(section(&comparison, &[]), "");
    }
}

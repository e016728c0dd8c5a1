//! Metadata in a frame's header, under the names that compositors look for.

use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use openexr::Attribute;

use super::fingerprint::{self, Fingerprint};

/// CIE xy of Rec. 709's red, green, blue and of D65: the primaries and the white of `R G B`.
const REC_709: [f32; 8] = [0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290];

/// Key of the frame's number in headers.
pub const FRAME_KEY: &str = "imageCounter";

/// Metadata of a frame, beside its planes.
///
/// Matrices are for row vectors, `p' = p * M`, rows one after the other, as in Imath, Nuke and all
/// EXR files: the translation stands in elements 12, 13 and 14. (glam's `Mat4::to_cols_array` of a
/// matrix for column vectors is the same sixteen numbers in the same order.)
#[derive(Clone, Debug, PartialEq)]
pub struct FrameMeta {
    /// Absolute number of the frame.
    pub frame: i32,
    /// Frames per second as a fraction: (24, 1), (24000, 1001).
    pub rate: (i32, u32),
    /// World space to camera space: the camera looks along -z, y is up. Row vectors.
    pub world_to_camera: [f32; 16],
    /// World space to normalized device coordinates, -1 to 1, y up. Row vectors.
    pub world_to_ndc: [f32; 16],
    /// Free text: how the frame was made.
    pub comments: String,
    /// Name of the shot.
    pub shot: String,
    /// Fingerprint of the frame, if a later run shall know it.
    pub fingerprint: Option<Fingerprint>,
    /// Further texts, names and values: of its layers, and of its run.
    pub layers: Arc<[(String, String)]>,
}

/// The header's attributes in the order in which they are listed by readers.
pub(super) fn attributes(meta: &FrameMeta, now: SystemTime) -> Vec<(String, Attribute)> {
    let (numerator, denominator) = (meta.rate.0.max(1), meta.rate.1.max(1));
    let text = |text: &str| Attribute::Text(text.replace('\0', " "));
    let software = concat!("Afterimage ", env!("CARGO_PKG_VERSION"));
    let time_and_flags = time_code(meta.frame, numerator, denominator);
    let fingerprint = meta.fingerprint.map(|made_from| (fingerprint::KEY, text(&made_from.to_string())));
    let attributes = [
        ("worldToCamera", Attribute::M44f(meta.world_to_camera)),
        ("worldToNDC", Attribute::M44f(meta.world_to_ndc)),
        ("framesPerSecond", Attribute::Rational { numerator, denominator }),
        (FRAME_KEY, Attribute::Int(meta.frame)),
        ("timeCode", Attribute::TimeCode { time_and_flags, user_data: 0 }),
        ("capDate", text(&date(now))),
        ("utcOffset", Attribute::Float(0.0)), // `capDate` is told in UTC
        ("comments", text(&meta.comments)),
        ("shot", text(&meta.shot)),
        ("software", text(software)),
        ("chromaticities", Attribute::Chromaticities(REC_709)),
    ];
    let layers = meta.layers.iter().map(|(name, value)| (name.clone(), text(value)));
    let attributes = attributes.into_iter().chain(fingerprint);
    attributes.map(|(name, value)| (name.to_owned(), value)).chain(layers).collect()
}

/// Hours, minutes, seconds and frames since frame 0 as the binary-coded digits of SMPTE 12M, in
/// OpenEXR's order (TV60 packing, no flags): frames in bits 0 to 5, seconds from 8, minutes from 16,
/// hours from 24. It counts frames without dropping any, and starts again after 24 hours; frame
/// numbers below 0 count back from there.
fn time_code(frame: i32, numerator: i32, denominator: u32) -> u32 {
    // 23.976 frames per second are counted as 24 in a time code.
    let per_second = (f64::from(numerator) / f64::from(denominator)).round().clamp(1.0, 40.0) as i64;
    let frame = i64::from(frame).rem_euclid(per_second * 24 * 60 * 60);
    let seconds = frame / per_second;
    let digits = |number: i64| (((number / 10) << 4) | (number % 10)) as u32;
    digits(frame % per_second)
        | digits(seconds % 60) << 8
        | digits(seconds / 60 % 60) << 16
        | digits(seconds / 3600) << 24
}

/// Formats a time as `YYYY:MM:DD hh:mm:ss` in UTC. Times before 1970 become its beginning.
fn date(now: SystemTime) -> String {
    let seconds = now.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let (year, month, day) = civil(seconds / 86_400);
    let (hour, minute, second) = (seconds / 3600 % 24, seconds / 60 % 60, seconds % 60);
    format!("{year:04}:{month:02}:{day:02} {hour:02}:{minute:02}:{second:02}")
}

/// Year, month (1 to 12) and day (1 to 31) that lie `days` after 1970-01-01, Gregorian calendar.
fn civil(mut days: u64) -> (u64, usize, u64) {
    let is_leap = |year: u64| year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let mut year = 1970;
    while days >= 365 + u64::from(is_leap(year)) {
        days -= 365 + u64::from(is_leap(year));
        year += 1;
    }
    let february = 28 + u64::from(is_leap(year));
    let lengths = [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let mut month = 0;
    while days >= lengths[month] {
        days -= lengths[month];
        month += 1;
    }
    (year, month + 1, days + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn dates_meet_the_calendar() {
        let at = |seconds| date(UNIX_EPOCH + Duration::from_secs(seconds));
        assert_eq!(at(0), "1970:01:01 00:00:00");
        assert_eq!(at(951_827_696), "2000:02:29 12:34:56");
        assert_eq!(at(1_735_689_599), "2024:12:31 23:59:59");
        assert_eq!(at(1_735_689_600), "2025:01:01 00:00:00");
        assert_eq!(at(4_107_542_400), "2100:03:01 00:00:00");
    }

    #[test]
    fn time_codes_are_binary_coded_digits() {
        assert_eq!(time_code(0, 24, 1), 0);
        assert_eq!(time_code(23, 24, 1), 0x0000_0023);
        assert_eq!(time_code(24, 24000, 1001), 0x0000_0100);
        assert_eq!(time_code(24 * 86_399 + 12, 24, 1), 0x2359_5912);
        assert_eq!(time_code(-1, 24, 1), 0x2359_5923);
        assert_eq!(time_code(i32::MIN, 1_000_000, 1) & 0xC0, 0, "no flag is set");
    }
}

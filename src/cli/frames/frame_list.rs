//! Numbers of frames in words.

/// Formats numbers that rise, as `1-4, 7`.
pub fn runs(frames: &[i32]) -> String {
    let mut runs: Vec<[i32; 2]> = Vec::new();
    for &frame in frames {
        match runs.last_mut() {
            Some(run) if run[1].checked_add(1) == Some(frame) => run[1] = frame,
            _ => runs.push([frame, frame]),
        }
    }
    let words = runs.iter().map(
        |[first, last]| {
            if first == last { first.to_string() } else { format!("{first}-{last}") }
        },
    );
    words.collect::<Vec<_>>().join(", ")
}

/// Formats numbers that rise as `--frames` takes them: `1-4,7`.
pub fn range(frames: &[i32]) -> String {
    runs(frames).replace(", ", ",")
}

/// Formats frames, as `frame 7`, `frames 1-4, 7`.
pub fn frames(frames: &[i32]) -> String {
    format!("{} {}", if frames.len() == 1 { "frame" } else { "frames" }, runs(frames))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_told_in_runs() {
        assert_eq!(runs(&[-2, -1, 0, 5, 7, 8]), "-2-0, 5, 7-8");
        assert_eq!((frames(&[3]), frames(&[3, 4])), ("frame 3".into(), "frames 3-4".into()));
    }
}

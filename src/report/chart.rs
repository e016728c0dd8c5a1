//! Charts as inline SVG: one value a frame, stacked or as lines.

use std::fmt::Write;

/// Size of a chart in SVG units, and the room for its labels.
const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 220.0;
const LEFT: f64 = 52.0;
const BOTTOM: f64 = 24.0;
const TOP: f64 = 10.0;

/// One thing over all frames.
pub struct Series {
    /// For the legend and the tips.
    pub name: &'static str,
    /// As CSS writes it.
    pub color: String,
    /// One a frame.
    pub values: Vec<f64>,
}

/// Bars, one a frame, each of parts on top of each other. `unit` follows numbers in tips.
pub fn stacked_bars(frames: &[i32], series: &[Series], unit: &str) -> String {
    let sums = (0..frames.len()).map(|i| series.iter().map(|series| series.values[i]).sum());
    let axis = Axis::up_to(sums.fold(0.0, f64::max));
    let mut svg = open(frames, &axis);
    let slot = (WIDTH - LEFT) / frames.len().max(1) as f64;
    let width = (slot * 0.86).max(0.4);
    for (i, frame) in frames.iter().enumerate() {
        let x = LEFT + slot * i as f64 + (slot - width) / 2.0;
        let mut base = 0.0;
        let _ = write!(svg, "<g><title>frame {frame}");
        for series in series {
            let _ = write!(svg, "&#10;{}: {:.2}{unit}", series.name, series.values[i]);
        }
        svg.push_str("</title>");
        for series in series.iter().filter(|series| series.values[i] > 0.0) {
            let (low, high) = (axis.y(base), axis.y(base + series.values[i]));
            base += series.values[i];
            let _ = write!(
                svg,
                r#"<rect x="{x:.2}" y="{high:.2}" width="{width:.2}" height="{:.2}" fill="{}"/>"#,
                low - high,
                series.color
            );
        }
        svg.push_str("</g>");
    }
    close(svg, series)
}

/// A line for each series, with a dot for each frame where there is room.
pub fn lines(frames: &[i32], series: &[Series], unit: &str) -> String {
    let most = series.iter().flat_map(|series| &series.values).copied().fold(0.0, f64::max);
    let axis = Axis::up_to(most);
    let mut svg = open(frames, &axis);
    let slot = (WIDTH - LEFT) / frames.len().max(1) as f64;
    let radius = if frames.len() > 150 { 1.2 } else { 2.6 };
    for series in series {
        let x = |i: usize| LEFT + slot * (i as f64 + 0.5);
        let points: Vec<String> = (series.values.iter().enumerate())
            .map(|(i, value)| format!("{:.2},{:.2}", x(i), axis.y(*value)))
            .collect();
        let _ = write!(
            svg,
            r#"<polyline points="{}" fill="none" stroke="{}" stroke-width="1.8"/>"#,
            points.join(" "),
            series.color
        );
        for (i, (value, frame)) in series.values.iter().zip(frames).enumerate() {
            let _ = write!(
                svg,
                r#"<circle cx="{:.2}" cy="{:.2}" r="{radius}" fill="{}"><title>frame {frame}: {} {value:.3}{unit}</title></circle>"#,
                x(i),
                axis.y(*value),
                series.color,
                series.name
            );
        }
    }
    close(svg, series)
}

/// From 0 to a round number.
struct Axis {
    top: f64,
    step: f64,
}

impl Axis {
    fn up_to(most: f64) -> Self {
        if most <= 0.0 || !most.is_finite() {
            return Self { top: 1.0, step: 0.5 };
        }
        let rough = most / 4.0;
        let power = 10_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 2.5, 5.0, 10.0].map(|digit| digit * power).into_iter();
        // the tolerance keeps 100 % from becoming 125 % by a rounding error
        let step = step.clone().find(|step| *step >= rough * (1.0 - 1e-9)).unwrap_or(rough);
        Self { top: step * (most / step * (1.0 - 1e-9)).ceil(), step }
    }

    fn y(&self, value: f64) -> f64 {
        HEIGHT - BOTTOM - (HEIGHT - BOTTOM - TOP) * (value / self.top).clamp(0.0, 1.0)
    }
}

/// The frame of a chart: lines across with numbers, and frames' numbers below.
fn open(frames: &[i32], axis: &Axis) -> String {
    let mut svg = format!(r#"<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img">"#);
    let ticks = (axis.top / axis.step).round() as usize;
    for tick in 0..=ticks {
        let value = axis.step * tick as f64;
        let y = axis.y(value);
        let _ = write!(
            svg,
            r#"<line class="grid" x1="{LEFT}" x2="{WIDTH}" y1="{y:.2}" y2="{y:.2}"/><text x="{}" y="{:.2}" text-anchor="end">{}</text>"#,
            LEFT - 6.0,
            y + 4.0,
            short(value)
        );
    }
    let slot = (WIDTH - LEFT) / frames.len().max(1) as f64;
    let every = frames.len().div_ceil(16).max(1);
    for (i, frame) in frames.iter().enumerate().step_by(every) {
        let x = LEFT + slot * (i as f64 + 0.5);
        let _ = write!(svg, r#"<text x="{x:.2}" y="{}" text-anchor="middle">{frame}</text>"#, HEIGHT - 6.0);
    }
    svg
}

fn close(mut svg: String, series: &[Series]) -> String {
    svg.push_str("</svg><p class=\"legend\">");
    for series in series {
        let _ = write!(svg, r#"<span><i style="background:{}"></i>{}</span>"#, series.color, series.name);
    }
    svg.push_str("</p>");
    svg
}

/// A number without needless zeros.
fn short(value: f64) -> String {
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(values: &[f64]) -> Series {
        Series { name: "seconds", color: String::from("#123456"), values: values.to_vec() }
    }

    #[test]
    fn axes_end_at_round_numbers() {
        for (most, top) in [(100.0, 100.0), (0.37, 0.4), (7.3, 8.0), (0.0, 1.0), (f64::NAN, 1.0)] {
            assert!((Axis::up_to(most).top - top).abs() < 1e-9, "{most}: {}", Axis::up_to(most).top);
        }
        assert_eq!(short(0.1 + 0.2), "0.3");
    }

    #[test]
    fn a_bar_for_each_part_and_a_dot_for_each_value() {
        let bars = stacked_bars(&[1, 2], &[series(&[1.0, 2.0]), series(&[0.0, 1.0])], " %");
        assert_eq!((bars.matches("<rect").count(), bars.matches("<title>").count()), (3, 2));
        let lines = lines(&[1, 2, 3], &[series(&[1.0, 2.0, 3.0])], " s");
        assert_eq!((lines.matches("<circle").count(), lines.matches("<polyline").count()), (3, 1));
    }

    #[test]
    fn no_frames_draw_an_empty_chart() {
        assert!(stacked_bars(&[], &[series(&[])], "").ends_with("</p>"));
    }
}

//! Charts: one value a frame, stacked or as lines. Drawings are inline SVG that stretches to whatever box it gets; text stands
//! beside them in HTML, so that it keeps its size on every screen.

use std::fmt::Write;

/// Size of a drawing in SVG units.
const WIDTH: f64 = 1000.0;
const HEIGHT: f64 = 100.0;

/// Maximum number of frame numbers below a chart; narrow pages leave out every other one.
const MOST_NUMBERS: usize = 12;

/// A quantity over all frames.
pub struct Series {
    /// Name, for the legend and the tips.
    pub name: &'static str,
    /// Colour in CSS.
    pub color: String,
    /// Values, one a frame.
    pub values: Vec<f64>,
}

/// Bars, one a frame, each of parts on top of each other. `unit` follows numbers in tips.
pub fn stacked_bars(frames: &[i32], series: &[Series], unit: &str) -> String {
    let sums = (0..frames.len()).map(|i| series.iter().map(|series| series.values[i]).sum());
    let axis = Axis::up_to(sums.fold(0.0, f64::max));
    let mut svg = open(&axis);
    let slot = slot(frames);
    let width = (slot * 0.86).max(0.4);
    for (i, frame) in frames.iter().enumerate() {
        let x = slot * (i as f64 + 0.5) - width / 2.0;
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
                r#"<rect x="{x:.2}" y="{high:.3}" width="{width:.2}" height="{:.3}" fill="{}"/>"#,
                low - high,
                series.color
            );
        }
        svg.push_str("</g>");
    }
    close(svg, frames, &axis, series)
}

/// A line for each series, with a dot for each frame.
pub fn lines(frames: &[i32], series: &[Series], unit: &str) -> String {
    let most = series.iter().flat_map(|series| &series.values).copied().fold(0.0, f64::max);
    let axis = Axis::up_to(most);
    let mut svg = open(&axis);
    let slot = slot(frames);
    let dot = if frames.len() > 150 { 2.4 } else { 5.6 };
    for series in series {
        let x = |i: usize| slot * (i as f64 + 0.5);
        let points: Vec<String> = (series.values.iter().enumerate())
            .map(|(i, value)| format!("{:.2},{:.3}", x(i), axis.y(*value)))
            .collect();
        let _ = write!(
            svg,
            r#"<polyline points="{}" fill="none" stroke="{}" stroke-width="1.8"/>"#,
            points.join(" "),
            series.color
        );
        for (i, (value, frame)) in series.values.iter().zip(frames).enumerate() {
            // a line without length, whose ends are round however the drawing is stretched
            let _ = write!(
                svg,
                r#"<path d="M{:.2} {:.3}h0" stroke="{}" stroke-width="{dot}" stroke-linecap="round"><title>frame {frame}: {} {value:.3}{unit}</title></path>"#,
                x(i),
                axis.y(*value),
                series.color,
                series.name
            );
        }
    }
    close(svg, frames, &axis, series)
}

/// Width of a frame in the drawing.
fn slot(frames: &[i32]) -> f64 {
    WIDTH / frames.len().max(1) as f64
}

/// An axis from 0 to a round number.
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
        HEIGHT * (1.0 - (value / self.top).clamp(0.0, 1.0))
    }

    /// Values at which lines go across.
    fn ticks(&self) -> impl Iterator<Item = f64> {
        let (step, count) = (self.step, (self.top / self.step).round() as usize);
        (0..=count).map(move |tick| step * tick as f64)
    }
}

/// Opens the drawing of a chart, with lines across.
fn open(axis: &Axis) -> String {
    let mut svg = format!(
        r#"<div class="plot"><svg viewBox="0 0 {WIDTH} {HEIGHT}" preserveAspectRatio="none" role="img">"#
    );
    for y in axis.ticks().map(|value| axis.y(value)) {
        let _ = write!(svg, r#"<line class="grid" x1="0" x2="{WIDTH}" y1="{y:.3}" y2="{y:.3}"/>"#);
    }
    svg
}

/// Closes a chart: numbers beside the lines, frames' numbers below, and the legend.
fn close(mut svg: String, frames: &[i32], axis: &Axis, series: &[Series]) -> String {
    svg.push_str("</svg>");
    for value in axis.ticks() {
        let from_top = 100.0 * axis.y(value) / HEIGHT;
        let _ = write!(svg, r#"<span class="y" style="top:{from_top:.2}%">{}</span>"#, short(value));
    }
    let every = frames.len().div_ceil(MOST_NUMBERS).max(1);
    for (number, (i, frame)) in frames.iter().enumerate().step_by(every).enumerate() {
        let from_left = 100.0 * slot(frames) * (i as f64 + 0.5) / WIDTH;
        let class = if number % 2 == 0 { "x" } else { "x odd" };
        let _ = write!(svg, r#"<span class="{class}" style="left:{from_left:.2}%">{frame}</span>"#);
    }
    svg.push_str("</div><p class=\"legend\">");
    for series in series {
        let _ = write!(svg, r#"<span><i style="background:{}"></i>{}</span>"#, series.color, series.name);
    }
    svg.push_str("</p>");
    svg
}

/// Formats a number without needless zeros.
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
        assert_eq!((lines.matches("<path").count(), lines.matches("<polyline").count()), (3, 1));
    }

    /// Text in a drawing would shrink with it.
    #[test]
    fn text_stands_outside_of_the_drawing_where_its_line_is() {
        let html = lines(&[7, 8], &[series(&[0.0, 4.0])], " s");
        assert!(!html.contains("<text"), "{html}");
        assert!(html.contains(r#"<line class="grid" x1="0" x2="1000" y1="25.000" y2="25.000"/>"#), "{html}");
        assert!(html.contains(r#"style="top:25.00%">3</span>"#), "{html}");
        assert!(html.contains(r#"<span class="x" style="left:25.00%">7</span>"#), "{html}");
        assert!(html.contains(r#"<span class="x odd" style="left:75.00%">8</span>"#), "{html}");
    }

    #[test]
    fn frames_are_numbered_as_far_as_there_is_room() {
        for count in [1, 12, 13, 480, 10_000] {
            let frames: Vec<i32> = (1..=count).collect();
            let html = lines(&frames, &[series(&vec![1.0; count as usize])], "");
            let numbers = html.matches(r#"<span class="x"#).count();
            assert!((1..=MOST_NUMBERS).contains(&numbers), "{count}: {numbers}");
        }
    }

    #[test]
    fn no_frames_draw_an_empty_chart() {
        assert!(stacked_bars(&[], &[series(&[])], "").ends_with("</p>"));
    }
}

//! The shot file of a turntable. A bare model is rendered by the same text that `afterimage init` writes.

use std::fmt::Write;
use std::path::Path;

use glam::DVec3;
use toml::Value;

use super::{FRAMES, Fit, Presentation, Up};
use crate::scene::camera::on_orbit;
use crate::scene::import::meshes::read_model::is_ply;

/// Colour that replaces black materials: a light grey, like clay.
const CLAY: [f64; 3] = [0.6, 0.6, 0.6];

/// First lines of a shot that was written for somebody.
pub(in crate::scene) const HEAD: &str = "\
# A shot for Afterimage. Check it with `afterimage info`, look at it with `afterimage preview`, render it with `afterimage
# render`. Axes are right-handed, Y is up; angles are in degrees, colours are linear.
";

/// Light of a shot whose model brings none.
pub(in crate::scene) const LIGHT: &str = "
# A sky after sunset fills the shadows ...
[environment]
sky = { elevation = 0, azimuth = 120, ground = [0.3, 0.3, 0.3] }
power = 1.5

# ... a large soft light stands for the sun ...
[[light]]
name = \"key\"
type = \"directional\"
direction = [-0.6, -0.9, -0.5]  # in which the light travels
angle = 12                      # its size: soft shadows
color = [1, 0.95, 0.88]
power = 1.05
samples = 4                     # shadow rays of each sample; 16: less noise

# ... and a cooler one models the other side.
[[light]]
name = \"back\"
type = \"directional\"
direction = [0.7, -0.6, 0.6]
angle = 24
color = [0.82, 0.9, 1]
power = 0.4
samples = 4
";

/// Paths of a shot that nobody wrote.
pub(in crate::scene) const INDIRECT: &str = "
# Light from the sky and from other surfaces. More paths: less noise.
[indirect]
paths = 16
";

/// Writes a shot of the model at the path `model`, presented according to `look`.
pub fn text(look: &Presentation, model: &str) -> String {
    let mut text = format!("{HEAD}{}", around(&look.fit, look.size));
    let key = if is_ply(Path::new(model)) { "ply" } else { "obj" };
    let _ = write!(text, "\n[[model]]\n{key} = {}\n", Value::from(model));
    if look.up == Up::Z {
        text += "rotate = [-90, 0, 0]    # in the file Z is up\n";
    }
    let _ = write!(
        text,
        "
# To move it, keys of its own; `rotate` turns it about its origin.
# [[model.key]]
# frame = 1
# rotate = [0, 0, 0]
#
# [[model.key]]
# frame = {FRAMES}
# rotate = [0, 90, 0]
{}{LIGHT}{INDIRECT}",
        floor(&look.fit)
    );
    for name in &look.black {
        let (name, [red, green, blue]) = (Value::from(name.as_str()), CLAY);
        let _ = write!(
            text,
            "\n# In its file this material is black.\n[[material]]\nname = {name}\nkd = [{red}, {green}, {blue}]\n"
        );
    }
    text
}

/// Settings and a camera that goes once around.
pub(in crate::scene) fn around(fit: &Fit, [width, height]: [u32; 2]) -> String {
    let size = fit.size;
    let [x, y, z] = fit.target.to_array().map(|coordinate| number(coordinate, size));
    let (target, distance) = (format!("[{x}, {y}, {z}]"), number(fit.distance, size));
    let eye = vector(on_orbit(fit.target, DVec3::new(0.0, fit.elevation, fit.distance)), size);
    format!(
        "
[render]
size = [{width}, {height}]      # pixels
samples = 2             # 2 x 2 samples a pixel
frames = \"1-{FRAMES}\"
rate = 24               # frames a second

# [output]
# path = \"out/name.####.exr\"

# The camera goes once around the model, which is {across} units across and fills the picture.
# `orbit`: degrees around the target (0: on the side of +Z, 90: of +X), degrees above it, distance from it.
# A camera that stands still: `eye = {eye}` instead of `orbit`, in one key alone.
[[camera.key]]
frame = 1
orbit = [0, {elevation}, {distance}]
target = {target}
fov = {fov}                # vertical

[[camera.key]]
frame = {end}
orbit = [360, {elevation}, {distance}]
target = {target}
",
        across = number(size, size),
        elevation = fit.elevation,
        fov = fit.fov,
        end = FRAMES + 1,
    )
}

/// A floor below the model.
pub(in crate::scene) fn floor(fit: &Fit) -> String {
    format!("\n[floor]\nheight = {}\ncolor = [0.3, 0.3, 0.3]\n", number(fit.floor, fit.size))
}

fn vector(vector: DVec3, size: f64) -> String {
    let [x, y, z] = vector.to_array().map(|coordinate| number(coordinate, size));
    format!("[{x}, {y}, {z}]")
}

/// Formats a number to a ten-thousandth of `size` or finer, as short as it goes.
pub(crate) fn number(value: f64, size: f64) -> String {
    let digits = (4.0 - size.log10().floor()).clamp(0.0, 60.0) as usize;
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    match text {
        "-0" => String::from("0"),
        // a whole number of the format has 64 bits
        text if !text.contains('.') && text.len() > 15 => format!("{text}.0"),
        text => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_fine_as_the_model() {
        let texts =
            [(1.23456, 1.0), (-0.00001, 1.0), (123_456.7, 5e5), (2e18, 1e18), (1.5e-9, 2e-9), (4.0, 3.0)];
        let texts = texts.map(|(value, size)| number(value, size));
        assert_eq!(texts, ["1.2346", "0", "123457", "2000000000000000000.0", "0.0000000015", "4"]);
    }
}

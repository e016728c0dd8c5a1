//! The table of a camera as text: what `init` writes for the camera of a file, and what tells shots apart.

use toml::Table;

use super::camera::{CameraKey, CameraTable};
use super::table_text::{Digits, Said, Values, keyed, lines, list, number, short, stated, table};
use super::toml_text::At;

impl CameraTable {
    /// Writes the table; `digits`: of the keys' views, that is of `fov` and `height`.
    pub fn text(&self, digits: Digits) -> String {
        let values = self.values();
        let mut text =
            if values.is_empty() { String::new() } else { format!("\n[camera]\n{}", lines(&values)) };
        for key in self.key.iter().map(At::get_ref) {
            text += &format!("\n[[camera.key]]\n{}", lines(&key.values(digits)));
        }
        text
    }

    /// The table, as if its text were read.
    pub fn to_table(&self, digits: Digits) -> Table {
        keyed(self.values(), self.key.iter().map(|key| key.get_ref().to_table(digits)))
    }

    fn values(&self) -> Values {
        // readers know no other file, and leave interpolation to the default
        let Self { from: _, animation: _, projection, interpolation: _, key: _ } = self;
        let projection = projection.and_then(|projection| toml::Value::try_from(projection).ok());
        stated([("projection", projection.map(Said::Value))])
    }
}

impl CameraKey {
    /// The table, as if its text were read.
    pub fn to_table(&self, digits: Digits) -> Table {
        table(self.values(digits))
    }

    fn values(&self, digits: Digits) -> Values {
        let view = |value: &Option<At<f64>>| match digits {
            Digits::Floating => number(value),
            Digits::Short => short(value),
        };
        let is_pinhole = self.aperture.as_ref().is_some_and(|radius| *radius.get_ref() == 0.0);
        stated([
            ("frame", Some(Said::Short(*self.frame.get_ref()))),
            ("eye", list(&self.eye)),
            ("orbit", list(&self.orbit)),
            ("target", list(&self.target)),
            ("rotation", list(&self.rotation)),
            ("roll", short(&self.roll)),
            ("fov", view(&self.fov)),
            ("height", view(&self.height)),
            ("shift", list(&self.shift)),
            ("aperture", if is_pinhole { short(&self.aperture) } else { number(&self.aperture) }),
            ("focus", number(&self.focus)),
            ("near", number(&self.near)),
            ("far", number(&self.far)),
            ("cut", self.cut.then(|| Said::of(true))),
        ])
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use std::path::Path;

    use toml::Value;

    use super::*;
    use crate::scene::keys::ShotFile;
    use crate::scene::keys::toml_text::TomlText;

    const PERSPECTIVE: &str = "
[[camera.key]]
frame = 1
eye = [0.0, -0.0, 8.0]
target = [0.1, 0.0, 1e30]
fov = 90.0
shift = [0.25, 0.0]
aperture = 2.0
focus = 3.0
near = 0.5
far = 1e16

[[camera.key]]
frame = 2.5
eye = [0.0, 1.0, 8.0]
target = [0.0, 0.0, 0.0]
roll = -12
aperture = 0

[[camera.key]]
frame = 3
eye = [0.0, 1.0, 7.0]
rotation = [1.0, 2.0, 3.0]
roll = 0.5
cut = true
";

    const ORTHOGRAPHIC: &str = "
[camera]
projection = \"orthographic\"

[[camera.key]]
frame = -1
orbit = [1.0, 2.0, 3.0]
target = [0.0, 0.0, 0.0]
height = 4

[[camera.key]]
frame = 2
orbit = [1.0, 2.0, 4.0]
target = [0.0, 0.0, 0.0]
height = 0.0000001
";

    /// A table says what its text says, and is written as it was read.
    #[test]
    fn tables_and_texts_are_the_same() {
        for (text, digits) in [(PERSPECTIVE, Digits::Floating), (ORTHOGRAPHIC, Digits::Short)] {
            let file: ShotFile = TomlText { path: Path::new("x"), text }.read().unwrap();
            let camera = file.camera.unwrap().into_inner();
            assert_eq!(camera.text(digits), text);
            let read: Table = toml::from_str(text).unwrap();
            let own = Value::Table(camera.to_table(digits));
            assert_eq!(Table::from_iter([(String::from("camera"), own)]), read);
        }
    }

    #[test]
    fn digits_are_those_that_are_asked_for() {
        let file: ShotFile = TomlText { path: Path::new("x"), text: ORTHOGRAPHIC }.read().unwrap();
        let text = file.camera.unwrap().get_ref().text(Digits::Floating);
        assert!(text.contains("\nheight = 4.0\n") && text.contains("\nheight = 1e-7\n"), "{text}");
        assert!(text.contains("\nframe = 2\n"), "{text}");
    }
}

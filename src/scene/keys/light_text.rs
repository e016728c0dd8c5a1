//! Tables of lights as text: what `init` writes for the lights of a file, and what tells shots apart.

use toml::{Table, Value};

use super::links;
use super::table_text::{Said, Values, keyed, lines, list, number, stated, table, word};
use super::toml_text::At;
use super::{LightKey, LightTable};

impl LightTable {
    /// Writes the table.
    pub fn text(&self) -> String {
        let mut text = format!("\n[[light]]\n{}", lines(&self.values()));
        for key in self.key.iter().map(At::get_ref) {
            text += &format!("[[light.key]]\n{}", lines(&key.values()));
        }
        text
    }

    /// The table, as if its text were read.
    pub fn to_table(&self) -> Table {
        keyed(self.values(), self.key.iter().map(|key| table(key.get_ref().values())))
    }

    fn values(&self) -> Values {
        // readers leave interpolation to the default
        let Self { name, kind, direction, position, target, up, color, power, interpolation: _, .. } = self;
        let Self { cone, soft, fall, size, spread, radius, faces, angle, samples, group, key: _, .. } = self;
        let Self { light_link, shadow_link, .. } = self;
        let head =
            [("name", name.as_deref().map(Said::of)), ("type", Value::try_from(kind).ok().map(Said::Value))];
        let fall = fall.as_ref().and_then(|fall| Value::try_from(fall.get_ref()).ok());
        let shape = [
            ("size", list(size)),
            ("cone", number(cone)),
            ("soft", number(soft)),
            ("fall", fall.map(Said::Value)),
            ("radius", number(radius)),
            ("angle", number(angle)),
            ("spread", number(spread)),
            ("faces", faces.as_ref().map(|faces| Said::of(*faces.get_ref()))),
            ("samples", samples.as_ref().map(|samples| Said::of(*samples.get_ref()))),
            ("group", word(group)),
            ("light_link", links::value(light_link)),
            ("shadow_link", links::value(shadow_link)),
        ];
        let place = [
            ("color", list(color)),
            ("power", number(power)),
            ("direction", list(direction)),
            ("position", list(position)),
            ("target", list(target)),
            ("up", list(up)),
        ];
        stated(head.into_iter().chain(shape).chain(place))
    }
}

impl LightKey {
    fn values(&self) -> Values {
        stated([
            ("frame", Some(Said::of(*self.frame.get_ref()))),
            ("size", list(&self.size)),
            ("cone", number(&self.cone)),
            ("soft", number(&self.soft)),
            ("radius", number(&self.radius)),
            ("angle", number(&self.angle)),
            ("spread", number(&self.spread)),
            ("color", list(&self.color)),
            ("power", number(&self.power)),
            ("direction", list(&self.direction)),
            ("position", list(&self.position)),
            ("target", list(&self.target)),
            ("up", list(&self.up)),
        ])
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use std::path::Path;

    use super::*;
    use crate::scene::keys::ShotFile;
    use crate::scene::keys::toml_text::TomlText;

    const LIGHTS: &str = "
[[light]]
name = 'a \"lamp\"'
type = \"spot\"
cone = 0.1
soft = 0.5
fall = \"square\"
radius = 1e-7
color = [1.0, 0.25, 1e30]
power = 2.0
position = [0.0, -0.0, 1.5]
target = [1.0, 2.0, 3.0]

[[light]]
name = \"sky\"
type = \"disk\"
size = [1.0, 2.0]
spread = 20.0
samples = 4
group = \"back\"
light_link = { exclude = [\"c\"], include = [\"a\", \"b\"] }
shadow_link = { exclude = [\"d\"] }
[[light.key]]
frame = 1.0
color = [1.0, 1.0, 1.0]
power = 0.5
position = [0.0, 0.0, 0.0]
target = [0.0, 0.0, 1.0]
up = [0.0, 1.0, 0.0]
[[light.key]]
frame = 2.5
power = 1.0
";

    /// A table says what its text says, and is written as it was read.
    #[test]
    fn tables_and_texts_are_the_same() {
        let file: ShotFile = TomlText { path: Path::new("x"), text: LIGHTS }.read().unwrap();
        let lights: Vec<&LightTable> = file.light.iter().map(At::get_ref).collect();
        assert_eq!(lights.iter().map(|light| light.text()).collect::<String>(), LIGHTS);
        let read: Table = toml::from_str(LIGHTS).unwrap();
        let own = lights.iter().map(|light| Value::Table(light.to_table())).collect();
        assert_eq!(Table::from_iter([(String::from("light"), Value::Array(own))]), read);
    }
}

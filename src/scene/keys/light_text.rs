//! Tables of lights as text: what `init` writes for the lights of a file, and what tells shots apart.

use std::fmt::Write;

use toml::{Table, Value};

use super::toml_text::{At, List};
use super::{LightKey, LightTable};

/// Keys with their values, in the order in which they are written.
type Values = Vec<(&'static str, Value)>;

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
        let mut table = table(self.values());
        let keys = || self.key.iter().map(|key| Value::Table(self::table(key.get_ref().values()))).collect();
        if !self.key.is_empty() {
            table.insert(String::from("key"), Value::Array(keys()));
        }
        table
    }

    fn values(&self) -> Values {
        // readers leave interpolation to the default
        let Self { name, kind, direction, position, target, up, color, power, interpolation: _, .. } = self;
        let Self { cone, soft, fall, size, spread, radius, faces, angle, samples, group, key: _, .. } = self;
        let head = [("name", name.clone().map(Value::from)), ("type", Value::try_from(kind).ok())];
        let shape = [
            ("size", list(size)),
            ("cone", number(cone)),
            ("soft", number(soft)),
            ("fall", fall.as_ref().and_then(|fall| Value::try_from(fall.get_ref()).ok())),
            ("radius", number(radius)),
            ("angle", number(angle)),
            ("spread", number(spread)),
            ("faces", faces.as_ref().map(|faces| Value::from(*faces.get_ref()))),
            ("samples", samples.as_ref().map(|samples| Value::from(*samples.get_ref()))),
            ("group", group.as_ref().map(|group| Value::from(group.get_ref().as_str()))),
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
            ("frame", Some(Value::from(*self.frame.get_ref()))),
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

fn stated(all: impl IntoIterator<Item = (&'static str, Option<Value>)>) -> Values {
    all.into_iter().filter_map(|(key, value)| Some((key, value?))).collect()
}

fn number(value: &Option<At<f64>>) -> Option<Value> {
    value.as_ref().map(|value| Value::from(*value.get_ref()))
}

fn list<const N: usize>(value: &Option<At<List<f64, N>>>) -> Option<Value> {
    value.as_ref().map(|value| Value::from(value.get_ref().0.to_vec()))
}

fn table(values: Values) -> Table {
    values.into_iter().map(|(key, value)| (String::from(key), value)).collect()
}

fn lines(values: &Values) -> String {
    let mut text = String::new();
    for (key, value) in values {
        // a write to a string does not fail
        let _ = writeln!(text, "{key} = {}", shown(value));
    }
    text
}

/// Text of a value: numbers with all of their digits, and none more.
fn shown(value: &Value) -> String {
    match value {
        Value::Float(number) => format!("{number:?}"),
        Value::Array(list) => format!("[{}]", list.iter().map(shown).collect::<Vec<_>>().join(", ")),
        _ => value.to_string(),
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

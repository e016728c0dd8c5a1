//! What a glTF or USD file says of its picture, as the tables that a shot file has for it. Readers make them; they are a shot as they
//! are, and `init` writes them as text.

use toml::{Table, Value};

use super::camera::{CameraTable, ShutterTable};
use super::samples::SamplesValue;
use super::table_text::{Digits, Said, Values, lines, list, number, stated, table, whole, word};
use super::toml_text::At;
use super::{BackgroundTable, EnvironmentTable, LightTable, Rate, RenderTable, ShotFile};

/// Tables of a shot that come from a file which it shows.
#[derive(Default)]
pub(crate) struct FileTables {
    pub render: Option<RenderTable>,
    pub shutter: Option<ShutterTable>,
    pub camera: Option<CameraTable>,
    /// Digits of the camera's view, where it is written.
    pub digits: Digits,
    pub lights: Vec<LightTable>,
    pub background: Option<BackgroundTable>,
    pub environment: Option<EnvironmentTable>,
}

impl FileTables {
    /// Writes the tables of the picture and its camera.
    pub fn text_of_view(&self) -> String {
        let Self { render, shutter, camera, digits, .. } = self;
        let settings = [
            ("render", render.as_ref().map(values_of_render)),
            ("shutter", shutter.as_ref().map(values_of_shutter)),
        ];
        text_of(settings) + &camera.as_ref().map_or(String::new(), |camera| camera.text(*digits))
    }

    /// Writes the tables of all that gives light.
    pub fn text_of_light(&self) -> String {
        let lights: String = self.lights.iter().map(LightTable::text).collect();
        lights + &text_of(self.surroundings())
    }

    /// Adds them to a shot file: lights behind its own, all others in place of its own.
    pub fn add_to(self, file: &mut ShotFile) {
        let Self { render, shutter, camera, digits: _, lights, background, environment } = self;
        if let Some(render) = render {
            file.render = render;
        }
        file.shutter = shutter.map(At::of).or(file.shutter.take());
        file.camera = camera.map(At::of).or(file.camera.take());
        file.light.extend(lights.into_iter().map(At::of));
        file.background = background.or(file.background.take());
        file.environment = environment.map(At::of).or(file.environment.take());
    }

    /// Adds them to the statements of a shot file, as [`Self::add_to`] does, without those that are settings of a render.
    pub fn add_to_statements(&self, file: &mut Table) {
        if !self.lights.is_empty()
            && let Value::Array(all) = file.entry("light").or_insert_with(|| Value::Array(Vec::new()))
        {
            all.extend(self.lights.iter().map(|light| Value::Table(light.to_table())));
        }
        let camera = self.camera.as_ref().map(|camera| camera.to_table(self.digits));
        let surroundings = self.surroundings().map(|(name, values)| (name, values.map(table)));
        let single = surroundings.into_iter().chain([("camera", camera)]);
        file.extend(single.filter_map(|(name, table)| Some((String::from(name), Value::Table(table?)))));
    }

    /// Values of what is all around, by the names of their tables.
    fn surroundings(&self) -> [(&'static str, Option<Values>); 2] {
        [
            ("background", self.background.as_ref().map(values_of_background)),
            ("environment", self.environment.as_ref().map(values_of_environment)),
        ]
    }
}

/// Writes those tables that are there.
fn text_of(tables: [(&str, Option<Values>); 2]) -> String {
    let text = |(name, values): (&str, Option<Values>)| Some(format!("\n[{name}]\n{}", lines(&values?)));
    tables.into_iter().filter_map(text).collect()
}

/// Values that readers state: all others are left to the default.
fn values_of_render(table: &RenderTable) -> Values {
    let size = |sides: &[At<i64>]| sides.iter().map(|side| *side.get_ref()).collect::<Vec<i64>>();
    let samples = table.samples.as_ref().and_then(|samples| match samples.get_ref() {
        SamplesValue::Fixed(count) => Some(Said::of(*count)),
        SamplesValue::Adaptive(_) => None,
    });
    let rate = table.rate.as_ref().map(|rate| match rate.get_ref() {
        Rate::Whole(rate) => Said::of(*rate),
        Rate::Text(rate) => Said::of(rate.as_str()),
    });
    stated([
        ("size", table.size.as_ref().map(|sides| Said::of(size(&sides.0)))),
        ("samples", samples),
        ("frames", word(&table.frames)),
        ("rate", rate),
    ])
}

fn values_of_shutter(table: &ShutterTable) -> Values {
    // readers state no curve
    let ShutterTable { open, close, curve: _ } = table;
    stated([("open", number(open)), ("close", number(close))])
}

fn values_of_background(table: &BackgroundTable) -> Values {
    let BackgroundTable { color, zenith, horizon, ground } = table;
    stated([
        ("color", list(color)),
        ("zenith", list(zenith)),
        ("horizon", list(horizon)),
        ("ground", list(ground)),
    ])
}

fn values_of_environment(table: &EnvironmentTable) -> Values {
    // no file has a sky of ours
    let EnvironmentTable { map, sky: _, rotation, power, visible, samples, light_group } = table;
    stated([
        ("map", word(map)),
        ("rotation", number(rotation)),
        ("power", number(power)),
        ("visible", visible.map(Said::of)),
        ("samples", whole(samples)),
        ("light_group", word(light_group)),
    ])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use std::path::Path;

    use super::*;
    use crate::scene::keys::toml_text::TomlText;

    const VIEW: &str = "
[render]
size = [1440, 720]
samples = 2
frames = \"1-13\"
rate = \"24000/1001\"

[shutter]
open = -0.25
close = 0.0

[[camera.key]]
frame = 1
eye = [0.0, 0.0, 8.0]
target = [0.0, 0.0, 0.0]
";

    const LIGHT: &str = "
[[light]]
type = \"point\"
power = 2.0
position = [0.0, 0.0, 1.5]

[background]
color = [2.0, 1.0, 0.5]

[environment]
map = 'a \"map\".exr'
rotation = 270.0
power = 0.5
";

    fn read(text: &str) -> ShotFile {
        TomlText { path: Path::new("x"), text }.read().unwrap()
    }

    fn tables() -> FileTables {
        let file = read(&format!("{VIEW}{LIGHT}"));
        FileTables {
            render: Some(file.render),
            shutter: file.shutter.map(At::into_inner),
            camera: file.camera.map(At::into_inner),
            digits: Digits::default(),
            lights: file.light.into_iter().map(At::into_inner).collect(),
            background: file.background,
            environment: file.environment.map(At::into_inner),
        }
    }

    /// Tables say what their text says, and are written as they were read.
    #[test]
    fn tables_and_texts_are_the_same() {
        assert_eq!(tables().text_of_view(), VIEW);
        assert_eq!(tables().text_of_light(), LIGHT);
        let mut wanted: Table = toml::from_str(&format!("{VIEW}{LIGHT}")).unwrap();
        for settings in ["render", "shutter"] {
            wanted.remove(settings);
        }
        let mut own = Table::new();
        tables().add_to_statements(&mut own);
        assert_eq!(own, wanted);
    }

    #[test]
    fn an_environment_that_is_the_background_has_no_values() {
        let text = "\n[background]\ncolor = [1.0, 1.0, 1.0]\n\n[environment]\n";
        let file = read(text);
        let environment = file.environment.map(At::into_inner);
        let tables = FileTables { background: file.background, environment, ..FileTables::default() };
        assert_eq!(tables.text_of_light(), text);
        let mut own = Table::new();
        tables.add_to_statements(&mut own);
        let wanted: Table = toml::from_str(text).unwrap();
        assert_eq!(own, wanted);
    }

    #[test]
    fn a_shot_file_has_them_beside_its_lights() {
        let mut file =
            read("[render]\nsize = [1, 1]\n[[light]]\ntype = \"directional\"\n[output]\nlayers = []\n");
        tables().add_to(&mut file);
        assert_eq!(file.render.size.as_ref().unwrap().0.each_ref().map(|side| *side.get_ref()), [1440, 720]);
        assert!(file.camera.is_some() && file.shutter.is_some() && file.environment.is_some());
        assert_eq!((file.light.len(), file.output.layers.as_ref().map(Vec::len)), (2, Some(0)));
        FileTables::default().add_to(&mut file);
        assert!(file.camera.is_some() && file.background.is_some() && file.light.len() == 2);
    }
}

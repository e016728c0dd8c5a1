//! Does the JSON schema take what the program takes, and does it hold every key that the documentation lists?

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use serde_json::Value;

static SCHEMA: LazyLock<Value> = LazyLock::new(|| {
    let output = Command::new(env!("CARGO_BIN_EXE_afterimage")).arg("schema").output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty());
    serde_json::from_slice(&output.stdout).unwrap()
});

/// What a schema may say beside what it demands.
const NOTES: [&str; 6] = ["$schema", "title", "description", "default", "format", "definitions"];

/// Why `value` is not what `schema` demands, if it is not. Knows the words that our schema uses, and no others.
fn fault(schema: &Value, value: &Value, at: &str) -> Option<String> {
    let Value::Object(words) = schema else {
        return (*schema != true).then(|| format!("{at}: nothing may be here"));
    };
    words.iter().find_map(|(word, wanted)| {
        let wrong = |fits: bool| (!fits).then(|| format!("{at}: {word} {wanted}, not {value}"));
        let bound = || wanted.as_f64().unwrap();
        match word.as_str() {
            word if NOTES.contains(&word) => None,
            "$ref" => {
                let name = wanted.as_str().unwrap().strip_prefix('#').unwrap();
                fault(SCHEMA.pointer(name).unwrap(), value, at)
            }
            "type" => wrong(is_of_type(wanted.as_str().unwrap(), value)),
            "enum" => wrong(wanted.as_array().unwrap().contains(value)),
            "const" => wrong(wanted == value),
            "minimum" => wrong(value.as_f64().is_none_or(|number| number >= bound())),
            "maximum" => wrong(value.as_f64().is_none_or(|number| number <= bound())),
            "exclusiveMinimum" => wrong(value.as_f64().is_none_or(|number| number > bound())),
            "exclusiveMaximum" => wrong(value.as_f64().is_none_or(|number| number < bound())),
            "minItems" => wrong(value.as_array().is_none_or(|list| list.len() >= bound() as usize)),
            "maxItems" => wrong(value.as_array().is_none_or(|list| list.len() <= bound() as usize)),
            // of rates and budgets
            "pattern" => wrong(value.as_str().is_none_or(|text| {
                let figures =
                    |text: &str| !text.trim().is_empty() && text.trim().bytes().all(|b| b.is_ascii_digit());
                match wanted.as_str().unwrap() {
                    "^(full|[0-9]+)$" => text == "full" || figures(text),
                    "^ *[0-9]+ *(/ *[0-9]+ *)?$" => text.splitn(2, '/').all(figures),
                    other => panic!("a new pattern: {other}"),
                }
            })),
            "items" => value.as_array().and_then(|list| {
                list.iter().enumerate().find_map(|(i, item)| fault(wanted, item, &format!("{at}[{i}]")))
            }),
            "required" => {
                let has = |key: &Value| value.get(key.as_str().unwrap()).is_some();
                wrong(!value.is_object() || wanted.as_array().unwrap().iter().all(has))
            }
            "properties" => value.as_object().and_then(|table| {
                let known = |key: &str| wanted.get(key);
                table.iter().find_map(|(key, value)| fault(known(key)?, value, &format!("{at}.{key}")))
            }),
            "additionalProperties" => {
                assert_eq!(wanted, false);
                let known = words.get("properties").and_then(Value::as_object);
                let is_known = |key: &String| known.is_some_and(|known| known.contains_key(key));
                wrong(value.as_object().is_none_or(|table| table.keys().all(is_known)))
            }
            "anyOf" | "oneOf" => {
                let fits = |one: &&Value| fault(one, value, at).is_none();
                let count = wanted.as_array().unwrap().iter().filter(fits).count();
                wrong(if word == "anyOf" { count > 0 } else { count == 1 })
            }
            "allOf" => wanted.as_array().unwrap().iter().find_map(|one| fault(one, value, at)),
            other => panic!("the schema uses `{other}`, which this test does not know"),
        }
    })
}

fn is_of_type(kind: &str, value: &Value) -> bool {
    match kind {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_i64() || value.is_u64(),
        "number" => value.is_number(),
        other => panic!("a type that TOML does not have: {other}"),
    }
}

fn fault_of(text: &str) -> Option<String> {
    let shot: toml::Table = toml::from_str(text).unwrap();
    fault(&SCHEMA, &serde_json::to_value(shot).unwrap(), "shot")
}

fn shots() -> Vec<PathBuf> {
    let folders = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").read_dir().unwrap();
    let folders = folders.map(|folder| folder.unwrap().path()).filter(|folder| folder.is_dir());
    let files = folders.flat_map(|folder| folder.read_dir().unwrap().map(|file| file.unwrap().path()));
    files.filter(|file| file.extension().is_some_and(|ending| ending == "toml")).collect()
}

#[test]
fn the_schema_takes_every_shot_that_is_shipped() {
    let shots = shots();
    assert!(shots.len() >= 6, "{shots:?}");
    for shot in shots {
        assert_eq!(fault_of(&std::fs::read_to_string(&shot).unwrap()), None, "{}", shot.display());
    }
}

const SHOT: &str = "[[camera.key]]\nframe = 1\neye = [0, 0, 1.5]\n[[model]]\nobj = \"a.obj\"\n";

#[test]
fn the_schema_takes_what_may_be_written_in_several_ways() {
    for more in [
        "scale = 2",
        "scale = [1, 2.5, 3]",
        "matrix = [[1, 0, 0, 0], [0, 1.5, 0, 0], [0, 0, 1, 0]]\nvisible = false",
        "[[model.key]]\nframe = 2\nmatrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\nvisible = true",
        "[render]\nrate = 24",
        "[render]\nrate = \"24000/1001\"",
        "[indirect]\nbudget = \"full\"",
        "[indirect]\nbudget = 100000",
        "[occlusion]\nradius = 1e-3\nrays = 256\n[ambient]\noccluded = true",
        "[environment]\nsky = { elevation = -6 }",
        "[floor]\ncolor = [0.2, 0.3, 0.4]\n[[camera.key]]\nframe = 2\norbit = [0, 10, 2]",
        "[output]\nlayers = [\"Z\", \"denoise_albedo\"]",
        "[[light]]\ntype = \"sphere\"\n[[light.key]]\nframe = 1.5",
    ] {
        assert_eq!(fault_of(&format!("{SHOT}{more}\n")), None, "{more}");
    }
}

#[test]
fn the_schema_refuses_what_the_program_refuses() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    for (more, place) in [
        ("colour = 1", "shot.model[0]"),
        ("scale = \"big\"", "shot.model[0].scale"),
        ("scale = [1, 2]", "shot.model[0].scale"),
        ("visible = 1", "shot.model[0].visible"),
        ("shapes = { obj = \"a.#.obj\", every = 0 }", "shot.model[0].shapes.every"),
        ("shapes = {}", "shot.model[0].shapes"),
        ("reflection_map = 4", "shot.model[0].reflection_map"),
        ("reflection_map = 2000", "shot.model[0].reflection_map"),
        ("matrix = [[1, 0, 0, 0], [0, 1, 0, 0]]", "shot.model[0].matrix"),
        ("matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1]]", "shot.model[0].matrix[2]"),
        ("[render]\nsamples = 17", "shot.render.samples"),
        ("[render]\nsamples = 1.5", "shot.render.samples"),
        ("[render]\nsize = [1280]", "shot.render.size"),
        ("[render]\noverscan = -1", "shot.render.overscan"),
        ("[render]\noverscan = 20000", "shot.render.overscan"),
        (
            "[[camera.key]]\nframe = 2\neye = [0, 0, 1]\ntarget = [0, 0, 0]\nshift = [0, 101]",
            "shot.camera.key[1].shift[1]",
        ),
        (
            "[[camera.key]]\nframe = 2\neye = [0, 0, 1]\ntarget = [0, 0, 0]\nheight = 0",
            "shot.camera.key[1].height",
        ),
        ("[render]\nsize = [0, 4]", "shot.render.size[0]"),
        ("[render]\nfilter = \"gauss\"", "shot.render.filter"),
        ("[render]\nrate = \"fast\"", "shot.render.rate"),
        ("[indirect]\nbudget = \"half\"", "shot.indirect.budget"),
        ("[indirect]\npaths = 2000", "shot.indirect.paths"),
        ("[occlusion]\nradius = 0", "shot.occlusion.radius"),
        ("[occlusion]\nrays = 257", "shot.occlusion.rays"),
        ("[environment]\nsky = { turbidity = 1 }", "shot.environment.sky.turbidity"),
        ("[output]\nlayers = [\"far\"]", "shot.output.layers[0]"),
        ("[[light]]\ntype = \"laser\"", "shot.light[0].type"),
        ("[[light]]\ntype = \"spot\"\ncone = 180", "shot.light[0].cone"),
        ("[[light]]\ntype = \"sphere\"\nposition = [0, 1, 0]\nsamples = 2", "shot.light[0].samples"),
        ("[[material]]\nname = \"m\"\npr = 2", "shot.material[0].pr"),
        ("[[camera.key]]\nframe = 2", "shot.camera.key[1]"),
    ] {
        let text = format!("{SHOT}{more}\n");
        let fault = fault_of(&text).unwrap_or_else(|| panic!("{more}"));
        assert!(fault.starts_with(&format!("{place}:")), "{more}: {fault}");
        let path = folder.path().join("s.toml");
        std::fs::write(&path, text).unwrap();
        assert!(afterimage::scene::load(&path, false).is_err(), "{more}");
    }
    for text in ["", "[camera]\n[[model]]\nobj = \"a\"", "[[camera.key]]\nframe = 1\neye = [0, 0, 1]"] {
        assert!(fault_of(text).is_some(), "{text}");
    }
}

/// Keys as `table.key` that the documentation of shot files lists.
fn documented() -> BTreeSet<String> {
    let page = include_str!("../../docs/shot-files.md");
    let keys = page.split("\n## Keys\n").nth(1).unwrap().split("\n## ").next().unwrap();
    let mut tables: Vec<String> = vec![String::new()];
    let mut found = BTreeSet::new();
    for line in keys.lines() {
        let line = line.trim_start_matches("### ");
        if line.starts_with("`[") {
            let names = line.split('`').skip(1).step_by(2).filter(|name| name.starts_with('['));
            tables = names.map(|name| name.trim_matches(['[', ']']).to_owned()).collect();
        } else if line == "File" {
            tables = vec![String::new()];
        } else if let Some(row) = line.strip_prefix("| `") {
            let first = row.split(" | ").next().unwrap();
            let names = first.split('`').step_by(2).filter(|name| !name.is_empty());
            found.extend(names.flat_map(|name| tables.iter().map(move |table| format!("{table}.{name}"))));
        }
    }
    found
}

/// Keys as `table.key` of the schema, but for tables.
fn in_schema(schema: &Value, table: &str, found: &mut BTreeSet<String>) {
    let Some(properties) = schema.get("properties").and_then(Value::as_object) else { return };
    for (key, value) in properties {
        let value = resolved(value);
        let path = if table.is_empty() { key.clone() } else { format!("{table}.{key}") };
        if value.get("properties").is_some() {
            in_schema(value, &path, found);
        } else if let Some(items) =
            value.get("items").map(resolved).filter(|items| items.get("properties").is_some())
        {
            in_schema(items, &path, found);
        } else {
            found.insert(format!("{table}.{key}"));
        }
    }
}

/// What a schema says, whether by a reference or not.
fn resolved(schema: &Value) -> &Value {
    let alone = |word: &str| schema.get(word).and_then(Value::as_array).filter(|list| list.len() == 1);
    let reference = schema.get("$ref").and_then(Value::as_str);
    match (reference, alone("anyOf").or_else(|| alone("allOf"))) {
        (Some(name), _) => SCHEMA.pointer(name.strip_prefix('#').unwrap()).unwrap(),
        (None, Some(list)) => resolved(&list[0]),
        (None, None) => schema,
    }
}

#[test]
fn the_schema_and_the_documentation_have_the_same_keys() {
    let mut schema = BTreeSet::new();
    in_schema(&SCHEMA, "", &mut schema);
    let mut documented = documented();
    // the page names the tables of the sky and of links as keys as well
    for table in
        ["environment.sky", "light.light_link", "light.shadow_link", "model.light_link", "model.shadow_link"]
    {
        assert!(documented.remove(table), "{table}");
    }
    assert!(schema.len() > 80, "{schema:?}");
    let only = |a: &BTreeSet<String>, b: &BTreeSet<String>| a.difference(b).cloned().collect::<Vec<_>>();
    assert_eq!((only(&schema, &documented), only(&documented, &schema)), (vec![], vec![]));
}

#[test]
fn every_key_says_what_it_is() {
    fn check(schema: &Value, table: &str) {
        for (key, value) in schema.get("properties").and_then(Value::as_object).into_iter().flatten() {
            let path = format!("{table}.{key}");
            assert!(value["description"].as_str().is_some_and(|text| text.len() > 5), "{path}: {value}");
        }
    }
    check(&SCHEMA, "");
    let definitions = SCHEMA["definitions"].as_object().unwrap();
    definitions.iter().for_each(|(name, definition)| check(definition, name));
}

//! Open Job Description, specification 2023-09: a template, and with it the other files of a job bundle of AWS Deadline Cloud.

use std::fmt::Write;

use serde_json::Value;

use super::{File, Plan};

/// Maximum number of characters of a job's name.
const LONGEST_NAME: usize = 128;

/// Files of a job bundle.
pub fn files(plan: &Plan) -> Vec<File> {
    let file = |name: &str, text| File { name: name.to_owned(), text, is_script: false };
    vec![
        file("template.yaml", template(plan)),
        file("parameter_values.yaml", parameter_values(plan)),
        file("parameters.json", parameters(plan)),
        file("asset_references.yaml", asset_references(plan)),
    ]
}

/// Command that gives the bundle to Deadline Cloud.
pub fn submission(plan: &Plan) -> Vec<String> {
    let folder = plan.output.display().to_string();
    ["deadline", "bundle", "submit"].map(String::from).into_iter().chain([folder]).collect()
}

/// A text as YAML, which takes all of JSON's.
fn text(text: &str) -> String {
    Value::from(text).to_string()
}

/// A text that is no expression of the template: `{{` begins one, and an empty string cannot be written otherwise.
fn literal(word: &str) -> String {
    text(&word.replace("{{", "{ {"))
}

fn list(words: impl Iterator<Item = String>) -> String {
    format!("[{}]", words.collect::<Vec<_>>().join(", "))
}

fn template(plan: &Plan) -> String {
    const SHOT: &str = "{{Param.Shot}}";
    const FILES: &str = "{{Param.FramesFolder}}/{{Param.FrameNames}}";
    let words = |all: Vec<String>| {
        list(all.into_iter().map(|word| {
            let is_ours = [SHOT, FILES, "{{Task.Param.Frames}}"].contains(&word.as_str());
            if is_ours { text(&word) } else { literal(&word) }
        }))
    };
    let mut render = plan.render(SHOT, FILES);
    render.extend(["--progress", "openjd", "--frames", "{{Task.Param.Frames}}"].map(String::from));
    let name: String = plan.name.chars().take(LONGEST_NAME).collect();
    let chunks = list(plan.chunks.iter().map(|chunk| text(&chunk.frames.to_string())));
    format!(
        r#"specificationVersion: jobtemplate-2023-09
name: {name}
parameterDefinitions:
- name: Shot
  type: PATH
  objectType: FILE
  dataFlow: IN
  description: The shot, or the model, that is rendered.
- name: FramesFolder
  type: PATH
  objectType: DIRECTORY
  dataFlow: OUT
  description: Folder of the frames.
- name: FrameNames
  type: STRING
  default: {names}
  description: Names of the frames, with a number sign for each digit.
- name: Program
  type: STRING
  default: {program}
  description: Afterimage on the machines of the farm.
steps:
- name: Render
  parameterSpace:
    taskParameterDefinitions:
    - name: Frames
      type: STRING
      range: {chunks}
  hostRequirements:
    amounts:
    - name: amount.worker.vcpu
      min: {threads}
    - name: amount.worker.memory
      min: {memory}
    attributes:
    - name: attr.worker.os.family
      anyOf: [linux]
  script:
    actions:
      onRun:
        command: "{{{{Param.Program}}}}"
        args: {render}
        cancelation:
          mode: NOTIFY_THEN_TERMINATE
- name: Verify
  dependencies:
  - dependsOn: Render
  script:
    actions:
      onRun:
        command: "{{{{Param.Program}}}}"
        args: {verify}
"#,
        name = text(&name),
        names = text(&plan.names),
        program = text(&plan.program),
        threads = plan.threads,
        memory = plan.memory,
        render = words(render),
        verify = words(plan.verify(SHOT, FILES)),
    )
}

/// Parameters that have no default: one of a path must be relative to the template (2023-09, "default" of a PATH parameter).
fn paths(plan: &Plan) -> [(&str, String); 2] {
    [("Shot", plan.shot.display().to_string()), ("FramesFolder", plan.folder.display().to_string())]
}

/// Values of parameters, for `openjd run`.
fn parameters(plan: &Plan) -> String {
    let values: serde_json::Map<String, Value> =
        paths(plan).into_iter().map(|(name, path)| (name.to_owned(), path.into())).collect();
    format!("{}\n", Value::Object(values))
}

/// Values of parameters, for Deadline Cloud.
fn parameter_values(plan: &Plan) -> String {
    let mut values = String::from(
        "parameterValues:\n\
         - name: \"deadline:priority\"\n  value: 50\n\
         - name: \"deadline:targetTaskRunStatus\"\n  value: READY\n\
         - name: \"deadline:maxFailedTasksCount\"\n  value: 20\n\
         - name: \"deadline:maxRetriesPerTask\"\n  value: 5\n",
    );
    for (name, path) in paths(plan) {
        let _ = writeln!(values, "- name: {name}\n  value: {}", text(&path));
    }
    values
}

fn asset_references(plan: &Plan) -> String {
    let path = |path: &std::path::PathBuf| format!("    - {}\n", text(&path.display().to_string()));
    let mut inputs: Vec<_> = plan.inputs.iter().chain([&plan.shot]).collect();
    inputs.sort_unstable();
    inputs.dedup();
    format!(
        "assetReferences:\n  inputs:\n    filenames:\n{}    directories: []\n  outputs:\n    directories:\n{}  referencedPaths: []\n",
        inputs.into_iter().map(path).collect::<String>(),
        path(&plan.folder),
    )
}

//! Two commits in turn: is a frame as fast as it was before a change?
//!
//! The other commit is built beside this one, in `target/guard`, and both run their own `cargo bench --bench shots` on the same
//! rows, one after the other, in alternating order. A machine that becomes slower for a while slows both; of each number the
//! fastest round counts.

use std::collections::BTreeMap;
use std::error::Error;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use afterimage::layers::Layers;
use clap::ValueEnum;
use serde_json::Value;

use super::kinds::{Kind, Lights};
use super::places::SceneName;
use super::{Arguments, folder};

/// Kinds that are compared unless the command line says otherwise: before a camera at rest, one that turns,
/// one that travels.
const KINDS: [Kind; 3] = [Kind::Object, Kind::Pan, Kind::Dolly];

/// Lights with which they are compared.
const LIGHTS: [Lights; 3] = [Lights::Points(1), Lights::Points(8), Lights::Soft];

/// Ways to make a frame that both commits measure.
const CONTESTANTS: [&str; 3] = ["raw", "full", "reproj"];

type Failable<T> = Result<T, Box<dyn Error>>;

/// Seconds a frame by row and contestant.
type Costs = BTreeMap<(usize, String), [f64; CONTESTANTS.len()]>;

/// A commit that is measured.
struct Program {
    name: String,
    /// Path of its benchmark.
    executable: PathBuf,
    /// Folder for its output.
    target: PathBuf,
    fastest: Costs,
}

/// Compares the program that runs with `commit`; prints a table.
pub fn run(arguments: &Arguments, commit: &str) -> Failable<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let place = std::path::absolute(folder())?.with_file_name("guard");
    fs::create_dir_all(&place)?;
    let (name, executable) = build(root, &place, commit)?;
    let program = |name: String, executable| Program {
        target: place.join(&name).join("target"),
        name,
        executable,
        fastest: Costs::new(),
    };
    let mut programs = [program(name, executable), program("this".into(), std::env::current_exe()?)];
    let options = options(arguments);
    println!("cargo bench --bench shots -- {}", options.join(" "));
    for round in 0..arguments.rounds() as usize {
        for turn in 0..programs.len() {
            let number = (turn + round) % programs.len();
            programs[number].measure(&options)?;
        }
    }
    print(&programs);
    Ok(())
}

/// Builds the benchmark of `commit` of the repository at `root`, in a worktree in `place`. Returns its short
/// name, and the program.
fn build(root: &Path, place: &Path, commit: &str) -> Failable<(String, PathBuf)> {
    let git = |arguments: &[&OsStr]| output(Command::new("git").current_dir(root).args(arguments));
    let full = format!("{commit}^{{commit}}");
    let name = git(&["rev-parse", "--short=10", &full].map(OsStr::new))?.trim().to_owned();
    let tree = place.join(&name).join("tree");
    if !tree.join("Cargo.toml").is_file() {
        git(&["worktree", "prune"].map(OsStr::new))?;
        let add = ["worktree", "add", "--detach"].map(OsStr::new);
        git(&[add.as_slice(), &[tree.as_os_str(), name.as_ref()]].concat())?;
    }
    eprintln!("guard: building {name}");
    let mut cargo = Command::new(root.join("scripts/cargo"));
    cargo
        .args(["bench", "--bench", "shots", "--no-run", "--locked", "--message-format=json"])
        .current_dir(&tree)
        // the libraries that both have in common are built once, whatever is compared
        .env("CARGO_TARGET_DIR", place.join("target"));
    let embree = root.join(".deps/embree");
    if std::env::var_os("EMBREE_DIR").is_none() && embree.is_dir() {
        cargo.env("EMBREE_DIR", embree);
    }
    let built = output(&mut cargo)?;
    let message = |line: &str| serde_json::from_str::<Value>(line).ok();
    let executable = |message: Value| {
        let is_it = message["target"]["name"] == "shots";
        message["executable"].as_str().filter(|_| is_it).map(PathBuf::from)
    };
    let found = built.lines().filter_map(message).find_map(executable);
    Ok((name, found.ok_or("cargo named no benchmark `shots`")?))
}

/// Returns the output of `command`; its messages are shown.
fn output(command: &mut Command) -> Failable<String> {
    let done = command.stderr(Stdio::inherit()).output().map_err(|error| format!("{command:?}: {error}"))?;
    if !done.status.success() {
        return Err(format!("{command:?} failed: {}", done.status).into());
    }
    Ok(String::from_utf8(done.stdout)?)
}

/// Options that both programs take. Those that `arguments` do not state are stated, since defaults of the
/// other program may differ.
fn options(arguments: &Arguments) -> Vec<String> {
    let scenes = if arguments.scenes.is_empty() {
        &[SceneName::City, SceneName::Kitchen]
    } else {
        arguments.scenes.as_slice()
    };
    let kinds = if arguments.kinds.is_empty() { &KINDS } else { arguments.kinds.as_slice() };
    let lights = if arguments.lights.is_empty() { &LIGHTS } else { arguments.lights.as_slice() };
    let numbers = |numbers: &[u32], default: u32| match numbers {
        [] => default.to_string(),
        all => joined(all.iter().map(u32::to_string)),
    };
    let [width, height] = arguments.size();
    let layers = joined(arguments.layers.unwrap_or(Layers::NONE).names().map(str::to_owned));
    let layers = if layers.is_empty() { "none".into() } else { layers };
    let name = |value: Option<clap::builder::PossibleValue>| value.map(|value| value.get_name().to_owned());
    [
        ("--scenes", joined(scenes.iter().filter_map(|scene| name(scene.to_possible_value())))),
        ("--kinds", joined(kinds.iter().map(|kind| kind.name()))),
        ("--lights", joined(lights.iter().map(Lights::to_string))),
        ("--samples", numbers(&arguments.samples, 1)),
        ("--depth", numbers(&arguments.depth, 0)),
        ("--size", format!("{width}x{height}")),
        ("--layers", layers),
        ("--frames", arguments.frames().to_string()),
        ("--rounds", "1".into()),
    ]
    .into_iter()
    .flat_map(|(option, value)| [option.to_owned(), value])
    .collect()
}

fn joined(values: impl Iterator<Item = String>) -> String {
    values.collect::<Vec<_>>().join(",")
}

impl Program {
    /// Runs the benchmark once, and keeps the faster numbers.
    fn measure(&mut self, options: &[String]) -> Failable<()> {
        let mut command = Command::new(&self.executable);
        output(command.args(options).arg("--bench").env("CARGO_TARGET_DIR", &self.target))?;
        let file: Value = serde_json::from_slice(&fs::read(self.target.join("bench/shots.json"))?)?;
        for (number, row) in file["rows"].as_array().into_iter().flatten().enumerate() {
            let text = |key: &str| row[key].as_str().map_or_else(|| row[key].to_string(), str::to_owned);
            let name = ["scene", "shot", "lights", "samples", "depth"].map(text).join(" | ");
            let fastest = self.fastest.entry((number, name)).or_insert([f64::INFINITY; CONTESTANTS.len()]);
            for (fastest, contestant) in fastest.iter_mut().zip(CONTESTANTS) {
                let seconds = row["costs"][contestant]["seconds"].as_f64();
                *fastest =
                    fastest.min(seconds.ok_or_else(|| format!("{}: no seconds of {contestant}", self.name))?);
            }
        }
        Ok(())
    }
}

/// Prints milliseconds a frame of both, and the ratio of this program's to the other's. Bare Embree is the
/// same in both: the distance of its ratio from 1 tells the noise of the machine.
fn print([before, now]: &[Program; 2]) {
    println!(
        "| scene | shot | lights | samples | depth |{}",
        CONTESTANTS.map(|who| format!(" {who}: {}, this, ratio |", before.name)).concat()
    );
    println!("|---|---|---|---|---|{}", "---|".repeat(CONTESTANTS.len()));
    for (row, old) in &before.fastest {
        let Some(new) = now.fastest.get(row) else { continue };
        let pair =
            |(old, new): (&f64, &f64)| format!(" {:.1} {:.1} **{:.2}** |", 1e3 * old, 1e3 * new, new / old);
        println!("| {} |{}", row.1, old.iter().zip(new).map(pair).collect::<String>());
    }
}

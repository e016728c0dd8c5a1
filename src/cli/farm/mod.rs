//! `afterimage farm`: what the engines of farms need to render a shot in chunks. On the farm nothing runs but `afterimage render`
//! and `afterimage verify`.

mod chunks;
mod flamenco;
mod openjd;
mod slurm;

use std::ffi::OsStr;
use std::fs::{self, Permissions};
use std::io::ErrorKind;
use std::num::NonZeroU32;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf, absolute};
use std::process::Command;

use clap::{Args, ValueEnum};

use self::chunks::Chunk;
use super::args::{self, Job};
use super::failure::Failure;
use super::info::cost;
use super::quoted;
use super::render;
use super::say::terminal::Terminal;
use crate::memory::{Bytes, Limit, Need, Part};
use crate::output::{self, WriteError};
use crate::scene::frames::Frames;
use crate::settings::Mode;

/// Reciprocal of the share by which the memory asked for is more than what is foreseen: estimates are within a fifth.
const MARGIN: u64 = 5;

/// Number of checkpoints on the way through the longest chunk, unless it is given.
const CHECKPOINTS: usize = 4;

/// Chunks of fewer frames have no checkpoints, unless they are asked for.
const LEAST_CHECKPOINTED: usize = 8;

/// Options of `render` that a job has for itself.
const OWN: [&str; 17] = [
    "--resume",
    "--shared",
    "--handoff",
    "--checkpoint",
    "--save-store",
    "--load-store",
    "--threads",
    "--progress",
    "--stats",
    "--coarse",
    "--contact-sheet",
    "--movie",
    "--audit",
    "-q",
    "--quiet",
    "-h",
    "--help",
];

/// Arguments as typed.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  afterimage farm city.toml --engine slurm --threads 16 -- --samples 4 -o /mnt/out/city/
      writes a job array, and a job that verifies its frames, to farm/city/slurm/
  afterimage farm city.toml --engine slurm --submit
  afterimage farm city.toml --engine openjd -o bundle/
      writes a job bundle: `deadline bundle submit bundle/`, `openjd run bundle/template.yaml -p file://bundle/parameters.json`

What stands after `--` goes to `render`. Chunks are segments, from base frame to base frame: none renders a frame twice. The frames
are those of one run of `render`, to the bit.")]
pub struct FarmArgs {
    /// A shot (TOML), or a model (OBJ, PLY, glTF, USD)
    #[arg(value_name = "SHOT.toml|MODEL")]
    shot: PathBuf,

    /// Engine that is to run the job
    #[arg(long, value_enum)]
    engine: Engine,

    /// Folder for the files of the job [default: farm/NAME/ENGINE]
    #[allow(rustdoc::broken_intra_doc_links, reason = "a default in brackets is no link")]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,

    /// Frames of a chunk, wherever segments end [default: chunks are segments]
    #[arg(long, value_name = "N")]
    chunk: Option<NonZeroU32>,

    /// Frames from one checkpoint to the next; 0: none [default: a quarter of the longest chunk, none below 8 frames]
    #[arg(long, value_name = "N")]
    checkpoint: Option<u32>,

    /// Processors of each task [default: as many as this machine has]
    #[arg(long, value_name = "N", value_parser = args::values::threads)]
    threads: Option<std::num::NonZeroUsize>,

    /// Memory of a machine of the farm, in GiB: a scene that does not fit is an error
    #[arg(long, value_name = "GIB", value_parser = clap::value_parser!(u32).range(1..))]
    node_memory: Option<u32>,

    /// Name or path of this program on the farm
    #[arg(long, default_value = "afterimage", value_name = "PROGRAM")]
    program: String,

    /// Address of the Flamenco Manager, for --submit
    #[arg(long, value_name = "URL", default_value = "http://localhost:8080")]
    manager: String,

    /// Also give the job to the engine, by its own program: `sbatch`, `deadline`, or `curl` for Flamenco
    #[arg(long)]
    submit: bool,

    /// Options of `render`
    #[arg(last = true, value_name = "RENDER OPTIONS")]
    options: Vec<String>,
}

/// Engines by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Engine {
    /// A folder that all machines see, and a script to start on each
    Shared,
    /// Open Job Description (2023-09): also a job bundle of AWS Deadline Cloud
    Openjd,
    /// Flamenco 3
    Flamenco,
    /// Slurm
    Slurm,
}

/// A job that is to be written for an engine.
struct Plan {
    /// Name of the shot.
    name: String,
    program: String,
    shot: PathBuf,
    /// Files that the shot reads.
    inputs: Vec<PathBuf>,
    /// Folder of the frames, absolute, and their names in it.
    folder: PathBuf,
    names: String,
    /// Options of `render` without its frames and files.
    options: Vec<String>,
    frames: Frames,
    chunks: Vec<Chunk>,
    checkpoint: Option<u32>,
    /// True if chunks begin at other frames than base frames: they hand on samples.
    handoff: bool,
    threads: usize,
    /// Memory of each task, MiB.
    memory: u64,
    /// Folder of the job's own files, absolute.
    output: PathBuf,
}

/// A file of a job.
struct File {
    name: String,
    text: String,
    is_script: bool,
}

impl Plan {
    /// Names of all frames, absolute.
    fn pattern(&self) -> String {
        self.folder.join(&self.names).display().to_string()
    }

    /// Words of `render` but for the program, `--frames` and progress, with `shot` and `pattern` as the engine writes them.
    fn render(&self, shot: &str, pattern: &str) -> Vec<String> {
        let words = ["render", shot].map(String::from).into_iter().chain(self.options.iter().cloned());
        let mut words: Vec<String> = words.chain(["-o", pattern].map(String::from)).collect();
        words.push(String::from("--resume"));
        words.extend(self.handoff.then(|| String::from("--handoff")));
        words.extend(
            self.checkpoint.iter().flat_map(|every| [String::from("--checkpoint"), every.to_string()]),
        );
        words
    }

    /// Words of `verify` but for the program.
    fn verify(&self, shot: &str, pattern: &str) -> Vec<String> {
        let mut words = ["verify", pattern, "--shot", shot, "--frames"].map(String::from).to_vec();
        words.push(self.frames.to_string());
        if !self.options.is_empty() {
            words.push(String::from("--"));
            words.extend(self.options.iter().cloned());
        }
        words
    }

    /// The script of a shared folder.
    fn shared(&self) -> Vec<File> {
        let render = self.render(&self.shot.display().to_string(), &self.pattern());
        let verify = self.verify(&self.shot.display().to_string(), &self.pattern());
        let text = format!(
            "#!/bin/sh\n\
             # Start this on each machine that is to help; more may come later, and any may be stopped.\n\
             # Each takes segments that no other has; all end when all frames are there.\n\
             set -eu\n\
             {program} {} --frames {} --shared \"$@\"\n\
             exec {program} {}\n",
            shell(&render),
            quoted(OsStr::new(&self.frames.to_string())),
            shell(&verify),
            program = quoted(OsStr::new(&self.program)),
        );
        vec![File { name: String::from("work.sh"), text, is_script: true }]
    }
}

/// Words as a shell takes them.
fn shell(words: &[String]) -> String {
    words.iter().map(|word| quoted(OsStr::new(word))).collect::<Vec<_>>().join(" ")
}

impl FarmArgs {
    /// Writes the job, and gives it to the engine if that is asked for.
    pub fn execute(&self, terminal: &mut Terminal) -> Result<(), Failure> {
        let plan = args::on_threads(self.threads, || self.plan(terminal))?;
        let engine =
            self.engine.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned());
        let files = match self.engine {
            Engine::Shared => plan.shared(),
            Engine::Openjd => openjd::files(&plan),
            Engine::Flamenco => flamenco::files(&plan)?,
            Engine::Slurm => slurm::files(&plan),
        };
        for file in &files {
            write(&plan.output.join(&file.name), file)?;
        }
        tell(&plan, &engine, &files, terminal);
        let submit = match self.engine {
            Engine::Shared => {
                terminal.result(&format!(
                    "{:<9}{} on each machine",
                    "start",
                    plan.output.join("work.sh").display()
                ));
                None
            }
            Engine::Openjd => Some(openjd::submission(&plan)),
            Engine::Flamenco => Some(flamenco::submission(&plan, &self.manager)),
            Engine::Slurm => Some(slurm::submission(&plan)),
        };
        match submit {
            Some(words) if self.submit => run(&words),
            Some(words) => {
                terminal.result(&format!("{:<9}{}", "submit", shell(&words)));
                Ok(())
            }
            None if self.submit => Err(Failure::Usage(String::from(
                "--submit: a shared folder has no engine; start work.sh on each machine",
            ))),
            None => Ok(()),
        }
    }

    fn plan(&self, terminal: &Terminal) -> Result<Plan, Failure> {
        if let Some(word) =
            self.options.iter().find(|word| OWN.contains(&word.split('=').next().unwrap_or_default()))
        {
            return Err(Failure::Usage(format!(
                "{word}: a job decides this itself; leave it out after `--` (see --threads, --checkpoint)"
            )));
        }
        let (job, target) = render::job_and_target(&self.shot, &self.options)?;
        let full = job.settings.mode == Mode::Full;
        let rule = render::rule(&job, full);
        let chunks = chunks::divide(&job, &rule, self.chunk)?;
        if let Some(note) = chunks::note(&chunks) {
            terminal.note(&note);
        }
        let longest = chunks.iter().map(|chunk| chunk.steps.len()).max().unwrap_or(0);
        let usual = if longest < LEAST_CHECKPOINTED { 0 } else { longest.div_ceil(CHECKPOINTS) as u32 };
        let checkpoint = Some(self.checkpoint.unwrap_or(usual)).filter(|every| *every > 0 && !full);
        let need = self.need(&job, &chunks);
        if let Some(gib) = self.node_memory {
            let limit = [(Limit::ControlGroup, u64::from(gib) << 30)];
            need.check(&limit).map_err(|_| too_large(&need, gib))?;
        }
        let path = |path: &Path| {
            absolute(path).map_err(|error| Failure::Failed(format!("{}: {error}", path.display())))
        };
        let pattern = path(&target.exr_pattern())?;
        let (folder, names) = (output::folder_of(&pattern).to_owned(), pattern.file_name());
        if folder.to_string_lossy().contains('#') {
            return Err(Failure::Usage(format!(
                "{}: tasks name frames by their whole path, in which # would stand for the frame's number: give another folder with -o, \
                 after `--`",
                folder.display()
            )));
        }
        let engine =
            self.engine.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned());
        let name = target.shot().to_owned();
        let files = self.output.clone().unwrap_or_else(|| Path::new("farm").join(&name).join(engine));
        Ok(Plan {
            program: self.program.clone(),
            shot: path(&self.shot)?,
            inputs: job.shot.files.iter().map(|file| path(file)).collect::<Result<_, _>>()?,
            folder,
            names: names.map(|names| names.to_string_lossy().into_owned()).unwrap_or_default(),
            options: without_frames_and_files(&self.options),
            frames: job.frames.clone(),
            checkpoint,
            // a shared run divides the frames by itself, into segments
            handoff: chunks::run_up(&chunks) > 0 && self.engine != Engine::Shared,
            chunks,
            threads: rayon::current_num_threads(),
            memory: (need.bytes() + need.bytes() / MARGIN).div_ceil(1 << 20),
            output: path(&files)?,
            name,
        })
    }

    /// Memory of the chunk that takes most, the scene included.
    fn need(&self, job: &Job, chunks: &[Chunk]) -> Need {
        let needs = chunks.iter().map(|chunk| render::need(job, &job.settings, &chunk.steps));
        let most = needs.max_by_key(Need::bytes).unwrap_or_default();
        most.and(Need::new(Part::new("the scene", cost::memory_of(&job.shot), "smaller models and textures")))
    }
}

fn too_large(need: &Need, gib: u32) -> Failure {
    let mut parts: Vec<&Part> = need.parts.iter().collect();
    parts.sort_by_key(|part| std::cmp::Reverse(part.bytes));
    let named: Vec<String> =
        parts.iter().take(3).map(|part| format!("{} {}", part.what, Bytes(part.bytes))).collect();
    let remedy = parts.first().map_or("larger machines", |part| part.remedy);
    Failure::Failed(format!(
        "a task needs about {} of memory ({}), and a machine has {gib} GiB (--node-memory): try {remedy}, or larger machines",
        Bytes(need.bytes()),
        named.join(", "),
    ))
}

/// Options but for those that each task has for itself: `--frames` and `-o`, with their values.
fn without_frames_and_files(options: &[String]) -> Vec<String> {
    let mut rest = Vec::new();
    let mut words = options.iter();
    while let Some(word) = words.next() {
        match word.as_str() {
            "--frames" | "-o" | "--output" => drop(words.next()),
            // clap takes `-oFILE`, too
            other if other.starts_with("--frames=") || other.starts_with("--output=") => {}
            other if other.starts_with("-o") => {}
            other => rest.push(other.to_owned()),
        }
    }
    rest
}

fn write(path: &Path, file: &File) -> Result<(), Failure> {
    output::ensure_writable(path).map_err(Failure::of)?;
    output::write_bytes(path, file.text.as_bytes()).map_err(Failure::of)?;
    if file.is_script {
        let failed = |error| Failure::of(WriteError { path: path.to_owned(), source: error });
        fs::set_permissions(path, Permissions::from_mode(0o755)).map_err(failed)?;
    }
    Ok(())
}

fn tell(plan: &Plan, engine: &str, files: &[File], terminal: &mut Terminal) {
    let mut line = |name: &str, value: String| terminal.result(&format!("{name:<9}{value}"));
    let frames = chunks::frames(&plan.chunks);
    line("engine", engine.to_owned());
    let run_up = match chunks::run_up(&plan.chunks) {
        0 => String::from("no run-up"),
        run_up => format!("{run_up} frames of run-up at most"),
    };
    line("chunks", format!("{} of {frames} frames, {run_up}", plan.chunks.len()));
    line("task", format!("{} processors, {} MiB of memory", plan.threads, plan.memory));
    line("frames", plan.pattern());
    for file in files {
        line("file", plan.output.join(&file.name).display().to_string());
    }
}

/// Runs a command of the engine to its end.
fn run(words: &[String]) -> Result<(), Failure> {
    let text = shell(words);
    let (program, rest) = words.split_first().ok_or_else(|| Failure::Failed(String::from("no command")))?;
    match Command::new(program).args(rest).status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(Failure::Failed(format!("`{text}` failed ({status}): see what it says above"))),
        Err(error) if error.kind() == ErrorKind::NotFound => {
            Err(Failure::Failed(format!("`{program}` is not installed here: run `{text}` where it is")))
        }
        Err(error) => Err(Failure::Failed(format!("`{text}` cannot be started: {error}; run it by hand"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tasks_have_their_own_frames_and_files() {
        let words = |text: &str| text.split(' ').map(String::from).collect::<Vec<_>>();
        let options = words("--frames 1-9 --samples 4 -o a/b.####.exr --output=c --frames=3 --mode full");
        assert_eq!(without_frames_and_files(&options), words("--samples 4 --mode full"));
    }
}

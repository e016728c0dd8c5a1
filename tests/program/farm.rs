//! Is what `farm` writes what engines take, and do their tasks make the frames of one run?

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::runs::{Place, Ran, analytic, assert_same};

fn farm(place: &Place, words: &str) -> Ran {
    let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage"));
    command.current_dir(place.0.path()).args(["farm".as_ref(), analytic().as_os_str()]);
    Ran::new(command.args(words.split_whitespace()).output().unwrap())
}

fn text(place: &Place, name: &str) -> String {
    fs::read_to_string(place.path(name)).unwrap()
}

/// Output of a program, or `None` with a message where it is not installed.
fn output_of(command: &mut Command) -> Option<String> {
    match command.stderr(Stdio::inherit()).output() {
        Ok(output) => {
            assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stdout));
            Some(String::from_utf8(output.stdout).unwrap())
        }
        Err(error) => {
            println!("skipped: {command:?}: {error}");
            None
        }
    }
}

#[track_caller]
fn assert_same_frames(place: &Place) {
    for frame in 1..=8 {
        let [one, other] = ["all", "parts"].map(|folder| place.path(&format!("{folder}/a.{frame:04}.exr")));
        assert_same(&one, &other);
    }
}

const RENDER: &str = "--base-every 3 --mode reproject -o parts/a.####.exr";

#[test]
fn chunks_are_segments_and_others_are_told() {
    let place = Place::new();
    let ran = farm(&place, &format!("--engine slurm -o job -- {RENDER}")).done();
    assert!(ran.stdout.contains("3 of 8 frames, no run-up"), "{}", ran.stdout);
    let script = text(&place, "job/render.sbatch");
    assert!(script.contains("chunks=(1-3 4-6 7-8)") && script.contains("--array=0-2\n"), "{script}");
    assert!(!script.contains("--handoff"), "each begins at a base frame: {script}");
    let ran = farm(&place, &format!("--engine slurm -o job --chunk 4 -- {RENDER}")).done();
    assert!(ran.stderr.contains("1 of 9 rendered frames are run-up"), "{}", ran.stderr);
    let script = text(&place, "job/render.sbatch");
    assert!(script.contains("chunks=(1-4 5-8)") && script.contains("--resume --handoff"), "{script}");
    // chunks that begin at base frames come first
    farm(&place, &format!("--engine slurm -o job --chunk 2 -- {}", RENDER.replace("3", "4"))).done();
    assert!(text(&place, "job/render.sbatch").contains("chunks=(1-2 5-6 3-4 7-8)"));
    farm(&place, &format!("--engine shared -o job --chunk 2 -- {RENDER}")).done();
    let script = text(&place, "job/work.sh");
    assert!(!script.contains("--handoff"), "a shared run divides by segments: {script}");
    // every chain has segments of its own
    farm(&place, "--engine slurm -o job -- --frames 1-8x2 --base-every 4").done();
    assert!(text(&place, "job/render.sbatch").contains("chunks=(1-3x2 5-7x2)"));
    let ran = farm(&place, "--engine slurm -o job -- --base-every 0").done();
    assert!(ran.stderr.contains("one chunk: set base_every"), "{}", ran.stderr);
}

#[test]
fn scenes_that_do_not_fit_and_options_that_a_job_has_itself_are_refused() {
    let place = Place::new();
    let huge = "--size 30000x20000 --samples 2";
    farm(&place, &format!("--engine slurm -o job --node-memory 8 -- {huge}")).failed(&[
        "a machine has 8 GiB",
        "samples a pixel",
        "--size",
    ]);
    assert!(!place.path("job").exists());
    for (words, why) in [
        ("--engine slurm -- --resume", "--resume"),
        ("--engine slurm -- --handoff", "--handoff"),
        ("--engine slurm -- --threads=3", "--threads"),
        ("--engine slurm -- --samples 0", "options of render"),
        ("--engine lsf", "openjd"),
    ] {
        let ran = farm(&place, words);
        assert!(ran.code == 2 && ran.stderr.contains(why), "{words}: {}", ran.stderr);
    }
    let ran = farm(&place, &format!("--engine slurm -o job --submit -- {RENDER}"));
    if Command::new("sbatch").arg("--version").output().is_err() {
        ran.failed(&["submit.sh` failed"]);
    }
}

#[test]
fn a_folder_in_whose_path_a_task_would_look_for_the_number_is_refused() {
    let place = Place::new();
    let ran = farm(&place, "--engine slurm -o job -- -o shot#3/");
    assert!(ran.code == 2 && ran.stderr.contains("shot#3: tasks name frames"), "{}", ran.stderr);
    assert!(!place.path("job").exists());
}

/// MiB of memory that a task asks for.
fn memory_of_a_task(place: &Place, shot: &str) -> u64 {
    let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage"));
    command.current_dir(place.0.path()).args([
        "farm",
        shot,
        "--engine",
        "slurm",
        "-o",
        "job",
        "--threads",
        "1",
    ]);
    Ran::new(command.args(["--", "--size", "64x36"]).output().unwrap()).done();
    let script = text(place, "job/render.sbatch");
    let line = script.lines().find_map(|line| line.strip_prefix("#SBATCH --mem=")).unwrap();
    line.trim_end_matches('M').parse().unwrap()
}

#[test]
fn the_memory_of_a_task_counts_the_scene() {
    let place = Place::new();
    let write = |name: &str, text: &str| fs::write(place.path(name), text).unwrap();
    write(
        "m.obj",
        "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n",
    );
    write("m.mtl", "newmtl a\nKd 1 1 1\n");
    let without = memory_of_a_task(&place, "m.obj");
    write("m.mtl", "newmtl a\nKd 1 1 1\nmap_Kd t.bmp\n");
    image::RgbImage::from_pixel(3000, 3000, image::Rgb([9, 99, 200])).save(place.path("t.bmp")).unwrap();
    let with = memory_of_a_task(&place, "m.obj");
    assert!(with >= without + 3000 * 3000 * 4 / (1 << 20), "{with} MiB with the texture, {without} without");
}

/// Runs the scripts as Slurm would: the array's tasks, one of which is requeued, and then the last job.
#[test]
fn scripts_of_slurm_render_and_verify_all_frames() {
    let place = Place::new();
    place.render(&RENDER.replace("parts", "all")).done();
    let program = env!("CARGO_BIN_EXE_afterimage");
    farm(
        &place,
        &format!("--engine slurm -o job --threads 1 --checkpoint 1 --program {program} -- {RENDER}"),
    )
    .done();
    let script = text(&place, "job/render.sbatch");
    for line in ["--cpus-per-task=1\n", "--requeue\n", "#SBATCH --mem="] {
        assert!(script.contains(line), "{line}: {script}");
    }
    let run = |name: &str, task: &str| {
        let mut shell = Command::new("bash");
        let variables = [("SLURM_CPUS_PER_TASK", "1"), ("SLURM_ARRAY_TASK_ID", task)];
        shell.current_dir(place.0.path()).arg(place.path(name)).envs(variables);
        Ran::new(shell.output().unwrap())
    };
    run("job/verify.sbatch", "").failed(&["8 of 8"]);
    for task in ["2", "0", "1", "1"] {
        run("job/render.sbatch", task).done();
    }
    run("job/verify.sbatch", "").done();
    assert_same_frames(&place);
}

/// Tasks of chunks in a segment, in the job's order: each goes on from the one before.
#[test]
fn tasks_of_slurm_hand_on_their_samples() {
    let place = Place::new();
    let render = "--base-every 0 --mode reproject --samples 1 -o parts/a.####.exr";
    place.render(&render.replace("parts", "all")).done();
    let program = env!("CARGO_BIN_EXE_afterimage");
    farm(&place, &format!("--engine slurm -o job --threads 1 --chunk 3 --program {program} -- {render}"))
        .done();
    for task in 0..3 {
        let mut shell = Command::new("bash");
        let variables = [("SLURM_CPUS_PER_TASK", "1"), ("SLURM_ARRAY_TASK_ID", &task.to_string())];
        shell.current_dir(place.0.path()).arg(place.path("job/render.sbatch")).envs(variables);
        let ran = Ran::new(shell.output().unwrap()).done();
        assert!(!ran.stderr.contains("run-up"), "{}", ran.stderr);
        assert_eq!(ran.stderr.contains("--handoff: goes on"), task > 0, "{}", ran.stderr);
    }
    assert_same_frames(&place);
    assert!(place.names("parts").iter().all(|name| name.ends_with(".exr")));
}

#[test]
fn the_script_of_a_shared_folder_renders_and_verifies_all_frames() {
    let place = Place::new();
    place.render(&RENDER.replace("parts", "all")).done();
    let program = env!("CARGO_BIN_EXE_afterimage");
    farm(&place, &format!("--engine shared -o job --program {program} -- {RENDER}")).done();
    let start =
        || Command::new(place.path("job/work.sh")).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    for child in [start(), start()] {
        let ran = Ran::new(child.unwrap().wait_with_output().unwrap()).done();
        assert!(ran.stdout.contains("complete"), "{}", ran.stdout);
    }
    assert_same_frames(&place);
}

/// Compiles the job with an `author` that records what the real one is told, and checks that.
const CHECK_JOB_TYPE: &str = r#"
const fs = require("fs"), vm = require("vm");
const author = {
  Task: (name, type) => ({ name, type, commands: [], needs: [],
    addCommand(c) { this.commands.push(c); }, addDependency(t) { this.needs.push(t.name); } }),
  Command: (name, parameters) => ({ name, parameters }),
};
const job = JSON.parse(fs.readFileSync(process.argv[3], "utf8"));
const context = vm.createContext({ author, JSON });
vm.runInContext(fs.readFileSync(process.argv[2], "utf8") + "\nglobalThis.type = JOB_TYPE;", context);
const known = context.type.settings.map((setting) => setting.key).sort().join();
if (known !== Object.keys(job.settings).sort().join()) throw new Error("settings: " + known);
const tasks = [];
job.addTask = (task) => tasks.push(task);
context.compileJob(job);
console.log(JSON.stringify(tasks));
"#;

#[test]
fn a_job_of_flamenco_compiles_and_its_tasks_make_all_frames() {
    let place = Place::new();
    place.render(&RENDER.replace("parts", "all")).done();
    let program = env!("CARGO_BIN_EXE_afterimage");
    farm(&place, &format!("--engine flamenco -o job --program {program} -- {RENDER}")).done();
    fs::write(place.path("check.js"), CHECK_JOB_TYPE).unwrap();
    let mut node = Command::new("node");
    node.current_dir(place.0.path()).args(["check.js", "job/afterimage.js", "job/job.json"]);
    let Some(tasks) = output_of(&mut node) else { return };
    let tasks: serde_json::Value = serde_json::from_str(&tasks).unwrap();
    let names: Vec<&str> =
        tasks.as_array().unwrap().iter().map(|task| task["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["render-1-3", "render-4-6", "render-7-8", "verify"]);
    assert_eq!(tasks[3]["needs"], serde_json::json!(["render-1-3", "render-4-6", "render-7-8"]));
    for task in tasks.as_array().unwrap() {
        let command = &task["commands"][0];
        assert_eq!((&task["type"], &command["name"]), (&"misc".into(), &"exec".into()));
        let words: Vec<&str> = command["parameters"]["args"]
            .as_array()
            .unwrap()
            .iter()
            .map(|word| word.as_str().unwrap())
            .collect();
        let mut program = Command::new(command["parameters"]["exe"].as_str().unwrap());
        Ran::new(program.current_dir("/").args(words).output().unwrap()).done();
    }
    assert_same_frames(&place);
}

#[test]
fn a_template_of_openjd_names_all_that_a_task_needs() {
    let place = Place::new();
    farm(&place, &format!("--engine openjd -o job --threads 2 -- {RENDER}")).done();
    let template = text(&place, "job/template.yaml");
    for part in [
        "specificationVersion: jobtemplate-2023-09\n",
        "range: [\"1-3\", \"4-6\", \"7-8\"]\n",
        "name: amount.worker.vcpu\n      min: 2\n",
        "name: amount.worker.memory\n      min: ",
        "\"--progress\", \"openjd\", \"--frames\", \"{{Task.Param.Frames}}\"",
        "- dependsOn: Render\n",
    ] {
        assert!(template.contains(part), "{part}: {template}");
    }
    let references = text(&place, "job/asset_references.yaml");
    assert!(references.contains("analytic.toml\"") && references.contains(".obj\""), "{references}");
}

/// With `openjd` of the Python package `openjd-cli`, which `AFTERIMAGE_OPENJD` names.
#[test]
fn openjd_takes_the_template_and_runs_it() {
    let Some(openjd) = std::env::var_os("AFTERIMAGE_OPENJD") else {
        println!("skipped: AFTERIMAGE_OPENJD does not name the program `openjd`");
        return;
    };
    let place = Place::new();
    place.render(&RENDER.replace("parts", "all")).done();
    let program = env!("CARGO_BIN_EXE_afterimage");
    farm(&place, &format!("--engine openjd -o job --program {program} -- {RENDER}")).done();
    let template = place.path("job/template.yaml");
    let run = |words: &[&str]| {
        let mut command = Command::new(Path::new(&openjd));
        output_of(command.current_dir(place.0.path()).arg(words[0]).arg(&template).args(&words[1..])).unwrap()
    };
    assert!(run(&["check"]).contains("passes validation checks"));
    let parameters = format!("file://{}", place.path("job/parameters.json").display());
    let log = run(&["run", "-p", &parameters, "--run-dependencies", "--step", "Verify"]);
    assert!(log.contains("openjd_progress: 100.0") && log.contains("openjd_status: frame 8"), "{log}");
    assert_same_frames(&place);
}

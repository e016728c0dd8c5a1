//! Slurm: a job array, and a job that verifies its frames.

use super::{File, Plan, shell};
use crate::cli::quoted;
use std::ffi::OsStr;

/// Memory of the job that verifies, MiB. It reads frames line by line, and the shot.
const LEAST_MEMORY: u64 = 512;

/// Scripts of a job.
pub fn files(plan: &Plan) -> Vec<File> {
    let script = |name: &str, text| File { name: name.to_owned(), text, is_script: true };
    vec![
        script("render.sbatch", render(plan)),
        script("verify.sbatch", verify(plan)),
        script("submit.sh", submit()),
    ]
}

/// Command that gives the job to Slurm.
pub fn submission(plan: &Plan) -> Vec<String> {
    vec![plan.output.join("submit.sh").display().to_string()]
}

fn render(plan: &Plan) -> String {
    let words = plan.render(&plan.shot.display().to_string(), &plan.pattern());
    let chunks: Vec<String> =
        plan.chunks.iter().map(|chunk| quoted(OsStr::new(&chunk.frames.to_string()))).collect();
    format!(
        "#!/bin/bash\n\
         #SBATCH --job-name={name}\n\
         #SBATCH --array=0-{last}\n\
         #SBATCH --ntasks=1\n\
         #SBATCH --cpus-per-task={threads}\n\
         #SBATCH --mem={memory}M\n\
         #SBATCH --requeue\n\
         #SBATCH --open-mode=append\n\
         #SBATCH --output=%x.%A_%a.log\n\
         # A task that is requeued goes on: whole frames are kept, and samples come from the last checkpoint.\n\
         set -euo pipefail\n\
         chunks=({chunks})\n\
         exec {program} {words} --progress plain \\\n  \
         --threads \"$SLURM_CPUS_PER_TASK\" --frames \"${{chunks[$SLURM_ARRAY_TASK_ID]}}\"\n",
        name = job_name(plan),
        last = plan.chunks.len().saturating_sub(1),
        threads = plan.threads,
        memory = plan.memory,
        chunks = chunks.join(" "),
        program = quoted(OsStr::new(&plan.program)),
        words = shell(&words),
    )
}

fn verify(plan: &Plan) -> String {
    format!(
        "#!/bin/bash\n\
         #SBATCH --job-name={name}.verify\n\
         #SBATCH --ntasks=1\n\
         #SBATCH --mem={memory}M\n\
         #SBATCH --output=%x.%j.log\n\
         set -euo pipefail\n\
         exec {program} {words}\n",
        name = job_name(plan),
        memory = plan.memory.max(LEAST_MEMORY),
        program = quoted(OsStr::new(&plan.program)),
        words = shell(&plan.verify(&plan.shot.display().to_string(), &plan.pattern())),
    )
}

/// Name of the job without what Slurm gives a meaning, in a line that is no shell's.
fn job_name(plan: &Plan) -> String {
    plan.name.chars().map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect()
}

/// The frames are verified however the array ended: that says what is missing.
fn submit() -> String {
    String::from(
        "#!/bin/bash\n\
         # Options go to both jobs, such as --partition=NAME. Logs appear in the current folder.\n\
         set -euo pipefail\n\
         here=$(cd \"$(dirname \"$0\")\" && pwd)\n\
         array=$(sbatch --parsable \"$@\" \"$here/render.sbatch\")\n\
         verify=$(sbatch --parsable --dependency=\"afterany:${array%%;*}\" \"$@\" \"$here/verify.sbatch\")\n\
         echo \"render $array\"\n\
         echo \"verify $verify\"\n",
    )
}

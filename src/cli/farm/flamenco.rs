//! Flamenco 3: a job type in JavaScript, and a job of it.

use serde_json::json;

use super::{File, Plan};
use crate::cli::failure::Failure;

/// The job type. Flamenco calls it by its file's name.
const JOB_TYPE: &str = include_str!("afterimage.js");

/// The job type, and the job.
pub fn files(plan: &Plan) -> Result<Vec<File>, Failure> {
    let (shot, pattern) = (plan.shot.display().to_string(), plan.pattern());
    let words = |words: &[String]| serde_json::to_string(words).map_err(Failure::of);
    let chunks: Vec<String> = plan.chunks.iter().map(|chunk| chunk.frames.to_string()).collect();
    let job = json!({
        "name": plan.name,
        "type": "afterimage",
        "priority": 50,
        "submitter_platform": "linux",
        "settings": {
            "program": plan.program,
            "render": words(&plan.render(&shot, &pattern))?,
            "verify": words(&plan.verify(&shot, &pattern))?,
            "chunks": chunks.join(" "),
        },
        "metadata": {
            "frames": plan.frames.to_string(),
            "memory": format!("{} MiB a task", plan.memory),
        },
    });
    let job = serde_json::to_string_pretty(&job).map_err(Failure::of)?;
    let file = |name: &str, text| File { name: name.to_owned(), text, is_script: false };
    Ok(vec![file("afterimage.js", JOB_TYPE.to_owned()), file("job.json", format!("{job}\n"))])
}

/// Command that gives the job to the Manager at `url`.
pub fn submission(plan: &Plan, url: &str) -> Vec<String> {
    let job = format!("@{}", plan.output.join("job.json").display());
    let jobs = format!("{}/api/v3/jobs", url.trim_end_matches('/'));
    let words = ["curl", "--fail-with-body", "-sS", "-H", "Content-Type: application/json", "--data-binary"];
    words.map(String::from).into_iter().chain([job, jobs]).collect()
}

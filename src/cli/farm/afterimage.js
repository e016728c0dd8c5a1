// A job type of Flamenco 3 for Afterimage. Put this file into the folder `scripts` of the Manager.
// `afterimage farm SHOT --engine flamenco` writes jobs of it: each task renders a chunk, and the last one verifies all frames.

const JOB_TYPE = {
  label: "Afterimage",
  description: "Render a shot in chunks, and verify its frames",
  settings: [
    { key: "program", type: "string", required: true, default: "afterimage", description: "Name or path of Afterimage on the workers" },
    { key: "chunks", type: "string", required: true, description: "Frames of each task, with spaces between tasks" },
    { key: "render", type: "string", required: true, description: "Words of `afterimage render`, but for the frames: a list in JSON" },
    { key: "verify", type: "string", required: true, description: "Words of `afterimage verify`: a list in JSON" },
  ],
};

function compileJob(job) {
  const settings = job.settings;
  const render = JSON.parse(settings.render);
  const verify = author.Task("verify", "misc");
  verify.addCommand(author.Command("exec", { exe: settings.program, args: JSON.parse(settings.verify) }));
  for (const chunk of settings.chunks.split(" ")) {
    if (chunk === "") {
      continue;
    }
    const task = author.Task("render-" + chunk, "misc");
    const args = render.concat(["--progress", "plain", "--frames", chunk]);
    task.addCommand(author.Command("exec", { exe: settings.program, args: args }));
    verify.addDependency(task);
    job.addTask(task);
  }
  job.addTask(verify);
}

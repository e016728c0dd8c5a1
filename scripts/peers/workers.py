"""Which renderers are on this machine, and work for them in processes of their own."""

import contextlib
import json
import os
import pathlib
import subprocess
import sys

from . import afterimage

SCRIPTS = pathlib.Path(__file__).resolve().parents[1]
# how each says its version
ASK = {
    "mitsuba": "import mitsuba; print('Mitsuba', mitsuba.__version__)",
    "cycles": "import bpy; print('Cycles', bpy.app.version_string)",
}


class Failed(Exception):
    """A worker ended with an error; the text is the end of what it said."""


def found():
    """The renderers that are here, with their versions."""
    here = {}
    if afterimage.program():
        here["afterimage"] = afterimage.version().capitalize()
    for renderer, question in ASK.items():
        answer = subprocess.run([sys.executable, "-c", question], capture_output=True, text=True, check=False)
        if answer.returncode == 0:
            here[renderer] = answer.stdout.strip().splitlines()[-1]
    return here


def run(work, renderer, job, variant="llvm", nice=False):
    """Lets the worker of `renderer` do a job; `Failed` where it ends with an error."""
    name = work / f"{renderer}-job.json"
    name.write_text(json.dumps(job | {"variant": f"{variant}_ad_rgb" if variant == "llvm" else "scalar_rgb"}))
    line = [*(["nice", "-n", "15"] if nice else []), sys.executable, "-m", f"peers.{renderer}_worker", str(name)]
    ran = subprocess.run(
        line,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
        env=os.environ | {"PYTHONPATH": str(SCRIPTS)},
    )
    if ran.returncode != 0:
        end = "\n".join(line[:300] for line in ran.stdout.strip().splitlines()[-5:])
        raise Failed(f"{renderer} ended with {ran.returncode}:\n{end}")


@contextlib.contextmanager
def kept(path, plan):
    """Whether `path` has yet to be made by `plan`. If it is, inside, the plan is written beside it."""
    beside = path.with_suffix(".plan.json")
    text = json.dumps(plan)
    if path.is_file() and beside.is_file() and beside.read_text() == text:
        yield False
        return
    beside.unlink(missing_ok=True)
    yield True
    beside.write_text(text)

"""Renders with Afterimage: writes shots, runs the program, reads its files and statistics."""

import json
import math
import os
import pathlib
import subprocess

import numpy as np

from . import measure, places

ROOT = pathlib.Path(__file__).resolve().parents[2]
FIRST_MEASURED = 5  # frame of a chain of inferred frames: before, the chain has only begun
CYCLE = 48  # frames from one base frame to the next, as shots have them by default
FULL_FRAMES = 3  # that are traced in full for one time


class Failed(Exception):
    """The program ended with an error, which the text repeats."""


def program_path():
    """Where the program that is measured should be."""
    return pathlib.Path(os.environ.get("AFTERIMAGE") or ROOT / "target/release/afterimage").resolve()


def program():
    """The program that is measured; None where there is none."""
    return program_path() if program_path().is_file() else None


def version():
    return run("--version").strip()


def run(*words, nice=False):
    """Runs the program to its end; returns what it prints."""
    line = [*(["nice", "-n", "15"] if nice else []), str(program()), *map(str, words)]
    # where the program lies elsewhere, it finds the checkout's Open Image Denoise all the same
    private = ROOT / ".deps/oidn"
    surroundings = {"OIDN_DIR": str(private)} if private.is_dir() else {}
    ran = subprocess.run(line, capture_output=True, text=True, check=False, env=surroundings | os.environ)
    if ran.returncode != 0:
        raise Failed(f"{' '.join(line)}\n{ran.stderr.strip()}")
    return ran.stdout


# --- shots ---


def write_shot(path, place, light_samples=16, pixel_filter="box"):
    """The shot of a place: no mirrors; how many samples and paths is said when it is rendered.

    `light_samples`: shadow rays of each sample to the panel."""
    width, height = place["size"]
    lines = ["[render]", f"size = [{width}, {height}]", "samples = 1", f'filter = "{pixel_filter}"', "depth = 1"]
    lines += [f'frames = "1-{last_frame(place)}"', "[indirect]", "paths = 1", "[camera]", *keys(place)]
    if "turn" in place:
        half = place["turn"]["shutter"] / 2
        lines += ["[shutter]", f"open = {-half}", f"close = {half}"]
    lines += ["[[model]]", f"obj = {json.dumps(place['scene'] + '/scene.obj')}"]
    if "sun" in place:
        # all light of MTL's convention is divided by pi
        sun = place["sun"]
        lines += ["[[light]]", 'type = "directional"', f"direction = {sun['direction']}", f"power = {sun['irradiance'] / math.pi}"]
    if "panel" in place:
        lines += panel(**place["panel"], samples=light_samples)
    if "sky" in place:
        lines += ["[background]", f"color = {place['sky']}", "[environment]"]
    path.write_text("\n".join(lines) + "\n")
    return path


def last_frame(place):
    """The frame that is compared, in which the camera stands as in the other renderers."""
    return next((place[move]["frames"] for move in ("dolly", "turn") if move in place), 1)


def keys(place):
    if "turn" in place:
        for frame in places.turn_ends(place):
            pitch, yaw = places.heading(place, frame)
            yield f"[[camera.key]]\nframe = {frame}\neye = {place['eye']}\nrotation = {[pitch, yaw, 0.0]}\nfov = {place['fov']}"
        return
    lens = f"\naperture = {place['lens']['radius']}\nfocus = {place['lens']['focus']}" if "lens" in place else ""
    ends = [(last_frame(place), place["eye"], place["target"])]
    if "dolly" in place:
        ends.insert(0, (1, place["dolly"]["eye"], place["dolly"]["target"]))
    for frame, eye, target in ends:
        yield f"[[camera.key]]\nframe = {frame}\neye = {eye}\ntarget = {target}\nfov = {place['fov']}{lens}"


def panel(center, size, radiance, samples):
    """A panel that shines down. Its `power` is its intensity, divided by pi as all light of MTL's convention."""
    center, (width, depth) = list(map(float, center)), size
    below = [center[0], center[1] - 1, center[2]]
    yield f'[[light]]\ntype = "rectangle"\nposition = {center}\ntarget = {below}'
    yield f"size = {[width, depth]}\npower = {radiance * width * depth / math.pi}\nsamples = {samples}"


# --- rendering ---


def picture(path, layer=None):
    """The colours of a layer of an EXR file, or of the picture itself; (height, width, 3), linear."""
    all_of_it = channels(path)
    return np.stack([all_of_it[f"{layer}.{one}" if layer else one] for one in "RGB"], axis=2)


def channels(path):
    """The channels of an EXR file, by name; (height, width)."""
    import OpenEXR

    read = OpenEXR.File(str(path), separate_channels=True).channels()
    return {name: np.asarray(channel.pixels, np.float64) for name, channel in read.items()}


def render(shot, folder, frames, options, nice=False, layers="none"):
    """Renders frames into `folder`; returns their files and their statistics, by frame."""
    folder.mkdir(parents=True, exist_ok=True)
    out, statistics = folder / "frame.####.exr", folder / "statistics.json"
    always = ["--frames", frames, "--layers", layers, "-q", "-o", out, "--stats", statistics]
    run("render", shot, *always, *options, nice=nice)
    made = json.loads(statistics.read_text())["frames"]
    return {one["frame"]: folder / f"frame.{one['frame']:04}.exr" for one in made}, made


def bounces(depth):
    """Surfaces that a path of Afterimage meets, where Mitsuba's have `depth` segments: the first is the eye's, the
    last goes to a light."""
    return depth - 2


def reference(place, folder, depth, grids, paths, out):
    """Writes a picture for each of `grids` (N, for N x N samples a pixel), with so many paths a sample.

    What is chosen by chance follows from where samples are: other grids make other choices.
    """
    folder.mkdir(parents=True, exist_ok=True)
    shot, last = write_shot(folder / "shot.toml", place), last_frame(place)
    pictures = []
    for grid in grids:
        options = ["--mode", "full", "--samples", grid, "--paths", paths, "--bounces", bounces(depth)]
        files, _ = render(shot, folder, str(last), options, nice=True)
        pictures.append(picture(files[last]))
    np.save(out, np.array(pictures, np.float32))


def measured(place, folder, depth, truth, mode, setting, rounds):
    """The row of one setting, as `measured_files` has it, with the error of the last frame."""
    row, files = measured_files(place, folder, depth, mode, setting, rounds)
    shown = picture(files[last_frame(place)], "denoised" if mode.endswith("+denoise") else None)
    return row | {"error": measure.relative_rmse(shown, truth)}


def measured_files(place, folder, depth, mode, setting, rounds):
    """The row of one setting: N, for N x N samples a pixel, paths of a new sample, paths that a kept one may get, rays to the panel
    and as many reflected ones where materials are rough; quality of the denoiser, if not the highest.

    `mode` is "full", "inferred" or "filled", with "+denoise" behind it or not. Seconds are the mean over frames, of each
    the fastest round, without writing files; of a chain also the mean over a cycle of frames with its base frame.
    Returns the row and the files, by frame.
    """
    folder.mkdir(parents=True, exist_ok=True)
    grid, paths, most, light_samples, *quality = setting
    how, _, denoise = mode.partition("+")
    # the truth has a box, which the area is where samples need not be in the centres of their cells
    pixel_filter = "box" if how == "full" else "area"
    shot, last = write_shot(folder / "shot.toml", place, light_samples, pixel_filter), last_frame(place)
    options, frames = options_of(how, last, grid, paths, most)
    options += ["--bounces", bounces(depth), "--reflections", light_samples]
    options += ["--denoise-quality", *(quality or ["high"])] if denoise else []
    taken = []
    for _ in range(rounds):
        with measure.timed_turn():
            files, made = render(shot, folder, frames, options)
        taken.append([one["seconds"]["total"] - one["seconds"]["write"] for one in made])
    fastest = np.min(taken, axis=0)
    counted = [at for at, one in enumerate(made) if how == "full" or one["frame"] >= FIRST_MEASURED]
    seconds = float(fastest[counted].mean())
    words = words_of(grid, paths, most, light_samples, "to the panel" if "panel" in place else "reflected")
    words += "".join(f"; {one}" for one in quality)
    row = {"renderer": f"Afterimage, {mode}", "depth": depth, "setting": words, "seconds": seconds}
    if how != "full":
        row["cycle"] = float(fastest[0] + (CYCLE - 1) * seconds) / CYCLE
    return row, files


def words_of(grid, paths, most, light_samples, use):
    words = f"{grid} x {grid} samples, {paths} path{'s' if paths > 1 else ''}"
    return words + (f", up to {most}" if most > paths else "") + f"; {light_samples} {use}"


def options_of(how, last, grid, paths, most):
    """Options and frames of a mode."""
    options = ["--samples", grid, "--paths", most]
    if how == "full":
        return [*options, "--mode", "full"], f"{last - FULL_FRAMES + 1}-{last}"
    options += ["--mode", "reproject", "--base-every", "0"]
    if how == "filled":
        options += ["--paths-per-frame", paths, "--budget", "full"]
    return options, f"1-{last}"

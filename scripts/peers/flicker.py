"""Flicker of denoised frames: how much the error changes from frame to frame, along points that stay in sight.

The last two frames of a move of the camera: into the rough kitchen under a panel and a sky, or towards the city, as rough, under
a sun and a sky. Afterimage infers frames, or traces each in full; Cycles renders them with the seed of the frame, or with one seed
for all frames. All are denoised by Open Image Denoise.
"""

import math

import numpy as np

from . import afterimage, measure, places, workers
from .report import markdown, say

SIZE, SMALL = [320, 180], [96, 54]
DEPTH, ROUGHNESS = 4, 0.5
DARK = 0.1  # radiance below which errors are not counted as larger shares of it
NEAR = 0.02  # a point is in sight in both frames where what is seen is as near, as a share of the distance
FRAMES = [places.FRAMES - 1, places.FRAMES]

# N, for N x N samples a pixel; paths of a new sample; paths that a kept one may get; reflections and rays to the panel
SETTINGS = {
    "full": [(1, 4, 4, 4), (2, 2, 2, 4), (3, 2, 2, 4), (3, 4, 4, 4)],
    "inferred": [(2, 16, 16, 4), (4, 4, 4, 4), (6, 4, 4, 4), (8, 2, 2, 1)],
    "filled": [(4, 2, 16, 4), (6, 2, 8, 4), (8, 1, 8, 1), (12, 1, 2, 1)],
}
SAMPLES = [4, 8, 16, 32, 64]  # a pixel, of Cycles
# references are denoised as well: their own noise would be more than what is measured
REFERENCE_GRID, REFERENCE_PATHS, REFERENCE_SAMPLES = 12, 4, 1024


PLACES = {"kitchen": places.kitchen, "city": places.city}


def main(work, rounds, quick, where):
    """Measures at one of `PLACES`, and returns the table and what it needs to be understood, in Markdown."""
    work = work / "flicker" / where
    work.mkdir(parents=True, exist_ok=True)
    place = PLACES[where](work / "scene", SMALL if quick else SIZE, roughness=ROUGHNESS)
    found = workers.found()
    if "afterimage" not in found:
        raise afterimage.Failed("the points in sight are those of Afterimage: make build")
    grid, samples = (3, 16) if quick else (REFERENCE_GRID, REFERENCE_SAMPLES)
    points, truth = own_reference(work, place, grid)
    pairs = points_in_sight(place, *points)
    say(f"{len(pairs[0])} of {place['size'][0] * place['size'][1]} points stay in sight")
    rows = []
    for mode, settings in SETTINGS.items():
        for setting in settings[:1] if quick else settings:
            rows.append(own_row(work, place, mode, setting, rounds, truth, pairs))
            say("{renderer}: {setting}: {seconds:.3f} s, error {error:.2%}, temporal {temporal:.2%}".format(**rows[-1]))
    if "cycles" in found:
        rows += cycles_rows(work, place, SAMPLES[:2] if quick else SAMPLES, samples, rounds, pairs)
    return report(found, rows)


# --- points ---


def points_in_sight(place, before, after):
    """Pixels of the last frame, and those of the frame before that show the same points; flat indices.

    `before` and `after`: positions, shape (height, width, 3), and whether a surface is seen."""
    width, height = place["size"]
    eye, target = (np.array(end) for end in places.dolly_view(place, FRAMES[0]))
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, [0, 1, 0])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    (positions_before, _), (positions, is_surface) = before, after
    offsets = positions - eye
    depth = offsets @ forward
    half = math.tan(math.radians(place["fov"]) / 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        x = np.floor((offsets @ right / depth / (half * width / height) + 1) * 0.5 * width)
        y = np.floor((1 - offsets @ up / depth / half) * 0.5 * height)
    inside = is_surface & (depth > 0) & (x >= 0) & (x < width) & (y >= 0) & (y < height)
    rows, columns = np.nonzero(inside)
    was = y[inside].astype(int), x[inside].astype(int)
    distance = np.linalg.norm(offsets[inside], axis=1)
    same = np.linalg.norm(positions_before[was] - positions[inside], axis=1) < NEAR * distance
    flat = rows[same] * width + columns[same], was[0][same] * width + was[1][same]
    return flat[0], flat[1]


def errors(pictures, truth):
    """Relative errors of the two frames, shape (pixels, 3) each."""
    return [((one - right) / (right + DARK)).reshape(-1, 3) for one, right in zip(pictures, truth)]


def figures(pictures, truth, pairs):
    """The root mean square of the relative error, and of its change along points that stay in sight."""
    before, after = errors(pictures, truth)
    change = after[pairs[0]] - before[pairs[1]]
    return {"error": float(np.sqrt(np.mean(after**2))), "temporal": float(np.sqrt(np.mean(change**2)))}


# --- work ---


def own_reference(work, place, grid):
    """Positions and surfaces of both frames, and their references."""
    shot = afterimage.write_shot(work / "shot.toml", place, 4)
    frames = f"{FRAMES[0]}-{FRAMES[1]}"
    centres, _ = afterimage.render(shot, work / "centres", frames, ["--mode", "full", "--paths", "0"], layers="P,object")
    points = []
    for frame in FRAMES:
        channels = afterimage.channels(centres[frame])
        points.append((np.stack([channels[f"P.{axis}"] for axis in "XYZ"], axis=2), channels["object.V"] > 0))
    path = work / "afterimage.npy"
    with workers.kept(path, [str(afterimage.program().stat().st_mtime), place, grid, REFERENCE_PATHS]) as missing:
        if missing:
            say("references of Afterimage")
            options = ["--mode", "full", "--samples", grid, "--paths", REFERENCE_PATHS, "--denoise"]
            options += ["--bounces", afterimage.bounces(DEPTH)]
            files, _ = afterimage.render(shot, work / "reference", frames, options)
            np.save(path, np.array([afterimage.picture(files[frame], "denoised") for frame in FRAMES]))
    return points, np.load(path)


def own_row(work, place, mode, setting, rounds, truth, pairs):
    row, files = afterimage.measured_files(place, work / "frames", DEPTH, f"{mode}+denoise", setting, rounds)
    return row | figures([afterimage.picture(files[frame], "denoised") for frame in FRAMES], truth, pairs)


def cycles_rows(work, place, ladder, reference_samples, rounds, pairs):
    views = [places.dolly_view(place, frame) for frame in FRAMES]
    job = {"place": place, "views": views, "depth": DEPTH, "rounds": rounds}
    truth = work / "cycles.npy"
    with workers.kept(truth, [place, views, DEPTH, reference_samples]) as missing:
        if missing:
            say("references of Cycles")
            one = [{"path": str(truth), "samples": reference_samples, "seeds": [1001, 1002]}]
            workers.run(work, "cycles", job | {"rounds": 1, "sequences": one})
    say("Cycles")
    sequences = [
        {"path": str(work / f"cycles-{name}-{samples}.npy"), "samples": samples, "seeds": seeds, "name": name}
        for name, seeds in {"a seed a frame": FRAMES, "one seed": [0, 0]}.items()
        for samples in ladder
    ]
    rows_file = work / "cycles.jsonl"
    rows_file.unlink(missing_ok=True)
    workers.run(work, "cycles", job | {"sequences": sequences, "rows": str(rows_file)})
    rows = []
    for row in measure.read_rows(rows_file):
        pictures = np.load(work / f"cycles-{row['name']}-{row['samples']}.npy")
        setting = f"{row['samples']} samples"
        found = {"renderer": f"Cycles, {row['name']}", "setting": setting, "seconds": row["seconds"]}
        rows.append(found | figures(pictures, np.load(truth), pairs))
    return rows


# --- report ---


def report(found, rows):
    lines = [["renderer", "setting", "s a frame", "with base frames", "error %", "temporal error %"]]
    lines.append(["---", "---", "---:", "---:", "---:", "---:"])
    for row in rows:
        cycle = f"{row['cycle']:.3f}" if "cycle" in row else ""
        line = [row["renderer"], row["setting"], f"{row['seconds']:.3f}", cycle]
        lines.append([*line, f"{100 * row['error']:.2f}", f"{100 * row['temporal']:.2f}"])
    own = [row for row in rows if "cycle" in row]
    return f"{', '.join(found.values())}.\n\n{markdown(lines)}\n\n{equal_time(rows, own)}\n"


def equal_time(rows, own):
    """Temporal errors at the time of each setting that reuses samples: those of the others, interpolated on logarithmic scales."""
    others = [name for name in dict.fromkeys(row["renderer"] for row in rows) if not any(row["renderer"] == name for row in own)]
    lines = [["at the time of", "s", "temporal error %", *others], ["---", "---:", "---:", *["---:" for _ in others]]]
    for row in own:
        line = [f"{row['renderer']}, {row['setting']}", f"{row['cycle']:.3f}", f"{100 * row['temporal']:.2f}"]
        for name in others:
            series = sorted((one["seconds"], one["temporal"]) for one in rows if one["renderer"] == name)
            seconds, temporal = (np.log([pair[at] for pair in series]) for at in (0, 1))
            at_time = math.exp(np.interp(math.log(row["cycle"]), seconds, temporal))
            line.append(f"{100 * at_time:.2f}, {at_time / row['temporal']:.1f} times")
        lines.append(line)
    return markdown(lines)

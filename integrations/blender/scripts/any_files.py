# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders the current frames of any .blend files by Cycles and by Afterimage, and says how far the pictures are apart.

Usage: PYTHON_WITH_BPY any_files.py FOLDER FILE..., with the renderer's Python module. Each picture is 240 pixels wide and as its file has it (view transform,
world, motion blur), without compositing; each render is a process of its own with LIMIT seconds, as files of strangers may bring Blender down. FOLDER keeps
pictures and logs; those that are there are not rendered again. Says, in 255ths, by how much fields of 12 x 12 pixels differ: the mean and the largest; and what
was told. `alike` is a mean below ALIKE with at most a twentieth of the fields beyond FAR; all others are to be looked at.
"""

import os
import subprocess
import sys

import bpy
import numpy as np

WIDTH, FIELD = 240, 12

LIMIT = 240
"""Seconds."""

ALIKE, FAR = 5.0, 20.0
"""Differences of fields, in 255ths."""


def render(file, out, engine):
    """Renders a file's current frame."""
    bpy.ops.wm.open_mainfile(filepath=file, load_ui=False, use_scripts=False)
    scene = bpy.context.scene
    if engine == "AFTERIMAGE":
        sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "tests"))
        import support

        module = support.extension()
        if not hasattr(bpy.types.Scene, "afterimage"):
            module.register()
    shown = scene.render
    height = min(2 * WIDTH, max(16, round(WIDTH * shown.resolution_y / max(1, shown.resolution_x))))
    shown.resolution_x, shown.resolution_y, shown.resolution_percentage = WIDTH, height, 100
    shown.use_border = shown.use_compositing = shown.use_sequencer = False
    settings = shown.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "IMAGE"
    settings.file_format = "PNG"
    shown.filepath, shown.engine = out, engine
    if engine == "CYCLES":
        cycles = scene.cycles
        cycles.device, cycles.samples, cycles.seed = "CPU", 96, 0
        cycles.use_adaptive_sampling, cycles.adaptive_threshold, cycles.use_denoising = True, 0.03, True
    bpy.ops.render.render(write_still=True)


def fields(path):
    """Means of the fields of a picture, in 255ths, over grey where it is clear."""
    image = bpy.data.images.load(path, check_existing=False)
    image.colorspace_settings.name = "Non-Color"
    values = np.empty(image.size[0] * image.size[1] * 4, dtype=np.float32)
    image.pixels.foreach_get(values)
    values = values.reshape(image.size[1], image.size[0], 4)
    shown = 255 * (values[:, :, :3] * values[:, :, 3:] + 0.35 * (1 - values[:, :, 3:]))
    rows, columns = (size // FIELD for size in shown.shape[:2])
    return shown[: rows * FIELD, : columns * FIELD].reshape(rows, FIELD, columns, FIELD, 3).mean(axis=(1, 3))


def made(folder, number, file, engine):
    """The picture of a file by a renderer; None if there is none."""
    out = os.path.join(folder, f"{number:03}_{engine.lower()}.png")
    if not os.path.exists(out):
        with open(out[:-4] + ".log", "w", encoding="utf-8") as log:
            try:
                subprocess.run([sys.executable, __file__, "--one", file, out, engine], stdout=log, stderr=subprocess.STDOUT, timeout=LIMIT, check=False)
            except subprocess.TimeoutExpired:
                pass
    return out if os.path.exists(out) else None


def main(folder, files):
    os.makedirs(folder, exist_ok=True)
    alike = both = 0
    for number, file in enumerate(files):
        cycles, ours = (made(folder, number, file, engine) for engine in ("CYCLES", "AFTERIMAGE"))
        if not cycles or not ours:
            print(f"{number:3} no picture by {'Cycles' if not cycles else 'Afterimage'}: {file}", flush=True)
            continue
        off = np.abs(fields(cycles) - fields(ours)).max(axis=2)
        is_alike = off.mean() < ALIKE and (off > FAR).mean() <= 0.05
        alike, both = alike + is_alike, both + 1
        with open(ours[:-4] + ".log", encoding="utf-8", errors="replace") as log:
            told = {line.strip() for line in log if line.startswith("Afterimage: ")}
        said = "alike" if is_alike else "LOOK "
        print(f"{number:3} {said} {off.mean():5.1f} {off.max():4.0f}, {len(told)} told: {file}", flush=True)
    print(f"{alike} of {both} are alike")


if __name__ == "__main__":
    if sys.argv[1] == "--one":
        render(*sys.argv[2:5])
    else:
        main(sys.argv[1], sys.argv[2:])

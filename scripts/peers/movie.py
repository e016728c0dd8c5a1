"""A short movie of the rough kitchen, denoised, from three renderers beside each other: how each flickers.

Afterimage infers its frames; Cycles renders them with one seed for all frames, and with the seed of each frame. Its samples are so many that
it takes the time of an inferred frame or more.
"""

import numpy as np

from . import afterimage, flicker, measure, places, workers
from .report import say

SETTING = (4, 4, 4, 4)  # as in flicker.SETTINGS
SAMPLES = 4  # a pixel, of Cycles
ZOOM = 2  # pixels of the movie to one of a picture, across and down
DELAY = 80  # milliseconds a frame
BRIGHTER = 2.0  # what the light of all pictures is multiplied by
TITLES = {"own": "Afterimage, reuse", "one": "Cycles, one seed", "each": "Cycles, a seed a frame"}


def main(work, quick, path):
    """Renders what is missing, writes the movie to `path`, and returns a line on it."""
    work /= "movie"
    work.mkdir(parents=True, exist_ok=True)
    size = flicker.SMALL if quick else flicker.SIZE
    place = places.kitchen(work / "kitchen", size, roughness=flicker.ROUGHNESS)
    frames = list(range(1, places.FRAMES + 1))
    say("Afterimage")
    row, files = afterimage.measured_files(place, work / "frames", flicker.DEPTH, "inferred+denoise", SETTING, 1)
    pictures = {"own": [afterimage.picture(files[frame], "denoised") for frame in frames]}
    say("Cycles")
    seeds = {"one": [0] * len(frames), "each": frames}
    sequences = [{"path": str(work / f"{name}.npy"), "samples": SAMPLES, "seeds": of, "name": name} for name, of in seeds.items()]
    rows = work / "cycles.jsonl"
    rows.unlink(missing_ok=True)
    views = [places.dolly_view(place, frame) for frame in frames]
    workers.run(work, "cycles", {"place": place, "views": views, "depth": flicker.DEPTH, "rounds": 1, "sequences": sequences, "rows": str(rows)})
    pictures |= {name: list(np.load(work / f"{name}.npy")) for name in seeds}
    write(path, pictures)
    taken = [f"{TITLES['own']}: {row['cycle']:.2f} s a frame"]
    taken += [f"{TITLES[one['name']]}: {one['seconds']:.2f} s" for one in measure.read_rows(rows)]
    return f"{path}: {'; '.join(taken)}"


def write(path, pictures):
    """Writes the pictures of all renderers in a row, there and back, so that the movie has no seam."""
    from PIL import Image, ImageDraw

    shown = []
    for side_by_side in zip(*(pictures[name] for name in TITLES)):
        panels = []
        for title, picture in zip(TITLES.values(), side_by_side):
            panel = Image.fromarray(on_screen(picture)).resize([ZOOM * side for side in picture.shape[1::-1]], Image.NEAREST)
            draw = ImageDraw.Draw(panel)
            draw.rectangle([0, 0, 8 + draw.textlength(title), 15], fill=(0, 0, 0))
            draw.text((4, 2), title, fill=(255, 255, 255))
            panels.append(np.asarray(panel))
        shown.append(Image.fromarray(np.concatenate(panels, axis=0)))
    shown += shown[-2:0:-1]
    shown[0].save(path, save_all=True, append_images=shown[1:], duration=DELAY, loop=0, quality=45, method=6)


def on_screen(picture):
    """sRGB of linear light, 8 bits."""
    light = np.clip(BRIGHTER * np.asarray(picture, np.float64), 0, 1)
    curved = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return np.round(255 * curved).astype(np.uint8)

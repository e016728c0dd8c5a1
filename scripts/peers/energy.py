"""Whether Afterimage's pictures are as bright as Mitsuba's, field by field of the picture, and how sure that is."""

import numpy as np

from . import afterimage, measure, places, workers
from .report import markdown, rounded, say

FIELDS = 4  # along each edge of a picture
DEPTH = 5  # of Mitsuba's paths: light that has bounced up to three times
SAMPLES, PARTS = 256, 16  # a pixel in each of Mitsuba's pictures, and how many: 4096 in all
GRIDS, PATHS = [9, 10, 11, 12, 13, 14, 15, 16], 4  # Afterimage's pictures, N x N samples a pixel each, and paths a sample
UNSURE = 3.0  # standard errors: of 16 fields that are equal one in 23 pictures has one that is further off


def cases(work, quick):
    """Title and place of each comparison."""
    square, wide = ([32, 32], [48, 27]) if quick else ([256, 256], [320, 180])
    box, open_box = (places.cornell(work / name, square, closed=name == "box") for name in ("box", "open-box"))
    bathroom = places.bathroom(work / "bathroom", wide)
    return {
        "Box, a lamp that is a surface": box,
        "Box without a ceiling, even sky": open_box | {"sky": [0.8, 0.9, 1.0]},
        "Bathroom, its lamps": bathroom,
        "Bathroom, its lamps and an even sky": bathroom | {"sky": [0.8, 0.9, 1.0]},
        "Kitchen, a panel below a black plate": places.kitchen(work / "kitchen-plate", wide, plate=True),
    }


def main(work, quick):
    found = workers.found()
    if not {"afterimage", "mitsuba"} <= set(found):
        return "Nothing compared: this takes Afterimage and Mitsuba.\n"
    texts = []
    for number, (title, place) in enumerate(cases(work, quick).items()):
        pictures = {}
        for renderer in ("afterimage", "mitsuba"):
            path = work / f"energy-{number}-{renderer}.npy"
            make(work, path, place, renderer, found[renderer], quick)
            pictures[renderer] = np.load(path).astype(np.float64)
        texts.append(compared(title, pictures["afterimage"], pictures["mitsuba"]))
        say(f"{title}: done")
    return "\n\n".join(texts) + "\n"


def make(work, path, place, renderer, version, quick):
    """Renders the pictures of a renderer, independent of each other, unless they are there."""
    if renderer == "afterimage":
        grids, paths = ([4, 5], 4) if quick else (GRIDS, PATHS)
        plan = [version, str(afterimage.program().stat().st_mtime), place, DEPTH, grids, paths]
        with workers.kept(path, plan) as missing:
            if missing:
                afterimage.reference(place, work / "reference", DEPTH, grids, paths, path)
        return
    samples, parts = (16, 4) if quick else (SAMPLES, PARTS)
    job = {"depth": DEPTH, "samples": samples, "parts": parts, "path": str(path)}
    with workers.kept(path, [version, place, job]) as missing:
        if missing:
            workers.run(work, renderer, {"place": place, "reference": job}, nice=True)


def compared(title, ours, theirs):
    """The table of a case: in each field how far our mean is from theirs, and the standard error of that, in percent."""
    (our_means, our_errors), (their_means, their_errors) = fields(ours), fields(theirs)
    off = our_means / their_means - 1
    sure = np.hypot(our_errors / our_means, their_errors / their_means)
    beyond = int((np.abs(off) > UNSURE * sure).sum())
    whole = ours.mean() / theirs.mean() - 1
    lines = [["left", *[""] * (FIELDS - 2), "right"], ["---:"] * FIELDS]
    lines += [[cell(*values) for values in zip(*rows)] for rows in zip(off, sure)]
    verdict = f"Whole picture {rounded(100 * whole, 3):+.3f} %. Fields off by more than {UNSURE:.0f} standard errors: {beyond} of {off.size}."
    return f"**{title}.** {verdict}\n\n{markdown(lines)}"


def cell(off, sure):
    text = f"{rounded(100 * off, 2):+.2f} ± {100 * sure:.2f}"
    return f"**{text}**" if abs(off) > UNSURE * sure else text


def fields(pictures):
    """Means of the fields of pictures, shape (FIELDS, FIELDS), and their standard errors as the pictures differ."""
    height, width = pictures.shape[1:3]
    rows, columns = (np.linspace(0, edge, FIELDS + 1).astype(int) for edge in (height, width))
    means = np.array([
        [
            pictures[:, top:bottom, left:right].mean((1, 2, 3))
            for left, right in zip(columns, columns[1:])
        ]
        for top, bottom in zip(rows, rows[1:])
    ])
    return means.mean(2), means.std(2, ddof=1) / np.sqrt(means.shape[2])

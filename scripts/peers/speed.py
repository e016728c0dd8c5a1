"""Seconds a frame to a relative error of 10 %, in all renderers that are there: the matt kitchen under a panel, or with rough materials
under a panel and a sky; frames are sharp, or blurred as the camera turns or has a lens."""

from . import afterimage, measure, places, workers
from .report import markdown, rounded, say

# how frames are blurred
CAMERAS = {
    "sharp": "",
    "turns": f"The camera turns by {places.TURN:g} degrees a frame; the shutter is open for {360 * places.SHUTTER:g} degrees about the frame's own time.",
    "lens": f"The camera has a lens, in focus where it looks; a point twice as far away is a disc of {places.DISC:.1%} of the picture's height.",
}
UNMOVED = {"mitsuba": "Mitsuba is left out: its camera does not move here."}  # renderers without a camera that turns
SIZE, SMALL = [320, 180], [96, 54]
DEPTHS = {3: "light that bounced once", 4: "light that bounced twice"}

# what Afterimage is tried with: N, for N x N samples a pixel; paths of a new sample; paths that a kept one may get; shadow
# rays of a sample to the panel: kept ones cost nothing; quality of the denoiser, if not the highest
GRIDS = {
    "full": [(4, 1, 1, 1), (5, 1, 1, 1), (6, 1, 1, 1), (7, 1, 1, 1), (8, 1, 1, 1), (5, 2, 2, 1)],
    "inferred": [(3, 16, 16, 16), (4, 3, 3, 16), (4, 4, 4, 16), (4, 8, 8, 16), (5, 4, 4, 4), (6, 2, 2, 4)],
    "filled": [(4, 1, 8, 16), (4, 1, 16, 16), (5, 1, 4, 4), (5, 1, 8, 4), (5, 1, 8, 16), (6, 1, 4, 4), (6, 1, 8, 4)],
    "full+denoise": [(2, 1, 1, 1), (3, 1, 1, 1), (3, 2, 2, 1), (4, 1, 1, 1), (5, 1, 1, 1)],
    "inferred+denoise": [(3, 4, 4, 16), (3, 4, 4, 16, "balanced"), (4, 2, 2, 4), (4, 2, 2, 4, "balanced"), (5, 2, 2, 4)],
    "filled+denoise": [(3, 1, 4, 16), (3, 1, 4, 16, "balanced"), (4, 1, 4, 4), (5, 1, 4, 4)],
}
# of rough materials: the fourth number is that of reflections as well
ROUGH_GRIDS = {
    "full": [(5, 1, 1, 1), (5, 2, 2, 1), (4, 2, 2, 1), (4, 4, 4, 4)],
    "inferred": [(3, 8, 8, 4), (4, 4, 4, 4), (4, 8, 8, 4), (4, 12, 12, 4), (5, 4, 4, 4), (6, 2, 2, 4)],
    "filled": [(3, 4, 16, 4), (4, 2, 16, 4), (5, 1, 8, 4)],
    "full+denoise": [(2, 2, 2, 4), (3, 1, 1, 1), (3, 1, 1, 4), (3, 1, 1, 4, "balanced"), (3, 2, 2, 4), (3, 2, 2, 4, "balanced")],
    "inferred+denoise": [
        (2, 4, 4, 4), (3, 2, 2, 4), (3, 4, 4, 4), (4, 2, 2, 4), (4, 1, 1, 4),
        (3, 2, 2, 4, "balanced"), (3, 4, 4, 4, "balanced"), (3, 8, 8, 4, "balanced"), (4, 2, 2, 4, "balanced"), (4, 2, 2, 4, "fast"),
    ],
    "filled+denoise": [(2, 4, 16, 4), (3, 2, 4, 4), (3, 1, 4, 4, "balanced"), (3, 2, 8, 4, "balanced")],
}
# of blurred frames: N that 2 or 3 divides, as with 5 or 7 each sample of a pixel is an exposure of its own, which takes more time
BLURRED_GRIDS = {
    "full": [(4, 1, 1, 1), (6, 1, 1, 1), (6, 2, 2, 1), (8, 1, 1, 1), (8, 2, 2, 1)],
    "inferred": [
        (4, 4, 4, 16), (4, 8, 8, 16), (4, 16, 16, 16), (6, 1, 1, 4), (6, 2, 2, 4), (6, 4, 4, 4), (8, 1, 1, 4), (8, 2, 2, 4),
    ],
    "filled": [(4, 1, 16, 16), (6, 1, 4, 4), (6, 1, 8, 4)],
    "full+denoise": [(2, 2, 2, 4), (4, 1, 1, 1), (4, 2, 2, 1), (6, 1, 1, 1)],
    "inferred+denoise": [(4, 2, 2, 4), (4, 2, 2, 4, "balanced"), (4, 4, 4, 16), (4, 4, 4, 16, "balanced"), (6, 2, 2, 4)],
    "filled+denoise": [(4, 1, 4, 4), (4, 1, 4, 4, "balanced"), (6, 1, 4, 4)],
}
BLURRED_ROUGH_GRIDS = {
    "full": [(4, 2, 2, 1), (4, 4, 4, 4), (6, 1, 1, 1), (6, 2, 2, 1)],
    "inferred": [(4, 4, 4, 4), (4, 8, 8, 4), (4, 12, 12, 4), (6, 2, 2, 4), (6, 4, 4, 4), (6, 8, 8, 4)],
    "filled": [(4, 2, 16, 4), (6, 1, 8, 4)],
    "full+denoise": [(2, 2, 2, 4), (2, 4, 4, 4, "balanced"), (4, 1, 1, 1), (4, 1, 1, 1, "balanced"), (4, 2, 2, 4, "balanced")],
    "inferred+denoise": [
        (2, 4, 4, 4), (4, 1, 1, 4), (4, 2, 2, 4), (4, 4, 4, 4), (6, 2, 2, 4),
        (4, 1, 1, 4, "balanced"), (4, 2, 2, 4, "balanced"), (4, 4, 4, 4, "balanced"), (4, 2, 2, 4, "fast"),
    ],
    "filled+denoise": [(2, 4, 16, 4), (4, 1, 4, 4, "balanced"), (4, 2, 8, 4, "balanced")],
}
REFERENCE_GRIDS, REFERENCE_PATHS = [13, 14, 15, 16], 2
ROUGH_REFERENCE_GRIDS = [9, 10, 11, 12]
BLURRED_REFERENCE_GRIDS, BLURRED_ROUGH_REFERENCE_GRIDS = [10, 14, 15, 16], [8, 9, 10, 12]
# samples a pixel of each part of a reference, and how many parts; the parts' spread tells its error
REFERENCES = {"mitsuba": (1024, 4), "cycles": (512, 4)}
LADDER = [2**power for power in range(12)]  # samples a pixel, until the error is small enough


def main(work, rounds, quick, depths, roughness=None, camera="sharp"):
    """Measures, and returns the table and what it needs to be understood, in Markdown."""
    size = SMALL if quick else SIZE
    if roughness is not None:
        work /= f"rough-{roughness}"
        work.mkdir(parents=True, exist_ok=True)
    place = places.kitchen(work / "kitchen", size, roughness=roughness, camera=camera)
    found = workers.found()
    if camera != "sharp":
        work /= camera
        work.mkdir(exist_ok=True)
    if camera == "turns":
        for renderer, why in UNMOVED.items():
            say(why)
            found.pop(renderer, None)
    if camera == "sharp":
        grids, reference_grids = (GRIDS, REFERENCE_GRIDS) if roughness is None else (ROUGH_GRIDS, ROUGH_REFERENCE_GRIDS)
    elif roughness is None:
        grids, reference_grids = BLURRED_GRIDS, BLURRED_REFERENCE_GRIDS
    else:
        grids, reference_grids = BLURRED_ROUGH_GRIDS, BLURRED_ROUGH_REFERENCE_GRIDS
    rows_file = work / "speed.jsonl"
    rows_file.unlink(missing_ok=True)
    references = make_references(work, place, found, depths, quick, reference_grids)
    if "afterimage" in found:
        grids = {mode: settings[:2] for mode, settings in grids.items()} if quick else grids
        measure_afterimage(work, place, references, rows_file, grids, rounds, depths)
    if "mitsuba" in found:
        # the variant that compiles has its samplers tried; the other one is there for comparison
        for variant, samplers in {"llvm": ["independent", "multijitter"], "scalar": ["multijitter"]}.items():
            measure_peer(work, place, references, rows_file, "mitsuba", samplers, rounds, depths, variant=variant)
    if "cycles" in found:
        denoising = ["denoised", "denoised balanced", "denoised balanced, guides fast"]
        measure_peer(work, place, references, rows_file, "cycles", ["plain", *denoising], rounds, depths)
    return report(found, references, measure.read_rows(rows_file), depths, camera)


# --- work ---


def make_references(work, place, found, depths, quick, grids):
    """The references of each renderer, by renderer and depth; those that have been made of the same are kept."""
    references, grids = {}, [4, 5] if quick else grids
    for renderer in found:
        for depth in depths:
            path = work / f"{renderer}-{depth}.npy"
            references[renderer, depth] = path
            if renderer == "afterimage":
                plan = [found[renderer], str(afterimage.program().stat().st_mtime), place, grids, REFERENCE_PATHS]
                with workers.kept(path, plan) as missing:
                    if missing:
                        say(f"reference of Afterimage, depth {depth}")
                        afterimage.reference(place, work / "reference", depth, grids, REFERENCE_PATHS, path)
                continue
            samples, parts = (16, 2) if quick else REFERENCES[renderer]
            job = {"depth": depth, "samples": samples, "parts": parts, "path": str(path)}
            with workers.kept(path, [found[renderer], place, job]) as missing:
                if missing:
                    say(f"reference of {renderer}, depth {depth}")
                    workers.run(work, renderer, {"place": place, "reference": job}, nice=True)
    return references


def measure_afterimage(work, place, references, rows_file, grids, rounds, depths):
    for depth in depths:
        truth = measure.Reference(references["afterimage", depth]).picture
        for mode, settings in grids.items():
            for setting in settings:
                row = afterimage.measured(place, work / "frames", depth, truth, mode, setting, rounds)
                measure.append(rows_file, row)
                say("{renderer}, depth {depth}: {setting}: {seconds:.3f} s, {error:.1%}".format(**row))


def measure_peer(work, place, references, rows_file, renderer, samplers, rounds, depths, variant=""):
    title = {"mitsuba": f"Mitsuba {variant}", "cycles": "Cycles"}[renderer]
    say(title)
    series = [
        {"name": f"{title}, {sampler}", "depth": depth, "sampler": sampler, "reference": str(references[renderer, depth])}
        for depth in depths
        for sampler in samplers
    ]
    job = {"place": place, "measure": series, "samples": LADDER, "rounds": rounds, "rows": str(rows_file)}
    workers.run(work, renderer, job, variant=variant)


# --- report ---


def report(found, references, rows, depths, camera):
    parts = [CAMERAS[camera]] if CAMERAS[camera] else []
    parts += UNMOVED.values() if camera == "turns" else []
    for depth in depths:
        meaning = DEPTHS[depth]
        parts.append(f"**Direct light and {meaning}** (`bounces = {depth - 2}`; Mitsuba `max_depth` {depth}; "
                     f"Cycles {depth - 2} diffuse bounce{'s' if depth > 3 else ''}).")
        parts.append(table([row for row in rows if row["depth"] == depth]))
    parts.append("References:")
    parts.append(reference_table(found, references, depths))
    return "\n\n".join(parts) + "\n"


def table(rows):
    lines = [["renderer", "setting", "s a frame", "with base frames", "error %", "s to 10 %"]]
    lines.append(["---", "---", "---:", "---:", "---:", "---:"])
    for renderer in dict.fromkeys(row["renderer"] for row in rows):
        own = [row for row in rows if row["renderer"] == renderer]
        seconds, known = measure.seconds_to(own)
        for at, row in enumerate(around(own)):
            to_target = {"between": "{:.3f}", "within": "below {:.3f}", "beyond": "not reached"}[known].format(seconds)
            name, last = (renderer, f"**{to_target}**") if at == 0 else ("", "")
            cycle = f"{row['cycle']:.3f}" if "cycle" in row else ""
            lines.append([name, row["setting"], f"{row['seconds']:.3f}", cycle, f"{100 * row['error']:.1f}", last])
    return markdown(lines)


def around(rows):
    """Of the best settings, the two between which the target is; or the one next to it."""
    best = measure.best_settings(rows)
    better = next((at for at, row in enumerate(best) if row["error"] <= measure.TARGET), len(best))
    return best[max(better - 1, 0) : better + 1]


def reference_table(found, references, depths):
    """How precise the references are, and how far from each other."""
    lines = [["depth", "reference of", "mean", "own error %", "mean, beside the first", "RMSE to the first %"]]
    lines.append(["---:", "---", "---:", "---:", "---:", "---:"])
    for depth in depths:
        loaded = {renderer: measure.Reference(references[renderer, depth]) for renderer in found}
        first = next(iter(loaded.values()), None)
        for renderer, one in loaded.items():
            mean = one.picture.mean()
            line = [str(depth), found[renderer], f"{mean:.5f}", f"{100 * one.own_error():.1f}"]
            apart = f"{rounded(100 * (mean / first.picture.mean() - 1), 2):+.2f} %"
            lines.append([*line, apart, f"{100 * measure.relative_rmse(one.picture, first.picture):.1f}"])
    return markdown(lines)


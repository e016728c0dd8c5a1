# SPDX-License-Identifier: GPL-3.0-or-later
"""Times a shot at several qualities: Cycles with persistent data, and Afterimage, export and files included.

    python integrations/blender/scripts/race.py FOLDER [--shot SHOT] [--blur] [--error] [--stills] [--defaults] [--frames FRAMES] [--width WIDTH] [--reference SAMPLES]

Shots:
    room        a camera that travels past things that rest, 48 frames: the scene of compare_cycles.py, without its glass
    cubes       27 cubes that turn, and two lamps, 10 frames
    character   a body that bends by its bones, two lamps, and a world, 10 frames
    flock       300 instances that fly, 10 frames
    skin        a head of skin that rests, two lamps, and a world, before a camera that goes around it, 24 frames
    patterns    things of forty nodes each, noise and cells of eight octaves, that rest before a camera that travels, 24 frames
    plain       the same of one colour each

--frames: the first FRAMES alone. --blur: with motion blur, half a frame long. --error: counts of ours follow from noise thresholds.
--stills: instead, how long the first ten frames take as an animation, and one by one as scripts render them. --defaults: instead, both as a new
file has them, denoised: Cycles with a noise threshold of 0.01 and at most 4096 samples; ours with finer thresholds as well. Both renderers have a filter of one pixel. The error is that of three frames against a picture of
the same renderer that has next to none, with REFERENCE samples in Cycles (1024): root of the mean square difference, over the mean, of the three
on the mean. How far apart these pictures are is said first. Between the measured qualities time and error are interpolated by their
logarithms. Needs a Python with bpy and afterimage.
"""

import argparse
import os
import sys
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import bpy
import compare_cycles
import numpy as np
import subjects
import support

CYCLES = {False: (16, 32, 64), True: (16, 32)}
"""Samples a pixel, of raw and of denoised pictures."""
OURS = ((2, 4, 4), (4, 1, 1), (4, 4, 4))
"""Samples (N x N), paths, reflected paths."""
THRESHOLDS = (8.0, 4.0, 2.0)
"""Noise thresholds, in percent."""
DEFAULTS = "defaults"
"""The quality of a new file."""
FINE = (1.0, 0.6)
"""Thresholds with which ours comes near the error of Cycles' defaults."""
REFERENCE = (12, 8, 8)
"""The same, of a picture whose error is next to none."""


def room(width, frames):
    """The scene of compare_cycles.py without its glass, which both render differently, and with a camera that travels 1.2 m to the side."""
    scene = compare_cycles.build(width)
    bpy.data.objects.remove(bpy.data.objects["Glass"])
    scene.frame_end = frames
    for frame, x in ((1, -0.6), (frames, 0.6)):
        scene.camera.location.x = x
        scene.camera.keyframe_insert("location", frame=frame)
    return scene


SHOTS = {"room": (room, 48), "cubes": (subjects.cubes, 10), "character": (subjects.character, 10), "flock": (subjects.flock, 10)} | {
    "skin": (subjects.skin, 24),
    "patterns": (subjects.patterns, 24),
    "plain": (subjects.plain, 24),
}
"""Functions that build the scenes, and their numbers of frames."""


def build(options):
    """The scene, and the frames in which it is checked."""
    make, frames = SHOTS[options.shot]
    scene = make(options.width, frames)
    scene.frame_end = frames = min(options.frames or frames, frames)
    if not options.error and not options.defaults:
        scene.afterimage.shadow_rays = "1"
    scene.cycles.max_bounces = scene.afterimage.bounces + 1
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 1.0
    scene.cycles.use_adaptive_sampling = False
    scene.render.use_persistent_data = True
    scene.render.use_motion_blur = options.blur
    image = scene.render.image_settings
    image.file_format, image.color_depth = "OPEN_EXR", "32"
    return scene, [frames // 6, frames // 2, frames * 5 // 6]


def choose(scene, engine, quality, is_denoised=False):
    """Sets the engine and its quality."""
    scene.render.engine = engine
    if engine == "CYCLES":
        scene.cycles.use_adaptive_sampling, scene.cycles.adaptive_threshold = quality == DEFAULTS, 0.01
        scene.cycles.samples, scene.cycles.use_denoising = 4096 if quality == DEFAULTS else quality, is_denoised
        scene.cycles.denoiser = "OPENIMAGEDENOISE"
    else:
        own = scene.afterimage
        own.denoise = is_denoised
        if quality == DEFAULTS:
            own.property_unset("error")
        else:
            own.error = 0 if isinstance(quality, tuple) else quality
        for at, name in enumerate(("samples", "paths", "reflections")):
            if own.error > 0:
                own.property_unset(name)
            else:
                setattr(own, name, quality[at])


def qualities(options, engine, is_denoised):
    """What an engine is measured with."""
    if options.defaults:
        return (DEFAULTS,) if engine == "CYCLES" else (DEFAULTS, *FINE)
    if engine == "CYCLES":
        return CYCLES[is_denoised]
    return THRESHOLDS if options.error else OURS


def pictures(scene, folder, engine, quality, checked):
    """Checked frames of this quality, each rendered by itself."""
    choose(scene, engine, quality)
    scene.afterimage.mode = "full"
    found = []
    for frame in checked:
        scene.frame_set(frame)
        found.append(support.render(scene, os.path.join(folder, f"right.{frame}.exr"))[:, :, :3])
    scene.afterimage.mode = "auto"
    return found


def error_of(found, right):
    """Mean relative error of pictures."""
    return float(np.mean([np.sqrt(((one - other) ** 2).mean()) / other.mean() for one, other in zip(found, right)]))


class Stopwatch:
    """Seconds that the renderer and the export take of a job."""

    def __init__(self):
        session = support.extension().session
        render, export = session.Job.frame, session.export
        self.frames, self.exports = [], []

        def noted(job, engine, at):
            made = render(job, engine, at)
            self.frames.append(made.seconds)
            return made

        def timed(*values):
            start = time.perf_counter()
            done = export(*values)
            self.exports.append(time.perf_counter() - start)
            return done

        session.Job.frame, session.export = noted, timed


def run(scene, folder, engine, quality, is_denoised, right):
    """Renders all frames, and returns seconds, processor seconds of all threads, and error."""
    choose(scene, engine, quality, is_denoised)
    name = f"{engine.lower()}-{quality}-{'denoised' if is_denoised else 'raw'}"
    scene.render.filepath = os.path.join(folder, f"{name}.####")
    start, start_of_all = time.perf_counter(), time.process_time()
    bpy.ops.render.render(animation=True)
    seconds, of_all = time.perf_counter() - start, time.process_time() - start_of_all
    found = [support.read_pixels(os.path.join(folder, f"{name}.{frame:04d}.exr"))[:, :, :3] for frame in right]
    return seconds, of_all, error_of(found, right.values())


def time_at(points, error):
    """Seconds at an error, between measured points of (seconds, error), or beyond them by the nearest two."""
    points = sorted(points, key=lambda point: -point[1])
    times, errors = np.log([point[0] for point in points]), np.log([point[1] for point in points])
    pick = int(np.clip(np.searchsorted(-errors, -np.log(error)) - 1, 0, len(points) - 2))
    share = (np.log(error) - errors[pick]) / (errors[pick + 1] - errors[pick])
    return float(np.exp(times[pick] + share * (times[pick + 1] - times[pick])))


def stills(scene, folder):
    """Seconds of the first ten frames as an animation and one by one, each the lesser of two."""
    scene.frame_end, scene.render.engine = min(scene.frame_end, 10), "AFTERIMAGE"

    def animation():
        scene.render.filepath = os.path.join(folder, "animation.####")
        bpy.ops.render.render(animation=True)

    def one_by_one():
        for frame in range(1, scene.frame_end + 1):
            scene.frame_set(frame)
            scene.render.filepath = os.path.join(folder, f"still.{frame}")
            bpy.ops.render.render(write_still=True)

    taken = {}
    for way in (animation, one_by_one, animation, one_by_one):
        support.extension().session.end()
        start = time.perf_counter()
        way()
        taken.setdefault(way, []).append(time.perf_counter() - start)
    return min(taken[animation]), min(taken[one_by_one])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=os.path.abspath)
    parser.add_argument("--shot", choices=SHOTS, default="room")
    parser.add_argument("--blur", action="store_true")
    parser.add_argument("--error", action="store_true")
    parser.add_argument("--stills", action="store_true")
    parser.add_argument("--defaults", action="store_true")
    parser.add_argument("--frames", type=int)
    parser.add_argument("--width", type=int, default=240)
    parser.add_argument("--reference", type=int, default=1024)
    options = parser.parse_args()
    folder = options.folder
    scene, checked = build(options)
    if options.stills:
        animation, one_by_one = stills(scene, folder)
        print(f"{options.shot}: animation {animation:.2f} s, one by one {one_by_one:.2f} s: {one_by_one / animation:.2f} times")
        sys.stdout.flush()
        os._exit(0)
    right = {engine: dict(zip(checked, pictures(scene, folder, engine, quality, checked))) for engine, quality in (("CYCLES", options.reference), ("AFTERIMAGE", REFERENCE))}
    apart = error_of(right["AFTERIMAGE"].values(), right["CYCLES"].values())
    print(f"{options.shot}{', blur' if options.blur else ''}: what both have next to no error of is {100 * apart:.1f} % apart", flush=True)
    watch, points = Stopwatch(), {}
    for is_denoised in (True,) if options.defaults else (False, True):
        for engine in ("AFTERIMAGE", "CYCLES"):
            for quality in qualities(options, engine, is_denoised):
                watch.frames.clear(), watch.exports.clear()
                seconds, of_all, error = run(scene, folder, engine, quality, is_denoised, right[engine])
                points.setdefault((engine, is_denoised), []).append((seconds, error))
                kind = "denoised" if is_denoised else "raw"
                print(f"{engine} {quality} {kind}: {seconds:.1f} s, {of_all:.1f} processor seconds, error {100 * error:.1f} %", flush=True)
                if watch.frames:
                    rest = seconds - sum(watch.frames) - sum(watch.exports)
                    print(f"  first frame {watch.frames[0]:.2f} s, others {np.mean(watch.frames[1:]):.3f} s each, export {sum(watch.exports):.2f} s,"
                          f" all else {rest:.2f} s", flush=True)
    for is_denoised in () if options.defaults else (False, True):
        for seconds, error in points["CYCLES", is_denoised]:
            ours = time_at(points["AFTERIMAGE", is_denoised], error)
            print(f"{'denoised' if is_denoised else 'raw'}, error {100 * error:.1f} %: Cycles {seconds:.1f} s, Afterimage {ours:.1f} s, {seconds / ours:.1f} times")
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main()

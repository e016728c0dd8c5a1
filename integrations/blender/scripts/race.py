# SPDX-License-Identifier: GPL-3.0-or-later
"""Times 48 frames with a moving camera: Cycles with persistent data, and Afterimage, export and files included.

    python integrations/blender/scripts/race.py FOLDER [WIDTH [CYCLES_SAMPLES [SAMPLES PATHS REFLECTIONS]]]

The scene is that of compare_cycles.py without its glass, which both render differently. The error is that of frame 24 against Cycles with
16 times the samples: root of the mean square difference, over the mean. Needs a Python with bpy and afterimage.
"""

import os
import sys
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import bpy
import compare_cycles
import numpy as np
import support

FRAMES, MIDDLE = 48, 24


def main():
    folder = os.path.abspath(sys.argv[1])
    numbers = [int(value) for value in sys.argv[2:]] + [240, 32, 2, 16, 8][len(sys.argv) - 2 :]
    width, cycles_samples, samples, paths, reflections = numbers
    scene = compare_cycles.build(width)
    bpy.data.objects.remove(bpy.data.objects["Glass"])
    scene.frame_end = FRAMES
    for frame, x in ((1, -0.6), (FRAMES, 0.6)):
        scene.camera.location.x = x
        scene.camera.keyframe_insert("location", frame=frame)
    own = scene.afterimage
    own.samples, own.paths, own.reflections, own.shadow_rays = samples, paths, reflections, "1"
    scene.cycles.use_denoising = False
    scene.cycles.max_bounces = own.bounces + 1
    scene.render.use_persistent_data = True
    scene.frame_set(MIDDLE)
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 16 * cycles_samples
    right = support.render(scene, os.path.join(folder, "right.exr"))[:, :, :3]
    scene.cycles.samples = cycles_samples
    session = support.extension().session
    inside, exports = [], []
    render, export = session.Job.frame, session.export

    def noted(job, engine, at):
        made = render(job, engine, at)
        inside.append(made.seconds)
        return made

    def timed(*values):
        start = time.perf_counter()
        done = export(*values)
        exports.append(time.perf_counter() - start)
        return done

    session.Job.frame, session.export = noted, timed
    for engine in ("CYCLES", "AFTERIMAGE"):
        scene.render.engine = engine
        scene.render.filepath = os.path.join(folder, f"{engine.lower()}.####")
        start = time.perf_counter()
        bpy.ops.render.render(animation=True)
        seconds = time.perf_counter() - start
        picture = support.read_exr(os.path.join(folder, f"{engine.lower()}.{MIDDLE:04d}.exr"))[:, :, :3]
        error = np.sqrt(((picture - right) ** 2).mean()) / right.mean()
        print(f"{engine}: {seconds:.1f} s, error {100 * error:.1f} %")
    print(f"of these in the renderer {sum(inside):.1f} s, export {sum(exports):.2f} s, all else {seconds - sum(inside) - sum(exports):.2f} s")
    print(f"first frame {inside[0]:.2f} s, the others {np.mean(inside[1:]):.2f} s")
    sys.stdout.flush()
    os._exit(0)


main()

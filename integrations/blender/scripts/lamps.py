# SPDX-License-Identifier: GPL-3.0-or-later
"""Many lamps, and balls that glow, beside Cycles and its light tree: the table of docs/performance.md.

    python integrations/blender/scripts/lamps.py FOLDER [REFERENCE]

A hall with 60 boxes, lit by 300 lamps or by 190 balls of 528 triangles each; light bounces twice. Prints seconds of whole renders on two threads, and the error
(root mean square over the mean, with the brightest hundredth of it and without) against REFERENCE samples of Cycles (512). Pictures are in FOLDER. Needs a Python
with bpy and afterimage.
"""

import os
import random
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "tests"))

import bpy
import numpy as np
import support
from test_surfaces import principled

SIZE = 160, 90
BALLS, LAMPS = 190, 300


def hall():
    """The hall with its boxes."""
    scene = support.empty(*SIZE)
    grey, _ = principled("Grey", Base_Color=(0.6, 0.6, 0.6, 1), Roughness=1.0, Specular_IOR_Level=0.0)
    add_box(scene, "Hall", (-20, -20, 0), (20, 20, 8)).materials.append(grey)
    for number in range(60):
        x, y, height = random.uniform(-18, 18), random.uniform(-14, 18), random.uniform(0.5, 3)
        add_box(scene, f"Box {number}", (x - 0.5, y - 0.5, 0), (x + 0.5, y + 0.5, height)).materials.append(grey)
    support.add_camera(scene, (0, -18, 2))
    return scene


def add_box(scene, name, low, high):
    """Adds a box. Returns its mesh."""
    corners = [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners, [], [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    support.add(scene, name, mesh)
    return mesh


def places(count):
    """Where lamps or balls hang."""
    return [(random.uniform(-19, 19), random.uniform(-19, 19), random.uniform(2, 7.5)) for _ in range(count)]


def lamps():
    """The hall, lit by lamps."""
    scene = hall()
    for number, place in enumerate(places(LAMPS)):
        lamp = bpy.data.lights.new(f"Lamp {number}", "POINT")
        lamp.energy, lamp.shadow_soft_size = random.uniform(2, 20), 0.05
        lamp.color = [random.uniform(0.5, 1) for _ in range(3)]
        support.add(scene, lamp.name, lamp, place)
    return scene


def balls():
    """The hall, lit by balls that glow."""
    scene = hall()
    glow, _ = principled("Glow", Base_Color=(0, 0, 0, 1), Emission_Color=(1, 0.9, 0.7, 1), Emission_Strength=20.0)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=0.06)
    ball = bpy.context.object.data
    bpy.data.objects.remove(bpy.context.object)
    ball.materials.append(glow)
    for number, place in enumerate(places(BALLS)):
        support.add(scene, f"Ball {number}", ball, place)
    return scene


def render(scene, engine, samples, path):
    """Renders with so many samples a pixel. Returns the picture and the seconds."""
    scene.render.engine = engine
    scene.render.threads_mode, scene.render.threads = "FIXED", 2
    cycles, own = scene.cycles, scene.afterimage
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising, cycles.pixel_filter_type = samples, False, False, "BOX"
    cycles.max_bounces = cycles.diffuse_bounces = 2
    cycles.sample_clamp_indirect = cycles.sample_clamp_direct = 0
    own.samples, own.paths, own.bounces, own.shadow_rays, own.mode = round(samples**0.5), 4, 2, "1", "full"
    start = time.perf_counter()
    picture = support.render(scene, path)[:, :, :3]
    return picture, time.perf_counter() - start


def main():
    folder, reference = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 512
    os.makedirs(folder, exist_ok=True)
    for make in (lamps, balls):
        random.seed(7)
        scene, name = make(), make.__name__
        right, _ = render(scene, "CYCLES", reference, os.path.join(folder, f"{name}.exr"))
        for engine, samples in (("CYCLES", 32), ("AFTERIMAGE", 4), ("AFTERIMAGE", 16)):
            picture, seconds = render(scene, engine, samples, os.path.join(folder, f"{name}-{engine.lower()}-{samples}.exr"))
            squares = np.sort(((picture - right) ** 2).ravel())
            errors = [np.sqrt(of.mean()) / right.mean() for of in (squares, squares[: squares.size * 99 // 100])]
            off = picture.mean() / right.mean() - 1
            print(f"{name}: {engine} {samples} samples: {seconds:.2f} s, error {errors[0]:.1%}, {errors[1]:.1%}; mean {off:+.1%}", flush=True)


main()

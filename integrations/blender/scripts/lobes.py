# SPDX-License-Identifier: GPL-3.0-or-later
"""How bright balls of one lobe each are beside Cycles, by roughness: the table of docs/blender.md.

    python integrations/blender/scripts/lobes.py FOLDER [SAMPLES]

A ball in an even world of 0.4, lit by a sun of two degrees from the side. Each number is the brightness of ours over that of Cycles (SAMPLES a pixel, 1024),
in percent above it: of the whole ball, of its middle and of its rim. Needs a Python with bpy and afterimage.
"""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "tests"))

import bpy
import numpy as np
import support
from support import Tree

SIZE = 96, 72
RADIUS = 30.4
"""Of the ball, in pixels."""

WHITE, GOLD, RED = (1, 1, 1, 1), (0.9, 0.6, 0.25, 1), (0.5, 0.08, 0.05, 1)


def principled(**values):
    """A function that makes a Principled BSDF of a roughness."""
    return lambda tree, roughness: tree.add("BsdfPrincipled", {"Roughness": roughness} | {key.replace("_", " ").replace("Ior", "IOR"): value for key, value in values.items()})


def shader(kind, color, **attributes):
    """A function that makes a shader of a roughness."""
    return lambda tree, roughness: tree.add(kind, {"Color": color, "Roughness": roughness}, **attributes)


LOBES = {
    "matt, rough as it says": shader("BsdfDiffuse", (0.97, 0.96, 0.95, 1)),
    "metal (Principled)": principled(Metallic=1.0, Base_Color=GOLD),
    "dark metal (Principled)": principled(Metallic=1.0, Base_Color=(0.2, 0.1, 0.05, 1)),
    "Glossy, Multiscatter GGX": shader("BsdfGlossy", GOLD, distribution="MULTI_GGX"),
    "brushed metal (Anisotropic 0.7)": principled(Metallic=1.0, Base_Color=GOLD, Anisotropic=0.7),
    "plastic (Principled)": principled(Base_Color=RED),
    "black plastic, index 1.8": principled(Base_Color=(0, 0, 0, 1), Ior=1.8),
    "a coat as rough, on plastic": lambda tree, roughness: principled(Base_Color=RED, Coat_Weight=1.0, Coat_Roughness=roughness)(tree, 0.5),
    "a coat as rough, on metal": lambda tree, roughness: principled(Metallic=1.0, Base_Color=GOLD, Coat_Weight=1.0, Coat_Roughness=roughness)(tree, 0.5),
    "sheen as rough, on plastic": lambda tree, roughness: principled(Base_Color=RED, Sheen_Weight=1.0, Sheen_Roughness=roughness)(tree, 0.5),
    "sheen alone": shader("BsdfSheen", (0.9, 0.6, 0.3, 1)),
    "glass, index 1.3": lambda tree, roughness: tree.add("BsdfGlass", {"Color": WHITE, "Roughness": roughness, "IOR": 1.3}, distribution="MULTI_GGX"),
    "translucent": lambda tree, roughness: tree.add("BsdfTranslucent", {"Color": (0.3, 0.6, 0.1, 1)}),
}

ROUGHNESSES = 0.1, 0.3, 0.6, 1.0

DARKEST = 0.003
"""Brightness in Cycles below which a part is next to black."""


def stage():
    """The scene without its ball."""
    scene = support.empty(*SIZE)
    scene.render.film_transparent = True
    scene.world = bpy.data.worlds.new("World")
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.4, 0.4, 0.4, 1)
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = 3.0, np.radians(2)
    support.add(scene, "Sun", sun, (0, 0, 5), (0.7, 0.5, 0))
    support.add_camera(scene, (0, 0, 4.5), (0, 0, 0))
    own = scene.afterimage
    own.samples, own.paths, own.reflections, own.shadow_rays = 4, 64, 32, "16"
    scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 1.0
    return scene


def ball(make, roughness):
    """A smooth ball of what a function makes."""
    material = bpy.data.materials.new("Lobe")
    tree = Tree(material)
    tree.links.new(make(tree, roughness).outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64, radius=1)
    bpy.context.object.data.shade_smooth()
    bpy.context.object.data.materials.append(material)


def parts():
    """Pixels of the whole ball, of its middle and of its rim."""
    rows, columns = np.mgrid[0 : SIZE[1], 0 : SIZE[0]]
    away = np.hypot(rows - (SIZE[1] - 1) / 2, columns - (SIZE[0] - 1) / 2) / RADIUS
    return away < 1.1, away < 0.4, (away > 0.75) & (away < 0.93)


def compare(folder, make, roughness, samples):
    """How much brighter parts of a ball are than in Cycles, in percent."""
    scene = stage()
    ball(make, roughness)
    pictures = []
    for engine in ("AFTERIMAGE", "CYCLES"):
        scene.render.engine, scene.cycles.samples = engine, samples
        pictures.append(support.render(scene, os.path.join(folder, f"{engine.lower()}.exr"))[:, :, :3])
    means = [[picture[part].mean() for part in parts()] for picture in pictures]
    return [f"{100 * (ours / cycles - 1):+.1f}" if cycles > DARKEST else "dark" for ours, cycles in zip(*means)]


def main():
    folder, samples = sys.argv[1], int((sys.argv[2:] or ["1024"])[0])
    os.makedirs(folder, exist_ok=True)
    print("| lobe | " + " | ".join(f"{roughness}" for roughness in ROUGHNESSES) + " |")
    print("|---|" + "---|" * len(ROUGHNESSES))
    for name, make in LOBES.items():
        # what has no roughness has one row of one number
        roughnesses = ROUGHNESSES[:1] if name == "translucent" else ROUGHNESSES
        cells = [" / ".join(compare(folder, make, roughness, samples)) for roughness in roughnesses]
        print(f"| {name} | " + " | ".join(cells + [""] * (len(ROUGHNESSES) - len(cells))) + " |", flush=True)


main()

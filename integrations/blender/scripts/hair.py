# SPDX-License-Identifier: GPL-3.0-or-later
"""How bright dense hair is beside Cycles: the table of docs/blender.md.

    python integrations/blender/scripts/hair.py FOLDER [SAMPLES [NAME...]]

A ball with hair on it, lit by a sun, an area light or a sky: 12,000 children of a particle system (simple, or interpolated), 6,000 hairs of one without
children, 6,000 hair curves, 8,000 short hairs. Each number is the mean of ours over that of Cycles (SAMPLES a pixel, 256), in percent above it, with
*Curves Shape = 3D Curves* and with the default, *Rounded Ribbons*: red, green, blue. Pictures are in FOLDER. Needs a Python with bpy and afterimage.
"""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "tests"))

import bpy
import numpy as np
import support
from mathutils import Vector
from support import Tree
from test_surfaces import principled

SIZE = 160, 120
BOUNCES = 12
COLOR = (0.6, 0.3, 0.1, 1)

CASES = [
    ("simple", "sun", "color"), ("interpolated", "sun", "color"), ("none", "sun", "color"), ("curves", "sun", "color"), ("short", "sun", "color"),
    ("curves", "area", "blond"), ("short", "area", "brown"), ("simple", "sky", "blond"), ("interpolated", "sky", "color"), ("curves", "sky", "brown"),
    ("short", "sky", "blond"), ("simple", "sun", "diffuse"), ("interpolated", "sky", "diffuse"), ("curves", "area", "diffuse"), ("short", "sun", "diffuse"),
]  # fmt: skip


def material(kind):
    """A material of hair, or a matt one."""
    made, _ = principled("Hair")
    tree = Tree(made)
    if kind == "diffuse":
        node = tree.add("BsdfDiffuse", {"Color": COLOR})
    elif kind == "color":
        node = tree.add("BsdfHairPrincipled", {"Color": COLOR}, model="CHIANG", parametrization="COLOR")
    else:
        melanin = {"blond": 0.15, "brown": 0.8}[kind]
        node = tree.add("BsdfHairPrincipled", {"Melanin": melanin, "Melanin Redness": 0.4}, model="CHIANG", parametrization="MELANIN")
    tree.links.new(node.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    return made


def curves(of):
    """Hair curves around a ball."""
    rng, count = np.random.default_rng(2), 6000
    roots = rng.normal(size=(count, 3))
    roots /= np.linalg.norm(roots, axis=1)[:, None]
    along = np.linspace(0, 1, 7)[None, :, None]
    places = roots[:, None] * (0.7 + 0.6 * along) + np.array([0, 0, -0.5]) * along**2 + rng.normal(size=(count, 1, 3)) * 0.05 * along
    data = bpy.data.hair_curves.new("Hair")
    data.add_curves([7] * count)
    data.position_data.foreach_set("vector", places.astype(np.float32).ravel())
    radii = data.attributes.get("radius") or data.attributes.new("radius", "FLOAT", "POINT")
    radii.data.foreach_set("value", np.tile(np.linspace(0.005, 0.0015, 7), count).astype(np.float32))
    data.materials.append(of)
    return data


def stage(hair, light, kind):
    """The scene of a case."""
    scene = support.empty(*SIZE)
    scene.render.film_transparent = True
    scene.world = bpy.data.worlds.new("World")
    color = (0.5, 0.6, 0.7, 1) if light == "sky" else (0, 0, 0, 1)
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = color
    support.add_camera(scene, (0, -6, 0.2), (np.pi / 2, 0, 0))
    if light == "sun":
        sun = bpy.data.lights.new("Sun", "SUN")
        sun.energy, sun.angle = 3.0, 0.05
        support.add(scene, "Sun", sun, (0, 0, 5), (0.9, 0.3, 0.4))
    elif light == "area":
        lamp = bpy.data.lights.new("Lamp", "AREA")
        lamp.energy, lamp.size = 300, 1.5
        place = (2.5, -3, 3)
        support.add(scene, "Lamp", lamp, place, (-Vector(place)).to_track_quat("-Z", "Y").to_euler())
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=0.7)
    ball, of = bpy.context.object, material(kind)
    skin, _ = principled("Skin", Base_Color=(0.5, 0.4, 0.3, 1), Specular_IOR_Level=0.0)
    for one in (skin, of):
        ball.data.materials.append(one)
    ball.data.shade_smooth()
    if hair == "curves":
        support.add(scene, "Hair", curves(of))
    else:
        settings = ball.modifiers.new("Hair", "PARTICLE_SYSTEM").particle_system.settings
        settings.type, settings.material, settings.render_step, settings.display_step = "HAIR", 2, 3, 3
        settings.root_radius, settings.tip_radius = 1, 0.3
        if hair in ("none", "short"):
            settings.count, settings.hair_length, settings.radius_scale = (6000, 0.7, 0.01) if hair == "none" else (8000, 0.12, 0.008)
        else:
            settings.count, settings.hair_length, settings.radius_scale = 600, 0.7, 0.01
            settings.child_type, settings.rendered_child_count, settings.child_radius = hair.upper(), 20, 0.1
    own, other = scene.afterimage, scene.cycles
    own.samples, own.paths, own.reflections, own.bounces, own.depth = 6, 2, 2, BOUNCES, BOUNCES
    other.max_bounces = other.glossy_bounces = other.transmission_bounces = other.diffuse_bounces = BOUNCES
    other.sample_clamp_indirect = other.blur_glossy = 0
    other.use_denoising = False
    other.pixel_filter_type, other.filter_width = "BOX", 1.0
    scene.cycles_curves.subdivisions = 3
    return scene


def main(folder, samples=256, *names):
    os.makedirs(folder, exist_ok=True)
    print("| hair, light, material | 3D curves | ribbons |\n|---|---|---|")
    for case in CASES:
        if names and "-".join(case) not in names:
            continue
        scene = stage(*case)
        ours = support.render(scene, os.path.join(folder, f"{'-'.join(case)}-ours.exr"))
        scene.render.engine, scene.cycles.samples = "CYCLES", int(samples)
        cells = []
        for shape in ("THICK", "RIBBONS"):
            scene.cycles_curves.shape = shape
            theirs = support.render(scene, os.path.join(folder, f"{'-'.join(case)}-{shape.lower()}.exr"))
            means = [image[:, :, :3].mean(axis=(0, 1)) for image in (ours, theirs)]
            cells.append(" / ".join(f"{100 * (one / other - 1):+.1f}" for one, other in zip(*means)))
        print(f"| {', '.join(case)} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(*sys.argv[1:])

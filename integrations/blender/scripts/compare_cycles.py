# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders a scene of twelve objects in Cycles and in Afterimage, and compares the mean brightness of 16 fields.

    python integrations/blender/scripts/compare_cycles.py FOLDER [WIDTH [CYCLES_SAMPLES [PATHS]]]

With PATHS, light through glass is bent and focused (`caustics`), by so many paths a sample.

Writes cycles.exr, afterimage.exr, and side-by-side.png (Cycles on the left) into FOLDER, and prints the table of docs/blender.md.
Needs a Python with bpy and afterimage.
"""

import os
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "tests"))

import bpy
import numpy as np
import support


def image(name, pixels, colorspace="sRGB"):
    """A packed image of pixels, the bottom row first."""
    height, width = pixels.shape[:2]
    full = np.ones((height, width, 4), dtype=np.float32)
    full[:, :, : pixels.shape[2]] = pixels
    made = bpy.data.images.new(name, width, height, alpha=True)
    made.colorspace_settings.name = colorspace
    made.pixels.foreach_set(full.ravel())
    made.pack()
    return made


def material(name, **inputs):
    """A Principled BSDF."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    for key, value in inputs.items():
        shader.inputs[key.replace("_", " ").replace("IOR level", "IOR Level")].default_value = value
    return made


def texture(made, pixels, socket, colorspace="sRGB", output="Color", through=None):
    """Links a picture to an input of a material's shader, by way of another node if `through` says."""
    tree = made.node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image(f"{made.name} {socket}", pixels, colorspace)
    source = node.outputs[output]
    if through:
        between = tree.nodes.new(through)
        tree.links.new(source, between.inputs["Color" if through == "ShaderNodeNormalMap" else "Height"])
        if through == "ShaderNodeBump":
            between.inputs["Distance"].default_value = 0.1
        source = between.outputs["Normal"]
    tree.links.new(source, made.node_tree.nodes["Principled BSDF"].inputs[socket])
    return node


def wood():
    """Rings of two browns."""
    y, x = np.mgrid[0:256, 0:256] / 256
    rings = 0.5 + 0.5 * np.sin(40 * np.hypot(x - 0.5, 0.3 * y + 0.1) + 2 * np.sin(6 * y))
    return (np.array([0.55, 0.35, 0.18]) * rings[..., None] + np.array([0.32, 0.18, 0.08]) * (1 - rings[..., None])).astype(np.float32)


def bricks():
    """Colours and directions of bricks."""
    y, x = np.mgrid[0:256, 0:256] / 256
    row = np.floor(y * 8)
    across, up = (x * 4 + 0.5 * (row % 2)) % 1, (y * 8) % 1
    height = np.clip(np.minimum(np.minimum(across, 1 - across) / 0.05, np.minimum(up, 1 - up) / 0.1), 0, 1)
    colors = np.array([0.6, 0.25, 0.18]) * height[..., None] + 0.55 * (1 - height[..., None])
    dx, dy = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) * 0.4, (np.roll(height, -1, 0) - np.roll(height, 1, 0)) * 0.4
    normal = np.stack([-dx, -dy, np.ones_like(dx)], axis=2)
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    return colors.astype(np.float32), (normal * 0.5 + 0.5).astype(np.float32), height[..., None].astype(np.float32)


def sphere(name, made, place, radius=0.8):
    """A smooth sphere with texture coordinates."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=radius, location=place)
    item = bpy.context.object
    item.name = name
    item.data.materials.append(made)
    item.data.polygons.foreach_set("use_smooth", [True] * len(item.data.polygons))
    return item


def cube(name, made, place, size=1.3, turn=0.4):
    """A cube with texture coordinates."""
    bpy.ops.mesh.primitive_cube_add(size=size, location=place, rotation=(0, 0, turn))
    item = bpy.context.object
    item.name = name
    item.data.materials.append(made)
    return item


def build(width):
    """The scene: four columns and three rows of objects on a floor, a sky that is brighter on one side, and two lamps."""
    scene = support.empty(width, width * 9 // 16)
    colors, directions, heights = bricks()
    floor = material("Floor", Base_Color=(0.5, 0.5, 0.5, 1), Roughness=1.0)
    floor.node_tree.nodes["Principled BSDF"].inputs["Specular IOR Level"].default_value = 0
    mesh = support.grid("Floor", 30)
    mesh.materials.append(floor)
    support.add(scene, "Floor", mesh)
    x, y = (-3.6, -1.2, 1.2, 3.6), (0, 2.6, 5.4)
    sphere("Gold", material("Gold", Base_Color=(1, 0.77, 0.34, 1), Metallic=1.0, Roughness=0.25), (x[0], y[0], 0.8))
    sphere("Glass", material("Glass", Base_Color=(1, 1, 1, 1), Transmission_Weight=1.0, Roughness=0.0, IOR=1.5), (x[1], y[0], 0.8))
    made = material("Wood", Roughness=0.4)
    texture(made, wood(), "Base Color")
    cube("Wood", made, (x[2], y[0], 0.65))
    made = material("Brick", Roughness=0.8)
    texture(made, colors, "Base Color")
    texture(made, directions, "Normal", "Non-Color", through="ShaderNodeNormalMap")
    cube("Brick", made, (x[3], y[0], 0.65))
    sphere("Plastic", material("Plastic", Base_Color=(0.7, 0.05, 0.05, 1), Roughness=0.3), (x[0], y[1], 0.8))
    made = material("Cloth", Roughness=1.0)
    row, column = np.mgrid[0:256, 0:256]
    weave = ((row // 16 + column // 16) % 2).astype(np.float32)
    node = texture(made, np.stack([0.2 + 0 * weave, 0.3 + 0 * weave, 0.6 + 0 * weave, weave], axis=2), "Base Color")
    made.node_tree.links.new(node.outputs["Alpha"], made.node_tree.nodes["Principled BSDF"].inputs["Alpha"])
    mesh = support.grid("Cloth", 1.7)
    mesh.uv_layers.new().uv.foreach_set("vector", np.array([0, 0, 1, 0, 1, 1, 0, 1], dtype=np.float32))
    mesh.materials.append(made)
    support.add(scene, "Cloth", mesh, (x[1], y[1], 0.9), (np.pi / 2, 0, 0.3))
    sphere("Lamp", material("Lamp", Base_Color=(0, 0, 0, 1), Emission_Color=(1, 0.6, 0.3, 1), Emission_Strength=4.0), (x[2], y[1], 0.6), 0.6)
    sphere("Mirror", material("Mirror", Base_Color=(0.9, 0.9, 0.9, 1), Metallic=1.0, Roughness=0.0), (x[3], y[1], 0.8))
    made = material("Bumps", Base_Color=(0.2, 0.5, 0.25, 1), Roughness=0.5)
    texture(made, heights, "Normal", "Non-Color", through="ShaderNodeBump")
    cube("Bumps", made, (x[0], y[2], 0.65))
    sphere("Chalk", material("Chalk", Base_Color=(0.85, 0.85, 0.85, 1), Roughness=1.0), (x[1], y[2], 0.8))
    sphere("Steel", material("Steel", Base_Color=(0.6, 0.6, 0.62, 1), Metallic=1.0, Roughness=0.5), (x[2], y[2], 0.8))
    bpy.ops.mesh.primitive_monkey_add(size=1.7, location=(x[3], y[2], 0.9))
    bpy.context.object.modifiers.new("Smooth", "SUBSURF").levels = 2
    bpy.context.object.data.materials.append(material("Clay", Base_Color=(0.5, 0.3, 0.2, 1), Roughness=0.7))
    world(scene)
    lamp = bpy.data.lights.new("Panel", "AREA")
    lamp.energy, lamp.size = 400, 2
    support.add(scene, "Panel", lamp, (-3, -4, 6), (0.6, -0.3, 0))
    support.add_camera(scene, (0, -9.5, 4.6), (np.radians(69), 0, 0), lens=36)
    own = scene.afterimage
    own.samples, own.paths, own.reflections, own.bounces, own.shadow_rays = 4, 64, 16, 4, "16"
    # all of the light: what Cycles clamps and blurs by default is missing from its mean
    scene.cycles.sample_clamp_indirect, scene.cycles.blur_glossy = 0, 0
    return scene


def world(scene):
    """A map of the sky, bright in one place, turned by 50 degrees."""
    rows, columns = np.mgrid[0:128, 0:256]
    up = rows / 128
    sky = np.stack([0.25 + 0.2 * up, 0.3 + 0.3 * up, 0.35 + 0.5 * up], axis=2)
    sky[up < 0.5] = [0.2, 0.17, 0.14]
    sky += (5 * np.exp(-(((columns - 90) / 14) ** 2 + ((rows - 96) / 10) ** 2)))[..., None]
    full = np.ones((128, 256, 4), dtype=np.float32)
    full[:, :, :3] = sky
    made = bpy.data.images.new("Sky", 256, 128, float_buffer=True)
    made.pixels.foreach_set(full.ravel())
    made.pack()
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    tree = scene.world.node_tree
    node, mapping, place = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexEnvironment", "Mapping", "TexCoord"))
    node.image = made
    mapping.vector_type = "POINT"
    mapping.inputs["Rotation"].default_value[2] = np.radians(50)
    tree.links.new(place.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], node.inputs["Vector"])
    tree.links.new(node.outputs["Color"], tree.nodes["Background"].inputs["Color"])


def main():
    folder = os.path.abspath(sys.argv[1])
    width = int(sys.argv[2]) if len(sys.argv) > 2 else 640
    scene = build(width)
    if len(sys.argv) > 4:
        scene.afterimage.caustics, scene.afterimage.paths = True, int(sys.argv[4])
    found = {}
    for engine in ("CYCLES", "AFTERIMAGE"):
        scene.render.engine = engine
        if engine == "CYCLES":
            scene.cycles.samples = int(sys.argv[3]) if len(sys.argv) > 3 else 256
            scene.cycles.use_denoising = False
            scene.cycles.max_bounces = 12
        start = time.perf_counter()
        found[engine] = support.render(scene, os.path.join(folder, f"{engine.lower()}.exr"))[:, :, :3]
        print(f"{engine}: {time.perf_counter() - start:.1f} s")
    cycles, ours = found["CYCLES"], found["AFTERIMAGE"]
    print("| | 1 | 2 | 3 | 4 |\n|---|---|---|---|---|")
    rows, columns = (np.linspace(0, size, 5).astype(int) for size in ours.shape[:2])
    for row in range(4):
        shares = []
        for column in range(4):
            field = np.s_[rows[row] : rows[row + 1], columns[column] : columns[column + 1]]
            shares.append(f"{100 * (ours[field].mean() / cycles[field].mean() - 1):+.1f} %")
        print(f"| {row + 1} | {' | '.join(shares)} |")
    from afterimage_extension.export import files, images

    both = np.concatenate([cycles, ours], axis=1)
    files.write_png(os.path.join(folder, "side-by-side.png"), (images.to_srgb(both) * 255 + 0.5).astype(np.uint8))
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main()

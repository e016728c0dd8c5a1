# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes Blender's sky texture, by Cycles in a process of its own: a render engine cannot render within a render.

Run by Blender or a Python with bpy, with a JSON of the node's properties and a file for the result: a picture of the sky without its sun,
and the light of the sun on a white surface that faces it.
"""

import json
import math
import os
import subprocess
import sys
import tempfile
import time

import numpy as np

WIDTH = 1024


def properties_of(node):
    """The sky node's own properties, as JSON has them."""
    found = {}
    for entry in node.bl_rna.properties:
        if not (entry.identifier.startswith(("sun_", "air", "ozone", "aerosol", "dust", "altitude", "ground_", "turbidity", "sky_type"))):
            continue
        value = getattr(node, entry.identifier)
        found[entry.identifier] = list(value) if entry.type == "FLOAT" and entry.is_array else value
    return found


_baked = {}
"""The sky that was baked last, by its properties: jobs and viewports mostly want the one before."""


def bake(node, goes_on=lambda: True):
    """Pixels of the sky, (height, width, 3) with row 0 at the bottom, and the radiance of a white surface that faces the sun alone.

    However long that takes: another sky would be another picture. `goes_on` is asked some times a second, and returns false to cancel.
    Raises Cancelled, and ExportError if there is no sky.
    """
    values = json.dumps(properties_of(node))
    if values not in _baked:
        found = _run(values, goes_on)
        _baked.clear()
        _baked[values] = found
    return _baked[values]


def _run(values, goes_on):
    """Bakes the sky of these properties in a process of its own."""
    import bpy

    from .warnings import Cancelled, ExportError

    with tempfile.TemporaryDirectory(prefix="afterimage-sky-") as folder:
        result, said = os.path.join(folder, "sky.npz"), os.path.join(folder, "said.txt")
        command = [bpy.app.binary_path, "-b", "--factory-startup", "--python-exit-code", "1", "--python", __file__, "--"]
        if not bpy.app.binary_path or not os.path.isfile(bpy.app.binary_path):
            # -P: modules of this folder must not stand in for those of Python
            command = [sys.executable, "-P", __file__]
        try:
            with open(said, "wb") as output:
                process = subprocess.Popen([*command, values, result], stdout=output, stderr=output, stdin=subprocess.DEVNULL)
            try:
                while process.poll() is None:
                    if not goes_on():
                        raise Cancelled()
                    time.sleep(0.05)
            finally:
                if process.poll() is None:
                    process.kill()
                    process.wait()
            if process.returncode == 0:
                with np.load(result) as found:
                    return found["sky"], found["sun"]
            why = f"its process ended with code {process.returncode} ({last_words(said)})"
        except (OSError, ValueError) as error:
            why = f"{type(error).__name__}: {error}"
        raise ExportError(f"the world's sky texture cannot be rendered by Cycles: {why}. Try again, or give the world an environment texture instead")


def last_words(path):
    """The last error that a process has written, or its last line."""
    with open(path, encoding="utf-8", errors="replace") as file:
        lines = [line.strip() for line in file if line.strip()]
    return next((line for line in reversed(lines) if "Error" in line), lines[-1] if lines else "it said nothing")


def direction_of(values):
    """The direction to the sun, in Blender's axes."""
    if values["sky_type"] in {"PREETHAM", "HOSEK_WILKIE"}:
        return np.array(values["sun_direction"])
    height, turn = values["sun_elevation"], values["sun_rotation"]
    return np.array([math.sin(turn) * math.cos(height), math.cos(turn) * math.cos(height), math.sin(height)])


def _render(scene, path, width, height):
    import bpy

    scene.render.resolution_x, scene.render.resolution_y, scene.render.filepath = width, height, path
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Linear Rec.709"
    values = np.empty(width * height * 4, dtype=np.float32)
    image.pixels.foreach_get(values)
    bpy.data.images.remove(image)
    return values.reshape(height, width, 4)[:, :, :3]


def main(values, result):
    """Renders the sky all around, and a small white square that faces the sun, with the sun's disk and without."""
    import bpy
    import mathutils

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.render.resolution_percentage = 4, False, 100
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.world = bpy.data.worlds.new("Sky")
    scene.world.use_nodes = True
    tree = scene.world.node_tree
    node = tree.nodes.new("ShaderNodeTexSky")
    node.sky_type = values["sky_type"]
    for key, value in values.items():
        setattr(node, key, value)
    tree.links.new(node.outputs[0], tree.nodes["Background"].inputs["Color"])
    has_disc = values["sky_type"] not in {"PREETHAM", "HOSEK_WILKIE"} and values.get("sun_disc")
    node.sun_disc = False
    data = bpy.data.cameras.new("Camera")
    camera = scene.camera = bpy.data.objects.new("Camera", data)
    scene.collection.objects.link(camera)
    data.type = "PANO"
    # 4.x keeps the kind of panorama with Cycles' own settings
    (data if hasattr(data, "panorama_type") else data.cycles).panorama_type = "EQUIRECTANGULAR"
    # +X in the middle, as an environment texture has it
    camera.rotation_euler = (math.pi / 2, 0, -math.pi / 2)
    path = os.path.join(os.path.dirname(result), "sky.exr")
    sky = _render(scene, path, WIDTH, WIDTH // 2)
    sun = np.zeros(3, dtype=np.float32)
    if has_disc:
        toward = mathutils.Vector(direction_of(values))
        mesh = bpy.data.meshes.new("White")
        mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
        material = bpy.data.materials.new("White")
        material.use_nodes = True
        nodes = material.node_tree
        matt = nodes.nodes.new("ShaderNodeBsdfDiffuse")
        matt.inputs["Color"].default_value = (1, 1, 1, 1)
        nodes.links.new(matt.outputs[0], nodes.nodes["Material Output"].inputs["Surface"])
        mesh.materials.append(material)
        square = bpy.data.objects.new("White", mesh)
        scene.collection.objects.link(square)
        square.rotation_euler = toward.to_track_quat("Z", "Y").to_euler()
        data.type, data.ortho_scale = "ORTHO", 0.5
        camera.location, camera.rotation_euler = toward * 0.5, square.rotation_euler
        scene.cycles.samples = 512
        lit = []
        for disc in (True, False):
            node.sun_disc = disc
            lit.append(_render(scene, path, 16, 16).mean(axis=(0, 1)))
        sun = np.maximum(lit[0] - lit[1], 0)
    np.savez(result, sky=sky, sun=sun)


if __name__ == "__main__":
    main(json.loads(sys.argv[-2]), sys.argv[-1])

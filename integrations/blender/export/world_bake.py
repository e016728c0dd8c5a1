# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes worlds by Cycles, in a process of its own: a render engine cannot render within a render.

Run by Blender or a Python with bpy, with a request as JSON and a file for the result: a picture of what lights, without the suns of sky
textures, one of what the camera sees if that differs, and those suns.
"""

import hashlib
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass

import numpy as np

WIDTH, WIDEST = 1024, 4096
"""Of the picture: that of a sky, and the most that it has of a world with pictures as wide."""
SUN_PIXELS = 128
"""Of the picture of a sun."""


@dataclass
class Sun:
    """The sun of a sky texture."""

    toward: np.ndarray
    """The direction to it, in Blender's axes."""
    angle: float
    """Its diameter in radians."""
    light: np.ndarray
    """Radiance of a white surface that faces it."""


@dataclass
class Baked:
    """Light from all around. Pictures are (height, width, 3), with row 0 at the bottom."""

    light: np.ndarray
    seen: np.ndarray | None
    """What the camera sees; None if it is the same."""
    suns: list


_baked = {}
"""The world that was baked last, by what it is: jobs and viewports mostly want the one before."""


def of_sky(node, goes_on=lambda: True):
    """Bakes a sky texture, however long that takes: another sky would be another picture.

    `goes_on` is asked some times a second, and returns false to cancel. Raises Cancelled, and ExportError if there is no picture.
    """
    return _once({"sky": properties_of(node)}, "sky texture", goes_on)


def of_world(world, state, at, goes_on=lambda: True):
    """Bakes a world, as `of_sky` does. `at`: the time, in frames. `state`: all that it shows then depends on, as text."""
    import bpy

    original = world.original
    with tempfile.TemporaryDirectory(prefix="afterimage-world-") as folder:
        path = os.path.join(folder, "world.blend")
        if original.library:
            path = os.path.normpath(bpy.path.abspath(original.library.filepath))
        else:
            # it goes without the rest of the scene, but for what it refers to
            bpy.data.libraries.write(path, {original}, path_remap="ABSOLUTE", fake_user=True)
        key = hashlib.blake2b(state.encode(), digest_size=16).hexdigest()
        return _once({"world": original.name, "state": key, "time": at, "file": path}, f"world `{original.name}`", goes_on)


def properties_of(node):
    """The sky node's own properties, as JSON has them."""
    found = {}
    for entry in node.bl_rna.properties:
        if not (entry.identifier.startswith(("sun_", "air", "ozone", "aerosol", "dust", "altitude", "ground_", "turbidity", "sky_type"))):
            continue
        value = getattr(node, entry.identifier)
        found[entry.identifier] = list(value) if entry.type == "FLOAT" and entry.is_array else value
    return found


def _once(request, what, goes_on):
    """What was baked of a request last, or is baked now."""
    key = json.dumps({name: value for name, value in request.items() if name not in {"file", "time"}})
    if key not in _baked:
        found = _run(json.dumps(request), what, goes_on)
        _baked.clear()
        _baked[key] = found
    return _baked[key]


def _run(request, what, goes_on):
    """Bakes in a process of its own."""
    import bpy

    from .warnings import Cancelled, ExportError

    with tempfile.TemporaryDirectory(prefix="afterimage-world-") as folder:
        result, said = os.path.join(folder, "world.npz"), os.path.join(folder, "said.txt")
        command = [bpy.app.binary_path, "-b", "--factory-startup", "--python-exit-code", "1", "--python", __file__, "--"]
        if not bpy.app.binary_path or not os.path.isfile(bpy.app.binary_path):
            # -P: modules of this folder must not stand in for those of Python
            command = [sys.executable, "-P", __file__]
        try:
            with open(said, "wb") as output:
                process = subprocess.Popen([*command, request, result], stdout=output, stderr=output, stdin=subprocess.DEVNULL)
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
                return read(result)
            why = f"its process ended with code {process.returncode} ({last_words(said)})"
        except (OSError, ValueError, KeyError) as error:
            why = f"{type(error).__name__}: {error}"
        raise ExportError(f"the {what} cannot be rendered by Cycles: {why}. Try again, or give the world an environment texture instead")


def read(path):
    """What a process has baked."""
    with np.load(path) as found:
        suns = [Sun(row[:3], float(row[3]), row[4:]) for row in found["suns"]]
        return Baked(found["light"], found["seen"] if "seen" in found else None, suns)


def last_words(path):
    """The last error that a process has written, or its last line."""
    with open(path, encoding="utf-8", errors="replace") as file:
        lines = [line.strip() for line in file if line.strip()]
    return next((line for line in reversed(lines) if "Error" in line), lines[-1] if lines else "it said nothing")


# From here on: the process that bakes.


def direction_of(values):
    """The direction to the sun of a sky with these properties, in Blender's axes."""
    if values["sky_type"] in {"PREETHAM", "HOSEK_WILKIE"}:
        return np.array(values["sun_direction"])
    height, turn = values["sun_elevation"], values["sun_rotation"]
    return np.array([math.sin(turn) * math.cos(height), math.cos(turn) * math.cos(height), math.sin(height)])


def _render(scene, path, width, height):
    """Linear pixels, (height, width, 3), with row 0 at the bottom."""
    import bpy

    scene.render.resolution_x, scene.render.resolution_y, scene.render.filepath = width, height, path
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Linear Rec.709"
    values = np.empty(width * height * 4, dtype=np.float32)
    image.pixels.foreach_get(values)
    bpy.data.images.remove(image)
    os.remove(path)
    return values.reshape(height, width, 4)[:, :, :3]


def _new_scene():
    """An empty scene of Cycles, with a camera."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.render.resolution_percentage = 4, False, 100
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(scene.camera)
    return scene


def _sky_world(values):
    """A world of a sky texture with these properties."""
    import bpy

    world = bpy.data.worlds.new("Sky")
    world.use_nodes = True
    tree = world.node_tree
    node = tree.nodes.new("ShaderNodeTexSky")
    node.sky_type = values["sky_type"]
    for key, value in values.items():
        setattr(node, key, value)
    tree.links.new(node.outputs[0], tree.nodes["Background"].inputs["Color"])
    return world


def _loaded_world(path, name):
    """A world out of a file."""
    import bpy

    with bpy.data.libraries.load(path) as (_, into):
        into.worlds = [name]
    world = into.worlds[0]
    # who sees it is not a matter of the picture
    for kind in ("camera", "diffuse", "glossy", "transmission"):
        setattr(world.cycles_visibility, kind, True)
    return world


def _trees(world):
    """The node trees of a world, and of the groups in them."""
    waiting, found = [world.node_tree], []
    while waiting:
        tree = waiting.pop()
        if tree not in found:
            found.append(tree)
            waiting += [node.node_tree for node in tree.nodes if node.type == "GROUP" and node.node_tree]
    return found


def _width(nodes):
    """How wide the picture is: as the widest one that it shows, within bounds."""
    images = [node.image for node in nodes if node.type in {"TEX_ENVIRONMENT", "TEX_IMAGE"} and node.image]
    return min(WIDEST, max([WIDTH, *(image.size[0] for image in images)]))


def _skies_with_suns(nodes):
    """Sky textures whose suns are told by themselves."""
    skies = [node for node in nodes if node.type == "TEX_SKY" and node.sky_type not in {"PREETHAM", "HOSEK_WILKIE"} and node.sun_disc]
    # where coordinates are bent nobody knows where the sun is: the picture has it
    return [node for node in skies if not any(entry.is_linked for entry in node.inputs)]


def _sun(scene, path, node):
    """One sun, by a picture with its disk and one without: its direction, its diameter, and the radiance of a white surface, in one row."""
    import mathutils

    toward, data = direction_of(properties_of(node)), scene.camera.data
    scene.camera.rotation_euler = mathutils.Vector(toward).to_track_quat("-Z", "Y").to_euler()
    data.type, data.angle = "PERSP", min(1.25 * node.sun_size, math.radians(160))
    pictures = []
    for disc in (True, False):
        node.sun_disc = disc
        pictures.append(_render(scene, path, SUN_PIXELS, SUN_PIXELS))
    side = ((np.arange(SUN_PIXELS) + 0.5) / SUN_PIXELS * 2 - 1) * math.tan(data.angle / 2)
    # the solid angle of each pixel by the cosine at the surface
    share = (2 * math.tan(data.angle / 2) / SUN_PIXELS) ** 2 / (1 + side[:, None] ** 2 + side[None, :] ** 2) ** 2
    light = ((pictures[0] - pictures[1]) * share[:, :, None]).sum(axis=(0, 1)) / math.pi
    return [*toward, node.sun_size, *np.maximum(light, 0)]


LIGHTING = {"Is Diffuse Ray": 1.0, "Is Reflection Ray": 1.0, "Ray Depth": 1.0, "Diffuse Depth": 1.0}
"""What Light Path nodes say to the rays by which a world lights matt surfaces; the rest is 0."""


def _as_it_lights(trees):
    """Lets Light Path nodes say what they say to rays that light. Returns false if there are none."""
    found = False
    for tree in trees:
        for link in [link for link in tree.links if link.from_node.type == "LIGHT_PATH"]:
            value = tree.nodes.new("ShaderNodeValue")
            value.outputs[0].default_value = LIGHTING.get(link.from_socket.name, 0.0)
            tree.links.new(value.outputs[0], link.to_socket)
            found = True
    return found


def _all_around(scene, path, width):
    """A picture of all directions, with +X in the middle as an environment texture has it."""
    data = scene.camera.data
    data.type = "PANO"
    # 4.x keeps the kind of panorama with Cycles' own settings
    (data if hasattr(data, "panorama_type") else data.cycles).panorama_type = "EQUIRECTANGULAR"
    scene.camera.rotation_euler = (math.pi / 2, 0, -math.pi / 2)
    return _render(scene, path, width, width // 2)


def main(request, result):
    """Bakes what is asked for."""
    scene = _new_scene()
    world = scene.world = _sky_world(request["sky"]) if "sky" in request else _loaded_world(request["file"], request["world"])
    at = request.get("time", 1.0)
    scene.frame_set(math.floor(at), subframe=at - math.floor(at))
    trees = _trees(world)
    nodes = [node for tree in trees for node in tree.nodes if not node.mute]
    path, width = os.path.join(os.path.dirname(result), "world.exr"), _width(nodes)
    skies, found = _skies_with_suns(nodes), {}
    for node in skies:
        node.sun_disc = False
    found["light"] = _all_around(scene, path, width)
    if _as_it_lights(trees):
        found["seen"] = found["light"]
        found["light"] = _all_around(scene, path, width)
    found["suns"] = np.array([_sun(scene, path, node) for node in skies], dtype=np.float64).reshape(-1, 7)
    np.savez(result, **found)


if __name__ == "__main__":
    main(json.loads(sys.argv[-2]), sys.argv[-1])

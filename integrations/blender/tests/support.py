# SPDX-License-Identifier: GPL-3.0-or-later
"""Loads the extension into bpy, and makes scenes for tests."""

import importlib.util
import os
import sys
import tempfile
import tomllib
import unittest

import bpy
import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
NAME = "afterimage_extension"


def extension():
    """The extension, registered once."""
    if NAME not in sys.modules:
        spec = importlib.util.spec_from_file_location(NAME, os.path.join(ROOT, "__init__.py"), submodule_search_locations=[ROOT])
        module = importlib.util.module_from_spec(spec)
        sys.modules[NAME] = module
        spec.loader.exec_module(module)
        module.register()
    return sys.modules[NAME]


def has_renderer():
    """Returns true if the Python module is there."""
    return importlib.util.find_spec("afterimage") is not None


def empty(width=64, height=48, frames=(1, 1), engine="AFTERIMAGE"):
    """An empty scene with a black world, whose frames are `frames`."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    module = extension()
    # a new file forgets what scripts have registered on start, but not classes
    if not hasattr(bpy.types.Scene, "afterimage"):
        module.register()
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.frame_start, scene.frame_end = frames
    scene.frame_set(frames[0])
    scene.render.engine = engine
    # counts as they are set, or by default: tests say what they need
    scene.afterimage.error = 0
    scene.view_settings.view_transform = "Standard"
    return scene


def add(scene, name, data, place=(0, 0, 0), turn=(0, 0, 0)):
    """Adds an object."""
    item = bpy.data.objects.new(name, data)
    item.location, item.rotation_euler = place, turn
    scene.collection.objects.link(item)
    return item


def add_camera(scene, place=(0, -5, 0), turn=(np.pi / 2, 0, 0), **values):
    """Adds the scene's camera; without `turn` it looks along +Y."""
    data = bpy.data.cameras.new("Camera")
    for key, value in values.items():
        setattr(data, key, value)
    scene.camera = add(scene, "Camera", data, place, turn)
    return scene.camera


def grid(name="Grid", size=2.0, count=1):
    """A square in the plane of X and Y, of count x count quads."""
    side = np.linspace(-size / 2, size / 2, count + 1)
    x, y = np.meshgrid(side, side)
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    a = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).ravel()
    faces = np.stack([a, a + 1, a + count + 2, a + count + 1], axis=1)
    return mesh_of(name, points, faces)


def mesh_of(name, points, faces):
    """A mesh of arrays of quads or triangles, without loops over vertices."""
    mesh = bpy.data.meshes.new(name)
    corners = faces.shape[1]
    mesh.vertices.add(len(points))
    mesh.vertices.foreach_set("co", np.asarray(points, dtype=np.float32).ravel())
    mesh.loops.add(faces.size)
    mesh.loops.foreach_set("vertex_index", faces.ravel().astype(np.int32))
    mesh.polygons.add(len(faces))
    mesh.polygons.foreach_set("loop_start", np.arange(0, faces.size, corners, dtype=np.int32))
    mesh.update(calc_edges=True)
    return mesh


class Tree:
    """Nodes of a material or of a group, made by their types."""

    def __init__(self, owner):
        tree = getattr(owner, "node_tree", owner)
        self.nodes, self.links = tree.nodes, tree.links

    def add(self, kind, inputs=(), **values):
        """A node of this type, without the prefix of all shader nodes. Inputs, by name or number: values, or outputs to link to."""
        node = self.nodes.new(f"ShaderNode{kind}")
        for key, value in values.items():
            setattr(node, key, value)
        for key, value in dict(inputs).items():
            if isinstance(value, bpy.types.NodeSocket):
                self.links.new(value, node.inputs[key])
            else:
                node.inputs[key].default_value = value
        return node


def render(scene, path):
    """Renders the current frame into an EXR, and returns its pixels, the top row first."""
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    return read_pixels(path)


def read_pixels(path):
    """Linear pixels of a file, the top row first."""
    image = bpy.data.images.load(path, check_existing=False)
    image.colorspace_settings.name = "Linear Rec.709"
    values = np.empty(image.size[0] * image.size[1] * 4, dtype=np.float32)
    image.pixels.foreach_get(values)
    pixels = values.reshape(image.size[1], image.size[0], 4)[::-1].copy()
    bpy.data.images.remove(image)
    return pixels


class ExportCase(unittest.TestCase):
    """Tests that export an empty scene, to which they add something."""

    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.folder = os.path.join(self.scratch.name, "shot")
        self.scene = empty()

    def tearDown(self):
        self.scratch.cleanup()

    def export(self):
        """Exports the scene. Returns the shot."""
        self.assertEqual(bpy.ops.afterimage.export_shot(directory=self.folder), {"FINISHED"})
        return self.shot()

    def shot(self):
        with open(os.path.join(self.folder, "shot.toml"), "rb") as file:
            return tomllib.load(file)

    def warnings(self):
        return list(extension().session.exported.warnings)

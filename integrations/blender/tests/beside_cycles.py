# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests that render a scene by the engine and by Cycles. They are skipped without the renderer's Python module."""

import os
import tempfile
import unittest

import bpy
import numpy as np
import support


@unittest.skipUnless(support.has_renderer(), "the Python module `afterimage` is not installed")
class BesideCycles(unittest.TestCase):
    """An empty scene, a folder, and comparisons of both engines."""

    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.scene = support.empty()

    def tearDown(self):
        self.scratch.cleanup()

    def path(self, name):
        return os.path.join(self.scratch.name, name)

    def both(self, samples=64):
        """The picture of Afterimage, and that of Cycles. `self.exported` is what was exported for it."""
        self.scene.render.engine = "AFTERIMAGE"
        session = support.extension().session
        export = session.export

        def noted(*values):
            self.exported = export(*values)
            return self.exported

        session.export = noted
        try:
            ours = support.render(self.scene, self.path("ours.exr"))
        finally:
            session.export = export
        self.scene.render.engine = "CYCLES"
        self.scene.cycles.samples = samples
        self.scene.cycles.use_denoising = False
        self.scene.cycles.pixel_filter_type = "BOX"
        self.scene.cycles.filter_width = 1.0
        return ours, support.render(self.scene, self.path("cycles.exr"))

    def bright(self, name, size, place, radiance=1.0):
        """A square that emits."""
        material = bpy.data.materials.new(name)
        material.use_nodes = True
        shader = material.node_tree.nodes["Principled BSDF"]
        shader.inputs["Emission Color"].default_value = (1, 1, 1, 1)
        shader.inputs["Emission Strength"].default_value = radiance
        shader.inputs["Base Color"].default_value = (0, 0, 0, 1)
        shader.inputs["Specular IOR Level"].default_value = 0
        mesh = support.grid(name, size)
        mesh.materials.append(material)
        # askew: an edge along rows of samples would be off by a part of their distance all the way
        return support.add(self.scene, name, mesh, place, (np.pi / 2, 0.4, 0))

    def assert_same_brightness(self, data, place=(0.5, -1, 2), turn=(0.4, 0.2, 0.1), tolerance=0.03):
        """A light on a matt wall, with a camera that looks down on it."""
        material = bpy.data.materials.new("Matt")
        material.use_nodes = True
        shader = material.node_tree.nodes["Principled BSDF"]
        shader.inputs["Specular IOR Level"].default_value = 0
        shader.inputs["Roughness"].default_value = 1
        mesh = support.grid("Wall", 10)
        mesh.materials.append(material)
        support.add(self.scene, "Wall", mesh)
        support.add(self.scene, "Light", data, place, turn)
        support.add_camera(self.scene, (0, 0, 6), (0, 0, 0))
        self.scene.afterimage.shadow_rays = "16"
        self.scene.afterimage.paths = 0
        ours, cycles = self.both(128)
        self.assertGreater(cycles[:, :, :3].mean(), 0.01)
        np.testing.assert_allclose(ours[:, :, :3].mean() / cycles[:, :, :3].mean(), 1, atol=tolerance)

    def light(self, kind, **values):
        data = bpy.data.lights.new("Light", kind)
        for key, value in values.items():
            setattr(data, key, value)
        return data

    def look_down(self, item_material, height=6):
        """A square of a material, seen from above."""
        mesh = support.grid("Square", 4)
        mesh.materials.append(item_material)
        support.add_camera(self.scene, (0, 0, height), (0, 0, 0))
        return support.add(self.scene, "Square", mesh)

    def even_world(self, light):
        self.scene.world = bpy.data.worlds.new("World")
        self.scene.world.use_nodes = True
        self.scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (*light, 1)

    def assert_same_colors(self, tolerance, samples=128):
        ours, cycles = self.both(samples)
        self.assertGreater(cycles[:, :, :3].mean(), 0.01)
        means = [picture[:, :, :3].mean(axis=(0, 1)) for picture in (ours, cycles)]
        np.testing.assert_allclose(means[0], means[1], rtol=tolerance)
        return ours, cycles

    def ball(self, material, radius=0.8, place=(0, 0, 0)):
        """A smooth ball of a material."""
        bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=radius, location=place)
        ball = bpy.context.object
        ball.data.shade_smooth()
        ball.data.materials.append(material)
        return ball

# SPDX-License-Identifier: GPL-3.0-or-later
"""Pointiness of meshes, beside Cycles. Needs bpy and the renderer's Python module."""

import os
import unittest

import beside_cycles
import bpy
import numpy as np
import support
from support import Tree
from test_surfaces import principled


class PointinessBesideCycles(beside_cycles.BesideCycles):
    def setUp(self):
        super().setUp()
        self.even_world((1, 1, 1))
        self.scene.afterimage.samples = 16
        support.add_camera(self.scene, (0, -4, 2.2), (1.07, 0, 0))
        self.material, self.node = principled("Worn", Roughness=1.0, Specular_IOR_Level=0.0)
        self.tree = Tree(self.material)

    def ramp(self, low=0.45, high=0.6):
        """A colour from blue where it is hollow by orange to green where it is convex."""
        node = self.tree.add("ValToRGB", {0: self.tree.add("NewGeometry").outputs["Pointiness"]})
        stops = node.color_ramp.elements
        stops[0].position, stops[0].color = low, (0.05, 0.1, 0.8, 1)
        stops[1].position, stops[1].color = high, (0.1, 0.8, 0.1, 1)
        stops.new((low + high) / 2).color = (0.9, 0.4, 0.05, 1)
        return node.outputs["Color"]

    def shown(self, item, *modifiers):
        """An object that has the material, with modifiers by their types and settings."""
        item.data.materials.clear()
        item.data.materials.append(self.material)
        for kind, settings in modifiers:
            modifier = item.modifiers.new(kind, kind)
            for key, value in settings.items():
                setattr(modifier, key, value)
        return item

    def cube(self, *modifiers):
        bpy.ops.mesh.primitive_cube_add(size=1.7, rotation=(0.2, 0.1, 0.6))
        return self.shown(bpy.context.object, *modifiers)

    def monkey(self, levels):
        bpy.ops.mesh.primitive_monkey_add(size=2.4, rotation=(-0.3, 0.0, 0.4))
        bpy.context.object.data.shade_smooth()
        # finer, for light on coarse smooth meshes is another matter
        return self.shown(bpy.context.object, ("SUBSURF", {"render_levels": levels}))

    def assert_same(self, name):
        ours, cycles = self.both()
        folder = os.environ.get("AFTERIMAGE_LOOK")
        if folder:
            whole = np.clip(np.concatenate([ours[:, :, :3], cycles[:, :, :3]], axis=1), 0, 1)
            pixels = (support.extension().export.images.to_srgb(whole) * 255 + 0.5).astype(np.uint8)
            support.extension().export.files.write_png(os.path.join(folder, f"{name}.png"), np.repeat(np.repeat(pixels, 6, axis=0), 6, axis=1))
        # pixels that are mostly the world are white
        on_it = cycles[:, :, :3].min(axis=2) < 0.6
        colors = [picture[on_it][:, :3] for picture in (ours, cycles)]
        self.assertGreater(float(np.std(colors[1], axis=0).max()), 0.04, "it shows a pattern")
        np.testing.assert_allclose(colors[0].mean(axis=0), colors[1].mean(axis=0), rtol=0.015)
        self.assertLess(float(np.abs(ours - cycles)[:, :, :3].mean()), 0.005)
        self.assertFalse(self.exported.warnings)

    def test_bevelled_cube(self):
        self.tree.links.new(self.ramp(), self.node.inputs["Base Color"])
        self.cube(("BEVEL", {"width": 0.25, "segments": 4}))
        self.assert_same("bevelled cube")

    def test_subdivided_cube(self):
        self.tree.links.new(self.ramp(0.5, 0.53), self.node.inputs["Base Color"])
        self.cube(("SUBSURF", {"render_levels": 3}))
        self.assert_same("subdivided cube")

    def test_far_from_flat(self):
        # between vertices, colours are of what is between their numbers, and no mean of their colours
        self.tree.links.new(self.ramp(0.63, 0.69), self.node.inputs["Base Color"])
        bpy.ops.mesh.primitive_cone_add(vertices=16, radius1=1.2, depth=3, rotation=(0.2, 0.1, 0.6))
        self.shown(bpy.context.object)
        self.assert_same("cone")

    def test_faces_that_share_places(self):
        self.tree.links.new(self.ramp(0.5, 0.56), self.node.inputs["Base Color"])
        self.cube(("BEVEL", {"width": 0.25, "segments": 4}), ("EDGE_SPLIT", {"split_angle": 0.0}))
        self.assert_same("split cube")

    def test_monkey(self):
        self.tree.links.new(self.ramp(), self.node.inputs["Base Color"])
        self.monkey(1)
        self.assert_same("monkey")

    def test_steep_ramp(self):
        self.tree.links.new(self.ramp(0.499, 0.506), self.node.inputs["Base Color"])
        self.monkey(2)
        self.assert_same("steep ramp")

    def test_mixed_shaders(self):
        factor = self.tree.add("MapRange", {0: self.tree.add("NewGeometry").outputs["Pointiness"], 1: 0.48, 2: 0.6}).outputs[0]
        light = self.tree.add("Emission", {"Color": (0.9, 0.4, 0.1, 1)}).outputs[0]
        mixed = self.tree.add("MixShader", {0: factor, 1: self.node.outputs[0], 2: light}).outputs[0]
        self.tree.links.new(mixed, self.tree.nodes["Material Output"].inputs["Surface"])
        self.node.inputs["Base Color"].default_value = (0.05, 0.2, 0.5, 1)
        self.monkey(1)
        self.assert_same("mixed shaders")


if __name__ == "__main__":
    unittest.main()

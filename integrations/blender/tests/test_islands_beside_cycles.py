# SPDX-License-Identifier: GPL-3.0-or-later
"""Random numbers of the islands of meshes, beside Cycles. Needs bpy and the renderer's Python module."""

import os
import unittest

import beside_cycles
import bpy
import numpy as np
import support
from support import Tree
from test_surfaces import principled


def squares(count):
    """Squares of four quads each, which nothing connects, in rows and columns of `count`. Every second one has its vertices mixed."""
    points, faces = [], []
    chance = np.random.default_rng(1)
    for index in range(count * count):
        mesh = support.grid(size=0.8, count=2)
        own = np.array([vertex.co for vertex in mesh.vertices]) + (index % count - (count - 1) / 2, index // count - (count - 1) / 2, 0)
        order = chance.permutation(len(own)) if index % 2 else np.arange(len(own))
        back = np.argsort(order)
        faces += [[back[vertex] + sum(map(len, points)) for vertex in polygon.vertices] for polygon in mesh.polygons]
        points.append(own[order])
        bpy.data.meshes.remove(mesh)
    return support.mesh_of("Squares", np.concatenate(points), np.array(faces))


class IslandsBesideCycles(beside_cycles.BesideCycles):
    def setUp(self):
        super().setUp()
        self.scene.world = bpy.data.worlds.new("World")
        self.scene.world.use_nodes = True
        self.scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
        self.scene.afterimage.samples = 4
        support.add_camera(self.scene, (0, 0, 6), (0, 0, 0))
        self.mesh = squares(5)
        self.item = support.add(self.scene, "Squares", self.mesh, turn=(0, 0, 0.2))
        self.material, self.node = principled("Islands", Roughness=1.0, Specular_IOR_Level=0.0)
        self.mesh.materials.append(self.material)

    def assert_same(self, name):
        ours, cycles = self.both()
        folder = os.environ.get("AFTERIMAGE_LOOK")
        if folder:
            whole = np.clip(np.concatenate([ours[:, :, :3], cycles[:, :, :3]], axis=1), 0, 1)
            pixels = (support.extension().export.images.to_srgb(whole) * 255 + 0.5).astype(np.uint8)
            support.extension().export.files.write_png(os.path.join(folder, f"{name}.png"), np.repeat(np.repeat(pixels, 4, axis=0), 4, axis=1))
        self.assertGreater(np.std(cycles[:, :, :3]), 0.1, "it shows a pattern")
        # edges of many squares; with other numbers it is 0.17
        self.assertLess(float(np.abs(ours - cycles)[:, :, :3].mean()), 0.015)
        self.assertFalse([said for said in self.exported.warnings if "constant" in said])

    def ramp(self, tree):
        node = tree.add("ValToRGB", {0: tree.add("NewGeometry").outputs["Random Per Island"]})
        stops = node.color_ramp.elements
        stops[0].color, stops[1].color, stops.new(0.5).color = (0.9, 0.1, 0.05, 1), (0.05, 0.2, 0.8, 1), (0.1, 0.7, 0.1, 1)
        return node.outputs["Color"]

    def test_colours_by_islands(self):
        tree = Tree(self.material)
        tree.links.new(self.ramp(tree), self.node.inputs["Base Color"])
        self.assert_same("islands")
        # those of the mesh with its modifiers count
        self.item.modifiers.new("Finer", "SUBSURF").subdivision_type = "SIMPLE"
        self.assert_same("finer islands")

    def test_islands_among_patterns(self):
        tree = Tree(self.material)
        noise = tree.add("TexNoise", {"Vector": tree.add("TexCoord").outputs["Object"], "Scale": 2.0}).outputs
        mix = tree.add("Mix", {0: noise[0], 6: self.ramp(tree), 7: noise["Color"]}, data_type="RGBA").outputs[2]
        tree.links.new(mix, self.node.inputs["Base Color"])
        self.assert_same("islands among patterns")


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: GPL-3.0-or-later
"""Fuzz, rough matt surfaces, metals' edges and what passes through surfaces, beside Cycles. Needs bpy and the renderer's Python module."""

import beside_cycles
import bpy
import numpy as np
import support
from support import Tree
from test_surfaces import principled


class LobesBesideCycles(beside_cycles.BesideCycles):
    def setUp(self):
        super().setUp()
        support.add_camera(self.scene, (0, 0, 4.5), (0, 0, 0))
        self.scene.afterimage.samples, self.scene.afterimage.paths, self.scene.afterimage.reflections = 4, 64, 32

    def sun(self, *turn):
        return support.add(self.scene, "Sun", self.light("SUN", energy=3, angle=0.1), (0, 0, 5), turn)

    def shader(self, kind, inputs, **values):
        """A material of one shader."""
        material, _ = principled(kind)
        tree = Tree(material)
        tree.links.new(tree.add(kind, inputs, **values).outputs[0], tree.nodes["Material Output"].inputs["Surface"])
        return material

    def assert_same_ball(self, material, tolerance):
        """A ball of a material is as bright, on the whole, in its middle and at its rim."""
        self.scene.render.film_transparent = True
        ball = self.ball(material, 1)
        try:
            ours, cycles = self.both(256)
        finally:
            bpy.data.objects.remove(ball)
        rows, columns = np.mgrid[0:48, 0:64]
        away = np.hypot(rows - 23.5, columns - 31.5) / 20.3
        for part in (away < 1.1, away < 0.4, (away > 0.75) & (away < 0.93)):
            np.testing.assert_allclose(*(picture[part][:, :3].mean(axis=0) for picture in (ours, cycles)), rtol=tolerance, atol=0.004)
        self.assertEqual(self.exported.warnings, [])
        return ours, cycles

    def test_sheen(self):
        self.even_world((0.4, 0.4, 0.4))
        self.sun(0.6, 0.5, 0)
        for roughness in (0.3, 0.5, 0.8):
            with self.subTest("alone", roughness=roughness):
                self.assert_same_ball(self.shader("BsdfSheen", {"Color": (0.9, 0.6, 0.3, 1), "Roughness": roughness}), 0.06)
        with self.subTest("on plastic"):
            values = {"Sheen_Weight": 0.7, "Sheen_Roughness": 0.4, "Roughness": 0.5, "Base_Color": (0.3, 0.05, 0.02, 1)}
            self.assert_same_ball(principled("Cloth", **values)[0], 0.05)

    def test_rough_matt_surfaces(self):
        for turn, light in (((0.6, 0.5, 0), 0.0), ((0.05, 0, 0), 0.0), ((0.9, 0.3, 0), 0.5)):
            self.even_world((light, light, light))
            sun = self.sun(*turn)
            # light that is scattered several times has the colour once more in Cycles than in the model: of white light it is the same
            for roughness, color, tolerance in ((0.3, (0.7, 0.4, 0.1, 1), 0.03), (1.0, (0.97, 0.96, 0.95, 1), 0.02), (1.0, (0.7, 0.4, 0.1, 1), 0.08)):
                with self.subTest(turn=turn, roughness=roughness, color=color):
                    self.assert_same_ball(self.shader("BsdfDiffuse", {"Color": color, "Roughness": roughness}), tolerance)
            bpy.data.objects.remove(sun)

    def test_edges_of_metal(self):
        self.even_world((0.5, 0.6, 0.7))
        self.sun(0.6, 0.5, 0)
        dark = (0.25, 0.12, 0.05, 1)
        with self.subTest("Glossy"):
            self.assert_same_ball(self.shader("BsdfGlossy", {"Color": dark, "Roughness": 0.4}, distribution="MULTI_GGX"), 0.04)
        for tint in (1.0, 0.8):
            with self.subTest("Principled", tint=tint):
                values = {"Metallic": 1.0, "Roughness": 0.4, "Base_Color": dark, "Specular_Tint": (tint, tint, tint, 1)}
                self.assert_same_ball(principled("Metal", **values)[0], 0.05)

    def test_brushed_metal(self):
        self.even_world((0.3, 0.35, 0.4))
        sun = self.sun(0.6, 0.5, 0)
        sun.data.angle = 0.3
        # light that is reflected several times is that of a round lobe
        for amount, rotation, axis, tolerance in ((0.6, 0.0, None, 0.04), (0.9, 0.25, None, 0.09), (0.8, 0.1, "X", 0.06)):
            with self.subTest(amount=amount, rotation=rotation, axis=axis):
                values = {"Metallic": 1.0, "Roughness": 0.4, "Base_Color": (0.8, 0.5, 0.3, 1), "Anisotropic": amount, "Anisotropic_Rotation": rotation}
                material, node = principled("Brushed", **values)
                if axis:
                    tree = Tree(material)
                    tree.links.new(tree.add("Tangent", direction_type="RADIAL", axis=axis).outputs[0], node.inputs["Tangent"])
                ours, cycles = self.assert_same_ball(material, tolerance)
                # the highlight lies where Cycles has it
                np.testing.assert_allclose(ours[:, :, 0], cycles[:, :, 0], atol=0.25 * float(cycles[:, :, 0].max()))

    def test_what_is_translucent(self):
        leaf = self.shader("BsdfTranslucent", {"Color": (0.2, 0.6, 0.1, 1)})
        both, _ = principled("Both")
        tree = Tree(both)
        parts = (tree.add("BsdfDiffuse", {"Color": (0.3, 0.4, 0.1, 1)}), tree.add("BsdfTranslucent", {"Color": (0.3, 0.4, 0.1, 1)}))
        mix = tree.add("MixShader", {0: 0.4, 1: parts[0].outputs[0], 2: parts[1].outputs[0]})
        tree.links.new(mix.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
        for material in (leaf, both):
            for name, turn in (("before", (0.4, 0, 0)), ("behind", (np.pi - 0.4, 0, 0))):
                with self.subTest(material=material.name, sun=name):
                    self.even_world((0.2, 0.2, 0.2))
                    sun, square = self.sun(*turn), self.look_down(material)
                    try:
                        self.assert_same_colors(0.03)
                    finally:
                        bpy.data.objects.remove(sun)
                        bpy.data.objects.remove(square)
                    self.assertEqual(self.exported.warnings, [])

    def test_glass_absorbs(self):
        self.even_world((1, 1, 1))
        self.scene.afterimage.depth = 12
        for density in (0.5, 3.0):
            with self.subTest(density=density):
                material = self.shader("BsdfGlass", {"Color": (1, 1, 1, 1), "Roughness": 0.0, "IOR": 1.3})
                tree = Tree(material)
                volume = tree.add("VolumeAbsorption", {"Color": (0.9, 0.5, 0.1, 1), "Density": density})
                tree.links.new(volume.outputs[0], tree.nodes["Material Output"].inputs["Volume"])
                # a ball of facets in Cycles, and a smooth one here, but for their rims
                self.assert_same_ball(material, 0.03)

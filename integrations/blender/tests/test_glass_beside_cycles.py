# SPDX-License-Identifier: GPL-3.0-or-later
"""Glass of several colours, and glass beside what is matt in one material, beside Cycles. Needs bpy and the renderer's Python module."""

import beside_cycles
import bpy
import numpy as np
import support
from support import Tree
from test_glass import halves, image_of
from test_surfaces import principled

HALVES = np.s_[6:-6, 5:28], np.s_[6:-6, 36:59]
"""Parts of the picture that show the left and the right half of the pane."""

BEHIND = (0.3, 1.2, 2.0)
"""Radiance behind the pane, by which what goes through it is told from what it scatters."""


class GlassBesideCycles(beside_cycles.BesideCycles):
    """A pane of two sides, whose pictures have two halves, before a square that emits, in a white world."""

    def setUp(self):
        super().setUp()
        self.even_world((1, 1, 1))
        self.scene.afterimage.samples, self.scene.afterimage.paths, self.scene.afterimage.reflections = 4, 64, 32
        lamp, _ = principled("Behind", Base_Color=(0, 0, 0, 1), Specular_IOR_Level=0.0, Emission_Color=(*BEHIND, 1), Emission_Strength=1.0)
        mesh = support.grid("Behind", 40)
        mesh.materials.append(lamp)
        support.add(self.scene, "Behind", mesh, (0, 0, -1.5))

    def pane(self, shader):
        """Looks down on a pane of the shader that a function makes for a tree."""
        material, _ = principled("Pane")
        tree = Tree(material)
        tree.links.new(shader(tree), tree.nodes["Material Output"].inputs["Surface"])
        square = self.look_down(material, 3)
        square.data.uv_layers.new().data.foreach_set("uv", [0, 0, 1, 0, 1, 1, 0, 1])
        square.modifiers.new("Thick", "SOLIDIFY").thickness = 0.05

    @staticmethod
    def picture(tree, left, right):
        return tree.add("TexImage", image=image_of("Halves", halves(left, right, 64))).outputs["Color"]

    def assert_same_halves(self, tolerance, least=0.2):
        """Both halves have the colours that Cycles shows, which differ at least by so much. Returns these."""
        ours, cycles = self.both(256)
        means = [[picture[half][:, :, :3].mean(axis=(0, 1)) for half in HALVES] for picture in (ours, cycles)]
        self.assertGreater(np.abs(means[1][0] - means[1][1]).max(), least, "the halves differ")
        np.testing.assert_allclose(means[0], means[1], atol=tolerance)
        self.assertFalse([said for said in self.exported.warnings if "constant" in said or "left out" in said])
        return means[1]

    def test_stained_glass(self):
        self.pane(lambda tree: tree.add("BsdfGlass", {"Color": self.picture(tree, (0.9, 0.3, 0.2), (0.2, 0.5, 0.9)), "Roughness": 0.0, "IOR": 1.2}).outputs[0])
        left, right = self.assert_same_halves(0.03)
        # once by each side, and a little is reflected
        np.testing.assert_allclose(left / BEHIND, [0.81, 0.09, 0.04], atol=0.06)
        np.testing.assert_allclose(right / BEHIND, [0.04, 0.25, 0.81], atol=0.06)

    def test_principled_glass_of_two_colours(self):
        inputs = {"Transmission Weight": 1.0, "Roughness": 0.0, "IOR": 1.2}
        self.pane(lambda tree: tree.add("BsdfPrincipled", {"Base Color": self.picture(tree, (0.8, 0.2, 0.1), (0.1, 0.4, 0.8)), **inputs}).outputs[0])
        self.assert_same_halves(0.03)

    def test_transmission_by_a_picture(self):
        # of a colour that has a channel of 1, which the shot's table says, and of one that has none, which a graph says
        for color in ((1.0, 0.3, 0.5), (0.6, 0.3, 0.2)):
            with self.subTest(color=color):
                inputs = {"Base Color": (*color, 1), "Roughness": 0.0, "IOR": 1.2}
                self.pane(lambda tree: tree.add("BsdfPrincipled", {"Transmission Weight": self.picture(tree, 0.0, 1.0), **inputs}).outputs[0])
                self.assert_same_halves(0.04)
                bpy.data.objects.remove(bpy.data.objects["Square"])

    def test_a_picture_that_mixes_glass_and_plastic(self):
        def shader(tree):
            glass = tree.add("BsdfGlass", {"Color": (0.9, 0.9, 0.6, 1), "Roughness": 0.0, "IOR": 1.3}).outputs[0]
            plastic = tree.add("BsdfPrincipled", {"Base Color": (0.5, 0.1, 0.05, 1), "Roughness": 0.0, "IOR": 1.3}).outputs[0]
            return tree.add("MixShader", {0: self.picture(tree, 1.0, 0.0), 1: glass, 2: plastic}).outputs[0]

        self.pane(shader)
        self.assert_same_halves(0.04)

    def test_panes_of_two_colours_beside_lead(self):
        def shader(tree):
            glass = tree.add("BsdfGlass", {"Color": self.picture(tree, (0.9, 0.3, 0.2), (0.2, 0.5, 0.9)), "Roughness": 0.0, "IOR": 1.2}).outputs[0]
            lead = tree.add("BsdfDiffuse", {"Color": (0.7, 0.65, 0.6, 1)}).outputs[0]
            return tree.add("MixShader", {0: self.picture(tree, 0.0, 1.0), 1: glass, 2: lead}).outputs[0]

        self.pane(shader)
        # what is matt reflects as its glass does
        self.assert_same_halves(0.05)

    def test_what_glass_reflects_totally(self):
        color = {"Color": (0.9, 0.3, 0.2, 1), "Roughness": 0.0, "IOR": 1.5}
        shaders = {
            "glass": lambda tree: tree.add("BsdfGlass", color).outputs[0],
            "principled": lambda tree: tree.add("BsdfPrincipled", {"Base Color": color["Color"], "Transmission Weight": 1.0, "Roughness": 0.0}).outputs[0],
            "in part": lambda tree: tree.add(
                "MixShader", {0: 0.5, 1: tree.add("BsdfGlass", color).outputs[0], 2: tree.add("BsdfDiffuse", {"Color": (0.4, 0.4, 0.4, 1)}).outputs[0]}
            ).outputs[0],
        }
        for name, shader in shaders.items():
            with self.subTest(name):
                material, _ = principled("Pane")
                tree = Tree(material)
                tree.links.new(shader(tree), tree.nodes["Material Output"].inputs["Surface"])
                square = self.look_down(material, 3)
                # it is seen from behind, as from within glass, beyond the critical angle
                square.data.flip_normals()
                square.rotation_euler = (np.radians(60), 0, 0)
                ours, cycles = self.both(256)
                height, width = cycles.shape[:2]
                middle = np.s_[height // 2 - 4 : height // 2 + 4, width // 2 - 8 : width // 2 + 8, :3]
                np.testing.assert_allclose(ours[middle].mean(axis=(0, 1)), cycles[middle].mean(axis=(0, 1)), atol=0.02)
                bpy.data.objects.remove(square)

# SPDX-License-Identifier: GPL-3.0-or-later
"""Volumes beside Cycles: fog, smoke and ink under lamps, suns and skies. Needs bpy and the renderer's Python module."""

import os

import beside_cycles
import bpy
import numpy as np
import support
from support import Tree
from test_surfaces import principled


SEEDS = os.path.join(os.path.dirname(__file__), "../../../fuzz/seeds/vdb")
"""Volumes that OpenVDB has written."""


class VolumesBesideCycles(beside_cycles.BesideCycles):
    def setUp(self):
        super().setUp()
        support.add_camera(self.scene, (0, 0, 6), (0, 0, 0))
        own = self.scene.afterimage
        own.samples, own.paths, own.bounces, own.volume_samples, own.volume_bounces, own.shadow_rays = 4, 16, 3, 4, 8, "4"
        self.scene.cycles.volume_bounces, self.scene.cycles.max_bounces, self.scene.cycles.diffuse_bounces = 8, 12, 3

    def filled(self, *nodes):
        """A material with the volumes that these shaders give together, and no surface."""
        material, shader = principled("Smoke")
        tree = Tree(material)
        made = [tree.add(kind, inputs).outputs[0] for kind, inputs in nodes]
        while len(made) > 1:
            made.append(tree.add("AddShader", {0: made.pop(0), 1: made.pop(0)}).outputs[0])
        tree.links.new(made[0], tree.nodes["Material Output"].inputs["Volume"])
        material.node_tree.nodes.remove(shader)
        return material

    def cube(self, material, size=2.0, place=(0, 0, 0), turn=(0.3, 0.5, 0.1)):
        bpy.ops.mesh.primitive_cube_add(size=size, location=place, rotation=turn)
        bpy.context.object.data.materials.append(material)
        return bpy.context.object

    def floor(self):
        """A matt floor below all."""
        material, shader = principled("Floor", Base_Color=(0.6, 0.5, 0.4, 1), Roughness=1.0)
        shader.inputs["Specular IOR Level"].default_value = 0
        mesh = support.grid("Floor", 12)
        mesh.materials.append(material)
        return support.add(self.scene, "Floor", mesh, (0, 0, -1.6))

    def assert_same(self, tolerance=0.03, samples=256):
        """Both pictures are as bright on the whole, and in nine parts of it."""
        ours, cycles = self.both(samples)
        self.assertGreater(cycles[:, :, :3].mean(), 0.005)
        np.testing.assert_allclose(*(picture[:, :, :3].mean(axis=(0, 1)) for picture in (ours, cycles)), rtol=tolerance)
        for rows in np.split(np.arange(48), 3):
            for columns in np.array_split(np.arange(64), 3):
                parts = [picture[np.ix_(rows, columns)][:, :, :3].mean() for picture in (ours, cycles)]
                np.testing.assert_allclose(*parts, rtol=2 * tolerance, atol=0.002)
        self.assertEqual(self.exported.warnings, [])

    def test_ink(self):
        self.even_world((1, 1, 1))
        self.cube(self.filled(("VolumeAbsorption", {"Color": (0.9, 0.5, 0.1, 1), "Density": 0.8})))
        self.floor()
        self.assert_same()

    def test_smoke_and_a_lamp(self):
        for anisotropy in (0.0, 0.5):
            with self.subTest(anisotropy=anisotropy):
                smoke = self.cube(self.filled(("VolumeScatter", {"Color": (0.8, 0.7, 0.6, 1), "Density": 0.7, "Anisotropy": anisotropy})))
                floor = self.floor()
                lamp = support.add(self.scene, "Lamp", self.light("POINT", energy=200, shadow_soft_size=0.1), (1.5, -1.0, 2.0))
                self.assert_same()
                for item in (smoke, floor, lamp):
                    bpy.data.objects.remove(item)

    def test_a_dense_cube(self):
        self.even_world((0.3, 0.4, 0.5))
        support.add(self.scene, "Sun", self.light("SUN", energy=3, angle=0.05), (0, 0, 5), (0.6, 0.5, 0))
        self.scene.afterimage.volume_bounces = self.scene.cycles.volume_bounces = 32
        self.scene.cycles.max_bounces = 40
        for anisotropy in (0.0, 0.5):
            with self.subTest(anisotropy=anisotropy):
                values = {"Color": (0.9, 0.8, 0.7, 1), "Density": 6.0, "Anisotropy": anisotropy}
                smoke = self.cube(self.filled(("VolumePrincipled", values)))
                self.assert_same(samples=512)
                bpy.data.objects.remove(smoke)

    def test_fire(self):
        self.floor()
        self.cube(self.filled(("Emission", {"Color": (1, 0.5, 0.1, 1), "Strength": 0.7}), ("VolumeAbsorption", {"Color": (0.5, 0.5, 0.5, 1), "Density": 1.0})))
        self.assert_same()

    def test_fog_everywhere(self):
        self.floor()
        self.scene.world = bpy.data.worlds.new("World")
        self.scene.world.use_nodes = True
        tree = self.scene.world.node_tree
        tree.nodes["Background"].inputs["Color"].default_value = (0.2, 0.3, 0.4, 1)
        fog = tree.nodes.new("ShaderNodeVolumeScatter")
        fog.inputs["Density"].default_value = 0.08
        tree.links.new(fog.outputs[0], tree.nodes["World Output"].inputs["Volume"])
        for light in (self.light("POINT", energy=300, shadow_soft_size=0.05), self.light("AREA", energy=200, size=1.0)):
            with self.subTest(light=light.type):
                lamp = support.add(self.scene, "Lamp", light, (1.0, 0.5, 1.5))
                self.assert_same()
                bpy.data.objects.remove(lamp)

    def test_a_camera_in_the_smoke(self):
        self.even_world((0.4, 0.4, 0.5))
        self.floor()
        support.add(self.scene, "Sun", self.light("SUN", energy=2, angle=0.02), (0, 0, 5), (0.5, 0.2, 0))
        self.cube(self.filled(("VolumeScatter", {"Color": (0.7, 0.8, 0.9, 1), "Density": 0.1})), 16)
        self.assert_same()

    def test_clouds(self):
        self.even_world((0.4, 0.45, 0.5))
        support.add(self.scene, "Sun", self.light("SUN", energy=3, angle=0.05), (0, 0, 5), (0.6, 0.5, 0))
        material = self.filled(("VolumeScatter", {"Color": (0.8, 0.8, 0.8, 1)}))
        tree = Tree(material)
        where = tree.add("TexCoord").outputs["Object"]
        noise = tree.add("TexNoise", {"Vector": where, "Scale": 1.5, "Detail": 0.0})
        dense = tree.add("MapRange", {0: noise.outputs[0], 1: 0.45, 2: 0.7, 3: 0.0, 4: 4.0})
        tree.links.new(dense.outputs[0], next(node for node in tree.nodes if node.type == "VOLUME_SCATTER").inputs["Density"])
        self.floor()
        self.cube(material)
        self.assert_same(0.03)

    def volume(self, file, material, scale, place, turn=(0.2, 0.4, 0.1), space="OBJECT"):
        """A Volume object of one of the files that tests of the renderer read."""
        data = bpy.data.volumes.new("Cloud")
        data.filepath = os.path.join(SEEDS, file)
        data.render.space = space
        data.materials.append(material)
        item = support.add(self.scene, "Cloud", data, place, turn)
        item.scale = (scale,) * 3
        return item

    def test_clouds(self):
        """Of a file, under a lamp."""
        values = {"Color": (0.8, 0.7, 0.6, 1), "Density": 0.4, "Anisotropy": 0.3}
        for space in ("OBJECT", "WORLD"):
            with self.subTest(space=space):
                cloud = self.volume("plain.vdb", self.filled(("VolumePrincipled", values)), 0.2, (-1.2, -1.3, -1.2), space=space)
                floor = self.floor()
                lamp = support.add(self.scene, "Lamp", self.light("POINT", energy=200, shadow_soft_size=0.1), (1.5, -1.0, 2.5))
                self.even_world((0.2, 0.2, 0.2))
                self.assert_same()
                for item in (cloud, floor, lamp):
                    bpy.data.objects.remove(item)

    def test_glowing_smoke(self):
        """The temperature of a file, as a black body, and a colour by nodes."""
        values = {"Color": (0.5, 0.5, 0.5, 1), "Density": 1.0, "Density Attribute": "temperature", "Blackbody Intensity": 1.0, "Temperature": 900.0}
        material = self.filled(("VolumePrincipled", values))
        self.even_world((0.1, 0.1, 0.1))
        self.volume("turned.vdb", material, 0.5, (-0.5, 0.0, -0.5))
        self.assert_same()

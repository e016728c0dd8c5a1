# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes of indices, mist, catchers and light groups, and view layers, beside Cycles. Needs bpy with Cycles, the renderer's Python module, and
a Python with OpenEXR, which reads the passes."""

import importlib.util
import unittest

import beside_cycles
import bpy
import numpy as np
import support
from test_surfaces import principled

HAS_OPENEXR = importlib.util.find_spec("OpenEXR") is not None
SIZE = 96, 72


@unittest.skipUnless(HAS_OPENEXR, "the Python module OpenEXR is not installed")
class Passes(beside_cycles.BesideCycles):
    """A red box and a blue one on a floor."""

    def setUp(self):
        super().setUp()
        self.scene.render.resolution_x, self.scene.render.resolution_y = SIZE
        support.add_camera(self.scene, (0, -7, 2.5), (1.3, 0, 0), lens=38)
        self.scene.afterimage.samples, self.scene.afterimage.paths, self.scene.afterimage.shadow_rays = 4, 32, "16"
        self.layer = self.scene.view_layers[0]
        self.grey, self.red, self.blue = (
            principled(name, Base_Color=(*color, 1), Specular_IOR_level=0.0, Roughness=1.0)[0]
            for name, color in (("Grey", (0.6, 0.6, 0.6)), ("Red", (0.8, 0.1, 0.1)), ("Blue", (0.1, 0.1, 0.8)))
        )
        mesh = support.grid("Floor", 24)
        mesh.materials.append(self.grey)
        self.floor = support.add(self.scene, "Floor", mesh)
        self.boxes = [self.box(place, material) for place, material in (((-1.0, 0, 0.6), self.red), ((1.2, 1.5, 0.6), self.blue))]

    def box(self, place, material):
        bpy.ops.mesh.primitive_cube_add(size=1.2, location=place, rotation=(0, 0, 0.4))
        bpy.context.object.data.materials.append(material)
        return bpy.context.object

    def sun(self, name="Sun", color=(1, 1, 1), turn=(0.6, 0.5, 0)):
        data = self.light("SUN", energy=3, angle=0.02, color=color)
        return support.add(self.scene, name, data, (0, 0, 9), turn)

    def sky(self, *color):
        self.even_world(color)

    def passes(self, engine, samples=64):
        """All channels of a render, by their names."""
        import OpenEXR

        self.scene.render.engine = engine
        if engine == "CYCLES":
            self.scene.cycles.samples, self.scene.cycles.use_denoising = samples, False
            self.scene.cycles.pixel_filter_type, self.scene.cycles.filter_width = "BOX", 1.0
        settings = self.scene.render.image_settings
        if hasattr(settings, "media_type"):
            settings.media_type = "MULTI_LAYER_IMAGE"
        settings.file_format, settings.color_depth = "OPEN_EXR_MULTILAYER", "32"
        self.scene.render.filepath = self.path(f"{engine}.exr")
        bpy.ops.render.render(write_still=True)
        with OpenEXR.File(self.path(f"{engine}.exr"), separate_channels=True) as file:
            return {name: channel.pixels.astype(np.float32) for part in file.parts for name, channel in part.channels.items()}

    def both_passes(self, samples=64):
        return self.passes("AFTERIMAGE"), self.passes("CYCLES", samples)

    def color(self, channels, name, layer="ViewLayer"):
        return np.stack([channels[f"{layer}.{name}.{letter}"] for letter in "RGB"], axis=2)

    def named(self, channels, *names):
        return next(channels[f"ViewLayer.{name}"] for name in names if f"ViewLayer.{name}" in channels)

    def test_indices_are_those_of_cycles(self):
        self.sun()
        for index, item in enumerate((self.floor, *self.boxes), 3):
            item.pass_index = index
        for index, material in enumerate((self.grey, self.red, self.blue), 11):
            material.pass_index = index
        self.layer.use_pass_object_index = self.layer.use_pass_material_index = True
        ours, cycles = self.both_passes(4)
        for names in (("Object Index.X", "IndexOB.X"), ("Material Index.X", "IndexMA.X")):
            mine, others = self.named(ours, *names), self.named(cycles, *names)
            self.assertEqual(set(np.unique(mine)), set(np.unique(others)))
            self.assertGreater(len(np.unique(mine)), 3)
            # rims
            self.assertLess((mine != others).mean(), 0.04)

    def test_mist_is_that_of_cycles(self):
        self.sun(), self.sky(0.1, 0.1, 0.1)
        self.layer.use_pass_mist = True
        mist = self.scene.world.mist_settings
        for falloff in ("QUADRATIC", "LINEAR", "INVERSE_QUADRATIC"):
            mist.start, mist.depth, mist.falloff = 5.0, 9.0, falloff
            ours, cycles = (self.named(channels, "Mist.Z") for channels in self.both_passes(64))
            np.testing.assert_allclose(ours.mean(), cycles.mean(), atol=2e-3)
            self.assertLess(np.abs(ours - cycles).mean(), 5e-3)
            self.assertGreater(ours.std(), 0.1)

    def test_the_pass_of_catchers_is_that_of_cycles(self):
        self.sun(color=(1, 0.3, 0.1)), self.sun("Other", (0.1, 0.4, 1), (0.6, -0.5, 0))
        self.scene.render.film_transparent = True
        self.floor.is_shadow_catcher = True
        self.layer.cycles.use_pass_shadow_catcher = True
        ours, cycles = self.both_passes(128)
        mine, others = (self.color(channels, "Shadow Catcher") for channels in (ours, cycles))
        self.assertLess(others.min(), 0.5)
        self.assertLess(np.abs(mine - others).mean(), 0.02)
        alpha = [channels["ViewLayer.Combined.A"] for channels in (ours, cycles)]
        self.assertLess(np.abs(alpha[0] - alpha[1]).mean(), 0.01)

    def test_light_groups_are_those_of_cycles_and_add_up(self):
        for name in ("key", "a sky", "glow", "nobody"):
            self.layer.lightgroups.add(name=name) if hasattr(self.layer.lightgroups, "add") else bpy.ops.scene.view_layer_add_lightgroup(name=name)
        self.sun().lightgroup = "key"
        self.sky(0.2, 0.3, 0.5)
        self.scene.world.lightgroup = "a sky"
        glow = principled("Glow", Base_Color=(0, 0, 0, 1), Specular_IOR_level=0.0, Emission_Color=(1, 0.5, 0.1, 1), Emission_Strength=6.0)[0]
        mesh = support.grid("Glow", 1.0)
        mesh.materials.append(glow)
        support.add(self.scene, "Glow", mesh, (0, -1.0, 2.2), (0.5, 0, 0)).lightgroup = "glow"
        ours, cycles = self.both_passes(256)
        whole = self.color(ours, "Combined")
        total = np.zeros_like(whole)
        for name in ("key", "a sky", "glow", "nobody"):
            mine, others = (self.color(channels, f"Combined_{name}") for channels in (ours, cycles))
            total += mine
            np.testing.assert_allclose(mine.mean(axis=(0, 1)), others.mean(axis=(0, 1)), rtol=0.04, atol=1e-3, err_msg=name)
            self.assertEqual(name == "nobody", mine.max() == 0)
        np.testing.assert_allclose(total, whole, rtol=0.01, atol=2e-3)

    def test_view_layers_have_their_own_collections_materials_and_samples(self):
        self.sun(), self.sky(0.1, 0.1, 0.1)
        own = bpy.data.collections.new("Boxes")
        self.scene.collection.children.link(own)
        for box in self.boxes:
            self.scene.collection.objects.unlink(box)
            own.objects.link(box)
        other = self.scene.view_layers.new("Clay")
        clay = principled("Clay", Base_Color=(0.7, 0.6, 0.5, 1), Specular_IOR_level=0.0, Roughness=1.0)[0]
        other.material_override = clay
        third = self.scene.view_layers.new("Floor")
        third.layer_collection.children["Boxes"].exclude = True
        fourth = self.scene.view_layers.new("Holes")
        fourth.layer_collection.children["Boxes"].holdout = True
        fourth.samples = 256
        ours, cycles = self.both_passes(64)
        for layer in ("ViewLayer", "Clay", "Floor", "Holes"):
            mine, others = (self.color(channels, "Combined", layer) for channels in (ours, cycles))
            np.testing.assert_allclose(mine.mean(axis=(0, 1)), others.mean(axis=(0, 1)), rtol=0.03, err_msg=layer)
            self.assertLess(np.abs(mine - others).mean(), 0.02 * others.mean() + 0.01, layer)

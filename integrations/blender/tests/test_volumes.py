# SPDX-License-Identifier: GPL-3.0-or-later
"""Volumes of materials and worlds: is what shaders say of them what is exported?"""

import os

import bpy
import numpy as np
import support
from support import Tree
from test_surfaces import principled


class Volumes(support.ExportCase):
    def filled(self, *nodes, surface=False):
        """A material with the volume that the last of these shaders gives: each a type, its inputs and its properties."""
        material, shader = principled("Smoke")
        tree = Tree(material)
        made = []
        for kind, inputs, *properties in nodes:
            inputs = {name: made[value].outputs[0] if isinstance(name, int) and isinstance(value, int) else value for name, value in inputs.items()}
            made.append(tree.add(kind, inputs, **(properties[0] if properties else {})))
        tree.links.new(made[-1].outputs[0], tree.nodes["Material Output"].inputs["Volume"])
        if not surface:
            material.node_tree.nodes.remove(shader)
        return material

    def exported(self, material):
        """The shot of a cube of a material."""
        bpy.ops.mesh.primitive_cube_add()
        bpy.context.object.data.materials.append(material)
        support.add_camera(self.scene)
        return self.export()

    def keys(self, *nodes):
        """What is exported of a volume alone."""
        table = self.exported(self.filled(*nodes))["material"][0]
        self.assertIs(table["surface"], False)
        return {name.removeprefix("volume_"): value for name, value in table.items() if name.startswith("volume_")}

    def assert_keys(self, found, **wanted):
        self.assertEqual(set(found), set(wanted))
        for name, value in wanted.items():
            np.testing.assert_allclose(found[name], value, rtol=1e-5, err_msg=name)

    def test_scatter(self):
        found = self.keys(("VolumeScatter", {"Color": (0.5, 0.25, 1, 1), "Density": 2.0, "Anisotropy": 0.3}))
        self.assert_keys(found, scatter=(1, 0.5, 2), anisotropy=0.3)

    def test_absorption(self):
        self.assert_keys(self.keys(("VolumeAbsorption", {"Color": (0.5, 0.25, 1, 1), "Density": 2.0})), absorb=(1, 1.5, 0))

    def test_emission(self):
        self.assert_keys(self.keys(("Emission", {"Color": (0.5, 0.25, 1, 1), "Strength": 4.0})), emit=(2, 1, 4))

    def test_principled(self):
        values = {"Color": (0.5, 0.25, 1, 1), "Density": 2.0, "Absorption Color": (0, 0.25, 1, 1), "Emission Strength": 0.5, "Emission Color": (1, 0.5, 0, 1)}
        self.assert_keys(self.keys(("VolumePrincipled", values)), scatter=(1, 0.5, 2), absorb=(1, 0.75, 0), emit=(0.5, 0.25, 0))

    def test_sums_and_mixtures(self):
        parts = ("VolumeScatter", {"Color": (1, 1, 1, 1), "Density": 2.0}), ("VolumeAbsorption", {"Color": (0, 0, 0, 1), "Density": 3.0})
        self.assert_keys(self.keys(*parts, ("AddShader", {0: 0, 1: 1})), scatter=(2, 2, 2), absorb=(3, 3, 3))

    def test_what_nodes_give_from_place_to_place_is_a_graph(self):
        for surface in (False, True):
            with self.subTest(surface=surface):
                material = self.filled(("VolumeScatter", {"Color": (1, 0.5, 0.25, 1)}), surface=surface)
                tree = Tree(material)
                noise = tree.add("TexNoise", {})
                tree.links.new(noise.outputs[0], next(node for node in tree.nodes if node.type == "VOLUME_SCATTER").inputs["Density"])
                table = self.exported(material)["material"][-1]
                self.assertNotIn("volume_scatter", table)
                with open(os.path.join(self.folder, table["mtlx"]), encoding="utf-8") as file:
                    text = file.read()
                self.assertRegex(text, r'<anisotropic_vdf[^>]*>\s*<input name="scattering" type="vector3" nodegraph=')
                self.assertIn("surfaceshader" if surface else "volumematerial", text)
                self.assertEqual([line for line in self.warnings() if "`Smoke`" in line and "olume" in line], [])

    def test_a_surface_stays_around_its_volume(self):
        table = self.exported(self.filled(("VolumeScatter", {"Color": (1, 1, 1, 1), "Density": 2.0}), surface=True))["material"][0]
        self.assertEqual(table["volume_scatter"], [2, 2, 2])
        self.assertNotIn("surface", table)

    def test_worlds(self):
        self.scene.world = bpy.data.worlds.new("World")
        self.scene.world.use_nodes = True
        tree = self.scene.world.node_tree
        fog = tree.nodes.new("ShaderNodeVolumeScatter")
        fog.inputs["Density"].default_value = 0.25
        tree.links.new(fog.outputs[0], tree.nodes["World Output"].inputs["Volume"])
        np.testing.assert_allclose(self.exported(principled("Stone")[0])["fog"]["scatter"], [0.2] * 3)

    def cloud(self, file, material=None, **values):
        """A Volume object of one of the files that tests of the renderer read."""
        data = bpy.data.volumes.new("Cloud")
        data.filepath = os.path.join(os.path.dirname(__file__), "../../../fuzz/seeds/vdb", file)
        for name, value in values.items():
            setattr(data, name, value)
        if material:
            data.materials.append(material)
        support.add_camera(self.scene)
        return support.add(self.scene, "Cloud", data)

    def test_volumes_are_files_and_what_their_material_makes_of_grids(self):
        cloud = self.cloud("plain.vdb", self.filled(("VolumePrincipled", {"Density": 2.0})))
        cloud.scale = (2, 2, 2)
        shot = self.export()
        model, material = shot["model"][0], shot["material"][0]
        self.assertEqual((model["vdb"]["material"], model["vdb"]["grids"]), (material["name"], ["density"]))
        with open(os.path.join(self.folder, model["vdb"]["file"]), "rb") as copied, open(bpy.path.abspath(cloud.data.filepath), "rb") as file:
            self.assertEqual(copied.read(), file.read())
        self.assertIs(material["surface"], False)
        # of a larger object there is less in each unit
        self.assertAlmostEqual(material["volume_density"], 0.5, 5)
        with open(os.path.join(self.folder, material["mtlx"]), encoding="utf-8") as file:
            text = file.read()
        self.assertRegex(text, r'<blender_volume_grid name="n1" type="multioutput">\s*<input name="grid" type="string" value="density"/>')
        self.assertEqual(self.warnings(), [])

    def test_volumes_glow_by_their_temperature(self):
        values = {"Density Attribute": "temperature", "Blackbody Intensity": 1.0}
        self.cloud("turned.vdb", self.filled(("VolumePrincipled", values)))
        shot = self.export()
        self.assertEqual(shot["model"][0]["vdb"]["grids"], ["temperature"])
        with open(os.path.join(self.folder, shot["material"][0]["mtlx"]), encoding="utf-8") as file:
            self.assertIn("blender_blackbody", file.read())
        self.assertEqual(self.warnings(), [])

    def test_volumes_that_cannot_be_read_are_told(self):
        for file, told in (("mask.vdb", "no grid of numbers"), ("none.vdb", "cannot be read")):
            with self.subTest(file=file):
                cloud = self.cloud(file)
                self.assertEqual([model["name"] for model in self.export()["model"]], ["nothing"])
                self.assertEqual(len([line for line in self.warnings() if f"`{cloud.name}`" in line and told in line]), 1, self.warnings())
                bpy.data.objects.remove(cloud)

    def test_smoke_that_is_simulated_is_left_out_and_told(self):
        support.add(self.scene, "Floor", support.grid("Floor"))
        bpy.ops.mesh.primitive_cube_add()
        domain = bpy.context.object
        domain.name = "Domain"
        domain.data.materials.append(self.filled(("VolumePrincipled", {})))
        fluid = domain.modifiers.new("Fluid", "FLUID")
        fluid.fluid_type = "DOMAIN"
        fluid.domain_settings.domain_type = "GAS"
        support.add_camera(self.scene)
        self.assertEqual([model["name"] for model in self.export()["model"]], ["Floor"])
        self.assertEqual(len([line for line in self.warnings() if "`Domain`" in line and "smoke" in line]), 1)

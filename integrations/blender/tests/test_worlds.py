# SPDX-License-Identifier: GPL-3.0-or-later
"""Worlds that are more than a colour, a picture or a sky: what Cycles bakes of them. Needs bpy with Cycles; the first class asks no renderer."""

import os
import unittest

import beside_cycles
import bpy
import numpy as np
import support


class Nodes:
    """Builds worlds of the scene."""

    def world(self, name="Dusk"):
        """Gives the scene a world. Returns its tree."""
        self.scene.world = bpy.data.worlds.new(name)
        self.scene.world.use_nodes = True
        return self.scene.world.node_tree

    def node(self, kind, **values):
        """A node of the world. `values`: its inputs, by names with _ for blanks."""
        node = self.scene.world.node_tree.nodes.new(f"ShaderNode{kind}")
        for name, value in values.items():
            node.inputs[name.replace("_", " ")].default_value = value
        return node

    def link(self, output, socket=None):
        """Links an output to an input, or to the world's surface."""
        tree = self.scene.world.node_tree
        tree.links.new(output, socket or tree.nodes["World Output"].inputs["Surface"])

    def background(self, color=(1, 1, 1, 1), strength=1.0):
        return self.node("Background", Color=color, Strength=strength)

    def mixed(self, factor, one, other):
        """A mix of two shaders as the world's surface. `factor`: a number, or an output."""
        mix = self.node("MixShader")
        for value, socket in zip((factor, one, other), mix.inputs):
            if isinstance(value, float):
                socket.default_value = value
            else:
                self.link(value, socket)
        self.link(mix.outputs[0])

    def gradient(self):
        """A world that is red towards +X, and green towards +Z."""
        tree = self.world()
        place, parts, join = self.node("TexCoord"), self.node("SeparateXYZ"), self.node("CombineColor")
        self.link(place.outputs["Generated"], parts.inputs[0])
        clamps = [self.node("Clamp") for _ in range(2)]
        for clamp, output, socket in zip(clamps, ("X", "Z"), join.inputs):
            self.link(parts.outputs[output], clamp.inputs[0])
            self.link(clamp.outputs[0], socket)
        self.link(join.outputs[0], tree.nodes["Background"].inputs["Color"])
        return tree.nodes["Background"]

    def sky(self, elevation, rotation):
        """A Background node of a sky texture."""
        node, shader = self.node("TexSky"), self.background()
        node.sun_elevation, node.sun_rotation = elevation, rotation
        self.link(node.outputs[0], shader.inputs["Color"])
        return shader


class Worlds(support.ExportCase, Nodes):
    def setUp(self):
        super().setUp()
        support.add_camera(self.scene)
        self.bake = support.extension().export.world.world_bake
        self.bake._baked.clear()
        self.runs, self.run_of = [], self.bake._run
        self.bake._run = lambda *values: self.runs.append(values[1]) or self.run_of(*values)

    def tearDown(self):
        self.bake._run = self.run_of
        super().tearDown()

    def map(self, shot):
        """The environment's picture, the top row first."""
        return support.read_pixels(os.path.join(self.folder, shot["environment"]["map"]))[:, :, :3]

    def said(self):
        return [line for line in self.warnings() if "Dusk" in line]

    def test_a_world_of_directions_is_baked_as_it_is(self):
        self.gradient().inputs["Strength"].default_value = 2.0
        shot = self.export()
        pixels = self.map(shot)
        height, width = pixels.shape[:2]
        # +X in the middle, +Z above: what lies ahead of -90 degrees
        self.assertEqual((width, height, shot["environment"]["rotation"], shot["environment"]["power"]), (1024, 512, -90, 1))
        np.testing.assert_allclose(pixels[height // 2, width // 2], [2, 0, 0], atol=0.02)
        np.testing.assert_allclose(pixels[0, 0], [0, 2, 0], atol=0.02)
        np.testing.assert_allclose(pixels[height // 4, width // 2], [2**0.5, 2**0.5, 0], atol=0.02)
        self.assertEqual((self.runs, self.said()), (["world `Dusk`"], []))

    def test_a_world_is_baked_again_only_when_what_it_shows_has_changed(self):
        node = self.gradient()
        self.export()
        self.scene.world.node_tree.nodes["World Output"].location = (900, 0)
        self.export()
        self.assertEqual(len(self.runs), 1)
        self.scene.world.node_tree.links.remove(self.scene.world.node_tree.nodes["Separate XYZ"].outputs["X"].links[0])
        self.export()
        self.assertEqual(len(self.runs), 2)
        node.inputs["Strength"].default_value = 3.0
        self.export()
        self.assertEqual(len(self.runs), 3)

    def test_a_bake_is_that_of_the_frame(self):
        strength = self.gradient().inputs["Strength"]
        for frame, value in ((1, 1.0), (3, 3.0)):
            strength.default_value = value
            strength.keyframe_insert("default_value", frame=frame)
        self.scene.frame_start, self.scene.frame_end = 3, 4
        np.testing.assert_allclose(self.map(self.export()).max(), 3, atol=0.03)
        self.assertEqual(self.said(), [])
        self.scene.frame_start = 1
        np.testing.assert_allclose(self.map(self.export()).max(), 1, atol=0.01)
        self.assertEqual((self.said(), len(self.runs)), (["world `Dusk` is animated: frame 1 is shown"], 2))

    def test_coordinates_of_an_object_are_those_of_where_it_is(self):
        self.gradient()
        compass = support.add(self.scene, "Compass", None)
        self.scene.world.node_tree.nodes["Texture Coordinate"].object = compass
        links = self.scene.world.node_tree.links
        links.new(self.scene.world.node_tree.nodes["Texture Coordinate"].outputs["Object"], self.scene.world.node_tree.nodes["Separate XYZ"].inputs[0])
        for turn in (0.0, np.pi):
            compass.rotation_euler.z = turn
            pixels = self.map(self.export())
            # red where its X points to
            ahead, behind = pixels[256, 512, 0], pixels[256, 2, 0]
            np.testing.assert_allclose((ahead, behind), (1, 0) if turn == 0 else (0, 1), atol=0.05)
        self.assertEqual((len(self.runs), self.said()), (2, []))

    def test_mixes_of_colours_are_colours_without_a_bake(self):
        self.world()
        self.mixed(0.25, self.background((1, 0, 0, 1), 2.0).outputs[0], self.background((0, 1, 0, 1)).outputs[0])
        np.testing.assert_allclose(self.export()["background"]["color"], [1.5, 0.25, 0])
        self.assertEqual((self.runs, self.said()), ([], []))

    def test_a_colour_that_is_plugged_into_the_surface_is_the_light(self):
        self.world()
        color = self.node("RGB")
        color.outputs[0].default_value = (0.25, 0.5, 1, 1)
        self.link(color.outputs[0])
        np.testing.assert_allclose(self.export()["background"]["color"], [0.25, 0.5, 1])
        self.assertEqual((self.runs, self.said()), ([], []))

    def test_a_world_that_comes_out_as_one_colour_is_that_colour(self):
        tree = self.world()
        warm = self.node("Blackbody", Temperature=3000.0)
        self.link(warm.outputs[0], tree.nodes["Background"].inputs["Color"])
        shot = self.export()
        red, green, blue = shot["background"]["color"]
        self.assertTrue(red > green > blue)
        self.assertEqual((shot["environment"], len(self.runs), self.said()), ({}, 1, []))

    def test_what_the_camera_alone_sees_of_mixed_colours_is_the_background(self):
        tree = self.world()
        path, mix = self.node("LightPath"), self.node("MixRGB", Color1=(0, 0, 1, 1), Color2=(1, 0, 0, 1))
        self.link(path.outputs["Is Camera Ray"], mix.inputs[0])
        self.link(mix.outputs[0], tree.nodes["Background"].inputs["Color"])
        shot = self.export()
        np.testing.assert_allclose(shot["background"]["color"], [1, 0, 0], atol=1e-3)
        self.assertFalse(shot["environment"]["visible"])
        np.testing.assert_allclose(self.map(shot).mean(axis=(0, 1)), [0, 0, 1], atol=1e-3)
        self.assertEqual(self.said(), [])

    def test_a_picture_for_the_camera_alone_is_told_and_what_lights_is_shown(self):
        shader = self.gradient()
        path = self.node("LightPath")
        self.mixed(path.outputs["Is Camera Ray"], self.background((0, 0, 1, 1)).outputs[0], shader.outputs[0])
        shot = self.export()
        np.testing.assert_allclose(self.map(shot).mean(axis=(0, 1)), [0, 0, 1], atol=1e-3)
        self.assertEqual(self.said(), ["world `Dusk`: what the camera sees of it is no plain colour: it sees what lights"])

    def test_a_picture_that_is_missing_is_magenta_behind_what_the_camera_sees(self):
        self.world()
        path, shader = self.node("LightPath"), self.background()
        self.link(self.node("TexEnvironment").outputs[0], shader.inputs["Color"])
        self.mixed(path.outputs["Is Camera Ray"], shader.outputs[0], self.background((0, 1, 0, 1)).outputs[0])
        shot = self.export()
        self.assertEqual((shot["background"]["color"], self.map(shot)[0, 0].tolist()), ([0, 1, 0], [1, 0, 1]))
        self.assertEqual(self.said(), ["world `Dusk`: its environment texture has no image"])

    def picture(self, **turn):
        """A world of a picture whose upper half is white, behind a Mapping node."""
        tree = self.world()
        place, mapping, source = self.node("TexCoord"), self.node("Mapping", **turn), self.node("TexEnvironment")
        source.image = bpy.data.images.new("Half", 64, 32, float_buffer=True)
        pixels = np.ones((32, 64, 4), dtype=np.float32)
        pixels[:16, :, :3] = 0
        source.image.pixels.foreach_set(pixels.ravel())
        source.image.filepath_raw, source.image.file_format = os.path.join(self.scratch.name, "half.exr"), "OPEN_EXR"
        source.image.save()
        self.link(place.outputs["Generated"], mapping.inputs["Vector"])
        self.link(mapping.outputs[0], source.inputs["Vector"])
        self.link(source.outputs[0], tree.nodes["Background"].inputs["Color"])

    def test_a_picture_that_is_turned_about_z_is_itself(self):
        self.picture(Rotation=(0, 0, np.radians(30)))
        self.assertAlmostEqual(self.export()["environment"]["rotation"], -120, places=4)
        self.assertEqual((self.runs, self.said()), ([], []))

    def test_a_picture_that_is_turned_about_x_is_baked(self):
        self.picture(Rotation=(np.pi, 0, 0))
        pixels = self.map(self.export())
        np.testing.assert_allclose([pixels[128, 0, 0], pixels[384, 0, 0]], [0, 1], atol=1e-3)
        self.assertEqual((len(self.runs), self.said()), (1, []))

    def test_each_of_several_skies_has_its_sun(self):
        self.world()
        self.mixed(0.5, self.sky(0.3, 0.0).outputs[0], self.sky(0.9, 1.0).outputs[0])
        shot = self.export()
        heights = sorted(-light["direction"][1] for light in shot["light"])
        np.testing.assert_allclose(heights, np.sin([0.3, 0.9]), atol=1e-5)
        self.assertEqual(len(self.runs), 1)
        # the higher one is brighter, and each is half of what it is alone
        powers = {round(-light["direction"][1], 2): light["power"] for light in shot["light"]}
        self.world("Alone")
        self.link(self.sky(0.9, 1.0).outputs[0])
        self.assertAlmostEqual(self.export()["light"][0]["power"] / powers[0.78], 2, places=2)
        self.assertGreater(powers[0.78], powers[0.3])


class WorldsBesideCycles(beside_cycles.BesideCycles, Nodes):
    def assert_alike(self, tolerance):
        """A matt ball on nothing, and what is around it, must be alike in four quarters of the picture and in the middle."""
        mesh = bpy.data.meshes.new("Ball")
        import bmesh

        made = bmesh.new()
        bmesh.ops.create_icosphere(made, subdivisions=4, radius=1.0)
        made.to_mesh(mesh)
        made.free()
        material = bpy.data.materials.new("Matt")
        material.use_nodes = True
        material.node_tree.nodes["Principled BSDF"].inputs["Specular IOR Level"].default_value = 0
        mesh.materials.append(material)
        support.add(self.scene, "Ball", mesh)
        support.add_camera(self.scene, (0, -4, 0))
        self.scene.afterimage.paths = 64
        ours, cycles = self.both(64)
        fields = [np.s_[:24, :32], np.s_[:24, 32:], np.s_[24:, :32], np.s_[24:, 32:], np.s_[16:24, 24:40], np.s_[24:32, 24:40]]
        for field in fields:
            mine, theirs = (picture[field][:, :, :3].mean(axis=(0, 1)) for picture in (ours, cycles))
            np.testing.assert_allclose(mine, theirs, rtol=tolerance, atol=0.005, err_msg=str(field))

    def test_a_gradient_lights_and_is_seen_as_in_cycles(self):
        self.gradient()
        self.assert_alike(0.03)

    def test_a_world_of_noise_is_that_of_cycles(self):
        tree = self.world()
        noise, place = self.node("TexNoise", Scale=3.0, Detail=4.0), self.node("TexCoord")
        self.link(place.outputs["Generated"], noise.inputs["Vector"])
        self.link(noise.outputs["Color"], tree.nodes["Background"].inputs["Color"])
        self.assert_alike(0.03)

    def test_a_colour_in_the_place_of_a_material_is_emission_as_in_cycles(self):
        support.add_camera(self.scene)
        material = bpy.data.materials.new("Glow")
        material.use_nodes = True
        tree = material.node_tree
        color = tree.nodes.new("ShaderNodeRGB")
        color.outputs[0].default_value = (0.2, 0.6, 0.9, 1)
        tree.links.new(color.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
        mesh = support.grid("Panel", 9)
        mesh.materials.append(material)
        support.add(self.scene, "Panel", mesh, turn=(np.pi / 2, 0, 0))
        for picture in self.both(1):
            np.testing.assert_allclose(picture.mean(axis=(0, 1)), [0.2, 0.6, 0.9, 1], atol=1e-3)
        self.assertEqual(self.exported.warnings, [])


if __name__ == "__main__":
    unittest.main()

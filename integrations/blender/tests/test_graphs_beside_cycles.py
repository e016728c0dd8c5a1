# SPDX-License-Identifier: GPL-3.0-or-later
"""What nodes compute of surfaces, beside Cycles. Needs bpy and the renderer's Python module."""

import beside_cycles
import bpy
import numpy as np
import support
from support import Tree
from test_surfaces import principled


def coordinates(tree, output="Object"):
    return tree.add("TexCoord").outputs[output]


def noise(tree, **values):
    inputs = {"Vector": coordinates(tree), "Scale": 1.5, "Detail": 3.0}
    return tree.add("TexNoise", inputs, **values).outputs


def ramp(tree, factor, interpolation="LINEAR", mode="RGB"):
    node = tree.add("ValToRGB", {0: factor})
    node.color_ramp.interpolation, node.color_ramp.color_mode = interpolation, mode
    stops = node.color_ramp.elements
    stops[0].position, stops[0].color = 0.3, (0.8, 0.1, 0.05, 1)
    stops[1].position, stops[1].color = 0.7, (0.05, 0.3, 0.7, 1)
    stops.new(0.5).color = (0.9, 0.8, 0.2, 1)
    return node.outputs["Color"]


def curves(tree, color):
    node = tree.add("RGBCurve", {"Color": color})
    node.mapping.curves[3].points.new(0.5, 0.2)
    node.mapping.curves[0].points.new(0.3, 0.6)
    return node.outputs[0]


def mapped(tree, kind):
    inputs = {"Vector": coordinates(tree, "Generated"), "Location": (0.3, 0.1, 0), "Rotation": (0.2, 0.3, 0.7), "Scale": (3, 1.5, 1)}
    return tree.add("TexNoise", {"Vector": tree.add("Mapping", inputs, vector_type=kind).outputs[0]}).outputs["Color"]


def texture(kind, output="Color", inputs=(), **values):
    """A builder of one texture in object space."""

    def build(tree):
        at = tree.add("Mapping", {"Vector": coordinates(tree), "Location": (0.31, 0.17, 0.23)}).outputs[0]
        return tree.add(f"Tex{kind}", {"Vector": at, **dict(inputs)}, **values).outputs[output]

    return build


def towards(tree):
    node = tree.add("Normal", {0: coordinates(tree)})
    node.outputs["Normal"].default_value = (0.8, 0.6, 0)
    return node.outputs["Dot"]


def grouped(tree):
    """A group that scales a noise, with a group in it."""
    inner = bpy.data.node_groups.new("Inner", "ShaderNodeTree")
    inner.interface.new_socket("Value", in_out="INPUT", socket_type="NodeSocketFloat")
    inner.interface.new_socket("Value", in_out="OUTPUT", socket_type="NodeSocketFloat")
    begin, end = inner.nodes.new("NodeGroupInput"), inner.nodes.new("NodeGroupOutput")
    math = inner.nodes.new("ShaderNodeMath")
    math.operation = "PINGPONG"
    math.inputs[1].default_value = 0.2
    inner.links.new(begin.outputs[0], math.inputs[0])
    inner.links.new(math.outputs[0], end.inputs[0])
    outer = bpy.data.node_groups.new("Outer", "ShaderNodeTree")
    outer.interface.new_socket("Value", in_out="INPUT", socket_type="NodeSocketFloat")
    outer.interface.new_socket("Value", in_out="OUTPUT", socket_type="NodeSocketFloat")
    begin, end, one = outer.nodes.new("NodeGroupInput"), outer.nodes.new("NodeGroupOutput"), outer.nodes.new("ShaderNodeGroup")
    one.node_tree = inner
    outer.links.new(begin.outputs[0], one.inputs[0])
    outer.links.new(one.outputs[0], end.inputs[0])
    group = tree.add("Group", node_tree=outer)
    tree.links.new(noise(tree)[0], group.inputs[0])
    return tree.add("Math", {0: group.outputs[0], 1: 3.0}, operation="MULTIPLY").outputs[0]


BUILDERS = {
    "noise": lambda tree: noise(tree)["Color"],
    "noise of four dimensions": lambda tree: noise(tree, noise_dimensions="4D")["Color"],
    "ridges": lambda tree: noise(tree, noise_type="RIDGED_MULTIFRACTAL")[0],
    "cells": texture("Voronoi", "Color", {"Scale": 2.0}),
    "smooth cells": texture("Voronoi", "Distance", {"Scale": 2.0}, feature="SMOOTH_F1"),
    "edges": texture("Voronoi", "Distance", {"Scale": 2.0}, feature="DISTANCE_TO_EDGE"),
    "rings": texture("Wave", "Color", {"Scale": 1.0, "Distortion": 2.0}, wave_type="RINGS"),
    "bands": texture("Wave", "Color", {"Scale": 1.0}, wave_profile="SAW", bands_direction="DIAGONAL"),
    "magic": texture("Magic", "Color", {"Scale": 1.0}),
    "checker": texture("Checker", "Color", {"Scale": 2.0, "Color1": (0.9, 0.2, 0.1, 1)}),
    "bricks": texture("Brick", "Color", {"Scale": 2.0, "Color1": (0.9, 0.2, 0.1, 1), "Mortar": (0.1, 0.1, 0.1, 1)}),
    "gradient": texture("Gradient", "Color", gradient_type="RADIAL"),
    "gabor": texture("Gabor", "Value", {"Scale": 1.0}),
    "ramp": lambda tree: ramp(tree, noise(tree)[0]),
    "smooth ramp": lambda tree: ramp(tree, noise(tree)[0], "B_SPLINE"),
    "ramp of hues": lambda tree: ramp(tree, noise(tree)[0], mode="HSV"),
    "curves": lambda tree: curves(tree, noise(tree)["Color"]),
    "mapping": lambda tree: mapped(tree, "POINT"),
    "mapping of textures": lambda tree: mapped(tree, "TEXTURE"),
    "hue": lambda tree: tree.add("HueSaturation", {"Hue": 0.7, "Saturation": 1.5, "Color": noise(tree)["Color"]}).outputs[0],
    "contrast": lambda tree: tree.add("BrightContrast", {"Color": noise(tree)["Color"], "Contrast": 1.0}).outputs[0],
    "number of a colour": lambda tree: tree.add("Math", {0: noise(tree)["Color"], 1: 2.0}, operation="POWER").outputs[0],
    "number of a vector": lambda tree: tree.add("Math", {0: coordinates(tree), 1: 0.2}, operation="MULTIPLY_ADD").outputs[0],
    "generated by default": lambda tree: tree.add("TexNoise", {"Scale": 4.0}).outputs["Color"],
    "separate": lambda tree: tree.add("SeparateXYZ", {0: coordinates(tree, "Generated")}).outputs["Y"],
    "towards a direction": towards,
    "map range": lambda tree: tree.add("MapRange", {0: noise(tree)[0], 1: 0.4, 2: 0.6, 3: 0.1, 4: 0.9}, interpolation_type="SMOOTHSTEP").outputs[0],
    "vectors": lambda tree: tree.add("VectorMath", {0: coordinates(tree), 1: (0.7, 0.4, 0.3)}, operation="MODULO").outputs[0],
    "places of the world": lambda tree: tree.add("TexNoise", {"Vector": tree.add("NewGeometry").outputs["Position"], "Scale": 1.5}).outputs["Color"],
    "normals of the world": lambda tree: tree.add("VectorMath", {0: tree.add("NewGeometry").outputs["Normal"], 1: noise(tree)[0]}, operation="MULTIPLY").outputs[0],
    "groups": grouped,
}
"""What gives a base colour, by name."""


class GraphsBesideCycles(beside_cycles.BesideCycles):
    def setUp(self):
        super().setUp()
        self.scene.world = bpy.data.worlds.new("World")
        self.scene.world.use_nodes = True
        self.scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
        self.scene.afterimage.samples = 4
        # turned, moved and scaled: spaces differ
        support.add_camera(self.scene, (0.3, 0.2, 6), (0, 0, 0))
        self.mesh = support.grid("Square", 4, 4)
        item = support.add(self.scene, "Square", self.mesh, (0.2, 0.1, -0.5), (0.3, -0.2, 0.4))
        item.scale = (1.1, 0.8, 1)

    def show(self, name, build):
        """Has the square show a base colour, on a matt surface: before a white world that is what is seen."""
        material, node = principled(name, Roughness=1.0, Specular_IOR_Level=0.0)
        tree = Tree(material)
        tree.links.new(build(tree), node.inputs["Base Color"])
        self.mesh.materials.clear()
        self.mesh.materials.append(material)

    def difference(self, samples=64):
        """Mean and largest difference of both pictures, of channels."""
        ours, cycles = self.both(samples)
        self.assertGreater(np.ptp(cycles[12:-12, 16:-16, :3]), 0.05, "it shows a pattern")
        apart = np.abs(ours - cycles)[:, :, :3]
        return float(apart.mean()), ours, cycles

    def test_every_kind_of_node_is_what_cycles_shows(self):
        for name, build in BUILDERS.items():
            with self.subTest(name):
                self.show(name, build)
                mean, _, _ = self.difference()
                self.assertLess(mean, 0.008)
                self.assertFalse([said for said in self.exported.warnings if "constant" in said], name)

    def test_pictures_take_computed_coordinates_and_mix_with_patterns(self):
        image = bpy.data.images.new("Stripes", 32, 32, float_buffer=True)
        values = np.ones((32, 32, 4), dtype=np.float32)
        values[:, ::2, 0] = 0.1
        values[::4, :, 1] = 0.2
        image.pixels.foreach_set(values.ravel())

        def build(tree):
            picture = tree.add("TexImage", image=image, interpolation="Linear")
            tree.links.new(tree.add("Mapping", {"Vector": coordinates(tree, "UV"), "Scale": (2, 1, 1)}).outputs[0], picture.inputs[0])
            mix = tree.add("Mix", data_type="RGBA", blend_type="MULTIPLY")
            for index, source in ((0, noise(tree)[0]), (6, picture.outputs["Color"]), (7, noise(tree)["Color"])):
                tree.links.new(source, mix.inputs[index])
            return mix.outputs[2]

        uvs = self.mesh.uv_layers.new().data
        points = np.array([self.mesh.vertices[loop.vertex_index].co[:2] for loop in self.mesh.loops]) / 4 + 0.5
        uvs.foreach_set("uv", points.astype(np.float32).ravel())
        self.show("Both", build)
        mean, _, _ = self.difference()
        self.assertLess(mean, 0.02)

    def test_pictures_at_coordinates_that_are_no_uv_map(self):
        image = bpy.data.images.new("Bars", 16, 16, float_buffer=True)
        values = np.ones((16, 16, 4), dtype=np.float32)
        values[:, ::2, 0], values[::4, :, 2] = 0.1, 0.3
        image.pixels.foreach_set(values.ravel())
        for output in ("Generated", "Object"):
            with self.subTest(output):

                def build(tree, output=output):
                    bent = tree.add("VectorMath", {0: noise(tree)["Color"], 1: (0.1, 0.1, 0), 2: coordinates(tree, output)}, operation="MULTIPLY_ADD")
                    picture = tree.add("TexImage", image=image, interpolation="Linear")
                    tree.links.new(bent.outputs[0], picture.inputs[0])
                    return picture.outputs["Color"]

                self.show(output, build)
                mean, _, _ = self.difference()
                self.assertLess(mean, 0.02)

    def test_surfaces_that_a_pattern_mixes(self):
        material, node = principled("Mixed", Roughness=1.0, Specular_IOR_Level=0.0, Base_Color=(0.8, 0.1, 0.1, 1))
        tree = Tree(material)
        other = tree.add("BsdfDiffuse", {"Color": (0.1, 0.2, 0.8, 1)})
        mix = tree.add("MixShader", {0: noise(tree)[0], 1: node.outputs[0], 2: other.outputs[0]})
        tree.links.new(mix.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
        self.mesh.materials.append(material)
        mean, _, _ = self.difference()
        self.assertLess(mean, 0.008)

    def test_heights_bend_normals(self):
        # a lamp from the side shows the slopes
        self.scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.02, 0.02, 0.02, 1)
        support.add(self.scene, "Sun", self.light("SUN", energy=3, angle=0.0), (0, 0, 5), (0.9, 0.3, 0))
        for invert, strength in ((False, 1.0), (True, 0.6)):
            with self.subTest(invert=invert):
                material, node = principled("Rough", Roughness=1.0, Specular_IOR_Level=0.0)
                tree = Tree(material)
                bump = tree.add("Bump", {"Height": noise(tree)[0], "Strength": strength, "Distance": 0.8}, invert=invert)
                tree.links.new(bump.outputs[0], node.inputs["Normal"])
                self.mesh.materials.clear()
                self.mesh.materials.append(material)
                mean, ours, cycles = self.difference()
                self.assertLess(mean, 0.01)
                spread = [float(np.std(picture[16:-16, 20:-20, 0])) for picture in (ours, cycles)]
                self.assertGreater(spread[1], 0.05, "it shows slopes")
                self.assertLess(abs(spread[0] - spread[1]), 0.1 * spread[1])

    def test_roughness_and_metal_vary(self):
        # a lamp in the mirrored direction: what is smooth shows it, what is rough spreads it
        self.scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.3, 0.3, 1)
        support.add(self.scene, "Sun", self.light("SUN", energy=2, angle=0.4), (0, 0, 5), (0.5, -0.35, 0))
        self.scene.afterimage.samples, self.scene.afterimage.paths, self.scene.afterimage.reflections = 8, 64, 64
        for what in ("Roughness", "Metallic", "both"):
            with self.subTest(what):
                material, node = principled(what, Roughness=0.4, Base_Color=(0.8, 0.5, 0.2, 1))
                tree = Tree(material)
                wide = tree.add("MapRange", {0: noise(tree)[0], 1: 0.4, 2: 0.6, 3: 0.15, 4: 0.9}).outputs[0]
                if what != "Metallic":
                    tree.links.new(wide, node.inputs["Roughness"])
                if what != "Roughness":
                    tree.links.new(wide, node.inputs["Metallic"])
                self.mesh.materials.clear()
                self.mesh.materials.append(material)
                mean, ours, cycles = self.difference(512)
                self.assertLess(mean, 0.02)
                middle = [picture[12:-12, 16:-16, :3] for picture in (ours, cycles)]
                np.testing.assert_allclose(middle[0].mean(axis=(0, 1)), middle[1].mean(axis=(0, 1)), rtol=0.02)
                self.assertFalse([said for said in self.exported.warnings if "constant" in said])

    def shown_by(self, name, build):
        """Has the square show the shader that `build` makes."""
        material, _ = principled(name)
        tree = Tree(material)
        tree.links.new(build(tree), tree.nodes["Material Output"].inputs["Surface"])
        self.mesh.materials.clear()
        self.mesh.materials.append(material)

    def test_a_mirror_in_part_keeps_the_pattern_of_what_is_matt(self):
        # a wall of tiles, whose mortar reflects as well or does not
        self.scene.afterimage.samples, self.scene.afterimage.paths, self.scene.afterimage.reflections = 4, 16, 16

        def tiles(tree, is_even):
            at = tree.add("Mapping", {"Vector": coordinates(tree), "Location": (0.31, 0.17, 0.23)}).outputs[0]
            brick = tree.add("TexBrick", {"Vector": at, "Scale": 1.0, "Mortar Size": 0.05, "Color1": (1, 1, 1, 1), "Color2": (1, 1, 1, 1), "Mortar": (0, 0, 0, 1)})
            mortar, tile = (tree.add("BsdfDiffuse", {"Color": color}).outputs[0] for color in ((0.8, 0.7, 0.6, 1), (0.25, 0.05, 0.03, 1)))
            matt = tree.add("MixShader", {0: brick.outputs[1], 1: tile, 2: mortar}).outputs[0]
            mirror = tree.add("BsdfGlossy", {"Color": (1, 1, 1, 1) if is_even else brick.outputs[0], "Roughness": 0.2}).outputs[0]
            return tree.add("MixShader", {0: 0.2, 1: matt, 2: mirror}).outputs[0]

        for is_even in (True, False):
            with self.subTest(is_even=is_even):
                self.shown_by(f"Tiles {is_even}", lambda tree: tiles(tree, is_even))
                mean, _, _ = self.difference()
                # a layer reflects less head-on than a mirror in part, and more towards edges
                self.assertLess(mean, 0.025 if is_even else 0.01)
                self.assertFalse([said for said in self.exported.warnings if "constant" in said])

    def test_light_that_a_pattern_gives(self):
        self.scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.1, 0.1, 0.1, 1)

        def glowing(tree):
            inputs = {"Base Color": (0, 0, 0, 1), "Specular IOR Level": 0.0, "Emission Color": noise(tree)["Color"], "Emission Strength": 3.0}
            return tree.add("BsdfPrincipled", inputs).outputs[0]

        def crack(tree):
            wide = tree.add("MapRange", {0: noise(tree)[0], 1: 0.45, 2: 0.55}).outputs[0]
            matt, light = tree.add("BsdfDiffuse", {"Color": (0.3, 0.2, 0.1, 1)}), tree.add("Emission", {"Color": (1, 0.3, 0.05, 1), "Strength": 2.0})
            return tree.add("MixShader", {0: wide, 1: matt.outputs[0], 2: light.outputs[0]}).outputs[0]

        def added(tree):
            light = tree.add("Emission", {"Color": (0.2, 0.5, 1, 1), "Strength": noise(tree)[0]})
            return tree.add("AddShader", {0: tree.add("BsdfDiffuse").outputs[0], 1: light.outputs[0]}).outputs[0]

        for build in (glowing, crack, added):
            with self.subTest(build.__name__):
                self.shown_by(build.__name__, build)
                mean, _, cycles = self.difference()
                self.assertLess(mean, 0.01 * max(1.0, float(cycles.max())))
                self.assertFalse([said for said in self.exported.warnings if "constant" in said], build.__name__)

    def test_surfaces_that_a_pattern_makes_clear(self):
        self.scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.2, 0.4, 0.8, 1)
        # a wall behind, on which what is there casts its shadow
        support.add(self.scene, "Wall", support.grid("Wall", 6), (0, 0, -1.5))
        support.add(self.scene, "Sun", self.light("SUN", energy=3, angle=0.0), (0, 0, 5), (0.2, 0.1, 0))

        def holes(tree):
            step = tree.add("Math", {0: noise(tree)[0], 1: 0.5}, operation="GREATER_THAN").outputs[0]
            return tree.add("MixShader", {0: step, 1: tree.add("BsdfTransparent").outputs[0], 2: tree.add("BsdfDiffuse").outputs[0]}).outputs[0]

        def smoke(tree):
            wide = tree.add("MapRange", {0: noise(tree)[0], 1: 0.35, 2: 0.65}).outputs[0]
            inputs = {"Base Color": (0.8, 0.5, 0.2, 1), "Specular IOR Level": 0.0, "Roughness": 1.0, "Alpha": wide}
            return tree.add("BsdfPrincipled", inputs).outputs[0]

        def glowing_smoke(tree):
            inputs = {"Base Color": (0, 0, 0, 1), "Specular IOR Level": 0.0, "Emission Color": noise(tree)["Color"], "Emission Strength": 1.5}
            inputs["Alpha"] = tree.add("Math", {0: noise(tree)[0], 1: 1.2}, operation="MULTIPLY").outputs[0]
            return tree.add("BsdfPrincipled", inputs).outputs[0]

        self.scene.afterimage.samples, self.scene.afterimage.paths = 8, 16
        for build in (holes, smoke, glowing_smoke):
            with self.subTest(build.__name__):
                self.shown_by(build.__name__, build)
                mean, ours, cycles = self.difference(256)
                self.assertLess(mean, 0.02)
                np.testing.assert_allclose(ours[:, :, :3].mean(), cycles[:, :, :3].mean(), rtol=0.02)
                self.assertFalse([said for said in self.exported.warnings if "constant" in said], build.__name__)

    def test_glass_of_a_pattern_and_by_one(self):
        # one sheet: light is tinted once. What is matt is as dark from both sides
        def stained(tree):
            return tree.add("BsdfGlass", {"Color": ramp(tree, noise(tree)[0]), "Roughness": 0.0, "IOR": 1.1}).outputs[0]

        def rooted(tree):
            inputs = {"Base Color": ramp(tree, noise(tree)[0]), "Transmission Weight": 1.0, "Roughness": 0.0, "IOR": 1.1}
            return tree.add("BsdfPrincipled", inputs).outputs[0]

        def weighted(tree):
            wide = tree.add("MapRange", {0: noise(tree)[0], 1: 0.4, 2: 0.6}).outputs[0]
            inputs = {"Base Color": (0.6, 0.2, 0.1, 1), "Transmission Weight": wide, "Roughness": 0.0, "IOR": 1.1}
            return tree.add("BsdfPrincipled", inputs).outputs[0]

        def mixed(tree):
            wide = tree.add("MapRange", {0: noise(tree)[0], 1: 0.4, 2: 0.6}).outputs[0]
            matt = tree.add("BsdfDiffuse", {"Color": (0.4, 0.1, 0.05, 1)}).outputs[0]
            glass = tree.add("BsdfGlass", {"Color": (0.7, 0.8, 0.9, 1), "Roughness": 0.0, "IOR": 1.1}).outputs[0]
            return tree.add("MixShader", {0: wide, 1: matt, 2: glass}).outputs[0]

        self.scene.afterimage.paths = 32
        for build in (stained, rooted, weighted, mixed):
            with self.subTest(build.__name__):
                self.shown_by(build.__name__, build)
                mean, _, _ = self.difference(256)
                self.assertLess(mean, 0.015)
                self.assertFalse([said for said in self.exported.warnings if "constant" in said], build.__name__)

    def test_copies_differ_by_their_numbers(self):
        material, node = principled("Sprinkles", Roughness=1.0, Specular_IOR_Level=0.0)
        tree = Tree(material)
        tree.links.new(ramp(tree, tree.add("ObjectInfo").outputs["Random"], "CONSTANT"), node.inputs["Base Color"])
        small = support.grid("Small", 0.3)
        small.materials.append(material)
        bpy.data.objects.remove(bpy.data.objects["Square"])
        for count in (4, 9):
            with self.subTest(count=count):
                # more than what a shot file lists one by one, and fewer
                places = [(0.4 * x - 1.6, 0.4 * y - 1.6, 0) for x in range(count) for y in range(count)]
                copies = [support.add(self.scene, f"Copy {at}", small, place) for at, place in enumerate(places)]
                mean, _, _ = self.difference()
                # edges of many squares; with other numbers it is 0.13
                self.assertLess(mean, 0.02)
                for copy in copies:
                    bpy.data.objects.remove(copy)

    def test_colour_attributes_take_part(self):
        layer = self.mesh.color_attributes.new("Paint", "FLOAT_COLOR", "CORNER")
        points = np.array([self.mesh.vertices[loop.vertex_index].co[:2] for loop in self.mesh.loops]) / 4 + 0.5
        colors = np.concatenate([points, np.full((len(points), 1), 0.2), np.ones((len(points), 1))], axis=1)
        layer.data.foreach_set("color", colors.astype(np.float32).ravel())

        def build(tree):
            paint = tree.add("VertexColor", layer_name="Paint").outputs[0]
            inverted = tree.add("Invert", {"Color": paint}).outputs[0]
            mix = tree.add("Mix", data_type="RGBA")
            for index, source in ((0, noise(tree)[0]), (6, paint), (7, inverted)):
                tree.links.new(source, mix.inputs[index])
            return mix.outputs[2]

        self.show("Painted", build)
        mean, _, _ = self.difference()
        self.assertLess(mean, 0.008)

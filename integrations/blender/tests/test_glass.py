# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports of glass: what of a material is glass, and which colours it has. Needs bpy; the renderer is not asked."""

import os
import re
import unittest

import bpy
import numpy as np
import support
from test_surfaces import principled

SHADOW = "without Caustics all of it casts a shadow, or nothing where half of it and more is glass"
REFLECTS = "what is matt of it reflects as its glass does"


def image_of(name, texels, colorspace="Non-Color"):
    """An image of texels: (rows, columns, 3), or numbers."""
    texels = np.asarray(texels, dtype=np.float32)
    texels = np.broadcast_to(texels if texels.ndim == 3 else texels[:, :, None], (*texels.shape[:2], 3))
    image = bpy.data.images.new(name, texels.shape[1], texels.shape[0], float_buffer=True)
    image.colorspace_settings.name = colorspace
    image.pixels.foreach_set(np.concatenate([texels, np.ones((*texels.shape[:2], 1))], axis=2).astype(np.float32).ravel())
    return image


def halves(left, right, size=8):
    """Texels of two halves, beside each other."""
    columns = np.arange(size) < size // 2
    return np.where(columns[None, :, None], np.reshape(left, (1, 1, -1)), np.reshape(right, (1, 1, -1))) * np.ones((size, 1, 1))


MASK = halves(0.0, 1.0)[:, :, 0]
PANES = halves((0.8, 0.2, 0.1), (0.1, 0.3, 0.6))


def step_of_noise(tree):
    """1 where a noise is more than a half, else 0."""
    return tree.add("Math", {0: tree.add("TexNoise").outputs[0], 1: 0.5}, operation="GREATER_THAN").outputs[0]


class Glasses(support.ExportCase):
    def setUp(self):
        super().setUp()
        support.add_camera(self.scene)

    def new(self, shader):
        """A material whose surface is what a function makes for its tree."""
        material, _ = principled("Pane")
        tree = support.Tree(material)
        tree.links.new(shader(tree), tree.nodes["Material Output"].inputs["Surface"])
        return material

    def picture(self, tree, texels, colorspace="Non-Color"):
        return tree.add("TexImage", image=image_of("Picture", texels, colorspace)).outputs["Color"]

    def exported(self, material, attribute=None):
        """Exports a square of a material. Returns the keys of it, and what is told of it."""
        mesh = support.grid()
        mesh.uv_layers.new()
        if attribute:
            mesh.color_attributes.new(attribute, "FLOAT_COLOR", "CORNER")
        mesh.materials.append(material)
        support.add(self.scene, "Square", mesh)
        values = self.export()["material"][0]
        lines = [line.removeprefix("material `Pane`: ") for line in self.warnings()]
        return values, sorted(part for line in lines for part in line.split("; "))

    def of_shader(self, shader):
        return self.exported(self.new(shader))

    def texels(self, file):
        return support.read_pixels(os.path.join(self.folder, file))[:, :, :3]

    def assert_picture(self, file, expected, is_color=True):
        """A picture shows these linear colours or numbers, to half a step of a byte, as Blender reads it back as if it was linear."""
        encoded = self.texels(file)
        if is_color:
            encoded = support.extension().export.images.to_linear(encoded)
        np.testing.assert_allclose(encoded, np.broadcast_to(expected if np.ndim(expected) == 3 else expected[:, :, None], encoded.shape)[::-1], atol=0.006)

    def graph(self):
        """The lines of the shader of the file of graphs: its inputs by name, with their types, and constants."""
        with open(os.path.join(self.folder, "materials.mtlx"), encoding="utf-8") as file:
            text = file.read()
        shader = text[text.index("<open_pbr_surface") : text.index("</open_pbr_surface>")]
        found = re.findall(r'<input name="(\w+)" type="\w+" (?:value="([^"]*)"|nodegraph)', shader)
        return {name: [float(part) for part in value.split(",")] if value else "graph" for name, value in found}, text

    def test_stained_glass_has_the_picture_of_its_colour(self):
        values, told = self.of_shader(lambda tree: tree.add("BsdfGlass", {"Color": self.picture(tree, PANES), "Roughness": 0.0, "IOR": 1.4}).outputs[0])
        self.assertEqual([values[key] for key in ("illum", "tf", "kd")], [7, [1, 1, 1], [0, 0, 0]])
        self.assertAlmostEqual(values["ni"], 1.4, places=6)
        np.testing.assert_allclose(values["ks"], PANES.mean(axis=(0, 1)), atol=1e-5)
        self.assertFalse({"map_transmission", "map_kd", "mtlx"} & set(values))
        self.assert_picture(values["map_tf"], PANES)
        self.assertCountEqual(told, ["the colour that it reflects counts by its mean"])

    def test_a_file_of_stained_glass_is_copied(self):
        image = image_of("Window", PANES)
        path = os.path.join(self.scratch.name, "window.png")
        image.filepath_raw, image.file_format = path, "PNG"
        image.save()
        file = bpy.data.images.load(path)
        values, _ = self.of_shader(lambda tree: tree.add("BsdfGlass", {"Color": tree.add("TexImage", image=file).outputs["Color"]}).outputs[0])
        self.assertEqual(values["map_tf"], "textures/window.png")

    def test_principled_glass_lets_the_root_of_its_picture_through(self):
        inputs = {"Transmission Weight": 1.0, "Roughness": 0.2}
        values, told = self.of_shader(lambda tree: tree.add("BsdfPrincipled", {"Base Color": self.picture(tree, PANES), **inputs}).outputs[0])
        self.assertEqual((values["illum"], values["tf"], told), (7, [1, 1, 1], []))
        self.assert_picture(values["map_tf"], np.sqrt(PANES))

    def test_of_two_pictures_of_colour_that_of_the_larger_part_is_kept(self):
        def half(share):
            return lambda tree: tree.add("BsdfPrincipled", {"Base Color": self.picture(tree, PANES), "Transmission Weight": share}).outputs[0]

        values, told = self.of_shader(half(0.25))
        root = np.sqrt(PANES).mean(axis=(0, 1))
        np.testing.assert_allclose(values["tf"], 0.25 * root, atol=1e-4)
        # the renderer scatters `kd` of what `tf` keeps back
        np.testing.assert_allclose(np.array(values["kd"]) * (1 - max(values["tf"])), [0.75] * 3, atol=1e-4)
        self.assert_picture(values["map_kd"], PANES)
        self.assertNotIn("map_tf", values)
        self.assertCountEqual(told, ["the colour of what goes through it counts by its mean"])
        self.scene = support.empty()
        support.add_camera(self.scene)
        values, told = self.of_shader(half(0.75))
        np.testing.assert_allclose(values["tf"], [0.75] * 3, atol=1e-6)
        self.assert_picture(values["map_tf"], np.sqrt(PANES))
        # a factor of the picture
        np.testing.assert_allclose(values["kd"], PANES.mean(axis=(0, 1)) / root, atol=1e-4)
        self.assertNotIn("map_kd", values)
        self.assertCountEqual(told, ["what is matt of it has the pattern of what goes through"])

    def test_transmission_by_a_picture(self):
        inputs = {"Base Color": (1, 0.25, 0.64, 1), "Roughness": 0.1}
        values, told = self.of_shader(lambda tree: tree.add("BsdfPrincipled", {"Transmission Weight": self.picture(tree, MASK), **inputs}).outputs[0])
        self.assertEqual(values["illum"], 7)
        np.testing.assert_allclose(values["tf"], [1, 0.5, 0.8], atol=1e-6)
        np.testing.assert_allclose(values["kd"], [1, 0.25, 0.64], atol=1e-6)
        self.assert_picture(values["map_transmission"], MASK, is_color=False)
        self.assertFalse({"map_tf", "map_kd", "mtlx"} & set(values))
        self.assertCountEqual(told, [SHADOW])

    def test_transmission_by_a_picture_of_a_colour_that_would_be_a_part_of_it(self):
        inputs = {"Base Color": (0.64, 0.16, 0.04, 1), "Roughness": 0.1}
        values, told = self.of_shader(lambda tree: tree.add("BsdfPrincipled", {"Transmission Weight": self.picture(tree, MASK), **inputs}).outputs[0])
        self.assertFalse({"illum", "tf", "transmission", "map_tf", "map_transmission"} & set(values))
        np.testing.assert_allclose(values["kd"], [0.64, 0.16, 0.04], atol=1e-6)
        np.testing.assert_allclose([values["ni"], values["pr"], *values["ks"]], [1.5, 0.1, 1, 1, 1], atol=1e-6)
        shader, text = self.graph()
        self.assertEqual((values["mtlx"], set(shader), shader["transmission_weight"]), ("materials.mtlx", {"transmission_weight", "transmission_color"}, "graph"))
        np.testing.assert_allclose(shader["transmission_color"], [0.8, 0.4, 0.2], atol=1e-6)
        self.assertIn('<image name="n1_in1" type="float">', text)
        self.assertCountEqual(told, [SHADOW])

    def mixed(self, mask, first, second):
        return lambda tree: tree.add("MixShader", {0: mask(tree), 1: first(tree), 2: second(tree)}).outputs[0]

    def test_a_picture_that_mixes_glass_and_plastic(self):
        def plastic(tree):
            return tree.add("BsdfPrincipled", {"Base Color": (0.5, 0.1, 0.05, 1)}).outputs[0]

        def glass(tree):
            return tree.add("BsdfGlass", {"Color": (1, 1, 1, 1), "Roughness": 0.5, "IOR": 1.3}).outputs[0]

        def mask(tree):
            return self.picture(tree, MASK)

        for name, shader, share in (("first", self.mixed(mask, glass, plastic), 1 - MASK), ("second", self.mixed(mask, plastic, glass), MASK)):
            with self.subTest(glass=name):
                self.scene = support.empty()
                support.add_camera(self.scene)
                values, told = self.of_shader(shader)
                self.assertEqual((values["illum"], values["tf"], values["ks"]), (7, [1, 1, 1], [1, 1, 1]))
                np.testing.assert_allclose([values["ni"], *values["kd"]], [1.3, 0.5, 0.1, 0.05], atol=1e-6)
                self.assert_picture(values["map_transmission"], share, is_color=False)
                self.assertFalse({"map_tf", "map_kd", "mtlx"} & set(values))
                self.assertCountEqual(told, [SHADOW])

    def test_a_window_of_panes_and_lead_has_one_picture_of_both(self):
        lead = halves(0.05, 0.3)[:, :, 0].T
        values, told = self.of_shader(
            self.mixed(
                lambda tree: self.picture(tree, MASK),
                lambda tree: tree.add("BsdfDiffuse", {"Color": self.picture(tree, lead)}).outputs[0],
                lambda tree: tree.add("BsdfGlass", {"Color": self.picture(tree, PANES), "Roughness": 0.0}).outputs[0],
            )
        )
        self.assertEqual((values["illum"], values["tf"], values["kd"]), (7, [1, 1, 1], [1, 1, 1]))
        self.assert_picture(values["map_transmission"], MASK, is_color=False)
        self.assert_picture(values["map_tf"], np.where(MASK[:, :, None] > 0, PANES, lead[:, :, None]))
        self.assertCountEqual(told, ["the colour that it reflects counts by its mean", SHADOW, REFLECTS])

    def test_glass_in_part_all_over_keeps_the_colours_of_both(self):
        values, told = self.of_shader(
            self.mixed(
                lambda tree: 0.5,
                lambda tree: tree.add("BsdfDiffuse", {"Color": self.picture(tree, PANES)}).outputs[0],
                lambda tree: tree.add("BsdfGlass", {"Color": (0.2, 0.4, 0.2, 1), "IOR": 1.2}).outputs[0],
            )
        )
        np.testing.assert_allclose([values["ni"], *values["tf"]], [1.2, 0.1, 0.2, 0.1], atol=1e-6)
        np.testing.assert_allclose(np.array(values["kd"]) * 0.8, [0.5] * 3, atol=1e-6)
        self.assert_picture(values["map_kd"], PANES)
        # the half that is glass reflects, in part and totally, in its colour
        np.testing.assert_allclose([values["ks"], values["ks_total"]], [[0.1, 0.2, 0.1]] * 2, atol=1e-6)
        self.assertEqual(told, [])

    def test_computed_colours_and_shares_of_glass(self):
        def tinted(tree):
            return tree.add("BsdfGlass", {"Color": tree.add("TexNoise").outputs["Color"], "Roughness": 0.0}).outputs[0]

        values, told = self.of_shader(tinted)
        shader, _ = self.graph()
        self.assertEqual(shader, {"transmission_weight": [1], "transmission_color": "graph"})
        self.assertEqual((values["kd"], values["pr"], told), ([0, 0, 0], 0, ["the colour that it reflects counts by its mean"]))
        self.assertFalse({"illum", "tf", "transmission"} & set(values))
        self.scene = support.empty()
        support.add_camera(self.scene)
        values, told = self.of_shader(
            self.mixed(
                step_of_noise,
                lambda tree: tree.add("BsdfDiffuse", {"Color": (0.5, 0.2, 0.1, 1)}).outputs[0],
                lambda tree: tree.add("BsdfGlass", {"Color": (0.9, 0.8, 0.7, 1)}).outputs[0],
            )
        )
        shader, _ = self.graph()
        self.assertEqual((set(shader), shader["transmission_weight"]), ({"transmission_weight", "transmission_color"}, "graph"))
        np.testing.assert_allclose(shader["transmission_color"], [0.9, 0.8, 0.7], atol=1e-6)
        np.testing.assert_allclose(values["kd"], [0.5, 0.2, 0.1], atol=1e-6)
        self.assertCountEqual(told, [SHADOW, REFLECTS])

    def test_the_root_of_a_computed_colour_is_computed(self):
        inputs = {"Transmission Weight": 1.0, "Roughness": 0.0}
        values, told = self.of_shader(lambda tree: tree.add("BsdfPrincipled", {"Base Color": tree.add("TexNoise").outputs["Color"], **inputs}).outputs[0])
        shader, text = self.graph()
        self.assertEqual((shader, told), ({"transmission_weight": [1], "transmission_color": "graph"}, []))
        self.assertRegex(text, r'<sqrt name="(\w+)" type="color3">[^§]*<output name="transmission_color" type="color3" nodename="\1"/>')

    def test_a_colour_attribute_that_mixes_glass_and_what_is_matt(self):
        material = self.new(
            self.mixed(
                lambda tree: tree.add("VertexColor", layer_name="Mask").outputs["Color"],
                lambda tree: tree.add("BsdfGlass", {"Color": (0.9, 0.8, 0.7, 1)}).outputs[0],
                lambda tree: tree.add("BsdfDiffuse", {"Color": (0.5, 0.2, 0.1, 1)}).outputs[0],
            )
        )
        values, told = self.exported(material, "Mask")
        shader, text = self.graph()
        # the colour as well: those of vertices would be a factor of one that is not computed
        self.assertEqual((shader, values["kd"]), ({"transmission_weight": "graph", "transmission_color": "graph"}, [1, 1, 1]))
        self.assertIn("<blender_vertex_color", text)
        self.assertCountEqual(told, [SHADOW, REFLECTS, "where it is glass in part, what goes through it and what is matt are of one colour"])

    def test_metal_beside_glass(self):
        def shader(metallic, mask=MASK):
            inputs = {"Base Color": (1, 1, 1, 1), "Transmission Weight": 1.0}
            return lambda tree: tree.add("BsdfPrincipled", {"Metallic": self.picture(tree, mask) if metallic is None else metallic, **inputs}).outputs[0]

        mostly = halves(0.0, 1.0)[:, :, 0]
        mostly[:, :6] = 0
        values, told = self.of_shader(shader(None, mostly))
        self.assert_picture(values["map_transmission"], 1 - mostly, is_color=False)
        self.assertCountEqual(told, [SHADOW, "what is metal beside its glass is matt"])
        self.scene = support.empty()
        support.add_camera(self.scene)
        values, told = self.of_shader(shader(0.75))
        # metal through which something is seen
        self.assertEqual((values["pm"], "tf" in values, told), (1.0, False, ["its glass does not bend light, beside its metal"]))
        self.assertEqual(values["alpha_mode"], "blend")
        self.assert_picture(values["map_d"], np.full((256, 256), 0.75), is_color=False)

    def test_a_mirror_on_glass_by_the_angle_is_the_reflection_of_glass(self):
        values, told = self.of_shader(
            self.mixed(
                lambda tree: tree.add("Fresnel", {"IOR": 1.4}).outputs[0],
                lambda tree: tree.add("BsdfRefraction", {"IOR": 1.4, "Roughness": 0.0}).outputs[0],
                lambda tree: tree.add("BsdfGlossy", {"Color": (0.5, 0.5, 0.5, 1), "Roughness": 0.0}).outputs[0],
            )
        )
        self.assertEqual((values["illum"], values["tf"], values["ks"], told), (7, [1, 1, 1], [0.5, 0.5, 0.5], []))

    def test_holes_in_glass_are_none_of_its_share(self):
        values, told = self.of_shader(
            self.mixed(
                lambda tree: self.picture(tree, MASK),
                lambda tree: tree.add("BsdfTransparent").outputs[0],
                lambda tree: tree.add("BsdfGlass", {"Color": (0.5, 0.8, 0.6, 1)}).outputs[0],
            )
        )
        self.assertEqual((values["illum"], "map_d" in values, "map_transmission" in values, told), (7, True, False, []))
        np.testing.assert_allclose(values["tf"], [0.5, 0.8, 0.6], atol=1e-6)

    def test_glass_of_which_nothing_is_mixed_in_changes_nothing(self):
        def plastic(tree):
            return tree.add("BsdfPrincipled", {"Base Color": (0.5, 0.1, 0.05, 1), "IOR": 1.6}).outputs[0]

        def glass(tree):
            return tree.add("BsdfGlass", {"Color": (0, 1, 0, 1), "IOR": 1.2}).outputs[0]

        for name, shader in (("first", self.mixed(lambda tree: 1.0, glass, plastic)), ("second", self.mixed(lambda tree: 0.0, plastic, glass))):
            with self.subTest(glass=name):
                self.scene = support.empty()
                support.add_camera(self.scene)
                values, told = self.of_shader(shader)
                self.assertEqual(("illum" in values, told), (False, []))
                np.testing.assert_allclose([values["ni"], *values["kd"]], [1.6, 0.5, 0.1, 0.05], atol=1e-4)

    def test_cracks_that_glow_in_glass(self):
        values, told = self.of_shader(
            self.mixed(
                lambda tree: self.picture(tree, MASK),
                lambda tree: tree.add("BsdfGlass", {"Color": (1, 1, 1, 1)}).outputs[0],
                lambda tree: tree.add("Emission", {"Color": (1, 0.5, 0, 1), "Strength": 2.0}).outputs[0],
            )
        )
        self.assertEqual((values["illum"], values["tf"], values["kd"]), (7, [1, 1, 1], [0, 0, 0]))
        self.assertTrue({"map_transmission", "map_ke"} <= set(values))

    def test_the_angle_says_where_it_is_glass(self):
        def edge(tree):
            return tree.add("LayerWeight").outputs["Facing"]

        values, told = self.of_shader(
            self.mixed(edge, lambda tree: tree.add("BsdfGlass").outputs[0], lambda tree: tree.add("BsdfDiffuse", {"Color": (0.2, 0.2, 0.2, 1)}).outputs[0])
        )
        shader, text = self.graph()
        self.assertEqual(shader["transmission_weight"], "graph")
        self.assertIn("<blender_layer_weight", text)

    def test_layers_that_glass_does_not_have_are_told(self):
        inputs = {"Transmission Weight": 1.0, "Coat Weight": 0.5, "Sheen Weight": 0.5, "Subsurface Weight": 1.0}
        _, told = self.of_shader(lambda tree: tree.add("BsdfPrincipled", inputs).outputs[0])
        self.assertCountEqual(told, ["its coat and its sheen are left out: the renderer has none of glass"])

    def test_what_absorbs_has_one_colour_of_its_surface(self):
        material = self.new(lambda tree: tree.add("BsdfGlass", {"Color": self.picture(tree, PANES)}).outputs[0])
        tree = support.Tree(material)
        volume = tree.add("VolumeAbsorption", {"Color": (0.9, 0.5, 0.1, 1)})
        tree.links.new(volume.outputs[0], tree.nodes["Material Output"].inputs["Volume"])
        values, told = self.exported(material)
        np.testing.assert_allclose(values["tf"], PANES.mean(axis=(0, 1)), atol=1e-4)
        self.assertTrue("depth" in values and "map_tf" not in values)
        self.assertCountEqual(told, ["the colour of what goes through it counts by its mean beside what its volume absorbs", "the colour that it reflects counts by its mean"])


if __name__ == "__main__":
    unittest.main()

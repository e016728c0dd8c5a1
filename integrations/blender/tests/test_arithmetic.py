# SPDX-License-Identifier: GPL-3.0-or-later
"""What nodes compute, beside Cycles. Needs bpy with Cycles, and no renderer."""

import os
import tempfile
import types
import unittest

import bpy
import numpy as np
import support

LIFT = 20.0
"""What is added to values, so that Cycles shows negative ones as well."""
PAIRS = (
    ((0.2, 0.6, 0.9), (0.7, 0.3, 0.1)),
    ((0.5, 0.0, 1.0), (0.0, 1.0, 0.4)),
    ((0.3, 0.3, 0.3), (0.9, 0.8, 0.1)),
    ((0.8, 0.45, 0.1), (0.4, 0.4, 0.4)),
)
NUMBERS = ((0.3, 0.8, 0.5), (-1.7, 0.6, 0.25), (2.5, -0.75, 1.5), (0.0, 0.0, 0.0), (1.25, 1.0, 0.2))


class Arithmetic(unittest.TestCase):
    """Each case is a square that emits what nodes compute; Cycles shows all of them in one picture."""

    def setUp(self):
        self.scene = support.empty(engine="CYCLES")
        self.cases = []

    def case(self, kind, what, values, **settings):
        """Adds a node with constants as inputs. `values`: from input numbers to constants."""
        material = bpy.data.materials.new(f"Case {len(self.cases)}")
        material.use_nodes = True
        tree = material.node_tree
        node, lift, shine = (tree.nodes.new(f"ShaderNode{name}") for name in (kind, "MixRGB", "Emission"))
        for name, value in settings.items():
            setattr(node, name, value)
        for index, value in values.items():
            # links, for Blender folds no constants then, and each has its own type
            source = tree.nodes.new("ShaderNodeRGB" if isinstance(value, tuple) else "ShaderNodeValue")
            source.outputs[0].default_value = (*value, 1) if isinstance(value, tuple) else value
            tree.links.new(source.outputs[0], node.inputs[index])
        lift.blend_type = "ADD"
        lift.inputs[0].default_value, lift.inputs[2].default_value = 1, (LIFT, LIFT, LIFT, 1)
        output = next(each for each in node.outputs if each.enabled)
        tree.links.new(output, lift.inputs[1])
        tree.links.new(lift.outputs[0], shine.inputs["Color"])
        tree.links.new(shine.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
        self.cases.append((what, material, node, output))
        return node

    def assert_as_cycles(self, tolerance=2e-4):
        """All cases are what Cycles shows."""
        nodes = support.extension().export.nodes
        side = int(np.ceil(np.sqrt(len(self.cases))))
        mesh = support.grid("Squares", side, side)
        for index, (_, material, _, _) in enumerate(self.cases):
            mesh.materials.append(material)
        mesh.polygons.foreach_set("material_index", np.minimum(np.arange(side * side), len(self.cases) - 1).astype(np.int32))
        support.add(self.scene, "Squares", mesh)
        support.add_camera(self.scene, (0, 0, 5), (0, 0, 0), type="ORTHO", ortho_scale=side)
        self.scene.render.resolution_x = self.scene.render.resolution_y = side * 5
        self.scene.cycles.samples, self.scene.cycles.use_denoising, self.scene.cycles.filter_width = 1, False, 0.01
        with tempfile.TemporaryDirectory() as folder:
            picture = support.render(self.scene, os.path.join(folder, "cases.exr"))[::-1]
        for index, (what, _, node, output) in enumerate(self.cases):
            evaluator = nodes.Evaluator(types.SimpleNamespace())
            found = nodes.color(evaluator.output(node, output))[0, 0]
            shown = picture[index // side * 5 + 2, index % side * 5 + 2, :3] - LIFT
            np.testing.assert_allclose(found, shown, rtol=tolerance, atol=1e-4, err_msg=what)
            self.assertEqual(evaluator.said, [], what)

    def test_blends_of_colours(self):
        for blend in [each.identifier for each in bpy.types.ShaderNodeMixRGB.bl_rna.properties["blend_type"].enum_items]:
            for factor in (0.0, 0.4, 1.0):
                for one, other in PAIRS:
                    values = {0: factor, 1: one, 2: other}
                    self.case("MixRGB", f"{blend} {values}", values, blend_type=blend)
                    self.case("Mix", f"{blend} {values}", {0: factor, 6: one, 7: other}, data_type="RGBA", blend_type=blend)
        self.assert_as_cycles()

    def test_operations_of_numbers(self):
        for operation in [each.identifier for each in bpy.types.ShaderNodeMath.bl_rna.properties["operation"].enum_items]:
            for values in NUMBERS:
                self.case("Math", f"{operation} {values}", dict(enumerate(values)), operation=operation)
        self.assert_as_cycles()

    def test_operations_of_vectors(self):
        vectors = ((0.3, 0.8, 0.5), (-1.7, 0.6, 0.25), (2.5, -0.75, 1.5))
        for operation in [each.identifier for each in bpy.types.ShaderNodeVectorMath.bl_rna.properties["operation"].enum_items]:
            for turn in range(3):
                values = {index: vectors[(index + turn) % 3] for index in range(3)} | {3: 0.7}
                self.case("VectorMath", f"{operation} {values}", values, operation=operation)
        nothing = {0: (0.0, 0.0, 0.0), 1: (0.0, 0.0, 0.0)}
        for operation in ("DIVIDE", "NORMALIZE", "PROJECT", "SNAP", "MODULO", "WRAP"):
            self.case("VectorMath", f"{operation} of nothing", nothing, operation=operation)
        self.assert_as_cycles()

    def test_hue_and_saturation(self):
        for hue, saturation, value, factor in ((0.5, 1.0, 1.0, 1.0), (0.3, 1.6, 0.7, 1.0), (0.9, 0.4, 2.0, 0.5), (0.5, 0.0, 1.0, 1.0)):
            for color in {color for pair in PAIRS for color in pair}:
                values = {0: hue, 1: saturation, 2: value, 3: factor, 4: color}
                self.case("HueSaturation", f"hue and saturation {values}", values)
        self.assert_as_cycles()

    def test_what_depends_on_the_eye_is_what_it_is_at_45_degrees(self):
        cases = [("Fresnel", "IOR", 0, 1.45), ("Fresnel", "IOR", 0, 2.2), ("Fresnel", "IOR", 0, 0.6), ("LayerWeight", "Blend", 0, 0.3)]
        cases += [("LayerWeight", "Blend", 1, blend) for blend in (0.0, 0.3, 0.5, 0.8)]
        for kind, name, output, value in cases:
            with self.subTest(kind, output=output, value=value):
                self.scene, self.cases = support.empty(engine="CYCLES"), []
                node = self.case(kind, kind, {name: value})
                tree = node.id_data
                tree.links.new(node.outputs[output], next(each for each in tree.nodes if each.type == "MIX_RGB").inputs[1])
                self.assert_as_aslant(node, output)

    def test_normals_that_are_turned_towards_the_eye(self):
        for kind, output in (("Fresnel", 0), ("LayerWeight", 0), ("LayerWeight", 1)):
            with self.subTest(kind, output=output):
                self.scene, self.cases = support.empty(engine="CYCLES"), []
                node = self.case(kind, kind, {})
                tree = support.Tree(self.cases[0][1])
                geometry = tree.add("NewGeometry").outputs
                mixed = tree.add("Mix", {0: 0.3, 6: geometry["Normal"], 7: geometry["Incoming"]}, data_type="RGBA").outputs[2]
                tree.links.new(mixed, node.inputs["Normal"])
                tree.links.new(node.outputs[output], next(each for each in tree.nodes if each.type == "MIX_RGB").inputs[1])
                self.assert_as_aslant(node, output)

    def assert_as_aslant(self, node, output):
        """The first case's material shows on a surface that is seen at 45 degrees what the evaluator says of a node's output."""
        support.add(self.scene, "Aslant", support.grid("Aslant", 20), turn=(np.pi / 4, 0, 0)).data.materials.append(self.cases[0][1])
        support.add_camera(self.scene, (0, 0, 9), (0, 0, 0), type="ORTHO", ortho_scale=2)
        self.scene.cycles.samples, self.scene.cycles.use_denoising = 1, False
        with tempfile.TemporaryDirectory() as folder:
            shown = support.render(self.scene, os.path.join(folder, "case.exr"))[24, 32, 0] - LIFT
        evaluator = support.extension().export.nodes.Evaluator(types.SimpleNamespace())
        np.testing.assert_allclose(evaluator.output(node, node.outputs[output])[0, 0, 0], shown, atol=1e-4)
        self.assertEqual(len(evaluator.said), 1)

    def test_curves(self):
        for factor in (0.5, 1.0):
            for color in {color for pair in PAIRS for color in pair} | {(1.6, 0.5, 3.0)}:
                node = self.case("RGBCurve", f"curves {factor} {color}", {0: factor, 1: color})
                for index, (x, y) in enumerate(((0.3, 0.6), (0.5, 0.5), (0.6, 0.2), (0.4, 0.5))):
                    node.mapping.curves[index].points.new(x, y)
                node.mapping.update()
        self.assert_as_cycles(0.02)


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair that moves and deforms: is it one thing that goes from frame to frame, and where it is in Blender?"""

import os

import bpy
import numpy as np
import support


class Hair(support.ExportCase):
    def setUp(self):
        super().setUp()
        self.scene.frame_end = 3
        support.add_camera(self.scene)

    def models(self):
        return self.export()["model"]

    def points(self, name):
        return np.load(os.path.join(self.folder, name))

    def emitter(self, count=20):
        """A square on which hair grows."""
        item = support.add(self.scene, "Emitter", support.grid(count=3))
        settings = item.modifiers.new("Hair", "PARTICLE_SYSTEM").particle_system.settings
        settings.type, settings.count, settings.hair_length, settings.render_step = "HAIR", count, 0.5, 2
        return item

    def hairs_of(self, models):
        return [model for model in models if "curves" in model]

    def test_hair_that_its_emitter_carries_is_one_thing_that_moves(self):
        item = self.emitter()
        for frame, x in ((1, 0.0), (3, 40.0)):
            item.location.x, item.rotation_euler.z = x, 0.1 * x
            item.keyframe_insert("location", frame=frame)
            item.keyframe_insert("rotation_euler", frame=frame)
        (hair,) = self.hairs_of(self.models())
        self.assertNotIn("shapes", hair)
        self.assertEqual(len(hair["key"]), 3)

    def test_hair_deforms_with_its_emitter(self):
        item = self.emitter()
        item.shape_key_add(name="Basis")
        key = item.shape_key_add(name="Up")
        for point in key.data:
            point.co.z += 1.0 + point.co.x
        for frame, value in ((1, 0.0), (3, 1.0)):
            key.value = value
            key.keyframe_insert("value", frame=frame)
        (hair,) = self.hairs_of(self.models())
        self.assertEqual((hair["shapes"]["first"], hair["shapes"]["every"]), (1, 1))
        shapes = [self.points(hair["shapes"]["curves"].replace("######", f"{number:06}")) for number in range(3)]
        np.testing.assert_array_equal(shapes[0], self.points(hair["curves"]["file"]))
        rise = [(shape[:, 2] - shapes[0][:, 2]).mean() for shape in shapes]
        # hairs turn with their faces, so that they do not go straight
        self.assertAlmostEqual(rise[1], rise[2] / 2, delta=0.05)
        self.assertGreater(rise[2], 0.5)

    def test_hair_curves_that_a_modifier_moves_deform(self):
        data = bpy.data.hair_curves.new("Tuft")
        data.add_curves([4, 4])
        places = np.array([[[x, 0, z] for z in np.linspace(0, 1, 4)] for x in (0, 1)], dtype=np.float32)
        data.position_data.foreach_set("vector", places.ravel())
        item = support.add(self.scene, "Tuft", data)
        nodes = bpy.data.node_groups.new("Lift", "GeometryNodeTree")
        for in_out in ("INPUT", "OUTPUT"):
            nodes.interface.new_socket("Geometry", in_out=in_out, socket_type="NodeSocketGeometry")
        begin, end = nodes.nodes.new("NodeGroupInput"), nodes.nodes.new("NodeGroupOutput")
        move = nodes.nodes.new("GeometryNodeSetPosition")
        nodes.links.new(begin.outputs[0], move.inputs["Geometry"])
        nodes.links.new(move.outputs[0], end.inputs[0])
        for frame, x in ((1, 0.0), (3, 1.0)):
            move.inputs["Offset"].default_value = (x, 0, 0)
            move.inputs["Offset"].keyframe_insert("default_value", frame=frame)
        item.modifiers.new("Lift", "NODES").node_group = nodes
        (hair,) = self.hairs_of(self.models())
        last = self.points(hair["shapes"]["curves"].replace("######", "000002"))
        np.testing.assert_allclose(last[:, 0] - places.reshape(-1, 3)[:, 0], 1, atol=1e-5)

    def test_hair_that_becomes_more_is_another_model(self):
        item = self.emitter()
        settings = item.particle_systems[0].settings
        settings.child_type, settings.rendered_child_count = "SIMPLE", 2
        for frame, count in ((1, 2), (3, 4)):
            settings.rendered_child_count = count
            settings.keyframe_insert("rendered_child_count", frame=frame)
        hairs = self.hairs_of(self.models())
        self.assertGreater(len({hair["curves"]["file"] for hair in hairs}), 1)

# SPDX-License-Identifier: GPL-3.0-or-later
"""Render jobs, with a renderer that shows which shot and frame it was asked for. Needs bpy alone."""

import builtins
import os
import tempfile
import tomllib
import types
import unittest

import bpy
import numpy as np
import support


class FakeRenderer(unittest.TestCase):
    """A scene with a camera and a floor, and a renderer that notes shots and frames."""

    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.scene = support.empty(16, 12)
        self.camera = support.add_camera(self.scene)
        self.floor = support.add(self.scene, "Floor", support.grid())
        self.session = support.extension().session
        self.kept = self.session.renderer
        self.shots, self.frames, self.files, self.ranges, self.asked = [], [], [], [], []
        self.session.renderer = lambda: types.SimpleNamespace(load=self.load, render=self.render)

    def tearDown(self):
        self.session.renderer = self.kept
        self.session.end()
        self.scratch.cleanup()

    def load(self, path):
        with open(path, "rb") as file:
            self.shots.append(tomllib.load(file))
        self.files += [name for _, _, names in os.walk(os.path.dirname(path)) for name in names]
        return self.shots[-1]

    def render(self, shot, frames, **more):
        """Pictures as red as the eye is far to the right of 4 units to the left, at its first key."""
        self.ranges.append(frames)
        self.asked.append(list(frames))
        width, height = more["crop"][2:] if "crop" in more else shot["render"]["size"]
        for number in frames:
            self.frames.append((number, shot["camera"]["projection"]))
            pixels = np.ones((height, width, 4), dtype=np.float32)
            pixels[:, :, 0] = shot["camera"]["key"][0]["eye"][0] + 4
            yield types.SimpleNamespace(number=number, layers={"RGBA": pixels, "N": pixels[:, :, :3]}, stats={}, seconds=0.0)


class Jobs(FakeRenderer):
    def eyes(self):
        """How far to the right each eye is, by the middle of its picture. Radiance: Blender 4 does not read its own OpenEXR files of one eye."""
        render = self.scene.render
        render.use_multiview = True
        render.image_settings.file_format, render.image_settings.views_format = "HDR", "INDIVIDUAL"
        render.filepath = os.path.join(self.scratch.name, "eye.hdr")
        bpy.ops.render.render(write_still=True)
        return [support.read_pixels(os.path.join(self.scratch.name, f"eye_{side}.hdr"))[6, 8, 0] - 4 for side in "LR"]

    def test_both_eyes_have_pictures(self):
        stereo = self.camera.data.stereo
        stereo.convergence_mode, stereo.pivot, stereo.interocular_distance, stereo.convergence_distance = "OFFAXIS", "CENTER", 0.5, 4
        np.testing.assert_allclose(self.eyes(), [-0.25, 0.25], atol=0.05)
        # off axis: both see the same at the distance at which they converge
        shift = 0.25 * self.camera.data.lens / self.camera.data.sensor_width / 4
        np.testing.assert_allclose([shot["camera"]["key"][0]["shift"][0] for shot in self.shots], [shift, -shift], atol=1e-5)

    def test_each_eye_is_exported_once_for_all_frames(self):
        self.scene.frame_end = 3
        self.scene.render.use_multiview = True
        # a warning of both is told once: of dots that are left out
        support.add(self.scene, "Dots", bpy.data.pointclouds.new("Dots"))
        told, print_of = [], builtins.print
        builtins.print = lambda *values, **more: told.append(values)
        self.scene.render.filepath = os.path.join(self.scratch.name, "f.####")
        try:
            bpy.ops.render.render(animation=True)
        finally:
            builtins.print = print_of
        self.assertEqual([shot["render"]["frames"] for shot in self.shots], ["1-3", "1-3"])
        self.assertEqual([number for number, _ in self.frames], [1, 1, 2, 2, 3, 3])
        self.assertEqual(len([values for values in told if "`Dots`" in str(values)]), 1)

    def test_views_of_two_cameras_are_theirs(self):
        self.scene.render.views_format = "MULTIVIEW"
        for suffix, x in (("_L", -2.0), ("_R", 3.0)):
            camera = support.add(self.scene, f"Camera{suffix}", self.camera.data, (x, -5, 0), (np.pi / 2, 0, 0))
            self.scene.camera = self.scene.camera if suffix == "_R" else camera
        np.testing.assert_allclose(self.eyes(), [-2, 3], atol=0.05)

    def test_an_export_of_two_eyes_is_told(self):
        self.scene.render.use_multiview = True
        bpy.ops.afterimage.export_shot(directory=self.scratch.name)
        self.assertIn("stereoscopy", "\n".join(self.session.exported.warnings))

    def test_cameras_of_both_projections_have_shots_of_their_own(self):
        self.scene.frame_end = 6
        flat = support.add(self.scene, "Flat", bpy.data.cameras.new("Flat"), (1, -5, 0), (np.pi / 2, 0, 0))
        flat.data.type = "ORTHO"
        for frame, camera in ((1, self.camera), (3, flat), (5, self.camera)):
            self.scene.timeline_markers.new(f"cut {frame}", frame=frame).camera = camera
        # exposures before the first frame of each must not see by the camera before
        self.scene.render.use_motion_blur = True
        self.scene.render.filepath = os.path.join(self.scratch.name, "f.####")
        bpy.ops.render.render(animation=True)
        kinds = ["perspective"] * 2 + ["orthographic"] * 2 + ["perspective"] * 2
        self.assertEqual(self.frames, list(zip(range(1, 7), kinds)))
        self.assertEqual([shot["render"]["frames"] for shot in self.shots], ["1-2", "3-4", "5-6"])
        for shot in self.shots:
            self.assertFalse([key for key in shot["camera"]["key"] if key.get("cut")])
            size = "height" if shot["camera"]["projection"] == "orthographic" else "fov"
            self.assertTrue(all(size in key for key in shot["camera"]["key"]))

    def test_every_second_frame_is_made_of_the_one_before_it(self):
        self.scene.frame_start, self.scene.frame_end, self.scene.frame_step = 3, 8, 2
        self.scene.render.filepath = os.path.join(self.scratch.name, "f.####")
        bpy.ops.render.render(animation=True)
        self.assertEqual([shot["render"]["frames"] for shot in self.shots], ["3-7x2"])
        self.assertEqual(self.ranges, [range(3, 8, 2)])

    def test_each_view_layer_is_exported_once_for_all_frames(self):
        self.scene.frame_end = 3
        self.scene.view_layers.new("Other").use_sky = False
        for is_kept in (False, True):
            with self.subTest(is_kept=is_kept):
                self.scene.render.use_persistent_data = is_kept
                self.shots.clear()
                self.scene.render.filepath = os.path.join(self.scratch.name, "f.####")
                bpy.ops.render.render(animation=True)
                self.assertEqual([shot["render"]["frames"] for shot in self.shots], ["1-3", "1-3"])

    def test_view_layers_that_show_the_same_are_one_render_with_the_passes_of_all(self):
        self.scene.frame_end = 3
        first, other = self.scene.view_layers[0], self.scene.view_layers.new("Other")
        first.use_pass_z = first.use_pass_normal = False
        other.use_pass_normal = True
        self.scene.render.filepath = os.path.join(self.scratch.name, "f.####")
        bpy.ops.render.render(animation=True)
        self.assertEqual(len(self.shots), 1)
        self.assertIn("N", self.shots[0]["output"]["layers"])
        self.assertEqual([number for number, _ in self.frames], [1, 2, 3])

    def test_view_layers_that_show_other_things_are_renders_of_their_own(self):
        other = self.scene.view_layers.new("Other")
        collection = bpy.data.collections.new("Props")
        self.scene.collection.children.link(collection)

        def count():
            self.shots.clear()
            bpy.ops.render.render()
            return len(self.shots)

        self.assertEqual(count(), 1)
        of_other = other.layer_collection.children["Props"]
        for flag in ("holdout", "indirect_only", "exclude"):
            with self.subTest(flag=flag):
                setattr(of_other, flag, True)
                self.assertEqual(count(), 2)
                setattr(of_other, flag, False)
        other.material_override = bpy.data.materials.new("Clay")
        self.assertEqual(count(), 2)
        other.material_override, other.samples = None, 7
        self.assertEqual(count(), 2)

    def test_a_view_layer_that_is_rendered_alone_has_its_own_passes_alone(self):
        self.scene.view_layers.new("Other").use_pass_normal = True
        self.scene.view_layers[0].use_pass_normal = False
        self.scene.render.use_single_layer = True
        bpy.ops.render.render()
        self.assertNotIn("N", self.shots[0]["output"].get("layers", []))

    def animate(self, holder, path, *values):
        """Gives a property a value in each frame, without passage from one to the next."""
        self.scene.frame_end = len(values)
        for frame, value in enumerate(values, 1):
            setattr(holder, path, value)
            holder.keyframe_insert(path, frame=frame)

    def rendered(self):
        """Renders the animation. Returns the frames of each shot, and what was told."""
        self.scene.render.filepath = os.path.join(self.scratch.name, "f.####")
        told, print_of = [], builtins.print
        builtins.print = lambda *values, **more: told.append(str(values[0]))
        try:
            bpy.ops.render.render(animation=True)
        finally:
            builtins.print = print_of
        self.assertEqual([number for number, _ in self.frames], list(range(1, self.scene.frame_end + 1)))
        return [shot["render"]["frames"] for shot in self.shots], [line for line in told if "animated" in line]

    def glow(self):
        """Gives the floor a material that emits. Returns the socket of its strength."""
        material = bpy.data.materials.new("Glow")
        material.use_nodes = True
        self.floor.data.materials.append(material)
        shader = material.node_tree.nodes["Principled BSDF"]
        shader.inputs["Emission Color"].default_value = (1, 1, 1, 1)
        return shader.inputs["Emission Strength"]

    def test_a_material_that_changes_is_in_each_frame_what_it_is_there(self):
        self.animate(self.glow(), "default_value", 1.0, 1.0, 2.0, 3.0, 3.0)
        frames, told = self.rendered()
        self.assertEqual(frames, ["1-2", "3", "4-5"])
        self.assertEqual([shot["material"][0]["ke"] for shot in self.shots], [[1, 1, 1], [2, 2, 2], [3, 3, 3]])
        self.assertEqual(told, ["Afterimage: material `Glow` is animated: frames in which it changes reuse nothing of those before"])

    def test_a_material_that_becomes_clear_to_some_rays_is_a_change(self):
        self.glow()
        tree = self.floor.data.materials[0].node_tree
        path, share, turned = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("LightPath", "Math", "Math"))
        share.operation, turned.operation, turned.inputs[0].default_value = "MULTIPLY", "SUBTRACT", 1.0
        for output, socket in ((path.outputs["Is Camera Ray"], share.inputs[0]), (share.outputs[0], turned.inputs[1])):
            tree.links.new(output, socket)
        tree.links.new(turned.outputs[0], tree.nodes["Principled BSDF"].inputs["Alpha"])
        self.animate(share.inputs[1], "default_value", 0.0, 0.0, 1.0)
        self.assertEqual(self.rendered()[0], ["1-2", "3"])
        self.assertEqual([shot["model"][0].get("hidden_from") for shot in self.shots], [None, ["camera"]])

    def test_what_is_replaced_by_a_constant_is_no_change(self):
        self.animate(self.glow(), "default_value", 1.0, 1.0, 1.0, 1.0)
        tree = self.floor.data.materials[0].node_tree
        noise, shader = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes["Principled BSDF"]
        noise.noise_dimensions = "4D"
        # which has a constant in place of a graph
        tree.links.new(noise.outputs[0], shader.inputs["Coat Weight"])
        self.animate(noise.inputs["W"], "default_value", 0.0, 1.0, 2.0, 3.0)
        self.animate(tree.nodes.new("ShaderNodeValue").outputs[0], "default_value", 0.0, 1.0, 2.0, 3.0)
        self.assertEqual(self.rendered(), (["1-4"], []))

    def test_pictures_that_move_or_are_mixed_anew_are_changes(self):
        self.floor.data.uv_layers.new()
        self.glow()
        tree = self.floor.data.materials[0].node_tree
        source, mapping, place, bright = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexImage", "Mapping", "TexCoord", "Gamma"))
        source.image = bpy.data.images.new("Picture", 4, 4)
        source.image.pixels.foreach_set(np.linspace(0, 1, 64, dtype=np.float32))
        links = ((place.outputs["UV"], mapping.inputs["Vector"]), (mapping.outputs[0], source.inputs["Vector"]), (source.outputs[0], bright.inputs[0]))
        for output, socket in (*links, (bright.outputs[0], tree.nodes["Principled BSDF"].inputs["Base Color"])):
            tree.links.new(output, socket)
        self.animate(mapping.inputs["Location"], "default_value", (0, 0, 0), (0, 0, 0), (0.5, 0, 0), (0.5, 0, 0))
        self.animate(bright.inputs["Gamma"], "default_value", 1.0, 1.0, 1.0, 2.0)
        self.assertEqual(self.rendered()[0], ["1-2", "3", "4"])

    def test_materials_that_are_held_stay_as_they_are_in_the_first_frame(self):
        self.scene.afterimage.hold = True
        self.animate(self.glow(), "default_value", 1.0, 2.0, 3.0)
        frames, told = self.rendered()
        self.assertEqual((frames, self.shots[0]["material"][0]["ke"]), (["1-3"], [1, 1, 1]))
        self.assertEqual(told, ["Afterimage: material `Glow` is animated: frame 1 is shown"])

    def test_a_material_that_changes_under_motion_blur_is_what_it_is_at_the_frame_itself(self):
        self.scene.render.use_motion_blur = True
        self.scene.render.motion_blur_position, self.scene.render.motion_blur_shutter = "CENTER", 1.0
        self.animate(self.glow(), "default_value", 1.0, 1.0, 2.0, 4.0)
        self.animate(self.camera, "location", (0, -5, 0), (1, -5, 0), (2, -5, 0), (3, -5, 0))
        frames, _ = self.rendered()
        self.assertEqual(frames, ["1-2", "3", "4"])
        self.assertEqual([shot["material"][0]["ke"][0] for shot in self.shots], [1, 2, 4])
        # and what moves is known for as long as the shutter is open
        times = [[key["frame"] for key in shot["camera"]["key"]] for shot in self.shots]
        self.assertEqual([(each[0], each[-1]) for each in times], [(0.5, 2.5), (2.5, 3.5), (3.5, 4.5)])

    def test_the_shutter_has_its_position_and_curve(self):
        render = self.scene.render
        render.use_motion_blur, render.motion_blur_shutter = True, 0.5

        def shutter():
            self.shots.clear()
            self.frames.clear()
            self.rendered()
            return self.shots[0]["shutter"]

        for position, times in (("START", [0.0, 0.5]), ("CENTER", [-0.25, 0.25]), ("END", [-0.5, 0.0])):
            render.motion_blur_position = position
            self.assertEqual(shutter(), {"open": times[0], "close": times[1]})
        mapping = render.motion_blur_shutter_curve
        for point, openness in zip(mapping.curves[0].points, (0, 1, 0)):
            point.location[1], point.handle_type = openness, "VECTOR"
        mapping.update()
        curve = np.array(shutter()["curve"])
        np.testing.assert_allclose(curve[:, 1], 1 - np.abs(2 * curve[:, 0] - 1), atol=1e-3)
        self.assertEqual((curve[0, 0], curve[-1, 0]), (0, 1))

    def test_a_world_that_changes_is_in_each_frame_what_it_is_there(self):
        self.scene.world = bpy.data.worlds.new("Dusk")
        self.scene.world.use_nodes = True
        self.animate(self.scene.world.node_tree.nodes["Background"].inputs["Color"], "default_value", (0, 0, 1, 1), (1, 0, 0, 1))
        frames, _ = self.rendered()
        self.assertEqual(frames, ["1", "2"])
        self.assertEqual([shot["background"]["color"] for shot in self.shots], [[0, 0, 1], [1, 0, 0]])

    def test_a_mesh_that_deforms_goes_on_where_a_material_changes(self):
        self.animate(self.glow(), "default_value", 1.0, 1.0, 2.0)
        self.floor.modifiers.new("Wave", "WAVE").speed = 1.0
        frames, _ = self.rendered()
        self.assertEqual(frames, ["1-2", "3"])
        self.assertEqual(["shapes" in shot["model"][0] for shot in self.shots], [True, False])
        self.assertEqual([name for name in self.files if name.endswith(".part")], [])

    def test_cameras_of_both_projections_in_one_export_are_told(self):
        self.scene.frame_end = 2
        flat = support.add(self.scene, "Flat", bpy.data.cameras.new("Flat"))
        flat.data.type = "ORTHO"
        for frame, camera in ((1, self.camera), (2, flat)):
            self.scene.timeline_markers.new(f"cut {frame}", frame=frame).camera = camera
        bpy.ops.afterimage.export_shot(directory=self.scratch.name)
        self.assertIn("perspective and orthographic cameras in one shot", "\n".join(self.session.exported.warnings))


if __name__ == "__main__":
    unittest.main()

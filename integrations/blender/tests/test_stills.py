# SPDX-License-Identifier: GPL-3.0-or-later
"""Stills that a script renders frame by frame: which share a shot, with a renderer that notes what it was asked for. Needs bpy alone."""

import os
import types
import unittest

import bpy
import numpy as np
import support
import test_jobs


class Stills(test_jobs.FakeRenderer):
    def setUp(self):
        super().setUp()
        self.scene.frame_end = 40
        self.floor.data.vertices[0].co.z = 0.5
        self.move(self.camera, (-1, -5, 0), (1, -5, 0))

    def move(self, item, *places):
        """Lets an object go from place to place in ten frames each."""
        for index, place in enumerate(places):
            item.location = place
            item.keyframe_insert("location", frame=1 + 10 * index)

    def still(self, frame):
        """Renders a frame as scripts do."""
        self.scene.frame_set(frame)
        self.scene.render.filepath = os.path.join(self.scratch.name, "still.png")
        bpy.ops.render.render(write_still=True)

    def stills(self, *frames):
        """Renders frames. Returns the frames of each shot that was exported for them."""
        for frame in frames:
            self.still(frame)
        self.assertEqual([number for number, _ in self.frames], list(frames))
        return [shot["render"]["frames"] for shot in self.shots]

    def test_stills_in_a_row_go_on_from_the_first_one(self):
        self.assertEqual(self.stills(*range(1, 25)), ["1-16", "17-40"])
        # the renderer was asked for all frames of a shot at once, and went on from one to the next
        self.assertEqual(self.asked, [list(range(1, 17)), list(range(17, 41))])

    def animation(self, first, last):
        """Renders an animation, of which nothing is counted."""
        frames = self.scene.frame_start, self.scene.frame_end
        self.scene.frame_start, self.scene.frame_end = first, last
        self.scene.render.filepath = os.path.join(self.scratch.name, "f.####")
        try:
            bpy.ops.render.render(animation=True)
        except RuntimeError:
            pass  # one that fails
        self.scene.frame_start, self.scene.frame_end = frames
        self.shots.clear()
        self.frames.clear()

    def test_stills_after_an_animation_go_on_where_persistent_data_keeps_the_engine(self):
        self.scene.render.use_persistent_data = True
        self.animation(1, 3)
        self.assertEqual(self.stills(1, 2, 3, 4, 5), ["1-16"])

    def test_stills_after_an_animation_that_fails_go_on_as_well(self):
        self.scene.render.use_persistent_data = True
        kept, self.session.renderer = self.session.renderer, lambda: 1 / 0
        self.animation(1, 3)
        self.session.renderer = kept
        self.assertEqual(self.stills(1, 2, 3, 4, 5), ["1-16"])

    def test_in_a_window_it_takes_three_stills_in_a_row(self):
        stills = support.extension().stills
        kept, stills.bpy = stills.bpy, types.SimpleNamespace(app=types.SimpleNamespace(background=False, handlers=bpy.app.handlers))
        try:
            self.assertEqual(self.stills(1, 2, 3, 4, 5), ["1", "2", "3-18"])
        finally:
            stills.bpy = kept

    def test_stills_in_steps_go_on_as_well(self):
        self.scene.frame_end = 12
        self.assertEqual(self.stills(1, 3, 5, 7, 9), ["1-12", "3-11x2"])

    def test_stills_here_and_there_are_exported_by_themselves(self):
        self.assertEqual(self.stills(1, 2, 9, 5, 6, 6, 5, 4), ["1-16", "9", "5", "6", "6", "5", "4"])

    def test_a_still_again_is_exported_again(self):
        self.assertEqual(self.stills(1, 2, 3, 4, 4, 5), ["1-16", "4", "5"])

    def test_what_deforms_and_motion_blur_go_on_as_well(self):
        self.scene.render.use_motion_blur = True
        self.floor.modifiers.new("Wave", "WAVE")
        self.scene.frame_end = 5
        self.assertEqual(self.stills(1, 2, 3, 4, 5), ["1-5"])

    def test_copies_go_on_from_the_second_one(self):
        for index in range(1000):
            self.move(support.add(self.scene, f"Copy {index}", self.floor.data), (index, 0, 0), (index, 1, 0))
        self.scene.frame_end = 6
        self.assertEqual(self.stills(1, 2, 3, 4, 5, 6), ["1", "2-6"])

    def test_the_first_still_of_what_rests_is_exported_by_itself(self):
        bpy.data.batch_remove(bpy.data.actions)
        self.assertEqual(self.stills(1, 2, 3, 4), ["1", "2-17"])

    def test_handlers_of_frames_are_not_called_out_of_order(self):
        called = []
        bpy.app.handlers.frame_change_post.append(lambda scene, graph: called.append(scene.frame_current))
        try:
            self.assertEqual(self.stills(1, 2, 3, 4), ["1", "2", "3", "4"])
        finally:
            bpy.app.handlers.frame_change_post.pop()
        self.assertEqual(sorted(set(called)), [1, 2, 3, 4])

    def test_what_is_never_reused_is_exported_by_itself(self):
        self.scene.afterimage.mode = "full"
        self.assertEqual(self.stills(1, 2, 3, 4), ["1", "2", "3", "4"])

    def changes(self):
        """What a script may change from still to still, by a name: each a function."""
        scene, floor = self.scene, self.floor
        material = bpy.data.materials.new("Matt")
        material.use_nodes = True
        floor.data.materials.append(material)
        other = bpy.data.materials.new("Other")
        shader = material.node_tree.nodes["Principled BSDF"]
        picture = material.node_tree.nodes.new("ShaderNodeTexImage")
        picture.image = bpy.data.images.new("Picture", 4, 4)
        picture.image.pack()
        material.node_tree.links.new(picture.outputs[0], shader.inputs["Base Color"])
        lamp = support.add(scene, "Lamp", bpy.data.lights.new("Lamp", "POINT"))
        scene.world = bpy.data.worlds.new("World")
        scene.world.use_nodes = True
        sky = scene.world.node_tree.nodes["Background"]
        floor.data.uv_layers.new()
        points = floor.data.vertices

        def paint():
            picture.image.pixels.foreach_set(np.full(64, 0.25, dtype=np.float32))

        return {
            "place": lambda: setattr(floor, "location", (1, 0, 0)),
            "vertex": lambda: setattr(points[0], "co", (5, 5, 5)),
            "coordinates": lambda: setattr(floor.data.uv_layers[0].data[0], "uv", (0.7, 0.7)),
            "smoothness": lambda: floor.data.shade_flat(),
            "value": lambda: setattr(shader.inputs["Roughness"], "default_value", 0.1),
            "pixels": paint,
            "link": lambda: material.node_tree.links.clear(),
            "slot": lambda: floor.data.materials.__setitem__(0, other),
            "name": lambda: setattr(floor, "name", "Ground"),
            "lamp": lambda: setattr(lamp.data, "energy", 500),
            "size": lambda: setattr(lamp.data, "shadow_soft_size", 0.7),
            "world": lambda: setattr(sky.inputs["Color"], "default_value", (0.5, 0, 0, 1)),
            "rays": lambda: setattr(scene.world.cycles_visibility, "camera", False),
            "visibility": lambda: setattr(lamp, "hide_render", True),
            "shadow": lambda: setattr(floor, "visible_shadow", False),
            "hole": lambda: setattr(floor, "is_holdout", True),
            "lens": lambda: setattr(self.camera.data, "lens", 20),
            "object": lambda: support.add(scene, "New", floor.data, (0, 0, 1)),
            "setting": lambda: setattr(scene.afterimage, "samples", 5),
            "resolution": lambda: setattr(scene.render, "resolution_x", 20),
            "pass": lambda: setattr(scene.view_layers[0], "use_pass_normal", True),
            "region": lambda: (setattr(scene.render, "use_border", True), setattr(scene.render, "border_max_x", 0.5)),
        }

    def test_whatever_a_script_changes_is_in_the_next_still(self):
        self.check_changes()

    def test_whatever_a_script_changes_is_in_the_next_still_where_persistent_data_keeps_the_scene(self):
        self.check_changes(is_kept=True)

    def check_changes(self, is_kept=False):
        """Checks that a still shows each change. `is_kept`: with persistent data, which an animation has used before."""
        for name in self.changes():
            with self.subTest(name):
                self.tearDown()
                self.setUp()
                if is_kept:
                    self.scene.render.use_persistent_data = True
                    self.animation(1, 2)
                change = self.changes()[name]
                self.assertEqual(self.stills(1, 2, 3), ["1-16"])
                change()
                self.still(4)
                self.assertEqual([shot["render"]["frames"] for shot in self.shots], ["1-16", "4"])

    def test_a_script_that_changes_something_in_each_still_is_not_exported_ahead_for_long(self):
        for frame in range(1, 13):
            self.floor.location.x = frame
            self.still(frame)
        shots = [shot["render"]["frames"] for shot in self.shots]
        self.assertEqual(shots, ["1-16", "2-17", *map(str, range(3, 13))])
        self.assertEqual([shot["model"][0]["matrix"][0][3] for shot in self.shots], list(range(1, 13)))

    def test_a_material_that_changes_by_keys_is_in_each_still(self):
        material = bpy.data.materials.new("Fade")
        material.use_nodes = True
        self.floor.data.materials.append(material)
        socket = material.node_tree.nodes["Principled BSDF"].inputs["Roughness"]
        for frame, value in ((4, 0.25), (5, 0.5), (6, 0.5)):
            socket.default_value = value
            socket.keyframe_insert("default_value", frame=frame)
        self.scene.frame_end = 8
        self.assertEqual(self.stills(*range(1, 9)), ["1-4", "5-8"])
        self.assertEqual([shot["material"][0]["pr"] for shot in self.shots], [0.25, 0.5])

    def test_no_files_are_left_of_stills_once_another_scene_is_loaded(self):
        self.stills(1, 2, 3, 4)
        folders = [job.folder for job in self.session._jobs.values()]
        self.assertEqual([os.path.isdir(folder) for folder in folders], [True])
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.assertEqual((self.session._jobs, [os.path.isdir(folder) for folder in folders]), ({}, [False]))

    def test_a_job_that_no_still_wants_is_over_after_a_minute(self):
        self.stills(1, 2, 3, 4)
        (job,) = self.session._jobs.values()
        self.session.release()
        self.assertEqual(len(self.session._jobs), 1)
        job.kept_at -= 61
        self.session.release()
        self.assertEqual((self.session._jobs, os.path.isdir(job.folder)), ({}, False))

    def test_an_animation_after_stills_is_exported_by_itself(self):
        self.stills(1, 2, 3)
        self.scene.frame_start, self.scene.frame_end = 4, 6
        self.scene.render.filepath = os.path.join(self.scratch.name, "f.####")
        bpy.ops.render.render(animation=True)
        self.assertEqual([shot["render"]["frames"] for shot in self.shots], ["1-16", "4-6"])
        self.assertEqual(self.session._jobs, {})


if __name__ == "__main__":
    unittest.main()

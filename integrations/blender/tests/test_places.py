# SPDX-License-Identifier: GPL-3.0-or-later
"""Where many copies of a mesh are, and what has many keys: in arrays beside the shot file."""

import os

import bpy
import numpy as np
from support import ExportCase, add, add_camera, extension, grid


class Places(ExportCase):
    def setUp(self):
        super().setUp()
        add_camera(self.scene)

    def array(self, model):
        places = model["places"]
        with open(os.path.join(self.folder, places["names"]), encoding="utf-8") as file:
            names = file.read().split("\n")
        self.assertEqual(names.pop(), "")
        return np.load(os.path.join(self.folder, places["file"])), names

    def test_hundreds_of_copies_at_rest_are_one_array(self):
        mesh = grid()
        for number in range(200):
            add(self.scene, f"Copy {number}", mesh, (number, 0, 0))
        models = self.export()["model"]
        self.assertEqual(len(models), 1)
        places, names = self.array(models[0])
        self.assertEqual((places.shape, names[7]), ((200, 3, 4), "Copy 7"))
        np.testing.assert_allclose(sorted(places[:, 0, 3]), np.arange(200))
        self.assertNotIn("every", models[0]["places"])

    def test_a_few_copies_stay_readable(self):
        mesh = grid()
        for number in range(3):
            add(self.scene, f"Copy {number}", mesh, (number, 0, 0))
        self.assertEqual([("matrix" in model, "places" in model) for model in self.export()["model"]], [(True, False)] * 3)

    def test_a_long_animation_has_a_key_a_frame(self):
        self.scene.frame_end = 100
        item = add(self.scene, "Mover", grid())
        item.keyframe_insert("location", frame=1)
        item.location.x = 99
        item.keyframe_insert("location", frame=100)
        add(self.scene, "Other", item.data, (0, 0, 5))
        models = self.export()["model"]
        rests, moves = sorted(models, key=lambda model: "places" in model)
        self.assertIn("matrix", rests)
        places, names = self.array(moves)
        self.assertEqual((places.shape, names), ((1, 100, 3, 4), ["Mover"]))
        self.assertEqual((moves["places"]["first"], moves["places"]["every"]), (1.0, 1.0))
        self.assertTrue((np.diff(places[0, :, 0, 3]) > 0).all())

    def test_what_comes_and_goes_is_zero_while_it_is_away(self):
        self.scene.frame_end = 100
        item = add(self.scene, "Guest", grid())
        for frame, hidden in [(1, True), (20, False), (50, True), (80, False)]:
            item.hide_render = hidden
            item.keyframe_insert("hide_render", frame=frame)
        places, _ = self.array(self.export()["model"][0])
        there = places[0].reshape(100, 12).any(axis=1)
        expected = [20 <= frame < 50 or frame >= 80 for frame in range(1, 101)]
        self.assertEqual(there.tolist(), expected)


class Keys(ExportCase):
    def test_keys_between_exposures_lie_on_the_way(self):
        places = __import__(f"{extension().__name__}.export.places", fromlist=["places"])
        # a shutter that is open for half of each frame: quarters of frames, with one missing in each
        times = [0.75, 1.0, 1.25, 1.75, 2.0, 2.25]
        found = places.Grid(times)
        self.assertEqual((found.first, found.every, found.count), (0.75, 0.25, 7))
        matrices = {time: np.full(12, time) for time in times}
        keys = found.keys([times[:4]], matrices)
        np.testing.assert_allclose(keys[:, 0, 0], [0.75, 1.0, 1.25, 1.5, 1.75, 0.0, 0.0])
        keys = found.keys([times[2:3], times[5:]], matrices)
        np.testing.assert_allclose(keys[:, 0, 0], [0, 0, 1.25, 1.25, 0, 0, 2.25], err_msg="it stays until it is gone")
        uneven = places.Grid([1.0, 2.0, 500.0])
        self.assertFalse(uneven.is_of_use)
        self.assertFalse(places.Grid([1.0, 1.0 + 1 / 3000]).is_of_use)
        self.assertTrue(places.Grid([7.0]).is_of_use)

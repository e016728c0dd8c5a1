"""Programs that render frame by frame: each frame is made of the samples of the one before, and is the picture of a render of all."""

import gc
import os
import time
import unittest

import numpy as np
from support import COURT, moved, still

import afterimage

SLOW = {"size": (320, 180), "samples": 2, "paths": 4}
"""Frames take some tenths of a second: whoever renders others on the way is told."""


def rendered(scene, number, **settings):
    """A frame, and the numbers of all frames that were rendered for it."""
    numbers = set()
    frames = list(afterimage.render(scene, frames=number, progress=lambda frame, share: numbers.add(frame), **settings))
    return frames[-1], numbers


def tasks():
    return len(os.listdir("/proc/self/task"))


class FrameByFrame(unittest.TestCase):
    def assert_same(self, one, other):
        self.assertEqual(one.number, other.number)
        for name, layer in one.layers.items():
            np.testing.assert_array_equal(layer, other.layers[name], f"frame {one.number}, {name}")
        for what in ("rays", "samples", "mode"):
            self.assertEqual(one.stats[what], other.stats[what], f"frame {one.number}")

    def test_frames_go_on_with_the_samples_of_the_frame_before(self):
        scene = afterimage.load(COURT)
        for settings in ({"layers": ["Z"]}, {"stereo": {"separation": 0.1}}, {"shutter": {"open": 0, "close": 0.5}}):
            settings = {**SLOW, **settings}
            whole = list(afterimage.render(scene, frames="1-4", **settings))
            self.assertGreater(whole[-1].stats["samples"]["good"], whole[-1].stats["samples"]["missed"])
            for expected in whole:
                frame, numbers = rendered(scene, expected.number, **settings)
                self.assertEqual(numbers, {expected.number}, "and no run-up to it")
                self.assert_same(frame, expected)

    def test_a_render_that_is_left_goes_on_in_the_next_one(self):
        scene = afterimage.load(COURT)
        whole = list(afterimage.render(scene, frames="1-5", **SLOW))
        self.assert_same(next(afterimage.render(scene, frames="1-5", **SLOW)), whole[0])
        for expected in whole[1:4]:
            numbers = set()
            left = afterimage.render(scene, frames=f"{expected.number}-9", progress=lambda frame, share, told=numbers: told.add(frame), **SLOW)
            self.assert_same(next(left), expected)
            del left
            self.assertEqual(numbers, {expected.number})
        # again, or not the next one: from the base frame, as ever
        for number, expected in ((4, {1, 2, 3, 4}), (5, {5}), (3, {1, 2, 3})):
            frame, numbers = rendered(scene, number, **SLOW)
            self.assert_same(frame, whole[number - 1])
            self.assertEqual(numbers, expected)

    def test_a_render_that_nobody_asks_anything_leaves_no_other_without_frames(self):
        scene = afterimage.load(COURT)
        for _ in range(20):
            afterimage.render(scene, frames="1-3", **SLOW)
        self.assertEqual([frame.number for frame in afterimage.render(scene, frames="1-2", **SLOW)], [1, 2])

    def test_other_settings_and_frames_of_their_own_begin_anew(self):
        scene = afterimage.load(COURT)
        rendered(scene, 1, **SLOW)
        other = {**SLOW, "paths": 5}
        self.assertEqual(rendered(scene, 2, **other)[1], {1, 2})
        self.assertEqual(rendered(scene, 3, **other)[1], {3})
        self.assertEqual(rendered(scene, 4, **SLOW)[1], {1, 2, 3, 4})
        self.assertEqual(rendered(scene, 4, mode="full", **SLOW)[1], {4})

    def test_two_renders_of_one_scene_at_a_time_are_apart(self):
        scene = afterimage.load(COURT)
        whole = list(afterimage.render(scene, frames="1-3", **SLOW))
        pair = [afterimage.render(scene, frames="1-3", **SLOW) for _ in range(2)]
        for expected in whole:
            for each in pair:
                self.assert_same(next(each), expected)

    def test_an_edit_drops_the_samples(self):
        def scene():
            made = still(frames="1-4", **SLOW)
            made.add_mesh("tile", [[-1, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], transform={1: moved(2), 4: moved(3, 1)})
            return made

        whole, edited = scene(), scene()
        kept = [rendered(whole, number)[0] for number in (1, 2)]
        self.assert_same(rendered(edited, 1)[0], kept[0])
        edited.add_light("point", position=(2, 3, 2), power=20)
        frame, numbers = rendered(edited, 2)
        self.assertEqual(numbers, {1, 2})
        self.assertGreater(frame.layers["RGBA"][..., :3].mean(), kept[1].layers["RGBA"][..., :3].mean())
        whole.add_light("point", position=(2, 3, 2), power=20)
        self.assert_same(list(afterimage.render(whole, frames="1-2"))[1], frame)

    def test_a_cancelled_frame_leaves_nothing(self):
        scene = afterimage.load(COURT)
        whole = list(afterimage.render(scene, frames="1-3", **SLOW))
        for number in (1, 2):
            rendered(scene, number, **SLOW)
        with self.assertRaises(afterimage.Cancelled):
            list(afterimage.render(scene, frames=3, progress=lambda frame, share: False, **SLOW))
        frame, numbers = rendered(scene, 3, **SLOW)
        self.assert_same(frame, whole[2])
        self.assertEqual(numbers, {1, 2, 3})

    def test_what_is_kept_goes_with_the_scene(self):
        list(afterimage.render(afterimage.load(COURT), frames=1, threads=2, **SLOW))
        gc.collect()
        time.sleep(1)
        before = tasks()
        scene = afterimage.load(COURT)
        list(afterimage.render(scene, frames=1, threads=2, **SLOW))
        self.assertGreater(tasks(), before)
        del scene
        gc.collect()
        deadline = time.monotonic() + 10
        while time.monotonic() < deadline and tasks() > before:
            time.sleep(0.05)
        self.assertLessEqual(tasks(), before, "threads are left")


if __name__ == "__main__":
    unittest.main()

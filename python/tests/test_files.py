"""Shots from files: the same numbers as in the program's files, bit by bit."""

import tempfile
import unittest

import numpy as np

import afterimage
import exr
from support import COURT, ROOT, program, rendered_by_program

SMALL = {"size": (96, 54), "paths": 2}
SMALL_OPTIONS = ["--size", "96x54", "--paths", "2"]


def channels_of(frame):
    """The channels of a frame by the names that they have in files, in any order of those of a layer."""
    for name, array in frame.layers.items():
        yield name, [array[:, :, channel] for channel in range(array.shape[2])]


class Files(unittest.TestCase):
    def test_a_shot_says_what_it_is(self):
        scene = afterimage.load(COURT)
        self.assertEqual((scene.frames, scene.size, scene.warnings), (list(range(1, 49)), (1280, 720), []))

    def test_frames_come_lazily_with_their_layers(self):
        render = afterimage.render(afterimage.load(str(COURT)), frames="1-3", layers="all", **SMALL)
        frames = list(render)
        self.assertEqual([frame.number for frame in frames], [1, 2, 3])
        self.assertEqual([frame.stats["mode"] for frame in frames], ["base", "reproject", "reproject"])
        layers = frames[0].layers
        self.assertEqual((layers["RGBA"].shape, layers["RGBA"].dtype), ((54, 96, 4), np.float32))
        self.assertEqual((layers["Z"].shape, layers["object"].dtype), ((54, 96, 1), np.uint32))
        self.assertEqual(layers["CryptoObject02"].shape, (54, 96, 4))
        self.assertGreater(len(np.unique(layers["object"])), 3)
        self.assertTrue(all(np.isfinite(layer).all() for layer in layers.values()))
        self.assertTrue(all(frame.seconds > 0 for frame in frames))
        self.assertEqual(list(render), [], "a render that is over has no more frames")

    @unittest.skipUnless(program(), "AFTERIMAGE_PROGRAM names no program")
    def test_frames_are_those_of_the_program(self):
        for shot, frames, settings, options in [
            (COURT, "1-3", {}, []),
            (COURT, "5-7x2", {"base_every": 4, "layers": "all"}, ["--base-every", "4", "--layers", "all"]),
            (COURT, "1-3", {"base_place": "middle", "mode": "reproject", "base_every": 3},
             ["--base-place", "middle", "--mode", "reproject", "--base-every", "3"]),
            (ROOT / "scenes" / "analytic" / "analytic.toml", "1", {"crop": (8, 6, 40, 30), "overscan": 3},
             ["--crop", "40x30+8+6", "--overscan", "3"]),
        ]:
            with self.subTest(shot=shot.name, frames=frames), tempfile.TemporaryDirectory() as folder:
                files = rendered_by_program(shot, frames, folder, *SMALL_OPTIONS, *options, "--compression", "none")
                ours = list(afterimage.render(afterimage.load(shot), frames=frames, **SMALL, **settings))
                self.assertEqual(sorted(frame.number for frame in ours), sorted(files))
                for frame in ours:
                    self.assert_same(frame, exr.read(files[frame.number]))

    def assert_same(self, frame, planes):
        """Compares all numbers of a frame with those of a file, which may be halves."""
        count = 0
        for layer, array in frame.layers.items():
            own = [name for name in planes if name.split(".")[0] == layer] or list(layer)
            self.assertEqual(len(own), array.shape[2], layer)
            # files sort channels by name; arrays have them in the order of their letters
            own.sort(key=lambda name: "RGBXYZUVWA".index(name[-1]))
            for channel, name in enumerate(own):
                plane, ours = planes[name], array[:, :, channel].astype(planes[name].dtype)
                self.assertTrue(np.array_equal(plane, ours), f"frame {frame.number}, {name}")
                count += 1
        self.assertEqual(count, len(planes), "a channel is in one of the two alone")

    def test_bad_files_are_told_as_the_program_tells_them(self):
        with tempfile.TemporaryDirectory() as folder:
            path = f"{folder}/odd.toml"
            with open(path, "w", encoding="utf-8") as file:
                file.write("[render]\nsise = [64, 48]\n")
            with self.assertRaises(afterimage.Error) as caught:
                afterimage.load(path)
            self.assertTrue(str(caught.exception).startswith(f"{path}:2:1: unknown key `sise`: did you mean `size`?"))
            for name in ["missing.obj", "missing.glb", "picture.png", "missing.ply"]:
                with self.assertRaises(afterimage.Error):
                    afterimage.load(f"{folder}/{name}")

    def test_settings_that_make_no_sense_are_refused_at_once(self):
        scene = afterimage.load(COURT)
        for settings, words in [
            ({"sise": (64, 48)}, "did you mean `size`"),
            ({"size": (0, 48)}, "`size` is 0"),
            ({"size": (64, float("nan"))}, "`size`"),
            ({"samples": 99}, "`samples` is 99"),
            ({"layers": ["far"]}, "there is no layer `far`"),
            ({"threads": 0}, "`threads` must be a whole number"),
            ({"backend": "gpu"}, '`backend` must be "embree" or "rust"'),
            ({"crop": (0, 0, 4000, 1)}, "a crop must lie in it"),
            ({"size": (60000, 60000), "samples": 16}, "samples a frame"),
            ({"mode": "fast"}, "unknown value `fast`"),
            ({"frames": "3-1"}, "runs backwards"),
            ({"frames": []}, "`frames` is empty"),
            ({"frames": range(4, 4)}, "`frames` is empty"),
            ({"frames": 1.5}, "must be whole numbers"),
            ({"depth": object()}, "`depth`: a object is neither a number"),
            ({"rate": 25}, "is the shot's own"),
            ({"filter": "box", "filter_radius": 2}, "means nothing for `box` and `area`"),
        ]:
            with self.subTest(**settings), self.assertRaises(afterimage.Error) as caught:
                afterimage.render(scene, **settings)
            self.assertIn(words, str(caught.exception))

    def test_frames_may_be_said_in_many_ways(self):
        scene = afterimage.load(COURT)
        for frames, expected in [(3, [3]), (range(1, 6, 2), [1, 3, 5]), (range(3, 0, -1), [1, 2, 3]),
                                 (np.arange(1, 3), [1, 2]), ([2, 1], [1, 2]), ("1,3", [1, 3])]:
            rendered = afterimage.render(scene, frames=frames, mode="full", size=(16, 9), paths=0, samples=1)
            self.assertEqual([frame.number for frame in rendered], expected, frames)

    def test_two_eyes_come_as_one_frame(self):
        scene = afterimage.load(COURT)
        (frame,) = afterimage.render(scene, frames=1, stereo={"separation": 0.1}, **SMALL)
        left, right = frame.layers["RGBA"], frame.layers["RGBA.right"]
        self.assertEqual(left.shape, right.shape)
        self.assertFalse(np.array_equal(left, right))
        self.assertIn("samples", frame.stats["right"])


if __name__ == "__main__":
    unittest.main()

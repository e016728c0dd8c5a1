"""Curves of arrays: are they shown where they are, do they deform, and is what does not fit told?"""
import unittest

import numpy as np

import afterimage
from support import moved, picture


def upright(count=5, points=4):
    """(count * points, 3): hairs side by side, 2 high."""
    up = np.linspace(-1, 1, points)
    return np.array([[x, y, 0] for x in np.linspace(-1, 1, count) for y in up])


def shot(**values):
    scene = afterimage.Scene(**{"size": (64, 48), "samples": 2, "frames": 1, **values})
    scene.add_light("sun", direction=(0, -0.3, -1), power=3)
    scene.set_camera(transform=moved(z=6), fov=40)
    return scene


class Curves(unittest.TestCase):
    def test_curves_are_where_their_points_are(self):
        columns = {}
        for basis, counts in [("linear", 4), ("bspline", [4] * 5), ("bezier", np.full(5, 4, np.int64)), ("catmull-rom", 4)]:
            scene = shot()
            scene.add_curves("hairs", upright(), counts, 0.1, basis=basis, material=scene.add_material("red", base_color=(1, 0, 0)))
            layers = picture(scene)
            columns[basis] = (layers["object"][24, :, 0] == 1).sum()
            self.assertGreater(layers["RGBA"][..., 0].max(), 0.1)
            self.assertEqual(layers["RGBA"][..., 1].max(), 0)
        # 5 hairs, 0.2 wide each, of the 5.8 that are seen
        self.assertTrue(all(abs(count - 11) <= 3 for count in columns.values()), columns)

    def test_flat_curves_are_strips_across_their_normals(self):
        seen = []
        for normal in [(0, 0, 1), (1, 0, 0)]:
            scene = shot()
            scene.add_curves("blades", upright(), 4, np.full(20, 0.1), normals=np.tile(normal, (20, 1)))
            seen.append((picture(scene)["object"] == 1).sum())
        self.assertGreater(seen[0], 5 * seen[1])

    def test_curves_deform_and_samples_go_along(self):
        scene = shot(frames="1-3", shutter={"open": -0.25, "close": 0.25})
        points = upright()
        scene.add_curves("hairs", points, 4, 0.05, points_by_frame={1: points, 3: points + [1, 0, 0]})
        frames = list(afterimage.render(scene, mode="reproject", audit=True))
        places = [np.nonzero(frame.layers["object"][..., 0] == 1)[1].mean() for frame in frames]
        self.assertLess(places[0] + 3, places[1])
        self.assertLess(places[1] + 3, places[2])
        self.assertEqual(sum(frame.stats["audit"]["differing"] for frame in frames), 0)

    def test_what_does_not_fit_is_told(self):
        points = upright()
        huge = points.copy()
        huge[3, 1] = np.nan
        for told, values in [
            ("20 points are no curves of 3", {"counts": 3}),
            ("19 points in all by their counts, and there are 20", {"counts": [4, 4, 4, 4, 3]}),
            ("3 radii for 20 points", {"radius": [1.0, 2.0, 3.0]}),
            ("radius is below 0, not finite", {"radius": float("nan")}),
            ("radius is below 0, not finite", {"radius": -1.0}),
            ("a point is not finite", {"points": huge}),
            ("one of `linear`, `bezier`", {"basis": "hermite"}),
            ("another number at frame 2", {"points_by_frame": {1: points, 2: points[:8]}}),
            ("a point at frame 2 is not finite", {"points_by_frame": {1: points, 2: huge}}),
            ("1 texture coordinates for 5 curves", {"uv": [[0, 0]]}),
            ("2 normals for 20 points", {"normals": [[0, 0, 1]] * 2}),
            ("there is no material `red`", {"material": "red"}),
            ("there are none", {"points": np.zeros((0, 3)), "counts": []}),
        ]:
            with self.subTest(told), self.assertRaisesRegex(afterimage.Error, told):
                shot().add_curves("hairs", **{"points": points, "counts": 4, "radius": 0.1, **values})

    def test_what_has_no_length_or_thickness_is_left_out(self):
        scene = shot()
        points = upright()
        points[4:8] = points[4]
        radii = np.full(20, 0.05)
        radii[8:12] = 0
        scene.add_curves("hairs", points, 4, radii)
        self.assertEqual(sum("left out" in warning for warning in scene.warnings), 2)
        # three of five, 0.1 wide and 2 high, at 11 pixels a unit
        self.assertTrue(abs((picture(scene)["object"] == 1).sum() - 73) < 20)
        scene = shot()
        scene.add_curves("dots", np.zeros((8, 3)), 4, 0.1)
        scene.add_mesh("triangle", [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
        self.assertIn("without a length", " ".join(scene.warnings))


if __name__ == "__main__":
    unittest.main()

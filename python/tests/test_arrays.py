"""Scenes from arrays."""

import unittest

import numpy as np

import afterimage
from support import CUBE, CUBE_FACES, moved, picture, still


class Arrays(unittest.TestCase):
    def test_a_still(self):
        scene = still()
        self.assertEqual((scene.frames, scene.size, scene.warnings), ([1], (64, 48), []))
        layers = picture(scene, layers=["object", "N", "Z"])
        self.assertEqual(set(np.unique(layers["object"])), {0, 1, 2})
        cube = layers["RGBA"][layers["object"][:, :, 0] == 1]
        self.assertGreater(cube[:, 0].mean(), 3 * cube[:, 1].mean(), "the cube is red")
        background = layers["RGBA"][layers["object"][:, :, 0] == 0]
        self.assertTrue(np.allclose(background[:, :3], (0.2, 0.3, 0.5), atol=1e-3))
        floor = layers["N"][layers["object"][:, :, 0] == 2]
        self.assertTrue(np.allclose(floor, (0, 1, 0)))

    def test_layout_and_type_of_arrays_do_not_matter(self):
        triangles = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5]], np.int32)
        expected = None
        wide = np.zeros((8, 6))
        wide[:, ::2] = CUBE
        for points, faces in [
            (CUBE, triangles),
            (CUBE.astype(np.float64), triangles.astype(np.uint8)),
            (np.asfortranarray(CUBE), np.asfortranarray(triangles.astype(np.int64))),
            (wide[:, ::2], triangles[::-1][::-1]),
            (CUBE.tolist(), triangles.tolist()),
            (CUBE.astype(np.float16), (triangles.ravel(), [3] * 4)),
        ]:
            scene = afterimage.Scene(size=(32, 24), samples=1)
            scene.add_mesh("sides", points, faces)
            scene.add_light("point", position=(0, 5, 5), power=50)
            scene.set_camera(eye=(5, 4, 6), target=(0, 0, 0))
            image = picture(scene)["RGBA"]
            expected = image if expected is None else expected
            self.assertGreater(image.max(), 0)
            self.assertTrue(np.array_equal(image, expected))

    def test_arrays_may_change_after_they_were_given(self):
        points, scene = CUBE.copy(), afterimage.Scene(size=(32, 24), samples=1)
        scene.add_mesh("cube", points, CUBE_FACES)
        points[:] = np.nan
        scene.add_light("sun", direction=(0, -1, -1))
        scene.set_camera(eye=(5, 4, 6), target=(0, 0, 0))
        self.assertIn(1, picture(scene)["object"])

    def test_values_of_points_and_of_corners_are_the_same_where_they_agree(self):
        corners, counts = CUBE_FACES
        normals = CUBE / np.sqrt(3)
        uv = CUBE[:, :2]
        images = []
        for by_corner in (False, True):
            scene = afterimage.Scene(size=(48, 36), samples=1)
            paint = np.abs(CUBE) * (0.9, 0.5, 0.1)
            values = [values[corners] if by_corner else values for values in (normals, uv, paint)]
            scene.add_mesh("cube", CUBE, (corners, counts), *values)
            scene.add_light("sun", direction=(-1, -2, -3))
            scene.set_camera(eye=(4, 3, 6), target=(0, 0, 0))
            images.append(picture(scene, layers=["uv", "N", "albedo"]))
        for name in ("RGBA", "uv", "N", "albedo"):
            self.assertTrue(np.array_equal(images[0][name], images[1][name]), name)
        painted = images[0]["albedo"][images[0]["uv"][:, :, 2] == 1]
        self.assertGreater(painted[:, 0].max(), 0.5)

    def test_faces_have_their_materials(self):
        scene = afterimage.Scene(size=(64, 48), samples=1)
        materials = [scene.add_material("glow", base_color=(0, 0, 0), emission=(0, 1, 0), emission_strength=2), None]
        square = [[-1, -1, 0], [0, -1, 0], [1, -1, 0], [-1, 1, 0], [0, 1, 0], [1, 1, 0]]
        faces = ([0, 1, 4, 3, 1, 2, 5, 4], [4, 4])
        scene.add_mesh("square", square, faces, materials=materials, face_materials=[0, 1])
        scene.set_camera(eye=(0, 0, 5), target=(0, 0, 0))
        image = picture(scene)["RGBA"]
        self.assertTrue(np.allclose(image[24, 24, :3], (0, 2, 0)), "left of the middle")
        self.assertTrue(np.array_equal(image[24, 40, :3], (0, 0, 0)), "right of it no light shines")

    def test_copies_motion_and_shapes(self):
        scene = afterimage.Scene(frames="1-3", fps=25, size=(64, 48), samples=1)
        cube = scene.add_mesh("cube", CUBE, CUBE_FACES, transform={1: moved(x=-4), 3: moved(x=4)})
        scene.add_instance(cube, moved(y=3), name="above", visible={1: True, 3: False})
        scene.add_mesh("soft", CUBE, CUBE_FACES, vertices_by_frame={1: CUBE * 0.2, 3: CUBE}, transform=moved(y=-3))
        scene.add_light("sun", direction=(0, -1, -1))
        scene.set_camera(transform=moved(z=14), fov=50)
        frames = list(afterimage.render(scene))
        places = [np.nonzero(frame.layers["object"][:, :, 0] == 1)[1].mean() for frame in frames]
        self.assertLess(places[0], places[1] - 5)
        self.assertLess(places[1], places[2] - 5)
        self.assertAlmostEqual(places[1], 31.5, delta=1)
        above, soft = ([(frame.layers["object"] == number).sum() for frame in frames] for number in (2, 3))
        self.assertGreater(above[1], 10)
        self.assertEqual(above[2], 0)
        self.assertLess(soft[0], soft[1])
        self.assertLess(soft[1], soft[2])

    def test_rays_see_what_they_are_to_see(self):
        scene = afterimage.Scene(frames="1", size=(32, 24), samples=1, background="transparent")
        scene.add_mesh("hidden", CUBE, CUBE_FACES, transform=moved(x=-3), hidden_from=["camera", "shadow"])
        cube = scene.add_mesh("shown", CUBE, CUBE_FACES)
        scene.add_instance(cube, moved(x=3), holdout=True)
        scene.set_camera(transform=moved(z=14), fov=50)
        frame = next(iter(afterimage.render(scene)))
        self.assertEqual(set(np.unique(frame.layers["object"])), {0, 2, 3})
        alpha = frame.layers["RGBA"][:, :, 3]
        self.assertGreater(alpha[:, 13:19].sum(), 5)
        self.assertEqual(alpha[:, :13].sum() + alpha[:, 19:].sum(), 0)
        with self.assertRaisesRegex(afterimage.Error, "there are no rays `eye`"):
            scene.add_instance(cube, hidden_from=["eye"])

    def test_reuse_is_exact(self):
        scene = still(frames="1-4", paths=4)
        scene.set_camera(keys={1: {"eye": (4, 3, 6)}, 4: {"eye": (4.5, 3, 5.6)}}, target=(0, 1, 0))
        frames = list(afterimage.render(scene, mode="reproject", audit=True))
        for key in ["differing", "coverage"]:
            self.assertEqual(sum(frame.stats["audit"][key] for frame in frames), 0)
        self.assertGreater(frames[-1].stats["samples"]["good"], 1000)

    def test_every_kind_of_light_shines(self):
        down = np.array([[1, 0, 0, 0], [0, 0, 1, 4], [0, -1, 0, 0], [0, 0, 0, 1]], float)
        for kind, values in [("point", {"power": 30}), ("sun", {"power": 2}), ("spot", {"power": 60, "cone": 80}),
                             ("rectangle", {"power": 30, "size": (1, 2)}), ("disk", {"power": 30}),
                             ("sphere", {"power": 30, "radius": 0.3})]:
            scene = afterimage.Scene(size=(32, 24), samples=1)
            scene.add_mesh("floor", [[-3, 0, -3], [-3, 0, 3], [3, 0, 3], [3, 0, -3]], [[0, 1, 2], [0, 2, 3]])
            scene.add_light(kind, transform=down, **values)
            scene.set_camera(eye=(0, 3, 6), target=(0, 0, 0))
            self.assertGreater(picture(scene)["RGBA"][12, 16, :3].min(), 0.01, kind)

    def test_a_matrix_turns_a_rectangle_about_its_axis(self):
        def lit(turn):
            sin, cos = np.sin(turn), np.cos(turn)
            above = np.array([[cos, -sin, 0, 0], [0, 0, 1, 0.5], [-sin, -cos, 0, 0], [0, 0, 0, 1]], float)
            scene = afterimage.Scene(size=(32, 32), samples=2)
            scene.add_mesh("floor", [[-3, 0, -3], [-3, 0, 3], [3, 0, 3], [3, 0, -3]], [[0, 1, 2], [0, 2, 3]])
            scene.add_light("rectangle", transform=above, size=(3, 0.1), power=1)
            scene.set_camera(transform=np.array([[1, 0, 0, 0], [0, 0, 1, 5], [0, -1, 0, 0], [0, 0, 0, 1]], float))
            light = picture(scene)["RGBA"][:, :, 0]
            return light[16, 4] / light[4, 16]
        self.assertGreater(lit(0), 1.5)
        self.assertLess(lit(np.pi / 2), 1 / 1.5)
        self.assertAlmostEqual(lit(np.pi / 4), 1, delta=0.1)

    def test_glass_sky_and_alpha(self):
        scene = afterimage.Scene(size=(48, 36), samples=1, paths=2, layers="all")
        glass = scene.add_material("glass", base_color=(1, 0.5, 0.5), transmission=1, ior=1.4)
        veil = scene.add_material("veil", alpha=0.5, roughness=1)
        scene.add_mesh("glass", CUBE, CUBE_FACES, material=glass)
        scene.add_mesh("veil", CUBE, CUBE_FACES, material=veil, transform=moved(x=3))
        scene.set_sky(elevation=30, azimuth=90, power=0.3)
        scene.set_camera(eye=(2, 2, 9), target=(1, 0, 0))
        layers = picture(scene)
        through = layers["refraction"][layers["object"][:, :, 0] == 1]
        self.assertGreater(through[:, 0].mean(), 1.3 * through[:, 1].mean())
        self.assertGreater(layers["refraction"][layers["object"][:, :, 0] == 2].mean(), 0)

    def test_meshes_that_make_no_sense_are_refused(self):
        scene = afterimage.Scene()
        triangle = [[0, 1, 2]]
        nan = CUBE.copy()
        nan[3, 1] = np.nan
        for words, arguments in [
            ("is not finite", {"vertices": nan}),
            ("must have the shape (n, 3), and has [8, 2]", {"vertices": CUBE[:, :2]}),
            ("must have the shape (n, 3)", {"vertices": CUBE.ravel()}),
            ("its dtype is <U", {"vertices": [["a", "b", "c"]] * 3}),
            ("its dtype is object", {"vertices": np.array([[None] * 3] * 3)}),
            ("is no array of numbers", {"vertices": [[1, 2], [3]]}),
            ("its dtype is complex", {"vertices": CUBE.astype(complex)}),
            ("a face is at vertex 8, and there are 8", {"faces": [[0, 1, 8]]}),
            ("has -1: numbers from 0", {"faces": [[0, 1, -1]]}),
            ("must be whole numbers, and its dtype is float64", {"faces": [[0.0, 1.0, 2.0]]}),
            ("it has no faces", {"faces": np.zeros((0, 3), int)}),
            ("it has no faces", {"faces": ([], [])}),
            ("do not add up to its 4 corners", {"faces": ([0, 1, 2, 3], [3])}),
            ("must have the shape (m, 3)", {"faces": [[0, 1, 2, 3]]}),
            ("`normals` has 3 entries", {"normals": np.ones((3, 3)), "faces": [[0, 1, 2], [0, 2, 3]]}),
            ("`uv` has a number that is not finite", {"uv": np.full((8, 2), np.inf)}),
            ("1 numbers of materials do not fit to 2 faces", {"face_materials": [0], "faces": [[0, 1, 2], [0, 2, 3]]}),
            ("a face has material 1, and there are 1", {"face_materials": [1], "materials": [None]}),
            ("there is no material `far`", {"material": "far"}),
            ("give `material` or `materials`", {"material": "a", "materials": ["a"]}),
            ("must have the shape (4, 4)", {"transform": np.eye(3)}),
            ("transpose those of row vectors", {"transform": moved(x=1).T}),
            ("is not finite", {"transform": moved(x=np.nan)}),
            ("is an empty dict", {"transform": {}}),
            ("must be numbers of frames", {"transform": {"a": np.eye(4)}}),
            ("3 vertices at frame 2 do not fit to its 8", {"vertices_by_frame": {2: CUBE[:3]}}),
            ("`visible` of `odd` must be True or False", {"visible": "yes"}),
        ]:
            with self.subTest(words), self.assertRaises(afterimage.Error) as caught:
                scene.add_mesh(**{"name": "odd", "vertices": CUBE, "faces": triangle, **arguments})
            self.assertIn(words, str(caught.exception))
            self.assertIn("odd", str(caught.exception))

    def test_other_things_that_make_no_sense_are_refused(self):
        scene, other = afterimage.Scene(), afterimage.Scene()
        mesh = other.add_mesh("cube", CUBE, CUBE_FACES)
        scene.add_material("red")
        for words, make in [
            ("there is a material `red` already", lambda: scene.add_material("red")),
            ("material `x`: `roughness` is 7", lambda: scene.add_material("x", roughness=7)),
            ("material `x`: unknown key `rough`", lambda: scene.add_material("x", rough=7)),
            ("light 1: `power` is", lambda: scene.add_light("point", position=(0, 0, 0), power=float("nan"))),
            ("unknown value `lamp`", lambda: scene.add_light("lamp")),
            ("camera", lambda: scene.set_camera(eye=(0, 0), target=(0, 0, 0))),
            ("unknown key `eyes`", lambda: scene.set_camera(eyes=(0, 0, 0))),
            ("unknown key `elevate`", lambda: scene.set_sky(elevate=2)),
            ("has a function of its own", lambda: scene.set("light", power=2)),
            ("unknown key `flor`", lambda: scene.set("flor", height=2)),
            ("of another scene", lambda: scene.add_instance(mesh)),
            ("stays as it is", lambda: afterimage.load(__import__("support").COURT).set_camera()),
            ("`fps` must be", lambda: afterimage.Scene(fps=0)),
            ("unknown key `sise`", lambda: afterimage.Scene(sise=0)),
        ]:
            with self.subTest(words), self.assertRaises(afterimage.Error) as caught:
                make()
            self.assertIn(words, str(caught.exception))

    def test_scenes_that_lack_something_say_so_when_they_are_rendered(self):
        empty = afterimage.Scene()
        with self.assertRaisesRegex(afterimage.Error, r"there is no \[camera\]"):
            afterimage.render(empty)
        empty.set_camera(eye=(0, 0, 5), target=(0, 0, 0))
        with self.assertRaisesRegex(afterimage.Error, "there is nothing to see"):
            afterimage.render(empty)
        empty.add_mesh("flat", np.zeros((3, 3)), [[0, 1, 2]])
        with self.assertRaisesRegex(afterimage.Error, "no mesh has a face with an area"):
            afterimage.render(empty)
        empty.add_mesh("cube", CUBE, CUBE_FACES)
        self.assertIn("mesh `flat` has no face with an area: it is left out", empty.warnings)
        self.assertEqual(len(list(afterimage.render(empty, size=(16, 9)))), 1)

    def test_a_scene_may_grow_after_it_was_rendered(self):
        scene = still()
        before = picture(scene)["object"].max()
        scene.add_mesh("more", CUBE, CUBE_FACES, transform=moved(x=-2.5, y=1))
        self.assertEqual((before, picture(scene)["object"].max()), (2, 3))

    def test_many_copies(self):
        scene = still()
        cube = scene.add_mesh("small", CUBE * 0.01, CUBE_FACES, visible=False)
        for number in range(10_000):
            scene.add_instance(cube, moved(x=number % 100 * 0.05 - 2.5, y=2 + number // 100 * 0.05))
        self.assertGreater(len(np.unique(picture(scene)["object"])), 100)


if __name__ == "__main__":
    unittest.main()

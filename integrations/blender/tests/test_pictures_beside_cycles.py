# SPDX-License-Identifier: GPL-3.0-or-later
"""Tiles of UDIM, sequences and movies, beside Cycles. Needs bpy and the renderer's Python module."""

import os
import unittest

import beside_cycles
import bpy
import numpy as np
import support
import test_pictures
from support import Tree
from test_pictures import COLORS, shows, spread
from test_surfaces import principled


class PicturesBesideCycles(beside_cycles.BesideCycles):
    """A matt square before a white world: what is seen is its base colour."""

    def setUp(self):
        super().setUp()
        self.scene.world = bpy.data.worlds.new("World")
        self.scene.world.use_nodes = True
        self.lit(1)
        self.scene.afterimage.samples = 4
        support.add_camera(self.scene, (0, 0, 6), (0, 0, 0))
        self.mesh = support.grid("Square", 4, 2)
        self.item = support.add(self.scene, "Square", self.mesh, turn=(0.2, -0.1, 0.3))
        self.material, self.node = principled("Tiled", Roughness=1.0, Specular_IOR_Level=0.0)
        self.mesh.materials.append(self.material)

    def lit(self, light):
        """Has the world be of this grey."""
        self.scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (light, light, light, 1)

    def tiled(self, colors, size=32, **more):
        return test_pictures.tiled(self.scratch.name, colors, size=size, **more)

    def assert_same(self, name, tolerance=0.01):
        """Compares both pictures. Edges differ: of the square, and of tiles, where a texel of the next one shines in."""
        ours, cycles = self.both()
        self.keep(name, ours, cycles)
        self.assertGreater(np.ptp(cycles[12:-12, 16:-16, :3]), 0.05, "it shows a pattern")
        self.assertLess(float(np.abs(ours - cycles)[:, :, :3].mean()), tolerance)
        return ours, cycles

    @staticmethod
    def keep(name, *pictures):
        """Keeps pictures beside each other in the folder that AFTERIMAGE_LOOK names, to be looked at."""
        folder = os.environ.get("AFTERIMAGE_LOOK")
        if folder:
            whole = np.concatenate([np.clip(picture[:, :, :3], 0, 1) for picture in pictures], axis=1)
            bytes_of = (support.extension().export.images.to_srgb(whole) * 255 + 0.5).astype(np.uint8)
            support.extension().export.files.write_png(os.path.join(folder, f"{name}.png"), np.repeat(np.repeat(bytes_of, 4, axis=0), 4, axis=1))

    def test_tiles(self):
        spread(self.mesh, 2, 2)
        shows(self.material, self.node, self.tiled(COLORS))
        self.assert_same("tiles")
        self.assertEqual(self.exported.warnings, [])

    def test_a_tile_that_is_missing(self):
        spread(self.mesh, 2, 2)
        shows(self.material, self.node, self.tiled({number: COLORS[number] for number in (1001, 1002, 1011)}))
        self.assert_same("missing tile")
        self.assertEqual(self.exported.warnings, [])

    def test_tiles_beside_the_first_one_that_a_mapping_moves(self):
        spread(self.mesh, 1, 1)
        source = shows(self.material, self.node, self.tiled({number: COLORS[number] for number in (1002, 1012)}))
        tree = Tree(self.material)
        at = tree.add("Mapping", {"Vector": tree.add("TexCoord").outputs["UV"], "Location": (1, 0, 0), "Scale": (0.9, 1.8, 1)}).outputs[0]
        tree.links.new(at, source.inputs["Vector"])
        self.assert_same("moved tiles")

    def test_a_picture_beside_tiles(self):
        spread(self.mesh, 2, 2)
        test_pictures.write_picture(self.path("marks.png"), (250, 250, 250), 32)
        tree = Tree(self.material)
        one = tree.add("TexImage", image=self.tiled(COLORS)).outputs["Color"]
        other = tree.add("TexImage", image=bpy.data.images.load(self.path("marks.png"))).outputs["Color"]
        mix = tree.add("Mix", {0: 1.0, 6: one, 7: other}, data_type="RGBA", blend_type="MULTIPLY").outputs[2]
        tree.links.new(mix, self.node.inputs["Base Color"])
        self.assert_same("beside tiles")

    def test_tiles_among_patterns(self):
        spread(self.mesh, 2, 2)
        tree = Tree(self.material)
        place = tree.add("TexCoord").outputs
        noise = tree.add("TexNoise", {"Vector": place["Object"], "Scale": 1.5}).outputs
        at = {
            "uv": place["UV"],
            "object": tree.add("VectorMath", {0: place["Object"], 1: (0.5, 0.5, 0), 2: (1, 1, 0)}, operation="MULTIPLY_ADD").outputs[0],
            "bent": tree.add("VectorMath", {0: noise["Color"], 1: (0.2, 0.2, 0), 2: place["UV"]}, operation="MULTIPLY_ADD").outputs[0],
        }
        image = self.tiled(COLORS)
        for name, coordinates in at.items():
            with self.subTest(name):
                source = tree.add("TexImage", {"Vector": coordinates}, image=image)
                mix = tree.add("Mix", {0: noise[0], 6: source.outputs["Color"], 7: (0.8, 0.8, 0.8, 1)}, data_type="RGBA").outputs[2]
                tree.links.new(mix, self.node.inputs["Base Color"])
                # what is bent beyond the tiles repeats here, and is magenta in Cycles
                self.assert_same(f"patterns {name}", 0.03 if name == "bent" else 0.01)

    def test_tiles_of_heights(self):
        # a lamp from the side shows the slopes, which are as steep in both directions
        self.lit(0.02)
        support.add(self.scene, "Sun", self.light("SUN", energy=3, angle=0.0), (0, 0, 5), (0.7, 0.7, 0))
        for vertex in self.mesh.vertices:
            vertex.co.y *= 0.5
        spread(self.mesh, 2, 1)
        side = np.linspace(0, 4 * np.pi, 256, endpoint=False)
        waves = ((np.sin(side)[:, None] + np.sin(side)[None, :]) * 60 + 128).astype(np.uint8)
        image = self.tiled({number: COLORS[number] for number in (1001, 1002)})
        for number in (1001, 1002):
            support.extension().export.files.write_png(self.path(f"tile.{number}.png"), np.repeat(waves[:, :, None], 3, axis=2))
        image.colorspace_settings.name = "Non-Color"
        image.reload()
        tree = Tree(self.material)
        source = tree.add("TexImage", image=image)
        bump = tree.add("Bump", {"Height": source.outputs["Color"], "Distance": 0.2})
        tree.links.new(bump.outputs[0], self.node.inputs["Normal"])
        ours, cycles = self.assert_same("heights", 0.02)
        spreads = [float(np.std(picture[16:-16, 10:-10, 0])) for picture in (ours, cycles)]
        self.assertGreater(spreads[1], 0.05, "it shows slopes")
        self.assertLess(abs(spreads[0] - spreads[1]), 0.1 * spreads[1])

    def frames(self, name, image, frames, **times):
        """Compares frames of an animation of the square that shows a movie or sequence with those of Cycles."""
        spread(self.mesh)
        user = shows(self.material, self.node, image).image_user
        user.use_auto_refresh = True
        for key, value in times.items():
            setattr(user, key, value)
        self.scene.frame_start, self.scene.frame_end = frames[0], frames[-1]
        self.scene.render.image_settings.file_format, self.scene.render.image_settings.color_depth = "OPEN_EXR", "32"
        self.scene.render.engine, self.scene.render.filepath = "AFTERIMAGE", self.path("ours_####")
        bpy.ops.render.render(animation=True)
        ours = [support.read_pixels(self.path(f"ours_{frame:04d}.exr")) for frame in frames]
        cycles = []
        for frame in frames:
            self.scene.frame_set(frame)
            # of the frame by itself, too
            alone, theirs = self.both()
            np.testing.assert_allclose(alone[:, :, :3].mean(axis=(0, 1)), theirs[:, :, :3].mean(axis=(0, 1)), atol=0.01)
            cycles.append(theirs)
        self.keep(name, np.concatenate(ours), np.concatenate(cycles))
        for frame, (one, other) in zip(frames, zip(ours, cycles)):
            self.assertLess(float(np.abs(one - other)[:, :, :3].mean()), 0.01, frame)
        return cycles

    def sequence(self):
        return test_pictures.sequence(self.scratch.name, list(COLORS.values())[:3], size=64)

    def test_a_sequence(self):
        cycles = self.frames("sequence", self.sequence(), range(1, 5), frame_duration=3)
        self.assertGreater(float(np.abs(cycles[0] - cycles[1]).mean()), 0.1)
        np.testing.assert_allclose(cycles[2].mean(), cycles[3].mean(), atol=0.01)

    def test_a_sequence_that_is_cyclic(self):
        cycles = self.frames("cycle", self.sequence(), range(2, 6), frame_duration=3, use_cyclic=True)
        np.testing.assert_allclose(cycles[0].mean(), cycles[3].mean(), atol=0.01)

    def test_a_sequence_with_a_start_and_an_offset(self):
        self.frames("offset", self.sequence(), range(1, 5), frame_duration=2, frame_start=2, frame_offset=1)

    def test_a_sequence_with_a_picture_that_is_missing(self):
        self.frames("missing frame", self.sequence(), range(2, 5), frame_duration=9)

    def test_a_sequence_without_auto_refresh(self):
        self.frames("still", self.sequence(), range(1, 4), frame_duration=3, use_auto_refresh=False)

    def test_a_world_of_a_sequence(self):
        bpy.data.objects.remove(self.item)
        tree = Tree(self.scene.world)
        source = tree.add("TexEnvironment", image=self.sequence())
        source.image_user.frame_duration = 3
        tree.links.new(source.outputs["Color"], tree.nodes["Background"].inputs["Color"])
        self.scene.camera.data.lens = 12
        support.add(self.scene, "Floor", support.grid("Floor", 2), (1, 1, 0))
        for frame in (1, 3):
            self.scene.frame_set(frame)
            self.assert_same(f"world {frame}", 0.02)

    def test_a_sequence_beside_tiles(self):
        self.mesh.uv_layers.new()
        spread(self.mesh, 2, 2)
        self.mesh.uv_layers.active_index = len(self.mesh.uv_layers) - 1
        self.mesh.uv_layers[-1].active_render = True
        shows(self.material, self.node, self.tiled(COLORS), "Emission Color")
        self.node.inputs["Emission Strength"].default_value = 0.5
        user = shows(self.material, self.node, self.sequence()).image_user
        user.frame_duration = 3
        for frame in (1, 3):
            self.scene.frame_set(frame)
            self.assert_same(f"beside tiles {frame}", 0.015)

    def test_a_movie(self):
        image = test_pictures.film(self.scratch.name, list(COLORS.values())[:3])
        if image is None:
            self.skipTest("this Blender writes no movies")
        spread_of = self.frames("movie", image, range(1, 5), frame_duration=3)
        self.assertGreater(float(np.abs(spread_of[0] - spread_of[1]).mean()), 0.1)


if __name__ == "__main__":
    unittest.main()

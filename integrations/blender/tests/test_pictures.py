# SPDX-License-Identifier: GPL-3.0-or-later
"""Tiles of UDIM, sequences and movies: what exports have of them. Needs bpy; the renderer is not asked."""

import os
import unittest

import bpy
import numpy as np
import support
import test_jobs
from support import Tree
from test_surfaces import principled, read_ply

COLORS = {1001: (230, 30, 20), 1002: (30, 200, 40), 1011: (20, 40, 220), 1012: (220, 200, 30)}
"""Of tiles."""


def write_picture(path, color, size=8):
    """Writes a picture of one colour with a dark quarter at its lower left, so that it shows how it lies."""
    pixels = np.empty((size, size, 3), dtype=np.uint8)
    pixels[:] = color
    pixels[size // 2 :, : size // 2] //= 4
    support.extension().export.files.write_png(path, pixels)


def tiled(folder, colors, name="tile", size=8):
    """An image of tiles of these colours, by their numbers."""
    for number, color in colors.items():
        write_picture(os.path.join(folder, f"{name}.{number}.png"), color, size)
    image = bpy.data.images.load(os.path.join(folder, f"{name}.{min(colors)}.png"))
    image.source, image.filepath = "TILED", os.path.join(folder, f"{name}.<UDIM>.png")
    for number in colors:
        if number not in [tile.number for tile in image.tiles]:
            image.tiles.new(number)
    return image


def sequence(folder, colors, name="frame", first=1, size=8):
    """An image of numbered files of these colours."""
    for number, color in enumerate(colors, first):
        write_picture(os.path.join(folder, f"{name}_{number:04d}.png"), color, size)
    image = bpy.data.images.load(os.path.join(folder, f"{name}_{first:04d}.png"))
    image.source = "SEQUENCE"
    return image


def film(folder, colors, name="film"):
    """A movie of frames of these colours. None where Blender writes no movies."""
    if not bpy.app.build_options.codec_ffmpeg:
        return None
    scene = bpy.data.scenes.new("Film")
    render = scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = 64, 32, 100
    scene.frame_start, scene.frame_end, scene.view_settings.view_transform = 1, len(colors), "Standard"
    editor = scene.sequence_editor_create()
    strips = editor.strips if hasattr(editor, "strips") else editor.sequences
    # its last argument is the length, or the end before Blender 5
    last = {"length": 1} if "length" in strips.bl_rna.functions["new_effect"].parameters else None
    for frame, color in enumerate(colors, 1):
        strip = strips.new_effect(name=f"{frame}", type="COLOR", channel=1, frame_start=frame, **(last or {"frame_end": frame + 1}))
        strip.color = [part / 255 for part in color]
    if hasattr(render.image_settings, "media_type"):
        render.image_settings.media_type = "VIDEO"
    render.image_settings.file_format = "FFMPEG"
    render.ffmpeg.format, render.ffmpeg.codec, render.ffmpeg.constant_rate_factor = "MPEG4", "H264", "PERC_LOSSLESS"
    render.filepath = os.path.join(folder, f"{name}.mp4")
    bpy.ops.render.render(animation=True, scene=scene.name)
    bpy.data.scenes.remove(scene)
    return bpy.data.images.load(os.path.join(folder, f"{name}.mp4"))


def spread(mesh, columns=1.0, rows=1.0, left=0.0, bottom=0.0):
    """Gives a square in the plane of X and Y texture coordinates."""
    points = np.array([mesh.vertices[loop.vertex_index].co[:2] for loop in mesh.loops])
    low, high = points.min(axis=0), points.max(axis=0)
    places = (points - low) / (high - low) * (columns, rows) + (left, bottom)
    mesh.uv_layers.new().data.foreach_set("uv", places.astype(np.float32).ravel())


def shows(material, node, image, socket="Base Color", **values):
    """Links a new image node to an input. Returns the node."""
    tree = Tree(material)
    source = tree.add("TexImage", image=image, **values)
    tree.links.new(source.outputs["Color"], node.inputs[socket])
    return source


class Tiles(support.ExportCase):
    def setUp(self):
        super().setUp()
        support.add_camera(self.scene)
        self.mesh = support.grid()
        self.material, self.node = principled("Tiled")
        self.mesh.materials.append(self.material)
        support.add(self.scene, "Square", self.mesh)

    def exported(self):
        """Exports the square. Returns the values of its material."""
        return self.export()["material"][0]

    def texels(self, name):
        """Bytes of a picture of the shot, the bottom row first."""
        image = bpy.data.images.load(os.path.join(self.folder, name), check_existing=False)
        values = np.array(image.pixels[:]).reshape(image.size[1], image.size[0], 4)
        bpy.data.images.remove(image)
        return (values[:, :, :3] * 255 + 0.5).astype(int)

    def uvs(self, shot):
        """Texture coordinates of the mesh, by x and y of its vertices."""
        _, vertices, _ = read_ply(os.path.join(self.folder, shot["model"][0]["ply"]))
        return {(round(float(row["x"])), round(float(row["y"]))): (float(row["s"]), float(row["t"])) for row in vertices}

    def test_tiles_are_one_picture_and_coordinates_cover_it(self):
        spread(self.mesh, 2, 2)
        shows(self.material, self.node, tiled(self.scratch.name, COLORS))
        shot = self.export()
        texels = self.texels(shot["material"][0]["map_kd"])
        self.assertEqual(texels.shape, (16, 16, 3))
        for number, (row, column) in {1001: (0, 0), 1002: (0, 8), 1011: (8, 0), 1012: (8, 8)}.items():
            np.testing.assert_allclose(texels[row + 7, column + 7], COLORS[number], atol=1)
            np.testing.assert_allclose(texels[row, column], np.array(COLORS[number]) // 4, atol=1)
        uvs = self.uvs(shot)
        np.testing.assert_allclose([uvs[-1, -1], uvs[1, 1]], [(0, 0), (1, 1)], atol=1e-6)
        self.assertEqual(self.warnings(), [])

    def test_a_mosaic_begins_where_the_first_tile_is(self):
        spread(self.mesh, 3, 1, left=1, bottom=1)
        shows(self.material, self.node, tiled(self.scratch.name, {1012: COLORS[1001], 1014: COLORS[1002]}))
        shot = self.export()
        texels = self.texels(shot["material"][0]["map_kd"])
        self.assertEqual(texels.shape, (8, 24, 3))
        # as Cycles shows what no tile has
        np.testing.assert_array_equal(texels[4, 12], (255, 0, 255))
        np.testing.assert_allclose([self.uvs(shot)[corner] for corner in ((-1, -1), (1, 1))], [(0, 0), (1, 1)], atol=1e-6)
        self.assertEqual(self.warnings(), [])

    def test_a_tile_without_a_file_is_told(self):
        spread(self.mesh, 2, 2)
        shows(self.material, self.node, tiled(self.scratch.name, COLORS))
        os.remove(os.path.join(self.scratch.name, "tile.1012.png"))
        texels = self.texels(self.exported()["map_kd"])
        np.testing.assert_array_equal(texels[12, 12], (255, 0, 255))
        self.assertEqual(len(self.warnings()), 1)
        self.assertRegex(self.warnings()[0], r"tile\.1012\.png.*Find Missing Files")

    def test_tiles_that_are_packed_or_not_saved_are_shown(self):
        spread(self.mesh, 2, 1)
        colors = {number: COLORS[number] for number in (1001, 1002)}
        image = tiled(self.scratch.name, colors)
        shows(self.material, self.node, image)
        image.pack()
        for number in colors:
            os.remove(os.path.join(self.scratch.name, f"tile.{number}.png"))
        np.testing.assert_allclose(self.texels(self.exported()["map_kd"])[7, [7, 15]], list(colors.values()), atol=1)
        if "save_copy" not in image.bl_rna.functions["save"].parameters:
            return
        painted = np.array(image.pixels[:], dtype=np.float32)
        painted.reshape(8, 8, 4)[:, :, :3] = 0.2, 0.4, 0.6
        image.pixels.foreach_set(painted)
        np.testing.assert_allclose(self.texels(self.exported()["map_kd"])[7, [7, 15]], [(51, 102, 153), colors[1002]], atol=1)
        self.assertEqual((self.warnings(), image.is_dirty), ([], True))

    def test_tiles_of_several_sizes_are_as_fine_as_the_finest(self):
        spread(self.mesh, 2, 1)
        write_picture(os.path.join(self.scratch.name, "tile.1002.png"), COLORS[1002], 32)
        image = tiled(self.scratch.name, {1001: COLORS[1001]})
        if 1002 not in [tile.number for tile in image.tiles]:
            image.tiles.new(1002)
        shows(self.material, self.node, image)
        texels = self.texels(self.exported()["map_kd"])
        self.assertEqual(texels.shape, (32, 64, 3))
        np.testing.assert_allclose(texels[31, [31, 63]], [COLORS[1001], COLORS[1002]], atol=1)

    def test_a_mosaic_has_no_more_texels_than_a_large_picture(self):
        spread(self.mesh, 2, 2)
        shows(self.material, self.node, tiled(self.scratch.name, COLORS))
        images = support.extension().export.images
        largest, images.LARGEST = images.LARGEST, 8
        try:
            texels = self.texels(self.exported()["map_kd"])
        finally:
            images.LARGEST = largest
        self.assertEqual(texels.shape, (8, 8, 3))
        np.testing.assert_allclose(texels[7, 7], COLORS[1012], atol=1)
        self.assertEqual(self.warnings(), ["image `tile.1001.png`: its tiles are made smaller, as 2x2 of them are one picture"])

    def test_pictures_beside_tiles_are_repeated_over_them(self):
        spread(self.mesh, 2, 1)
        shows(self.material, self.node, tiled(self.scratch.name, {number: COLORS[number] for number in (1001, 1002)}))
        write_picture(os.path.join(self.scratch.name, "rough.png"), (200, 200, 200))
        rough = bpy.data.images.load(os.path.join(self.scratch.name, "rough.png"))
        rough.colorspace_settings.name = "Non-Color"
        shows(self.material, self.node, rough, "Roughness")
        values = self.exported()
        texels = self.texels(values["map_pr"])
        np.testing.assert_array_equal(texels[:, :8], texels[:, 8:])
        self.assertEqual(texels.shape, (8, 16, 3))
        self.assertEqual(self.warnings(), [])

    def test_all_tiles_of_a_material_share_the_mosaic_of_all(self):
        spread(self.mesh, 2, 2)
        shows(self.material, self.node, tiled(self.scratch.name, {number: COLORS[number] for number in (1001, 1012)}))
        shows(self.material, self.node, tiled(self.scratch.name, {1002: COLORS[1002]}, "glow"), "Emission Color")
        self.node.inputs["Emission Strength"].default_value = 1.0
        values = self.exported()
        self.assertEqual([self.texels(values[key]).shape for key in ("map_kd", "map_ke")], [(16, 16, 3)] * 2)
        self.assertEqual(self.warnings(), [])

    def test_coordinates_beside_the_tiles_are_told(self):
        spread(self.mesh, 3, 1)
        shows(self.material, self.node, tiled(self.scratch.name, {number: COLORS[number] for number in (1001, 1002)}))
        self.exported()
        self.assertEqual(self.warnings(), ["mesh `Grid` has texture coordinates beside the tiles of material `Tiled`: tiles repeat there"])

    def test_the_other_mark_for_tiles_is_known(self):
        spread(self.mesh, 2, 2)
        image = tiled(self.scratch.name, COLORS)
        for number, mark in {1001: "u1_v1", 1002: "u2_v1", 1011: "u1_v2", 1012: "u2_v2"}.items():
            os.rename(os.path.join(self.scratch.name, f"tile.{number}.png"), os.path.join(self.scratch.name, f"tile.{mark}.png"))
        image.filepath = os.path.join(self.scratch.name, "tile.<UVTILE>.png")
        shows(self.material, self.node, image)
        np.testing.assert_allclose(self.texels(self.exported()["map_kd"])[15, 7], COLORS[1011], atol=1)
        self.assertEqual(self.warnings(), [])

    def test_nothing_of_ours_is_listed_or_saved(self):
        spread(self.mesh, 2, 2)
        shows(self.material, self.node, tiled(self.scratch.name, COLORS))
        self.exported()
        others = {data.name for data in (*bpy.data.images, *bpy.data.textures)} - {"tile.1001.png", "Render Result"}
        self.assertTrue(all(name.startswith(".") for name in others), others)
        path = os.path.join(self.scratch.name, "saved.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        bpy.ops.wm.open_mainfile(filepath=path)
        self.assertEqual({data.name for data in (*bpy.data.images, *bpy.data.textures)} - {"Render Result"}, {"tile.1001.png"})

    def test_reading_tiles_and_frames_again_tells_no_viewport_of_a_change(self):
        spread(self.mesh, 2, 2)
        shows(self.material, self.node, tiled(self.scratch.name, COLORS))
        shows(self.material, self.node, sequence(self.scratch.name, COLORS.values()), "Emission Color")
        images, told = support.extension().export.images, []
        graph = bpy.context.evaluated_depsgraph_get()
        bpy.context.view_layer.update()
        bpy.app.handlers.depsgraph_update_post.append(lambda scene, graph: told.extend(update.id.name for update in graph.updates))
        try:
            # what is ours is made by the first reading
            for _ in range(2):
                told.clear()
                read = images.Images(self.folder, support.extension().export.warnings.Warnings())
                for node in self.material.node_tree.nodes:
                    if node.type == "TEX_IMAGE":
                        self.assertIsNotNone(read.pixels(images.pictures.Pictures(read).of(node)))
                bpy.context.view_layer.update()
        finally:
            bpy.app.handlers.depsgraph_update_post.pop()
        self.assertEqual((told, list(graph.updates)), ([], []))


class Frames(test_jobs.FakeRenderer):
    """Sequences and movies."""

    REDS = (40, 90, 140, 190, 240)

    def setUp(self):
        super().setUp()
        spread(self.floor.data)
        self.material, self.node = principled("Film")
        self.floor.data.materials.append(self.material)
        self.files_at = {}

    def load(self, path):
        """Notes the red of the picture of the material, too."""
        shot = super().load(path)
        name = shot["material"][0].get("map_kd")
        if name:
            image = bpy.data.images.load(os.path.join(os.path.dirname(path), name), check_existing=False)
            shot["red"] = round(image.pixels[-4] * 255)
            bpy.data.images.remove(image)
        return shot

    def shows(self, image, length, **times):
        """Has the floor show a movie or sequence. Returns the node's user of the image."""
        user = shows(self.material, self.node, image).image_user
        user.frame_duration, user.use_auto_refresh = length, True
        for key, value in times.items():
            setattr(user, key, value)
        return user

    def numbers(self, count):
        return sequence(self.scratch.name, [(red, 100, 100) for red in self.REDS[:count]])

    def rendered(self, last):
        """Renders an animation. Returns the frames of each shot and the red that it shows."""
        self.scene.frame_end = last
        return list(zip(test_jobs.Jobs.rendered(self)[0], [shot.get("red") for shot in self.shots]))

    def test_each_frame_shows_its_picture(self):
        self.shows(self.numbers(3), 3)
        self.assertEqual(self.rendered(5), [("1", 40), ("2", 90), ("3-5", 140)])
        # nodes leave them as they are: files are copied
        self.assertEqual([shot["material"][0]["map_kd"] for shot in self.shots], [f"textures/frame_000{number}.png" for number in (1, 2, 3)])

    def test_a_cycle_goes_on(self):
        self.shows(self.numbers(2), 2, use_cyclic=True)
        self.assertEqual(self.rendered(4), [("1", 40), ("2", 90), ("3", 40), ("4", 90)])

    def test_start_and_offset_count(self):
        self.shows(self.numbers(4), 2, frame_start=3, frame_offset=2)
        self.assertEqual(self.rendered(5), [("1-2", 90), ("3", 140), ("4-5", 190)])

    def test_an_offset_may_be_animated(self):
        user = self.shows(self.numbers(5), 1)
        self.animate = test_jobs.Jobs.animate.__get__(self)
        self.animate(user, "frame_offset", 3, 3, 1)
        self.assertEqual(self.rendered(3), [("1-2", 190), ("3", 90)])

    def test_pictures_that_nodes_change_are_those_of_the_frame(self):
        user = self.shows(self.numbers(3), 3)
        tree = Tree(self.material)
        source = next(node for node in tree.nodes if node.type == "TEX_IMAGE")
        tree.links.new(tree.add("Gamma", {"Color": source.outputs["Color"], "Gamma": 1.5}).outputs[0], self.node.inputs["Base Color"])
        reds = [red for _, red in self.rendered(3)]
        self.assertEqual((user.frame_duration, len(reds), reds == sorted(set(reds))), (3, 3, True))

    def test_a_picture_that_is_missing_is_told(self):
        self.shows(self.numbers(2), 3)
        self.assertEqual(self.rendered(3), [("1", 40), ("2", 90), ("3", None)])
        self.assertEqual(self.shots[-1]["material"][0]["kd"], [1, 0, 1])

    def test_hold_materials_keeps_the_first_picture(self):
        self.scene.afterimage.hold = True
        self.shows(self.numbers(3), 3)
        self.scene.frame_end = 3
        frames, told = test_jobs.Jobs.rendered(self)
        self.assertEqual((frames, self.shots[0]["red"]), (["1-3"], 40))
        self.assertEqual(told, ["Afterimage: material `Film` is animated: frame 1 is shown"])

    def test_a_sequence_that_nothing_shows_is_no_change(self):
        Tree(self.material).add("TexImage", image=self.numbers(3)).image_user.frame_duration = 3
        self.assertEqual(self.rendered(3), [("1-3", None)])

    def test_stills_show_their_pictures(self):
        image = self.numbers(3)
        user = self.shows(image, 3)
        reds = []
        for frame in range(1, 4):
            self.scene.frame_set(frame)
            self.scene.render.filepath = os.path.join(self.scratch.name, "still.png")
            bpy.ops.render.render(write_still=True)
            reds.append(self.shots[-1]["red"])
        self.assertEqual(reds, [40, 90, 140])
        # what a script changes counts
        self.scene.frame_set(4)
        user.frame_offset = -1
        bpy.ops.render.render(write_still=True)
        self.assertEqual(self.shots[-1]["red"], 90)

    def test_movies_show_their_pictures(self):
        image = film(self.scratch.name, [(red, 100, 100) for red in self.REDS[:3]])
        if image is None:
            self.skipTest("this Blender writes no movies")
        user = self.shows(image, 3)
        self.assertEqual(user.frame_duration, 3)
        found = self.rendered(4)
        self.assertEqual([frames for frames, _ in found], ["1", "2", "3-4"])
        np.testing.assert_allclose([red for _, red in found], self.REDS[:3], atol=8)

    def test_names_of_files_are_those_of_blender(self):
        pictures = support.extension().export.pictures
        image = self.numbers(1)
        user = self.shows(image, 9)
        for path in ("/a/b.c/pic.png", "/a/x12y034z.tar.png", "/a/b12/pic", "/a/b/12.0034", "/a/p-5.png", "/a/007.exr"):
            image.filepath_raw = path
            for frame in (1, 8):
                self.scene.frame_set(frame)
                evaluated = self.material.evaluated_get(bpy.context.evaluated_depsgraph_get())
                there = next(node for node in evaluated.node_tree.nodes if node.type == "TEX_IMAGE").image_user
                self.assertEqual(pictures.numbered(path, frame), image.filepath_from_user(image_user=there))
        self.assertEqual(user.frame_start, 1)

    def test_numbers_of_frames_are_those_of_blender(self):
        pictures = support.extension().export.pictures
        image = self.numbers(1)
        user = self.shows(image, 9)
        for times in ((1, 5, 0, False), (3, 2, 10, True), (1, 0, 0, False), (5, 3, -1, False), (-2, 3, 1, True)):
            user.frame_start, user.frame_duration, user.frame_offset, user.use_cyclic = times
            clip = pictures.Clip.of(image, user)
            for frame in range(-4, 12):
                self.scene.frame_set(frame)
                evaluated = self.material.evaluated_get(bpy.context.evaluated_depsgraph_get())
                there = next(node for node in evaluated.node_tree.nodes if node.type == "TEX_IMAGE").image_user
                self.assertEqual(clip.number(frame), there.frame_current, (times, frame))


class Looks(unittest.TestCase):
    def test_what_a_picture_is_takes_no_look_at_its_pixels_unless_it_was_painted(self):
        support.empty()
        at_rest = support.extension().export.at_rest
        image = bpy.data.images.new("Large", 512, 512)
        image.pack()
        image.update()
        self.assertEqual(len(image.pixels), 4 * 512 * 512, "it is loaded")
        before = repr(at_rest.state_of_image(image))
        self.assertLess(len(before), 4000)
        image.pixels[0] = 0.5
        self.assertNotEqual(repr(at_rest.state_of_image(image)), before)


if __name__ == "__main__":
    unittest.main()

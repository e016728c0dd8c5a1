# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders by the engine, beside Cycles. Needs bpy and the renderer's Python module."""

import os
import unittest

import beside_cycles
import bpy
import numpy as np
import support


def middle_of(picture):
    """Column and row of the mean place of light."""
    rows, columns = np.mgrid[: picture.shape[0], : picture.shape[1]]
    light = picture[:, :, 0]
    return (columns * light).sum() / light.sum(), (rows * light).sum() / light.sum()


class Render(beside_cycles.BesideCycles):
    def assert_same_framing(self):
        """Three squares in different places must cover the same pixels, but for rims."""
        for index, place in enumerate([(0.3, 0, 0.2), (-0.7, 0.5, 0.5), (0.8, 1, -0.6)]):
            self.bright(f"square {index}", 0.4, place)
        self.scene.afterimage.samples = 8
        ours, cycles = self.both(256)
        self.assertGreater((cycles[:, :, 0] > 0.5).sum(), 20)
        np.testing.assert_allclose(middle_of(ours), middle_of(cycles), atol=0.05, err_msg="the middle of all squares, in pixels")
        different = np.abs(ours[:, :, 0] - cycles[:, :, 0])
        self.assertLess(different.max(), 0.2, "coverage of a pixel by an edge")
        self.assertLess(abs(ours[:, :, 0].sum() / cycles[:, :, 0].sum() - 1), 0.01)

    def test_shift_moves_the_picture_as_in_cycles(self):
        support.add_camera(self.scene, shift_x=0.12, shift_y=-0.07, lens=35)
        self.assert_same_framing()

    def test_the_sensor_fits_upright(self):
        support.add_camera(self.scene, sensor_fit="VERTICAL", sensor_height=30, lens=40, shift_x=0.1, shift_y=0.05)
        self.assert_same_framing()

    def test_the_sensor_fits_across_in_an_upright_picture(self):
        self.scene.render.resolution_x, self.scene.render.resolution_y = 48, 80
        support.add_camera(self.scene, sensor_fit="HORIZONTAL", lens=30, shift_y=0.1)
        self.assert_same_framing()

    def test_an_orthographic_camera_that_is_rolled(self):
        support.add_camera(self.scene, turn=(np.pi / 2, 0.3, 0.1), type="ORTHO", ortho_scale=4, shift_x=0.05)
        self.assert_same_framing()

    def test_what_is_no_camera_sees_as_in_cycles(self):
        lamps = {kind: bpy.data.lights.new(kind, kind) for kind in ("SPOT", "AREA", "SUN")}
        lamps["SPOT"].spot_size = 0.5
        for lamp in lamps.values():
            lamp.energy = 0
        for name, data in {"Empty": None, "Mesh": bpy.data.meshes.new("None"), **lamps}.items():
            with self.subTest(name):
                self.scene.camera = support.add(self.scene, name, data, (0.1, -5, 0.2), (np.pi / 2, 0.1, 0))
                self.assert_same_framing()
                for square in [item for item in self.scene.objects if item.name.startswith("square")]:
                    bpy.data.objects.remove(square)

    def test_point(self):
        self.assert_same_brightness(self.light("POINT", energy=200, shadow_soft_size=0))

    def test_point_with_radius(self):
        self.assert_same_brightness(self.light("POINT", energy=200, shadow_soft_size=0.3))

    def test_sun(self):
        self.assert_same_brightness(self.light("SUN", energy=3, angle=0.05))

    def test_spot(self):
        self.assert_same_brightness(self.light("SPOT", energy=300, spot_size=1.0, spot_blend=0.3, shadow_soft_size=0))

    def test_spot_with_radius(self):
        self.assert_same_brightness(self.light("SPOT", energy=300, spot_size=1.0, spot_blend=0.3, shadow_soft_size=0.4))

    def test_area_square(self):
        self.assert_same_brightness(self.light("AREA", energy=100, shape="SQUARE", size=0.8))

    def test_area_rectangle(self):
        self.assert_same_brightness(self.light("AREA", energy=100, shape="RECTANGLE", size=1.2, size_y=0.4))

    def test_area_disk(self):
        self.assert_same_brightness(self.light("AREA", energy=100, shape="DISK", size=0.8))

    def test_area_ellipse(self):
        self.assert_same_brightness(self.light("AREA", energy=100, shape="ELLIPSE", size=1.0, size_y=0.6))

    def test_area_with_a_spread(self):
        self.assert_same_brightness(self.light("AREA", energy=100, shape="RECTANGLE", size=1.2, size_y=0.4, spread=1.6))

    def test_ellipse_with_a_narrow_spread(self):
        self.assert_same_brightness(self.light("AREA", energy=30, shape="ELLIPSE", size=1.0, size_y=2.0, spread=0.7))

    def test_a_sky_with_its_sun_lights_as_in_cycles(self):
        self.scene.world = bpy.data.worlds.new("Sky")
        self.scene.world.use_nodes = True
        tree = self.scene.world.node_tree
        node = tree.nodes.new("ShaderNodeTexSky")
        node.sun_elevation, node.sun_rotation = 0.6, 0.9
        tree.links.new(node.outputs[0], tree.nodes["Background"].inputs["Color"])
        self.scene.afterimage.paths = 64
        material = bpy.data.materials.new("Matt")
        material.use_nodes = True
        material.node_tree.nodes["Principled BSDF"].inputs["Specular IOR Level"].default_value = 0
        mesh = support.grid("Floor", 10)
        mesh.materials.append(material)
        support.add(self.scene, "Floor", mesh)
        support.add_camera(self.scene, (0, 0, 6), (0, 0, 0))
        ours, cycles = self.both(256)
        np.testing.assert_allclose(ours[:, :, :3].mean(axis=(0, 1)) / cycles[:, :, :3].mean(axis=(0, 1)), 1, atol=0.03)

    def test_both_eyes_are_those_of_cycles(self):
        stereo = support.add_camera(self.scene, shift_x=0.05).data.stereo
        stereo.pivot, stereo.interocular_distance, stereo.convergence_distance = "CENTER", 0.5, 3
        self.bright("near", 0.5, (0.2, 0, 0.2))
        self.bright("far", 0.3, (-0.6, 1, -0.3))
        self.scene.afterimage.samples = 8
        render = self.scene.render
        render.use_multiview, render.image_settings.views_format = True, "INDIVIDUAL"
        render.image_settings.file_format = "HDR"  # see test_jobs
        self.scene.cycles.samples, self.scene.cycles.use_denoising = 64, False
        self.scene.cycles.pixel_filter_type, self.scene.cycles.filter_width = "BOX", 1.0
        for mode in ("OFFAXIS", "TOE"):
            stereo.convergence_mode = mode
            for engine in ("AFTERIMAGE", "CYCLES"):
                render.engine, render.filepath = engine, self.path(f"{engine}.hdr")
                bpy.ops.render.render(write_still=True)
            for side in "LR":
                ours, cycles = (support.read_pixels(self.path(f"{engine}_{side}.hdr")) for engine in ("AFTERIMAGE", "CYCLES"))
                np.testing.assert_allclose(middle_of(ours), middle_of(cycles), atol=0.05, err_msg=f"{mode} {side}")

    def test_exposure_and_a_world_for_the_camera_are_those_of_cycles(self):
        support.add_camera(self.scene, (0, 0, 5), (0, 0, 0))
        support.add(self.scene, "Floor", support.grid(size=1.0))
        self.scene.world = bpy.data.worlds.new("World")
        self.scene.world.use_nodes = True
        tree = self.scene.world.node_tree
        lights, mix, path, camera = tree.nodes["Background"], *(tree.nodes.new(f"ShaderNode{kind}") for kind in ("MixShader", "LightPath", "Background"))
        lights.inputs["Color"].default_value, camera.inputs["Color"].default_value = (0, 0, 1, 1), (1, 0, 0, 1)
        for output, socket in ((path.outputs["Is Camera Ray"], mix.inputs[0]), (lights.outputs[0], mix.inputs[1]), (camera.outputs[0], mix.inputs[2])):
            tree.links.new(output, socket)
        tree.links.new(mix.outputs[0], tree.nodes["World Output"].inputs["Surface"])
        self.scene.cycles.film_exposure = 1.5
        self.scene.afterimage.paths = 64
        ours, cycles = self.both(64)
        np.testing.assert_allclose(ours[0, 0], [1.5, 0, 0, 1], atol=1e-3)
        for place in (np.s_[:4, :4], np.s_[20:28, 28:36]):
            np.testing.assert_allclose(ours[place].mean(axis=(0, 1)), cycles[place].mean(axis=(0, 1)), atol=0.02)

    def travel(self):
        """A camera that moves to the side over a floor, in four frames."""
        self.scene.frame_end = 4
        camera = support.add_camera(self.scene, (0, -5, 1))
        for frame, x in ((1, 0.0), (4, 0.2)):
            camera.location.x = x
            camera.keyframe_insert("location", frame=frame)
        support.add(self.scene, "Floor", support.grid(size=6, count=4))
        self.scene.world = bpy.data.worlds.new("World")
        self.scene.afterimage.mode = "reproject"

    def noted(self, render):
        """Calls a function that renders. Returns the number of exports, and of each frame its number and how many samples it has kept."""
        session = support.extension().session
        exports, frames = [], []
        export, frame = session.export, session.Job.frame
        session.export = lambda *values: exports.append(1) or export(*values)

        def noted(job, *values):
            made = frame(job, *values)
            frames.append((made.number, made.stats["samples"]["good"] + made.stats["samples"]["overlapped"]))
            return made

        session.Job.frame = noted
        try:
            render()
        finally:
            session.export, session.Job.frame = export, frame
        return len(exports), frames

    def test_an_animation_reuses_samples_and_is_exported_once(self):
        self.travel()
        self.scene.render.filepath = self.path("f.####")
        exports, frames = self.noted(lambda: bpy.ops.render.render(animation=True))
        self.assertEqual(exports, 1)
        self.assertEqual([number for number, _ in frames], [1, 2, 3, 4])
        self.assertEqual(frames[0][1], 0)
        self.assertTrue(all(kept > 1000 for _, kept in frames[1:]), frames)
        self.assertEqual(support.extension().session._jobs, {})

    def test_stills_in_a_row_reuse_samples_and_show_what_each_shows_by_itself(self):
        self.travel()
        self.bright("square", 0.6, (0, 0, 0.4), 2.0)
        pictures = []

        def stills():
            for frame in range(1, 5):
                self.scene.frame_set(frame)
                pictures.append(support.render(self.scene, self.path("still.exr")))

        exports, frames = self.noted(stills)
        self.assertEqual((exports, [number for number, _ in frames]), (1, [1, 2, 3, 4]))
        self.assertEqual([kept > 1000 for _, kept in frames], [False, True, True, True])
        self.scene.afterimage.mode = "full"
        alone = support.render(self.scene, self.path("alone.exr"))
        np.testing.assert_allclose(pictures[-1].mean(axis=(0, 1)), alone.mean(axis=(0, 1)), atol=2e-3)
        self.assertGreater(np.abs(pictures[0] - alone).max(), 0.1)
        self.assertLess(np.abs(pictures[-1] - alone).mean(), 0.2 * np.abs(pictures[0] - alone).mean())

    def test_a_render_region_shows_a_part_of_the_picture(self):
        support.add_camera(self.scene)
        self.bright("square", 1.0, (0.2, 0, 0.1))
        whole = support.render(self.scene, self.path("whole.exr"))
        render = self.scene.render
        render.use_border, render.use_crop_to_border = True, True
        render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.25, 0.5
        part = support.render(self.scene, self.path("part.exr"))
        self.assertEqual(part.shape[:2], (12, 32))
        np.testing.assert_allclose(part, whole[24:36, 16:48], atol=1e-3)
        render.use_crop_to_border = False
        placed = support.render(self.scene, self.path("placed.exr"))
        np.testing.assert_allclose(placed[24:36, 16:48], whole[24:36, 16:48], atol=1e-3)

    def test_cancelling_ends_the_job_and_removes_its_files(self):
        self.scene.frame_end = 8
        support.add_camera(self.scene)
        support.add(self.scene, "Floor", support.grid()).modifiers.new("Wave", "WAVE")
        module = support.extension()
        folders, make = [], module.session.tempfile.mkdtemp
        asked = []
        self.scene.render.filepath = self.path("f.####")
        module.session.tempfile.mkdtemp = lambda **values: folders.append(make(**values)) or folders[-1]
        cancelled = module.session.is_cancelled
        module.session.is_cancelled = lambda engine: asked.append(1) or len(asked) > 4
        try:
            bpy.ops.render.render(animation=True)
        finally:
            module.session.is_cancelled = cancelled
            module.session.tempfile.mkdtemp = make
        self.assertGreater(len(asked), 4)
        self.assertEqual({os.path.exists(folder) for folder in folders}, {False})
        self.assertEqual(module.session._jobs, {})

    def test_without_a_camera_blender_gets_an_error(self):
        with self.assertRaisesRegex(RuntimeError, "(?i)camera"):
            bpy.ops.render.render()

    def test_passes_are_those_of_cycles(self):
        support.add_camera(self.scene)
        self.bright("square", 1.0, (0, 0.5, 0))
        view_layer = self.scene.view_layers[0]
        for flag in ("z", "position", "normal", "emit", "cryptomatte_object"):
            setattr(view_layer, f"use_pass_{flag}", True)
        found = {}
        passes = support.extension().passes
        put = passes.put

        def noted(slot, pixels):
            found[slot.name] = np.array(pixels)
            put(slot, pixels)

        passes.put = noted
        try:
            support.render(self.scene, self.path("ours.exr"))
        finally:
            passes.put = put
        middle = self.scene.render.resolution_y // 2, self.scene.render.resolution_x // 2
        self.assertAlmostEqual(float(found["Depth"][middle][0]), 5.5, places=3)
        np.testing.assert_allclose(found["Position"][middle][1], 0.5, atol=1e-3)
        np.testing.assert_allclose(found["Normal"][middle], [0, -1, 0], atol=1e-2)
        emitted = found.get("Emission", found.get("Emit"))
        np.testing.assert_allclose(emitted[middle], [1, 1, 1], atol=1e-2)
        hashed = support.extension().hashing.murmur3(b"square", as_float=True)
        self.assertEqual(int(found["CryptoObject00"][middle][0].view(np.uint32)), hashed)

    def test_the_hash_is_cryptomattes(self):
        self.assertEqual(support.extension().hashing.murmur3(b"torus"), 4053562365)


if __name__ == "__main__":
    unittest.main()

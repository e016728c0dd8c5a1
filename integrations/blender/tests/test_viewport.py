# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of viewports, without a window. Needs bpy and the renderer's Python module."""

import os
import time
import types

import beside_cycles
import bpy
import mathutils
import numpy as np
import support


def middle_of(light):
    """Column and row of the mean place of light, from 0 to 1."""
    rows, columns = np.mgrid[: light.shape[0], : light.shape[1]] + 0.5
    return [(columns * light).sum() / light.sum() / light.shape[1], (rows * light).sum() / light.sum() / light.shape[0]]


class Viewports(beside_cycles.BesideCycles):
    def setUp(self):
        super().setUp()
        self.viewport = support.extension().viewport
        self.bright("square", 0.5, (0.4, 0, 0.3))
        self.bright("other", 0.3, (-0.6, 0.5, -0.4))
        self.exports = []
        self.export_shot = self.viewport.export_shot
        self.viewport.export_shot = lambda *values: self.exports.append(1) or self.export_shot(*values)

    def tearDown(self):
        self.viewport.export_shot = self.export_shot
        super().tearDown()

    def view(self, camera):
        """The view through a camera, as a region of the picture's size has it."""
        graph = bpy.context.evaluated_depsgraph_get()
        size = self.scene.render.resolution_x, self.scene.render.resolution_y
        matrices = camera.matrix_world.inverted(), camera.calc_matrix_camera(graph, x=size[0], y=size[1])
        region = types.SimpleNamespace(width=size[0], height=size[1])
        return self.viewport.View.of(region, types.SimpleNamespace(view_matrix=matrices[0], window_matrix=matrices[1]))

    def assert_view_is_the_render(self, **values):
        camera = support.add_camera(self.scene, (0.3, -5, 0.2), (np.pi / 2 - 0.1, 0.2, 0.05), **values)
        self.scene.afterimage.samples = 4
        rendered = support.render(self.scene, self.path("ours.exr"))[:, :, 0]
        preview = self.viewport.Preview()
        try:
            view = self.view(camera)
            preview.update(self.scene, bpy.context.evaluated_depsgraph_get(), view)
            pixels = preview.picture(view)
        finally:
            preview.close()
        self.assertEqual(pixels.shape, (48, 64, 4))
        self.assertGreater(rendered.sum(), 10)
        np.testing.assert_allclose(pixels[::-1, :, 0], rendered, atol=0.02)
        self.assertFalse(os.path.exists(preview.folder))

    def test_a_view_through_a_camera_is_its_render(self):
        self.assert_view_is_the_render(lens=60, shift_x=0.1, shift_y=-0.05)

    def test_an_orthographic_view_is_its_render(self):
        self.assert_view_is_the_render(type="ORTHO", ortho_scale=3, shift_x=0.1, shift_y=0.05)

    def test_an_orthographic_view_shows_what_is_behind_its_eye(self):
        camera = support.add_camera(self.scene, (0, 1, 0), type="ORTHO", ortho_scale=3)
        self.scene.camera = None
        near, far = -10.0, 10.0
        window = mathutils.Matrix([[2 / 3, 0, 0, 0], [0, 2 / 2.25, 0, 0], [0, 0, -2 / (far - near), -(far + near) / (far - near)], [0, 0, 0, 1]])
        bpy.context.view_layer.update()
        matrices = types.SimpleNamespace(view_matrix=camera.matrix_world.inverted(), window_matrix=window)
        view = self.viewport.View.of(types.SimpleNamespace(width=64, height=48), matrices)
        preview = self.viewport.Preview()
        try:
            preview.update(self.scene, bpy.context.evaluated_depsgraph_get(), view)
            self.assertGreater(preview.picture(view)[:, :, 0].max(), 0.9)
        finally:
            preview.close()

    def shown(self, viewport, view, seconds=60):
        """Asks for a view until its last picture is there; returns all pictures."""
        pictures, ends = [], time.monotonic() + seconds
        while time.monotonic() < ends:
            pixels, goes_on, messages = viewport.show(self.scene, bpy.context.evaluated_depsgraph_get(), view)
            self.assertEqual(messages, [])
            if pixels is not None and (not pictures or pictures[-1] is not pixels):
                pictures.append(pixels)
            if not goes_on:
                return pictures
            time.sleep(0.01)
        self.fail("no picture came")

    def test_pictures_get_finer_and_only_changes_of_the_scene_are_exported(self):
        camera = support.add_camera(self.scene)
        bpy.context.view_layer.update()
        viewport = self.viewport.Viewport()
        folder = viewport.work.preview.folder
        try:
            first = self.view(camera)
            pictures = self.shown(viewport, first)
            self.assertEqual(pictures[-1].shape, (48, 64, 4))
            before = middle_of(pictures[-1][:, :, 0])
            # the view alone
            camera.location.x += 0.3
            bpy.context.view_layer.update()
            moved = self.shown(viewport, self.view(camera))[-1]
            self.assertLess(middle_of(moved[:, :, 0])[0], before[0] - 0.03)
            self.assertEqual(len(self.exports), 1)
            # the scene
            bpy.data.objects["square"].location.z -= 0.3
            bpy.context.view_layer.update()
            viewport.change()
            changed = self.shown(viewport, self.view(camera))[-1]
            self.assertEqual(len(self.exports), 2)
            self.assertLess(middle_of(changed[:, :, 0])[1], middle_of(moved[:, :, 0])[1] - 0.03)
        finally:
            viewport.close()
        ends = time.monotonic() + 20
        while os.path.exists(folder) and time.monotonic() < ends:
            time.sleep(0.02)
        self.assertFalse(os.path.exists(folder))

    def test_the_engine_draws_what_the_viewport_shows(self):
        camera = support.add_camera(self.scene)
        bpy.context.view_layer.update()
        drawn, said = [], []
        draw, kept = self.viewport.draw, bpy.app.timers.register
        region = types.SimpleNamespace(width=64, height=48)
        graph = bpy.context.evaluated_depsgraph_get()
        matrices = types.SimpleNamespace(view_matrix=camera.matrix_world.inverted(), window_matrix=camera.calc_matrix_camera(graph, x=64, y=48))
        context = types.SimpleNamespace(region=region, region_data=matrices)
        engine = types.SimpleNamespace(viewport=None, update_stats=lambda *values: said.append(values))
        kind = support.extension().engine.AfterimageEngine
        self.viewport.draw = lambda engine, scene, pixels, size: drawn.append((pixels, size))
        bpy.app.timers.register = lambda function, first_interval: function()
        try:
            kind.view_update(engine, context, graph)
            ends = time.monotonic() + 60
            while time.monotonic() < ends and not (drawn and drawn[-1][0].shape[0] == 48):
                kind.view_draw(engine, context, graph)
                time.sleep(0.02)
        finally:
            self.viewport.draw, bpy.app.timers.register = draw, kept
            engine.viewport.close()
        self.assertEqual((said, drawn[-1][1]), ([], (64, 48)))
        self.assertGreater(drawn[-1][0][:, :, 0].max(), 0.9)

# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture in a viewport: a plain preview, coarse at first.

`Preview` exports the scene and makes pictures of views. It needs no window, and exports nothing when the view alone changes. `Viewport`
has a thread that renders the view that was asked for last, and `draw` shows a picture in a region.
"""

import dataclasses
import math
import os
import shutil
import tempfile
import threading
import time

import bpy
import numpy as np

from . import session
from .export import export_shot, with_camera
from .export.camera import TO_Y_UP, rotation_of

LEVELS = ((0.25, 1), (1.0, 1), (1.0, 2), (1.0, 4))
"""Pictures of a view that follow each other: the share of its size, and N for N x N samples in a pixel."""
PATHS, REFLECTIONS = 4, 4
"""The most of both that each sample of a preview has."""
REST = 0.2
"""Seconds without a change of the scene after which it is exported."""


@dataclasses.dataclass(frozen=True)
class View:
    """Camera and size of a region."""

    size: tuple
    """Pixels."""
    view: tuple
    """World to camera, by rows, in Blender's axes."""
    window: tuple
    """Camera to clip space, by rows."""

    @classmethod
    def of(cls, region, region_3d):
        """The view of a region of a 3D viewport."""
        rows = (tuple(value for row in matrix for value in row) for matrix in (region_3d.view_matrix, region_3d.window_matrix))
        return cls((region.width, region.height), *rows)

    def camera(self):
        """The projection, and the values of a [[camera.key]]."""
        place = np.linalg.inv(np.array(self.view, dtype=float).reshape(4, 4))
        window = np.array(self.window, dtype=float).reshape(4, 4)
        axes = TO_Y_UP[:3, :3] @ place[:3, :3]
        axes /= np.linalg.norm(axes, axis=0)
        eye = (TO_Y_UP @ place[:, 3])[:3]
        share = np.array(self.size) / max(self.size) / 2
        key = {"rotation": rotation_of(axes)}
        if window[3, 3] == 0:
            key["fov"] = math.degrees(2 * math.atan(1 / window[1, 1]))
            shift = window[:2, 2] * share
        else:
            # a viewport shows what is behind its eye as well, as far as its clipping says
            eye = eye + axes[:, 2] * max(0.0, (-1 - window[2, 3]) / window[2, 2])
            key["height"] = 2 / window[1, 1]
            shift = -window[:2, 3] * share
        return "perspective" if window[3, 3] == 0 else "orthographic", {"eye": eye.tolist(), **key, "shift": shift.tolist()}


class Preview:
    """A scene as it was exported last, and pictures of it."""

    def __init__(self):
        self.module = session.renderer()
        # removed at the latest when Blender ends
        self.scratch = tempfile.TemporaryDirectory(prefix="afterimage-view-", ignore_cleanup_errors=True)
        self.folder = self.scratch.name
        self.count, self.exported, self.threads = 0, None, None

    def update(self, scene, depsgraph, view):
        """Exports the scene as it is. Returns what was replaced, as messages."""
        messages = []
        settings = session.settings_of(scene, [depsgraph.view_layer], [scene.frame_current], messages.append, has_error=False)
        render = {**settings.render, "reflections": min(REFLECTIONS, settings.render["reflections"]), "mode": "full"}
        indirect = {**settings.indirect, "paths": min(PATHS, settings.indirect["paths"])}
        settings = dataclasses.replace(settings, render=render, indirect=indirect, output={}, shutter=None, camera=view.camera())
        self.threads = scene.render.threads if scene.render.threads_mode == "FIXED" else None
        # the one before may be read at this moment; those before that are not
        shutil.rmtree(self._folder(self.count - 1), ignore_errors=True)
        self.count += 1
        self.exported = export_shot(scene, depsgraph, self._folder(self.count), settings, lambda frame, subframe: None, lambda share: True)
        return [*messages, *self.exported.warnings]

    def _folder(self, count):
        return os.path.join(self.folder, str(count))

    def picture(self, view, level=LEVELS[-1], goes_on=lambda: True):
        """Linear pixels of a view, (height, width, 4), the bottom row first; None if `goes_on` returned false."""
        share, samples = level
        exported = self.exported
        path = os.path.join(os.path.dirname(exported.path), "view.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(with_camera(exported.parts, *view.camera()))
        size = tuple(max(1, round(side * share)) for side in view.size)
        extra = {"threads": self.threads} if self.threads else {}
        scene = self.module.load(path)
        try:
            frames = self.module.render(scene, size=size, samples=samples, progress=lambda frame, done: goes_on(), **extra)
            return np.ascontiguousarray(next(frames).layers["RGBA"][::-1])
        except self.module.Cancelled:
            return None

    def close(self):
        """Removes its files."""
        self.scratch.cleanup()


class _Work:
    """State that a viewport and its thread share: the thread has no way to the viewport, which ends it."""

    def __init__(self, preview):
        self.preview, self.changed = preview, threading.Condition()
        self.wanted, self.made, self.error, self.is_over = None, None, None, False

    def run(self):
        """Renders the view that is wanted, level by level, until another one is."""
        while True:
            with self.changed:
                self.changed.wait_for(lambda: self.is_over or (self.wanted and self._level() is not None))
                if self.is_over:
                    break
                wanted, level = self.wanted, self._level()
            try:
                pixels = self.preview.picture(wanted[0], LEVELS[level], lambda: self.wanted == wanted and not self.is_over)
            except Exception as error:  # noqa: BLE001  the viewport says it
                pixels, self.error = None, str(error)
            with self.changed:
                if self.error is not None:
                    self.wanted = None
                elif pixels is not None:
                    self.made = (wanted, level, pixels)
        self.preview.close()

    def _level(self):
        """The level that comes next for what is wanted; None if all are made."""
        if self.made is None or self.made[0] != self.wanted:
            return 0
        return self.made[1] + 1 if self.made[1] + 1 < len(LEVELS) else None


class Viewport:
    """The pictures of one viewport."""

    def __init__(self):
        self.work = _Work(Preview())
        self.changed_at = -math.inf
        self.is_stale = True
        threading.Thread(target=self.work.run, name="afterimage-viewport", daemon=True).start()

    def change(self):
        """Notes that the scene has changed."""
        self.is_stale, self.changed_at = True, time.monotonic()

    def show(self, scene, depsgraph, view):
        """The newest pixels for a view (None: there are none yet), whether more will come, and messages of an export."""
        messages, work = [], self.work
        if self.is_stale and time.monotonic() - self.changed_at >= REST:
            with work.changed:
                work.wanted = None
            messages = work.preview.update(scene, depsgraph, view)
            self.is_stale, work.error = False, None
        with work.changed:
            if not self.is_stale and work.error is None:
                work.wanted = (view, work.preview.count)
                work.changed.notify()
            made, error = work.made, work.error
        if error is not None:
            messages.append(error)
        is_last = made is not None and made[0] == work.wanted and made[1] == len(LEVELS) - 1
        return made[2] if made else None, self.is_stale or (error is None and not is_last), messages

    def __del__(self):
        self.close()

    def close(self):
        """Ends the thread, which removes the files."""
        with self.work.changed:
            self.work.is_over = True
            self.work.changed.notify()


def draw(engine, scene, pixels, size):
    """Draws pixels over a region of this size, through the scene's view transform."""
    import gpu
    from gpu_extras.presets import draw_texture_2d

    height, width = pixels.shape[:2]
    texture = gpu.types.GPUTexture((width, height), format="RGBA16F", data=gpu.types.Buffer("FLOAT", pixels.size, pixels.ravel()))
    gpu.state.blend_set("ALPHA_PREMULT")
    engine.bind_display_space_shader(scene)
    draw_texture_2d(texture, (0, 0), *size)
    engine.unbind_display_space_shader()
    gpu.state.blend_set("NONE")


def redraw():
    """Draws all rendered viewports again; a timer calls it, once."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D" and any(space.type == "VIEW_3D" and space.shading.type == "RENDERED" for space in area.spaces):
                area.tag_redraw()

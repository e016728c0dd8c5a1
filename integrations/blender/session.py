# SPDX-License-Identifier: GPL-3.0-or-later
"""A render job: the shot of all its frames, exported once, and the renderer that goes from frame to frame.

Blender asks an engine for one frame at a time, and makes a new engine for each. What is reused lives here, from the handler
`render_init`, which begins a job, to `render_complete` or `render_cancel`. So a scene that changes between jobs is exported anew.
"""

import dataclasses
import fractions
import itertools
import shutil
import tempfile

import bpy

from . import passes
from .export import Settings, export_shot
from .export.camera import camera_at

_jobs = {}
_told = set()
"""Warnings of these jobs: each is told once, and not for each eye again."""
export_folder = None
"""Where "Export shot" wants the shot: then the engine exports and renders nothing."""
exported = None
"""What was exported there."""


class MissingRenderer(Exception):
    """The Python module is not installed."""


def renderer():
    """The Python module that renders."""
    try:
        import afterimage
    except ImportError as error:
        raise MissingRenderer(
            f"the renderer is not installed ({error}): install an extension that carries it, or the wheel `afterimage_renderer` for"
            " Blender's Python. File > Export > Afterimage Shot works without it"
        ) from error
    return afterimage


def is_cancelled(engine):
    """Returns true if the user has pressed Esc."""
    return engine.test_break()


def size_of(scene):
    """Size of the whole picture in pixels."""
    share = scene.render.resolution_percentage / 100
    return max(1, int(scene.render.resolution_x * share)), max(1, int(scene.render.resolution_y * share))


def crop_of(scene):
    """Column, row from the top, width and height of the render region; None for the whole picture."""
    render = scene.render
    if not render.use_border:
        return None
    width, height = size_of(scene)
    left, right = int(render.border_min_x * width), int(render.border_max_x * width)
    bottom, top = int(render.border_min_y * height), int(render.border_max_y * height)
    if right <= left or top <= bottom:
        return None
    return left, height - top, right - left, top - bottom


def shutter_of(scene):
    """When the shutter opens and closes, in frames; None without motion blur."""
    render = scene.render
    if not render.use_motion_blur or render.motion_blur_shutter <= 0:
        return None
    length = min(1.0, render.motion_blur_shutter)
    begins = {"START": 0.0, "CENTER": -length / 2, "END": -length}[render.motion_blur_position]
    return begins, begins + length


def settings_of(scene, view_layer, frames, warn):
    """The export's settings of a scene."""
    own = scene.afterimage
    if abs(scene.render.pixel_aspect_x - scene.render.pixel_aspect_y) > 1e-4:
        warn("pixels that are not square are rendered square: set the aspect to 1")
    if scene.render.use_motion_blur and scene.render.motion_blur_shutter > 1:
        warn("a shutter longer than a frame is made one frame long")
    rate = fractions.Fraction(scene.render.fps) / fractions.Fraction(scene.render.fps_base).limit_denominator(100000)
    rate = rate.limit_denominator(1001)
    render = {"samples": own.samples, "depth": own.depth, "reflections": own.reflections, "mode": own.mode, "base_every": own.base_every}
    # as Blender's box of one pixel, but that samples need not lie in the centres of their cells
    render.update(exposures=own.exposures, caustics="paths" if own.caustics else "none", filter="area")
    # the exposure of the film is a setting of Cycles, which counts for its limits as well
    exposure = getattr(getattr(scene, "cycles", None), "film_exposure", 1.0)
    if own.clamp > 0 and exposure > 0:
        render["clamp"] = own.clamp * exposure
    return Settings(
        frames=frames,
        size=size_of(scene),
        rate=rate.numerator if rate.denominator == 1 else f"{rate.numerator}/{rate.denominator}",
        render=render,
        indirect={"paths": own.paths, "bounces": own.bounces},
        output={"layers": passes.layers(scene, view_layer), "denoise": own.denoise},
        shutter=shutter_of(scene),
        transparent=scene.render.film_transparent,
        shadow_rays=int(own.shadow_rays),
        exposure=exposure,
    )


def frames_of(scene, is_animation):
    """Frames of the job, rising."""
    if not is_animation:
        return [scene.frame_current]
    return list(range(scene.frame_start, scene.frame_end + 1, scene.frame_step)) or [scene.frame_current]


def views_of(scene):
    """Names of the pictures of a frame, such as those of two eyes; one without a name if there is one alone."""
    render = scene.render
    if not render.use_multiview:
        return [""]
    return [each.name for each in (render.stereo_views if render.views_format == "STEREO_3D" else render.views) if each.use]


def of_one_projection(scene, frames):
    """The first of these frames that follow each other and have cameras of one projection, as a shot has."""

    def projection(frame):
        camera = camera_at(scene, frame)
        return camera and camera.type == "CAMERA" and camera.data.type == "ORTHO"

    return list(itertools.takewhile(lambda frame: projection(frame) == projection(frames[0]), frames))


class Job:
    """The frames of one scene, view layer and view that are rendered one after the other."""

    def __init__(self, engine, scene, depsgraph, view_layer, view):
        frames = [frame for frame in frames_of(scene, engine.is_animation) if frame >= scene.frame_current]
        if scene.frame_current not in frames:
            frames = [scene.frame_current]
        self.frames = of_one_projection(scene, frames)
        self.folder = tempfile.mkdtemp(prefix="afterimage-")
        self.render, self.next = None, 0
        try:
            self.exported = export(engine, scene, depsgraph, view_layer, self.folder, self.frames, view, True)
            self.frames = self.exported.frames
            self.module = renderer()
            self.scene = self.module.load(self.exported.path)
        except BaseException:
            self.close()
            raise
        objects = passes.numbered(self.exported.names)
        self.objects = objects + ([] if scene.render.film_transparent else ["background"])

    def frame(self, engine, scene):
        """Renders the frame at which the scene is."""
        number = scene.frame_current
        if self.render is None or self.next >= len(self.frames) or self.frames[self.next] != number:
            self.next = self.frames.index(number)
            extra = {}
            crop = crop_of(scene)
            if crop:
                extra["crop"] = crop
            if scene.render.threads_mode == "FIXED":
                extra["threads"] = scene.render.threads

            def progress(_frame, done):
                self.engine.update_progress(done)
                return not is_cancelled(self.engine)

            self.render = iter(self.module.render(self.scene, frames=self.frames[self.next :], progress=progress, **extra))
        self.engine = engine
        try:
            frame = next(self.render)
        except BaseException:
            self.render = None
            raise
        finally:
            self.engine = None
        self.next += 1
        return frame

    def close(self):
        """Ends the render and removes the shot."""
        self.render = None
        self.scene = None
        shutil.rmtree(self.folder, ignore_errors=True)


def export(engine, scene, depsgraph, view_layer, folder, frames, view="", ends_at_changes=False):
    """Exports frames through a render engine, which evaluates the scene as it is rendered.

    `view`: the engine's active one of several. `ends_at_changes`: see export.Settings.
    """
    messages = []
    settings = dataclasses.replace(settings_of(scene, view_layer, frames, messages.append), ends_at_changes=ends_at_changes)
    if view:
        # by the engine, which knows how far the eyes are apart and where they converge
        eye = lambda camera: (engine.camera_model_matrix(camera), engine.camera_shift_x(camera))  # noqa: E731
        settings = dataclasses.replace(settings, view=view, eye=eye)
    elif scene.render.use_multiview:
        messages.append("stereoscopy: the shot has the camera's own view alone")

    def progress(share):
        engine.update_progress(share)
        engine.update_stats("", f"Afterimage | exporting motion, {share:.0%}")
        return not is_cancelled(engine)

    current, part = scene.frame_current, scene.frame_subframe
    try:
        done = export_shot(scene, depsgraph, folder, settings, lambda frame, subframe: engine.frame_set(frame, subframe=subframe), progress)
    finally:
        engine.frame_set(current, subframe=part)
    done.warnings[:0] = messages
    for message in done.warnings:
        if message not in _told:
            _told.add(message)
            engine.report({"WARNING"}, message)
            print(f"Afterimage: {message}")
    return done


def job_of(engine, scene, depsgraph, view_layer, view):
    """The job at work for a scene, a view layer and a view, which begins with its first frame."""
    key = (scene.name_full, view_layer.name, view)
    job = _jobs.get(key)
    if job is None or scene.frame_current not in job.frames:
        if job is not None:
            job.close()
            del _jobs[key]
        job = _jobs[key] = Job(engine, scene, depsgraph, view_layer, view)
    return job


def end(*_):
    """Ends all jobs."""
    for job in _jobs.values():
        job.close()
    _jobs.clear()
    _told.clear()


HANDLERS = ("render_init", "render_complete", "render_cancel")


def register():
    """Listens to the beginning and the end of render jobs."""
    persistent = bpy.app.handlers.persistent(end)
    for name in HANDLERS:
        getattr(bpy.app.handlers, name).append(persistent)


def unregister():
    """Ends what is at work, and listens no more."""
    end()
    for name in HANDLERS:
        handlers = getattr(bpy.app.handlers, name)
        if end in handlers:
            handlers.remove(end)

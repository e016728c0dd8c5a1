# SPDX-License-Identifier: GPL-3.0-or-later
"""A render job: the shot of all its frames, exported once, and the renderer that goes from frame to frame.

Blender asks an engine for one frame at a time, and makes a new engine for each. What is reused lives here, from the handler
`render_init`, which begins a job, to `render_complete` or `render_cancel`. So a scene that changes between jobs is exported anew.

Scripts render animations still by still. Where stills follow each other, the job of one has frames of the next ones as well, and is kept for
them. Whether each shows what it was expected to show is looked up when it is rendered.
"""

import atexit
import contextlib
import dataclasses
import fractions
import itertools
import math
import shutil
import tempfile
import time

import bpy

from . import passes, view_layers
from .export import Settings, export_shot, run_of
from .export.camera import camera_at
from .stills import Stills

LONGEST_WAIT = 60.0
"""Seconds for which a job is kept for another still."""

_jobs = {}
_stills = {}
"""By scene, first of the view layers that show the same, and view, as jobs."""
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


LEAST_ERROR = 0.001
"""Least error that the renderer takes."""
CURVE_STEPS = 32
"""Pieces of a shutter's curve: it goes straight along each."""


def curve_of(scene, warn):
    """How far the shutter is open over its time, as pairs of time and openness, both from 0 to 1; None if it is all open."""
    mapping = scene.render.motion_blur_shutter_curve
    mapping.initialize()
    curve = mapping.curves[0]
    times = sorted({step / CURVE_STEPS for step in range(CURVE_STEPS + 1)} | {min(max(point.location[0], 0.0), 1.0) for point in curve.points})
    points = [(round(time, 6), round(min(max(mapping.evaluate(curve, time), 0.0), 1.0), 6)) for time in times]
    if len({openness for _, openness in points}) > 1:
        return tuple(points)
    if points[0][1] <= 0:
        warn("the shutter curve never opens the shutter: it is taken to be all open")
    return None


MOST_SAMPLES = 16
"""Most samples across a pixel that the renderer takes."""


def samples_of(scene, view_layer):
    """How many times the scene's samples a view layer has, by the counts that Cycles would take: 1 unless it overrides them."""
    usual = getattr(getattr(scene, "cycles", None), "samples", 0)
    own = getattr(view_layer, "samples", 0)
    return own / usual if own > 0 and usual > 0 else 1


FALLOFFS = {"QUADRATIC": "quadratic", "LINEAR": "linear", "INVERSE_QUADRATIC": "inverse"}
"""How mist grows, in Blender and in shots."""


def mist_of(scene):
    """The distances of the mist of a scene's world, as [mist] has them; None without a world, as if the mist were Blender's usual one."""
    mist = scene.world and scene.world.mist_settings
    if not mist:
        return None
    return {"start": max(0.0, mist.start), "depth": max(1e-9, mist.depth), "falloff": FALLOFFS.get(mist.falloff, "quadratic")}


def settings_of(scene, layers, frames, warn, has_error=True):
    """The export's settings of a scene for view layers that show the same. Without `has_error` its counts are as they are set, or by default,
    whatever its noise threshold."""
    own, view_layer = scene.afterimage, layers[0]
    if abs(scene.render.pixel_aspect_x - scene.render.pixel_aspect_y) > 1e-4:
        warn("pixels that are not square are rendered square: set the aspect to 1")
    if scene.render.use_motion_blur and scene.render.motion_blur_shutter > 1:
        warn("a shutter longer than a frame is made one frame long")
    rate = fractions.Fraction(scene.render.fps) / fractions.Fraction(scene.render.fps_base).limit_denominator(100000)
    rate = rate.limit_denominator(1001)
    render = {"depth": own.depth, "mode": own.mode, "base_every": own.base_every}
    indirect = {"bounces": own.bounces, "volume_bounces": own.volume_bounces}
    has_error = has_error and own.error > 0
    more = samples_of(scene, view_layer)
    if has_error:
        render["error"] = min(max(own.error / 100 / math.sqrt(more), LEAST_ERROR), 1.0)
    stated = {name for name in ("samples", "paths", "reflections", "shadow_rays") if not has_error or own.is_property_set(name)}
    render["volume_samples"] = own.volume_samples
    render.update({name: getattr(own, name) for name in ("samples", "reflections") if name in stated})
    if more != 1 and "samples" in render:
        render["samples"] = min(max(round(own.samples * math.sqrt(more)), 1), MOST_SAMPLES)
    if "paths" in stated:
        indirect["paths"] = own.paths
    # as Blender's box of one pixel, but that samples need not lie in the centres of their cells
    if own.exposures > 0:
        render["exposures"] = own.exposures
    render.update(caustics="paths" if own.caustics else "none", filter="area")
    # the exposure of the film is a setting of Cycles, which counts for its limits as well
    exposure = getattr(getattr(scene, "cycles", None), "film_exposure", 1.0)
    if own.clamp > 0 and exposure > 0:
        render["clamp"] = own.clamp * exposure
    return Settings(
        frames=frames,
        size=size_of(scene),
        rate=rate.numerator if rate.denominator == 1 else f"{rate.numerator}/{rate.denominator}",
        render=render,
        indirect=indirect,
        output={"layers": passes.layers(scene, layers), "denoise": own.denoise},
        mist=mist_of(scene) if any(layer.use_pass_mist for layer in layers) else None,
        light_groups=tuple(passes.light_groups(view_layer).values()),
        shutter=shutter_of(scene),
        curve=curve_of(scene, warn) if shutter_of(scene) else None,
        transparent=scene.render.film_transparent,
        shadow_rays=int(own.shadow_rays) if "shadow_rays" in stated else None,
        exposure=exposure,
    )


def frames_of(scene):
    """Frames of the animation, rising."""
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
    """The frames of one scene and view that are rendered one after the other, for all view layers that show the same."""

    def __init__(self, engine, scene, depsgraph, layers, view, frames):
        self.frames = of_one_projection(scene, frames)
        self.folder = tempfile.mkdtemp(prefix="afterimage-")
        self.render, self.next, self.engine = None, 0, None
        self.groups, self.renders_of_groups = list(passes.light_groups(layers[0])), {}
        self.last, self.served = None, set()
        """The last frame, and the names of the view layers that have had it."""
        self.of_groups = {}
        """What each light group brings of the last frame."""
        self.kept_at = None
        """When it was kept for another still; None while it is at work."""
        is_watched = not engine.is_animation and len(self.frames) > 1
        ends_at_changes = not engine.is_animation or not scene.afterimage.hold
        try:
            self.exported = export(engine, scene, depsgraph, layers, self.folder, self.frames, view, ends_at_changes, is_watched)
            self.frames = self.exported.frames
            self.module = renderer()
            self.scene = self.module.load(self.exported.path)
        except BaseException:
            self.close()
            raise
        self.extra = extra_of(scene)
        self.numbers = passes.Numbers(self.exported.indices, self.exported.material_indices)
        objects = passes.numbered(self.exported.names)
        self.objects = objects + ([] if scene.render.film_transparent else ["background"])

    def frame(self, engine, scene, view_layer):
        """The frame at which the scene is, for a view layer: it is rendered for the first one, and is there for those that show the same."""
        number = scene.frame_current
        if self.last is None or self.last.number != number or view_layer.name in self.served:
            self.last, self.served = None, set()
            self.last = self._render(engine, number)
        self.served.add(view_layer.name)
        return self.last

    def _render(self, engine, number):
        """Renders a frame."""
        if self.render is None or self.next >= len(self.frames) or self.frames[self.next] != number:
            self.next = self.frames.index(number)

            def progress(_frame, done):
                self.engine.update_progress(done)
                return not is_cancelled(self.engine)

            frames = run_of(self.frames[self.next :])
            self.render = iter(self.module.render(self.scene, frames=frames, progress=progress, **self.extra))
            self.renders_of_groups = {group: self._render_of(group, frames, progress) for group in self.groups}
        self.engine = engine
        try:
            frame = next(self.render)
            dark = frame.layers["RGBA"][:, :, :3] * 0
            self.of_groups = {group: next(render).layers["RGBA"][:, :, :3] if render else dark for group, render in self.renders_of_groups.items()}
        except BaseException:
            self.render, self.renders_of_groups = None, {}
            raise
        finally:
            self.engine = None
        self.next += 1
        return frame

    def _render_of(self, group, frames, progress):
        """A render of what a light group brings; None for a group in which nothing is shown."""
        with open(self.exported.path, encoding="utf-8") as file:
            is_there = f'group = "{group}"' in file.read()
        if not is_there:
            return None
        return iter(self.module.render(self.scene, frames=frames, progress=progress, layers="none", denoise=False, only_lights=group, **self.extra))

    def is_worth_keeping(self):
        """Returns true if there are frames that stills to come may want."""
        return self.exported.noted is not None and self.next < len(self.frames)

    def goes_on(self, engine, scene, depsgraph, layers, view):
        """Returns true if the next frame of a job that was kept is the one at which the scene is, and shows what was exported for it."""
        if engine.is_animation or self.frames[self.next] != scene.frame_current or self.extra != extra_of(scene):
            return False
        settings = settings_for(engine, scene, layers, self.frames, view, lambda message: None)
        settings = dataclasses.replace(settings, ends_at_changes=True)
        if unbound(settings) != unbound(self.exported.settings):
            return False
        with at_frame_of(engine, scene) as set_frame:
            return self.exported.noted.is_still(scene, depsgraph, settings, scene.frame_current, set_frame)

    def close(self):
        """Ends the render and removes the shot."""
        self.render, self.renders_of_groups, self.of_groups = None, {}, {}
        self.scene, self.last = None, None
        shutil.rmtree(self.folder, ignore_errors=True)


def extra_of(scene):
    """What the renderer is told beside the shot."""
    extra = {}
    crop = crop_of(scene)
    if crop:
        extra["crop"] = crop
    if scene.render.threads_mode == "FIXED":
        extra["threads"] = scene.render.threads
    return extra


def unbound(settings):
    """Settings without what belongs to one engine or job."""
    return dataclasses.replace(settings, eye=None, frames=[], is_watched=True)


def settings_for(engine, scene, layers, frames, view, warn):
    """The export's settings through a render engine. `view`: the engine's active one of several."""
    settings = settings_of(scene, layers, frames, warn)
    if view:
        # by the engine, which knows how far the eyes are apart and where they converge
        def eye(camera):
            return engine.camera_model_matrix(camera), engine.camera_shift_x(camera)

        return dataclasses.replace(settings, view=view, eye=eye)
    if scene.render.use_multiview:
        warn("stereoscopy: the shot has the camera's own view alone")
    return settings


@contextlib.contextmanager
def at_frame_of(engine, scene):
    """Gives a function that evaluates the scene at a frame and a part of one, and goes back to where the scene is."""
    current, part = scene.frame_current, scene.frame_subframe
    try:
        yield lambda frame, subframe: engine.frame_set(frame, subframe=subframe)
    finally:
        engine.frame_set(current, subframe=part)


def export(engine, scene, depsgraph, layers, folder, frames, view="", ends_at_changes=False, is_watched=False):
    """Exports frames through a render engine, which evaluates the scene as it is rendered, of view layers that show the same.

    `view`: the engine's active one of several. `ends_at_changes`, `is_watched`: see export.Settings.
    """
    messages = []
    settings = settings_for(engine, scene, layers, frames, view, messages.append)
    settings = dataclasses.replace(settings, ends_at_changes=ends_at_changes, is_watched=is_watched)

    def progress(share):
        engine.update_progress(share)
        engine.update_stats("", f"Afterimage | exporting motion, {share:.0%}")
        return not is_cancelled(engine)

    with at_frame_of(engine, scene) as set_frame:
        done = export_shot(scene, depsgraph, folder, settings, set_frame, progress)
    done.warnings[:0] = messages
    for message in done.warnings:
        if message not in _told:
            _told.add(message)
            engine.report({"WARNING"}, message)
            print(f"Afterimage: {message}")
    return done


def job_of(engine, scene, depsgraph, view_layer, view):
    """The job at work for a scene, a view layer and a view, which begins with its first frame."""
    layers = view_layers.alike(scene, view_layer)
    key = (scene.name_full, layers[0].name, view)
    job, number = _jobs.get(key), scene.frame_current
    if job is not None and job.kept_at is None and number in job.frames:
        return job
    stills = _stills.setdefault(key, Stills())
    if engine.is_animation:
        stills.forget()
    else:
        stills.note(number)
    if job is not None:
        is_expected = job.kept_at is not None and job.frames[job.next] == number
        if job.kept_at is not None and job.goes_on(engine, scene, depsgraph, layers, view):
            job.kept_at = None
            return job
        if is_expected and not engine.is_animation:
            stills.miss()
        job.close()
        del _jobs[key]
    frames = [frame for frame in frames_of(scene) if frame >= number] if engine.is_animation else stills.frames(scene)
    job = _jobs[key] = Job(engine, scene, depsgraph, layers, view, frames if number in frames else [number])
    return job


def begin(*_):
    """Begins with a render: other jobs than those that are kept are over."""
    _told.clear()
    close_jobs(lambda job: job.kept_at is None)


def complete(*_):
    """Ends the jobs of a render, but for those that have frames of stills to come."""
    _told.clear()
    close_jobs(lambda job: job.kept_at is None and not job.is_worth_keeping())
    for job in _jobs.values():
        job.kept_at = job.kept_at or time.monotonic()
    if _jobs and not bpy.app.timers.is_registered(release):
        bpy.app.timers.register(release, first_interval=LONGEST_WAIT)


def release():
    """Ends jobs that nobody has wanted for a while. A timer calls it, as long as there are any."""
    latest = time.monotonic() - LONGEST_WAIT
    close_jobs(lambda job: job.kept_at is not None and job.kept_at <= latest and not bpy.app.is_job_running("RENDER"))
    return LONGEST_WAIT if _jobs else None


def end(*_):
    """Ends all jobs."""
    close_jobs(lambda job: True)
    _told.clear()
    _stills.clear()


def close_jobs(which):
    """Ends some of the jobs."""
    for key in [key for key, job in _jobs.items() if which(job)]:
        _jobs.pop(key).close()


HANDLERS = {"render_init": begin, "render_complete": complete, "render_cancel": end, "load_pre": end}


def register():
    """Listens to the beginning and the end of render jobs."""
    for name, handler in HANDLERS.items():
        getattr(bpy.app.handlers, name).append(bpy.app.handlers.persistent(handler))
    atexit.register(end)


def unregister():
    """Ends what is at work, and listens no more."""
    end()
    atexit.unregister(end)
    for name, handler in HANDLERS.items():
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)

# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports a shot: walks over the scene's frames, and writes meshes, pictures and shot.toml into a folder."""

import os
from dataclasses import dataclass, field

from . import camera, libraries, lights, toml
from .glance import Noted
from .images import Images
from .materials import GRAPHS, Materials
from .mesh_store import MeshStore
from .places import model_tables
from .walk import STEPS_A_FRAME, Walk, times_of
from .warnings import Warnings


@dataclass
class Settings:
    """What the export needs to know beside the scene."""

    frames: list
    size: tuple
    """Pixels, with the percentage of the resolution."""
    rate: str
    render: dict = field(default_factory=dict)
    """More keys of [render]."""
    indirect: dict = field(default_factory=dict)
    output: dict = field(default_factory=dict)
    mist: dict | None = None
    """Keys of [mist], if a layer shows it."""
    light_groups: tuple = ()
    """Names of the view layer's light groups."""
    shutter: tuple | None = None
    """When the shutter opens and closes, in frames from each frame's own time; None without motion blur."""
    curve: tuple | None = None
    """How far it is open meanwhile, as pairs of time and openness; None if it is all open."""
    transparent: bool = False
    shadow_rays: int | None = 4
    """Rays from each sample to a light that has a size; None: as many as follow from the error of [render]."""
    exposure: float = 1.0
    """Factor on all light."""
    camera: tuple | None = None
    """Projection and values of a camera at rest, instead of the scene's."""
    view: str = ""
    """One view of several, such as that of the left eye, whose place `eye` tells: see camera.key_of."""
    eye: object = None
    ends_at_changes: bool = False
    """True if the shot is to end before the first frame in which something has changed that shots have no tracks for."""
    is_watched: bool = False
    """True if it is to be noted what each frame shows."""


@dataclass
class Exported:
    """What an export wrote."""

    path: str
    """The shot file."""
    parts: tuple
    """Its text before the camera and behind it."""
    frames: list
    """Those of it that the shot has: all, unless it ends at changes."""
    names: list
    """Names of models, and of materials, in the shot."""
    materials: list
    indices: list
    """Pass indices of the models."""
    material_indices: dict
    """Pass indices of materials, by their names in the shot."""
    warnings: list
    settings: Settings
    noted: Noted | None
    """What frames show, if that is watched."""


def export_shot(scene, depsgraph, folder, settings, set_frame, progress):
    """Writes the shot of `settings.frames` into `folder`.

    `set_frame(frame, subframe)` evaluates the scene, `progress(share)` from 0 to 1 returns false to cancel. The shot file is written
    last, so that a folder without it is known to be unfinished. Raises ExportError, Cancelled, and OSError.
    """
    warnings = Warnings()
    libraries.tell_of_missing(warnings)
    os.makedirs(folder, exist_ok=True)
    shot = os.path.join(folder, "shot.toml")
    if os.path.exists(shot):
        os.remove(shot)
    materials = Materials(Images(folder, warnings), warnings, settings.exposure)
    times = times_of(settings.frames, settings.shutter)
    step = 1 / STEPS_A_FRAME if settings.shutter else step_of(times)
    store = MeshStore(folder, materials, step, warnings)
    store.is_watched = settings.is_watched
    try:
        walk = Walk(scene, depsgraph, store, settings, warnings)
        walk.over(times, set_frame, lambda share: progress(share * 0.8))
        noted = Noted.of(walk) if settings.is_watched else None
        cameras = camera.tables(walk.camera_keys, warnings)
        models, names, groups, indices = model_tables(walk, folder, lambda share: progress(0.8 + share * 0.2))
        text = walk.world + lights.tables(walk.light_tracks(), groups)
        if not names:
            warnings.add("the scene shows no mesh: the picture has nothing but the world")
            models = [empty_model()]
            materials.use(None)
        text += [materials.tables[name] for name in materials.tables] + models
    finally:
        store.abandon()
    from .files import whole

    if graphs := materials.document.text():
        whole(os.path.join(folder, GRAPHS), lambda file: file.write(graphs.encode()))
    parts = head(scene, settings, walk.frames), "\n".join(part for part in text if part)
    whole(shot, lambda file: file.write("\n".join([parts[0], *cameras, parts[1]]).encode()))
    return Exported(shot, parts, walk.frames, names, list(materials.tables), indices, materials.indices(), list(warnings), settings, noted)


def with_camera(parts, projection, key):
    """Text of a shot file of these parts, with a camera at rest."""
    return "\n".join([parts[0], toml.table("[camera]", {"projection": projection}), toml.table("[[camera.key]]", {"frame": 1, **key}), parts[1]])


def step_of(times):
    """The distance between frames, which must be even for shapes that deform."""
    return times[1] - times[0] if len(times) > 1 else 1.0


def frame_range(frames):
    """Frames as [render] has them."""
    run = run_of(frames)
    if len(frames) == 1 or not isinstance(run, range):
        return ",".join(map(str, frames))
    ends = f"{run[0]}{'-' if run[0] >= 0 else ':'}{run[-1]}"
    return ends if run.step == 1 else f"{ends}x{run.step}"


def run_of(frames):
    """Frames as a range if they follow each other in even steps: each is then made of the one before, and not of those between as well."""
    step = frames[1] - frames[0] if len(frames) > 1 else 1
    run = range(frames[0], frames[-1] + 1, step)
    return run if list(run) == list(frames) else frames


def head(scene, settings, frames):
    """The beginning of the file of these frames."""
    keys = {"size": list(settings.size), "frames": frame_range(frames), **settings.render}
    if settings.rate is not None:
        keys["rate"] = settings.rate
    parts = [toml.table("# Exported from Blender", {"title": scene.name}), toml.table("[render]", keys)]
    if settings.indirect:
        parts.append(toml.table("[indirect]", settings.indirect))
    parts.append(toml.table("[output]", {"background": "transparent" if settings.transparent else "visible", **settings.output}))
    if settings.mist:
        parts.append(toml.table("[mist]", settings.mist))
    if settings.shutter:
        keys = {"open": settings.shutter[0], "close": settings.shutter[1]}
        if settings.curve:
            keys["curve"] = [list(point) for point in settings.curve]
        parts.append(toml.table("[shutter]", keys))
    return "\n".join(parts)


def empty_model():
    """A shot needs a model: one that is never there."""
    return toml.table("[[model]]", {"name": "nothing", "quadric": {"type": "sphere"}, "visible": False})

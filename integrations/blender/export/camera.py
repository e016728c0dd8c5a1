# SPDX-License-Identifier: GPL-3.0-or-later
"""Cameras: Blender's lens, sensor and markers to the keys of [camera]."""

import math
from types import SimpleNamespace

import numpy as np

from .warnings import ExportError

# Blender's axes to those of shots: X stays, Z becomes Y, and Y becomes -Z
TO_Y_UP = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], dtype=float)


SENSOR = 36.0
"""Width in mm of the sensor of what is no camera."""

LENS = 50.0
"""Its focal length in mm; lights have one by the angle of their spot."""

SPOT = math.radians(45)
"""That angle of lights that are no spots: Blender keeps the one of a new light."""


def lens_of(camera):
    """What says how an object sees: the data of a camera, or what Cycles takes for anything else from which a scene may be rendered."""
    if camera.type == "CAMERA":
        return camera.data
    lens = LENS
    if camera.type == "LIGHT":
        # Blender makes it for a sensor of 32 mm
        lens = 16 / math.tan(getattr(camera.data, "spot_size", SPOT) / 2)
    return SimpleNamespace(
        type="PERSP",
        lens=lens,
        sensor_width=SENSOR,
        sensor_height=24.0,
        sensor_fit="AUTO",
        shift_x=0.0,
        shift_y=0.0,
        clip_start=1e-5,
        clip_end=1e5,
        dof=SimpleNamespace(use_dof=False),
    )


def camera_at(scene, frame):
    """The camera of a frame: that of the last marker with a camera, or of the first one before it, or the scene's."""
    marked = sorted((marker.frame, marker.camera) for marker in scene.timeline_markers if marker.camera)
    before = [camera for at, camera in marked if at <= math.floor(frame)]
    if before:
        return before[-1]
    if marked:
        return marked[0][1]
    return scene.camera


def rotation_of(matrix):
    """Pitch, yaw and roll in degrees of a camera whose matrix has its right, up and backward axes as columns."""
    forward = -matrix[:, 2]
    pitch = math.asin(max(-1.0, min(1.0, forward[1])))
    yaw = math.atan2(-forward[0], -forward[2]) if math.hypot(forward[0], forward[2]) > 1e-6 else 0.0
    cos_y, sin_y, cos_p, sin_p = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    turned = np.array([[cos_y, 0, sin_y], [0, 1, 0], [-sin_y, 0, cos_y]]) @ np.array([[1, 0, 0], [0, cos_p, -sin_p], [0, sin_p, cos_p]])
    left = turned.T @ matrix
    return [math.degrees(pitch), math.degrees(yaw), math.degrees(-math.atan2(left[1, 0], left[0, 0]))]


def fit_of(data, width, height, aspect=(1.0, 1.0)):
    """The side of the picture that the sensor fits, in pixels, and the sensor's size along it in mm."""
    across, up = width * aspect[0], height * aspect[1]
    if data.sensor_fit == "VERTICAL":
        return up, data.sensor_height
    if data.sensor_fit == "HORIZONTAL":
        return across, data.sensor_width
    return max(across, up), data.sensor_width


def camera_of_view(scene, camera, view):
    """The camera of one view of several, which may be cameras that differ by the ends of their names."""
    views = {each.name: each.camera_suffix for each in scene.render.views if each.use}
    if scene.render.views_format != "MULTIVIEW" or view not in views:
        return camera
    own = next((suffix for suffix in views.values() if suffix and camera.name.endswith(suffix)), None)
    return (scene.objects.get(camera.name.removesuffix(own) + views[view]) if own else None) or camera


def key_of(camera, scene, depsgraph, size, warnings, eye=None):
    """The projection, and the values of a [[camera.key]]. `eye`: matrix and horizontal shift of an evaluated camera, if they are not its own."""
    evaluated = camera.evaluated_get(depsgraph)
    data = lens_of(evaluated)
    place, shift = eye(evaluated) if eye else (evaluated.matrix_world, data.shift_x)
    place = np.array(place, dtype=float)
    matrix = TO_Y_UP[:3, :3] @ place[:3, :3]
    lengths = np.linalg.norm(matrix, axis=0)
    if not np.isfinite(place).all() or not (lengths > 0).all():
        raise ExportError(f"camera `{camera.name}` has no place: its matrix is flat or not finite. Check its constraints and drivers")
    width, height = size
    fit, sensor = fit_of(data, width, height)
    at = (TO_Y_UP @ place[:, 3])[:3]
    longer = fit / max(width, height)
    key = {"eye": at.tolist(), "rotation": rotation_of(matrix / lengths)}
    if data.type == "ORTHO":
        projection = "orthographic"
        key["height"] = data.ortho_scale * height / fit
    else:
        projection = "perspective"
        if data.type == "PANO":
            warnings.add(f"camera `{camera.name}`: panoramas are not rendered; it is shown with its lens")
        key["fov"] = math.degrees(2 * math.atan(sensor / 2 / data.lens * height / fit))
        if data.dof.use_dof and data.dof.aperture_fstop > 0:
            key["aperture"] = data.lens * 1e-3 / (2 * data.dof.aperture_fstop) / scene.unit_settings.scale_length
            key["focus"] = focus_of(data, at, -matrix[:, 2] / lengths[2], depsgraph)
            # the renderer has no wider lens
            key["aperture"] = min(key["aperture"], 10 * key["focus"])
    key["shift"] = [shift * longer, data.shift_y * longer]
    key.update(near=data.clip_start, far=data.clip_end)
    return projection, key


def focus_of(data, eye, forward, depsgraph):
    """Distance along the view axis of what is sharp."""
    focus = data.dof.focus_distance
    if data.dof.focus_object:
        place = TO_Y_UP @ np.array(data.dof.focus_object.evaluated_get(depsgraph).matrix_world)[:, 3]
        focus = abs(float(np.dot(place[:3] - eye, forward)))
    return max(focus, 1e-5)


def tables(keys, warnings):
    """[camera] and its keys: `keys` are (time, name of the camera, projection, values)."""
    from . import toml

    projection = keys[0][2]
    if any(key[2] != projection for key in keys):
        warnings.add("perspective and orthographic cameras in one shot: all are shown as the first one. Export the frames of each by themselves")
    out = [toml.table("[camera]", {"projection": projection})]
    last_name, last_values = None, None
    for index, (time, name, kind, values) in enumerate(keys):
        if kind != projection:
            values = dict(values)
            values.pop("fov", None), values.pop("height", None), values.pop("aperture", None), values.pop("focus", None)
        cut = last_name is not None and name != last_name
        if last_values and not cut:
            unwrap(values["rotation"], last_values["rotation"])
        if last_values == values and not cut and index < len(keys) - 1 and keys[index + 1][3] == values:
            continue  # at rest between two keys that say the same
        out.append(toml.table("[[camera.key]]", {"frame": time, **values, "cut": True if cut else None}))
        last_name, last_values = name, values
    return out


def unwrap(angles, before):
    """Adds whole turns to yaw and roll, so that they go the short way from the key before."""
    for axis in (1, 2):
        angles[axis] += 360 * round((before[axis] - angles[axis]) / 360)

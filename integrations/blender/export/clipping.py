# SPDX-License-Identifier: GPL-3.0-or-later
"""The clipping distances of cameras. Shots have those that cut anything off: frames take more time with them."""

import numpy as np

from .camera import TO_Y_UP, fit_of, lens_of

CORNERS = np.array([[x, y, z, 1] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)


class Clipping:
    """Which distances cut anything off."""

    def __init__(self):
        self.cuts = {"near": False, "far": False}

    def see(self, camera, size, placed, time):
        """Looks at what is placed at a time. `camera` is evaluated."""
        placed = [each for each in placed if time in each.mesh]
        if not placed:
            return
        data = lens_of(camera)
        view = np.linalg.inv(TO_Y_UP @ np.array(camera.matrix_world.normalized(), dtype=float))
        matrices = np.stack([each.matrices[time].reshape(3, 4) for each in placed])
        low, high = (np.stack([each.mesh[time].bounds[end] for each in placed]) for end in (0, 1))
        corners = low[:, None, :] + CORNERS[None, :, :3] * (high - low)[:, None, :]
        world = np.einsum("nij,nkj->nki", matrices[:, :, :3], corners) + matrices[:, None, :, 3]
        depths = -(world @ view[2, :3] + view[2, 3])
        self.cuts["far"] |= bool((depths.max(axis=1) > data.clip_end).any())
        eyes = np.linalg.inv(view) @ box(data, size)
        for index in np.flatnonzero((depths.min(axis=1) < data.clip_start) & (depths.max(axis=1) > 0)):
            if self.cuts["near"]:
                break
            self.cuts["near"] = reaches(placed[index].mesh[time], matrices[index], eyes)

    def drop(self, keys):
        """Takes the distances that cut nothing off in any frame out of keys of cameras, as they are in `camera.tables`."""
        for *_, values in keys:
            for plane in [plane for plane, cuts in self.cuts.items() if not cuts]:
                values.pop(plane, None)


def box(data, size):
    """Corners, as columns, of the box in the camera's own axes that holds what is seen nearer than the clip start."""
    fit, sensor = fit_of(data, *size)
    wide = (data.ortho_scale if data.type == "ORTHO" else sensor / data.lens * data.clip_start) / fit
    shift = np.array([data.shift_x, data.shift_y]) * wide * fit
    half = np.array(size) * wide / 2
    low, high = np.append(shift - half, -data.clip_start), np.append(shift + half, 0)
    return np.vstack([(low + CORNERS[:, :3] * (high - low)).T, np.ones(8)])


def reaches(stored, matrix, corners):
    """Returns true if triangles of a mesh reach into a box: its corners are columns in the world."""
    inside = np.linalg.solve(matrix[:, :3], corners[:3] - matrix[:, 3:])
    low, high = inside.min(axis=1), inside.max(axis=1)
    lowest, highest = stored.boxes
    near = np.flatnonzero(np.logical_and.reduce([lowest[axis] <= high[axis] for axis in range(3)] + [highest[axis] >= low[axis] for axis in range(3)]))
    points = stored.geometry.positions[stored.geometry.triangles[near]].astype(float)
    normals = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    apart = np.abs(np.einsum("ni,ni->n", normals, points[:, 0] - (low + high) / 2))
    return bool((apart <= np.abs(normals) @ ((high - low) / 2)).any())

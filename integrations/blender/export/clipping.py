# SPDX-License-Identifier: GPL-3.0-or-later
"""The clipping distances of cameras, which shots do not have: what they cut off in Blender is shown, and told."""

import numpy as np

from .camera import TO_Y_UP, fit_of

CORNERS = np.array([[x, y, z, 1] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)


class Clipping:
    """What cameras would cut off, by their names."""

    def __init__(self, warnings):
        self.warnings = warnings
        self.near, self.far = {}, {}

    def see(self, camera, size, placed, time):
        """Looks at what is placed at a time. `camera` is evaluated."""
        placed = [each for each in placed if time in each.mesh]
        if not placed:
            return
        data = camera.data
        view = np.linalg.inv(TO_Y_UP @ np.array(camera.matrix_world.normalized(), dtype=float))
        matrices = np.stack([each.matrices[time].reshape(3, 4) for each in placed])
        low, high = (np.stack([each.mesh[time].bounds[end] for each in placed]) for end in (0, 1))
        corners = low[:, None, :] + CORNERS[None, :, :3] * (high - low)[:, None, :]
        world = np.einsum("nij,nkj->nki", matrices[:, :, :3], corners) + matrices[:, None, :, 3]
        depths = -(world @ view[2, :3] + view[2, 3])
        far, near = self.far.setdefault(camera.name, {}), self.near.setdefault(camera.name, {})
        for index in np.flatnonzero(depths.max(axis=1) > data.clip_end):
            far.setdefault(placed[index].name)
        eyes = np.linalg.inv(view) @ box(data, size)
        for index in np.flatnonzero((depths.min(axis=1) < data.clip_start) & (depths.max(axis=1) > 0)):
            name = placed[index].name
            if name not in near and reaches(placed[index].mesh[time], matrices[index], eyes):
                near.setdefault(name)

    def tell(self):
        """Warns of what cameras would cut off."""
        for what, found in (("start", self.near), ("end", self.far)):
            for camera, names in found.items():
                names = list(names)
                if names:
                    more = f" and {len(names) - 3} more" if len(names) > 3 else ""
                    shown = ", ".join(f"`{name}`" for name in names[:3])
                    self.warnings.add(f"camera `{camera}`: its clip {what} is left out: it cuts {shown}{more} off in Blender")


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

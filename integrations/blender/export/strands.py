# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair of a shot: that of particle systems, and hair curves, as Cycles shows them: thick curves through their points."""

import hashlib
import os
from dataclasses import dataclass

import numpy as np

from .files import whole
from .meshes import FARTHEST, read_array

USUAL_RADIUS = 0.005
"""Radius of hair curves without one, as Cycles has it."""


@dataclass
class Strands:
    """Hairs at one time, in the space of their object."""

    points: np.ndarray
    """(points, 4), float32: places and radii."""
    counts: np.ndarray
    """(hairs,): points of each."""
    uvs: np.ndarray | None
    """(hairs, 2): texture coordinates where each grows."""

    def digest(self):
        """Digest of all of it."""
        digest = hashlib.blake2b(digest_size=16)
        for array in (self.points, self.counts, self.uvs):
            digest.update(b"-" if array is None else np.ascontiguousarray(array).data)
        return digest.digest()


class StoredStrands:
    """Hairs and their files; to the rest of the export a mesh."""

    shapes, deforms = None, False

    def __init__(self, store, name, strands, material, scale):
        self.store, self.name, self.strands, self.material, self.scale = store, name, strands, material, scale
        self.folder, self.key = None, None
        self.digest = strands.digest()
        places, radii = strands.points[:, :3], strands.points[:, 3:]
        self.bounds = (places - radii).min(axis=0), (places + radii).max(axis=0)
        self.reach = float(np.abs(places).max() + radii.max())

    def shape_at(self, time):
        """Digest of the shape: other hairs at another time are another mesh."""
        return self.digest

    @property
    def looks(self):
        """Digest of what is no shape."""
        return (self.material.name_full if self.material else "").encode()

    normals = b""

    @property
    def boxes(self):
        """Lowest and highest coordinates of all pieces, (3, pieces) each."""
        places, radii = self.strands.points[:, :3].T, self.strands.points[:, 3]
        low, high = places - radii, places + radii
        return np.minimum(low[:, :-1], low[:, 1:]), np.maximum(high[:, :-1], high[:, 1:])

    def has_veils(self):
        """Returns true if it is clear in part."""
        return self.store.materials.is_veil(self.material)

    def reflects_nothing(self):
        """Returns true if it is black or clear."""
        return self.store.materials.reflects_nothing(self.material)

    def models(self):
        """Writes the files. Returns what [[model]] tables say, and to which rays the material shows itself."""
        materials = self.store.materials
        materials.use(self.material, 1.0, self.scale)
        curves = {"file": self._array("points", self.strands.points), "basis": "catmull-rom", "material": materials.name(self.material)}
        counts = self.strands.counts
        same = int(counts[0])
        curves["counts"] = same if (counts == same).all() else self._array("counts", counts.astype("<f8"))
        if (uv := materials.uv(self.material)) and self.strands.uvs is not None:
            matrix = uv[1]
            curves["uvs"] = self._array("uvs", self.strands.uvs @ matrix[:2, :2].T + matrix[:2, 2])
        return [({"curves": curves}, materials.visibility(self.material))]

    def _array(self, name, values):
        path = self.store.path(self, f"{name}.npy")
        kind = "<f4" if values.dtype == np.float32 else "<f8"
        whole(path, lambda file: np.lib.format.write_array(file, np.ascontiguousarray(values, dtype=kind)))
        return os.path.relpath(path, self.store.folder).replace(os.sep, "/")


def hair_systems(item):
    """Pairs of a modifier and its particle system, of those that draw hair."""
    for modifier in item.modifiers:
        system = modifier.particle_system if modifier.type == "PARTICLE_SYSTEM" and modifier.show_render else None
        if system and system.settings.type == "HAIR" and system.settings.render_type == "PATH":
            yield modifier, system


def of_system(item, modifier, system, is_final):
    """Hairs of a particle system, parents or, where there are any, children. None if there are none."""
    settings = system.settings
    parents, children = len(system.particles), len(system.child_particles)
    first = 0 if settings.child_type == "NONE" or not children else parents
    steps = 2 ** (settings.render_step if is_final else settings.display_step) + 1
    numbers = range(first, parents + children)
    if not numbers:
        return None
    co_hair = system.co_hair
    places = np.array([co_hair(object=item, particle_no=number, step=step) for number in numbers for step in range(steps)], dtype=np.float64)
    if not np.isfinite(places).all():
        return None
    back = np.linalg.inv(np.array(item.matrix_world, dtype=np.float64))
    places = (places @ back[:3, :3].T + back[:3, 3]).reshape(len(numbers), steps, 3)
    lengths = np.linalg.norm(np.diff(places, axis=1), axis=2)
    along = np.concatenate([np.zeros((len(numbers), 1)), np.cumsum(lengths, axis=1)], axis=1)
    whole_lengths = along[:, -1:]
    share = np.divide(along, whole_lengths, out=np.zeros_like(along), where=whole_lengths > 0)
    radii = radius_of(settings, share)
    points = np.concatenate([places, radii[:, :, None]], axis=2)
    kept = whole_lengths[:, 0] > 0
    if not kept.any():
        return None
    uvs = uvs_of(item, modifier, system, numbers)
    # points in the place of the one before are none
    distinct = np.concatenate([np.ones((len(numbers), 1), dtype=bool), lengths > 0], axis=1) & kept[:, None]
    return Strands(points[distinct].astype(np.float32), distinct.sum(axis=1)[kept], None if uvs is None else uvs[kept])


def radius_of(settings, share):
    """Radii at shares of the length, as Cycles has them."""
    root, tip = (0.5 * settings.radius_scale * radius for radius in (settings.root_radius, settings.tip_radius))
    thin = np.clip(1 - share, 0, 1)
    shape = settings.shape
    if shape:
        thin = thin ** (1 + shape if shape < 0 else 1 / max(1 - shape, 1e-6))
    radii = thin * (root - tip) + tip
    if settings.use_close_tip:
        radii[:, -1] = 0
    return radii


def uvs_of(item, modifier, system, numbers):
    """Texture coordinates of the emitter where hairs grow; None if it has none."""
    layers = getattr(item.data, "uv_layers", None)
    if not layers:
        return None
    parents = len(system.particles)
    active = max(layers.active_index, 0)
    found = np.zeros((len(numbers), 2), dtype=np.float64)
    for row, number in enumerate(numbers):
        particle = system.particles[number if number < parents else 0]
        try:
            found[row] = system.uv_on_emitter(modifier, particle=particle, particle_no=number, uv_no=active)
        except (RuntimeError, TypeError):
            return None
    return found


def of_curves(data):
    """Hairs of hair curves. None if there are none."""
    offsets = read_array(data.curve_offset_data, "value", 1, np.int32)
    places = read_array(data.position_data, "vector", 3, np.float32)
    if len(offsets) < 2 or not len(places) or not np.isfinite(places).all():
        return None
    attribute = data.attributes.get("radius")
    radii = np.full(len(places), USUAL_RADIUS, dtype=np.float32)
    if attribute is not None and attribute.data_type == "FLOAT" and len(attribute.data) == len(places):
        radii = np.clip(np.nan_to_num(read_array(attribute.data, "value", 1, np.float32)), 0, None)
    uv = data.attributes.get("surface_uv_coordinate")
    counts = np.diff(offsets)
    uvs = None
    if uv is not None and uv.data_type == "FLOAT2" and len(uv.data) == len(counts):
        uvs = read_array(uv.data, "vector", 2, np.float32).astype(np.float64)
    return Strands(np.concatenate([places, radii[:, None]], axis=1).astype(np.float32), counts, uvs)


class StrandStore:
    """All hair of an export. What is the same as at the time before is one thing with it."""

    def __init__(self, meshes, warnings):
        self.meshes, self.warnings, self.known = meshes, warnings, {}

    def of(self, key, name, strands, material, matrix):
        """The stored hairs of a key; None if they cannot be shown."""
        if strands is None or not self.meshes.materials.is_there(material):
            return None
        if not np.isfinite(strands.points).all() or np.abs(strands.points).max() > FARTHEST:
            self.warnings.add(f"object `{name}`: its hair is left out where points of it are not at finite numbers, or farther than {FARTHEST:g} away")
            return None
        before = self.known.get(key)
        if before is not None and before.digest == strands.digest() and before.material == material:
            return before
        scale = float(abs(np.linalg.det(matrix[:3, :3])) ** (1 / 3)) or 1.0
        stored = self.known[key] = StoredStrands(self.meshes, name, strands, material, scale)
        stored.key = key
        return stored

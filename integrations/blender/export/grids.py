# SPDX-License-Identifier: GPL-3.0-or-later
"""Volumes of a shot: objects whose grids are OpenVDB's, of files or of modifiers, with what their materials say of them."""

import hashlib
import os
import shutil

import numpy as np

from .images import safe

KINDS = {"FLOAT": True, "VECTOR_FLOAT": True}
"""Types of grids that are read."""


class StoredVolume:
    """The grids of an object and their file; to the rest of the export a mesh."""

    shapes, deforms, normals = None, False, b""

    def __init__(self, store, name, source, material, bounds, factor):
        self.store, self.name, self.source, self.material, self.factor = store, name, source, material, factor
        self.folder, self.key = None, None
        self.bounds = bounds
        self.reach = float(np.abs(np.array(bounds)).max())

    @property
    def digest(self):
        """What tells it from others."""
        return hashlib.blake2b(repr((self.source.digest, self.factor)).encode(), digest_size=16).digest()

    def shape_at(self, time):
        """Digest of the shape: other grids at another time are another mesh."""
        return self.digest

    @property
    def looks(self):
        """Digest of what is no shape."""
        return (self.material.name_full if self.material else "").encode()

    @property
    def boxes(self):
        """Lowest and highest coordinates of all pieces, (3, pieces) each."""
        return tuple(np.asarray(corner, dtype=float)[:, None] for corner in self.bounds)

    def has_veils(self):
        """Returns true if it is clear in part."""
        return False

    def reflects_nothing(self):
        """Returns true if it is black or clear."""
        return True

    def models(self):
        """Writes the files. Returns what [[model]] tables say, and to which rays the material shows itself."""
        materials = self.store.materials
        name, asked, seen = materials.use_of_volume(self.material, self.factor, self.source.names)
        file = self.source.into(self.store.path(self, f"{safe(self.name)}.vdb"))
        vdb = {"file": os.path.relpath(file, self.store.folder).replace(os.sep, "/"), "material": name}
        if grids := [each for each in self.source.names if each in asked]:
            vdb["grids"] = grids
        return [({"vdb": vdb}, seen)]


class Source:
    """Where grids come from: a file that is there, or a copy of what modifiers have made."""

    def __init__(self, path, names, is_own):
        self.path, self.names, self.is_own = path, names, is_own
        with open(path, "rb") as file:
            self.digest = hashlib.file_digest(file, "blake2b").hexdigest()

    def into(self, path):
        """Puts the file into the shot. Returns its place."""
        if self.is_own:
            shutil.move(self.path, path)
            self.path, self.is_own = path, False
        elif os.path.abspath(self.path) != os.path.abspath(path):
            shutil.copyfile(self.path, path)
        return path


class VolumeStore:
    """All volumes of an export. What is the same as at the time before is one thing with it."""

    def __init__(self, meshes, warnings):
        self.meshes, self.warnings, self.known, self.count = meshes, warnings, {}, 0

    def of(self, key, item, material, matrix):
        """The stored volume of an object; None if it cannot be shown."""
        data = item.data
        source = self._source(item)
        if source is None:
            return None
        corners = np.array(item.bound_box, dtype=float)
        bounds = corners.min(axis=0), corners.max(axis=0)
        if not np.isfinite(corners).all():
            return None
        # opacity that belongs to the object is less where that is larger, as in Cycles
        linear = np.array(matrix)[:3, :3]
        factor = 1.0 if data.render.space == "WORLD" else float(np.sqrt(3) / max(np.linalg.norm(linear @ np.ones(3)), 1e-12))
        stored = StoredVolume(self.meshes, item.name, source, material, bounds, factor)
        before = self.known.get(key)
        if before is not None and before.digest == stored.digest and before.material == material:
            if source.is_own:
                os.remove(source.path)
            return before
        stored.key = key
        self.known[key] = stored
        return stored

    def _source(self, item):
        grids = item.data.grids
        if not grids.load() and grids.error_message:
            self.warnings.add(f"object `{item.name}` is left out: its volume cannot be read ({grids.error_message})")
            return None
        names = [grid.name for grid in grids if grid.data_type in KINDS]
        if not any(grid.data_type == "FLOAT" for grid in grids):
            self.warnings.add(f"object `{item.name}` is left out: its volume has no grid of numbers")
            return None
        path = grids.frame_filepath
        if path and os.path.isfile(path) and not item.modifiers:
            return Source(path, names, False)
        self.count += 1
        folder = os.path.join(self.meshes.folder, "meshes")
        os.makedirs(folder, exist_ok=True)
        path = os.path.join(folder, f"volume-{self.count}.vdb")
        if not grids.save(filepath=path) or not os.path.isfile(path):
            self.warnings.add(f"object `{item.name}` is left out: its grids cannot be saved")
            return None
        return Source(path, names, True)

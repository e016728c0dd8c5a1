# SPDX-License-Identifier: GPL-3.0-or-later
"""The meshes of a shot: which objects share one, which deform, and the files of each.

A mesh that cannot change is read once. One that might (modifiers, shape keys, geometry nodes, curves) is read at each time: while its
faces stay the same it is one mesh with a point cache; when they change, another mesh begins.
"""

import functools
import os

import numpy as np

from . import files, meshes
from .images import safe, to_srgb

MOST_DOUBLED = 0.01
"""Share of the area of a mesh from which on it is told that its faces lie in each other."""

BESIDE_TILES = 1e-4
"""How far texture coordinates may lie beside a mosaic, which has a size of 1: what an edge is rounded to."""


class Stored:
    """A mesh and its files. `shapes` is its point cache while it deforms."""

    def __init__(self, store, name, geometry, materials, time, users_scale):
        self.store, self.name, self.geometry, self.materials = store, name, geometry, materials
        self.folder, self.first, self.last_time = None, time, time
        self.scale = users_scale
        self.shapes, self.pending, self.deforms = None, 0, False
        self.key, self.watched = None, {}
        if store.is_watched:
            self.watch(time, geometry.positions)
        self.bounds = geometry.positions.min(axis=0), geometry.positions.max(axis=0)
        self.reach = meshes.reach_of(geometry.positions)

    @functools.cached_property
    def boxes(self):
        """Lowest and highest coordinates of all triangles, (3, triangles) each."""
        return meshes.boxes_of(self.geometry)

    def watch(self, time, positions):
        """Notes a digest of the shape at a time."""
        self.watched[time] = meshes.digest_of(positions)

    def shape_at(self, time):
        """Digest of the shape at a time; a mesh that was not looked at again has its first one."""
        return self.watched.get(time) or self.watched[self.first]

    @functools.cached_property
    def looks(self):
        """Digest of what is no shape: faces, their materials, texture coordinates, colours."""
        geometry = self.geometry
        tables = [values for table in (geometry.uvs, geometry.colors) for _, values in sorted(table.items())]
        names = repr([material.name_full if material else "" for material in self.materials])
        return geometry.topology + meshes.digest_of(np.frombuffer(names.encode(), dtype=np.uint8), geometry.slots, *tables)

    @functools.cached_property
    def normals(self):
        """Digest of the normals of the first shape."""
        return meshes.digest_of(self.geometry.normals)

    def add_shape(self, time, positions):
        """Notes the shape at a later time."""
        if self.store.is_watched:
            self.watch(time, positions)
        same = np.array_equal(positions, self.last_positions if self.deforms else self.geometry.positions)
        if not self.deforms and same:
            self.pending += 1
        else:
            if not self.deforms:
                self.deforms = True
                self.shapes = files.PointCache(self.store.path(self, "shapes.pc2"), len(positions), self.first, self.store.step)
                for _ in range(self.pending + 1):
                    self.shapes.add(self.geometry.positions)
            self.shapes.add(positions)
            self.last_positions = positions
        self.last_time = time

    def models(self):
        """Writes the files. Returns pairs of what [[model]] tables say of them, and to which rays the materials show themselves: a pair for
        all faces, unless their materials do not agree."""
        groups, uvs, colors = self._parts()
        if self.deforms:
            self.shapes.close(keep=True)
            self.shapes = None
        write = self._obj if self.deforms else self._ply
        endings = [f"-{index}" for index in range(1, len(groups) + 1)] if len(groups) > 1 else [""]
        return [(write(parts, uvs, colors, ending), seen) for ending, (seen, parts) in zip(endings, groups.items())]

    def _slots(self):
        """Pairs of a material and the triangles that have it, of those that are drawn."""
        materials, slots = self.materials, self.geometry.slots
        groups = {}
        of_store = self.store.materials
        media = {slot: of_store.is_medium(materials[slot]) for slot in np.unique(slots)}
        for slot in np.unique(slots):
            if media[slot] and not all(media.values()):
                of_store.leave_out(materials[slot])
            elif of_store.is_there(materials[slot]):
                groups.setdefault(materials[slot].name_full if materials[slot] else "", []).append(slot)
        for same in groups.values():
            yield materials[same[0]], np.flatnonzero(np.isin(slots, same))

    def has_veils(self):
        """Returns true if faces of it are clear in part."""
        return any(self.store.materials.is_veil(material) for material, _ in self._slots())

    def reflects_nothing(self):
        """Returns true if all faces of it are black or clear."""
        return all(self.store.materials.reflects_nothing(material) for material, _ in self._slots())

    def _uvs(self, material):
        """Texture coordinates of a material, moved by the mapping of its pictures; None if it has no pictures."""
        uv = self.store.materials.uv(material)
        if uv is None:
            return anywhere(self.geometry) if self.store.materials.is_even_veil(material) else None
        name, matrix = uv
        values = self.geometry.uvs.get(name)
        if values is None:
            if name:
                self.store.warnings.add(f"mesh `{self.name}` has no UV map `{name}`, which material `{material.name}` wants")
            values = self.geometry.uvs.get("")
        if values is None:
            self.store.warnings.add(f"mesh `{self.name}` has no UV map: material `{material.name}` shows one texel. Unwrap it")
            values = np.zeros((self.geometry.corners, 2), dtype=np.float32)
        if np.allclose(matrix, np.eye(3)):
            return values
        return (values @ matrix[:2, :2].T + matrix[:2, 2]).astype(np.float32)

    def _tell_of_tiles(self, material, uvs, corners):
        """Tells of texture coordinates that lie beside a material's mosaic of tiles."""
        if uvs is None or not self.store.materials.has_tiles(material):
            return
        places = uvs[corners]
        if places.min() < -BESIDE_TILES or places.max() > 1 + BESIDE_TILES:
            self.store.warnings.add(f"mesh `{self.name}` has texture coordinates beside the tiles of material `{material.name}`: tiles repeat there")

    def _use(self, material, uvs):
        """Makes sure that a material is written."""
        store = self.store
        density = 1.0
        if uvs is not None and store.materials.has_bump(material):
            density = meshes.uv_density(self.geometry, uvs) * self.scale
        store.materials.use(material, density, self.scale)

    def _parts(self):
        """From the rays that meet them to pairs of a material's name and its triangles; texture coordinates and colours of all corners (None:
        there are none)."""
        geometry, materials = self.geometry, self.store.materials
        groups, places, paint = {}, None, None
        for material, rows in self._slots():
            uvs, colors = self._uvs(material), materials.colors(material, geometry, self.name)
            self._use(material, uvs)
            groups.setdefault(materials.visibility(material), []).append((materials.name(material), rows))
            at = geometry.loops[rows].ravel()
            self._tell_of_tiles(material, uvs, at)
            places = with_values(places, uvs, at, geometry.corners, 0)
            paint = with_values(paint, colors, at, geometry.corners, 1)
        return groups, places, paint

    def _ply(self, parts, uvs, colors, ending):
        geometry = self.geometry
        rows = np.concatenate([rows for _, rows in parts]) if len(parts) > 1 else parts[0][1]
        values = meshes.split_vertices(geometry, rows, uvs, colors)
        # a file of one material has its name
        is_named = len(parts) == 1 and not ending
        path = self.store.path(self, f"{parts[0][0]}.ply" if is_named else f"mesh{ending}.ply")
        files.write_ply(path, *values, () if is_named else [(name, len(rows)) for name, rows in parts])
        return {"ply": self.store.relative(path)}

    def _obj(self, parts, uvs, colors, ending):
        geometry = self.geometry
        corners = geometry.loops.ravel()
        normals = geometry.normals[corners] if geometry.normals is not None else None
        if colors is not None:
            colors = to_srgb(meshes.means_of_vertices(geometry, colors))
        path = self.store.path(self, f"mesh{ending}.obj")
        files.write_obj(path, geometry.positions, geometry.triangles, parts, normals, uvs[corners] if uvs is not None else None, colors)
        cache = self.store.relative(self.store.path(self, "shapes.pc2"))
        # what a point cache says of its frames is a single float: say it in full
        shapes = {"cache": cache, "first": float(self.first), "every": float(self.store.step)}
        return {"obj": self.store.relative(path), "shapes": shapes}


ASKEW = np.array([[1, 0], [0, 1], [0.618, 0.731]])
"""Flattens a mesh onto a plane on edge to none of the directions in which faces usually lie."""


def anywhere(geometry):
    """Texture coordinates of a picture that is the same all over: they need only differ from place to place, which UV maps need not."""
    flat = geometry.positions @ ASKEW
    flat = flat - flat.min(axis=0)
    values = np.zeros((geometry.corners, 2), dtype=np.float32)
    values[geometry.loops.ravel()] = (flat / max(float(flat.max()), 1e-12))[geometry.triangles.ravel()]
    return values


def with_values(all_values, values, at, count, default):
    """Values of `count` corners, with `values` at those of one material; None while no material has any."""
    if values is None:
        return all_values
    if all_values is None:
        all_values = np.full((count, values.shape[1]), default, dtype=np.float32)
    all_values[at] = values[at]
    return all_values


def has_handlers():
    """Returns true if something listens to changes of frames: it may change meshes, and may count on frames coming in order."""
    import bpy

    return bool(bpy.app.handlers.frame_change_pre or bpy.app.handlers.frame_change_post)


class MeshStore:
    """All meshes of an export."""

    is_watched = False
    """True if what each frame shows is noted: see glance.py."""

    def __init__(self, folder, materials, step, warnings):
        self.folder, self.materials, self.step, self.warnings = folder, materials, step, warnings
        self.override = None
        """The material of all meshes, if a view layer has one."""
        self.known, self.stored, self.folders = {}, [], set()
        self.time = 0.0

    def begin(self, time):
        """Begins with another time."""
        self.time, self.here, self.counts = time, {}, {}

    def end(self):
        """Ends a time."""
        self.here = {}

    def of(self, instance, item):
        """The mesh of an instance at this time; None if it has no faces."""
        data = item.data
        materials = [slot.material for slot in item.material_slots] or list(getattr(data, "materials", ()) or ())
        if self.override:
            materials = [self.override]
        pointer = (data.as_pointer() if data else 0, tuple(material.name_full if material else "" for material in materials))
        if pointer in self.here:
            return self.here[pointer]
        if self._is_rigid(item):
            key = (data.original.name_full if data.original else data.name_full, pointer[1])
            if key not in self.known:
                self.known[key] = self._read(instance, item, materials, None)
            found = self.known[key]
        else:
            owner = (item.name_full, instance.parent.name_full if instance.is_instance else "", pointer[1])
            count = self.counts[owner] = self.counts.get(owner, -1) + 1
            key = (*owner, count)
            found = self.known[key] = self._read(instance, item, materials, self.known.get(key))
        if found is not None:
            found.key = key
        self.here[pointer] = found
        return found

    @staticmethod
    def _is_rigid(item):
        """Returns true if nothing can change the mesh: all objects with its data show the same at all times."""
        original = item.original
        data = original.data
        if item.type != "MESH" or original.type != "MESH" or data is None or original.modifiers or data.is_editmode or has_handlers():
            return False
        # geometry nodes make meshes of their own, whose originals are not those of the object; Blender 5 says of all that they are their own originals
        known = {data.as_pointer(), item.data.as_pointer()}
        if item.data.original is None or item.data.original.as_pointer() not in known or item.data.name != data.name:
            return False
        return not data.shape_keys and not data.animation_data and not item.is_instancer

    def _read(self, instance, item, materials, before):
        """Reads a mesh, or notes the shape of one that is known already."""
        if item.data is None:
            return None
        if not item.data.is_editmode:
            return self._read_mesh(item.data, instance, item, materials, before)
        # what is being edited, by whichever object, is a mesh only once it is asked for: until then its data has no faces
        try:
            return self._read_mesh(item.to_mesh(), instance, item, materials, before)
        finally:
            item.to_mesh_clear()

    def _read_mesh(self, mesh, instance, item, materials, before):
        if not len(mesh.polygons):
            return None
        name = item.name
        topology = meshes.topology_of(mesh)
        if before is not None and before.geometry.topology == topology:
            if abs(self.time - before.last_time - self.step) < 1e-6:
                positions = meshes.read_positions(mesh)
                reach = meshes.reach_of(positions)
                if np.isfinite(reach):
                    before.add_shape(self.time, positions)
                    before.reach = max(before.reach, reach)
                    return before
        geometry = meshes.read_geometry(mesh, topology, self.materials.attributes(materials))
        if geometry is None or not len(geometry.triangles):
            return None
        materials = materials or [None]
        geometry.slots = np.clip(geometry.slots, 0, len(materials) - 1)
        # all are asked, so that each is told
        if not any([self.materials.is_there(materials[slot]) for slot in np.unique(geometry.slots)]):
            return None
        if not np.isfinite(meshes.reach_of(geometry.positions)):
            self.warnings.add(f"object `{name}` is left out where vertices of its mesh are not at finite numbers, or farther than {meshes.FARTHEST:g} away")
            return None
        if before is not None and np.array_equal(before.geometry.positions, geometry.positions) and before.geometry.topology == topology:
            if not before.deforms:
                before.last_time = self.time
                return before
        if meshes.share_of_doubles(mesh) > MOST_DOUBLED:
            self.warnings.add(f"object `{name}`: faces of it lie in each other. They are lit, where Cycles has them shadow each other; merge them by distance")
        scale = float(abs(instance.matrix_world.determinant()) ** (1 / 3)) or 1.0
        stored = Stored(self, mesh.name if self._is_rigid(item) else name, geometry, materials, self.time, scale)
        self.stored.append(stored)
        return stored

    def path(self, stored, name):
        """A file in a mesh's own folder, which is made if need be."""
        if stored.folder is None:
            stem, count = safe(stored.name), 1
            folder = stem
            while folder.lower() in self.folders:
                count += 1
                folder = f"{stem}-{count}"
            self.folders.add(folder.lower())
            stored.folder = os.path.join(self.folder, "meshes", folder)
            os.makedirs(stored.folder, exist_ok=True)
        return os.path.join(stored.folder, name)

    def relative(self, path):
        """A path as the shot file has it."""
        return os.path.relpath(path, self.folder).replace(os.sep, "/")

    def abandon(self):
        """Closes and removes what is half written."""
        for stored in self.stored:
            if stored.shapes is not None:
                stored.shapes.close(keep=False)

# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes as arrays: what Blender has evaluated, triangulated, as files want it. No loop runs over vertices."""

import hashlib
from dataclasses import dataclass

import numpy as np

from . import islands, pointiness


@dataclass
class Geometry:
    """A mesh at one time, in the space of its object."""

    positions: np.ndarray
    """(vertices, 3), float32."""
    triangles: np.ndarray
    """(triangles, 3): vertices."""
    loops: np.ndarray
    """(triangles, 3): corners of Blender's faces."""
    slots: np.ndarray
    """(triangles,): material slots."""
    normals: np.ndarray | None
    """(corners, 3), or None where all is flat."""
    uvs: dict
    """From the name of a UV map to (corners, 2). The name "" is that of the map which is active for rendering."""
    colors: dict
    """From the name of a colour attribute to (corners, 3), linear. Those alone that materials ask for."""
    topology: bytes
    """Digest of everything but positions: two times of one digest may be shapes of one mesh."""

    @property
    def corners(self):
        """Number of corners."""
        return int(self.loops.max()) + 1


def read_array(collection, attribute, width, kind):
    """All values of an attribute of a collection."""
    values = np.empty(len(collection) * width, dtype=kind)
    if len(values):
        collection.foreach_get(attribute, values)
    return values.reshape(-1, width) if width > 1 else values


def read_positions(mesh):
    """Where all vertices are."""
    attribute = mesh.attributes.get("position")
    if attribute is not None and len(attribute.data) == len(mesh.vertices):
        return read_array(attribute.data, "vector", 3, np.float32)
    return read_array(mesh.vertices, "co", 3, np.float32)


def read_whole(mesh, attribute, domain, count):
    """An attribute of whole numbers, which Blender hands out at once, where its elements are asked one by one; None if the mesh has no such."""
    attribute = mesh.attributes.get(attribute)
    if attribute is None or (attribute.data_type, attribute.domain, len(attribute.data)) != ("INT", domain, count):
        return None
    return read_array(attribute.data, "value", 1, np.int32)


def read_corners(mesh):
    """The vertices of all corners."""
    corners = read_whole(mesh, ".corner_vert", "CORNER", len(mesh.loops))
    return read_array(mesh.loops, "vertex_index", 1, np.int32) if corners is None else corners


def read_slots(mesh):
    """The slots of the materials of all faces."""
    slots = read_whole(mesh, "material_index", "FACE", len(mesh.polygons))
    return read_array(mesh.polygons, "material_index", 1, np.int32) if slots is None else slots


def topology_of(mesh):
    """Digest of faces, without positions. Two meshes of the same digest have the same vertices in the same order."""
    digest = hashlib.blake2b(digest_size=16)
    digest.update(np.array([len(mesh.vertices), len(mesh.loops), len(mesh.polygons)]).tobytes())
    digest.update(read_corners(mesh).tobytes())
    digest.update(read_array(mesh.polygons, "loop_total", 1, np.int32).tobytes())
    return digest.digest()


def digest_of(*arrays):
    """Digest of arrays, of which any may be None."""
    digest = hashlib.blake2b(digest_size=16)
    for array in arrays:
        digest.update(b"-" if array is None else np.ascontiguousarray(array).data)
    return digest.digest()


def read_colors(mesh, name, corners):
    """Values of an attribute at all corners, (corners, 3) in linear colours; "" is the colour attribute that renders show, and one of
    `islands` has their numbers, that of `pointiness` what stands for it. None where there is none. `corners`: their vertices."""
    if name == islands.NAME:
        numbers = islands.of_vertices(len(mesh.vertices), read_array(mesh.edges, "vertices", 2, np.int32))
        return np.repeat(numbers[corners][:, None], 3, axis=1)
    if name == pointiness.NAME:
        normals, edges = read_array(mesh.vertex_normals, "vector", 3, np.float32), read_array(mesh.edges, "vertices", 2, np.int32)
        return pointiness.to_colors(pointiness.of_vertices(read_positions(mesh), normals, edges))[corners]
    if not name:
        index = mesh.color_attributes.render_color_index
        attribute = mesh.color_attributes[index] if 0 <= index < len(mesh.color_attributes) else None
    else:
        attribute = mesh.attributes.get(name)
    kinds = {"FLOAT_COLOR": ("color", 4), "BYTE_COLOR": ("color", 4), "FLOAT_VECTOR": ("vector", 3), "FLOAT": ("value", 1)}
    if attribute is None or attribute.data_type not in kinds or attribute.domain not in {"POINT", "CORNER", "FACE"}:
        return None
    field, width = kinds[attribute.data_type]
    values = read_array(attribute.data, field, width, np.float32).reshape(-1, width)
    values = values[:, :3] if width > 1 else np.repeat(values, 3, axis=1)
    if attribute.domain == "POINT":
        return values[corners]
    if attribute.domain == "FACE":
        return np.repeat(values, read_array(mesh.polygons, "loop_total", 1, np.int32), axis=0)
    return values


def read_geometry(mesh, topology=b"", colors=()):
    """Everything of a mesh, with the colour attributes of these names, or None if it has no faces."""
    if not len(mesh.polygons):
        return None
    mesh.calc_loop_triangles()
    loops = read_array(mesh.loop_triangles, "loops", 3, np.int32)
    corners = read_corners(mesh)
    polygons = read_array(mesh.loop_triangles, "polygon_index", 1, np.int32)
    slots = read_slots(mesh)[polygons]
    normals = None
    if mesh.normals_domain == "POINT":
        normals = read_array(mesh.vertex_normals, "vector", 3, np.float32)[corners]
    elif mesh.normals_domain == "CORNER":
        normals = read_array(mesh.corner_normals, "vector", 3, np.float32)
    uvs = {}
    for layer in mesh.uv_layers:
        if not layer.uv or len(layer.uv) != len(corners):
            continue
        uvs[layer.name] = read_array(layer.uv, "vector", 2, np.float32)
        if layer.active_render:
            uvs[""] = uvs[layer.name]
    if uvs and "" not in uvs:
        uvs[""] = next(iter(uvs.values()))
    found = {name: read_colors(mesh, name, corners) for name in colors}
    found = {name: values for name, values in found.items() if values is not None}
    return Geometry(read_positions(mesh), corners[loops], loops, slots, normals, uvs, found, topology)


MOST_LOOKED_AT = 20000
"""Most faces of a mesh of which it is asked whether some lie in each other: that takes as long as reading them."""


def share_of_doubles(mesh):
    """Share of the area of a mesh whose faces lie in other ones of the same size, as those of a thing that was copied and not moved do; of small meshes."""
    count = len(mesh.polygons)
    if not 2 <= count <= MOST_LOOKED_AT:
        return 0.0
    centers, normals = read_array(mesh.polygons, "center", 3, np.float32), read_array(mesh.polygons, "normal", 3, np.float32)
    areas = read_array(mesh.polygons, "area", 1, np.float32)
    size = float(np.sqrt(areas.sum(dtype=np.float64)))
    if not (0 < size < np.inf and np.isfinite(centers).all()):
        return 0.0
    # one may be turned over
    largest = np.take_along_axis(normals, np.abs(normals).argmax(axis=1)[:, None], axis=1)
    sides = np.round(np.column_stack([centers * (1e5 / size), normals * np.sign(largest) * 1e3, areas * (1e5 / size**2)]))
    _, which, times = np.unique(sides, axis=0, return_inverse=True, return_counts=True)
    return float(areas[times[which.ravel()] > 1].sum() / areas.sum())


FARTHEST = 1e18
"""The largest coordinate that the renderer takes."""


def reach_of(positions):
    """The largest coordinate of some vertices; infinity if one of them is nowhere that can be shown."""
    reach = float(np.abs(positions).max())
    return reach if reach <= FARTHEST else np.inf


def boxes_of(geometry):
    """Lowest and highest coordinates of all triangles, (3, triangles) each."""
    a, b, c = (geometry.positions.T[:, corner] for corner in geometry.triangles.T)
    return np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)


def uv_density(geometry, uvs):
    """Units of the mesh in one unit of the texture, on the mean over its triangles. Bump maps need it."""
    points, places = geometry.positions[geometry.triangles], uvs[geometry.loops]
    a, b = points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]
    area = np.linalg.norm(np.cross(a, b), axis=1).sum()
    s, t = places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]
    flat = np.abs(s[:, 0] * t[:, 1] - s[:, 1] * t[:, 0]).sum()
    return float(np.sqrt(area / flat)) if flat > 1e-12 and area > 0 else 1.0


def means_of_vertices(geometry, values):
    """For each vertex the mean of `values` at its corners; ones where it has none."""
    vertices, corners = geometry.triangles.ravel(), geometry.loops.ravel()
    count = np.bincount(vertices, minlength=len(geometry.positions))
    sums = [np.bincount(vertices, weights=values[corners, part], minlength=len(count)) for part in range(values.shape[1])]
    return np.where(count[:, None] > 0, np.stack(sums, axis=1) / np.maximum(count, 1)[:, None], 1.0)


def split_vertices(geometry, rows, uvs, colors=None):
    """Vertices with one value of each kind, as PLY wants them, of the triangles at `rows`.

    Returns positions, triangles, normals, texture coordinates and colours (those of them that there are, None for the others). Corners
    that agree with the first corner of their vertex share it; others become vertices of their own.
    """
    triangles, loops = geometry.triangles[rows], geometry.loops[rows]
    vertices, corners = triangles.ravel(), loops.ravel()
    kinds = [values[corners] if values is not None else None for values in (geometry.normals, uvs, colors)]
    if len(rows) < len(geometry.triangles):
        used, vertices = np.unique(vertices, return_inverse=True)
        positions = geometry.positions[used]
    else:
        positions = geometry.positions
    if all(values is None for values in kinds):
        return positions, vertices.reshape(-1, 3), *kinds
    first = np.zeros(len(positions), dtype=np.int64)
    # written backwards, so that the first corner of each vertex stays
    first[vertices[::-1]] = np.arange(len(vertices) - 1, -1, -1)
    own = np.zeros(len(vertices), dtype=bool)
    for values in kinds:
        if values is not None:
            own |= (values != values[first[vertices]]).any(axis=1)
    split = np.flatnonzero(own)
    index = vertices.copy()
    index[split] = len(positions) + np.arange(len(split))
    source = np.concatenate([first, split])
    positions = np.concatenate([positions, positions[vertices[split]]])
    return positions, index.reshape(-1, 3), *(values[source] if values is not None else None for values in kinds)

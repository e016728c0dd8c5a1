# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the files of a shot: meshes (PLY, OBJ), point caches (PC2), pictures (PNG, EXR). Needs numpy alone."""

import os
import struct
import zlib

import numpy as np


def whole(path, write):
    """Writes a file that is complete or absent: `write` gets a file open for writing bytes."""
    part = f"{path}.part"
    try:
        with open(part, "wb") as file:
            write(file)
        os.replace(part, path)
    except BaseException:
        if os.path.exists(part):
            os.remove(part)
        raise


def write_ply(path, positions, triangles, normals=None, uvs=None, colors=None, materials=()):
    """Writes a binary PLY of triangles. All arrays but `triangles` have one row a vertex.

    `materials`: pairs of a material's name and how many triangles have it, in their order; none where the file's name says it.
    """
    kinds = [(["nx", "ny", "nz"], normals), (["s", "t"], uvs), (["red", "green", "blue"], colors)]
    columns = [positions] + [array for _, array in kinds if array is not None]
    names = ["x", "y", "z"] + [name for names, array in kinds if array is not None for name in names]
    vertices = np.hstack(columns).astype("<f4", copy=False)
    faces = np.empty(len(triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)] + ([("material", "<i4")] if materials else []))
    faces["count"] = 3
    faces["corners"] = triangles
    if materials:
        faces["material"] = np.repeat(np.arange(len(materials)), [count for _, count in materials])
    header = ["ply", "format binary_little_endian 1.0", *(f"comment material {name}" for name, _ in materials)]
    header += [f"element vertex {len(vertices)}", *(f"property float {name}" for name in names)]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    header += (["property int material_index"] if materials else []) + ["end_header", ""]

    def write(file):
        file.write("\n".join(header).encode())
        file.write(np.ascontiguousarray(vertices).data)
        file.write(faces.data)

    whole(path, write)


def _rows(prefix, values, pattern):
    """Lines of an OBJ: one for each row of `values`."""
    line = f"{prefix} {pattern}\n"
    return (line * len(values)) % tuple(values.ravel().tolist())


def write_obj(path, positions, triangles, parts, normals=None, uvs=None, colors=None):
    """Writes an OBJ, and the MTL beside it which names its materials.

    `parts`: pairs of a material's name and the rows of `triangles` that have it. `normals` and `uvs` have a row for each corner of
    `triangles`, in their order; `colors` one for each position, as screens show them.
    """
    points = positions if colors is None else np.hstack([positions, colors])
    text = [f"mtllib {os.path.basename(path)[:-4]}.mtl\n", _rows("v", points, " ".join(["%.9g"] * points.shape[1]))]
    corners = [triangles + 1]
    pattern = "%d"
    numbers = np.arange(1, 3 * len(triangles) + 1).reshape(-1, 3)
    if uvs is not None:
        text.append(_rows("vt", uvs, "%.9g %.9g"))
        corners.append(numbers)
        pattern += "/%d"
    if normals is not None:
        text.append(_rows("vn", normals, "%.6g %.6g %.6g"))
        corners.append(numbers)
        pattern += "/%d" if uvs is not None else "//%d"
    corners = np.stack(corners, axis=2)
    for material, rows in parts:
        text.append(f"usemtl {material}\n")
        text.append(_rows("f", corners[rows].reshape(len(rows), -1), f"{pattern} {pattern} {pattern}"))
    whole(path, lambda file: file.write("".join(text).encode()))
    materials = "".join(f"newmtl {material}\n" for material, _ in parts)
    whole(path[:-4] + ".mtl", lambda file: file.write(materials.encode()))


class PointCache:
    """A PC2 file, written sample by sample, so that long shots need no memory."""

    def __init__(self, path, points, first, every):
        self.path, self.samples = path, 0
        self.file = open(f"{path}.part", "wb")
        self.head = (points, first, every)
        self._write_head()

    def _write_head(self):
        points, first, every = self.head
        self.file.write(struct.pack("<12siiffi", b"POINTCACHE2\0", 1, points, first, every, self.samples))

    def add(self, positions):
        """Appends one sample: where all points are."""
        self.file.write(np.ascontiguousarray(positions, dtype="<f4").data)
        self.samples += 1

    def close(self, keep):
        """Ends the file; removes it unless it is to be kept."""
        part = f"{self.path}.part"
        if keep:
            self.file.seek(0)
            self._write_head()
        self.file.close()
        if keep:
            os.replace(part, self.path)
        elif os.path.exists(part):
            os.remove(part)


def write_png(path, pixels):
    """Writes 8-bit pixels, (height, width, 3) or (height, width, 1), of which row 0 is the top."""
    height, width, channels = pixels.shape
    rows = np.empty((height, 1 + width * channels), dtype=np.uint8)
    rows[:, 0] = 0
    rows[:, 1:] = pixels.reshape(height, -1)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", width, height, 8, 2 if channels == 3 else 0, 0, 0, 0)
    data = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows.tobytes(), 1)) + chunk(b"IEND", b"")
    whole(path, lambda file: file.write(data))


def write_exr(path, pixels):
    """Writes linear pixels, (height, width, 3) floats of which row 0 is the top, as an OpenEXR of 32-bit floats without compression."""
    height, width, _ = pixels.shape

    def attribute(name, kind, data):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data

    window = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    channels = b"".join(name + b"\0" + struct.pack("<iBBBBii", 2, 0, 0, 0, 0, 1, 1) for name in (b"B", b"G", b"R")) + b"\0"
    head = struct.pack("<ii", 20000630, 2) + attribute("channels", "chlist", channels)
    head += attribute("compression", "compression", b"\0") + attribute("dataWindow", "box2i", window)
    head += attribute("displayWindow", "box2i", window) + attribute("lineOrder", "lineOrder", b"\0")
    head += attribute("pixelAspectRatio", "float", struct.pack("<f", 1)) + attribute("screenWindowCenter", "v2f", bytes(8))
    head += attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    line = 12 * width
    offsets = len(head) + 8 * height + np.arange(height, dtype="<u8") * (line + 8)
    rows = np.empty(height, dtype=[("y", "<i4"), ("size", "<i4"), ("data", "<f4", (3, width))])
    rows["y"], rows["size"] = np.arange(height), line
    rows["data"] = pixels[:, :, ::-1].transpose(0, 2, 1)
    whole(path, lambda file: (file.write(head), file.write(offsets.data), file.write(rows.data)))

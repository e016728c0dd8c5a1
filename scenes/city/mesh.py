"""Polygon meshes with texture coordinates, and how they become OBJ files.

Space: metres, Y up, right-handed; faces run counter-clockwise seen from outside. A polygon is one
`f` line of the OBJ file, whatever its number of corners.
"""

import math
from pathlib import Path


class Mesh:
    """Objects made of polygons; each polygon has a material and one (u, v) a corner."""

    def __init__(self):
        self.objects = []  # (name, [(material, positions, uvs, normals or None)])

    def object(self, name):
        """Open an object: what is added from now on belongs to it."""
        self.objects.append((name, []))

    def face(self, material, positions, uvs=None, normals=None):
        """Add one polygon. Without `uvs` it gets the plan of its own corners, in metres."""
        if uvs is None:
            uvs = [(x, -z) for x, _, z in positions]
        self.objects[-1][1].append((material, positions, uvs, normals))

    def count(self):
        """Number of polygons."""
        return sum(len(faces) for _, faces in self.objects)

    def write(self, path, library, comment):
        """Write the OBJ file at `path`; its materials are those of the MTL file `library`."""
        lines = [f"# {comment}", f"# {self.count()} polygons", f"mtllib {library}"]
        pools = {"v": {}, "vt": {}, "vn": {}}
        body = []
        for name, faces in self.objects:
            body.append(f"o {name}")
            current = None
            for material, positions, uvs, normals in faces:
                if material != current:
                    body.append(f"usemtl {material}")
                    current = material
                corners = []
                for i, position in enumerate(positions):
                    corner = f"{_index(pools['v'], position)}/{_index(pools['vt'], uvs[i])}"
                    if normals is not None:
                        corner += f"/{_index(pools['vn'], normals[i])}"
                    corners.append(corner)
                body.append("f " + " ".join(corners))
        for key, pool in pools.items():
            lines += [f"{key} {text}" for text in pool]
        Path(path).write_text("\n".join(lines + body) + "\n", encoding="ascii")


def _index(pool, numbers):
    text = " ".join(f"{number + 0.0:.4f}".rstrip("0").rstrip(".") for number in numbers)
    text = " ".join("0" if part == "-0" else part for part in text.split())
    return pool.setdefault(text, len(pool) + 1)


def rectangle(x0, z0, x1, z1, y):
    """Corners of a level rectangle that faces up."""
    return [(x0, y, z1), (x1, y, z1), (x1, y, z0), (x0, y, z0)]


def ring(x, z, y, radius, sides, turn=0.0, squash=1.0):
    """Corners of a level regular polygon, counter-clockwise seen from above; `turn` in steps."""
    points = []
    for i in range(sides):
        angle = 2 * math.pi * (i + turn) / sides
        points.append((x + radius * math.cos(angle), y, z - squash * radius * math.sin(angle)))
    return points


def box_ring(x, z, y, width, depth):
    """Corners of a level rectangle by centre and size, counter-clockwise seen from above."""
    w, d = width / 2, depth / 2
    return [(x - w, y, z + d), (x + w, y, z + d), (x + w, y, z - d), (x - w, y, z - d)]


def walls(mesh, material, lower, upper, tile):
    """Quads between two rings of as many corners.

    `tile` = (width, height, columns, rows): metres that one picture of the texture covers, and its
    bays and floors. Each wall takes whole bays and the ring whole floors, so no window is cut.
    """
    width, height, columns, rows = tile
    count = len(lower)
    for i in range(count):
        a, b, c, d = lower[i], lower[(i + 1) % count], upper[(i + 1) % count], upper[i]
        u = max(1, round(math.dist(a, b) / (width / columns))) / columns
        v0 = max(0, round(a[1] / (height / rows))) / rows
        v = max(1, round((d[1] - a[1]) / (height / rows))) / rows
        v_right = v * (c[1] - b[1]) / (d[1] - a[1])
        mesh.face(material, [a, b, c, d], [(0, v0), (u, v0), (u, v0 + v_right), (0, v0 + v)])


def cone(mesh, material, base, apex, tile=None):
    """Triangles from a ring to a point above it (or below, for a ring given clockwise).

    A picture of the texture covers the whole triangle, or `tile` metres.
    """
    for i, a in enumerate(base):
        corners = [a, base[(i + 1) % len(base)], apex]
        mesh.face(material, corners, _upright(corners, tile))


def antiprism(mesh, material, lower, upper, tile=None):
    """Triangles between two rings of as many corners, the upper half a step ahead."""
    count = len(lower)
    for i in range(count):
        a, b = lower[i], lower[(i + 1) % count]
        c, d = upper[i], upper[(i + 1) % count]
        mesh.face(material, [a, b, c], _upright([a, b, c], tile))
        u, v, w = _upright([c, d, b], tile)
        mesh.face(material, [b, d, c], [(w[0], -w[1]), v, u])


def _upright(corners, tile):
    """Texture coordinates of a triangle on a level edge: the edge at v = 0, undistorted in metres."""
    if tile is None:
        return [(0, 0), (1, 0), (0.5, 1)]
    a, b, apex = corners
    edge, height = math.dist(a, b), math.dist([(p + q) / 2 for p, q in zip(a, b)], apex)
    return [(0, 0), (edge / tile, 0), (edge / 2 / tile, height / tile)]


def geodesic(mesh, material, centre, radius):
    """A ball of 80 flat triangles: an icosahedron with each face cut in four."""
    tilt = math.atan(0.5)
    points = [(0.0, 1.0, 0.0)]
    for sign, turn in ((1, 0.0), (-1, 0.5)):
        points += [
            (math.cos(tilt) * math.cos(a), sign * math.sin(tilt), -math.cos(tilt) * math.sin(a))
            for a in (2 * math.pi * (i + turn) / 5 for i in range(5))
        ]
    points.append((0.0, -1.0, 0.0))
    faces = []
    for i in range(5):
        j = (i + 1) % 5
        faces += [(0, 1 + i, 1 + j), (1 + i, 6 + i, 1 + j), (6 + i, 6 + j, 1 + j), (11, 6 + j, 6 + i)]
    for ia, ib, ic in faces:
        a, b, c = points[ia], points[ib], points[ic]
        ab, bc, ca = _middle(a, b), _middle(b, c), _middle(c, a)
        for triangle in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)):
            placed = [tuple(m + radius * p for m, p in zip(centre, point)) for point in triangle]
            mesh.face(material, placed, [(0, 0), (1, 0), (0.5, 1)])


def _middle(a, b):
    total = [p + q for p, q in zip(a, b)]
    length = math.hypot(*total)
    return tuple(t / length for t in total)

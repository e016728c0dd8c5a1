#!/usr/bin/env python3
"""Builds the court of `court.toml`: `python3 scenes/court/make_court.py` writes its OBJ and MTL files beside it. Needs nothing but
Python.

A walled court above the sea, with a pool. Metres, Y up; the camera looks north, along -Z. The low sun stands in the south-west, behind
the arcade: it reaches the court through the arches.
"""

import math
import random
from pathlib import Path

FOLDER = Path(__file__).resolve().parent

# name: (Kd as sRGB, more statements)
MATERIALS = {
    "rose": ("#d3907c", ""),
    "coral": ("#c8694a", ""),
    "lime": ("#dfd1bc", ""),
    "stone": ("#d8ccb8", "Pr 0.35"),
    "stone_dark": ("#cbbda6", "Pr 0.35"),
    "stone_light": ("#e2d8c8", "Pr 0.35"),
    "joint": ("#8f8270", ""),
    "coping": ("#e9e2d6", ""),
    "water": ("#0d3c43", "Ks 0.05 0.06 0.06\nNs 800\nillum 5"),
    "sea": ("#175a80", "Ks 0.06 0.06 0.06\nNs 500\nillum 5"),
    "wood": ("#9a6238", ""),
    "wood_dark": ("#7d4c2a", ""),
    "bark": ("#6b5646", ""),
    "leaf": ("#5f7d3c", ""),
    "leaf_light": ("#8aa04e", ""),
    "leaf_dark": ("#43622f", ""),
    "fruit": ("#e8952a", "Pr 0.45"),
    "clay": ("#b9583a", ""),
    "soil": ("#3d2f26", ""),
    "glaze": ("#1f5a66", "Pr 0.18"),
    "brass": ("#d9ab5b", "Pr 0.34\nPm 1"),
}


class Mesh:
    """Faces with materials, written as one OBJ file. A corner is a position, or a position and its normal."""

    def __init__(self):
        self.faces = []  # (material, positions, normals or None)

    def face(self, material, positions, normals=None):
        self.faces.append((material, positions, normals))

    def grid(self, material, rows, smooth=True):
        """Quads between rows of as many points each; smooth ones have the normals of the points' neighbours."""
        normals = grid_normals(rows) if smooth else None
        for j in range(len(rows) - 1):
            for i in range(len(rows[0]) - 1):
                corners = [(j, i), (j, i + 1), (j + 1, i + 1), (j + 1, i)]
                places = [rows[row][column] for row, column in corners]
                self.face(material, places, normals and [normals[row][column] for row, column in corners])

    def box(self, material, low, high):
        """A box between two corners, without a floor."""
        (x0, y0, z0), (x1, y1, z1) = low, high
        self.face(material, [(x0, y1, z1), (x1, y1, z1), (x1, y1, z0), (x0, y1, z0)])
        foot = [(x0, z1), (x1, z1), (x1, z0), (x0, z0)]
        for (xa, za), (xb, zb) in zip(foot, foot[1:] + foot[:1]):
            self.face(material, [(xa, y0, za), (xb, y0, zb), (xb, y1, zb), (xa, y1, za)])

    def write(self, path):
        pools, body, current = {"v": {}, "vn": {}}, [], None
        for material, positions, normals in self.faces:
            if material != current:
                body.append(f"usemtl {material}")
                current = material
            corners = [str(index(pools["v"], position)) for position in positions]
            if normals:
                corners = [f"{corner}//{index(pools['vn'], normal)}" for corner, normal in zip(corners, normals)]
            body.append("f " + " ".join(corners))
        lines = ["# made by make_court.py", "mtllib court.mtl"]
        lines += [f"{key} {text}" for key, pool in pools.items() for text in pool]
        path.write_text("\n".join(lines + body) + "\n", encoding="ascii")


def index(pool, numbers):
    """The number of a vector among those of `pool`, from 1 on; millimetres."""
    text = " ".join(f"{round(number, 3) + 0.0:.3f}".rstrip("0").rstrip(".") for number in numbers)
    return pool.setdefault(text, len(pool) + 1)


def add(a, b, factor=1.0):
    return tuple(p + factor * q for p, q in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.hypot(*a) or 1.0
    return tuple(p / length for p in a)


def grid_normals(rows):
    """A normal for each point of a grid: across its neighbours, which go on around it where the grid closes."""
    height, width = len(rows), len(rows[0])
    closed = math.dist(rows[height // 2][0], rows[height // 2][-1]) < 1e-6
    ring = math.dist(rows[0][width // 2], rows[-1][width // 2]) < 1e-6

    def near(number, step, count, goes_on):
        if goes_on and not 0 <= number + step < count:
            return (number + step) % (count - 1)
        return min(max(number + step, 0), count - 1)

    normals = []
    for j in range(height):
        up, down = near(j, 1, height, ring), near(j, -1, height, ring)
        row = []
        for i in range(width):
            right, left = near(i, 1, width, closed), near(i, -1, width, closed)
            along, across = add(rows[j][right], rows[j][left], -1), add(rows[up][i], rows[down][i], -1)
            row.append(unit(cross(along, across)))
        normals.append(row)
    return normals


# --- walls ---


def arch(centre, width, spring):
    """An opening from the ground to a half circle: (u, low, high) from its left edge to its right one."""
    radius = width / 2
    angles = [math.pi * i / 28 for i in range(29)]
    return [(centre - radius * math.cos(a), 0.0, spring + radius * math.sin(a)) for a in angles]


def moon(centre, height, radius):
    """A round opening."""
    angles = [math.pi * i / 40 for i in range(41)]
    sides = [(centre - radius * math.cos(a), radius * math.sin(a)) for a in angles]
    return [(u, height - half, height + half) for u, half in sides]


def window(left, right, low, high):
    return [(left, low, high), (right, low, high)]


def wall(mesh, material, place, start, end, height, thickness, openings):
    """A wall from u = start to end, with openings from left to right. `place(u, v, w)` is where its points are."""

    def quad(*corners):
        mesh.face(material, [place(*corner) for corner in corners])

    def panel(u0, v0, u1, v1, top0, top1):
        """A part of both sides, between lower and upper edges that may slope."""
        if top0 - v0 < 1e-9 and top1 - v1 < 1e-9:
            return
        quad((u0, v0, 0), (u1, v1, 0), (u1, top1, 0), (u0, top0, 0))
        quad((u1, v1, -thickness), (u0, v0, -thickness), (u0, top0, -thickness), (u1, top1, -thickness))

    at = start
    for opening in openings:
        panel(at, 0.0, opening[0][0], 0.0, height, height)
        for (u0, low0, high0), (u1, low1, high1) in zip(opening, opening[1:]):
            panel(u0, 0.0, u1, 0.0, low0, low1)
            panel(u0, high0, u1, high1, height, height)
            quad((u0, high0, 0), (u1, high1, 0), (u1, high1, -thickness), (u0, high0, -thickness))
            if low0 + low1 > 0:
                quad((u1, low1, 0), (u0, low0, 0), (u0, low0, -thickness), (u1, low1, -thickness))
        for (u, low, high), turned in ((opening[0], False), (opening[-1], True)):
            jamb = [(u, low, 0), (u, high, 0), (u, high, -thickness), (u, low, -thickness)]
            if high - low > 1e-9:
                quad(*(reversed(jamb) if turned else jamb))
        at = opening[-1][0]
    panel(at, 0.0, end, 0.0, height, height)
    quad((start, height, 0), (end, height, 0), (end, height, -thickness), (start, height, -thickness))
    quad((start, 0, -thickness), (start, 0, 0), (start, height, 0), (start, height, -thickness))
    quad((end, 0, 0), (end, 0, -thickness), (end, height, -thickness), (end, height, 0))


def walls(mesh):
    arches = [arch(centre, 2.3, 2.55) for centre in (-8.0, -4.75, -1.5, 1.75, 5.0, 8.25)]
    # u runs to the south along the arcade, to the east along the wall of the gate, to the north along the east wall
    wall(mesh, "rose", lambda u, v, w: (-5.5 + w, v, -u), -11.0, 11.0, 5.0, 0.7, [[(u, a, b) for u, a, b in o] for o in arches])
    wall(mesh, "coral", lambda u, v, w: (u, v, -10.0 + w), -6.2, 6.2, 6.0, 0.8, [moon(1.1, 3.0, 1.75)])
    wall(mesh, "lime", lambda u, v, w: (5.5 - w, v, -u), -11.0, 10.0, 5.0, 0.6, [window(5.4, 8.4, 1.0, 3.9)])


# --- floor and pool ---

POOL = (-1.9, -6.2, 2.9, 4.2)  # x, z of its north-west corner, and of its south-east corner


def floor(mesh, chance):
    """Slabs with joints around the pool, and the ground below."""
    west, north, east, south = POOL
    step = 0.8
    for row in range(-15, 16):
        for column in range(-11, 12):
            x, z = 0.5 + column * step, -1.0 + row * step
            x0, z0, x1, z1 = x - step / 2, z - step / 2, x + step / 2, z + step / 2
            material = chance.choice(["stone", "stone", "stone_dark", "stone_light"])
            if x1 > west and x0 < east and z1 > north and z0 < south:
                continue
            g = 0.006
            mesh.face(material, [(x0 + g, 0, z1 - g), (x1 - g, 0, z1 - g), (x1 - g, 0, z0 + g), (x0 + g, 0, z0 + g)])
    for x0, z0, x1, z1 in ((-9, -14, west, 12), (east, -14, 9, 12), (west, -14, east, north), (west, south, east, 12)):
        mesh.face("joint", [(x0, -0.008, z1), (x1, -0.008, z1), (x1, -0.008, z0), (x0, -0.008, z0)])
    mesh.box("lime", (-9, -9, -14), (9, -0.9, 12))
    mesh.face("sea", [(-4000, -9, 4000), (4000, -9, 4000), (4000, -9, -4000), (-4000, -9, -4000)])


def pool(mesh):
    """Coping, walls, and water whose ripples are in its normals and, a few millimetres high, in its shape."""
    west, north, east, south = POOL
    rim, top = 0.4, 0.09
    # the coping covers the slabs that the pool cuts
    for low, high in (
        ((west - rim, north - rim), (west, south + rim)),
        ((east, north - rim), (east + rim, south + rim)),
        ((west, north - rim), (east, north)),
        ((west, south), (east, south + rim)),
    ):
        mesh.box("coping", (low[0], -0.5, low[1]), (high[0], top, high[1]))
    columns, lines = 28, 56
    rows = []
    for j in range(lines + 1):
        row = []
        for i in range(columns + 1):
            x, z = west + (east - west) * i / columns, south + (north - south) * j / lines
            row.append((x, -0.06 + ripple(x, z), z))
        rows.append(row)
    mesh.grid("water", rows)


def ripple(x, z):
    waves = ((1.9, 0.7, 0.3, 3.0), (-0.8, 2.6, 1.1, 3.4), (3.1, 2.3, 2.0, 1.5), (-2.7, 3.9, 4.0, 1.2))
    return 0.001 * sum(height * math.sin(a * x + b * z + phase) for a, b, phase, height in waves)


def stairs(mesh):
    """From the court to the gate."""
    for step in range(7):
        front = -7.5 - 0.32 * step
        mesh.box("coping", (-0.4, 0.0, -10.0), (2.6, 0.175 * (step + 1), front))


# --- things ---


def lathe(mesh, material, centre, profile, sides=32):
    """A body of revolution about a vertical axis; `profile` from its foot to its top: (radius, height)."""
    x, y, z = centre
    turns = [2 * math.pi * i / sides for i in range(sides + 1)]
    rows = [[(x + r * math.cos(a), y + h, z - r * math.sin(a)) for a in turns] for r, h in profile]
    mesh.grid(material, rows)


def bench(mesh):
    """Slats on two blocks, along the east wall."""
    for z in (-2.3, -0.1):
        mesh.box("coping", (4.35, 0, z - 0.15), (4.85, 0.38, z + 0.15))
    for slat in range(5):
        x = 4.3 + 0.122 * slat
        mesh.box("wood" if slat % 2 else "wood_dark", (x, 0.38, -2.9), (x + 0.11, 0.44, 0.5))


def vase(mesh, centre, height, width, material):
    shape = [(0.32, 0), (0.42, 0.03), (0.78, 0.22), (0.98, 0.42), (1.0, 0.52), (0.86, 0.70), (0.5, 0.86), (0.36, 0.92), (0.42, 1.0), (0.34, 0.99), (0.28, 0.9)]
    lathe(mesh, material, centre, [(r * width / 2, h * height) for r, h in refine(shape)])


def refine(points, times=2):
    """A smoother line through about the same points (Chaikin)."""
    for _ in range(times):
        cut = [points[0]]
        for a, b in zip(points, points[1:]):
            cut += [tuple(0.75 * p + 0.25 * q for p, q in zip(a, b)), tuple(0.25 * p + 0.75 * q for p, q in zip(a, b))]
        points = cut + [points[-1]]
    return points


def tree(mesh, chance, foot, height):
    """An orange tree in a pot: limbs that fork, leaves and fruit at their ends."""
    x, y, z = foot
    pot = [(0.32, 0), (0.34, 0.02), (0.44, 0.52), (0.50, 0.53), (0.50, 0.62), (0.44, 0.62), (0.42, 0.54)]
    lathe(mesh, "clay", foot, pot)
    lathe(mesh, "soil", (x, y + 0.55, z), [(0.42, 0), (0.0, 0.02)], 24)
    limb(mesh, chance, (x, y + 0.5, z), (0.05, 1, 0.02), height * 0.42, 0.06, 0)


def limb(mesh, chance, start, direction, length, radius, depth):
    direction = unit(direction)
    end = add(start, direction, length)
    side = unit(cross(direction, (0.3, 0.2, 1.0)))
    other = cross(direction, side)
    turns = [2 * math.pi * i / 6 for i in range(7)]
    rows = []
    for place, r in ((start, radius), (end, radius * 0.65)):
        rows.append([add(add(place, side, r * math.cos(a)), other, r * math.sin(a)) for a in turns])
    mesh.grid("bark", rows)
    if depth >= 2:
        for _ in range(13 if depth == 2 else 26):
            leaf(mesh, chance, add(start, direction, length * chance.uniform(0.2, 1.15)), 0.1 + 0.12 * depth / 2)
    if depth == 4:
        return
    if depth == 3 and chance.random() < 0.3:
        fruit(mesh, add(end, (chance.uniform(-0.1, 0.1), -0.1, chance.uniform(-0.1, 0.1))))
    turn = chance.uniform(0, 2 * math.pi)
    for fork in range(4 if depth == 0 else 3 if depth < 3 else 2):
        a = turn + fork * 2.1 + chance.uniform(-0.3, 0.3)
        lean = chance.uniform(0.55, 0.95)
        away = add(add((0, 0, 0), side, math.cos(a)), other, math.sin(a))
        limb(mesh, chance, end, add(add(direction, away, lean), (0, 0.12, 0)), length * chance.uniform(0.5, 0.68), radius * 0.62, depth + 1)


def leaf(mesh, chance, centre, spread):
    """A bent leaf of two triangles beside its rib, somewhere around `centre`."""
    centre = add(centre, [chance.gauss(0, spread * 0.5) for _ in range(3)])
    along = unit([chance.gauss(0, 1), chance.gauss(-0.25, 0.6), chance.gauss(0, 1)])
    across = unit(cross(along, unit([chance.gauss(0, 0.5), 1, chance.gauss(0, 0.5)])))
    length = chance.uniform(0.05, 0.075)
    tip, root = add(centre, along, length), add(centre, along, -length)
    left, right = add(centre, across, length * 0.5), add(centre, across, -length * 0.5)
    material = chance.choice(["leaf", "leaf", "leaf_light", "leaf_dark"])
    mesh.face(material, [root, right, tip, left])


def fruit(mesh, centre):
    profile = [(0.05 * math.sin(math.pi * i / 6), -0.05 * math.cos(math.pi * i / 6)) for i in range(7)]
    lathe(mesh, "fruit", centre, profile, 9)


def hoop(radius=0.95, thickness=0.055):
    """A ring that stands upright around the origin."""
    mesh = Mesh()
    rows = []
    for j in range(15):
        b = 2 * math.pi * j / 14
        row = []
        for i in range(73):
            a = 2 * math.pi * i / 72
            r = radius + thickness * math.cos(b)
            row.append((r * math.cos(a), r * math.sin(a), thickness * math.sin(b)))
        rows.append(row)
    mesh.grid("brass", rows)
    return mesh


def linear(colour):
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    return " ".join(f"{p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4:.4f}" for p in parts)


def main():
    chance = random.Random(7)
    court = Mesh()
    walls(court)
    floor(court, chance)
    pool(court)
    stairs(court)
    bench(court)
    tree(court, chance, (4.4, 0.0, -5.0), 3.6)
    vase(court, (-2.2, 0.0, -8.6), 1.15, 0.72, "glaze")
    vase(court, (-1.35, 0.0, -8.2), 0.62, 0.56, "clay")
    court.box("lime", (0.05, -0.4, -2.45), (0.55, 0.32, -1.95))
    court.write(FOLDER / "court.obj")
    hoop().write(FOLDER / "hoop.obj")
    lines = ["# made by make_court.py"]
    for name, (colour, more) in MATERIALS.items():
        lines += ["", f"newmtl {name}", f"Kd {linear(colour)}"] + (more.split("\n") if more else ["illum 1"])
    (FOLDER / "court.mtl").write_text("\n".join(lines) + "\n", encoding="ascii")


if __name__ == "__main__":
    main()

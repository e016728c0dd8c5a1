#!/usr/bin/env python3
"""Makes hall.obj and hall.mtl: a hall between two mirrors that face each other, with pillars and blocks. Needs nothing but Python."""

from pathlib import Path

HERE = Path(__file__).parent
MATERIALS = {
    "mirror": "Kd 0 0 0\nKs 0.88 0.9 0.9\nillum 3",
    "plaster": "Kd 0.72 0.7 0.66",
    "oak": "Kd 0.42 0.27 0.16",
    "slate": "Kd 0.16 0.18 0.2",
    "brick": "Kd 0.55 0.2 0.13",
    "moss": "Kd 0.2 0.32 0.14",
}

points, faces = [], []


def quad(material, *corners):
    first = len(points) + 1
    points.extend(corners)
    faces.append((material, [first, first + 1, first + 2, first + 3]))


def block(material, low, high):
    (a, b, c), (x, y, z) = low, high
    quad(material, (a, b, z), (x, b, z), (x, y, z), (a, y, z))
    quad(material, (x, b, c), (a, b, c), (a, y, c), (x, y, c))
    quad(material, (x, b, z), (x, b, c), (x, y, c), (x, y, z))
    quad(material, (a, b, c), (a, b, z), (a, y, z), (a, y, c))
    quad(material, (a, y, z), (x, y, z), (x, y, c), (a, y, c))
    quad(material, (a, b, c), (x, b, c), (x, b, z), (a, b, z))


# tiles of the floor, two kinds of them
for row in range(24):
    for column in range(12):
        x, z = column * 0.5 - 3, row * 0.5 - 6
        kind = "oak" if (row + column) % 2 else "slate"
        quad(kind, (x, 0, z + 0.5), (x + 0.5, 0, z + 0.5), (x + 0.5, 0, z), (x, 0, z))
quad("plaster", (-3, 3.2, -6), (3, 3.2, -6), (3, 3.2, 6), (-3, 3.2, 6))
quad("plaster", (-3, 0, -6), (3, 0, -6), (3, 3.2, -6), (-3, 3.2, -6))
quad("plaster", (3, 0, 6), (-3, 0, 6), (-3, 3.2, 6), (3, 3.2, 6))
quad("mirror", (-3, 0, 6), (-3, 0, -6), (-3, 3.2, -6), (-3, 3.2, 6))
quad("mirror", (3, 0, -6), (3, 0, 6), (3, 3.2, 6), (3, 3.2, -6))
for number in range(4):
    z = 3 * number - 4.5
    for x in (-2.2, 2.2):
        block("plaster", (x - 0.15, 0, z - 0.15), (x + 0.15, 3.2, z + 0.15))
block("brick", (-1.2, 0, -3.4), (-0.4, 0.9, -2.6))
block("moss", (0.3, 0, -1.5), (1.3, 0.5, -0.5))
block("brick", (0.6, 0.5, -1.2), (1.0, 1.2, -0.8))
block("slate", (-0.9, 0, 0.7), (-0.3, 1.5, 1.3))

lines = ["mtllib hall.mtl"] + ["v {:g} {:g} {:g}".format(*point) for point in points]
for material in MATERIALS:
    lines.append(f"usemtl {material}")
    lines += ["f " + " ".join(map(str, face)) for of, face in faces if of == material]
(HERE / "hall.obj").write_text("\n".join(lines) + "\n")
(HERE / "hall.mtl").write_text("\n".join(f"newmtl {name}\n{text}\n" for name, text in MATERIALS.items()))

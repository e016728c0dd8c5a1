#!/usr/bin/env python3
"""Builds the flag of `cloth.toml`: `python3 scenes/cloth/make_cloth.py` writes its OBJ and MTL files, its picture and its shapes
beside it. Needs nothing but Python.

The flag hangs on a pole at x = 0 and reaches to x = LENGTH; waves run along it with the wind, deeper the farther they are from the
pole. As many shapes as a wave takes to come to where the next one was, so that they can be repeated. Metres, Y up.
"""

import math
import struct
import zlib
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
LENGTH, HEIGHT = 3.0, 1.9
COLUMNS, ROWS = 26, 10
SHAPES = 16
# of a wave along the flag, and how far it swings at the free end
WAVE, SWING = 1.7, 0.4


def place(u, v, phase):
    """A point of the flag: u from the pole to the free end, v from the lower edge to the upper one; phase 0 to 1."""
    along, depth = u * LENGTH, SWING * u * (1.25 - 0.35 * u)
    turn = 2 * math.pi * (along / WAVE - phase)
    # the upper edge is ahead, and a second wave of half the length runs below the first
    lean = 0.9 * (v - 0.5)
    z = depth * math.sin(turn + lean) + 0.3 * depth * math.sin(2 * turn - 2.1 * v)
    # cloth does not stretch: what swings aside is shorter
    x = along - 0.32 * depth * (1 + math.cos(2 * (turn + lean))) * u
    sag = 0.14 * u * u * (1 + 0.25 * math.sin(turn + 1.3))
    return x, (v - 0.5) * HEIGHT - sag * (1.2 - v), z


def positions(phase):
    points = [place(i / COLUMNS, j / ROWS, phase) for j in range(ROWS + 1) for i in range(COLUMNS + 1)]
    return "".join("v {:.3f} {:.3f} {:.3f}\n".format(*point) for point in points)


def rest():
    """The flag spread out: faces, texture coordinates, and one normal, so that it is smooth."""
    points = [(i / COLUMNS, j / ROWS) for j in range(ROWS + 1) for i in range(COLUMNS + 1)]
    lines = ["# made by make_cloth.py\n", "mtllib cloth.mtl\n", "usemtl flag\n"]
    lines += ["v {:.3f} {:.3f} 0\n".format(u * LENGTH, (v - 0.5) * HEIGHT) for u, v in points]
    lines += ["vt {:.4f} {:.4f}\n".format(u, v) for u, v in points]
    lines.append("vn 0 0 1\n")
    for j in range(ROWS):
        for i in range(COLUMNS):
            first = j * (COLUMNS + 1) + i + 1
            corners = [first, first + 1, first + COLUMNS + 2, first + COLUMNS + 1]
            lines.append("f " + " ".join("{0}/{0}/1".format(corner) for corner in corners) + "\n")
    return "".join(lines)


def picture(width=192, height=120):
    """A blue cross on white and a red disc in its corner, as rows of RGB from the top."""
    rows = []
    for y in range(height):
        row = bytearray([0])
        for x in range(width):
            color = (236, 232, 222)
            if abs(x - 70) < 13 or abs(y - 60) < 13:
                color = (28, 62, 128)
            if (x - 131) ** 2 + (y - 28) ** 2 < 17**2:
                color = (196, 40, 34)
            if min(x, y, width - 1 - x, height - 1 - y) < 3:
                color = (28, 62, 128)
            row += bytes(color)
        rows.append(bytes(row))
    return b"".join(rows)


def png(data, width=192, height=120):
    def chunk(kind, content):
        crc = zlib.crc32(kind + content)
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", crc)

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    parts = [chunk(b"IHDR", head), chunk(b"IDAT", zlib.compress(data, 9)), chunk(b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


def main():
    (FOLDER / "cloth.obj").write_text(rest())
    (FOLDER / "cloth.mtl").write_text("# made by make_cloth.py\nnewmtl flag\nKd 0.9 0.9 0.9\nKs 0 0 0\nmap_Kd flag.png\nillum 1\n")
    (FOLDER / "flag.png").write_bytes(png(picture()))
    for shape in range(SHAPES):
        (FOLDER / "flag.{:02}.obj".format(shape + 1)).write_text(positions(shape / SHAPES))


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Makes drum.obj, an upright cylinder with rounded edges: python3 scenes/patterns/make_drum.py."""

import math
import os

RADIUS, HEIGHT, ROUND, SIDES = 0.55, 1.45, 0.06, 64


def profile():
    """Radius, height and normal of the outline, from the middle of the top to the floor."""
    yield 0.0, HEIGHT, (0.0, 1.0)
    for step in range(9):
        angle = math.pi / 2 * (1 - step / 8)
        yield RADIUS - ROUND + ROUND * math.cos(angle), HEIGHT - ROUND + ROUND * math.sin(angle), (math.cos(angle), math.sin(angle))
    yield RADIUS, 0.0, (1.0, 0.0)


def main():
    lines = ["# made by make_drum.py", "usemtl rust"]
    rows = list(profile())
    for radius, height, (out, up) in rows:
        for side in range(SIDES):
            turn = 2 * math.pi * side / SIDES
            x, z = math.cos(turn), math.sin(turn)
            lines.append(f"v {radius * x:.5f} {height:.5f} {radius * z:.5f}")
            lines.append(f"vn {out * x:.5f} {up:.5f} {out * z:.5f}")
    for row in range(len(rows) - 1):
        for side in range(SIDES):
            a, b = row * SIDES + side + 1, row * SIDES + (side + 1) % SIDES + 1
            corners = [a, b, b + SIDES, a + SIDES] if row else [a, b + SIDES, a + SIDES]
            lines.append("f " + " ".join(f"{corner}//{corner}" for corner in corners))
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "drum.obj")
    with open(path, "w") as file:
        file.write("\n".join(lines) + "\n")


main()

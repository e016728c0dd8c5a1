#!/usr/bin/env python3
"""Builds the city: `python3 scenes/city/make_city.py` (numpy and Pillow) writes OBJ, MTL and PNG files beside it.

Metres, Y up; the avenue runs north along -Z, the reflecting pool lies on it, the mirror tower closes
it. The sun stands in the south-west, so the eastern row is lit and the western row casts the shadows.
755 polygons, as many as the city of Adelson and Hodges' paper of 1993; the count is checked.
"""

import math
from pathlib import Path

import textures
from mesh import Mesh, antiprism, box_ring, cone, geodesic, rectangle, ring, walls

POLYGONS = 755
FOLDER = Path(__file__).resolve().parent

# What one picture of a facade covers: width, height in metres; bays, floors.
FACADES = {
    "limestone": (26.0, 30.0, 8, 8),
    "sandstone": (26.0, 30.0, 8, 8),
    "brick": (30.0, 30.0, 8, 8),
    "rose": (30.0, 30.0, 8, 8),
    "deco": (28.0, 30.0, 8, 8),
    "ribbon": (32.0, 32.0, 8, 8),
    "curtain": (34.0, 32.0, 8, 8),
    "haze_warm": (30.0, 32.0, 8, 8),
    "haze_cool": (34.0, 32.0, 8, 8),
}
SHOPS = (40.0, 7.0, 8, 1)
PLAIN = (10.0, 10.0, 1, 1)

# name: (Kd, more statements). Colours are sRGB hex here, linear in the MTL file.
MATERIALS = {
    "limestone": ("#ffffff", "map_Kd limestone.png"),
    "sandstone": ("#f3d3a6", "map_Kd limestone.png"),
    "brick": ("#f6e6de", "map_Kd brick.png"),
    "rose": ("#f0d6cc", "map_Kd brick.png"),
    "deco": ("#ffffff", "map_Kd deco.png"),
    "ribbon": ("#ffffff", "Ks 0.05 0.05 0.05\nNs 60\nillum 5\nmap_Kd ribbon.png"),
    "curtain": ("#ffffff", "Ks 0.14 0.15 0.16\nNs 120\nillum 5\nmap_Kd curtain.png"),
    "haze_warm": ("#b89f8e", "Ke 0.12 0.14 0.18\nmap_Kd deco.png"),
    "haze_cool": ("#93a5ad", "Ke 0.12 0.15 0.20\nmap_Kd ribbon.png"),
    "shops": ("#ffffff", "map_Kd shops.png"),
    "roof_pale": ("#e2d6c2", "map_Kd roof.png"),
    "roof_dark": ("#878c94", "map_Kd roof.png"),
    "roof_red": ("#b5664c", ""),
    "roof_green": ("#ffffff", "map_Kd garden.png"),
    "roof_copper": ("#6fb3a0", ""),
    "haze_roof": ("#8d8f96", "Ke 0.12 0.14 0.18"),
    "gold": ("#6b4a1c", "Ks 0.86 0.66 0.36\nNs 200\nillum 3"),
    "mirror": ("#ffffff", "Ks 0.60 0.74 0.80\nNs 400\nillum 3\nmap_Kd mirror.png"),
    "water": ("#12414c", "Ks 0.34 0.38 0.40\nNs 500\nillum 5"),
    "glass": ("#000000", "Ks 1 1 1\nNs 600\nNi 1.5\nd 0.1\nillum 7"),
    "stone": ("#e8dfcf", ""),
    "paving": ("#ffffff", "map_Kd paving.png"),
    "road": ("#ffffff", "map_Kd road.png"),
    "block": ("#bdb29f", ""),
    "lawn": ("#7d9a52", ""),
    "land": ("#a8a888", "Ke 0.02 0.025 0.03"),
    "hill_near": ("#6f8594", "Ke 0.14 0.19 0.25"),
    "hill_far": ("#7f94a8", "Ke 0.26 0.33 0.42"),
    "leaf": ("#4f7d43", ""),
    "leaf_light": ("#7f9d4a", ""),
    "leaf_gold": ("#d99a3a", ""),
    "hull": ("#ffffff", "Ks 0.18 0.18 0.18\nNs 30\nillum 2\nmap_Kd hull.png"),
    "fin": ("#e2553d", "Ks 0.1 0.1 0.1\nNs 30\nillum 2"),
    "gondola": ("#2b3f52", "Ks 0.2 0.2 0.2\nNs 60\nillum 2"),
    "pole": ("#39424c", ""),
    "hut": ("#efe8da", ""),
    "tram": ("#ffffff", "map_Kd tram.png"),
}

# Towers: kind, x, z, width, depth, height, facade, roof. West row, east row, then those behind.
TOWERS = [
    ("shop", -64, 78, 34, 34, 30, "limestone", "roof_green"),
    ("shop", -64, 28, 34, 40, 26, "brick", "roof_pale"),
    ("setback", -65, -24, 36, 38, 46, "sandstone", "roof_pale"),
    ("shop", -64, -76, 34, 40, 32, "ribbon", "roof_green"),
    ("setback", -66, -130, 38, 38, 78, "deco", "roof_copper"),
    ("shop", 64, 78, 34, 34, 40, "ribbon", "roof_pale"),
    ("setback", 65, 28, 36, 38, 74, "deco", "roof_copper"),
    ("shop", 64, -24, 34, 36, 52, "brick", "roof_green"),
    ("wedge", 66, -76, 36, 36, 96, "curtain", "roof_dark"),
    ("shop", 64, -130, 34, 36, 62, "limestone", "roof_red"),
    ("wedge", -122, 30, 36, 40, 70, "curtain", "roof_dark"),
    ("spire", -120, -40, 34, 34, 92, "limestone", "roof_copper"),
    ("box", -124, -104, 40, 36, 84, "rose", "roof_dark"),
    ("octagon", -126, -168, 44, 44, 128, "curtain", "roof_dark"),
    ("box", 124, 20, 40, 40, 92, "rose", "roof_dark"),
    ("octagon", 128, -44, 46, 46, 132, "curtain", "roof_dark"),
    ("setback", 122, -112, 38, 38, 112, "sandstone", "roof_copper"),
    ("box", 120, -176, 36, 36, 86, "ribbon", "roof_pale"),
    ("box", -60, -196, 38, 38, 58, "rose", "roof_red"),
    ("wedge", 62, -200, 38, 38, 108, "curtain", "roof_dark"),
    ("box", -190, -230, 44, 40, 104, "haze_cool", "haze_roof"),
    ("wedge", -128, -262, 40, 40, 120, "haze_warm", "haze_roof"),
    ("box", -62, -290, 40, 40, 94, "haze_cool", "haze_roof"),
    ("spire", 40, -310, 36, 36, 104, "haze_warm", "haze_roof"),
    ("wedge", 112, -272, 40, 40, 140, "haze_cool", "haze_roof"),
    ("box", 186, -240, 44, 40, 88, "haze_warm", "haze_roof"),
    ("box", -36, -330, 36, 30, 66, "haze_warm", "haze_roof"),
]


# On roofs: x, z, height of the roof, width, depth, height.
HUTS = [
    (-70, 70, 30, 8, 6, 3.5),
    (-58, 32, 26, 9, 12, 4.0),
    (-70, -70, 32, 10, 8, 4.5),
    (58, 70, 40, 10, 8, 4.0),
    (68, -16, 52, 9, 9, 5.0),
    (128, 26, 92, 14, 14, 7.0),
    (-128, -108, 84, 16, 12, 7.0),
]
ROOF_TREES = [(-58, 84, 30.1), (-53, 72, 30.1), (-68, 89, 30.1)]
TRAMS = [(-33, 40), (-39, -30), (33, -2), (39, 12), (-33, 104)]


def tower(mesh, kind, x, z, width, depth, height, facade, roof):
    """One tower on the ground. Its walls face out; what stands on a roof has no floor of its own."""
    tile, foot = FACADES[facade], box_ring(x, z, 0.0, width, depth)
    if kind == "octagon":
        foot = ring(x, z, 0.0, width / 2, 8, 0.5)
        top = ring(x, z, height, width / 2, 8, 0.5)
        walls(mesh, facade, foot, top, tile)
        deck(mesh, roof, top)
        return
    if kind == "shop":
        base = box_ring(x, z, 7.0, width, depth)
        walls(mesh, "shops", foot, base, SHOPS)
        foot = base
    if kind == "wedge":
        top = box_ring(x, z, height, width, depth)
        drop = height * 0.16
        top = [(px, py - (drop if px * x < x * x else 0.0), pz) for px, py, pz in top]
        walls(mesh, facade, foot, top, tile)
        deck(mesh, roof, top)
        return
    if kind == "setback":
        for share, inset in ((0.52, 0.0), (0.86, 0.24)):
            ledge = box_ring(x, z, height * share, width * (1 - inset), depth * (1 - inset))
            walls(mesh, facade, foot, ledge, tile)
            deck(mesh, roof, ledge)
            foot = box_ring(x, z, height * share, width * (0.76 - inset), depth * (0.76 - inset))
    top = [(px, height, pz) for px, _, pz in foot]
    walls(mesh, facade, foot, top, tile)
    if kind == "spire":
        cone(mesh, roof, top, (x, height + width * 0.75, z))
    else:
        deck(mesh, roof, top)


def deck(mesh, material, corners):
    """A roof: one picture of its texture covers it, border and all."""
    xs, zs = [p[0] for p in corners], [p[2] for p in corners]
    u = [(x - min(xs)) / (max(xs) - min(xs)) for x in xs]
    v = [(max(zs) - z) / (max(zs) - min(zs)) for z in zs]
    mesh.face(material, corners, list(zip(u, v)))


def block(mesh, material, x, z, y, width, depth, height):
    """A box without a floor, standing at height `y`."""
    foot, top = box_ring(x, z, y, width, depth), box_ring(x, z, y + height, width, depth)
    walls(mesh, material, foot, top, PLAIN)
    mesh.face(material, top)


def rooftops(mesh):
    """Stair heads and gardens on the roofs that the camera passes."""
    for i, (x, z, y, width, depth, height) in enumerate(HUTS):
        mesh.object(f"hut_{i + 1:02}")
        block(mesh, "hut", x, z, y, width, depth, height)
    for i, (x, z, y) in enumerate(ROOF_TREES):
        mesh.object(f"roof_tree_{i + 1:02}")
        poplar(mesh, "leaf_gold" if i == 1 else "leaf", x, y, z, 6.0 + i, 1.9, 0.4 * i)


def trams(mesh):
    """Trams on both roads. One picture of the texture covers a side."""
    for i, (x, z) in enumerate(TRAMS):
        mesh.object(f"tram_{i + 1:02}")
        foot, top = box_ring(x, z, 0.5, 2.8, 16.0), box_ring(x, z, 3.9, 2.6, 15.4)
        walls(mesh, "tram", foot, top, (16.0, 3.4, 8, 1))
        mesh.face("hut", top)


def ground(mesh):
    """Land, the city's slab, two roads along the mall, three across, lawns and the paved mall."""
    mesh.object("land")
    mesh.face("land", rectangle(-2600, -2600, 2600, 2600, 0.0))
    mesh.object("streets")
    mesh.face("block", rectangle(-230, -350, 230, 330, 0.05))
    for x in (-36, 36):
        strip(mesh, x - 7, -268, x + 7, 320, 0.10)
    mesh.object("mall")
    mesh.face("paving", rectangle(-27, -112, 27, 300, 0.10), plan(-27, -112, 27, 300, 9.0))
    for x in (-20.5, 20.5):
        mesh.face("lawn", rectangle(x - 4.5, -66, x + 4.5, 86, 0.16))


def strip(mesh, x0, z0, x1, z1, y):
    """A road; the picture's height is 14 m of it."""
    v = round((z1 - z0) / 14.0)
    mesh.face("road", rectangle(x0, z0, x1, z1, y), [(0, 0), (1, 0), (1, v), (0, v)])


def plan(x0, z0, x1, z1, tile):
    """Texture coordinates of a level rectangle, one picture every `tile` metres."""
    u, v = (x1 - x0) / tile, (z1 - z0) / tile
    return [(0, 0), (u, 0), (u, v), (0, v)]


def pool(mesh):
    """The long reflecting pool: water a hand below a stone rim."""
    mesh.object("pool")
    outer = box_ring(0, 10, 0.8, 26, 150)
    inner = box_ring(0, 10, 0.8, 22, 146)
    foot = [(x, 0.0, z) for x, _, z in outer]
    water = [(x, 0.4, z) for x, _, z in inner]
    walls(mesh, "stone", foot, outer, PLAIN)
    for i in range(4):
        j = (i + 1) % 4
        mesh.face("stone", [outer[i], outer[j], inner[j], inner[i]])
    walls(mesh, "stone", water[::-1], inner[::-1], PLAIN)
    mesh.face("water", water)


def pavilion(mesh):
    """The glass ball over the pool, on a six-sided foot."""
    mesh.object("plinth")
    top = ring(0, 18, 1.6, 4.2, 6)
    walls(mesh, "stone", ring(0, 18, 0.2, 5.0, 6), top, PLAIN)
    mesh.face("stone", top)
    mesh.object("glass_ball")
    geodesic(mesh, "glass", (0.0, 10.8, 18.0), 9.0)


def mirror_tower(mesh):
    """The tower that closes the avenue: rings that turn half a step from floor to floor."""
    mesh.object("mirror_tower")
    x, z = 0.0, -152.0
    rings = [
        ring(x, z, y, radius, 8, turn)
        for y, radius, turn in ((0, 24, 0.0), (44, 27, 0.5), (90, 21, 1.0), (130, 13, 1.5))
    ]
    for lower, upper in zip(rings, rings[1:]):
        antiprism(mesh, "mirror", lower, upper, 8.0)
    cone(mesh, "mirror", rings[-1], (x, 170.0, z), 8.0)


def hills(mesh):
    """Two rings of ridges, open sheets that face the city."""
    mesh.object("hills")
    for material, count, distance, tall, phase in (
        ("hill_near", 12, 1700.0, 190.0, 0.2), ("hill_far", 12, 2300.0, 420.0, 0.6)
    ):
        for i in range(count):
            angle = 2 * math.pi * (i + phase) / count
            half = 2 * math.pi / count * (0.82 + 0.16 * math.sin(5.1 * i))
            peak = tall * (0.72 + 0.28 * math.sin(2.3 * i + phase))
            reach = distance * (1 + 0.06 * math.cos(3.7 * i))
            left, right = (
                (reach * math.cos(a), 0.0, -reach * math.sin(a)) for a in (angle + half, angle - half)
            )
            top = (reach * math.cos(angle), peak, -reach * math.sin(angle))
            mesh.face(material, [left, right, top], [(0, 0), (1, 0), (0.5, 1)])


def trees(mesh):
    """Poplars along the lawns: two four-sided points, base to base."""
    places = [(x, z) for z in (-60, -40, -20, 0, 20, 40, 60, 80) for x in (-20.5, 20.5)]
    places = [place for place in places if place not in ((20.5, 40), (20.5, 60))]
    for i, (x, z) in enumerate(places):
        mesh.object(f"tree_{i + 1:02}")
        leaf = ("leaf", "leaf_light", "leaf", "leaf_gold", "leaf_light")[(i * 7 + i // 2) % 5]
        height = 9.5 + 2.5 * math.sin(i * 2.1)
        poplar(mesh, leaf, x, 0.1, z, height, 2.3 + 0.4 * math.sin(i * 1.3), i * 0.37)


def poplar(mesh, leaf, x, y, z, height, radius, turn):
    """A tree of eight triangles that stands on the point (x, y, z)."""
    waist = ring(x, z, y + height * 0.36, radius, 4, turn)
    cone(mesh, leaf, waist, (x, y + height, z))
    cone(mesh, leaf, waist[::-1], (x, y, z))


def blimp():
    """The airship, nose along -Z, 46 m long: a smooth hull, four fins, a gondola."""
    mesh = Mesh()
    mesh.object("hull")
    sides, stations = 14, [0.0, 0.02, 0.075, 0.16, 0.3, 0.5, 0.68, 0.82, 0.93, 1.0]
    skin = [[hull_point(t, i / sides) for i in range(sides + 1)] for t in stations]
    for lower, upper, t0, t1 in zip(skin, skin[1:], stations, stations[1:]):
        for i in range(sides):
            corners = [(lower, i, t0), (upper, i, t1), (upper, i + 1, t1), (lower, i + 1, t0)]
            if t0 == 0.0:
                corners.pop(3)
            elif t1 == 1.0:
                corners.pop(2)
            mesh.face(
                "hull",
                [r[k][0] for r, k, _ in corners],
                [(t, k / sides) for _, k, t in corners],
                [r[k][1] for r, k, _ in corners],
            )
    mesh.object("fins")
    for dx, dy in ((1, 0), (0, 1), (-1, 0), (0, -1)):
        fin(mesh, dx, dy)
    mesh.object("gondola")
    top = box_ring(0.0, -4.0, -5.4, 3.0, 9.0)
    floor = box_ring(0.0, -4.0, -8.2, 2.2, 6.5)
    walls(mesh, "gondola", floor, top, PLAIN)
    mesh.face("gondola", floor[::-1])
    return mesh


def hull_point(t, around):
    """Position and normal of the hull at `t` from nose to tail, `around` from keel to keel."""
    def radius(s):
        return 6.3 * max(0.0, 4 * s * (1 - s)) ** 0.5 * (1.13 - 0.26 * s)

    angle, step = 2 * math.pi * around, 1e-4
    r = radius(t)
    if t in (0.0, 1.0):
        normal = (0.0, 0.0, -1.0 if t == 0.0 else 1.0)
    else:
        slope = (radius(t + step) - radius(t - step)) / (2 * step * 46.0)
        length = math.hypot(1.0, slope)
        normal = (-math.sin(angle) / length, -math.cos(angle) / length, -slope / length)
    return (-r * math.sin(angle), -r * math.cos(angle), 46.0 * (t - 0.5)), normal


def fin(mesh, dx, dy):
    """A tapering wedge that stands out from the tail along (dx, dy)."""
    def at(out, side, z):
        return (dx * out - dy * side, dy * out + dx * side, z)

    left = [at(1.6, 0.5, 13.0), at(1.6, 0.5, 21.0), at(8.4, 0.0, 22.5), at(8.4, 0.0, 17.5)]
    right = [at(1.6, -0.5, 13.0), at(8.4, 0.0, 17.5), at(8.4, 0.0, 22.5), at(1.6, -0.5, 21.0)]
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    mesh.face("fin", left, square)
    mesh.face("fin", right, square)
    mesh.face("fin", [left[0], left[3], right[0]], square[:3])
    mesh.face("fin", [left[1], right[3], left[2]], square[:3])


def sign():
    """The four-sided golden mirror that turns on its pole; origin on the pole, at its widest."""
    mesh = Mesh()
    mesh.object("sign")
    waist = ring(0, 0, 0.0, 5.6, 4, 0.5)
    cone(mesh, "gold", waist, (0.0, 9.5, 0.0))
    cone(mesh, "gold", waist[::-1], (0.0, -5.6, 0.0))
    return mesh


def city():
    """All that stands still."""
    mesh = Mesh()
    ground(mesh)
    pool(mesh)
    pavilion(mesh)
    mirror_tower(mesh)
    for i, row in enumerate(TOWERS):
        mesh.object(f"tower_{i + 1:02}_{row[0]}")
        tower(mesh, *row)
    rooftops(mesh)
    trees(mesh)
    trams(mesh)
    hills(mesh)
    mesh.object("sign_pole")
    cone(mesh, "pole", ring(20.5, 50, 0.2, 0.7, 4), (20.5, 12.0, 50))
    return mesh


def linear(colour):
    """sRGB hex to linear red, green, blue."""
    values = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return [v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in values]


def write_materials(path):
    """Write the MTL file that the three models share."""
    lines = ["# The materials of the city, of its blimp and of its sign. Colours are linear."]
    for name, (colour, more) in MATERIALS.items():
        lines += ["", f"newmtl {name}", "Kd " + " ".join(f"{v:.4f}" for v in linear(colour))]
        lines += more.split("\n") if more else []
        if "illum" not in more:
            lines.append("illum 1")
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def main():
    models = {"city": city(), "blimp": blimp(), "sign": sign()}
    for name, mesh in models.items():
        mesh.write(FOLDER / f"{name}.obj", "city.mtl", "Made by make_city.py. CC0.")
        print(f"{name}: {mesh.count()} polygons")
    total = sum(mesh.count() for mesh in models.values())
    print(f"in all: {total}")
    write_materials(FOLDER / "city.mtl")
    textures.write_all(FOLDER)
    if total != POLYGONS:
        raise SystemExit(f"the city is to have {POLYGONS} polygons, and has {total}")


if __name__ == "__main__":
    main()

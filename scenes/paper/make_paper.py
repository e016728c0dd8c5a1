#!/usr/bin/env python3
"""Builds the scenes of the paper's three animations: `python3 scenes/paper/make_paper.py` writes OBJ, MTL and shot files
beside it. Needs nothing but Python.

Adelson and Hodges tell what their scene was made of, and not what it showed: 755 polygons, 578 of them partially
reflective; 41 quadrics, all partially reflective, four of them refractive as well; two infinite planes for ground and
sky; one light. This is a park of as many. The counts are checked. Metres, Y up.
"""

import math
import sys
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent / "city"))
from mesh import Mesh, box_ring, cone, geodesic, rectangle, ring  # noqa: E402

MATT, REFLECTIVE, QUADRICS, REFRACTIVE = 177, 578, 41, 4

# name: MTL statements. illum 3 reflects by Ks beside its Kd; illum 7 refracts as well.
MATERIALS = {
    "paving_light": "Kd 0.70 0.66 0.58\nillum 1",
    "paving_dark": "Kd 0.36 0.33 0.30\nillum 1",
    "kiosk": "Kd 0.80 0.28 0.16\nillum 1",
    "steel": "Kd 0.24 0.27 0.32\nKs 0.35 0.36 0.38\nNs 200\nillum 3",
    "bronze": "Kd 0.42 0.26 0.10\nKs 0.30 0.24 0.16\nNs 120\nillum 3",
    "azure": "Kd 0.10 0.28 0.52\nKs 0.25 0.25 0.25\nNs 200\nillum 3",
    "pool": "Kd 0.05 0.16 0.18\nKs 0.45 0.47 0.48\nNs 400\nillum 3",
    "stone": "Kd 0.62 0.58 0.52\nKs 0.12 0.12 0.12\nNs 60\nillum 3",
    "gold": "Kd 0.52 0.36 0.08\nKs 0.40 0.32 0.18\nNs 300\nillum 3",
    "leaf": "Kd 0.12 0.34 0.12\nKs 0.10 0.12 0.10\nNs 40\nillum 3",
    "mirror": "Kd 0.06 0.06 0.07\nKs 0.80 0.80 0.80\nNs 600\nillum 3",
    "glass": "Kd 0 0 0\nKs 1 1 1\nNs 600\nNi 1.5\nd 0.1\nillum 7",
    "hull": "Kd 0.70 0.20 0.18\nKs 0.20 0.20 0.20\nNs 80\nillum 3",
    "iron": "Kd 0.16 0.16 0.17\nKs 0.25 0.25 0.26\nNs 100\nillum 3",
    "lawn": "Kd 0.20 0.34 0.14\nillum 1",
    "sky": "Kd 0 0 0\nKe 0.32 0.52 0.86\nillum 1",
}

COLUMNS = [(x, z) for x in (-36, -12, 12, 36) for z in (-30, 0, 30)]


def box(mesh, material, x, z, low, high, width, depth):
    """Four walls and a roof: five polygons."""
    lower, upper = box_ring(x, z, low, width, depth), box_ring(x, z, high, width, depth)
    prism(mesh, material, lower, upper)
    mesh.face(material, upper)


def prism(mesh, material, lower, upper):
    """The walls between two rings of as many corners."""
    for i in range(len(lower)):
        j = (i + 1) % len(lower)
        mesh.face(material, [lower[i], lower[j], upper[j], upper[i]])


def park():
    mesh = Mesh()
    mesh.object("paving")
    for column in range(15):
        for row in range(11):
            x, z = -52.5 + 7 * column, -38.5 + 7 * row
            shade = "paving_light" if (column + row) % 2 == 0 else "paving_dark"
            mesh.face(shade, rectangle(x, z, x + 7, z + 7, 0.05))
    mesh.object("kiosks")
    for x in (-24, 24):
        box(mesh, "kiosk", x, 46, 0, 5, 8, 6)
        mesh.face("kiosk", rectangle(x - 5, 42, x + 5, 50, 5.4))
    assert mesh.count() == MATT, mesh.count()

    mesh.object("round_towers")
    for i in range(12):
        angle = 2 * math.pi * (i + 0.5) / 12
        x, z, height = 95 * math.cos(angle), -95 * math.sin(angle), 26 + 14 * math.sin(5 * angle)
        lower, upper = ring(x, z, 0, 5, 8), ring(x, z, height, 5, 8)
        prism(mesh, "steel", lower, upper)
        mesh.face("steel", upper)
    mesh.object("towers")
    for i in range(20):
        angle = 2 * math.pi * i / 20
        x, z, height = 140 * math.cos(angle), -140 * math.sin(angle), 34 + 20 * math.cos(3 * angle)
        box(mesh, "azure" if i % 2 else "bronze", x, z, 0, height, 9, 9)
    mesh.object("globes")
    for x, z in ((-66, -52), (66, -52), (-66, 52), (66, 52)):
        geodesic(mesh, "steel", (x, 11, z), 10)
    mesh.object("obelisks")
    for x in (-24, 24, 0, -48, 48):
        top = box_ring(x, -54, 16, 2.4, 2.4)
        prism(mesh, "bronze", box_ring(x, -54, 0, 4, 4), top)
        cone(mesh, "gold", top, (x, 19, -54))
    mesh.object("pool")
    for i in range(10):
        mesh.face("pool", rectangle(-25 + 5 * i, 8, -20 + 5 * i, 22, 0.3))
    assert mesh.count() == MATT + REFLECTIVE, mesh.count()
    return mesh


def spinner():
    """Four polygons that face all ways."""
    mesh = Mesh()
    mesh.object("spinner")
    prism(mesh, "mirror", box_ring(0, 0, 0, 14, 14), box_ring(0, 0, 22, 14, 14))
    assert mesh.count() == 4
    return mesh


def gondola():
    """26 polygons: what hangs below the blimp's hull, and its fins."""
    mesh = Mesh()
    mesh.object("gondola")
    box(mesh, "iron", 0, 0, -7.5, -5, 9, 3)
    mesh.face("iron", list(reversed(box_ring(0, 0, -7.5, 9, 3))))
    mesh.object("fins")
    for y, z, height, depth in ((4.5, 0, 4, 0.4), (-6.5, 0, 3, 0.4), (-0.2, 4.5, 0.4, 4), (-0.2, -4.5, 0.4, 4)):
        box(mesh, "hull", -14, z, y, y + height, 5, depth)
    assert mesh.count() == 26, mesh.count()
    return mesh


def hook():
    """8 polygons above the weight."""
    mesh = Mesh()
    mesh.object("hook")
    top = box_ring(0, 0, 5, 1.6, 1.6)
    prism(mesh, "iron", box_ring(0, 0, 3.2, 2.4, 2.4), top)
    cone(mesh, "iron", top, (0, 8, 0))
    assert mesh.count() == 8
    return mesh


def quadrics():
    """Each: name, keys of the quadric, where it stands."""
    all = []
    for i, (x, z) in enumerate(COLUMNS):
        all.append((f"column {i + 1}", 'type = "cylinder", radius = 1.2, height = 9, material = "stone"', (x, 0, z)))
        all.append((f"ball {i + 1}", 'type = "sphere", radius = 2, material = "gold"', (x, 11, z)))
    for i, (x, z) in enumerate(((-24, -15), (24, -15), (-24, 38), (24, 38))):
        all.append((f"glass {i + 1}", 'type = "sphere", radius = 4, material = "glass"', (x, 4.2, z)))
    for i in range(5):
        keys = 'type = "cone", radius = 4.5, height = 15, material = "leaf"'
        all.append((f"tree {i + 1}", keys, (-60 + 30 * i, 0, 66)))
    for i in range(3):
        keys = 'type = "ellipsoid", radii = [5, 2.2, 3], material = "azure"'
        all.append((f"pebble {i + 1}", keys, (-16 + 16 * i, 2.2, 54)))
    for i in range(3):
        keys = 'type = "paraboloid", radius = 5, height = 4, open = true, material = "bronze"'
        all.append((f"bowl {i + 1}", keys, (-30 + 30 * i, 0, -72)))
    for i in range(2):
        keys = 'type = "hyperboloid", radius = 7, height = 24, waist = 4.5, material = "stone"'
        all.append((f"cooling tower {i + 1}", keys, (-70 + 140 * i, 0, 0)))
    assert len(all) == QUADRICS and sum("glass" in keys for _, keys, _ in all) == REFRACTIVE
    return all


def model(name, what, translate=None, keys=()):
    lines = ["[[model]]", f'name = "{name}"', what]
    if translate:
        lines.append(f"translate = {list(translate)}")
    for frame, pose in keys:
        lines += ["", "[[model.key]]", f"frame = {frame}", *pose]
    return "\n".join(lines)


def at(place, turn=None):
    lines = [f"translate = {list(place)}"]
    return lines + ([f"rotate = {list(turn)}"] if turn else [])


def shot(title, note, frames, samples, camera, more):
    """The text of a shot file. `more`: models beside the park's."""
    head = f"""# {note}
# Written by make_paper.py.
title = "{title}"

[render]
size = [640, 480]
samples = {samples}
frames = "1-{frames}"
rate = 30
depth = 3
mode = "reproject"
base_every = 0

[output]
path = "out/paper/{title.lower().replace(' ', '-')}.####.exr"

[camera]
interpolation = "smooth"
"""
    for frame, eye, target, roll in camera:
        head += f"\n[[camera.key]]\nframe = {frame}\neye = {list(eye)}\ntarget = {list(target)}\nroll = {roll}\nfov = 50\n"
    models = [
        model("ground", 'quadric = { type = "plane", material = "lawn" }'),
        model("sky", 'quadric = { type = "plane", material = "sky" }', (0, 400, 0)),
        model("park", 'obj = "park.obj"'),
        *(model(name, f"quadric = {{ {keys} }}", place) for name, keys, place in quadrics()),
        *more,
    ]
    light = '[[light]]\nname = "lamp"\ntype = "point"\nposition = [120, 260, 160]\ncolor = [1, 0.96, 0.88]\npower = 90000'
    ambient = "[ambient]\ncolor = [0.22, 0.24, 0.28]"
    return "\n\n".join([head.rstrip(), *models, light, ambient, materials()]) + "\n"


def materials():
    """Those of quadrics, which have no MTL file."""
    tables = []
    for name in ("stone", "gold", "glass", "leaf", "azure", "bronze", "lawn", "sky", "hull", "iron"):
        lines = ["[[material]]", f'name = "{name}"']
        for statement in MATERIALS[name].split("\n"):
            key, *numbers = statement.split()
            lines.append(f"{key.lower()} = {numbers[0] if len(numbers) == 1 else '[' + ', '.join(numbers) + ']'}")
        tables.append("\n".join(lines))
    return "\n\n".join(tables)


# Away from the park first: nothing is in sight but the two planes. Then about all three axes, and through it.
FLIGHT = [
    (1, (20, 34, 205), (-300, 44, 290), 0),
    (78, (16, 34, 203), (-260, 42, 240), -4),
    (178, (-10, 34, 178), (-20, 12, 0), 8),
    (262, (-21, 30, 138), (0, 8, 0), 4),
    (350, (-8, 26, 106), (6, 6, -10), -6),
    (434, (8, 24, 84), (8, 6, -24), 5),
    (517, (31, 23, 60), (-8, 6, -24), -4),
    (600, (43, 25, 34), (-24, 4, -10), 0),
]


def stretched(keys, frames):
    """The same flight in another number of frames."""
    return [(round(1 + (frame - 1) * (frames - 1) / 599), *rest) for frame, *rest in keys]


def shots():
    blimp = [(1, (260, 74, -60), (0, 8, 0)), (932, (-190, 66, -10), (0, -6, 0))]
    blimp = [(frame, at(place, turn)) for frame, place, turn in blimp]
    # falls from its crane by gravity, 9.81 m/s^2: in 30 frames a second 60 m take 105 frames
    fall = [(1, at((0, 64, -24))), (500, at((0, 64, -24)))]
    fall += [(500 + step, at((0, round(64 - 0.5 * 9.81 * (step / 30) ** 2, 3), -24))) for step in range(5, 106, 5)]
    ball = 'quadric = { type = "sphere", radius = 3.4, material = "iron" }'
    hull = 'quadric = { type = "ellipsoid", radii = [18, 5.5, 5.5], material = "hull" }'
    # two levels: with them a full frame has the 1.6 primary rays a pixel that the paper's had, of which its 0.05 are 3 %
    adaptive = "{ min = 1, max = 2 }"
    return {
        "animation1.toml": shot(
            "Animation 1", "The paper's first animation: 600 frames, the camera turns about all three axes; one ray a pixel.",
            600, "1", FLIGHT, [],
        ),
        "animation2.toml": shot(
            "Animation 2", "The paper's second: 300 frames from above, at rest; a mirror with four sides turns; two levels of "
            "adaptive samples.",
            300, adaptive, [(1, (0, 150, 78), (0, 0, 6), 0)],
            [model("spinner", 'obj = "spinner.obj"', None,
                   [(1, at((0, 0, 0), (0, 0, 0))), (301, at((0, 0, 0), (0, 720, 0)))])],
        ),
        "animation3.toml": shot(
            "Animation 3", "The paper's third: the first flight in 932 frames, a blimp flies and a weight falls; two levels of "
            "adaptive samples.",
            932, adaptive, stretched(FLIGHT, 932),
            [model("blimp", 'obj = "gondola.obj"', None, blimp), model("hull", hull, None, blimp),
             model("hook", 'obj = "hook.obj"', None, fall), model("weight", ball, None, fall)],
        ),
    }


def main():
    for name, mesh in (("park", park()), ("spinner", spinner()), ("gondola", gondola()), ("hook", hook())):
        mesh.write(FOLDER / f"{name}.obj", "paper.mtl", f"{name}: made by make_paper.py")
    text = "\n\n".join(f"newmtl {name}\n{statements}" for name, statements in MATERIALS.items())
    (FOLDER / "paper.mtl").write_text(f"# made by make_paper.py\n{text}\n", encoding="ascii")
    for name, text in shots().items():
        (FOLDER / name).write_text(text, encoding="ascii")


if __name__ == "__main__":
    main()

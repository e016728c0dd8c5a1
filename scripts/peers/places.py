"""Where the camera stands in each scene, and what lights it; plain dictionaries, which go to all renderers.

Lengths are in the scene's units. Colours are linear RGB with Rec. 709 primaries. A view's `fov` is vertical, in degrees.
"""

import math
import pathlib

import numpy as np

from . import scene

FRAMES = 24  # of the moves of the camera
TURN, SHUTTER = 2.0, 0.5  # of a camera that turns: degrees a frame, and how much of a frame the shutter is open
DISC = 5 / 180  # of a lens: the disc of a point twice as far away as what is in focus, as a share of the picture's height
ROOT = pathlib.Path(__file__).resolve().parents[2]


def kitchen(folder, size, *, plate=False, roughness=None, camera="sharp"):
    """The kitchen under a panel at its ceiling, with a dolly into it of a centimetre a frame.

    The `camera` may have a "lens" on this way; or it "turns" instead, where the dolly ends, with a shutter.

    With a `roughness` its materials reflect, and an even white sky shines in through its windows.

    The panel shines downwards, and the camera does not see it. Mitsuba's panel is a surface that takes what light meets it, and
    Afterimage's is none: with a black `plate` above it they are alike.
    """
    above = [four_sided("plate", [level(2.301, [-0.2, 0.8], [0.9, 1.5], up=False)], [0, 0, 0], [0, 0, 0])]
    travel = np.array([-0.1052, -0.01015, -0.21559]) / FRAMES
    eye, target = np.array([1.211, 1.80475, 3.85239]), np.array([0.335, 1.72, 2.056])
    way = FRAMES - 1
    lit = {} if roughness is None else {"sky": [1.0, 1.0, 1.0]}
    made = lit | {
        "name": "kitchen",
        "scene": str(scene.real("kitchen", folder, above if plate else (), roughness)),
        "size": size,
        "fov": 40,
        # the view that is measured: the dolly's last frame
        "eye": (eye + way * travel).tolist(),
        "target": (target + way * travel).tolist(),
        "dolly": {"frames": FRAMES, "eye": eye.tolist(), "target": target.tolist()},
        "panel": {"center": [0.3, 2.3, 1.2], "size": [1.0, 0.6], "radiance": 15.0},
    }
    if camera == "lens":
        made["lens"] = lens(made)
    elif camera == "turns":
        del made["dolly"]
        made["turn"] = {"frames": FRAMES, "degrees": TURN, "shutter": SHUTTER}
    return made


def lens(place):
    """A lens that is focused on what the camera looks at."""
    focus = math.dist(place["eye"], place["target"])
    # twice as far away as the focus, discs are as wide as the lens's radius is at the focus
    return {"focus": focus, "radius": DISC * 2 * focus * math.tan(math.radians(place["fov"]) / 2)}


def city(folder, size, *, roughness):
    """The city that comes with the project, of rough materials, under a sun and an even sky; the first frames of its crane shot.

    What moves in that shot, and what emits, is left out.
    """
    eye, target = np.array([-16.0, 63.0, 165.0]), np.array([4.0, 48.0, 0.0])
    to_eye, to_target = np.array([-9.6, 55.0, 153.8]), np.array([2.0, 47.6, 0.0])
    return {
        "name": "city",
        "scene": str(scene.matt_version(ROOT / "scenes/city/city.obj", folder, roughness=roughness, lamps=False)),
        "size": size,
        "fov": 46,
        "eye": to_eye.tolist(),
        "target": to_target.tolist(),
        "dolly": {"frames": FRAMES, "eye": eye.tolist(), "target": target.tolist()},
        "sky": [0.4, 0.5, 0.7],
        "sun": {"direction": [0.7, -0.56, -0.44], "irradiance": 4.0},
    }


def dolly_view(place, frame):
    """Eye and target of the dolly in one of its frames."""
    dolly = place["dolly"]
    share = (frame - 1) / (dolly["frames"] - 1)
    return [
        (np.array(dolly[end]) * (1 - share) + np.array(place[end]) * share).tolist() for end in ("eye", "target")
    ]


def heading(place, frame):
    """Pitch and yaw, in degrees, of a camera that turns: up, and left of -Z. In the last frame it looks at its target."""
    right, up, back = np.array(place["target"]) - place["eye"]
    yaw = math.degrees(math.atan2(-right, -back))
    to_come = place["turn"]["frames"] - frame
    return math.degrees(math.atan2(up, math.hypot(right, back))), yaw - to_come * place["turn"]["degrees"]


def turn_ends(place):
    """The frames between which a camera turns: beyond its first and last, as the shutter opens before them and closes after."""
    return 0, place["turn"]["frames"] + 1


def bathroom(folder, size):
    """The bathroom from its camera; no light yet but its lamps."""
    eye = np.array([0.00724053, 0.912405, -0.227584])
    across = math.radians(55)
    return {
        "name": "bathroom",
        "scene": str(scene.real("bathroom", folder)),
        "size": size,
        "fov": math.degrees(2 * math.atan(math.tan(across / 2) * size[1] / size[0])),
        "eye": eye.tolist(),
        "target": (eye + np.array([-0.751879, 0.015471, -0.659119])).tolist(),
    }


def cornell(folder, size, *, closed):
    """Two blocks in a box of 2 x 2 x 2 whose front is open: under a lamp, or without a ceiling under the sky."""
    if scene.made_from(folder) != [scene.FORMAT, "cornell", closed]:
        scene.write(folder, cornell_parts(closed), [scene.FORMAT, "cornell", closed])
    return {
        "name": "box",
        "scene": str(folder),
        "size": size,
        "fov": 38,
        "eye": [0, 1, 4.2],
        "target": [0, 1, 0],
    }


def cornell_parts(closed):
    """The parts of the box, each a list of four-sided faces."""
    white = [
        level(0, [-1, 1], [-1, 1], up=True),
        [[-1, 0, -1], [1, 0, -1], [1, 2, -1], [-1, 2, -1]],
        *block([-0.35, 0.6, -0.3], [0.3, 0.6, 0.3], 0.3),
        *block([0.33, 0.3, 0.35], [0.3, 0.3, 0.3], -0.3),
    ]
    parts = [
        ("red", [[[-1, 0, 1], [-1, 0, -1], [-1, 2, -1], [-1, 2, 1]]], [0.63, 0.065, 0.05], [0, 0, 0]),
        ("green", [[[1, 0, -1], [1, 0, 1], [1, 2, 1], [1, 2, -1]]], [0.14, 0.45, 0.091], [0, 0, 0]),
    ]
    if closed:
        white.append(level(2, [-1, 1], [-1, 1], up=False))
        # Mitsuba's surfaces emit to their front, Afterimage's to both sides: a black plate takes what goes up, and leaves no gap to speak of
        parts.append(("plate", [level(1.981, [-0.26, 0.26], [-0.24, 0.18], up=False)], [0, 0, 0], [0, 0, 0]))
        parts.append(("lamp", [level(1.98, [-0.24, 0.24], [-0.22, 0.16], up=False)], [0, 0, 0], [17, 12, 4]))
    parts.append(("white", white, [0.73, 0.73, 0.73], [0, 0, 0]))
    return [four_sided(*one) for one in parts]


def level(height, x, z, *, up):
    """A level rectangle that faces up or down."""
    corners = [[x[0], height, z[1]], [x[1], height, z[1]], [x[1], height, z[0]], [x[0], height, z[0]]]
    return corners if up else corners[::-1]


def block(center, half, turn):
    """The faces of a block that stands on the floor, but for the one that it stands on; turned about Y, in radians."""
    sine, cosine = math.sin(turn), math.cos(turn)

    def corner(x, y, z):
        x, y, z = x * half[0], y * half[1], z * half[2]
        return [center[0] + cosine * x + sine * z, center[1] + y, center[2] - sine * x + cosine * z]

    ring = [(-1, 1), (1, 1), (1, -1), (-1, -1)]
    sides = [[(*at, -1), (*to, -1), (*to, 1), (*at, 1)] for at, to in zip(ring, ring[1:] + ring[:1])]
    return [[corner(x, y, z) for x, z, y in side] for side in sides] + [[corner(x, 1, z) for x, z in ring]]


def four_sided(name, faces, albedo, emission):
    """A part of a scene of faces with four corners each."""
    positions = np.array(faces, np.float32).reshape(-1, 3)
    first = 4 * np.arange(len(faces))[:, None]
    triangles = np.concatenate([first + [0, 1, 2], first + [0, 2, 3]]).astype(np.int32)
    return scene.part(name, positions, triangles, albedo, emission=emission)

"""Helpers of several tests: small scenes, and the program to compare with."""

import os
import pathlib
import subprocess

import numpy as np

import afterimage

ROOT = pathlib.Path(__file__).resolve().parents[2]
COURT = ROOT / "scenes" / "court" / "court.toml"

CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float32)
CUBE_FACES = (
    np.array([0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3], np.int32),
    np.full(6, 4, np.int32),
)


def moved(x=0.0, y=0.0, z=0.0):
    """A matrix that moves by a vector."""
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def still(**settings):
    """A red cube above a grey floor, in the sun."""
    scene = afterimage.Scene(**{"size": (64, 48), "samples": 1, **settings})
    red = scene.add_material("red", base_color=(0.8, 0.1, 0.1), roughness=0.6)
    grey = scene.add_material("grey", base_color=(0.5, 0.5, 0.5))
    scene.add_mesh("cube", CUBE, CUBE_FACES, material=red, transform=moved(y=1))
    floor = np.array([[-9, 0, -9], [-9, 0, 9], [9, 0, 9], [9, 0, -9]], np.float32)
    scene.add_mesh("floor", floor, np.array([[0, 1, 2], [0, 2, 3]], np.int32), material=grey)
    scene.add_light("sun", direction=(-1, -2, -1), power=3)
    scene.set_camera(eye=(4, 3, 6), target=(0, 1, 0), fov=40)
    scene.set_background(color=(0.2, 0.3, 0.5))
    return scene


def program():
    """Path of the program `afterimage`, if one is at hand: AFTERIMAGE_PROGRAM names it."""
    named = os.environ.get("AFTERIMAGE_PROGRAM")
    return named if named and pathlib.Path(named).is_file() else None


def rendered_by_program(shot, frames, folder, *options):
    """Paths of the EXR files of frames that the program has rendered, by number."""
    pattern = os.path.join(folder, "frame.####.exr")
    command = [program(), "render", str(shot), "--frames", frames, "-o", pattern, "--quiet", "--progress", "none"]
    subprocess.run([*command, *options], check=True, cwd=folder, stdin=subprocess.DEVNULL)
    return {int(path.name.split(".")[1]): path for path in sorted(pathlib.Path(folder).glob("frame.*.exr"))}


def picture(scene, **settings):
    (frame,) = afterimage.render(scene, frames=settings.pop("frames", 1), **settings)
    return frame.layers

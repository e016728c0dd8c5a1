"""Loading of large meshes: seconds and memory from the start of a process to the end of its first frame, which is small."""

import json
import os
import pathlib
import subprocess
import sys
import time

import numpy as np

from . import afterimage, workers
from .report import markdown, say

TRIANGLES = {"10 M": 10_000_000, "30 M": 30_000_000}
SMALL = {"0.2 M": 200_000}
KINDS = ["obj", "ply", "glb"]
SIZE = [64, 36]
EYE, TARGET, FOV = [0.5, 0.8, 1.9], [0.5, 0.0, 0.4], 40
MITSUBA = ["obj", "ply"]  # it reads no glTF
LINES = 1 << 20  # of a text file that are made at once


def main(work, quick):
    """Measures, and returns the table in Markdown."""
    work /= "load"
    work.mkdir(parents=True, exist_ok=True)
    found = workers.found()
    lines = [["triangles", "file", *(f"{name}, s; GiB" for name in found.values())]]
    lines.append(["---", "---", *["---:"] * len(found)])
    for words, triangles in (SMALL if quick else TRIANGLES).items():
        for kind in KINDS:
            file = made(work, kind, triangles)
            line = [words, f"{kind}, {file.stat().st_size / (1 << 20):.0f} MiB"]
            for renderer in found:
                if renderer == "mitsuba" and kind not in MITSUBA:
                    line.append("–")
                    continue
                seconds, memory = first_frame(work, renderer, kind, file)
                say(f"{renderer}, {words}, {kind}: {seconds:.1f} s, {memory:.2f} GiB")
                line.append(f"{seconds:.1f}; {memory:.2f}")
            lines.append(line)
            file.unlink()
    return markdown(lines) + "\n"


# --- files ---


def made(work, kind, triangles):
    """A wavy square of so many triangles, without normals and texture coordinates, as a file of that kind."""
    file = work / f"waves.{kind}"
    side = round((triangles / 2) ** 0.5)
    across = np.linspace(0, 1, side + 1, dtype=np.float32)
    x, z = np.meshgrid(across, across)
    y = 0.02 * np.sin(40 * x) * np.cos(31 * z)
    positions = np.stack([x, y, z], axis=2).reshape(-1, 3).astype("<f4")
    first = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    below = first + side + 1
    faces = np.stack([first, below, first + 1, first + 1, below, below + 1], axis=1).reshape(-1, 3).astype("<u4")
    {"obj": write_obj, "ply": write_ply, "glb": write_glb}[kind](file, positions, faces)
    return file


def write_obj(file, positions, faces):
    with open(file, "w", encoding="ascii") as out:
        for letter, rows in (("v", positions), ("f", faces + 1)):
            form = f"{letter} %.6g %.6g %.6g\n" if letter == "v" else f"{letter} %d %d %d\n"
            for part in range(0, len(rows), LINES):
                piece = rows[part : part + LINES]
                out.write((form * len(piece)) % tuple(piece.ravel().tolist()))


def write_ply(file, positions, faces):
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(positions)}"]
    head += [f"property float {axis}" for axis in "xyz"]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header\n"]
    rows = np.empty(len(faces), np.dtype([("count", "u1"), ("corners", "<i4", 3)]))
    rows["count"], rows["corners"] = 3, faces
    with open(file, "wb") as out:
        out.write("\n".join(head).encode())
        out.write(positions.tobytes())
        out.write(rows.tobytes())


def write_glb(file, positions, faces):
    sizes = [positions.nbytes, faces.nbytes]
    description = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "waves"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": sum(sizes)}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": sizes[0]}, {"buffer": 0, "byteOffset": sizes[0], "byteLength": sizes[1]}],
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "count": len(positions), "type": "VEC3",
                "min": positions.min(axis=0).tolist(), "max": positions.max(axis=0).tolist(),
            },
            {"bufferView": 1, "componentType": 5125, "count": faces.size, "type": "SCALAR"},
        ],
    }
    text = json.dumps(description).encode()
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + sum(sizes)
    with open(file, "wb") as out:
        out.write(b"glTF" + np.array([2, total, len(text)], "<u4").tobytes() + b"JSON" + text)
        out.write(np.array([sum(sizes)], "<u4").tobytes() + b"BIN\0" + positions.tobytes() + faces.tobytes())


# --- work ---


def first_frame(work, renderer, kind, file):
    """Seconds and GiB of a process that reads `file` and renders a frame of it."""
    if renderer == "afterimage":
        key = "gltf" if kind == "glb" else kind
        shot = work / "shot.toml"
        shot.write_text(
            f"[render]\nsize = {SIZE}\nsamples = 1\n[[camera.key]]\nframe = 1\neye = {EYE}\ntarget = {TARGET}\nfov = {FOV}\n"
            f'[[model]]\n{key} = "{file}"\n[[light]]\ntype = "point"\nposition = [0.5, 2.0, 0.5]\npower = 4\n'
        )
        line = [str(afterimage.program()), "render", str(shot), "--layers", "none", "-q", "-o", str(work / "first.####.exr")]
    else:
        job = work / "job.json"
        job.write_text(json.dumps({"renderer": renderer, "kind": kind, "file": str(file), "size": SIZE, "eye": EYE, "target": TARGET, "fov": FOV}))
        line = [sys.executable, "-m", "peers.loading_worker", str(job)]
    began = time.perf_counter()
    said = work / "said.txt"
    with open(said, "wb") as log:
        child = subprocess.Popen(line, stdout=log, stderr=subprocess.STDOUT, env=os.environ | {"PYTHONPATH": str(workers.SCRIPTS)})
        _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    seconds = time.perf_counter() - began
    if child.returncode != 0:
        raise workers.Failed(f"{renderer} ended with {child.returncode}:\n{said.read_text(errors='replace')[-2000:]}")
    return seconds, usage.ru_maxrss / (1 << 20)

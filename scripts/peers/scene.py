"""One scene for all renderers: triangles of matt or rough materials, as files that each of them can read.

A scene is a folder with `scene.json`, `mesh.npz` (for Mitsuba and Cycles) and `scene.obj` with `scene.mtl` (for
Afterimage). Positions are single floats, the same bits in all of them. There are no vertex normals: renderers
differ in what they make of these where surfaces turn away, and nothing here measures that.
"""

import json
import os
import pathlib

import numpy as np

# A matt surface that reflects more than this makes light last for dozens of bounces, in all renderers alike.
MOST_ALBEDO = 0.95
# What a matt surface takes of the highlight colour of the metal that it replaces.
METAL_SHARE = 0.7
# Of a material that the MTL file names without saying a colour.
UNSAID_ALBEDO = 0.5
# Illumination models of MTL that mean glass.
GLASS = {4, 6, 7, 9}

FORMAT = 2  # of the folder: raise it when what is written changes


class SceneMissing(Exception):
    """There is no such scene on this machine; the text says what to do."""


def collection():
    """The folder of scenes that are not shipped, as the benchmarks find it."""
    return pathlib.Path(os.environ.get("AFTERIMAGE_SCENES") or pathlib.Path.home() / ".cache/afterimage-scenes")


def real(name, folder, beside=(), roughness=None):
    """The matt version of scene `name` of the collection, made in `folder` where it is not there yet; with other parts `beside` it."""
    obj = collection() / name / f"{name}.obj"
    if not obj.is_file():
        raise SceneMissing(f"there is no {obj}; AFTERIMAGE_SCENES names the folder of such scenes")
    return matt_version(obj, folder, beside, roughness)


def matt_version(obj, folder, beside=(), roughness=None, lamps=True):
    """The matt version of an OBJ file, as a scene in `folder`; without `lamps` nothing emits.

    With a `roughness`, what is matt reflects as well, as plastic of this roughness does.
    """
    seen = obj.stat()
    source = [FORMAT, str(obj), seen.st_size, seen.st_mtime_ns, roughness, lamps, *[one["material"]["name"] for one in beside]]
    if made_from(folder) != source:
        parts = [one for one in (matt(*part) for part in read_obj(obj)) if one is not None]
        for one in parts:
            one["material"]["roughness"] = roughness
            if not lamps:
                one["material"]["emission"] = [0, 0, 0]
        write(folder, [*parts, *beside], source)
    return folder


def made_from(folder):
    """What the scene in `folder` was made from; None where there is none."""
    try:
        return json.loads((folder / "scene.json").read_text())["source"]
    except (OSError, ValueError, KeyError):
        return None


# --- reading ---


def read_obj(path):
    """The parts of an OBJ file by material: (triangles, material), in the order in which they are first used.

    Triangles are pairs of index arrays, shape (n, 3): of positions and of texture coordinates, -1 where a corner has
    none. They come with the arrays they index. Polygons are cut as fans.
    """
    lists, corners, current, libraries = {"v": [], "vt": []}, {}, "", []
    with open(path, encoding="utf-8", errors="replace") as lines:
        for line in lines:
            word, _, rest = line.partition(" ")
            if word in lists:
                lists[word].append(rest)
            elif word == "f":
                corners.setdefault(current, []).append(rest.split())
            elif word == "usemtl":
                current = rest.strip()
            elif word == "mtllib":
                libraries.append(path.parent / rest.strip())
    positions = numbers(lists["v"], 3)
    texture = numbers(lists["vt"], 2)
    materials = {}
    for library in libraries:
        materials.update(read_mtl(library))
    for name, faces in corners.items():
        fans = [(face[0], face[at], face[at + 1]) for face in faces for at in range(1, len(face) - 1)]
        split = [corner.split("/") for fan in fans for corner in fan]
        of_position = np.array([int(corner[0]) for corner in split])
        of_texture = np.array([int(corner[1]) if len(corner) > 1 and corner[1] else 0 for corner in split])
        if of_position.min() < 1 or of_texture.min() < 0:
            raise ValueError(f"{path}: indices that count back are not read here")
        yield name, positions, texture, of_position - 1, of_texture - 1, materials.get(name, {})


def numbers(texts, width):
    """The first `width` numbers of each text, as single floats."""
    return np.array([text.split()[:width] for text in texts], np.float32).reshape(-1, width)


def read_mtl(path):
    """The statements of each material of an MTL file."""
    materials, now = {}, {}
    for line in path.read_text(errors="replace").splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] == "newmtl":
            now = materials.setdefault(" ".join(words[1:]), {})
        elif words[0] == "map_Kd":
            now["map_Kd"] = str(path.parent / words[-1])
        elif words[0] in ("Kd", "Ks", "Ke"):
            now[words[0]] = [float(word) for word in words[1:4]]
        elif words[0] == "illum":
            now["illum"] = int(words[1])
    return materials


def matt(name, positions, texture, of_position, of_texture, material):
    """A part of a scene with the matt material that stands for `material`; None for glass, which is left out.

    A texture is the albedo. Metals, which have no diffuse colour, get a share of their highlight's.
    """
    if material.get("illum") in GLASS:
        return None
    albedo = material.get("Kd", [UNSAID_ALBEDO] * 3)
    if not any(albedo):
        albedo = [METAL_SHARE * share for share in material.get("Ks", [0, 0, 0])]
    emission = material.get("Ke", [0, 0, 0])
    image = material.get("map_Kd")
    albedo = [1.0] * 3 if image else [min(share, MOST_ALBEDO) for share in albedo]
    # a vertex for each pair of position and texture coordinate
    pairs, corners = np.unique(np.stack([of_position, of_texture], 1), axis=0, return_inverse=True)
    uv = np.zeros((len(pairs), 2), np.float32)
    if len(texture):
        uv = np.where(pairs[:, 1:] >= 0, texture[pairs[:, 1]], np.float32(0))
    faces = corners.reshape(-1, 3).astype(np.int32)
    return part(name, positions[pairs[:, 0]], faces, albedo, uv=uv, image=image, emission=emission)


def part(name, positions, faces, albedo, *, uv=None, image=None, emission=(0, 0, 0)):
    """Triangles of one material. Triangles without an area are left out: renderers differ in what they do with them."""
    a, b, c = (positions[faces[:, corner]].astype(np.float64) for corner in range(3))
    faces = faces[np.linalg.norm(np.cross(b - a, c - a), axis=1) > 0]
    uv = np.zeros((len(positions), 2), np.float32) if uv is None else uv
    material = {"name": name, "albedo": list(albedo), "image": image, "emission": list(emission), "roughness": None}
    return {"material": material, "positions": positions.astype(np.float32), "uv": uv, "faces": faces}


# --- writing ---


def write(folder, parts, source):
    """Writes a scene; `scene.json`, which says that it is complete, at the end."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "scene.json").unlink(missing_ok=True)
    parts = [one for one in parts if len(one["faces"])]
    arrays = {f"{name}{at}": one[name] for at, one in enumerate(parts) for name in ("positions", "uv", "faces")}
    np.savez(folder / "mesh.npz", **arrays)
    write_mtl(folder / "scene.mtl", parts)
    write_obj(folder / "scene.obj", parts)
    materials = [one["material"] for one in parts]
    (folder / "scene.json").write_text(json.dumps({"source": source, "materials": materials}, indent=1))


def write_mtl(path, parts):
    with open(path, "w", encoding="utf-8") as out:
        for at, one in enumerate(parts):
            material = one["material"]
            out.write(f"newmtl m{at}\nillum 1\nKa 0 0 0\n")
            out.write("Kd {} {} {}\n".format(*material["albedo"]))
            if material["roughness"] is not None:
                out.write(f"Pr {material['roughness']}\n")
            if any(material["emission"]):
                out.write("Ke {} {} {}\n".format(*material["emission"]))
            if material["image"]:
                out.write(f"map_Kd {material['image']}\n")


def write_obj(path, parts):
    with open(path, "w", encoding="utf-8") as out:
        out.write("mtllib scene.mtl\n")
        first = 1
        for at, one in enumerate(parts):
            out.write(f"usemtl m{at}\n")
            # nine digits bring back the same single float
            np.savetxt(out, one["positions"], "v %.9g %.9g %.9g")
            np.savetxt(out, one["uv"], "vt %.9g %.9g")
            np.savetxt(out, np.repeat(one["faces"] + first, 2, axis=1), "f %d/%d %d/%d %d/%d")
            first += len(one["positions"])


def load(folder):
    """The parts of the scene in `folder`, as `part` makes them."""
    folder = pathlib.Path(folder)
    materials = json.loads((folder / "scene.json").read_text())["materials"]
    with np.load(folder / "mesh.npz") as arrays:
        return [
            {"material": material} | {name: arrays[f"{name}{at}"] for name in ("positions", "uv", "faces")}
            for at, material in enumerate(materials)
        ]

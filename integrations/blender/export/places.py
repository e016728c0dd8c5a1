# SPDX-License-Identifier: GPL-3.0-or-later
"""Models of a shot, and where their copies are: in the shot file where there are few, in arrays beside it where there are many."""

import dataclasses
import itertools
import math
import os

import numpy as np

from . import toml
from .files import whole
from .light_links import keys_of
from .warnings import Cancelled

FEW = 64
"""Places of a mesh, those of all copies at all times, that a person may want to read in the shot file."""
MOST_BETWEEN = 8
"""Keys of an array for each time that was looked at: where more would be needed, times are too uneven, and are written out."""


TICKS = 1000
"""Parts of a frame of which times are wholes."""


class Grid:
    """Evenly spaced keys among which all times are."""

    def __init__(self, times):
        ticks = [round(time * TICKS) for time in times]
        step = math.gcd(*(after - before for before, after in zip(ticks, ticks[1:]))) or TICKS
        self.first, self.every = times[0], step / TICKS
        self.at = {time: (tick - ticks[0]) // step for time, tick in zip(times, ticks)}
        self.count = self.at[times[-1]] + 1
        exact = all(abs(self.first + self.at[time] * self.every - time) < 1e-9 for time in times)
        self.is_of_use = exact and self.count <= MOST_BETWEEN * len(times)
        self.after = {time: self.at[after] for time, after in zip(times, times[1:])}

    def keys(self, runs, matrices):
        """Matrices of a copy at all keys, (keys, 3, 4): zero where it is not there."""
        out = np.zeros((self.count, 12))
        for run in runs:
            at = [self.at[time] for time in run]
            values = np.array([matrices[time] for time in run])
            between = np.arange(at[0], at[-1] + 1)
            if len(at) == len(between):
                out[between] = values
            else:
                # as the renderer goes from key to key
                for column in range(12):
                    out[between, column] = np.interp(between, at, values[:, column])
            # it stays until it is gone
            out[at[-1] + 1 : self.after.get(run[-1], self.count)] = values[-1]
        return out.reshape(-1, 3, 4)


class Copy:
    """A copy of a mesh: its name, runs of times at which it is there, and its matrices by time. Each shows itself to the same rays at all times."""

    __slots__ = ("name", "random", "index", "runs", "matrices", "is_always", "rests")

    def __init__(self, placed, runs, times):
        matrices = placed.matrices
        self.name, self.random, self.index, self.runs, self.matrices = placed.name, placed.random, placed.index, runs, matrices
        self.is_always = len(runs) == 1 and len(runs[0]) == len(times)
        first = matrices[runs[0][0]]
        self.rests = all(np.array_equal(matrices[time], first) for run in runs for time in run)

    def matrix(self):
        """Where it is first."""
        return self.matrices[self.runs[0][0]]


def model_tables(walk, folder, progress):
    """[[model]] tables of all that was seen, the names of all models, those of their groups, and the models' pass indices."""
    by_mesh, names, indices, out = {}, [], [], []
    count = max(1, len(walk.placed))
    for index, placed in enumerate(walk.placed.values()):
        if index % 256 == 0 and not progress(index / count):
            raise Cancelled()
        for stored, seen, runs in runs_of(placed, walk.times):
            groups = by_mesh.setdefault(id(stored), (stored, {}))[1]
            groups.setdefault(seen, []).append(Copy(placed, runs, walk.times))
    grid, asks_random = Grid(walk.times), walk.meshes.materials.ask_random()
    tell_whole_holdouts(by_mesh, walk.warnings)
    tell_catchers(by_mesh, walk.warnings)
    linked = {name for _, groups in by_mesh.values() for seen in groups if not seen.is_nowhere() for name in seen.groups}
    for stored, groups in by_mesh.values():
        count = itertools.count(1)
        for (source, of_faces), (of_copies, copies) in itertools.product(stored.models(), groups.items()):
            seen = of_faces.and_of(of_copies)
            if seen.catcher and stored.reflects_nothing():
                # no light arrives on it of which any could be missing
                seen = dataclasses.replace(seen, hidden=seen.hidden | {"camera"})
            if seen.is_nowhere():
                continue
            links = keys_of(seen.links, linked)
            if links is None:
                walk.warnings.add(f"object `{copies[0].name}`: its light is linked to nothing that is shown, and lights everything here")
            source = {**source, **seen.keys(), **(links or {})}
            arrays = Arrays(folder, stored.folder, source, next(count), asks_random)
            for copies, write in divided(copies, grid, len(walk.times)):
                names += [copy.name for copy in copies]
                indices += [copy.index for copy in copies]
                out += write(arrays, copies) if write else [model(copy, source, walk.times, asks_random) for copy in copies]
    return out, names, linked, indices


def tell_whole_holdouts(by_mesh, warnings):
    """Tells of objects that are holes to the camera as a whole, where Blender has a hole in part."""
    for stored, groups in by_mesh.values():
        names = dict.fromkeys(copy.name for seen, copies in groups.items() if seen.keys().get("holdout") for copy in copies)
        if names and stored.has_veils():
            for name in names:
                warnings.add(f"object `{name}`: its holdout is a whole one also where its materials are clear in part")


def tell_catchers(by_mesh, warnings):
    """Tells of catchers of shadows beside each other: in Blender they keep no light from each other."""
    groups = [(stored, seen, copies) for stored, groups in by_mesh.values() for seen, copies in groups.items()]
    names = [copy.name for stored, seen, copies in groups if "shadow_catcher" in seen.keys() and not stored.reflects_nothing() for copy in copies]
    if len(names) > 1:
        shown = ", ".join(f"`{name}`" for name in list(dict.fromkeys(names))[:4])
        warnings.add(f"shadow catchers {shown}{' and others' if len(set(names)) > 4 else ''} cast shadows on each other, as they do not in Blender")


def divided(copies, grid, times):
    """Pairs of copies, and what writes them into an array; None for what is written into the shot file."""
    resting = [copy for copy in copies if copy.rests and copy.is_always]
    others = [copy for copy in copies if not (copy.rests and copy.is_always)]
    if len(resting) + len(others) * times <= FEW:
        return [(copies, None)]
    parts = [(resting, Arrays.at_rest if len(resting) > FEW else None)]
    return [*parts, (others, (lambda arrays, copies: arrays.with_keys(copies, grid)) if grid.is_of_use else None)]


class Arrays:
    """Arrays of the places of a mesh's copies, in the folder `beside` of the mesh's own files. `source`: what [[model]] tables say of the mesh.

    `number`: counts the arrays of one mesh, whose copies do not all show themselves to the same rays. `has_randoms`: with the numbers by which
    copies differ.
    """

    def __init__(self, folder, beside, source, number, has_randoms=False):
        self.folder, self.beside, self.source, self.has_randoms = folder, beside, source, has_randoms
        self.ending = f"-{number}" if number > 1 else ""

    def at_rest(self, copies):
        """The table of copies at rest."""
        places = np.array([copy.matrix() for copy in copies]).reshape(-1, 3, 4)
        return self._table("at-rest", copies, places.shape, [places], {})

    def with_keys(self, copies, grid):
        """The table of copies that move, or come and go."""
        if not copies:
            return []
        keys = (grid.keys(copy.runs, copy.matrices) for copy in copies)
        return self._table("places", copies, (len(copies), grid.count, 3, 4), keys, {"first": float(grid.first), "every": grid.every})

    def _table(self, kind, copies, shape, parts, more):
        """Writes an array that comes in parts, and the names; returns the table."""
        base = os.path.join(self.beside, kind + self.ending)

        def write(file):
            header = {"descr": "<f8", "fortran_order": False, "shape": tuple(int(extent) for extent in shape)}
            np.lib.format.write_array_header_1_0(file, header)
            for part in parts:
                file.write(np.ascontiguousarray(part, dtype="<f8").data)

        whole(f"{base}.npy", write)
        lines = "".join(" ".join(copy.name.splitlines()) + "\n" for copy in copies)
        whole(f"{base}.txt", lambda file: file.write(lines.encode()))
        if self.has_randoms:
            randoms = np.array([copy.random for copy in copies], dtype="<f8")
            whole(f"{base}-randoms.npy", lambda file: np.lib.format.write_array(file, randoms))
        base = os.path.relpath(base, self.folder).replace(os.sep, "/")
        places = {"file": f"{base}.npy", "names": f"{base}.txt", **({"randoms": f"{base}-randoms.npy"} if self.has_randoms else {}), **more}
        return [toml.table("[[model]]", {"name": copies[0].name, **self.source, "places": places})]


def runs_of(placed, times):
    """Meshes, the rays to which an object shows them, and the runs of times in which it does so without being turned inside out."""
    found = {}
    before = None
    for time in times:
        stored = placed.mesh.get(time)
        if stored is None:
            before = None
            continue
        matrix = placed.matrices[time]
        side = np.linalg.det(matrix.reshape(3, 4)[:, :3]) > 0
        seen = placed.seen[time]
        key = (id(stored), seen, bool(side))
        runs = found.setdefault(key, (stored, seen, []))[2]
        if before == key:
            runs[-1].append(time)
        else:
            runs.append([time])
        before = key
    return found.values()


def rows(matrix):
    """A matrix as [[model]] has it."""
    values = [float(value) for value in matrix]
    return [values[0:4], values[4:8], values[8:12]]


def model(copy, source, times, has_random=False):
    """One [[model]] with its keys. `has_random`: with the number by which copies differ."""
    table = {"name": copy.name, **source}
    if has_random:
        table["random"] = float(copy.random)
    if copy.rests:
        table["matrix"] = rows(copy.matrix())
    if not copy.is_always:
        table["visible"] = False
    out = [toml.table("[[model]]", table)]
    ends = {time: after for time, after in zip(times, times[1:])}
    for run in copy.runs:
        for index, time in enumerate(run):
            key = {"frame": time}
            if not copy.rests:
                key["matrix"] = rows(copy.matrices[time])
            if not copy.is_always and index == 0:
                key["visible"] = True
            if len(key) > 1:
                out.append(toml.table("[[model.key]]", key))
        after = ends.get(run[-1])
        if not copy.is_always and after is not None and all(after != other[0] for other in copy.runs):
            out.append(toml.table("[[model.key]]", {"frame": after, "visible": False}))
    return "".join(out)

# SPDX-License-Identifier: GPL-3.0-or-later
"""Pointiness of the vertices of a mesh, as Cycles has it: above 0.5 where it is convex, below where it is hollow.

A colour attribute stands for it: red is how far it is above 0.5, and green how far below, as shares of a half. So small differences about
0.5, where most surfaces are, keep their digits however few colours have, what is far from 0.5 is not cut off, what lies between vertices
is as Cycles interpolates it, and white, which meshes without colours have, is flat.
"""

import numpy as np

NAME = ".Pointiness"
"""Of the colour attribute that stands for it."""

FLAT = 0.5

NEAR = np.finfo(np.float32).eps
"""Vertices are one if their squared distance is less, and the sums of their coordinates differ by three times as much at most."""

ASLANT = np.array([0.4363, -0.7071, 0.5565])
"""A direction of unit length along which few vertices of lattices are as far as each other."""


def merged(positions):
    """For each vertex the one that stands for all at its place."""
    sums = positions.sum(axis=1, dtype=np.float32).astype(np.float64)
    by_sum = np.argsort(sums, kind="stable")
    runs = np.empty(len(sums), dtype=np.int64)
    runs[by_sum] = np.cumsum(np.diff(sums[by_sum], prepend=sums[by_sum[:1]]) > 3 * NEAR)
    along = positions @ ASLANT
    # those that may be one are next to each other, or nearly so
    order = np.lexsort((along, runs))
    sums, runs, along, places = sums[order], runs[order], along[order], positions[order].astype(np.float64)
    targets, searching, step = np.arange(len(order)), np.arange(len(order)), 0
    while len(searching):
        step += 1
        searching = searching[searching + step < len(order)]
        other = searching + step
        may_be = (runs[other] == runs[searching]) & (along[other] - along[searching] < np.sqrt(NEAR))
        searching, other = searching[may_be], other[may_be]
        apart = places[other] - places[searching]
        is_one = ((apart * apart).sum(axis=1) < NEAR) & (np.abs(sums[other] - sums[searching]) <= 3 * NEAR)
        targets[searching[is_one]] = other[is_one]
        searching = searching[~is_one]
    while not np.array_equal(targets, targets[targets]):
        targets = targets[targets]
    roots = np.empty(len(order), dtype=np.int64)
    roots[order] = order[targets]
    return roots


def sums_at(vertices, values, count):
    """Sums of the rows of some vertices, for each of `count` vertices."""
    return np.stack([np.bincount(vertices, weights=part, minlength=count) for part in values.T], axis=1)


def unit(vectors):
    """Vectors at unit length; those without any stay."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(length > 0, length, 1)


def both_ways(edges, count):
    """Starts and ends of edges, each of which counts once, in both directions."""
    low, high = np.divmod(np.unique(edges.min(axis=1) * count + edges.max(axis=1)), count)
    return np.concatenate([low, high]), np.concatenate([high, low])


def of_vertices(positions, normals, edges):
    """The pointiness of each vertex. `edges`: rows of two vertices."""
    count = len(positions)
    roots = merged(positions)
    starts, ends = both_ways(roots[edges], count)
    normals = unit(sums_at(roots, normals, count))
    met = np.bincount(starts, minlength=count)
    away = sums_at(starts, unit(positions[ends].astype(np.float64) - positions[starts]), count) / np.maximum(met, 1)[:, None]
    angles = np.arccos(np.clip((normals * away).sum(axis=1), -1, 1))
    values = np.where(met > 0, angles / np.pi, 0)
    # as smooth as if farther vertices took part
    smooth = (values + np.bincount(starts, weights=values[ends], minlength=count)) / (met + 1)
    return smooth[roots].astype(np.float32)


def to_colors(values):
    """Colours that stand for pointiness."""
    above = (values - FLAT) / FLAT
    return np.stack([np.clip(above, 0, 1), np.clip(-above, 0, 1), np.zeros_like(above)], axis=-1)


def from_colors(colors):
    """Pointiness of colours that stand for it, as one channel."""
    return FLAT + FLAT * (colors[..., :1] - colors[..., 1:2])

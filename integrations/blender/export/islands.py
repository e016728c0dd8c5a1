# SPDX-License-Identifier: GPL-3.0-or-later
"""Random numbers of the islands of a mesh, its parts that no edge connects, as Cycles has them."""

import numpy as np

NAME = ".Random Per Island"
"""Of the colour attribute that stands for them."""


def roots_of(count, edges):
    """For each of `count` vertices the one that stands for its island, which depends on the order of the edges, as in Cycles."""
    parents, ranks = list(range(count)), [0] * count

    def root_of(vertex):
        while parents[vertex] != vertex:
            parents[vertex] = parents[parents[vertex]]
            vertex = parents[vertex]
        return vertex

    for first, second in edges:
        one, other = root_of(first), root_of(second)
        if one != other:
            if ranks[one] < ranks[other]:
                one, other = other, one
            parents[other] = one
            ranks[one] += ranks[one] == ranks[other]
    return np.array([root_of(vertex) for vertex in range(count)], dtype=np.uint32)


def numbers_of(keys):
    """Numbers from 0 to 1 of some keys: Jenkins' hash."""

    def turned(value, bits):
        return (value << np.uint32(bits)) | (value >> np.uint32(32 - bits))

    b = c = np.full(len(keys), 0xDEADBEEF + 4 + 13, dtype=np.uint32)
    a = b + keys
    for turns in ((14, 11, 25), (16, 4, 14)):
        c = (c ^ b) - turned(b, turns[0])
        a = (a ^ c) - turned(c, turns[1])
        b = (b ^ a) - turned(a, turns[2])
    c = (c ^ b) - turned(b, 24)
    return c.astype(np.float32) / np.float32(0xFFFFFFFF)


def of_vertices(count, edges):
    """The number of the island of each vertex, by its edges as rows of two."""
    return numbers_of(roots_of(count, edges.tolist()))

"""Reads EXR files as the program writes them with --compression none: one part, lines one after the other."""

import struct

import numpy as np

TYPES = {0: np.dtype("<u4"), 1: np.dtype("<f2"), 2: np.dtype("<f4")}


def read(path):
    """Channels of a file by name: arrays (height, width) of their own type."""
    data = path.read_bytes()
    assert data[:4] == b"\x76\x2f\x31\x01", "no EXR file"
    at, attributes = 8, {}
    while data[at] != 0:
        end = data.index(b"\0", at)
        name, at = data[at:end].decode(), end + 1
        end = data.index(b"\0", at)
        at = end + 1
        (size,) = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    at += 1
    assert attributes["compression"] == b"\0", "compressed"
    left, top, right, bottom = struct.unpack("<4i", attributes["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    channels = list(_channels(attributes["channels"]))
    planes = {name: np.empty((height, width), TYPES[kind]) for name, kind in channels}
    for row, place in enumerate(struct.unpack_from(f"<{height}Q", data, at)):
        line, _ = struct.unpack_from("<2i", data, place)
        assert line == top + row, "lines out of order"
        place += 8
        for name, kind in channels:
            planes[name][row] = np.frombuffer(data, TYPES[kind], width, place)
            place += width * TYPES[kind].itemsize
    return planes


def _channels(text):
    at = 0
    while text[at] != 0:
        end = text.index(b"\0", at)
        (kind,) = struct.unpack_from("<i", text, end + 1)
        yield text[at:end].decode(), kind
        at = end + 17

# SPDX-License-Identifier: GPL-3.0-or-later
"""The hash of Cryptomatte's names."""

MASK = 0xFFFFFFFF


def _turn(value, bits):
    return ((value << bits) | (value >> (32 - bits))) & MASK


def murmur3(data, as_float=False):
    """MurmurHash3_32 with seed 0. `as_float`: as Cryptomatte 1.2 makes it the bits of a finite float."""
    value, length = 0, len(data)
    for start in range(0, length - length % 4, 4):
        block = int.from_bytes(data[start : start + 4], "little") * 0xCC9E2D51 & MASK
        value ^= _turn(block, 15) * 0x1B873593 & MASK
        value = (_turn(value, 13) * 5 + 0xE6546B64) & MASK
    tail = data[length - length % 4 :]
    if tail:
        block = int.from_bytes(tail, "little") * 0xCC9E2D51 & MASK
        value ^= _turn(block, 15) * 0x1B873593 & MASK
    value ^= length
    value = (value ^ value >> 16) * 0x85EBCA6B & MASK
    value = (value ^ value >> 13) * 0xC2B2AE35 & MASK
    value ^= value >> 16
    if as_float and (value >> 23) & 255 in (0, 255):
        value ^= 1 << 23
    return value

"""Prints name, type, width and sum of each channel that OpenEXR's own module reads of FILE.exr, all parts."""

import sys

import OpenEXR

file = OpenEXR.File(sys.argv[1], separate_channels=True)
for part in file.parts:
    for name, channel in part.channels.items():
        pixels = channel.pixels
        print(name, pixels.dtype, pixels.shape[1], float(pixels.astype("float64").sum()))

"""Prints name, type, width and sum of each channel that OpenEXR's own module reads of FILE.exr, all parts; of parts
of several views after the name of the view."""

import sys

import OpenEXR

file = OpenEXR.File(sys.argv[1], separate_channels=True)
for part in file.parts:
    view = part.header.get("view")
    for name, channel in part.channels.items():
        pixels = channel.pixels
        name = view + "." + name if view else name
        print(name, pixels.dtype, pixels.shape[1], float(pixels.astype("float64").sum()))

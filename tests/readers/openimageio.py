"""Reads a file with OpenImageIO, all of its subimages, and writes their channels into one EXR under the names that it tells; those of
subimages of several views after the name of the view.

python openimageio.py FILE.exr FOLDER
"""

import sys

import numpy
import OpenImageIO as oiio


def main(path, folder):
    file = oiio.ImageInput.open(path)
    if file is None:
        sys.exit(oiio.geterror())
    names, planes, number = [], [], 0
    while file.seek_subimage(number, 0):
        spec = file.spec()
        view = spec.get_string_attribute("view")
        names += [view + "." + name if view else name for name in spec.channelnames]
        planes.append(file.read_image(number, 0, 0, spec.nchannels, oiio.FLOAT))
        number += 1
    pixels = numpy.ascontiguousarray(numpy.concatenate(planes, axis=2))
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], oiio.FLOAT)
    spec.channelnames = tuple(names)
    out = oiio.ImageOutput.create(folder + "/read.exr")
    if not (out.open(folder + "/read.exr", spec) and out.write_image(pixels) and out.close()):
        sys.exit(out.geterror())


main(*sys.argv[-2:])

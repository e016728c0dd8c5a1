"""Prints layer, name, sum and moment (sum of value times number of the pixel) of each matte of FILE.exr, tabs between them, as
the decoder of PyPI's cryptomatte-api finds them by the header."""

import sys

import numpy
from cryptomatte_api import Cryptomatte

for layer in Cryptomatte.load(sys.argv[1]):
    of = layer.metadata().name()
    for name, values in layer.masks().items():
        values = values.astype("float64").ravel()
        moment = float((values * numpy.arange(values.size)).sum())
        print(of, name, float(values.sum()), moment, sep="\t")

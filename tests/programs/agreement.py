# usage: agreement.py PLAIN.png DOME.png LEFT RIGHT BOTTOM TOP
#
# Prints the part of a fisheye's pixels, in thousandths, that agree with the program's own picture. Only pixels within
# the program's lens are compared. The lens is given as in the statistics, by the tangents of its sides. The fisheye is
# 180 degrees wide, and the program's axis is in its middle. It shows the picture smaller there, so both pictures are
# smoothed, and a difference of 26 of 255 is allowed.
import sys

import numpy
from PIL import Image, ImageFilter


def pixels(file, radius):
    return numpy.asarray(Image.open(file).convert("RGB").filter(ImageFilter.GaussianBlur(radius)), dtype=float)


def main(plain, dome, *lens):
    left, right, bottom, top = map(float, lens)
    own, seen = pixels(plain, 1.5), pixels(dome, 1)
    height, width, _ = own.shape
    size = seen.shape[0]
    row, column = numpy.mgrid[0:size, 0:size]
    x, y = (column + 0.5) * 2 / size - 1, 1 - (row + 0.5) * 2 / size
    radius = numpy.hypot(x, y)
    tangent = numpy.tan(numpy.minimum(radius, 0.98) * numpy.pi / 2) / numpy.maximum(radius, 1e-9)
    across, up = (x * tangent - left) / (right - left), (top - y * tangent) / (top - bottom)
    inside = (radius < 0.98) & (across > 0.02) & (across < 0.98) & (up > 0.02) & (up < 0.98)
    at = (up[inside] * height).astype(int), (across[inside] * width).astype(int)
    # A pixel of the fisheye is as wide as several pixels of the picture, so the most similar neighbour counts.
    best = numpy.full(inside.sum(), 255.0)
    for down in (-2, 0, 2):
        for aside in (-2, 0, 2):
            near = own[numpy.clip(at[0] + down, 0, height - 1), numpy.clip(at[1] + aside, 0, width - 1)]
            best = numpy.minimum(best, numpy.abs(near - seen[inside]).max(axis=1))
    print(round(1000 * float((best <= 26).mean())) if inside.any() else "null")


main(*sys.argv[1:])

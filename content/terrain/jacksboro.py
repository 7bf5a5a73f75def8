#!/usr/bin/env python3
"""Makes jacksboro.png: a mountainside of the Cumberland Mountains, Tennessee, as a 16-bit grey PNG.

Source: jacksboro_fault_dem.npz of Debian's python-matplotlib-data (344 x 403 heights in whole metres, 3 arc-seconds apart): SRTM
elevations, public domain, prepared by Joe Kington for matplotlib. Only the standard library is used.

The degrees of the source are not square on the ground (75 m by 93 m here), and 90 m facets are coarse beside boulders, so a window
of 1.92 km is sampled anew every 15 m, by Catmull-Rom splines. The escarpment in its middle falls at up to 36 degrees, which is the
angle of repose of scree. Prints the numbers that a scene needs.
"""

import ast
import math
import struct
import sys
import zipfile
import zlib

SOURCE = "/usr/share/matplotlib/mpl-data/sample_data/jacksboro_fault_dem.npz"
CENTRE_ROW, CENTRE_COLUMN = 311, 224
SAMPLES, SPACING = 129, 15.0
METRES_PER_DEGREE = 111200.0


def array_of(archive, name):
    """One .npy member: its shape and its raw numbers."""
    data = archive.read(name + ".npy")
    length = struct.unpack("<H", data[8:10])[0]
    header = ast.literal_eval(data[10 : 10 + length].decode())
    count = math.prod(header["shape"])
    code = {"<i2": "h", "<f8": "d"}[header["descr"]]
    return header["shape"], struct.unpack(f"<{count}{code}", data[10 + length :])


def spline(p, t):
    """Catmull-Rom between p[1] and p[2]."""
    a = -p[0] + 3 * p[1] - 3 * p[2] + p[3]
    b = 2 * p[0] - 5 * p[1] + 4 * p[2] - p[3]
    return p[1] + 0.5 * t * (p[2] - p[0] + t * (b + t * a))


def height_at(heights, width, row, column):
    r, c = math.floor(row), math.floor(column)
    rows = [spline(heights[(r + i) * width + c - 1 : (r + i) * width + c + 3], column - c) for i in range(-1, 3)]
    return spline(rows, row - r)


def chunk(kind, data):
    body = kind + data
    return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))


def main():
    target = sys.argv[1] if len(sys.argv) > 1 else "jacksboro.png"
    with zipfile.ZipFile(SOURCE) as archive:
        shape, heights = array_of(archive, "elevation")
        degrees = {name: array_of(archive, name)[1][0] for name in ("dx", "dy", "ymin")}
    row_metres = degrees["dy"] * METRES_PER_DEGREE
    column_metres = degrees["dx"] * METRES_PER_DEGREE * math.cos(math.radians(degrees["ymin"]))
    half = (SAMPLES - 1) / 2
    grid = [
        height_at(heights, shape[1], CENTRE_ROW + (z - half) * SPACING / row_metres, CENTRE_COLUMN + (x - half) * SPACING / column_metres)
        for z in range(SAMPLES)
        for x in range(SAMPLES)
    ]
    low, high = math.floor(min(grid)), math.ceil(max(grid))
    values = [round((h - low) / (high - low) * 65535) for h in grid]
    rows = b"".join(b"\0" + struct.pack(f">{SAMPLES}H", *values[z * SAMPLES : (z + 1) * SAMPLES]) for z in range(SAMPLES))
    text = b"Source\0SRTM (public domain), by way of matplotlib's jacksboro_fault_dem.npz"
    with open(target, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        file.write(chunk(b"IHDR", struct.pack(">IIBBBBB", SAMPLES, SAMPLES, 16, 0, 0, 0, 0)))
        file.write(chunk(b"tEXt", text) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))
    print(f'{target}: "spacing": {SPACING:g}, "low": {low}, "high": {high}')
    return grid


if __name__ == "__main__":
    main()

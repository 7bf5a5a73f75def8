#!/usr/bin/env python3
"""Makes ridge_ground.png: jacksboro.png with a pit where the recipe `ridge` cuts its piece of mountain out.

The cliff takes the place of the ground there: the ground meets its rim and goes down within two samples, so that what frost takes
away leaves no grass in the air. Only the standard library is used.
"""

import os
import struct
import zlib

from canyon import write_png

HERE = os.path.dirname(os.path.abspath(__file__))
CROP = 33, 48, 36, 36  # first column, first row, columns, rows: as in content/recipes/ridge.json
HIGH = 553.0  # metres from black to white
DEPTHS = 0.0, 2.0, 20.0  # metres below the mountain, by samples from the rim
PIT = 130.0  # and farther in


def heights(path):
    """The samples of a 16-bit grey PNG whose rows are not filtered, row by row."""
    with open(path, "rb") as file:
        data = file.read()
    at, packed, side = 8, b"", 0
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            side = struct.unpack(">I", body[:4])[0]
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    rows = zlib.decompress(packed)
    return side, [list(struct.unpack(f">{side}H", rows[y * (2 * side + 1) + 1 : (y + 1) * (2 * side + 1)])) for y in range(side)]


def main():
    side, samples = heights(os.path.join(HERE, "jacksboro.png"))
    left, top, columns, rows = CROP
    for z in range(top, top + rows):
        for x in range(left, left + columns):
            rim = min(x - left, left + columns - 1 - x, z - top, top + rows - 1 - z)
            depth = DEPTHS[rim] if rim < len(DEPTHS) else PIT
            samples[z][x] = max(0, round(samples[z][x] - depth / HIGH * 65535))
    write_png("ridge_ground.png", side, [value for row in samples for value in row])


if __name__ == "__main__":
    main()

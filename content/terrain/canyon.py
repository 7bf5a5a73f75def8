#!/usr/bin/env python3
"""Makes canyon.png, a made-up canyon with a winding river, and canyon_floor.png, the same without its walls, as 16-bit grey PNGs. Only
the standard library is used.

Across the river: its bed, banks, a skirt of scree, then walls of beds of rock, each a steep face over a narrow ledge, up to a plateau.
Every length wanders with value noise. A layer of rocks is found the faster, the less steep its map is: those on the floor have a map of
their own. Prints the numbers that a scene needs.
"""

import math
import struct
import zlib

SAMPLES, SPACING = 257, 0.5
MAPS = (("canyon.png", True, -2.0, 40.0), ("canyon_floor.png", False, -2.0, 8.0))


def hashed(x, z, seed):
    h = (x * 0x8DA6B343 ^ z * 0xD8163841 ^ seed * 0xCB1AB31F) & 0xFFFFFFFF
    h = (h ^ h >> 15) * 0x2C1B3C6D & 0xFFFFFFFF
    h = (h ^ h >> 12) * 0x297A2D39 & 0xFFFFFFFF
    return (h ^ h >> 15) / 0xFFFFFFFF * 2 - 1


def noise(x, z, seed):
    """Value noise, -1..1."""
    i, j = math.floor(x), math.floor(z)
    u, v = x - i, z - j
    u, v = u * u * (3 - 2 * u), v * v * (3 - 2 * v)
    a, b = hashed(i, j, seed), hashed(i + 1, j, seed)
    c, d = hashed(i, j + 1, seed), hashed(i + 1, j + 1, seed)
    return (a + (b - a) * u) * (1 - v) + (c + (d - c) * u) * v


def smooth(low, high, x):
    t = min(max((x - low) / (high - low), 0), 1)
    return t * t * (3 - 2 * t)


def river(z):
    """x of the river's middle."""
    return 14 * math.sin(z / 17) + 2.5 * math.sin(z / 7.5 + 1)


def height(x, z, walls=True):
    middle = river(z)
    tilt = (river(z + 0.5) - river(z - 0.5)) / 1.0
    away = abs(x - middle) / math.sqrt(1 + tilt * tilt)
    side = 1 if x > middle else 2
    away += 2.2 * noise(x / 9, z / 9, 10 + side) + 0.7 * noise(x / 3, z / 3, 20)
    y = -1.2 + 1.5 * smooth(2.5, 8.0, away) + 0.12 * noise(x / 1.7, z / 1.7, 30)
    y += 0.65 * max(min(away, 15.5) - 8.0, 0)  # the skirt
    if not walls:
        return y
    # Beds: each rises steeply over less than a metre, then a ledge.
    at, base = 15.5, 0
    for bed, thick in enumerate((6.5, 3.5, 5.5, 4.0, 6.0, 4.5)):
        face = at + 1.3 * noise(z / 5, bed * 7.3 + side * 50, 40) + 0.5 * noise(z / 1.6, bed * 3.1 + side * 50, 41)
        y += thick * smooth(face, face + 0.24 * thick, away)
        at += 0.24 * thick + 0.7 + 0.9 * (noise(z / 11, bed * 5.7 + side * 50, 42) + 1)
    y += 0.35 * noise(x / 2.3, z / 2.3, 50) * smooth(15, 17, away)
    return y


def chunk(kind, data):
    body = kind + data
    return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))


def write_png(target, side, values):
    """A square of 16-bit grey."""
    rows = b"".join(b"\0" + struct.pack(f">{side}H", *values[z * side : (z + 1) * side]) for z in range(side))
    with open(target, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        file.write(chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 16, 0, 0, 0, 0)))
        file.write(chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def write(target, walls, low, high):
    half = (SAMPLES - 1) / 2 * SPACING
    grid = [height(column * SPACING - half, row * SPACING - half, walls) for row in range(SAMPLES) for column in range(SAMPLES)]
    assert low <= min(grid) and max(grid) <= high, (min(grid), max(grid))
    write_png(target, SAMPLES, [round((h - low) / (high - low) * 65535) for h in grid])
    print(f'{target}: "spacing": {SPACING:g}, "low": {low:g}, "high": {high:g}')


def main():
    for name, walls, low, high in MAPS:
        write(name, walls, low, high)


if __name__ == "__main__":
    main()

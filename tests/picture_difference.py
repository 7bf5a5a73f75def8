"""Counts the pixels in which two PNG pictures of 8 bits a channel differ. Usage: picture_difference.py A.png B.png

Prints how many differ and how many there are. Only the standard library is used.
"""

import struct
import sys
import zlib


def unfilter(kind, line, before, step):
    for x in range(len(line)):
        left = line[x - step] if x >= step else 0
        up = before[x]
        corner = before[x - step] if x >= step else 0
        if kind == 1:
            guess = left
        elif kind == 2:
            guess = up
        elif kind == 3:
            guess = (left + up) // 2
        elif kind == 4:
            paeth = left + up - corner
            guess = min((abs(paeth - left), 0, left), (abs(paeth - up), 1, up), (abs(paeth - corner), 2, corner))[2]
        else:
            guess = 0
        line[x] = (line[x] + guess) & 255


def rows_of(path):
    """Width, bytes a pixel, and the rows."""
    with open(path, "rb") as file:
        data = file.read()
    at, packed, width, step = 8, b"", 0, 0
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            width, _, depth, colour = struct.unpack(">IIBB", body[:10])
            step = {(8, 0): 1, (8, 2): 3, (8, 6): 4}[depth, colour]
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    raw = zlib.decompress(packed)
    rows, before = [], bytearray(width * step)
    for start in range(0, len(raw), width * step + 1):
        line = bytearray(raw[start + 1 : start + 1 + width * step])
        unfilter(raw[start], line, before, step)
        rows.append(line)
        before = line
    return width, step, rows


def main():
    width, step, a = rows_of(sys.argv[1])
    _, _, b = rows_of(sys.argv[2])
    differing = sum(row[x : x + step] != other[x : x + step] for row, other in zip(a, b) for x in range(0, width * step, step))
    print(differing, width * len(a))


main()

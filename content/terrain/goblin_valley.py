#!/usr/bin/env python3
"""Makes goblin_valley.png, the floor of a made-up desert valley with a dry wash and a rim of cliffs, and three pictures of the same place:
goblin_valley_stands.png, where hoodoos stand and how densely, goblin_valley_ages.png, how old they are, and goblin_valley_debris.png,
where stones lie. 16-bit grey PNGs; only the standard library is used. Prints the numbers that a scene needs.
"""

import math

import canyon
from canyon import noise, smooth

SAMPLES, SPACING = 257, 0.8
MASK_SAMPLES, MASK_SPACING = 129, 1.6
DEBRIS_SAMPLES, DEBRIS_SPACING = 193, 0.5
LOW, HIGH = -4.0, 36.0
FLOOR = 76.0  # metres from the middle to the foot of the rim


def wash(z):
    """x of the middle of the dry wash."""
    return 9 * math.sin(z / 24 + 0.6) + 3 * math.sin(z / 9.0)


def away_from_wash(x, z):
    return abs(x - wash(z) - 1.5 * noise(x / 7, z / 7, 3))


def rim(x, z):
    """Metres behind the foot of the rim, negative on the floor; the valley is open to the south, +z."""
    r = math.hypot(x, 1.12 * (z + 6)) + 9 * noise(x / 31, z / 31, 4) + 4 * noise(x / 12, z / 12, 5) + 1.2 * noise(x / 4, z / 4, 6)
    return r - FLOOR - 30 * smooth(10, 80, z)


def height(x, z):
    y = 1.1 * noise(x / 36, z / 36, 10) + 0.55 * noise(x / 13, z / 13, 11) + 0.16 * noise(x / 4.7, z / 4.7, 12)
    y += 0.05 * noise(x / 1.9, z / 1.9, 13)
    bed = smooth(7.5, 2.0, away_from_wash(x, z))
    y = y * (1 - 0.75 * bed) - 0.9 * bed
    behind = rim(x, z)
    y += 0.16 * max(behind + 14, 0) * smooth(-14, 4, behind)  # the skirt
    at = 4.0
    for number, thick in enumerate((3.5, 5.5, 3.0, 6.5)):
        face = at + 2.0 * noise(x / 9, z / 9 + number * 7.3, 20) + 0.9 * noise(x / 3, z / 3 + number * 3.1, 21)
        y += thick * smooth(face, face + 0.6 * thick, behind)
        at += 0.6 * thick + 1.8 + 1.8 * (noise(x / 15, z / 15 + number * 5.7, 22) + 1)
    return y


def stands(x, z):
    """In groups, with clearings between, none in the wash and on the rim."""
    groups = noise(x / 21, z / 21, 30) + 0.55 * noise(x / 8.5, z / 8.5, 31) + 0.30
    share = smooth(-0.05, 0.40, groups) * smooth(3.5, 7.0, away_from_wash(x, z)) * smooth(0, -9, rim(x, z))
    return share


def age(x, z):
    """Old where the wash has been at work for long, and by chance; young under the rim."""
    old = 0.85 - 0.010 * away_from_wash(x, z) + 0.85 * noise(x / 19, z / 19, 40) + 0.30 * noise(x / 6, z / 6, 41)
    return 0.3 + 0.7 * min(max(old, 0), 1)


def debris(x, z):
    """Stones lie in drifts."""
    drifts = noise(x / 2.6, z / 2.6, 50) + 0.6 * noise(x / 1.1, z / 1.1, 51) + 0.5 * noise(x / 9, z / 9, 52)
    return (0.06 + 0.94 * smooth(0.10, 0.75, drifts)) * (0.15 + 0.85 * smooth(2.0, 6.0, away_from_wash(x, z)))


def write(target, samples, spacing, low, high, function):
    half = (samples - 1) / 2 * spacing
    grid = [function(column * spacing - half, row * spacing - half) for row in range(samples) for column in range(samples)]
    canyon.write_png(target, samples, [round((value - low) / (high - low) * 65535) for value in grid])
    assert low <= min(grid) and max(grid) <= high, (min(grid), max(grid))
    print(f'{target}: "spacing": {spacing:g}, "low": {low:g}, "high": {high:g}; {min(grid):.2f} to {max(grid):.2f}')


def main():
    write("goblin_valley.png", SAMPLES, SPACING, LOW, HIGH, height)
    write("goblin_valley_stands.png", MASK_SAMPLES, MASK_SPACING, 0, 1, stands)
    write("goblin_valley_ages.png", MASK_SAMPLES, MASK_SPACING, 0, 1, age)
    write("goblin_valley_debris.png", DEBRIS_SAMPLES, DEBRIS_SPACING, 0, 1, debris)


if __name__ == "__main__":
    main()

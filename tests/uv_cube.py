"""A cube of 2 m with UVs, for tests of what becomes of them."""

PLACES = [(x, y, z) for z in (0, 2) for x, y in ((0, 0), (2, 0), (2, 2), (0, 2))]
SIDES = [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (2, 3, 7, 6), (0, 4, 7, 3), (1, 2, 6, 5)]


def on_side(quad, place):
    """s, t, and how far off its plane, of a side."""
    a, b, _, d = (PLACES[v] for v in quad)
    offset = [p - q for p, q in zip(place, a)]
    along, up = [p - q for p, q in zip(b, a)], [p - q for p, q in zip(d, a)]
    s, t = (sum(p * q for p, q in zip(offset, way)) / 4 for way in (along, up))
    return s, t, max(abs(o - s * p - t * q) for o, p, q in zip(offset, along, up))

"""Values of keys of recipes, at and beyond their ends, of wrong types and in wrong places, for check_schema.py."""

HOODOO = {
    "name": ["x" * 63, "x" * 64, 5, None],
    "random_seed": [0, 2**53, 2**53 + 2, -1, 0.5, "1"],
    "voxel": [0.001, 100, 0, 101, "1", None, [1]],
    "size": [[1, 1, 1], [4096, 1, 1], [4097, 1, 1], [0, 1, 1], [1, 1], [1, 1, 1, 1], 5, [1, 1, "1"], [1.5, 1, 1]],
    "start": [
        {}, {"shape": "box"}, {"radius": 5}, {"shape": "box", "radius": 5}, {"shape": "pyramid"}, {"shape": "column", "lobes": 3},
        {"shape": "joints", "spacing": 3}, {"shape": "joints", "spacing": 30, "gap": 0.5, "warp": 1, "missing": 0, "low": 1},
        {"shape": "joint_map"}, {"shape": "joint_map", "file": "a.png"}, {"shape": "mesh", "file": "a.obj", "lift": 1},
        {"shape": "sphere", "radius": 10, "lift": 4}, {"shape": "cone", "height": -1}, {"shape": "cylinder", "height": 4096}, 5, None,
        {"shape": "box", "min": [0, 0], "max": [1, 1, 1]}, {"shape": "joint_map", "file": ""}, {"shape": "joint_map", "file": "x" * 256},
    ],
    "durability": [
        [[0, 1]], [], [[0, 1]] * 33, [[0]], [[0, 1, 2, 3, 4, 5]], [[0, 0]], [[1.1, 1]], [[0, 1, 5]], [[0, 1, 1, 0.5]], [[0, 1, 1, 5, 0]],
        [["0", 1]], [[0, 1, 0.5, 16, 2], [1, 2]], 5, [5], {},
    ],
    "bubbles": [
        [{"altitude": 0, "kind": "disc", "radius": 3}], [], [{}], [{"mixture": []}], [{"mixture": [{"radius": 2}]}], [{"mixture": [{}] * 5}], [{"mixture": [{}], "radius": 2}],
        [{"radius": 0.5}], [{"radius": 12.5}], [{"kind": "cube"}], [{"colour": 1}], 5, [5], [{"altitude": 2}], [{"mixture": [{"x": 1}]}],
    ],
    "spheroidal": [
        {}, {"curve": "none"}, {"curve": "square"}, {"gain": -1}, {"gain": 1001}, {"power": 1.5}, {"power": 5}, {"saturation": 0}, 5,
        {"threshold": 2}, {"exponent": 1},
    ],
    "cavernous": [{}, {"curve": "saturating", "threshold": -0.5, "saturation": 0.1, "power": 2, "gain": 0.3}, [1]],
    "exposure": [0, 2, -0.1, 2.1, "0"],
    "steps_per_voxel": [1, 10000, 0.5, 10001, None],
    "colluvium": [{}, {"share": 0.5}, {"share": 2}, {"durability": 0}, {"repose": 0.05}, {"repose": 4}, {"angle": 1}, 5],
    "rockfall": ["none", "drop", "colluvium", "fall", 1, ["none"]],
    "phases": [
        [], [{"share": 0.5}], [{"steps": 5, "exposure": 1}], [{"exposure": 1}], [{"share": 0.5, "steps": 5}], [{"steps": 1}] * 9, 5, [5],
        [{"share": 2}], [{"share": 0.5, "spheroidal": {"curve": "linear"}, "colluvium": {}}], [{"share": 0.5, "name": "x"}],
        [{"share": 0.5, "colluvium": {"share": 3}}], [{"steps": 0.5}],
    ],
    "variants": [1, 255, 0, 256, 1.5, "1"],
    "ages": [[1], [0.5], [], [2], [-0.1], 0.5, ["a"], [1 - i / 20 for i in range(16)], [1 - i / 20 for i in range(17)]],
    "age_steps": [[0], [5], [], [0.5], [-1], 5, [1000001]],
    "max_steps": [1, 1000000, 0, 1000001],
    "lod_levels": [1, 6, 0, 7],
    "lattice_steps": [2, 64, 3, 0, 66],
    "parts": [True, False, 0, "true"],
    "kind": ["rocks", "Hoodoo", 5],
    "colour": [1],
}

SHARDS = {
    "name": ["x" * 63, "x" * 64, 5, None],
    "random_seed": [0, 2**53, 2**53 + 2, -1, 0.5, "1"],
    "input": [
        {}, {"shape": "box"}, {"radius": 5}, {"shape": "box", "radius": 5}, {"shape": "pyramid"}, {"shape": "box", "size": [1, 2, 0]},
        {"shape": "box", "size": [1, 2, 3], "noise": 0.3, "wavelength": 2, "octaves": 3, "resolution": 64}, 5, None,
        {"shape": "hill", "top": 1, "bulge": 0, "rings": 1, "sides": 3}, {"sides": 2}, {"rings": 17}, {"top": 0}, {"bulge": 2},
        {"shape": "sphere", "radius": 5, "resolution": 7}, {"shape": "sphere", "resolution": 8}, {"shape": "sphere", "height": 3},
        {"shape": "cone", "height": 9}, {"shape": "capsule", "radius": 1, "height": 4}, {"shape": "mesh"},
        {"shape": "mesh", "file": "a.obj", "scale": 2, "position": [0, 1, 0], "resolution": 100}, {"shape": "mesh", "file": ""},
        {"shape": "mesh", "file": "x" * 256}, {"shape": "terrain", "file": "a.png"}, {"shape": "terrain", "file": "a.png", "scale": 2},
        {"shape": "terrain", "file": "a.png", "spacing": 2, "low": 1, "high": 9, "crop": [1, 2, 30, 40], "base": -3},
        {"shape": "terrain", "file": "a.png", "crop": [1, 2, 30]}, {"shape": "terrain", "file": "a.png", "spacing": 0},
        {"shape": "hoodoo", "file": "a.json", "variant": 254, "age": 15, "lod": 5}, {"shape": "hoodoo", "file": "a.json", "lod": 6},
        {"shape": "hoodoo"}, {"shape": "support"}, {"shape": "support", "resolution": 100}, {"shape": "support", "size": [1, 1, 1]},
    ],
    "seeds": [
        {}, {"pattern": "random", "count": 0}, {"count": 1000001}, {"count": 0.5}, {"pattern": "grid", "spacing": 2, "jitter": 0.5},
        {"pattern": "grid", "jitter": 2}, {"pattern": "random", "jitter": 0.5}, {"pattern": "columns", "length": 3}, {"spacing": 0},
        {"pattern": "grid", "length": 3}, {"pattern": "slabs", "layers": [1, 2]}, {"pattern": "slabs", "layers": [0]},
        {"pattern": "slabs", "layers": [1] * 33}, {"pattern": "slabs", "layers": []}, {"pattern": "slabs", "up": [0.3, 1, 0]},
        {"pattern": "poisson", "spacing": 1, "spacing_end": 2, "grade": [0, 0, 1]}, {"grade": [0, 1, 0]}, {"up": [0, 0, 0]},
        {"pattern": "points"}, {"pattern": "points", "points": [[1, 2, 3]]}, {"pattern": "points", "points": [[1, 2]]},
        {"pattern": "points", "points": []}, {"pattern": "points", "points": [[1, 2, 3]], "count": 1}, {"stretch": [2, 1, 1]},
        {"stretch": [0, 1, 1]}, {"random_seed": 5}, {"pattern": "hexagons"}, 5, [],
    ],
    "clip": ["auto", "walls", "mesh", "none", 1],
    "link_angle": [0.001, 1.5, 0, 2],
    "images": [{}, {"file": "a.png", "slices": 4}, {"slices": 0}, {"slices": 4097}, {"min": [0, 0]}, {"colour": 1}, 5],
    "rains": [
        [{}], [], [{}] * 4, [{}] * 5, [{"direction": [1, 0, 0]}], [{"direction": [0, 0, 0]}], [{"direction": [2, 0, 0]}], {}, [5],
        [{"spread": 0}], [{"spread": 3.2}], [{"weight": 0}], [{"weight": 2, "x": 1}],
    ],
    "water": [1, 0, 1e6, 1e7, "1"],
    "gravity": [[0, 1, 0], [0, 0, 0], [0, -1], [0, -1, 2], 5],
    "resistance": [
        {}, {"value": 0.9}, {"value": 2}, {"kind": "constant", "amplitude": 0.5}, {"kind": "function"}, {"kind": "function", "value": 1},
        {"kind": "noise", "value": 0.4, "amplitude": 0.3, "period": 2, "octaves": 3, "random_seed": 4}, {"kind": "noise", "octaves": 9},
        {"kind": "layers"}, {"kind": "layers", "layers": [[0, 0.3], [2, 0.9]], "up": [0.2, 1, 0]}, {"kind": "layers", "layers": []},
        {"kind": "layers", "layers": [[0, 2]]}, {"kind": "layers", "layers": [[0]]}, {"kind": "layers", "value": 0.2},
        {"kind": "layers", "up": [0, 0, 0]}, {"kind": "noise", "period": 0}, {"kind": "sine"}, 5, None,
    ],
    "absorption": [{}, {"solid": 0.2, "air": 0.1, "resistance": 0.5, "total": False}, {"solid": -1}, {"total": 1}, {"x": 1}, 5],
    "damage": [0, 1000, -1, 1001],
    "breakage": [{}, {"life": 0, "chance": 1}, {"life": 2}, {"chance": -1}, {"x": 1}],
    "fall": ["gone", "kept", "lost", 1],
    "fall_life": [0, 1, 2, "0"],
    "stability": [{}, {"strength": 1e6, "density": 2700, "compression": 8, "interval": 1}, {"interval": 0}, {"compression": 0.5}, 5],
    "states": [
        [], [{}], [{"where": "all", "state": "core"}], [{"state": "rock"}], [{"where": "exterior", "angle": 1}], [{}] * 16, [{}] * 17,
        [{"where": "facing", "direction": [0, 0, 1], "angle": 0.5}], [{"where": "facing", "direction": [0, 0, 0]}],
        [{"where": "facing", "angle": 4}], [{"where": "base", "depth": 2}], [{"where": "base", "depth": -1}],
        [{"where": "box", "min": [0, 0, 0], "max": [1, 1, 1]}], [{"where": "sphere", "centre": [0, 0, 0], "radius": 2}],
        [{"where": "sphere", "radius": 0}], [{"where": "half_space", "direction": [1, 0, 0], "offset": 3, "state": "air"}],
        [{"where": "half_space", "radius": 1}], [{"where": "top"}], 5, [5],
    ],
    "phases": [
        [], [{"share": 0.5}], [{"paths": 5, "water": 2}], [{"water": 1}], [{"share": 0.5, "paths": 5}], [{"paths": 1}] * 17, 5, [5],
        [{"share": 2}], [{"share": 0.5, "resistance": {"kind": "noise"}, "rains": [{}]}], [{"share": 0.5, "name": "x"}],
        [{"share": 0.5, "absorption": {"solid": -3}}], [{"paths": 0.5}], [{"paths": 1, "gravity": [0, 0, 0]}],
    ],
    "paths": [[0], [5], [], [0.5], [-1], 5, ["a"], list(range(16)), list(range(17))],
    "shares": [[1], [0.5], [], [2], [-0.1], 0.5, [1 - i / 20 for i in range(16)], [1 - i / 20 for i in range(17)]],
    "max_paths": [70000, 1e9, 0, 1e9 + 1],
    "rubble": [{}, {"ground": -3, "repose": 1, "min_volume": 2, "share": 0.5, "reach": 9, "resolution": 0.1}, {"repose": 0},
               {"share": 2}, {"x": 1}, 5],
    "lod_levels": [1, 6, 0, 7],
    "lattice_per_metre": [0, 4096, 4097, -1],
    "kind": ["Shards", 5],
    "colour": [1],
}


def of_number_or_range(low, high, step):
    return [low, high, low - step, high + step, low + 0.5, "1", None, True, [], {}, [low, high], [low], [low, high, high], [low, "x"]]


def of_rocks(key):
    """Keys of rocks are numbers, ranges and words: what to try follows from the table."""
    low, high = key["min"], key["max"]
    if key["kind"] == "numbers":
        return [[low, 0, high], [high * 2, 0, 0], [0, 1], [0, 1, 0, 0], 5, ["a", 0, 1]]
    if key["kind"] == "bool":
        return [True, False, 0, 1, "true", None, [True]]
    if key["kind"] in ("text", "choice"):
        return ["random", "aligned", "x" * 63, "x" * 64, 5, None, ["random"]]
    if key["kind"] == "seed":
        return [0, 1, 2**53, 2**53 + 2, -1, 0.5, "1", None]
    return of_number_or_range(low, high, 2 if key["kind"] == "count" else 1)

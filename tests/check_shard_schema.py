"""check_shard_schema.py SCHEMA PRINT_SHARD_KEYS RECIPES WORK

Holds the JSON schema of recipes of shards against the baker: the same keys, ranges, choices and defaults at every depth; and for many
a recipe with one value at or beyond its end, of a wrong type or in a wrong place, both must give the same verdict. Every recipe of
shards in the folder RECIPES must fit both.
"""

import json
import os
import subprocess
import sys

import jsonschema

schema_path, print_keys, recipes, work = sys.argv[1:5]
faults = []


def expect(condition, text):
    if not condition:
        faults.append(text)


schema = json.load(open(schema_path, encoding="utf-8"))
table = json.loads(subprocess.run([print_keys], check=True, capture_output=True, text=True).stdout)


def resolve(part):
    while "$ref" in part:
        part = {**schema["$defs"][part["$ref"].rsplit("/", 1)[1]], **{k: v for k, v in part.items() if k != "$ref"}}
    return part


def compare(key, part, path):
    part = resolve(part)
    expect(part.get("description", "") != "", f"{path}: no description")
    kind = key["kind"]
    ends = (key["min"], key["max"])
    length = (part.get("minItems"), part.get("maxItems"))
    if kind in ("number", "count", "seed"):
        expect((part.get("minimum"), part.get("maximum")) == ends, f"{path}: ends differ from {ends}")
        expect(part.get("type") == ("number" if kind == "number" else "integer"), f"{path}: type")
    elif kind in ("counts", "numbers", "values", "times"):
        item = part.get("items", {})
        expect((item.get("minimum"), item.get("maximum")) == ends, f"{path}: ends differ from {ends}")
        expect(item.get("type") == ("integer" if kind in ("counts", "times") else "number"), f"{path}: type")
        fixed = kind in ("counts", "numbers")
        expect(length[1] == key["size"] and (not fixed or length[0] == key["size"]), f"{path}: length")
    elif kind == "text":
        expect(part.get("maxLength") == key["max"], f"{path}: maxLength")
    elif kind == "choice":
        expect(part.get("enum") == key["words"].split(), f"{path}: choices")
    elif kind == "bool":
        expect(part.get("type") == "boolean", f"{path}: type")
    elif kind == "rows":
        columns = part["items"]["prefixItems"]
        expect(length == (key["least"], key["size"]), f"{path}: length")
        expect(len(columns) == len(key["members"]) == part["items"]["maxItems"] == part["items"]["minItems"], f"{path}: columns")
        for column, item in zip(key["members"], columns):
            expect((item["minimum"], item["maximum"]) == (column["min"], column["max"]), f"{path}: ends of {column['name']}")
    elif kind == "phases":
        expect(length == (key["least"], key["size"]), f"{path}: length")
        compare_members(key["members"] + table["rules"], part["items"], path)
    elif kind == "list":
        expect(length == (key["least"], key["size"]), f"{path}: length")
        compare_members(key["members"], part["items"], path)
    else:
        compare_members(key["members"], part, path)


def compare_members(keys, part, path):
    if "anyOf" in part:
        name, words = keys[0]["name"], keys[0]["words"].split()
        expect([a["properties"][name]["const"] for a in part["anyOf"]] == words, f"{path}: choices of {name}")
        for number, choice in enumerate(part["anyOf"]):
            own = [m for m in keys[1:] if m.get("only", 2**32 - 1) >> number & 1]
            rest = {k: v for k, v in choice["properties"].items() if k != name}
            expect(choice["properties"][name].get("description", "") != "", f"{path} {words[number]}: no description")
            compare_members(own, {**choice, "properties": rest}, f"{path} {words[number]}")
        return
    names, there = sorted(key["name"] for key in keys), sorted(part["properties"])
    expect(names == there, f"{path}: keys differ: {sorted(set(names) ^ set(there))}")
    expect(part.get("additionalProperties") is False, f"{path}: unknown keys are allowed")
    for key in keys:
        if key["name"] in part["properties"]:
            compare(key, part["properties"][key["name"]], f"{path}.{key['name']}")


top = {k: v for k, v in schema["properties"].items() if k not in ("$schema", "kind")}
compare_members(table["keys"] + table["rules"], {**schema, "properties": top}, "recipe")
path = os.path.join(work, "shards.json")
validator = jsonschema.validators.validator_for(schema)(schema)


def printed(value):
    with open(path, "w", encoding="utf-8") as file:
        json.dump(value, file)
    run = subprocess.run([print_keys, path], capture_output=True, text=True)
    expect(run.returncode in (0, 2), f"{value}: exit status {run.returncode}")
    return run.stdout if run.returncode == 0 else None


# What a default says, the baker takes for what is left out.
plain = json.dumps(table["defaults"])
for name, part in top.items():
    if name == "shares":
        continue
    text = printed({"kind": "shards", name: resolve(part)["default"]})
    expect(text is not None and json.dumps(json.loads(text)) == plain, f"{name}: its default is not the baker's")

values = {
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
expect(sorted(set(values) - {"kind", "colour"}) == sorted(top), "a key without values to try")
compared = 0
for name, tries in values.items():
    for value in tries:
        recipe = {"kind": "shards", name: value}
        by_schema = validator.is_valid(recipe)
        by_baker = printed(recipe) is not None
        expect(by_schema == by_baker, f"{json.dumps(recipe)}: schema {'accepts' if by_schema else 'refuses'}, the baker does not agree")
        compared += 1
expect(not validator.is_valid({"kind": "shards", "paths": [5], "shares": [0.5]}), "schema: paths and shares together")
expect(printed({"kind": "shards", "paths": [5], "shares": [0.5]}) is None, "baker: paths and shares together")

shipped = 0
for name in sorted(os.listdir(recipes)):
    with open(os.path.join(recipes, name), encoding="utf-8") as file:
        recipe = json.load(file)
    if recipe.get("kind") != "shards":
        continue
    shipped += 1
    for error in validator.iter_errors(recipe):
        expect(False, f"{name}: {error.json_path}: {error.message}")
    text = printed(recipe)
    expect(text is not None, f"{name}: refused by the baker")
    if text is not None:
        for error in validator.iter_errors(json.loads(text)):
            expect(False, f"{name} as printed: {error.json_path}: {error.message}")
expect(shipped >= 5, f"{shipped} recipes of shards ship")

print(f"{compared} recipes compared, {shipped} shipped ones")
for fault in faults:
    print(fault)
sys.exit(1 if faults else 0)

"""check_hoodoo_schema.py SCHEMA PRINT_HOODOO_KEYS SCREE_BAKE RECIPES WORK

Holds the JSON schema of hoodoo recipes against the baker: the same keys, ranges, choices and defaults at every depth; and for many a
recipe with one value at or beyond its end, of a wrong type or in a wrong place, both must give the same verdict. Every hoodoo recipe
in the folder RECIPES must fit both.
"""

import json
import os
import subprocess
import sys

import jsonschema

schema_path, print_keys, bake, recipes, work = sys.argv[1:6]
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
    kind = key["kind"]
    ends = (key["min"], key["max"])
    if kind in ("number", "count", "seed"):
        expect((part.get("minimum"), part.get("maximum")) == ends, f"{path}: ends differ from {ends}")
        expect(part.get("type") == ("number" if kind == "number" else "integer"), f"{path}: type")
    elif kind == "counts":
        item = part.get("items", {})
        expect((item.get("minimum"), item.get("maximum")) == ends and part.get("maxItems") == 3, f"{path}: ends differ from {ends}")
    elif kind == "text":
        expect(part.get("maxLength") == key["max"], f"{path}: maxLength")
    elif kind == "choice":
        expect(part.get("enum") == key["words"].split(), f"{path}: choices")
    elif kind == "bool":
        expect(part.get("type") == "boolean", f"{path}: type")
    elif kind == "durability":
        expect((part["minItems"], part["maxItems"]) == ends, f"{path}: length")
        for column, item in zip(key["members"], part["items"]["prefixItems"]):
            expect((item["minimum"], item["maximum"]) == (column["min"], column["max"]), f"{path}: ends of {column['name']}")
        expect(len(part["items"]["prefixItems"]) == len(key["members"]) == part["items"]["maxItems"], f"{path}: columns")
    elif kind == "bubbles":
        expect((part["minItems"], part["maxItems"]) == ends, f"{path}: length")
        single, mixed = part["items"]["anyOf"]
        mixture = next(m for m in key["members"] if m["name"] == "mixture")
        others = [m for m in key["members"] if m["name"] != "mixture"]
        compare_members(others + mixture["members"], single, path)
        compare_members(others, {**mixed, "properties": {k: v for k, v in mixed["properties"].items() if k != "mixture"}}, path)
        inner = mixed["properties"]["mixture"]
        expect((inner["minItems"], inner["maxItems"]) == (mixture["min"], mixture["max"]), f"{path}: length of a mixture")
        compare_members(mixture["members"], inner["items"], path + ".mixture")
    elif kind in ("ages", "age_steps"):
        expect((part["items"]["minimum"], part["items"]["maximum"]) == ends, f"{path}: ends differ from {ends}")
    elif kind == "phases":
        expect((part["minItems"], part["maxItems"]) == ends, f"{path}: length")
        compare_members(key["members"] + table["rules"], part["items"], path)
    elif key["name"] == "start":
        words = key["members"][0]["words"].split()
        expect([a["properties"]["shape"]["const"] for a in part["anyOf"]] == words, f"{path}: shapes")
        for number, shape in enumerate(part["anyOf"]):
            own = [m for m in key["members"][1:] if m.get("shapes", 2**32 - 1) >> number & 1]
            rest = {k: v for k, v in shape["properties"].items() if k != "shape"}
            compare_members(own, {**shape, "properties": rest}, f"{path} {words[number]}")
    else:
        compare_members(key["members"], part, path)


def compare_members(keys, part, path):
    names, there = sorted(key["name"] for key in keys), sorted(part["properties"])
    expect(names == there, f"{path}: keys differ: {sorted(set(names) ^ set(there))}")
    expect(part.get("additionalProperties") is False, f"{path}: unknown keys are allowed")
    for key in keys:
        if key["name"] in part["properties"]:
            compare(key, part["properties"][key["name"]], f"{path}.{key['name']}")


top = {k: v for k, v in schema["properties"].items() if k not in ("$schema", "kind")}
compare_members(table["keys"] + table["rules"], {**schema, "properties": top}, "recipe")
path = os.path.join(work, "hoodoo.json")
validator = jsonschema.validators.validator_for(schema)(schema)


def printed(value):
    with open(path, "w", encoding="utf-8") as file:
        json.dump(value, file)
    run = subprocess.run([bake, path, "--print-recipe"], capture_output=True, text=True)
    expect(run.returncode in (0, 2), f"{value}: exit status {run.returncode}")
    return run.stdout if run.returncode == 0 else None


# What a default says, the baker takes for what is left out.
plain = json.dumps(table["defaults"])
for name, part in top.items():
    part = resolve(part)
    expect(part.get("description", "") != "", f"{name}: no description")
    if name == "age_steps":
        continue
    text = printed({"kind": "hoodoo", name: part["default"]})
    expect(text is not None and json.dumps(json.loads(text)) == plain, f"{name}: its default is not the baker's")

bubble = {"altitude": 0, "kind": "disc", "radius": 3}
values = {
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
        [bubble], [], [{}], [{"mixture": []}], [{"mixture": [{"radius": 2}]}], [{"mixture": [{}] * 5}], [{"mixture": [{}], "radius": 2}],
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
expect(sorted(set(values) - {"kind", "colour"}) == sorted(top), "a key without values to try")
compared = 0
for name, tries in values.items():
    for value in tries:
        recipe = {"kind": "hoodoo", name: value}
        by_schema = validator.is_valid(recipe)
        if name == "kind" and value == "rocks":
            continue  # the other schema's
        by_baker = printed(recipe) is not None
        expect(by_schema == by_baker, f"{json.dumps(recipe)}: schema {'accepts' if by_schema else 'refuses'}, scree-bake does not agree")
        compared += 1
expect(not validator.is_valid({"kind": "hoodoo", "ages": [0.5], "age_steps": [5]}), "schema: ages and age_steps together")
expect(printed({"kind": "hoodoo", "ages": [0.5], "age_steps": [5]}) is None, "scree-bake: ages and age_steps together")

shipped = 0
for name in sorted(os.listdir(recipes)):
    with open(os.path.join(recipes, name), encoding="utf-8") as file:
        recipe = json.load(file)
    if recipe.get("kind") != "hoodoo":
        continue
    shipped += 1
    for error in validator.iter_errors(recipe):
        expect(False, f"{name}: {error.json_path}: {error.message}")
    text = printed(recipe)
    expect(text is not None, f"{name}: refused by scree-bake")
    if text is not None:
        for error in validator.iter_errors(json.loads(text)):
            expect(False, f"{name} as printed: {error.json_path}: {error.message}")

print(f"{compared} recipes compared, {shipped} shipped ones")
for fault in faults:
    print(fault)
sys.exit(1 if faults else 0)

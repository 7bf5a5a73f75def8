"""check_schema.py SCHEMA PRINT_KEYS KIND RECIPES WORK

Holds the JSON schema of recipes of a KIND (rocks, hoodoo, shards) against the baker: the same keys, ranges, choices and defaults at
every depth; and for many a recipe with one value at or beyond its end, of a wrong type or in a wrong place, both must give the same
verdict. Every recipe of this kind in the folder RECIPES must fit both.
"""

import json
import os
import subprocess
import sys

import jsonschema

import schema_tries

schema_path, print_keys, word, recipes, work = sys.argv[1:6]
faults = []


def expect(condition, text):
    if not condition:
        faults.append(text)


schema = json.load(open(schema_path, encoding="utf-8"))
table = json.loads(subprocess.run([print_keys, word], check=True, capture_output=True, text=True).stdout)
plain_kind = {} if word == "rocks" else {"kind": word}


def resolve(part):
    while "$ref" in part:
        part = {**schema["$defs"][part["$ref"].rsplit("/", 1)[1]], **{k: v for k, v in part.items() if k != "$ref"}}
    return part


def without(part, name):
    return {**part, "properties": {k: v for k, v in part["properties"].items() if k != name}}


def compare_number(part, ends, whole, path):
    expect((part.get("minimum"), part.get("maximum")) == ends, f"{path}: ends differ from {ends}")
    expect(part.get("type") == ("integer" if whole else "number"), f"{path}: type")


def compare(key, part, path):
    part = resolve(part)
    expect(part.get("description", "") != "", f"{path}: no description")
    kind = key["kind"]
    whole = kind in ("count", "seed", "counts", "count_range", "times")
    ends = (key["min"], key["max"])
    length = (part.get("minItems"), part.get("maxItems"))
    if kind in ("number", "count", "seed"):
        compare_number(part, ends, whole, path)
    elif kind in ("range", "count_range"):
        one, two = part["oneOf"]
        compare_number(one, ends, whole, path)
        compare_number(two["items"], ends, whole, path)
        expect((two["minItems"], two["maxItems"]) == (2, 2), f"{path}: length")
    elif kind in ("counts", "numbers", "values", "times"):
        compare_number(part.get("items", {}), ends, whole, path)
        fixed = kind in ("counts", "numbers")
        expect(length[1] == key["size"] and (not fixed or length[0] == key["size"]), f"{path}: length")
    elif kind == "text":
        expect(part.get("maxLength") == key["max"], f"{path}: maxLength")
    elif kind == "choice":
        expect(part.get("enum") == key["words"].split(), f"{path}: choices")
    elif kind == "bool":
        expect(part.get("type") == "boolean", f"{path}: type")
    elif kind == "object":
        compare_members(key["members"], part, path)
    else:
        expect(length == (key["least"], key["size"]), f"{path}: length")
        if kind == "rows":
            compare_rows(key, part["items"], path)
        else:
            compare_members(key["members"] + (table["rules"] if kind == "phases" else []), part["items"], path)


def compare_rows(key, row, path):
    columns = row["prefixItems"]
    expect(len(columns) == len(key["members"]) == row["maxItems"], f"{path}: columns")
    expect(row["minItems"] == (key["columns"] or len(columns)), f"{path}: columns of a short row")
    for column, item in zip(key["members"], columns):
        expect((item["minimum"], item["maximum"]) == (column["min"], column["max"]), f"{path}: ends of {column['name']}")


def compare_members(keys, part, path):
    alone = next((key for key in keys if key.get("alone")), None)
    if alone is not None:
        single, listed = part["anyOf"]
        others = [key for key in keys if key is not alone]
        compare_members(others + alone["members"], single, path)
        compare_members(others, without(listed, alone["name"]), path)
        compare(alone, listed["properties"][alone["name"]], f"{path}.{alone['name']}")
        return
    if "anyOf" in part:
        name, words = keys[0]["name"], keys[0]["words"].split()
        expect([a["properties"][name]["const"] for a in part["anyOf"]] == words, f"{path}: choices of {name}")
        for number, choice in enumerate(part["anyOf"]):
            own = [m for m in keys[1:] if m.get("only", 2**32 - 1) >> number & 1]
            expect(choice["properties"][name].get("description", "") != "", f"{path} {words[number]}: no description")
            compare_members(own, without(choice, name), f"{path} {words[number]}")
        return
    names, there = sorted(key["name"] for key in keys), sorted(part["properties"])
    expect(names == there, f"{path}: keys differ: {sorted(set(names) ^ set(there))}")
    expect(part.get("additionalProperties") is False, f"{path}: unknown keys are allowed")
    for key in keys:
        if key["name"] in part["properties"]:
            compare(key, part["properties"][key["name"]], f"{path}.{key['name']}")


top = {k: v for k, v in schema["properties"].items() if k not in ("$schema", "kind")}
compare_members(table["keys"] + table["rules"], {**schema, "properties": top}, "recipe")
path = os.path.join(work, f"schema_{word}.json")
validator = jsonschema.validators.validator_for(schema)(schema)


def printed(value):
    with open(path, "w", encoding="utf-8") as file:
        json.dump(value, file)
    run = subprocess.run([print_keys, word, path], capture_output=True, text=True)
    expect(run.returncode in (0, 2), f"{value}: exit status {run.returncode}")
    return run.stdout if run.returncode == 0 else None


# What a default says, the baker takes for what is left out.
plain = json.dumps(table["defaults"])
for name, part in top.items():
    if name in ("age_steps", "shares"):
        continue
    text = printed({**plain_kind, name: resolve(part)["default"]})
    expect(text is not None and json.dumps(json.loads(text)) == plain, f"{name}: its default is not the baker's")

# Rules between keys that no schema can say.
beside = {"contact_radius": {"contact_blend": 1.5}, "contact_blend": {"contact_radius": 0}}
if word == "rocks":
    values = {key["name"]: schema_tries.of_rocks(key) for key in table["keys"]}
    values.update({"kind": ["hoodoo", 5], "colour": [1]})
else:
    values = schema_tries.HOODOO if word == "hoodoo" else schema_tries.SHARDS
expect(sorted(set(values) - {"kind", "colour"}) == sorted(top), "a key without values to try")
compared = 0
for name, tries in values.items():
    for value in tries:
        recipe = {**plain_kind, **beside.get(name, {}), name: value}
        by_schema = validator.is_valid(recipe)
        by_baker = printed(recipe) is not None
        expect(by_schema == by_baker, f"{json.dumps(recipe)}: schema {'accepts' if by_schema else 'refuses'}, the baker does not agree")
        compared += 1
for both in ({"ages": [0.5], "age_steps": [5]}, {"paths": [5], "shares": [0.5]}):
    expect(not validator.is_valid({**plain_kind, **both}), f"schema: {' and '.join(both)} together")
    expect(printed({**plain_kind, **both}) is None, f"baker: {' and '.join(both)} together")

shipped = 0
for name in sorted(os.listdir(recipes)):
    with open(os.path.join(recipes, name), encoding="utf-8") as file:
        recipe = json.load(file)
    if recipe.get("kind", "rocks") != word:
        continue
    shipped += 1
    for error in validator.iter_errors(recipe):
        expect(False, f"{name}: {error.json_path}: {error.message}")
    text = printed(recipe)
    expect(text is not None, f"{name}: refused by the baker")
    if text is not None:
        for error in validator.iter_errors(json.loads(text)):
            expect(False, f"{name} as printed: {error.json_path}: {error.message}")
expect(shipped >= 5, f"only {shipped} recipes ship")

print(f"{compared} recipes compared, {shipped} shipped ones")
for fault in faults:
    print(fault)
sys.exit(1 if faults else 0)

"""check_recipe_schema.py SCHEMA PRINT_RECIPE_KEYS SCREE_BAKE RECIPES WORK

Holds the JSON schema of recipes against the baker: the same keys, types, ranges, defaults and choices; and for many a recipe with one
key at or beyond its end, or of a wrong type, both must give the same verdict. Every recipe in the folder RECIPES must fit both.
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


def ends(part):
    """The one pair of minimum and maximum that a key's schema names, wherever it stands."""
    found = {(p["minimum"], p["maximum"]) for p in walk(part) if "minimum" in p}
    return found.pop() if len(found) == 1 else None


def walk(part):
    if isinstance(part, dict):
        yield part
        for value in part.values():
            yield from walk(value)
    elif isinstance(part, list):
        for value in part:
            yield from walk(value)


schema = json.load(open(schema_path, encoding="utf-8"))
table = json.loads(subprocess.run([print_keys], check=True, capture_output=True, text=True).stdout)
properties = {name: part for name, part in schema["properties"].items() if name not in ("$schema", "kind")}
expect(schema.get("additionalProperties") is False, "the schema allows unknown keys")
names = [key["name"] for key in table["keys"]]
expect(sorted(names) == sorted(properties), f"keys differ: {sorted(set(names) ^ set(properties))}")
for key in table["keys"]:
    name = key["name"]
    part = properties.get(name, {})
    expect(part.get("default") == table["defaults"][name], f"{name}: default {part.get('default')}, not {table['defaults'][name]}")
    expect(part.get("description", "") != "", f"{name}: no description")
    if key["kind"] == "choice":
        expect(part.get("enum") == key["choices"].split(), f"{name}: enum {part.get('enum')}, not {key['choices']}")
    elif key["kind"] == "bool":
        expect(part.get("type") == "boolean", f"{name}: type {part.get('type')}")
    elif key["kind"] == "text":
        expect(part.get("maxLength") == key["max"], f"{name}: maxLength {part.get('maxLength')}")
    else:
        expect(ends(part) == (key["min"], key["max"]), f"{name}: ends {ends(part)}, not {(key['min'], key['max'])}")

validator = jsonschema.validators.validator_for(schema)(schema)
path = os.path.join(work, "recipe.json")


def accepted_by_baker(text):
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    run = subprocess.run([bake, path, "--print-recipe"], capture_output=True, text=True)
    expect(run.returncode in (0, 2), f"{text}: exit status {run.returncode}")
    return run.returncode == 0


compared = 0
for key in table["keys"]:
    low, high = key["min"], key["max"]
    if key["kind"] == "vector":
        values = [[low, 0, high], [high * 2, 0, 0], [0, 1], [0, 1, 0, 0], 5, ["a", 0, 1]]
    elif key["kind"] == "bool":
        values = [True, False, 0, 1, "true", None, [True]]
    elif key["kind"] in ("text", "choice"):
        values = ["random", "aligned", "x" * 63, "x" * 64, 5, None, ["random"]]
    elif key["kind"] == "seed":
        values = [0, 1, 2**53, 2**53 + 2, -1, 0.5, "1", None]
    else:
        step = 2 if key["kind"] == "count" else 1
        values = [low, high, low - step, high + step, low + 0.5, "1", None, True, [], {}, [low, high], [low], [low, high, high], [low, "x"]]
    for value in values:
        recipe = {key["name"]: value}
        if key["name"] == "contact_radius":
            recipe["contact_blend"] = 1.5  # the one rule between keys that no schema can say
        if key["name"] == "contact_blend":
            recipe["contact_radius"] = 0
        text = json.dumps(recipe)
        by_schema = validator.is_valid(recipe)
        by_baker = accepted_by_baker(text)
        expect(by_schema == by_baker, f"{text}: schema {'accepts' if by_schema else 'refuses'}, scree-bake does not agree")
        compared += 1

shipped = sorted(name for name in os.listdir(recipes) if name.endswith(".json"))
expect(len(shipped) >= 5, f"only {len(shipped)} recipes ship")
for name in shipped:
    with open(os.path.join(recipes, name), encoding="utf-8") as file:
        text = file.read()
    if json.loads(text).get("kind") in ("hoodoo", "shards"):
        continue  # see check_hoodoo_schema.py
    for error in validator.iter_errors(json.loads(text)):
        expect(False, f"{name}: {error.json_path}: {error.message}")
    expect(accepted_by_baker(text), f"{name}: refused by scree-bake")

print(f"{len(names)} keys, {compared} recipes compared, {len(shipped)} shipped ones")
for fault in faults:
    print(fault)
sys.exit(1 if faults else 0)

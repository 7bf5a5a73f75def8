#!/usr/bin/python3
"""scree-bake as a program, and recipe.schema.json held against its reader. Usage: check_bake.py SCREE-BAKE WORK-FOLDER

Every shipped recipe must pass schema and reader; one with every key is then spoiled in one place after the other, and the two must
agree on each. Wrong arguments and outputs that cannot be made end with status 2 and one line that names them, before any rock is
baked, and leave nothing behind. Exit status 77 (skipped) without python3-jsonschema."""

import glob
import json
import os
import shutil
import subprocess
import sys

try:
    import jsonschema
except ImportError:
    print("skipped: python3-jsonschema is not installed")
    sys.exit(77)

BAKE, WORK = (os.path.abspath(path) for path in sys.argv[1:3])
CONTENT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "content")
VALUES = [None, True, "x", "", "z" * 64, [], [1], [1, 2], [2, 1], [1, 2, 3], [1, "x"], {}]
VALUES += [-1, 0, 0.5, 1, 3, 7, 21, 65, 101, 2**53, 1e17, 1e300]
# Rules between two values, which a schema cannot say.
READER_ALONE = ["is greater than the most", "must be greater than contact_radius"]
faults = []


def expect(condition, what):
    if not condition:
        faults.append(what)


def bake(*arguments):
    return subprocess.run([BAKE, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=WORK)


def write(name, text):
    with open(os.path.join(WORK, name), "w", encoding="utf-8") as file:
        file.write(text)
    return name


def refused(named, *arguments):
    before = sorted(os.listdir(WORK))
    result = bake(*arguments)
    said = f"{' '.join(arguments)}: status {result.returncode}, said {result.stderr!r}"
    expect(result.returncode == 2, f"not status 2: {said}")
    expect(result.stderr.count("\n") == 1 and named in result.stderr, f"not one line with '{named}': {said}")
    expect(result.stdout == "" and sorted(os.listdir(WORK)) == before, f"something was written: {said}")
    return result.stderr


def limits(rule):
    """Just inside and just outside of what a rule of the schema allows."""
    for part in [rule, rule.get("items", {}), *rule.get("oneOf", [])]:
        for limit in (part.get(word) for word in ("minimum", "maximum")):
            if limit is not None:
                step = 0.001 if part["type"] == "number" else 1 if limit < 2**53 else 2  # a double holds no odd number beyond
                yield from (limit - step, limit, limit + step, [limit, limit], [limit - step] * 3, [limit + step] * 3)


def schema_and_reader_agree():
    with open(os.path.join(CONTENT, "schema", "recipe.schema.json"), encoding="utf-8") as file:
        schema = json.load(file)
    validator = jsonschema.Draft202012Validator(schema)
    shipped = glob.glob(os.path.join(CONTENT, "recipes", "*.json"))
    expect(len(shipped) >= 5, "fewer than five recipes ship")
    for path in shipped:
        with open(path, encoding="utf-8") as file:
            expect(validator.is_valid(json.load(file)), f"{path}: the schema refuses it")
        expect(bake(path, "--print-recipe").returncode == 0, f"{path}: the reader refuses it")

    defaults = json.loads(bake(write("empty.json", "{}"), "--print-recipe").stdout)
    told = {key: value["default"] for key, value in schema["properties"].items() if key != "$schema"}
    expect(defaults == told, f"the defaults of the schema are not the reader's: {defaults} {told}")

    count = 0
    for key in list(schema["properties"]) + ["unknown"]:
        for value in VALUES + list(limits(schema["properties"].get(key, {}))):
            recipe = dict(defaults, **{key: value})
            good = bake(write("spoiled.json", json.dumps(recipe)), "--print-recipe").returncode == 0
            line = "" if good else refused("spoiled.json: ", "spoiled.json", "--print-recipe")
            expect(good or key in line, f"{key} = {value!r}: '{line}' does not name it")
            alone = any(rule in line for rule in READER_ALONE)
            expect(validator.is_valid(recipe) == (good or alone), f"{key} = {value!r}: the reader said '{line}', the schema otherwise")
            count += 1
    return count


def bad_recipes_are_named():
    for text in ["", "{", "[]", "5", '{"n": 5} more', '{"n": 5}{}', '{"n": 5,}', '{"n": NaN}', "[" * 5000]:
        refused("bad.json: ", write("bad.json", text), "-o", "x.scree")
    refused("bad.json: n: given twice", write("bad.json", '{"n": 5, "n": 6}'), "-o", "x.scree")
    whole = json.dumps({"name": "cut", "n": 5, "seeds": [1, 2]})
    for length in range(len(whole)):
        refused("cut.json: ", write("cut.json", whole[:length]), "-o", "x.scree")
    refused("nowhere.json: ", "nowhere.json", "-o", "x.scree")
    refused("--set: n: ", "empty.json", "-o", "x.scree", "--set", "n=3")
    refused("--set: n: ", "empty.json", "-o", "x.scree", "--set", "n")
    refused("--set: rocks: ", "empty.json", "-o", "x.scree", "--set", "rocks=3")
    result = bake("empty.json", "--print-recipe", "--set", "n=5", "--set", "g=[1,2]", "--set", "name=cobbles")
    changed = json.loads(result.stdout)
    expect((changed["n"], changed["g"], changed["name"]) == (5, [1, 2], "cobbles"), "--set does not override")


def bad_arguments_are_named():
    refused("no recipe")
    refused("no output", "empty.json")
    refused("--frobnicate", "empty.json", "--frobnicate")
    refused("-o: needs a value", "empty.json", "-o")
    refused("b.json", "a.json", "b.json", "-o", "x.scree")
    for threads in ["0", "257", "two", ""]:
        refused("--threads", "empty.json", "-o", "x.scree", "--threads", threads)
    expect(bake("--help").stdout.startswith("Usage: scree-bake"), "--help says nothing")
    expect(bake("--version").stdout.startswith("scree-bake "), "--version says nothing")


def outputs_are_looked_at_first():
    """n = 9 would take minutes."""
    large = write("large.json", '{"n": 9, "seeds": 20}')
    refused("no/such/x.scree: ", large, "-o", "no/such/x.scree")
    refused(WORK + ": ", large, "-o", WORK)
    refused("no/such/r.json: ", large, "-o", "x.scree", "--report", "no/such/r.json")
    refused("x.scree: cannot be both", large, "-o", "x.scree", "--report", "x.scree")


def devices_are_written_to():
    """A pipe stands for /dev/null, which a rename would replace."""
    pipe = os.path.join(WORK, "pipe")
    os.mkfifo(pipe)
    small = os.path.join(CONTENT, "golden", "small.json")
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    result = bake(small, "-o", "x.scree", "--report", pipe)
    expect(result.returncode == 0 and result.stderr == "", f"not quiet when piped: {result.stderr!r}")
    report = json.loads(os.read(reader, 65536))
    os.close(reader)
    expect(os.path.exists(pipe) and not os.path.isfile(pipe), "a pipe was replaced by a file")
    expect({"rocks", "triangles", "bytes", "digest", "seconds"} <= set(report), f"the report lacks something: {report}")
    expect(report["bytes"] == os.path.getsize(os.path.join(WORK, "x.scree")), "the report's bytes are not the pack's")
    expect(len(report["seconds"]) > 3, "the report has no seconds by stage")


shutil.rmtree(WORK, ignore_errors=True)
os.makedirs(WORK)
count = schema_and_reader_agree()
bad_recipes_are_named()
bad_arguments_are_named()
outputs_are_looked_at_first()
devices_are_written_to()
for fault in faults[:40]:
    print(fault)
print(f"{count} spoiled recipes, {len(faults)} faults")
sys.exit(1 if faults else 0)

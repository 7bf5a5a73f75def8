"""Holds scene.schema.json and the scene reader against each other. Usage: check_scenes.py SCENE_CHECK WORK_FOLDER

Every shipped scene and some that use every key must pass both. The latter are then spoiled in one place after the other (a key missing,
unknown, of another type, out of range) and the two must agree on each. What a schema cannot say is listed in READER_ALONE.
Exit status 77 (skipped) without python3-jsonschema.
"""

import copy
import glob
import json
import os
import subprocess
import sys

try:
    import jsonschema
except ImportError:
    print("skipped: python3-jsonschema is not installed")
    sys.exit(77)

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
VALUES = [None, True, "x", "", "#12345g", [], [1, 2], [1, 2, 3, 4], {}, -1, 0, 0.5, 1, 3, 171, 2**53, 1e17, 1e300, "z" * 600]
# Rules between two values.
READER_ALONE = [
    "expected a number > low",
    "expected at least 2 columns and 2 rows",
    "expected another point than eye",
    "expected a vector that is not zero",
    "expected at most the smallest half extent",
    "expected above + below > 0",
    "expected a number >= from",
    "expected the smaller number first",
]

SPHERE = {"shape": "sphere"}
MAP = {"file": "a.png", "spacing": 1, "low": 0.5, "high": 2, "crop": [1, 2, 3, 4]}
HEAD = {
    "name": "every key but those of shapes",
    "camera": {"eye": [1, 2, 3], "target": [0, 0, 0], "fov": 50},
    "sun": {"direction": [0, 1, 0], "colour": "#ffffff"},
    "sky": "#8090a0",
    "ground": {"kind": "terrain", "cover": "sand", "position": [1, 2, 3], "colour": "#000000", **MAP, "water": {"height": 1, "colour": "#000000"}},
    "fields": [
        {
            "name": "f",
            "pack": "boulders",
            "seed": 1,
            "cell_size": 1,
            "origin": [0, 0, 0],
            "threshold": 0.5,
            "shell": False,
            "palette": {"colours": ["#000000", "#ffffff"], "variation": 0.5},
            "key": 65535,
            "density": 0.5,
            "filters": [
                {"filter": "mask", "file": "m.png", "spacing": 1, "crop": [1, 2, 3, 4], "position": [1, 2, 3], "inverted": True},
                {"filter": "slope", "from": 0.5, "to": 80, "fade": 3, "position": [0, 0, 0], "inverted": False, **MAP},
                {"filter": "altitude", "from": -1, "to": 400, "fade": 1, "inverted": True},
            ],
            "support": SPHERE,
        }
    ],
}
AGES = {"file": "a.png", "spacing": 1, "crop": [1, 2, 3, 4], "position": [1, 2, 3], "inverted": True}
SCATTER = {
    "name": "h",
    "pack": "goblin",
    "seed": 1,
    "spacing": 3,
    "origin": [0, 0, 0],
    "scale": [0.5, 1],
    "max_slope": 30,
    "weights": [0.5, 3],
    "ages": AGES,
    "key": 7,
    "density": 0.5,
    "filters": [{"filter": "altitude", "from": -1, "to": 400, "fade": 1, "inverted": True}],
    "palette": {"colours": ["#000000", "#ffffff"], "variation": 0.5},
    "support": SPHERE,
}
MODELS = {"models": ["tree.glb", "bush.gltf"], "spacing": 3, "support": SPHERE}
SHAPES = [
    {"shape": "sphere", "radius": 1, "name": "s", "position": [1, 2, 3], "rotation": [1, 2, 3], "scale": 2},
    {"shape": "box", "half": [1, 1, 1], "rounding": 0.25},
    {"shape": "capsule", "a": [0, 0, 0], "b": [0, 1, 0], "radius": 1},
    {"shape": "cylinder", "radius": 1, "half_height": 2},
    {"shape": "cone", "radius": 1, "height": 1},
    {"shape": "heightfield", "above": 1, "below": 1, **MAP},
    {"shape": "mesh", "file": "m.off", "resolution": 64},
    {"shape": "ellipsoid", "radii": [1, 2, 3]},
    {"shape": "half_space", "name": "below"},
    {"shape": "torus", "radius": 2, "tube_radius": 0.5},
    {"shape": "extrusion", "points": [[0, 0], [1, 0], [0, 1]], "low": 0.5, "high": 2},
    {"shape": "tube", "points": [[0, 0, 0, 1], [1, 0, 0, 0.5]], "closed": True, "subdivisions": 4, "half_height": 1},
    {"shape": "blobs", "points": [[0, 0, 0, 1], [1, 2, 3, 0.5]]},
    {"shape": "pattern", "pattern": "waves", "spacing": 1, "radius": 0.5, "amplitude": 0.5, "wavelength": 3},
    {"shape": "union", "children": [SPHERE]},
    {"shape": "intersection", "children": [SPHERE, SPHERE]},
    {"shape": "difference", "children": [SPHERE]},
    {"shape": "smooth_union", "blend": 1, "children": [{"shape": "union", "children": [SPHERE]}]},
    {"shape": "noise", "amplitude": 0.5, "wavelength": 2, "octaves": 3, "seed": 7, "child": {"shape": "union", "children": [SPHERE]}},
]


def places(value, below=(), path=()):
    """Every place of a JSON tree at or under `below`, but one element of each list of numbers."""
    if path[: len(below)] == below:
        yield path
    if isinstance(value, dict):
        for key in value:
            yield from places(value[key], below, path + (key,))
    elif isinstance(value, list):
        for i in range(len(value)):
            if i == 0 or isinstance(value[i], dict):
                yield from places(value[i], below, path + (i,))


def spoiled(scene, below):
    """Copies of a scene with one fault each, at or under `below`, as (what, scene)."""
    for path in places(scene, below):
        where = ".".join(map(str, path))

        def parent_of(copied):
            for step in path[:-1]:
                copied = copied[step]
            return copied

        if path:
            changed = copy.deepcopy(scene)
            del parent_of(changed)[path[-1]]
            yield f"without {where}", changed
            for value in VALUES:
                changed = copy.deepcopy(scene)
                parent_of(changed)[path[-1]] = value
                yield f"{where} = {json.dumps(value)[:20]}", changed
        target = scene
        for step in path:
            target = target[step]
        if isinstance(target, dict):
            changed = copy.deepcopy(scene)
            target = changed
            for step in path:
                target = target[step]
            target["unheard_of"] = 1
            yield f"unknown key in {where}", changed


def main():
    checker, folder = sys.argv[1], sys.argv[2]
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(ROOT, "content/schema/scene.schema.json"), encoding="utf-8") as file:
        schema = json.load(file)
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)

    cases = []
    for path in sorted(glob.glob(os.path.join(ROOT, "content/scenes/*.json"))):
        with open(path, encoding="utf-8") as file:
            scene = json.load(file)
        if scene.get("$schema") != "../schema/scene.schema.json":
            sys.exit(f"{path}: $schema does not name the schema")
        cases.append((path, scene, True))
    bases = [(HEAD, ())]
    bases += [({"fields": [scatter]}, ("fields", 0)) for scatter in (SCATTER, MODELS, {**SCATTER, "weights": [1]})]
    bases += [({"fields": [{"pack": "b", "support": shape}]}, ("fields", 0, "support")) for shape in SHAPES]
    for base, below in bases:
        cases.append((json.dumps(base), base, True))
        cases += [(what, scene, None) for what, scene in spoiled(base, below)]

    names = []
    for i, (_, scene, _) in enumerate(cases):
        names.append(os.path.join(folder, f"{i}.json"))
        with open(names[-1], "w", encoding="utf-8") as file:
            json.dump(scene, file)
    answers = subprocess.run([checker], input="\n".join(names) + "\n", capture_output=True, text=True, check=True).stdout.splitlines()
    for name in names:
        os.remove(name)
    if len(answers) != len(cases):
        sys.exit("the reader did not answer for every scene")

    faults = accepted = 0
    for (what, scene, expected), answer in zip(cases, answers):
        by_reader = answer == "accepted"
        by_schema = validator.is_valid(scene)
        accepted += by_reader
        agree = by_reader == by_schema or (by_schema and any(rule in answer for rule in READER_ALONE))
        if not agree or (expected and not by_reader):
            faults += 1
            print(f"{what}: the schema says {'yes' if by_schema else 'no'}, the reader: {answer}")
    print(f"{len(cases)} scenes, {accepted} of them good, {faults} disagreements")
    sys.exit(1 if faults else 0)


main()

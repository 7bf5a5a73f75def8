"""Checks JSON files named on standard input, one a line: each parses, has no key twice, and fits the schema of its folder.

content/recipes/*.json and content/golden/*.json are held against content/schema/recipe.schema.json, or hoodoo.schema.json or
shards.schema.json where they say so, content/scenes/*.json against scene.schema.json; a schema itself must be a valid one. Prints one line per fault; exit status 1 if there was any.
"""

import json
import os
import sys

import jsonschema

SCHEMAS = {
    "content/recipes": "content/schema/recipe.schema.json",
    "content/golden": "content/schema/recipe.schema.json",
    "content/scenes": "content/schema/scene.schema.json",
}


def no_key_twice(pairs):
    found = {}
    for key, value in pairs:
        if key in found:
            raise ValueError(f"key '{key}' appears twice")
        found[key] = value
    return found


def load(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file, object_pairs_hook=no_key_twice)


def faults_of(path):
    try:
        value = load(path)
    except ValueError as error:
        return [f"{path}: {error}"]
    if path.endswith(".schema.json"):
        validator = jsonschema.validators.validator_for(value)
        try:
            validator.check_schema(value)
        except jsonschema.SchemaError as error:
            return [f"{path}: not a valid schema: {error.message}"]
        return []
    schema_path = SCHEMAS.get(os.path.dirname(path))
    kind = value.get("kind") if isinstance(value, dict) and schema_path is not None else None
    if kind in ("hoodoo", "shards"):
        schema_path = f"content/schema/{kind}.schema.json"
    if schema_path is None:
        return []
    if not os.path.exists(schema_path):
        return [f"{path}: there is no {schema_path}"]
    schema = load(schema_path)
    validator = jsonschema.validators.validator_for(schema)(schema)
    return [
        f"{path}: {'/'.join(str(part) for part in error.absolute_path) or '(top)'}: {error.message}"
        for error in validator.iter_errors(value)
    ]


def main():
    faults = [fault for line in sys.stdin for fault in faults_of(line.strip())]
    for fault in faults:
        print(fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

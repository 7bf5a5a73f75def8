"""check_cliff_glb.py SCREE_BAKE SCREE_INFO SCREE_SCATTER WORK

Cliffs as .glb: UVs are TEXCOORD_0, cut faces a primitive of their own with the material "cut", the rest "rock". A cube with UVs is
split, written by scree-info and by scree-scatter in both forms, and held against the file that it was made of and the second reader
of packs. What Draco bytes hold is in test_model_export.c. Leaves WORK/*.glb for the glTF validator. Prints what does not hold and
exits with 1; with 77 where all but the second reader was asked, for want of python3-xxhash.
"""

import json
import os
import shutil
import struct
import subprocess
import sys
from collections import Counter

from uv_cube import PLACES, SIDES, on_side

try:
    import pack_reader
except SystemExit:
    pack_reader = None

BAKE, INFO, SCATTER, WORK = sys.argv[1:5]
LATTICE = 1024
faults = []

# Side i of the cube has the UVs (i + s) / 6, 2 t - 1, so that the range is no unit square; v runs down.
CORNERS = ((0, 0), (1, 0), (1, 1), (0, 1))


def expect(condition, what):
    if not condition and what not in faults:
        faults.append(what)


def law(side, s, t):
    return (side + s) / 6, 2 * t - 1


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    expect(done.returncode == 0, f"{' '.join(command[1:])}: {done.stderr!r}")
    return done.returncode == 0


def path(name):
    return os.path.join(WORK, name)


def bake(name, **members):
    recipe = {"kind": "shards", "name": name, "seeds": {"count": 60}, "paths": [0, 3000], "lattice_per_metre": LATTICE, "lod_levels": 1,
              "clip": "mesh", "input": {"shape": "mesh", "file": "cube.obj"}, **members}
    with open(path(name + ".json"), "w", encoding="utf-8") as file:
        json.dump(recipe, file)
    return run(BAKE, path(name + ".json"), "-o", path(name + ".scree"), "-q")


class Glb:
    def __init__(self, name):
        with open(path(name), "rb") as file:
            data = file.read()
        length = struct.unpack_from("<I", data, 12)[0]
        self.name = name
        self.tree = json.loads(data[20:20 + length])
        self.bytes = data[28 + length:]

    def numbers(self, accessor):
        a = self.tree["accessors"][accessor]
        view = self.tree["bufferViews"][a["bufferView"]]
        size = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[a["type"]]
        form = "<" + str(size) + {5121: "B", 5123: "H", 5125: "I", 5126: "f"}[a["componentType"]]
        start = view["byteOffset"] + a.get("byteOffset", 0)
        stride = view.get("byteStride", struct.calcsize(form))
        return [struct.unpack_from(form, self.bytes, start + i * stride) for i in range(a["count"])]

    def parts(self, mesh):
        """The primitives of a mesh by the names of their materials."""
        named = [(self.tree["materials"][p["material"]]["name"], p) for p in self.tree["meshes"][mesh]["primitives"]]
        expect(len({name for name, _ in named}) == len(named), f"{self.name}: two primitives of one material")
        expect({name for name, _ in named} <= {"rock", "cut"}, f"{self.name}: materials {[name for name, _ in named]}")
        return dict(named)

    def triangles(self, primitive):
        """Corners as place and UV; no vertex may be of another primitive."""
        places, uvs = (self.numbers(primitive["attributes"][key]) for key in ("POSITION", "TEXCOORD_0"))
        indices = [i for (i,) in self.numbers(primitive["indices"])]
        expect(set(indices) == set(range(len(places))) and len(uvs) == len(places), f"{self.name}: vertices that nothing uses")
        return [[(places[v], uvs[v]) for v in indices[i:i + 3]] for i in range(0, len(indices), 3)]

    def node_of(self, row):
        return next(node["mesh"] for i, node in enumerate(n for n in self.tree["nodes"] if "mesh" in n) if i == row)


def expect_law(name, glb, time, cut):
    """What stands is the cube where its material is rock, with the cube's UVs; cuts are inside."""
    parts = glb.parts(glb.node_of(time))
    expect(set(parts) == ({"rock", "cut"} if cut else {"rock"}), f"{name}: at {time}, primitives {sorted(parts)}")
    rock = glb.triangles(parts["rock"]) if "rock" in parts else []
    for corners in rock:
        # The middle of the cube is at x = z = 0.
        places = [(x + 1, y, z + 1) for (x, y, z), _ in corners]
        side = next((i for i, quad in enumerate(SIDES) if all(on_side(quad, p)[2] < 1e-6 for p in places)), None)
        expect(side is not None, f"{name}: at {time}, rock that is on no side")
        for place, (_, uv) in zip(places, corners) if side is not None else ():
            want = law(side, *on_side(SIDES[side], place)[:2])
            expect(max(abs(a - b) for a, b in zip(uv, want)) <= 3 / LATTICE, f"{name}: at {time}, {place}: {uv}, not {want}")
    expect(cut or len(rock) == 12, f"{name}: {len(rock)} triangles of an untouched cube")
    for corners in glb.triangles(parts["cut"]) if "cut" in parts else []:
        places = [(x + 1, y, z + 1) for (x, y, z), _ in corners]
        expect(not any(all(on_side(quad, p)[2] < 1e-6 for p in places) for quad in SIDES), f"{name}: a side is a cut")


def by_place(triangles):
    """UVs of the corners by the lattice places of a triangle, whatever its first corner."""
    found = {}
    for corners in triangles:
        whole = [(tuple(round(x * LATTICE) for x in place), uv) for place, uv in corners]
        first = whole.index(min(whole))
        whole = whole[first:] + whole[:first]
        found[tuple(place for place, _ in whole)] = [uv for _, uv in whole]
    expect(len(found) == len(triangles), "two triangles at one place")
    return found


def expect_pack(name, glb, pack, count):
    """Every triangle of every asset, with its UVs, in the primitive of its material."""
    ranges = list(zip(pack.uv_min, pack.uv_max))
    for asset in range(count):
        places, surface, uvs, triangles = pack.coarsest_of(asset)
        wanted = {"rock": [], "cut": []}
        for triangle in triangles:
            wanted["cut" if all(surface[v][0] % 16 == 2 for v in triangle) else "rock"].append(
                [([x / LATTICE for x in places[v]], [low + (high - low) * t / 65535 for t, (low, high) in zip(uvs[v], ranges)])
                 for v in triangle])
        parts = glb.parts(glb.node_of(asset))
        for part, triangles in wanted.items():
            found = by_place(glb.triangles(parts[part]) if part in parts else [])
            wants = by_place(triangles)
            expect(found.keys() == wants.keys(), f"{name}: asset {asset}, {part}: {len(found)} triangles, not {len(wants)}, or others")
            for key in found.keys() & wants.keys():
                off = max(abs(a - b) for mine, theirs in zip(found[key], wants[key]) for a, b in zip(mine, theirs))
                expect(off < 1e-5, f"{name}: asset {asset}, {part}: UVs {found[key]}, not {wants[key]}")


def expect_scattered(form, keep):
    """A scene of the cliff and of its blocks: each mesh has its UVs, in Draco bytes too."""
    fields = [{"pack": "levels", "time": 1}, {"pack": "levels", "time": 1, "what": "blocks", "origin": [9, 0, 0]}]
    with open(path("scene.json"), "w", encoding="utf-8") as file:
        json.dump({"fields": fields}, file)
    if not run(SCATTER, path("scene.json"), "-o", path(keep), "--format", form, "--packs", WORK, "--rocks", "all"):
        return
    glb = Glb(keep)
    names = Counter()
    for mesh in range(len(glb.tree["meshes"])):
        for name, primitive in glb.parts(mesh).items():
            names[name] += 1
            uvs = primitive["attributes"].get("TEXCOORD_0")
            expect(uvs is not None, f"{keep}: no TEXCOORD_0")
            draco = primitive.get("extensions", {}).get("KHR_draco_mesh_compression")
            expect((draco is not None) == (form == "instanced"), f"{keep}: Draco")
            if draco is not None:
                expect(set(draco["attributes"]) == set(primitive["attributes"]), f"{keep}: attributes of Draco")
                expect(len(set(draco["attributes"].values())) == 4, f"{keep}: ids of Draco")
            accessor = glb.tree["accessors"][uvs or 0]
            expect(accessor["type"] == "VEC2" and accessor["componentType"] == 5126, f"{keep}: TEXCOORD_0 are no two floats")
    expect(names["cut"] > 1 and names["rock"] > 0, f"{keep}: primitives {names}")


shutil.rmtree(WORK, ignore_errors=True)
os.makedirs(WORK)
lines = [f"v {x} {y} {z}" for x, y, z in PLACES]
lines += [f"vt {u!r} {1 - v!r}" for side in range(6) for u, v in (law(side, s, t) for s, t in CORNERS)]
lines += ["f " + " ".join(f"{v + 1}/{4 * side + k + 1}" for k, v in enumerate(quad)) for side, quad in enumerate(SIDES)]
with open(path("cube.obj"), "w", encoding="utf-8") as out:
    out.write("\n".join(lines) + "\n")
with open(path("plain.obj"), "w", encoding="utf-8") as out:
    out.write("\n".join(line.split("/")[0] if line[0] != "f" else "f " + " ".join(w.split("/")[0] for w in line.split()[1:])
                        for line in lines if not line.startswith("vt")) + "\n")

for cliff, levels in (("coarse", 1), ("levels", 2)):
    if bake(cliff, lod_levels=levels) and run(INFO, path(cliff + ".scree"), "--glb", path(cliff + ".glb")):
        written = Glb(cliff + ".glb")
        expect_law(cliff, written, 0, False)
        expect_law(cliff, written, 1, True)
        if pack_reader is not None and levels == 1:
            with open(path(cliff + ".scree"), "rb") as stream:
                expect_pack(cliff, written, pack_reader.Pack(stream.read()), len(written.tree["meshes"]))
expect_scattered("flat", "flat.glb")
expect_scattered("instanced", "instanced.glb")

# No UVs, and nothing is cut: the range of the pack is empty.
if bake("bare", paths=[0], input={"shape": "mesh", "file": "plain.obj"}) and run(INFO, path("bare.scree"), "--glb", path("bare.glb")):
    bare = Glb("bare.glb").parts(0)
    expect(set(bare) == {"rock"} and "TEXCOORD_0" not in bare["rock"]["attributes"], "bare: UVs out of nowhere")

for fault in faults[:40]:
    print(fault)
if pack_reader is None and not faults:
    print("skipped: the second reader of packs, for want of python3-xxhash")
    sys.exit(77)
sys.exit(1 if faults else 0)

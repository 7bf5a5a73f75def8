#!/usr/bin/python3
"""A second reader of packs, written from docs/pack_format.md and from nothing else.

usage: pack_reader.py PACK.scree [--info SCREE-INFO]

Reads and checks a pack; with --info also compares what it read with what `SCREE-INFO --json PACK` says. Exits with 1 and one line
for the first rule or number that does not hold. Needs python3-xxhash."""

import json
import math
import struct
import subprocess
import sys

try:
    import xxhash
except ImportError:
    print("skipped: python3-xxhash is not installed")
    sys.exit(77)

MAGIC = bytes([0x89, 0x53, 0x43, 0x52, 0x0D, 0x0A, 0x1A, 0x0A])
RECIPE, TILES, CELLS, ASSETS, LODS, CONTACTS, HULLS, BLOB_INDEX, BLOBS, PARTS, MODELS, PLACEMENTS, TIMES, UVS = range(1, 15)
ELEMENT_SIZES = {
    RECIPE: [1], TILES: [4], CELLS: [4], ASSETS: [52], LODS: [16], CONTACTS: [8, 5], HULLS: [6, 3], BLOB_INDEX: [12], BLOBS: [1],
    PARTS: [4], MODELS: [24], PLACEMENTS: [16], TIMES: [32], UVS: [16]
}
MAX_BURIAL = 7  # never hidden
NAMES = ["recipe", "tiles", "cells", "assets", "lods", "contacts", "hulls", "blob_index", "blobs", "parts", "models", "placements",
         "times", "uvs"]


class Corrupt(Exception):
    pass


def check(condition, what):
    if not condition:
        raise Corrupt(what)


def xxh3(data):
    return xxhash.xxh3_64_intdigest(data)


def mesh_digest(positions, occlusion, triangles, surface=None, uvs=None):
    keys = [(x & 0xFFFF | (y & 0xFFFF) << 16 | (z & 0xFFFF) << 32 | o << 48,) for (x, y, z), o in zip(positions, occlusion)]
    if surface is not None:
        more = [m | d << 8 | ((c - 128) & 0xFF) << 16 for m, d, c, _ in surface]
        if uvs is not None:
            more = [key | group << 24 | u << 32 | v << 48 for key, (_, _, _, group), (u, v) in zip(more, surface, uvs)]
        keys = [key + (word,) for key, word in zip(keys, more)]
    total = 0
    for a, b, c in triangles:
        a, b, c = keys[a], keys[b], keys[c]
        least = min(a + b + c, b + c + a, c + a + b)
        total += xxh3(struct.pack(f"<{len(least)}Q", *least))
    return xxh3(struct.pack("<QQ", total % 2**64, len(triangles)))


def place_code(translation):
    steps = [math.floor((t + 4096) * 128) for t in translation]
    return sum((steps[axis] >> bit & 1) << (3 * bit + axis) for bit in range(21) for axis in range(3))


class Pack:
    def __init__(self, data):
        self.data = data
        self.read_header()
        self.read_sections()
        self.read_tables()
        self.read_assets()

    def read_header(self):
        data = self.data
        check(len(data) >= 64, "file is shorter than its header")
        check(data[:8] == MAGIC, "magic")
        self.format_version, self.section_count, self.file_size = struct.unpack_from("<IIQ", data, 8)
        check(self.format_version == 4, "format version")
        (check_value,) = struct.unpack_from("<I", data, 60)
        check(check_value == xxh3(data[:60]) & 0xFFFFFFFF, "header check")
        check(self.file_size == len(data), "file size")
        self.table_digest, self.digest = struct.unpack_from("<QQ", data, 24)
        self.cells_per_cube, kind, reserved, self.lattice_per_cell, self.proxy_per_cell = struct.unpack_from("<BBHHH", data, 40)
        self.lod_count, self.max_rocks_per_cell, self.max_radius = struct.unpack_from("<IIf", data, 48)
        check(kind <= 2 and reserved == 0, "kind of the pack")
        self.models = kind >= 1
        self.cliff = kind == 2
        self.kinds = range(1, (10, 12, 15)[kind])
        check(len(self.kinds) <= self.section_count <= 64, "section count")
        check(self.cells_per_cube == 0 if self.models else 1 <= self.cells_per_cube <= 16, "cells per cube")
        check(1 <= self.lattice_per_cell <= 4096, "lattice per cell")
        check(self.proxy_per_cell <= (0 if self.models else 4096), "lattice of proxies")
        self.reach = 4096 if self.models else 16
        self.proxy_count = 256 * 9 if self.proxy_per_cell > 0 else 0
        check(1 <= self.lod_count <= 8, "lod count")
        check(1 <= self.max_rocks_per_cell <= 255, "rocks per cell")
        check(0 < self.max_radius <= self.reach, "largest radius")

    def read_sections(self):
        data = self.data
        end = 64 + 32 * self.section_count
        check(end <= len(data), "section table past the end")
        check(xxh3(data[64:end]) == self.table_digest, "section table digest")
        self.sections, self.element_size, digests = {}, {}, {}
        for i in range(self.section_count):
            kind, element_size, offset, size, digest = struct.unpack_from("<IIQQQ", data, 64 + 32 * i)
            check(offset == (end + 63) // 64 * 64, f"offset of section {i}")
            check(offset + size <= len(data), f"section {i} past the end")
            check(not any(data[end:offset]), f"padding before section {i}")
            check(element_size > 0 and size % element_size == 0, f"size of section {i}")
            end = offset + size
            content = data[offset:end]
            check(xxh3(content) == digest, f"digest of section {i}")
            if kind not in ELEMENT_SIZES:
                continue
            check(kind in self.kinds and kind not in self.sections, f"kind of section {i}")
            check(element_size in ELEMENT_SIZES[kind], f"size of the elements of section {i}")
            self.sections[kind], self.element_size[kind], digests[kind] = content, element_size, digest
        check(end == len(data), "bytes after the last section")
        check(len(self.sections) == len(self.kinds), "a section is missing")
        canonical = data[40:60] + b"".join(struct.pack("<Q", digests[k]) for k in self.kinds if k not in (BLOB_INDEX, BLOBS))
        check(xxh3(canonical) == self.digest, "pack digest")

    def elements(self, kind):
        return len(self.sections[kind]) // self.element_size[kind]

    def read_tables(self):
        recipe = self.sections[RECIPE]
        check(recipe[-1:] == b"\0" and recipe.count(b"\0") == 1, "end of the recipe")
        self.recipe = json.loads(recipe[:-1].decode("utf-8"))
        n = self.cells_per_cube
        self.cell_count = self.elements(CELLS) - 1
        self.asset_count = self.elements(ASSETS)
        check(self.cell_count >= 1 and self.asset_count >= 1, "counts")
        check(self.elements(TILES) == 256 * n**3, "size of the tiles")
        self.tiles = struct.unpack(f"<{self.elements(TILES)}I", self.sections[TILES])
        check(max(self.tiles, default=0) < self.cell_count, "a tile names a cell that is not there")
        self.first_asset = struct.unpack(f"<{self.cell_count + 1}I", self.sections[CELLS])
        check(self.first_asset[0] == 0 and self.first_asset[-1] == self.asset_count, "ends of the cells")
        for a, b in zip(self.first_asset, self.first_asset[1:]):
            check(a <= b <= a + self.max_rocks_per_cell, "rocks of a cell")
        for kind in (LODS, BLOB_INDEX):
            check(self.elements(kind) == (self.asset_count + self.proxy_count) * self.lod_count, f"size of section {kind}")
        if self.models:
            check(self.elements(CONTACTS) == 0 and self.elements(MODELS) == self.asset_count, "sizes of the sections of models")
            check(self.elements(PARTS) >= 1, "size of the parts")
        if self.cliff:
            self.read_cliff()

    def read_cliff(self):
        times = self.elements(TIMES)
        check(times >= 1 and self.elements(UVS) == 1, "sizes of the sections of a cliff")
        check(list(self.first_asset) == [0, *range(times, times + self.cell_count)], "ages of a cliff and its blocks")
        *range_of_uvs, = struct.unpack("<4f", self.sections[UVS])
        self.uv_min, self.uv_max = range_of_uvs[:2], range_of_uvs[2:]
        check(all(-65536 <= low <= high <= 65536 for low, high in zip(self.uv_min, self.uv_max)), "range of the UVs")
        self.placements = list(struct.iter_unpack("<I3f", self.sections[PLACEMENTS]))
        for asset, *place in self.placements:
            check(times <= asset < self.asset_count, "a placement names no block")
            check(all(abs(t) <= self.reach for t in place), "place of a block")
        self.times, next_placement = [], 0
        for first, count, *bounds in struct.iter_unpack("<2I6f", self.sections[TIMES]):
            low, high = bounds[:3], bounds[3:]
            check(first == next_placement and first + count <= len(self.placements), "placements of a time")
            next_placement = first + count
            check(all(-4 * self.reach <= a <= b <= 4 * self.reach for a, b in zip(low, high)), "bounds of a time")
            check(count > 0 or bounds == [0] * 6, "bounds of a time without placements")
            places = [placement[1:] for placement in self.placements[first:next_placement]]
            check(all(a <= p <= b for place in places for a, p, b in zip(low, place, high)), "a block outside its bounds")
            codes = [place_code(place) for place in places]
            check(codes == sorted(codes), "order of placements")
            self.times.append((first, count, low, high))
        check(next_placement == len(self.placements), "placements of no time")

    def read_assets(self):
        names = "cell first_contact first_hull contact_count burial hull_count seed".split()
        self.assets = []
        for values in struct.iter_unpack("<IIIBBBB6h6f", self.sections[ASSETS]):
            asset = dict(zip(names, values[:7]))
            asset["bounds_min"], asset["bounds_max"] = values[7:10], values[10:13]
            asset["centroid"] = values[13:16]
            asset["volume"], asset["inner_radius"], asset["outer_radius"] = values[16:19]
            self.assets.append(asset)
        self.lods = list(struct.iter_unpack("<QIf", self.sections[LODS]))
        layout = "<3hBB" if self.element_size[CONTACTS] == 8 else "<3bBB"
        self.contacts = list(struct.iter_unpack(layout, self.sections[CONTACTS]))
        self.blob_index = list(struct.iter_unpack("<III", self.sections[BLOB_INDEX]))
        if self.models:
            self.part_first = struct.unpack(f"<{self.elements(PARTS)}I", self.sections[PARTS])
            self.model_records = list(struct.iter_unpack("<3f3I", self.sections[MODELS]))
        for number, asset in enumerate(self.assets):
            self.check_asset(number, asset)
            if self.models:
                self.check_model(number, asset)
        for number in range(self.asset_count + self.proxy_count):
            self.check_levels(number)

    def check_asset(self, number, asset):
        name = f"asset {number}: "
        check(asset["cell"] < self.cell_count, name + "cell")
        first = self.first_asset[asset["cell"]]
        check(first <= number < self.first_asset[asset["cell"] + 1], name + "cell of the section of cells")
        check(asset["seed"] < self.max_rocks_per_cell, name + "seed")
        check(number == first or asset["seed"] > self.assets[number - 1]["seed"], name + "order of seeds")
        check(asset["first_contact"] + asset["contact_count"] <= len(self.contacts), name + "contacts")
        check(1 <= asset["burial"] <= MAX_BURIAL, name + "burial")
        check(4 <= asset["hull_count"] <= 64, name + "hull count")
        check(asset["first_hull"] + asset["hull_count"] <= self.elements(HULLS), name + "hull")
        for low, high, centre in zip(asset["bounds_min"], asset["bounds_max"], asset["centroid"]):
            check(low <= high and abs(centre) <= self.reach, name + "bounds or centroid")
        check(0 <= asset["volume"] <= 8 * self.max_radius**3, name + "volume")
        check(0 < asset["outer_radius"] <= self.max_radius, name + "outer radius")
        check(0 <= asset["inner_radius"] <= asset["outer_radius"], name + "inner radius")
        previous = (-1, -1)
        for contact in self.contacts_of(asset):
            check(contact[3] < 27 and contact[4] < self.max_rocks_per_cell, name + "contact")
            check(previous < contact[3:5], name + "order of contacts")
            previous = contact[3:5]

    def check_model(self, number, asset):
        name = f"model {number}: "
        check(asset["burial"] == MAX_BURIAL, name + "burial")
        check(asset["seed"] == number - self.first_asset[asset["cell"]], name + "age")
        footprint, height, share, _, first, count = self.model_records[number]
        check(0 <= footprint <= self.reach and 0 <= height <= self.reach and 0 <= share <= 1, name + "sizes")
        check(1 <= count <= 255 and first + count < len(self.part_first), name + "parts")
        for part in range(first, first + count):
            begin, end = self.part_first[part : part + 2]
            check(4 <= end - begin <= 64 and end <= self.elements(HULLS), name + "a part")

    def check_levels(self, number):
        name = f"mesh {number}: "
        for lod in range(self.lod_count):
            digest, triangles, error = self.lods[number * self.lod_count + lod]
            offset, size, vertices = self.blob_index[number * self.lod_count + lod]
            check(4 * offset + size <= len(self.sections[BLOBS]), name + "blob")
            check(1 <= triangles <= 16 * size and vertices <= 3 * triangles, name + "triangles")
            check(0 <= error <= self.reach, name + "error")
            check(not self.models or vertices <= 65536, name + "vertices")
            blob = self.sections[BLOBS][4 * offset : 4 * offset + size]
            if lod + 1 == self.lod_count:
                self.check_plain_mesh(name, blob, vertices, triangles, digest)
            else:
                # Draco's own header: magic, version, geometry type (1 = mesh).
                check(blob[:8] == b"DRACO\x02\x02\x01", name + "no Draco bytes")

    def check_plain_mesh(self, name, blob, vertices, triangles, digest):
        check(vertices <= 65536 and len(blob) >= 8, name + "plain mesh")
        *base, position_size, index_size = struct.unpack_from("<3hBB", blob)
        check(position_size in (1, 2) and index_size in (1, 2), name + "widths of a plain mesh")
        extra = 4 * vertices if self.models else 0
        places = 2 * vertices if self.cliff else 0
        size = 8 + (3 * position_size + 1) * vertices + extra + 2 * places + 3 * index_size * triangles
        check(len(blob) == size, name + "size of a plain mesh")
        layout = f"<{3 * vertices}{'BH'[position_size - 1]}{vertices}B{extra}B{places}H{3 * triangles}{'BH'[index_size - 1]}"
        numbers = struct.unpack_from(layout, blob, 8)
        steps, occlusion = numbers[: 3 * vertices], numbers[3 * vertices : 4 * vertices]
        surface = [numbers[4 * vertices + i : 4 * vertices + i + 4] for i in range(0, extra, 4)] if self.models else None
        for bytes_of in surface or []:
            check(bytes_of[0] % 16 <= (2 if self.cliff else 1) and bytes_of[2] > 0, name + "surface of a plain mesh")
            check(self.cliff or bytes_of[3] == 0, name + "group of a plain mesh")
        uvs = [numbers[i : i + 2] for i in range(4 * vertices + extra, 4 * vertices + extra + places, 2)] if self.cliff else None
        corners = numbers[4 * vertices + extra + places :]
        positions = [tuple(b + s for b, s in zip(base, steps[i : i + 3])) for i in range(0, len(steps), 3)]
        check(all(max(p) < 32768 for p in positions), name + "positions of a plain mesh")
        check(max(corners) < vertices, name + "triangles of a plain mesh")
        mesh = [corners[i : i + 3] for i in range(0, len(corners), 3)]
        check(mesh_digest(positions, occlusion, mesh, surface, uvs) == digest, name + "digest of a plain mesh")
        return positions, surface, uvs, mesh

    def coarsest_of(self, number):
        """Positions, surface, UVs as they are stored, and triangles."""
        level = (number + 1) * self.lod_count - 1
        digest, triangles, _ = self.lods[level]
        offset, size, vertices = self.blob_index[level]
        blob = self.sections[BLOBS][4 * offset : 4 * offset + size]
        return self.check_plain_mesh(f"mesh {number}: ", blob, vertices, triangles, digest)

    def contacts_of(self, asset):
        return self.contacts[asset["first_contact"] : asset["first_contact"] + asset["contact_count"]]

    def hull_of(self, asset):
        size = self.element_size[HULLS]
        begin, end = size * asset["first_hull"], size * (asset["first_hull"] + asset["hull_count"])
        return list(struct.iter_unpack("<3h" if size == 6 else "<3b", self.sections[HULLS][begin:end]))

    def model_of(self, number, whole=False):
        footprint, height, share, steps, first, count = self.model_records[number]
        size = self.element_size[HULLS]
        parts = [
            list(struct.iter_unpack("<3h" if size == 6 else "<3b", self.sections[HULLS][size * begin : size * end]))
            for begin, end in zip(self.part_first[first : first + count], self.part_first[first + 1 : first + count + 1])
        ]
        asset = self.assets[number]
        return {
            "variant": asset["cell"], "age": asset["seed"], "steps": steps, "footprint": footprint, "height": height, "share": share,
            "parts": parts if whole else count
        }


def same(name, mine, theirs):
    """Numbers of scree-info are printed so that they read back as the same float."""
    if isinstance(mine, (list, tuple)):
        check(len(mine) == len(theirs), f"{name}: {len(mine)} values here, {len(theirs)} in scree-info")
        for i, (a, b) in enumerate(zip(mine, theirs)):
            same(f"{name}[{i}]", a, b)
    elif isinstance(mine, dict):
        check(mine.keys() == theirs.keys(), f"{name}: {sorted(mine)} here, {sorted(theirs)} in scree-info")
        for key in mine:
            same(f"{name}.{key}", mine[key], theirs[key])
    elif isinstance(mine, float):
        check(mine == struct.unpack("<f", struct.pack("<f", theirs))[0], f"{name}: {mine} here, {theirs} in scree-info")
    else:
        check(mine == theirs, f"{name}: {mine} here, {theirs} in scree-info")


def same_levels(name, pack, levels, theirs):
    blobs = [pack.blob_index[i] for i in levels]
    errors = sorted(pack.lods[i][2] for i in levels)
    same(name + ".triangles", sum(pack.lods[i][1] for i in levels), theirs["triangles"])
    same(name + ".vertices", sum(blob[2] for blob in blobs), theirs["vertices"])
    same(name + ".bytes", sum(blob[1] for blob in blobs), theirs["bytes"])
    same(name + ".error", errors[-1], theirs["error"])
    same(name + ".error_95", errors[(95 * len(errors) + 99) // 100 - 1], theirs["error_95"])


def compare(pack, info):
    for name in "format_version file_size cells_per_cube lattice_per_cell lod_count max_rocks_per_cell max_radius proxy_per_cell".split():
        same(name, getattr(pack, name), info[name])
    same("digest", f"{pack.digest:016x}", info["digest"])
    same("kind", "cliff" if pack.cliff else "models" if pack.models else "tiles", info["kind"])
    if pack.cliff:
        same("uv_min", pack.uv_min, info["uv_min"])
        same("uv_max", pack.uv_max, info["uv_max"])
        same("placements", len(pack.placements), info["placements"])
        same("times", len(pack.times), len(info["times"]))
        for number, ((first, count, low, high), theirs) in enumerate(zip(pack.times, info["times"])):
            share, paths = pack.model_records[number][2:4]
            mine = {"asset": number, "paths": paths, "share": share, "first_placement": first, "placements": count,
                    "bounds_min": low, "bounds_max": high}
            same(f"times[{number}]", mine, theirs)
    if pack.models:
        same("variants", pack.cell_count, info["variants"])
        same("models", pack.asset_count, len(info["models"]))
        for number, model in enumerate(info["models"]):
            same(f"models[{number}]", pack.model_of(number), {**model})
    same("cells", pack.cell_count, info["cells"])
    same("assets", pack.asset_count, info["assets"])
    same("recipe", json.dumps(pack.recipe, sort_keys=True), json.dumps(info["recipe"], sort_keys=True))
    for kind, name in enumerate(NAMES[: len(pack.kinds)], 1):
        same(f"sections.{name}", len(pack.sections[kind]), info["sections"][name])
    same("contacts", len(pack.contacts), info["contacts"])
    same("proxy_count", pack.proxy_count, info["proxy_count"])
    same("burial", [sum(asset["burial"] == b for asset in pack.assets) for b in range(1, MAX_BURIAL + 1)], info["burial"])
    for lod in range(pack.lod_count):
        rocks = range(lod, pack.asset_count * pack.lod_count, pack.lod_count)
        same_levels(f"lods[{lod}]", pack, rocks, info["lods"][lod])
        if pack.proxy_count:
            for kind, parts in (("whole", [0]), ("parts", range(1, 9))):
                proxies = [(pack.asset_count + 9 * code + part) * pack.lod_count + lod for code in range(256) for part in parts]
                same_levels(f"proxies.{kind}[{lod}]", pack, proxies, info["proxies"][kind][lod])
    check(len(info["examples"]) >= 1, "scree-info shows no examples")
    scale = lambda steps: [struct.unpack("<f", struct.pack("<f", v / pack.lattice_per_cell))[0] for v in steps]
    for example in info["examples"]:
        number = example["asset"]
        asset = pack.assets[number]
        name = f"examples[asset {number}]."
        for key in ("cell", "seed", "burial", "volume", "inner_radius", "outer_radius", "centroid"):
            same(name + key, asset[key], example[key])
        same(name + "bounds_min", scale(asset["bounds_min"]), example["bounds_min"])
        same(name + "bounds_max", scale(asset["bounds_max"]), example["bounds_max"])
        contacts = [[*c[:3], c[3] % 3 - 1, c[3] // 3 % 3 - 1, c[3] // 9 - 1, c[4]] for c in pack.contacts_of(asset)]
        same(name + "contacts", contacts, example["contacts"])
        same(name + "hull", pack.hull_of(asset), example["hull"])
        if pack.models:
            same(name + "model", pack.model_of(number, whole=True), example["model"])
        for lod, level in enumerate(example["lods"]):
            digest, triangles, error = pack.lods[number * pack.lod_count + lod]
            _, size, vertices = pack.blob_index[number * pack.lod_count + lod]
            same(name + "digest", f"{digest:016x}", level["digest"])
            same(name + "lod", [triangles, vertices, size], [level["triangles"], level["vertices"], level["bytes"]])
            same(name + "error", error, level["error"])


def main():
    arguments = sys.argv[1:]
    info_program = None
    if len(arguments) == 3 and arguments[1] == "--info":
        info_program = arguments[2]
    elif len(arguments) != 1:
        sys.exit(__doc__)
    path = arguments[0]
    try:
        corners = [(0, 0, 0), (10, 0, 0), (0, 10, 0), (0, 0, 10)]
        example = mesh_digest(corners, [0, 85, 170, 255], [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
        check(example == 0x87865A563AD6A90A, "the example of the digest of a mesh")
        surface = [(0, 64, 128, 0), (16, 0, 1, 0), (33, 255, 255, 0), (1, 128, 100, 0)]
        example = mesh_digest(corners, [0, 85, 170, 255], [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], surface)
        check(example == 0x90D6656EE2BD09DA, "the example of the digest of the mesh of a model")
        surface = [(0, 64, 128, 0), (16, 0, 1, 1), (33, 255, 255, 255), (2, 128, 100, 7)]
        uvs = [(0, 0), (65535, 1), (2, 65534), (32768, 100)]
        example = mesh_digest(corners, [0, 85, 170, 255], [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], surface, uvs)
        check(example == 0x9808A4C35F9C6008, "the example of the digest of the mesh of a cliff")
        with open(path, "rb") as file:
            pack = Pack(file.read())
        if info_program:
            output = subprocess.run([info_program, "--json", path], check=True, stdout=subprocess.PIPE).stdout
            compare(pack, json.loads(output))
    except (Corrupt, OSError) as fault:
        sys.exit(f"{path}: {fault}")
    volume = math.fsum(asset["volume"] for asset in pack.assets) / pack.asset_count
    print(f"{path}: {pack.asset_count} assets, digest {pack.digest:016x}, mean volume {volume:.3f} cubic cells")


if __name__ == "__main__":
    main()

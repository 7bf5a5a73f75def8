#!/usr/bin/env bash
# scree-scatter as people use it. Usage: test_scatter.sh BIN_FOLDER WORK_FOLDER
# Bakes small packs, scatters every shipped scene in both forms, holds the files against the glTF validator where it is installed, and
# checks that bad input gives status 2, one line that names what is wrong, and no file.
set -euo pipefail
export LC_ALL=C

BIN=$(cd "$1" && pwd)
WORK=$2
HERE=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
ROOT=$HERE/..
failures=0

fail() {
  printf 'FAILED: %s\n' "$*"
  failures=$((failures + 1))
}

rm -rf "$WORK"
mkdir -p "$WORK/packs" "$WORK/data" "$WORK/out"
cd "$WORK"

for recipe in "$ROOT"/content/recipes/*.json; do
  name=$(basename "$recipe" .json)
  grep -qs "\"pack\": \"$name\"" "$ROOT"/content/scenes/*.json || continue
  small=(--set n=4 --set voxels_per_cell=6 --set lod_levels=2 --set proxies=false)
  grep -q '"kind": "hoodoo"' "$recipe" && small=(--set variants=1 --set lod_levels=2)
  grep -q '"kind": "shards"' "$recipe" && small=(--set lod_levels=2)
  "$BIN/scree-bake" "$recipe" "${small[@]}" -q -o "packs/$name.scree"
done

# Meshes are read from the installed package; where one is missing, an octahedron stands in for it.
archive=/usr/share/doc/libcgal-dev/data.tar.gz
for mesh in bunny00.off man.off; do
  if [[ -f $archive ]] && tar -xzOf "$archive" data/meshes/$mesh >data/$mesh 2>/dev/null; then
    echo "$mesh: from libcgal-demo"
  else
    echo "$mesh: libcgal-demo is not installed, an octahedron instead"
    printf 'OFF\n6 8 0\n.5 0 0\n-.5 0 0\n0 .5 0\n0 -.5 0\n0 0 .5\n0 0 -.5\n' >data/$mesh
    printf '3 0 2 4\n3 2 1 4\n3 1 3 4\n3 3 0 4\n3 2 0 5\n3 1 2 5\n3 3 1 5\n3 0 3 5\n' >>data/$mesh
  fi
done

# How many rocks a scene has at least. Of the paper's scenes: as many as there.
declare -A least=([canyon]=25313 [zen_garden]=94658 [bories]=28032 [statue]=8000 [boulder_pile]=3000 [bunny]=6000
  [dry_stone_wall]=2500 [scree_slope]=20000 [goblin_valley]=12000 [hoodoos]=20
  [hill_cave]=20000 [four_times]=90 [basalt_wall]=18000 [tilted_slabs]=18000 [frost_hoodoo]=140 [ridge]=200)

# number FILE KEY: the first number of that key in a report.
number() { sed -nE "s/.*\"$2\": ([0-9.]+).*/\1/p" "$1" | head -1; }

for scene in "$ROOT"/content/scenes/*.json; do
  name=$(basename "$scene" .json)
  for format in instanced flat; do
    file=out/$name-$format.glb
    if ! "$BIN/scree-scatter" "$scene" -o "$file" --format $format --lod 1 --packs packs --data data --rocks all --report report.json >log 2>&1; then
      fail "$name $format: $(<log)"
      continue
    fi
    [[ ! -s log ]] || fail "$name $format: not silent when piped: $(<log)"
    [[ $(number report.json bytes) == $(stat -c %s "$file") ]] || fail "$name $format: the report has another size than the file"
    (($(number report.json instances) >= ${least[$name]:-1000000000})) || fail "$name $format: only $(number report.json instances) rocks"
    [[ -n $(number report.json seconds) && -n $(number report.json unique_meshes) ]] || fail "$name $format: report"
    python3 -c 'import json,sys; r=json.load(open(sys.argv[1])); sys.exit(sum(f["instances"] for f in r["fields"]) != r["instances"])' report.json ||
      fail "$name $format: the fields of the report do not add up"
    echo "$name $format: $(number report.json instances) rocks, $(number report.json unique_meshes) shapes, $(stat -c %s "$file") bytes"
  done
done

if command -v node >/dev/null; then
  node "$HERE/validate_gltf.js" out/*.glb || { (($? == 77)) || fail "the glTF validator found faults"; }
fi

"$BIN/scree-scatter" --version | grep -qE '^scree-scatter [0-9]+\.[0-9]+\.[0-9]+$' || fail "--version"
"$BIN/scree-scatter" --help | grep -q 'usage: scree-scatter' || fail "--help"

# refused WORDS ARGUMENTS...: status 2, one line with these words, and nothing new in the folder.
refused() {
  local words=$1 status=0
  shift
  rm -rf bad && mkdir bad
  "$BIN/scree-scatter" "$@" >bad.out 2>bad.err || status=$?
  ((status == 2)) || fail "$*: status $status instead of 2"
  [[ $(wc -l <bad.err) == 1 ]] || fail "$*: not one line: $(<bad.err)"
  grep -qF -- "$words" bad.err || fail "$*: '$words' is not in: $(<bad.err)"
  [[ -z $(ls -A bad) ]] || fail "$*: left behind $(ls -A bad)"
}

scene() { printf '{"fields": [{"pack": "%s", "cell_size": %s, "support": %s}]}\n' "$1" "$2" "$3" >scene.json; }
ball='{"shape": "sphere", "radius": 3}'
where=(-o bad/out.glb --packs packs --data data)

refused 'a scene is missing' -o bad/out.glb
refused '-o OUT.glb is missing' scene.json
refused 'unknown option --fast' scene.json --fast
refused 'a value is missing after --lod' scene.json "${where[@]}" --lod
refused '--lod: expected a whole number in 0..15, got "x"' scene.json "${where[@]}" --lod x
refused '--lod 2: the pack "boulders" has the levels 0..1' "$ROOT/content/scenes/boulder_pile.json" "${where[@]}" --lod 2
refused '--rocks: expected visible or all' scene.json "${where[@]}" --rocks some
refused '--format: expected instanced or flat' scene.json "${where[@]}" --format round
refused 'unexpected argument b.json' a.json b.json "${where[@]}"
refused 'gone.json: cannot open: No such file or directory' gone.json "${where[@]}"
echo '{"fields": [' >scene.json
refused 'scene.json: line 2, column 1: not valid JSON' scene.json "${where[@]}"
scene boulders '"a"' "$ball"
refused 'scene.json: fields[0].cell_size: expected a number > 0, got "a"' scene.json "${where[@]}"
scene quartz 0.5 "$ball"
refused 'scene.json: fields[0].pack: there is no pack "quartz": packs/quartz.scree does not exist' scene.json "${where[@]}"
head -c 5000 packs/boulders.scree >packs/cut.scree
scene cut 0.5 "$ball"
refused 'packs/cut.scree: file is truncated' scene.json "${where[@]}"
echo '# not a pack' >packs/text.scree
scene text 0.5 "$ball"
refused 'packs/text.scree: ' scene.json "${where[@]}"
scene boulders 0.5 '{"shape": "mesh", "file": "gone.off"}'
refused 'scene.json: fields[0].support: "gone.off" is neither beside the scene nor in the data folder data' scene.json "${where[@]}"
# A cube without its lid.
printf 'OFF\n8 5 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n' >open.off
printf '4 3 2 1 0\n4 4 5 6 7\n4 0 1 5 4\n4 0 4 7 3\n4 1 2 6 5\n' >>open.off
scene boulders 0.5 '{"shape": "union", "children": [{"shape": "box"}, {"shape": "mesh", "file": "open.off"}]}'
refused 'scene.json: fields[0].support.children[1]: open.off: ' scene.json "${where[@]}"
grep -qi 'edge' bad.err || fail "a mesh with a border: no edge is named: $(<bad.err)"
head -c 200 data/bunny00.off >cut.off
scene boulders 0.5 '{"shape": "union", "children": [{"shape": "sphere"}, {"shape": "mesh", "file": "cut.off"}]}'
refused 'scene.json: fields[0].support.children[1]: cut.off: line ' scene.json "${where[@]}"
scene boulders 0.5 "$ball"
scene boulders 0.01 '{"shape": "sphere", "radius": 1e5}'
refused 'fields[0]: it has more than 20000000 rocks; enlarge cell_size' scene.json "${where[@]}"
scene boulders 0.5 '{"shape": "half_space"}'
refused 'fields[0].support: it has no end; cut it to size with an intersection' scene.json "${where[@]}"
scene boulders 0.5 "$ball"
refused 'bad/no/out.glb: cannot write: No such file or directory' scene.json -o bad/no/out.glb --packs packs

# A report that cannot be written, and an output that is a folder.
scene boulders 0.5 "$ball"
refused 'bad/no/r.json: cannot write: No such file' scene.json -o report.glb --packs packs --report bad/no/r.json
refused 'out: is a directory' scene.json -o out --packs packs

# An older file is replaced only by a whole one.
echo 'older' >kept.glb
scene quartz 0.5 "$ball"
"$BIN/scree-scatter" scene.json -o kept.glb --packs packs 2>/dev/null && fail "a missing pack was no error"
[[ $(<kept.glb) == older ]] || fail "an older file was touched"

# Every truncation of a scene is refused: each gives status 2 and one line.
head -c 300 "$ROOT/content/scenes/bunny.json" >whole.json
for ((length = 0; length < 300; length += 13)); do
  head -c $length whole.json >scene.json
  refused 'scene.json: ' scene.json "${where[@]}"
done

if ((failures)); then
  printf '%d failures\n' "$failures"
  exit 1
fi
echo "all as it should be"

#!/bin/sh
# bench_size.sh SOURCE LIBRARY [NAME]: how large the core runtime is, one JSON object a line; for ./dev bench, which runs it as
# scree-bench-size. The code is what lies in the .text sections of all its objects, the decoder and the pool of threads not among
# them; a game that does not call everything links less. The constants are the .rodata sections.
#   runtime.code_kb        as shipped: LIBRARY
#   runtime.code_small_kb  the same sources as MinSizeRel, for those who need room more than speed
set -eu
source=$1 library=$2 prefix=${3:-}

wanted() { case $1 in "$prefix"*) ;; *) return 1 ;; esac }

print_size() {
  size -A "$2" | awk -v name="$1" '
    $1 ~ /^\.text/ { code += $2 }
    $1 ~ /^\.rodata/ { constants += $2 }
    END { printf "{\"name\": \"%s\", \"value\": %.1f, \"unit\": \"KiB\", \"constants_kb\": %.1f, \"goal\": 150}\n",
          name, code / 1024, constants / 1024 }'
}

if wanted runtime.code_kb; then print_size runtime.code_kb "$library"; fi
if wanted runtime.code_small_kb; then
  folder=$(mktemp -d)
  trap 'rm -rf "$folder"' EXIT
  cmake -S "$source" -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=MinSizeRel -DSCREE_TESTS=OFF -DSCREE_DEMO=OFF -DSCREE_BAKE=OFF \
    -DSCREE_DRACO=OFF >/dev/null
  cmake --build "$folder" --target scree_runtime >/dev/null
  print_size runtime.code_small_kb "$folder/runtime/libscree-runtime.a"
fi

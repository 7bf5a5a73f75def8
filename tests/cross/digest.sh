#!/bin/sh
# digest.sh WORK GOLDEN INPUTS COMPILER LEVEL KERNELS [RUNNER]
# Compiles digest_small with one compiler and optimisation level, runs it (RUNNER: an emulator for another CPU), and compares what
# it prints with the golden file. KERNELS: `wide` (chosen at run time) or `plain`. INPUTS is made by CMake: `flag F`,
# `include DIR`, `header FILE`, `source FILE`, one a line.
set -eu
work=$1 golden=$2 inputs=$3 compiler=$4 level=$5 kernels=$6 runner=${7:-}

rm -rf "$work"
mkdir -p "$work/include/cjson"
# Single headers: a cross compiler must not see the rest of /usr/include.
cp /usr/include/xxhash.h "$work/include/"
cp /usr/include/cjson/cJSON.h "$work/include/cjson/"

# Recipes in JSON are not read here, so that cJSON is left unresolved: a call to it would end the program.
flags="-std=c11 -Wno-psabi -I$work/include $(sed -n 's/^flag //p; s/^include /-I/p' "$inputs" | tr '\n' ' ')"
link="-static -Wl,--unresolved-symbols=ignore-in-object-files -pthread"
[ "$kernels" = plain ] || flags="$flags -DSCREE_WIDE_KERNELS"

sed -n 's/^source //p' "$inputs" | while IFS= read -r source; do
  extra=
  case $source in
    *_avx2.c)
      [ "$kernels" = wide ] || continue
      extra=-mavx2
      ;;
  esac
  # Names repeat between folders.
  # shellcheck disable=SC2086 # flags are words
  "$compiler" $flags $level $extra -c "$source" -o "$work/$(basename "$(dirname "$source")")-$(basename "$source").o"
done
# shellcheck disable=SC2086
"$compiler" $link "$work"/*.o -lm -o "$work/digest_small"

# shellcheck disable=SC2086
$runner "$work/digest_small" >"$work/digests.txt"
[ -z "${SCREE_UPDATE_GOLDEN:-}" ] || cp "$work/digests.txt" "$golden"
if ! cmp -s "$golden" "$work/digests.txt"; then
  echo "$compiler $level $kernels $runner: the digests are not those of $golden"
  diff "$golden" "$work/digests.txt" || true
  echo "if the bits were meant to change, the file is now:"
  cat "$work/digests.txt"
  exit 1
fi

#!/bin/sh
# bench_size.sh LIBRARY [NAME]: how large the core runtime is, as one JSON object; for ./dev bench, which runs it as scree-bench-size.
# The code is what lies in the .text sections of all its objects, the decoder and the pool of threads not among them; a game that
# does not call everything links less. The constants are the .rodata sections.
set -eu
name=runtime.code_kb
case $name in "${2:-}"*) ;; *) exit 0 ;; esac
size -A "$1" | awk -v name="$name" '
  $1 ~ /^\.text/ { code += $2 }
  $1 ~ /^\.rodata/ { constants += $2 }
  END { printf "{\"name\": \"%s\", \"value\": %.1f, \"unit\": \"KiB\", \"constants_kb\": %.1f, \"goal\": 150}\n",
        name, code / 1024, constants / 1024 }'

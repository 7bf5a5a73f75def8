#!/usr/bin/env bash
# House rules that a machine can hold: ./dev lint runs this. Prints one line per finding and ends with status 1 if there was any.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
export LC_ALL=C

findings=0
finding() {
  printf '%s\n' "$*"
  findings=$((findings + 1))
}

# finding_lines WHAT: each line of standard input is one finding.
finding_lines() {
  local line
  while IFS= read -r line; do finding "$1: $line"; done
}

# Files of ours that git knows or would add, by pathspec.
ours() { git ls-files --cached --others --exclude-standard -- "$@" | while IFS= read -r f; do [[ -f $f ]] && printf '%s\n' "$f"; done; }

mapfile -t c_sources < <(ours '*.c')
mapfile -t cxx_sources < <(ours '*.cpp')
mapfile -t headers < <(ours '*.h')
mapfile -t scripts < <(ours dev .ci/run '*.sh')
mapfile -t texts < <(ours '*.c' '*.cpp' '*.h' '*.sh' '*.py' '*.js' '*.mjs' '*.cmake' '*CMakeLists.txt' '*.json' '*.md' '*.glsl' '*.vert' '*.frag' dev .ci/run)
code=("${c_sources[@]}" "${cxx_sources[@]}" "${headers[@]}")

echo "-- formatting (clang-format, ${#code[@]} files)"
finding_lines format < <(clang-format --dry-run "${code[@]}" 2>&1 | grep -E 'warning:|error:' | sort -u || true)

echo "-- length"
for file in "${code[@]}" "${scripts[@]}"; do
  limit=800
  [[ $file == include/* ]] && limit=600
  lines=$(wc -l <"$file")
  ((lines <= limit)) || finding "length: $file has $lines lines, at most $limit"
done

echo "-- words that do not belong in a finished tree"
# The patterns are spelt so that this file does not match itself.
finding_lines "unfinished" < <(grep -nE '\b(TO''DO|FIX''ME|X''XX)\b' "${texts[@]}" || true)
finding_lines "absolute path" < <(grep -nE '(^|[^[:alnum:]._/-])/(wo''rk|ho''me|Use''rs|ro''ot)/' "${texts[@]}" || true)
finding_lines "trailing space" < <(grep -nE '[[:space:]]+$' "${texts[@]}" | cut -d: -f1,2 || true)

echo "-- folder rules"
while IFS= read -r included; do
  [[ -f include/scree/$included ]] || finding "include: a public header includes $included, which is not in include/scree/"
done < <(grep -hoE '^ *# *include *"[^"]+"' include/scree/*.h | sed -E 's/.*"(.*)"/\1/' | sort -u)
mapfile -t runtime < <(ours 'runtime/*.c' 'runtime/*.h' 'runtime/*.cpp')
finding_lines "runtime/ must not print" < <(grep -nE '^ *# *include *<(stdio\.h|iostream|fstream|cstdio)>' "${runtime[@]}" || true)
finding_lines "runtime/ must not see other folders" < <(grep -nE '^ *# *include *"(\.\./)*(bake|demo|tests)/' "${runtime[@]}" || true)
mapfile -t bake_headers < <(ours 'bake/*.h')
for header in "${bake_headers[@]}"; do
  name=${header##*/}
  [[ -f runtime/$name ]] && finding "names: $name is both in bake/ and in runtime/"
  finding_lines "runtime/ includes a header of bake/" < <(grep -nE "^ *# *include *[\"<]${name}[\">]" "${runtime[@]}" || true)
done
mapfile -t demo < <(ours 'demo/*.c' 'demo/*.h' 'demo/*.cpp')
if ((${#demo[@]})); then
  for file in runtime/*.h bake/*.h; do
    name=${file##*/}
    [[ -f demo/$name ]] && continue
    finding_lines "demo/ includes a private header" < <(grep -nE "^ *# *include *[\"<]([a-z.]+/)*${name}[\">]" "${demo[@]}" || true)
  done
fi
finding_lines "C++ outside the files that touch a C++ library" < <(ours '*.cc' '*.cxx' '*.hpp' '*.hh')

mapfile -t lists < <(ours '*CMakeLists.txt')
for source in "${c_sources[@]}" "${cxx_sources[@]}"; do
  grep -qE "(^|[^[:alnum:]_])${source##*/}([^[:alnum:]_]|\$)" "${lists[@]}" || finding "built by nobody: $source is in no CMakeLists.txt"
done

echo "-- links of the documents"
mapfile -t documents < <(ours '*.md')
while IFS=: read -r document link; do
  target=${link%%#*}
  [[ -z $target || $target == *://* || -e $(dirname "$document")/$target ]] || finding "link: $document points at $target, which is not there"
done < <(grep -oE '\]\([^)]+\)' "${documents[@]}" | sed -E 's/\]\((.*)\)/\1/')
while read -r size picture; do
  ((size <= 600000)) || finding "picture: $picture has $size bytes, at most 600000"
done < <(ours 'docs/*.png' | xargs -r stat -c '%s %n')

echo "-- JSON and schemas"
finding_lines json < <(ours '*.json' | /usr/bin/python3 tests/check_json.py || true)

echo "-- scripts (shellcheck)"
finding_lines shellcheck < <(shellcheck -f gcc "${scripts[@]}" || true)

echo "-- static checks (cppcheck, ${#c_sources[@]} C files)"
# A modest fixed set. Suppressed: what cppcheck cannot know (system headers), vectors that are filled lane by lane, zerodivcond,
# which cannot follow a loop that divides down to one, legacyUninitvar, which stumbles over compound literals, and the advice to use
# readdir_r, which is out of date.
finding_lines cppcheck < <(cppcheck --quiet --std=c11 --language=c -j "$(nproc)" --enable=warning,portability,performance \
  --inline-suppr --suppress=missingIncludeSystem --suppress='*:/usr/include/*' \
  --suppress=zerodivcond --suppress=legacyUninitvar --suppress=readdirCalled --library=posix -D__GNUC__=12 -D__x86_64__ \
  -Iinclude -Iruntime -Ibake \
  --template='{file}:{line}: {severity}: {message} [{id}]' "${c_sources[@]}" 2>&1 || true)

if ((findings)); then
  printf '\nlint: %d findings\n' "$findings"
  exit 1
fi
printf '\nlint: no findings\n'

# shellcheck shell=bash
# For the tests of scree-view, which source it: facts, counted in `failures`. Needs `bin`, the folder of the programs.
# shellcheck disable=SC2154
failures=0
fact() { # fact TEXT COMMAND...: the command must succeed
  local text=$1
  shift
  if "$@"; then
    printf 'ok      %s\n' "$text"
  else
    printf 'FAILED  %s\n' "$text"
    failures=$((failures + 1))
  fi
}

# refuses STATUS WORDS ARGUMENT...: ends with that status, one line on stderr that holds the words, nothing left behind.
refuses() {
  local status=$1 words=$2 got=0
  shift 2
  "$bin/scree-view" "$@" >out.txt 2>err.txt || got=$?
  [[ $got == "$status" && $(wc -l <err.txt) == 1 && ! -s out.txt && ! -e x.png ]] && grep -qF -- "$words" err.txt && return 0
  printf '        status %s, said: %s\n' "$got" "$(head -c 300 err.txt)"
  return 1
}

differ() { ! cmp -s "$1" "$2"; }

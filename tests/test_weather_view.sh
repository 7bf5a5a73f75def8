#!/usr/bin/env bash
# scree-view over a recipe of a hoodoo, as people run it: arguments, pictures without a display, and its window under Xvfb.
#   test_weather_view.sh BIN WORK (arguments|pictures|window)
# Ends with status 77 when the machine lacks what a part needs.
# shellcheck disable=SC2317 # functions are called by way of fact
set -euo pipefail
bin=$1 work=$2 part=$3
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
rm -rf "$work" && mkdir -p "$work" && cd "$work"
export LC_ALL=C

# shellcheck source=tests/view_facts.sh
source "$here/view_facts.sh"

cat >small.json <<'JSON'
{"kind": "hoodoo", "name": "small one", "voxel": 0.125, "size": [40, 28, 40],
 "start": {"shape": "column", "radius": 11, "lobes": 1},
 "durability": [[0, 1.4], [0.4, 0.5], [0.7, 1.6], [1, 1]], "bubbles": [{"radius": 3}], "steps_per_voxel": 14,
 "colluvium": {"share": 0.35, "durability": 0.6, "repose": 0.7}, "variants": 2, "ages": [0.97, 0.05]}
JSON

draw() { # draw FILE ARGUMENT...
  local file=$1
  shift
  "$bin/scree-view" small.json --headless --screenshot "$file" --size 160x120 --samples 2 "$@"
}

case $part in
  arguments)
    help() { "$bin/scree-view" --help >help.txt && grep -q -- '--weather FILE' help.txt && grep -q 'keep this age' help.txt; }
    fact help_names_options_and_keys help
    fact missing_recipe_is_named refuses 2 'nowhere.json' --weather nowhere.json --headless --screenshot x.png
    printf '{"kind": "hoodoo", "colluvium": {"share": 2}}' >wrong.json
    fact wrong_key_is_named_with_its_file refuses 2 'wrong.json: colluvium.share' wrong.json --headless --screenshot x.png
    fact variant_has_a_range refuses 2 'small.json: variants' small.json --variant 2 --headless --screenshot x.png
    fact steps_have_a_range refuses 2 '--steps' small.json --steps 1000001 --headless --screenshot x.png
    fact recipes_have_no_tiles refuses 2 'durability' small.json --colour tile --headless --screenshot x.png
    printf '{"fields": []}' >scene.json
    fact scenes_have_no_curvature refuses 2 'scene.json' scene.json --colour curvature --headless --screenshot x.png
    fact scenes_have_no_steps refuses 2 '--steps' scene.json --steps 3 --headless --screenshot x.png
    fact a_scene_is_no_recipe refuses 2 'scene.json' --weather scene.json --headless --screenshot x.png
    fact one_of_both refuses 2 'scene.json' scene.json --weather small.json --headless --screenshot x.png
    unset DISPLAY WAYLAND_DISPLAY
    fact window_without_display_is_refused refuses 1 "no window" small.json
    ;;
  pictures)
    if ! draw a.png --steps 12 --log log.txt 2>err.txt; then
      grep -q 'no OpenGL' err.txt && echo "SKIPPED: $(cat err.txt)" && exit 77
      cat err.txt
      exit 1
    fi
    fact picture_is_a_png_of_the_size_asked_for test "$(head -c 24 a.png | od -An -tx1 | tr -d ' \n')" = \
      89504e470d0a1a0a0000000d49484452000000a000000078
    fact log_tells_the_step grep -qE '^picture step=12 rock=[1-9][0-9]* .* digest=[0-9a-f]{16}$' log.txt
    draw b.png --steps 12
    fact same_recipe_gives_the_same_bytes cmp a.png b.png
    draw plain.png --steps 12 --no-indirect
    fact opengl_33_path_gives_the_same_bytes cmp a.png plain.png
    for how in '--steps 0' '--steps 40' '--steps 12 --variant 1' '--steps 12 --colour durability' '--steps 12 --colour curvature' \
      '--steps 12 --wireframe' '--steps 12 --camera 5,2,5,0,1,0,40'; do
      # shellcheck disable=SC2086 # words on purpose
      draw other.png $how
      fact "picture_differs_with_${how// /_}" differ a.png other.png
    done
    "$bin/scree-view" --weather small.json --headless --screenshot c.png --size 160x120 --samples 2 --steps 12
    fact weather_option_is_the_same cmp a.png c.png
    ;;
  window)
    for tool in xvfb-run xdotool; do
      command -v "$tool" >/dev/null || { echo "SKIPPED: no $tool here" && exit 77; }
    done
    cp small.json edited.json
    # Lines of the log come through a pipe: each step waits for what the one before it caused.
    mkfifo log
    # shellcheck disable=SC2016 # expanded by the inner shell
    drive='
      bin=$1
      exec 3<>log
      "$bin/scree-view" edited.json --size 640x480 --samples 2 --log log --screenshot key.png 2>err.txt &
      viewer=$!
      wait_for() { # wait_for WORDS: the next line that begins with them, as $line
        while read -r -t 60 line <&3; do
          case $line in "$1"*) echo "$line" && return 0 ;; esac
        done
        echo "no line: $1"
        kill "$viewer"
        exit 1
      }
      wait_for "open step=0"
      wait_for "graph"
      read -r _ x0 y0 x1 y1 <<<"$line"
      wait_for "still"
      xdotool key space
      wait_for "step step=8"
      xdotool key space
      wait_for "still"
      # The point at altitude 0.4 and durability 0.5, where the graph goes from 0.1 to 10; to the right is more durable.
      x=$((x0 + (x1 - x0) * 349 / 1000)) y=$((y1 - (y1 - y0) * 4 / 10))
      xdotool mousemove "$x" "$y" mousedown 1
      wait_for "held"
      xdotool mousemove $((x + 20)) "$y"
      wait_for "edit"
      xdotool mousemove $((x + 60)) $((y + 4))
      wait_for "edit"
      xdotool mouseup 1
      wait_for "rules step="
      xdotool key Delete
      wait_for "rules step="
      xdotool key k
      wait_for "age kept"
      for i in 1 2 3; do
        xdotool key Right
        wait_for "step step="
      done
      xdotool key Left
      wait_for "go step="
      xdotool key p
      wait_for "picture key.png"
      xdotool key e
      wait_for "exported"
      xdotool key ctrl+s
      wait_for "saved edited.json"
      xdotool key BackSpace
      wait_for "go step=0"
      xdotool key Next
      xdotool key Prior
      wait_for "variant step=0 variant=1"
      xdotool key ctrl+q
      wait "$viewer"
      echo "ended $?"
    '
    xvfb-run -a -s '-screen 0 640x480x24' bash -c "$drive" drive "$bin" >steps.txt 2>&1 || true
    cat steps.txt
    fact window_opens_and_ends_well grep -qx 'ended 0' steps.txt
    [[ -s err.txt ]] && cat err.txt
    fact nothing_is_complained_about test ! -s err.txt
    digest() { grep "^$1" steps.txt | sed 's/.*digest=//'; }
    step() { grep "^$1" steps.txt | head -n 1 | sed 's/.*step=\([0-9]*\).*/\1/'; }
    fact a_drag_changes_no_rock test "$(step 'rules')" -ge 8
    phase() { grep -q "\"phases\": \[{\"steps\": $(step 'rules'), \"durability\": \[\[0, 1.4, [^]]*\], \[0.7, 1.6, [^]]*\], \[1, 1, [^]]*\]\]" edited.json; }
    fact changes_by_hand_are_a_phase_of_the_saved_recipe phase
    fact the_recipe_has_one_age_more test "$(grep -c '"ages": \[[^,]*, [^,]*, [^,]*\]' edited.json)" = 1
    last=$(step 'go step=[1-9]')
    draw_of() { "$bin/scree-view" "$1" --headless --screenshot d.png --size 64x64 --samples 1 --steps "$last" --log - | sed 's/.*digest=//'; }
    fact the_saved_recipe_gives_what_was_seen test "$(draw_of edited.json)" = "$(digest 'go step=[1-9]')"
    fact the_old_recipe_gives_another test "$(draw_of small.json)" != "$(digest 'go step=[1-9]')"
    fact the_start_is_the_start_again test "$(digest 'go step=0 ')" = "$(digest 'open')"
    fact picture_of_key_p_is_there test -s key.png
    glb() { test "$(head -c 4 "small_one-0-$last.glb")" = glTF; }
    fact surface_of_key_e_is_there glb
    fact nothing_is_left_beside_the_recipe test -z "$(find . -name 'edited.json?*' -o -name '*.tmp*')"
    ;;
esac
exit $((failures > 0))

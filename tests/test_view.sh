#!/usr/bin/env bash
# scree-view as people run it: arguments, pictures without a display, and its window under Xvfb.
#   test_view.sh BIN RECIPE WORK (arguments|pictures|window)
# Ends with status 77 when the machine lacks what a part needs.
# shellcheck disable=SC2317 # functions are called by way of fact
set -euo pipefail
bin=$1 recipe=$2 work=$3 part=$4
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
rm -rf "$work" && mkdir -p "$work" && cd "$work"
export LC_ALL=C

# shellcheck source=tests/view_facts.sh
source "$here/view_facts.sh"

cat >scene.json <<'JSON'
{
  "camera": {"eye": [4, 3, 6], "target": [0, 0.8, 0], "fov": 40},
  "fields": [{"pack": "small", "seed": 3, "cell_size": 0.6,
              "support": {"shape": "sphere", "radius": 1.7, "position": [0, 0.6, 0]}}]
}
JSON

bake() { "$bin/scree-bake" "$recipe" --set n=4 --set voxels_per_cell=6 --set random_seed=5 --set proxies=false -q -o small.scree; }

draw() { # draw FILE ARGUMENT...
  local file=$1
  shift
  "$bin/scree-view" scene.json --packs . --headless --screenshot "$file" --size 160x120 --samples 2 "$@"
}

case $part in
  arguments)
    help() { "$bin/scree-view" --help >help.txt && grep -q 'Usage: scree-view SCENE.json' help.txt && grep -q orbit help.txt; }
    fact help_names_options_and_keys help
    version() { "$bin/scree-view" --version >version.txt && grep -qE '^scree-view [0-9]+\.[0-9]+\.[0-9]+$' version.txt; }
    fact version_is_three_numbers version
    fact scene_is_needed refuses 2 'no scene'
    fact one_scene_only refuses 2 'b.json' a.json b.json
    fact unknown_option_is_named refuses 2 '--frobnicate' scene.json --frobnicate
    fact option_without_value_is_named refuses 2 '--size' scene.json --size
    fact headless_needs_a_file refuses 2 '--headless' scene.json --headless
    for bad in 1280 12x0 x720 1280x720x1 99999x9; do
      fact "size_${bad}_is_refused" refuses 2 "$bad" scene.json --headless --screenshot x.png --size "$bad"
    done
    for bad in 1,2,3 1,2,3,4,5,x 1,1,1,1,1,1; do
      fact "camera_${bad}_is_refused" refuses 2 "$bad" scene.json --headless --screenshot x.png --camera "$bad"
    done
    fact samples_have_a_range refuses 2 '--samples' scene.json --headless --screenshot x.png --samples 0
    fact lod_has_a_range refuses 2 '--lod' scene.json --headless --screenshot x.png --lod 6
    fact pixel_error_has_a_range refuses 2 '--pixel-error' scene.json --headless --screenshot x.png --pixel-error nan
    fact colour_is_a_word refuses 2 'pink' scene.json --headless --screenshot x.png --colour pink
    fact rocks_are_all_or_visible refuses 2 'some' scene.json --headless --screenshot x.png --rocks some
    fact missing_scene_is_named refuses 2 'nowhere.json' nowhere.json --headless --screenshot x.png
    unset DISPLAY WAYLAND_DISPLAY
    fact window_without_display_is_refused refuses 1 "no window" scene.json
    printf '{"fields": [{"pack": 3}]}' >wrong.json
    fact wrong_type_is_named refuses 2 'fields[0].pack' wrong.json --headless --screenshot x.png
    ;;
  pictures)
    bake
    if ! draw a.png --log log.txt 2>err.txt; then
      grep -q 'no OpenGL' err.txt && echo "SKIPPED: $(cat err.txt)" && exit 77
      cat err.txt
      exit 1
    fi
    fact picture_is_a_png_of_the_size_asked_for test "$(head -c 24 a.png | od -An -tx1 | tr -d ' \n')" = \
      89504e470d0a1a0a0000000d49484452000000a000000078
    fact log_counts_stones grep -qE '^picture instances=[1-9][0-9]+ ' log.txt
    draw b.png
    fact same_scene_gives_the_same_bytes cmp a.png b.png
    draw plain.png --no-indirect
    fact opengl_33_path_gives_the_same_bytes cmp a.png plain.png
    for how in '--colour lod' '--colour tile' '--wireframe' '--lod 3' '--camera 5,2,5,0,0.8,0,40'; do
      # shellcheck disable=SC2086 # two words on purpose
      draw other.png $how
      fact "picture_differs_with_${how// /_}" differ a.png other.png
    done
    # A pile, a wall and a smaller pile. What is left out is what no line of a sample of thousands sees (bake/burial.c): so may the pictures
    # differ, in one pixel of ten thousand over all views.
    cat >pile.json <<'JSON'
{"camera": {"eye": [9, 6, 9], "target": [0, 1, 0]},
 "fields": [{"pack": "small", "seed": 3, "cell_size": 0.16, "shell": false,
             "support": {"shape": "intersection", "children": [
               {"shape": "smooth_union", "blend": 1, "children": [
                 {"shape": "cone", "radius": 4.5, "height": 4}, {"shape": "box", "position": [3, 1, 0], "half": [3, 1.5, 0.9]}]},
               {"shape": "box", "position": [0, 5, 0], "half": [9, 5, 9]}]}},
            {"pack": "small", "seed": 8, "cell_size": 0.3, "shell": false,
             "support": {"shape": "sphere", "position": [-3.5, 0.5, 1], "radius": 1.6}}]}
JSON
    drawn() { sed -n 's/^picture instances=\([0-9]*\).*/\1/p' "$1"; }
    differing=0 pixels=0
    for view in 9,6,9,0,1,0,40 -8,3,5,0,1,0,40 0.5,14,0.5,0,0,0,35 5,0.6,4,2,0.8,0,60 -6,1,-3,-3,0.5,1,50 0,2,-9,0,1,0,30; do
      for which in all visible; do
        "$bin/scree-view" pile.json --packs . --headless --screenshot $which.png --size 320x240 --samples 1 --rocks $which \
          "--camera=$view" --log $which.log
      done
      read -r some every < <(python3 "$here/picture_difference.py" all.png visible.png)
      differing=$((differing + some)) pixels=$((pixels + every))
      printf '        %s of %s pixels differ from %s\n' "$some" "$every" "$view"
    done
    printf '        %s of %s rocks are drawn, %s of %s pixels differ\n' "$(drawn visible.log)" "$(drawn all.log)" $differing $pixels
    fact rocks_that_are_left_out_are_hardly_seen test $((10000 * differing)) -le $pixels
    fact hidden_rocks_are_left_out test $((20 * $(drawn visible.log))) -lt $((19 * $(drawn all.log)))
    fact missing_pack_is_named refuses 2 'small' scene.json --packs elsewhere --headless --screenshot x.png
    head -c 2000 small.scree >short.scree
    sed 's/"small"/"short"/' scene.json >short.json
    fact truncated_pack_is_named refuses 2 'short.scree' short.json --packs . --headless --screenshot x.png
    fact unwritable_picture_is_named refuses 2 'no/such/x.png' scene.json --packs . --headless --screenshot no/such/x.png
    fact unwritable_log_is_named refuses 2 'no/such/x.log' scene.json --packs . --headless --screenshot x.png --log no/such/x.log
    sed 's/"cell_size": 0.6/"cell_size": 0.0001, "shell": false/' scene.json >huge.json
    fact too_many_stones_are_refused refuses 2 'cell_size' huge.json --packs . --headless --screenshot x.png
    ;;
  window)
    for tool in xvfb-run xdotool; do
      command -v "$tool" >/dev/null || { echo "SKIPPED: no $tool here" && exit 77; }
    done
    bake
    cp scene.json edited.json
    # Lines of the log come through a pipe: each step waits for what the one before it caused.
    mkfifo log
    # shellcheck disable=SC2016 # expanded by the inner shell
    drive='
      bin=$1
      exec 3<>log
      "$bin/scree-view" edited.json --packs . --size 480x360 --samples 2 --no-panel --log log --screenshot key.png 2>err.txt &
      viewer=$!
      wait_for() { # wait_for WORDS: the next line that begins with them, as $line
        while read -r -t 100 line <&3; do
          case $line in "$1"*) echo "$line" && return 0 ;; esac
        done
        echo "no line: $1"
        kill "$viewer"
        exit 1
      }
      wait_for "open field=0"
      wait_for "still"
      xdotool mousemove 240 170 mousedown 1
      wait_for "select field=0"
      xdotool mousemove 270 190
      wait_for "query field=0"
      xdotool mousemove 330 230
      wait_for "query field=0"
      xdotool mouseup 1
      wait_for "still"
      xdotool key p
      wait_for "picture key.png"
      xdotool key ctrl+s
      wait_for "saved edited.json"
      xdotool key ctrl+q
      wait "$viewer"
      echo "ended $?"
    '
    xvfb-run -a -s '-screen 0 640x480x24' bash -c "$drive" drive "$bin" >steps.txt 2>&1 || true
    cat steps.txt
    fact window_opens_and_ends_well grep -qx 'ended 0' steps.txt
    stones() { grep "^$1" steps.txt | tail -n 1 | sed 's/.*instances=\([0-9]*\).*/\1/'; }
    fact stones_follow_the_drag test "$(stones open)" != "$(stones query)"
    fact picture_of_key_p_is_there test -s key.png
    fact moved_support_is_saved differ scene.json edited.json
    moved() { grep -A2 '"shape": "sphere"' edited.json | grep -q '"position"' && ! grep -q '"position": \[0, 0.6, 0\]' edited.json; }
    fact saved_position_is_another moved
    fact nothing_is_left_beside_the_scene test -z "$(find . -name 'edited.json?*' -o -name '*.tmp*')"
    ;;
esac
exit $((failures > 0))

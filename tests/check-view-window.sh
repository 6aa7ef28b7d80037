#!/bin/bash
# SPDX-License-Identifier: MIT
# Runs iblview in a window as a user would, on a display of its own: keys,
# mouse, wheel, another size, files that are dropped, and the ways out. What the
# window shows must be what --offscreen writes. BUILD names the build.
set -u
. tests/lib.sh
[ -x "$build/iblview" ] || skip_all 'iblview was not built'
need Xvfb xdotool
server='' viewer=''
tidy() {
    [ -z "$viewer" ] || kill -KILL "$viewer" 2>/dev/null
    [ -z "$server" ] || kill "$server" 2>/dev/null
    wait
    rm -rf "$work"
}
trap tidy EXIT
mkdir "$work/bin" "$work/screen"
for tool in mkenv shown desktop; do
    ${CC:-cc} -std=c11 -D_XOPEN_SOURCE=700 -Itests -o "$work/bin/$tool" \
        "tests/cli/$tool.c" tests/float_exr.c -lm -lpng -lX11 2>"$work/err" || {
        cat "$work/err"
        skip_all "tests/cli/$tool.c does not compile (package libx11-dev?)"
    }
done
ln -s "$build/iblview" "$build/iblbake" "$work/bin"
export PATH=$work/bin:$PATH
cd "$work" || exit 1
# Drivers leak, and are gone when the leak sanitizer wants their names. They
# allocate so much that to know where costs a third of the time.
ASAN_OPTIONS=${ASAN_OPTIONS:+$ASAN_OPTIONS:}detect_leaks=0
export ASAN_OPTIONS=$ASAN_OPTIONS:malloc_context_size=1

# ---- a display -------------------------------------------------------------
# start_server [arguments]: sets DISPLAY.
start_server() {
    : >display
    # -r: keys that are down do not repeat, however late they come up.
    Xvfb -displayfd 3 -screen 0 800x600x24 -dpi 96 -noreset -nolisten tcp -r \
        "$@" 3>display 2>server.log &
    server=$!
    within grep -q . display || { cat server.log; skip_all 'Xvfb does not start'; }
    DISPLAY=:$(cat display)
    export DISPLAY
}
stop_server() {
    kill "$server"
    wait "$server" 2>/dev/null
    server=
}

# ---- the window ------------------------------------------------------------
# A window that goes away while it is looked at is an error of xdotool.
find_window() {
    window=$(xdotool search --onlyvisible --pid "$viewer" | head -n 1)
    [ -n "$window" ]
}
# open [arguments]: sets viewer and window; its words go to `said`. The hint at
# the keys goes with any key.
open() {
    : >said # which is emptied between, so it is added to
    iblview --size 320x240 "$@" 2>>said >printed &
    viewer=$!
    within find_window || { echo "wanted a window, found: $(cat said)"; return 1; }
    [ "${hint:-}" = kept ] || press Escape
}
# ended: the viewer has; sets status.
gone() { ! kill -0 "$viewer" 2>/dev/null; }
ended() {
    within gone || { echo 'wanted an end, found it running'; kill -KILL "$viewer"; }
    wait "$viewer"
    status=$?
    viewer=
    # The key that ended it was not released in it, and would stay down.
    xdotool keyup q keyup Escape
}
quits() {
    press q
    ended
    is 0 $status "$(cat said): status"
}
title() { xdotool getwindowname "$window"; }
titled() { [[ $(title) == *"$1"* ]]; }
# shows TEXT: the title comes to say so.
shows() { within titled "$1" || is "$1" "$(title)" title; }
# away: the pointer is in the window and leaves it, also after a drop there.
away() {
    xdotool mousemove --window "$window" 9 9
    xdotool mousemove 780 580
}
# After the last key of a window there is none to be released in.
press() { xdotool key --window "$window" --delay 30 "$@" 2>/dev/null; }
# snap FILE: what the viewer itself makes of its picture. The next key takes
# the notice about it away.
snap() {
    rm -f iblview-*.png
    press P
    within test -e iblview-001.png || { there iblview-001.png; return; }
    mv iblview-001.png "$1"
    press Escape
}
# still FILE [arguments]: the same without a window.
still() {
    local file=$1
    shift
    iblview -q --offscreen "$file" "$@" 2>err || is 0 $? "$(cat err): status"
}
# on_screen FILE: the display has these pixels where the window is.
as_shown() {
    # shellcheck disable=SC2034
    local X Y WINDOW WIDTH HEIGHT SCREEN
    eval "$(xdotool getwindowgeometry --shell "$window")"
    differing=$(shown screen/Xvfb_screen0 "$X" "$Y" "$1") &&
        [ "$differing" = 0 ]
}
on_screen() {
    within as_shown "$1" || echo "wanted $1 on the screen, found $differing other pixels"
}
not_shown() { ! as_shown "$1"; }
changes() { # PICTURE WHAT: which then shows
    within not_shown "$1" || echo "wanted $2 on the screen, found $1"
}

# ---- what is shown ---------------------------------------------------------
mkenv exr 64 32 BGR >env.exr
mkenv hdr 64 32 >sun.hdr
baked() { # MAP
    cp "$1" map"${1#*.}" &&
        iblbake -q "$1" -o baked --name env --size 64 --irradiance-size 16 \
            --lut-size 32 2>/dev/null || is 0 $? "bake of $1: status"
}

test_opens_and_equals_offscreen() {
    still off.png --size 320x240 baked
    hint=kept open baked || return
    shows 'env | '
    changes off.png 'how to see the keys'
    press Escape
    is 320x240 "$(xdotool getwindowgeometry "$window" | grep -o '[0-9]*x[0-9]*')"
    on_screen off.png
    snap first.png
    same first.png off.png
}

# Keys and the mouse, as xdotool has them, make the picture of options. 60 of
# the 218 pixels that labels leave are 60/218 of half a turn.
test_states() {
    local acts options
    while IFS='|' read -r acts options; do
        eval "xdotool mousemove --window $window 100 100 $acts"
        snap state.png
        eval "still off.png --size 320x240 $options baked"
        same state.png off.png "$acts"
        press Home
    done <<'END'
key t key m key bracketright|--tone agx --mode levels --level 1
mousedown 3 mousemove_relative 109 0 mouseup 3|--turn 90
mousedown 1 mousemove_relative 20 0 mousemove_relative 20 0 mousemove_relative 20 0 mouseup 1 mousemove_relative 30 30|--yaw -49.541284403669728
END
    xdotool click 4
    snap near.png
    differ near.png first.png 'after the wheel'
    press Home
    snap again.png
    same again.png first.png 'after Home'
}

# No picture is written over another one.
test_pictures_are_kept() {
    touch iblview-{001..999}.png
    press P
    away
    changes first.png 'a word of all the pictures'
    find . -name 'iblview-*.png' -size +0
    absent iblview-1000.png
    rm iblview-*.png
    press Escape
    on_screen first.png
}

test_texel_under_the_pointer() {
    press m
    xdotool mousemove --window "$window" 160 120
    snap level.png
    changes level.png 'a texel read out'
    away
    on_screen level.png
    press Home Escape
}

# It takes the pointer: a drag over it turns nothing, and its button "Keys"
# shows the list, which the first Escape takes away.
test_panel() {
    press p
    xdotool mousemove --window "$window" 270 120 sleep 1 mousedown 1 \
        mousemove_relative 0 60 mouseup 1
    xdotool mousemove --window "$window" 270 18 sleep 1 click 1 sleep 1
    away
    press Escape
    changes first.png 'keys'
    press Escape
    on_screen first.png
}

# Another size, and back; hidden, and shown.
test_resize() {
    xdotool windowsize --sync "$window" 400 300
    still off.png --size 400x300 baked
    away
    on_screen off.png
    snap larger.png
    same larger.png off.png
    xdotool windowsize --sync "$window" 320 240
    on_screen first.png
    xdotool windowunmap --sync "$window"
    xdotool windowmap --sync "$window"
    on_screen first.png
}

test_drop() {
    cp env.exr 'dropped map.exr'
    works desktop "$window" drop "file://$work/dropped%20map.exr"
    shows 'dropped map | '
    still dropped.png --size 320x240 'dropped map.exr'
    away
    on_screen dropped.png
    desktop "$window" drop "file://$work/baked"
    shows 'env | '
    # What is dropped last is what stays, however long the other takes.
    mkenv hdr 4096 2048 >large.hdr
    desktop "$window" drop "file://$work/large.hdr"
    desktop "$window" drop "file://$work/baked"
    sleep 2
    rm large.hdr
    shows 'env | '
}

test_quit() {
    quits
    open baked || return
    shows 'env | '
    press Escape Escape
    sleep 0.3
    ! gone || echo 'wanted Escape to close, found an end'
    desktop "$window" close
    ended
    is 0 $status "closed: status ($(cat said))"
    lines 0 said
}

# Baked probes: one, and what is around it.
two() {
    [ ! -d two ] || return
    cat >two.json <<'END'
{"version": 1, "defaults": {"size": 16}, "global":
 {"capture": {"equirect": "sun.hdr"}}, "probes": [{"name": "a", "position":
 [0, 1, 0], "capture": {"equirect": "env.exr"}, "influence":
 {"box": {"centre": [0, 1, 0], "half": [3, 3, 3]}}}]}
END
    iblbake probes -q two.json -o two
}
# Of the scene; what is dropped there takes their place, but not what is broken.
test_baked_probes() {
    two
    open baked --mode scene --probe-size 16 --probe-set two/index.json || return
    shows 'env | '
    mkdir bad
    echo '{' >bad/index.json
    : >said
    desktop "$window" drop "file://$work/bad/index.json"
    within grep -q 'bad/index.json:.*no JSON' said || has 'bad/index.json:.*no JSON' said
    desktop "$window" drop "file://$work/two/index.json"
    shows 'env | '
    quits
}

# A key shows the next layer, up to the last.
test_arrays() {
    two
    still second.png --size 320x240 two --array-layer 1
    open two || return
    press a
    on_screen second.png
    press a
    within grep -q 'has no layer 2' said || has 'has no layer 2' said
    press Escape
    on_screen second.png
    press A
    changes second.png 'the first'
    quits
}

# Maps of a folder, by arrows, are baked beside the window; it can be closed
# meanwhile.
test_maps_of_a_folder() {
    mkdir folder
    cp env.exr folder/a.exr
    cp sun.hdr folder/b.hdr
    open folder/b.hdr || return
    shows 'b | '
    press Next
    shows 'a | '
    still map.png --size 320x240 folder/a.exr
    on_screen map.png
    press Next
    quits
}

# A map that cannot be read leaves the list of its folder, and says why.
test_list_without_a_set() {
    mkdir damaged
    echo junk >damaged/a.hdr
    hint=kept open damaged || return
    xdotool mousemove --window "$window" 100 77 sleep 1 click 1
    within grep -q 'a.hdr: is no image' said || has 'a.hdr: is no image' said
    ! gone || echo 'wanted it running, found an end'
    quits
}

# A pipe whose writer says nothing keeps no window open.
test_stalled_pipe() {
    mkfifo stalled
    exec 5<>stalled
    open stalled || return
    press q
    ended
    exec 5>&-
    is 0 $status "$(cat said): status"
}

# Twice as fine a display: a window, and a picture, of twice as many pixels.
test_fine_display() {
    desktop root dpi 192
    open --no-labels baked || return
    shows 'env | '
    still off.png --size 640x480 --no-labels baked
    away
    on_screen off.png
    # Nothing else is drawn between the window and the picture.
    snap first.png
    same first.png off.png
    xdotool mousemove --window "$window" 200 100 mousedown 1 \
        mousemove_relative 40 0 mousemove_relative 80 0 mouseup 1
    snap dragged.png
    still off.png --size 640x480 --no-labels --yaw -45 baked
    same dragged.png off.png 'dragged by a quarter of the height'
    press q
    ended
    desktop root dpi 96
}

# ---- where there is no window ----------------------------------------------
test_no_display() {
    (unset DISPLAY
     refused 1 'iblview: no window: *DISPLAY*--offscreen*' iblview baked)
    DISPLAY=:4242 refused 1 'iblview: no window: *:4242*--offscreen*' \
        iblview baked
}
test_no_opengl() {
    refused 1 'iblview: no window with OpenGL 3.3 core: *--offscreen*' \
        iblview baked
}

run() { # TESTS
    local t
    for t; do
        # The first one makes the picture that others come back to.
        [ $t = opens_and_equals_offscreen ] || picked "test_$t" || continue
        "test_$t" >why 2>&1
        verdict "$t" "$(head -n 5 why)"
    done
}
verdict 'bakes' "$(baked env.exr)"
start_server -fbdir screen
run opens_and_equals_offscreen
if [ -n "$viewer" ]; then
    run states pictures_are_kept texel_under_the_pointer \
        panel resize drop quit baked_probes arrays maps_of_a_folder \
        list_without_a_set stalled_pipe \
        fine_display
fi
stop_server
run no_display
start_server -extension GLX
run no_opengl
cd "$top" || exit 1
end

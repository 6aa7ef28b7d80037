#!/bin/bash
# SPDX-License-Identifier: MIT
# The scene's probes round: iblview writes what they have captured, iblbake
# bakes it, and iblview lights the scene by that. BUILD names the build.
set -u
. tests/lib.sh
slow='saving|every_way'
use_viewer
mkenv exr 64 32 BGR >"$work/env.exr"
iblbake -q "$work/env.exr" -o "$work/sky" --size 32 --irradiance-size 8 \
    --lut-size 32 || exit 1
scene='--mode scene --probe-size 32 --seconds 1.5 --fov 70 --pitch 15 --yaw 30'
picture="--size 128x96 $scene"

cd "$work" || exit 1
# shellcheck disable=SC2086
iblview sky --offscreen captured.png $picture --probes 8 2>err
need_pictures err
# shellcheck disable=SC2086
iblview sky --offscreen alone.png $picture || exit 1
# shellcheck disable=SC2086
iblview sky $scene --probes 8 --save-probes scene || exit 1

# quietly [command]: it works without a word.
quietly() {
    "$@" >"$work/said" 2>&1 || echo "$*: status $?"
    [ ! -s "$work/said" ] || echo "$*: $(head -n 1 "$work/said")"
}
near() { node "$work/bin/png.mjs" "$@"; }
save() { # DIR [arguments]
    local dir=$1
    shift
    # shellcheck disable=SC2086
    quietly iblview sky $scene --probes 8 --save-probes "$dir" "$@"
}
bake() { quietly iblbake probes -q "$@"; } # SET -o DIR [options]
show() { # OUT.png INDEX [arguments]
    local out=$1 index=$2
    shift 2
    # shellcheck disable=SC2086
    quietly iblview sky --offscreen "$out" $picture --probe-set "$index" "$@"
}

# ---- round ----------------------------------------------------------------

# What is left is 64 samples a texel against the exact prefilter: of 255 values
# 2 at most, and 0.9 in the mean of a part.
test_the_same_picture() {
    [ "$(find scene/ -type f | wc -l)" = 49 ] || ls scene
    bake scene/set.json -o baked
    show baked.png baked/index.json
    near captured.png baked.png 4 1.2
    # Without probes it is another one.
    [ -n "$(near captured.png alone.png 60 10)" ] || echo 'probes do nothing'
}

# Filtered by the library as well, both are nearly the same.
test_filtered_by_the_library() {
    save filtered --probe-filter cpu
    bake filtered/set.json -o baked
    # shellcheck disable=SC2086
    quietly iblview sky --offscreen a.png $picture --probes 8 \
        --probe-filter cpu
    show b.png baked/index.json --probe-filter cpu
    near a.png b.png 4 1
}

# Nine harmonics are what irradiance is but for some percent.
test_every_way_to_bake() {
    bake scene/set.json -o baked --container dds --pixel rgba32f
    show a.png baked/index.json
    near captured.png a.png 4 1.2
    bake scene/set.json -o baked --container ktx --pixel rgb9e5
    show a.png baked/index.json
    near captured.png a.png 4 1.2
    bake scene/set.json -o baked --pixel bc6h --quality fast --zstd 1
    show a.png baked/index.json
    near captured.png a.png 24 2.4
    bake scene/set.json -o baked --pixel r11g11b10f --irradiance sh
    show a.png baked/index.json
    near captured.png a.png 16 6
}

# A wall hides baked probes as it hides captured ones.
test_walls() {
    bake scene/set.json -o baked
    # shellcheck disable=SC2086
    quietly iblview sky --offscreen without.png $picture --probes 8 --no-walls
    show a.png baked/index.json --no-walls
    near without.png a.png 4 1.2
    near captured.png a.png 16 2 >other
    [ -s other ] || echo 'no wall hides a probe'
}

# ---- saving ----------------------------------------------------------------

test_saving() {
    save b --offscreen b.png --size 128x96
    diff -r scene b
    cmp captured.png b.png
    save b # over what is there
    diff -r scene b
    save paraboloids --probe-capture paraboloids
    diff -rq scene paraboloids >differ && echo 'no paraboloids'
    # shellcheck disable=SC2086
    iblview sky $scene --probes 2 --save-probes c/d -v >said ||
        echo "status $?"
    [ -s c/d/set.json ] || echo 'no directory was made'
    grep -q 'probes: 2, faces of 32, written to c/d' said || cat said
}

test_saving_fails_whole() {
    echo >plain
    wrong 1 '*plain*' sky $scene --probes 8 --save-probes plain
    wrong 1 '*/dev/null*' sky $scene --probes 8 --save-probes /dev/null/x
    mkdir full
    mkdir full/probe_07_nz.exr
    ls -A full >names
    wrong 1 '*probe_07_nz.exr*' sky $scene --probes 8 --save-probes full
    ls -A full | diff names -
    # And with a signal while it is cleaned up.
    [ $sanitized = no ] || return
    preload
    # shellcheck disable=SC2086
    { LD_PRELOAD=$work/preload.so FAULT='remove -15 0' iblview sky $scene --probes 8 \
        --save-probes full 2>err; } 2>/dev/null
    [ $? -eq 143 ] || echo "status $?: $(cat err)"
    ls -A full | diff names -
}

# ---- what is said ----------------------------------------------------------

test_misuse() {
    wrong 2 '*--probe-set and --probes: choose one*' sky $scene --probes 2 \
        --probe-set x.json --offscreen a.png
    wrong 2 '*--save-probes and --probe-set: choose one*' sky $scene \
        --probe-set x.json --save-probes out
    wrong 2 '*--save-probes: there are no local probes*' sky $scene \
        --save-probes out
    wrong 2 '*--save-probes: only with --mode scene*' sky --probes 2 \
        --save-probes out
    wrong 2 '*--save-probes and --contact-sheet: choose one*' sky $scene \
        --probes 2 --save-probes out --contact-sheet a.png
}

test_bad_sets() {
    wrong 1 '*none.json: cannot be read*' sky $scene --offscreen a.png \
        --probe-set none.json
    wrong 1 '*scene/set.json: is a set to bake*' sky $scene --offscreen a.png \
        --probe-set scene/set.json
    bake scene/set.json -o baked
    sed -i 's/"layer": 1,/"layer": 99,/' baked/index.json
    wrong 1 '*index.json: probes\[1\].layer: *from 0 to 7, found 99*' sky \
        $scene --offscreen a.png --probe-set baked/index.json
}

test_what_is_told() {
    bake scene/set.json -o baked
    # shellcheck disable=SC2086
    iblview sky --offscreen a.png $picture --probe-set baked/index.json -v \
        >said 2>&1 || echo "status $?"
    grep -q '^probes: baked/index.json, 8, levels: 3$' said || cat said
}

for t in $(declare -F | sed -n 's/^declare -f \(test_.*\)/\1/p'); do
    picked "$t" || continue
    mkdir "$work/$t" && cd "$work/$t" || exit 1
    ln -s ../sky ../scene ../captured.png ../alone.png .
    verdict "$t" "$($t 2>&1)"
    cd "$work" || exit 1
done
end

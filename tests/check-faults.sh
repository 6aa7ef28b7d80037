#!/bin/bash
# SPDX-License-Identifier: MIT
# Has calls to the C library fail, one at a time, and kills the programs, as
# faults/walk.c says. Tries some of all runs; with FULL=1 all, which takes long.
# BUILD names the build.
set -u
. tests/lib.sh
slow='bench|verify|map|saved'
use iblbake
! [ -x "$build/iblview" ] || ln -s "$build/iblview" "$work/bin"
[ $sanitized = no ] || skip_all 'a sanitizer replaces the same calls'
preload
${CC:-cc} -std=c11 -O1 -o "$work/bin/walk" tests/faults/walk.c || exit 1
mkenv exr 8 4 BGR >"$work/a.exr"
mkenv hdr 8 4 >"$work/b.hdr"
small='-q --size 4 --lut-size 4 --irradiance-size 2'

# Makes this directory the one that runs begin in.
begin() {
    mkdir "$work/$t" "$work/$t/before" && cd "$work/$t/before" || exit 1
    cp "$work/a.exr" "$work/b.hdr" .
}
# faults N [options of walk] -- COMMAND...: each Nth run.
faults() {
    local options=(-e "$1")
    shift
    for (( ; $# > 0; )); do
        [ "$1" != -- ] || break
        options+=("$1")
        shift
    done
    shift
    [ -z "${FULL:-}" ] || options+=(-e 1)
    walk "${options[@]}" "$work/preload.so" "$work/$t/before" "$work/$t/run" \
        "$@" 2>"$work/$t/counts"
    [ -z "${FULL:-}" ] || { echo "$t:"; cat "$work/$t/counts"; } >&3
}

# Over an older set, flushed.
test_bake() {
    begin
    # shellcheck disable=SC2086
    iblbake a.exr $small --size 8 -o o --depfile d
    # shellcheck disable=SC2086
    faults 97 -- iblbake a.exr -j 1 $small -o o --depfile d --sync
}

# Drawing takes most of the time.
test_preview() {
    begin
    # shellcheck disable=SC2086
    iblbake a.exr $small --only lut,json -o o --preview p.png
    # shellcheck disable=SC2086
    faults 197 -- iblbake b.hdr -j 1 $small --only lut,json -o o \
        --preview p.png
}

# Into a new folder, files of several engines, by two threads.
test_targets() {
    begin
    # shellcheck disable=SC2086
    faults 97 -- iblbake b.hdr -j 2 $small -o n/o --target three,babylon-env \
        --lights 1
}

# Two maps side by side, of which what is finished stays.
test_batch() {
    begin
    # shellcheck disable=SC2086
    faults 397 -p -- iblbake a.exr b.hdr -j 1 $small -o o
}

# One of two probes is as it was.
test_probes() {
    begin
    cat >set.json <<'END'
{"version": 1,
 "defaults": {"size": 4, "levels": 1, "irradiance": 4, "lut_size": 4},
 "probes": [
  {"name": "hall", "position": [0, 1, 0], "capture": {"equirect": "a.exr"},
   "influence": {"box": {"centre": [0, 1, 0], "half": [4, 2, 4]}}},
  {"name": "lamp", "position": [1, 1, 0], "capture": {"equirect": "b.hdr"},
   "influence": {"sphere": {"centre": [1, 1, 0], "radius": 1}}}
 ]}
END
    iblbake probes -q set.json -o o
    cp a.exr b.hdr
    faults 97 -- iblbake probes -q -j 1 set.json -o o --sync
}

test_grid() {
    begin
    cat >room.json <<'END'
{"version": 1, "min": [-6, 0, -4], "max": [6, 3, 4], "spacing": 4,
 "solid": [{"min": [-1, 0, -5], "max": [0, 9, 0]}],
 "capture": {"equirect": "grid/{name}.exr"}, "defaults": {"size": 8}}
END
    faults 29 -- iblbake probes --grid room.json -o set.json
}

test_verify() {
    begin
    # shellcheck disable=SC2086
    iblbake a.exr $small -o o
    faults 397 -k memory -k read -k write -- iblbake verify -q -j 1 a.exr o --texels 24 --json v.json
}

# What it measures differs from run to run.
test_bench() {
    begin
    faults 9999 -q -1 -k memory -- iblbake bench -q a.exr --sizes 4 --samples 4 \
        --rounds 1 --texels 24
}

# Not in OpenGL, whose own failures are not ours.
test_picture() {
    begin
    # shellcheck disable=SC2086
    iblbake a.exr $small -o o
    faults 397 -o -k memory -k read -- iblview o --size 16x16 --offscreen p.png
}

test_picture_of_a_map() {
    begin
    faults 397 -o -k memory -k read -- iblview a.exr --size 16x16 --offscreen p.png
}

test_saved_probes() {
    begin
    # shellcheck disable=SC2086
    iblbake a.exr $small -o o
    faults 397 -o -k memory -k read -- iblview o --mode scene --probe-size 16 --probes 1 \
        --save-probes s
}

exec 3>&1
for t in $(compgen -A function test_); do
    picked "$t" || continue
    verdict "$t" "$($t 2>&1 | head -n 40)"
    cd "$top" || exit 1
done
end

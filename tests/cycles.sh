#!/bin/sh
# SPDX-License-Identifier: MIT
# The viewer against a renderer that others wrote: spheres of F0 = 1 under one
# map, by Cycles and by each `iblview --reflection`, of sets by iblbake.
#   cycles.sh [BUILD [MAP [SAMPLES]]]      build, data/sky.exr, 512
# Skipped, with a word, where there is no Blender. Prints errors for each
# sphere, fails where they are beyond the bounds of tests/cycles.c.
set -eu
build=${1:-build}
map=${2:-data/sky.exr}
samples=${3:-512}
command -v blender >/dev/null 2>&1 || {
    echo 'check-cycles: skipped: there is no blender (Debian: blender)'
    exit 0
}
command -v oiiotool >/dev/null 2>&1 || {
    echo 'check-cycles: skipped: no oiiotool (Debian: openimageio-tools)'
    exit 0
}
work=$(mktemp -d "${TMPDIR:-/tmp}/iblview-cycles-XXXXXX")
trap 'rm -rf "$work"' EXIT
"$build/tests/cycles" scene >"$work/scene.json"
"$build/tests/cycles" map "$map" >"$work/map.pfm"
oiiotool "$work/map.pfm" -d float -o "$work/map.exr"
blender -b --factory-startup --python-exit-code 1 -P tests/cycles.py -- \
    "$work/scene.json" "$work/map.exr" "$work/cycles.exr" "$samples" \
    >"$work/log" 2>&1 || {
    tail -n 5 "$work/log"
    echo 'check-cycles: blender failed'
    exit 1
}
"$build/iblbake" -q --mapping linear "$map" -o "$work/linear"
"$build/iblbake" -q "$map" -o "$work/set"
"$build/tests/cycles" compare "$map" "$work/linear" "$work/set" \
    "$work/cycles.exr"

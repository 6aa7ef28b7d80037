#!/bin/bash
# SPDX-License-Identifier: MIT
# The viewer against a renderer that others wrote: spheres of F0 = 1 under one
# map, by Cycles and by each `iblview --reflection`, of sets by iblbake; then a
# model, if it is there, of Debian's assimp-testmodels: 121,496 triangles.
#   cycles.sh [BUILD [MAP [SAMPLES [MODEL]]]]      build, data/sky.exr, 512
# Skipped, with a word, where there is no Blender. Prints errors for each
# sphere, fails where they are beyond the bounds of tests/cycles.c.
set -eu
build=${1:-build}
map=${2:-data/sky.exr}
samples=${3:-512}
model=${4:-/usr/share/assimp/models/glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb}
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
render() { # SCENE PICTURE SAMPLES [MODEL]
    blender -b --factory-startup --python-exit-code 1 -P tests/cycles.py -- \
        "$work/$1" "$work/map.exr" "$work/$2" "${@:3}" >"$work/log" 2>&1 || {
        tail -n 5 "$work/log"
        echo 'check-cycles: blender failed'
        exit 1
    }
}
"$build/tests/cycles" map "$map" >"$work/map.pfm"
oiiotool "$work/map.pfm" -d float -o "$work/map.exr"
"$build/iblbake" -q --mapping linear "$map" -o "$work/linear"
"$build/iblbake" -q "$map" -o "$work/set"
"$build/tests/cycles" scene >"$work/scene.json"
render scene.json cycles.exr "$samples"
"$build/tests/cycles" compare "$map" "$work/linear" "$work/set" \
    "$work/cycles.exr"
if ! [ -r "$model" ] || ! blender -b --python-exit-code 1 \
    --python-expr 'import numpy' >"$work/log" 2>&1; then
    echo 'check-cycles: no model (Debian: assimp-testmodels, python3-numpy)'
    exit 0
fi
"$build/tests/cycles" scene "$model" >"$work/model.json"
render model.json model.exr "$samples" "$model"
echo "${model##*/}"
"$build/tests/cycles" compare "$work/set" "$model" "$work/model.exr"

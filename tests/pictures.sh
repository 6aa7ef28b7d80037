#!/bin/sh
# SPDX-License-Identifier: MIT
# Pictures of rough metals, under a sun and under a soft sky: by the
# split sum, by four taps of the lobe table with the sun as a light, and by the
# integral, from top to bottom.
#   pictures.sh [BUILD [OUT [ROWS]]]
#                  build, data, "split four-taps reference"
set -eu
build=${1:-build}
out=${2:-data}
rows=${3:-split four-taps reference}
sun=../shared/data/quarry_01_1k.hdr
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

picture() { # NAME MAP OPTIONS
    name=$1 map=$2 n=0
    shift 2
    "$build/iblbake" -q "$map" -o "$work/$name-split"
    "$build/iblbake" -q "$map" --sun -o "$work/$name-four-taps" 2>"$work/none"
    ln -s "$name-four-taps" "$work/$name-reference"
    for row in $rows; do
        n=$((n + 1))
        samples=
        [ "$row" != reference ] || samples='--samples 1024'
        # shellcheck disable=SC2086
        "$build/iblview" -q "$work/$name-$row" --reflection "$row" \
            $samples --size 720x160 --grid 1x6 --metallic 1:1 \
            --material white --fov 12 --roughness 0.2:0.9 --no-labels \
            --offscreen "$work/$name-$n.png" "$@"
    done
    oiiotool "$work/$name"-?.png --mosaic:pad=4 "1x$n" -o "$out/$name.png"
}
[ ! -r "$sun" ] || picture rendered-sun "$sun" --turn 75 --ev -1
picture rendered-soft data/forest.exr --turn 250
# The first of the README, where Blender is: an environment of 2048x1024.
if [ "${rows%reference}" != "$rows" ] && command -v blender >/dev/null; then
    blender -b --factory-startup --python-exit-code 1 -P data/colonnade.py -- \
        "$work/colonnade.exr" >"$work/none"
    "$build/iblbake" -q "$work/colonnade.exr" -o "$work/hero" --size 512 --sun
    "$build/iblview" -q "$work/hero" --offscreen "$out/hero.png" --no-labels \
        --size 1280x560 --grid 2x6 --antialias 3 --turn 25 --fov 30 \
        --pitch 3 --ev -2.2
fi

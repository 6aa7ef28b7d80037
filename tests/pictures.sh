#!/bin/sh
# SPDX-License-Identifier: MIT
# Pictures of rough metals, under a sun and under a soft sky: by the
# split sum, by two taps of the lobe table with the sun as a light, and by the
# integral, from top to bottom.
#   pictures.sh [BUILD [SUN [SOFT [OUT]]]]
#                  build, quarry_01_1k.hdr, data/forest.exr, data
set -eu
build=${1:-build}
sun=${2:-../shared/data/quarry_01_1k.hdr}
soft=${3:-data/forest.exr}
out=${4:-data}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

strip() { # SET REFLECTION OPTIONS
    set=$1 way=$2
    shift 2
    "$build/iblview" -q "$work/$set" --reflection "$way" --samples 1024 \
        --size 720x160 --grid 1x6 --metallic 1:1 --material white --fov 12 \
        --roughness 0.2:0.9 --no-labels --offscreen "$work/$way.png" "$@"
}
picture() { # NAME MAP OPTIONS
    name=$1 map=$2
    shift 2
    "$build/iblbake" -q "$map" --skybox 512 --mapping linear -o "$work/all"
    "$build/iblbake" -q "$map" --skybox 512 --sun -o "$work/sun" 2>"$work/none"
    strip all split "$@"
    strip sun two-taps "$@"
    strip sun reference "$@"
    oiiotool "$work/split.png" "$work/two-taps.png" "$work/reference.png" \
        --mosaic:pad=4 1x3 -o "$out/$name.png"
    rm -r "$work/all" "$work/sun"
}
[ ! -r "$sun" ] || picture rendered-sun "$sun" --turn 75 --ev -1
picture rendered-soft "$soft" --turn 250

# Local probes without and with the walls that hide them: the orange light of the
# panel on the right goes through the wall behind the sphere, or it does not.
"$build/iblbake" -q data/sky.exr -o "$work/scene"
wall() { # NAME OPTIONS
    name=$1
    shift
    "$build/iblview" -q "$work/scene" --mode scene --probes 9 --probe-size 64 \
        --seconds 1.5 --yaw -32 --pitch -12 --fov 50 --turn 180 --ev 0.5 \
        --size 480x320 --offscreen "$work/$name.png" "$@"
}
wall through --no-walls
wall hidden
oiiotool "$work/through.png" "$work/hidden.png" --mosaic:pad=4 2x1 \
    -o "$out/scene-walls.png"

#!/bin/bash
# SPDX-License-Identifier: MIT
# The bytes that --scene and --rendered-error choose beside the fewest there
# are, see bench_choice.c: a line for each of 16 cases; minutes.
#   bench-choice.sh [FOLDER]    of npm's @webxr-input-profiles/assets, as
#                               bench-scenes.sh fetches it
# Maps that are not here are left out.
set -eu
make -s DEPS=no BUILD="${BUILD:-build}" bridge \
    "${BUILD:-build}/tests/bench_choice"
# shellcheck source=tests/lib.sh
. tests/lib.sh
npm=${1:-$build/scenes/node_modules/@webxr-input-profiles/assets/dist/profiles}

cd "$work"
matte='"pbrMetallicRoughness": {"metallicFactor": 0'
make_scene matte "[{$matte}}]"
make_scene mirror '[{"pbrMetallicRoughness": {"roughnessFactor": 0}}]'
of_roughness() { # BEGINNING ROUGHNESS...: a material of each
    local pbr=$1 sep=
    shift
    for r; do
        printf '%s{%s"roughnessFactor": %s}}' "$sep" "$pbr" "$r"
        sep=', '
    done
}
make_scene plastic "[$(of_roughness "$matte, " 0.3 0.4 0.5 0.6)]"
make_scene all "[$(of_roughness '"pbrMetallicRoughness": {' \
    0 0.1 0.2 0.3 0.4 0.5 0.6 0.7 0.8 0.9 1)]"
cd "$top"

case_of() { # MAP ERROR SCENE; ERROR -: --scene alone
    local scene=$work/$3.gltf error=()
    [ "$2" = - ] || error=(--rendered-error "$2")
    [ -e "$scene" ] || scene=$npm/$3.glb
    if [ ! -r "$1" ] || [ ! -r "$scene" ]; then
        echo "left out: $3 in $1"
        return
    fi
    printf '%s in %s, ' "$3" "${1##*/}"
    "$build/tests/bench_choice" "$1" --scene "$scene" "${error[@]}" \
        --dry-run 2>/dev/null | grep 'ratio\|can be had'
}
shared=../shared/data
case_of data/forest.exr .01 matte
case_of data/sky.exr .005 matte
case_of $shared/quarry_01_1k.hdr .02 matte
case_of data/forest.exr .01 plastic
case_of data/studio.exr .005 plastic
case_of $shared/royal_esplanade_1k.hdr .02 plastic
case_of $shared/royal_esplanade_1k.hdr .1 plastic
case_of data/studio.exr .1 mirror
case_of data/forest.exr .1 all
case_of data/forest.exr .2 all
case_of data/forest.exr - oculus-go/none
case_of data/forest.exr - oculus-touch/left
case_of data/studio.exr - generic-fixed-hand/left
case_of data/studio.exr .05 generic-touchpad/left
case_of data/forest.exr .2 generic-touchpad/left
case_of $shared/night.exr .05 generic-trigger/left

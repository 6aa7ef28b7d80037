#!/bin/bash
# SPDX-License-Identifier: MIT
# The files of iblbake --target in the engines themselves, as npm has them, in
# Chromium with software GL: drawn by the programs that --explain prints, and
# compared block by block with what half floats give in the same engine and
# exact levels by its lookups. Engines that do not run here (Bevy, Cesium) have
# readers that we wrote from their rules.
# BUILD: where to build. MAPS: names of the maps, by default two that differ most;
# `make check-clients` takes four. PICTURE: also write a picture of the engines
# side by side there. The last line is "N passed, N failed, N skipped".
set -u
MAPS=${MAPS:-quarry blaze}
. tests/lib.sh

need node npm chromium
npm=$build/npm-clients
fetch_npm "$npm" 'three@0.187.0 babylonjs@9.34.0 babylonjs-loaders@9.28.0
    filament@1.53.4 playcanvas@2.23.3 ktx-parse@1.1.0' ||
    skip_all 'npm cannot fetch the engines'

targets=$("$build/iblbake" --target list |
    sed -n '/^unreal/,$d; s/^\([a-z-]*\): .*/\1/p' | paste -sd,)
bake() { "$build/iblbake" -q --name map "$@"; }
# What files are compared with: floats, in our world, in a folder that is named
# after the options.
exact() { # MAP ENV OPTIONS
    local map=$1 env=$2 name
    shift 2
    name=${*//--/}
    bake "$env" -o "$work/$map/exact-${name// /-}" "$@" --pixel rgba32f \
        --only specular,irradiance,json
}
for map in lamps $MAPS; do
    case $map in
    quarry) env=../shared/data/quarry_01_1k.hdr other=data/sky.exr ;;
    royal) env=../shared/data/royal_esplanade_1k.hdr other=data/studio.exr ;;
    *)
        env=$work/$map.hdr
        node tests/clients/maps.mjs $map >"$env"
        ;;
    esac
    [ -f "$env" ] || env=$other
    ok "$map" bake --target $targets "$env" -o "$work/$map"
    for target in ${targets//,/ }; do
        "$build/iblbake" --target "$target" --name map --explain \
            >"$work/$map/$target.js"
    done
    [ $map != lamps ] || continue
    for chain in 'filament --size 384 --levels 6' 'babylon --size 256' \
        'linear --size 256 --levels 6' 'linear --size 256 --levels 5'; do
        # shellcheck disable=SC2086
        ok "$map, $chain" exact $map "$env" --mapping $chain
    done
    ok "$map for three" bake "$env" -o "$work/$map/three-half" \
        --only specular --size 384 --levels 5 --mirror x
    ok "$map for Filament" bake "$env" -o "$work/$map/filament-half" \
        --only specular --levels 5 --format ktx --sh 2
done

MAPS=$MAPS \
    node tests/clients/drive.mjs "$npm" "$work" "$(command -v chromium)" \
    ${PICTURE:+"$PICTURE"} >"$work/report" 2>&1
report 'the engines' "$work/report"
end

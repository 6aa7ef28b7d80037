#!/bin/bash
# SPDX-License-Identifier: MIT
# The files of iblbake --target in the engines themselves, as npm has them, in
# Chromium with software GL: drawn by the lines that --explain prints, compared
# with what exact levels give by the engine's own lookups. Engines that do not
# run here (Bevy, Cesium, glTF's extension) are readers that we wrote from their
# rules. BUILD: where to build. SUN: a map of a sun. PICTURE: also write a
# picture of the engines side by side there. The last line is "N passed, N
# failed, N skipped".
set -u
. tests/lib.sh

need node npm chromium
# Fetched once: a network that is not there is no fault of our files.
engines='three@0.187.0 babylonjs@9.34.0 filament@1.53.4 playcanvas@2.23.3'
readers='ktx-parse@1.1.0 pngjs@7.0.0 gltf-validator@2.0.0-dev.3.10'
npm=$build/npm-clients
if [ "$(cat "$npm/fetched" 2>/dev/null)" != "$engines $readers" ]; then
    # shellcheck disable=SC2086
    npm install --no-save --no-package-lock --no-audit --no-fund \
        --ignore-scripts --loglevel=error --prefix "$npm" $engines $readers ||
        skip_all 'npm cannot fetch the engines'
    echo "$engines $readers" >"$npm/fetched"
fi

sun=${SUN:-../shared/data/quarry_01_1k.hdr}
[ -f "$sun" ] || sun=data/sky.exr
node tests/clients/lamps.mjs >"$work/lamps.hdr"
targets=$("$build/iblbake" --target list | sed -n 's/^\([a-z-]*\): .*/\1/p' |
    paste -sd,)
bake() { "$build/iblbake" -q --name map "$@"; }
# What files are compared with: floats, in our world, in a folder that is named
# after the options.
exact() { # MAP ENV OPTIONS
    local map=$1 env=$2 name
    shift 2
    name=${*//--/}
    bake "$env" -o "$work/$map/exact-${name// /-}" "$@" --pixel rgba32f \
        --lut-size 64 --only specular,irradiance,lut,json
}
for map in lamps sun soft; do
    case $map in
    lamps) env=$work/lamps.hdr ;;
    sun) env=$sun ;;
    soft) env=data/forest.exr ;;
    esac
    ok "$map" bake --target $targets "$env" -o "$work/$map"
    for target in ${targets//,/ }; do
        "$build/iblbake" --target "$target" --name map --explain \
            >"$work/$map/$target.js"
    done
    [ $map != lamps ] || continue
    for chain in 'filament --size 256 --levels 6' 'babylon --size 256' \
        'linear --size 256 --levels 6' 'linear --size 256 --levels 5'; do
        # shellcheck disable=SC2086
        ok "$map, $chain" exact $map "$env" --mapping $chain
    done
done

node tests/clients/drive.mjs "$npm" "$work" "$(command -v chromium)" \
    ${PICTURE:+"$PICTURE"} >"$work/report" 2>&1
grep -v '^[0-9]* passed, [0-9]* failed$' "$work/report"
last=$(tail -n 1 "$work/report")
case $last in
*' passed, '*' failed')
    passed=$((passed + ${last%% passed*}))
    last=${last#* passed, }
    failed=$((failed + ${last%% failed}))
    ;;
*) verdict 'the engines' 'no verdict' ;;
esac
end

#!/bin/bash
# SPDX-License-Identifier: MIT
# What shaders draw with baked files, by `iblbake verify --rendered`: for each map
# and way nRMSE +- its standard error, median and 95th percentile of the error,
# means over the roughnesses from .1 to 1, in percent, for F0 = 1 and F0 = .04.
#   bench-rendered.sh [BUILD [MAP...]]
#                  build, data/*.exr and ../shared/data/*.hdr
set -eu
build=${1:-build}
[ $# -eq 0 ] || shift
[ $# -gt 0 ] || set -- data/*.exr ../shared/data/*.hdr
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

bake() { # NAME [OPTIONS]: into a directory of that name
    "$build/iblbake" -q "$map" --name env -o "$work/$1" "${@:2}"
}
judge() { # TEXT [OPTIONS]
    "$build/iblbake" verify --rendered "$map" "${@:2}" |
        awk -v text="$1" '$2 == "mean" {
                split($3, nrmse, /[+]-/)
                error = 100 * nrmse[2]
                digits = error > .95 ? 0 : error > .095 ? 1 : 2
                error = sprintf("%.*f", digits, error)
                sub(/^0/, "", error)
                row = row sprintf("| %.*f +- %s / %.1f / %.0f ", digits,
                    100 * nrmse[1], error, 100 * $4, 100 * $5)
            }
            END { print "| " text " " row "|" }'
}
for map; do
    [ -r "$map" ] || continue
    echo "| ${map##*/} | F0 = 1 | F0 = .04 |"
    echo '| --- | --- | --- |'
    rm -rf "${work:?}"/*
    bake linear --mapping linear
    bake default
    bake sun --sun
    if command -v cmgen >/dev/null; then
        cmgen -q -f ktx -s 256 -x "$work/cmgen" "$map" &&
            judge "cmgen, split sum" --shader split --rotate -90 \
                --roughness-map filament --lut "$work/default/brdf_lut.ktx2" \
                --specular "$work/cmgen/cmgen_ibl.ktx"
    fi
    judge '`--mapping linear`, split sum' "$work/linear" --name env \
        --shader split
    for shader in split bent fit table two-taps four-taps; do
        judge "default, $shader" "$work/default" --name env --shader $shader
    done
    for shader in table four-taps; do
        judge "\`--sun\`, $shader" "$work/sun" --name env --shader $shader
    done
    echo
done

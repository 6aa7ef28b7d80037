#!/bin/sh
# SPDX-License-Identifier: MIT
# iblbake beside Filament's cmgen and the classic tutorial, error beside time,
# through `iblbake bench`: table, and bench.csv, .json, .html and, by gnuplot, .svg in OUT.
#   bench-peers.sh [BUILD [ROUNDS [ENV [OUT [OPTIONS]]]]]
#                  build, 5, quarry_01_1k.hdr, BUILD/bench, none
# OPTIONS are more of iblbake bench.
# The tutorial is learnopengl.com's as published, with our own options: the
# irradiance by the grid of step 0.025 over the hemisphere at 32x32, 1,024
# samples at 128x128 in 5 levels, first at full resolution, then with the mip
# by the sample's density, and the table of 512x512 at 1,024 with Schlick's
# geometry.
set -eu

build=${1:-build}
rounds=${2:-5}
env=${3:-../shared/data/quarry_01_1k.hdr}
out=${4:-$build/bench}
[ $# -lt 4 ] && set -- || shift 4

[ -r "$env" ] || {
    echo "skipped: $env is not here"
    exit 0
}
mkdir -p "$out"

tutorial='--method sampled --size 128 --levels 5 --samples 1024 --lod-bias 0
    --irradiance-size 32 --irradiance-step 0.025
    --lut-size 512 --lut-samples 1024 --geometry schlick-ibl'
# cmgen's outputs: the same levels, mapping, packed floats in KTX and the sky,
# and our irradiance, table and harmonics besides; also by its samples.
alike='--size 256 --levels 5 --mapping filament --rotate cmgen
    --format ktx --pixel r11g11b10f --skybox 256'

set -- "$@" --variant "as cmgen=$alike" \
    --variant "as cmgen by samples=$alike --method sampled --samples 1024" \
    --variant "tutorial=$tutorial --pdf-mip no" \
    --variant "tutorial with mips=$tutorial --pdf-mip yes"
if command -v cmgen >/dev/null 2>&1; then
    # It names its files after the directory.
    set -- "$@" --peer 'cmgen=cmgen -q -f ktx -s 256 -x {out}/cmgen {env}' \
        --peer-output 'cmgen=--specular {out}/cmgen/cmgen_ibl.ktx
            --roughness-map filament --rotate cmgen'
else
    echo 'skipped cmgen: it is not here (Debian: libfilament-tools)'
fi
"$build/iblbake" bench --rounds "$rounds" "$env" "$@" \
    --csv "$out/bench.csv" --json "$out/bench.json" \
    --html "$out/bench.html"
echo "$out/bench.html has the plots"
command -v gnuplot >/dev/null 2>&1 || exit 0
gnuplot <<END
set terminal svg size 720,440 font "sans-serif,12" background "white"
set output "$out/bench.svg"
set datafile separator comma
set logscale
set grid
set key off
set xlabel "time of the whole process, s"
set ylabel "nRMSE of the levels with r > 0"
set xrange [*:30]
plot "$out/bench.csv" using \\
    (strcol("content") eq "all" ? column("wall_s") : NaN):"nrmse" \\
    with points pointtype 7, \\
    "" using (strcol("content") eq "all" ? column("wall_s") : NaN):"nrmse":\\
    "name" with labels offset 1 left
END

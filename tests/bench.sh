#!/bin/sh
# SPDX-License-Identifier: MIT
# bench.sh BUILD: the figures of tests/MEASURED.md, measured here and now.
set -eu
build=${1:-build}
work=$(mktemp -d "${TMPDIR:-/tmp}/iblbake-bench-XXXXXX")
trap 'rm -rf "$work"' EXIT

map=../shared/data/quarry_01_1k.hdr
[ -r "$map" ] || {
    echo "skipped: $map is not here"
    exit 0
}
echo '== a 4096x2048 EXR (ZIP) baked, beside OpenEXRCore decoding it'
# Noise of 0.5 %, for without it neighbours would be alike as in no picture.
oiiotool "$map" --resize 4096x2048 \
    --pattern constant:color=1,1,1 4096x2048 3 \
    --noise:type=gaussian:mean=0:stddev=0.005 --mul \
    -d half --compression zip -o "$work/4k.exr"
"$build/tests/bench_turns" 9 \
    iblbake "$build/iblbake" -q "$work/4k.exr" -o "$work/out" , \
    OpenEXRCore "$build/tests/bench_exr" "$work/4k.exr"

echo '== accuracy of sampled specular levels, beside cmgen'
"$build/tests/bench_quality"

echo '== what the default bake promises'
bash tests/bench-spectral.sh "$build"

echo '== whole processes: settings, the classic tutorial, cmgen'
sh tests/bench-peers.sh "$build"

#!/bin/sh
# SPDX-License-Identifier: MIT
# Our BC6H and UASTC HDR beside those of Basis Universal (ktx2-encoder and
# three.js of npm): a Markdown table for each map, of its default levels, with
# seconds of one processor, kB with Zstandard 19, and errors as ibl/io.h defines
# them.
#   bench-blocks.sh [BUILD [MAP...]]
#                   build, data/forest.exr and quarry_01_1k.hdr
set -eu
build=${1:-build}
[ $# -lt 1 ] || shift
[ $# -gt 0 ] || set -- data/forest.exr ../shared/data/quarry_01_1k.hdr
work=$build/blocks
npm=$work/npm

make -s DEPS=no BUILD="$build" "$build/iblbake" "$build/tests/bench_blocks"
mkdir -p "$npm"
peers='ktx2-encoder@0.6.0 ktx-parse@1.1.0 three@0.187.0'
if [ "$(cat "$npm/fetched" 2>/dev/null)" != "$peers" ]; then
    # shellcheck disable=SC2086
    npm install --no-save --no-package-lock --no-audit --no-fund \
        --ignore-scripts --loglevel=error --prefix "$npm" $peers
    echo "$peers" >"$npm/fetched"
fi
for map; do
    [ -r "$map" ] || {
        echo "skipped: $map is not here"
        continue
    }
    for pixel in rgba32f bc6h uastc-hdr; do
        "$build/iblbake" -q "$map" --only specular --pixel $pixel \
            --name $pixel -o "$work"
    done
    name=${map##*/}
    seconds=$(node "$(dirname "$0")/bench_blocks.mjs" "$npm" "$work")
    # shellcheck disable=SC2086
    "$build/tests/bench_blocks" "$work" "${name%.*}" $seconds
done

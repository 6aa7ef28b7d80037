#!/bin/sh
# SPDX-License-Identifier: MIT
# bench.sh BUILD: the figures of tests/MEASURED.md, measured here and now.
set -eu
build=${1:-build}
map=../shared/data/quarry_01_1k.hdr
[ -r "$map" ] || {
    echo "skipped: $map is not here"
    exit 0
}
echo '== what the default bake promises'
bash tests/bench-spectral.sh "$build"

echo '== whole processes: settings, the classic tutorial, cmgen'
bash tests/bench-peers.sh "$build"

#!/bin/sh
# SPDX-License-Identifier: MIT
# Times whole processes, iblbake against cmgen of Filament, in turns
# A B C A B C ..., and prints medians and ratios.
#   bench-cmgen.sh [BUILD [ROUNDS [ENV]]]      build, 5, quarry_01_1k.hdr
#   A  iblbake, cmgen's outputs: the same levels, mapping, samples, packed
#      floats in KTX and the sky, and our irradiance, LUT and SH besides
#   B  iblbake as it comes
#   C  cmgen -q -f ktx -s 256 -x
set -eu

build=${1:-build}
rounds=${2:-5}
env=${3:-../shared/data/quarry_01_1k.hdr}

command -v cmgen >/dev/null 2>&1 || {
    echo 'skipped: no cmgen here (Debian: libfilament-tools)'
    exit 0
}
[ -r "$env" ] || {
    echo "skipped: $env is not here"
    exit 0
}

out=$(mktemp -d "${TMPDIR:-/tmp}/iblbake-bench-XXXXXX")
trap 'rm -rf "$out"' EXIT
trap 'exit 1' HUP INT TERM

run_A() {
    "$build/iblbake" -q --format ktx --pixel r11g11b10f --size 256 \
        --levels 5 --mapping filament --samples 1024 --skybox 256 \
        "$env" -o "$out/a"
}
run_B() {
    "$build/iblbake" -q "$env" -o "$out/b"
}
run_C() {
    cmgen -q -f ktx -s 256 -x "$out/c" "$env" >"$out/cmgen.log" 2>&1 || {
        cat "$out/cmgen.log" >&2
        return 1
    }
}

# The first round warms the caches and is not counted.
round=0
while [ "$round" -le "$rounds" ]; do
    for which in A B C; do
        start=$(date +%s%N)
        "run_$which"
        end=$(date +%s%N)
        [ "$round" = 0 ] || echo $((end - start)) >>"$out/$which"
    done
    round=$((round + 1))
done

# Milliseconds, the lower one of two middles.
median() {
    sort -n "$out/$1" | sed -n "$(((rounds + 1) / 2))p" |
        awk '{ printf "%.1f", $1 / 1e6 }'
}
a=$(median A) b=$(median B) c=$(median C)
echo "$env, medians of $rounds rounds in turns, whole processes"
awk -v a="$a" -v b="$b" -v c="$c" 'BEGIN {
    printf "cmgen -q -f ktx -s 256 -x     %8.1f ms\n", c
    printf "iblbake, the same and more    %8.1f ms  %5.1f times faster\n", \
        a, c / a
    printf "iblbake, defaults             %8.1f ms  %5.1f times faster\n", \
        b, c / b
}'

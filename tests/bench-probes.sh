#!/bin/bash
# SPDX-License-Identifier: MIT
# What probes cost, here and now: captures and their filters by size and method,
# frames by how many probes light them, and a set of 64 baked offline.
#   bench-probes.sh [BUILD [ROUNDS]]      build, 5 rounds of the set
# Everything that is compared takes turns; figures are medians, and CPU time
# is of all threads. OpenGL draws into memory, where Mesa's llvmpipe is the GPU,
# as the lines say.
set -eu
build=${1:-build}
rounds=${2:-5}
program=$build/iblbake
for f in "$program" "$build/tests/bench_set" "$build/tests/bench_turns"; do
    [ -x "$f" ] || { echo "$f: not built: make all benches"; exit 1; }
done
work=$(mktemp -d "${TMPDIR:-/tmp}/iblbake-probes-XXXXXX")
trap 'rm -rf "$work"' EXIT
probes=64 size=128

if [ -x "$build/tests/bench_capture" ]; then
    echo '== an update of a dynamic probe'
    "$build/tests/bench_capture"
    echo
    echo '== a frame of the room'
    "$build/tests/bench_room" 1280 720
else
    echo 'skipped what draws: iblview was not built'
fi
# ---- a set, offline ---------------------------------------------------------

echo
echo "== iblbake probes: $probes captures of six faces of $size"
mkdir "$work/hdr" "$work/exr"
"$build/tests/bench_set" "$work/hdr" "$probes" "$size"
sed 's/\.hdr/.exr/g' "$work/hdr/set.json" >"$work/exr/set.json"
for file in "$work"/hdr/*.hdr; do
    printf '%s -d half --compression zip -o %s ' "$file" \
        "$work/exr/$(basename "$file" .hdr).exr"
done | xargs -n 120 oiiotool

# A run, with its time and that of each stage added to FILE: lines of STAGE MS.
bake() { # TYPE THREADS FILE
    local TIMEFORMAT='%R %U %S'
    { time "$program" probes "$work/$1/set.json" -o "$work/out-$1-$2" \
        -j "$2" --force -v 2>"$work/said"; } 2>"$work/time"
    {
        awk '{ print "all", 1000 * $1; print "cpu", 1000 * ($2 + $3) }' \
            "$work/time"
        awk '$NF == "s" && $1 != "total" {
                ms = 1000 * $(NF - 1)
                NF -= 2
                sub(/ [0-9]+$/, "")
                gsub(/ /, "_")
                sum[$0] += ms
            }
            END { for (name in sum) print name, sum[name] }' "$work/said"
    } >>"$3"
}
for ((round = -1; round < rounds; round++)); do
    for type in hdr exr; do
        for threads in 1 2; do
            bake $type $threads "$work/times-$type-$threads"
            [ $round -ge 0 ] || : >"$work/times-$type-$threads"
        done
    done
done

# Median of a stage's lines; "specular" with the resampling to its texels.
median() { # STAGE FILE
    awk -v name="$1" '$1 == name { print $2 }' "$2" | sort -n |
        awk '{ v[NR] = $1 }
            END {
                if (NR)
                    print (v[int((NR + 1) / 2)] + v[int(NR / 2) + 1]) / 2
            }'
}
files=("$work"/times-hdr-1 "$work"/times-hdr-2 "$work"/times-exr-1
    "$work"/times-exr-2)
printf '%-34s %15s %15s %15s %15s\n' '' '.hdr -j1' '.hdr -j2' 'EXR -j1' \
    'EXR -j2'
row() { # WHAT STAGE...
    local what=$1 f stage
    shift
    printf '%-34s' "$what"
    for f in "${files[@]}"; do
        for stage; do median "$stage" "$f"; done |
            awk -v all="$(median all "$f")" '{ sum += $1 }
                END { printf " %7.0f ms %3.0f %%", sum, 100 * sum / all }'
    done
    printf '\n'
}
row 'hashes of captures' look
row 'reading and decoding' decode
row 'cube to map' map
row 'level 0' level
row 'analysis' analysis
row 'levels' specular resampling
row 'irradiance' irradiance
row 'half floats' texels
row 'table of the split sum' lut
row 'arrays and files' write
row 'hashes of files' hash
row 'whole process' all
row 'its CPU time' cpu
printf '%-34s' 'probes per second'
for f in "${files[@]}"; do
    awk -v n=$probes -v ms="$(median all "$f")" \
        'BEGIN { printf " %10.1f     ", 1000 * n / ms }'
done
printf '\n'

"$build/tests/bench_turns" 9 \
    hdr "$program" probes -q "$work/hdr/set.json" -o "$work/out-hdr-1" , \
    exr "$program" probes -q "$work/exr/set.json" -o "$work/out-exr-1" |
    awk '{ printf "%-34s %7.1f ms, fastest %.1f\n",
            "the same again, unchanged, " $1, $4, $5 }'

#!/bin/bash
# SPDX-License-Identifier: MIT
# What the default bake promises, beside what it does here and now: its error
# at every level, and its time as ratios to cmgen, to stb_image's decoding
# alone, to the sampled method and to one thread.
#   bench-spectral.sh [BUILD [ROUNDS [ENV]]]     build, 21, quarry_01_1k.hdr
# Commands run in turns (tests/bench_turns.c), those with cmgen a quarter of
# the rounds. A ratio is that of the medians, with that of the fastest runs
# after it. oiiotool makes the 4096x2048 map from ENV, with noise of 0.5 %:
# without it neighbours would have the same bytes, which no picture has, and run
# lengths would make reading easier than it is. What the build or the machine
# lacks is reported and left out.
set -eu
build=${1:-build}
rounds=${2:-21}
env=${3:-../shared/data/quarry_01_1k.hdr}
program=$build/iblbake turns=$build/tests/bench_turns stb=$build/tests/bench_stb

for f in "$program" "$turns" "$stb"; do
    [ -x "$f" ] || { echo "$f: not built: make all benches"; exit 1; }
done
[ -r "$env" ] || { echo "skipped: $env is not here"; exit 0; }
command -v node >/dev/null || { echo 'skipped: node is not here'; exit 0; }
work=$(mktemp -d "${TMPDIR:-/tmp}/iblbake-spectral-XXXXXX")
trap 'rm -rf "$work"' EXIT
few=$(((rounds + 3) / 4))

bake=("$program" -q)
sampled=("$program" -q --samples 1024 --method sampled)

# ---- what is measured ------------------------------------------------------

# time of NAME in the lines of turns: field 4 wall median, 5 fastest, 7 and 8
# CPU time, 10 and 11 what it said.
field() { awk -v name="$1" -v f="$2" '$1 == name { print $f }' "$work/times"; }

row() { # WHAT MEASURED BAR NOTE
    printf '%-54s %12s  %-15s %s\n' "$1" "$2" "$3" "${4:-}"
}

# ratio WHAT BAR A FIELD B FIELD [UP]: A over B by medians and by fastest runs;
# met where it is at most the bar, with UP at least.
ratio() {
    local a b least
    a=$(field "$3" "$4") b=$(field "$5" "$6")
    least=$(awk -v a="$(field "$3" $(($4 + 1)))" \
        -v b="$(field "$5" $(($6 + 1)))" 'BEGIN { printf "%.2f", a / b }')
    awk -v a="$a" -v b="$b" -v bar="$2" -v up="${7:-}" -v least="$least" \
        'BEGIN { r = a / b
            ok = up ? r >= bar : r <= bar
            printf "%.2f|%s|%.1f / %.1f ms, fastest %s\n", r,
                (up ? ">= " : "<= ") bar (ok ? " met" : " MISSED"), a, b,
                least }' >"$work/ratio"
    IFS='|' read -r value bar note <"$work/ratio"
    row "$1" "$value" "$bar" "$note"
}

# Content, level, texels, nRMSE and worst of each level of a bake.
levels() { # DIR
    "$program" verify -q --texels 400 "$env" "$1" --json "$work/levels.json"
    node -p "JSON.parse(fs.readFileSync('$work/levels.json')).levels.map(l =>
        [l.content, l.level, l.texels, l.nrmse, l.worst].join(' ')).join('\n')"
}
largest() { # FILE FIELD: of every level but the environment itself
    awk -v f="$2" '($1 != "specular" || $2 > 0) && $f > most { most = $f }
        END { print most }' "$1"
}
judge() { # WHAT VALUE BAR
    row "$1" "$2" "$(awk -v v="$2" -v b="$3" \
        'BEGIN { print "<= " b (v <= b ? " met" : " MISSED") }')"
}

row what measured bar
"${bake[@]}" --pixel rgba32f -o "$work/32" "$env"
"${bake[@]}" -o "$work/16" "$env"
"${sampled[@]}" --pixel rgba32f -o "$work/s" "$env"
levels "$work/32" >"$work/levels32"
levels "$work/16" >"$work/levels16"
levels "$work/s" >"$work/levels-s"
judge 'rgba32f: largest nRMSE of levels >= 1, irradiance' \
    "$(largest "$work/levels32" 4)" 1e-4
judge "rgba32f: largest relative error of $(awk \
    'n == "" || $3 < n { n = $3 } END { print n }' \
    "$work/levels32")+ texels a level" "$(largest "$work/levels32" 5)" 1e-3
judge 'rgba16f: largest nRMSE of levels >= 1, irradiance' \
    "$(largest "$work/levels16" 4)" 4e-4

if command -v cmgen >/dev/null; then
    mkdir "$work/cmgen"
    "$turns" "$few" ours "${bake[@]}" -o "$work/o" "$env" , \
        cmgen cmgen -q -f ktx -s 256 -x "$work/cmgen/env" "$env" \
        >"$work/times"
    ratio "cmgen / ours, $few rounds" 60 cmgen 4 ours 4 up
else
    row 'cmgen / ours' 'not here' '>= 60' 'Debian: libfilament-tools'
fi

"$turns" "$rounds" stb "$stb" "$env" , ours "${bake[@]}" -o "$work/o" "$env" , \
    sampled "${sampled[@]}" -o "$work/o2" "$env" >"$work/times"
ratio "ours / stb_image's decoding, $rounds rounds" 10 ours 4 stb 10
ratio "ours / sampled 1,024, $rounds rounds" 1 ours 4 sampled 4
paste -d ' ' "$work/levels-s" "$work/levels32" | awk \
    '($1 != "specular" || $2 > 0) && $1 != "irradiance" {
        r = $4 / $9
        if (least == "" || r < least) { least = r; level = $2 } }
    END { printf "%.0f %d\n", least, level }' >"$work/least"
read -r least level <"$work/least"
row 'nRMSE, sampled 1,024 / ours, least of all levels' "$least" \
    "$([ "$least" -ge 50 ] && echo '>= 50 met' || echo '>= 50 MISSED')" \
    "level $level"

oiiotool "$env" --resize 4096x2048 \
    --pattern constant:color=1,1,1 4096x2048 3 \
    --noise:type=gaussian:mean=0:stddev=0.005 --mul -o "$work/large.hdr"
"$turns" "$rounds" stb "$stb" "$work/large.hdr" , \
    two "${bake[@]}" -j 2 -o "$work/o" "$work/large.hdr" , \
    one "${bake[@]}" -j 1 -o "$work/o2" "$work/large.hdr" , \
    both bash -c '"$@" -o "$0/o3" "$0/large.hdr" &
        "$@" -o "$0/o4" "$0/large.hdr"; wait' "$work" "${bake[@]}" -j 1 \
    >"$work/times"
ratio "4 times as wide: ours / stb_image's decoding" 2 two 4 stb 10
# 1.7 where the machine gives two cores: two bakes with -j 1 at once say how
# much it gives.
two_cores=$(awk -v one="$(field one 4)" -v both="$(field both 4)" \
    'BEGIN { printf "%.2f", 2 * one / both }')
ratio "4 times as wide: -j 1 / -j 2; two cores give $two_cores" \
    "$(awk -v two="$two_cores" 'BEGIN { printf "%.2f", 0.85 * two }')" \
    one 4 two 4 up

"$turns" "$rounds" lut "$program" -q -j 1 --only lut -o "$work/o" \
    >"$work/times"
judge 'table of 256: CPU ms of the whole process' "$(field lut 7)" 10
table_error() { # DIR
    "$program" verify -q --lut "$1/brdf_lut.ktx2" --json "$work/lut.json"
    node -p "JSON.parse(fs.readFileSync('$work/lut.json')).lut.nrmse"
}
"$program" -q --only lut --pixel rgba32f -o "$work/l32"
judge 'table of 256, before rounding: rms error, to that of RG16F' \
    "$(table_error "$work/l32")" "$(table_error "$work/o")"

#!/bin/bash
# SPDX-License-Identifier: MIT
# iblbake beside Filament's cmgen and the classic tutorial: whole processes in
# turns (tests/bench_turns.c), their memory, and the error of what they leave as
# iblbake verify finds it. OUT/bench.csv has it, and gnuplot draws OUT/bench.svg.
#   bench-peers.sh [BUILD [ROUNDS [ENV [OUT]]]]
#                  build, 5, quarry_01_1k.hdr, BUILD/bench
# What is not here is left out.
set -eu
build=${1:-build}
rounds=${2:-5}
env=${3:-../shared/data/quarry_01_1k.hdr}
out=${4:-$build/bench}
program=$build/iblbake turns=$build/tests/bench_turns

for f in "$program" "$turns"; do
    [ -x "$f" ] || { echo "$f: not built: make all benches"; exit 1; }
done
[ -r "$env" ] || { echo "skipped: $env is not here"; exit 0; }
command -v node >/dev/null || { echo 'skipped: node is not here'; exit 0; }
mkdir -p "$out"
work=$(mktemp -d "${TMPDIR:-/tmp}/iblbake-peers-XXXXXX")
trap 'rm -rf "$work"' EXIT

commands=() names=()
add() { # NAME OPTION...
    names+=("$1")
    [ ${#commands[@]} = 0 ] || commands+=(,)
    commands+=("${1// /_}" "$program" -q -o "$work/${1// /_}" --name env "$env"
        "${@:2}")
}
add default
for n in 256 1024 4096; do
    add "sampled $n" --method sampled --samples $n
done
# cmgen's outputs: the same levels, mapping, packed floats in KTX and the sky,
# and our irradiance, table and harmonics besides.
add 'as cmgen' --size 256 --levels 5 --rotate -90 --format ktx \
    --pixel r11g11b10f --skybox 256
add tutorial --preset learnopengl
add 'tutorial without mips' --preset learnopengl --pdf-mip no
if command -v cmgen >/dev/null; then
    names+=(cmgen)
    mkdir "$work/cmgen"
    # It names its files after the directory.
    commands+=(, cmgen cmgen -q -f ktx -s 256 -x "$work/cmgen/env" "$env")
else
    echo 'skipped cmgen: it is not here (Debian: libfilament-tools)'
fi
"$turns" "$rounds" "${commands[@]}" >"$work/times"
for name in "${names[@]}"; do
    dir=$work/${name// /_}
    files=("$dir" --name env)
    [ "$name" != cmgen ] || files=(--specular "$dir/env/env_ibl.ktx"
        --roughness-map filament --rotate -90)
    "$program" verify -q --json "$dir.json" "$env" "${files[@]}"
done
cat >"$work/table.mjs" <<'END'
import fs from 'node:fs';
const [, , work, out, ...names] = process.argv;
const times = new Map(fs.readFileSync(work + '/times', 'utf8').trim().split('\n')
    .map(l => l.split(/\s+/)).map(f => [f[0], f]));
const row = (...c) => console.log(c.map((x, i) =>
    i ? String(x).padStart(11) : x.padEnd(24)).join(''));
row('', 'time ms', 'CPU ms', 'peak MiB', 'nRMSE %', 'p95 %');
const csv = ['name,wall_s,cpu_s,peak_bytes,nrmse,p95'];
for (const name of names) {
    const key = name.replaceAll(' ', '_'), t = times.get(key);
    const levels = JSON.parse(fs.readFileSync(`${work}/${key}.json`)).levels
        .filter(l => l.content === 'specular' && l.roughness > 0);
    const rms = Math.sqrt(levels.reduce((s, l) => s + l.nrmse ** 2, 0) /
        levels.length);
    const p95 = Math.max(...levels.map(l => l.p95));
    const [wall, cpu, peak] = [t[3], t[6], t.at(-1)];
    row(name, wall, cpu, peak, (100 * rms).toPrecision(3),
        (100 * p95).toPrecision(3));
    csv.push([name, wall / 1e3, cpu / 1e3, peak * 2 ** 20, rms, p95].join());
}
fs.writeFileSync(out + '/bench.csv', csv.join('\n') + '\n');
END
node "$work/table.mjs" "$work" "$out" "${names[@]}"
command -v gnuplot >/dev/null || exit 0
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
plot "$out/bench.csv" using "wall_s":"nrmse" with points pointtype 7, \\
    "" using "wall_s":"nrmse":"name" with labels offset 1 left
END
sed -i 's/[[:blank:]]*$//' "$out/bench.svg"

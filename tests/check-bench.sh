#!/bin/bash
# SPDX-License-Identifier: MIT
# iblbake bench on small bakes: reports that other programs read, errors that
# iblbake verify finds, too, peers that fail and hang, signals. BUILD names the
# build.
set -u
. tests/lib.sh
program=$build/iblbake
running=
trap 'kill $running 2>/dev/null; rm -rf "$work"' EXIT
mkdir "$work/tmp"
export TMPDIR=$work/tmp
# Nothing of a run is left in its directory.
nothing_left() { ls -A "$work/tmp"; }
# How long peers sleep that are to be killed: no other process does so long, and
# none of them ends by itself while it is looked for.
long=1000.$$
ended() { ! pgrep -xf "sleep $long"; }

# A name that has to be quoted everywhere.
env="$work/it's a sky.hdr"
sky=$top/data/sky.exr
${CC:-cc} -std=c11 -Itests -o "$work/mkenv" tests/cli/mkenv.c \
    tests/float_exr.c -lm && "$work/mkenv" hdr 128 64 >"$env"

# ---- a run with all reports ------------------------------------------------
# The peer is ourselves with the settings of the base, so its error is known.
"$program" bench -q "$env" --sizes 16,32 --samples 16,64 --threads 1,23 --isa c \
    --source-sizes 32,100 --rounds 4 --texels 24 --rendered 24 \
    --bake '--irradiance-size 8 --levels 3 --lut-size 16' \
    --variant 'two=--levels 2 --size 32 --lut-size 8' \
    --variant 'sheen=--method spectral --lobe charlie' \
    --variant 'turned=--method spectral --rotate 90' \
    --peer "self='$program' -q --size 16 --isa c -o {out} {env} \
        --lut-size 16 --irradiance-size 8 --levels 3" \
    --peer-output 'self={out} --name {name}' \
    --peer "true=dd if=/dev/zero of=/dev/null bs=1 count=200000 2>/dev/null;
        times >'$work/times'; true {other}" \
    --csv "$work/r.csv" --json "$work/r.json" --html "$work/r.html" \
    >"$work/table" 2>"$work/err"
status=$?
verdict run "$([ $status = 0 ] || echo "status $status: $(cat "$work/err")")"
verdict quiet "$(cat "$work/err")"
verdict run-left "$(nothing_left)"
for name in auto spectral 'sampled 16' 'sampled-nomip 64' 'auto, size 32' \
    'auto, threads 23' 'auto, source 100' two self true; do
    verdict "table: $name" "$(grep -qE "^[ *]$name  " "$work/table" ||
        echo 'no such row')"
done

# The same errors as iblbake verify finds in the same bake.
"$program" -q --size 16 --isa c -o "$work/out" "$env" \
    --lut-size 16 --irradiance-size 8 --levels 3
"$program" verify -q "$env" "$work/out" --texels 24 \
    --json "$work/verify.json"
"$program" verify -q --rendered --directions 24 "$env" "$work/out" \
    --json "$work/drawn.json"
if command -v node >/dev/null; then
    node - "$work" >"$work/node" 2>&1 <<'JS'
const fs = require('fs'), dir = process.argv[2];
const read = name => fs.readFileSync(`${dir}/${name}`, 'utf8');
const need = (ok, text) => { if (!ok) console.log(text); };
const j = JSON.parse(read('r.json'));
const point = name => j.points.find(p => p.name == name);

for (const p of j.points) {
    need(p.wall_s.rounds.length == 4, `${p.name}: rounds`);
    /* R's type 7 of four: at 0.75, 1.5 and 2.25 of the sorted values. */
    const t = [...p.wall_s.rounds].sort((a, b) => a - b);
    const is = (name, want) => need(
        Math.abs(p.wall_s[name] / want - 1) < 1e-9 && want > 0,
        `${p.name}: ${name} ${p.wall_s[name]} of ${t}`);
    is('q1', (t[0] + 3 * t[1]) / 4);
    is('median', (t[1] + t[2]) / 2);
    is('q3', (3 * t[2] + t[3]) / 4);
    need(p.peak_bytes > 1e5, `${p.name}: memory`);
    if (p.kind == 'peer') continue;
    let sum = 0;
    for (const s in p.stages_s) sum += p.stages_s[s].rounds[0];
    need(Math.abs(sum / p.wall_s.rounds[0] - 1) < 1e-6,
        `${p.name}: stages ${sum}`);
}
/* two methods, two by two samples, a size, a thread count, two sources, three
   variants, two peers; the base only once. */
need(j.points.length == 2 + 4 + 1 + 1 + 2 + 3 + 2, `${j.points.length} points`);
need(point('auto').sweeps.join() == 'method,size,threads,isa',
    `base: ${point('auto').sweeps}`);
need(point('sampled 16').sweeps.join() == 'method,samples',
    `sampled: ${point('sampled 16').sweeps}`);
need(point('sampled 16').samples == 16 && !('samples' in point('auto')),
    'samples');
/* What is exact is better than what is sampled. */
need(point('spectral').error < point('sampled 64').error / 10,
    `spectral: ${point('spectral').error}`);
/* Each is judged by its own lobe and rotation. */
for (const name of ['sheen', 'turned'])
    need(point(name).error < 1e-3, `${name}: ${point(name).error}`);
need(point('auto, source 100').source.height == 50, 'source height');
need(!('error' in point('true')), 'a peer without output has an error');
need(point('two').levels.filter(l => l.content == 'specular').length == 2,
    'levels of the variant');

const v = JSON.parse(read('verify.json'));
/* verify writes four digits. */
const same = (name, levels) => {
    const mine = point(name).levels.filter(l => l.content != 'lut');
    need(mine.length == levels.length, `${name}: ${mine.length} levels`);
    const close = (a, b) => Math.abs(a - b) <= 1e-3 * Math.abs(b);
    for (const what of ['nrmse', 'median', 'p95', 'worst', 'bias'])
        mine.forEach((l, i) => need(close(l[what], levels[i][what]),
            `${name} level ${i}: ${what} ${l[what]}, not ${levels[i][what]}`));
};
same('auto', v.levels);
same('self', v.levels);
same('auto, threads 23', v.levels);
const rough = v.levels.filter(l => l.content == 'specular' && l.roughness > 0);
const rms = Math.sqrt(rough.reduce((s, l) => s + l.nrmse ** 2, 0) /
    rough.length);
need(rough.length == 2, `${rough.length} rough levels`);
need(Math.abs(point('self').error / rms - 1) < 1e-3, `error, not ${rms}`);
const drawn_means = JSON.parse(read('drawn.json')).rendered.means;
need(drawn_means.length == 2, 'no means of what is rendered');
for (const name of ['self', 'auto'])
    need(Math.abs(point(name).rendered * 2 /
        (drawn_means[0].nrmse + drawn_means[1].nrmse) - 1) < 1e-3,
        `${name}: rendered ${point(name).rendered}`);
need(!('rendered' in point('sheen')), 'another lobe is judged as GGX');
for (const p of j.points.filter(p => 'error' in p)) {
    const p95 = p.levels.filter(l => l.content == 'specular' &&
        l.roughness > 0).map(l => l.p95);
    need(p.worst_p95 == Math.max(...p95), `${p.name}: p95 of ${p95}`);
}

/* The front, by its definition. */
const rivals = j.points.filter(p => 'error' in p && !p.source.resampled &&
    (p.kind != 'bake' || p.size == 16 && p.threads == 1));
for (const p of rivals)
    need(p.front == !rivals.some(q => q.error <= p.error &&
        q.wall_s.median <= p.wall_s.median &&
        (q.error < p.error || q.wall_s.median < p.wall_s.median)),
        `${p.name}: front ${p.front}`);
need(point('sampled 64').error < point('sampled-nomip 64').error,
    'lookups by density are no better');

/* The same bake leaves the same bytes, and what a shell says of its own time
   and of its children's is the system's, too. */
const bytes = fs.readdirSync(`${dir}/out`).reduce((s, name) =>
    s + fs.statSync(`${dir}/out/${name}`).size, 0);
need(point('self').output_bytes == bytes,
    `${point('self').output_bytes} bytes, not ${bytes}`);
const times = read('times').match(/[0-9.]+m[0-9.]+/g).reduce((s, t) =>
    s + t.split('m')[0] * 60 + Number(t.split('m')[1]), 0);
need(Math.abs(point('true').cpu_s.rounds.at(-1) - times) < 0.02 + times / 10,
    `${point('true').cpu_s.rounds.at(-1)} s, not ${times}`);

/* CSV: every line as many fields, names in quotes read back. */
const rows = read('r.csv').trimEnd().split('\n').map(line =>
    line.match(/("([^"]|"")*"|[^,]*)(,|$)/g).map(f => f.replace(/,$/, ''))
        .slice(0, -1));
const head = rows[0];
rows.forEach((r, i) => need(r.length == head.length ||
    r.length == head.length - 1, `line ${i}: ${r.length} fields`));
const column = name => head.indexOf(name);
/* A column for each stage, in the order of a bake. */
const staged = ['start', 'decode', 'level 0', 'specular 1', 'write', 'lut',
    'rest'].map(name => column(name + '_s'));
need(!staged.includes(-1), `stages: ${head}`);
need(['start', 'decode', 'level 0', 'specular 2', 'lut', 'rest'].every(
    (name, i, all) => !i || column(name + '_s') > column(all[i - 1] + '_s')),
    `order of stages: ${head}`);
const all = rows.filter(r => r[column('content')] == 'all');
need(all.length == j.points.length, `${all.length} lines for all`);
all.forEach((r, i) => {
    const p = j.points[i], {median, q1, q3} = p.wall_s;
    const want = {wall_s: median, wall_q1_s: q1, wall_q3_s: q3,
        cpu_s: p.cpu_s.median, peak_bytes: p.peak_bytes,
        output_bytes: p.output_bytes, p95: p.worst_p95 ?? 0,
        nrmse: p.error ?? 0, front: p.front ?? 0};
    for (const name in want)
        need(Math.abs(r[column(name)] - want[name]) <= 1e-8 * want[name],
            `${name} of ${p.name}: ${r[column(name)]}, not ${want[name]}`);
});
const lines = rows.filter(r => /^[a-z]/.test(r[column('content')]) &&
    !['all', 'content'].includes(r[column('content')]));
lines.forEach((r, i) => {
    const l = j.points.flatMap(p =>
        [...p.levels ?? [], ...p.rendered_rows ?? []])[i];
    for (const what of ['level', 'roughness', 'nrmse', 'median', 'p95', 'worst',
        'bias', 'f0'])
        need(Math.abs((r[column(what)] || 0) - (l[what] ?? 0)) <=
            1e-8 * Math.abs(l[what] ?? 0),
            `line ${i}: ${what} ${r[column(what)]}, not ${l[what]}`);
});
all.forEach((r, i) => {
    for (const s in j.points[i].stages_s ?? {})
        need(Math.abs(r[column(s + '_s')] - j.points[i].stages_s[s].median) <
            1e-8, `${s} of ${j.points[i].name}`);
});

/* The page holds the measurements, loads nothing, and draws them. */
const page = read('r.html');
need(!/https?:|src=|<link|<img|url\(|@import/.test(page), 'loads something');
const [, held] = page.match(/<script type="application\/json"[^>]*>([^]*?)<\//);
need(JSON.stringify(JSON.parse(held)) == JSON.stringify(j), 'other data');
const [, script] = page.match(/<script>([^]*?)<\/script>/);
const main = {};
new Function('document', script)({getElementById: () => ({textContent: held}),
    querySelector: () => main});
const drawn = main.innerHTML;
const open = [];
for (const [tag, slash, name, rest] of
    drawn.matchAll(/<(\/?)([a-z0-9]+)([^>]*)>/g)) {
    if (slash) need(open.pop() == name, `unexpected ${tag}`);
    else if (!rest.endsWith('/')) open.push(name);
}
need(open.length == 0, `not closed: ${open}`);
need(!/NaN|undefined|Infinity/.test(drawn), 'a number that is none');
/* As many points as there are rivals, at places that go with logarithms, and
 * rings around the front. */
const [, chart] = drawn.match(/against time<\/h3>\n<svg([^]*?)<\/svg>/);
const keys = new Set(rivals.map(p => p.kind == 'bake' ? p.method : p.name)).size + 1;
const dots = [...chart.matchAll(/<circle r="4" cx="([^"]*)" cy="([^"]*)"/g)]
    .slice(keys).map(([, x, y]) => [+x, +y]);
need(dots.length == rivals.length, `${dots.length} points`);
const shown = [];
for (const name of new Set(rivals.map(p => p.kind == 'bake' ? p.method : p.name)))
    shown.push(...rivals.filter(p =>
        (p.kind == 'bake' ? p.method : p.name) == name));
const marks = dots.map(([x, y], i) =>
    [Math.log(shown[i].wall_s.median), Math.log(shown[i].error), x, y]);
for (const [value, at, sign] of [[0, 2, 1], [1, 3, -1]]) {
    marks.sort((a, b) => a[value] - b[value]);
    const first = marks[0], last = marks.at(-1);
    need(sign * (last[at] - first[at]) > 100, 'a plot is upside down');
    for (const m of marks)
        need(Math.abs((m[value] - first[value]) / (last[value] - first[value]) *
            (last[at] - first[at]) + first[at] - m[at]) < 2, `mark ${m}`);
}
need(chart.split('class="front"').length - 1 ==
    rivals.filter(p => p.front).length, 'rings');
for (const title of ['Error against time', 'Rendered error against time',
    'Error against roughness',
    'Time against samples', 'Time against output size',
    'Time against source size', 'Time against threads', 'Stages'])
    need(drawn.includes(`<h3>${title}</h3>`), `no ${title}`);
/* A row of the summary: the figures of the JSON in three digits. */
const unit = {s: 1, ms: 1e-3, 'µs': 1e-6, '%': 1e-2, MiB: 2 ** 20};
for (const p of j.points.filter(p => !p.source.resampled)) {
    const row = drawn.split('<tr').find(r =>
        r.match(/<td>([^<]*)/)?.[1].trim() == p.name) ?? '';
    const cells = [...row.matchAll(/<td>([-0-9.e]+).(s|ms|µs|%|MiB)<\/td>/g)]
        .map(c => c[1] * unit[c[2]]);
    const want = [p.wall_s.median, p.wall_s.q1, p.wall_s.q3, p.cpu_s.median,
        p.peak_bytes, p.error, p.worst_p95, p.rendered].filter(x => x !== undefined);
    need(cells.length == want.length && cells.every((c, i) =>
        Math.abs(c / want[i] - 1) < 0.06),
        `row of ${p.name}: ${cells}, not ${want}`);
    need(!!p.front == row.startsWith(' class="front"'), `${p.name} in bold`);
}
for (const s in point('two').stages_s)
    need(drawn.includes(`<tr><td>${s}</td>`), `no row of stage ${s}`);
for (const word of [j.machine.cpu, j.machine.compiler, j.date])
    need(word && drawn.includes(word), `does not name ${word}`);
JS
    verdict reports "$(cat "$work/node")"
else
    verdict reports "$(have node)"
fi
# Every combination, but of samples only with methods that take them.
# Without sidecars, which have the times of stages.
"$program" bench -q --full "$env" --methods spectral,sampled --samples 4,16 \
    --sizes 8,16 --threads 1 --isa c --source-sizes none --rounds 1 --texels 0 \
    --bake "--only specular" \
    --json "$work/full.json" >"$work/table" 2>&1
verdict full "$([ "$(grep -c '"kind": "bake"' "$work/full.json")" = 6 ] ||
    cat "$work/table")"

# Every pixel format: its bytes by the header that they share and the blocks of
# its levels, 8x8 and 4x4 texels; what it loses.
"$program" bench -q --formats "$env" --methods auto --sizes 8 --threads 1 \
    --isa c --source-sizes none --rounds 1 --texels 24 --bake '--levels 2' \
    --json "$work/formats.json" --html "$work/formats.html" \
    >"$work/table" 2>&1
if command -v node >/dev/null; then
    cat >"$work/formats.cjs" <<'JS'
const fs = require('fs'), [, , dir] = process.argv;
const need = (ok, what) => ok || console.log(what);
const {points} = JSON.parse(fs.readFileSync(`${dir}/formats.json`));
const formats = points.filter(p => p.kind == 'format');
const names = formats.map(p => p.name);
for (const [name, block, bytes] of [['rgba16f', 1, 8], ['rgba32f', 1, 16],
    ['rgb9e5', 1, 4], ['r11g11b10f', 1, 4], ['bc6h', 4, 16],
    ['uastc-hdr', 4, 16], ['astc4x4hdr', 4, 16]]) {
    const p = formats.find(p => p.name == name);
    const texels = 6 * ((8 / block) ** 2 + (4 / block) ** 2) * bytes;
    need(p && p.specular_bytes > texels && p.specular_bytes < texels + 2000,
        `${name}: ${p?.specular_bytes} bytes`);
    const {nrmse, relative} = p.pixel_error;
    need(block == 4 ? nrmse > 1e-3 && nrmse < .1 && p.whole_error < .15
        : name == 'rgba32f' ? nrmse == 0 && relative == 0
        : nrmse > 0 && nrmse < .01, `${name}: off by ${nrmse}, ${relative}`);
    const packed = formats.find(q => q.name == `${name} zstd`);
    need(packed.specular_bytes < p.specular_bytes &&
        packed.pixel_error.nrmse == nrmse, `${name} zstd: other texels`);
}
need(['bc6h fast', 'bc6h best', 'uastc-hdr fast', 'uastc-hdr best'].every(n =>
    names.includes(n)) && names.length == 18, `${names}`);
need(points.every(p => p.kind == 'format' ? !p.rival && !p.front : p.base),
    'formats among rivals');
const page = fs.readFileSync(`${dir}/formats.html`, 'utf8');
const [, held] = page.match(/<script type="application\/json"[^>]*>([^]*?)<\//);
const [, script] = page.match(/<script>([^]*?)<\/script>/);
const main = {};
new Function('document', script)({getElementById: () => ({textContent: held}),
    querySelector: () => main});
const dots = what => main.innerHTML.split(`against ${what}, by pixel format`)[1]
    .split('</svg>')[0].split('<circle r="4"').length - 1;
need(dots('bytes') == 20 && dots('time') == 20, 'points of the plots');
need(!/NaN|undefined|Infinity/.test(main.innerHTML), 'a number that is none');
const table = fs.readFileSync(`${dir}/table`, 'utf8').split(' formats')[1] ?? '';
for (const p of formats)
    need(table.includes(` ${p.name} `), `no line of ${p.name}`);
JS
    verdict formats "$(node "$work/formats.cjs" "$work")"
fi

# ---- what goes wrong -------------------------------------------------------
small=(-q --sizes 8 --samples 1 --methods sampled --threads 1 --isa c
    --source-sizes none --rounds 1 --texels 0)
wrong() { # NAME STATUS GLOB ARGUMENTS: one line, no report, nothing left
    picked "$1" || return
    verdict "$1" "$(cd "$work/tmp" && refused "$2" "$3" "$program" bench \
        "${small[@]}" --csv no.csv "${@:4}")"
}
wrong fails 1 'iblbake: peer bad: exit status 3: no luck' \
    "$sky" --peer 'bad=echo trying; echo no luck >&2; exit 3'
wrong missing 1 'iblbake: peer bad: exit status 127: *not found*' \
    "$sky" --peer 'bad=no-such-program {env}'
wrong killed 1 'iblbake: peer bad: killed by signal 9' \
    "$sky" --peer 'bad=kill -9 $$'
wrong hangs 1 'iblbake: peer slow: no end within 2 s: *--timeout*' \
    "$sky" --timeout 2 --peer "slow=sleep $long & sleep $long; true"
verdict 'hangs: nothing runs on' "$(within ended || echo 'something does')"
wrong no-output 1 'iblbake: *cannot be opened*' "$sky" --texels 24 \
    --peer 'none=true' --peer-output 'none=--specular {out}/x.ktx'
wrong bake-option 1 'iblbake: bake sampled 1: exit status 2: *--levels*' \
    "$sky" --bake '--levels 9'
wrong no-map 1 'iblbake: none.exr: *' none.exr
wrong report 1 'iblbake: *none/x.json: cannot be written*' "$sky" \
    --json "$work/none/x.json"
wrong swept 2 'iblbake: --bake --size=4: --size is set by*' "$sky" \
    --bake --size=4
wrong placed 2 'iblbake: --variant -ox: -o is set by*' "$sky" \
    --variant v=-ox
wrong method 2 'iblbake: --methods magic: not a value*' "$sky" \
    --methods magic
wrong no-peer 2 'iblbake: --peer-output x=*: there is no --peer*' \
    "$sky" --texels 24 --peer-output x=y
wrong peer-arguments 1 'iblbake: --bogus: unknown option*' "$sky" \
    --texels 24 --peer x=true --peer-output 'x=--bogus {out}'
wrong stdin 2 'iblbake: -: standard input*' -
wrong nothing 2 'iblbake: no environment*'

# ---- signals ---------------------------------------------------------------
# As at a terminal (the whole group gets it), and sent to the program alone.
begun() { ls "$work"/tmp/*/*/begun; }
removed() { [ -z "$(nothing_left)" ]; }
stopped() { # NAME SIGNAL WHOM
    picked "$1" || return
    # A job in the background of a script would ignore INT.
    setsid env --default-signal=INT "$program" bench "${small[@]}" "$sky" \
        --peer "long=touch {out}/begun; sleep $long" >"$work/out.txt" 2>&1 &
    local pid=$! status
    running=$pid
    within begun
    kill "-$2" -- "$3$pid"
    wait $pid
    status=$?
    running=
    verdict "$1: dies of it" "$([ $status = $((128 + $(kill -l "$2"))) ] ||
        echo "status $status: $(cat "$work/out.txt")")"
    verdict "$1: left" "$(within removed || nothing_left)"
    verdict "$1: nothing runs on" "$(within ended || echo 'something does')"
}
stopped ctrl-c INT -
stopped term TERM ''
end

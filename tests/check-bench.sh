#!/bin/bash
# SPDX-License-Identifier: MIT
# iblbake bench on a small map: the errors that iblbake verify finds, reports
# that other programs read, a page that can be read. BUILD names the build.
set -u
. tests/lib.sh
program=$build/iblbake
mkdir "$work/tmp"

# A name that has to be quoted everywhere.
env="$work/it's a \"sky\", dark.hdr"
${CC:-cc} -std=c11 -Itests -o "$work/mkenv" tests/cli/mkenv.c \
    tests/float_exr.c -lm && "$work/mkenv" hdr 64 32 >"$env"
few='--texels 24 --directions 48'

for group in size irradiance-step; do
    rounds=1
    [ $group != size ] || rounds=3
    # shellcheck disable=SC2086
    "$program" bench -q $few --rounds $rounds --only $group "$env" --csv "$work/$group.csv" \
        --html "$work/$group.html" \
        >"$work/$group.txt" 2>"$work/err"
    status=$?
    verdict "$group" "$(is 0 $status status)" \
        "$(cat "$work/err")"
done

# The same errors as iblbake verify finds in the same bake.
"$program" -q -o "$work/out" --name env "$env"
"$program" verify -q "$env" "$work/out" --name env --texels 24 \
    --json "$work/verify.json"
"$program" verify -q --rendered --directions 48 "$env" "$work/out" --name env \
    --json "$work/drawn.json"
if command -v node >/dev/null; then
    node - "$work" >"$work/node" 2>&1 <<'JS'
const fs = require('fs'), dir = process.argv[2];
const read = name => fs.readFileSync(`${dir}/${name}`, 'utf8');
const need = (ok, text) => { if (!ok) console.log(text); }; // wanted and found
const close = (a, b, text, slack = 1e-3) =>
    need(Math.abs(a - b) <= slack * Math.abs(b), `${text}: found ${a}, wanted ${b}`);
const figures = ['time_s', 'bytes', 'specular', 'irradiance', 'table', 'metals',
    'dielectrics'];

/* The lines of CSV, every one with as many fields, as objects. */
const lines = group => {
    const [head, ...rows] = read(group + '.csv').trimEnd().split('\n').map(
        line => [...line.matchAll(/(?:^|,)("(?:[^"]|"")*"|[^,]*)/g)].map(f => f[1]));
    return rows.map((r, i) => {
        need(r.length === head.length, `${group} line ${i}: found ${r.length} fields, wanted ${head.length}`);
        const s = Object.fromEntries(head.map((name, k) => [name, r[k]]));
        for (const name of figures)
            s[name] = s[name] && ['', '_low', '_high'].map(e => Number(s[name + e]));
        return s;
    });
};
const {levels, lut} = JSON.parse(read('verify.json'));
const {rendered} = JSON.parse(read('drawn.json'));
const mean = list => list.reduce((a, b) => a + b) / list.length;
const usual = lines('size').find(s => s.group === 'preset');
close(usual.specular[0], mean(levels.filter(l => l.content === 'specular' &&
    l.roughness > 0).map(l => l.nrmse)), 'levels');
close(usual.irradiance[0], levels.find(l => l.content === 'irradiance').nrmse,
    'irradiance');
close(usual.table[0], lut.nrmse, 'table');
const drawn = f0 => rendered.means.find(m => m.f0 === f0).nrmse;
close(usual.metals[0], drawn(1), 'metals');
close(usual.dielectrics[0], drawn(.04), 'dielectrics');

/* A grid of irradiance shows in irradiance. */
const of = (group, value) => lines(group)
    .find(s => s.group === group && s.value === value);
need(of('irradiance-step', '.2').irradiance[0] > .1 &&
    of('irradiance-step', '.025').irradiance[0] < .02 &&
    !of('irradiance-step', '.2').specular, 'irradiance by steps: wanted above .1 and ' +
    `below .02, found ${JSON.stringify(['.2', '.025'].map(v => of('irradiance-step', v)))}`);

for (const group of ['size', 'irradiance-step']) {
    const settings = lines(group);
    const [first, ...rest] = settings;
    need(first.value === 'none' && rest.every(s => s.group === group &&
        s.options.endsWith(`--${group} ${s.value}"`)), `wanted none, then each --${group}, found ${settings.map(s => s.options)}`);
    for (const s of settings) {
        need(s.map.endsWith('""sky"", dark.hdr"'), `found ${s.map}, wanted ""sky"", dark.hdr`);
        for (const name of figures.filter(f => s[f]))
            need(s[name][1] <= s[name][0] && s[name][0] <= s[name][2],
                `${s.value}: found ${name} ${s[name]}, wanted it between the last two`);
    }
    const text = read(group + '.txt');
    need(text.includes(`; ${group === 'size' ? 3 : 1} rounds\n`), `wanted a word of rounds, found ${text}`);
    for (const s of settings)
        need(new RegExp(`^${s.group} +${s.value} `, 'm').test(text),
            `wanted a line of ${s.group} ${s.value}, found ${text}`);

    /* The page holds the lines, loads nothing, and draws them. */
    const page = read(group + '.html');
    const loads = /https?:|src=|<link|<img|url\(|@import/.exec(page);
    need(!loads, `wanted nothing loaded, found ${loads}`);
    const [, escaped] = page.match(/<pre[^>]*>([^]*?)<\/pre>/);
    const held = escaped.replace(/&lt;/g, '<').replace(/&amp;/g, '&');
    need(held === read(group + '.csv'), `wanted the lines of ${group}.csv, found ${held}`);
    const [, script] = page.match(/<script>([^]*?)<\/script>/), main = {};
    new Function('document', script)({getElementById: () =>
        ({textContent: held}), querySelector: () => main});
    const html = main.innerHTML, open = [];
    for (const [tag, slash, name, more] of
        html.matchAll(/<(\/?)([a-z0-9]+)([^>]*)>/g))
        if (slash) need(open.pop() === name, `wanted the end of what is open, found ${tag}`);
        else if (!more.endsWith('/')) open.push(name);
    need(!open.length, `wanted an end of each, found ${open} open`);
    need(!/NaN|undefined|Infinity/.test(html), `wanted numbers, found ${/.{20}(NaN|undefined|Infinity)/.exec(html)}`);
    const title = {'size': 'As rendered, by bytes',
        'irradiance-step': 'Irradiance'}[group];
    const figure = html.split('<figure>').find(f => f.includes(`>${title}<`));
    if (!figure) {
        console.log(`wanted a plot of ${title}, found none`);
        continue;
    }
    const points = figure.match(/<circle r="4"/g) ?? [];
    need(points.length >= rest.length, `${title}: found ${points.length} points, wanted ${rest.length}`);
    for (const s of rest)
        need(figure.includes(`>${s.value}</text>`), `${title}: wanted ${s.value}, found ${figure}`);
}
JS
    verdict reports "$(cat "$work/node")"
else
    verdict reports "$(have node)"
fi

# ---- what goes wrong -------------------------------------------------------
wrong() { # NAME STATUS GLOB ARGUMENTS: one line, no report, nothing left
    picked "$1" || return
    # shellcheck disable=SC2086
    verdict "$1" "$(cd "$work/tmp" && refused "$2" "$3" "$program" bench -q \
        $few --rounds 1 --only lut-samples --csv no.csv "${@:4}")"
}
wrong no-map 1 'iblbake: none.exr: *' none.exr
wrong second-map 1 'iblbake: none.exr: *' "$env" none.exr
wrong report 1 'iblbake: *none/x.html: cannot be written*' "$env" \
    --html "$work/none/x.html"
wrong both 1 'iblbake: *: is both input and output*' "$env" --html "$env"
wrong stdin 2 'iblbake: -: *standard input*' -
wrong nothing 2 'iblbake: no map*'
end

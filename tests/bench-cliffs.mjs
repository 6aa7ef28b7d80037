// SPDX-License-Identifier: MIT
// node tests/bench-cliffs.mjs [BUILD]
//
// Looks for cliffs: sweeps one setting of a bake at a time and prints processor
// time and peak memory. Work is pixels read plus texels written; a cell is
// marked where its time a unit of work is more than 3 times that of both
// neighbours (in a list without an order: of the median), beyond 10 ms.
import {spawnSync} from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';

const build = process.argv[2] ?? 'build';
if (!fs.existsSync(path.join(build, 'tests/bench_turns'))) {
    console.error(`${build}/tests/bench_turns: not built: make all benches`);
    process.exit(1);
}
const work = fs.mkdtempSync(path.join(os.tmpdir(), 'cliffs-'));
process.on('exit', () => fs.rmSync(work, {recursive: true, force: true}));

// A map of blocks of 16 x 1 pixels, each of its own brightness.
function makeMap(width) {
    const name = path.join(work, `${width}.hdr`);
    if (fs.existsSync(name)) return name;
    const file = fs.openSync(name, 'w');
    let seed = width;
    fs.writeSync(file, '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n' +
        `-Y ${width / 2} +X ${width}\n`);
    for (let y = 0; y < width / 2; y++) {
        const row = [2, 2, width >> 8, width & 255];
        for (let part = 0; part < 4; part++)
            for (let x = 0; x < width; x += 16) {
                seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
                const byte = part < 3 ? 64 + (seed >>> 25) : 126 + (seed >>> 30);
                row.push(128 + Math.min(16, width - x), byte);
            }
        fs.writeSync(file, Buffer.from(row));
    }
    fs.closeSync(file);
    return name;
}

function measure(width, options) {
    const out = path.join(work, 'out');
    const made = spawnSync(path.join(build, 'tests/bench_turns'), ['1', 'bake',
        path.join(build, 'iblbake'), '-q', makeMap(width), '-o', out,
        ...options], {encoding: 'utf8'});
    if (made.status !== 0) return null;
    const words = made.stdout.split(/\s+/);
    const bytes = fs.readdirSync(out).reduce((sum, name) =>
        sum + fs.statSync(path.join(out, name)).size, 0);
    fs.rmSync(out, {recursive: true});
    return {ms: Number(words[6]), mib: Number(words[words.indexOf('peak') + 1]),
        work: width * width / 2 + bytes / 8};
}

let marked = 0;
const median = list => [...list].sort((a, b) => a - b)[list.length >> 1];
const start = measure(64, ['--only', 'irradiance']).ms;
function sweep(title, ordered, cells) {
    console.log(`\n${title.padEnd(34)}  CPU ms   peak MiB   ns a unit`);
    const rows = cells.map(([name, width, options]) =>
        ({name, ...measure(width, options)})).filter(row => row.ms);
    const unit = rows.map(r => Math.max(r.ms - start, 0) / r.work);
    rows.forEach((r, i) => {
        const near = ordered ? [unit[i - 1], unit[i + 1]].filter(x => x >= 0) :
            [median(unit)];
        const mark = r.ms > start + 10 && unit[i] > 3 * Math.max(...near);
        marked += mark;
        console.log(`${r.name.padEnd(32)}${r.ms.toFixed(0).padStart(10)}` +
            `${r.mib.toFixed(0).padStart(11)}` +
            `${(unit[i] * 1e6).toFixed(0).padStart(12)}${mark ? '  CLIFF' : ''}`);
    });
}

const doubled = (from, to) =>
    Array.from({length: Math.log2(to / from) + 1}, (_, i) => from << i);
const of = (option, values, ...more) => values.map(value =>
    [`${option} ${value}`, 1024, [option, String(value), ...more]]);
for (const width of [512, 1024])
    sweep(`size, from a map ${width} wide`, true, doubled(16, 4096).map(size =>
        [`--size ${size}`, width, ['--size', String(size)]]));
sweep('width of the map', true, doubled(64, 16384).map(width =>
    [`${width}`, width, []]));
sweep('levels of 512', true, of('--levels', [1, 2, 3, 4, 5, 6, 7, 8, 9],
    '--size', '512'));
sweep('tolerance', true, of('--tolerance', ['1e-1', '1e-2', '1e-3', '1e-4',
    '1e-5']));
sweep('least roughness', true, ['.5', '.2', '.1', '.08', '.05', '.03', '.02']
    .map(r => [r, 1024, ['--roughness-range', `${r}:1`]]));
sweep('lobe', false, of('--lobe', ['ggx', 'charlie', 'phong'],
    '--lobe-table', 'no'));
sweep('mapping', false, of('--mapping', ['filament', 'linear', 'babylon']));
sweep('layout', false, of('--layout', ['cube', 'equirect', 'octahedral']));
sweep('method', false, of('--method', ['spectral', 'auto']));
sweep('samples', true, of('--samples', doubled(16, 1024), '--method',
    'sampled'));
console.log(`\n${marked} marked`);

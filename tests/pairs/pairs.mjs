// SPDX-License-Identifier: MIT
// node tests/pairs/pairs.mjs BUILD [--seed N] [--seconds S] [--write]
//                            [--more] [--alone] [--light] [--with OPTION]
//                            [COMMAND...]
//
// Runs every pair of values of the options of bake, verify, probes and view, as
// their --help lists them, in rows of some options each, and judges each run by
// the laws below. Rows that are refused shrink to their smallest conflict, which
// refused.txt has with its message: other rows avoid it, and it is run by
// itself. --write writes that list anew, with --more it adds to it. --alone tries
// what each option changes by itself. --light looks for crashes and refusals
// alone, --with for pairs with one option, --seconds ends after so long.
// JOBS runs are made at once. The last line is "N passed, N failed".
import {spawn, spawnSync} from 'node:child_process';
import {createHash} from 'node:crypto';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import {fileURLToPath} from 'node:url';
import {commands, ends} from './values.mjs';
import {makeInputs} from './inputs.mjs';

const flags = {}, wanted = [];
const [build, ...rest] = process.argv.slice(2);
for (let i = 0; i < rest.length; i++)
    if (/^--(seed|seconds)$/.test(rest[i]))
        flags[rest[i].slice(2)] = Number(rest[++i]);
    else if (rest[i] === '--with') flags.with = rest[++i];
    else if (rest[i].startsWith('--')) flags[rest[i].slice(2)] = true;
    else wanted.push(rest[i]);
const listName = fileURLToPath(new URL('refused.txt', import.meta.url));
const bin = path.resolve(build);
const work = fs.mkdtempSync(path.join(os.tmpdir(), 'pairs-'));
process.on('exit', () => fs.rmSync(work, {recursive: true, force: true}));
process.on('SIGINT', () => process.exit(130));
process.on('SIGTERM', () => process.exit(143));
let seed = flags.seed ?? 1, passed = 0, failed = 0, runs = 0;
const random = n => { // below n
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    return Math.floor(seed / 2 ** 32 * n);
};
const shuffled = list => {
    for (let i = list.length; i > 1;) {
        const k = random(i--);
        [list[i], list[k]] = [list[k], list[i]];
    }
    return list;
};
const began = Date.now(), seconds = () => (Date.now() - began) / 1000;
let end = Infinity;
function fail(what) {
    failed++;
    console.log('FAILED: ' + what);
}

// ---- running ----------------------------------------------------------------

const env = {...process.env};
delete env.LD_LIBRARY_PATH;
delete env.DISPLAY;
delete env.WAYLAND_DISPLAY;
let free = Number(process.env.JOBS) || os.availableParallelism();
const waiting = [];
// Runs a program in a directory, which it makes unless there is one.
async function run(program, words, dir = path.join(work, 'r' + runs)) {
    runs++;
    while (free === 0) await new Promise(go => waiting.push(go));
    free--;
    fs.mkdirSync(dir, {recursive: true});
    const input = fs.openSync(path.join(work, 'mild.exr'));
    // A minute of processors' time, however busy the machine is.
    const child = spawn('bash', ['-c', 'ulimit -t 60; exec "$@"', '-',
        path.join(bin, program), ...words],
        {cwd: dir, stdio: [input, 'pipe', 'pipe'], env});
    fs.closeSync(input);
    const out = ['', ''];
    [child.stdout, child.stderr].forEach((pipe, k) =>
        pipe.setEncoding('utf8').on('data', text => { out[k] += text; }));
    const late = setTimeout(() => child.kill('SIGKILL'), 600000);
    const [status, signal] = await new Promise(done =>
        child.on('close', (...how) => done(how)));
    clearTimeout(late);
    free++;
    waiting.shift()?.();
    const crash = signal ? /XCPU|KILL/.test(signal) ? 'takes a minute' : signal :
        /Sanitizer|runtime error/.test(out[1]) ? out[1].slice(0, 2000) :
        ![0, 1, 2].includes(status) ? `status ${status}` : '';
    return {dir, status, crash, out: out[0], err: out[1]};
}
const remove = r => fs.rmSync(r.dir, {recursive: true, force: true});
// What a run left: names with hashes of the bytes. The sidecar's times, and for
// `plain` the options that it repeats, are no part of them.
function files(dir, plain) {
    const found = new Map();
    for (const entry of fs.readdirSync(dir, {recursive: true,
        withFileTypes: true})) {
        const name = path.join(entry.parentPath ?? entry.path, entry.name);
        if (!entry.isFile() || name.includes('/.iblbake/')) continue;
        let bytes = fs.readFileSync(name);
        if (name.endsWith('.json'))
            bytes = bytes.toString().replace(/"timings[^]*?\}/, '')
                .replace(plain ? /"options": \{[^]*?\}/ : '', '');
        found.set(path.relative(dir, name),
            createHash('md5').update(bytes).digest('hex'));
    }
    return found;
}
const differ = (a, b) => [...new Set([...a.keys(), ...b.keys()])]
    .filter(name => a.get(name) !== b.get(name));

// ---- options and their values -----------------------------------------------

function table(help, values) {
    const options = new Map();
    const rows = help.matchAll(
        /^  (?:-\w, |    )--([a-z0-9-]+)(?: (\S+))?((?:.*\n)(?:  {25}.*\n)*)/gm);
    for (const [, name, value, text] of rows) {
        if (ends.includes(name)) continue;
        const words = text.replace(/\s+/g, ' ').trim();
        const [allowed, standard] =
            (/\(([^()]*)\)$/.exec(words)?.[1] ?? '').split('; default ');
        const range = /^(\S+) to (\S+)$/.exec(allowed);
        const takes = /^[A-Z]/.test(value ?? '');
        let list = values[name];
        if (!list && !takes) list = [''];
        if (!list && range) {
            const [low, high] = [Number(range[1]), Number(range[2])];
            list = [low, high, Number(standard), (low + high) / 2 | 0];
        }
        if (!list && / or /.test(allowed)) list = allowed.split(/, | or /);
        if (!list || list.some(v => v !== v))
            fail(`--${name}: has no values to try: add them to values.mjs`);
        else
            options.set(name, {takes, values: [...new Set(list.map(String))]});
    }
    for (const name in values)
        if (name !== 'ENV' && !options.has(name))
            fail(`--${name}: is no option: take it out of values.mjs`);
    if (values.ENV) options.set('ENV', {env: true, values: values.ENV});
    return options;
}
// The command line of a row: {NAME: VALUE}.
// missing: its inputs are not there, so that what is not refused ends soon.
function line(cmd, row, {without, more = [], missing} = {}) {
    const own = [], others = [], added = [], env = [], inputs = [];
    for (const [name, value] of Object.entries(row)) {
        const option = cmd.options.get(name);
        const words = value.split(' ').filter(w => w);
        const mine = option.env ? [] : ['--' + name];
        if (option.takes) mine.push(words.shift());
        if (name !== without) own.push(...mine);
        while (words.length) {
            const word = words.shift(), other = word.slice(2);
            if (!word.startsWith('--')) {
                if (word.startsWith('+')) added.push(word.slice(1));
                else (option.env ? env : inputs).push(word);
                continue;
            }
            const pair = cmd.options.get(other)?.takes === false ? [word] :
                [word, words.shift()];
            if (!(other in row) && !others.includes(word)) others.push(...pair);
        }
    }
    // One input, that of ENV before any other, and what is added to it.
    const places = env.length ? env : inputs.length ? inputs.slice(0, 1) :
        cmd.env.split(' ');
    places.push(...added.filter((p, i) => !places.includes(p) &&
        added.indexOf(p) === i));
    if (missing) places.fill('../missing.exr');
    const all = [...cmd.words, ...others, ...own, ...more, ...places];
    if (cmd.page[0] === 'iblview') {
        if (!/--(offscreen|contact-sheet)/.test(all.join(' ')))
            all.push('--offscreen', 'p.png');
        if (!all.includes('--size')) all.push('--size', '40x40');
    }
    return [...all, ...cmd.tail.split(' ').filter(w => w)];
}
const places = words =>
    words.filter(w => /^\.\..*\.(exr|hdr|ktx2)$/.test(w));
const told = (cmd, row, how) =>
    [cmd.page[0], ...line(cmd, row, how)].join(' ');

// ---- laws -------------------------------------------------------------------

const formats = {rgba16f: 97, rgba32f: 109, rg16f: 83, rg32f: 103,
    rgb9e5: 123, r11g11b10f: 122, bc6h: 143,
    'uastc-hdr': 1000066000, astc4x4hdr: 1000066000};
// What a KTX2 file is not that the sidecar says; texels that are not finite.
function judgeTexture(bytes, o) {
    const u32 = at => bytes.readUInt32LE(at);
    const want = [formats[o.pixel], o.width, o.height, o.faces,
        Math.max(o.levels?.length ?? 1, 1)];
    const got = [12, 20, 24, 36, 40].map(u32);
    if (String(got) !== String(want)) return `is ${got}, not ${want}`;
    if (u32(44) || !/f$/.test(o.pixel) || /^r11/.test(o.pixel)) return '';
    const half = /16f/.test(o.pixel);
    const mask = half ? 0x7c00 : 0x7f800000;
    for (let l = 0; l < got[4]; l++) {
        const from = Number(bytes.readBigUInt64LE(80 + 24 * l));
        const to = from + Number(bytes.readBigUInt64LE(88 + 24 * l));
        for (let at = from; at < to; at += half ? 2 : 4)
            if (((half ? bytes.readUInt16LE(at) : u32(at)) & mask) === mask)
                return `level ${l} is not finite`;
    }
    return '';
}
function* sidecars(dir) {
    for (const name of files(dir).keys())
        if (name.endsWith('.json')) {
            const json = JSON.parse(fs.readFileSync(path.join(dir, name)));
            if (json.outputs) yield [path.dirname(name), name, json];
        }
}
// Files are as their sidecar says.
function judgeFiles(dir, row) {
    const left = new Set(files(dir).keys());
    const index = path.join(dir, 'out/index.json');
    if (fs.existsSync(index)) { // of probes
        const named = fs.readFileSync(index, 'utf8')
            .match(/"[^"/]+\.(ktx2?|dds)"/g).map(s => s.slice(1, -1)).sort();
        const there = [...left].map(f => path.basename(f))
            .filter(f => f !== 'index.json').sort();
        return String([...new Set(named)]) === String(there) ? '' :
            `sidecar: the index names ${named}, not ${there}`;
    }
    if ('only' in row && !/json/.test(row.only)) return '';
    for (const [at, name, json] of sidecars(dir)) {
        left.delete(name);
        for (const o of json.outputs) {
            const stem = path.join(at, o.file.replace(/gltf$/, ''));
            const names = [o.file, ...o.container !== 'gltf' ? [] :
                [...left].filter(f => f.startsWith(stem.slice(0, -1) + '_') &&
                    /_[pn][xyz]\.png$/.test(f)).map(f => path.relative(at, f))];
            let bytes = Buffer.alloc(0);
            for (const file of names) {
                const whole = path.join(at, file);
                left.delete(whole);
                if (!fs.existsSync(path.join(dir, whole)))
                    return `sidecar: ${whole} is not there`;
                bytes = Buffer.concat([bytes,
                    fs.readFileSync(path.join(dir, whole))]);
            }
            if (bytes.length !== o.bytes)
                return `sidecar: ${o.file} has ${bytes.length} bytes, not ` +
                    o.bytes;
            const why = o.container === 'ktx2' && judgeTexture(bytes, o);
            if (why) return `sidecar: ${o.file} ${why}`;
        }
    }
    const other = [...left].filter(name => !/_sh\.txt$|^[pd]\./
        .test(name));
    return other.length ? `sidecar: does not name ${other}` : '';
}
const contents = {specular: 'specular', irradiance: 'irradiance',
    skybox: 'skybox', lut: 'brdf_lut', 'lobe-table': 'lobe_lut'};
// --only gives the same files.
async function judgeOnly(cmd, row, r) {
    if (['only', 'incremental', 'rendered-error', 'scene'].some(n => n in row))
        return '';
    const [, , json] = sidecars(r.dir).next().value ?? [];
    const kinds = shuffled(Object.keys(contents).filter(k =>
        json?.outputs.some(o => o.content === contents[k])));
    if (kinds.length < 2) return '';
    const part = await run(cmd.page[0],
        line(cmd, row, {more: ['--only', kinds[0]]}));
    const all = files(r.dir), few = files(part.dir);
    remove(part);
    if (part.crash) return `only: --only ${kinds[0]}: ${part.crash}`;
    if (part.status === 2) return '';
    if (part.status) return `only: --only ${kinds[0]}: ${part.err}`;
    const bad = [...few].filter(([name, hash]) => !/\.(json|png|d)$/
        .test(name) && hash !== all.get(name));
    return bad.length ? `only: --only ${kinds[0]}: ${bad[0][0]} differs` :
        few.size ? '' : `only: --only ${kinds[0]}: no file`;
}
// iblbake verify reads it, and finds no large error.
async function judgeVerify(cmd, row, r) {
    const env = places(line(cmd, row));
    if (env.length !== 1 || 'from' in row || row.ENV === '-') return '';
    const input = ['layer', 'part', 'any-aspect', 'strict', 'primaries',
        'exposure', 'clamp', 'name'];
    const words = line(cmd, row), given = [];
    words.forEach((w, i) => {
        if (w === '--input-layout' || w.startsWith('--') &&
            input.includes(w.slice(2)))
            given.push(w, ...cmd.options.get(w.slice(2)).takes ?
                [words[i + 1]] : []);
    });
    for (const [at, , json] of sidecars(r.dir)) {
        if (!json.outputs.some(o => Object.values(contents).slice(0, 4)
            .includes(o.content)))
            continue;
        const v = await run('iblbake', ['verify', ...given, '--texels', '24',
            '--json', '-', ...env, at], r.dir);
        if (v.crash || v.status) return `verify: ${v.crash || v.err}`;
        const bad = JSON.parse(v.out).levels?.find(l => l.nonfinite);
        if (bad) return `verify: ${bad.content} ${bad.level} is not finite`;
    }
    return '';
}

// What a row comes to: refused with a message, or the law that it breaks.
async function judge(cmd, row, laws = true, missing = false) {
    const r = await run(cmd.page[0], line(cmd, row, {missing}));
    const result = why => {
        remove(r);
        return {...r, law: why.split(':')[0], why};
    };
    if (r.crash) return result(`crash: ${r.crash}`);
    const left = files(r.dir);
    if (r.status) {
        const lines = r.err.trimEnd().split('\n')
            .filter(l => !/^ibl\w+: warning: /.test(l));
        // What was baked before one of many failed stays.
        const many = 'from' in row || row.ENV === '../folder' ||
            places(line(cmd, row)).length > 1;
        r.message = lines.at(-1);
        r.refused = true;
        return result(
            many && r.status === 1 ? '' :
            !/^ibl(bake|view): /.test(r.message) ? 'line: none on stderr' :
            lines.length > 1 && !('verbose' in row) ?
                `line: ${lines.length} lines: ${lines.join(' / ')}` :
            left.size && cmd.tail ? `left: ${[...left.keys()]}` :
            r.out && r.status === 2 ? `line: on stdout: ${r.out}` : '');
    }
    if (!laws || flags.light) return result('');
    let why = cmd.tail && !('grid' in row) ? judgeFiles(r.dir, row) : '';
    const more = 'threads' in row || cmd.page[0] === 'iblview' ? [] :
        ['--threads', '3'];
    const again = await run(cmd.page[0], line(cmd, row, {more}));
    const bad = differ(left, files(again.dir));
    remove(again);
    if (!why && (again.status || bad.length))
        why = `same: again, ${more.join(' ')}: ${again.err}${bad} differ`;
    if (!why && !cmd.words.length && cmd.tail)
        why = await judgeOnly(cmd, row, r) || await judgeVerify(cmd, row, r);
    return result(why);
}

// ---- conflicts --------------------------------------------------------------

// A message without the values that it names.
function pattern(message, row) {
    for (const value of Object.values(row).flatMap(v => v.split(' ')))
        if (/[a-z]{2}/.test(value) && !value.startsWith('--'))
            message = message.replaceAll(value.replace(/^\.\.\//, ''), 'V');
    return message.replace(/-?\d*\.?\d+(e[-+]?\d+)?/g, 'N');
}
// Conflicts are {members: {NAME: [VALUES]}, status, message}.
const has = (conflict, row) => Object.entries(conflict.members)
    .every(([name, values]) => name in row && values.includes(row[name]));
// Rows with each of the values of a conflict.
function combinations(members) {
    const all = Object.entries(members);
    const most = Math.max(...all.map(([, values]) => values.length));
    return Array.from({length: most}, (_, i) => Object.fromEntries(
        all.map(([name, values]) => [name, values[i % values.length]])));
}
const alike = (a, b) => a.law === b.law && !a.refused === !b.refused &&
    (a.status === 2) === (b.status === 2);
// The smallest part of a row that comes to the same.
async function shrink(cmd, row, result, order, missing) {
    // What makes bakes small goes last: others are tried in less time.
    const first = n => cmd.usual.includes(n) ? 1 : 0;
    for (const name of order.sort((a, b) => first(a) - first(b))) {
        const {[name]: _, ...less} = row;
        if (!Object.keys(less).length) break;
        const r = await judge(cmd, less, !!result.why, missing);
        if (alike(r, result)) [row, result] = [less, r];
    }
    return [row, result];
}
// The other values with which it is refused by the same words.
async function widen(cmd, row, result, missing) {
    const conflict = {status: result.status,
        message: pattern(result.message, row),
        members: Object.fromEntries(Object.entries(row)
            .map(([name, value]) => [name, [value]]))};
    const {members} = conflict;
    for (const name in members)
        for (const value of cmd.options.get(name).values) {
            if (members[name].includes(value)) continue;
            let same = true;
            for (const other of combinations({...members, [name]: [value]})) {
                const r = await judge(cmd, other, false, missing);
                same = r.refused && !r.why &&
                    pattern(r.message, other) === conflict.message;
                if (!same) break;
            }
            if (same) members[name].push(value);
        }
    // As they will be tried; else as it was found.
    for (const other of combinations(members)) {
        const r = await judge(cmd, other, false, missing);
        if (!r.refused || pattern(r.message, other) !== conflict.message)
            for (const name in members) members[name] = [row[name]];
    }
    return conflict;
}
const readList = () => fs.existsSync(listName) ?
    fs.readFileSync(listName, 'utf8').split('\n').filter(l => l) : [];
function parse(text, cmd) {
    const [, status, message, ...members] = text.split('\t');
    return {status: Number(status), message,
        members: Object.fromEntries(members.map(member => {
            const at = member.indexOf('=');
            const option = member.slice(0, at), values = member.slice(at + 1);
            return [option, values === '*' ?
                cmd.options.get(option)?.values ?? [] : values.split('|')];
        }))};
}
const written = (name, cmd, c) => [name, c.status, c.message,
    ...Object.entries(c.members).sort().map(([option, values]) => {
        const all = cmd.options.get(option).values;
        return `${option}=${values.length === all.length ? '*' :
            all.filter(v => values.includes(v)).join('|')}`;
    })].join('\t');

// Writes the list anew: of this command the conflicts, of others as it was.
function save(name, cmd, conflicts) {
    if (!flags.write) return;
    const others = readList().filter(l => l.split('\t')[0] !== name);
    fs.writeFileSync(listName, [...others,
        ...conflicts.map(c => written(name, cmd, c))].sort().join('\n') + '\n');
}

// ---- one command ------------------------------------------------------------

// Each listed conflict alone, where another one may be named first. Gives those
// that still are.
async function known(cmd, conflicts) {
    const messages = new Set(conflicts.map(c => c.message));
    const right = await Promise.all(conflicts.map(async c => {
        const all = combinations(c.members);
        for (const row of flags.seconds ? [all[random(all.length)]] : all) {
            const r = await judge(cmd, row, false);
            if (r.refused && !r.why && r.status === c.status &&
                messages.has(pattern(r.message, row)))
                passed++;
            else if (flags.write) return [];
            else
                fail(`${told(cmd, row)}: is listed as refused with ` +
                    `'${c.message}', ${r.why || r.message || 'and works'}`);
        }
        return [c];
    }));
    return right.flat();
}

async function pairs(name, cmd, conflicts) {
    const items = [...cmd.options].flatMap(([option, {values}]) =>
        values.map(value => ({option, value})));
    const key = (a, b) => a < b ? a * items.length + b : b * items.length + a;
    const free = new Set(), broken = [];
    const conflict = row => conflicts.some(c => has(c, row)) ||
        broken.some(c => has(c, row));
    const row = list => Object.fromEntries(list.map(i =>
        [items[i].option, items[i].value]));
    items.forEach((a, i) => items.forEach((b, k) => {
        if (i < k && a.option !== b.option &&
            [undefined, a.option, b.option].includes(flags.with))
            free.add(key(i, k));
    }));
    const order = shuffled([...free]), all = free.size;
    // A row that begins with an uncovered pair.
    const make = () => {
        let list;
        while (order.length) {
            const pair = order.pop();
            list = [Math.floor(pair / items.length), pair % items.length];
            if (!free.delete(pair)) list = null;
            else if (!conflict(row(list))) break;
            else list = null;
        }
        if (!list) return null;
        const gain = i => list.reduce((n, k) => n + free.has(key(i, k)), 0);
        while (list.length < cmd.row) {
            const used = row(list);
            const usual = random(8) > 0 && cmd.usual.filter(o => !(o in used));
            const more = items.map((_, i) => i).filter(i =>
                !(items[i].option in used) &&
                (!usual?.length || usual.includes(items[i].option)));
            const best = shuffled(more).map(i => [gain(i), i])
                .sort((a, b) => b[0] - a[0])
                .find(([n, i]) => (n || usual) && !conflict(row([...list, i])));
            if (!best && usual?.length) {
                usual.length = 0;
                break;
            }
            if (!best) break;
            list.push(best[1]);
        }
        for (const i of list)
            for (const k of list) if (i < k) free.delete(key(i, k));
        return list;
    };
    // Values that are refused by themselves, first: [i].
    const queue = flags.with || conflicts.length ? [] :
        items.map((_, i) => [i]);
    let rows = 0;
    while (seconds() < end) {
        const batch = [];
        while (batch.length < 8) {
            const list = queue.shift() ?? make();
            if (!list) break;
            if (!conflict(row(list))) batch.push(list);
        }
        if (!batch.length) break;
        const results = await Promise.all(batch.map(async list => {
            const whole = row(list);
            const result = await judge(cmd, whole, list.length > 1);
            return {list, whole, result};
        }));
        for (const r of results)
            // A sample has no time to look for what refuses it.
            if (r.result.why || r.result.refused && !flags.seconds)
                r.small = (async () => {
                // Its pairs are to be seen elsewhere.
                for (const i of r.list)
                    for (const k of r.list) if (i < k) {
                        free.add(key(i, k));
                        order.unshift(key(i, k));
                    }
                const {whole, result} = r;
                const names = shuffled(Object.keys(whole));
                r.missing = !result.why && result.status === 2 &&
                    alike(result, await judge(cmd, whole, false, true));
                return shrink(cmd, whole, result, names, r.missing);
            })();
        for (const r of results) {
            rows++;
            if (flags.write && rows % 50 === 0) console.log(`${rows} rows, ` +
                `${free.size} pairs left, ${conflicts.length} refusals`);
            if (!r.small) {
                passed++;
                continue;
            }
            const [small, why] = await r.small;
            if (conflict(small)) continue;
            if (why.why) {
                broken.push({members: Object.fromEntries(
                    Object.entries(small).map(([n, v]) => [n, [v]]))});
                fail(`${told(cmd, small)}: ${why.why}`);
                continue;
            }
            conflicts.push(await widen(cmd, small, why, r.missing));
            save(name, cmd, conflicts);
            if (flags.write) passed++;
            else
                fail(`${told(cmd, small)}: is refused, which is not listed: ` +
                    why.message);
        }
    }
    console.log(`${name}: ${items.length} values of ${cmd.options.size} ` +
        `options, ${all} pairs, ${free.size} of them not run (refused or not ` +
        `reached); ${rows} rows, ${runs} runs, ${seconds().toFixed(0)} s`);
}

// Each option alone changes something, by at least one value.
async function alone(name, cmd) {
    await Promise.all([...cmd.options].map(async ([option, {values, env}]) => {
        if (env || !values.length) return;
        let changes = false;
        for (const value of values) {
            const r = await run(cmd.page[0], line(cmd, {[option]: value}));
            const without = await run(cmd.page[0],
                line(cmd, {[option]: value}, {without: option}));
            changes ||= r.status !== without.status || r.out !== without.out ||
                r.err !== without.err ||
                differ(files(r.dir, true), files(without.dir, true)).length > 0;
            remove(r);
            remove(without);
        }
        if (changes === !(option in cmd.silent)) passed++;
        else fail(`${name}: --${option} alone ${changes ? 'changes something:' +
            ' take it out of silent' : 'changes nothing'}`);
    }));
}

process.chdir(work);
makeInputs((...words) => {
    const r = spawnSync(path.join(bin, 'iblbake'), words, {env});
    if (r.status !== 0) throw new Error(`${words}: ${r.stderr}`);
});
console.log(`seed ${seed}`);
const names = Object.keys(commands).filter(n =>
    (!wanted.length || wanted.includes(n)) &&
    fs.existsSync(path.join(bin, commands[n].page[0])));
for (const [k, name] of names.entries()) {
    const cmd = commands[name];
    const help = await run(cmd.page[0], [...cmd.page.slice(1), '--help']);
    if (name === 'bake') {
        const list = await run('iblbake', ['--target', 'list']);
        cmd.values.target = [...list.out.matchAll(/^([a-z-]+): /gm)]
            .map(m => m[1]).concat('all', 'three,gltf');
    }
    cmd.options = table(help.out, cmd.values);
    let conflicts = flags.write && !flags.more ? [] : readList()
        .filter(l => l.split('\t')[0] === name).map(l => parse(l, cmd));
    if (flags.seconds)
        end = seconds() + (flags.seconds - seconds()) / (names.length - k);
    if (flags.alone) await alone(name, cmd);
    if (flags.write)
        conflicts = conflicts.filter(c => Object.entries(c.members).every(
            ([option, values]) => values.every(v =>
                cmd.options.get(option)?.values.includes(v))));
    conflicts = await known(cmd, conflicts);
    save(name, cmd, conflicts);
    await pairs(name, cmd, conflicts);
}
console.log(`${passed} passed, ${failed} failed`);
process.exitCode = failed ? 1 : 0;

// SPDX-License-Identifier: MIT
// node tests/pairs/pairs.mjs BUILD [--write [--more]] [--alone] [--light]
//                            [--list] [--seed N] [--seconds S] [COMMAND...]
//
// Runs every pair of values of the options of bake and the other commands, as
// their --help lists them, in rows of many options each, and judges each run by
// the laws below. What is refused stands in refused.txt with its message; rows
// avoid it, and it is run by itself. --write finds all pairs that are misuse by
// themselves, then what rows meet beyond them, and writes that list anew, or with
// --more adds the latter. --alone tries what each option changes by itself, --light
// looks for crashes and refusals, --list only runs what is listed, a third of it,
// --seconds a sample of rows. JOBS runs are made at once. The last line is "N passed, N failed".
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
const seconds = () => performance.now() / 1000;
let end = Infinity;
function fail(what) {
    failed++;
    console.log('FAILED: ' + what);
}

// ---- running ----------------------------------------------------------------

const env = {...process.env};
for (const name of ['LD_LIBRARY_PATH', 'DISPLAY', 'WAYLAND_DISPLAY'])
    delete env[name];
const jobs = Number(process.env.JOBS) || os.availableParallelism();
// Does `task` for each of what is iterated, some at once.
function each(iterable, task) {
    const all = iterable[Symbol.iterator]();
    return Promise.all(Array.from({length: jobs}, async () => {
        for (let next = all.next(); !next.done; next = all.next())
            await task(next.value);
    }));
}
// Runs a program in a directory, which it makes unless there is one.
async function run(program, words, dir = path.join(work, 'r' + runs)) {
    runs++;
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
    let [status, signal] = await new Promise(done =>
        child.on('close', (...how) => done(how)));
    clearTimeout(late);
    // LeakSanitizer falls over thread data of libraries that bridges load.
    if (/^Tracer caught signal/m.test(out[1])) [status, out[1]] = [0, ''];
    const crash = signal ? /XCPU|KILL/.test(signal) ? 'takes a minute' : signal :
        /Sanitizer|runtime error/.test(out[1]) ? out[1].slice(0, 2000) :
        ![0, 1, 2].includes(status) ? `status ${status}` : '';
    return {dir, status, crash, out: out[0], err: out[1]};
}
const remove = r => fs.rmSync(r.dir, {recursive: true, force: true});
// What a run left: names with hashes of the bytes, for `plain` without the options
// that the sidecar repeats.
function files(dir, plain) {
    const found = new Map();
    for (const entry of fs.readdirSync(dir, {recursive: true,
        withFileTypes: true})) {
        const name = path.join(entry.parentPath ?? entry.path, entry.name);
        if (!entry.isFile() || name.includes('/.iblbake/')) continue;
        let bytes = fs.readFileSync(name);
        if (plain && name.endsWith('.json'))
            bytes = bytes.toString().replace(/"options": \{[^]*?\}/, '');
        found.set(path.relative(dir, name),
            createHash('md5').update(bytes).digest('hex'));
    }
    return found;
}
const differ = (a, b) => [...new Set([...a.keys(), ...b.keys()])]
    .filter(name => a.get(name) !== b.get(name));

// ---- options and their values -----------------------------------------------

// The options of a --help that end nothing: {NAME: {takes, values}}.
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
// missing: its inputs are not there, so that what is no misuse ends soon.
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
    let places = env.length ? env : inputs.length ?
        [inputs[0], ...cmd.env.split(' ').slice(1)] : cmd.env.split(' ');
    places.push(...added.filter((p, i) => !places.includes(p) &&
        added.indexOf(p) === i));
    if (missing)
        places = places.map(p => ({'-': '-', '../folder': '../empty'}[p] ??
            '../missing.exr'));
    const all = [...cmd.words, ...others, ...own, ...more, ...places];
    if (cmd.page[0] === 'iblview') {
        if (!/--(offscreen|contact-sheet)/.test(all.join(' ')))
            all.push('--offscreen', 'p.png');
        if (!all.includes('--size')) all.push('--size', '40x40');
    }
    return [...all, ...cmd.tail.split(' ').filter(w => w)];
}
const places = words =>
    words.filter(w => /^\.\..*\.(exr|hdr|ktx2|png)$/.test(w));
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
    const all = [...files(dir).keys()], left = new Set(all);
    const index = all.find(f => path.basename(f) === 'index.json');
    if (index) { // of probes
        const named = fs.readFileSync(path.join(dir, index), 'utf8')
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
            const names = (o.files ?? [o.file]).map(f => path.join(at, f))
                .filter(f => all.includes(f));
            names.forEach(name => left.delete(name));
            const bytes = Buffer.concat(names.map(name =>
                fs.readFileSync(path.join(dir, name))));
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
        'exposure', 'clamp', 'name', 'face-order', 'input-transfer'];
    const words = line(cmd, row), given = [];
    words.forEach((w, i) => {
        if (w === '--input-layout' || w.startsWith('--') &&
            input.includes(w.slice(2)))
            given.push(w, ...cmd.options.get(w.slice(2)).takes ?
                [words[i + 1]] : []);
    });
    for (const [at, , json] of sidecars(r.dir)) {
        if (!json.outputs.some(o => Object.values(contents).slice(0, 4)
            .includes(o.content) && !/^(exr|hdr|png)$/.test(o.container)))
            continue;
        const v = await run('iblbake', ['verify', ...given, '--texels', '24',
            '--json', '-', ...env, at], r.dir);
        if (v.crash || v.status) return `verify: ${v.crash || v.err}`;
        const bad = JSON.parse(v.out).levels?.find(l => l.nonfinite);
        if (bad) return `verify: ${bad.content} ${bad.level} is not finite`;
    }
    return '';
}

// What convert wrote is read, finite, and has the light of IN; and texels that
// lose nothing give IN again, byte for byte, or if DDS had the keys, its DDS.
async function judgeConvert(cmd, row, r) {
    const words = line(cmd, row), from = words.at(-2), made = files(r.dir);
    const ask = (...w) => run('iblbake', [...w, '--max-memory', '1G'], r.dir);
    const table = /_lut/.test(from), flat = /flat/.test(from);
    const picture = /exr|hdr|png/.test(row.format);
    const blocks = /bc6h|astc/.test(words.join(' ')); // a sun's ends are coarse
    const layout = table ? 'octahedral' : {cube: 'faces', cross: 'hcross'}[
        row.layout] ?? row.layout ?? (flat ? 'octahedral' : 'faces');
    const names = [...new Set([...made.keys()].map(name =>
        name.replace(/_[pn][xyz]\./, '_%f.')))].sort();
    const told = [];
    for (const some of picture ? [[from], names] : [[from, ...names]]) {
        const v = await ask('info', '--json', ...some, ...picture &&
            some !== names ? [] : ['--input-layout', layout]);
        if (v.crash || v.status) return `read: ${v.crash || v.err}`;
        told.push(...JSON.parse(v.out).files);
    }
    const [was, ...are] = told, levels = picture ? are : are[0].levels;
    if (levels.length !== was.levels.length)
        return `light: ${levels.length} levels, not ${was.levels.length}`;
    for (const [l, {mean, nonfinite}] of levels.entries()) {
        const want = was.levels[l].mean;
        if (nonfinite || row.format !== 'png' && !('largest' in row) &&
            !mean.every((v, c) => Math.abs(v - (want[c] ?? v)) <=
                (blocks ? .2 : .03) * Math.max(...want)))
            return `light: level ${l} has ${mean}, not ${want}`;
    }
    if (picture || 'layout' in row || 'largest' in row ||
        /--pixel (?!rgba32f)/.test(words.join(' '))) return '';
    const kind = /dds/.test(row.format + from) ? 'dds' : 'ktx2';
    const same = 'pixel' in row ? ['--pixel', was.pixel] : [];
    const back = await ask('convert', ...same, 'p.ktx2', 'back.' + kind);
    const own = await ask('convert', from, 'own.' + kind);
    const bytes = name => fs.readFileSync(path.join(r.dir, name));
    return back.status || own.status ? `back: ${back.err}${own.err}` :
        bytes('back.' + kind).equals(bytes(from.endsWith(kind) ? from :
            'own.' + kind)) ? '' : 'back: is another file than IN';
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
            .filter(l => !/^ibl\w+: (note|warning): /.test(l));
        // Of many, one that failed refuses nothing, and what was baked stays.
        if (r.status === 1 && ('from' in row || row.ENV === '../folder' ||
            places(line(cmd, row)).length > 1 && cmd.tail))
            return result('');
        // With --verbose the times of what was done may follow it.
        r.message = lines.filter(l => /^ibl/.test(l)).at(-1) ?? '';
        r.refused = true;
        return result(
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
    if (!why && (again.status || bad.length || again.out !== r.out))
        why = `same: again, ${more.join(' ')}: ${again.err}${bad.join() ||
            'what is printed'} differ`;
    if (!why && cmd.words[0] === 'convert')
        why = await judgeConvert(cmd, row, r);
    if (!why && !cmd.words.length && cmd.tail)
        why = await judgeOnly(cmd, row, r) || await judgeVerify(cmd, row, r);
    return result(why);
}

// ---- what is refused --------------------------------------------------------

// A message without the values that it names.
function plain(cmd, message, row) {
    const words = line(cmd, row);
    message = message.replace(/^ibl\w+: /, '').replace(/^--target \S+: /, '');
    words.forEach((word, i) => {
        const value = words[i + 1];
        if (word.startsWith('--') && value && !value.startsWith('--'))
            message = message.replaceAll(new RegExp(
                `(?<=${word.slice(2)}) ${value.replace(/\W/g, '\\$&')}(?!\\w)`,
                'g'), '');
    });
    return message
        .replace(/(--[a-z-]+) -?[\d.][-+\d.,:=x\/e]*?(?=[,:]? |:?$)/g, '$1')
        .replace(/\.\.\/[\w.%\/]+/g, 'FILE')
        .replace(/(?<![\w.])-?\d*\.?\d+(e[-+]?\d+)?(?!\w)/g, 'N');
}
// The list of a command: conflicts of one item, of two or of more, each with
// status and message. Items are numbers of cmd.items, in rising order.
class Refused {
    constructor(cmd) {
        this.cmd = cmd;
        this.all = new Map();
        this.bad = new Uint8Array(cmd.items.length ** 2);
        this.more = [];
    }
    add(items, status, message) {
        this.all.set(String(items), {items, status, message});
        if (items.length > 2) this.more.push(items);
        else this.bad[items[0] * this.cmd.items.length + items.at(-1)] = 1;
    }
    // Whether a list of items, whose own order is free, has a conflict.
    has(list) {
        const n = this.cmd.items.length;
        return list.some(a => list.some(b => a <= b && this.bad[a * n + b])) ||
            this.more.some(items => items.every(i => list.includes(i)));
    }
    values(option) { // those that are not refused alone
        return this.cmd.items.map((_, i) => i).filter(i =>
            this.cmd.items[i].option === option && !this.has([i]));
    }
    // Conflicts of one message as products: [{status, message, groups}]. The
    // option that it names, first of all, is --* in it.
    products() {
        let list = [...this.all.values()].map(({items, status, message}) => {
            const named = /--([a-z-]+)/.exec(message)?.[1];
            const is = i => this.cmd.items[i].option === named ? 0 : 1;
            const head = items.some(i => !is(i));
            return {status,
                message: head ? message.replace(`--${named}`, '--*') : message,
                groups: [...items].sort((a, b) => is(a) - is(b) || a - b)
                    .map(i => [i])};
        });
        for (const at of [3, 2, 1, 0]) {
            const found = new Map();
            for (const c of list) {
                const key = [c.status, c.message, ...c.groups.map(
                    (g, k) => k === at ? '' : g)].join('\t');
                const other = found.get(key);
                if (other && at in c.groups)
                    other.groups[at] = [...other.groups[at], ...c.groups[at]]
                        .sort((a, b) => a - b);
                else found.set(key, c);
            }
            list = [...found.values()];
        }
        return list;
    }
    text(group) {
        const options = [...new Set(group.map(i => this.cmd.items[i].option))];
        return options.map(option => {
            const mine = group.filter(i => this.cmd.items[i].option === option);
            return String(mine) === String(this.values(option)) ? option :
                `${option}=${mine.map(i => this.cmd.items[i].value).join('|')}`;
        }).join('; ');
    }
    group(text) {
        return text.split('; ').flatMap(part => {
            const [, option, values] = /^([^=]*)(?:=(.*))?$/.exec(part);
            return values === undefined ? this.values(option) :
                values.split('|').map(value => this.cmd.items.findIndex(i =>
                    i.option === option && i.value === value))
                    .filter(i => i >= 0);
        });
    }
}
const rowOf = (cmd, items) => Object.fromEntries(items.map(i =>
    [cmd.items[i].option, cmd.items[i].value]));
const readList = () =>
    fs.readFileSync(listName, 'utf8').split('\n').filter(l => l);
// The products of a command's list, those of one item first.
function read(name, refused) {
    return readList().map(l => l.split('\t')).filter(l => l[0] === name)
        .sort((a, b) => a.length - b.length)
        .map(([, status, message, ...texts]) => {
            const {items} = refused.cmd;
            const groups = texts.map(t => refused.group(t));
            const all = groups.reduce((some, g) => some.flatMap(list =>
                g.map(i => [...list, i])), [[]])
                .filter(list => list.every((a, k) => list.every((b, m) =>
                    k === m || items[a].option !== items[b].option)));
            for (const list of all)
                refused.add([...list].sort((a, b) => a - b), Number(status),
                    message.replace('--*', `--${items[list[0]].option}`));
            return groups;
        });
}
function write(name, refused) {
    const lines = refused.products().map(c => [name, c.status, c.message,
        ...c.groups.map(g => refused.text(g))].join('\t'));
    const others = readList().filter(l => l.split('\t')[0] !== name);
    fs.writeFileSync(listName, [...others, ...lines].sort().join('\n') + '\n');
}

// ---- one command ------------------------------------------------------------

// All conflicts of one item and of two that are misuse.
async function find(cmd, refused) {
    const many = cmd.items.map((_, i) => i), all = many.map(i => [i]);
    for (const a of many)
        for (const b of many)
            if (a < b && cmd.items[a].option !== cmd.items[b].option)
                all.push([a, b]);
    await each(all, async items => {
        if (refused.has(items)) return;
        const row = rowOf(cmd, items), r = await judge(cmd, row, false, true);
        if (r.why) fail(`${told(cmd, row, {missing: true})}: ${r.why}`);
        else if (r.status === 2)
            refused.add(items, 2, plain(cmd, r.message, row));
    });
    console.log(`${all.length} runs, ${seconds().toFixed(0)} s, ` +
        `${refused.all.size} refused`);
}
// Whether a conflict is as it is listed, and what it comes to.
async function same(cmd, c) {
    const row = rowOf(cmd, c.items);
    const r = await judge(cmd, row, false, c.status === 2);
    const good = r.refused && !r.why && r.status === c.status &&
        plain(cmd, r.message, row) === c.message;
    return [good, `${told(cmd, row)}: is listed as refused with ` +
        `'${c.message}', ${r.why || r.message || 'and works'}`];
}
// The smallest part of a row that comes to the same.
async function shrink(cmd, row, result) {
    const alike = r => r.law === result.law && !r.refused === !result.refused &&
        (r.status === 2) === (result.status === 2);
    const missing = !result.why && result.status === 2 &&
        alike(await judge(cmd, row, false, true));
    // What makes bakes small goes last: others are tried in less time.
    const last = n => cmd.usual.includes(n) ? 1 : 0;
    for (const name of shuffled(Object.keys(row))
        .sort((a, b) => last(a) - last(b))) {
        const {[name]: _, ...less} = row;
        if (!Object.keys(less).length) break;
        const r = await judge(cmd, less, !!result.why, missing);
        if (alike(r)) [row, result] = [less, r];
    }
    return [row, result];
}
// Each pair in a row of others.
async function pairs(name, cmd, refused) {
    const {items} = cmd, key = (a, b) => a < b ? a * items.length + b :
        b * items.length + a;
    const left = new Set(), usual = items.map((_, i) => i)
        .filter(i => cmd.usual.includes(items[i].option));
    items.forEach((a, i) => items.forEach((b, k) => {
        if (i < k && a.option !== b.option && !refused.has([i, k]))
            left.add(key(i, k));
    }));
    const order = shuffled([...left]), all = left.size;
    // Options that measure errors take half a minute with a sanitizer.
    const slow = i => flags.seconds &&
        /^scene|rendered-error/.test(`${items[i].option} ${items[i].value}`);
    const met = (list, set) => list.forEach(i => list.forEach(k =>
        i < k && set(key(i, k))));
    function* make() {
        while (order.length && seconds() < end) {
            const pair = order.pop();
            if (!left.has(pair)) continue;
            const list = [Math.floor(pair / items.length), pair % items.length];
            if (list.some(slow) || refused.has(list)) continue;
            const open = i => !slow(i) && !list.some(k => items[k].option ===
                items[i].option) && !refused.has([...list, i]);
            // What keeps it small, most often; then what is new.
            for (const i of random(8) ? shuffled(usual) : [])
                if (open(i)) list.push(i);
            const gain = i => list.reduce((n, k) => n + left.has(key(i, k)), 0);
            while (list.length < cmd.row) {
                const best = shuffled(items.map((_, i) => i))
                    .map(i => [gain(i), i]).filter(([n]) => n)
                    .sort((a, b) => b[0] - a[0]).find(([, i]) => open(i));
                if (!best) break;
                list.push(best[1]);
            }
            met(list, pair => left.delete(pair));
            yield list.sort((a, b) => a - b);
        }
    }
    let rows = 0;
    await each(make(), async list => {
        const row = rowOf(cmd, list), result = await judge(cmd, row);
        if (++rows % 50 === 0 && flags.write)
            console.log(`${rows} rows, ${left.size} pairs left, ` +
                `${refused.all.size} refused, ${seconds().toFixed(0)} s`);
        // A sample has no time to look for what refuses it.
        // check_view_controls.c sees where settings of the viewer apply.
        const own = cmd.page[0] === 'iblview' && !result.why &&
            /: (is|are) (of|those of) |: add --compare/.test(result.message);
        if (!result.why && (!result.refused || flags.seconds || own))
            return passed++;
        // Its pairs are to be seen elsewhere.
        met(list, pair => { left.add(pair); order.unshift(pair); });
        const [small, why] = await shrink(cmd, row, result);
        const part = list.filter(i => items[i].option in small);
        if (refused.has(part)) return 0;
        const message = plain(cmd, why.message ?? '', small);
        // What three refuse in listed words is not looked for in all forms.
        const heard = part.length > 2 && [...refused.all.values()].some(c =>
            c.message === message);
        refused.add(part, why.status, message);
        if (why.why || !flags.write && !heard) {
            refused.all.delete(String(part));
            return fail(`${told(cmd, small)}: ${why.why ||
                'is refused, which is not listed: ' + why.message}`);
        }
        if (!flags.write) return passed++;
        // The same with other values of its options.
        let others = [[]];
        for (const i of part)
            others = others.flatMap(some => items.map((_, k) => [...some, k])
                .filter(o => items[o.at(-1)].option === items[i].option));
        const c = refused.all.get(String(part));
        for (const other of shuffled(others).slice(0, 100))
            if (!refused.has(other) &&
                (await same(cmd, {...c, items: other}))[0])
                refused.add(other, c.status, c.message);
        return write(name, refused);
    });
    console.log(`${name}: ${items.length} values of ${cmd.options.size} ` +
        `options, ${all} pairs, ${order.length && left.size} of them not ` +
        `run; ${rows} rows, ${runs} runs, ${seconds().toFixed(0)} s`);
}
// Each option alone changes something, by at least one value.
async function alone(name, cmd) {
    await each(cmd.options, async ([option, {values, env}]) => {
        if (env || !values.length || option in cmd.silent) return;
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
        if (changes) passed++;
        else fail(`${name}: --${option} alone changes nothing`);
    });
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
    cmd.items = [...cmd.options].flatMap(([option, {values}]) =>
        values.map(value => ({option, value})));
    const refused = new Refused(cmd), listed = new Refused(cmd);
    const products = read(name, listed);
    end = flags.seconds ? seconds() +
        (flags.seconds - seconds()) / (names.length - k) : Infinity;
    if (flags.alone) await alone(name, cmd);
    if (flags.write && !flags.more) {
        await find(cmd, refused);
        await each([...listed.all.values()], async c => {
            if ((c.status === 1 || c.items.length > 2) &&
                !refused.has(c.items) && (await same(cmd, c))[0])
                refused.add(c.items, c.status, c.message);
        });
        write(name, refused);
    } else if (!flags.seconds)
        // Each value of each product once; with --light what ends soon.
        await each(shuffled(products.flatMap(groups => Array.from(
            {length: Math.max(...groups.map(g => g.length))}, (_, i) =>
                groups.map(g => g[i % g.length]).sort((a, b) => a - b))))
                .filter((_, i) => !flags.list || i % 3 === 0),
            async items => {
                const c = listed.all.get(String(items));
                if (!c || flags.light && c.status === 1) return;
                const [good, why] = await same(cmd, c);
                if (good) passed++;
                else fail(why);
            });
    if (flags.list) continue; // rows
    await pairs(name, cmd, flags.write && !flags.more ? refused : listed);
}
console.log(`${passed} passed, ${failed} failed`);
process.exitCode = failed ? 1 : 0;

// SPDX-License-Identifier: MIT
/*
 * node tests/clients/drive.mjs NPM DIR CHROMIUM [PICTURE]
 *
 * Draws the sets of files DIR/MAP/SET in the engines installed under
 * NPM/node_modules, in one browser, each by the program that DIR/MAP/TARGET.js
 * has for its target, and compares the screen block by block with the same
 * engine's of half floats (DIR/MAP/SET-half) and with what the exact levels
 * DIR/MAP/exact-OPTIONS give by the engine's lookups (engines.mjs).
 * Prints a table; the last line is "N passed, N failed". PICTURE: a PNG to
 * write, of what the engines draw.
 */
import {spawn} from 'node:child_process';
import {existsSync, mkdtempSync, readFileSync, rmSync, statSync,
        writeFileSync} from 'node:fs';
import {createServer} from 'node:http';
import path from 'node:path';
import {fileURLToPath} from 'node:url';

import {compare, distance, mirrors, spheres, views} from './looks.mjs';
import {readExact} from './exact.mjs';
import {engines, harmonics} from './engines.mjs';
import {integral} from './integral.mjs';
import {lamps} from './maps.mjs';
import {lookup} from './cube.mjs';
import {lightProbe, rules} from './rules.mjs';

const [npm, dir, chromium, picture] = process.argv.slice(2);
const here = path.dirname(fileURLToPath(import.meta.url));
const modules = path.resolve(npm, 'node_modules');
const SECONDS = 120;

let passed = 0, failed = 0;
function verdict(good, what) {
    good ? passed++ : failed++;
    if (!good)
        console.log('FAILED: ' + what);
}

/* ---- pages ---------------------------------------------------------------- */

/* Without lamps, which tells axes apart. */
const MAPS = (process.env.MAPS || 'quarry royal dusk blaze').split(' ');
/* Maps whose reflections are drawn by an engine's own lookup and with its
 * replacement, if it has one, and compared with the integral. */
const judged = (engine, map) => engine.reflects && /lamps|blaze/.test(map);
const jobs = [];
for (const map of ['lamps', ...MAPS])
    for (const [target, engine] of Object.entries(engines)
        .filter(([, {maps}]) => !maps || map === 'lamps' || maps.includes(map)))
        for (const set of [target, ...map === 'lamps' || !engine.half ? [] :
            [engine.half], ...judged(engine, map) ? [target + '-fit'] : []])
            if (!jobs.some(job => job.map === map && job.set === set))
                jobs.push({map, target: set in engines ? set : target, set,
                           saved: {}, said: []});
let current = -1;

function page({map, target, set}) {
    let lines = readFileSync(path.join(dir, map, target + '.js'), 'utf8');
    if (set === 'three-half')
        lines = lines.replaceAll('loader.loadAsync', 'halfFloats');
    if (set !== target + '-fit')
        lines = lines.replace(/.. Reflections:[^]*Reflections end.\n/, '');
    return readFileSync(path.join(here, engines[target].page), 'utf8')
        .replace('/* PROGRAM */', () => lines);
}
const exactOf = ({map, target}) =>
    readExact(modules, path.join(dir, map), engines[target].chain);
/* What a page draws: spheres from each side; of lamps a mirror, and what is
 * behind it. */
function shots(job) {
    const engine = engines[job.target], sides = views(engine.eye);
    const drawn = (s, light) => sides.map(({eye, fov}, view) => ({...s, fov,
        exposure: light, from: eye, to: [0, 0, 0], name: `${view}/${s.name}`}));
    const reflected = judged(engine, job.map) ? mirrors.flatMap(s =>
        drawn(s, reflections(engine, job.map, s).exposure)) : [];
    if (job.set === job.target + '-fit')
        return reflected;
    if (job.map !== 'lamps')
        return reflected.concat(spheres.flatMap(s => drawn(s, exposure(job))));
    return reflected.concat(sides.flatMap(({eye, fov}, view) => {
        const look = {fov, from: eye, to: [0, 0, 0], exposure: 1, albedo: 1};
        const mirror = {...look, metal: 1, roughness: 0, gloss: 1};
        return [{...mirror, name: `${view}/mirror`},
                {...mirror, background: true, fov: 120, from: [0, 0, 0],
                 to: eye.map(x => -x), name: `${view}/background`}];
    }));
}
/* A mean luminance of 0.4, so that little of the light is beyond white. */
const exposure = job => 0.4 / exactOf(job).mean;

/* What an engine should show of some pixels of a sphere from each side, by its
 * rules for the whole reflection: none is beyond white. */
const sums = new Map();
function reflections(engine, map, {metal, roughness}) {
    const key = `${map} ${roughness}`;
    if (!sums.has(key))
        sums.set(key, views(engines.three.eye).map(view => view.some().map(p =>
            ({i: p.i, ...integral(map, p, roughness)}))));
    const sides = sums.get(key).map(side => side.map(p =>
        ({i: p.i, light: engine.reflects(p, metal || 0.04)})));
    const exposure = 1 / Math.max(...sides.flat().flatMap(p => p.light));
    sides.flat().forEach(p => p.light = p.light.map(x => exposure * x));
    return {exposure, sides};
}

/* What the picture has: a row for each engine. */
const PICTURED = ['matte', 'metal .25', 'metal .75'];
function tiles() {
    const rows = Object.keys(engines).map(target => ({
        label: target, tiles: MAPS.flatMap(map => {
            const i = jobs.findIndex(job => job.map === map &&
                job.set === target && job.done);
            return i < 0 ? [] : PICTURED.map(name =>
                ({name, at: `/tile/${i}/0/${name}`}));
        })})).filter(row => row.tiles.length);
    return JSON.stringify({rows, size: views.SIZE});
}

/* The bytes of a path, or undefined. */
function file(where) {
    const [first, ...rest] = where.split('/').filter(Boolean);
    const job = jobs[current];
    if (where === '/tiles')
        return tiles();
    if (first === 'tile')
        return jobs[rest[0]].saved[rest.slice(1).join('/')];
    if (where === '/picture.html')
        return readFileSync(path.join(here, 'picture.html'));
    if (where === '/clients/page.js')
        return readFileSync(path.join(here, 'page.js'), 'utf8')
            .replace('/* JOB */ {}', () => JSON.stringify({size: views.SIZE,
                shots: shots(job)}));
    // The package has no module: a page's names of its global one.
    if (where === '/clients/babylonjs.js')
        return `import '/npm/babylonjs/babylon.js';
export const {${[...new Set(page(job).match(/(?<=BABYLON\.)\w+/g))]}} = BABYLON;`;
    if (rest[rest.length - 1] === 'page.html')
        return page(job);
    const basis = rest.indexOf('basis');
    const name =
        first === 'npm' ? path.join(modules, ...rest) :
        basis >= 0 ? path.join(modules, 'three/examples/jsm/libs/basis',
                               ...rest.slice(basis + 1)) :
        path.join(dir, first || '', ...rest);
    return existsSync(name) && statSync(name).isFile() ?
        readFileSync(name) : undefined;
}
const TYPES = {'.js': 'text/javascript', '.mjs': 'text/javascript',
               '.html': 'text/html; charset=utf-8', '.png': 'image/png',
               '.wasm': 'application/wasm'};

function answer(request, response) {
    const where = decodeURIComponent(
        new URL(request.url, 'http://localhost').pathname);
    const body = [];
    request.on('data', part => body.push(part));
    request.on('end', () => {
        if (request.method === 'POST')
            return response.end(told(where, Buffer.concat(body)));
        const bytes = file(where);
        response.writeHead(bytes === undefined ? 404 : 200, {
            'content-type': TYPES[path.extname(where)] ||
                'application/octet-stream',
            'cache-control': /^.npm/.test(where) ? 'max-age=600' : 'no-store'});
        response.end(bytes);
    });
}
/* What a page tells; gives the address of the next page. */
function told(where, body) {
    const job = jobs[current];
    if (where.startsWith('/saved/'))
        job.saved[where.slice(7)] = body;
    else if (where === '/said')
        job.said.push(body.toString());
    else if (where === '/failed')
        fail(body.toString());
    else if (where === '/picture') {
        writeFileSync(picture, body);
        finish();
    } else if (where === '/next') {
        job.done = true;
        return advance();
    }
    return 'ok';
}

/* ---- the browser ---------------------------------------------------------- */

const profile = mkdtempSync(path.join(dir, 'profile'));
const server = createServer(answer);
let browser, timer, finish;
const finished = new Promise(go => finish = go);

function stop() {
    clearTimeout(timer);
    browser.removeAllListeners();
    browser.kill('SIGKILL');
}
function start(url) {
    browser = spawn(chromium, ['--headless', '--no-sandbox', '--use-gl=angle',
        '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
        '--no-first-run', '--disable-extensions',
        '--disable-background-networking', '--user-data-dir=' + profile,
        `http://127.0.0.1:${server.address().port}${url}`],
        {stdio: 'ignore'});
    browser.on('error', e => fail('no browser: ' + e.message));
    browser.on('exit', () => fail('the browser ended'));
}
/* The address of the next job; of nothing after the last, and its picture. */
function advance() {
    clearTimeout(timer);
    if (++current >= jobs.length) {
        if (picture && current === jobs.length)
            return '/picture.html';
        finish();
        return 'about:blank';
    }
    timer = setTimeout(() => fail(`nothing for ${SECONDS} s`), SECONDS * 1000);
    return `/${jobs[current].map}/` +
        `${jobs[current].set.replace('-fit', '')}/page.html`;
}
/* A page that failed may hang: a new browser has the next. */
function fail(why) {
    if (jobs[current])
        jobs[current].failed = why;
    stop();
    const url = advance();
    if (url !== 'about:blank')
        start(url);
}

/* ---- what was drawn ------------------------------------------------------- */

/* The lamps that are not where they belong in a picture of a mirror or of the
 * background. */
function misplaced(engine, saved) {
    const seen = new Map();
    views(engine.eye).forEach((view, k) => {
        for (const [name, rays] of [
            ['mirror', view.pixels(engine.left).map(p => p && p.n.map((x, i) =>
                2 * p.n.reduce((sum, y, j) => sum + y * p.v[j], 0) * x -
                p.v[i]))],
            ['background', view.background(engine.left)]])
            for (const {axis, colour} of lamps) {
                let best = -1, at = -1;
                rays.forEach((ray, i) => {
                    const near = ray && i % 5 === 0 ? engine.world(ray).reduce(
                        (sum, x, j) => sum + x * axis[j], 0) : -1;
                    if (near > best)
                        [best, at] = [near, i];
                });
                if (best > 0.999)
                    seen.set(`${name} ${axis.join(' ')}`, colour.every((c, i) =>
                        (saved[`${k}/${name}`][4 * at + i] > 200) === c > 0));
            }
    });
    return [...seen].filter(([, right]) => !right).map(([name]) => name).concat(
        seen.size === 12 ? [] : `only ${seen.size} of 12 seen`);
}

const BARS = [4, 3, 6];
/* Compares the pictures of a sphere from all sides with others; the worst of
 * each measure. */
function worst(engine, sphere, saved, other) {
    const out = [0, 0, 0];
    views(engine.eye).forEach((view, k) => compare(
        saved[`${k}/${sphere.name}`], other(view, k), view.pixels(engine.left))
        .forEach((x, i) => out[i] = Math.max(out[i], x)));
    return out;
}
const shown = off => off.map(x => x.toFixed(1)).join('/').padStart(13);

/* How far an engine's own reflections are off the integral, and those of the
 * replacement: less than 0.85 times as far in the mean of spheres. */
const distances = [];
function judgeReflections({map, target, saved}) {
    const engine = engines[target], name = `${target} ${map}`;
    const fit = jobs.find(j => j.map === map && j.set === target + '-fit');
    const why = fit.failed || fit.said[0];
    verdict(fit.done && !why, `${name}: replaced: ${why || 'not drawn'}`);
    if (!fit.done)
        return;
    const [own, off] = [saved, fit.saved].map(from => mirrors.map(sphere =>
        reflections(engine, map, sphere).sides.map((side, k) =>
            distance(from[`${k}/${sphere.name}`], side, engine.decode))
            .reduce((a, b) => a.map((x, i) => Math.max(x, b[i])))));
    const share = [0, 1].map(k => mirrors.reduce((product, _, i) =>
        product * (off[i][k] / own[i][k]) ** (1 / mirrors.length), 1));
    for (const [kind, row] of [['own', own], ['fit', [...off, share]]])
        distances.push(target.padEnd(12) + map.padEnd(7) + kind.padEnd(6) +
            row.map(x => shown(x.map(y => 100 * y))).join(''));
    verdict(share[0] < 0.85 && share[1] < 0.9,
        `${name}: replaced: ${share} of its own`);
    mirrors.forEach((sphere, i) => {
        const [a, b] = [own[i][0], off[i][0]];
        verdict((map !== 'lamps' || a < 0.4) && b < 1.1 * a,
            `${name} ${sphere.name}: ${a.toFixed(3)}, replaced: ${b.toFixed(3)}`);
    });
}

function judge(job) {
    const {map, target, set, saved} = job, name = `${target} ${map}`;
    verdict(job.done && !job.failed, `${name}: ${job.failed || 'not drawn'}`);
    if (!job.done || set !== target)
        return;
    verdict(!job.said.length, `${name}: ${job.said[0]}`);
    const engine = engines[target];
    if (judged(engine, map))
        judgeReflections(job);
    if (map === 'lamps') {
        const wrong = misplaced(engine, saved);
        verdict(!wrong.length, `${name}: not right at ${wrong.join(', ')}`);
        return;
    }
    const half = jobs.find(j => j.map === map && j.set === engine.half);
    const exact = exactOf(job), light = exposure(job);
    const rows = {};
    for (const sphere of spheres) {
        const lit = engine.lit(exact, sphere);
        const tell = (to, off, bars) => {
            (rows[to] = rows[to] || {})[sphere.name] = off;
            verdict(off.every((x, i) => !(x > bars[i])), `${name} ` +
                `${sphere.name}: ${shown(off).trim()} from ${to}`);
        };
        if (half && half.done)
            tell('half', worst(engine, sphere, saved,
                (_, k) => half.saved[`${k}/${sphere.name}`]), BARS);
        if (lit)
            tell('exact', worst(engine, sphere, saved, view =>
                view.draw(engine, p => lit(p).map(x => light * x))),
                engine.exact(sphere, map) || [Infinity, Infinity, Infinity]);
    }
    for (const [to, row] of Object.entries(rows))
        console.log(target.padEnd(12) + map.padEnd(7) + to.padEnd(6) +
            spheres.map(s => row[s.name] ? shown(row[s.name]) :
                ' '.repeat(13)).join(''));
}

/* ---- what has only rules -------------------------------------------------- */

/* Directions all round. */
const around = [...Array(500).keys()].map(i => {
    const y = 1 - (2 * i + 1) / 500, p = i * Math.PI * (3 - Math.sqrt(5));
    return [Math.sqrt(1 - y * y) * Math.cos(p), y,
            Math.sqrt(1 - y * y) * Math.sin(p)];
});

/* The error of one function of a direction from another, of their mean square. */
function relative(got, want) {
    let sum = 0, all = 0;
    for (const d of around) {
        const a = got(d), b = want(d);
        for (let c = 0; c < 3; c++) {
            sum += (a[c] - b[c]) ** 2;
            all += b[c] ** 2;
        }
    }
    return Math.sqrt(sum / all);
}
async function judgeRule(map, target) {
    const rule = rules[target], name = `${target} ${map}`;
    const from = path.join(dir, map, target);
    const file = await rule.read(modules, from);
    if (map === 'lamps') {
        const wrong = lamps.filter(({axis, colour}) => file.radiance(axis, 0)
            .some((x, c) => x > 0.5 !== colour[c] > 0));
        verdict(!wrong.length, `${name}: not right at ` +
            wrong.map(({axis}) => axis.join(' ')).join(', '));
        return;
    }
    const exact = readExact(modules, path.join(dir, map), rule.chain);
    const most = exact.levels.length - 1;
    const errors = [0, 0.2, 0.4, 0.6, 0.8, 1].map(r => relative(
        d => file.radiance(d, r), d => lookup(exact.levels, d, r * most)));
    errors.push(relative(file.diffuse, n => file.harmonic ?
        harmonics(exact.sh, n) : lookup([exact.irradiance], n, 0)));
    console.log(target.padEnd(12) + map.padEnd(6) +
        errors.map(e => (100 * e).toFixed(2).padStart(8)).join(''));
    errors.forEach((e, i) => verdict(e <= rule.most,
        `${name} ${i < 6 ? i / 5 : 'diffuse'}: ${(100 * e).toFixed(2)} %`));
}

async function judgeProbe(map) {
    const from = path.join(dir, map, 'three');
    const {sh} = readExact(modules, path.join(dir, map), engines.three.chain);
    const e = relative(await lightProbe(modules, from), n => harmonics(sh, n));
    verdict(e < 1e-5, `three's LightProbe ${map}: ${(100 * e).toFixed(4)} %`);
}

await new Promise(go => server.listen(0, '127.0.0.1', go));
start(advance());
await finished;
stop();
server.close();
console.log('block bias / chroma shift / step, of 255, from half floats in ' +
    'the engine and exact levels by its lookups');
console.log(' '.repeat(25) +
    spheres.map(s => s.name.padStart(13)).join(''));
jobs.forEach(judge);
console.log('root mean square / worst block, in per cent of what is to be ' +
    'seen, from the integral');
console.log(' '.repeat(25) +
    mirrors.map(s => s.name.padStart(13)).join('') + 'fit / own'.padStart(13));
console.log(distances.join('\n'));
rmSync(profile, {recursive: true, force: true, maxRetries: 5});
console.log('readers after the rules: relative error in per cent');
for (const map of MAPS)
    await judgeProbe(map).catch(e =>
        verdict(false, `three's LightProbe ${map}: ${e.stack}`));
for (const map of new Set(['lamps', MAPS[0], MAPS[MAPS.length - 1]]))
    for (const target of Object.keys(rules))
        await judgeRule(map, target).catch(e =>
            verdict(false, `${target} ${map}: ${e.stack}`));
console.log(`${passed} passed, ${failed} failed`);
process.exit(failed ? 1 : 0);

// SPDX-License-Identifier: MIT
/*
 * node tests/clients/drive.mjs NPM DIR CHROMIUM [PICTURE]
 *
 * Draws the sets of files DIR/MAP/TARGET in the engines installed under
 * NPM/node_modules, in one browser, each loaded by the lines that
 * DIR/MAP/TARGET.js has for it, and compares the screen with what the exact
 * levels DIR/MAP/exact-N give by that engine's lookups (engines.mjs).
 * Prints a table; the last line is "N passed, N failed". PICTURE: a PNG to
 * write, of what the engines draw.
 */
import {spawn} from 'node:child_process';
import {existsSync, mkdtempSync, readFileSync, rmSync, statSync,
        writeFileSync} from 'node:fs';
import {createServer} from 'node:http';
import path from 'node:path';
import {fileURLToPath} from 'node:url';

import {readExact} from './exact.mjs';
import {engines, harmonics} from './engines.mjs';
import {lamps} from './lamps.mjs';
import {lookup} from './cube.mjs';
import {lightProbe, rules} from './rules.mjs';

const [npm, dir, chromium, picture] = process.argv.slice(2);
const here = path.dirname(fileURLToPath(import.meta.url));
const modules = path.resolve(npm, 'node_modules');
const SIZE = 192, SECONDS = 120;
/* Of all light, so that little of it is beyond white. */
const EXPOSURE = {lamps: 1, sun: 0.4, soft: 0.4};

/* The screen's mean difference of a sphere, of 255. Mirrors of PlayCanvas are
 * of a size that the screen decides. */
const MOST = 2;
const spheres = [
    ...[0, 0.2, 0.4, 0.6, 0.8, 1].map(roughness =>
        ({name: String(roughness), metal: 1, roughness})),
    {name: 'diffuse', metal: 0, roughness: 1}];
const ROUGH = spheres.slice(1, 6).map(s => s.name);

let passed = 0, failed = 0;
function verdict(good, what) {
    good ? passed++ : failed++;
    if (!good)
        console.log('FAILED: ' + what);
}

/* ---- pages ---------------------------------------------------------------- */

const MAPS = ['lamps', 'sun', 'soft'], jobs = [];
for (const map of MAPS)
    for (const target of Object.keys(engines))
        jobs.push({map, target, saved: {}, said: []});
let current = -1;

function page({map, target}) {
    const lines = readFileSync(path.join(dir, map, target + '.js'), 'utf8');
    return readFileSync(path.join(here, engines[target].page), 'utf8')
        .replace('/* SNIPPET */', () => lines);
}
const drawn = ({map}) => map === 'lamps' ? spheres.slice(0, 1) : spheres;

/* What the picture has: a row for each engine. */
const PICTURED = ['0', '0.4', 'diffuse'];
function tiles() {
    const rows = Object.keys(engines).map(target => ({
        label: target, tiles: ['sun', 'soft'].flatMap(map => {
            const i = jobs.findIndex(job => job.map === map &&
                job.target === target && job.done);
            return i < 0 ? [] : PICTURED.map(name =>
                ({name: /^d/.test(name) ? name : 'r = ' + name,
                  at: `/tile/${i}/${name}`}));
        })})).filter(row => row.tiles.length);
    return JSON.stringify({rows, size: SIZE});
}

/* The bytes of a path, or undefined. */
function file(where) {
    const [first, ...rest] = where.split('/').filter(Boolean);
    const job = jobs[current];
    if (where === '/tiles')
        return tiles();
    if (first === 'tile')
        return jobs[rest[0]].saved[rest[1]];
    if (where === '/picture.html')
        return readFileSync(path.join(here, 'picture.html'));
    if (where === '/clients/page.js')
        return readFileSync(path.join(here, 'page.js'), 'utf8')
            .replace('/* SPHERES */ []', JSON.stringify(drawn(job)))
            .replace('/* EYE */ [4, 4, 4]',
                     JSON.stringify(engines[job.target].eye))
            .replace('/* EXPOSURE */ 1', EXPOSURE[job.map]);
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
        job.until = Date.now();
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
    jobs[current].since = Date.now();
    timer = setTimeout(() => fail(`nothing for ${SECONDS} s`), SECONDS * 1000);
    return `/${jobs[current].map}/${jobs[current].target}/page.html`;
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

/* ---- the screen ----------------------------------------------------------- */

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const unit = a => a.map(x => x / Math.hypot(...a));
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                         a[0] * b[1] - a[1] * b[0]];

/* Normal and view of each pixel that the unit sphere covers, but its rim, in
 * the engine's axes; null elsewhere. */
function sight({left, eye}) {
    const ahead = unit(eye.map(x => -x));
    const side = (a, b) => left ? cross(b, a) : cross(a, b);
    const right = unit(side(ahead, [0, 1, 0])), up = side(right, ahead);
    const tan = Math.tan(Math.PI / 18), pixels = [];
    for (let y = 0; y < SIZE; y++)
        for (let x = 0; x < SIZE; x++) {
            const across = tan * (2 * (x + 0.5) / SIZE - 1);
            const upwards = tan * (1 - 2 * (y + 0.5) / SIZE);
            const ray = unit(ahead.map((a, i) =>
                a + across * right[i] + upwards * up[i]));
            const b = dot(eye, ray), in2 = b * b - dot(eye, eye) + 1;
            const n = eye.map((e, i) => e + (-b - Math.sqrt(in2)) * ray[i]);
            const v = ray.map(r => -r);
            pixels.push(in2 > 0 && dot(n, v) > 0.15 ? {n, v} : null);
        }
    return pixels;
}

/* How much a normal differs from the next pixels', the most of an axis. */
function slope(pixels, i) {
    const x = i % SIZE & ~1, y = Math.floor(i / SIZE) & ~1;
    const [a, b, c] = [[x, y], [x + 1, y], [x, y + 1]].map(
        ([u, v]) => pixels[v * SIZE + u] || pixels[i]);
    return Math.max(...a.n.map((n, k) => Math.max(
        Math.abs(b.n[k] - n), Math.abs(c.n[k] - n))));
}

/* Mean difference in 8 bits between a picture and what is expected. */
function difference(engine, exact, exposure, sphere, picture) {
    const pixels = sight(engine);
    let sum = 0, count = 0;
    pixels.forEach((pixel, i) => {
        if (!pixel)
            return;
        const {n, v} = pixel;
        const light = sphere.metal ?
            engine.radiance(exact, n, v, sphere.roughness, slope(pixels, i)) :
            engine.diffuse(exact, n, v);
        for (let c = 0; c < 3; c++) {
            const held = Math.min(1, Math.max(0, exposure * light[c]));
            sum += Math.abs(picture[4 * i + c] - 255 * engine.encode(held));
            count++;
        }
    });
    return sum / count;
}

/* The lamps that are not where they belong in the picture of a mirror. */
function misplaced(engine, picture) {
    const pixels = sight(engine);
    return lamps.filter(({axis, colour}) => {
        let best = -1, at = -1;
        pixels.forEach((pixel, i) => {
            if (!pixel)
                return;
            const {n, v} = pixel;
            const r = n.map((x, k) => 2 * dot(n, v) * x - v[k]);
            const near = dot(engine.world(r), axis);
            if (near > best)
                [best, at] = [near, i];
        });
        return colour.some((c, k) => (picture[4 * at + k] > 200) !== c > 0 );
    }).map(({axis}) => axis.join(' '));
}

/* ---- what was drawn ------------------------------------------------------- */

function judge(job) {
    const {map, target, saved} = job;
    const name = `${target} ${map}`;
    verdict(job.done && !job.failed, `${name}: ${job.failed || 'not drawn'}`);
    verdict(!job.said.length, `${name}: ${job.said[0]}`);
    if (!job.done)
        return;
    const engine = engines[target];
    if (map === 'lamps') {
        const wrong = misplaced(engine, saved[0]);
        verdict(!wrong.length, `${name}: not right at ${wrong.join(', ')}`);
        return;
    }
    const exact = readExact(modules, path.join(dir, map), engine.chain);
    let row = target.padEnd(12) + map.padEnd(6);
    for (const sphere of drawn(job)) {
        const off = difference(engine, exact, EXPOSURE[map], sphere,
                               saved[sphere.name]);
        row += off.toFixed(2).padStart(8);
        if (ROUGH.includes(sphere.name) || sphere.name === 'diffuse')
            verdict(off <= (sphere.roughness === 1 && sphere.metal &&
                engine.roughest || MOST), `${name} ${sphere.name}: ` +
                `${off.toFixed(2)} of 255 from the exact levels`);
    }
    console.log(row + `   ${((job.until - job.since) / 1000).toFixed(1)} s`);
}

/* ---- what has only rules -------------------------------------------------- */

/* Directions all round. */
const around = [...Array(2000).keys()].map(i => {
    const y = 1 - (2 * i + 1) / 2000, p = i * Math.PI * (3 - Math.sqrt(5));
    return [Math.sqrt(1 - y * y) * Math.cos(p), y,
            Math.sqrt(1 - y * y) * Math.sin(p)];
});

/* The error of one function of a direction from another, of their mean square,
 * but beside texels that may have been above the largest. */
function relative(got, want, largest = Infinity) {
    let sum = 0, all = 0;
    for (const d of around) {
        const a = got(d), b = want(d);
        if (Math.max(...b) > largest / 4)
            continue;
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
        d => file.radiance(d, r), d => lookup(exact.levels, d, r * most),
        rule.largest));
    errors.push(relative(file.diffuse, n => file.harmonic ?
        harmonics(exact.sh, n) : lookup([exact.irradiance], n, 0)));
    console.log(target.padEnd(12) + map.padEnd(6) +
        errors.map(e => (100 * e).toFixed(2).padStart(8)).join(''));
    errors.forEach((e, i) => verdict(e <= rule.most,
        `${name} ${spheres[i].name}: ${(100 * e).toFixed(2)} %`));
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
console.log('mean difference from the exact levels, of 255');
console.log('target      map   ' +
    spheres.map(s => s.name.padStart(8)).join(''));
jobs.forEach(judge);
rmSync(profile, {recursive: true, force: true, maxRetries: 5});
console.log('readers after the rules: relative error in per cent');
for (const map of MAPS.slice(1))
    await judgeProbe(map).catch(e =>
        verdict(false, `three's LightProbe ${map}: ${e.stack}`));
for (const map of MAPS)
    for (const target of Object.keys(rules))
        await judgeRule(map, target).catch(e =>
            verdict(false, `${target} ${map}: ${e.stack}`));
console.log(`${passed} passed, ${failed} failed`);
process.exit(failed ? 1 : 0);

// SPDX-License-Identifier: MIT
/* The page: what was dropped is baked, shown, judged and packed. */
import {zipSync} from './three/examples/jsm/libs/fflate.module.js';
import {bake, convert, run as runProgram} from './iblbake/index.mjs';
import {MATERIALS, MEASURED, ROUGHNESS, createView} from './view.js';

const $ = id => document.getElementById(id);
const form = $('form').elements, GRIDS = [48, 96], WHITE = 0.25;
/* The open map {name, bytes, half}, or texture; what was made of it; the chosen
 * sphere. */
let map = null, made = null, sphere = {row: 0, column: 2}, view = null;

const bytesOf = n => n < 1e6 ? `${(n / 1e3).toFixed(n < 1e4 ? 1 : 0)} kB` :
    `${(n / 1e6).toFixed(2)} MB`;
const timeOf = ms => ms < 1000 ? `${ms.toFixed()} ms` :
    `${(ms / 1000).toFixed(2)} s`;
const percent = x => `${(100 * x).toFixed(x < 0.0995 ? 2 : 1)} %`;
/* Files of the baker are in folders of its own. */
const plain = text => text.trim().replaceAll('./in/', '');
function fail(e) {
    if (e === STOPPED)
        return;
    $('said').textContent = plain(e.message ?? e).split('\n').pop();
    $('said').hidden = false;
}

/* ---- workers: the baker has its own; exact.js answers the last question ------------ */

const STOPPED = Symbol('stopped');
let stopper = new AbortController();
async function run(call, {bytes, name}, options) {
    stopper.abort(STOPPED);
    const {signal} = stopper = new AbortController(), start = performance.now();
    document.body.classList.add('busy');
    $('progress').value = 0;
    try {
        const result = await call(bytes, {...options, name, signal,
            onProgress: part => $('progress').value = part});
        return {...result, time: performance.now() - start};
    } finally {
        if (stopper.signal === signal)
            document.body.classList.remove('busy');
    }
}
const exact = new Worker('exact.js', {type: 'module'});
let asked = 0;
const ask = question => new Promise((go, fail) => {
    const id = ++asked;
    exact.onmessage = ({data}) => data.id === id &&
        (data.error ? fail(Error(data.error)) : go(data));
    exact.onerror = e => fail(Error(e.message || 'the browser has no more memory'));
    exact.postMessage({...question, id});
});

/* ---- options, and their command line --------------------------------------------- */

const dashed = key => '--' + key.replace(/[A-Z]/g, c => '-' + c.toLowerCase());
function options({texture}) {
    const of = Object.fromEntries(new FormData($('form'))), out = {};
    const engine = of.kind === 'engine', levels = of.what === 'levels';
    if (engine)
        Object.assign(out, {target: of.target, size: of.size, pixel: of.pixel,
                            format: of.format});
    else if (!texture)
        Object.assign(out, levels ? {only: 'specular,irradiance', size: of.size} :
            {only: 'skybox', skybox: of.size || 512});
    if (!engine)
        Object.assign(out, {format: of.picture, layout: of.layout},
                      of.picture === 'png' && {tone: of.tone});
    if (!texture)
        Object.assign(out, {rotate: +of.rotation, exposure: +of.exposure});
    for (const key in out)
        out[key] || delete out[key];
    // More, as the words of a command line.
    let key;
    for (const [word] of of.more.matchAll(/"[^"]*"|\S+/g))
        if (/^-+[a-z]/i.test(word)) {
            const [name, value] = word.replace(/^-+/, '').split(/=(.*)/);
            key = name.replace(/-./g, c => c[1].toUpperCase());
            out[key] = value ?? true;
        } else if (key)
            out[key] = word.replace(/"/g, '');
        else
            throw Error(`More options: ${word} follows no option`);
    return out;
}
function command(chosen) {
    const quoted = word => /^[\w.,:+-]+$/.test(word) ? word :
        `'${word.replace(/'/g, "'\\''")}'`;
    return ['iblbake', ...map.texture ? ['convert'] : [],
        ...Object.entries(chosen).flatMap(([key, value]) => value === true ?
            [dashed(key)] : [dashed(key), quoted(String(value))]),
        quoted(map.name), ...map.texture ? ['out.' + chosen.format] :
            ['-o', 'out']].join(' ');
}

/* ---- a map, its picture and its files -------------------------------------------- */

const READING = ['layer', 'part', 'anyAspect', 'inputLayout', 'faceOrder',
    'inputTransfer', 'primaries', 'clamp'];
async function open(file) {
    const start = performance.now(), {name} = file;
    const next = {name, texture: /\.(ktx2|ktx|dds|env)$/i.test(name)};
    $('said').hidden = true;
    try {
        next.bytes = await file.arrayBuffer();
        if (next.texture)
            form.kind.value = 'pictures';
        else {
            const given = Object.entries(options(next)).filter(([key]) =>
                READING.includes(key));
            const {files, time} = await run(bake, next, {only: 'specular',
                mapping: 'filament', size: 256, levels: 5, mirror: 'x',
                ...Object.fromEntries(given)});
            [next.half] = Object.values(files);
            view?.prefilter(null);
            await view?.show(next.half, true, {});
            performance.measure('picture', {start});
            $('shown').textContent = `half floats, ${timeOf(time)}`;
            $('own').textContent = $('how').textContent = '';
            $('empty').hidden = !!view;
        }
        map = next;
        made = null;
        $('choices').hidden = true;
        $('choices').tBodies[0].replaceChildren();
        kinds();
        const reading = view && !next.texture && ask({bytes: next.bytes});
        await make().catch(fail);
        if (reading && map === next)
            await compare(next, reading);
    } catch (e) {
        fail(e);
    }
}
/* Beside three.js itself, which holds the page up, and the truth. */
async function compare(of, reading) {
    try {
        const took = await view.prefilter(await reading);
        $('own').textContent = `in ${timeOf(took)}, each time a page loads`;
        of.exact = true;
        judge();
    } catch (e) {
        $('how').textContent = `No comparison: ${e.message}.`;
    }
}

let later;
function soon(wait = 250) {
    clearTimeout(later);
    later = map && setTimeout(() => make().catch(fail), wait);
}
async function make() {
    clearTimeout(later);
    $('said').hidden = $('download').disabled = true;
    const of = map, chosen = options(of), {target} = chosen;
    const done = await run(of.texture ? convert : bake, of, {...chosen,
        quiet: true, ...of.texture && {to: `out.${chosen.format}`},
        ...target && {explain: true}});
    const bytes = Object.values(done.files).reduce((n, f) => n + f.length, 0);
    made = {...done, chosen, bytes, code: target ? done.text :
        'No target: no program.'};
    $('warning').textContent = plain(done.log);
    $('status').textContent = `${bytesOf(bytes)} in ${timeOf(done.time)}`;
    $('download').disabled = false;
    choice(made);
    tell();
    const cube = target === 'three' && !chosen.sun && !chosen.lights &&
        Object.keys(done.files).find(name => /_specular\.ktx2$/.test(name));
    if (!view || of.texture || !cube && !of.loaded)
        return;
    of.loaded = cube;
    await view.show(cube ? done.files[cube] : of.half, !cube, cube ? chosen : {});
    $('shown').textContent = cube ? `${bytesOf(bytes)}, as three.js loads it` :
        'half floats';
    judge();
}
function tell() {
    const {value} = document.querySelector('[name=tab]:checked');
    $('text').classList.toggle('wrap', value === 'command');
    $('text').textContent = !made ? '' : value === 'code' ? made.code :
        value === 'command' ? command(made.chosen) :
        Object.entries(made.files).map(([name, f]) =>
            `${bytesOf(f.length).padStart(8)}  ${name}`).join('\n');
}
/* A row of the table of choices, which can be taken again. */
function choice({chosen, bytes, time}) {
    const name = Object.entries(chosen).map(([key, value]) => /target|format/
        .test(key) ? value : `${key} ${value}`).join(', ') || 'textures';
    const state = new FormData($('form')), [body] = $('choices').tBodies;
    [...body.rows].find(row => row.cells[0].textContent === name)?.remove();
    const row = made.row = body.insertRow(0);
    const button = document.createElement('button');
    button.textContent = name;
    button.onclick = () => {
        state.forEach((value, key) => form[key].value = value);
        kinds();
        look();
        soon(0);
    };
    row.insertCell().append(button);
    for (const text of [bytesOf(bytes), timeOf(time), ''])
        row.insertCell().textContent = text;
    $('choices').hidden = false;
}
function download() {
    const text = string => new TextEncoder().encode(string + '\n');
    const zip = zipSync({...made.files, 'code.txt': text(made.code),
        'command.txt': text(command(made.chosen))}, {level: 0});
    const a = document.createElement('a');
    a.href = URL.createObjectURL(new Blob([zip], {type: 'application/zip'}));
    a.download = map.name.replace(/\.[^.]*$/, '') + '.zip';
    a.click();
    setTimeout(() => URL.revokeObjectURL(a.href), 10000);
}

/* ---- the chosen sphere ----------------------------------------------------------- */

const [ours, truth, theirs, ourError, theirError] = ['iblbake', 'exact',
    'three.js', 'iblbake off', 'three.js off'].map(name => {
    const figure = document.createElement('figure');
    figure.append(document.createElement('canvas'), name);
    $('pictures').append(figure);
    return figure.firstChild;
});
/* Khronos' neutral curve, as three.js has it, then sRGB. */
function tone(rgb) {
    const low = Math.min(...rgb), off = low < 0.08 ? low - 6.25 * low * low : 0.04;
    const c = rgb.map(x => x - off), peak = Math.max(...c, 1e-9), bright = peak > 0.76;
    const most = bright ? 1 - 0.0576 / (peak - 0.52) : peak;
    const grey = bright ? 1 - 1 / (0.15 * (peak - most) + 1) : 0;
    return c.map(x => x * most / peak).map(x => x + (most - x) * grey)
        .map(x => 255 * (x < 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055));
}
const heat = x => [2.2 * x, 1.55 * x - 0.25, 4 * x - 3].map(y => 255 * y);
function paint(canvas, n, colour, mark = -1) {
    const to = canvas.getContext('2d'), image = new ImageData(n, n);
    canvas.width = canvas.height = n;
    for (let i = 0; i < n * n; i++)
        image.data.set([...colour(i), 255], 4 * i);
    to.putImageData(image, 0, 0);
    to.strokeStyle = '#fff';
    to.arc(mark % n + 0.5, Math.floor(mark / n) + 0.5, n / 16, 0, 7);
    mark >= 0 && to.stroke();
}
/* Errors of a picture: of each place, of all, and the worst, as parts of the root
 * mean square. The rim, which pixels cut, does not count. */
function errors(light, pixels, n) {
    const map = new Float32Array(n * n), half = MEASURED / n;
    let sum = 0, all = 0, count = 0, where = 0;
    const seen = i => 4 * (Math.floor((i % n + 0.5) * half) + MEASURED *
        (MEASURED - 1 - Math.floor((Math.floor(i / n) + 0.5) * half)));
    for (let i = 0; i < n * n; i++) {
        const middle = x => (2 * x + 1) / n - 1;
        if (middle(i % n) ** 2 + middle(Math.floor(i / n)) ** 2 > 0.96)
            continue;
        for (let c = 0; c < 3; c++) {
            map[i] += (pixels[seen(i) + c] - light[3 * i + c]) ** 2;
            all += light[3 * i + c] ** 2;
        }
        sum += map[i];
        count++;
        where = map[i] > map[where] ? i : where;
    }
    map.forEach((x, i) => map[i] = Math.sqrt(x * count / all));
    return {rms: Math.sqrt(sum / all), worst: map[where], where, map, seen};
}
/* Coarsely first. */
async function judge() {
    if (!map?.exact)
        return;
    const of = map, {row, column} = sphere, {row: line} = made ?? {};
    const drawn = view.measure(sphere), bright = 2 ** form.exposure.value;
    const turn = form.rotation.value * Math.PI / 180;
    for (const n of GRIDS) {
        const start = performance.now(), got = await ask({n, turn,
            pixel: 2 / MEASURED, sphere: {...MATERIALS[row],
            roughness: ROUGHNESS[column]}}).catch(fail);
        if (!got || map !== of)
            return;
        const picture = (from, at) => i => tone([0, 1, 2].map(c =>
            bright * from[at(i) + c]));
        paint(truth, n, picture(got.light, i => 3 * i));
        const off = drawn.map((pixels, k) => {
            const e = errors(got.light, pixels, n);
            paint([ours, theirs][k], n, picture(pixels, e.seen));
            paint([ourError, theirError][k], n, i => heat(e.map[i] / WHITE), e.where);
            $(`rms${k}`).textContent = percent(e.rms);
            $(`worst${k}`).textContent = percent(e.worst);
            return [e.rms, e.worst];
        });
        $('how').textContent = `${MATERIALS[row].name} of roughness ` +
            `${ROUGHNESS[column]}: the sum over all pixels of the map, exact to ` +
            `${percent(got.exact)}, in ${timeOf(performance.now() - start)}; ` +
            'errors as parts of its root mean square, bright from ' +
            `${100 * WHITE} %, the worst in a ring.`;
        if (line && of.loaded)
            line.cells[3].textContent = percent(off[0][0]);
        document.body.dataset.judged =
            JSON.stringify({row, column, off, exact: got.exact, n});
    }
}

/* ---- controls -------------------------------------------------------------------- */

const fill = (name, rows) => form[name].append(...rows.map(row =>
    new Option(...[row].flat())));
fill('target', ['three', 'babylon', 'babylon-env', 'filament', 'bevy', 'playcanvas',
    'gltf', 'cesium', 'unreal', 'unity', 'godot', ['no engine: textures', '']]);
fill('size', [['as usual', ''], 64, 128, 256, 384, 512, 1024, 2048]);
fill('pixel', [['as the target has', ''], 'rgba16f', 'rgba32f', 'rgb9e5',
    'r11g11b10f', 'bc6h', 'uastc-hdr', 'astc4x4hdr']);
fill('format', [['as the target has', ''], 'ktx2', 'ktx', 'dds', 'dds-legacy', 'env',
    'gltf', 'playcanvas']);
const radios = (name, labels) => $(name).innerHTML = labels.map((text, i) => '<label>' +
    `<input type="radio" name="${name}" value="${i}"><span>${text}</span></label>`)
    .join('');
radios('row', MATERIALS.map(m => m.name));
radios('column', ROUGHNESS);
function pick(which) {
    sphere = {row: +which.row, column: +which.column};
    for (const key in sphere)
        $('sphere').elements[key].value = sphere[key];
    judge();
}
function kinds() {
    for (const label of document.querySelectorAll('[data-kind]'))
        label.hidden = label.dataset.kind !== form.kind.value;
}
function look() {
    const [exposure, rotation] = [+form.exposure.value, +form.rotation.value];
    $('ev').textContent = `${exposure} EV`;
    $('deg').textContent = `${rotation}°`;
    view?.set({exposure, rotation, background: form.background.value});
}
function settle(e) {
    kinds();
    judge();
    e?.target.name === 'background' || soon();
}
function turned(degrees, end) {
    form.rotation.value = Math.round(degrees);
    look();
    end && settle();
}
$('sphere').onchange = () => pick(Object.fromEntries(new FormData($('sphere'))));
$('form').oninput = look;
$('form').onchange = settle;
$('form').onsubmit = e => e.preventDefault();
$('tabs').onchange = tell;
$('stop').onclick = () => stopper.abort(STOPPED);
$('download').onclick = download;
$('copy').onclick = () =>
    navigator.clipboard.writeText($('text').textContent).catch(fail);

/* Models are shown, everything else is a map. */
async function take(files) {
    const list = [...files];
    if (!list.some(f => /\.gl(b|tf)$/i.test(f.name)))
        return list.length && open(list[0]);
    await view?.model(list).catch(fail);
    map ?? $('forest.exr').click();
}
const sample = async e => take([new File([await (await fetch('data/' +
    e.target.id)).blob()], e.target.id)]);
for (const name of ['forest.exr', 'sky.exr', 'knot.glb'])
    $(name).onclick = e => sample(e).catch(fail);
$('balls').onclick = () => view?.model(null);
$('open').onclick = $('model').onclick = () => {
    $('file').value = '';
    $('file').click();
};
$('file').onchange = () => take($('file').files);
for (const kind of ['dragover', 'dragleave', 'drop'])
    addEventListener(kind, e => {
        e.preventDefault();
        document.body.classList.toggle('over', kind === 'dragover');
        kind === 'drop' && take(e.dataTransfer.files);
    });

try {
    view = createView($('view'), pick, turned);
} catch {
    fail('This browser draws no WebGL 2: maps are baked and packed all the same, ' +
        'without pictures.');
}
look();
settle();
pick(sphere);
navigator.serviceWorker?.register('sw.js').catch(() => {});
await Promise.all([view?.warm(), runProgram(['--version'])]);
document.body.dataset.ready = '';

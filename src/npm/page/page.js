// SPDX-License-Identifier: MIT
/* The page: what was dropped is baked, shown, judged and packed. */
import {zipSync} from './three/examples/jsm/libs/fflate.module.js';
import {MATERIALS, MEASURED, ROUGHNESS, createView} from './view.js';

const $ = id => document.getElementById(id);
const form = $('form').elements, GRIDS = [48, 96], ERRORS = 0.25;
const TARGETS = ['three', 'babylon', 'babylon-env', 'filament', 'bevy',
    'playcanvas', 'gltf', 'cesium', 'unreal', 'unity', 'godot', 'none'];
let map = null, made = null, sphere = {row: 0, column: 2}, view = null, judged;

/* ---- what is said ---------------------------------------------------------- */

const bytesOf = n => n < 1e6 ? `${(n / 1e3).toFixed(n < 1e4 ? 1 : 0)} kB` :
    `${(n / 1e6).toFixed(2)} MB`;
const timeOf = ms => ms < 1000 ? `${ms.toFixed()} ms` :
    `${(ms / 1000).toFixed(2)} s`;
const percent = x => `${(100 * x).toFixed(x < 0.0995 ? 2 : 1)} %`;
function fail(what) {
    $('said').textContent = String(what?.message ?? what).trim().split('\n').pop();
    $('said').hidden = false;
}
async function trying(work) {
    try {
        return await work();
    } catch (e) {
        if (e !== STOPPED)
            fail(e);
    }
}

/* ---- workers: one question at a time, a new one ends it ------------------------ */

const STOPPED = Symbol('stopped');
class Asked {
    #worker = null;
    #wait = null;
    #id = 0;
    constructor(name, keep) {
        Object.assign(this, {name, keep});
        this.#start();
    }
    #start() {
        this.#worker?.terminate();
        this.#worker = new Worker(this.name, {type: 'module'});
        this.#worker.onmessage = ({data}) => {
            if (data.id !== this.#id || !this.#wait)
                return;
            if ('progress' in data)
                return this.#wait.tell?.(data.progress);
            const {go, fail} = this.#wait;
            this.#wait = null;
            data.error ? fail(Error(data.error)) : go(data.result ?? data);
        };
        this.#worker.onerror = e => {
            e.preventDefault();
            this.#wait?.fail(Error(e.message || 'the worker ended: the browser ' +
                'gives it no more memory'));
            this.#wait = null;
            this.#start();
        };
    }
    stop() {
        if (!this.#wait)
            return;
        this.#wait.fail(STOPPED);
        this.#wait = null;
        if (!this.keep)
            this.#start();
    }
    ask(question, tell) {
        this.stop();
        this.#worker.postMessage({...question, id: ++this.#id});
        return new Promise((go, fail) => this.#wait = {go, fail, tell});
    }
}
const baker = new Asked('baker.js'), exact = new Asked('exact.js', true);

async function run(call, {bytes, name}, options) {
    $('progress').hidden = $('stop').hidden = false;
    $('progress').value = 0;
    const start = performance.now();
    try {
        const result = await baker.ask({call, bytes, options: {...options, name}},
            x => $('progress').value = x);
        return {...result, time: performance.now() - start};
    } finally {
        $('progress').hidden = $('stop').hidden = true;
    }
}

/* ---- options and their command line -------------------------------------------- */

const dashed = key => '--' + key.replace(/[A-Z]/g, c => '-' + c.toLowerCase());
const camel = word => word.replace(/^-+/, '').replace(/-./g,
    c => c[1].toUpperCase());
/* Words of a command line as options. */
function more(text) {
    const out = {};
    let key;
    for (const word of text.match(/"[^"]*"|\S+/g) ?? [])
        if (/^--?[a-z]/i.test(word)) {
            const [name, value] = word.split(/=(.*)/);
            out[key = camel(name)] = value ?? true;
        } else if (key)
            out[key] = word.replace(/"/g, '');
        else
            throw Error(`More options: ${word} follows no option`);
    return out;
}
function options() {
    const {value: kind} = form.kind, size = form.size.value, out = {};
    if (kind === 'pictures') {
        const levels = form.what.value === 'levels' || map.texture;
        if (!map.texture)
            Object.assign(out, levels ? {only: 'specular,irradiance'} :
                {only: 'skybox', skybox: +size || map.edge || 512});
        if (levels && size && !map.texture)
            out.size = +size;
        Object.assign(out, {format: form.picture.value,
                            layout: form.layout.value});
        if (out.format === 'png')
            out.tone = form.tone.value;
    } else {
        if (form.target.value !== 'none')
            out.target = form.target.value;
        if (size)
            out.size = +size;
        for (const key of ['pixel', 'format'])
            if (form[key].value)
                out[key] = form[key].value;
    }
    if (!map.texture && +form.rotation.value)
        out.rotate = +form.rotation.value;
    if (!map.texture && +form.exposure.value)
        out.exposure = +form.exposure.value;
    return {...out, ...more(form.more.value)};
}
const quoted = word => /[^\w.,:+-]/.test(word) ?
    `'${word.replace(/'/g, "'\\''")}'` : word;
const command = chosen => ['iblbake', ...map.texture ? ['convert'] : [],
    ...Object.entries(chosen).flatMap(([key, value]) => value === true ?
        [dashed(key)] : [dashed(key), quoted(String(value))]),
    quoted(map.name), ...map.texture ? ['out.' + chosen.format] :
        ['-o', 'out']].join(' ');

/* ---- a map, its picture and its files -------------------------------------------- */

const TEXTURES = /\.(ktx2|ktx|dds|env)$/i;
async function open(file) {
    const start = performance.now();
    $('said').hidden = true;
    const bytes = await file.arrayBuffer();
    const next = {name: file.name, bytes, texture: TEXTURES.test(file.name)};
    const before = map;
    await trying(async () => {
        if (next.texture) {
            map = next;
            form.kind.value = 'pictures';
        } else {
            const {files, time} = await run('bake', next, {only: 'specular',
                mapping: 'filament', size: 384, levels: 5, mirror: 'x'});
            map = next;
            next.half = Object.values(files)[0];
            await picture(next.half, true, {});
            $('empty').hidden = true;
            performance.measure('picture', {start});
            $('shown').textContent = `half floats, ${timeOf(time)}`;
            $('status').textContent =
                `Picture ${timeOf(performance.now() - start)} after the drop.`;
        }
        made = null;
        $('choices').tBodies[0].replaceChildren();
        $('choices').hidden = true;
        if (!next.texture)
            compare(next);
        await make();
    });
    if (!map)
        map = before;
}
async function picture(bytes, half, baked) {
    await view?.show(bytes, half, baked);
}
/* Beside three.js itself, and the truth. */
async function compare(next) {
    $('own').textContent = '';
    await view?.prefilter(null);
    try {
        const {w, h, half} = await exact.ask({bytes: next.bytes});
        next.edge = 2 ** Math.round(Math.log2(w / 4));
        next.exact = true;
        if (map !== next || !view)
            return;
        const took = await view.prefilter({w, h, half});
        $('own').textContent = `in ${timeOf(took)}, each time a page loads`;
        judge();
    } catch (e) {
        if (e !== STOPPED)
            $('how').textContent = `No comparison: ${e.message}.`;
    }
}

let later;
function soon(wait = 250) {
    clearTimeout(later);
    later = setTimeout(() => map && trying(make), wait);
}
async function make() {
    clearTimeout(later);
    $('said').hidden = true;
    $('download').disabled = true;
    const of = map, chosen = options();
    const done = await run(of.texture ? 'convert' : 'bake', of,
        {...chosen, ...chosen.target && {explain: true}, quiet: true});
    const bytes = Object.values(done.files).reduce((n, f) => n + f.length, 0);
    // The program, and what there is to say.
    const lines = done.log.split('\n'), said = /^iblbake: /;
    made = {...done, chosen, bytes,
        code: chosen.target ? lines.filter(l => !said.test(l)).join('\n').trim() :
            'No target: the files are for a program of your own.'};
    $('warning').textContent = lines.filter(l => said.test(l)).join('\n');
    $('status').textContent = `${bytesOf(bytes)} in ${timeOf(done.time)}`;
    $('download').disabled = false;
    made.row = choice(made);
    const cube = Object.keys(done.files).find(n => /_specular\.ktx2$/.test(n));
    const three = chosen.target === 'three' && cube && !chosen.sun &&
        !chosen.lights;
    if (view && (three || of.baked) && !of.texture) {
        of.baked = three;
        await picture(three ? done.files[cube] : of.half, !three,
                      three ? chosen : {});
        $('shown').textContent = three ? `${bytesOf(bytes)}, as three.js loads it` :
            'half floats';
        judge();
    }
    tell();
}
function tell() {
    const {value} = document.querySelector('[name=tab]:checked');
    $('files').classList.toggle('wrap', value === 'command');
    $('copy').hidden = value === 'files' || !made;
    $('files').textContent = !made ? '' : value === 'code' ? made.code :
        value === 'command' ? command(made.chosen) :
        Object.entries(made.files).map(([name, f]) =>
            `${bytesOf(f.length).padStart(8)}  ${name}`).join('\n');
}
/* A row of the table of choices, which can be taken again. */
function choice({chosen, bytes, time}) {
    const name = Object.entries(chosen).map(([key, value]) => /target|format/
        .test(key) ? value : `${key} ${value}`).join(', ') || 'textures';
    const body = $('choices').tBodies[0];
    [...body.rows].find(row => row.cells[0].textContent === name)?.remove();
    const row = body.insertRow(0), button = document.createElement('button');
    const state = [...new FormData($('form'))];
    button.textContent = name;
    button.onclick = () => {
        state.forEach(([key, value]) => form[key].value = value);
        look();
        kinds();
        soon(0);
    };
    row.insertCell().append(button);
    [bytesOf(bytes), timeOf(time), ''].forEach(t =>
        row.insertCell().textContent = t);
    $('choices').hidden = false;
    return row;
}

/* ---- the chosen sphere --------------------------------------------------------- */

const figures = ['iblbake', 'exact', 'three.js', 'iblbake off', 'three.js off']
    .map(name => {
        const figure = document.createElement('figure');
        const canvas = document.createElement('canvas');
        figure.append(canvas, name);
        $('pictures').append(figure);
        return canvas;
    });
/* Khronos' neutral curve, as three.js has it, then sRGB. */
function tone(rgb) {
    const low = Math.min(...rgb), off = low < 0.08 ? low - 6.25 * low * low : 0.04;
    const c = rgb.map(x => x - off), peak = Math.max(...c), d = 0.24;
    const most = peak < 0.76 ? peak : 1 - d * d / (peak + d - 0.76);
    const grey = peak < 0.76 ? 0 : 1 - 1 / (0.15 * (peak - most) + 1);
    return c.map(x => x * most / (peak || 1)).map(x => x + (most - x) * grey)
        .map(x => 255 * (x < 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) -
            0.055));
}
const heat = x => [0, 1, 2].map(c => 255 * Math.min(1, Math.max(0,
    [2.2, 1.55, 0.75][c] * x - [0, 0.25, 0.4][c] + (x > 0.8 ? 5 * x - 4 : 0))));
function paint(canvas, n, colour, mark) {
    canvas.width = canvas.height = n;
    const to = canvas.getContext('2d'), image = to.createImageData(n, n);
    for (let i = 0; i < n * n; i++) {
        const rgb = colour(i);
        rgb.every(x => x === x) && image.data.set([...rgb, 255], 4 * i);
    }
    to.putImageData(image, 0, 0);
    if (mark === undefined)
        return;
    to.strokeStyle = '#fff';
    to.beginPath();
    to.arc(mark % n + 0.5, Math.floor(mark / n) + 0.5, n / 16, 0, 7);
    to.stroke();
}
async function judge() {
    if (!view || !map?.exact)
        return;
    const of = map, {row, column} = sphere, roughness = ROUGHNESS[column];
    const drawn = view.measure(sphere), kept = made?.row;
    const turn = +form.rotation.value * Math.PI / 180;
    for (const n of GRIDS) {
        const asked = performance.now();
        const got = await exact.ask({n, pixel: 2 / MEASURED, turn,
            sphere: {...MATERIALS[row], roughness}}).catch(() => null);
        if (!got?.light || map !== of)
            return;
        const off = drawn.map(pixels => pixels && measure(got.light, pixels, n));
        off.forEach((o, k) => {
            $(`rms${k}`).textContent = o ? percent(o.rms) : '–';
            $(`worst${k}`).textContent = o ? percent(o.worst) : '–';
        });
        const ev = 2 ** form.exposure.value, at = (p, i, s) =>
            tone([0, 1, 2].map(c => ev * p[s(i) + c]));
        paint(figures[1], n, i => at(got.light, i, k => 3 * k));
        off.forEach((o, k) => o && [paint(figures[2 * k], n, i =>
            got.light[3 * i] >= 0 ? at(drawn[k], i, o.place) : [NaN]),
            paint(figures[3 + k], n, i => heat(o.map[i] / ERRORS), o.where)]);
        $('how').textContent = `${MATERIALS[row].name} of roughness ${roughness}: ` +
            `the sum over all pixels of the map, exact to ${percent(got.exact)}, ` +
            `in ${timeOf(performance.now() - asked)}; errors as parts of its root ` +
            `mean square, white from ${100 * ERRORS} %, the worst in a ring.`;
        if (kept && off[0] && of.baked)
            kept.cells[3].textContent = percent(off[0].rms);
        judged = {sphere: {row, column}, off: off.map(o => o && [o.rms, o.worst]),
            exact: got.exact, n};
        document.body.dataset.judged = JSON.stringify(judged);
    }
}
/* Errors of a picture: of each place, all, and the worst. The rim, which a pixel
 * cuts, does not count. */
function measure(light, pixels, n) {
    const half = MEASURED / n, map = new Float32Array(n * n).fill(NaN);
    const place = i => 4 * ((MEASURED - 1 - Math.floor((Math.floor(i / n) + 0.5) *
        half)) * MEASURED + Math.floor((i % n + 0.5) * half));
    let sum = 0, all = 0, count = 0, where = 0;
    for (let i = 0; i < n * n; i++) {
        const x = (i % n + 0.5) / n * 2 - 1, y = (i / n | 0) / n * 2 - 1 + 1 / n;
        if (!(light[3 * i] >= 0) || x * x + y * y > 0.96)
            continue;
        let off = 0;
        for (let c = 0; c < 3; c++) {
            const want = light[3 * i + c];
            off += (pixels[place(i) + c] - want) ** 2;
            all += want * want;
        }
        map[i] = Math.sqrt(off);
        sum += off;
        count++;
        if (!(map[where] >= map[i]))
            where = i;
    }
    const rms = Math.sqrt(all / count);
    map.forEach((x, i) => map[i] = x / rms);
    return {rms: Math.sqrt(sum / all), worst: map[where], where, map, place};
}

/* ---- controls ------------------------------------------------------------------ */

function fill(select, rows) {
    select.replaceChildren(...rows.map(row => new Option(...[row].flat())));
}
fill(form.target, TARGETS.map(t => [t === 'none' ? 'no engine: textures' : t, t]));
fill(form.size, [['as usual', ''], 64, 128, 256, 384, 512, 1024, 2048]);
fill(form.pixel, [['as the target has', ''], 'rgba16f', 'rgba32f', 'rgb9e5',
    'r11g11b10f', 'bc6h', 'uastc-hdr', 'astc4x4hdr']);
fill(form.format, [['as the target has', ''], 'ktx2', 'ktx', 'dds', 'dds-legacy',
    'env', 'gltf', 'playcanvas']);
function radios(at, name, labels) {
    $(at).append(...labels.map((text, i) => {
        const label = document.createElement('label');
        const input = Object.assign(document.createElement('input'),
            {type: 'radio', name, value: i});
        const span = Object.assign(document.createElement('span'),
            {textContent: text});
        label.append(input, span);
        return label;
    }));
}
radios('materials', 'row', MATERIALS.map(m => m.name));
radios('roughness', 'column', ROUGHNESS);
function pick(which) {
    sphere = {row: +which.row, column: +which.column};
    for (const [key, value] of Object.entries(sphere))
        $('sphere').elements[key].value = value;
    judge();
}
$('sphere').onchange = () =>
    pick(Object.fromEntries(new FormData($('sphere'))));
const kinds = () => document.querySelectorAll('[data-kind]').forEach(label =>
    label.hidden = label.dataset.kind !== form.kind.value);
function look() {
    const [exposure, rotation] = [+form.exposure.value, +form.rotation.value];
    $('ev').textContent = `${exposure} EV`;
    $('deg').textContent = `${rotation}°`;
    view?.set({exposure, rotation, background: form.background.value});
}
function turned(degrees, end) {
    form.rotation.value = Math.round(degrees);
    look();
    end && settle();
}
function settle() {
    judge();
    soon();
}
$('form').oninput = look;
$('form').onchange = e => {
    kinds();
    e.target.name === 'background' ? 0 : settle();
};
$('form').onsubmit = e => e.preventDefault();
$('tabs').onchange = tell;
$('stop').onclick = () => baker.stop();
$('copy').onclick = () => navigator.clipboard.writeText($('files').textContent)
    .catch(fail);
$('download').onclick = () => {
    const {files, code, chosen} = made, base = map.name.replace(/\.[^.]*$/, '');
    const text = string => new TextEncoder().encode(string + '\n');
    const zip = zipSync({...files, 'command.txt': text(command(chosen)),
        'code.txt': text(code)}, {level: 0});
    const a = Object.assign(document.createElement('a'), {
        href: URL.createObjectURL(new Blob([zip], {type: 'application/zip'})),
        download: base + '.zip'});
    a.click();
    setTimeout(() => URL.revokeObjectURL(a.href), 10000);
};

/* Models are shown, everything else is a map. */
async function take(files) {
    const list = [...files];
    if (list.some(f => /\.gl(b|tf)$/i.test(f.name)))
        await trying(async () => {
            await view?.model(list);
            if (!map)
                await sample('forest.exr');
        });
    else if (list.length)
        await open(list[0]);
}
const fetched = async name =>
    new File([await (await fetch('data/' + name)).blob()], name);
const sample = async name => open(await fetched(name));
$('open').onclick = $('model').onclick = e => {
    $('file').accept = e.target.id === 'open' ?
        '.hdr,.exr,.pic,.png,.ktx2,.ktx,.dds,.env' : '.glb,.gltf,.bin,image/*';
    $('file').value = '';
    $('file').click();
};
$('file').onchange = () => take($('file').files);
$('knot').onclick = async () => take([await fetched('knot.glb')]);
$('balls').onclick = () => view?.model(null);
for (const button of document.querySelectorAll('[data-map]'))
    button.onclick = () => trying(() => sample(button.dataset.map));
addEventListener('dragover', e => {
    e.preventDefault();
    document.body.classList.add('over');
});
addEventListener('dragleave', e => e.relatedTarget ||
    document.body.classList.remove('over'));
addEventListener('drop', e => {
    e.preventDefault();
    document.body.classList.remove('over');
    take(e.dataTransfer.files);
});

try {
    view = createView($('view'), pick, turned);
} catch {
    fail('This browser draws no WebGL 2: maps are baked and packed all the same, ' +
        'without pictures.');
}
kinds();
look();
pick(sphere);
navigator.serviceWorker?.register('sw.js').catch(() => {});
await view?.warm();
document.body.dataset.ready = '';

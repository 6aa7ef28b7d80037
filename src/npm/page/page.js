// SPDX-License-Identifier: MIT
/* The page: what was dropped is baked, shown, judged and packed. */
import {zipSync} from 'three/addons/libs/fflate.module.js';
import {run} from './iblbake/index.mjs';
import {PIXELS, createView} from './view.js';

const $ = id => document.getElementById(id), form = $('form').elements;
/* The open map {name, bytes, half}; the files that were made of it; the view. */
let map = null, made = null, view = null, stopper = new AbortController(), later;

const bytesOf = n => `${(n / 1e3).toFixed(1)} kB`;
const timeOf = ms => `${(ms / 1e3).toFixed(2)} s`, percent = x => `${(100 * x).toFixed(2)} %`;
function fail(e) {
    if (e.name === 'AbortError')
        return;
    $('said').textContent = String(e.message ?? e).trim().split('\n').pop();
    $('said').hidden = false;
}

/* Runs the program, and ends the run before. */
async function iblbake(args, files) {
    stopper.abort();
    const {signal} = stopper = new AbortController(), start = performance.now();
    document.body.classList.add('busy');
    $('progress').value = 0;
    try {
        const result = await run(args, files, {signal,
            onProgress: part => $('progress').value = part});
        if (result.status)
            throw Error(result.stderr.replace(/^iblbake: /gm, ''));
        return {...result, time: performance.now() - start};
    } finally {
        if (stopper.signal === signal) {
            document.body.classList.remove('busy');
            $('download').disabled = !made; // those from before, if it failed
        }
    }
}
/* Controls have the names of options. */
const NAMES = ['target', 'only', 'rotate', 'exposure', 'size', 'format', 'layout', 'pixel'];
const more = () => (form.more.value.match(/"[^"]*"|[^\s"]+/g) ?? [])
    .map(word => word.replace(/"/g, ''));
/* Those that say how a map is read, with their values. */
const reading = () => more().filter((word, i, all) =>
    /^--(layer|part|any-aspect|input-|face-order|primaries|clamp)/
        .test(word.startsWith('--') ? word : all[i - 1]));
function chosen() {
    const cube = form.only.value === 'skybox';
    return [...NAMES.filter(name => !/^0?$/.test(form[name].value) && !(cube && name === 'size'))
        .flatMap(name => ['--' + name, form[name].value]),
        ...cube ? ['--skybox', form.size.value || '512'] : [], ...more()];
}

/* ---- a map, its picture and its files -------------------------------------------- */

/* First a set that is soon made, for the picture. */
async function open(file) {
    const start = performance.now(), next = {name: file.name};
    $('said').hidden = true;
    try {
        next.bytes = new Uint8Array(await file.arrayBuffer());
        const {files, time} = await iblbake(['--only=specular', '--mapping=filament',
            '--size=256', '--levels=5', '--mirror=x', ...reading(), '--name=a', '-o', 'out', '--',
            next.name], {[next.name]: next.bytes});
        map = next;
        made = null;
        map.half = files['out/a_specular.ktx2'];
        view?.prefilter(null);
        await view?.show(map.half);
        performance.measure('picture', {start});
        $('shown').textContent = `half floats, ${timeOf(time)}`;
        ['own', 'how', 'off0', 'off1'].forEach(id => $(id).textContent = '');
        canvases.forEach(canvas => canvas.width = 0);
        $('empty').hidden = !!view;
        $('choices').replaceChildren();
        await make().catch(fail);
        if (!view || map !== next)
            return;
        // Beside three.js itself, which holds the page up, and the truth.
        const took = await view.prefilter(map.bytes.buffer);
        $('own').textContent = `in ${timeOf(took)}, each time a page loads`;
        map.compared = true;
        judge();
    } catch (e) {
        fail(e);
    }
}
async function make() {
    $('said').hidden = $('download').disabled = true;
    const {name, bytes, half} = map, target = form.target.value, args = chosen();
    const done = await iblbake([...target ? ['--explain'] : [], ...args, '-o', 'out', '--', name],
        {[name]: bytes});
    made = Object.fromEntries(Object.entries(done.files).map(([file, content]) =>
        [file.slice('out/'.length), content]));
    const list = Object.entries(made).map(([file, {length}]) => [length, file]);
    const size = bytesOf(list.reduce((n, [length]) => n + length, 0));
    $('files').textContent = list.map(([length, file]) =>
        `${bytesOf(length).padStart(8)}  ${file}`).join('\n');
    $('code').textContent = done.stdout || 'No target: no program.';
    $('command').textContent = ['iblbake', ...args, name, '-o', 'out'].map(word =>
        /^[\w.,:+=-]+$/.test(word) ? word : `'${word.replace(/'/g, "'\\''")}'`).join(' ');
    $('warning').textContent = done.stderr.trim();
    $('status').textContent = `${size} in ${timeOf(done.time)}`;
    $('choices').prepend(`${args.join(' ') || 'textures'}: ${$('status').textContent}\n`);
    $('download').disabled = false;
    if (!view)
        return;
    // What three.js would load, as half floats; of others the picture is enough.
    const cube = Object.keys(made).find(file => /_specular\.ktx2$/.test(file));
    if (target === 'three' && cube && !/--(sun|lights|mirror|up)/.test(args)) {
        const {files} = await iblbake(['convert', '--pixel=rgba16f', cube, 'half.ktx2'],
            {[cube]: made[cube]});
        await view.show(files['half.ktx2'], +form.rotate.value, +form.exposure.value);
        $('shown').textContent = `${size}, as three.js loads it`;
    } else {
        await view.show(half);
        $('shown').textContent = 'half floats';
    }
    judge();
}
$('download').onclick = () => {
    const text = id => new TextEncoder().encode($(id).textContent + '\n');
    const zip = zipSync({...made, 'code.txt': text('code'), 'command.txt': text('command')},
        {level: 0});
    const href = URL.createObjectURL(new Blob([zip], {type: 'application/zip'}));
    Object.assign(document.createElement('a'),
        {href, download: map.name.replace(/\.[^.]*$/, '') + '.zip'}).click();
};

/* ---- the chosen sphere ----------------------------------------------------------- */

const canvases = document.querySelectorAll('figure canvas');
function paint(canvas, value) { // value: of a channel of pixels from the bottom
    const n = canvas.width = canvas.height = PIXELS, image = new ImageData(n, n);
    for (let i = 0; i < 4 * n * n; i++)
        image.data[i] = i % 4 === 3 ? 255 :
            value(4 * n * (n - 1 - Math.floor(i / 4 / n)) + i % (4 * n));
    canvas.getContext('2d').putImageData(image, 0, 0);
}
/* Root mean squares of a picture, and of its difference to another one. */
function error(truth, pixels) {
    let off = 0, all = 0, count = 0;
    truth.forEach((x, i) => {
        off += (pixels[i] - x) ** 2;
        all += x * x;
        count += x > 0;
    });
    return [Math.sqrt(all / count), Math.sqrt(off / all)];
}
async function judge() {
    if (!map?.compared)
        return;
    const start = performance.now(), {row, column} = $('sphere').elements, of = map;
    const pictures = await view.measure(+row.value, +column.value);
    if (!pictures || of !== map)
        return;
    const truth = pictures[2], errors = [0, 1].map(k => error(truth, pictures[k]));
    pictures.forEach((pixels, k) => paint(canvases[k], i =>
        255 * (2 ** form.exposure.value * pixels[i]) ** (1 / 2.2)));
    errors.forEach(([bright, off], k) => {
        paint(canvases[3 + k], i => 255 * 4 * Math.abs(pictures[k][i] - truth[i]) / bright);
        $(`off${k}`).textContent = percent(off);
    });
    $('how').textContent = 'Exact: the sum over all pixels of the map, in ' +
        `${timeOf(performance.now() - start)}. Errors: parts of its root mean square, x 4.`;
    document.body.dataset.judged = JSON.stringify({row: +row.value, column: +column.value,
        off: errors.map(([, off]) => off)});
}

/* ---- controls -------------------------------------------------------------------- */

function look() {
    const [exposure, rotation] = [+form.exposure.value, +form.rotate.value];
    $('ev').textContent = `${exposure} EV`;
    $('deg').textContent = `${rotation}°`;
    view?.set({exposure, rotation, background: form.background.value});
}
$('form').oninput = look;
$('form').onchange = ({target: {name, value}}) => {
    if (/^(hdr|exr|png|skybox)$/.test(value)) // what no engine takes
        form.target.value = '';
    clearTimeout(later);
    later = map && name !== 'background' && setTimeout(() => make().catch(fail), 250);
};
$('form').onsubmit = e => e.preventDefault();
$('sphere').onchange = judge;
$('stop').onclick = () => stopper.abort();

/* Models are shown, every other file is a map. */
async function take(file) {
    if (!file) return; // nothing was picked, or text was dropped
    if (!/\.gl(b|tf)$/i.test(file.name))
        return open(file);
    const url = URL.createObjectURL(file);
    await view?.model(url).catch(fail).finally(() => URL.revokeObjectURL(url));
    map ?? $('forest.exr').click();
}
for (const name of ['forest.exr', 'sky.exr', 'knot.glb'])
    $(name).onclick = () => fetch('data/' + name).then(r => r.blob())
        .then(blob => take(new File([blob], name))).catch(fail);
$('balls').onclick = () => view?.model(null);
$('open').onclick = $('model').onclick = () => {
    $('file').value = ''; // the same file may be meant again
    $('file').click();
};
$('file').onchange = () => take($('file').files[0]);
for (const kind of ['dragover', 'dragleave', 'drop'])
    addEventListener(kind, e => {
        e.preventDefault();
        document.body.classList.toggle('over', kind === 'dragover');
        kind === 'drop' && take(e.dataTransfer.files[0]);
    });

try {
    view = createView($('view'));
} catch {
    fail('This browser draws no WebGL 2: maps are baked and packed, but not shown.');
}
look();
navigator.serviceWorker?.register('sw.js').catch(() => {});
await Promise.all([view?.isDrawn(), run(['--version'])]).catch(fail);
document.body.dataset.ready = '';

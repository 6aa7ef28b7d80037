// SPDX-License-Identifier: MIT
/*
 * A worker with the truth: {bytes} reads a map, by the readers of three.js, and
 * gives its half floats; {sphere} sums the light that it reflects, over all
 * pixels of the map.
 *
 * The sum is over a tree of means: a patch of the sky is split until it is small
 * against the width of the lobe at its half vector, beyond the map's pixels if
 * need be. A mean stands where its light is, so that what is left is of second
 * order. GGX, height-correlated Smith and Schlick as in three.js, with its light
 * of more than one bounce: what differs is the lookup of the map.
 */
import {DataUtils, FloatType} from './three/build/three.core.js';
import {EXRLoader} from './three/examples/jsm/loaders/EXRLoader.js';
import {HDRLoader} from './three/examples/jsm/loaders/HDRLoader.js';

const MOST = 4096 * 2048, SPLIT = 0.125, WIDEST = 0.2, FINEST = -5, RIM = 0.05;
const turns = new MessageChannel();
let levels, latest;

function read(bytes) {
    const exr = new DataView(bytes).getUint32(0, true) === 20000630;
    const loader = exr ? new EXRLoader() : new HDRLoader();
    loader.type = FloatType;
    const {width: w, height: h, data} = loader.parse(bytes);
    if (data.length !== 4 * w * h || w !== 2 * h)
        throw Error('it is no equirectangular picture with colours');
    if (w * h > MOST)
        throw Error(`${w} x ${h} pixels take too much memory for that`);
    const half = new Uint16Array(4 * w * h), light = new Float32Array(3 * w * h);
    for (let y = 0, to = 0; y < h; y++)
        for (let x = 0, at = 4 * w * (exr ? h - 1 - y : y); x < w;
             x++, at += 4, to++)
            for (let c = 0; c < 3; c++) { // repaired as iblbake does
                const l = data[at + c] > 0 ? Math.min(data[at + c], 3e38) : 0;
                light[3 * to + c] = l;
                half[4 * to + c] = DataUtils.toHalfFloat(Math.min(l, 65504));
            }
    levels = [{w, h, light}];
    while (levels.at(-1).h > 8)
        levels.push(coarser(levels.length - 1));
    return {w, h, half};
}

/* Patches: where the light is, area, radiance. Level 0 are pixels, those below
 * parts of them, those above 2x2 of the level before. */
const patch = new Float64Array(7), size = level => Math.PI / levels[0].h * 2 ** level;
function find(level, i, j) {
    if (level > 0) {
        const {w, light} = levels[level];
        for (let k = 0, at = 7 * (j * w + i); k < 7; k++)
            patch[k] = light[at + k];
        return;
    }
    const [{w, light}] = levels, edge = size(level), t = edge * (j + 0.5);
    const p = edge * (i + 0.5) - Math.PI, s = Math.sin(t);
    const at = 3 * ((j >> -level) * w + (i >> -level));
    patch[0] = s * Math.cos(p);
    patch[1] = Math.cos(t);
    patch[2] = s * Math.sin(p);
    patch[3] = s * 2 * Math.sin(edge / 2) * edge;
    for (let c = 0; c < 3; c++)
        patch[4 + c] = light[at + c];
}
function coarser(level) {
    const fine = levels[level], w = (fine.w + 1) >> 1, h = (fine.h + 1) >> 1;
    const light = new Float32Array(7 * w * h);
    for (let j = 0; j < fine.h; j++)
        for (let i = 0; i < fine.w; i++) {
            find(level, i, j);
            const to = 7 * ((j >> 1) * w + (i >> 1)), area = patch[3];
            const power = area * (patch[4] + patch[5] + patch[6] + 1e-30);
            for (let k = 0; k < 7; k++)
                light[to + k] += k === 3 ? area : patch[k] * (k < 3 ? power : area);
        }
    for (let to = 0; to < light.length; to += 7) {
        const long = Math.hypot(light[to], light[to + 1], light[to + 2]) || 1;
        for (let k = 0; k < 7; k++)
            light[to + k] /= k < 3 ? long : k > 3 ? light[to + 3] : 1;
    }
    return {w, h, light};
}

/* The sums of a place: its normal, the view, and the light; of the reflection two
 * parts, F0 times the first and the second, each with what white light gives;
 * then E/pi. Plain variables, since this is run 10 million times. */
const stack = new Int32Array(4096), sums = new Float64Array(11);
let nx, ny, nz, vx, vy, vz, nv, lv, a2;

function add(nl, vl) {
    const h = Math.sqrt(Math.max(2 + 2 * vl, 1e-12));
    const nh = (nl + nv) / h, d = 1 + nh * nh * (a2 - 1);
    const matte = nl * patch[3] / Math.PI, f = 1 - (1 + vl) / h;
    const weight = a2 / (2 * d * d) * matte /
        (nl * lv + nv * Math.sqrt(a2 + (1 - a2) * nl * nl));
    const grazing = weight * f * f * f * f * f, rest = weight - grazing;
    for (let c = 0; c < 3; c++) {
        const light = patch[4 + c];
        sums[c] += rest * light;
        sums[4 + c] += grazing * light;
        sums[8 + c] += matte * light;
    }
    sums[3] += rest;
    sums[7] += grazing;
}
function integral(normal, view, roughness, split) {
    [nx, ny, nz] = normal;
    [vx, vy, vz] = view;
    nv = nx * vx + ny * vy + nz * vz;
    a2 = roughness ** 4;
    lv = Math.sqrt(a2 + (1 - a2) * nv * nv);
    sums.fill(0);
    const top = levels.at(-1);
    for (let at = 0; at < top.w * top.h; at++) {
        stack[0] = levels.length - 1;
        stack[1] = at % top.w;
        stack[2] = Math.floor(at / top.w);
        for (let depth = 3; depth;) {
            const level = stack[depth -= 3], i = stack[depth + 1];
            const j = stack[depth + 2], edge = size(level);
            find(level, i, j);
            const nl = nx * patch[0] + ny * patch[1] + nz * patch[2];
            if (nl < -1.5 * edge)
                continue;
            const vl = vx * patch[0] + vy * patch[1] + vz * patch[2];
            const side = Math.max(nl + nv, 0);
            const nh = side * side / Math.max(2 + 2 * vl, 1e-12);
            const lobe = Math.max(a2, 1 / Math.max(nh, 0.1) - 1);
            if (level === FINEST ||
                edge <= Math.min(WIDEST, 2 * split * Math.sqrt(lobe))) {
                if (nl > 0)
                    add(nl, vl);
                continue;
            }
            const {w, h} = level > 0 ? levels[level - 1] : {};
            for (let k = 0; k < 4; k++) {
                const x = 2 * i + (k & 1), y = 2 * j + (k >> 1);
                if (x >= w || y >= h)
                    continue;
                stack[depth++] = level - 1;
                stack[depth++] = x;
                stack[depth++] = y;
            }
        }
    }
}

/* What white light gives, of the first part and the second, over N.V: of it the
 * sums of a coarser split are known to be off, and by how much. */
const WHITES = 24;
const whites = roughness => Array.from({length: WHITES + 1}, (_, k) => {
    const z = Math.max(k / WHITES, RIM);
    integral([Math.sqrt(1 - z * z), 0, z], [0, 0, 1], roughness, SPLIT / 3);
    return [sums[3], sums[7]];
});
/* What three.js makes of the sums. */
function reflected({colour, metal}, white, out, to) {
    const at = Math.min(WHITES - 1e-6, nv * WHITES), k = Math.floor(at), s = sums;
    for (const [part, first] of [[0, 0], [1, 4]]) {
        const [a, b] = [white[k][part], white[k + 1][part]];
        const right = (a + (b - a) * (at - k)) / s[first + 3];
        for (let c = 0; c < 4; c++)
            s[first + c] *= right;
    }
    const lost = 1 - s[3] - s[7];
    for (let c = 0; c < 3; c++) {
        const f0 = metal ? colour[c] : 0.04, mean = f0 + (1 - f0) / 21;
        const once = f0 * s[3] + s[7];
        const more = once * mean / (1 - mean * lost) * lost;
        out[to + c] = f0 * s[c] + s[4 + c] + (more +
            (metal ? 0 : colour[c] * (1 - once - more))) * s[8 + c];
    }
}

/* {id, sphere {roughness, metal, colour}, turn (of the map, in radians), n,
 * pixel}: n x n places of the sphere as it is seen from +z, in pixels of that
 * many radii. Gives radiance, NaN outside, and how exact it is. */
async function reflect({id, sphere, turn, n, pixel: p}) {
    const out = new Float32Array(3 * n * n).fill(NaN), fine = new Float32Array(3);
    const [c, s] = [Math.cos(turn), Math.sin(turn)];
    const turned = (x, y, z) => [c * x - s * z, y, s * x + c * z];
    const rough = Math.max(sphere.roughness, 0.0525), view = turned(0, 0, 1);
    const white = whites(rough + p);
    let off = 0, all = 0, count = 0;
    for (let j = 0; j < n; j++) {
        for (let i = 0; i < n; i++) {
            // The middle of a pixel near the middle of the place.
            const at = k => (Math.floor((k + 0.5) * 2 / n / p) + 0.5) * p - 1;
            const x = at(i), y = -at(j), z = Math.sqrt(1 - x * x - y * y);
            if (!(z > RIM))
                continue;
            // Three.js widens lobes by the bend of the surface in a pixel.
            const r = Math.min(1, rough + p * Math.max(1, Math.abs(x) / z,
                                                       Math.abs(y) / z));
            const to = 3 * (j * n + i), normal = turned(x, y, z);
            integral(normal, view, r, SPLIT);
            reflected(sphere, white, out, to);
            if (++count % 99)
                continue;
            integral(normal, view, r, SPLIT / 2);
            reflected(sphere, white, fine, 0);
            fine.forEach((l, k) => {
                off += (l - out[to + k]) ** 2;
                all += l * l;
            });
        }
        await new Promise(go => { // lets a later question in
            turns.port1.onmessage = go;
            turns.port2.postMessage(0);
        });
        if (latest !== id)
            return;
    }
    postMessage({id, light: out, exact: Math.sqrt(off / all)});
}

onmessage = async ({data}) => {
    const {id} = data;
    latest = id;
    try {
        if (data.sphere)
            return await reflect(data);
        const map = read(data.bytes);
        postMessage({id, ...map}, [map.half.buffer]);
    } catch (e) {
        postMessage({id, error: e.message});
    }
};

// SPDX-License-Identifier: MIT
/*
 * A worker with the truth: {bytes} reads a map, by the readers of three.js, and
 * gives its half floats; {job} sums the light that a sphere reflects, over all
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

const MOST = 4096 * 2048, SPLIT = 0.125, WIDEST = 0.2, RIM = 0.05;
const turns = new MessageChannel();
let map, latest;

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
    return {w, h, half, levels: tree(w, h, light)};
}

/* Level 0 has the pixels, others patches of 2x2 of those before: seven numbers,
 * where the light is, area, radiance. */
function tree(w, h, light) {
    const angle = (n, i) => Math.PI * (i + 0.5) / n;
    const levels = [{w, h, size: Math.PI / h, light,
        phi: Float64Array.from({length: w}, (_, i) => 2 * angle(w, i) - Math.PI),
        theta: Float64Array.from({length: h}, (_, i) => angle(h, i))}];
    while (levels.at(-1).h > 8) {
        const fine = levels.at(-1), last = levels.length > 1;
        const [pw, ph] = [(fine.w + 1) >> 1, (fine.h + 1) >> 1];
        const out = new Float32Array(7 * pw * ph), part = new Float64Array(7);
        for (let j = 0; j < fine.h; j++)
            for (let i = 0; i < fine.w; i++) {
                const to = 7 * ((j >> 1) * pw + (i >> 1));
                if (last)
                    part.set(fine.light.subarray(7 * (j * fine.w + i),
                                                 7 * (j * fine.w + i) + 7));
                else
                    pixel(levels[0], i, j, part);
                const power = part[3] * (part[4] + part[5] + part[6] + 1e-30);
                for (let k = 0; k < 7; k++)
                    out[to + k] += part[k] * (k < 3 ? power :
                        k > 3 ? part[3] : 1);
            }
        for (let to = 0; to < out.length; to += 7) {
            const long = Math.hypot(out[to], out[to + 1], out[to + 2]);
            for (let k = 0; k < 7; k++)
                out[to + k] /= k < 3 ? long || 1 : k > 3 ? out[to + 3] : 1;
        }
        levels.push({w: pw, h: ph, size: 2 * fine.size, light: out});
    }
    return levels;
}
function pixel({w, light, phi, theta, size}, i, j, out) {
    const s = Math.sin(theta[j]);
    out[0] = s * Math.cos(phi[i]);
    out[1] = Math.cos(theta[j]);
    out[2] = s * Math.sin(phi[i]);
    out[3] = s * 2 * Math.sin(size / 2) * size;
    for (let c = 0; c < 3; c++)
        out[4 + c] = light[3 * (j * w + i) + c];
}

/* The sums of a place: its normal, the view, and the light; of the reflection two
 * parts, F0 times the first and the second, each with what white light gives;
 * then E/pi. Plain variables, since this is run 10 million times. */
const stack = new Int32Array(4096), patch = new Float64Array(7);
const sums = new Float64Array(11);
let nx, ny, nz, vx, vy, vz, nv, lv, a2, split, depth;

function add(x, y, z, area, red, green, blue) {
    const nl = nx * x + ny * y + nz * z;
    if (nl <= 0)
        return;
    const vl = vx * x + vy * y + vz * z;
    const h = Math.sqrt(Math.max(2 + 2 * vl, 1e-12));
    const nh = (nl + nv) / h, d = 1 + nh * nh * (a2 - 1);
    const matte = nl * area / Math.PI, f = 1 - (1 + vl) / h;
    const weight = a2 / (2 * d * d) * matte /
        (nl * lv + nv * Math.sqrt(a2 + (1 - a2) * nl * nl));
    const grazing = weight * f * f * f * f * f, rest = weight - grazing;
    sums[0] += rest * red;
    sums[1] += rest * green;
    sums[2] += rest * blue;
    sums[3] += rest;
    sums[4] += grazing * red;
    sums[5] += grazing * green;
    sums[6] += grazing * blue;
    sums[7] += grazing;
    sums[8] += matte * red;
    sums[9] += matte * green;
    sums[10] += matte * blue;
}
/* A pixel, in m x m parts. */
function addParts({size, theta, phi}, i, j, m) {
    const step = size / m, wide = 2 * Math.sin(step / 2) * step;
    for (let k = 0; k < m; k++) {
        const t = theta[j] + step * (k + 0.5 - m / 2), s = Math.sin(t);
        for (let l = 0; l < m; l++) {
            const p = phi[i] + step * (l + 0.5 - m / 2);
            add(s * Math.cos(p), Math.cos(t), s * Math.sin(p), s * wide,
                patch[4], patch[5], patch[6]);
        }
    }
}
function visit(levels, level, at) {
    const {w, size, light} = levels[level];
    const j = Math.floor(at / w), i = at - j * w;
    if (level)
        for (let k = 0; k < 7; k++)
            patch[k] = light[7 * at + k];
    else
        pixel(levels[0], i, j, patch);
    const nl = nx * patch[0] + ny * patch[1] + nz * patch[2];
    if (nl < -1.5 * size)
        return;
    const vl = vx * patch[0] + vy * patch[1] + vz * patch[2];
    const side = Math.max(nl + nv, 0);
    const nh = side * side / Math.max(2 + 2 * vl, 1e-12);
    const lobe = Math.max(a2, 1 / Math.max(nh, 0.1) - 1);
    const most = Math.min(WIDEST, 2 * split * Math.sqrt(lobe));
    if (size <= most)
        add(patch[0], patch[1], patch[2], patch[3], patch[4], patch[5],
            patch[6]);
    else if (!level)
        addParts(levels[0], i, j, Math.min(32, Math.ceil(size / most)));
    else {
        const next = levels[level - 1];
        for (let k = 0; k < 4; k++) {
            const x = 2 * i + (k & 1), y = 2 * j + (k >> 1);
            if (x < next.w && y < next.h) {
                stack[depth++] = level - 1;
                stack[depth++] = y * next.w + x;
            }
        }
    }
}
function integral(levels, normal, view, roughness, step) {
    [nx, ny, nz] = normal;
    [vx, vy, vz] = view;
    nv = nx * vx + ny * vy + nz * vz;
    a2 = roughness ** 4;
    lv = Math.sqrt(a2 + (1 - a2) * nv * nv);
    split = step;
    sums.fill(0);
    const top = levels.at(-1);
    for (let at = 0; at < top.w * top.h; at++) {
        depth = 0;
        visit(levels, levels.length - 1, at);
        while (depth) {
            depth -= 2;
            visit(levels, stack[depth], stack[depth + 1]);
        }
    }
}

/* What white light gives, of the first part and the second, over N.V: of it the
 * sums of a coarser split are known to be off, and by how much. */
const WHITES = 24;
function whites(levels, roughness) {
    return Array.from({length: WHITES + 1}, (_, k) => {
        const z = Math.max(k / WHITES, RIM);
        integral(levels, [Math.sqrt(1 - z * z), 0, z], [0, 0, 1], roughness,
                 SPLIT / 3);
        return [sums[3], sums[7]];
    });
}
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

/* job: {id, sphere {roughness, metal, colour}, turn (of the map, in radians),
 * n, pixel}: n x n places of the sphere as it is seen from +z, in pixels of
 * that many radii. Gives radiance, none outside, and how exact it is. */
async function sphere(job) {
    const {n, pixel: p, turn} = job, out = new Float32Array(3 * n * n).fill(NaN);
    const [c, s] = [Math.cos(turn), Math.sin(turn)];
    const turned = ([x, y, z]) => [c * x - s * z, y, s * x + c * z];
    const view = turned([0, 0, 1]), fine = new Float32Array(3);
    const white = whites(map.levels, Math.max(job.sphere.roughness, 0.0525) + p);
    let off = 0, all = 0, count = 0;
    for (let j = 0; j < n; j++) {
        for (let i = 0; i < n; i++) {
            // The middle of a pixel near the middle of the place.
            const at = k => (Math.floor((k + 0.5) * 2 / n / p) + 0.5) * p - 1;
            const x = at(i), y = -at(j), z = Math.sqrt(1 - x * x - y * y);
            if (!(z > RIM))
                continue;
            const r = Math.min(1, Math.max(job.sphere.roughness, 0.0525) +
                p * Math.max(1, Math.abs(x) / z, Math.abs(y) / z));
            const normal = turned([x, y, z]), to = 3 * (j * n + i);
            integral(map.levels, normal, view, r, SPLIT);
            reflected(job.sphere, white, out, to);
            if (++count % 99 === 0) {
                integral(map.levels, normal, view, r, SPLIT / 2);
                reflected(job.sphere, white, fine, 0);
                fine.forEach((l, k) => {
                    off += (l - out[to + k]) ** 2;
                    all += l * l;
                });
            }
        }
        await new Promise(go => { // lets a later job in
            turns.port1.onmessage = go;
            turns.port2.postMessage(0);
        });
        if (latest !== job.id)
            return;
    }
    postMessage({id: job.id, light: out, exact: Math.sqrt(off / all)});
}

onmessage = ({data}) => {
    latest = data.id;
    try {
        if (data.bytes) {
            const {half, ...rest} = read(data.bytes);
            map = rest;
            postMessage({id: data.id, w: map.w, h: map.h, half}, [half.buffer]);
        } else
            sphere(data).catch(e => postMessage({id: data.id, error: e.message}));
    } catch (e) {
        map = null;
        postMessage({id: data.id, error: e.message});
    }
};

// SPDX-License-Identifier: MIT
/*
 * What a surface reflects of a map: the integral itself, as a sum over 128x64
 * means of the map's pixels. GGX, height-correlated Smith, Schlick.
 */
import {radiance, WIDTH, HEIGHT} from './maps.mjs';

const EDGE = 4; // pixels of the map in one of the sum
const kept = new Map();

/* Seven numbers of each patch: the direction to the middle of its light, its
 * area and its radiance. */
function patches(name) {
    if (kept.has(name))
        return kept.get(name);
    const pixels = radiance(name), [w, h] = [WIDTH / EDGE, HEIGHT / EDGE];
    const out = new Float64Array(7 * w * h);
    for (let j = 0; j < HEIGHT; j++)
        for (let i = 0; i < WIDTH; i++) {
            const at = 7 * (Math.floor(j / EDGE) * w + Math.floor(i / EDGE));
            const t = Math.PI * (j + 0.5) / HEIGHT;
            const p = 2 * Math.PI * ((i + 0.5) / WIDTH - 0.5);
            const area = Math.sin(t) * 2 * Math.PI / WIDTH * Math.PI / HEIGHT;
            const l = pixels[j * WIDTH + i], light = l[0] + l[1] + l[2];
            [Math.sin(t) * Math.cos(p) * light, Math.cos(t) * light,
                Math.sin(t) * Math.sin(p) * light, 1, ...l]
                .forEach((x, k) => out[at + k] += area * x);
        }
    for (let at = 0; at < out.length; at += 7) {
        const length = Math.hypot(out[at], out[at + 1], out[at + 2]);
        for (let k = 0; k < 7; k++)
            out[at + k] /= k < 3 ? length : k > 3 ? out[at + 3] : 1;
    }
    kept.set(name, out);
    return out;
}

/* seen: radiance of two parts of the reflection, f0 times the first and the
 * second; white: the same of a white map; light: E/pi. */
export function integral(name, {n, v}, roughness) {
    const all = patches(name), sums = Array(12).fill(0);
    const a2 = roughness ** 4, [nx, ny, nz] = n, [vx, vy, vz] = v;
    const nv = nx * vx + ny * vy + nz * vz;
    const lv = Math.sqrt(a2 + (1 - a2) * nv * nv);
    for (let at = 0; at < all.length; at += 7) {
        const x = all[at], y = all[at + 1], z = all[at + 2];
        const nl = nx * x + ny * y + nz * z;
        if (nl <= 0)
            continue;
        const vl = vx * x + vy * y + vz * z, h = Math.sqrt(2 + 2 * vl);
        const nh = (nl + nv) / h, d = 1 + nh * nh * (a2 - 1);
        const matte = nl * all[at + 3] / Math.PI;
        const weight = a2 / (2 * d * d) * matte /
            (nl * lv + nv * Math.sqrt(a2 + (1 - a2) * nl * nl));
        const f = 1 - (1 + vl) / h, grazing = weight * f * f * f * f * f;
        for (let c = 0; c < 4; c++) {
            const l = c < 3 ? all[at + 4 + c] : 1;
            sums[c] += (weight - grazing) * l;
            sums[4 + c] += grazing * l;
            sums[8 + c] += matte * l;
        }
    }
    return {seen: [sums.slice(0, 3), sums.slice(4, 7)],
        white: [sums[3], sums[7]], light: sums.slice(8, 11)};
}

// SPDX-License-Identifier: MIT
/*
 * What eyes would see: pictures of spheres of 320 pixels from two opposite
 * sides, compared block by block. A mean over a picture would hide it.
 */
const SIZE = 336, BALL = 320, BLOCK = 16, STEP = 8, GRID = 4, COARSE = 8;
const LUMA = [0.2126, 0.7152, 0.0722];
const RIM = 0.3; // of the cosine between normal and view

const number = r => String(r).replace(/^0/, '');
const ball = (name, metal, roughness, gloss, albedo = 1) =>
    ({name: name + (gloss ? ' ' + number(roughness) : ''), metal, roughness,
      gloss, albedo});
export const spheres = [ball('matte', 0, 1, 0),
    ...[0.25, 1].map(r => ball('gloss', 0, r, 1)),
    ...[0.25, 0.5, 0.75].map(r => ball('metal', 1, r, 1))];
/* Those that show a reflection alone. */
export const mirrors = [...[0.3, 0.5, 0.7].map(r => ball('white', 1, r, 1)),
    ball('black', 0, 0.5, 1, 0)];

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const unit = a => a.map(x => x / Math.hypot(...a));
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                         a[0] * b[1] - a[1] * b[0]];

/* The ray of each pixel. */
function rays(eye, tan, left) {
    const ahead = unit(eye.map(x => -x)), out = [];
    const side = (a, b) => left ? cross(b, a) : cross(a, b);
    const right = unit(side(ahead, [0, 1, 0])), up = side(right, ahead);
    for (let y = 0; y < SIZE; y++)
        for (let x = 0; x < SIZE; x++) {
            const across = tan * (2 * (x + 0.5) / SIZE - 1);
            const upwards = tan * (1 - 2 * (y + 0.5) / SIZE);
            out.push(unit(ahead.map((a, i) =>
                a + across * right[i] + upwards * up[i])));
        }
    return out;
}
/* Normal and view of each pixel that the unit sphere covers, but its rim, in
 * the engine's axes; null elsewhere. */
function sight(eye, tan, left) {
    return rays(eye, tan, left).map(ray => {
        const b = dot(eye, ray), in2 = b * b - dot(eye, eye) + 1;
        const n = eye.map((e, i) => e + (-b - Math.sqrt(in2)) * ray[i]);
        const v = ray.map(r => -r);
        return in2 > 0 && dot(n, v) > RIM ? {n, v} : null;
    });
}

const kept = new Map();
function once(key, make) {
    if (!kept.has(key))
        kept.set(key, make());
    return kept.get(key);
}

/* The two sides that a sphere is seen from. */
export const views = eye => [1, -1].map(side => {
    const at = eye.map(x => side * x);
    const tan = Math.tan(Math.asin(1 / Math.hypot(...eye))) * SIZE / BALL;
    const pixels = left => once(`${at} ${left}`, () => sight(at, tan, left));
    return {
        eye: at, fov: 2 * Math.atan(tan) * 180 / Math.PI, pixels,
        background: left => rays(at, Math.tan(Math.PI / 3), left),
        /* A picture by a function of what a pixel sees, on a grid. */
        draw({left, encode}, light) {
            const out = new Float32Array(4 * SIZE * SIZE);
            pixels(left).forEach((p, i) => {
                if (!p || i % GRID || Math.floor(i / SIZE) % GRID)
                    return;
                light(p).forEach((x, c) => out[4 * i + c] =
                    255 * encode(Math.min(1, Math.max(0, x))));
                out[4 * i + 3] = 1;
            });
            return out;
        },
        /* Some pixels, {n, v, i}. */
        some: () => pixels(false).flatMap((p, i) => p && i % COARSE === 3 &&
            Math.floor(i / SIZE) % COARSE === 3 ? {...p, i} : [])};
});
views.SIZE = SIZE;

/* a and b of CIE Lab, of a colour of 8-bit sRGB. */
function chroma(rgb) {
    const [r, g, b] = rgb.map(x => x / 255).map(x =>
        x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);
    const [x, y, z] = [
        (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505,
        0.2126 * r + 0.7152 * g + 0.0722 * b,
        (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089].map(t =>
        t > 0.008856 ? Math.cbrt(t) : 7.787 * t + 16 / 116);
    return [500 * (x - y), 200 * (y - z)];
}

/* Means of two pictures over squares of pixels: three numbers of each. */
function squares(a, b, pixels, edge) {
    const out = new Map();
    for (let y = 0; y < SIZE; y++)
        for (let x = 0; x < SIZE; x++) {
            const i = y * SIZE + x;
            if (!pixels[i] || !b[4 * i + 3])
                continue;
            const key = Math.floor(y / edge) * SIZE + Math.floor(x / edge);
            const sum = out.get(key) || [0, 0, 0, 0, 0, 0, 0];
            out.set(key, sum);
            for (let c = 0; c < 3; c++) {
                sum[c] += a[4 * i + c];
                sum[3 + c] += b[4 * i + c];
            }
            sum[6]++;
        }
    const full = Math.max(...[...out.values()].map(sum => sum[6]));
    return new Map([...out].filter(([, sum]) => sum[6] > full / 2)
        .map(([key, sum]) => [key, sum.map(x => x / sum[6])]));
}

/*
 * How much two pictures differ, where pixels are not null and b has something
 * (alpha): the worst difference of the mean of a block, of 255; the worst shift
 * of its chroma, in Lab; and the worst step over 8 pixels of the difference in
 * luma, between means of 4x4, since a picture is rounded.
 */
export function compare(a, b, pixels) {
    let bias = 0, shift = 0, step = 0;
    for (const mean of squares(a, b, pixels, BLOCK).values()) {
        const p = mean.slice(0, 3), q = mean.slice(3, 6);
        p.forEach((x, c) => bias = Math.max(bias, Math.abs(x - q[c])));
        const [s, t] = [chroma(p), chroma(q)];
        shift = Math.max(shift, Math.hypot(s[0] - t[0], s[1] - t[1]));
    }
    const off = m => LUMA.reduce((sum, w, c) => sum + w * (m[c] - m[3 + c]), 0);
    const cells = squares(a, b, pixels, GRID);
    for (const [key, mean] of cells)
        for (const by of [STEP / GRID, STEP / GRID * SIZE]) {
            const next = cells.get(key + by);
            if (next)
                step = Math.max(step, Math.abs(off(mean) - off(next)));
        }
    return [bias, shift, step];
}

/*
 * How much a picture is off what it should show, in linear light: the root mean
 * square, and the worst mean of a block, by want's root mean square. want: {i,
 * light} of some pixels.
 */
export function distance(picture, want, decode) {
    const blocks = new Map();
    let sum = 0, all = 0, count = 0;
    want.forEach(({i, light}) => light.forEach((x, c) => {
        const key = `${Math.floor(i / SIZE / BLOCK)} ` +
            `${Math.floor(i % SIZE / BLOCK)} ${c}`;
        const off = decode(picture[4 * i + c] / 255) - x;
        sum += off * off;
        all += x * x;
        count++;
        const block = blocks.get(key) || [0, 0];
        blocks.set(key, [block[0] + off, block[1] + 1]);
    }));
    const worst = Math.max(...[...blocks.values()]
        .filter(([, n]) => n === (BLOCK / COARSE) ** 2)
        .map(([off, n]) => Math.abs(off / n)));
    return [Math.sqrt(sum / all), worst / Math.sqrt(all / count)];
}

// SPDX-License-Identifier: MIT
/*
 * Maps that are made: node maps.mjs NAME >NAME.hdr. The world is the one of
 * <ibl/ibl.h>: u = atan2(z, x) / 2 pi + 1/2.
 *   lamps  tells axes apart: on grey, a disc of 18 degrees and a colour of its
 *          own around each
 *   dusk   a low orange sun, six tenths of the light, under a colourful sky
 *   blaze  a sun of nine tenths of the light
 */
import {fileURLToPath} from 'node:url';

export const lamps = [
    {axis: [1, 0, 0], colour: [1, 0, 0]}, {axis: [-1, 0, 0], colour: [0, 1, 1]},
    {axis: [0, 1, 0], colour: [0, 1, 0]}, {axis: [0, -1, 0], colour: [1, 0, 1]},
    {axis: [0, 0, 1], colour: [0, 0, 1]}, {axis: [0, 0, -1], colour: [1, 1, 0]}
];
export const [WIDTH, HEIGHT] = [512, 256];

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const luminance = c => dot(c, [0.2126, 0.7152, 0.0722]);
const mix = (a, b, t) => a.map((x, i) => x + (b[i] - x) * t);

function lamp(d) {
    const near = lamps.find(({axis}) => dot(axis, d) > Math.cos(Math.PI / 10));
    return near ? near.colour : [0.1, 0.1, 0.1];
}
/* Blue above, violet and orange at the horizon, green below. */
function sky([x, y]) {
    const rim = mix([0.9, 0.45, 0.2], [0.35, 0.2, 0.5], 0.5 - x / 2);
    return y > 0 ? mix(rim, [0.1, 0.25, 0.7], Math.sqrt(y)) :
        mix(mix(rim, [0, 0, 0], 0.5), [0.08, 0.15, 0.05], Math.sqrt(-y));
}

/* Degrees above the horizon and around, and of radius. */
const SUNS = {
    dusk: {up: 6, around: 40, radius: 1.2, colour: [1, 0.55, 0.2], share: 0.6},
    blaze: {up: 48, around: 160, radius: 1, colour: [1, 0.9, 0.7], share: 0.9}
};

/* The radiance of each pixel, row by row. */
export function radiance(name) {
    const pixels = [], weights = [], sunny = [];
    const sun = SUNS[name], rad = Math.PI / 180;
    for (let j = 0; j < HEIGHT; j++)
        for (let i = 0; i < WIDTH; i++) {
            const t = Math.PI * (j + 0.5) / HEIGHT;
            const p = 2 * Math.PI * ((i + 0.5) / WIDTH - 0.5);
            const d = [Math.sin(t) * Math.cos(p), Math.cos(t),
                       Math.sin(t) * Math.sin(p)];
            weights.push(Math.sin(t));
            pixels.push(sun ? sky(d) : lamp(d));
            sunny.push(sun && dot(d, [
                Math.cos(sun.up * rad) * Math.cos(sun.around * rad),
                Math.sin(sun.up * rad),
                Math.cos(sun.up * rad) * Math.sin(sun.around * rad)]) >
                Math.cos(sun.radius * rad));
        }
    if (!sun)
        return pixels;
    let all = 0, part = 0;
    weights.forEach((w, i) => {
        all += w * luminance(pixels[i]);
        part += sunny[i] ? w * luminance(sun.colour) : 0;
    });
    const scale = all / part * sun.share / (1 - sun.share);
    return pixels.map((c, i) =>
        sunny[i] ? c.map((x, k) => x + scale * sun.colour[k]) : c);
}

/* node maps.mjs NAME */
if (process.argv[1] === fileURLToPath(import.meta.url)) {
    const out = radiance(process.argv[2]).flatMap(c => {
        const e = Math.floor(Math.log2(Math.max(...c))) + 1;
        return [...c.map(x => Math.min(255, Math.round(x * 2 ** (8 - e)))),
                e + 128];
    });
    process.stdout.write(Buffer.concat([Buffer.from(
        `#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y ${HEIGHT} +X ${WIDTH}\n`),
        Buffer.from(out)]));
}

// SPDX-License-Identifier: MIT
/*
 * The map that tells axes apart: on grey, a disc of 18 degrees and a colour of
 * its own around each. lampsMap() is its .hdr; the world is the one of
 * <ibl/ibl.h>: u = atan2(z, x) / 2 pi + 1/2.
 */
import {fileURLToPath} from 'node:url';

export const lamps = [
    {axis: [1, 0, 0], colour: [1, 0, 0]}, {axis: [-1, 0, 0], colour: [0, 1, 1]},
    {axis: [0, 1, 0], colour: [0, 1, 0]}, {axis: [0, -1, 0], colour: [1, 0, 1]},
    {axis: [0, 0, 1], colour: [0, 0, 1]}, {axis: [0, 0, -1], colour: [1, 1, 0]}
];
const [WIDTH, HEIGHT] = [512, 256];
const HALF = 128, GREY = 13; // RGBE of exponent 129: 1, and 0.1

export function lampsMap() {
    const head = `#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y ${HEIGHT} +X ${WIDTH}\n`;
    const texels = Buffer.alloc(WIDTH * HEIGHT * 4);
    for (let j = 0, at = 0; j < HEIGHT; j++)
        for (let i = 0; i < WIDTH; i++, at += 4) {
            const t = Math.PI * (j + 0.5) / HEIGHT;
            const p = 2 * Math.PI * ((i + 0.5) / WIDTH - 0.5);
            const d = [Math.sin(t) * Math.cos(p), Math.cos(t),
                       Math.sin(t) * Math.sin(p)];
            const lamp = lamps.find(({axis}) =>
                axis.reduce((sum, x, k) => sum + x * d[k], 0) >
                    Math.cos(Math.PI / 10));
            for (let k = 0; k < 3; k++)
                texels[at + k] = lamp ? HALF * lamp.colour[k] : GREY;
            texels[at + 3] = 129;
        }
    return Buffer.concat([Buffer.from(head), texels]);
}

/* node lamps.mjs >lamps.hdr */
if (process.argv[1] === fileURLToPath(import.meta.url))
    process.stdout.write(lampsMap());

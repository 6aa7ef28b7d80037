// SPDX-License-Identifier: MIT
// Compares pictures, none of which is read by our own code:
//   node png.mjs A.png B.png N [MEAN]   no value differs by more than N, and
//                                        none of the means of the values in
//                                        4 x 4 parts by more than MEAN
// They are 8-bit RGB without interlacing. Says what is not so.
// A.png@X,Y,TOP is a part of A, as large as B and from X, Y on, of both without
// the first TOP rows.
import {readPng} from './read_png.mjs';

// Of each part and channel.
function means({width, height, data}) {
    const sums = Array(48).fill(0), counts = Array(48).fill(0);
    for (let y = 0, i = 0; y < height; y++)
        for (let x = 0; x < width; x++) {
            const part = 4 * Math.floor(y * 4 / height) +
                Math.floor(x * 4 / width);
            for (let at = 3 * part; at < 3 * part + 3; at++, i++) {
                sums[at] += data[i];
                counts[at]++;
            }
        }
    return sums.map((sum, i) => counts[i] ? sum / counts[i] : 0);
}

function cut({width, data}, x, y, size, top) {
    const rows = [];
    for (let i = top; i < size.height; i++) {
        const at = 3 * ((y + i) * width + x);
        rows.push(data.subarray(at, at + 3 * size.width));
    }
    return {...size, height: size.height - top, data: Buffer.concat(rows)};
}

const [first, second, most, mean] = process.argv.slice(2);
const [name, at] = first.split('@');
let [a, b] = [name, second].map(readPng);
if (at) {
    const [x, y, top] = at.split(',').map(Number);
    [a, b] = [cut(a, x, y, b, top), cut(b, 0, 0, b, top)];
}
let worst = a.width === b.width && a.height === b.height ? 0 : Infinity;
for (let i = 0; i < a.data.length; i++)
    worst = Math.max(worst, Math.abs(a.data[i] - b.data[i]));
if (!(worst <= +most))
    console.log(`${first} and ${second} differ by ${worst}`);
if (mean !== undefined) {
    const other = means(b);
    const off = means(a).map((x, i) => Math.abs(x - other[i]));
    const part = off.indexOf(Math.max(...off));
    if (!(off[part] <= +mean))
        console.log(`${first} and ${second} differ by ${off[part].toFixed(2)}` +
            ` in the mean of part ${Math.floor(part / 3)}`);
}

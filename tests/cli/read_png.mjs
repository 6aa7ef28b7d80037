// SPDX-License-Identifier: MIT
// A PNG's bytes, by no code of ours.
import fs from 'fs';
import zlib from 'zlib';

// PNG specification (W3C, 2nd edition), 9.2: what a filter predicts.
const predict = [
    () => 0,
    (a) => a,
    (a, b) => b,
    (a, b) => (a + b) >> 1,
    (a, b, c) => {
        const pa = Math.abs(b - c), pb = Math.abs(a - c);
        const pc = Math.abs(a + b - 2 * c);
        return pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
    },
];

export function readPng(path) {
    return decodePng(fs.readFileSync(path), path, 2);
}

// Of colour type 2, RGB, or 6, RGBA.
export function decodePng(file, path, type) {
    const depth = type === 6 ? 4 : 3;
    const parts = [];
    let width, height;
    for (let at = 8; at < file.length;) {
        const size = file.readUInt32BE(at);
        const kind = file.toString('latin1', at + 4, at + 8);
        const body = file.subarray(at + 8, at + 8 + size);
        if (kind === 'IHDR') {
            width = body.readUInt32BE(0);
            height = body.readUInt32BE(4);
            if (body[8] !== 8 || body[9] !== type || body[12] !== 0)
                throw Error(`${path}: not 8 bits of type ${type}`);
        }
        if (kind === 'IDAT')
            parts.push(body);
        at += 12 + size;
    }
    const raw = zlib.inflateSync(Buffer.concat(parts));
    const row = depth * width;
    const data = Buffer.alloc(row * height);
    for (let y = 0; y < height; y++) {
        const filter = raw[y * (row + 1)];
        for (let x = 0; x < row; x++) {
            const at = y * row + x;
            const a = x < depth ? 0 : data[at - depth];
            const b = y ? data[at - row] : 0;
            const c = x < depth || !y ? 0 : data[at - row - depth];
            data[at] = raw[y * (row + 1) + 1 + x] + predict[filter](a, b, c);
        }
    }
    return {width, height, data};
}

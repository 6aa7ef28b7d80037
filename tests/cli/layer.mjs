// SPDX-License-Identifier: MIT
// Compares layers of KTX2 arrays with KTX2 of one layer, texel by texel.
//   node layer.mjs [--alpha GREY] ARRAY LAYER SINGLE [ARRAY LAYER SINGLE ...]
// Prints what differs; nothing: the same bytes. With GREY, all of halves, the
// array has as its alpha what that map is, 1 at most.
import fs from 'fs';

// The levels of a file: for each the texels of its layers.
function levels(name) {
    const file = fs.readFileSync(name);
    const layers = Math.max(file.readUInt32LE(32), 1);
    const count = Math.max(file.readUInt32LE(40), 1);
    const out = {layers, size: file.readUInt32LE(20), level: []};
    for (let l = 0; l < count; l++) {
        const from = Number(file.readBigUInt64LE(80 + 24 * l));
        const bytes = Number(file.readBigUInt64LE(88 + 24 * l));
        out.level.push(file.subarray(from, from + bytes));
    }
    return out;
}

function compare(array, layer, single) {
    const a = levels(array), b = levels(single);
    if (grey)
        b.level.forEach((texels, l) => {
            for (let i = 6; i < texels.length; i += 8)
                texels.writeUInt16LE(Math.min(0x3C00,
                    grey.level[l].readUInt16LE(i - 6)), i);
        });
    if (a.size !== b.size || a.level.length !== b.level.length || b.layers !== 1)
        console.log(`${array}: another shape than ${single}`);
    else
        a.level.forEach((texels, l) => {
            const n = texels.length / a.layers;
            if (Buffer.compare(texels.subarray(n * layer, n * layer + n),
                               b.level[l]))
                console.log(`${array}: layer ${layer}, level ${l}: not ` +
                            `the texels of ${single}`);
        });
}

const files = process.argv.slice(2);
const grey = files[0] === '--alpha' ? levels(files.splice(0, 2)[1]) : null;
for (let i = 0; i < files.length; i += 3)
    compare(...files.slice(i, i + 3));

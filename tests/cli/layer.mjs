// SPDX-License-Identifier: MIT
// Compares layers of KTX2 arrays with KTX2 of one layer, texel by texel.
//   node layer.mjs ARRAY LAYER SINGLE [ARRAY LAYER SINGLE ...]
// Prints what differs; nothing: the same bytes.
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

for (let i = 2; i < process.argv.length; i += 3)
    compare(...process.argv.slice(i, i + 3));

// SPDX-License-Identifier: MIT
// Changes a rgba32f DDS cube of iblbake as bakers do by mistake.
//   node damage.mjs IN HOW OUT
//   swap    faces +X and +Y change places
//   shift   half a texel to the right, in every level but the first
//   nan     one channel of one texel of the last level
//   scale=K every value times K
//   face=K  every value of +X plus K
//   upper=K every value of +X plus K, in its upper half alone
import fs from 'fs';

const [input, how, output] = process.argv.slice(2);
const file = fs.readFileSync(input);
const head = 148; // magic, DDS_HEADER, DDS_HEADER_DXT10
const size = file.readUInt32LE(16);
const levels = Math.max(file.readUInt32LE(28), 1);
const edge = l => Math.max(size >> l, 1);

// Faces follow each other with all their levels.
let chain = 0;
for (let l = 0; l < levels; l++) chain += 16 * edge(l) ** 2;
if (file.length !== head + 6 * chain) throw new Error(`${input}: not as said`);
const at = (l, face, x, y, c) => {
    let offset = head + face * chain;
    for (let k = 0; k < l; k++) offset += 16 * edge(k) ** 2;
    return offset + 16 * (y * edge(l) + x) + 4 * c;
};

function each(change) {
    const old = Buffer.from(file);
    for (let l = 0; l < levels; l++)
        for (let face = 0; face < 6; face++)
            for (let y = 0; y < edge(l); y++)
                for (let x = 0; x < edge(l); x++)
                    for (let c = 0; c < 3; c++)
                        file.writeFloatLE(change(old, l, face, x, y, c),
                            at(l, face, x, y, c));
    fs.writeFileSync(output, file);
}
const value = (old, ...where) => old.readFloatLE(at(...where));
const [what, k] = how.split('=');

each((old, l, face, x, y, c) => {
    const v = value(old, l, face, x, y, c);
    switch (what) {
    case 'swap':
        return value(old, l, [2, 1, 0, 3, 4, 5][face], x, y, c);
    case 'shift':
        return l === 0 ? v : (v + value(old, l, face,
            Math.min(x + 1, edge(l) - 1), y, c)) / 2;
    case 'nan':
        return l === levels - 1 && face === 3 && x === 0 && y === 0 &&
            c === 1 ? NaN : v;
    case 'scale':
        return v * k;
    case 'face':
        return face === 0 ? v + Number(k) : v;
    case 'upper':
        return face === 0 && 2 * y < edge(l) ? v + Number(k) : v;
    default:
        throw new Error(how);
    }
});

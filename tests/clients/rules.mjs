// SPDX-License-Identifier: MIT
/*
 * Bevy and Cesium do not run here: these are readers after their rules. Of each
 * target
 *   chain   options of the exact levels
 *   most    the relative error that its texels may have
 *   read(modules, dir) gives radiance(d, roughness) and diffuse(n), which is
 *           E/pi (harmonic: of nine coefficients), in the engine's axes, which
 *           are those of our world
 */
import {readFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import path from 'node:path';
import {pathToFileURL} from 'node:url';

import {level, lookup} from './cube.mjs';

const need = (modules, name) =>
    createRequire(path.join(modules, 'x.js'))(name);

/* ---- KTX2 ----------------------------------------------------------------- */

const RGBA16F = 97, RGB9E5 = 123, ZSTANDARD = 2;

function half(bits) {
    const exponent = bits >> 10 & 31, rest = bits & 1023;
    return (bits >> 15 ? -1 : 1) * (exponent ?
        2 ** (exponent - 15) * (1 + rest / 1024) : rest * 2 ** -24);
}
/* Four floats of each texel. */
function unpack(format, bytes) {
    const data = bytes.buffer.slice(bytes.byteOffset,
                                    bytes.byteOffset + bytes.byteLength);
    if (format === RGBA16F)
        return Float32Array.from(new Uint16Array(data), half);
    if (format !== RGB9E5)
        throw new Error('vkFormat ' + format);
    const out = [];
    for (const bits of new Uint32Array(data)) {
        const scale = 2 ** ((bits >>> 27) - 24);
        out.push((bits & 511) * scale, (bits >>> 9 & 511) * scale,
                 (bits >>> 18 & 511) * scale, 1);
    }
    return out;
}
async function readKtx2(modules, name, zstandard) {
    const file = need(modules, 'ktx-parse').read(readFileSync(name));
    const packed = file.supercompressionScheme === ZSTANDARD;
    if (packed !== zstandard)
        throw new Error(`${name}: scheme ${file.supercompressionScheme}`);
    let decoder;
    if (packed) {
        const {ZSTDDecoder} = await import(pathToFileURL(path.join(modules,
            'three/examples/jsm/libs/zstddec.module.js')));
        decoder = new ZSTDDecoder();
        await decoder.init();
    }
    return file.levels.map(({levelData, uncompressedByteLength}) => {
        const data = unpack(file.vkFormat, packed ?
            decoder.decode(levelData, uncompressedByteLength) : levelData);
        return level(Math.sqrt(data.length / 24), 4, data);
    });
}
/* A level for each of evenly spaced roughnesses. */
const even = levels => (d, roughness) =>
    lookup(levels, d, roughness * (levels.length - 1));

/* ---- Bevy: looks cubes up with z negated ---------------------------------- */

const bevy = {
    chain: '--mapping linear --size 256 --levels 6', most: 3e-3,
    async read(modules, dir) {
        const read = what => readKtx2(modules,
            path.join(dir, `map_${what}.ktx2`), true);
        const light = even(await read('specular'));
        const diffuse = await read('irradiance');
        return {radiance: ([x, y, z], r) => light([x, y, -z], r),
                diffuse: ([x, y, z]) => lookup(diffuse, [x, y, -z], 0)};
    }
};

/* ---- Cesium: RGBA16F without Zstandard, coefficients with all constants --- */

const cesium = {
    chain: bevy.chain, most: 3e-3,
    async read(modules, dir) {
        const light = even(await readKtx2(
            modules, path.join(dir, 'map_specular.ktx2'), false));
        const flat = JSON.parse(
            readFileSync(path.join(dir, 'map_sh.txt'), 'utf8'));
        const sh = [...Array(9).keys()].map(i => flat.slice(3 * i, 3 * i + 3));
        return {radiance: light, harmonic: true, diffuse([x, y, z]) {
            const basis = [1, y, z, x, y * x, y * z, 3 * z * z - 1, z * x,
                           x * x - y * y];
            return [0, 1, 2].map(c =>
                basis.reduce((sum, b, i) => sum + b * sh[i][c], 0));
        }};
    }
};

export const rules = {bevy, cesium};

/* ---- three's own LightProbe ----------------------------------------------- */

/* E/pi of NAME_sh.txt. */
export async function lightProbe(modules, dir) {
    const {SphericalHarmonics3, Vector3} = await import(pathToFileURL(
        path.join(modules, 'three/build/three.module.js')));
    const sh = new SphericalHarmonics3().fromArray(JSON.parse(
        readFileSync(path.join(dir, 'map_sh.txt'), 'utf8')));
    return n => sh.getIrradianceAt(new Vector3(...n), new Vector3())
        .divideScalar(Math.PI).toArray();
}

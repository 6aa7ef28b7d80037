// SPDX-License-Identifier: MIT
/*
 * The exact levels of a map: DIR/exact-NAME, baked as rgba32f cubes in our
 * world, read by ktx-parse. NAME has the options, without their dashes.
 */
import {readFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import path from 'node:path';

import {level} from './cube.mjs';

/* Levels of floats of a KTX2 file, as the file has them. */
function floats(modules, name) {
    const {read} = createRequire(path.join(modules, 'x.js'))('ktx-parse');
    const file = read(readFileSync(name));
    return file.levels.map(({levelData}) => new Float32Array(
        levelData.buffer.slice(levelData.byteOffset,
                               levelData.byteOffset + levelData.byteLength)));
}
const cube = (modules, name) => floats(modules, name).map(data =>
    level(Math.sqrt(data.length / 24), 4, data));

const kept = new Map();
export function readExact(modules, dir, chain) {
    const from = path.join(dir,
        'exact-' + chain.replace(/--/g, '').replace(/ /g, '-'));
    if (!kept.has(from)) {
        const {irradiance} = JSON.parse(
            readFileSync(path.join(from, 'map.json'), 'utf8')).sh;
        kept.set(from, {
            levels: cube(modules, path.join(from, 'map_specular.ktx2')),
            irradiance: cube(modules,
                             path.join(from, 'map_irradiance.ktx2'))[0],
            sh: irradiance,
            // Luminance of all light.
            mean: 0.28209479 * [0.2126, 0.7152, 0.0722].reduce(
                (sum, w, c) => sum + w * irradiance[0][c], 0)});
    }
    return kept.get(from);
}

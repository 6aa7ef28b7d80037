// SPDX-License-Identifier: MIT
// Reads an engine's own file as the engine does, and compares it with the DDS
// file of rgba32f and the sidecar of the same bake:
//   node engine_files.mjs SPECULAR.dds SIDECAR.json FILE [IRRADIANCE.dds]
// Says what is not so.
import fs from 'fs';
import path from 'path';
import {decodePng} from './read_png.mjs';

const [dds, sidecar, name, diffuse] = process.argv.slice(2);
const sh = JSON.parse(fs.readFileSync(sidecar)).sh.irradiance;

// Faces, then their levels; rows from the top.
function readDds(file) {
    const b = fs.readFileSync(file);
    const size = b.readUInt32LE(12), levels = b.readUInt32LE(28) || 1;
    const cube = [];
    let at = 148;
    for (let f = 0; f < 6; f++)
        for (let l = 0; l < levels; l++) {
            const n = size >> l || 1;
            (cube[l] ||= {n, faces: []}).faces[f] =
                new Float32Array(b.buffer.slice(b.byteOffset + at,
                    b.byteOffset + at + 16 * n * n));
            at += 16 * n * n;
        }
    return cube;
}
const want = readDds(dds);

function close(what, got, wanted, by) {
    const square = (list) => list.reduce((sum, x) => sum + x * x, 0);
    const error = Math.sqrt(square(got.map((x, i) => x - wanted[i])) /
        square(wanted));
    if (!(error <= by))
        console.log(`${name}: ${what} is off by ${error}, more than ${by}`);
}

// Babylon's fromRGBD of a face whose rows are from the bottom.
function checkFace(png, level, face, cube = want) {
    const {n, faces} = cube[level];
    const {width, height, data} = decodePng(png, name, 6);
    if (width !== n || height !== n)
        return console.log(`${name}: a face of ${width}x${height}, not ${n}`);
    const got = [], wanted = [];
    for (let y = 0; y < n; y++)
        for (let x = 0; x < n; x++)
            for (let c = 0; c < 3; c++) {
                const at = 4 * ((n - 1 - y) * n + x);
                got.push((data[at + c] / 255) ** 2.2 / (data[at + 3] / 255));
                wanted.push(faces[face][4 * (y * n + x) + c]);
            }
    close(`face ${face} of level ${level}`, got, wanted, 6e-3);
}

// Its basis, with the Condon-Shortley phase: SH3ylmBasisConstants.
const pi = Math.PI, root = Math.sqrt;
const basis = [root(1 / (4 * pi)), -root(3 / (4 * pi)), root(3 / (4 * pi)),
    -root(3 / (4 * pi)), root(15 / (4 * pi)), -root(15 / (4 * pi)),
    root(5 / (16 * pi)), -root(15 / (4 * pi)), root(15 / (16 * pi))];
const shown = (c) => c.map((rgb, i) => rgb.map((x) => x * basis[i])).flat();
// What a shader is to show, from our coefficients of E/pi.
const right = sh.map((rgb, i) => rgb.map((x) => x * Math.abs(basis[i]))).flat();

function checkEnv() {
    const b = fs.readFileSync(name);
    if (b.toString('hex', 0, 8) !== '86168796f6d69636')
        return console.log('not an .env');
    const end = b.indexOf(0, 8);
    const info = JSON.parse(b.toString('latin1', 8, end));
    if (info.version !== 2 || info.imageType !== 'image/png' ||
        info.width !== want[0].n || info.specular.lodGenerationScale !== 0.8 ||
        info.specular.mipmaps.length !== 6 * want.length)
        console.log('another manifest', info);
    info.specular.mipmaps.forEach(({length, position}, i) => checkFace(
        b.subarray(end + 1 + position, end + 1 + position + length),
        Math.floor(i / 6), i % 6));
    // What matte surfaces look up.
    const matte = info.irradiance.irradianceTexture;
    if (matte.size !== 16 || matte.faces.length !== 6)
        console.log('another irradianceTexture', matte);
    matte.faces.forEach(({length, position}, face) => checkFace(b.subarray(
        end + 1 + position, end + 1 + position + length), 0, face,
        readDds(diffuse)));
    // SphericalHarmonics.FromPolynomial.
    const p = info.irradiance, add = (k, ...terms) => [0, 1, 2].map(
        (c) => pi * k * terms.reduce((s, [w, v]) => s + w * v[c], 0));
    close('irradiance', shown([
        add(0.376127, [1, p.xx], [1, p.yy], [1, p.zz]),
        add(-0.977204, [1, p.y]), add(0.977204, [1, p.z]),
        add(-0.977204, [1, p.x]), add(1.16538, [1, p.xy]),
        add(-1.16538, [1, p.yz]),
        add(1, [1.34567, p.zz], [-0.672834, p.xx], [-0.672834, p.yy]),
        add(-1.16538, [1, p.zx]), add(1.16538, [1, p.xx], [-1, p.yy])]),
        right, 1e-3);
}

function checkGltf() {
    const g = JSON.parse(fs.readFileSync(name));
    const ext = 'EXT_lights_image_based';
    const light = g.extensions[ext].lights[g.scenes[g.scene].extensions[ext].light];
    if (g.asset.version !== '2.0' || !g.extensionsUsed.includes(ext) ||
        light.intensity !== 1 || String(light.rotation) !== '0,0,0,1' ||
        light.specularImageSize !== want[0].n ||
        light.specularImages.length !== want.length)
        console.log('another light', light);
    light.specularImages.forEach((faces, level) => faces.forEach((i, face) => {
        const {uri, mimeType} = g.images[i];
        if (mimeType !== 'image/png' || !/^[\w.%-]+$/.test(uri))
            console.log(`an image ${uri}`);
        checkFace(fs.readFileSync(path.join(path.dirname(name),
            decodeURIComponent(uri))), level, face);
    }));
    // convertIrradianceToLambertianRadiance.
    close('irradiance', shown(light.irradianceCoefficients).map((x) => x / pi),
        right, 1e-6);
}

// A level's value towards d, of the nearest texel.
function nearest({n, faces}, [x, y, z]) {
    const m = Math.max(Math.abs(x), Math.abs(y), Math.abs(z));
    const [face, u, v] = m === x ? [0, -z, -y] : m === -x ? [1, z, -y]
        : m === y ? [2, x, z] : m === -y ? [3, x, -z]
            : m === z ? [4, x, -y] : [5, -x, -y];
    const at = (t) => Math.min(n - 1, Math.floor((t / m + 1) / 2 * n));
    const i = 4 * (at(v) * n + at(u));
    return [...faces[face].slice(i, i + 3)];
}

// decodeRGBP and toSphericalUv, of texels inside of a rectangle.
function checkRectangle(data, left, top, width, level, by) {
    const got = [], wanted = [], height = width / 2;
    for (let y = 1; y < height - 1; y++)
        for (let x = 1; x < width - 1; x++) {
            const at = 4 * ((top + y) * 512 + left + x);
            const scale = 8 - 7 * data[at + 3] / 255;
            const phi = 2 * pi * ((x - 0.5) / (width - 2) - 0.5);
            const theta = pi * (0.5 - (y - 0.5) / (height - 2));
            for (let c = 0; c < 3; c++)
                got.push((data[at + c] / 255 * scale) ** 2);
            // No step of 7 / 255 is wasted on the range.
            if (scale > 1 && Math.max(...data.slice(at, at + 3)) <
                254 - 7 / scale)
                console.log('a range of', scale, data.slice(at, at + 4));
            wanted.push(...nearest(level, [Math.cos(theta) * Math.cos(phi),
                Math.sin(theta), Math.cos(theta) * Math.sin(phi)]));
        }
    close(`the rectangle at ${left}, ${top}`, got, wanted, by);
}

function checkAtlas() {
    const {width, height, data} = decodePng(fs.readFileSync(name), name, 6);
    if (width !== 512 || height !== 512)
        console.log('another size');
    checkRectangle(data, 0, 0, 512, want[0], 0.2);
    checkRectangle(data, 256, 256, 256, want[0], 0.2);
    for (let k = 1; k < 6; k++)
        checkRectangle(data, 0, 512 - (512 >> k), 512 >> k, want[k],
            k < 4 ? 0.1 : 0.3);
    checkRectangle(data, 128, 384, 64, readDds(diffuse)[0], 0.05);
}

({'.env': checkEnv, '.gltf': checkGltf, '.png': checkAtlas})[
    path.extname(name)]();

// SPDX-License-Identifier: MIT
// Makes the inputs of pairs.mjs: maps of 64x32 and the like, models, sets.
import fs from 'node:fs';

// OpenEXR as "OpenEXR File Layout" has it: uncompressed floats, a scan line a
// chunk; light(u, v, layer) gives red, green and blue.
function exr(name, width, height, light, layers = ['']) {
    const channels = layers.flatMap((layer, l) => ['B', 'G', 'R'].map((c, k) =>
        ({name: layer + c, at: (u, v) => light(u, v, l)[2 - k]})));
    const i32 = (...n) => Buffer.from(Int32Array.from(n).buffer);
    const f32 = (...n) => Buffer.from(Float32Array.from(n).buffer);
    const text = s => Buffer.from(s + '\0');
    const attribute = (key, type, data) =>
        Buffer.concat([text(key), text(type), i32(data.length), data]);
    const box = i32(0, 0, width - 1, height - 1);
    const head = Buffer.concat([i32(0x01312f76, 2),
        attribute('channels', 'chlist', Buffer.concat([
            ...channels.map(c => Buffer.concat([text(c.name),
                i32(2, 0, 1, 1)])), Buffer.from([0])])),
        attribute('compression', 'compression', Buffer.from([0])),
        attribute('dataWindow', 'box2i', box),
        attribute('displayWindow', 'box2i', box),
        attribute('lineOrder', 'lineOrder', Buffer.from([0])),
        attribute('pixelAspectRatio', 'float', f32(1)),
        attribute('screenWindowCenter', 'v2f', f32(0, 0)),
        attribute('screenWindowWidth', 'float', f32(1)), Buffer.from([0])]);
    const bytes = 4 * width * channels.length;
    const first = head.length + 8 * height;
    const table = Buffer.alloc(8 * height), lines = [];
    for (let j = 0; j < height; j++) {
        table.writeBigUInt64LE(BigInt(first + j * (8 + bytes)), 8 * j);
        lines.push(i32(j, bytes), ...channels.map(c => f32(...Array.from(
            {length: width}, (_, i) => c.at((i + .5) / width,
                (j + .5) / height)))));
    }
    fs.writeFileSync(name, Buffer.concat([head, table, ...lines]));
}
// Flat RGBE.
function hdr(name, width, height, light) {
    const bytes = [];
    for (let j = 0; j < height; j++)
        for (let i = 0; i < width; i++) {
            const rgb = light((i + .5) / width, (j + .5) / height);
            const e = Math.floor(Math.log2(Math.max(...rgb))) + 1;
            bytes.push(...rgb.map(v => Math.min(255, v * 256 / 2 ** e)),
                e + 128);
        }
    fs.writeFileSync(name, Buffer.concat([Buffer.from('#?RADIANCE\n' +
        `FORMAT=32-bit_rle_rgbe\n\n-Y ${height} +X ${width}\n`),
        Buffer.from(bytes)]));
}
const mild = (u, v) => [1 + .5 * Math.cos(6.28 * u) * Math.sin(3.14 * v),
    1 + .4 * Math.sin(12.57 * u) * Math.sin(3.14 * v) ** 2,
    1 + .6 * Math.cos(3.14 * v)];
const sun = (u, v) => Math.floor(64 * u) === 48 && Math.floor(32 * v) === 8 ?
    [9e4, 8e4, 6e4] : v < .5 ? [.4, .6, 1.1] : [.2, .15, .1];

function model(name, material) {
    const places = Buffer.from(new Float32Array(
        [-1, -1, 0, 1, -1, 0, -1, 1, 0, 1, 1, 0]).buffer).toString('base64');
    fs.writeFileSync(name, JSON.stringify({
        asset: {version: '2.0'}, materials: [material], scene: 0,
        extensionsUsed: Object.keys(material.extensions ?? {}),
        buffers: [{byteLength: 48, uri:
            'data:application/octet-stream;base64,' + places}],
        bufferViews: [{buffer: 0, byteLength: 48}],
        accessors: [{bufferView: 0, componentType: 5126, count: 4,
            type: 'VEC3', min: [-1, -1, 0], max: [1, 1, 0]}],
        meshes: [{primitives: [{mode: 5, material: 0,
            attributes: {POSITION: 0, NORMAL: 0}}]}],
        nodes: [{mesh: 0}], scenes: [{nodes: [0]}]}));
}
const probes = map => ({version: 1,
    defaults: {size: 16, levels: 2, irradiance: 4, lut_size: 8},
    global: {capture: {equirect: map}},
    probes: [
        {name: 'hall', position: [0, 1, 0], capture: {equirect: map},
            influence: {box: {centre: [0, 1, 0], half: [6, 6, 6]}}, blend: 1,
            proxy: {sphere: {centre: [0, 1, 0], radius: 4}}},
        {name: 'lamp', position: [1, 1, 0], capture: {equirect: 'sun.hdr'},
            influence: {sphere: {centre: [1, 1, 0], radius: 1}}}]});

// bake(WORDS...) runs iblbake in this directory.
export function makeInputs(bake) {
    const json = (name, value) =>
        fs.writeFileSync(name, JSON.stringify(value));
    exr('mild.exr', 64, 32, mild);
    hdr('sun.hdr', 64, 32, sun);
    exr('nan.exr', 64, 32, (u, v) => u < .02 ? [NaN, 1, -1] : mild(u, v));
    exr('layers.exr', 64, 32, (u, v, l) => l ? sun(u, v) : mild(u, v),
        ['', 'wide.']);
    for (const [name, width, height] of [['wide', 64, 20], ['square', 32, 32],
        ['hcross', 64, 48], ['vcross', 48, 64], ['hstrip', 96, 16],
        ['vstrip', 16, 96]])
        exr(name + '.exr', width, height, mild);
    for (const level of [0, 1])
        for (const [k, face] of ['px', 'nx', 'py', 'ny', 'pz', 'nz'].entries())
            hdr(`${level}_${face}.hdr`, 16 >> level, 16 >> level,
                (u, v) => [1 + u, 1 + v, 1 + k / 6]);
    fs.mkdirSync('empty');
    fs.mkdirSync('folder');
    fs.copyFileSync('mild.exr', 'folder/mild.exr');
    fs.copyFileSync('sun.hdr', 'folder/sun.hdr');
    fs.writeFileSync('list.txt', '../sun.hdr\n');
    model('ball.gltf', {pbrMetallicRoughness: {roughnessFactor: .4}});
    model('sheen.gltf', {extensions: {KHR_materials_sheen:
        {sheenColorFactor: [1, .5, .2], sheenRoughnessFactor: .5}}});
    json('set.json', probes('mild.exr'));
    json('wide.json', probes('wide.exr'));
    json('nan.json', probes('nan.exr'));
    json('sh.json', {...probes('mild.exr'), defaults: {size: 8,
        irradiance: 'sh', lut_size: 8}});
    json('grid.json', {version: 1, grid: {box: {min: [0, 0, 0],
        max: [4, 2, 4]}, counts: [2, 1, 2], capture: {equirect: '%n.exr'}}});
    const small = ['-q', '--size', '16', '--lut-size', '8',
        '--irradiance-size', '4', '--skybox', '4'];
    bake('mild.exr', '-o', 'set', ...small);
    bake('-q', '--only', 'lut', '--geometry', 'schlick-ibl', '--lut-size', '8',
        '-o', 'schlick');
    bake('sun.hdr', '-o', 'sunset', ...small, '--sun', '--format', 'dds',
        '--pixel', 'rgba32f', '--lobe-table-size', '8');
    bake('mild.exr', '-o', 'png', '-q', '--target', 'gltf', '--size', '16');
    bake('mild.exr', '-o', 'flat', ...small, '--layout', 'octahedral');
    fs.copyFileSync('set/mild_skybox.ktx2', 'cube.ktx2');
    bake('probes', 'set.json', '-o', 'probes', '-q');
}

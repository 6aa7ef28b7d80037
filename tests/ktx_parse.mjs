// SPDX-License-Identifier: MIT
/*
 * node tests/ktx_parse.mjs NPM FILE...
 *
 * Reads textures that write_textures wrote with readers that others wrote,
 * installed under NPM/node_modules: KTX2 with ktx-parse, KTX with three's
 * KTXLoader, DDS with parse-dds (which knows rgba32f cubes with all levels
 * alone; the header of others is checked against Microsoft's numbers). The two
 * last do not know arrays: KTX arrays are taken apart here as the
 * specification says. Zstandard is unpacked by three's decoder. UASTC HDR of
 * one layer (others are made of odd bytes) is decoded by Basis Universal's
 * transcoder and compared with NAME.half. The texels of FILE = PIXEL-SHAPE.EXT
 * are compared with PIXEL-SHAPE.raw.
 * Prints a line for each file; the last line is "N passed, N failed".
 */
import {readFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import path from 'node:path';
import {pathToFileURL} from 'node:url';

const [npm, ...files] = process.argv.slice(2);
if (!files.length) {
    console.error('usage: node ktx_parse.mjs NPM FILE...');
    process.exit(2);
}
const modules = path.resolve(npm, 'node_modules');
const require = createRequire(path.join(modules, 'x.js'));
const three = name => import(pathToFileURL(
    path.join(modules, 'three/examples/jsm/loaders', name)));

const ktxParse = require('ktx-parse');
const parseDds = require('parse-dds');
const {KTXLoader} = await three('KTXLoader.js');
const {ZSTDDecoder} = await three('../libs/zstddec.module.js');
const zstd = new ZSTDDecoder();
await zstd.init();

/* A script for browsers, which require would take for a module. */
async function loadBasis() {
    const dir = path.join(modules, 'three/examples/jsm/libs/basis/');
    const script = readFileSync(dir + 'basis_transcoder.js', 'utf8');
    const make = new Function('require', '__dirname', '__filename',
                              script + '; return BASIS;');
    const basis = await make(require, dir, dir + 'x.js')(
        {wasmBinary: readFileSync(dir + 'basis_transcoder.wasm')});
    basis.initializeBasis();
    return basis;
}
const basis = await loadBasis();
const RGB_HALF = 24;

/* SFLOAT samples are signed (0x40) floats (0x80) from -1 to 1. */
const [one, minusOne] = [0x3F800000, 0xBF800000 | 0];
const floats = (channels, bits) => channels.map((c, i) =>
    [i * bits, bits - 1, c | 0xC0, minusOne, one]);
const shared = [0, 1, 2].flatMap(c => [
    [9 * c, 8, c, 0, 8448], [27, 4, c | 0x20, 15, 31]]);
const block = (type, lower) => [[0, 127, type, lower, one]];
const small = [[0, 10, 0x80, 0, one], [11, 10, 0x81, 0, one],
               [22, 9, 0x82, 0, one]];
const pixels = {
    rgba16f: {vk: 97, type: 2, bytes: 8, gl: 0x881A, glType: 0x140B, dxgi: 10,
              samples: floats([0, 1, 2, 15], 16)},
    rgba32f: {vk: 109, type: 4, bytes: 16, gl: 0x8814, glType: 0x1406, dxgi: 2,
              samples: floats([0, 1, 2, 15], 32)},
    rgb9e5: {vk: 123, type: 4, bytes: 4, gl: 0x8C3D, glType: 0x8C3E, dxgi: 67,
             samples: shared},
    r11g11b10f: {vk: 122, type: 4, bytes: 4, gl: 0x8C3A, glType: 0x8C3B,
                 dxgi: 26, samples: small},
    bc6h: {vk: 143, type: 1, bytes: 16, gl: 0x8E8F, glType: 0, dxgi: 95,
           edge: 4, model: 133, samples: block(0x80, 0)},
    'uastc-hdr': {vk: 1000066000, type: 1, bytes: 16, edge: 4, model: 167,
                  samples: block(0x80, 0)},
    astc4x4hdr: {vk: 1000066000, type: 1, bytes: 16, gl: 0x93B0, glType: 0,
                 edge: 4, model: 162, samples: block(0xC0, minusOne)},
    rg16f: {vk: 83, type: 2, bytes: 4, gl: 0x822F, glType: 0x140B, dxgi: 34,
            samples: floats([0, 1], 16)},
    rg32f: {vk: 103, type: 4, bytes: 8, gl: 0x8230, glType: 0x1406, dxgi: 16,
            samples: floats([0, 1], 32)},
};

function same(what, got, want) {
    const [a, b] = [JSON.stringify(got), JSON.stringify(want)];
    if (a !== b)
        throw new Error(`${what}: ${a}, not ${b}`);
}

function sameBytes(what, got, want) {
    if (Buffer.compare(Buffer.from(got), Buffer.from(want)))
        throw new Error(`${what}: other bytes`);
}

/* What the file's name promises. */
function expected(file) {
    const whole = path.basename(file, path.extname(file));
    const name = whole.replace(/-zstd$/, '');
    const [, pixel, shape, size, levels, layers = 1] =
        name.match(/^([\w-]+)-(cube|alpha|flat)(\d+)x(\d+)(?:x(\d+))?$/);
    const raw = readFileSync(path.join(path.dirname(file), name + '.raw'));
    const faces = shape === 'flat' ? 1 : 6;
    const images = [];
    let at = 0;
    for (let l = 0; l < levels; l++) {
        const edge = Math.max(size >> l, 1);
        const blocks = Math.ceil(edge / (pixels[pixel].edge ?? 1));
        const bytes = blocks * blocks * pixels[pixel].bytes;
        images.push({edge, bytes, faces: []}); // of all layers
        for (let f = 0; f < layers * faces; f++, at += bytes)
            images[l].faces.push(raw.subarray(at, at + bytes));
    }
    same('raw texels', raw.length, at);
    return {...pixels[pixel], pixel, size: +size, levels: +levels,
            layers: +layers, faces, images, alpha: shape === 'alpha',
            packed: name !== whole,
            half: path.join(path.dirname(file), name + '.half')};
}

/* Every texel, by another decoder. */
function checkBasis(bytes, want) {
    const k = new basis.KTX2File(new Uint8Array(bytes));
    same('Basis', [k.isValid(), !!k.isHDR(), k.getWidth(), k.getFaces(),
         k.getLevels(), k.getLayers(), k.startTranscoding()],
         [true, true, want.size, want.faces, want.levels,
          0, 1]);
    const half = readFileSync(want.half);
    let at = 0;
    want.images.forEach((image, l) => {
        const size = image.edge * image.edge * 6;
        for (let f = 0; f < want.faces; f++, at += size) {
            const got = new Uint8Array(
                k.getImageTranscodedSizeInBytes(l, 0, f, RGB_HALF));
            same(`level ${l}`, [got.length, k.transcodeImage(got, l, 0, f,
                 RGB_HALF, 0, -1, -1)], [size, 1]);
            sameBytes(`texels of level ${l} face ${f}`, got,
                      half.subarray(at, at + size));
        }
    });
    same('halves', half.length, at);
    k.close();
    k.delete();
}

function checkKtx2(bytes, want) {
    const k = ktxParse.read(new Uint8Array(bytes));
    same('vkFormat', k.vkFormat, want.vk);
    same('typeSize', k.typeSize, want.type);
    same('size', [k.pixelWidth, k.pixelHeight, k.pixelDepth, k.layerCount],
         [want.size, want.size, 0, want.layers > 1 ? want.layers : 0]);
    same('faces and levels', [k.faceCount, k.levelCount, k.levels.length],
         [want.faces, want.levels, want.levels]);
    same('supercompression', [k.supercompressionScheme, k.globalData],
         [want.packed ? 2 : 0, null]);

    same('descriptors', k.dataFormatDescriptor.length, 1);
    const d = k.dataFormatDescriptor[0];
    same('descriptor', [d.vendorId, d.descriptorType, d.versionNumber,
         d.colorModel, d.colorPrimaries, d.transferFunction, d.flags],
         [0, 0, ktxParse.KHR_DF_VERSION,
          want.model ?? ktxParse.KHR_DF_MODEL_RGBSDA,
          ktxParse.KHR_DF_PRIMARIES_BT709, ktxParse.KHR_DF_TRANSFER_LINEAR,
          want.alpha ? ktxParse.KHR_DF_FLAG_ALPHA_PREMULTIPLIED
                     : ktxParse.KHR_DF_FLAG_ALPHA_STRAIGHT]);
    const edge = (want.edge ?? 1) - 1;
    same('texel block', d.texelBlockDimension, [edge, edge, 0, 0]);
    same('planes', d.bytesPlane, [want.bytes, 0, 0, 0, 0, 0, 0, 0]);
    same('samples', d.samples.map(s => [s.bitOffset, s.bitLength,
         s.channelType, s.sampleLower, s.sampleUpper]), want.samples);
    same('sample positions', d.samples.every(s => s.samplePosition.every(
         p => p === 0)), true);

    same('keys', Object.keys(k.keyValue),
         ['KTXorientation', 'KTXwriter', 'Odd', 'iblRoughness']);
    same('KTXorientation', k.keyValue.KTXorientation, 'rd');
    same('KTXwriter', /^iblbake \d+\.\d+\.\d+$/.test(k.keyValue.KTXwriter),
         true);
    sameBytes('Odd', k.keyValue.Odd, Buffer.from('é\0'));
    sameBytes('iblRoughness', k.keyValue.iblRoughness,
              Buffer.from('0 0.25 0.5 1\0'));

    let end = Infinity; // the smallest level comes first
    k.levels.forEach((level, l) => {
        const at = level.levelData.byteOffset;
        const align = want.packed ? 1 : Math.max(4, want.bytes);
        same(`level ${l}'s alignment`, at % align, 0);
        same(`level ${l}'s place`, at < end, true);
        end = at;
        const size = level.uncompressedByteLength;
        const data = want.packed ? zstd.decode(level.levelData, size)
                                 : level.levelData;
        same(`level ${l}'s size`, size, data.byteLength);
        sameBytes(`level ${l}`, data, Buffer.concat(want.images[l].faces));
    });
    if (want.pixel === 'uastc-hdr' && want.layers === 1)
        checkBasis(bytes, want);
    return `vkFormat ${k.vkFormat}`;
}

/* KTX 1.1: an array's imageSize is the level's. */
function checkKtxArray(bytes, want) {
    const word = i => bytes.readUInt32LE(i);
    same('elements, faces and levels', [word(48), word(52), word(56)],
         [want.layers, want.faces, want.levels]);
    let at = 64 + word(60);
    want.images.forEach((image, l) => {
        const size = word(at);
        same(`level ${l}'s imageSize`, size,
             want.layers * want.faces * image.bytes);
        sameBytes(`level ${l}`, bytes.subarray(at + 4, at + 4 + size),
                  Buffer.concat(image.faces));
        at += 4 + size;
    });
    same('file size', bytes.length, at);
    return `${want.layers} layers, taken apart here`;
}

function checkKtx(bytes, want) {
    if (want.layers > 1)
        return checkKtxArray(bytes, want);
    const buffer = new Uint8Array(bytes).buffer;
    // It means to read compressed texels and warns, but it reads any.
    const warn = console.warn;
    console.warn = () => {};
    const k = new KTXLoader().parse(buffer, true);
    console.warn = warn;
    same('size', [k.width, k.height], [want.size, want.size]);
    same('glInternalFormat', k.format, want.gl);
    same('cube and levels', [k.isCubemap, k.mipmapCount, k.mipmaps.length],
         [want.faces === 6, want.levels, want.levels * want.faces]);
    want.images.forEach((image, l) => image.faces.forEach((face, f) => {
        const got = k.mipmaps[l * want.faces + f];
        same(`level ${l}'s edges`, [got.width, got.height],
             [image.edge, image.edge]);
        sameBytes(`level ${l} face ${f}`, got.data, face);
    }));
    const words = new DataView(buffer, 12);
    same('glType and size', [words.getUint32(4, true),
         words.getUint32(8, true)], [want.glType, want.type]);
    return `glInternalFormat 0x${k.format.toString(16)}`;
}

function checkDds(bytes, want) {
    const buffer = new Uint8Array(bytes).buffer;
    const words = new Uint32Array(buffer, 0, 37);
    same('magic, size', [words[0], words[1], words[19]],
         [0x20534444, 124, 32]);
    same('DX10', [words[21], words[32], words[33], words[34], words[35]],
         [0x30315844, want.dxgi, 3, want.faces === 6 ? 4 : 0,
          want.layers]);
    let offsets = null;
    if (want.pixel === 'rgba32f' && want.images.at(-1).edge === 1) {
        const d = parseDds(buffer);
        same('size', d.shape, [want.size, want.size]);
        same('format', [d.format, d.cubemap], ['rgba32f', true]);
        same('images', d.images.length, want.levels * 6);
        offsets = d.images.map(i => i.offset);
    }
    let at = 148;
    for (let f = 0; f < want.layers * want.faces; f++) {
        want.images.forEach((image, l) => {
            /* It reads the first layer. */
            const from = offsets?.[f * want.levels + l] ?? at;
            sameBytes(`face ${f} level ${l}`,
                      new Uint8Array(buffer, from, image.bytes),
                      image.faces[f]);
            at += image.bytes;
        });
    }
    same('file size', bytes.length, at);
    return `DXGI ${words[32]}${offsets ? ', by parse-dds' : ''}`;
}

const checks = {'.ktx2': checkKtx2, '.ktx': checkKtx, '.dds': checkDds};
let failed = 0;
for (const file of files) {
    try {
        const check = checks[path.extname(file)];
        const found = check(readFileSync(file), expected(file));
        console.log(`${path.basename(file)}: ${found}`);
    } catch (error) {
        console.log(`FAILED ${file}: ${error.message}`);
        failed++;
    }
}
console.log(`${files.length - failed} passed, ${failed} failed`);
process.exit(failed ? 1 : 0);

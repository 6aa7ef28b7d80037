// SPDX-License-Identifier: MIT
/*
 * node tests/bench_blocks.mjs NPM DIR
 *
 * Encodes DIR/rgba32f_specular.ktx2 with ktx2-encoder's Basis Universal as
 * UASTC HDR, in its default quality, and transcodes that to BC6H with three's;
 * both are installed under NPM/node_modules. Our cubes DIR/PIXEL_specular.ktx2
 * with the peer's blocks in place of ours become DIR/peer_PIXEL.ktx2. Prints
 * the processor's seconds to UASTC HDR, and to BC6H.
 */
import {readFileSync, writeFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import path from 'node:path';
import {pathToFileURL} from 'node:url';

const [npm, dir] = process.argv.slice(2);
const modules = path.resolve(npm, 'node_modules');
const require = createRequire(path.join(modules, 'x.js'));
const {read, write} = require('ktx-parse');
const encoder = await (await import(pathToFileURL(path.join(
    modules, 'ktx2-encoder/dist/basis/basis_encoder.js')))).default(
    {print() {}});
encoder.initializeBasis();

const basis = path.join(modules, 'three/examples/jsm/libs/basis/');
const make = new Function('require', '__dirname', '__filename',
    readFileSync(basis + 'basis_transcoder.js', 'utf8') +
    '\nreturn BASIS;')(require, basis, basis + 'x.js');
const transcoder = await make(
    {wasmBinary: readFileSync(basis + 'basis_transcoder.wasm')});
transcoder.initializeBasis();

const BC6H = 22; // transcoder_texture_format::cTFBC6H
const seconds = {encode: 0, transcode: 0};

function timed(what, call) {
    const from = process.cpuUsage(), result = call();
    const {user, system} = process.cpuUsage(from);
    if (!result)
        throw new Error(what + ' failed');
    seconds[what] += (user + system) / 1e6;
    return result;
}

/* The faces of a level below each other, so that the blocks' order is ours. */
function encode(texels, width) {
    const e = new encoder.BasisEncoder(), out = new Uint8Array(16 << 20);
    e.setCreateKTX2File(true);
    e.setKTX2UASTCSupercompression(false);
    e.setHDR(true);
    e.setMipGen(false);
    e.setTexType(0);
    e.setSliceSourceImageHDR(0, texels, width, 6 * width, 1, false, 100);
    const size = timed('encode', () => e.encode(out));
    e.delete();
    return out.slice(0, size);
}

function transcode(file) {
    const f = new transcoder.KTX2File(file);
    const to = new Uint8Array(f.getImageTranscodedSizeInBytes(0, 0, 0, BC6H));
    timed('transcode', () => f.startTranscoding() &&
        f.transcodeImage(to, 0, 0, 0, BC6H, 0, -1, -1));
    f.close();
    f.delete();
    return to;
}

const cube = pixel => read(readFileSync(`${dir}/${pixel}_specular.ktx2`));
const exact = cube('rgba32f'), bc6h = cube('bc6h'), uastc = cube('uastc-hdr');
// The smallest level comes first, which also warms the compiler up.
for (let l = exact.levels.length - 1; l >= 0; l--) {
    const floats = new Float32Array(exact.levels[l].levelData.slice().buffer);
    const half = floats.map(x => Math.min(x, 65504));
    const file = encode(new Uint8Array(half.buffer), exact.pixelWidth >> l);
    uastc.levels[l].levelData = read(file).levels[0].levelData;
    bc6h.levels[l].levelData = transcode(file);
}
writeFileSync(`${dir}/peer_bc6h.ktx2`, write(bc6h));
writeFileSync(`${dir}/peer_uastc-hdr.ktx2`, write(uastc));
console.log(seconds.encode.toFixed(3),
            (seconds.encode + seconds.transcode).toFixed(3));

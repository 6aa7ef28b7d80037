// SPDX-License-Identifier: MIT
// The functions of the package of npm: prints what they do wrong.
import assert from 'node:assert';
import fs from 'node:fs';
import { syncBuiltinESMExports } from 'node:module';
import threading, { Worker } from 'node:worker_threads';
import { bake, convert, info, run, verify } from 'iblbake';

const bytes = fs.readFileSync(process.argv[2]), name = 'forest.exr';
const refused = async (promise, what) => assert.rejects(promise, error => {
    assert.match(error.message, what);
    assert(!error.message.includes('\n'));
    return true;
});

const shares = [];
const { files, report, log } = await bake(bytes, { name, size: 32, irradianceSize: 8,
    only: ['specular', 'irradiance', 'json'], onProgress: done => shares.push(done) });
assert.deepEqual(Object.keys(files).sort(),
    ['forest.json', 'forest_irradiance.ktx2', 'forest_specular.ktx2']);
assert.equal(report.source.path, name);
assert.equal(log, '');
assert(shares.length > 4 && shares.at(-1) === 1 && shares.every(s => s >= 0 && s <= 1));

// Threads change no byte. A blob is taken too, runs beside each other give the same,
// lists have commas.
const again = await Promise.all([1, 2, 5].map(threads => bake(new Blob([bytes]), { name,
    threads, size: 32, irradianceSize: 8, only: 'specular,irradiance,json' })));
for (const one of again) assert.deepEqual(one.files, files);

// As many threads begin as are asked for, but for some that rest.
let threads = 0;
threading.Worker = class extends Worker {
    constructor(...given) {
        super(...given);
        threads++;
    }
};
syncBuiltinESMExports();
assert.deepEqual((await bake(bytes, { name, threads: 9, only: 'lut' })).files['brdf_lut.ktx2'],
    (await bake(bytes, { name, only: 'lut' })).files['brdf_lut.ktx2']);
assert(threads > 4);

const texture = files['forest_specular.ktx2'];
assert.equal((await info(texture, { name: 'a.ktx2' })).report.files[0].width, 32);
assert.deepEqual(Object.keys((await convert(texture, { name: 'a.ktx2', to: 'b.dds' })).files),
    ['b.dds']);
assert((await verify(bytes, files, { name })).report.levels.length > 1);
assert.match((await bake(bytes, { name, target: 'three', size: 32, explain: true })).text, /three/);

// In a thread of the caller's, too.
fs.writeFileSync('thread.mjs', `import { parentPort, workerData } from 'node:worker_threads';
    import { bake } from 'iblbake';
    parentPort.postMessage(Object.keys((await bake(workerData, { name: 'a.exr' })).files));`);
const inThread = new Worker('./thread.mjs', { workerData: bytes });
assert((await new Promise((resolve, reject) => inThread.on('message', resolve)
    .on('error', reject))).includes('a_specular.ktx2'));

await assert.rejects(verify(bytes, files, { name, maxError: 1e-9 }), error =>
    error.status === 1 && JSON.parse(error.text).levels.length > 1);
await assert.rejects(bake(bytes, { name, onProgress() { throw Error('mine'); } }), /mine/);
await refused(bake(bytes, { name, colour: 3 }), /^--colour: unknown option/);
await refused(bake(bytes, { name, size: 'large' }), /^--size large: /);
await refused(bake(new Uint8Array(9), { name }), /^forest.exr: is no image/);
await refused(bake(bytes.subarray(0, bytes.length / 2), { name }), /^forest.exr: EXR /);
assert.equal((await run(['--help'])).status, 0);
assert.equal((await run(['verify'])).status, 2);

const stop = new AbortController(), begun = performance.now();
setTimeout(() => stop.abort(), 200);
await assert.rejects(bake(bytes, { name, pixel: 'bc6h', quality: 'best', size: 2048,
    threads: 3, signal: stop.signal }), { name: 'AbortError' });
assert(performance.now() - begun < 10000);
await assert.rejects(bake(bytes, { signal: AbortSignal.abort() }), { name: 'AbortError' });

// SPDX-License-Identifier: MIT
/* node build.mjs OUT NODE_MODULES PACKAGE: fills the folder OUT with the page, which
 * is the files beside this one, what they import of three.js, and our package of npm. */
import {createHash} from 'node:crypto';
import {execFileSync} from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';

const [out, modules, baker] = process.argv.slice(2);
const here = import.meta.dirname ?? path.dirname(process.argv[1]);
const copy = (from, to) => fs.cpSync(from, path.join(out, to), {recursive: true});

fs.rmSync(out, {recursive: true, force: true});
copy(here, '.');
for (const name of ['forest.exr', 'sky.exr', 'knot.glb'])
    copy(path.join(here, '../../../data', name), 'data/' + name);
for (const name of ['LICENSE', 'build/three.module.js', 'build/three.core.js',
    ...['controls/OrbitControls', 'libs/fflate.module', 'loaders/EXRLoader',
        'loaders/GLTFLoader', 'loaders/HDRLoader', 'utils/BufferGeometryUtils',
        'utils/SkeletonUtils'].map(file => `examples/jsm/${file}.js`)])
    copy(path.join(modules, 'three', name), 'three/' + name);
copy(baker, 'iblbake');
for (const name of ['build.mjs', 'iblbake/threads.wasm'])
    fs.rmSync(path.join(out, name));

/* The program's lines for the reflections of three.js, as a module. */
const [lines] = execFileSync(process.execPath, [
    path.join(baker, 'bin/iblbake.cjs'), '--target', 'three', '--explain'],
    {encoding: 'utf8'}).match(/^.. Reflections: [^]*^.. Reflections end\.$/m);
fs.writeFileSync(path.join(out, 'reflections.js'),
    `export default function(THREE) {\n${lines}\n}\n`);

/* What works without a network: all of it. */
const files = fs.readdirSync(out, {recursive: true}).sort().filter(name =>
    name !== 'sw.js' && fs.statSync(path.join(out, name)).isFile());
const hash = createHash('sha256'), worker = path.join(out, 'sw.js');
files.forEach(name => hash.update(fs.readFileSync(path.join(out, name))));
fs.writeFileSync(worker, fs.readFileSync(worker, 'utf8').replace('VERSION', hash.digest('hex'))
    .replace('/* FILES */', () => files.map(f => JSON.stringify(f)).join(',')));

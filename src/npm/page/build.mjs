// SPDX-License-Identifier: MIT
/*
 * node build.mjs OUT NODE_MODULES PACKAGE
 *
 * Fills the folder OUT with the page: the files beside this one, three.js with
 * what it imports from NODE_MODULES, and our package of npm. Browsers
 * find modules by path, in workers too, so that `three` is replaced in imports.
 */
import {createHash} from 'node:crypto';
import {execFileSync} from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import {fileURLToPath} from 'node:url';

const [out, modules, baker] = process.argv.slice(2);
const here = path.dirname(fileURLToPath(import.meta.url));
const three = path.join(modules, 'three');
const read = name => fs.readFileSync(name, 'utf8');
function write(name, bytes) {
    const to = path.join(out, name);
    fs.mkdirSync(path.dirname(to), {recursive: true});
    fs.writeFileSync(to, bytes);
}

fs.rmSync(out, {recursive: true, force: true});
for (const name of fs.readdirSync(here))
    if (name !== path.basename(process.argv[1]))
        write(name, fs.readFileSync(path.join(here, name)));
for (const name of ['forest.exr', 'sky.exr', 'knot.glb'])
    write('data/' + name,
        fs.readFileSync(path.join(here, '../../../data', name)));

/* A module of three.js and those that it imports. The renderer's core is
 * enough for all but the renderer. */
const done = new Set();
function take(name) {
    if (done.has(name))
        return;
    done.add(name);
    const from = path.relative(path.dirname(name), 'build/three.core.js');
    const text = read(path.join(three, name)).replace(
        /^((?:import|export)\b[^;'"]*from\s*|\} from |import )'([^']+)'/gm,
        (all, start, what) => {
            if (what === 'three')
                return `${start}'${from}'`;
            take(path.join(path.dirname(name), what));
            return all;
        });
    write('three/' + name, text);
}
const used = new Set();
for (const name of fs.readdirSync(here).filter(n => n.endsWith('.js')))
    for (const [, module] of read(path.join(here, name)).matchAll(
        /'\.\/three\/([^']+\.js)'/g))
        used.add(module);
used.forEach(take);
for (const name of ['basis', 'draco/gltf'].flatMap(dir =>
    fs.readdirSync(path.join(three, 'examples/jsm/libs', dir))
        .filter(file => /_(transcoder|decoder|wrapper)\.(js|wasm)$/.test(file))
        .map(file => `examples/jsm/libs/${dir}/${file}`)))
    write('three/' + name, fs.readFileSync(path.join(three, name)));
write('three/LICENSE', read(path.join(three, 'LICENSE')));

/* The baker, and its program of three.js' reflections as a module. */
fs.cpSync(baker, path.join(out, 'iblbake'), {recursive: true});
const [lines] = execFileSync(process.execPath, [
    path.join(baker, 'bin/iblbake.cjs'), '--target', 'three', '--explain'],
    {encoding: 'utf8'}).match(/^.. Reflections: [^]*^.. Reflections end\.$/m);
write('reflections.js', `export default function(THREE) {\n${lines}\n}\n`);

/* What works without a network: all of it. */
const files = fs.readdirSync(out, {recursive: true}).map(String)
    .filter(name => name !== 'sw.js' && fs.statSync(path.join(out, name)).isFile())
    .sort();
const hash = createHash('sha256');
files.forEach(name => hash.update(name).update(
    fs.readFileSync(path.join(out, name))));
write('sw.js', read(path.join(out, 'sw.js'))
    .replace('/* FILES */', () => files.map(f => JSON.stringify(f)).join(','))
    .replace('VERSION', hash.digest('hex').slice(0, 16)));

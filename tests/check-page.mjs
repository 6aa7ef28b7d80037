// SPDX-License-Identifier: MIT
/*
 * node tests/check-page.mjs PAGE NPM NATIVE CHROMIUM [SHOTS]
 *
 * Uses the page in the folder PAGE as people do; tests/check-page.sh calls it.
 * NATIVE: what the native program makes of data/forest.exr turned by 40 degrees.
 */
import fs from 'node:fs';
import {createServer} from 'node:http';
import {createRequire} from 'node:module';
import path from 'node:path';

const [root, npm, native, chromium, shots] = process.argv.slice(2);
const {chromium: browser} = createRequire(
    path.resolve(npm, 'node_modules/x.js'))('playwright-core');
const {unzipSync} = await import(path.resolve(root,
    'three/examples/jsm/libs/fflate.module.js'));
const LONG = 180000; // of a busy machine
let passed = 0, failed = 0;
async function test(name, work) {
    try {
        await work();
        passed++;
    } catch (e) {
        failed++;
        console.log(`FAILED: ${name}: ${e.message}`);
    }
}
function check(good, what) {
    if (!good)
        throw Error(what);
}

/* ---- a host of static files ------------------------------------------------ */

const TYPES = {'.js': 'text/javascript', '.mjs': 'text/javascript',
    '.css': 'text/css', '.html': 'text/html; charset=utf-8',
    '.wasm': 'application/wasm'};
const server = createServer((request, response) => {
    const name = decodeURIComponent(new URL(request.url, 'http://h').pathname);
    const file = path.join(root, name.endsWith('/') ? name + 'index.html' : name);
    const there = fs.existsSync(file);
    response.writeHead(there ? 200 : 404, {'content-type':
        TYPES[path.extname(file)] ?? 'application/octet-stream'});
    response.end(there ? fs.readFileSync(file) : '');
});
await new Promise(go => server.listen(0, '127.0.0.1', go));
const address = `http://127.0.0.1:${server.address().port}/`;

const chrome = await browser.launch({executablePath: chromium, args: [
    '--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader',
    '--enable-unsafe-swiftshader']});
/* A page that is ready; what goes wrong there is kept. */
async function visit(width, height, before = () => {}) {
    const context = await chrome.newContext({viewport: {width, height}});
    await context.addInitScript(before);
    const page = await context.newPage(), wrong = [];
    page.setDefaultTimeout(LONG);
    page.on('pageerror', e => wrong.push(e.message));
    page.on('requestfailed', r => wrong.push(r.url()));
    page.on('request', r => r.url().startsWith(address) ||
        /^(data|blob):/.test(r.url()) || wrong.push('asks for ' + r.url()));
    await page.goto(address);
    await page.waitForSelector('body[data-ready]');
    return {context, page, wrong};
}
async function drop(page, name, bytes) {
    const transfer = await page.evaluateHandle(([n, text]) => {
        const t = new DataTransfer();
        t.items.add(new File([Uint8Array.from(atob(text),
            c => c.charCodeAt(0))], n));
        return t;
    }, [name, Buffer.from(bytes).toString('base64')]);
    await page.dispatchEvent('#stage', 'drop', {dataTransfer: transfer});
}
const forest = fs.readFileSync('data/forest.exr');
const done = page => page.waitForSelector('#download:enabled');
const shot = (page, name) => shots && page.screenshot({
    path: path.join(shots, name + '.png')});
async function baked(page) {
    await page.waitForFunction(() =>
        performance.getEntriesByName('picture').length);
    await done(page);
}
async function judged(page) {
    const text = await page.waitForFunction(() =>
        document.querySelector('#shown').textContent.includes('loads') &&
        document.querySelector('#own').textContent &&
        document.body.dataset.judged);
    return JSON.parse(await text.jsonValue());
}
async function zip(page) {
    const [download] = await Promise.all([page.waitForEvent('download'),
        page.click('#download')]);
    return [download.suggestedFilename(),
        unzipSync(fs.readFileSync(await download.path()))];
}

const {context, page, wrong} = await visit(1440, 900);
await test('a dropped map is baked and shown', async () => {
    await drop(page, 'forest.exr', forest);
    await baked(page);
    const [first] = await page.evaluate(() =>
        performance.getEntriesByName('picture').map(p => p.duration));
    await judged(page);
    await drop(page, 'forest.exr', forest);
    await page.waitForFunction(() =>
        performance.getEntriesByName('picture').length > 1);
    await judged(page);
    const later = await page.evaluate(() =>
        performance.getEntriesByName('picture')[1].duration);
    console.log(`picture after ${(first / 1000).toFixed(2)}, ` +
        `${(later / 1000).toFixed(2)} s`);
});
await test('it is compared with the exact integral', async () => {
    for (const [row, column] of [[0, 2], [1, 1], [0, 3]]) {
        await page.evaluate(() => delete document.body.dataset.judged);
        await page.check(`[name=row][value="${row}"]`, {force: true});
        await page.check(`[name=column][value="${column}"]`, {force: true});
        const {off: [own, theirs]} = await judged(page);
        check(own > 0.001 && own < 0.1 && own < theirs,
            `sphere ${row} ${column}: ${own}, three.js: ${theirs}`);
    }
    await shot(page, 'desktop');
});
await test('rotation and target are those of the command line', async () => {
    await page.fill('[name=rotate]', '40');
    await page.selectOption('[name=target]', '');
    await page.fill('[name=more]', '--only specular,json');
    await page.press('[name=more]', 'Enter');
    await page.waitForTimeout(400);
    await done(page);
    const said = await page.textContent('#command');
    check(said === 'iblbake --rotate 40 --only specular,json forest.exr -o out',
        said);
});
await test('the zip has what the native program makes', async () => {
    const [name, files] = await zip(page);
    check(name === 'forest.zip', name);
    for (const file of fs.readdirSync(native))
        check(files[file], `${file} is not in it`);
    const [a, b] = [files['forest_specular.ktx2'],
        fs.readFileSync(path.join(native, 'forest_specular.ktx2'))]
        .map(bytes => new DataView(bytes.buffer, bytes.byteOffset,
                                   bytes.byteLength));
    check(a.byteLength === b.byteLength, `${a.byteLength} bytes, not ${b.byteLength}`);
    const command = new TextDecoder().decode(files['command.txt']);
    check(/^iblbake --rotate 40 /.test(command), command);
    const choices = await page.textContent('#choices');
    check(/--rotate 40.* kB in [\d.]+ s\n/.test(choices), choices);
    const at = Number(b.getBigUint64(80 + 24 * (b.getUint32(40, true) - 1), true));
    for (let i = at; i < a.byteLength; i += 2)
        check(Math.abs(a.getUint16(i, true) - b.getUint16(i, true)) <= 1,
            `a half at ${i} is off by more than a step`);
});
await test('pictures, as converters make them', async () => {
    await page.fill('[name=more]', '');
    await page.selectOption('[name=only]', 'skybox');
    await page.selectOption('[name=layout]', 'cross');
    await page.selectOption('[name=size]', '64');
    await page.selectOption('[name=format]', 'png');
    await page.waitForTimeout(400);
    await done(page);
    const [, files] = await zip(page), png = files['forest_skybox.png'];
    check(png && png[1] === 0x50, `not in ${Object.keys(files)}`);
    check(new DataView(png.buffer, png.byteOffset).getUint32(16) === 256,
        'is not 256 wide');
});
await test('faces and levels, as HDR and EXR', async () => {
    for (const [format, ends] of [['hdr', '_0_px.hdr'], ['exr', '_2_nz.exr']]) {
        await page.selectOption('[name=only]', 'specular,irradiance');
        await page.selectOption('[name=layout]', 'cube');
        await page.selectOption('[name=format]', format);
        await page.waitForTimeout(400);
        await done(page);
        const names = Object.keys((await zip(page))[1]);
        check(names.some(name => name.endsWith(ends)), `no ${ends} in ${names}`);
    }
});
/* Of the left half, where spheres and models are. */
const seen = async () => {
    await page.evaluate(() => new Promise(go => requestAnimationFrame(() =>
        requestAnimationFrame(go))));
    return (await (await page.$('#view')).screenshot()).toString('base64');
};
await test('a dropped model, exposure and background are seen', async () => {
    const pictures = [await seen()], differs = async what => {
        pictures.push(await seen());
        check(new Set(pictures).size === pictures.length, `${what} changes nothing`);
    };
    await drop(page, 'knot.glb', fs.readFileSync('data/knot.glb'));
    for (let i = 0; i < 600 && await seen() === pictures[0]; i++)
        await page.waitForTimeout(100);
    await differs('a model');
    await shot(page, 'model');
    await page.fill('[name=exposure]', '2');
    await differs('exposure');
    await page.selectOption('[name=background]', 'none');
    await differs('background');
    await page.click('#balls');
    await differs('#balls');
});
await test('what is stopped leaves the files from before', async () => {
    await page.selectOption('[name=format]', 'ktx2');
    await page.fill('[name=more]', '--pixel bc6h --quality best --zstd 19 --size 2048');
    await page.press('[name=more]', 'Enter');
    await page.waitForSelector('body.busy');
    await page.click('#stop');
    await done(page);
    const before = Object.keys((await zip(page))[1]);
    check(before.some(name => name.endsWith('.exr')), `files are ${before}`);
    await page.fill('[name=more]', '--zstd 19');
    await drop(page, 'again.exr', forest);
    await page.waitForFunction(() => document.querySelector('#command').textContent
        .includes('--zstd 19 again.exr'));
    check(await page.isHidden('#said'), await page.innerText('#said'));
});
await test('a damaged map is one line, and the page goes on', async () => {
    await drop(page, 'bad.exr', forest.subarray(0, 5000));
    await page.waitForSelector('#said:not([hidden])');
    const said = await page.innerText('#said');
    check(/bad\.exr/.test(said) && !said.includes('\n'), said);
    await page.click('[id="sky.exr"]');
    await page.waitForFunction(() => document.querySelector('#said').hidden);
    await done(page);
});
await test('nothing went wrong, and nothing else was asked for', () =>
    check(!wrong.length, wrong.join('; ')));
await test('without a network', async () => {
    await page.evaluate(() => navigator.serviceWorker.ready);
    await context.setOffline(true);
    await page.reload();
    await page.waitForSelector('body[data-ready]');
    await page.click('[id="forest.exr"]');
    await baked(page);
    await judged(page);
    await context.close();
});
await test('by keys alone, on a phone', async () => {
    const {page, context, wrong} = await visit(390, 844);
    const press = async (until, key = 'Tab') => {
        for (let i = 0; i < 60; i++) {
            await page.keyboard.press(key);
            const at = await page.evaluate(() => [document.activeElement.id,
                document.activeElement.name]);
            if (at.includes(until))
                return page.evaluate(() => {
                    const e = document.activeElement;
                    const seen = e.type === 'radio' ? e.nextElementSibling : e;
                    return getComputedStyle(seen).outlineStyle;
                });
        }
        throw Error(`no way to ${until}`);
    };
    check(await press('forest.exr') === 'solid', 'focus is not to be seen');
    await page.keyboard.press('Enter');
    await baked(page);
    check(await press('row') === 'solid', 'focus of a sphere');
    await page.keyboard.press('ArrowRight');
    for (const name of ['target', 'rotate', 'model', 'download'])
        check(await press(name) === 'solid', `focus of ${name}`);
    const names = await page.$$eval('button, select, input', all => all.filter(e =>
        e.type !== 'file' && !e.textContent && !e.labels?.[0]?.textContent)
        .map(e => e.outerHTML));
    check(!names.length, `without a name: ${names}`);
    const wide = await page.evaluate(() => document.body.scrollWidth);
    check(wide <= 390, `${wide} pixels wide`);
    await judged(page);
    await page.evaluate(() => scrollTo(0, 0));
    await shot(page, 'phone');
    check(!wrong.length, wrong.join('; '));
    await context.close();
});
await test('without WebGL it says so, and packs', async () => {
    const {page, context} = await visit(1440, 900, () =>
        HTMLCanvasElement.prototype.getContext = () => null);
    check(/WebGL/.test(await page.innerText('#said')), `it says: ${await page.innerText('#said')}`);
    await page.click('[id="sky.exr"]');
    await done(page);
    const names = Object.keys((await zip(page))[1]);
    check(names.includes('sky_specular.ktx2'), `no set in ${names}`);
    await context.close();
});
await chrome.close();
server.close();
console.log(`${passed} passed, ${failed} failed, 0 skipped`);
process.exit(failed ? 1 : 0);

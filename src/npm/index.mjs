// SPDX-License-Identifier: MIT
// iblbake as functions; index.d.ts says what they take and give.

const node = Boolean(globalThis.process?.versions?.node);
const wasm = new URL('./iblbake.wasm', import.meta.url);

let compiled;
async function compile() {
    const bytes = node
        ? await (await import(/* webpackIgnore: true */ 'node:fs/promises')).readFile(wasm)
        : await fetch(wasm).then(r => r.ok ? r.arrayBuffer()
            : Promise.reject(new Error(`${wasm}: ${r.status} ${r.statusText}`)));
    return WebAssembly.compile(bytes);
}

// A thread for a run: one that rests, or a new one.
const resting = [];
async function thread() {
    if (resting.length) return resting.pop();
    if (!node) return new Worker(new URL('./worker.mjs', import.meta.url), { type: 'module' });
    const { Worker: Thread } = await import(/* webpackIgnore: true */ 'node:worker_threads');
    const t = new Thread(new URL('./worker.mjs', import.meta.url));
    t.on('message', data => t.onmessage({ data }));
    t.on('error', error => t.onerror(error));
    return t;
}

// Runs the command line `args` on files in memory, { NAME: bytes }. Resolves to
// { status, files, stdout, stderr }: the files are those that it made.
export async function run(args, files = {}, { onProgress, signal } = {}) {
    signal?.throwIfAborted();
    compiled ??= compile();
    compiled.catch(() => { compiled = undefined; });
    const [module, t] = await Promise.all([compiled, thread()]);
    let stop;
    try {
        const result = await new Promise((resolve, reject) => {
            stop = () => reject(signal.reason);
            signal?.addEventListener('abort', stop);
            if (signal?.aborted) stop();
            t.ref?.();
            t.onmessage = ({ data }) => 'done' in data ? onProgress?.(data.done) : resolve(data);
            t.onerror = event => reject(event.error ?? event);
            t.postMessage({ module, args, files });
        });
        t.unref?.();
        resting.push(t);
        return result;
    } catch (error) {
        t.terminate();
        throw error;
    } finally {
        signal?.removeEventListener('abort', stop);
    }
}

// { irradianceSize: 32, skybox: true, only: ['lut'] } as on a command line.
export function commandLine(options) {
    return Object.entries(options).flatMap(([key, value]) => {
        const name = '--' + key.replace(/[A-Z]/g, c => '-' + c.toLowerCase());
        if (value === true) return [name];
        if (value === undefined || value === null || value === false) return [];
        return [`${name}=${Array.isArray(value) ? value.join(',') : value}`];
    });
}

// The command on files that it is given, `operands` by name; options come first.
async function command(word, options, operands, files) {
    const { onProgress, signal, ...rest } = options;
    const result = await run([...word, ...commandLine(rest), '--', ...operands],
        files, { onProgress, signal });
    if (result.status) {
        const text = result.stderr.trim().replace(/^iblbake: /gm, '');
        throw Object.assign(new Error(text), { name: 'IblbakeError', status: result.status });
    }
    return { ...result, files: Object.fromEntries(Object.entries(result.files)
        .map(([name, bytes]) => [name.replace(/^out\//, ''), bytes])) };
}
const bytesOf = async data => data instanceof Uint8Array ? data
    : new Uint8Array(data instanceof ArrayBuffer ? data : await data.arrayBuffer());

export async function bake(bytes, { name = 'environment.hdr', ...options } = {}) {
    const { files, stdout, stderr } = await command(['--output=out'], options, [name],
        { [name]: await bytesOf(bytes) });
    const side = files[Object.keys(files).find(file => file.endsWith('.json'))];
    return { files, report: side ? JSON.parse(new TextDecoder().decode(side)) : null,
        log: stderr, text: stdout };
}

export async function verify(bytes, set, { name = 'environment.hdr', ...options } = {}) {
    const files = { [name]: await bytesOf(bytes) };
    for (const [file, data] of Object.entries(set)) files['out/' + file] = await bytesOf(data);
    const { stdout, stderr } = await command(['verify', '--json=-'], options,
        [name, 'out'], files);
    return { report: JSON.parse(stdout), log: stderr };
}

export async function info(bytes, { name = 'environment.hdr', ...options } = {}) {
    const { stdout, stderr } = await command(['info', '--json'], options, [name],
        { [name]: await bytesOf(bytes) });
    return { report: JSON.parse(stdout), log: stderr };
}

export async function convert(bytes, { name = 'texture.ktx2', to, ...options }) {
    const { files, stderr } = await command(['convert'], options, [name, 'out/' + to],
        { [name]: await bytesOf(bytes), 'out/.keep': new Uint8Array() });
    return { files, log: stderr };
}

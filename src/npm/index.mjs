// SPDX-License-Identifier: MIT
// iblbake as functions; index.d.ts says what they take and give.

const node = Boolean(globalThis.process?.versions?.node);
const wasm = new URL('./iblbake.wasm', import.meta.url), ENVIRONMENT = 'environment.hdr';

let compiled;
async function compile() {
    const bytes = node
        ? await (await import(/* webpackIgnore: true */ 'node:fs/promises'))
            .readFile(new URL('threads.wasm', wasm))
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
    const ready = compiled ??= compile();
    ready.catch(() => { compiled = undefined; });
    const used = []; // the run's thread, and those that it begins
    let stop, over = false;
    try {
        const result = await new Promise((resolve, reject) => {
            stop = () => reject(signal.reason);
            signal?.addEventListener('abort', stop);
            if (signal?.aborted) stop();
            const begin = async task => {
                const t = await used[used.push(thread()) - 1];
                t.ref?.();
                t.onmessage = ({ data }) => over || take(data).catch(reject);
                t.onerror = ({ message }) => reject(refusal(message, 1));
                t.postMessage(await task);
            };
            const take = async data => 'done' in data ? onProgress?.(data.done)
                : data.thread ? begin(data) : resolve(data);
            begin(ready.then(module => ({ module, args, files }))).catch(reject);
        });
        const t = await used.shift();
        t.unref?.();
        resting.length < 4 ? resting.push(t) : t.terminate();
        return result;
    } finally {
        over = true;
        signal?.removeEventListener('abort', stop);
        for (const t of used) t.then(t => t.terminate(), () => {});
    }
}

const refusal = (message, status, text = '') =>
    Object.assign(new Error(message), { name: 'IblbakeError', status, text });

// { irradianceSize: 32, skybox: true, only: ['lut'] } as on a command line.
const commandLine = options => Object.entries(options).flatMap(([key, value]) => {
    const name = '--' + key.replace(/[A-Z]/g, c => '-' + c.toLowerCase());
    if (value === true) return [name];
    return value === undefined || value === null || value === false ? [] : [`${name}=${value}`];
});

// A command on files that it is given, with those of `out`; options come first.
async function command(words, { onProgress, signal, ...options }, given, ...operands) {
    const files = {};
    for (const [name, data] of Object.entries(given))
        files[name] = data instanceof Uint8Array ? data
            : new Uint8Array(data instanceof ArrayBuffer ? data : await data.arrayBuffer());
    const made = await run([...words, ...commandLine(options), '--', ...operands], files,
        { onProgress, signal });
    if (made.status)
        throw refusal(made.stderr.trim().replace(/^iblbake: /gm, ''), made.status, made.stdout);
    return { files: Object.fromEntries(Object.entries(made.files).map(([name, bytes]) =>
        [name.replace(/^out\//, ''), bytes])), log: made.stderr, text: made.stdout };
}

export async function bake(bytes, { name = ENVIRONMENT, ...options } = {}) {
    const made = await command(['--output=out'], options, { [name]: bytes }, name);
    const side = Object.keys(made.files).find(file => file.endsWith('.json'));
    const report = side ? JSON.parse(new TextDecoder().decode(made.files[side])) : null;
    return { ...made, report };
}
export async function verify(bytes, set, { name = ENVIRONMENT, ...options } = {}) {
    const files = Object.entries(set).map(([file, data]) => ['out/' + file, data]);
    const { log, text } = await command(['verify', '--json=-'], options,
        { ...Object.fromEntries(files), [name]: bytes }, name, 'out');
    return { report: JSON.parse(text), log };
}
export async function info(bytes, { name = ENVIRONMENT, ...options } = {}) {
    const { log, text } = await command(['info', '--json'], options, { [name]: bytes }, name);
    return { report: JSON.parse(text), log };
}
export const convert = (bytes, { name = 'texture.ktx2', to, ...options }) =>
    command(['convert'], options, { [name]: bytes, 'out/.keep': new Uint8Array() }, name,
        'out/' + to);

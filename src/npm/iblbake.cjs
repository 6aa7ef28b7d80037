#!/usr/bin/env node
// SPDX-License-Identifier: MIT
// The command. The program runs in threads beside this one, so that signals reach it:
// it then removes what it has begun, or this one does, and the process dies of them.
const { Worker, isMainThread, parentPort, workerData } = require('node:worker_threads');
const fs = require('node:fs'), os = require('node:os'), path = require('node:path');
const system = import('../system.mjs');

async function work({ stop, thread }) {
    const { run } = await system;
    if (thread) return run(thread.module, [], { fs }, thread);
    // Few runs pay for the optimizer.
    require('node:v8').setFlagsFromString('--wasm-tiering-budget=100000000');
    const module = new WebAssembly.Module(fs.readFileSync(path.join(__dirname, '../threads.wasm')));
    const slashes = arg => process.platform === 'win32' ? arg.replaceAll('\\', '/') : arg;
    return run(module, ['iblbake', ...process.argv.slice(2).map(slashes)], {
        fs, process: process.pid, place: os.hostname(), isTerminal: require('node:tty').isatty,
        cwd: () => slashes(process.cwd()),
        isGone(pid) {
            try { return !process.kill(pid, 0); } catch (error) { return error.code === 'ESRCH'; }
        },
        // Each takes some 30 ms of a CPU to begin.
        cpus: Math.min(os.availableParallelism?.() ?? os.cpus().length, 8),
        spawn: thread => parentPort.postMessage({ thread }),
        last: last => parentPort.postMessage({ last }),
        interrupted: () => Atomics.load(stop, 0),
    });
}

function main() {
    const stop = new Int32Array(new SharedArrayBuffer(4));
    let last, left, how;
    const end = action => {
        if (how) return; // npm sends what a terminal sends, too
        how = action;
        Atomics.store(stop, 0, 1);
        setTimeout(() => first?.removeAllListeners('exit').terminate(), 300);
        setTimeout(() => Promise.resolve(last && work({ thread: last })).finally(how), 400);
    };
    const begin = (data, advice) => {
        const fail = error => {
            how || fs.writeSync(2, `iblbake: ${error.message}${advice}\n`);
            end(() => process.exit(1));
        };
        try {
            return new Worker(__filename, { argv: process.argv.slice(2), workerData: data })
                .on('error', fail);
        } catch (error) { fail(error); }
    };
    const first = begin({ stop }, '')?.on('exit', () => left && how?.());
    first?.on('message', message => {
        last ??= message.last;
        left = 'status' in message;
        if (message.thread) begin(message, ': fewer threads (-j) may do')?.unref();
        else process.exitCode = message.status;
    });
    for (const signal of ['SIGINT', 'SIGTERM', 'SIGHUP'])
        process.on(signal, () => end(() => {
            process.removeAllListeners(signal);
            process.kill(process.pid, signal);
        }));
}

if (isMainThread) main();
else work(workerData).then(status => parentPort.postMessage({ status }));

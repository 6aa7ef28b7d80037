#!/usr/bin/env node
// SPDX-License-Identifier: MIT
// The command. The program runs in threads beside this one, so that signals
// reach it: it then removes what it has begun, and the process dies of them.
const { Worker, isMainThread, parentPort, workerData } = require('node:worker_threads');
const fs = require('node:fs'), os = require('node:os'), path = require('node:path');

async function work({ stop, thread }) {
    const { run } = await import('../system.mjs');
    if (thread) return run(thread.module, [], {}, thread);
    // Few runs pay for the optimizer.
    require('node:v8').setFlagsFromString('--wasm-tiering-budget=100000000');
    const module = new WebAssembly.Module(fs.readFileSync(path.join(__dirname, '../threads.wasm')));
    const slashes = arg => process.platform === 'win32' ? arg.replaceAll('\\', '/') : arg;
    // No call waits for another program, so that signals are looked at meanwhile.
    const { isatty } = require('node:tty'), { O_RDONLY, O_NONBLOCK } = fs.constants;
    const open = (file, how) => fs.openSync(file, how === 'r' ? O_RDONLY | O_NONBLOCK : how);
    let input = 0;
    try {
        if (isatty(0) || fs.fstatSync(0).isFIFO()) input = open('/dev/stdin', 'r');
    } catch { /* there is none */ }
    return run(module, ['iblbake', ...process.argv.slice(2).map(slashes)], {
        fs: { ...fs, openSync: open,
            readSync: (fd, ...rest) => fs.readSync(fd || input, ...rest) },
        process: process.pid, place: os.hostname(), isTerminal: isatty,
        cwd: () => slashes(process.cwd()),
        isGone(pid) {
            try { return !process.kill(pid, 0); } catch (error) { return error.code === 'ESRCH'; }
        },
        interrupted: () => Atomics.load(stop, 0) && 128,
        // Each takes some 30 ms of a CPU to begin.
        cpus: Math.min(os.availableParallelism?.() ?? os.cpus().length, 8),
        spawn: thread => parentPort.postMessage({ thread }),
    });
}

function main() {
    const stop = new Int32Array(new SharedArrayBuffer(4));
    const begin = data => new Worker(__filename, { argv: process.argv.slice(2), workerData: data })
        .on('error', error => {
            fs.writeSync(2, `iblbake: ${error.message}\n`);
            process.exit(1);
        });
    const worker = begin({ stop });
    let died;
    worker.on('message', ({ thread, status }) => {
        thread ? begin({ thread }).unref() : process.exitCode = status;
    });
    const die = () => process.removeAllListeners(died) && process.kill(process.pid, died);
    worker.on('exit', () => died && die());
    // npm sends what a terminal sends, too: the second one changes nothing.
    for (const signal of ['SIGINT', 'SIGTERM', 'SIGHUP'])
        process.on(signal, () => {
            died ??= signal;
            Atomics.store(stop, 0, 1);
            setTimeout(die, 10000);
        });
}

if (isMainThread) main();
else work(workerData).then(status => parentPort.postMessage({ status }));

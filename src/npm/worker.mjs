// SPDX-License-Identifier: MIT
// A thread of index.mjs, in node and in browsers: runs a program for a message, or a
// thread of one.
import { run } from './system.mjs';
import { memory } from './memory.mjs';

const node = globalThis.process?.versions?.node;
const port = node ? (await import(/* webpackIgnore: true */ 'node:worker_threads')).parentPort
    : globalThis;

port.onmessage = ({ data: { module, args, files, thread } }) => {
    if (thread) return run(thread.module, [], {}, thread);
    const said = ['', '', ''], decoders = said.map(() => new TextDecoder());
    const fs = memory(files, (fd, bytes) => {
        said[fd] += decoders[fd].decode(bytes, { stream: true });
    });
    try {
        const status = run(module, ['iblbake', ...args], {
            fs, isTerminal: () => false, process: 1, isGone: () => false, place: '',
            cwd: () => '/', progress: done => port.postMessage({ done }),
            spawn: thread => port.postMessage({ thread }),
        });
        const made = fs.made();
        port.postMessage({ status, files: made, stdout: said[1], stderr: said[2] },
            Object.values(made).map(bytes => bytes.buffer));
    } catch (error) { // as when there is no memory
        port.postMessage({ status: 1, files: {}, stdout: '', stderr: `iblbake: ${error.message}` });
    }
};

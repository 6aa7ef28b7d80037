// SPDX-License-Identifier: MIT
// The system of the program: runs an instance of it on the functions of node's
// fs, or on those of memory.mjs, which have the same names.

// errno of the C library that the program is linked with, by names of node.
const ERRNO = {
    EACCES: 2, EAGAIN: 6, EBADF: 8, EBUSY: 10, EDQUOT: 19, EEXIST: 20, EFBIG: 22,
    EINVAL: 28, EIO: 29, EISDIR: 31, ELOOP: 32, EMFILE: 33, ENAMETOOLONG: 37,
    ENOENT: 44, ENOSPC: 51, ENOSYS: 52, ENOTDIR: 54, ENOTEMPTY: 55, EPERM: 63,
    EPIPE: 64, EROFS: 69, ESPIPE: 70, EXDEV: 75,
};
const O_WRITE = 1, O_EXCLUSIVE = 0o200, O_FOLDER = 0o200000;
const TERMINAL = 2, FOLDER = 3, FILE = 4, big = { bigint: true };
const STACK = 44; // in the C library's struct of a thread

// Runs `module` with arguments; returns its exit status.
//   fs, cwd, isTerminal       as of node
//   process, isGone, place, cpus   see port.h
//   spawn                     is given what another thread is to run as `thread`
//   interrupted               asked now and then: whether to remove what was begun, and end
//   last                      is given what removes it, as `thread`, when this one cannot
//   progress                  is told the share that is done
export function run(module, args, host, thread) {
    const { fs } = host;
    const files = new Map([0, 1, 2].map(fd => [fd, { fd, at: 0, pipe: true }]));
    const encoder = new TextEncoder(), decoder = new TextDecoder();
    let exports, memory, view, bytes, leaving = 0, left = 63, kept = 0;

    const look = () => { // the memory moves when it grows
        if (bytes?.buffer !== memory.buffer) {
            bytes = new Uint8Array(memory.buffer);
            view = new DataView(memory.buffer);
        }
        if (host.interrupted?.()) leave(128);
    };
    const leave = status => { // removes what was begun, through this host
        if (leaving) return;
        leaving = true;
        leaving = exports.leave();
        if (leaving) throw { status };
    };
    const text = at => decoder.decode(bytes.slice(at, bytes.indexOf(0, at)));
    const put = (at, string, room) => {
        const coded = encoder.encode(string).subarray(0, room - 1);
        bytes.set(coded, at);
        bytes[at + coded.length] = 0;
        return coded.length;
    };
    const guard = (call, sign) => (...given) => {
        look();
        try {
            return call(...given) ?? 0;
        } catch (error) {
            if (!error.code) throw error;
            return sign * (ERRNO[error.code] ?? ERRNO.EIO);
        }
    };
    const file = fd => files.get(fd) ?? fail('EBADF');
    const fail = code => { throw Object.assign(new Error(code), { code }); };

    // Bytes that a call moved, of all pieces of memory that it was given.
    const each = (pieces, count, result, move) => {
        let all = 0;
        for (let i = 0; i < count; i++) {
            const at = view.getUint32(pieces + 8 * i, true);
            const size = view.getUint32(pieces + 8 * i + 4, true);
            const n = size && move(bytes.subarray(at, at + size), all);
            all += n;
            if (n < size) break;
        }
        view.setUint32(result, all, true);
        return all;
    };
    const patiently = (f, call) => {
        for (;;) {
            try {
                return call();
            } catch (error) {
                if (error.code === 'EOF') return 0; // a pipe's, on Windows
                if (error.code === 'EPIPE' && f.fd < 3) leave(141);
                if (error.code === 'ESPIPE' && !f.pipe) f.pipe = true;
                else if (error.code !== 'EAGAIN') throw error;
                Atomics.wait(new Int32Array(new SharedArrayBuffer(4)), 0, 0, 5);
            }
        }
    };
    const read = (f, into, at) => patiently(f, () =>
        fs.readSync(f.fd, into, 0, into.length, f.pipe ? null : at));
    const write = (f, from) => {
        for (let done = 0; done < from.length;)
            done += patiently(f, () => fs.writeSync(f.fd, from, done, from.length - done));
        return from.length;
    };
    const stat = (at, s) => {
        bytes.fill(0, at, at + 88);
        view.setUint32(at, Number(s.dev & 0xffffffffn), true);
        view.setUint32(at + 12, Number(s.mode), true);
        view.setUint32(at + 16, Number(s.nlink), true);
        view.setBigInt64(at + 40, s.size, true);
        [s.atimeNs, s.mtimeNs, s.ctimeNs].forEach((t, i) => {
            view.setInt32(at + 56 + 8 * i, Number(t / 1000000000n), true);
            view.setInt32(at + 60 + 8 * i, Number(t % 1000000000n), true);
        });
        view.setBigUint64(at + 80, s.ino, true);
    };

    const system = {
        __syscall_stat64(path, at) { stat(at, fs.statSync(text(path), big)); },
        __syscall_lstat64(path, at) { stat(at, fs.lstatSync(text(path), big)); },
        __syscall_fstat64(fd, at) { stat(at, fs.fstatSync(file(fd).fd, big)); },
        __syscall_unlink(path) { fs.unlinkSync(text(path)); },
        __syscall_rmdir(path) { fs.rmdirSync(text(path)); },
        __syscall_mkdir(path) { fs.mkdirSync(text(path)); },
        __syscall_rename(from, to) { fs.renameSync(text(from), text(to)); },
        __syscall_faccessat(dir, path, how) { fs.accessSync(text(path), how); },
        __syscall_readlink(path, to, room) {
            const name = encoder.encode(fs.readlinkSync(text(path))).subarray(0, room);
            bytes.set(name, to);
            return name.length;
        },
        __syscall_getcwd(to, room) { return put(to, host.cwd(), room) + 1; },
        __syscall_getdents64(fd, to, room) {
            const f = file(fd), SIZE = 280;
            let used = 0;
            for (; f.at < f.names.length && used + SIZE <= room; f.at++, used += SIZE) {
                bytes.fill(0, to + used, to + used + SIZE);
                view.setBigUint64(to + used, 1n, true);
                view.setBigUint64(to + used + 8, BigInt(f.at + 1), true);
                view.setUint16(to + used + 16, SIZE, true);
                put(to + used + 19, f.names[f.at], 256);
            }
            return used;
        },
        args_sizes_get(count, size) {
            view.setUint32(count, args.length, true);
            view.setUint32(size, args.reduce((n, a) => n + encoder.encode(a).length + 1, 0), true);
        },
        args_get(list, at) {
            args.forEach((arg, i) => {
                view.setUint32(list + 4 * i, at, true);
                at += put(at, arg, Infinity) + 1;
            });
        },
        clock_time_get(clock, precision, at) {
            const ms = performance.timeOrigin + performance.now();
            view.setBigUint64(at, BigInt(Math.round(ms * 1e6)), true);
        },
        fd_read(fd, pieces, count, got) {
            const f = file(fd);
            f.at += each(pieces, count, got, (to, n) => read(f, to, f.at + n));
        },
        fd_pread(fd, pieces, count, at, got) {
            each(pieces, count, got, (to, n) => read(file(fd), to, Number(at) + n));
        },
        fd_write(fd, pieces, count, got) {
            each(pieces, count, got, from => write(file(fd), from));
        },
        fd_seek(fd, offset, whence, result) {
            const f = file(fd);
            if (fd < 3) fail('ESPIPE');
            f.at = Number(offset) + (whence === 0 ? 0 : whence === 1 ? f.at
                : f.names ? 0 : Number(fs.fstatSync(f.fd).size));
            view.setBigInt64(result, BigInt(f.at), true);
        },
        fd_sync(fd) { fs.fsyncSync(file(fd).fd); },
        fd_close(fd) {
            const f = file(fd);
            files.delete(fd);
            if (fd > 2 && !f.names) fs.closeSync(f.fd);
        },
        fd_fdstat_get(fd, at) {
            bytes.fill(0, at, at + 24);
            bytes[at] = file(fd).names ? FOLDER : host.isTerminal(fd) ? TERMINAL : FILE;
        },
        proc_exit(status) { throw thread ? Error('aborted') : { status }; },
        setTempRet0(value) { kept = value; },
        getTempRet0: () => kept,
        __emscripten_init_main_thread_js(at) {
            enter(at, 1);
            const size = 1 << 16, last = exports.malloc(size); // a thread and its stack
            bytes.fill(0, last, last + size);
            view.setUint32(last + STACK, last + size, true);
            host.last?.({ module, memory, at: last });
        },
        _emscripten_default_pthread_stack_size: () => 1 << 20,
        __pthread_create_js(at, attributes, start, given) {
            if (!host.spawn || !left) fail('EAGAIN');
            left--;
            host.spawn({ module, memory, at, start, given });
        },
        __emscripten_thread_cleanup(at) { // after it was joined
            left++;
            exports._emscripten_thread_free_data(at);
        },
    };
    const iblbake = {
        open: guard((path, flags) => {
            path = text(path);
            let fd = 3;
            while (files.has(fd)) fd++;
            files.set(fd, flags & O_FOLDER ? { at: 0, names: ['.', '..', ...fs.readdirSync(path)] }
                : { at: 0, fd: fs.openSync(path, !(flags & O_WRITE) ? 'r'
                    : flags & O_EXCLUSIVE ? 'wx' : 'w') });
            return fd;
        }, -1),
        process: () => host.process,
        is_gone: process => host.isGone(process) ? 1 : 0,
        cpus: () => host.cpus ?? 1,
        place: (at, room) => { look(); put(at, host.place, room); },
        progress: done => { look(); host.progress?.(done); },
    };
    const enter = (at, main) => {
        exports._emscripten_thread_init(at, 0, main, 1, 0);
        if (!main) exports.stackRestore(view.getUint32(at + STACK, true));
        exports.emscripten_tls_init();
    };
    // Functions that libraries longjmp out of are called by `invoke`.
    const longjmp = () => { throw longjmp; };
    const invoke = (index, ...given) => {
        const stack = exports.stackSave();
        try {
            return exports.__indirect_function_table.get(index)(...given);
        } catch (error) {
            exports.stackRestore(stack);
            if (error !== longjmp) throw error;
            exports.setThrew(1, 0);
        }
    };

    const imports = { env: {}, wasi_snapshot_preview1: {}, iblbake };
    for (const { module: from, name, kind } of WebAssembly.Module.imports(module)) {
        if (kind === 'memory')
            memory = imports.env[name] = thread?.memory
                ?? new WebAssembly.Memory({ initial: 1024, maximum: 65536, shared: true });
        const call = guard(system[name] ?? (() => fail('ENOSYS')), from === 'env' ? -1 : 1);
        imports[from][name] ??= name.startsWith('invoke_') ? invoke
            : name === '_emscripten_throw_longjmp' ? longjmp : call;
    }
    exports = new WebAssembly.Instance(module, imports).exports;
    memory ??= exports.memory;
    try {
        if (!thread) return exports._start() ?? 0;
        look();
        enter(thread.at, 0);
        if (!thread.start) return exports.leave();
        const begin = exports.__indirect_function_table.get(thread.start);
        exports._emscripten_thread_exit(begin(thread.given));
        return 0;
    } catch (error) {
        if (error.status === undefined) throw error;
        return error.status;
    }
}

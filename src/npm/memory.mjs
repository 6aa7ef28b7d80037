// SPDX-License-Identifier: MIT
// Files in memory, behind the functions of node's fs that system.mjs calls.
// `files` maps names to their bytes; what is printed goes to print(fd, bytes).
export function memory(files, print = () => {}) {
    const folders = new Set(['']), open = new Map(), ids = new Map();
    let next = 3;

    const fail = code => { throw Object.assign(new Error(code), { code }); };
    const name = path => path.split('/').filter(p => p && p !== '.').join('/');
    const parent = path => path.slice(0, Math.max(path.lastIndexOf('/'), 0));
    const describe = path => {
        if (!ids.has(path)) ids.set(path, BigInt(ids.size + 1));
        return {
            dev: 1n, ino: ids.get(path), nlink: 1n, atimeNs: 0n, mtimeNs: 0n,
            ctimeNs: 0n, size: BigInt(files.get(path)?.length ?? 0),
            mode: files.has(path) ? 0o100644n : 0o40755n,
        };
    };
    const statSync = path => {
        const at = name(path);
        if (files.has(at) && /\/\.?$/.test(path)) fail('ENOTDIR');
        return files.has(at) || folders.has(at) ? describe(at) : fail('ENOENT');
    };
    for (const path of [...files.keys()])
        for (let at = parent(path); at; at = parent(at)) folders.add(at);

    return {
        statSync, lstatSync: statSync, accessSync: path => { statSync(path); },
        fstatSync(fd) {
            const f = open.get(fd);
            return f ? { ...describe(f.path), size: BigInt(f.size) }
                : { ...describe('/'), mode: 0o10600n };
        },
        openSync(path, how) {
            const at = name(path), there = files.get(at);
            if (folders.has(at) && how !== 'r') fail('EISDIR');
            if (!there && how === 'r' && !folders.has(at)) fail('ENOENT');
            if (there && how === 'wx') fail('EEXIST');
            if (!folders.has(parent(at))) fail('ENOENT');
            if (how !== 'r') files.set(at, new Uint8Array());
            open.set(next, { path: at, bytes: files.get(at), how, size: files.get(at)?.length ?? 0 });
            return next++;
        },
        readSync(fd, to, offset, length, at) {
            const f = open.get(fd);
            if (!f) return 0;
            if (!f.bytes) fail('EISDIR');
            const part = f.bytes.subarray(at, Math.min(at + length, f.size));
            to.set(part, offset);
            return part.length;
        },
        writeSync(fd, from, offset, length) {
            const f = open.get(fd), part = from.subarray(offset, offset + length);
            if (!f) {
                print(fd, part.slice());
                return length;
            }
            if (f.size + length > f.bytes.length) {
                const more = new Uint8Array(Math.max(f.size + length, 2 * f.bytes.length));
                more.set(f.bytes.subarray(0, f.size));
                f.bytes = more;
            }
            f.bytes.set(part, f.size);
            f.size += length;
            return length;
        },
        closeSync(fd) {
            const f = open.get(fd);
            open.delete(fd);
            if (f.how !== 'r' && files.has(f.path))
                files.set(f.path, f.bytes.subarray(0, f.size));
        },
        fsyncSync() {},
        unlinkSync(path) { files.delete(name(path)) || fail('ENOENT'); },
        renameSync(from, to) {
            const bytes = files.get(name(from)) ?? fail('ENOENT');
            files.set(name(to), bytes);
            files.delete(name(from));
        },
        mkdirSync(path) {
            const at = name(path);
            if (files.has(at) || folders.has(at)) fail('EEXIST');
            if (!folders.has(parent(at))) fail('ENOENT');
            folders.add(at);
        },
        rmdirSync(path) {
            if (this.readdirSync(path).length) fail('ENOTEMPTY');
            folders.delete(name(path));
        },
        readdirSync(path) {
            const at = name(path);
            if (!folders.has(at)) fail(files.has(at) ? 'ENOTDIR' : 'ENOENT');
            return [...folders, ...files.keys()]
                .filter(p => p && parent(p) === at).map(p => p.slice(at && at.length + 1));
        },
        readlinkSync() { fail('EINVAL'); },
    };
}

// SPDX-License-Identifier: MIT
// Files in memory, behind the functions of node's fs that system.mjs calls; an open
// file is the entry itself. `given` has bytes by name; what is printed goes to
// print(descriptor, bytes); made() gives the files that were written.
export function memory(given, print) {
    const all = new Map([['', { ino: 1n }]]); // folders have no bytes
    let count = 1n;
    const fail = code => { throw Object.assign(new Error(code), { code }); };
    const name = path => path.split('/').filter(p => p && p !== '.').join('/');
    const parent = at => at.slice(0, Math.max(at.lastIndexOf('/'), 0));
    const put = (at, more) => {
        if (!all.has(parent(at))) fail('ENOENT');
        const entry = { ino: ++count, ...more };
        all.set(at, entry);
        return entry;
    };
    const find = path => {
        const entry = all.get(name(path)) ?? fail('ENOENT');
        return entry.bytes && /\/\.?$/.test(path) ? fail('ENOTDIR') : entry;
    };
    const fstatSync = ({ ino, bytes, size = bytes?.length ?? 0 }) => ({
        dev: 1n, ino: ino ?? 0n, nlink: 1n, atimeNs: 0n, mtimeNs: 0n, ctimeNs: 0n,
        size: BigInt(size), mode: bytes ? 0o100644n : ino ? 0o40755n : 0o10600n,
    });
    const folder = at => all.get(at) ?? (folder(parent(at)), put(at));
    for (const [path, bytes] of Object.entries(given)) {
        folder(parent(name(path)));
        put(name(path), { bytes });
    }

    return {
        made: () => Object.fromEntries([...all].filter(([, entry]) => entry.parts)
            .map(([at, { bytes }]) => [at, bytes])),
        fstatSync, statSync: path => fstatSync(find(path)),
        lstatSync: path => fstatSync(find(path)), accessSync: find,
        openSync(path, how) {
            if (how === 'r') return find(path);
            const there = all.get(name(path));
            if (there && how === 'wx') fail('EEXIST');
            if (there && !there.bytes) fail('EISDIR');
            return put(name(path), { bytes: new Uint8Array(), parts: [], size: 0 });
        },
        readSync(entry, to, offset, length, at) {
            if (!entry) return 0; // standard input
            const part = (entry.bytes ?? fail('EISDIR')).subarray(at, at + length);
            to.set(part, offset);
            return part.length;
        },
        writeSync(entry, from, offset, length) {
            const part = from.slice(offset, offset + length);
            if (!entry.parts) print(entry, part);
            else entry.size += entry.parts.push(part) && length;
            return length;
        },
        closeSync(entry) {
            if (!entry.parts) return;
            let at = 0;
            entry.bytes = new Uint8Array(entry.size);
            for (const part of entry.parts) {
                entry.bytes.set(part, at);
                at += part.length;
            }
        },
        fsyncSync() {},
        unlinkSync(path) { all.delete(name(path)) || fail('ENOENT'); },
        renameSync(from, to) {
            all.set(name(to), find(from));
            all.delete(name(from));
        },
        mkdirSync(path) { all.has(name(path)) ? fail('EEXIST') : put(name(path)); },
        rmdirSync(path) {
            if (this.readdirSync(path).length) fail('ENOTEMPTY');
            all.delete(name(path));
        },
        readdirSync(path) {
            if (find(path).bytes) fail('ENOTDIR');
            return [...all.keys()].filter(at => at && parent(at) === name(path))
                .map(at => at.slice(at.lastIndexOf('/') + 1));
        },
        readlinkSync() { fail('EINVAL'); },
    };
}

// SPDX-License-Identifier: MIT
// coverage.mjs: reads what gcov says of each object (--json-format), and prints
// the share of lines that ran: of the library and the programs, by folder, and
// the files that are reached least. A line that is compiled for several
// instruction sets has run if it has in one.
import {createInterface} from 'node:readline';

const files = new Map();
for await (const line of createInterface({input: process.stdin})) {
    for (const file of JSON.parse(line).files) {
        if (!/^src\/|^include\//.test(file.file))
            continue;
        const lines = files.get(file.file) ?? new Map();
        files.set(file.file, lines);
        for (const {line_number: n, count} of file.lines)
            lines.set(n, Math.max(lines.get(n) ?? 0, count));
    }
}
const sums = new Map();
function add(name, ran, all)
{
    const sum = sums.get(name) ?? {ran: 0, all: 0};
    sums.set(name, {ran: sum.ran + ran, all: sum.all + all});
}
const row = ({ran, all}, name) =>
    `${(100 * ran / all).toFixed(1).padStart(6)} % of ${
        String(all).padStart(5)} lines  ${name}`;
const least = [];
for (const [file, lines] of files) {
    const all = lines.size, ran = [...lines.values()].filter(n => n > 0).length;
    add(file.replace(/\/[^/]*$/, ''), ran, all);
    add('in all', ran, all);
    least.push({file, ran, all});
}
least.sort((a, b) => b.all - b.ran - (a.all - a.ran));
for (const {file, ran, all} of least.slice(0, 20).reverse())
    console.log(row({ran, all}, file));
console.log();
for (const name of [...sums.keys()].sort())
    console.log(row(sums.get(name), name));

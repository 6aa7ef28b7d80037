// SPDX-License-Identifier: MIT
// random.mjs SEED COUNT: prints a table of mutants (tests/mutants/run.sh) for
// lines of src that are chosen at random, by the seed: another operator, another
// constant, the opposite condition, or a statement that is missing. More than
// COUNT, since some do not compile.
import {execFileSync} from 'node:child_process';
import {readdirSync, readFileSync} from 'node:fs';

const [seed, count] = process.argv.slice(2).map(Number);

// Marsaglia 2003, "Xorshift RNGs", page 4, with 32 bits.
let state = (seed * 2654435761 + 1) >>> 0;
function below(n)
{
    state ^= state << 13;
    state ^= state >>> 17;
    state ^= state << 5;
    return (state >>> 0) % n;
}

// Relations are negated: a bound that moves by one often changes nothing.
const operators = {
    ' < ': ' >= ', ' <= ': ' > ', ' > ': ' <= ', ' >= ': ' < ',
    ' == ': ' != ', ' != ': ' == ', ' && ': ' || ', ' || ': ' && ',
    ' + ': ' - ', ' - ': ' + ', ' * ': ' / ', ' / ': ' * ',
    ' += ': ' -= ', ' -= ': ' += ', '++': '--', '--': '++',
};

// All ways to break a line.
function waysOf(line)
{
    const ways = [], end = line.search(/\/[/*]/);
    const add = (at, length, text) => (end < 0 || at < end) && ways.push(
        line.slice(0, at) + text + line.slice(at + length));
    for (const [from, to] of Object.entries(operators))
        for (let at = line.indexOf(from); at >= 0;
             at = line.indexOf(from, at + 1))
            add(at, from.length, to);
    for (const m of line.matchAll(/(?<![\w.%])(\d+)(\.\d+)?(?![\w.])/g))
        if (line[m.index + m[0].length] !== ']' || !/[,)]$/.test(line))
            add(m.index, m[0].length, +m[0] && m[2] ? `${m[0]} * 2` :
                String(+m[1] + 1) + (m[2] ?? ''));
    const condition = line.match(/^(\s*(?:if|while) \()(.*)(\)(?: \{)?)$/);
    if (condition && !/=(?!=)/.test(condition[2].replace(/[<>!=]=/g, '')))
        ways.push(`${condition[1]}!(${condition[2]})${condition[3]}`);
    if (/^\s+(\w[\w>.[\]-]* [-+*/|&]?= |\w+\(|\w[\w>.[\]-]*\+\+|gl\.).*;$/
            .test(line))
        ways.push(`${line.match(/^\s*/)[0]};`);
    return ways;
}

// Lines of code, without comments, text, attributes, declarations of constants and
// of arrays.
function linesOf(file)
{
    const lines = readFileSync(file, 'utf8').split('\n');
    let comment = false, macro = false;
    const found = [];
    lines.forEach((line, i) => {
        const inside = comment || macro;
        comment = line.lastIndexOf('/*') > line.lastIndexOf('*/') ||
            (comment && !line.includes('*/'));
        macro = line.endsWith('\\');
        if (inside || comment ||
            /^\s*(#|\/\/|\/\*|\*|static const|enum)|__attribute__|"/.test(line) ||
            /^\s+(?!return)\w[\w ]*[ *]\w+\[[^=]*\](;| = \{)/.test(line))
            return;
        if (waysOf(line).length)
            found.push({file, lines, i});
    });
    return found;
}

// The tests that the tables name for other bugs of a file, or of its folder: they
// see most of what any test sees, and sooner. Then all quick tests, the script with
// the longest name of words of the file's path, and the first ones with a sanitizer,
// which also sees what is not freed.
const rows = readdirSync('tests/mutants').filter(f => f.endsWith('.txt'))
    .flatMap(f => readFileSync(`tests/mutants/${f}`, 'utf8').split(/\n\n+/))
    .map(row => ({file: row.match(/^[\w/.-]+\.\w+$/m)?.[0] ?? '',
                  tests: row.match(/(?<=^= ).*/m)?.[0].split(' ') ?? []}));
const scripts = readdirSync('tests').flatMap(f => f.match(/^check-(.*)\.sh$/)?.[1] ?? [])
    .sort((a, b) => a.length - b.length);
function testsOf(file)
{
    const folder = file.replace(/[^/]*$/, '');
    const of = rows.filter(r => r.file === file);
    const named = of.flatMap(r => r.tests);
    const tests = [...new Set((of.length ? of : rows.filter(r =>
        r.file.startsWith(folder))).flatMap(r => r.tests)
        .filter(t => t.startsWith('check_')).map(t => t.replace(/:.*/, '')))];
    const words = file.split(/\W|_/);
    const script = scripts.filter(name =>
        name.split('-').every(word => words.includes(word))).slice(-1);
    return tests.slice(0, 4).concat(
        [...new Set(named.filter(t => t.startsWith('check-')))], 'any',
        script.map(name => `check-${name}.sh`),
        tests.slice(0, 2).map(t => `asan/${t}`),
        /^src.(cli|common|io|json|set)/.test(file) ? 'asan/check-cli.sh' : []);
}

const all = execFileSync('git', ['ls-files', 'src'], {encoding: 'utf8'})
    .split('\n')
    .filter(f => /\.(c|h|cpp|frag|vert|glsl)$/.test(f) &&
        !/^src\/(port\/(windows|wasm|builtin)|io\/bridge\/openexr_core)/.test(f))
    .flatMap(linesOf);
const taken = new Set();
for (let n = 0; n < 1.3 * count;) {
    const at = below(all.length), {file, lines, i} = all[at];
    const ways = waysOf(lines[i]), way = ways[below(ways.length)];
    // As many lines before it as make it the only such place.
    let first = i;
    const text = () => lines.slice(first, i + 1).join('\n') + '\n';
    const whole = lines.join('\n');
    while (whole.split(text()).length > 2 && first > 0)
        first--;
    if (taken.has(at))
        continue;
    taken.add(at);
    n++;
    const before = lines.slice(first, i);
    console.log([`# line ${i + 1}`, file,
        ...[...before, lines[i]].map(l => `-${l}`),
        ...[...before, way].map(l => `+${l}`),
        `= ${testsOf(file).join(' ')}`, ''].join('\n'));
}

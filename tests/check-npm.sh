#!/bin/bash
# SPDX-License-Identifier: MIT
# The package of npm, as `make npm` packs it: installed into an empty folder, its
# command and its functions beside the program that was built for this machine.
set -u
. tests/lib.sh
need emcc clang node npm npx brotli
native=$build/iblbake
[ -x "$native" ] || { echo "$native: not built"; exit 1; }
packed npm
cd "$work" || exit 1
echo '{ "private": true, "type": "module" }' >package.json
log=$(npm install --silent --no-audit --no-fund --offline \
    "$build/npm/iblbake-$version.tgz" 2>&1) || { verdict install "$log"; end; exit; }
verdict install
package=$work/node_modules/iblbake
npm=$package/bin/iblbake.cjs

test_npx() {
    [[ $(npx iblbake --version) = "iblbake $version"* ]] || npx iblbake --version
    npx iblbake -q "$top/data/forest.exr" -o npx --size 16 2>&1
    there npx/forest_specular.ktx2 "$package/LICENSES-of-libraries.txt"
}

# Without locks, signals of all kinds, and users that may not write.
test_cases() {
    (cd "$top" && PROGRAM=$npm BUILD=$build bash tests/check-cli.sh) >cases 2>&1 ||
        grep FAILED cases
    grep -qE '^[1-9][0-9]+ passed' cases || tail -n 1 cases
}
export EXCEPT='odd names|unprivileged|ulimit|TIFF|oiiotool|-isa'

# Halves differ by one step at most, of few.
compare() { # FOLDER FOLDER
    local file
    for file in "$1"/*.ktx2; do
        node - "$file" "$2/${file##*/}" <<'END'
const fs = require('fs'), [a, b] = process.argv.slice(2).map(f => {
    const bytes = fs.readFileSync(f), at = Number(bytes.readBigUInt64LE(80));
    return new Uint16Array(bytes.buffer, bytes.byteOffset + (at & ~1));
});
const other = a.reduce((n, x, i) => n + (x !== b[i]), 0);
const far = a.reduce((n, x, i) => n + (Math.abs(x - b[i]) > 1), 0);
if (a.length !== b.length || far || other > 1e-4 * a.length + 4)
    console.log(process.argv[2], a.length, b.length, 'halves:', other, 'differ,', far, 'by more than a step');
END
    done
}
test_same_as_native() {
    local set
    for set in '' '--size 64 --mapping filament --lights 1 --skybox 64' '--lobe charlie'; do
        # shellcheck disable=SC2086
        "$native" --isa c -q "$top/data/sky.exr" -o native $set
        # shellcheck disable=SC2086
        "$npm" -q "$top/data/sky.exr" -o wasm $set
        compare native wasm
    done
}

# The first thread has the files.
test_threads() {
    local j
    for j in 1 3 40; do
        "$npm" -q -j $j "$top/data/sky.exr" -o $j --method sampled --samples 64 --zstd 3
        diff -r 1 $j
    done
    # Where the system has fewer, nothing is left.
    (ulimit -n 200; "$npm" -q -j 64 "$top/data/sky.exr" -o few 2>log)
    is 1 $? status
    has 'fewer threads (-j) may do' log
    absent few
}

test_compressions() {
    local kind
    have oiiotool || return
    for kind in none rle zip zips piz pxr24 b44 b44a; do
        oiiotool "$top/data/forest.exr" --resize 128x64 -d half --compression $kind -o $kind.exr
        "$native" --isa c -q $kind.exr -o native --size 16
        "$npm" -q $kind.exr -o wasm --size 16
        compare native wasm
    done
    oiiotool "$top/data/forest.exr" --compression dwaa -o dwaa.exr
    refused 1 'iblbake: dwaa.exr: is OpenEXR, DWA*this build does not read: save it*' \
        "$npm" dwaa.exr -o dwaa
    oiiotool "$top/data/forest.exr" -o tiff.tif
    refused 1 'iblbake: tiff.tif: is TIFF, which this build does not read: save it*' \
        "$npm" tiff.tif -o tiff
}

test_streams() {
    "$npm" - -q -o stdin --size 16 <"$top/data/forest.exr"
    "$npm" - -q -o piped --size 16 < <(cat "$top/data/forest.exr")
    cmp stdin/env_specular.ktx2 piped/env_specular.ktx2
    is '{' "$("$npm" info --json "$top/data/forest.exr" | head -c 1)"
    # It waits for who writes, and then ends by a signal.
    mkfifo fifo
    { sleep .3; cat "$top/data/forest.exr" >fifo; } &
    "$npm" fifo -q -o late --size 16
    cmp stdin/env_specular.ktx2 late/fifo_specular.ktx2
    exec 9<>fifo
    "$npm" - -o left <fifo 2>log &
    within test -d left || echo 'did not begin'
    kill -TERM $!
    wait $! 2>/dev/null
    is 143 $? status
    exec 9>&-
    absent left
}

test_batch() {
    mkdir maps
    cp "$top"/data/{forest,sky}.exr maps
    "$npm" maps -o batch --size 16 --incremental >log 2>&1
    has 'baked 2 maps' log
    "$npm" maps -o batch --size 16 --incremental >log 2>&1
    has 'kept 2' log
    "$native" -q --isa c maps -o native-batch --size 16
    compare native-batch batch
    "$npm" -q --from <(printf '%s\n' maps/*) -o listed --size 16
    diff -r batch listed | grep -v '^Only in batch: .iblbake$'
}

test_interrupted() {
    local status signal
    for signal in INT TERM; do
        mkdir "$signal"
        (cd "$signal" && interrupt "$signal" "$npm" -q "$top/data/sky.exr" --size 2048 \
            --pixel bc6h --quality best --zstd 22 -o left/made; echo "$status" >../status)
        [ "$(<status)" -gt 128 ] || echo "$signal: status $(<status)"
        find "$signal" -mindepth 1
    done
}

test_sizes() { # the bars of issue 44
    local wasm threads glue
    wasm=$(brotli -c -q 11 -w 24 "$package/iblbake.wasm" | wc -c)
    threads=$(brotli -c -q 11 -w 24 "$package/threads.wasm" | wc -c)
    glue=$(cat "$package"/*.mjs | gzip -9 | wc -c)
    [ "$wasm" -le 620000 ] && [ "$threads" -le 620000 ] && [ "$glue" -le 30000 ] ||
        echo "found $wasm, $threads and $glue bytes, wanted 620000 and 30000 at most"
}

test_functions() {
    cp "$top/tests/npm.mjs" .
    node npm.mjs "$top/data/forest.exr" "$native" 2>&1
    tsc --version >/dev/null 2>&1 || return 0
    tsc --noEmit --lib es2022,dom "$package/index.d.ts"
}

for t in $(compgen -A function test_); do
    picked "$t" || continue
    verdict "$t" "$($t 2>&1 | head -n 12)"
    cd "$work" || exit 1
done
end

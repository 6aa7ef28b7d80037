#!/bin/bash
# SPDX-License-Identifier: MIT
# The page of `make page` in Chromium with software GL, by playwright: a map is
# dropped, baked, compared and packed, a damaged one refused; without a network,
# by keys alone, and on a phone. BUILD: where it was built. SHOTS: a folder for
# pictures of it. The last line is "N passed, N failed, N skipped".
set -u
. tests/lib.sh

need node npm chromium emcc clang
log=$(${MAKE:-make} -s DEPS=no BUILD="$build" page 2>&1) || {
    [[ $log != *'npm error'* ]] || skip_all 'npm cannot fetch three.js'
    [[ $log != *'libraries: no source'* ]] || skip_all "${log##*libraries: }"
    verdict 'make page' "$log"
    end
    exit
}
# Fetched once; it drives Debian's browser.
driver=playwright-core@1.65.1
npm=$build/npm-driver
if [ "$(cat "$npm/fetched" 2>/dev/null)" != "$driver" ]; then
    npm install --no-save --no-package-lock --no-audit --no-fund \
        --ignore-scripts --loglevel=error --prefix "$npm" $driver ||
        skip_all 'npm cannot fetch playwright'
    echo "$driver" >"$npm/fetched"
fi
"$build/iblbake" -q data/forest.exr --rotate 40 --only specular,json \
    -o "$work/native" || exit 1
exec node tests/check-page.mjs "$build/page" "$npm" "$work/native" \
    "$(command -v chromium)" ${SHOTS:+"$SHOTS"}

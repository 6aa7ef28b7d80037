#!/bin/bash
# SPDX-License-Identifier: MIT
# Pairs of options by pairs/pairs.mjs: a third of what is listed as misuse, with a
# sanitizer rows for eight seconds, or `check-pairs.sh all` of them, and whether
# each changes something by itself. SEED picks the sample (1), BUILD the build; a
# sanitized one judges crashes and refusals alone.
set -u
. tests/lib.sh
command -v node >/dev/null || skip_all 'node is missing'
# OSMesa never frees some 480 bytes.
echo leak:libOSMesa.so >"$work/leaks"
export LSAN_OPTIONS=suppressions=$work/leaks:print_suppressions=0
how=(--light --list)
[ "${1:-}" != all ] || how=(--alone)
if grep -q __asan_init "$build/iblbake"; then
    how=(--light)
    [ "${1:-}" = all ] || how+=(--seconds 8 --seed "${SEED:-1}")
fi
node tests/pairs/pairs.mjs "$build" "${how[@]}"

#!/bin/bash
# SPDX-License-Identifier: MIT
# Runs the tests of what is built for other systems, installed, or drawn by engines,
# two at a time, with each third of many alike cases; the last line sums up. A test
# without what it needs says so and is skipped.
set -u
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
export IBL_TEST_QUICK=1
unset MAKEFLAGS MFLAGS MAKELEVEL

run() { # TEST...: one after the other
    local test
    for test; do
        env --default-signal bash "tests/check-$test.sh" >"$work/$test" 2>&1 \
            </dev/null
        sed "1i == check-$test, after $SECONDS s" "$work/$test"
    done
}
run npm page &
run windows &
for test in deb install arm64 clients; do
    wait -n
    run $test &
done
wait

cat "$work"/* | awk '/^[0-9]+ passed, [0-9]+ failed, [0-9]+ skipped$/ {
        tests++; passed += $1; failed += $3; skipped += $5 }
    END { if (tests != 7) { print "a test ended without a verdict"; failed++ }
        print passed " passed, " failed " failed, " skipped " skipped"
        exit failed > 0 }'

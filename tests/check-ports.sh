#!/bin/bash
# SPDX-License-Identifier: MIT
# Runs the test of each port that is there; the last line sums up. A test without
# what it needs says so and is skipped.
set -u
passed=0 failed=0 skipped=0
log=$(mktemp) || exit 1
trap 'rm -f "$log"' EXIT
for test in npm page windows deb; do
    script=tests/check-$test.sh
    [ -e "$script" ] || continue
    echo "== check-$test"
    bash "$script" 2>&1 | tee "$log"
    if [[ $(tail -n 1 "$log") =~ ^([0-9]+)' passed, '([0-9]+)' failed, '([0-9]+)' skipped'$ ]]; then
        passed=$((passed + BASH_REMATCH[1]))
        failed=$((failed + BASH_REMATCH[2]))
        skipped=$((skipped + BASH_REMATCH[3]))
    else
        echo "FAILED: check-$test: ended without a verdict"
        failed=$((failed + 1))
    fi
done
echo "$passed passed, $failed failed, $skipped skipped"
[ $failed -eq 0 ]

#!/bin/bash
# SPDX-License-Identifier: MIT
# What lint.sh finds is right, and what it and the scripts of the tests are for:
# a folder that grew is named, a name that is no test's fails, a program that is
# missing is one line.
set -u
. tests/lib.sh
need clang-format mandoc glslangValidator git

test_lint() { BUILD=$build sh tests/lint.sh 2>&1 | grep -vx 'lint: clean'; }

test_budget() {
    sh tests/budget.sh >"$work/now"
    works sh tests/budget.sh "$work/now"
    # One folder may have a line less, one is not named.
    awk '$1 == "src/json" { $2-- } $1 != "tests/cli"' "$work/now" >"$work/less"
    sh tests/budget.sh "$work/less" >"$work/said" && is 1 0 status
    lines 2 "$work/said"
    has '^src/json: [0-9]* lines, 1 more than' "$work/said"
    has '^tests/cli: .* than the 0 of ' "$work/said"
}

# Of a script that takes no time where nothing is to be done.
test_only() {
    ONLY=no_such BUILD=$build bash tests/check-faults.sh >"$work/said" && is 1 0 status
    has -x 'FAILED: ONLY=no_such: no test has such a name' "$work/said"
}

# All programs are there but the one that it needs first.
test_missing() {
    local script tool
    mkdir "$work/few"
    ln -s "$(command -v bash)" "$(command -v mktemp)" "$(command -v rm)" \
        "$work/few"
    for script in tests/check-*.sh; do
        tool=$(sed -n 's/^need \([^ ]*\).*/\1/p' "$script" | head -n 1)
        [ -n "$tool" ] || continue
        PATH=$work/few BUILD=$build bash "$script" >"$work/said" 2>&1 ||
            is 0 $? "$script: status"
        printf '%s\n' "skipped: $tool is missing (make deps, tests/deps.sh)" \
            '0 passed, 0 failed, 1 skipped' | diff "$work/said" - >"$work/why" ||
            head -n 5 "$work/why"
    done
}

for t in lint budget only missing; do
    picked "$t" || continue
    verdict "$t" "$("test_$t")"
done
end

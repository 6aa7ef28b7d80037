#!/bin/sh
# SPDX-License-Identifier: MIT
# budget.sh: prints the lines of each folder of src, include and tests, without
# those below it: `make budget` keeps them in tests/budget.txt.
# budget.sh FILE: names the folders that have more than FILE allows, 0 where it
# says nothing, and fails if there are any.
set -u
export GIT_CEILING_DIRECTORIES="$PWD/.."
lines() {
    { git ls-files 2>/dev/null || find src include tests -type f; } |
        grep -E '^(src|include|tests)/' |
        grep -vE '\.f16$|^tests/(budget\.(txt|new)|fuzz/finds/)' | xargs awk '
        FNR == 1 { folder = FILENAME; sub(/\/[^\/]*$/, "", folder) }
        { n[folder]++ }
        END { for (folder in n) print folder, n[folder] }' | LC_ALL=C sort
}
[ $# -gt 0 ] || { lines; exit; }
lines | awk -v file="$1" 'FILENAME == file { most[$1] = $2; next }
    $2 > most[$1] + 0 {
        printf "%s: %d lines, %d more than the %d of %s: take out as many " \
            "there, or let `make budget` count anew and say why\n", $1, $2,
            $2 - most[$1], most[$1], file
        bad = 1
    }
    END { exit bad }' "$1" -

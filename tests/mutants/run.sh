#!/bin/bash
# SPDX-License-Identifier: MIT
# run.sh [--check] [TABLE...]: breaks the program on purpose, one change at a
# time, and reports which changes the tests see. Takes an hour or more. --check
# builds and runs nothing: it checks that each mutant's lines and tests exist.
# run.sh --random SEED COUNT: the same with COUNT lines that are chosen at random,
# by the tests of its file, all quick ones and the first with a sanitizer; prints
# those that no test sees, and fails if more than 15 % are. Takes minutes for each
# that survives.
#
# A table, tests/mutants/*.txt, is a list of mutants with empty lines between:
#   # NOTE       what breaks, for the reader
#   FILE         from the top folder
#   -LINES       as they stand in FILE, which has them once
#   +LINES       what replaces them
#   = TESTS      what should fail: check_X, check_X:CASE, check-x.sh or
#                check-x.sh:PATTERN, of the names of its tests, or any
#   ? REASON     why no test can see it; its survival is no failure
#
# A mutant that does not compile, or changes nothing, is a mistake of the table
# and a failure, as is a survivor without a reason.
set -u
cd "$(dirname "$0")/../.." || exit 1
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
each=try most=100000
[ "${1:-}" != --check ] || { each=look; shift; }
if [ "${1:-}" = --random ]; then
    most=$3
    node tests/mutants/random.mjs "$2" "$3" >"$work/random.txt" || exit 1
    set -- "$work/random.txt"
fi
[ $# -gt 0 ] || set -- tests/mutants/*.txt
tables=()
for table; do tables+=("$(realpath "$table")"); done

# Builds a copy of the tree, which is then the working directory.
prepare() {
    local copy=$work/tree part
    echo "mutants: building"
    mkdir "$copy" "$work/tmp"
    export TMPDIR=$work/tmp
    git ls-files -z --cached --others --exclude-standard |
        xargs -0 cp -p --parents -t "$copy" || exit 1
    mkdir "$copy/build"
    for part in build/*; do
        case $part in
        build/cov | build/tsan | 'build/*') ;;
        *) cp -a "$part" "$copy/build" ;;
        esac
    done
    [ ! -d ../shared ] || ln -s "$(realpath ../shared)" "$work/shared"
    cd "$copy" || exit 1
    make -s -j"$(nproc)" DEPS=no all tests || exit 1
}

mutants=0 killed=0 survived=0 explained=0 wrong=0
note='' file='' old='' new='' tests='' reason=''
report() { printf '%-9s %s%s\n' "$1" "$file" "${note:+: $note}"; }
mistake() { # WORDS
    wrong=$((wrong + 1))
    report "$1"
}

# The file with the mutant, which must fit in one place.
mutated() {
    OLD=$old NEW=$new perl -0777 -pe '
        my $n = () = /\Q$ENV{OLD}\E/g;
        die if $n != 1 || $ENV{OLD} eq $ENV{NEW};
        s/\Q$ENV{OLD}\E/$ENV{NEW}/' "$file" 2>/dev/null
}

# Checks that the mutant's lines and the tests that it names exist.
look() {
    local t
    mutated >/dev/null || mistake 'NOT FOUND'
    for t in $tests; do
        case $t in
        any) ;;
        *.sh) [ -f "tests/${t#asan/}" ] ;;
        *.sh:*)
            grep -qE -- "${t#*:}" "tests/${t%%:*}" "$work/names" tests/cli/*.case
            ;;
        *:*) grep -qw -- "${t#*:}" "tests/${t%%:*}.c" 2>/dev/null ;;
        *) [ -f "tests/$t.c" ] ;;
        esac || mistake "NO $t"
    done
}

# A test that fails or does not end sees the mutant.
sees() {
    local name=${1%%:*} only='' what=all bridge= program
    [ "$1" = "$name" ] || only=${1#*:}
    [[ $file != src/io/bridge/* ]] || bridge='bridge exr-bridge scene-bridge'
    case $name in
    any)
        make -s -j"$(nproc)" DEPS=no all tests >/dev/null 2>&1 || return 2
        ! STOP=1 timeout 300 bash tests/run.sh --quick build >/dev/null 2>&1
        ;;
    *.sh)
        [ "$name" != check-fuzz.sh ] || what='config=asan fuzzers'
        [[ $name != asan/* ]] || what='config=asan all'
        # shellcheck disable=SC2086
        make -s -j"$(nproc)" DEPS=no $what >/dev/null 2>&1 || return 2
        [ "$what" = all ] && what=build || what=build/asan
        ! ONLY=$only BUILD=$what timeout 600 bash "tests/${name#asan/}" \
            >/dev/null 2>&1
        ;;
    *)
        program=build/tests/$name what=config=release
        [[ $name != asan/* ]] || program=build/asan/tests/${name#*/} what=config=asan
        # shellcheck disable=SC2086
        make -s -j"$(nproc)" DEPS=no $what $bridge "$program" \
            >/dev/null 2>&1 || return 2
        # shellcheck disable=SC2086
        ! timeout 120 "$program" $only >/dev/null 2>&1
        ;;
    esac
}

try() {
    local t status by=
    if ! mutated >"$work/mutant"; then
        mistake 'NOT FOUND'
        return
    fi
    cp "$file" "$work/original"
    cp "$work/mutant" "$file"
    for t in $tests; do
        sees "$t" </dev/null
        status=$?
        if [ $status = 2 ]; then
            [ "$t" = any ] || mistake 'NO BUILD'
            by=none
        elif [ $status = 0 ]; then
            killed=$((killed + 1))
            report killed
            by=$t
        fi
        [ -z "$by" ] || break
    done
    if [ -z "$by" ] && [ -n "$reason" ]; then
        explained=$((explained + 1))
        report explained
    elif [ -z "$by" ]; then
        survived=$((survived + 1))
        report SURVIVED
    fi
    cp "$work/original" "$file"
}

flush() {
    if [ -n "$file" ] && [ $((killed + survived)) -lt "$most" ]; then
        $each
        mutants=$((mutants + 1))
    fi
    note='' file='' old='' new='' tests='' reason=''
}

ls tests/cli tests/fuzz >"$work/names"
[ $each = look ] || prepare
for table in "${tables[@]}"; do
    while IFS= read -r line; do
        case $line in
        '') flush ;;
        '#'*) note=${note:+$note }${line#'# '} ;;
        -*) old=$old${line#-}$'\n' ;;
        +*) new=$new${line#+}$'\n' ;;
        =*) tests="$tests ${line#=}" ;;
        '?'*) reason=${line#'? '} ;;
        *) file=$line ;;
        esac
    done <"$table"
    flush
done

if [ $each = look ]; then
    echo "$mutants mutants, $wrong mistakes"
    exit $((wrong > 0))
fi
all=$((killed + survived + explained))
echo "$killed of $all mutants killed" \
    "($((all ? 100 * killed / all : 0)) %), $explained survivors explained," \
    "$survived not, $wrong wrong"
[ "$most" = 100000 ] || exit $((100 * survived > 15 * all || wrong))
[ $survived -eq 0 ] && [ $wrong -eq 0 ]

#!/bin/sh
# SPDX-License-Identifier: MIT
# run.sh BUILD...: runs the test programs of every build, and with the first
# build the scripts; the sanitized ones run the scripts that bake, too. Ends
# with the line `N passed, N failed, N skipped`.
set -u
passed=0 failed=0 skipped=0
log=$(mktemp) || exit 1
trap 'rm -f "$log"' EXIT

# Scripts run make as a user would, not as a part of the make that runs them.
unset MAKEFLAGS MFLAGS MAKELEVEL

export ASAN_OPTIONS=detect_stack_use_after_return=1:allocator_may_return_null=1
export UBSAN_OPTIONS=print_stacktrace=1
export TSAN_OPTIONS=halt_on_error=1

# Runs a command, adds up its summary, shows all but the summary.
run() {
    name=$1
    shift
    begin=$(date +%s)
    "$@" >"$log" 2>&1 </dev/null
    status=$?
    seconds=$(($(date +%s) - begin))
    line=$(grep -E '^[0-9]+ passed, [0-9]+ failed' "$log" | tail -n 1)
    if [ -z "$line" ]; then
        line='0 passed, 1 failed'
        [ $status -eq 0 ] || line="$line (exit status $status)"
    elif [ $status -ne 0 ] && expr "$line" : '.* 0 failed' >/dev/null; then
        line="$line, 1 failed (exit status $status)"
        failed=$((failed + 1))
    fi
    echo "$name: $line (${seconds} s)"
    grep -vE '^[0-9]+ passed, [0-9]+ failed' "$log" | sed 's/^/    /'
    set -- $(echo "$line" | tr -cs '0-9' ' ')
    passed=$((passed + $1))
    failed=$((failed + $2))
    case $line in
    *skipped*) skipped=$((skipped + $3)) ;;
    esac
}

first=$1
for build; do
    for program in "$build"/tests/check_*; do
        [ -x "$program" ] && run "$program" "$program"
    done
    for script in tests/check-*.sh; do
        case $build:$script in
        "$first":* | *san:*/check-cli.sh | *asan:*/check-verify.sh)
            run "$build: $script" env BUILD="$build" bash "$script" ;;
        esac
    done
done
echo "$passed passed, $failed failed, $skipped skipped"
[ $failed -eq 0 ]

#!/bin/bash
# SPDX-License-Identifier: MIT
# run.sh BUILD SECONDS [HARNESS...]: fuzzes so long with each harness, by default
# with all. Begins with the seeds, the finds of before and what earlier runs
# kept in BUILD/fuzz/corpus. A crash, a leak, a hang or too much memory leaves a
# file in BUILD/fuzz/finds; then the command that repeats it is printed.
# SEED=N: the same random numbers in each run, and nothing is kept.
set -u
build=$1 seconds=$2
shift 2
if [ $# -eq 0 ]; then
    set -- "$build"/fuzz/fuzz_*
    set -- "${@##*/fuzz_}"
fi
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
mkdir -p "$build/fuzz/finds"
export TMPDIR=$work ASAN_OPTIONS=allocator_may_return_null=1
export UBSAN_OPTIONS=print_stacktrace=1
LD_LIBRARY_PATH=$(cd "$build" && pwd) # for libiblexr.so
export LD_LIBRARY_PATH

status=0
for harness in "$@"; do
    program=$build/fuzz/fuzz_$harness corpus=$build/fuzz/corpus/$harness
    [ -z "${SEED:-}" ] || corpus=$work/$harness
    finds=tests/fuzz/finds/$harness
    mkdir -p "$corpus"
    [ -d "$finds" ] || finds=
    seeds=$build/fuzz/seeds
    limits='-rss_limit_mb=2048 -malloc_limit_mb=1024 -timeout=20 -max_len=8192'
    # shellcheck disable=SC2086
    if "$program" $limits -max_total_time="$seconds" -seed="${SEED:-0}" \
        -close_fd_mask=1 -artifact_prefix="$build/fuzz/finds/$harness-" \
        -dict="$seeds/$harness.dict" -print_final_stats=1 "$corpus" "$seeds/$harness" \
        $finds >"$work/log" 2>&1; then
        awk -v name="$harness" '/cov: / { at = $0 }
            /number_of_executed_units/ { runs = $2 }
            END { match(at, /cov: [0-9]+ ft: [0-9]+/)
                print name ": " runs " runs, " substr(at, RSTART, RLENGTH) }' \
            "$work/log"
    else
        status=1
        grep -vE 'NEW|REDUCE|pulse|^INFO|^Dictionary' "$work/log" | tail -n 60
        find=$(sed -n 's/.*Test unit written to //p' "$work/log" | tail -n 1)
        echo "$harness: found something. To repeat it:"
        echo "    $program $limits ${find:-(no file was written)}"
    fi
done
exit $status

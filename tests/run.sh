#!/bin/bash
# SPDX-License-Identifier: MIT
# run.sh [--quick] BUILD...: runs the test programs of every build, and with the
# first build the scripts; the sanitized ones run the scripts that bake, too. As
# many run at once as there are processors; results are printed in a fixed
# order. Repeats at the end what failed, and prints `N passed, N failed, N
# skipped`. --quick leaves out slow tests, and all scripts but check-cli.sh.
set -u
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT

quick=no
if [ "${1:-}" = --quick ]; then
    quick=yes
    export IBL_TEST_QUICK=1
    shift
fi

# Scripts run make as a user would, not as a part of the make that runs them.
unset MAKEFLAGS MFLAGS MAKELEVEL

ASAN_OPTIONS=detect_stack_use_after_return=1:allocator_may_return_null=1
export LSAN_OPTIONS=print_suppressions=0
# What is undefined traps there; this prints where it was.
export ASAN_OPTIONS=$ASAN_OPTIONS:handle_sigill=1
# OpenImageIO, which is not built for it, starts a thread whatever it is told,
# and shares with it what ThreadSanitizer cannot see to be guarded.
echo 'race:libOpenImageIO_Util.so' >"$work/tsan"
export TSAN_OPTIONS=halt_on_error=1:suppressions=$work/tsan
# What a killed test leaves behind goes with ours. Other users run the program
# there, too.
export TMPDIR=$work/tmp
mkdir "$TMPDIR"
chmod 755 "$work"

# Some wait for others, for a disk, a display or a browser. A map of gigabytes
# is read by one test at a time.
slots=$(($(nproc) + 1))
[ -z "${IBL_TEST_LARGE:-}" ] || slots=1

# ---- what there is to run: a name, a build and a script, or a program ------
tests=()
first=$1
programs() {
    local build=$1 program
    for program in "$build"/tests/check_*; do
        [ ! -x "$program" ] || tests+=("$program")
    done
}
scripts() {
    local build=$1 script
    for script in tests/check-*.sh; do
        case $quick:$build:$script in
        # Those of make check-ports.
        *-ports.sh | *-npm.sh | *-page.sh | *-windows.sh | *-deb.sh | \
            *-arm64.sh | *-install.sh | *-clients.sh) ;;
        yes:*/check-cli.sh)
            tests+=("$build: $script") ;;
        yes:*) ;;
        *asan:*/check-fuzz.sh | *san:*/check-cli.sh | \
            *asan:*/check-batch.sh | *asan:*/check-pairs.sh)
            tests+=("$build: $script") ;;
        *:*/check-fuzz.sh) ;;
        *:"$first":*)
            tests+=("$build: $script") ;;
        esac
    done
}
# The longest tests must not be the last to begin: first are the slowest builds,
# which are the last ones, and of each build the scripts.
for ((i = $#; i > 0; i--)); do
    scripts "${!i}"
    programs "${!i}"
done

# With a sanitizer, where the rest runs no code that these do not; races are
# between threads, and with signals.
declare -A only=(
    [asan: tests/check-batch.sh]='failures|interrupted'
    [asan: tests/check-cli.sh]='malformed|interrupt'
    [asan/tests/check_blocks]='alike_beyond_calls errors'
    [asan/tests/check_environment]='failures pieces rows_and_threads'
    [asan/tests/check_hdr]='damaged headers long_header'
    [asan/tests/check_inputs]='alpha_and_mending all_forms_are_one_map dds_cubes envmap_cubes
        files_that_users_met names_of_faces orientations wrong_orders'
    [asan/tests/check_levels]='seams threads'
    [asan/tests/check_read]='damaged kinds mending'
    [asan/tests/check_set]='probes what_is_refused what_others_mean wrong_keys'
    [asan/tests/check_texture]='bombs boundless damaged headers ktx_turned_and_widened
        odd_metadata texels words zstd_frames'
    [tsan: tests/check-cli.sh]='thread|interrupt|signal|progress'
    [tsan/tests/check_environment]='rows_and_threads pieces progress'
    [tsan/tests/check_read]='everywhere damage_while_read'
    [tsan/tests/check_view_set]='baker'
)

# ---- running them ----------------------------------------------------------
# Each has a session of its own, by which all of it can be killed; and what
# runs in the background of a script would ignore INT, and under nohup HUP,
# which tests send.
start() { # NUMBER
    local name=${tests[$1]} command few
    few=${only[${name#"$first"/}]:-}
    command=("$name")
    case $name in
    *': '*) command=(env ONLY="$few" "BUILD=${name%%: *}" bash "${name#*: }") ;;
    # The numbers of slow tests do not depend on the compiler, and they run no
    # code that others do not.
    *san/*)
        read -rd "" -a few <<<"$few"
        command=(env IBL_TEST_QUICK=1 "$name" "${few[@]}") ;;
    esac
    (
        TIMEFORMAT='%R %U %S'
        time env --default-signal setsid "${command[@]}" \
            >"$work/$1.log" 2>&1 </dev/null
        echo $? >"$work/$1.status"
    ) 2>"$work/$1.time" &
}

stop() { # SIGNAL
    local pids
    trap '' INT TERM HUP
    # The sessions are named by the only child that each of our jobs has.
    pids=$(pgrep -d, -P "$(jobs -p | paste -sd,)")
    if [ -n "$pids" ]; then
        # shellcheck disable=SC2086
        kill -TERM ${pids//,/ } 2>/dev/null
        pkill -TERM -s "$pids"
        wait
        pkill -KILL -s "$pids"
    fi
    exit $((128 + $(kill -l "$1")))
}
for signal in INT TERM HUP; do
    # shellcheck disable=SC2064
    trap "stop $signal" $signal
done

# Adds up the summary of a test that has ended, shows all but the summary.
passed=0 failed=0 skipped=0 again=
show() { # NUMBER
    local log=$work/$1.log line status wall user system
    status=$(cat "$work/$1.status" 2>/dev/null || echo unknown)
    read -r wall user system < <(tail -n 1 "$work/$1.time")
    line=$(grep -E '^[0-9]+ passed, [0-9]+ failed' "$log" | tail -n 1)
    if [ -z "$line" ]; then
        line='0 passed, 1 failed'
        [ "$status" = 0 ] || line="$line (exit status $status)"
    elif [ "$status" != 0 ] && [[ $line == *' 0 failed'* ]]; then
        line="$line, 1 failed (exit status $status)"
        failed=$((failed + 1))
    fi
    [[ $line == *' 0 failed'* && $status = 0 ]] || again="$again $1"
    awk -v name="${tests[$1]}: $line" -v wall="$wall" -v cpu="$user $system" \
        'BEGIN { split(cpu, part, " ")
            printf "%s (%.0f s, %.0f s of processors)\n", name, wall,
                part[1] + part[2] }'
    grep -vE '^[0-9]+ passed, [0-9]+ failed' "$log" | sed 's/^/    /'
    if [[ $line =~ ^([0-9]+)\ passed,\ ([0-9]+)\ failed(,\ ([0-9]+)\ sk)? ]]; then
        passed=$((passed + BASH_REMATCH[1]))
        failed=$((failed + BASH_REMATCH[2]))
        skipped=$((skipped + ${BASH_REMATCH[4]:-0}))
    fi
}

# STOP=1 looks no further after a test that failed.
next=0 active=0 shown=0
while ((next < ${#tests[@]} || active > 0)); do
    [ -z "${STOP:-}" ] || ! grep -qsvx 0 "$work"/*.status || stop TERM
    if ((next < ${#tests[@]} && active < slots)); then
        start $((next++))
        active=$((active + 1))
    else
        wait -n
        active=$((active - 1))
        # Not by -e: a file is there before anything is in it.
        while [ -s "$work/$shown.status" ]; do
            show $((shown++))
        done
    fi
done
while ((shown < ${#tests[@]})); do
    show $((shown++))
done
for number in $again; do
    echo "${tests[$number]} did not pass:"
    tail -n 40 "$work/$number.log" | sed 's/^/    /'
done
echo "$passed passed, $failed failed, $skipped skipped"
[ $failed -eq 0 ]

# SPDX-License-Identifier: MIT
# shellcheck shell=bash
# What the scripts of the tests share, by `. tests/lib.sh` in the top folder.
# Sets top, build (BUILD, from everywhere) and work, an empty directory that is
# removed at exit, and counts.
top=$PWD
build=$(cd "${BUILD:-build}" && pwd) || exit 1
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
passed=0 failed=0 skipped=0

verdict() { # NAME [WHY]: no reason, no failure
    if [ $# -eq 1 ] || [ -z "$2" ]; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "FAILED: $1: $2"
    fi
}
ok() { # NAME [command]: it works
    local name=$1 log
    shift
    if log=$("$@" 2>&1); then
        verdict "$name"
    else
        verdict "$name" "$*: $log"
    fi
}
# The last line, and whether nothing failed.
end() {
    echo "$passed passed, $failed failed, $skipped skipped"
    [ $failed -eq 0 ]
}
skip_all() { # WHY
    echo "skipped: $1"
    echo '0 passed, 0 failed, 1 skipped'
    exit 0
}
need() { # PROGRAM
    command -v "$1" >/dev/null || { echo "$1 is missing"; exit 1; }
}

# Programs of the build, by name, and mkenv, which makes environments.
use() { # PROGRAM...
    local program
    mkdir "$work/bin"
    ${CC:-cc} -std=c11 -o "$work/bin/mkenv" tests/cli/mkenv.c -lm || exit 1
    for program; do
        [ -x "$build/$program" ] || { echo "$program: not built"; exit 1; }
        ln -s "$build/$program" "$work/bin"
    done
    export PATH=$work/bin:$PATH
}

# ---- the viewer without a display --------------------------------------------

use_viewer() {
    [ -x "$build/iblview" ] || skip_all 'iblview was not built'
    need node
    use iblbake iblview
    cp tests/cli/png.mjs "$work/bin"
    unset DISPLAY WAYLAND_DISPLAY
    # OSMesa never frees some 480 bytes.
    echo leak:libOSMesa.so >"$work/leaks"
    export LSAN_OPTIONS=suppressions=$work/leaks:print_suppressions=0
}
# Without OSMesa there are no pictures, as the first one says in FILE.
need_pictures() { # FILE
    ! grep -q libosmesa6 "$1" || skip_all "$(cat "$1")"
}
# iblview fails with one line like that, and leaves nothing.
wrong() { # STATUS GLOB [arguments]
    local want=$1 glob=$2 status
    shift 2
    ls -A >"$work/before"
    iblview "$@" 2>"$work/err" >"$work/printed"
    status=$?
    ls -A | diff "$work/before" - || echo "$*: left something"
    [ $status -eq "$want" ] || echo "$*: status $status, not $want"
    [ "$(wc -l <"$work/err")" = 1 ] ||
        echo "$*: not one line: $(cat "$work/err")"
    # shellcheck disable=SC2254
    case $(cat "$work/err") in
    $glob) ;;
    *) echo "$*: $(cat "$work/err")" ;;
    esac
    [ ! -s "$work/printed" ] || echo "$*: on stdout: $(cat "$work/printed")"
}

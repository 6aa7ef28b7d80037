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

verdict() { # NAME [WHY]: no reason, no failure; or `skipped: WHY`
    [ -z "${IBL_TEST_TIMES:-}" ] || spent "$1"
    case ${2-} in
    '') passed=$((passed + 1)) ;;
    'skipped: '*)
        skipped=$((skipped + 1))
        echo "skipped $1: ${2#skipped: }"
        ;;
    *)
        failed=$((failed + 1))
        echo "FAILED: $1: $2"
        ;;
    esac
}
# Prints what processors worked for NAME: since the last one.
spent=0
spent() { # NAME
    local now
    builtin times >"$work/times"
    now=$(awk -F '[ms ]+' 'NR == 2 {
        print ($1 + $3) * 6000 + int(($2 + $4) * 100) }' "$work/times")
    printf '%5d.%02d s %s\n' $(((now - spent) / 100)) \
        $(((now - spent) % 100)) "$1"
    spent=$now
}
have() { # PROGRAM...: false, with the reason for a verdict, where one is not
    local program
    for program; do
        command -v "$program" >/dev/null && continue
        echo "skipped: $program is missing (make deps, tests/deps.sh)"
        return 1
    done
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
# The last line, and whether nothing failed. ONLY that no test is like is a
# mistake.
end() {
    [ -z "${ONLY:-}" ] || [ $matched = yes ] ||
        verdict "ONLY=$ONLY" 'no test has such a name'
    echo "$passed passed, $failed failed, $skipped skipped"
    [ $failed -eq 0 ]
}
skip_all() { # WHY
    echo "skipped: $1"
    echo '0 passed, 0 failed, 1 skipped'
    exit 0
}
# packed NAME: sets version, and has packaging/NAME.sh make what is tested; the
# sources of libraries may be out of reach.
packed() {
    local log
    version=$(sed -n 's/^.define IBL_VERSION "\(.*\)"/\1/p' include/ibl/ibl.h)
    log=$(sh "packaging/$1.sh" "$build" "$version" 2>&1) &&
        { verdict build; return; }
    [[ $log != *'libraries: no source'* ]] || skip_all "${log##*libraries: }"
    verdict build "$log"
    end
    exit
}
# refused STATUS GLOB COMMAND...: the command ends with that status and one line
# like GLOB, prints nothing, and leaves nothing in this directory.
refused() {
    local want=$1 glob=$2 status
    shift 2
    touch "$work/before" "$work/err" "$work/printed"
    ls -A >"$work/before"
    "$@" 2>"$work/err" >"$work/printed"
    status=$?
    ls -A | diff "$work/before" - || echo "$*: left something"
    [ $status -eq "$want" ] || echo "$*: status $status, not $want"
    [ "$(wc -l <"$work/err")" = 1 ] ||
        echo "$*: not one line: $(cat "$work/err")"
    # shellcheck disable=SC2254
    case $(cat "$work/err") in
    $glob) ;;
    *) echo "$*: found '$(cat "$work/err")', wanted '$glob'" ;;
    esac
    [ ! -s "$work/printed" ] || echo "$*: on stdout: $(cat "$work/printed")"
}
# What was wanted beside what was found, if they differ, each for a verdict.
is() { # WANTED FOUND [WHAT]
    [ "$1" = "$2" ] || echo "${3:+$3: }found '$2', wanted '$1'"
}
has() { # [-OPTION] PATTERN FILE: a line of the file, as grep finds it
    grep -q "$@" || echo "wanted '${*: -2:1}' in ${*: -1}, found: $(
        head -n 8 "${@: -1}")"
}
hasnt() { # PATTERN FILE
    ! grep -- "$1" "$2" || echo "wanted no '$1' in $2, found the above"
}
count() { # N PATTERN FILE: so many lines like it
    is "$1" "$(grep -c -- "$2" "$3")" "lines like '$2' in $3"
}
lines() { # N FILE: so many lines in all
    is "$1" "$(grep -c '' "$2")" "lines in $2, $(head -n 8 "$2")"
}
works() { # COMMAND...: ends with status 0
    "$@" || is 0 $? "$*: status"
}
there() { # FILE...: not empty
    local f
    for f; do
        [ -s "$f" ] || echo "wanted $f, found: $(ls -A . "${f%/*}" 2>&1 | xargs)"
    done
}
absent() { # FILE...: or folders
    local f
    for f; do
        [ ! -e "$f" ] || echo "wanted no $f, found: $(ls -Ald "$f" "$f"/* 2>&1)"
    done
}
# within COMMAND...: true as soon as it is; false if it is not in a minute, or
# longer on a busy machine.
within() {
    local n
    for ((n = 0; n < 600; n++)); do
        "$@" >/dev/null 2>&1 && return 0
        sleep 0.1
    done
    return 1
}
# interrupt SIGNAL COMMAND...: sends it the signal when its bake is under way,
# as the half second of processors says that it has taken; sets status. What
# would take minutes must then end by the signal before it has taken some
# seconds, whatever else the machine does meanwhile; on a busy one the signal
# may come late.
interrupt() {
    local signal=$1 pid
    shift
    # What runs in the background of a script would ignore INT, and under nohup
    # HUP.
    (ulimit -t 20; exec env --default-signal "$@") </dev/null &
    pid=$!
    while took=$(awk '{ print $14 + $15 }' "/proc/$pid/stat" 2>/dev/null) &&
        [ "${took:-50}" -lt 50 ]; do
        sleep 0.02
    done
    kill -s "$signal" $pid
    { wait $pid; } 2>/dev/null # where the shell tells of the signal
    status=$?
}
# Prints a flat .hdr of 16x8 pixels: so many of the bytes after each number.
map_of() { # COUNT BYTES...
    local i
    printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n'
    for (( ; $# > 1; )); do
        # shellcheck disable=SC2059
        for ((i = 0; i < $1; i++)); do printf "$2"; done
        shift 2
    done
}
# Runs standard input by node, with fs, json(FILE), which reads one, and what says
# what was found and wanted: near(WHAT, GOT, WANT, BY) of what is farther apart
# than BY, equal(WHAT, GOT, WANT), must(WANT, OK, GOT).
js() { # ARGUMENTS
    {
        cat <<'END'
const fs = require('fs');
const json = name => JSON.parse(fs.readFileSync(name));
const shown = JSON.stringify;
const near = (what, got, want, by) => Math.abs(got - want) <= by ||
    console.log(`${what}: found ${got}, wanted ${want}`);
const equal = (what, got, want) => shown(got) === shown(want) ||
    console.log(`${what}: found ${shown(got)}, wanted ${shown(want)}`);
const must = (want, ok, got) =>
    ok || console.log(`found ${shown(got)}, wanted ${want}`);
END
        cat
    } | node - "$@"
}
# fetch_npm FOLDER PACKAGES: npm's, once: a network that is not there is no fault of
# ours.
fetch_npm() {
    [ "$(cat "$1/fetched" 2>/dev/null)" = "$2" ] && return
    # shellcheck disable=SC2086
    npm install --no-save --no-package-lock --no-audit --no-fund \
        --ignore-scripts --loglevel=error --prefix "$1" $2 && echo "$2" >"$1/fetched"
}
# report NAME FILE: what a program printed, whose last line is "N passed, N failed".
report() {
    sed '$d' "$2"
    if [[ $(tail -n 1 "$2") =~ ^([0-9]+)\ passed,\ ([0-9]+)\ failed$ ]]; then
        passed=$((passed + BASH_REMATCH[1])) failed=$((failed + BASH_REMATCH[2]))
    else
        verdict "$1" "wanted a verdict, found: $(tail -n 1 "$2")"
    fi
}
need() { # PROGRAM...: without one of them nothing is tested
    local why
    why=$(have "$@") || skip_all "${why#skipped: }"
}

# Programs of the build, by name, and mkenv, which makes environments. Sets
# sanitized: whether a sanitizer makes them slow, and map terabytes.
use() { # PROGRAM...
    local program
    sanitized=no
    grep -qE '__(asan|tsan)_init' "$build/$1" && sanitized=yes
    mkdir "$work/bin"
    ${CC:-cc} -std=c11 -Itests -o "$work/bin/mkenv" tests/cli/mkenv.c \
        tests/float_exr.c -lm || exit 1
    for program; do
        [ -x "$build/$program" ] || { echo "$program: not built"; exit 1; }
        ln -s "$build/$program" "$work/bin"
    done
    export PATH=$work/bin:$PATH
}

# Makes $work/preload.so, which has calls to the C library fail, as FAULT says:
# see faults/preload.c. Not for what a sanitizer is in.
preload() {
    ${CC:-cc} -std=c11 -O1 -shared -fPIC -o "$work/preload.so" \
        "$top/tests/faults/preload.c" || exit 1
}

# Whether a test is wanted: with ONLY those whose name it matches, else all, but
# with IBL_TEST_QUICK those that do not match slow, and with a sanitizer those
# that do not match repeats, which run no code that others do not. A script may
# set both.
slow=
repeats=
sanitized=no
matched=no
picked() { # NAME
    [[ $1 =~ ${ONLY:-} ]] || return
    matched=yes
    [ -z "${ONLY:-}" ] || return 0
    [ -z "${IBL_TEST_QUICK:-}" ] || [ -z "$slow" ] || [[ ! $1 =~ $slow ]] ||
        return
    [ $sanitized = no ] || [ -z "$repeats" ] || [[ ! $1 =~ $repeats ]]
}

# Of many alike cases whether to take this one: each third with a sanitizer or
# with IBL_TEST_QUICK.
asked=0
taken() {
    { [ $sanitized = no ] && [ -z "${IBL_TEST_QUICK:-}" ]; } ||
        [ $((asked++ % 3)) = 0 ]
}

# ---- the viewer without a display --------------------------------------------

use_viewer() {
    [ -x "$build/iblview" ] || skip_all 'iblview was not built'
    need node
    use iblbake iblview
    cp tests/cli/png.mjs tests/cli/read_png.mjs "$work/bin"
    unset DISPLAY WAYLAND_DISPLAY
    # OSMesa never frees some 480 bytes.
    echo leak:libOSMesa.so >"$work/leaks"
    export LSAN_OPTIONS=suppressions=$work/leaks:print_suppressions=0
}
# Pictures, or what they are of.
same() { # FILE FILE [WHAT]
    cmp -s "$1" "$2" || echo "wanted $1, found another picture, $2${3:+: $3}"
}
differ() { # FILE FILE [WHAT]
    ! cmp -s "$1" "$2" || echo "wanted another picture than $1, found it in $2${3:+: $3}"
}
# Without OSMesa there are no pictures, as the first one says in FILE.
need_pictures() { # FILE
    ! grep -q libosmesa6 "$1" || skip_all "$(cat "$1")"
}
# iblview fails so.
wrong() { # STATUS GLOB [arguments]
    refused "$1" "$2" iblview "${@:3}"
}
# Writes NAME.gltf: one square of each material.
make_scene() {
    node -e '
const [name, list] = process.argv.slice(1);
const materials = JSON.parse(list);
const places = Buffer.from(new Float32Array(
    [-1, -1, 0, 1, -1, 0, -1, 1, 0, 1, 1, 0]).buffer);
const each = f => materials.map((m, i) => f(i));
require("fs").writeFileSync(name, JSON.stringify({
    asset: {version: "2.0"}, materials,
    buffers: [{byteLength: 48, uri: "data:;base64," +
        places.toString("base64")}],
    bufferViews: [{buffer: 0, byteLength: 48}],
    accessors: [{bufferView: 0, componentType: 5126, count: 4, type: "VEC3"}],
    meshes: each(i => ({primitives: [{mode: 5, material: i,
        attributes: {POSITION: 0, NORMAL: 0}}]})),
    nodes: each(i => ({mesh: i})), scenes: [{nodes: each(i => i)}]}));
' "$1.gltf" "$2"
}

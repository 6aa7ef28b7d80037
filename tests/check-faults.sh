#!/bin/bash
# SPDX-License-Identifier: MIT
# Has calls to the C library fail, one at a time, and kills the programs, as
# faults/walk.c says. Tries some of all runs; with FULL=1 all, which takes long.
# Then runs them on file systems that are full or read-only, and with names of any
# bytes. BUILD names the build.
set -u
. tests/lib.sh
slow='verify|map|saved|small_disk'
use iblbake
! [ -x "$build/iblview" ] || ln -s "$build/iblview" "$work/bin"
[ $sanitized = no ] || skip_all 'a sanitizer replaces the same calls'
preload
${CC:-cc} -std=c11 -O1 -o "$work/bin/walk" tests/faults/walk.c || exit 1
mkenv exr 8 4 BGR >"$work/a.exr"
mkenv hdr 8 4 >"$work/b.hdr"
small='-q --size 4 --lut-size 4 --irradiance-size 2'

# Makes this directory the one that runs begin in.
begin() {
    mkdir "$work/$t" "$work/$t/before" && cd "$work/$t/before" || exit 1
    cp "$work/a.exr" "$work/b.hdr" .
}
# faults N [options of walk] -- COMMAND...: each Nth run.
faults() {
    local options=(-e "$1")
    shift
    for (( ; $# > 0; )); do
        [ "$1" != -- ] || break
        options+=("$1")
        shift
    done
    shift
    [ -z "${FULL:-}" ] || options+=(-e 1)
    walk "${options[@]}" "$work/preload.so" "$work/$t/before" "$work/$t/run" \
        "$@" 2>"$work/$t/counts"
    [ -z "${FULL:-}" ] || { echo "$t:"; cat "$work/$t/counts"; } >&3
}

# Over an older set, flushed.
test_bake() {
    begin
    # shellcheck disable=SC2086
    iblbake a.exr $small --size 8 -o o --depfile d
    # shellcheck disable=SC2086
    faults 97 -- iblbake a.exr -j 1 $small -o o --depfile d --sync
}

# Drawing takes most of the time.
test_preview() {
    begin
    iblbake a.exr -q --lut-size 4 --only lut,json -o o --preview p.png
    faults 197 -- iblbake b.hdr -j 1 -q --lut-size 4 --only lut,json -o o \
        --preview p.png
}

# Into a new folder, files of several engines, by two threads.
test_targets() {
    begin
    faults 97 -- iblbake b.hdr -j 2 -q --size 8 -o n/o \
        --target three,babylon-env --lights 1
}

# Two maps side by side, of which what is finished stays.
test_batch() {
    begin
    # shellcheck disable=SC2086
    faults 397 -p -- iblbake a.exr b.hdr -j 1 $small -o o
}

# Most of what asks for memory, where little is baked.
test_small_batch() {
    begin
    faults 9 -1 -p -k memory -- iblbake a.exr b.hdr -j 1 -o o --depfile d \
        --target three --only lut,json -q --lut-size 1
}

# Two probes, of which one is changed after the bake.
bake_set() { # DIRECTORY
    cat >set.json <<'END'
{"version": 1,
 "defaults": {"size": 4, "levels": 1, "irradiance": 4, "lut_size": 4},
 "probes": [
  {"name": "hall", "position": [0, 1, 0], "capture": {"equirect": "a.exr"},
   "influence": {"box": {"centre": [0, 1, 0], "half": [4, 2, 4]}}},
  {"name": "lamp", "position": [1, 1, 0], "capture": {"equirect": "b.hdr"},
   "influence": {"sphere": {"centre": [1, 1, 0], "radius": 1}}}
 ]}
END
    iblbake probes -q set.json -o "$1"
    cp a.exr b.hdr
}
test_probes() {
    begin
    bake_set o
    faults 97 -- iblbake probes -q -j 1 set.json -o o --sync
}

test_grid() {
    begin
    cat >room.json <<'END'
{"version": 1, "min": [-6, 0, -4], "max": [6, 3, 4], "spacing": 4,
 "solid": [{"min": [-1, 0, -5], "max": [0, 9, 0]}],
 "capture": {"equirect": "grid/{name}.exr"}, "defaults": {"size": 8}}
END
    faults 29 -- iblbake probes --grid room.json -o set.json
}

test_verify() {
    begin
    # shellcheck disable=SC2086
    iblbake a.exr $small -o o
    faults 397 -k memory -k read -k write -- iblbake verify -q -j 1 a.exr o --texels 24 --json v.json
}

test_convert() {
    begin
    iblbake a.exr -q --size 4 -o o --only specular
    faults 29 -- iblbake convert -q -j 1 o/a_specular.ktx2 c.ktx2 --layout equirect
}
test_convert_to_pictures() {
    begin
    iblbake a.exr -q --size 4 -o o --only specular
    faults 29 -- iblbake convert -q -j 1 o/a_specular.ktx2 c.exr --layout cross
}

test_info_of_a_map() {
    begin
    faults 17 -k memory -k read -k write -- iblbake info -j 1 b.hdr
}
test_info_of_a_folder() {
    begin
    iblbake a.exr -q --size 4 -o o --only specular
    faults 17 -k memory -k read -k write -- iblbake info --texels yes --json o
}

# Not in OpenGL, whose own failures are not ours.
test_picture() {
    begin
    # shellcheck disable=SC2086
    iblbake a.exr $small -o o
    faults 397 -o -k memory -k read -- iblview o --size 16x16 --offscreen p.png
}

test_picture_of_a_map() {
    begin
    faults 397 -o -k memory -k read -- iblview a.exr --size 16x16 --offscreen p.png
}

# ---- file systems ------------------------------------------------------------

# What writes over the files of an older run.
writers=("iblbake a.exr $small -o o --depfile d --preview p.png"
    "iblbake a.exr b.hdr $small -j 1 -o o"
    'iblbake probes -q set.json -o s'
    'iblbake verify -q a.exr o --texels 24 --json v.json')
[ ! -x "$work/bin/iblview" ] ||
    writers+=('iblview o/a_specular.ktx2 --size 16x16 --offscreen p.png')
files() { # DIRECTORY
    (cd "$1" && find . ! -name filler -type f -exec cksum {} + | sort -k 3)
}
# Calls a function with each of them; in before is what is there, in after what
# the command makes of it.
each_writer() { # FUNCTION
    local command
    begin
    # shellcheck disable=SC2086
    iblbake a.exr b.hdr $small --size 8 -o o
    bake_set s
    touch d p.png v.json
    for command in "${writers[@]}"; do
        rm -rf ../after
        cp -a . ../after
        (cd ../after && $command >&2) || is 0 $? "$command: status"
        (cd .. && "$1" "$command")
    done
}
# judged STATUS WORDS COMMAND: what ran here failed with one line and left all
# as it was, or made what is in ../after.
judged() {
    local want=before
    [ "$1" != 0 ] || want=after
    [ "$1" = 0 ] || { is 1 "$1" "$3: status"; lines 1 "$work/err"
        has "$2" "$work/err"; }
    files . | diff <(files ../$want) - || echo "of $3, status $1"
}

# Some pages are free, until the command has room; then the disk is read-only.
small_disk() { # COMMAND
    local pages status=1
    mkdir -p disk
    mount -t tmpfs -o size=1m none disk && cd disk || exit 1
    for ((pages = 0; pages < 64 && status != 0; pages += 1 + 2 * pages)); do
        rm -rf -- *
        cp -a ../before/. .
        head -c $((1024 * $(df --output=avail . | tail -n 1) - 4096 * pages)) \
            /dev/zero >filler
        $1 2>"$work/err" >&2
        status=$?
        judged $status 'No space left on device: make room' "$1"
    done
    [ $pages -gt 1 ] || echo "$1: wanted no room on a full disk, found some"
    rm -rf -- *
    cp -a ../before/. .
    mount -o remount,ro .
    $1 2>"$work/err" >&2
    judged $? 'Read-only file system: choose another' "$1"
    cd ..
    umount disk
}
test_small_disk() {
    export -f begin bake_set each_writer small_disk judged files is has lines
    export work t small
    unshare -rm bash -c "$(declare -p writers); each_writer small_disk"
}

# Names are bytes. A set's own are UTF-8, those of its directory need not be.
test_names() {
    local name odd
    name=$(printf -- '-a b\n\001"\\%%\303\251;$#')
    odd=$(printf './-\377')$name
    begin
    mkdir "$odd"
    cp a.exr "$odd/$name.exr"
    cp b.hdr "$odd"
    # shellcheck disable=SC2086
    iblbake "$odd/$name.exr" $small -o "$odd 1"
    # shellcheck disable=SC2086
    iblbake "$odd" $small -o 2 --incremental
    # shellcheck disable=SC2086
    find "$odd" -type f -print0 | iblbake --from - $small -o 3
    diff -r -x .iblbake 2 3
    cmp "$odd 1/${name}_specular.ktx2" "2/${name}_specular.ktx2"
    iblbake verify -q "$odd/$name.exr" "$odd 1" --texels 24 --json "$odd.json"
    [ ! -x "$work/bin/iblview" ] ||
        iblview "$odd 1" --size 16x16 --offscreen "$odd.png"
    cd "$odd"
    cp ../a.exr .
    bake_set "$odd"
    there "$odd/index.json" "../$odd.json"
}

exec 3>&1
most=40 # lines
[ -z "${FULL:-}" ] || most=-0
for t in $(compgen -A function test_); do
    picked "$t" || continue
    if [ "$t" = test_small_disk ] && ! unshare -rm true 2>/dev/null; then
        verdict "$t" 'skipped: no disk can be mounted'
        continue
    fi
    verdict "$t" "$($t 2>&1 | head -n $most)"
    cd "$top" || exit 1
done
end

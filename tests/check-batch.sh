#!/bin/bash
# SPDX-License-Identifier: MIT
# Bakes of many environments in one call, against bakes of each alone. BUILD
# names the build.
set -u
. tests/lib.sh
need node make script
repeats='same_bytes|incremental_options|depfile|progress|words|collide|tree'
use iblbake
options='--size 16 --lut-size 16 --irradiance-size 4 --lobe-table-size 8'

# Four environments, sun.hdr the brightest, and one that is none.
mkdir "$work/maps"
mkenv hdr 32 16 >"$work/maps/sun.hdr"
mkenv exr 64 32 BGR >"$work/maps/mild.exr"
for n in 1 2; do
    map_of $((40 * n)) '\x80\x40\x20\x82' $((128 - 40 * n < 0 ? 0 : \
        128 - 40 * n)) '\x20\x40\x80\x80' | head -c $((46 + 512)) \
        >"$work/maps/map$n.hdr"
done
head -c 46 "$work/maps/map1.hdr" >"$work/bad.hdr"
# They are older than the grace of --incremental.
touch -d '1 hour ago' "$work/maps"/*
sleep 0.05

fresh() {
    cd "$top"
    rm -rf "$work/case"
    mkdir "$work/case"
    cp -rp "$work/maps" "$work/case/m"
    cd "$work/case" || exit 1
}
bake() { # ARGUMENTS: fails on any word
    iblbake -q $options "$@" || is 0 $? "$*: status"
}
singly() { # DIR [OPTIONS]: each map alone
    local to=$1 f
    shift
    for f in m/*; do iblbake -q $options "$f" -o "$to" "$@"; done
}
times() { find "$1" -type f -printf '%p %T@ %i\n' | sort; }

# ---- the tests -----------------------------------------------------------

test_same_bytes_as_single_bakes() {
    local n
    singly alone
    for n in 1 5; do
        bake m/* -o "many$n" -j $n
        diff -r alone "many$n"
    done
    # A map that is large is baked by all threads: as are few.
    bake m/sun.hdr m/mild.exr -o few -j 4
    diff -r alone few | grep -v '^Only in alone: map\|^Only in alone'
}

test_same_bytes_with_options() {
    local set options=
    for set in '--target three,babylon-env --size 16' \
        '--levels 2 --sun --verify --size 16 --lut-size 16' \
        '--only irradiance,skybox --skybox 8 --sh-format cmgen --irradiance-size 4'; do
        taken || continue
        # shellcheck disable=SC2086
        singly alone $set >/dev/null
        # shellcheck disable=SC2086
        bake m -o many $set >/dev/null
        diff -r alone many || echo "with $set"
        rm -rf alone many
    done
}

test_lists() {
    local how
    bake m -o wanted
    printf 'm/%s\r\n' sun.hdr mild.exr >some
    printf 'm/map%d.hdr\n\n' 1 2 >others
    bake --from some m/map?.hdr -o a
    bake --from - -o b < <(cat some others)
    bake --from <(find m -type f -print0) -o c
    bake m/sun.hdr m/mild.exr --from <(printf 'm/map1.hdr\nm/map2.hdr') -o d
    for how in a b c d; do diff -r wanted $how || echo "list $how"; done
    # Folders in a folder, a byte order mark and blank lines do not count.
    mkdir -p capitals/folder.hdr
    cp m/sun.hdr capitals/SUN.HDR
    printf '\xEF\xBB\xBFm/%s\n \t\n' sun.hdr >marked
    bake --from marked -o f
    there f/sun_specular.ktx2
    cp m/sun.hdr $'return.hdr\r'
    bake capitals --from <(printf 'return.hdr\r\0') -o e
    there e/{SUN,return}_specular.ktx2
    mkdir none
    touch none/notes.txt none/.hidden.hdr
    refused 1 '*none: is a directory without environments*' \
        iblbake none -o out
    : >empty
    refused 1 '*--from empty: names no environment' \
        iblbake --from empty -o out
    refused 1 '*--from gone: cannot be opened: No such file*' \
        iblbake --from gone -o out
    echo - >empty
    refused 1 '*-: standard input is one environment*' \
        iblbake --from empty -o out
}

test_names_that_collide() {
    mkdir n
    cp m/sun.hdr n
    refused 1 '*m/sun.hdr and n/sun.hdr: both would make the files of sun: *' \
        iblbake m/sun.hdr m/mild.exr n/sun.hdr -o out
    cp m/sun.hdr m/mild.hdr
    refused 1 '*m/mild.exr and m/mild.hdr: both would make *' \
        iblbake m -o out --keep-going
    # What one map is made of is not replaced by another's output.
    mkdir out
    cp m/sun.hdr out/sun_specular.ktx2
    refused 1 '*out/sun_specular.ktx2: would be replaced by *, an output: *' \
        iblbake -q m/sun.hdr out/sun_specular.ktx2 -o out
    rm -r out
    refused 1 '*m/sun.hdr and *m/sun.hdr: are one file: give it once' \
        iblbake m/sun.hdr "$PWD/m/sun.hdr" -o out
    # Nor are the outputs of an environment of the same name elsewhere.
    cp m/map1.hdr n/sun.hdr
    bake m/sun.hdr -o kept
    find kept -type f -exec cksum {} + >was
    refused 1 '*: kept/sun.json: was made from m/sun.hdr, and n/sun.hdr would *' \
        iblbake $options n/sun.hdr -o kept --incremental
    find kept -type f -exec cksum {} + | diff was -
    refused 1 '*--name: is for one environment, and these are 5: *' \
        iblbake m -o out --name x
}

test_failures() {
    local status f
    cp "$work/bad.hdr" m/n_bad.hdr
    cp "$work/bad.hdr" m/sic.hdr
    singly alone 2>/dev/null
    iblbake -q $options m -o many --keep-going 2>err
    status=$?
    is 1 $status status
    diff -r alone many
    sed 's/: .*//; s/.* failed$/&:/' err | sort -u >lines
    has 'n_bad.hdr: .*cut short' err
    is 'iblbake: 2 of 6 maps failed:
iblbake: failed: m/n_bad.hdr
iblbake: failed: m/sic.hdr' "$(tail -n 3 err)"
    iblbake -q -j 1 $options m/n_bad.hdr m/sun.hdr -o many --keep-going 2>err
    lines 3 err
    # Without it the first failure is the end, with one line of it.
    iblbake -q -j 1 $options m/map1.hdr m/n_bad.hdr m/sun.hdr -o first 2>err
    status=$?
    is 1 $status status
    lines 1 err
    there first/map1.json
    find first -name '*sun*' -o -name '.*tmp' | grep .
    refused 1 '*: m/sun.hdr: level 0 of specular has *: nothing was written' \
        iblbake -q $options -j 1 m/sun.hdr m/map1.hdr -o first \
        --max-error 1e-9
    iblbake $options m/mild.exr m/sun.hdr -o first --lights 9 2>err
    for f in m/mild.exr m/sun.hdr; do
        count 1 "^iblbake: warning: $f: .* light" err
    done
    : >file
    refused 1 'iblbake: file: is there and is no directory: *' \
        iblbake $options m -o file
    # One line of a pattern that fits no files, also if it is looked up twice.
    refused 1 '*: no_%f.hdr: no file has *' \
        iblbake --size 16 no_%f.hdr -o none --incremental --only specular
    # Nothing is left where nothing was done.
    iblbake -q $options m/n_bad.hdr gone.hdr -o none 2>err
    iblbake -q $options m/*_bad.hdr m/sic.hdr -o none --keep-going 2>err
    absent none
}

test_incremental() {
    sleep 0.05 # the grace, since m is a new copy
    bake m -o out --incremental
    singly alone
    diff -r -x .iblbake alone out
    times out >was
    iblbake $options -v m -o out --incremental 2>err
    has 'baked 0 maps, kept 4, 0 failed' err
    times out | diff was -
    # Another time is no change of contents.
    touch -d '2 hours ago' m/sun.hdr
    bake m -o out --incremental
    times out | diff was -
    # A change, an output that is gone, and one that another wrote.
    map_of 128 '\x80\x80\x80\x81' >m/map1.hdr
    rm out/map2_irradiance.ktx2
    echo >>out/mild.json
    iblbake $options -v m -o out --incremental 2>err
    has 'baked 3 maps, kept 1, 0 failed' err
    rm -r alone
    singly alone
    diff -r -x .iblbake alone out
    # A table that is gone, though no map is to be baked.
    touch -d '1 hour ago' m/map1.hdr
    sleep 0.05
    bake m -o out --incremental
    rm out/brdf_lut.ktx2
    iblbake $options -v m -o out --incremental 2>err
    has 'baked 0 maps, kept 4' err
    diff -r -x .iblbake alone out
}

test_incremental_options() {
    local set name options='--size 16 --lut-size 16'
    sleep 0.05 # the grace, since m is a new copy
    bake m/sun.hdr -o out --incremental
    for set in '--levels 1' '--exposure 1' '--rotate 10' '--verify' \
        '--name sun --only lut,specular,json'; do
        # shellcheck disable=SC2086
        iblbake $options -v m/sun.hdr -o out --incremental $set 2>err >printed
        has 'baked 1 maps, kept 0' err
        # shellcheck disable=SC2086
        iblbake -v $set $options -o out m/sun.hdr --incremental 2>err >printed
        has 'baked 0 maps, kept 1' err
    done
    # Each name has a record of its own.
    for name in one two one two; do
        iblbake $options -v m/sun.hdr -o named --incremental --name $name 2>err
    done
    has 'baked 0 maps, kept 1' err
    # What does not decide what is made.
    iblbake $options -v m/sun.hdr -o out --incremental -j 1 --sync $set 2>err
    has 'kept 1' err
    # A stamp that is none.
    rm out/.iblbake/sun.map && mkfifo out/.iblbake/sun.map
    timeout 300 iblbake -q $options m/sun.hdr -o out --incremental 2>err
    has 'out/.iblbake/sun.map: is a pipe' err
}

# Folders below a folder, whose outputs are in folders of the same names; the
# tables are made once. What has no map any more goes, and nothing else.
test_tree() {
    mkdir -p m/a/b m/.hidden
    cp m/sun.hdr m/.hidden/no.hdr
    mv m/map1.hdr m/a
    mv m/map2.hdr m/a/b
    cp m/a/map1.hdr m/a/sun.hdr
    ln -s .. m/a/loop
    sleep 0.05
    bake m -o flat
    is 2 "$(ls flat | grep -c json)" "sidecars of $(ls -m flat)"
    bake m -o out --recursive --incremental
    iblbake -q $options m/a/b/map2.hdr -o alone
    diff out/a/b alone | grep -v '"file": "\(../../\)*brdf_lut' | grep '^[<>]'
    has '"../../brdf_lut.ktx2"' out/a/b/map2.json
    is out/brdf_lut.ktx2 "$(find out -name 'brdf_lut*')"
    iblbake verify m/a/b/map2.hdr out/a/b >verdict || is 0 $? status
    has brdf_lut verdict
    iblbake $options -v m -o out --recursive --incremental 2>err
    has 'baked 0 maps, kept 5, 0 failed' err
    # Without --prune all stays.
    rm -r m/a/b m/sun.hdr
    echo >>out/sun.json # another's now
    bake m -o out --recursive --incremental
    there out/a/b/map2.json
    touch out/notes.txt
    iblbake $options m -o out --recursive --incremental --prune 2>err
    has 'kept 3, 0 failed, removed 1:' err
    has 'warning: out/sun.json: its map is gone, but it changed' err
    find out ! -name '.*' | sort >left
    grep 'map2\|out/a/b' left
    has out/a/sun.json left
    has out/notes.txt left
    has out/sun.json left
}

test_depfile() {
    local t=$'\t'
    cat >Makefile <<END
lit/sun.json: m/sun.hdr m/mild.exr
${t}iblbake -q $options m/sun.hdr m/mild.exr -o lit --incremental --depfile d
-include d
END
    make -s && make >said
    has 'up to date' said
    for f in lit/*; do
        make "$f" >said
        has "Nothing to be done\|up to date" said
    done
    for f in sun.hdr mild.exr; do
        iblbake -q $options m/$f -o lit --depfile one.d
        cat one.d
    done | diff - d
    # The rules of maps that are kept are those of maps that are baked.
    mv d baked
    make -s lit/sun.json -B
    diff baked d
    # It replaces no environment and no output, baked or kept.
    cp -r m was
    set -- iblbake $options m/sun.hdr m/mild.exr -o lit --keep-going
    for f in m/mild.exr m/sun.hdr; do
        refused 1 "*$f: is both input and output: *" "$@" --depfile $f
        refused 1 "*$f: is both input and output: *" \
            "$@" --incremental --depfile $f
    done
    diff -r was m
    for f in lit/sun.json lit/brdf_lut.ktx2; do
        refused 1 "*$f: is the name of another output too: *" \
            "$@" --incremental --depfile $f
    done
    refused 1 '*new/brdf_lut.ktx2: is the name of another output too: *' \
        iblbake $options m -o new --depfile new/brdf_lut.ktx2
    bake m/sun.hdr m/mild.exr -o new --depfile new/all.d
    has 'm/mild.exr$' new/all.d
    iblbake -q $options m/sun.hdr no_%f.hdr -o new --keep-going \
        --depfile new/rest.d 2>err
    has 'm/sun.hdr$' new/rest.d
    # Names that a depfile cannot hold, of a map that is kept.
    cp m/sun.hdr 'm/a;b.hdr'
    sleep 0.05
    bake 'm/a;b.hdr' -o odd --incremental
    refused 1 '*a;b*: has a ;, which make or ninja cannot read *' \
        iblbake $options 'm/a;b.hdr' -o odd --incremental --depfile odd.d
    absent odd.d
}

test_progress() {
    script -qec "iblbake -j 1 $options m -o out" log </dev/null >/dev/null
    tr '\r' '\n' <log >bars
    has '^maps  *\[#* *\] *[0-9]* %' bars
    iblbake -q $options m "$work/bad.hdr" -o out --keep-going --incremental \
        --progress json >events 2>/dev/null
    js <<'END'
const events = fs.readFileSync('events', 'utf8').trim().split('\n')
    .map(s => JSON.parse(s));
const maps = events.filter(e => e.event === 'map');
const [begin, end] = [events[0], events.at(-1)];
equal('begin', [begin.event, begin.maps, begin.kept, begin.pixels],
    ['begin', 5, 0, 2048 + 512 + 2 * 128]);
equal('maps', new Set(maps.map(e => e.map)).size, 5);
equal('done', maps.map(e => [e.done, e.maps]), maps.map((_, i) => [i + 1, 5]));
const failed = maps.filter(e => e.state === 'failed');
must('bad.hdr alone', failed.length === 1 && failed[0].error.includes('bad.hdr'),
    failed);
equal('end', [end.event, end.baked, end.failed], ['end', 4, 1]);
END
}

test_words_in_order() {
    local f
    iblbake $options m -o out --verify >printed 2>err
    has '^iblbake: baked 4 maps, kept 0, 0 failed: [0-9.]* s$' err
    [ $sanitized = no ] || return 0
    for f in m/*; do
        echo "$f"
        iblbake $options "$f" -o out --verify
        echo
    done >wanted
    diff wanted printed
    bake m -o out --verify -q 2>&1 | grep .
    iblbake $options m -o out --verify --progress json 2>&1 | grep -v '^{.*}$'
    iblbake $options -v m -o out 2>err
    for f in out/*.json out/*specular*; do
        has "^iblbake: wrote $f" err
    done
}

# Shards at once into one directory are one batch, each map in one of them.
test_shards() {
    local k n
    singly alone
    for n in 3; do
        for ((k = 1; k <= n; k++)); do
            iblbake $options m -o many$n --shard $k/$n --progress json >part$k &
        done
        wait
        diff -r alone many$n
        for ((k = 1; k <= n; k++)); do grep -h '"event":"map"' part$k; done |
            sed 's/.*"map":"\([^"]*\)".*/\1/' | sort | diff <(printf '%s\n' m/*) -
    done
    # What cannot be read is in some shard, too; the rest is baked.
    cp "$work/bad.hdr" m/z.hdr
    for k in 1 2; do
        iblbake -q $options m -o rest --keep-going --shard $k/2 2>err$k
    done
    diff -r alone rest
    cat err? >err
    count 1 'failed: m/z.hdr' err
    refused 1 '*--shard 6/6: there are 5 environments: take at most 5 shards' \
        iblbake m -o out --shard 6/6
}

# The files of a map are of one run: another gives its own no names meanwhile.
test_two_runs() {
    local run held
    sleep 0.05 # the grace, since m is a new copy
    bake m/sun.hdr -o one --levels 1
    bake m/sun.hdr -o two --levels 2
    bake m/sun.hdr -o out --incremental
    times out >was
    for held in out/.iblbake out; do # for stamps, and for files
        exec 8<$held
        flock -s 8
        for run in 1 2; do
            iblbake -q $options m/sun.hdr -o out --incremental --levels $run \
                8<&- &
        done
        if [ $held = out ]; then # by one of them, while the other waits for it
            within compgen -G 'out/.*tmp' ||
                echo "wanted out/.*tmp, found: $(ls -A out | xargs)"
            sleep 0.1
        else
            sleep 0.4
            is 2 "$(jobs -r | wc -l)" 'runs that wait'
        fi
        times out | grep -v tmp | diff was - || echo "of $held"
        exec 8<&-
        wait
        times out >was
    done
    ls -A out out/.iblbake | grep -i -e lock -e tmp
    # The stamp is that of the run whose files are there.
    for run in 1 2; do
        bake m/sun.hdr -o out --incremental --levels $run
    done
    diff -r -x .iblbake two out
    for run in {1..8}; do
        iblbake -q $options m/sun.hdr -o out --levels 1 &
        iblbake -q $options m/sun.hdr -o out --levels 2
        wait
        diff -rq -x .iblbake one out >/dev/null ||
            diff -rq -x .iblbake two out >/dev/null || echo "of $run: wanted one or two, found both"
    done
}

test_interrupted() {
    local status
    interrupt INT iblbake -q -j 2 m -o out --size 1024 --method sampled \
        --samples 1048576
    is 130 $status status
    find . -name '.*tmp' -o -name '*_specular*'
}

test_memory_is_planned() {
    local set most
    [ $sanitized = no ] || return 0
    ${CC:-cc} -o peak "$top/tests/cli/peak.c" || return
    mkenv hdr 1024 512 >sky.hdr
    while read -r set; do
        # shellcheck disable=SC2086
        ./peak iblbake sky.hdr -v -o out $set 2>err >printed ||
            is 0 $? "$set: $(cat err): status"
        awk -v what="with $set" '
            /plans .* MiB of memory/ { plan = 1024 * $3 }
            { peak = $1 }
            END {
                if (plan < peak || plan > 2.5 * peak)
                    print what ": planned " plan ", took " peak " KiB"
            }' err
    done <<'END'

--size 512 --lut-size 16
--skybox 512 --sun --lut-size 16
--size 512 --pixel rgba32f --only specular
--preview p.png --lut-size 16
--layout octahedral --size 256 --lut-size 16
--size 1024 --levels 2 --up z --lut-size 16
END
    # Bakes side by side wait for each other's memory.
    for set in a b c d; do cp sky.hdr m/$set.hdr; done
    for most in 100 200; do
        ./peak iblbake -q m -o out -j 4 --max-memory ${most}M 2>err ||
            is 0 $? "$(cat err): status"
        [ "$(tail -n 1 err)" -le $((most * 1024)) ] ||
            echo "found $(cat err) KiB, wanted $most MiB at most"
    done
}

test_memory_is_refused() {
    local i
    mkenv hdr 64 32 >sky.hdr
    bake sky.hdr -o lit --name large
    refused 1 '*sky.hdr: takes *, more than the 64 of --max-memory: ask for *' \
        iblbake sky.hdr -o out --size 1024 --max-memory 64M
    # 30480x15240 pixels of one colour: four times 240 runs in each scanline.
    { printf '\2\2\167\20'
      for i in 200 200 200 201; do printf "\\377\\$i%.0s" {1..240}; done; } >lines
    for ((i = 0; i < 14; i++)); do cat lines lines >more && mv more lines; done
    { printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 15240 +X 30480\n'
      cat lines; } >large.hdr
    refused 1 '*large.hdr: takes 6* MiB of memory, more than the 4096 of *' \
        iblbake large.hdr -o out --preview p.png --max-memory 4G
    refused 1 '*large.hdr: takes 5??? MiB *, more than the 4096 that *' \
        iblbake verify large.hdr lit --max-memory 4G
    iblbake -q sky.hdr -o big --size 512 --skybox 512 --only specular,skybox
    refused 1 '*big: takes 60 MiB *, more than the 40 of *judge fewer files*' \
        iblbake verify sky.hdr big --max-memory 40M
    refused 1 '*big/sky_skybox.ktx2: takes 17 MiB *, more than the 10 that *' \
        iblbake verify sky.hdr big --max-memory 10M
    # What begins as a map is not read for ever.
    refused 1 '*standard input: over 32 MiB, the most that is read of a stream*' \
        iblbake - -o out --max-memory 64M \
        < <(head -c 60 large.hdr; head -c 100M /dev/zero)
    echo '{"version": 1, "probes": [{"name": "a", "position": [0, 0, 0],
        "influence": {"sphere": {"centre": [0, 0, 0], "radius": 1}},
        "capture": {"equirect": "sky.hdr"}}]}' >set.json
    refused 1 '*set.json: takes *, more than the 64 of --max-memory: ask for *' \
        iblbake probes set.json -o out --size 1024 --max-memory 64M
}

for t in $(compgen -A function test_); do
    picked "$t" || continue
    fresh
    verdict "$t" "$($t 2>&1 | head -n 12)"
done
cd "$top"
end

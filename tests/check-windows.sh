#!/bin/bash
# SPDX-License-Identifier: MIT
# The program for Windows, as `make windows` packs it, by Wine: the cases of
# tests/cli, bakes of every instruction set beside those of the program that was
# built for this machine, tests of the library, and what Windows does in its own
# way.
set -u
. tests/lib.sh
need x86_64-w64-mingw32-gcc-posix wine mandoc zip unzip node
native=$build/iblbake
[ -x "$native" ] || { echo "$native: not built"; exit 1; }
# Its system is set up once.
export WINEPREFIX=$build/windows/wine WINEDEBUG=-all WINEDLLOVERRIDES=mscoree,mshtml=
packed windows
folder=$work/iblbake-$version-windows
unzip -q -d "$work" "$build/windows/iblbake-$version-windows.zip" || exit 1
exe=$folder/iblbake.exe
cat >"$work/iblbake" <<END
#!/bin/sh
exec wine '$exe' "\$@"
END
chmod +x "$work/iblbake"
win() { wine "$exe" "$@" </dev/null; }
wine cmd /c ver >"$work/log" 2>&1 </dev/null ||
    skip_all "Wine: $(tail -n 1 "$work/log")"

test_zip() {
    local file
    x86_64-w64-mingw32-objdump -p "$exe" "$folder/iblbake.dll" |
        sed -n 's/.*DLL Name: //p' | sort -u | grep -vixE 'kernel32.dll|msvcrt.dll'
    for file in manual/iblbake.1.html include/ibl/ibl.h include/ibl/ibl.hlsl \
        lib/libiblbake.a LICENSES-of-libraries.txt; do
        there "$folder/$file"
    done
    for file in $(cd "$top/man" && ls iblbake*); do
        there "$folder/manual/$file.html"
    done
}

# Those that make files or limits that Windows does not have are left out.
test_cases() {
    ONLY= PROGRAM=$work/iblbake BUILD=$build bash tests/check-cli.sh \
        >"$work/cases" 2>&1 || grep FAILED "$work/cases"
    grep -qE '^[1-9][0-9]+ passed' "$work/cases" || tail -n 1 "$work/cases"
}
export EXCEPT='unprivileged|mkfifo|ulimit|/dev/null|odd names'

# Halves differ by one step at most, of few.
test_same_as_native() {
    local isa file
    for isa in c sse2 avx2; do
        "$native" --isa $isa -q "$top/data/sky.exr" -o native/$isa --skybox 64 2>err ||
            { grep -q "no $isa" err && continue; }
        win --isa $isa -q "$top/data/sky.exr" -o windows/$isa --skybox 64
        for file in native/$isa/*.ktx2; do
            cmp -s "$file" "windows/${file#*/}" && continue
            js "$file" "windows/${file#*/}" <<'END'
const [a, b] = process.argv.slice(2).map(name => fs.readFileSync(name));
let most = 0, n = 0;
for (let i = 0; i + 1 < a.length; i += 2) {
    const by = Math.abs(a.readUInt16LE(i) - b.readUInt16LE(i));
    most = Math.max(most, by);
    n += by > 0;
}
if (a.length !== b.length || most > 1 || n > a.length / 2e4)
    console.log(`${process.argv[2]}: ${n} differ, by up to ${most} steps`);
END
        done
    done
}
test_targets() {
    local target
    for target in three babylon filament playcanvas; do
        "$native" -q --target $target --size 32 "$top/data/sky.exr" -o native &&
            win -q --target $target --size 32 "$top/data/sky.exr" -o windows
    done
    diff -rq native windows | grep -v '\.json'
}
test_c_tests() {
    local name
    for name in check_levels check_kern; do
        sh -c 'cd "$1" && sh packaging/windows.sh "$2" "$3" "tests/$4"' sh \
            "$top" "$build" "$version" $name >log 2>&1 || { tail -n 3 log; continue; }
        (cd "$top" && wine "$build/windows/tests/$name.exe" 2>&1) >log ||
            tail -n 5 log
        tail -n 1 log | grep -q '^[1-9].* 0 failed' || echo "$name: $(tail -n 1 log)"
    done
}
test_paths() {
    local name=$'\303\244 \346\227\245'
    mkdir "$name" && cp "$top/data/sky.exr" "$name/$name.exr"
    win -q "$name\\$name.exr" -o "out\\$name" --size 16 --depfile "out\\d.d"
    there "out/$name/${name}_specular.ktx2"
    grep -q "$name" "out/$name/$name.json" || cat "out/$name/$name.json"
    win -q "Z:$(pwd | tr / '\\')\\$name\\$name.exr" -o "Z:$PWD/drive" --size 16
    there "drive/${name}_specular.ktx2"
    win info -q "$name" >/dev/null
    # As a prompt hands them on.
    cp "$name/$name.exr" b.exr
    wine cmd /c "$(wine winepath -w "$exe") -q b*.exr -o out\\all --size 16" \
        >log 2>&1 || cat log
    there out/all/b_specular.ktx2
}
test_replace() {
    win -q "$top/data/forest.exr" -o out --name sky --size 32 --force 2>err ||
        win -q "$top/data/forest.exr" -o out --name sky --size 32
    cp -r out old
    # Others hold it for a moment, or for longer than the program waits.
    cat >hold.c <<'C'
#include <stdlib.h>
#include <windows.h>
int main(int argc, char **argv)
{
    HANDLE file = CreateFileA(argv[1], GENERIC_READ, FILE_SHARE_READ, NULL,
                              OPEN_EXISTING, 0, NULL);
    CreateDirectoryA("held", NULL);
    Sleep(atoi(argv[2]));
    return argc != 3 || file == INVALID_HANDLE_VALUE;
}
C
    x86_64-w64-mingw32-gcc-posix hold.c -o hold.exe
    wine hold.exe out/sky_specular.ktx2 600000 &
    within test -d held || echo 'not held'
    win -q "$top/data/forest.exr" -o out --name sky --size 16 2>err &&
        echo 'replaced what is held'
    has 'sky_specular.ktx2.*Permission denied' err
    lines 1 err
    cmp out/sky_specular.ktx2 old/sky_specular.ktx2
    kill $!
    wait $! 2>/dev/null
    rmdir held
    wine hold.exe out/sky_specular.ktx2 500 &
    within test -d held
    win -q "$top/data/forest.exr" -o out --name sky --size 16 || echo "status $?"
    cmp -s out/sky_specular.ktx2 old/sky_specular.ktx2 && echo 'not replaced'
    ls -A out | diff - <(ls -A old)
}
test_batch() {
    mkdir -p maps/sub
    cp "$top/data/sky.exr" maps && cp "$top/data/forest.exr" maps/sub
    set -- --incremental --size 16 --recursive maps -o out
    win -v "$@" >first 2>&1 || cat first
    there out/sub/forest_specular.ktx2
    find out -name '*.ktx2' -printf '%P %T@\n' | sort >before
    win -v "$@" >second 2>&1 || cat second
    find out -name '*.ktx2' -printf '%P %T@\n' | sort | diff before -
    cp "$top/data/forest.exr" maps/sky.exr
    win "$@" >third 2>&1 || cat third
    find out -name '*.ktx2' -printf '%P %T@\n' | sort | diff before - >changed
    grep -q sky_specular changed && ! grep -q forest changed || cat changed
}
test_stdin() {
    cat "$top/data/sky.exr" | wine "$exe" -q - -o out --size 16
    win -q "$top/data/sky.exr" -o file --size 16
    cmp out/env_specular.ktx2 file/sky_specular.ktx2
    # Names as `dir /b /s` lists them, and a batch of it.
    mkdir maps && cp "$top/data/sky.exr" maps/a.exr && cp maps/a.exr maps/b.exr
    printf 'maps\\a.exr\r\nmaps\\b.exr\r\n' |
        wine "$exe" -q --from - -o list --size 16
    there list/a_specular.ktx2 list/b_specular.ktx2
}
test_cannot_read() {
    refused 1 '*DWAB*save it with*' wine "$exe" "$top/data/studio.exr" -o out
    printf 'II*\0\10\0\0\0\0\0' >map.tif
    refused 1 '*TIFF*save it*' wine "$exe" map.tif -o out
}
test_commands() {
    cp "$top/data/sky.exr" .
    win -q sky.exr -o set --size 16
    win verify -q --max-error 1 sky.exr set || is 0 $? 'verify: status'
    win convert -q set/sky_specular.ktx2 a.dds
    "$native" convert -q set/sky_specular.ktx2 n.dds && cmp n.dds a.dds
    win info a.dds >said
    has '16' said
    cat >set.json <<'END'
{"version": 1, "defaults": {"size": 16, "levels": 3},
 "probes": [{"name": "a", "position": [0, 0, 0], "capture": {"equirect": "sky.exr"},
             "influence": {"sphere": {"centre": [0, 0, 0], "radius": 2}}}]}
END
    win probes -q set.json -o probes
    there probes/probes_specular.ktx2 probes/index.json
}
test_ctrl_c() {
    interrupt INT wine "$exe" "$top/data/sky.exr" -q -j 2 -o new/out --size 1024 \
        --method sampled --samples 1048576
    [ $status -ne 0 ] || echo 'status 0'
    within test ! -e new || ls -AR new
}
# The library from C, by the DLL and whole.
test_library() {
    cat >use.c <<'C'
#include <ibl/ibl.h>
#include <ibl/io.h>
#include <stdio.h>
int main(int argc, char **argv)
{
    ibl_ctx *ctx;
    ibl_image env;
    double sh[27];
    if (argc != 2 || ibl_ctx_create(NULL, &ctx) ||
        ibl_image_read(ctx, argv[1], NULL, &env, NULL) ||
        ibl_bake_sh(ctx, &env, 2, 0, sh))
        return 1;
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
    return !(sh[0] > 0);
}
C
    local by
    for by in -l:libiblbake.dll.a '-static -l:libiblbake.a'; do
        # shellcheck disable=SC2086
        x86_64-w64-mingw32-gcc-posix use.c -I"$folder/include" -L"$folder/lib" \
            $by -pthread -o use.exe && cp "$folder/iblbake.dll" . &&
            WINEPATH=$folder wine use.exe "$top/data/sky.exr" || echo "$by: $?"
    done
}
# CPU of a bake that computes, the least of three in turns: Wine's own files and
# memory are no measure of those of Windows.
test_speed() {
    local i t
    set -- -q -j 1 --method sampled --size 256 --only specular
    TIMEFORMAT=%U
    for i in 1 2 3; do
        t=$({ time "$native" "$@" "$top/data/sky.exr" -o n; } 2>&1) && echo "n $t"
        t=$({ time win "$@" "$top/data/sky.exr" -o w; } 2>&1) && echo "w $t"
        t=$({ time win --version >/dev/null; } 2>&1) && echo "s $t"
    done >times
    awk '{ if (!($1 in t) || $2 < t[$1]) t[$1] = $2 }
        END { ratio = (t["w"] - t["s"]) / t["n"]
            if (ratio > 1.3) print "takes " ratio " times as long" }' times
}

for t in $(compgen -A function test_); do
    picked "$t" || continue
    mkdir "$work/case" && cd "$work/case" || exit 1
    [ $t = test_cases ] && cd "$top"
    verdict "$t" "$($t 2>&1 | head -n 12)"
    cd "$top" && rm -rf "$work/case"
done
end

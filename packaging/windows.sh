#!/bin/sh
# SPDX-License-Identifier: MIT
# windows.sh BUILD VERSION: builds for Windows on x86-64 in BUILD/windows and
# packs BUILD/windows/iblbake-VERSION-windows.zip.
# windows.sh BUILD VERSION TARGET...: makes these there, as tests/check_kern.
set -eu
top=$PWD name=iblbake-$2-windows
mkdir -p "$1/windows/deps"
build=$(cd "$1/windows" && pwd) deps=$build/deps
machine=x86_64-w64-mingw32
export CC=$machine-gcc-posix AR=$machine-ar
export PKG_CONFIG_LIBDIR=/nowhere # that of this system
[ "$deps/libdeps.a" -nt packaging/libraries.sh ] ||
    CFLAGS=-O2 sh packaging/libraries.sh "$1/sources" "$deps"
$AR rcs "$deps/libdl.a" # dlopen() is in no library here
echo '1 24 "packaging/windows.manifest"' | $machine-windres -o "$build/manifest.o"

# gcc does not align the stack to 32 bytes on Windows, and AVX's moves want that
# unless the assembler takes others. Threads get the stack that POSIX's have.
run_make() {
    make -s -j"$(nproc)" DEPS=no BUILD="$build" PORT=windows CC=$CC AR=$AR \
        DEFLATE=libdeflate LINKER= IO_LIBS="$deps/libdeps.a" BIN="$build/iblbake.exe" \
        CPPFLAGS="-I$deps/include -D__USE_MINGW_ANSI_STDIO=1 \
            -D__USE_MINGW_ACCESS -D_FILE_OFFSET_BITS=64 \
            -D_POSIX_THREAD_SAFE_FUNCTIONS \
            -include src/port/windows.h" \
        CFLAGS='-O2 -DNDEBUG -Werror=implicit-function-declaration -Wno-format \
            -Wno-format-extra-args -Wno-conversion -Wno-float-conversion -Wno-undef \
            -Wa,-muse-unaligned-vector-move' \
        LDFLAGS="-static -Wl,--stack,8388608 -L$deps" LDLIBS="$build/manifest.o" \
        "$@"
}
if [ $# -gt 2 ]; then
    shift 2
    run_make "$build/libiblbake.a"
    for target; do
        run_make ISA='-Itests/windows -include tests/windows/sys/mman.h' \
            "$build/$target"
    done
    exit
fi
run_make "$build/iblbake.exe" "$build/libiblbake.a" "$build/gen/ibl.hlsl"

rm -rf "$build/$name" "$build/$name.zip"
mkdir -p "$build/$name/include/ibl" "$build/$name/lib" "$build/$name/manual"
cd "$build/$name"
cp "$build/iblbake.exe" .
$machine-strip iblbake.exe
cp "$top/LICENSE" LICENSE.txt
cp "$top/NEWS.md" NEWS.txt
cp "$deps/licences.txt" LICENSES-of-libraries.txt
cp "$top"/include/ibl/*.h "$top"/include/ibl/*.glsl "$build/gen/ibl.hlsl" \
    include/ibl
# The library as a DLL, with what compilers link it by, and whole.
{ echo EXPORTS; cat "$top/tests/symbols.txt"; } >lib/iblbake.def
$CC -static -shared -s -o iblbake.dll lib/iblbake.def \
    -Wl,--out-implib,lib/libiblbake.dll.a -Wl,--whole-archive \
    "$build/libiblbake.a" -Wl,--no-whole-archive "$deps/libdeps.a"
printf 'create lib/libiblbake.a\naddlib %s\naddlib %s\nsave\n' \
    "$build/libiblbake.a" "$deps/libdeps.a" | $AR -M
for page in "$top"/man/iblbake*.[17]; do
    mandoc -Thtml -Oman=%N.%S.html "$page" >"manual/${page##*/}.html"
done
cd ..
find "$name" -exec touch -d "$(date -R -r "$top/NEWS.md")" {} +
zip -q -X -r "$name.zip" "$name"
rm -r "$name"
ls -l "$build/$name.zip" | sed "s|$top/||"

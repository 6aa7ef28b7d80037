#!/bin/sh
# SPDX-License-Identifier: MIT
# libraries.sh SOURCES OUT: builds the libraries that the program reads and
# writes files with, for a system that Debian has no packages of, by CC, AR and
# CFLAGS: headers in OUT/include, all objects in OUT/libdeps.a, and what their
# licences ask to be told in OUT/licences.txt. The sources are those of Debian,
# with its patches where they are served, unpacked in SOURCES.
set -eu
mkdir -p "$1" "$2/include" "$2/obj"
sources=$(cd "$1" && pwd)
out=$(cd "$2" && pwd)

# ---- sources: NAME_VERSION ---------------------------------------------------

cd "$sources"
exec 9>lock # others may want them at the same time
flock 9
mkdir -p apt/parts apt/lists/partial
apt() {
    # shellcheck disable=SC2086
    "$@" -o Dir::Etc::sourcelist=/dev/null -o Dir::Etc::sourceparts="$sources/apt/parts" \
        -o Dir::State::lists="$sources/apt/lists" -o APT::Sandbox::User=root
}
fetch() { # NAME_VERSION
    name=${1%_*} version=${1#*_}
    [ ! -d "$name" ] || return 0
    [ -s apt/parts/source.list ] || {
        apt-get indextargets --format 'deb-src $(REPO_URI) $(RELEASE) $(COMPONENT)' \
            'Created-By: Packages' 'Origin: Debian' >apt/parts/source.list
        apt apt-get update -qq || true
    }
    # Of a patched version a mirror may have the release alone, or neither.
    for full in $(apt apt-cache showsrc "$name" | sed -n 's/^Version: //p' |
        grep -F "$version" | sort -ruV); do
        apt apt-get source -qq --only-source --download-only "$name=$full" 2>>log ||
            apt apt-get source -qq --only-source --download-only --tar-only \
                "$name=$full" 2>>log || continue
        dsc=${name}_${full#*:}.dsc
        if [ -e "$dsc" ] && [ -e "${dsc%.dsc}.debian.tar.xz" ]; then
            dpkg-source --no-check -x "$dsc" "$name.new" >>log
        else
            echo "libraries: $name $version without Debian's patches," \
                'which are not served' >&2
            mkdir -p "$name.new"
            tar -x -C "$name.new" --strip-components=1 -f "$(ls "$name"_*.orig.tar.*)"
        fi
        mv "$name.new" "$name"
        return 0
    done
    echo "libraries: no source of $name $version: see $sources/log" >&2
    exit 1
}
for entry in zlib_1.2.13 libdeflate_1.14 libzstd_1.5.4 jansson_2.14 \
    libpng1.6_1.6.39 libjpeg-turbo_2.1.5 xxhash_0.8.1 imath_3.1.6 openexr_3.1.5; do
    fetch $entry
done
exec 9>&-

for name in */; do
    for text in "$name"LICENSE* "$name"COPYING* "$name"README.ijg; do
        [ ! -f "$text" ] || { printf '==== %s\n\n' "$text"; cat "$text"; echo; }
    done
done >"$out/licences.txt"

# ---- what their own builds would find out ------------------------------------

cd "$out/include"
cp "$sources"/zlib/z*.h "$sources"/libdeflate/libdeflate.h \
    "$sources"/libzstd/lib/zstd*.h "$sources"/jansson/src/jansson.h \
    "$sources"/libpng1.6/png*.h "$sources"/libjpeg-turbo/j*.h \
    "$sources"/xxhash/xxhash.h "$sources"/imath/src/Imath/*.h \
    "$sources"/openexr/src/lib/OpenEXRCore/openexr*.h .
cp "$sources/libpng1.6/scripts/pnglibconf.h.prebuilt" pnglibconf.h
sed 's/@json_inline@/inline/; s/@json_have_[a-z_]*@/1/' \
    "$sources/jansson/src/jansson_config.h.in" >jansson_config.h
sed -E 's/@JPEG_LIB_VERSION@/62/; s/@BITS_IN_JSAMPLE@/8/; s/@[A-Z_]*@/0/
    s/#cmakedefine ([CDM].*)/#define \1/; s/#cmakedefine ([A-Z_]*).*/#undef \1/' \
    "$sources/libjpeg-turbo/jconfig.h.in" >jconfig.h
sed 's/@BUILD@/0/; s/@INLINE@/inline/; s/@THREAD_LOCAL@/_Thread_local/
    s/@SIZE_T@/__SIZEOF_SIZE_T__/; s/#cmakedefine/#undef/; s/@[A-Z_]*@//' \
    "$sources/libjpeg-turbo/jconfigint.h.in" >jconfigint.h
sed 's/@[A-Z_]*@/0/' "$sources/libjpeg-turbo/jversion.h.in" >jversion.h
for config in imath/config/ImathConfig openexr/cmake/OpenEXRConfig; do
    sed -E 's/#cmakedefine01 (.*)/#define \1 1/; s/#cmakedefine ([A-Z_]*).*/#undef \1/
        s/@[A-Za-z_]*@/0/' "$sources/$config.h.in" >"${config##*/}.h"
done
printf '#define HAVE_%s 1\n' ATOMIC_BUILTINS LOCALE_H STDINT_H SYS_TIME_H \
    SYS_TYPES_H UNISTD_H >jansson_private_config.h
ln -sfn . OpenEXR
echo '#define ILMTHREAD_THREADING_ENABLED 1' >IlmThreadConfig.h

# ---- objects -----------------------------------------------------------------

compile() { # FOLDER OPTIONS FILE...
    folder=$sources/$1 options=$2
    shift 2
    for file; do
        object=$out/obj/$(echo "${folder##*/}-$file" | tr / -).o
        [ "$object" -nt "$folder/$file" ] ||
            echo "$options -o '$object' '$folder/$file'"
    done
}
inside() { # FOLDER PATTERN...: names of files there
    (cd "$sources/$1" && shift && eval ls "$@")
}
{
    # shellcheck disable=SC2046
    compile zlib '' adler32.c compress.c crc32.c deflate.c inffast.c inflate.c \
        inftrees.c trees.c uncompr.c zutil.c infback.c
    compile libdeflate/lib '' adler32.c deflate_decompress.c utils.c \
        zlib_decompress.c x86/cpu_features.c
    compile libzstd/lib '-DZSTD_DISABLE_ASM -DXXH_NAMESPACE=ZSTD_' \
        $(inside libzstd/lib common/*.c compress/*.c decompress/*.c)
    compile jansson/src "-DHAVE_STDINT_H" $(inside jansson/src '*.c')
    compile libpng1.6 '-DPNG_INTEL_SSE_OPT=0' $(inside libpng1.6 'png*.c' | grep -v pngtest)
    # What decodes.
    compile libjpeg-turbo '' $(sed -n '/^set(JPEG_SOURCES/,/)/{
        s/.*SOURCES//; s/)//; p; }' "$sources/libjpeg-turbo/CMakeLists.txt" |
        tr ' ' '\n' | grep -vE '^j(c[^o]|fdct)') jaricom.c jdarith.c jsimd_none.c
    compile xxhash '' xxhash.c
    compile openexr/src/lib/OpenEXRCore '' \
        $(inside openexr/src/lib/OpenEXRCore '*.c')
} | xargs -r -P "$(nproc)" -L 1 $CC -I"$out/include" $CFLAGS -w -c
rm -f "$out/libdeps.a"
$AR rcs "$out/libdeps.a" "$out"/obj/*.o

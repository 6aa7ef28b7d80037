#!/bin/bash
# SPDX-License-Identifier: MIT
# The library and the program for aarch64, built by Debian's cross compiler
# against Debian's own arm64 packages and run by qemu-user: the kernels, and
# bakes and containers that are byte for byte those of this machine's build.
# BUILD names that build; what is fetched and built is in BUILD/arm64.
# `check-arm64.sh count MAP` counts the instructions of a bake instead, by plain C
# and by NEON.
set -u
. tests/lib.sh

packages='libc6-dev libopenexr-dev libdeflate-dev libzstd-dev libpng-dev
libjpeg-dev libjansson-dev libxxhash-dev'
arm=$build/arm64
sysroot=$arm/sysroot

need aarch64-linux-gnu-gcc qemu-aarch64 apt-get dpkg-deb

# An apt of its own: nothing of the system is changed, and no root is needed.
apt() { APT_CONFIG=$work/apt.conf apt-get -qq "$@"; }
fetch() {
    local state=$work/apt file
    mkdir -p "$state/lists/partial" "$state/cache/archives/partial"
    touch "$state/status"
    cat >"$work/apt.conf" <<END
APT::Architecture "arm64";
APT::Architectures { "arm64"; };
APT::Install-Recommends "false";
APT::Sandbox::User "";
Debug::NoLocking "true";
Dir::State "$state";
Dir::State::status "$state/status";
Dir::Cache "$state/cache";
END
    # shellcheck disable=SC2086
    apt update && apt install --download-only -y $packages || return 1
    rm -rf "$sysroot"
    mkdir -p "$sysroot"
    for file in "$state"/cache/archives/*.deb; do
        dpkg-deb -x "$file" "$sysroot" || return 1
    done
    find "$sysroot" -type l -lname '/*' | while read -r file; do
        ln -snf "$sysroot$(readlink "$file")" "$file"
    done
    # shellcheck disable=SC2086
    echo $packages >"$sysroot/fetched"
}
# shellcheck disable=SC2086
if [ "$(cat "$sysroot/fetched" 2>/dev/null)" != "$(echo $packages)" ]; then
    fetch >"$work/fetch" 2>&1 ||
        skip_all "no arm64 packages: $(tail -n 1 "$work/fetch")"
fi

compile() { # TARGET...
    PKG_CONFIG_SYSROOT_DIR=$sysroot \
        PKG_CONFIG_LIBDIR=$sysroot/usr/lib/aarch64-linux-gnu/pkgconfig \
        make -s "-j$(nproc)" DEPS=no BUILD="$arm" CFLAGS='-O2 -DNDEBUG' \
        CPPFLAGS=-DTEST_SANITIZED=1 WERROR=-Werror LINKER= \
        CC="aarch64-linux-gnu-gcc --sysroot=$sysroot" "$@" >&2 ||
        { verdict build 'it does not compile'; end; exit 1; }
}
emulate() { qemu-aarch64 -L "$sysroot" "$@"; }

if [ "${1:-}" = count ]; then
    compile "$arm/iblbake"
    gcc -O2 -shared -fPIC -o "$work/count.so" tests/count_instructions.c
    for isa in c neon; do
        emulate -plugin "$work/count.so" "$arm/iblbake" -q --threads 1 \
            --isa $isa -o "$work/$isa" "$2" 2>&1 | sed "s/^/$isa: /"
    done
    exit
fi

# Tests of all versions of the kernels. Others need minutes for a truth in
# emulated long doubles: the bakes judge those sums.
kernels='check_kern check_pixel'
# shellcheck disable=SC2046
compile "$arm/iblbake" "$arm/tests/write_textures" \
    $(for test in $kernels; do echo "$arm/tests/$test"; done)
make -s DEPS=no BUILD="$build" "$build/tests/write_textures" >&2

case $(emulate "$arm/iblbake" --version) in
*'instructions  neon'*) verdict chosen ;;
*) verdict chosen 'NEON is not what auto takes' ;;
esac
for test in $kernels; do
    ok "$test" emulate "$arm/tests/$test"
done

# ---- containers ------------------------------------------------------------

mkdir "$work/arm" "$work/here"
ok 'containers by NEON' emulate "$arm/tests/write_textures" "$work/arm"
ok 'containers here' "$build/tests/write_textures" "$work/here"
ok containers diff -r "$work/here" "$work/arm"

# ---- bakes -----------------------------------------------------------------

# The same files from both machines: those of AVX2 and NEON, and those of plain C.
same() { # ISA_HERE ISA_THERE MAP [OPTION...]
    local here=$1 there=$2
    shift 2
    rm -rf "$work/here" "$work/there"
    ok "$* by $here" "$build/iblbake" -q --isa "$here" --lut-size 32 "$@" \
        -o "$work/here"
    ok "$* by $there" emulate "$arm/iblbake" -q --isa "$there" --lut-size 32 \
        "$@" -o "$work/there"
    ok "$*: $here and $there" diff -r "$work/here" "$work/there"
}
case $("$build/iblbake" --version) in
*'instructions  avx2'*)
    same avx2 neon data/forest.exr --size 64 --skybox 64 --pixel rgba32f
    same avx2 neon data/sky.exr --size 32 --lobe charlie --pixel rgba32f \
        --layout equirect
    same avx2 neon data/forest.exr --size 32 --method sampled --samples 64
    same avx2 neon data/sky.exr --size 48 --sh 3 --pixel bc6h --quality fast
    ;;
*) verdict 'AVX2 and NEON' 'skipped: this CPU has no AVX2' ;;
esac
same c c data/sky.exr --size 32 --pixel rgba32f
ok '3 threads' emulate "$arm/iblbake" -q --isa c --threads 3 --lut-size 32 \
    data/sky.exr --size 32 --pixel rgba32f -o "$work/three"
ok '3 threads' diff -r "$work/there" "$work/three"
end

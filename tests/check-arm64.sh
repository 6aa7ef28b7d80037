#!/bin/bash
# SPDX-License-Identifier: MIT
# The library and the program for aarch64, built by Debian's cross compiler
# against Debian's own arm64 packages and run by qemu-user: the kernels, bakes
# whose texels are those of this machine's build, and containers that are so byte
# for byte. BUILD names that build; what is fetched and built is in BUILD/arm64.
# `check-arm64.sh count MAP` counts the instructions of a bake instead, by plain C
# and by NEON.
set -u
. tests/lib.sh

packages='libc6-dev libopenexr-dev libdeflate-dev libzstd-dev libpng-dev
libjpeg-dev libjansson-dev libxxhash-dev'
arm=$build/arm64
sysroot=$arm/sysroot

need aarch64-linux-gnu-gcc qemu-aarch64 apt-get dpkg-deb node

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
        CPPFLAGS=-DTEST_SANITIZED=1 WERROR=-Werror \
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

# Tests of all versions of the kernels. Those left out show nothing of NEON, or,
# as the others of check_kern_legendre, take minutes for a truth in emulated long
# doubles: the bakes judge those sums.
sums=gather,angles,weights,rows,points,lights,spread,legendre_coefficients
sums=$sums,legendre_values,near_the_pole,brdf_sums,mix,reflection
kernels="check_kern check_kern_fft check_kern_sums:$sums check_kern_legendre:rows
check_pixel"
# shellcheck disable=SC2046
compile "$arm/iblbake" "$arm/tests/write_textures" \
    $(for test in $kernels; do echo "$arm/tests/${test%%:*}"; done)
make -s DEPS=no BUILD="$build" "$build/tests/write_textures" >&2

case $(emulate "$arm/iblbake" --version) in
*'instructions  neon'*) verdict chosen ;;
*) verdict chosen 'NEON is not what auto takes' ;;
esac
for test in $kernels; do
    name=${test%%:*} cases=${test#"$name"}
    cases=${cases#:}
    # shellcheck disable=SC2086
    ok "$name" emulate "$arm/tests/$name" ${cases//,/ }
done

# ---- containers ------------------------------------------------------------

mkdir "$work/arm" "$work/here"
ok 'containers by NEON' emulate "$arm/tests/write_textures" "$work/arm"
ok 'containers here' "$build/tests/write_textures" "$work/here"
ok containers diff -r "$work/here" "$work/arm"

# ---- bakes -----------------------------------------------------------------

bake() { # FOLDER RUN... : bakes as floats into it
    local folder=$work/$1
    shift
    "$@" -q --pixel rgba32f --lut-size 32 --size 64 --skybox 64 \
        -o "$folder" --name map
}
# Files whose texels are farther apart than 1e-5 of themselves or of their
# level's mean, and files with the same texels that differ.
compare() { # FOLDER FOLDER
    js "$@" <<'END'
const texels = bytes => {
    const levels = Math.max(bytes.readUInt32LE(40), 1), all = [];
    for (let i = 0; i < levels; i++) {
        const at = Number(bytes.readBigUInt64LE(80 + 24 * i));
        const size = Number(bytes.readBigUInt64LE(88 + 24 * i));
        all.push(new Float32Array(bytes.buffer.slice(
            bytes.byteOffset + at, bytes.byteOffset + at + size)));
    }
    return all;
};
const [one, two] = process.argv.slice(2);
const names = fs.readdirSync(one).filter(name => name.endsWith('.ktx2'));
if (names.length < 4 || `${fs.readdirSync(two)}` != `${fs.readdirSync(one)}`)
    console.log(`${fs.readdirSync(one)} and ${fs.readdirSync(two)}`);
for (const name of names) {
    const a = fs.readFileSync(`${one}/${name}`);
    const b = fs.readFileSync(`${two}/${name}`);
    let differs = 0, worst = 0;
    const others = texels(b);
    texels(a).forEach((level, i) => {
        const mean = level.reduce((sum, x) => sum + Math.abs(x), 0) /
            level.length;
        level.forEach((x, k) => {
            const off = Math.abs(x - others[i][k]);
            differs += !(off == 0);
            worst = Math.max(worst, off / Math.max(Math.abs(x), mean));
        });
    });
    if (!(worst <= 1e-5))
        console.log(`${name}: ${worst} apart`);
    if (!differs && a.compare(b))
        console.log(`${name}: the texels are the same, the file is not`);
}
END
}
for env in data/sky.exr data/forest.exr; do
    name=$(basename $env)
    rm -rf "$work/here" "$work/c" "$work/neon" "$work/three"
    ok "$name here" bake here "$build/iblbake" $env
    ok "$name by NEON" bake neon emulate "$arm/iblbake" --threads 1 $env
    verdict "$name" "$(compare "$work/here" "$work/neon")"
done
ok 'plain C' bake c emulate "$arm/iblbake" --isa c $env
verdict 'plain C' "$(compare "$work/here" "$work/c")"
ok '3 threads' bake three emulate "$arm/iblbake" --threads 3 $env
ok '3 threads' diff -r "$work/neon" "$work/three"
end

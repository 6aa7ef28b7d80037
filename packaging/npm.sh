#!/bin/sh
# SPDX-License-Identifier: MIT
# npm.sh BUILD VERSION: builds the package of npm in BUILD/npm, by emscripten and
# the libraries of libraries.sh.
set -eu
export NODE_PATH=/usr/share/nodejs # where Debian's emcc finds what it needs
export PKG_CONFIG_LIBDIR=/nowhere # that of this system
wasm=$1/wasm package=$1/npm/package
# The compiler itself: emcc takes half a second to call it.
cc="clang $(emcc --cflags)"
flags='-Os -msimd128 -mbulk-memory -DNDEBUG'
CC=$cc AR=emar CFLAGS="$flags -DZSTD_NO_INLINE -DHUF_FORCE_DECOMPRESS_X1 \
    -DZSTD_FORCE_DECOMPRESS_SEQUENCES_SHORT" sh packaging/libraries.sh "$1/sources" "$wasm/deps"
${MAKE:-make} -s -j"$(nproc)" DEPS=no PORT=wasm BUILD="$wasm" PORT_FLAGS= CC="$cc" AR=emar \
    CFLAGS="$flags" HOT=-O3 CPPFLAGS="-isystem $wasm/deps/include" \
    DEFLATE=libdeflate WARN=-w CWARN= "$wasm/iblbake.wasm"
rm -rf "$package"
mkdir -p "$package/bin"
cp src/npm/index.mjs src/npm/index.d.ts src/npm/system.mjs src/npm/memory.mjs \
    src/npm/worker.mjs src/npm/README.md LICENSE "$wasm/iblbake.wasm" "$package"
cp src/npm/iblbake.cjs "$package/bin"
cp "$wasm/deps/licences.txt" "$package/LICENSES-of-libraries.txt"
chmod 755 "$package/bin/iblbake.cjs"
sed "s/@VERSION@/$2/" src/npm/package.json.in >"$package/package.json"
cd "$1/npm"
npm pack --silent ./package

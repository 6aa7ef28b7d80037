#!/bin/sh
# SPDX-License-Identifier: MIT
# npm.sh BUILD VERSION: builds the package of npm in BUILD/npm, by emscripten.
set -eu
export NODE_PATH=/usr/share/nodejs # where Debian's emcc finds what it needs
export PKG_CONFIG_LIBDIR=/nowhere # that of this system
package=$1/npm/package lib=$(em-config CACHE)/sysroot/lib/wasm32-emscripten
# The compiler itself: emcc takes half a second to call it.
cc="clang $(emcc --cflags)" flags='-Os -msimd128 -mbulk-memory -DNDEBUG'
build() { # OUT LDLIBS FLAGS: OUT/iblbake.wasm
    CC="$cc $3" AR=emar CFLAGS="$flags -DZSTD_NO_INLINE -DHUF_FORCE_DECOMPRESS_X1 \
        -DZSTD_FORCE_DECOMPRESS_SEQUENCES_SHORT" \
        sh packaging/libraries.sh "${1%/*}/sources" "$1/deps"
    ${MAKE:-make} -s -j"$(nproc)" DEPS=no PORT=wasm BUILD="$1" PORT_FLAGS= CC="$cc $3" AR=emar \
        CFLAGS="$flags" HOT=-O3 CPPFLAGS="-isystem $1/deps/include" LDLIBS="$2" \
        DEFLATE=libdeflate WARN=-w CWARN= "$1/iblbake.wasm"
}
build "$1/wasm" '' '' # for pages, of one thread
# emcc links threads only with a host of its own: what to link is named here.
build "$1/threads" "-sIMPORTED_MEMORY -nostdlib $lib/crt1.o $lib/crtbegin.o \
    -lstandalonewasm-memgrow -lstubs -lc-mt -ldlmalloc-mt -lcompiler_rt-mt -Wl,--shared-memory \
    -Wl,--no-check-features,--export=_emscripten_thread_init,--export=_emscripten_thread_exit \
    -Wl,--export=_emscripten_thread_free_data,--export=emscripten_tls_init" '-pthread -matomics'
rm -rf "$package"
mkdir -p "$package/bin"
cp src/npm/index.mjs src/npm/index.d.ts src/npm/system.mjs src/npm/memory.mjs \
    src/npm/worker.mjs src/npm/README.md LICENSE "$1/wasm/iblbake.wasm" "$package"
cp "$1/threads/iblbake.wasm" "$package/threads.wasm"
cp src/npm/iblbake.cjs "$package/bin"
cp "$1/wasm/deps/licences.txt" "$package/LICENSES-of-libraries.txt"
chmod 755 "$package/bin/iblbake.cjs"
sed "s/@VERSION@/$2/" src/npm/package.json.in >"$package/package.json"
cd "$1/npm"
npm pack --silent ./package

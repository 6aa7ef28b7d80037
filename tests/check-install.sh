#!/bin/bash
# SPDX-License-Identifier: MIT
# Installs into an empty root and uses what is there as a user would: the
# program, the man page, the library from C and from C++ through pkg-config,
# then uninstalls and finds nothing left.
set -u
. tests/lib.sh
prefix=$work/usr
# By the name that it was built by, or all would be built anew.
make=(make --no-print-directory DEPS=no BUILD="${BUILD:-build}" PREFIX="$prefix")
ok install "${make[@]}" install
ok version "$prefix/bin/iblbake" --version
ok bake "$prefix/bin/iblbake" -q data/sky.exr -o "$work/out" --size 16
ok bridge "$prefix/bin/iblbake" -q data/studio.exr -o "$work/out" --size 16
ok manual man -l "$prefix/share/man/man1/iblbake.1"
ok verify-manual man -l "$prefix/share/man/man1/iblbake-verify.1"
ok method-manual man -l "$prefix/share/man/man7/iblbake-method.7"
for f in probes.glsl ibl.glsl ibl.hlsl; do
    ok "$f" test -s "$prefix/include/ibl/$f"
done

if [ -x "$build/iblview" ]; then
    ok view-manual man -l "$prefix/share/man/man1/iblview.1"
    ok view "$prefix/bin/iblview" "$work/out/sky_specular.ktx2" --texel 0,0
    ok view-bridge "$prefix/bin/iblview" data/studio.exr --texel 0,0
else
    skipped=1
    echo 'skipped iblview, which was not built'
    ok no-view-manual test ! -e "$prefix/share/man/man1/iblview.1"
fi

export PKG_CONFIG_PATH=$prefix/lib/pkgconfig
cat >"$work/use.c" <<'C'
#include <ibl/ibl.h>
#include <ibl/io.h>
#include <stdio.h>
int main(int argc, char **argv)
{
    ibl_ctx *ctx;
    ibl_image env;
    double sh[27];
    if (argc != 2 || ibl_ctx_create(NULL, &ctx))
        return 1;
    if (ibl_image_read(ctx, argv[1], NULL, &env, NULL) ||
        ibl_bake_sh(ctx, &env, 2, 0, sh))
        return 1;
    printf("%g\n", sh[0]);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
    return !(sh[0] > 0);
}
C
cp "$work/use.c" "$work/use.cpp"
flags() { pkg-config "$@" iblbake; }
ok c sh -c "cc '$work/use.c' -o '$work/use' $(flags --cflags --libs)"
ok c-runs "$work/use" data/sky.exr
ok c-bridge "$work/use" data/studio.exr
ok c++ sh -c "c++ '$work/use.cpp' -o '$work/use++' $(flags --cflags --libs)"
ok c++-runs "$work/use++" data/sky.exr

# The bake alone needs nothing but the C library, as does our own .hdr code.
cat >"$work/alone.c" <<'C'
#include <ibl/ibl.h>
int main(void)
{
    ibl_ctx *ctx;
    ibl_cube cube;
    float white[6] = {1, 1, 1, 1, 1, 1};
    ibl_image env = {2, 1, white};
    ibl_specular_options opts = ibl_specular_options_default();
    opts.size = 8;
    if (ibl_ctx_create(NULL, &ctx) ||
        ibl_bake_specular(ctx, &env, &opts, &cube))
        return 1;
    ibl_cube_free(&cube);
    ibl_ctx_free(ctx);
    return 0;
}
C
ok alone cc "$work/alone.c" -o "$work/alone" -I"$prefix/include" \
    "$prefix/lib/libiblbake.a" -lm -pthread
ok alone-runs "$work/alone"

# make names packages that are missing, and installs none.
mkdir "$work/bin"
printf '#!/bin/sh\necho absent\n' >"$work/bin/dpkg-query"
printf '#!/bin/sh\n: >"%s/called"\n' "$work" >"$work/bin/apt-get"
cp "$work/bin/apt-get" "$work/bin/sudo"
chmod +x "$work"/bin/*
says=$(PATH=$work/bin:$PATH env -u DEPS -u MAKEFLAGS make BUILD="$work/none" 2>&1) && says=built
case $says in
*libzstd-dev*'"make deps" installs'*) verdict make-names-packages ;;
*) verdict make-names-packages "$says" ;;
esac
ok make-changes-nothing test ! -e "$work/called" -a ! -e "$work/none"

ok uninstall "${make[@]}" uninstall
left=$(find "$prefix" -type f)
ok nothing-left test -z "$left"
# The library remembers the PREFIX: back to the default one.
ok as-before make -s DEPS=no BUILD="${BUILD:-build}" all
end

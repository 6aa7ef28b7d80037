#!/bin/bash
# SPDX-License-Identifier: MIT
# Builds what the tarball has, in a folder of its own, installs that into an
# empty root and uses what is there as a user would: the program, the man page,
# the library from C and from C++, shared and static, through pkg-config and
# through CMake, then uninstalls and finds nothing left.
set -u
. tests/lib.sh
prefix="$work/a prefix"

# The tarball has all there is, builds without git and in a folder with a blank
# in its name, and where it is built does not matter. What is not committed is
# installed, too.
mkdir "$work/bin" "$work/a folder"
printf '#!/bin/sh\nexit 127\n' >"$work/bin/git"
chmod +x "$work/bin/git"
if git diff --quiet HEAD 2>/dev/null; then
    ok dist make -s DEPS=no BUILD="$work/dist" dist
    tar -xzf "$work"/dist/iblbake-*.tar.gz -C "$work/a folder"
    tarball=$(echo "$work/a folder"/iblbake-*)
    (cd "$tarball" && find . -type f ! -name REVISION | sed 's|^\./||' | sort) |
        cmp - <(git ls-files | LC_ALL=C sort)
    verdict dist-files "$(is 0 $? 'status of cmp with the files of git')"
    same='iblbake iblview libiblbake.a libiblbake.so libiblbridge.so libiblexr.so
        libiblscene.so'
else
    same=
    verdict dist 'skipped: there are changes that are not committed, or no git'
    tarball="$work/a folder/iblbake"
    mkdir "$tarball"
    tar -c --exclude=./build --exclude=./.git . | tar -x -C "$tarball"
fi
make=(env PATH="$work/bin:$PATH" make --no-print-directory DEPS=no
    -C "$tarball" PREFIX="$prefix")
# What is older than its objects is not compiled again, but for the command line,
# whose code differs by folder if any does; dist-files says that all is there.
if [ -n "$same" ] && [ -e "$build/used-cc" ]; then
    mkdir "$tarball/build"
    cp -a "$build"/{obj,gen,used-*} "$tarball/build"
    rm -rf "$tarball/build/obj/src/cli" "$tarball/build/obj/tests"
    sed -i "s|-map=$top=|-map=$tarball=|" "$tarball/build/used-cc"
    touch -d '2001-01-01' "$tarball/build/used-cc"
    find "$tarball" -path "$tarball/build" -prune -o -type f \
        -exec touch -d '2001-01-01' {} +
fi
ok dist-builds "${make[@]}" -s -j"$(nproc)" PREFIX=/usr/local all
for file in $same; do
    [ ! -e "$build/$file" ] || ok "same-$file" cmp "$build/$file" \
        "$tarball/build/$file"
done

# The library remembers the PREFIX.
ok install "${make[@]}" install
ok version "$prefix/bin/iblbake" --version
ok bake "$prefix/bin/iblbake" -q data/sky.exr -o "$work/out" --size 16
ok bridge "$prefix/bin/iblbake" -q data/studio.exr -o "$work/out" --size 16
for f in man1/iblbake.1 man1/iblbake-verify.1 man7/iblbake-method.7; do
    verdict "manual-$f" "$(have man && man -l "$prefix/share/man/$f" 2>&1 \
        >/dev/null)"
done
for f in probes.glsl ibl.glsl ibl.hlsl; do
    ok "$f" test -s "$prefix/include/ibl/$f"
done

# The shells complete what the program knows.
complete_in_bash() {
    PATH=$prefix/bin:$PATH bash -c '
        . "$1"/share/bash-completion/completions/iblbake
        COMP_WORDS=(iblbake verify --lobe ch) COMP_CWORD=3
        _iblbake && echo "${COMPREPLY[*]}"
        COMP_WORDS=(iblbake co) COMP_CWORD=1
        _iblbake && echo "${COMPREPLY[*]}"' bash "$prefix" 2>&1
}
verdict completion-bash \
    "$(diff <(complete_in_bash) <(printf 'charlie\nconvert\n'))"
if have fish; then
    verdict completion-fish "$(diff <(PATH=$prefix/bin:$PATH fish --no-config -c '
        source $argv[1]/share/fish/vendor_completions.d/iblview.fish
        complete -C "iblbake --lobe ch"' "$prefix" 2>&1) <(printf 'charlie\tlobe\n'))"
fi
! have zsh || ok completion-zsh zsh -n "$prefix/share/zsh/site-functions/_iblbake"

if [ -x "$tarball/build/iblview" ]; then
    ok view-manual test -s "$prefix/share/man/man1/iblview.1"
    ok view-map test -s "$prefix/share/iblbake/forest.exr"
    ok view "$prefix/bin/iblview" "$work/out/sky_specular.ktx2" \
        --offscreen "$work/p.png"
    ok view-bridge "$prefix/bin/iblview" data/studio.exr \
        --offscreen "$work/p.png"
else
    verdict iblview 'skipped: it was not built'
    ok no-view-manual test ! -e "$prefix/share/man/man1/iblview.1"
fi

export PKG_CONFIG_PATH=$prefix/lib/pkgconfig
cat >"$work/use.c" <<'C'
#include <ibl/ibl.h>
#include <ibl/set.h>
#include <stdio.h>
#include <string.h>
#if IBL_VERSION_NUMBER < 200
#error "older than 0.2.0"
#endif
int main(int argc, char **argv)
{
    ibl_ctx *ctx;
    ibl_image env;
    double sh[27];
    ibl_set set;
    if (argc != 3 || strcmp(ibl_version(), IBL_VERSION) ||
        ibl_ctx_create(NULL, &ctx))
        return 1;
    if (ibl_image_read(ctx, argv[1], NULL, &env, NULL) ||
        ibl_bake_sh(ctx, &env, 2, 0, sh))
        return 1;
    if (ibl_set_open(ctx, argv[2], NULL, &set) || set.sh_degree != 2)
        return 1;
    ibl_set_free(&set);
    printf("%g\n", sh[0]);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
    return !(sh[0] > 0);
}
C
cp "$work/use.c" "$work/use.cpp"
# uses NAME PROGRAM none|libiblbake.so.1: it bakes by the library named.
uses() {
    local found
    found=$(ldd "$2" 2>&1 | sed -n 's/.*\(libiblbake\.so\.[0-9]*\) => \/.*/\1/p')
    [ "${found:-none}" = "$3" ] || verdict "$1-library" "$found, not $3"
    ok "$1-runs" "$2" data/sky.exr "$work/out/sky.json"
}
# pkg-config's words are for a shell.
flags() { pkg-config "$@" iblbake; }
rpath="-Wl,-rpath,'$prefix/lib'"
for c in cc:c c++:cpp; do
    ok "${c#*:}" sh -c "${c%:*} '$work/use.${c#*:}' -o '$work/use' \
        $(flags --cflags --libs) $rpath"
    uses "${c#*:}" "$work/use" libiblbake.so.1
    ok "${c#*:}-static" sh -c "${c%:*} '$work/use.${c#*:}' -o '$work/use' \
        $(flags --static --cflags --libs | sed 's/-liblbake/-l:libiblbake.a/')"
    uses "${c#*:}-static" "$work/use" none
done
ok c-bridge "$work/use" data/studio.exr "$work/out/studio.json"
mkdir "$work/cmake"
cat >"$work/cmake/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.18)
project(use C CXX)
find_package(iblbake 0.2 REQUIRED)
foreach(language c cpp)
  add_executable(${language} ../use.${language})
  target_link_libraries(${language} iblbake::iblbake)
  add_executable(${language}-static ../use.${language})
  target_link_libraries(${language}-static iblbake::static)
endforeach()
CMAKE
if have cmake >"$work/why"; then
    ok cmake cmake -S "$work/cmake" -B "$work/cmake/build" \
        -DCMAKE_PREFIX_PATH="$prefix"
    ok cmake-build cmake --build "$work/cmake/build"
    for name in c cpp; do
        uses "cmake-$name" "$work/cmake/build/$name" libiblbake.so.1
        uses "cmake-$name-static" "$work/cmake/build/$name-static" none
    done
    sed -i 's/iblbake 0\.2/iblbake 9/' "$work/cmake/CMakeLists.txt"
    ! cmake -S "$work/cmake" -B "$work/cmake/none" -DCMAKE_PREFIX_PATH="$prefix" \
        >/dev/null 2>&1
    verdict cmake-wants-a-version "$(is 0 $? 'status where version 9 is asked for')"
else
    verdict cmake "$(cat "$work/why")"
fi

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
        ibl_bake_specular(ctx, &env, &opts, &cube, NULL))
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
left=$(find "$prefix" ! -type d)
ok nothing-left test -z "$left"
end

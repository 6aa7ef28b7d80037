#!/bin/bash
# SPDX-License-Identifier: MIT
# Runs the examples of README.md as they stand there: the shell line, the
# Makefile rule (with -j), the CMake list, the C program, and the shader lines
# through glslang. What it and the other documents link to is there, and its
# pictures are of today.
set -u
. tests/lib.sh
# The first fenced block of a language.
block() {
    awk -v fence='```'"$1" '$0 == fence { on = 1; next }
        on && /^```$/ { exit } on { print; n++ }
        END { if (!n) print "no example" }' "$top/README.md"
}
export PATH=$build:$PATH
cd "$work" || exit 1
mkdir env
# Two maps of 8x4 pixels, flat RGBE.
for name in noon dusk; do
    { printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n'
      for i in $(seq 32); do printf '\200\100\040\201'; done; } >env/$name.hdr
done

cp env/noon.hdr env.hdr
for document in "$top"/*.md "$top"/tests/*.md; do
    sed -n 's/.*](\([^)#]*\)[^)]*).*/\1/p' "$document" | sort -u |
        while read -r link; do
            case $link in
            '' | http*) ;;
            *) [ -e "${document%/*}/$link" ] || echo "wanted $link of $document, found no such file" ;;
            esac
        done
done >missing
ok links test ! -s missing
# What the table of hard cases names is there.
sed -n '/^## Hard cases/,/^## Bounds/p' "$top/tests/README.md" |
    grep -o '`check_[^`]*: [^`]*`\|"[^"]*"' | tr -d '`' | sort -u |
    while IFS= read -r row; do
        case $row in
        \"*) grep -qF "{$row, " "$top/tests/check_levels.c" ;;
        *) grep -qw -- "${row#*: }" "$top/tests/${row%%:*}.c" ;;
        esac || echo "wanted $row, found no such row"
    done >missing
verdict hard-cases "$(cat missing)"

block sh >example.sh
ok shell sh -e example.sh
ok shell-output test -s out/env_specular.ktx2

block bash >example.bash
ok batch bash -e example.bash
ok batch-output test -s lit/noon_specular.ktx2 -a -s lit/dusk.json
rm -r lit

block make >Makefile
ok make make -j4
for name in noon dusk; do
    ok "make-$name" test -s lit/${name}_specular.ktx2 -a -s lit/$name.json
done
ok make-lut test -s lit/brdf_lut.ktx2
ok make-idle make -q
touch -d '+2 seconds' env/dusk.hdr
make -j4 >again 2>&1
ok make-one test "$(grep -c iblbake again)" = 1
for part in _specular.ktx2 _irradiance.ktx2 .json; do
    rm lit/noon$part
    make -j4 >again 2>&1
    ok "make-again$part" test -s lit/noon$part -a \
        "$(grep -c "iblbake.*noon" again)" = 1
done

if have cmake >why; then
    mkdir cmake && block cmake >cmake/CMakeLists.txt
    cp -r env cmake/env
    cp env/noon.hdr "cmake/env/the \$sky.v1.hdr"
    ok cmake cmake -S cmake -B cmake/build
    ok cmake-build cmake --build cmake/build -j4
    ok cmake-output test -s cmake/build/lit/noon_specular.ktx2
    ok cmake-odd-name test -s "cmake/build/lit/the \$sky.v1_specular.ktx2"
    cmake --build cmake/build -j4 >again 2>&1
    ok cmake-idle test "$(grep -c Generating again)" = 0
    rm cmake/build/lit/noon_irradiance.ktx2
    cmake --build cmake/build -j4 >again 2>&1
    ok cmake-again test -s cmake/build/lit/noon_irradiance.ktx2
else
    verdict cmake "$(cat why)"
fi

block c >light.c
ok c cc -Wall -Wextra -Werror -I"$top/include" light.c "$build/libiblbake.a" \
    -lOpenEXRCore $(pkg-config --libs "$(cat "$build/used-deflate")" \
    libzstd jansson libpng zlib) \
    -ldl -lm -pthread -o light
ok c-runs ./light

# The pictures are what the demo and `make pictures` make today, but for the
# integral's rows, which take too long.
as_today() {
    local picture
    [ -x "$build/iblview" ] || { echo 'skipped: iblview was not built'; return; }
    have node oiiotool || return
    cp "$top"/tests/cli/*png.mjs .
    mkdir pictures
    (cd "$top" && make -n DEPS=no BUILD="$build" DEMO="$work/pictures" \
        demo-pictures | sed 's/ -v / -q /' | grep -v contact-sheet | sh -e &&
        sh tests/pictures.sh "$build" "$work/pictures" 'split four-taps')
    for picture in pictures/*.png; do
        node png.mjs "$top/data/${picture##*/}@0,0,0" "$picture" 255 0.5
    done
}
verdict pictures "$(as_today 2>&1)"

if have glslangValidator >why; then
    { echo '#version 330 core'; cat "$top/include/ibl/ibl.glsl"; block glsl
      echo 'out vec4 color; uniform samplerCube s, i; uniform sampler2D b;
        uniform sampler2DArray l; in vec3 n, v;
        void main() { color = vec4(ibl(s, i, b, l, vec4(5, 0, 5, 1), n, v,
            vec3(1), vec3(.04), .5, 0.), 1); }'; } >ibl.frag
    ok glsl glslangValidator ibl.frag
else
    verdict glsl "$(cat why)"
fi
end

#!/bin/sh
# SPDX-License-Identifier: MIT
# Our textures in the eyes of programs that others wrote: file(1), and
# ktx-parse, three.js and parse-dds from npm. BUILD: where to build. The last
# line is "N passed, N failed, N skipped".
set -eu
build=${BUILD:-build}
textures=$build/textures

for program in node npm file; do
    command -v $program >/dev/null 2>&1 && continue
    echo "skipped: $program is missing (make deps, tests/deps.sh)"
    echo '0 passed, 0 failed, 1 skipped'
    exit 0
done

make -s DEPS=no BUILD="$build" "$build/tests/write_textures"
rm -rf "$textures"
"$build/tests/write_textures" "$textures"

passed=0
failed=0
# is PATTERN WORDS: what file(1) says of the files.
is() {
    for f in "$textures"/$1; do
        said=$(file -b "$f")
        case $said in
        "$2") passed=$((passed + 1)) ;;
        *)
            echo "FAILED file $f: $said, not $2"
            failed=$((failed + 1))
            ;;
        esac
    done
}
ktx2='Khronos KTX2 texture'
cube="$ktx2, 8 x 8, 6 faces, 4 mipmaps"
is bc6h-cube8x4.ktx2 "$cube, BC6H_UFLOAT_BLOCK"
is rgba16f-cube8x4.ktx2 "$cube, R16G16B16A16_SFLOAT"
is rgb9e5-cube8x4.ktx2 "$cube, E5B9G9R9_UFLOAT_PACK32"
is r11g11b10f-cube8x4.ktx2 "$cube, B10G11R11_UFLOAT_PACK32"
is rgba32f-cube8x4x5.ktx2 \
    "$ktx2, 8 x 8, 5 layers, 6 faces, 4 mipmaps, R32G32B32A32_SFLOAT"
is rg16f-flat5x1x2.ktx2 "$ktx2, 5 x 5, 2 layers, R16G16_SFLOAT"
is rg32f-flat5x1.ktx2 "$ktx2, 5 x 5, R32G32_SFLOAT"
ktx='Khronos KTX texture (little-endian)'
is 'rgba*-cube8x4.ktx' "$ktx, 8 x 8, RGBA"
is 'r[!g]*-cube8x4.ktx' "$ktx, 8 x 8, RGB"
is 'rg*f-flat5x1.ktx' "$ktx, 5 x 5"
dds='Microsoft DirectDraw Surface (DDS):'
is bc6h-cube8x4.dds "$dds 8 x 8, DXGI format: BC6H_UF16"
is rgba16f-cube8x4x5.dds "$dds 8 x 8, DXGI format: R16G16B16A16_FLOAT"
is rgba32f-cube8x4.dds "$dds 8 x 8, DXGI format: R32G32B32A32_FLOAT"
is rgb9e5-cube8x4.dds "$dds 8 x 8, DXGI format: R9G9B9E5_SHAREDEXP"
is r11g11b10f-cube8x4.dds "$dds 8 x 8, DXGI format: R11G11B10_FLOAT"
is rg16f-flat5x1.dds "$dds 5 x 5, DXGI format: R16G16_FLOAT"

# Fetched once: a network that is not there is no fault of our textures.
readers='ktx-parse@1.1.0 three@0.187.0 parse-dds@1.2.1
gltf-validator@2.0.0-dev.3.10'
if [ "$(cat "$build/npm/fetched" 2>/dev/null)" != "$readers" ]; then
    # shellcheck disable=SC2086
    if ! npm install --no-save --no-package-lock --no-audit --no-fund \
        --ignore-scripts --loglevel=error --prefix "$build/npm" $readers; then
        echo 'skipped: npm cannot fetch the readers'
        echo "$passed passed, $failed failed, 1 skipped"
        exit $((failed > 0))
    fi
    echo "$readers" >"$build/npm/fetched"
fi
here=$(dirname "$0")

# To the validator of Khronos, the light is an extension that it does not know,
# and its images belong to nothing; all else is right.
rm -rf "$build/gltf"
"$build/iblbake" -q data/forest.exr -o "$build/gltf" --format gltf --size 32 \
    --levels 2 --mapping linear --name 'a b'
if said=$(node "$here/gltf_valid.mjs" "$build/npm" "$build/gltf/a b.gltf") &&
    [ -z "$said" ]; then
    passed=$((passed + 1))
else
    failed=$((failed + 1))
    echo "FAILED gltf-validator: $said"
fi
node "$here/ktx_parse.mjs" "$build/npm" "$textures"/*.ktx2 "$textures"/*.ktx \
    "$textures"/*.dds >"$textures/report" || true
cat "$textures/report"
last=$(tail -n 1 "$textures/report")
case $last in
*' passed, '*' failed')
    passed=$((passed + ${last%% passed*}))
    last=${last#* passed, }
    failed=$((failed + ${last%% failed}))
    ;;
*)
    echo 'FAILED node: no verdict'
    failed=$((failed + 1))
    ;;
esac
echo "$passed passed, $failed failed, 0 skipped"
[ "$failed" = 0 ]

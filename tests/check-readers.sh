#!/bin/bash
# SPDX-License-Identifier: MIT
# Our textures in the eyes of programs that others wrote: file(1), and
# ktx-parse, three.js and parse-dds from npm. BUILD: where to build.
set -u
. tests/lib.sh
need node npm file
textures=$build/textures
ok textures make -s DEPS=no BUILD="${BUILD:-build}" \
    "${BUILD:-build}/tests/write_textures"
rm -rf "$textures"
"$build/tests/write_textures" "$textures"

read_as() { # FILES WORDS: what file(1) says of each
    local f
    for f in "$textures"/$1; do
        verdict "file ${f##*/}" "$(is "$2" "$(file -b "$f")")"
    done
}
ktx2='Khronos KTX2 texture'
cube="$ktx2, 8 x 8, 6 faces, 4 mipmaps"
read_as bc6h-cube8x4.ktx2 "$cube, BC6H_UFLOAT_BLOCK"
read_as rgba16f-cube8x4.ktx2 "$cube, R16G16B16A16_SFLOAT"
read_as rgb9e5-cube8x4.ktx2 "$cube, E5B9G9R9_UFLOAT_PACK32"
read_as r11g11b10f-cube8x4.ktx2 "$cube, B10G11R11_UFLOAT_PACK32"
read_as rgba32f-cube8x4x5.ktx2 \
    "$ktx2, 8 x 8, 5 layers, 6 faces, 4 mipmaps, R32G32B32A32_SFLOAT"
read_as rg16f-flat5x1x2.ktx2 "$ktx2, 5 x 5, 2 layers, R16G16_SFLOAT"
read_as rg32f-flat5x1.ktx2 "$ktx2, 5 x 5, R32G32_SFLOAT"
ktx='Khronos KTX texture (little-endian)'
read_as 'rgba*-cube8x4.ktx' "$ktx, 8 x 8, RGBA"
read_as 'r[!g]*-cube8x4.ktx' "$ktx, 8 x 8, RGB"
read_as 'rg*f-flat5x1.ktx' "$ktx, 5 x 5"
dds='Microsoft DirectDraw Surface (DDS):'
read_as bc6h-cube8x4.dds "$dds 8 x 8, DXGI format: BC6H_UF16"
read_as rgba16f-cube8x4x5.dds "$dds 8 x 8, DXGI format: R16G16B16A16_FLOAT"
read_as rgba32f-cube8x4.dds "$dds 8 x 8, DXGI format: R32G32B32A32_FLOAT"
read_as rgb9e5-cube8x4.dds "$dds 8 x 8, DXGI format: R9G9B9E5_SHAREDEXP"
read_as r11g11b10f-cube8x4.dds "$dds 8 x 8, DXGI format: R11G11B10_FLOAT"
read_as rg16f-flat5x1.dds "$dds 5 x 5, DXGI format: R16G16_FLOAT"

fetch_npm "$build/npm" 'ktx-parse@1.1.0 three@0.187.0 parse-dds@1.2.1
gltf-validator@2.0.0-dev.3.10' || {
    verdict npm 'skipped: npm cannot fetch the readers'
    end
    exit
}

# To the validator of Khronos, the light is an extension that it does not know,
# and its images belong to nothing; all else is right.
rm -rf "$build/gltf"
"$build/iblbake" -q data/forest.exr -o "$build/gltf" --format gltf --size 32 \
    --levels 2 --mapping linear --name 'a b'
verdict gltf-validator \
    "$(node tests/gltf_valid.mjs "$build/npm" "$build/gltf/a b.gltf" 2>&1)"
node tests/ktx_parse.mjs "$build/npm" "$textures"/*.ktx2 "$textures"/*.ktx \
    "$textures"/*.dds >"$work/report"
report ktx_parse "$work/report"
end

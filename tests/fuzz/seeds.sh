#!/bin/bash
# SPDX-License-Identifier: MIT
# seeds.sh BUILD DIR: makes DIR/HARNESS/*, what fuzzing begins with, and
# DIR/HARNESS.dict. The last bytes of a seed are its harness's choices.
set -eu
# Leaks are not looked for here: that takes a third of the time.
export ASAN_OPTIONS=detect_leaks=0
build=$(cd "$1" && pwd)
iblbake=$build/iblbake iblview=$build/iblview
rm -rf "$2"
mkdir -p "$2"
cd "$2"
mkdir -p image texture json scene engine options made
seed() { # HARNESS NAME CHOICES [FILE]: the choices as printf has them
    { cat -- ${4+"$4"} && printf "$3"; } >"$1/$2"
}

# ---- images: choices step, way, bits, layout, primaries, alpha ---------------
begin='#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n'
hdr() { # NAME BYTES WAY
    printf "$2" | seed image "$1" "\\x07\\x0$3\\x0\\x0\\x0\\x0"
}
four='\x40\x50\x60\x80\x20\x30\x10\x7f\x01\x02\x03\x84\x99\x88\x77\x66'
run='\x02\x02\x00\x08\x88\x40\x88\x50\x04\x01\x02\x03\x04\x84\x60\x88\x80'
hdr flat.hdr "$begin\n-Y 2 +X 4\n$four$four" 0
hdr old.hdr "$begin\n-Y 2 +X 4\n$four\x40\x50\x60\x80\x01\x01\x01\x03$four" 3
hdr new.hdr "$begin\n-Y 4 +X 8\n$run$run$run$run" 5
hdr up.hdr "$begin\n+Y 4 -X 8\n$run$run$run$run" 7
hdr columns.hdr "$begin\n-X 8 +Y 4\n$four$four$four$four$four$four$four$four" 2
hdr named.hdr "#?RADIANCE\n# made\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2.5\nCOLORCORR=1 \
1.5 2\nPRIMARIES=.64 .33 .3 .6 .15 .06 .3127 .329\n\n-Y 2 +X 4\n$four$four" 6
packings='none rle zip zips piz pxr24 b44 b44a'
outputs=()
for packing in $packings; do
    outputs+=(--compression "$packing" --scanline -o "made/scanline-$packing.exr"
        --tile 8 8 -o "made/tile-$packing.exr")
done
oiiotool --nosoftwareattrib --create 16x8 4 --fill:topleft=1,.1,.2,1:\
topright=.5,2,.1,.5:bottomleft=0,.1,9,.2:bottomright=.1,.2,.3,1 16x8 \
    -o made/map.exr \
    -d half "${outputs[@]}" --scanline --compression zip \
    made/map.exr -d half made/map.exr -d half --siappend -o made/parts.exr \
    made/map.exr --ch R -d uint32 --chnames Y -o made/grey.exr \
    made/map.exr -d float --ch R,G,B --attrib:type=float\[8\] chromaticities \
    .713,.293,.165,.83,.128,.044,.32168,.33767 -o made/acescg.exr \
    --create 64x32 4 --fill:top=1,.1,.2,1:bottom=0,.1,9,.2 64x32 -d half \
    --compression dwaa -o made/dwaa.exr --tile 32 32 --compression dwab \
    -o made/dwab.exr \
    --create 2x2 3 --fill:color=.5,.2,.1 2x2 -d half -o made/flat.exr \
    -o made/face.hdr -d uint8 -o made/dot.png -o made/dot.jpg
for packing in $packings; do
    seed image scanline-$packing.exr '\x0\x02\x0\x0\x0\x01' \
        "made/scanline-$packing.exr"
    seed image tile-$packing.exr '\x07\x03\x0\x0\x0\x0' \
        "made/tile-$packing.exr"
done
seed image dwaa.exr '\x0\x02\x0\x0\x0\x01' made/dwaa.exr
seed image dwab.exr '\x07\x03\x0\x0\x0\x0' made/dwab.exr
seed image acescg.exr '\x09\x03\x14\x0\x02\x0' made/acescg.exr
seed image parts.exr '\x0\x02\x0\x0\x0\x01' made/parts.exr
seed image face.exr '\x0\x01\x0\x0\x0\x0' made/flat.exr
seed image face.hdr '\x0\x01\x0\x0\x0\x0' made/face.hdr
seed image grey.exr '\x0\x05\x0\x0\x01\x0' made/grey.exr

# Ultra HDR JPEGs without pictures: the harness's bridge has them.
two() { # N: two bytes, as printf has them
    printf '\\x%02x\\x%02x' $(($1 >> 8)) $(($1 & 255))
}
segment() { # MARKER BYTES
    printf "$2" >made/body
    printf "\\xff\\x$1$(two $(($(stat -c %s made/body) + 2)))"
    cat made/body
}
ultra_hdr() { # NAME MARKER BYTES MARKER BYTES: what the first says, and the second
    { printf '\xff\xd8' && segment "$4" "$5" && printf '\xff\xda'; } >made/gain
    local index='MPF\0MM\0\x2a\0\0\0\x08\0\x01\xb0\x02\0\x07\0\0\0\x20\0\0\0\x1a'
    index=$index$(printf '\\0%.0s' {1..26})$(two "$(stat -c %s made/gain)")
    {
        printf '\xff\xd8'
        segment "$2" "$3"
        segment e2 "$index\\0\\0\\0\\x3c\\0\\0\\0\\0"
        printf '\xff\xd9'
        cat made/gain
    } >made/ultra.jpg
    seed image "$1" '\x0\x02\x0\x0\x0\x0' made/ultra.jpg
}
xmp='http://ns.adobe.com/xap/1.0/\0'
ultra_hdr android.jpg e1 "$xmp<x hdrgm:Version=\"1.0\"/>" e1 "$xmp<rdf:Description \
hdrgm:Version=\"1.0\" hdrgm:GainMapMax=\"3.5\" hdrgm:HDRCapacityMax=\"3.5\"><hdrgm:Gamma>\
<rdf:Seq><rdf:li>1</rdf:li><rdf:li>2</rdf:li><rdf:li>1</rdf:li></rdf:Seq></hdrgm:Gamma>"
iso='urn:iso:std:iso:ts:21496:-1\0\0\0\0\0'
meaning='\x40'
for n in 0 3584 0 3584 1024 16 16; do # parts of 1024
    meaning="$meaning\\0\\0$(two $n)\\0\\0\\x04\\0"
done
ultra_hdr iso.jpg e2 "$iso" e2 "$iso$meaning"

# ---- a bake of each kind: textures, sidecars, engines' files -----------------
small='--size 4 --levels 3 --irradiance-size 4 --lut-size 4'
for pixel in rgba16f rgba32f rgb9e5 r11g11b10f bc6h uastc-hdr astc4x4hdr; do
    for format in ktx2 ktx dds dds-legacy; do
        "$iblbake" -q made/map.exr -o made/$pixel-$format --pixel $pixel \
            --format $format $small 2>/dev/null || continue
        for file in made/$pixel-$format/map_specular.*; do
            seed texture "$pixel-$format" '\x0\x0\x0' "$file"
            seed image "$pixel-$format" '\x0\x02\x0\x0\x0\x02' "$file"
        done
    done
done
"$iblbake" -q made/map.exr -o made/more --zstd 9 --layout octahedral --pixel bc6h \
    --sun --lobe-table prior $small --name map
seed texture flat-zstd '\x01\x01\x01' made/more/map_specular.ktx2
seed texture lut-zstd '\x01\x02\x02' made/more/brdf_lut.ktx2
for file in made/more/*lobe_lut.ktx2; do
    seed texture lobes '\x02\x03\x0' "$file"
done
for target in babylon-env:8 gltf:4; do
    "$iblbake" -q made/map.exr -o made/${target%:*} --target ${target%:*} \
        --name s --size ${target#*:}
done
seed engine env '' made/babylon-env/s.env
seed engine gltf '' made/gltf/s.gltf
seed image env '\x0\x02\x0\x0\x0\x0' made/babylon-env/s.env
"$iblbake" -q made/flat.exr -o made/atlas --target playcanvas --name s \
    --size 32 --any-aspect
seed engine atlas '' made/atlas/s_envatlas.png

# What others write: a cube by the old flags alone, one whose array counts
# faces, no descriptor, faces in another order; bytes, for the bridge.
patch() { # FROM TO OFFSET BYTES ...
    cp "$1" "$2"
    local to=$2
    shift 2
    for (( ; $#; )); do
        printf "$2" | dd of="$to" bs=1 seek="$1" conv=notrunc status=none
        shift 2
    done
}
dds=made/rgba16f-dds/map_specular.dds ktx2=made/rgba16f-ktx2/map_specular.ktx2
patch $dds made/flags.dds 136 '\0'
patch $dds made/six.dds 140 '\6'
patch $ktx2 made/bare.ktx2 48 '\0\0\0\0\0\0\0\0'
patch $dds made/bytes.dds 128 '\x1d'
for file in made/{flags.dds,six.dds,bare.ktx2,bytes.dds}; do
    seed texture "$(basename "$file")" '\x0\x0\x0' "$file"
    seed image "$(basename "$file")" '\x0\x02\x40\x0\x0\x0' "$file"
done
oiiotool --create 4x24 3 --fill:color=.5,.2,.1 4x24 -d half --tile 4 4 --attrib \
    textureformat "CubeFace Environment" -o made/envmap.exr
seed image envmap.exr '\x0\x02\x0\x0\x0\x0' made/envmap.exr
printf 'PF\r\n2 1\r\n-1.0\r\n%024d' 0 | seed image crlf.pfm '\x0\x02\x0\x0\x0\x0'

# ---- JSON: the choice is the reader ------------------------------------------
cat >made/set.json <<'END'
{"version": 1, "defaults": {"size": 16, "levels": 3, "irradiance": 4,
  "lut_size": 16, "mapping": "linear", "pixel": "rgba16f", "container": "ktx2",
  "zstd": 3, "alpha": "file", "overflow": "clip"},
 "global": {"capture": {"cross": "b.exr"}},
 "probes": [{"name": "hall", "position": [0, 1, 0], "capture":
   {"equirect": "a.exr"}, "influence": {"box": {"centre": [0, 1, 0],
   "half": [4, 2, 4]}}, "blend": 1, "priority": 2, "proxy": {"sphere":
   {"centre": [0, 1, 0], "radius": 6}}}, {"name": "l", "position": [1, 1, 0],
   "capture": {"faces": ["1", "2", "3", "4", "5", "6"]}, "influence":
   {"sphere": {"centre": [1, 1, 0], "radius": 1}}}]}
END
cat >made/grid.json <<'END'
{"version": 1, "min": [0, 0, 0], "max": [4, 3, 4], "spacing": 2, "solid":
 [{"min": [0, 0, 0], "max": [1, 1, 1]}], "blend": 0.5, "name": "p{x}{y}{z}",
 "capture": {"equirect": "grid/{name}.exr"}, "defaults": {"size": 8}}
END
cat >made/one.json <<'END'
{"version": 1, "defaults": {"size": 4, "levels": 2, "irradiance": "sh",
  "lut_size": 4}, "probes": [{"name": "a", "position": [0, 0, 0], "capture":
  {"equirect": "map.exr"}, "influence": {"box": {"centre": [0, 0, 0],
  "half": [1, 1, 1]}}}]}
END
"$iblbake" probes -q made/one.json -o made/probes
cp made/rgba16f-ktx2/map.json made/sidecar.json
seed json set '\x00' made/set.json
seed json grid '\x01' made/grid.json
seed json index '\x04' made/probes/index.json
for reader in 2 3; do
    seed json sidecar$reader "\\x0$reader" made/sidecar.json
    seed json more$reader "\\x0$reader" made/more/map.json
done

# ---- scenes ------------------------------------------------------------------
cat >made/scene.gltf <<'END'
{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":
0,"scale":[2,1,1],"rotation":[0,0,0,1],"children":[1]},{"matrix":[1,0,0,0,0,1,0,
0,0,0,1,0,0,0,0,1],"mesh":0}],"buffers":[{"uri":"b.bin","byteLength":68}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,
"byteLength":24},{"buffer":0,"byteOffset":60,"byteLength":8}],"accessors":[
{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},{"bufferView":1,
"componentType":5126,"count":3,"type":"VEC2"},{"bufferView":2,"componentType":
5123,"count":3,"type":"SCALAR"}],"meshes":[{"primitives":[{"attributes":
{"POSITION":0,"TEXCOORD_0":1},"indices":2,"material":0,"mode":4}]}],"images":
[{"uri":"data:image/png;base64,PNG"}],"samplers":[{"wrapS":33071,"magFilter":
9728}],"textures":[{"source":0,"sampler":0}],"materials":[{"alphaMode":"MASK",
"pbrMetallicRoughness":{"baseColorTexture":{"index":0},"metallicFactor":0.5,
"roughnessFactor":0.5,"baseColorFactor":[1,0.5,0.2,1]},"extensions":
{"KHR_materials_clearcoat":{"clearcoatFactor":1},"KHR_materials_sheen":
{"sheenColorFactor":[1,1,1]},"KHR_texture_transform":{}},"emissiveFactor":[1,1,1]
}]}
END
png=$(base64 -w0 made/dot.png)
sed "s|PNG|$png|" made/scene.gltf | tr -d '\n' >made/whole.gltf
seed scene gltf '\x0' made/whole.gltf
sed "s|data:image/png;base64,PNG|data:image/jpeg;base64,$(base64 -w0 made/dot.jpg)|" \
    made/scene.gltf | tr -d '\n' | seed scene jpeg '\x01'
word() { # N: four bytes, the least significant first
    printf "$(printf '\\x%02x' $(($1 & 255)) $(($1 >> 8 & 255)) $(($1 >> 16)) 0)"
}
{
    printf '\0%.0s' {1..14} && printf '\x80\x3f'
    printf '\0%.0s' {1..14} && printf '\x80\x3f'
    printf '\0%.0s' {1..28} && printf '\0\0\x01\0\x02\0\0\0'
    cat made/dot.jpg && printf '\0\0\0'
} >made/bin
size=$(($(stat -c %s made/bin) / 4 * 4))
json=$(tr -d '\n' <made/scene.gltf | sed "s/\"uri\":\"b.bin\",//
    s/\"byteLength\":68}/\"byteLength\":$size}/
    s/\"byteLength\":8}/&,{\"buffer\":0,\"byteOffset\":68,\"byteLength\":$((size - 68))}/
    s/\"uri\":\"data:[^\"]*\"/\"bufferView\":3,\"mimeType\":\"image\/jpeg\"/")
while [ $((${#json} % 4)) -ne 0 ]; do json="$json "; done
{
    printf glTF && word 2 && word $((28 + ${#json} + size)) && word ${#json}
    printf 'JSON%s' "$json" && word $size && printf 'BIN\0'
    head -c $size made/bin
} | seed scene glb '\x0'

# What else a node, an accessor, a material and a primitive may have. What is
# packed was made by meshoptimizer's, Draco's and libwebp's encoders.
scene() { # NAME: the members after the nodes
    { printf '{"asset":{"version":"2.0"},"scenes":[{"nodes":[0,1,2]}],' && cat; } |
        tr -d '\n' | seed scene "$1" '\x0'
}
scene skin <<'END'
"nodes":[{"children":[3]},{"mesh":0,"skin":0},{"mesh":0,"extensions":{
"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":0,"SCALE":0}},
"KHR_node_visibility":{"visible":true}}},{"translation":[1,2,3]}],"skins":[{
"joints":[3,0],"inverseBindMatrices":4}],"buffers":[{"uri":"b.bin","byteLength":
68}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":60,
"byteLength":8}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,
"type":"VEC3","sparse":{"count":1,"indices":{"bufferView":1,"componentType":5123
},"values":{"bufferView":0}}},{"bufferView":1,"componentType":5123,"count":3,
"type":"SCALAR"},{"componentType":5121,"count":3,"type":"VEC4","normalized":true,
"sparse":{"count":2,"indices":{"bufferView":1,"componentType":5121},"values":{
"bufferView":0}}},{"componentType":5121,"count":3,"type":"VEC4"},{
"componentType":5126,"count":2,"type":"MAT4"}],"meshes":[{"primitives":[{
"attributes":{"POSITION":0,"NORMAL":0,"JOINTS_0":3,"WEIGHTS_0":2,"JOINTS_1":3,
"WEIGHTS_1":2,"TEXCOORD_3":0},"material":0}]}],"extensionsUsed":["X_new",
"KHR_texture_basisu"],"materials":[{"occlusionTexture":{"index":0,"texCoord":3},
"extensions":{"KHR_materials_pbrSpecularGlossiness":{"diffuseFactor":[1,1,1,1],
"glossinessFactor":0.5,"specularGlossinessTexture":{"index":0,"texCoord":1}}}}],
"textures":[{"extensions":{"EXT_texture_webp":{"source":0}}}],"images":[{"uri":
"data:image/webp;base64,UklGRiAAAABXRUJQVlA4TBMAAAAvAQAAAA/woP9JmP/5jyVkRP8DAA=="}]}
END
scene draco <<'END'
"nodes":[{"mesh":0},{},{}],"buffers":[{"uri":"data:;base64,RFJBQ08CAgEBAAAABAIBAg
AAAR//ARH/AREC/wAAAAAAAQAJAwAAAgEDAgIAAQEBAQEAAwMBMAEQAwAkgkoEAAAAAP8HAAAAAIC/AAC
AvwAAAEAAAABACwEBAQADAwEwARADACiCjAAAAAAA/wAAAA==","byteLength":112}],
"bufferViews":[{"buffer":0,"byteLength":112}],"accessors":[{"componentType":5126,
"count":4,"type":"VEC3"},{"componentType":5121,"count":4,"type":"VEC2",
"normalized":true},{"componentType":5123,"count":6,"type":"SCALAR"}],"meshes":[{
"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":2,
"extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{
"POSITION":0,"TEXCOORD_0":1}}}}]}]}
END
scene meshopt <<'END'
"nodes":[{"mesh":0},{},{}],"buffers":[{"uri":"data:;base64,oAAAAAE/AAAA////AAAAAQ
wAAAD/AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAACAvwAAgL8AAABA","byteLength":57},{"uri":
"data:;base64,4fAQAHaHVmd4qYZliWiYAWkAAA==","byteLength":19}],"bufferViews":[{
"buffer":0,"byteLength":48,"extensions":{"EXT_meshopt_compression":{"buffer":0,
"byteLength":57,"byteStride":12,"count":4,"mode":"ATTRIBUTES","filter":"NONE"}}},
{"buffer":0,"byteLength":12,"extensions":{"EXT_meshopt_compression":{"buffer":1,
"byteLength":19,"byteStride":2,"count":6,"mode":"TRIANGLES"}}}],"accessors":[{
"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},{"bufferView":1,
"componentType":5123,"count":6,"type":"SCALAR"}],"meshes":[{"primitives":[{
"attributes":{"POSITION":0},"indices":1}]}]}
END

# ---- command lines, a word a line: the choice is the command -----------------
line() { # CHOICE NAME WORD...
    printf '%s\n' "${@:3}" | seed options "$2" "$1"
}
line 0 bake a.hdr -o out --size 64 --levels=5 --pixel rgba16f --zstd 3 --verify
line 0 targets a.hdr -o o --target three,babylon --rotate -90 --sun -q
line 0 choose a.hdr -o o --rendered-error .01 --scene m.glb --dry-run
line 0 sampled a.hdr -oo --method sampled --samples 64 --roughness-range .1:.9 --only json,lut
line 0 batch a.hdr b.exr --from list -o o --keep-going --incremental
line 1 verify a.hdr out --lod '2 r - r r' --roughness-map 0,.5,1 --axes x,z,-y
line 2 bench a.hdr --tools cmgen --json out.json --repeat 3
line 3 probes set.json two.json -o out --shard 1/2 --zstd 19 --size 32 --alpha ignore -v
line 3 grid --grid room.json -o set.json
line 6 view out --size 640x360 --grid 4x8 --tone aces --offscreen a.png --ev -1
line 6 sheet out --contact-sheet a.png --mode levels --against split
line 4 info a.hdr out --json
line 5 convert a.ktx2 b.exr --layout equirect --pixel rgba16f --tone film

# ---- words -------------------------------------------------------------------
options() {
    "$iblbake" --help
    for command in verify bench probes info convert; do "$iblbake" $command --help; done
    "$iblview" --help
}
options | grep -oE -- '--[a-z0-9-]+' | sort -u | sed 's/.*/"&"/' >options.dict
options | grep -oE '\b[a-z][a-z0-9]+(-[a-z0-9]+)*\b' | sort -u | sed 's/.*/"&"/' \
    >>options.dict
for kind in json engine scene; do
    cat $kind/* | LC_ALL=C grep -aoE '"[A-Za-z_.]+"' | sort -u >$kind.dict
done
cat image/*.exr | LC_ALL=C grep -aoE '[A-Za-z0-9]{4,}' | sort -u |
    sed 's/.*/"&"/' >image.dict
printf '"%s"\n' EXPOSURE= COLORCORR= PRIMARIES= FORMAT=32-bit_rle_rgbe '-Y ' '+X ' \
    'hdrgm:GainMapMax' hdrgm:BaseRenditionIsHDR RY BY layerA.R >>image.dict
strings -n 6 texture/* | grep -oE '[A-Za-z_.]{6,}' | sort -u | sed 's/.*/"&"/' \
    >texture.dict
rm -r made

#!/bin/bash
# SPDX-License-Identifier: MIT
# Runs iblview without a display as a user would: pictures, sheets, errors, and
# what is said about what does not work. BUILD names the build.
set -u
. tests/lib.sh
slow='scene|models_of_others|sheets|stats'
use_viewer
# With a sanitizer most of each run is the start of OpenGL, so these are left
# out: their calls are those of other tests, and only their pictures differ.
repeats='same_bytes|samples'
mkenv hdr 32 16 >"$work/env.hdr"
mkenv exr 64 32 BGR >"$work/env.exr"
bake="iblbake -q $work/env.exr --size 16 --irradiance-size 8 --lut-size 16"
$bake -o "$work/ktx2" --skybox 32 || exit 1
small='--size 48x36'

iblview "$work/ktx2" --offscreen "$work/first.png" $small 2>"$work/err"
need_pictures "$work/err"

# draw OUT.png [arguments]: a picture without a word.
draw() {
    local out=$1
    shift
    iblview --offscreen "$out" $small "$@" >said 2>&1 || is 0 $? "$*: status"
    there "$out"
    lines 0 said
}
size() { od -An -td4 -j16 -N8 --endian=big "$1" | awk '{ print $1 " x " $2 }'; }

# ---- pictures ------------------------------------------------------------

test_same_bytes_in_every_run() {
    draw a.png "$work/ktx2"
    draw b.png "$work/ktx2"
    same a.png b.png
    is '48 x 36' "$(size a.png)"
}

# The world is upright whatever the axes of the files are, by their keys or by the
# sidecar, in harmonics and lights too.
test_axes_look_the_same() {
    local axes map=$work/case.hdr
    local how="--size 16 --irradiance-size 8 --lut-size 16 --sh 4 --sun"
    mkenv hdr 64 32 >"$map"
    iblbake -q "$map" -o a $how --skybox 16 2>/dev/null
    draw a.png a -q
    draw sh.png a -q --diffuse sh
    for axes in '--mirror x' '--mirror z --up z' '--up z --format dds'; do
        taken || continue
        rm -rf b
        iblbake -q "$map" -o b $how --skybox 16 $axes 2>/dev/null
        draw b.png b -q
        same a.png b.png
        draw b.png b -q --diffuse sh
        same sh.png b.png
    done
}

test_files_by_name() {
    draw a.png "$work/ktx2" --sky "$work/ktx2/env_skybox.ktx2"
    mkdir apart
    cp "$work/ktx2/env_specular.ktx2" apart
    cp "$work/ktx2/env_irradiance.ktx2" irr.ktx2
    cp "$work/ktx2/brdf_lut.ktx2" lut.ktx2
    cp "$work/ktx2/env_skybox.ktx2" sky.ktx2
    draw b.png apart -q --irradiance irr.ktx2 --lut lut.ktx2 --sky sky.ktx2
    same a.png b.png
    # A .gltf is a set if it has a light and nothing to draw.
    iblbake -q --size 16 --levels 2 --format gltf --mapping linear \
        "$work/env.exr" -o light
    draw a.png light -q
    draw b.png light/env.gltf -q
    same a.png b.png
}

test_models() {
    make_scene a '[{}]'
    make_scene b '[{"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}]'
    draw a.png "$work/ktx2" --model a.gltf
    draw b.png "$work/ktx2" --model b.gltf
    draw c.png "$work/ktx2"
    draw again.png "$work/ktx2" --model a.gltf
    same a.png again.png
    same c.png "$work/first.png"
    differ a.png b.png
    # An image of one red texel is a red factor.
    make_scene t '[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]'
    js <<'END'
const t = json('t.gltf');
t.accessors.push({...t.accessors[0], type: 'VEC2'});
t.meshes[0].primitives[0].attributes.TEXCOORD_0 = 1;
t.textures = [{source: 0}];
t.images = [{uri: 'data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAA' +
    'AADElEQVR4nGP4z8AAAAMBAQDJ/pLvAAAAAElFTkSuQmCC'}];
fs.writeFileSync('t.gltf', shown(t));
END
    draw t.png "$work/ktx2" --model t.gltf
    same b.png t.png
    iblview "$work/ktx2" --model b.gltf --offscreen d.png $small \
        --compare split --samples 16 >said
    has '^ *[1-9][0-9]*  *0\.[0-9]* (all)$' said
}

# One line after notes of parts, and no picture.
test_models_that_cannot_be_drawn() {
    local file
    make_scene good '[{}]'
    printf '{}' >empty.gltf
    sed 's/"count":4/"count":5/' good.gltf >long.gltf
    for file in none.gltf empty.gltf long.gltf env.exr .; do
        iblview "$work/ktx2" --model $file --offscreen no.png 2>said
        is 1 $? "$file: status"
        is 1 "$(grep -vc '^iblview: note' said)" "$file: lines of $(cat said)"
        absent no.png
    done
    wrong 2 '*--mode model: is of a model: add --model' "$work/ktx2" \
        --mode model
    iblview good.gltf --model good.gltf --offscreen no.png 2>said
    has 'is a second model' said
    # A model alone is lit by the map that comes with the program.
    iblview good.gltf --offscreen alone.png --size 32x18 &&
        iblview --model good.gltf --offscreen same.png --size 32x18 &&
        cmp alone.png same.png
}

# Those of others, where they are installed: all that are said to be good.
test_models_of_others() {
    local file folder=/usr/share/assimp/models/glTF2
    for file in 2CylinderEngine-glTF-Binary/2CylinderEngine.glb \
        BoxTextured-glTF/BoxTextured.gltf ClearCoat-glTF/ClearCoatTest.gltf \
        BoxTextured-glTF-pbrSpecularGlossiness/BoxTextured.gltf \
        simple_skin/simple_skin.gltf issue_3269/texcoord_crash.gltf \
        textureTransform/TextureTransformTest.gltf; do
        [ -e $folder/$file ] && taken || continue
        draw a.png "$work/ktx2" --model $folder/$file
    done
}

test_maps_are_baked() {
    local d
    draw a.png env.exr -q
    iblbake -q env.exr -o out && draw c.png out && same a.png c.png
    # Six files; and what only iblbake can be told.
    wrong 2 '*--input-layout: *iblbake --input-layout bakes it first*' \
        env.exr --input-layout equirect
    for d in px nx py ny pz nz; do
        mkenv exr 16 16 BGR >"f_$d.exr"
    done
    draw e.png -q 'f_%f.exr'
    [ $sanitized = yes ] ||
        { iblbake -q 'f_%f.exr' -o six && draw f.png -q six && same e.png f.png; }
    # Through the image bridge, which is found beside the program.
    [ ! -e "$build/libiblbridge.so" ] || draw d.png -q "$top/data/studio.exr"
    [ $sanitized = no ] || return 0
    draw b.png env.hdr -q
    differ a.png b.png
}

# Two sets side by side, and the panel over them.
test_panel_and_other_set() {
    local small='-q --size 96x64'
    draw a.png "$work/ktx2" $small
    draw b.png "$work/ktx2" $small --size 800x64 --panel
    differ a.png b.png
    iblbake -q "$work/env.exr" -o other --size 8 --levels 2 || return
    draw a.png "$work/ktx2" $small --against-set other --split 1
    draw b.png "$work/ktx2" $small --against-set other --split 0
    differ a.png b.png
    iblview "$work/ktx2" ${small#-q} --against-set other --offscreen a.png >out
    has '^relative RMSE of env against env' out
    wrong 1 '*nothing*' "$work/ktx2" $small --offscreen c.png \
        --against-set nothing
}

test_scene() {
    local scene='--mode scene --probe-size 32'
    draw scene.png "$work/ktx2" $scene
    # A model stands where the mirror was.
    make_scene a '[{}]'
    draw a.png "$work/ktx2" $scene --model a.gltf
    differ scene.png a.png
    wrong 2 '*--probe-size 100: *16, 32*' "$work/ktx2" --probe-size 100
}

# Two states, by options, by the name of a reflection, or not at all.
test_against() {
    local to='--offscreen a.png --size 64x48'
    iblview "$work/ktx2" $to --against fit >said
    has -x 'relative RMSE of reflection split against reflection fit' said
    wrong 2 '*--against: --reflection bogus: *split*' "$work/ktx2" $to --against bogus
    wrong 2 '*--against: --yaw 3: is the same for both sides' "$work/ktx2" \
        $to --against '--yaw 3'
    wrong 2 '*--compare: a state with itself*' "$work/ktx2" $to \
        --against split
}

# Pictures with alpha, those of a turn, and the exposure of the mean.
test_more_pictures() {
    draw a.png "$work/ktx2" --background transparent --no-labels
    is 6 "$(od -An -tu1 -j25 -N1 a.png | xargs)" 'kind of PNG'
    iblview "$work/ktx2" $small --turntable 3 --offscreen b.png ||
        is 0 $? status
    is 'b-001.png b-002.png b-003.png' "$(ls b-*.png | xargs)"
    differ b-001.png b-002.png
    draw c.png "$work/ktx2" --no-labels --tone linear --mean-exposure
    draw d.png "$work/ktx2" --no-labels --tone linear --mean-exposure --ev 3
    same c.png d.png
    wrong 2 '*--turntable*--offscreen*' "$work/ktx2" --turntable 3
}

# --stats: words of NAME=NUMBER, and what draws; in the room the probe's, too.
test_stats() {
    local number='[0-9]+\.[0-9]' room=
    local by='by=(EGL|OSMesa) [A-Za-z].*'
    for mode in 'spheres --grid 2x2' 'scene --probe-size 32 --seconds 1.5'; do
        iblview "$work/ktx2" --offscreen a.png --size 48x36 --antialias 1 \
            --stats --mode $mode >said || is 0 $? status
        has -Ex "mode=${mode%% *} frames=16 frame=$number worst=$number\
( gpu=$number)?$room $by" said
        room=" seconds=1.500 ms=$number"
    done
    iblview "$work/ktx2" --contact-sheet a.png $small --mode levels --stats >said
    has '^mode=levels frames=160 ' said
}

test_samples() {
    local with='--reflection reference -q'
    draw a.png "$work/ktx2" $with --samples 32
    draw b.png "$work/ktx2" $with --samples 33
    differ a.png b.png
    draw b.png "$work/ktx2" $with --samples 256
    draw a.png "$work/ktx2" $with
    same a.png b.png
    iblview "$work/ktx2" --offscreen c.png $small --compare difference \
        --samples 33 >said
    has ' 33 samples a pixel' said
}

# Places along the axes of each sheet are the pictures of the same options; the
# caption is in the upper 24 rows.
test_contact_sheets() {
    local rows columns row column sheet picture
    while IFS='|' read -r rows columns row column sheet picture; do
        iblview "$work/ktx2" --contact-sheet sheet.png $small $sheet ||
            is 0 $? status
        [ "$(size sheet.png)" = "$((4 + columns * 52)) x $((4 + rows * 40))" ] ||
            size sheet.png
        draw a.png "$work/ktx2" -q $picture
        node "$work/bin/png.mjs" \
            "sheet.png@$((4 + 52 * column)),$((4 + 40 * row)),24" a.png 0
    done <<END
12|4|1|2|--turn 30|--material copper --turn 210 --grid 2x4
2|5|1|4|--ev 1 --mode levels|--level 1 --ev 3 --mode levels
END
}

test_notes_on_what_does_not_fit() {
    $bake --quiet -o out --lobe charlie --roughness-range 0.25:1 \
        --lut-kind multiscatter >said 2>&1
    # The map is not at hand.
    sed -i 's/"path": "[^"]*"/"path": "gone.exr"/' out/env.json
    iblview out --offscreen a.png $small >said 2>&1 || is 0 $? status
    lines 4 said
    has 'lobe charlie' said
    has 'level 0 is of roughness 0.25' said
    has 'of kind multiscatter: not used' said
    has 'made with the geometry smith' said
    iblview out --offscreen a.png $small -q 2>&1
}

# Each part has its line: without the map, level 0 is the reference of a mirror;
# what is no metal has irradiance, too.
test_errors() {
    cp -r "$work/ktx2" out
    sed -i 's/"path": "[^"]*"/"path": "gone.exr"/' out/*.json
    iblview out --offscreen a.png --size 32x32 --grid 2x1 --samples 16 \
        --compare split --roughness 0:0 >said || is 0 $? status
    awk 'NR == 3 && /metallic 0.000, roughness 0.000$/ { plastic = $2 }
         NR == 4 && /metallic 1.000, roughness 0.000$/ { metal = $2 }
         NR > 2 { pixels += NR == 5 ? -$1 : $1 }
         END { if (NR != 5 || pixels || !plastic || metal > 0.1 * plastic)
                   print "found", plastic, metal, NR, "lines and", pixels,
                       "pixels of no sphere, wanted metal <= 0.1 plastic, 5, 0" }' said
}

# ---- what does not work --------------------------------------------------

test_misuse() {
    wrong 2 '*nothing to show*--help' --offscreen a.png
    wrong 2 '*env.exr: is both input and output: *' env.exr --offscreen env.exr
    wrong 2 '*twice*' "$work/ktx2" twice
    wrong 2 '*--frobnicate*unknown*--help' --frobnicate x
    wrong 2 '*--material mud*it takes gold, *' x --material mud
    wrong 2 '*--size 0x9*' x --size 0x9
    wrong 2 '*--grid 17x1*16x16' x --grid 17x1
    wrong 2 '*--metallic 0:2*' x --metallic 0:2
    wrong 2 '*--light: is no more: --lights*' x --light 1,2,3,1,1,1
    wrong 2 '*--offscreen*.png*' x --offscreen ''
    wrong 2 '*--offscreen a.jpg: *.png*.exr*' x --offscreen a.jpg
    wrong 2 '*--samples 2: only with*' x --samples 2 --reflection reference
    wrong 2 '*--samples 2: *reference*' x --samples 2 --offscreen a.png
    wrong 2 '*--contact-sheet*spheres and levels' x --mode table \
        --contact-sheet a.png
    wrong 2 '*--frames: is no more*' x --frames 2
}

test_missing_and_wrong_files() {
    local to='--offscreen a.png'
    wrong 1 '*nowhere*' nowhere $to
    iblbake -q --only lut --lut-kind charlie --lut-size 4 -o kinds
    wrong 1 '*of kind charlie*split*' "$work/ktx2" $to \
        --lut kinds/brdf_lut_charlie.ktx2
}

test_unwritable_outputs() {
    mkdir dir.png
    wrong 1 '*nowhere*' "$work/ktx2" $small --offscreen nowhere/a.png
    wrong 1 '*dir.png*' "$work/ktx2" $small --offscreen dir.png
    wrong 1 '*nowhere*' "$work/ktx2" $small --contact-sheet nowhere/a.png \
        --mode levels
    iblview --keys >/dev/full 2>err
    is 1 $? 'status of a full stdout'
    lines 1 err
}

# A file-size limit is an error like another.
test_nothing_half_written() {
    draw a.png "$work/ktx2"
    cp a.png old.png
    (ulimit -f 0
     iblview "$work/ktx2" $small --ev 1 --offscreen a.png 2>&1
     echo "status $?") | grep -vx 'status 1' | grep -vx 'iblview: .*a.png.*'
    same a.png old.png
}

test_no_display() {
    wrong 1 '*--offscreen*' "$work/ktx2"
    # What is wrong with a display, too, comes first.
    wrong 1 '*nowhere*' nowhere
}

# A name cannot break a line or steer the terminal.
test_odd_names() {
    local odd=$'a\nb\033[31m' scene='--mode scene --probe-size 16'
    cp -r "$work/ktx2" "$odd"
    iblview "$odd" --probe-set "$odd/gone.json" $scene --offscreen a.png \
        >said 2>&1 && is 1 0 status
    make_scene a '[{"name": "a\nb\u001b[31m"}]'
    iblview "$odd" --model a.gltf --offscreen a.png $small --samples 1 \
        --compare split --against-set "$odd" --against reference >>said ||
        is 0 $? status
    LC_ALL=C grep -n '[^ -~]' said
    count 2 'a?b?\[31m' said
}

# ---- what it says of itself ----------------------------------------------

test_texts() {
    [ "$(iblview --version)" = "$(iblbake --version | head -n 1 |
        sed 's/iblbake/iblview/; s/ (.*//')" ] || iblview --version
    # Headings, then keys in 16 columns and what they do.
    iblview --keys | awk '/^[A-Z][a-z ]*:$/ || !length { next }
        length > 100 || !/^  [^ ]/ || substr($0, 18, 1) != " " ||
        substr($0, 19) !~ /^[A-Za-z]/'
    # Each key has one meaning.
    iblview --keys | cut -c3-17 | tr -s ' ' '\n' | sort | uniq -d
    # Nothing but what they ask for, to be piped.
    iblview --keys 2>&1 >/dev/null
    # Options that README.md names are there.
    iblview --help | grep -o -- '--[a-z-]*' | sort -u >known
    sed -n 's/^.*iblview \(.*\)/\1/p' "$top/README.md" | sed 's/#.*//' |
        grep -o -- '--[a-z-]*' | sort -u | comm -13 known -
}

for t in $(compgen -A function test_); do
    picked "$t" || continue
    rm -rf "$work/case"
    mkdir "$work/case"
    cd "$work/case" || exit 1
    cp "$work/env.hdr" "$work/env.exr" .
    verdict "$t" "$($t 2>&1 | head -n 12)"
    cd "$top" || exit 1
done
end

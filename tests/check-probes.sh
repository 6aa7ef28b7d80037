#!/bin/bash
# SPDX-License-Identifier: MIT
# Runs `iblbake probes` as a user would: sets against bakes of their maps one
# by one, when a set is baked again, mistakes in sets, grids. BUILD names the
# build.
set -u
. tests/lib.sh
slow='options_change|cubes|mended'
need node
use iblbake
mkenv hdr 32 16 >"$work/sun.hdr"
mkenv exr 64 32 BGR >"$work/mild.exr"
mkenv exr 32 16 BGR >"$work/other.exr"
cd "$work" || exit 1

layer() { node "$top/tests/cli/layer.mjs" "$@"; }
expect() { # kept or wrote, [options]: what a run does with a set
    local want=$1
    shift
    iblbake probes "$@" -v 2>err >/dev/null || is 0 $? "$*: status"
    has "iblbake: $want .*/index.json$" err
}
state() { find "$1" -type f -printf '%p %i %T@\n' | sort; }

# Three probes, of which two come in another order, and the sky.
cat >set.json <<'END'
{"version": 1,
 "defaults": {"size": 16, "levels": 3, "irradiance": 4, "lut_size": 16},
 "global": {"capture": {"equirect": "other.exr"}},
 "probes": [
  {"name": "hall", "position": [0, 1, 0], "capture": {"equirect": "mild.exr"},
   "influence": {"box": {"centre": [0, 1, 0], "half": [8, 7, 8]}}, "blend": 1,
   "proxy": {"sphere": {"centre": [0, 1, 0], "radius": 6}}},
  {"name": "lamp", "position": [1, 1, 0], "capture": {"equirect": "sun.hdr"},
   "influence": {"sphere": {"centre": [1, 1, 0], "radius": 1}}}
 ]}
END
edit() { # JSON changed by a line of JavaScript on s
    node -e "const fs = require('fs');
        const s = JSON.parse(fs.readFileSync('$1')); $2;
        fs.writeFileSync('$3', JSON.stringify(s))"
}
edits() { # JSON changed by each line of standard input, up to a |: bad0.json, ...
    node -e "const fs = require('fs'), text = fs.readFileSync('$1');
        fs.readFileSync(0, 'utf8').trimEnd().split('\n').forEach((line, i) => {
            const s = JSON.parse(text);
            eval(line.split('|')[0]);
            fs.writeFileSync('bad' + i + '.json', JSON.stringify(s));
        })"
}

test_layers_are_single_bakes() {
    local same=()
    local size='--size 16 --levels 3 --irradiance-size 4 --lut-size 16'
    works iblbake probes -q set.json -o out
    set -- lamp sun.hdr hall mild.exr global other.exr
    for layer in 0 1 2; do
        # shellcheck disable=SC2086
        works iblbake -q $size "$2" -o one --name "$1"
        same+=(out/probes_specular.ktx2 $layer "one/$1_specular.ktx2"
            out/probes_irradiance.ktx2 $layer "one/$1_irradiance.ktx2")
        shift 2
    done
    layer out/brdf_lut.ktx2 0 one/brdf_lut.ktx2 "${same[@]}"
}
test_index() {
    js <<'END'
const i = json('out/index.json');
equal('index', [i.probes.map(p => [p.name, p.layer]), i.specular.roughness,
    i.specular.lod_scale, i.files.brdf_lut.file], [[['lamp', 0], ['hall', 1]],
    [0, +(1 - Math.sqrt(0.5)).toPrecision(15), 1], 2, 'brdf_lut.ktx2']);
END
}

# ---- what is baked again -------------------------------------------------
test_unchanged_is_left_alone() {
    local before
    before=$(state out)
    expect kept set.json -o out
    is "$before" "$(state out)"
}
# A later run leaves what a run from the start does.
like_new() { # SET, [options]
    rm -rf new
    iblbake probes -q "$@" -o new
    diff -r new inc
}
test_changes() {
    local change
    rm -rf inc && cp -a out inc
    cp mild.exr saved && mkenv exr 48 24 BGR >mild.exr
    expect wrote set.json -o inc
    like_new set.json
    mv saved mild.exr
    expect wrote set.json -o inc
    diff -r out inc
    # Of layers that are in other places, more or fewer, too.
    while read -r change; do
        edit set.json "$change" moved.json
        expect wrote moved.json -o inc
        like_new moved.json
        expect kept moved.json -o inc
    done <<'END'
s.probes[0].position = [0, 1, 5]
s.probes[0].priority = 1
s.probes.push({...s.probes[0], name: "twin", priority: -1})
s.probes.shift(); delete s.global
END
}
# Each option that decides what is in a file makes another hash, and so does
# each setting of a set. What --help lists is here.
test_options_change() {
    local change options map
    map='s.probes = [s.probes[0]]; delete s.global;
        s.probes[0].capture.equirect ='
    mkenv exr 64 32 BGR 0.5 >dim.exr
    { printf 'P6 32 16 255\n' && head -c 1536 sun.hdr; } >low.ppm
    edit set.json "$map 'low.ppm'" low.json
    edit set.json "$map 'lying.hdr'" lying.json
    edit set.json "$map 'layers.exr'" layers.json
    if have oiiotool >/dev/null; then
        oiiotool mild.exr dim.exr --chappend --chnames R,G,B,l.R,l.G,l.B \
            -o layers.exr
    else
        sed 's/layers.exr/mild.exr/' layers.json >x && mv x layers.json
    fi
    for set in set low lying layers; do
        iblbake probes -q $set.json -o base_$set
    done
    while read -r set options; do
        rm -rf inc && cp -a base_"${set%.json}" inc
        # shellcheck disable=SC2086
        expect wrote $set -o inc $options
        echo "$options" | grep -o -e '--[a-z-]*' >>tried
    done <<'END'
set.json --alpha ignore
set.json --container dds
set.json --zstd 3
set.json --pixel rgba32f
set.json --pixel bc6h --quality fast
set.json --overflow clip
set.json --size 8
set.json --levels 2
set.json --irradiance 8
set.json --any-aspect
set.json --strict
set.json --isa c
set.json --primaries acescg
set.json --exposure 1
set.json --clamp 1
low.json --input-transfer linear
lying.json --input-layout hcross
lying.json --face-order px,nx,py,ny,pz,nz/180
layers.json --layer l
layers.json --part 0
END
    expect kept layers.json -o inc -j 1 --max-memory 1G --part 0 --sync
    expect wrote layers.json -o inc --part 0 --force
    iblbake probes --help | sed -n '/^In place/,/^Running/{
        s/^ *\(--[a-z-]*\).*/\1/p
    }' | sort -u >listed
    sort -u tried | comm -23 listed -
    while read -r change; do
        rm -rf inc && cp -a out inc
        edit set.json "s.defaults.$change" changed.json
        expect wrote changed.json -o inc
    done <<'END'
size = 8
levels = 2
mapping = "linear"
method = "sampled"
samples = 17
tolerance = 0.5
pixel = "rgba32f"
quality = "normal"
overflow = "clip"
container = "ktx"
zstd = 1
irradiance = 8
lut_size = 8
alpha = "straight"
END
    iblbake probes -q set.json -o blocks --pixel bc6h --quality fast
    count 9 '"nrmse"' blocks/index.json
    iblbake probes -q set.json -o packed --zstd 3
    count 3 '"zstd": 3' packed/index.json
}
# The sun is beyond half floats: clipping loses what spreading moves.
test_overflow() {
    iblbake probes -q set.json -o clipped --size 64 --overflow clip
    iblbake probes set.json -o spread --size 64 2>err
    has 'probes.1..capture: [0-9]* texel.* brighter .* light went to' err
    js <<'END'
const read = d => json(d + '/index.json').probes;
const [[lost, none], [moved]] =
    ['clipped', 'spread'].map(d => read(d).map(p => p.beyond));
must('texels that moved', read('spread')[0].saturated >= moved.texels, moved);
must('what spreading moves lost by clipping', !none && moved?.texels > 0 &&
    moved.moved > 0 && !moved.lost && !lost.moved && lost.lost === moved.moved,
    [none, moved, lost]);
END
}

# Files that are missing, or newer than the index as what is edited or what a
# killed run has left; an index of another hash or version.
test_damage_is_mended() {
    local f
    for f in out/*; do
        f=${f#out/}
        for how in missing edited; do
            taken || continue
            rm -rf inc && cp -a out inc
            case $how in
            missing) rm "inc/$f" ;;
            edited) [ "$f" = index.json ] && echo >"inc/$f" || printf '\377' |
                dd of="inc/$f" bs=1 seek=200 conv=notrunc status=none ;;
            esac
            expect wrote set.json -o inc
            diff -r out inc || echo "of $f $how"
        done
    done
    for change in 's.hash = "0"' 'delete s.hash'; do
        rm -rf inc && cp -a out inc
        edit out/index.json "$change" inc/index.json
        expect wrote set.json -o inc
        diff -r out inc || echo "of $change"
    done
}
# A run that is killed between two renames leaves what the next one bakes anew.
test_killed_run() {
    [ $sanitized = no ] || return
    preload
    edit set.json 's.defaults.tolerance = 0.01' finer.json
    rm -rf inc && cp -a out inc
    (LD_PRELOAD=$work/preload.so FAULT='rename -9 1' iblbake probes -q \
        finer.json -o inc) 2>/dev/null
    cmp -s inc/probes_specular.ktx2 out/probes_specular.ktx2 &&
        echo 'wanted a new probes_specular.ktx2, found the old one'
    cmp inc/index.json out/index.json
    expect wrote set.json -o inc
    diff -r -x '.*' out inc
}

# ---- cubes ----------------------------------------------------------------
# The same cube as faces and as both crosses: flat RGBE, each texel a colour
# of its own. Level 0 is the cube itself.
cat >cube.mjs <<'END'
import fs from 'fs';
const n = 16, rgbe = (f, x, y) => [30 + 40 * f, 20 + 14 * x, 20 + 14 * y, 129];
const write = (name, w, h, at) => {
    const bytes = [];
    for (let y = 0; y < h; y++)
        for (let x = 0; x < w; x++) bytes.push(...(at(x, y) ?? [0, 0, 0, 0]));
    fs.writeFileSync(name, Buffer.concat([Buffer.from(
        `#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y ${h} +X ${w}\n`),
        Buffer.from(bytes)]));
};
for (let f = 0; f < 6; f++)
    write(`face${f}.hdr`, n, n, (x, y) => rgbe(f, x, y));
const lying = [[-1, 2, -1, -1], [1, 4, 0, 5], [-1, 3, -1, -1]];
const cell = (grid, x, y) => grid[Math.floor(y / n)][Math.floor(x / n)];
write('lying.hdr', 4 * n, 3 * n, (x, y) => cell(lying, x, y) < 0 ? null :
    rgbe(cell(lying, x, y), x % n, y % n));
const upright = [[-1, 2, -1], [1, 4, 0], [-1, 3, -1], [-1, 5, -1]];
write('upright.hdr', 3 * n, 4 * n, (x, y) => {
    const f = cell(upright, x, y);
    if (f < 0) return null;
    return f === 5 ? rgbe(5, n - 1 - x % n, n - 1 - y % n)
                   : rgbe(f, x % n, y % n);
});
write('narrow.hdr', 8, 16, () => [9, 9, 9, 129]);
write('small.hdr', 8, 8, () => [9, 9, 9, 129]);
END
node cube.mjs
test_cubes() {
    local same=()
    local f='["face0.hdr","face1.hdr","face2.hdr","face3.hdr","face4.hdr",
        "face5.hdr"]'
    edit set.json "delete s.global; s.probes = ['faces', 'cross', 'cross'].map(
        (k, i) => ({...s.probes[0], name: 'p' + i, capture: {[k]:
        [$f, '$PWD/lying.hdr', 'upright.hdr'][i]}}))" cubes.json
    iblbake probes -q cubes.json -o cubes --pixel rgba32f
    edit cubes.json 's.probes = s.probes.slice(0, 1)' cube.json
    iblbake probes -q cube.json -o cube --pixel rgba32f
    for layer in 0 1 2; do
        same+=(cubes/probes_specular.ktx2 $layer cube/probes_specular.ktx2
            cubes/probes_irradiance.ktx2 $layer cube/probes_irradiance.ktx2)
    done
    layer "${same[@]}"
    # Half as large it is its mips, whose edges are as sharp.
    iblbake probes -q cube.json -o half --size 8 --pixel rgba32f
    js <<'END'
for (const [name, n] of [['cube', 16], ['half', 8]]) {
    const b = fs.readFileSync(name + '/probes_specular.ktx2');
    const from = Number(b.readBigUInt64LE(80)), at = x => (x + .5) * 16 / n - .5;
    for (let i = 0; i < 6 * n * n; i += 13) {
        const f = i / n / n | 0, y = (i / n | 0) % n, x = i % n;
        [30 + 40 * f, 20 + 14 * at(x), 20 + 14 * at(y)].forEach((v, c) =>
            near(`${name}: face ${f} ${x} ${y} ${c}`,
                b.readFloatLE(from + 16 * i + 4 * c), v / 128, 0.01));
    }
}
END
    works iblbake probes -q cube.json -o odd --size 12
    works iblbake probes -q cube.json -o twice --size 32
}

# ---- alpha -------------------------------------------------------------------
mkenv exr 64 32 ABGR 0 >hole.exr
mkenv exr 64 32 BGR 0 >hole_colours.exr
mkenv exr 64 32 Y 0 >hole_alpha.exr
mkenv exr 64 32 ABGR 0.5 >veil.exr
mkenv exr 64 32 ABGR 0.9995 >rounded.exr
mkenv exr 64 32 ABGR 0 0 >blind.exr
mkenv exr 64 32 ABGR nan >nan.exr
mkenv exr 64 32 ABGR 255 >large.exr
edit set.json 's.probes[1].capture.equirect = "hole.exr"' hole.json

test_alpha_is_filtered_as_colours() {
    local size='--size 16 --levels 3 --irradiance-size 4 --lut-size 16'
    works iblbake probes -v hole.json -o alpha 2>err
    has 'layer 0: lamp: baked, with alpha$' err
    for part in colours alpha; do
        # shellcheck disable=SC2086
        works iblbake -q $size hole_$part.exr -o one --name $part
    done
    for kind in specular irradiance; do
        layer --alpha one/alpha_$kind.ktx2 alpha/probes_$kind.ktx2 0 \
            one/colours_$kind.ktx2
        layer alpha/probes_$kind.ktx2 1 one/hall_$kind.ktx2 \
            alpha/probes_$kind.ktx2 2 one/global_$kind.ktx2
        js $kind <<'END'
const b = fs.readFileSync(`alpha/probes_${process.argv[2]}.ktx2`);
equal('premultiplied', [b[b.readUInt32LE(48) + 15],
    b.includes('iblbake.alpha\0premultiplied\0')], [1, true]);
END
    done
    js <<'END'
const {probes, global} = json('alpha/index.json');
equal('alpha', [...probes, global].map(p => p.alpha), [true, false, undefined]);
equal('none', json('out/index.json').probes.map(p => p.alpha), [false, false]);
END
    for threads in 1 3; do
        iblbake probes -q -j $threads hole.json -o j$threads
        diff -r alpha j$threads
    done
}
# One face is half seen.
test_alpha_of_faces() {
    mkenv exr 16 16 ABGR 1 >seen.exr
    mkenv exr 16 16 ABGR 0.5 0.5 >half.exr
    edit set.json "delete s.global; s.probes = [{...s.probes[0], capture:
        {faces: [...Array(5).fill('seen.exr'), 'half.exr']}}]" faces.json
    works iblbake probes -q faces.json -o faces
    js <<'END'
const b = fs.readFileSync('faces/probes_specular.ktx2');
const from = Number(b.readBigUInt64LE(80)), alpha = i => b.readUInt16LE(from + 8 * i + 6);
equal('alpha', Array.from({length: 6 * 256}, (_, i) => alpha(i)),
    Array.from({length: 6 * 256}, (_, i) => i < 5 * 256 ? 0x3C00 : 0x3800));
END
}
test_alpha_harmonics() {
    rm -rf inc
    iblbake probes -q hole.json -o inc --irradiance sh
    for part in colours alpha; do
        iblbake -q hole_$part.exr -o one --only json --name $part
    done
    js <<'END'
const {probes} = json('inc/index.json');
const part = n => json(`one/${n}.json`).sh.irradiance;
part('colours').flat().forEach((c, i) => near('sh', probes[0].sh.flat()[i], c, 1e-6));
part('alpha').forEach((c, i) => near('alpha', probes[0].alpha_sh[i], c[0], 1e-6));
equal('no alpha', probes[1].alpha_sh, undefined);
END
}
test_alpha_of_no_account() {
    # Of renderers' rounding, and of the global environment.
    edit hole.json 's.probes[1].capture.equirect = "rounded.exr"' round.json
    works iblbake probes -q round.json -o inc --pixel rgb9e5
    edit set.json 's.global.capture.equirect = "blind.exr"' sky.json
    works iblbake probes sky.json -o inc --pixel rgb9e5 2>err
    grep -v 'is black everywhere$' err
    works iblbake probes -q hole.json -o inc --pixel rgb9e5 --alpha ignore
}
test_alpha_warnings() {
    edit hole.json "s.probes[1].capture.equirect = 'large.exr';
        s.probes[0].capture.equirect = 'nan.exr'" odd.json
    works iblbake probes odd.json -o inc 2>err
    has '^iblbake: warning: nan.exr: .* finite in 140 pixels, .* 1 in 0, ' err
    has '^iblbake: warning: large.exr: .* in 0 pixels, .* 1 in 140, ' err
    lines 2 err
    # Colours that were not multiplied: those of veil, alpha of hole.
    node -e "const fs = require('fs'), row = 64 * 4;
        const b = fs.readFileSync('hole.exr'), c = fs.readFileSync('veil.exr');
        for (let y = 0; y < 32; y++) {
            const at = b.length - (32 - y) * (4 * row + 8) + 8;
            c.copy(b, at + row, at + row, at + 4 * row);
        }
        fs.writeFileSync('shown.exr', b);"
    edit hole.json 's.probes[1].capture.equirect = "shown.exr"' odd.json
    works iblbake probes odd.json -o inc 2>err
    case $(cat err) in
    'iblbake: warning: shown.exr: 140 pixels had a colour but alpha 0, '*) ;;
    *) cat err ;;
    esac
    works iblbake probes odd.json -o inc --alpha straight 2>err
    lines 0 err
}

# Each layer is judged by its own capture, with alpha and of cubes, too: a layer
# of another is not right.
test_verify() {
    edit set.json "s.probes = [{...s.probes[0], name: 'p', capture: {cross:
        'upright.hdr'}}, {...s.probes[0], capture: {faces: Array.from({length:
        6}, (_, i) => 'face' + i + '.hdr')}}]" cubes.json
    iblbake probes -q hole.json -o alpha && iblbake probes -q cubes.json -o cubes
    for set in hole.json/alpha cubes.json/cubes; do
        works iblbake verify -q --texels 24 --max-error 0.02 ${set%/*} ${set#*/}
    done
    iblbake verify --texels 24 set.json alpha --max-error 0.02 >said 2>err
    is 1 $? 'status of what was seen through a hole'
    has -x 'lamp, layer 0: sun.hdr' said
    has -x 'hall, layer 1: mild.exr' said
    has '^(global), layer 2: other.exr' said
    count 1 '^brdf_lut ' said
    lines 1 err
    has '^iblbake: lamp: level 0 of specular has ' err
    works iblbake verify -q --texels 24 --max-error 0.02 other.exr --array-layer 2 \
        --specular alpha/probes_specular.ktx2
    edit set.json 's.probes[0].name = "room"' moved.json
    while IFS='|' read -r command status glob; do
        # shellcheck disable=SC2086
        refused "$status" "iblbake: $glob" iblbake verify -q $command
    done <<'END'
moved.json alpha|1|moved.json: is not the set of alpha/index.json: bake it again
set.json sub|1|sub/index.json: cannot be read: *
set.json|2|set.json: a set of probes is judged by the directory of its bake, *
set.json alpha --json x|2|set.json: a set of probes *
other.exr --specular alpha/probes_specular.ktx2|1|*: *3 layers, *
other.exr --array-layer 3 --specular alpha/probes_specular.ktx2|1|alpha/probes_specular.ktx2: has no layer 3, but 0 to 2: *
END
}

# ---- several sets ------------------------------------------------------------
# Each set is in a directory of its name, and in one shard.
test_shards() {
    edit set.json 's.probes.pop()' fewer.json
    mkdir -p sub && edit set.json 'for (const p of [...s.probes, s.global])
        p.capture.equirect = "../" + p.capture.equirect' sub/moved.json
    iblbake probes -q hole.json fewer.json sub/moved.json -o all --size 8
    for k in 3 1 2; do
        expect wrote hole.json fewer.json sub/moved.json --size 8 -o parts \
            --shard $k/3
        is $((1 + k % 3)) "$(find parts -name index.json | wc -l)" "sets of $(ls -m parts)"
    done
    diff -r all parts
    iblbake probes -q hole.json -o hole --size 8 && diff -r hole all/hole
    # What one call has baked, another keeps.
    expect kept hole.json fewer.json -o parts --size 8
    iblbake probes -q hole.json -o one_part --shard 1/1 --size 8
    diff -r hole one_part
}

# ---- mistakes --------------------------------------------------------------
# One line a mistake: what is done to the set, and what the message says.
test_mistakes() {
    local change glob n=0
    cat >mistakes <<'END'
s.version = 2|version: expected 1, found 2
delete s.probes; s.min = [0, 0, 0]|is a grid: add --grid, *
s.extra = 1|extra: expected no such member, but version, defaults, global or probes; found "extra"
s.probes = []|probes: expected *, found an array of 0
s.probes = Array(341).fill(s.probes[0])|probes: expected an array of 1 to 340, *
s.defaults.pixel = "rgb8"|defaults.pixel: expected rgba16f, rgba32f, rgb9e5, r11g11b10f, bc6h, uastc-hdr or astc4x4hdr, found "rgb8"
s.probes[0].capture.equirect = "blind.exr"|probes[[]0].capture: alpha is 0 everywhere, so nothing *, or take --alpha ignore
s.probes[0].capture.equirect = "hole.exr"; s.defaults.pixel = "rgb9e5"|probes[[]0].capture: has alpha below 1, which rgb9e5 has no room for: choose --pixel rgba16f or rgba32f, *
s.global = {}|global.capture: expected an object with equirect, cross or faces, found nothing
delete s.probes[0].name|probes[[]0].name: expected a string that is not empty, found nothing
s.probes[1].name = "hall"|probes[[]1].name: expected a name of its own, found "hall", which probes[[]0] has
s.probes[0].position = [1, 2]|probes[[]0].position: expected an array of 3 numbers, found an array of 2
delete s.probes[0].influence|probes[[]0].influence: expected an object with box or sphere, found nothing
s.probes[0].influence.sphere = {}|probes[[]0].influence: expected one of box and sphere, found *
s.probes[0].influence.box.half[1] = 0|probes[[]0].influence.box.half[[]1]: expected a number above 0, up to *, found 0
s.probes[0].blend = 7.5|probes[[]0].blend: expected at most 7, half the influence's least width, found 7.5
s.probes[0].proxy.sphere.centre = [9, 0, 0]|probes[[]0].proxy: expected a volume around the probe's position, found it outside
s.probes[0].capture = {faces: ["a"]}|probes[[]0].capture.faces: expected an array of 6 files, *, found an array of 1
s.probes[0].capture.equirect = "no.exr"|probes[[]0].capture: no.exr: cannot be read: No such file or directory
s.probes[0].capture = {faces: ["a,b", ..."12345"]}|probes[[]0].capture: expected faces without commas in their paths, found *
END
    edits set.json <mistakes
    while IFS='|' read -r change glob; do
        mv bad$n.json bad.json
        n=$((n + 1))
        refused 1 "iblbake: bad.json: $glob" iblbake probes bad.json -o bad |
            sed "s|^|$change: |"
    done <mistakes
}
test_other_mistakes() {
    local command status glob
    mkdir self && cp ./*.exr ./*.hdr self && cp set.json self/index.json
    for name in narrow small; do
        edit set.json "s.probes[0].capture = {faces: [...Array(5).fill(
            'face0.hdr'), '$name.hdr']}" $name.json
    done
    while IFS='|' read -r command status glob; do
        # shellcheck disable=SC2086
        refused "$status" "iblbake: $glob" timeout 300 iblbake probes $command
    done <<'END'
no.json -o bad|1|no.json: cannot be read: No such file or directory
-o bad|2|no set: *
set.json|2|no output directory: *
narrow.json -o bad|1|narrow.hdr: 8x16 pixels: a face is square, 16384 at most
small.json -o bad|1|small.hdr: 8 pixels wide, but the faces before it 16
set.json sub/set.json -o bad|1|set.json and sub/set.json: both would be in bad/set: *
set.json hole.json -o bad --shard 1/3|2|--shard 1/3: parts are of whole sets, of which there are 2: take at most 2 shards
--grid room.json hole.json|2|hole.json: a second grid after room.json: *
merge part1 part2 -o bad|2|merge: is no more: *: iblbake probes --shard K/N *
--grid room.json --sync|2|--sync: standard output is no file: add -o FILE
self/index.json -o self|1|self/index.json: is both input and output: *
END
}
# ---- grids ------------------------------------------------------------------
cat >room.json <<'END'
{"version": 1, "min": [-6, 0, -4], "max": [6, 3, 4], "spacing": 4,
 "solid": [{"min": [-1, 0, -5], "max": [0, 9, 0]}],
 "capture": {"equirect": "grid/{name}.exr"}, "defaults": {"size": 8}}
END
test_grid() {
    works iblbake probes --grid room.json -o grid.json
    iblbake probes --grid room.json | cmp - grid.json
    cp room.json kept.json
    refused 1 'iblbake: room.json: is both input and output: choose another *' \
        iblbake probes --grid room.json -o room.json
    cmp room.json kept.json
    js <<'END'
const {probes} = json('grid.json'), {position, influence: {box}, blend, capture} = probes[3];
equal('names', probes.map(p => p.name.slice(6)),
    ['0_0_0', '2_0_0', '0_0_1', '1_0_1', '2_0_1']);
equal('probe', [position, box.centre, box.half, blend, capture.equirect],
    [[0, 1.5, 2], [0, 1.5, 0], [2.75, 3, 5.5], 1.5, 'grid/probe_1_0_1.exr']);
END
    mkdir grid
    for name in 0_0_0 2_0_0 0_0_1 1_0_1 2_0_1; do
        cp mild.exr grid/probe_$name.exr
    done
    works iblbake probes -q grid.json -o gridded
    local change glob n=0
    cat >mistakes <<'END'
s.spacing = 0.001|spacing: expected at most 1000 cells along an axis, *
delete s.spacing; s.counts = [1, 0, 1]|counts[[]1]: expected a whole number from 1 to 1000, found 0
s.spacing = 0.8|expected a grid of at most 341 probes, found more*
s.solid[0] = {min: [-9, -9, -9], max: [9, 9, 9]}|expected a cell that is free, found all 6 solid
s.name = "p{x}"|name: expected a name with {z}, *, found "p{x}"
s.blend = 9|blend: expected a number from 0 to 3, found 9
s.probes = []|is a set already: leave out --grid
END
    edits room.json <mistakes
    while IFS='|' read -r change glob; do
        mv bad$n.json bad.json
        n=$((n + 1))
        refused 1 "iblbake: bad.json: $glob" iblbake probes --grid bad.json
    done <mistakes
}

# The light that a set leaves to the outside, by the manual's words: of walls,
# as boxes or spheres, at points of a finer grid than what is tested has.
cat >outside.mjs <<'END'
const influence = (p, x) => {
    const {box, sphere} = p.influence, c = (box ?? sphere).centre;
    const off = c.map((v, k) => Math.abs(x[k] - v));
    const depth = box ? Math.min(...box.half.map((h, k) => h - off[k]))
                      : sphere.radius - Math.hypot(...off);
    const t = Math.min(Math.max(depth / (p.blend || 1e-12), 0), 1);
    return t * t * (3 - 2 * t);
};
export function outside(probes, volume, hidden = () => false, n = 40) {
    const {box, sphere} = volume, {centre} = box ?? sphere;
    let worst = 0;
    for (let i = 0; i < 6 * (n + 1) ** 2; i++) {
        const d = [i % 2 ? 1 : -1, (i / 6 | 0) % (n + 1) * 2 / n - 1,
            (i / 6 / (n + 1) | 0) * 2 / n - 1], axis = (i / 2 | 0) % 3;
        d.unshift(...d.splice(3 - axis, axis));
        const l = sphere ? Math.hypot(...d) / sphere.radius : 1;
        const x = centre.map((c, k) => c + d[k] / l * (box ? box.half[k] : 1));
        const sum = probes.reduce((s, p) => s + influence(p, x), 0);
        if (!hidden(x)) worst = Math.max(worst, 1 - sum);
    }
    return worst;
}
export const box = ({min, max}) => ({box: {
    centre: min.map((a, k) => (a + max[k]) / 2),
    half: min.map((a, k) => (max[k] - a) / 2)}});
END
# The examples of the manual: of a hall with proxies, and of a room as a grid.
test_manual_lights_its_walls() {
    sed -n '/^A hall/,/^\.Ed/{/^[{} ]/p}' "$top/man/iblbake-probes.1" \
        >hall_manual.json
    sed -n '/^\$ cat room/,/^\.Ed/{/^[{} ]/p}' "$top/man/iblbake-probes.1" \
        >room_manual.json
    works iblbake probes --grid room_manual.json -o room_set.json
    works iblbake probes --grid room.json -o grid.json
    js <<'END'
import('./outside.mjs').then(({outside, box}) => {
    const hall = json('hall_manual.json').probes;
    for (const p of hall)
        near('hall: ' + p.name, outside(hall, p.proxy), 0, 1e-9);
    for (const [set, grid] of [['room_set.json', 'room_manual.json'],
        ['grid.json', 'room.json']]) {
        const {probes} = json(set), g = json(grid);
        const out = x => x.some((v, k) => v < g.min[k] || v > g.max[k]);
        const hidden = x => out(x) || g.solid.some(s => x.every((v, k) =>
            v > s.min[k] && v < s.max[k]));
        for (const part of [g, ...g.solid])
            near(grid, outside(probes, box(part), hidden), 0, 1e-9);
    }
});
END
}
# A change of a set and what is said of it: where light comes from outside.
# Strictly it is refused.
test_walls() {
    js <<'END'
const cases = `
1|"a".*100 %
a.influence.box.half = [7, 3, 10]|
a.influence.box.half = [7, 2.5, 10]|"a".*50 %
a.blend = 0|"a".*100 % .* by a little without one$
a.blend = 0; a.influence.box.half = [6.1, 2.1, 9.1]|
a.influence = ball(0, 2, 0, 10)|"a".*100 %
a.influence = ball(0, 2, 0, 12)|
a.proxy = ball(0, 2, 1, 2)|"a".*100 %
b.proxy = ball(50, 1, 0, 3); a.influence.box.half = [7, 3, 10]|"b".*100 %
delete a.proxy|
a.proxy.box.half = [600, 200, 900]|
b.influence = box(0, 2, 0, 6, 3, 9); a.influence.box.half = [9, 3, 10]|
b.influence = box(6, 2, 0, 1, 3, 10); a.influence = box(-2, 2, 0, 8, 2, 10); b.blend = 1|"a".*100 %
b.proxy = a.proxy; b.position = [-3, 2, 0]; a.position = [3, 2, 0]; b.influence = box(-3, 2, 0, 3.5, 2.5, 9.5); a.influence = box(3, 2, 0, 3.5, 2.5, 9.5); b.blend = 1|50 % .* by the blend$
`.trim().split('\n');
const ball = (x, y, z, radius) => ({sphere: {centre: [x, y, z], radius}});
const box = (x, y, z, ...half) => ({box: {centre: [x, y, z], half}});
const probes = (s, ...options) => {
    fs.writeFileSync('walls.json', JSON.stringify(s));
    return require('child_process').spawnSync('iblbake', ['probes',
        'walls.json', ...options], {encoding: 'utf8'});
};
const capture = {equirect: 'other.exr'}, hall = box(0, 2, 0, 6, 2, 9);
import('./outside.mjs').then(({outside}) => cases.forEach(line => {
    const [change, want] = line.split('|');
    const s = JSON.parse(JSON.stringify({version: 1,
        defaults: {size: 4, levels: 1, irradiance: 1, lut_size: 1}, probes: [
            {name: 'a', position: [0, 2, 0], capture, influence: hall,
                blend: 1, proxy: hall},
            {name: 'b', position: [50, 2, 0], capture,
                influence: ball(50, 2, 0, 2)}]})), [a, b] = s.probes;
    eval(change);
    let run = probes(s, '-o', 'walls');
    const said = run.stderr.trim();
    if (run.status || (want ? !RegExp('^iblbake: warning: walls.json: probe ' +
        '.*' + want).test(said) : said))
        console.log(`${change}: found ${run.status}: ${said}, wanted ${want}`);
    if (!want) {
        for (const p of [a, b].filter(p => p.proxy?.box?.half[0] < 600))
            near(change, outside(s.probes, p.proxy), 0, .01);
        return;
    }
    run = probes(s, '-o', 'bad', '--strict');
    if (run.status !== 1 || run.stderr.trim() !== said.replace('warning: ', ''))
        console.log(`${change}: found ${run.status}: ${run.stderr}, wanted 1: ${said}`);
}));
END
    absent bad
}


# In the order of this file. All others use what the first of them leave.
for name in $(sed -n 's/^\(test_[a-z_]*\)() {$/\1/p' \
    "$top/tests/check-probes.sh"); do
    case $name in
    test_layers_are_single_bakes | test_alpha_is_filtered_as_colours) ;;
    *) picked "$name" || continue ;;
    esac
    verdict "$name" "$($name 2>&1)"
done
end

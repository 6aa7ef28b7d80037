#!/bin/bash
# SPDX-License-Identifier: MIT
#
# Targets: what --target writes and prints. BUILD names the build.
set -u
. tests/lib.sh
need node
use iblbake
mkenv hdr 64 32 >"$work/env.hdr"
small='--size 32'
targets=$(iblbake --target list | sed -n 's/^\([a-z-]*\): .*/\1/p')
filters='unreal unity godot' # which filter maps themselves
targets=${targets%%"${filters%% *}"*}
words() { # TARGET: its options, as the list has them
    iblbake --target list | sed -n "/^$1: /,/^[a-z-]*: /s/^    //p" |
        tr '\n' ' '
}
bake() { # [options]
    iblbake -q $small "$@" env.hdr || is 0 $? "$*: status"
}

test_list() {
    iblbake --target list >list 2>err || is 0 $? status
    lines 0 err
    awk 'length > 80 { print "line " NR " has " length }' list
    is 'three babylon babylon-env filament bevy playcanvas gltf cesium' "$(echo $targets)"
    is "$filters" "$(sed -n 's/^\([a-z-]*\): .*/\1/p' list | tail -n 3 | xargs)"
    iblbake --target list >/dev/full 2>err && is 1 0 'status of a full stdout'
}

# A target is its options, but for its name in the sidecar and Filament's glType.
test_same_as_its_options() {
    local t
    for t in $targets $filters; do
        set -- --levels 2
        case $t in
        babylon* | playcanvas | u* | godot) set -- ;; # which have a number
        esac
        bake --target "$t" "$@" -o "out/$t"
        # shellcheck disable=SC2046
        bake $(words "$t") $small "$@" -o "hand/$t"
        has "^  \"target\": \"$t\"" "out/$t/env.json"
    done 2>&1
    rm -f out/filament/*.ktx hand/filament/*.ktx
    js $targets $filters <<'END'
for (const target of process.argv.slice(2))
    for (const where of ['out', 'hand']) {
        const name = `${where}/${target}/env.json`, sidecar = json(name);
        delete sidecar.options;
        delete sidecar.target;
        if (target === 'filament')
            sidecar.outputs.forEach(o => delete o.xxh3_128);
        fs.writeFileSync(name, JSON.stringify(sidecar, null, 1));
    }
END
    for t in $targets $filters; do
        diff -r "out/$t" "hand/$t"
    done | head -n 4
}

# Sets of one chain are those of single targets byte by byte. With further
# chains the analysis may have more degrees than one needs alone, by which a
# texel in some thousands is rounded the other way.
test_several_are_single_ones() {
    local t f
    # Some of these have harmonics, of others the axes differ.
    bake --target all --sun -o all
    is "$(printf '%s\n' $targets $filters | sort | xargs)" "$(ls all | xargs)"
    for t in filament cesium godot; do
        bake --target "$t" --sun -o "one/$t"
        diff <(ls "one/$t") <(ls "all/$t")
    done
    cmp {one,all}/godot/env_specular.exr
    for f in filament/env_specular.ktx cesium/env_specular.ktx2; do
        [ "$(cmp -l "one/$f" "all/$f" | wc -l)" -lt 40 ] ||
            echo "$f: wanted few other bytes, found $(cmp -l "one/$f" "all/$f" | wc -l)"
    done
    bake --target filament,three --levels 2 --sun -o two
    bake --target filament --levels 2 --sun -o one/filament
    bake --target three --levels 2 --sun -o one/three
    diff -r one/filament two/filament
    diff -r one/three two/three
}

# Every set is read again, in the world's axes, and is what it says.
test_verified() {
    local t
    mkenv exr 64 32 BGR >mild.exr
    iblbake -q $small --target all mild.exr -o out --depfile d || is 0 $? status
    for t in $targets; do
        iblbake verify mild.exr "out/$t" --texels 24 --max-error 0.1 >log 2>&1 ||
            is 0 $? "$t: $(tail -n 1 log): status"
        has '^specular ' log
    done
    find out -type f | sort >made
    tr -d '\\:' <d | tr ' ' '\n' | grep '^out/' | sort | diff made -
    is ' mild.exr' "$(tr -d '\\\n' <d | sed 's/.*://')"
}

# The command line wins, on either side of --target.
test_overrides() {
    bake --target three --quality best -o after
    bake --quality best --target three -o before
    cmp after/env_specular.ktx2 before/env_specular.ktx2
    has '"quality": "best"' after/env.json
    iblbake -q --target bevy --only irradiance,json env.hdr -o only
    is 'env.json env_irradiance.ktx2' "$(ls only | xargs)"
    # What a target sets and has no place any more falls away.
    bake --target bevy,cesium --pixel rgba16f --zstd 0 -o both
    there both/cesium/env_specular.ktx2
    # The level that lights matte surfaces is not of fewer texels.
    bake --target filament,bevy,gltf,cesium --size 4 -o tiny
    bake --target three,filament --size 64 -o small
    js <<'END'
for (const [set, levels] of [['tiny/gltf', 2], ['tiny/filament', 2],
                             ['small/three', 3], ['small/filament', 4]])
    near(set, json(`${set}/env.json`).outputs.find(o =>
        o.content === 'specular').levels.length, levels, 0);
END
    bake --target filament --skybox 8 -o skybox
    there skybox/env_skybox.ktx
    iblbake $small --target gltf --skybox 8 env.hdr -o none 2>err
    has 'skybox: not in [a-z]*.gltf, whose level 0' err
}

test_refused() {
    refused 2 '*--target nope: not a value*three*cesium*all or list' \
        iblbake --target nope env.hdr -o out
    refused 2 '*--target three,: not a value*' \
        iblbake --target three, env.hdr -o out
    refused 2 '*no output directory*' iblbake --target three env.hdr
    refused 2 '*no environment*' iblbake --target three -o out
    refused 1 '*nothing was written' iblbake -q --target all $small \
        --max-error 1e-9 -o out env.hdr
    mkdir -p taken/bevy/env.json
    refused 1 '*taken/bevy/env.json: is a directory*' \
        iblbake --target all $small -o taken env.hdr
    bake --target three,bevy -o other
    mkdir there
    cp env.hdr there
    refused 1 '*was made from env.hdr, and there/env.hdr would replace*' \
        iblbake --target three,bevy $small there/env.hdr -o other
}

# The lines name files that are there.
test_explain_names_files() {
    local t f
    for t in $targets $filters; do
        bake --target "$t" --explain -o "out/$t" >lines
        [ "$t" = gltf ] || has 'env[_.]' lines
        grep -o "env[_.][_a-z.0-9]*" lines | sort -u | while read -r f; do
            there "out/$t/$f"
        done
        grep '[{][a-z]*}' lines
        iblbake --target "$t" --explain | diff lines - || echo "of $t"
    done
    iblbake --target three,bevy --explain >lines
    has '^three: ' lines
    has '^bevy: ' lines
}

# What replaces an engine's lookup has ibl_lobe_fit as <ibl/ibl.glsl> has it, and
# leaves shaders alone that it does not know, but says so.
test_reflections() {
    local t
    sed -n '/^ibl_lobe ibl_lobe_fit(/,/^}/{ s| *//.*||; p }' \
        "$top/include/ibl/ibl.glsl" >fit
    there fit
    for t in three babylon babylon-env gltf playcanvas; do
        iblbake --target $t --explain >lines
        lines "$(grep -cxFf lines fit)" fit
        js <<'END'
const [block] = fs.readFileSync('lines', 'utf8')
    .match(/^.. Reflections: [^]*^.. Reflections end/m);
const chunks = new Map([['litForwardBackendPS', 'other']]), said = [];
const THREE = {ShaderChunk: {lights_fragment_maps: 'other',
                             envmap_physical_pars_fragment: 'other'}};
const BABYLON = {Effect: {ShadersStore: {pbrPixelShader: 'other'}}};
const pc = {ShaderChunks: {get: () => chunks}};
const shaders = () => JSON.stringify([THREE, BABYLON, [...chunks]]);
const before = shaders();
new Function('THREE', 'BABYLON', 'pc', 'app', 'console', block)(
    THREE, BABYLON, pc, {}, {warn: line => said.push(line)});
equal('shaders', shaders(), before);
equal('warnings', said.length, 1);
END
    done
}

# Programs that run as they stand: in a page, too, which </script> would end.
test_programs() {
    local t
    for t in $targets $filters; do
        iblbake --target $t --explain --sun --skybox 8 --name env |
            sed 's/{n}/1/g; s/{[-a-z]*}/0/g' >$t.mjs
        case $t in
        unreal) python3 -c 'compile(open("unreal.mjs").read(), "unreal", "exec")' ;;
        bevy | unity | godot) is "$(tr -cd '{(' <$t.mjs | wc -c)" \
            "$(tr -cd '})' <$t.mjs | wc -c)" "$t: closing brackets" ;;
        *) node --check $t.mjs 2>&1 | head -n 4 ;;
        esac
        has -E "^(import|us(e|ing)|extends|// after)" $t.mjs
        grep -n '</' $t.mjs
        case $t in
        [!pcgu]*) [ $t = babylon-env ] || has 'env_skybox' $t.mjs ;;
        esac
        awk 'length > 80' $t.mjs
    done
}

# The files of the level that an engine lights matte surfaces from have the
# colours of the exact one: in CIE Lab, at a mean of 0.4, a shift of each texel.
# Blocks of 16x16 texels have 5.3, of 8x8 12.7.
test_matte_texels() {
    node "$top/tests/clients/maps.mjs" dusk >dusk.hdr
    make -s -C "$top" DEPS=no BUILD="$build" "$build/tests/chroma"
    iblbake -q --name env --target three,filament dusk.hdr -o out
    iblbake -q --name env --only specular --pixel rgba32f --size 384 --levels 5 \
        --mirror x dusk.hdr -o three
    iblbake -q --name env --only specular --pixel rgba32f --size 256 --levels 5 \
        dusk.hdr -o filament
    "$build/tests/chroma" out/three/env_specular.ktx2 \
        three/env_specular.ktx2 4 4.5
    "$build/tests/chroma" out/filament/env_specular.ktx \
        filament/env_specular.ktx2 4 4
}

# A sun's harmonics have less than there is of a channel on its far side.
test_rings() {
    node "$top/tests/clients/maps.mjs" dusk >dusk.hdr
    iblbake $small --target cesium,gltf dusk.hdr -o out 2>err
    count 2 'nine harmonics.*--sun, or .* --sh-window auto$' err
    # The least E/pi of the window is 0, of none below; sinc(1 / 4)^4 = .6570,
    # sinc(1 / 2)^4 = .1643.
    map_of 40 '\x10\x20\x40\x80' 1 '\x80\x60\x40\x8a' 87 '\x10\x20\x40\x80' \
        >lone.hdr
    iblbake -q --only json lone.hdr -o plain
    iblbake -q --only json --sh-window auto lone.hdr -o auto
    iblbake -q --only json --sh-window 4 lone.hdr -o four
    js <<'END'
const [plain, auto, four] = ['plain', 'auto', 'four']
    .map(d => json(`${d}/lone.json`).sh);
const basis = ([x, y, z]) => [.28209479, ...[y, z, x].map(v => .48860251 * v),
    ...[x * y, y * z].map(v => 1.09254843 * v), .31539157 * (3 * z * z - 1),
    1.09254843 * z * x, .54627422 * (x * x - y * y)];
const darkest = sh => {
    let dark = Infinity;
    for (let i = 0; i < 4000; i++) {
        const z = 1 - (2 * i + 1) / 4000, r = Math.sqrt(1 - z * z);
        const b = basis([r * Math.cos(2.39996 * i), r * Math.sin(2.39996 * i), z]);
        for (let c = 0; c < 3; c++)
            dark = Math.min(dark, b.reduce((e, y, k) =>
                e + y * sh.irradiance[k][c], 0));
    }
    return dark / sh.irradiance[0][0];
};
must('negative light without --sh-window, none with it', darkest(plain) < -.001 &&
    Math.abs(darkest(auto)) < .001, [darkest(plain), darkest(auto)]);
[1, .65702, .16426].forEach((want, l) => near(`l = ${l}`,
    four.radiance[l * l][0] / plain.radiance[l * l][0], want, 1e-4));
END
    iblbake $small --target three,babylon-env dusk.hdr -o none 2>err
    hasnt harmonics err
    iblbake $small --target cesium,gltf --sun dusk.hdr -o sun 2>err
    hasnt harmonics err
}

# A light's direction, colour and intensity are those of the sidecar.
test_explain_lights() {
    mkenv hdr 128 64 >env.hdr
    bake --target all --sun --explain -o out >lines
    js <<'END'
const light = json('out/filament/env.json').lights[0];
const [x, y, z] = light.direction;
const e = light.irradiance, most = Math.max(...e);
const colour = e.map(v => v / most);
const text = fs.readFileSync('lines', 'utf8');
const same = (target, what, want) => {
    const part = text.slice(text.indexOf(`${target}: `));
    const at = part.slice(part.indexOf(what) + what.length);
    const got = at.match(/-?[0-9][0-9.]*(e[-+]?[0-9]+)?/g).map(Number);
    want.forEach((w, i) => near(`${target} ${i}`, got[i], w,
        1e-5 * Math.abs(w) + 1e-6));
};
near('a mild colour', colour[1], colour[0], .9);
same('three', 'new THREE.Color(', [...colour, most]);
same('three', 'position.set(', [x, y, z]);
same('babylon', 'BABYLON.Vector3(', [-z, -y, -x]);
same('babylon-env', 'intensity = ', [most]);
same('filament', '.intensity(', [30000 * most, -x, -y, -z,
    light.radius_deg]);
same('bevy', 'illuminance: ', [1000 * most]);
same('bevy', 'looking_to(Vec3::new(', [-x, -y, -z]);
same('playcanvas', 'intensity: ', [most / Math.PI]);
same('playcanvas', 'UP, new pc.Vec3(', [-z, y, x]);
same('cesium', 'frame, new Cesium.Cartesian3(', [-x, z, -y]);
same('unreal', 'set_intensity(', [most]);
same('unity', '.intensity = ', [most / Math.PI]);
same('godot', '.light_energy = ', [most / Math.PI]);
END
}

# Where an engine looks up the direction of the light that its program has, there
# is the sun of its map, as OpenImageIO reads it.
test_maps_of_engines() {
    have oiiotool || return
    local t
    mkenv hdr 128 64 >env.hdr
    for t in $filters; do
        bake --target "$t" --sun --explain -o "out/$t" >"$t"
        bake --target "$t" -o "all/$t"
        oiiotool "all/$t/env_specular."??? -d float --compression none -o "$t.tif"
    done
    js <<'END'
const {PI, atan2, acos} = Math;
const engines = { // what the program has, and its u and v
    // TextureDerivedData: LookupLongLat, with y and z exchanged as in cubes
    unreal: [/make_rot_from_x[(]unreal.Vector[(](.*?)[)]/, ([x, y, z]) =>
        [.5 + atan2(x, -y) / (2 * PI), acos(z) / PI]],
    // Skybox-Panoramic.shader: ToRadialCoords
    unity: [/forward = new Vector3[(](.*?)[)]/, ([x, y, z]) =>
        [.5 - atan2(z, x) / (2 * PI), acos(y) / PI]],
    // sky.glsl: panorama_coords
    godot: [/looking_at[(]Vector3[(](.*?)[)]/, ([x, y, z]) =>
        [(1 + atan2(x, -z) / (2 * PI)) % 1, acos(y) / PI]],
};
for (const [name, [line, lookup]] of Object.entries(engines)) {
    const [u, v] = lookup(fs.readFileSync(name, 'utf8').match(line)[1].split(',')
        .map(s => -parseFloat(s)));
    const b = fs.readFileSync(name + '.tif'), tags = {}, ifd = b.readUInt32LE(4);
    for (let i = 0; i < b.readUInt16LE(ifd); i++) {
        const at = ifd + 2 + 12 * i, short = b.readUInt16LE(at + 2) === 3;
        tags[b.readUInt16LE(at)] =
            short ? b.readUInt16LE(at + 8) : b.readUInt32LE(at + 8);
    }
    near(name + ' width', tags[256], 128, 0);
    let most = 0, x = 0, y = 0; // strips follow each other, in front of the tags
    for (let i = 0; i < 128 * 64; i++) {
        const value = b.readFloatLE(b.readUInt32LE(tags[273]) + 12 * i);
        if (value > most) [most, x, y] = [value, i % 128, i >> 7];
    }
    near(name + ' u', u, (x + .5) / 128, 1 / 128);
    near(name + ' v', v, (y + .5) / 64, 1 / 64);
}
END
}

for t in $(compgen -A function test_); do
    picked "$t" || continue
    cd "$top"
    rm -rf "$work/case"
    mkdir "$work/case"
    cd "$work/case" || exit 1
    cp "$work/env.hdr" .
    verdict "$t" "$($t 2>&1 | head -n 12)"
done
cd "$top"
end

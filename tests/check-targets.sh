#!/bin/bash
# SPDX-License-Identifier: MIT
#
# Targets: what --target writes and prints. BUILD names the build.
set -u
. tests/lib.sh
need node
use iblbake
mkenv hdr 64 32 >"$work/env.hdr"
small='--size 32 --irradiance-size 4'
targets=$(iblbake --target list | sed -n 's/^\([a-z-]*\): .*/\1/p')
words() { # TARGET: its options, as the list has them
    iblbake --target list | sed -n "/^$1: /,/^[a-z-]*: /s/^    //p" |
        tr '\n' ' '
}
bake() { # [options]
    iblbake -q $small "$@" env.hdr || echo "$*: status $?"
}

test_list() {
    iblbake --target list >list 2>err || echo "status $?"
    [ ! -s err ] || cat err
    awk 'length > 80 { print "line " NR " has " length }' list
    [ "$(echo $targets)" = 'three babylon babylon-env filament bevy playcanvas gltf cesium' ] ||
        echo "$targets"
    iblbake --target list >/dev/full 2>err && echo 'a full stdout is not noticed'
}

# A target is its options, but for its name in the sidecar and Filament's glType.
test_same_as_its_options() {
    local t
    for t in $targets; do
        bake --target "$t" -o "out/$t"
        # shellcheck disable=SC2046
        bake $(words "$t") $small -o "hand/$t"
        grep -q "^  \"target\": \"$t\"" "out/$t/env.json" ||
            echo "$t: not in the sidecar"
    done 2>&1
    rm -f out/filament/*.ktx hand/filament/*.ktx
    # Only targets have no error that is expected of what is rendered.
    js $targets <<'END'
for (const target of process.argv.slice(2))
    for (const where of ['out', 'hand']) {
        const name = `${where}/${target}/env.json`, sidecar = json(name);
        delete sidecar.options;
        delete sidecar.target;
        delete sidecar.expected_rendered_error;
        fs.writeFileSync(name, JSON.stringify(sidecar, null, 1));
    }
END
    for t in $targets; do
        diff -r "out/$t" "hand/$t"
    done | head -n 4
}

# What the files of targets are, but for their texels and estimates.
facts() {
    cd "$1" && find . -type f | sort
    grep -hE '"(content|file|container|pixel|width|mapping|lod.*|size|roughness|method)":' \
        ./*/*.json
}

# Sets of one chain are those of single targets byte by byte. With further
# chains the analysis may have more degrees than one needs alone, by which a
# texel in some thousands is rounded the other way.
test_several_are_single_ones() {
    local t f
    bake --target all --sun -o all
    [ "$(ls all | tr '\n' ' ')" = \
        "$(printf '%s\n' $targets | sort | tr '\n' ' ')" ] || ls all
    for t in $targets; do
        bake --target "$t" --sun -o "one/$t"
    done
    diff <(facts one) <(facts all) | head -n 4
    for f in filament/env_specular.ktx cesium/env_specular.ktx2; do
        [ "$(cmp -l "one/$f" "all/$f" | wc -l)" -lt 40 ] || echo "$f differs"
    done
    bake --target filament,three --sun -o two
    bake --target babylon-env,babylon --sun -o two
    diff -r one two | grep -v '^Only in one: '
    return 0
}

# Every set is read again, in the world's axes, and is what it says.
test_verified() {
    local t
    mkenv exr 64 32 BGR >mild.exr
    iblbake -q $small --target all mild.exr -o out || echo "status $?"
    for t in $targets; do
        iblbake verify mild.exr "out/$t" --max-error 0.1 >log 2>&1 ||
            echo "$t: $(tail -n 1 log)"
        grep -q '^specular ' log || echo "$t: nothing was judged"
    done
}

test_threads() {
    local j
    for j in 1 2 7; do
        bake --target all -j $j --skybox 16 -o $j
    done
    diff -r 1 2
    diff -r 1 7
}

# The command line wins, on either side of --target.
test_overrides() {
    bake --target three --quality best -o after
    bake --quality best --target three -o before
    cmp after/env_specular.ktx2 before/env_specular.ktx2
    grep -q '"quality": "best"' after/env.json || echo 'not best'
    bake --target bevy --only irradiance,json -o only
    [ "$(ls only | tr '\n' ' ')" = 'env.json env_irradiance.ktx2 ' ] || ls only
    # What a target sets and has no place any more falls away.
    bake --target bevy,three --format ktx --pixel rgba16f -o both
    bake --target filament,bevy,gltf,cesium --size 4 --format ktx2 -o tiny
    [ -s both/three/env_specular.ktx ] || ls -R both
    bake --target filament --skybox 8 -o skybox
    [ -s skybox/env_skybox.ktx ] || ls skybox
    iblbake $small --target gltf --skybox 8 env.hdr -o none 2>err
    grep -q 'skybox: not in [a-z]*.gltf, whose level 0' err || cat err
}

test_refused() {
    refused 2 '*--target nope: not a value*three*cesium*all or list' \
        iblbake --target nope env.hdr -o out
    refused 2 '*--target three,: not a value*' \
        iblbake --target three, env.hdr -o out
    refused 2 '*--target three: --pixel uastc-hdr: dds files*' \
        iblbake --target bevy,three --format dds --pixel uastc-hdr env.hdr -o out
    refused 2 '*--target gltf: --levels 9: a cube of size 8 *' \
        iblbake --target gltf --size 8 --levels 9 env.hdr -o out
    refused 2 '*--preview p.png: *one --target*' \
        iblbake --target three,bevy --preview p.png env.hdr -o out
    refused 2 '*--explain: *Add --target*' iblbake --explain env.hdr -o out
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

test_depfile() {
    bake --target all -o out --depfile d
    find out -type f | sort >made
    tr -d '\\:' <d | tr ' ' '\n' | grep '^out/' | sort | diff made -
    tr -d '\\\n' <d | grep -q ': env.hdr$' || cat d
}

# The lines name files that are there.
test_explain_names_files() {
    local t f
    for t in $targets; do
        bake --target "$t" --explain -o "out/$t" >lines
        grep -q 'env[_.]' lines || [ "$t" = gltf ] || echo "$t: no file"
        grep -o "env[_.][_a-z.0-9]*" lines | sort -u | while read -r f; do
            [ -s "out/$t/$f" ] || echo "$t: no $f"
        done
        grep '[{][a-z]*}' lines
        iblbake --target "$t" --explain | diff lines - || echo "$t: differs"
    done
    iblbake --target three,bevy --explain >lines
    grep -q '^three: ' lines && grep -q '^bevy: ' lines || cat lines
}

test_lines_are_javascript() {
    local t
    for t in three babylon babylon-env filament playcanvas cesium; do
        iblbake --target $t --explain --sun | sed 's/{n}/1/g; s/{[-a-z]*}/0/g' \
            >$t.mjs
        node --check $t.mjs 2>&1 | head -n 4
    done
    iblbake --target all --explain --sun | awk 'length > 80'
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

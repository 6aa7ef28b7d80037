#!/bin/bash
# SPDX-License-Identifier: MIT
# Runs `iblbake verify` and `iblbake --verify` as a user would: on its own
# bakes, on bakes that were damaged as bakers do by mistake, on files of other
# programs, and on nonsense. BUILD names the build.
set -u
. tests/lib.sh
slow='lobes|damage_is|containers_and|in_spite'
repeats='damage_is|figures|estimates|memory|mixed|colours|sidecar_or|in_spite|own_bakes'
need node
use iblbake
cp tests/cli/damage.mjs "$work/bin"
mkenv hdr 16 8 >"$work/env.hdr" # a sun beyond half floats
mkenv exr 8 4 BGR >"$work/env.exr" # mild
map_of 128 '\200\200\200\201' >"$work/one.hdr" # the truth is 1 everywhere
levels='--size 32 --levels 3 --mapping linear'
small="$levels --irradiance-size 2 --lut-size 2"
exact='--format dds --pixel rgba32f'
floats="$small $exact"
few='--rendered --directions 24'
damage() { node "$work/bin/damage.mjs" "$@"; }

# accept|refuse [options] ENV ...: within --max-error or not, with one line on
# standard error if not. MAX is the bound.
judge() {
    iblbake verify -q --texels 24 --max-error "$MAX" "$@" 2>err >printed
    status=$?
    lines 0 printed
}
accept() {
    judge "$@"
    is 0 $status "verify $*: status ($(cat err))"
}
refuse() {
    judge "$@"
    is 1 $status "verify $*: status"
    lines 1 err
}
wrong() { # STATUS GLOB [arguments]
    refused "$1" "$2" iblbake verify "${@:3}"
}

# ---- our own bakes -----------------------------------------------------

# The bounds: the sampled method's error with 1,024 samples, which is 1e-3 on
# a map without small lights and 1e-2 beside a sun; rgb9e5 rounds at 1e-3,
# r11g11b10f at 1e-2.
test_own_bakes_pass() {
    local file
    iblbake -q $small env.exr -o out && MAX=0.003 accept env.exr out
    iblbake -q $floats env.hdr -o hdr && MAX=0.02 accept env.hdr hdr
    iblbake -q $small env.exr -o out --name other
    MAX=0.003 accept --name other env.exr out
    for file in env.exr out/other.json out/other_specular.ktx2; do
        wrong 1 "iblbake: $file: is both input and output: *" env.exr out \
            --name other --json $file
    done
    rm out/env*
    wrong 1 '*: out: has no env_specular*another name*' env.exr out
}

# A cube in the axes of the bake is not copied: 14 MB of texels and 42 MB of
# floats, which a short file holds.
test_memory() {
    [ $sanitized = no ] || return
    iblbake -q --size 768 --levels 1 --pixel rgb9e5 --zstd 3 \
        --only specular env.hdr -o large
    (ulimit -v 88000; MAX=1 accept -j 1 env.hdr large)
}

# Flat maps: every texel is the sum of its own direction, mirrored or not; turned
# otherwise it is not.
test_layouts() {
    local layout
    for layout in equirect octahedral; do
        taken || continue
        iblbake -q $small --layout $layout --skybox 16 --pixel rgba32f --mirror x \
            --rotate 20 env.exr -o $layout --max-error 3e-3 || is 0 $? "$layout: status"
        MAX=3e-3 accept env.exr $layout
        MAX=3e-3 refuse --rotate 60 env.exr $layout
        works iblbake verify -q $few env.exr $layout
    done
}

# Where pixels are larger than texels level 0 is an interpolation of them, and
# so is its truth: float sums apart, or what half floats round. So are mips.
# Axes are turned back by the keys, or by the sidecar of files without keys;
# files that say nothing are judged as they are.
test_axes() {
    local only='--only specular,irradiance,skybox,json'
    set -- --size 16 --irradiance-size 8 --skybox 8 $only --mirror x --up z
    works iblbake -q env.exr -o out "$@" --max-error 2e-3
    MAX=2e-3 accept env.exr out
    cp out/env_specular.ktx2 same.ktx2
    MAX=2e-3 accept env.exr --specular same.ktx2
    sed -i 's/iblbake\.mirror/iblbake.mirroR/; s/iblbake\.up/iblbake.uP/' \
        same.ktx2
    MAX=0.1 refuse env.exr --specular same.ktx2
    iblbake -q env.exr -o dds --format dds "$@"
    MAX=2e-3 accept env.exr dds
    MAX=2e-3 accept env.exr --specular dds/env_specular.dds --mirror x --up z
    MAX=0.1 refuse env.exr --specular dds/env_specular.dds
    sed -i 's/"mirror": "x"/"mirror": "q"/' dds/env.json
    wrong 1 '*its mirror is "q", which this version does not know*' env.exr dds
}

# What engines' own files give back, as the sidecar or their keys tell of it.
test_engine_files() {
    local kind
    for kind in 'env --mapping babylon' 'gltf --mapping linear --levels 3' \
        'playcanvas --mapping linear --levels 6'; do
        rm -rf out
        iblbake -q env.exr -o out --rotate 30 --size 32 --format $kind
        ls out/env*[!0-9]* | grep -vE '\.json|_[pn][xyz]\.png' >main
        MAX=0.06 accept env.exr out
        rm out/env.json
        MAX=0.06 accept env.exr out --rotate 30
        MAX=0.06 refuse env.exr --rotate 0 --specular "$(cat main)"
    done
}

# verify reads the map as the files say that the bake did, or as it is told.
test_colours() {
    printf '#?RADIANCE\nPRIMARIES=.708 .292 .17 .797 .131 .046 .3127 .329\n' \
        >wide.hdr
    tail -n +2 env.hdr >>wide.hdr
    iblbake -q $floats wide.hdr -o out --primaries rec709 --exposure 1.5 \
        --clamp 7 --sh 2
    MAX=0.02 accept wide.hdr out
    MAX=0.02 refuse --exposure 1 wide.hdr out
    MAX=0.02 refuse --primaries acescg wide.hdr out
    MAX=0.02 refuse --clamp 3 wide.hdr out
    iblbake -q $levels wide.hdr -o keys --only specular --primaries acescg \
        --exposure 1.5 --clamp 7
    MAX=0.02 accept wide.hdr keys
    js <<'END'
const s = json('out/wide.json'), o = s.options, c = s.colour;
const told = [o.primaries, o.exposure, o.clamp, o.pixel, 'output' in o,
              s.source.primaries, c.primaries, c.exposure_ev, c.clamp];
equal('options', told.join(), 'rec709,1.5,7,rgba32f,false,Rec.2020,rec709,1.5,7');
must('a tenth of the light clamped', c.clamped_pixels > 0 && c.clamp_removed > 0.1, c);
END
    iblbake -q $floats one.hdr -o one --exposure -2 -j 3 --rotate 9
    js <<'END'
const e = json('one/one.json').environment;
near('luminance', e.mean_luminance, 0.25, 1e-6);
END
}

# Each container and each pixel format once. Blocks of texels lose some percent.
test_containers_and_pixels() {
    local format pixel bound
    while read -r format pixel bound; do
        taken || continue
        rm -rf out
        iblbake -q env.exr -o out --size 16 --irradiance-size 4 \
            --lut-size 8 --skybox 9 --format $format --pixel $pixel \
            --mapping filament --rotate 30 --geometry schlick-ibl
        [ $bound != .15 ] || MAX=1e-4 refuse env.exr out
        MAX=$bound accept env.exr out
    done <<'END'
ktx2 uastc-hdr .15
ktx2 rgba32f .015
dds r11g11b10f .015
ktx astc4x4hdr .15
ktx rgb9e5 .015
ktx2 rgba16f .015
dds bc6h .15
END
}

# DDS has no keys: all is in the sidecar, and without it in options.
test_sidecar_or_options() {
    iblbake -q $floats env.exr -o out --mapping filament --rotate 90 \
        --geometry schlick-ibl
    MAX=0.003 accept env.exr out
    mv out/env.json .
    MAX=0.003 refuse env.exr out
    MAX=0.003 accept env.exr out --roughness-map filament --rotate 90 \
        --geometry schlick-ibl
    MAX=0.003 accept env.exr out --roughness-map 0,0.29289322,1 --rotate 90 \
        --geometry schlick-ibl
}

# Keys, and where there are none the sidecar, and without it an option.
test_lobes() {
    local lobe
    for lobe in charlie phong; do
        taken || continue
        iblbake -q $levels $exact --only specular,json env.exr -o out \
            --lobe $lobe --max-error 0.01 || is 0 $? "$lobe: status"
        MAX=0.01 accept env.exr out
        MAX=0.01 refuse env.exr out --lobe ggx
        MAX=0.01 accept env.exr --specular out/env_specular.dds --lobe $lobe
        rm -rf out
    done
    iblbake -q $levels --only specular env.exr -o keys --lobe charlie
    MAX=0.01 accept env.exr keys
    iblbake -q $levels $exact --only specular,json env.exr -o out
    sed -i 's/"lobe": "ggx"/"lobe": "beckmann"/' out/env.json
    wrong 1 '*lobe is "beckmann", which this version does not know*' env.exr out
    MAX=0.003 accept env.exr out --lobe ggx
}

# The other kinds, by the key, the sidecar or the option; DDS has no keys.
test_kinds_of_tables() {
    local kind format
    for kind in multiscatter charlie; do
        for format in ktx2 dds; do
            taken || continue
            iblbake -q --irradiance-size 2 --lut-size 8 --lut-kind $kind \
                --only irradiance,lut,json --pixel rgba32f --format $format \
                --max-error 0.001 env.exr -o out
            MAX=0.001 accept env.exr out
            MAX=0.001 accept --lut out/brdf_lut_$kind.$format --lut-kind $kind
        done
    done
    iblbake -q --only lut --lut-size 16 -o out
    MAX=0.0003 accept --lut out/brdf_lut.ktx2
    MAX=0.0003 refuse --lut out/brdf_lut.ktx2 --geometry schlick-ibl
    MAX=0.001 refuse --lut out/brdf_lut.ktx2 --lut-kind charlie
}

# ---- damage ------------------------------------------------------------

test_damage_is_found() {
    iblbake -q $floats --lut-size 4 env.exr -o out
    MAX=0.003 accept env.exr out
    damage out/env_specular.dds swap s.dds
    MAX=0.003 refuse env.exr out --specular s.dds
    damage out/env_specular.dds shift s.dds
    MAX=0.003 refuse env.exr out --specular s.dds
    damage out/env_specular.dds scale=1.05 s.dds
    MAX=0.003 refuse env.exr out --specular s.dds
    damage out/env_irradiance.dds scale=3.14159265 i.dds
    MAX=0.003 refuse env.exr out --irradiance i.dds
    MAX=0.003 accept env.exr out --irradiance i.dds --irradiance-scale E
    # What a sidecar says of files elsewhere is not followed.
    sed 's|"env_specular.dds"|"../s.dds"|' out/env.json >json
    mv json out/env.json
    MAX=0.003 accept env.exr out
    # Whatever the bound.
    damage out/env_specular.dds nan s.dds
    MAX=1000 refuse env.exr out --specular s.dds
    has 'specular 2 has 1 texels of NaN' err
    iblbake -q $floats env.exr -o out --mapping filament
    rm out/env.json
    MAX=0.003 refuse env.exr out
}

# Closed forms: where the truth is 1, +X wrong by 0.6 and all else right gives
# an nRMSE of 0.6 sqrt(1/6), a p95 and a worst of 0.6 towards +X, a median of
# 0 and a mean of 1.1. With half of +X wrong, a twelfth of all, there are 5 %
# above that but not 10.
test_figures() {
    iblbake -q $floats --size 16 one.hdr -o out
    damage out/one_specular.dds face=0.6 s.dds
    iblbake verify one.hdr --specular s.dds --all --json all.json >all
    # Estimates: an eighth of 0.245.
    iblbake verify one.hdr --specular s.dds --json some.json >table
    damage out/one_specular.dds upper=0.6 s.dds
    iblbake verify -q one.hdr --specular s.dds --all --json half.json
    js <<'END'
for (const [file, part, slack] of [['all.json', 6, 0.001],
    ['some.json', 6, 0.06], ['half.json', 12, 0.001]]) {
    const levels = json(file).levels;
    near('levels', levels.length, 3, 0);
    for (const l of levels) {
        near('nrmse', l.nrmse, 0.6 * Math.sqrt(1 / part), slack);
        near('median', l.median, 0, 1e-4);
        near('p95', l.p95, 0.6, 1e-3);
        near('worst', l.worst, 0.6, 1e-3);
        near('bias', l.bias, 0.6 / part, slack);
        near('nonfinite', l.nonfinite, 0, 0);
        const [x, y, z] = l.worst_at;
        if (file === 'all.json') equal('error of all', l.standard_error.nrmse, 0);
        must('the worst on +X', x > Math.abs(y) - 1e-3 && x > Math.abs(z) - 1e-3,
            l.worst_at);
    }
}
END
    awk 'NR > 1 && NF != 14' table
    lines 4 table
}

# The chosen texels tell of all of them, as well as their standard errors say.
test_estimates() {
    local seed
    mkenv hdr 64 32 >env.hdr
    iblbake -q $small env.hdr -o out --method sampled --samples 64
    iblbake verify env.hdr out --json all.json --all -q
    for seed in 1 2 3; do
        iblbake verify env.hdr out --json $seed.json --seed $seed -q
    done
    js <<'END'
const all = json('all.json').levels;
let within = 0, count = 0;
for (const seed of [1, 2, 3])
    json(seed + '.json').levels.forEach((l, i) => {
        for (const what of ['nrmse', 'median', 'p95', 'bias']) {
            const off = Math.abs(l[what] - all[i][what]);
            const error = l.standard_error[what] + 1e-6;
            count++;
            within += off <= 2 * error;
            if (off > 4.5 * error && what !== 'p95')
                console.log(`${l.content} ${l.level}, seed ${seed}: ${what}: found ` +
                    `${l[what]} +- ${error}, wanted ${all[i][what]}`);
        }
        must(`at most ${all[i].worst} of ${all[i].texels}`, l.worst <= all[i].worst &&
            l.texels <= all[i].texels, [l.worst, l.texels]);
    });
must(`0.85 of ${count}`, within >= 0.85 * count, within);
END
}

# Harmonics are found in the sidecar, in other axes, too: theirs is the error of
# their degree; coefficients that are wrong are found.
test_harmonics() {
    mkenv hdr 64 32 >env.hdr
    iblbake -q $small env.hdr --mirror x --up z --rotate 20 -o out
    iblbake verify env.hdr out --json v.json >table
    MAX=0.02 accept env.hdr out
    js <<'END'
const h = json('v.json').harmonics;
near('coefficients', h.coefficients, 0, 1e-6);
must('.01 to .3 at level 2', h.nrmse > .01 && h.nrmse < .3 && h.level === 2, h);
const s = json('out/env.json');
s.sh.radiance[2][1] *= 1.1;
fs.writeFileSync('out/env.json', JSON.stringify(s));
END
    MAX=0.01 refuse env.hdr out
    has 'harmonics' err
}

# ---- files of other programs -------------------------------------------

# ---- nonsense ----------------------------------------------------------

# Others stand in tests/pairs/refused.txt.
test_misuse() {
    wrong 2 '*no environment*' --json -
    wrong 2 '*nothing to judge*' env.exr
    wrong 2 '*a third argument*' env.exr out more
    wrong 2 '*--roughness-map 0,2: not a value*' env.exr out \
        --roughness-map 0,2
    wrong 2 '*it takes*' --rendered --directions 23 env.exr out
    iblbake -q $small env.exr -o out
    wrong 2 '*no environment*' --rendered --lut out/brdf_lut.ktx2
    wrong 1 '*no specular cube*' --rendered env.exr \
        --irradiance out/env_irradiance.ktx2
    wrong 1 'iblbake: --lobe ggx: there is no *leave it out' env.exr \
        --irradiance out/env_irradiance.ktx2 --lobe ggx
    wrong 2 'iblbake: --rotate 3: a table needs no environment: *' --lut out/brdf_lut.ktx2 \
        --rotate 3
}

test_malformed() {
    wrong 1 '*gone: *No such file*' env.exr gone
    wrong 1 '*env.exr: not a texture*' env.exr env.exr
    mkdir empty
    wrong 1 '*empty: has no env_specular*' env.exr empty
    iblbake -q $small env.exr -o out
    wrong 1 '*gone.exr*' gone.exr out --name env
    cp out/env.json .
    echo '{"outputs": [' >out/env.json
    wrong 1 '*out/env.json:2:0: no JSON: *bake the set again*' env.exr out
    ln -sf /dev/null out/env.json
    wrong 1 '*out/env.json: is no file*' env.exr out
    rm out/env.json
    echo '[3, {"outputs": 3}]' >out/env.json
    MAX=0.003 accept env.exr out
    cp env.json out
    rm out/env_specular.ktx2
    wrong 1 '*env_specular.ktx2*names it*' env.exr out
    iblbake -q $small env.exr -o pictures --format exr
    wrong 1 '*: is a picture, and *: bake it as KTX2*' env.exr pictures
    wrong 1 '*flat texture*' env.exr --specular out/brdf_lut.ktx2
    wrong 1 '*where a BRDF table * is wanted*' --lut out/env_irradiance.ktx2
    head -c 300 out/env_irradiance.ktx2 >cut.ktx2
    wrong 1 '*cut.ktx2*' env.exr --irradiance cut.ktx2
    wrong 1 '*env.hdr*' env.exr --irradiance env.hdr
    wrong 1 '*gone/p.json*' env.exr out --specular out/env_irradiance.ktx2 \
        --roughness-map 1 --json gone/p.json
}

# A list of roughnesses that is not that of the levels is no account of them,
# in keys or sidecar; an option is.
test_levels_that_disagree() {
    local change
    iblbake -q $levels env.exr -o out --only specular --format ktx
    cp out/env_specular.ktx own.ktx
    sed 's/\x000,0.5,1\x00/\x000,0,1,1\x00/' own.ktx >out/env_specular.ktx
    cmp -s own.ktx out/env_specular.ktx &&
        echo 'wanted other keys, found those of own.ktx'
    wrong 1 '*has 3 levels, and the roughness of 4: bake it again*' env.exr out
    MAX=0.003 accept env.exr out --roughness-map linear
    sed 's/\x000,0.5,1\x00/\x000;0.5,1\x00/' own.ktx >out/env_specular.ktx
    wrong 1 '*its list of the roughness of levels is damaged*' env.exr out
    rm -r out
    iblbake -q $floats env.exr -o out
    cp out/env.json own.json
    for change in 'pop()' 'fill({roughness: 2})'; do
        node -e "const s = JSON.parse(require('fs').readFileSync('own.json'));
            s.outputs[0].levels.$change;
            console.log(JSON.stringify(s))" >out/env.json
        wrong 1 '*out/env*: has *bake * again*' env.exr out
    done
    MAX=0.003 accept env.exr out --roughness-map 0,0.5,1
}

# A set of files of two bakes is named, and one whole set is not.
test_mixed_sets() {
    iblbake -q $small env.exr -o out
    iblbake -q $small env.exr -o other --tolerance .1
    iblbake verify env.exr out 2>err >verdict
    hasnt warning err
    cp other/env_specular.ktx2 out
    iblbake verify env.exr out 2>err >verdict
    has 'warning: out/env_specular.ktx2: is not the file that out/env.json' err
}

# Files say how many lights were taken out of what they are made from, by keys
# or the sidecar; the skybox has them.
test_lights() {
    local format
    mkenv hdr 128 64 >sunny.hdr
    for format in ktx2 dds; do
        [ $sanitized = no ] || [ $format = dds ] || continue
        rm -rf out
        iblbake -q $small sunny.hdr --pixel rgba32f --format $format \
            --skybox 32 --sun --rotate 50 -o out --max-error 0.001 >table ||
            is 0 $? "$format: $(cat table): status"
        MAX=0.001 accept sunny.hdr out
        MAX=0.001 refuse sunny.hdr out --lights 0
        MAX=0.001 accept sunny.hdr --rotate 50 --lights 4 \
            --specular out/sunny_specular.$format --roughness-map linear
    done
    sed -i 's/"radius_rad"/"radius"/' out/sunny.json
    wrong 1 '*sunny.json: its lights are damaged*' sunny.hdr out
    iblbake -q $small sunny.hdr -o lit
    iblbake -q $small sunny.hdr -o dark --sun
    wrong 1 '*baked with * lights taken out, another file with * 1: judge one*' \
        sunny.hdr --specular lit/sunny_specular.ktx2 \
        --irradiance dark/sunny_irradiance.ktx2
}

# ---- results -----------------------------------------------------------

test_results_in_spite_of_the_error() {
    iblbake -q $small env.exr -o out
    iblbake verify env.exr out --max-error 1e-9 --json v.json >table 2>err &&
        is 1 0 status
    there v.json table
    has '"passed": false' v.json
    works iblbake verify -q $few env.exr out --max-rendered-error 5
    iblbake verify -q $few env.exr out --max-rendered-error 0.001 2>err
    has 'rendered with F0 = 1, the files have an nRMSE of .*, above 0.001' err
    iblbake verify env.exr out >/dev/full 2>err && is 1 0 'status of a full stdout'
    lines 1 err
}

# ---- the bake's --verify -----------------------------------------------

test_bake_and_verify() {
    iblbake $small env.exr -o out --rotate 40 --mapping filament \
        --geometry schlick-ibl --verify >table 2>err || is 0 $? status
    lines 0 err
    # The same as verify says of the files, and of the sidecar's harmonics.
    iblbake verify env.exr out | grep -v '^harmonics\|^  of degree' | cmp - table
    js <<'END'
const v = json('out/env.json').verify;
const got = v.levels.map(l => l.content + l.level).join();
equal('levels', got, 'specular0,specular1,specular2,irradiance0');
must('below .003 and .0003', v.levels[1].nrmse < 0.003 && v.lut.worst < 0.0003, v);
END
    iblbake -q $small env.exr -o out2 --max-error 0.003 || is 0 $? status
    has '"verify"' out2/env.json
}

# ---- what is rendered --------------------------------------------------

# On a constant map only the table is wrong, by its roundings at most.
test_rendered() {
    local shader
    iblbake -q $small --lut-size 128 --lobe-table prior one.hdr -o out
    for shader in split bent fit two-taps three-taps four-taps table; do
        taken || continue
        iblbake verify $few --shader $shader one.hdr out --json v.json >table
        js $shader <<'END'
const { shader, rows, means } = json('v.json').rendered;
near('rows', rows.length, 16, 0);
near('means', means.length, 2, 0);
equal('shader', shader, process.argv[2]);
for (const row of [...rows, ...means]) {
    near('nrmse', row.nrmse, 0, 0.03);
    near('bias', row.bias, 0, 0.03);
    near('standard error', row.standard_error.nrmse, 0, 0.01);
}
END
        lines 20 table
    done
    has 'by table: 24 directions' table
}

# A sun is right as a disc, not as a part of levels.
test_rendered_with_lights() {
    mkenv hdr 256 128 >sunny.hdr
    iblbake -q $small --size 64 sunny.hdr --rotate 50 --sun -o rest
    works iblbake verify -q $few sunny.hdr rest --max-rendered-error 0.08
    [ $sanitized = no ] || return 0
    iblbake -q $small --size 64 sunny.hdr --rotate 50 -o all
    iblbake verify -q $few sunny.hdr all --max-rendered-error 0.3 2>err &&
        is 1 0 'status of a sun without its disc'
}

# An error that is no number would be below any bound.
test_rendered_not_finite() {
    iblbake -q $floats --lobe-table prior --lobe-table-size 4 env.exr -o out
    damage out/env_specular.dds scale=NaN nan.dds
    wrong 1 '*holds values that are not finite*' $few env.exr out \
        --specular nan.dds
    lobes() { # HALF: every value of a lobe table
        head -c 148 out/env_lobe_lut.dds && printf "$1%.0s" {1..256}
    }
    lobes '\377\377' >nan.dds
    wrong 1 '*not finite*' $few env.exr out --lobe-table nan.dds
    lobes '\000\274' >below.dds # -1: a GPU takes level 0
    works iblbake verify -q $few env.exr out --lobe-table below.dds
}

# As when another bake in the same directory has replaced the table.
test_rendered_other_levels() {
    iblbake -q $small env.exr -o out
    mv out/env_lobe_lut.ktx2 out/lobe_lut.ktx2
    rm out/env.json
    iblbake verify $few env.exr out >table
    has 'by table' table
    iblbake -q --levels 4 --lobe-table prior --only lobe-table -o out
    iblbake verify $few env.exr out >table 2>err || is 0 $? status
    has 'by split' table
    has 'out/lobe_lut.ktx2: left out: for levels of other' err
    wrong 1 '*lobe_lut.ktx2: for levels of other roughness*' $few env.exr out \
        --lobe-table out/lobe_lut.ktx2
}

for t in $(compgen -A function test_); do
    picked "$t" || continue
    rm -rf "$work/case"
    mkdir "$work/case"
    cd "$work/case" || exit 1
    cp "$work/env.hdr" "$work/env.exr" "$work/one.hdr" .
    verdict "$t" "$($t 2>&1 | head -n 12)"
    cd "$top" || exit 1
done
end

#!/bin/bash
# SPDX-License-Identifier: MIT
#
# Runs the built program as a user would. BUILD names the build.
#
# tests/cli/*.case hold the plain cases. Lines by their first characters:
#   == NAME   begins cases of that name, each of which runs in a fresh directory
#             with env.hdr (32x16, with a sun beyond half floats) and env.exr
#             (64x32, mild)
#   ? STATUS  of the cases from here on
#   $ LINE    shell; the lines from the first to the one before the last
#             command set up, the last command is what is judged. A line whose
#             predecessor ends in a backslash continues it.
#   + FILES   exist afterwards and are not empty
#   - FILES   do not
#   ! GLOB    ends the case: the one line on standard error; none: nothing there
# After any other status than 0 the directory must be as it was before the
# last command.
#
# PROGRAM, a port of it, takes only these, without those whose name or first
# commands are like EXCEPT, and with IBL_TEST_QUICK each third.
set -u
. tests/lib.sh
slow='_convert|of_faces|_info|interrupted|scenes|fewest|choice|lights_auto|pictures|printed|depfile'
repeats='fewest|lights|pictures|scenes|choice|convert|misuse|usage|printed|depfile'
program=$build/iblbake
need node
use iblbake
[ -z "${PROGRAM:-}" ] || ln -sf "$PROGRAM" "$work/bin/iblbake"
trap 'chmod -R u+rwX "$work"; rm -rf "$work"' EXIT
cat >"$work/bin/unprivileged" <<'END'
#!/bin/sh
[ "$(id -u)" = 0 ] || exec "$@"
exec setpriv --reuid=65534 --regid=65534 --clear-groups "$@"
END
chmod 755 "$work" "$work/bin" "$work/bin/unprivileged"
mkenv hdr 32 16 >"$work/env.hdr"
mkenv exr 64 32 BGR >"$work/env.exr"
small='--size 16 --lut-size 16 --irradiance-size 4'

# An unprivileged user must reach the program.
reachable=yes
unprivileged iblbake --version >/dev/null 2>&1 || reachable=no

fresh() { # a new directory with the environments
    cd "$top"
    chmod -R u+rwX "$work/case" 2>/dev/null
    rm -rf "$work/case"
    mkdir "$work/case"
    cd "$work/case" || exit 1
    cp "$work/env.hdr" "$work/env.exr" .
}
snapshot() {
    find . -mindepth 1 \( -type d -printf '%p\n' -o \
        -printf '%p %m %T@ %s %i\n' \) 2>/dev/null
}

# ---- cases ---------------------------------------------------------------

pristine= # what is in the directory, if no case has changed it
run_case() {
    local name=$1 setup=$2 command=$3 want=$4 error=$5 with=$6 without=$7
    local before after got text why= f
    [ -z "${EXCEPT:-}" ] || [[ ! "$name $setup" =~ $EXCEPT ]] || return
    picked "$name" || return
    [ -z "${PROGRAM:-}" ] || taken || return
    case $command in
    *unprivileged*)
        [ $reachable = yes ] || {
            verdict "$name" \
                'skipped: no unprivileged user can run the program'
            return
        }
    esac
    [ -n "$pristine" ] && [ -z "$setup" ] && cd "$work/case" || fresh
    [ -z "$setup" ] || { eval "$setup"; pristine=; }
    [ "$want" = 0 ] || before=${pristine:-$(snapshot)}
    (
        # Generous for the image bridge's libraries, far below what the
        # absurd sizes ask for.
        [ $sanitized = yes ] || [ -n "${PROGRAM:-}" ] || ulimit -v 2000000
        eval "$command"
    ) >"$work/stdout" 2>"$work/stderr" </dev/null
    got=$?
    text=$(<"$work/stderr")
    # shellcheck disable=SC2254
    case $text in
    $error) ;;
    *) why="found '$text', wanted '$error'" ;;
    esac
    [[ $text != *$'\n'* ]] || why="several lines: $text"
    [ ! -s "$work/stdout" ] || why="on stdout: $(head -n 3 "$work/stdout")"
    [ $got -eq "$want" ] || why="status $got, not $want: $text"
    for f in $with; do
        [ -s "$f" ] || why="wanted $f, found: $(ls -A . "${f%/*}" 2>&1 | xargs)"
    done
    for f in $without; do
        [ ! -e "$f" ] || why="wanted no $f, found: $(ls -Ald "$f")"
    done
    pristine=
    if [ "$want" != 0 ] && after=$(snapshot) && [ "$before" != "$after" ]; then
        why="left behind: $(diff <(echo "$before") <(echo "$after") | head -n 3)"
    elif [ "$want" != 0 ] && [ -z "$setup" ]; then
        pristine=$before
    fi
    verdict "$name" "$why"
}

run_cases() {
    local line name= status= setup= command= with= without= more=no
    while IFS= read -r line; do
        case $line in
        '== '*) name="${1##*/}: ${line#== }" ;;
        '? '*) status=${line#? } ;;
        '$ '*)
            if [ $more = no ]; then
                setup=$setup$command$'\n'
                command=
            fi
            command=$command${line#$ }$'\n'
            case $line in *\\) more=yes ;; *) more=no ;; esac
            ;;
        '+ '*) with=${line#+ } ;;
        '- '*) without=${line#- } ;;
        '!'*)
            line=${line#!}
            run_case "$name: ${command%%$'\n'*}" "$setup" "$command" "$status" \
                "${line# }" "$with" "$without"
            cd "$top"
            setup= command= with= without= more=no
            ;;
        esac
    done <"$1"
}

# ---- the rest: functions named test_*, failing by a reason on stdout -------

test_what_cannot_be_printed() {
    local set
    for set in '--help' '--verify --only lut --lut-size 16' \
        '--rendered-error 1 --target bevy --size 32' \
        '--target cesium --size 32 --explain'; do
        # shellcheck disable=SC2086
        iblbake env.exr -o full $set >/dev/full 2>err && is 1 0 "$set: status"
        is 'iblbake: standard output cannot be written: why' \
            "$(sed 's/No space left on device\|an earlier write failed/why/' err)"
        absent full
    done
}

# Also of another bake in the same directory.
test_same_bytes_for_any_number_of_threads() {
    local j
    mkdir 1 7
    for j in 1 7 1; do
        (cd $j && iblbake ../env.hdr -q -j $j --size 32 --lut-size 17 \
            --irradiance-size 5 --skybox 16 -o out --sh 5 --preview p.png \
            --depfile env.d &&
            iblbake ../env.hdr -q -j $j --size 16 -o sampled --zstd 5 \
                --method sampled --samples 64 --jitter) || is 0 $? "-j $j: status"
    done
    diff -r 1 7
}

# Plain C and SSE2 write the same files; so does AVX2 with the C library's
# functions for CPUs without fused products. (check-arm64.sh has NEON.)
test_every_instruction_set() {
    local isa
    for isa in c sse2 avx2; do
        iblbake env.exr $small -o $isa --isa $isa 2>err ||
            has "no $isa; the best" err
    done
    has '"arithmetic": "plain"' c/env.json
    [ ! -d sse2 ] || diff -r c sse2
    [ -d avx2 ] || return
    has '"arithmetic": "fused"' avx2/env.json
    GLIBC_TUNABLES=glibc.cpu.hwcaps=-FMA,-AVX2 \
        iblbake env.exr $small -o libm --isa avx2
    diff -r avx2 libm
}

# A bake that would run for minutes is ended, and leaves nothing.
ended_by() { # SIGNAL STATUS
    interrupt "$1" iblbake env.exr -q -j 2 -o new/out --size 1024 \
        --method sampled --samples 1048576 --skybox 64 --depfile env.d
    is "$2" $status "$1: status"
    is 'env.exr env.hdr' "$(ls -R | xargs | cut -d' ' -f2-)"
}
test_interrupted_leaves_nothing() {
    local ends
    # ABRT as a library that gives up does.
    for ends in INT:130 HUP:129 XCPU:152 ABRT:134; do
        taken || continue
        ended_by ${ends%:*} ${ends#*:}
    done
}

# Descriptor 2, closed, must not become an output's and take the messages.
test_closed_descriptors() {
    iblbake env.hdr --size 16 -o out --only specular && mv out ok
    iblbake env.hdr --size 16 -v -o out --only specular <&- >&- 2>&- ||
        is 0 $? status
    diff -r ok out
    iblbake - $small -o out <&- 2>err && is 1 0 'status of a closed input'
    lines 1 err
}

# Four files and a directory, and two more where the latter is new.
test_sync() {
    works iblbake env.exr $small -o one
    works iblbake env.exr $small -o two --sync
    diff -r one two
    [ $sanitized = no ] || return 0
    preload
    # No call is there to fail, and just six.
    LD_PRELOAD=$work/preload.so FAULT='flush 5 0' iblbake env.exr $small -o one ||
        is 0 $? 'status where a flush fails that nobody asks for'
    LD_PRELOAD=$work/preload.so FAULT='flush 5 6' \
        iblbake env.exr $small -o one --sync || is 0 $? 'status where the seventh fails'
    LD_PRELOAD=$work/preload.so FAULT='flush 5 5' \
        iblbake env.exr $small -o one --sync 2>err && is 1 0 'status where the sixth fails'
    has ' flushed.*: Input/output error' err
}

# Under nohup a hangup is of no account.
test_ignored_signals() {
    local pid
    mkfifo pipe
    exec 8<>pipe
    env --ignore-signal=HUP iblbake - -q $small -o out <pipe 8<&- &
    pid=$!
    # The shell's handlers end with its image; the program then catches what is
    # sent to it otherwise: TERM is the 15th.
    within grep -qx iblbake /proc/$pid/comm
    within grep -q '^SigCgt:.*[4-7c-f]...$' /proc/$pid/status
    kill -HUP $pid
    cat env.exr >&8
    exec 8>&-
    wait $pid || is 0 $? status
    there out/env.json
}

test_interrupted_while_reading_a_pipe() {
    mkfifo pipe
    exec 8<>pipe
    timeout --preserve-status -s INT 1 iblbake - -o out <pipe
    is 130 $? status
    exec 8>&-
    absent out
}

test_progress_on_a_terminal() {
    local long='--size 64 --method sampled --samples 8192'
    [ $sanitized = no ] || long='--size 64 --lut-size 64'
    script -qec "iblbake env.exr $long -o out" log \
        </dev/null >/dev/null
    has '\[#* *\] *[0-9]* %' log
    # What was drawn last is wiped off.
    is '' "$(tr '\r' '\n' <log | grep -v '^Script\|^$' | tail -n 1 | grep '#')" bar
    script -qec "iblbake -q env.exr $long -o out" log \
        </dev/null >/dev/null
    is '' "$(grep '%' log)" 'bar with -q'
    iblbake env.exr $small -o out 2>err
    lines 0 err
}

test_verbose_names_what_was_read_and_written() {
    local f
    iblbake -v env.exr $small -o out --preview p.png --depfile d 2>err
    has -x 'iblbake: read env.exr: OpenEXR, .*, 64 x 32, peak .*' err
    for f in out/* p.png d; do
        has "^iblbake: wrote $f" err
    done
    has -E '^total +[0-9.]+ s$' err
    has -F 'specular.ktx2: cube, rgba16f, 16 x 16, levels: 2' err
}

# What a character may do to make or to ninja is refused; with all others both
# find the map by the rule.
test_depfile_characters() {
    local c held= name
    for c in $'\t' $'\r' $'\001' $'\177' $'\377' ' ' '!' '"' '#' '$' '%' '&' "'" '(' \
        ')' '*' '+' ',' '-' ':' ';' '<' '=' '>' '?' '@' '[' '\' ']' '^' '_' '`' \
        '{' '|' '}' '~'; do
        taken || continue
        ln env.exr "a${c}b"
        if iblbake -q --only json -o o --name n --depfile d "a${c}b" 2>err; then
            held=$held$c
        else
            has 'has .*, which make or ninja cannot read' err
        fi
    done
    [ "$asked" != 0 ] || is $'\377 !#$()+,-:@[\\]_{}~' "$held" 'names'
    for c in ' ' ')' ':' '\'; do # not at the end
        ln env.exr "a$c"
        iblbake -q --only json -o o --name n --depfile d "a$c" 2>err && is 1 0 "a$c: status"
    done
    for name in 'b#c$d:e\f\ g' "a${held}b"; do
        ln env.exr "$name"
        iblbake -q --only json -o o --name n --depfile d "$name"
        rm "$name"
        make -f d o/n.json >said 2>&1
        has -F "'$name'" said
        command -v ninja >/dev/null || continue
        printf 'rule r\n command = cp d e\n deps = gcc\n depfile = e\n%s' \
            $'build o/n.json: r\n' >build.ninja
        rm -f .ninja_*
        ninja >log || is 0 $? "$(cat log): status"
        ninja -t deps >said
        has -xF "    $name" said
    done
}

# A skybox, its faces and a list of them are one environment; the set is named
# after the pattern, and the depfile has every file.
test_environment_of_faces() {
    local face list= small="$small --pixel rgba32f"
    for face in px nx py ny pz nz; do
        mkenv exr 16 16 BGR >"f_$face.exr"
        list=$list${list:+,}f_$face.exr
    done
    mkenv hdr 16 16 >f_ny.exr
    iblbake -q $small 'f_%f.exr' -o a --depfile d
    iblbake -q $small --input-layout faces --name f "$list" -o b --skybox 16
    iblbake -q $small b/f_skybox.ktx2 -o c --name f
    cmp a/f_specular.ktx2 b/f_specular.ktx2
    cmp a/f_irradiance.ktx2 b/f_irradiance.ktx2
    count 6 'f_.*exr' d
    count 1 '"layout": "faces"' a/f.json
    iblbake verify -q b/f_skybox.ktx2 c --name f --max-error 0.02
}

# What is said of a file stands in it, too.
test_sidecar_is_as_keys() {
    iblbake -q env.exr --size 32 --levels 4 --method sampled --samples 9 \
        --lod-bias 0.5 --jitter --rotate 30 --roughness-range 0:0.75 \
        --pdf-mip no --lobe phong --mapping filament \
        --lut-size 8 --lut-samples 16 --geometry schlick-ibl --irradiance-size 4 \
        --irradiance-step 0.25 -o out
    iblbake -q env.exr --size 32 --only specular,json --tolerance 0.001 -o exact
    js <<'END'
const s = json('out/env.json');
const digits = (n, x) => Number(x.toPrecision(n));
for (const [o, of, dir] of [...s.outputs.map(o => [o, s, 'out/']),
    [json('exact/env.json').outputs[0], json('exact/env.json'), 'exact/']]) {
    const b = fs.readFileSync(dir + o.file), keys = {};
    let at = b.readUInt32LE(56);
    for (const end = at + b.readUInt32LE(60); at < end;) {
        const n = b.readUInt32LE(at);
        const [k, v] = b.toString('latin1', at + 4, at + 4 + n).split('\0');
        keys[k.replace('iblbake.', '')] = v;
        at += 4 + (n + 3 & ~3);
    }
    const same = (key, want) => keys[key] === String(want) ||
        console.log(`${o.content}: ${key}: found ${keys[key]}, wanted ${want}`);
    for (const k of ['content', 'method', 'lobe', 'mapping', 'geometry',
        'tolerance', 'lod_bias', 'lod_scale', 'lod_offset'])
        if (k in o)
            same(k, typeof o[k] === 'number' ? digits(9, o[k]) : o[k]);
    if (!/_lut/.test(o.content)) same('yaw_deg', of.orientation.yaw_deg);
    if (o.content === 'brdf_lut') same('samples', 16);
    if (o.content === 'irradiance') same('step', o.step_rad);
    if (o.content !== 'specular') continue;
    same('roughness', o.levels.map(l => digits(9, l.roughness)));
    if (dir === 'out/') same('samples', o.levels.map(l => l.samples ?? 0));
    same('degrees', o.levels.map(l => l.degree ?? 0));
    keys.estimate.split(',').forEach((x, l) => { // three digits and four
        const e = o.levels[l].estimated_error ?? 0;
        if (Math.abs(x - e) > 0.006 * e)
            console.log(`level ${l}: estimate: found ${x}, wanted ${e}`);
    });
    if (dir === 'exact/') {
        must('an estimate', o.levels[2].estimated_error > 0, o);
        continue;
    }
    same('roughness_range', o.roughness_range.join(':'));
    for (const k of ['jitter', 'pdf_mip']) same(k, o[k] ? 'yes' : 'no');
    equal('of samples', [o.levels.map(l => l.samples).join(), o.lod_bias, o.jitter,
        o.pdf_mip, o.whole_chain.size], [',9,9,9', .5, true, false, 32]);
}
END
}

# The bytes of its options spelled out; what is typed beside it counts more.
test_preset() {
    local f few='--samples 4 --size 16 --levels 2 --lut-size 4'
    iblbake -q env.exr $few --preset learnopengl --irradiance-step .5 -o out
    iblbake -q env.exr $few --irradiance-step .5 -o long --method sampled \
        --mapping linear --lod-bias 0 --irradiance-size 32 --lut-samples 1024 \
        --geometry schlick-ibl --lobe-table no
    for f in out/*.ktx2; do cmp "$f" "long/${f#*/}"; done
    ls out long | sort | uniq -c | grep ' 1 .*ktx2'
}

# A name that is no text is refused, as the name of files; that of a map is not.
test_sidecar_names() {
    local odd
    odd=$(printf 'a%%\377\303\251b')
    cp env.exr "$odd.exr"
    iblbake -q $small "$odd.exr" -o out 2>err && is 1 0 status
    has 'no UTF-8.*give another$' err
    iblbake -q $small "$odd.exr" -o out --name odd
    js <<'END'
equal('path', json('out/odd.json').source.path, 'a%\ufffd\ufffd\ufffdb.exr');
END
    odd='a%25é"\o'
    cp env.exr "$odd.exr"
    iblbake -q $small "$odd.exr" -o out
    js "$odd" <<'END'
const [, , odd] = process.argv, {source, outputs} = json(`out/${odd}.json`);
equal('names', [source.path, outputs[0].file], [odd + '.exr', odd + '_specular.ktx2']);
END
}

# A light and what it is taken out of have the light of the map; the skybox
# keeps all. glTF's light is the same one. Nothing depends on threads.
test_lights() {
    mkenv hdr 128 64 >sunny.hdr
    local to='--size 32 --lut-size 8 --pixel rgba32f --format ktx --skybox 32'
    iblbake -q $to sunny.hdr -o all --rotate 70
    iblbake -v $to sunny.hdr -o rest --rotate 70 --sun -j 1 2>told
    iblbake $to sunny.hdr -o again --rotate 70 --lights 5 -j 3 \
        --preview x.png 2>err
    has 'warning: 1 of 5 lights were taken: ' err
    cmp all/sunny_skybox.ktx rest/sunny_skybox.ktx
    for f in rest/*.ktx; do cmp "$f" "again/${f#*/}"; done
    js <<'END'
const [all, rest, again] =
    ['all', 'rest', 'again'].map(d => json(d + '/sunny.json'));
equal('lights that nobody wants', [all.lights, all.gltf], [undefined, undefined]);
equal('the light of five', again.lights, rest.lights);
const [light] = rest.lights;
const told = fs.readFileSync('told', 'utf8')
    .match(/light: towards (.*), radius (.*) degrees, irradiance (.*)/) ?? [];
[...light.direction, light.radius_deg, ...light.irradiance].forEach((x, i) => near(
    `number ${i} of ${told[0]}`, told.slice(1).join(' ').split(' ')[i], x, 1e-3 * Math.abs(x) + 5e-5));
const less = all.sh.radiance.map((a, i) =>
    a.map((x, c) => x - rest.sh.radiance[i][c]));
for (let c = 0; c < 3; c++) {
    near('light', less[0][c] * Math.sqrt(4 * Math.PI) / light.irradiance[c], 1,
        1e-6);
    const omega = 2 * Math.PI * (1 - Math.cos(light.radius_rad));
    near('radiance', light.radiance[c] * omega / light.irradiance[c], 1, 1e-9);
    [3, 1, 2].forEach((i, axis) => near('direction',
        less[i][c] * Math.sqrt(4 * Math.PI / 3) / light.irradiance[c],
        light.direction[axis], 1e-3));
}
near('degrees', light.radius_deg, light.radius_rad * 180 / Math.PI, 1e-9);
const g = rest.gltf, node = g.nodes[g.scenes[g.scene].nodes[0]];
const lamp = g.extensions.KHR_lights_punctual
    .lights[node.extensions.KHR_lights_punctual.light];
const [x, y, z, w] = node.rotation;
const back = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)];
for (let c = 0; c < 3; c++) {
    near('gltf', back[c], light.direction[c], 1e-9);
    near('lux', lamp.color[c] * lamp.intensity, light.irradiance[c], 1e-9);
    near('color', lamp.color[c], Math.min(lamp.color[c], 1), 0);
}
near('rotation', x * x + y * y + z * z + w * w, 1, 1e-9);
END
    grep -laP 'iblbake.lights\x{00}1\x{00}' rest/*.ktx >keyed
    printf 'rest/sunny_%s.ktx\n' irradiance specular | diff keyed -
}

# The nine of Filament's text, of the key that it reads, and of Cesium are the
# same, E/pi with all constants, in one order; check-clients.sh has engines look
# those of three.js and Cesium up. A file of four has no key.
test_sh_formats() {
    iblbake -q --only json --sh-format cmgen env.exr -o cmgen
    iblbake -q --only json --sh-format cesium env.exr -o cesium
    iblbake -q --size 8 --only specular --format ktx env.exr -o key
    iblbake -q --size 8 --only specular --format ktx --sh 1 env.exr -o less
    ls key less >names
    printf '%s:\nenv_specular.ktx\n' key less | sed '2a\\' | diff - names
    is '' "$(grep -ao 'sh.$' less/env_specular.ktx)" 'key of four'
    js <<'END'
const lines = fs.readFileSync('cmgen/env_sh.txt', 'utf8').trim().split('\n');
const cmgen = lines.flatMap(line => line.match(
    /^\( *(.*), *(.*), *(.*)\); \/\/ L\d-?\d, irradiance, pre-scaled base$/)
    .slice(1).map(Number));
const ktx = fs.readFileSync('key/env_specular.ktx');
const at = ktx.indexOf('sh\0'), size = ktx.readUInt32LE(at - 4);
const key = ktx.toString('latin1', at + 3, at + size - 1).trim().split(/\s+/);
const cesium = json('cesium/env_sh.txt');
near('numbers', cesium.length + cmgen.length + key.length, 81, 0);
cesium.forEach((x, i) => [cmgen[i], +key[i]].forEach(y =>
    near('number ' + i, y, x, 1e-5)));
END
}

# What others say of a file, what was put into it, and all files but the damaged.
test_info() {
    have oiiotool || return
    iblbake -q env.hdr -o out --size 16 --levels 3 --lut-size 16 --pixel rgba32f
    cp "$OLDPWD/data/sky.exr" .
    js <<'END'
const bytes = fs.readFileSync('out/env_specular.ktx2');
const at = l => Number(bytes.readBigUInt64LE(80 + 24 * l));
bytes.writeUInt32LE(0x7fc00000, at(0) + 16 * 5 + 4); // NaN
bytes.writeUInt32LE(0xff800000, at(1)); // -Inf
bytes.writeFloatLE(-1, at(1) + 16 + 8);
bytes.writeFloatLE(123456, at(1) + 32);
fs.writeFileSync('odd.ktx2', bytes);
// A sky of 1 with a sun of 256 x 256 / 32 on pixel 96, 20.
const pixels = Buffer.alloc(256 * 128 * 4, Buffer.from([128, 128, 128, 129]));
pixels.set([128, 128, 128, 140], (20 * 256 + 96) * 4);
fs.writeFileSync('sun.hdr', Buffer.concat([Buffer.from('#?RADIANCE\n' +
    'FORMAT=32-bit_rle_rgbe\n\n-Y 128 +X 256\n'), pixels]));
END
    iblbake info --json -q env.hdr env.exr sky.exr out/env_specular.ktx2 odd.ktx2 \
        out/brdf_lut.ktx2 sun.hdr >info.json || is 0 $? status
    oiiotool --info --stats env.hdr env.exr >stats
    js <<'END'
const {files} = json('info.json');
const [hdr, exr, sky, texture, odd, lut, sun] = files;
const said = fs.readFileSync('stats', 'utf8');
for (const f of [hdr, exr]) {
    const part = said.slice(said.indexOf(f.file));
    const [, width, height] = part.match(/: +(\d+) x +(\d+)/);
    near(f.file, f.width, +width, 0);
    near(f.file, f.height, +height, 0);
    const most = Math.max(...part.match(/Stats Max: ([^(]*)/)[1].trim().split(' '));
    near(f.file + ' peak', f.peak, most, 1e-4 * most);
    near(f.file + ' bytes', f.bytes, fs.statSync(f.file).size, 0);
}
must('Radiance RGBE', /^Radiance RGBE/.test(hdr.format), hdr.format);
near('negative pixels', sky.negative, 11, 0);
const head = fs.readFileSync('out/env_specular.ktx2');
[texture.width, texture.height, , texture.layers - 1, texture.faces,
    texture.levels.length].forEach((n, i) => i === 2 ||
        near('member ' + i, n, head.readUInt32LE(20 + 4 * i), 0));
near('VkFormat', head.readUInt32LE(12), 109, 0);
equal('format', texture.format + texture.pixel, 'ktx2rgba32f');
const {outputs} = json('out/env.json');
outputs.find(o => o.content === 'specular').levels.forEach((l, i) =>
    near('roughness', texture.levels[i].roughness, l.roughness, 1e-8));
texture.levels.forEach(l => l.mean.forEach((x, c) =>
    near('mean of a level', x / hdr.mean[c], 1, 2e-2)));
const table = fs.readFileSync('out/brdf_lut.ktx2');
let sum = 0;
for (let i = 0; i < 256; i++)
    sum += table.readFloatLE(table.length - 2048 + 8 * i) / 256;
near('mean of the table', lut.mean[0], sum, 1e-9);
near('not finite', odd.nonfinite, 2, 0);
near('negative', odd.negative, 1, 0);
near('at level 1', odd.levels[1].nonfinite, 1, 0);
near('peak', odd.levels[1].peak, 123456, 0);
near('peak of all', odd.peak, Math.max(...odd.levels.map(l => l.peak)), 0);
near('other peak', odd.levels[2].peak, texture.levels[2].peak, 0);
const theta = Math.PI * 20.5 / 128, phi = 2 * Math.PI * (96.5 / 256 - .5);
const area = 2 * Math.PI / 256 *
    (Math.cos(Math.PI * 20 / 128) - Math.cos(Math.PI * 21 / 128));
const [light, ...more] = sun.lights;
near('lights', more.length, 0, 0);
near('x', light.direction[0], Math.sin(theta) * Math.cos(phi), 2e-3);
near('y', light.direction[1], Math.cos(theta), 2e-3);
near('z', light.direction[2], Math.sin(theta) * Math.sin(phi), 2e-3);
near('mean with a sun', sun.mean[1], 1 + 2047 * area / 4 / Math.PI, 1e-5);
near('share', light.share, 2047 * area / (4 * Math.PI + 2047 * area), 1e-3);
END
    head -c 4000 odd.ktx2 >out/cut.ktx2
    echo nothing >out/not.dds
    echo text >out/notes.txt
    iblbake info out >listed 2>err && is 1 0 'status of damage'
    cut -d : -f 2 err | diff - <(printf ' out/%s\n' cut.ktx2 not.dds)
    lines 4 listed
    refused 1 'iblbake: none: is a directory without *' sh -c \
        'mkdir none; iblbake info none; status=$?; rmdir none; exit $status'
}
# A header says what the whole file does, and whether the file is cut short.
test_info_of_headers() {
    local with n=0
    mkdir cut
    for with in '--zstd 3' '--pixel bc6h' '--format ktx --pixel rgb9e5' \
        '--format dds' '--format dds-legacy' '--layout equirect'; do
        # shellcheck disable=SC2086
        iblbake -q env.hdr -o out --size 128 --name $n --only specular $with
        n=$((n + 1))
    done
    for with in out/*; do head -c 20000 "$with" >"cut/${with##*/}"; done
    iblbake info --json --texels no out >no
    iblbake info --json --texels yes out >yes
    js <<'END'
const plain = name => JSON.stringify(json(name).files, (key, value) =>
    /^(peak|mean|nonfinite|negative)$/.test(key) ? undefined : value, 1);
equal('without texels', plain('no'), plain('yes'));
near('files', json('no').files.length, 6, 0);
END
    iblbake info cut 2>err && is 1 0 'status of what is cut'
    count 6 'iblbake: cut/.*: damaged or cut short: ' err
}
# The headers of 1,000 textures of 6 MiB in a second, without their texels.
test_info_of_many() {
    [ $sanitized = no ] || return
    iblbake -q env.exr -o out --size 256 --pixel rgba32f --levels 1 --only specular
    node -e 'for (let n = 1000; n < 2000; n++)
        require("fs").linkSync("out/env_specular.ktx2", `out/${n}.ktx2`)'
    (
        ulimit -t 1
        iblbake info -j 1 out >listed 2>err || is 0 $? status
    )
    [ "$(grep -c '256x256x6 .*ktx2 rgba32f' listed)" = 1001 ] ||
        { tail -n 1 listed; cat err; }
}
# A bake of the same floats has the same bytes; what loses nothing does so there
# and back; maps of other layouts have each level's light.
test_convert() {
    local with file
    mkdir got
    iblbake -q env.exr -o all $small --levels 2 --pixel rgba32f --mirror x --sun
    for with in 'ktx2 --pixel bc6h --zstd 3' 'ktx --pixel rgb9e5' \
        'dds --pixel rgba16f' 'dds --pixel r11g11b10f --largest 2'; do
        # shellcheck disable=SC2086
        iblbake -q env.exr -o want $small --levels 2 --mirror x --sun --sh 1 \
            --format $with
        for file in env_specular env_irradiance; do
            # shellcheck disable=SC2086
            iblbake convert -q all/$file.ktx2 got/$file.${with%% *} \
                ${with#* } || is 0 $? "$with: status"
            cmp {got,want}/$file.${with%% *}
        done
        rm -r want
    done 2>err
    sed '/^iblbake: warning: /d' err
    cd got || return
    iblbake convert ../all/env_lobe_lut.ktx2 lobes.ktx &&
        iblbake convert lobes.ktx lobes.ktx2 && cmp ../all/env_lobe_lut.ktx2 lobes.ktx2
    iblbake convert env_specular.ktx2 a.ktx
    iblbake convert --zstd 3 a.ktx b.ktx2 && cmp env_specular.ktx2 b.ktx2
    for with in equirect octahedral; do
        iblbake convert ../all/env_specular.ktx2 $with.ktx2 --layout $with
        iblbake convert $with.ktx2 $with-cube.ktx2 --layout cube
    done
    iblbake info --json ../all/env_specular.ktx2 equirect.ktx2 \
        octahedral.ktx2 {equirect,octahedral}-cube.ktx2 >info
    js <<'END'
const {files} = json('info'), [cube] = files;
for (const f of files) f.levels.forEach(({mean, roughness}, l) => {
    near(f.file + ' ' + l, mean[1], cube.levels[l].mean[1], 5e-3);
    near(f.file + ' roughness', roughness, cube.levels[l].roughness, 0);
});
for (const f of files.slice(3))
    equal('keys', f.keys, cube.keys);
END
    refused 1 'iblbake: ../env.exr: is no texture (*' iblbake convert ../env.exr o.dds
    refused 1 'iblbake: b.ktx2: is a baked map (specular), *' \
        iblbake b.ktx2 -o none --only skybox --skybox 4
    iblbake b.ktx2 -o some --only skybox --skybox 4 --prefiltered 2>err
    has 'warning: b.ktx2: is a baked map (specular), whose level 0 is' err
    refused 1 'iblbake: b.ktx2: such a file cannot hold these texels: *' \
        iblbake convert b.ktx2 o.dds --pixel astc4x4hdr
    refused 1 'iblbake: lobes.ktx: has layers or alpha, *' \
        iblbake convert lobes.ktx o.png
    refused 1 'iblbake: b.ktx2: is both input and output: *' \
        iblbake convert b.ktx2 b.ktx2 --zstd 1
    refused 1 'iblbake: lobes.ktx: is a table, no map: *' \
        iblbake convert lobes.ktx o.ktx --layout equirect
}
# OpenImageIO reads from pictures what textures of the same bake hold: halves and
# floats as they are, RGBE to half a step of its exponent, PNG after its curves.
test_pictures() {
    have oiiotool || return
    local with file args=() sky='--skybox 8 --only skybox --pixel rgba32f'
    for with in '16 --pixel rgba16f' '32 --pixel rgba32f' 'flat --layout equirect' \
        'exr --format exr' 'exr32 --format exr --pixel rgba32f --primaries acescg' \
        'dim --pixel rgba32f --largest .9985' 'dimmed --format hdr --largest .9985' \
        'hdr --format hdr' 'cross --format hdr --layout cross' \
        'pano --format exr --layout equirect --rotate 90' \
        'png --format png' 'clip --format png --tone clip'; do
        # shellcheck disable=SC2086
        iblbake -q env.exr -o "${with%% *}" $small --levels 2 --skybox 8 \
            ${with#* } || is 0 $? "$with: status"
    done
    iblbake convert flat/env_specular.ktx2 flat.exr
    iblbake convert 32/env_specular.ktx2 cubes.exr
    iblbake convert 32/env_specular.ktx2 crosses.hdr --layout cross
    iblbake convert 32/brdf_lut.ktx2 lut.png
    for file in {exr,exr32,hdr,dimmed,cross,pano,png,clip,.}/*.{exr,hdr,png}; do
        [ ! -f "$file" ] || args+=("$file" -o "$file.tif")
    done
    oiiotool -d float --compression none "${args[@]}" || return
    js <<'END'
const half = h => (h & 0x7c00 ? (1 + (h & 0x3ff) / 1024) * 2 ** ((h >> 10 & 31) - 15) :
    (h & 0x3ff) * 2 ** -24) * (h & 0x8000 ? -1 : 1);
// Levels of faces of texels of R, G and B.
function texture(name) {
    const b = fs.readFileSync(name), u32 = at => b.readUInt32LE(at), levels = [];
    const [channels, size] = {83: [2, 2], 97: [4, 2], 103: [2, 4], 109: [4, 4]}[u32(12)];
    for (let l = 0; l < u32(40); l++) {
        const w = u32(20) >> l, h = u32(24) >> l, faces = u32(36);
        const start = Number(b.readBigUInt64LE(80 + 24 * l));
        levels.push(Array.from({length: faces}, (_, f) => ({w, h,
            at: (x, y, c) => {
                const i = start + (((f * h + y) * w + x) * channels + c) * size;
                return c >= channels ? 0 : size === 2 ? half(b.readUInt16LE(i)) :
                    b.readFloatLE(i);
            }})));
    }
    return levels;
}
// OpenImageIO's TIFF: strips follow each other.
function picture(name) {
    const b = fs.readFileSync(name + '.tif'), tags = {}, ifd = b.readUInt32LE(4);
    for (let i = 0; i < b.readUInt16LE(ifd); i++) {
        const at = ifd + 2 + 12 * i, short = b.readUInt16LE(at + 2) === 3;
        tags[b.readUInt16LE(at)] =
            short ? b.readUInt16LE(at + 8) : b.readUInt32LE(at + 8);
        if (b.readUInt32LE(at + 4) > 1 && !short)
            tags[b.readUInt16LE(at)] = b.readUInt32LE(b.readUInt32LE(at + 8));
    }
    const w = tags[256], h = tags[257], n = tags[277];
    return {w, h, at: (x, y, c) => b.readFloatLE(tags[273] + 4 * ((y * w + x) * n + c))};
}
const same = x => x;
const srgb = x => x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055;
const film = x => x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
const byte = x => Math.min(Math.max(x, 0), 1);
function compare(name, face, as, slack, x0 = 0, y0 = 0) {
    const p = picture(name);
    if (!x0 && !y0 && p.w !== 4 * face.w) near(name + ' width', p.w, face.w, 0);
    for (let y = 0; y < face.h; y++) for (let x = 0; x < face.w; x++) {
        const want = [0, 1, 2].map(c => as(face.at(x, y, c)));
        for (let c = 0; c < 3; c++)
            if (Math.abs(p.at(x + x0, y + y0, c) - want[c]) > slack(want, c))
                return near([name, x, y, c], p.at(x + x0, y + y0, c), want[c], 0);
    }
}
const sides = ['px', 'nx', 'py', 'ny', 'pz', 'nz'];
const place = [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [3, 1]]; // of <ibl/io.h>
const exact = () => 0;
// Half a step of 8 bits of the largest, or of the next exponent, to which that
// may round up.
const rgbe = (want, c) => {
    const most = Math.max(...want), up = want[c] === most ? 1 : 256 / 255.5;
    return 2 ** (Math.floor(Math.log2(most * up)) - 8) * 1.001;
};
const steps = () => .51 / 255;
function all(dir, ext, from, as, slack) {
    for (const [what, levels] of [['skybox', 1], ['specular', 2], ['irradiance', 1]])
        texture(`${from}/env_${what}.ktx2`).slice(0, levels).forEach((faces, l) =>
            faces.forEach((face, f) => {
                const level = levels > 1 ? `_${l}` : '';
                if (dir === 'cross')
                    compare(`${dir}/env_${what}${level}.${ext}`, face, as, slack,
                        place[f][0] * face.w, place[f][1] * face.h);
                else compare(`${dir}/env_${what}${level}${faces.length > 1 ?
                    '_' + sides[f] : ''}.${ext}`, face, as, slack);
            }));
}
all('exr', 'exr', '16', same, exact);
all('hdr', 'hdr', '32', same, rgbe);
all('cross', 'hdr', '32', same, rgbe);
all('dimmed', 'hdr', 'dim', same, rgbe); // 255.6 of 256
all('png', 'png', '32', x => byte(srgb(film(x))), steps);
all('clip', 'png', '32', x => byte(srgb(x)), steps);
compare('exr/brdf_lut.exr', texture('16/brdf_lut.ktx2')[0][0], same, exact);
compare('lut.png', texture('32/brdf_lut.ktx2')[0][0], byte, steps);
compare('cubes_1_ny.exr', texture('32/env_specular.ktx2')[1][3], same, exact);
compare('flat_1.exr', texture('flat/env_specular.ktx2')[1][0], same, exact);
for (const o of json('exr/env.json').outputs) {
    const files = o.files ?? [o.file];
    near(o.content, files.length, {skybox: 6, specular: 12, irradiance: 6}[o.content] ?? 1, 0);
    near(o.content, files.reduce((sum, f) => sum + fs.statSync('exr/' + f).size, 0), o.bytes, 0);
}
END
    cmp crosses_1.hdr cross/env_specular_1.hdr
    oiiotool --info -v pano/env_skybox.exr exr32/env_skybox_px.exr >said
    has 'iblbake.content: "skybox"' said
    has 'LatLong Environment' said
    has 'chromaticities: 0.713, 0.293' said
    # shellcheck disable=SC2086
    # They are read again: the same cube, which was turned there and back.
    iblbake -q pano/env_skybox.exr -o again $sky --rotate -90 --name a
    iblbake -q cross/env_skybox.hdr -o again $sky --name b
    iblbake -q hdr/env_skybox_%f.hdr -o again $sky --name c
    iblbake info --json 32/env_skybox.ktx2 again/*.ktx2 >info
    js <<'END'
const sums = ({file}) => { // of light by sides: which way it comes from
    const b = fs.readFileSync(file), start = Number(b.readBigUInt64LE(80));
    return Array.from({length: 6}, (_, f) => Array.from({length: 64}, (_, i) =>
        b.readFloatLE(start + 16 * (64 * f + i) + 4)).reduce((a, b) => a + b));
};
const [want, ...files] = json('info').files;
for (const f of files) sums(f).forEach((s, i) =>
    near(f.file, s / sums(want)[i], 1, .02));
END
}
# Five lamps, two of them side by side, and one of a hundredth of their light
# under a soft sky: auto takes the five, with which a shader draws with less than
# .3 of the error. Without lamps it takes none and says nothing.
test_lights_auto() {
    js <<'END'
const W = 512, H = 256, data = Buffer.alloc(4 * W * H);
const lamp = {'100,100': 2e3, '102,100': 2e3, '250,40': 2e3, '330,120': 2e3,
    '480,80': 2e3, '400,200': 20};
for (let i = 0; i < W * H; i++) {
    const x = i % W, y = i / W | 0;
    const v = lamp[[x, y]] ?? 0.2 + 0.1 * Math.cos(Math.PI * y / H);
    const e = Math.max(Math.ceil(Math.log2(v)), -2), m = v * 2 ** (8 - e) | 0;
    data.set([m, m, m, e + 128], 4 * i);
}
require('fs').writeFileSync('lamps.hdr', Buffer.concat([Buffer.from(
    `#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y ${H} +X ${W}\n`), data]));
END
    local f s to='--size 64 --irradiance-size 8 --lut-size 8 --format dds'
    iblbake $to lamps.hdr -o auto --lights auto -j 1 2>err
    iblbake $to env.exr -o none --lights auto 2>>err
    lines 0 err
    has '"lights": \[\]' none/env.json
    iblbake -q $to lamps.hdr -o again --lights auto -j 3
    iblbake -q $to lamps.hdr -o five --lights 5
    iblbake -q $to lamps.hdr -o six --lights 6
    for f in auto/*.dds; do
        cmp "$f" "again/${f#*/}"
        cmp "$f" "five/${f#*/}"
    done
    iblbake -q $to lamps.hdr -o none
    for s in none auto; do
        iblbake verify -q --rendered --directions 64 lamps.hdr $s --json $s.json
    done
    js <<'END'
const error = s => json(s + '.json').rendered.rows.filter(r => r.f0 == 1)
    .reduce((sum, r) => sum + r.nrmse, 0);
must(`.3 of ${error('none')}`, error('auto') < 0.3 * error('none'), error('auto'));
for (const [s, n] of [['auto', 5], ['six', 6]])
    equal(s, json(s + '/lamps.json').lights.length, n);
END
}

# The table's figures are those of the files; what is given is kept.
test_choice() {
    set -- iblbake env.exr --rendered-error .3 --size 40 --levels 3 \
        --pixel rgba32f --irradiance-size 5 --lut-size 17 --lobe-table-size 9
    "$@" -o given >table
    js <<'END'
const {outputs} = json('given/env.json');
const of = what => outputs.find(o => o.content === what);
const got = [of('specular').width, of('specular').levels.length,
    of('specular').pixel, of('irradiance').width, of('brdf_lut').width,
    of('lobe_lut').width].join();
equal('sizes', got, '40,3,rgba32f,5,17,9');
END
    [ $sanitized = no ] || return 0
    "$@" --dry-run | cmp - table
    iblbake env.exr --rendered-error .3 -o out >table
    iblbake env.exr --rendered-error .0001 -o near >table
    # The least error is no more than the default's, whose bytes are all there are.
    awk '/^rendered/ { most = $5 }
        / the least is / { sub(/.* the least is /, ""); least = $1 }
        END { if (!(least > 0 && least <= most))
            print "found " least ", wanted at most " most }' table
    js <<'END'
const set = json('out/env.json');
const {choice, outputs} = set;
const bytes = outputs.reduce((sum, o) => sum + o.bytes, 0);
const {rendered_error, standard_error, bytes: chosen} = choice.set;
must('an error of .3', choice.reached && rendered_error <= 0.3 &&
    standard_error > 0 && standard_error < 0.1, choice);
must(`bytes of files, ${bytes}, and an eighth of the default's`, chosen <= bytes &&
    chosen >= 0.8 * bytes - 2000 && chosen <= choice.default.bytes / 8, choice);
equal('bytes of the default', choice.default.bytes, 4512768);
const [out, least] = ['out', 'near'].map(d => json(`${d}/env.json`).choice.set);
must('fewer bytes, more error', out.bytes < least.bytes / 1.5 &&
    least.rendered_error < out.rendered_error, [out, least]);
// A shader that goes by the mapping finds the levels where they are.
for (const d of ['out', 'near', 'given']) {
    const {lod_scale, lod_offset, levels} =
        json(`${d}/env.json`).outputs.find(o => o.content === 'specular');
    levels.forEach(({roughness: r}, l) => levels.length > 1 &&
        near(d, r * (2 - r) * lod_scale + lod_offset, l, 1e-6));
}
END
}

# What a person would decide. A texture that is not there costs a warning, or,
# strict, the bake.
test_scenes() {
    local no_metal='"metallicFactor": 0' extensions='"extensions": {"KHR_' scene map
    make_scene matte "[{\"pbrMetallicRoughness\": {$no_metal},
        \"occlusionTexture\": {\"index\": 9}}]"
    make_scene mirror '[{"pbrMetallicRoughness": {"roughnessFactor": 0}}]'
    make_scene unlit "[{${extensions}materials_unlit\": {}}}]"
    make_scene sheen "[{\"pbrMetallicRoughness\": {$no_metal},
        ${extensions}materials_sheen\": {\"sheenColorFactor\": [1, 1, 1],
            \"sheenRoughnessFactor\": 0.5}}}]"
    head -c 200 mirror.gltf >cut.gltf
    refused 1 '*cut.gltf: *' iblbake env.exr --scene cut.gltf -o cut
    refused 1 '*matte.gltf: materials?0?.occlusionTexture.index: *' \
        iblbake --scene matte.gltf --strict --dry-run env.exr
    cp mirror.gltf env.gltf
    iblbake env.exr --scene env.gltf --format gltf --mapping linear -o . \
        2>err >table && is 1 0 status
    has 'env.gltf: is both input and output' err
    cmp mirror.gltf env.gltf
    # Options of the split sum's table are not of sheen's, and the bytes told
    # are those of the files but for what says what they are.
    iblbake env.exr --scene sheen.gltf --geometry schlick-ibl --lut-samples 9 \
        -o split >split.txt
    awk -v told="$(sed -n 's/^bytes of texels *\([0-9]*\).*/\1/p' split.txt)" \
        -v there="$(cat split/*.ktx2 | wc -c)" \
        'BEGIN { if (!(told < there && there < told + 20000))
            print "files of " there " bytes, wanted " told " to 20000 more" }'
    [ $sanitized = no ] || return 0
    for scene in matte mirror unlit sheen; do
        map=env.exr
        [ $scene != mirror ] || map=$OLDPWD/data/forest.exr
        iblbake "$map" --scene $scene.gltf --depfile $scene.d -o $scene \
            --name map >$scene.txt 2>$scene.err || is 0 $? "$scene: status"
        is $scene.gltf "$(sed -n '$s/ *//p' $scene.d)"
    done
    has 'warning: matte.gltf: materials\[0\].occlusionTexture.index: .* left' matte.err
    js <<'END'
const seen = name => {
    const set = json(`${name}/map.json`);
    const of = what => set.outputs.find(o => o.content === what);
    return {...set, specular: of('specular'), irradiance: of('irradiance'),
        names: set.outputs.map(o => o.file),
        layers: of('lobe_lut')?.layers.map(l => l.split('= ')[1]).join()};
};
const matte = seen('matte'), mirror = seen('mirror');
const unlit = seen('unlit'), sheen = seen('sheen');
must('16, 30000 bytes', matte.specular.width <= 16 && matte.choice.reached &&
    matte.choice.set.bytes < 30000, [matte.specular, matte.choice]);
equal('matte', [matte.scene.dielectric[64], matte.scene.metal[64]], [1, 0]);
must('a level of r = 0', mirror.specular.levels.length === 1 && !mirror.irradiance &&
    mirror.specular.levels[0].roughness === 0, mirror.specular);
/* Of the lobe table, what the materials look up. */
equal('layers', [matte, mirror, sheen].map(s => s.layers),
    ['0.04,0.04', '1,1', '0.04,0.04']);
equal('unlit', [unlit.names.length, unlit.scene.unlit, unlit.choice.set.bytes],
    [4, 1, unlit.choice.default.bytes]);
must('16', sheen.specular.width <= 16, sheen.specular);
const [charlie] = json('sheen/map_charlie.json').outputs;
equal('charlie', [charlie.lobe, ...charlie.levels.map(l => l.roughness)],
    ['charlie', .5]);
must('10000 bytes', charlie.bytes < 10000, charlie);
END
    # Two scenes are one of both; a target takes no second set.
    iblbake env.exr --scene matte.gltf --scene mirror.gltf --dry-run >both 2>err
    has '2 files: 2 materials' both
    has 'metals *50 %' both
    has 'lobe table *[0-9]*  adds' both
    iblbake env.exr --scene sheen.gltf --target bevy -o bevy >table
    has 'sheen *none' table
}

# The bytes chosen for an error are at most 1.3 times those of a set that has it,
# which options name.
test_fewest() {
    make_scene matte '[{"pbrMetallicRoughness": {"metallicFactor": 0}}]'
    set -- iblbake env.exr --rendered-error .02 --dry-run
    "$@" >chosen 2>err || is 0 $? "$(cat err): status"
    "$@" --size 8 --levels 2 --pixel rgb9e5 --lut-size 8 --lobe-table-size 4 \
        >there 2>err || is 0 $? "$(cat err): status"
    cat there chosen | awk '/^bytes/ { bytes[n++] = $4 }
        /cannot be reached/ || /^bytes/ && $4 == 0
        END { if (!(n == 2 && bytes[1] <= 1.3 * bytes[0])) print n, bytes[0],
            bytes[1] }'
    # The error is that of the set as it is told, with the levels of a mapping.
    value() { sed -n "s/^\(chosen\)\? *$1 *\([^ ]*\) .*/\2/p" chosen; }
    set -- iblbake env.exr --scene matte.gltf --rendered-error .006 \
        --mapping linear --levels 3
    "$@" --dry-run >chosen 2>err
    "$@" -o there --size "$(value size)" --pixel "$(value texels)" \
        --lut-size "$(value 'BRDF table')" \
        --lobe-table-size "$(value 'lobe table')" 2>err >told
    cat told chosen | awk '/^rendered/ { is[n++] = $3 }
        END { if (n != 2 || is[0] != is[1]) print n, is[0], is[1] }'
}

for f in tests/cli/*.case; do
    run_cases "$f"
done
[ -z "${PROGRAM:-}" ] || { end; exit; }
for t in $(compgen -A function test_); do
    picked "$t" || continue
    fresh
    verdict "$t" "$($t 2>&1 | head -n 12)"
    cd "$top"
done
cd "$top"
end

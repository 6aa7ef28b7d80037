#!/bin/sh
# SPDX-License-Identifier: MIT
# What a reader should not have to check. BUILD names a built library.
set -u
build=${BUILD:-build}
bad=0
complain() { echo "lint: $*"; bad=$((bad + 1)); }
# The files of the tree: those of git, or all of a tarball but what was built.
export GIT_CEILING_DIRECTORIES="$PWD/.."
git ls-files >"$build/files.txt" 2>/dev/null ||
    find . -type f ! -path './build/*' ! -name REVISION |
    sed 's|^\./||' >"$build/files.txt"
files() { grep -E "$1" "$build/files.txt"; }
code=$(files '\.(c|h|cpp)$')
shaders=$(files '^src/view/shaders/')
public=$(files '^include/.*\.glsl$')

clang-format --dry-run -Werror $code 2>"$build/format.txt" || {
    sed 's/:.*//' "$build/format.txt" | grep '/' | sort -u
    complain 'not in the format, or no clang-format'
}

# White space at line ends, tabs, and a newline at the end of every text.
grep -vE '\.(exr|f16|glb|hdr|png)$|^tests/fuzz/finds/' "$build/files.txt" | xargs perl -ne '
    warn("$ARGV:$.: trailing blanks\n"), $bad = 1 if /[ \t]$/;
    warn("$ARGV: no newline\n"), $bad = 1 if eof && !/\n\z/;
    close ARGV if eof;
    END { $? = $bad }' || complain 'white space'
awk 'length > 80 { print FILENAME ":" FNR; n++ } END { exit n > 0 }' $code \
    $shaders $public || complain 'lines over 80 columns'

# Every header compiles alone: its own .c begins with it, or it is tried here, and
# the public ones in C++, too.
others=$(for h in $(files '\.h$' | grep -vE '^(tests/windows/|src/port/windows)'); do
    grep -m 1 '^#include "' "${h%.h}.c" 2>/dev/null |
        grep -q "[\"/]${h##*/}\"" || echo "$h"
done)
${CC:-cc} -std=c11 -D_XOPEN_SOURCE=700 -Iinclude -Isrc -Itests -mavx2 -mfma \
    $(pkg-config --cflags OpenEXR) -fsyntax-only -x c $others ||
    complain 'a header does not compile alone'
${CXX:-c++} -std=c++11 -Wall -Wextra -Iinclude -fsyntax-only -x c++ \
    include/ibl/*.h || complain 'a public header is not C++'

# Shaders, as the viewer puts them together, are GLSL 3.30 to a stricter
# compiler than Mesa's, program by program.
mkdir -p "$build/glsl"
for f in $shaders; do
    awk -v file="$f" 'function take(name,    line, part, here) {
            if (had[name]++)
                return
            while ((getline line <name) > 0)
                if (split(line, part, "\"") == 3 && line ~ /^#include "/) {
                    here = (getline line <(dir part[2])) >= 0
                    close(dir part[2])
                    take((here ? dir : "include/ibl/") part[2])
                } else
                    print line
        }
        BEGIN {
            dir = file
            sub(/[^\/]*$/, "", dir)
            print "#version 330 core"
            print "#extension GL_ARB_texture_cube_map_array : enable"
            take(file)
        }' >"$build/glsl/${f##*/}"
done
programs=$(sed -n \
    's/.*view_program("[^"]*", "\(.*\)", "\(.*\)").*/\1 \2/p' src/view/*.c*)
[ -n "$programs" ] || complain 'no shader programs are found'
while read -r vertex fragment; do
    glslangValidator -l "$build/glsl/$vertex" "$build/glsl/$fragment" \
        >"$build/glsl/log" && continue
    cat "$build/glsl/log"
    complain "$vertex, $fragment: not GLSL"
done <<PROGRAMS
$programs
PROGRAMS

# Names with external linkage carry the prefix.
nm -g --defined-only "$build/libiblbake.a" |
    awk 'NF == 3 && $3 !~ /^ibl_/ && $3 !~ /^(__|_GLOBAL|DW\.)/ \
        { print $3; n++ } END { exit n > 0 }' ||
    complain 'external names without ibl_'
# What a program can link to: another list wants another SOVERSION.
nm -D --defined-only "$build/libiblbake.so" | awk '{ print $3 }' | sort |
    diff tests/symbols.txt - || complain 'other symbols than tests/symbols.txt'
# The viewer's: view_, gl (which stands for gl.h's functions), main and what
# src/common/ asks a program for.
if [ -e "$build/iblview" ]; then
    nm -g --defined-only "$build"/obj/src/view/*.o |
        awk 'NF == 3 && $3 != "ibl_this_program" && \
            $3 !~ /^(view_|gl$|main$|__|_GLOBAL|DW\.)/ \
            { print $3; n++ } END { exit n > 0 }' ||
        complain 'external names of the viewer without view_'
fi

# Includes point downwards: room, then the rooms it may name.
while read -r room allowed; do
    files "^src/$room/.*\.(c|h|cpp)$" | xargs grep -H '^#include "' |
        grep -vE "\"(ibl|$(echo "$allowed" | tr ' ' '|'))/"
done >"$build/layers.txt" <<'ROOMS'
port port io
core core port
image image core kern
brdf brdf core
kern kern core brdf
bake bake core image brdf kern
probe probe core
io io core image kern json port
json json port
common common json port
engine engine core common image io json
set set core common engine image io json
scene scene core common io engine json port
cli cli common engine scene set json port
view view common engine scene set json port
ROOMS
[ ! -s "$build/layers.txt" ] || {
    cat "$build/layers.txt"
    complain 'includes against the arrows'
}
grep -rnE '#include "(core|image|brdf|kern|bake|probe|io)/' src/common src/cli \
    src/view && complain 'programs see include/, json/ and port/ only'
# No module, NAME.h with NAME.c and NAME_simd.c, needs itself through others.
files '^src/.*\.(c|h|cpp)$' | xargs grep -H '^#include "' |
    sed -E 's/^src\///; s/(_simd|_lanes)?\.(c|h|cpp):.*"(.*)"$/ \3/
        s/(_simd|_lanes)?\.h$//' | awk '$1 != $2' |
    tsort 2>"$build/circles.txt" >/dev/null || {
    cat "$build/circles.txt"
    complain 'modules include each other in a circle'
}
grep -rn --include="*.[ch]" pthread_create src | grep -vE '^src/(core/pool|cli/batch|view/baked_set)\.c' &&
    complain 'threads are started in core/pool.c, cli/batch.c and view/baked_set.c
only'

# Small is a feature.
sh tests/budget.sh tests/budget.txt || complain 'more lines than there may be'

# Mutants fit the source as it is.
bash tests/mutants/run.sh --check >"$build/mutants.txt" || {
    cat "$build/mutants.txt"
    complain 'mutants whose lines or tests are gone'
}

for page in man/*.[0-9]; do
    [ -f "$page" ] || continue
    mandoc -Tlint -Wstyle "$page" || complain "$page: mandoc"
done

[ $bad -eq 0 ] && echo 'lint: clean'
[ $bad -eq 0 ]

#!/bin/sh
# SPDX-License-Identifier: MIT
# What the viewer's fragment shaders would cost on an integrated GPU (Vega 8 of
# the first Ryzen) at 1920x1080, by the estimate of a compiler for it: Mesa's
# RADV compiles for GPUs that are not there. Nothing is drawn and nothing is
# timed: it is no frame rate. Skipped, with a word, where something is missing.
set -eu
skip() {
    echo "shader-cost: skipped: $1"
    exit 0
}
command -v glslangValidator >/dev/null 2>&1 ||
    skip 'there is no glslangValidator (Debian: glslang-tools)'
work=$(mktemp -d "${TMPDIR:-/tmp}/iblview-cost-XXXXXX")
trap 'rm -rf "$work"' EXIT
echo '#include <vulkan/vulkan.h>' >"$work/vulkan.c"
${CC:-cc} -fsyntax-only "$work/vulkan.c" 2>/dev/null ||
    skip 'there are no headers of Vulkan (Debian: libvulkan-dev)'
${CC:-cc} -std=c11 -Wall -Wextra -O1 -o "$work/cost" tests/shader_cost.c -lvulkan

# A shader with what it includes, each file once, as src/view/program.c does it.
# Vulkan has no GLSL before 4.5; glslangValidator finds places for what has
# none.
flat() { # FILE
    awk 'function put(name, i, at, line) {
            if (name in had)
                return
            had[name] = 1
            for (i = 1; i <= 2; i++) {
                at = folder[i] name
                if ((getline line <at) <= 0)
                    continue
                do
                    if (line ~ /^#include "/)
                        put(substr(line, 11, index(substr(line, 11), "\"") - 1))
                    else
                        print line
                while ((getline line <at) > 0)
                return
            }
        }
        BEGIN {
            folder[1] = "src/view/shaders/"; folder[2] = "include/ibl/"
            print "#version 450"
            put(ARGV[1])
        }' "$1"
}
set --
for pair in full.vert:sky.frag sphere.vert:sphere.frag full.vert:display.frag \
    room.vert:room.frag room_sky.vert:room_sky.frag; do
    vertex=${pair%:*} fragment=${pair#*:}
    mkdir "$work/$fragment"
    flat "$vertex" >"$work/$fragment/$vertex"
    flat "$fragment" >"$work/$fragment/$fragment"
    # Local probes come in four words of bits, and hardly any point has more
    # than one probe of each; a compiler would think of all that could be.
    if [ "$fragment" = room.frag ]; then
        sed -i 's/while (bits != 0u/if (bits != 0u/w '"$work/once" \
            "$work/$fragment/$fragment"
        [ -s "$work/once" ] || {
            echo 'room.frag: no loop over probes: mend the line that finds it' >&2
            exit 1
        }
    fi
    (cd "$work/$fragment" && glslangValidator -V -R --aml --amb -l "$vertex" \
        "$fragment" >log) || { cat "$work/$fragment/log"; exit 1; }
    set -- "$@" "$fragment" "$work/$fragment/vert.spv" "$work/$fragment/frag.spv"
done

status=0
RADV_FORCE_FAMILY=raven MESA_SHADER_CACHE_DISABLE=true "$work/cost" "$@" >"$work/table" 2>"$work/why" ||
    status=$?
[ $status != 77 ] ||
    skip 'this Vulkan has no RADV (Debian: mesa-vulkan-drivers)'
[ $status = 0 ] || { cat "$work/why"; exit 1; }
cat <<'END'
Fragment shaders by the estimate of Mesa's compiler ACO, not a measured frame
rate: nothing was drawn.
waves    in flight on a SIMD
latency  cycles of a wave of 64 pixels from its first to its last instruction
busy     cycles that a SIMD is busy with a wave, with the others in flight; for
         a choice that all pixels make alike both ways count half
ms, %    busy for 1920x1080 pixels, all covered, on 8 units of 4 SIMDs at
         1.1 GHz; share of the 16.7 ms between frames at 60 a second
once     ms if every wave went through every instruction once, 4 cycles each
cube, 2D lookups of a pixel, and those in buffers, all branches taken, loops
         turning three times; ms: of the units that filter, at one of them a
         clock and unit, as with halves between two levels, or four of buffers
bytes    of texels that a pixel's lookups touch; GB/s: at 60 frames a second,
         if no cache had any of them. Two channels of DDR4-2400 have 38; caches
         are what lookups of neighbouring pixels count on
The room has four local probes at each pixel, and the one that moves.
What is written and blended adds 52 bytes a pixel, 6.5 GB/s.
END
cat "$work/table"

#!/bin/bash
# SPDX-License-Identifier: MIT
# The functions for shaders as a compiler of GLSL sees them that is not of a
# driver, in both languages that they are for; each must be called here.
set -u
. tests/lib.sh
command -v glslangValidator >/dev/null ||
    skip_all 'no glslangValidator (glslang-tools)'

cat >"$work/use.glsl" <<'GLSL'
uniform samplerBuffer probes;
uniform usampler2D tiles;
uniform samplerCube sky;
uniform vec3 point, r;
uniform mat4 clip;
uniform int count;
layout(location = 0) out vec4 color;
layout(location = 1) out uvec2 mask_of_tile;

void main()
{
    uvec2 mask = ibl_tile_mask(tiles, gl_FragCoord.xy, 16);
    ibl_mix m = ibl_probes_blend(probes, mask, point);
    ibl_mix all = ibl_probes_blend(probes, count, point);
    ibl_mix near = ibl_probes_near(probes, count, point, 3);
    int nearest = ibl_probes_nearest(probes, count, point);
    ibl_mix seen = ibl_mix_none();
    vec3 light = m.rest * textureLod(sky, r, 0.0).rgb;

    for (int i = 0; i < m.count; i++) {
        ibl_probe p = ibl_probe_fetch(probes, m.probe[i]);
        vec3 lookup;

        ibl_probe_parallax(p, point, r, lookup);
        vec4 color = textureLod(sky, lookup, float(p.layer));
        ibl_mix_add(seen, i, ibl_probe_influence(p, point) * color.a);
        light += m.weight[i] * color.rgb;
    }
    ibl_mix_end(seen);
    color = vec4(light, seen.rest + all.rest + near.weight[0] + float(nearest));
    mask_of_tile = ibl_tile_cull(probes, count, clip, ivec2(1920, 1080), 16,
                                 ivec2(gl_FragCoord.xy));
}
GLSL
for version in '330 core' '430 core' '310 es' '320 es'; do
    { echo "#version $version"
      case $version in *es)
        [ "${version% *}" -ge 320 ] ||
            echo '#extension GL_EXT_texture_buffer : require'
        echo 'precision highp float; precision highp int;
            precision highp samplerBuffer; precision highp usampler2D;'
      esac
      cat include/ibl/probes.glsl "$work/use.glsl"; } >"$work/use.frag"
    ok "${version// /-}" glslangValidator "$work/use.frag"
done
# What is not called is not compiled by every driver.
for name in $(sed -nE 's/^[a-z0-9_]+ (ibl_[a-z_]+)\(.*/\1/p' \
    include/ibl/probes.glsl | sort -u); do
    ok "called-$name" test "$(cat include/ibl/probes.glsl "$work/use.glsl" |
        grep -cw "$name")" -gt 1
done
end

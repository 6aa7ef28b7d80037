#!/bin/bash
# SPDX-License-Identifier: MIT
# The functions for shaders as a compiler of GLSL sees them that is not of a
# driver, in both languages that they are for; each must be called here.
set -u
. tests/lib.sh
need glslangValidator

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
    color = vec4(light, seen.rest + all.rest);
    mask_of_tile = ibl_tile_cull(probes, count, clip, ivec2(1920, 1080), 16,
                                 ivec2(gl_FragCoord.xy));
}
GLSL
cat >"$work/main.glsl" <<'GLSL'
uniform samplerCube specular, irradiance;
uniform sampler2D brdf;
uniform sampler2DArray lobe;
uniform vec4 p[5], sh[25];
layout(location = 0) out vec4 color;

void main()
{
    color = seen_by(specular, irradiance, brdf, lobe, p[0], p[1], p[2], p[3],
                    p[4], sh);
}
GLSL
cat >"$work/main.hlsl" <<'HLSL'
TextureCube specular, irradiance;
Texture2D brdf;
Texture2DArray lobe;
SamplerState s;
float4 p[5], sh[25];

float4 main() : SV_Target
{
    return seen_by(specular, s, irradiance, s, brdf, s, lobe, s, p[0], p[1],
                   p[2], p[3], p[4], sh);
}
HLSL
heading() { # VERSION
    echo "#version $1"
    case $1 in *es)
        [ "${1% *}" -ge 320 ] ||
            echo '#extension GL_EXT_texture_buffer : require'
        echo 'precision highp float; precision highp int;
            precision highp samplerBuffer; precision highp usampler2D;
            precision highp samplerCube; precision highp sampler2DArray;'
    esac
}
for version in '330 core' '430 core' '310 es' '320 es'; do
    { heading "$version"; cat include/ibl/probes.glsl "$work/use.glsl"; } \
        >"$work/use.frag"
    ok "${version// /-}" glslangValidator "$work/use.frag"
    { heading "$version"
      cat include/ibl/ibl.glsl tests/shader_use.glsl "$work/main.glsl"; } \
        >"$work/ibl.frag"
    ok "ibl-${version// /-}" glslangValidator "$work/ibl.frag"
done
{ cat "$build/gen/ibl.hlsl"
  sed -E -f include/ibl/hlsl.sed tests/shader_use.glsl
  cat "$work/main.hlsl"; } >"$work/ibl.hlsl"
ok hlsl glslangValidator -D -V -e main -S frag --auto-map-bindings \
    -o "$work/ibl.spv" "$work/ibl.hlsl"
# What is not called is not compiled by every driver.
while read -r file use; do
    for name in $(sed -nE 's/^[a-z0-9_]+ (ibl_[a-z_0-9]+)\(.*/\1/p' "$file" |
        sort -u); do
        ok "called-$name" test \
            "$(cat "$file" "$use" | grep -cw "$name")" -gt 1
    done
done <<USES
include/ibl/probes.glsl $work/use.glsl
include/ibl/ibl.glsl tests/shader_use.glsl
USES
end

# SPDX-License-Identifier: MIT
# Makes ibl.hlsl of ibl.glsl, for the build. Each texture NAME comes with its
# sampler NAME_sampler.
s/^\/\/ GLSL 3\.30 or later.*/\/\/ HLSL of shader model 4 or later, made from ibl.glsl by hlsl.sed; it/
s/ ibl\.hlsl is the same file$//
/^\/\/ in HLSL\.$/d
s/^(\/\/     )uniform sampler(Cube|2DArray|2D) (\w+);.*/\1Texture\2 \3; SamplerState \3_sampler;/
s/^(\/\/     )uniform vec4 chain;  /\1vec4 chain;/
s/\bsampler(Cube|2DArray|2D) (\w+)/Texture\1 \2, SamplerState \2_sampler/g
s/\btextureLod\((\w+), /\1.SampleLevel(\1_sampler, /g
s/^( *)vec3 (\w+) = vec3\(textureSize\((\w+), 0\)\);/\1float3 \2;\n\1\3.GetDimensions(\2.x, \2.y, \2.z);/
s/([a-z_0-9]\()(specular|irradiance|brdf|lobe|map), /\1\2, \2_sampler, /g
s/\.SampleLevel\((\w+)_sampler, \1_sampler, /.SampleLevel(\1_sampler, /g
s/\bvec([234])\b/float\1/g
s/\bmix\(/lerp(/g
s/\bfract\(/frac(/g
s/\batan\((\S+), /atan2(\1, /g
s/^const float /static const float /

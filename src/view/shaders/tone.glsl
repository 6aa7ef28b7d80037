// SPDX-License-Identifier: MIT
// Converts scene-linear RGB (Rec. 709 primaries) to display values, 0..1.

// Luminance of Rec. 709 primaries: ITU-R BT.709-6, item 3.2.
float luminance(vec3 c) {
    return dot(c, vec3(0.2126, 0.7152, 0.0722));
}

// Infinity or NaN. Tests the exponent: compilers may take isnan for false.
bvec3 beyond(vec3 c) {
    return equal(floatBitsToUint(c) & 0x7f800000u, uvec3(0x7f800000u));
}

bvec3 not_number(vec3 c) {
    return greaterThan(floatBitsToUint(c) & 0x7fffffffu, uvec3(0x7f800000u));
}

// Reinhard, Stark, Shirley and Ferwerda 2002, "Photographic Tone Reproduction
// for Digital Images", eq. 3, applied to luminance; colours keep their hue.
vec3 reinhard(vec3 c) {
    return c / (1.0 + luminance(c));
}

// Hill's fit of the ACES reference rendering and sRGB output transforms.
// Matrices by rows: sRGB => XYZ => D65_2_D60 => AP1 => RRT_SAT before the fit,
// ODT_SAT => XYZ => D60_2_D65 => sRGB after it:
// github.com/TheRealMJP/BakingLab, BakingLab/ACES.hlsl.
vec3 aces(vec3 c) {
    const mat3 rendering = mat3(0.59719, 0.35458, 0.04823,
                                0.07600, 0.90834, 0.01566,
                                0.02840, 0.13383, 0.83777);
    const mat3 output_device = mat3(1.60475, -0.53108, -0.07367,
                                    -0.10208, 1.10813, -0.00605,
                                    -0.00327, -0.07276, 1.07602);
    c = c * rendering;
    // RRTAndODTFit
    vec3 a = c * (c + 0.0245786) - 0.000090537;
    vec3 b = c * (0.983729 * c + 0.4329510) + 0.238081;
    return (a / b) * output_device;
}

// Khronos PBR Neutral Tone Mapper, specification 1.0 (2024):
// github.com/KhronosGroup/ToneMapping, PBR_Neutral.
vec3 neutral(vec3 c) {
    const float f90 = 0.04; // normal Fresnel reflection, which is removed
    const float start = 0.8 - f90;
    const float desaturation = 0.15;
    float x = min(c.r, min(c.g, c.b));
    c -= x < 2.0 * f90 ? x - x * x / (4.0 * f90) : f90;
    float peak = max(c.r, max(c.g, c.b));
    if (peak < start)
        return c;
    const float d = 1.0 - start;
    float lower = 1.0 - d * d / (peak + d - start);
    float g = 1.0 / (desaturation * (peak - lower) + 1.0);
    return mix(vec3(lower), c * (lower / peak), g);
}

// AgX: Sobotka 2022, github.com/sobotka/AgX, in the space of Rec. 2020 as in
// Blender, its curve by Wrensch 2023, "Minimal AgX Implementation", without a
// look. The result is what the display shows, before sRGB's curve. Matrices by
// columns.
vec3 agx(vec3 c) {
    const mat3 to_2020 = mat3(0.6274, 0.0691, 0.0164, 0.3293, 0.9195, 0.0880,
                              0.0433, 0.0113, 0.8956);
    const mat3 from_2020 = mat3(1.6605, -0.1246, -0.0182,
                                -0.5876, 1.1329, -0.1006,
                                -0.0728, -0.0083, 1.1187);
    const mat3 inset =
        mat3(0.856627153315983, 0.137318972929847, 0.11189821299995,
             0.0951212405381588, 0.761241990602591, 0.0767994186031903,
             0.0482516061458583, 0.101439036467562, 0.811302368396859);
    const mat3 outset =
        mat3(1.1271005818144368, -0.1413297634984383, -0.1413297634984383,
             -0.1106066430966032, 1.157823702216272, -0.1106066430966029,
             -0.0164939387178346, -0.0164939387178343, 1.2519364065950405);
    const float low = -12.47393, high = 4.026069; // stops
    vec3 x = log2(max(inset * (to_2020 * c), 1e-10));
    x = clamp((x - low) / (high - low), 0.0, 1.0);
    vec3 x2 = x * x, x4 = x2 * x2;
    x = 15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x +
        0.4298 * x2 + 0.1191 * x - 0.00232;
    return from_2020 * pow(max(outset * x, 0.0), vec3(2.2));
}

// IEC 61966-2-1:1999, 5.2.
vec3 srgb(vec3 c) {
    c = clamp(c, 0.0, 1.0);
    return mix(1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, 12.92 * c,
               lessThanEqual(c, vec3(0.0031308)));
}

// As view_tone of view/settings.h; 0 is linear.
const int REINHARD = 1, ACES = 2, NEUTRAL = 3, AGX = 4;

vec3 tone(vec3 c, int curve) {
    // Above 1e12 every curve is at its limit; below, squares are finite floats.
    c = clamp(c, 0.0, 1e12);
    return curve == REINHARD  ? reinhard(c)
           : curve == ACES    ? aces(c)
           : curve == NEUTRAL ? neutral(c)
           : curve == AGX     ? agx(c)
                              : c;
}

// Cubehelix: Green 2011, "A colour scheme for the display of astronomical
// intensity images", Bull. Astr. Soc. India 39, eq. 2; start 0.5, -1.5
// rotations, hue and gamma 1. level: 0 (black) .. 1 (white).
vec3 helix(float level) {
    float angle = 6.28318530718 * (0.5 / 3.0 + 1.0 - 1.5 * level);
    float swing = level * (1.0 - level) / 2.0;
    vec2 turn = swing * vec2(cos(angle), sin(angle));
    return clamp(level + mat2x3(-0.14861, -0.29227, 1.97294,
                                1.78277, -0.90649, 0.0) * turn, 0.0, 1.0);
}

const float STOPS = 8.0; // VIEW_STOPS of view/ui.h

// sRGB-encoded false colour of a luminance, STOPS around middle grey.
vec3 false_colour(float y, vec2 pixel) {
    bool stripe = fract((pixel.x + pixel.y) / 8.0) < 0.5;
    if (y < 0.18 * exp2(-STOPS))
        return stripe ? vec3(0.0) : vec3(0.0, 0.0, 0.5);
    if (y > 0.18 * exp2(STOPS))
        return stripe ? vec3(1.0) : vec3(1.0, 0.0, 0.0);
    float at = clamp(log2(y / 0.18) + STOPS, 0.0, 2.0 * STOPS - 1e-4);
    float share = (floor(at) + 0.5 * fract(at)) / (2.0 * STOPS);
    return helix(0.1 + 0.8 * share);
}

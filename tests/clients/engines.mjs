// SPDX-License-Identifier: MIT
/*
 * What each engine makes of exact levels: the lookups of its shaders, after
 * their source. Of each target
 *   page      draws it
 *   world     the direction of our world that a direction of the engine shows
 *   eye       the camera: the same place of our world in all
 *   chain     options of the exact levels
 *   left      whether the engine is left-handed
 *   radiance(exact, n, v, roughness)   of a white metal, linear
 *   diffuse(exact, n, v)               of what is white and no metal
 *   encode    the screen's value of a linear one
 *   roughest  the difference allowed at roughness 1, if it is another
 * n, v: normal and view in the engine's axes; exact: {levels, irradiance
 * (a level of E/pi), sh (nine coefficients of E/pi), albedo(nv, roughness)
 * (split sum: scale and bias)}.
 */
import {lookup, mix} from './cube.mjs';

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const reflect = (n, v) => n.map((x, i) => 2 * dot(n, v) * x - v[i]);
const srgb = x => x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055;
const power = x => x ** (1 / 2.2);
const same = d => d;

/* three and Filament turn rough reflections towards the normal. */
const bent = (n, v, r) => mix(reflect(n, v), n, r ** 4);
const filamentLod = (exact, r) => (exact.levels.length - 1) * r * (2 - r);
const roughest = exact => exact.levels.length - 1;

const three = {
    page: 'three.html', world: same, eye: [4, 4, 4], encode: srgb,
    chain: '--mapping filament --size 256 --levels 6',
    // The roughness that it adds for the screen's sake is what n is off by
    // from pixel to pixel.
    radiance(exact, n, v, roughness, slope) {
        const r = Math.min(1, Math.max(0.0525, roughness) + slope);
        const [scale, bias] = exact.albedo(dot(n, v), r);
        const light = lookup(exact.levels, bent(n, v, r),
                             filamentLod(exact, r));
        const rest = lookup(exact.levels, n, roughest(exact));
        return mix(rest, light, scale + bias);
    },
    diffuse: (exact, n) => lookup(exact.levels, n, roughest(exact))
};

/* Irradiance of nine coefficients of E/pi, as <ibl/ibl.h> orders them. */
export function harmonics(sh, [x, y, z]) {
    const basis = [
        0.28209479, 0.48860251 * y, 0.48860251 * z, 0.48860251 * x,
        1.09254843 * x * y, 1.09254843 * y * z,
        0.31539157 * (3 * z * z - 1), 1.09254843 * z * x,
        0.54627422 * (x * x - y * y)];
    return [0, 1, 2].map(c =>
        basis.reduce((sum, b, i) => sum + b * sh[i][c], 0));
}
/* Babylon mixes the harmonics into rough reflections. */
const babylon = {
    page: 'babylon.html', world: ([x, y, z]) => [z, y, x], left: true,
    eye: [4, 4, 4], encode: power, chain: '--mapping babylon --size 256',
    radiance(exact, n, v, r) {
        const alpha = r * r + 0.0005;
        const light = lookup(exact.levels, babylon.world(reflect(n, v)),
                             0.8 * Math.log2(256 * alpha));
        return mix(light, babylon.diffuse(exact, n), Math.min(1, alpha));
    },
    diffuse: (exact, n) => harmonics(exact.sh, babylon.world(n))
};

const filament = {
    page: 'filament.html', world: same, eye: [4, 4, 4], encode: srgb,
    chain: three.chain,
    radiance: (exact, n, v, roughness) => {
        const r = Math.max(0.045, roughness);
        return lookup(exact.levels, bent(n, v, r), filamentLod(exact, r));
    },
    // Its glTF material reflects 4 % besides.
    diffuse(exact, n, v) {
        const [scale, bias] = exact.albedo(dot(n, v), 1);
        const e = mix([bias], [scale + bias], 0.04)[0];
        const more = 1 + 0.04 * (1 / (scale + bias) - 1);
        const light = lookup(exact.levels, n, roughest(exact));
        const gloss = lookup(exact.levels, n, roughest(exact));
        return light.map((x, c) => x * (1 - e) + e * more * gloss[c]);
    }
};

const playcanvas = {
    page: 'playcanvas.html', world: ([x, y, z]) => [z, y, -x],
    eye: [-4, 4, 4], encode: power,
    chain: '--mapping linear --size 256 --levels 6',
    // It joins 14 x 6 texels by lines there: a low sun takes 2.25, others 1.5.
    roughest: 2.5,
    radiance: (exact, n, v, r) =>
        lookup(exact.levels, playcanvas.world(reflect(n, v)), 5 * r),
    // What is no metal reflects 4 % besides, from any side.
    diffuse: (exact, n, v) =>
        mix(lookup([exact.irradiance], playcanvas.world(n), 0),
            playcanvas.radiance(exact, n, v, 1), 0.04)
};

export const engines = {three, babylon, 'babylon-env': babylon, filament,
                        playcanvas};

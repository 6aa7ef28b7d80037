// SPDX-License-Identifier: MIT
/*
 * What each engine makes of exact levels: the lookups of its shaders, after
 * their source. Of each target
 *   page      draws it
 *   maps      those that it draws beside lamps; nothing: all
 *   half      the set of half floats that it is compared with
 *   world     the direction of our world that a direction of the engine shows
 *   eye       the camera: the same place of our world in all
 *   chain     options of the exact levels
 *   left      whether the engine is left-handed
 *   lit(exact, sphere)   a function of {n, v}, what the sphere shows, linear;
 *             nothing for spheres whose shader is not here
 *   exact(sphere, map)   how much it may be off; nothing: any
 *   encode    the screen's value of a linear one; decode: back
 *   reflects(sums, f0)   the reflection of the integral (integral.mjs), as it
 *             counts light that facets scatter more than once; nothing: its
 *             lookup cannot be replaced
 * n, v: normal and view in the engine's axes; exact: {levels, irradiance
 * (a level of E/pi), sh (nine coefficients of E/pi)}.
 */
import {lookup, mix} from './cube.mjs';

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const reflect = (n, v) => n.map((x, i) => 2 * dot(n, v) * x - v[i]);
const srgb = x => x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055;
const fromSrgb = x => x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4;
const power = x => x ** (1 / 2.2);
const fromPower = x => x ** 2.2;
const same = d => d;

const matte = s => !s.metal && !s.gloss;
const MATTE = [4, 3, Infinity], ALL = [4, 3, 6];
/* E/pi in the world's axes. */
const diffuse = (exact, world, n) => lookup([exact.irradiance], world(n), 0);

const three = {
    page: 'three.html', half: 'three-half', world: same, eye: [4, 4, 4],
    encode: srgb, decode: fromSrgb,
    chain: '--mapping filament --size 384 --levels 6',
    reflects({seen, white, light}, f0) {
        const once = f0 * white[0] + white[1], lost = 1 - white[0] - white[1];
        const mean = f0 + (1 - f0) / 21;
        return light.map((x, c) => f0 * seen[0][c] + seen[1][c] +
            once * mean / (1 - mean * lost) * lost * x);
    },
    lit: (exact, s) => matte(s) && (({n}) => diffuse(exact, same, n)),
    exact: () => MATTE
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
/* Babylon mixes the irradiance into rough reflections. */
const babylon = {
    page: 'babylon.html', world: ([x, y, z]) => [z, y, x], left: true,
    eye: [4, 4, 4], encode: power, decode: fromPower,
    chain: '--mapping babylon --size 256',
    reflects: ({seen, white}, f0) => seen[0].map((x, c) =>
        (f0 * x + seen[1][c]) * (1 + f0 / (white[0] + white[1]) - f0)),
    lit: (exact, s) => matte(s) ?
        ({n}) => diffuse(exact, babylon.world, n) :
        s.metal && (({n, v}) => {
            const alpha = s.roughness ** 2 + 0.0005;
            const light = lookup(exact.levels, babylon.world(reflect(n, v)),
                                 0.8 * Math.log2(256 * alpha));
            return mix(light, diffuse(exact, babylon.world, n),
                       Math.min(1, alpha));
        }),
    exact: s => matte(s) ? MATTE : ALL
};

const filament = {
    page: 'filament.html', half: 'filament-half', world: same,
    eye: [4, 4, 4], encode: srgb, chain: three.chain,
    maps: ['quarry', 'dusk'], // its pages are the slowest
    lit: () => null
};

const playcanvas = {
    page: 'playcanvas.html', world: ([x, y, z]) => [z, y, -x],
    eye: [-4, 4, 4], encode: power, decode: fromPower,
    // It reflects F0 from any side.
    reflects: ({seen, white}, f0) => seen[0].map((x, c) =>
        f0 * (x + seen[1][c]) / (white[0] + white[1])),
    chain: '--mapping linear --size 256 --levels 6',
    // What is no metal reflects 4 % besides, from any side.
    lit: (exact, s) => !matte(s) && (({n, v}) => {
        const light = lookup(exact.levels, playcanvas.world(reflect(n, v)),
                             5 * s.roughness);
        return s.metal ? light :
            mix(diffuse(exact, playcanvas.world, n), light, 0.04);
    }),
    // It joins 64x32 texels of diffuse light by lines, and 28x12 of r = 0.75:
    // the edge of a strong sun's light is off. Texels that were sought for these
    // two pictures alone still had 4.8 and 9.0, with a free range each 4.1 and
    // 7.8, and an atlas of twice the edge 0.6 and 7.6.
    exact: (_, map) => map === 'blaze' ? [5.5, 3, 16] : ALL
};

/* By Babylon's loader. Matte surfaces are lit by nine harmonics. */
const gltf = {
    page: 'babylon.html', world: same, eye: [4, 4, 4], encode: power,
    chain: '--mapping linear --size 256 --levels 5', maps: ['quarry'],
    decode: fromPower, reflects: babylon.reflects,
    lit: (exact, s) => matte(s) && (({n}) => harmonics(exact.sh, n)),
    exact: () => MATTE
};

export const engines = {three, babylon,
    'babylon-env': {...babylon, half: 'babylon', reflects: null}, filament,
    playcanvas, gltf};

// SPDX-License-Identifier: MIT
/*
 * Cubes of floats, looked up as OpenGL does with seamless filtering: faces +X
 * -X +Y -Y +Z -Z, row 0 on top. levels[l] is {n, texels}: 6 faces of (n + 2)^2
 * texels of 3 floats, with a border of the neighbours' texels.
 */
const FACES = [ // across, down and outwards, as axes and signs
    [[2, -1], [1, -1], [0, 1]], [[2, 1], [1, -1], [0, -1]],
    [[0, 1], [2, 1], [1, 1]], [[0, 1], [2, -1], [1, -1]],
    [[0, 1], [1, -1], [2, 1]], [[0, -1], [1, -1], [2, -1]]];

/* The face that a direction meets, and where: -1 to 1 across and down. */
export function faceOf(d) {
    const a = d.map(Math.abs);
    const axis = a[0] >= a[1] && a[0] >= a[2] ? 0 : a[1] >= a[2] ? 1 : 2;
    const face = 2 * axis + (d[axis] < 0);
    const [[s, ss], [t, ts]] = FACES[face];
    return [face, ss * d[s] / a[axis], ts * d[t] / a[axis]];
}
/* The direction of a place on a face, not of unit length. */
export function direction(face, u, v) {
    const [[s, ss], [t, ts], [o, os]] = FACES[face];
    const d = [];
    d[s] = ss * u;
    d[t] = ts * v;
    d[o] = os;
    return d;
}

/* A level of 6 * n * n texels of `channels` floats. */
export function level(n, channels, data) {
    const m = n + 2, texels = new Float32Array(6 * m * m * 3);
    const inside = (i, j) => i >= 0 && i < n && j >= 0 && j < n;
    for (let face = 0, to = 0; face < 6; face++)
        for (let j = -1; j <= n; j++)
            for (let i = -1; i <= n; i++, to += 3) {
                let [f, x, y] = [face, i, j];
                if (!inside(i, j)) {
                    const [g, u, v] = faceOf(direction(face,
                        (2 * i + 1) / n - 1, (2 * j + 1) / n - 1));
                    const index = w => Math.min(n - 1, Math.max(0,
                        Math.floor((w + 1) / 2 * n)));
                    [f, x, y] = [g, index(u), index(v)];
                }
                const from = ((f * n + y) * n + x) * channels;
                for (let c = 0; c < 3; c++)
                    texels[to + c] = data[from + c];
            }
    return {n, texels};
}

function bilinear({n, texels}, [face, u, v]) {
    const x = (u + 1) / 2 * n + 0.5, y = (v + 1) / 2 * n + 0.5;
    const i = Math.min(n, Math.floor(x)), j = Math.min(n, Math.floor(y));
    const m = n + 2, out = [0, 0, 0];
    for (let k = 0; k < 4; k++) {
        const right = k & 1, down = k >> 1;
        const weight = (right ? x - i : 1 - x + i) * (down ? y - j : 1 - y + j);
        const at = 3 * ((face * m + j + down) * m + i + right);
        for (let c = 0; c < 3; c++)
            out[c] += weight * texels[at + c];
    }
    return out;
}
export const mix = (a, b, t) => a.map((x, i) => x + (b[i] - x) * t);

/* lod is held within the levels. */
export function lookup(levels, d, lod) {
    const held = Math.min(levels.length - 1, Math.max(0, lod));
    const low = Math.floor(held), where = faceOf(d);
    const a = bilinear(levels[low], where);
    return low === held ? a :
        mix(a, bilinear(levels[low + 1], where), held - low);
}

/* SPDX-License-Identifier: MIT */
/* Sample sets that filter captured cubes. Needs no OpenGL. */
#ifndef VIEW_CAPTURE_SAMPLES_H
#define VIEW_CAPTURE_SAMPLES_H

/* Number of levels of the lookups; the last has four texels along an edge. */
int view_capture_lookups(int size);
/* Variance along an axis of a lookup in a level from 1 on, in mean solid angles
 * of a texel: wide enough to hide that texel sizes vary 5-fold. */
#define VIEW_CAPTURE_BLUR (5.0 / 3)

/* Samples for each texel: of a level, and of irradiance, whose small cube must
 * be as accurate as a level. */
enum {
    VIEW_CAPTURE_SAMPLES = 64,
    VIEW_CAPTURE_MOST_SAMPLES = 128
};

/* Rows of VIEW_CAPTURE_MOST_SAMPLES: one for each level from 1 on, one for
 * irradiance. A sample: x, y of a direction about +Z, weight, level of the
 * lookup. The caller must free it. NULL, with a message: no memory. */
float *view_capture_samples(int size, int levels);

#endif

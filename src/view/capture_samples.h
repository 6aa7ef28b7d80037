/* SPDX-License-Identifier: MIT */
/* The samples by which captured cubes are filtered. Needs no OpenGL. */
#ifndef VIEW_CAPTURE_SAMPLES_H
#define VIEW_CAPTURE_SAMPLES_H

/* Levels of the lookups: the last has four texels along an edge. */
int view_capture_lookups(int size);
/* Variance along an axis of a lookup in a level from 1 on, in mean solid angles
 * of a texel: wide enough to hide that texels differ 5 times in size. */
#define VIEW_CAPTURE_BLUR (5.0 / 3)

/* Of each texel of a level, and of irradiance: that cube is small, and is to be
 * as good as a level. */
enum {
    VIEW_CAPTURE_SAMPLES = 64,
    VIEW_CAPTURE_MOST_SAMPLES = 128
};

/* Rows of VIEW_CAPTURE_MOST_SAMPLES: one for each level from 1 on, one for
 * irradiance. A sample is x, y of a direction about +Z, weight and level of the
 * lookup. For free(). NULL, with a message: no memory. */
float *view_capture_samples(int size, int levels);

#endif

/* SPDX-License-Identifier: MIT */
#include "kern/arc.h"

#include <immintrin.h>

void ibl_arc_prefix_avx2(const float *rgb, int width, const double *turn,
                         double level, double rise, double *sums)
{
    const __m256d y4 = _mm256_set1_pd(rise);
    __m256d x = _mm256_setzero_pd(), z = x, y = x;

    for (int i = 0; i < width; i++) {
        const __m256d l =
            _mm256_setr_pd(rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2], 1.0);
        const __m256d x4 = _mm256_set1_pd(level * turn[2 * i]);
        const __m256d z4 = _mm256_set1_pd(level * turn[2 * i + 1]);
        double *to = sums + (size_t)i * IBL_ARC_LANES;
        _mm256_storeu_pd(to, x);
        _mm256_storeu_pd(to + 4, z);
        _mm256_storeu_pd(to + 8, y);
        x = _mm256_fmadd_pd(x4, l, x);
        z = _mm256_fmadd_pd(z4, l, z);
        y = _mm256_fmadd_pd(y4, l, y);
    }
    double *to = sums + (size_t)width * IBL_ARC_LANES;
    _mm256_storeu_pd(to, x);
    _mm256_storeu_pd(to + 4, z);
    _mm256_storeu_pd(to + 8, y);
}

typedef struct record {
    __m256d x, z, y;
} record;

static record load(const double *p)
{
    return (record){_mm256_loadu_pd(p), _mm256_loadu_pd(p + 4),
                    _mm256_loadu_pd(p + 8)};
}

static record plus(record a, record b)
{
    return (record){_mm256_add_pd(a.x, b.x), _mm256_add_pd(a.z, b.z),
                    _mm256_add_pd(a.y, b.y)};
}

static record minus(record a, record b)
{
    return (record){_mm256_sub_pd(a.x, b.x), _mm256_sub_pd(a.z, b.z),
                    _mm256_sub_pd(a.y, b.y)};
}

void ibl_arc_add_avx2(const ibl_arc_rows *rows, double centre,
                      const double *half, double sum[IBL_ARC_LANES])
{
    const int width = rows->width;
    const size_t last = (size_t)width * IBL_ARC_LANES;
    const double *row = rows->sums;
    record s = load(sum);

    for (int r = 0; r < rows->rows; r++, row += last + IBL_ARC_LANES) {
        if (!(half[r] > 0.0))
            continue;
        if (half[r] > width) {
            s = plus(s, load(row + last));
            continue;
        }
        int first = (int)(centre - half[r] + 0.5 + width) - width;
        int end = (int)(centre + half[r] + 0.5);
        /* Which of the two stays the same for many rows, so branches. */
        const double *a = row, *b = row;
        if (first < 0 || end > width) {
            if (first < 0)
                first += width;
            else
                end -= width;
            s = plus(s, load(row + last));
        }
        a += (size_t)first * IBL_ARC_LANES;
        b += (size_t)end * IBL_ARC_LANES;
        s = plus(s, minus(load(b), load(a)));
    }
    _mm256_storeu_pd(sum, s.x);
    _mm256_storeu_pd(sum + 4, s.z);
    _mm256_storeu_pd(sum + 8, s.y);
}

/* SPDX-License-Identifier: MIT */
#include "kern/fft.h"

#include <assert.h>
#include <complex.h>
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/pi.h"

#define TURN (2 * IBL_PI)

/* ---- tables ----------------------------------------------------------- */

/* e^(-2 pi i j / size), rounded once. */
static void root(int size, int j, float cos_sin[2])
{
    const double a = TURN * (double)j / (double)size;
    cos_sin[0] = (float)cos(a);
    cos_sin[1] = (float)-sin(a);
}

static void fill_pass(int block, float *pass)
{
    for (int j = 0; j < block / 4; j++)
        for (int k = 1; k <= 3; k++, pass += 2)
            root(block, k * j, pass);
}

/* All passes together have less than 4/3 of the first one's 3/2 size floats. */
bool ibl_fft_init(ibl_fft *fft, int size)
{
    assert(size >= 2 && size <= IBL_FFT_MAX_SIZE && !(size & (size - 1)));
    *fft = (ibl_fft){.size = size};
    fft->roots = ibl_alloc_array((size_t)size, 3 * sizeof *fft->roots);
    if (!fft->roots)
        return false;
    for (int j = 0; j < size / 2; j++)
        root(size, j, fft->roots + 2 * (size_t)j);
    float *pass = fft->roots + size;
    for (int p = 0; size >> 2 * p > 8; p++) {
        const int block = size >> 2 * p;
        fft->passes[p] = pass;
        fill_pass(block, pass);
        pass += block / 4 * 6;
    }
    return true;
}

void ibl_fft_free(ibl_fft *fft)
{
    ibl_free(fft->roots);
    *fft = (ibl_fft){0};
}

int ibl_fft_slot(int size, int i)
{
    int slot = 0;
    for (int bit = 1; bit < size; bit *= 2, i /= 2)
        slot = 2 * slot + (i & 1);
    return slot;
}

static ibl_fft_pair pair(double complex a, double complex b, int first,
                         int second)
{
    return (ibl_fft_pair){{(float)creal(a), (float)cimag(a)},
                          {(float)creal(b), (float)cimag(b)},
                          first,
                          second};
}

/*
 * With E and O the transforms of the even and the odd x, Z = E + i O. So
 * E_m = (Z_m + conj Z_-m) / 2, O_m = (Z_m - conj Z_-m) / 2i, all with period
 * size, and the transform of x is E_m + e^(-2 pi i m / n) O_m.
 */
void ibl_fft_real_pairs(int size, const double *factor, int count,
                        ibl_fft_pair *pairs)
{
    for (int m = 0; m < count; m++) {
        const double complex f = factor[2 * m] + I * factor[2 * m + 1];
        const double angle = TURN / 2 * (double)(m % (2 * size)) / (double)size;
        const double complex odd = -I * (cos(angle) - I * sin(angle));
        const int k = m % size;
        pairs[m] =
            pair(f * (1 + odd) / 2, f * (1 - odd) / 2, ibl_fft_slot(size, k),
                 ibl_fft_slot(size, (size - k) % size));
    }
}

/*
 * The inverse: 2 E_k = X_k + conj X_(size-k), 2 O_k = (X_k - conj
 * X_(size-k)) e^(2 pi i k / n), where X_m is 0 from count on. The factor 2
 * replaces the bins n - m, which the sum over m leaves out.
 */
void ibl_fft_real_pairs_inverse(int size, const double *factor, int count,
                                ibl_fft_pair *pairs)
{
    assert(count >= 1 && count <= size);
    for (int k = 0; k < size; k++) {
        const double angle = TURN / 2 * (double)k / (double)size;
        const double complex odd = I * (cos(angle) + I * sin(angle));
        double complex a = 0, b = 0;
        int first = 0, second = 0;
        if (k == 0) {
            /* Re F_0 = (F_0 + conj F_0) / 2, for even and odd samples. */
            a = b = (1 + I) / 2 * factor[0];
        } else {
            if (k < count) {
                first = k;
                a = (factor[2 * k] + I * factor[2 * k + 1]) * (1 + odd);
            }
            if (size - k < count) {
                second = size - k;
                b = (factor[2 * second] - I * factor[2 * second + 1]) *
                    (1 - odd);
            }
        }
        pairs[ibl_fft_slot(size, k)] = pair(a, b, first, second);
    }
}

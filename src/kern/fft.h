/* SPDX-License-Identifier: MIT */
/*
 * Fast Fourier transforms of sixteen rows at once. Row r is lane r of every
 * vector: no shuffles are needed, and all rows share the twiddle factors.
 *
 * A complex value is 16 real parts and then 16 imaginary ones; value k is at
 * z + k * IBL_FFT_VALUE. So the memory of sixteen real rows x_i, 16 floats for
 * each i, is also that of half as many complex values x_2k + i x_(2k+1). A real
 * transform of n is a complex one of n / 2, followed by ibl_fft_dsp.split.
 *
 * All pointers to lanes are 64-byte aligned.
 */
#ifndef IBL_KERN_FFT_H
#define IBL_KERN_FFT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ibl/ibl.h"
#include "kern/isa.h"

enum {
    IBL_FFT_LANES = 16,
    IBL_FFT_VALUE = 2 * IBL_FFT_LANES, /* floats of a complex value */
    IBL_FFT_MAX_SIZE = 32768,
    IBL_FFT_MAX_PASSES = 8
};

/* Tables for the complex transforms of one size. */
typedef struct ibl_fft {
    int size;     /* a power of two, 2..IBL_FFT_MAX_SIZE */
    float *roots; /* e^(-2 pi i j / size), j < size / 2: cos, sin; owns all */
    /* For blocks of size >> 2 p with more than 8 values and w = e^(-2 pi i /
     * block): w^j, w^2j, w^3j for j < block / 4, each as cos and sin. */
    float *passes[IBL_FFT_MAX_PASSES];
} ibl_fft;

/* False if there is no memory; *fft is then empty. */
bool ibl_fft_init(ibl_fft *fft, int size);
void ibl_fft_free(ibl_fft *fft); /* zeroed is allowed */

/* Reverses the bits of index i in 0..size - 1. */
int ibl_fft_slot(int size, int i);

/* Two complex factors and the indices of two values. */
typedef struct ibl_fft_pair {
    float a[2], b[2];
    int32_t first, second;
} ibl_fft_pair;

/* The spectra of sixteen rows. Bin m has its 16 real parts at data + m * bin,
 * the imaginary ones `part` floats later. */
typedef struct ibl_fft_spectrum {
    float *data;
    size_t bin, part;
} ibl_fft_spectrum;

/*
 * Pairs for real rows of n = 2 size values, 16 floats each, which the
 * complex transforms take for size complex ones.
 * ibl_fft_real_pairs: after forward, split with the count pairs gives
 *     F_m = factor_m sum over i < n of x_i e^(-2 pi i m i / n).
 * ibl_fft_real_pairs_inverse: merge with size pairs, then inverse, gives
 *     x_i = Re G_0 + 2 Re sum over 0 < m < count of G_m e^(2 pi i m i / n),
 *     G_m = factor_m F_m, count <= size, factor_0 real.
 *   factor  count complex numbers, real and imaginary part
 */
void ibl_fft_real_pairs(int size, const double *factor, int count,
                        ibl_fft_pair *pairs);
void ibl_fft_real_pairs_inverse(int size, const double *factor, int count,
                                ibl_fft_pair *pairs);

typedef struct ibl_fft_dsp {
    /*
     * In place, without a factor. Forward takes values in order and leaves
     *     Z_k = sum over j of z_j e^(-2 pi i j k / size)
     * in place ibl_fft_slot(size, k). Inverse takes what forward leaves and
     * gives, in order, the sum over k of Z_k e^(+2 pi i j k / size).
     */
    void (*forward)(const ibl_fft *fft, float *z);
    void (*inverse)(const ibl_fft *fft, float *z);
    /* Bin m = a z[first] + b conj(z[second]), by pairs[m], for m < count. */
    void (*split)(const float *z, const ibl_fft_pair *pairs, int count,
                  const ibl_fft_spectrum *out);
    /* z[k] = a F[first] + b conj(F[second]), by pairs[k], for k < count. */
    void (*merge)(const ibl_fft_spectrum *in, const ibl_fft_pair *pairs,
                  int count, float *z);
} ibl_fft_dsp;

IBL_DECLARE_KERNEL(ibl_fft);

#endif

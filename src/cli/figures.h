/* SPDX-License-Identifier: MIT */
/*
 * Errors of samples as figures with standard errors, and where to take samples.
 *
 * Samples are along an evenly spread sequence that begins at random,
 * IBL_BATCHES stretches of which are batches. The change of a figure when one
 * of them is left out gives its standard error (jackknife), rather too much of
 * it: what one stretch misses the next one has.
 */
#ifndef CLI_FIGURES_H
#define CLI_FIGURES_H

#include <ibl/ibl.h>
#include <stdbool.h>

enum {
    IBL_BATCHES = 16,
    IBL_DIMENSIONS = 6 /* of a sequence */
};

/* What was seen of one sample. With S what is judged, T the truth, |.| over R,
 * G and B: */
typedef struct ibl_seen {
    double weight;
    double error;        /* relative, as of ibl_relative_error */
    double wrong, truth; /* |S - T|^2, |T|^2 */
    double light[2];     /* R + G + B of T and of S */
    int batch;           /* -1: of none, no matter of chance */
} ibl_seen;

typedef enum ibl_figure {
    IBL_FIGURE_NRMSE,  /* sqrt(sum w |S - T|^2 / sum w |T|^2) */
    IBL_FIGURE_MEDIAN, /* of the relative error */
    IBL_FIGURE_P95,    /* its 95th percentile */
    IBL_FIGURE_BIAS,   /* mean R + G + B of S, relative to that of T, - 1 */
    IBL_FIGURES
} ibl_figure;

/* "nrmse", "median", "p95", "bias" */
extern const char *const ibl_figure_names[];

typedef struct ibl_measured {
    double value[IBL_FIGURES];
    double error[IBL_FIGURES]; /* standard errors of these */
    /* Values without a batch: what follows from them has a standard error, too.
     */
    double without[IBL_BATCHES][IBL_FIGURES];
} ibl_measured;

/* Sets of a sample what follows from the colours, of the map's mean: its error,
 * |S - T|^2, |T|^2 and light. */
void ibl_see(ibl_seen *sample, const double judged[3], const double truth[3],
             const double mean[3]);
/* Sorts the samples by error. */
ibl_measured ibl_measured_of(ibl_seen *samples, size_t count);
/* The mean of figures along the same samples, with its errors. */
ibl_measured ibl_measured_mean(const ibl_measured *rows, int count);
/* The standard error of a figure from its values without each batch. */
double ibl_jackknife(const double without[IBL_BATCHES]);

/* The batch of sample i of n. */
static inline int ibl_batch_of(size_t i, size_t n)
{
    return (int)(i * IBL_BATCHES / n);
}
/* Point i of a seed's sequence, 0..1 each. */
void ibl_spread(int seed, size_t i, double u[IBL_DIMENSIONS]);

double ibl_dot(const double a[3], const double b[3]);
void ibl_normalise(double v[3]);
/* The unit vector at an angle from an axis, at an azimuth; NULL: +Y. */
void ibl_around(const double *axis, double cosine, double azimuth,
                double out[3]);

/* A part of a map, as one light. */
typedef struct ibl_spot {
    double direction[3];
    double share;  /* of samples near lights; all are 1, or 0 if it is dark */
    double spread; /* 1 - cosine of the angle below which it is even */
} ibl_spot;

enum {
    IBL_SPOT_COLUMNS = 64, /* of the map, and half as many rows */
    IBL_SPOTS = IBL_SPOT_COLUMNS * IBL_SPOT_COLUMNS / 2
};

/* IBL_SPOTS of them, to be freed by the caller. */
ibl_spot *ibl_spots_of(const ibl_image *env, double yaw_deg);
/* The spot at u, 0..1, of the shares; NULL: it is dark. */
const ibl_spot *ibl_spot_at(const ibl_spot *spots, double u);
/* Draws the cosine of a distance by u, 0..1, so that each octave of it beyond
 * the spread has the same number; and its density by solid angle. */
double ibl_spot_draw(double spread, double u);
double ibl_spot_density(double spread, double cosine);

#endif

/* SPDX-License-Identifier: MIT */
/* Plots as SVG: axes with units, series with a legend, labels that keep out
 * of each other's way. No scripts, no fonts or pictures from elsewhere. */
#ifndef CLI_PLOT_H
#define CLI_PLOT_H

#include <stdbool.h>
#include <stdio.h>

typedef enum ibl_plot_unit {
    IBL_PLOT_NUMBER,
    IBL_PLOT_SECONDS, /* written as µs, ms or s */
    IBL_PLOT_PERCENT  /* 0.01 is written as 1 % */
} ibl_plot_unit;

typedef struct ibl_plot_axis {
    const char *label;
    ibl_plot_unit unit;
    bool log;         /* what is not above 0 is then left out */
    bool at_values;   /* ticks where the points are, not at round numbers */
    double low, high; /* range, if not both 0: else that of the points */
} ibl_plot_axis;

typedef struct ibl_plot_point {
    double x, y;
    double x_low, x_high; /* a bar along x, if not both 0 */
    double y_low, y_high; /* along y */
    bool ring;            /* marked */
    char label[24];       /* beside it, or "" */
} ibl_plot_point;

enum {
    IBL_PLOT_COLOURS = 8
};

typedef struct ibl_plot_series {
    char name[64];
    int style;   /* colour and marker: any number from 0 */
    bool line;   /* joins the points in their order */
    bool dashed; /* the line, without markers: not measured */
    int count;
    ibl_plot_point *points;
} ibl_plot_series;

typedef struct ibl_plot {
    const char *title; /* NULL: none */
    const char *ring;  /* what rings mean, for the legend; NULL: none */
    ibl_plot_axis x, y;
    int count;
    ibl_plot_series *series;
} ibl_plot;

/* The <svg> element. With standalone it is a whole file with its colours;
 * else they are those of ibl_plot_css, which the page has. */
void ibl_plot_write(const ibl_plot *plot, bool standalone, FILE *to);

/* Declarations for :root, light and dark, and rules for what plots use. */
extern const char ibl_plot_css[];

/* text with &, <, > and quotes as entities; control characters as blanks. */
void ibl_plot_escape(const char *text, FILE *to);
/* A value with its unit, three digits at most: "1.25 ms", "0.4 %". */
void ibl_plot_format(ibl_plot_unit unit, double value, char *text, size_t size);

#endif

/* SPDX-License-Identifier: MIT */
/* What a run shows, as plots. */
#ifndef CLI_BENCH_PLOTS_H
#define CLI_BENCH_PLOTS_H

#include "cli/bench.h"
#include "cli/plot.h"

/* A plot that ibl_bench_plot_free frees. count is 0 if the run has not what
 * it shows, or if memory ended. source: an environment as it is. */
ibl_plot ibl_bench_plot_error(const ibl_bench *b, int source);
ibl_plot ibl_bench_plot_roughness(const ibl_bench *b, int source);
/* Time against a swept axis, whole and by stages. */
ibl_plot ibl_bench_plot_axis(const ibl_bench *b, int source,
                             ibl_bench_axis axis);
void ibl_bench_plot_free(ibl_plot *plot);

/* Whether two points are of the same environment, resampled or not. */
bool ibl_bench_is_of(const ibl_bench *b, const ibl_bench_point *p, int source);

#endif

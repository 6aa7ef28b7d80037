#!/bin/bash
# SPDX-License-Identifier: MIT
# The choice of --scene with other samples: for each map and each of five seeds
# the bytes, the error that is stated, and both beside the mean of the seeds:
# bytes as a ratio, the error in standard errors.
#   bench-choice.sh ERROR MODEL MAP...
set -eu
make -s DEPS=no BUILD="${BUILD:-build}" bridge \
    "${BUILD:-build}/tests/bench_choice"
error=$1 model=$2
shift 2
for map; do
    for seed in 1 2 3 4 5; do
        SEED=$seed "${BUILD:-build}/tests/bench_choice" "$map" --scene "$model" \
            --rendered-error "$error" --dry-run 2>/dev/null |
            awk '/^bytes/ { bytes = $4 }
                /^rendered/ { print bytes, $3, $8 }'
    done | awk -v map="${map##*/}" '
        { bytes[NR] = $1; error[NR] = $2; off[NR] = $3
          mean += log($1); sum += $2 / $3 ^ 2; weight += 1 / $3 ^ 2 }
        END {
            for (i = 1; i <= NR; i++)
                printf "%s %d: %d bytes, %.2f; %.2f %% +- %.2f, %+.1f\n", map,
                       i, bytes[i], bytes[i] / exp(mean / NR), error[i], off[i],
                       (error[i] - sum / weight) / off[i]
        }'
done

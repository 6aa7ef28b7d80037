/* SPDX-License-Identifier: MIT */
/* Repairs values that no radiance or alpha has, as ibl/io.h says. */
#ifndef IBL_IO_REPAIR_H
#define IBL_IO_REPAIR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "io/rows.h"

typedef struct ibl_repair {
    size_t nonfinite; /* pixels that held Inf or NaN */
    size_t negative;  /* pixels that held a finite value below 0 */
    float peak;       /* largest component after */
} ibl_repair;

/* Reads rows and mends their Inf, NaN and negative values: the same for any
 * number of threads and any division into calls. -0 becomes 0 and is not
 * counted. */
typedef struct ibl_mender {
    ibl_rows *rows;
    ibl_repair done;    /* so far */
    uint32_t *most;     /* ibl_max_finite of each row of the map */
    const float *above; /* the last row of the last call, before its repair */
    float *before[2];   /* rows before their repair, in turns */
    int turn;
    float *ahead; /* the next row, where it has been read already */
    bool has_ahead;
} ibl_mender;

/* To be freed in any case; the rows stay the caller's. */
ibl_status ibl_mender_init(ibl_mender *m, ibl_rows *rows);
/* The next count rows, which are there. After an error rgb is unspecified. */
ibl_status ibl_mender_read(ibl_mender *m, int count, float *rgb);
void ibl_mender_free(ibl_mender *m);

/* Mends alpha and applies it to the colours; counts pixels. */
typedef struct ibl_alpha_mender {
    bool straight;         /* colours are not multiplied by alpha yet */
    size_t nonfinite;      /* Inf or NaN */
    size_t beyond;         /* below 0 or above 1, by more than rounding */
    size_t hidden;         /* colours that became 0, of those not straight */
    float lowest, highest; /* finite alpha before its repair */
    float least, most;     /* and after */
} ibl_alpha_mender;

ibl_alpha_mender ibl_alpha_mender_of(bool straight);
/* Of `pixels` values and their colours. */
void ibl_alpha_mend(ibl_alpha_mender *m, float *alpha, float *rgb,
                    size_t pixels);

#endif

/* SPDX-License-Identifier: MIT */
/* What sidecars and keys are made of, checked and with all members. */
#ifndef IBL_IO_SIDECAR_FACTS_H
#define IBL_IO_SIDECAR_FACTS_H

#include <stdbool.h>

#include "ibl/sidecar.h"
#include "json/json_text.h"

typedef struct ibl_sidecar_facts {
    ibl_ctx *ctx;
    ibl_sidecar_options o;
    ibl_read_options read;
    ibl_specular_options specular;
    ibl_irradiance_options irradiance;
    ibl_lut_options lut;
    ibl_lobe_table_options lobe_table;
    ibl_specular_layout layout; /* of textures that were not made yet */
} ibl_sidecar_facts;

/* Takes a program's facts, and checks the numbers by which arrays are read. */
ibl_status ibl_sidecar_take(ibl_ctx *ctx, const ibl_sidecar_options *facts,
                            ibl_sidecar_facts *f);
/* Refuses an output of unknown content. */
ibl_status ibl_sidecar_check_content(ibl_ctx *ctx, const ibl_sidecar_output *o);

/* "fast", "normal" or "best". */
const char *ibl_quality_name(ibl_quality quality);
/* Puts what a file of that content is for. */
void ibl_sidecar_put_content(const ibl_sidecar_facts *f, ibl_content content,
                             json_t **j);
/* The entry of an output with a texture; NULL: no memory. */
json_t *ibl_sidecar_file(const ibl_sidecar_facts *f,
                         const ibl_sidecar_output *o);

#endif

/* SPDX-License-Identifier: MIT */
/* write_lobe_tables >FILE: src/bake/lobe_tables.f16; `make lobe-tables`. */
#include <stdio.h>

#include "bake/lobe_fit.h"
#include "core/half.h"

int main(void)
{
    ibl_ctx *ctx;
    if (ibl_ctx_create(NULL, &ctx))
        return 1;
    for (int size = IBL_LOBE_KNOWN_SIZE, i = 0; i < IBL_LOBE_KNOWN; i++) {
        ibl_lobe_table_options o = ibl_lobe_table_options_default();
        ibl_specular_options s = ibl_specular_options_default();
        float data[IBL_LOBE_KNOWN_BYTES / 2];
        s.size = size << i;
        if (ibl_specular_layout_of(&s, &o.layout) ||
            ibl_lobe_table_fit(ctx, &o, data))
            return 1;
        for (size_t k = 0; k < sizeof data / sizeof *data; k++) {
            const uint16_t half = ibl_half_from_float(data[k]);
            putchar(half & 255);
            putchar(half >> 8);
        }
    }
    ibl_ctx_free(ctx);
    return fflush(stdout) != 0;
}

/* SPDX-License-Identifier: MIT */
/* A picture of panels in rows: maps, unfolded cubes and tables, with labels. */
#ifndef CLI_SHEET_H
#define CLI_SHEET_H

#include <stddef.h>

#include <ibl/ibl.h>

typedef struct ibl_panel {
    const ibl_image *map; /* one of map, cube and lut is set */
    const ibl_cube *cube;
    const ibl_lut *lut; /* N.V to the right, roughness upwards, untouched */
    int level;
    char text[2][32]; /* two lines of label */
} ibl_panel;

/* Draws panels, light times exposure, as a PNG file, which the caller must
 * free. */
void ibl_sheet_png(const ibl_panel *panels, int count, double exposure,
                   void **png, size_t *size);

#endif

/* SPDX-License-Identifier: MIT */
/* A picture of panels in rows: maps, unfolded cubes and tables, with labels. */
#ifndef CLI_SHEET_H
#define CLI_SHEET_H

#include <stdbool.h>
#include <stddef.h>

#include <ibl/ibl.h>

enum {
    IBL_SHEET_GAP = 16,
    IBL_SHEET_DOT = 2, /* pixels along a dot; a letter has 3 by 5 dots */
    IBL_SHEET_GLYPH = 4 * IBL_SHEET_DOT /* pixels from letter to letter */
};

/*
 * An unfolded cube is a cross of 4 by 3 faces, +Y on top, -X +Z +X -Z in the
 * middle row, -Y below, so that neighbours in the cross are neighbours on the
 * cube. These are the column and row of each face.
 */
extern const int ibl_cross_place[IBL_FACES][2];

typedef struct ibl_panel {
    const ibl_image *map; /* one of map, cube and lut is set */
    const ibl_cube *cube;
    const ibl_lut *lut; /* N.V to the right, roughness upwards, untouched */
    int level;
    char text[2][32]; /* two lines of label */
} ibl_panel;

typedef struct ibl_sheet {
    /* sRGB, 0 to 1 and limited to that, of a component of a map or cube. */
    double (*tone)(double value, int channel);
    double exposure;       /* factor before tone; 0: 1 */
    bool cells;            /* texels stay squares */
    int footer;            /* rows of pixels below the panels */
    int width, height;     /* of the picture, from here on ibl_sheet_draw's */
    unsigned char *pixels; /* sRGB, 3 bytes each */
} ibl_sheet;

/* Draws panels. False: no memory. ibl_sheet_encode is needed also then. */
bool ibl_sheet_draw(ibl_sheet *sheet, const ibl_panel *panels, int count);

/* Sets a pixel to exposed and toned values. */
void ibl_sheet_put(const ibl_sheet *sheet, int x, int y, const double rgb[3]);

/* Writes text in capitals, with its upper left corner at left, top. Characters
 * without a glyph stay blank. */
void ibl_sheet_write(const ibl_sheet *sheet, int left, int top,
                     const char *text);

/* Frees the pixels. The PNG file is the caller's to free. False: no memory. */
bool ibl_sheet_encode(ibl_sheet *sheet, void **png, size_t *size);

#endif

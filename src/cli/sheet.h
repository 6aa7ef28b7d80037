/* SPDX-License-Identifier: MIT */
/* An image of panels in rows; each panel holds an unfolded cube. */
#ifndef CLI_SHEET_H
#define CLI_SHEET_H

#include <stdbool.h>
#include <stddef.h>

#include "cli/faces.h"

enum {
    IBL_SHEET_FACE = 96, /* pixels along a face's edge in an unfolded cube */
    IBL_PANEL_WIDTH = IBL_CROSS_COLUMNS * IBL_SHEET_FACE,
    IBL_PANEL_HEIGHT = IBL_CROSS_ROWS * IBL_SHEET_FACE,
    IBL_SHEET_GAP = 16,
    IBL_SHEET_DOT = 2, /* pixels along a dot; a letter has 3 by 5 dots */
    IBL_SHEET_GLYPH = 4 * IBL_SHEET_DOT, /* pixels from letter to letter */
    IBL_SHEET_LINE = 8 * IBL_SHEET_DOT
};

typedef struct ibl_sheet {
    int width, height;
    int columns;           /* panels per row */
    unsigned char *pixels; /* sRGB, 3 bytes each */
} ibl_sheet;

/* Makes a grey sheet with room for panels, and `footer` rows of pixels below
 * them. False: no memory. */
bool ibl_sheet_create(ibl_sheet *sheet, int panels, int footer);
void ibl_sheet_free(ibl_sheet *sheet);

/* Finds the upper left corner of a panel; returns the first byte of a pixel. */
void ibl_sheet_place(const ibl_sheet *sheet, int panel, int *left, int *top);
unsigned char *ibl_sheet_pixel(const ibl_sheet *sheet, int x, int y);

/* Writes text in capitals, with its upper left corner at left, top. Characters
 * without a glyph stay blank. */
void ibl_sheet_write(const ibl_sheet *sheet, int left, int top,
                     const char *text);

#endif

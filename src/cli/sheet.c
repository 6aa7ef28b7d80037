/* SPDX-License-Identifier: MIT */
#include "cli/sheet.h"

#include <png.h>
#include <stdlib.h>
#include <string.h>

enum {
    BACKGROUND = 24 /* grey, as the file stores it */
};

bool ibl_sheet_create(ibl_sheet *sheet, int panels, int footer)
{
    const int most = panels > 9 ? 4 : 3;
    const int columns = panels < most ? panels : most;
    const int rows = (panels + columns - 1) / columns;

    *sheet = (ibl_sheet){
        .width = IBL_SHEET_GAP + columns * (IBL_PANEL_WIDTH + IBL_SHEET_GAP),
        .height =
            IBL_SHEET_GAP + rows * (IBL_PANEL_HEIGHT + IBL_SHEET_GAP) + footer,
        .columns = columns};
    const size_t bytes = 3 * (size_t)sheet->width * (size_t)sheet->height;
    sheet->pixels = malloc(bytes);
    if (!sheet->pixels)
        return false;
    memset(sheet->pixels, BACKGROUND, bytes);
    return true;
}

void ibl_sheet_free(ibl_sheet *sheet)
{
    free(sheet->pixels);
    sheet->pixels = NULL;
}

void ibl_sheet_place(const ibl_sheet *sheet, int panel, int *left, int *top)
{
    *left = IBL_SHEET_GAP +
            panel % sheet->columns * (IBL_PANEL_WIDTH + IBL_SHEET_GAP);
    *top = IBL_SHEET_GAP +
           panel / sheet->columns * (IBL_PANEL_HEIGHT + IBL_SHEET_GAP);
}

unsigned char *ibl_sheet_pixel(const ibl_sheet *sheet, int x, int y)
{
    return sheet->pixels + 3 * ((size_t)y * (size_t)sheet->width + (size_t)x);
}

bool ibl_sheet_png(const ibl_sheet *sheet, void **png, size_t *size)
{
    png_image image = {.version = PNG_IMAGE_VERSION,
                       .width = (png_uint_32)sheet->width,
                       .height = (png_uint_32)sheet->height,
                       .format = PNG_FORMAT_RGB};
    png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(image);

    *png = malloc(bytes);
    if (!*png)
        return false;
    if (!png_image_write_to_memory(&image, *png, &bytes, 0, sheet->pixels, 0,
                                   NULL)) {
        free(*png);
        return false;
    }
    *size = bytes;
    return true;
}

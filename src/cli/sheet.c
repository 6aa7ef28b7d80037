/* SPDX-License-Identifier: MIT */
#include "cli/sheet.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

enum {
    BACKGROUND = 24 /* sRGB value of the grey */
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

/* Glyphs of 3 by 5 dots: one octal digit per row, from the top. */
static const struct {
    char character;
    unsigned rows;
} font[] = {{'0', 075557}, {'1', 026227}, {'2', 071747}, {'3', 071717},
            {'4', 055711}, {'5', 074717}, {'6', 074757}, {'7', 071111},
            {'8', 075757}, {'9', 075717}, {'.', 000002}, {'-', 000700},
            {'=', 007070}, {'A', 025755}, {'B', 065656}, {'C', 034443},
            {'D', 065556}, {'E', 074647}, {'F', 074644}, {'G', 034553},
            {'H', 055755}, {'I', 072227}, {'K', 055655}, {'L', 044447},
            {'M', 057755}, {'N', 065555}, {'O', 025552}, {'P', 065644},
            {'R', 065655}, {'S', 034216}, {'T', 072222}, {'U', 055557},
            {'V', 055552}, {'W', 055775}, {'X', 055255}, {'Y', 055222}};

static unsigned rows_of(char character)
{
    for (size_t i = 0; i < sizeof font / sizeof *font; i++)
        if (font[i].character == toupper((unsigned char)character))
            return font[i].rows;
    return 0;
}

void ibl_sheet_write(const ibl_sheet *s, int left, int top, const char *text)
{
    for (; *text; text++, left += IBL_SHEET_GLYPH) {
        const unsigned rows = rows_of(*text);
        for (int y = 0; y < 5 * IBL_SHEET_DOT; y++) {
            for (int x = 0; x < 3 * IBL_SHEET_DOT; x++) {
                const int dot = 3 * (y / IBL_SHEET_DOT) + x / IBL_SHEET_DOT;
                if (rows >> (14 - dot) & 1 && left + x < s->width)
                    memset(ibl_sheet_pixel(s, left + x, top + y), 200, 3);
            }
        }
    }
}

/* SPDX-License-Identifier: MIT */
#include "kern/astc_ways.h"

#include "kern/astc_hdr_block.h"
#include "kern/bc6h_modes.h"

const ibl_astc_way ibl_astc_ways[IBL_ASTC_WAYS] = {
    {1, IBL_ASTC_DIRECT, IBL_ISE_16, IBL_ISE_192},
    {1, IBL_ASTC_DIRECT, IBL_ISE_12, IBL_ISE_256},
    {2, IBL_ASTC_SCALE, IBL_ISE_8, IBL_ISE_80},
    {2, IBL_ASTC_SCALE, IBL_ISE_6, IBL_ISE_128},
    {2, IBL_ASTC_SCALE, IBL_ISE_5, IBL_ISE_192}};

const unsigned short ibl_astc_patterns[IBL_ASTC_PATTERNS] = {
    28, 20, 16,  29,  91, 9,   107, 72,  149, 204, 50,  114, 496, 17,
    78, 39, 252, 828, 43, 156, 116, 210, 476, 273, 684, 359, 246};

static void set_levels(int range, ibl_astc_levels *l)
{
    l->count = ibl_ise_levels(range);
    for (int i = 0; i < l->count; i++) {
        const int step = ibl_ise_weight(range, i);
        int k = i;
        for (; k > 0 && l->step[k - 1] > step; k--) {
            l->step[k] = l->step[k - 1];
            l->code[k] = l->code[k - 1];
        }
        l->step[k] = (unsigned char)step;
        l->code[k] = (unsigned char)i;
    }
}

static void set_patterns(ibl_astc_tables *t)
{
    for (int p = 0; p < IBL_ASTC_PATTERNS_PADDED; p++) {
        const int pattern = ibl_astc_patterns[p < IBL_ASTC_PATTERNS ? p : 0];
        unsigned char of[IBL_BLOCK_TEXELS];
        ibl_astc_find_subsets(pattern, of);
        t->count[p] = 0;
        for (int i = 0; i < 16; i++) {
            t->second[i][p] = of[i];
            t->count[p] += of[i];
        }
    }
}

static void set_regions(ibl_astc_tables *t)
{
    for (int p = 0; p < IBL_ASTC_PATTERNS; p++) {
        unsigned bits = 0;
        for (int i = 0; i < 16; i++)
            bits |= (unsigned)t->second[i][p] << i;
        for (int k = 0; k < IBL_BC6H_PARTITIONS; k++) {
            const unsigned b = ibl_bc6h_partitions[k];
            if (b != bits && b != (bits ^ 0xFFFF))
                continue;
            t->region[p] = (unsigned char)k;
            t->inverse[p] = b != bits;
        }
    }
}

void ibl_astc_set_tables(const ibl_astc_fit_dsp *fit, ibl_astc_tables *t)
{
    *t = (ibl_astc_tables){.fit = fit};
    for (int i = 0; i < IBL_ASTC_WAYS; i++) {
        const ibl_astc_way *w = &ibl_astc_ways[i];
        set_levels(w->weight_range, &t->levels[w->weight_range]);
        ibl_astc_set_codes(w->value_range, &t->codes[w->value_range]);
    }
    set_patterns(t);
    set_regions(t);
}

/* ---- as BC6H ----------------------------------------------------------- */

/* The indices for levels of weights, by their count: of 4 bits and of 3. */
static const unsigned char fours[17][16] = {
    [12] = {0, 1, 2, 4, 5, 6, 9, 10, 11, 13, 14, 15},
    [16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15}};
static const unsigned char threes[9][8] = {[4] = {0, 2, 5, 7},
                                           [5] = {0, 2, 4, 5, 7},
                                           [6] = {0, 1, 3, 4, 6, 7},
                                           [8] = {0, 1, 2, 3, 4, 5, 6, 7}};

/* Of the 16 bits that BC6H interpolates; 64/31 of a half. */
static int quantised(int half, int bits)
{
    return (half * 64 + 30) / (31 << (16 - bits));
}

/* Whether a mode has the ends, halves, those of the first region first. */
static int mode_has(const ibl_bc6h_mode *m, int halves[4][3])
{
    for (int c = 0; c < 3 && m->deltas; c++) {
        const int most = 1 << (m->other_bits[c] - 1);
        const int base = quantised(halves[0][c], m->bits);
        for (int i = 1; i < 2 * m->regions; i++) {
            const int d = quantised(halves[i][c], m->bits) - base;
            if (d < -most || d >= most)
                return 0;
        }
    }
    return 1;
}

/* The first region is that of texel 0. A region's ends are turned if its
 * anchor's index would have its highest bit set. */
static void put_region(const unsigned char *index, int top, int anchor,
                       const ibl_astc_line *l, int ends[2][3], int halves[][3])
{
    const int turned = (index[l->level[anchor]] & top) != 0;
    for (int i = 0; i < 6; i++)
        halves[(i / 3) ^ turned][i % 3] = ends[i / 3][i % 3];
}

float ibl_astc_error_as_bc6h(const ibl_astc_tables *tb, const ibl_astc_way *w,
                             int pattern, const ibl_astc_texels t[],
                             const ibl_astc_line l[])
{
    const int two = w->subsets == 2;
    const int count = tb->levels[w->weight_range].count;
    const unsigned char *index = two ? threes[count] : fours[count];
    const ibl_bc6h_mode *m = &ibl_bc6h_modes[two ? 0 : IBL_BC6H_ONE_REGION];
    const int second_anchor = ibl_bc6h_anchors[tb->region[pattern]];
    int ends[2][2][3], halves[4][3], steps[IBL_BLOCK_TEXELS];
    float sum = 0;

    for (int s = 0; s < w->subsets; s++) {
        ibl_astc_line_ends(w->mode, l[s].values, ends[s]);
        for (int i = 0; i < 6; i++)
            ends[s][i / 3][i % 3] = ibl_astc_half(ends[s][i / 3][i % 3] << 4);
    }
    for (int r = 0; r <= two; r++) {
        const int s = r ^ (two && tb->inverse[pattern]);
        put_region(index, two ? 4 : 8, r ? second_anchor : 0, &l[s], ends[s],
                   halves + 2 * r);
    }
    while (!mode_has(m, halves))
        m++;
    for (int s = 0; s < w->subsets; s++) {
        for (int i = 0; i < 6; i++) {
            int *end = &ends[s][i / 3][i % 3];
            *end = ibl_bc6h_unquantise(quantised(*end, m->bits), m->bits);
        }
        for (int i = 0; i < IBL_BLOCK_TEXELS; i++)
            steps[i] = ibl_bc6h_weights[!two][index[l[s].level[i]]];
        sum += tb->fit->error_bc6h(&t[s], ends[s], steps);
    }
    return sum;
}

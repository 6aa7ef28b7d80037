/* SPDX-License-Identifier: MIT */
#include "kern/astc_hdr_endpoints.h"

/* Fields of IBL_ASTC_SCALE: red, green, blue, scale; of IBL_ASTC_DIRECT a, c,
 * b0, b1, d0, d1, in the order of the values that hold their lower bits. */
#define AT(field, bit) ((field) << 4 | (bit))
#define R(bit) AT(0, bit)
#define G(bit) AT(1, bit)
#define B(bit) AT(2, bit)
#define S(bit) AT(3, bit)
const ibl_astc_form ibl_astc_scale_forms[IBL_ASTC_SCALE_FORMS] = {
    {1, {11, 5, 5, 7}, {R(9), R(8), R(7), R(10), R(6), S(6), S(5)}},
    {1, {11, 6, 6, 5}, {R(8), G(5), R(7), B(5), R(6), R(10), R(9)}},
    {2, {10, 5, 5, 8}, {R(9), R(8), R(7), R(6), S(7), S(6), S(5)}},
    {3, {9, 6, 6, 7}, {R(8), G(5), R(7), B(5), R(6), S(6), S(5)}},
    {4, {8, 7, 7, 6}, {G(6), G(5), B(6), B(5), R(6), R(7), S(5)}},
    {5, {7, 7, 7, 7}, {G(6), G(5), B(6), B(5), R(6), S(6), S(5)}}};

#define A(bit) AT(0, bit)
#define C(bit) AT(1, bit)
#define B0(bit) AT(2, bit)
#define B1(bit) AT(3, bit)
#define D0(bit) AT(4, bit)
#define D1(bit) AT(5, bit)
const ibl_astc_form ibl_astc_direct_forms[IBL_ASTC_DIRECT_FORMS - 1] = {
    {3, {9, 6, 7, 7, 7, 7}, {B0(6), B1(6), D0(6), D1(6), D0(5), D1(5), A(8)}},
    {3, {9, 6, 8, 8, 6, 6}, {B0(6), B1(6), B0(7), B1(7), D0(5), D1(5), A(8)}},
    {2, {10, 7, 6, 6, 7, 7}, {A(9), C(6), D0(6), D1(6), D0(5), D1(5), A(8)}},
    {2, {10, 7, 7, 7, 6, 6}, {B0(6), B1(6), A(9), C(6), D0(5), D1(5), A(8)}},
    {1, {11, 6, 8, 8, 5, 5}, {B0(6), B1(6), B0(7), B1(7), A(9), A(10), A(8)}},
    {1, {11, 8, 6, 6, 6, 6}, {A(9), A(10), C(7), C(6), D0(5), D1(5), A(8)}},
    {0, {12, 7, 7, 7, 5, 5}, {B0(6), B1(6), A(11), C(6), A(9), A(10), A(8)}},
    {0, {12, 7, 6, 6, 6, 6}, {A(9), A(10), A(11), C(6), D0(5), D1(5), A(8)}}};

/* Where the places are: a value, and a bit of it. */
const unsigned char ibl_astc_scale_places[IBL_ASTC_PLACES] = {
    AT(1, 6), AT(1, 5), AT(2, 6), AT(2, 5), AT(3, 7), AT(3, 6), AT(3, 5)};
const unsigned char ibl_astc_direct_places[IBL_ASTC_PLACES] = {
    AT(2, 6), AT(3, 6), AT(4, 6), AT(5, 6), AT(4, 5), AT(5, 5), AT(1, 6)};

static int bit_of(const unsigned char *values, int code)
{
    return values[code >> 4] >> (code & 15) & 1;
}

static void gather(const ibl_astc_form *form, const unsigned char *places,
                   const unsigned char *values, int *fields)
{
    for (int i = 0; i < IBL_ASTC_PLACES; i++) {
        const int to = form->codes[i];
        fields[to >> 4] |= bit_of(values, places[i]) << (to & 15);
    }
}

static void swap(int v[3], int major)
{
    const int first = v[0];
    v[0] = v[major];
    v[major] = first;
}

static int clamped(int v)
{
    return v < 0 ? 0 : v > 4095 ? 4095 : v;
}

static void scale_ends(const unsigned char v[4], int e[2][3])
{
    const int bits = v[0] >> 6 | v[1] >> 7 << 2 | v[2] >> 7 << 3;
    const int last = bits >> 2 == 3;
    const int form = !last ? bits & 3 : bits == 15 ? 5 : 4;
    const int major = !last ? bits >> 2 : bits == 15 ? 0 : bits & 3;
    const int drop = ibl_astc_scale_forms[form].drop;
    int fields[4] = {v[0] & 63, v[1] & 31, v[2] & 31, v[3] & 31};

    gather(&ibl_astc_scale_forms[form], ibl_astc_scale_places, v, fields);
    for (int c = 0; c < 3; c++) {
        const int lower = c && form < 5 ? fields[0] - fields[c] : fields[c];
        e[1][c] = clamped(lower * (1 << drop));
        e[0][c] = clamped((lower - fields[3]) * (1 << drop));
    }
    swap(e[0], major);
    swap(e[1], major);
}

static int extended(int value, int bits)
{
    const int sign = 1 << (bits - 1);
    return ((value & (2 * sign - 1)) ^ sign) - sign;
}

static void direct_ends(const unsigned char v[6], int e[2][3])
{
    const int form = v[1] >> 7 | v[2] >> 7 << 1 | v[3] >> 7 << 2;
    const int major = v[4] >> 7 | v[5] >> 7 << 1;
    const ibl_astc_form *f = &ibl_astc_direct_forms[form];
    int x[6] = {v[0], v[1] & 63, v[2] & 63, v[3] & 63, v[4] & 31, v[5] & 31};

    if (major == 3) {
        for (int i = 0; i < 4; i++)
            e[i & 1][i / 2] = v[i] << 4;
        for (int i = 0; i < 2; i++)
            e[i][2] = (v[4 + i] & 127) << 5;
        return;
    }
    gather(f, ibl_astc_direct_places, v, x);
    for (int c = 0; c < 3; c++) {
        const int high = c ? x[0] - x[1 + c] : x[0];
        const int d = c ? extended(x[3 + c], f->bits[3 + c]) : 0;
        e[1][c] = clamped(high * (1 << f->drop));
        e[0][c] = clamped((high - x[1] - d) * (1 << f->drop));
    }
    swap(e[0], major);
    swap(e[1], major);
}

void ibl_astc_line_ends(int mode, const unsigned char *values, int e[2][3])
{
    if (mode == IBL_ASTC_SCALE)
        scale_ends(values, e);
    else
        direct_ends(values, e);
}

/* SPDX-License-Identifier: MIT */
/*
 * Which faces of a cube an image holds, and whether they meet.
 *
 * Neighbours on a cube are nearly equal along their border, so the steps across
 * all borders, over those inside the faces, tell whether each face is where it
 * belongs. A search places one face after the other, the smallest steps first,
 * and turns back where the steps exceed those of the best cube so far. All 24
 * turns of a cube fit as well as each other: of these the one that changes
 * least is named.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/layout.h"

enum {
    TURNS = 8,                 /* 4 * mirrored + quarters clockwise */
    CODES = TURNS * IBL_FACES, /* face + IBL_FACES * turn */
    TRIED = CODES / 2,         /* no file mirrors some of its faces */
    EDGE = 64,                 /* samples along a border, at most */
    LEAST_EDGE = 8,            /* smaller faces are not judged */
    MOST_STEPS = 1 << 17       /* of a search */
};

/* Ratios of steps. Those of six photographs as cubes of 8 to 512 texels, turned
 * to many sides: where the search changed anything in right ones, it gained a
 * factor of at most 1.2; in wrong ones from 1.5 on, and what it found was up to
 * 2.7. Walls in plain colours that meet at the borders have more. */
#define SUSPICIOUS .7
#define FITS 1.5
#define CONTINUOUS 3

static const char *const names[] = {"px", "nx", "py", "ny", "pz", "nz"};
static const char *const turns[] = {"",   "/90",  "/180",  "/270",
                                    "/m", "/m90", "/m180", "/m270"};

/* ---- the list ----------------------------------------------------------- */

int ibl_face_order_parse(const char *text, unsigned char order[IBL_FACES])
{
    unsigned found = 0;

    for (int i = 0; i < IBL_FACES; i++) {
        const size_t length = strcspn(text, ",");
        int code = 0;
        for (char item[16]; code < CODES; code++) {
            sprintf(item, "%s%s", names[code % IBL_FACES],
                    turns[code / IBL_FACES]);
            if (strlen(item) == length && !strncasecmp(item, text, length))
                break;
        }
        if (code == CODES)
            return 0;
        order[i] = (unsigned char)code;
        found |= 1u << code % IBL_FACES;
        text += length + (text[length] == ',' && i + 1 < IBL_FACES);
    }
    return !*text && found == (1u << IBL_FACES) - 1;
}

void ibl_face_order_text(const unsigned char order[IBL_FACES],
                         char text[IBL_FACE_ORDER])
{
    for (int i = 0; i < IBL_FACES; i++)
        text +=
            sprintf(text, "%s%s%s", i ? "," : "", names[order[i] % IBL_FACES],
                    turns[order[i] / IBL_FACES]);
}

void ibl_face_put(const float *from, size_t row, int code, ibl_cube *cube)
{
    const int n = cube->size, turn = code / IBL_FACES;
    float *to = ibl_cube_face(cube, 0, code % IBL_FACES);

    for (int y = 0; y < n; y++)
        for (int x = 0; x < n; x++, to += 3) {
            /* back by quarters: what is at the top came from the left */
            int at[2] = {x, y};
            for (int t = 0; t < turn % 4; t++) {
                const int up = at[1];
                at[1] = n - 1 - at[0];
                at[0] = up;
            }
            const int column = turn / 4 ? n - 1 - at[0] : at[0];
            memcpy(to, from + row * (size_t)at[1] + 3 * (size_t)column,
                   3 * sizeof *to);
        }
}

/* ---- steps -------------------------------------------------------------- */

/* The face beyond the top, right, bottom and left edge of each. */
static const signed char beyond[IBL_FACES][4] = {{2, 5, 3, 4}, {2, 4, 3, 5},
                                                 {5, 0, 4, 1}, {4, 0, 5, 1},
                                                 {2, 0, 3, 1}, {2, 1, 3, 0}};

/* The logarithms of the luminance of a cube's faces, at n x n places. */
typedef struct faces {
    int n;
    /* The mean step between edge e of face f and edge d of face g, indexed
     * [4 f + e][4 g + d], both clockwise. */
    float step[4 * IBL_FACES][4 * IBL_FACES];
    double inside; /* the mean step between neighbours in a face */
    float at[];
} faces;

/* Takes means over the texels of each place. Logarithms are of what is above a
 * share of a mean in which suns count little: noise in the dark is nothing. */
static void look(const ibl_cube *cube, faces *f)
{
    const size_t n = (size_t)f->n, size = (size_t)cube->size;
    const size_t count = IBL_FACES * n * n;
    double roots = 0;

    for (size_t i = 0; i < count; i++) {
        const size_t y = i / n % n, x = i % n;
        const size_t y0 = y * size / n, y1 = (y + 1) * size / n;
        const size_t x0 = x * size / n, x1 = (x + 1) * size / n;
        double light = 0;
        for (size_t v = y0; v < y1; v++)
            for (size_t u = x0; u < x1; u++) {
                const float *p =
                    cube->data + 3 * ((i / (n * n) * size + v) * size + u);
                light += (double)(p[0] + 2 * p[1] + p[2]);
            }
        light = fmax(light, 0) / (double)(4 * (y1 - y0) * (x1 - x0));
        f->at[i] = (float)light;
        roots += sqrt(light) / (double)count;
    }
    for (size_t i = 0; i < count; i++)
        f->at[i] = (float)log((double)f->at[i] + .05 * roots * roots + 1e-30);
}

/* Sample i of an edge, clockwise. */
static float edge_at(const faces *f, int edge, int i)
{
    const int n = f->n, last = n - 1;
    const int x[] = {i, last, last - i, 0}, y[] = {0, i, last, last - i};
    return f->at[(edge / 4 * n + y[edge % 4]) * n + x[edge % 4]];
}

static void measure(faces *f)
{
    const int n = f->n, edges = 4 * IBL_FACES;
    double sum = 0;

    for (int i = 0; i < IBL_FACES * n * n; i++) {
        const float *p = &f->at[i];
        sum += i % n ? fabs((double)(p[0] - p[-1])) : 0;
        sum += i / n % n ? fabs((double)(p[0] - p[-n])) : 0;
    }
    f->inside = sum / (2 * IBL_FACES * n * (n - 1));
    for (int i = 0; i < edges * edges; i++) {
        double across = 0;
        for (int k = 0; k < n; k++)
            across += fabs((double)(edge_at(f, i / edges, k) -
                                    edge_at(f, i % edges, n - 1 - k)));
        f->step[i / edges][i % edges] = (float)(across / n);
    }
}

/* ---- the search --------------------------------------------------------- */

typedef struct search {
    const faces *f;
    unsigned char in[IBL_FACES], best[IBL_FACES]; /* code of the face there */
    double least;                                 /* the cost of the best */
    int steps;
} search;

/* The edge of the face in a place that lies at the place's edge. */
static int edge_in(int code, int edge)
{
    return 4 * (code % IBL_FACES) + (edge - code / IBL_FACES + 4) % 4;
}

/* The steps across the borders that a face in a place shares with the places
 * that are taken. */
static double steps_of(const search *s, const unsigned char *order, int place,
                       unsigned taken, int code)
{
    double sum = 0;

    for (int e = 0; e < 4; e++) {
        const int other = beyond[place][e];
        int d = 0;
        if (!(taken >> other & 1))
            continue;
        while (beyond[other][d] != place)
            d++;
        sum += (double)s->f->step[edge_in(code, e)][edge_in(order[other], d)];
    }
    return sum;
}

/* Finds faces for the places from the i-th on; used: the faces taken. */
static void place_from(search *s, int i, unsigned taken, unsigned used,
                       double cost)
{
    static const int places[] = {0, 2, 4, 1, 3, 5}; /* neighbours first */
    double costs[TRIED];

    if (i == IBL_FACES) {
        s->least = cost;
        memcpy(s->best, s->in, sizeof s->best);
        return;
    }
    const int place = places[i];
    for (int c = 0; c < TRIED; c++) { /* a little for each change */
        const int change = 2 * (c % IBL_FACES != place) + 3 * (c >= IBL_FACES);
        costs[c] = used >> c % IBL_FACES & 1
                       ? INFINITY
                       : cost + steps_of(s, s->in, place, taken, c) +
                             s->f->inside * .01 * change;
    }
    for (;;) {
        int c = 0;
        for (int k = 1; k < TRIED; k++)
            c = costs[k] < costs[c] ? k : c;
        if (!(costs[c] < s->least) || s->steps++ > MOST_STEPS)
            return;
        s->in[place] = (unsigned char)c;
        place_from(s, i + 1, taken | 1u << place, used | 1u << c % IBL_FACES,
                   costs[c]);
        costs[c] = INFINITY;
    }
}

/* The mean step across the borders of the places that the search changed, over
 * that inside all faces. */
static double ratio_of(const search *s, const unsigned char *order)
{
    double sum = 0;
    int count = 0;

    for (int p = 0; p < IBL_FACES; p++)
        for (int e = 0; e < 4; e++) {
            const int other = beyond[p][e];
            if (s->best[p] == p && s->best[other] == other)
                continue;
            sum += steps_of(s, order, p, 1u << other, order[p]);
            count++;
        }
    return sum / (count * s->f->inside);
}

static void judge(ibl_ctx *ctx, const char *name, const faces *f,
                  const unsigned char order[IBL_FACES])
{
    static const unsigned char as_it_is[] = {0, 1, 2, 3, 4, 5};
    search s = {.f = f, .least = INFINITY};
    unsigned char mended[IBL_FACES];
    char text[IBL_FACE_ORDER];

    place_from(&s, 0, 0, 0, 0);
    const double now = ratio_of(&s, as_it_is), then = ratio_of(&s, s.best);
    if (!(now > SUSPICIOUS && now > FITS * then && then < CONTINUOUS))
        return; /* or none of them is a number */
    for (int i = 0; i < IBL_FACES; i++)
        for (int p = 0; p < IBL_FACES; p++)
            if (s.best[p] % IBL_FACES == order[i] % IBL_FACES) {
                const int turn = order[i] / IBL_FACES;
                const int quarters = turn + s.best[p] / IBL_FACES;
                mended[i] =
                    (unsigned char)(IBL_FACES * ((turn & 4) + quarters % 4) +
                                    p);
            }
    ibl_face_order_text(mended, text);
    ibl_warn(ctx,
             "%s: its faces do not meet: the steps across their borders are "
             "%.2g times those inside, but %.2g times in the order "
             "--face-order=%s",
             name, now, then, text);
}

ibl_status ibl_faces_check(ibl_ctx *ctx, const char *name, const ibl_cube *cube,
                           const unsigned char order[IBL_FACES])
{
    const int n = cube->size < EDGE ? cube->size : EDGE;
    const size_t count = IBL_FACES * (size_t)n * (size_t)n;

    if (n < LEAST_EDGE)
        return IBL_OK;
    faces *f = ibl_alloc_zeroed(1, sizeof *f + count * sizeof(float));
    if (!f)
        return ibl_no_memory(ctx, "the faces of a cube");
    f->n = n;
    look(cube, f);
    measure(f);
    judge(ctx, name, f, order);
    ibl_free(f);
    return IBL_OK;
}

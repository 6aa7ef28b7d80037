/* SPDX-License-Identifier: MIT */
/*
 * Level 0: the average of an equirectangular map over each texel of a cube.
 *
 * In the chart (phi, c = cos theta) solid angle is plain area, a source pixel
 * is a rectangle, and a texel is a region bounded by four curves. With
 *     G(phi, c) = integral of L from c up to the pole, along phi,
 * Green's theorem turns the integral of L over the texel into one along its
 * outline, the loop integral of G dphi. G is a prefix sum down a column of
 * the source, linear in c within a row, and dphi is 0 on meridians. So only
 * horizontal straight lines of the cube matter: the rows of the four side
 * faces, and the rows and columns of the top and the bottom. Each line is
 * walked once, cut at texel corners and at columns and rows of the source,
 * and serves the texels on both sides: what one loses the other gains, and
 * the energy is kept whatever the sizes. Between two cuts, at most a source
 * column apart, the line is taken as straight in the chart but for its bow.
 *
 * Dividing by the same loop integral for L = 1 gives the average, and makes a
 * constant map constant to rounding.
 *
 * A source whose pixels are larger than the texels is interpolated
 * bilinearly to a finer grid on the way into the prefix sums, with weights
 * between rows that leave every pixel the solid angle it has (bend_rows).
 */
#include <assert.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "image/cube.h"
#include "image/level0.h"

#define PI 3.14159265358979323846

enum {
    RGB1 = 4,            /* channels of a sum: R, G, B and L = 1 */
    MIN_COLUMNS = 512,   /* keeps the straight pieces short */
    TILE_SUMS = 1 << 17, /* prefix sums held at once: 4 MiB */
    LINES_PER_JOB = 8,
    COLUMNS_PER_JOB = 64
};

typedef struct sum4 {
    double v[RGB1];
} sum4;

/* The source on its fine grid: scale_x * width columns by scale_y * height
 * rows, and the exact cosines of the row boundaries. */
struct source {
    const ibl_image *env;
    int scale_x, scale_y;
    bool bilinear; /* else every fine pixel has its source pixel's value */
    int columns, rows;
    double *bend;     /* height + 1, if bilinear; see bend_rows */
    double yaw;       /* radians, 0..2 pi */
    double *cosine;   /* rows + 1 */
    double *per_row;  /* rows: 1 / (cosine[j] - cosine[j + 1]) */
    double *cos_edge; /* columns + 1: of the column boundaries' phi */
    double *sin_edge;
};

/* Prefix sums of columns first .. first + columns - 1 (modulo the source's)
 * and of rows top .. bottom - 1; bottom_up counts rows from the south pole. */
struct tile {
    int first, columns;
    int top, bottom;
    bool bottom_up;
    sum4 *prefix; /* (bottom - top + 1) rows of columns sums */
};

/* A horizontal line of the cube: at height y, at distance a > 0 from the
 * vertical axis, its foot in the horizontal direction (foot_x, foot_z), one
 * of the four axes. A point t along it, -1..1 towards growing phi, has
 * phi = phi(foot) + atan(t / a). */
struct line {
    double y, a;
    int foot_x, foot_z;
    const double *corner; /* columns coordinate of its n + 1 texel corners */
    sum4 *edge;           /* n integrals of G dphi, in walking order */
};

/* One face at work. */
struct face_job {
    const struct source *src;
    struct tile tile;
    const ibl_face_axes *axes;
    int n;
    sum4 *edges;     /* n integrals for each line: a side's n + 1 rows; a
                        pole's n + 1 lines of constant z, then n + 1 of x */
    double *corners; /* n + 1 for each worker */
    float *texels;   /* of the face */
};

/* ---- the source ------------------------------------------------------- */

/* phi to the columns coordinate: whole numbers are column boundaries. */
static double column_of(const struct source *s, double phi)
{
    return ((phi + s->yaw) / (2 * PI) + 0.5) * s->columns;
}

static int wrap(int i, int n)
{
    i %= n;
    return i < 0 ? i + n : i;
}

static int ceil_div(int a, int b)
{
    return (a + b - 1) / b;
}

static void source_free(struct source *s)
{
    ibl_free(s->cosine);
    ibl_free(s->per_row);
    ibl_free(s->cos_edge);
    ibl_free(s->sin_edge);
    ibl_free(s->bend);
}

/* How far down between the centres of two rows a fine row is, 0..1; *above:
 * the upper one, -1 beyond the zenith. */
static double between_rows(const struct source *s, int row, int *above)
{
    const double y = (row + 0.5) / s->scale_y - 0.5;
    *above = (int)floor(y);
    return y - *above;
}

/*
 * Rows differ in solid angle, so a linear weight t of the lower row would give
 * pixels more or less light than they have: a sun next to a pole 8 % more.
 * With t + bend t (1 - t) every row has, between each two centres, the solid
 * angle that is its own up to the border. bend is at most 1/4, at the poles,
 * and the weights stay in 0..1 and sum to 1. Beyond a pole is the same row.
 */
static void bend_rows(const struct source *s)
{
    double missing = 0, room = 0;
    int pair = -1;
    for (int row = 0; row < s->rows; row++) {
        int above;
        const double t = between_rows(s, row, &above);
        const double dc = s->cosine[row] - s->cosine[row + 1];
        if (above != pair)
            missing = room = 0;
        pair = above;
        missing += ((t > 0.5) - t) * dc;
        room += t * (1 - t) * dc;
        if (pair >= 0 && pair < s->env->height - 1 && room > 0)
            s->bend[pair + 1] = missing / room;
    }
}

/* A texel at the middle of a face is 2/n wide, its quarter turn n texels. */
static ibl_status source_init(ibl_ctx *ctx, const ibl_image *env,
                              double yaw_deg, int n, struct source *s)
{
    *s = (struct source){.env = env};
    s->yaw = (yaw_deg - 360 * floor(yaw_deg / 360)) * (PI / 180);
    s->bilinear = env->width < 4 * n || env->height < 2 * n;
    const int columns = 4 * n > MIN_COLUMNS ? 4 * n : MIN_COLUMNS;
    s->scale_x = env->width < columns ? ceil_div(columns, env->width) : 1;
    s->scale_y = env->height < 2 * n ? ceil_div(2 * n, env->height) : 1;
    /* Even, for beyond the poles: half a turn is whole columns. */
    if (s->bilinear && env->width % 2 && s->scale_x % 2)
        s->scale_x++;
    s->columns = env->width * s->scale_x;
    s->rows = env->height * s->scale_y;

    s->cosine = ibl_alloc_array((size_t)s->rows + 1, sizeof *s->cosine);
    s->per_row = ibl_alloc_array((size_t)s->rows, sizeof *s->per_row);
    s->cos_edge = ibl_alloc_array((size_t)s->columns + 1, sizeof(double));
    s->sin_edge = ibl_alloc_array((size_t)s->columns + 1, sizeof(double));
    s->bend = ibl_alloc_zeroed((size_t)env->height + 1, sizeof *s->bend);
    if (!s->cosine || !s->per_row || !s->cos_edge || !s->sin_edge || !s->bend) {
        source_free(s);
        return ibl_no_memory(ctx, "the source's tables");
    }
    for (int j = 0; j <= s->rows; j++)
        s->cosine[j] = cos(PI * j / s->rows);
    for (int j = 0; j < s->rows; j++)
        s->per_row[j] = 1 / (s->cosine[j] - s->cosine[j + 1]);
    for (int k = 0; k <= s->columns; k++) {
        const double phi = 2 * PI * k / s->columns - PI - s->yaw;
        s->cos_edge[k] = cos(phi);
        s->sin_edge[k] = sin(phi);
    }
    if (s->bilinear)
        bend_rows(s);
    return IBL_OK;
}

/* ---- prefix sums ------------------------------------------------------ */

/* Where a fine column or row lies between two of the source: offset of the
 * first, offset of the second, weight of the second. */
struct tap {
    size_t at[2];
    double weight;
};

static struct tap column_tap(const struct source *s, int column)
{
    const int width = s->env->width;
    column = wrap(column, s->columns);
    if (!s->bilinear) {
        const size_t at = 3 * (size_t)(column / s->scale_x);
        return (struct tap){{at, at}, 0};
    }
    const double x = (column + 0.5) / s->scale_x - 0.5;
    const int left = (int)floor(x);
    return (struct tap){
        {3 * (size_t)wrap(left, width), 3 * (size_t)wrap(left + 1, width)},
        x - left};
}

/* A fine row lies between two of the source. Beyond a pole is the row next
 * to it, half a turn away: those columns are taps[1]. */
static void fetch_row(const struct source *s, int row,
                      struct tap (*taps)[COLUMNS_PER_JOB], int count,
                      double (*rgb)[3])
{
    const ibl_image *env = s->env;
    int above;
    const double t = between_rows(s, row, &above);
    const double lower = t + s->bend[above + 1] * t * (1 - t);
    memset(rgb, 0, (size_t)count * sizeof *rgb);
    for (int k = 0; k < 2; k++) {
        int j = above + k;
        const double weight = k ? lower : 1 - lower;
        const bool beyond = j < 0 || j >= env->height;
        const struct tap *tap = taps[beyond];
        if (beyond)
            j = j < 0 ? 0 : env->height - 1;
        const float *p = env->data + 3 * (size_t)j * (size_t)env->width;
        for (int i = 0; i < count; i++) {
            const double w1 = weight * tap[i].weight, w0 = weight - w1;
            const float *left = p + tap[i].at[0], *right = p + tap[i].at[1];
            for (int c = 0; c < 3; c++)
                rgb[i][c] += w0 * (double)left[c] + w1 * (double)right[c];
        }
    }
}

/* The same where every fine pixel has its source pixel's value. */
static void copy_row(const struct source *s, int row, const struct tap *tap,
                     int count, double (*rgb)[3])
{
    const float *p =
        s->env->data + 3 * (size_t)(row / s->scale_y) * (size_t)s->env->width;
    for (int i = 0; i < count; i++) {
        for (int c = 0; c < 3; c++)
            rgb[i][c] = (double)p[tap[i].at[0] + (size_t)c];
    }
}

static void sum_columns(void *arg, int job, int worker)
{
    const struct face_job *f = arg;
    const struct source *s = f->src;
    const struct tile *t = &f->tile;
    const int begin = job * COLUMNS_PER_JOB, left = t->columns - begin;
    const int count = left < COLUMNS_PER_JOB ? left : COLUMNS_PER_JOB;
    struct tap taps[2][COLUMNS_PER_JOB];
    double rgb[COLUMNS_PER_JOB][3];
    sum4 sum[COLUMNS_PER_JOB] = {0};
    sum4 *out = t->prefix + begin;
    (void)worker;

    for (int i = 0; i < count; i++) {
        const int column = t->first + begin + i;
        taps[0][i] = column_tap(s, column);
        taps[1][i] = column_tap(s, column + s->columns / 2);
    }
    memcpy(out, sum, (size_t)count * sizeof *sum);
    for (int j = t->top; j < t->bottom; j++) {
        const double dc = s->cosine[j] - s->cosine[j + 1];
        const int row = t->bottom_up ? s->rows - 1 - j : j;
        if (s->bilinear)
            fetch_row(s, row, taps, count, rgb);
        else
            copy_row(s, row, taps[0], count, rgb);
        for (int i = 0; i < count; i++) {
            for (int c = 0; c < 3; c++)
                sum[i].v[c] += rgb[i][c] * dc;
            sum[i].v[3] += dc;
        }
        out += t->columns;
        memcpy(out, sum, (size_t)count * sizeof *sum);
    }
}

/* ---- walking a line --------------------------------------------------- */

/* Where a line stands: cosine, its slope over phi, and the source row. */
struct point {
    double cosine, slope;
    int row;
};

/* Adds weight * G at the middle of [low, high] in a row of a column. */
static void add_mean(const struct source *s, const struct tile *t, int column,
                     int row, double mid, double weight, sum4 *sum)
{
    const sum4 *above = t->prefix +
                        (size_t)(row - t->top) * (size_t)t->columns +
                        (size_t)column;
    const sum4 *below = above + t->columns;
    const double f = (s->cosine[row] - mid) * s->per_row[row];
    for (int c = 0; c < RGB1; c++)
        sum->v[c] += weight * (above->v[c] + f * (below->v[c] - above->v[c]));
}

/* Adds the integral of G dphi along a piece within one column. The piece is
 * straight but for a bow that makes the mean of its cosine right to fourth
 * order (Hermite's end correction of the trapezium rule). */
static void add_piece(const struct source *s, const struct tile *t, int column,
                      struct point a, struct point b, double dphi, sum4 *sum)
{
    const double bow = (a.slope - b.slope) * dphi / 12;
    if (a.row == b.row) {
        add_mean(s, t, column, a.row, 0.5 * (a.cosine + b.cosine) + bow, dphi,
                 sum);
        return;
    }
    if (a.row > b.row) {
        const struct point swap = a;
        a = b;
        b = swap;
    }
    const double per_cosine = dphi / (a.cosine - b.cosine);
    for (int row = a.row; row <= b.row; row++) {
        const double high = row == a.row ? a.cosine : s->cosine[row];
        const double low = row == b.row ? b.cosine : s->cosine[row + 1];
        add_mean(s, t, column, row, 0.5 * (high + low) + bow,
                 per_cosine * (high - low), sum);
    }
}

/* Moves p to where the angle from the line's foot has cosine q and sine r:
 * there the axis is a / q away. */
static void move_to(const struct source *s, const struct tile *t,
                    const struct line *ln, double q, double r, struct point *p)
{
    const double yq = ln->y * q;
    const double inverse = 1 / sqrt(yq * yq + ln->a * ln->a);
    p->cosine = yq * inverse;
    p->slope = -r * ln->y * ln->a * ln->a * inverse * inverse * inverse;
    while (p->row > t->top && p->cosine > s->cosine[p->row])
        p->row--;
    while (p->row < t->bottom - 1 && p->cosine < s->cosine[p->row + 1])
        p->row++;
}

static void move_to_corner(const struct face_job *f, const struct line *ln,
                           int corner, struct point *p)
{
    const double t = 2.0 * corner / f->n - 1;
    const double inverse = 1 / sqrt(ln->a * ln->a + t * t);
    move_to(f->src, &f->tile, ln, ln->a * inverse, t * inverse, p);
}

static void move_to_edge(const struct face_job *f, const struct line *ln,
                         int column, struct point *p)
{
    const int edge = wrap(column, f->src->columns);
    const double x = f->src->cos_edge[edge], z = f->src->sin_edge[edge];
    move_to(f->src, &f->tile, ln, x * ln->foot_x + z * ln->foot_z,
            z * ln->foot_x - x * ln->foot_z, p);
}

/* A walk starts at the line's own end or at a tile's first column. */
static struct point start_point(const struct face_job *f, const struct line *ln,
                                double begin)
{
    struct point p = {.row = f->tile.top};
    if (begin <= ln->corner[0])
        move_to_corner(f, ln, 0, &p);
    else
        move_to_edge(f, ln, (int)begin, &p);
    return p;
}

/* Walks a line from columns coordinate begin to end, within the tile's
 * columns moved by shift. */
static void walk_part(const struct face_job *f, const struct line *ln,
                      int shift, double begin, double end)
{
    const struct source *s = f->src;
    const int origin = f->tile.first + shift;
    const double dphi = 2 * PI / s->columns;
    int texel = 0, column = (int)floor(begin) - origin;
    struct point at = start_point(f, ln, begin);

    while (texel < f->n - 1 && ln->corner[texel + 1] <= begin)
        texel++;
    for (double x = begin; x < end && texel < f->n;) {
        const double boundary = origin + column + 1;
        const double corner = ln->corner[texel + 1];
        const double next = corner <= boundary ? corner : boundary;
        struct point to = at;
        if (corner <= boundary)
            move_to_corner(f, ln, texel + 1, &to);
        else
            move_to_edge(f, ln, f->tile.first + column + 1, &to);
        if (next > x)
            add_piece(s, &f->tile, column, at, to, (next - x) * dphi,
                      &ln->edge[texel]);
        texel += corner <= boundary;
        column += boundary <= corner;
        x = next;
        at = to;
    }
}

static void walk(const struct face_job *f, const struct line *ln)
{
    const int turn = f->src->columns, first = f->tile.first;
    const double from = ln->corner[0], to = ln->corner[f->n];
    const int last_shift = (int)floor((to - first) / turn);

    for (int k = (int)floor((from - first) / turn); k <= last_shift; k++) {
        const double tile_begin = first + k * turn;
        const double tile_end = tile_begin + f->tile.columns;
        const double begin = from > tile_begin ? from : tile_begin;
        const double end = to < tile_end ? to : tile_end;
        if (begin < end)
            walk_part(f, ln, k * turn, begin, end);
    }
}

static void set_corners(const struct face_job *f, struct line *ln,
                        double *corner)
{
    const double foot = atan2(ln->foot_z, ln->foot_x);
    for (int i = 0; i <= f->n; i++)
        corner[i] =
            column_of(f->src, foot + atan((2.0 * i / f->n - 1) / ln->a));
    ln->corner = corner;
}

static bool is_pole(const ibl_face_axes *axes)
{
    return axes->forward[1] != 0;
}

static int line_count(const struct face_job *f)
{
    return (is_pole(f->axes) ? 2 : 1) * (f->n + 1);
}

static void walk_lines(void *arg, int job, int worker)
{
    const struct face_job *f = arg;
    const int lines = f->n + 1;
    const int begin = job * LINES_PER_JOB;
    const int end = begin + LINES_PER_JOB < line_count(f)
                        ? begin + LINES_PER_JOB
                        : line_count(f);
    double *corners = f->corners + (size_t)worker * (size_t)lines;

    for (int i = begin; i < end; i++) {
        const double at = 2.0 * (i % lines) / f->n - 1;
        struct line ln = {.edge = f->edges + (size_t)i * (size_t)f->n};
        if (!is_pole(f->axes)) {
            ln.y = -at;
            ln.a = 1;
            ln.foot_x = f->axes->forward[0];
            ln.foot_z = f->axes->forward[2];
            if (i == begin)
                set_corners(f, &ln, corners);
        } else {
            const int sign = at > 0 ? 1 : -1;
            if (2 * (i % lines) == f->n) /* through the pole: dphi = 0 */
                continue;
            ln.y = 1;
            ln.a = fabs(at);
            ln.foot_x = i < lines ? 0 : sign;
            ln.foot_z = i < lines ? sign : 0;
            set_corners(f, &ln, corners);
        }
        ln.corner = corners;
        walk(f, &ln);
    }
}

/* ---- texels ----------------------------------------------------------- */

/* Adds sign times the integral along segment i of a line, i counted towards
 * growing x, z or u. Where turned is set the walk ran the other way. */
static void add_segment(const struct face_job *f, int line, int i, bool turned,
                        double sign, sum4 *sum)
{
    const int walked = turned ? f->n - 1 - i : i;
    const sum4 *g = f->edges + (size_t)line * (size_t)f->n + (size_t)walked;
    if (turned)
        sign = -sign;
    for (int c = 0; c < RGB1; c++)
        sum->v[c] += sign * g->v[c];
}

/* Loop integral around texel (x, z) of a pole's face, counted from the -x -z
 * corner. Lines of constant z run towards -x when z > 0, lines of constant x
 * towards -z when x < 0. */
static void pole_loop(const struct face_job *f, int x, int z, sum4 *sum)
{
    const int n = f->n, columns = n + 1;
    add_segment(f, z, x, 2 * z > n, 1, sum);
    add_segment(f, z + 1, x, 2 * (z + 1) > n, -1, sum);
    add_segment(f, columns + x + 1, z, 2 * (x + 1) < n, 1, sum);
    add_segment(f, columns + x, z, 2 * x < n, -1, sum);
}

/* The same for a side: phi grows against u on every side face. */
static void side_loop(const struct face_job *f, int x, int y, sum4 *sum)
{
    add_segment(f, y, x, true, 1, sum);
    add_segment(f, y + 1, x, true, -1, sum);
}

static void finish_row(void *arg, int y, int worker)
{
    const struct face_job *f = arg;
    float *out = f->texels + 3 * (size_t)y * (size_t)f->n;
    const int z = f->axes->down[2] > 0 ? y : f->n - 1 - y;
    (void)worker;

    for (int x = 0; x < f->n; x++) {
        sum4 sum = {0};
        if (is_pole(f->axes))
            pole_loop(f, x, z, &sum);
        else
            side_loop(f, x, y, &sum);
        /* Below a bright pixel G is not 0 and leaves its rounding. */
        for (int c = 0; c < 3; c++)
            out[3 * x + c] = (float)(sum.v[c] > 0 ? sum.v[c] / sum.v[3] : 0);
    }
}

/* ---- one face --------------------------------------------------------- */

/* Rows of the source that the face's lines can meet, with one to spare: a
 * side face reaches 45 degrees from the horizon at most, a pole's corner is
 * atan(sqrt(2)) from it. */
static void set_rows(struct face_job *f)
{
    const int rows = f->src->rows;
    const int quarter = rows / 4 - 1;
    const int corner = (int)ceil(rows * (atan(sqrt(2.0)) / PI)) + 1;
    if (is_pole(f->axes)) {
        f->tile.top = 0;
        f->tile.bottom = corner < rows ? corner : rows;
        f->tile.bottom_up = f->axes->forward[1] < 0;
    } else {
        f->tile.top = quarter > 0 ? quarter : 0;
        f->tile.bottom = rows - f->tile.top;
        f->tile.bottom_up = false;
    }
}

/* Columns of a tile of so many rows; their sums fit in TILE_SUMS. */
static int tile_width(int rows)
{
    const int width = TILE_SUMS / (rows + 1);
    return width < 1 ? 1 : width;
}

/* Columns that the face covers, from the first one. */
static int set_columns(struct face_job *f)
{
    if (is_pole(f->axes)) {
        f->tile.first = 0;
        return f->src->columns;
    }
    const double foot = atan2(f->axes->forward[2], f->axes->forward[0]);
    f->tile.first = (int)floor(column_of(f->src, foot - PI / 4));
    return (int)ceil(column_of(f->src, foot + PI / 4)) - f->tile.first;
}

/* f has its buffers: edges for a pole's face, a tile's prefix sums. */
static ibl_status filter_face(ibl_ctx *ctx, struct face_job *f)
{
    const size_t edges = (size_t)line_count(f) * (size_t)f->n;
    ibl_status status = IBL_OK;

    set_rows(f);
    const int columns = set_columns(f), first = f->tile.first;
    const int width = tile_width(f->tile.bottom - f->tile.top);
    memset(f->edges, 0, edges * sizeof *f->edges);
    for (int done = 0; done < columns && !status; done += width) {
        const int left = columns - done;
        f->tile.first = first + done;
        f->tile.columns = width < left ? width : left;
        status = ibl_run(ctx, NULL, ceil_div(f->tile.columns, COLUMNS_PER_JOB),
                         sum_columns, f);
        if (!status)
            status = ibl_run(ctx, NULL, ceil_div(line_count(f), LINES_PER_JOB),
                             walk_lines, f);
    }
    if (!status)
        status = ibl_run(ctx, NULL, f->n, finish_row, f);
    return status;
}

static ibl_status convert(ibl_ctx *ctx, const ibl_image *env, double yaw_deg,
                          const ibl_cube *cube)
{
    const size_t n = (size_t)cube->size;
    struct source src = {0};
    struct face_job f = {.src = &src, .n = cube->size};
    ibl_status status;

    status = source_init(ctx, env, yaw_deg, cube->size, &src);
    if (status)
        return status;
    const size_t sums = src.rows < TILE_SUMS ? TILE_SUMS : src.rows + 1u;
    f.tile.prefix = ibl_alloc_array(sums, sizeof *f.tile.prefix);
    f.edges = ibl_alloc_array(2 * (n + 1) * n, sizeof *f.edges);
    f.corners = ibl_alloc_array((size_t)ibl_ctx_threads(ctx) * (n + 1),
                                sizeof *f.corners);
    if (!f.tile.prefix || !f.edges || !f.corners)
        status = ibl_no_memory(ctx, "level 0");
    for (int face = 0; face < IBL_FACES && !status; face++) {
        ibl_progress(ctx, "level 0", face / (double)IBL_FACES);
        f.axes = &ibl_face[face];
        f.texels = ibl_cube_face(cube, 0, face);
        status = filter_face(ctx, &f);
    }
    if (!status)
        ibl_progress(ctx, "level 0", 1);
    ibl_free(f.corners);
    ibl_free(f.edges);
    ibl_free(f.tile.prefix);
    source_free(&src);
    return status;
}

/* ---- rows ------------------------------------------------------------- */

struct ibl_level0 {
    ibl_ctx *ctx;
    ibl_cube *cube;
    double yaw_deg;
    int added;
    ibl_image env;
};

ibl_status ibl_level0_create(ibl_ctx *ctx, int width, int height,
                             double yaw_deg, ibl_cube *cube, ibl_level0 **out)
{
    *out = NULL;
    if (!isfinite(yaw_deg))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT, "the yaw must be finite");
    ibl_level0 *l = ibl_alloc_zeroed(1, sizeof *l);
    if (!l)
        return ibl_no_memory(ctx, "level 0");
    *l = (ibl_level0){.ctx = ctx, .cube = cube, .yaw_deg = yaw_deg};
    const ibl_status status = ibl_image_alloc(ctx, width, height, &l->env);
    if (status) {
        ibl_level0_free(l);
        return status;
    }
    *out = l;
    return IBL_OK;
}

ibl_status ibl_level0_add(ibl_level0 *l, int rows, const float *rgb)
{
    const size_t row = 3 * (size_t)l->env.width;
    assert(rows >= 0 && rows <= l->env.height - l->added);
    memcpy(l->env.data + (size_t)l->added * row, rgb,
           (size_t)rows * row * sizeof *rgb);
    l->added += rows;
    return IBL_OK;
}

ibl_status ibl_level0_finish(ibl_level0 *l)
{
    assert(l->added == l->env.height);
    return convert(l->ctx, &l->env, l->yaw_deg, l->cube);
}

void ibl_level0_free(ibl_level0 *l)
{
    if (!l)
        return;
    ibl_image_free(&l->env);
    ibl_free(l);
}

ibl_status ibl_cube_from_latlong(ibl_ctx *ctx, const ibl_image *env,
                                 double yaw_deg, ibl_cube *cube)
{
    ibl_level0 *l;
    ibl_status status =
        ibl_level0_create(ctx, env->width, env->height, yaw_deg, cube, &l);
    if (status)
        return status;
    status = ibl_level0_add(l, env->height, env->data);
    if (!status)
        status = ibl_level0_finish(l);
    ibl_level0_free(l);
    return status;
}

/* SPDX-License-Identifier: MIT */
#include "cli/judge_picks.h"

#include <math.h>
#include <stdlib.h>

#include "cli/faces.h"

enum {
    BLOCKS = 32 /* of the map, along a row, of which each has one brightest
                   pixel; half as many along a column */
};

typedef enum kind {
    LIGHT,
    CORNER,
    NEAR,
    EDGE,
    DARK,
    REST,
    KINDS
} kind;

double ibl_pick_random(int seed, unsigned long long stream,
                       unsigned long long index)
{
    /* splitmix64, Steele et al. 2014. */
    unsigned long long x = (unsigned long long)seed * 0xD1B54A32D192ED03u +
                           stream * 0x8CB92BA72F3D8DD7u +
                           (index + 1) * 0x9E3779B97F4A7C15u;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
    x ^= x >> 31;
    return (double)(x >> 11) / 9007199254740992.0;
}

/* ---- the brightest pixels -------------------------------------------- */

typedef struct pixel {
    float value; /* R + G + B */
    int x, y;
} pixel;

static float value_of(const ibl_image *env, int x, int y)
{
    const float *p =
        env->data + 3 * ((size_t)y * (size_t)env->width + (size_t)x);
    return p[0] + p[1] + p[2];
}

/* The convention of ibl/ibl.h, then the turn about +Y. */
static void pixel_direction(const ibl_image *env, double yaw_deg, pixel at,
                            double dir[3])
{
    const double phi =
        ((at.x + 0.5) / env->width - 0.5) * 2 * M_PI - yaw_deg * M_PI / 180;
    const double theta = M_PI * (at.y + 0.5) / env->height;
    dir[0] = sin(theta) * cos(phi);
    dir[1] = cos(theta);
    dir[2] = sin(theta) * sin(phi);
}

static pixel brightest(const ibl_image *env, int block)
{
    const int columns = env->width < BLOCKS ? env->width : BLOCKS;
    const int rows = env->height < BLOCKS / 2 ? env->height : BLOCKS / 2;
    const long long i = block % columns, j = block / columns;
    pixel best = {-1, 0, 0};

    if (j >= rows)
        return best;
    for (int y = (int)(j * env->height / rows);
         y < (int)((j + 1) * env->height / rows); y++)
        for (int x = (int)(i * env->width / columns);
             x < (int)((i + 1) * env->width / columns); x++)
            if (value_of(env, x, y) > best.value)
                best = (pixel){value_of(env, x, y), x, y};
    return best;
}

static bool is_far(const double dir[3], double dirs[][3], int count)
{
    for (int i = 0; i < count; i++)
        if (dir[0] * dirs[i][0] + dir[1] * dirs[i][1] + dir[2] * dirs[i][2] >
            cos(10 * M_PI / 180))
            return false;
    return true;
}

int ibl_find_lights(const ibl_image *env, double yaw_deg, int most,
                    double dirs[][3])
{
    pixel blocks[BLOCKS * BLOCKS / 2];
    int count = 0;

    for (int b = 0; b < BLOCKS * BLOCKS / 2; b++)
        blocks[b] = brightest(env, b);
    while (count < most) {
        pixel *best = NULL;
        double dir[3];
        for (int b = 0; b < BLOCKS * BLOCKS / 2; b++)
            if (blocks[b].value >= 0 &&
                (!best || blocks[b].value > best->value))
                best = &blocks[b];
        if (!best)
            break;
        pixel_direction(env, yaw_deg, *best, dir);
        best->value = -1;
        if (!is_far(dir, dirs, count))
            continue;
        for (int k = 0; k < 3; k++)
            dirs[count][k] = dir[k];
        count++;
    }
    return count;
}

/* ---- kinds ----------------------------------------------------------- */

typedef struct picker {
    const ibl_pick_scene *scene;
    const ibl_judge_options *opts;
    int n;    /* size */
    int grid; /* cells along an edge for REST */
    int light_count;
    ibl_texel lights[IBL_JUDGE_LIGHTS];
    size_t members[KINDS]; /* texels of the level */
    size_t quota[KINDS];   /* to be chosen; not of REST */
    size_t *cells;         /* members of REST in each cell */
    size_t *wanted;        /* index among them of the one that is chosen */
} picker;

static size_t cell_of(const picker *p, ibl_texel t, int grid)
{
    const long long i = t.x, j = t.y;
    const size_t x = (size_t)(i * grid / p->n), y = (size_t)(j * grid / p->n);
    return ((size_t)t.face * (size_t)grid + y) * (size_t)grid + x;
}

static bool is_near(const picker *p, ibl_texel t)
{
    const double *l = p->scene->lights[0];
    double d[3];

    ibl_face_direction(t.face, 2 * (t.x + 0.5) / p->n - 1,
                       2 * (t.y + 0.5) / p->n - 1, d);
    const double dot = d[0] * l[0] + d[1] * l[1] + d[2] * l[2];
    const double length2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    const double limit = cos(20 * M_PI / 180);
    return dot > 0 && dot * dot > limit * limit * length2;
}

static kind kind_of(const picker *p, ibl_texel t)
{
    const bool x_edge = t.x == 0 || t.x == p->n - 1;
    const bool y_edge = t.y == 0 || t.y == p->n - 1;

    for (int i = 0; i < p->light_count; i++)
        if (t.face == p->lights[i].face && abs(t.x - p->lights[i].x) <= 1 &&
            abs(t.y - p->lights[i].y) <= 1)
            return LIGHT;
    if (x_edge && y_edge)
        return CORNER;
    if (is_near(p, t))
        return NEAR;
    if (x_edge || y_edge)
        return EDGE;
    return p->scene->dark[cell_of(p, t, IBL_DARK_CELLS)] ? DARK : REST;
}

/* ---- the choice ------------------------------------------------------ */

static void visit_all(picker *p, void (*visit)(picker *, ibl_texel, void *),
                      void *cookie)
{
    ibl_texel t;
    for (t.face = 0; t.face < IBL_FACES; t.face++)
        for (t.y = 0; t.y < p->n; t.y++)
            for (t.x = 0; t.x < p->n; t.x++)
                visit(p, t, cookie);
}

static void count_member(picker *p, ibl_texel t, void *cookie)
{
    const kind k = kind_of(p, t);

    (void)cookie;
    p->members[k]++;
    if (k == REST)
        p->cells[cell_of(p, t, p->grid)]++;
}

typedef struct chosen {
    ibl_judged_texel *list;
    size_t count;
    size_t seen[KINDS], taken[KINDS];
} chosen;

/* The member of a kind that is chosen as number i of quota: a random one in
 * the i-th of as many equal stretches. */
static size_t member(const picker *p, kind k, size_t i)
{
    const double stretch = (double)p->members[k] / (double)p->quota[k];
    const double at =
        ((double)i + ibl_pick_random(p->opts->seed, k, i)) * stretch;
    const size_t first = (size_t)ceil((double)i * stretch);
    const size_t index = (size_t)at;
    return index < first ? first : index;
}

static void choose_member(picker *p, ibl_texel t, void *cookie)
{
    chosen *c = cookie;
    const kind k = kind_of(p, t);
    double weight = 1;

    if (k == REST) {
        const size_t cell = cell_of(p, t, p->grid);
        if (p->wanted[cell]-- != 0)
            return;
        weight = (double)p->cells[cell];
    } else if (k != LIGHT && k != CORNER && p->members[k] > p->quota[k]) {
        if (c->taken[k] == p->quota[k] ||
            c->seen[k]++ != member(p, k, c->taken[k]))
            return;
        c->taken[k]++;
        weight = (double)p->members[k] / (double)p->quota[k];
    }
    c->list[c->count++] = (ibl_judged_texel){.at = t, .weight = weight};
}

static void choose_all(picker *p, ibl_texel t, void *cookie)
{
    chosen *c = cookie;
    (void)p;
    c->list[c->count++] = (ibl_judged_texel){.at = t, .weight = 1};
}

static bool take_everything(picker *p, ibl_judged_texel **list, size_t *count)
{
    chosen c = {0};
    const size_t texels = IBL_FACES * (size_t)p->n * (size_t)p->n;

    c.list = malloc(texels * sizeof *c.list);
    if (!c.list)
        return false;
    visit_all(p, choose_all, &c);
    *list = c.list;
    *count = c.count;
    return true;
}

static void set_quotas(picker *p)
{
    const int texels = p->opts->texels;
    const int lights = texels / 36;
    const int known = p->scene->light_count;

    p->light_count = lights < 1 ? 1 : lights < known ? lights : known;
    for (int i = 0; i < p->light_count; i++)
        p->lights[i] = ibl_face_texel(p->n, p->scene->lights[i]);
    p->quota[NEAR] = p->quota[EDGE] = p->quota[DARK] = (size_t)texels / 8;
    const double rest = fmax(6, texels - 9.0 * p->light_count - 24 -
                                    3.0 * (double)p->quota[DARK]);
    p->grid = (int)sqrt(rest / 6 + 0.5);
    if (p->grid < p->opts->grid)
        p->grid = p->opts->grid;
    if (p->grid > p->n)
        p->grid = p->n;
}

bool ibl_picks(const ibl_pick_scene *scene, const ibl_judge_options *opts,
               ibl_judged_texel **list, size_t *count)
{
    picker p = {.scene = scene, .opts = opts, .n = scene->size};
    chosen c = {0};
    const size_t texels = IBL_FACES * (size_t)p.n * (size_t)p.n;

    if (opts->all || texels <= (size_t)opts->texels)
        return take_everything(&p, list, count);
    set_quotas(&p);
    const size_t cells = IBL_FACES * (size_t)p.grid * (size_t)p.grid;
    if (texels <= cells)
        return take_everything(&p, list, count);
    p.cells = calloc(cells, sizeof *p.cells);
    p.wanted = calloc(cells, sizeof *p.wanted);
    c.list =
        malloc((9 * (size_t)p.light_count + 24 + 3 * p.quota[DARK] + cells) *
               sizeof *c.list);
    if (p.cells && p.wanted && c.list) {
        visit_all(&p, count_member, NULL);
        for (size_t i = 0; i < cells; i++)
            p.wanted[i] = (size_t)(ibl_pick_random(opts->seed, KINDS, i) *
                                   (double)p.cells[i]);
        visit_all(&p, choose_member, &c);
        *list = c.list;
        *count = c.count;
        c.list = NULL;
    }
    const bool ok = !c.list && p.cells && p.wanted;
    free(c.list);
    free(p.cells);
    free(p.wanted);
    return ok;
}
